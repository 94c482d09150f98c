// One tick of the feed-forward in its three parts, as docs/feedforward.md numbers its steps.

#include "tribo/feedforward_f32.h"

#include "bank_f32.h"
#include "constants.h"
#include "hold_f32.h"
#include "learning_f32.h"
#include "observer_f32.h"

#include <stddef.h>

/// The params of which `params->method` is the first member.
static const tribo_feedforward_f32_params_t *own(const tribo_force_loop_f32_params_t *params)
{
    return (const tribo_feedforward_f32_params_t *)params->method;
}

static bool runs(const tribo_feedforward_f32_state_t *state)
{
    return state->mode >= TRIBO_FEEDFORWARD_START && state->mode <= TRIBO_FEEDFORWARD_HOLD;
}

/// All states at rest at y; beside a running controller, those that follow r at r. What is learned stays.
static void start(tribo_feedforward_f32_state_t *state, float r, float y)
{
    const bool  enters = state->mode == TRIBO_FEEDFORWARD_ENTER;
    const float at     = enters ? r : y;

    *state = (tribo_feedforward_f32_state_t){
        .mode        = TRIBO_FEEDFORWARD_START,
        .offset_rule = enters ? TRIBO_FEEDFORWARD_TAKE_OVER : TRIBO_FEEDFORWARD_KEEP,
        .term_n      = enters ? state->term_n : 0.0f,
        .r_n         = {r, r},
        .reached_n   = at,
        .settled_n   = at,
        .turned_n    = at,
        .u_n         = y,
        .hold        = {.anchor_n = at, .force_n = y, .extra_margin = state->hold.extra_margin},
        .learned     = state->learned,
        .share       = state->share,
        .at_bound    = state->at_bound,
        .forgotten   = state->forgotten,
    };
    observer_f32_start(&state->observer, y);
}

/// A corrupt memory: everything is forgotten, and u goes on.
static void forget(const tribo_feedforward_f32_params_t *params, tribo_feedforward_f32_state_t *state)
{
    const float    term      = state->term_n;
    const uint32_t forgotten = state->forgotten;
    tribo_feedforward_f32_reset(state);
    state->mode      = TRIBO_FEEDFORWARD_ENTER;
    state->term_n    = exceeds(term, params->offset_max_n) ? 0.0f : term;
    state->forgotten = forgotten;
    count(&state->forgotten);
}

/// Step 6: f while r moves. `alone`: the controller alone takes this reversal, f jumps and b cancels it.
static void follow(const tribo_feedforward_f32_params_t *params,
                   tribo_feedforward_f32_state_t        *state,
                   bool                                  flips,
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
        const float jump =
            signals->f_n - bank_f32_friction(params, learned, signals->level_n, signals->partial, before);
        signals->lead_n = alone ? 0.0f : params->lead * jump;
        state->offset_n += alone ? jump : 0.0f;
    }
    if (flips && !alone)
    {
        const bool bound =
            !(learned->weight[0] > FEEDFORWARD_WEIGHT_MIN && learned->weight[0] < FEEDFORWARD_WEIGHT_MAX);
        const uint32_t turns = bound ? state->at_bound + 1u : 0u;
        state->at_bound =
            (uint8_t)(state->at_bound < TRIBO_FEEDFORWARD_BOUND_TURNS ? turns : TRIBO_FEEDFORWARD_BOUND_TURNS);
        state->offset_rule = TRIBO_FEEDFORWARD_REVERSAL;
    }
    state->sigma = after;
    state->mode  = state->sign != 0 ? TRIBO_FEEDFORWARD_MOVING : TRIBO_FEEDFORWARD_START;
}

/// Step 7: f and the error while r stands.
static void stand(const tribo_feedforward_f32_params_t *params,
                  tribo_feedforward_f32_state_t        *state,
                  tribo_feedforward_f32_signals_t      *signals)
{
    const float margin = FEEDFORWARD_HOLD_MARGIN * (1.0f - limit_f32(state->hold.extra_margin, 0.0f, 1.0f));
    const float B      = margin * state->learned.weight[0] * signals->level_n;
    if (state->mode != TRIBO_FEEDFORWARD_HOLD)
    {
        hold_f32_enter(state, B);
    }
    signals->f_n = hold_f32_step(params, state, B);
    state->sigma = 0.0f;
    if (signals->y_good)
    {
        signals->e_n = hold_f32_deadband(params, &state->hold, signals->e_n, signals->y_n, state->observer.y_n);
    }
}

