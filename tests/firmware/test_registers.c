// The drive through its registers: params staged, checked and swapped, the store at power-up, commands, traces.

#include "app/crc32.h"
#include "registers_host.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PERIOD_US  1000u
#define RING_WORDS 800u

static uint32_t ring[RING_WORDS];
static double   force_n;    ///< of a plant that follows u with a lag
static double   stiction_n; ///< and stands for smaller u - F
static unsigned ticks;

// --- a board -------------------------------------------------------------------------------------------------------

static void power_up_with(drive_fault_t found)
{
    const registers_board_t parts = {.port       = &board.port,
                                     .line       = &line,
                                     .flash      = &flash,
                                     .defaults   = &defaults,
                                     .baud       = 115200,
                                     .ring       = ring,
                                     .ring_words = RING_WORDS};
    board_init(&board, UINT32_MAX - 20u * PERIOD_US);
    registers_load(&registers, &parts);
    registers_start(&registers, found);
    map        = registers_map(&registers);
    force_n    = 0.0;
    stiction_n = 0.0;
    ticks      = 0;
}

static void power_up(void)
{
    power_up_with(DRIVE_FAULT_NONE);
}

void setUp(void)
{
    memset(sectors, 0xff, sizeof sectors);
    defaults        = params_default();
    defaults.method = PARAMS_METHOD_PAPER;
#if DRIVE_FEEDFORWARD
    defaults.guard_on = 0;
#endif
    defaults.drive.residual_n       = 0.0f;
    defaults.drive.command_limit_ms = 0;
    defaults.drive.reference_ms     = 0;
    power_up();
}

static double in_newton(loop_force_t x)
{
    return (double)scaling_value(x, BOARD_FULL_SCALE_N);
}

static void tick(void)
{
    board_new_tick(&board);
    board.y = board_force(force_n);
    registers_tick(&registers);
    registers_run(&registers);
    const double u   = in_newton(board.command);
    const double net = u - force_n;
    force_n += (net > stiction_n ? net - stiction_n : net < -stiction_n ? net + stiction_n : 0.0) * 0.02;
    ticks++;
    board.now_us += PERIOD_US;
}

static void run(unsigned count)
{
    for (unsigned i = 0; i < count; i++)
    {
        tick();
    }
}

// --- a host --------------------------------------------------------------------------------------------------------

static double read_number(uint32_t address)
{
    const uint32_t word = read_word(address);
    float          number;
    memcpy(&number, &word, sizeof number);
    return (double)number;
}

static modbus_status_t try_number(uint32_t address, float number)
{
    uint32_t word;
    memcpy(&word, &number, sizeof word);
    return try_word(address, word);
}

static void write_number(uint32_t address, float number)
{
    TEST_ASSERT_EQUAL_INT(MODBUS_OK, try_number(address, number));
}

enum
{
#define NUMBER(group, symbol, member, key, unit, low, high, standard, change, number, ...) NUMBER_##symbol = (number),
    TRIBO_PARAMETERS(NUMBER)
#undef NUMBER
};

#define NUMBER_OF(symbol) read_number(REGISTERS_STATE_AT + 2u * REGISTERS_STATE_##symbol)
#define COUNT_OF(symbol)  read_word(REGISTERS_COMPENSATION_AT + 2u * REGISTERS_COMPENSATION_##symbol)
#define SHOWN_OF(symbol)  read_number(REGISTERS_COMPENSATION_AT + 2u * REGISTERS_COMPENSATION_##symbol)
#define SIGNAL_OF(symbol) read_number(REGISTERS_SIGNALS_AT + 2u * REGISTERS_SIGNAL_##symbol)
#define PARAM_AT(symbol)  (REGISTERS_STAGED_AT + NUMBER_##symbol)

static void start(void)
{
    tick();
    command(REGISTERS_START);
    tick();
    TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
}

// --- params --------------------------------------------------------------------------------------------------------

/// The drive is off for good, and its bus says why.
static void test_defaults_with_a_period_that_is_none_are_refused_and_can_be_read(void)
{
    const uint32_t periods[] = {0, 1, 9, 100001, UINT32_MAX};
    for (unsigned i = 0; i < sizeof periods / sizeof periods[0]; i++)
    {
        defaults.drive.period_us = periods[i];
        power_up();
        tick();
        TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT_PARAMS, STATE_OF(fault));
        TEST_ASSERT_EQUAL_HEX32(REGISTERS_STAGED_AT + REGISTERS_DRIVE_AT + 2u * DRIVE_CONFIG_period_us,
                                STATE_OF(refused_register));
        TEST_ASSERT_EQUAL_UINT32(0, STATE_OF(unlocked_ticks));
        TEST_ASSERT_FALSE(board.enabled);
    }
}

static void test_defaults_are_the_papers_loop(void)
{
    const params_set_t                  set   = params_default();
    const tribo_force_loop_f32_config_t paper = tribo_force_loop_f32_paper();
#define COMPARE(config, symbol, member, key)                                                                           \
    {                                                                                                                  \
        const uint32_t word = params_word(&set, PARAMS_##symbol);                                                      \
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&(config).member, &word, sizeof word, key);                                   \
    }
#define OF_LOOP(group, symbol, member, key, ...)       COMPARE(paper, symbol, member, key)
#define OF_CONTROLLER(group, symbol, member, key, ...) COMPARE(paper.controller, symbol, member, key)
#define OF_FRICTION(group, symbol, member, key, ...)   COMPARE(paper.compensator.friction, symbol, member, key)
#define OF_ARM(group, symbol, member, key, ...)        COMPARE(paper.compensator.arm, symbol, member, key)
    TRIBO_SAMPLE_PARAMETERS(OF_LOOP)
    TRIBO_INPUT_PARAMETERS(OF_LOOP)
    TRIBO_GAIN_PARAMETERS(OF_LOOP)
    TRIBO_LIMIT_PARAMETERS(OF_CONTROLLER)
    TRIBO_CASCADE_PARAMETERS(OF_CONTROLLER)
    TRIBO_FRICTION_PARAMETERS(OF_FRICTION)
    TRIBO_BREAKAWAY_PARAMETERS(OF_FRICTION)
    TRIBO_TABLE_PARAMETERS(OF_FRICTION)
    TRIBO_ARM_PARAMETERS(OF_ARM)
#if DRIVE_FEEDFORWARD
    const tribo_feedforward_f32_config_t feedforward = tribo_feedforward_f32_default();
    const tribo_guard_f32_config_t       guard       = tribo_guard_f32_default();
#define OF_FEEDFORWARD(group, symbol, member, key, ...) COMPARE(feedforward, symbol, member, key)
#define OF_GUARD(group, symbol, member, key, ...)       COMPARE(guard, symbol, member, key)
    TRIBO_FEEDFORWARD_PARAMETERS(OF_FEEDFORWARD)
    TRIBO_GUARD_PARAMETERS(OF_GUARD)
    TEST_ASSERT_EQUAL_UINT32(1, set.guard_on);
#endif
    TEST_ASSERT_EQUAL_MEMORY(paper.controller.sections, set.sections, 2 * sizeof set.sections[0]);
}

#if DRIVE_FEEDFORWARD
static void check_poles(const params_set_t *set, float actuator, float sensor)
{
    TEST_ASSERT_EQUAL_FLOAT(actuator, set->drive.actuator_pole_rad_per_s);
    TEST_ASSERT_EQUAL_FLOAT(sensor, set->drive.sensor_pole_rad_per_s);
    TEST_ASSERT_EQUAL_FLOAT(actuator, params_number(set, PARAMS_ACTUATOR_POLE));
    TEST_ASSERT_EQUAL_FLOAT(sensor, params_number(set, PARAMS_SENSOR_POLE));
}

static void test_a_pole_is_reported_once(void)
{
    tribo_loop_parts_t loop = {.config = tribo_force_loop_f32_paper(), .feedforward = tribo_feedforward_f32_default()};
    params_set_t       set  = params_default();
    drive_config_t     config = set.drive;
    check_poles(&set, loop.feedforward.actuator_pole_rad_per_s, loop.feedforward.sensor_pole_rad_per_s);
    config.actuator_pole_rad_per_s = 900.0f;
    config.sensor_pole_rad_per_s   = 300.0f;
    set                            = params_default_of(&config);
    check_poles(&set, 900.0f, 300.0f);
    params_take_loop(&set, &loop);
    check_poles(&set, 900.0f, 300.0f);
    loop.feeds_forward                       = true;
    loop.feedforward.actuator_pole_rad_per_s = 700.0f;
    loop.feedforward.sensor_pole_rad_per_s   = 90.0f;
    params_take_loop(&set, &loop);
    check_poles(&set, 700.0f, 90.0f);
}

