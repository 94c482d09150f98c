// What is said of a refused list: the element, the number in it, its value and its range.

#include ARITH_HEADER
#include "unity.h"

#include <math.h>
#include <stddef.h>

static tribo_force_loop_f32_config_t config;
static tribo_biquad_f32_section_t    sections[TRIBO_BIQUAD_SECTIONS_MAX];
static tribo_breakaway_point_f32_t   points[3];
static tribo_refusal_t               refusal;

void setUp(void)
{
    config = tribo_force_loop_f32_paper();
    for (uint32_t i = 0; i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        sections[i] = config.controller.sections[i < 2u ? i : 0u];
    }
    points[0] = (tribo_breakaway_point_f32_t){0.0f, 0.01f, 0.01f};
    points[1] = (tribo_breakaway_point_f32_t){0.5f, 0.02f, 0.02f};
    points[2] = (tribo_breakaway_point_f32_t){1.0f, 0.03f, 0.03f};

    config.controller.sections          = sections;
    config.controller.section_count     = 3;
    config.controller.refusal           = &refusal;
    config.compensator.friction.refusal = &refusal;

    refusal                                  = (tribo_refusal_t){0};
    config.compensator.friction.table        = points;
    config.compensator.friction.table_length = 3;
}

/// `number` made `value` is refused with `status`, in place `member` of element `index`, for this range.
static void check(tribo_status_t status,
                  float         *number,
                  float          value,
                  uint32_t       index,
                  uint32_t       member,
                  float          low,
                  float          high)
{
    static loop_t loop;
    const float   good = *number;
    *number            = value;
    TEST_ASSERT_EQUAL_INT(status, loop_init(&loop, &config));
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(index, refusal.index, tribo_status_text(status));
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(member, refusal.member, tribo_status_text(status));
    TEST_ASSERT_TRUE_MESSAGE(isnan(value) ? isnan(refusal.value) : refusal.value == value, tribo_status_text(status));
    TEST_ASSERT_EQUAL_FLOAT_MESSAGE(low, refusal.low, tribo_status_text(status));
    TEST_ASSERT_EQUAL_FLOAT_MESSAGE(high, refusal.high, tribo_status_text(status));
    *number = good;
}

static void test_a_refused_section_is_reported_with_its_coefficient(void)
{
    check(TRIBO_ERR_SECTION_COEFFICIENT, &sections[0].b2, 2e6f, 0, 2, -1e6f, 1e6f);
    check(TRIBO_ERR_SECTION_COEFFICIENT, &sections[2].a2, NAN, 2, 4, -4.0f, 4.0f);
    check(TRIBO_ERR_SECTION_FEEDTHROUGH, &sections[1].b0, 0.0f, 1, 0, -1e6f, 1e6f);
    check(TRIBO_ERR_SECTION_UNSTABLE, &sections[2].a1, -1.0f, 2, 3, -4.0f, 4.0f);
}

static void test_a_refused_row_of_the_table_is_reported_with_its_number(void)
{
    check(TRIBO_ERR_TABLE_POSITIVE, &points[0].positive_n, 0.0f, 0, 1, 1e-6f, 1e6f);
    check(TRIBO_ERR_TABLE_NEGATIVE, &points[2].negative_n, -1.0f, 2, 2, 1e-6f, 1e6f);
    check(TRIBO_ERR_TABLE_FORCE, &points[0].force_n, NAN, 0, 0, 0.0f, 1e6f);
    check(TRIBO_ERR_TABLE_FORCE, &points[2].force_n, 0.5f, 2, 0, 0.0f, 1e6f); // not over the row before
#if TRIBO_IS_Q31
    check(TRIBO_ERR_TABLE_FORCE, &points[2].force_n, 2.5f, 2, 0, 0.0f, 1e6f); // over the full scale
    check(TRIBO_ERR_TABLE_POSITIVE, &points[1].positive_n, 2.5f, 1, 1, 1e-6f, 1e6f);
#endif
}

static void test_a_refused_cascade_is_reported_with_its_first_coefficient(void)
{
    // A double integrator whose zeros are on the unit circle, far from z = 1: no anti-windup stabilises it.
    sections[0]                     = (tribo_biquad_f32_section_t){1.0f, 2.0f, 2.0f, 1.0f, 0.0f};
    sections[1]                     = (tribo_biquad_f32_section_t){1.0f, 1.0f, 0.0f, 1.0f, 0.0f};
    config.controller.section_count = 2;
    check(TRIBO_ERR_ANTI_WINDUP, &sections[0].b0, 1.0f, 0, 0, -1e6f, 1e6f);
}

#if TRIBO_IS_Q31
static void test_a_refused_headroom_is_reported_with_its_first_coefficient(void)
{
    // A gain of 1e9, of two poles that zeros cancel.
    sections[0]                     = (tribo_biquad_f32_section_t){1e6f, 1e6f, 0.25e6f, 1.0f, 0.25f};
    sections[1]                     = (tribo_biquad_f32_section_t){1e3f, 1e3f, 0.25e3f, 1.0f, 0.25f};
    config.controller.section_count = 2;
    check(TRIBO_ERR_HEADROOM, &sections[0].b0, 1e6f, 0, 0, -1e6f, 1e6f);
}

/// In 28 bits its second pole is at z = 1 as well; the number said is the one that was given.
static void test_a_section_that_rounding_makes_unstable_is_said_with_its_coefficient(void)
{
    static loop_t loop;
    sections[0]                     = (tribo_biquad_f32_section_t){1.0f, 1.5f, 0.5f, 1e-9f, 0.0f};
    config.controller.section_count = 1;
    check(TRIBO_ERR_SECTION_UNSTABLE, &sections[0].a1, 1e-9f, 0, 3, -4.0f, 4.0f);
    config.controller.refusal = NULL;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SECTION_UNSTABLE, loop_init(&loop, &config));
}
#endif

static void test_a_status_of_no_list_has_no_number(void)
{
    static loop_t loop;
    config.gain = 3.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_GAIN, loop_init(&loop, &config));
    TEST_ASSERT_TRUE(refusal.value == 0.0f && refusal.low == 0.0f && refusal.high == 0.0f);
}

static void test_a_config_without_room_for_it_is_refused_likewise(void)
{
    static loop_t loop;
    config.controller.refusal           = NULL;
    config.compensator.friction.refusal = NULL;
    points[2].positive_n                = 0.0f;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_TABLE_POSITIVE, loop_init(&loop, &config));
    sections[2].b0 = NAN;
    TEST_ASSERT_EQUAL_INT(TRIBO_ERR_SECTION_COEFFICIENT, loop_init(&loop, &config));
}

#include "runners/test_refusal.inc" // main
