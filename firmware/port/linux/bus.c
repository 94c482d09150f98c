#include "bus.h"

#include "support/clock.h"

#include <errno.h>
#include <modbus.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define ADDRESSES       0x10000
#define REOPEN_MS       1000
#define MS_PER_S        1000
#define NS_PER_MS       1000000
#define US_PER_MS       1000
#define TCP_HEAD        6     ///< bytes, up to the length of what follows
#define TCP_REQUEST_MIN 8     ///< with unit and function
#define BYTE_GAP_US     50000 ///< within a frame: more than a pty or a USB adapter makes

#define END_TEXT    96
#define KEEP_IDLE_S 2   ///< then the kernel asks a silent client's once a second ...
#define KEEP_TRIALS 3   ///< ... so often
#define SEND_MS     100 ///< for a client that does not read its answers

struct bus
{
    const bus_config_t *config;
    modbus_t           *modbus;
    modbus_mapping_t   *mapping; ///< what modbus_reply answers from
    int                 listener;
    bool                gone; ///< the line
    char                client[END_TEXT];
    double              heard_s;    ///< when the client came, or last asked for something
    unsigned long long  refused;    ///< clients, beside another
    time_t              refused_at; ///< and told
};

bool bus_is_used(const bus_config_t *config)
{
    return config->device[0] != '\0' || config->listen[0] != '\0';
}

static bool is_serial(const bus_t *bus)
{
    return bus->listener < 0;
}

/// A client that leaves is none; a serial line that goes away may come back.
static void lose(bus_t *bus)
{
    if (is_serial(bus) && !bus->gone)
    {
        (void)fprintf(stderr,
                      "%s: bus.device: %s: %s\n",
                      program_invocation_short_name,
                      bus->config->device,
                      modbus_strerror(errno));
    }
    bus->gone = is_serial(bus);
    modbus_close(bus->modbus);
}

// --- a request -----------------------------------------------------------------------------------------------------

static uint16_t get(const uint8_t *bytes)
{
    return (uint16_t)(bytes[0] << 8 | bytes[1]);
}

/// What a request asks for. A count of 0: nothing of that kind.
typedef struct
{
    unsigned read_address, read_count;
    unsigned write_address, write_count;
    uint8_t *values; ///< to be written
} request_t;

static bool fits(unsigned address, unsigned count)
{
    return address + count <= ADDRESSES;
}

/// `data` are the `size` bytes from the function's code on, without a CRC. 0 or an exception.
static unsigned parse(request_t *request, uint8_t *data, size_t size)
{
    size_t   head      = 0; // up to the values
    unsigned write_max = 0;
    *request           = (request_t){0};
    switch (data[0])
    {
    case MODBUS_FC_READ_HOLDING_REGISTERS:
        head = 5;
        break;
    case MODBUS_FC_WRITE_SINGLE_REGISTER:
        head      = 3;
        write_max = 1;
        break;
    case MODBUS_FC_WRITE_MULTIPLE_REGISTERS:
        head      = 6;
        write_max = MODBUS_MAX_WRITE_REGISTERS;
        break;
    case MODBUS_FC_WRITE_AND_READ_REGISTERS:
        head      = 10;
        write_max = MODBUS_MAX_WR_WRITE_REGISTERS;
        break;
    default:
        return MODBUS_EXCEPTION_ILLEGAL_FUNCTION;
    }
    const bool reads = data[0] == MODBUS_FC_READ_HOLDING_REGISTERS || data[0] == MODBUS_FC_WRITE_AND_READ_REGISTERS;
    if (size < head)
    {
        return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
    }
    if (reads)
    {
        request->read_address = get(data + 1);
        request->read_count   = get(data + 3);
    }
    if (write_max > 0u)
    {
        uint8_t *part          = data + (reads ? 5 : 1);
        request->write_address = get(part);
        request->write_count   = write_max == 1u ? 1u : get(part + 2);
        request->values        = data + head;
    }
    const bool counted = write_max > 1u; // has a byte count
    const bool good    = (!reads || (request->read_count >= 1u && request->read_count <= MODBUS_MAX_READ_REGISTERS)) &&
                      (write_max == 0u || (request->write_count >= 1u && request->write_count <= write_max)) &&
                      size == head + 2u * request->write_count &&
                      (!counted || data[head - 1u] == 2u * request->write_count);
    if (!good)
    {
        return MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE;
    }
    return fits(request->read_address, request->read_count) && fits(request->write_address, request->write_count)
               ? 0u
               : MODBUS_EXCEPTION_ILLEGAL_DATA_ADDRESS;
}

