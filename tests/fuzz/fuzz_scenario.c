// A scenario file: what is read and checked without a complaint is within what the library takes.

#include "fuzz.h"

#include "loop/loop_config.h"
#include "scenario/config.h"
#include "scenario/loop.h"

unsigned fuzz_good;

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    common_error_t     error    = {""};
    char              *text     = fuzz_text(data, size);
    common_scenario_t *scenario = sim_scenario_create();
    ALWAYS(scenario != NULL);
    const bool ok =
        common_scenario_load_text(scenario, text, "fuzz.yaml", &error) && sim_scenario_check(scenario, &error);
    fuzz_check_error(ok, &error);
    if (ok)
    {
        common_loop_config_t config;
        sim_loop_t           loop;
        common_loop_config_fill(&config, common_scenario_loop(scenario));
        ALWAYS(sim_loop_init(&loop, false, &config, 2.0) == TRIBO_OK);
        fuzz_good++;
    }
    common_scenario_destroy(scenario);
    free(text);
    return 0;
}
