// One tick of the feed-forward, steps 1 to 8 of docs/feedforward.md: one text for both arithmetics, after words_f32.h or words_q31.h and
// reference.h.

#define SAMPLE_TICKS 10u

/// The learned load at a force.
static force_t learned_load(const weights_t *w, force_t force)
{
    return bounded(plus(w->constant, times(force, w->scale)));
}

/// G.
static force_t level_of(const state_t *x)
{
    return part_of(x->level, x->weights.trust);
}

/// f(sigma).
static force_t friction_at(const state_t *x, number_t sigma)
{
    number_t sum = times(x->weights.use[0], sigma);
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        sum = plus(sum, times(x->weights.use[1u + j], x->stop[j]));
    }
    return bounded(times(level_of(x), clamp_of(sum, NUMBER(3.99))));
}

/// At rest at y; beside a running controller at r. What is learned stays.
static void start(const params_t *p, state_t *x, force_t r, force_t y)
{
    const bool    enters = x->mode == TRIBO_FEEDFORWARD_ENTER;
    const force_t at     = enters ? r : y;

    rest_at(p, x, r, at);
    x->b           = enters ? 0 : learned_load(&x->weights, at);
    x->offset_seal = ~bits_of(x->b);
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        x->stop[j] = 0;
    }
    x->y[0] = x->y[1] = y;
    x->y_noise        = 0;
    x->actuator = x->sensor = x->force = x->travelled = y;
    x->difference = x->friction = 0;
    x->error                    = 0;
    x->still = x->since = 0;
    x->side             = 0;
    x->quick            = 0;
    x->rests            = false;
    x->phase            = SAMPLE_TICKS - 1u; // the learner starts with this tick
    x->starts           = 1;
    x->flipped          = 0; // turns and chatter before are learned all the same
}

/// Step 3: the stops, and how long r stands: a width that shrinks is no motion. In a hold a step of r leaves it standing: seed the mean error with it, or u would stay
/// frozen and b would absorb the step.
static void move_stops(const params_t *p, state_t *x, const follow_t *now)
{
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        x->stop[j] = clamp_of(plus(x->stop[j], gained(now->turned, p->stop_gain[j])), NUMBER(1.0));
    }
    if (now->turned == 0 || now->moved == 0)
    {
        x->still += x->still < p->still_ticks ? 1u : 0u;
        return;
    }
    const bool stays = x->mode == TRIBO_FEEDFORWARD_HOLD && now->step;
    x->rests         = false;
    x->error         = stays ? now->moved : x->error;
    x->still         = stays ? x->still : 0u;
}

/// What a reversal makes of V_0 and load.
static void turn_weights(weights_t *w)
{
    if (w->seal == seal_of(w)) // a corrupt one is forgotten with the next sample
    {
        w->use[0]   = plus(w->use[0], minus(w->turned, w->sliding));
        w->sliding  = w->turned;
        w->constant = part_of(w->constant, w->kept);
        w->scale    = part_of(w->scale, w->kept);
        w->kept     = PART(0.99999994);
        w->seal     = seal_of(w);
    }
}

/// A reversal while r moves. Until the arm has slid both ways all that friction lacks is taken for friction, as too little would overshoot:
/// the learner has said beforehand what that makes of the weights. It turns its own with the next sample, and what is on its way is turned
/// where it arrives.
static void turn(state_t *x)
{
    turn_weights(&x->weights);
    x->turned_since = true;
    count_few(&x->turns);
}

/// Step 5: f while r moves. The controller alone takes a first motion.
static void move(const params_t *p, state_t *x, bool first)
{
    const number_t left = minus(along(x->sign, NUMBER(1.0)), x->sigma);
    const number_t by   = first ? left : clamp_of(left, p->jump);
    const force_t  jump = bounded(times(level_of(x), times(x->weights.use[0], by)));
    x->sigma            = clamp_of(plus(x->sigma, by), NUMBER(1.0));
    x->f                = friction_at(x, x->sigma);
    x->mode             = x->sign != 0 ? TRIBO_FEEDFORWARD_MOVING : TRIBO_FEEDFORWARD_START;
    if (first)
    {
        x->b = plus(x->b, jump);
        return;
    }
    x->lead = bounded(gained(jump, p->lead_gain));
    if (x->flips && x->rule == TRIBO_FEEDFORWARD_KEEP)
    {
        x->rule = TRIBO_FEEDFORWARD_REVERSAL;
    }
}

