// Parts of a tick of the feed-forward, each alone and from any numbers, against steps 2, 4, 7, 10 and the monitor of
// docs/feedforward.md in double precision.

#define FULL_SCALE_N 2.0
#include "feedforward.h"
#if TRIBO_IS_Q31
#include "feedforward/hold_q31.h"
#include "feedforward/monitor_q31.h"
#include "feedforward/observer_q31.h"
#else
#include "feedforward/hold_f32.h"
#include "feedforward/monitor_f32.h"
#include "feedforward/observer_f32.h"
#endif
#include "random.h"
#include "runs.h"
#include "unity.h"

#include <math.h>

#define SEED   0xba2cu
#define H      1e-3
#define TRIALS RUNS(20000, 500)
#define B      (0.007 + 0.3 * 0.5) // the paper's rig
#define W      (B / 314.0)
#define TAU    (1.0 / 200.0 + 0.0288 / 3.84)
#define WIDEST TRIBO_EITHER(1e9, FULL_SCALE_N / 64.0) // a mean second difference in fixed point

static random_t                       r;
static tribo_feedforward_f32_config_t config;
static tribo_compensator_f32_config_t model;
static feedforward_t                  x;

void setUp(void)
{
    r.state = SEED;
    config  = tribo_feedforward_f32_default();
    model   = tribo_force_loop_f32_paper().compensator;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, feedforward_init_scaled(&x, &config, &model, 2.0, H, 1.0));
}

void tearDown(void)
{
}

/// Of either sign, from the last bits to `most`.
static double any(double most)
{
    return (random_between(&r, 0.0, 1.0) < 0.5 ? -1.0 : 1.0) * most * pow(10.0, random_between(&r, -6.0, 0.0));
}

static double clamp(double a, double low, double high)
{
    return fmin(fmax(a, low), high);
}

/// Towards the input, for a time constant.
static double pass(double before, double input, double time, double tick)
{
    return before + tick / (time + tick) * (input - before);
}

static void check(double expected, double found, const char *name)
{
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(4e-7 * fmax(1.0, fabs(expected)), expected, found, name);
}

static void test_the_mean_second_difference_takes_up_to_four_times_itself(void)
{
    for (int i = 0; i < TRIALS; i++)
    {
        const double               now    = any(0.9);
        const double               old[2] = {now + any(0.05), now + any(0.05)};
        const double               mean   = random_between(&r, 0.0, 1.0) * fmin(WIDEST, 0.05) * fabs(any(1.0));
        const double               d2     = fmin(fabs(now - 2.0 * old[0] + old[1]), WIDEST);
        const double               most   = 4.0 * mean + 0.002 * W;
        const double               wanted = mean + (fmin(d2, most) - mean) / 250.0;
        const feedforward_number_t at     = FORCE(now);
        feedforward_number_t       last[] = {FORCE(old[0]), FORCE(old[1])};
        const double               found  = OF_NOISE(TRIBO_PART(bank, noise)(&x.params, NOISE(mean), at, last));
        TEST_ASSERT_DOUBLE_WITHIN(1e-9 + 1e-6 * wanted, fmin(wanted, WIDEST), found);
        TEST_ASSERT_TRUE(last[0] == at && last[1] == FORCE(old[0]));
    }
}

/// Step 4: the stops and the sign follow rs behind plays of their widths.
static void test_stops_and_sign_follow_the_reference_behind_their_plays(void)
{
    TRIBO(feedforward, state_t) *const s     = &x.memory.state;
    int                                turns = 0;
    for (int i = 0; i < TRIALS; i++)
    {
        const double rs    = any(0.9);
        const double noise = fabs(any(5e-3));
        const double width = W + noise;
        const double rn    = rs + any(0.02);
        const double rp    = rs + any(2e-3);
        const int    sign  = (int)(random_bits(&r) % 3u) - 1;
        double       phi[4];
        s->TRIBO_N(reached) = FORCE(rs);
        s->TRIBO_N(settled) = FORCE(rn);
        s->TRIBO_N(turned)  = FORCE(rp);
        s->sign             = (int8_t)sign;
        for (int j = 0; j < 4; j++)
        {
            phi[j]     = random_between(&r, -1.0, 1.0);
            s->stop[j] = to(phi[j], 29);
        }
        TRIBO_PART(bank, slide)(&x.params, s, TRIBO_EITHER((float)noise, (uint32_t)FORCE(noise)));
        TRIBO_PART(bank, turn)(s, TRIBO_EITHER((float)width, (uint32_t)FORCE(width)));
        const double n = clamp(rn, rs - noise / 2.0, rs + noise / 2.0);
        const double p = clamp(rp, rs - width / 2.0, rs + width / 2.0);
        check(n, OF_FORCE(s->TRIBO_N(settled)), "rn");
        check(p, OF_FORCE(s->TRIBO_N(turned)), "rp");
        for (int j = 0; j < 4; j++)
        {
            const double d = B / 11.0 * pow(0.375, 3 - j);
            TEST_ASSERT_DOUBLE_WITHIN(3e-7 / d, clamp(phi[j] + (n - rn) / d, -1.0, 1.0), from((double)s->stop[j], 29));
        }
        if (p == rp || fabs(p - rp) > 1e-6)
        {
            TEST_ASSERT_EQUAL_INT(p > rp ? 1 : p < rp ? -1 : sign, s->sign);
        }
        turns += p != rp;
    }
    TEST_ASSERT_TRUE(turns > TRIALS / 10);
}

