// The loop whose compensator believes in LuGre friction: beside Eq. (12) by explicit steps in double, and what must hold of every
// method. The plant is a play: an arm without mass that sticks within its breakaway.

#define FULL_SCALE_N 4.0 // of Q31, so that an input beyond input_max shows as such
#include ARITH_HEADER
#include "lugre_paper.h"
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define H  1e-3
#define L0 0.007 // the paper's breakaway
#define L1 0.3

static tribo_force_loop_f32_config_t config;
static tribo_lugre_f32_config_t      lugre;
static loop_t                        loop;
static loop_t                        other;
static loop_t                        unchanged;
static loop_seen_t                   seen;

typedef struct
{
    double actuator, F, y;
} plant_t;

static plant_t plant;
static double  breakaway = 1.0; // of the plant, as a factor

static void move(plant_t *p, double u)
{
    p->actuator += 0.18 * (u - p->actuator);
    const double L = breakaway * (L0 + L1 * fabs(p->F));
    p->F           = fmax(p->actuator - L, fmin(p->actuator + L, p->F));
    p->y += 0.0535 * (p->F - p->y);
}

/// 0.4 to 0.6 N, period 4 s.
static double triangle(int k)
{
    const double phase = fmod(k * H, 4.0);
    return 0.4 + 0.1 * (phase < 2.0 ? phase : 4.0 - phase);
}

static void tick(int k)
{
    seen = loop_step(&loop, triangle(k), plant.y);
    move(&plant, seen.u);
}

static void begin(void)
{
    plant = (plant_t){0};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_lugre(&loop, &config, &lugre));
}

void setUp(void)
{
    config = tribo_force_loop_f32_paper();
    lugre  = lugre_paper();
    begin();
}

void tearDown(void)
{
}

// --- Eq. (12) ----------------------------------------------------------------------------------------------------

/// Loop, arm and bristles in double: the sections as they are written, Eqs. (2) and (12) by explicit steps.
typedef struct
{
    double position, speed, z;
    double s1[TRIBO_BIQUAD_SECTIONS_MAX], s2[TRIBO_BIQUAD_SECTIONS_MAX];
    double f;
} reference_t;

static double reference_controller(reference_t *x, double e)
{
    for (uint32_t i = 0; i < config.controller.section_count; i++)
    {
        const tribo_biquad_f32_section_t *s = &config.controller.sections[i];
        const double                      v = e - (double)s->a1 * x->s1[i] - (double)s->a2 * x->s2[i];
        e                                   = (double)s->b0 * v + (double)s->b1 * x->s1[i] + (double)s->b2 * x->s2[i];
        x->s2[i] += x->s1[i];
        x->s1[i] += v;
    }
    return e;
}

static double reference_friction(const reference_t *x, double *dz)
{
    const double L = L0 + L1 * fabs((double)config.compensator.arm.stiffness * x->position);
    *dz            = x->speed - (double)lugre.stiffness * fabs(x->speed) * x->z / L;
    const double f = (double)lugre.stiffness * x->z + (double)lugre.damping * *dz + (double)lugre.viscous * x->speed;
    return fmin(L, fmax(-L, f));
}

static double reference_step(reference_t *x, double r, double y, int steps)
{
    const tribo_arm_f32_config_t *arm = &config.compensator.arm;
    const double                  u   = reference_controller(x, r - y) + (double)config.gain * x->f;
    const double                  h   = H / steps;
    double                        dz;
    for (int i = 0; i < steps; i++)
    {
        const double f     = reference_friction(x, &dz);
        const double force = u - (double)arm->stiffness * x->position - (double)arm->damping * x->speed - f;
        x->position += h * x->speed;
        x->z += h * dz;
        x->speed += h * force / (double)arm->inertia;
    }
    x->f = reference_friction(x, &dz);
    return u;
}

/// From rest, as the bristles of an explicit method do not survive a step of r.
static double gentle(int k)
{
    return k < 2000 ? 0.2e-3 * k : triangle(k - 2000);
}

