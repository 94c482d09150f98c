/// Converts a loop's values to the library's configuration, in single precision.

#ifndef COMMON_LOOP_CONFIG_H
#define COMMON_LOOP_CONFIG_H

#include "loop/loop_keys.h"
#include "tribo_loop_parts.h"

/// The parts, and the arrays to which their config points. They must not move, and must outlive the params made from them.
typedef struct
{
    tribo_loop_parts_t          parts;
    tribo_biquad_f32_section_t  sections[TRIBO_BIQUAD_SECTIONS_MAX];
    tribo_breakaway_point_f32_t table[TRIBO_BREAKAWAY_POINTS_MAX];
} common_loop_config_t;

void common_loop_config_fill(common_loop_config_t *loop, const common_loop_keys_t *keys);

/// Returns the status of the library's set-up for this loop.
tribo_status_t common_loop_config_status(const common_loop_config_t *loop);

#endif
