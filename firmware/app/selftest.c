#include "app/selftest.h"

#include "app/crc32.h"
#ifdef TRIBO_ARITHMETIC_Q31
#include "app/golden_q31.h"
#else
#include "app/golden_f32.h"
#endif

// --- image ---------------------------------------------------------------------------------------------------------

drive_fault_t selftest_image(const volatile selftest_seal_t *seal, const uint8_t *memory)
{
    uint32_t crc   = 0;
    uint32_t total = 0;
    for (size_t i = 0; seal->magic == SELFTEST_MAGIC && i < SELFTEST_REGIONS; i++)
    {
        // NOLINTNEXTLINE(performance-no-int-to-ptr): the seal holds the linker's addresses
        const void *part = (const void *)((uintptr_t)memory + seal->regions[i].address);
        crc              = crc32_update(crc, part, seal->regions[i].size);
        total += seal->regions[i].size;
    }
    return total > 0u && crc == seal->crc ? DRIVE_FAULT_NONE : DRIVE_FAULT_IMAGE;
}

// --- RAM -----------------------------------------------------------------------------------------------------------

static uint32_t real_read(const volatile uint32_t *word)
{
    return *word;
}

static void real_write(volatile uint32_t *word, uint32_t value)
{
    *word = value;
}

const selftest_ram_t selftest_ram_real = {.read = real_read, .write = real_write};

static bool holds(const selftest_ram_t *ram, volatile uint32_t *word, uint32_t pattern)
{
    ram->write(word, pattern);
    return ram->read(word) == pattern;
}

static bool check_word(const selftest_ram_t *ram, volatile uint32_t *word)
{
    const uint32_t kept = ram->read(word);
    const bool ok = holds(ram, word, 0x55555555u) && holds(ram, word, 0xaaaaaaaau) && holds(ram, word, 0x33333333u) &&
                    holds(ram, word, 0xccccccccu);
    ram->write(word, kept);
    return ok;
}

/// With an open or shorted address line, word 0 and word 2^k are the same cell: a write to one changes the other.
static bool check_addresses(const selftest_ram_t *ram, volatile uint32_t *words, size_t count)
{
    const uint32_t kept_first = ram->read(words);
    bool           ok         = true;
    ram->write(words, 0x12345678u);
    for (size_t i = 1; i < count; i *= 2u)
    {
        const uint32_t kept = ram->read(words + i);
        ram->write(words + i, 0x87654321u);
        ok = ram->read(words) == 0x12345678u && ok;
        ram->write(words + i, kept);
        ram->write(words, 0x12345678u); // needed if both words are the same cell
    }
    ram->write(words, kept_first);
    return ok;
}

drive_fault_t selftest_ram(const selftest_ram_t *ram, volatile uint32_t *words, size_t count)
{
    bool ok = count > 0u && check_addresses(ram, words, count);
    for (size_t i = 0; ok && i < count; i++)
    {
        ok = check_word(ram, words + i);
    }
    return ok ? DRIVE_FAULT_NONE : DRIVE_FAULT_RAM;
}

// --- golden vector -------------------------------------------------------------------------------------------------

#define GOLDEN_TICKS   200
#define GOLDEN_POINTS  3u
#define GOLDEN_RANGE_N 4.0f ///< force of 2^31 in golden_reference; the full scale in Q31

/// The reference is a triangle, a jump beyond the limits, then slow motion to and fro within breakaway, where friction
/// follows its curve.
static int32_t golden_reference(int32_t tick)
{
    const int32_t phase = tick % 40;
    const int32_t wave  = phase < 20 ? phase : 40 - phase;
    if (tick < 80)
    {
        return wave * (1 << 23) - (tick / 40) * (1 << 27);
    }
    if (tick < 120)
    {
        return tick < 84 ? 15 * (1 << 26) : 0;
    }
    return wave * (1 << 17) - (1 << 20);
}

