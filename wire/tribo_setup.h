/// What a drive in an emulator is set up with, as the 32-bit words of the message SETUP. The list below is the only place
/// that knows their order; a field is one line.

#ifndef TRIBO_SETUP_H
#define TRIBO_SETUP_H

#include "tribo/force_loop_feedforward_f32.h"
#include "tribo/guard_f32.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/// Not to be moved: `loop` points to the sections and to the table beside it.
typedef struct
{
    uint32_t                       period_us, late_us, budget_us, stuck_ticks; ///< of drive_config_t
    float                          full_scale_n;                               ///< of Q31; f32 ignores it
    tribo_force_loop_f32_config_t  loop;
    uint32_t                       feeds_forward; ///< 1: instead of the paper's method
    tribo_feedforward_f32_config_t feedforward;
    uint32_t                       guarded; ///< 1: with the guard against over-compensation
    tribo_guard_f32_config_t       guard;
    tribo_biquad_f32_section_t     sections[TRIBO_BIQUAD_SECTIONS_MAX];
    tribo_breakaway_point_f32_t    table[TRIBO_BREAKAWAY_POINTS_MAX];
} tribo_setup_t;

/// Every member but the two arrays, which follow whole. Each is a float or a uint32_t.
#define TRIBO_SETUP_FIELDS(FIELD)                                                                                      \
    FIELD(period_us)                                                                                                   \
    FIELD(late_us)                                                                                                     \
    FIELD(budget_us)                                                                                                   \
    FIELD(stuck_ticks)                                                                                                 \
    FIELD(full_scale_n)                                                                                                \
    FIELD(loop.sample_time_s)                                                                                          \
    FIELD(loop.input_max_n)                                                                                            \
    FIELD(loop.gain)                                                                                                   \
    FIELD(loop.controller.u_min_n)                                                                                     \
    FIELD(loop.controller.u_max_n)                                                                                     \
    FIELD(loop.controller.section_count)                                                                               \
    FIELD(loop.compensator.friction.k_min)                                                                             \
    FIELD(loop.compensator.friction.k_max)                                                                             \
    FIELD(loop.compensator.friction.m)                                                                                 \
    FIELD(loop.compensator.friction.v0_n_per_s)                                                                        \
    FIELD(loop.compensator.friction.positive.offset_n)                                                                 \
    FIELD(loop.compensator.friction.positive.slope)                                                                    \
    FIELD(loop.compensator.friction.negative.offset_n)                                                                 \
    FIELD(loop.compensator.friction.negative.slope)                                                                    \
    FIELD(loop.compensator.friction.table_length)                                                                      \
    FIELD(loop.compensator.friction.set_level)                                                                         \
    FIELD(loop.compensator.friction.reset_level)                                                                       \
    FIELD(loop.compensator.friction.pulse_width_s)                                                                     \
    FIELD(loop.compensator.friction.gravity_n)                                                                         \
    FIELD(loop.compensator.arm.inertia)                                                                                \
    FIELD(loop.compensator.arm.damping)                                                                                \
    FIELD(loop.compensator.arm.stiffness)                                                                              \
    FIELD(feeds_forward)                                                                                               \
    FIELD(feedforward.actuator_pole_rad_per_s)                                                                         \
    FIELD(feedforward.sensor_pole_rad_per_s)                                                                           \
    FIELD(feedforward.reversal_n)                                                                                      \
    FIELD(feedforward.jump_time_s)                                                                                     \
    FIELD(feedforward.lead)                                                                                            \
    FIELD(feedforward.noise_gain)                                                                                      \
    FIELD(feedforward.noise_time_s)                                                                                    \
    FIELD(feedforward.rate_time_s)                                                                                     \
    FIELD(feedforward.rate_max_n_per_s)                                                                                \
    FIELD(feedforward.offset_time_s)                                                                                   \
    FIELD(feedforward.slide_width_n)                                                                                   \
    FIELD(feedforward.slide_filter_time_s)                                                                             \
    FIELD(feedforward.slide_rate_max_n_per_s)                                                                          \
    FIELD(feedforward.slide_run_in_n)                                                                                  \
    FIELD(feedforward.slide_error_max_n)                                                                               \
    FIELD(feedforward.learning.spread_scale)                                                                           \
    FIELD(feedforward.learning.spread_offset_n)                                                                        \
    FIELD(feedforward.learning.correlation)                                                                            \
    FIELD(feedforward.learning.correlation_faded)                                                                      \
    FIELD(feedforward.learning.trust)                                                                                  \
    FIELD(feedforward.learning.doubt)                                                                                  \
    FIELD(feedforward.learning.weight_n)                                                                               \
    FIELD(feedforward.learning.forgetting_per_n)                                                                       \
    FIELD(feedforward.learning.scale_min)                                                                              \
    FIELD(feedforward.learning.scale_max)                                                                              \
    FIELD(feedforward.hold.gain)                                                                                       \
    FIELD(feedforward.hold.still_time_s)                                                                               \
    FIELD(feedforward.hold.margin)                                                                                     \
    FIELD(feedforward.hold.quick_time_s)                                                                               \
    FIELD(feedforward.hold.caution_travel_n)                                                                           \
    FIELD(feedforward.hold.deadband_time_s)                                                                            \
    FIELD(guarded)                                                                                                     \
    FIELD(guard.turn_n)                                                                                                \
    FIELD(guard.quick_time_s)                                                                                          \
    FIELD(guard.stray_n)                                                                                               \
    FIELD(guard.fade_time_s)

