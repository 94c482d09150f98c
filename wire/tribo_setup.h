/// The set-up of a drive in lock-step, as the 32-bit words of the message SETUP. Only the lists below define their order.

#ifndef TRIBO_SETUP_H
#define TRIBO_SETUP_H

#include "tribo/parameters.h"
#include "tribo_loop_parts.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef struct
{
    uint32_t                    period_us, late_us, budget_us, stuck_ticks; ///< members of drive_config_t
    float                       full_scale_n;                               ///< force of 2^31 in Q31; f32 ignores it
    tribo_loop_parts_t          loop;
    tribo_biquad_f32_section_t  sections[TRIBO_BIQUAD_SECTIONS_MAX]; ///< `loop` points to these on the receiving side
    tribo_breakaway_point_f32_t table[TRIBO_BREAKAWAY_POINTS_MAX];
} tribo_setup_t;

/// Every member; the arrays to which the config points follow. The drive's own members, and all parameters of the library's list
/// (tribo/parameters.h), are a float or a uint32_t each.
#define TRIBO_SETUP_OWN(FIELD)                                                                                         \
    FIELD(period_us)                                                                                                   \
    FIELD(late_us)                                                                                                     \
    FIELD(budget_us)                                                                                                   \
    FIELD(stuck_ticks)                                                                                                 \
    FIELD(full_scale_n)

/// Members that are 0 or 1.
#define TRIBO_SETUP_FLAGS(FLAG)                                                                                        \
    FLAG(loop.feeds_forward)                                                                                           \
    FLAG(loop.is_sensorless)                                                                                           \
    FLAG(loop.guarded)

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

// The member of tribo_setup_t that holds the config of a group.
#define TRIBO_SETUP_SAMPLE      loop.config
#define TRIBO_SETUP_INPUT       loop.config
#define TRIBO_SETUP_GAIN        loop.config
#define TRIBO_SETUP_LIMIT       loop.config.controller
#define TRIBO_SETUP_CASCADE     loop.config.controller
#define TRIBO_SETUP_FRICTION    loop.config.compensator.friction
#define TRIBO_SETUP_BREAKAWAY   loop.config.compensator.friction
#define TRIBO_SETUP_TABLE       loop.config.compensator.friction
#define TRIBO_SETUP_ARM         loop.config.compensator.arm
#define TRIBO_SETUP_FEEDFORWARD loop.feedforward
#define TRIBO_SETUP_SENSORLESS  loop.sensorless
#define TRIBO_SETUP_GUARD       loop.guard

#define TRIBO_SETUP_FIELD_WORDS                                                                                        \
    ((size_t)TRIBO_PARAMETER_COUNT(TRIBO_SETUP_OWN) + (size_t)TRIBO_PARAMETER_COUNT(TRIBO_SETUP_FLAGS) +               \
     (size_t)TRIBO_PARAMETER_COUNT(TRIBO_SETUP_PARAMETERS))
#define TRIBO_SETUP_SECTION_WORDS (sizeof(tribo_biquad_f32_section_t) / sizeof(uint32_t) * TRIBO_BIQUAD_SECTIONS_MAX)
#define TRIBO_SETUP_POINT_WORDS   (sizeof(tribo_breakaway_point_f32_t) / sizeof(uint32_t) * TRIBO_BREAKAWAY_POINTS_MAX)
#define TRIBO_SETUP_WORDS         (TRIBO_SETUP_FIELD_WORDS + TRIBO_SETUP_SECTION_WORDS + TRIBO_SETUP_POINT_WORDS)

/// Writes a setup as words. Sections and points beyond those that fit are left out, and refused at set-up.
static inline void tribo_setup_to_words(const tribo_setup_t *setup, uint32_t words[TRIBO_SETUP_WORDS])
{
    const tribo_controller_f32_config_t *controller = &setup->loop.config.controller;
    const tribo_friction_f32_config_t   *friction   = &setup->loop.config.compensator.friction;
    memset(words, 0, TRIBO_SETUP_WORDS * sizeof *words);
#define TRIBO_SETUP_PUT(member)                                                                                        \
    _Static_assert(sizeof setup->member == sizeof(uint32_t), "a word");                                                \
    memcpy(words++, &setup->member, sizeof(uint32_t));
#define TRIBO_SETUP_PUT_FLAG(member)                    *words++ = setup->member ? 1u : 0u;
#define TRIBO_SETUP_PUT_ROW(group, symbol, member, ...) TRIBO_SETUP_PUT(TRIBO_SETUP_##group.member)
    TRIBO_SETUP_OWN(TRIBO_SETUP_PUT)
    TRIBO_SETUP_FLAGS(TRIBO_SETUP_PUT_FLAG)
    TRIBO_SETUP_PARAMETERS(TRIBO_SETUP_PUT_ROW)
#undef TRIBO_SETUP_PUT_ROW
#undef TRIBO_SETUP_PUT_FLAG
#undef TRIBO_SETUP_PUT
    for (size_t i = 0; i < controller->section_count && i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        memcpy(words + 5u * i, &controller->sections[i], sizeof controller->sections[i]);
    }
    words += TRIBO_SETUP_SECTION_WORDS;
    for (size_t i = 0; friction->table != NULL && i < friction->table_length && i < TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
        memcpy(words + 3u * i, &friction->table[i], sizeof friction->table[i]);
    }
}

/// Reads a setup from words. It must not move afterwards, because it points to its own sections and table.
static inline void tribo_setup_from_words(tribo_setup_t *setup, const uint32_t words[TRIBO_SETUP_WORDS])
{
    tribo_loop_parts_t *loop = &setup->loop;
#define TRIBO_SETUP_GET(member)                         memcpy(&setup->member, words++, sizeof(uint32_t));
#define TRIBO_SETUP_GET_FLAG(member)                    setup->member = *words++ != 0u;
#define TRIBO_SETUP_GET_ROW(group, symbol, member, ...) TRIBO_SETUP_GET(TRIBO_SETUP_##group.member)
    TRIBO_SETUP_OWN(TRIBO_SETUP_GET)
    TRIBO_SETUP_FLAGS(TRIBO_SETUP_GET_FLAG)
    TRIBO_SETUP_PARAMETERS(TRIBO_SETUP_GET_ROW)
#undef TRIBO_SETUP_GET_ROW
#undef TRIBO_SETUP_GET_FLAG
#undef TRIBO_SETUP_GET
    memcpy(setup->sections, words, sizeof setup->sections);
    memcpy(setup->table, words + TRIBO_SETUP_SECTION_WORDS, sizeof setup->table);
    tribo_friction_f32_config_t *friction = &loop->config.compensator.friction;
    loop->config.controller.sections      = setup->sections;
    loop->config.controller.pause         = NULL; // a pointer of the other side, like refusal, method and guard
    loop->config.controller.refusal       = NULL;
    friction->refusal                     = NULL;
    loop->config.pi                       = (tribo_pi_t){0};
    loop->config.method                   = (tribo_loop_part_t){.config = NULL};
    loop->config.guard                    = (tribo_loop_guard_t){.part = {.config = NULL}};
    friction->table                       = friction->table_length > 0u ? setup->table : NULL;
}

#endif
