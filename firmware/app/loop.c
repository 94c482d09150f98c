#include "app/loop.h"

static tribo_point_t *table_of(loop_setup_t *setup)
{
#if TRIBO_IS_Q31
    return setup->table;
#else
    (void)setup;
    return NULL;
#endif
}

tribo_status_t loop_setup(loop_setup_t *setup, const tribo_force_loop_f32_config_t *config, float full_scale_n)
{
    return tribo_init_loop(&setup->params, table_of(setup), config, full_scale_n);
}

#if DRIVE_FEEDFORWARD
void loop_begin(loop_state_t *state, const loop_params_t *params, loop_memory_t *memory)
{
    state->memory = memory != NULL ? &memory->state.tick : NULL;
    (void)TRIBO(force_loop,
                start)(state, params, true); // fails without memory, which each tick then counts as a bad input
}

bool loop_has_sensor(const loop_params_t *params)
{
    return params->method == NULL || TRIBO(feedforward, of)(params) != NULL;
}

loop_widths_t loop_widths_per_unit(uint32_t units)
{
    return TRIBO_EITHER(1.0f / (float)units, (int32_t)(536870912u / units));
}

#if TRIBO_IS_Q31
static loop_widths_t widths_of(int32_t moved, loop_widths_t per_unit)
{
    const int64_t widths = (int64_t)moved * per_unit;
    return widths > INT32_MAX ? INT32_MAX : widths < -INT32_MAX ? -INT32_MAX : (int32_t)widths;
}
#else
static loop_widths_t widths_of(int32_t moved, loop_widths_t per_unit)
{
    return (float)moved * per_unit;
}
#endif

void loop_motion(loop_memory_t *memory, int32_t intended, int32_t measured, loop_widths_t per_unit)
{
    TRIBO(sensorless, motion)(memory, widths_of(intended, per_unit), widths_of(measured, per_unit));
}

void loop_forget(const loop_params_t *params, loop_memory_t *memory)
{
    if (params->method != NULL)
    {
        TRIBO(feedforward, reset)(&memory->state);
    }
}

bool loop_is_learning(const loop_memory_t *memory)
{
    return TRIBO(feedforward, is_learning)(&memory->state);
}

void loop_learn(const loop_params_t *params, loop_memory_t *memory)
{
    if (memory != NULL)
    {
        (void)TRIBO(feedforward, learn)(params, memory);
    }
}

tribo_feedforward_learned_t loop_learned(const loop_params_t *params,
                                         const loop_memory_t *memory,
                                         uint32_t             direction,
                                         loop_force_t         at)
{
    return TRIBO(feedforward, learned)(params, &memory->state, direction, at);
}

float loop_share(const loop_state_t *state)
{
    return (float)state->guard.fade * (1.0f / (float)TRIBO_ALL);
}
#else
// NOLINTBEGIN(readability-non-const-parameter): a loop with a feed-forward writes to `memory`
void loop_begin(loop_state_t *state, const loop_params_t *params, loop_memory_t *memory)
{
    (void)memory;
    (void)TRIBO(force_loop, start)(state, params, false); // cannot fail: the pointers are not null
}

void loop_motion(loop_memory_t *memory, int32_t intended, int32_t measured, loop_widths_t per_unit)
{
    (void)memory;
    (void)intended;
    (void)measured;
    (void)per_unit;
}

void loop_forget(const loop_params_t *params, loop_memory_t *memory)
{
    (void)params;
    (void)memory;
}

void loop_learn(const loop_params_t *params, loop_memory_t *memory)
{
    (void)params;
    (void)memory;
}
// NOLINTEND(readability-non-const-parameter)

bool loop_has_sensor(const loop_params_t *params)
{
    (void)params;
    return true;
}

loop_widths_t loop_widths_per_unit(uint32_t units)
{
    (void)units;
    return 0;
}
#endif
