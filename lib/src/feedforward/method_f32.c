// One tick of the feed-forward in its three parts, as docs/feedforward.md numbers its steps.

#include "tribo/feedforward_f32.h"

#include "../number/first_order_f32.h"
#include "bank_f32.h"
#include "constants.h"
#include "hold_f32.h"
#include "learning_f32.h"
#include "monitor_f32.h"
#include "observer_f32.h"
#include "state_f32.h"

#include <stddef.h>

/// All states at rest at y; beside a running controller, those that follow r at r. What is learned stays.
static void start(tribo_feedforward_f32_state_t *state, float r, float y)
{
    const bool  enters = state->mode == TRIBO_FEEDFORWARD_ENTER;
    const float at     = enters ? r : y;

    state_f32_rest(state, r, at);
    if (!enters)
    {
        state->offset_n    = bank_f32_load(&state->learned, at);
        state->tick.term_n = 0.0f;
    }
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        state->stop[j] = 0.0f;
    }
    hold_f32_start(&state->hold, at); // the rest as one begins
    observer_f32_start(&state->observer, y);
    learning_f32_start(&state->learning, y);
    monitor_f32_start(&state->monitor);
}

/// Step 6: f while r moves. `alone`: the controller alone takes this reversal, f jumps and b cancels it.
static void follow(const tribo_feedforward_f32_params_t *params,
                   tribo_feedforward_f32_state_t        *state,
                   bool                                  alone,
                   tribo_feedforward_f32_signals_t      *signals)
{
    const tribo_feedforward_weights_f32_t *const learned = &state->learned;

    const float before = state->sigma;
    const float left   = (float)state->sign - before;
    const float after  = bound_f32(before + (alone ? left : bound_f32(left, params->jump)), 1.0f);

    signals->f_n = bank_f32_friction(params, learned, signals->level_n, signals->partial, after);
    if (after != before)
    {
        const float jump = bank_f32_rise(params, learned, signals->level_n) * (after - before);
        signals->lead_n  = alone ? 0.0f : params->lead * jump;
        state->offset_n += alone ? jump : 0.0f;
    }
    if (signals->flips && !alone)
    {
        state_f32_note_bound(state);
        if (state->offset_rule == TRIBO_FEEDFORWARD_KEEP)
        {
            state->offset_rule = TRIBO_FEEDFORWARD_REVERSAL;
        }
    }
    state->sigma = after;
    state->mode  = state->sign != 0 ? TRIBO_FEEDFORWARD_MOVING : TRIBO_FEEDFORWARD_START;
}

/// Step 7: f and the error while r stands, or friction fed forward does harm.
static void stand(const tribo_feedforward_f32_params_t *params,
                  tribo_feedforward_f32_state_t        *state,
                  tribo_feedforward_f32_signals_t      *signals)
{
    const float margin = 1.0f - limit_f32(state->hold.extra_margin, 0.0f, 1.0f);
    const float B      = margin * state->learned.weight[0] * signals->level_n;
    const float net    = state->u_n - state->observer.travelled_n - signals->load_n;

    signals->f_n = hold_f32_friction(net, B);
    if (state->mode != TRIBO_FEEDFORWARD_HOLD)
    {
        hold_f32_enter(state, signals->f_n);
    }
    hold_f32_turn(params, &state->hold, net, B);
    state->sigma = 0.0f;
    if (signals->y_good)
    {
        signals->e_n = hold_f32_deadband(params,
                                         &state->hold,
                                         signals->e_n,
                                         signals->y_n,
                                         state->observer.y_n,
                                         state->observer.noise_n);
    }
    if (state_f32_stays(state))
    {
        signals->e_n       = 0.0f;
        state->offset_rule = TRIBO_FEEDFORWARD_CONTINUE;
    }
}

