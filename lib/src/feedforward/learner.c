#include "learner.h"

#include "../number/first_order_f32.h"

#define WEIGHTS TRIBO_FEEDFORWARD_WEIGHTS
#define LEARNED TRIBO_FEEDFORWARD_LEARNED

// The reason of each stands in docs/feedforward.md. B is the usual breakaway, w = B/314.
#define WIDTH         (1.0f / 314.0f) // w of B
#define TRAVEL_MAX    2.0f            // delta of w
#define MEASURED      4.0f            // rho of w
#define DOUBT         40.0f           // travel that ends doubt, of w
#define JUMP_MAX      8.0f            // of a change of z, over L
#define SURPRISE      4.0f            // squared deviations
#define UNEXPLAINED   0.01f           // square of what no weight explains, over L
#define WEIGHT_MAX    8.0f            // deviations of a
#define SLIDING_MIN   0.02f
#define SLIDING_LOW   0.2f // at its bound: the configured breakaway is far off
#define SLIDING_MAX   3.0f
#define LOAD_MAX      2.0f  // of the load's regressors
#define PRESLIDING    0.15f // A_0, of V_0^2
#define LACK          1.15f
#define CHATTER       0.9f
#define HARM          0.6f // xi
#define ON_TRIAL      0.51f
#define RATIO_PART    0.125f
#define RATIO_MAX     4.0f
#define EFFORT_WIDTH  0.01f // of B
#define NEED_MIN      0.1f  // of B
#define FEEDBACK_MIN  4u
#define FEEDBACK_MAX  128u
#define FEEDBACK_MORE 8u
#define CREDIBLE_N    1.0e9f

/// Where P_ij stands, for j <= i.
static uint32_t at(uint32_t i, uint32_t j)
{
    return i >= j ? i * (i + 1u) / 2u + j : j * (j + 1u) / 2u + i;
}

/// The bits of what is learned. ~, so that no zeroed memory is sound.
static uint32_t seal_of(const tribo_feedforward_learner_t *x)
{
    uint32_t bits = bits_f32(x->doubt) ^ bits_f32(x->travel_n);
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
            x->P[at(i, j)] = i == j ? 1.0f : 0.0f;
        }
    }
    x->doubt    = 1.0f;
    x->travel_n = 0.0f;
    x->seal     = seal_of(x);
}

