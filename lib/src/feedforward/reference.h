// What the feed-forwards with and without a force sensor share: they follow the reference r, and model the path from u
// to y without friction (steps 2 to 4 of docs/feedforward.md, which has the symbols). Starts and hand-overs are here,
// too.
//
// This text serves both arithmetics and is included after words_f32.h or words_q31.h. Not synchronized: one state, one
// tick.

#define FEEDFORWARD(name) NAME(feedforward, name)
#define LOOP(name)        NAME(force_loop, name)
#define SENSORLESS(name)  NAME(sensorless, name)
#define ESTIMATE(name)    NAME(force_estimate, name)

typedef FEEDFORWARD(params_t) params_t;
typedef FEEDFORWARD(state_t) state_t;
typedef FEEDFORWARD(memory_t) memory_t;
typedef FEEDFORWARD(weights_t) weights_t;
typedef LOOP(params_t) loop_params_t;

/// Names the method with a force sensor in `params`. tick.h defines it next to the method, because the address of a
/// function of another source needs a table of absolute addresses.
void FEEDFORWARD(set_method)(params_t *params);

/// Makes the params of a loop's method in the loop's set-up.
tribo_status_t FEEDFORWARD(make)(const tribo_loop_part_t             *part,
                                 const tribo_force_loop_f32_config_t *loop,
                                 float                                full_scale_n,
                                 loop_params_t                       *made);

/// The method's params: `loop->method` points to their first member.
static inline const params_t *params_of(const loop_params_t *loop)
{
    return (const params_t *)loop->method;
}

static inline bool is_running(const state_t *x)
{
    return x->mode >= TRIBO_FEEDFORWARD_START && x->mode <= TRIBO_FEEDFORWARD_HOLD;
}

static inline int8_t sign_of(force_t x)
{
    return (int8_t)((x > 0) - (x < 0));
}

/// x times the sign of a direction, 0 without one. A product would overflow if the sign were corrupt.
static inline force_t along(int8_t sign, force_t x)
{
    return sign > 0 ? x : sign < 0 ? minus(0, x) : 0;
}

/// x limited to low..high. A NaN becomes low, so that a corrupt state recovers.
static inline force_t clamp(force_t x, force_t low, force_t high)
{
    if (!(x >= low))
    {
        return low;
    }
    return x > high ? high : x;
}

/// A play: x stays until `at` is more than `half` away, and is then dragged along.
static inline force_t play(force_t x, force_t at, force_t half)
{
    return clamp(x, minus(at, half), plus(at, half));
}

static inline void count_few(uint8_t *counter)
{
    *counter = (uint8_t)(*counter < UINT8_MAX ? *counter + 1u : UINT8_MAX);
}

/// Checksum of the learned weights that the tick uses. The complement makes zeroed memory fail the check.
static inline uint32_t seal_of(const weights_t *x)
{
    uint32_t bits = bits_of(x->sliding) ^ bits_of(x->constant) ^ bits_of(x->scale) ^ bits_of(x->turned);
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_WEIGHTS; j++)
    {
        bits ^= bits_of(x->use[j]);
    }
    return ~(bits ^ bits_of((force_t)x->trust) ^ bits_of((force_t)x->kept) ^ x->fed_back);
}

/// Copies member by member, because accesses to volatile objects keep their order.
static inline void copy_weights(volatile weights_t *to, const volatile weights_t *from)
{
    to->sliding  = from->sliding;
    to->constant = from->constant;
    to->scale    = from->scale;
    to->trust    = from->trust;
    to->turned   = from->turned;
    to->kept     = from->kept;
    to->fed_back = from->fed_back;
    to->seal     = from->seal;
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_WEIGHTS; j++)
    {
        to->use[j] = from->use[j];
    }
}

/// Sets the weights to those of an untrained method: the configured breakaway times `trust`, no stops and no load. They
/// are set member by member, because assigning a struct would call memset in a tick.
static inline void forget_weights(const params_t *p, weights_t *x)
{
    x->sliding  = NUMBER(1.0);
    x->constant = 0;
    x->scale    = 0;
    x->trust    = p->trust;
    x->turned   = NUMBER(1.0);
    x->kept     = PART(0.99999994);
    x->fed_back = 0;
    for (uint32_t j = 0; j < TRIBO_FEEDFORWARD_WEIGHTS; j++)
    {
        x->use[j] = j == 0u ? NUMBER(1.0) : 0;
    }
    x->seal = seal_of(x);
}

/// Puts the state to rest at the force `at` with the reference r. Next to a running controller b takes over, so that u
/// continues. Learned values stay.
static inline void rest_at(const params_t *p, state_t *x, force_t r, force_t at)
{
    const bool enters = x->mode == TRIBO_FEEDFORWARD_ENTER;
    if (x->weights.seal != seal_of(&x->weights))
    {
        forget_weights(p, &x->weights);
    }
    x->mode    = TRIBO_FEEDFORWARD_START;
    x->rule    = enters ? TRIBO_FEEDFORWARD_TAKE_OVER : TRIBO_FEEDFORWARD_KEEP;
    x->sign    = 0;
    x->limited = 0;
    x->flips   = false;
    x->r[0] = x->r[1] = r;
    x->reached = x->turned = at;
    x->r_noise = x->rate = x->behind[0] = x->behind[1] = 0;
    x->sigma = x->b = x->f = x->v = 0;
}

