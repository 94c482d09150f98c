#define _DEFAULT_SOURCE // rates above 38,400 baud; NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp)

#include "target/serial.h"

#include "support/clock.h"
#include "tribo_wire.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#define CRC_WORDS    1u
#define MESSAGE_SIZE (4u * (TRIBO_WIRE_HEADER_WORDS + TRIBO_WIRE_WORDS_MAX + CRC_WORDS))
#define HELLO_S      0.3 // time between two HELLOs
#define DEVICE_MAX   4096

struct sim_serial
{
    int     line;
    uint8_t message[MESSAGE_SIZE];
};

// --- the line ------------------------------------------------------------------------------------------------------

static speed_t speed_of(unsigned long baud)
{
    static const struct
    {
        unsigned long baud;
        speed_t       speed;
    } speeds[] =
        {{9600, B9600}, {57600, B57600}, {115200, B115200}, {230400, B230400}, {460800, B460800}, {921600, B921600}};
    for (size_t i = 0; i < sizeof speeds / sizeof speeds[0]; i++)
    {
        if (speeds[i].baud == baud)
        {
            return speeds[i].speed;
        }
    }
    return B0;
}

/// Parses "DEVICE" or "DEVICE,BAUD".
static bool parse(const char *text, char device[DEVICE_MAX], speed_t *speed, common_error_t *error)
{
    const char  *comma  = strrchr(text, ',');
    const size_t length = comma != NULL ? (size_t)(comma - text) : strlen(text);
    if (length == 0 || length >= DEVICE_MAX)
    {
        return common_error_set(error, "serial:%s names no device", text);
    }
    memcpy(device, text, length);
    device[length] = '\0';

    char *end = NULL;
    *speed    = comma != NULL ? speed_of(strtoul(comma + 1, &end, 10)) : speed_of(SIM_SERIAL_BAUD);
    return (*speed != B0 && (end == NULL || *end == '\0')) ||
           common_error_set(error, "serial:%s: rates are 9600, 57600, 115200, 230400, 460800 and 921600 baud", text);
}

/// Sets the line to 8N1, raw bytes, no flow control.
static bool set_raw(int line, speed_t speed)
{
    struct termios settings;
    if (tcgetattr(line, &settings) != 0)
    {
        return false;
    }
    settings.c_iflag     = 0;
    settings.c_oflag     = 0;
    settings.c_lflag     = 0;
    settings.c_cflag     = CS8 | CREAD | CLOCAL;
    settings.c_cc[VMIN]  = 1;
    settings.c_cc[VTIME] = 0;
    return cfsetispeed(&settings, speed) == 0 && cfsetospeed(&settings, speed) == 0 &&
           tcsetattr(line, TCSANOW, &settings) == 0 && tcflush(line, TCIOFLUSH) == 0;
}

sim_serial_t *sim_serial_open(const char *device, common_error_t *error)
{
    char    path[DEVICE_MAX];
    speed_t speed = B0;
    if (!parse(device, path, &speed, error))
    {
        return NULL;
    }
    sim_serial_t *serial = calloc(1, sizeof *serial);
    if (serial == NULL)
    {
        (void)common_error_set(error, "out of memory");
        return NULL;
    }
    serial->line = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (serial->line < 0 || ioctl(serial->line, TIOCEXCL) != 0 || !set_raw(serial->line, speed))
    {
        (void)common_error_set(error, "%s cannot be used as a serial line: %s", path, strerror(errno));
        sim_serial_close(serial);
        return NULL;
    }
    return serial;
}

void sim_serial_close(sim_serial_t *serial)
{
    if (serial == NULL)
    {
        return;
    }
    if (serial->line >= 0)
    {
        (void)close(serial->line);
    }
    free(serial);
}

/// Waits until the line is ready for `events`. Returns false at `deadline_s` or when the device is gone.
static bool wait_for_line(const sim_serial_t *serial, short events, double deadline_s)
{
    const double  left_s = deadline_s - common_clock_s();
    struct pollfd line   = {.fd = serial->line, .events = events};
    return left_s > 0.0 && poll(&line, 1, (int)(1e3 * left_s) + 1) > 0 && (line.revents & events) != 0;
}

// --- messages ------------------------------------------------------------------------------------------------------

static void put_word(uint8_t *bytes, uint32_t word)
{
    for (unsigned i = 0; i < 4u; i++)
    {
        bytes[i] = (uint8_t)(word >> (8u * i));
    }
}

