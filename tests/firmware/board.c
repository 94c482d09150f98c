#include "board.h"

static bool read_sensor(void *context, loop_force_t *reading)
{
    const board_t *board = context;
    *reading             = board->y;
    return !board->silent;
}

static void command(void *context, loop_force_t output)
{
    board_t *board         = context;
    board->moved_while_off = board->moved_while_off || (!board->enabled && output != 0);
    board->command         = output;
    board->commands++;
}

static void enable(void *context, bool on)
{
    board_t *board  = context;
    board->off_late = board->off_late || (!on && board->enabled && board->commands > 0u);
    board->enabled  = on;
}

static uint32_t inputs(void *context)
{
    const board_t *board = context;
    return board->inputs;
}

static void measure(void *context, port_measured_t *measured)
{
    const board_t *board = context;
    *measured            = board->measured;
}

static uint32_t time_us(void *context)
{
    board_t *board = context;
    return board->now_us + (board->clock_reads++ == 0u ? 0u : board->tick_us);
}

static void log_byte(void *context, uint8_t byte)
{
    board_t *board = context;
    if (board->log_length + 1u < BOARD_LOG_SIZE)
    {
        board->log[board->log_length++] = (char)byte;
        board->log[board->log_length]   = '\0';
    }
}

void board_init(board_t *board, uint32_t now_us)
{
    *board      = (board_t){.now_us   = now_us,
                            .tick_us  = 20,
                            .measured = {.bus_mv = 24000, .temperature_mc = 25000},
                            .command  = board_force(1.0),
                            .enabled  = true};
    board->port = (port_t){.context     = board,
                           .sensor      = {.full_units = BOARD_FULL_SCALE_N},
                           .output      = {.full_units = BOARD_FULL_SCALE_N},
                           .measures    = PORT_MEASURES_CURRENT | PORT_MEASURES_BUS | PORT_MEASURES_TEMPERATURE,
                           .measure     = measure,
                           .read_sensor = read_sensor,
                           .command     = command,
                           .enable      = enable,
                           .inputs      = inputs,
                           .time_us     = time_us,
                           .log_byte    = log_byte};
}

loop_force_t board_force(double force_n)
{
    return tribo_force_of_q31((int32_t)(force_n / (double)BOARD_FULL_SCALE_N * 2147483647.0), BOARD_FULL_SCALE_N);
}

void board_new_tick(board_t *board)
{
    board->clock_reads = 0;
    board->commands    = 0;
}

// NOLINTNEXTLINE(readability-non-const-parameter): a modbus_line_t's
int board_receive_nothing(void *context, uint8_t *bytes, size_t room)
{
    (void)context;
    (void)bytes;
    (void)room;
    return 0;
}
