#include "learner.h"

#include "../number/first_order_f32.h"

#define WEIGHTS TRIBO_FEEDFORWARD_WEIGHTS
#define LEARNED TRIBO_FEEDFORWARD_LEARNED

// B is the breakaway at the usual force, w = B/314. docs/feedforward.md has the measurements behind these values.
#define WIDTH         (1.0f / 314.0f) // w as a part of B
#define TRAVEL_MAX    2.0f            // largest delta in w: no sample outweighs the others
#define MEASURED      4.0f            // rho in w: variance of a measurement, per travel
#define DOUBT         40.0f           // travel in w within which the doubt about the prior ends
#define JUMP_MAX      8.0f            // largest change of friction within the lag of z, in L
#define SURPRISE      4.0f            // (2 standard deviations)^2: a larger error is a push
#define UNEXPLAINED   0.01f           // (0.1 L)^2 of friction that no weight explains
#define WEIGHT_MAX    8.0f            // limit of a, in prior deviations
#define SLIDING_MIN   0.02f           // limits of V_0
#define SLIDING_LOW   0.2f            // at_bound from here down: the configured breakaway is far off
#define SLIDING_MAX   3.0f
#define LOAD_MAX      2.0f   // limit of the load's regressors
#define PRESLIDING    0.15f  // least V_1^2 + V_2^2 that counts as presliding, in V_0^2
#define LACK          1.15f  // times the deficit, what V_0 loses at a first reversal
#define CHATTER       0.9f   // factor on V_0 each time that a hold chatters ...
#define CHATTER_MOST  4u     // ... and how often a sample may: more comes from a corrupt tick
#define HARM          0.6f   // xi beyond which friction fed forward does harm
#define ON_TRIAL      0.51f  // xi after feedback: one reversal with a ratio above 1.23 exceeds HARM
#define RATIO_PART    0.125f // weight of a reversal in the low pass of xi
#define RATIO_MAX     4.0f   // limit of xi
#define RATIO_SEEN    0.01f  // the play on v hides less
#define EFFORT_WIDTH  0.01f  // half width of the play on v, in B
#define NEED_MIN      0.1f   // added to the change of need before dividing by it, in B
#define FEEDBACK_MIN  4u     // least and largest number of reversals with friction fed back
#define FEEDBACK_MAX  128u
#define FEEDBACK_MORE 8u     // factor on that number if the harm returns
#define CREDIBLE_N    1.0e9f // a sum beyond it comes from a corrupt tick

/// Index of P_ij, of which the lower triangle is stored by rows.
static uint32_t packed_index(uint32_t i, uint32_t j)
{
    return i >= j ? i * (i + 1u) / 2u + j : j * (j + 1u) / 2u + i;
}

/// Checksum of what is learned. The complement makes zeroed memory fail the check.
static uint32_t seal_of(const tribo_feedforward_learner_t *x)
{
    uint32_t bits = bits_f32(x->doubt) ^ bits_f32(x->travel_n) ^ bits_f32(x->breakaway_n) ^ x->rig;
    for (uint32_t i = 0; i < LEARNED; i++)
    {
        bits ^= bits_f32(x->a[i]);
    }
    for (uint32_t i = 0; i < sizeof(x->P) / sizeof(x->P[0]); i++)
    {
        bits ^= bits_f32(x->P[i]);
    }
    return ~bits;
}

void tribo_learner_forget(tribo_feedforward_learner_t *x)
{
    for (uint32_t i = 0; i < LEARNED; i++)
    {
        x->a[i] = 0.0f;
        for (uint32_t j = 0; j <= i; j++)
        {
            x->P[packed_index(i, j)] = i == j ? 1.0f : 0.0f;
        }
    }
    x->doubt    = 1.0f;
    x->travel_n = 0.0f;
    x->seal     = seal_of(x);
}

void tribo_learner_check(const tribo_feedforward_learning_t *p, tribo_feedforward_learner_t *x)
{
    const bool is_corrupt = x->seal != seal_of(x);
    x->a[WEIGHTS] *= x->breakaway_n / p->breakaway_n; // c_0 stays if only the usual force differs
    x->breakaway_n = p->breakaway_n;
    if (is_corrupt)
    {
        count(&x->forgotten);
    }
    if (is_corrupt || x->rig != p->rig)
    {
        tribo_learner_forget(x);
        tribo_learner_restore(x);
        x->rig = p->rig;
    }
    x->seal = seal_of(x);
}

