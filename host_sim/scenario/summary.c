#include "scenario/summary.h"

#include <cjson/cJSON.h>

#include <math.h>
#include <stddef.h>
#include <stdio.h>

#define UNKNOWN 0.5 // relative variance above which a direction is not learned

typedef struct
{
    const char *key;
    double      value;
} number_t;

static bool add(cJSON *object, const number_t *numbers, size_t count)
{
    bool ok = object != NULL;
    for (size_t i = 0; ok && i < count; i++)
    {
        ok = cJSON_AddNumberToObject(object, numbers[i].key, numbers[i].value) != NULL;
    }
    return ok;
}

#define ADD(object, ...)                                                                                               \
    add(object, (const number_t[]){__VA_ARGS__}, sizeof((const number_t[]){__VA_ARGS__}) / sizeof(number_t))

static bool add_measures(cJSON *object, const sim_result_t *result)
{
    const sim_activity_t *activity = &result->activity;
    return ADD(object,
               {"rms_error_N", result->rms_error_n},
               {"max_error_N", result->max_error_n},
               {"rms_measured_error_N", result->rms_measured_error_n},
               {"u_variation_N", activity->u_variation_n},
               {"variation_ratio", sim_activity_variation_ratio(activity)}, // NaN becomes null
               {"chatter_ticks", (double)activity->chatter_ticks},
               {"Q_switches", (double)activity->q_switches});
}

bool sim_summary_not_learned(const sim_result_t *result, uint64_t ticks, char text[SIM_NOT_LEARNED_SIZE])
{
    const sim_idle_t *idle = &result->idle;
    const double      all  = 0.01 * (double)ticks; // for percents
    if (!result->learns || fmax(result->learned.relative_variance[0], result->learned.relative_variance[1]) <= UNKNOWN)
    {
        return false;
    }
    (void)snprintf(
        text,
        SIM_NOT_LEARNED_SIZE,
        "F travelled %.3g N; r stood in %.0f %% of the ticks, u was at a limit in %.0f %%, r or y was bad in %.0f %%",
        idle->travel_n,
        (double)idle->standing / all,
        (double)idle->limited / all,
        (double)idle->bad_inputs / all);
    return true;
}

static bool add_learned(cJSON *object, const sim_result_t *result, uint64_t ticks)
{
    static const char *const names[] = {"positive", "negative"};

    const sim_learned_t *learned    = &result->learned;
    cJSON               *directions = result->learns ? cJSON_AddObjectToObject(object, "learned") : NULL;
    bool                 ok         = !result->learns || directions != NULL;
    for (int d = 0; ok && result->learns && d < 2; d++)
    {
        cJSON *one = cJSON_AddObjectToObject(directions, names[d]);
        ok         = ADD(one,
                         {"breakaway_N", learned->breakaway_n[d]},
                         {"relative_variance", learned->relative_variance[d]},
                         {"travel_N", learned->travel_n[d]}) &&
             cJSON_AddBoolToObject(one, "at_bound", learned->at_bound[d]) != NULL &&
             cJSON_AddBoolToObject(one, "stays_at_bound", learned->stays_at_bound[d]) != NULL;
    }
    char       text[SIM_NOT_LEARNED_SIZE];
    const bool none = sim_summary_not_learned(result, ticks, text);
    return ok &&
           (!result->learns ||
            (cJSON_AddBoolToObject(directions, "harms", learned->harms) != NULL &&
             ADD(directions, {"forgotten", (double)learned->forgotten}, {"usual_force_N", result->usual_force_n}) &&
             cJSON_AddItemToObject(directions, "not_learned", none ? cJSON_CreateString(text) : cJSON_CreateNull())));
}

static bool add_counters(cJSON *object, const sim_result_t *result, uint64_t ticks)
{
    return ADD(object, {"limited_ticks", (double)result->limited_ticks}, {"bad_inputs", (double)result->bad_inputs}) &&
           (result->guard == NULL || cJSON_AddStringToObject(object, "guard", result->guard) != NULL) &&
           add_learned(object, result, ticks);
}

static bool add_target(cJSON *object, const sim_summary_t *summary)
{
    return cJSON_AddStringToObject(object, "target", summary->target) != NULL &&
           cJSON_AddStringToObject(object, "arithmetic", summary->q31 ? "q31" : "f32") != NULL &&
           ADD(object,
               {"different_ticks", (double)summary->lock_step.different_ticks},
               {"lock_step_ticks_per_s", summary->lock_step.ticks_per_s});
}

static bool add_q31(cJSON *object, const sim_summary_t *summary)
{
    cJSON *q31 = cJSON_AddObjectToObject(object, "q31");
    return add_measures(q31, &summary->result_q31) && add_counters(q31, &summary->result_q31, summary->ticks) &&
           ADD(cJSON_AddObjectToObject(object, "difference"),
               {"max_u_N", summary->difference.max_u_n},
               {"rms_u_N", summary->difference.rms_u_n},
               {"max_F_N", summary->difference.max_force_n},
               {"rms_F_N", summary->difference.rms_force_n});
}

char *sim_summary_to_json(const sim_summary_t *summary)
{
    cJSON     *object = cJSON_CreateObject();
    const bool ok     = add_measures(object, &summary->result) && ADD(object, {"ticks", (double)summary->ticks}) &&
                    add_counters(object, &summary->result, summary->ticks) &&
                    ADD(object,
                        {"simulated_s", summary->simulated_s},
                        {"wall_s", summary->wall_s},
                        {"real_time_factor", summary->real_time_factor}) &&
                    (summary->target == NULL || add_target(object, summary)) &&
                    (!summary->both || add_q31(object, summary));
    char *text = ok ? cJSON_Print(object) : NULL;
    cJSON_Delete(object);
    return text;
}
