// The stages of the feed-forward's learning, each alone and from any numbers within their bounds, against the equations of step 11 of
// docs/feedforward.md in double precision. What a closed loop seldom reaches counts as much as the rest here.

#define FULL_SCALE_N 2.0
#include "feedforward.h"
#if TRIBO_IS_Q31
#include "feedforward/learning_q31.h"
#define DOUBT_PER_TRAVEL x.params.doubt_per_unit
#else
#include "feedforward/learning_f32.h"
#define DOUBT_PER_TRAVEL x.params.doubt_per_n
#endif
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

#define SEED   0x1ea21u
#define H      1e-3
#define TRIALS RUNS(20000, 500)
#define STOPS  4

// Of the paper's rig, but that the directions differ and gravity acts.
#define UP      0.007
#define DOWN    0.021
#define SLOPE   0.3
#define FALL    0.2
#define GRAVITY 0.04
#define B       ((UP + DOWN) / 2.0 + (SLOPE + FALL) / 2.0 * 0.5)
#define D_T     (B / 7.85)

/// The numbers of a sample and of what is learned, by the page's names.
typedef struct
{
    double V[1 + STOPS], c[3], M[4][4], P[STOPS], doubt, W[1 + STOPS];
    double X[1 + STOPS]; // over their widths
    double yf, z, jump, delta;
    double k[4], kappa[STOPS], epsilon, l, rho, q[4 + STOPS], gain;
    double presliding; // max(0, 1 - (A_n/A)^2)
    double noise;      // n_y
    double lambda, rs, phi[STOPS], sigma, b, f, level;
} page_t;

static random_t                       r;
static tribo_feedforward_f32_config_t config;
static tribo_compensator_f32_config_t model;
static feedforward_t                  x;
static page_t                         p;

void setUp(void)
{
    r.state                          = SEED;
    config                           = tribo_feedforward_f32_default();
    model                            = tribo_force_loop_f32_paper().compensator;
    model.friction.positive.offset_n = (float)UP;
    model.friction.negative.offset_n = (float)DOWN;
    model.friction.positive.slope    = (float)SLOPE;
    model.friction.negative.slope    = (float)FALL;
    model.friction.gravity_n         = (float)GRAVITY;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, feedforward_init_scaled(&x, &config, &model, 2.0, H, 1.0));
}

void tearDown(void)
{
}

static double clamp(double a, double low, double high)
{
    return fmin(fmax(a, low), high);
}

/// Within +-most, and now and then at an end of it.
static double any(double most)
{
    const double kind = random_between(&r, 0.0, 1.0);
    return kind < 0.1 ? -most : kind < 0.2 ? most : random_between(&r, -most, most);
}

static double L_of(double F)
{
    return (UP + DOWN) / 2.0 + (SLOPE + FALL) / 2.0 * fabs(F);
}

static double D_of(double F)
{
    return (UP - DOWN) / 2.0 + (SLOPE - FALL) / 2.0 * fabs(F) - GRAVITY;
}

static double load_of(double F)
{
    return p.c[0] + p.c[1] * fabs(F) + p.c[2] * F;
}

static const int row[4][4] = {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}};

