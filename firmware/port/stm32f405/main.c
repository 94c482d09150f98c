// The drive on the STM32F405: clock, self-test, then ticks in TIM2's interrupt, and in the background the log and commands over
// USART1 (app/command.h), with 10 mN for a step of the reference.

#include "app/command.h"
#include "app/drive.h"
#include "app/selftest.h"
#include "board.h"
#include "device.h"
#include "reset.h"
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

/// Refuses a field for which only one value is right.
static bool is_right(drive_config_error_t *error, const char *field, float value, float right)
{
    *error = (drive_config_error_t){.field = field, .value = value, .low = right, .high = right};
    return value == right;
}

/// Whether config and params are made for each other, and for the tick, the converters and the clock of this board.
static bool set_up(drive_config_error_t *error)
{
    const float crystal_hz = (float)rig_config.crystal_hz;
    const float usable_hz  = (float)(rig_config.crystal_hz / CLOCK_CRYSTAL_STEP_HZ * CLOCK_CRYSTAL_STEP_HZ);
    const bool  same_tick  = RIG_SAMPLE_TIME_S == (float)BOARD_TICK_US / 1e6f; // as the params' own rounding has it
    const float sample_us  = same_tick ? (float)BOARD_TICK_US : RIG_SAMPLE_TIME_S * 1e6f;
    return drive_setup_init(&drive_setup_used, &rig_config, &rig_params, &board_port, error) &&
           is_right(error, "period_us", (float)rig_config.period_us, (float)BOARD_TICK_US) &&
           is_right(error, "period_us", (float)BOARD_TICK_US, sample_us) &&
#ifdef DRIVE_ARITH_Q31
           is_right(error, "full_scale_n", rig_config.full_scale_n, RIG_FULL_SCALE_N) &&
#endif
           is_right(error, "crystal_hz", crystal_hz, usable_hz);
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

/// In hexadecimal.
static void write_word(uint32_t word)
{
    char text[] = "00000000";
    for (unsigned i = 0; i < 8u; i++)
    {
        text[7u - i] = "0123456789abcdef"[word >> (4u * i) & 15u];
    }
    port_write(&board_port, text);
}

static void report_clock(const board_clock_t *clock)
{
    static const char *const texts[] = {[CLOCK_CRYSTAL]  = "168 MHz from HSE",
                                        [CLOCK_INTERNAL] = "168 MHz from HSI, no HSE",
                                        [CLOCK_SLOW]     = "16 MHz from HSI, no PLL",
                                        [CLOCK_WRONG]    = "168 MHz from HSI, wrong HSE"};
    port_write(&board_port, "clock: ");
    port_write(&board_port, texts[clock->source]);
    port_write(&board_port, ", HSE ");
    port_write_number(&board_port, clock->crystal_khz);
    port_write(&board_port, " kHz\n");
}

static void report_reset(const reset_t *reset)
{
    port_write(&board_port, "reset: ");
    port_write(&board_port, reset_text(reset->cause));
    if (reset->cause == RESET_EXCEPTION)
    {
        port_write(&board_port, " ");
        port_write_number(&board_port, reset->exception);
        port_write(&board_port, " at ");
        write_word(reset->address);
        port_write(&board_port, ", status ");
        write_word(reset->status);
    }
    port_write(&board_port, "\n");
}

static drive_fault_t check_clock(const board_clock_t *clock)
{
    const bool allowed = drive_setup_used.config.degraded_clock != 0u;
    const bool good    = clock->source == CLOCK_CRYSTAL || (clock->source != CLOCK_WRONG && allowed);
    return good ? DRIVE_FAULT_NONE : DRIVE_FAULT_CLOCK;
}

int main(void)
{
    drive_config_error_t error;
    const reset_t        reset   = reset_take();
    const bool           fits    = set_up(&error);
    const board_clock_t  clock   = board_init(&drive_setup_used.config, drive_setup_used.scaling.no_current);
    const drive_fault_t  tested  = selftest_run(&selftest_seal, NULL, data_start, SIZE_MAX); // interrupts are off
    const drive_fault_t  found[] = {tested,
                                   fits ? DRIVE_FAULT_NONE : DRIVE_FAULT_PARAMS,
                                    check_clock(&clock),
                                    reset_fault(reset.cause)};
    unsigned             first   = 0;
    while (first < sizeof found / sizeof found[0] - 1u && found[first] == DRIVE_FAULT_NONE)
    {
        first++;
    }
    drive_init(&drive, &board_port, &drive_setup_used, found[first]);
    port_write(&board_port,
               tested == DRIVE_FAULT_NONE ? "tribo " LOOP_ARITHMETIC ", self-test passed\n"
                                          : "tribo " LOOP_ARITHMETIC ", self-test failed\n");
    report_reset(&reset);
    report_clock(&clock);
    drive_report_off(&board_port, &drive_setup_used.config);
    if (!fits)
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