/// Step 8: f in the first tick after a hold, chosen so that u continues.
static void leave(const tribo_feedforward_f32_params_t *params,
                  tribo_feedforward_f32_state_t        *state,
                  tribo_feedforward_f32_signals_t      *signals)
{
    const tribo_feedforward_weights_f32_t *const learned = &state->learned;

    const float at_0 = bank_f32_friction(params, learned, signals->level_n, signals->partial, 0.0f);
    const float rise = bank_f32_rise(params, learned, signals->level_n);
    state->sigma     = (float)state->sign;
    if (state->hold.side != state->sign && rise > 0.0f)
    {
        state->sigma = bound_f32((state->u_n - signals->lin_n - at_0) / rise, 1.0f);
    }
    signals->f_n       = bank_f32_friction(params, learned, signals->level_n, signals->partial, state->sigma);
    state->mode        = TRIBO_FEEDFORWARD_MOVING;
    state->offset_rule = TRIBO_FEEDFORWARD_CONTINUE;
}

/// Steps 6 to 8: f, by the mode.
static void feed(const tribo_feedforward_f32_params_t *params,
                 tribo_feedforward_f32_state_t        *state,
                 bool                                  stands,
                 bool                                  alone,
                 tribo_feedforward_f32_signals_t      *signals)
{
    if (stands && state->mode != TRIBO_FEEDFORWARD_START)
    {
        stand(params, state, signals);
    }
    else if (state->mode == TRIBO_FEEDFORWARD_HOLD)
    {
        leave(params, state, signals);
    }
    else
    {
        follow(params, state, alone, signals);
    }
}

/// A sum beyond all forces, or not a number.
static bool is_corrupt(const tribo_feedforward_f32_signals_t *signals, float offset)
{
    return exceeds(signals->e_n, FEEDFORWARD_FORCE_MAX_N) ||
           exceeds(signals->lin_n + signals->f_n + offset, FEEDFORWARD_FORCE_MAX_N);
}

/// Step 1: starts with good inputs, and looks after b. True if it runs.
static bool runs(tribo_feedforward_f32_state_t *state, float r, float y, bool good)
{
    if (!state_f32_runs(state))
    {
        if (good)
        {
            start(state, r, y);
        }
        return good;
    }
    if (state->offset_seal != ~bits_f32(state->offset_n))
    {
        state->offset_rule = TRIBO_FEEDFORWARD_TAKE_OVER; // a flipped bit of b: u goes on
        count(&state->forgotten);
    }
    return true;
}

/// Step 5: force without friction, and the model of the path. A noisy r has no reliable rate.
static void plan(const tribo_feedforward_f32_params_t *params,
                 const tribo_friction_f32_params_t    *friction,
                 tribo_feedforward_f32_state_t        *state,
                 float                                 moved,
                 float                                 width,
                 float                                 fade,
                 tribo_feedforward_f32_signals_t      *signals)
{
    const float            rs    = state->reached_n;
    const bank_f32_prior_t prior = bank_f32_prior(friction, rs);
    const float            ahead = params->lag_s * state->rate_n_s * (params->reversal_n / width);

    bank_f32_path(params, state, moved, ahead);
    signals->reached_n = rs;
    signals->load_n    = prior.load_n + bank_f32_load(&state->learned, rs);
    signals->lin_n     = rs + ahead + signals->load_n;
    signals->level_n   = fade * prior.L_n;
    signals->lead_n    = 0.0f;
}

/// True if the controller alone takes a reversal: the first, and a step while friction is in doubt.
static bool alone(const tribo_feedforward_f32_state_t *state, int8_t before, bool step)
{
    return before == 0 || (step && state->learned.doubt > FEEDFORWARD_DOUBTFUL);
}

