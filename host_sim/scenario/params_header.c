// This source is compiled once for each arithmetic.

#include "scenario/params_header.h"

#include "tribo_arithmetic.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#if TRIBO_IS_Q31
#define UPPER "Q31"
#define IN_F32(...)
#define IN_Q31(...) __VA_ARGS__,
#else
#define UPPER       "F32"
#define IN_F32(...) __VA_ARGS__,
#define IN_Q31(...)
#endif

// --- the fields of params ------------------------------------------------------------------------------------------

typedef enum
{
    FLOAT,
    UINT8,
    UINT16,
    UINT32,
    INT32,
    INT64,
    BOOL,
    TABLE,      ///< pointer to breakaway points, defined before the params
    METHOD,     ///< pointer to a method, the first member of params defined before these
    GUARD,      ///< pointer to params of a guard, defined before these
    FUNCTIONS,  ///< the functions of a method, written by one function of the library
    GUARD_STEP, ///< the step function of a guard
    STRUCT,     ///< a struct with rows of its own, a line for each
    SMALL       ///< a struct with rows of its own, on one line
} kind_t;

typedef struct field
{
    const char         *name;
    kind_t              kind;
    size_t              offset, size;          ///< offset in the struct, and size of an element
    size_t              count;                 ///< number of elements; 0: not an array
    size_t              counter, counter_size; ///< offset and size of the field with the number in use; size 0: all are
    const struct field *rows;                  ///< rows of a struct, ended by one without a name
} field_t;

// A field's kind follows from its type, so a row needs only the name. T is the struct that the rows describe.
// clang-format off
// NOLINTBEGIN(bugprone-macro-parentheses,bugprone-sizeof-expression): the arguments are names, one of which names a pointer
#define KIND(x) _Generic((x), float: FLOAT, uint8_t: UINT8, uint16_t: UINT16, uint32_t: UINT32, int32_t: INT32, int64_t: INT64, bool: BOOL, \
    const TRIBO(force_loop, method_t) *: METHOD, const TRIBO(guard, params_t) *: GUARD, TRIBO(force_loop, method_t): FUNCTIONS, \
    const tribo_point_t *: TABLE, default: GUARD_STEP)
#define AT(member) (((T *)0)->member)
#define TEXT(member) #member
#define PLACE(member) .name = TEXT(member), .offset = offsetof(T, member)
#define F(member) {PLACE(member), .kind = KIND(AT(member)), .size = sizeof AT(member)}
#define ARRAY(member) {PLACE(member), .kind = KIND(AT(member[0])), .size = sizeof AT(member[0]), .count = sizeof AT(member) / sizeof AT(member[0])}
#define S(member, rows_) {PLACE(member), .kind = STRUCT, .size = sizeof AT(member), .rows = (rows_)}
#define SMALLS(member, rows_) {PLACE(member), .kind = SMALL, .size = sizeof AT(member[0]), .count = sizeof AT(member) / sizeof AT(member[0]), .rows = (rows_)}
#define STRUCTS(member, counter_, rows_) {PLACE(member), .kind = STRUCT, .size = sizeof AT(member[0]), .count = 1, \
    .counter = offsetof(T, counter_), .counter_size = sizeof AT(counter_), .rows = (rows_)}
#define END {.name = NULL}

#define T TRIBO(biquad, section_t)
static const field_t section[] = {F(b0), IN_F32(F(b1), F(b2), F(a1), F(a2))
    IN_Q31(F(c1), F(minus_a1), F(c2), F(d2), F(d2_low), F(shift), F(scale)) END};
#undef T
#define T TRIBO(biquad, params_t)
static const field_t cascade[] = {STRUCTS(section, count, section), F(count), IN_Q31(F(input_scale), F(output_scale)) END};
#undef T
#define T TRIBO(controller, params_t)
static const field_t controller[] = {S(cascade, cascade), F(anti_windup), IN_Q31(F(taken_max)) F(TRIBO_N(u_min)), F(TRIBO_N(u_max)),
    IN_Q31(F(anti_windup_shift)) END};