float tribo_learner_sliding(const tribo_feedforward_learning_t *p, const tribo_feedforward_learner_t *x)
{
    return limit_f32(1.0f + p->deviation[0] * x->a[0], SLIDING_MIN, SLIDING_MAX);
}

static void set_sliding(const tribo_feedforward_learning_t *p, tribo_feedforward_learner_t *x, float V)
{
    x->a[0] = (limit_f32(V, SLIDING_MIN, SLIDING_MAX) - 1.0f) / p->deviation[0];
}

float tribo_learner_load(const tribo_feedforward_learning_t *p, const tribo_feedforward_learner_t *x, float force_n)
{
    return p->deviation[WEIGHTS] * x->a[WEIGHTS] + p->deviation[WEIGHTS + 1u] * x->a[WEIGHTS + 1u] * force_n;
}

/// Starts a run: the arm is at rest, and nothing is known of its friction state.
static void start_run(tribo_feedforward_learner_t *x, const learner_sample_t *sample)
{
    for (uint32_t j = 0; j < WEIGHTS; j++)
    {
        x->stop[j] = 0.0f;
    }
    x->travelled_n = sample->travelled_n;
    x->friction_n  = sample->friction_n;
    x->surplus     = 0.0f;
    x->played_n    = 0.0f;
    x->effort_n    = 0.0f;
    x->begun       = 0;
}

/// V_0 after a reversal, and the part of the learned load that is kept. Slides in one direction cannot tell friction
/// below the configured value from a load that helps the motion. Until the arm has slid both ways, the whole deficit is
/// attributed to friction, because an overestimated friction would overshoot the reversal. `one` is 1 after slides in
/// one direction only, when the variance P_00 of V_0 is still near that of the prior, and falls to 0 as slides in both
/// directions reduce it.
static void weights_after_turn(const tribo_feedforward_learning_t *p,
                               const tribo_feedforward_learner_t  *x,
                               float                              *V,
                               float                              *kept)
{
    const float one  = limit_f32(4.0f * x->P[0] - 0.6f, 0.0f, 1.0f);
    const float lack = -x->stop[0] * one * x->surplus;

    *V    = tribo_learner_sliding(p, x);
    *kept = 1.0f;
    if (lack > 0.0f)
    {
        *V    = limit_f32(*V - LACK * lack, SLIDING_MIN, SLIDING_MAX);
        *kept = 1.0f - one;
    }
}

/// Applies a reversal to what is learned.
static void apply_turn(const tribo_feedforward_learning_t *p, tribo_feedforward_learner_t *x)
{
    float V;
    float kept;
    weights_after_turn(p, x, &V, &kept);
    set_sliding(p, x, V);
    x->a[WEIGHTS] *= kept;
    x->a[WEIGHTS + 1u] *= kept;
    x->surplus *= kept;
}

static bool is_at_bound(float V)
{
    return !(V > SLIDING_LOW && V < SLIDING_MAX);
}

/// Counts the consecutive reversals with V_0 at a bound. At 4 the count latches.
static void note_bound(const tribo_feedforward_learning_t *p, tribo_feedforward_learner_t *x)
{
    if (x->at_bound < TRIBO_FEEDFORWARD_BOUND_TURNS)
    {
        x->at_bound = (uint8_t)(is_at_bound(tribo_learner_sliding(p, x)) ? x->at_bound + 1u : 0u);
    }
}

/// The monitor. xi is the travel of v since the last reversal divided by the change of `need`, the part of u that
/// overcomes friction. If v travels as far as friction changes, the controller works against the friction fed
/// forward. Then friction is fed back for a number of reversals, which grows if fewer were fed forward since the last
/// time.
static void weigh_effort(const tribo_feedforward_learning_t *p,
                         tribo_feedforward_learner_t        *x,
                         const learner_sample_t             *sample)
{
    const float ratio = x->effort_n / (magnitude(sample->need_n - x->need_n) + NEED_MIN * p->breakaway_n);
    x->ratio  = bound_f32(first_order_f32_step(x->ratio, limit_f32(ratio, 0.0f, RATIO_MAX), RATIO_PART), RATIO_MAX);
    x->length = (uint8_t)(x->length > 0u ? x->length - 1u : 0u);
    x->judged = (uint8_t)(x->judged < UINT8_MAX ? x->judged + 1u : UINT8_MAX);
    if (x->ratio > HARM)
    {
        const uint32_t next = FEEDBACK_MORE * x->length;
        x->length           = (uint8_t)(next < FEEDBACK_MIN ? FEEDBACK_MIN : next > FEEDBACK_MAX ? FEEDBACK_MAX : next);
        x->left             = x->length;
        x->harms            = 1;
    }
}

