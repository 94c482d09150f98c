// What the feed-forward without a force sensor learns from the effort of another loop: against a model in double precision that is
// written from docs/feedforward.md alone, and what it promises besides.

#define FULL_SCALE_N 4.0
#include ARITH_HEADER
#include "random.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define H      1e-3
#define UP     0.060 // breakaway of each direction
#define DOWN   0.040
#define SLOPE  0.05
#define G0     0.02
#define BELIEF 0.9
#define CLOSE  TRIBO_EITHER(2e-6, 2e-7)
#define UNIT   TRIBO_EITHER(1.0, 1.0 / 536870912.0) // of Q29

typedef struct
{
    TRIBO(force_loop, params_t) params, fed; // without a sensor, with one
    TRIBO(feedforward, params_t) own, of_fed;
    TRIBO(feedforward, memory_t) memory;
    TRIBO(force_loop, state_t) state;
    TRIBO(force_loop, signals_t) signals;
    tribo_point_t table[2][TRIBO_BREAKAWAY_POINTS_MAX];
} blind_t;

static tribo_force_loop_f32_config_t  config;
static tribo_feedforward_f32_config_t method;
static tribo_sensorless_f32_config_t  sensorless;
static blind_t                        x, other;

static void init(blind_t *b)
{
    memset(b, 0, sizeof *b);
    TEST_ASSERT_EQUAL_INT(
        TRIBO_OK,
        tribo_init_sensorless(&b->params, b->table[0], &b->own, &config, &method, &sensorless, (float)FULL_SCALE_N));
    TEST_ASSERT_EQUAL_INT(
        TRIBO_OK,
        tribo_init_feedforward(&b->fed, b->table[1], &b->of_fed, &config, &method, (float)FULL_SCALE_N));
    b->state.memory = &b->memory.state.tick;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, TRIBO(force_loop, start)(&b->state, &b->params, false));
}

void setUp(void)
{
    config                                        = tribo_force_loop_f32_paper();
    config.compensator.friction.positive.offset_n = (float)UP;
    config.compensator.friction.negative.offset_n = (float)DOWN;
    config.compensator.friction.positive.slope    = (float)SLOPE;
    config.compensator.friction.negative.slope    = (float)SLOPE;
    config.compensator.friction.gravity_n         = (float)G0;
    method                                        = tribo_feedforward_f32_default();
    sensorless                                    = tribo_sensorless_f32_default();
    init(&x);
    init(&other);
}

static void move(blind_t *b, double intended, double measured)
{
    TRIBO(sensorless, motion)(&b->memory,
                              TRIBO_EITHER((float)intended, (int32_t)(intended * 536870912.0)),
                              TRIBO_EITHER((float)measured, (int32_t)(measured * 536870912.0)));
}

static double tick(blind_t *b, const TRIBO(force_loop, params_t) * params, double r)
{
    return from_force(TRIBO(force_loop, step)(params, &b->state, to_force(r), 0, &b->signals));
}

static double weight(const blind_t *b)
{
    return (double)b->memory.state.weights.sliding * UNIT;
}

static double constant(const blind_t *b)
{
    return (double)(b->own.learning.deviation[3] * b->memory.state.learner.a[3]);
}

static double variance(const blind_t *b)
{
    return (double)b->memory.state.learner.P[0];
}

static double travelled(const blind_t *b)
{
    return (double)b->memory.state.learner.travel_n;
}

// --- the model -------------------------------------------------------------------------------------------------------

typedef struct
{
    double u1, mv, zf, p, X, W, G, X_last, a_last, l_last;
    int    side, known;
    long   n;
    double V, c, M, travel;
    double slack[2], sigma, b;
    int    s;
} model_t;

static double clamp(double value, double low, double high)
{
    return fmin(fmax(value, low), high);
}

static double L_of(double force)
{
    return 0.5 * (UP + DOWN) + SLOPE * fabs(force);
}

#define D   (0.5 * (UP - DOWN) - G0)
#define P_A 200.0
#define TAU (1.0 / P_A + 0.0288 / 3.84)
#define B   L_of(2.0 / 4.0)
#define W_R (B / 314.0)

