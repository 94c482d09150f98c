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

/// Reads `text` and looks its host up; `name` begins the complaint, with the field and the range. A null `port` must be given.
/// `lowest` is the least port that makes sense: 0 where any free one will do. Null after a complaint, else for freeaddrinfo.
struct addrinfo *link_address_find(const char            *name,
                                   const char            *text,
                                   const char            *port,
                                   unsigned               lowest,
                                   const struct addrinfo *wanted,
                                   link_address_t        *address);

#endif
