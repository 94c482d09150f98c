#include "app/params.h"

#include "tribo/paper_controller.h"

#include <stddef.h>
#include <string.h>

params_set_t params_default(void)
{
    static const tribo_biquad_f32_section_t paper[TRIBO_PAPER_CONTROLLER_SECTION_COUNT] = TRIBO_PAPER_CONTROLLER_F32;
#define DEFAULT(type, symbol, member, name, unit, low, high, normal, status, text) .symbol = (normal),
    static const params_loop_t loop = {PARAMS_LOOP_FIELDS(DEFAULT)};
    params_set_t               set  = {.drive = drive_config_default(), .loop = loop};
#if DRIVE_FEEDFORWARD
    static const params_feed_t  feed  = {PARAMS_FEED_FIELDS(DEFAULT)};
    static const params_guard_t guard = {PARAMS_GUARD_FIELDS(DEFAULT)};
    set.feed                          = feed;
    set.guard                         = guard;
#endif
#undef DEFAULT
    memcpy(set.sections, paper, sizeof paper);
    return set;
}

// --- refusals ------------------------------------------------------------------------------------------------------

/// What a refusal is about, of a list its first word, and the range. The fields of the loop come first.
typedef struct
{
    uint8_t status, word;
    float   low, high;
} refusal_t;

