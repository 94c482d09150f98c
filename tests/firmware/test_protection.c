// What protects the rig: nobody changes it while the drive runs, nobody at rest without the key, and nobody beyond the board's
// ceilings. First one rule a test, then a client that tries everything. TRIBO_WRITES=1000000 lets it write that often.

#include "app/crc32.h"
#include "registers_host.h"
#include "runs.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PERIOD_US    1000u
#define UNLOCK_TICKS (REGISTERS_UNLOCK_S * 1000000u / PERIOD_US)

static uint32_t ring[64];
static double   force_n; ///< of a plant that follows u with a lag

static const params_ceiling_t ceilings[] = {{PARAMS_U_MAX, 0.0f, 3.0f},
                                            {PARAMS_U_MIN, -3.0f, 0.0f},
                                            {DRIVE_CONFIG_residual_n, 1e-6f, 0.5f},
                                            {DRIVE_CONFIG_sensor_zero_units, -0.5f, 0.5f},
                                            {DRIVE_CONFIG_command_limit_ms, 1.0f, 1000.0f}};

// --- a board -------------------------------------------------------------------------------------------------------

static void power_up_under(uint32_t ceiling_count)
{
    const registers_board_t parts = {.port          = &board.port,
                                     .line          = &line,
                                     .flash         = &flash,
                                     .defaults      = &defaults,
                                     .ceilings      = ceilings,
                                     .ceiling_count = ceiling_count,
                                     .baud          = 115200,
                                     .ring          = ring,
                                     .ring_words    = sizeof ring / sizeof ring[0]};
    board_init(&board, UINT32_MAX - 20u * PERIOD_US);
    board.port.measures |= PORT_MEASURES_POSITION;
    registers_load(&registers, &parts);
    registers_start(&registers, DRIVE_FAULT_NONE);
    map     = registers_map(&registers);
    force_n = 0.0;
}

static void power_up(void)
{
    power_up_under(sizeof ceilings / sizeof ceilings[0]);
}

void setUp(void)
{
    memset(sectors, 0xff, sizeof sectors);
    defaults                  = params_default();
    defaults.drive.residual_n = 0.4f;
    defaults.drive.tare_max_n = 0.5f;
    defaults.drive.debounce_n = 2; // so that one more or one less is allowed
    defaults.drive.debounce_m = 4;
    power_up();
}

static void tick(void)
{
    board_new_tick(&board);
    board.y = board_force(force_n);
    registers_tick(&registers);
    registers_run(&registers);
    force_n += ((double)scaling_value(board.command, BOARD_FULL_SCALE_N) - force_n) * 0.05;
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

static uint32_t bits_of(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static float number_of(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

#define U_MAX_AT (REGISTERS_STAGED_AT + 0x106u)
#define GAIN_AT  (REGISTERS_STAGED_AT + 0x108u)

/// Returns the register of a word in front of the sections.
static uint32_t register_of(uint32_t word)
{
    return REGISTERS_STAGED_AT + (word < (uint32_t)PARAMS_LOOP_AT ? REGISTERS_DRIVE_AT + 2u * word
                                                                  : REGISTERS_LOOP_AT + 2u * (word - PARAMS_LOOP_AT));
}

static void start(void)
{
    command(REGISTERS_START);
    tick();
    TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
}

static void unlock(void)
{
    write_word(REQUEST_AT(unlock), REGISTERS_KEY);
}

// --- one rule a test -----------------------------------------------------------------------------------------------

/// A value of a word that protects which is another one and, but for the period and what goes with it, allowed.
static uint32_t other_value(uint32_t word)
{
    const uint32_t is = params_word(&registers.active->set, word);
    if (word >= (uint32_t)DRIVE_CONFIG_COUNT)
    {
        return bits_of(number_of(is) != 0.0f ? 0.75f * number_of(is) : 0.125f);
    }
    const drive_config_field_t *field = &drive_config_fields[word];
    if (field->is_float)
    {
        return bits_of(number_of(is) != 0.0f ? 0.75f * number_of(is) : field->low > 0.0f ? 100.0f : 0.125f);
    }
    return field->high == 1.0f ? 1u - is : word == DRIVE_CONFIG_crystal_hz ? 16000000u : is + 1u;
}

static bool is_bound_to_the_tick(uint32_t word)
{
    return word == DRIVE_CONFIG_period_us || word == (uint32_t)PARAMS_SAMPLE_TIME || // refused for each other
           (word == DRIVE_CONFIG_full_scale_n && TRIBO_IS_Q31);                      // below twice u_max
}

/// These params do not change with the key either.
static bool is_wiring(uint32_t word)
{
    return word == DRIVE_CONFIG_ready_level || word == DRIVE_CONFIG_fault_level ||
           word == DRIVE_CONFIG_sensor_reversed || word == DRIVE_CONFIG_command_reversed ||
           word == DRIVE_CONFIG_crystal_hz || word == DRIVE_CONFIG_degraded_clock ||
           word == DRIVE_CONFIG_motion_reversed;
}

static void stage(uint32_t address, uint32_t word)
{
    command(REGISTERS_REVERT);
    write_word(address, word);
}

static void check_refused(uint32_t address, uint32_t outcome)
{
    const params_set_t         active     = registers.active->set;
    const drive_setup_t *const setup      = drive_setup(&registers.drive);
    const uint32_t             protection = STATE_OF(protection);
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_APPLY));
    TEST_ASSERT_EQUAL_UINT32(outcome, STATE_OF(outcome));
    TEST_ASSERT_EQUAL_HEX32(address, STATE_OF(refused_register));
    TEST_ASSERT_EQUAL_HEX32(STATE_OF(refused_low), STATE_OF(refused_high));
    tick();
    TEST_ASSERT_EQUAL_MEMORY(&active, &registers.active->set, sizeof active);
    TEST_ASSERT_EQUAL_PTR(setup, drive_setup(&registers.drive));
    TEST_ASSERT_EQUAL_HEX32(protection, STATE_OF(protection));
    TEST_ASSERT_EQUAL_UINT32(0, STATE_OF(protection_changes));
}

static unsigned check_every_word(uint32_t outcome)
{
    unsigned checked = 0;
    uint32_t place   = 0;
    for (uint32_t word = params_next_protecting(&place); word < PARAMS_WORDS; word = params_next_protecting(&place))
    {
        if (!is_bound_to_the_tick(word))
        {
            stage(register_of(word), other_value(word));
            check_refused(register_of(word), is_wiring(word) ? (uint32_t)REGISTERS_SET_REFUSED : outcome);
            checked++;
        }
    }
    return checked;
}

static void test_nothing_that_protects_changes_in_run(void)
{
    start();
    TEST_ASSERT_GREATER_THAN_UINT(30, check_every_word(REGISTERS_PROTECTED));
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_word(REQUEST_AT(unlock), REGISTERS_KEY));
    TEST_ASSERT_EQUAL_UINT32(0, STATE_OF(unlocked_ticks));
    stage(U_MAX_AT, bits_of(1.5f));
    check_refused(U_MAX_AT, REGISTERS_PROTECTED);
}

