#include "app/registers.h"

#include "app/crc32.h"

#include <stdatomic.h>
#include <stddef.h>
#include <string.h>

typedef uint32_t word_t;

static word_t bits_of(float x)
{
    word_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static const drive_config_t *config_of(const registers_t *registers)
{
    return &registers->active->set.drive;
}

/// Returns the ticks in this time. The board's defaults are read over the bus even if they are refused for a period of 0.
static uint32_t ticks_of(const registers_t *registers, uint32_t s)
{
    const uint32_t period_us = config_of(registers)->period_us;
    return s * (1000000u / (period_us > 0u ? period_us : 1u));
}

static bool is_running(const registers_t *registers)
{
    return registers->drive.state == DRIVE_RUN || registers->drive.state == DRIVE_STARTING;
}

// --- set-up --------------------------------------------------------------------------------------------------------

static bool make(registers_t *registers, params_t *params)
{
    const registers_board_t *board = &registers->board;
    registers->is_refused =
        !params_check_method(&params->set, board->defaults, &registers->refused) ||
        !params_make(params, board->port, &registers->refused) ||
        !params_check_ceilings(&params->set, board->ceilings, board->ceiling_count, &registers->refused) ||
        !params_check_wiring(&params->set, board->defaults, &registers->refused) ||
        (board->suits != NULL && !board->suits(&params->set, &registers->refused));
    return !registers->is_refused;
}

/// Returns the one of the two params that the drive does not run with.
static params_t *spare_of(registers_t *registers)
{
    return registers->active == &registers->params[0] ? &registers->params[1] : &registers->params[0];
}

/// Replaces the defaults by the saved set. A saved set that is refused stays staged, so that a host can read it.
static void load(registers_t *registers)
{
    const store_flash_t *flash = registers->board.flash;
    params_t *const      saved = spare_of(registers);
    registers->store = flash != NULL ? store_read(flash, PARAMS_LAYOUT, saved->words, PARAMS_WORDS) : STORE_EMPTY;
    if (registers->store == STORE_OK)
    {
        registers->staged  = saved->set;
        registers->store   = make(registers, saved) ? STORE_OK : STORE_FOREIGN;
        registers->active  = registers->store == STORE_OK ? saved : registers->active;
        registers->is_made = registers->is_made || registers->store == STORE_OK;
    }
    registers->is_known = registers->store == STORE_OK || registers->store == STORE_EMPTY;
}

/// Begins the seal of new params.
static void renew_seal(registers_t *registers)
{
    registers->is_sealed  = false;
    registers->crc        = 0;
    registers->crc_bytes  = 0;
    registers->protection = params_protection(&registers->active->set);
}

#define SEAL_STEP 16u // bytes a call, because a tick and the line wait meanwhile

/// Params that change without being applied show a stray write or rotten RAM.
static void check_seal(registers_t *registers)
{
    const unsigned char *params = (const unsigned char *)registers->active;
    const uint32_t       left   = (uint32_t)sizeof *registers->active - registers->crc_bytes;
    const uint32_t       step   = left < SEAL_STEP ? left : SEAL_STEP;
    registers->crc              = crc32_update(registers->crc, params + registers->crc_bytes, step);
    registers->crc_bytes += step;
    if (step == left)
    {
        if (registers->is_sealed && registers->crc != registers->seal)
        {
            drive_condemn(&registers->drive);
        }
        registers->seal      = registers->crc;
        registers->is_sealed = true;
        registers->crc       = 0;
        registers->crc_bytes = 0;
    }
}

static const loop_force_t *signal_of(const registers_t *registers, uint32_t signal);

static void arm_fault_trace(registers_t *registers)
{
    const trace_setup_t setup = {.channels      = {signal_of(registers, REGISTERS_SIGNAL_r),
                                                   signal_of(registers, REGISTERS_SIGNAL_y),
                                                   signal_of(registers, REGISTERS_SIGNAL_u),
                                                   signal_of(registers, REGISTERS_SIGNAL_f_hat)},
                                 .channel_count = REGISTERS_FAULT_CHANNELS,
                                 .decimation    = 1,
                                 .after         = REGISTERS_FAULT_AFTER,
                                 .trigger       = TRACE_FAULT};
    (void)trace_arm(&registers->fault_trace, &setup);
}

#define FAULT_SIGNALS                                                                                                  \
    (1u << REGISTERS_SIGNAL_r | 1u << REGISTERS_SIGNAL_y | 1u << REGISTERS_SIGNAL_u | 1u << REGISTERS_SIGNAL_f_hat)

void registers_load(registers_t *registers, const registers_board_t *board)
{
    memset(registers, 0, sizeof *registers);
    registers->board  = *board;
    registers->active = &registers->params[0];
#define DEFAULT(symbol, name, type, unit, normal, text) .symbol = (normal),
    registers->requests                                         = (registers_requests_t){REGISTERS_REQUESTS(DEFAULT)};
#undef DEFAULT
    registers->active->set = *board->defaults;
    registers->staged      = *board->defaults;
    registers->is_made     = make(registers, registers->active);
    load(registers);
}

/// Returns the most important fault: of the self-test, of wrong defaults of the board, of the store, then others.
static drive_fault_t first_fault(const registers_t *registers, drive_fault_t found)
{
    if (found >= DRIVE_FAULT_IMAGE && found < DRIVE_FAULT_PARAMS)
    {
        return found;
    }
    if (!registers->is_made)
    {
        return DRIVE_FAULT_PARAMS;
    }
    return registers->is_known || found == DRIVE_FAULT_CLOCK ? found : DRIVE_FAULT_STORE;
}

/// Initialises the memory with the first params that have a feed-forward. Learned values then outlast other methods.
static void begin_learning(registers_t *registers, const params_t *params)
{
#if DRIVE_FEEDFORWARD
    if (params->loop.params.method != NULL && !registers->is_learning)
    {
        loop_forget(&params->loop.params, &registers->memory);
        registers->is_learning = true;
    }
#else
    (void)registers;
    (void)params;
#endif
}

void registers_start(registers_t *registers, drive_fault_t found)
{
    const registers_board_t    *board  = &registers->board;
    const drive_config_t *const config = config_of(registers);
    drive_init(&registers->drive, board->port, &registers->active->drive, first_fault(registers, found));
    registers->taken = &registers->active->drive;
    renew_seal(registers);
    begin_learning(registers, registers->active);
    drive_attach(&registers->drive, &registers->memory);
    trace_init(&registers->trace, board->ring, board->ring_words);
    trace_init(&registers->fault_trace,
               registers->fault_ring,
               sizeof registers->fault_ring / sizeof registers->fault_ring[0]);
    arm_fault_trace(registers);
    modbus_init(&registers->modbus, (uint8_t)config->bus_unit, board->baud, config->period_us);
}

// --- signals -------------------------------------------------------------------------------------------------------

static const loop_force_t *signal_of(const registers_t *registers, uint32_t signal)
{
    switch (signal)
    {
#define SIGNAL(symbol, name, unit, member, text)                                                                       \
    case REGISTERS_SIGNAL_##symbol:                                                                                    \
        return &registers->member;
        REGISTERS_SIGNALS(SIGNAL)
#undef SIGNAL
    default:
        return NULL;
    }
}

/// Converts a force of the drive's arithmetic to the float on the bus.
static word_t to_bus(const registers_t *registers, word_t force)
{
    return bits_of(scaling_value(tribo_force_of_word(force), config_of(registers)->full_scale_n));
}

static word_t signal_word(const registers_t *registers, uint32_t signal)
{
    return to_bus(registers, tribo_force_word(*signal_of(registers, signal)));
}

// --- the tick ------------------------------------------------------------------------------------------------------

void registers_tick(registers_t *registers)
{
    drive_t   *drive   = &registers->drive;
    const bool was_run = drive->state == DRIVE_RUN;
    modbus_take(&registers->modbus, registers->board.line);
    drive_tick(drive);
    if (registers->taken != drive->setup)
    {
        atomic_thread_fence(memory_order_release); // the background may be on another core
        registers->taken = drive->setup;
    }
    if (registers->starts_taken != drive->starts_seen)
    {
        atomic_thread_fence(memory_order_release);
        registers->starts_taken = drive->starts_seen;
    }
    const bool is_run  = drive->state == DRIVE_RUN;
    registers->applied = is_run ? drive->signals.controller.TRIBO_N(u) : 0;
    trace_step(&registers->trace, drive->ticks, drive->state == DRIVE_FAULT);
    trace_step(&registers->fault_trace, drive->ticks, drive->state == DRIVE_FAULT);
    if (is_run && !was_run && registers->fault_trace.state == TRACE_DONE)
    {
        arm_fault_trace(registers); // the trace of the last fault is kept until the next run
    }
}

// --- where a word is ------------------------------------------------------------------------------------------------

typedef enum
{
    NOWHERE,
    STATE,
    SIGNALS,
    COMPENSATION,
    REQUESTS,
    CHANGES,
    WINDOW,
    STAGED,
    ACTIVE
} block_kind_t;

/// Blocks of 32-bit words, `at` their Modbus addresses. The active set has the blocks of the staged one.
static const struct
{
    uint16_t at, words, first; ///< `first`: number of the block's first word in a set
    uint8_t  kind;
} blocks[] = {
    {REGISTERS_STATE_AT, REGISTERS_STATE_COUNT, 0, STATE},
    {REGISTERS_SIGNALS_AT, REGISTERS_SIGNAL_COUNT, 0, SIGNALS},
    {REGISTERS_REQUESTS_AT, sizeof(registers_requests_t) / sizeof(word_t), 0, REQUESTS},
    {REGISTERS_CHANGES_AT, REGISTERS_CHANGES * sizeof(registers_change_t) / sizeof(word_t), 0, CHANGES},
    {REGISTERS_WINDOW_AT, REGISTERS_WINDOW, 0, WINDOW},
    {REGISTERS_STAGED_AT + REGISTERS_DRIVE_AT, DRIVE_CONFIG_COUNT, 0, STAGED},
    {REGISTERS_STAGED_AT + REGISTERS_LOOP_AT, PARAMS_LOOP_COUNT, PARAMS_LOOP_AT, STAGED},
    {REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, 1, PARAMS_METHOD_AT, STAGED},
#if DRIVE_FEEDFORWARD
    {REGISTERS_COMPENSATION_AT, REGISTERS_COMPENSATION_COUNT, 0, COMPENSATION},
    {REGISTERS_STAGED_AT + REGISTERS_FEED_AT, PARAMS_FEED_COUNT, PARAMS_FEED_AT, STAGED},
    {REGISTERS_STAGED_AT + REGISTERS_GUARD_AT, PARAMS_GUARD_COUNT, PARAMS_GUARD_AT, STAGED},
#endif
    {REGISTERS_STAGED_AT + REGISTERS_SECTIONS_AT, PARAMS_TABLE_AT - PARAMS_SECTIONS_AT, PARAMS_SECTIONS_AT, STAGED},
    {REGISTERS_STAGED_AT + REGISTERS_TABLE_AT, PARAMS_WORDS - PARAMS_TABLE_AT, PARAMS_TABLE_AT, STAGED}};

#define TRACE_AFTER (PARAMS_WORDS + offsetof(registers_requests_t, after) / sizeof(word_t)) ///< requests follow the set

/// Returns the Modbus address of a word of the staged set or of a request, or 0 if it has none.
static uint32_t register_of(uint32_t word)
{
    if (word >= PARAMS_WORDS)
    {
        return REGISTERS_REQUESTS_AT + 2u * (word - PARAMS_WORDS);
    }
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++)
    {
        const uint32_t offset = word - blocks[i].first;
        if (blocks[i].kind == STAGED && offset < blocks[i].words)
        {
            return blocks[i].at + 2u * offset;
        }
    }
    return 0;
}

