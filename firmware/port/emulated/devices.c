#include "devices.h"

#include <semihost.h>
#include <string.h>

static int bus   = -1;
static int flash = -1;

void devices_open(void)
{
    char line[64] = "";
    (void)sys_semihost_get_cmdline(line, sizeof line);
    line[sizeof line - 1u] = '\0';
    bus                    = strstr(line, "bus") != NULL ? sys_semihost_open(DEVICES_BUS, SH_OPEN_R_PLUS_B) : -1;
    flash                  = strstr(line, "flash") != NULL ? sys_semihost_open(DEVICES_FLASH, SH_OPEN_R_PLUS_B) : -1;
}

bool devices_have_bus(void)
{
    return bus >= 0;
}

// --- bus -----------------------------------------------------------------------------------------------------------

/// Semihosting returns the number of missing bytes.
static size_t done(uintptr_t missing, size_t asked)
{
    return missing <= asked ? asked - missing : 0u;
}

static int receive(void *context, uint8_t *bytes, size_t room)
{
    (void)context;
    return bus >= 0 ? (int)done(sys_semihost_read(bus, bytes, room), room) : 0;
}

static size_t send(void *context, const uint8_t *bytes, size_t count)
{
    (void)context;
    return bus >= 0 ? done(sys_semihost_write(bus, bytes, count), count) : count;
}

const modbus_line_t *devices_line(void)
{
    static const modbus_line_t line = {.receive = receive, .send = send};
    return &line;
}

// --- flash ---------------------------------------------------------------------------------------------------------

#define ERASED 0xffffffffu

static bool seek(unsigned sector, uint32_t word)
{
    return sys_semihost_seek(flash, 4u * (sector * DEVICES_SECTOR_WORDS + word)) == 0;
}

/// Words beyond the end of the file read as erased.
static uint32_t read_word(void *context, unsigned sector, uint32_t word)
{
    uint32_t value = ERASED;
    (void)context;
    return seek(sector, word) && sys_semihost_read(flash, &value, sizeof value) == 0u ? value : ERASED;
}

static bool put_word(unsigned sector, uint32_t word, uint32_t value)
{
    return seek(sector, word) && sys_semihost_write(flash, &value, sizeof value) == 0u;
}

static bool erase(void *context, unsigned sector)
{
    bool ok = true;
    (void)context;
    for (uint32_t word = 0; ok && word < DEVICES_SECTOR_WORDS; word++)
    {
        ok = put_word(sector, word, ERASED);
    }
    return ok;
}

/// Writes a word. It only clears bits, as flash does.
static bool write_word(void *context, unsigned sector, uint32_t word, uint32_t value)
{
    return put_word(sector, word, read_word(context, sector, word) & value);
}

const store_flash_t *devices_flash(void)
{
    static const store_flash_t file = {.sector_words = DEVICES_SECTOR_WORDS,
                                       .read         = read_word,
                                       .erase        = erase,
                                       .write        = write_word};
    return flash >= 0 ? &file : NULL;
}