static void test_nothing_that_protects_changes_at_rest_while_it_is_locked(void)
{
    tick();
    TEST_ASSERT_GREATER_THAN_UINT(30, check_every_word(REGISTERS_LOCKED));
}

static void test_what_tunes_changes_in_run_without_a_key(void)
{
    const uint32_t protection = STATE_OF(protection);
    start();
    stage(GAIN_AT, bits_of(0.5f));
    command(REGISTERS_APPLY);
    tick();
    TEST_ASSERT_EQUAL_FLOAT(0.5f, number_of(read_word(TO_ACTIVE(GAIN_AT))));
    TEST_ASSERT_EQUAL_HEX32(protection, STATE_OF(protection));
    TEST_ASSERT_EQUAL_UINT32(0, STATE_OF(protection_changes));
}

static void test_a_change_at_rest_with_the_key_is_counted_and_kept(void)
{
    const uint32_t protection = STATE_OF(protection);
    run(7);
    unlock();
    TEST_ASSERT_EQUAL_UINT32(UNLOCK_TICKS, STATE_OF(unlocked_ticks));
    TEST_ASSERT_EQUAL_UINT32(0, read_word(REQUEST_AT(unlock)));
    stage(U_MAX_AT, bits_of(2.5f));
    write_word(DRIVE_AT(residual_ms), 80);
    command(REGISTERS_APPLY);
    tick();
    TEST_ASSERT_TRUE(protection != STATE_OF(protection));
    TEST_ASSERT_EQUAL_UINT32(2, STATE_OF(protection_changes));
    TEST_ASSERT_EQUAL_UINT32(7, read_word(REGISTERS_CHANGES_AT));
    TEST_ASSERT_EQUAL_HEX32(DRIVE_AT(residual_ms), read_word(REGISTERS_CHANGES_AT + 2));
    TEST_ASSERT_EQUAL_UINT32(50, read_word(REGISTERS_CHANGES_AT + 4));
    TEST_ASSERT_EQUAL_UINT32(80, read_word(REGISTERS_CHANGES_AT + 6));
    TEST_ASSERT_EQUAL_HEX32(U_MAX_AT, read_word(REGISTERS_CHANGES_AT + 10));
    TEST_ASSERT_EQUAL_FLOAT(2.0f, number_of(read_word(REGISTERS_CHANGES_AT + 12)));
    TEST_ASSERT_EQUAL_FLOAT(2.5f, number_of(read_word(REGISTERS_CHANGES_AT + 14)));
    stage(U_MAX_AT, bits_of(2.0f));
    write_word(DRIVE_AT(residual_ms), 50);
    command(REGISTERS_APPLY);
    TEST_ASSERT_EQUAL_HEX32(protection, STATE_OF(protection)); // what it was
    TEST_ASSERT_EQUAL_UINT32(4, STATE_OF(protection_changes));
}

