#include "part.h"

#include "error.h"
#include "loop/loop_check.h"
#include "loop/loop_config.h"
#include "scenario.h"
#include "scope.h"

#include <stdlib.h>
#include <string.h>

#define FRICTION_SIGNALS "n_N", "L_N", "v_N_per_s", "Q1", "Q2", "Q"

static const native_shape_t shapes[NATIVE_KINDS] = {
    [NATIVE_LOOP] =
        {.name   = "loop",
         .inputs = {"r_N", "y_N"},
         .outputs =
             {"u_N", "e_N", "controller_N", "friction_term_N", "limited", "F_hat_N", FRICTION_SIGNALS, "f_hat_N"}},
    [NATIVE_FRICTION]    = {.name = "friction", .inputs = {"u_N", "F_N"}, .outputs = {"f_N", FRICTION_SIGNALS}},
    [NATIVE_COMPENSATOR] = {.name    = "compensator",
                            .inputs  = {"u_N"},
                            .outputs = {"f_hat_N", FRICTION_SIGNALS, "F_hat_N"}},
    [NATIVE_GUARD]       = {.name = "guard", .inputs = {"r_N", "y_N", "friction_N", "good"}, .outputs = {"fade"}},
    [NATIVE_FEEDFORWARD] = {.name    = "feedforward",
                            .inputs  = {"r_N", "y_N", "controller_N"},
                            .outputs = {"u_N", "e_N", "friction_term_N", "limited", "F_hat_N", "f_hat_N"}}};

static const native_functions_t *functions_of(const native_part_t *part)
{
    return part->q31 ? &native_q31_functions : &native_f32_functions;
}

static tribo_status_t start(native_part_t *part)
{
    memset(part->outputs, 0, sizeof part->outputs);
    const native_scope_t scope  = native_enter();
    const tribo_status_t status = sim_loop_init(&part->loop, part->q31, &part->config, part->loop.full_scale_n);
    native_leave(&scope);
    return status;
}

native_part_t *native_part_new(const char *kind, const native_scenario_t *scenario, bool q31, native_error_t *error)
{
    const common_loop_keys_t *keys = native_scenario_loop(scenario);
    native_part_t            *part = calloc(1, sizeof *part);
    common_error_t            said = {""};
    if (part == NULL)
    {
        native_error_say(error, "", "out of memory");
        return NULL;
    }
    while (part->kind < NATIVE_KINDS && strcmp(shapes[part->kind].name, kind) != 0)
    {
        part->kind++;
    }
    if (part->kind == NATIVE_KINDS || (part->kind == NATIVE_LOOP && !native_scenario_has_loop(scenario, &said)))
    {
        native_error_say(error, "controller.kind", said.text[0] != '\0' ? said.text : "no such part");
        free(part);
        return NULL;
    }
    part->shape = &shapes[part->kind];
    part->q31   = q31;
    while (part->shape->inputs[part->inputs] != NULL)
    {
        part->inputs++;
    }
    common_loop_config_fill(&part->config, keys);
    if (part->kind != NATIVE_LOOP)
    {
        part->config.parts.feeds_forward = part->kind == NATIVE_FEEDFORWARD;
        part->config.parts.guarded       = part->kind == NATIVE_GUARD;
    }
    part->loop.full_scale_n     = keys->limits.full_scale_n;
    const tribo_status_t status = start(part);
    if (!native_accepted(status, error))
    {
        free(part);
        return NULL;
    }
    return part;
}

void native_part_delete(native_part_t *part)
{
    free(part);
}

void native_part_reset(native_part_t *part)
{
    (void)start(part); // it succeeded before
}

const char *native_part_input(const native_part_t *part, unsigned index)
{
    return part->shape->inputs[index];
}

const char *native_part_output(const native_part_t *part, unsigned index)
{
    return part->shape->outputs[index];
}

double native_part_step(native_part_t *part, double a, double b, double c, double d)
{
    const double         in[NATIVE_INPUTS_MAX] = {a, b, c, d};
    const native_scope_t scope                 = native_enter();
    functions_of(part)->tick[part->kind](part, in, part->outputs, true);
    native_leave(&scope);
    return part->outputs[0];
}

double native_part_seen(native_part_t *part, unsigned index)
{
    return part->outputs[index];
}

void native_part_play(native_part_t *part, const double *const *inputs, size_t count, double *const *outputs, bool all)
{
    const native_tick_t tick                  = functions_of(part)->tick[part->kind];
    double              in[NATIVE_INPUTS_MAX] = {0.0};
    unsigned            wanted                = 1;
    while (all && part->shape->outputs[wanted] != NULL)
    {
        wanted++;
    }
    const native_scope_t scope = native_enter();
    for (size_t i = 0; i < count; i++)
    {
        for (unsigned k = 0; k < part->inputs; k++)
        {
            in[k] = inputs[k][i];
        }
        tick(part, in, part->outputs, all);
        for (unsigned k = 0; k < wanted; k++)
        {
            outputs[k][i] = part->outputs[k];
        }
    }
    native_leave(&scope);
}

double native_feedforward_error(native_part_t *part, double r_n, double y_n)
{
    const native_scope_t scope = native_enter();
    const double         e_n   = functions_of(part)->error(part, r_n, y_n);
    native_leave(&scope);
    return e_n;
}

double native_feedforward_command(native_part_t *part, double v_n)
{
    const native_scope_t scope = native_enter();
    functions_of(part)->command(part, v_n, part->outputs);
    native_leave(&scope);
    return part->outputs[0];
}

bool native_part_learned(const native_part_t *part, double force_n, double values[12])
{
    if (!part->config.parts.feeds_forward)
    {
        return false;
    }
    const sim_learned_t learned = sim_loop_learned(&part->loop, force_n);
    for (int d = 0; d < 2; d++)
    {
        *values++ = learned.breakaway_n[d];
        *values++ = learned.relative_variance[d];
        *values++ = learned.travel_n[d];
        *values++ = learned.at_bound[d];
        *values++ = learned.stays_at_bound[d];
    }
    *values++ = learned.harms;
    *values++ = learned.forgotten;
    return true;
}

const char *native_part_guard_cause(const native_part_t *part)
{
    return part->config.parts.guarded ? sim_loop_guard_text(&part->loop) : NULL;
}

void native_part_restore(native_part_t *part)
{
    functions_of(part)->restore(part);
}

unsigned native_part_limited_ticks(const native_part_t *part)
{
    return sim_loop_limited_ticks(&part->loop);
}

unsigned native_part_bad_inputs(const native_part_t *part)
{
    return sim_loop_bad_inputs(&part->loop);
}

double native_part_sample_time_s(const native_part_t *part)
{
    return part->loop.sample_time_s;
}
