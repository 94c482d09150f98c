/// Params that the drive makes itself, where the config is known only then: the emulated port gets it from the host. A
/// board's are made beforehand, by tribo-sim params, and no set-up code is in its image.

#ifndef DRIVE_LOOP_SETUP_H
#define DRIVE_LOOP_SETUP_H

#include "app/loop.h"

#include "tribo/status.h"

/// Not to be moved once it is set up.
typedef struct
{
    loop_params_t params;
#ifdef DRIVE_ARITH_Q31
    tribo_breakaway_point_q31_t table[TRIBO_BREAKAWAY_POINTS_MAX];
#endif
} loop_setup_t;

/// Checks `config` and computes `setup->params`; for `full_scale_n` see tribo/quantize_q31.h, f32 does not read it. An f32
/// breakaway table must live as long as the params. All or nothing. Not for the tick.
tribo_status_t loop_setup(loop_setup_t *setup, const tribo_force_loop_f32_config_t *config, float full_scale_n);

#endif
