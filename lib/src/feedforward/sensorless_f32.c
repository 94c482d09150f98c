// The feed-forward without a force sensor; docs/feedforward.md has its steps.

#include "tribo/feedforward_f32.h"

#include "../number/first_order_f32.h"
#include "../number/ranges.h"
#include "bank_f32.h"
#include "constants.h"
#include "effort_f32.h"
#include "state_f32.h"

#include <stddef.h>

#define ROW(...) PARAMETERS_ROW(tribo_sensorless_f32_config_t, __VA_ARGS__)
const tribo_parameter_t tribo_sensorless_parameters[] = {TRIBO_SENSORLESS_PARAMETERS(ROW)};
#undef ROW

/// The sign of the last motion beyond a width: `moves` of it through a play.
static int32_t push(float *slack, float moves)
{
    const float wanted = *slack + moves;
    *slack             = exceeds(wanted, FEEDFORWARD_FORCE_MAX_N) ? 0.0f : bound_f32(wanted, 0.5f);
    return exceeds(wanted, 0.5f) ? bank_f32_sign(wanted) : 0;
}

void tribo_sensorless_f32_motion(tribo_feedforward_f32_memory_t *memory, float intended, float measured)
{
    tribo_feedforward_f32_motion_t *const motion = &memory->motion;

    const int32_t first  = push(&motion->slack[0], intended);
    const int32_t second = push(&motion->slack[1], measured);
    const int32_t sign   = first != 0 || magnitude(intended) > 0.0f ? first : second; // at rest: the measured
    motion->sign         = (int8_t)(sign != 0 ? sign : motion->sign);
    motion->is_known     = 1;
    motion->measured     = measured;
}

/// What another loop's effort teaches. False: what was learned is corrupt.
static bool learn(const tribo_feedforward_f32_params_t *params,
                  tribo_feedforward_f32_memory_t       *memory,
                  const bank_f32_prior_t               *prior)
{
    tribo_feedforward_f32_motion_t *const        motion  = &memory->motion;
    const tribo_feedforward_weights_f32_t *const learned = &memory->state.learned;

    motion->was_known   = motion->was_known != 0u || motion->is_known != 0u;
    const bool is_sound = motion->was_known == 0u || learning_f32_fold_all(learned) == learned->seal;
    if (is_sound && motion->is_known != 0u)
    {
        effort_f32_step(params, memory, prior);
    }
    return is_sound;
}

/// The direction that friction opposes: that of rs, unless the motion is known in this tick.
static int8_t direction(tribo_feedforward_f32_memory_t *memory, int8_t before)
{
    if (memory->motion.is_known == 0u)
    {
        return memory->state.sign;
    }
    memory->motion.is_known = 0;
    return memory->motion.sign != 0 ? memory->motion.sign : before;
}

/// Step 6: friction of V, at `level` of the believed breakaway. b takes what V changes, from `V_before` on.
static void oppose(const tribo_feedforward_f32_params_t *params,
                   tribo_feedforward_f32_memory_t       *memory,
                   float                                 level,
                   float                                 V_before)
{
    tribo_feedforward_f32_state_t *const   state   = &memory->state;
    tribo_feedforward_f32_signals_t *const signals = &memory->signals;

    const float V      = effort_f32_weight(memory);
    const float before = state->sigma;
    const float left   = bound_f32((float)state->sign - before, params->jump);
    state->sigma       = bound_f32(before + left, 1.0f);
    signals->level_n   = level * V;
    signals->f_n       = signals->level_n * state->sigma;
    signals->lead_n    = params->lead * signals->level_n * (state->sigma - before);
    if (V != V_before)
    {
        state->offset_n += level * (V - V_before) * state->sigma;
    }
}

/// What the loop reads. The controller is taken out of u: in a change of params it goes on with an error of 0.
static void tell(tribo_feedforward_f32_state_t *state, float friction_n)
{
    state->tick.e_n        = 0.0f;
    state->tick.friction_n = friction_n;
    state->tick.has_e      = state->mode != TRIBO_FEEDFORWARD_RESTART;
    state->tick.has_y      = false;
}

