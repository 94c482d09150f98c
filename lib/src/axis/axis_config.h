// From the config of an axis to those of the parts below, for both arithmetics.

#ifndef TRIBO_AXIS_AXIS_CONFIG_H
#define TRIBO_AXIS_AXIS_CONFIG_H

#include "tribo/axis_f32.h"

#include <stddef.h>

/// Fills in `loop`, but for the method and the guard. Returns TRIBO_OK or the first status of the fields that the loop's init does not check.
tribo_status_t tribo_axis_config_expand(tribo_force_loop_f32_config_t *loop, const tribo_axis_f32_config_t *config);

/// The guard for a loop that its init accepts.
tribo_guard_f32_config_t tribo_axis_config_guard(const tribo_force_loop_f32_config_t *loop,
                                                 const tribo_axis_f32_config_t       *config);

/// Breakaway as configured, at the usual force.
float tribo_axis_config_breakaway(const tribo_force_loop_f32_config_t *loop);

/// CRC-32 (IEEE 802.3) of `size` bytes.
uint32_t tribo_axis_checksum(const void *bytes, size_t size);

/// Of the numbers that what is learned refers to.
uint32_t tribo_axis_config_rig(const tribo_force_loop_f32_config_t *loop,
                               const tribo_axis_f32_config_t       *config,
                               float                                full_scale_n);

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
