// The board's outputs on devices that this file plays: what is turned off first, and what a power stage that does not do as it is
// told costs. Devices and lines are in memory that both processes see.

#include "board.h"

#include "realtime.h"
#include "supervisor.h"
#include "unity.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define MS INT64_C(1000000)

static struct
{
    atomic_int   level[LINE_COUNT];
    atomic_int   reads_high;                  ///< enable, -1: as it was set, -2: the chip does not read outputs
    atomic_int   edges;                       ///< of the heartbeat
    atomic_int   order, enable_at, output_at; ///< of the last time that enable went off, and of the output's last write
    atomic_int   block_ms;                    ///< of the output's driver
    atomic_llong killed_ns, off_ns, output_ns; ///< off_ns: enable went off
    atomic_bool  in_output;
} *seen;

static rig_t   rig;
static board_t board;
static drive_t drive;

static drive_setup_t setup;
static float         shown[RIG_MEASURED]; ///< by the power stage, in units; NaN: it cannot be read

// --- devices -------------------------------------------------------------------------------------------------------

lines_t *lines_open(const line_config_t config[LINE_COUNT], const char *consumer, common_error_t *error)
{
    (void)config;
    (void)consumer;
    (void)error;
    return (lines_t *)seen;
}

void lines_close(lines_t *lines)
{
    (void)lines;
}

bool lines_set(lines_t *lines, line_t output, bool high)
{
    (void)lines;
    if (output == LINE_ENABLE && !high)
    {
        atomic_store(&seen->off_ns, realtime_now_ns());
        atomic_store(&seen->enable_at, atomic_fetch_add(&seen->order, 1));
    }
    seen->edges += output == LINE_HEARTBEAT && (atomic_load(&seen->level[output]) != 0) != high;
    atomic_store(&seen->level[output], high);
    return true;
}

bool lines_read_back(lines_t *lines, line_t output, bool *high)
{
    (void)lines;
    const int reads = atomic_load(&seen->reads_high);
    *high           = reads == -1 ? atomic_load(&seen->level[output]) != 0 : reads == 1;
    return reads != -2;
}

bool lines_seen(lines_t *lines, line_t input, bool *high, bool *low)
{
    (void)lines;
    *high = atomic_load(&seen->level[input]) != 0;
    *low  = !*high;
    return true;
}

bool pwm_open(pwm_t *pwm, const pwm_config_t *config, float idle, const char *key, common_error_t *error)
{
    (void)pwm;
    (void)config;
    (void)idle;
    (void)key;
    (void)error;
    return true;
}

void pwm_close(pwm_t *pwm)
{
    (void)pwm;
}

bool pwm_write(const pwm_t *pwm, float duty)
{
    (void)pwm;
    (void)duty;
    atomic_store(&seen->output_at, atomic_fetch_add(&seen->order, 1));
    atomic_store(&seen->in_output, true);
    const int64_t end_ns = realtime_now_ns() + atomic_load(&seen->block_ms) * MS;
    while (realtime_now_ns() < end_ns)
    {
        (void)realtime_sleep_until(end_ns);
    }
    atomic_store(&seen->in_output, false);
    atomic_store(&seen->output_ns, realtime_now_ns());
    return true;
}

bool channel_open(channel_t              *channel,
                  const channel_config_t *config,
                  bool                    is_output,
                  const char             *key,
                  common_error_t         *error)
{
    (void)channel;
    (void)config;
    (void)is_output;
    (void)key;
    (void)error;
    return true;
}

void channel_close(channel_t *channel)
{
    (void)channel;
}

bool channel_read(const channel_t *channel, float *value)
{
    const ptrdiff_t i           = channel - board.measured;
    const bool      is_measured = i >= 0 && i < RIG_MEASURED;
    *value                      = is_measured ? shown[i] : 0.0f;
    return !is_measured || !isnan(shown[i]);
}

bool channel_write(const channel_t *channel, float value)
{
    (void)channel;
    (void)value;
    return true;
}

// --- a board -------------------------------------------------------------------------------------------------------

static common_error_t error;

