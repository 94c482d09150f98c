// The feed-forward without a force sensor, docs/sensorless.md:
//
//     u = limit(lin + f + lead - b)          f = share belief V L(rs) sigma
//
// Without a sensor there is no error for the controller: its output is taken out of u. V is 1 until a motion of the arm
// is known. Where it is known, r is the output of another position or velocity loop, and V is learned from its work. A
// slide is the motion from one reversal to the next. The arm is at rest at both ends, so no kinetic energy is left
// over, and u has done the work of friction and load alone:
//
//     W = integral of z dx = V l |X| + c X          z = u_1 - D          X: travel of a slide, with its sign
//
// Two slides, one in each direction, tell V and c apart.
//
// This text serves both arithmetics and is included after words_f32.h or words_q31.h, and after reference.h.

#define TRAVEL_MIN   16.0f               // shortest slide that counts, widths
#define WEIGHING     32.0f               // travel at which a slide has half of the largest gain, widths
#define GAIN_MOST    0.5f                // largest gain of two slides
#define TICKS_MAX    (UINT32_C(1) << 20) // a longer slide does not count
#define SLIDING_MOST 4.0f                // limit of V from two slides

typedef FEEDFORWARD(motion_t) motion_t;
typedef FEEDFORWARD(effort_t) effort_t;
typedef ESTIMATE(t) estimate_t;

/// Moves a play one width wide by `moves`. Returns the direction in which the motion leaves the play, 0 while it stays
/// inside.
static int32_t play_direction(number_t *slack, number_t moves)
{
    const number_t target = plus(*slack, moves);
    *slack                = is_credible(target, FASTEST) ? clamp_of(target, NUMBER(0.5)) : 0;
    return size_of(target) > NUMBER(0.5) ? sign_of(target) : 0;
}

void SENSORLESS(motion)(memory_t *memory, number_t intended, number_t measured)
{
    motion_t *const motion = &memory->motion;

    const int32_t first  = play_direction(&motion->slack[0], intended);
    const int32_t second = play_direction(&motion->slack[1], measured);
    const int32_t sign   = first != 0 || intended > 0 || intended < 0
                               ? first
                               : second; // while the intended motion rests, the measured one counts
    motion->sign         = (int8_t)(sign != 0 ? sign : motion->sign);
    motion->is_known     = 1;
    motion->measured     = measured;
}

/// V: learned, but 1 until a motion has been known.
static number_t sliding_weight(const memory_t *memory)
{
    return memory->motion.was_known != 0u ? memory->state.weights.sliding : NUMBER(1.0);
}

/// Learns V_0 and c_0 from this slide and the last one, which had the other direction. `work` is that of u, `prior`
/// that of the configured friction, both per width of travel.
static void learn_from_two_slides(const params_t *p, memory_t *memory, float travel, float work, float prior)
{
    const tribo_feedforward_learning_t *const learning = &p->learning;
    const effort_t *const                     x        = &memory->motion.effort;
    tribo_feedforward_learner_t *const        learner  = &memory->state.learner;

    const float now   = magnitude(travel);
    const float last  = magnitude(x->last_travel);
    const float delta = now < last ? now : last;
    const float gain  = GAIN_MOST * delta / (delta + WEIGHING);
    const float V     = limit_f32((work + x->last_work) / (prior + x->last_prior), 0.0f, SLIDING_MOST);
    const float net   = work - x->last_work - V * (prior - x->last_prior);
    const float c     = x->side < 0 ? -0.5f * net : 0.5f * net;
    tribo_learner_take(learning, learner, V, c, gain, delta * learning->reversal_n, now * learning->reversal_n);

    tribo_feedforward_f32_weights_t learned = {.sliding = tribo_learner_sliding(learning, learner), .trust = 1.0f};
    memory->state.weights                   = taken(learning, &learned);
    memory->state.weights.seal              = seal_of(&memory->state.weights);
}

