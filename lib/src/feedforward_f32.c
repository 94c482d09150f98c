#include "tribo/feedforward_f32.h"

#include "feedforward_f32_step.h"

tribo_feedforward_f32_config_t tribo_feedforward_f32_default(void)
{
    const tribo_path_f32_config_t        path     = tribo_path_f32_paper();
    const tribo_feedforward_f32_config_t standard = {.actuator_pole_rad_per_s = path.actuator_pole_rad_per_s,
                                                     .sensor_pole_rad_per_s   = path.sensor_pole_rad_per_s,
                                                     .reversal_n              = 0.5e-3f,
                                                     .jump_time_s             = 0.02f,
                                                     .lead                    = 1.0f,
                                                     .noise_gain              = 4.0f,
                                                     .noise_time_s            = 0.25f,
                                                     .rate_time_s             = 0.01f,
                                                     .rate_max_n_per_s        = 2.0f,
                                                     .offset_time_s           = 5.0f,
                                                     .slide_width_n           = 3.0e-3f,
                                                     .slide_filter_time_s     = 0.02f,
                                                     .slide_rate_max_n_per_s  = 0.5f,
                                                     .slide_run_in_n          = 5.0e-3f,
                                                     .slide_error_max_n       = 1.0e-3f,
                                                     .learning                = tribo_breakaway_learning_f32_default(),
                                                     .hold                    = tribo_hold_f32_default()};
    return standard;
}

/// A field of the config, what it must be within, and the status that names it.
typedef struct
{
    float          value, min, max;
    tribo_status_t status;
} field_t;

static tribo_status_t check(const tribo_feedforward_f32_config_t *c)
{
    const field_t field[] = {
        {c->reversal_n, 1.0e-9f, TRIBO_F32_FORCE_MAX_N, TRIBO_ERR_REVERSAL_WIDTH},
        {c->jump_time_s, 1.0e-6f, 1.0e3f, TRIBO_ERR_JUMP_TIME},
        {c->lead, 0.0f, 1.0f, TRIBO_ERR_LEAD},
        {c->noise_gain, 0.0f, 8.0f, TRIBO_ERR_REFERENCE_NOISE},
        {c->noise_time_s, 1.0e-6f, 1.0e3f, TRIBO_ERR_REFERENCE_NOISE},
        {c->rate_time_s, 1.0e-6f, 1.0e3f, TRIBO_ERR_REFERENCE_RATE},
        {c->rate_max_n_per_s, 1.0e-6f, 1.0e9f, TRIBO_ERR_REFERENCE_RATE},
        {c->offset_time_s, 1.0e-6f, 1.0e3f, TRIBO_ERR_OFFSET_TIME},
        {c->slide_width_n, 1.0e-9f, TRIBO_F32_FORCE_MAX_N, TRIBO_ERR_SLIDE_WIDTH},
        {c->slide_rate_max_n_per_s, 1.0e-6f, 1.0e9f, TRIBO_ERR_SLIDE_RATE},
        {c->slide_run_in_n, 1.0e-9f, TRIBO_F32_FORCE_MAX_N, TRIBO_ERR_SLIDE_RUN_IN},
        {c->slide_error_max_n, 1.0e-9f, TRIBO_F32_FORCE_MAX_N, TRIBO_ERR_SLIDE_ERROR},
    };
    for (uint32_t i = 0; i < sizeof field / sizeof field[0]; i++)
    {
        if (!within(field[i].value, field[i].min, field[i].max))
        {
            return field[i].status;
        }
    }
    return TRIBO_OK;
}

