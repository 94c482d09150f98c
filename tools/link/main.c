// tribo-link: a drive on a serial line, for a person. Registers by name (list.h), over Modbus RTU by libmodbus.

#include "app/registers.h"
#include "bus.h"
#include "find.h"
#include "keys/table.h"
#include "loop/loop_check.h"
#include "loop/loop_config.h"
#include "serve.h"
#include "status.h"
#include "support/clock.h"
#include "support/number.h"
#include "support/options.h"
#include "support/output_file.h"

#include "tribo/status.h"

#include <argp.h>
#include <inttypes.h>
#include <math.h>
#include <regex.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define EXIT_DIFFERENT 1
#define EXIT_FAILED    2

#define WORDS_MAX     64
#define RENEWALS      4u   ///< of a reference within drive.reference_ms
#define TURN_S        0.05 ///< that a trace is read before others have their turn on the line
#define TRACE_LOOK_MS 50
#define STATE_S       1.0  ///< that a command has to show in the drive's state
#define TARE_S        10.0 ///< that a tare may take

typedef struct
{
    const char    *device;
    int            unit, baud;
    const char    *out; ///< null: standard output
    const char    *signals, *trigger, *watch;
    double         level, wait_s, hold_s;
    uint64_t       decimation, after;
    bool           acknowledge, markdown;
    bool           wants_help;
    bool           is_short; ///< no command: the state in a few lines
    status_watch_t watching;
    const char    *listen, *allow;
    char          *words[WORDS_MAX]; ///< the command and its arguments
    int            count;
} options_t;

// --- params --------------------------------------------------------------------------------------------------------

static uint16_t active_at(const link_row_t *row)
{
    return (uint16_t)(row->address + (REGISTERS_ACTIVE_AT - REGISTERS_STAGED_AT));
}

/// The number of digits that distinguish a register's values.
static int digits_of(const link_row_t *row)
{
    return row->is_float ? 9 : 10;
}

static double number_of(const link_row_t *row, uint32_t word)
{
    return row->is_float ? (double)link_float(word) : (double)word;
}

static uint32_t word_of(const link_row_t *row, double number)
{
    return row->is_float ? link_word((float)number) : (uint32_t)number;
}

/// The parts of a set: Modbus registers in the set, words in params.
static const struct
{
    uint16_t at;
    int      word, count;
} parts[] = {{REGISTERS_TABLE_AT, PARAMS_TABLE_AT, PARAMS_WORDS - PARAMS_TABLE_AT},
             {REGISTERS_SECTIONS_AT, PARAMS_SECTIONS_AT, PARAMS_TABLE_AT - PARAMS_SECTIONS_AT},
             {REGISTERS_GUARD_AT, PARAMS_GUARD_AT, PARAMS_GUARD_COUNT},
             {REGISTERS_FEED_AT, PARAMS_FEED_AT, PARAMS_FEED_COUNT},
             {REGISTERS_METHOD_AT, PARAMS_METHOD_AT, 1},
             {REGISTERS_LOOP_AT, PARAMS_LOOP_AT, PARAMS_LOOP_COUNT},
             {REGISTERS_DRIVE_AT, 0, DRIVE_CONFIG_COUNT}};

#define PARTS (sizeof parts / sizeof parts[0])

static bool has_part(const link_bus_t *bus, size_t part)
{
    return (parts[part].at != REGISTERS_FEED_AT && parts[part].at != REGISTERS_GUARD_AT) || link_bus_feeds_forward(bus);
}

/// Reads the whole set at `base` as words; params that the drive does not have get their defaults.
static bool read_set(link_bus_t *bus, uint16_t base, params_t *params)
{
    bool ok     = true;
    params->set = params_default();
    for (size_t i = 0; ok && i < PARTS; i++)
    {
        ok =
            !has_part(bus, i) ||
            link_bus_read(bus, (uint16_t)(base + parts[i].at), params->words + parts[i].word, (unsigned)parts[i].count);
    }
    return ok;
}

static bool stage_set(link_bus_t *bus, const params_t *params)
{
    bool ok = true;
    for (size_t i = 0; ok && i < PARTS; i++)
    {
        ok = !has_part(bus, i) || link_bus_write(bus,
                                                 (uint16_t)(REGISTERS_STAGED_AT + parts[i].at),
                                                 params->words + parts[i].word,
                                                 (unsigned)parts[i].count);
    }
    return ok;
}

static uint32_t word_at(const params_t *params, const link_row_t *row)
{
    const uint32_t place = row->address - REGISTERS_STAGED_AT;
    size_t         i     = 0;
    while (place < parts[i].at)
    {
        i++;
    }
    return params->words[(uint32_t)parts[i].word + (place - parts[i].at) / 2u];
}

/// NAME is LIST[INDEX] or an element's part.
static bool is_element(const char *name, const char *list, uint32_t *index)
{
    const size_t length = strlen(list);
    const bool   is_of  = strncmp(name, list, length) == 0 && name[length] == '[';
    *index              = is_of ? (uint32_t)strtoul(name + length + 1, NULL, 10) : 0u;
    return is_of;
}

/// Not an element of a list beyond the length that the set has.
static bool is_used(const params_t *params, const link_row_t *row)
{
    uint32_t index;
    if (is_element(row->name, "controller.sections", &index))
    {
        return index < params->words[PARAMS_SECTION_COUNT];
    }
    if (is_element(row->name, "compensator.friction.breakaway.table", &index))
    {
        return index < params->words[PARAMS_TABLE_LENGTH];
    }
    return true;
}

static const link_row_t *find_param(const link_bus_t *bus, const char *name)
{
    const link_row_t *row = link_find(name);
    if (row != NULL && link_is_of_feedforward(row) && !link_bus_feeds_forward(bus))
    {
        (void)link_complain("%s: this drive is built without the feed-forward", name);
        return NULL;
    }
    if (row != NULL && row->group == LINK_PARAM)
    {
        return row;
    }
    const char *nearest = link_nearest(name, true);
    (void)link_complain("there is no param %s%s%s (tribo-link list shows them)",
                        name,
                        nearest != NULL ? "; did you mean " : "",
                        nearest != NULL ? nearest : "");
    return NULL;
}

