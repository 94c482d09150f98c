/// One record of words, e.g. the params of a drive, in two sectors of flash in turn. Whenever the power fails, a read after it
/// finds the record of before or the new one.
///
///     sector    word 0, 1    marks: erased, then STORE_CURRENT when the record is complete, 0 when the other sector's has
///                            taken its place
///               2            STORE_VERSION
///               3            layout, which tells what the words mean
///               4            number, one more with each record
///               5            words in the record
///               6 ...        the record, then the CRC-32 from word 2 on
///
/// A write erases the sector that is not current, fills it, marks it current, and then the other one replaced. So a sector
/// marked current whose CRC is wrong has rotted, and the older record beside it is not taken for the last one saved: the store
/// is damaged. A mark is two words, as one may rot.
///
/// A word must keep bits that are written to 0 twice, and a write may only clear bits, as with NOR flash without ECC.

#ifndef DRIVE_STORE_H
#define DRIVE_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STORE_SECTORS    2u
#define STORE_VERSION    1u
#define STORE_CURRENT    0x43555252u // "RRUC"
#define STORE_HEAD_WORDS 6u
#define STORE_WORDS_MAX  1024u ///< of a record

/// The flash; no function waits without a time-out. `sector` is 0 or 1, `word` counts 32-bit words from its start.
typedef struct
{
    void    *context;
    uint32_t sector_words; ///< of each sector, at least STORE_HEAD_WORDS + 1 and the record's
    uint32_t (*read)(void *context, unsigned sector, uint32_t word);
    bool (*erase)(void *context, unsigned sector);
    bool (*write)(void *context, unsigned sector, uint32_t word, uint32_t value);
} store_flash_t;

typedef enum
{
    STORE_OK,
    STORE_EMPTY,   ///< nothing was ever saved, or the first save did not end
    STORE_FOREIGN, ///< the record has another version, layout or length: of other firmware
    STORE_DAMAGED, ///< the last record has rotted
    STORE_FAILED   ///< the flash could not be erased or written
} store_status_t;

/// Reads the last record into `words`, which are not changed unless STORE_OK.
store_status_t store_read(const store_flash_t *flash, uint32_t layout, uint32_t *words, uint32_t count);

/// Writes a record and reads it back; STORE_OK or STORE_FAILED, which leaves the record of before. Takes as long as erasing a
/// sector does. Whatever the store held, damaged or not, afterwards it holds this.
store_status_t store_write(const store_flash_t *flash, uint32_t layout, const uint32_t *words, uint32_t count);

/// A few words for a log. Never null.
const char *store_status_text(store_status_t status);

#endif
