/// Names the library in one arithmetic by names that both share: Q31 if TRIBO_ARITHMETIC_Q31 is defined, otherwise single
/// precision. For sources that are compiled once for each.
///
///     TRIBO(force_loop, step)   tribo_force_loop_f32_step or tribo_force_loop_q31_step
///     TRIBO_N(input_max)        a force in a struct: input_max_n or input_max
///     tribo_force_t             a force: float in N, or int32_t in Q31 of the full scale
///     TRIBO_ALL                 all of the friction compensation, as a guard's fade
///
/// Functions take the full scale in both arithmetics; single precision ignores it. Freestanding C.

#ifndef TRIBO_ARITHMETIC_H
#define TRIBO_ARITHMETIC_H

#include "tribo_loop_parts.h"
#include "tribo_signal_words.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef TRIBO_ARITHMETIC_Q31

#include "tribo/feedforward_q31.h"
#include "tribo/force_loop_q31.h"

#define TRIBO_ARITHMETIC       "q31"
#define TRIBO_IS_Q31           1
#define TRIBO(noun, verb)      tribo_##noun##_q31_##verb
#define TRIBO_PART(noun, verb) noun##_q31_##verb // a function inside the library
#define TRIBO_N(field)         field
#define TRIBO_ALL              UINT32_MAX
#define TRIBO_EITHER(f32, q31) (q31)

typedef int32_t                     tribo_force_t;
typedef tribo_breakaway_point_q31_t tribo_point_t;

#else

#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"

#define TRIBO_ARITHMETIC       "f32"
#define TRIBO_IS_Q31           0
#define TRIBO(noun, verb)      tribo_##noun##_f32_##verb
#define TRIBO_PART(noun, verb) noun##_f32_##verb // a function inside the library
#define TRIBO_N(field)         field##_n
#define TRIBO_ALL              1.0f
#define TRIBO_EITHER(f32, q31) (f32)

typedef float                       tribo_force_t;
typedef tribo_breakaway_point_f32_t tribo_point_t;

#endif

// --- forces --------------------------------------------------------------------------------------------------------

/// Converts a force to its bits, for telemetry and checksums, and back.
static inline uint32_t tribo_force_word(tribo_force_t x)
{
    uint32_t word;
    memcpy(&word, &x, sizeof word);
    return word;
}

static inline tribo_force_t tribo_force_of_word(uint32_t word)
{
    tribo_force_t x;
    memcpy(&x, &word, sizeof x);
    return x;
}

/// Converts a Q31 fraction of the full scale to a force, and back, saturated; not for a NaN. In Q31 the fraction is the
/// force itself.
static inline tribo_force_t tribo_force_of_q31(int32_t x, float full_scale_n)
{
    (void)full_scale_n;
    return TRIBO_EITHER((float)x * (full_scale_n * (1.0f / 2147483648.0f)), x);
}

static inline int32_t tribo_force_q31(tribo_force_t x, float full_scale_n)
{
#ifdef TRIBO_ARITHMETIC_Q31
    (void)full_scale_n;
    return x;
#else
    const float scaled = x / full_scale_n * 2147483648.0f;
    return scaled >= 2147483648.0f ? INT32_MAX : scaled <= -2147483648.0f ? INT32_MIN : (int32_t)scaled;
#endif
}

/// Converts N to Q31, to the nearest bit, and back, for a host. A force beyond full scale becomes INT32_MAX or -INT32_MAX,
/// and a NaN INT32_MIN, which a loop takes as bad inputs. Full scale itself becomes the number next to the limit.
static inline int32_t tribo_q31_of_n(double force_n, double full_scale_n)
{
    const float force =
        (float)force_n; // full scale is a float in the library, so a force that equals it as a float is within
    const float  full = (float)full_scale_n;
    const double most = 2147483646.0;
    if (!(force >= -full && force <= full))
    {
        return force > full ? INT32_MAX : force < -full ? -INT32_MAX : INT32_MIN;
    }
    const double  x         = force_n / full_scale_n * 2147483648.0;
    const double  limited   = x > most ? most : x < -most ? -most : x;
    const int32_t truncated = (int32_t)limited;
    const double  rest      = limited - truncated;
    return truncated + (rest >= 0.5) - (rest <= -0.5);
}

static inline double tribo_n_of_q31(int32_t x, double full_scale_n)
{
    return x / 2147483648.0 * full_scale_n;
}

static inline tribo_force_t tribo_force_of_n(double force_n, double full_scale_n)
{
    (void)full_scale_n;
    return TRIBO_EITHER((float)force_n, tribo_q31_of_n(force_n, full_scale_n));
}

static inline double tribo_force_n(tribo_force_t x, double full_scale_n)
{
    (void)full_scale_n;
    return TRIBO_EITHER((double)x, tribo_n_of_q31(x, full_scale_n));
}

/// Returns whether x is NaN; always false in Q31.
static inline bool tribo_force_is_nan(tribo_force_t x)
{
    (void)x;
    return TRIBO_EITHER((tribo_force_word(x) & 0x7fffffffu) > 0x7f800000u, false);
}

/// Returns whether the loop accepts x as a reference or reading; false for a NaN.
static inline bool tribo_force_is_credible(const TRIBO(force_loop, params_t) * params, tribo_force_t x)
{
    const tribo_force_t most = params->TRIBO_N(input_max);
    return TRIBO_EITHER((tribo_force_word(x) & 0x7fffffffu) <= tribo_force_word(most), x >= -most && x <= most);
}

/// Writes a tick's signals in the order of tribo_signal_words.h.
static inline void tribo_signal_words(const TRIBO(force_loop, signals_t) * signals, uint32_t words[TRIBO_SIGNAL_WORDS])
{
    TRIBO_EITHER(tribo_signal_words_f32, tribo_signal_words_q31)(signals, words);
}

// --- init functions ------------------------------------------------------------------------------------------------

/// Returns the library's config, which names the method and the guard of `loop`. The library's init function then makes them in
/// `feedforward` and `guard`.
static inline tribo_force_loop_f32_config_t tribo_loop_with_parts(const tribo_loop_parts_t *loop,
                                                                  TRIBO(feedforward, params_t) * feedforward,
                                                                  TRIBO(guard, params_t) * guard)
{
    tribo_force_loop_f32_config_t config = loop->config;
    if (loop->is_sensorless)
    {
        config.method = TRIBO(sensorless, use)(feedforward, &loop->feedforward, &loop->sensorless);
    }
    else if (loop->feeds_forward)
    {
        config.method = TRIBO(feedforward, use)(feedforward, &loop->feedforward);
    }
    if (loop->guarded)
    {
        config.guard = TRIBO(guard, use)(guard, &loop->guard);
    }
    return config;
}

/// Calls the library's init function and returns its status. In Q31 `table` holds the breakaway points; null for a config without
/// them. In single precision it is not used, and params point to the table of the config.
static inline tribo_status_t tribo_init_loop(TRIBO(force_loop, params_t) * params,
                                             tribo_point_t                       *table,
                                             const tribo_force_loop_f32_config_t *config,
                                             float                                full_scale_n)
{
#ifdef TRIBO_ARITHMETIC_Q31
    const tribo_force_loop_q31_config_t q31 = {.loop = *config, .full_scale_n = full_scale_n, .table = table};
    return tribo_force_loop_q31_init(params, &q31);
#else
    (void)table;
    (void)full_scale_n;
    return tribo_force_loop_f32_init(params, config);
#endif
}

#endif
