/// Params made in the drive itself, of a config in physical units.

#ifndef DRIVE_LOOP_SETUP_H
#define DRIVE_LOOP_SETUP_H

#include "app/loop.h"

#include "tribo/guard_f32.h"
#include "tribo/status.h"

/// Must not move after set-up: params may point to the table.
typedef struct
{
    loop_params_t params;
#if DRIVE_FEEDFORWARD
    loop_feedforward_params_t feedforward; ///< if there is one
    loop_guard_params_t       guard;
#endif
#ifdef DRIVE_ARITH_Q31
    tribo_breakaway_point_q31_t table[TRIBO_BREAKAWAY_POINTS_MAX];
#endif
} loop_setup_t;

/// Checks `config` and computes `setup->params`. f32 ignores `full_scale_n` (see tribo/quantize_q31.h), and its params point
/// to the breakaway table of `config`, which must outlive them. Writes all or nothing. Not for the tick.
tribo_status_t loop_setup(loop_setup_t *setup, const tribo_force_loop_f32_config_t *config, float full_scale_n);

#if DRIVE_FEEDFORWARD
/// The same of a loop that feeds friction forward. Its memory: loop_forget and drive_attach.
tribo_status_t loop_setup_feedforward(loop_setup_t                         *setup,
                                      const tribo_force_loop_f32_config_t  *config,
                                      const tribo_feedforward_f32_config_t *feedforward,
                                      float                                 full_scale_n);

/// The guard's, which is not on then, for a loop of this sample time and full scale. Writes all or nothing.
tribo_status_t loop_setup_guard(loop_guard_params_t            *guard,
                                const tribo_guard_f32_config_t *config,
                                float                           sample_time_s,
                                float                           full_scale_n);
#endif

#endif
