// From the config of an axis to those of the parts below, for both arithmetics.

#ifndef TRIBO_AXIS_AXIS_CONFIG_H
#define TRIBO_AXIS_AXIS_CONFIG_H

#include "tribo/axis_f32.h"

#include <stddef.h>

/// What the init functions below read. `section` holds the PI, and what stands for the caller's own controller.
typedef struct
{
    tribo_force_loop_f32_config_t loop;
    tribo_biquad_f32_section_t    section;
} axis_parts_t;

/// Fills in `parts`; they point to themselves. Returns TRIBO_OK or the first status of the fields that the parts below do not check.
tribo_status_t tribo_axis_config_expand(axis_parts_t *parts, const tribo_axis_f32_config_t *config);

/// The guard for parts of which a loop has been made.
tribo_guard_f32_config_t tribo_axis_config_guard(const axis_parts_t *parts, const tribo_axis_f32_config_t *config);

/// Breakaway as configured, at the usual force.
float tribo_axis_config_breakaway(const axis_parts_t *parts);

/// CRC-32 (IEEE 802.3) of `size` bytes.
uint32_t tribo_axis_checksum(const void *bytes, size_t size);

/// Of the numbers that what is learned refers to.
uint32_t tribo_axis_config_rig(const axis_parts_t *parts, const tribo_axis_f32_config_t *config, float full_scale_n);

/// One direction of a report.
void tribo_axis_report_direction(tribo_axis_report_t               *report,
                                 uint32_t                           direction,
                                 const tribo_feedforward_learned_t *learned,
                                 float                              breakaway_n);

/// The warnings of a report that is else complete.
void tribo_axis_report_warn(tribo_axis_report_t               *report,
                            const tribo_feedforward_learned_t *learned,
                            tribo_guard_cause_t                cause);

#endif
