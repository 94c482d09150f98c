// The drive of the emulated port, from the bytes of its link to the tick: any bytes end it or move it, and a command that it
// gives is finite and within its limits.

#include "fuzz.h"

// lock_step opens the link and tests the memory of a microcontroller; the rest is what is tried here.
#include "port/emulated/lock_step.c"

#include <math.h>
#include <semihost.h>

static const uint8_t *input;
static size_t         left;

unsigned fuzz_good;

int sys_semihost_open(const char *path, int mode)
{
    (void)path;
    return mode;
}

/// What is left of the message that begins at `input`: a call brings no more, as the host waits for an answer.
static size_t message_left;

static size_t message_size(void)
{
    uint32_t header[TRIBO_WIRE_HEADER_WORDS];
    if (left < sizeof header)
    {
        return left;
    }
    memcpy(header, input, sizeof header);
    return sizeof header + (header[1] <= TRIBO_WIRE_WORDS_MAX ? sizeof(uint32_t) * header[1] : 0);
}

/// Two hundred bytes at a time at most, as a pipe may cut them.
uintptr_t sys_semihost_read(int file, void *buffer, size_t size)
{
    (void)file;
    message_left = (message_left > 0) ? message_left : message_size();
    size_t count = (size < left) ? size : left;
    count        = (count < message_left) ? count : message_left;
    count        = (count < 200u) ? count : 200u;
    memcpy(buffer, input, count);
    input += count;
    left -= count;
    message_left -= count;
    return size - count;
}

uintptr_t sys_semihost_write(int file, const void *buffer, size_t size)
{
    uint32_t words[TRIBO_WIRE_HEADER_WORDS + 1u] = {0};
    (void)file;
    memcpy(words, buffer, size < sizeof words ? size : sizeof words);
    if (words[0] == TRIBO_WIRE_TOCK)
    {
        fuzz_good += board.enabled ? 1u : 0u;
#ifndef TRIBO_ARITHMETIC_Q31
        ALWAYS(isfinite(board.command));
#endif
        ALWAYS(board.enabled || tribo_force_word(board.command) == 0u);
    }
    return 0;
}

int sys_semihost_putc(char byte, void *file)
{
    (void)byte;
    (void)file;
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input        = data;
    left         = size;
    message_left = 0;
    board        = (board_t){.enabled = false};
    ALWAYS(link_open());
    const int status = serve(0);
    ALWAYS(status == 0 || (status >= 3 && status <= 5));
    return 0;
}
