// The feed-forward without a force sensor in fixed point; sensorless_f32.c has the steps in float.

#include "tribo/feedforward_q31.h"

#include "../number/fixed_q31.h"
#include "../number/ranges.h"
#include "bank_q31.h"
#include "constants.h"
#include "effort_q31.h"
#include "state_q31.h"

#include <stddef.h>

static int32_t push(int32_t *slack, int32_t moves)
{
    const int32_t half   = BANK_Q31_ONE / 2;
    const int32_t wanted = limit_q31(*slack, -half, half) + limit_q31(moves, -2 * BANK_Q31_ONE, 2 * BANK_Q31_ONE);
    *slack               = limit_q31(wanted, -half, half);
    return bank_q31_sign(wanted - *slack);
}

void tribo_sensorless_q31_motion(tribo_feedforward_q31_memory_t *memory, int32_t intended, int32_t measured)
{
    tribo_feedforward_q31_motion_t *const motion = &memory->motion;

    const int32_t first  = push(&motion->slack[0], intended);
    const int32_t second = push(&motion->slack[1], measured);
    const int32_t sign   = first != 0 || intended != 0 ? first : second; // at rest: the measured
    motion->sign         = (int8_t)(sign != 0 ? sign : motion->sign);
    motion->is_known     = 1;
    motion->measured     = measured;
}

static bool learn(const tribo_feedforward_q31_params_t *params,
                  tribo_feedforward_q31_memory_t       *memory,
                  const bank_q31_prior_t               *prior)
{
    tribo_feedforward_q31_motion_t *const        motion  = &memory->motion;
    const tribo_feedforward_weights_q31_t *const learned = &memory->state.learned;

    motion->was_known   = motion->was_known != 0u || motion->is_known != 0u;
    const bool is_sound = motion->was_known == 0u || learning_q31_fold_all(learned) == learned->seal;
    if (is_sound && motion->is_known != 0u)
    {
        effort_q31_step(params, memory, prior);
    }
    return is_sound;
}

static int8_t direction(tribo_feedforward_q31_memory_t *memory, int8_t before)
{
    if (memory->motion.is_known == 0u)
    {
        return memory->state.sign;
    }
    memory->motion.is_known = 0;
    return (int8_t)bank_q31_sign(memory->motion.sign != 0 ? memory->motion.sign : before);
}

static void oppose(const tribo_feedforward_q31_params_t *params,
                   tribo_feedforward_q31_memory_t       *memory,
                   uint32_t                              level,
                   int32_t                               V_before)
{
    tribo_feedforward_q31_state_t *const   state   = &memory->state;
    tribo_feedforward_q31_signals_t *const signals = &memory->signals;

    const int32_t V      = effort_q31_weight(memory);
    const int32_t before = limit_q31(state->sigma, -BANK_Q31_ONE, BANK_Q31_ONE);
    const int32_t left   = limit_q31(state->sign * BANK_Q31_ONE - before, -params->jump, params->jump);
    state->sigma         = before + left;
    signals->level       = effort_q31_level(level, V);
    signals->f           = bank_q31_product((int32_t)signals->level, state->sigma);
    const int32_t jump   = bank_q31_product((int32_t)signals->level, left);
    signals->lead        = bank_q31_times(jump, params->lead, 16, (uint32_t)BANK_Q31_ONE / 2u);
    if (V != V_before)
    {
        const int32_t last = (int32_t)effort_q31_level(level, V_before);
        state->offset      = sum_q31(state->offset, signals->f - bank_q31_product(last, state->sigma));
    }
}

