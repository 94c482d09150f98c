#include "link.h"

#include <semihost.h>
#include <string.h>

static int from_host, to_host;

bool link_open(void)
{
    from_host = sys_semihost_open(TRIBO_WIRE_TO_TARGET, SH_OPEN_R_B);
    to_host   = sys_semihost_open(TRIBO_WIRE_FROM_TARGET, SH_OPEN_W_B);
    return from_host >= 0 && to_host >= 0;
}

/// Words as the wire has them. All targets are little-endian, and this file does not compile for another.
typedef char link_needs_little_endian[__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? 1 : -1];

bool link_send(tribo_wire_kind_t kind, const uint32_t *words, uint32_t count)
{
    uint32_t     message[TRIBO_WIRE_HEADER_WORDS + TRIBO_TOCK_WORDS] = {(uint32_t)kind, count};
    const size_t size = sizeof(uint32_t) * (TRIBO_WIRE_HEADER_WORDS + count);
    if (size > sizeof message)
    {
        return false;
    }
    memcpy(message + TRIBO_WIRE_HEADER_WORDS, words, sizeof(uint32_t) * count);
    return sys_semihost_write(to_host, message, size) == 0; // what is left to write
}

/// Appends what has come to `buffer`, at least a byte; false at the end of the link.
static bool read_more(uint8_t *buffer, size_t size, size_t *have)
{
    const size_t    room    = size - *have;
    const uintptr_t missing = sys_semihost_read(from_host, buffer + *have, room);
    if (missing >= room)
    {
        return false;
    }
    *have += room - missing;
    return true;
}

bool link_receive(uint32_t *kind, uint32_t words[TRIBO_WIRE_WORDS_MAX], uint32_t *count)
{
    // The host waits for an answer, so that what one call brings is never more than one message, and mostly all of it.
    static uint32_t message[TRIBO_WIRE_HEADER_WORDS + TRIBO_WIRE_WORDS_MAX];
    size_t          have = 0;
    size_t          need = sizeof(uint32_t) * TRIBO_WIRE_HEADER_WORDS;
    while (have < need)
    {
        if (!read_more((uint8_t *)message, sizeof message, &have))
        {
            return false;
        }
        if (have >= sizeof(uint32_t) * TRIBO_WIRE_HEADER_WORDS)
        {
            if (message[1] > TRIBO_WIRE_WORDS_MAX)
            {
                return false;
            }
            need = sizeof(uint32_t) * (TRIBO_WIRE_HEADER_WORDS + message[1]);
        }
    }
    *kind  = message[0];
    *count = message[1];
    memcpy(words, message + TRIBO_WIRE_HEADER_WORDS, sizeof(uint32_t) * message[1]);
    return true;
}
