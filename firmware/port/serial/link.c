// Messages of wire/tribo_wire.h over a serial line, each with its CRC. A lost or wrong byte invalidates its message, and the
// host then ends the run. A HELLO from the host begins a new session at any time.

#include "port/emulated/link.h"

#include "app/crc32.h"
#include "serial.h"

#include <string.h>

#define KIND_MASK 0xffff0000u // every kind begins with "TR"
#define KIND_MARK 0x54520000u

static bool hello_came; ///< a HELLO came within a session and ended it

static uint32_t read_word(void)
{
    uint32_t word = 0;
    for (unsigned i = 0; i < 4u; i++)
    {
        word |= (uint32_t)serial_read() << (8u * i);
    }
    return word;
}

/// Skips bytes until a word can be a kind.
static uint32_t read_kind(void)
{
    uint32_t word = read_word();
    while ((word & KIND_MASK) != KIND_MARK)
    {
        word = word >> 8 | (uint32_t)serial_read() << 24;
    }
    return word;
}

/// Receives the next complete message.
static void receive(uint32_t *kind, uint32_t words[TRIBO_WIRE_WORDS_MAX], uint32_t *count)
{
    static uint32_t message[TRIBO_WIRE_HEADER_WORDS + TRIBO_WIRE_WORDS_MAX];
    for (;;)
    {
        message[0] = read_kind();
        message[1] = read_word();
        if (message[1] > TRIBO_WIRE_WORDS_MAX)
        {
            continue;
        }
        for (uint32_t i = 0; i < message[1]; i++)
        {
            message[TRIBO_WIRE_HEADER_WORDS + i] = read_word();
        }
        const size_t size = sizeof(uint32_t) * (TRIBO_WIRE_HEADER_WORDS + message[1]);
        if (read_word() == crc32_update(0, message, size))
        {
            *kind  = message[0];
            *count = message[1];
            memcpy(words, message + TRIBO_WIRE_HEADER_WORDS, sizeof(uint32_t) * message[1]);
            return;
        }
    }
}

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "words are sent as they are in memory");

bool link_open(void)
{
    static uint32_t words[TRIBO_WIRE_WORDS_MAX];
    uint32_t        kind  = 0;
    uint32_t        count = 0;
    while (!hello_came && kind != TRIBO_WIRE_HELLO)
    {
        receive(&kind, words, &count);
    }
    hello_came = false;
    return true;
}

static void write_bytes(const void *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++)
    {
        // NOLINTNEXTLINE(clang-analyzer-core.CallAndMessage): all bytes of the message's words are set
        serial_write(((const uint8_t *)bytes)[i]);
    }
}

bool link_send(tribo_wire_kind_t kind, const uint32_t *words, uint32_t count)
{
    const uint32_t header[TRIBO_WIRE_HEADER_WORDS] = {(uint32_t)kind, count};
    const size_t   size                            = sizeof(uint32_t) * count;
    const uint32_t crc                             = crc32_update(crc32_update(0, header, sizeof header), words, size);
    write_bytes(header, sizeof header);
    write_bytes(words, size);
    write_bytes(&crc, sizeof crc);
    return true;
}

bool link_receive(uint32_t *kind, uint32_t words[TRIBO_WIRE_WORDS_MAX], uint32_t *count)
{
    receive(kind, words, count);
    hello_came = *kind == TRIBO_WIRE_HELLO;
    return !hello_came;
}

void link_close(const link_cycles_t *cycles)
{
    const uint32_t mean = cycles->ticks > 0u ? (uint32_t)(cycles->sum / cycles->ticks) : 0u;
    const uint32_t words[TRIBO_CYCLES_WORDS] =
        {[TRIBO_CYCLES_LEAST] = cycles->least, [TRIBO_CYCLES_MEAN] = mean, [TRIBO_CYCLES_MOST] = cycles->most};
    (void)link_send(TRIBO_WIRE_END, words, TRIBO_CYCLES_WORDS);
}

void link_log(uint8_t byte)
{
    (void)byte; // the link uses the line; its answer carries a fault's number
}

uint32_t link_cycles(void)
{
    return serial_cycles();
}

uint32_t *link_ram(void)
{
    return serial_ram();
}