static void check(tribo_feedforward_learner_t *x)
{
    if (x->seal != seal_of(x))
    {
        tribo_learner_forget(x);
        count(&x->forgotten);
    }
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

static void start(tribo_feedforward_learner_t *x, const learner_sample_t *sample)
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

/// What a reversal makes of V_0 and load. Slides in one direction cannot tell less friction from a load: as far as no other has slid, all
/// that is lacking is taken for friction.
static void turned(const tribo_feedforward_learning_t *p, const tribo_feedforward_learner_t *x, float *V, float *kept)
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

static void turn(const tribo_feedforward_learning_t *p, tribo_feedforward_learner_t *x)
{
    float V;
    float kept;
    turned(p, x, &V, &kept);
    set_sliding(p, x, V);
    x->a[WEIGHTS] *= kept;
    x->a[WEIGHTS + 1u] *= kept;
    x->surplus *= kept;
}

static bool is_at_bound(float V)
{
    return !(V > SLIDING_LOW && V < SLIDING_MAX);
}

/// Counts the consecutive reversals that find V_0 at a bound; 4 stay.
static void note_bound(const tribo_feedforward_learning_t *p, tribo_feedforward_learner_t *x)
{
    if (x->at_bound < TRIBO_FEEDFORWARD_BOUND_TURNS)
    {
        x->at_bound = (uint8_t)(is_at_bound(tribo_learner_sliding(p, x)) ? x->at_bound + 1u : 0u);
    }
}

/// The travel of v since the last reversal, over the change of what overcomes friction. Where v travels as far as friction changes, it works
/// against what is fed forward.
static void weigh_effort(const tribo_feedforward_learning_t *p,
                         tribo_feedforward_learner_t        *x,
                         const learner_sample_t             *sample)
{
    const float ratio = x->effort_n / (magnitude(sample->need_n - x->need_n) + NEED_MIN * p->breakaway_n);
    x->ratio  = bound_f32(first_order_f32_step(x->ratio, limit_f32(ratio, 0.0f, RATIO_MAX), RATIO_PART), RATIO_MAX);
    x->length = (uint8_t)(x->length > 0u ? x->length - 1u : 0u);
    if (x->ratio > HARM)
    {
        const uint32_t next = FEEDBACK_MORE * x->length; // longer the less it was fed forward since the last
        x->length           = (uint8_t)(next < FEEDBACK_MIN ? FEEDBACK_MIN : next > FEEDBACK_MAX ? FEEDBACK_MAX : next);
        x->left             = x->length;
        x->harms            = 1;
    }
}

/// At a reversal.
static void judge(const tribo_feedforward_learning_t *p, tribo_feedforward_learner_t *x, const learner_sample_t *sample)
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

/// The travel of v, apart from the noise of y.
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

/// One step of the filter, for `travel` of the sample.
static void regress(const tribo_feedforward_learning_t *p,
                    tribo_feedforward_learner_t        *x,
                    const learner_sample_t             *sample,
                    float                               change,
                    float                               travel)
{
    const float w     = WIDTH * p->breakaway_n;
    const float per_L = 1.0f / sample->L_n;
    float       k[LEARNED];
    float       q[LEARNED];
    k[0] = p->deviation[0] * x->stop[0];
    for (uint32_t j = 1; j < WEIGHTS; j++)
    {
        k[j] = p->deviation[j] * (x->stop[j] - x->stop[j - 1u]);
    }
    k[WEIGHTS]      = limit_f32(p->deviation[WEIGHTS] * per_L, 0.0f, LOAD_MAX);
    k[WEIGHTS + 1u] = bound_f32(p->deviation[WEIGHTS + 1u] * sample->force_n * per_L, LOAD_MAX);

    float error = (sample->friction_n - sample->load_n) * per_L - x->stop[0];
    float s2    = 0.0f;
    for (uint32_t i = 0; i < LEARNED; i++)
    {
        q[i] = 0.0f;
        for (uint32_t j = 0; j < LEARNED; j++)
        {
            q[i] += x->P[at(i, j)] * k[j];
        }
        s2 += q[i] * k[i];
        error -= k[i] * x->a[i];
    }
    x->surplus = bound_f32(tribo_learner_load(p, x, sample->force_n) * per_L, WEIGHT_MAX);

    // While friction changes, z lags behind the stops. A surprise beyond two deviations is a push, not friction.
    const float jump   = bound_f32(change * p->jump_lag * per_L, JUMP_MAX);
    const float most   = SURPRISE * (s2 + UNEXPLAINED);
    const float square = error * error;
    const float part   = travel / (MEASURED * w * (1.0f + jump * jump) + travel * s2);
    const float gain   = square > most ? part * (most / square) : part;
    const float back   = limit_f32(p->forgetting_per_n * travel, 0.0f, 1.0f);
    for (uint32_t i = 0; i < LEARNED; i++)
    {
        x->a[i] = bound_f32(x->a[i] + gain * error * q[i], WEIGHT_MAX);
        for (uint32_t j = 0; j <= i; j++)
        {
            const float left = x->P[at(i, j)] - gain * q[i] * q[j];
            x->P[at(i, j)]   = bound_f32(first_order_f32_step(left, i == j ? 1.0f : 0.0f, back), 1.0f);
        }
    }
    x->doubt *= 1.0f - limit_f32(travel / (DOUBT * w), 0.0f, 1.0f);
    x->travel_n += travel;
}

/// The measured force moves stops of its own. What is not learned from has no travel.
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

/// What the tick shall use. Less friction would look like less presliding, hence the gate on the weights of the stops.
static void tell(const tribo_feedforward_learning_t *p,
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
    turned(p, x, &result->turned, &result->kept);
}

void tribo_learner_step(const tribo_feedforward_learning_t *p,
                        tribo_feedforward_learner_t        *x,
                        const learner_sample_t             *sample,
                        tribo_feedforward_f32_weights_t    *result)
{
    const float sum = sample->travelled_n + sample->force_n + sample->friction_n + sample->noise_n + sample->effort_n +
                      sample->need_n;
    check(x);
    for (uint32_t i = 0; i < sample->turns; i++)
    {
        turn(p, x);
    }
    for (uint32_t i = 0; i < sample->chatter; i++)
    {
        set_sliding(p, x, CHATTER * tribo_learner_sliding(p, x));
    }
    if (sample->starts) // what had turned before has turned
    {
        start(x, sample);
    }
    if (!exceeds(sum, CREDIBLE_N)) // else the tick is corrupt, and starts anew
    {
        if (sample->flips > 0u)
        {
            judge(p, x, sample);
        }
        learn(p, x, sample);
        follow_effort(p, x, sample);
    }
    x->seal = seal_of(x);
    tell(p, x, sample->noise_n, result);
}

void tribo_learner_take(const tribo_feedforward_learning_t *p,
                        tribo_feedforward_learner_t        *x,
                        float                               sliding,
                        float                               constant_n,
                        float                               gain,
                        float                               both_n,
                        float                               slid_n)
{
    const float back = limit_f32(p->forgetting_per_n * both_n, 0.0f, 1.0f);
    check(x);
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

/// Variance of L in the direction of a place over the prior's.
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
            variance += k[i] * x->P[at(index[i], index[j])] * k[j];
        }
    }
    return limit_f32(variance / prior, 0.0f, 1.0f);
}

tribo_feedforward_learned_t tribo_learner_readout(const tribo_feedforward_learning_t *p,
                                                  const tribo_feedforward_learner_t  *x,
                                                  const learner_place_t              *place)
{
    const float V    = tribo_learner_sliding(p, x);
    const float load = place->sign * (place->load_n + tribo_learner_load(p, x, place->force_n));
    const float L    = V * place->L_n + load;
    return (tribo_feedforward_learned_t){.L_n               = L > 0.05f * V * place->L_n ? L : 0.05f * V * place->L_n,
                                         .relative_variance = relative_variance(p, x, place),
                                         .travel_n          = x->travel_n,
                                         .at_bound          = is_at_bound(V),
                                         .stays_at_bound    = x->at_bound >= TRIBO_FEEDFORWARD_BOUND_TURNS,
                                         .harms             = x->harms != 0u,
                                         .late              = place->late,
                                         .forgotten         = place->forgotten + x->forgotten};
}

void tribo_learner_restore(tribo_feedforward_learner_t *x)
{
    x->at_bound = 0;
    x->harms    = 0;
    x->left     = 0;
    x->length   = 0;
    x->ratio    = 0.0f;
}