static int get_params(link_bus_t *bus, const options_t *options)
{
    params_t params;
    size_t   count;
    if (!read_set(bus, REGISTERS_ACTIVE_AT, &params))
    {
        return EXIT_FAILED;
    }
    for (int i = 2; i < options->count; i++)
    {
        const link_row_t *row = find_param(bus, options->words[i]);
        if (row == NULL)
        {
            return EXIT_FAILED;
        }
        (void)printf("%s: %.*g\n", row->name, digits_of(row), number_of(row, word_at(&params, row)));
    }
    const link_row_t *list = link_list(&count);
    for (size_t i = 0; options->count == 2 && i < count; i++)
    {
        const bool is_there = link_bus_feeds_forward(bus) || !link_is_of_feedforward(&list[i]);
        if (list[i].group == LINK_PARAM && is_there && is_used(&params, &list[i]))
        {
            (void)printf("%s: %.*g\n",
                         list[i].name,
                         digits_of(&list[i]),
                         number_of(&list[i], word_at(&params, &list[i])));
        }
    }
    return 0;
}

typedef struct
{
    const link_row_t *row;
    uint32_t          word;
} change_t;

/// A number, or the word that a scenario has for it; null or what is wrong.
static const char *parse_value(const char *name, const char *text, double *number)
{
    static char    wrong[64 + COMMON_WORDS_MAX];
    common_place_t place;
    if (!common_key_find(common_loop_keys, NULL, name, &place) || place.key->type != COMMON_KEY_CHOICE)
    {
        return common_number_parse(text, number);
    }
    const int index = common_key_find_word(place.key, text);
    if (index >= 0)
    {
        *number = index;
        return NULL;
    }
    if (common_number_parse(text, number) == NULL)
    {
        return NULL;
    }
    char words[COMMON_WORDS_MAX];
    common_key_words(place.key, words, sizeof words);
    (void)snprintf(wrong, sizeof wrong, "is not %s, nor their number from 0", words);
    return wrong;
}

/// `text` names the number.
static bool check_size(const char *text, const char *number, const link_row_t *row)
{
    return !common_number_is_below(number, row->least) ||
           link_complain("%s: too small to be meant: 0, or at least %.0e in size", text, row->least);
}

static bool parse_change(const link_bus_t *bus, change_t *change, const char *text)
{
    char        name[96];
    const char *equals = strchr(text, '=');
    double      number;
    if (equals == NULL || (size_t)(equals - text) >= sizeof name)
    {
        (void)link_complain("params set %s: NAME=VALUE is expected", text);
        return false;
    }
    (void)snprintf(name, sizeof name, "%.*s", (int)(equals - text), text);
    change->row = find_param(bus, name);
    if (change->row == NULL)
    {
        return false;
    }
    const link_row_t *row = change->row;
    if (row->is_float && !check_size(text, equals + 1, row))
    {
        return false;
    }
    const char *wrong = parse_value(name, equals + 1, &number);
    if (wrong != NULL)
    {
        return link_complain("%s: %s", text, wrong);
    }
    const bool within = (number >= row->low && number <= row->high) || (row->can_be_0 && number == 0.0);
    if (!within && fabs(number - row->low) > 1e-6 * fabs(row->low) && fabs(number - row->high) > 1e-6 * fabs(row->high))
    {
        return link_complain("%s: %.9g to %.9g%s", text, row->low, row->high, row->can_be_0 ? " or 0" : "");
    }
    if (!row->is_float && number != floor(number))
    {
        return link_complain("%s: a whole number is expected", text);
    }
    change->word = word_of(row, number);
    return true;
}

/// All or nothing: what is staged is the set that the drive runs with, and these changes.
static int set_params(link_bus_t *bus, const options_t *options)
{
    change_t changes[WORDS_MAX];
    if (options->count == 2)
    {
        (void)link_complain("params set: NAME=VALUE is expected");
        return EXIT_FAILED;
    }
    for (int i = 2; i < options->count; i++)
    {
        if (!parse_change(bus, &changes[i], options->words[i]))
        {
            return EXIT_FAILED;
        }
        for (int k = 2; k < i; k++)
        {
            if (changes[k].row == changes[i].row)
            {
                (void)link_complain("params set %s %s: only one is expected", options->words[k], options->words[i]);
                return EXIT_FAILED;
            }
        }
    }
    bool ok = link_bus_command(bus, REGISTERS_REVERT, "staging the params");
    for (int i = 2; ok && i < options->count; i++)
    {
        ok = link_bus_write(bus, changes[i].row->address, &changes[i].word, 1);
    }
    return ok && link_bus_apply(bus, "applying the params") ? 0 : EXIT_FAILED;
}

/// Merges the loop of a scenario into the drive's set.
static bool take_scenario(params_t *params, const char *path)
{
    common_error_t       error = {""};
    common_loop_config_t loop;
    common_scenario_t   *scenario = common_scenario_create_of(common_loop_keys, sizeof(common_loop_keys_t));
    bool                 ok       = scenario != NULL && common_scenario_load(scenario, path, &error) &&
              common_check_present(scenario, &error) && common_check_has_loop(scenario, &error) &&
              common_check_loop(scenario, &error);
    if (ok)
    {
        common_loop_config_fill(&loop, common_scenario_loop(scenario));
        params_take_loop(&params->set, &loop.parts);
    }
    else
    {
        (void)link_complain("%s", error.text[0] != '\0' ? error.text : "out of memory");
    }
    common_scenario_destroy(scenario);
    return ok;
}

static bool wants_scenario(const options_t *options)
{
    return options->count == 3 || link_complain("params %s: one SCENARIO.yaml is expected", options->words[1]);
}

static int params_from(link_bus_t *bus, const options_t *options)
{
    params_t params;
    return wants_scenario(options) && read_set(bus, REGISTERS_ACTIVE_AT, &params) &&
                   take_scenario(&params, options->words[2]) && stage_set(bus, &params) &&
                   link_bus_apply(bus, "applying the params")
               ? 0
               : EXIT_FAILED;
}

static int diff_params(link_bus_t *bus, const options_t *options)
{
    params_t          drive, scenario;
    size_t            count, different = 0;
    const link_row_t *list = link_list(&count);
    if (!wants_scenario(options) || !read_set(bus, REGISTERS_ACTIVE_AT, &drive))
    {
        return EXIT_FAILED;
    }
    scenario = drive;
    if (!take_scenario(&scenario, options->words[2]))
    {
        return EXIT_FAILED;
    }
    for (size_t i = 0; i < count; i++)
    {
        const link_row_t *row = &list[i];
        if (row->group == LINK_PARAM && (is_used(&drive, row) || is_used(&scenario, row)) &&
            word_at(&drive, row) != word_at(&scenario, row))
        {
            (void)printf("%s: %.9g in the drive, %.9g in %s\n",
                         row->name,
                         number_of(row, word_at(&drive, row)),
                         number_of(row, word_at(&scenario, row)),
                         options->words[2]);
            different++;
        }
    }
    return different > 0u ? EXIT_DIFFERENT : 0;
}

