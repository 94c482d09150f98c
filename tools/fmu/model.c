#include "model.h"

#include "keys/table.h"
#include "loop/loop_config.h"
#include "scenario/columns.h"
#include "scenario/keys.h"
#include "scenario/loop.h"
#include "scenario/plant_config.h"
#include "scenario/runner.h"

#include <fenv.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct
{
    const char *key;
    double      number;
    uint64_t    whole;
} value_t;

typedef struct
{
    const char *list;
    unsigned    count;
} length_t;

// What an FMU can be.
enum
{
    LOOP,
    COMPENSATOR,
    PLANT
};

// Made by tools/tribo-fmu: values, lengths, FMU_PART, FMU_TOKEN, FMU_Q31, FMU_LEARNS.
#include "values.h"

enum
{
    COUNT = sizeof values / sizeof values[0]
};

const char *const fmu_token = FMU_TOKEN;

/// A change of params is a change of their address (force_loop_f32.h), and the params of the last tick must stay until the next one.
/// So there are three sets: those, the present ones, and room for new ones.
enum
{
    SLOTS = 3
};

typedef struct
{
    bool          is_started;
    unsigned      slot;   ///< the present loop
    unsigned      active; ///< of saved: the loop whose params the last tick had; SLOTS: none
    sim_config_t  config[SLOTS];
    sim_loop_t    loop[SLOTS];
    sim_row_t     row;
    sim_learned_t learned;
} state_t;

struct fmu_model
{
    state_t              now;
    common_loop_config_t loop_config[SLOTS];
    sim_plant_config_t   plant_config; ///< with the rest of a plant: null or zero as long as it is not started
    sim_plant_t         *plant;
    sim_sensor_t         sensor;
    common_error_t       error;
};

static void put(sim_config_t *config, const char *key, double number, uint64_t whole)
{
    common_place_t          place;
    const common_optional_t given = {.is_given = true, .value = number};
    const int               word  = (int)number;
    (void)common_key_find(sim_keys, config, key, &place);
    switch (place.key->type)
    {
    case COMMON_KEY_NUMBER:
        memcpy(place.at, &number, sizeof number);
        break;
    case COMMON_KEY_OPTIONAL:
        memcpy(place.at, &given, sizeof given);
        break;
    case COMMON_KEY_WHOLE:
        memcpy(place.at, &whole, sizeof whole);
        break;
    case COMMON_KEY_CHOICE:
        memcpy(place.at, &word, sizeof word);
        break;
    default:
        break;
    }
}

static void drop_plant(fmu_model_t *model)
{
    sim_plant_destroy(model->plant);
    sim_sensor_free(&model->sensor);
    model->plant = NULL;
}

static bool make_plant(fmu_model_t *model)
{
    const sim_config_t *config = &model->now.config[0];
    drop_plant(model);
    model->plant_config = sim_plant_config_of(config);
    model->plant        = sim_plant_create(&model->plant_config, sim_truth_models[config->plant.model]);
    return (model->plant != NULL &&
            sim_sensor_init(&model->sensor, &config->sensor.sampling, model->plant_config.step_s)) ||
           common_error_set(&model->error, "out of memory");
}

/// What the loop reads at a tick.
static void read_plant(fmu_model_t *model)
{
    model->now.row.force_n = sim_plant_force(model->plant);
    model->now.row.y_n     = sim_sensor_read(&model->sensor, sim_plant_filtered_force(model->plant));
}

void fmu_model_reset(fmu_model_t *model)
{
    common_place_t place;
    drop_plant(model);
    memset(model, 0, sizeof *model);
    common_key_set_defaults(sim_keys, (char *)model->now.config);
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0] && lengths[i].list != NULL; i++)
    {
        char *group = (char *)model->now.config;
        (void)common_key_find(sim_keys, group, lengths[i].list, &place);
        char *const counter = place.at - place.key->offset + place.key->count_offset;
        memcpy(counter, &lengths[i].count, sizeof lengths[i].count);
    }
    for (size_t i = 0; i < COUNT; i++)
    {
        put(model->now.config, values[i].key, values[i].number, values[i].whole);
    }
}

fmu_model_t *fmu_model_create(void)
{
    fmu_model_t *model = calloc(1, sizeof *model);
    if (model != NULL)
    {
        fmu_model_reset(model);
    }
    return model;
}

void fmu_model_destroy(fmu_model_t *model)
{
    drop_plant(model);
    free(model);
}

const char *fmu_model_error(const fmu_model_t *model)
{
    return model->error.text;
}

