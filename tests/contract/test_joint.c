// A joint with current and encoder: what it learns from a position loop's effort, what it takes out, and what its guard does. The plant is a
// mass with Coulomb friction, the loop a PD with an integral, both of this file.

#include ARITH_HEADER

#include "tribo/joint_q31.h"
#include "unity.h"

#include <string.h>

typedef TRIBO(joint, t) joint_t;
typedef tribo_force_t position_t;

#define H        1e-3
#define FRICTION 0.1    // of an effort of 1
#define MOVE     1000   // ticks
#define STROKE   4000.0 // counts
#define TRAVEL   4.0
#define MASS     2e-6 // effort over counts per second squared
#define ONE      2147483648.0

static joint_t joint;

void setUp(void)
{
    memset(&joint, 0, sizeof joint);
}

static tribo_force_t effort_of(double x)
{
    return TRIBO_EITHER((float)x, (int32_t)(fmax(-1.0, fmin(x, 0.9999999995)) * ONE));
}

static double number(tribo_force_t x)
{
    return TRIBO_EITHER((double)x, (double)x / ONE);
}

static tribo_joint_config_t config_of(double breakaway)
{
    tribo_joint_config_t config    = tribo_joint_config();
    config.sample_time_s           = (float)H;
    config.effort_max              = 1.0f;
    config.travel                  = (float)TRAVEL;
    config.breakaway               = (float)breakaway;
    config.actuator_pole_rad_per_s = 1000.0f;
    return config;
}

static void begin(double breakaway)
{
    const tribo_joint_config_t config = config_of(breakaway);
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, init)(&joint, &config));
}

static tribo_joint_report_t report(void)
{
    tribo_joint_report_t x;
    TRIBO(joint, report)(&joint, &x);
    return x;
}

static double step(double effort, double q_ref, double q)
{
    return number(TRIBO(joint, step)(&joint, effort_of(effort), (position_t)q_ref, (position_t)q));
}

// --- a joint and its loop ------------------------------------------------------------------------------------------------------------

typedef struct
{
    double actuator, position, speed, integral, last, asked[2]; // counts, counts a second
    double friction, viscous, load, outer;
    int    sign; // of the term
} plant_t;

static void move(plant_t *x, double u)
{
    for (int i = 0; i < 10; i++)
    {
        const double h = H / 10.0;
        x->actuator += (1.0 - exp(-1000.0 * h)) * (u - x->actuator);
        const double push = x->actuator + x->load + x->outer - x->viscous * x->speed + MASS * x->speed / h;
        x->speed          = fabs(push) < x->friction ? 0.0 : (push - copysign(x->friction, push)) * h / MASS;
        x->position += h * x->speed;
    }
}

/// A minimum-jerk stroke to and fro with rests between.
static double wanted(long tick)
{
    const double s    = fmin(1.0, (double)(tick % MOVE) / (0.8 * MOVE));
    const double bend = s * s * s * (10.0 + s * (6.0 * s - 15.0));
    return tick / MOVE % 2 == 0 ? STROKE * bend : STROKE * (1.0 - bend);
}

/// One tick of joint and loop; returns the error in counts.
static double plant_step(plant_t *x, double q_ref)
{
    const double q      = floor(x->position);
    const double e      = q_ref - q;
    x->integral         = fmax(-0.5, fmin(0.5, x->integral + 0.000005 * e));
    const double v      = (q_ref - x->asked[0]) / H;
    const double a      = (v - (x->asked[0] - x->asked[1]) / H) / H;
    const double effort = fmax(-1.0, fmin(1.0, MASS * a + 0.004 * e + 0.0001 * (v - (q - x->last) / H) + x->integral));
    const double u      = step(effort, q_ref, q);
    x->last             = q;
    x->asked[1]         = x->asked[0];
    x->asked[0]         = q_ref;
    move(x, x->sign < 0 ? 2.0 * effort - u : u);
    return q_ref - x->position;
}

static double moves(plant_t *x, long from, long to)
{
    double square = 0.0;
    for (long tick = from * MOVE; tick < to * MOVE; tick++)
    {
        const double e = plant_step(x, wanted(tick));
        square += e * e;
    }
    return sqrt(square / (double)((to - from) * MOVE));
}

// --- set-up ------------------------------------------------------------------------------------------------------------------------------

static void test_an_empty_config_is_refused_field_by_field(void)
{
    const joint_t        untouched = {0};
    tribo_joint_config_t config    = tribo_joint_config();
    TEST_ASSERT_EQUAL(TRIBO_ERR_SAMPLE_TIME, TRIBO(joint, init)(&joint, &config));
    config.sample_time_s = (float)H;
    TEST_ASSERT_EQUAL(TRIBO_ERR_JOINT_EFFORT, TRIBO(joint, init)(&joint, &config));
    config.effort_max = 1.0f;
    TEST_ASSERT_EQUAL(TRIBO_ERR_JOINT_TRAVEL, TRIBO(joint, init)(&joint, &config));
    TEST_ASSERT_EQUAL_MEMORY(&untouched, &joint, sizeof joint);
    config.travel = 4.0f;
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, init)(&joint, &config));
}

static void test_each_field_is_checked(void)
{
    const float bad[] = {NAN, INFINITY, -1.0f, 1e9f};
    for (uint32_t i = 0; i < 4; i++)
    {
        tribo_joint_config_t config = config_of(0.1);
        config.sample_time_s        = bad[i];
        TEST_ASSERT_EQUAL(TRIBO_ERR_SAMPLE_TIME, TRIBO(joint, init)(&joint, &config));
        config            = config_of(0.1);
        config.effort_max = bad[i];
        TEST_ASSERT_EQUAL(TRIBO_ERR_JOINT_EFFORT, TRIBO(joint, init)(&joint, &config));
        config        = config_of(0.1);
        config.travel = bad[i];
        TEST_ASSERT_EQUAL(TRIBO_ERR_JOINT_TRAVEL, TRIBO(joint, init)(&joint, &config));
        config           = config_of(0.1);
        config.breakaway = bad[i];
        TEST_ASSERT_EQUAL(TRIBO_ERR_JOINT_BREAKAWAY, TRIBO(joint, init)(&joint, &config));
        config                         = config_of(0.1);
        config.actuator_pole_rad_per_s = bad[i];
        TEST_ASSERT_EQUAL(TRIBO_ERR_JOINT_POLE, TRIBO(joint, init)(&joint, &config));
        config      = config_of(0.1);
        config.gain = bad[i];
        TEST_ASSERT_EQUAL(TRIBO_ERR_JOINT_GAIN, TRIBO(joint, init)(&joint, &config));
        begin(0.1);
        TEST_ASSERT_EQUAL(TRIBO_ERR_JOINT_GAIN, TRIBO(joint, gain)(&joint, bad[i]));
    }
    const float wrong[] = {NAN, INFINITY, -1.0f, 1.1e9f, 99.0f * (float)TRAVEL};
    for (uint32_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
    {
        tribo_joint_config_t config = config_of(0.1);
        config.wrap                 = wrong[i];
        TEST_ASSERT_EQUAL(TRIBO_ERR_JOINT_WRAP, TRIBO(joint, init)(&joint, &config));
    }
    tribo_joint_config_t turn = config_of(0.1);
    turn.wrap                 = 100.5f * (float)TRAVEL;
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, init)(&joint, &turn));
#if TRIBO_IS_Q31
    turn.wrap = 1000.5f; // no whole count
    TEST_ASSERT_EQUAL(TRIBO_ERR_JOINT_WRAP, TRIBO(joint, init)(&joint, &turn));
