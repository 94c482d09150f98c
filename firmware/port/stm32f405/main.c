// The drive on the STM32F405: params from flash, clock, self-test, then ticks in TIM2's interrupt. The background serves USART1:
// first a log and text commands (app/command.h), from the first Modbus frame on a bus (app/registers.h).

#include "app/command.h"
#include "app/log.h"
#include "app/registers.h"
#include "app/selftest.h"
#include "board.h"
#include "device.h"
#include "params_flash.h"
#include "reset.h"
#include "rig_config.h"
#include "stage.h"

static registers_t registers;

#define TRACE_WORDS 8192u // 32 KiB: two seconds of four signals

static uint32_t     ring[TRACE_WORDS];
static params_set_t defaults;

#define REFERENCE_STEP 0.01f // N
#define REFERENCE_MAX  1.0f

void board_tick(void)
{
    registers_tick(&registers);
}

extern uint32_t data_start[];

static bool refuse(params_error_t *error, uint32_t word, float value, float right)
{
    *error = (params_error_t){.word = word, .value = value, .low = right, .high = right};
    return false;
}

/// Returns true if a set suits this board's tick and clock.
static bool suits(const params_set_t *set, params_error_t *error)
{
    const uint32_t crystal_hz = set->drive.crystal_hz;
    const uint32_t usable_hz  = crystal_hz / CLOCK_CRYSTAL_STEP_HZ * CLOCK_CRYSTAL_STEP_HZ;
    if (set->drive.period_us != BOARD_TICK_US)
    {
        return refuse(error, DRIVE_CONFIG_period_us, (float)set->drive.period_us, (float)BOARD_TICK_US);
    }
    if (crystal_hz != usable_hz)
    {
        return refuse(error, DRIVE_CONFIG_crystal_hz, (float)crystal_hz, (float)usable_hz);
    }
    drive_config_error_t by_stage;
    if (!stage_suits(&set->drive, &by_stage))
    {
        *error = (params_error_t){by_stage.field, by_stage.value, by_stage.low, by_stage.high, TRIBO_OK};
        return false;
    }
    return true;
}

static void take_text(void *context, const uint8_t *bytes, size_t count);

static void load_params(void)
{
    static modbus_line_t           line;
    static const registers_board_t parts = {.port          = &board_port,
                                            .line          = &line,
                                            .flash         = &params_flash,
                                            .defaults      = &defaults,
                                            .suits         = suits,
                                            .ceilings      = rig_ceilings,
                                            .ceiling_count = sizeof rig_ceilings / sizeof rig_ceilings[0],
                                            .baud          = 115200,
                                            .ring          = ring,
                                            .ring_words    = TRACE_WORDS};
    line                                 = board_line;
    line.stray                           = take_text;
    defaults                             = params_default_of(&rig_config);
    registers_load(&registers, &parts);
}

/// Moves the reference, which is 0 after every stop.
static void move_reference(float step_n)
{
    const float full_scale_n = registers.active->set.drive.full_scale_n;
    const float now_n        = scaling_value(registers.drive.reference, full_scale_n);
    const float next_n       = now_n + step_n;
    const float r_n = next_n > REFERENCE_MAX ? REFERENCE_MAX : next_n < -REFERENCE_MAX ? -REFERENCE_MAX : next_n;
    drive_set_reference(&registers.drive, scaling_number(r_n, full_scale_n));
}

static bool must_report; // report once the command's bytes have made room for others

static void execute(command_t command)
{
    switch (command)
    {
    case COMMAND_NONE:
        break;
    case COMMAND_STOP:
        drive_stop(&registers.drive);
        break;
    case COMMAND_START:
        drive_start(&registers.drive);
        break;
    case COMMAND_ACKNOWLEDGE:
        if (registers.is_known)
        {
            drive_acknowledge(&registers.drive);
        }
        break;
    case COMMAND_REPORT:
        must_report = true;
        break;
    case COMMAND_UP:
        move_reference(REFERENCE_STEP);
        break;
    case COMMAND_DOWN:
        move_reference(-REFERENCE_STEP);
        break;
    }
}

static bool is_text(void)
{
    return registers.modbus.frames == 0u;
}

static command_reader_t reader;

