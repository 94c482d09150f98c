// What the README's example leaves to its reader: an arm with friction, and a main that runs the benchmark's
// triangle on it. The plant is simpler than the simulation's, and its breakaway 20 % above what the example believes.

#include "tribo/status.h"

#include <math.h>
#include <stdio.h>

float          read_force_n(void);
void           command_force_n(float u);
tribo_status_t force_control_start(void);
void           force_control_tick(float reference_n);

#define PERIOD 20000 // ticks of 1 ms

static double actuator_n, force_n, reading_n;

float read_force_n(void)
{
    return (float)reading_n;
}

/// A pole at 200 rad/s, the arm with b/K = 7.5 ms between breakaway and breakaway, the sensor's pole at 55 rad/s.
void command_force_n(float u)
{
    const double breakaway = 1.2 * (0.007 + 0.3 * fabs(force_n));
    actuator_n += 0.181 * ((double)u - actuator_n);
    const double held = fmin(actuator_n + breakaway, fmax(actuator_n - breakaway, force_n));
    force_n += 0.125 * (held - force_n);
    reading_n += 0.0535 * (force_n - reading_n);
}

int main(void)
{
    if (force_control_start() != TRIBO_OK)
    {
        return 1;
    }
    double sum = 0.0;
    for (long tick = 0; tick < 3 * PERIOD; tick++)
    {
        const double phase     = (double)(tick % PERIOD) / PERIOD;
        const double reference = 0.4 + 0.4 * (phase < 0.5 ? phase : 1.0 - phase);
        sum += tick < 2 * PERIOD ? 0.0 : (reference - force_n) * (reference - force_n);
        force_control_tick((float)reference);
    }
    const double rms = sqrt(sum / PERIOD);
    printf("triangle, third period: RMS error %.3f mN\n", 1e3 * rms);
    return rms < 0.3e-3 ? 0 : 1; // 1.41 mN where friction is not known, and so not fed forward
}
