/// A board on a serial line that speaks wire/tribo_wire.h, each message with its CRC. No wait exceeds SIM_SERIAL_TIMEOUT_S,
/// even while bytes trickle in.

#ifndef SIM_SERIAL_H
#define SIM_SERIAL_H

#include "support/error.h"

#include <stdbool.h>
#include <stdint.h>

#define SIM_SERIAL_TIMEOUT_S 5
#define SIM_SERIAL_BAUD      921600

typedef struct sim_serial sim_serial_t;

/// Opens `device` exclusively, e.g. /dev/ttyUSB0, or with its rate /dev/ttyUSB0,115200. Null on failure.
sim_serial_t *sim_serial_open(const char *device, common_error_t *error);
void          sim_serial_close(sim_serial_t *serial);

/// Requests HELLO until the board answers, and drops earlier bytes.
bool sim_serial_hello(sim_serial_t *serial, uint32_t *words, uint32_t count, common_error_t *error);

bool sim_serial_send(sim_serial_t *serial, uint32_t kind, const uint32_t *words, uint32_t count, common_error_t *error);

/// Receives the next message. Fails unless the message is complete and has this kind and length.
bool sim_serial_receive(sim_serial_t *serial, uint32_t kind, uint32_t *words, uint32_t count, common_error_t *error);

#endif
