#include "native.h"

#include "loop/tuned.h"

#include "error.h"
#include "loop/loop_keys.h"
#include "scope.h"
#include "tribo/feedforward_q31.h"
#include "tribo/force_loop_q31.h"

#include <stdio.h>

// clang-format off: one row a parameter
#define ROW(group, symbol_, member, key_, unit_, low_, high_, standard_, change, number, condition_, sentence) \
    {.symbol = #symbol_, .key = TRIBO_KEY_##group key_, .unit = (unit_), .condition = (condition_), .text = (sentence), \
     .low = (low_), .high = (high_), .standard = (standard_)},
static const native_parameter_t parameters[] = {TRIBO_PARAMETERS(ROW)};
#undef ROW
// clang-format on

unsigned native_parameter_count(void)
{
    return sizeof parameters / sizeof parameters[0];
}

native_parameter_t native_parameter(unsigned index)
{
    return parameters[index];
}

const char *native_status_symbol(int status)
{
#define ROW(group, symbol, ...) #symbol,
#define REFUSAL(symbol, ...)    #symbol,
    static const char *const symbols[] = {"OK", "NULL", TRIBO_PARAMETERS(ROW) TRIBO_REFUSALS(REFUSAL)};
#undef ROW
#undef REFUSAL
    return symbols[status];
}

const char *native_version(void)
{
    return TRIBO_VERSION_STRING;
}

void native_error_say(native_error_t *error, const char *key, const char *text)
{
    error->status = 0;
    (void)snprintf(error->key, sizeof error->key, "%s", key);
    (void)snprintf(error->text, sizeof error->text, "%s", text);
}

bool native_accepted(tribo_status_t status, native_error_t *error)
{
    if (status != TRIBO_OK)
    {
        native_error_say(error, common_loop_key_of(status), tribo_status_text(status));
        error->status = (int)status;
    }
    return status == TRIBO_OK;
}

unsigned native_quantise(const float    *sections,
                         unsigned        count,
                         float           full_scale_n,
                         float           u_min_n,
                         float           u_max_n,
                         long long       numbers[39],
                         float           peaks[4],
                         double         *conditioning,
                         native_error_t *error)
{
    tribo_biquad_f32_section_t          given[TRIBO_BIQUAD_SECTIONS_MAX] = {{.b0 = 0.0f}};
    const tribo_controller_f32_config_t config                           = {.sections      = given,
                                                                            .section_count = count,
                                                                            .u_min_n       = u_min_n,
                                                                            .u_max_n       = u_max_n};
    tribo_controller_f32_params_t       f32;
    tribo_controller_q31_params_t       q31;
    tribo_headroom_q31_t                headroom;
    double                              through = 1.0;
    for (unsigned i = 0; i < count && i < TRIBO_BIQUAD_SECTIONS_MAX; i++)
    {
        const float *s = &sections[5u * i];
        given[i]       = (tribo_biquad_f32_section_t){.b0 = s[0], .b1 = s[1], .b2 = s[2], .a1 = s[3], .a2 = s[4]};
        through *= (double)s[0];
    }
    const native_scope_t scope  = native_enter();
    tribo_status_t       status = tribo_controller_f32_init(&f32, &config);
    status = status == TRIBO_OK ? tribo_controller_q31_init(&q31, &config, full_scale_n, &headroom) : status;
    native_leave(&scope);
    if (!native_accepted(status, error))
    {
        return 0;
    }
    *conditioning = (double)f32.anti_windup * through;
    for (unsigned i = 0; i < q31.cascade.count; i++)
    {
        const tribo_biquad_q31_section_t *s = &q31.cascade.section[i];
        const long long made[]              = {s->b0, s->c1, s->minus_a1, s->c2, s->d2, s->d2_low, s->shift, s->scale};
        for (unsigned k = 0; k < sizeof made / sizeof made[0]; k++)
        {
            *numbers++ = made[k];
        }
        peaks[i] = headroom.output[i];
    }
    *numbers++ = q31.cascade.input_scale;
    *numbers++ = q31.cascade.output_scale;
    *numbers++ = q31.anti_windup;
    *numbers++ = q31.anti_windup_shift;
    *numbers++ = q31.taken_max;
    *numbers++ = q31.u_min;
    *numbers++ = q31.u_max;
    return q31.cascade.count;
}

float native_usual_force(float usual_force_n, float u_min_n, float u_max_n)
{
    const tribo_force_loop_f32_config_t config = {.usual_force_n = usual_force_n,
                                                  .controller    = {.u_min_n = u_min_n, .u_max_n = u_max_n}};
    return tribo_force_loop_f32_usual_force_n(&config);
}

bool native_tune(const float rig[12], float tuned[10], native_error_t *error)
{
    tribo_compensator_f32_config_t model = tribo_force_loop_f32_paper().compensator;
    tribo_compensator_f32_params_t made;
    common_tuned_t                 known;
    model.friction.positive      = (tribo_breakaway_f32_t){.offset_n = rig[0], .slope = rig[1]};
    model.friction.negative      = (tribo_breakaway_f32_t){.offset_n = rig[2], .slope = rig[3]};
    model.arm                    = (tribo_arm_f32_config_t){.inertia = rig[4], .damping = rig[5], .stiffness = rig[6]};
    model.friction.pulse_width_s = 3.0f * rig[11]; // of no matter here
    const native_scope_t scope   = native_enter();
    tribo_status_t       status  = tribo_compensator_f32_init(&made, &model, rig[11]);
    if (status == TRIBO_OK)
    {
        status = common_tune(&known,
                             &(common_rig_t){.arm                     = model.arm,
                                             .friction                = made.friction,
                                             .actuator_pole_rad_per_s = rig[7],
                                             .sensor_pole_rad_per_s   = rig[8],
                                             .usual_force_n           = rig[9],
                                             .noise_n                 = rig[10],
                                             .sample_time_s           = rig[11]});
    }
    native_leave(&scope);
    if (!native_accepted(status, error))
    {
        return false;
    }
    const tribo_feedforward_f32_config_t fed     = known.feedforward;
    const tribo_guard_f32_config_t       guard   = known.guard;
    const float                          found[] = {fed.actuator_pole_rad_per_s,
                                                    fed.sensor_pole_rad_per_s,
                                                    fed.reversal_n,
                                                    fed.presliding_n,
                                                    fed.jump_time_s,
                                                    fed.forgetting_per_n,
                                                    guard.turn_n,
                                                    guard.quick_time_s,
                                                    guard.stray_n,
                                                    guard.fade_time_s};
    for (unsigned i = 0; i < sizeof found / sizeof found[0]; i++)
    {
        tuned[i] = found[i];
    }
    return true;
}
