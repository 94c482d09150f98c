// One tick of the feed-forward with a force sensor: steps 1 to 8 of docs/feedforward.md.
//
//     u = limit(v + lin + f + lead - b)          v = K(z) e          e = rs - y + m2
//
// The loop calls method_error (steps 1 to 6), runs the controller on e, calls method_term (step 7), limits u, and calls
// method_after (step 8). Every 10 ticks the tick and the learner exchange a sample and a result.
//
// This text serves both arithmetics. It is included after words_f32.h or words_q31.h, and after reference.h.

#define SAMPLE_TICKS 10u

/// c(F): the learned part of the force that does not reverse with the motion, c_0 + c_2 F.
static force_t learned_load(const weights_t *w, force_t force)
{
    return bounded(plus(w->constant, times(force, w->scale)));
}

/// G = share (1 - (1 - gamma) doubt) L(rs): the friction level, reduced while little has been learned.
static force_t friction_level(const state_t *x)
{
    return part_of(x->level, x->weights.trust);
}

/// f(sigma) = G (U_0 sigma + U_1 phi_1 + U_2 phi_2), with the sum limited so that corrupt weights stay bounded.
static force_t friction_at(const state_t *x, number_t sigma)
{
    number_t sum = times(x->weights.use[0], sigma);
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_STOPS; j++)
    {
        sum = plus(sum, times(x->weights.use[1u + j], x->stop[j]));
    }
    return bounded(times(friction_level(x), clamp_of(sum, NUMBER(3.99))));
}

/// Starts the method at rest at the reading y. If it enters next to a running controller it starts at r instead, so
/// that e is the error r - y that this controller already has. Learned values stay.
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
    x->phase            = SAMPLE_TICKS - 1u; // post the first sample at the end of this tick
    x->starts           = 1;
    x->flipped          = 0; // turns and chatter stay: they are still to be learned
}

/// Step 3: moves the stops, and counts for how long r has been standing. r moves only if both rp and rs do: rp alone
/// also moves when its play gets narrower. A step of r during a hold does not end the hold. It seeds the mean error
/// instead, or u would stay frozen and b would absorb the step.
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

/// Replaces V_0 and the learned load by their values after a reversal, which the learner has computed beforehand
/// (learner.c, weights_after_turn). `kept` becomes 1 so that a second reversal before the next result changes nothing
/// more.
static void turn_weights(weights_t *w)
{
    if (w->seal == seal_of(w)) // corrupt weights are forgotten at the next exchange
    {
        w->use[0]   = plus(w->use[0], minus(w->turned, w->sliding));
        w->sliding  = w->turned;
        w->constant = part_of(w->constant, w->kept);
        w->scale    = part_of(w->scale, w->kept);
        w->kept     = PART(0.99999994);
        w->seal     = seal_of(w);
    }
}

/// A reversal while r moves. Until the arm has slid both ways, the whole deficit is attributed to friction, because an
/// overestimated friction would overshoot this reversal. The tick changes its weights at once. The learner changes its
/// own with the next sample, and a result that is still under way is changed when it arrives (exchange).
static void apply_turn(state_t *x)
{
    turn_weights(&x->weights);
    x->turned_since = true;
    count_few(&x->turns);
}