static model_t model_of(double r)
{
    return (model_t){.u1 = r, .V = 1.0, .M = 1.0};
}

static void model_ends(model_t *m)
{
    if (m->n >= 1L << 20 || m->X * m->side < 16.0 || m->G * m->side <= 0.0)
    {
        return;
    }
    const double way = fabs(m->X);
    const double a   = m->W / way;
    const double l   = m->G / m->X * (1.0 + 2.0 / way);
    if (m->X * m->X_last < 0.0)
    {
        const double delta = fmin(way, fabs(m->X_last));
        const double g     = 0.5 * delta / (delta + 32.0);
        const double V     = clamp((a + m->a_last) / (l + m->l_last), 0.0, 4.0);
        const double c     = m->side * (a - m->a_last - V * (l - m->l_last)) / 2.0;
        m->V               = clamp(m->V + g * clamp(V - m->V, -0.25, 0.25), 0.02, 3.0);
        m->c               = clamp(m->c + g * clamp(c - m->c, -2.0 * B, 2.0 * B), -B, B);
        m->M               = (1.0 - g) * m->M;
        m->M += fmin(1.0, 0.0157 / B * W_R * delta) * (1.0 - m->M);
        m->travel += W_R * way;
    }
    m->X_last = m->X;
    m->a_last = a;
    m->l_last = l;
}

static void model_slides(model_t *m, double r, double measured)
{
    const double T_y  = fmax(0.8 * TAU, 5.0 * H);
    const double part = H / (T_y + H);
    m->mv += part * (measured - m->mv);
    m->zf += part * (m->u1 - D - m->zf);
    const double at   = m->p + m->mv;
    m->p              = clamp(at, -0.5, 0.5);
    const double push = at - m->p;
    if (push != 0.0 && (push > 0.0 ? 1 : -1) != m->side)
    {
        model_ends(m);
        m->side = push > 0.0 ? 1 : -1;
        m->n    = 0;
        m->X = m->W = m->G = 0.0;
    }
    if (m->n < 1L << 20)
    {
        m->n++;
        m->X += m->mv;
        m->W += m->zf * m->mv;
        m->G += L_of(r) * m->mv;
    }
}

/// u. The intended motion is never at rest, and u never limited.
static double model_tick(model_t *m, double r, double intended, double measured)
{
    const double V_before = m->known ? m->V : 1.0;
    m->known              = 1;
    model_slides(m, r, measured);
    const double pushed = m->slack[0] + intended;
    m->slack[0]         = clamp(pushed, -0.5, 0.5);
    m->s                = pushed > 0.5 ? 1 : pushed < -0.5 ? -1 : m->s;
    const double last   = m->sigma;
    m->sigma += clamp(m->s - m->sigma, -2.0 * H / (2.1 * TAU), 2.0 * H / (2.1 * TAU));
    const double level = BELIEF * L_of(r);
    m->b += level * (m->V - V_before) * m->sigma;
    m->b -= H / (0.3 + H) * m->b;
    const double lead = 0.7 / (P_A * H) * level * m->V * (m->sigma - last);
    const double u    = r + D + level * m->V * m->sigma + lead - m->b;
    m->u1 += (1.0 - exp(-P_A * H)) * (u - m->u1);
    return u;
}