// --- commands ------------------------------------------------------------------------------------------------------

/// Refuses another period, because the timer keeps the one that it was set up with.
static bool keeps_period(registers_t *registers, const params_set_t *next)
{
    const float is        = (float)config_of(registers)->period_us;
    const float value     = (float)next->drive.period_us;
    registers->refused    = (params_error_t){.word = DRIVE_CONFIG_period_us, .value = value, .low = is, .high = is};
    registers->is_refused = value != is;
    return !registers->is_refused;
}

/// Returns true if the drive runs, or may run at the end of the present tick or of the next one.
static bool is_started(const registers_t *registers)
{
    const uint32_t taken = registers->starts_taken;
    atomic_thread_fence(memory_order_acquire); // the state is at least as new
    return registers->drive.starts != taken || is_running(registers);
}

static uint32_t unlocked_ticks(const registers_t *registers)
{
    const uint32_t most = ticks_of(registers, REGISTERS_UNLOCK_S);
    const uint32_t gone = registers->drive.ticks - registers->unlocked_at;
    return registers->is_unlocked && gone < most ? most - gone : 0u;
}

/// Registers that protect change only at rest and unlocked.
static registers_outcome_t check_protection(registers_t *registers, const params_set_t *next)
{
    registers->is_refused = !params_protect_alike(next, &registers->active->set, &registers->refused) &&
                            (is_started(registers) || unlocked_ticks(registers) == 0u);
    return !registers->is_refused ? REGISTERS_DONE : is_started(registers) ? REGISTERS_PROTECTED : REGISTERS_LOCKED;
}