#endif
    tribo_joint_config_t config    = config_of(0.1);
    config.actuator_pole_rad_per_s = 0.0f;
    config.sample_time_s           = 0.1f; // slower than all of its own times
    config.travel                  = 9000.0f;
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, init)(&joint, &config));
#if TRIBO_IS_Q31
    config.travel = 0.9f;
    TEST_ASSERT_EQUAL(TRIBO_ERR_JOINT_TRAVEL, TRIBO(joint, init)(&joint, &config));
    config.travel = 10001.0f;
    TEST_ASSERT_EQUAL(TRIBO_ERR_JOINT_TRAVEL, TRIBO(joint, init)(&joint, &config));
#endif
    TEST_ASSERT_EQUAL(TRIBO_ERR_NULL, TRIBO(joint, init)(NULL, &config));
    TEST_ASSERT_EQUAL(TRIBO_ERR_NULL, TRIBO(joint, init)(&joint, NULL));
}

/// Position `x` of an encoder that begins anew after `turn` counts, at `from` counts.
static double wrapped(double x, double turn, double from)
{
    return from + fmod(fmod(x - from, turn) + turn, turn);
}

/// Encoders of 3,000 and 4,096 counts a turn, and one whose reference counts turns: the same u in each tick.
static void test_a_joint_that_wraps_is_the_one_that_counts_turns(void)
{
    static joint_t    wraps;
    static const long turns[] = {3000, 4096};
    for (uint32_t i = 0; i < 6u; i++)
    {
        const double         turn   = (double)turns[i % 2u];
        const double         from   = i / 2u == 1u ? -0.5 * turn : 0.0;
        tribo_joint_config_t config = config_of(FRICTION);
        config.wrap                 = (float)turn;
        plant_t x                   = {.friction = FRICTION, .sign = 1};
        begin(FRICTION);
        TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, init)(&wraps, &config));
        double integral = 0.0;
        for (long tick = 0; tick < 12 * MOVE; tick++)
        {
            const double q_ref  = round(3.0 * wanted(tick)) - 5000.0;
            const double q      = floor(x.position) - 5000.0;
            const double effort = fmax(-1.0, fmin(1.0, 0.004 * (q_ref - q) + 0.0001 * (q_ref - x.last) + integral));
            integral            = fmax(-0.5, fmin(0.5, integral + 0.000005 * (q_ref - q)));
            x.last              = q_ref;
            const double u      = step(effort, q_ref, q);
            const double seen   = i / 2u == 2u ? q_ref : wrapped(q_ref, turn, from);
            const double other  = number(
                TRIBO(joint, step)(&wraps, effort_of(effort), (position_t)seen, (position_t)wrapped(q, turn, from)));
            TEST_ASSERT_TRUE(u == other);
            x.speed += H * (u - (x.speed > 0.0 ? FRICTION : -FRICTION)) / MASS;
            x.speed *= 0.98;
            x.position += H * x.speed;
        }
        TEST_ASSERT_TRUE(report().is_learned);
    }
}

static void test_before_the_init_a_joint_puts_out_nothing(void)
{
    TEST_ASSERT_TRUE(step(0.5, 0.0, 0.0) == 0.0);
    TEST_ASSERT_FALSE(report().is_learned);
}

// --- what it is for --------------------------------------------------------------------------------------------------------------------

static double error_with(double gain, double breakaway, double load)
{
    plant_t x = {.friction = FRICTION, .load = load};
    begin(breakaway);
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, gain)(&joint, (float)gain));
    (void)moves(&x, 0, 12);
    return moves(&x, 12, 20);
}

/// Fast moves in oil: viscous friction reaches 1.2 times the dry friction, which alone is learned. A sine of 0.5 and 1 Hz behind a PD.
static void test_viscous_friction_of_fast_moves_is_not_learned(void)
{
    for (uint32_t i = 0; i < 6u; i++)
    {
        const double frequency = i < 3u ? 0.5 : 1.0;
        const double speed     = 2.0 * 3.14159265 * frequency * STROKE; // counts a second
        plant_t      plant     = {.friction = FRICTION, .viscous = 0.6 * (i % 3u) * FRICTION / speed};
        double       rate      = 0.0;
        begin(0.0);
        for (long tick = 0; tick < 20000; tick++)
        {
            const double phase = 2.0 * 3.14159265 * frequency * H * (double)tick;
            const double q_ref = STROKE * sin(phase);
            const double q     = floor(plant.position);
            rate += 0.3 * ((q - plant.last) / H - rate);
            plant.last         = q;
            const double heavy = -MASS * speed * 2.0 * 3.14159265 * frequency * sin(phase);
            const double e     = heavy + 0.004 * (q_ref - q) + 0.0001 * (speed * cos(phase) - rate);
            move(&plant, step(fmax(-1.0, fmin(1.0, e)), q_ref, q));
        }
        const tribo_joint_report_t x = report();
        TEST_ASSERT_EQUAL(TRIBO_JOINT_SOUND, x.cause);
        TEST_ASSERT_FLOAT_WITHIN(0.18f * (float)FRICTION, (float)FRICTION, x.friction);
        TEST_ASSERT_TRUE(x.low < (float)FRICTION && (float)FRICTION < x.high);
    }
}

static void test_friction_is_learned_whatever_was_configured_and_compensated(void)
{
    const double none       = error_with(0.0, 0.0, 0.0);
    const double believed[] = {0.0, 0.5 * FRICTION, FRICTION, 2.0 * FRICTION};
    for (uint32_t i = 0; i < 4; i++)
    {
        const double with = error_with(0.9, believed[i], 0.0);

        TEST_ASSERT_TRUE(none > 3.0 * with);
        const tribo_joint_report_t x = report();
        TEST_ASSERT_TRUE(x.is_learned);
        TEST_ASSERT_FLOAT_WITHIN(0.1f * (float)FRICTION, (float)FRICTION, x.friction);
        TEST_ASSERT_TRUE(x.low < (float)FRICTION && (float)FRICTION < x.high && x.high < 2.0f * (float)FRICTION);
        TEST_ASSERT_EQUAL(TRIBO_JOINT_SOUND, x.cause);
        TEST_ASSERT_EQUAL_FLOAT(1.0f, x.share);
        TEST_ASSERT_EQUAL(0, x.bad_inputs);
    }
}