/// Motions of many speeds and lengths, and an effort that has little to do with them.
static void test_each_step_is_that_of_the_model(void)
{
    random_t r      = {.state = 0xeff0ULL};
    model_t  m      = model_of(0.3);
    double   speed  = 0.0;
    double   effort = 0.3;
    double   goal   = 0.3;
    double   most   = 0.0;
    for (int k = 0; k < 300000; k++)
    {
        if (k % 400 == 0)
        {
            speed = random_between(&r, -1.2, 1.2);
            speed = k % 2000 == 0 ? 0.02 * speed : speed;
            goal  = 0.03 + (speed > 0.0 ? 0.05 : -0.05) * (k < 150000 ? 2.5 : 0.3) + random_between(&r, -0.02, 0.02);
        }
        effort += 0.02 * (goal - effort);
        const double intended = speed > 0.0 ? 0.25 : -0.25;
        const double fine     = floor(speed * 16384.0) / 16384.0;
        const double given    = (double)(float)effort;
        move(&x, intended, fine);
        const double u = tick(&x, &x.params, given);
        most           = fmax(most, fabs(u - model_tick(&m, given, intended, fine)));
        TEST_ASSERT_DOUBLE_WITHIN(3e-5, m.V, weight(&x));
    }
    TEST_ASSERT_TRUE(m.travel > 100.0 * W_R && fabs(m.V - 1.0) > 0.1);
    TEST_ASSERT_DOUBLE_WITHIN(5e-6, 0.0, most);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, m.c, constant(&x));
    TEST_ASSERT_DOUBLE_WITHIN(2e-6, m.M, variance(&x));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * m.travel, m.travel, travelled(&x));
}

// --- promises --------------------------------------------------------------------------------------------------------

/// An axis that moves as given, and the effort that its loop asks for: what friction, load and mass need beside what is fed.
typedef struct
{
    double friction, load, mass; // of u; N a width per tick^2
    double amplitude;            // widths
    double period;               // ticks
    double last, fed;
    long   k;
} axis_t;

static double place(const axis_t *a, long k)
{
    return -a->amplitude * cos(6.283185307179586 * (double)k / a->period);
}

/// A tick. Returns u.
static double axis_tick(axis_t *a, blind_t *b)
{
    const double before = place(a, a->k - 1);
    const double now    = place(a, a->k);
    const double next   = place(a, a->k + 1);
    const double side   = next > now ? 1.0 : -1.0;
    const double needed = side * a->friction + a->load + a->mass * (next - 2.0 * now + before);
    a->k++;
    move(b, now - before, now - before);
    const double u = tick(b, &b->params, needed - a->fed);
    a->fed         = u - (needed - a->fed);
    return u;
}

static axis_t axis_of(double friction)
{
    return (axis_t){.friction = friction, .load = D, .amplitude = 200.0, .period = 1000.0};
}

static void slide(axis_t *a, blind_t *b, int periods)
{
    for (int k = 0; k < periods * (int)a->period; k++)
    {
        (void)axis_tick(a, b);
    }
}

/// Removes the slope of the model, so that L is the same at each effort.
static void without_slope(void)
{
    config.compensator.friction.positive.slope = 0.0f;
    config.compensator.friction.negative.slope = 0.0f;
    init(&x);
    init(&other);
}

static void test_two_slides_tell_friction_and_load(void)
{
    without_slope();
    for (int i = 0; i < 4; i++)
    {
        static const double truth[] = {0.5, 0.7, 1.4, 2.0};
        axis_t              a       = axis_of(0.05 * truth[i]);
        a.load                      = D + 0.013;
        init(&x);
        slide(&a, &x, 20);
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * truth[i], truth[i], weight(&x));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.013, constant(&x));
        TEST_ASSERT_TRUE(variance(&x) < 0.1);
    }
}

/// 400 widths of 0.5 N are 12 times 1/Q, and 6.25 times what Q31 can count: their rest would be half of 1/Q.
static void test_a_travel_beyond_forgetting_returns_all_of_the_variance(void)
{
    method.reversal_n       = 0.5f;
    method.forgetting_per_n = 1.0f / 16.0f;
    without_slope();
    axis_t a = axis_of(0.05);
    slide(&a, &x, 4);
    TEST_ASSERT_TRUE(travelled(&x) > 400.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 1.0, variance(&x));
}

/// The mass takes ten times what friction does at the ends of a stroke. The axis has no actuator's lag.
static void test_acceleration_is_not_friction(void)
{
    method.actuator_pole_rad_per_s = 20000.0f;
    without_slope();
    axis_t a = axis_of(0.05);
    a.mass   = 0.5 / (200.0 * pow(6.283185307179586 / 1000.0, 2));
    slide(&a, &x, 20);
    TEST_ASSERT_DOUBLE_WITHIN(0.03, 1.0, weight(&x));
}