static void keep_change(registers_t *registers, uint32_t word, uint32_t from, uint32_t to)
{
    registers->changes[registers->protection_changes % REGISTERS_CHANGES] =
        (registers_change_t){.tick = registers->drive.ticks, .address = register_of(word), .from = from, .to = to};
    registers->protection_changes++;
}

static void keep_changes(registers_t *registers, const params_set_t *next)
{
    const params_set_t *is    = &registers->active->set;
    uint32_t            place = 0;
    for (uint32_t word = params_next_protecting(&place); word < PARAMS_WORDS; word = params_next_protecting(&place))
    {
        if (params_word(next, word) != params_word(is, word))
        {
            keep_change(registers, word, params_word(is, word), params_word(next, word));
        }
    }
    params_error_t turned;
    if (!params_signs_alike(next, is, &turned))
    {
        keep_change(registers, turned.word, params_word(is, turned.word), params_word(next, turned.word));
    }
}

/// Returns true if a tick with the active params has ended, so that the spare is free.
static bool is_taken(const registers_t *registers)
{
    return registers->taken == &registers->active->drive;
}

static registers_outcome_t apply(registers_t *registers)
{
    drive_t        *drive = &registers->drive;
    params_t *const next  = spare_of(registers);
    if (!is_taken(registers))
    {
        return REGISTERS_BUSY; // the tick still runs with the spare
    }
    next->set = registers->staged;
    if (bits_of(next->set.drive.sensor_zero_units) == bits_of(drive_sensor_zero_units(drive)))
    {
        next->set.drive.sensor_zero_units =
            config_of(registers)->sensor_zero_units; // the zero that a tare has moved is not a change
    }
    if (!keeps_period(registers, &next->set) || !make(registers, next))
    {
        return REGISTERS_SET_REFUSED;
    }
    const registers_outcome_t protection = check_protection(registers, &next->set);
    if (protection != REGISTERS_DONE)
    {
        return protection;
    }
    keep_changes(registers, &next->set);
    begin_learning(registers, next);
    if (next->set.drive.full_scale_n != config_of(registers)->full_scale_n)
    {
        drive_reference(drive, 0); // the old reference has the old scale
    }
    registers->active = next;
    renew_seal(registers);
    registers->is_known    = true;
    registers->modbus.unit = (uint8_t)next->set.drive.bus_unit; // the answer to this request still has the old unit
    drive_change(drive, &next->drive);
    return REGISTERS_DONE;
}