static int apply_defaults(link_bus_t *bus)
{
    return link_bus_command(bus, REGISTERS_DEFAULTS, "staging the defaults") &&
                   link_bus_apply(bus, "applying the defaults")
               ? 0
               : EXIT_FAILED;
}

static int params_command(link_bus_t *bus, const options_t *options)
{
    const char *what = options->count > 1 ? options->words[1] : "";
    if (strcmp(what, "get") == 0)
    {
        return get_params(bus, options);
    }
    if (strcmp(what, "set") == 0)
    {
        return set_params(bus, options);
    }
    if (strcmp(what, "save") == 0)
    {
        return link_bus_command(bus, REGISTERS_SAVE, "saving the params") ? 0 : EXIT_FAILED;
    }
    if (strcmp(what, "diff") == 0)
    {
        return diff_params(bus, options);
    }
    if (strcmp(what, "from") == 0)
    {
        return params_from(bus, options);
    }
    if (strcmp(what, "defaults") == 0)
    {
        return apply_defaults(bus);
    }
    (void)link_complain("params%s%s: get, set, save, diff, from or defaults is expected",
                        what[0] != '\0' ? " " : "",
                        what);
    return EXIT_FAILED;
}

// --- status --------------------------------------------------------------------------------------------------------

static int show_status(link_bus_t *bus, const options_t *options)
{
    const bool is_json = options->watching.json;
    const bool ok      = options->is_short && !is_json ? status_show_short(bus) : status_show(bus, is_json);
    return ok ? 0 : EXIT_FAILED;
}

static int watch(link_bus_t *bus, const options_t *options)
{
    status_watch_t watching = options->watching;
    watching.hold_s         = options->hold_s;
    return status_watch(bus, &watching) ? 0 : EXIT_FAILED;
}

static bool is_network(const char *device)
{
    return strncmp(device, "tcp:", 4) == 0;
}

static int serve_page(link_bus_t *bus, const options_t *options)
{
    char          unit[16], baud[16];
    const serve_t served = {.listen  = options->listen,
                            .allow   = options->allow,
                            .rate_hz = options->watching.rate_hz,
                            .unit    = unit,
                            .baud    = is_network(options->device) ? NULL : baud};
    (void)snprintf(unit, sizeof unit, "%d", options->unit);
    (void)snprintf(baud, sizeof baud, "%d", options->baud);
    return serve(bus, &served) ? 0 : EXIT_FAILED;
}

static int show_changes(link_bus_t *bus)
{
    enum
    {
        WORDS = sizeof(registers_change_t) / sizeof(uint32_t)
    };
    uint32_t words[REGISTERS_CHANGES * WORDS];
    uint32_t count;
    if (!link_bus_state(bus, "protection_changes", &count) ||
        !link_bus_read(bus, REGISTERS_CHANGES_AT, words, REGISTERS_CHANGES * WORDS))
    {
        return EXIT_FAILED;
    }
    const uint32_t first = count > REGISTERS_CHANGES ? count - REGISTERS_CHANGES : 0u;
    if (first > 0u)
    {
        (void)printf("%u before these\n", first);
    }
    for (uint32_t i = first; i < count; i++)
    {
        registers_change_t change;
        memcpy(&change, words + (size_t)(i % REGISTERS_CHANGES) * WORDS, sizeof change);
        const link_row_t *row = link_at((uint16_t)change.address);
        if (row != NULL)
        {
            (void)printf("tick %u: %s from %.*g to %.*g\n",
                         change.tick,
                         row->name,
                         digits_of(row),
                         number_of(row, change.from),
                         digits_of(row),
                         number_of(row, change.to));
        }
    }
    return 0;
}

static bool wait_for_state(link_bus_t *bus, uint32_t wanted, const char *what)
{
    uint32_t state = 0;
    uint32_t fault = 0;
    for (const double end_s = common_clock_s() + STATE_S; common_clock_s() < end_s;)
    {
        if (!link_bus_state(bus, "state", &state) || !link_bus_state(bus, "fault", &fault))
        {
            return false;
        }
        if (state == wanted)
        {
            return true;
        }
        (void)nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
    }
    return link_complain("%s: the drive is in %s%s%s",
                         what,
                         status_state_text(state),
                         state == DRIVE_FAULT ? ": " : "",
                         state == DRIVE_FAULT ? drive_fault_text((drive_fault_t)fault) : "");
}

static int start(link_bus_t *bus)
{
    return link_bus_command(bus, REGISTERS_START, "start") && wait_for_state(bus, DRIVE_RUN, "start") ? 0 : EXIT_FAILED;
}

static int stop(link_bus_t *bus)
{
    return link_bus_command(bus, REGISTERS_STOP, "stop") && wait_for_state(bus, DRIVE_IDLE, "stop") ? 0 : EXIT_FAILED;
}

static int tare(link_bus_t *bus)
{
    uint32_t     state = DRIVE_TARE_BUSY;
    const double end_s = common_clock_s() + TARE_S;
    if (!link_bus_command(bus, REGISTERS_TARE, "tare"))
    {
        return EXIT_FAILED;
    }
    while (state != DRIVE_TARE_DONE && common_clock_s() < end_s)
    {
        (void)nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
        if (!link_bus_state(bus, "tare", &state))
        {
            return EXIT_FAILED;
        }
        if (state == DRIVE_TARE_REFUSED)
        {
            (void)link_complain("tare: refused: not idle, or a force beyond drive.tare_max_n (0: no tare)");
            return EXIT_FAILED;
        }
    }
    return state == DRIVE_TARE_DONE || link_complain("tare: not done in %g s", TARE_S) ? 0 : EXIT_FAILED;
}

static int restore(link_bus_t *bus)
{
    return link_bus_command(bus, REGISTERS_RESTORE, "restore") ? 0 : EXIT_FAILED;
}

static int forget(link_bus_t *bus)
{
    return link_bus_command(bus, REGISTERS_FORGET, "forget") ? 0 : EXIT_FAILED;
}

/// Renews the reference if the drive waits for its host: for --hold, or until a signal ends this program.
static bool renew_reference(link_bus_t *bus, uint32_t word, const options_t *options)
{
    uint32_t     within_ms, state;
    const double start_s = common_clock_s();
    if (!link_bus_read(bus, active_at(link_find("drive.reference_ms")), &within_ms, 1))
    {
        return false;
    }
    if (within_ms == 0u && options->hold_s > 0.0 && isfinite(options->hold_s))
    {
        return link_complain(
            "reference: --hold %g: drive.reference_ms is 0, so this drive keeps the reference without renewal",
            options->hold_s);
    }
    if (!link_bus_write(bus, link_find("reference")->address, &word, 1))
    {
        return link_complain("reference: not taken; a drive that was started with --reference takes none from the bus");
    }
    if (within_ms == 0u)
    {
        return true;
    }
    const int rest_ms = within_ms / RENEWALS > 0u ? (int)(within_ms / RENEWALS) : 1;
    (void)fprintf(stderr, "reference: renewed every %d ms; the drive waits %u ms for it\n", rest_ms, within_ms);
    while (!(common_clock_s() - start_s >= options->hold_s))
    {
        if (!link_bus_rest(bus, rest_ms) || !link_bus_write(bus, link_find("reference")->address, &word, 1) ||
            !link_bus_state(bus, "state", &state))
        {
            return false;
        }
        if (state == DRIVE_FAULT)
        {
            return link_complain("reference: the drive is in fault");
        }
    }
    return true;
}

