// Runs the sketch on a host: loop() ten times per tick, with the motor driving the examples' arm. ./sketch [STALL]: with
// STALL the loop stops for two ticks.

#include "../../sim/arm.h"
#include "../simplefoc.ino"

#include <math.h>
#include <stdio.h>

#define PERIOD 10000u // ticks

static arm_t arm;
static float flowing;
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
    return arm.reading_n;
}

void start_timer(void (*tick)(), int)
{
    timer = tick;
}

int main(int count, char **)
{
    double square = 0;
    setup();
    for (unsigned tick = 0; tick < 2 * PERIOD; tick++)
    {
        reference_n = arm_reference_n(tick, PERIOD);
        timer();
        for (int i = 0; i < 10; i++)
        {
            if (count == 1 || tick != 5000)
            {
                loop();
            }
        }
        const double error = reference_n - arm.force_n;
        square += tick < PERIOD ? 0 : error * error;
        arm_step(&arm, ARM_1KHZ, flowing / AMPERE_PER_N);
    }
    printf("RMS error %.0f uN, enabled %d\n", 1e6 * sqrt(square / PERIOD), motor.enabled);
    return 0;
}
