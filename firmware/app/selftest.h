/// Tests the drive at power-up, before anything moves. Each part returns the fault found, or DRIVE_FAULT_NONE.

#ifndef DRIVE_SELFTEST_H
#define DRIVE_SELFTEST_H

#include "app/drive.h"

#include <stddef.h>
#include <stdint.h>

#define SELFTEST_REGIONS 4u
#define SELFTEST_MAGIC   0x4c414553u // "SEAL"

/// The loaded regions of the image, without this struct, and the CRC-32 over them in this order. tools/seal_image.py writes them
/// after linking. An unsealed image fails the test.
typedef struct
{
    uint32_t magic;
    uint32_t crc;
    struct
    {
        uint32_t address, size; ///< bytes; size 0: not used
    } regions[SELFTEST_REGIONS];
} selftest_seal_t;

/// The seal of the running image.
extern const volatile selftest_seal_t selftest_seal;

/// Tests image, RAM and golden vector in this order, up to the first that fails. RAM is tested from `ram` to the stack in use, at
/// most `ram_bytes_max`. Call it with interrupts off.
drive_fault_t selftest_run(const volatile selftest_seal_t *seal,
                           const uint8_t                  *memory,
                           uint32_t                       *ram,
                           size_t                          ram_bytes_max);

/// Tests the image against its seal. `memory` is the location of the seal's address 0: null on a microcontroller.
drive_fault_t selftest_image(const volatile selftest_seal_t *seal, const uint8_t *memory);

/// Access to a word of RAM; tests pass a defective one.
typedef struct
{
    uint32_t (*read)(const volatile uint32_t *word);
    void (*write)(volatile uint32_t *word, uint32_t value);
} selftest_ram_t;

extern const selftest_ram_t selftest_ram_real;

/// Tests the address lines, then each of `count` words with patterns that reveal stuck and shorted bits. Restores the contents.
/// The words must be outside the stack in use, and interrupts off.
drive_fault_t selftest_ram(const selftest_ram_t *ram, volatile uint32_t *words, size_t count);

/// The expected CRC-32 over all signals of three loops, 200 ticks each: that of golden.yaml, and its first two sections with a
/// breakaway table, and with a breakaway slope and a gain above 1. The value comes from the host (tests/firmware/test_selftest.c),
/// where the library is tested against double precision. It changes with any result of the library.
#ifdef TRIBO_ARITHMETIC_Q31
#define SELFTEST_GOLDEN_CRC 0xc1d5ec97u
#else
#define SELFTEST_GOLDEN_CRC 0x22a031dcu
#endif

drive_fault_t selftest_golden(void);

/// Computes this CRC.
uint32_t selftest_golden_crc(void);

#endif
