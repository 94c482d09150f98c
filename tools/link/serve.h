/// tribo-link serve: a drive on one page, for a browser on this machine.
///
///     GET /         the page               GET /list     the params: unit, range, what each is
///     GET /events   samples as they come   GET /values   the params' values
///     POST /do      a command of tribo-link, a word a line
///
/// No web site of others may start a drive, or ask it so often that its host has no turn. Every request must bring the token of the
/// printed address, name this server by a name that it knows (Host, against names that others point here), and come from no other
/// page (Origin, Sec-Fetch-Site). No GET changes anything, no page may frame this one.
///
/// One command works at a time, and one trace beside it. A stop ends the command that works and those that wait. A client has so
/// many seconds for its request however often it sends a byte; while places are scarce, the oldest one without the token goes.

#ifndef LINK_SERVE_H
#define LINK_SERVE_H

#include "bus.h"

typedef struct
{
    const char *listen; ///< HOST:PORT; port 0: any that is free
    const char *allow;  ///< a further name of this machine; without one nothing but loopback is listened on; null: none
    double      rate_hz;
    const char *unit, *baud; ///< as the command line has them, for the commands
} serve_t;

/// Until a signal ends it.
bool serve(link_bus_t *bus, const serve_t *options);

#endif