static void test_a_load_is_distinguished_from_friction(void)
{
    (void)error_with(0.9, 0.0, 0.08);
    TEST_ASSERT_FLOAT_WITHIN(0.01f, (float)FRICTION, report().friction);
    TEST_ASSERT_FLOAT_WITHIN(0.01f, -0.08f, report().load);
}

static void test_a_load_by_a_model_is_added_and_not_learned(void)
{
    plant_t x = {.friction = FRICTION, .load = 0.3};
    begin(0.0);
    TRIBO(joint, load)(&joint, effort_of(-0.3));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, -0.3, step(0.0, 0.0, 0.0));
    (void)moves(&x, 0, 12);
    TEST_ASSERT_FLOAT_WITHIN(0.01f, (float)FRICTION, report().friction);
    TEST_ASSERT_FLOAT_WITHIN(0.01f, 0.0f, report().load);
}

static void test_a_gain_ramps(void)
{
    plant_t x = {.friction = FRICTION};
    begin(FRICTION);
    (void)moves(&x, 0, 12);
    const long at = 12 * MOVE + MOVE / 2; // in full motion
    for (long tick = 12 * MOVE; tick < at; tick++)
    {
        (void)plant_step(&x, wanted(tick));
    }
    double before = number(joint.term);
    TEST_ASSERT_DOUBLE_WITHIN(0.15 * FRICTION, 0.9 * FRICTION, before);
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, gain)(&joint, 0.0f));
    for (long tick = at; tick < at + 200; tick++)
    {
        (void)plant_step(&x, wanted(tick));
        TEST_ASSERT_TRUE(fabs(number(joint.term) - before) < 0.02 * FRICTION);
        before = number(joint.term);
    }
    TEST_ASSERT_TRUE(before < 0.3 * FRICTION);
}

static void test_u_is_the_effort_where_gain_is_0_and_within_the_limit(void)
{
    tribo_joint_config_t config = config_of(0.2);
    config.gain                 = 0.0f;
    config.effort_max           = TRIBO_EITHER(0.25f, 1.0f);
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, init)(&joint, &config));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.2, step(0.2, 0.0, 0.0));
    TEST_ASSERT_EQUAL(0, report().limited_ticks);
#if TRIBO_IS_Q31
    TEST_ASSERT_EQUAL(-INT32_MAX, tribo_joint_q31_step(&joint, INT32_MIN, 0, 0));
#else
    TEST_ASSERT_EQUAL_FLOAT(-0.25f, tribo_joint_f32_step(&joint, -3.0f, 0.0f, 0.0f));
#endif
    TEST_ASSERT_EQUAL(1, report().limited_ticks);
    TRIBO(joint, load)(&joint, effort_of(TRIBO_EITHER(0.2, 0.8)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6,
                              TRIBO_EITHER(0.25, 1.0),
                              step(TRIBO_EITHER(0.2, 0.8), 0.0, 0.0)); // together beyond the limit
    TEST_ASSERT_EQUAL(2, report().limited_ticks);
}

static void test_a_bad_input_is_counted_and_changes_nothing(void)
{
    begin(0.1);
#if TRIBO_IS_Q31
    TRIBO(joint, load)(&joint, INT32_MIN); // any number is one
    TEST_ASSERT_EQUAL(0, report().bad_inputs);
#else
    const float bad[] = {NAN, INFINITY, -INFINITY, 1e30f};
    for (uint32_t i = 0; i < 4; i++)
    {
        begin(0.1);
        TEST_ASSERT_EQUAL_FLOAT(0.5f, tribo_joint_f32_step(&joint, 0.5f, 10.0f, 10.0f));
        TEST_ASSERT_EQUAL_FLOAT(0.0f, tribo_joint_f32_step(&joint, bad[i], 10.0f, 10.0f));
        TEST_ASSERT_EQUAL_FLOAT(0.5f, tribo_joint_f32_step(&joint, 0.5f, bad[i], 10.0f));
        TEST_ASSERT_EQUAL_FLOAT(0.5f, tribo_joint_f32_step(&joint, 0.5f, 10.0f, bad[i]));
        TRIBO(joint, load)(&joint, bad[i]);
        TEST_ASSERT_EQUAL(4, report().bad_inputs);
        TEST_ASSERT_EQUAL_FLOAT(0.5f, tribo_joint_f32_step(&joint, 0.5f, 10.0f, 10.0f));
    }
#endif
}

/// The first tick after a time without ticks has no term, where a joint that only went on would have its old one.
static void test_a_joint_that_rests_starts_without_its_term(void)
{
    for (int rests = 0; rests < 2; rests++)
    {
        plant_t x = {.friction = FRICTION};
        begin(FRICTION);
        TRIBO(joint, rest)(&joint);
        (void)moves(&x, 0, 8);
        for (long tick = 8 * MOVE; tick < 8 * MOVE + MOVE / 3; tick++)
        {
            (void)plant_step(&x, wanted(tick));
        }
        const tribo_joint_report_t before = report();
        if (rests != 0)
        {
            TRIBO(joint, rest)(&joint);
        }
        const double q = floor(x.position);
        const double u = fabs(step(0.0, q, q));
        TEST_ASSERT_TRUE(rests != 0 ? u == 0.0 : u > 0.5 * FRICTION);
        TEST_ASSERT_TRUE(before.is_learned && report().is_learned);
        TEST_ASSERT_EQUAL_FLOAT(before.friction, report().friction);
    }
}

#if TRIBO_IS_Q31

/// A slide whose work would overflow is void, and its mean effort is full scale at most.
static void test_a_slide_with_too_much_work_is_void(void)
{
    int64_t *const sums[] = {&joint.slide.travel, &joint.slide.work, &joint.slide.slow_work};
    for (uint32_t i = 0; i < 6; i++)
    {
        begin(FRICTION);
        (void)step(0.1, 100.0, 100.0);
        *sums[i / 2] = (i % 2 == 0 ? 1 : -1) * ((INT64_C(1) << 61) + 1);
        (void)step(0.1, 101.0, 101.0);
        TEST_ASSERT_EQUAL(1 << 20, joint.slide.ticks);
    }
    plant_t x = {.friction = FRICTION};
    begin(FRICTION);
    for (long tick = 0; tick < MOVE; tick++)
    {
        joint.slide.work = tick == MOVE / 2 ? INT64_C(1) << 60 : joint.slide.work;
        (void)plant_step(&x, wanted(tick));
    }
    for (long tick = MOVE; tick < 2 * MOVE && joint.slide.has[1] == 0u; tick++)
    {
        (void)plant_step(&x, wanted(tick));
    }
    TEST_ASSERT_EQUAL(INT32_MAX, joint.slide.mean[1]);
}