/// Step 8: f in the first tick after a hold, chosen so that u continues.
static void leave(const tribo_feedforward_f32_params_t *params,
                  tribo_feedforward_f32_state_t        *state,
                  tribo_feedforward_f32_signals_t      *signals)
{
    const tribo_feedforward_weights_f32_t *const learned = &state->learned;

    const float at_0 = bank_f32_friction(params, learned, signals->level_n, signals->partial, 0.0f);
    const float rise = (1.0f - params->distrust * learned->doubt) * signals->level_n * learned->use[0];
    state->sigma     = (float)state->sign;
    if (state->hold.side != state->sign && rise > 0.0f)
    {
        state->sigma = bound_f32((state->u_n - signals->lin_n - at_0) / rise, 1.0f);
    }
    signals->f_n       = bank_f32_friction(params, learned, signals->level_n, signals->partial, state->sigma);
    state->mode        = TRIBO_FEEDFORWARD_MOVING;
    state->offset_rule = TRIBO_FEEDFORWARD_CONTINUE;
}

// Steps 1 to 8.
float tribo_feedforward_f32_method_error(const tribo_force_loop_f32_params_t *loop,
                                         void                                *memory,
                                         float                                r_n,
                                         float                                y_n,
                                         float                                fade)
{
    const tribo_feedforward_f32_params_t *const params  = own(loop);
    tribo_feedforward_f32_memory_t *const       inner   = memory;
    tribo_feedforward_f32_state_t *const        state   = &inner->state;
    tribo_feedforward_f32_signals_t *const      signals = &inner->signals;

    // 1: input
    const bool bad_r = exceeds(r_n, params->input_max_n);
    const bool bad_y = exceeds(y_n, params->input_max_n);
    *signals         = (tribo_feedforward_f32_signals_t){.y_good = !bad_y};
    if (!runs(state))
    {
        if (bad_r || bad_y)
        {
            return 0.0f;
        }
        start(state, r_n, y_n);
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
    bank_f32_follow(params, state, noise, width);
    const bool flips  = state->sign != sign;
    const bool stands = hold_f32_stands(params, state, 0.5f * width, step);

    // 5: force without friction, error; a noisy r has no reliable rate
    const bank_f32_prior_t prior = bank_f32_prior(&loop->compensator.friction, state->reached_n);
    const float            ahead = params->lag_s * state->rate_n_s * (params->reversal_n / width);
    bank_f32_path(params, state, moved, ahead);
    signals->e_n       = bad_y ? 0.0f : e;
    signals->y_n       = y;
    signals->reached_n = state->reached_n;
    signals->lin_n     = state->reached_n + ahead + bank_f32_load(&state->learned, &prior, state->reached_n);

    // 6 to 8: friction
    signals->level_n = fade * limit_f32(state->share, 0.5f, 1.0f) * prior.L_n;
    signals->partial = bank_f32_partial(state);
    if (stands)
    {
        stand(params, state, signals);
    }
    else if (state->mode == TRIBO_FEEDFORWARD_HOLD)
    {
        leave(params, state, signals);
    }
    else
    {
        const bool alone = flips && (sign == 0 || (step && state->learned.doubt > FEEDFORWARD_DOUBTFUL));
        follow(params, state, flips, alone, signals);
    }
    if (exceeds(signals->e_n, FEEDFORWARD_FORCE_MAX_N) ||
        exceeds(signals->lin_n + signals->f_n + state->offset_n, FEEDFORWARD_FORCE_MAX_N) ||
        learning_f32_corrupt(params, &state->learned))
    {
        forget(params, state);
        return bad_r || bad_y ? 0.0f : r_n - y_n;
    }
    state->e_n = signals->e_n;
    state->f_n = signals->f_n;
    return signals->e_n;
}

float tribo_feedforward_f32_method_friction(const void *memory)
{
    const tribo_feedforward_f32_state_t *const state = &((const tribo_feedforward_f32_memory_t *)memory)->state;
    return runs(state) ? state->f_n : 0.0f;
}

// Step 9, before u is limited.
float tribo_feedforward_f32_method_term(const tribo_force_loop_f32_params_t *loop, void *memory, float v_n)
{
    const tribo_feedforward_f32_params_t *const params  = own(loop);
    tribo_feedforward_f32_memory_t *const       inner   = memory;
    tribo_feedforward_f32_state_t *const        state   = &inner->state;
    tribo_feedforward_f32_signals_t *const      signals = &inner->signals;
    if (!runs(state))
    {
        return state->mode == TRIBO_FEEDFORWARD_ENTER ? state->term_n : 0.0f;
    }
    const float wanted = signals->lin_n + signals->f_n + signals->lead_n;
    float       b      = state->offset_n;
    switch (state->offset_rule)
    {
    case TRIBO_FEEDFORWARD_REVERSAL:
        b = v_n; // wound up during stiction
        break;
    case TRIBO_FEEDFORWARD_CONTINUE:
        b = v_n + wanted - state->u_n;
        break;
    case TRIBO_FEEDFORWARD_TAKE_OVER:
        b = wanted - state->term_n;
        break;
    default:
        break;
    }
    state->offset_rule = TRIBO_FEEDFORWARD_KEEP;
    state->offset_n    = bound_f32(b, params->offset_max_n);
    state->term_n      = wanted - state->offset_n;
    signals->b_n       = state->offset_n;
    signals->term_n    = state->term_n;
    return state->term_n;
}

// Steps 10 to 12, once u is known.
void tribo_feedforward_f32_method_after(const tribo_force_loop_f32_params_t *loop,
                                        void                                *memory,
                                        float                                v_n,
                                        float                                u_n,
                                        tribo_force_loop_f32_signals_t      *seen)
{
    const tribo_feedforward_f32_params_t *const params  = own(loop);
    tribo_feedforward_f32_memory_t *const       inner   = memory;
    tribo_feedforward_f32_state_t *const        state   = &inner->state;
    tribo_feedforward_f32_signals_t *const      signals = &inner->signals;
    if (!runs(state))
    {
        return;
    }
    state->u_n     = u_n;
    state->limited = (int8_t)(seen->controller.limited ? bank_f32_sign(v_n + signals->term_n - u_n) : 0);

    const observer_f32_signals_t measured = observer_f32_step(params, &state->observer, u_n, signals->y_n);

    const bool learns = state->mode == TRIBO_FEEDFORWARD_MOVING && state->limited == 0 && signals->y_good &&
                        magnitude(measured.change_n) <= params->change_max_n;
    signals->friction_n = measured.friction_n;
    signals->travel_n   = learns ? magnitude(measured.travel_n) : 0.0f;

    const tribo_feedforward_weights_f32_t *const learned = &state->learned;
    const bank_f32_prior_t                       none    = {.load_n = 0.0f};
    const float                                  before  = bank_f32_load(learned, &none, signals->reached_n);
    if (learning_f32_step(params, &loop->compensator.friction, state, &measured, learns))
    {
        // Learning does not move u.
        const float f    = bank_f32_friction(params, learned, signals->level_n, bank_f32_partial(state), state->sigma);
        const float load = bank_f32_load(learned, &none, signals->reached_n) - before;
        state->offset_n += (f - state->f_n) + load;
        state->f_n = f;
    }
    const float F     = signals->reached_n + state->behind_n[0];
    seen->compensator = (tribo_compensator_f32_signals_t){
        .force_n  = F,
        .friction = {.n_n = u_n - F, .L_n = state->learned.weight[0] * signals->level_n, .f_n = signals->f_n}};
}

void tribo_feedforward_f32_method_last(const void *memory, tribo_force_loop_f32_last_t *last)
{
    const tribo_feedforward_f32_state_t *const state = &((const tribo_feedforward_f32_memory_t *)memory)->state;
    if (runs(state))
    {
        last->e_n = state->e_n;
        last->y_n = state->observer.y_n[0];
    }
    if (state->mode != TRIBO_FEEDFORWARD_RESTART)
    {
        last->term_n = state->term_n;
    }
}

void tribo_feedforward_f32_method_enter(void *memory, float term_n, bool anew)
{
    tribo_feedforward_f32_state_t *const state = &((tribo_feedforward_f32_memory_t *)memory)->state;

    const bool goes_on = runs(state) && !anew;
    state->mode        = goes_on ? state->mode : TRIBO_FEEDFORWARD_ENTER;
    state->offset_rule = goes_on ? TRIBO_FEEDFORWARD_TAKE_OVER : TRIBO_FEEDFORWARD_KEEP;
    state->term_n      = exceeds(term_n, TRIBO_F32_FORCE_MAX_N) ? 0.0f : term_n;
}
