/// Keeps one record of words, e.g. the params of a drive, in two alternating sectors of flash. After a power failure at any time,
/// a read finds either the old record or the new one.
///
///     sector    word 0, 1    marks: erased, then STORE_CURRENT when the record is complete, 0 when the record of the other
///                            sector has replaced it
///               2            STORE_VERSION
///               3            layout, the meaning of the words
///               4            number, one more with each record
///               5            words in the record
///               6 ...        the record, then the CRC-32 from word 2 on
///
/// A write erases the sector that is not current, fills it, marks it current, and then marks the other one replaced. A sector
/// marked current with a wrong CRC has therefore rotted. The store is then damaged, and the older record does not count as the
/// last one. A mark has two words, because one may rot.
///
/// The flash must be NOR flash without ECC: a write only clears bits, and a bit may be cleared twice. A write before an
/// erasure must have reached the flash before any of that sector is erased; flash does so by itself.

#ifndef DRIVE_STORE_H
#define DRIVE_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STORE_SECTORS    2u
#define STORE_VERSION    1u
#define STORE_CURRENT    0x43555252u // "RRUC"
#define STORE_HEAD_WORDS 6u
#define STORE_WORDS_MAX  1024u ///< largest record

/// The flash. Every wait in it has a time-out. `sector` is 0 or 1, `word` counts 32-bit words from its start.
typedef struct
{
    void    *context;
    uint32_t sector_words; ///< size of each sector, at least STORE_HEAD_WORDS + 1 more than the record
    uint32_t (*read)(void *context, unsigned sector, uint32_t word);
    bool (*erase)(void *context, unsigned sector);
    bool (*write)(void *context, unsigned sector, uint32_t word, uint32_t value);
} store_flash_t;

typedef enum
{
    STORE_OK,
    STORE_EMPTY,   ///< nothing was ever saved, or the first save was interrupted
    STORE_FOREIGN, ///< the record has another version, layout or length, from other firmware
    STORE_DAMAGED, ///< the last record has rotted
    STORE_FAILED   ///< the flash could not be erased or written
} store_status_t;

/// Reads the last record into `words`. Leaves them unchanged unless it returns STORE_OK.
store_status_t store_read(const store_flash_t *flash, uint32_t layout, uint32_t *words, uint32_t count);

/// Returns true if the last record is this one, so that a write erases nothing.
bool store_holds(const store_flash_t *flash, uint32_t layout, const uint32_t *words, uint32_t count);

/// Writes a record and reads it back, unless it is already the last one. Returns STORE_OK, or STORE_FAILED, which leaves the old
/// record. Takes as long as erasing a sector. Also replaces the contents of a damaged store.
store_status_t store_write(const store_flash_t *flash, uint32_t layout, const uint32_t *words, uint32_t count);

/// Returns a short text for a log. Never null.
const char *store_status_text(store_status_t status);

#endif
