/// The drive as a bus sees it: Modbus registers. Their lists are here, and in params.h and config.h for the params.
/// `tribo-link list --markdown` prints them, and tribo-link knows registers by these names.
///
/// All registers have 32 bits, two Modbus registers with the high one first, except the command. A write must hold whole
/// registers; a read may begin or end within one.
///
///     0x0000   states and counters                0x0200   a window into a trace
///     0x0080   signals of the last tick           0x1000   the staged set of params, read and written
///     0x0100   command, one Modbus register       0x2000   the set that the drive runs with, at the same places
///     0x0110   requests
///     0x0180   the last changes of registers that protect
///
/// Params are written to the staged set, where only floats are checked for numbers that no one can mean. REGISTERS_APPLY
/// checks this set as a whole and makes params from it, which the drive uses from one tick to the next. If the set is
/// refused, the drive keeps its params, and refused_* name the register of the staged set and its range. REGISTERS_SAVE
/// writes the active set into the store.
///
/// Some registers protect: limits, scaling, signs, levels and times of faults. A set that changes one of them, or the sign
/// of the controller's gain, is applied only out of RUN and after REGISTERS_KEY was written to `unlock`. The drive then
/// stays unlocked for REGISTERS_UNLOCK_S; a start or another value ends that. Key and staged set belong to their client and
/// end with it: with its connection, or after REGISTERS_CLIENT_S without a request. No set may exceed the ceilings of the
/// board, whose values are in its image, or change the image's clock, signs and levels. `protection` is a CRC-32 of all
/// registers that protect, for a host to compare. Each change of one is counted and kept.
///
/// At power-up the drive uses the set in the store, or the defaults of its board if nothing was ever saved. If the store is
/// damaged or of other firmware, the drive is in DRIVE_FAULT_STORE, which cannot be acknowledged before a set was applied.

#ifndef DRIVE_REGISTERS_H
#define DRIVE_REGISTERS_H

#include "app/drive.h"
#include "app/modbus.h"
#include "app/params.h"
#include "app/store.h"
#include "app/trace.h"

#include <stdbool.h>
#include <stdint.h>

#define REGISTERS_VERSION 10u ///< version of the lists in this file

#define REGISTERS_STATE_AT        0x0000u
#define REGISTERS_SIGNALS_AT      0x0080u
#define REGISTERS_COMPENSATION_AT 0x00c0u
#define REGISTERS_COMMAND_AT      0x0100u
#define REGISTERS_REQUESTS_AT     0x0110u
#define REGISTERS_CHANGES_AT      0x0180u
#define REGISTERS_WINDOW_AT       0x0200u
#define REGISTERS_STAGED_AT       0x1000u
#define REGISTERS_ACTIVE_AT       0x2000u
#define REGISTERS_WINDOW          62u ///< words that one frame can read

#define REGISTERS_KEY      0x6c6f6f73u ///< "loos"
#define REGISTERS_UNLOCK_S 60u
#define REGISTERS_CLIENT_S 10u ///< a client without a request for so long has gone
#define REGISTERS_SAVES    32u ///< different sets that may be saved, and ...
#define REGISTERS_SAVE_S                                                                                               \
    3600u ///< ... the time after which one more may, so that the flash's 10,000 erasures last for years
#define REGISTERS_CHANGES 16u ///< number of the last changes that are kept

// Places in a set, in Modbus registers.
#define REGISTERS_DRIVE_AT    0x000u
#define REGISTERS_LOOP_AT     PARAMS_LOOP_NUMBER
#define REGISTERS_METHOD_AT   0x1feu
#define REGISTERS_FEED_AT     PARAMS_FEED_NUMBER
#define REGISTERS_GUARD_AT    PARAMS_GUARD_NUMBER
#define REGISTERS_SECTIONS_AT 0x300u
#define REGISTERS_TABLE_AT    0x400u

