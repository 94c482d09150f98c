/// All parameters of a drive that need no rebuild, as one set: its config (config.h), and that of the loop in physical units and
/// single precision. A set consists of 32-bit words, so that a bus or a store need not know its fields. It is checked as a whole.

#ifndef DRIVE_PARAMS_H
#define DRIVE_PARAMS_H

#include "app/drive.h"
#include "app/loop.h"

#include "tribo/parameters.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

// The loop's parameters are those of tribo/parameters.h that have a register. They form three blocks of Modbus registers, two
// registers a word.
#define PARAMS_LOOP_NUMBER  0x100u
#define PARAMS_FEED_NUMBER  0x200u
#define PARAMS_GUARD_NUMBER 0x2e0u ///< number of guard.on; the guard's parameters follow it

// clang-format off: one list a line
#define PARAMS_LOOP_ROWS(ROW) \
    TRIBO_SAMPLE_PARAMETERS(ROW) \
    TRIBO_INPUT_PARAMETERS(ROW) \
    TRIBO_LIMIT_PARAMETERS(ROW) \
    TRIBO_GAIN_PARAMETERS(ROW) \
    TRIBO_FRICTION_PARAMETERS(ROW) \
    TRIBO_BREAKAWAY_PARAMETERS(ROW) \
    TRIBO_ARM_PARAMETERS(ROW) \
    TRIBO_CASCADE_PARAMETERS(ROW) \
    TRIBO_TABLE_PARAMETERS(ROW)

/// Parameters of a loop whose compensator.method is 1 or 3, and of its guard. A drive without the feed-forward has none.
#if DRIVE_FEEDFORWARD
#define PARAMS_FEED_ROWS(ROW) \
    TRIBO_FEEDFORWARD_PARAMETERS(ROW) \
    TRIBO_SENSORLESS_PARAMETERS(ROW)
#define PARAMS_GUARD_ROWS(ROW) TRIBO_GUARD_PARAMETERS(ROW)
#else
#define PARAMS_FEED_ROWS(ROW)
#define PARAMS_GUARD_ROWS(ROW)
#endif
// clang-format on

enum
{
    PARAMS_LOOP_COUNT  = TRIBO_PARAMETER_COUNT(PARAMS_LOOP_ROWS),
    PARAMS_FEED_COUNT  = TRIBO_PARAMETER_COUNT(PARAMS_FEED_ROWS),
    PARAMS_GUARD_COUNT = TRIBO_PARAMETER_COUNT(PARAMS_GUARD_ROWS) + (DRIVE_FEEDFORWARD ? 1 : 0) ///< including guard.on
};

#define PARAMS_GUARD_TEXT "1: friction compensation that makes the loop hunt or overshoot is faded until it is restored"

#define PARAMS_METHOD_PAPER       0u ///< fed back with compensator.gain; a gain of 0 turns it off
#define PARAMS_METHOD_FEEDFORWARD 1u
#define PARAMS_METHOD_OFF         2u // needs an image with the feed-forward; elsewhere use a gain of 0
#define PARAMS_METHOD_SENSORLESS  3u
#define PARAMS_METHOD_MAX         (DRIVE_FEEDFORWARD ? PARAMS_METHOD_SENSORLESS : PARAMS_METHOD_PAPER)
#define PARAMS_METHOD_TEXT                                                                                             \
    "how friction is compensated: 0: fed back with compensator.gain, as in the paper; 1: fed forward; 2: off; 3: fed " \
    "forward without a force sensor, only on boards that have none"

/// The words of a set, in this order.
typedef struct
{
    drive_config_t drive;
    uint32_t       loop[PARAMS_LOOP_COUNT]; ///< floats except for the two counts, in the order of their registers
    uint32_t       method;                  ///< PARAMS_METHOD_: how friction is compensated
#if DRIVE_FEEDFORWARD
    uint32_t feed[PARAMS_FEED_COUNT];
    uint32_t guard_on; ///< 1: there is a guard
    uint32_t guard[PARAMS_GUARD_COUNT - 1];
#endif
    tribo_biquad_f32_section_t  sections[TRIBO_BIQUAD_SECTIONS_MAX];
    tribo_breakaway_point_f32_t table[TRIBO_BREAKAWAY_POINTS_MAX];
} params_set_t;