// NOLINTNEXTLINE(bugprone-macro-parentheses): a summand
#define TRIBO_SETUP_ONE(member)   +1u
#define TRIBO_SETUP_FIELD_WORDS   (0u TRIBO_SETUP_FIELDS(TRIBO_SETUP_ONE))
#define TRIBO_SETUP_SECTION_WORDS (sizeof(tribo_biquad_f32_section_t) / sizeof(uint32_t) * TRIBO_BIQUAD_SECTIONS_MAX)
#define TRIBO_SETUP_POINT_WORDS   (sizeof(tribo_breakaway_point_f32_t) / sizeof(uint32_t) * TRIBO_BREAKAWAY_POINTS_MAX)
#define TRIBO_SETUP_WORDS         (TRIBO_SETUP_FIELD_WORDS + TRIBO_SETUP_SECTION_WORDS + TRIBO_SETUP_POINT_WORDS)

/// A copy of `loop`, whose sections and table come along; more of either than fit are left out, and refused at set-up.
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
    setup->loop.compensator.friction.table_length = friction->table != NULL ? friction->table_length : 0u;
}

static inline void tribo_setup_to_words(const tribo_setup_t *setup, uint32_t words[TRIBO_SETUP_WORDS])
{
#define TRIBO_SETUP_PUT(member)                                                                                        \
    _Static_assert(sizeof setup->member == sizeof(uint32_t), #member);                                                 \
    memcpy(words++, &setup->member, sizeof(uint32_t));
    TRIBO_SETUP_FIELDS(TRIBO_SETUP_PUT)
#undef TRIBO_SETUP_PUT
    memcpy(words, setup->sections, sizeof setup->sections);
    memcpy(words + TRIBO_SETUP_SECTION_WORDS, setup->table, sizeof setup->table);
}

static inline void tribo_setup_from_words(tribo_setup_t *setup, const uint32_t words[TRIBO_SETUP_WORDS])
{
#define TRIBO_SETUP_GET(member) memcpy(&setup->member, words++, sizeof(uint32_t));
    TRIBO_SETUP_FIELDS(TRIBO_SETUP_GET)
#undef TRIBO_SETUP_GET
    memcpy(setup->sections, words, sizeof setup->sections);
    memcpy(setup->table, words + TRIBO_SETUP_SECTION_WORDS, sizeof setup->table);
    tribo_friction_f32_config_t *friction = &setup->loop.compensator.friction;
    setup->loop.controller.sections       = setup->sections;
    friction->table                       = friction->table_length > 0u ? setup->table : NULL;
}

#endif