static void test_a_loop_without_a_sensor_is_taken_over(void)
{
    const params_set_t before = params_default();
    params_set_t       set    = before;
    tribo_loop_parts_t loop   = {.config        = tribo_force_loop_f32_paper(),
                                 .feeds_forward = true,
                                 .feedforward   = tribo_feedforward_f32_default(),
                                 .sensorless    = {.belief = 0.4f},
                                 .guarded       = true,
                                 .guard         = tribo_guard_f32_default()};
    TEST_ASSERT_EQUAL_FLOAT(tribo_sensorless_f32_default().belief, params_number(&set, PARAMS_BELIEF));
    params_take_loop(&set, &loop);
    TEST_ASSERT_EQUAL_MEMORY(&before, &set, sizeof set);
    loop.is_sensorless = true;
    loop.guarded       = false;
    loop.guard         = (tribo_guard_f32_config_t){.turn_n = 1.0f};
    params_take_loop(&set, &loop);
    TEST_ASSERT_EQUAL_UINT32(PARAMS_METHOD_SENSORLESS, set.method);
    TEST_ASSERT_EQUAL_FLOAT(0.4f, params_number(&set, PARAMS_BELIEF));
    TEST_ASSERT_EQUAL_UINT32(0, set.guard_on);
    TEST_ASSERT_EQUAL_MEMORY(before.guard, set.guard, sizeof set.guard);
}
#endif

/// Two builds whose words mean the same have the same layout; PARAMS_LAYOUT_OWN is to be set to what this says.
static void test_the_layout_is_that_of_the_lists(void)
{
#define NAME(type, name, ...) #name,
    static const char *const own[] = {DRIVE_CONFIG_FIELDS(NAME)};
#undef NAME
#define ELEMENT_NAME(symbol, member, key, ...) key,
    static const char *const elements[] = {TRIBO_SECTION_ELEMENTS(ELEMENT_NAME) TRIBO_POINT_ELEMENTS(ELEMENT_NAME)};
#undef ELEMENT_NAME
    uint32_t crc = 0;
    for (size_t i = 0; i < sizeof own / sizeof own[0]; i++)
    {
        crc = crc32_update(crc, own[i], strlen(own[i]) + 1u);
    }
    for (size_t i = 0; i < sizeof elements / sizeof elements[0]; i++)
    {
        crc = crc32_update(crc, elements[i], strlen(elements[i]) + 1u);
    }
    TEST_ASSERT_EQUAL_HEX32(crc, PARAMS_LAYOUT_OWN);
    TEST_ASSERT_EQUAL_HEX32(PARAMS_LAYOUT_OF(DRIVE_FEEDFORWARD), STATE_OF(layout));
    TEST_ASSERT_EQUAL_HEX32(PARAMS_LAYOUT_OF(1) - 1u, PARAMS_LAYOUT_OF(0));
}

static void test_every_word_of_both_sets_has_its_register(void)
{
    static const struct
    {
        uint32_t at, words;
    } blocks[]                = {{REGISTERS_DRIVE_AT, DRIVE_CONFIG_COUNT},
                                 {REGISTERS_LOOP_AT, PARAMS_LOOP_COUNT},
                                 {REGISTERS_METHOD_AT, 1},
                                 {REGISTERS_FEED_AT, PARAMS_FEED_COUNT},
                                 {REGISTERS_GUARD_AT, PARAMS_GUARD_COUNT},
                                 {REGISTERS_SECTIONS_AT, 20},
                                 {REGISTERS_TABLE_AT, 96}};
    const params_set_t before = registers.active->set;
    uint32_t           word   = 0x3a020304u; // as a float a number that can be meant
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++)
    {
        for (uint32_t k = 0; k < blocks[i].words; k++)
        {
            write_word(REGISTERS_STAGED_AT + blocks[i].at + 2u * k, word++);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0x3a020304u + PARAMS_WORDS, word);
    uint32_t words[PARAMS_WORDS];
    memcpy(words, &registers.staged, sizeof words);
    for (uint32_t i = 0; i < PARAMS_WORDS; i++)
    {
        TEST_ASSERT_EQUAL_HEX32(0x3a020304u + i, words[i]);
    }
    TEST_ASSERT_EQUAL_HEX32(0x3a020304u, read_word(REGISTERS_STAGED_AT));
    TEST_ASSERT_EQUAL_MEMORY(&before, &registers.active->set, sizeof before);
    uint32_t active = 0;
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++)
    {
        for (uint32_t k = 0; k < blocks[i].words; k++)
        {
            const uint32_t at = REGISTERS_ACTIVE_AT + blocks[i].at + 2u * k;
            TEST_ASSERT_EQUAL_HEX32(params_word(&before, active++), read_word(at));
            TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS, try_word(at, 0)); // read only
        }
    }
    command(REGISTERS_REVERT);
    TEST_ASSERT_EQUAL_MEMORY(&before, &registers.staged, sizeof before);
}

static void test_a_set_is_swapped_in_run_without_a_bump(void)
{
    start();
    write_number(REQUEST_AT(reference), 0.5f);
    for (int change = 0; change < 20; change++)
    {
        run(400);
        write_number(PARAM_AT(GAIN), change % 2 == 0 ? 0.2f : 0.85f);
        write_number(PARAM_AT(BREAKAWAY_OFFSET), change % 2 == 0 ? 0.02f : 0.007f);
        write_number(REGISTERS_STAGED_AT + REGISTERS_SECTIONS_AT, change % 2 == 0 ? 1.5f : 1.81855643f);
        const double u = in_newton(board.command);
        command(REGISTERS_APPLY);
        TEST_ASSERT_EQUAL_INT(MODBUS_BUSY, try_command(REGISTERS_APPLY)); // until the tick has taken it
        tick();
        TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, u, in_newton(board.command));
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, change % 2 == 0 ? 0.2 : 0.85, read_number(TO_ACTIVE(PARAM_AT(GAIN))));
        TEST_ASSERT_EQUAL_PTR(&registers.active->drive, drive_setup(&registers.drive));
        TEST_ASSERT_EQUAL_PTR(&registers.active->loop.params, registers.drive.loop.active);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 0.5, force_n);
}

/// Applies a set in RUN with this word in `address`: it must be refused, and the drive must not notice.
static void check_refused(const char *name, uint32_t address, uint32_t word, float value, float low, float high)
{
    char message[160];
    (void)snprintf(message, sizeof message, "%s = %g", name, (double)value);
    const drive_setup_t *setup  = drive_setup(&registers.drive);
    const params_set_t   active = registers.active->set;
    write_word(address, word);
    TEST_ASSERT_EQUAL_INT_MESSAGE(MODBUS_FAILURE, try_command(REGISTERS_APPLY), message);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(REGISTERS_SET_REFUSED, STATE_OF(outcome), message);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(address, STATE_OF(refused_register), message);
    TEST_ASSERT_EQUAL_FLOAT_MESSAGE(low, (float)NUMBER_OF(refused_low), message);
    TEST_ASSERT_EQUAL_FLOAT_MESSAGE(high, (float)NUMBER_OF(refused_high), message);
    TEST_ASSERT_TRUE_MESSAGE(isnan(value) || NUMBER_OF(refused_value) == (double)value, message);
    tick();
    TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
    TEST_ASSERT_EQUAL_PTR(setup, drive_setup(&registers.drive));
    TEST_ASSERT_EQUAL_MEMORY(&active, &registers.active->set, sizeof active);
    command(REGISTERS_REVERT);
}

static void check_number_refused(const char *name, uint32_t address, float value, float low, float high)
{
    uint32_t word;
    memcpy(&word, &value, sizeof word);
    check_refused(name, address, word, value, low, high);
}

static void check_ends(const char *name, uint32_t address, float low, float high)
{
    const float above = 1.5f;
    check_number_refused(name, address, high > 0.0f ? high * above : 1.0f, low, high);
    check_number_refused(name, address, low < 0.0f ? low * above : low / 2.0f - 1e-14f, low, high);
    TEST_ASSERT_EQUAL_INT_MESSAGE(MODBUS_ILLEGAL_VALUE, try_number(address, NAN), name);
    TEST_ASSERT_EQUAL_INT_MESSAGE(MODBUS_ILLEGAL_VALUE, try_number(address, -INFINITY), name);
}

