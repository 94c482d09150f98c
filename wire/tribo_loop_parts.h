/// A loop in physical units with its method and its guard, as in a scenario, in the message SETUP and in a drive's set.

#ifndef TRIBO_LOOP_PARTS_H
#define TRIBO_LOOP_PARTS_H

#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"

#include <stdbool.h>

/// `config` points to sections and a table elsewhere, which must outlive the params made from it.
typedef struct
{
    tribo_force_loop_f32_config_t  config;
    bool                           feeds_forward; ///< the feed-forward replaces the paper's method
    tribo_feedforward_f32_config_t feedforward;
    bool                           is_sensorless; ///< the feed-forward has no y
    tribo_sensorless_f32_config_t  sensorless;
    bool                           guarded;
    tribo_guard_f32_config_t       guard;
} tribo_loop_parts_t;

#endif
