/// From physical parameters to the Q31 params of the feed-forward and its parts, checked: quantize_q31.h says how.
///
/// Forces of a config are in N, FS is the force in N that is 2^31 in Q31 and 2^29 units inside. Besides what the f32 init functions
/// ask, in q31: forces are below FS/4 and at least 1e-6 FS, but for input_max_n up to FS, the weight up to FS/16, and
/// rate_max_n_per_s h up to FS/128; slide_rate_max_n_per_s h is up to FS/512; offset_time_s is over 2 h; spread_scale up to 1;
/// forgetting_per_n FS below 32; b/(K h) below 32,768 (or TRIBO_ERR_DAMPING); the lag of the path below 65,536 ticks, in
/// which r moves by up to FS/2 at rate_max_n_per_s (or TRIBO_ERR_LEAD). A low pass has a part of at least 1e-5 a tick.

#ifndef TRIBO_QUANTIZE_FEEDFORWARD_Q31_H
#define TRIBO_QUANTIZE_FEEDFORWARD_Q31_H

#include "tribo/feedforward_f32.h"
#include "tribo/feedforward_q31.h"
#include "tribo/quantize_q31.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Returns TRIBO_OK or what tribo_path_f32_init and tribo_arm_q31_init say. Writes nothing unless TRIBO_OK.
tribo_status_t tribo_path_q31_init(tribo_path_q31_params_t       *params,
                                   const tribo_path_f32_config_t *config,
                                   float                          sample_time_s);

/// Returns TRIBO_OK or what tribo_friction_meter_f32_init says; see above. Writes nothing unless TRIBO_OK.
tribo_status_t tribo_friction_meter_q31_init(tribo_friction_meter_q31_params_t *params,
                                             const tribo_path_f32_config_t     *path,
                                             float                              filter_time_s,
                                             float                              sample_time_s);

/// `design` in N becomes `params` of which a unit is 2^-29 full scales. Returns TRIBO_OK, TRIBO_ERR_NULL,
/// TRIBO_ERR_FULL_SCALE or what tribo_breakaway_learning_f32_init says; see above. Writes nothing unless TRIBO_OK.
tribo_status_t tribo_breakaway_learning_q31_init(tribo_breakaway_learning_q31_params_t       *params,
                                                 const tribo_breakaway_learning_f32_config_t *design,
                                                 float                                        full_scale_n);

/// Returns TRIBO_OK, TRIBO_ERR_FULL_SCALE or what tribo_hold_f32_init says; caution_travel_n is 1.25e-4 to 1e3 FS. Writes nothing
/// unless TRIBO_OK.
tribo_status_t tribo_hold_q31_init(tribo_hold_q31_params_t       *params,
                                   const tribo_hold_f32_config_t *config,
                                   float                          sample_time_s,
                                   float                          full_scale_n);

/// Returns TRIBO_OK, TRIBO_ERR_FULL_SCALE, or what tribo_feedforward_f32_init and the functions above say. Writes nothing
/// unless TRIBO_OK.
tribo_status_t tribo_feedforward_q31_init(tribo_feedforward_q31_params_t       *params,
                                          const tribo_feedforward_f32_config_t *config,
                                          const tribo_compensator_f32_config_t *model,
                                          float                                 input_max_n,
                                          float                                 sample_time_s,
                                          float                                 full_scale_n);

/// The whole loop with the feed-forward, as tribo_force_loop_feedforward_f32_init: `params` will point to `feedforward`. `table`
/// and `headroom` as for tribo_force_loop_q31_init. Returns what that and then tribo_feedforward_q31_init say; `table` is written
/// if the first is content.
tribo_status_t tribo_force_loop_feedforward_q31_init(tribo_force_loop_q31_params_t        *params,
                                                     tribo_breakaway_point_q31_t          *table,
                                                     tribo_feedforward_q31_params_t       *feedforward,
                                                     const tribo_force_loop_f32_config_t  *config,
                                                     const tribo_feedforward_f32_config_t *feedforward_config,
                                                     float                                 full_scale_n,
                                                     tribo_headroom_q31_t                 *headroom);

#ifdef __cplusplus
}
#endif

#endif