static void give(void)
{
    TRIBO(feedforward, state_t) *const          state = &x.memory.state;
    TRIBO(feedforward_weights, t) *const        known = &state->learned;
    TRIBO(feedforward_learning, state_t) *const learn = &state->learning;
    for (int j = 0; j <= STOPS; j++)
    {
        known->weight[j] = to(p.V[j], 29);
        known->use[j]    = to(p.W[j], 29);
        learn->stop[j]   = to(p.X[j], 29);
    }
    known->TRIBO_N(constant) = FORCE(p.c[0]);
    known->slope             = to(p.c[1], 29);
    known->scale             = to(p.c[2], 29);
    known->doubt             = PART(p.doubt, 32);
    known->TRIBO_N(travel)   = 0;
    for (int i = 0; i < 4; i++)
    {
        for (int j = i; j < 4; j++)
        {
            known->covariance[row[i][j]] = to(p.M[i][j], 30);
        }
        known->variance[i]      = to(p.P[i], 30);
        learn->regressor[i]     = to(p.k[i], 29);
        learn->regressor[4 + i] = to(p.kappa[i], 29);
        learn->gained[i]        = to(p.q[i], 27);
        learn->gained[4 + i]    = to(p.q[4 + i], 27);
        state->stop[i]          = to(p.phi[i], 29);
    }
    learn->TRIBO_N(force)          = FORCE(p.yf);
    learn->TRIBO_N(friction)       = FORCE(p.z);
    learn->TRIBO_N(jump)           = FORCE(p.jump);
    learn->TRIBO_N(sample)         = TRIBO_EITHER((float)p.delta, (uint32_t)FORCE(p.delta));
    learn->error                   = to(p.epsilon, 26);
    learn->load                    = to(p.l, 26);
    learn->TRIBO_N(weighing)       = TRIBO_EITHER((float)p.rho, (uint32_t)FORCE(p.rho));
    learn->gain                    = PART(p.gain, 31);
    learn->presliding              = PART(p.presliding, 32);
    state->hold.extra_margin       = PART(p.lambda, 32);
    state->observer.TRIBO_N(noise) = NOISE(p.noise);
    state->TRIBO_N(reached)        = FORCE(p.rs);
    state->sigma                   = to(p.sigma, 29);
    state->TRIBO_N(offset)         = FORCE(p.b);
    state->TRIBO_N(f)              = FORCE(p.f);
}

static void work(uint32_t stage)
{
    give();
    TRIBO_PART(learning, work)
    (&x.params,
     &x.loop.compensator.friction,
     &x.memory.state,
     stage,
     TRIBO_EITHER((float)p.level, (uint32_t)FORCE(p.level)));
}

#define KNOWN x.memory.state.learned
#define LEARN x.memory.state.learning

// --- anything ----------------------------------------------------------------------------------------------------------------------

static void draw(void)
{
    double root[4][4];
    double most = 0.0;
    p           = (page_t){.V = {random_between(&r, 0.0, 1.0) < 0.2 ? 0.02 : random_between(&r, 0.02, 3.0)}};
    for (int i = 0; i < 4; i++)
    {
        p.V[i + 1] = any(2.0);
        p.W[i]     = any(4.0);
        p.P[i]     = random_between(&r, 0.0, 1.0);
        p.X[i]     = any(1.0);
        p.k[i]     = i == 0 ? any(0.4) : random_between(&r, i == 3 ? -2.0 : 0.0, 2.0);
        p.kappa[i] = any(1.1);
        p.q[i]     = any(3.0);
        p.q[4 + i] = any(1.1);
        p.phi[i]   = any(1.0);
        for (int j = 0; j < 4; j++)
        {
            root[i][j] = random_between(&r, -1.0, 1.0);
        }
    }
    for (int i = 0; i < 4; i++) // a covariance
    {
        for (int j = 0; j < 4; j++)
        {
            for (int n = 0; n < 4; n++)
            {
                p.M[i][j] += root[i][n] * root[j][n];
            }
            most = fmax(most, fabs(p.M[i][j]));
        }
    }
    for (int i = 0; i < 4; i++)
    {
        for (int j = 0; j < 4; j++)
        {
            p.M[i][j] /= most;
        }
    }
    p.W[STOPS]   = any(2.0);
    p.X[STOPS]   = any(1.0);
    p.c[0]       = any(B);
    p.c[1]       = any(0.5);
    p.c[2]       = any(0.5);
    p.doubt      = random_between(&r, 0.0, 1.0);
    p.yf         = any(0.9);
    p.delta      = B / 157.0 * pow(10.0, random_between(&r, -2.0, 0.0));
    p.z          = D_of(p.yf) + load_of(p.yf) + any(2.0) * L_of(p.yf);
    p.jump       = any(1.0) * pow(10.0, random_between(&r, -4.0, 0.0));
    p.epsilon    = any(1.0) * pow(10.0, random_between(&r, -3.0, 0.7));
    p.l          = any(2.0);
    p.rho        = B / 78.5 * random_between(&r, 1.0, 65.0);
    p.gain       = 0.5 * pow(10.0, random_between(&r, -4.0, 0.0));
    p.epsilon    = clamp(p.epsilon, -0.7 / p.gain, 0.7 / p.gain);
    p.presliding = random_between(&r, 0.0, 1.0);
    p.noise      = random_between(&r, 0.0, 1.0) < 0.3 ? 0.0 : 0.03 * pow(10.0, random_between(&r, -4.0, 0.0));
    p.lambda     = random_between(&r, 0.0, 1.0);
    p.rs         = any(0.9);
    p.sigma      = any(1.0);
    p.b          = any(0.2);
    p.f          = any(0.2);
    p.level      = random_between(&r, 0.0, 0.3);
}

