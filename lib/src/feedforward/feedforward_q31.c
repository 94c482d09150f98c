#include "tribo/feedforward_q31.h"

#include "tribo/feedforward_f32.h"

#include "../number/fixed_q31.h"
#include "../number/ranges.h"
#include "bank_q31.h"
#include "constants.h"
#include "feedback.h"
#include "learning_q31.h"

#include <stddef.h>

#define STEP_MAX 0.0078125f // of FS: the rate in Q37

/// Ranges that are narrower than in f32.
static tribo_status_t check(const tribo_feedforward_f32_params_t *f32, float full_scale_n)
{
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    if (!within(f32->input_max_n / full_scale_n, FIXED_Q31_SMALLEST, 1.0f))
    {
        return TRIBO_ERR_INPUT_MAX;
    }
    if (!fits(f32->reversal_n, full_scale_n))
    {
        return TRIBO_ERR_REVERSAL_WIDTH;
    }
    if (!within(1.0f / f32->stop_per_n[TRIBO_FEEDFORWARD_STOPS - 1u] / full_scale_n, 1.0e-4f, 0.25f))
    {
        return TRIBO_ERR_PRESLIDING;
    }
    if (!(f32->lag_s * f32->rate_hz < 65536.0f))
    {
        return TRIBO_ERR_ACTUATOR_POLE;
    }
    if (!(f32->damping < 32768.0f))
    {
        return TRIBO_ERR_DAMPING;
    }
    return f32->forgetting_per_n * full_scale_n < 32.0f ? TRIBO_OK : TRIBO_ERR_FORGETTING;
}

/// x of Q32 times 2^shift, for x from 0, with the least shift that fits.
static uint32_t with_shift(float x, uint8_t *shift)
{
    *shift = 0;
    while (scaled(x, -(int32_t)*shift) >= 1.0f)
    {
        (*shift)++;
    }
    return fixed_unsigned(x, 32 - (int32_t)*shift);
}

/// A force in units, at least 1 and at most FS.
static int32_t force(float force_n, float full_scale_n)
{
    const int32_t x = units(force_n < full_scale_n ? force_n : full_scale_n, full_scale_n);
    return x > 0 ? x : 1;
}

/// A number per newton as one per unit of `bits`.
static uint32_t per_unit(float per_n, float full_scale_n, int32_t bits)
{
    return fixed_unsigned(per_n * full_scale_n, bits - 29);
}

/// Checked params of the twin in fixed point.
static void convert(tribo_feedforward_q31_params_t *made, const tribo_feedforward_f32_params_t *f32, float FS)
{
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        made->stop_per_unit[j] = fixed_unsigned(f32->stop_per_n[j] * FS, 10);
    }
    made->input_max  = (uint32_t)fixed_input_max(f32->input_max_n, FS);
    made->offset_max = force(f32->offset_max_n, FS);
    made->reversal   = (uint32_t)force(f32->reversal_n, FS);
    made->jump = f32->jump < 2.0f ? fixed(f32->jump, 29) + 1 : INT32_C(1) << 30; // rounded up: the ramp ends in time
    made->lead = fixed_unsigned(f32->lead, 16);
    made->distrust    = fixed_unsigned(f32->distrust, 32);
    made->lag         = with_shift(f32->lag_s * f32->rate_hz / 256.0f, &made->lag_shift); // the rate is 256 times finer
    made->noise_part  = fixed_unsigned(f32->noise_part, 32);
    made->noise_floor = fixed_unsigned(f32->noise_floor_n / FS, 37);
    made->rate_part   = fixed_unsigned(f32->rate_part, 32);
    made->step        = force(f32->step_n < STEP_MAX * FS ? f32->step_n : STEP_MAX * FS, FS);
    made->lag_part    = fixed_unsigned(f32->lag_part, 32);
    made->actuator_part       = fixed_unsigned(f32->actuator_part, 32);
    made->sensor_part         = fixed_unsigned(f32->sensor_part, 32);
    made->observer_part       = fixed_unsigned(f32->observer_part, 32);
    made->damping             = with_shift(f32->damping, &made->damping_shift);
    made->jump_lag            = fixed_unsigned(f32->jump_lag, 16);
    made->measured_per_unit   = fixed_unsigned(f32->measured_per_n * FS, 10);
    made->travel_half         = (uint32_t)force(f32->travel_half_n, FS);
    made->slip                = (uint32_t)force(f32->slip_n, FS);
    made->travel_max          = (uint32_t)force(f32->travel_max_n, FS);
    made->weighing            = (uint32_t)force(f32->weighing_n, FS);
    made->doubt_per_unit      = per_unit(f32->doubt_per_n, FS, 40);
    made->margin_per_unit     = per_unit(f32->margin_per_n, FS, 40);
    made->forgetting_per_unit = per_unit(f32->forgetting_per_n, FS, 56);
    made->constant_sd         = (uint32_t)force(f32->constant_sd_n, FS);
    made->constant_max        = force(f32->constant_max_n, FS);
    made->still_ticks         = f32->still_ticks;
    made->quick_ticks         = f32->quick_ticks;
    made->deadband_part       = fixed_unsigned(f32->deadband_part, 32);
    made->effort_part         = fixed_unsigned(f32->effort_part, 32);
    made->effort_half         = (uint32_t)force(f32->effort_half_n, FS);
}

