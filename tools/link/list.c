#include "list.h"

#include "app/registers.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ROWS_MAX 400u

static link_row_t rows[ROWS_MAX];
static size_t     row_count;

static link_row_t *add(const char  *name,
                       link_group_t group,
                       uint32_t     address,
                       bool         is_float,
                       const char  *unit,
                       const char  *text)
{
    link_row_t *row = &rows[row_count++];
    (void)snprintf(row->name, sizeof row->name, "%s", name);
    row->group    = group;
    row->address  = (uint16_t)address;
    row->is_float = is_float;
    row->unit     = unit[0] != '-' ? unit : "";
    row->text     = text;
    row->least    = (double)(group != LINK_PARAM                                     ? PARAMS_LEAST_N
                             : address < REGISTERS_STAGED_AT + REGISTERS_SECTIONS_AT ? params_least(0)
                                                                                     : params_least(PARAMS_SECTIONS_AT));
    return row;
}

static link_row_t *set_range(link_row_t *row, double low, double high, bool can_be_0, double normal)
{
    row->has_range = true;
    row->low       = low;
    row->high      = high;
    row->can_be_0  = can_be_0;
    row->normal    = normal;
    return row;
}

#define IS_FLOAT(type) ((type)0.5 != (type)0)

static void add_states_and_requests(void)
{
    uint32_t address = REGISTERS_STATE_AT;
#define STATE(symbol, name, type, unit, text)                                                                          \
    (void)add(name, LINK_STATE, address, IS_FLOAT(type), unit, text);                                                  \
    address += 2u;
    REGISTERS_STATE(STATE)
    address = REGISTERS_COMPENSATION_AT;
    REGISTERS_COMPENSATION(STATE)
#undef STATE
    address = REGISTERS_SIGNALS_AT;
#define SIGNAL(symbol, name, unit, member, text)                                                                       \
    (void)add(name, LINK_SIGNAL, address, true, unit, text);                                                           \
    address += 2u;
    REGISTERS_SIGNALS(SIGNAL)
#undef SIGNAL
    address = REGISTERS_REQUESTS_AT;
#define REQUEST(symbol, name, type, unit, standard, text)                                                              \
    add(name, LINK_REQUEST, address, IS_FLOAT(type), unit, text)->normal = (double)(standard);                         \
    address += 2u;
    REGISTERS_REQUESTS(REQUEST)
#undef REQUEST
    address = REGISTERS_CHANGES_AT;
    for (unsigned i = 0; i < REGISTERS_CHANGES; i++)
    {
        char full[32];
#define CHANGE(symbol, name, type, unit, text)                                                                         \
    (void)snprintf(full, sizeof full, "changes[%u].%s", i, name);                                                      \
    (void)add(full, LINK_CHANGE, address, false, unit, text);                                                          \
    address += 2u;
        REGISTERS_CHANGE(CHANGE)
#undef CHANGE
    }
}

