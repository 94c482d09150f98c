/// One tick of the loop as 32-bit words, in the same order for both arithmetics: for the wire, and for the self-test's CRC.
/// Only this list defines their order; a signal is one line.

#ifndef TRIBO_SIGNAL_WORDS_H
#define TRIBO_SIGNAL_WORDS_H

#include "tribo/force_loop_f32.h"
#include "tribo/force_loop_q31.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/// The forces, which follow a first word of flags: name, name in a report, member of tribo_force_loop_f32_signals_t, member of
/// tribo_force_loop_q31_signals_t.
#define TRIBO_SIGNAL_FORCES(FORCE)                                                                                     \
    FORCE(E, "e", e_n, e)                                                                                              \
    FORCE(CONTROLLER, "controller", controller.v_n, controller.v)                                                      \
    FORCE(FEEDFORWARD, "feedforward", friction_term_n, friction_term)                                                  \
    FORCE(U, "u", controller.u_n, controller.u)                                                                        \
    FORCE(F_HAT, "F_hat", compensator.force_n, compensator.force)                                                      \
    FORCE(N, "n", compensator.friction.n_n, compensator.friction.n)                                                    \
    FORCE(L, "L", compensator.friction.L_n, compensator.friction.L)                                                    \
    FORCE(RATE, "v", compensator.friction.v_n_per_s, compensator.friction.rise) /* Q31: the rise in a tick, v h */     \
    FORCE(FRICTION, "f_hat", compensator.friction.f_n, compensator.friction.f)

typedef enum
{
    TRIBO_SIGNAL_FLAGS, ///< bit 0: u is limited; bits 1 to 3: Q1, Q2, Q
#define TRIBO_SIGNAL_PLACE(name, text, f32, q31) TRIBO_SIGNAL_##name,
    TRIBO_SIGNAL_FORCES(TRIBO_SIGNAL_PLACE)
#undef TRIBO_SIGNAL_PLACE
        TRIBO_SIGNAL_WORDS
} tribo_signal_word_t;

#define TRIBO_SIGNAL_LIMITED 1u

static inline uint32_t tribo_signal_flags(bool limited, uint8_t relays)
{
    return (limited ? TRIBO_SIGNAL_LIMITED : 0u) | (uint32_t)relays << 1;
}

static inline uint32_t tribo_signal_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/// Writes forces in N, as the bits of the float.
static inline void tribo_signal_words_f32(const tribo_force_loop_f32_signals_t *signals,
                                          uint32_t                              words[TRIBO_SIGNAL_WORDS])
{
    words[TRIBO_SIGNAL_FLAGS] = tribo_signal_flags(signals->controller.limited, signals->compensator.friction.relays);
#define TRIBO_SIGNAL_PUT(name, text, f32, q31) words[TRIBO_SIGNAL_##name] = tribo_signal_bits(signals->f32);
    TRIBO_SIGNAL_FORCES(TRIBO_SIGNAL_PUT)
#undef TRIBO_SIGNAL_PUT
}

/// Writes forces in Q31 of the full scale.
static inline void tribo_signal_words_q31(const tribo_force_loop_q31_signals_t *signals,
                                          uint32_t                              words[TRIBO_SIGNAL_WORDS])
{
    words[TRIBO_SIGNAL_FLAGS] = tribo_signal_flags(signals->controller.limited, signals->compensator.friction.relays);
#define TRIBO_SIGNAL_PUT(name, text, f32, q31) words[TRIBO_SIGNAL_##name] = (uint32_t)signals->q31;
    TRIBO_SIGNAL_FORCES(TRIBO_SIGNAL_PUT)
#undef TRIBO_SIGNAL_PUT
}

#endif
