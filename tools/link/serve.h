/// tribo-link serve: a drive on one page, for a browser on this machine.
///
///     GET /         the page               GET /list     the params: unit, range, what each is
///     GET /events   samples as they come   GET /values   the params' values
///     POST /do      a command of tribo-link, a word a line
///
/// No foreign web site may start a drive, or ask it so often that its host gets no turn. Every request must bring the token of the
/// printed address, name this server by a name that it knows (Host, against names that others point here), and come from no other
/// page (Origin, Sec-Fetch-Site). No GET changes anything, no page may frame this one.
///
/// One command runs at a time, and one trace in addition. A stop ends the running command and those that wait. A client has a
/// fixed time for its request, however often it sends a byte; if places are scarce, the oldest client without the token is dropped.

#ifndef LINK_SERVE_H
#define LINK_SERVE_H

#include "bus.h"

typedef struct
{
    const char *listen; ///< HOST:PORT; port 0: any free port
    const char *allow;  ///< another name of this machine; without one only loopback is served; null: none
    double      rate_hz;
    const char *unit, *baud; ///< as the command line has them, for the commands; baud is null on a network
} serve_t;

/// Serves until a signal ends it.
bool serve(link_bus_t *bus, const serve_t *options);

#endif