/// u against the reference's, for the same r and y. Returns the rms difference of f^.
static double compare(int ticks, int steps, double *largest_u, double *largest_F)
{
    reference_t reference = {0};
    double      square    = 0.0;
    begin();
    for (int k = 0; k < ticks; k++)
    {
        const double y = plant.y;
        const double F = (double)config.compensator.arm.stiffness * reference.position;
        const double u = reference_step(&reference, gentle(k), y, steps);
        seen           = loop_step(&loop, gentle(k), y);
        move(&plant, seen.u);
        const double d = seen.compensator.friction.f - reference.f;
        square += d * d;
        *largest_u = fmax(*largest_u, fabs(seen.u - u));
        *largest_F = fmax(*largest_F, fabs(seen.compensator.F - F));
    }
    return sqrt(square / ticks);
}

/// With the paper's numbers, of which the explicit method needs steps below 2 I/(2 s1) = 0.38 us at a reversal, where the bristles
/// are stretched the other way.
static void test_loop_follows_equation_12(void)
{
    double       largest_u = 0.0;
    double       largest_F = 0.0;
    const double rms       = compare(RUNS(9000, 150), 4000, &largest_u, &largest_F);
    printf("f^ within %.1e N rms of Eq. (12), u within %.1e N, F^ %.1e N\n", rms, largest_u, largest_F);
    TEST_ASSERT_TRUE(rms < 1e-4); // of L = 0.18 N
    TEST_ASSERT_TRUE(largest_u < 5e-4);
    TEST_ASSERT_TRUE(largest_F < 2e-4);
}

static void test_loop_follows_equation_12_with_soft_bristles(void)
{
    lugre                  = (tribo_lugre_f32_config_t){.stiffness = 3000.0f, .damping = 1.0f, .viscous = 0.1f};
    double       largest_u = 0.0;
    double       largest_F = 0.0;
    const double rms       = compare(RUNS(9000, 300), 400, &largest_u, &largest_F);
    printf("f^ within %.1e N rms of Eq. (12), u within %.1e N, F^ %.1e N\n", rms, largest_u, largest_F);
    TEST_ASSERT_TRUE(rms < 1e-3);
    TEST_ASSERT_TRUE(largest_F < 1e-3);
}

// --- the tick ----------------------------------------------------------------------------------------------------

/// With everything in it: ramps, steps, stands, limits and bad inputs.
static double rough(int k)
{
    const double jump = k % 6000 > 5600 ? 0.7 : 0.0;
    const double sign = k % 9000 > 6500 ? triangle(6500) : triangle(k);
    return k % 700 == 699 ? 2.5 : sign - jump;
}

static void test_loop_is_controller_and_compensator_joined(void)
{
    static parts_t parts;
    config.controller.u_max_n = 0.72f;
    begin();
    parts_reset_lugre(&parts);
    double feedforward = 0.0;
    for (int k = 0; k < 12000; k++)
    {
        const bool   bad       = k % 700 == 699 || k % 800 == 799;
        const double y         = k % 800 == 799 ? 3.0 : plant.y;
        seen                   = loop_step(&loop, rough(k), y);
        const loop_seen_t each = parts_step(&parts, &loop, seen.e, seen.feedforward);
        TEST_ASSERT_TRUE(bad == (seen.e == 0.0));
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, feedforward, seen.feedforward);
        TEST_ASSERT_TRUE(seen.u == each.u && seen.limited == each.limited);
        TEST_ASSERT_TRUE(seen.compensator.F == each.compensator.F);
        TEST_ASSERT_TRUE(seen.compensator.friction.n == each.compensator.friction.n);
        TEST_ASSERT_TRUE(seen.compensator.friction.L == each.compensator.friction.L);
        TEST_ASSERT_TRUE(seen.compensator.friction.f == each.compensator.friction.f);
        TEST_ASSERT_TRUE(seen.compensator.friction.v == 0.0 && !seen.compensator.friction.q);
        feedforward = (double)config.gain * seen.compensator.friction.f;
        move(&plant, seen.u);
    }
    TEST_ASSERT_TRUE(loop_limited_ticks(&loop) > 100u);
    TEST_ASSERT_EQUAL_UINT32(12000 / 700 + 12000 / 800 - 12000 / 5600, loop_bad_inputs(&loop));
}