/// Read-only registers: REGISTER(symbol, name, type, unit, text).
// clang-format off: one row a register
#define REGISTERS_STATE(REGISTER) \
    REGISTER(version, "version", uint32_t, "", "version of these lists") \
    REGISTER(layout, "layout", uint32_t, "", "identifies the meaning of a set's words: a number made from their names") \
    REGISTER(q31, "q31", uint32_t, "", "1: the drive computes in Q31") \
    REGISTER(state, "state", uint32_t, "", "0 idle, 1 run, 2 fault, 3 starting") \
    REGISTER(fault, "fault", uint32_t, "", "the cause of the fault, see below") \
    REGISTER(fault_tick, "fault_tick", uint32_t, "ticks", "the tick that latched the fault") \
    REGISTER(tick, "tick", uint32_t, "ticks", "ticks since power-up; wraps") \
    REGISTER(limits, "limits", uint32_t, "", "limits of the last tick, as bits: 1 u is limited, 2 the reference is not credible, 4 the host is gone and r goes to safe_reference_n") \
    REGISTER(max_tick_us, "max_tick_us", uint32_t, "us", "longest time from a tick's start to its command") \
    REGISTER(max_late_us, "max_late_us", uint32_t, "us", "largest delay of a tick's start") \
    REGISTER(overruns, "overruns", uint32_t, "ticks", "ticks over budget") \
    REGISTER(limited_ticks, "limited_ticks", uint32_t, "ticks", "ticks with u at a limit, since the start") \
    REGISTER(bad_inputs, "bad_inputs", uint32_t, "ticks", "ticks with a bad reference or reading, and corrupt states found, since the start") \
    REGISTER(tare, "tare", uint32_t, "", "the last tare: 0 none, 1 busy, 2 done, 3 refused") \
    REGISTER(store, "store", uint32_t, "", "0 read, 1 empty, 2 of other firmware, 3 damaged, 4 not writable") \
    REGISTER(outcome, "outcome", uint32_t, "", "outcome of the last command, see below") \
    REGISTER(refused_register, "refused_register", uint32_t, "", "the register that was refused; 0: none") \
    REGISTER(refused_status, "refused_status", uint32_t, "", "the reason of the library (tribo/status.h); 0: refused by the drive") \
    REGISTER(refused_value, "refused_value", float, "", "the value that was refused") \
    REGISTER(refused_low, "refused_low", float, "", "lowest value allowed") \
    REGISTER(refused_high, "refused_high", float, "", "highest value allowed; fields that depend on each other may narrow the range") \
    REGISTER(frames, "frames", uint32_t, "", "frames of the bus that were executed") \
    REGISTER(bad_frames, "bad_frames", uint32_t, "", "frames of the bus with a wrong CRC") \
    REGISTER(exceptions, "exceptions", uint32_t, "", "exceptions answered") \
    REGISTER(trace_state, "trace_state", uint32_t, "", "0 stopped, 1 armed, 2 triggered, 3 done") \
    REGISTER(trace_count, "trace_count", uint32_t, "samples", "samples taken since the trace was armed; wraps") \
    REGISTER(trace_held, "trace_held", uint32_t, "samples", "samples of these that can still be read") \
    REGISTER(trace_first_tick, "trace_first_tick", uint32_t, "ticks", "tick of sample 0") \
    REGISTER(trace_trigger, "trace_trigger_sample", uint32_t, "samples", "sample of the trigger, once triggered") \
    REGISTER(trace_signals_seen, "trace_signals_seen", uint32_t, "", "trace.signals of the samples held") \
    REGISTER(trace_decimation_seen, "trace_decimation_seen", uint32_t, "ticks", "trace.decimation of the samples held") \
    REGISTER(protection, "protection", uint32_t, "", "CRC-32 of the registers that protect, see below") \
    REGISTER(protection_changes, "protection_changes", uint32_t, "", "changes of such registers since power-up") \
    REGISTER(unlocked_ticks, "unlocked_ticks", uint32_t, "ticks", "ticks left in which a set may change registers that protect; 0: locked")
// clang-format on

