// A header of params: the first line of the input is a --set that its comment quotes, the rest the scenario.

#include "fuzz.h"

#include "loop/loop_config.h"
#include "scenario/config.h"
#include "scenario/params_header.h"

#include <stdio.h>
#include <string.h>

unsigned fuzz_good;

/// Whatever a user wrote stays in the comment, in ASCII, and no value is one that C cannot read.
static void check_header(const char *text)
{
    const char *guard = strstr(text, "\n#ifndef LOOP_PARAMS_");
    ALWAYS(guard != NULL && strstr(guard, "nan") == NULL && strstr(guard, "inff") == NULL);
    ALWAYS(strstr(guard, "-2147483648") == NULL); // no constant of int32_t
    for (const char *line = text; line < guard; line = strchr(line, '\n') + 1)
    {
        ALWAYS(strncmp(line, "///", 3) == 0 || *line == '\n');
    }
    for (const unsigned char *p = (const unsigned char *)text; *p != '\0'; p++)
    {
        ALWAYS(*p == '\n' || (*p >= 0x20u && *p < 0x7fu));
    }
}

static void write_header(const sim_config_t *config, const char *set, bool q31)
{
    common_loop_config_t loop_config;
    sim_loop_t           loop;
    char                *text = NULL;
    size_t               size = 0;
    common_loop_config_fill(&loop_config, &config->loop);
    if (sim_loop_init(&loop, q31, &loop_config, config->loop.limits.full_scale_n) != TRIBO_OK)
    {
        return;
    }
    FILE *stream = open_memstream(&text, &size);
    ALWAYS(stream != NULL);
    (q31 ? sim_params_header_q31_write
         : sim_params_header_f32_write)(stream,
                                        &(sim_params_header_t){.name        = "loop",
                                                               .scenario    = set,
                                                               .description = "",
                                                               .sets        = &set,
                                                               .set_count   = 1,
                                                               .config      = &loop_config.parts.config,
                                                               .loop        = &loop});
    ALWAYS(fclose(stream) == 0);
    check_header(text);
    free(text);
    fuzz_good++;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    common_error_t     error    = {""};
    char              *set      = fuzz_text(data, size);
    common_scenario_t *scenario = sim_scenario_create();
    ALWAYS(scenario != NULL);
    char *rest = strchr(set, '\n');
    if (rest != NULL)
    {
        *rest++ = '\0';
        if (common_scenario_load_text(scenario, rest, "fuzz.yaml", &error) && sim_scenario_check(scenario, &error))
        {
            write_header(sim_scenario_config(scenario), set, false);
            write_header(sim_scenario_config(scenario), set, true);
        }
    }
    common_scenario_destroy(scenario);
    free(set);
    return 0;
}
