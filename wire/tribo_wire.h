/// What the host and a drive in an emulator say to each other, in lock-step. Knows neither side.
///
/// A message is 32-bit words, least significant byte first: kind, number of words that follow, those words. Floats travel as
/// their bits, forces in the drive's own arithmetic: N in single precision, or Q31 of the full scale.
///
///     target          host
///     HELLO   ---->
///             <----   SETUP      the loop's config; the target makes its params of it
///     READY   ---->
///             <----   TICK  }    as often as wanted
///     TOCK    ---->         }
///             <----   END        the target's program ends with status 0

#ifndef TRIBO_WIRE_H
#define TRIBO_WIRE_H

#define TRIBO_WIRE_VERSION 1u

#define TRIBO_WIRE_HEADER_WORDS 2u
#define TRIBO_WIRE_WORDS_MAX    160u ///< of a message, without its header

/// The FIFOs, in the folder that the emulator runs in.
#define TRIBO_WIRE_TO_TARGET   "to_target"
#define TRIBO_WIRE_FROM_TARGET "from_target"

typedef enum
{
    TRIBO_WIRE_HELLO = 0x54520001, ///< "TR" and a number
    TRIBO_WIRE_SETUP,
    TRIBO_WIRE_READY,
    TRIBO_WIRE_TICK,
    TRIBO_WIRE_TOCK,
    TRIBO_WIRE_END
} tribo_wire_kind_t;

typedef enum
{
    TRIBO_HELLO_VERSION,
    TRIBO_HELLO_ARITHMETIC, ///< 0 f32, 1 q31
    TRIBO_HELLO_FAULT,      ///< what the self-test found, 0 if nothing
    TRIBO_HELLO_WORDS
} tribo_hello_word_t;

#define TRIBO_SETUP_SECTIONS_MAX 4u
#define TRIBO_SETUP_POINTS_MAX   32u

typedef enum
{
    TRIBO_SETUP_FULL_SCALE,
    TRIBO_SETUP_PERIOD_US,
    TRIBO_SETUP_LATE_US,
    TRIBO_SETUP_BUDGET_US,
    TRIBO_SETUP_STUCK_TICKS,
    TRIBO_SETUP_SAMPLE_TIME,
    TRIBO_SETUP_INPUT_MAX,
    TRIBO_SETUP_GAIN,
    TRIBO_SETUP_U_MIN,
    TRIBO_SETUP_U_MAX,
    TRIBO_SETUP_K_MIN,
    TRIBO_SETUP_K_MAX,
    TRIBO_SETUP_M,
    TRIBO_SETUP_V0,
    TRIBO_SETUP_POSITIVE_OFFSET,
    TRIBO_SETUP_POSITIVE_SLOPE,
    TRIBO_SETUP_NEGATIVE_OFFSET,
    TRIBO_SETUP_NEGATIVE_SLOPE,
    TRIBO_SETUP_SET_LEVEL,
    TRIBO_SETUP_RESET_LEVEL,
    TRIBO_SETUP_PULSE_WIDTH,
    TRIBO_SETUP_GRAVITY,
    TRIBO_SETUP_INERTIA,
    TRIBO_SETUP_DAMPING,
    TRIBO_SETUP_STIFFNESS,
    TRIBO_SETUP_SECTION_COUNT,
    TRIBO_SETUP_POINT_COUNT, ///< 0: no table
    TRIBO_SETUP_SECTIONS,    ///< b0, b1, b2, a1, a2 of each of TRIBO_SETUP_SECTIONS_MAX
    TRIBO_SETUP_POINTS = TRIBO_SETUP_SECTIONS + 5 * TRIBO_SETUP_SECTIONS_MAX, ///< |F|, L+, L- of each
    TRIBO_SETUP_WORDS  = TRIBO_SETUP_POINTS + 3 * TRIBO_SETUP_POINTS_MAX
} tribo_setup_word_t;

typedef enum
{
    TRIBO_READY_STATUS, ///< tribo_status_t
    TRIBO_READY_WORDS
} tribo_ready_word_t;

#define TRIBO_REQUEST_START       1u
#define TRIBO_REQUEST_STOP        2u
#define TRIBO_REQUEST_ACKNOWLEDGE 4u

typedef enum
{
    TRIBO_TICK_REQUESTS, ///< bits, made before the tick
    TRIBO_TICK_START_US, ///< the clock when the tick starts ...
    TRIBO_TICK_END_US,   ///< ... and when the loop is done
    TRIBO_TICK_INPUTS,   ///< PORT_INPUT_ bits
    TRIBO_TICK_SILENT,   ///< not 0: the sensor does not answer
    TRIBO_TICK_R,
    TRIBO_TICK_Y,
    TRIBO_TICK_WORDS
} tribo_tick_word_t;

typedef enum
{
    TRIBO_TOCK_COMMAND, ///< as the power stage has it
    TRIBO_TOCK_ENABLED,
    TRIBO_TOCK_STATE,  ///< drive_state_t
    TRIBO_TOCK_FAULT,  ///< drive_fault_t
    TRIBO_TOCK_LIMITS, ///< drive_limit_t bits
    TRIBO_TOCK_LIMITED_TICKS,
    TRIBO_TOCK_BAD_INPUTS,
    TRIBO_TOCK_LOOP, ///< loop_word_t: bits, e, controller, feedforward, u, F^, n, L, rate, f^
    TRIBO_TOCK_WORDS = TRIBO_TOCK_LOOP + 10
} tribo_tock_word_t;

#endif