/// Makes the setup of the trace that is requested. Returns false if there is no such trace.
static bool make_trace(const registers_t *registers, trace_setup_t *made)
{
    const registers_requests_t *asked = &registers->requests;
    const uint32_t              none  = (uint32_t)TRACE_TRIGGERS;
    trace_setup_t               setup = {.decimation = asked->decimation, .after = asked->after};
    bool                        good  = asked->signals >> REGISTERS_SIGNAL_COUNT == 0u;
    setup.trigger                     = (trace_trigger_t)(asked->trigger < none ? asked->trigger : none);
    setup.watched                     = signal_of(registers, asked->watched);
    setup.level                       = good ? scaling_number(asked->level, config_of(registers)->full_scale_n) : 0;
    for (uint32_t i = 0; good && i < REGISTERS_SIGNAL_COUNT; i++)
    {
        if ((asked->signals >> i & 1u) != 0u)
        {
            good                                              = setup.channel_count < TRACE_CHANNELS_MAX;
            setup.channels[good ? setup.channel_count++ : 0u] = signal_of(registers, i);
        }
    }
    setup.channel_count = good ? setup.channel_count : 0u;
    *made               = setup;
    return trace_suits(&registers->trace, &setup);
}

bool registers_can_trace(const registers_t *registers)
{
    trace_setup_t unused;
    return make_trace(registers, &unused);
}

static registers_outcome_t arm_trace(registers_t *registers)
{
    trace_setup_t setup;
    if (!make_trace(registers, &setup) || !trace_arm(&registers->trace, &setup))
    {
        const uint32_t channels = setup.channel_count;
        const uint32_t most     = channels > 0u ? trace_capacity(&registers->trace, channels) - 1u : UINT32_MAX;
        registers->is_refused   = setup.after > most;
        registers->refused =
            (params_error_t){.word = TRACE_AFTER, .value = (float)setup.after, .low = 0.0f, .high = (float)most};
        return REGISTERS_TRACE_REFUSED;
    }
    registers->trace_signals = registers->requests.signals;
    return REGISTERS_DONE;
}

static registers_outcome_t request_if(bool possible, void (*request)(drive_t *drive), drive_t *drive)
{
    if (possible)
    {
        request(drive);
    }
    return possible ? REGISTERS_DONE : REGISTERS_WRONG_STATE;
}

static registers_outcome_t acknowledge(registers_t *registers)
{
    if (!registers->is_known)
    {
        return REGISTERS_NO_PARAMS;
    }
    return request_if(registers->drive.state == DRIVE_FAULT, drive_acknowledge, &registers->drive);
}

