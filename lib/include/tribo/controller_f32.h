/// Force controller, single precision: cascade, output limit, anti-windup, bumpless change of params.
///
///     v = K(z) e                         the cascade
///     u = limit(v + term)                u_min to u_max
///
/// While u is limited, the cascade's states advance as if the input had been e + (u - term - v) c / D, where D is the
/// cascade's direct feedthrough. c = 1 is Hanus' conditioning: with that input the output would have been u. It needs
/// zeros inside the unit circle. tribo_controller_f32_init finds the largest |c| = 1, 1/2, 1/4 ... of either sign for
/// which the conditioned cascade decays within 2^24 ticks. Every stable biproper cascade has such a c. A cascade with
/// one pole at z = 1 has such a c of one sign or the other; with two such poles many cascades have one. The init
/// rejects a cascade that no |c| of 1e-6 or more stabilises. Then a zero cancels an integrator, or zeros cancel poles
/// slower than about 10^-7 a tick and another zero is outside the unit circle.
///
/// Rounding costs 1.4e-7 N over the paper's triangle, compared with double precision. A ripple that lasts for minutes
/// is worse, because each output is rounded to the same side and the slow pole accumulates the error: +-20 mN at the
/// Nyquist frequency give up to 6e-6 N in a minute (tests/contract/test_controller.c). Q31 carries its rounding
/// remainders, so the same ripple costs 1.7e-8 N.
///
/// The only loop is over the sections. Not synchronized: one state, one tick.
/// Source: R. Hanus, M. Kinnaert, J.-L. Henrotte, "Conditioning technique, a general anti-windup and bumpless
/// transfer method", Automatica 23(6), 1987.

#ifndef TRIBO_CONTROLLER_F32_H
#define TRIBO_CONTROLLER_F32_H

#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_controller_f32_params tribo_controller_f32_params_t;

#define TRIBO_BIQUAD_SECTIONS_MAX 4u

/// A section in the delta operator. Stable when 0 < a2 < a1 and 4 - 2 a1 + a2 > 0: poles inside the unit circle. a2 =
/// 0, one pole at z = 1, is accepted as an integrator. Coefficients in z describe another filter here. The init refuses
/// most of them as unstable, but not those with positive a1 > a2. TRIBO_BIQUAD_F32 converts them.
typedef struct
{
    float b0, b1, b2; ///< each within +-1e6
    float a1, a2;
} tribo_biquad_f32_section_t;

/// Initialiser of a section from the coefficients in z, (b0 + b1 z^-1 + b2 z^-2) / (1 + a1 z^-1 + a2 z^-2). A row of
/// MATLAB's sos matrix without its fourth column has this form. Write constants with all their digits: the compiler
/// converts them in double, and no double remains in the program.
#define TRIBO_BIQUAD_F32(b0_, b1_, b2_, a1_, a2_)                                                                      \
    {(float)(b0_),                                                                                                     \
     (float)(2.0 * (b0_) + (b1_)),                                                                                     \
     (float)((double)(b0_) + (b1_) + (b2_)),                                                                           \
     (float)(2.0 + (a1_)),                                                                                             \
     (float)(1.0 + (double)(a1_) + (a2_))}

typedef struct
{
    const tribo_biquad_f32_section_t *sections; ///< K(z), the first section next to e; |b0| of each section 1e-6 to 1e6
    uint32_t                          section_count; ///< 1 to TRIBO_BIQUAD_SECTIONS_MAX
    float                             u_min_n;       ///< -1e6 to 0 N
    float                             u_max_n;       ///< 0 to 1e6 N, over u_min_n
    /// The init calls it after at most 30,000 operations each time, for example to serve a watchdog. May be null.
    void (*pause)(void);
    /// The init writes it if it refuses a section, or the whole cascade (as its first b0). May be null.
    tribo_refusal_t *refusal;
} tribo_controller_f32_config_t;

/// Signals of one step, for logging.
typedef struct
{
    float v_n;     ///< the cascade's output
    float u_n;     ///< the limited sum
    bool  limited; ///< u differs from v + term
} tribo_controller_f32_signals_t;

/// Checks `config`, copies the sections and finds the anti-windup. Returns TRIBO_OK, TRIBO_ERR_NULL, the status of the
/// first wrong field, or TRIBO_ERR_ANTI_WINDUP, which the top of this file explains. Writes nothing unless TRIBO_OK.
/// Not for the tick.
tribo_status_t tribo_controller_f32_init(tribo_controller_f32_params_t       *params,
                                         const tribo_controller_f32_config_t *config);

// --- contents of the types above: reserve room for them; write only the members whose comment says so ---------------

/// The cascade of a controller.
typedef struct
{
    tribo_biquad_f32_section_t section[TRIBO_BIQUAD_SECTIONS_MAX]; ///< the first is next to the input
    uint32_t                   count;                              ///< 2 to 4: a pass-through follows a single section
} tribo_biquad_f32_params_t;

typedef struct
{
    float w1, w2;
    float w2_carry; ///< accumulated rounding error of w2
} tribo_biquad_f32_section_state_t;

typedef struct
{
    tribo_biquad_f32_section_state_t section[TRIBO_BIQUAD_SECTIONS_MAX];
    uint32_t                         bad_inputs; ///< since reset; stops at UINT32_MAX
} tribo_biquad_f32_state_t;

/// Constants of a step, computed by tribo_controller_f32_init. Constant from then on; several loops may share them.
struct tribo_controller_f32_params
{
    tribo_biquad_f32_params_t cascade;
    float                     anti_windup; ///< c / D
    float                     u_min_n, u_max_n;
};

typedef struct
{
    tribo_biquad_f32_state_t cascade;
    uint32_t                 limited_ticks; ///< since reset; stops at UINT32_MAX
} tribo_controller_f32_state_t;

#ifdef __cplusplus
}
#endif

#endif