static void test_a_refused_field_is_named_with_its_range(void)
{
    start();
#define CHECK(group, symbol, member, key, unit, low, high, standard, change, number, ...)                              \
    check_ends(key, PARAM_AT(symbol), (float)(low), (float)(high));
    TRIBO_SAMPLE_PARAMETERS(CHECK)
    TRIBO_INPUT_PARAMETERS(CHECK)
    TRIBO_LIMIT_PARAMETERS(CHECK)
    TRIBO_GAIN_PARAMETERS(CHECK)
    TRIBO_FRICTION_PARAMETERS(CHECK)
    TRIBO_BREAKAWAY_PARAMETERS(CHECK)
    TRIBO_ARM_PARAMETERS(CHECK)
    PARAMS_FEED_ROWS(CHECK)
    PARAMS_GUARD_ROWS(CHECK)
#undef CHECK
    check_refused("section_count", PARAM_AT(SECTION_COUNT), 5, 5.0f, 1.0f, 4.0f);
    check_refused("table_length", PARAM_AT(TABLE_LENGTH), 33, 33.0f, 0.0f, 32.0f);
#if DRIVE_FEEDFORWARD
    check_refused("guard.on", REGISTERS_STAGED_AT + REGISTERS_GUARD_AT, 2, 2.0f, 0.0f, 1.0f);
#endif
    check_refused("method", REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, 3, 3.0f, 0.0f, DRIVE_FEEDFORWARD ? 2.0f : 0.0f);
    for (uint32_t i = 0; i < DRIVE_CONFIG_COUNT; i++)
    {
        const drive_config_field_t *field   = &drive_config_fields[i];
        const uint32_t              address = REGISTERS_STAGED_AT + REGISTERS_DRIVE_AT + 2u * i;
        if (i == DRIVE_CONFIG_full_scale_n && TRIBO_IS_Q31)
        {
            continue; // the library refuses it first
        }
        if (field->is_float)
        {
            check_number_refused(drive_config_name(i), address, 2.0f * field->high, field->low, field->high);
            TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_number(address, NAN));
        }
        else if (i != DRIVE_CONFIG_period_us) // the board's
        {
            check_refused(drive_config_name(i),
                          address,
                          2u * (uint32_t)field->high,
                          2.0f * field->high,
                          field->low,
                          field->high);
        }
    }
}

static void test_a_position_reference_reaches_the_drive_by_itself(void)
{
    write_number(REQUEST_AT(reference), 0.5f);
    write_word(REQUEST_AT(position_reference), (uint32_t)-5);
    TEST_ASSERT_EQUAL_INT32(-5, registers.drive.position_reference);
    TEST_ASSERT_EQUAL_UINT32((uint32_t)-5, read_word(REQUEST_AT(position_reference)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5, read_number(REQUEST_AT(reference)));
    const uint16_t beyond[4] = {0, 7, 0, 7}; // the list ends behind it: nothing of a write that is refused is taken
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS,
                          map.write(map.context, (uint16_t)REQUEST_AT(position_reference), 4, beyond));
    TEST_ASSERT_EQUAL_INT32(-5, registers.drive.position_reference);
}

static void test_fields_that_do_not_fit_each_other_are_refused(void)
{
    start();
    check_number_refused("sample_time_s", PARAM_AT(SAMPLE_TIME), 0.002f, 0.001f, 0.001f);
    check_number_refused("k_min over k_max", PARAM_AT(K_MIN), 21.0f, 1.01f, 1000.0f);
    check_number_refused("unstable", REGISTERS_STAGED_AT + REGISTERS_SECTIONS_AT + 6, -1.0f, -4.0f, 4.0f);
    check_number_refused("pulse", PARAM_AT(PULSE_WIDTH), 0.07f, 1e-6f, 6.3f);
    check_refused("late_us", DRIVE_AT(late_us), 1000, 1000.0f, 0.0f, 999.0f);
}

static void test_a_refusal_names_the_section_the_point_and_the_direction(void)
{
    start();
    check_number_refused("unstable",
                         REGISTERS_STAGED_AT + REGISTERS_SECTIONS_AT + 2u * (5u * 1u + 3u),
                         -1.0f,
                         -4.0f,
                         4.0f);
    check_number_refused("negative", PARAM_AT(BREAKAWAY_NEGATIVE_SLOPE), 11.0f, 0.0f, 10.0f);
    const float points[] = {0.0f, 0.1f, 0.1f, 0.5f, 0.1f, 0.1f, 1.0f, 0.1f, 0.1f};
    for (uint32_t i = 0; i < sizeof points / sizeof points[0]; i++)
    {
        write_number(REGISTERS_STAGED_AT + REGISTERS_TABLE_AT + 2u * i, points[i]);
    }
    write_word(PARAM_AT(TABLE_LENGTH), 3);
    check_number_refused("point", REGISTERS_STAGED_AT + REGISTERS_TABLE_AT + 2u * (3u * 1u + 2u), -0.1f, 1e-6f, 1e6f);
}

#if DRIVE_FEEDFORWARD
static void test_the_method_changes_in_run_without_a_bump(void)
{
    start();
    write_number(REQUEST_AT(reference), 0.5f);
    for (int change = 0; change < 4; change++)
    {
        run(1000);
        const double u = in_newton(board.command);
        write_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, change % 2 == 0 ? 1 : 0);
        command(REGISTERS_APPLY);
        tick();
        TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, u, in_newton(board.command));
        TEST_ASSERT_EQUAL_PTR(&registers.active->loop.params, registers.drive.loop.active);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.05, 0.5, force_n);
}
#else
static void test_the_feed_forward_is_absent(void)
{
    start();
    for (uint32_t at = REGISTERS_FEED_AT; at < REGISTERS_SECTIONS_AT; at++)
    {
        uint16_t value;
        TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS,
                              map.read(map.context, (uint16_t)(REGISTERS_STAGED_AT + at), 1, &value));
        TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS,
                              map.read(map.context, (uint16_t)(REGISTERS_ACTIVE_AT + at), 1, &value));
    }
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS, try_word(REGISTERS_STAGED_AT + REGISTERS_FEED_AT, 0));
    check_refused("method", REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, 1, 1.0f, 0.0f, 0.0f);
}
#endif

// --- guard and learning --------------------------------------------------------------------------------------------

#if DRIVE_FEEDFORWARD
/// A triangle of 0.3 to 0.5 N, 2 s a period.
static void run_triangle(unsigned count)
{
    for (unsigned i = 0; i < count; i++)
    {
        const unsigned phase = ticks % 2000u;
        write_number(REQUEST_AT(reference), 0.3f + 2e-4f * (float)(phase < 1000u ? phase : 2000u - phase));
        tick();
    }
}

static void apply_word(uint32_t address, uint32_t word)
{
    write_word(address, word);
    command(REGISTERS_APPLY);
}

/// On a plant without friction the default L makes the loop hunt.
static void hunt(void)
{
    write_number(PARAM_AT(GAIN), 1.2f);
    apply_word(REGISTERS_STAGED_AT + REGISTERS_GUARD_AT, 1);
    start();
    run_triangle(10000);
    TEST_ASSERT_EQUAL_UINT32(DRIVE_WARNING_HUNTING, COUNT_OF(warnings));
    TEST_ASSERT_TRUE(SHOWN_OF(fade) == 0.0 && SIGNAL_OF(added) == 0.0);
}

static void test_the_guard_fades_what_hunts_until_it_is_restored(void)
{
    write_number(PARAM_AT(GAIN), 1.2f);
    command(REGISTERS_APPLY);
    start();
    run_triangle(10000);
    TEST_ASSERT_EQUAL_UINT32(0, COUNT_OF(warnings)); // none is on
    TEST_ASSERT_TRUE(SHOWN_OF(fade) == 1.0);
    command(REGISTERS_STOP);
    tick();

    hunt();
    drive_log(&registers.drive);
    TEST_ASSERT_NOT_NULL(strstr(board.log, "warning: friction faded: hunting\n"));
    board.log_length = 0;
    drive_log(&registers.drive);
    TEST_ASSERT_EQUAL_size_t(0, board.log_length); // once
    command(REGISTERS_STOP);
    tick();
    start();
    run_triangle(1000);
    TEST_ASSERT_EQUAL_UINT32(DRIVE_WARNING_HUNTING, COUNT_OF(warnings)); // over a stop
    TEST_ASSERT_TRUE(SHOWN_OF(fade) == 0.0);

    stiction_n = 0.1;
    write_number(PARAM_AT(GAIN), 0.8f);
    command(REGISTERS_APPLY);
    command(REGISTERS_RESTORE);
    run_triangle(251);
    TEST_ASSERT_EQUAL_UINT32(0, COUNT_OF(warnings));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 0.5, SHOWN_OF(fade)); // half of fade_time_s
    run_triangle(3000);
    TEST_ASSERT_TRUE(SHOWN_OF(fade) == 1.0);
    TEST_ASSERT_EQUAL_UINT32(0, COUNT_OF(warnings));
}

/// Nothing of a guard that is off refuses a set: neither a small input_max nor a fade_time_s that the guard could not have.
static void test_a_guard_that_is_off_refuses_nothing(void)
{
    write_number(PARAM_AT(INPUT_MAX), 5e-6f);
    write_number(PARAM_AT(GUARD_TURN), 1e-9f);
    write_number(PARAM_AT(GUARD_STRAY), 1e6f);
    write_number(PARAM_AT(GUARD_QUICK_TIME), 1e3f);
    write_number(PARAM_AT(GUARD_FADE_TIME), 1e3f);
    write_word(REQUEST_AT(unlock), REGISTERS_KEY);
    command(REGISTERS_APPLY);
    TEST_ASSERT_EQUAL_UINT32(0, STATE_OF(refused_register));
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_DONE, STATE_OF(outcome));
}

