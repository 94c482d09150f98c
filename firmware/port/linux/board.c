#include "board.h"

#include "realtime.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>

#define FIRST_US  1000000u ///< time of the first tick on the schedule's clock
#define NS_PER_MS 1000000

static bool write_output(board_t *board, float output)
{
    board->output = output;
    if (board->desk != NULL)
    {
        return true;
    }
    return board->rig->output == RIG_OUTPUT_PWM ? pwm_write(&board->pwm, output) : channel_write(&board->dac, output);
}

static uint32_t time_us(void *context)
{
    const board_t *board  = context;
    const int64_t  now_ns = realtime_now_ns();
    const int64_t  behind = now_ns - board->due_ns;
    if (board->slack_ns == 0)
    {
        return (uint32_t)(now_ns / 1000);
    }
    return board->due_us + (behind > board->slack_ns ? (uint32_t)(behind / 1000) : 0u);
}

static bool set_enable(board_t *board, bool on)
{
    if (on || board->is_on)
    {
        board->off_us      = time_us(board);
        board->is_off_long = false;
    }
    board->is_on = on;
    return board->lines == NULL || lines_set(board->lines, LINE_ENABLE, on);
}

/// Takes the enable away first: the power stage is then off even if the output's driver blocks.
void board_off(void *context)
{
    board_t *board = context;
    (void)set_enable(board, false);
    (void)write_output(board, *board->idle);
}

// --- the port ------------------------------------------------------------------------------------------------------

static bool read_sensor(void *context, loop_force_t *reading)
{
    board_t *board = context;
    if (board->desk == NULL)
    {
        return channel_read(&board->sensor, reading);
    }
    *reading = (float)board->desk->read(board->plant);
    return true;
}

static void command(void *context, loop_force_t output)
{
    board_t *board = context;
    if (!write_output(board, output))
    {
        board->failed = true;
        board_off(board);
    }
}

static void enable(void *context, bool on)
{
    board_t *board = context;
    board->failed  = !set_enable(board, on) || board->failed;
}

/// Returns the fault of a power stage that is not as the last tick left it; null if there is none.
static const char *check_stage(board_t *board, bool is_ready)
{
    bool       is_high   = false;
    const bool is_read   = board->reads_enable && lines_read_back(board->lines, LINE_ENABLE, &is_high);
    const bool must_fall = board->rig->ready_off_ms > 0u && line_is_used(&board->rig->lines[LINE_READY]);
    board->is_off_long =
        board->is_off_long || (!board->is_on && time_us(board) - board->off_us > 1000u * board->rig->ready_off_ms);
    if (board->reads_enable && !is_read)
    {
        return "lines.enable can no longer be read back";
    }
    if (is_read && is_high != board->is_on)
    {
        return is_high ? "lines.enable reads on, though it is off" : "lines.enable reads off, though it is on";
    }
    return must_fall && is_ready && board->is_off_long && !board->is_on
               ? "lines.ready has not fallen within ready_off_ms, though enable is off"
               : NULL;
}

/// Reads an input. A line that cannot be read counts as active.
static uint32_t read_inputs(const board_t *board)
{
    static const struct
    {
        line_t   line;
        uint32_t bit;
    } known[] = {{LINE_EMERGENCY_STOP, PORT_INPUT_EMERGENCY_STOP},
                 {LINE_POWER_FAULT, PORT_INPUT_POWER_FAULT},
                 {LINE_READY, PORT_INPUT_NOT_READY}};

    uint32_t active = 0;
    for (size_t i = 0; board->lines != NULL && i < sizeof known / sizeof known[0]; i++)
    {
        bool high;
        bool low;
        if (!line_is_used(&board->rig->lines[known[i].line]))
        {
            continue;
        }
        const bool ok = lines_seen(board->lines, known[i].line, &high, &low);
        active |=
            ok ? port_inputs(board_config(board), high ? known[i].bit : 0u, low ? known[i].bit : 0u) & known[i].bit
               : known[i].bit;
    }
    return active;
}

static uint32_t inputs(void *context)
{
    board_t *board  = context;
    uint32_t active = read_inputs(board);
    if (board->lines != NULL)
    {
        board->complaint = check_stage(board, (active & PORT_INPUT_NOT_READY) == 0u);
        active |= board->complaint != NULL ? PORT_INPUT_POWER_FAULT : 0u;
    }
    return active;
}

static bool is_measured(const board_t *board, unsigned i)
{
    return board->desk == NULL && board->rig->measured[i].channel.device[0] != '\0';
}

static bool has_position(const board_t *board)
{
    return board->desk == NULL && board->rig->position.file[0] != '\0';
}