/// The signs and levels at its pins and its crystal are as the image says, or as the store of another image does not.
static void test_no_key_turns_a_sign_a_level_or_the_clock(void)
{
    const drive_config_t is = defaults.drive;
    tick();
    unlock();
    for (uint32_t word = 0; word < (uint32_t)DRIVE_CONFIG_COUNT; word++)
    {
        if (is_wiring(word))
        {
            stage(register_of(word), other_value(word));
            check_refused(register_of(word), REGISTERS_SET_REFUSED);
        }
    }
    command(REGISTERS_SAVE);
    tick();
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_DONE, STATE_OF(outcome));
    defaults.drive.command_reversed = 1;
    power_up();
    TEST_ASSERT_EQUAL_UINT32(STORE_FOREIGN, STATE_OF(store));
    TEST_ASSERT_EQUAL_HEX32(DRIVE_AT(command_reversed), STATE_OF(refused_register));
    defaults.drive = is;
}

/// The count is of all, and the last ones are kept.
static void test_of_a_set_that_changes_much_the_last_changes_are_kept(void)
{
    static const uint32_t words[] = {DRIVE_CONFIG_residual_n,
                                     DRIVE_CONFIG_residual_ms,
                                     DRIVE_CONFIG_tracking_n,
                                     DRIVE_CONFIG_tracking_ms};
    uint32_t              applied = 0;
    tick();
    unlock();
    command(REGISTERS_REVERT);
    for (float x = 1.0f; applied < 3u * REGISTERS_CHANGES; x += 1.0f)
    {
        for (size_t i = 0; i < sizeof words / sizeof words[0]; i++, applied++)
        {
            const bool is_float = drive_config_fields[words[i]].is_float;
            write_word(register_of(words[i]), is_float ? bits_of(0.01f * x) : 10u * (uint32_t)x);
        }
        command(REGISTERS_APPLY);
        tick();
    }
    TEST_ASSERT_EQUAL_UINT32(applied, STATE_OF(protection_changes));
    for (uint32_t n = applied - REGISTERS_CHANGES; n < applied; n++)
    {
        const uint32_t at   = REGISTERS_CHANGES_AT + n % REGISTERS_CHANGES * (uint32_t)sizeof(registers_change_t) / 2u;
        const uint32_t word = words[n % 4u];
        TEST_ASSERT_EQUAL_HEX32(register_of(word), read_word(at + 2u));
        if (n >= applied - 4u)
        {
            TEST_ASSERT_EQUAL_HEX32(params_word(&registers.active->set, word), read_word(at + 6u));
        }
    }
}

static void check_locked(void)
{
    TEST_ASSERT_EQUAL_UINT32(0, STATE_OF(unlocked_ticks));
    stage(U_MAX_AT, bits_of(1.5f));
    check_refused(U_MAX_AT, REGISTERS_LOCKED);
}

static void test_the_key_lasts_for_a_minute(void)
{
    tick();
    unlock();
    for (uint32_t i = 0; i < UNLOCK_TICKS - 1u; i++)
    {
        registers.modbus.heard++; // its client asks for something, or the key would end with it
        tick();
    }
    TEST_ASSERT_EQUAL_UINT32(1, STATE_OF(unlocked_ticks));
    tick();
    check_locked();
    registers.drive.ticks = registers.unlocked_at; // as after 2^32 ticks
    check_locked();
}

static void test_a_start_and_every_other_value_lock(void)
{
    tick();
    unlock();
    start();
    command(REGISTERS_STOP);
    tick();
    check_locked();
    unlock();
    write_word(REQUEST_AT(unlock), 0);
    check_locked();
    unlock();
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_word(REQUEST_AT(unlock), REGISTERS_KEY + 1u));
    check_locked();
}

static void test_a_key_comes_too_late_after_a_requested_start(void)
{
    tick();
    command(REGISTERS_START);
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_word(REQUEST_AT(unlock), REGISTERS_KEY));
    command(REGISTERS_STOP);
    tick();
    unlock();
    command(REGISTERS_START);
    stage(U_MAX_AT, bits_of(2.5f));
    check_refused(U_MAX_AT, REGISTERS_PROTECTED);
}

// A client on another core, as on Linux: it writes at each call that the tick makes of its board.
static port_t   whole;    ///< the board's port
static unsigned attempts; ///< of the client, in this tick