#undef T
#define T TRIBO(breakaway, t)
static const field_t law[] = {F(TRIBO_N(offset)), F(slope), END};
#undef T
#define T tribo_point_t
static const field_t point[] = {F(TRIBO_N(force)), F(TRIBO_N(positive)), F(TRIBO_N(negative)), END};
#undef T
#if !TRIBO_IS_Q31
#define T tribo_friction_f32_k_t
static const field_t k[] = {F(at_0), F(per_power), END};
#undef T
#endif
#define T TRIBO(friction, params_t)
static const field_t friction[] = {IN_F32(F(rate_hz), F(exponent_per_rise)) IN_Q31(F(rise_max), F(exponent_rate)) F(exponent_at_rest),
    IN_F32(SMALLS(k, k)) IN_Q31(F(k_min), F(k_max)) SMALLS(law, law), F(table), F(set_level), F(reset_level), F(TRIBO_N(gravity)),
    IN_Q31(ARRAY(law_whole), F(rise_shift), F(k_shift), F(is_shallow)) F(table_length), F(pulse_width), END};
#undef T
#define T TRIBO(arm, params_t)
static const field_t arm[] = {F(phi_d), F(phi_g), F(gamma_d), F(gamma_g), IN_Q31(F(shift)) END};
#undef T
#define T TRIBO(compensator, params_t)
static const field_t compensator[] = {S(friction, friction), S(arm, arm), END};
#undef T
#define T TRIBO(force_loop, params_t)
static const field_t loop_fields[] = {F(TRIBO_N(input_max)), F(gain), S(controller, controller), S(compensator, compensator), F(method), F(guard), END};
#undef T
#define T tribo_feedforward_learning_t
static const field_t learning[] = {F(breakaway_n), F(reversal_n), ARRAY(per_n), ARRAY(deviation), F(jump_lag), F(forgetting_per_n), F(trust), F(unit_n), F(rig), END};
#undef T
#define T TRIBO(feedforward, params_t)
static const field_t feedforward[] = {
    F(method), F(input_max), F(offset_max), F(reversal), ARRAY(stop_gain), F(jump), F(lead_gain), F(lag_gain), F(damping_gain),
    F(step), F(noise_floor), F(noise_part), F(slow_part), F(fast_part), F(lag_part), F(actuator_part), F(sensor_part),
    F(leak_part), F(trust), F(still_ticks), F(quick_ticks), S(learning, learning), END};
#undef T
#define T TRIBO(guard, params_t)
static const field_t guard[] = {F(step), F(on), F(TRIBO_N(half)), F(TRIBO_N(stray)), F(work), F(fade_step), F(quick_ticks), END};
#undef T
// NOLINTEND(bugprone-macro-parentheses,bugprone-sizeof-expression)
// clang-format on

// --- values as C ---------------------------------------------------------------------------------------------------

typedef struct
{
    FILE       *stream;
    const char *name;   ///< name of the params
    const char *method; ///< the method's part of the name of its function
} sheet_t;

static uint32_t unsigned_at(const char *at, size_t size)
{
    uint8_t  byte = 0;
    uint16_t half = 0;
    uint32_t word = 0;
    memcpy(size == 1 ? (void *)&byte : size == 2 ? (void *)&half : (void *)&word, at, size);
    return byte + half + word;
}

/// Writes the address of a part that is defined before these params and begins with their name.
static void put_address(const sheet_t *sheet, kind_t kind, bool is_there)
{
    switch (is_there ? kind : STRUCT)
    {
    case TABLE:
        (void)fprintf(sheet->stream, "%s_table", sheet->name);
        break;
    case METHOD:
        (void)fprintf(sheet->stream, "&%s_feedforward.method", sheet->name);
        break;
    case GUARD:
        (void)fprintf(sheet->stream, "&%s_guard", sheet->name);
        break;
    default:
        (void)fputs("NULL", sheet->stream);
        break;
    }
}

static void put_scalar(const sheet_t *sheet, const field_t *field, const char *at)
{
    float       real    = 0.0f;
    int32_t     integer = 0;
    int64_t     wide    = 0;
    const void *pointer = NULL;
    switch (field->kind)
    {
    case FLOAT: // nine digits keep every bit
        memcpy(&real, at, sizeof real);
        (void)fprintf(sheet->stream, "%.8ef", (double)real);
        break;
    case INT32: // INT32_MIN has no constant of its type
        memcpy(&integer, at, sizeof integer);
        (void)fprintf(sheet->stream, integer == INT32_MIN ? "-2147483647 - 1" : "%" PRId32, integer);
        break;
    case INT64: // never INT64_MIN: a product of two int32_t
        memcpy(&wide, at, sizeof wide);
        (void)fprintf(sheet->stream, "INT64_C(%" PRId64 ")", wide);
        break;
    case BOOL:
        (void)fputs(unsigned_at(at, field->size) != 0 ? "true" : "false", sheet->stream);
        break;
    case TABLE:
    case METHOD:
    case GUARD:
        memcpy((void *)&pointer, at, sizeof pointer);
        put_address(sheet, field->kind, pointer != NULL);
        break;
    case FUNCTIONS: // params begin with these
        (void)fprintf(sheet->stream, "{tribo_%s_" TRIBO_ARITHMETIC "_method}", sheet->method);
        break;
    case GUARD_STEP:
        (void)fputs("tribo_guard_" TRIBO_ARITHMETIC "_step", sheet->stream);
        break;
    default:
        (void)fprintf(sheet->stream, "%" PRIu32 "u", unsigned_at(at, field->size));
        break;
    }
}

