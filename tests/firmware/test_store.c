// The store of params: power cut at every write and erasure of random histories, and bits that rot.

#include "app/crc32.h"
#include "app/store.h"
#include "runs.h"
#include "unity.h"

#include <string.h>

#define SECTOR_WORDS 40u
#define LAYOUT       0x1234u
#define RECORD_MAX   12u
#define HISTORIES    RUNS(1000u, 10u)

typedef struct
{
    uint32_t words[STORE_SECTORS][SECTOR_WORDS];
    uint32_t operations; ///< writes and erasures so far
    uint32_t cut_at;     ///< the operation in which the power fails; from there on nothing is written
    bool     broken;     ///< every write fails
    uint32_t erasable;   ///< the power fails in an erasure after so many words, if the sector has more
    uint32_t stuck;      ///< a word of sector 1 that takes no write
    unsigned erasures[STORE_SECTORS];
} chip_t;

static chip_t   chip;
static uint32_t random_state = 1; // xorshift32, seed 1

static uint32_t random_word(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state;
}

static uint32_t random_up_to(uint32_t limit)
{
    return random_word() % (limit + 1u);
}

/// A word whose change was cut short: some of the bits that were to change have.
static uint32_t torn(uint32_t from, uint32_t to)
{
    const uint32_t some    = random_word();
    const uint32_t more    = random_word();
    const uint32_t masks[] = {0u, 0xffffffffu, some, some | more};
    const uint32_t mask    = masks[random_up_to(3)];
    return from ^ ((from ^ to) & mask);
}

static uint32_t read_chip(void *context, unsigned sector, uint32_t word)
{
    const chip_t *from = context;
    TEST_ASSERT_LESS_THAN_UINT32(STORE_SECTORS, sector);
    TEST_ASSERT_LESS_THAN_UINT32(SECTOR_WORDS, word);
    return from->words[sector][word];
}

static bool erase_chip(void *context, unsigned sector)
{
    chip_t        *to        = context;
    const uint32_t operation = to->operations++;
    if (to->broken)
    {
        return false;
    }
    if (to->erasable < SECTOR_WORDS)
    {
        memset(to->words[sector], 0xff, to->erasable * sizeof(uint32_t));
        return false;
    }
    to->erasures[sector] += operation < to->cut_at;
    for (uint32_t i = 0; i < SECTOR_WORDS && operation <= to->cut_at; i++)
    {
        to->words[sector][i] = operation == to->cut_at ? torn(to->words[sector][i], 0xffffffffu) : 0xffffffffu;
    }
    return true;
}

static bool write_chip(void *context, unsigned sector, uint32_t word, uint32_t value)
{
    chip_t        *to        = context;
    const uint32_t operation = to->operations++;
    TEST_ASSERT_LESS_THAN_UINT32(SECTOR_WORDS, word);
    if (to->broken)
    {
        return false;
    }
    const uint32_t was = to->words[sector][word];
    if (operation <= to->cut_at && (sector == 0u || word != to->stuck))
    {
        to->words[sector][word] = operation == to->cut_at ? torn(was, was & value) : was & value;
    }
    return true;
}

static const store_flash_t flash = {.context      = &chip,
                                    .sector_words = SECTOR_WORDS,
                                    .read         = read_chip,
                                    .erase        = erase_chip,
                                    .write        = write_chip};

void setUp(void)
{
    memset(&chip, 0, sizeof chip);
    memset(chip.words, 0xff, sizeof chip.words);
    chip.cut_at   = UINT32_MAX;
    chip.stuck    = UINT32_MAX;
    chip.erasable = SECTOR_WORDS;
}

typedef struct
{
    uint32_t words[RECORD_MAX];
} record_t;

static record_t random_record(void)
{
    record_t record;
    for (unsigned i = 0; i < RECORD_MAX; i++)
    {
        record.words[i] = random_up_to(3) == 0 ? (random_up_to(1) == 0 ? 0u : 0xffffffffu) : random_word();
    }
    return record;
}

static store_status_t save(const record_t *record)
{
    return store_write(&flash, LAYOUT, record->words, RECORD_MAX);
}