static void test_loop_is_the_same_without_signals(void)
{
    loop_copy(&other, &loop);
    for (int k = 0; k < 3000; k++)
    {
        const double u = loop_step(&loop, rough(k), plant.y).u;
        TEST_ASSERT_TRUE(u == loop_step_unseen_by(&other, &loop, rough(k), plant.y));
        move(&plant, u);
    }
}

static void test_loop_compensates(void)
{
    double with = 0.0;
    double none = 0.0;
    for (int run = 0; run < 2; run++)
    {
        config.gain = run == 0 ? 0.85f : 0.0f;
        begin();
        for (int k = 0; k < 12000; k++)
        {
            const double error = triangle(k) - plant.F;
            *(run == 0 ? &with : &none) += k >= 4000 ? error * error : 0.0;
            tick(k);
        }
    }
    printf("rms error %.2e N with, %.2e N without\n", sqrt(with / 8000.0), sqrt(none / 8000.0));
    TEST_ASSERT_TRUE(sqrt(with) < 0.4 * sqrt(none));
}

/// With a reset between, a loop does not know what it was before, whatever its method was.
static void test_loop_after_a_reset_is_as_new(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_lugre(&other, &config, &lugre));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&unchanged, &config, NULL)); // the paper's
    for (int method = 0; method < 2; method++)
    {
        const loop_t *by = method == 0 ? &other : &unchanged;
        for (int k = 0; k < 2500; k++)
        {
            (void)loop_step_by(&loop, by, rough(k), 0.3);
        }
        loop_reset(&loop);
        loop_reset(&other);
        for (int k = 0; k < 2500; k++)
        {
            const double u = loop_step_by(&loop, &other, triangle(k), 0.2).u;
            TEST_ASSERT_TRUE(u == loop_step(&other, triangle(k), 0.2).u);
        }
        loop_reset(&loop);
        loop_reset(&unchanged);
        for (int k = 0; k < 2500; k++)
        {
            const double u = loop_step_by(&loop, &unchanged, triangle(k), 0.2).u;
            TEST_ASSERT_TRUE(u == loop_step(&unchanged, triangle(k), 0.2).u);
        }
        loop_reset(&unchanged);
        loop_reset(&loop);
    }
}

static void test_loop_takes_breakaway_and_gravity_of_the_friction(void)
{
    static const tribo_breakaway_point_f32_t points[] = {{0.0f, 0.05f, 0.08f}, {1.0f, 0.15f, 0.2f}};
    config.compensator.friction.table                 = points;
    config.compensator.friction.table_length          = 2;
    config.compensator.friction.gravity_n             = 0.03f;
    begin();
    for (int k = 0; k < 4000; k++)
    {
        tick(k);
        const double load = fabs(seen.compensator.F);
        const double L    = seen.compensator.friction.f >= 0.0 ? 0.05 + 0.1 * load : 0.08 + 0.12 * load;
        TEST_ASSERT_DOUBLE_WITHIN(2e-7, L, seen.compensator.friction.L);
        TEST_ASSERT_DOUBLE_WITHIN(2e-7, seen.u - seen.compensator.F + 0.03, seen.compensator.friction.n);
    }
}

static tribo_status_t init(tribo_force_loop_f32_config_t *of_loop, tribo_lugre_f32_config_t *of_lugre)
{
    return tribo_init_lugre(&loop.params, loop.table, &loop.lugre, of_loop, of_lugre, (float)FULL_SCALE_N);
}

static void check_refused(tribo_status_t status)
{
    memset(&loop, 0x5a, sizeof loop);
    memcpy(&other, &loop, sizeof loop);
    TEST_ASSERT_EQUAL_INT(status, init(&config, &lugre));
    TEST_ASSERT_EQUAL_MEMORY(&other, &loop, sizeof loop); // nothing is written
    setUp();
}

static void test_init_names_the_field_that_is_wrong(void)
{
    config.gain = 3.0f;
    check_refused(TRIBO_ERR_GAIN);
    config.gain = NAN;
    check_refused(TRIBO_ERR_GAIN);
    lugre.stiffness = 0.0f;
    check_refused(TRIBO_ERR_BRISTLE_STIFFNESS);
    lugre.damping = -1.0f;
    check_refused(TRIBO_ERR_BRISTLE_DAMPING);
    lugre.viscous = NAN;
    check_refused(TRIBO_ERR_BRISTLE_VISCOUS);
    const float full_scale_n = (float)FULL_SCALE_N;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, init(NULL, &lugre));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL, init(&config, NULL));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL,
                          tribo_init_lugre(NULL, loop.table, &loop.lugre, &config, &lugre, full_scale_n));
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_NULL,
                          tribo_init_lugre(&loop.params, loop.table, NULL, &config, &lugre, full_scale_n));
}

