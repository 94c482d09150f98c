#include "cli/params_header.h"

#include <ctype.h>
#include <inttypes.h>
#include <string.h>

/// Where a sheet of C is written: each line indented by the depth of its braces.
typedef struct
{
    FILE    *stream;
    unsigned depth;
} sheet_t;

static void indent(const sheet_t *sheet)
{
    (void)fprintf(sheet->stream, "%*s", 4 * (int)sheet->depth, "");
}

static void open_brace(sheet_t *sheet, const char *field)
{
    indent(sheet);
    (void)fprintf(sheet->stream, field[0] != '\0' ? ".%s = {\n" : "{\n", field);
    sheet->depth++;
}

static void close_brace(sheet_t *sheet)
{
    sheet->depth--;
    indent(sheet);
    (void)fputs("},\n", sheet->stream);
}

/// Nine digits are every bit of a float.
static void put_float(const sheet_t *sheet, const char *field, float x)
{
    indent(sheet);
    (void)fprintf(sheet->stream, ".%s = %.8ef,\n", field, (double)x);
}

static void put_unsigned(const sheet_t *sheet, const char *field, uint32_t x)
{
    indent(sheet);
    (void)fprintf(sheet->stream, ".%s = %" PRIu32 "u,\n", field, x);
}

/// INT32_MIN has no constant of its type.
static void put_int(const sheet_t *sheet, const char *field, int32_t x)
{
    indent(sheet);
    if (x == INT32_MIN)
    {
        (void)fprintf(sheet->stream, ".%s = -2147483647 - 1,\n", field);
        return;
    }
    (void)fprintf(sheet->stream, ".%s = %" PRId32 ",\n", field, x);
}

static void put_table(const sheet_t *sheet, const sim_params_header_t *header, bool exists)
{
    indent(sheet);
    (void)fprintf(sheet->stream, ".table = %s%s,\n", exists ? header->name : "NULL", exists ? "_table" : "");
}

// --- f32 -----------------------------------------------------------------------------------------------------------

static void put_law_f32(const sheet_t *sheet, const tribo_breakaway_f32_t *law)
{
    indent(sheet);
    (void)fprintf(sheet->stream, "{.offset_n = %.8ef, .slope = %.8ef},\n", (double)law->offset_n, (double)law->slope);
}

static void put_controller_f32(sheet_t *sheet, const tribo_controller_f32_params_t *p)
{
    open_brace(sheet, "controller");
    open_brace(sheet, "cascade");
    open_brace(sheet, "section");
    for (uint32_t i = 0; i < p->cascade.count; i++)
    {
        const tribo_biquad_f32_section_t *s = &p->cascade.section[i];
        open_brace(sheet, "");
        put_float(sheet, "b0", s->b0);
        put_float(sheet, "b1", s->b1);
        put_float(sheet, "b2", s->b2);
        put_float(sheet, "a1", s->a1);
        put_float(sheet, "a2", s->a2);
        close_brace(sheet);
    }
    close_brace(sheet);
    put_unsigned(sheet, "count", p->cascade.count);
    put_unsigned(sheet, "pair_input_end", p->cascade.pair_input_end);
    put_unsigned(sheet, "output_end", p->cascade.output_end);
    close_brace(sheet);
    put_float(sheet, "anti_windup", p->anti_windup);
    put_float(sheet, "u_min_n", p->u_min_n);
    put_float(sheet, "u_max_n", p->u_max_n);
    close_brace(sheet);
}

