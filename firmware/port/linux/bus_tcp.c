#include "bus_lines.h"

#include "support/clock.h"

#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define CLIENTS     8 ///< the client that has the drive, and others that may stop it
#define NOBODY      (-1)
#define MS_PER_S    1000
#define HEAD        7 ///< bytes: number, protocol, length of what follows, unit
#define LENGTH_AT   4
#define FRAME_MAX   (HEAD + MODBUS_PDU_MAX)
#define END_TEXT    96
#define KEEP_IDLE_S 2 ///< after this time the kernel probes a silent client once a second ...
#define KEEP_TRIALS 3 ///< ... this many times
#define BACKLOG     16

typedef struct
{
    int     socket; ///< negative: free
    uint8_t bytes[FRAME_MAX];
    size_t  length;
    size_t  late;    ///< bytes from the first on that came while the program could not answer
    double  heard_s; ///< when the client came, or sent its last request
    char    name[END_TEXT];
} client_t;

struct bus_tcp
{
    const bus_config_t *config;
    int                 listener;
    client_t            clients[CLIENTS];
    int                 first;       ///< the client that has the drive, or NOBODY
    unsigned long long  refused;     ///< requests of other clients
    time_t              reported_at; ///< time of the last message about them
};

// --- addresses -----------------------------------------------------------------------------------------------------

/// Writes "ADDRESS port PORT" for one end of a socket.
static void name_end(const struct sockaddr_storage *address, socklen_t size, char text[END_TEXT])
{
    char host[NI_MAXHOST] = "?";
    char port[NI_MAXSERV] = "?";
    (void)getnameinfo((const struct sockaddr *)address,
                      size,
                      host,
                      sizeof host,
                      port,
                      sizeof port,
                      NI_NUMERICHOST | NI_NUMERICSERV);
    (void)snprintf(text, END_TEXT, "%.64s port %.8s", host, port);
}

static bool is_loopback(const struct sockaddr_storage *address)
{
    const struct sockaddr_in  *v4 = (const struct sockaddr_in *)address;
    const struct sockaddr_in6 *v6 = (const struct sockaddr_in6 *)address;
    return address->ss_family == AF_INET6 ? IN6_IS_ADDR_LOOPBACK(&v6->sin6_addr)
                                          : ntohl(v4->sin_addr.s_addr) >> 24 == IN_LOOPBACKNET;
}

/// Reports at the start who can reach the drive, because TCP has no password.
static void say_who_reaches(const bus_tcp_t *bus)
{
    struct sockaddr_storage address;
    socklen_t               size = sizeof address;
    char                    where[END_TEXT];
    memset(&address, 0, sizeof address);
    if (getsockname(bus->listener, (struct sockaddr *)&address, &size) != 0)
    {
        return;
    }
    name_end(&address, size, where);
    (void)fprintf(stderr,
                  "bus: Modbus TCP on %s: %s\n",
                  where,
                  is_loopback(&address) ? "only programs on this machine reach the drive"
                                        : "anyone who reaches this address can move the drive, without a password");
}

/// Reports refused requests, at most once a second, because a refused client may try again and again.
static void tell_refusal(bus_tcp_t *bus, const client_t *client)
{
    const time_t now = time(NULL);
    bus->refused++;
    if (now != bus->reported_at)
    {
        (void)fprintf(stderr,
                      "%s: bus.listen: %s is refused: %s has the drive (%llu refused)\n",
                      program_invocation_short_name,
                      client->name,
                      bus->clients[bus->first].name,
                      bus->refused);
        bus->reported_at = now;
    }
}

// --- coming and going ----------------------------------------------------------------------------------------------

static void leave(bus_tcp_t *bus, const bus_service_t *service, int which)
{
    client_t *client = &bus->clients[which];
    (void)close(client->socket);
    client->socket = -1;
    client->length = 0;
    client->late   = 0;
    if (which == bus->first)
    {
        bus->first = NOBODY;
        service->leave(service->registers.context);
    }
}

/// Returns a client that only keeps its place, e.g. with half a request.
static bool is_silent(const bus_tcp_t *bus, const client_t *client)
{
    return common_clock_s() - client->heard_s > (double)bus->config->silent_s;
}

/// Returns a free place, or that of the client, other than the first, that has been silent for longest.
static int find_place(bus_tcp_t *bus, const bus_service_t *service)
{
    int longest = bus->first == 0 ? 1 : 0;
    for (int i = 0; i < CLIENTS; i++)
    {
        if (bus->clients[i].socket < 0)
        {
            return i;
        }
        if (i != bus->first && bus->clients[i].heard_s < bus->clients[longest].heard_s)
        {
            longest = i;
        }
    }
    leave(bus, service, longest);
    return longest;
}

static void set_option(int socket, int level, int option, int value)
{
    (void)setsockopt(socket, level, option, &value, sizeof value);
}