/// Of its size, but at least of 1: single precision, or the last bits of a format.
static void check(double expected, double found, const char *name)
{
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-6 * fmax(1.0, fabs(expected)), expected, found, name);
}

// --- the stages --------------------------------------------------------------------------------------------------------------------

/// Stage 0: what is measured moves the stops, and a part of its travel counts unless it slips or hunts.
static void test_a_sample_counts_its_travel_unless_it_slips_or_hunts(void)
{
    const double d[1 + STOPS] = {B / 628.0, B / 11.0 * 0.052734375, B / 11.0 * 0.140625, B / 11.0 * 0.375, B / 11.0};
    const double slip         = B / 0.314 * 10.0 * H;
    int          counted      = 0;
    int          hunted       = 0;
    for (int i = 0; i < TRIALS; i++)
    {
        draw();
        give();
        TRIBO(feedforward_observer, state_t) *const seen = &x.memory.state.observer;

        const double   dm        = (i % 2 == 0 ? 1.0 : -1.0) * slip * pow(10.0, random_between(&r, -3.0, 0.3));
        const double   m         = any(0.9);
        const bool     allowed   = i % 7 != 0;
        const int      before    = (int)(random_bits(&r) % 3u) - 1;
        const bool     hunts     = random_bits(&r) % 2u != 0u;
        const uint32_t since     = (uint32_t)(random_bits(&r) % 12u) * 10u;
        seen->TRIBO_N(travelled) = FORCE(m + dm);
        seen->TRIBO_N(friction)  = FORCE(p.z + p.jump);
        seen->TRIBO_N(force)     = FORCE(p.yf);
        LEARN.TRIBO_N(travelled) = FORCE(m);
        LEARN.side               = (int8_t)before;
        LEARN.hunts              = hunts;
        LEARN.since              = since;
        TRIBO_PART(learning, sample)(&x.params, seen, &LEARN, allowed);
        double X[1 + STOPS];
        for (int j = 0; j <= STOPS; j++)
        {
            X[j] = clamp(p.X[j] + dm / d[j], -1.0, 1.0);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2e-7 / d[j], X[j], from((double)LEARN.stop[j], 29), "X");
        }
        const int      side = X[STOPS] == 1.0 ? 1 : X[STOPS] == -1.0 ? -1 : before;
        const bool     hunt = side != before ? since < 100u : hunts;
        const uint32_t next = side != before ? 0u : since < 100u ? since + 10u : since;
        const bool     good = allowed && fabs(dm) <= slip && !(hunt && next < 100u);
        TEST_ASSERT_EQUAL_INT(side, LEARN.side);
        TEST_ASSERT_EQUAL_INT(hunt, LEARN.hunts != 0);
        TEST_ASSERT_EQUAL_UINT32(next, LEARN.since);
        check(p.jump, OF_FORCE(LEARN.TRIBO_N(jump)), "jump");
        check(p.z + p.jump, OF_FORCE(LEARN.TRIBO_N(friction)), "z");
        check(p.yf, OF_FORCE(LEARN.TRIBO_N(force)), "yf");
        check(m + dm, OF_FORCE(LEARN.TRIBO_N(travelled)), "m");
        TEST_ASSERT_DOUBLE_WITHIN(2e-7, good ? fmin(fabs(dm), B / 157.0) : 0.0, OF_FORCE(LEARN.TRIBO_N(sample)));
        counted += good;
        hunted += allowed && fabs(dm) <= slip && !good;
    }
    TEST_ASSERT_TRUE(counted > TRIALS / 10 && hunted > TRIALS / 10);
}

