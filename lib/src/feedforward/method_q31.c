// One tick of the feed-forward in fixed point; method_f32.c has the steps in float.

#include "tribo/feedforward_q31.h"

#include "../number/first_order_q31.h"
#include "bank_q31.h"
#include "constants.h"
#include "hold_q31.h"
#include "learning_q31.h"
#include "monitor_q31.h"
#include "observer_q31.h"
#include "state_q31.h"

#include <stddef.h>

static void start(tribo_feedforward_q31_state_t *state, int32_t r, int32_t y)
{
    const bool    enters = state->mode == TRIBO_FEEDFORWARD_ENTER;
    const int32_t at     = enters ? r : y;

    state_q31_rest(state, r, at);
    if (!enters)
    {
        state->offset    = bank_q31_load(&state->learned, at);
        state->tick.term = 0;
    }
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        state->stop[j] = 0;
    }
    hold_q31_start(&state->hold, at); // the rest as one begins
    observer_q31_start(&state->observer, y);
    learning_q31_start(&state->learning, y);
    monitor_q31_start(&state->monitor);
}

/// f for `sigma`.
static int32_t friction(const tribo_feedforward_q31_params_t  *params,
                        const tribo_feedforward_q31_state_t   *state,
                        const tribo_feedforward_q31_signals_t *signals,
                        int32_t                                sigma)
{
    return bank_q31_friction(params, &state->learned, signals->level, signals->partial, sigma);
}

static void follow(const tribo_feedforward_q31_params_t *params,
                   tribo_feedforward_q31_state_t        *state,
                   bool                                  alone,
                   tribo_feedforward_q31_signals_t      *signals)
{
    const int32_t before = limit_q31(state->sigma, -BANK_Q31_ONE, BANK_Q31_ONE);
    const int32_t left   = state->sign * BANK_Q31_ONE - before;
    const int32_t after  = before + (alone ? left : limit_q31(left, -params->jump, params->jump));

    signals->f = friction(params, state, signals, after);
    if (after != before)
    {
        const int32_t jump = bank_q31_product(bank_q31_rise(params, &state->learned, signals->level), after - before);
        signals->lead      = alone ? 0 : bank_q31_times(jump, params->lead, 16, (uint32_t)BANK_Q31_ONE / 2u);
        state->offset      = sum_q31(state->offset, alone ? jump : 0);
    }
    if (signals->flips && !alone)
    {
        state_q31_note_bound(state);
        if (state->offset_rule == TRIBO_FEEDFORWARD_KEEP)
        {
            state->offset_rule = TRIBO_FEEDFORWARD_REVERSAL;
        }
    }
    state->sigma = after;
    state->mode  = state->sign != 0 ? TRIBO_FEEDFORWARD_MOVING : TRIBO_FEEDFORWARD_START;
}

static void stand(const tribo_feedforward_q31_params_t *params,
                  tribo_feedforward_q31_state_t        *state,
                  tribo_feedforward_q31_signals_t      *signals)
{
    const uint32_t margin = ~state->hold.extra_margin;
    const uint32_t V      = tribo_q31_magnitude(state->learned.weight[0]);
    const int32_t  B   = bank_q31_times((int32_t)tribo_q31_high(signals->level, margin), V, 29, (uint32_t)BANK_Q31_ONE);
    const int32_t  net = difference_q31(difference_q31(state->u, state->observer.travelled), signals->load);

    signals->f = hold_q31_friction(net, B);
    if (state->mode != TRIBO_FEEDFORWARD_HOLD)
    {
        hold_q31_enter(state, signals->f);
    }
    hold_q31_turn(params, &state->hold, net, B);
    state->sigma = 0;
    if (signals->y_good)
    {
        signals->e =
            hold_q31_deadband(params, &state->hold, signals->e, signals->y, state->observer.y, state->observer.noise);
    }
    if (state_q31_stays(state))
    {
        signals->e         = 0;
        state->offset_rule = TRIBO_FEEDFORWARD_CONTINUE;
    }
}

static void leave(const tribo_feedforward_q31_params_t *params,
                  tribo_feedforward_q31_state_t        *state,
                  tribo_feedforward_q31_signals_t      *signals)
{
    const int32_t rise = bank_q31_rise(params, &state->learned, signals->level);

    state->sigma = state->sign * BANK_Q31_ONE;
    if (state->hold.side != state->sign && rise > 0)
    {
        const int32_t left = difference_q31(state->u - signals->lin, friction(params, state, signals, 0));
        const int32_t size = (int32_t)(ratio_q31(tribo_q31_magnitude(left), (uint32_t)rise) / 4u);
        state->sigma       = left < 0 ? -size : size;
    }
    signals->f         = friction(params, state, signals, state->sigma);
    state->mode        = TRIBO_FEEDFORWARD_MOVING;
    state->offset_rule = TRIBO_FEEDFORWARD_CONTINUE;
}