static void test_what_is_learned_does_not_depend_on_belief(void)
{
    without_slope();
    axis_t a          = axis_of(0.08);
    axis_t same       = a;
    sensorless.belief = 0.2f;
    init(&other);
    slide(&a, &x, 20);
    slide(&same, &other, 20);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, weight(&x), weight(&other));
}

static void test_what_is_learned_is_told_as_that_of_the_method_with_y(void)
{
    without_slope();
    axis_t a = axis_of(0.1);
    a.load   = D + 0.013;
    slide(&a, &x, 20);
    for (uint32_t direction = 0; direction < 2; direction++)
    {
        const tribo_feedforward_learned_t told =
            TRIBO(feedforward, learned)(&x.params, &x.memory.state, direction, to_force(0.3));
        const double load = UP - 0.05 + 0.013; // of the directions, and beside gravity
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, 0.1 + (direction == 0 ? load : -load), (double)told.L_n);
        TEST_ASSERT_TRUE(told.relative_variance < 0.1f);
        TEST_ASSERT_FALSE(told.at_bound);
    }
}

/// f has the same bits then, even if something was learned with a sensor.
static void test_without_a_motion_nothing_is_learned_nor_used(void)
{
    (void)tick(&x, &x.params, 0.4);
    (void)tick(&other, &other.params, 0.4);
    x.memory.state.weights.sliding = TRIBO_EITHER(2.0f, 1 << 30); // with its seal broken, too
    for (int k = 0; k < 9000; k++)
    {
        const double r = 0.4 + 0.1 * sin(2e-3 * k);
        TEST_ASSERT_TRUE(tick(&x, &x.params, r) == tick(&other, &other.params, r));
    }
    TEST_ASSERT_TRUE(weight(&x) == 2.0 && variance(&other) == 1.0);
    TEST_ASSERT_EQUAL_UINT32(0, x.memory.state.forgotten);
}

static void test_neither_at_rest_nor_in_noise_nor_one_way_is_anything_learned(void)
{
    random_t r = {.state = 0x57111ULL};
    for (int k = 0; k < 60000; k++)
    {
        // Noise, creeping to and fro by 5 widths, then one way alone.
        const double motion = k < 20000   ? random_between(&r, -0.4, 0.4)
                              : k < 40000 ? (k % 4000 < 2000 ? 0.0025 : -0.0025)
                                          : 0.3;
        move(&x, 0.0, motion);
        (void)tick(&x, &x.params, 0.1 * sin(0.01 * k));
    }
    TEST_ASSERT_TRUE(weight(&x) == 1.0 && constant(&x) == 0.0 && variance(&x) == 1.0);
}

/// Where a slide ends f is no further than a tick of its ramp from what it was, but u goes on as it would without.
static void test_u_does_not_move_where_it_learns(void)
{
    without_slope();
    int learned = 0;
    for (int k = 0; k < 40000; k++)
    {
        const double motion     = k % 2000 < 1000 ? 0.5 : -0.5;
        const double r          = k % 2000 < 1000 ? 0.1 : -0.1;
        const double before     = weight(&x);
        other                   = x; // one that does not slide in this tick
        other.state.memory      = &other.memory.state.tick;
        other.state.memory_seal = ~(uintptr_t)&other.memory.state.tick;
        other.params.method     = &other.own.method;
        other.state.active      = &other.params;
        move(&x, 1.0, motion);
        move(&other, 1.0, 0.0);
        const double u = tick(&x, &x.params, r);
        const double v = tick(&other, &other.params, r);
        if (weight(&x) != before)
        {
            const double by = BELIEF * 0.05 * fabs(weight(&x) - before);
            learned++;
            TEST_ASSERT_TRUE(by > 1e-4 || learned > 6);
            TEST_ASSERT_DOUBLE_WITHIN(0.005 * by + CLOSE, v, u);
        }
    }
    TEST_ASSERT_TRUE(learned > 10);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, BELIEF * 0.05 * weight(&x), from_force(x.signals.compensator.friction.TRIBO_N(f)));
    for (int k = 0; k < 3000; k++)
    {
        move(&x, 1.0, 0.0);
        (void)tick(&x, &x.params, 0.1);
    }
    move(&x, 1.0, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 0.1 + D + BELIEF * 0.05 * weight(&x), tick(&x, &x.params, 0.1)); // b is gone
}