/// At a reversal, what friction lacks and no other direction has told apart from a load is taken for less friction.
static void test_a_turn_takes_a_lack_as_far_as_one_direction_alone_has_slid(void)
{
    int lacked = 0;
    for (int i = 0; i < TRIALS; i++)
    {
        draw();
        p.M[0][0] = random_between(&r, 0.0, 0.6);
        p.W[0]    = p.V[0] - any(0.99);
        give();
        KNOWN.seal        = TRIBO_PART(learning, fold_all)(&KNOWN);
        const double one  = clamp((p.M[0][0] - 0.15) / 0.25, 0.0, 1.0);
        const double lack = -one * p.l * p.X[0];
        const double V    = lack > 0.0 ? clamp(p.V[0] - 1.15 * lack, 0.02, 3.0) : p.V[0];
        const double both = lack > 0.0 ? 1.0 - one : 1.0;
        TRIBO_PART(learning, turn)(&KNOWN, &LEARN);
        check(V, from((double)KNOWN.weight[0], 29), "V_0");
        check(p.W[0] + V - p.V[0], from((double)KNOWN.use[0], 29), "W_0");
        check(both * p.c[0], OF_FORCE(KNOWN.TRIBO_N(constant)), "c_0");
        check(both * p.c[1], from((double)KNOWN.slope, 29), "c_1");
        check(both * p.c[2], from((double)KNOWN.scale, 29), "c_2");
        check(both * p.l, from((double)LEARN.load, 26), "l");
        TEST_ASSERT_EQUAL_HEX32(TRIBO_PART(learning, fold_all)(&KNOWN), KNOWN.seal);
        lacked += V < p.V[0];
    }
    TEST_ASSERT_TRUE(lacked > TRIALS / 5);
}

static void test_the_regressor_is_of_the_stops_and_the_load_and_jumps_weigh_less(void)
{
    int capped = 0;
    for (int i = 0; i < TRIALS; i++)
    {
        draw();
        const double L   = L_of(p.yf);
        double       sum = p.V[0] * p.X[0];
        work(1);
        check(0.4 * p.X[0], from((double)LEARN.regressor[0], 29), "k_0");
        check(fmin(2.0, B / 5.23 / L), from((double)LEARN.regressor[1], 29), "k_1");
        check(fmin(2.0, 0.1 * fabs(p.yf) / L), from((double)LEARN.regressor[2], 29), "k_2");
        check(clamp(0.1 * p.yf / L, -2.0, 2.0), from((double)LEARN.regressor[3], 29), "k_3");
        for (int j = 1; j <= STOPS; j++)
        {
            const double psi = p.X[j] - p.X[j - 1];
            sum += p.V[j] * psi;
            check(0.55 * psi, from((double)LEARN.regressor[3 + j], 29), "kappa");
        }
        const double net  = p.z - D_of(p.yf) - load_of(p.yf);
        const double fast = 0.03 * fabs(p.jump) / (10.0 * H * L);
        capped += fast > 8.0;
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5, net / L - sum, from((double)LEARN.error, 26), "epsilon");
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5, load_of(p.yf) / L, from((double)LEARN.load, 26), "l");
        const double rho = B / 78.5 * (1.0 + pow(fmin(8.0, fast), 2.0));
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1e-5 * rho, rho, OF_FORCE(LEARN.TRIBO_N(weighing)), "rho");
    }
    TEST_ASSERT_TRUE(capped > TRIALS / 20);
}

/// Of a small breakaway, the regressors of the load end at 2.
static void test_the_regressors_of_the_load_are_limited(void)
{
    model.friction.positive.offset_n = 1e-3f;
    model.friction.negative.offset_n = 1e-3f;
    model.friction.positive.slope    = 0.02f;
    model.friction.negative.slope    = 0.02f;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, feedforward_init_scaled(&x, &config, &model, 2.0, H, 1.0));
    for (int side = -1; side <= 1; side += 2)
    {
        draw();
        p.yf = side * 0.9;
        p.z  = 0.0;
        work(1);
        check(0.011 / 5.23 / 0.019, from((double)LEARN.regressor[1], 29), "k_1");
        check(2.0, from((double)LEARN.regressor[2], 29), "k_2");
        check(side * 2.0, from((double)LEARN.regressor[3], 29), "k_3");
        p.yf = 0.0;
        work(1);
        check(2.0, from((double)LEARN.regressor[1], 29), "k_1");
        check(0.0, from((double)LEARN.regressor[2], 29), "k_2");
        check(0.0, from((double)LEARN.regressor[3], 29), "k_3");
    }
}

