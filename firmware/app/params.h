/// All that a drive can be told without a rebuild, as one set: its config (config.h), and the loop's in physical units and
/// single precision. A set is 32-bit words, so that a bus or a store needs no notion of its fields, and is checked as a whole.

#ifndef DRIVE_PARAMS_H
#define DRIVE_PARAMS_H

#include "app/drive.h"
#include "app/loop.h"

#include "tribo/parameters.h"
#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

// The loop's parameters are those of tribo/parameters.h that have a register: in three blocks of Modbus registers, of two a word.
#define PARAMS_LOOP_NUMBER  0x100u
#define PARAMS_FEED_NUMBER  0x200u
#define PARAMS_GUARD_NUMBER 0x2e0u ///< of guard.on, which the guard's parameters follow

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

/// Of a loop whose compensator.method is 1 or 3, and its guard's. None in a drive without it.
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
    PARAMS_GUARD_COUNT = TRIBO_PARAMETER_COUNT(PARAMS_GUARD_ROWS) + (DRIVE_FEEDFORWARD ? 1 : 0) ///< with guard.on
};

#define PARAMS_GUARD_TEXT                                                                                              \
    "1: friction compensation that makes the loop hunt or overshoot is faded, until it is restored"

#define PARAMS_METHOD_PAPER       0u ///< fed back with compensator.gain; 0 turns it off
#define PARAMS_METHOD_FEEDFORWARD 1u
#define PARAMS_METHOD_OFF         2u // without the feed-forward: a gain of 0
#define PARAMS_METHOD_SENSORLESS  3u
#define PARAMS_METHOD_MAX         (DRIVE_FEEDFORWARD ? PARAMS_METHOD_SENSORLESS : PARAMS_METHOD_PAPER)
#define PARAMS_METHOD_TEXT                                                                                             \
    "0: fed back with compensator.gain, as the paper does; 1: fed forward; 2: off; 3: fed forward without a force "    \
    "sensor, in a board that has none and there alone"

/// Words in this order.
typedef struct
{
    drive_config_t drive;
    uint32_t       loop[PARAMS_LOOP_COUNT]; ///< floats but for the two counts, by register
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
    PARAMS_LOOP_AT     = DRIVE_CONFIG_COUNT, ///< word of the set
    PARAMS_METHOD_AT   = PARAMS_LOOP_AT + PARAMS_LOOP_COUNT,
    PARAMS_FEED_AT     = PARAMS_METHOD_AT + 1,
    PARAMS_GUARD_AT    = PARAMS_FEED_AT + PARAMS_FEED_COUNT,
    PARAMS_SECTIONS_AT = PARAMS_GUARD_AT + PARAMS_GUARD_COUNT,
    PARAMS_TABLE_AT    = PARAMS_SECTIONS_AT + 5 * (int)TRIBO_BIQUAD_SECTIONS_MAX,
    PARAMS_WORDS       = PARAMS_TABLE_AT + 3 * (int)TRIBO_BREAKAWAY_POINTS_MAX
};

_Static_assert(sizeof(params_set_t) == PARAMS_WORDS * sizeof(uint32_t), "a set is words without gaps");

/// The word of a register's number.
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
    tribo_status_t status; ///< of the library, which says more than the range where fields depend on each other
} params_error_t;

/// A set and what a drive runs with. Not to be moved once made.
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

/// The widest that a board lets a word of a set be, whoever asks. 0 turns a check off and is allowed only if it is within.
typedef struct
{
    uint16_t word; ///< of drive_config_t, or of a float of the loop
    float    low, high;
} params_ceiling_t;

/// The default of every field: the paper's rig, with friction fed forward and the guard on where the drive has them. With
/// `config` for the drive's, whose poles are the feed-forward's, too.
params_set_t params_default(void);
params_set_t params_default_of(const drive_config_t *config);

/// A word of a set; params_number: of a float.
uint32_t params_word(const params_set_t *set, uint32_t word);
float    params_number(const params_set_t *set, uint32_t word);

/// Whether a word of a set is a float.
bool params_is_number(uint32_t word);

#define PARAMS_LEAST_N 1e-9f ///< of a force that a client asks for, the smallest that any parameter can be about

/// Likewise of a word of a set: no range begins nearer to 0, and no coefficient of slow poles at a high rate is smaller.
float params_least(uint32_t word);

#define PARAMS_MOST_N 1e6f ///< of a force that a client asks for: the end of all ranges of forces

/// Whether the bits of a float are a number that somebody can mean: 0, or at least `least` in size, and finite. Words or bytes in
/// another order often make a tiny one.
static inline bool params_is_meant(uint32_t bits, float least)
{
    const uint32_t size = bits & 0x7fffffffu;
    uint32_t       bits_of_least;
    memcpy(&bits_of_least, &least, sizeof bits_of_least);
    return size == 0u || (size >= bits_of_least && size < 0x7f800000u);
}

/// Takes over what `config` says of the loop, with its sections and its table, and `feedforward`, whose poles are the drive's, too;
/// null: the paper's method. `sensorless`: its feed-forward has no force sensor; null: it has.
void params_take_loop(params_set_t                         *set,
                      const tribo_force_loop_f32_config_t  *config,
                      const tribo_feedforward_f32_config_t *feedforward,
                      const tribo_sensorless_f32_config_t  *sensorless);

#if DRIVE_FEEDFORWARD
/// The guard of `config`; null: none.
void params_take_guard(params_set_t *set, const tribo_guard_f32_config_t *config);
#endif

/// Makes params of params->set, checked as a whole by the library and by the drive. False with `error` for the first field
/// that is refused: then `params` are not to be used. Not for the tick.
bool params_make(params_t *params, const port_t *port, params_error_t *error);

/// Whether no ceiling is exceeded; false with `error` for the first that is.
bool params_check_ceilings(const params_set_t     *set,
                           const params_ceiling_t *ceilings,
                           uint32_t                count,
                           params_error_t         *error);

/// Whether the method goes with the board's force sensor, or with none, as its own set has it: no client turns a sensor's checks off.
/// False with `error` if not.
bool params_check_method(const params_set_t *set, const params_set_t *of_board, params_error_t *error);

/// Whether what is WIRED (config.h) is as in the board's own set: no bus changes it. False with `error` for the first that is not.
bool params_check_wiring(const params_set_t *set, const params_set_t *of_board, params_error_t *error);

/// The words that protect: all of config.h, and limits, scaling and arm of the loop (PROTECTS in tribo/parameters.h).
/// Returns the next one and moves `place`, which begins at 0; PARAMS_WORDS behind the last. In the order of their registers.
uint32_t params_next_protecting(uint32_t *place);

/// CRC-32 of these words and the two signs of the controller's gain, -1, 0 or 1, each as four bytes with the low one first.
uint32_t params_protection(const params_set_t *set);

/// Whether all of them are those of `like`, and the signs of the controller's gain; false with `error` for the first that is not.
bool params_protect_alike(const params_set_t *set, const params_set_t *like, params_error_t *error);
bool params_signs_alike(const params_set_t *set, const params_set_t *like, params_error_t *error);

/// Differs if the words of a set mean something else. Of the library's list it takes the number of rows, as their registers do not move;
/// OWN is the CRC-32 of the other names, which are not in an image: test_registers.c computes it. METHOD counts feed-forwards that give the
/// same numbers another meaning.
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