static void attempt(void)
{
    attempts++;
    registers_run(&registers);
    TEST_ASSERT_EQUAL_INT(MODBUS_ILLEGAL_VALUE, try_word(REQUEST_AT(unlock), REGISTERS_KEY));
    TEST_ASSERT_TRUE(try_command(REGISTERS_APPLY) != MODBUS_OK);
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_PROTECTED, STATE_OF(outcome));
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_SAVE));
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_WRONG_STATE, STATE_OF(outcome));
}

static bool read_sensor_meanwhile(void *context, loop_force_t *reading)
{
    attempt();
    return whole.read_sensor(context, reading);
}

static void measure_meanwhile(void *context, port_measured_t *measured)
{
    attempt();
    whole.measure(context, measured);
}

static uint32_t inputs_meanwhile(void *context)
{
    attempt();
    return whole.inputs(context);
}

static uint32_t time_us_meanwhile(void *context)
{
    attempt();
    return whole.time_us(context);
}

static void enable_meanwhile(void *context, bool on)
{
    attempt();
    whole.enable(context, on);
}

static void command_meanwhile(void *context, loop_force_t output)
{
    attempt();
    whole.command(context, output);
}

/// The client has the key, and its set waits for the apply. Returns how often it wrote within the tick that takes the start.
static unsigned start_meanwhile(void)
{
    const port_t own = board.port;
    unlock();
    stage(U_MAX_AT, bits_of(2.5f));
    command(REGISTERS_START);
    whole                  = own;
    attempts               = 0;
    board.port.read_sensor = read_sensor_meanwhile;
    board.port.measure     = measure_meanwhile;
    board.port.inputs      = inputs_meanwhile;
    board.port.time_us     = time_us_meanwhile;
    board.port.enable      = enable_meanwhile;
    board.port.command     = command_meanwhile;
    board_new_tick(&board);
    registers_tick(&registers);
    board.now_us += PERIOD_US;
    board.port = own;
    return attempts;
}

static void test_nothing_that_protects_changes_within_the_tick_that_starts(void)
{
    defaults.drive.bus_low_v = 18.0f; // so that the tick measures
    power_up();
    tick();
    TEST_ASSERT_EQUAL_UINT(7, start_meanwhile()); // one call of each, two of the clock
    TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
    check_refused(U_MAX_AT, REGISTERS_PROTECTED);
}

static void test_a_start_that_was_dropped_protects_no_longer(void)
{
    tick();
    board.inputs = PORT_INPUT_EMERGENCY_STOP;
    TEST_ASSERT_GREATER_THAN_UINT(3, start_meanwhile());
    TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT, STATE_OF(state));
    unlock();
    command(REGISTERS_APPLY);
    tick();
    TEST_ASSERT_EQUAL_FLOAT(2.5f, number_of(read_word(TO_ACTIVE(U_MAX_AT))));
}

static void test_the_sign_of_the_controller_does_not_turn_in_run(void)
{
    const uint32_t b0 = REGISTERS_STAGED_AT + REGISTERS_SECTIONS_AT;
    const uint32_t b2 = b0 + 4u;
    float          is[3]; // b0, b1, b2
    memcpy(is, &registers.active->set.sections[0], sizeof is);
    start();
    command(REGISTERS_REVERT);
    for (uint32_t i = 0; i < 3u; i++)
    {
        write_word(b0 + 2u * i, bits_of(-is[i]));
    }
    check_refused(b0, REGISTERS_PROTECTED);
    command(REGISTERS_REVERT);
    write_word(b2, bits_of(-is[2]));
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_APPLY));
    command(REGISTERS_REVERT);
    write_word(b0, bits_of(0.9f * is[0])); // a retuned one
    command(REGISTERS_APPLY);
    tick();
    command(REGISTERS_STOP);
    tick();
    unlock();
    memcpy(is, &registers.active->set.sections[0], sizeof is);
    for (uint32_t i = 0; i < 3u; i++)
    {
        write_word(b0 + 2u * i, bits_of(-is[i]));
    }
    command(REGISTERS_APPLY);
    TEST_ASSERT_EQUAL_UINT32(1, STATE_OF(protection_changes));
    TEST_ASSERT_EQUAL_HEX32(b0, read_word(REGISTERS_CHANGES_AT + 2));
}