static void test_init_makes_the_loop_of_the_config_with_another_friction_model(void)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init(&other, &config));
    TEST_ASSERT_NULL(other.params.compensator.model);
    TEST_ASSERT_EQUAL_PTR(&loop.lugre.model, loop.params.compensator.model);
    other.params.compensator.model = loop.params.compensator.model;
    TEST_ASSERT_EQUAL_MEMORY(&other.params, &loop.params, sizeof other.params);
}

// --- changes of params -------------------------------------------------------------------------------------------

typedef enum
{
    OFF,
    PAPER,
    FEEDFORWARD,
    LUGRE,
    OTHER_LUGRE, // other bristles, gain, breakaway
    METHODS
} method_t;

static loop_t by[METHODS]; // params

static void make_methods(void)
{
    const tribo_feedforward_f32_config_t feedforward = tribo_feedforward_f32_default();
    tribo_force_loop_f32_config_t        one         = config;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&by[PAPER], &one, NULL));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&by[FEEDFORWARD], &one, &feedforward));
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_lugre(&by[LUGRE], &one, &lugre));
    one.gain = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&by[OFF], &one, NULL));
    one.gain                                = 0.6f;
    one.compensator.friction.positive.slope = 0.25f;
    const tribo_lugre_f32_config_t soft     = {.stiffness = 3000.0f, .damping = 10.0f, .viscous = 0.2f};
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_lugre(&by[OTHER_LUGRE], &one, &soft));
}

static double lead_of(const loop_t *x)
{
    return fabs(TRIBO_LEARNED_N(double, x->memory.state.lead, FULL_SCALE_N));
}

/// How far u is from that of a loop that goes on, in the tick of the change and in the next, beyond what that loop's own u moves
/// by: the feed-forward hands over what it added in the last tick, but for the lead of a jump.
static void change_at(int k, method_t from, method_t to, double most[2])
{
    loop_copy(&unchanged, &loop);
    loop_copy(&other, &loop);
    plant_t           old_plant = plant;
    const loop_seen_t old       = loop_step_by(&unchanged, &by[from], triangle(k), plant.y);
    const loop_seen_t now       = loop_step_by(&other, &by[to], triangle(k), plant.y);
    const double      lead      = from == FEEDFORWARD ? lead_of(&unchanged) : 0.0;
    most[0] = fmax(most[0], fabs(now.u - old.u) - (from == FEEDFORWARD ? fabs(old.u - seen.u) + lead : 0.0));
    move(&old_plant, old.u);
    static loop_t still;
    if (to >= LUGRE && from < LUGRE) // the arm is where the sensor says, and stands there if friction can hold it
    {
        const friction_seen_t *f = &now.compensator.friction;
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, plant.y, now.compensator.F);
        if (fabs(f->n) < 0.99 * f->L)
        {
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, f->n, f->f);
            loop_copy(&still, &other);
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, plant.y, loop_step_by(&still, &by[to], triangle(k), plant.y).compensator.F);
        }
    }
    const double next = loop_step_by(&other, &by[to], triangle(k + 1), old_plant.y).u;
    const double was  = loop_step_by(&unchanged, &by[from], triangle(k + 1), old_plant.y).u;
    most[1] = fmax(most[1], fabs(next - was) - (from < LUGRE || to < LUGRE ? 2.0 * fabs(was - old.u) + lead : 0.0));
}