static int set_reference(link_bus_t *bus, const options_t *options)
{
    char   text[64];
    double number = 0.0;
    if (options->count != 2)
    {
        (void)link_complain("reference: one force in N is expected");
        return EXIT_FAILED;
    }
    (void)snprintf(text, sizeof text, "reference %s", options->words[1]);
    if (!check_size(text, options->words[1], link_find("reference")))
    {
        return EXIT_FAILED;
    }
    const char *wrong = common_number_parse(options->words[1], &number);
    if (wrong != NULL)
    {
        (void)link_complain("%s: %s", text, wrong);
        return EXIT_FAILED;
    }
    uint32_t most;
    if (!link_bus_read(bus, active_at(link_find("limits.input_max_N")), &most, 1))
    {
        return EXIT_FAILED;
    }
    if (!(fabsf((float)number) <= link_float(most)))
    {
        (void)link_complain("reference %g: outside -%g to %g N (limits.input_max_N)",
                            number,
                            (double)link_float(most),
                            (double)link_float(most));
        return EXIT_FAILED;
    }
    return renew_reference(bus, link_word((float)number), options) ? 0 : EXIT_FAILED;
}

// --- traces --------------------------------------------------------------------------------------------------------

typedef struct
{
    uint32_t states[REGISTERS_STATE_COUNT];
    uint32_t channels;
} trace_head_t;

static bool read_head(link_bus_t *bus, uint32_t which, trace_head_t *head)
{
    if (!link_bus_write(bus, link_find("trace.which")->address, &which, 1) ||
        !link_bus_read(bus, REGISTERS_STATE_AT, head->states, REGISTERS_STATE_COUNT))
    {
        return false;
    }
    const uint32_t seen = head->states[REGISTERS_STATE_trace_signals_seen];
    head->channels      = 0;
    for (uint32_t i = 0; i < REGISTERS_SIGNAL_COUNT; i++)
    {
        head->channels += seen >> i & 1u;
    }
    return true;
}

static void write_header(FILE *file, uint32_t signals)
{
    static const char *const names[] = {
#define NAME(symbol, name, unit, member, text) name,
        REGISTERS_SIGNALS(NAME)
#undef NAME
    };
    (void)fputs("t_s", file);
    for (uint32_t i = 0; i < REGISTERS_SIGNAL_COUNT; i++)
    {
        if ((signals >> i & 1u) != 0u)
        {
            (void)fprintf(file, ",%s", names[i]);
        }
    }
    (void)fputc('\n', file);
}

#define REST_MS 5

/// Writes the trace, with time 0 at its first sample.
static bool write_samples(link_bus_t *bus, const trace_head_t *head, double interval_s, FILE *file)
{
    const uint32_t held   = head->states[REGISTERS_STATE_trace_held];
    const uint32_t first  = head->states[REGISTERS_STATE_trace_count] - held;
    const uint32_t most   = LINK_WINDOW / head->channels;
    double         turn_s = common_clock_s();
    for (uint32_t done = 0; done < held;)
    {
        uint32_t       words[LINK_WINDOW];
        const uint32_t samples = held - done < most ? held - done : most;
        if (!link_bus_window(bus, first + done, words, samples * head->channels))
        {
            return false;
        }
        if (common_clock_s() - turn_s > TURN_S) // a host that renews its reference must not wait for the whole trace
        {
            if (!link_bus_rest(bus, REST_MS))
            {
                return false;
            }
            turn_s = common_clock_s();
        }
        for (uint32_t i = 0; i < samples; i++, done++)
        {
            (void)fprintf(file, "%.9g", done * interval_s);
            for (uint32_t k = 0; k < head->channels; k++)
            {
                (void)fprintf(file, ",%.9g", (double)link_float(words[i * head->channels + k]));
            }
            (void)fputc('\n', file);
        }
    }
    return true;
}

static bool save_trace(link_bus_t *bus, const trace_head_t *head, common_output_file_t *file)
{
    common_error_t error = {""};
    uint32_t       period_us;
    if (!link_bus_read(bus, active_at(link_find("drive.period_us")), &period_us, 1))
    {
        return false;
    }
    const double ticks = (double)head->states[REGISTERS_STATE_trace_decimation_seen];
    write_header(file->stream, head->states[REGISTERS_STATE_trace_signals_seen]);
    return write_samples(bus, head, ticks * (double)period_us / 1e6, file->stream) &&
           (common_output_commit(file, 1, &error) || link_complain("%s", error.text));
}

/// Opens --out. A command opens it before its work, so that a wrong place costs no trace and no acknowledgement.
static bool open_out(const options_t *options, common_output_file_t *file)
{
    common_error_t error = {""};
    return common_output_open(file, options->out, &error) || link_complain("%s", error.text);
}

static bool find_signal(const char *name, size_t length, uint32_t *place)
{
    const link_row_t *row = NULL;
    char              text[32];
    if (length < sizeof text)
    {
        (void)snprintf(text, sizeof text, "%.*s", (int)length, name);
        row = link_find(text);
    }
    if (row == NULL || row->group != LINK_SIGNAL)
    {
        return link_complain("unknown signal %.*s (tribo-link list shows them)", (int)length, name);
    }
    *place = (uint32_t)(row->address - REGISTERS_SIGNALS_AT) / 2u;
    return true;
}

static bool parse_signals(const char *text, uint32_t *signals)
{
    const char *const all   = text;
    unsigned          count = 0;
    *signals                = 0;
    while (*text != '\0')
    {
        uint32_t     place  = 0;
        const size_t length = strcspn(text, ",");
        if (!find_signal(text, length, &place))
        {
            return false;
        }
        if ((*signals >> place & 1u) != 0u)
        {
            return link_complain("--signals %s: %.*s is given twice", all, (int)length, text);
        }
        *signals |= 1u << place;
        count++;
        text += length + (text[length] == ',');
    }
    return (count >= 1u && count <= TRACE_CHANNELS_MAX) ||
           link_complain("--signals %s: has %u names, 1 to %u are expected", all, count, TRACE_CHANNELS_MAX);
}