static void test_a_push_moves_the_weight_by_an_eighth_at_most(void)
{
    double before = 1.0;
    for (int k = 0; k < 40000; k++)
    {
        const double motion = k % 2000 < 1000 ? 0.5 : -0.5;
        move(&x, motion, motion);
        (void)tick(&x, &x.params, k % 2000 < 1000 ? 1.0 : -1.0);
        TEST_ASSERT_TRUE(fabs(weight(&x) - before) <= 0.125 + 1e-6);
        before = weight(&x);
    }
    TEST_ASSERT_TRUE(weight(&x) == 3.0);
}

static bool stays(void)
{
    return TRIBO(feedforward, learned)(&x.params, &x.memory.state, 0, 0).stays_at_bound;
}

static void test_a_weight_at_a_bound_is_latched_after_four_slides_until_restored(void)
{
    for (int less = 0; less < 2; less++)
    {
        init(&x);
        int at_bound = 0;
        for (int k = 0; k < 80000 && !stays(); k++)
        {
            const double motion = k % 2000 < 1000 ? 0.5 : -0.5;
            const double before = (double)x.memory.state.learner.travel_n;
            move(&x, motion, motion);
            (void)tick(&x, &x.params, (less != 0 ? -1.0 : 1.0) * (k % 2000 < 1000 ? 1.0 : -1.0));
            at_bound += (double)x.memory.state.learner.travel_n != before && (weight(&x) <= 0.2 || weight(&x) >= 3.0);
        }
        TEST_ASSERT_EQUAL_INT(4, at_bound);
        TEST_ASSERT_TRUE(weight(&x) >= 0.02 - 1e-6 && weight(&x) <= 3.0);
        TRIBO(feedforward, restore)(&x.memory.state);
        TEST_ASSERT_FALSE(stays());
    }
}

static void test_mirrored_slides_give_mirrored_bits(void)
{
    config.compensator.friction.negative  = config.compensator.friction.positive;
    config.compensator.friction.gravity_n = 0.0f;
    init(&x);
    init(&other);
    for (int k = 0; k < 40000; k++)
    {
        const double motion = 0.6 * sin(0.005 * k);
        const double r      = 0.1 * sin(0.005 * k + 0.3) + 0.01 * cos(0.0012 * k);
        move(&x, motion, motion);
        move(&other, -motion, -motion);
        TEST_ASSERT_TRUE(tick(&x, &x.params, r) == -tick(&other, &other.params, -r));
        TEST_ASSERT_TRUE(weight(&x) == weight(&other) && constant(&x) == -constant(&other));
    }
    TEST_ASSERT_TRUE(weight(&x) != 1.0);
}

/// Returns the weight after a third slide in the middle of which something is wrong.
static double third_slide(int wrong)
{
    init(&x);
    for (int k = 0; k < 4500; k++)
    {
        const double motion = k % 2000 < 1000 ? 0.5 : -0.5;
        move(&x, motion, motion);
        if (k == 2500 && wrong == 1)
        {
            TRIBO(sensorless, motion)(&x.memory, 0, TRIBO_EITHER(NAN, INT32_MIN));
        }
        if (k == 2500 && wrong == 2)
        {
            TRIBO(sensorless, motion)(&x.memory, 0, TRIBO_EITHER(1001.0f, INT32_MAX - (1 << 23)));
        }
        if (k == 2500 && wrong == 3)
        {
            x.memory.motion.effort.ticks = (1u << 20) - 500u; // a slide without an end
        }
        (void)tick(&x, &x.params, k >= 2000 && k < 3000 ? 0.4 : k % 2000 < 1000 ? 0.1 : -0.1);
    }
    return weight(&x);
}