static void test_the_observer_measures_friction_and_travel(void)
{
    TRIBO(feedforward_observer, state_t) s;
    for (int i = 0; i < TRIALS; i++)
    {
        const double u[3]     = {any(0.9), any(0.9), any(0.9)}; // u, u_1, u_2
        const double y        = any(0.9);
        const double yf       = y + any(0.1);
        const double zf       = any(0.3);
        const double n        = fabs(any(5e-3));
        const double moved    = yf + any(2e-3);
        s.TRIBO_N(y)[0]       = FORCE(y);
        s.TRIBO_N(y)[1]       = FORCE(y);
        s.TRIBO_N(noise)      = NOISE(n);
        s.TRIBO_N(actuator)   = FORCE(u[1]);
        s.TRIBO_N(sensor)     = FORCE(u[2]);
        s.TRIBO_N(force)      = FORCE(yf);
        s.TRIBO_N(difference) = FORCE(zf);
        s.TRIBO_N(travelled)  = FORCE(moved);
        TRIBO_PART(observer, step)(&x.params, &s, FORCE(u[0]), FORCE(y));
        const double u1   = u[1] + (1.0 - exp(-0.2)) * (u[0] - u[1]);
        const double u2   = u[2] + (1.0 - exp(-0.055)) * (u1 - u[2]);
        const double next = pass(yf, y, 0.8 * TAU, H);
        const double net  = pass(zf, u2 - y, 0.8 * TAU, H);
        const double ny   = n + (0.0 - n) / 250.0;
        const double half = (W / 5.0 + 0.4 * ny) / 2.0;
        check(u1, OF_FORCE(s.TRIBO_N(actuator)), "u_1");
        check(u2, OF_FORCE(s.TRIBO_N(sensor)), "u_2");
        check(next, OF_FORCE(s.TRIBO_N(force)), "yf");
        check(net, OF_FORCE(s.TRIBO_N(difference)), "zf");
        TEST_ASSERT_DOUBLE_WITHIN(3e-6, net - 0.0288 / 3.84 * (next - yf) / H, OF_FORCE(s.TRIBO_N(friction)));
        check(clamp(moved, next - half, next + half), OF_FORCE(s.TRIBO_N(travelled)), "m");
    }
}

static void test_the_deadband_is_a_part_of_the_noise_by_how_often_y_changes(void)
{
    TRIBO(feedforward_hold, state_t) s = {.side = 0};
    const double part                  = H / (0.3 + H);
    int          rests                 = 0;
    for (int i = 0; i < TRIALS; i++)
    {
        const double n_e    = fabs(any(0.02));
        const double n_a    = random_between(&r, 0.0, 1.0);
        const double n_y    = fabs(any(0.02));
        const double mean   = any(0.002);
        const double e      = any(0.1);
        const double old[2] = {any(0.03), any(0.03)};
        const double y      = i % 3 == 0 ? old[0] : any(0.03);
        const double d2     = fmin(fabs(y - 2.0 * old[0] + old[1]), WIDEST);

        const feedforward_number_t last[]  = {FORCE(old[0]), FORCE(old[1])};
        const bool                 changed = FORCE(y) != last[0];
        s.TRIBO_N(noise)                   = NOISE(n_e);
        s.changed                          = PART(n_a, 32);
        s.TRIBO_N(error)                   = FORCE(mean);
        const bool before                  = random_bits(&r) % 2u == 0;
        const bool stands                  = i % 7 != 0;
        s.rests                            = before;
        s.still                            = x.params.still_ticks - (stands ? 0u : 1u);
        const double found = OF_FORCE(TRIBO_PART(hold, deadband)(&x.params, &s, FORCE(e), FORCE(y), last, NOISE(n_y)));
        const double all   = n_a + part * ((changed ? 1.0 : 0.0) - n_a);
        const double noise = changed ? n_e + part * (d2 - n_e) : n_e;
        const double least = 0.07 * n_y;
        const double d     = least + noise * 0.6 * (1.0 - all);
        const double most  = before ? 2.5 * least : least;
        check(all, from((double)s.changed, 32), "n_a");
        check(noise, OF_NOISE(s.TRIBO_N(noise)), "n_e");
        check(mean, OF_FORCE(s.TRIBO_N(error)), "mean of e");
        if (fabs(fabs(mean) - most) > 1e-6)
        {
            rests += s.rests;
            TEST_ASSERT_TRUE(s.rests == (stands && fabs(mean) < most));
        }
        check(e - clamp(mean, -d, d), found, "e");
    }
    TEST_ASSERT_TRUE(rests > TRIALS / 10 && rests < TRIALS * 9 / 10);
}

