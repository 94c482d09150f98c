// The loop with the feed-forward in place of the paper's compensator, and changes between the two and to none, around a plant
// that is a play: an arm without mass that sticks within its breakaway. On an emulated processor the runs are shorter: it computes
// the host's bits (tests/identity, tests/lock_step), so the long ones would find the same there.

#define FULL_SCALE_N 4.0 // of Q31, so that an input beyond input_max shows as such
#include "feedforward.h"
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define H     1e-3
#define TICKS RUNS(41000, 11000)
#define LEARN RUNS(25000, 5000) // ticks in which there is something to learn
#define L0    0.007             // the paper's breakaway
#define L1    0.3

static tribo_force_loop_f32_config_t  config;
static tribo_feedforward_f32_config_t feedforward;
static loop_t                         loop;
static loop_t                         other;
static loop_t                         unchanged;
static loop_seen_t                    seen;

typedef struct
{
    double actuator, F, y;
} plant_t;

static plant_t plant;

static void move(plant_t *p, double u)
{
    p->actuator += 0.18 * (u - p->actuator);
    const double L = L0 + L1 * fabs(p->F);
    p->F           = fmax(p->actuator - L, fmin(p->actuator + L, p->F));
    p->y += 0.0535 * (p->F - p->y);
}

/// 0.4 to 0.6 N, period 20 s.
static double triangle(int k)
{
    const double phase = fmod(k * H, 20.0);
    return 0.4 + 0.02 * (phase < 10.0 ? phase : 20.0 - phase);
}

static void tick(int k)
{
    seen = loop_step(&loop, triangle(k), plant.y);
    move(&plant, seen.u);
}

static void run(int from, int to)
{
    for (int k = from; k < to; k++)
    {
        tick(k);
    }
}

static void begin(void)
{
    plant = (plant_t){0};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&loop, &config, &feedforward));
}

void setUp(void)
{
    config      = tribo_force_loop_f32_paper();
    feedforward = tribo_feedforward_f32_default();
    begin();
}

typedef enum
{
    OFF,
    PAPER,
    FEEDFORWARD,
    METHODS
} method_t;

static loop_t by[METHODS]; // params

static void make_methods(void)
{
    const float gain = config.gain;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&by[PAPER], &config, NULL));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&by[FEEDFORWARD], &config, &feedforward));
    config.gain = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&by[OFF], &config, NULL));
    config.gain = gain;
}

// --- the tick ----------------------------------------------------------------------------------------------------

/// With everything in it: ramps, steps, stands, limits and bad inputs.
static double rough(int k)
{
    const double jump = k % 6000 > 5600 ? 0.7 : 0.0;
    const double sign = k % 9000 > 6500 ? triangle(6500) : triangle(9 * k);
    return k % 700 == 699 ? 2.5 : sign - jump;
}

static void test_loop_is_controller_and_feedforward_joined(void)
{
    static feedforward_t parts;
    TRIBO(controller, state_t) controller;
    config.controller.u_max_n = 0.72f;
    begin();
    TEST_ASSERT_EQUAL_INT(
        TRIBO_OK,
        feedforward_init_scaled(&parts, &feedforward, &config.compensator, (double)config.input_max_n, H, 1.0));
    TRIBO(controller, reset)(&controller);
    for (int k = 0; k < TICKS; k++)
    {
        const double y = k % 800 == 799 ? 3.0 : plant.y;
        TRIBO(controller, signals_t) alone;
        TRIBO(controller, state_t) copy = controller;
        const tribo_force_t e           = to_force(feedforward_before(&parts, rough(k), y));
        (void)TRIBO_PART(controller, step)(&loop.params.controller, &copy, e, 0, &alone);
        const double v     = from_force(alone.TRIBO_N(v)); // before the limit
        const double added = feedforward_added(&parts, v);
        const double u =
            from_force(TRIBO_PART(controller, step)(&loop.params.controller, &controller, e, to_force(added), &alone));
        feedforward_after(&parts, v, u, alone.limited);
        seen = loop_step(&loop, rough(k), y);
        TEST_ASSERT_TRUE(seen.u == u);
        TEST_ASSERT_TRUE(k % 800 != 799 || seen.e == 0.0);
        const feedforward_seen_t inner = feedforward_seen(&parts);
        TEST_ASSERT_TRUE(seen.e == from_force(e) && seen.feedforward == added);
        TEST_ASSERT_DOUBLE_WITHIN(4.0 * ROUNDING, inner.f, seen.compensator.friction.f);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, seen.u, seen.compensator.F + seen.compensator.friction.n);
        move(&plant, u);
    }
    TEST_ASSERT_TRUE(loop_limited_ticks(&loop) > 100u);
    TEST_ASSERT_EQUAL_UINT32(TICKS / 700 + TICKS / 800 - TICKS / 5600, loop_bad_inputs(&loop));
    TEST_ASSERT_TRUE(loop_learned_travel(&loop) > 0.1);
}

