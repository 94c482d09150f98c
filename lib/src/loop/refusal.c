// Which number a set-up has refused. A set-up returns a status; to find an element of a list it is repeated here, with the list so
// far.

#include "tribo/force_loop_f32.h"
#include "tribo/force_loop_q31.h"
#include "tribo/parameters.h"
#include "tribo/status.h"

#include "../number/ieee_f32.h"
#include "prepare.h"

#include <stdbool.h>
#include <stddef.h>

typedef tribo_status_t (*set_up_t)(const tribo_force_loop_f32_config_t *config, float full_scale_n);

static tribo_status_t set_up_f32(const tribo_force_loop_f32_config_t *config, float full_scale_n)
{
    tribo_force_loop_f32_params_t params;
    (void)full_scale_n;
    return tribo_force_loop_f32_prepare(&params, config);
}

static tribo_status_t set_up_q31(const tribo_force_loop_f32_config_t *config, float full_scale_n)
{
    tribo_force_loop_q31_params_t       params;
    tribo_breakaway_point_q31_t         table[TRIBO_BREAKAWAY_POINTS_MAX];
    const tribo_force_loop_q31_config_t whole = {.loop = *config, .full_scale_n = full_scale_n, .table = table};
    return tribo_force_loop_q31_prepare(&params, &whole, NULL);
}

// The numbers of a section and then of a point, in the order of their structs.
#define SECTION_NUMBERS                                       5u
#define RANGE(symbol, member, key, unit, low, high, sentence) {(float)(low), (float)(high)},
static const float ranges[][2] = {TRIBO_SECTION_ELEMENTS(RANGE) TRIBO_POINT_ELEMENTS(RANGE)};

/// Which of them a status is about: the first from `first` to `last` that is out of its range, else the last.
static const struct
{
    uint8_t status, first, last;
    bool    of_all; ///< the elements together
} about[] = {{TRIBO_ERR_SECTION_COEFFICIENT, 0, 4, false},
             {TRIBO_ERR_SECTION_FEEDTHROUGH, 0, 0, false},
             {TRIBO_ERR_SECTION_UNSTABLE, 3, 3, false},
             {TRIBO_ERR_ANTI_WINDUP, 0, 0, true},
             {TRIBO_ERR_HEADROOM, 0, 0, true},
             {TRIBO_ERR_TABLE_FORCE, 5, 5, false},
             {TRIBO_ERR_TABLE_POSITIVE, 6, 6, false},
             {TRIBO_ERR_TABLE_NEGATIVE, 7, 7, false}};

static tribo_refusal_t refusal_of(set_up_t                             set_up,
                                  tribo_status_t                       status,
                                  const tribo_force_loop_f32_config_t *config,
                                  float                                full_scale_n)
{
    const uint32_t rows = sizeof about / sizeof about[0];
    uint32_t       i    = rows;
    for (uint32_t row = 0; row < rows; row++)
    {
        i = about[row].status == (uint8_t)status ? row : i;
    }
    if (i == rows)
    {
        return (tribo_refusal_t){0};
    }
    tribo_force_loop_f32_config_t part     = *config;
    const bool                    in_table = about[i].first >= SECTION_NUMBERS;
    uint32_t *const count = in_table ? &part.compensator.friction.table_length : &part.controller.section_count;
    const uint32_t  all   = about[i].of_all ? 0u : *count;

    // The fewest elements that are refused likewise; the last of them is to blame.
    for (*count = 1; *count < all && set_up(&part, full_scale_n) != status; ++*count)
    {
    }
    const uint32_t     index = *count - 1u;
    const uint32_t     begin = in_table ? SECTION_NUMBERS : 0u;
    const float *const number =
        in_table ? &config->compensator.friction.table[index].force_n : &config->controller.sections[index].b0;

    uint32_t n = about[i].first;
    while (n < about[i].last && within(number[n - begin], ranges[n][0], ranges[n][1]))
    {
        n++;
    }
    return (tribo_refusal_t){index, n - begin, number[n - begin], ranges[n][0], ranges[n][1]};
}

tribo_refusal_t tribo_force_loop_f32_refusal(tribo_status_t status, const tribo_force_loop_f32_config_t *config)
{
    return refusal_of(set_up_f32, status, config, 0.0f);
}

tribo_refusal_t tribo_force_loop_q31_refusal(tribo_status_t                       status,
                                             const tribo_force_loop_f32_config_t *config,
                                             float                                full_scale_n)
{
    return refusal_of(set_up_q31, status, config, full_scale_n);
}