enum
{
    PARAMS_LOOP_AT     = DRIVE_CONFIG_COUNT, ///< number of a word in the set
    PARAMS_METHOD_AT   = PARAMS_LOOP_AT + PARAMS_LOOP_COUNT,
    PARAMS_FEED_AT     = PARAMS_METHOD_AT + 1,
    PARAMS_GUARD_AT    = PARAMS_FEED_AT + PARAMS_FEED_COUNT,
    PARAMS_SECTIONS_AT = PARAMS_GUARD_AT + PARAMS_GUARD_COUNT,
    PARAMS_TABLE_AT    = PARAMS_SECTIONS_AT + 5 * (int)TRIBO_BIQUAD_SECTIONS_MAX,
    PARAMS_WORDS       = PARAMS_TABLE_AT + 3 * (int)TRIBO_BREAKAWAY_POINTS_MAX
};

_Static_assert(sizeof(params_set_t) == PARAMS_WORDS * sizeof(uint32_t), "a set is words without gaps");

/// The word that has a register's number.
#define PARAMS_WORD(number)                                                                                            \
    ((number) >= PARAMS_GUARD_NUMBER  ? PARAMS_GUARD_AT + ((number) - PARAMS_GUARD_NUMBER) / 2u                        \
     : (number) >= PARAMS_FEED_NUMBER ? PARAMS_FEED_AT + ((number) - PARAMS_FEED_NUMBER) / 2u                          \
                                      : PARAMS_LOOP_AT + ((number) - PARAMS_LOOP_NUMBER) / 2u)

/// PARAMS_<symbol> is the word of each parameter.
enum
{
#define PARAMS_PLACE(group, symbol, member, key, unit, low, high, standard, change, number, condition, sentence)       \
    PARAMS_##symbol = PARAMS_WORD(number),
    PARAMS_LOOP_ROWS(PARAMS_PLACE) PARAMS_FEED_ROWS(PARAMS_PLACE) PARAMS_GUARD_ROWS(PARAMS_PLACE)
#undef PARAMS_PLACE
};

/// Why a set is refused: the word of the field to change, its value and the range that is allowed.
typedef struct
{
    uint32_t       word;
    float          value, low, high;
    tribo_status_t status; ///< of the library; says more than the range if fields depend on each other
} params_error_t;

/// A set, and the params made from it with which a drive runs. Must not move once made.
typedef struct
{
    union
    {
        params_set_t set;
        uint32_t     words[PARAMS_WORDS];
    };
    loop_setup_t  loop;
    drive_setup_t drive;
} params_t;

/// The widest range that a board allows to a word of a set, for any client. 0, which turns a check off, is allowed only if it is
/// within the range.
typedef struct
{
    uint16_t word; ///< a word of drive_config_t, or a float of the loop
    float    low, high;
} params_ceiling_t;

/// Returns the default of every field: the paper's rig, with friction fed forward and the guard on if the image has them.
/// params_default_of takes the drive's fields from `config`, and its poles for the feed-forward as well.
params_set_t params_default(void);
params_set_t params_default_of(const drive_config_t *config);

/// Returns a word of a set, as bits or as a float.
uint32_t params_word(const params_set_t *set, uint32_t word);
float    params_number(const params_set_t *set, uint32_t word);

/// Returns whether a word of a set is a float.
bool params_is_number(uint32_t word);

#define PARAMS_LEAST_N                                                                                                 \
    1e-9f ///< smallest force other than 0 that a client may request; no parameter needs a smaller one

/// Returns the smallest size other than 0 of a word of a set. No range begins nearer to 0, and no coefficient of slow poles
/// at a high rate is smaller.
float params_least(uint32_t word);