/// Executes a command. A stop always acts. A save only sets must_save, so that its answer goes out before the flash is busy.
static modbus_status_t execute(registers_t *registers, uint16_t command)
{
    drive_t            *drive   = &registers->drive;
    registers_outcome_t outcome = REGISTERS_DONE;
    switch (command)
    {
    case REGISTERS_START:
        outcome = request_if(drive->state == DRIVE_IDLE, drive_start, drive);
        break;
    case REGISTERS_STOP:
        drive_stop(drive);
        break;
    case REGISTERS_ACKNOWLEDGE:
        outcome = acknowledge(registers);
        break;
    case REGISTERS_TARE:
        outcome = request_if(drive->state == DRIVE_IDLE, drive_tare, drive);
        break;
    case REGISTERS_APPLY:
        outcome = apply(registers);
        break;
    case REGISTERS_REVERT:
        registers->staged    = registers->active->set;
        registers->is_staged = true;
        break;
    case REGISTERS_DEFAULTS:
        registers->staged    = *registers->board.defaults;
        registers->is_staged = true;
        break;
    case REGISTERS_SAVE:
        registers->must_save = !is_started(registers) && registers->is_known;
        outcome              = registers->must_save  ? REGISTERS_BUSY
                               : registers->is_known ? REGISTERS_WRONG_STATE
                                                     : REGISTERS_NO_PARAMS;
        break;
    case REGISTERS_TRACE:
        outcome = arm_trace(registers);
        break;
    case REGISTERS_TRACE_STOP:
        trace_stop(&registers->trace);
        break;
#if DRIVE_FEEDFORWARD
    case REGISTERS_RESTORE:
        drive_restore(drive);
        break;
    case REGISTERS_FORGET:
        outcome = request_if(!is_running(registers), drive_forget, drive);
        if (outcome == REGISTERS_DONE && registers->active->loop.params.method == NULL)
        {
            registers->is_learning =
                false; // the tick cannot forget without a feed-forward; the next params with one do
        }
        break;
#endif
    default:
        return MODBUS_ILLEGAL_VALUE;
    }
    registers->outcome  = outcome;
    const bool accepted = outcome == REGISTERS_DONE || registers->must_save;
    return accepted ? MODBUS_OK : outcome == REGISTERS_BUSY ? MODBUS_BUSY : MODBUS_FAILURE;
}

/// Saves the active set with the present zero of the sensor. The spare holds the words to write.
static void save(registers_t *registers)
{
    const store_flash_t *flash = registers->board.flash;
    params_t *const      spare = spare_of(registers);
    registers->must_save       = false;
    registers->outcome         = REGISTERS_NOT_SAVED;
    if (flash == NULL || is_started(registers))
    {
        return;
    }
    spare->set                         = registers->active->set;
    spare->set.drive.sensor_zero_units = drive_sensor_zero_units(&registers->drive);
    if (!params_check_ceilings(&spare->set,
                               registers->board.ceilings,
                               registers->board.ceiling_count,
                               &registers->refused))
    {
        registers->is_refused = true;
        registers->outcome = REGISTERS_SET_REFUSED; // several tares, each within its bound, have moved the zero too far
        return;
    }
    const bool erases = !store_holds(flash, PARAMS_LAYOUT, spare->words, PARAMS_WORDS);
    if (erases && registers->saves == REGISTERS_SAVES)
    {
        registers->outcome = REGISTERS_SAVED_OFTEN;
        return;
    }
    registers->saves += erases;
    registers->store   = store_write(flash, PARAMS_LAYOUT, spare->words, PARAMS_WORDS);
    registers->outcome = registers->store == STORE_OK ? REGISTERS_DONE : REGISTERS_NOT_SAVED;
}

static void allow_saves(registers_t *registers)
{
    const uint32_t interval = ticks_of(registers, REGISTERS_SAVE_S);
    if (registers->drive.ticks - registers->saves_at >= interval)
    {
        registers->saves_at += interval;
        registers->saves -= registers->saves > 0u;
    }
}

void registers_forget_client(registers_t *registers)
{
    registers->is_unlocked = false;
    if (registers->is_staged)
    {
        registers->staged    = registers->active->set;
        registers->is_staged = false;
    }
}

/// A serial line has no connection that ends, so a client that is silent for long counts as gone.
static void look_for_client(registers_t *registers)
{
    const uint32_t silence = ticks_of(registers, REGISTERS_CLIENT_S);
    if (registers->heard != registers->modbus.heard)
    {
        registers->heard    = registers->modbus.heard;
        registers->heard_at = registers->drive.ticks;
    }
    if (registers->drive.ticks - registers->heard_at > silence)
    {
        registers_forget_client(registers);
    }
}

bool registers_run(registers_t *registers)
{
    registers->is_unlocked = unlocked_ticks(registers) > 0u && !is_started(registers);
    drive_learn(&registers->drive);
    check_seal(registers);
    allow_saves(registers);
    const modbus_registers_t map = registers_map(registers);
    modbus_serve(&registers->modbus, registers->board.line, &map, MODBUS_MASTER);
    look_for_client(registers);
    if (!registers->must_save || !is_taken(registers) ||
        registers->modbus.answer_sent != registers->modbus.answer_length)
    {
        return false;
    }
    save(registers);
    modbus_serve(&registers->modbus, registers->board.line, &map, MODBUS_LATE);
    return true;
}

// --- reading -------------------------------------------------------------------------------------------------------