static void test_a_hold_follows_the_error(void)
{
    TRIBO(feedforward_hold, state_t) s = {.side = 0};
    for (int i = 0; i < TRIALS; i++)
    {
        const double mean = any(0.02);
        const double e    = any(0.1);
        s.TRIBO_N(error)  = FORCE(mean);
        TRIBO_PART(hold, follow)(&x.params, &s, FORCE(e));
        check(mean + H / (0.3 + H) * (e - mean), OF_FORCE(s.TRIBO_N(error)), "mean of e");
    }
}

/// A flipped bit must not keep u from its rest for ever.
static void test_a_corrupt_mean_of_the_error_comes_back(void)
{
    static const double odd[] = {(double)NAN, (double)INFINITY, -3e38};
    for (int i = 0; i < 3; i++)
    {
        TRIBO(feedforward_hold, state_t) s = {.side = 0};
        s.TRIBO_N(error)                   = TRIBO_EITHER((float)odd[i], odd[i] < 0.0 ? -(1 << 30) : 1 << 30);
        for (int k = 0; k < 9000; k++)
        {
            TRIBO_PART(hold, follow)(&x.params, &s, FORCE(0.01));
        }
        TEST_ASSERT_DOUBLE_WITHIN(3e-6, 0.01, OF_FORCE(s.TRIBO_N(error)));
    }
}

static void test_a_hold_feeds_back_its_part_of_what_sticks(void)
{
    TRIBO(feedforward, state_t) *const s = &x.memory.state;
    for (int i = 0; i < TRIALS; i++)
    {
        const double net  = any(0.3);
        const double most = fabs(any(0.2));
        const int    side = (int)(random_bits(&r) % 3u) - 1;
        s->hold.side      = (int8_t)side;
        check(0.94 * clamp(net, -most, most), OF_FORCE(TRIBO_PART(hold, friction)(FORCE(net), FORCE(most))), "f");
        TRIBO_PART(hold, turn)(&x.params, &s->hold, FORCE(net), FORCE(most));
        if (fabs(fabs(net) - most) > 1e-6)
        {
            TEST_ASSERT_EQUAL_INT(fabs(net) < most ? side : net > 0.0 ? 1 : -1, s->hold.side);
        }
    }
}

static void test_the_monitor_sums_the_travel_of_v_beyond_its_noise(void)
{
    TRIBO(feedforward_monitor, state_t) s;
    for (int i = 0; i < TRIALS; i++)
    {
        const double before = any(0.9);
        const double played = before + any(0.05);
        const double v      = before + any(0.9);
        const double noise  = fabs(any(0.01));
        const double travel = 4.0 * B * (i % 8 == 0 ? 1.0 - fabs(any(0.1)) : random_between(&r, 0.0, 1.0));
        s                   = (TRIBO(feedforward_monitor, state_t)){0};
        s.TRIBO_N(v)        = FORCE(before);
        s.TRIBO_N(played)   = FORCE(played);
        s.TRIBO_N(travel)   = TRIBO_EITHER((float)travel, (uint32_t)FORCE(travel));
        TRIBO_PART(monitor, step)(&x.params, &s, FORCE(v), NOISE(noise));
        const double half = (0.02 * B + 4.0 * noise) / 2.0;
        const double vf   = pass(before, v, 0.03, 10.0 * H);
        const double vp   = clamp(played, vf - half, vf + half);
        check(vf, OF_FORCE(s.TRIBO_N(v)), "vf");
        check(vp, OF_FORCE(s.TRIBO_N(played)), "vp");
        check(fmin(travel + fabs(vp - played), 4.0 * B), OF_FORCE(s.TRIBO_N(travel)), "t_v");
    }
}

