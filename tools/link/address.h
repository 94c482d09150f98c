/// Addresses as users write them: HOST[:PORT], an IPv6 address in brackets.

#ifndef LINK_ADDRESS_H
#define LINK_ADDRESS_H

#include <netdb.h>
#include <stdbool.h>

#define LINK_HOST_MAX 256

typedef struct
{
    char host[LINK_HOST_MAX]; ///< without brackets
    char port[6];
} link_address_t;

/// Reads `text` and looks its host up; `name` begins the complaint, with the field and the range. If `port` is null, the text must have one.
/// `lowest` is the lowest valid port, 0 if any free port will do. Returns null after a complaint, or a list for freeaddrinfo.
struct addrinfo *link_address_find(const char            *name,
                                   const char            *text,
                                   const char            *port,
                                   unsigned               lowest,
                                   const struct addrinfo *wanted,
                                   link_address_t        *address);

#endif
