/// Runs a program in QEMU that communicates over two pipes and semihosting (wire/tribo_wire.h). No wait exceeds
/// SIM_EMULATOR_TIMEOUT_S: an emulator that is missing, dies or hangs is an error. No files are created.

#ifndef SIM_EMULATOR_H
#define SIM_EMULATOR_H

#include "support/error.h"

#include <stdbool.h>
#include <stdint.h>

#define SIM_EMULATOR_TIMEOUT_S 5

typedef struct sim_emulator sim_emulator_t;

/// Starts `command`, a null-terminated list of arguments. Null on failure. The emulator dies with this program, however it
/// ends.
sim_emulator_t *sim_emulator_start(char *const *command, common_error_t *error);

/// Kills the emulator if it has not ended, and frees it.
void sim_emulator_stop(sim_emulator_t *emulator);

/// Waits until the program has ended by itself. Fails unless its status is 0.
bool sim_emulator_wait(sim_emulator_t *emulator, common_error_t *error);

bool sim_emulator_send(sim_emulator_t *emulator,
                       uint32_t        kind,
                       const uint32_t *words,
                       uint32_t        count,
                       common_error_t *error);

/// Receives the next message. Fails unless the message has this kind and length.
bool sim_emulator_receive(sim_emulator_t *emulator,
                          uint32_t        kind,
                          uint32_t       *words,
                          uint32_t        count,
                          common_error_t *error);

/// Returns the last line printed by the emulator or its program, "" if none. Valid until the next call.
const char *sim_emulator_last_line(sim_emulator_t *emulator);

#endif