static void add_fields(void)
{
    char     name[72];
    uint32_t address = REGISTERS_STAGED_AT + REGISTERS_DRIVE_AT;
#define DRIVE(type, field, unit, low, high, off, standard, change, text)                                               \
    {                                                                                                                  \
        link_row_t *row = add("drive." #field, LINK_PARAM, address, IS_FLOAT(type), unit, text);                       \
        (void)set_range(row, (double)(low), (double)(high), (off) != 0, (double)(standard));                           \
        row->protects = true;                                                                                          \
        row->wired    = DRIVE_##change == DRIVE_WIRED;                                                                 \
        address += 2u;                                                                                                 \
    }
    DRIVE_CONFIG_FIELDS(DRIVE)
#undef DRIVE
#define FIELD(group, symbol, member, key, unit, low, high, standard, change, number, condition, sentence)              \
    set_range(add(TRIBO_KEY_##group key,                                                                               \
                  LINK_PARAM,                                                                                          \
                  REGISTERS_STAGED_AT + (number),                                                                      \
                  PARAMS_##symbol != PARAMS_SECTION_COUNT && PARAMS_##symbol != PARAMS_TABLE_LENGTH,                   \
                  unit,                                                                                                \
                  sentence),                                                                                           \
              (double)(low),                                                                                           \
              (double)(high),                                                                                          \
              false,                                                                                                   \
              (double)(standard))                                                                                      \
        ->protects = TRIBO_##change != 0;
    PARAMS_LOOP_ROWS(FIELD)
    (void)set_range(
        add("compensator.method", LINK_PARAM, REGISTERS_STAGED_AT + REGISTERS_METHOD_AT, false, "", PARAMS_METHOD_TEXT),
        PARAMS_METHOD_PAPER,
        PARAMS_METHOD_SENSORLESS,
        false,
        PARAMS_METHOD_FEEDFORWARD);
    PARAMS_FEED_ROWS(FIELD)
    address = REGISTERS_STAGED_AT + REGISTERS_GUARD_AT;
    (void)
        set_range(add("compensator.guard.on", LINK_PARAM, address, false, "", PARAMS_GUARD_TEXT), 0.0, 1.0, false, 1.0);
    PARAMS_GUARD_ROWS(FIELD)
#undef FIELD
    const params_set_t set = params_default();
    address                = REGISTERS_STAGED_AT + REGISTERS_SECTIONS_AT;
    for (unsigned i = 0; i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
#define SECTION(symbol, member, last, unit, low, high, text)                                                           \
    (void)snprintf(name, sizeof name, "controller.sections[%u].%s", i, last);                                          \
    (void)set_range(add(name, LINK_PARAM, address, true, unit, text),                                                  \
                    (double)(low),                                                                                     \
                    (double)(high),                                                                                    \
                    false,                                                                                             \
                    (double)set.sections[i].member);                                                                   \
    address += 2u;
        TRIBO_SECTION_ELEMENTS(SECTION)
#undef SECTION
    }
    address = REGISTERS_STAGED_AT + REGISTERS_TABLE_AT;
    for (unsigned i = 0; i < TRIBO_BREAKAWAY_POINTS_MAX; i++)
    {
#define POINT(symbol, member, last, unit, low, high, text)                                                             \
    (void)snprintf(name, sizeof name, "compensator.friction.breakaway.table[%u].%s", i, last);                         \
    (void)set_range(add(name, LINK_PARAM, address, true, unit, text), (double)(low), (double)(high), false, 0.0);      \
    address += 2u;
        TRIBO_POINT_ELEMENTS(POINT)
#undef POINT
    }
}

static int compare_addresses(const void *left, const void *right)
{
    const link_row_t *const a = left;
    const link_row_t *const b = right;
    return a->group != b->group ? (a->group > b->group) - (a->group < b->group)
                                : (a->address > b->address) - (a->address < b->address);
}

const link_row_t *link_list(size_t *count)
{
    if (row_count == 0u)
    {
        add_states_and_requests();
        add_fields();
        qsort(rows, row_count, sizeof rows[0], compare_addresses); // the library's list is not in the registers' order
    }
    *count = row_count;
    return rows;
}

const link_row_t *link_find(const char *name)
{
    size_t            count;
    const link_row_t *list = link_list(&count);
    for (size_t i = 0; i < count; i++)
    {
        if (strcmp(list[i].name, name) == 0)
        {
            return &list[i];
        }
    }
    return NULL;
}

const link_row_t *link_at(uint16_t address)
{
    size_t            count;
    const link_row_t *list = link_list(&count);
    for (size_t i = 0; i < count; i++)
    {
        if (list[i].address == address)
        {
            return &list[i];
        }
    }
    return NULL;
}

const char *link_nearest(const char *part, bool params_only)
{
    size_t            count;
    const link_row_t *list = link_list(&count);
    for (size_t i = 0; i < count; i++)
    {
        if ((list[i].group == LINK_PARAM || !params_only) && strstr(list[i].name, part) != NULL)
        {
            return list[i].name;
        }
    }
    return NULL;
}

const uint16_t link_command_at    = REGISTERS_COMMAND_AT;
const uint16_t link_window_at     = REGISTERS_WINDOW_AT;
const uint16_t link_active_offset = REGISTERS_ACTIVE_AT - REGISTERS_STAGED_AT;
const unsigned link_apply         = REGISTERS_APPLY;
const unsigned link_stop          = REGISTERS_STOP;
const uint32_t link_key           = REGISTERS_KEY;
const unsigned link_version       = REGISTERS_VERSION;
const uint32_t link_store_failed  = STORE_FAILED;

_Static_assert(LINK_WINDOW == REGISTERS_WINDOW && (unsigned)LINK_DONE == (unsigned)REGISTERS_DONE &&
                   (unsigned)LINK_BUSY == (unsigned)REGISTERS_BUSY &&
                   (unsigned)LINK_WRONG_STATE == (unsigned)REGISTERS_WRONG_STATE &&
                   (unsigned)LINK_NOT_SAVED == (unsigned)REGISTERS_NOT_SAVED &&
                   (unsigned)LINK_SET_REFUSED == (unsigned)REGISTERS_SET_REFUSED &&
                   (unsigned)LINK_TRACE_REFUSED == (unsigned)REGISTERS_TRACE_REFUSED &&
                   (unsigned)LINK_PROTECTED == (unsigned)REGISTERS_PROTECTED &&
                   (unsigned)LINK_LOCKED == (unsigned)REGISTERS_LOCKED,
               "as in registers.h");

uint32_t link_layout(bool feeds_forward)
{
    return PARAMS_LAYOUT_OF(feeds_forward);
}

bool link_is_of_feedforward(const link_row_t *row)
{
    const uint32_t at = REGISTERS_STAGED_AT + REGISTERS_FEED_AT;
    return (row->address >= at && row->address < REGISTERS_STAGED_AT + REGISTERS_SECTIONS_AT) ||
           (row->address >= REGISTERS_COMPENSATION_AT && row->address < REGISTERS_COMMAND_AT);
}

const char *link_outcome_text(uint32_t outcome)
{
    static const char *const texts[] = {
#define OUTCOME(symbol, text) text,
        REGISTERS_OUTCOMES(OUTCOME)
#undef OUTCOME
    };
    return outcome < sizeof texts / sizeof texts[0] ? texts[outcome] : "unknown outcome";
}

// --- the document --------------------------------------------------------------------------------------------------

static void print_text(const char *text)
{
    for (; *text != '\0'; text++)
    {
        (void)printf("%s%c", *text == '|' ? "\\" : "", *text);
    }
}

static void print_row(const link_row_t *row)
{
    (void)printf("| `%s` | 0x%04x | %s | %s | ",
                 row->name,
                 row->address,
                 row->is_float ? "float32" : "uint32",
                 row->unit[0] != '\0' ? row->unit : "-");
    if (row->has_range)
    {
        (void)printf("%g to %g%s | %g | %s | ",
                     row->low,
                     row->high,
                     row->can_be_0 ? ", 0: off" : "",
                     row->normal,
                     row->wired      ? "wired"
                     : row->protects ? "protects"
                                     : "tunes");
    }
    else if (row->group == LINK_REQUEST)
    {
        (void)printf("%g | ", row->normal);
    }
    print_text(row->text);
    (void)fputs(" |\n", stdout);
}

/// Elements of a list after the first are left out: their addresses follow.
static void print_group(link_group_t group)
{
    size_t            count;
    const link_row_t *list = link_list(&count);
    for (size_t i = 0; i < count; i++)
    {
        const char *element = strchr(list[i].name, '[');
        if (list[i].group == group && (element == NULL || element[1] == '0'))
        {
            print_row(&list[i]);
        }
    }
}

static void print_words(void)
{
    (void)fputs(
        "\n## Commands\n\nWritten to 0x0100, the only register of 16 bits, by function 6 or 16. A command that the "
        "drive "
        "refuses is\nanswered by exception 4 (or 6: later) and `outcome` says why.\n\n| command | effect "
        "|\n|---|---|\n",
        stdout);
#define COMMAND(symbol, number, text) (void)printf("| %d | %s |\n", number, text);
    REGISTERS_COMMANDS(COMMAND)
#undef COMMAND
    (void)fputs("\n| `outcome` | meaning |\n|---|---|\n", stdout);
    int outcome = 0;
#define OUTCOME(symbol, text) (void)printf("| %d | %s |\n", outcome++, text);
    REGISTERS_OUTCOMES(OUTCOME)
#undef OUTCOME
    (void)fputs("\n| `fault` | meaning |\n|---|---|\n", stdout);
    for (int fault = 0; fault < DRIVE_FAULTS; fault++)
    {
        (void)printf("| %d | %s |\n", fault, drive_fault_text((drive_fault_t)fault));
    }
    (void)fputs("\n| bit of `warnings` | meaning |\n|---|---|\n", stdout);
    for (unsigned bit = 1; bit < DRIVE_WARNINGS_END; bit <<= 1)
    {
        (void)printf("| %u | %s |\n", bit, drive_warning_text((drive_warning_t)bit));
    }
}

void link_print_markdown(void)
{
    (void)printf(
        "# Registers\n\nPrinted by `tribo-link list --markdown`, version %u of the lists in firmware/app/registers.h, "
        "params.h "
        "and config.h.\n\n"
        "The drive speaks Modbus RTU at 115200 8N1, or Modbus TCP, with functions 3, 6, 16 and 23. Every register but "
        "the "
        "command has 32 bits:\ntwo Modbus registers, the high one at the address given, the low one at the next. A "
        "write "
        "must hold both. A number that is infinite, NaN or implausibly small is\nrefused with exception 3, "
        "as it usually means that words or bytes are in the wrong order: a force below %.0e N, a param below %.0e,\nin "
        "a section or the table below %.0e. 0 is taken, and a master that computes r rounds it. -0 counts as 0. "
        "[firmware/README.md](../firmware/README.md)\nexplains how the registers work together.\n\n"
        "## Params\n\nThe staged set is read and written at these addresses. The set that the drive runs with is read "
        "at "
        "an address 0x%04x higher. Names are keys\nof a scenario, or `drive.` and a field of firmware/app/config.h. Of "
        "a "
        "list the first element is shown.\n\nA param that tunes may change while the drive runs. A param that protects "
        "changes only at rest: stop the drive, write 0x%08x to `unlock`,\nand apply the set within %u s. The sign of "
        "the "
        "controller's gain protects, too: that of the product of all `b0`, and of all `b2`. Where a section's\n`b2` is "
        "0, "
        "its `b1` counts, or its `b0` if that is 0 as well. No set may exceed the ceilings of its board. A param that "
        "is "
        "wired is fixed by\nthe board's image or by tribo-drive's configuration.\n\nThe staged set and the key belong "
        "to "
        "the client that wrote them. Both end with its connection, or after %u s without a request. A frame to\nall "
        "units "
        "stops the drive, and does nothing else.\n\n`protection` is the CRC-32 (IEEE 802.3) of the words of all "
        "registers "
        "that protect or are wired, in the order of their addresses, the zero of\nthe sensor without a tare, and of "
        "these "
        "two signs. A sign is 1, 0 or -1 in 32 bits. Each word has its low byte first.\n\n"
        "| name | address | type | unit | range | default | class | what |\n|---|---|---|---|---|---|---|---|\n",
        REGISTERS_VERSION,
        (double)PARAMS_LEAST_N,
        (double)params_least(0),
        (double)params_least(PARAMS_SECTIONS_AT),
        REGISTERS_ACTIVE_AT - REGISTERS_STAGED_AT,
        REGISTERS_KEY,
        REGISTERS_UNLOCK_S,
        REGISTERS_CLIENT_S);
    print_group(LINK_PARAM);
    print_words();
    (void)fputs("\n## Requests\n\nThese can be read and written.\n\n| name | address | type | unit | default | what "
                "|\n|---|---|---|---|---|---|\n",
                stdout);
    print_group(LINK_REQUEST);
    (void)fputs(
        "\n## States and counters\n\nRead only.\n\n| name | address | type | unit | what |\n|---|---|---|---|---|\n",
        stdout);
    print_group(LINK_STATE);
    (void)printf(
        "\n## Protection changes\n\nRead only. The change whose number is n, from 0, is at element n modulo %u; "
        "`protection_changes` counts them.\n\n| name | address | type | unit | what |\n|---|---|---|---|---|\n",
        REGISTERS_CHANGES);
    print_group(LINK_CHANGE);
    (void)fputs(
        "\n## Signals\n\nThese are of the last tick and read only; their order is that of `trace.signals`.\n\n| name | "
        "address | type | unit | what |\n|---|---|---|---|---|\n",
        stdout);
    print_group(LINK_SIGNAL);
    (void)printf("\n## Trace window\n\nAt 0x%04x, %u values of 32 bits (float32, N), read only: those of sample "
                 "`trace.position`, then those "
                 "of the samples after it.\nA sample has the signals of `trace_signals_seen` in their order. Written "
                 "and read in one frame "
                 "by function 23.\n",
                 REGISTERS_WINDOW_AT,
                 REGISTERS_WINDOW);
}
