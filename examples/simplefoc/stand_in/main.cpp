// Runs the sketch on a host: loop() ten times per tick, with the motor driving the examples' arm.
// ./sketch [stall | glitch | blind | stubborn]: stall stops the loop for two ticks; the sensor has no reading for 19 ticks with
// glitch, for a second with blind and with stubborn, where a user enables the motor again and again meanwhile.

#include "../../sim/arm.h"
#include "../simplefoc.ino"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PERIOD 10000u // ticks
#define FAILS  5000u

static arm_t arm;
static float flowing;
static bool  is_blind;
static void (*timer)();

void FOCMotor::flows(float ampere)
{
    flowing = ampere;
}

void FOCMotor::sense()
{
}

float read_force_n()
{
    return is_blind ? NAN : arm.reading_n;
}

void start_timer(void (*tick)(), int)
{
    timer = tick;
}

int main(int count, char **words)
{
    const char    *word   = count > 1 ? words[1] : "";
    const bool     again  = strcmp(word, "stubborn") == 0;
    const unsigned blind  = again || strcmp(word, "blind") == 0 ? 1000 : strcmp(word, "glitch") == 0 ? 19 : 0;
    double         square = 0;
    unsigned       off    = 0; // ticks until no current flows
    unsigned       on     = 0; // ticks with a current after 19 bad readings
    setup();
    for (unsigned tick = 0; tick < 2 * PERIOD; tick++)
    {
        reference_n = arm_reference_n(tick, PERIOD);
        is_blind    = tick >= FAILS && tick < FAILS + blind;
        timer();
        for (int i = 0; i < 10; i++)
        {
            if (strcmp(word, "stall") != 0 || tick != FAILS)
            {
                loop();
            }
        }
        const double error = reference_n - arm.force_n;
        square += tick < PERIOD ? 0 : error * error;
        arm_step(&arm, ARM_1KHZ, flowing / AMPERE_PER_N);
        on += is_blind && tick >= FAILS + 19 && flowing != 0.0f;
        if (flowing == 0.0f && tick > FAILS && off == 0)
        {
            off = tick - FAILS;
        }
        if (again && is_blind && !motor.enabled)
        {
            motor.enable();
        }
    }
    printf("RMS error %.0f uN, enabled %d, off after %u, on for %u\n",
           1e6 * sqrt(square / PERIOD),
           motor.enabled,
           off,
           on);
    return 0;
}
