/// The set-up of a drive in lock-step, as the 32-bit words of the message SETUP. The lists below alone define their order.

#ifndef TRIBO_SETUP_H
#define TRIBO_SETUP_H

#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"
#include "tribo/parameters.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/// Do not copy: `loop` points to the sections and the table in the same struct.
typedef struct
{
    uint32_t                       period_us, late_us, budget_us, stuck_ticks; ///< of drive_config_t
    float                          full_scale_n;                               ///< of Q31; f32 ignores it
    tribo_force_loop_f32_config_t  loop;
    uint32_t                       feeds_forward; ///< 1: instead of the paper's method
    tribo_feedforward_f32_config_t feedforward;
    uint32_t                       is_sensorless; ///< 1: and does so without a force sensor
    tribo_sensorless_f32_config_t  sensorless;
    uint32_t                       guarded; ///< 1: with the guard against over-compensation
    tribo_guard_f32_config_t       guard;
    tribo_biquad_f32_section_t     sections[TRIBO_BIQUAD_SECTIONS_MAX];
    tribo_breakaway_point_f32_t    table[TRIBO_BREAKAWAY_POINTS_MAX];
} tribo_setup_t;

/// Every member except the two arrays, which follow them. Each is a float or a uint32_t: the drive's own, and all parameters of the
/// library's list (tribo/parameters.h).
#define TRIBO_SETUP_OWN(FIELD)                                                                                         \
    FIELD(period_us)                                                                                                   \
    FIELD(late_us)                                                                                                     \
    FIELD(budget_us)                                                                                                   \
    FIELD(stuck_ticks)                                                                                                 \
    FIELD(full_scale_n)                                                                                                \
    FIELD(feeds_forward)                                                                                               \
    FIELD(is_sensorless)                                                                                               \
    FIELD(guarded)

#define TRIBO_SETUP_PARAMETERS(ROW)                                                                                    \
    TRIBO_SAMPLE_PARAMETERS(ROW)                                                                                       \
    TRIBO_INPUT_PARAMETERS(ROW)                                                                                        \
    TRIBO_GAIN_PARAMETERS(ROW)                                                                                         \
    TRIBO_LIMIT_PARAMETERS(ROW)                                                                                        \
    TRIBO_CASCADE_PARAMETERS(ROW)                                                                                      \
    TRIBO_FRICTION_PARAMETERS(ROW)                                                                                     \
    TRIBO_BREAKAWAY_PARAMETERS(ROW)                                                                                    \
    TRIBO_TABLE_PARAMETERS(ROW)                                                                                        \
    TRIBO_ARM_PARAMETERS(ROW)                                                                                          \
    TRIBO_FEEDFORWARD_PARAMETERS(ROW)                                                                                  \
    TRIBO_SENSORLESS_PARAMETERS(ROW)                                                                                   \
    TRIBO_GUARD_PARAMETERS(ROW)

// Where the config of a group is in tribo_setup_t.
#define TRIBO_SETUP_SAMPLE      loop
#define TRIBO_SETUP_INPUT       loop
#define TRIBO_SETUP_GAIN        loop
#define TRIBO_SETUP_LIMIT       loop.controller
#define TRIBO_SETUP_CASCADE     loop.controller
#define TRIBO_SETUP_FRICTION    loop.compensator.friction
#define TRIBO_SETUP_BREAKAWAY   loop.compensator.friction
#define TRIBO_SETUP_TABLE       loop.compensator.friction
#define TRIBO_SETUP_ARM         loop.compensator.arm
#define TRIBO_SETUP_FEEDFORWARD feedforward
#define TRIBO_SETUP_SENSORLESS  sensorless
#define TRIBO_SETUP_GUARD       guard

#define TRIBO_SETUP_FIELD_WORDS                                                                                        \
    ((size_t)TRIBO_PARAMETER_COUNT(TRIBO_SETUP_OWN) + (size_t)TRIBO_PARAMETER_COUNT(TRIBO_SETUP_PARAMETERS))
#define TRIBO_SETUP_SECTION_WORDS (sizeof(tribo_biquad_f32_section_t) / sizeof(uint32_t) * TRIBO_BIQUAD_SECTIONS_MAX)
#define TRIBO_SETUP_POINT_WORDS   (sizeof(tribo_breakaway_point_f32_t) / sizeof(uint32_t) * TRIBO_BREAKAWAY_POINTS_MAX)
#define TRIBO_SETUP_WORDS         (TRIBO_SETUP_FIELD_WORDS + TRIBO_SETUP_SECTION_WORDS + TRIBO_SETUP_POINT_WORDS)

/// Copies `loop`, whose controller is sections, with them and its table. Excess ones are dropped here and refused at set-up.
static inline void tribo_setup_take_loop(tribo_setup_t *setup, const tribo_force_loop_f32_config_t *loop)
{
    const tribo_friction_f32_config_t *friction = &loop->compensator.friction;
    setup->loop                                 = *loop;
    for (size_t i = 0; i < loop->controller.section_count && i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        setup->sections[i] = loop->controller.sections[i];
    }
    for (size_t i = 0; friction->table != NULL && i < friction->table_length && i < TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
        setup->table[i] = friction->table[i];
    }
}

static inline void tribo_setup_to_words(const tribo_setup_t *setup, uint32_t words[TRIBO_SETUP_WORDS])
{
#define TRIBO_SETUP_PUT(member)                                                                                        \
    _Static_assert(sizeof setup->member == sizeof(uint32_t), "a word");                                                \
    memcpy(words++, &setup->member, sizeof(uint32_t));
#define TRIBO_SETUP_PUT_ROW(group, symbol, member, ...) TRIBO_SETUP_PUT(TRIBO_SETUP_##group.member)
    TRIBO_SETUP_OWN(TRIBO_SETUP_PUT)
    TRIBO_SETUP_PARAMETERS(TRIBO_SETUP_PUT_ROW)
#undef TRIBO_SETUP_PUT_ROW
#undef TRIBO_SETUP_PUT
    memcpy(words, setup->sections, sizeof setup->sections);
    memcpy(words + TRIBO_SETUP_SECTION_WORDS, setup->table, sizeof setup->table);
}

static inline void tribo_setup_from_words(tribo_setup_t *setup, const uint32_t words[TRIBO_SETUP_WORDS])
{
#define TRIBO_SETUP_GET(member)                         memcpy(&setup->member, words++, sizeof(uint32_t));
#define TRIBO_SETUP_GET_ROW(group, symbol, member, ...) TRIBO_SETUP_GET(TRIBO_SETUP_##group.member)
    TRIBO_SETUP_OWN(TRIBO_SETUP_GET)
    TRIBO_SETUP_PARAMETERS(TRIBO_SETUP_GET_ROW)
#undef TRIBO_SETUP_GET_ROW
#undef TRIBO_SETUP_GET
    memcpy(setup->sections, words, sizeof setup->sections);
    memcpy(setup->table, words + TRIBO_SETUP_SECTION_WORDS, sizeof setup->table);
    tribo_friction_f32_config_t *friction = &setup->loop.compensator.friction;
    setup->loop.controller.sections       = setup->sections;
    setup->loop.controller.pause          = NULL; // of this end only, as are method and guard
    setup->loop.controller.refusal        = NULL;
    friction->refusal                     = NULL;
    setup->loop.pi                        = (tribo_pi_t){0};
    setup->loop.method                    = (tribo_loop_part_t){.config = NULL};
    setup->loop.guard                     = (tribo_loop_guard_t){.part = {.config = NULL}};
    friction->table                       = friction->table_length > 0u ? setup->table : NULL;
}

#endif
