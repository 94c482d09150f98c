#include "app/store.h"

#include "app/crc32.h"

#define ERASED   0xffffffffu
#define REPLACED 0u

enum
{
    MARK    = 0,
    VERSION = 2,
    LAYOUT  = 3,
    NUMBER  = 4,
    LENGTH  = 5
};

typedef enum
{
    UNMARKED,
    CURRENT,
    REPLACED_BY_OTHER
} mark_t;

typedef struct
{
    mark_t   mark;
    bool     good; ///< the CRC matches
    uint32_t number, length;
} sector_t;

static uint32_t word_of(const store_flash_t *flash, unsigned sector, uint32_t word)
{
    return flash->read(flash->context, sector, word);
}

static uint32_t crc_of(const store_flash_t *flash, unsigned sector, uint32_t length)
{
    uint32_t crc = 0;
    for (uint32_t i = VERSION; i < STORE_HEAD_WORDS + length; i++)
    {
        const uint32_t word = word_of(flash, sector, i);
        crc                 = crc32_update(crc, &word, sizeof word);
    }
    return crc;
}

static bool has_room(const store_flash_t *flash, uint32_t length)
{
    return length <= STORE_WORDS_MAX && STORE_HEAD_WORDS + length + 1u <= flash->sector_words;
}

static mark_t mark_of(const store_flash_t *flash, unsigned sector)
{
    const uint32_t a = word_of(flash, sector, MARK);
    const uint32_t b = word_of(flash, sector, MARK + 1u);
    if (a == STORE_CURRENT || b == STORE_CURRENT)
    {
        return CURRENT;
    }
    return a == REPLACED || b == REPLACED ? REPLACED_BY_OTHER : UNMARKED;
}

static sector_t look_at(const store_flash_t *flash, unsigned sector)
{
    sector_t seen = {.mark   = mark_of(flash, sector),
                     .number = word_of(flash, sector, NUMBER),
                     .length = word_of(flash, sector, LENGTH)};
    seen.good     = has_room(flash, seen.length) &&
                word_of(flash, sector, STORE_HEAD_WORDS + seen.length) == crc_of(flash, sector, seen.length);
    return seen;
}

static bool write_mark(const store_flash_t *flash, unsigned sector, uint32_t mark)
{
    const bool first = flash->write(flash->context, sector, MARK, mark);
    return flash->write(flash->context, sector, MARK + 1u, mark) && first;
}

#define NONE STORE_SECTORS

/// Returns the sector of the last record, or NONE with the reason in `status`.
static unsigned find_last(const sector_t sectors[STORE_SECTORS], store_status_t *status)
{
    unsigned last = NONE;
    for (unsigned i = 0; i < STORE_SECTORS; i++)
    {
        // A good record may lack its marks: they were not finished, or have rotted.
        const bool candidate = sectors[i].good && sectors[i].mark != REPLACED_BY_OTHER;
        const bool newer     = last == NONE || (int32_t)(sectors[i].number - sectors[last].number) > 0;
        last                 = candidate && newer ? i : last;
    }
    const bool rotten =
        (sectors[0].mark == CURRENT && !sectors[0].good) || (sectors[1].mark == CURRENT && !sectors[1].good);
    const bool replaced = sectors[0].mark == REPLACED_BY_OTHER || sectors[1].mark == REPLACED_BY_OTHER;
    *status             = rotten || (last == NONE && replaced) ? STORE_DAMAGED : last == NONE ? STORE_EMPTY : STORE_OK;
    return *status == STORE_OK ? last : NONE;
}

store_status_t store_read(const store_flash_t *flash, uint32_t layout, uint32_t *words, uint32_t count)
{
    const sector_t sectors[STORE_SECTORS] = {look_at(flash, 0), look_at(flash, 1)};
    store_status_t status;
    const unsigned last = find_last(sectors, &status);
    if (last == NONE)
    {
        return status;
    }
    if (word_of(flash, last, VERSION) != STORE_VERSION || word_of(flash, last, LAYOUT) != layout ||
        sectors[last].length != count)
    {
        return STORE_FOREIGN;
    }
    for (uint32_t i = 0; i < count; i++)
    {
        words[i] = word_of(flash, last, STORE_HEAD_WORDS + i);
    }
    return STORE_OK;
}