/// The registers from `place` on against what the library says.
static void check_learned(uint32_t direction, uint32_t place)
{
    const loop_params_t              *params = &registers.active->loop.params;
    const tribo_feedforward_learned_t learned =
        TRIBO(feedforward, learned)(params, &registers.memory.state, direction, registers.drive.r);
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, (double)learned.L_n, read_number(REGISTERS_COMPENSATION_AT + 2u * place));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7,
                              (double)learned.relative_variance,
                              read_number(REGISTERS_COMPENSATION_AT + 2u * (place + 1u)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6,
                              (double)learned.travel_n,
                              read_number(REGISTERS_COMPENSATION_AT + 2u * (place + 2u)));
    TEST_ASSERT_TRUE(learned.travel_n > 0.0f && learned.relative_variance > 0.0f);
}

/// The prior is a quarter of the friction, and learning may not go beyond three times it.
static void test_learning_that_stays_at_its_bound_is_a_warning_until_it_is_restored(void)
{
    write_number(PARAM_AT(BREAKAWAY_OFFSET), 0.075f);
    write_number(PARAM_AT(BREAKAWAY_NEGATIVE_OFFSET), 0.075f);
    write_number(PARAM_AT(BREAKAWAY_SLOPE), 0.0f);
    write_number(PARAM_AT(BREAKAWAY_NEGATIVE_SLOPE), 0.0f);
    apply_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, 1);
    start();
    stiction_n = 0.3;
    run_triangle(2000);
    TEST_ASSERT_EQUAL_UINT32(0, COUNT_OF(warnings)); // not of a slide or two
    run_triangle(18000);
    TEST_ASSERT_EQUAL_UINT32(1, COUNT_OF(bound_up));
    TEST_ASSERT_EQUAL_UINT32(1, COUNT_OF(bound_down));
    TEST_ASSERT_EQUAL_UINT32(DRIVE_WARNING_BOUND, COUNT_OF(warnings));
    drive_log(&registers.drive);
    TEST_ASSERT_NOT_NULL(strstr(board.log, "warning: learned breakaway stays at its bound\n"));
    command(REGISTERS_STOP);
    tick();
    TEST_ASSERT_EQUAL_UINT32(DRIVE_WARNING_BOUND, COUNT_OF(warnings));
    const double learned = SHOWN_OF(travel_up);
    command(REGISTERS_RESTORE);
    tick();
    TEST_ASSERT_EQUAL_UINT32(0, COUNT_OF(warnings));
    TEST_ASSERT_TRUE(SHOWN_OF(travel_up) == learned); // is kept
    start();
    run_triangle(20000);
    TEST_ASSERT_EQUAL_UINT32(DRIVE_WARNING_BOUND, COUNT_OF(warnings));
}

/// Removes what the slide has taught, though the learner still judges it.
static void forget_slide(void)
{
    tribo_feedforward_learner_t *const learner = &registers.memory.state.learner;
    for (uint32_t i = 0; i < TRIBO_FEEDFORWARD_LEARNED; i++)
    {
        uint32_t bits;
        memcpy(&bits, &learner->a[i], sizeof bits);
        learner->seal ^= bits;
        learner->a[i] = 0.0f;
    }
}

/// A triangle of which nothing is learned, until friction is found to do harm.
static void run_until_harm(unsigned most)
{
    for (unsigned i = 0; i < most && COUNT_OF(harms) == 0u; i++)
    {
        forget_slide();
        run_triangle(1);
    }
}

static void test_friction_that_does_harm_is_fed_back_without_a_warning(void)
{
    write_number(PARAM_AT(TRUST), 1.0f);
    apply_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, 1);
    start();
    stiction_n = 0.02; // the model says 0.1 to 0.16
    run_until_harm(1500);
    TEST_ASSERT_TRUE(COUNT_OF(harms) == 0u && COUNT_OF(warnings) == 0u && SHOWN_OF(fade) == 1.0);
    run_until_harm(60000);
    TEST_ASSERT_EQUAL_UINT32(1, COUNT_OF(harms));
    TEST_ASSERT_EQUAL_UINT32(0, COUNT_OF(warnings));
    TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
    run_triangle(100);
    TEST_ASSERT_EQUAL_INT(TRIBO_FEEDFORWARD_HOLD, registers.memory.state.mode);
    TEST_ASSERT_TRUE(SHOWN_OF(fade) == 1.0); // of the guard alone
    command(REGISTERS_RESTORE);
    run_triangle(1);
    TEST_ASSERT_EQUAL_UINT32(0, COUNT_OF(harms));
    TEST_ASSERT_EQUAL_INT(TRIBO_FEEDFORWARD_MOVING, registers.memory.state.mode);
}

static void test_a_memory_that_was_corrupt_is_counted(void)
{
    apply_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, 1);
    start();
    stiction_n = 0.1;
    run_triangle(4000);
    TEST_ASSERT_EQUAL_UINT32(0, COUNT_OF(forgotten));
    for (uint32_t times = 1; times <= 2u; times++)
    {
        registers.memory.state.learner.seal ^= 1u;
        run_triangle(20);
        TEST_ASSERT_EQUAL_UINT32(times, COUNT_OF(forgotten));
    }
    apply_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, 2);
    run_triangle(1);
    TEST_ASSERT_EQUAL_UINT32(0, COUNT_OF(forgotten)); // of another method
    command(REGISTERS_STOP);
    tick();
    apply_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, 1);
    tick();
    TEST_ASSERT_EQUAL_UINT32(2, COUNT_OF(forgotten));
    command(REGISTERS_FORGET);
    tick();
    TEST_ASSERT_EQUAL_UINT32(0, COUNT_OF(forgotten));
}

static void test_a_corrupt_state_of_the_controller_is_counted(void)
{
    start();
    run(100);
    TEST_ASSERT_EQUAL_UINT32(0, STATE_OF(bad_inputs));
    registers.drive.loop.controller.cascade.section[0].w1 = TRIBO_EITHER(NAN, INT64_C(1) << 62);
    run(100);
    TEST_ASSERT_EQUAL_UINT32(1, STATE_OF(bad_inputs));
    TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
}

/// Appended to, never moved: what is on the bus of a drive in the field.
static void test_no_register_of_the_compensation_moves(void)
{
    static const char *const names[] = {"warnings",
                                        "friction_fade",
                                        "learned_positive_N",
                                        "learned_positive_relative_variance",
                                        "learned_positive_travel_N",
                                        "learned_positive_at_bound",
                                        "learned_negative_N",
                                        "learned_negative_relative_variance",
                                        "learned_negative_travel_N",
                                        "learned_negative_at_bound",
                                        "friction_harms",
                                        "learned_forgotten",
                                        "learned_late"};
#define NAME(symbol, name, type, unit, text) name,
    static const char *const found[] = {REGISTERS_COMPENSATION(NAME)};
#undef NAME
    TEST_ASSERT_EQUAL_HEX32(0xc0, REGISTERS_COMPENSATION_AT);
    TEST_ASSERT_EQUAL_size_t(sizeof names, sizeof found);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
    {
        TEST_ASSERT_EQUAL_STRING(names[i], found[i]);
    }
    TEST_ASSERT_TRUE(DRIVE_WARNING_HUNTING == 1 && DRIVE_WARNING_OVERSHOOT == 2 && DRIVE_WARNING_BOUND == 4);
}

/// As if so much had been learned from with the params in use.
static void have_travelled(float travel_n)
{
    tribo_feedforward_learner_t *const learner = &registers.memory.state.learner;
    learner->travel_n                          = travel_n;
    const void *const params                   = registers.active->loop.params.method; // its first member
    learner->rig                               = ((const TRIBO(feedforward, params_t) *)params)->learning.rig;
}

static void test_what_is_learned_is_in_registers(void)
{
    TEST_ASSERT_TRUE(SHOWN_OF(learned_up) == 0.0 &&
                     SHOWN_OF(relative_variance_up) == 0.0); // nothing is learned by this method
    apply_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, 1);
    start();
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, SHOWN_OF(relative_variance_up));
    TEST_ASSERT_TRUE(SHOWN_OF(travel_up) == 0.0 && SHOWN_OF(travel_down) == 0.0);
    stiction_n = 0.2; // the model says 0.1 to 0.16
    run_triangle(20000);
    check_learned(TRIBO_BREAKAWAY_POSITIVE, REGISTERS_COMPENSATION_learned_up);
    check_learned(TRIBO_BREAKAWAY_NEGATIVE, REGISTERS_COMPENSATION_learned_down);
    TEST_ASSERT_DOUBLE_WITHIN(0.06, 0.2, SHOWN_OF(learned_up));
    TEST_ASSERT_DOUBLE_WITHIN(0.06, 0.2, SHOWN_OF(learned_down));
    TEST_ASSERT_TRUE(SHOWN_OF(relative_variance_up) < 0.3 && SHOWN_OF(relative_variance_down) < 0.3);
    TEST_ASSERT_EQUAL_UINT32(0, COUNT_OF(bound_up));
    TEST_ASSERT_EQUAL_UINT32(0, COUNT_OF(bound_down));
    const double travel = SHOWN_OF(travel_up);
    command(REGISTERS_STOP);
    tick();
    start();
    TEST_ASSERT_TRUE(SHOWN_OF(travel_up) > 0.9 * travel); // outlasts a stop
    apply_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, 2);
    run_triangle(100);
    TEST_ASSERT_TRUE(SHOWN_OF(learned_up) == 0.0); // not in use
    TEST_ASSERT_TRUE(SIGNAL_OF(added) == 0.0);
    apply_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, 1);
    run_triangle(1);
    TEST_ASSERT_TRUE(SHOWN_OF(travel_up) > 0.9 * travel); // and other methods
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_FORGET));
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_WRONG_STATE, STATE_OF(outcome));
    command(REGISTERS_STOP);
    tick();
    command(REGISTERS_FORGET);
    tick();
    TEST_ASSERT_TRUE(SHOWN_OF(travel_up) == 0.0 && SHOWN_OF(travel_down) == 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, SHOWN_OF(relative_variance_up));
    have_travelled(10.0f);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 10.0, SHOWN_OF(travel_up));
    command(REGISTERS_FORGET);
    tick();
    start();
    run_triangle(20000);
    command(REGISTERS_APPLY);
    run_triangle(1);
    TEST_ASSERT_TRUE(SHOWN_OF(travel_up) > 0.0); // only FORGET begins anew
    apply_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, 2);
    command(REGISTERS_STOP);
    tick();
    command(REGISTERS_FORGET); // while another method is in use
    tick();
    apply_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, 1);
    tick();
    TEST_ASSERT_TRUE(SHOWN_OF(travel_up) == 0.0 && SHOWN_OF(travel_down) == 0.0);
}

