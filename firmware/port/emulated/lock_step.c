// The drive in lock-step. The host simulates plant, sensor, power stage, fault inputs and clock; each TICK message replaces a
// timer interrupt. The application is the same as on a board.

#include "lock_step.h"

#include "app/registers.h"
#include "app/selftest.h"
#include "link.h"

#include <string.h>

#define RAM_TESTED_MAX (64u * 1024u) // bytes; a machine may have megabytes

typedef struct
{
    uint32_t     tick[TRIBO_TICK_WORDS]; ///< the message of this tick
    uint32_t     clock_reads;
    loop_force_t command;
    bool         enabled;
} board_t;

static bool read_sensor(void *context, loop_force_t *reading)
{
    const board_t *board = context;
    *reading             = tribo_force_of_word(board->tick[TRIBO_TICK_Y]);
    return board->tick[TRIBO_TICK_SILENT] == 0u;
}

static void command(void *context, loop_force_t output)
{
    board_t *board = context;
    board->command = output;
}

static void enable(void *context, bool on)
{
    board_t *board = context;
    board->enabled = on;
}

static uint32_t inputs(void *context)
{
    const board_t *board = context;
    return board->tick[TRIBO_TICK_INPUTS];
}

/// Returns the time: the first call in a tick is at its start, later ones at its end.
static uint32_t time_us(void *context)
{
    board_t *board = context;
    return board->tick[board->clock_reads++ == 0u ? TRIBO_TICK_START_US : TRIBO_TICK_END_US];
}

static void log_byte(void *context, uint8_t byte)
{
    (void)context;
    link_log(byte);
}

/// The host has already scaled sensor and output, so they are in N; `ranges` are set with the full scale.
static board_t board;
static port_t  port = {.context     = &board,
                       .read_sensor = read_sensor,
                       .command     = command,
                       .enable      = enable,
                       .inputs      = inputs,
                       .time_us     = time_us,
                       .log_byte    = log_byte};

/// The host gives the params and the reference, so there is no bus.
// NOLINTNEXTLINE(readability-non-const-parameter): the type is that of a modbus_line_t's member
static int receive_nothing(void *context, uint8_t *bytes, size_t room)
{
    (void)context;
    (void)bytes;
    (void)room;
    return 0;
}

static const modbus_line_t silent = {.receive = receive_nothing};

// --- lock-step -----------------------------------------------------------------------------------------------------

static link_cycles_t cycles;

static void count_cycles(uint32_t taken)
{
    cycles.least = cycles.ticks == 0u || taken < cycles.least ? taken : cycles.least;
    cycles.most  = taken > cycles.most ? taken : cycles.most;
    cycles.sum += taken;
    cycles.ticks++;
}

static void tick(registers_t *registers, const uint32_t *words)
{
    drive_t *drive = &registers->drive;
    memcpy(board.tick, words, sizeof board.tick);
    board.clock_reads = 0;
    if ((words[TRIBO_TICK_REQUESTS] & TRIBO_REQUEST_START) != 0u)
    {
        drive_start(drive);
    }
    if ((words[TRIBO_TICK_REQUESTS] & TRIBO_REQUEST_STOP) != 0u)
    {
        drive_stop(drive);
    }
    if ((words[TRIBO_TICK_REQUESTS] & TRIBO_REQUEST_ACKNOWLEDGE) != 0u)
    {
        drive_acknowledge(drive);
    }
    drive_reference(drive, tribo_force_of_word(words[TRIBO_TICK_R]));
    const uint32_t start = link_cycles();
    registers_tick(registers);
    count_cycles(link_cycles() - start);
    registers_run(registers);
}

