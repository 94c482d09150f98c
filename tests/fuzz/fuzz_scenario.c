// A scenario file: what is read and checked without a complaint is within what the library takes.

#include "fuzz.h"

#include "loop/loop_config.h"
#include "scenario/config.h"
#include "scenario/loop.h"

static unsigned good;

unsigned fuzz_good_inputs(void)
{
    return good;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    sim_error_t     error    = {""};
    char           *text     = fuzz_text(data, size);
    sim_scenario_t *scenario = sim_scenario_create();
    ALWAYS(scenario != NULL);
    const bool ok = sim_scenario_load_text(scenario, text, "fuzz.yaml", &error) && sim_scenario_check(scenario, &error);
    fuzz_check_error(ok, &error);
    if (ok)
    {
        sim_loop_config_t config;
        sim_loop_t        loop;
        sim_loop_config_fill(&config, sim_scenario_loop(scenario));
        ALWAYS(sim_loop_init(&loop, false, &config, 2.0) == TRIBO_OK);
        good++;
    }
    sim_scenario_destroy(scenario);
    free(text);
    return 0;
}