#else

static void test_a_state_that_is_no_number_is_forgotten_and_learned_anew(void)
{
    float *const states[] = {&joint.friction,
                             &joint.spread,
                             &joint.offset,
                             &joint.level,
                             &joint.term,
                             &joint.kept,
                             &joint.load,
                             &joint.lagged,
                             &joint.direction,
                             &joint.slide.moved,
                             &joint.slide.effort};
    for (uint32_t i = 0; i < 2u * sizeof states / sizeof states[0]; i++)
    {
        plant_t x = {.friction = FRICTION};
        begin(FRICTION);
        (void)moves(&x, 0, 4);
        const uint32_t bad = report().bad_inputs;
        *states[i / 2u]    = i % 2u == 0u ? NAN : 1.0e30f;
        for (long tick = 4 * MOVE; tick < 14 * MOVE; tick++)
        {
            (void)plant_step(&x, wanted(tick));
            TEST_ASSERT_TRUE(isfinite(x.actuator) && fabs(x.actuator) <= 1.0);
        }
        const tribo_joint_report_t after = report();
        const tribo_joint_force_t  force = tribo_joint_f32_force(&joint);
        TEST_ASSERT_FLOAT_WITHIN(0.2f * (float)FRICTION, (float)FRICTION, after.friction);
        TEST_ASSERT_TRUE(isfinite(after.low) && isfinite(after.high) && isfinite(after.load));
        TEST_ASSERT_TRUE(isfinite(force.low) && isfinite(force.force) && isfinite(force.high));
        TEST_ASSERT_TRUE(after.bad_inputs <= bad + 1u);
        if (i % 2u == 0u && states[i / 2u] != &joint.kept) // which the next motion sets anew
        {
            TEST_ASSERT_EQUAL(bad + 1u, after.bad_inputs);
        }
    }
    uint32_t found = 0;
    // The mean of the last slide is found once it is learned; the other one is replaced before.
    for (int way = 0; way < 2; way++)
    {
        plant_t x = {.friction = FRICTION};
        begin(FRICTION);
        TRIBO(joint, load)(&joint, 0.01f);
        (void)moves(&x, 0, 4);
        joint.slide.mean[way] = 1.0e38f;
        (void)moves(&x, 4, 20);
        TEST_ASSERT_FLOAT_WITHIN(0.2f * (float)FRICTION, (float)FRICTION, report().friction);
        found += report().bad_inputs;
        TEST_ASSERT_EQUAL_FLOAT(0.01f, joint.load);
    }
    TEST_ASSERT_EQUAL(1, found);
}

#endif

// --- what is learned ---------------------------------------------------------------------------------------------------------------------

static void test_a_hand_that_leads_teaches_nothing(void)
{
    plant_t x = {.friction = FRICTION};
    begin(FRICTION);
    (void)moves(&x, 0, 12);
    float before = 0.0f;
    for (long tick = 0; tick < 8 * MOVE; tick++)
    {
        const double q = floor(wanted(tick));
        (void)step(0.0, q, q);
        before = tick == 2 * MOVE ? report().friction : before; // the loop's last slide has ended
    }
    TEST_ASSERT_EQUAL_FLOAT(before, report().friction);
}

static void test_a_motion_that_q_ref_did_not_ask_for_teaches_nothing(void)
{
    begin(FRICTION);
    for (long tick = 0; tick < 8 * MOVE; tick++)
    {
        (void)step(0.3, 0.0, floor(wanted(tick)));
    }
    TEST_ASSERT_FALSE(report().is_learned);
}

/// Slides to and fro of `counts` with an effort that has `friction`, by `speed` counts a tick; a last one ends the slide before.
static void slides(int count, double counts, double speed, double friction)
{
    double q = 0.0;
    for (int i = 0; i < count; i++)
    {
        const double way = i % 2 == 0 ? 1.0 : -1.0;
        for (double done = 0.0; fabs(done) < fabs(counts); done += speed)
        {
            q += way * speed;
            (void)step(way * friction, q + way, q);
        }
    }
}

static void begin_without_term(void)
{
    begin(0.0);
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, gain)(&joint, 0.0f));
}

/// Slides of a fast part between two slow ones. The rise of effort from 0.2 to 0.4 beyond an eighth is extrapolated to rest. What a slide
/// has had must not be taken out of later slow ones.
static void test_the_rise_of_a_fast_part_is_extrapolated_to_rest(void)
{
    begin_without_term();
    double q = 0.0;
    for (int i = 0; i < 41; i++)
    {
        const double way = i % 2 == 0 ? 1.0 : -1.0;
        for (int tick = 0; tick < 600; tick++)
        {
            const bool is_fast = tick >= 150 && tick < 450;
            q += way * (is_fast ? 1.5 : 0.5);
            (void)step(way * (is_fast ? 0.4 : 0.2), q + way, q);
        }
    }
    TEST_ASSERT_FLOAT_WITHIN(0.01f, 0.2f - 0.625f * (0.4f - 1.125f * 0.2f), report().friction);
    slides(41, 400.0, 0.5, 0.2);
    TEST_ASSERT_FLOAT_WITHIN(0.01f, 0.2f, report().friction);
}

/// Slides whose speed rises to `fastest` and falls again, with an effort of its own for the slow and the fast part.
static void humps(int count, double fastest, double slow_effort, double fast_effort)
{
    double q = 0.0;
    for (int i = 0; i < 200 * count; i++)
    {
        const double way   = i / 200 % 2 == 0 ? 1.0 : -1.0;
        const double speed = fastest * fmin(1.0, fmin(i % 200 + 1, 200 - i % 200) / 50.0);
        q += way * speed;
        (void)step(way * (speed > 0.5 * fastest ? fast_effort : slow_effort), q + way, q);
    }
}

static void test_a_fast_motion_of_a_fine_encoder_is_no_jump(void)
{
    begin_without_term();
    humps(5, 3000.0 * TRAVEL, 0.2, 0.2);
    TEST_ASSERT_TRUE(report().is_learned);
    TEST_ASSERT_FLOAT_WITHIN(0.05f, 0.2f, report().friction);
}

/// What bends a gear or lifts a load at both ends of a slide is not friction.
static void test_no_more_is_learned_than_the_fast_part_of_a_slide_takes(void)
{
    begin_without_term();
    humps(21, 100.0 * TRAVEL, 0.8, 0.2);
    TEST_ASSERT_FLOAT_WITHIN(0.1f, 0.2f, report().friction);
}