static float method_error(const tribo_force_loop_f32_params_t *loop, void *memory, float r_n, float y_n, float fade)
{
    const tribo_feedforward_f32_params_t *const params  = state_f32_params(loop);
    tribo_feedforward_f32_memory_t *const       inner   = memory;
    tribo_feedforward_f32_state_t *const        state   = &inner->state;
    tribo_feedforward_f32_signals_t *const      signals = &inner->signals;

    const bool bad = exceeds(r_n, params->input_max_n);
    float      e   = 0.0f;
    if (!state_f32_runs(state))
    {
        if (bad)
        {
            state->offset_rule = TRIBO_FEEDFORWARD_KEEP;
            tell(state, 0.0f);
            return 0.0f;
        }
        // The term to go on from is for the controller's output at that error.
        const bool is_handed = state->offset_rule == TRIBO_FEEDFORWARD_CONTINUE;
        e                    = is_handed && !exceeds(y_n, params->input_max_n) ? r_n - y_n : 0.0f;
        state_f32_rest(state, r_n, r_n);
        effort_f32_start(inner, r_n);
    }
    state->noise_n     = bank_f32_noise(params, state->noise_n, bad ? state->r_n[0] : r_n, state->r_n);
    const float  noise = FEEDFORWARD_NOISE_GAIN * state->noise_n;
    const float  width = params->reversal_n + noise;
    const float  moved = bank_f32_reach(params, state, state->r_n[0]);
    const int8_t sign  = state->sign;
    bank_f32_turn(state, width);

    // A noisy r has no reliable rate; that of somebody else's effort is noise altogether.
    const float            rate  = inner->motion.is_known != 0u ? 0.0f : state->rate_n_s;
    const bank_f32_prior_t prior = bank_f32_prior(&loop->compensator.friction, state->reached_n);
    const float            ahead = params->lag_s * rate * (params->reversal_n / width);
    bank_f32_path(params, state, moved, ahead);

    const float V    = effort_f32_weight(inner);
    const bool  good = learn(params, inner, &prior);
    state->sign      = direction(inner, sign);
    oppose(params, inner, fade * (1.0f - params->distrust) * prior.L_n, V);
    signals->e_n       = e;
    signals->reached_n = state->reached_n;
    signals->lin_n     = state->reached_n + ahead + prior.load_n;
    if (!good || exceeds(signals->lin_n + signals->f_n + state->offset_n + state->behind_n[0], FEEDFORWARD_FORCE_MAX_N))
    {
        state_f32_forget(params, state);
        tell(state, 0.0f);
        return 0.0f;
    }
    tell(state, signals->f_n);
    return e;
}

// v is 0, or what the controller had when it was taken off.
static float method_term(const tribo_force_loop_f32_params_t *loop, void *memory, float v_n)
{
    const tribo_feedforward_f32_params_t *const params  = state_f32_params(loop);
    tribo_feedforward_f32_memory_t *const       inner   = memory;
    tribo_feedforward_f32_state_t *const        state   = &inner->state;
    tribo_feedforward_f32_signals_t *const      signals = &inner->signals;
    if (!state_f32_runs(state))
    {
        return state->mode == TRIBO_FEEDFORWARD_ENTER ? state->tick.term_n : 0.0f;
    }
    const tribo_controller_f32_params_t *const limits = &loop->controller;

    const bool  takes_over = state->offset_rule == TRIBO_FEEDFORWARD_TAKE_OVER;
    const float wanted     = signals->lin_n + signals->f_n;
    const float b          = takes_over ? wanted - (v_n + state->tick.term_n)
                                        : first_order_f32_step(state->offset_n, 0.0f, params->noise_part);
    state->offset_rule     = TRIBO_FEEDFORWARD_KEEP;
    state->offset_n        = bound_f32(b, params->offset_max_n);
    const float sum        = wanted + signals->lead_n - state->offset_n;
    const float u          = limit_f32(sum, limits->u_min_n, limits->u_max_n); // here: the controller shall not wind up
    state->limited         = (int8_t)bank_f32_sign(sum - u);
    state->tick.term_n     = limit_f32(wanted - state->offset_n, limits->u_min_n, limits->u_max_n) - v_n;
    signals->b_n           = state->offset_n;
    signals->term_n        = u - v_n;
    return signals->term_n;
}

static void method_after(const tribo_force_loop_f32_params_t *loop,
                         void                                *memory,
                         float                                v_n,
                         float                                u_n,
                         tribo_force_loop_f32_signals_t      *seen)
{
    tribo_feedforward_f32_memory_t *const  inner   = memory;
    tribo_feedforward_f32_state_t *const   state   = &inner->state;
    tribo_feedforward_f32_signals_t *const signals = &inner->signals;
    (void)v_n;
    if (!state_f32_runs(state))
    {
        return;
    }
    const tribo_feedforward_f32_params_t *const params = state_f32_params(loop);

    const float actuator       = first_order_f32_step(state->observer.actuator_n, u_n, params->actuator_part);
    state->observer.actuator_n = exceeds(actuator, FEEDFORWARD_FORCE_MAX_N) ? u_n : actuator;
    seen->controller.limited   = state->limited != 0;
    state_f32_show(seen, u_n, signals->reached_n + state->behind_n[0], signals->level_n, signals->f_n);
}

