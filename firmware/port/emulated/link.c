#include "link.h"

#include <semihost.h>
#include <string.h>

extern uint32_t __data_start[];

static int from_host, to_host;

bool link_open(void)
{
    from_host = sys_semihost_open(TRIBO_WIRE_TO_TARGET, SH_OPEN_R_B);
    to_host   = sys_semihost_open(TRIBO_WIRE_FROM_TARGET, SH_OPEN_W_B);
    return from_host >= 0 && to_host >= 0;
}

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "words are sent as they are in memory");

bool link_send(tribo_wire_kind_t kind, const uint32_t *words, uint32_t count)
{
    uint32_t     message[TRIBO_WIRE_HEADER_WORDS + TRIBO_TOCK_WORDS] = {(uint32_t)kind, count};
    const size_t size = sizeof(uint32_t) * (TRIBO_WIRE_HEADER_WORDS + count);
    if (size > sizeof message)
    {
        return false;
    }
    memcpy(message + TRIBO_WIRE_HEADER_WORDS, words, sizeof(uint32_t) * count);
    return sys_semihost_write(to_host, message, size) == 0; // the result is the number of bytes not written
}

/// Waits for at least one byte and appends it to `buffer`. Returns false at the end of the link.
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
    // The host waits for each answer, so a read returns at most one message, usually all of it.
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

void link_close(const link_cycles_t *cycles)
{
    (void)cycles; // an emulator has no cycles
}

void link_log(uint8_t byte)
{
    (void)sys_semihost_putc((char)byte, NULL);
}

uint32_t link_cycles(void)
{
    return 0;
}

uint32_t *link_ram(void)
{
    return __data_start;
}