static bool answer(const drive_t *drive)
{
    uint32_t tock[TRIBO_TOCK_WORDS];
    tock[TRIBO_TOCK_COMMAND]       = tribo_force_word(board.command);
    tock[TRIBO_TOCK_ENABLED]       = board.enabled;
    tock[TRIBO_TOCK_STATE]         = (uint32_t)drive->state;
    tock[TRIBO_TOCK_FAULT]         = (uint32_t)drive->fault;
    tock[TRIBO_TOCK_LIMITS]        = drive->limits;
    tock[TRIBO_TOCK_LIMITED_TICKS] = drive->loop.controller.limited_ticks;
    tock[TRIBO_TOCK_BAD_INPUTS]    = drive->loop.bad_inputs;
#if DRIVE_FEEDFORWARD
    tock[TRIBO_TOCK_GUARD] = (uint32_t)drive->loop.guard.cause;
#else
    tock[TRIBO_TOCK_GUARD] = (uint32_t)TRIBO_GUARD_NONE;
#endif
    tribo_signal_words(&drive->signals, tock + TRIBO_TOCK_SIGNALS);
    return link_send(TRIBO_WIRE_TOCK, tock, TRIBO_TOCK_WORDS);
}

/// Makes the drive's config. The rig's faults are off, because a scenario's plant is often faulty on purpose.
static params_set_t set_of(const tribo_setup_t *setup)
{
    params_set_t set           = params_default();
    set.drive.period_us        = setup->period_us;
    set.drive.late_us          = setup->late_us;
    set.drive.budget_us        = setup->budget_us;
    set.drive.stuck_ticks      = setup->stuck_ticks;
    set.drive.full_scale_n     = setup->full_scale_n;
    set.drive.residual_n       = 0.0f;
    set.drive.tracking_n       = 0.0f;
    set.drive.command_limit_ms = 0;
    set.drive.swing_ms         = 0;
    set.drive.reference_ms     = 0;
    params_take_loop(&set, &setup->loop);
    return set;
}

#define RING_WORDS 800u // the smallest machine has 32 KiB

static int serve(drive_fault_t found)
{
    static registers_t   registers;
    static params_set_t  defaults;
    static tribo_setup_t setup;
    static uint32_t      words[TRIBO_WIRE_WORDS_MAX];
    static uint32_t      ring[RING_WORDS];

    uint32_t kind;
    uint32_t count;
    if (!link_receive(&kind, words, &count) || kind != TRIBO_WIRE_SETUP || count != TRIBO_SETUP_WORDS)
    {
        return 3;
    }
    cycles = (link_cycles_t){0};
    tribo_setup_from_words(&setup, words);
    port.sensor.full_units = port.output.full_units = setup.full_scale_n;
    defaults                                        = set_of(&setup);
    const registers_board_t parts =
        {.port = &port, .line = &silent, .defaults = &defaults, .baud = 115200, .ring = ring, .ring_words = RING_WORDS};
    registers_load(&registers, &parts);
    registers_start(&registers, found);
    const uint32_t status = registers.is_refused ? (uint32_t)registers.refused.status : (uint32_t)TRIBO_OK;
    bool           ok     = link_send(TRIBO_WIRE_READY, &status, TRIBO_READY_WORDS);
    while (ok && link_receive(&kind, words, &count))
    {
        if (kind == TRIBO_WIRE_END)
        {
            link_close(&cycles);
            return 0;
        }
        if (kind != TRIBO_WIRE_TICK || count != TRIBO_TICK_WORDS)
        {
            return 4;
        }
        tick(&registers, words);
        drive_log(&registers.drive); // comes before the answer, after which the host may end this program
        ok = answer(&registers.drive);
    }
    return 5;
}

int lock_step(void)
{
    if (!link_open())
    {
        return 2;
    }
    const drive_fault_t found = selftest_run(&selftest_seal, NULL, link_ram(), RAM_TESTED_MAX);

    const uint32_t hello[TRIBO_HELLO_WORDS] = {[TRIBO_HELLO_VERSION] = TRIBO_WIRE_VERSION,
                                               [TRIBO_HELLO_Q31]     = TRIBO_IS_Q31,
                                               [TRIBO_HELLO_FAULT]   = (uint32_t)found};
    return link_send(TRIBO_WIRE_HELLO, hello, TRIBO_HELLO_WORDS) ? serve(found) : 3;
}