static void test_a_slide_with_a_motion_that_is_none_does_not_count(void)
{
    const double good = third_slide(0);
    for (int wrong = 1; wrong <= 3; wrong++)
    {
        TEST_ASSERT_TRUE(fabs(third_slide(wrong) - good) > 0.05);
        TEST_ASSERT_EQUAL_UINT32(0, x.memory.state.forgotten);
    }
}

static void test_a_flipped_bit_of_what_is_learned_is_forgotten_and_counted_and_u_goes_on(void)
{
    without_slope();
    for (int number = 0; number < 3; number++)
    {
        init(&x);
        axis_t a = axis_of(0.1);
        slide(&a, &x, 20);
        const double u         = axis_tick(&a, &x);
        void *const  numbers[] = {&x.memory.state.weights.sliding,
                                  &x.memory.state.weights.constant,
                                  &x.memory.state.weights.use[0]};
        ((unsigned char *)numbers[number])[2] ^= 0x40u;
        TEST_ASSERT_DOUBLE_WITHIN(2e-3, u, axis_tick(&a, &x));
        TEST_ASSERT_EQUAL_UINT32(1, x.memory.state.forgotten);
        TEST_ASSERT_TRUE(weight(&x) == 1.0);
        slide(&a, &x, 20);
        TEST_ASSERT_DOUBLE_WITHIN(0.05, 2.0, weight(&x));
    }
}

/// What a flip in a slide's sums does is bounded, and learned away.
static void test_a_corrupt_slide_heals(void)
{
    static const uint32_t bad[] = {0x7fc00000u, 0x7f800000u, 0xff7fffffu, 0x80000000u, 0x7fffffffu, 0xffffffffu};
    without_slope();
    axis_t a = axis_of(0.1);
    slide(&a, &x, 20);
    const size_t size = sizeof x.memory.motion.effort;
    for (size_t at = 0; at + 4u <= size; at += 4u)
    {
        for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        {
            const double before = weight(&x);
            memcpy((char *)&x.memory.motion.effort + at, &bad[i], 4u);
            x.memory.state.actuator = TRIBO_EITHER(NAN, INT32_MIN);
            slide(&a, &x, 1);
            TEST_ASSERT_DOUBLE_WITHIN(0.376, before, weight(&x));
            slide(&a, &x, 9);
            TEST_ASSERT_DOUBLE_WITHIN(0.05, 2.0, weight(&x));
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0, x.memory.state.forgotten);
}

/// A weight that was learned with a sensor is used from the first known motion on: b takes what f changes by.
static void test_u_goes_on_where_a_motion_becomes_known(void)
{
    without_slope();
    axis_t a = axis_of(0.1);
    slide(&a, &x, 20);
    x.memory.motion.was_known = 0;
    for (int k = 0; k < 3000; k++)
    {
        (void)tick(&x, &x.params, 0.1 + 1e-5 * k);
    }
    const double before = tick(&x, &x.params, 0.13);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, BELIEF * 0.05, from_force(x.signals.compensator.friction.TRIBO_N(f)));
    move(&x, 2.0, 0.0);
    TEST_ASSERT_DOUBLE_WITHIN(4e-4, before, tick(&x, &x.params, 0.13));
    TEST_ASSERT_DOUBLE_WITHIN(3e-3, BELIEF * 0.1, from_force(x.signals.compensator.friction.TRIBO_N(f)));
}

/// What was learned stays over a restart; the slide does not.
static void test_a_restart_ends_the_slide_and_keeps_what_was_learned(void)
{
    without_slope();
    axis_t a = axis_of(0.1);
    slide(&a, &x, 20);
    const double learned = weight(&x);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, TRIBO(force_loop, start)(&x.state, &x.params, true));
    for (int k = 0; k < 3500; k++) // in one direction and back: the first slides are none of the last ones' other half
    {
        move(&x, k < 2000 ? 0.5 : -0.5, k < 2000 ? 0.5 : -0.5);
        (void)tick(&x, &x.params, 1.0);
        TEST_ASSERT_TRUE(weight(&x) == learned);
    }
}

#include "runners/test_effort.inc" // main