/// What the loop reads. The controller is taken out of u: in a change of params it goes on with an error of 0.
static void tell(tribo_feedforward_q31_state_t *state, int32_t friction)
{
    state->tick.e        = 0;
    state->tick.friction = friction;
    state->tick.has_e    = state->mode != TRIBO_FEEDFORWARD_RESTART;
    state->tick.has_y    = false;
}

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

    const bool bad     = tribo_q31_magnitude(r_q31) > params->input_max;
    uint32_t   ignored = 0;
    int32_t    e       = 0;
    if (!state_q31_runs(state))
    {
        if (bad)
        {
            state->offset_rule = TRIBO_FEEDFORWARD_KEEP;
            tell(state, 0);
            return 0;
        }
        // The term to go on from is for the controller's output at that error.
        const bool is_handed = state->offset_rule == TRIBO_FEEDFORWARD_CONTINUE;
        if (is_handed && tribo_q31_magnitude(y_q31) <= params->input_max)
        {
            e = tribo_q31_subtract(r_q31, y_q31, &ignored);
        }
        state_q31_rest(state, bank_q31_inside(r_q31), bank_q31_inside(r_q31));
        effort_q31_start(inner, bank_q31_inside(r_q31));
    }
    state->noise         = bank_q31_noise(params, state->noise, bad ? state->r[0] : bank_q31_inside(r_q31), state->r);
    const uint32_t noise = state->noise / BANK_Q31_NOISE_PER(FEEDFORWARD_NOISE_GAIN);
    const uint32_t width = params->reversal + noise;
    const int32_t  moved = bank_q31_reach(params, state, state->r[0]);
    const int8_t   sign  = state->sign;
    bank_q31_turn(state, width);

    // A noisy r has no reliable rate; that of somebody else's effort is noise altogether.
    const int32_t          rate     = inner->motion.is_known != 0u ? 0 : state->rate;
    const bank_q31_prior_t prior    = bank_q31_prior(&loop->compensator.friction, state->reached);
    const uint32_t         reliable = 2u * ratio_q31(params->reversal, width);
    const uint32_t         lag      = tribo_q31_high(params->lag, reliable);
    const int32_t          ahead    = bank_q31_times(rate, lag, 32u - params->lag_shift, (uint32_t)BANK_Q31_ONE / 2u);
    bank_q31_path(params, state, moved, ahead);

    const int32_t V    = effort_q31_weight(inner);
    const bool    good = learn(params, inner, &prior);
    state->sign        = direction(inner, sign);
    oppose(params, inner, bank_q31_share(bank_q31_share(prior.L, fade), ~params->distrust), V);
    signals->e       = bank_q31_inside(e);
    signals->reached = state->reached;
    signals->lin     = sum_q31(sum_q31(state->reached, ahead), bank_q31_both(&prior, 0));
    if (!good)
    {
        state_q31_forget(state);
        tell(state, 0);
        return 0;
    }
    tell(state, bank_q31_outside(signals->f));
    return e;
}

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
    const tribo_controller_q31_params_t *const limits = &loop->controller;

    const bool    takes_over = state->offset_rule == TRIBO_FEEDFORWARD_TAKE_OVER;
    const int32_t most       = 2 * (BANK_Q31_ONE - 1);
    const int32_t wanted     = limit_q31(sum_q31(signals->lin, signals->f), -most, most);
    const int32_t going      = bank_q31_inside(v) + bank_q31_inside(state->tick.term);
    const int32_t b          = takes_over ? wanted - going : first_order_q31_step(state->offset, 0, params->noise_part);
    uint32_t      ignored    = 0;
    state->offset_rule       = TRIBO_FEEDFORWARD_KEEP;
    state->offset            = limit_q31(b, -params->offset_max, params->offset_max);

    const int32_t low   = bank_q31_inside(limits->u_min);
    const int32_t high  = bank_q31_inside(limits->u_max);
    const int32_t sum   = limit_q31(wanted + signals->lead, -most, most) - state->offset;
    const int32_t u     = limit_q31(sum, low, high); // here: the controller shall not wind up
    const int32_t plain = limit_q31(wanted - state->offset, low, high);
    state->limited      = (int8_t)bank_q31_sign(sum - u);
    state->tick.term    = tribo_q31_subtract(bank_q31_outside(plain), v, &ignored);
    signals->b          = state->offset;
    signals->term       = tribo_q31_subtract(bank_q31_outside(u), v, &ignored);
    return signals->term;
}

static void method_after(const tribo_force_loop_q31_params_t *loop,
                         void                                *memory,
                         int32_t                              v,
                         int32_t                              u_q31,
                         tribo_force_loop_q31_signals_t      *seen)
{
    tribo_feedforward_q31_memory_t *const  inner   = memory;
    tribo_feedforward_q31_state_t *const   state   = &inner->state;
    tribo_feedforward_q31_signals_t *const signals = &inner->signals;
    (void)v;
    if (!state_q31_runs(state))
    {
        return;
    }
    const int32_t  actuator  = limit_q31(state->observer.actuator, -BANK_Q31_ONE, BANK_Q31_ONE);
    const uint32_t part      = state_q31_params(loop)->actuator_part;
    state->observer.actuator = first_order_q31_step(actuator, bank_q31_inside(u_q31), part);
    seen->controller.limited = state->limited != 0;
    state_q31_show(seen, u_q31, sum_q31(signals->reached, state->behind[0]), (int32_t)signals->level, signals->f);
}

