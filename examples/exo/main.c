// Runs the joint in QEMU with a controller that is common in exoskeletons, command plus P without I: first without the
// compensation, then with it.

#include "../sim/arm.h"
#include "joint.h"

#include <math.h>
#include <stdio.h>

#define KP     2.0f
#define PERIOD 5000u // ticks

static float run(bool compensated)
{
    arm_t arm    = {0};
    float square = 0.0f;
    for (unsigned tick = 0; tick < 2 * PERIOD; tick++)
    {
        const float command    = arm_reference_n(tick, PERIOD);
        const float controller = command + KP * (command - arm.reading_n);
        const float error      = command - arm.force_n;
        square += tick < PERIOD ? 0.0f : error * error;
        arm_step(&arm, ARM_500HZ, compensated ? joint_step(command, arm.reading_n, controller) : controller);
    }
    return 1e6f * sqrtf(square / (float)PERIOD);
}

int main(void)
{
    if (!joint_start())
    {
        return 1;
    }
    printf("without: RMS error %d uN m\n", (int)run(false));
    printf("RMS error %d uN m\n", (int)run(true));
    return 0;
}