void setUp(void)
{
    seen = mmap(NULL, sizeof *seen, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    TEST_ASSERT_TRUE(seen != MAP_FAILED);
    atomic_store(&seen->reads_high, -1);
    error = (common_error_t){""};
    setup = (drive_setup_t){.config = drive_config_default()};
    drive = (drive_t){.state = DRIVE_IDLE, .setup = &setup};
    rig   = (rig_t){.output          = RIG_OUTPUT_PWM,
                    .drive           = drive_config_default(),
                    .lines           = {[LINE_ENABLE] = {.name = "enable"}},
                    .heartbeat_ticks = 1,
                    .read_back       = 1,
                    .ready_off_ms    = 20};
}

void tearDown(void)
{
    board_close(&board);
    (void)munmap(seen, sizeof *seen);
}

static bool open_board(void)
{
    return board_open(&board, &rig, NULL, NULL, &error);
}

static uint32_t inputs(void)
{
    return board.port.inputs(board.port.context);
}

static void enable(bool on)
{
    board.port.enable(board.port.context, on);
}

/// Measures until each quantity has had its turn.
static port_measured_t measure(void)
{
    port_measured_t measured = {0};
    for (unsigned i = 0; i < RIG_MEASURED; i++)
    {
        board.port.measure(board.port.context, &measured);
    }
    return measured;
}

static void test_the_power_stages_channels_are_read_in_turn(void)
{
    rig.measured[RIG_CURRENT]     = (rig_measure_t){{"adc", "voltage1"}, 5e-3, 1650.0}; // mV
    rig.measured[RIG_TEMPERATURE] = (rig_measure_t){{"ntc", "temp"}, 1e-3, 0.0};
    shown[RIG_CURRENT]            = 1250.0f;
    shown[RIG_SUPPLY]             = 1.0f;
    shown[RIG_TEMPERATURE]        = 61500.0f;
    TEST_ASSERT_TRUE(open_board());
    TEST_ASSERT_EQUAL_UINT32(PORT_MEASURES_CURRENT | PORT_MEASURES_TEMPERATURE, board.port.measures);
    port_measured_t is;
    board.port.measure(board.port.context, &is); // has all from the start
    TEST_ASSERT_EQUAL_INT32(-2000, is.current_ma);
    TEST_ASSERT_EQUAL_INT32(61500, is.temperature_mc);
    TEST_ASSERT_EQUAL_INT32(0, is.bus_mv); // there is none
    shown[RIG_CURRENT]     = 1850.0f;
    shown[RIG_TEMPERATURE] = -5000.0f;
    is                     = measure();
    TEST_ASSERT_EQUAL_INT32(1000, is.current_ma);
    TEST_ASSERT_EQUAL_INT32(-5000, is.temperature_mc);
    shown[RIG_CURRENT]     = NAN;
    shown[RIG_TEMPERATURE] = 1e30f;
    is                     = measure();
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, is.current_ma);
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, is.temperature_mc);
}

static void write_counter(const char *number)
{
    FILE *file = fopen(rig.position.file, "w");
    TEST_ASSERT_NOT_NULL(file);
    TEST_ASSERT_TRUE(fputs(number, file) >= 0 && fclose(file) == 0);
}

static int32_t position(void)
{
    port_measured_t is;
    board.port.measure(board.port.context, &is);
    return is.position;
}

static void test_a_counter_is_the_arms_position(void)
{
    (void)snprintf(rig.position.file, sizeof rig.position.file, "/tmp/tribo-position-%ld", (long)getpid());
    rig.position.bits = 32;
    write_counter("4294967290\n");
    TEST_ASSERT_TRUE(open_board());
    TEST_ASSERT_EQUAL_UINT32(PORT_MEASURES_POSITION, board.port.measures);
    TEST_ASSERT_EQUAL_INT32(0, position());
    write_counter("4\n");
    TEST_ASSERT_EQUAL_INT32(10, position());
    write_counter("4294967295\n");
    TEST_ASSERT_EQUAL_INT32(5, position());
    write_counter("gone\n");
    TEST_ASSERT_EQUAL_INT32(INT32_MIN + 4, position()); // as far away as it can be
    board_close(&board);

    rig.position.bits = 16;
    write_counter("65530\n");
    TEST_ASSERT_TRUE(open_board());
    write_counter("5\n");
    TEST_ASSERT_EQUAL_INT32(11, position());
    write_counter("65000\n");
    TEST_ASSERT_EQUAL_INT32(-530, position());
    for (int turns = 1; turns <= 3; turns++) // further than the counter counts
    {
        write_counter("30000\n");
        (void)position();
        write_counter("60000\n");
        (void)position();
        write_counter("0\n");
        TEST_ASSERT_EQUAL_INT32(65536 * turns + 6, position());
    }
    board_close(&board);

    write_counter("\n");
    TEST_ASSERT_FALSE(open_board());
    TEST_ASSERT_NOT_NULL(strstr(error.text, "position.file: /tmp/tribo-position-"));
    TEST_ASSERT_NOT_NULL(strstr(error.text, " cannot be read as a whole number: Invalid argument"));
    (void)snprintf(rig.position.file, sizeof rig.position.file, "/tmp");
    error = (common_error_t){""};
    TEST_ASSERT_FALSE(open_board());
    TEST_ASSERT_NOT_NULL(strstr(error.text, "position.file: /tmp cannot be read as a whole number: Is a directory"));
    (void)snprintf(rig.position.file, sizeof rig.position.file, "/tmp/tribo-position-%ld", (long)getpid());
    error = (common_error_t){""};
    (void)remove(rig.position.file);
    TEST_ASSERT_FALSE(open_board());
    TEST_ASSERT_NOT_NULL(strstr(error.text, "No such file"));
}