static void method_enter(void *memory, int32_t term, bool anew)
{
    tribo_feedforward_q31_state_t *const state = &((tribo_feedforward_q31_memory_t *)memory)->state;
    state_q31_enter(state, term, anew);
    if (!state_q31_runs(state))
    {
        state->offset_rule = TRIBO_FEEDFORWARD_CONTINUE;
    }
    tell(state, 0);
}

// One by one: an initialiser would be a table of absolute addresses.
void tribo_sensorless_q31_method(tribo_force_loop_q31_functions_t *functions)
{
    functions->error = method_error;
    functions->term  = method_term;
    functions->after = method_after;
    functions->enter = method_enter;
}

tribo_status_t tribo_force_loop_sensorless_q31_init(tribo_force_loop_q31_params_t        *params,
                                                    tribo_breakaway_point_q31_t          *table,
                                                    tribo_feedforward_q31_params_t       *feedforward,
                                                    const tribo_force_loop_f32_config_t  *config,
                                                    const tribo_feedforward_f32_config_t *feedforward_config,
                                                    const tribo_sensorless_f32_config_t  *sensorless_config,
                                                    float                                 full_scale_n,
                                                    tribo_headroom_q31_t                 *headroom)
{
    if (sensorless_config == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = PARAMETERS_CHECK(tribo_sensorless_parameters, sensorless_config);
    if (status == TRIBO_OK)
    {
        status = tribo_force_loop_feedforward_q31_init(params,
                                                       table,
                                                       feedforward,
                                                       config,
                                                       feedforward_config,
                                                       full_scale_n,
                                                       headroom);
    }
    if (status == TRIBO_OK)
    {
        feedforward->distrust         = ~fixed_unsigned(sensorless_config->belief, 32);
        feedforward->method.functions = tribo_sensorless_q31_method;
    }
    return status;
}

static int32_t stuck(const tribo_friction_q31_params_t *friction,
                     int32_t                            before,
                     int32_t                            u,
                     uint32_t                           up,
                     uint32_t                           down,
                     uint32_t                           turns)
{
    const int32_t  g    = bank_q31_inside(friction->gravity);
    const uint32_t most = 2u * (uint32_t)BANK_Q31_ONE - 2u; // with u and g it fits
    int32_t        F    = before;
    for (uint32_t i = 0; i < turns; i++)
    {
        const bank_q31_prior_t prior = bank_q31_prior(friction, F);
        const int32_t          half  = prior.load + g;
        const int32_t          rise  = bank_q31_times((int32_t)prior.L + half, up, 31, most);
        const int32_t          fall  = bank_q31_times((int32_t)prior.L - half, down, 31, most);
        F                            = limit_q31(before, u + g - rise, u + g + fall);
    }
    return F;
}

void tribo_force_estimate_q31_step(const tribo_force_loop_q31_params_t  *params,
                                   const tribo_feedforward_q31_params_t *feedforward,
                                   tribo_force_estimate_q31_t           *estimate,
                                   uint32_t                              tolerance,
                                   int32_t                               u_q31)
{
    const tribo_friction_q31_params_t *const friction = &params->compensator.friction;

    const int32_t u     = bank_q31_inside(u_q31);
    const int32_t most  = (int32_t)(feedforward->input_max / 4u);
    uint32_t      turns = ESTIMATE_TURNS;
    // In units: a limit of u may be at the end of the scale, which is not credible as a reading.
    if (tribo_q31_magnitude(u_q31) / 4u > feedforward->input_max / 4u)
    {
        return;
    }
    if (estimate->runs == 0u)
    {
        *estimate = (tribo_force_estimate_q31_t){.runs = 1, .lagged = u, .force = u, .low = -most, .high = most};
        turns     = ESTIMATE_FIRST_TURNS;
    }
    const uint32_t one  = UINT32_C(1) << 31;
    const uint32_t few  = one - tolerance / 2u;
    const uint32_t many = one + tolerance / 2u;
    estimate->lagged    = limit_q31(first_order_q31_step(estimate->lagged, u, feedforward->lag_part), -most, most);
    estimate->force     = stuck(friction, estimate->force, estimate->lagged, one, one, turns);
    estimate->low       = stuck(friction, estimate->low, estimate->lagged, many, few, turns);
    estimate->high      = stuck(friction, estimate->high, estimate->lagged, few, many, turns);
}