/// Judges a reversal. The first one after a start, and those with friction fed back, say nothing about friction fed
/// forward.
static void judge_reversal(const tribo_feedforward_learning_t *p,
                           tribo_feedforward_learner_t        *x,
                           const learner_sample_t             *sample)
{
    if (x->begun != 0u)
    {
        note_bound(p, x);
    }
    if (x->left > 0u || x->begun == 0u)
    {
        x->played_n = sample->effort_n;
        x->ratio    = x->left == 1u ? ON_TRIAL : x->ratio;
        x->left     = (uint8_t)(x->left > 0u ? x->left - 1u : 0u);
    }
    else
    {
        weigh_effort(p, x, sample);
    }
    x->begun    = 1;
    x->need_n   = sample->need_n;
    x->effort_n = 0.0f;
}

/// Sums the travel of v behind a play that is wider than the noise of y.
static void follow_effort(const tribo_feedforward_learning_t *p,
                          tribo_feedforward_learner_t        *x,
                          const learner_sample_t             *sample)
{
    const float before = x->played_n;
    const float half   = EFFORT_WIDTH * p->breakaway_n + 2.0f * sample->noise_n;
    if (sample->moves)
    {
        x->played_n = limit_f32(before, sample->effort_n - half, sample->effort_n + half);
        x->effort_n = bound_f32(x->effort_n + magnitude(x->played_n - before), 4.0f * p->breakaway_n);
    }
}

/// One step of the Kalman filter. `travel` weighs the sample; `change` is the change of z since the last one.
static void regress(const tribo_feedforward_learning_t *p,
                    tribo_feedforward_learner_t        *x,
                    const learner_sample_t             *sample,
                    float                               change,
                    float                               travel)
{
    const float w     = WIDTH * p->breakaway_n;
    const float per_L = 1.0f / sample->L_n;
    // The regressors k of learner.h. Those of the load are limited, because L may be small.
    float k[LEARNED];
    float q[LEARNED];
    k[0] = p->deviation[0] * x->stop[0];
    for (uint32_t j = 1; j < WEIGHTS; j++)
    {
        k[j] = p->deviation[j] * (x->stop[j] - x->stop[j - 1u]);
    }
    k[WEIGHTS]      = limit_f32(p->deviation[WEIGHTS] * per_L, 0.0f, LOAD_MAX);
    k[WEIGHTS + 1u] = bound_f32(p->deviation[WEIGHTS + 1u] * sample->force_n * per_L, LOAD_MAX);

    // The error of the present weights a, q = P k, and s2 = k P k, the variance that a leaves in the error.
    float error = (sample->friction_n - sample->load_n) * per_L - x->stop[0];
    float s2    = 0.0f;
    for (uint32_t i = 0; i < LEARNED; i++)
    {
        q[i] = 0.0f;
        for (uint32_t j = 0; j < LEARNED; j++)
        {
            q[i] += x->P[packed_index(i, j)] * k[j];
        }
        s2 += q[i] * k[i];
        error -= k[i] * x->a[i];
    }
    x->surplus = bound_f32(tribo_learner_load(p, x, sample->force_n) * per_L, WEIGHT_MAX);

    // While friction changes, z lags behind the stops, so the sample is less certain. An error beyond two standard
    // deviations is a push, not friction: it has no more weight than one at two deviations.
    const float jump   = bound_f32(change * p->jump_lag * per_L, JUMP_MAX);
    const float most   = SURPRISE * (s2 + UNEXPLAINED);
    const float square = error * error;
    const float part   = travel / (MEASURED * w * (1.0f + jump * jump) + travel * s2);
    const float gain   = square > most ? part * (most / square) : part;
    const float back   = limit_f32(p->forgetting_per_n * travel, 0.0f, 1.0f);
    // The covariance falls by what this sample says, and returns to that of the prior over a travel of 1/Q, so that the
    // learner keeps following friction that changes.
    for (uint32_t i = 0; i < LEARNED; i++)
    {
        x->a[i] = bound_f32(x->a[i] + gain * error * q[i], WEIGHT_MAX);
        for (uint32_t j = 0; j <= i; j++)
        {
            const float left         = x->P[packed_index(i, j)] - gain * q[i] * q[j];
            x->P[packed_index(i, j)] = bound_f32(first_order_f32_step(left, i == j ? 1.0f : 0.0f, back), 1.0f);
        }
    }
    x->doubt *= 1.0f - limit_f32(travel / (DOUBT * w), 0.0f, 1.0f);
    x->travel_n += travel;
}