/// A request waits while the learner has a sample, but not for params with another method, which learn nothing.
static void test_a_request_that_waits_for_the_learner_ends_with_its_params(void)
{
    for (uint32_t method = PARAMS_METHOD_FEEDFORWARD; method <= PARAMS_METHOD_OFF; method++)
    {
        apply_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, PARAMS_METHOD_FEEDFORWARD);
        tick();
        have_travelled(10.0f);
        registers.memory.state.exchange.owner = TRIBO_FEEDFORWARD_OWNER_LEARNER;
        command(REGISTERS_FORGET);
        tick();
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, 10.0, SHOWN_OF(travel_up));
        apply_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, method);
        tick();
        apply_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, PARAMS_METHOD_FEEDFORWARD);
        tick();
        registers.memory.state.exchange.owner = TRIBO_FEEDFORWARD_OWNER_TICK;
        tick();
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, method == PARAMS_METHOD_FEEDFORWARD ? 0.0 : 10.0, SHOWN_OF(travel_up));
    }
}

/// Makes a board without a sensor: no client can choose that.
static void have_no_sensor(void)
{
    const uint32_t none       = 0;
    defaults.method           = PARAMS_METHOD_SENSORLESS;
    defaults.guard_on         = 1;
    defaults.drive.tracking_n = 0.0f;
    memcpy((uint32_t *)&defaults + PARAMS_BREAKAWAY_SLOPE, &none, sizeof none);
}

static void check_method_is_refused(uint32_t method, float low, float high)
{
    write_word(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, method);
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_APPLY));
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_SET_REFUSED, STATE_OF(outcome));
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, STATE_OF(refused_register));
    TEST_ASSERT_EQUAL_FLOAT((float)method, (float)NUMBER_OF(refused_value));
    TEST_ASSERT_EQUAL_FLOAT(low, (float)NUMBER_OF(refused_low));
    TEST_ASSERT_EQUAL_FLOAT(high, (float)NUMBER_OF(refused_high));
    command(REGISTERS_REVERT);
}

/// The key lets a client change what protects, but not this.
static void test_no_client_says_whether_there_is_a_sensor(void)
{
    defaults.drive.tracking_n = 0.0f;
    power_up();
    tick();
    write_word(REQUEST_AT(unlock), REGISTERS_KEY);
    check_method_is_refused(PARAMS_METHOD_SENSORLESS, 0.0f, 2.0f);
    have_no_sensor();
    power_up();
    tick();
    write_word(REQUEST_AT(unlock), REGISTERS_KEY);
    for (uint32_t method = PARAMS_METHOD_PAPER; method <= PARAMS_METHOD_OFF; method++)
    {
        check_method_is_refused(method, 3.0f, 3.0f);
    }
    TEST_ASSERT_FALSE(loop_has_sensor(registers.drive.setup->params));
}

/// This happens where an image for another board takes over a flash.
static void test_saved_params_of_a_board_with_another_sensor_are_waited_for(void)
{
    static const uint32_t methods[] = {PARAMS_METHOD_SENSORLESS, PARAMS_METHOD_FEEDFORWARD};
    have_no_sensor();
    for (unsigned i = 0; i < 2u; i++)
    {
        memset(sectors, 0xff, sizeof sectors);
        defaults.method = methods[i];
        power_up();
        tick();
        command(REGISTERS_SAVE);
        run(10);
        TEST_ASSERT_EQUAL_UINT32(REGISTERS_DONE, STATE_OF(outcome));
        defaults.method = methods[1u - i];
        power_up();
        tick();
        TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT_STORE, STATE_OF(fault));
        TEST_ASSERT_EQUAL_UINT32(STORE_FOREIGN, STATE_OF(store));
        TEST_ASSERT_EQUAL_UINT32(REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, STATE_OF(refused_register));
        TEST_ASSERT_EQUAL_INT(i == 0u, loop_has_sensor(registers.drive.setup->params));
    }
}

static void test_a_drive_without_a_sensor_learns_and_forgets(void)
{
    have_no_sensor();
    power_up();
    tick();
    TEST_ASSERT_FALSE(loop_has_sensor(&registers.active->loop.params));
    TEST_ASSERT_FALSE(registers.active->loop.guard.on);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.007, SHOWN_OF(learned_up));
    have_travelled(2.0f);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 2.0, SHOWN_OF(travel_up));
    command(REGISTERS_FORGET);
    tick();
    TEST_ASSERT_TRUE(SHOWN_OF(travel_up) == 0.0);
    start();
    run(1000);
    TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
}
#endif

static void test_the_period_stays_that_of_the_board(void)
{
    start();
    check_refused("alone", DRIVE_AT(period_us), 500, 500.0f, 1000.0f, 1000.0f);
    write_word(DRIVE_AT(period_us), 2000);
    write_number(PARAM_AT(SAMPLE_TIME), 0.002f);
    write_number(PARAM_AT(PULSE_WIDTH), 0.006f);
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_APPLY));
    TEST_ASSERT_EQUAL_HEX32(DRIVE_AT(period_us), STATE_OF(refused_register));
    TEST_ASSERT_TRUE(NUMBER_OF(refused_low) == 1000.0 && NUMBER_OF(refused_high) == 1000.0);
}

static void test_the_full_scale_stays_in_run(void)
{
    start();
    write_number(DRIVE_AT(full_scale_n), 8.0f);
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_APPLY));
    TEST_ASSERT_EQUAL_HEX32(DRIVE_AT(full_scale_n), STATE_OF(refused_register));
    command(REGISTERS_STOP);
    tick();
    write_number(REQUEST_AT(reference), 1.0f);
    write_word(REQUEST_AT(unlock), REGISTERS_KEY);
    command(REGISTERS_APPLY);
    TEST_ASSERT_TRUE(read_number(REQUEST_AT(reference)) == 0.0);
}

static void test_the_full_scale_stays_once_a_start_is_asked_for(void)
{
    command(REGISTERS_START);
    write_number(DRIVE_AT(full_scale_n), 8.0f);
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_APPLY));
    TEST_ASSERT_EQUAL_HEX32(DRIVE_AT(full_scale_n), STATE_OF(refused_register));
}

static void test_a_breakaway_table_is_used(void)
{
    write_word(PARAM_AT(TABLE_LENGTH), 2);
    const float points[] = {0.0f, 0.01f, 0.01f, 1.0f, 0.3f, 0.3f};
    for (uint32_t i = 0; i < 6; i++)
    {
        write_number(REGISTERS_STAGED_AT + REGISTERS_TABLE_AT + 2u * i, points[i]);
    }
    command(REGISTERS_APPLY);
    start();
    TEST_ASSERT_EQUAL_UINT32(2, registers.active->loop.params.compensator.friction.table_length);
    run(10);
    write_number(REGISTERS_STAGED_AT + REGISTERS_TABLE_AT + 6u, 0.0f); // falls
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_APPLY));
    TEST_ASSERT_EQUAL_HEX32(REGISTERS_STAGED_AT + REGISTERS_TABLE_AT + 6u, STATE_OF(refused_register));
    TEST_ASSERT_EQUAL_UINT32(TRIBO_ERR_TABLE_FORCE, STATE_OF(refused_status));
}

// --- what may be written -------------------------------------------------------------------------------------------

