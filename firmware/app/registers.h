/// The drive as a bus sees it: Modbus registers, of which every list is here or where params.h and config.h take it from.
/// `tribo-link list --markdown` prints them, and tribo-link knows registers by these names.
///
/// All registers are of 32 bits, two Modbus registers with the high one first, except the command. A write must hold whole
/// ones; a read may cut one.
///
///     0x0000   states and counters                0x0200   a window into a trace
///     0x0080   signals of the last tick           0x1000   the staged set of params, read and written
///     0x0100   command, one Modbus register       0x2000   the set that the drive runs with, at the same places
///     0x0110   requests
///     0x0180   the last changes of what protects
///
/// Params are written to the staged set, where nothing is checked. REGISTERS_APPLY makes params of it, checked as a whole, and
/// the drive goes on with them from one tick to the next. If they are refused the drive goes on as it was, and refused_* name
/// the register of the staged set and its range. REGISTERS_SAVE writes what the drive runs with into the store.
///
/// Some registers protect: limits, scaling, signs, levels and times of faults. A set that changes one of them, or the sign of
/// the controller's gain, is applied only out of RUN, and once `unlock` was written with REGISTERS_KEY. That lasts
/// REGISTERS_UNLOCK_S; a start or another value ends it. The key and a staged set are their client's and end with it: with its
/// connection, or after REGISTERS_CLIENT_S without a request. No set is wider than the ceilings of the board, whose values are in
/// its image, and its clock, signs and levels are the image's. `protection` is a CRC-32 of all that protects, for a host to compare, and each change is counted and kept.
///
/// At power-up the drive runs with what the store holds, or if nothing was ever saved with the defaults of its board. If the
/// store is damaged or of other firmware it is in DRIVE_FAULT_STORE, which cannot be acknowledged before a set was applied.

#ifndef DRIVE_REGISTERS_H
#define DRIVE_REGISTERS_H

#include "app/drive.h"
#include "app/modbus.h"
#include "app/params.h"
#include "app/store.h"
#include "app/trace.h"

#include <stdbool.h>
#include <stdint.h>

#define REGISTERS_VERSION 10u ///< of the lists in this file

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
#define REGISTERS_CLIENT_S 10u   ///< without a request its client has gone
#define REGISTERS_SAVES    32u   ///< of different sets, and ...
#define REGISTERS_SAVE_S   3600u ///< ... one more each, so that the flash's 10,000 erasures last for years whoever saves
#define REGISTERS_CHANGES  16u   ///< that are kept

// Places in a set, in Modbus registers.
#define REGISTERS_DRIVE_AT    0x000u
#define REGISTERS_LOOP_AT     PARAMS_LOOP_NUMBER
#define REGISTERS_METHOD_AT   0x1feu
#define REGISTERS_FEED_AT     PARAMS_FEED_NUMBER
#define REGISTERS_GUARD_AT    PARAMS_GUARD_NUMBER
#define REGISTERS_SECTIONS_AT 0x300u
#define REGISTERS_TABLE_AT    0x400u

