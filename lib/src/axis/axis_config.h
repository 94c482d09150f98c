// Derives the configs of loop and guard from that of an axis, and its report, for both arithmetics.

#ifndef TRIBO_AXIS_AXIS_CONFIG_H
#define TRIBO_AXIS_AXIS_CONFIG_H

#include "tribo/axis_f32.h"

#include <stddef.h>

/// Fills in `loop` except for the method and the guard. `most_n` is the largest force of the arithmetic: 1e6 N, or the
/// full scale. Checks the fields that the loop's init does not check. Returns TRIBO_OK or the status of the first bad
/// one.
tribo_status_t tribo_axis_config_expand(tribo_force_loop_f32_config_t *loop,
                                        const tribo_axis_f32_config_t *config,
                                        float                          most_n);

/// The config of the guard, with forces from `least_n` to `most_n`. `loop` must be one that the loop's init accepts.
tribo_guard_f32_config_t tribo_axis_config_guard(const tribo_force_loop_f32_config_t *loop,
                                                 const tribo_axis_f32_config_t       *config,
                                                 float                                least_n,
                                                 float                                most_n);

/// The status of the loop's init, about the field that the axis' config has instead of a derived one.
tribo_status_t tribo_axis_config_status(tribo_status_t status, const tribo_axis_f32_config_t *config);

/// CRC-32 (IEEE 802.3) of `size` bytes.
uint32_t tribo_axis_checksum(const void *bytes, size_t size);

/// Fills in one direction of a report.
void tribo_axis_report_direction(tribo_axis_report_t               *report,
                                 uint32_t                           direction,
                                 const tribo_feedforward_learned_t *learned,
                                 float                              breakaway_n);

/// True if friction is at the upper limit of learning, or if a load many times the configured breakaway takes its place
/// while slides both ways have not settled friction.
bool tribo_axis_is_far_below(const tribo_feedforward_learning_t *learning,
                             const tribo_feedforward_learner_t  *learner,
                             float                               usual_force_n);

/// Fills in the warnings of a report with its counters, except those of tribo_axis_report_far.
void tribo_axis_report_warn(tribo_axis_report_t               *report,
                            const tribo_feedforward_learned_t *learned,
                            tribo_guard_cause_t                cause,
                            bool                               is_miscalled);

/// Completes a report by times_less, breakaway_factor and the warnings of a wrong breakaway or presliding.
/// `is_far_below` is latched.
void tribo_axis_report_far(tribo_axis_report_t                *report,
                           const tribo_feedforward_learning_t *learning,
                           const tribo_feedforward_learner_t  *learner,
                           bool                                is_far_below);

#endif
