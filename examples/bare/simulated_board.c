// A board for QEMU: it simulates the examples' arm and prints the result over semihosting. Replace it with your board.

#include "../sim/arm.h"
#include "board.h"

#define PERIOD 10000u // ticks
#define END    (2u * PERIOD)
#ifndef SENSOR_DIES_AT
#define SENSOR_DIES_AT END
#endif

static arm_t    arm;
static unsigned tick, missing; // missing: consecutive readings that failed
static float    square_mn2;    // sum over the last period
static bool     off;

#ifdef BOARD_Q31
#define FULL_SCALE_N  4.0f // RIG_FULL_SCALE_N
#define TO_BOARD(n)   ((board_force_t)((n) * (2147483648.0f / FULL_SCALE_N)))
#define FROM_BOARD(u) ((float)(u) * (FULL_SCALE_N / 2147483648.0f))
#else
#define TO_BOARD(n)   (n)
#define FROM_BOARD(u) (u)
#endif

static uint32_t semihost(uint32_t operation, const void *argument)
{
    register uint32_t    r0 __asm("r0") = operation;
    register const void *r1 __asm("r1") = argument;
    __asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

/// Prints "RMS error 123 uN" for the last period and ends the program. The exit status is 1 if the board is off.
static void end(void)
{
    char     text[] = "RMS error 00000 uN\n";
    unsigned rms_un = 0;
    while ((float)rms_un * (float)rms_un * 1e-6f < square_mn2 / (float)PERIOD)
    {
        rms_un++;
    }
    for (char *digit = text + 14; digit > text + 9; digit--, rms_un /= 10u)
    {
        *digit = (char)('0' + rms_un % 10u);
    }
    (void)semihost(4, text);
    const uint32_t status[] = {0x20026u, off};
    (void)semihost(0x20, status);
}

board_force_t board_reference(void)
{
    return TO_BOARD(arm_reference_n(tick, PERIOD));
}

board_force_t board_force(void)
{
    if (tick >= SENSOR_DIES_AT)
    {
        missing++;
        return BOARD_NO_FORCE;
    }
    missing = 0;
    return TO_BOARD(arm.reading_n);
}

void board_command(board_force_t u)
{
    const float error_mn = 1e3f * (arm_reference_n(tick, PERIOD) - arm.force_n);
    square_mn2 += tick < END - PERIOD ? 0.0f : error_mn * error_mn;
    arm_step(&arm, ARM_1KHZ, off ? 0.0f : FROM_BOARD(u));
    if (++tick == END)
    {
        end();
    }
}

void board_off(void)
{
    if (!off)
    {
        (void)semihost(4, "off\n");
    }
    off = true;
}

bool board_is_healthy(void)
{
    return missing < 20u;
}