/// Reads a measured quantity. One that cannot be read exceeds every level.
static void read_measured(board_t *board, unsigned i)
{
    const rig_measure_t *rig     = &board->rig->measured[i];
    int32_t *const       all[]   = {[RIG_CURRENT]     = &board->latest.current_ma,
                                    [RIG_SUPPLY]      = &board->latest.bus_mv,
                                    [RIG_TEMPERATURE] = &board->latest.temperature_mc};
    float                reading = 0.0f;
    const bool           ok      = channel_read(&board->measured[i], &reading);
    const double         value   = 1e3 * rig->per_unit * ((double)reading - rig->zero);
    *all[i]                      = !ok || !(value < 2e9) ? INT32_MAX : value < -2e9 ? INT32_MIN : (int32_t)lrint(value);
}

/// Measures one quantity a tick, in turn, because each reading may take as long as its device takes.
static void read_next(board_t *board)
{
    for (unsigned i = 0; i < RIG_MEASURED; i++)
    {
        board->measured_at = (board->measured_at + 1u) % RIG_MEASURED;
        if (is_measured(board, board->measured_at))
        {
            read_measured(board, board->measured_at);
            return;
        }
    }
}

static void measure(void *context, port_measured_t *measured)
{
    board_t *board = context;
    read_next(board);
    if (has_position(board))
    {
        board->latest.position = counter_read(&board->position);
    }
    *measured = board->latest;
}

static void log_byte(void *context, uint8_t byte)
{
    board_t    *board     = context;
    const char *complaint = board->complaint; // written by the tick
    (void)fputc(byte, stderr);
    if (byte == '\n' && complaint != board->logged)
    {
        board->logged = complaint;
        if (complaint != NULL)
        {
            (void)fprintf(stderr, "power stage: %s\n", complaint);
        }
    }
}

// --- opening -------------------------------------------------------------------------------------------------------

static bool open_desk(board_t *board, const common_scenario_t *scenario, common_error_t *error)
{
    board->plant = board->desk->open(scenario, error);
    return board->plant != NULL;
}

/// Checks the enable right after it was turned off.
static bool read_enable_back(board_t *board, common_error_t *error)
{
    bool is_high = false;
    char text[3 * LINES_NAME_MAX];
    board->reads_enable = board->rig->read_back != 0 && lines_read_back(board->lines, LINE_ENABLE, &is_high);
    line_describe(LINE_ENABLE, &board->rig->lines[LINE_ENABLE], text, sizeof text);
    if (board->rig->read_back != 0 && !board->reads_enable)
    {
        (void)fprintf(stderr, "%s: this chip does not read an output back\n", text);
    }
    return !is_high || common_error_set(error, "%s: reads on, though it is off", text);
}

static bool open_measured(board_t *board, common_error_t *error)
{
    static const char *const keys[] =
        {[RIG_CURRENT] = "current", [RIG_SUPPLY] = "supply", [RIG_TEMPERATURE] = "temperature"};
    for (unsigned i = 0; i < RIG_MEASURED; i++)
    {
        if (!is_measured(board, i))
        {
            continue;
        }
        if (!channel_open(&board->measured[i], &board->rig->measured[i].channel, false, keys[i], error))
        {
            return false;
        }
        read_measured(board, i);
    }
    return !has_position(board) || counter_open(&board->position, &board->rig->position, "position", error);
}

static bool open_devices(board_t *board, common_error_t *error)
{
    const rig_t *rig = board->rig;
    board->lines     = lines_open(rig->lines, "tribo-drive", error);
    const bool ok    = board->lines != NULL &&
                    (!rig_has_sensor(rig) || channel_open(&board->sensor, &rig->sensor, false, "sensor", error)) &&
                    (rig->output == RIG_OUTPUT_PWM ? pwm_open(&board->pwm, &rig->pwm, *board->idle, "pwm", error)
                                                   : channel_open(&board->dac, &rig->dac, true, "dac", error));
    if (!ok)
    {
        return false;
    }
    board_off(board);
    return read_enable_back(board, error) && open_measured(board, error);
}

