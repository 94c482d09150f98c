// The drive on the STM32F405: self-test, then ticks in TIM2's interrupt, and in the background the log and commands over
// USART1 (app/command.h), with 10 mN for a step of the reference.

#include "app/command.h"
#include "app/drive.h"
#include "app/selftest.h"
#include "board.h"
#include "device.h"
#include "rig_config.h"
#ifdef DRIVE_ARITH_Q31
#include "rig_q31.h"
#else
#include "rig_f32.h"
#endif

static drive_t       drive;
static drive_setup_t drive_setup_used;

#define REFERENCE_STEP 0.01f // N
#define REFERENCE_MAX  1.0f

void board_tick(void)
{
    drive_tick(&drive);
}

extern uint32_t data_start[];

/// Whether config and params are made for each other, and for the tick and the converters of this board.
static drive_fault_t set_up(drive_config_error_t *error)
{
    bool ok = drive_setup_init(&drive_setup_used, &rig_config, &rig_params, &board_port, error);
    if (ok && rig_config.period_us != BOARD_TICK_US)
    {
        *error = (drive_config_error_t){"period_us", (float)rig_config.period_us, BOARD_TICK_US, BOARD_TICK_US, false};
        ok     = false;
    }
    if (ok && RIG_SAMPLE_TIME_S != (float)BOARD_TICK_US / 1e6f)
    {
        const float sample_us = RIG_SAMPLE_TIME_S * 1e6f;
        *error                = (drive_config_error_t){"period_us", (float)BOARD_TICK_US, sample_us, sample_us, false};
        ok                    = false;
    }
#ifdef DRIVE_ARITH_Q31
    if (ok && RIG_FULL_SCALE_N != rig_config.full_scale_n)
    {
        *error =
            (drive_config_error_t){"full_scale_n", rig_config.full_scale_n, RIG_FULL_SCALE_N, RIG_FULL_SCALE_N, false};
        ok = false;
    }
#endif
    return ok ? DRIVE_FAULT_NONE : DRIVE_FAULT_PARAMS;
}

/// Moves the reference, which is 0 after every stop.
static void move_reference(float step_n)
{
    const float now_n  = scaling_value(drive.reference, rig_config.full_scale_n);
    const float next_n = now_n + step_n;
    const float r_n    = next_n > REFERENCE_MAX ? REFERENCE_MAX : next_n < -REFERENCE_MAX ? -REFERENCE_MAX : next_n;
    drive_reference(&drive, scaling_number(r_n, rig_config.full_scale_n));
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
        move_reference(REFERENCE_STEP);
        break;
    case COMMAND_DOWN:
        move_reference(-REFERENCE_STEP);
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

    drive_config_error_t error;
    const board_clock_t  clock  = board_init();
    const drive_fault_t  tested = selftest_run(&selftest_seal, NULL, data_start, SIZE_MAX); // interrupts are off
    const drive_fault_t  fits   = set_up(&error);
    const drive_fault_t  found  = tested != DRIVE_FAULT_NONE ? tested : fits;
    const drive_fault_t  reset  = board_was_reset_by_watchdog() ? DRIVE_FAULT_WATCHDOG : DRIVE_FAULT_NONE;
    drive_init(&drive, &board_port, &drive_setup_used, found != DRIVE_FAULT_NONE ? found : reset);
    port_write(&board_port, "tribo " LOOP_ARITHMETIC ", self-test ");
    port_write(&board_port, tested == DRIVE_FAULT_NONE ? "passed, " : "failed, ");
    port_write(&board_port, clocks[clock]);
    drive_report_off(&board_port, &rig_config);
    if (fits != DRIVE_FAULT_NONE)
    {
        drive_report_refused(&board_port, &error);
    }
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