/// Read-only registers of feed-forward and guard; not in a drive without them.
// clang-format off: one row a register
#define REGISTERS_COMPENSATION(REGISTER) \
    REGISTER(warnings, "warnings", uint32_t, "", "warnings until command 11, see below; the drive runs on") \
    REGISTER(fade, "friction_fade", float, "", "share of the friction compensation that is added to u: less than 1 where the guard has faded it; 1 without compensation, too") \
    REGISTER(learned_up, "learned_positive_N", float, "N", "breakaway at the last reference, learned by the feed-forward in the positive direction; 0 without one") \
    REGISTER(relative_variance_up, "learned_positive_relative_variance", float, "", "its variance divided by the initial variance, 0 to 1") \
    REGISTER(travel_up, "learned_positive_travel_N", float, "N", "travel from which it was learned") \
    REGISTER(bound_up, "learned_positive_at_bound", uint32_t, "", "1: learning is at its limit, do not trust the value") \
    REGISTER(learned_down, "learned_negative_N", float, "N", "learned breakaway in the negative direction") \
    REGISTER(relative_variance_down, "learned_negative_relative_variance", float, "", "its variance divided by the initial variance, 0 to 1") \
    REGISTER(travel_down, "learned_negative_travel_N", float, "N", "travel from which it was learned") \
    REGISTER(bound_down, "learned_negative_at_bound", uint32_t, "", "1: learning is at its limit, do not trust the value") \
    REGISTER(harms, "friction_harms", uint32_t, "", "1: feeding friction forward costs more effort than it saves; until command 11") \
    REGISTER(forgotten, "learned_forgotten", uint32_t, "", "how often a corrupt memory was forgotten, since power-up or command 12") \
    REGISTER(late, "learned_late", uint32_t, "", "samples that the background took too late, since power-up or command 12; they only slow learning down")
// clang-format on

/// The signals, in the order of a sample's channels: SIGNAL(symbol, name, unit, member, text) with a `member` of registers_t.
// clang-format off: one row a signal
#define REGISTERS_SIGNALS(SIGNAL) \
    SIGNAL(r, "r_N", "N", drive.r, "reference") \
    SIGNAL(y, "F_N", "N", drive.y, "measured force") \
    SIGNAL(u, "u_N", "N", applied, "command as applied; 0 unless the drive runs") \
    SIGNAL(e, "e_N", "N", drive.signals.TRIBO_N(e), "error r - y") \
    SIGNAL(v, "controller_N", "N", drive.signals.controller.TRIBO_N(v), "the controller's part of u") \
    SIGNAL(added, "friction_term_N", "N", drive.signals.TRIBO_N(friction_term), "the part of u that the method adds to the controller: f^ times the gain, or the whole feed-forward, lin + f + lead - b") \
    SIGNAL(f_hat, "F_hat_N", "N", drive.signals.compensator.TRIBO_N(force), "the arm model's force") \
    SIGNAL(n, "n_N", "N", drive.signals.compensator.friction.TRIBO_N(n), "net force") \
    SIGNAL(l, "L_N", "N", drive.signals.compensator.friction.TRIBO_N(L), "breakaway for the sign of n") \
    SIGNAL(f, "f_hat_N", "N", drive.signals.compensator.friction.TRIBO_N(f), "estimated friction")
// clang-format on

/// Registers to read and write: REGISTER(symbol, name, type, unit, default, text). The code that uses them checks them.
// clang-format off: one row a register
#define REGISTERS_REQUESTS(REGISTER) \
    REGISTER(reference, "reference", float, "N", 0.0f, "reference; 0 after every stop, fault and acknowledgement; renew it within drive.reference_ms") \
    REGISTER(which, "trace.which", uint32_t, "", 0u, "which trace the states and the window show: 0 the trace, 1 the one kept for faults") \
    REGISTER(position, "trace.position", uint32_t, "samples", 0u, "sample at which the window begins") \
    REGISTER(signals, "trace.signals", uint32_t, "", 0x47u, "signals to record, as bits in the order of the signals; 8 at most") \
    REGISTER(decimation, "trace.decimation", uint32_t, "ticks", 1u, "ticks from sample to sample") \
    REGISTER(trigger, "trace.trigger", uint32_t, "", 1u, "0 none, 1 fault, 2 reversal, 3 rises to level, 4 falls to level") \
    REGISTER(watched, "trace.watched", uint32_t, "", 0u, "the signal watched for a reversal or a level, by its place in the list") \
    REGISTER(level, "trace.level", float, "N", 0.0f, "level of the trigger, up to 1e6") \
    REGISTER(after, "trace.after", uint32_t, "samples", 100u, "samples recorded after the trigger's own") \
    REGISTER(unlock, "unlock", uint32_t, "", 0u, "0x6c6f6f73, written out of run, lets a set change for 60 s what protects; 0 ends that; reads as 0") \
    REGISTER(position_reference, "position_reference", uint32_t, "", 0u, "without a force sensor: target of your position loop, in units of the arm's position, as a two's complement; friction follows its motion, or the measured one if none is written; the first after a stop, fault or acknowledgement is not a motion")
// clang-format on