/// Writes a struct on one line: "{.offset = 1u, .slope = 2u}".
static void put_small(const sheet_t *sheet, const field_t *rows, const char *at)
{
    for (const field_t *row = rows; row->name != NULL; row++)
    {
        (void)fprintf(sheet->stream, "%s.%s = ", row == rows ? "{" : ", ", row->name);
        put_scalar(sheet, row, at + row->offset);
    }
    (void)fputs("}", sheet->stream);
}

static void put_rows(const sheet_t *sheet, const field_t *rows, const char *at, int indent);

/// Writes the elements of an array of structs, or one struct.
static void put_structs(const sheet_t *sheet, const field_t *field, const char *at, size_t count, int indent)
{
    (void)fputs("{\n", sheet->stream);
    for (size_t i = 0; i < count; i++)
    {
        const char *element = at + i * field->size;
        if (field->kind == SMALL)
        {
            (void)fprintf(sheet->stream, "%*s", indent + 4, "");
            put_small(sheet, field->rows, element);
            (void)fputs(",\n", sheet->stream);
        }
        else if (field->count == 0)
        {
            put_rows(sheet, field->rows, element, indent + 4);
        }
        else
        {
            (void)fprintf(sheet->stream, "%*s{\n", indent + 4, "");
            put_rows(sheet, field->rows, element, indent + 8);
            (void)fprintf(sheet->stream, "%*s},\n", indent + 4, "");
        }
    }
    (void)fprintf(sheet->stream, "%*s}", indent, "");
}

/// Writes the rows of the struct at `at`, a line for each.
static void put_rows(const sheet_t *sheet, const field_t *rows, const char *at, int indent)
{
    for (const field_t *row = rows; row->name != NULL; row++)
    {
        const char *value = at + row->offset;
        (void)fprintf(sheet->stream, "%*s.%s = ", indent, "", row->name);
        if (row->rows != NULL)
        {
            const size_t fixed = (row->count > 0) ? row->count : 1;
            const size_t count = (row->counter_size > 0) ? unsigned_at(at + row->counter, row->counter_size) : fixed;
            put_structs(sheet, row, value, count, indent);
        }
        else
        {
            for (size_t i = 0; i < row->count; i++)
            {
                (void)fputs(i == 0 ? "{" : ", ", sheet->stream);
                put_scalar(sheet, row, value + i * row->size);
            }
            if (row->count == 0)
            {
                put_scalar(sheet, row, value);
            }
            (void)fputs(row->count > 0 ? "}" : "", sheet->stream);
        }
        (void)fputs(",\n", sheet->stream);
    }
}

/// Writes the params of a part, `noun`, if there are any.
static void put_own(const sheet_t *sheet, const char *noun, const field_t *rows, const void *params)
{
    if (params != NULL)
    {
        (void)fprintf(sheet->stream,
                      "static const tribo_%s_" TRIBO_ARITHMETIC "_params_t %s_%s = {\n",
                      noun,
                      sheet->name,
                      strcmp(noun, "force_loop") == 0 ? "params" : noun);
        put_rows(sheet, rows, params, 4);
        (void)fputs("};\n", sheet->stream);
    }
}

/// Writes the breakaway table, if there is one, and the params.
static void put_loop(const sheet_t *sheet, const TRIBO(force_loop, params_t) * params)
{
    const field_t points                = {.kind = SMALL, .size = sizeof(tribo_point_t), .rows = point};
    const TRIBO(friction, params_t) *in = &params->compensator.friction;
    if (in->table != NULL)
    {
        (void)fprintf(sheet->stream,
                      "static const tribo_breakaway_point_" TRIBO_ARITHMETIC "_t %s_table[] = ",
                      sheet->name);
        put_structs(sheet, &points, (const char *)in->table, in->table_length, 0);
        (void)fputs(";\n", sheet->stream);
    }
    put_own(sheet, "feedforward", feedforward, params->method);
    put_own(sheet, "guard", guard, params->guard);
    put_own(sheet, "force_loop", loop_fields, params);
}