static void test_half_a_register_is_neither_written_nor_half_a_frame(void)
{
    const uint16_t     values[6] = {0x3f80, 2, 0x3f80, 4, 0x3f80, 6}; // also numbers
    const params_set_t before    = registers.staged;
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS, map.write(map.context, REGISTERS_STAGED_AT, 1, values));
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS, map.write(map.context, REGISTERS_STAGED_AT + 1u, 2, values));
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS, map.write(map.context, REGISTERS_STAGED_AT, 3, values));
    const uint16_t last = REGISTERS_STAGED_AT + REGISTERS_TABLE_AT + 2u * 95u;
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS, map.write(map.context, last, 4, values));
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS, map.write(map.context, REGISTERS_STATE_AT, 2, values));
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS, map.write(map.context, REGISTERS_SIGNALS_AT, 2, values));
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS, map.write(map.context, REGISTERS_WINDOW_AT, 2, values));
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS, map.write(map.context, REGISTERS_COMMAND_AT, 2, values));
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS, map.write(map.context, 0xfffe, 2, values));
    TEST_ASSERT_EQUAL_MEMORY(&before, &registers.staged, sizeof before);
    uint16_t one = 0;
    TEST_ASSERT_EQUAL_INT(MODBUS_OK, map.read(map.context, REGISTERS_STAGED_AT + 1u, 1, &one));
    TEST_ASSERT_EQUAL_UINT16(1000, one);
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS, map.read(map.context, 0x0fff, 2, &one));
}

static void test_a_reference_beyond_what_is_credible_is_refused(void)
{
    start();
    write_number(REQUEST_AT(reference), 0.25f);
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_number(REQUEST_AT(reference), NAN));
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_number(REQUEST_AT(reference), INFINITY));
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_number(REQUEST_AT(reference), 2.01f));
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_number(REQUEST_AT(reference), -2.01f));
    tick();
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.25, SIGNAL_OF(r));
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.25, read_number(REQUEST_AT(reference)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, in_newton(board.command), SIGNAL_OF(u));
    TEST_ASSERT_TRUE(SIGNAL_OF(u) != 0.0);
    command(REGISTERS_STOP);
    tick();
    TEST_ASSERT_TRUE(SIGNAL_OF(u) == 0.0);
    tick();
    TEST_ASSERT_TRUE(SIGNAL_OF(r) == 0.0);
}

static void test_a_silent_bus_is_the_fault_of_the_reference(void)
{
    defaults.drive.reference_ms = 20;
    power_up();
    start();
    run(1000); // nobody has set one
    TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
    for (int i = 0; i < 100; i++)
    {
        write_number(REQUEST_AT(reference), 0.1f);
        run(15);
    }
    TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
    (void)STATE_OF(state); // reading does not renew it
    run(15);
    TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT, STATE_OF(state));
    TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT_REFERENCE, STATE_OF(fault));
}

static void test_commands_act_in_their_states(void)
{
    tick();
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_ACKNOWLEDGE));
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_WRONG_STATE, STATE_OF(outcome));
    start();
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_DONE, STATE_OF(outcome));
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_START));
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_TARE));
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_SAVE));
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_WRONG_STATE, STATE_OF(outcome));
    for (uint32_t unknown = 0; unknown <= UINT16_MAX; unknown++)
    {
        if (unknown == 0u || unknown > (DRIVE_FEEDFORWARD ? REGISTERS_FORGET : REGISTERS_TRACE_STOP))
        {
            TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_command((uint16_t)unknown));
        }
    }
    board.inputs = PORT_INPUT_EMERGENCY_STOP;
    tick();
    TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT, STATE_OF(state));
    TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT_EMERGENCY_STOP, STATE_OF(fault));
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_START));
    board.inputs = 0;
    command(REGISTERS_ACKNOWLEDGE);
    tick();
    TEST_ASSERT_EQUAL_UINT32(DRIVE_IDLE, STATE_OF(state));
}

// --- the store -----------------------------------------------------------------------------------------------------

static void save(void)
{
    command(REGISTERS_SAVE);
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_BUSY, STATE_OF(outcome));
    TEST_ASSERT_EQUAL_INT(MODBUS_BUSY, try_command(REGISTERS_START));
    tick();
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_DONE, STATE_OF(outcome));
}

static void test_saved_params_are_those_of_the_next_power_up(void)
{
    TEST_ASSERT_EQUAL_UINT32(STORE_EMPTY, STATE_OF(store));
    write_number(PARAM_AT(GAIN), 0.5f);
    command(REGISTERS_APPLY);
    tick();
    save();
    power_up();
    TEST_ASSERT_EQUAL_UINT32(STORE_OK, STATE_OF(store));
    TEST_ASSERT_EQUAL_UINT32(DRIVE_IDLE, STATE_OF(state));
    TEST_ASSERT_TRUE(read_number(TO_ACTIVE(PARAM_AT(GAIN))) == 0.5);
    TEST_ASSERT_TRUE(read_number(PARAM_AT(GAIN)) == 0.5);
    command(REGISTERS_DEFAULTS);
    TEST_ASSERT_TRUE(read_number(PARAM_AT(GAIN)) == (double)0.85f);
    start();
}

/// The start comes from a client whose tick has not come yet, or from the board's own line.
static void test_a_start_just_before_a_save_prevents_it(void)
{
    tick();
    command(REGISTERS_START);
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_SAVE));
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_WRONG_STATE, STATE_OF(outcome));
    command(REGISTERS_STOP);
    tick();
    command(REGISTERS_SAVE);
    drive_start(&registers.drive);
    registers_run(&registers);
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_NOT_SAVED, STATE_OF(outcome));
    tick();
    TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
    TEST_ASSERT_EQUAL_HEX32(0xffffffff, sectors[0][2]);
}

static uint8_t late_frame[8]; ///< comes while the flash is busy

static void put_late_frame(void)
{
    memcpy(registers.modbus.frame, late_frame, sizeof late_frame);
    registers.modbus.length   = sizeof late_frame;
    registers.modbus.complete = true;
}

static void test_what_came_during_a_save_does_not_start(void)
{
    static const uint8_t start_frame[8] = {1, 6, 1, 0, 0, 1, 0x49, 0xf6};
    static const uint8_t stop_frame[8]  = {1, 6, 1, 0, 0, 2, 0x09, 0xf7};
    const uint8_t *const frames[]       = {start_frame, stop_frame};
    on_erase                            = put_late_frame;
    for (unsigned i = 0; i < 2u; i++)
    {
        const uint32_t stops      = registers.drive.stops;
        const uint32_t exceptions = registers.modbus.exceptions;
        const uint32_t executed   = registers.modbus.frames;
        memcpy(late_frame, frames[i], sizeof late_frame);
        write_number(PARAM_AT(GAIN), 0.3f + 0.1f * (float)i);
        command(REGISTERS_APPLY);
        tick();
        command(REGISTERS_SAVE);
        run(5);
        TEST_ASSERT_EQUAL_UINT32(DRIVE_IDLE, STATE_OF(state));
        TEST_ASSERT_EQUAL_UINT32(REGISTERS_DONE, STATE_OF(outcome));
        TEST_ASSERT_EQUAL_UINT32(executed + 1u, registers.modbus.frames);
        TEST_ASSERT_EQUAL_UINT32(stops + i, registers.drive.stops);
        TEST_ASSERT_EQUAL_UINT32(exceptions + 1u - i, registers.modbus.exceptions);
    }
    on_erase = NULL;
}

/// The client need not repeat the stop, and the outcome stays that of the save.
static void test_a_stop_acts_while_a_save_waits(void)
{
    const uint16_t stop = REGISTERS_STOP;
    command(REGISTERS_SAVE);
    const uint32_t stops = registers.drive.stops;
    TEST_ASSERT_EQUAL_INT(MODBUS_BUSY, try_command(REGISTERS_START));
    TEST_ASSERT_EQUAL_INT(MODBUS_BUSY, try_word(REQUEST_AT(unlock), REGISTERS_KEY));
    TEST_ASSERT_EQUAL_INT(MODBUS_OK, try_command(REGISTERS_STOP));
    TEST_ASSERT_EQUAL_UINT32(stops + 1u, registers.drive.stops);
    TEST_ASSERT_EQUAL_INT(MODBUS_OK, map.stop(map.context, REGISTERS_COMMAND_AT, 1, &stop));
    TEST_ASSERT_EQUAL_UINT32(stops + 2u, registers.drive.stops);
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_BUSY, STATE_OF(outcome));
    tick();
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_DONE, STATE_OF(outcome));
}

static void test_those_who_may_only_stop_do_nothing_else(void)
{
    command(REGISTERS_START);
    run(10);
    const uint16_t values[] = {REGISTERS_STOP, REGISTERS_STOP};
    for (uint32_t address = 0; address < 0x3000u; address++)
    {
        const uint16_t at = (uint16_t)address;
        TEST_ASSERT_EQUAL_INT(MODBUS_BUSY, map.stop(map.context, at, 2, values));
        TEST_ASSERT_TRUE(map.stop(map.context, at, 1, values) == MODBUS_BUSY || at == REGISTERS_COMMAND_AT);
    }
    tick();
    TEST_ASSERT_EQUAL_UINT32(DRIVE_IDLE, STATE_OF(state));
    for (uint32_t number = 0; number <= UINT16_MAX; number++)
    {
        const uint16_t word = (uint16_t)number;
        TEST_ASSERT_EQUAL_INT(number == REGISTERS_STOP ? MODBUS_OK : MODBUS_BUSY,
                              map.stop(map.context, REGISTERS_COMMAND_AT, 1, &word));
    }
    tick();
    TEST_ASSERT_EQUAL_UINT32(DRIVE_IDLE, STATE_OF(state));
}

