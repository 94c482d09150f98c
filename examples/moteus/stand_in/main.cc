// Runs hold() of force.cc against the stand-in: with the triangle, with a fault, with a drive that does not answer, and with
// a sensor without readings.

#define FORCE_NO_MAIN
#include "../force.cc"

#include <cstdio>

#define PERIOD 5000u // ticks

/// Returns true if hold() throws in the tick `last` at the latest, of a failure after ten ticks, and leaves the drive
/// stopped.
static bool stops_and_throws(bool mjbots::moteus::Controller::*with, int last)
{
    moteus::Controller controller(options());
    int                ticks = 0;
    try
    {
        hold(controller, [] { return 0.5; }, [&] { controller.*with = ++ticks >= 10; });
    } catch (const std::runtime_error &)
    {
        return ticks <= last && controller.mode == moteus::Mode::kStopped;
    }
    return false;
}

int main()
{
    moteus::Controller controller(options());
    unsigned           tick   = 0;
    double             square = 0;
    const auto         next   = [&] {
        const double reference = tick < 2 * PERIOD ? arm_reference_n(tick, PERIOD) : std::nan("");
        const double error     = reference - controller.arm.force_n;
        square += tick < PERIOD || std::isnan(error) ? 0 : error * error;
        tick++;
        return reference;
    };
    hold(controller, next, [] {});
    std::printf("RMS error %.0f uN\n", 1e6 * std::sqrt(square / PERIOD));
    using moteus::Controller;
    return stops_and_throws(&Controller::faulty, 11) && stops_and_throws(&Controller::silent, 11) &&
                   stops_and_throws(&Controller::blind, 30)
               ? 0
               : 1;
}