void fmu_model_forget_error(fmu_model_t *model)
{
    model->error.text[0] = '\0';
}

/// A loop at rest, made by the library's set-up.
static bool make(fmu_model_t *model, unsigned slot)
{
    const sim_config_t *config = &model->now.config[slot];
    common_loop_config_fill(&model->loop_config[slot], &config->loop);
    if (FMU_PART == COMPENSATOR)
    {
        model->loop_config[slot].parts.feeds_forward = false;
        model->loop_config[slot].parts.guarded       = false;
    }
    const tribo_status_t status =
        sim_loop_init(&model->now.loop[slot], FMU_Q31, &model->loop_config[slot], config->loop.limits.full_scale_n);
    return status == TRIBO_OK ||
           common_error_set(&model->error, "%s: %s", common_loop_key_of(status), tribo_status_text(status));
}

static unsigned active_slot(const state_t *now)
{
    unsigned slot = 0;
    while (slot < SLOTS && now->loop[now->slot].in_f32.state.active != &now->loop[slot].in_f32.params &&
           now->loop[now->slot].in_q31.state.active != &now->loop[slot].in_q31.params)
    {
        slot++;
    }
    return slot;
}

/// What the loop `old` remembers, for the present one, whose start has named its memory.
#define REMEMBER(loop, old, arithmetic)                                                                                \
    do                                                                                                                 \
    {                                                                                                                  \
        tribo_force_loop_##arithmetic##_state_t *const state = &(loop)->in_##arithmetic.state;                         \
        tribo_force_loop_##arithmetic##_state_t        was   = (old)->in_##arithmetic.state;                           \
                                                                                                                       \
        was.memory                     = state->memory;                                                                \
        was.memory_seal                = state->memory_seal;                                                           \
        *state                         = was;                                                                          \
        (loop)->in_##arithmetic.memory = (old)->in_##arithmetic.memory;                                                \
    } while (0)

static void remember(fmu_model_t *model, const sim_loop_t *old)
{
    sim_loop_t *const loop = &model->now.loop[model->now.slot];
    if (FMU_Q31)
    {
        REMEMBER(loop, old, q31);
    }
    else
    {
        REMEMBER(loop, old, f32);
    }
}

/// With the floating-point environment of a program's start, whatever rounding, flush to zero or traps the importer has: the same bits
/// in each of them. Locale is of error.c, the only one that writes numbers.
static fenv_t enter(void)
{
    fenv_t before;
    (void)fegetenv(&before);
    (void)fesetenv(FE_DFL_ENV);
    return before;
}

static bool start(fmu_model_t *model)
{
    state_t *const now = &model->now;
    if (FMU_PART == PLANT)
    {
        now->is_started = make_plant(model);
        if (now->is_started)
        {
            read_plant(model);
        }
        return now->is_started;
    }
    now->is_started  = make(model, now->slot);
    now->row.learned = FMU_LEARNS ? &now->learned : NULL;
    return now->is_started;
}

bool fmu_model_start(fmu_model_t *model)
{
    const fenv_t before = enter();
    const bool   ok     = start(model);
    (void)fesetenv(&before);
    return ok;
}

/// Goes on with other values.
static bool change(fmu_model_t *model, const sim_config_t *next)
{
    state_t *const now    = &model->now;
    const unsigned old    = now->slot;
    const unsigned active = active_slot(now);
    unsigned       slot   = 0;
    while (slot == old || slot == active)
    {
        slot++;
    }
    now->config[slot] = *next;
    if (!make(model, slot))
    {
        return false;
    }
    now->slot = slot;
    remember(model, &now->loop[old]);
    return true;
}

static double *input_of(fmu_model_t *model, unsigned variable)
{
    const char      *name = variable >= FMU_COLUMNS && variable < FMU_COLUMNS + SIM_COLUMNS_MAX
                                ? sim_columns[variable - FMU_COLUMNS].name
                                : "";
    sim_row_t *const row  = &model->now.row;
    if (FMU_PART != LOOP)
    {
        return strcmp(name, "u_N") == 0 ? &row->u_n : NULL;
    }
    return strcmp(name, "r_N") == 0 ? &row->r_n : strcmp(name, "y_N") == 0 ? &row->y_n : NULL;
}

