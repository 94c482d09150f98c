#include "board.h"

#include "realtime.h"
#include "scenario/plant_config.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>

#define FIRST_US 1000000u ///< of the first tick, on the schedule's clock

static bool write_output(board_t *board, float output)
{
    board->output = output;
    if (board->plant != NULL)
    {
        return true;
    }
    return board->rig->output == RIG_OUTPUT_PWM ? pwm_write(&board->pwm, output) : channel_write(&board->dac, output);
}

static bool set_enable(board_t *board, bool on)
{
    return board->lines == NULL || lines_set(board->lines, LINE_ENABLE, on);
}

void board_off(void *context)
{
    board_t *board = context;
    (void)write_output(board, *board->idle);
    (void)set_enable(board, false);
}

// --- the port ------------------------------------------------------------------------------------------------------

static bool read_sensor(void *context, loop_force_t *reading)
{
    board_t *board = context;
    if (board->plant == NULL)
    {
        return channel_read(&board->sensor, reading);
    }
    *reading = (float)sim_sensor_read(&board->plant_sensor, sim_plant_filtered_force(board->plant));
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

/// A line that cannot be read is active.
static uint32_t inputs(void *context)
{
    static const struct
    {
        line_t   line;
        uint32_t bit;
    } known[] = {{LINE_EMERGENCY_STOP, PORT_INPUT_EMERGENCY_STOP},
                 {LINE_POWER_FAULT, PORT_INPUT_POWER_FAULT},
                 {LINE_READY, PORT_INPUT_NOT_READY}};

    const board_t *board  = context;
    uint32_t       active = 0;
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

static void log_byte(void *context, uint8_t byte)
{
    (void)context;
    (void)fputc(byte, stderr);
}

// --- opening -------------------------------------------------------------------------------------------------------

static bool open_simulation(board_t *board, const sim_scenario_t *scenario, sim_error_t *error)
{
    const sim_config_t *config = sim_scenario_config(scenario);
    board->plant_steps         = sim_plant_steps(config);
    board->plant_config        = sim_plant_config_of(config);
    if (!sim_sensor_init(&board->plant_sensor, &config->sensor.sampling, board->plant_config.step_s))
    {
        return sim_error_set(error, "out of memory");
    }
    board->plant = sim_plant_create(&board->plant_config, sim_truth_models[config->plant.model]);
    return board->plant != NULL || sim_error_set(error, "out of memory");
}

static bool open_devices(board_t *board, sim_error_t *error)
{
    const rig_t *rig = board->rig;
    board->lines     = lines_open(rig->lines, "tribo-drive", error);
    return board->lines != NULL && channel_open(&board->sensor, &rig->sensor, false, "sensor", error) &&
           (rig->output == RIG_OUTPUT_PWM ? pwm_open(&board->pwm, &rig->pwm, *board->idle, "pwm", error)
                                          : channel_open(&board->dac, &rig->dac, true, "dac", error));
}

static port_t port_of(board_t *board)
{
    const rig_t       *rig    = board->rig;
    const bool         pwm    = rig->output == RIG_OUTPUT_PWM;
    const port_range_t sensor = {.low_units = (float)rig->sensor_low, .high_units = (float)rig->sensor_high};
    const port_range_t duty   = {.low_units = 0.0f, .high_units = 1.0f};
    const port_range_t dac    = {.low_units = (float)rig->dac_low, .high_units = (float)rig->dac_high};
    const port_range_t none   = {.low_units = 0.0f};
    const bool         real   = rig->io == RIG_IO_DEVICES;
    return (port_t){.context     = board,
                    .sensor      = real ? sensor : none,
                    .output      = !real ? none
                                   : pwm ? duty
                                         : dac,
                    .read_sensor = read_sensor,
                    .command     = command,
                    .enable      = enable,
                    .inputs      = inputs,
                    .time_us     = time_us,
                    .log_byte    = log_byte};
}

bool board_open(board_t *board, const rig_t *rig, const sim_scenario_t *scenario, sim_error_t *error)
{
    void *shared = mmap(NULL, sizeof(float), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED)
    {
        return sim_error_set(error, "no shared memory: %s", strerror(errno));
    }
    *board = (board_t){.rig = rig, .sensor = {.file = -1}, .dac = {.file = -1}, .pwm = {.file = -1}, .idle = shared};
    *board->idle  = rig->drive.command_zero_units;
    board->port   = port_of(board);
    const bool ok = rig->io == RIG_IO_SIMULATED ? open_simulation(board, scenario, error) : open_devices(board, error);
    if (!ok)
    {
        board_close(board);
        return false;
    }
    board_off(board);
    return true;
}

void board_close(board_t *board)
{
    pwm_close(&board->pwm);
    channel_close(&board->dac);
    channel_close(&board->sensor);
    lines_close(board->lines);
    if (board->rig->io == RIG_IO_SIMULATED)
    {
        sim_plant_destroy(board->plant);
        sim_sensor_free(&board->plant_sensor);
    }
    board->lines = NULL;
    board->plant = NULL;
    (void)munmap((void *)board->idle, sizeof *board->idle);
}

const drive_config_t *board_config(const board_t *board)
{
    return board->drive != NULL ? &drive_setup(board->drive)->config : &board->rig->drive;
}

void board_attach(board_t *board, const drive_t *drive)
{
    board->drive = drive;
    *board->idle = board_config(board)->command_zero_units;
}

void board_begin(board_t *board, uint64_t number, int64_t due_ns)
{
    board->due_ns = due_ns;
    board->due_us = FIRST_US + (uint32_t)(number * board_config(board)->period_us);
}

void board_advance(board_t *board)
{
    const drive_config_t *drive = board_config(board);
    const double          sign  = drive->command_reversed != 0u ? -1.0 : 1.0;
    const double          u =
        sign * ((double)board->output - (double)drive->command_zero_units) * (double)drive->command_n_per_unit;
    sim_plant_signals_t unused;
    *board->idle = drive->command_zero_units;
    for (unsigned i = 0; board->plant != NULL && i < board->plant_steps; i++)
    {
        sim_sensor_push(&board->plant_sensor, sim_plant_filtered_force(board->plant));
        sim_plant_step(board->plant, u, &unused);
    }
}
