// Runs of floats that stand side by side, read and written at once: gcc takes an instruction for each.

#ifndef TRIBO_RUN_F32_H
#define TRIBO_RUN_F32_H

#include "tribo/biquad_f32.h"

#include "pair.h"

/// The states of a pair of sections.
typedef struct
{
    tribo_biquad_f32_section_state_t section[2];
} run_f32_pair_t;

_Static_assert(sizeof(tribo_biquad_f32_section_t) == 5u * sizeof(float), "five floats in a row");
_Static_assert(sizeof(tribo_biquad_f32_section_state_t) == 3u * sizeof(float), "three floats in a row");

#if defined(TRIBO_THUMB2) && defined(__ARM_FP)

// The registers are those with which gcc 12 copies least. Variables around theirs: nothing that a sanitizer makes a call of
// may come between those.

/// The coefficients at `*at`, which goes on to the next.
#define RUN_F32_SECTION(name, r0, r1, r2, r3, r4)                                                                      \
    static inline tribo_biquad_f32_section_t name(const tribo_biquad_f32_section_t **at)                               \
    {                                                                                                                  \
        const tribo_biquad_f32_section_t *next = *at;                                                                  \
        register float                    s_b0 __asm__(r0);                                                            \
        register float                    s_b1 __asm__(r1);                                                            \
        register float                    s_b2 __asm__(r2);                                                            \
        register float                    s_a1 __asm__(r3);                                                            \
        register float                    s_a2 __asm__(r4);                                                            \
        __asm__("vldmia %5!, {%0-%4}"                                                                                  \
                : "=t"(s_b0), "=t"(s_b1), "=t"(s_b2), "=t"(s_a1), "=t"(s_a2), "+r"(next)                               \
                : "m"(*next));                                                                                         \
        const float b0 = s_b0;                                                                                         \
        const float b1 = s_b1;                                                                                         \
        const float b2 = s_b2;                                                                                         \
        const float a1 = s_a1;                                                                                         \
        const float a2 = s_a2;                                                                                         \
        *at            = next;                                                                                         \
        return (tribo_biquad_f32_section_t){.b0 = b0, .b1 = b1, .b2 = b2, .a1 = a1, .a2 = a2};                         \
    }

RUN_F32_SECTION(run_f32_first, "s2", "s3", "s4", "s5", "s6")
RUN_F32_SECTION(run_f32_last, "s0", "s1", "s2", "s3", "s4")

static inline run_f32_pair_t run_f32_pair(const tribo_biquad_f32_state_t *state)
{
    register float s8 __asm__("s8");
    register float s9 __asm__("s9");
    register float s10 __asm__("s10");
    register float s11 __asm__("s11");
    register float s12 __asm__("s12");
    register float s13 __asm__("s13");
    __asm__("vldmia %6, {%0-%5}"
            : "=t"(s8), "=t"(s9), "=t"(s10), "=t"(s11), "=t"(s12), "=t"(s13)
            : "r"(state->section), "m"(state->section[0]), "m"(state->section[1]));
    const float w1_0    = s8;
    const float w2_0    = s9;
    const float carry_0 = s10;
    const float w1_1    = s11;
    const float w2_1    = s12;
    const float carry_1 = s13;
    return (run_f32_pair_t){{{w1_0, w2_0, carry_0}, {w1_1, w2_1, carry_1}}};
}

static inline void run_f32_keep_pair(tribo_biquad_f32_state_t *state, run_f32_pair_t pair)
{
    const float    w1_0               = pair.section[0].w1;
    const float    w2_0               = pair.section[0].w2;
    const float    carry_0            = pair.section[0].w2_carry;
    const float    w1_1               = pair.section[1].w1;
    const float    w2_1               = pair.section[1].w2;
    const float    carry_1            = pair.section[1].w2_carry;
    register float s5 __asm__("s5")   = w1_0;
    register float s6 __asm__("s6")   = w2_0;
    register float s7 __asm__("s7")   = carry_0;
    register float s8 __asm__("s8")   = w1_1;
    register float s9 __asm__("s9")   = w2_1;
    register float s10 __asm__("s10") = carry_1;
    __asm__("vstmia %2, {%3-%8}"
            : "=m"(state->section[0]), "=m"(state->section[1])
            : "r"(state->section), "t"(s5), "t"(s6), "t"(s7), "t"(s8), "t"(s9), "t"(s10));
}

#else

static inline tribo_biquad_f32_section_t run_f32_first(const tribo_biquad_f32_section_t **at)
{
    return *(*at)++;
}

static inline tribo_biquad_f32_section_t run_f32_last(const tribo_biquad_f32_section_t **at)
{
    return *(*at)++;
}

static inline run_f32_pair_t run_f32_pair(const tribo_biquad_f32_state_t *state)
{
    return (run_f32_pair_t){{state->section[0], state->section[1]}};
}

static inline void run_f32_keep_pair(tribo_biquad_f32_state_t *state, run_f32_pair_t pair)
{
    state->section[0] = pair.section[0];
    state->section[1] = pair.section[1];
}

#endif

#endif