/// Step 9: the measured force moves stops of its own, whether the sample is learned from or not.
static void learn(const tribo_feedforward_learning_t *p, tribo_feedforward_learner_t *x, const learner_sample_t *sample)
{
    const float moved  = sample->travelled_n - x->travelled_n;
    const float change = sample->friction_n - x->friction_n;
    const float travel = bound_f32(magnitude(moved), TRAVEL_MAX * WIDTH * p->breakaway_n);
    for (uint32_t j = 0; j < WEIGHTS; j++)
    {
        x->stop[j] = bound_f32(x->stop[j] + moved * p->per_n[j], 1.0f);
    }
    x->travelled_n = sample->travelled_n;
    x->friction_n  = sample->friction_n;
    if (sample->learns && travel > 0.0f)
    {
        regress(p, x, sample, change, travel);
    }
}

/// Writes the weights for the tick. Friction below the configured value looks like a change of presliding, and so does
/// noise. The gate R therefore uses V_1 and V_2 only as far as they are larger than such an error.
static void write_result(const tribo_feedforward_learning_t *p,
                         const tribo_feedforward_learner_t  *x,
                         float                               noise,
                         tribo_feedforward_f32_weights_t    *result)
{
    const float V   = tribo_learner_sliding(p, x);
    const float V_1 = p->deviation[1] * x->a[1];
    const float V_2 = p->deviation[2] * x->a[2];
    const float A   = V_1 * V_1 + V_2 * V_2;

    const float least = (PRESLIDING + 2.0f * noise / (DOUBT * WIDTH * p->breakaway_n)) * V * V;
    const float ratio = A > least ? least / A : 1.0f;
    const float R     = 1.0f - ratio * ratio;

    result->sliding  = V;
    result->use[0]   = V - R * V_1;
    result->use[1]   = R * V_1 - R * V_2;
    result->use[2]   = R * V_2;
    result->constant = p->deviation[WEIGHTS] * x->a[WEIGHTS];
    result->scale    = p->deviation[WEIGHTS + 1u] * x->a[WEIGHTS + 1u];
    result->trust    = 1.0f - (1.0f - p->trust) * x->doubt;
    result->fed_back = x->harms != 0u && x->left > 0u ? 1u : 0u;
    weights_after_turn(p, x, &result->turned, &result->kept);
}

void tribo_learner_step(const tribo_feedforward_learning_t *p,
                        tribo_feedforward_learner_t        *x,
                        const learner_sample_t             *sample,
                        tribo_feedforward_f32_weights_t    *result)
{
    const float sum = sample->travelled_n + sample->force_n + sample->friction_n + sample->noise_n + sample->effort_n +
                      sample->need_n;
    tribo_learner_check(p, x);
    for (uint32_t i = 0; i < sample->turns; i++)
    {
        apply_turn(p, x);
    }
    for (uint32_t i = 0; i < sample->chatter && i < CHATTER_MOST; i++)
    {
        set_sliding(p, x, CHATTER * tribo_learner_sliding(p, x));
    }
    if (sample->starts) // after the turns and chatter, which are of the run before
    {
        start_run(x, sample);
    }
    if (!exceeds(sum, CREDIBLE_N)) // otherwise the tick is corrupt and starts anew by itself
    {
        if (sample->flips > 0u)
        {
            judge_reversal(p, x, sample);
        }
        learn(p, x, sample);
        follow_effort(p, x, sample);
    }
    x->seal = seal_of(x);
    write_result(p, x, sample->noise_n, result);
}

