#include PARTS_HEADER
#include "random.h"
#include "unity.h"

#include <math.h>

static const tribo_biquad_f32_section_t three[] = {TRIBO_BIQUAD_F32(0.25, -0.3, 0.2, -1.2, 0.72),
                                                   TRIBO_BIQUAD_F32(1.5, -1.0, 0.1, -0.9, 0.1),
                                                   TRIBO_BIQUAD_F32(0.5, 0.5, 0.0, -0.5, 0.0)};

static cascade_t cascade;

static void init(cascade_t *x, const tribo_biquad_f32_section_t *sections, uint32_t count)
{
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, cascade_init(x, sections, count));
}

static double step(cascade_t *x, double input)
{
    const double y = cascade_output(x, input);
    cascade_advance(x, input, 0.0);
    return y;
}

/// A section (b0 + b1 z^-1 + b2 z^-2) / (1 + a1 z^-1 + a2 z^-2), direct form I in double.
typedef struct
{
    double b0, b1, b2, a1, a2;
    double x1, x2, y1, y2;
} direct_t;

static double direct_step(direct_t *s, double x)
{
    const double y = s->b0 * x + s->b1 * s->x1 + s->b2 * s->x2 - s->a1 * s->y1 - s->a2 * s->y2;
    s->x2          = s->x1;
    s->x1          = x;
    s->y2          = s->y1;
    s->y1          = y;
    return y;
}

static void test_biquad_is_the_section_of_its_coefficients_in_z(void)
{
    direct_t direct = {.b0 = 0.25, .b1 = -0.3, .b2 = 0.2, .a1 = -1.2, .a2 = 0.72};
    random_t r      = {1};
    init(&cascade, three, 1);
    for (int k = 0; k < 1000; k++)
    {
        const double x = (double)(float)random_between(&r, -1.0, 1.0);
        TEST_ASSERT_DOUBLE_WITHIN(2e-6, direct_step(&direct, x), step(&cascade, x));
    }
}

static void test_biquad_cascade_runs_its_sections_in_order(void)
{
    const tribo_biquad_f32_section_t section[] = {TRIBO_BIQUAD_F32(1.0, 0.0, 0.0, -0.5, 0.0),
                                                  TRIBO_BIQUAD_F32(2.0, -1.0, 0.0, 0.0, 0.0),
                                                  TRIBO_BIQUAD_F32(0.5, 0.5, 0.25, 0.0, 0.5),
                                                  TRIBO_BIQUAD_F32(-1.0, 0.0, 0.1, 0.2, 0.0)};
    for (uint32_t count = 1; count <= 4u; count++)
    {
        direct_t direct[] = {{.b0 = 1.0, .a1 = -0.5},
                             {.b0 = 2.0, .b1 = -1.0},
                             {.b0 = 0.5, .b1 = 0.5, .b2 = 0.25, .a2 = 0.5},
                             {.b0 = -1.0, .b2 = 0.1, .a1 = 0.2}};
        random_t r        = {2};
        init(&cascade, section, count);
        for (int k = 0; k < 1000; k++)
        {
            const double x = (double)(float)random_between(&r, -1.0, 1.0);
            double       y = x;
            for (uint32_t i = 0; i < count; i++)
            {
                y = direct_step(&direct[i], y);
            }
            TEST_ASSERT_DOUBLE_WITHIN(4e-6, y, step(&cascade, x));
        }
    }
}

static void test_biquad_advances_as_if_the_corrected_input_had_come(void)
{
    for (uint32_t count = 1; count <= 3u; count++)
    {
        static cascade_t corrected;
        init(&cascade, three, count);
        init(&corrected, three, count);
        for (int k = 0; k < 100; k++)
        {
            const double x          = 0.5 * sin(k * 0.1);
            const double correction = 0.4 * cos(k * 0.07);
            (void)cascade_output(&corrected, x);
            cascade_advance(&corrected, x, correction);
            (void)step(&cascade, x + correction);
            for (uint32_t i = 0; i < count; i++)
            {
                TEST_ASSERT_DOUBLE_WITHIN(CASCADE_ROUNDING, cascade_w1(&cascade, i), cascade_w1(&corrected, i));
            }
        }
    }
}

// --- change of params ----------------------------------------------------------------------------------------------

static void test_biquad_change_keeps_the_output_and_its_slope(void)
{
    const tribo_biquad_f32_section_t to_sections[] = {TRIBO_BIQUAD_F32(0.75, -0.3, 0.1, -1.1, 0.6),
                                                      TRIBO_BIQUAD_F32(2.5, -2.0, 0.3, -0.7, 0.2)};
    static cascade_t                 to;
    init(&cascade, three, 2);
    init(&to, to_sections, 2);
    for (int k = 0; k < 50; k++)
    {
        (void)step(&cascade, sin(k * 0.1));
    }
    cascade_t old = cascade;
    cascade_change(&cascade, &to, 0.7, 0.25);
    const cascade_t old_before = old;
    const cascade_t new_before = cascade;
    TEST_ASSERT_DOUBLE_WITHIN(CASCADE_ROUNDING, step(&old, 0.7) + 0.25, step(&cascade, 0.7));
    for (uint32_t i = 0; i < 2u; i++)
    {
        // With its input standing, an output changes as its w1 does.
        TEST_ASSERT_DOUBLE_WITHIN(CASCADE_ROUNDING,
                                  cascade_w1(&old, i) - cascade_w1(&old_before, i),
                                  cascade_w1(&cascade, i) - cascade_w1(&new_before, i));
    }
}

static void test_biquad_change_to_the_same_params_changes_nothing_to_see(void)
{
    init(&cascade, three, 2);
    for (int k = 0; k < 50; k++)
    {
        (void)step(&cascade, sin(k * 0.1));
    }
    cascade_t       plain = cascade;
    const cascade_t same  = cascade;
    cascade_change(&cascade, &same, 0.7, 0.0);
    for (int k = 0; k < 200; k++)
    {
        const double x = cos(k * 0.1);
        TEST_ASSERT_DOUBLE_WITHIN(2e-6, step(&plain, x), step(&cascade, x));
    }
}

static void test_biquad_change_takes_another_number_of_sections(void)
{
    for (uint32_t from_count = 1; from_count <= 3u; from_count++)
    {
        for (uint32_t to_count = 1; to_count <= 3u; to_count++)
        {
            static cascade_t to;
            init(&cascade, three, from_count);
            init(&to, three, to_count);
            for (int k = 0; k < 50; k++)
            {
                (void)step(&cascade, 0.3 * sin(k * 0.1));
            }
            cascade_t old = cascade;
            cascade_change(&cascade, &to, 0.2, 0.0);
            const double after = cascade_output(&cascade, 0.2);
            TEST_ASSERT_DOUBLE_WITHIN(2e-6, step(&old, 0.2), after);
            if (to_count > from_count)
            {
                // The last section is new: it stands still for one more sample, its input standing.
                const double w1 = cascade_w1(&cascade, to_count - 1u);
                cascade_advance(&cascade, 0.2, 0.0);
                TEST_ASSERT_DOUBLE_WITHIN(CASCADE_ROUNDING, w1, cascade_w1(&cascade, to_count - 1u));
            }
        }
    }
}

#include "runners/test_biquad.inc" // main