static port_t port_of(board_t *board)
{
    const rig_t       *rig    = board->rig;
    const bool         pwm    = rig->output == RIG_OUTPUT_PWM;
    const port_range_t sensor = {.low_units = (float)rig->sensor_low, .high_units = (float)rig->sensor_high};
    const port_range_t duty   = {.low_units = 0.0f, .high_units = 1.0f};
    const port_range_t dac    = {.low_units = (float)rig->dac_low, .high_units = (float)rig->dac_high};
    const port_range_t none   = {.low_units = 0.0f};
    const bool         real   = board->desk == NULL;
    const uint32_t     shown  = (is_measured(board, RIG_CURRENT) ? PORT_MEASURES_CURRENT : 0u) |
                           (is_measured(board, RIG_SUPPLY) ? PORT_MEASURES_BUS : 0u) |
                           (is_measured(board, RIG_TEMPERATURE) ? PORT_MEASURES_TEMPERATURE : 0u) |
                           (has_position(board) ? PORT_MEASURES_POSITION : 0u);
    return (port_t){.context     = board,
                    .sensor      = real ? sensor : none,
                    .output      = !real ? none
                                   : pwm ? duty
                                         : dac,
                    .measures    = shown,
                    .measure     = measure,
                    .read_sensor = read_sensor,
                    .command     = command,
                    .enable      = enable,
                    .inputs      = inputs,
                    .time_us     = time_us,
                    .log_byte    = log_byte};
}

bool board_open(board_t                 *board,
                const rig_t             *rig,
                const desk_t            *desk,
                const common_scenario_t *scenario,
                common_error_t          *error)
{
    void *shared = mmap(NULL, sizeof(float), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED)
    {
        return common_error_set(error, "shared memory cannot be allocated: %s", strerror(errno));
    }
    *board        = (board_t){.rig      = rig,
                              .desk     = desk,
                              .sensor   = {.file = -1},
                              .dac      = {.file = -1},
                              .pwm      = {.file = -1},
                              .position = {.file = -1},
                              .measured = {{.file = -1}, {.file = -1}, {.file = -1}},
                              .idle     = shared};
    *board->idle  = rig->drive.command_zero_units;
    board->port   = port_of(board);
    const bool ok = desk != NULL ? open_desk(board, scenario, error) : open_devices(board, error);
    if (!ok)
    {
        board_close(board);
    }
    return ok;
}

void board_close(board_t *board)
{
    pwm_close(&board->pwm);
    channel_close(&board->dac);
    channel_close(&board->sensor);
    for (unsigned i = 0; i < RIG_MEASURED; i++)
    {
        channel_close(&board->measured[i]);
    }
    counter_close(&board->position);
    lines_close(board->lines);
    if (board->desk != NULL)
    {
        board->desk->close(board->plant);
    }
    board->lines = NULL;
    board->plant = NULL;
    (void)munmap((void *)board->idle, sizeof *board->idle);
}

const drive_config_t *board_config(const board_t *board)
{
    return board->drive != NULL ? &drive_setup(board->drive)->config : &board->rig->drive;
}

bool board_attach(board_t *board, const drive_t *drive, common_error_t *error)
{
    const rig_t  *rig       = board->rig;
    const bool    has_ready = board->lines != NULL && line_is_used(&rig->lines[LINE_READY]);
    const int64_t end_ns    = realtime_now_ns() + (int64_t)rig->ready_off_ms * NS_PER_MS;
    board->drive            = drive;
    *board->idle            = board_config(board)->command_zero_units;
    // A power stage that was on before may need time to turn off.
    while (has_ready && rig->ready_off_ms > 0u && (read_inputs(board) & PORT_INPUT_NOT_READY) == 0u)
    {
        if (realtime_now_ns() > end_ns)
        {
            char text[3 * LINES_NAME_MAX];
            line_describe(LINE_READY, &rig->lines[LINE_READY], text, sizeof text);
            return common_error_set(error,
                                    "%s: the power stage is ready, though enable has been off for %" PRIu64
                                    " ms (ready_off_ms; 0 if its ready output does not fall)",
                                    text,
                                    rig->ready_off_ms);
        }
        (void)realtime_sleep_until(realtime_now_ns() + NS_PER_MS);
    }
    board->is_off_long = true;
    return true;
}

void board_begin(board_t *board, uint64_t number, int64_t due_ns)
{
    board->due_ns = due_ns;
    board->due_us = FIRST_US + (uint32_t)(number * board_config(board)->period_us);
}

void board_pulse(board_t *board)
{
    const bool is_well = board->drive->state != DRIVE_FAULT && !board->failed;
    if (board->lines == NULL || !is_well || ++board->pulse_ticks < board->rig->heartbeat_ticks)
    {
        return;
    }
    board->pulse_ticks = 0;
    board->pulse       = !board->pulse;
    board->failed      = !lines_set(board->lines, LINE_HEARTBEAT, board->pulse);
}

void board_advance(board_t *board)
{
    const drive_config_t *drive = board_config(board);
    const double          sign  = drive->command_reversed != 0u ? -1.0 : 1.0;
    const double          u =
        sign * ((double)board->output - (double)drive->command_zero_units) * (double)drive->command_n_per_unit;
    *board->idle = drive->command_zero_units;
    if (board->desk != NULL)
    {
        board->desk->advance(board->plant, u);
    }
}
