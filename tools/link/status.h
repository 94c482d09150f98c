/// Shows the state of a drive: as text, as JSON, and live.

#ifndef LINK_STATUS_H
#define LINK_STATUS_H

#include "bus.h"

/// The name of a drive's state; never null.
const char *status_state_text(uint32_t state);

#define STATUS_REASON_MAX 160u

/// Says why a drive in this state refuses a command, and the way out.
void status_refusal(unsigned command, uint32_t state, uint32_t fault, char reason[STATUS_REASON_MAX]);

/// Prints all states, counters and signals, as lines or as one JSON object.
bool status_show(link_bus_t *bus, bool json);

/// Prints the state, the force and the learned values, in a few lines.
bool status_show_short(link_bus_t *bus);

/// Room for a sample, above PlotJuggler's limit.
#define STATUS_SAMPLE_MAX 2048u

/// Reads a sample as a line of JSON. Returns its length, or 0 after a complaint.
size_t status_sample(link_bus_t *bus, char text[STATUS_SAMPLE_MAX]);

typedef struct
{
    double      rate_hz, hold_s;
    bool        json;     ///< a line for each sample on standard output, in place of the view
    const char *udp;      ///< HOST:PORT that gets the same lines; null: none
    const char *teleplot; ///< HOST:PORT that gets lines in Teleplot's format; null: none
} status_watch_t;

/// Samples the drive until the time is over or a signal ends it. On a terminal it redraws a view.
bool status_watch(link_bus_t *bus, const status_watch_t *watch);

#endif