/// Ends a slide: checks that it counts, and learns if the last one that counted had the other direction.
static void end_slide(const params_t *p, memory_t *memory)
{
    effort_t *const x = &memory->motion.effort;

    const float slid   = number_of_sum(x->travel);
    const float travel = x->side < 0 ? -slid : slid;
    if (x->ticks >= TICKS_MAX || !(travel >= TRAVEL_MIN))
    {
        return;
    }
    const float work  = newtons_of_sum(&p->learning, x->work) / travel;
    const float prior = newtons_of_sum(&p->learning, x->prior) / slid *
                        (1.0f + 2.0f / travel); // the play ends a slide a width late: friction works there and back
    if (!(prior > 0.0f) || exceeds(work, TRIBO_F32_FORCE_MAX_N))
    {
        return;
    }
    if (x->last_travel * slid < 0.0f)
    {
        learn_from_two_slides(p, memory, slid, work, prior);
    }
    x->last_travel = slid;
    x->last_work   = work;
    x->last_prior  = prior;
}

/// Sums travel and work of the slide, in a tick with a known motion. Motion and effort pass the same low pass, so that
/// kinetic energy stays in balance. A slide with a tick that is too fast to be credible does not count.
static void slide(const params_t *p, memory_t *memory, const prior_t *prior)
{
    effort_t *const x = &memory->motion.effort;

    const bool     beyond = !is_credible(memory->motion.measured, FASTEST);
    const number_t moved  = low_pass(x->moved, beyond ? 0 : memory->motion.measured, p->fast_part);
    const force_t  effort = low_pass(x->effort, minus(memory->state.actuator, prior->load), p->fast_part);
    x->moved              = is_credible(moved, FASTEST) ? moved : 0;
    x->effort             = is_credible(effort, CREDIBLE_N) ? bounded(effort) : 0;

    const number_t target = plus(x->slack, x->moved);
    x->slack              = clamp_of(target, NUMBER(0.5));
    const int8_t sign     = sign_of(minus(target, x->slack));
    if (sign != 0 && sign != x->side)
    {
        end_slide(p, memory);
        x->side   = sign;
        x->ticks  = 0;
        x->travel = 0;
        x->work   = 0;
        x->prior  = 0;
    }
    x->ticks = beyond ? TICKS_MAX : x->ticks;
    if (x->ticks < TICKS_MAX)
    {
        x->ticks++;
        x->travel = added(x->travel, x->moved);
        x->work   = added(x->work, times(x->effort, x->moved));
        x->prior  = added(x->prior, times(prior->L, x->moved));
    }
}

/// The direction that friction opposes: that of the motion if it is known in this tick, otherwise that of rs.
static int8_t direction(memory_t *memory, int8_t before)
{
    if (memory->motion.is_known == 0u)
    {
        return memory->state.sign;
    }
    memory->motion.is_known = 0;
    return memory->motion.sign != 0 ? sign_of(memory->motion.sign) : before;
}

/// Ramps sigma to the direction and sets f. `level` is the configured breakaway times share and belief. b absorbs the
/// change of f from `V_before` to V, so learning never moves u.
static void set_friction(const params_t *p, memory_t *memory, force_t level, number_t V_before)
{
    state_t *const x = &memory->state;

    const number_t V      = sliding_weight(memory);
    const number_t before = clamp_of(x->sigma, NUMBER(1.0));
    const number_t left   = clamp_of(minus(along(x->sign, NUMBER(1.0)), before), p->jump);
    x->sigma              = clamp_of(plus(before, left), NUMBER(1.0));
    x->level              = bounded(times(level, V));
    x->f                  = times(x->level, x->sigma);
    x->lead               = bounded(gained(times(x->level, left), p->lead_gain));
    x->b                  = plus(x->b, minus(x->f, times(bounded(times(level, V_before)), x->sigma)));
}

/// Publishes an error of 0: the controller is taken out of u, and after a change of params it continues with that
/// error.
static void publish_no_error(state_t *x, force_t friction)
{
    publish_tick(x, 0, 0, friction);
    x->tick.has_e = x->mode != TRIBO_FEEDFORWARD_RESTART;
    x->tick.has_y = false;
}

/// Starts at a good r. Returns the error for the controller: r - y right after a hand-over, because the term to
/// continue from was computed for the controller's output at that error; otherwise 0.
static force_t start(const params_t *p, memory_t *memory, force_t r, force_t y)
{
    state_t *const x = &memory->state;

    const bool    is_handed = x->rule == TRIBO_FEEDFORWARD_CONTINUE && is_credible(y, p->input_max);
    const force_t at        = inside(r);
    rest_at(p, x, at, at);
    memory->motion.effort = (effort_t){.side = 0};
    x->actuator           = at;
    return is_handed ? minus(r, y) : 0;
}