// Steps 1 to 8.
static float method_error(const tribo_force_loop_f32_params_t *loop, void *memory, float r_n, float y_n, float fade)
{
    const tribo_feedforward_f32_params_t *const params  = state_f32_params(loop);
    tribo_feedforward_f32_memory_t *const       inner   = memory;
    tribo_feedforward_f32_state_t *const        state   = &inner->state;
    tribo_feedforward_f32_signals_t *const      signals = &inner->signals;

    // 1: input
    const bool bad_r = exceeds(r_n, params->input_max_n);
    const bool bad_y = exceeds(y_n, params->input_max_n);
    const bool good  = !bad_r && !bad_y;
    if (!runs(state, r_n, y_n, good))
    {
        state->tick.friction_n = 0.0f;
        state->tick.has_e      = false;
        return 0.0f;
    }
    const float r = bad_r ? state->r_n[0] : r_n;
    const float y = bad_y ? state->observer.y_n[0] : y_n;

    // 2 to 4: reachable reference, stops, sign
    state->noise_n     = bank_f32_noise(params, state->noise_n, r, state->r_n);
    const float  noise = FEEDFORWARD_NOISE_GAIN * state->noise_n;
    const float  width = params->reversal_n + noise;
    const float  e     = (state->reached_n - y) + state->behind_n[1];
    const float  moved = bank_f32_reach(params, state, r);
    const bool   step  = magnitude(moved) > params->step_n;
    const int8_t sign  = state->sign;
    bank_f32_slide(params, state, noise);
    bank_f32_turn(state, width);
    const bool flips  = state->sign != sign;
    const bool stands = hold_f32_stands(params, state, 0.5f * width, step);

    // 5 to 8: force without friction, friction, error
    if (flips && !stands)
    {
        learning_f32_turn(&state->learned, &state->learning);
    }
    plan(params, &loop->compensator.friction, state, moved, width, fade, signals);
    signals->y_good  = !bad_y;
    signals->flips   = flips;
    signals->need_n  = state->f_n - state->offset_n;
    signals->e_n     = bad_y ? 0.0f : e;
    signals->y_n     = y;
    signals->partial = bank_f32_partial(state);
    hold_f32_follow(params, &state->hold, bad_y ? state->hold.error_n : e);
    feed(params, state, stands, flips && alone(state, sign, step), signals);
    if (is_corrupt(signals, state->offset_n))
    {
        state_f32_forget(params, state);
        return good ? r_n - y_n : 0.0f;
    }
    state->f_n             = signals->f_n;
    state->tick.e_n        = signals->e_n;
    state->tick.y_n        = y;
    state->tick.friction_n = signals->f_n;
    state->tick.has_e      = true;
    state->tick.has_y      = true;
    return signals->e_n;
}

/// v without its noise.
static float quiet(const tribo_feedforward_f32_state_t *state, float v)
{
    return v + bound_f32(state->v_n - v, FEEDFORWARD_V_NOISE * state->observer.noise_n);
}

/// b at a reversal at `rs`: v, wound up during stiction. Where v made up for a load, and would push F beyond the reversal, b keeps that.
static float reversed(const tribo_feedforward_f32_params_t *params,
                      const tribo_feedforward_f32_state_t  *state,
                      float                                 rs,
                      float                                 v)
{
    const float s    = (float)state->sign;
    const float load = magnitude(bank_f32_load(&state->learned, rs));
    const float kept = limit_f32(s * (state->offset_n - v) - params->reversal_n, 0.0f, FEEDFORWARD_KEPT * load);
    return v + s * kept;
}

// Step 9, before u is limited.
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
    if (signals->flips)
    {
        monitor_f32_judge(params, &state->monitor, v_n, v_n + signals->need_n);
    }
    const float wanted = signals->lin_n + signals->f_n; // without the lead: a pulse
    float       b      = state->offset_n;
    switch (state->offset_rule)
    {
    case TRIBO_FEEDFORWARD_REVERSAL:
        b = reversed(params, state, signals->reached_n, quiet(state, v_n));
        break;
    case TRIBO_FEEDFORWARD_CONTINUE:
        b = v_n + wanted - state->u_n;
        break;
    case TRIBO_FEEDFORWARD_TAKE_OVER:
        b = wanted - state->tick.term_n;
        break;
    default:
        break;
    }
    const float passed = first_order_f32_step(state->v_n, v_n, params->observer_part);
    state->v_n         = exceeds(passed, FEEDFORWARD_FORCE_MAX_N) ? v_n : passed;
    state->offset_rule = TRIBO_FEEDFORWARD_KEEP;
    state->offset_n    = bound_f32(b, params->offset_max_n);
    state->tick.term_n = wanted - state->offset_n;
    signals->b_n       = state->offset_n;
    signals->term_n    = state->tick.term_n + signals->lead_n;
    return signals->term_n;
}

