// Runs the sketch of joint/ on a host: loop() ten times per tick, with the motor driving the examples' joint.
// ./joint [off | stall | reversed | blind | hand | away]: off disables the friction term, stall stops the loop for two ticks,
// reversed exchanges the motor's phases or the encoder, blind has no angle for a second. With hand the motor is disabled for
// three swings that a hand makes in its place; with away the joint begins far from angle 0.

#include "../joint/joint.ino"
#include "../../sim/hinge.h"

#include <stdio.h>
#include <string.h>

#define PI             3.14159265
#define TURN           (2 * PI)
#define AMPERE_PER_N_M 4.0
#define TICKS          12000u

static hinge_t hinge;
static float   flowing;
static bool    is_blind;
static void (*timer)();

void FOCMotor::flows(float ampere)
{
    flowing = ampere;
}

void FOCMotor::sense()
{
    if (is_blind)
    {
        shaft_angle = NAN;
        return;
    }
    const float angle = (float)(TURN * hinge_reading(&hinge, 16384.0));
    shaft_angle       = isnan(shaft_angle) ? angle : shaft_angle;
    shaft_velocity += 0.2f * (1000.0f * (angle - shaft_angle) - shaft_velocity); // LPF_velocity of 5 ms
    shaft_angle = angle;
}

void start_timer(void (*tick)(), int)
{
    timer = tick;
}

int main(int count, char **words)
{
    const char  *word   = count > 1 ? words[1] : "";
    const double sign   = strcmp(word, "reversed") == 0 ? -1.0 : 1.0;
    double       square = 0;
    const bool   hand   = strcmp(word, "hand") == 0;
    double       most   = 0; // current from 0.1 s after the last angle
    double       first  = 0; // of the first 10 ms
    hinge.angle         = strcmp(word, "away") == 0 ? 3.0 : 0.0;
    setup();
    const float begin = motor.target;
    if (strcmp(word, "off") == 0)
    {
        (void)tribo_joint_f32_gain(&joint, 0.0f);
    }
    for (unsigned t = 0; t < TICKS; t++)
    {
        motor.target                = begin + (float)(0.25 * TURN * sin(PI * 0.001 * t));
        motor.feed_forward_velocity = (float)(0.25 * TURN * PI * cos(PI * 0.001 * t));
        is_blind                    = strcmp(word, "blind") == 0 && t >= 5000 && t < 6000;
        timer();
        for (int i = 0; i < 10; i++)
        {
            if (strcmp(word, "stall") != 0 || t != 5000)
            {
                loop();
            }
        }
        most               = is_blind && t >= 5100 ? fmax(most, fabs(flowing)) : most;
        first              = t < 10 ? fmax(first, fabs(flowing)) : first;
        const double error = motor.target - TURN * hinge.angle;
        square += t < TICKS / 2 ? 0 : error * error;
        if (hand && t == 6000)
        {
            motor.disable();
        }
        const bool led = hand && !motor.enabled;
        hinge_step(&hinge, 0.001, led ? 20.0 * error / TURN : sign * flowing / AMPERE_PER_N_M);
    }
    tribo_joint_report_t report;
    tribo_joint_f32_report(&joint, &report);
    printf(
        "RMS error %.0f urad, enabled %d, friction %.0f mA, share %.2f, %s, %.0f uA without an angle, first %.0f mA\n",
        1e6 * sqrt(square / (TICKS / 2)),
        motor.enabled,
        1e3 * report.friction,
        report.share,
        tribo_joint_cause_text(report.cause),
        1e6 * most,
        1e3 * first);
    return 0;
}
