#include "serial.h"

#include <asm/termbits.h> // supports any rate; termios.h has only a list of rates, and cannot be included as well
#include <errno.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#define RATE_PART 20u ///< a UART's divider may change the rate by one part in so many

static bool has_rate(int file, uint32_t baud)
{
    struct termios2 is;
    if (ioctl(file, TCGETS2, &is) != 0)
    {
        return false;
    }
    const uint32_t off = is.c_ospeed > baud ? is.c_ospeed - baud : baud - is.c_ospeed;
    errno              = EINVAL;
    return off <= baud / RATE_PART;
}

static bool set_up(int file, uint32_t baud, bool rs485)
{
    struct termios2 raw;
    memset(&raw, 0, sizeof raw);
    raw.c_cflag    = CS8 | CREAD | CLOCAL | BOTHER;
    raw.c_ispeed   = baud;
    raw.c_ospeed   = baud;
    raw.c_cc[VMIN] = 1;
    struct serial_rs485 transceiver;
    memset(&transceiver, 0, sizeof transceiver);
    transceiver.flags = SER_RS485_ENABLED;
    return ioctl(file, TCSETS2, &raw) == 0 && has_rate(file, baud) && ioctl(file, TCFLSH, TCIOFLUSH) == 0 &&
           (!rs485 || ioctl(file, TIOCSRS485, &transceiver) == 0);
}

int serial_open(const char *path, uint32_t baud, bool rs485)
{
    const int file = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (file >= 0 && !set_up(file, baud, rs485))
    {
        const int why = errno;
        (void)close(file);
        errno = why;
        return -1;
    }
    return file;
}

void serial_close(int file)
{
    (void)ioctl(file, TCFLSH, TCIOFLUSH);
    (void)close(file);
}