static void put_friction_f32(sheet_t *sheet, const sim_params_header_t *header, const tribo_friction_f32_params_t *p)
{
    open_brace(sheet, "friction");
    put_float(sheet, "rate_hz", p->rate_hz);
    put_float(sheet, "y_per_rise", p->y_per_rise);
    put_float(sheet, "y_at_0", p->y_at_0);
    open_brace(sheet, "k");
    for (int i = 0; i < 2; i++)
    {
        indent(sheet);
        (void)fprintf(sheet->stream, "{.at_0 = %.8ef, .per_w = %.8ef},\n", (double)p->k[i].at_0, (double)p->k[i].per_w);
    }
    close_brace(sheet);
    open_brace(sheet, "law");
    put_law_f32(sheet, &p->law[0]);
    put_law_f32(sheet, &p->law[1]);
    close_brace(sheet);
    open_brace(sheet, "reset");
    put_law_f32(sheet, &p->reset[0]);
    put_law_f32(sheet, &p->reset[1]);
    close_brace(sheet);
    put_table(sheet, header, p->table != NULL);
    put_float(sheet, "set_level", p->set_level);
    put_float(sheet, "reset_level", p->reset_level);
    put_float(sheet, "gravity_n", p->gravity_n);
    put_unsigned(sheet, "table_length", p->table_length);
    put_unsigned(sheet, "pulse_width", p->pulse_width);
    close_brace(sheet);
}

static void put_arm_f32(sheet_t *sheet, const tribo_arm_f32_params_t *p)
{
    open_brace(sheet, "arm");
    put_float(sheet, "phi_d", p->phi_d);
    put_float(sheet, "phi_g", p->phi_g);
    put_float(sheet, "gamma_d", p->gamma_d);
    put_float(sheet, "gamma_g", p->gamma_g);
    close_brace(sheet);
}

static void put_loop_f32(sheet_t *sheet, const sim_params_header_t *header)
{
    const tribo_force_loop_f32_params_t *p        = &header->loop->params_f32;
    const tribo_friction_f32_params_t   *friction = &p->compensator.friction;
    if (friction->table != NULL)
    {
        (void)fprintf(sheet->stream, "static const tribo_breakaway_point_f32_t %s_table[] = {\n", header->name);
        for (uint32_t i = 0; i < friction->table_length; i++)
        {
            const tribo_breakaway_point_f32_t *point = &friction->table[i];
            (void)fprintf(sheet->stream,
                          "    {.force_n = %.8ef, .positive_n = %.8ef, .negative_n = %.8ef},\n",
                          (double)point->force_n,
                          (double)point->positive_n,
                          (double)point->negative_n);
        }
        (void)fputs("};\n", sheet->stream);
    }
    (void)fprintf(sheet->stream, "static const tribo_force_loop_f32_params_t %s_params = {\n", header->name);
    sheet->depth = 1;
    put_unsigned(sheet, "usual_input_end", p->usual_input_end);
    put_unsigned(sheet, "input_end", p->input_end);
    put_float(sheet, "gain", p->gain);
    put_controller_f32(sheet, &p->controller);
    open_brace(sheet, "compensator");
    put_friction_f32(sheet, header, friction);
    put_arm_f32(sheet, &p->compensator.arm);
    close_brace(sheet);
    (void)fputs("};\n", sheet->stream);
}

// --- q31 -----------------------------------------------------------------------------------------------------------

static void put_law_q31(const sheet_t *sheet, const tribo_breakaway_q31_t *law)
{
    indent(sheet);
    (void)fprintf(sheet->stream, "{.offset = %" PRIu32 "u, .slope = %" PRIu32 "u},\n", law->offset, law->slope);
}

static void put_controller_q31(sheet_t *sheet, const tribo_controller_q31_params_t *p)
{
    open_brace(sheet, "controller");
    open_brace(sheet, "cascade");
    open_brace(sheet, "section");
    for (uint32_t i = 0; i < p->cascade.count; i++)
    {
        const tribo_biquad_q31_section_t *s = &p->cascade.section[i];
        open_brace(sheet, "");
        put_int(sheet, "b0", s->b0);
        put_int(sheet, "c1", s->c1);
        put_int(sheet, "minus_a1", s->minus_a1);
        put_int(sheet, "c2", s->c2);
        put_int(sheet, "d2", s->d2);
        put_int(sheet, "d2_low", s->d2_low);
        put_int(sheet, "shift_power", s->shift_power);
        put_unsigned(sheet, "shift", s->shift);
        put_unsigned(sheet, "scale", s->scale);
        close_brace(sheet);
    }
    close_brace(sheet);
    put_int(sheet, "pair_power", p->cascade.pair_power);
    put_unsigned(sheet, "count", p->cascade.count);
    put_unsigned(sheet, "input_scale", p->cascade.input_scale);
    close_brace(sheet);
    put_int(sheet, "anti_windup", p->anti_windup);
    put_int(sheet, "taken_max", p->taken_max);
    put_int(sheet, "u_min", p->u_min);
    put_int(sheet, "u_max", p->u_max);
    put_unsigned(sheet, "anti_windup_shift", p->anti_windup_shift);
    close_brace(sheet);
}