static uint32_t get_word(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/// Computes the CRC-32 of IEEE 802.3.
static uint32_t crc_of(const uint8_t *bytes, size_t size)
{
    uint32_t crc = UINT32_MAX;
    for (size_t i = 0; i < size; i++)
    {
        crc ^= bytes[i];
        for (unsigned bit = 0; bit < 8u; bit++)
        {
            crc = crc >> 1 ^ (0xedb88320u & (0u - (crc & 1u)));
        }
    }
    return ~crc;
}

bool sim_serial_send(sim_serial_t *serial, uint32_t kind, const uint32_t *words, uint32_t count, common_error_t *error)
{
    const size_t size = 4u * (TRIBO_WIRE_HEADER_WORDS + (size_t)count);
    put_word(serial->message, kind);
    put_word(serial->message + 4, count);
    for (uint32_t i = 0; i < count; i++)
    {
        put_word(serial->message + 4u * (TRIBO_WIRE_HEADER_WORDS + i), words[i]);
    }
    put_word(serial->message + size, crc_of(serial->message, size));

    const double deadline_s = common_clock_s() + SIM_SERIAL_TIMEOUT_S;
    size_t       sent       = 0;
    while (sent < size + 4u)
    {
        const ssize_t some = write(serial->line, serial->message + sent, size + 4u - sent);
        sent += some > 0 ? (size_t)some : 0u;
        if (some <= 0 && !wait_for_line(serial, POLLOUT, deadline_s))
        {
            return common_error_set(error, "the serial line accepts no more bytes");
        }
    }
    return true;
}

/// Reads until `have` is `size`. Returns false at the deadline.
static bool read_until(sim_serial_t *serial, size_t *have, size_t size, double deadline_s)
{
    while (*have < size)
    {
        const ssize_t some = read(serial->line, serial->message + *have, size - *have);
        *have += some > 0 ? (size_t)some : 0u;
        if (*have < size && !wait_for_line(serial, POLLIN, deadline_s))
        {
            return false;
        }
    }
    return true;
}

static void get_words(const sim_serial_t *serial, uint32_t *words, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
    {
        words[i] = get_word(serial->message + 4u * (TRIBO_WIRE_HEADER_WORDS + i));
    }
}

static bool is_header(const sim_serial_t *serial, uint32_t kind, uint32_t count)
{
    return get_word(serial->message) == kind && get_word(serial->message + 4) == count;
}

/// Receives a complete message of any kind into serial->message.
static bool read_message(sim_serial_t *serial, double deadline_s, common_error_t *error)
{
    size_t have = 0;
    size_t size = 4u * TRIBO_WIRE_HEADER_WORDS;
    bool   ok   = read_until(serial, &have, size, deadline_s);
    if (ok)
    {
        const uint32_t count = get_word(serial->message + 4);
        if (count > TRIBO_WIRE_WORDS_MAX)
        {
            return common_error_set(error, "the board sends messages of another kind or version");
        }
        size += 4u * (size_t)count;
        ok = read_until(serial, &have, size + 4u, deadline_s);
    }
    if (!ok)
    {
        return have == 0 ? common_error_set(error, "the board has not answered for %d s", SIM_SERIAL_TIMEOUT_S)
                         : common_error_set(error, "the board has stopped within a message");
    }
    return get_word(serial->message + size) == crc_of(serial->message, size) ||
           common_error_set(error, "a message from the board was damaged on the line: its CRC is wrong");
}

bool sim_serial_receive(sim_serial_t *serial, uint32_t kind, uint32_t *words, uint32_t count, common_error_t *error)
{
    const double deadline_s = common_clock_s() + SIM_SERIAL_TIMEOUT_S;
    do
    {
        if (!read_message(serial, deadline_s, error))
        {
            return false;
        }
    } while (get_word(serial->message) == TRIBO_WIRE_HELLO); // this answers an earlier HELLO
    get_words(serial, words, count);
    return is_header(serial, kind, count) ||
           common_error_set(error, "the board sends messages of another kind or version");
}

/// Finds an answer to HELLO anywhere in the bytes received until `deadline_s`.
static bool find_hello(sim_serial_t *serial, uint32_t count, double deadline_s)
{
    const size_t size = 4u * (TRIBO_WIRE_HEADER_WORDS + (size_t)count);
    size_t       have = 0;
    while (read_until(serial, &have, size + 4u, deadline_s))
    {
        if (is_header(serial, TRIBO_WIRE_HELLO, count) &&
            get_word(serial->message + size) == crc_of(serial->message, size))
        {
            return true;
        }
        memmove(serial->message, serial->message + 1, --have);
    }
    return false;
}

bool sim_serial_hello(sim_serial_t *serial, uint32_t *words, uint32_t count, common_error_t *error)
{
    const double deadline_s = common_clock_s() + SIM_SERIAL_TIMEOUT_S;
    while (common_clock_s() < deadline_s)
    {
        if (!sim_serial_send(serial, TRIBO_WIRE_HELLO, NULL, 0, error))
        {
            return false;
        }
        if (find_hello(serial, count, common_clock_s() + HELLO_S))
        {
            get_words(serial, words, count);
            return true;
        }
    }
    return common_error_set(error, "no board answers; is its lock-step image running, and is this its rate?");
}