static void test_loop_with_a_feedforward_is_the_same_without_signals(void)
{
    loop_copy(&other, &loop);
    for (int k = 0; k < 3000; k++)
    {
        const double u = loop_step(&loop, rough(k), plant.y).u;
        TEST_ASSERT_TRUE(u == loop_step_unseen_by(&other, &loop, rough(k), plant.y));
        move(&plant, u);
    }
}

static void test_loop_with_a_feedforward_follows_closely(void)
{
    double worst = 0.0;
    for (int k = 0; k < RUNS(60000, 22000); k++)
    {
        const double F = plant.F;
        tick(k);
        worst = k > 20000 ? fmax(worst, fabs(triangle(k) - F)) : worst;
    }
    TEST_ASSERT_TRUE(worst < 0.004);
}

static void test_loop_without_memory_is_the_controller_alone(void)
{
    static controller_t controller;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, controller_init(&controller, &config.controller));
    loop_reset(&loop);
    for (int k = 0; k < 1000; k++)
    {
        const double y = k == 500 ? 3.0 : plant.y; // a bad input
        seen           = loop_step(&loop, triangle(k), y);
        TEST_ASSERT_TRUE(seen.u == controller_step(&controller, seen.e, 0.0).u);
        TEST_ASSERT_DOUBLE_WITHIN(4.0 * ROUNDING, k == 500 ? 0.0 : triangle(k) - y, seen.e);
        TEST_ASSERT_TRUE(seen.feedforward == 0.0 && seen.compensator.friction.f == 0.0);
        move(&plant, seen.u);
    }
    TEST_ASSERT_EQUAL_UINT32(1000 + 1, loop_bad_inputs(&loop)); // each tick, so that nobody runs it unknowingly
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_MEMORY, TRIBO(force_loop, start)(&loop.state, &loop.params, true));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, TRIBO(force_loop, start)(NULL, &loop.params, true));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, TRIBO(force_loop, start)(&loop.state, NULL, true));
}

static void test_loop_that_never_had_memory_hands_over_to_the_papers_method(void)
{
    make_methods();
    loop_reset(&loop);
    for (int k = 0; k < 500; k++)
    {
        seen = loop_step_by(&loop, &by[FEEDFORWARD], k == 250 ? 3.0 : triangle(k), plant.y);
        move(&plant, seen.u);
    }
    for (int bad = 0; bad < 2; bad++)
    {
        loop_copy(&other, &loop);
        loop_copy(&unchanged, &loop);
        const double r   = bad != 0 ? 3.0 : triangle(500);
        const double old = loop_step_by(&unchanged, &by[FEEDFORWARD], r, plant.y).u;
        TEST_ASSERT_DOUBLE_WITHIN(2.0 * CHANGE_TOLERANCE_N, old, loop_step_by(&other, &by[PAPER], r, plant.y).u);
    }
}