static void put_friction_q31(sheet_t *sheet, const sim_params_header_t *header, const tribo_friction_q31_params_t *p)
{
    open_brace(sheet, "friction");
    put_unsigned(sheet, "rise_max", p->rise_max);
    put_unsigned(sheet, "rate", p->rate);
    put_int(sheet, "y_at_0", p->y_at_0);
    indent(sheet);
    (void)fprintf(sheet->stream, ".k = {%" PRIu32 "u, %" PRIu32 "u, %" PRIu32 "u},\n", p->k[0], p->k[1], p->k[2]);
    open_brace(sheet, "law");
    put_law_q31(sheet, &p->law[0]);
    put_law_q31(sheet, &p->law[1]);
    close_brace(sheet);
    open_brace(sheet, "reset");
    put_law_q31(sheet, &p->reset[0]);
    put_law_q31(sheet, &p->reset[1]);
    close_brace(sheet);
    put_table(sheet, header, p->table != NULL);
    put_unsigned(sheet, "set_level", p->set_level);
    put_unsigned(sheet, "reset_level", p->reset_level);
    put_int(sheet, "gravity", p->gravity);
    indent(sheet);
    (void)fprintf(sheet->stream, ".law_whole = {%uu, %uu},\n", p->law_whole[0], p->law_whole[1]);
    put_unsigned(sheet, "rise_shift", p->rise_shift);
    put_unsigned(sheet, "k_shift", p->k_shift);
    indent(sheet);
    (void)fprintf(sheet->stream, ".plain = %s,\n", p->plain ? "true" : "false");
    put_unsigned(sheet, "table_length", p->table_length);
    put_unsigned(sheet, "pulse_width", p->pulse_width);
    close_brace(sheet);
}

static void put_arm_q31(sheet_t *sheet, const tribo_arm_q31_params_t *p)
{
    open_brace(sheet, "arm");
    put_int(sheet, "phi_d", p->phi_d);
    put_int(sheet, "phi_g", p->phi_g);
    put_int(sheet, "gamma_d", p->gamma_d);
    put_int(sheet, "gamma_g", p->gamma_g);
    put_int(sheet, "power", p->power);
    put_unsigned(sheet, "below", p->below);
    put_unsigned(sheet, "shift", p->shift);
    close_brace(sheet);
}

static void put_loop_q31(sheet_t *sheet, const sim_params_header_t *header)
{
    const tribo_force_loop_q31_params_t *p        = &header->loop->params_q31;
    const tribo_friction_q31_params_t   *friction = &p->compensator.friction;
    if (friction->table != NULL)
    {
        (void)fprintf(sheet->stream, "static const tribo_breakaway_point_q31_t %s_table[] = {\n", header->name);
        for (uint32_t i = 0; i < friction->table_length; i++)
        {
            const tribo_breakaway_point_q31_t *point = &friction->table[i];
            (void)fprintf(sheet->stream,
                          "    {.force = %" PRId32 ", .positive = %" PRId32 ", .negative = %" PRId32 "},\n",
                          point->force,
                          point->positive,
                          point->negative);
        }
        (void)fputs("};\n", sheet->stream);
    }
    (void)fprintf(sheet->stream, "static const tribo_force_loop_q31_params_t %s_params = {\n", header->name);
    sheet->depth = 1;
    put_unsigned(sheet, "usual_input_end", p->usual_input_end);
    put_unsigned(sheet, "input_end", p->input_end);
    put_int(sheet, "gain", p->gain);
    put_controller_q31(sheet, &p->controller);
    open_brace(sheet, "compensator");
    put_friction_q31(sheet, header, friction);
    put_arm_q31(sheet, &p->compensator.arm);
    close_brace(sheet);
    (void)fputs("};\n", sheet->stream);
}

