#include "target/target.h"

#include "scenario/loop.h"
#include "support/clock.h"
#include "support/data_path.h"
#include "target/boards.h"
#include "target/emulator.h"
#include "target/serial.h"
#include "tribo_wire.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define FAULT_NONE 0u // DRIVE_FAULT_NONE; the drive logs the text of other faults

/// Words of a command line for QEMU before its common part.
#define MACHINE_MAX 8

typedef struct
{
    const char *name;
    const char *tree; ///< preset that builds the image
    const char *machine[MACHINE_MAX];
} model_t;

#define MODEL(name, tree, ...) {name, tree, {__VA_ARGS__}},
static const model_t models[] = {SIM_BOARDS(MODEL)};
#undef MODEL

#define MODELS (sizeof models / sizeof models[0])

#define SERIAL "serial:" // before the name of a device

struct sim_target
{
    const char     *name;
    const model_t  *model; ///< null: a board on a serial line
    sim_emulator_t *emulator;
    sim_serial_t   *serial;
    sim_loop_t      host; ///< the same loop, computed on this host
    uint32_t        period_us;
    uint64_t        ticks, different_ticks;
    double          busy_s;
    uint32_t        tock[TRIBO_TOCK_WORDS]; ///< answer to the last tick
    char            difference[256];        ///< the first difference
};

static const model_t *model_of(const char *name)
{
    for (size_t i = 0; i < MODELS; i++)
    {
        if (strcmp(models[i].name, name) == 0)
        {
            return &models[i];
        }
    }
    return NULL;
}

static bool is_serial(const char *name)
{
    return strncmp(name, SERIAL, sizeof SERIAL - 1u) == 0;
}

bool sim_target_exists(const char *name)
{
    return model_of(name) != NULL || is_serial(name);
}

const char *sim_target_names(void)
{
#define NAME(name, ...) ", " name
    static const char names[] = SIM_BOARDS(NAME) ", serial:DEVICE";
#undef NAME
    return names + 2;
}

/// Puts the target's name before the error.
static bool blame(const sim_target_t *target, const common_error_t *inner, common_error_t *error)
{
    return common_error_set(error, "%s: %s", target->name, inner->text);
}

static bool send_message(sim_target_t   *target,
                         uint32_t        kind,
                         const uint32_t *words,
                         uint32_t        count,
                         common_error_t *error)
{
    return target->serial != NULL ? sim_serial_send(target->serial, kind, words, count, error)
                                  : sim_emulator_send(target->emulator, kind, words, count, error);
}

static bool receive_message(sim_target_t *target, uint32_t kind, uint32_t *words, uint32_t count, common_error_t *error)
{
    return target->serial != NULL ? sim_serial_receive(target->serial, kind, words, count, error)
                                  : sim_emulator_receive(target->emulator, kind, words, count, error);
}

// --- start ---------------------------------------------------------------------------------------------------------

static bool find_image(char *path, size_t size, const sim_target_t *target, common_error_t *error)
{
    const char *given = getenv("TRIBO_FIRMWARE");
    char        built[PATH_MAX];
    common_data_path(built, "firmware");
    const int length = snprintf(path,
                                size,
                                "%s/%s/firmware/tribo-drive-%s.elf",
                                given != NULL ? given : built,
                                target->model->tree,
                                target->host.q31 ? "q31" : "f32");
    return ((size_t)length < size && access(path, R_OK) == 0) ||
           common_error_set(error,
                            "%s: no image %s; to build it: cmake --preset %s && cmake --build --preset %s",
                            target->model->name,
                            path,
                            target->model->tree,
                            target->model->tree);
}

static bool open_serial(sim_target_t *target, common_error_t *error)
{
    common_error_t inner = {""};
    target->serial       = sim_serial_open(target->name + sizeof SERIAL - 1u, &inner);
    return target->serial != NULL || blame(target, &inner, error);
}

static bool start_emulator(sim_target_t *target, common_error_t *error)
{
    char image[1024];
    if (!find_image(image, sizeof image, target, error))
    {
        return false;
    }
    const char *const common[]                                                    = {"-accel",
                                                                                     "tcg",
                                                                                     "-display",
                                                                                     "none",
                                                                                     "-monitor",
                                                                                     "none",
                                                                                     "-serial",
                                                                                     "none",
                                                                                     "-semihosting-config",
                                                                                     "enable=on,target=native",
                                                                                     "-kernel"};
    const char       *command[MACHINE_MAX + sizeof common / sizeof common[0] + 2] = {NULL};
    size_t            count                                                       = 0;
    while (count < MACHINE_MAX && target->model->machine[count] != NULL)
    {
        command[count] = target->model->machine[count];
        count++;
    }
    memcpy(command + count, common, sizeof common);
    command[count + sizeof common / sizeof common[0]] = image;

    common_error_t inner = {""};
    target->emulator     = sim_emulator_start((char *const *)command, &inner);
    return target->emulator != NULL || blame(target, &inner, error);
}

