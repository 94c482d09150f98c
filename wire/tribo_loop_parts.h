/// A loop in physical units with its method and its guard: what a scenario says, the message SETUP carries and a drive's set holds.

#ifndef TRIBO_LOOP_PARTS_H
#define TRIBO_LOOP_PARTS_H

#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"

#include <stdbool.h>

/// `config` points to sections and a table somewhere else, which outlive the params made of it.
typedef struct
{
    tribo_force_loop_f32_config_t  config;
    bool                           feeds_forward; ///< instead of the paper's method
    tribo_feedforward_f32_config_t feedforward;
    bool                           is_sensorless; ///< and does so without y
    tribo_sensorless_f32_config_t  sensorless;
    bool                           guarded;
    tribo_guard_f32_config_t       guard;
} tribo_loop_parts_t;

#endif