static bool parse_trigger(const char *text, uint32_t *trigger)
{
    static const char *const words[TRACE_TRIGGERS] = {"none", "fault", "reversal", "rise", "fall"};
    for (uint32_t i = 0; i < TRACE_TRIGGERS; i++)
    {
        if (strcmp(words[i], text) == 0)
        {
            *trigger = i;
            return true;
        }
    }
    return link_complain("--trigger %s: none, fault, reversal, rise or fall is expected", text);
}

static bool arm(link_bus_t *bus, const options_t *options)
{
    registers_requests_t asked = {.decimation = (uint32_t)options->decimation,
                                  .after      = (uint32_t)options->after,
                                  .level      = (float)options->level};
    if (!parse_signals(options->signals, &asked.signals) || !parse_trigger(options->trigger, &asked.trigger) ||
        !find_signal(options->watch, strlen(options->watch), &asked.watched))
    {
        return false;
    }
    const uint32_t words[] =
        {asked.signals, asked.decimation, asked.trigger, asked.watched, link_word(asked.level), asked.after};
    return link_bus_write(bus, link_find("trace.signals")->address, words, sizeof words / sizeof words[0]) &&
           link_bus_command(bus, REGISTERS_TRACE, "trace");
}

/// Stops a trace whose time is over. Returns true if its samples are the result: it had no trigger to wait for.
static bool end_trace(link_bus_t *bus, const options_t *options, trace_head_t *head)
{
    const bool had_trigger = head->states[REGISTERS_STATE_trace_state] == TRACE_TRIGGERED;
    if (!link_bus_command(bus, REGISTERS_TRACE_STOP, "trace") || !read_head(bus, 0, head))
    {
        return false;
    }
    if (had_trigger)
    {
        return link_complain("trace: the trigger came, but not all %" PRIu64
                             " samples after it within %g s, so nothing is "
                             "written; a longer --wait or a smaller --after completes it",
                             options->after,
                             options->wait_s);
    }
    if (strcmp(options->trigger, "none") != 0)
    {
        return link_complain(
            "trace: the trigger %s did not come within %g s, so nothing is written; --wait waits longer, "
            "and --trigger none records without a trigger",
            options->trigger,
            options->wait_s);
    }
    return head->states[REGISTERS_STATE_trace_held] > 0u ||
           link_complain("trace: the drive took no sample within %g s, so nothing is written",
                         options->wait_s + STATE_S);
}

/// Waits until the trace is done or the time is over.
static bool wait_for_trace(link_bus_t *bus, const options_t *options, trace_head_t *head)
{
    const double end_s = common_clock_s() + options->wait_s;
    for (;;)
    {
        if (!read_head(bus, 0, head))
        {
            return false;
        }
        if (head->states[REGISTERS_STATE_trace_state] == TRACE_DONE)
        {
            return true;
        }
        // Without a trigger the first sample is waited for, also after a --wait of 0.
        const bool is_first = strcmp(options->trigger, "none") == 0 && head->states[REGISTERS_STATE_trace_held] == 0u;
        if (common_clock_s() >= end_s + (is_first ? STATE_S : 0.0))
        {
            return end_trace(bus, options, head);
        }
        if (!link_bus_rest(bus, TRACE_LOOK_MS))
        {
            return false;
        }
    }
}

static int record_trace(link_bus_t *bus, const options_t *options)
{
    trace_head_t         head;
    common_output_file_t file;
    const bool           ok = open_out(options, &file) && arm(bus, options) && wait_for_trace(bus, options, &head) &&
                    save_trace(bus, &head, &file);
    common_output_discard(&file, 1);
    return ok ? 0 : EXIT_FAILED;
}

static void print_fault(const trace_head_t *head)
{
    const uint32_t fault = head->states[REGISTERS_STATE_fault];
    const bool     is    = head->states[REGISTERS_STATE_state] == DRIVE_FAULT;
    (void)printf("fault: %s", is ? drive_fault_text((drive_fault_t)fault) : "none");
    if (is)
    {
        (void)printf(", since tick %u of %u",
                     head->states[REGISTERS_STATE_fault_tick],
                     head->states[REGISTERS_STATE_tick]);
    }
    (void)putchar('\n');
}

/// Writes the trace that was kept for the fault.
static bool save_fault(link_bus_t *bus, const trace_head_t *head, common_output_file_t *file)
{
    return head->states[REGISTERS_STATE_trace_state] == TRACE_DONE
               ? save_trace(bus, head, file)
               : link_complain("fault --out: there was no fault since the last start");
}

/// Prints the cause, and with --out writes the trace that was kept for it.
static int show_fault(link_bus_t *bus, const options_t *options)
{
    trace_head_t         head;
    common_output_file_t file = {.stream = NULL};
    bool                 ok   = (options->out == NULL || open_out(options, &file)) && read_head(bus, 1, &head);
    if (ok)
    {
        print_fault(&head);
        ok = options->out == NULL || save_fault(bus, &head, &file);
    }
    common_output_discard(&file, 1);
    if (ok && options->acknowledge)
    {
        ok = link_bus_command(bus, REGISTERS_ACKNOWLEDGE, "acknowledgement") &&
             wait_for_state(bus, DRIVE_IDLE, "acknowledgement");
    }
    return ok ? 0 : EXIT_FAILED;
}

// --- the command line ----------------------------------------------------------------------------------------------

/// Writes out standard output. Returns the exit status: that of the command, or EXIT_FAILED if output is lost.
static int finish(int status)
{
    common_error_t error = {""};
    if (status == EXIT_FAILED || common_output_flush(&error))
    {
        return status;
    }
    (void)link_complain("%s", error.text);
    return EXIT_FAILED;
}

static int show_list(const options_t *options)
{
    size_t            count;
    const link_row_t *list = link_list(&count);
    if (options->markdown)
    {
        link_print_markdown();
        return 0;
    }
    for (size_t i = 0; i < count; i++)
    {
        (void)printf("%s  0x%04x  %s\n", list[i].name, list[i].address, list[i].text);
    }
    return 0;
}

static const struct
{
    const char *name;
    int (*plain)(link_bus_t *bus);
    int (*with_options)(link_bus_t *bus, const options_t *options);
} commands[] = {{.name = "status", .with_options = show_status},
                {.name = "watch", .with_options = watch},
                {.name = "serve", .with_options = serve_page},
                {.name = "params", .with_options = params_command},
                {.name = "start", .plain = start},
                {.name = "stop", .plain = stop},
                {.name = "fault", .with_options = show_fault},
                {.name = "tare", .plain = tare},
                {.name = "changes", .plain = show_changes},
                {.name = "restore", .plain = restore},
                {.name = "forget", .plain = forget},
                {.name = "reference", .with_options = set_reference},
                {.name = "trace", .with_options = record_trace}};