static void accept_client(bus_tcp_t *bus, const bus_service_t *service)
{
    struct sockaddr_storage address;
    socklen_t               size = sizeof address;
    const int socket = accept4(bus->listener, (struct sockaddr *)&address, &size, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (socket < 0)
    {
        return;
    }
    const int place  = find_place(bus, service);
    client_t *client = &bus->clients[place];
    client->socket   = socket;
    client->heard_s  = common_clock_s();
    bus->first       = bus->first == NOBODY ? place : bus->first;
    name_end(&address, size, client->name);
    set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
    set_option(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
    set_option(socket, IPPROTO_TCP, TCP_KEEPIDLE, KEEP_IDLE_S);
    set_option(socket, IPPROTO_TCP, TCP_KEEPINTVL, 1);
    set_option(socket, IPPROTO_TCP, TCP_KEEPCNT, KEEP_TRIALS);
    set_option(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, (KEEP_IDLE_S + KEEP_TRIALS) * MS_PER_S);
}

/// Gives the drive to the client that sends a request, if the first client has gone or has been silent for too long.
static void give_place(bus_tcp_t *bus, const bus_service_t *service, int which)
{
    if (bus->first != NOBODY && bus->first != which && is_silent(bus, &bus->clients[bus->first]))
    {
        (void)fprintf(stderr,
                      "%s: bus.listen: %s is dropped: it has sent no request for %u s, and another client has\n",
                      program_invocation_short_name,
                      bus->clients[bus->first].name,
                      (unsigned)bus->config->silent_s);
        leave(bus, service, bus->first);
    }
    bus->first = bus->first == NOBODY ? which : bus->first;
}

// --- a request -----------------------------------------------------------------------------------------------------

/// Returns the size of the frame at the beginning of the bytes; 0 if its length has not come yet; negative if it is not Modbus.
static ssize_t size_of(const client_t *client)
{
    const uint8_t *bytes = client->bytes;
    if (client->length < HEAD)
    {
        return 0;
    }
    const ssize_t size = LENGTH_AT + 2 + (bytes[LENGTH_AT] << 8 | bytes[LENGTH_AT + 1]);
    return bytes[2] != 0u || bytes[3] != 0u || size <= HEAD || size > FRAME_MAX ? -1 : size;
}

static bool has_request(const client_t *client)
{
    const ssize_t size = size_of(client);
    return client->socket >= 0 && size != 0 && (size < 0 || client->length >= (size_t)size);
}

static void drop(client_t *client, size_t count)
{
    client->length -= count;
    client->late -= client->late < count ? client->late : count;
    memmove(client->bytes, client->bytes + count, client->length);
}

/// Executes a whole request of `size` bytes. A client that has left gets no answer, and of its requests only a stop is executed.
static void answer(bus_tcp_t *bus, const bus_service_t *service, int which, size_t size, bool has_left)
{
    client_t *client = &bus->clients[which];
    uint8_t   bytes[FRAME_MAX];
    give_place(bus, service, which);
    client->heard_s              = common_clock_s();
    const modbus_source_t source = which != bus->first             ? MODBUS_GUEST
                                   : has_left || client->late > 0u ? MODBUS_LATE
                                                                   : MODBUS_MASTER;
    const size_t          pdu =
        modbus_answer(service->modbus, &service->registers, source, client->bytes + HEAD, size - HEAD, bytes + HEAD);
    if (source == MODBUS_GUEST && (bytes[HEAD] & 0x80u) != 0u)
    {
        tell_refusal(bus, client);
    }
    memcpy(bytes, client->bytes, HEAD);
    bytes[LENGTH_AT]      = 0;
    bytes[LENGTH_AT + 1u] = (uint8_t)(pdu + 1u);
    drop(client, size);
    if (send(client->socket, bytes, HEAD + pdu, MSG_DONTWAIT | MSG_NOSIGNAL) != (ssize_t)(HEAD + pdu))
    {
        leave(bus, service, which); // the client does not read its answers
    }
}

/// Receives bytes of a client. Returns false if the client has closed its sending side.
static bool receive(client_t *client)
{
    const size_t room = sizeof client->bytes - client->length;
    if (room == 0u)
    {
        return true; // there is a whole request
    }
    const ssize_t count = recv(client->socket, client->bytes + client->length, room, MSG_DONTWAIT);
    client->length += count > 0 ? (size_t)count : 0u;
    return count > 0 || (count < 0 && (errno == EAGAIN || errno == EINTR));
}

static void serve_client(bus_tcp_t *bus, const bus_service_t *service, int which, bool has_left)
{
    client_t  *client = &bus->clients[which];
    const bool lives  = receive(client);
    if (has_request(client))
    {
        const ssize_t size = size_of(client);
        service->modbus->bad_frames += size < 0;
        if (size < 0)
        {
            leave(bus, service, which);
        }
        else
        {
            answer(bus, service, which, (size_t)size, has_left || !lives);
        }
    }
    else if (!lives)
    {
        leave(bus, service, which);
    }
}

// --- the line ------------------------------------------------------------------------------------------------------

static int listen_at(const struct addrinfo *end)
{
    const int one     = 1;
    const int socket_ = socket(end->ai_family, end->ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK, end->ai_protocol);
    if (socket_ < 0)
    {
        return -1;
    }
    if (setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one) == 0 &&
        bind(socket_, end->ai_addr, end->ai_addrlen) == 0 && listen(socket_, BACKLOG) == 0)
    {
        return socket_;
    }
    const int why = errno;
    (void)close(socket_);
    errno = why;
    return -1;
}

static int open_listener(const bus_config_t *config, common_error_t *error)
{
    char                  service[8];
    struct addrinfo      *ends  = NULL;
    const struct addrinfo wants = {.ai_flags    = AI_PASSIVE,
                                   .ai_family   = AF_UNSPEC,
                                   .ai_socktype = SOCK_STREAM,
                                   .ai_protocol = IPPROTO_TCP};
    (void)snprintf(service, sizeof service, "%u", (unsigned)config->port);
    const int unknown  = getaddrinfo(config->listen, service, &wants, &ends);
    int       listener = -1;
    for (const struct addrinfo *end = ends; unknown == 0 && end != NULL && listener < 0; end = end->ai_next)
    {
        listener = listen_at(end);
    }
    if (listener < 0)
    {
        const char *why = unknown == 0 || unknown == EAI_SYSTEM ? strerror(errno) : gai_strerror(unknown);
        (void)common_error_set(error, "bus.listen: %s: %s", config->listen, why);
    }
    if (ends != NULL)
    {
        freeaddrinfo(ends);
    }
    return listener;
}

bus_tcp_t *bus_tcp_open(const bus_config_t *config, common_error_t *error)
{
    bus_tcp_t *bus = calloc(1, sizeof *bus);
    if (bus == NULL)
    {
        (void)common_error_set(error, "out of memory");
        return NULL;
    }
    bus->config   = config;
    bus->first    = NOBODY;
    bus->listener = open_listener(config, error);
    for (int i = 0; i < CLIENTS; i++)
    {
        bus->clients[i].socket = -1;
    }
    if (bus->listener < 0)
    {
        free(bus);
        return NULL;
    }
    say_who_reaches(bus);
    return bus;
}

void bus_tcp_close(bus_tcp_t *bus)
{
    for (int i = 0; bus != NULL && i < CLIENTS; i++)
    {
        if (bus->clients[i].socket >= 0)
        {
            (void)close(bus->clients[i].socket);
        }
    }
    if (bus != NULL)
    {
        (void)close(bus->listener);
    }
    free(bus);
}

void bus_tcp_was_away(bus_tcp_t *bus)
{
    for (int i = 0; i < CLIENTS; i++)
    {
        client_t *client  = &bus->clients[i];
        int       waiting = 0;
        if (client->socket >= 0 && ioctl(client->socket, FIONREAD, &waiting) == 0)
        {
            client->late = client->length + (size_t)waiting;
        }
    }
}

/// Executes one request of each client. The first client comes first: if it has left, its place is free for the next one.
static void serve_clients(bus_tcp_t *bus, const bus_service_t *service, const struct pollfd *ends)
{
    const int first = bus->first;
    for (int k = first == NOBODY ? 0 : -1; k < CLIENTS; k++)
    {
        const int i     = k < 0 ? first : k;
        const int event = ends[i].revents;
        if ((k >= 0 && i == first) || bus->clients[i].socket != ends[i].fd || ends[i].fd < 0)
        {
            continue;
        }
        if (event != 0 || has_request(&bus->clients[i]))
        {
            serve_client(bus, service, i, (event & (POLLRDHUP | POLLHUP | POLLERR)) != 0);
        }
        else if (i != bus->first && is_silent(bus, &bus->clients[i]))
        {
            leave(bus, service, i);
        }
    }
}

void bus_tcp_serve(bus_tcp_t *bus, const bus_service_t *service, int wait_ms)
{
    struct pollfd ends[CLIENTS + 1];
    bool          waits = true;
    for (int i = 0; i < CLIENTS; i++)
    {
        ends[i] = (struct pollfd){.fd = bus->clients[i].socket, .events = POLLIN | POLLRDHUP};
        waits   = waits && !has_request(&bus->clients[i]);
    }
    ends[CLIENTS] = (struct pollfd){.fd = bus->listener, .events = POLLIN};
    if (poll(ends, CLIENTS + 1, waits ? wait_ms : 0) >= 0)
    {
        serve_clients(bus, service, ends);
        if (ends[CLIENTS].revents != 0)
        {
            accept_client(bus, service);
        }
    }
}
