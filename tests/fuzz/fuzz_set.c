// --set: a line an assignment, one after the other, on a scenario that is good without them.

#include "fuzz.h"

#include "scenario/config.h"

#include <string.h>

unsigned fuzz_good;

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    common_error_t     error    = {""};
    char              *text     = fuzz_text(data, size);
    common_scenario_t *scenario = sim_scenario_create();
    ALWAYS(scenario != NULL);
    bool ok = common_scenario_load_text(scenario, "duration_s: 1\nreference: {kind: step}\n", "fuzz.yaml", &error);
    for (char *line = strtok(text, "\n"); ok && line != NULL; line = strtok(NULL, "\n"))
    {
        ok = common_scenario_set(scenario, line, &error);
    }
    ok = ok && sim_scenario_check(scenario, &error);
    fuzz_check_error(ok, &error);
    fuzz_good += ok ? 1u : 0u;
    common_scenario_destroy(scenario);
    free(text);
    return 0;
}