/// Stages 2 and 3 of one sample.
static void test_the_gain_is_that_of_least_squares_and_a_surprise_gets_less(void)
{
    int surprised = 0;
    for (int i = 0; i < TRIALS; i++)
    {
        draw();
        double q[4 + STOPS] = {0.0};
        double S            = 0.0;
        p.epsilon           = any(1.0) * pow(10.0, random_between(&r, -1.0, 1.3));
        for (int a = 0; a < 4; a++)
        {
            for (int b = 0; b < 4; b++)
            {
                q[a] += p.M[a][b] * p.k[b];
            }
            q[4 + a] = p.P[a] * p.kappa[a];
            S += q[a] * p.k[a] + q[4 + a] * p.kappa[a];
        }
        const double usual = 4.0 * (S + 0.01) / (p.epsilon * p.epsilon);
        const double gain  = p.delta / (p.rho + p.delta * S) * fmin(1.0, usual);
        surprised += usual < 1.0;
        work(2);
        for (int a = 0; a < 4 + STOPS; a++)
        {
            p.q[a] = a < TRIBO_EITHER(8, 4) ? from((double)LEARN.gained[a], 27) : p.q[a];
        }
        work(3);
        for (int a = 0; a < 4 + STOPS; a++)
        {
            check(q[a], from((double)LEARN.gained[a], 27), "q");
        }
        const double found = from((double)LEARN.gain, 31);
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(TRIBO_EITHER(1e-5, 2e-4) * gain + 1e-8, gain, found, "gain");
    }
    TEST_ASSERT_TRUE(surprised > TRIALS / 20 && surprised < TRIALS - TRIALS / 20);
}

static void test_weights_move_by_gain_and_error_within_their_bounds(void)
{
    int ends[2] = {0, 0};
    for (int i = 0; i < TRIALS; i++)
    {
        draw();
        work(4);
        const double step = p.gain * p.epsilon;
        const double V    = p.V[0] + 0.4 * step * p.q[0];
        ends[0] += V < 0.02 || V > 3.0;
        check(clamp(V, 0.02, 3.0), from((double)KNOWN.weight[0], 29), "V_0");
        for (int j = 1; j <= STOPS; j++)
        {
            const double next = p.V[j] + 0.55 * step * p.q[3 + j];
            ends[1] += fabs(next) > 2.0;
            check(clamp(next, -2.0, 2.0), from((double)KNOWN.weight[j], 29), "V_j");
        }
        const double left = 1.0 - p.delta / (B / 1.57);
        check(p.lambda * left, from((double)x.memory.state.hold.extra_margin, 32), "lambda");
    }
    TEST_ASSERT_TRUE(ends[0] > TRIALS / 50 && ends[1] > TRIALS / 50);
}

/// An error that is not a number moves nothing. In fixed point there is none: the largest moves nothing beyond its bounds.
static void test_an_error_that_is_not_a_number_keeps_what_is_learned_within_its_bounds(void)
{
    draw();
    give();
    LEARN.error = TRIBO_EITHER((float)NAN, INT32_MIN);
    for (uint32_t stage = 4; stage <= 5; stage++)
    {
        TRIBO_PART(learning, work)(&x.params,
                                   &x.loop.compensator.friction,
                                   &x.memory.state,
                                   stage,
                                   TRIBO_EITHER(0.1f, (uint32_t)FORCE(0.1)));
    }
    for (int j = 0; j <= STOPS; j++)
    {
        const double V = from((double)KNOWN.weight[j], 29);
        TEST_ASSERT_TRUE(
            TRIBO_EITHER(V == (double)(float)p.V[j], V >= (j == 0 ? 0.019 : -2.0) && V <= (j == 0 ? 3.0 : 2.0)));
    }
    const double c = OF_FORCE(KNOWN.TRIBO_N(constant));
    TEST_ASSERT_TRUE(TRIBO_EITHER(c == (double)(float)p.c[0], fabs(c) <= B + 1e-6));
    const double slopes[] = {from((double)KNOWN.slope, 29), from((double)KNOWN.scale, 29)};
    for (int j = 0; j < 2; j++)
    {
        TEST_ASSERT_TRUE(TRIBO_EITHER(slopes[j] == (double)(float)p.c[1 + j], fabs(slopes[j]) <= 0.5));
    }
}

