#include "scenario/summary.h"

#include <cjson/cJSON.h>

#include <stdbool.h>
#include <stddef.h>

static bool add(cJSON *object, const char *key, double value)
{
    return cJSON_AddNumberToObject(object, key, value) != NULL;
}

static bool add_target(cJSON *object, const sim_summary_t *summary)
{
    return summary->target == NULL ||
           (cJSON_AddStringToObject(object, "target", summary->target) != NULL &&
            cJSON_AddStringToObject(object, "arithmetic", summary->q31 ? "q31" : "f32") != NULL &&
            add(object, "different_ticks", (double)summary->lock_step.different_ticks) &&
            add(object, "lock_step_ticks_per_s", summary->lock_step.ticks_per_s));
}

char *sim_summary_to_json(const sim_summary_t *summary)
{
    cJSON *object = cJSON_CreateObject();
    char  *text   = NULL;
    if (object != NULL && add(object, "rms_error_N", summary->rms_error_n) &&
        add(object, "max_error_N", summary->max_error_n) &&
        add(object, "rms_measured_error_N", summary->rms_measured_error_n) &&
        add(object, "ticks", (double)summary->ticks) && add(object, "limited_ticks", (double)summary->limited_ticks) &&
        add(object, "bad_inputs", (double)summary->bad_inputs) && add(object, "simulated_s", summary->simulated_s) &&
        add(object, "wall_s", summary->wall_s) && add(object, "real_time_factor", summary->real_time_factor) &&
        add_target(object, summary))
    {
        text = cJSON_Print(object);
    }
    cJSON_Delete(object);
    return text;
}