static void test_the_monitor_judges_effort_by_what_friction_takes(void)
{
    TRIBO(feedforward_monitor, state_t) s;
    int harmful = 0;
    for (int i = 0; i < TRIALS; i++)
    {
        const double need   = any(0.9);
        const double before = need + any(0.5);
        const double travel = 4.0 * B * fabs(any(1.0));
        const double ratio  = random_between(&r, 0.0, 4.0);
        const bool   harms  = i % 16 == 0;
        s                   = (TRIBO(feedforward_monitor, state_t)){.begun = true, .feedback = {.harms = harms}};
        s.TRIBO_N(need)     = FORCE(before);
        s.TRIBO_N(travel)   = TRIBO_EITHER((float)travel, (uint32_t)FORCE(travel));
        s.ratio             = TRIBO_EITHER((float)ratio, (uint32_t)to(ratio / 4.0, 31));
        TRIBO_PART(monitor, judge)(&x.params, &s, FORCE(any(0.9)), FORCE(need));
        const double now = fmin(4.0, travel / (fabs(need - before) + 0.1 * B));
        const double xi  = ratio + (now - ratio) / 8.0;
        TEST_ASSERT_DOUBLE_WITHIN(2e-5, xi, from((double)s.ratio, 29));
        TEST_ASSERT_TRUE(fabs(xi - 0.6) < 2e-5 || (s.feedback.harms != 0) == (harms || xi > 0.6));
        TEST_ASSERT_TRUE(fabs(xi - 0.6) < 2e-5 || s.feedback.left == (xi > 0.6 ? 4 : 0));
        check(need, OF_FORCE(s.TRIBO_N(need)), "need");
        TEST_ASSERT_TRUE(s.TRIBO_N(travel) == 0);
        harmful += s.feedback.harms != 0;
    }
    TEST_ASSERT_TRUE(harmful > TRIALS / 4);
}

/// As the text has it, from every length.
static void test_feedback_lasts_up_to_eight_times_the_last_less_what_was_forward_since(void)
{
    for (int length = 0; length < 256; length++)
    {
        for (int harms = 0; harms < 2; harms++)
        {
            tribo_feedforward_feedback_t found = {.length = (uint8_t)length};
            feedback_judge(&found, harms);
            const int rest = length > 0 ? length - 1 : 0;
            TEST_ASSERT_EQUAL_INT(harms ? (int)clamp(8.0 * rest, 4.0, 128.0) : rest, found.length);
            TEST_ASSERT_EQUAL_INT(harms ? found.length : 0, found.left);
            TEST_ASSERT_EQUAL_INT(harms, found.harms);
            TEST_ASSERT_TRUE(feedback_is_on(&found) == harms);
        }
    }
    const tribo_feedforward_feedback_t unsaid = {.left = 128}; // a flipped bit
    TEST_ASSERT_FALSE(feedback_is_on(&unsaid));
}

static void test_a_reversal_fed_back_begins_the_travel_of_v_and_the_last_begins_a_trial(void)
{
    for (uint8_t left = 1; left < 4; left++)
    {
        TRIBO(feedforward_monitor, state_t) s = {.feedback = {.harms = true, .left = left, .length = 9}};
        s.TRIBO_N(travel)                     = TRIBO_EITHER(0.1f, 1000u);
        s.ratio                               = TRIBO_EITHER(0.75f, (uint32_t)to(0.75 / 4.0, 31));
        TRIBO_PART(monitor, judge)(&x.params, &s, FORCE(0.25), FORCE(0.125));
        check(0.25, OF_FORCE(s.TRIBO_N(v)), "vf");
        check(0.25, OF_FORCE(s.TRIBO_N(played)), "vp");
        check(0.125, OF_FORCE(s.TRIBO_N(need)), "need");
        check(left == 1 ? 0.51 : 0.75, from((double)s.ratio, 29), "xi");
        TEST_ASSERT_TRUE(s.TRIBO_N(travel) == 0 && s.begun);
        TEST_ASSERT_TRUE(s.feedback.left == left - 1 && s.feedback.length == 9 && s.feedback.harms);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_mean_second_difference_takes_up_to_four_times_itself);
    RUN_TEST(test_stops_and_sign_follow_the_reference_behind_their_plays);
    RUN_TEST(test_the_observer_measures_friction_and_travel);
    RUN_TEST(test_the_deadband_is_a_part_of_the_noise_by_how_often_y_changes);
    RUN_TEST(test_a_hold_follows_the_error);
    RUN_TEST(test_a_corrupt_mean_of_the_error_comes_back);
    RUN_TEST(test_a_hold_feeds_back_its_part_of_what_sticks);
    RUN_TEST(test_the_monitor_sums_the_travel_of_v_beyond_its_noise);
    RUN_TEST(test_the_monitor_judges_effort_by_what_friction_takes);
    RUN_TEST(test_feedback_lasts_up_to_eight_times_the_last_less_what_was_forward_since);
    RUN_TEST(test_a_reversal_fed_back_begins_the_travel_of_v_and_the_last_begins_a_trial);
    return UNITY_END();
}