static void test_loop_that_has_just_forgotten_hands_over_like_one_without_memory(void)
{
    make_methods();
    loop_restart_with_memory(&loop);
    for (int k = 0; k < 500; k++)
    {
        move(&plant, loop_step_by(&loop, &by[FEEDFORWARD], triangle(k), plant.y).u);
    }
    loop_copy(&other, &loop);
    loop_copy(&unchanged, &loop);
    loop_forget(&other);
    loop_detach_memory(&unchanged);
    const double without = loop_step_by(&unchanged, &by[PAPER], triangle(500), plant.y).u;
    TEST_ASSERT_TRUE(loop_step_by(&other, &by[PAPER], triangle(500), plant.y).u == without);
    TEST_ASSERT_TRUE(loop_step_by(&loop, &by[PAPER], triangle(500), plant.y).u != without);
}

static void test_loop_restarts_with_or_without_what_was_learned(void)
{
    run(0, LEARN);
    const double learned = loop_learned_travel(&loop);
    TEST_ASSERT_TRUE(learned > RUNS(0.2, 0.04));
    loop_restart_with_memory(&loop);
    TEST_ASSERT_TRUE(loop_learned_travel(&loop) == learned);
    seen = loop_step(&loop, 0.0, 0.0);
    TEST_ASSERT_TRUE(seen.u == 0.0);
    TEST_ASSERT_EQUAL_UINT32(0, loop_bad_inputs(&loop));
    TEST_ASSERT_TRUE(loop_learned_travel(&loop) == learned);
    begin();
    TEST_ASSERT_TRUE(loop_learned_travel(&loop) == 0.0);
    TEST_ASSERT_TRUE(loop_step(&loop, 3.0, 0.0).u == 0.0); // a bad first reference
}

static void test_loop_init_passes_on_what_its_parts_refuse(void)
{
    config.gain = 3.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_GAIN, loop_init_feedforward(&loop, &config, &feedforward));
    config.gain            = 0.5f;
    feedforward.reversal_n = -1.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_REVERSAL_WIDTH, loop_init_feedforward(&loop, &config, &feedforward));
}

// --- change of method --------------------------------------------------------------------------------------------

typedef struct
{
    double in_tick, in_slide, in_stick; // u beside one that goes on; its steps in the ticks after
} bump_t;

/// Changes from one method to the other at tick k of a run under the first.
static void change_at(int k, method_t from, method_t to, bump_t *bump)
{
    plant_t changed_plant = plant;
    loop_copy(&unchanged, &loop);
    loop_copy(&other, &loop);
    plant_t      old_plant = plant;
    const double old_u     = loop_step_by(&unchanged, &by[from], triangle(k), plant.y).u;
    double       u         = loop_step_by(&other, &by[to], triangle(k), plant.y).u;
    bump->in_tick          = fmax(bump->in_tick, fabs(u - old_u));
    double last            = u;
    double old_last        = old_u;
    for (int i = 1; i <= 5; i++)
    {
        const bool sticks = changed_plant.F == plant.F;
        move(&changed_plant, last);
        move(&old_plant, old_last);
        const double old = loop_step_by(&unchanged, &by[from], triangle(k + i), old_plant.y).u;
        u                = loop_step_by(&other, &by[to], triangle(k + i), changed_plant.y).u;
        // A step of u that the loop would not have made: a reversal of f is not meant.
        const double step = fmin(fabs(u - last), fabs((u - last) - (old - old_last)));
        double      *most = sticks && i > 1 ? &bump->in_stick : &bump->in_slide;
        *most             = fmax(*most, step);
        last              = u;
        old_last          = old;
    }
}

static void check_change(method_t from, method_t to)
{
    bump_t bump = {0};
    make_methods();
    begin();
    for (int k = 0; k < TICKS; k++)
    {
        if (k > 3000 && k % RUNS(97, 970) == 0)
        {
            change_at(k, from, to, &bump);
        }
        seen = loop_step_by(&loop, &by[from], triangle(k), plant.y);
        move(&plant, seen.u);
    }
    static const char *const names[] = {"off", "paper", "feedforward"};
    printf(
        "%s to %s: u moves by %.1e N in the tick, by steps of up to %.2e N in a slide, %.2e N in mid-stick after it\n",
        names[from],
        names[to],
        bump.in_tick,
        bump.in_slide,
        bump.in_stick);
    // From the feed-forward, what was added a tick before goes on: without r's move of a tick, and breakaway's with it.
    TEST_ASSERT_TRUE(bump.in_tick <= (from == FEEDFORWARD ? 1.35e-4 : 2.0 * CHANGE_TOLERANCE_N));
    TEST_ASSERT_TRUE(bump.in_slide <= 1.5e-3);
    TEST_ASSERT_TRUE(bump.in_stick <= 8e-3);
}