static void test_loop_changes_to_and_from_lugre_without_a_bump(void)
{
    make_methods();
    for (int from = OFF; from < METHODS; from++)
    {
        for (int to = OFF; to < METHODS; to++)
        {
            double most[2] = {0.0, 0.0};
            begin();
            if (from == to || (from < LUGRE && to < LUGRE))
            {
                continue;
            }
            for (int k = 0; k < RUNS(9000, 3000); k++)
            {
                if (k > 1000 && k % 61 == 0)
                {
                    change_at(k, (method_t)from, (method_t)to, most);
                }
                seen = loop_step_by(&loop, &by[from], triangle(k), plant.y);
                move(&plant, seen.u);
            }
            printf("%d to %d: u moves by %.1e N in the tick, %.1e N in the next\n", from, to, most[0], most[1]);
            TEST_ASSERT_TRUE(most[0] <= (from == FEEDFORWARD ? 5e-4 : 2.0 * CHANGE_TOLERANCE_N));
            TEST_ASSERT_TRUE(most[1] <= 1e-3);
        }
    }
}

static void test_loop_changes_between_two_friction_models_without_a_bump(void)
{
    static loop_t another;
    begin();
    for (int k = 0; k < 3000; k++)
    {
        tick(k);
    }
    loop_copy(&another, &loop);
    loop_other_model(&another);
    loop_copy(&other, &loop);
    loop_copy(&unchanged, &loop);
    const double      old = loop_step(&unchanged, triangle(3000), plant.y).u;
    const loop_seen_t now = loop_step_by(&other, &another, triangle(3000), plant.y);
    TEST_ASSERT_DOUBLE_WITHIN(2.0 * CHANGE_TOLERANCE_N, old, now.u);
    TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, plant.y, now.compensator.F); // the model starts anew
}

static void test_loop_with_lugre_keeps_new_limits_at_once(void)
{
    make_methods();
    config.controller.u_max_n = 0.1f;
    static loop_t tight;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_lugre(&tight, &config, &lugre));
    for (int from = PAPER; from <= LUGRE; from++)
    {
        begin();
        for (int k = 0; k < 1500; k++)
        {
            seen = loop_step_by(&loop, &by[from], triangle(k), plant.y);
            move(&plant, seen.u);
        }
        TEST_ASSERT_TRUE(seen.u > 0.2);
        seen = loop_step_by(&loop, &tight, triangle(1500), plant.y);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, 0.1, seen.u);
        TEST_ASSERT_TRUE(seen.limited);
    }
}

static void test_loop_takes_lugre_up_beside_a_bad_input(void)
{
    make_methods();
    for (int bad_r = 0; bad_r < 2; bad_r++)
    {
        for (int to = OFF; to <= LUGRE; to++)
        {
            const method_t from = to == LUGRE ? PAPER : LUGRE;
            begin();
            for (int k = 0; k < 1800; k++)
            {
                seen = loop_step_by(&loop, &by[from], triangle(k), plant.y);
                move(&plant, seen.u);
            }
            loop_copy(&unchanged, &loop);
            for (int k = 1800; k < 1803; k++)
            {
                const double r = bad_r == 1 ? 3.0 : triangle(k);
                const double y = bad_r == 0 ? -3.0 : plant.y;
                seen           = loop_step_by(&loop, &by[to], r, y);
                TEST_ASSERT_TRUE(seen.e == 0.0 || to == FEEDFORWARD);
                const double old = loop_step_by(&unchanged, &by[from], r, y).u;
                TEST_ASSERT_DOUBLE_WITHIN(k == 1800 ? 5e-4 : 8e-3, old, seen.u);
                move(&plant, seen.u);
            }
            TEST_ASSERT_EQUAL_UINT32(3, loop_bad_inputs(&loop));
        }
    }
}

// --- what must never happen --------------------------------------------------------------------------------------

static void test_loop_is_a_mirror_image_of_itself(void)
{
    loop_copy(&other, &loop);
    for (int k = 0; k < 6000; k++)
    {
        const double r           = 1.2 * (triangle(k) - 0.5) + 0.3 * sin(0.002 * k);
        seen                     = loop_step(&loop, r, plant.y);
        const loop_seen_t mirror = loop_step(&other, -r, -plant.y);
        TEST_ASSERT_DOUBLE_WITHIN(4.0 * ROUNDING, -seen.u, mirror.u);
        TEST_ASSERT_DOUBLE_WITHIN(4.0 * ROUNDING, -seen.compensator.friction.f, mirror.compensator.friction.f);
        move(&plant, seen.u);
    }
}