// --- the header around them ----------------------------------------------------------------------------------------

static void put_upper(FILE *stream, const char *name)
{
    for (; *name != '\0'; name++)
    {
        (void)fputc(toupper((unsigned char)*name), stream);
    }
}

/// Writes a user's text, reduced to one line of ASCII.
static void put_quoted(FILE *stream, const char *text)
{
    (void)fputc('"', stream);
    for (; *text != '\0'; text++)
    {
        (void)fputc(isprint((unsigned char)*text) ? *text : '?', stream);
    }
    (void)fputc('"', stream);
}

static void put_comment(FILE *stream, const sim_params_header_t *header)
{
    const tribo_force_loop_f32_config_t *config = header->config;
    (void)fprintf(
        stream,
        "/// Params of the force loop \"%s\" in %s, made by tribo-sim params: change its input, not this file.\n"
        "///\n"
        "///     scenario     ",
        header->name,
        TRIBO_EITHER("f32", "Q31"));
    put_quoted(stream, header->scenario);
    for (int i = 0; i < header->set_count; i++)
    {
        (void)fputs("\n///     --set        ", stream);
        put_quoted(stream, header->sets[i]);
    }
    if (header->description[0] != '\0')
    {
        (void)fputs("\n///     description  ", stream);
        put_quoted(stream, header->description);
    }
    (void)fprintf(stream, "\n///     tick         %g s\n", (double)config->sample_time_s);
    if (TRIBO_IS_Q31)
    {
        (void)fprintf(stream, "///     full scale   %g N is 2^31\n", header->loop->full_scale_n);
    }
    (void)fprintf(stream,
                  "///     u            %g to %g N\n"
                  "///     |r| and |y|  up to %g N\n"
                  "///     gain         %g, of a controller of %u sections\n"
                  "///\n"
                  "/// Equal to the result of the library's init function. Include it in one file of a program, which "
                  "then needs no "
                  "set-up code.\n\n",
                  (double)config->controller.u_min_n,
                  (double)config->controller.u_max_n,
                  (double)config->input_max_n,
                  (double)config->gain,
                  (unsigned)config->controller.section_count);
}

static void put_define(FILE *stream, const sim_params_header_t *header, const char *what, double value)
{
    (void)fputs("#define ", stream);
    put_upper(stream, header->name);
    (void)fprintf(stream, "_%s %.8ef\n", what, value);
}

void TRIBO_PART(sim_params_header, write)(FILE *stream, const sim_params_header_t *header)
{
    const TRIBO(force_loop, params_t) *params = &TRIBO_EITHER(header->loop->in_f32, header->loop->in_q31).params;
    const char *const guards[2]               = {"#ifndef ", "#define "};
    put_comment(stream, header);
    // The guard contains the arithmetic: with one name in both, neither header is skipped and the compiler reports a redeclaration.
    for (size_t i = 0; i < 2; i++)
    {
        (void)fputs(guards[i], stream);
        put_upper(stream, header->name);
        (void)fputs("_PARAMS_" UPPER "_H\n", stream);
    }
    (void)fprintf(stream,
                  "\n#include \"tribo/%s_" TRIBO_ARITHMETIC ".h\"\n\n"
                  "#if TRIBO_FORCE_LOOP_" UPPER "_PARAMS_VERSION != %d\n"
                  "#error \"made for another version of tribo: run tribo-sim params again\"\n"
                  "#endif\n\n"
                  "#if defined(__cplusplus) && __cplusplus < 202002L && defined(__GNUC__)\n"
                  "#pragma GCC system_header // no warning that members are named as in C and C++20\n"
                  "#endif\n\n// clang-format off\n",
                  header->is_sensorless || params->method != NULL ? "feedforward" : "force_loop",
                  TRIBO_EITHER(TRIBO_FORCE_LOOP_F32_PARAMS_VERSION, TRIBO_FORCE_LOOP_Q31_PARAMS_VERSION));
    put_define(stream, header, "SAMPLE_TIME_S", (double)header->config->sample_time_s);
    if (TRIBO_IS_Q31)
    {
        put_define(stream, header, "FULL_SCALE_N", (double)(float)header->loop->full_scale_n);
    }
    (void)fputs("\n", stream);
    put_loop(&(sheet_t){.stream = stream,
                        .name   = header->name,
                        .method = header->is_sensorless ? "sensorless" : "feedforward"},
             params);
    (void)fputs("// clang-format on\n\n#endif\n", stream);
}
