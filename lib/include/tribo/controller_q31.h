/// Force controller in Q31; controller_f32.h explains anti-windup and change of params. The anti-windup's correction is
/// rounded down to 16 units of the first node, 2^-27 of its full scale, and to a unit of later ones.
/// Not synchronized: one state, one tick.

#ifndef TRIBO_CONTROLLER_Q31_H
#define TRIBO_CONTROLLER_Q31_H

#include "tribo/controller_f32.h"
#include "tribo/q31.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_controller_q31_params tribo_controller_q31_params_t;

/// Signals of one step, for logging.
typedef struct
{
    int32_t v;       ///< the cascade's output, Q31, saturated
    int32_t u;       ///< the limited sum, Q31
    bool    limited; ///< u differs from v + term
} tribo_controller_q31_signals_t;

/// Worst-case peaks as a fraction of full scale: L1 norms of the quantised cascade plus 2 %. For responses longer than
/// 4096 ticks they are upper bounds, as headroom_q31.c explains.
typedef struct
{
    float input;                             ///< peak of the input node
    float output[TRIBO_BIQUAD_SECTIONS_MAX]; ///< peak of each section's output node, below 2^scale
} tribo_headroom_q31_t;

/// Does what tribo_controller_f32_init does, in Q31. Returns TRIBO_OK, TRIBO_ERR_FULL_SCALE, a status of
/// tribo_controller_f32_init for the sections as given or as rounded, or TRIBO_ERR_HEADROOM if a peak is unbounded or
/// reaches 2^24 full scales, or if its response lasts for more than about 2^28 ticks. `headroom` may be null. It computes
/// in double: on a Cortex-M4F 8 million instructions for the paper's sections, 28 million for four slow ones.
tribo_status_t tribo_controller_q31_init(tribo_controller_q31_params_t       *params,
                                         const tribo_controller_f32_config_t *config,
                                         float                                full_scale_n,
                                         tribo_headroom_q31_t                *headroom);

// --- contents of the types above: reserve room for them; write only the members whose comment says so ---------------

typedef struct
{
    int32_t b0, c1;     ///< Q28, with the scales of both nodes in them
    int32_t minus_a1;   ///< Q28
    int32_t c2;         ///< Q(28 + shift), with the scales of both nodes in it
    int32_t d2, d2_low; ///< Q(28 + shift), and 2^-32 of that, to add
    uint8_t shift;      ///< s, 0 to 30
    uint8_t scale;      ///< 0 to 24: the section's output node holds y times 2^-scale
} tribo_biquad_q31_section_t;

/// Constants of the cascade.
typedef struct
{
    tribo_biquad_q31_section_t section[TRIBO_BIQUAD_SECTIONS_MAX];
    uint8_t                    count;        ///< 2 to 4: a pass-through follows a single section
    uint8_t                    input_scale;  ///< 0 to 24: the input node holds x times 2^-input_scale
    uint8_t                    output_scale; ///< the scale of the last section
} tribo_biquad_q31_params_t;

typedef struct
{
    int64_t w1, w2;
} tribo_biquad_q31_section_state_t;

typedef struct
{
    tribo_biquad_q31_section_state_t section[TRIBO_BIQUAD_SECTIONS_MAX];
    uint32_t                         carry;     ///< bits of the input dropped for its scale so far, from bit 31 down
    uint32_t                         saturated; ///< clamped values and restarted sections; stops at UINT32_MAX
} tribo_biquad_q31_state_t;

/// Constants of a step, computed by tribo_controller_q31_init. Constant from then on; several loops may share them.
struct tribo_controller_q31_params
{
    tribo_biquad_q31_params_t cascade;
    int32_t                   anti_windup; ///< c/D between the last and the input node: mantissa ...
    int32_t                   taken_max; ///< largest change of the last node by a limit; its correction fits every node
    int32_t                   u_min, u_max; ///< Q31
    uint8_t anti_windup_shift;              ///< ... and its exponent, 1 to 31: anti_windup 2^(anti_windup_shift - 32)
};

typedef struct
{
    tribo_biquad_q31_state_t cascade;       ///< contains the count of saturated values
    uint32_t                 limited_ticks; ///< since reset; stops at UINT32_MAX
} tribo_controller_q31_state_t;

#ifdef __cplusplus
}
#endif

#endif