/// The part of the stops' weights that is used, by the sum of their squares.
static double presliding_of(double A)
{
    const double least = 0.15 + 2.0 * p.noise / D_T;
    return A > 0.0 ? fmax(0.0, 1.0 - pow(least / A, 2.0)) : 0.0;
}

static void test_the_load_moves_within_its_bounds_and_b_takes_it(void)
{
    int ends[3] = {0, 0, 0};
    int used    = 0;
    for (int i = 0; i < TRIALS; i++)
    {
        draw();
        work(5);
        const double sd[3]   = {B / 5.23, 0.1, 0.1};
        const double most[3] = {B, 0.5, 0.5};
        const double before  = load_of(p.rs);
        const double A       = p.V[1] * p.V[1] + p.V[2] * p.V[2] + p.V[3] * p.V[3] + p.V[4] * p.V[4];
        for (int j = 0; j < 3; j++)
        {
            const double next = p.c[j] + sd[j] * p.gain * p.epsilon * p.q[1 + j];
            ends[j] += fabs(next) > most[j];
            p.c[j] = clamp(next, -most[j], most[j]);
        }
        check(p.c[0], OF_FORCE(KNOWN.TRIBO_N(constant)), "c_0");
        check(p.c[1], from((double)KNOWN.slope, 29), "c_1");
        check(p.c[2], from((double)KNOWN.scale, 29), "c_2");
        check(p.b + load_of(p.rs) - before, OF_FORCE(x.memory.state.TRIBO_N(offset)), "b");
        const double part = presliding_of(A);
        check(part, from((double)LEARN.presliding, 32), "presliding");
        used += part < 0.99;
    }
    TEST_ASSERT_TRUE(ends[0] > TRIALS / 50 && ends[1] > TRIALS / 50 && ends[2] > TRIALS / 50);
    TEST_ASSERT_TRUE(used > 0);
}

/// Of stops that have learned little, nothing is used; from then on ever more, and less in noise.
static void test_presliding_is_used_from_a_sum_of_squares_on(void)
{
    for (int i = 0; i <= 40; i++)
    {
        draw();
        const double A = 0.01 * i;
        for (int j = 1; j <= STOPS; j++)
        {
            p.V[j] = (j % 2 == 0 ? -1.0 : 1.0) * sqrt(A / STOPS);
        }
        work(5);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5, presliding_of(A), from((double)LEARN.presliding, 32));
    }
}

/// On a hub of next to no breakaway no sum of squares is beyond the noise.
static void test_no_presliding_is_used_in_noise_beyond_all_weights(void)
{
    DOUBT_PER_TRAVEL = TRIBO_EITHER(1e4f, UINT32_MAX);
    for (int i = 0; i < 100; i++)
    {
        draw();
        p.noise = 0.03;
        work(5);
        TEST_ASSERT_TRUE(LEARN.presliding == 0);
        p.k[1] = 2.0;
        work(6);
        const double S = p.presliding * pow(p.V[1], 3.0) / (p.V[1] * p.V[1] + 0.04);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5,
                                  fmin(0.75 * p.V[0] - S, TRIBO_EITHER(5.0, 4.0)),
                                  from((double)KNOWN.use[0], 29));
    }
}

