/// tribo-link serve: a drive on one page, for a browser on this machine.
///
///     GET /         the page               GET /list     the params: unit, range, what each is
///     GET /events   samples as they come   GET /values   the params' values
///     POST /do      a command of tribo-link, a word a line
///
/// A web site of whoever must not start a drive. So a request must name this server by a name that it knows (Host, against names
/// that others point here), must not come from a page of another origin (Origin), and where it changes anything must bring the
/// token that only the page has. No GET changes anything, no page may frame this one.

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
