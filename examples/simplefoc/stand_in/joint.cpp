// Runs the sketch of joint/ on a host: loop() ten times per tick, with the motor driving the examples' joint.
// ./joint [off | stall | reversed | blind]: off disables the friction term, stall stops the loop for two ticks, reversed
// exchanges the motor's phases or the encoder, blind has no angle for a second.

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
    double       most   = 0; // current from 0.1 s after the last angle
    setup();
    if (strcmp(word, "off") == 0)
    {
        (void)tribo_joint_f32_gain(&joint, 0.0f);
    }
    for (unsigned t = 0; t < TICKS; t++)
    {
        motor.target                = (float)(0.25 * TURN * sin(PI * 0.001 * t));
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
        const double error = motor.target - TURN * hinge.angle;
        square += t < TICKS / 2 ? 0 : error * error;
        hinge_step(&hinge, 0.001, sign * flowing / AMPERE_PER_N_M);
    }
    tribo_joint_report_t report;
    tribo_joint_f32_report(&joint, &report);
    printf("RMS error %.0f urad, enabled %d, friction %.0f mA, share %.2f, %s, %.0f uA without an angle\n",
           1e6 * sqrt(square / (TICKS / 2)),
           motor.enabled,
           1e3 * report.friction,
           report.share,
           tribo_joint_cause_text(report.cause),
           1e6 * most);
    return 0;
}