// --- the header around them ----------------------------------------------------------------------------------------

static void put_upper(FILE *stream, const char *name)
{
    for (; *name != '\0'; name++)
    {
        (void)fputc(toupper((unsigned char)*name), stream);
    }
}

/// What a user wrote, on its one line and in ASCII.
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
        header->loop->q31 ? "Q31" : "f32");
    put_quoted(stream, header->scenario);
    for (int i = 0; i < header->set_count; i++)
    {
        (void)fputs("\n///     --set        ", stream);
        put_quoted(stream, header->sets[i]);
    }
    (void)fprintf(stream, "\n///     tick         %g s\n", (double)config->sample_time_s);
    if (header->loop->q31)
    {
        (void)fprintf(stream, "///     full scale   %g N is 2^31\n", header->loop->full_scale_n);
    }
    (void)fprintf(stream,
                  "///     u            %g to %g N\n"
                  "///     |r| and |y|  up to %g N\n"
                  "///     gain         %g, of a controller of %u sections\n"
                  "///\n"
                  "/// As the library's init function makes them. For one file of a program, which then needs no "
                  "set-up code.\n\n",
                  (double)config->controller.u_min_n,
                  (double)config->controller.u_max_n,
                  (double)config->input_max_n,
                  (double)config->gain,
                  (unsigned)config->controller.section_count);
}

/// With the arithmetic: of one name in both, neither is left out, and a compiler says that it is declared twice.
static void put_guard(FILE *stream, const sim_params_header_t *header, const char *directive)
{
    (void)fprintf(stream, "%s ", directive);
    put_upper(stream, header->name);
    (void)fprintf(stream, "_PARAMS_%s_H\n", header->loop->q31 ? "Q31" : "F32");
}

static void put_define(FILE *stream, const sim_params_header_t *header, const char *what, double value)
{
    (void)fputs("#define ", stream);
    put_upper(stream, header->name);
    (void)fprintf(stream, "_%s %.8ef\n", what, value);
}

static void put_version(FILE *stream, const char *arithmetic, int version)
{
    (void)fprintf(stream,
                  "#if TRIBO_FORCE_LOOP_%s_PARAMS_VERSION != %d\n"
                  "#error \"made for another version of tribo: run tribo-sim params again\"\n"
                  "#endif\n\n",
                  arithmetic,
                  version);
}

void sim_params_header_write(FILE *stream, const sim_params_header_t *header)
{
    const bool q31   = header->loop->q31;
    sheet_t    sheet = {.stream = stream};
    put_comment(stream, header);
    put_guard(stream, header, "#ifndef");
    put_guard(stream, header, "#define");
    (void)fprintf(stream, "\n#include \"tribo/force_loop_%s.h\"\n\n", q31 ? "q31" : "f32");
    if (q31)
    {
        put_version(stream, "Q31", TRIBO_FORCE_LOOP_Q31_PARAMS_VERSION);
    }
    else
    {
        put_version(stream, "F32", TRIBO_FORCE_LOOP_F32_PARAMS_VERSION);
    }
    (void)fputs("// clang-format off\n", stream);
    put_define(stream, header, "SAMPLE_TIME_S", (double)header->config->sample_time_s);
    if (q31)
    {
        put_define(stream, header, "FULL_SCALE_N", (double)(float)header->loop->full_scale_n);
    }
    (void)fputs("\n", stream);
    if (q31)
    {
        put_loop_q31(&sheet, header);
    }
    else
    {
        put_loop_f32(&sheet, header);
    }
    (void)fputs("// clang-format on\n\n#endif\n", stream);
}
