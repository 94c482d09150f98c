#include "app/faults.h"

#include "app/scaling.h"

static uint32_t ticks_of(uint32_t ms, uint32_t period_us)
{
    return ms == 0u ? 0u : (ms * 1000u + period_us - 1u) / period_us;
}

void faults_init(faults_bounds_t *bounds, const drive_config_t *config)
{
    *bounds = (faults_bounds_t){.residual            = scaling_number(config->residual_n, config->full_scale_n),
                                .tare_max            = scaling_number(config->tare_max_n, config->full_scale_n),
                                .residual_ticks      = ticks_of(config->residual_ms, config->period_us),
                                .command_limit_ticks = ticks_of(config->command_limit_ms, config->period_us),
                                .reference_ticks     = ticks_of(config->reference_ms, config->period_us),
                                .ready_ticks         = ticks_of(config->ready_ms, config->period_us)};
    if (config->residual_n > 0.0f && bounds->residual == 0)
    {
        bounds->residual = loop_from_word(1u); // the least, for 0 is off
    }
}

/// Counts ticks in a row with a condition; true beyond `bound`.
static bool lasts(uint32_t *ticks, bool condition, uint32_t bound)
{
    *ticks = condition ? *ticks + (*ticks != UINT32_MAX) : 0u;
    return bound > 0u && *ticks > bound;
}

static bool is_beyond(loop_force_t y, loop_force_t f_hat, loop_force_t bound)
{
#ifdef DRIVE_ARITH_Q31
    const int64_t difference = (int64_t)y - f_hat;
#else
    const float difference = y - f_hat;
#endif
    return difference > bound || difference < -bound;
}

bool faults_residual(const faults_bounds_t *bounds, faults_state_t *state, loop_force_t y, loop_force_t f_hat)
{
    const bool beyond = bounds->residual > 0 && is_beyond(y, f_hat, bounds->residual);
    return lasts(&state->residual, beyond, bounds->residual_ticks);
}

bool faults_command_limit(const faults_bounds_t *bounds, faults_state_t *state, bool limited)
{
    return lasts(&state->command_limit, limited, bounds->command_limit_ticks);
}

bool faults_reference(const faults_bounds_t *bounds, faults_state_t *state, bool renewed)
{
    return lasts(&state->reference, !renewed, bounds->reference_ticks);
}

bool faults_starting(const faults_bounds_t *bounds, faults_state_t *state)
{
    return lasts(&state->starting, true, bounds->ready_ticks);
}