#define CLIENT_TICKS (REGISTERS_CLIENT_S * 1000u)

static void test_the_key_and_a_staged_set_end_with_their_client(void)
{
    for (int way = 0; way < 2; way++) // it says so, or is silent
    {
        write_word(REQUEST_AT(unlock), REGISTERS_KEY);
        write_number(PARAM_AT(GAIN), 0.5);
        run(CLIENT_TICKS - 1u);
        TEST_ASSERT_TRUE(STATE_OF(unlocked_ticks) > 0u);
        TEST_ASSERT_TRUE(read_number(PARAM_AT(GAIN)) == 0.5);
        if (way == 0)
        {
            registers_forget_client(&registers);
        }
        else
        {
            run(3);
        }
        TEST_ASSERT_EQUAL_UINT32(0, STATE_OF(unlocked_ticks));
        TEST_ASSERT_TRUE(read_number(PARAM_AT(GAIN)) == read_number(TO_ACTIVE(PARAM_AT(GAIN))));
    }
}

static void test_a_client_that_asks_now_and_then_keeps_its_set(void)
{
    write_number(PARAM_AT(GAIN), 0.5);
    for (int i = 0; i < 3; i++)
    {
        run(CLIENT_TICKS - 1u);
        registers.modbus.heard++;
        tick();
    }
    TEST_ASSERT_TRUE(read_number(PARAM_AT(GAIN)) == 0.5);
    command(REGISTERS_DEFAULTS);
    write_number(PARAM_AT(GAIN), 0.4f);
    command(REGISTERS_APPLY);
    command(REGISTERS_DEFAULTS); // is its set, too
    run(CLIENT_TICKS + 2u);
    TEST_ASSERT_TRUE(read_number(PARAM_AT(GAIN)) == (double)0.4f);
}

static uint32_t outcome_of_save(float gain)
{
    write_number(PARAM_AT(GAIN), gain);
    command(REGISTERS_APPLY);
    tick();
    command(REGISTERS_SAVE);
    tick();
    return STATE_OF(outcome);
}

/// A client that saves again and again must not wear the flash, whose sectors take 10,000 erasures.
static void test_a_storm_of_saves_erases_little(void)
{
    tick();
    erasures = 0;
    for (unsigned i = 0; i < 10u * REGISTERS_SAVES; i++)
    {
        const uint32_t due = i < REGISTERS_SAVES ? REGISTERS_DONE : REGISTERS_SAVED_OFTEN;
        TEST_ASSERT_EQUAL_UINT32(due, outcome_of_save(0.1f + 0.001f * (float)i));
    }
    TEST_ASSERT_EQUAL_UINT(REGISTERS_SAVES, erasures);
    TEST_ASSERT_EQUAL_UINT32(STORE_OK, STATE_OF(store));
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_DONE,
                             outcome_of_save(0.1f + 0.001f * (float)(REGISTERS_SAVES - 1u))); // what it has
    for (unsigned hour = 1; hour <= 3u; hour++)
    {
        registers.drive.ticks = hour * REGISTERS_SAVE_S * 1000u - 100u;
        TEST_ASSERT_EQUAL_UINT32(REGISTERS_SAVED_OFTEN, outcome_of_save(0.5f));
        run(100);
        TEST_ASSERT_EQUAL_UINT32(REGISTERS_DONE, outcome_of_save(0.6f + 0.01f * (float)hour));
        TEST_ASSERT_EQUAL_UINT32(REGISTERS_SAVED_OFTEN, outcome_of_save(0.5f));
    }
    TEST_ASSERT_EQUAL_UINT(REGISTERS_SAVES + 3u, erasures);
    power_up();
    TEST_ASSERT_TRUE(read_number(TO_ACTIVE(PARAM_AT(GAIN))) == (double)(0.6f + 0.01f * 3.0f));
}

static void test_a_tare_is_saved(void)
{
    defaults.drive.tare_max_n = 0.5f;
    power_up();
    tick();
    force_n = 0.2;
    command(REGISTERS_TARE);
    for (unsigned i = 0; i <= DRIVE_TARE_TICKS; i++)
    {
        force_n = 0.2;
        tick();
    }
    TEST_ASSERT_EQUAL_UINT32(DRIVE_TARE_DONE, STATE_OF(tare));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.2, read_number(TO_ACTIVE(DRIVE_AT(sensor_zero_units))));
    save();
    power_up();
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 0.2, read_number(DRIVE_AT(sensor_zero_units)));
}

/// The store does not hold what the drive can run with: it says so and waits for a set.
static void check_waits(store_status_t status)
{
    power_up();
    run(3);
    TEST_ASSERT_EQUAL_UINT32(status, STATE_OF(store));
    TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT, STATE_OF(state));
    TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT_STORE, STATE_OF(fault));
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_ACKNOWLEDGE));
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_NO_PARAMS, STATE_OF(outcome));
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_SAVE));
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_START));
    run(3);
    TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT, STATE_OF(state));
    command(REGISTERS_DEFAULTS);
    command(REGISTERS_APPLY);
    tick();
    TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT, STATE_OF(state));
    command(REGISTERS_ACKNOWLEDGE);
    tick();
    TEST_ASSERT_EQUAL_UINT32(DRIVE_IDLE, STATE_OF(state));
    save();
    power_up();
    TEST_ASSERT_EQUAL_UINT32(STORE_OK, STATE_OF(store));
    start();
}

static void test_a_damaged_store_is_reported_and_needs_a_new_set(void)
{
    save();
    sectors[0][STORE_HEAD_WORDS + 3u] ^= 0x100u;
    check_waits(STORE_DAMAGED);
}

static void test_a_store_of_other_firmware_is_reported_and_needs_a_new_set(void)
{
    uint32_t words[PARAMS_WORDS] = {0};
    TEST_ASSERT_EQUAL_INT(STORE_OK, store_write(&flash, PARAMS_LAYOUT + 1u, words, PARAMS_WORDS));
    check_waits(STORE_FOREIGN);
}

static void test_saved_params_that_the_board_refuses_are_reported_and_need_a_new_set(void)
{
    uint32_t    words[PARAMS_WORDS];
    const float good = 0.85f, bad = 3.0f;
    memcpy((uint32_t *)&defaults + PARAMS_GAIN, &bad, sizeof bad);
    memcpy(words, &defaults, sizeof words);
    TEST_ASSERT_EQUAL_INT(STORE_OK, store_write(&flash, PARAMS_LAYOUT, words, PARAMS_WORDS));
    memcpy((uint32_t *)&defaults + PARAMS_GAIN, &good, sizeof good);
    power_up();
    TEST_ASSERT_EQUAL_HEX32(PARAM_AT(GAIN), STATE_OF(refused_register));
    TEST_ASSERT_TRUE(read_number(PARAM_AT(GAIN)) == 3.0); // what was saved is there to be looked at
    check_waits(STORE_FOREIGN);
}

static void test_a_failed_self_test_comes_before_the_store(void)
{
    save();
    sectors[0][STORE_HEAD_WORDS] ^= 1u;
    power_up_with(DRIVE_FAULT_RAM);
    TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT_RAM, STATE_OF(fault));
    power_up_with(DRIVE_FAULT_WATCHDOG);
    TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT_STORE, STATE_OF(fault));
}

// --- traces --------------------------------------------------------------------------------------------------------

static double sample_of(uint32_t number, uint32_t channel)
{
    write_word(REQUEST_AT(position), number);
    return read_number(REGISTERS_WINDOW_AT + 2u * channel);
}

static void test_a_fault_keeps_200_ticks_before_it(void)
{
    double y[2000], u[2000];
    start();
    for (unsigned i = 0; i < 500; i++)
    {
        write_number(REQUEST_AT(reference), 0.3f + 0.001f * (float)(i % 100u));
        y[ticks + 1u] = force_n;
        tick();
        u[ticks] = in_newton(board.command);
    }
    board.inputs = PORT_INPUT_EMERGENCY_STOP;
    run(100);
    write_word(REQUEST_AT(which), 1);
    TEST_ASSERT_EQUAL_UINT32(TRACE_DONE, STATE_OF(trace_state));
    TEST_ASSERT_EQUAL_UINT32(0x47, STATE_OF(trace_signals_seen));
    const uint32_t trigger = STATE_OF(trace_trigger);
    const uint32_t tick_0  = STATE_OF(trace_first_tick);
    TEST_ASSERT_EQUAL_UINT32(STATE_OF(fault_tick), tick_0 + trigger);
    TEST_ASSERT_EQUAL_UINT32(216, STATE_OF(trace_held));
    for (uint32_t i = trigger - 200u; i < trigger; i++)
    {
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, y[tick_0 + i], sample_of(i, 1));
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, u[tick_0 + i], sample_of(i, 2));
    }
    TEST_ASSERT_TRUE(sample_of(trigger, 2) == 0.0);

    board.inputs = 0; // the fault can still be read after its acknowledgement, up to the next start
    command(REGISTERS_ACKNOWLEDGE);
    run(10);
    TEST_ASSERT_EQUAL_UINT32(TRACE_DONE, STATE_OF(trace_state));
    command(REGISTERS_START);
    run(10);
    TEST_ASSERT_EQUAL_UINT32(TRACE_ARMED, STATE_OF(trace_state));
}

