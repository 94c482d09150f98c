// The drive on the STM32F405: self-test, then ticks in TIM2's interrupt, and in the background the log and commands over
// USART1 (app/command.h), with 10 mN for a step of the reference.

#include "app/command.h"
#include "app/drive.h"
#include "app/selftest.h"
#include "board.h"
#include "convert.h"
#include "device.h"
#ifdef DRIVE_ARITH_Q31
#include "rig_q31.h"
#else
#include "rig_f32.h"
#endif

static drive_t          drive;
static volatile int32_t reference; ///< Q31 of the full scale

#define REFERENCE_STEP ((int32_t)(0.01f / CONVERT_FULL_SCALE_N * 2147483648.0f)) // 10 mN
#define REFERENCE_MAX  (100 * REFERENCE_STEP)                                    // 1 N

static const drive_config_t config = {.period_us = BOARD_TICK_US, .late_us = 50, .budget_us = 250, .stuck_ticks = 200};

void board_tick(void)
{
    drive_tick(&drive, loop_from_q31(reference, CONVERT_FULL_SCALE_N));
}

extern uint32_t data_start[];

/// Whether the rig's params are made for the tick and the converters of this board.
static drive_fault_t check_params(void)
{
    bool ok = RIG_SAMPLE_TIME_S == (float)BOARD_TICK_US / 1e6f && convert_suits(&rig_params);
#ifdef DRIVE_ARITH_Q31
    ok = ok && RIG_FULL_SCALE_N == CONVERT_FULL_SCALE_N;
#endif
    return ok ? DRIVE_FAULT_NONE : DRIVE_FAULT_PARAMS;
}

static void execute(command_t command)
{
    switch (command)
    {
    case COMMAND_NONE:
        break;
    case COMMAND_STOP:
        drive_stop(&drive);
        break;
    case COMMAND_START:
        drive_start(&drive);
        break;
    case COMMAND_ACKNOWLEDGE:
        drive_acknowledge(&drive);
        break;
    case COMMAND_REPORT:
        drive_report(&drive);
        break;
    case COMMAND_UP:
        reference = reference < REFERENCE_MAX ? reference + REFERENCE_STEP : REFERENCE_MAX;
        break;
    case COMMAND_DOWN:
        reference = reference > -REFERENCE_MAX ? reference - REFERENCE_STEP : -REFERENCE_MAX;
        break;
    }
}

static void read_command(void)
{
    static command_reader_t reader;
    const int               byte = board_read_byte();
    if (byte >= 0)
    {
        execute(command_take(&reader, (uint8_t)byte));
    }
    else if (byte != BOARD_NO_BYTE)
    {
        command_spoil(&reader);
        execute(byte == BOARD_OVERRUN ? COMMAND_STOP : COMMAND_NONE); // a lost byte may have been an x
    }
}

/// Called by the background, which kicks the watchdog only if there was a tick since: it monitors both.
static void kick(void)
{
    static uint32_t kicked_at;
    const uint32_t  ticks = *(volatile uint32_t *)&drive.ticks;
    if (ticks != kicked_at)
    {
        kicked_at = ticks;
        board_kick();
    }
}

int main(void)
{
    static const char *const clocks[] = {[BOARD_CLOCK_HSE]  = "168 MHz from HSE\n",
                                         [BOARD_CLOCK_HSI]  = "168 MHz from HSI, no HSE\n",
                                         [BOARD_CLOCK_SLOW] = "16 MHz from HSI, no PLL\n"};

    const board_clock_t clock  = board_init();
    const drive_fault_t tested = selftest_run(&selftest_seal, NULL, data_start, SIZE_MAX); // interrupts are off
    const drive_fault_t found  = tested != DRIVE_FAULT_NONE ? tested : check_params();
    const drive_fault_t reset  = board_was_reset_by_watchdog() ? DRIVE_FAULT_WATCHDOG : DRIVE_FAULT_NONE;
    drive_init(&drive, &board_port, &rig_params, &config, found != DRIVE_FAULT_NONE ? found : reset);
    port_write(&board_port, "tribo " LOOP_ARITHMETIC ", self-test ");
    port_write(&board_port, tested == DRIVE_FAULT_NONE ? "passed, " : "failed, ");
    port_write(&board_port, clocks[clock]);
    board_start();

    for (;;)
    {
        kick();
        drive_log(&drive);
        kick(); // the line before and the one after may each take 9 ms
        read_command();
        __WFI(); // until the next tick or conversion
    }
}