static unsigned read_values(bus_t *bus, const bus_registers_t *registers, const request_t *request)
{
    return registers->read(registers->context,
                           (uint16_t)request->read_address,
                           (uint16_t)request->read_count,
                           bus->mapping->tab_registers + request->read_address);
}

static unsigned write_values(const bus_registers_t *registers, const request_t *request)
{
    uint16_t values[MODBUS_MAX_WRITE_REGISTERS];
    for (unsigned i = 0; i < request->write_count; i++)
    {
        values[i] = get(request->values + 2u * (size_t)i);
    }
    return registers->write(registers->context,
                            (uint16_t)request->write_address,
                            (uint16_t)request->write_count,
                            values);
}

/// modbus_reply writes to the mapping before it reads from it. What it would change of what was read is read here instead.
static void keep_what_was_read(const bus_t *bus, const request_t *request)
{
    for (unsigned i = 0; i < request->write_count; i++)
    {
        const unsigned address = request->write_address + i;
        if (address - request->read_address < request->read_count)
        {
            request->values[2u * i]      = (uint8_t)(bus->mapping->tab_registers[address] >> 8);
            request->values[2u * i + 1u] = (uint8_t)bus->mapping->tab_registers[address];
        }
    }
}

/// With both, the write comes first; but before it a trial of the read, so that nothing is written if there are no such
/// registers.
static unsigned perform(bus_t *bus, const bus_registers_t *registers, const request_t *request)
{
    unsigned status = request->read_count > 0u ? read_values(bus, registers, request) : 0u;
    if (status != MODBUS_EXCEPTION_ILLEGAL_DATA_ADDRESS && request->write_count > 0u)
    {
        status = write_values(registers, request);
        if (status == 0u && request->read_count > 0u)
        {
            status = read_values(bus, registers, request);
            keep_what_was_read(bus, request);
        }
    }
    return status;
}

static bus_event_t answer(bus_t *bus, const bus_registers_t *registers, uint8_t *frame, size_t size)
{
    const size_t head = (size_t)modbus_get_header_length(bus->modbus);
    const size_t crc  = is_serial(bus) ? 2u : 0u;
    const bool   all  = is_serial(bus) && frame[head - 1u] == MODBUS_BROADCAST_ADDRESS;
    request_t    request;
    unsigned     status = parse(&request, frame + head, size - head - crc);
    if (all && request.read_count > 0u)
    {
        return BUS_NOTHING; // nobody may answer
    }
    status         = status == 0u ? perform(bus, registers, &request) : status;
    bus->heard_s   = common_clock_s();
    const int sent = all            ? 0
                     : status == 0u ? modbus_reply(bus->modbus, frame, (int)size, bus->mapping)
                                    : modbus_reply_exception(bus->modbus, frame, status);
    if (sent < 0 && !is_serial(bus))
    {
        lose(bus);
    }
    return status == 0u ? BUS_EXECUTED : BUS_REFUSED;
}

// --- clients over TCP ----------------------------------------------------------------------------------------------

/// "ADDRESS port PORT" of one end of a socket.
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

/// Whoever leaves says so, and a host that is gone does not answer the kernel for KEEP_IDLE_S + KEEP_TRIALS s.
static bool client_lives(const bus_t *bus)
{
    char      byte;
    const int client = modbus_get_socket(bus->modbus);
    if (client < 0)
    {
        return false;
    }
    const ssize_t count = recv(client, &byte, 1, MSG_PEEK | MSG_DONTWAIT);
    return count > 0 || (count < 0 && (errno == EAGAIN || errno == EINTR));
}

/// One that only keeps its place, e.g. with half a request.
static bool client_is_silent(const bus_t *bus)
{
    return common_clock_s() - bus->heard_s > (double)bus->config->silent_s;
}

static void set_option(int socket, int level, int option, int value)
{
    (void)setsockopt(socket, level, option, &value, sizeof value);
}