static void test_loop_changes_between_off_the_papers_method_and_the_feedforward_without_a_bump(void)
{
    for (int from = OFF; from < METHODS; from++)
    {
        for (int to = OFF; to < METHODS; to++)
        {
            if (from != to)
            {
                check_change((method_t)from, (method_t)to);
            }
        }
    }
}

#define PERIOD RUNS(20000, 9000)

static void test_loop_changes_between_two_methods_that_feed_forward_without_a_bump(void)
{
    static loop_t another;
    make_methods();
    begin();
    loop_copy(&another, &by[FEEDFORWARD]);
    loop_other_method(&another);
    for (int k = 0; k < 5000; k++)
    {
        move(&plant, loop_step_by(&loop, &by[FEEDFORWARD], triangle(k), plant.y).u);
    }
    loop_copy(&other, &loop);
    loop_copy(&unchanged, &loop);
    const double old = loop_step_by(&unchanged, &by[FEEDFORWARD], triangle(5000), plant.y).u;
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, old, loop_step_by(&other, &another, triangle(5000), plant.y).u);
    loop_detach_memory(&loop); // a change within the method needs none
    (void)loop_step_by(&loop, &by[FEEDFORWARD], triangle(5000), plant.y);
    loop_copy(&another, &by[FEEDFORWARD]);
    loop_copy(&unchanged, &loop);
    const double alone = loop_step_by(&unchanged, &by[FEEDFORWARD], triangle(5001), plant.y).u;
    TEST_ASSERT_DOUBLE_WITHIN(2.0 * CHANGE_TOLERANCE_N,
                              alone,
                              loop_step_by(&loop, &another, triangle(5001), plant.y).u);
}

static void test_loop_compensates_soon_after_a_change_of_method(void)
{
    make_methods();
    begin();
    method_t now   = OFF;
    double   worst = 0.0;
    double   still = 0.0;
    for (int k = 0; k < RUNS(5, 3) * PERIOD; k++)
    {
        now            = (method_t)(k / PERIOD % 3);
        const double F = plant.F;
        seen           = loop_step_by(&loop, &by[now], triangle(k), plant.y);
        move(&plant, seen.u);
        if (now == FEEDFORWARD && k % PERIOD > 500)
        {
            worst = fmax(worst, fabs(triangle(k) - F));
        }
        else if (now == OFF)
        {
            still = fmax(still, fabs(triangle(k) - F));
        }
    }
    printf("worst error %.1e N with, %.1e N without\n", worst, still);
    TEST_ASSERT_TRUE(worst < 0.3 * still);
    TEST_ASSERT_TRUE(loop_learned_travel(&loop) > RUNS(0.1, 0.01));
}

static void test_loop_taken_up_again_knows_what_it_had_learned(void)
{
    make_methods();
    begin();
    run(0, LEARN);
    const double learned = loop_learned_travel(&loop);
    for (int k = LEARN; k < LEARN + RUNS(5000, 1000); k++)
    {
        seen = loop_step_by(&loop, &by[PAPER], triangle(k), plant.y);
        move(&plant, seen.u);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, learned, loop_learned_travel(&loop)); // a last tick may have learned
    (void)loop_step_by(&loop, &by[FEEDFORWARD], triangle(LEARN + 5000), plant.y);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, learned, loop_learned_travel(&loop));
}

/// Returns the lead of a jump, which is not handed over.
static double lead_of(const loop_t *x)
{
    return fabs(inner_n(x->memory.state.lead, FULL_SCALE_N));
}