/// Publishes the tick's values that the loop reads: it needs them for the guard and for a change of params.
static inline void publish_tick(state_t *x, force_t e, force_t y, force_t friction)
{
    x->tick.OF(e)        = outside(e);
    x->tick.OF(y)        = outside(y);
    x->tick.OF(friction) = outside(friction);
    x->tick.has_e        = is_running(x);
    x->tick.has_y        = x->tick.has_e;
}

/// Starts a corrupt state anew, with u continuing from the last credible term. Learned values are kept if their
/// checksum fits.
static inline void start_anew(const params_t *p, state_t *x)
{
    if (x->weights.seal != seal_of(&x->weights))
    {
        forget_weights(p, &x->weights);
    }
    x->mode          = TRIBO_FEEDFORWARD_ENTER;
    x->tick.OF(term) = is_credible(inside(x->tick.OF(term)), p->offset_max) ? x->tick.OF(term) : 0;
    publish_tick(x, 0, 0, 0);
    count(&x->forgotten);
}

/// After a change of params: b is chosen in the next tick so that `term` is added to the controller's output. `anew` is
/// true if another method ran before; otherwise a running method keeps its state.
static inline void enter_at(state_t *x, force_t term, bool anew)
{
    if (x->mode == TRIBO_FEEDFORWARD_RESTART && !anew)
    {
        return; // no tick has run yet, so there is no term to continue from
    }
    const bool goes_on = is_running(x) && !anew;
    x->mode            = (uint8_t)(goes_on ? x->mode : TRIBO_FEEDFORWARD_ENTER);
    x->rule            = goes_on ? TRIBO_FEEDFORWARD_TAKE_OVER : TRIBO_FEEDFORWARD_KEEP;
    x->tick.OF(term)   = is_credible(term, CREDIBLE_N) ? term : 0;
    x->tick.has_e      = goes_on;
}

/// Prepares the memory for the first tick of a run. Zeroed memory is always reset, because it holds nothing learned.
static inline void method_start(void *memory, bool keep_learned)
{
    memory_t *const all = (memory_t *)memory;
    if (!keep_learned || all->state.learner.seal == 0u)
    {
        FEEDFORWARD(reset)(&all->state);
    }
    all->state.mode = TRIBO_FEEDFORWARD_RESTART;
    all->state.tick = (LOOP(tick_t)){.has_e = false};
    all->motion     = (FEEDFORWARD(motion_t)){.sign = 0};
}

/// Noise of a signal: the mean magnitude of its second difference, which a ramp does not have. A tick counts with at
/// most four times the mean, so that reversals and steps are not taken for noise. `last` holds the two values before
/// `now`.
static inline force_t noise_of(const params_t *p, force_t mean, force_t now, force_t last[2])
{
    const force_t second = finer(size_of(minus(minus(now, last[0]), minus(last[0], last[1]))));
    const force_t most   = plus(gained(size_of(mean), GAIN(4.0)), p->noise_floor);
    last[1]              = last[0];
    last[0]              = now;
    return low_pass(mean, second < most ? second : most, p->noise_part);
}

/// How rs and rp follow r in a tick.
typedef struct
{
    force_t moved;  ///< change of rs in this tick
    force_t turned; ///< change of rp in this tick: the travel that is no noise
    force_t width;  ///< W, how far r must return to count as reversed
    bool    step;   ///< r steps: the move has no rate
} follow_t;

/// Steps 2 and 3. rs follows r, but stops while u is at the limit that r moves towards. rp follows rs through a play of
/// width W, which grows with the noise of r so that noise is no reversal. The last move of rp gives the direction s.
static inline follow_t follow(const params_t *p, state_t *x, force_t r)
{
    const force_t last     = minus(x->r[0], x->r[1]);
    x->r_noise             = noise_of(p, x->r_noise, r, x->r);
    const force_t width    = plus(p->reversal, coarser(gained(x->r_noise, GAIN(4.0))));
    const force_t distance = minus(r, x->reached);
    const bool    held     = x->limited != 0 && sign_of(distance) * x->limited > 0;
    const force_t moved    = held ? 0 : distance;
    const bool    step     = size_of(moved) > p->step && size_of(minus(moved, last)) > p->step; // else a fast ramp
    const force_t before   = x->turned;
    const int8_t  sign     = x->sign;
    x->reached             = bounded(plus(x->reached, moved));
    x->rate                = low_pass(x->rate, step ? 0 : finer(moved), p->fast_part);
    x->turned              = play(before, x->reached, width / 2);
    const force_t turned   = minus(x->turned, before);
    x->sign                = turned != 0 ? sign_of(turned) : sign;
    x->flips               = x->sign != sign;
    return (follow_t){.moved = moved, .turned = turned, .width = width, .step = step};
}

/// Step 4: the lead of lin before rs that makes up for the lag tau of actuator and arm. A noisy r has no reliable rate,
/// so the lead shrinks as W grows. m_1 and m_2, the modelled force of the arm and its reading, are held as distances
/// from rs.
static inline force_t lead_of(const params_t *p, state_t *x, const follow_t *now, force_t rate)
{
    const force_t ahead = bounded(gained(times(rate, over(p->reversal, now->width)), p->lag_gain));
    x->behind[0]        = low_pass(minus(x->behind[0], now->moved), ahead, p->lag_part);
    x->behind[1]        = low_pass(minus(x->behind[1], now->moved), x->behind[0], p->sensor_part);
    return ahead;
}
