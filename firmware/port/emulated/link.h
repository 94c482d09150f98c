/// Exchanges messages with the host (wire/tribo_wire.h) over two pipes and semihosting.

#ifndef EMULATED_LINK_H
#define EMULATED_LINK_H

#include "tribo_wire.h"

#include <stdbool.h>
#include <stdint.h>

/// Opens both pipes.
bool link_open(void);

bool link_send(tribo_wire_kind_t kind, const uint32_t *words, uint32_t count);

/// Waits for the next message. Returns false at the end of the link or for a message that is too long.
bool link_receive(uint32_t *kind, uint32_t words[TRIBO_WIRE_WORDS_MAX], uint32_t *count);

/// The cycles of the drive's ticks.
typedef struct
{
    uint32_t least, most, ticks;
    uint64_t sum;
} link_cycles_t;

/// Closes the link after END.
void link_close(const link_cycles_t *cycles);

void link_log(uint8_t byte);

/// Returns the core's counter of cycles; 0 if there is none.
uint32_t link_cycles(void);

/// The start of the tested RAM.
uint32_t *link_ram(void);

#endif