static bool write_record(const store_flash_t *flash,
                         unsigned             sector,
                         const uint32_t       head[STORE_HEAD_WORDS],
                         const uint32_t      *words,
                         uint32_t             count)
{
    bool ok = flash->erase(flash->context, sector);
    for (uint32_t i = VERSION; ok && i < STORE_HEAD_WORDS + count; i++)
    {
        const uint32_t value = i < STORE_HEAD_WORDS ? head[i] : words[i - STORE_HEAD_WORDS];
        ok                   = flash->write(flash->context, sector, i, value) && word_of(flash, sector, i) == value;
    }
    const uint32_t crc = ok ? crc_of(flash, sector, count) : 0u;
    ok                 = ok && flash->write(flash->context, sector, STORE_HEAD_WORDS + count, crc);
    return ok && look_at(flash, sector).good;
}

/// Marks `sector` as replaced before its erasure, so that an interrupted erasure does not look like a rotten record. No
/// record of a damaged store may reappear, so the sector that shows the damage is marked last.
static bool mark_replaced(const store_flash_t *flash,
                          const sector_t       sectors[STORE_SECTORS],
                          store_status_t       status,
                          unsigned             sector)
{
    if (status == STORE_DAMAGED)
    {
        const unsigned shows = sectors[0].mark == CURRENT && !sectors[0].good ? 0u : 1u;
        return write_mark(flash, 1u - shows, REPLACED) && write_mark(flash, shows, REPLACED);
    }
    return sectors[sector].mark != CURRENT || write_mark(flash, sector, REPLACED);
}

/// Returns true if the last record is this one, so that nothing needs to be erased.
static bool holds(const store_flash_t *flash,
                  const sector_t       sectors[STORE_SECTORS],
                  unsigned             last,
                  uint32_t             layout,
                  const uint32_t      *words,
                  uint32_t             count)
{
    bool same = last != NONE && sectors[last].length == count && mark_of(flash, last) == CURRENT &&
                word_of(flash, last, VERSION) == STORE_VERSION && word_of(flash, last, LAYOUT) == layout;
    for (uint32_t i = 0; same && i < count; i++)
    {
        same = word_of(flash, last, STORE_HEAD_WORDS + i) == words[i];
    }
    return same;
}

bool store_holds(const store_flash_t *flash, uint32_t layout, const uint32_t *words, uint32_t count)
{
    const sector_t sectors[STORE_SECTORS] = {look_at(flash, 0), look_at(flash, 1)};
    store_status_t status;
    return holds(flash, sectors, find_last(sectors, &status), layout, words, count);
}

store_status_t store_write(const store_flash_t *flash, uint32_t layout, const uint32_t *words, uint32_t count)
{
    if (!has_room(flash, count))
    {
        return STORE_FAILED;
    }
    const sector_t sectors[STORE_SECTORS] = {look_at(flash, 0), look_at(flash, 1)};
    store_status_t status;
    const unsigned last = find_last(sectors, &status);
    if (holds(flash, sectors, last, layout, words, count))
    {
        return STORE_OK;
    }
    // If there is no last record, a good one is an old one of a damaged store. It stays marked as replaced, because an
    // interrupted erasure could take only the mark away, and its number is exceeded for the same reason.
    const unsigned other  = last != NONE ? last : sectors[0].good ? 0u : 1u;
    const unsigned sector = 1u - other;
    const uint32_t number = 1u + (sectors[other].good ? sectors[other].number : 0u);

    const uint32_t head[STORE_HEAD_WORDS] = {ERASED, ERASED, STORE_VERSION, layout, number, count};
    if (!mark_replaced(flash, sectors, status, sector) || !write_record(flash, sector, head, words, count) ||
        !write_mark(flash, sector, STORE_CURRENT) || mark_of(flash, sector) != CURRENT)
    {
        return STORE_FAILED;
    }
    (void)write_mark(flash, 1u - sector, REPLACED); // optional, because this record is already the last one
    return STORE_OK;
}

const char *store_status_text(store_status_t status)
{
    static const char *const texts[] = {[STORE_OK]      = "read",
                                        [STORE_EMPTY]   = "empty",
                                        [STORE_FOREIGN] = "of other firmware",
                                        [STORE_DAMAGED] = "damaged",
                                        [STORE_FAILED]  = "not writable"};
    return (unsigned)status < sizeof texts / sizeof texts[0] ? texts[status] : "unknown";
}