static int perform(link_bus_t *bus, const options_t *options)
{
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++)
    {
        if (strcmp(commands[i].name, options->words[0]) == 0)
        {
            if (bus == NULL)
            {
                return 0; // the caller only asks whether the command exists
            }
            return commands[i].plain != NULL ? commands[i].plain(bus) : commands[i].with_options(bus, options);
        }
    }
    (void)link_complain("there is no command %s (tribo-link --help shows them)", options->words[0]);
    return EXIT_FAILED;
}

enum
{
    OPTION_BAUD = 256,
    OPTION_SIGNALS,
    OPTION_DECIMATION,
    OPTION_TRIGGER,
    OPTION_WATCH,
    OPTION_LEVEL,
    OPTION_AFTER,
    OPTION_WAIT,
    OPTION_HOLD,
    OPTION_ACKNOWLEDGE,
    OPTION_JSON,
    OPTION_RATE,
    OPTION_UDP,
    OPTION_TELEPLOT,
    OPTION_LISTEN,
    OPTION_ALLOW,
    OPTION_MARKDOWN,
    OPTION_USAGE,
    OPTION_VERSION
};

// clang-format off: one row an option. Its text begins with its commands; without any it belongs to all, or a drive's to all that
// talk to one.
static const struct argp_option known[] = {
    {.name = "device", .key = 'd', .arg = "DEVICE", .doc = "the serial line, or tcp:HOST[:PORT]; if left out, TRIBO_LINK_DEVICE or the one where a drive answers"},
    {.name = "unit", .key = 'u', .arg = "1-247", .doc = "the drive's address, 1 if left out"},
    {.name = "baud", .key = OPTION_BAUD, .arg = "BAUD", .doc = "115200 if left out"},
    {.name = "out", .key = 'o', .arg = "FILE.csv", .doc = "trace, fault: the file for the samples; a trace's go to standard output if left out"},
    {.name = "signals", .key = OPTION_SIGNALS, .arg = "NAME,...", .doc = "trace: up to 8; r_N,F_N,u_N,F_hat_N if left out"},
    {.name = "decimation", .key = OPTION_DECIMATION, .arg = "TICKS", .doc = "trace: ticks from sample to sample, 1 if left out"},
    {.name = "trigger", .key = OPTION_TRIGGER, .arg = "none|fault|reversal|rise|fall", .doc = "trace: the trigger; none if left out, and the trace ends after --wait"},
    {.name = "watch", .key = OPTION_WATCH, .arg = "NAME", .doc = "trace: the signal that reverses, rises or falls; r_N if left out"},
    {.name = "level", .key = OPTION_LEVEL, .arg = "N", .doc = "trace: the level that the signal rises or falls to"},
    {.name = "after", .key = OPTION_AFTER, .arg = "SAMPLES", .doc = "trace: samples after the trigger, 100 if left out; the rest of the ring is from before it"},
    {.name = "wait", .key = OPTION_WAIT, .arg = "S", .doc = "trace: the time for the trigger and the samples after it, 10 s if left out; if it is over, nothing is written and the exit status is 2"},
    {.name = "hold", .key = OPTION_HOLD, .arg = "S", .doc = "reference, watch: ends after this time; after a signal if left out"},
    {.name = "json", .key = OPTION_JSON, .doc = "status: prints JSON; watch: prints a line of JSON per sample, in place of the view"},
    {.name = "rate", .key = OPTION_RATE, .arg = "HZ", .doc = "watch, serve: samples a second, 10 if left out"},
    {.name = "udp", .key = OPTION_UDP, .arg = "HOST:PORT", .doc = "watch: sends each sample there as JSON, e.g. to PlotJuggler at 127.0.0.1:9870"},
    {.name = "teleplot", .key = OPTION_TELEPLOT, .arg = "HOST:PORT", .doc = "watch: sends each sample there in Teleplot's format, e.g. to 127.0.0.1:47269"},
    {.name = "listen", .key = OPTION_LISTEN, .arg = "HOST:PORT", .doc = "serve: the address to listen on; 127.0.0.1:8088 if left out"},
    {.name = "allow", .key = OPTION_ALLOW, .arg = "NAME", .doc = "serve: the name by which browsers on other machines call this one; without it nothing but loopback is served"},
    {.name = "acknowledge", .key = OPTION_ACKNOWLEDGE, .doc = "fault: acknowledges it"},
    {.name = "markdown", .key = OPTION_MARKDOWN, .doc = "list: prints a page in Markdown, with types, units, ranges and defaults"},
    {.name = "help", .key = '?', .doc = "prints this help; with a COMMAND only its own"},
    {.name = "usage", .key = OPTION_USAGE, .doc = "prints the options in short"},
    {.name = "version", .key = OPTION_VERSION, .doc = "prints the version of this program"},
    {.name = NULL}};
// clang-format on

static bool matches(const char *text, const char *pattern, const char *word)
{
    char    whole[128];
    regex_t expression;
    (void)snprintf(whole, sizeof whole, pattern, word);
    const bool is_valid = regcomp(&expression, whole, REG_EXTENDED | REG_NOSUB) == 0;
    const bool found    = is_valid && regexec(&expression, text, 0, NULL, 0) == 0;
    if (is_valid)
    {
        regfree(&expression);
    }
    return found;
}

/// Returns true if the command uses the option. `list` and `completion` talk to no drive, and `ports` looks for devices itself.
static bool is_of(const struct argp_option *option, const char *command)
{
    const bool is_of_drive = option->key == 'd' || option->key == 'u' || option->key == OPTION_BAUD;
    const bool has_no_use =
        matches("list,completion", "(^|,)%s(,|$)", command) || (option->key == 'd' && strcmp(command, "ports") == 0);
    return (!is_of_drive || !has_no_use) && (!matches(option->doc, "^[a-z]+(, [a-z]+)*: %s", "") ||
                                             matches(option->doc, "(^|[,;] )%s(, [a-z]+)*: ", command));
}

/// Prints commands and options for bash to evaluate.
static int print_completion(const options_t *options)
{
    if (options->count != 2 || strcmp(options->words[1], "bash") != 0)
    {
        (void)link_complain("completion: bash is expected");
        return EXIT_FAILED;
    }
    (void)fputs("complete -o default -W 'list ports completion", stdout);
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++)
    {
        (void)printf(" %s", commands[i].name);
    }
    for (const struct argp_option *option = known; option->name != NULL; option++)
    {
        (void)printf(" --%s", option->name);
    }
    (void)puts("' tribo-link");
    return 0;
}