/// Turns off two fault checks, because time in the emulator is exact and a simulated sensor may repeat its value for long.
static void fill_setup(uint32_t                    words[TRIBO_SETUP_WORDS],
                       const sim_target_t         *target,
                       const common_loop_config_t *config)
{
    const tribo_setup_t setup = {.period_us    = target->period_us,
                                 .late_us      = target->period_us / 10u,
                                 .budget_us    = target->period_us / 2u,
                                 .stuck_ticks  = 0,
                                 .full_scale_n = (float)target->host.full_scale_n,
                                 .loop         = config->parts};
    tribo_setup_to_words(&setup, words);
}

static bool say_hello(sim_target_t *target, const common_loop_config_t *config, common_error_t *error)
{
    uint32_t hello[TRIBO_HELLO_WORDS];
    uint32_t setup[TRIBO_SETUP_WORDS];
    uint32_t ready[TRIBO_READY_WORDS];
    if (!(target->serial != NULL ? sim_serial_hello(target->serial, hello, TRIBO_HELLO_WORDS, error)
                                 : receive_message(target, TRIBO_WIRE_HELLO, hello, TRIBO_HELLO_WORDS, error)))
    {
        return false;
    }
    if (hello[TRIBO_HELLO_VERSION] != TRIBO_WIRE_VERSION || hello[TRIBO_HELLO_Q31] != (uint32_t)target->host.q31)
    {
        return common_error_set(error, "the image has another version or arithmetic; build it again");
    }
    if (hello[TRIBO_HELLO_FAULT] != FAULT_NONE)
    {
        return common_error_set(error, "the drive's self-test failed with fault %" PRIu32, hello[TRIBO_HELLO_FAULT]);
    }
    fill_setup(setup, target, config);
    if (!send_message(target, TRIBO_WIRE_SETUP, setup, TRIBO_SETUP_WORDS, error) ||
        !receive_message(target, TRIBO_WIRE_READY, ready, TRIBO_READY_WORDS, error))
    {
        return false;
    }
    return ready[TRIBO_READY_STATUS] == (uint32_t)TRIBO_OK ||
           common_error_set(error,
                            "the target refuses a config that the host accepts: %s",
                            tribo_status_text((tribo_status_t)ready[TRIBO_READY_STATUS]));
}

sim_target_t *sim_target_start(const char                 *name,
                               bool                        q31,
                               const common_loop_config_t *config,
                               double                      full_scale_n,
                               common_error_t             *error)
{
    sim_target_t *target = calloc(1, sizeof *target);
    if (target == NULL)
    {
        (void)common_error_set(error, "out of memory");
        return NULL;
    }
    target->name                = name;
    target->model               = model_of(name);
    target->period_us           = (uint32_t)fmax(1.0, round(1e6 * (double)config->parts.config.sample_time_s));
    const tribo_status_t status = sim_loop_init(&target->host, q31, config, full_scale_n);
    if (status != TRIBO_OK)
    {
        (void)common_error_set(error, "%s", tribo_status_text(status));
        sim_target_destroy(target);
        return NULL;
    }
    common_error_t inner = {""};
    if (!(target->model != NULL ? start_emulator(target, error) : open_serial(target, error)) ||
        (!say_hello(target, config, &inner) && !blame(target, &inner, error)))
    {
        sim_target_destroy(target);
        return NULL;
    }
    return target;
}

// --- ticks ---------------------------------------------------------------------------------------------------------

static void compare(sim_target_t *target, const uint32_t words[TRIBO_SIGNAL_WORDS])
{
#define NAME(place, text, f32, q31) [TRIBO_SIGNAL_##place] = (text),
    static const char *const names[TRIBO_SIGNAL_WORDS]     = {[TRIBO_SIGNAL_FLAGS] = "limited, Q1, Q2, Q",
                                                              TRIBO_SIGNAL_FORCES(NAME)};
#undef NAME

    const uint32_t *seen  = target->tock + TRIBO_TOCK_SIGNALS;
    const uint32_t  guard = (uint32_t)sim_loop_guard_cause(&target->host);
    if (memcmp(seen, words, sizeof(uint32_t) * TRIBO_SIGNAL_WORDS) == 0 &&
        target->tock[TRIBO_TOCK_COMMAND] == words[TRIBO_SIGNAL_U] && target->tock[TRIBO_TOCK_GUARD] == guard)
    {
        return;
    }
    if (target->different_ticks++ > 0)
    {
        return;
    }
    for (unsigned i = 0; i < TRIBO_SIGNAL_WORDS; i++)
    {
        if (seen[i] != words[i])
        {
            (void)snprintf(target->difference,
                           sizeof target->difference,
                           "%s in tick %" PRIu64 " is %08" PRIx32 ", but %08" PRIx32 " on the host",
                           names[i],
                           target->ticks,
                           seen[i],
                           words[i]);
            return;
        }
    }
    if (target->tock[TRIBO_TOCK_GUARD] != guard)
    {
        (void)snprintf(target->difference,
                       sizeof target->difference,
                       "the guard's cause in tick %" PRIu64 " is %" PRIu32 ", but %" PRIu32 " on the host",
                       target->ticks,
                       target->tock[TRIBO_TOCK_GUARD],
                       guard);
        return;
    }
    (void)snprintf(target->difference,
                   sizeof target->difference,
                   "the command in tick %" PRIu64 " is %08" PRIx32 ", but u is %08" PRIx32,
                   target->ticks,
                   target->tock[TRIBO_TOCK_COMMAND],
                   words[TRIBO_SIGNAL_U]);
}

