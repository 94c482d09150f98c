#include "app/params.h"

#include "app/crc32.h"

#include "tribo/paper_controller.h"

#include <stddef.h>
#include <string.h>

// --- the lists -----------------------------------------------------------------------------------------------------

/// A parameter table of the library, and the offset of its config in tribo_loop_parts_t.
typedef struct
{
    const tribo_parameter_t *rows;
    uint16_t                 count, at;
} group_t;

#define GROUP(rows, config_) {(rows), sizeof(rows) / sizeof((rows)[0]), offsetof(tribo_loop_parts_t, config_)}

static const group_t groups[] = {
    GROUP(tribo_loop_parameters, config),
    GROUP(tribo_limit_parameters, config.controller),
    GROUP(tribo_cascade_parameters, config.controller),
    GROUP(tribo_friction_parameters, config.compensator.friction),
    GROUP(tribo_breakaway_parameters, config.compensator.friction),
    GROUP(tribo_table_parameters, config.compensator.friction),
    GROUP(tribo_arm_parameters, config.compensator.arm),
#if DRIVE_FEEDFORWARD
    GROUP(tribo_feedforward_parameters, feedforward),
    GROUP(tribo_sensorless_parameters, sensorless),
    GROUP(tribo_guard_parameters, guard),
#endif
};

/// Finds the n-th row of all groups, its word in a set and its offset in tribo_loop_parts_t. Returns false beyond the last row.
static bool find_row(uint32_t n, const tribo_parameter_t **row, uint32_t *word, size_t *at)
{
    for (size_t i = 0; i < sizeof groups / sizeof groups[0]; i++)
    {
        if (n < groups[i].count)
        {
            *row  = &groups[i].rows[n];
            *word = PARAMS_WORD((*row)->number);
            *at   = (size_t)groups[i].at + (*row)->at;
            return true;
        }
        n -= groups[i].count;
    }
    return false;
}

uint32_t params_word(const params_set_t *set, uint32_t word)
{
    uint32_t bits;
    memcpy(&bits, (const unsigned char *)set + word * sizeof bits, sizeof bits);
    return bits;
}