static void test_loop_changes_the_params_of_its_feedforward_without_a_bump(void)
{
    double worst = 0.0;
    make_methods();
    begin();
    feedforward.jump_lead                      = 0.5f;
    feedforward.jump_time_s                    = 0.04f;
    feedforward.trust                          = 0.9f;
    config.compensator.friction.positive.slope = 0.2f;
    config.controller.u_max_n                  = 1.5f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&by[OFF], &config, &feedforward)); // which it is not
    for (int k = 0; k < TICKS; k++)
    {
        if (k > 3000 && (k % RUNS(97, 970) == 0 || k % 10000 < RUNS(60, 6)))
        {
            loop_copy(&unchanged, &loop);
            loop_copy(&other, &loop);
            const double old_u = loop_step_by(&unchanged, &by[FEEDFORWARD], triangle(k), plant.y).u;
            const double u     = loop_step_by(&other, &by[OFF], triangle(k), plant.y).u;
            const double leads = lead_of(&unchanged) + lead_of(&other);
            const double next  = loop_step_by(&other, &by[OFF], triangle(k + 1), plant.y).u;
            const double was   = loop_step_by(&unchanged, &by[FEEDFORWARD], triangle(k + 1), plant.y).u;
            TEST_ASSERT_DOUBLE_WITHIN(0.017 + leads, old_u, u); // a tick of a jump, which is longer now
            worst = k % 10000 > 100 ? fmax(worst, fmax(fabs(u - old_u), fabs(next - was))) : worst;
        }
        seen = loop_step_by(&loop, &by[FEEDFORWARD], triangle(k), plant.y);
        move(&plant, seen.u);
    }
    printf("u moves by up to %.1e N\n", worst);
    TEST_ASSERT_TRUE(worst <= 1.5e-3);
}

static void test_loop_with_a_feedforward_keeps_new_limits_at_once(void)
{
    make_methods();
    config.controller.u_max_n = 0.1f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&by[OFF], &config, &feedforward));
    for (int from = PAPER; from <= FEEDFORWARD; from++)
    {
        begin();
        for (int k = 0; k < 3000; k++)
        {
            seen = loop_step_by(&loop, &by[from], triangle(k), plant.y);
            move(&plant, seen.u);
        }
        TEST_ASSERT_TRUE(seen.u > 0.2);
        seen = loop_step_by(&loop, &by[OFF], triangle(3000), plant.y);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.1, seen.u);
        TEST_ASSERT_TRUE(seen.limited);
    }
}

#define BAD_AT RUNS(8000, 3000)

static void test_loop_changes_method_beside_a_bad_input(void)
{
    make_methods();
    for (int bad_r = 0; bad_r < 2; bad_r++)
    {
        for (int to = PAPER; to <= FEEDFORWARD; to++)
        {
            const method_t from = to == PAPER ? FEEDFORWARD : PAPER;
            begin();
            for (int k = 0; k < BAD_AT; k++)
            {
                seen = loop_step_by(&loop, &by[from], triangle(k), plant.y);
                move(&plant, seen.u);
            }
            double last = seen.u;
            for (int k = BAD_AT; k < BAD_AT + 10; k++)
            {
                const bool bad = k < BAD_AT + 3;
                seen           = loop_step_by(&loop,
                                    &by[to],
                                    bad && bad_r == 1 ? 3.0 : triangle(k),
                                    bad && bad_r == 0 ? -3.0 : plant.y);
                TEST_ASSERT_DOUBLE_WITHIN(1.5e-3, last, seen.u);
                last = seen.u;
                move(&plant, seen.u);
            }
            TEST_ASSERT_EQUAL_UINT32(3, loop_bad_inputs(&loop));
        }
    }
}

// --- what must never happen --------------------------------------------------------------------------------------

static void flip(void *object, uint32_t bit)
{
    unsigned char *const bytes = object;
    bytes[bit / 8u] ^= (unsigned char)(1u << bit % 8u);
}