/// REGISTER(symbol, name, type, unit, text): read only.
// clang-format off: one row a register
#define REGISTERS_STATE(REGISTER) \
    REGISTER(version, "version", uint32_t, "", "of these lists") \
    REGISTER(layout, "layout", uint32_t, "", "of a set of params: CRC-32 of its names") \
    REGISTER(q31, "q31", uint32_t, "", "1: the drive computes in Q31") \
    REGISTER(state, "state", uint32_t, "", "0 idle, 1 run, 2 fault, 3 starting") \
    REGISTER(fault, "fault", uint32_t, "", "the cause of the fault, see below") \
    REGISTER(fault_tick, "fault_tick", uint32_t, "ticks", "the tick that latched it") \
    REGISTER(tick, "tick", uint32_t, "ticks", "since power-up; wraps") \
    REGISTER(limits, "limits", uint32_t, "", "of the last tick: 1 u is limited, 2 the reference is not credible, 4 the host is gone and r goes to safe_reference_n") \
    REGISTER(max_tick_us, "max_tick_us", uint32_t, "us", "longest from a tick's start to its command") \
    REGISTER(max_late_us, "max_late_us", uint32_t, "us", "latest start") \
    REGISTER(overruns, "overruns", uint32_t, "ticks", "over budget") \
    REGISTER(limited_ticks, "limited_ticks", uint32_t, "ticks", "with u at a limit, since the start") \
    REGISTER(bad_inputs, "bad_inputs", uint32_t, "ticks", "with a bad reference or reading, and corrupt pointers found, since the start") \
    REGISTER(tare, "tare", uint32_t, "", "of the last tare: 0 none, 1 busy, 2 done, 3 refused") \
    REGISTER(store, "store", uint32_t, "", "0 read, 1 empty, 2 of other firmware, 3 damaged, 4 not writable") \
    REGISTER(outcome, "outcome", uint32_t, "", "of the last command, see below") \
    REGISTER(refused_register, "refused_register", uint32_t, "", "the staged register that was refused; 0: none") \
    REGISTER(refused_status, "refused_status", uint32_t, "", "the library's refusal (tribo/status.h); 0: the drive's") \
    REGISTER(refused_value, "refused_value", float, "", "the value that was refused") \
    REGISTER(refused_low, "refused_low", float, "", "allowed from") \
    REGISTER(refused_high, "refused_high", float, "", "to; fields that depend on each other may narrow it") \
    REGISTER(frames, "frames", uint32_t, "", "of the bus that were executed") \
    REGISTER(bad_frames, "bad_frames", uint32_t, "", "of the bus with a wrong CRC") \
    REGISTER(exceptions, "exceptions", uint32_t, "", "answered") \
    REGISTER(trace_state, "trace_state", uint32_t, "", "0 stopped, 1 armed, 2 triggered, 3 done") \
    REGISTER(trace_count, "trace_count", uint32_t, "samples", "since it was armed; wraps") \
    REGISTER(trace_held, "trace_held", uint32_t, "samples", "of these, those that can still be read") \
    REGISTER(trace_first_tick, "trace_first_tick", uint32_t, "ticks", "of sample 0") \
    REGISTER(trace_trigger, "trace_trigger_sample", uint32_t, "samples", "once triggered") \
    REGISTER(trace_signals_seen, "trace_signals_seen", uint32_t, "", "trace.signals of what it holds") \
    REGISTER(trace_decimation_seen, "trace_decimation_seen", uint32_t, "ticks", "trace.decimation of what it holds") \
    REGISTER(protection, "protection", uint32_t, "", "CRC-32 of the registers that protect, see below") \
    REGISTER(protection_changes, "protection_changes", uint32_t, "", "of such registers since power-up") \
    REGISTER(unlocked_ticks, "unlocked_ticks", uint32_t, "ticks", "left in which a set may change what protects; 0: locked")
// clang-format on

/// Of feed-forward and guard, likewise; not in a drive without them.
// clang-format off: one row a register
#define REGISTERS_COMPENSATION(REGISTER) \
    REGISTER(warnings, "warnings", uint32_t, "", "until command 11, see below; the drive runs on") \
    REGISTER(fade, "friction_fade", float, "", "of the compensation that is added to u: 1, or less where the guard has faded it; 1 without compensation, too") \
    REGISTER(learned_up, "learned_positive_N", float, "N", "breakaway at the last reference as the feed-forward has learned it; 0 without one") \
    REGISTER(relative_variance_up, "learned_positive_relative_variance", float, "", "variance of it over what it was at first, 0 to 1") \
    REGISTER(travel_up, "learned_positive_travel_N", float, "N", "that it was learned from") \
    REGISTER(bound_up, "learned_positive_at_bound", uint32_t, "", "1: not to be trusted") \
    REGISTER(learned_down, "learned_negative_N", float, "N", "in the negative direction") \
    REGISTER(relative_variance_down, "learned_negative_relative_variance", float, "", "of the negative direction") \
    REGISTER(travel_down, "learned_negative_travel_N", float, "N", "of the negative direction") \
    REGISTER(bound_down, "learned_negative_at_bound", uint32_t, "", "of the negative direction") \
    REGISTER(harms, "friction_harms", uint32_t, "", "1: friction fed forward costs more effort than it saves; until command 11") \
    REGISTER(forgotten, "learned_forgotten", uint32_t, "", "times that a corrupt memory was forgotten, since power-up or command 12") \
    REGISTER(late, "learned_late", uint32_t, "", "samples that the background learned from too late, likewise: costs time to learn, nothing else")
// clang-format on