static void take_number(struct argp_state *state,
                        const char        *name,
                        const char        *text,
                        double             low,
                        double             high,
                        double            *number)
{
    if (common_number_parse(text, number) != NULL || !(*number >= low && *number <= high))
    {
        argp_error(state, "--%s %s: a number from %g to %g is expected", name, text, low, high);
    }
}

static void take_whole(struct argp_state *state,
                       const char        *name,
                       const char        *text,
                       uint64_t           low,
                       uint64_t           high,
                       uint64_t          *number)
{
    if (common_number_parse_whole(text, number) != NULL || *number < low || *number > high)
    {
        argp_error(state,
                   "--%s %s: a whole number from %llu to %llu is expected",
                   name,
                   text,
                   (unsigned long long)low,
                   (unsigned long long)high);
    }
}

/// Accepts only the rates that libmodbus knows: it uses 9600 for any other.
static int take_baud(struct argp_state *state, const char *text)
{
    static const int rates[] = {1200,    2400,    4800,    9600,    19200,   38400,   57600,
                                115200,  230400,  460800,  500000,  576000,  921600,  1000000,
                                1152000, 1500000, 2000000, 2500000, 3000000, 3500000, 4000000};
    uint64_t         whole   = 0;
    const char      *wrong   = common_number_parse_whole(text, &whole);
    char             list[sizeof rates / sizeof rates[0] * 10] = "";
    for (size_t i = 0; i < sizeof rates / sizeof rates[0]; i++)
    {
        if (wrong == NULL && whole == (uint64_t)rates[i])
        {
            return rates[i];
        }
        (void)snprintf(list + strlen(list), sizeof list - strlen(list), "%s%d", i > 0 ? ", " : "", rates[i]);
    }
    argp_error(state, "--baud %s: one of %s is expected", text, list);
    return 0;
}