#define PARAMS_MOST_N 1e6f ///< largest force that a client may request: the limit of all ranges of forces

/// Returns whether the bits of a float are a number that a client can mean: finite, and 0 or at least `least` in size.
/// Swapped words or bytes often make a tiny number.
static inline bool params_is_meant(uint32_t bits, float least)
{
    const uint32_t size = bits & 0x7fffffffu;
    uint32_t       bits_of_least;
    memcpy(&bits_of_least, &least, sizeof bits_of_least);
    return size == 0u || (size >= bits_of_least && size < 0x7f800000u);
}

/// Copies a loop into the set, with the sections and the table that its config points to. The poles of a feed-forward become the
/// drive's as well. Parameters of a method or a guard that `loop` does not have stay as they are.
void params_take_loop(params_set_t *set, const tribo_loop_parts_t *loop);

/// Makes params from params->set, which the library and the drive check as a whole. Returns false and fills `error` for the first
/// field that is refused; do not use `params` then. Not for the tick.
bool params_make(params_t *params, const port_t *port, params_error_t *error);

/// Returns true if all words are within the ceilings; otherwise false, with `error` for the first that is not.
bool params_check_ceilings(const params_set_t     *set,
                           const params_ceiling_t *ceilings,
                           uint32_t                count,
                           params_error_t         *error);

/// Returns true if the method uses a force sensor exactly if that of the board's own set does, so that no client turns a sensor's
/// checks off; otherwise false, with `error`.
bool params_check_method(const params_set_t *set, const params_set_t *of_board, params_error_t *error);

/// Returns true if all WIRED words (config.h) are those of the board's own set, because no bus may change them; otherwise false,
/// with `error` for the first that is not.
bool params_check_wiring(const params_set_t *set, const params_set_t *of_board, params_error_t *error);

/// Iterates over the words that protect: all of config.h, and limits, scaling and arm of the loop (PROTECTS in
/// tribo/parameters.h), in the order of their registers. Returns the next word and moves `place`, which begins at 0. Returns
/// PARAMS_WORDS after the last.
uint32_t params_next_protecting(uint32_t *place);

/// Returns the CRC-32 of these words and of the two signs of the controller's gain, -1, 0 or 1, each as four bytes with the
/// low byte first.
uint32_t params_protection(const params_set_t *set);

/// Returns true if all words that protect, and the signs of the controller's gain, are those of `like`; otherwise false,
/// with `error` for the first that is not. params_signs_alike compares only the signs.
bool params_protect_alike(const params_set_t *set, const params_set_t *like, params_error_t *error);
bool params_signs_alike(const params_set_t *set, const params_set_t *like, params_error_t *error);

/// A number that changes with the meaning of a set's words. The library's list contributes only its number of rows, because its
/// registers never move. OWN is the CRC-32 of all other names; an image holds no names, so test_registers.c computes it. METHOD
/// counts the versions of the feed-forward that gave the same numbers another meaning.
#define PARAMS_LAYOUT_METHOD 2u
#define PARAMS_LAYOUT_OWN    0x6a69fbd8u
#define PARAMS_LAYOUT_ROWS                                                                                             \
    (PARAMS_LOOP_COUNT + TRIBO_PARAMETER_COUNT(TRIBO_FEEDFORWARD_PARAMETERS) +                                         \
     TRIBO_PARAMETER_COUNT(TRIBO_SENSORLESS_PARAMETERS) + TRIBO_PARAMETER_COUNT(TRIBO_GUARD_PARAMETERS))
#define PARAMS_LAYOUT_OF(feeds_forward)                                                                                \
    (PARAMS_LAYOUT_OWN + (PARAMS_LAYOUT_METHOD << 16) + 2u * (uint32_t)(PARAMS_LAYOUT_ROWS) -                          \
     ((feeds_forward) ? 0u : 1u))
#define PARAMS_LAYOUT PARAMS_LAYOUT_OF(DRIVE_FEEDFORWARD)

#endif