static const trace_t *shown_trace(const registers_t *registers)
{
    return registers->requests.which == 0u ? &registers->trace : &registers->fault_trace;
}

#if DRIVE_FEEDFORWARD
/// Returns the breakaway that the feed-forward has learned at the last reference.
static tribo_feedforward_learned_t learned(const registers_t *registers, uint32_t direction)
{
    const drive_t *drive = &registers->drive;
    return loop_learned(drive->setup->params, &registers->memory, direction, drive->r);
}

static word_t compensation_word(const registers_t *registers, uint32_t place)
{
    const bool is_up = place < REGISTERS_COMPENSATION_learned_down;

    const tribo_feedforward_learned_t shown =
        learned(registers, is_up ? TRIBO_BREAKAWAY_POSITIVE : TRIBO_BREAKAWAY_NEGATIVE);
    switch (place)
    {
    case REGISTERS_COMPENSATION_warnings:
        return drive_warnings(&registers->drive);
    case REGISTERS_COMPENSATION_fade:
        return bits_of(loop_share(&registers->drive.loop));
    case REGISTERS_COMPENSATION_learned_up:
    case REGISTERS_COMPENSATION_learned_down:
        return bits_of(shown.L_n);
    case REGISTERS_COMPENSATION_relative_variance_up:
    case REGISTERS_COMPENSATION_relative_variance_down:
        return bits_of(shown.relative_variance);
    case REGISTERS_COMPENSATION_travel_up:
    case REGISTERS_COMPENSATION_travel_down:
        return bits_of(shown.travel_n);
    case REGISTERS_COMPENSATION_harms:
        return shown.harms;
    case REGISTERS_COMPENSATION_forgotten:
        return shown.forgotten;
    case REGISTERS_COMPENSATION_late:
        return shown.late;
    default:
        return shown.at_bound;
    }
}
#endif

static word_t bad_inputs(const loop_state_t *loop)
{
    const TRIBO(biquad, state_t) *const cascade = &loop->controller.cascade;
    return loop->bad_inputs + TRIBO_EITHER(cascade->bad_inputs, cascade->saturated);
}

static word_t state_word(const registers_t *registers, uint32_t place)
{
    const drive_t *drive                        = &registers->drive;
    const trace_t *trace                        = shown_trace(registers);
    const bool     own                          = trace == &registers->trace;
    const word_t   words[REGISTERS_STATE_COUNT] = {
        [REGISTERS_STATE_version]               = REGISTERS_VERSION,
        [REGISTERS_STATE_layout]                = PARAMS_LAYOUT,
        [REGISTERS_STATE_q31]                   = TRIBO_IS_Q31,
        [REGISTERS_STATE_state]                 = (word_t)drive->state,
        [REGISTERS_STATE_fault]                 = (word_t)drive->fault,
        [REGISTERS_STATE_fault_tick]            = drive->fault_tick,
        [REGISTERS_STATE_tick]                  = drive->ticks,
        [REGISTERS_STATE_limits]                = drive->limits,
        [REGISTERS_STATE_max_tick_us]           = drive->max_tick_us,
        [REGISTERS_STATE_max_late_us]           = drive->max_late_us,
        [REGISTERS_STATE_overruns]              = drive->overruns,
        [REGISTERS_STATE_limited_ticks]         = drive->loop.controller.limited_ticks,
        [REGISTERS_STATE_bad_inputs]            = bad_inputs(&drive->loop),
        [REGISTERS_STATE_tare]                  = (word_t)drive->tare,
        [REGISTERS_STATE_store]                 = (word_t)registers->store,
        [REGISTERS_STATE_outcome]               = (word_t)registers->outcome,
        [REGISTERS_STATE_refused_register]      = registers->is_refused ? register_of(registers->refused.word) : 0u,
        [REGISTERS_STATE_refused_status]        = (word_t)registers->refused.status,
        [REGISTERS_STATE_refused_value]         = bits_of(registers->refused.value),
        [REGISTERS_STATE_refused_low]           = bits_of(registers->refused.low),
        [REGISTERS_STATE_refused_high]          = bits_of(registers->refused.high),
        [REGISTERS_STATE_frames]                = registers->modbus.frames,
        [REGISTERS_STATE_bad_frames]            = registers->modbus.bad_frames,
        [REGISTERS_STATE_exceptions]            = registers->modbus.exceptions,
        [REGISTERS_STATE_trace_state]           = (word_t)trace->state,
        [REGISTERS_STATE_trace_count]           = trace->count,
        [REGISTERS_STATE_trace_held]            = trace->held,
        [REGISTERS_STATE_trace_first_tick]      = trace->first_tick,
        [REGISTERS_STATE_trace_trigger]         = trace->trigger_sample,
        [REGISTERS_STATE_trace_signals_seen]    = own ? registers->trace_signals : FAULT_SIGNALS,
        [REGISTERS_STATE_trace_decimation_seen] = trace->setup.decimation,
        [REGISTERS_STATE_protection]            = registers->protection,
        [REGISTERS_STATE_protection_changes]    = registers->protection_changes,
        [REGISTERS_STATE_unlocked_ticks]        = unlocked_ticks(registers),
    };
    return words[place];
}