static void test_a_power_stage_without_readiness_signal_is_not_queried(void)
{
    TEST_ASSERT_TRUE(open_board());
    TEST_ASSERT_EQUAL_UINT32(0, board.port.measures);
}

static void test_enable_goes_off_before_the_output(void)
{
    TEST_ASSERT_TRUE(open_board());
    TEST_ASSERT_TRUE(atomic_load(&seen->enable_at) < atomic_load(&seen->output_at));
    enable(true);
    board_off(&board);
    TEST_ASSERT_EQUAL_INT(0, atomic_load(&seen->level[LINE_ENABLE]));
    TEST_ASSERT_TRUE(atomic_load(&seen->enable_at) < atomic_load(&seen->output_at));
}

// --- an output's driver that blocks for a second --------------------------------------------------------------------

#define BLOCK_MS 1000

/// Idle it takes 2 ms, or 2 ms more than the heartbeat's limit.
#define LONGEST_MS   200
#define HEARTBEAT_MS 10u

static int is_killed_running(void *context, heart_t *heart)
{
    (void)context;
    enable(true);
    heart_beat(heart);
    atomic_store(&seen->block_ms, BLOCK_MS);
    atomic_store(&seen->killed_ns, realtime_now_ns());
    (void)raise(SIGKILL);
    return 0;
}

/// In its driver, where kill -9 waits for the kernel: only the heartbeat tells.
static int is_blocked_writing(void *context, heart_t *heart)
{
    (void)context;
    enable(true);
    heart_beat(heart);
    atomic_store(&seen->block_ms, BLOCK_MS);
    atomic_store(&seen->killed_ns, realtime_now_ns());
    board.port.command(board.port.context, tribo_force_of_q31(0, 1.0f));
    return 0;
}

static void check_off_within_the_limit(int (*loop)(void *context, heart_t *heart))
{
    const supervisor_config_t supervisor = {.heartbeat_ms = HEARTBEAT_MS,
                                            .priority     = 1,
                                            .off          = board_off,
                                            .context      = &board};
    TEST_ASSERT_TRUE(open_board());
    (void)supervisor_run(&supervisor, loop, NULL, &error);
    TEST_ASSERT_EQUAL_STRING("", error.text);
    TEST_ASSERT_EQUAL_INT(0, atomic_load(&seen->level[LINE_ENABLE]));
    TEST_ASSERT_TRUE(atomic_load(&seen->output_ns) - atomic_load(&seen->killed_ns) >= BLOCK_MS * MS);
}

static void test_a_killed_loop_is_off_at_once_though_its_output_blocks(void)
{
    check_off_within_the_limit(is_killed_running);
    TEST_ASSERT_TRUE(atomic_load(&seen->off_ns) - atomic_load(&seen->killed_ns) < LONGEST_MS * MS);
}

static void test_a_loop_that_its_output_blocks_is_off_before_it_comes_back(void)
{
    check_off_within_the_limit(is_blocked_writing);
    TEST_ASSERT_TRUE(atomic_load(&seen->enable_at) < atomic_load(&seen->output_at));
}

// --- reading back --------------------------------------------------------------------------------------------------

static void test_an_enable_that_stays_high_refuses_the_start(void)
{
    atomic_store(&seen->reads_high, 1);
    TEST_ASSERT_FALSE(open_board());
    TEST_ASSERT_EQUAL_STRING("lines.enable ('enable'): reads on, though it is off", error.text);
    rig.read_back = 0;
    TEST_ASSERT_TRUE(open_board());
    TEST_ASSERT_TRUE(board_attach(&board, &drive, &error));
    TEST_ASSERT_EQUAL_HEX32(0, inputs());
}

