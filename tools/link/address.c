#include "address.h"

#include "bus.h"
#include "support/number.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define PORT_MAX 65535u

/// Returns the end of the host, or null after a complaint. `text` starts after the opening bracket, if there is one.
static const char *end_of_host(const char *name, const char *text, bool is_in_brackets)
{
    const char *end = text + strcspn(text, is_in_brackets ? "]" : ":");
    if (is_in_brackets && (*end != ']' || (end[1] != ':' && end[1] != '\0')))
    {
        (void)link_complain("%s: [HOST]:PORT is expected", name);
        return NULL;
    }
    if (!is_in_brackets && *end == ':' && strchr(end + 1, ':') != NULL)
    {
        (void)link_complain("%s: an IPv6 address is expected in brackets: [%s] or [HOST]:PORT", name, text);
        return NULL;
    }
    if (end == text || (size_t)(end - text) >= LINK_HOST_MAX)
    {
        (void)link_complain("%s: host: %s", name, end == text ? "empty" : "too long");
        return NULL;
    }
    return end;
}

static bool read_port(const char *name, const char *text, unsigned lowest, link_address_t *address)
{
    uint64_t port;
    if (common_number_parse_whole(text, &port) != NULL || port < lowest || port > PORT_MAX)
    {
        return link_complain("%s: port: value %s: %u to %u", name, text[0] != '\0' ? text : "\"\"", lowest, PORT_MAX);
    }
    (void)snprintf(address->port, sizeof address->port, "%" PRIu64, port);
    return true;
}

struct addrinfo *link_address_find(const char            *name,
                                   const char            *text,
                                   const char            *port,
                                   unsigned               lowest,
                                   const struct addrinfo *wanted,
                                   link_address_t        *address)
{
    struct addrinfo *found          = NULL;
    const bool       is_in_brackets = text[0] == '[';
    const char      *host           = text + is_in_brackets;
    const char      *end            = end_of_host(name, host, is_in_brackets);
    if (end == NULL)
    {
        return NULL;
    }
    (void)snprintf(address->host, sizeof address->host, "%.*s", (int)(end - host), host);
    end += is_in_brackets;
    if (*end != ':' && port == NULL)
    {
        (void)link_complain("%s: HOST:PORT is expected", name);
        return NULL;
    }
    if (!read_port(name, *end == ':' ? end + 1 : port, lowest, address))
    {
        return NULL;
    }
    const int wrong = getaddrinfo(address->host, address->port, wanted, &found);
    if (wrong != 0)
    {
        (void)link_complain("%s: host unknown: %s: there is no such address (%s)",
                            name,
                            address->host,
                            gai_strerror(wrong));
        return NULL;
    }
    return found;
}