typedef struct
{
    block_kind_t kind;
    uint32_t     word; ///< number of the word in its block, or in its set
    bool         low;  ///< the second Modbus register of the word
} place_t;

static place_t find(uint32_t address)
{
    const bool     is_active = address >= REGISTERS_ACTIVE_AT;
    const uint32_t alike     = is_active ? address - (REGISTERS_ACTIVE_AT - REGISTERS_STAGED_AT) : address;
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++)
    {
        const uint32_t offset = alike - blocks[i].at;
        if (alike >= blocks[i].at && offset < 2u * blocks[i].words)
        {
            const block_kind_t kind = is_active ? ACTIVE : (block_kind_t)blocks[i].kind;
            return (place_t){kind, blocks[i].first + offset / 2u, offset % 2u != 0u};
        }
    }
    return (place_t){NOWHERE, 0, false};
}

static word_t word_in(const void *words, uint32_t place)
{
    word_t word;
    memcpy(&word, (const unsigned char *)words + place * sizeof word, sizeof word);
    return word;
}

/// Reads a word of the trace's window, of which only whole samples can be read.
static bool read_window(const registers_t *registers, uint32_t place, word_t *word)
{
    const trace_t *trace    = shown_trace(registers);
    const uint32_t channels = trace->setup.channel_count;
    word_t         samples[TRACE_CHANNELS_MAX];
    if (channels == 0u || !trace_read(trace, registers->requests.position + place / channels, samples, channels))
    {
        return false;
    }
    *word = to_bus(registers, samples[place % channels]);
    return true;
}

static modbus_status_t read_word(const registers_t *registers, const place_t *place, word_t *word)
{
    switch (place->kind)
    {
    case STATE:
        *word = state_word(registers, place->word);
        return MODBUS_OK;
    case SIGNALS:
        *word = signal_word(registers, place->word);
        return MODBUS_OK;
#if DRIVE_FEEDFORWARD
    case COMPENSATION:
        *word = compensation_word(registers, place->word);
        return MODBUS_OK;
#endif
    case REQUESTS:
        *word = place->word == 0u ? to_bus(registers, tribo_force_word(registers->drive.reference))
                                  : word_in(&registers->requests, place->word);
        return MODBUS_OK;
    case CHANGES:
        *word = word_in(registers->changes, place->word);
        return MODBUS_OK;
    case WINDOW:
        return read_window(registers, place->word, word) ? MODBUS_OK : MODBUS_ILLEGAL_VALUE; // no such sample
    case STAGED:
        *word = word_in(&registers->staged, place->word);
        return MODBUS_OK;
    case ACTIVE:
        *word = place->word == DRIVE_CONFIG_sensor_zero_units ? bits_of(drive_sensor_zero_units(&registers->drive))
                                                              : word_in(&registers->active->set, place->word);
        return MODBUS_OK;
    default:
        return MODBUS_ILLEGAL_ADDRESS;
    }
}

static modbus_status_t read_once(const registers_t *registers, uint16_t address, uint16_t count, uint16_t *values)
{
    for (uint32_t i = 0; i < count; i++)
    {
        const place_t         place   = find(address + i);
        const bool            command = address + i == REGISTERS_COMMAND_AT; // reads as 0
        word_t                word    = 0;
        const modbus_status_t status  = command ? MODBUS_OK : read_word(registers, &place, &word);
        if (status != MODBUS_OK)
        {
            return status;
        }
        values[i] = (uint16_t)(place.low ? word : word >> 16);
    }
    return MODBUS_OK;
}

#define READ_TRIALS 4

/// Reads registers of one tick: if a tick came in between, it reads them again.
static modbus_status_t read_registers(void *context, uint16_t address, uint16_t count, uint16_t *values)
{
    const registers_t       *registers = context;
    const volatile uint32_t *ticks     = &registers->drive.ticks;
    modbus_status_t          status    = MODBUS_OK;
    for (int trial = 0; trial < READ_TRIALS; trial++)
    {
        const uint32_t tick = *ticks;
        status              = read_once(registers, address, count, values);
        if (tick == *ticks)
        {
            break;
        }
    }
    return status;
}

// --- writing -------------------------------------------------------------------------------------------------------

/// Returns true if a word of the requests or of a set is a float.
static bool is_number(const place_t *place)
{
#define IS_FLOAT(symbol, name, type, unit, normal, text) (type)0.5 != 0,
    static const bool of_requests[] = {REGISTERS_REQUESTS(IS_FLOAT)};
#undef IS_FLOAT
    return place->kind == STAGED ? params_is_number(place->word) : place->kind == REQUESTS && of_requests[place->word];
}