tribo_status_t tribo_feedforward_f32_init(tribo_feedforward_f32_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_compensator_f32_config_t *model,
                                          float                                 input_max_n,
                                          float                                 sample_time_s)
{
    if (params == NULL || config == NULL || model == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    const tribo_path_f32_config_t path = {.actuator_pole_rad_per_s = config->actuator_pole_rad_per_s,
                                          .sensor_pole_rad_per_s   = config->sensor_pole_rad_per_s,
                                          .arm                     = model->arm};

    tribo_feedforward_f32_params_t made   = {.input_max_n = input_max_n};
    tribo_status_t                 status = tribo_path_f32_init(&made.path, &path, sample_time_s);
    if (status == TRIBO_OK)
    {
        status = tribo_friction_meter_f32_init(&made.meter, &path, config->slide_filter_time_s, sample_time_s);
    }
    if (status == TRIBO_OK)
    {
        status = check(config);
    }
    if (status == TRIBO_OK)
    {
        status = tribo_breakaway_learning_f32_init(&made.learning, &config->learning);
    }
    if (status == TRIBO_OK)
    {
        status = tribo_hold_f32_init(&made.hold, &config->hold, sample_time_s);
    }
    if (status == TRIBO_OK && !within(input_max_n, FLT_MIN, TRIBO_F32_FORCE_MAX_N))
    {
        status = TRIBO_ERR_INPUT_MAX;
    }
    if (status != TRIBO_OK)
    {
        return status;
    }
    const float lag         = 1.0f / path.actuator_pole_rad_per_s + path.arm.damping / path.arm.stiffness;
    made.offset_max_n       = 4.0f * input_max_n;
    made.reversal_n         = config->reversal_n;
    made.jump               = limit_f32(2.0f * sample_time_s / config->jump_time_s, 0.0f, 2.0f);
    made.lead_s             = config->lead * lag;
    made.noise_gain         = config->noise_gain;
    made.noise_part         = limit_f32(sample_time_s / config->noise_time_s, 0.0f, 1.0f);
    made.noise_floor_n      = 0.002f * config->reversal_n;
    made.rate_hz            = 1.0f / sample_time_s;
    made.rate_part          = first_order_f32_lag(config->rate_time_s, sample_time_s);
    made.step_n             = config->rate_max_n_per_s * sample_time_s;
    made.offset_part        = limit_f32(sample_time_s / config->offset_time_s, 0.0f, 1.0f);
    made.slide_half_n       = 0.5f * config->slide_width_n;
    made.slide_change_max_n = config->slide_rate_max_n_per_s * sample_time_s;
    made.slide_run_in_n     = config->slide_run_in_n;
    made.slide_error_max_n  = config->slide_error_max_n;
    *params                 = made;
    return TRIBO_OK;
}

void tribo_feedforward_f32_reset(const tribo_feedforward_f32_params_t *params, tribo_feedforward_f32_state_t *state)
{
    state->r_n[0] = 0.0f;
    tribo_friction_meter_f32_reset(&state->meter, 0.0f);
    state->share      = 1.0f;
    state->bad_inputs = 0;
    tribo_breakaway_learning_f32_reset(&params->learning, &state->learning);
    state->side = 1.0f;
    tribo_hold_f32_reset(&state->hold, 0.0f);
    tribo_feedforward_f32_restart(state);
}

void tribo_feedforward_f32_restart(tribo_feedforward_f32_state_t *state)
{
    state->running  = false;
    state->entering = false;
    state->entry_n  = 0.0f;
}

void tribo_feedforward_f32_enter(tribo_feedforward_f32_state_t *state, float added_n)
{
    state->running  = false;
    state->entering = true;
    state->entry_n  = exceeds(added_n, TRIBO_F32_FORCE_MAX_N) ? 0.0f : added_n;
}

float tribo_feedforward_f32_before(const tribo_feedforward_f32_params_t *params,
                                   const tribo_friction_f32_params_t    *friction,
                                   tribo_feedforward_f32_state_t        *state,
                                   float                                 r_n,
                                   float                                 y_n,
                                   tribo_feedforward_f32_signals_t      *signals)
{
    return feedforward_f32_before(params, friction, state, r_n, y_n, signals);
}

float tribo_feedforward_f32_added(const tribo_feedforward_f32_params_t *params,
                                  tribo_feedforward_f32_state_t        *state,
                                  float                                 v_n,
                                  tribo_feedforward_f32_signals_t      *signals)
{
    return feedforward_f32_added(params, state, exceeds(v_n, FLT_MAX) ? 0.0f : v_n, signals);
}

void tribo_feedforward_f32_after(const tribo_feedforward_f32_params_t *params,
                                 const tribo_friction_f32_params_t    *friction,
                                 tribo_feedforward_f32_state_t        *state,
                                 float                                 v_n,
                                 float                                 u_n,
                                 bool                                  limited,
                                 tribo_feedforward_f32_signals_t      *signals)
{
    if (exceeds(u_n, TRIBO_F32_FORCE_MAX_N) || exceeds(v_n, FLT_MAX))
    {
        signals->travel_n = 0.0f;
        signals->meter    = (tribo_friction_meter_f32_signals_t){.friction_n = 0.0f};
        return;
    }
    feedforward_f32_after(params, friction, state, v_n, u_n, limited, signals);
}

tribo_feedforward_f32_learned_t tribo_feedforward_f32_learned(const tribo_feedforward_f32_params_t *params,
                                                              const tribo_friction_f32_params_t    *friction,
                                                              const tribo_feedforward_f32_state_t  *state,
                                                              uint32_t                              direction,
                                                              float                                 force_n)
{
    const float    force = exceeds(force_n, TRIBO_F32_FORCE_MAX_N) ? 0.0f : force_n;
    const uint32_t side  = direction & 1u;
    const float    prior = feedforward_f32_prior(friction, side, force);

    tribo_breakaway_learning_f32_state_t learning = state->learning;
    if (force * state->side < 0.0f)
    {
        tribo_breakaway_learning_f32_change_side(&params->learning, &learning); // as r would
    }
    const tribo_breakaway_learning_f32_signals_t known =
        tribo_breakaway_learning_f32_at(&params->learning, &learning, side, prior);
    return (tribo_feedforward_f32_learned_t){
        .L_n            = known.L_n,
        .doubt          = known.doubt,
        .travel_n       = learning.travel_n[side] + learning.across.travel_n[side],
        .at_bound       = tribo_breakaway_learning_f32_is_at_bound(&params->learning, &learning, side, prior),
        .stays_at_bound = state->learning.stays_at_bound[side] != 0};
}