float params_number(const params_set_t *set, uint32_t word)
{
    const uint32_t bits = params_word(set, word);
    float          number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

static void put(params_set_t *set, uint32_t word, const void *bits)
{
    memcpy((unsigned char *)set + word * sizeof(uint32_t), bits, sizeof(uint32_t));
}

#if DRIVE_FEEDFORWARD
/// The rig's poles: their words in the residual's model and in the feed-forward.
static const struct
{
    uint8_t residual, feed;
} poles[] = {{DRIVE_CONFIG_actuator_pole_rad_per_s, PARAMS_ACTUATOR_POLE},
             {DRIVE_CONFIG_sensor_pole_rad_per_s, PARAMS_SENSOR_POLE}};

static void copy_pole(params_set_t *set, uint32_t from, uint32_t to)
{
    const uint32_t pole = params_word(set, from);
    put(set, to, &pole);
}
#endif

params_set_t params_default_of(const drive_config_t *config)
{
    static const tribo_biquad_f32_section_t paper[TRIBO_PAPER_CONTROLLER_SECTION_COUNT] = TRIBO_PAPER_CONTROLLER_F32;

    params_set_t set = {.drive = *config};
#if DRIVE_FEEDFORWARD
    set.method   = PARAMS_METHOD_FEEDFORWARD;
    set.guard_on = 1u;
#endif
    const tribo_parameter_t *row;
    uint32_t                 word;
    size_t                   at;
    for (uint32_t n = 0; find_row(n, &row, &word, &at); n++)
    {
        const uint32_t whole = row->is_whole != 0u ? (uint32_t)row->standard : 0u;
        put(&set, word, row->is_whole != 0u ? (const void *)&whole : (const void *)&row->standard);
    }
    memcpy(set.sections, paper, sizeof paper);
#if DRIVE_FEEDFORWARD
    for (size_t i = 0; i < sizeof poles / sizeof poles[0]; i++)
    {
        copy_pole(&set, poles[i].residual, poles[i].feed);
    }
#endif
    return set;
}

params_set_t params_default(void)
{
    const drive_config_t config = drive_config_default();
    return params_default_of(&config);
}

// --- refusals ------------------------------------------------------------------------------------------------------

static bool refuse(params_error_t *error, uint32_t word, float value, float low, float high, tribo_status_t status)
{
    *error = (params_error_t){word, value, low, high, status};
    return false;
}

static bool refuse_row(params_error_t *error, const params_set_t *set, const tribo_parameter_t *row, uint32_t word)
{
    const float value = row->is_whole != 0u ? (float)params_word(set, word) : params_number(set, word);
    return refuse(error, word, value, row->low, row->high, (tribo_status_t)row->status);
}

/// Returns the row of a word. Null for a word of `drive`, a section or the table, the method or guard.on, which have no row.
static const tribo_parameter_t *row_of(uint32_t word)
{
    const tribo_parameter_t *row;
    uint32_t                 of_row;
    size_t                   at;
    for (uint32_t n = 0; find_row(n, &row, &of_row, &at); n++)
    {
        if (of_row == word)
        {
            return row;
        }
    }
    return NULL;
}

bool params_is_number(uint32_t word)
{
    if (word < (uint32_t)DRIVE_CONFIG_COUNT)
    {
        return drive_config_fields[word].is_float;
    }
    const tribo_parameter_t *row = row_of(word);
    return row != NULL ? row->is_whole == 0u : word >= (uint32_t)PARAMS_SECTIONS_AT;
}

float params_least(uint32_t word)
{
    return word >= (uint32_t)PARAMS_SECTIONS_AT ? 1e-20f : 1e-15f;
}

static float highest(uint32_t word)
{
    const tribo_parameter_t *row = row_of(word);
    return word < (uint32_t)DRIVE_CONFIG_COUNT ? drive_config_fields[word].high : row != NULL ? row->high : 1e6f;
}

/// Refuses numbers that no one can mean (params_is_meant), which may nevertheless be within their range.
static bool check_sizes(params_error_t *error, const params_set_t *set)
{
    for (uint32_t word = 0; word < PARAMS_WORDS; word++)
    {
        const float least = params_least(word);
        // params_is_number comes last, because it searches all rows.
        if (!params_is_meant(params_word(set, word), least) && params_is_number(word))
        {
            return refuse(error, word, params_number(set, word), least, highest(word), TRIBO_OK);
        }
    }
    return true;
}

/// Checks the ranges of all rows, including those that this method does not use.
static bool check_ranges(params_error_t *error, const params_set_t *set)
{
    const tribo_parameter_t *row;
    uint32_t                 word;
    size_t                   at;
    for (uint32_t n = 0; find_row(n, &row, &word, &at); n++)
    {
        (void)refuse_row(error, set, row, word);
        if (!(error->value >= row->low && error->value <= row->high))
        {
            return false;
        }
    }
    if (set->method > PARAMS_METHOD_MAX)
    {
        return refuse(error, PARAMS_METHOD_AT, (float)set->method, PARAMS_METHOD_PAPER, PARAMS_METHOD_MAX, TRIBO_OK);
    }
#if DRIVE_FEEDFORWARD
    if (set->guard_on > 1u)
    {
        return refuse(error, PARAMS_GUARD_AT, (float)set->guard_on, 0.0f, 1.0f, TRIBO_OK);
    }
#endif
    return true;
}

// --- words that protect ---------------------------------------------------------------------------------------------

static float value_of(const params_set_t *set, uint32_t word)
{
    return word < (uint32_t)DRIVE_CONFIG_COUNT ? drive_config_value(&set->drive, word) : params_number(set, word);
}

bool params_check_ceilings(const params_set_t     *set,
                           const params_ceiling_t *ceilings,
                           uint32_t                count,
                           params_error_t         *error)
{
    for (uint32_t i = 0; i < count; i++)
    {
        const float value = value_of(set, ceilings[i].word);
        if (!(value >= ceilings[i].low && value <= ceilings[i].high))
        {
            return refuse(error, ceilings[i].word, value, ceilings[i].low, ceilings[i].high, TRIBO_OK);
        }
    }
    return true;
}

static bool refuse_change(params_error_t *error, const params_set_t *set, const params_set_t *like, uint32_t word)
{
    const float right = value_of(like, word);
    return refuse(error, word, value_of(set, word), right, right, TRIBO_OK);
}

bool params_check_method(const params_set_t *set, const params_set_t *of_board, params_error_t *error)
{
    const bool     is_blind = of_board->method == PARAMS_METHOD_SENSORLESS;
    const uint32_t most     = PARAMS_METHOD_MAX < PARAMS_METHOD_OFF ? PARAMS_METHOD_MAX : PARAMS_METHOD_OFF;
    const uint32_t low      = is_blind ? PARAMS_METHOD_SENSORLESS : PARAMS_METHOD_PAPER;
    const uint32_t high     = is_blind ? PARAMS_METHOD_SENSORLESS : most;
    return (set->method >= low && set->method <= high) ||
           refuse(error, PARAMS_METHOD_AT, (float)set->method, (float)low, (float)high, TRIBO_OK);
}

bool params_check_wiring(const params_set_t *set, const params_set_t *of_board, params_error_t *error)
{
    for (uint32_t word = 0; word < (uint32_t)DRIVE_CONFIG_COUNT; word++)
    {
        if (drive_config_fields[word].wired && params_word(set, word) != params_word(of_board, word))
        {
            return refuse_change(error, set, of_board, word);
        }
    }
    return true;
}

// A bit for each word of the loop that protects. No word of the feed-forward or the guard does.
#define PROTECTING(group, symbol, member, key, unit, low, high, standard, change, number, ...)                         \
    | (uint32_t)TRIBO_##change << ((number) - PARAMS_LOOP_NUMBER) / 2u
#define IS_PROTECTING(group, symbol, member, key, unit, low, high, standard, change, ...) | TRIBO_##change
_Static_assert(PARAMS_LOOP_COUNT <= 32 && (0 PARAMS_FEED_ROWS(IS_PROTECTING) PARAMS_GUARD_ROWS(IS_PROTECTING)) == 0,
               "only words of the loop protect, and they fit into 32 bits");
static const uint32_t protecting = 0u PARAMS_LOOP_ROWS(PROTECTING);
#undef IS_PROTECTING
#undef PROTECTING

uint32_t params_next_protecting(uint32_t *place)
{
    while (*place < (uint32_t)PARAMS_METHOD_AT)
    {
        const uint32_t word = (*place)++;
        if (word < (uint32_t)DRIVE_CONFIG_COUNT || (protecting >> (word - (uint32_t)PARAMS_LOOP_AT) & 1u) != 0u)
        {
            return word;
        }
    }
    return PARAMS_WORDS;
}

static int32_t sign_of(float x)
{
    return (x > 0.0f) - (x < 0.0f);
}

/// Finds the signs of u after a step of e: `at_once`, from b0 of each section, and `in_the_end`, from b2 of each in delta
/// form. The output of a section without b2 ends at 0, approached from the side of its b1, or of b0 if b1 is 0 as well.
static void find_signs(const params_set_t *set, int32_t *at_once, int32_t *in_the_end)
{
    const uint32_t count = params_word(set, PARAMS_SECTION_COUNT);
    *at_once = *in_the_end = 1;
    for (uint32_t i = 0; i < count && i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        const tribo_biquad_f32_section_t *section = &set->sections[i];
        const float last = section->b2 != 0.0f ? section->b2 : section->b1 != 0.0f ? section->b1 : section->b0;
        *at_once *= sign_of(section->b0);
        *in_the_end *= sign_of(last);
    }
}

uint32_t params_protection(const params_set_t *set)
{
    uint32_t crc   = 0;
    uint32_t place = 0;
    for (uint32_t word = params_next_protecting(&place); word < PARAMS_WORDS; word = params_next_protecting(&place))
    {
        const uint32_t bits = params_word(set, word);
        crc                 = crc32_update(crc, &bits, sizeof bits);
    }
    int32_t signs[2];
    find_signs(set, &signs[0], &signs[1]);
    return crc32_update(crc, signs, sizeof signs);
}

bool params_signs_alike(const params_set_t *set, const params_set_t *like, params_error_t *error)
{
    int32_t at_once, in_the_end, at_once_like, in_the_end_like;
    find_signs(set, &at_once, &in_the_end);
    find_signs(like, &at_once_like, &in_the_end_like);
    return (at_once == at_once_like || refuse_change(error, set, like, PARAMS_SECTIONS_AT)) &&
           (in_the_end == in_the_end_like || refuse_change(error, set, like, PARAMS_SECTIONS_AT + 2u));
}

bool params_protect_alike(const params_set_t *set, const params_set_t *like, params_error_t *error)
{
    uint32_t place = 0;
    for (uint32_t word = params_next_protecting(&place); word < PARAMS_WORDS; word = params_next_protecting(&place))
    {
        if (params_word(set, word) != params_word(like, word))
        {
            return refuse_change(error, set, like, word);
        }
    }
    return params_signs_alike(set, like, error);
}

// --- params --------------------------------------------------------------------------------------------------------

static tribo_loop_parts_t parts_of(const params_set_t *set)
{
    tribo_loop_parts_t             parts    = {.feeds_forward = false};
    tribo_force_loop_f32_config_t *config   = &parts.config;
    tribo_friction_f32_config_t   *friction = &config->compensator.friction;
    const tribo_parameter_t       *row;
    uint32_t                       word;
    size_t                         at;
    for (uint32_t n = 0; find_row(n, &row, &word, &at); n++)
    {
        const uint32_t bits = params_word(set, word);
        memcpy((unsigned char *)&parts + at, &bits, sizeof bits);
    }
    config->controller.sections = set->sections;
    friction->table             = friction->table_length > 0u ? set->table : NULL;
    return parts;
}

/// Returns whether `loop` has the part in which its byte `at` is.
static bool has_part(const tribo_loop_parts_t *loop, size_t at)
{
    return at >= offsetof(tribo_loop_parts_t, guard)         ? loop->guarded
           : at >= offsetof(tribo_loop_parts_t, sensorless)  ? loop->is_sensorless
           : at >= offsetof(tribo_loop_parts_t, feedforward) ? loop->feeds_forward
                                                             : true;
}

/// Leaves out sections or points beyond those that fit; their count is refused later.
void params_take_loop(params_set_t *set, const tribo_loop_parts_t *loop)
{
    const tribo_controller_f32_config_t *controller = &loop->config.controller;
    const tribo_friction_f32_config_t   *friction   = &loop->config.compensator.friction;
    const tribo_parameter_t             *row;
    uint32_t                             word;
    size_t                               at;
    for (uint32_t n = 0; find_row(n, &row, &word, &at); n++)
    {
        if (has_part(loop, at))
        {
            put(set, word, (const unsigned char *)loop + at);
        }
    }
    set->method = loop->is_sensorless   ? PARAMS_METHOD_SENSORLESS
                  : loop->feeds_forward ? PARAMS_METHOD_FEEDFORWARD
                                        : PARAMS_METHOD_PAPER;
#if DRIVE_FEEDFORWARD
    set->guard_on = loop->guarded ? 1u : 0u;
    for (size_t i = 0; loop->feeds_forward && i < sizeof poles / sizeof poles[0]; i++)
    {
        copy_pole(set, poles[i].feed, poles[i].residual);
    }
#endif
    for (uint32_t i = 0; i < controller->section_count && i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        set->sections[i] = controller->sections[i];
    }
    for (uint32_t i = 0; friction->table != NULL && i < friction->table_length && i < TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
        set->table[i] = friction->table[i];
    }
}

#if DRIVE_FEEDFORWARD
/// There is always a guard. Of one that is off only fade_time_s counts, within which the fade of an earlier guard ends. Its other
/// fields get values that are never refused.
static tribo_status_t set_up_loop(params_t *params, tribo_loop_parts_t *parts)
{
    const params_set_t       *set   = &params->set;
    tribo_guard_f32_config_t *guard = &parts->guard;
    const float               h     = parts->config.sample_time_s;

    parts->is_sensorless = set->method == PARAMS_METHOD_SENSORLESS;
    parts->feeds_forward = parts->is_sensorless || set->method == PARAMS_METHOD_FEEDFORWARD;
    parts->guarded       = true;
    const bool is_on     = set->guard_on != 0u && !parts->is_sensorless; // a guard judges y
    if (!is_on)
    {
        guard->turn_n       = TRIBO_EITHER(1.0f, 0.5f * set->drive.full_scale_n);
        guard->stray_n      = guard->turn_n;
        guard->quick_time_s = h;
        guard->fade_time_s  = guard->fade_time_s > 1e6f * h ? 1e6f * h : guard->fade_time_s;
    }
    if (set->method == PARAMS_METHOD_OFF)
    {
        parts->config.gain = 0.0f;
    }
    const tribo_force_loop_f32_config_t whole =
        tribo_loop_with_parts(parts, &params->loop.feedforward, &params->loop.guard);
    const tribo_status_t status = loop_setup(&params->loop, &whole, set->drive.full_scale_n);
    params->loop.guard.on       = is_on;
    return status;
}
#else
static tribo_status_t set_up_loop(params_t *params, const tribo_loop_parts_t *parts)
{
    return loop_setup(&params->loop, &parts->config, params->set.drive.full_scale_n);
}
#endif

/// Translates a refusal of the library. If several parameters are wrong only together, it names the inertia; for the whole
/// cascade it names the first coefficient.
static bool refuse_loop(params_error_t                      *error,
                        const params_t                      *params,
                        const tribo_force_loop_f32_config_t *config,
                        tribo_status_t                       status,
                        const tribo_refusal_t               *refusal)
{
    const tribo_status_t     named = status == TRIBO_ERR_ARM_TOO_FAST ? TRIBO_ERR_INERTIA : status;
    const tribo_parameter_t *row;
    uint32_t                 word;
    size_t                   at;
    for (uint32_t n = 0; find_row(n, &row, &word, &at); n++)
    {
        if (row->status == (uint8_t)named)
        {
            (void)refuse_row(error, &params->set, row, word);
            error->status = status;
            return false;
        }
    }
    const float full_scale_n = params->set.drive.full_scale_n;
    if (status == TRIBO_ERR_FULL_SCALE)
    {
        return refuse(error, DRIVE_CONFIG_full_scale_n, full_scale_n, 1e-3f, 1e6f, status);
    }
    if (status == TRIBO_ERR_PAPER_SAMPLE_TIME)
    {
        const float only_s = TRIBO_PAPER_CONTROLLER_SAMPLE_TIME_S;
        return refuse(error, PARAMS_SAMPLE_TIME, config->sample_time_s, only_s, only_s, status);
    }
    const bool of_table = status >= TRIBO_ERR_TABLE_FORCE && status <= TRIBO_ERR_TABLE_NEGATIVE;
    word                = of_table ? PARAMS_TABLE_AT + 3u * refusal->index : PARAMS_SECTIONS_AT + 5u * refusal->index;
    return refuse(error, word + refusal->member, refusal->value, refusal->low, refusal->high, status);
}

bool params_make(params_t *params, const port_t *port, params_error_t *error)
{
    const params_set_t *set                   = &params->set;
    tribo_refusal_t     refusal               = {0};
    tribo_loop_parts_t  parts                 = parts_of(set);
    parts.config.controller.pause             = port->pause;
    parts.config.controller.refusal           = &refusal;
    parts.config.compensator.friction.refusal = &refusal;
    if (!check_sizes(error, set) || !check_ranges(error, set))
    {
        return false;
    }
    const tribo_status_t status = set_up_loop(params, &parts);
    if (status != TRIBO_OK)
    {
        return refuse_loop(error, params, &parts.config, status, &refusal);
    }
    const float sample_us = 1e6f * parts.config.sample_time_s;
    const float period_us = (float)set->drive.period_us;

    const drive_config_field_t *const period = &drive_config_fields[DRIVE_CONFIG_period_us];
    if (!(period_us >= period->low && period_us <= period->high)) // otherwise the sample time would have to equal it
    {
        return refuse(error, DRIVE_CONFIG_period_us, period_us, period->low, period->high, TRIBO_OK);
    }
    if (!(sample_us >= period_us - 0.51f &&
          sample_us <= period_us + 0.51f)) // a period is a whole number of microseconds
    {
        const float period_s = period_us / 1e6f;
        return refuse(error, PARAMS_SAMPLE_TIME, parts.config.sample_time_s, period_s, period_s, TRIBO_OK);
    }
    drive_config_error_t by_drive;
    if (!drive_setup_init(&params->drive, &set->drive, &params->loop.params, port, &by_drive))
    {
        return refuse(error, by_drive.field, by_drive.value, by_drive.low, by_drive.high, TRIBO_OK);
    }
    return true;
}