static store_status_t load(record_t *record)
{
    memset(record, 0x77, sizeof *record);
    return store_read(&flash, LAYOUT, record->words, RECORD_MAX);
}

static bool holds(const record_t *record)
{
    record_t found;
    return load(&found) == STORE_OK && memcmp(&found, record, sizeof found) == 0;
}

static void test_an_erased_store_is_empty_and_stays_so(void)
{
    record_t found, before;
    memset(&before, 0x77, sizeof before);
    TEST_ASSERT_EQUAL_INT(STORE_EMPTY, load(&found));
    TEST_ASSERT_EQUAL_MEMORY(&before, &found, sizeof found);
    TEST_ASSERT_EQUAL_UINT32(0, chip.operations);
}

static void test_records_alternate_between_the_sectors(void)
{
    for (unsigned i = 0; i < 10; i++)
    {
        const record_t record = random_record();
        TEST_ASSERT_EQUAL_INT(STORE_OK, save(&record));
        TEST_ASSERT_TRUE(holds(&record));
        TEST_ASSERT_EQUAL_UINT(i / 2 + 1, chip.erasures[0]);
        TEST_ASSERT_EQUAL_UINT((i + 1) / 2, chip.erasures[1]);
    }
}

static void test_a_record_that_is_the_last_one_costs_no_erasure(void)
{
    const record_t record = random_record();
    (void)save(&record);
    const uint32_t operations = chip.operations;
    TEST_ASSERT_EQUAL_INT(STORE_OK, save(&record));
    TEST_ASSERT_EQUAL_UINT32(operations, chip.operations);
    // Another layout or length is another record.
    TEST_ASSERT_EQUAL_INT(STORE_OK, store_write(&flash, LAYOUT + 1u, record.words, RECORD_MAX));
    TEST_ASSERT_EQUAL_INT(STORE_OK, store_write(&flash, LAYOUT + 1u, record.words, RECORD_MAX - 1u));
    TEST_ASSERT_EQUAL_UINT(2, chip.erasures[0]);
    TEST_ASSERT_EQUAL_UINT(1, chip.erasures[1]);
    TEST_ASSERT_EQUAL_INT(STORE_OK, save(&record));
    TEST_ASSERT_TRUE(holds(&record));
    // One that has rotted is written again.
    chip.words[1][STORE_HEAD_WORDS] ^= 1u;
    TEST_ASSERT_EQUAL_INT(STORE_OK, save(&record));
    TEST_ASSERT_TRUE(holds(&record));
}

/// With the number set by hand, and the CRC over it.
static void test_numbers_wrap(void)
{
    record_t record = random_record();
    (void)save(&record);
    chip.words[0][4] = 0xffffffffu;
    chip.words[0][STORE_HEAD_WORDS + RECORD_MAX] =
        crc32_update(0, chip.words[0] + 2, 4u * (STORE_HEAD_WORDS - 2u + RECORD_MAX));
    TEST_ASSERT_TRUE(holds(&record));
    const chip_t before = chip;
    record              = random_record();
    (void)save(&record);
    TEST_ASSERT_EQUAL_HEX32(0, chip.words[1][4]);
    chip.words[0][0] = before.words[0][0]; // as if the power had failed before the old record was marked as replaced
    TEST_ASSERT_TRUE(holds(&record));
}

static void test_a_record_of_other_firmware_is_not_taken(void)
{
    const record_t record = random_record();
    record_t       found;
    (void)save(&record);
    TEST_ASSERT_EQUAL_INT(STORE_FOREIGN, store_read(&flash, LAYOUT + 1u, found.words, RECORD_MAX));
    TEST_ASSERT_EQUAL_INT(STORE_FOREIGN, store_read(&flash, LAYOUT, found.words, RECORD_MAX - 1u));
    TEST_ASSERT_TRUE(holds(&record));
}

static void test_a_record_that_has_no_room_is_refused(void)
{
    static const uint32_t words[SECTOR_WORDS];
    TEST_ASSERT_EQUAL_INT(STORE_OK, store_write(&flash, LAYOUT, words, SECTOR_WORDS - STORE_HEAD_WORDS - 1u));
    TEST_ASSERT_EQUAL_INT(STORE_FAILED, store_write(&flash, LAYOUT, words, SECTOR_WORDS - STORE_HEAD_WORDS));
    TEST_ASSERT_EQUAL_INT(STORE_FAILED, store_write(&flash, LAYOUT, words, 0xfffffff0u));
}