static force_t method_error(const loop_params_t *loop, void *inner, force_t r, force_t y, part_t fade)
{
    const params_t *const p      = params_of(loop);
    memory_t *const       memory = inner;
    state_t *const        x      = &memory->state;

    const bool good = is_credible(r, p->input_max);
    force_t    e    = 0;
    if (!is_running(x))
    {
        if (!good)
        {
            x->rule = TRIBO_FEEDFORWARD_KEEP;
            publish_no_error(x, 0);
            return 0;
        }
        e = start(p, memory, r, y);
    }
    const int8_t   before = x->sign;
    const follow_t now    = follow(p, x, good ? inside(r) : x->r[0]);
    const prior_t  prior  = prior_of(&loop->compensator.friction, x->reached);
    const force_t  ahead =
        lead_of(p, x, &now, memory->motion.is_known != 0u ? 0 : x->rate); // the rate of another loop's output is noise
    if (memory->motion.was_known != 0u && x->weights.seal != seal_of(&x->weights))
    {
        start_anew(p, x);
        publish_no_error(x, 0);
        return 0;
    }
    const number_t V         = sliding_weight(memory);
    memory->motion.was_known = memory->motion.was_known != 0u || memory->motion.is_known != 0u;
    if (memory->motion.is_known != 0u)
    {
        slide(p, memory, &prior);
    }
    x->sign = direction(memory, before);
    set_friction(p, memory, part_of(part_of(prior.L, fade), p->trust), V);
    x->lin = plus(plus(x->reached, ahead), prior.load);
    if (!is_credible(plus(plus(x->lin, x->f), plus(x->b, x->behind[0])), CREDIBLE_N))
    {
        start_anew(p, x);
        publish_no_error(x, 0);
        return 0;
    }
    publish_no_error(x, x->f);
    return e;
}

// v is 0, or what the controller still puts out. It is taken out of the sum, which is limited here: so the controller
// never sees a limit and cannot wind up.
static force_t method_term(const loop_params_t *loop, void *inner, force_t v_out)
{
    const params_t *const p = params_of(loop);
    state_t *const        x = &((memory_t *)inner)->state;
    if (!is_running(x))
    {
        return x->mode == TRIBO_FEEDFORWARD_ENTER ? x->tick.OF(term) : 0;
    }
    const force_t low         = inside(loop->controller.OF(u_min));
    const force_t high        = inside(loop->controller.OF(u_max));
    const force_t v           = inside(v_out);
    const force_t model_force = plus(x->lin, x->f);
    const force_t fading      = low_pass(x->b, 0, p->slow_part);
    x->b = clamp_of(x->rule == TRIBO_FEEDFORWARD_TAKE_OVER ? minus(model_force, plus(v, inside(x->tick.OF(term))))
                                                           : fading,
                    p->offset_max);
    x->rule = TRIBO_FEEDFORWARD_KEEP;

    const force_t sum = plus(minus(model_force, x->b), x->lead);
    const force_t u   = clamp(sum, low, high);
    x->limited        = sign_of(minus(sum, u));
    x->tick.OF(term)  = outside(minus(clamp(minus(model_force, x->b), low, high), v));
    return outside(minus(u, v));
}

static void method_after(const loop_params_t *loop, void *inner, force_t v, force_t u_out, LOOP(signals_t) * seen)
{
    state_t *const x = &((memory_t *)inner)->state;
    (void)v;
    if (!is_running(x))
    {
        return;
    }
    const force_t actuator   = low_pass(x->actuator, inside(u_out), params_of(loop)->actuator_part);
    x->actuator              = is_credible(actuator, CREDIBLE_N) ? actuator : inside(u_out);
    seen->controller.limited = x->limited != 0;
    show(seen, inside(u_out), plus(x->reached, x->behind[0]), x->level, x->f);
}

static void method_enter(void *memory, force_t term, bool anew)
{
    state_t *const x = &((memory_t *)memory)->state;
    enter_at(x, term, anew);
    if (anew)
    {
        ((memory_t *)memory)->motion = (motion_t){.sign = 0}; // forget the motion of an earlier run
    }
    if (!is_running(x))
    {
        x->rule = TRIBO_FEEDFORWARD_CONTINUE;
    }
    publish_no_error(x, 0);
}