/// A jog at an even speed: its slow parts are some ticks, whose effort turns the joint round, too early or too late.
static void test_a_slow_part_of_some_ticks_does_not_count(void)
{
    begin_without_term();
    double q = 0.0;
    for (int i = 0; i < 20000; i++)
    {
        const double way   = i / 1000 % 2 == 0 ? 1.0 : -1.0;
        const bool   turns = i % 1000 < 20 || i % 1000 >= 980;
        q += way * (turns ? 2.0 : 10.0);
        (void)step(way * (turns ? -0.3 : 0.2), q + way, q);
    }
    TEST_ASSERT_FLOAT_WITHIN(0.03f, 0.2f, report().friction);
}

/// q_ref turns quickly, and the joint springs to and fro by 150 counts before it follows by 3000.
static void test_a_rebound_teaches_nothing(void)
{
    begin_without_term();
    double q = 0.0;
    for (int i = 0; i < 22000; i++)
    {
        const double way   = i / 1100 % 2 == 0 ? 1.0 : -1.0;
        const int    since = i % 1100;
        const double q_ref = fmin(40.0 * since, 2400.0) + fmin(10.0 * fmax(since - 60, 0), 2000.0) - 2200.0;
        q += way * (since < 50 || since >= 100 ? 3.0 : -3.0);
        (void)step(way * (since < 100 ? 0.9 : 0.2), way * q_ref, q);
    }
    TEST_ASSERT_TRUE(report().is_learned);
    TEST_ASSERT_FLOAT_WITHIN(0.05f, 0.2f, report().friction);
}

/// Neither a reading of one tick nor the way back from it. The joint is a count ahead of q_ref, where the guard looks.
static void test_a_glitch_of_the_encoder_is_no_motion(void)
{
    begin(0.2);
    for (int k = 0; k < 400; k++)
    {
        (void)step(0.2, k, k + 1.0 - (k % 100 == 99 ? 1e5 : 0.0));
    }
    TEST_ASSERT_EQUAL(TRIBO_JOINT_SOUND, report().cause);
}

static void test_a_jump_or_a_slide_that_is_too_long_teaches_nothing(void)
{
    begin_without_term();
    slides(3, 400.0, 1.0, 0.2);
    TEST_ASSERT_TRUE(report().is_learned);

    begin_without_term();
    slides(4, -400.0, -1.0, -0.2); // the other way first
    TEST_ASSERT_TRUE(report().is_learned);
    TEST_ASSERT_FLOAT_WITHIN(0.02f, 0.2f, report().friction);

    tribo_joint_config_t fast    = config_of(0.0);
    fast.actuator_pole_rad_per_s = 0.0f;
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, init)(&joint, &fast));
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, gain)(&joint, 0.0f));
    slides(4, 400.0, 1.0, 0.2);
    TEST_ASSERT_FLOAT_WITHIN(0.02f, 0.2f, report().friction);

    begin_without_term();
    for (int i = 0; i < 4; i++) // an index pulse in each slide
    {
        const double way = i % 2 == 0 ? 1.0 : -1.0;
        for (int k = 0; k < 400; k++)
        {
            const double jump = k < 200 ? 0.0 : 1e5;
            const double q    = (way > 0.0 ? k : 400 - k) + jump;
            (void)step(way * 0.2, q + way, q);
        }
    }
    TEST_ASSERT_FALSE(report().is_learned);

    begin_without_term();
    slides(3, 1.1 * (double)(1 << 20), 1.0, 0.2); // ticks
    TEST_ASSERT_FALSE(report().is_learned);

    begin_without_term();
    slides(3, 5.0e6, 3000.0, 0.2);
    TEST_ASSERT_TRUE(report().is_learned);
    TEST_ASSERT_FLOAT_WITHIN(0.1f, 0.2f, report().friction); // friction that jumps within a low pass: on the safe side
#if TRIBO_IS_Q31
    begin_without_term();
    slides(3, 1.0e8, 3900.0, 0.2); // its work would not fit
    TEST_ASSERT_FALSE(report().is_learned);
#endif
    begin_without_term();
    slides(20, 30.0, 1.0, 0.2); // too short
    TEST_ASSERT_FALSE(report().is_learned);
}

/// q_ref and q go to and fro by 400 counts, q `late` ticks behind: it sticks until the loop has wound up.
static void late_slides(int count, int late)
{
    for (int k = 0; k < count * 400 + late; k++)
    {
        const int    at    = k - late;
        const bool   is_up = at >= 0 && at / 400 % 2 == 0;
        const double there = k / 400 % 2 == 0 ? k % 400 : 400 - k % 400;
        const double seen  = at < 0 ? 0 : (is_up ? at % 400 : 400 - at % 400);
        (void)step(is_up ? 0.2 : -0.2, there, seen);
    }
}

static void test_a_joint_that_sticks_while_q_ref_goes_most_of_its_way_learns(void)
{
    begin_without_term();
    late_slides(5, 250);
    TEST_ASSERT_TRUE(report().is_learned);
    TEST_ASSERT_FLOAT_WITHIN(0.02f, 0.2f, report().friction);
}

static void test_a_long_travel_is_not_requested_twice(void)
{
    begin_without_term();
    late_slides(1, 0);
    for (int k = 0; k < 8 * 400; k++) // q goes on to and fro, q_ref does not
    {
        (void)step(k / 400 % 2 == 0 ? -0.2 : 0.2, 400.0, k / 400 % 2 == 0 ? 400 - k % 400 : k % 400);
    }
    TEST_ASSERT_FALSE(report().is_learned);
}

#if TRIBO_IS_Q31
static void test_counts_may_wrap(void)
{
    double u[2];
    for (int i = 0; i < 2; i++)
    {
        const uint32_t start = i == 0 ? 0u : (uint32_t)INT32_MAX - 100u;
        begin(0.0);
        for (long tick = 0; tick < 4 * MOVE; tick++)
        {
            const uint32_t q = start + (uint32_t)(int32_t)wanted(tick);
            const double   e = tick / MOVE % 2 == 0 ? 0.2 : -0.2;
            u[i]             = number(tribo_joint_q31_step(&joint, effort_of(e), (int32_t)(q + 1u), (int32_t)q));
        }
        TEST_ASSERT_TRUE(report().is_learned);
    }
    TEST_ASSERT_TRUE(u[0] == u[1]);
}
#endif

// --- the guard -----------------------------------------------------------------------------------------------------------------------------

/// q_ref and q go up together by a count a tick, without effort.
static void lead(int ticks)
{
    for (int i = 0; i < ticks; i++)
    {
        (void)step(0.0, (double)i, (double)i);
    }
}

static void rest(double q_ref, double q, int ticks)
{
    for (int i = 0; i < ticks; i++)
    {
        (void)step(0.2 * ((q < q_ref) - (q > q_ref)), q_ref, q);
    }
}

static void test_what_is_believed_is_used_by_half_until_it_is_learned(void)
{
    begin(0.2);
    lead(1000);
    TEST_ASSERT_DOUBLE_WITHIN(0.001, 0.5 * 0.8 * 0.2, number(joint.term));
}