static const refusal_t refusals[] = {
#define FIELD(type, symbol, member, name, unit, low, high, normal, status, text)                                       \
    {TRIBO_ERR_##status, (uint8_t)(PARAMS_LOOP_AT + (int)PARAMS_##symbol), (float)(low), (float)(high)},
    PARAMS_LOOP_FIELDS(FIELD)
#undef FIELD
#define FIELD(type, symbol, member, name, unit, low, high, normal, status, text)                                       \
    {TRIBO_ERR_##status, (uint8_t)(PARAMS_FEED_AT + PARAMS_FEED_##symbol), (float)(low), (float)(high)},
        PARAMS_FEED_FIELDS(FIELD)
#undef FIELD
#if DRIVE_FEEDFORWARD
#define FIELD(type, symbol, member, name, unit, low, high, normal, status, text)                                       \
    {TRIBO_ERR_##status, (uint8_t)(PARAMS_GUARD_AT + PARAMS_GUARD_##symbol), (float)(low), (float)(high)},
            PARAMS_GUARD_FIELDS(FIELD)
#undef FIELD
                {TRIBO_OK, PARAMS_GUARD_AT + PARAMS_GUARD_on, 0.0f, 1.0f},
#endif
    {TRIBO_OK, PARAMS_METHOD_AT, PARAMS_METHOD_PAPER, PARAMS_METHOD_MAX},
    {TRIBO_ERR_SECTION_COEFFICIENT, PARAMS_SECTIONS_AT, -1e6f, 1e6f},
    {TRIBO_ERR_SECTION_FEEDTHROUGH, PARAMS_SECTIONS_AT, -1e6f, 1e6f},
    {TRIBO_ERR_SECTION_UNSTABLE, PARAMS_SECTIONS_AT + 3, -4.0f, 4.0f},
    {TRIBO_ERR_ANTI_WINDUP, PARAMS_SECTIONS_AT, -1e6f, 1e6f},
    {TRIBO_ERR_HEADROOM, PARAMS_SECTIONS_AT, -1e6f, 1e6f},
    {TRIBO_ERR_TABLE_FORCE, PARAMS_TABLE_AT, 0.0f, 1e6f},
    {TRIBO_ERR_TABLE_BREAKAWAY, PARAMS_TABLE_AT + 1, 1e-6f, 1e6f},
    {TRIBO_ERR_ARM_TOO_FAST, (uint8_t)(PARAMS_LOOP_AT + PARAMS_inertia), 1e-12f, 1e12f},
    {TRIBO_ERR_FULL_SCALE, DRIVE_CONFIG_full_scale_n, 1e-3f, 1e6f},
};

static float number_of(const params_set_t *set, uint32_t word)
{
    uint32_t bits;
    float    number;
    memcpy(&bits, (const unsigned char *)set + word * sizeof bits, sizeof bits);
    memcpy(&number, &bits, sizeof number);
    const bool whole = word < (uint32_t)PARAMS_LOOP_AT
                           ? !drive_config_fields[word].is_float
                           : word == (uint32_t)PARAMS_METHOD_AT ||
                                 (PARAMS_GUARD_COUNT > 0 && word == (uint32_t)PARAMS_GUARD_AT) ||
                                 word == (uint32_t)PARAMS_LOOP_AT + PARAMS_section_count ||
                                 word == (uint32_t)PARAMS_LOOP_AT + PARAMS_table_length;
    return whole ? (float)bits : number;
}

static bool is_within(const refusal_t *refusal, float value)
{
    return value >= refusal->low && value <= refusal->high;
}

static bool refuse(params_error_t *error, const params_set_t *set, const refusal_t *refusal, tribo_status_t status)
{
    *error = (params_error_t){refusal->word, number_of(set, refusal->word), refusal->low, refusal->high, status};
    return false;
}

/// The ranges of the list, which in places are narrower than the library's.
static bool check_ranges(params_error_t *error, const params_set_t *set)
{
    for (size_t i = 0; i < PARAMS_LOOP_COUNT + PARAMS_FEED_COUNT + PARAMS_GUARD_COUNT + 1u; i++)
    {
        if (!is_within(&refusals[i], number_of(set, refusals[i].word)))
        {
            return refuse(error, set, &refusals[i], (tribo_status_t)refusals[i].status);
        }
    }
    return true;
}

static bool refuse_loop(params_error_t *error, const params_set_t *set, tribo_status_t status)
{
    size_t i = 0;
    while (i + 1u < sizeof refusals / sizeof refusals[0] && refusals[i].status != (uint8_t)status)
    {
        i++;
    }
    return refuse(error, set, &refusals[i], status);
}

// --- params --------------------------------------------------------------------------------------------------------

static tribo_force_loop_f32_config_t config_of(const params_set_t *set)
{
    tribo_force_loop_f32_config_t config = {.gain = 0.0f};
#define COPY(type, symbol, member, name, unit, low, high, normal, status, text) config.member = set->loop.symbol;
    PARAMS_LOOP_FIELDS(COPY)
#undef COPY
    config.controller.sections        = set->sections;
    config.compensator.friction.table = set->loop.table_length > 0u ? set->table : NULL;
    return config;
}

/// More sections or points than fit are left out, and the count is refused.
void params_take_loop(params_set_t                         *set,
                      const tribo_force_loop_f32_config_t  *config,
                      const tribo_feedforward_f32_config_t *feedforward)
{
    const tribo_friction_f32_config_t *friction = &config->compensator.friction;
#define TAKE(type, symbol, member, name, unit, low, high, normal, status, text) set->loop.symbol = config->member;
    PARAMS_LOOP_FIELDS(TAKE)
#undef TAKE
    set->method = feedforward != NULL ? PARAMS_METHOD_FEEDFORWARD : PARAMS_METHOD_PAPER;
#if DRIVE_FEEDFORWARD
    if (feedforward != NULL)
    {
#define TAKE(type, symbol, member, name, unit, low, high, normal, status, text) set->feed.symbol = feedforward->member;
        PARAMS_FEED_FIELDS(TAKE)
#undef TAKE
    }
#endif
    for (uint32_t i = 0; i < config->controller.section_count && i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        set->sections[i] = config->controller.sections[i];
    }
    for (uint32_t i = 0; friction->table != NULL && i < friction->table_length && i < TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
        set->table[i] = friction->table[i];
    }
}

#if DRIVE_FEEDFORWARD
void params_take_guard(params_set_t *set, const tribo_guard_f32_config_t *config)
{
    set->guard.on = config != NULL ? 1u : 0u;
    if (config != NULL)
    {
#define TAKE(type, symbol, member, name, unit, low, high, normal, status, text) set->guard.symbol = config->member;
        PARAMS_GUARD_FIELDS(TAKE)
#undef TAKE
    }
}

static tribo_status_t set_up_guard(params_t *params)
{
    const params_set_t      *set = &params->set;
    tribo_guard_f32_config_t config;
#define COPY(type, symbol, member, name, unit, low, high, normal, status, text) config.member = set->guard.symbol;
    PARAMS_GUARD_FIELDS(COPY)
#undef COPY
    if (set->guard.on == 0u) // only fade_time_s counts, within which an earlier guard's share comes back
    {
        config.turn_n       = 0.5f * set->loop.input_max;
        config.stray_n      = 0.5f * set->loop.input_max;
        config.quick_time_s = set->loop.sample_time;
    }
    const tribo_status_t status =
        loop_setup_guard(&params->loop.guard, &config, set->loop.sample_time, set->drive.full_scale_n);
    params->loop.guard.on = set->guard.on != 0u;
    return status;
}
#endif

static tribo_status_t set_up_loop(params_t *params, const tribo_force_loop_f32_config_t *config)
{
    const params_set_t *set = &params->set;
#if DRIVE_FEEDFORWARD
    if (set->method == PARAMS_METHOD_FEEDFORWARD)
    {
        tribo_feedforward_f32_config_t feedforward;
#define COPY(type, symbol, member, name, unit, low, high, normal, status, text) feedforward.member = set->feed.symbol;
        PARAMS_FEED_FIELDS(COPY)
#undef COPY
        return loop_setup_feedforward(&params->loop, config, &feedforward, set->drive.full_scale_n);
    }
    if (set->method == PARAMS_METHOD_OFF)
    {
        tribo_force_loop_f32_config_t off = *config;
        off.gain                          = 0.0f;
        return loop_setup(&params->loop, &off, set->drive.full_scale_n);
    }
#endif
    return loop_setup(&params->loop, config, set->drive.full_scale_n);
}

bool params_make(params_t *params, const port_t *port, params_error_t *error)
{
    const params_set_t                 *set    = &params->set;
    const tribo_force_loop_f32_config_t config = config_of(set);
    if (!check_ranges(error, set))
    {
        return false;
    }
    tribo_status_t status = set_up_loop(params, &config);
#if DRIVE_FEEDFORWARD
    if (status == TRIBO_OK)
    {
        status = set_up_guard(params);
    }
#endif
    if (status != TRIBO_OK)
    {
        return refuse_loop(error, set, status);
    }
    const float sample_us = 1e6f * set->loop.sample_time;
    const float period_us = (float)set->drive.period_us;
    if (!(sample_us >= period_us - 0.51f &&
          sample_us <= period_us + 0.51f)) // a period is a whole number of microseconds
    {
        const float period_s = period_us / 1e6f;
        *error =
            (params_error_t){PARAMS_LOOP_AT + PARAMS_sample_time, set->loop.sample_time, period_s, period_s, TRIBO_OK};
        return false;
    }
    drive_config_error_t by_drive;
    if (!drive_setup_init(&params->drive, &set->drive, &params->loop.params, port, &by_drive))
    {
        *error = (params_error_t){by_drive.field, by_drive.value, by_drive.low, by_drive.high, TRIBO_OK};
        return false;
    }
#if DRIVE_FEEDFORWARD
    params->drive.guard = &params->loop.guard;
#endif
    return true;
}
