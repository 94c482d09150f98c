// One tick of the controller: v = K(z) e, u = limit(v + term), and anti-windup. The caller has checked that e is
// finite.
//
// Without anti-windup the slow pole of K(z) would integrate e while u is limited, and u would stay at the limit long
// after e has changed sign. The conditioning technique (Hanus et al., see tribo/controller_f32.h) advances the states
// with the error that would have given the applied u. While u is within its limits it changes nothing.
//
//     e --> first half of the cascade --> v --(+ term)--> unsaturated --> limit --> u
//     e + (u - unsaturated) c/D --> second half of the cascade: the states

#ifndef TRIBO_CONTROLLER_ANTI_WINDUP_F32_H
#define TRIBO_CONTROLLER_ANTI_WINDUP_F32_H

#include "tribo/controller_f32.h"

#include "biquad_f32.h"

#include <stddef.h>

/// Calls the pause of `config`, if there is one, between two pieces of set-up. `config` may be null.
static inline void controller_f32_pause(const tribo_controller_f32_config_t *config)
{
    if (config != NULL && config->pause != NULL)
    {
        config->pause();
    }
}

/// Does what tribo_controller_f32_init does. `conditioned_by` is c of the anti-windup. It is kept if it is not 0 and
/// the cascade is stable with it. Otherwise the function chooses c and writes it back.
tribo_status_t tribo_controller_f32_prepare(tribo_controller_f32_params_t       *params,
                                            const tribo_controller_f32_config_t *config,
                                            float                               *conditioned_by);

/// Does the same for the section of a PI within its ranges (tribo_pi_f32_section) and accepted limits of u. Such a section
/// is stable, and with c = 1 unless ki is too small against kp. Returns TRIBO_OK or TRIBO_ERR_ANTI_WINDUP, and writes
/// `params` in both cases.
tribo_status_t tribo_controller_f32_init_pi(tribo_controller_f32_params_t       *params,
                                            const tribo_controller_f32_config_t *config);

/// Puts the cascade to rest and sets the counters to 0.
void tribo_controller_f32_reset(tribo_controller_f32_state_t *state);

/// The limit that `unsaturated` exceeds. 0 if it exceeds neither, because it is a NaN or a flipped bit has made a limit
/// one.
static inline float controller_f32_limit(const tribo_controller_f32_params_t *params, float unsaturated)
{
    if (unsaturated > params->u_max_n)
    {
        return params->u_max_n;
    }
    return unsaturated < params->u_min_n ? params->u_min_n : 0.0f;
}

/// Handles a sum beyond any credible force, which means a corrupt state. The cascade restarts from rest and u is the
/// limited term.
static inline float controller_f32_restart(const tribo_controller_f32_params_t *params,
                                           tribo_controller_f32_state_t        *state,
                                           float                                term_n,
                                           tribo_controller_f32_signals_t      *signals)
{
    const bool  limited = !within(term_n, params->u_min_n, params->u_max_n);
    const float u       = limited ? controller_f32_limit(params, term_n) : term_n;
    biquad_f32_restart(&state->cascade);
    *signals = (tribo_controller_f32_signals_t){.v_n = 0.0f, .u_n = u, .limited = limited};
    return u;
}

/// Second half of a tick: computes u for the cascade's output `v` and advances its states. u is within u_min_n to
/// u_max_n in any state.
static inline float controller_f32_apply(const tribo_controller_f32_params_t *params,
                                         tribo_controller_f32_state_t        *state,
                                         float                                e_n,
                                         float                                v,
                                         float                                term_n,
                                         const tribo_biquad_f32_outputs_t    *outputs,
                                         tribo_controller_f32_signals_t      *signals)
{
    const float unsaturated = v + term_n;
    const bool  limited     = !within(unsaturated, params->u_min_n, params->u_max_n);
    float       u           = unsaturated;
    if (limited) // true for NaN
    {
        count(&state->limited_ticks);
        if (exceeds(unsaturated, BIQUAD_F32_OUTPUT_MAX))
        {
            return controller_f32_restart(params, state, term_n, signals);
        }
        u = controller_f32_limit(params, unsaturated);
    }
    // v is the cascade's output before this tick's anti-windup; the limit changed the sum by u - v - term.
    signals->v_n     = v;
    signals->u_n     = u;
    signals->limited = limited;

    // Anti-windup: the states advance as if the error had been e + (u - unsaturated) c/D. D is the direct feedthrough
    // of the cascade, so c = 1 makes the conditioned output exactly u; where that is unstable, init has chosen a
    // smaller |c|.
    biquad_f32_advance(&params->cascade, &state->cascade, e_n, outputs, (u - unsaturated) * params->anti_windup);
    return u;
}

#endif