/// Step 5: f while r moves. A reversal does not switch f at once: sigma ramps within the jump time, and `lead` makes up
/// for a part of the actuator's lag during the ramp. At the first motion after a start nobody knows how far friction
/// has built up. Then sigma jumps and b absorbs the jump, so u does not move and the controller alone overcomes the
/// breakaway.
static void follow_reference(const params_t *p, state_t *x, bool first)
{
    const number_t left = minus(along(x->sign, NUMBER(1.0)), x->sigma);
    const number_t by   = first ? left : clamp_of(left, p->jump);
    const force_t  jump = bounded(times(friction_level(x), times(x->weights.use[0], by)));
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

/// Counts changes of the side on which the net force exceeds the learned breakaway. Four of them in quick succession
/// mean that feeding friction back makes the arm chatter: breakaway is less than learned. From then on each change is
/// reported to the learner, which lowers V_0 by a tenth.
static void note_chatter(const params_t *p, state_t *x, int8_t side)
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

/// Step 6: r stands and no longer says where friction points, or the monitor has found that friction fed forward does
/// harm. Friction is then fed back: f follows the net force that friction must be holding, u - m - load, up to the
/// learned breakaway. Only 0.94 of it is fed back, because feedback of all of it would hunt.
static void hold(const params_t *p, state_t *x)
{
    const force_t B      = bounded(times(x->level, x->weights.sliding));
    const force_t net    = minus(minus(x->u, x->travelled), x->load);
    const force_t before = x->f;
    x->f                 = part_of(clamp_of(net, B), PART(0.94));
    if (x->mode != TRIBO_FEEDFORWARD_HOLD) // the hold begins: b absorbs the change of f
    {
        x->b     = plus(x->b, minus(x->f, before));
        x->mode  = TRIBO_FEEDFORWARD_HOLD;
        x->rests = false;
        x->side  = x->sign;
        x->since = 0;
        x->quick = 0;
        x->sigma = 0;
    }
    note_chatter(p, x, size_of(net) > B ? sign_of(net) : x->side);

    // e passes through a dead band, or the controller would follow the noise of the sensor. While the mean error is
    // inside the band u rests, with a wider band to leave it so that u does not toggle.
    const force_t noise = coarser(part_of(x->y_noise, PART(0.04)));
    const bool    still = p->still_ticks > 0u && x->still >= p->still_ticks; // otherwise only the monitor holds
    if (x->y_good)
    {
        const force_t most = x->rests ? noise * 7 / 2 : noise;
        x->e               = minus(x->e, clamp_of(x->error, noise));
        x->rests           = still && size_of(x->error) < most;
    }
    if (x->rests)
    {
        x->e    = 0;
        x->rule = TRIBO_FEEDFORWARD_CONTINUE;
    }
}

/// The first tick after a hold. If net force was last beyond breakaway on the side of the new direction, sigma starts
/// there. If not, sigma is where u stands between both breakaways. b is chosen so that u continues.
static void leave_hold(state_t *x)
{
    const force_t rise = bounded(times(friction_level(x), x->weights.use[0]));
    x->sigma           = along(x->sign, NUMBER(1.0));
    if (x->side != x->sign && rise > 0)
    {
        x->sigma = over(minus(minus(x->u, x->lin), friction_at(x, 0)), rise);
    }
    x->f    = friction_at(x, x->sigma);
    x->mode = TRIBO_FEEDFORWARD_MOVING;
    x->rule = TRIBO_FEEDFORWARD_CONTINUE;
}

/// True if a sum or a low pass of the state is beyond any credible force: the state is corrupt.
static bool is_corrupt(const state_t *x)
{
    const force_t passes = plus(plus(plus(x->friction, x->error), plus(x->v, x->force)), plus(x->y_noise, x->r_noise));
    const force_t sum    = plus(plus(x->lin, x->f), plus(x->b, x->travelled));
    return !is_credible(x->e, CREDIBLE_N) || !is_credible(sum, CREDIBLE_N) || !is_credible(passes, CREDIBLE_N);
}

/// Starts the method on the first tick with good inputs, and checks b. If a bit of b has flipped, b is computed anew
/// from the last term, so that u continues. Returns true if the method runs in this tick.
static bool start_or_check(const params_t *p, state_t *x, force_t r, force_t y, bool good)
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

/// Step 5 or 6, depending on whether r stands.
static void set_friction(const params_t *p, state_t *x, bool stands, bool first)
{
    if (stands && x->mode != TRIBO_FEEDFORWARD_START)
    {
        hold(p, x);
    }
    else if (x->mode == TRIBO_FEEDFORWARD_HOLD)
    {
        leave_hold(x);
    }
    else
    {
        follow_reference(p, x, first);
    }
}

// Steps 1 to 6: everything up to the error for the controller.
static force_t method_error(const loop_params_t *loop, void *memory, force_t r, force_t y, part_t fade)
{
    const params_t *const p = params_of(loop);
    state_t *const        x = &((memory_t *)memory)->state;

    const bool good_r = is_credible(r, p->input_max);
    x->y_good         = is_credible(y, p->input_max);
    const bool good   = good_r && x->y_good;
    if (!start_or_check(p, x, r, y, good))
    {
        publish_tick(x, 0, 0, 0);
        return 0;
    }
    x->y_now              = x->y_good ? inside(y) : x->y[0];
    const int8_t   before = x->sign;
    const force_t  e      = plus(minus(x->reached, x->y_now), x->behind[1]); // rs of the last tick: y is its answer
    const follow_t now    = follow(p, x, good_r ? inside(r) : x->r[0]);
    move_stops(p, x, &now);
    const bool stands = (p->still_ticks > 0u && x->still >= p->still_ticks) || x->weights.fed_back != 0u;
    if (x->flips && !stands)
    {
        apply_turn(x);
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
    publish_tick(x, x->e, x->y_now, x->f);
    return x->tick.OF(e);
}

// Step 7: the offset b, and the term that the loop adds to v before it limits u.
static force_t method_term(const loop_params_t *loop, void *memory, force_t v_out)
{
    const params_t *const p = params_of(loop);
    state_t *const        x = &((memory_t *)memory)->state;
    if (!is_running(x))
    {
        return x->mode == TRIBO_FEEDFORWARD_ENTER ? x->tick.OF(term) : 0;
    }
    const force_t v           = inside(v_out);
    const force_t model_force = plus(x->lin, x->f); // without the lead, a short pulse that b must not absorb
    if (x->flips)
    {
        x->turn_need = plus(v, x->need);
        count_few(&x->flipped);
    }
    if (x->rule == TRIBO_FEEDFORWARD_REVERSAL)
    {
        // The controller wound up while the arm stuck. b = v takes that out of u, which would otherwise overshoot the
        // reversal. Where v made up for an unknown load, the load is still there: b keeps up to a quarter of it.
        const force_t beyond = minus(along(x->sign, minus(x->b, x->v)), p->reversal);
        const force_t kept   = clamp(beyond, 0, size_of(x->own_load) / 4);
        x->b                 = plus(x->v, along(x->sign, kept));
    }
    else if (x->rule == TRIBO_FEEDFORWARD_CONTINUE)
    {
        x->b = minus(plus(v, model_force), x->u);
    }
    else if (x->rule == TRIBO_FEEDFORWARD_TAKE_OVER)
    {
        x->b = minus(model_force, inside(x->tick.OF(term)));
        x->v = v; // a hand-over is no travel of v for the monitor
    }
    x->rule = TRIBO_FEEDFORWARD_KEEP;
    x->v    = low_pass(x->v, v, p->fast_part);
    x->b    = clamp_of(x->b, p->offset_max);

    x->tick.OF(term) = outside(minus(model_force, x->b));
    return outside(plus(minus(model_force, x->b), x->lead));
}

/// Step 8: the friction that the learner is to explain, z = u - y behind the lags of actuator and sensor, less the
/// damping of the arm. y also drives a play that is wider than the noise, so that noise does not count as travel.
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

/// Posts a sample for the learner. The members are written one by one, because accesses to volatile objects keep their
/// order and `owner` must be written last.
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

/// Every 10 ticks: takes the result of the last sample and posts the next one. b absorbs the change of f and load by
/// the new weights, so learning never moves u. The change is counted from the f and load that this tick has used, so u
/// continues even after corrupt weights. b then fades over 1000 tau, so that what it has absorbed comes back within a
/// minute.
static void exchange(const params_t *p, state_t *x)
{
    const bool    learned = x->exchange.owner == TRIBO_FEEDFORWARD_OWNER_RESULT;
    const bool    is_late = x->exchange.owner == TRIBO_FEEDFORWARD_OWNER_LEARNER;
    const force_t before  = plus(x->f, x->own_load);
    if (learned)
    {
        copy_weights(&x->weights, &x->exchange.result);
        x->exchange.owner = TRIBO_FEEDFORWARD_OWNER_TICK;
    }
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
    if (is_late)
    {
        count(&x->late);
        return;
    }
    post(p, x);
}

// Step 8: what follows from the limited u.
static void method_after(const loop_params_t *loop, void *memory, force_t v, force_t u_out, LOOP(signals_t) * seen)
{
    const params_t *const p = params_of(loop);
    state_t *const        x = &((memory_t *)memory)->state;
    if (!is_running(x))
    {
        return;
    }
    const force_t u = inside(u_out);
    x->u            = x->rests ? x->u : u; // while u rests, its rounding errors must not add up
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

// Assigned one by one, because an initialiser would compile to a table of absolute addresses.
void FEEDFORWARD(method)(LOOP(functions_t) * functions)
{
    functions->error = method_error;
    functions->term  = method_term;
    functions->after = method_after;
    functions->enter = method_enter;
    functions->start = method_start;
}

void FEEDFORWARD(set_method)(params_t *params)
{
    params->method.functions = FEEDFORWARD(method);
}