/// Takes bytes that are not a frame as commands.
static void take_text(void *context, const uint8_t *bytes, size_t count)
{
    static uint32_t heard_us;
    const uint32_t  now_us = board_port.time_us(board_port.context);
    (void)context;
    command_pause(&reader, now_us - heard_us);
    heard_us = now_us;
    for (size_t i = 0; i < count && is_text(); i++)
    {
        execute(command_take(&reader, bytes[i]));
    }
}

static void look_for_lost_text(void)
{
    if (registers.modbus.lost && is_text())
    {
        registers.modbus.lost = false;
        command_spoil(&reader);
        execute(COMMAND_STOP); // a lost byte may have been an x
    }
}

/// Serves the line, with the log last, because the log waits: text that arrives meanwhile finds room only if earlier text
/// was taken.
static void serve_line(void)
{
    board_release_line();
    look_for_lost_text();
    registers_run(&registers);
    if (!is_text())
    {
        return;
    }
    if (must_report)
    {
        must_report = false;
        drive_report(&registers.drive);
    }
    drive_log(&registers.drive);
}

/// Logs a number in hexadecimal.
static void write_word(uint32_t word)
{
    char text[] = "00000000";
    for (unsigned i = 0; i < 8u; i++)
    {
        text[7u - i] = "0123456789abcdef"[word >> (4u * i) & 15u];
    }
    log_text(&board_port, text);
}

static void report_clock(const board_clock_t *clock)
{
    static const char *const texts[] = {[CLOCK_CRYSTAL]  = "168 MHz from HSE",
                                        [CLOCK_INTERNAL] = "168 MHz from HSI, no HSE",
                                        [CLOCK_SLOW]     = "16 MHz from HSI, no PLL",
                                        [CLOCK_WRONG]    = "168 MHz from HSI, wrong HSE"};
    log_text(&board_port, "clock: ");
    log_text(&board_port, texts[clock->source]);
    log_text(&board_port, ", HSE ");
    log_number(&board_port, clock->crystal_khz);
    log_text(&board_port, " kHz\n");
}

static void report_reset(const reset_t *reset)
{
    log_text(&board_port, "reset: ");
    log_text(&board_port, reset_text(reset->cause));
    if (reset->cause == RESET_EXCEPTION)
    {
        log_text(&board_port, " ");
        log_number(&board_port, reset->exception);
        log_text(&board_port, " at ");
        write_word(reset->address);
        log_text(&board_port, ", status ");
        write_word(reset->status);
    }
    log_text(&board_port, "\n");
}

static drive_fault_t check_clock(const board_clock_t *clock)
{
    const bool allowed = registers.active->set.drive.degraded_clock != 0u;
    const bool usable  = clock->source == CLOCK_INTERNAL || (clock->source == CLOCK_SLOW && STAGE_SLOW_CLOCK);
    const bool good    = clock->source == CLOCK_CRYSTAL || (usable && allowed);
    return good ? DRIVE_FAULT_NONE : DRIVE_FAULT_CLOCK;
}

int main(void)
{
    const reset_t reset = reset_take();
    load_params();
    const drive_setup_t *setup   = &registers.active->drive;
    const board_clock_t  clock   = board_init(&registers.active->set.drive, setup->scaling.no_current);
    const drive_fault_t  tested  = selftest_run(&selftest_seal, NULL, data_start, SIZE_MAX); // interrupts are off
    const drive_fault_t  found[] = {tested, check_clock(&clock), reset_fault(reset.cause), reset_check_brown_out()};
    unsigned             first   = 0;
    while (first < sizeof found / sizeof found[0] - 1u && found[first] == DRIVE_FAULT_NONE)
    {
        first++;
    }
    registers_start(&registers, found[first]);
    log_text(&board_port,
             tested == DRIVE_FAULT_NONE ? "tribo " TRIBO_ARITHMETIC ", self-test passed\n"
                                        : "tribo " TRIBO_ARITHMETIC ", self-test failed\n");
    report_reset(&reset);
    report_clock(&clock);
    log_text(&board_port, "params: ");
    log_text(&board_port, store_status_text(registers.store));
    log_text(&board_port, "\n");
    drive_report_off(&board_port, &registers.active->set.drive);
    board_start();

    for (;;)
    {
        board_kick();
        serve_line(); // a line of the log takes 9 ms
        board_kick();
        __WFI(); // until the next tick or conversion
    }
}
