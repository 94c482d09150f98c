// What a fuzz target has: libFuzzer's entry, and a word on whether the corpus still gets anywhere (replay.c).

#ifndef TESTS_FUZZ_H
#define TESTS_FUZZ_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/// Aborts if what must never happen has happened.
#define ALWAYS(condition) ((condition) ? (void)0 : abort())

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/// How many inputs so far were good ones, which each target counts. A corpus that has none has gone stale.
extern unsigned fuzz_good;

/// The bytes as text, up to a zero byte; to be freed.
static inline char *fuzz_text(const uint8_t *data, size_t size)
{
    char *text = malloc(size + 1);
    ALWAYS(text != NULL);
    for (size_t i = 0; i < size; i++)
    {
        text[i] = (char)data[i];
    }
    text[size] = '\0';
    return text;
}

/// A failure has one line of words without control characters, a success has none.
static inline void fuzz_check_error(bool ok, const common_error_t *error)
{
    ALWAYS(ok == (error->text[0] == '\0'));
    for (const unsigned char *p = (const unsigned char *)error->text; *p != '\0'; p++)
    {
        ALWAYS(*p >= 0x20u && *p != 0x7fu);
    }
}

#endif
