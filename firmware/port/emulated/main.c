// The drive in an emulator, one port for every machine: the host, which has the plant, is the sensor, the power stage, the
// inputs and the clock. A message is a timer interrupt. Nothing of the application knows.

#include "app/drive.h"
#include "app/loop_setup.h"
#include "app/selftest.h"
#include "link.h"

#include <semihost.h>
#include <string.h>

typedef struct
{
    uint32_t     tick[TRIBO_TICK_WORDS]; ///< the message of this tick
    uint32_t     clock_reads;
    loop_force_t command;
    bool         enabled;
} board_t;

static bool read_force(void *context, loop_force_t *y)
{
    const board_t *board = context;
    *y                   = loop_from_word(board->tick[TRIBO_TICK_Y]);
    return board->tick[TRIBO_TICK_SILENT] == 0u;
}

static void command(void *context, loop_force_t u)
{
    board_t *board = context;
    board->command = u;
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

/// The first look in a tick is at its start, the others at its end.
static uint32_t time_us(void *context)
{
    board_t *board = context;
    return board->tick[board->clock_reads++ == 0u ? TRIBO_TICK_START_US : TRIBO_TICK_END_US];
}

static void log_byte(void *context, uint8_t byte)
{
    (void)context;
    (void)sys_semihost_putc((char)byte, NULL);
}

static board_t      board;
static const port_t port = {.context    = &board,
                            .read_force = read_force,
                            .command    = command,
                            .enable     = enable,
                            .inputs     = inputs,
                            .time_us    = time_us,
                            .log_byte   = log_byte};

// --- self-test -----------------------------------------------------------------------------------------------------

extern uint32_t __data_start[], __stack[];

#define STACK_IN_USE   512u          // bytes below this frame that the test itself may take
#define RAM_TESTED_MAX (64u * 1024u) // of the machine's RAM, which may be megabytes

static drive_fault_t self_test(void)
{
    const uintptr_t     start = (uintptr_t)__data_start;
    const uintptr_t     end   = (uintptr_t)__builtin_frame_address(0) - STACK_IN_USE;
    const size_t        size  = end - start < RAM_TESTED_MAX ? end - start : RAM_TESTED_MAX;
    const drive_fault_t image = selftest_image(&selftest_seal, NULL);
    if (image != DRIVE_FAULT_NONE)
    {
        return image;
    }
    const drive_fault_t ram = selftest_ram(&selftest_ram_real, __data_start, size / sizeof(uint32_t));
    return ram != DRIVE_FAULT_NONE ? ram : selftest_golden();
}

// --- set-up --------------------------------------------------------------------------------------------------------

static float number(const uint32_t *words, uint32_t place)
{
    float x;
    memcpy(&x, words + place, sizeof x);
    return x;
}

static tribo_status_t set_up(loop_setup_t *setup, const uint32_t *words)
{
    static tribo_biquad_f32_section_t  sections[TRIBO_BIQUAD_SECTIONS_MAX];
    static tribo_breakaway_point_f32_t table[TRIBO_BREAKAWAY_POINTS_MAX];
    for (uint32_t i = 0; i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        const uint32_t *section = words + TRIBO_SETUP_SECTIONS + 5 * i;
        sections[i]             = (tribo_biquad_f32_section_t){.b0 = number(section, 0),
                                                               .b1 = number(section, 1),
                                                               .b2 = number(section, 2),
                                                               .a1 = number(section, 3),
                                                               .a2 = number(section, 4)};
    }
    for (uint32_t i = 0; i < TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
        const uint32_t *point = words + TRIBO_SETUP_POINTS + 3 * i;
        table[i]              = (tribo_breakaway_point_f32_t){.force_n    = number(point, 0),
                                                              .positive_n = number(point, 1),
                                                              .negative_n = number(point, 2)};
    }
    const tribo_force_loop_f32_config_t config = {
        .sample_time_s = number(words, TRIBO_SETUP_SAMPLE_TIME),
        .input_max_n   = number(words, TRIBO_SETUP_INPUT_MAX),
        .gain          = number(words, TRIBO_SETUP_GAIN),
        .controller    = {.sections      = sections,
                          .section_count = words[TRIBO_SETUP_SECTION_COUNT],
                          .u_min_n       = number(words, TRIBO_SETUP_U_MIN),
                          .u_max_n       = number(words, TRIBO_SETUP_U_MAX)},
        .compensator   = {.friction = {.k_min         = number(words, TRIBO_SETUP_K_MIN),
                                       .k_max         = number(words, TRIBO_SETUP_K_MAX),
                                       .m             = number(words, TRIBO_SETUP_M),
                                       .v0_n_per_s    = number(words, TRIBO_SETUP_V0),
                                       .positive      = {.offset_n = number(words, TRIBO_SETUP_POSITIVE_OFFSET),
                                                         .slope    = number(words, TRIBO_SETUP_POSITIVE_SLOPE)},
                                       .negative      = {.offset_n = number(words, TRIBO_SETUP_NEGATIVE_OFFSET),
                                                         .slope    = number(words, TRIBO_SETUP_NEGATIVE_SLOPE)},
                                       .table         = words[TRIBO_SETUP_POINT_COUNT] > 0u ? table : NULL,
                                       .table_length  = words[TRIBO_SETUP_POINT_COUNT],
                                       .set_level     = number(words, TRIBO_SETUP_SET_LEVEL),
                                       .reset_level   = number(words, TRIBO_SETUP_RESET_LEVEL),
                                       .pulse_width_s = number(words, TRIBO_SETUP_PULSE_WIDTH),
                                       .gravity_n     = number(words, TRIBO_SETUP_GRAVITY)},
                          .arm      = {.inertia   = number(words, TRIBO_SETUP_INERTIA),
                                       .damping   = number(words, TRIBO_SETUP_DAMPING),
                                       .stiffness = number(words, TRIBO_SETUP_STIFFNESS)}}};
    return loop_setup(setup, &config, number(words, TRIBO_SETUP_FULL_SCALE));
}

// --- lock-step -----------------------------------------------------------------------------------------------------

static void tick(drive_t *drive, const uint32_t *words)
{
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
    drive_tick(drive, loop_from_word(words[TRIBO_TICK_R]));
}

static bool answer(const drive_t *drive)
{
    uint32_t tock[TRIBO_TOCK_WORDS];
    tock[TRIBO_TOCK_COMMAND]       = loop_word(board.command);
    tock[TRIBO_TOCK_ENABLED]       = board.enabled;
    tock[TRIBO_TOCK_STATE]         = (uint32_t)drive->state;
    tock[TRIBO_TOCK_FAULT]         = (uint32_t)drive->fault;
    tock[TRIBO_TOCK_LIMITS]        = drive->limits;
    tock[TRIBO_TOCK_LIMITED_TICKS] = loop_limited_ticks(&drive->loop);
    tock[TRIBO_TOCK_BAD_INPUTS]    = loop_bad_inputs(&drive->loop);
    loop_words(&drive->signals, tock + TRIBO_TOCK_LOOP);
    return link_send(TRIBO_WIRE_TOCK, tock, TRIBO_TOCK_WORDS);
}

/// Returns the program's exit status.
static int serve(drive_fault_t found)
{
    static drive_t      drive;
    static loop_setup_t setup;
    static uint32_t     words[TRIBO_WIRE_WORDS_MAX];

    uint32_t kind;
    uint32_t count;
    if (!link_receive(&kind, words, &count) || kind != TRIBO_WIRE_SETUP || count != TRIBO_SETUP_WORDS)
    {
        return 3;
    }
    const drive_config_t config = {.period_us   = words[TRIBO_SETUP_PERIOD_US],
                                   .late_us     = words[TRIBO_SETUP_LATE_US],
                                   .budget_us   = words[TRIBO_SETUP_BUDGET_US],
                                   .stuck_ticks = words[TRIBO_SETUP_STUCK_TICKS]};
    const uint32_t       status = (uint32_t)set_up(&setup, words);
    if (found == DRIVE_FAULT_NONE && status != TRIBO_OK)
    {
        found = DRIVE_FAULT_PARAMS;
    }
    drive_init(&drive, &port, &setup.params, &config, found);
    bool ok = link_send(TRIBO_WIRE_READY, &status, TRIBO_READY_WORDS);
    while (ok && link_receive(&kind, words, &count))
    {
        if (kind == TRIBO_WIRE_END)
        {
            return 0;
        }
        if (kind != TRIBO_WIRE_TICK || count != TRIBO_TICK_WORDS)
        {
            return 4;
        }
        tick(&drive, words);
        drive_log(&drive); // before the answer, after which the host may end this
        ok = answer(&drive);
    }
    return 5;
}

int main(void)
{
    if (!link_open())
    {
        return 2;
    }
    const drive_fault_t found                    = self_test();
    const uint32_t      hello[TRIBO_HELLO_WORDS] = {TRIBO_WIRE_VERSION, loop_arithmetic()[0] == 'q', (uint32_t)found};
    return link_send(TRIBO_WIRE_HELLO, hello, TRIBO_HELLO_WORDS) ? serve(found) : 3;
}