static bool exchange(sim_target_t *target, uint32_t r, uint32_t y, common_error_t *error)
{
    uint32_t       tick[TRIBO_TICK_WORDS];
    const uint32_t start_us   = (uint32_t)target->ticks * target->period_us;
    tick[TRIBO_TICK_REQUESTS] = target->ticks == 0 ? TRIBO_REQUEST_START : 0u;
    tick[TRIBO_TICK_START_US] = start_us;
    tick[TRIBO_TICK_END_US]   = start_us;
    tick[TRIBO_TICK_INPUTS]   = 0;
    tick[TRIBO_TICK_SILENT]   = 0;
    tick[TRIBO_TICK_R]        = r;
    tick[TRIBO_TICK_Y]        = y;
    if (!send_message(target, TRIBO_WIRE_TICK, tick, TRIBO_TICK_WORDS, error) ||
        !receive_message(target, TRIBO_WIRE_TOCK, target->tock, TRIBO_TOCK_WORDS, error))
    {
        return false;
    }
    if (target->tock[TRIBO_TOCK_FAULT] == FAULT_NONE)
    {
        return true;
    }
    const double t_s = (double)target->ticks * target->host.sample_time_s;
    return target->serial != NULL
               ? common_error_set(error,
                                  "the drive stopped at t = %g s with fault %" PRIu32 " of firmware/app/drive.h",
                                  t_s,
                                  target->tock[TRIBO_TOCK_FAULT])
               : common_error_set(error,
                                  "the drive stopped at t = %g s: %s",
                                  t_s,
                                  sim_emulator_last_line(target->emulator));
}

bool sim_target_step(sim_target_t                   *target,
                     double                          r_n,
                     double                          y_n,
                     double                         *u_n,
                     tribo_force_loop_f32_signals_t *signals,
                     common_error_t                 *error)
{
    const uint32_t r       = sim_loop_word(&target->host, r_n);
    const uint32_t y       = sim_loop_word(&target->host, y_n);
    const double   start_s = common_clock_s();
    common_error_t inner   = {""};
    if (!exchange(target, r, y, &inner))
    {
        return blame(target, &inner, error);
    }
    target->busy_s += common_clock_s() - start_s;

    uint32_t words[TRIBO_SIGNAL_WORDS];
    sim_loop_step_words(&target->host, r, y, words);
    compare(target, words);
    sim_loop_signals(&target->host, target->tock + TRIBO_TOCK_SIGNALS, signals);
    *u_n = sim_loop_force(&target->host, target->tock[TRIBO_TOCK_COMMAND]);
    target->ticks++;
    return true;
}

/// Ends the session: an emulator ends, a board answers with its cycles.
static bool wait_for_end(sim_target_t *target, uint32_t cycles[TRIBO_CYCLES_WORDS], common_error_t *error)
{
    return target->serial != NULL
               ? sim_serial_receive(target->serial, TRIBO_WIRE_END, cycles, TRIBO_CYCLES_WORDS, error)
               : sim_emulator_wait(target->emulator, error);
}

const sim_loop_t *sim_target_twin(const sim_target_t *target)
{
    return &target->host;
}

bool sim_target_finish(sim_target_t *target, sim_target_result_t *result, common_error_t *error)
{
    uint32_t       cycles[TRIBO_CYCLES_WORDS] = {0};
    common_error_t inner                      = {""};
    if (!send_message(target, TRIBO_WIRE_END, NULL, 0, &inner) || !wait_for_end(target, cycles, &inner))
    {
        return blame(target, &inner, error);
    }
    *result = (sim_target_result_t){.ticks           = target->ticks,
                                    .different_ticks = target->different_ticks,
                                    .limited_ticks   = target->tock[TRIBO_TOCK_LIMITED_TICKS],
                                    .bad_inputs      = target->tock[TRIBO_TOCK_BAD_INPUTS],
                                    .cycles_least    = cycles[TRIBO_CYCLES_LEAST],
                                    .cycles_mean     = cycles[TRIBO_CYCLES_MEAN],
                                    .cycles_most     = cycles[TRIBO_CYCLES_MOST],
                                    .ticks_per_s = target->busy_s > 0.0 ? (double)target->ticks / target->busy_s : 0.0};
    if (target->different_ticks > 0)
    {
        (void)snprintf(result->difference,
                       sizeof result->difference,
                       "%s: %" PRIu64 " of %" PRIu64 " ticks differ from the host's; the first: %s",
                       target->name,
                       target->different_ticks,
                       target->ticks,
                       target->difference);
    }
    return true;
}

void sim_target_destroy(sim_target_t *target)
{
    if (target != NULL)
    {
        sim_emulator_stop(target->emulator);
        sim_serial_close(target->serial);
        free(target);
    }
}
