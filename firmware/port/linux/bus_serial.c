#include "bus_lines.h"

#include "rtu.h"
#include "serial.h"

#include "support/clock.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define REOPEN_S 1.0
#define SILENT_S 0.05 ///< longer than any pause that a pty or a USB adapter makes within a frame

struct bus_serial
{
    const bus_config_t *config;
    int                 file;    ///< negative: the line has gone ...
    double              gone_s;  ///< ... at this time, or this is the last attempt to open it
    double              heard_s; ///< time of the last bytes
    rtu_t               rtu;
};

static bool reopen(bus_serial_t *bus)
{
    bus->file = serial_open(bus->config->device, (uint32_t)bus->config->baud, bus->config->rs485 != 0);
    bus->rtu  = (rtu_t){0};
    return bus->file >= 0;
}

bus_serial_t *bus_serial_open(const bus_config_t *config, common_error_t *error)
{
    bus_serial_t *bus = calloc(1, sizeof *bus);
    if (bus == NULL)
    {
        (void)common_error_set(error, "out of memory");
        return NULL;
    }
    bus->config = config;
    if (!reopen(bus))
    {
        (void)common_error_set(error, "bus.device: %s: %s", config->device, strerror(errno));
        free(bus);
        return NULL;
    }
    return bus;
}

void bus_serial_close(bus_serial_t *bus)
{
    if (bus != NULL && bus->file >= 0)
    {
        serial_close(bus->file);
    }
    free(bus);
}

void bus_serial_was_away(bus_serial_t *bus)
{
    int waiting = 0;
    if (bus->file >= 0 && ioctl(bus->file, FIONREAD, &waiting) == 0)
    {
        bus->rtu.late = bus->rtu.length + (size_t)waiting;
    }
}

/// Closes a line that has failed. It may come back.
static void lose(bus_serial_t *bus, const bus_service_t *service, int why)
{
    (void)fprintf(stderr,
                  "%s: bus.device: %s: %s\n",
                  program_invocation_short_name,
                  bus->config->device,
                  why != 0 ? strerror(why) : "the line has gone");
    serial_close(bus->file);
    bus->file   = -1;
    bus->gone_s = common_clock_s();
    service->leave(service->registers.context);
}

static void answer(const bus_serial_t *bus, const bus_service_t *service, const rtu_frame_t *frame)
{
    uint8_t               bytes[MODBUS_FRAME_MAX];
    const modbus_source_t source = frame->is_late || !frame->is_awaited ? MODBUS_LATE : MODBUS_MASTER;
    const size_t          length =
        modbus_execute(service->modbus, &service->registers, source, frame->bytes, frame->length, bytes);
    if (frame->is_awaited)
    {
        (void)!write(bus->file, bytes, length); // if there is no room, no one reads the line
    }
}

static void take_frames(bus_serial_t *bus, const bus_service_t *service, bool is_silent)
{
    rtu_frame_t    frame;
    const uint32_t torn = bus->rtu.torn;
    while (rtu_take(&bus->rtu, is_silent, &frame))
    {
        answer(bus, service, &frame);
    }
    service->modbus->bad_frames += bus->rtu.torn - torn;
}

static void read_line(bus_serial_t *bus, const bus_service_t *service)
{
    size_t         room;
    uint8_t *const bytes = rtu_room(&bus->rtu, &room);
    const ssize_t  count = read(bus->file, bytes, room);
    if (count > 0)
    {
        bus->rtu.length += (size_t)count;
        bus->heard_s = common_clock_s();
        take_frames(bus, service, false);
    }
    else if (count == 0 || (errno != EAGAIN && errno != EINTR))
    {
        lose(bus, service, count < 0 ? errno : 0);
    }
}

void bus_serial_serve(bus_serial_t *bus, const bus_service_t *service, int wait_ms)
{
    const double now_s = common_clock_s();
    if (bus->file < 0 && now_s - bus->gone_s >= REOPEN_S && !reopen(bus))
    {
        bus->gone_s = now_s;
    }
    struct pollfd line = {.fd = bus->file, .events = POLLIN};
    if (poll(&line, 1, wait_ms) > 0)
    {
        read_line(bus, service);
    }
    else if (bus->rtu.length > 0u && now_s - bus->heard_s > SILENT_S)
    {
        take_frames(bus, service, true);
    }
}