static void test_a_fifth_of_friction_stays_where_a_hand_leads(void)
{
    TEST_ASSERT_EQUAL_FLOAT(0.97f, tribo_joint_config().gain);
    const double gains[] = {1.0, 0.97, 0.9, 0.5};
    for (int i = 0; i < 4; i++)
    {
        for (int late = 0; late < 2; late++)
        {
            begin(0.2);
            TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, gain)(&joint, (float)gains[i]));
            for (int k = 0; k < 1000; k++)
            {
                (void)step(0.0, (double)k, (double)(k - late));
            }
            const double part = late == 0 ? fmin(gains[i], 0.8) : gains[i];
            TEST_ASSERT_DOUBLE_WITHIN(0.0005, 0.5 * part * 0.2, number(joint.term));
        }
    }
}

static void test_a_term_gives_way_to_an_effort_that_opposes_it_at_rest(void)
{
    begin(0.2);
    lead(1000);
    for (int i = 0; i < 200; i++)
    {
        (void)step(0.001, 999.0, 999.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.001, 0.08, number(joint.term)); // nothing opposes it
    for (int i = 0; i < 100; i++)
    {
        (void)step(-0.03, 999.0, 999.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.002, 0.08 - 2.0 * 0.03, number(joint.term));

    // Back, and the loop already pushes that way: what it has wound up is not added to.
    for (int i = 0; i < 100; i++)
    {
        (void)step(-0.06, 999.0, 999.0);
    }
    double most = 0.0;
    for (int i = 0; i < 20; i++)
    {
        (void)step(-0.06, 998.0 - i, 999.0 - i);
        most = fmax(most, -number(joint.term));
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.015, 0.09 - 0.06, most);
    for (int i = 20; i < 600; i++)
    {
        (void)step(0.0, 998.0 - i, 999.0 - i);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.002, -0.097, number(joint.term)); // q_ref leads: no hand
}

static void test_without_a_loop_there_is_no_term_at_rest(void)
{
    begin(0.2);
    lead(1000); // a hand leads it
    TEST_ASSERT_DOUBLE_WITHIN(0.001, 0.08, number(joint.term));
    rest(999.0, 999.0, 200);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, number(joint.term));
}

/// A joint that has learned its friction, at `q` with the term in full.
static double moving_term(void)
{
    plant_t plant = {.friction = FRICTION, .sign = 1};
    begin(FRICTION);
    (void)moves(&plant, 0, 6);
    double q = plant.position;
    double u = 0.0;
    for (int k = 0; k < 100; k++)
    {
        q += 4.0;
        u = step(0.02, q + 20.0, q);
    }
    TEST_ASSERT_TRUE(u - 0.02 > 0.5 * FRICTION);
    return q;
}

static void test_without_a_loop_there_is_no_term_beside_a_moving_reference(void)
{
    const double q     = moving_term();
    double       q_ref = q + 20.0;
    for (int k = 0; k < 600; k++)
    {
        q_ref += 4.0;
        const double u = step(0.0, q_ref, q);
        TEST_ASSERT_TRUE(k < 400 || fabs(u) < 1e-6);
    }
    q_ref += 4.0;
    for (int k = 0; k < 400; k++) // the loop is on again
    {
        q_ref += 4.0;
        (void)step(0.02, q_ref, q);
    }
    TEST_ASSERT_TRUE(step(0.02, q_ref + 4.0, q) - 0.02 > 0.5 * FRICTION);
}

static void test_a_hand_that_leads_without_effort_keeps_its_term(void)
{
    double q = moving_term();
    double u = 0.0;
    for (int k = 0; k < 2000; k++)
    {
        q += 4.0;
        u = step(0.0, q, q);
    }
    TEST_ASSERT_TRUE(u > 0.4 * FRICTION);
}

#if !TRIBO_IS_Q31 // counts are never bad
static void test_a_dead_encoder_takes_the_term_away(void)
{
    const double q = moving_term();
    for (int k = 0; k < 600; k++)
    {
        const double u = step(0.02, q + 20.0 + 4.0 * k, (double)NAN);
        TEST_ASSERT_TRUE(k > 20 || u - 0.02 > 0.5 * FRICTION); // a glitch does not
        TEST_ASSERT_TRUE(k < 400 || fabs(u - 0.02) < 1e-6);
    }
    TEST_ASSERT_EQUAL_UINT32(600, report().bad_inputs);
}
#endif

static double along, way; // way: 1 or -1

/// A tick of a motion that goes on, with the same lag and effort. Returns the term against it.
static double term_along(bool has_encoder)
{
    along += 8.0 * way;
    const position_t q = has_encoder ? (position_t)(along - 4.0 * way) : TRIBO_EITHER((position_t)NAN, 0);
    return way * number(TRIBO(joint, step)(&joint, effort_of(0.3 * way), (position_t)along, q)) - 0.3;
}

/// Returns the time until the term is 0.
static double time_to_none(bool has_encoder, double h)
{
    int ticks = 1;
    while (fabs(term_along(has_encoder)) > 1e-6 && ticks < 100000)
    {
        ticks++;
    }
    return ticks * h;
}

/// Starts a motion, and returns its full term.
static double begin_along(double h, double pole, double to)
{
    tribo_joint_config_t config    = config_of(FRICTION);
    config.sample_time_s           = (float)h;
    config.actuator_pole_rad_per_s = (float)pole;
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, init)(&joint, &config));
    double full = 0.0;
    along       = 0.0;
    way         = to;
    for (int k = 0; k < (int)(2.0 / h) + 50; k++)
    {
        full = term_along(true);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.97 * FRICTION / 2.0, full);
    return full;
}

static void check_times(double h, double pole)
{
    const double lag  = pole > 0.0 ? 1.0 / pole : 0.0;
    const double most = 1.05 * (lag + 2.0 * h); // of a change of the term by itself
    const double full = begin_along(h, pole, 1.0);
    joint.cause       = TRIBO_JOINT_ASTRAY;
    const double fade = time_to_none(true, h);
    TEST_ASSERT_TRUE(fade <= fmax(0.1, 1.05 * lag + 4.0 * h) + 1e-9);
    TEST_ASSERT_DOUBLE_WITHIN(1.5 * h, fmax(0.05, most), fade);
    TRIBO(joint, restore)(&joint);
    int rise = 1;
    while (term_along(true) < 0.99 * full && rise < 100000)
    {
        rise++;
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * most + 0.004 + h, fmax(fmax(0.4, 8.0 * h), most), rise * h);
    while (term_along(true) < full - 1e-6 && rise < 100000)
    {
        rise++;
    }
#if !TRIBO_IS_Q31 // counts are never bad
    TEST_ASSERT_DOUBLE_WITHIN(1.5 * h, fmax(0.05, 4.0 * h) + most, time_to_none(false, h));
#endif
}

