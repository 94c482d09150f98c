/// From physical parameters to Q31 params, checked: the set-up side of the _q31 modules.
///
/// These functions take the same config structs as the f32 functions, and the full scale FS, the force in N that is 2^31. They
/// check every field, quantise, check again on the quantised numbers (stability, range, headroom), and write all or
/// nothing. They use float, so they live in a file of their own: a program whose params were made on the host links none
/// of it. Not for the tick; a cascade takes some 10^5 float operations to measure, a slow one up to 10^8.
///
/// Besides what the f32 init functions ask, in q31: every force of a config is below FS, limits and input_max_n up to FS;
/// a breakaway, input_max_n and u_max_n - u_min_n are at least 1e-6 FS and the relays' levels 1e-6, which leaves them 11
/// bits, and set_level times the smallest breakaway is at least one bit (or TRIBO_ERR_SET_LEVEL); an arm's K h^2/I and damping
/// keep its coefficients below 4 and its quantised poles inside the unit circle;
/// m FS/(6 v0 h) is below 2^31 (or TRIBO_ERR_V0), as v0 would be less than a bit a tick otherwise.
///
/// Headroom: the worst-case peak of each node is its L1 norm from the inputs in their full range. For a plain cascade
/// the input is x within FS. For a controller they are e within FS and, as the anti-windup makes the states follow what
/// was really put out, u - feedforward within u_max + FS; so a slow pole or an integrator costs no headroom.
/// A response is followed for 131,072 ticks; what it has left by then must be a single slow pole, whose tail is added.

#ifndef TRIBO_QUANTIZE_Q31_H
#define TRIBO_QUANTIZE_Q31_H

#include "tribo/force_loop_f32.h"
#include "tribo/force_loop_q31.h"
#include "tribo/guard_f32.h"
#include "tribo/guard_q31.h"
#include "tribo/lugre_f32.h"
#include "tribo/lugre_q31.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Worst-case peaks as a fraction of full scale, as bounded by L1 norms on the quantised numbers.
typedef struct
{
    float input;                                 ///< of the input node
    float output[TRIBO_BIQUAD_Q31_SECTIONS_MAX]; ///< of each section's output node; 2^scale is above it
} tribo_headroom_q31_t;

/// `table` takes the config's table in Q31, config->table_length points that live as long as the params; null if the
/// config has none. Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_FULL_SCALE or what tribo_friction_f32_init says.
tribo_status_t tribo_friction_q31_init(tribo_friction_q31_params_t       *params,
                                       tribo_breakaway_point_q31_t       *table,
                                       const tribo_friction_f32_config_t *config,
                                       float                              sample_time_s,
                                       float                              full_scale_n);

/// Returns TRIBO_OK or what tribo_arm_f32_init says; TRIBO_ERR_ARM_TOO_FAST when gamma_d reaches 4, TRIBO_ERR_DAMPING
/// when the quantised arm is not stable.
tribo_status_t tribo_arm_q31_init(tribo_arm_q31_params_t       *params,
                                  const tribo_arm_f32_config_t *config,
                                  float                         sample_time_s);

/// Friction and arm; see the two.
tribo_status_t tribo_compensator_q31_init(tribo_compensator_q31_params_t       *params,
                                          tribo_breakaway_point_q31_t          *table,
                                          const tribo_compensator_f32_config_t *config,
                                          float                                 sample_time_s,
                                          float                                 full_scale_n);

/// LuGre, with the arm that it holds. Returns TRIBO_OK, TRIBO_ERR_NULL or what tribo_lugre_f32_init says;
/// TRIBO_ERR_BRISTLE_DAMPING also where 1 + a + b (lugre_f32.h) is 2^21 or more.
tribo_status_t tribo_lugre_q31_init(tribo_lugre_q31_params_t       *params,
                                    const tribo_lugre_f32_config_t *config,
                                    const tribo_arm_f32_config_t   *arm,
                                    float                           sample_time_s);

/// The guard. Returns TRIBO_OK, TRIBO_ERR_FULL_SCALE or what tribo_guard_f32_init says; turn_n and stray_n are 1e-6 FS to under FS.
/// Writes nothing unless TRIBO_OK.
tribo_status_t tribo_guard_q31_init(tribo_guard_q31_params_t       *params,
                                    const tribo_guard_f32_config_t *config,
                                    float                           sample_time_s,
                                    float                           full_scale_n);

/// A plain cascade. Returns TRIBO_OK or what tribo_biquad_f32_init says; TRIBO_ERR_HEADROOM when a peak has no bound (an
/// integrator), none that can be told (two poles of some 10^-6 a tick or slower) or is 2^24 full scales or more. `headroom` may be null.
tribo_status_t tribo_biquad_q31_init(tribo_biquad_q31_params_t        *params,
                                     const tribo_biquad_f32_section_t *sections,
                                     uint32_t                          count,
                                     tribo_headroom_q31_t             *headroom);

/// A controller. Returns TRIBO_OK, TRIBO_ERR_FULL_SCALE or what tribo_controller_f32_init says; TRIBO_ERR_HEADROOM as for a
/// plain cascade. `headroom` may be null.
tribo_status_t tribo_controller_q31_init(tribo_controller_q31_params_t       *params,
                                         const tribo_controller_f32_config_t *config,
                                         float                                full_scale_n,
                                         tribo_headroom_q31_t                *headroom);

/// The whole loop: `table` as for the friction, `headroom` (may be null) as for the controller.
tribo_status_t tribo_force_loop_q31_init(tribo_force_loop_q31_params_t       *params,
                                         tribo_breakaway_point_q31_t         *table,
                                         const tribo_force_loop_f32_config_t *config,
                                         float                                full_scale_n,
                                         tribo_headroom_q31_t                *headroom);

/// The same with LuGre in the compensator (force_loop_lugre_q31.h): `params` will point to `lugre`. Returns what
/// tribo_force_loop_q31_init and then tribo_lugre_q31_init say. Nothing but the table is written unless TRIBO_OK.
tribo_status_t tribo_force_loop_lugre_q31_init(tribo_force_loop_q31_params_t       *params,
                                               tribo_breakaway_point_q31_t         *table,
                                               tribo_lugre_q31_params_t            *lugre,
                                               const tribo_force_loop_f32_config_t *config,
                                               const tribo_lugre_f32_config_t      *lugre_config,
                                               float                                full_scale_n,
                                               tribo_headroom_q31_t                *headroom);

#ifdef __cplusplus
}
#endif

#endif