static error_t take(int key, char *value, struct argp_state *state)
{
    common_error_t error   = {""};
    options_t     *options = state->input;
    uint64_t       whole   = 0;
    if (key != '?' && !common_options_add(known, key, value, &error)) // help may be asked for twice
    {
        argp_error(state, "%s", error.text);
    }
    switch (key)
    {
    case '?':
        options->wants_help = true;
        return 0;
    case OPTION_USAGE:
        argp_state_help(state, stdout, ARGP_HELP_USAGE);
        exit(finish(0));
    case OPTION_VERSION:
        (void)puts("tribo-link " TRIBO_VERSION_STRING);
        exit(finish(0));
    case 'd':
        options->device = value;
        return 0;
    case 'u':
        take_whole(state, "unit", value, 1, 247, &whole);
        options->unit = (int)whole;
        return 0;
    case OPTION_BAUD:
        options->baud = take_baud(state, value);
        return 0;
    case 'o':
        options->out = value;
        return 0;
    case OPTION_SIGNALS:
        options->signals = value;
        return 0;
    case OPTION_DECIMATION:
        take_whole(state, "decimation", value, 1, UINT32_MAX, &options->decimation);
        return 0;
    case OPTION_TRIGGER:
        options->trigger = value;
        return 0;
    case OPTION_WATCH:
        options->watch = value;
        return 0;
    case OPTION_LEVEL:
        take_number(state, "level", value, -1e6, 1e6, &options->level);
        return 0;
    case OPTION_AFTER:
        take_whole(state, "after", value, 0, UINT32_MAX, &options->after);
        return 0;
    case OPTION_WAIT:
        take_number(state, "wait", value, 0.0, 86400.0, &options->wait_s);
        return 0;
    case OPTION_HOLD:
        take_number(state, "hold", value, 0.0, 1e6, &options->hold_s);
        return 0;
    case OPTION_ACKNOWLEDGE:
        options->acknowledge = true;
        return 0;
    case OPTION_JSON:
        options->watching.json = true;
        return 0;
    case OPTION_RATE:
        take_number(state, "rate", value, 0.1, 1000.0, &options->watching.rate_hz);
        return 0;
    case OPTION_UDP:
        options->watching.udp = value;
        return 0;
    case OPTION_TELEPLOT:
        options->watching.teleplot = value;
        return 0;
    case OPTION_LISTEN:
        options->listen = value;
        return 0;
    case OPTION_ALLOW:
        options->allow = value;
        return 0;
    case OPTION_MARKDOWN:
        options->markdown = true;
        return 0;
    case ARGP_KEY_ARG:
        if (options->count == WORDS_MAX)
        {
            argp_error(state, "too many words");
        }
        options->words[options->count++] = value;
        return 0;
    case ARGP_KEY_NO_ARGS:
        options->is_short = true;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp parser = {
    .options  = known,
    .parser   = take,
    .args_doc = "[COMMAND]",
    .doc      = "Operates a drive on a serial line, over Modbus RTU, or on a network, over Modbus TCP.\v"
                "  (none)                      shows state, force and learned values, in short\n"
                "  status                      shows states, counters and signals\n"
                "  watch                       shows the same as they change; Ctrl-C ends it\n"
                "  serve                       shows the same on a page for a local browser:\n"
                "                              live plot, params, start and stop, trace\n"
                "  ports                       lists where drives answer\n"
                "  params get [NAME...]        shows the drive's params; all without a NAME\n"
                "  params set NAME=VALUE...    sets them together; refused if one does not fit.\n"
                "                              Params that tune change while the drive runs,\n"
                "                              those that protect (list --markdown) at rest:\n"
                "                              each such change is printed, and unlocked for\n"
                "                              this one command\n"
                "  params from SCENARIO.yaml   sets the loop of a scenario\n"
                "  params diff SCENARIO.yaml   shows the params that differ; exit status 1 if\n"
                "                              there are any\n"
                "  params save                 saves them in the drive's flash, with the tare\n"
                "  params defaults             sets those of the board\n"
                "  start, stop, tare           starts the loop, stops it, makes the reading 0 N\n"
                "  restore                     clears warnings; friction that faded returns\n"
                "  forget                      forgets the learned friction; not in run\n"
                "  reference N                 sets the force to hold, and renews it until a\n"
                "                              signal ends it if drive.reference_ms is not 0\n"
                "  changes                     shows the protection changes since power-up\n"
                "  fault                       shows the cause; --out writes its trace\n"
                "  trace                       records signals, for tribo-sim replay\n"
                "  list                        shows the names of all registers\n"
                "  completion bash             for bash: eval \"$(tribo-link completion bash)\""};

/// Prints the lines of the parser's text about `command`, and its options; the whole text for null.
static int show_help(const char *command)
{
    struct argp_option own[sizeof known / sizeof known[0]] = {{.name = NULL}};
    char               name[] = "tribo-link", line[256], lines[2048] = "";
    size_t             count    = 0;
    bool               is_about = false;
    if (command == NULL)
    {
        argp_help(&parser, stdout, ARGP_HELP_SHORT_USAGE | ARGP_HELP_DOC | ARGP_HELP_LONG, name);
        return 0;
    }
    for (size_t i = 0; known[i].name != NULL; i++)
    {
        if (is_of(&known[i], command))
        {
            own[count++] = known[i];
        }
    }
    for (const char *text = strchr(parser.doc, '\v') + 1; *text != '\0';
         text += strcspn(text, "\n"), text += *text == '\n')
    {
        (void)snprintf(line, sizeof line, "%.*s\n", (int)strcspn(text, "\n"), text);
        is_about = matches(line, "^  ([a-z]+, )*%s[ ,\n]", command) || (is_about && strncmp(line, "    ", 4) == 0);
        (void)strncat(lines, is_about ? line : "", sizeof lines - strlen(lines) - 1u);
    }
    if (lines[0] == '\0')
    {
        (void)link_complain("there is no command %s (tribo-link --help shows them)", command);
        return EXIT_FAILED;
    }
    const struct argp of_command = {.options = own, .args_doc = command, .doc = lines};
    argp_help(&of_command, stdout, ARGP_HELP_SHORT_USAGE | ARGP_HELP_PRE_DOC | ARGP_HELP_LONG, name);
    return 0;
}

static bool is_given(int key)
{
    size_t i = 0;
    while (common_options_at(i) != NULL && common_options_at(i)->key != key)
    {
        i++;
    }
    return common_options_at(i) != NULL;
}

/// Refuses a trace's options that its trigger ignores.
static bool check_trigger(const options_t *options)
{
    const bool is_level = strcmp(options->trigger, "rise") == 0 || strcmp(options->trigger, "fall") == 0;
    if (is_given(OPTION_LEVEL) && !is_level)
    {
        return link_complain("trace: --level needs --trigger rise or fall");
    }
    if (is_given(OPTION_WATCH) && !is_level && strcmp(options->trigger, "reversal") != 0)
    {
        return link_complain("trace: --watch needs --trigger reversal, rise or fall");
    }
    return !is_given(OPTION_AFTER) || strcmp(options->trigger, "none") != 0 ||
           link_complain("trace: --after needs a --trigger");
}

/// Refuses words behind commands that take none.
static bool check_words(const options_t *options)
{
    static const char *const with_words[] = {"params", "reference", "completion"};
    const char *const        command      = options->words[0];
    bool                     takes_words  = false;
    for (size_t i = 0; i < sizeof with_words / sizeof with_words[0]; i++)
    {
        takes_words = takes_words || strcmp(command, with_words[i]) == 0;
    }
    if (options->count > 1 && !takes_words)
    {
        return link_complain("%s takes no argument, but %s was given (tribo-link %s --help)",
                             command,
                             options->words[1],
                             command);
    }
    return options->count < 3 || strcmp(command, "params") != 0 ||
           (strcmp(options->words[1], "save") != 0 && strcmp(options->words[1], "defaults") != 0) ||
           link_complain("params %s takes no argument, but %s was given", options->words[1], options->words[2]);
}

/// Refuses options that the command would ignore.
static bool check_given(const options_t *options)
{
    for (size_t i = 0; common_options_at(i) != NULL; i++)
    {
        const struct argp_option *option = common_options_at(i);
        if (!is_of(option, options->words[0]))
        {
            return link_complain("%s has no option --%s (tribo-link %s --help)",
                                 options->words[0],
                                 option->name,
                                 options->words[0]);
        }
    }
    if (options->device != NULL && is_network(options->device) && is_given(OPTION_BAUD))
    {
        return link_complain("--baud: %s is no serial line", options->device);
    }
    return check_words(options) && (strcmp(options->words[0], "trace") != 0 || check_trigger(options));
}

int main(int count, char **arguments)
{
    static char status_word[] = "status";
    const char *device        = getenv("TRIBO_LINK_DEVICE");
    options_t   options       = {.device     = device != NULL && device[0] != '\0' ? device : NULL,
                                 .unit       = 1,
                                 .baud       = 115200,
                                 .signals    = "r_N,F_N,u_N,F_hat_N",
                                 .trigger    = "none",
                                 .watch      = "r_N",
                                 .watching   = {.rate_hz = 10.0},
                                 .listen     = "127.0.0.1:8088",
                                 .wait_s     = 10.0,
                                 .hold_s     = (double)INFINITY,
                                 .decimation = 1,
                                 .after      = 100};
    common_output_fill_descriptors();
    argp_err_exit_status = EXIT_FAILED;
    (void)argp_parse(&parser, count, arguments, ARGP_NO_HELP, NULL, &options);
    if (options.wants_help)
    {
        return finish(show_help(options.words[0]));
    }
    if (options.is_short)
    {
        options.words[options.count++] = status_word;
    }
    if (!check_given(&options))
    {
        return EXIT_FAILED;
    }
    if (strcmp(options.words[0], "list") == 0)
    {
        return finish(show_list(&options));
    }
    if (strcmp(options.words[0], "completion") == 0)
    {
        return finish(print_completion(&options));
    }
    if (strcmp(options.words[0], "ports") == 0)
    {
        return finish(link_print_devices(options.unit, options.baud) ? 0 : EXIT_FAILED);
    }
    if (perform(NULL, &options) != 0)
    {
        return EXIT_FAILED;
    }
    char found[LINK_DEVICE_MAX];
    if (options.device != NULL && options.device[0] == '\0')
    {
        (void)link_complain("--device is empty: a serial line or tcp:HOST[:PORT] is expected");
        return EXIT_FAILED;
    }
    if (options.device == NULL)
    {
        options.device = link_find_device(found, options.unit, options.baud) ? found : NULL;
    }
    common_output_clean_on_signal();
    const bool is_stop = options.device != NULL && strcmp(options.words[0], "stop") == 0;
    const int  beside  = is_stop ? link_bus_stop_beside(options.device, options.unit) : 0;
    if (beside != 0)
    {
        (void)fputs(beside > 0 ? "stopped, although another program controls the drive\n" : "", stdout);
        return finish(beside > 0 ? 0 : EXIT_FAILED);
    }
    link_bus_t *bus    = options.device != NULL ? link_bus_open(options.device, options.unit, options.baud) : NULL;
    const int   status = bus != NULL ? finish(perform(bus, &options)) : EXIT_FAILED;
    link_bus_close(bus);
    return status;
}