/// A change: REGISTER(symbol, name, type, unit, text). Change number n is kept at place n modulo REGISTERS_CHANGES.
// clang-format off: one row a register
#define REGISTERS_CHANGE(REGISTER) \
    REGISTER(tick, "tick", uint32_t, "ticks", "tick of the change") \
    REGISTER(address, "register", uint32_t, "", "its register in the staged set") \
    REGISTER(from, "from", uint32_t, "", "the word before the change") \
    REGISTER(to, "to", uint32_t, "", "the word after the change")
// clang-format on

/// COMMAND(symbol, number, text)
#define REGISTERS_COMMANDS(COMMAND)                                                                                    \
    COMMAND(START, 1, "start; only in idle")                                                                           \
    COMMAND(STOP, 2, "stop")                                                                                           \
    COMMAND(ACKNOWLEDGE, 3, "acknowledge the fault; only in fault, once its cause is gone")                            \
    COMMAND(TARE, 4, "make the mean of the next readings 0 N; only in idle")                                           \
    COMMAND(APPLY, 5, "check the staged set and use it")                                                               \
    COMMAND(REVERT, 6, "copy the active set to the staged set")                                                        \
    COMMAND(DEFAULTS, 7, "copy the board's defaults to the staged set")                                                \
    COMMAND(SAVE, 8, "write the active set, with the tare, into the store; not in run")                                \
    COMMAND(TRACE, 9, "begin a trace with the settings trace.*")                                                       \
    COMMAND(TRACE_STOP, 10, "end the trace")                                                                           \
    COMMAND(RESTORE, 11, "clear the warnings; faded friction returns")                                                 \
    COMMAND(FORGET, 12, "forget the values that the feed-forward has learned; not in run")

/// OUTCOME(symbol, text)
#define REGISTERS_OUTCOMES(OUTCOME)                                                                                    \
    OUTCOME(DONE, "done, or for a start, acknowledgement or tare: requested")                                          \
    OUTCOME(BUSY, "under way")                                                                                         \
    OUTCOME(WRONG_STATE, "not possible in this state of the drive")                                                    \
    OUTCOME(SET_REFUSED, "the set is refused; refused_* say why")                                                      \
    OUTCOME(NO_PARAMS, "the store is damaged or of other firmware: a set must be applied first")                       \
    OUTCOME(NOT_SAVED, "the flash cannot be written")                                                                  \
    OUTCOME(TRACE_REFUSED, "trace.* are out of range")                                                                 \
    OUTCOME(PROTECTED, "refused_register protects: to change it, stop the drive and unlock")                           \
    OUTCOME(LOCKED, "refused_register protects: to change it, unlock")                                                 \
    OUTCOME(SAVED_OFTEN, "32 different sets were saved; now one more an hour, to save the flash from wear")

typedef enum
{
#define REGISTERS_COMMAND(symbol, number, text) REGISTERS_##symbol = (number),
    REGISTERS_COMMANDS(REGISTERS_COMMAND)
#undef REGISTERS_COMMAND
} registers_command_t;

typedef enum
{
#define REGISTERS_OUTCOME(symbol, text) REGISTERS_##symbol,
    REGISTERS_OUTCOMES(REGISTERS_OUTCOME)
#undef REGISTERS_OUTCOME
} registers_outcome_t;

enum
{
#define REGISTERS_PLACE(symbol, name, type, unit, text) REGISTERS_STATE_##symbol,
    REGISTERS_STATE(REGISTERS_PLACE)
#undef REGISTERS_PLACE
        REGISTERS_STATE_COUNT
};

enum
{
#define REGISTERS_PLACE(symbol, name, type, unit, text) REGISTERS_COMPENSATION_##symbol,
    REGISTERS_COMPENSATION(REGISTERS_PLACE)
#undef REGISTERS_PLACE
        REGISTERS_COMPENSATION_COUNT
};

enum
{
#define REGISTERS_PLACE(symbol, name, unit, member, text) REGISTERS_SIGNAL_##symbol,
    REGISTERS_SIGNALS(REGISTERS_PLACE)
#undef REGISTERS_PLACE
        REGISTERS_SIGNAL_COUNT
};

/// The requests as they were written.
typedef struct
{
#define REGISTERS_MEMBER(symbol, name, type, unit, normal, text) type symbol;
    REGISTERS_REQUESTS(REGISTERS_MEMBER)
#undef REGISTERS_MEMBER
} registers_requests_t;