tribo_status_t tribo_feedforward_q31_init(tribo_feedforward_q31_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_arm_f32_config_t         *arm,
                                          const tribo_friction_f32_params_t    *friction,
                                          float                                 input_max_n,
                                          float                                 usual_force_n,
                                          float                                 sample_time_s,
                                          float                                 full_scale_n)
{
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_feedforward_f32_params_t f32;

    tribo_status_t status =
        tribo_feedforward_f32_init(&f32, config, arm, friction, input_max_n, usual_force_n, sample_time_s);
    if (status == TRIBO_OK)
    {
        status = check(&f32, full_scale_n);
    }
    if (status != TRIBO_OK)
    {
        return status;
    }
    tribo_feedforward_q31_params_t made = {.reversal = 0};
    convert(&made, &f32, full_scale_n);
    *params = made;
    return TRIBO_OK;
}

void tribo_feedforward_q31_reset(tribo_feedforward_q31_state_t *state)
{
    *state = (tribo_feedforward_q31_state_t){.mode = TRIBO_FEEDFORWARD_RESTART};
    learning_q31_forget(&state->learned);
}

tribo_feedforward_q31_learned_t tribo_feedforward_q31_learned(const tribo_friction_q31_params_t   *friction,
                                                              const tribo_feedforward_q31_state_t *state,
                                                              uint32_t                             direction,
                                                              int32_t                              force)
{
    const tribo_feedforward_weights_q31_t *const learned = &state->learned;

    const int32_t          at    = bank_q31_inside(force);
    const bank_q31_prior_t prior = bank_q31_prior(friction, at);
    const int32_t load  = bank_q31_both(&prior, bank_q31_load(learned, at)) + bank_q31_inside(friction->gravity);
    const int32_t V     = learned->weight[0];
    const int32_t L     = bank_q31_times(V, prior.L, 29, (uint32_t)BANK_Q31_ONE);
    const int32_t least = part_of_q31(L, BANK_Q31_Q32(FEEDFORWARD_LEARNED_MIN));
    const int32_t sign  = (direction & 1u) == TRIBO_BREAKAWAY_POSITIVE ? 1 : -1;
    const int32_t known = L + sign * load;
    return (tribo_feedforward_q31_learned_t){
        .L                 = (uint32_t)limit_q31(known, least, BANK_Q31_ONE - 1),
        .relative_variance = learning_q31_relative_variance(learned, &state->learning, sign),
        .travel            = learned->travel,
        .at_bound          = V <= BANK_Q31_Q29(FEEDFORWARD_WEIGHT_LOW) || V >= BANK_Q31_Q29(FEEDFORWARD_WEIGHT_MAX),
        .stays_at_bound    = tribo_feedforward_stays_at_bound(state->at_bound),
        .harms             = state->monitor.feedback.harms != 0u,
        .forgotten         = state->forgotten};
}

void tribo_feedforward_q31_restore(tribo_feedforward_q31_state_t *state)
{
    state->at_bound      = 0;
    state->monitor.ratio = 0;
    feedback_restore(&state->monitor.feedback);
}

void tribo_force_loop_feedforward_q31_attach(tribo_force_loop_q31_state_t   *state,
                                             tribo_feedforward_q31_memory_t *memory)
{
    state->memory      = memory;
    state->memory_seal = ~(uintptr_t)memory;
    if (memory != NULL)
    {
        memory->signals    = (tribo_feedforward_q31_signals_t){.e = 0};
        memory->state.mode = TRIBO_FEEDFORWARD_RESTART;
        memory->state.tick = (tribo_force_loop_q31_tick_t){.has_e = false};
        memory->motion     = (tribo_feedforward_q31_motion_t){.sign = 0};
    }
}