static void method_enter(void *memory, float term_n, bool anew)
{
    tribo_feedforward_f32_state_t *const state = &((tribo_feedforward_f32_memory_t *)memory)->state;
    state_f32_enter(state, term_n, anew);
    if (!state_f32_runs(state))
    {
        state->offset_rule = TRIBO_FEEDFORWARD_CONTINUE;
    }
    tell(state, 0.0f);
}

// One by one: an initialiser would be a table of absolute addresses.
void tribo_sensorless_f32_method(tribo_force_loop_f32_functions_t *functions)
{
    functions->error = method_error;
    functions->term  = method_term;
    functions->after = method_after;
    functions->enter = method_enter;
}

tribo_sensorless_f32_config_t tribo_sensorless_f32_default(void)
{
    const tribo_sensorless_f32_config_t standard = {TRIBO_SENSORLESS_PARAMETERS(PARAMETERS_DEFAULT)};
    return standard;
}

tribo_status_t tribo_force_loop_sensorless_f32_init(tribo_force_loop_f32_params_t        *params,
                                                    tribo_feedforward_f32_params_t       *feedforward,
                                                    const tribo_force_loop_f32_config_t  *config,
                                                    const tribo_feedforward_f32_config_t *feedforward_config,
                                                    const tribo_sensorless_f32_config_t  *sensorless_config)
{
    if (sensorless_config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = PARAMETERS_CHECK(tribo_sensorless_parameters, sensorless_config);
    if (status == TRIBO_OK)
    {
        status = tribo_force_loop_feedforward_f32_init(params, feedforward, config, feedforward_config);
    }
    if (status == TRIBO_OK)
    {
        feedforward->distrust         = 1.0f - sensorless_config->belief;
        feedforward->method.functions = tribo_sensorless_f32_method;
    }
    return status;
}

/// F of an arm that sticks within `up` and `down` times its breakaway, which depends on F: in `turns` steps.
static float stuck(const tribo_friction_f32_params_t *friction,
                   float                              before,
                   float                              u,
                   float                              up,
                   float                              down,
                   uint32_t                           turns)
{
    const float g = friction->gravity_n;
    float       F = before;
    for (uint32_t i = 0; i < turns; i++)
    {
        const bank_f32_prior_t prior = bank_f32_prior(friction, F);
        const float            half  = prior.load_n + g; // of what the directions differ by
        F = limit_f32(before, u + g - up * (prior.L_n + half), u + g + down * (prior.L_n - half));
    }
    return F;
}

static bool is_corrupt(const tribo_force_estimate_f32_t *x, float most)
{
    return x->runs == 0u || exceeds(x->lagged_n, most) || exceeds(x->force_n, FEEDFORWARD_FORCE_MAX_N) ||
           exceeds(x->low_n, FEEDFORWARD_FORCE_MAX_N) || exceeds(x->high_n, FEEDFORWARD_FORCE_MAX_N);
}

void tribo_force_estimate_f32_step(const tribo_force_loop_f32_params_t  *params,
                                   const tribo_feedforward_f32_params_t *feedforward,
                                   tribo_force_estimate_f32_t           *estimate,
                                   float                                 tolerance,
                                   float                                 u_n)
{
    const tribo_friction_f32_params_t *const friction = &params->compensator.friction;

    const float most  = feedforward->input_max_n;
    uint32_t    turns = ESTIMATE_TURNS;
    if (!within(tolerance, 0.0f, 1.0f) || exceeds(u_n, most))
    {
        return;
    }
    if (is_corrupt(estimate, most))
    {
        *estimate =
            (tribo_force_estimate_f32_t){.runs = 1, .lagged_n = u_n, .force_n = u_n, .low_n = -most, .high_n = most};
        turns = ESTIMATE_FIRST_TURNS;
    }
    const float few    = 1.0f - tolerance;
    const float many   = 1.0f + tolerance;
    estimate->lagged_n = first_order_f32_step(estimate->lagged_n, u_n, feedforward->lag_part);
    estimate->force_n  = stuck(friction, estimate->force_n, estimate->lagged_n, 1.0f, 1.0f, turns);
    estimate->low_n    = stuck(friction, estimate->low_n, estimate->lagged_n, many, few, turns);
    estimate->high_n   = stuck(friction, estimate->high_n, estimate->lagged_n, few, many, turns);
}