/// Step 11: a stage, and after the last the monitor and the check of what is learned.
static void learn(const tribo_force_loop_f32_params_t *loop,
                  tribo_feedforward_f32_state_t       *state,
                  tribo_feedforward_f32_signals_t     *signals,
                  float                                v_n)
{
    const tribo_feedforward_f32_params_t *const params = state_f32_params(loop);

    const bool moves = state->mode == TRIBO_FEEDFORWARD_MOVING;
    const bool fresh = state->learning.stage == 0u;
    const bool last  = state->learning.stage >= FEEDFORWARD_STAGES - 1u;
    learning_f32_step(params,
                      &loop->compensator.friction,
                      state,
                      signals->level_n,
                      moves && state->limited == 0 && signals->y_good);
    signals->travel_n = fresh ? state->learning.sample_n : 0.0f;
    if (last)
    {
        monitor_f32_step(params, &state->monitor, moves ? v_n : state->monitor.v_n, state->observer.noise_n);
        if (learning_f32_corrupt(&state->learned, &state->learning))
        {
            state_f32_forget(params, state);
        }
    }
}

// Steps 10 and 11, once u is known.
static void method_after(const tribo_force_loop_f32_params_t *loop,
                         void                                *memory,
                         float                                v_n,
                         float                                u_n,
                         tribo_force_loop_f32_signals_t      *seen)
{
    const tribo_feedforward_f32_params_t *const params  = state_f32_params(loop);
    tribo_feedforward_f32_memory_t *const       inner   = memory;
    tribo_feedforward_f32_state_t *const        state   = &inner->state;
    tribo_feedforward_f32_signals_t *const      signals = &inner->signals;
    if (!state_f32_runs(state))
    {
        return;
    }
    if (!state_f32_stays(state)) // else rounding adds up
    {
        state->u_n = u_n;
    }
    state->limited = (int8_t)(seen->controller.limited ? bank_f32_sign(v_n + signals->term_n - u_n) : 0);

    observer_f32_step(params, &state->observer, u_n, signals->y_n);
    signals->friction_n = state->observer.friction_n;
    signals->travel_n   = 0.0f;
    if (!signals->flips)
    {
        learn(loop, state, signals, v_n);
    }
    state->offset_seal = ~bits_f32(state->offset_n);
    const float F      = signals->reached_n + state->behind_n[0];
    state_f32_show(seen, u_n, F, state->learned.weight[0] * signals->level_n, signals->f_n);
}

static void method_enter(void *memory, float term_n, bool anew)
{
    state_f32_enter(&((tribo_feedforward_f32_memory_t *)memory)->state, term_n, anew);
}

// One by one: an initialiser would be a table of absolute addresses.
void tribo_feedforward_f32_method(tribo_force_loop_f32_functions_t *functions)
{
    functions->error = method_error;
    functions->term  = method_term;
    functions->after = method_after;
    functions->enter = method_enter;
}

tribo_status_t tribo_force_loop_feedforward_f32_init(tribo_force_loop_f32_params_t        *params,
                                                     tribo_feedforward_f32_params_t       *feedforward,
                                                     const tribo_force_loop_f32_config_t  *config,
                                                     const tribo_feedforward_f32_config_t *feedforward_config)
{
    tribo_force_loop_f32_params_t made;
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = tribo_force_loop_f32_init(&made, config);
    if (status == TRIBO_OK)
    {
        status = tribo_feedforward_f32_init(feedforward,
                                            feedforward_config,
                                            &config->compensator.arm,
                                            &made.compensator.friction,
                                            config->input_max_n,
                                            tribo_force_loop_f32_usual_force_n(config),
                                            config->sample_time_s);
    }
    if (status == TRIBO_OK)
    {
        *params                       = made;
        feedforward->method.functions = tribo_feedforward_f32_method;
        params->method                = &feedforward->method;
    }
    return status;
}