// Assigned one by one, because an initialiser would compile to a table of absolute addresses.
void SENSORLESS(method)(LOOP(functions_t) * functions)
{
    functions->error = method_error;
    functions->term  = method_term;
    functions->after = method_after;
    functions->enter = method_enter;
    functions->start = method_start;
}

static tribo_status_t part_make(const tribo_loop_part_t             *part,
                                const tribo_force_loop_f32_config_t *loop,
                                float                                full_scale_n,
                                loop_params_t                       *made)
{
    params_t *const                            params     = (params_t *)part->params;
    const tribo_sensorless_f32_config_t *const sensorless = (const tribo_sensorless_f32_config_t *)part->sensorless;
    if (sensorless == NULL)
    {
        return TRIBO_ERR_NULL;
    }
    tribo_status_t status = PARAMETERS_CHECK(tribo_sensorless_parameters, sensorless);
    status                = status == TRIBO_OK ? FEEDFORWARD(make)(part, loop, full_scale_n, made) : status;
    if (status == TRIBO_OK)
    {
        params->trust            = part_exactly(sensorless->belief);
        params->method.functions = SENSORLESS(method);
    }
    return status;
}

tribo_loop_part_t SENSORLESS(use)(params_t                             *params,
                                  const tribo_feedforward_f32_config_t *config,
                                  const tribo_sensorless_f32_config_t  *sensorless)
{
    tribo_loop_part_t part = {.config = config, .sensorless = sensorless, .params = params};
    part.TYPED(make)       = part_make;
    return part;
}

// --- the force from u alone ------------------------------------------------------------------------------------------

// Each iteration multiplies the error by the slope of L(F), 0.3 on the paper's rig.
#define ITERATIONS       4u
#define FIRST_ITERATIONS 16u

/// F of an arm that sticks: F stays at `before` unless u exceeds breakaway, times `up` in the positive direction and
/// `down` in the negative one. Breakaway depends on F, hence a fixed-point iteration.
static force_t sticking_force(const friction_params_t *friction,
                              force_t                  before,
                              force_t                  u,
                              number_t                 up,
                              number_t                 down,
                              uint32_t                 iterations)
{
    const force_t g = inside(friction->OF(gravity));
    force_t       F = before;
    for (uint32_t i = 0; i < iterations; i++)
    {
        const prior_t prior = prior_of(friction, F);
        const force_t half  = plus(prior.load, g); // half the difference of L+ and L-
        const force_t at    = plus(u, g);
        F = clamp(before, minus(at, times(plus(prior.L, half), up)), plus(at, times(minus(prior.L, half), down)));
    }
    return F;
}

void ESTIMATE(step)(const loop_params_t *params,
                    const params_t      *feedforward,
                    estimate_t          *estimate,
                    part_t               tolerance,
                    force_t              OF(u))
{
    const friction_params_t *const friction = &params->compensator.friction;

    const force_t most       = inside(feedforward->input_max);
    const force_t at         = inside(OF(u));
    uint32_t      iterations = ITERATIONS;
    if (!is_part(tolerance) || !is_credible(at, most))
    {
        return;
    }
    const force_t sum = plus(plus(estimate->force, estimate->low), estimate->high);
    if (estimate->runs == 0u || !is_credible(estimate->lagged, most) || !is_credible(sum, CREDIBLE_N))
    {
        *estimate  = (estimate_t){.runs = 1, .lagged = at, .force = at, .low = -most, .high = most};
        iterations = FIRST_ITERATIONS;
    }
    const number_t lower = minus(NUMBER(1.0), part_of(NUMBER(1.0), tolerance));
    const number_t upper = plus(NUMBER(1.0), part_of(NUMBER(1.0), tolerance));
    estimate->lagged     = low_pass(estimate->lagged, at, feedforward->lag_part);
    estimate->force = sticking_force(friction, estimate->force, estimate->lagged, NUMBER(1.0), NUMBER(1.0), iterations);
    estimate->low   = sticking_force(friction, estimate->low, estimate->lagged, upper, lower, iterations);
    estimate->high  = sticking_force(friction, estimate->high, estimate->lagged, lower, upper, iterations);
}