void tribo_learner_take(const tribo_feedforward_learning_t *p,
                        tribo_feedforward_learner_t        *x,
                        float                               sliding,
                        float                               constant_n,
                        float                               gain,
                        float                               both_n,
                        float                               slid_n)
{
    // The bounds keep an odd slide from moving V_0 or c_0 far.
    const float back = limit_f32(p->forgetting_per_n * both_n, 0.0f, 1.0f);
    tribo_learner_check(p, x);
    set_sliding(p, x, tribo_learner_sliding(p, x) + gain * bound_f32(sliding - tribo_learner_sliding(p, x), 0.25f));
    const float c = p->deviation[WEIGHTS] * x->a[WEIGHTS];
    x->a[WEIGHTS] =
        bound_f32(c + gain * bound_f32(constant_n - c, 2.0f * p->breakaway_n), p->breakaway_n) / p->deviation[WEIGHTS];
    x->travel_n = x->travel_n + slid_n;
    for (uint32_t i = 0; i < sizeof(x->P) / sizeof(x->P[0]); i++)
    {
        x->P[i] *= 1.0f - gain;
    }
    x->P[0] = first_order_f32_step(x->P[0], 1.0f, back);
    x->seal = seal_of(x);
    note_bound(p, x);
}

/// Variance of breakaway in the direction of `place`, divided by that of the prior.
static float relative_variance(const tribo_feedforward_learning_t *p,
                               const tribo_feedforward_learner_t  *x,
                               const learner_place_t              *place)
{
    const uint32_t index[3] = {0, WEIGHTS, WEIGHTS + 1u};
    const float    k[3]     = {p->deviation[0] * place->L_n,
                               place->sign * p->deviation[WEIGHTS],
                               place->sign * p->deviation[WEIGHTS + 1u] * place->force_n};
    float          variance = 0.0f;
    float          prior    = 0.0f;
    for (uint32_t i = 0; i < 3u; i++)
    {
        prior += k[i] * k[i];
        for (uint32_t j = 0; j < 3u; j++)
        {
            variance += k[i] * x->P[packed_index(index[i], index[j])] * k[j];
        }
    }
    return limit_f32(variance / prior, 0.0f, 1.0f);
}

/// The sum of two counts, which stops at UINT32_MAX.
static uint32_t both(uint32_t a, uint32_t b)
{
    return a < UINT32_MAX - b ? a + b : UINT32_MAX;
}

tribo_feedforward_learned_t tribo_learner_readout(const tribo_feedforward_learning_t *p,
                                                  const tribo_feedforward_learner_t  *x,
                                                  const learner_place_t              *place)
{
    tribo_feedforward_learner_t known = *x;
    if (known.rig != p->rig) // the next sample will find that
    {
        tribo_learner_forget(&known);
    }
    const float V    = tribo_learner_sliding(p, &known);
    const float load = place->sign * (place->load_n + tribo_learner_load(p, &known, place->force_n));
    const float L    = V * place->L_n + load; // reported as 5 % of friction at least: a load may exceed friction
    return (tribo_feedforward_learned_t){.L_n               = L > 0.05f * V * place->L_n ? L : 0.05f * V * place->L_n,
                                         .relative_variance = relative_variance(p, &known, place),
                                         .travel_n          = known.travel_n,
                                         .at_bound          = is_at_bound(V),
                                         .stays_at_bound    = known.at_bound >= TRIBO_FEEDFORWARD_BOUND_TURNS,
                                         .harms             = known.harms != 0u,
                                         .late              = place->late,
                                         .forgotten         = both(place->forgotten, known.forgotten)};
}

float tribo_learner_times_less(const tribo_feedforward_learner_t *x)
{
    if (x->judged == 0u || x->left > 0u)
    {
        return 0.0f;
    }
    float missing = 1.0f; // xi begins at 0: the part of its mean that it has not yet reached
    for (uint32_t i = 0; i < x->judged; i++)
    {
        missing *= 1.0f - RATIO_PART;
    }
    const float mean = x->ratio / (1.0f - missing);
    return 1.0f / (mean > RATIO_SEEN ? mean : RATIO_SEEN);
}

void tribo_learner_restore(tribo_feedforward_learner_t *x)
{
    x->at_bound = 0;
    x->harms    = 0;
    x->left     = 0;
    x->length   = 0;
    x->ratio    = 0.0f;
    x->judged   = 0;
}