/// Steps 6 to 8: f, by the mode.
static void feed(const tribo_feedforward_q31_params_t *params,
                 tribo_feedforward_q31_state_t        *state,
                 bool                                  stands,
                 bool                                  alone,
                 tribo_feedforward_q31_signals_t      *signals)
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

/// As the twin's.
static bool runs(tribo_feedforward_q31_state_t *state, int32_t r, int32_t y, bool good)
{
    if (!state_q31_runs(state))
    {
        if (good)
        {
            start(state, r, y);
        }
        return good;
    }
    if (state->offset_seal != ~(uint32_t)state->offset)
    {
        state->offset_rule = TRIBO_FEEDFORWARD_TAKE_OVER;
        tribo_q31_count(&state->forgotten);
    }
    return true;
}

/// Step 5. A noisy r has no reliable rate.
static void plan(const tribo_feedforward_q31_params_t *params,
                 const tribo_friction_q31_params_t    *friction,
                 tribo_feedforward_q31_state_t        *state,
                 int32_t                               moved,
                 uint32_t                              width,
                 uint32_t                              fade,
                 tribo_feedforward_q31_signals_t      *signals)
{
    const int32_t          rs       = state->reached;
    const bank_q31_prior_t prior    = bank_q31_prior(friction, rs);
    const uint32_t         reliable = 2u * ratio_q31(params->reversal, width);
    const uint32_t         lag      = tribo_q31_high(params->lag, reliable);
    const int32_t ahead = bank_q31_times(state->rate, lag, 32u - params->lag_shift, (uint32_t)BANK_Q31_ONE / 2u);

    bank_q31_path(params, state, moved, ahead);
    signals->reached = rs;
    signals->load    = bank_q31_both(&prior, bank_q31_load(&state->learned, rs));
    signals->lin     = rs + ahead + signals->load;
    signals->level   = bank_q31_share(prior.L, fade);
    signals->lead    = 0;
}

/// As the twin's.
static bool alone(const tribo_feedforward_q31_state_t *state, int8_t before, bool step)
{
    return before == 0 || (step && state->learned.doubt > BANK_Q31_Q32(FEEDFORWARD_DOUBTFUL));
}

// Steps 1 to 8.
static int32_t method_error(const tribo_force_loop_q31_params_t *loop,
                            void                                *memory,
                            int32_t                              r_q31,
                            int32_t                              y_q31,
                            uint32_t                             fade)
{
    const tribo_feedforward_q31_params_t *const params  = state_q31_params(loop);
    tribo_feedforward_q31_memory_t *const       inner   = memory;
    tribo_feedforward_q31_state_t *const        state   = &inner->state;
    tribo_feedforward_q31_signals_t *const      signals = &inner->signals;

    // 1: input
    const bool bad_r = tribo_q31_magnitude(r_q31) > params->input_max;
    const bool bad_y = tribo_q31_magnitude(y_q31) > params->input_max;
    const bool good  = !bad_r && !bad_y;
    if (!runs(state, bank_q31_inside(r_q31), bank_q31_inside(y_q31), good))
    {
        state->tick.friction = 0;
        state->tick.has_e    = false;
        return 0;
    }
    const int32_t r = bad_r ? state->r[0] : bank_q31_inside(r_q31);
    const int32_t y = bad_y ? state->observer.y[0] : bank_q31_inside(y_q31);

    // 2 to 4: reachable reference, stops, sign
    state->noise         = bank_q31_noise(params, state->noise, r, state->r);
    const uint32_t noise = state->noise / BANK_Q31_NOISE_PER(FEEDFORWARD_NOISE_GAIN);
    const uint32_t width = params->reversal + noise;
    const int32_t  e     = sum_q31(difference_q31(state->reached, y), state->behind[1]);
    const int32_t  moved = bank_q31_reach(params, state, r);
    const bool     step  = tribo_q31_magnitude(moved) > (uint32_t)params->step;
    const int8_t   sign  = state->sign;
    bank_q31_slide(params, state, noise);
    bank_q31_turn(state, width);
    const bool flips  = state->sign != sign;
    const bool stands = hold_q31_stands(params, state, width / 2u, step);

    // 5 to 8: force without friction, friction, error
    if (flips && !stands)
    {
        learning_q31_turn(&state->learned, &state->learning);
    }
    plan(params, &loop->compensator.friction, state, moved, width, fade, signals);
    signals->y_good  = !bad_y;
    signals->flips   = flips;
    signals->need    = difference_q31(state->f, state->offset);
    signals->e       = bad_y ? 0 : e;
    signals->y       = y;
    signals->partial = bank_q31_partial(state);
    hold_q31_follow(params, &state->hold, bad_y ? state->hold.error : e);
    feed(params, state, stands, flips && alone(state, sign, step), signals);
    state->f             = signals->f;
    state->tick.e        = bank_q31_outside(signals->e);
    state->tick.y        = bank_q31_outside(y);
    state->tick.friction = bank_q31_outside(signals->f);
    state->tick.has_e    = true;
    state->tick.has_y    = true;
    return state->tick.e;
}