/// The signals, in the order of a sample's channels: SIGNAL(symbol, name, unit, member, text), `member` of registers_t.
// clang-format off: one row a signal
#define REGISTERS_SIGNALS(SIGNAL) \
    SIGNAL(r, "r_N", "N", drive.r, "reference") \
    SIGNAL(y, "F_N", "N", drive.y, "measured force") \
    SIGNAL(u, "u_N", "N", applied, "command as applied: 0 unless the drive runs") \
    SIGNAL(e, "e_N", "N", drive.signals.TRIBO_N(e), "error") \
    SIGNAL(v, "controller_N", "N", drive.signals.controller.TRIBO_N(v), "the controller's part of u") \
    SIGNAL(added, "friction_term_N", "N", drive.signals.TRIBO_N(friction_term), "what the method adds to the controller: f^ times the gain, or the whole feed-forward, lin + f + lead - b") \
    SIGNAL(f_hat, "F_hat_N", "N", drive.signals.compensator.TRIBO_N(force), "the arm model's force") \
    SIGNAL(n, "n_N", "N", drive.signals.compensator.friction.TRIBO_N(n), "net force") \
    SIGNAL(l, "L_N", "N", drive.signals.compensator.friction.TRIBO_N(L), "breakaway for the sign of n") \
    SIGNAL(f, "f_hat_N", "N", drive.signals.compensator.friction.TRIBO_N(f), "estimated friction")
// clang-format on

/// REGISTER(symbol, name, type, unit, default, text): read and written; checked by what uses them.
// clang-format off: one row a register
#define REGISTERS_REQUESTS(REGISTER) \
    REGISTER(reference, "reference", float, "N", 0.0f, "0 after every stop, fault and acknowledgement; renew it within drive.reference_ms") \
    REGISTER(which, "trace.which", uint32_t, "", 0u, "that states and window are of: 0 the trace, 1 the one kept for faults") \
    REGISTER(position, "trace.position", uint32_t, "samples", 0u, "where the window begins") \
    REGISTER(signals, "trace.signals", uint32_t, "", 0x47u, "bits, by the order of the signals; 8 at most") \
    REGISTER(decimation, "trace.decimation", uint32_t, "ticks", 1u, "from sample to sample") \
    REGISTER(trigger, "trace.trigger", uint32_t, "", 1u, "0 none, 1 fault, 2 reversal, 3 rises to level, 4 falls to level") \
    REGISTER(watched, "trace.watched", uint32_t, "", 0u, "the signal of a reversal or level, by its order") \
    REGISTER(level, "trace.level", float, "N", 0.0f, "of the trigger, up to 1e6") \
    REGISTER(after, "trace.after", uint32_t, "samples", 100u, "recorded after the trigger's") \
    REGISTER(unlock, "unlock", uint32_t, "", 0u, "0x6c6f6f73 out of run: for 60 s a set may change what protects; 0 ends it; reads as 0") \
    REGISTER(position_reference, "position_reference", uint32_t, "", 0u, "without a force sensor: where your position loop wants the arm, in units of its position, as a two's complement; the first after a stop, fault or acknowledgement is no motion; without one the measured motion decides")
// clang-format on

/// Of the change whose number is n, n modulo REGISTERS_CHANGES: REGISTER(symbol, name, type, unit, text).
// clang-format off: one row a register
#define REGISTERS_CHANGE(REGISTER) \
    REGISTER(tick, "tick", uint32_t, "ticks", "that it was made in") \
    REGISTER(address, "register", uint32_t, "", "of the staged set") \
    REGISTER(from, "from", uint32_t, "", "the word that it had") \
    REGISTER(to, "to", uint32_t, "", "the word that it has")
// clang-format on

/// COMMAND(symbol, number, text)
#define REGISTERS_COMMANDS(COMMAND)                                                                                    \
    COMMAND(START, 1, "start; in idle")                                                                                \
    COMMAND(STOP, 2, "stop")                                                                                           \
    COMMAND(ACKNOWLEDGE, 3, "acknowledge the fault; in fault, once its cause is gone")                                 \
    COMMAND(TARE, 4, "the mean of the next readings is 0 N; in idle")                                                  \
    COMMAND(APPLY, 5, "go on with the staged set")                                                                     \
    COMMAND(REVERT, 6, "stage the set that the drive runs with")                                                       \
    COMMAND(DEFAULTS, 7, "stage the defaults of the board")                                                            \
    COMMAND(SAVE, 8, "write what the drive runs with, and its tare, into the store; not in run")                       \
    COMMAND(TRACE, 9, "begin a trace as trace.* say")                                                                  \
    COMMAND(TRACE_STOP, 10, "end it")                                                                                  \
    COMMAND(RESTORE, 11, "take the warnings back; friction that was faded returns")                                    \
    COMMAND(FORGET, 12, "forget what the feed-forward has learned; not in run")

