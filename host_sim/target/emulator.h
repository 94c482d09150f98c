/// A program in QEMU that talks over two pipes and semihosting (wire/tribo_wire.h). Nothing here waits for longer than
/// SIM_EMULATOR_TIMEOUT_S: an emulator that is missing, dies or hangs is an error. Nothing is created in the file system.

#ifndef SIM_EMULATOR_H
#define SIM_EMULATOR_H

#include "support/error.h"

#include <stdbool.h>
#include <stdint.h>

#define SIM_EMULATOR_TIMEOUT_S 5

typedef struct sim_emulator sim_emulator_t;

/// Starts `command`, a list of arguments that ends with null. Null on failure. The emulator dies with this program, however
/// that ends.
sim_emulator_t *sim_emulator_start(char *const *command, sim_error_t *error);

/// Kills it if it has not ended, and frees it.
void sim_emulator_stop(sim_emulator_t *emulator);

/// Waits until the program has ended by itself, which must be with status 0.
bool sim_emulator_wait(sim_emulator_t *emulator, sim_error_t *error);

bool sim_emulator_send(sim_emulator_t *emulator,
                       uint32_t        kind,
                       const uint32_t *words,
                       uint32_t        count,
                       sim_error_t    *error);

/// The next message, which must be of this kind and length.
bool sim_emulator_receive(sim_emulator_t *emulator, uint32_t kind, uint32_t *words, uint32_t count, sim_error_t *error);

/// The last line that the emulator or its program has printed, "" if none. Valid until the next call.
const char *sim_emulator_last_line(sim_emulator_t *emulator);

#endif