/// A section that ends at 0 does not hide the sign of the others.
static void test_the_sign_does_not_turn_behind_a_section_without_b2(void)
{
    const uint32_t first  = REGISTERS_STAGED_AT + REGISTERS_SECTIONS_AT;
    const uint32_t second = first + 2u * 5u;
    tick();
    unlock();
    write_word(first + 4u, 0u);
    command(REGISTERS_APPLY);
    TEST_ASSERT_EQUAL_UINT32(0, STATE_OF(protection_changes)); // b1 is on the same side
    start();
    write_word(second + 4u, read_word(second + 4u) ^ 0x80000000u);
    check_refused(first + 4u, REGISTERS_PROTECTED);
    command(REGISTERS_REVERT);
    write_word(first + 2u, read_word(first + 2u) ^ 0x80000000u);
    check_refused(first + 4u, REGISTERS_PROTECTED);
    command(REGISTERS_REVERT);
    write_word(second, bits_of(0.9f * number_of(read_word(second)))); // a retuned one
    command(REGISTERS_APPLY);
}

static void test_no_key_goes_beyond_the_boards_ceiling(void)
{
    tick();
    unlock();
    stage(U_MAX_AT, bits_of(3.5f));
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_APPLY));
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_SET_REFUSED, STATE_OF(outcome));
    TEST_ASSERT_EQUAL_HEX32(U_MAX_AT, STATE_OF(refused_register));
    TEST_ASSERT_EQUAL_FLOAT(3.5f, number_of(STATE_OF(refused_value)));
    TEST_ASSERT_EQUAL_FLOAT(0.0f, number_of(STATE_OF(refused_low)));
    TEST_ASSERT_EQUAL_FLOAT(3.0f, number_of(STATE_OF(refused_high)));
    stage(DRIVE_AT(command_limit_ms), 0); // off
    TEST_ASSERT_EQUAL_INT(MODBUS_FAILURE, try_command(REGISTERS_APPLY));
    TEST_ASSERT_EQUAL_HEX32(DRIVE_AT(command_limit_ms), STATE_OF(refused_register));
    stage(U_MAX_AT, bits_of(3.0f));
    command(REGISTERS_APPLY);
    tick();
    TEST_ASSERT_EQUAL_FLOAT(3.0f, number_of(read_word(TO_ACTIVE(U_MAX_AT))));
}

static void test_a_store_beyond_the_boards_ceiling_is_not_used(void)
{
    power_up_under(0); // of other firmware, say
    tick();
    unlock();
    stage(U_MAX_AT, bits_of(3.5f));
    command(REGISTERS_APPLY);
    tick();
    command(REGISTERS_SAVE);
    run(2);
    TEST_ASSERT_EQUAL_UINT32(REGISTERS_DONE, STATE_OF(outcome));
    power_up_under(0);
    TEST_ASSERT_EQUAL_FLOAT(3.5f, number_of(read_word(TO_ACTIVE(U_MAX_AT))));
    power_up();
    tick();
    TEST_ASSERT_EQUAL_UINT32(STORE_FOREIGN, STATE_OF(store));
    TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT_STORE, STATE_OF(fault));
    TEST_ASSERT_EQUAL_HEX32(U_MAX_AT, STATE_OF(refused_register));
    TEST_ASSERT_EQUAL_FLOAT(2.0f, number_of(read_word(TO_ACTIVE(U_MAX_AT))));
}

static void test_defaults_beyond_the_boards_ceiling_are_a_fault(void)
{
    defaults.drive.command_limit_ms = 0;
    power_up();
    tick();
    TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT_PARAMS, STATE_OF(fault));
}

/// Reads as a host does: from the registers, in the order of their addresses.
static void test_a_host_can_compute_the_crc_of_the_protection_params(void)
{
    uint32_t crc   = 0;
    uint32_t place = 0;
    uint32_t last  = 0;
    for (uint32_t word = params_next_protecting(&place); word < PARAMS_WORDS; word = params_next_protecting(&place))
    {
        const uint32_t address = register_of(word);
        const uint32_t bits    = read_word(TO_ACTIVE(address));
        const uint8_t  bytes[] = {(uint8_t)bits, (uint8_t)(bits >> 8), (uint8_t)(bits >> 16), (uint8_t)(bits >> 24)};
        TEST_ASSERT_GREATER_THAN_UINT32(last, address);
        last = address;
        crc  = crc32_update(crc, bytes, sizeof bytes);
    }
    TEST_ASSERT_EQUAL_HEX32(REGISTERS_STAGED_AT + 0x126u, last);
    const uint8_t up[] = {1, 0, 0, 0, 1, 0, 0, 0};
    TEST_ASSERT_EQUAL_HEX32(crc32_update(crc, up, sizeof up), STATE_OF(protection));

    // The signs of the gain: both turned, then that at rest alone.
    const uint32_t section = REGISTERS_STAGED_AT + REGISTERS_SECTIONS_AT;
    unlock();
    write_word(section, read_word(section) ^ 0x80000000u);
    write_word(section + 4u, read_word(section + 4u) ^ 0x80000000u);
    command(REGISTERS_APPLY);
    tick();
    const uint8_t down[] = {0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff};
    TEST_ASSERT_EQUAL_HEX32(crc32_update(crc, down, sizeof down), STATE_OF(protection));
    unlock();
    write_word(section, read_word(section) ^ 0x80000000u);
    command(REGISTERS_APPLY);
    tick();
    const uint8_t mixed[] = {1, 0, 0, 0, 0xff, 0xff, 0xff, 0xff};
    TEST_ASSERT_EQUAL_HEX32(crc32_update(crc, mixed, sizeof mixed), STATE_OF(protection));
}