/// Friction that chatters about a play is less than learned.
static void watch(const params_t *p, state_t *x, int8_t side)
{
    if (side == x->side)
    {
        x->since += x->since < p->quick_ticks ? 1u : 0u;
        return;
    }
    const uint32_t run = x->since < p->quick_ticks ? x->quick + 1u : 0u;
    x->quick           = (uint8_t)(run < 4u ? run : 4u);
    x->since           = 0;
    x->side            = side;
    if (x->quick == 4u)
    {
        count_few(&x->chatter);
    }
}

/// Step 6: friction is fed back, up to what is learned.
static void hold(const params_t *p, state_t *x)
{
    const force_t B      = bounded(times(x->level, x->weights.sliding));
    const force_t net    = minus(minus(x->u, x->travelled), x->load);
    const force_t before = x->f;
    x->f                 = part_of(clamp_of(net, B), PART(0.94));
    if (x->mode != TRIBO_FEEDFORWARD_HOLD)
    {
        x->b     = plus(x->b, minus(x->f, before));
        x->mode  = TRIBO_FEEDFORWARD_HOLD;
        x->rests = false;
        x->side  = x->sign;
        x->since = 0;
        x->quick = 0;
        x->sigma = 0;
    }
    watch(p, x, size_of(net) > B ? sign_of(net) : x->side);

    // The controller shall not follow its own sensor's noise.
    const force_t noise = coarser(part_of(x->y_noise, PART(0.04)));
    const bool    still = p->still_ticks > 0u && x->still >= p->still_ticks; // else the monitor's alone
    if (x->y_good)
    {
        const force_t most = x->rests ? noise * 7 / 2 : noise;
        x->e               = minus(x->e, clamp_of(x->error, noise));
        x->rests           = still && size_of(x->error) < most;
    }
    if (x->rests) // u stays
    {
        x->e    = 0;
        x->rule = TRIBO_FEEDFORWARD_CONTINUE;
    }
}

/// The first tick after a hold: sigma is where u stands between both breakaways, and u goes on.
static void leave(state_t *x)
{
    const force_t rise = bounded(times(level_of(x), x->weights.use[0]));
    x->sigma           = along(x->sign, NUMBER(1.0));
    if (x->side != x->sign && rise > 0)
    {
        x->sigma = over(minus(minus(x->u, x->lin), friction_at(x, 0)), rise);
    }
    x->f    = friction_at(x, x->sigma);
    x->mode = TRIBO_FEEDFORWARD_MOVING;
    x->rule = TRIBO_FEEDFORWARD_CONTINUE;
}

/// A sum or a low pass that is no force.
static bool is_corrupt(const state_t *x)
{
    const force_t passes = plus(plus(plus(x->friction, x->error), plus(x->v, x->force)), plus(x->y_noise, x->r_noise));
    const force_t sum    = plus(plus(x->lin, x->f), plus(x->b, x->travelled));
    return !is_credible(x->e, CREDIBLE_N) || !is_credible(sum, CREDIBLE_N) || !is_credible(passes, CREDIBLE_N);
}

/// Whether it runs in this tick: good inputs start it. With a flipped bit of b, u goes on.
static bool runs_with(const params_t *p, state_t *x, force_t r, force_t y, bool good)
{
    if (!is_running(x))
    {
        if (good)
        {
            start(p, x, inside(r), inside(y));
        }
        return good;
    }
    if (x->offset_seal != ~bits_of(x->b))
    {
        x->rule = TRIBO_FEEDFORWARD_TAKE_OVER;
        count(&x->forgotten);
    }
    return true;
}

/// Steps 5 and 6, by the mode.
static void set_friction(const params_t *p, state_t *x, bool stands, bool first)
{
    if (stands && x->mode != TRIBO_FEEDFORWARD_START)
    {
        hold(p, x);
    }
    else if (x->mode == TRIBO_FEEDFORWARD_HOLD)
    {
        leave(x);
    }
    else
    {
        move(p, x, first);
    }
}

