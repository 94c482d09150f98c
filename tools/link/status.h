/// What a drive says of itself: for a person, as JSON, and live.

#ifndef LINK_STATUS_H
#define LINK_STATUS_H

#include "bus.h"

/// Words of a drive's state. Not null.
const char *status_state_text(uint32_t state);

/// All states, counters and signals on standard output, as lines or as one JSON object.
bool status_show(link_bus_t *bus, bool json);

/// The state, the force and what was learned, in a few lines.
bool status_show_short(link_bus_t *bus);

/// Room for a sample: PlotJuggler takes less than that.
#define STATUS_SAMPLE_MAX 2048u

/// Reads a sample as a line of JSON; its length, 0 after a complaint.
size_t status_sample(link_bus_t *bus, char text[STATUS_SAMPLE_MAX]);

typedef struct
{
    double      rate_hz, hold_s;
    bool        json;     ///< a line for each sample on standard output, in place of the view
    const char *udp;      ///< HOST:PORT that the same goes to; null: none
    const char *teleplot; ///< HOST:PORT that lines of Teleplot go to; null: none
} status_watch_t;

/// Samples the drive until the time is over or a signal ends it. On a terminal a view that is drawn again and again.
bool status_watch(link_bus_t *bus, const status_watch_t *watch);

#endif
