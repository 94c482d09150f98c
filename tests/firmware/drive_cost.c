// What the drive's tick costs in RUN, in instructions of an emulated processor, by part: "name value" a line. The sensor follows
// the arm that the loop commands by the paper's method, without the guard, in a triangle of 0.4 to 0.6 N, with every bound of the
// faults on. On the bus bytes come as fast as 115,200 baud brings them, and beside the trace for faults one of eight signals
// records every tick and waits for a level.
//
//     drive        the loop, and what decides whether it may run
//     bus          bytes copied from the line
//     trace, fault_trace
//     tick         the whole handler: these, and calling them

#include "../target/counter.h"
#include "app/registers.h"
#include "board.h"

#include <stdio.h>
#include <string.h>

#define TICKS 4000

COUNTED(int, counted_all, (registers_t * registers), (registers_tick(registers), 0))
COUNTED(int, counted_drive, (drive_t * drive), (drive_tick(drive), 0))
COUNTED(int, counted_bus, (modbus_t * modbus, const modbus_line_t *line), (modbus_take(modbus, line), 0))
COUNTED(int, counted_trace, (trace_t * trace, uint32_t tick), (trace_step(trace, tick, false), 0))
COUNTED(loop_force_t,
        counted_loop,
        (const loop_params_t *params, loop_state_t *state, loop_force_t r, loop_force_t y, loop_signals_t *signals),
        TRIBO(force_loop, step)(params, state, r, y, signals))

#define TICK_BYTES 12 // of 1 ms

/// Three ticks of bytes, then silence.
static int receive(void *context, uint8_t *bytes, size_t room)
{
    const registers_t *registers = context;
    if (room < TICK_BYTES || registers->drive.ticks % 8u > 2u)
    {
        return 0;
    }
    memset(bytes, 1, TICK_BYTES);
    return TICK_BYTES;
}

static size_t send(void *context, const uint8_t *bytes, size_t count)
{
    (void)context;
    (void)bytes;
    return count;
}

static registers_t registers;
static drive_t     copy;
static board_t     board;

static void print(const char *name, const counts_t *c)
{
    printf("%s.drive.%s.min %lu\n", TRIBO_ARITHMETIC, name, (unsigned long)c->min);
    printf("%s.drive.%s.mean %lu\n", TRIBO_ARITHMETIC, name, (unsigned long)(c->sum / c->calls));
    printf("%s.drive.%s.max %lu\n", TRIBO_ARITHMETIC, name, (unsigned long)c->max);
}

int main(void)
{
    static const modbus_line_t line = {.context = &registers, .receive = receive, .send = send};
    static uint32_t            ring[800];
    static params_set_t        defaults;
    static modbus_t            bus_copy;
    static trace_t             trace_copy;

    defaults                    = params_default();
    defaults.method             = PARAMS_METHOD_PAPER;
    defaults.guard_on           = 0;
    defaults.drive.stuck_ticks  = 200;
    defaults.drive.reference_ms = 50;
    defaults.drive.ready_ms     = 50;
    board_init(&board, 0);
    const registers_board_t parts =
        {.port = &board.port, .line = &line, .defaults = &defaults, .baud = 115200, .ring = ring, .ring_words = 800};
    registers_load(&registers, &parts);
    registers_start(&registers, DRIVE_FAULT_NONE);
    counter_init();

    counts_t all = {0}, drive = {0}, loop = {0}, bus = {0}, trace = {0}, fault_trace = {0};
    registers.requests.signals         = 0xffu;
    registers.requests.trigger         = TRACE_RISE;
    registers.requests.level           = 1.0f;
    registers.requests.after           = 20;
    const modbus_registers_t map       = registers_map(&registers);
    const uint16_t           arm_trace = REGISTERS_TRACE;
    if (map.write(map.context, REGISTERS_COMMAND_AT, 1, &arm_trace) != MODBUS_OK)
    {
        return 1;
    }
    double shown_n = 0.0;
    drive_start(&registers.drive);
    for (int k = 0; k < TICKS; k++)
    {
        const double phase = k % 2000 / 1000.0;
        const double r_n   = 0.4 + 0.2 * (phase < 1.0 ? phase : 2.0 - phase);
        board_new_tick(&board);
        board.now_us = (uint32_t)k * 1000u;
        board.y      = board_force(shown_n + 1e-4 * (k % 3));
        drive_reference(&registers.drive, board_force(r_n));
        copy                         = registers.drive;
        const board_t        before  = board;
        loop_state_t         state   = copy.loop;
        const bool           ran     = copy.state == DRIVE_RUN;
        const drive_setup_t *used    = copy.setup;
        loop_signals_t       signals = copy.signals;
        const loop_force_t   r       = copy.reference;
        (void)counted_drive(&copy);
        if (ran)
        {
            counts_add(&drive);
            (void)counted_loop(used->params, &state, r, copy.y, &signals);
            counts_add(&loop);
        }
        board      = before;
        bus_copy   = registers.modbus;
        trace_copy = registers.trace; // which writes the same words into the ring as the handler will
        (void)counted_bus(&bus_copy, &line);
        counts_add(&bus);
        (void)counted_trace(&trace_copy, copy.ticks);
        counts_add(&trace);
        trace_copy = registers.fault_trace;
        (void)counted_trace(&trace_copy, copy.ticks);
        counts_add(&fault_trace);
        (void)counted_all(&registers);
        if (ran)
        {
            counts_add(&all);
        }
        registers_run(&registers);
        if (registers.drive.state == DRIVE_FAULT)
        {
            printf("the drive stopped: %s\n", drive_fault_text(registers.drive.fault));
            return 1;
        }
        const double f_hat_n = tribo_force_q31(registers.drive.signals.compensator.TRIBO_N(force), BOARD_FULL_SCALE_N) /
                               2147483648.0 * 4.0;
        shown_n += 0.0535 * (f_hat_n - shown_n);
    }
    print("loop", &loop);
    print("and_loop", &drive);
    print("bus", &bus);
    print("trace", &trace);
    print("fault_trace", &fault_trace);
    print("everything", &all);
    return 0;
}