/// A host that reads the active set and writes it back with a change of what tunes.
static void test_a_tare_is_no_change_of_what_protects(void)
{
    tick();
    command(REGISTERS_TARE);
    for (unsigned i = 0; i <= DRIVE_TARE_TICKS; i++)
    {
        force_n = 0.2;
        tick();
    }
    TEST_ASSERT_EQUAL_UINT32(DRIVE_TARE_DONE, STATE_OF(tare));
    const uint32_t zero = read_word(TO_ACTIVE(DRIVE_AT(sensor_zero_units)));
    TEST_ASSERT_FLOAT_WITHIN(1e-4f, 0.2f, number_of(zero));
    stage(GAIN_AT, bits_of(0.5f));
    write_word(DRIVE_AT(sensor_zero_units), zero);
    command(REGISTERS_APPLY);
    tick();
    TEST_ASSERT_EQUAL_HEX32(zero, read_word(TO_ACTIVE(DRIVE_AT(sensor_zero_units))));
    TEST_ASSERT_EQUAL_UINT32(0, STATE_OF(protection_changes));
}

/// Each tare is within its bound of the zero before, which a save and a power-up have made the drive's own.
static void test_the_zero_does_not_walk_beyond_its_ceiling_by_tares(void)
{
    double zero = 0.0;
    for (unsigned i = 0; i < 4; i++)
    {
        tick();
        command(REGISTERS_TARE);
        for (unsigned k = 0; k <= DRIVE_TARE_TICKS; k++)
        {
            force_n = zero + 0.2;
            tick();
        }
        TEST_ASSERT_EQUAL_UINT32(DRIVE_TARE_DONE, STATE_OF(tare));
        (void)try_command(REGISTERS_SAVE);
        run(2);
        TEST_ASSERT_EQUAL_UINT32(i < 2 ? REGISTERS_DONE : REGISTERS_SET_REFUSED, STATE_OF(outcome));
        power_up();
        const double kept = (double)number_of(read_word(TO_ACTIVE(DRIVE_AT(sensor_zero_units))));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, i < 2 ? zero + 0.2 : zero, kept);
        zero = kept;
    }
}

static void test_params_that_change_by_themselves_stop_the_drive_for_good(void)
{
    const size_t places[] = {offsetof(params_t, set.drive.residual_n),
                             offsetof(params_t, loop.params.controller.TRIBO_N(u_max)),
                             offsetof(params_t, drive.bounds.residual_level),
                             sizeof(params_t) - 1u};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++)
    {
        power_up();
        start();
        run(1000);
        TEST_ASSERT_EQUAL_UINT32(DRIVE_RUN, STATE_OF(state));
        ((unsigned char *)registers.active)[places[i]] ^= 4u;
        run((unsigned)(2u * sizeof(params_t) / 16u + 3u));
        TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT, STATE_OF(state));
        TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT_CONFIG_CHANGED, STATE_OF(fault));
        TEST_ASSERT_FALSE(board.enabled);
        command(REGISTERS_ACKNOWLEDGE);
        run(3);
        TEST_ASSERT_EQUAL_UINT32(DRIVE_FAULT_CONFIG_CHANGED, STATE_OF(fault));
    }
}

// --- a client that tries everything --------------------------------------------------------------------------------

/// What a tick runs with, of all that protects: numbers as the tick reads them, not as they are reported.
typedef struct
{
    drive_config_t  config;
    scaling_t       scaling;
    faults_bounds_t bounds;
    scaling_gain_t  poles[2]; ///< of the residual's model
    loop_force_t    down;
    TRIBO(arm, params_t) arm;
    loop_force_t u_min, u_max, input_max;
    int          signs[2]; ///< of the controller's gain, at once and at rest
} effective_t;

static uint32_t random_state;

static uint32_t draw(uint32_t count)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)(random_state >> 4) * count >> 28);
}

static int sign_of(float x)
{
    return (x > 0.0f) - (x < 0.0f);
}

/// Returns the sign of the response to a slow ramp of e: that of the first of b2, b1, b0 that is not 0.
static int sign_at_rest(const tribo_biquad_f32_section_t *section)
{
    const int signs[] = {sign_of(section->b2), sign_of(section->b1), sign_of(section->b0)};
    return signs[0] != 0 ? signs[0] : signs[1] != 0 ? signs[1] : signs[2];
}