static void test_flash_that_does_not_take_a_write_leaves_the_last_record(void)
{
    const record_t record = random_record();
    const record_t next   = random_record();
    (void)save(&record);
    chip.broken = true;
    TEST_ASSERT_EQUAL_INT(STORE_FAILED, save(&next));
    TEST_ASSERT_TRUE(holds(&record));
    chip.broken = false;
    chip.cut_at = chip.operations + 3; // says yes, and writes nothing
    TEST_ASSERT_EQUAL_INT(STORE_FAILED, save(&next));
    TEST_ASSERT_TRUE(holds(&record));
}

static void test_a_word_that_takes_no_write_is_found(void)
{
    for (uint32_t word = 0; word <= STORE_HEAD_WORDS + RECORD_MAX; word++)
    {
        setUp();
        const record_t record = random_record();
        record_t       next;
        memset(&next, 0x11, sizeof next); // an erased word would be right by chance
        (void)save(&record);
        chip.stuck                = word;
        const store_status_t said = save(&next);
        TEST_ASSERT_TRUE(said == STORE_OK ? holds(&next) : holds(&record));
        TEST_ASSERT_TRUE(said == STORE_FAILED || word < 2u); // of the two marks one is enough
    }
}

static void test_every_status_has_a_text(void)
{
    for (unsigned i = 0; i <= STORE_FAILED; i++)
    {
        TEST_ASSERT_NOT_EQUAL_INT(0, strcmp("unknown", store_status_text((store_status_t)i)));
    }
    TEST_ASSERT_EQUAL_STRING("unknown", store_status_text((store_status_t)99));
}

// --- the power fails -----------------------------------------------------------------------------------------------

/// The store must hold `old` (null: nothing was ever saved) or `next`.
static void check_old_or_new(const record_t *old, const record_t *next)
{
    record_t             found;
    const store_status_t status = load(&found);
    if (status == STORE_OK)
    {
        TEST_ASSERT_TRUE(memcmp(&found, next, sizeof found) == 0 ||
                         (old != NULL && memcmp(&found, old, sizeof found) == 0));
        record_t again;
        TEST_ASSERT_EQUAL_INT(STORE_OK, load(&again)); // and the same whenever it is read
        TEST_ASSERT_EQUAL_MEMORY(&found, &again, sizeof found);
    }
    else
    {
        TEST_ASSERT_NULL(old);
        TEST_ASSERT_EQUAL_INT(STORE_EMPTY, status);
    }
}

/// A save with the power cut in its operation `cut`; false if it has no such operation.
static bool cut_save(const record_t *old, const record_t *next, uint32_t cut)
{
    chip.operations              = 0;
    chip.cut_at                  = cut;
    const store_status_t said    = save(next);
    const bool           was_cut = chip.operations > cut;
    chip.cut_at                  = UINT32_MAX;
    check_old_or_new(old, next);
    TEST_ASSERT_TRUE(said == STORE_FAILED || holds(next)); // nor is a write that did not arrive taken for done
    return was_cut;
}