/// r and y of any size, NaN included: u within its limits, f^ within breakaway.
static void test_any_input_leaves_u_within_its_limits_and_friction_within_breakaway(void)
{
    random_t seed             = {11};
    config.controller.u_max_n = 0.9f;
    config.controller.u_min_n = -0.2f;
    begin();
    for (int k = 0; k < RUNS(60000, 6000); k++)
    {
        const double size = pow(10.0, random_between(&seed, -6.0, k % 7 == 0 ? 8.0 : 0.5));
        const double r    = k % 11 == 0 ? (double)NAN : random_between(&seed, -size, size);
        const double y    = k % 13 == 0 ? (double)INFINITY : random_between(&seed, -1.0, 1.0);
        seen              = loop_step(&loop, r, y);
        TEST_ASSERT_TRUE(seen.u >= -0.2 - ROUNDING && seen.u <= 0.9 + ROUNDING);
        TEST_ASSERT_TRUE(fabs(seen.compensator.friction.f) <= seen.compensator.friction.L);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, L0 + L1 * fabs(seen.compensator.F), seen.compensator.friction.L);
    }
}

/// The guard looks at what LuGre adds, not at the memory of a feed-forward that stands beside.
static void test_guard_ends_the_hunting_of_a_loop_with_lugre(void)
{
    guard_t guard;
    config.gain = 1.0f;
    breakaway   = 0.3;
    begin();
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, guard_init(&guard, H));
    for (int k = 0; k < 8000; k++)
    {
        move(&plant, loop_step_guarded(&loop, &guard, triangle(k), plant.y));
    }
    breakaway = 1.0;
    TEST_ASSERT_TRUE(guard_share(&guard) == 0.0);
}

static void test_loop_with_a_flipped_bit_in_its_state_keeps_its_limits_and_recovers(void)
{
    static loop_t before;
    double        worst = 0.0;
    begin();
    for (int k = 0; k < 3000; k++)
    {
        tick(k);
    }
    const plant_t plant_before = plant;
    loop_copy(&before, &loop);
    for (uint32_t bit = 0; bit < 8u * sizeof loop.state; bit++)
    {
        loop_copy(&loop, &before);
        plant                      = plant_before;
        unsigned char *const bytes = (unsigned char *)&loop.state;
        bytes[bit / 8u] ^= (unsigned char)(1u << bit % 8u);
        for (int k = 3000; k < 3020 || (bit % RUNS(13, 97) == 0 && k < 11000); k++)
        {
            tick(k);
            TEST_ASSERT_TRUE(seen.u >= -2.0 && seen.u <= 2.0);
        }
        if (bit % RUNS(13, 97) == 0)
        {
            worst = fmax(worst, fabs(plant.F - triangle(10999)));
        }
    }
    printf("an error of up to %.1e N is left 8 s later\n", worst);
    TEST_ASSERT_TRUE(worst < 0.02);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_loop_follows_equation_12);
    RUN_TEST(test_loop_follows_equation_12_with_soft_bristles);
    RUN_TEST(test_loop_is_controller_and_compensator_joined);
    RUN_TEST(test_loop_is_the_same_without_signals);
    RUN_TEST(test_loop_compensates);
    RUN_TEST(test_loop_after_a_reset_is_as_new);
    RUN_TEST(test_loop_takes_breakaway_and_gravity_of_the_friction);
    RUN_TEST(test_init_names_the_field_that_is_wrong);
    RUN_TEST(test_init_makes_the_loop_of_the_config_with_another_friction_model);
    RUN_TEST(test_loop_changes_to_and_from_lugre_without_a_bump);
    RUN_TEST(test_loop_changes_between_two_friction_models_without_a_bump);
    RUN_TEST(test_loop_with_lugre_keeps_new_limits_at_once);
    RUN_TEST(test_loop_takes_lugre_up_beside_a_bad_input);
    RUN_TEST(test_loop_is_a_mirror_image_of_itself);
    RUN_TEST(test_any_input_leaves_u_within_its_limits_and_friction_within_breakaway);
    RUN_TEST(test_guard_ends_the_hunting_of_a_loop_with_lugre);
    RUN_TEST(test_loop_with_a_flipped_bit_in_its_state_keeps_its_limits_and_recovers);
    return UNITY_END();
}
