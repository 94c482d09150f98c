/// Messages between the host and a drive in lock-step. This file depends on neither side, only on the library.
///
/// A message consists of 32-bit words, least significant byte first: kind, number of the words that follow, those words. A
/// float is sent as its bits, a force in the drive's own arithmetic: in N in single precision, or in Q31 of the full scale.
///
///     target          host
///     HELLO   ---->
///             <----   SETUP      the loop's config; the target makes its params from it
///     READY   ---->
///             <----   TICK  }    any number of times
///     TOCK    ---->         }
///             <----   END        the target's program ends with status 0
///
/// Over a serial line each message is followed by the CRC-32 of its words. A session begins with an empty HELLO from the host,
/// repeated until the target answers. The target answers END with an END that carries its cycles.

#ifndef TRIBO_WIRE_H
#define TRIBO_WIRE_H

#include "tribo_setup.h"
#include "tribo_signal_words.h"

#define TRIBO_WIRE_VERSION 7u

#define TRIBO_WIRE_HEADER_WORDS 2u
#define TRIBO_WIRE_WORDS_MAX    TRIBO_SETUP_WORDS ///< the longest message, SETUP, without its header

/// Two pipes, which the emulator receives as open files. The target opens them by these names.
#define TRIBO_WIRE_TO_TARGET_FD   3
#define TRIBO_WIRE_TO_TARGET      "/dev/fd/3"
#define TRIBO_WIRE_FROM_TARGET_FD 4
#define TRIBO_WIRE_FROM_TARGET    "/dev/fd/4"

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
    TRIBO_HELLO_Q31,   ///< 1 if the image computes in Q31, 0 in f32
    TRIBO_HELLO_FAULT, ///< the self-test's result, 0 if it passed
    TRIBO_HELLO_WORDS
} tribo_hello_word_t;

typedef enum
{
    TRIBO_READY_STATUS, ///< tribo_status_t of the loop's set-up
    TRIBO_READY_WORDS
} tribo_ready_word_t;

typedef enum
{
    TRIBO_CYCLES_LEAST, ///< fewest cycles of a tick of the drive; 0: the core has no counter
    TRIBO_CYCLES_MEAN,
    TRIBO_CYCLES_MOST,
    TRIBO_CYCLES_WORDS
} tribo_cycles_word_t;

#define TRIBO_REQUEST_START       1u
#define TRIBO_REQUEST_STOP        2u
#define TRIBO_REQUEST_ACKNOWLEDGE 4u

typedef enum
{
    TRIBO_TICK_REQUESTS, ///< TRIBO_REQUEST_ bits, made before the tick
    TRIBO_TICK_START_US, ///< the clock when the tick starts ...
    TRIBO_TICK_END_US,   ///< ... and when the loop is done
    TRIBO_TICK_INPUTS,   ///< PORT_INPUT_ bits
    TRIBO_TICK_SILENT,   ///< 0 if the sensor answers
    TRIBO_TICK_R,
    TRIBO_TICK_Y,
    TRIBO_TICK_WORDS
} tribo_tick_word_t;

// NOLINTNEXTLINE(cert-int09-c,readability-enum-initial-value): the last enumerator is a count
typedef enum
{
    TRIBO_TOCK_COMMAND, ///< as the power stage receives it
    TRIBO_TOCK_ENABLED,
    TRIBO_TOCK_STATE,  ///< drive_state_t
    TRIBO_TOCK_FAULT,  ///< drive_fault_t
    TRIBO_TOCK_LIMITS, ///< drive_limit_t bits
    TRIBO_TOCK_LIMITED_TICKS,
    TRIBO_TOCK_BAD_INPUTS,
    TRIBO_TOCK_GUARD,   ///< tribo_guard_cause_t
    TRIBO_TOCK_SIGNALS, ///< tribo_signal_word_t
    TRIBO_TOCK_WORDS = (int)TRIBO_TOCK_SIGNALS + (int)TRIBO_SIGNAL_WORDS
} tribo_tock_word_t;

#endif
