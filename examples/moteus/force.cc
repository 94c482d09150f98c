// The loop of force.py in C++, over mjbots' client (moteus.h). ./force holds 0.5 N m until a fault.

#include "moteus.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

namespace moteus = mjbots::moteus;

static const double kWatchdogS = 0.02;
static const double kMaxTorque = 2.0;              // N m
static const int    kBadMax    = 20;               // bad readings in succession, 40 ms
static const double kOffset = 0.5, kNmPerUnit = 4; // torque sensor on aux1 pin 1

// [add
#include "rig_500hz_f32.h"

static tribo_force_loop_f32_state_t   loop;
static tribo_feedforward_f32_memory_t memory;

static void start()
{
    loop.memory = &memory.state.tick;
    (void)tribo_force_loop_f32_start(&loop, &rig_params, true); // keeps the learned values
}

static double torque_for(double reference, double reading, int *bad)
{
    const uint32_t before = loop.bad_inputs;
    const float    u =
        tribo_force_loop_f32_step(&rig_params, &loop, static_cast<float>(reference), static_cast<float>(reading), NULL);
    tribo_feedforward_f32_learn(&rig_params, &memory);
    *bad = loop.bad_inputs != before ? *bad + 1 : 0;
    return u;
}
// add]

static moteus::Controller::Options options()
{
    moteus::Controller::Options result;
    result.id                                    = 1;
    result.position_format.position              = moteus::kFloat;
    result.position_format.feedforward_torque    = moteus::kFloat;
    result.position_format.kp_scale              = moteus::kFloat;
    result.position_format.kd_scale              = moteus::kFloat;
    result.position_format.maximum_torque        = moteus::kFloat;
    result.position_format.watchdog_timeout      = moteus::kFloat;
    result.query_format.extra[0].register_number = moteus::Register::kAux1AnalogIn1;
    result.query_format.extra[0].resolution      = moteus::kFloat;
    return result;
}

/// Sends one reference per period from `next` until it returns NaN. Then, or at any fault, it stops the drive.
template <typename Next, typename Pause> void hold(moteus::Controller &controller, Next next, Pause pause)
{
    start();
    controller.SetStop();
    auto state = controller.SetQuery();
    int  bad   = 0;
    for (double reference = next(); state && !std::isnan(reference); reference = next())
    {
        moteus::PositionMode::Command command;
        command.position           = std::nan("");
        command.kp_scale           = 0;
        command.kd_scale           = 0;
        command.feedforward_torque = torque_for(reference, (state->values.extra[0].value - kOffset) * kNmPerUnit, &bad);
        command.maximum_torque     = kMaxTorque;
        command.watchdog_timeout   = kWatchdogS;
        state                      = controller.SetPosition(command);
        const bool has_left        = state && state->values.mode != moteus::Mode::kPosition;
        if (has_left || bad == kBadMax)
        {
            controller.SetStop();
            throw std::runtime_error(has_left ? "the moteus has left position mode" : "20 bad readings in succession");
        }
        pause();
    }
    controller.SetStop();
    if (!state)
    {
        throw std::runtime_error("no answer from the moteus");
    }
}

#ifndef FORCE_NO_MAIN
int main()
{
    moteus::Controller controller(options());
    auto               due   = std::chrono::steady_clock::now();
    const auto         pause = [&] {
        due = std::max(due + std::chrono::milliseconds(2),
                       std::chrono::steady_clock::now()); // does not catch up after a late tick
        std::this_thread::sleep_until(due);
    };
    hold(controller, [] { return 0.5; }, pause);
}
#endif
