#include "scenario/parameter_list.h"

#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"
#include "tribo/parameters.h"

#include <math.h>
#include <stdio.h>

static void print_heading(const char *title)
{
    (void)printf("\n### %s\n\n| field | key | unit | range | default | what |\n|---|---|---|---|---|---|\n", title);
}

static void print_row(const char *field,
                      const char *key,
                      const char *unit,
                      double      low,
                      double      high,
                      double      standard,
                      const char *text)
{
    char word[32] = "-";
    if (!isnan(standard))
    {
        (void)snprintf(word, sizeof word, "%g", standard);
    }
    (void)printf("| `%s` | %s | %s | %g to %g | %s | ", field, key, unit, low, high, word);
    for (; *text != '\0'; text++)
    {
        (void)printf("%s%c", *text == '|' ? "\\" : "", *text); // a '|' would end the cell
    }
    (void)fputs(" |\n", stdout);
}

// The field as text. A config without this field does not compile.
#define FIELD(config, path) (sizeof(((config *)0)->path) != 0 ? #path : "")

// Where the members of a group are.
#define AT_SAMPLE(member)      FIELD(tribo_force_loop_f32_config_t, member)
#define AT_INPUT(member)       FIELD(tribo_force_loop_f32_config_t, member)
#define AT_GAIN(member)        FIELD(tribo_force_loop_f32_config_t, member)
#define AT_LIMIT(member)       FIELD(tribo_force_loop_f32_config_t, controller.member)
#define AT_CASCADE(member)     FIELD(tribo_force_loop_f32_config_t, controller.member)
#define AT_BREAKAWAY(member)   FIELD(tribo_force_loop_f32_config_t, compensator.friction.member)
#define AT_TABLE(member)       FIELD(tribo_force_loop_f32_config_t, compensator.friction.member)
#define AT_FRICTION(member)    FIELD(tribo_force_loop_f32_config_t, compensator.friction.member)
#define AT_ARM(member)         FIELD(tribo_force_loop_f32_config_t, compensator.arm.member)
#define AT_SENSORLESS(member)  FIELD(tribo_sensorless_f32_config_t, member)
#define AT_FEEDFORWARD(member) FIELD(tribo_feedforward_f32_config_t, member)
#define AT_GUARD(member)       FIELD(tribo_guard_f32_config_t, member)
#define AT_SCALE(member)       #member // an argument, not a field

#define ROW(group, symbol, member, key, unit, low, high, standard, change, number, condition, text)                    \
    print_row(AT_##group(member), "`" TRIBO_KEY_##group key "`", unit, low, high, standard, text);
// The length of a list has no key, because a scenario's list has its own length.
#define LENGTH(group, symbol, member, key, unit, low, high, standard, change, number, condition, text)                 \
    print_row(AT_##group(member), "-", unit, low, high, standard, text);
#define POINT(symbol, member, key, unit, low, high, text)                                                              \
    print_row(AT_TABLE(table[0].member), "`" TRIBO_KEY_TABLE "table[]." key "`", unit, low, high, (double)NAN, text);
#define SECTION(symbol, member, key, unit, low, high, text)                                                            \
    print_row(AT_CASCADE(sections[0].member),                                                                          \
              "`" TRIBO_KEY_CASCADE "sections[]." key "`",                                                             \
              unit,                                                                                                    \
              low,                                                                                                     \
              high,                                                                                                    \
              (double)NAN,                                                                                             \
              text);

void sim_parameter_list_print(void)
{
    print_heading("Force loop: `tribo_force_loop_f32_config_t`");
    TRIBO_BREAKAWAY_PARAMETERS(ROW)
    TRIBO_TABLE_PARAMETERS(LENGTH)
    TRIBO_POINT_ELEMENTS(POINT)
    TRIBO_GAIN_PARAMETERS(ROW)
    TRIBO_ARM_PARAMETERS(ROW)
    TRIBO_FRICTION_PARAMETERS(ROW)
    TRIBO_CASCADE_PARAMETERS(LENGTH)
    TRIBO_SECTION_ELEMENTS(SECTION)
    TRIBO_LIMIT_PARAMETERS(ROW)
    TRIBO_INPUT_PARAMETERS(ROW)
    TRIBO_SAMPLE_PARAMETERS(ROW)
    print_heading("Argument of a set-up in Q31");
    TRIBO_SCALE_PARAMETERS(ROW)
    print_heading("Feed-forward: `tribo_feedforward_f32_config_t`");
    TRIBO_FEEDFORWARD_PARAMETERS(ROW)
    print_heading("Without a sensor: `tribo_sensorless_f32_config_t`");
    TRIBO_SENSORLESS_PARAMETERS(ROW)
    print_heading("Guard: `tribo_guard_f32_config_t`");
    TRIBO_GUARD_PARAMETERS(ROW)
}