typedef struct
{
#define REGISTERS_MEMBER(symbol, name, type, unit, text) type symbol;
    REGISTERS_CHANGE(REGISTERS_MEMBER)
#undef REGISTERS_MEMBER
} registers_change_t;

#define REGISTERS_FAULT_CHANNELS 4u ///< r, y, u and F^
#define REGISTERS_FAULT_AFTER    15u
#define REGISTERS_FAULT_SAMPLES  216u ///< 200 before the fault, its own, and those after it

/// The board behind the registers. All pointers must outlive them.
typedef struct
{
    const port_t        *port;
    const modbus_line_t *line;
    const store_flash_t *flash;    ///< null: there is no flash, and nothing can be saved
    const params_set_t  *defaults; ///< the board's defaults
    /// Checks whether a set suits the board beyond the converters, which the port describes; null: every set does.
    bool (*suits)(const params_set_t *set, params_error_t *error);
    const params_ceiling_t *ceilings;
    uint32_t                ceiling_count;
    bool      has_reference; ///< the board has a reference of its own each tick, so the bus may not write one
    uint32_t  baud;
    uint32_t *ring; ///< of the trace
    uint32_t  ring_words;
} registers_board_t;

/// Read only: the functions below write it. Small members stand first, because their addresses make shorter code.
typedef struct
{
    params_t *active;                    ///< one of `params`
    const drive_setup_t *volatile taken; ///< the setup that the last tick used
    volatile uint32_t    starts_taken;   ///< starts that the ticks that have ended have executed or dropped
    bool                 is_made;        ///< the active params are valid
    bool                 is_known;       ///< the store is good or empty, or a set was applied since power-up
    bool                 is_refused;
    bool                 must_save;
    bool                 is_unlocked;
    bool                 is_staged;   ///< the client has changed the staged set
    uint32_t             heard;       ///< modbus.heard, ...
    uint32_t             heard_at;    ///< ... and the tick in which it changed or the client last wrote
    uint32_t             unlocked_at; ///< tick of the unlock
    uint32_t             saves;       ///< number of saves, minus one for each REGISTERS_SAVE_S
    uint32_t             saves_at;    ///< tick of the last subtraction
    uint32_t             protection, protection_changes;
    bool                 is_sealed;
    uint32_t             seal;           ///< CRC-32 of the active params
    uint32_t             crc, crc_bytes; ///< CRC-32 of their first bytes, and the number of these
    store_status_t       store;
    registers_outcome_t  outcome;
    params_error_t       refused;
    registers_requests_t requests;
    loop_force_t         applied;       ///< u of the last tick
    uint32_t             trace_signals; ///< signals that the trace holds
    registers_board_t    board;

    drive_t            drive;
    modbus_t           modbus;
    trace_t            trace, fault_trace;
    uint32_t           fault_ring[REGISTERS_FAULT_CHANNELS * REGISTERS_FAULT_SAMPLES];
    loop_memory_t      memory;      ///< memory of a feed-forward; outlasts stops and changes of params and method
    bool               is_learning; ///< the memory is initialised
    registers_change_t changes[REGISTERS_CHANGES];
    params_set_t       staged;
    params_t           params[2];
} registers_t;

/// Reads the store and makes params, registers->active, for a board that needs its config before it sets up its hardware. Their
/// drive setup is complete unless registers_start finds a fault. Calls no function of the port.
void registers_load(registers_t *registers, const registers_board_t *board);

/// Sets up the drive with these params. `found` is the fault that drive_init takes.
void registers_start(registers_t *registers, drive_fault_t found);

/// Runs a tick of the drive, records the traces and copies received bytes. Call it in the timer's interrupt.
void registers_tick(registers_t *registers);

/// Executes frames and long commands. Call it in the background, again and again. Returns true if it was busy for so long that
/// requests which came meanwhile are late.
bool registers_run(registers_t *registers);

/// Locks, and forgets the staged changes, because the client has gone.
void registers_forget_client(registers_t *registers);

/// Returns whether the trace that the registers request would be armed. A port whose tick runs on beside the background
/// stops the trace before it is armed anew, and must not stop it for one that is refused.
bool registers_can_trace(const registers_t *registers);

/// Returns the registers behind registers->modbus.
modbus_registers_t registers_map(registers_t *registers);

#endif
