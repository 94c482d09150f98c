#include "tribo/feedforward_q31.h"

#include "tribo/feedforward_f32.h"

#include "../number/fixed_q31.h"
#include "../number/ranges.h"
#include "words_q31.h"

#include "reference.h"

#define STEP_MAX 0.0078125f // in FS, the range of finer()

/// Checks the ranges that are narrower in Q31 than in float.
static tribo_status_t check(const tribo_feedforward_f32_params_t *f32, float full_scale_n)
{
    if (!full_scale_ok(full_scale_n))
    {
        return TRIBO_ERR_FULL_SCALE;
    }
    if (!within(f32->input_max / full_scale_n, FIXED_Q31_SMALLEST, 1.0f))
    {
        return TRIBO_ERR_INPUT_MAX;
    }
    if (!fits(f32->reversal, full_scale_n))
    {
        return TRIBO_ERR_REVERSAL_WIDTH;
    }
    if (!within(1.0f / f32->stop_gain[TRIBO_FEEDFORWARD_STOPS - 1u] / full_scale_n, 1.0e-4f, 0.25f))
    {
        return TRIBO_ERR_PRESLIDING;
    }
    if (!(f32->lag_gain < 65536.0f))
    {
        return TRIBO_ERR_ACTUATOR_POLE;
    }
    return f32->damping_gain < 32768.0f ? TRIBO_OK : TRIBO_ERR_DAMPING;
}

/// A force in Q29 of FS, limited to 1 unit and FS.
static int32_t force(float force_n, float full_scale_n)
{
    const int32_t x = units(force_n < full_scale_n ? force_n : full_scale_n, full_scale_n);
    return x > 0 ? x : 1;
}

/// A gain in Q16, up to 65536.
static uint32_t gain(float x)
{
    return fixed_unsigned(x, 16);
}

static uint32_t part(float x)
{
    return fixed_unsigned(x, 32);
}

/// Converts checked params of tribo_feedforward_f32_init to fixed point.
static void convert(tribo_feedforward_q31_params_t *made, const tribo_feedforward_f32_params_t *f32, float FS)
{
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        made->stop_gain[j] = gain(f32->stop_gain[j] * FS);
    }
    made->input_max  = fixed_input_max(f32->input_max, FS);
    made->offset_max = force(f32->offset_max, FS);
    made->reversal   = force(f32->reversal, FS);
    made->jump =
        f32->jump < 2.0f ? fixed(f32->jump, 29) + 1 : INT32_C(1) << 30; // rounded up, so that the ramp ends in time
    made->lead_gain     = gain(f32->lead_gain);
    made->lag_gain      = gain(f32->lag_gain / 64.0f); // the rate is 64 times finer
    made->damping_gain  = gain(f32->damping_gain);
    made->step          = force(f32->step < STEP_MAX * FS ? f32->step : STEP_MAX * FS, FS);
    made->noise_floor   = fixed(f32->noise_floor / FS, 35);
    made->noise_part    = part(f32->noise_part);
    made->slow_part     = part(f32->slow_part);
    made->fast_part     = part(f32->fast_part);
    made->lag_part      = part(f32->lag_part);
    made->actuator_part = part(f32->actuator_part);
    made->sensor_part   = part(f32->sensor_part);
    made->leak_part     = part(f32->leak_part);
    made->trust         = part(f32->trust);
    made->still_ticks   = f32->still_ticks;
    made->quick_ticks   = f32->quick_ticks;

    made->learning        = f32->learning;
    made->learning.unit_n = FS / 536870912.0f;
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
    status = status == TRIBO_OK ? check(&f32, full_scale_n) : status;
    if (status == TRIBO_OK)
    {
        *params = (tribo_feedforward_q31_params_t){.reversal = 0};
        convert(params, &f32, full_scale_n);
    }
    return status;
}

static tribo_status_t init_for(params_t                             *params,
                               const tribo_feedforward_f32_config_t *config,
                               const tribo_force_loop_f32_config_t  *loop,
                               float                                 full_scale_n,
                               const loop_params_t                  *made)
{
    tribo_friction_f32_params_t friction;
    (void)made; // has no friction in newtons
    (void)tribo_friction_f32_init(&friction,
                                  &loop->compensator.friction,
                                  loop->sample_time_s); // cannot fail: the loop's init has accepted it
    return tribo_feedforward_q31_init(params,
                                      config,
                                      &loop->compensator.arm,
                                      &friction,
                                      loop->input_max_n,
                                      tribo_force_loop_f32_usual_force_n(loop),
                                      loop->sample_time_s,
                                      full_scale_n);
}

#include "make.h"