#define SIGN 0x80000000u

static bool is_within(word_t bits, float most)
{
    return (bits & ~SIGN) <= bits_of(most);
}

/// Accepts a number that a client can mean, and makes -0 to 0. A tiny number comes from swapped words or bytes, or from an
/// integer.
static bool take_number(const place_t *place, word_t *word)
{
    if (!is_number(place))
    {
        return true;
    }
    *word = *word == SIGN ? 0u : *word;
    return place->kind == STAGED ? params_is_meant(*word, params_least(place->word))
                                 : params_is_meant(*word, PARAMS_LEAST_N) && is_within(*word, PARAMS_MOST_N);
}

static bool take_reference(registers_t *registers, word_t word, bool only_check)
{
    float       r;
    const float most = params_number(&registers->active->set, PARAMS_INPUT_MAX);
    memcpy(&r, &word, sizeof r);
    if (registers->board.has_reference || !(r >= -most && r <= most))
    {
        return false;
    }
    if (!only_check)
    {
        drive_reference(&registers->drive, scaling_number(r, config_of(registers)->full_scale_n));
    }
    return true;
}

static bool unlock(registers_t *registers, word_t key, bool only_check)
{
    const bool fits = key == 0u || (key == REGISTERS_KEY && !is_started(registers));
    if (!only_check || !fits)
    {
        registers->is_unlocked = fits && key == REGISTERS_KEY;
        registers->unlocked_at = registers->drive.ticks;
    }
    return fits;
}

static modbus_status_t write_word(registers_t *registers, const place_t *place, word_t word, bool only_check)
{
    void *words = NULL;
    if (!take_number(place, &word))
    {
        return MODBUS_ILLEGAL_VALUE;
    }
    switch (place->kind)
    {
    case REQUESTS:
        if (place->word == 0u)
        {
            return take_reference(registers, word, only_check) ? MODBUS_OK : MODBUS_ILLEGAL_VALUE;
        }
        if (place->word == offsetof(registers_requests_t, position_reference) / sizeof word && !only_check)
        {
            drive_position_reference(&registers->drive, (int32_t)word);
        }
        if (place->word == offsetof(registers_requests_t, unlock) / sizeof word)
        {
            return unlock(registers, word, only_check) ? MODBUS_OK : MODBUS_ILLEGAL_VALUE;
        }
        words = &registers->requests;
        break;
    case STAGED:
        words = &registers->staged;
        break;
    default:
        return MODBUS_ILLEGAL_ADDRESS;
    }
    if (!only_check)
    {
        registers->is_staged = registers->is_staged || words == &registers->staged;
        memcpy((unsigned char *)words + place->word * sizeof word, &word, sizeof word);
    }
    return MODBUS_OK;
}

static modbus_status_t write_words(registers_t    *registers,
                                   uint16_t        address,
                                   uint16_t        count,
                                   const uint16_t *values,
                                   bool            only_check)
{
    for (uint32_t i = 0; i < count; i += 2u)
    {
        const place_t place = find(address + i);
        const word_t  word  = (word_t)values[i] << 16 | (i + 1u < count ? values[i + 1u] : 0u);
        if (place.low || i + 1u >= count)
        {
            return MODBUS_ILLEGAL_ADDRESS; // half a register
        }
        const modbus_status_t status = write_word(registers, &place, word, only_check);
        if (status != MODBUS_OK)
        {
            return status;
        }
    }
    return MODBUS_OK;
}

/// Stops the drive for a source that may only stop. The outcome remains that of the client's last command.
static modbus_status_t stop_drive(void *context, uint16_t address, uint16_t count, const uint16_t *values)
{
    registers_t *registers = context;
    const bool   is_stop   = address == REGISTERS_COMMAND_AT && count == 1u && values[0] == REGISTERS_STOP;
    if (is_stop)
    {
        drive_stop(&registers->drive);
    }
    return is_stop ? MODBUS_OK : MODBUS_BUSY;
}

static modbus_status_t write_registers(void *context, uint16_t address, uint16_t count, const uint16_t *values)
{
    registers_t *registers = context;
    registers->heard_at    = registers->drive.ticks;
    if (registers->must_save)
    {
        return stop_drive(context, address, count, values);
    }
    if (address == REGISTERS_COMMAND_AT && count == 1u)
    {
        return execute(registers, values[0]);
    }
    const modbus_status_t status = write_words(registers, address, count, values, true);
    return status == MODBUS_OK ? write_words(registers, address, count, values, false) : status;
}

modbus_registers_t registers_map(registers_t *registers)
{
    return (
        modbus_registers_t){.context = registers, .read = read_registers, .write = write_registers, .stop = stop_drive};
}
