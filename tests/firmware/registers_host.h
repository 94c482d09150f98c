// The drive's registers and a host that reads and writes them, on a flash that is RAM. Of the tests of registers: each has its own
// power-up and its own plant.

#ifndef TESTS_FIRMWARE_REGISTERS_HOST_H
#define TESTS_FIRMWARE_REGISTERS_HOST_H

#include "app/registers.h"
#include "board.h"
#include "unity.h"

#include <string.h>

#define SECTOR_WORDS (STORE_HEAD_WORDS + PARAMS_WORDS + 32u) // room for a set of an older, longer list

static board_t            board;
static registers_t        registers;
static modbus_registers_t map;
static params_set_t       defaults;
static unsigned           erasures;
static void (*on_erase)(void); ///< null: nothing comes meanwhile
static uint32_t sectors[STORE_SECTORS][SECTOR_WORDS];

// --- a board -------------------------------------------------------------------------------------------------------

static uint32_t read_flash(void *context, unsigned sector, uint32_t word)
{
    (void)context;
    return sectors[sector][word];
}

static bool erase_flash(void *context, unsigned sector)
{
    (void)context;
    erasures++;
    if (on_erase != NULL)
    {
        on_erase();
    }
    memset(sectors[sector], 0xff, sizeof sectors[sector]);
    return true;
}

static bool write_flash(void *context, unsigned sector, uint32_t word, uint32_t value)
{
    (void)context;
    sectors[sector][word] &= value;
    return true;
}

static const store_flash_t flash = {.sector_words = SECTOR_WORDS,
                                    .read         = read_flash,
                                    .erase        = erase_flash,
                                    .write        = write_flash};

static size_t send_all(void *context, const uint8_t *bytes, size_t count)
{
    (void)context;
    (void)bytes;
    return count;
}

static const modbus_line_t line = {.receive = board_receive_nothing, .send = send_all};

// --- a host --------------------------------------------------------------------------------------------------------

static uint32_t read_word(uint32_t address)
{
    uint16_t values[2] = {0, 0};
    TEST_ASSERT_EQUAL_INT(MODBUS_OK, map.read(map.context, (uint16_t)address, 2, values));
    return (uint32_t)values[0] << 16 | values[1];
}

static modbus_status_t try_word(uint32_t address, uint32_t word)
{
    const uint16_t values[2] = {(uint16_t)(word >> 16), (uint16_t)word};
    return map.write(map.context, (uint16_t)address, 2, values);
}

static void write_word(uint32_t address, uint32_t word)
{
    TEST_ASSERT_EQUAL_INT(MODBUS_OK, try_word(address, word));
}

static modbus_status_t try_command(uint16_t command)
{
    return map.write(map.context, REGISTERS_COMMAND_AT, 1, &command);
}

static void command(uint16_t number)
{
    TEST_ASSERT_EQUAL_INT(MODBUS_OK, try_command(number));
}

#define STATE_OF(symbol)    read_word(REGISTERS_STATE_AT + 2u * REGISTERS_STATE_##symbol)
#define REQUEST_AT(symbol)  (REGISTERS_REQUESTS_AT + (uint32_t)offsetof(registers_requests_t, symbol) / 2u)
#define DRIVE_AT(symbol)    (REGISTERS_STAGED_AT + REGISTERS_DRIVE_AT + 2u * DRIVE_CONFIG_##symbol)
#define TO_ACTIVE(register) ((register) - REGISTERS_STAGED_AT + REGISTERS_ACTIVE_AT)

#endif