static void test_an_enable_pin_that_reads_other_than_set_is_a_fault(void)
{
    TEST_ASSERT_TRUE(open_board());
    TEST_ASSERT_EQUAL_HEX32(0, inputs());
    atomic_store(&seen->reads_high, 1);
    TEST_ASSERT_EQUAL_HEX32(PORT_INPUT_POWER_FAULT, inputs());
    TEST_ASSERT_EQUAL_STRING("lines.enable reads on, though it is off", board.complaint);
    enable(true);
    TEST_ASSERT_EQUAL_HEX32(0, inputs());
    TEST_ASSERT_NULL(board.complaint);
    atomic_store(&seen->reads_high, 0);
    TEST_ASSERT_EQUAL_HEX32(PORT_INPUT_POWER_FAULT, inputs());
    TEST_ASSERT_EQUAL_STRING("lines.enable reads off, though it is on", board.complaint);
}

static void test_a_chip_that_does_not_read_outputs_goes_without(void)
{
    atomic_store(&seen->reads_high, -2);
    TEST_ASSERT_TRUE(open_board());
    enable(true);
    TEST_ASSERT_EQUAL_HEX32(0, inputs());
}

static void use_ready(void)
{
    rig.lines[LINE_READY] = (line_config_t){.name = "ready"};
}

static void test_a_stage_that_is_ready_though_off_refuses_the_start(void)
{
    use_ready();
    atomic_store(&seen->level[LINE_READY], 1);
    TEST_ASSERT_TRUE(open_board());
    TEST_ASSERT_FALSE(board_attach(&board, &drive, &error));
    TEST_ASSERT_EQUAL_STRING("lines.ready ('ready'): the power stage is ready, though enable has been off for 20 ms "
                             "(ready_off_ms; 0 if its ready output does not fall)",
                             error.text);
    rig.ready_off_ms = 0;
    TEST_ASSERT_TRUE(board_attach(&board, &drive, &error));
}

/// On the clock of ticks from outside, which no load can disturb.
static void test_ready_must_fall_within_its_time(void)
{
    use_ready();
    TEST_ASSERT_TRUE(open_board());
    board.slack_ns = INT64_MAX;
    TEST_ASSERT_TRUE(board_attach(&board, &drive, &error));
    board_begin(&board, 0, 0);
    enable(true);
    atomic_store(&seen->level[LINE_READY], 1);
    board_begin(&board, 1000, 0);
    TEST_ASSERT_EQUAL_HEX32(0, inputs());
    enable(false);
    board_begin(&board, 1020, 0); // ms
    TEST_ASSERT_EQUAL_HEX32(0, inputs());
    enable(false); // as in each tick
    board_begin(&board, 1021, 0);
    TEST_ASSERT_EQUAL_HEX32(PORT_INPUT_POWER_FAULT, inputs());
    TEST_ASSERT_EQUAL_STRING("lines.ready has not fallen within ready_off_ms, though enable is off", board.complaint);
    board_begin(&board, 5000000, 0); // 32 bits of us are over
    TEST_ASSERT_EQUAL_HEX32(PORT_INPUT_POWER_FAULT, inputs());
    atomic_store(&seen->level[LINE_READY], 0);
    TEST_ASSERT_EQUAL_HEX32(PORT_INPUT_NOT_READY, inputs());
    TEST_ASSERT_NULL(board.complaint);
}

// --- the heartbeat's line --------------------------------------------------------------------------------------------

static int edges_of_ticks(unsigned ticks)
{
    const int before = atomic_load(&seen->edges);
    for (unsigned i = 0; i < ticks; i++)
    {
        board_pulse(&board);
    }
    return atomic_load(&seen->edges) - before;
}

static void test_the_heartbeat_has_an_edge_each_so_many_ticks_while_all_is_well(void)
{
    TEST_ASSERT_TRUE(open_board());
    TEST_ASSERT_TRUE(board_attach(&board, &drive, &error));
    TEST_ASSERT_EQUAL_INT(12, edges_of_ticks(12));
    drive.state = DRIVE_RUN;
    TEST_ASSERT_EQUAL_INT(12, edges_of_ticks(12));
    rig.heartbeat_ticks = 4;
    TEST_ASSERT_EQUAL_INT(3, edges_of_ticks(12));
    drive.state = DRIVE_FAULT;
    TEST_ASSERT_EQUAL_INT(0, edges_of_ticks(12));
    drive.state  = DRIVE_RUN;
    board.failed = true;
    TEST_ASSERT_EQUAL_INT(0, edges_of_ticks(12));
}

#include "runners/test_board.inc" // main