static bool check(fmu_model_t *model, unsigned variable, double value)
{
    common_place_t place;
    if (input_of(model, variable) != NULL)
    {
        // A loop takes anything and counts what is bad.
        return FMU_PART != PLANT || isfinite(value) || common_error_set(&model->error, "u_N: %g is not finite", value);
    }
    if (variable >= COUNT)
    {
        return common_error_set(&model->error, "variable %u cannot be set", variable);
    }
    const char *name = values[variable].key;
    if (FMU_PART == PLANT && model->now.is_started)
    {
        return common_error_set(&model->error, "%s: cannot be set once the plant has started", name);
    }
    (void)common_key_find(sim_keys, model->now.config, name, &place);
    const common_key_t *key = place.key;
    return (value >= key->min && value <= key->max) ||
           common_error_set(&model->error, "%s: %g is outside %g to %g", name, value, key->min, key->max);
}

static bool set(fmu_model_t *model, const unsigned *variables, size_t count, const double *numbers)
{
    state_t *const now       = &model->now;
    bool           is_change = false;
    for (size_t i = 0; i < count; i++)
    {
        if (!check(model, variables[i], numbers[i]))
        {
            return false;
        }
        is_change = is_change || variables[i] < FMU_COLUMNS;
    }
    if (is_change)
    {
        sim_config_t next = now->config[now->slot];
        for (size_t i = 0; i < count; i++)
        {
            if (variables[i] < FMU_COLUMNS)
            {
                put(&next, values[variables[i]].key, numbers[i], (uint64_t)numbers[i]);
            }
        }
        if (!now->is_started)
        {
            now->config[now->slot] = next;
        }
        else if (!change(model, &next))
        {
            return false;
        }
    }
    for (size_t i = 0; i < count; i++)
    {
        double *const input = input_of(model, variables[i]);
        if (input != NULL)
        {
            *input = numbers[i];
        }
    }
    return true;
}

bool fmu_model_set(fmu_model_t *model, const unsigned *variables, size_t count, const double *numbers)
{
    const fenv_t before = enter();
    const bool   ok     = set(model, variables, count, numbers);
    (void)fesetenv(&before);
    return ok;
}

bool fmu_model_get(fmu_model_t *model, unsigned variable, double *value)
{
    const state_t *const now = &model->now;
    double               of[SIM_COLUMNS_MAX];
    common_place_t       place;
    if (variable >= FMU_COLUMNS)
    {
        const unsigned column = variable - FMU_COLUMNS;
        if (column >= sim_column_values(&now->row, of))
        {
            return common_error_set(&model->error, "there is no variable %u", variable);
        }
        // u in Q31 has more digits than a column.
        *value = strcmp(sim_columns[column].name, "u_N") == 0 ? now->row.u_n : of[column];
        return true;
    }
    if (variable >= COUNT)
    {
        return common_error_set(&model->error, "there is no variable %u", variable);
    }
    (void)common_key_find(sim_keys, (void *)&now->config[now->slot], values[variable].key, &place);
    if (place.key->type == COMMON_KEY_OPTIONAL)
    {
        common_optional_t optional;
        memcpy(&optional, place.at, sizeof optional);
        *value = optional.is_given ? optional.value : values[variable].number;
    }
    else
    {
        memcpy(value, place.at, sizeof *value);
    }
    return true;
}

static bool tick_plant(fmu_model_t *model)
{
    state_t *const      now   = &model->now;
    const unsigned      steps = sim_plant_steps(&now->config[0]);
    sim_plant_signals_t later;
    for (unsigned step = 0; step < steps; step++)
    {
        sim_sensor_push(&model->sensor, sim_plant_filtered_force(model->plant));
        sim_plant_step(model->plant, now->row.u_n, step == 0 ? &now->row.plant : &later);
    }
    read_plant(model);
    return isfinite(now->row.force_n) || common_error_set(&model->error, "the simulated plant diverges");
}

static void tick_compensator(state_t *now)
{
    sim_loop_f32_t *loop = &now->loop[now->slot].in_f32;
    (void)tribo_compensator_f32_step(&loop->params.compensator,
                                     &loop->state.compensator,
                                     (float)now->row.u_n,
                                     &now->row.loop.compensator);
}

static void tick_loop(state_t *now)
{
    now->row.u_n = sim_loop_step(&now->loop[now->slot], now->row.r_n, now->row.y_n, &now->row.loop);
    if (now->row.learned != NULL)
    {
        now->learned = sim_loop_learned(&now->loop[now->slot], now->row.r_n);
    }
}

void fmu_model_set_time(fmu_model_t *model, double t_s)
{
    model->now.row.t_s = t_s;
}

