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

static bool add_beside(cJSON *object, const sim_beside_t *beside)
{
    if (!beside->exists)
    {
        return true;
    }
    cJSON *q31        = cJSON_AddObjectToObject(object, "q31");
    cJSON *difference = cJSON_AddObjectToObject(object, "difference");
    return add(q31, "rms_error_N", beside->rms_error_n) && add(q31, "max_error_N", beside->max_error_n) &&
           add(q31, "rms_measured_error_N", beside->rms_measured_error_n) &&
           add(q31, "limited_ticks", (double)beside->limited_ticks) &&
           add(q31, "bad_inputs", (double)beside->bad_inputs) && add(difference, "max_u_N", beside->max_u_n) &&
           add(difference, "rms_u_N", beside->rms_u_n) && add(difference, "max_F_N", beside->max_force_n) &&
           add(difference, "rms_F_N", beside->rms_force_n);
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
        add_target(object, summary) && add_beside(object, &summary->beside))
    {
        text = cJSON_Print(object);
    }
    cJSON_Delete(object);
    return text;
}