static effective_t effective(void)
{
    const drive_setup_t *setup  = drive_setup(&registers.drive);
    const params_t      *params = setup == &registers.params[0].drive ? &registers.params[0] : &registers.params[1];
    effective_t          is;
    memset(&is, 0, sizeof is); // its padding as well
    is.config = setup->config;
    memcpy(&is.scaling, &setup->scaling, sizeof is.scaling);
    memcpy(&is.bounds, &setup->bounds, sizeof is.bounds);
    memcpy(&is.arm, setup->expected.arm, sizeof is.arm);
#ifdef TRIBO_ARITHMETIC_Q31 // its last member is a byte: a copied struct has anything behind it
    memset(&is.arm.shift + 1, 0, sizeof is.arm - offsetof(TRIBO(arm, params_t), shift) - 1u);
#endif
    is.poles[0]  = setup->expected.actuator;
    is.poles[1]  = setup->expected.sensor;
    is.down      = setup->expected.down;
    is.u_min     = setup->params->controller.TRIBO_N(u_min);
    is.u_max     = setup->params->controller.TRIBO_N(u_max);
    is.input_max = setup->params->TRIBO_N(input_max);
    is.signs[0] = is.signs[1] = 1;
    for (uint32_t i = 0; i < params_word(&params->set, PARAMS_SECTION_COUNT); i++)
    {
        is.signs[0] *= sign_of(params->set.sections[i].b0);
        is.signs[1] *= sign_at_rest(&params->set.sections[i]);
    }
    return is;
}

/// Returns what hostile and careless clients write in place of a word.
static uint32_t evil_value(uint32_t is)
{
    static const float numbers[] = {0.0f, -0.0f, 1.0f, -1.0f, 1e-9f, 1e3f, 1e6f, -1e6f, 1e30f};
    switch (draw(7))
    {
    case 0:
        return bits_of(numbers[draw(sizeof numbers / sizeof numbers[0])]);
    case 1:
        return is ^ 0x80000000u;
    case 2:
        return bits_of(number_of(is) * 2.0f);
    case 3:
        return bits_of(number_of(is) * (0.5f + (float)draw(100) / 100.0f));
    case 4:
        return draw(3);
    case 5:
        return is + 1u + draw(1000);
    default:
        return is ^ 1u << draw(32);
    }
}

static const uint16_t block_ends[][2] = {{REGISTERS_DRIVE_AT, 2u * DRIVE_CONFIG_COUNT},
                                         {REGISTERS_LOOP_AT, 2u * PARAMS_LOOP_COUNT},
                                         {REGISTERS_METHOD_AT, 2},
#if DRIVE_FEEDFORWARD
                                         {REGISTERS_FEED_AT, 2u * PARAMS_FEED_COUNT},
                                         {REGISTERS_GUARD_AT, 2u * PARAMS_GUARD_COUNT},
#endif
                                         {REGISTERS_SECTIONS_AT, 40},
                                         {REGISTERS_TABLE_AT, 12}};

static uint32_t draw_staged(void)
{
    const uint16_t *block = block_ends[draw(2) == 0u ? draw(2) : draw(sizeof block_ends / sizeof block_ends[0])];
    return REGISTERS_STAGED_AT + block[0] + 2u * draw(block[1] / 2u);
}

static bool is_at_rest(void)
{
    return registers.drive.state == DRIVE_IDLE || registers.drive.state == DRIVE_FAULT;
}

typedef struct
{
    unsigned long writes, in_run, applied, by_key;
    bool          permitted; ///< the key was written at rest, and nothing has ended it since
    uint32_t      permitted_at;
    bool          granted; ///< a set was applied meanwhile; the next tick takes it
    bool          started; ///< asked for
} client_t;

/// What each tick must leave as it was. Padding is compared as well: effective() clears it.
static void check_tick(client_t *client)
{
    const effective_t before = effective();
    const bool        ran    = !is_at_rest();
    tick();
    const effective_t after   = effective();
    const bool        granted = client->granted;
    client->started = client->granted = false;
    // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison,cert-exp42-c,cert-flp37-c): see above
    const bool alike = memcmp(&before, &after, sizeof before) == 0;
    TEST_ASSERT_TRUE_MESSAGE(alike || !ran, "what protects has changed in run");
    TEST_ASSERT_TRUE_MESSAGE(alike || granted, "what protects has changed without the key");
    client->by_key += !alike;
    client->permitted =
        client->permitted && is_at_rest() && registers.drive.ticks - client->permitted_at < UNLOCK_TICKS;
    const float u_max = scaling_value(after.u_max, after.config.full_scale_n);
    const float u_min = scaling_value(after.u_min, after.config.full_scale_n);
    TEST_ASSERT_TRUE_MESSAGE(u_max <= 3.00001f && u_min >= -3.00001f, "u's limit is beyond the ceiling");
    TEST_ASSERT_TRUE_MESSAGE(after.bounds.residual > 0 && after.bounds.residual_level > 0u, "the residual is off");
    TEST_ASSERT_TRUE_MESSAGE(after.bounds.command_limit_level > 0u && after.bounds.command_limit_level <= 1000u,
                             "the limit of u at its limit is off");
}