/// v without its noise.
static int32_t quiet(const tribo_feedforward_q31_state_t *state, int32_t v)
{
    const int32_t most = (int32_t)(state->observer.noise / BANK_Q31_NOISE_PER(FEEDFORWARD_V_NOISE));
    return v + limit_q31(difference_q31(state->v, v), -most, most);
}

/// b at a reversal at `rs`: v, wound up during stiction. Where v made up for a load, and would push F beyond the reversal, b keeps that.
static int32_t reversed(const tribo_feedforward_q31_params_t *params,
                        const tribo_feedforward_q31_state_t  *state,
                        int32_t                               rs,
                        int32_t                               v)
{
    const int32_t  beyond = state->sign > 0 ? difference_q31(state->offset, v) : difference_q31(v, state->offset);
    const uint32_t load   = tribo_q31_magnitude(bank_q31_load(&state->learned, rs));
    const uint32_t most   = tribo_q31_high(load, BANK_Q31_Q32(FEEDFORWARD_KEPT));
    const int32_t  kept   = limit_q31(difference_q31(beyond, (int32_t)params->reversal), 0, (int32_t)most);
    return v + state->sign * kept;
}

// Step 9, before u is limited.
static int32_t method_term(const tribo_force_loop_q31_params_t *loop, void *memory, int32_t v)
{
    const tribo_feedforward_q31_params_t *const params  = state_q31_params(loop);
    tribo_feedforward_q31_memory_t *const       inner   = memory;
    tribo_feedforward_q31_state_t *const        state   = &inner->state;
    tribo_feedforward_q31_signals_t *const      signals = &inner->signals;
    if (!state_q31_runs(state))
    {
        return state->mode == TRIBO_FEEDFORWARD_ENTER ? state->tick.term : 0;
    }
    if (signals->flips)
    {
        monitor_q31_judge(params, &state->monitor, bank_q31_inside(v), sum_q31(bank_q31_inside(v), signals->need));
    }
    const int32_t most   = 2 * (BANK_Q31_ONE - 1);
    const int32_t wanted = limit_q31(signals->lin + signals->f, -most, most); // without the lead: a pulse
    int32_t       b      = state->offset;
    switch (state->offset_rule)
    {
    case TRIBO_FEEDFORWARD_REVERSAL:
        b = reversed(params, state, signals->reached, quiet(state, bank_q31_inside(v)));
        break;
    case TRIBO_FEEDFORWARD_CONTINUE:
        b = bank_q31_inside(v) + wanted - state->u;
        break;
    case TRIBO_FEEDFORWARD_TAKE_OVER:
        b = wanted - bank_q31_inside(state->tick.term);
        break;
    default:
        break;
    }
    state->v           = first_order_q31_step(state->v, bank_q31_inside(v), params->observer_part);
    state->offset_rule = TRIBO_FEEDFORWARD_KEEP;
    state->offset      = limit_q31(b, -params->offset_max, params->offset_max);
    state->tick.term   = bank_q31_outside(wanted - state->offset);
    signals->b         = state->offset;
    signals->term      = bank_q31_outside(limit_q31(wanted + signals->lead, -most, most) - state->offset);
    return signals->term;
}