static void test_a_power_failure_leaves_the_old_record_or_the_new(void)
{
    unsigned cuts = 0;
    for (unsigned history = 0; history < HISTORIES; history++)
    {
        setUp();
        record_t       last;
        bool           saved = false;
        const unsigned saves = random_up_to(5);
        for (unsigned i = 0; i <= saves; i++)
        {
            const record_t next   = random_record();
            const chip_t   before = chip;
            uint32_t       cut    = 0;
            while (cut_save(saved ? &last : NULL, &next, cut))
            {
                const record_t after = random_record(); // the store works on after each
                TEST_ASSERT_EQUAL_INT(STORE_OK, save(&after));
                TEST_ASSERT_TRUE(holds(&after));
                chip = before;
                cut++;
                cuts++;
            }
            chip = before;
            // The history goes on from a save that was cut somewhere, or not.
            (void)cut_save(saved ? &last : NULL, &next, random_up_to(2 * cut));
            record_t found;
            saved = load(&found) == STORE_OK;
            last  = found;
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT(HISTORIES * 20u, cuts);
}

// --- bits rot ------------------------------------------------------------------------------------------------------

static void flip(unsigned sector, uint32_t bit)
{
    chip.words[sector][bit / 32u] ^= 1u << (bit % 32u);
}

#define USED_BITS (32u * (STORE_HEAD_WORDS + RECORD_MAX + 1u))

static void test_one_rotten_bit_never_brings_an_older_record_back(void)
{
    for (unsigned saves = 1; saves <= 4; saves++)
    {
        setUp();
        record_t last;
        for (unsigned i = 0; i < saves; i++)
        {
            last = random_record();
            (void)save(&last);
        }
        const chip_t   before  = chip;
        const unsigned current = (saves - 1u) % 2u;
        for (unsigned sector = 0; sector < STORE_SECTORS; sector++)
        {
            for (uint32_t bit = 0; bit < 32u * SECTOR_WORDS; bit++)
            {
                chip = before;
                flip(sector, bit);
                const bool spoils = sector == current && bit >= 64u && bit < USED_BITS;
                record_t   found;
                TEST_ASSERT_EQUAL_INT(spoils ? STORE_DAMAGED : STORE_OK, load(&found));
                TEST_ASSERT_TRUE(spoils || memcmp(&found, &last, sizeof last) == 0);
            }
        }
    }
}

static void test_rotten_bits_never_bring_a_wrong_record(void)
{
    for (unsigned i = 0; i < HISTORIES * 20u; i++)
    {
        setUp();
        record_t       last;
        const unsigned saves = 1u + random_up_to(3);
        for (unsigned k = 0; k < saves; k++)
        {
            last = random_record();
            (void)save(&last);
        }
        for (unsigned flips = 1u + random_up_to(3); flips > 0; flips--)
        {
            flip(random_up_to(1), random_up_to(USED_BITS - 1u));
        }
        record_t             found;
        const store_status_t status = load(&found);
        TEST_ASSERT_TRUE(status == STORE_DAMAGED || (status == STORE_OK && memcmp(&found, &last, sizeof last) == 0));

        // A damaged store takes a new record, and if the power fails in that, none of the old ones comes back.
        const record_t next = random_record();
        chip.operations     = 0;
        chip.cut_at         = random_up_to(random_up_to(1) == 0 ? 5 : 30);
        (void)save(&next);
        chip.cut_at                = UINT32_MAX;
        const store_status_t after = load(&found);
        TEST_ASSERT_TRUE(status == STORE_OK || after != STORE_OK || memcmp(&found, &next, sizeof next) == 0);
        TEST_ASSERT_EQUAL_INT(STORE_OK, save(&next));
        TEST_ASSERT_TRUE(holds(&next));
    }
}

/// The power fails at any point of an erasure, even where only the marks are gone.
static void test_an_interrupted_erasure_brings_no_record_of_a_damaged_store_back(void)
{
    for (uint32_t words = 0; words < SECTOR_WORDS; words++)
    {
        for (unsigned saves = 2; saves <= 3; saves++) // the last record is in sector 1, then in sector 0
        {
            setUp();
            record_t records[5], found;
            for (unsigned i = 0; i < 5u; i++)
            {
                records[i] = random_record();
                (void)(i < saves && save(&records[i]));
            }
            flip((saves - 1u) % 2u, 32u * STORE_HEAD_WORDS);
            chip.erasable = words;
            TEST_ASSERT_EQUAL_INT(STORE_FAILED, save(&records[3]));
            TEST_ASSERT_EQUAL_INT(STORE_DAMAGED, load(&found));
            chip.erasable = SECTOR_WORDS;
            TEST_ASSERT_EQUAL_INT(STORE_OK, save(&records[3]));
            chip.erasable = words; // the next save erases the sector that held a record of the damaged store
            TEST_ASSERT_EQUAL_INT(STORE_FAILED, save(&records[4]));
            TEST_ASSERT_TRUE(holds(&records[3]));
        }
    }
}

#include "runners/test_store.inc" // main