static void test_what_is_used_of_the_weights_shrinks_and_b_takes_the_change_of_f(void)
{
    const double of_W = TRIBO_EITHER(1e-5, 2e-5); // in Q31 a difference of two that are within 1e-5 each
    const double of_f = TRIBO_EITHER(2e-6, 2e-5);
    int          ends = 0;
    for (int i = 0; i < TRIALS; i++)
    {
        draw();
        work(6);
        double S[STOPS + 2] = {0.0};
        double W[STOPS + 1];
        for (int j = 1; j <= STOPS; j++)
        {
            S[j] = p.presliding * pow(p.V[j], 3.0) / (p.V[j] * p.V[j] + 0.04);
        }
        const double spared = fmin(p.k[1] * p.noise / (3.0 * D_T), 0.25 * p.V[0]);
        double       sum    = 0.0;
        for (int j = 0; j <= STOPS; j++)
        {
            W[j] = fmin((j == 0 ? p.V[0] - spared : S[j]) - S[j + 1], TRIBO_EITHER(5.0, 4.0));
            sum += W[j] * (j == 0 ? p.sigma : p.phi[j - 1]);
            TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(of_W, W[j], from((double)KNOWN.use[j], 29), "W");
        }
        ends += fabs(sum) > 4.0;
        const double doubt = p.doubt * (1.0 - p.delta / (B / 7.85));
        const double f     = (1.0 - 0.5 * doubt) * p.level * clamp(sum, -4.0, 4.0);
        check(doubt, from((double)KNOWN.doubt, 32), "doubt");
        check(p.delta, OF_FORCE(KNOWN.TRIBO_N(travel)), "travel");
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(of_f, f, OF_FORCE(x.memory.state.TRIBO_N(f)), "f");
        TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(of_f, p.b + f - p.f, OF_FORCE(x.memory.state.TRIBO_N(offset)), "b");
    }
    TEST_ASSERT_TRUE(ends > TRIALS / 100);
}

/// A number less what a sample says, brought back to its own by `part`.
static double left(double before, double drop, double own, double part)
{
    const double less = before - drop;
    return clamp(less + part * (own - less), own == 0.0 ? -1.0 : 0.0, 1.0);
}

/// Two rows of M, from row `first`.
static void check_rows(int first, double part)
{
    for (int a = first; a < first + 2; a++)
    {
        for (int b = a; b < 4; b++)
        {
            const double own = a == b ? 1.0 : 0.0;
            check(left(p.M[a][b], p.gain * p.q[a] * p.q[b], own, part),
                  from((double)KNOWN.covariance[row[a][b]], 30),
                  "M");
        }
    }
}

/// Stages 7 and 8: what a sample says makes M and P smaller, forgetting brings them back.
static void check_variances(double forgetting)
{
    for (int i = 0; i < TRIALS; i++)
    {
        draw();
        const double part = fmin(1.0, forgetting * p.delta);
        for (int a = 0; a < 4 + STOPS; a++) // a gain q^2 as it may be
        {
            p.q[a] *= 0.3;
        }
        work(7);
        check_rows(0, part);
        work(8);
        check_rows(2, part);
        for (int j = 0; j < STOPS; j++)
        {
            const double drop = p.gain * p.q[4 + j] * p.q[4 + j];
            check(left(p.P[j], drop, 1.0, part), from((double)KNOWN.variance[j], 30), "P");
        }
    }
}

static void test_a_sample_takes_its_part_of_the_variances_and_forgetting_brings_them_back(void)
{
    check_variances(0.0157 / B);
}

static void test_the_quickest_forgetting_leaves_nothing_of_a_sample(void)
{
    config.forgetting_per_n = TRIBO_EITHER(1e6f, 15.9f);
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, feedforward_init_scaled(&x, &config, &model, 2.0, H, 1.0));
    check_variances((double)config.forgetting_per_n);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_sample_counts_its_travel_unless_it_slips_or_hunts);
    RUN_TEST(test_a_turn_takes_a_lack_as_far_as_one_direction_alone_has_slid);
    RUN_TEST(test_the_regressor_is_of_the_stops_and_the_load_and_jumps_weigh_less);
    RUN_TEST(test_the_regressors_of_the_load_are_limited);
    RUN_TEST(test_the_gain_is_that_of_least_squares_and_a_surprise_gets_less);
    RUN_TEST(test_weights_move_by_gain_and_error_within_their_bounds);
    RUN_TEST(test_an_error_that_is_not_a_number_keeps_what_is_learned_within_its_bounds);
    RUN_TEST(test_the_load_moves_within_its_bounds_and_b_takes_it);
    RUN_TEST(test_presliding_is_used_from_a_sum_of_squares_on);
    RUN_TEST(test_no_presliding_is_used_in_noise_beyond_all_weights);
    RUN_TEST(test_what_is_used_of_the_weights_shrinks_and_b_takes_the_change_of_f);
    RUN_TEST(test_a_sample_takes_its_part_of_the_variances_and_forgetting_brings_them_back);
    RUN_TEST(test_the_quickest_forgetting_leaves_nothing_of_a_sample);
    return UNITY_END();
}
