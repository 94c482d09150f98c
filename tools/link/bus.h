/// A drive on a serial line or a network, by libmodbus. Functions return false after they have said on stderr what is wrong.

#ifndef LINK_BUS_H
#define LINK_BUS_H

#include "list.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct link_bus link_bus_t;

/// Opens `device`, a serial line or tcp:HOST[:PORT], and checks that a drive answers whose lists are those of this program; null
/// if not.
link_bus_t *link_bus_open(const char *device, int unit, int baud);
void        link_bus_close(link_bus_t *bus);

/// Whether anything answers there as a drive does, at once and without a word.
bool link_bus_answers(const char *device, int unit, int baud);

/// Stops the drive on a network while another client has it, where all but a stop is refused: 1. 0, without a word, if no other has
/// it, or nothing answers; negative, after a complaint: there can be no such device.
int link_bus_stop_beside(const char *device, int unit);

/// The device as it was opened.
const char *link_bus_name(const link_bus_t *bus);

/// Leaves the line to others, and takes it back: the only time when it is not locked. A network's connection is closed meanwhile.
void link_bus_release(link_bus_t *bus);
bool link_bus_take(link_bus_t *bus);

/// The one, a wait, and the other.
bool link_bus_rest(link_bus_t *bus, int ms);

/// Whether the drive was built with the feed-forward, whose params others have not.
bool link_bus_feeds_forward(const link_bus_t *bus);

/// `count` 32-bit words, however many frames that takes.
bool link_bus_read(link_bus_t *bus, uint16_t address, uint32_t *words, unsigned count);
bool link_bus_write(link_bus_t *bus, uint16_t address, const uint32_t *words, unsigned count);

/// Writes a word and reads up to REGISTERS_WINDOW words of the window in one frame.
bool link_bus_window(link_bus_t *bus, uint32_t position, uint32_t *words, unsigned count);

/// Of a state, a signal or a request.
bool link_bus_state(link_bus_t *bus, const char *name, uint32_t *word);

/// Applies the staged set. Where that changes what protects, says so and writes the key first.
bool link_bus_apply(link_bus_t *bus, const char *what);

/// Sends a command (registers_command_t) and waits for its outcome. False, with the drive's reason on stderr, if it refuses.
bool link_bus_command(link_bus_t *bus, unsigned command, const char *what);

float    link_float(uint32_t word);
uint32_t link_word(float number);

/// A message on stderr, behind the program's name. Always false.
bool link_complain(const char *format, ...) __attribute__((format(printf, 1, 2)));

#endif
