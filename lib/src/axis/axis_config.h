// Derives the configs of loop and guard from that of an axis, for both arithmetics, and names the bits of its warnings.

#ifndef TRIBO_AXIS_AXIS_CONFIG_H
#define TRIBO_AXIS_AXIS_CONFIG_H

#include "tribo/axis_f32.h"

#include <stddef.h>

// Bits of the warnings of a report.
#define WARN_BAD_INPUT 1u
#define WARN_LIMITED   2u
#define WARN_TOO_SMALL 4u
#define WARN_HUNTING   16u
#define WARN_OVERSHOOT 32u
#define WARN_FORGOTTEN 64u
#define WARN_LATE      128u
#define WARN_TOO_LARGE 256u
#define WARN_LONG      512u
#define WARN_SHORT     1024u
#define WARN_CALLS     2048u

/// Fills in `loop` except for the method and the guard. `most_n` is the largest force of the arithmetic: 1e6 N, or the
/// full scale. Checks the fields that the loop's init does not check. Returns TRIBO_OK or the status of the first bad
/// one.
tribo_status_t tribo_axis_config_expand(tribo_force_loop_f32_config_t *loop,
                                        const tribo_axis_f32_config_t *config,
                                        float                          most_n);

#endif
