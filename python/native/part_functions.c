// What depends on the arithmetic in part.h; compiled once for each.

#include "part.h"

#include "tribo_arithmetic.h"

#ifdef TRIBO_ARITHMETIC_Q31
typedef int64_t sum_t;
#else
typedef float sum_t;
#endif

#define IN(part) TRIBO_EITHER(&(part)->loop.in_f32, &(part)->loop.in_q31)

static tribo_force_t force_of(const native_part_t *part, double x_n)
{
    return tribo_force_of_n(x_n, part->loop.full_scale_n);
}

static double n_of(const native_part_t *part, tribo_force_t x)
{
    return tribo_force_n(x, part->loop.full_scale_n);
}

/// n, L, v, Q1, Q2, Q.
static double *put_friction(const native_part_t *part, const TRIBO(friction, signals_t) * seen, double *out)
{
    *out++ = n_of(part, seen->TRIBO_N(n));
    *out++ = n_of(part, seen->TRIBO_N(L));
    *out++ = TRIBO_EITHER((double)seen->v_n_per_s, n_of(part, seen->rise) / part->loop.sample_time_s);
    *out++ = (seen->relays & TRIBO_RELAY_Q1) != 0u;
    *out++ = (seen->relays & TRIBO_RELAY_Q2) != 0u;
    *out++ = (seen->relays & TRIBO_RELAY_Q) != 0u;
    return out;
}

static void tick_loop(native_part_t *part, const double *in, double *out, bool all)
{
    tribo_force_loop_f32_signals_t      seen;
    const tribo_friction_f32_signals_t *friction = &seen.compensator.friction;
    *out++                                       = sim_loop_step(&part->loop, in[0], in[1], &seen);
    if (!all)
    {
        return;
    }
    *out++ = (double)seen.e_n;
    *out++ = (double)seen.controller.v_n;
    *out++ = (double)seen.friction_term_n;
    *out++ = seen.controller.limited;
    *out++ = (double)seen.compensator.force_n;
    *out++ = (double)friction->n_n;
    *out++ = (double)friction->L_n;
    *out++ = (double)friction->v_n_per_s;
    *out++ = (friction->relays & TRIBO_RELAY_Q1) != 0u;
    *out++ = (friction->relays & TRIBO_RELAY_Q2) != 0u;
    *out++ = (friction->relays & TRIBO_RELAY_Q) != 0u;
    *out++ = (double)friction->f_n;
}

static void tick_friction(native_part_t *part, const double *in, double *out, bool all)
{
    TRIBO_PART(sim_loop, t) *loop = IN(part);
    TRIBO(friction, signals_t) seen;
    *out++ = n_of(part,
                  TRIBO(friction, step)(&loop->params.compensator.friction,
                                        &loop->state.compensator.friction,
                                        force_of(part, in[0]),
                                        force_of(part, in[1]),
                                        &seen));
    if (all)
    {
        (void)put_friction(part, &seen, out);
    }
}

static void tick_compensator(native_part_t *part, const double *in, double *out, bool all)
{
    TRIBO_PART(sim_loop, t) *loop = IN(part);
    TRIBO(compensator, signals_t) seen;
    *out++ = n_of(
        part,
        TRIBO(compensator, step)(&loop->params.compensator, &loop->state.compensator, force_of(part, in[0]), &seen));
    if (all)
    {
        out    = put_friction(part, &seen.friction, out);
        *out++ = n_of(part, seen.TRIBO_N(force));
    }
}

static void tick_guard(native_part_t *part, const double *in, double *out, bool all)
{
    TRIBO_PART(sim_loop, t) *loop = IN(part);
    (void)all;
    *out = (double)TRIBO(guard, step)(&loop->guard_params,
                                      &loop->state.guard,
                                      force_of(part, in[0]),
                                      force_of(part, in[1]),
                                      force_of(part, in[2]),
                                      in[3] != 0.0) /
           (double)TRIBO_ALL;
}

// --- a feed-forward around another controller ----------------------------------------------------------------------

static double error(native_part_t *part, double r_n, double y_n)
{
    TRIBO_PART(sim_loop, t) *loop = IN(part);
    part->r_n                     = r_n;
    part->y_n                     = y_n;
    TRIBO(force_loop, functions_t) functions;
    loop->params.method->functions(&functions);
    part->e_n =
        n_of(part, functions.error(&loop->params, &loop->memory, force_of(part, r_n), force_of(part, y_n), TRIBO_ALL));
    return part->e_n;
}

static void command(native_part_t *part, double v_n, double *out)
{
    TRIBO_PART(sim_loop, t) *loop                   = IN(part);
    const TRIBO(force_loop, params_t) *const params = &loop->params;
    TRIBO(force_loop, functions_t) functions;
    params->method->functions(&functions);
    const tribo_force_t v    = force_of(part, v_n);
    const tribo_force_t term = functions.term(params, &loop->memory, v);

    const tribo_force_t low  = params->controller.TRIBO_N(u_min);
    const tribo_force_t high = params->controller.TRIBO_N(u_max);
    const sum_t         sum  = (sum_t)v + (sum_t)term;
    const tribo_force_t u    = sum > high ? high : sum < low ? low : (tribo_force_t)sum;

    TRIBO(force_loop, signals_t)
    signals = {.TRIBO_N(e)             = force_of(part, part->e_n),
               .TRIBO_N(friction_term) = term,
               .controller             = {.TRIBO_N(v) = v, .TRIBO_N(u) = u, .limited = u != sum}};
    functions.after(params, &loop->memory, v, u, &signals);
    (void)TRIBO(feedforward, learn)(params, &loop->memory);
    out[0] = n_of(part, u);
    out[1] = part->e_n;
    out[2] = n_of(part, term);
    out[3] = u != sum;
    out[4] = n_of(part, signals.compensator.TRIBO_N(force));
    out[5] = n_of(part, signals.compensator.friction.TRIBO_N(f));
}

static void tick_feedforward(native_part_t *part, const double *in, double *out, bool all)
{
    double        every[NATIVE_OUTPUTS_MAX];
    double *const into = all ? out : every;
    (void)error(part, in[0], in[1]);
    command(part, in[2], into);
    out[0] = into[0];
}

static void restore(native_part_t *part)
{
    TRIBO_PART(sim_loop, t) *loop = IN(part);
    TRIBO(guard, restore)(&loop->state.guard);
    TRIBO(feedforward, restore)(&loop->memory.state);
}

const native_functions_t TRIBO_PART(native, functions) = {.tick    = {[NATIVE_LOOP]        = tick_loop,
                                                                      [NATIVE_FRICTION]    = tick_friction,
                                                                      [NATIVE_COMPENSATOR] = tick_compensator,
                                                                      [NATIVE_GUARD]       = tick_guard,
                                                                      [NATIVE_FEEDFORWARD] = tick_feedforward},
                                                          .error   = error,
                                                          .command = command,
                                                          .restore = restore};
