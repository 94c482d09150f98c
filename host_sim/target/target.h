/// Runs the drive's firmware on an emulated microcontroller, or on a board at a serial line (serial:DEVICE), in lock-step
/// with the plant on this host. The same loop runs on the host, and each word from the target is compared with that of the
/// host, bit by bit.

#ifndef SIM_TARGET_H
#define SIM_TARGET_H

#include "scenario/loop.h"
#include "support/error.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct sim_target sim_target_t;

/// The result of a run.
typedef struct
{
    uint64_t ticks;
    uint64_t different_ticks;                        ///< ticks with a word that differs from the host's
    uint64_t limited_ticks;                          ///< counted by the target
    uint64_t bad_inputs;                             ///< counted by the target
    uint32_t cycles_least, cycles_mean, cycles_most; ///< cycles of a tick on a board with a counter, otherwise 0
    double   ticks_per_s;                            ///< ticks a second of wall time in lock-step, without the plant
    char     difference[512];                        ///< text on the first difference; "" if there is none
} sim_target_result_t;

/// Starts the image for target `name` in its emulator and sets up its loop with `config`, which must outlive it, and in q31
/// with `full_scale_n`, or that of the board. Null on failure. Images are in the folder TRIBO_FIRMWARE, by default the build
/// trees.
sim_target_t *sim_target_start(const char                 *name,
                               bool                        q31,
                               const common_loop_config_t *config,
                               double                      full_scale_n,
                               common_error_t             *error);

/// Runs one tick of the drive. `u_n` is exactly the command that the power stage receives.
bool sim_target_step(sim_target_t                   *target,
                     double                          r_n,
                     double                          y_n,
                     double                         *u_n,
                     tribo_force_loop_f32_signals_t *signals,
                     common_error_t                 *error);

/// Returns the same loop, computed on this host.
const sim_loop_t *sim_target_twin(const sim_target_t *target);

/// Ends the firmware. Returns false if it does not end as requested. A difference from the host is a result, not a failure.
bool sim_target_finish(sim_target_t *target, sim_target_result_t *result, common_error_t *error);

void sim_target_destroy(sim_target_t *target);

/// Return whether this target exists, and the names of all targets, separated by ", ".
bool        sim_target_exists(const char *name);
const char *sim_target_names(void);

#endif