/// Step 11: a stage, and after the last the monitor and the check of what is learned.
static void learn(const tribo_force_loop_q31_params_t *loop,
                  tribo_feedforward_q31_state_t       *state,
                  tribo_feedforward_q31_signals_t     *signals,
                  int32_t                              v)
{
    const tribo_feedforward_q31_params_t *const params = state_q31_params(loop);

    const bool moves = state->mode == TRIBO_FEEDFORWARD_MOVING;
    const bool fresh = state->learning.stage == 0u;
    const bool last  = state->learning.stage >= FEEDFORWARD_STAGES - 1u;
    learning_q31_step(params,
                      &loop->compensator.friction,
                      state,
                      signals->level,
                      moves && state->limited == 0 && signals->y_good);
    signals->travel = fresh ? state->learning.sample : 0u;
    if (last)
    {
        monitor_q31_step(params, &state->monitor, moves ? bank_q31_inside(v) : state->monitor.v, state->observer.noise);
        if (learning_q31_corrupt(&state->learned, &state->learning))
        {
            state_q31_forget(state);
        }
    }
}

// Steps 10 and 11, once u is known.
static void method_after(const tribo_force_loop_q31_params_t *loop,
                         void                                *memory,
                         int32_t                              v,
                         int32_t                              u_q31,
                         tribo_force_loop_q31_signals_t      *seen)
{
    const tribo_feedforward_q31_params_t *const params  = state_q31_params(loop);
    tribo_feedforward_q31_memory_t *const       inner   = memory;
    tribo_feedforward_q31_state_t *const        state   = &inner->state;
    tribo_feedforward_q31_signals_t *const      signals = &inner->signals;

    const int32_t u       = bank_q31_inside(u_q31);
    uint32_t      ignored = 0;
    if (!state_q31_runs(state))
    {
        return;
    }
    const int32_t wanted = tribo_q31_add(v, signals->term, &ignored);
    if (!state_q31_stays(state))
    {
        state->u = u;
    }
    state->limited = (int8_t)(seen->controller.limited ? (wanted > u_q31) - (wanted < u_q31) : 0);

    observer_q31_step(params, &state->observer, u, signals->y);
    signals->friction = state->observer.friction;
    signals->travel   = 0u;
    if (!signals->flips)
    {
        learn(loop, state, signals, v);
    }
    state->offset_seal = ~(uint32_t)state->offset;
    const int32_t F    = sum_q31(signals->reached, state->behind[0]);
    const int32_t L    = bank_q31_times(state->learned.weight[0], signals->level, 29, (uint32_t)BANK_Q31_ONE);
    state_q31_show(seen, u_q31, F, L, signals->f);
}

static void method_enter(void *memory, int32_t term, bool anew)
{
    state_q31_enter(&((tribo_feedforward_q31_memory_t *)memory)->state, term, anew);
}

// One by one: an initialiser would be a table of absolute addresses.
void tribo_feedforward_q31_method(tribo_force_loop_q31_functions_t *functions)
{
    functions->error = method_error;
    functions->term  = method_term;
    functions->after = method_after;
    functions->enter = method_enter;
}

tribo_status_t tribo_force_loop_feedforward_q31_init(tribo_force_loop_q31_params_t        *params,
                                                     tribo_breakaway_point_q31_t          *table,
                                                     tribo_feedforward_q31_params_t       *feedforward,
                                                     const tribo_force_loop_f32_config_t  *config,
                                                     const tribo_feedforward_f32_config_t *feedforward_config,
                                                     float                                 full_scale_n,
                                                     tribo_headroom_q31_t                 *headroom)
{
    tribo_force_loop_q31_params_t made;
    tribo_headroom_q31_t          measured;
    tribo_friction_f32_params_t   friction;
    if (params == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = tribo_force_loop_q31_init(&made, table, config, full_scale_n, &measured);
    if (status == TRIBO_OK)
    {
        status = tribo_friction_f32_init(&friction, &config->compensator.friction, config->sample_time_s);
    }
    if (status == TRIBO_OK)
    {
        status = tribo_feedforward_q31_init(feedforward,
                                            feedforward_config,
                                            &config->compensator.arm,
                                            &friction,
                                            config->input_max_n,
                                            tribo_force_loop_f32_usual_force_n(config),
                                            config->sample_time_s,
                                            full_scale_n);
    }
    if (status != TRIBO_OK)
    {
        return status;
    }
    if (headroom != NULL)
    {
        *headroom = measured;
    }
    *params                       = made;
    feedforward->method.functions = tribo_feedforward_q31_method;
    params->method                = &feedforward->method;
    return TRIBO_OK;
}