/// Any bit of what the loop and its feed-forward know: u is within its limits, and in the end F is where r is.
static void test_loop_with_a_flipped_bit_in_its_memory_keeps_its_limits_and_recovers(void)
{
    static loop_t  before;
    const uint32_t step       = RUNS(1, 211);
    config.controller.u_max_n = 0.9f;
    config.controller.u_min_n = -0.2f;
    begin();
    run(0, 12000);
    const plant_t plant_before = plant;
    loop_copy(&before, &loop);
    double worst = 0.0;
    for (uint32_t bit = 0; bit < 8u * sizeof loop.memory; bit += step)
    {
        loop_copy(&loop, &before);
        plant = plant_before;
        flip(&loop.memory, bit);
        for (int k = 12000; k < 12300; k++)
        {
            tick(k);
            TEST_ASSERT_TRUE(seen.u >= -0.2 - ROUNDING && seen.u <= 0.9 + ROUNDING);
        }
        if (RUNS(bit % 29 == 0, bit == 0))
        {
            run(12300, 52000);
            worst = fmax(worst, fabs(plant.F - triangle(52000)));
        }
    }
    printf("an error of up to %.1e N is left 40 s later\n", worst);
    TEST_ASSERT_TRUE(worst < 5e-3);
}

static void test_loop_with_a_flipped_bit_in_its_state_keeps_its_limits(void)
{
    static loop_t before;
    begin();
    run(0, 3000);
    loop_copy(&before, &loop);
    for (uint32_t bit = 0; bit < 8u * sizeof loop.state; bit++)
    {
        loop_copy(&loop, &before);
        flip(&loop.state, bit);
        for (int k = 3000; k < 3020; k++)
        {
            tick(k);
            TEST_ASSERT_TRUE(seen.u >= -2.0 && seen.u <= 2.0);
        }
    }
}

/// The excess goes into the caller's integrator, where a NaN would stay.
static void test_own_controller_with_a_flipped_bit_in_the_memory_gets_a_command_and_an_excess_that_are_numbers(void)
{
    static loop_t before;
    begin();
    run(0, 3000);
    loop_copy(&before, &loop);
    const double y = plant.y;
    for (uint32_t bit = 0; bit < 8u * sizeof loop.memory; bit++)
    {
        loop_copy(&loop, &before);
        flip(&loop.memory, bit);
        for (int k = 3000; k < 3005; k++)
        {
            tribo_force_t       excess;
            const tribo_force_t r = to_force(triangle(k));
            const tribo_force_t v = TRIBO(force_loop, error)(&loop.params, &loop.state, r, to_force(y));
            const double        u = from_force(TRIBO(force_loop, command)(&loop.params, &loop.state, v, &excess));
            TEST_ASSERT_TRUE(u >= -2.0 && u <= 2.0);
            TEST_ASSERT_TRUE(isfinite(from_force(excess)));
        }
    }
}

/// A term that is no number leaves u to the caller's controller, and is counted.
static void test_own_controller_goes_on_alone_while_the_term_is_no_number(void)
{
    begin();
    run(0, 3000);
    const uint32_t bad    = loop_bad_inputs(&loop);
    tribo_force_t  excess = 1;
    (void)TRIBO(force_loop, error)(&loop.params, &loop.state, to_force(0.5), to_force(0.5));
    loop.memory.state.lead = TRIBO_EITHER(NAN, 0);
    const double u         = from_force(TRIBO(force_loop, command)(&loop.params, &loop.state, to_force(0.25), &excess));
    TEST_ASSERT_EQUAL_UINT32(bad + TRIBO_EITHER(1u, 0u), loop_bad_inputs(&loop));
    TEST_ASSERT_TRUE(TRIBO_EITHER(u == 0.25, u > 0.25)); // in Q31 each term is a number
    TEST_ASSERT_TRUE(excess == 0);
}

/// A flipped bit of a flag leaves a byte that is neither 0 nor 1: it counts as set.
static void test_loop_with_a_flipped_bit_in_a_flag_of_its_memory_changes_params(void)
{
    for (uint32_t bit = 0; bit < 8u; bit++)
    {
        begin();
        run(0, 3000);
        flip(&loop.memory.state.tick.has_e, bit);
        flip(&loop.memory.state.tick.has_y, bit);
        TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&other, &config));
        const double u = loop_step_by(&loop, &other, triangle(3000), plant.y).u;
        TEST_ASSERT_TRUE(bit == 0u || fabs(u - seen.u) < 1e-2);
    }
}

#include "runners/test_methods.inc" // main
