// doors axis CONTROLLER NUMBER... | doors joint: reads the inputs of a tick from a row, and writes what comes of them, by the library's own calls;
// in Q31 if TRIBO_ARITHMETIC_Q31 is defined. All numbers are whole: of a float its bits. doors.py has the rows.

#include "tribo_arithmetic.h"

#include "tribo/axis_q31.h"
#include "tribo/joint_q31.h"

#include <stdio.h>
#include <stdlib.h>

static const float full_scale_n = 8.0f;

static float float_of(int32_t word)
{
    float x;
    memcpy(&x, &word, sizeof x);
    return x;
}

static tribo_force_t force_of(int32_t word)
{
    return tribo_force_of_word((uint32_t)word);
}

static int32_t word_of(tribo_force_t x)
{
    return (int32_t)tribo_force_word(x);
}

static tribo_axis_f32_config_t axis_config(void)
{
    tribo_axis_f32_config_t config             = tribo_axis_f32_config();
    config.sample_time_s                       = 1e-3f;
    config.u_min_n                             = -2.0f;
    config.u_max_n                             = 2.0f;
    config.positive                            = (tribo_breakaway_f32_t){.offset_n = 0.007f, .slope = 0.3f};
    config.feedforward.actuator_pole_rad_per_s = 200.0f;
    config.feedforward.sensor_pole_rad_per_s   = 55.0f;
    return config;
}

static tribo_status_t axis_init(TRIBO(axis, t) * axis, const tribo_axis_f32_config_t *config)
{
#if TRIBO_IS_Q31
    return tribo_axis_q31_init(axis, config, full_scale_n);
#else
    return tribo_axis_f32_init(axis, config);
#endif
}

static void axis_tune(TRIBO(axis, t) * axis, const tribo_axis_f32_config_t *config)
{
    static TRIBO(axis, params_t) params[8];
    static unsigned              count;
    TRIBO(axis, params_t) *const next = &params[count++ % 8u];
#if TRIBO_IS_Q31
    (void)tribo_axis_q31_prepare(next, config, full_scale_n);
#else
    (void)tribo_axis_f32_prepare(next, config);
#endif
    (void)TRIBO(axis, change)(axis, next);
}

static void axis_learn(TRIBO(axis, t) * axis)
{
    (void)axis;
#if TRIBO_IS_Q31
    (void)tribo_axis_q31_learn(axis);
#endif
}

/// A row of r, y and the controller's output: e, u and what the limit took.
static void play_own(TRIBO(axis, t) * axis)
{
    for (int32_t r, y, v; scanf("%d %d %d", &r, &y, &v) == 3;)
    {
        const int32_t e = word_of(TRIBO(axis, error)(axis, force_of(r), force_of(y)));
        const int32_t u = word_of(TRIBO(axis, command)(axis, force_of(v)));
        axis_learn(axis);
        (void)printf("%d %d %d\n", e, u, word_of(TRIBO(axis, excess)(axis)));
    }
}

/// A row of r, y and kp, or a factor of the first section: u.
static void play_axis(int count, char **words)
{
    static TRIBO(axis, t) axis;
    tribo_axis_f32_config_t    config      = axis_config();
    tribo_biquad_f32_section_t sections[4] = {{.b0 = 0.0f}};
    const bool                 is_pi       = strcmp(words[0], "pi") == 0;
    for (int i = 1; i < count; i++)
    {
        const float x = float_of((int32_t)strtol(words[i], NULL, 10));
        memcpy((char *)sections + (size_t)(i - 1) * sizeof x, &x, sizeof x);
    }
    const tribo_biquad_f32_section_t first = sections[0];

    config.controller = tribo_paper();
    if (strcmp(words[0], "own") == 0)
    {
        config.controller = tribo_own();
        (void)axis_init(&axis, &config);
        play_own(&axis);
        return;
    }
    float before = is_pi ? 1.9f : 1.0f;
    if (is_pi)
    {
        config.controller = tribo_pi(before, 110.0f);
    }
    else if (count > 1)
    {
        config.controller = tribo_sections(sections, (uint32_t)(count - 1) / 5u);
    }
    (void)axis_init(&axis, &config);
    for (int32_t r, y, x; scanf("%d %d %d", &r, &y, &x) == 3;)
    {
        if (float_of(x) != before)
        {
            before            = float_of(x);
            sections[0].b0    = before * first.b0;
            sections[0].b1    = before * first.b1;
            sections[0].b2    = before * first.b2;
            config.controller = is_pi ? tribo_pi(before, 110.0f) : config.controller;
            axis_tune(&axis, &config);
        }
        (void)printf("%d\n", word_of(TRIBO(axis, step)(&axis, force_of(r), force_of(y))));
        axis_learn(&axis);
    }
}

/// A row of effort, q_ref, q and load: u.
static void play_joint(void)
{
    static TRIBO(joint, t) joint;
    tribo_joint_config_t config = tribo_joint_config();
    config.sample_time_s        = 1e-3f;
    config.effort_max           = 1.0f;
    config.travel               = TRIBO_EITHER(4.0f / 8192.0f, 4.0f);
    (void)TRIBO(joint, init)(&joint, &config);
    for (int32_t effort, q_ref, q, load; scanf("%d %d %d %d", &effort, &q_ref, &q, &load) == 4;)
    {
        TRIBO(joint, load)(&joint, force_of(load));
        (void)printf("%d\n", word_of(TRIBO(joint, step)(&joint, force_of(effort), force_of(q_ref), force_of(q))));
    }
}

int main(int count, char **arguments)
{
    if (count > 2 && strcmp(arguments[1], "axis") == 0)
    {
        play_axis(count - 2, &arguments[2]);
    }
    else
    {
        play_joint();
    }
    return 0;
}