static void write_staged(client_t *client)
{
    const uint32_t address = draw_staged();
    client->writes++;
    if (draw(20) == 0u) // a whole frame, perhaps over the end of a block
    {
        uint16_t       values[40];
        const uint16_t count = (uint16_t)(1u + draw(40));
        for (uint16_t i = 0; i < count; i++)
        {
            values[i] = (uint16_t)draw(65536);
        }
        (void)map.write(map.context, (uint16_t)(address + draw(2)), count, values);
        return;
    }
    (void)try_word(address, evil_value(read_word(address)));
}

static void write_key(client_t *client)
{
    const uint32_t key  = draw(3) == 0u ? evil_value(REGISTERS_KEY) : draw(8) == 0u ? 0u : REGISTERS_KEY;
    const bool     rest = is_at_rest() && !client->started;
    client->writes++;
    const modbus_status_t status = try_word(REQUEST_AT(unlock), key);
    if (status == MODBUS_BUSY) // with a save
    {
        return;
    }
    client->permitted    = status == MODBUS_OK && key == REGISTERS_KEY;
    client->permitted_at = registers.drive.ticks;
    TEST_ASSERT_TRUE_MESSAGE(rest || !client->permitted, "unlocked in run");
}

static void send_command(client_t *client, uint16_t number)
{
    const bool            rest   = is_at_rest() && !client->started;
    const modbus_status_t status = try_command(number);
    client->writes++;
    client->applied += number == REGISTERS_APPLY && status == MODBUS_OK;
    client->granted =
        client->granted || (number == REGISTERS_APPLY && status == MODBUS_OK && rest && client->permitted);
    client->started =
        (client->started || (number == REGISTERS_START && status == MODBUS_OK)) && number != REGISTERS_STOP;
}

/// A client's next act. Most begin from what the drive has, change little and apply it, as that is most often accepted.
static void act(client_t *client)
{
    switch (draw(10))
    {
    case 0:
    case 1:
    case 2:
        send_command(client, REGISTERS_REVERT);
        write_staged(client);
        break;
    case 3:
        write_staged(client);
        break;
    case 4:
    case 5:
    case 6:
        send_command(client, REGISTERS_APPLY);
        break;
    case 7:
        write_key(client);
        break;
    case 8:
        client->writes++;
        (void)try_word(REQUEST_AT(reference), bits_of((float)draw(100) / 50.0f - 1.0f));
        break;
    default:
        send_command(client, (uint16_t)(draw(20) == 0u ? draw(65536) : draw(14)));
        break;
    }
}

/// A drive that is not in RUN most often is brought there: it is what the client attacks.
static void go_on(client_t *client)
{
    if (registers.drive.state == DRIVE_FAULT && draw(4) == 0u)
    {
        send_command(client, REGISTERS_ACKNOWLEDGE);
    }
    else if (registers.drive.state == DRIVE_IDLE && draw(40) == 0u)
    {
        send_command(client, REGISTERS_START);
    }
}

static void test_no_sequence_of_one_client_talks_the_drive_out_of_its_protection(void)
{
    const char         *asked  = getenv("TRIBO_WRITES");
    const unsigned long writes = asked != NULL ? strtoul(asked, NULL, 10) : RUNS(20000, 4000);
    client_t            client = {.writes = 0};
    random_state               = 20261122u;
    for (unsigned long round = 0; client.writes < writes; round++)
    {
        if (round % 2000u == 0u) // of a rig as it was set up
        {
            memset(sectors, 0xff, sizeof sectors);
            power_up();
            client.permitted = client.granted = client.started = false;
        }
        const bool          ran    = !is_at_rest();
        const unsigned long before = client.writes;
        act(&client);
        client.in_run += ran ? client.writes - before : 0u;
        go_on(&client);
        for (uint32_t i = draw(3); i > 0u; i--)
        {
            check_tick(&client);
        }
    }
    (void)printf("%lu writes, %lu in run, %lu sets applied, %lu changes of what protects at rest with the key\n",
                 client.writes,
                 client.in_run,
                 client.applied,
                 client.by_key);
    TEST_ASSERT_GREATER_THAN_UINT64(writes / 3u, client.in_run);
    TEST_ASSERT_GREATER_THAN_UINT64(writes / 100u, client.applied);
    TEST_ASSERT_GREATER_THAN_UINT64(0, client.by_key);
}

#include "runners/test_protection.inc" // main