static void accept_client(bus_t *bus)
{
    struct sockaddr_storage address;
    socklen_t               size = sizeof address;
    modbus_close(bus->modbus);
    const int client = modbus_tcp_pi_accept(bus->modbus, &bus->listener);
    if (client < 0 || getpeername(client, (struct sockaddr *)&address, &size) != 0)
    {
        return;
    }
    name_end(&address, size, bus->client);
    bus->heard_s               = common_clock_s();
    const struct timeval limit = {.tv_usec = (suseconds_t)SEND_MS * US_PER_MS};
    (void)setsockopt(client, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
    set_option(client, SOL_SOCKET, SO_KEEPALIVE, 1);
    set_option(client, IPPROTO_TCP, TCP_KEEPIDLE, KEEP_IDLE_S);
    set_option(client, IPPROTO_TCP, TCP_KEEPINTVL, 1);
    set_option(client, IPPROTO_TCP, TCP_KEEPCNT, KEEP_TRIALS);
    set_option(client, IPPROTO_TCP, TCP_USER_TIMEOUT, (KEEP_IDLE_S + KEEP_TRIALS) * MS_PER_S);
}

/// A message a second at most: the one that is refused may try again and again.
static void refuse_client(bus_t *bus)
{
    struct sockaddr_storage address;
    socklen_t               size   = sizeof address;
    const int               second = accept4(bus->listener, (struct sockaddr *)&address, &size, SOCK_CLOEXEC);
    if (second < 0)
    {
        return;
    }
    (void)close(second);
    bus->refused++;
    const time_t now = time(NULL);
    if (now != bus->refused_at)
    {
        char who[END_TEXT];
        name_end(&address, size, who);
        (void)fprintf(stderr,
                      "%s: bus.listen: %s is refused: %s has the drive (%llu refused)\n",
                      program_invocation_short_name,
                      who,
                      bus->client,
                      bus->refused);
        bus->refused_at = now;
    }
}

static void take_client(bus_t *bus)
{
    const bool lives = client_lives(bus);
    if (lives && !client_is_silent(bus))
    {
        refuse_client(bus);
        return;
    }
    if (lives)
    {
        (void)fprintf(stderr,
                      "%s: bus.listen: %s is dropped: it has asked for nothing in %u s, and another comes\n",
                      program_invocation_short_name,
                      bus->client,
                      (unsigned)bus->config->silent_s);
    }
    accept_client(bus);
}

static bool is_loopback(const struct sockaddr_storage *address)
{
    const struct sockaddr_in  *v4 = (const struct sockaddr_in *)address;
    const struct sockaddr_in6 *v6 = (const struct sockaddr_in6 *)address;
    return address->ss_family == AF_INET6 ? IN6_IS_ADDR_LOOPBACK(&v6->sin6_addr)
                                          : ntohl(v4->sin_addr.s_addr) >> 24 == IN_LOOPBACKNET;
}

/// For the start: TCP has no password.
static void say_who_reaches(const bus_t *bus)
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
                  is_loopback(&address) ? "programs of this machine alone reach the drive"
                                        : "whoever reaches this address moves the drive, without a password");
}

// --- the line ------------------------------------------------------------------------------------------------------

static bool fail(const bus_t *bus, const char *why, common_error_t *error)
{
    const bool serial = bus->config->device[0] != '\0';
    return common_error_set(error,
                            "bus.%s: %s: %s",
                            serial ? "device" : "listen",
                            serial ? bus->config->device : bus->config->listen,
                            why);
}

static bool connect_serial(const bus_t *bus)
{
    return modbus_connect(bus->modbus) == 0 &&
           (bus->config->rs485 == 0 || modbus_rtu_set_serial_mode(bus->modbus, MODBUS_RTU_RS485) == 0);
}

static bool open_serial(bus_t *bus, common_error_t *error)
{
    bus->modbus = modbus_new_rtu(bus->config->device, (int)bus->config->baud, 'N', 8, 1);
    return (bus->modbus != NULL && connect_serial(bus)) || fail(bus, modbus_strerror(errno), error);
}

static bool open_listener(bus_t *bus, common_error_t *error)
{
    char service[8];
    (void)snprintf(service, sizeof service, "%u", (unsigned)bus->config->port);
    bus->modbus   = modbus_new_tcp_pi(bus->config->listen, service);
    errno         = EADDRNOTAVAIL; // if the name is unknown
    bus->listener = bus->modbus != NULL ? modbus_tcp_pi_listen(bus->modbus, 1) : -1;
    if (bus->listener < 0)
    {
        return fail(bus, modbus_strerror(errno), error);
    }
    say_who_reaches(bus);
    return true;
}

bus_t *bus_open(const bus_config_t *config, common_error_t *error)
{
    bus_t *bus = calloc(1, sizeof *bus);
    if (bus == NULL)
    {
        (void)common_error_set(error, "out of memory");
        return NULL;
    }
    *bus          = (bus_t){.config = config, .listener = -1};
    bus->mapping  = modbus_mapping_new_start_address(0, 0, 0, 0, 0, ADDRESSES, 0, 0);
    const bool ok = (bus->mapping != NULL || common_error_set(error, "out of memory")) &&
                    (config->device[0] != '\0' ? open_serial(bus, error) : open_listener(bus, error));
    if (!ok)
    {
        bus_close(bus);
        return NULL;
    }
    (void)modbus_set_byte_timeout(bus->modbus, 0, BYTE_GAP_US);
    return bus;
}

