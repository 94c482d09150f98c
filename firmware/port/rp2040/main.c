// The drive on the RP2040: clocks, self-test, then ticks in the timer's interrupt. The background serves UART0 with a log
// until the first Modbus frame, and with the bus (app/registers.h). Params are not saved, because writing the flash from
// which the image runs needs functions of the boot ROM, which the emulators of this project do not have.

#include "app/log.h"
#include "app/registers.h"
#include "app/selftest.h"
#include "board.h"
#include "device.h"
#include "rig_config.h"

#define TRACE_WORDS 8192u // 32 KiB: two seconds of four signals

static registers_t  registers;
static uint32_t     ring[TRACE_WORDS];
static params_set_t defaults;

extern uint32_t data_start[];

void board_tick(void)
{
    registers_tick(&registers);
}

/// Returns true if a set suits this board's tick.
static bool suits(const params_set_t *set, params_error_t *error)
{
    const uint32_t period_us = set->drive.period_us;
    *error                   = (params_error_t){.word  = DRIVE_CONFIG_period_us,
                                                .value = (float)period_us,
                                                .low   = BOARD_TICK_US,
                                                .high  = BOARD_TICK_US};
    return period_us == BOARD_TICK_US;
}

static void load_params(void)
{
    static const registers_board_t parts  = {.port          = &board_port,
                                             .line          = &board_line,
                                             .defaults      = &defaults,
                                             .suits         = suits,
                                             .ceilings      = rig_ceilings,
                                             .ceiling_count = sizeof rig_ceilings / sizeof rig_ceilings[0],
                                             .baud          = 115200,
                                             .ring          = ring,
                                             .ring_words    = TRACE_WORDS};
    const drive_config_t           config = rig_config();
    defaults                              = params_default_of(&config);
    registers_load(&registers, &parts);
}

static void report_reset(drive_fault_t fault, uint32_t exception, uint32_t address)
{
    log_text(&board_port, "reset: ");
    log_text(&board_port, fault == DRIVE_FAULT_NONE ? "power-on or pin" : drive_fault_text(fault));
    if (exception != 0u)
    {
        log_text(&board_port, " ");
        log_number(&board_port, exception);
        log_text(&board_port, " at ");
        log_number(&board_port, address);
    }
    log_text(&board_port, "\n");
}

static void serve_line(void)
{
    board_release_line();
    registers_run(&registers);
    if (registers.modbus.frames == 0u)
    {
        drive_log(&registers.drive);
    }
}

int main(void)
{
    uint32_t            exception, address;
    const drive_fault_t reset = board_reset_fault(&exception, &address);
    load_params();
    if (!board_init(&registers.active->set.drive))
    {
        for (;;)
        {
            __WFI(); // without its crystal the chip has no clock for time, so the outputs stay off until it is reset
        }
    }
    const drive_fault_t tested = selftest_run(&selftest_seal, NULL, data_start, SIZE_MAX); // interrupts are off
    registers_start(&registers, tested != DRIVE_FAULT_NONE ? tested : reset);
    log_text(&board_port,
             tested == DRIVE_FAULT_NONE ? "tribo " TRIBO_ARITHMETIC ", self-test passed\n"
                                        : "tribo " TRIBO_ARITHMETIC ", self-test failed\n");
    report_reset(reset, exception, address);
    drive_report_off(&board_port, &registers.active->set.drive);
    board_start();

    for (;;)
    {
        board_kick();
        serve_line(); // a line of the log takes 9 ms
        board_kick();
        __WFI(); // until the next tick
    }
}