/// As the header states, with ticks from the shortest that is usual to the longest.
static void test_the_term_goes_and_comes_within_the_times_stated(void)
{
    static const double ticks_s[] = {1e-4, 1e-3, 0.02, 0.1};
    static const double poles[]   = {0.0, 50.0, 10.0, 5.0, 2.0, 1.0};
    for (size_t i = 0; i < sizeof ticks_s / sizeof ticks_s[0]; i++)
    {
        for (size_t k = 0; k < sizeof poles / sizeof poles[0]; k++)
        {
            check_times(ticks_s[i], poles[k]);
        }
    }
}

/// A smaller gain also acts behind a slow actuator and with long ticks.
static void test_the_term_follows_a_smaller_gain_at_any_lag(void)
{
    static const double ticks_s[] = {1e-3, 0.02, 0.1};
    static const double poles[]   = {0.0, 10.0, 1.0};
    for (size_t i = 0; i < 18u; i++)
    {
        const double h    = ticks_s[i / 3u % 3u];
        const double full = begin_along(h, poles[i % 3u], i < 9u ? 1.0 : -1.0);
        TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, gain)(&joint, 0.0f));
        for (double t = 0.0; t < 0.3; t += h)
        {
            (void)term_along(true);
        }
        TEST_ASSERT_TRUE(fabs(term_along(true)) < 0.15 * full); // exp(-3); long ticks are slower
        for (double t = 0.0; t < 2.5; t += h)
        {
            (void)term_along(true);
        }
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, term_along(true));
    }
}

/// True if a slide of `ticks` counts as a whole: no fast part of it is kept. The motion is a sine, q_ref ahead.
static bool counts_whole(double h, double pole, int ticks)
{
    tribo_joint_config_t config    = config_of(FRICTION);
    config.sample_time_s           = (float)h;
    config.actuator_pole_rad_per_s = (float)pole;
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, init)(&joint, &config));
    const double turn     = acos(-1.0) / ticks;
    bool         is_whole = true;
    int          slides   = 0;
    for (int k = 0; slides < 8 && k < 20 * ticks; k++)
    {
        const double q_ref = 8000.0 * sin(turn * (k + 1.0));
        (void)step(0.1, floor(q_ref), floor(8000.0 * sin(turn * k)));
        if (joint.slide.ended == 2u)
        {
            slides++;
            is_whole = joint.slide.fast_travel == 0;
        }
    }
    TEST_ASSERT_EQUAL(8, slides);
    return is_whole;
}

/// As the header states.
static void test_all_of_a_brief_slide_counts(void)
{
    static const double ticks_s[] = {1e-3, 3e-3, 0.02, 0.1};
    static const double poles[]   = {0.0, 50.0, 10.0};
    for (size_t i = 0; i < 12u; i++)
    {
        const double h     = ticks_s[i / 3u];
        const double pole  = poles[i % 3u];
        const double lag   = pole > 0.0 ? 1.0 / pole : 0.0;
        const double brief = 6.0 * (fmax(0.8 * (lag + 2.0 * h), fmax(5.0 * h, 0.01)) + h) / h;
        TEST_ASSERT_TRUE(counts_whole(h, pole, (int)floor(brief) - 1));
        TEST_ASSERT_FALSE(counts_whole(h, pole, (int)ceil(brief) + 1));
    }
}

static void test_a_reference_may_step_by_any_amount(void)
{
    begin(FRICTION);
    for (int k = 0; k < 12; k++)
    {
        const double to = k % 2 == 0 ? 4100.0 : 0.0; // more than 1000 travels
        double       q  = 4100.0 - to;
        for (int i = 0; i < 1000; i++) // without overshoot
        {
            q += 0.01 * (to - q);
            (void)step(0.0001 * (to - q), to, floor(q));
        }
    }
    TEST_ASSERT_EQUAL(TRIBO_JOINT_SOUND, report().cause);
}

static void test_a_joint_that_is_off_by_two_travels_turns_and_not_before(void)
{
    begin(0.2);
    lead(1000);
    rest(999.0, 999.0 + 8.0, 200);
    TEST_ASSERT_EQUAL(1, joint.sign);
    rest(999.0, 999.0 + 9.0, 200);
    TEST_ASSERT_EQUAL(-1, joint.sign);
    TEST_ASSERT_EQUAL(1, joint.turns);
    for (int i = 0; i < 20; i++)
    {
        (void)step(0.0, 999.0 + i, 1000.0 + i);
    }
    TEST_ASSERT_EQUAL(0, joint.turns);
}

static void test_one_pair_of_slides_moves_what_is_learned_by_a_quarter_at_most(void)
{
    begin_without_term();
    slides(6, 400.0, 1.0, 0.2);
    const float before = report().friction;
    slides(2, 400.0, 1.0, 0.9);
    TEST_ASSERT_TRUE(report().friction > 1.1f * before);
    TEST_ASSERT_TRUE(report().friction < 1.6f * before); // two ends of slides
}

static void test_a_joint_behind_its_reference_is_not_astray(void)
{
    begin(0.2);
    for (int i = 0; i < 2000; i++) // it catches up with a lag
    {
        (void)step(0.0, 500.0 + 0.5 * i, fmin(500.0 + 0.5 * i - 20.0, 1.0 * i));
    }
    TEST_ASSERT_EQUAL(TRIBO_JOINT_SOUND, report().cause);
}

static void test_a_term_alone_does_not_pull_a_joint_back(void)
{
    begin(0.2);
    rest(100.0, 80.0, 200);
    TEST_ASSERT_TRUE(number(joint.term) > 0.05); // the loop pulls, too
    for (int i = 0; i < 200; i++)
    {
        (void)step(0.0, 100.0, 80.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, number(joint.term));
    for (int i = 0; i < 200; i++)
    {
        (void)step(-0.1, 100.0, 80.0);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, number(joint.term));
}

static void test_a_joint_that_goes_astray_loses_its_term_within_a_tenth_of_a_second_until_restored(void)
{
    begin(0.2);
    lead(200);
    TEST_ASSERT_TRUE(number(joint.term) > 0.05);
    TEST_ASSERT_EQUAL(TRIBO_JOINT_SOUND, report().cause);
    for (int i = 0; i < 120; i++) // three times as fast as it shall be
    {
        (void)step(0.0, 200.0 + i, 200.0 + 3.0 * i);
    }
    TEST_ASSERT_EQUAL(TRIBO_JOINT_ASTRAY, report().cause);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, report().share);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, number(joint.term));
    const double at = 500.0;
    rest(at, at, 2000);
    TEST_ASSERT_EQUAL_FLOAT(0.0f, report().share); // latched
    TRIBO(joint, restore)(&joint);
    TEST_ASSERT_EQUAL(TRIBO_JOINT_SOUND, report().cause);
    (void)step(0.0, at, at);
    TEST_ASSERT_TRUE(report().share < 0.01f); // it ramps
    rest(at, at, 600);
    TEST_ASSERT_EQUAL_FLOAT(1.0f, report().share);
}