/// OUTCOME(symbol, text)
#define REGISTERS_OUTCOMES(OUTCOME)                                                                                    \
    OUTCOME(DONE, "done, or for a start, acknowledgement or tare: requested")                                          \
    OUTCOME(BUSY, "under way")                                                                                         \
    OUTCOME(WRONG_STATE, "not in this state of the drive")                                                             \
    OUTCOME(SET_REFUSED, "the set is refused, see refused_*")                                                          \
    OUTCOME(NO_PARAMS, "the store is damaged or of other firmware: a set must be applied first")                       \
    OUTCOME(NOT_SAVED, "the flash does not take it")                                                                   \
    OUTCOME(TRACE_REFUSED, "trace.* are out of range")                                                                 \
    OUTCOME(PROTECTED, "refused_register protects: stop the drive, then unlock")                                       \
    OUTCOME(LOCKED, "refused_register protects: unlock")                                                               \
    OUTCOME(SAVED_OFTEN, "32 sets were saved; one more an hour, or the flash would wear")

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

/// Words as they were written.
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
#define REGISTERS_FAULT_SAMPLES  216u ///< 200 before the fault's own, and those after it

/// What the registers are put in front of. All must outlive them.
typedef struct
{
    const port_t        *port;
    const modbus_line_t *line;
    const store_flash_t *flash;    ///< null: there is none, and nothing can be saved
    const params_set_t  *defaults; ///< of the board
    /// Whether a set suits the board beyond what the port says of its converters; null: any does.
    bool (*suits)(const params_set_t *set, params_error_t *error);
    const params_ceiling_t *ceilings;
    uint32_t                ceiling_count;
    bool                    has_reference; ///< of its own, each tick: one of the bus is refused
    uint32_t                baud;
    uint32_t               *ring; ///< of the trace
    uint32_t                ring_words;
} registers_board_t;

/// Read only; the functions below write it. The small members first: code that reaches them is shorter.
typedef struct
{
    params_t *active;                    ///< of `params`
    const drive_setup_t *volatile taken; ///< what the last tick ended with
    bool                 is_made;        ///< the active params
    bool                 is_known;       ///< the params were saved once, or applied since power-up
    bool                 is_refused;
    bool                 must_save;
    bool                 is_unlocked;
    bool                 is_staged;   ///< by the client
    uint32_t             heard;       ///< modbus.heard, ...
    uint32_t             heard_at;    ///< ... and the tick that it changed in, or that the client last wrote in
    uint32_t             unlocked_at; ///< tick
    uint32_t             saves;       ///< less one for each REGISTERS_SAVE_S
    uint32_t             saves_at;    ///< tick of the last one less
    uint32_t             protection, protection_changes;
    bool                 is_sealed;
    uint32_t             seal;           ///< CRC-32 of the active params
    uint32_t             crc, crc_bytes; ///< of the first bytes of them
    store_status_t       store;
    registers_outcome_t  outcome;
    params_error_t       refused;
    registers_requests_t requests;
    loop_force_t         applied;       ///< u of the last tick
    uint32_t             trace_signals; ///< of what the trace holds
    registers_board_t    board;

    drive_t            drive;
    modbus_t           modbus;
    trace_t            trace, fault_trace;
    uint32_t           fault_ring[REGISTERS_FAULT_CHANNELS * REGISTERS_FAULT_SAMPLES];
    loop_memory_t      memory; ///< of a feed-forward, which goes on over stops and changes of params and of the method
    bool               is_learning; ///< the memory has begun
    registers_change_t changes[REGISTERS_CHANGES];
    params_set_t       staged;
    params_t           params[2];
} registers_t;

/// Reads the store and makes params, for a board that needs its config before its hardware is set up: registers->active, whose
/// drive setup is whole but for a fault. No port's function is called.
void registers_load(registers_t *registers, const registers_board_t *board);

/// Sets up the drive with these. `found` as drive_init has it.
void registers_start(registers_t *registers, drive_fault_t found);

/// In the timer's interrupt: a tick of the drive, the traces, and the bytes that have come.
void registers_tick(registers_t *registers);

/// In the background, again and again: frames, and commands that take long. True if nobody could answer meanwhile: what has come
/// until now is late.
bool registers_run(registers_t *registers);

/// The client has gone: locks, and forgets what it has staged.
void registers_forget_client(registers_t *registers);

/// The registers behind registers->modbus.
modbus_registers_t registers_map(registers_t *registers);

#endif