/// The simulated sensor follows the reference with a lag, and reads 0 at the end.
static uint32_t run_golden(const loop_params_t *params, uint32_t crc)
{
    loop_state_t state = {.memory = NULL};
    int32_t      y     = 0;
    (void)TRIBO(force_loop, start)(&state, params, false); // cannot fail: the paper's method needs no memory
    for (int32_t k = 0; k < GOLDEN_TICKS; k++)
    {
        const int32_t  r = golden_reference(k);
        loop_signals_t signals;
        uint32_t       words[TRIBO_SIGNAL_WORDS];
        y = k < 120 ? y + (r - y) / 8 : 0;
        (void)TRIBO(force_loop, step)(params,
                                      &state,
                                      tribo_force_of_q31(r, GOLDEN_RANGE_N),
                                      tribo_force_of_q31(y, GOLDEN_RANGE_N),
                                      &signals);
        tribo_signal_words(&signals, words);
        crc = crc32_update(crc, words, sizeof words);
    }
    return crc;
}

/// Runs the loop with its first two sections, which take another way than three, another friction law and another gain.
static uint32_t run_golden_with(const tribo_friction_f32_config_t *friction, loop_force_t gain, uint32_t crc)
{
    loop_params_t params            = golden_params;
    params.gain                     = gain;
    params.controller.cascade.count = 2;
#if TRIBO_IS_Q31
    tribo_point_t table[GOLDEN_POINTS];
    (void)tribo_friction_q31_init(&params.compensator.friction,
                                  table,
                                  friction,
                                  GOLDEN_SAMPLE_TIME_S,
                                  GOLDEN_FULL_SCALE_N);
#else
    (void)tribo_friction_f32_init(&params.compensator.friction, friction, GOLDEN_SAMPLE_TIME_S);
#endif
    return run_golden(&params, crc);
}

uint32_t selftest_golden_crc(void)
{
    static const tribo_breakaway_point_f32_t points[GOLDEN_POINTS] = {
        {.force_n = 0.0f, .positive_n = 0.0078125f, .negative_n = 0.015625f},
        {.force_n = 0.5f, .positive_n = 0.125f, .negative_n = 0.1875f},
        {.force_n = 1.0f, .positive_n = 0.3125f, .negative_n = 0.25f}};
    const tribo_friction_f32_config_t paper = tribo_force_loop_f32_paper().compensator.friction;
    tribo_friction_f32_config_t       table = paper;
    tribo_friction_f32_config_t       steep = paper;
    table.table                             = points;
    table.table_length                      = GOLDEN_POINTS;
    steep.positive     = (tribo_breakaway_f32_t){.offset_n = 0.0078125f, .slope = 1.25f}; // an integer part in Q31
    steep.negative     = (tribo_breakaway_f32_t){.offset_n = 0.015625f, .slope = 0.5f};
    const uint32_t crc = run_golden_with(&table, golden_params.gain, run_golden(&golden_params, 0));
    return run_golden_with(&steep, TRIBO_EITHER(1.5f, 3 * (1 << 28)), crc);
}

drive_fault_t selftest_golden(void)
{
    return selftest_golden_crc() == SELFTEST_GOLDEN_CRC ? DRIVE_FAULT_NONE : DRIVE_FAULT_GOLDEN;
}

// --- the whole test ------------------------------------------------------------------------------------------------

#define STACK_IN_USE 512u ///< bytes below this frame, for the RAM test itself

drive_fault_t selftest_run(const volatile selftest_seal_t *seal,
                           const uint8_t                  *memory,
                           uint32_t                       *ram,
                           size_t                          ram_bytes_max)
{
    const uintptr_t     stack = (uintptr_t)__builtin_frame_address(0) - STACK_IN_USE;
    const size_t        free  = stack - (uintptr_t)ram;
    const size_t        bytes = free < ram_bytes_max ? free : ram_bytes_max;
    const drive_fault_t image = selftest_image(seal, memory);
    if (image != DRIVE_FAULT_NONE)
    {
        return image;
    }
    const drive_fault_t found = selftest_ram(&selftest_ram_real, ram, bytes / sizeof(uint32_t));
    return found != DRIVE_FAULT_NONE ? found : selftest_golden();
}
