/// What the drive checks at power-up, before anything moves. Each part returns what it found, DRIVE_FAULT_NONE if nothing.

#ifndef DRIVE_SELFTEST_H
#define DRIVE_SELFTEST_H

#include "app/drive.h"

#include <stddef.h>
#include <stdint.h>

#define SELFTEST_REGIONS 4u
#define SELFTEST_MAGIC   0x4c414553u // "SEAL"

/// Filled in after linking, by tools/seal_image.py: the loaded parts of the image, all but this struct, and the CRC-32 over
/// them in this order. An image that was not sealed fails.
typedef struct
{
    uint32_t magic;
    uint32_t crc;
    struct
    {
        uint32_t address, size; ///< bytes; size 0: not used
    } regions[SELFTEST_REGIONS];
} selftest_seal_t;

/// The image's own.
extern const volatile selftest_seal_t selftest_seal;

/// `memory` is where address 0 of the seal is: null on a microcontroller.
drive_fault_t selftest_image(const volatile selftest_seal_t *seal, const uint8_t *memory);

/// Reads and writes a word of RAM; the real ones are selftest_ram_read and selftest_ram_write.
typedef struct
{
    uint32_t (*read)(const volatile uint32_t *word);
    void (*write)(volatile uint32_t *word, uint32_t value);
} selftest_ram_t;

extern const selftest_ram_t selftest_ram_real;

/// Word by word patterns that find stuck and shorted bits, and before that the address lines; what was there is
/// put back. For `count` words outside the stack in use, with interrupts off.
drive_fault_t selftest_ram(const selftest_ram_t *ram, volatile uint32_t *words, size_t count);

/// 200 ticks each of the loop with two sections and a plain law of breakaway, which have a way of their own, with three and a
/// table, and with two and a steep law: every bit of what they see, as a CRC-32. The expected ones are the host's
/// (tests/firmware/test_selftest.c), where the library is held against double precision; they change when what the library
/// computes does.
#ifdef DRIVE_ARITH_Q31
#define SELFTEST_GOLDEN_CRC 0x4ea4265bu
#else
#define SELFTEST_GOLDEN_CRC 0x8984c871u
#endif

drive_fault_t selftest_golden(void);

/// The CRC itself.
uint32_t selftest_golden_crc(void);

#endif