// Steps 1 to 6.
static force_t method_error(const loop_params_t *loop, void *memory, force_t r, force_t y, part_t fade)
{
    const params_t *const p = params_of(loop);
    state_t *const        x = &((memory_t *)memory)->state;

    const bool good_r = is_credible(r, p->input_max);
    x->y_good         = is_credible(y, p->input_max);
    const bool good   = good_r && x->y_good;
    if (!runs_with(p, x, r, y, good))
    {
        tell(x, 0, 0, 0);
        return 0;
    }
    x->y_now              = x->y_good ? inside(y) : x->y[0];
    const int8_t   before = x->sign;
    const force_t  e      = plus(minus(x->reached, x->y_now), x->behind[1]);
    const follow_t now    = follow(p, x, good_r ? inside(r) : x->r[0]);
    move_stops(p, x, &now);
    const bool stands = (p->still_ticks > 0u && x->still >= p->still_ticks) || x->weights.fed_back != 0u;
    if (x->flips && !stands)
    {
        turn(x);
    }
    const prior_t prior = prior_of(&loop->compensator.friction, x->reached);
    const force_t ahead = lead_of(p, x, &now, x->rate);
    x->own_load         = learned_load(&x->weights, x->reached);
    x->load             = bounded(plus(prior.load, x->own_load));
    x->lin              = plus(plus(x->reached, ahead), x->load);
    x->level            = part_of(prior.L, fade);
    x->lead             = 0;
    x->e                = x->y_good ? e : 0;
    x->error            = x->y_good ? low_pass(x->error, e, p->slow_part) : x->error;
    x->need             = minus(x->f, x->b);
    set_friction(p, x, stands, x->flips && before == 0);
    if (is_corrupt(x))
    {
        start_anew(p, x);
        return good ? minus(r, y) : 0;
    }
    tell(x, x->e, x->y_now, x->f);
    return x->tick.OF(e);
}

// Step 7, before u is limited.
static force_t method_term(const loop_params_t *loop, void *memory, force_t v_out)
{
    const params_t *const p = params_of(loop);
    state_t *const        x = &((memory_t *)memory)->state;
    if (!is_running(x))
    {
        return x->mode == TRIBO_FEEDFORWARD_ENTER ? x->tick.OF(term) : 0;
    }
    const force_t v      = inside(v_out);
    const force_t wanted = plus(x->lin, x->f); // without the lead: a pulse
    if (x->flips)
    {
        x->turn_need = plus(v, x->need);
        count_few(&x->flipped);
    }
    if (x->rule ==
        TRIBO_FEEDFORWARD_REVERSAL) // v was wound up during stiction; where it made up for a load, b keeps a part of that
    {
        const force_t beyond = minus(along(x->sign, minus(x->b, x->v)), p->reversal);
        const force_t kept   = clamp(beyond, 0, size_of(x->own_load) / 4);
        x->b                 = plus(x->v, along(x->sign, kept));
    }
    else if (x->rule == TRIBO_FEEDFORWARD_CONTINUE)
    {
        x->b = minus(plus(v, wanted), x->u);
    }
    else if (x->rule == TRIBO_FEEDFORWARD_TAKE_OVER)
    {
        x->b = minus(wanted, inside(x->tick.OF(term)));
        x->v = v; // it has not travelled there
    }
    x->rule = TRIBO_FEEDFORWARD_KEEP;
    x->v    = low_pass(x->v, v, p->fast_part);
    x->b    = clamp_of(x->b, p->offset_max);

    x->tick.OF(term) = outside(minus(wanted, x->b));
    return outside(plus(minus(wanted, x->b), x->lead));
}

/// Step 8: measured friction, and the travel of y apart from its noise.
static void observe(const params_t *p, state_t *x, force_t u)
{
    const force_t before = x->force;
    x->y_noise           = noise_of(p, x->y_noise, x->y_now, x->y);
    x->actuator          = low_pass(x->actuator, u, p->actuator_part);
    x->sensor            = low_pass(x->sensor, x->actuator, p->sensor_part);
    x->force             = low_pass(before, x->y_now, p->fast_part);
    x->difference        = low_pass(x->difference, minus(x->sensor, x->y_now), p->fast_part);
    x->friction          = minus(x->difference, gained(minus(x->force, before), p->damping_gain));
    const force_t half   = plus(p->reversal / 10, coarser(x->y_noise / 5));
    x->travelled         = play(x->travelled, x->force, half);
}