void bus_close(bus_t *bus)
{
    if (bus == NULL)
    {
        return;
    }
    if (bus->modbus != NULL)
    {
        modbus_close(bus->modbus);
        modbus_free(bus->modbus);
    }
    if (bus->listener >= 0)
    {
        (void)close(bus->listener);
    }
    modbus_mapping_free(bus->mapping);
    free(bus);
}

static void pause_ms(int ms)
{
    const struct timespec pause = {.tv_sec = ms / MS_PER_S, .tv_nsec = (long)(ms % MS_PER_S) * NS_PER_MS};
    (void)nanosleep(&pause, NULL);
}

static bool come_back(bus_t *bus, int wait_ms)
{
    static int waited_ms; // there is one bus
    pause_ms(wait_ms);
    waited_ms += wait_ms;
    if (waited_ms < REOPEN_MS)
    {
        return false;
    }
    waited_ms = 0;
    bus->gone = !connect_serial(bus);
    return !bus->gone;
}

/// A whole request: its bytes, 0 as long as it has not come. Negative: the client has left, or sends no Modbus.
static ssize_t take_request(const bus_t *bus, uint8_t frame[MODBUS_TCP_MAX_ADU_LENGTH])
{
    const int     client = modbus_get_socket(bus->modbus);
    const ssize_t count  = recv(client, frame, MODBUS_TCP_MAX_ADU_LENGTH, MSG_PEEK | MSG_DONTWAIT);
    if (count <= 0)
    {
        return count < 0 && (errno == EAGAIN || errno == EINTR) ? 0 : -1;
    }
    if (count < TCP_HEAD)
    {
        return 0;
    }
    const ssize_t size = TCP_HEAD + get(frame + 4);
    if (get(frame + 2) != 0u || size < TCP_REQUEST_MIN || size > MODBUS_TCP_MAX_ADU_LENGTH)
    {
        return -1;
    }
    return count < size ? 0 : recv(client, frame, (size_t)size, MSG_DONTWAIT);
}

/// Of a client. libmodbus would wait for each further byte of a request, and with it all that this thread does.
static bus_event_t serve_client(bus_t *bus, const bus_registers_t *registers, int wait_ms)
{
    uint8_t       frame[MODBUS_TCP_MAX_ADU_LENGTH];
    const ssize_t bytes = take_request(bus, frame);
    if (bytes > 0)
    {
        return answer(bus, registers, frame, (size_t)bytes);
    }
    if (bytes == 0)
    {
        pause_ms(wait_ms); // poll does not wait for the rest
        return BUS_NOTHING;
    }
    const bool has_left = !client_lives(bus);
    lose(bus);
    return has_left ? BUS_NOTHING : BUS_BAD_FRAME;
}

static bus_event_t serve_line(bus_t *bus, unsigned unit, const bus_registers_t *registers)
{
    uint8_t frame[MODBUS_MAX_ADU_LENGTH];
    (void)modbus_set_slave(bus->modbus, (int)unit);
    errno           = 0;
    const int bytes = modbus_receive(bus->modbus, frame);
    if (bytes > 0)
    {
        return answer(bus, registers, frame, (size_t)bytes);
    }
    if (bytes == 0)
    {
        return BUS_NOTHING;
    }
    if (errno == ETIMEDOUT || errno >= MODBUS_ENOBASE)
    {
        (void)modbus_flush(bus->modbus);
        return BUS_BAD_FRAME;
    }
    lose(bus);
    return BUS_NOTHING;
}

bus_event_t bus_serve(bus_t *bus, unsigned unit, const bus_registers_t *registers, int wait_ms)
{
    if (bus->gone && !come_back(bus, wait_ms))
    {
        return BUS_NOTHING;
    }
    struct pollfd ends[] = {{.fd = modbus_get_socket(bus->modbus), .events = POLLIN},
                            {.fd = bus->listener, .events = POLLIN}};
    if (poll(ends, sizeof ends / sizeof ends[0], wait_ms) <= 0)
    {
        return BUS_NOTHING;
    }
    // The client of before first: what it has sent is answered, and if it has left, its place is free for the next one.
    const bus_event_t event = ends[0].revents == 0 ? BUS_NOTHING
                              : is_serial(bus)     ? serve_line(bus, unit, registers)
                                                   : serve_client(bus, registers, wait_ms);
    if (ends[1].revents != 0)
    {
        take_client(bus);
    }
    return event;
}