static bool play(fmu_model_t *model, double t_s, double step_s)
{
    const double sample_time_s = model->now.config[model->now.slot].loop.sample_time_s;
    const double ticks         = round(step_s / sample_time_s);
    if (!(ticks >= 1.0 && fabs(step_s - ticks * sample_time_s) <= 1e-6 * sample_time_s))
    {
        return common_error_set(&model->error,
                                "communication step: %g s is not a multiple of sample_time_s, %g s",
                                step_s,
                                sample_time_s);
    }
    for (double i = 0.0; i < ticks; i += 1.0)
    {
        if (FMU_PART == LOOP)
        {
            tick_loop(&model->now);
        }
        else if (FMU_PART == COMPENSATOR)
        {
            tick_compensator(&model->now);
        }
        else if (!tick_plant(model))
        {
            return false;
        }
    }
    fmu_model_set_time(model, t_s + step_s);
    return true;
}

bool fmu_model_step(fmu_model_t *model, double t_s, double step_s)
{
    const fenv_t before = enter();
    const bool   ok     = play(model, t_s, step_s);
    (void)fesetenv(&before);
    return ok;
}

static size_t line_size(const fmu_model_t *model)
{
    return model->sensor.length * sizeof *model->sensor.line;
}

static size_t plant_size(const fmu_model_t *model)
{
    return model->plant != NULL ? sizeof model->sensor + line_size(model) + sim_plant_size(model->plant) : 0;
}

/// memcpy for what may be nothing.
static void copy(void *to, const void *from, size_t size)
{
    if (size > 0)
    {
        memcpy(to, from, size);
    }
}

size_t fmu_model_size(const fmu_model_t *model)
{
    return sizeof(state_t) + plant_size(model);
}

void fmu_model_save(const fmu_model_t *model, void *bytes)
{
    state_t saved = model->now;
    saved.active  = active_slot(&model->now);
    memcpy(bytes, &saved, sizeof saved);
    if (model->plant != NULL)
    {
        char *to = (char *)bytes + sizeof saved;
        memcpy(to, &model->sensor, sizeof model->sensor);
        copy(to + sizeof model->sensor, model->sensor.line, line_size(model));
        sim_plant_save(model->plant, to + sizeof model->sensor + line_size(model));
    }
}

/// Of a state_t that is the model's already.
static bool load_plant(fmu_model_t *model, const char *from, size_t size)
{
    if (!make_plant(model))
    {
        return false;
    }
    if (size != plant_size(model))
    {
        return common_error_set(&model->error, "state: %zu bytes of a plant, not %zu", size, plant_size(model));
    }
    sim_sensor_t sensor;
    memcpy(&sensor, from, sizeof sensor);
    sensor.line   = model->sensor.line;
    model->sensor = sensor;
    copy(sensor.line, from + sizeof sensor, line_size(model));
    sim_plant_load(model->plant, from + sizeof sensor + line_size(model));
    return true;
}

bool fmu_model_load(fmu_model_t *model, const void *bytes, size_t size)
{
    state_t *const now = &model->now;
    state_t        saved;
    if (size < sizeof saved || (FMU_PART != PLANT && size != sizeof saved))
    {
        return common_error_set(&model->error, "state: %zu bytes, not %zu", size, sizeof saved);
    }
    memcpy(&saved, bytes, sizeof saved);
    *now             = saved;
    now->row.learned = FMU_LEARNS ? &now->learned : NULL;
    if (!saved.is_started)
    {
        drop_plant(model);
        return true;
    }
    if (FMU_PART == PLANT)
    {
        return load_plant(model, (const char *)bytes + sizeof saved, size - sizeof saved);
    }
    // Pointers are of the model that was saved.
    for (unsigned slot = 0; slot < SLOTS; slot++)
    {
        if (slot == saved.slot || slot == saved.active)
        {
            (void)make(model, slot); // as it was made before
        }
    }
    remember(model, &saved.loop[saved.slot]);
    if (FMU_Q31)
    {
        tribo_force_loop_q31_state_t *state = &now->loop[now->slot].in_q31.state;
        state->active                       = saved.active < SLOTS ? &now->loop[saved.active].in_q31.params : NULL;
        state->active_seal                  = ~(uintptr_t)state->active;
    }
    else
    {
        tribo_force_loop_f32_state_t *state = &now->loop[now->slot].in_f32.state;
        state->active                       = saved.active < SLOTS ? &now->loop[saved.active].in_f32.params : NULL;
        state->active_seal                  = ~(uintptr_t)state->active;
    }
    return true;
}
