/// The drive's self-test at power-up, before anything moves. Each part returns the fault found, or DRIVE_FAULT_NONE.

#ifndef DRIVE_SELFTEST_H
#define DRIVE_SELFTEST_H

#include "app/drive.h"

#include <stddef.h>
#include <stdint.h>

#define SELFTEST_REGIONS 4u
#define SELFTEST_MAGIC   0x4c414553u // "SEAL"

/// Written after linking, by tools/seal_image.py: the loaded regions of the image, without this struct, and the CRC-32 over
/// them in this order. An unsealed image fails.
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

/// Image, RAM and golden vector in this order, up to the first that fails. RAM is tested from `ram` to the stack in use, at
/// most `ram_bytes_max`; call it with interrupts off.
drive_fault_t selftest_run(const volatile selftest_seal_t *seal,
                           const uint8_t                  *memory,
                           uint32_t                       *ram,
                           size_t                          ram_bytes_max);

/// `memory` is the location of the seal's address 0: null on a microcontroller.
drive_fault_t selftest_image(const volatile selftest_seal_t *seal, const uint8_t *memory);

/// Access to a word of RAM; tests pass a defective one.
typedef struct
{
    uint32_t (*read)(const volatile uint32_t *word);
    void (*write)(volatile uint32_t *word, uint32_t value);
} selftest_ram_t;

extern const selftest_ram_t selftest_ram_real;

/// Tests the address lines, then every word with patterns that reveal stuck and shorted bits. Restores the contents. For
/// `count` words outside the stack in use, with interrupts off.
drive_fault_t selftest_ram(const selftest_ram_t *ram, volatile uint32_t *words, size_t count);

/// The CRC-32 over all signals of 200 ticks each of three loops: two sections (golden.yaml), three sections and a breakaway
/// table (golden_table.yaml), and a breakaway slope and a gain above 1 (golden_steep.yaml). The expected value is the host's
/// (tests/firmware/test_selftest.c), where the library is tested against double precision. It changes with any result of the
/// library.
#ifdef TRIBO_ARITHMETIC_Q31
#define SELFTEST_GOLDEN_CRC 0x4ea4265bu
#else
#define SELFTEST_GOLDEN_CRC 0x8984c871u
#endif

drive_fault_t selftest_golden(void);

/// The CRC itself.
uint32_t selftest_golden_crc(void);

#endif