// Member by member, as accesses to volatile objects keep their order.
static void post(const params_t *p, state_t *x)
{
    const bool slides =
        x->mode == TRIBO_FEEDFORWARD_MOVING || (x->mode == TRIBO_FEEDFORWARD_HOLD && x->still < p->still_ticks);

    x->exchange.sample.travelled = x->travelled;
    x->exchange.sample.force     = x->force;
    x->exchange.sample.friction  = x->friction;
    x->exchange.sample.noise     = coarser(x->y_noise);
    x->exchange.sample.effort    = x->v;
    x->exchange.sample.need      = x->turn_need;
    x->exchange.sample.flips     = x->flipped;
    x->exchange.sample.turns     = x->turns;
    x->exchange.sample.chatter   = x->chatter;
    x->exchange.sample.learns    = slides && x->limited == 0 && x->y_good;
    x->exchange.sample.moves     = x->mode == TRIBO_FEEDFORWARD_MOVING;
    x->exchange.sample.starts    = x->starts;
    x->exchange.owner            = TRIBO_FEEDFORWARD_OWNER_LEARNER;

    x->flipped = x->turns = x->chatter = x->starts = 0;
    x->turned_since                                = false;
}

/// The result of the last sample, if there is one.
static bool fetch(state_t *x)
{
    if (x->exchange.owner != TRIBO_FEEDFORWARD_OWNER_RESULT)
    {
        return false;
    }
    copy_weights(&x->weights, &x->exchange.result);
    x->exchange.owner = TRIBO_FEEDFORWARD_OWNER_TICK;
    return true;
}

/// Every 10 ticks: takes what was learned of the last sample, and posts the next. b takes what f and load change by, from what this tick
/// has used, so that u goes on even where that was corrupt.
static void exchange(const params_t *p, state_t *x)
{
    const bool    learned = fetch(x);
    const bool    is_due  = x->exchange.owner == TRIBO_FEEDFORWARD_OWNER_LEARNER;
    const force_t before  = plus(x->f, x->own_load);
    if (x->weights.seal != seal_of(&x->weights))
    {
        forget_weights(p, &x->weights);
        count(&x->forgotten);
    }
    else if (learned && x->turned_since)
    {
        turn_weights(&x->weights);
    }
    x->f        = x->mode == TRIBO_FEEDFORWARD_HOLD ? x->f : friction_at(x, x->sigma);
    x->own_load = learned_load(&x->weights, x->reached);
    x->b        = plus(x->b, minus(plus(x->f, x->own_load), before));
    x->b        = minus(x->b, part_of(x->b, p->leak_part));
    if (is_due)
    {
        count(&x->late);
        return;
    }
    post(p, x);
}

// Step 8, once u is known.
static void method_after(const loop_params_t *loop, void *memory, force_t v, force_t u_out, LOOP(signals_t) * seen)
{
    const params_t *const p = params_of(loop);
    state_t *const        x = &((memory_t *)memory)->state;
    if (!is_running(x))
    {
        return;
    }
    const force_t u = inside(u_out);
    x->u            = x->rests ? x->u : u; // else rounding adds up
    x->limited =
        (int8_t)(seen->controller.limited ? sign_of(minus(plus(inside(v), plus(inside(x->tick.OF(term)), x->lead)), u))
                                          : 0);
    observe(p, x, u);
    x->phase++;
    if (x->phase >= SAMPLE_TICKS)
    {
        x->phase = 0;
        exchange(p, x);
    }
    x->offset_seal = ~bits_of(x->b);
    show(seen, u, plus(x->reached, x->behind[0]), bounded(times(x->level, x->weights.sliding)), x->f);
}

static void method_enter(void *memory, force_t term, bool anew)
{
    enter_at(&((memory_t *)memory)->state, term, anew);
}

// One by one: an initialiser would be a table of absolute addresses.
void FEED(method)(LOOP(functions_t) * functions)
{
    functions->error = method_error;
    functions->term  = method_term;
    functions->after = method_after;
    functions->enter = method_enter;
    functions->start = method_start;
}

void FEED(set_method)(params_t *params)
{
    params->method.functions = FEED(method);
}