static void test_a_trace_is_read_while_the_drive_runs(void)
{
    start();
    write_number(REQUEST_AT(reference), 0.5f);
    write_word(REQUEST_AT(signals), 1u << REGISTERS_SIGNAL_y | 1u << REGISTERS_SIGNAL_e);
    write_word(REQUEST_AT(decimation), 3);
    write_word(REQUEST_AT(trigger), TRACE_RISE);
    write_word(REQUEST_AT(watched), REGISTERS_SIGNAL_y);
    write_number(REQUEST_AT(level), 0.25f);
    write_word(REQUEST_AT(after), 50);
    command(REGISTERS_TRACE);
    TEST_ASSERT_EQUAL_UINT32(TRACE_ARMED, STATE_OF(trace_state));
    run(1000);
    TEST_ASSERT_EQUAL_UINT32(TRACE_DONE, STATE_OF(trace_state));
    TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
    const uint32_t trigger = STATE_OF(trace_trigger);
    TEST_ASSERT_EQUAL_UINT32(trigger + 51u, STATE_OF(trace_count));
    TEST_ASSERT_TRUE(sample_of(trigger, 0) < 0.26 && sample_of(trigger + 1u, 0) >= 0.25);
    uint16_t values[2u * REGISTERS_WINDOW];
    write_word(REQUEST_AT(position), trigger);
    TEST_ASSERT_EQUAL_INT(MODBUS_OK, map.read(map.context, REGISTERS_WINDOW_AT, 2u * REGISTERS_WINDOW, values));
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_ADDRESS,
                          map.read(map.context, REGISTERS_WINDOW_AT + 2u * REGISTERS_WINDOW, 2, values));
    write_word(REQUEST_AT(position), trigger + 51u); // not recorded
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, map.read(map.context, REGISTERS_WINDOW_AT, 2, values));
    for (uint32_t i = 0; i < trigger + 51u; i++)
    {
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5, sample_of(i, 0) + sample_of(i, 1));
    }
    command(REGISTERS_TRACE_STOP);
    TEST_ASSERT_EQUAL_UINT32(TRACE_STOPPED, STATE_OF(trace_state));
}

/// 0.5 N, 1.23 N, 500 mN and 0.3 N by masters of other orders: the low word first, all bytes reversed, an integer. The last
/// two are normal numbers: -1.6e-23 and 9.6e-13.
static const uint32_t unmeant[] =
    {0x00003f00u, 0x0000003fu, 0x00003e80u, 500u, 1u, 0x007fffffu, 0x807fffffu, 0x80000001u, 0x999a3e99u, 0x2b87ce00u};

static void test_an_implausible_reference_is_refused(void)
{
    start();
    write_number(REQUEST_AT(reference), 0.25f);
    for (size_t i = 0; i < sizeof unmeant / sizeof unmeant[0]; i++)
    {
        TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_word(REQUEST_AT(reference), unmeant[i]));
        TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_word(REQUEST_AT(level), unmeant[i]));
    }
    tick();
    TEST_ASSERT_DOUBLE_WITHIN(1e-7, 0.25, SIGNAL_OF(r));
    write_word(REQUEST_AT(reference), 0x80000000u); // -0 is 0
    tick();
    TEST_ASSERT_EQUAL_HEX32(0, read_word(REQUEST_AT(reference)));
    write_number(REQUEST_AT(reference), -1.001e-9f);
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_word(REQUEST_AT(reference), 0x3089705eu)); // 0.999e-9
    write_word(REQUEST_AT(decimation), 1u);                                                    // a whole number
}

static bool has_same_words(const params_set_t *a, const params_set_t *b)
{
    uint32_t word = 0;
    while (word < PARAMS_WORDS && params_word(a, word) == params_word(b, word))
    {
        word++;
    }
    return word == PARAMS_WORDS;
}

/// Each float of a set, and no whole number, which would look the same.
static void test_an_implausible_param_is_refused(void)
{
    const params_set_t before  = registers.staged;
    unsigned           numbers = 0;
    for (uint32_t address = REGISTERS_STAGED_AT; address < REGISTERS_ACTIVE_AT; address += 2u)
    {
        uint16_t values[2];
        if (map.read(map.context, (uint16_t)address, 2, values) != MODBUS_OK)
        {
            continue;
        }
        const uint32_t        was    = read_word(address);
        const modbus_status_t status = try_word(address, 500u);
        const bool is_whole = !has_same_words(&before, &registers.staged) || (was == 500u && status == MODBUS_OK);
        TEST_ASSERT_EQUAL_INT(is_whole ? MODBUS_OK : MODBUS_ILLEGAL_VALUE, status);
        write_word(address, was);
        numbers += !is_whole;
        if (!is_whole)
        {
            write_word(address, 0x80000000u);
            TEST_ASSERT_EQUAL_HEX32(0, read_word(address));
            write_word(address, was);
        }
    }
    unsigned floats = 5u * TRIBO_BIQUAD_SECTIONS_MAX + 3u * TRIBO_BREAKAWAY_POINTS_MAX;
    for (uint32_t i = 0; i < DRIVE_CONFIG_COUNT; i++)
    {
        floats += drive_config_fields[i].is_float;
    }
    TEST_ASSERT_EQUAL_UINT(floats + PARAMS_LOOP_COUNT - 2u + PARAMS_FEED_COUNT +
                               (PARAMS_GUARD_COUNT > 0 ? PARAMS_GUARD_COUNT - 1u : 0u),
                           numbers);
}

/// The set comes from a board's own image or from a store.
static void test_a_set_with_an_implausible_number_is_refused(void)
{
    static params_t params;
    params_error_t  error;
    params.set                   = defaults;
    params.words[PARAMS_DAMPING] = 500u;
    TEST_ASSERT_FALSE(params_make(&params, &board.port, &error));
    TEST_ASSERT_EQUAL_UINT32(PARAMS_DAMPING, error.word);
    params.set                                  = defaults;
    params.words[DRIVE_CONFIG_safe_reference_n] = 0x80000001u;
    TEST_ASSERT_FALSE(params_make(&params, &board.port, &error));
    TEST_ASSERT_EQUAL_UINT32(DRIVE_CONFIG_safe_reference_n, error.word);
    params.set                            = defaults;
    params.words[PARAMS_SECTIONS_AT + 7u] = 0x007fffffu;
    TEST_ASSERT_FALSE(params_make(&params, &board.port, &error));
    TEST_ASSERT_EQUAL_UINT32(PARAMS_SECTIONS_AT + 7u, error.word);
    params.set = defaults; // of a row that the table does not use
    memcpy(&params.words[PARAMS_TABLE_AT + 90u], &(float){-INFINITY}, sizeof(float));
    TEST_ASSERT_FALSE(params_make(&params, &board.port, &error));
    TEST_ASSERT_EQUAL_UINT32(PARAMS_TABLE_AT + 90u, error.word);
}

static void test_a_trace_out_of_range_is_refused(void)
{
    static const struct
    {
        uint32_t at, word;
    } wrong[] = {{REQUEST_AT(signals), 0},
                 {REQUEST_AT(signals), 0x1ff},
                 {REQUEST_AT(signals), 1u << REGISTERS_SIGNAL_COUNT},
                 {REQUEST_AT(decimation), 0},
                 {REQUEST_AT(trigger), TRACE_TRIGGERS},
                 {REQUEST_AT(trigger), UINT32_MAX},
                 {REQUEST_AT(after), RING_WORDS}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
    {
        const uint32_t was = read_word(wrong[i].at);
        write_word(wrong[i].at, wrong[i].word);
        TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_TRACE));
        TEST_ASSERT_EQUAL_UINT32(REGISTERS_TRACE_REFUSED, STATE_OF(outcome));
        TEST_ASSERT_EQUAL_HEX32(wrong[i].at == REQUEST_AT(after) ? REQUEST_AT(after) : 0u, STATE_OF(refused_register));
        write_word(wrong[i].at, was);
    }
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_number(REQUEST_AT(level), NAN));
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_number(REQUEST_AT(level), nextafterf(-1e6f, -2e6f)));
    TEST_ASSERT_EQUAL_INT(MODBUS_OK, try_number(REQUEST_AT(level), -1e6f));
    write_word(REQUEST_AT(trigger), TRACE_RISE);
    write_word(REQUEST_AT(watched), REGISTERS_SIGNAL_COUNT);
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_TRACE));
    write_word(REQUEST_AT(watched), 0);
    command(REGISTERS_TRACE);
}

#include "runners/test_registers.inc" // main