static void test_a_joint_that_moves_fast_may_run_ahead_for_a_tenth_of_a_second(void)
{
    begin(0.2);
    slides(4, 4000.0, 10.0, 0.2);
    for (int i = 0; i < 90; i++)
    {
        (void)step(0.0, 10.0 + 10.0 * i, 12.0 * i);
    }
    TEST_ASSERT_EQUAL(TRIBO_JOINT_SOUND, report().cause);
}

static void test_a_joint_that_hunts_at_rest_is_quiet_after_four_turns(void)
{
    begin(0.2);
    lead(100);
    double size[8];
    for (int turn = 0; turn < 8; turn++)
    {
        rest(100.0, turn % 2 == 0 ? 120.0 : 80.0, 100);
        size[turn] = fabs(number(joint.term));
        TEST_ASSERT_EQUAL(turn < 3 ? TRIBO_JOINT_SOUND : TRIBO_JOINT_HUNTING, report().cause);
    }
    TEST_ASSERT_TRUE(size[0] > 0.05);
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * size[0], 0.5 * size[0], size[1]);
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * size[0], 0.25 * size[0], size[2]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.0, size[7]);
}

static void test_an_effort_with_the_wrong_sign_is_found(void)
{
    begin(0.2);
    slides(8, 400.0, 1.0, -0.2);
    TEST_ASSERT_EQUAL(TRIBO_JOINT_REVERSED, report().cause);
    slides(4, 400.0, 1.0, -0.2);
    TEST_ASSERT_EQUAL(TRIBO_JOINT_REVERSED, report().cause);
    TEST_ASSERT_TRUE(report().friction < 0.2f);
}

/// Swings of a heavy joint at 8 to 16 Hz by an effort of up to seven times its friction, `sign` times what it takes. A swing lasts 3 to 6 time
/// constants of the low pass.
static tribo_joint_report_t swings(double hertz, double heavy, double sign)
{
    const double         turn      = 6.283185307179586 * hertz * H;
    tribo_joint_config_t config    = config_of(0.0);
    config.actuator_pole_rad_per_s = 0.0f;
    config.gain                    = 0.0f;
    TEST_ASSERT_EQUAL(TRIBO_OK, TRIBO(joint, init)(&joint, &config));
    for (int k = 0; k < 1000; k++)
    {
        const double middle = turn * (k + 0.5); // between this tick and the next one
        const double effort = copysign(FRICTION, cos(middle)) - heavy * sin(middle);
        const double q      = floor(1000.0 * sin(turn * k));
        (void)step(sign * effort, q + 1.0, q);
    }
    return report();
}

static void test_quick_swings_are_not_taken_for_a_wrong_sign(void)
{
    for (int hertz = 8; hertz <= 16; hertz += 2)
    {
        for (int i = 1; i <= 6; i++)
        {
            const tribo_joint_report_t x = swings(hertz, 0.1 * i, 1.0);
            TEST_ASSERT_EQUAL(TRIBO_JOINT_SOUND, x.cause);
            TEST_ASSERT_FLOAT_WITHIN(0.4f * (float)FRICTION, (float)FRICTION, x.friction);
            TEST_ASSERT_EQUAL(TRIBO_JOINT_REVERSED, swings(hertz, 0.1 * i, -1.0).cause);
        }
    }
}

static void test_each_cause_has_a_sentence(void)
{
    TEST_ASSERT_EQUAL_STRING("sound", tribo_joint_cause_text(TRIBO_JOINT_SOUND));
    TEST_ASSERT_NOT_NULL(strstr(tribo_joint_cause_text(TRIBO_JOINT_ASTRAY), "_load"));
    TEST_ASSERT_NOT_NULL(strstr(tribo_joint_cause_text(TRIBO_JOINT_HUNTING), "restore"));
    TEST_ASSERT_NOT_NULL(strstr(tribo_joint_cause_text(TRIBO_JOINT_REVERSED), "rattles"));
}

// --- the force ---------------------------------------------------------------------------------------------------------------------------------

static void test_the_force_from_current_is_within_its_interval(void)
{
    plant_t x = {.friction = FRICTION};
    begin(0.0);
    TEST_ASSERT_TRUE(TRIBO(joint, force)(&joint).high >= 1.0f);
    (void)moves(&x, 0, 13);
    const double at = wanted(13 * MOVE - 1);
    for (int i = 0; i < 3000; i++) // something pushes, slowly
    {
        x.outer = i < 2000 ? -0.3 * i / 2000.0 : -0.3;
        (void)plant_step(&x, at);
        const tribo_joint_force_t force = TRIBO(joint, force)(&joint);
        TEST_ASSERT_TRUE((double)force.low <= -x.outer + 0.005 && -x.outer <= (double)force.high + 0.005);
        TEST_ASSERT_TRUE((double)(force.high - force.low) <= 2.0 * 1.5 * 1.1 * FRICTION);
    }
    TEST_ASSERT_TRUE(TRIBO(joint, force)(&joint).low > 0.1f); // it holds something
}

/// A PD that has no integral, whose q_ref starts at its peak speed: the joint overshoots q_ref in its first swing. `is_exchanged`: the motor's
/// phases are, so that the joint runs away.
static tribo_joint_report_t swung(double hertz, double swing, bool is_exchanged)
{
    const double turn = 6.283185307179586 * hertz;
    plant_t      x    = {.friction = FRICTION};
    double       last = 0.0;
    begin(0.1);
    for (long tick = 0; tick < 3000; tick++)
    {
        const double t      = H * (double)tick;
        const double q      = floor(x.position);
        const double e      = swing * sin(turn * t) - q;
        const double effort = fmax(-1.0, fmin(1.0, MASS * 40.0 * (40.0 * e + (e - last) / H)));
        const double u      = step(effort, swing * sin(turn * t), q);
        last                = e;
        move(&x, is_exchanged ? -u : u);
    }
    return report();
}

static void test_a_quick_start_is_no_runaway(void)
{
    const double swings[][2] = {{2.0, 2000.0}, {4.0, 500.0}, {1.0, 4000.0}};
    for (uint32_t i = 0; i < 3; i++)
    {
        const tribo_joint_report_t sound = swung(swings[i][0], swings[i][1], false);
        TEST_ASSERT_EQUAL(TRIBO_JOINT_SOUND, sound.cause);
        TEST_ASSERT_TRUE(sound.is_learned && sound.share == 1.0f);
        TEST_ASSERT_NOT_EQUAL(TRIBO_JOINT_SOUND, swung(swings[i][0], swings[i][1], true).cause);
    }
}

#include "runners/test_joint.inc" // main
