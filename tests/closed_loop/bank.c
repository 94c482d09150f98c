#include "bank.h"

#include "tribo/controller_f32.h"
#include "tribo/paper_controller.h"

#include <math.h>
#include <stddef.h>

#define H        1e-3
#define ACTUATOR 200.0           // pole, rad/s
#define SENSOR   55.0            // pole, rad/s
#define ARM_LAG  (0.0288 / 3.84) // b/K, s
#define U_MAX    2.0
#define PART(T)  (H / ((T) + H)) // of a low pass with time constant T

// Constants of the design that are not studied.
#define STOP_RATIO       (8.0 / 3.0)
#define NOISE_TIME_S     0.25
#define RATE_TIME_S      0.010
#define STEP_N           (2.0 * H) // a larger move of r in a tick is a step
#define NOISE_WIDTH      4.0       // width of a reversal per mean second difference of r
#define TRAVEL_WIDTH_N   0.1e-3
#define TRAVEL_NOISE     0.4
#define OBSERVER_TIME_S  0.010
#define RATE_MAX_N_S     0.5
#define MEASURED_MOST_N  1e-3 // a larger move counts as that
#define WEIGHING_N       2e-3 // R
#define FORGETTING_1_N   0.1  // Q
#define DOUBT_TRAVEL_N   0.020
#define PRIOR_WEIGHT     0.5 // of f before anything is learned
#define PRIOR_SD         0.4 // of V_0
#define PRIOR_STOP_SD    0.55
#define PRIOR_CONSTANT_N 0.030
#define PRIOR_SLOPE      0.1
#define CONSTANT_MOST_N  0.157
#define SLOPE_MOST       0.5
#define LAG_S            0.030 // of z behind the stops
#define SURPRISE         4.0   // squared standard deviations; what surprises more is a push, not friction
#define MODEL_ERROR      0.01  // square of what no weight explains
#define LEAST_PRESLIDING 0.15  // sum of squared weights of the stops below which none is used
#define EFFORT_TIME_S    0.03
#define EFFORT_WIDTH     0.02 // of L
#define NEED_LEAST       0.1  // of L
#define HARM_MOST        4.0
#define HARM_REVERSALS   8.0
#define HARM             1.2 // effort with friction fed forward over that without
#define HARM_SHARE       0.0
#define FADE_TIME_S      1.0
#define HOLD_GAIN        0.94
#define HOLD_MARGIN      0.85

static const tribo_biquad_f32_section_t controller[2] = TRIBO_PAPER_CONTROLLER_F32;

bank_options_t bank_default(void)
{
    return (bank_options_t){.method       = BANK_FEEDFORWARD,
                            .lead         = 0.7,
                            .shrinkage    = 0.2,
                            .still_time_s = 0.2,
                            .width_n      = 0.5e-3,
                            .jump_time_s  = 0.020,
                            .factor       = 1.0,
                            .stop_n       = 0.75e-3,
                            .period       = 4.0};
}

void bank_reset(bank_t *x)
{
    *x = (bank_t){.running = false};
}

static double within(double x, double low, double high)
{
    return fmin(fmax(x, low), high);
}

static int sign_of(double x)
{
    return (x > 0.0) - (x < 0.0);
}

static double breakaway(double force)
{
    return 0.007 + 0.3 * fabs(force);
}

// --- the controller -------------------------------------------------------------------------------------------------

static double output(const bank_t *x, double e, double y[2])
{
    y[0] = (double)controller[0].b0 * e + x->w1[0];
    y[1] = (double)controller[1].b0 * y[0] + x->w1[1];
    return y[1];
}

/// u within its limits; the states receive the difference (anti-windup).
static double apply(bank_t *x, double e, const double y[2], double unsaturated)
{
    const double u          = within(unsaturated, -U_MAX, U_MAX);
    double       correction = (u - unsaturated) / ((double)controller[0].b0 * (double)controller[1].b0);
    double       in         = e + correction;
    for (int i = 0; i < 2; i++)
    {
        correction *= (double)controller[i].b0;
        const double out = y[i] + correction;
        const double w2  = x->w2[i];
        x->w1[i] += (double)controller[i].b1 * in - (double)controller[i].a1 * out + w2;
        x->w2[i] += (double)controller[i].b2 * in - (double)controller[i].a2 * out;
        in = out;
    }
    x->limited = sign_of(unsaturated - u);
    return u;
}

// --- the bank -------------------------------------------------------------------------------------------------------

static void start(bank_t *x, double r, double y)
{
    bank_reset(x);
    x->running = true;
    x->r[0] = x->r[1] = r;
    x->y[0] = x->y[1] = y;
    x->reached = x->play = x->stopped = x->anchor = y;
    x->u = x->actuator = x->sensor = x->filtered = x->travelled = y;
    x->weight[0]                                                = 1.0;
    x->doubt                                                    = 1.0;
    x->share                                                    = 1.0;
    for (int j = 0; j < BANK_STOPS; j++)
    {
        x->variance[j] = 1.0;
    }
    for (int j = 0; j < BANK_LOADS; j++)
    {
        x->covariance[j][j] = 1.0;
    }
}

/// Updates the mean second difference of a signal with its `last` two values; each tick counts at most four times the mean.
static double noise(double mean, double now, double last[2])
{
    const double second = fmin(fabs(now - 2.0 * last[0] + last[1]), 4.0 * mean + 1e-6);
    last[1]             = last[0];
    last[0]             = now;
    return mean + (second - mean) * H / NOISE_TIME_S;
}

static double stop_width(const bank_options_t *options, int j)
{
    return options->stop_n * pow(STOP_RATIO, j);
}

/// A learned weight for use: small ones, possibly noise, shrink.
static double shrunk(const bank_options_t *options, double V)
{
    return V * V * V / (V * V + options->shrinkage * options->shrinkage);
}

/// Part of the stops' weights that is used: none before they are sure to be more than the creep at a jump.
static double presliding(const bank_t *x)
{
    double squares = 0.0;
    for (int j = 1; j <= BANK_STOPS; j++)
    {
        squares += x->weight[j] * x->weight[j];
    }
    return squares > LEAST_PRESLIDING ? 1.0 - pow(LEAST_PRESLIDING / squares, 2.0) : 0.0;
}

/// Step 4: f for direction sigma.
static double friction(const bank_t *x, const bank_options_t *options, double sigma)
{
    const double part = presliding(x);
    double       last = sigma;
    double       sum  = x->weight[0] * sigma;
    for (int j = 0; j < BANK_STOPS; j++)
    {
        const double phi = x->stop[j] / stop_width(options, j);
        sum += part * shrunk(options, x->weight[j + 1]) * (phi - last);
        last = phi;
    }
    return options->factor * x->share * (1.0 - (1.0 - PRIOR_WEIGHT) * x->doubt) * breakaway(x->reached) * sum;
}

/// The value of v in a slide at rs.
static double bias(const bank_t *x)
{
    return x->constant + x->slope * fabs(x->reached) + x->scale * x->reached;
}

/// Step 10: f while r stands, from the play of hold_f32.h around u.
static double hold(bank_t *x, double *e, double y)
{
    const double L = HOLD_MARGIN * x->share * fmax(0.2, x->weight[0]) * breakaway(x->reached) * (1.0 - x->extra_margin);
    const double last  = x->y[0];
    const double moved = fabs(y - 2.0 * last + x->y[1]);
    if (!x->holds)
    {
        const double f = within(x->f, -L, L);
        x->held_force  = x->u - f;
        x->offset += HOLD_GAIN * f - x->f;
        x->side       = x->sign;
        x->held_error = 0.0;
        x->side_s     = 0.0;
        x->quick      = 0;
        x->phase      = 0;
        x->travel     = 0.0;
    }
    const double f    = within(x->u - x->held_force, -L, L);
    const double F    = x->u - f;
    const int    side = F != x->held_force ? sign_of(F - x->held_force) : x->side;
    x->side_s += H;
    if (side != x->side)
    {
        x->quick = x->side_s < 0.2 ? x->quick + 1 : 0;
        x->extra_margin += x->quick >= 4 ? 0.1 * (1.0 - x->extra_margin) : 0.0;
        x->side_s = 0.0;
    }
    x->side       = side;
    x->held_force = F;
    x->sigma      = 0.0;

    const bool changes = y != last;
    x->held_changes += ((changes ? 1.0 : 0.0) - x->held_changes) * PART(0.3);
    x->held_noise += changes ? (moved - x->held_noise) * PART(0.3) : 0.0;
    x->held_error += (*e - x->held_error) * PART(0.3);
    const double deadband = x->held_noise * (0.1 * x->held_changes + 0.6 * (1.0 - x->held_changes));
    *e -= within(x->held_error, -deadband, deadband);
    return HOLD_GAIN * f;
}

/// f in the first tick after a hold, chosen so that u continues.
static double leave(bank_t *x, const bank_options_t *options, double lin)
{
    const double at_0 = friction(x, options, 0.0);
    const double rise = friction(x, options, 1.0) - at_0;
    x->sigma          = x->sign;
    if (x->side != x->sign && rise > 0.0)
    {
        x->sigma = within((x->u - lin - at_0) / rise, -1.0, 1.0);
    }
    return friction(x, options, x->sigma);
}

/// Step 9: a sample of the regressor and of the measured friction with its change over LAG_S.
static void sample(bank_t *x, const double psi[BANK_STOPS + 1], double z, double change)
{
    const double load = fabs(x->filtered);
    const double L    = breakaway(x->filtered);
    x->sample_k[0]    = PRIOR_SD * psi[0];
    x->sample_k[1]    = PRIOR_CONSTANT_N / L;
    x->sample_k[2]    = PRIOR_SLOPE * load / L;
    x->sample_k[3]    = PRIOR_SLOPE * x->filtered / L;
    x->sample_e       = (z - x->constant - x->slope * load - x->scale * x->filtered) / L;
    for (int j = 0; j <= BANK_STOPS; j++)
    {
        x->sample_e -= x->weight[j] * psi[j];
    }
    for (int j = 0; j < BANK_STOPS; j++)
    {
        x->sample_psi[j] = PRIOR_STOP_SD * psi[j + 1];
    }
    x->sample_weighing = WEIGHING_N * (1.0 + pow(change / L, 2.0));
    x->sample_travel   = fmin(x->travel, MEASURED_MOST_N);
    x->travel          = 0.0;
}

/// Learning from the sample of the last tick. A sample is taken every `period` ticks, so that its parts may be spread over them.
static void learn(bank_t *x, const bank_options_t *options)
{
    const double *const regress       = x->sample_k;
    double              q[BANK_LOADS] = {0.0};
    double              spread        = 0.0;
    double              q_stop[BANK_STOPS];
    const double        travel = x->sample_travel;
    const double        error  = x->sample_e;
    for (int i = 0; i < BANK_LOADS; i++)
    {
        for (int j = 0; j < BANK_LOADS; j++)
        {
            q[i] += x->covariance[i][j] * regress[j];
        }
        spread += q[i] * regress[i];
    }
    for (int j = 0; j < BANK_STOPS; j++)
    {
        q_stop[j] = x->variance[j] * x->sample_psi[j];
        spread += q_stop[j] * x->sample_psi[j];
    }
    const double trust  = fmin(1.0, SURPRISE * (spread + MODEL_ERROR) / (error * error));
    const double gain   = trust * travel / (x->sample_weighing + travel * spread);
    const double before = friction(x, options, x->sigma) + bias(x);
    x->weight[0]        = within(x->weight[0] + PRIOR_SD * gain * q[0] * error, 0.2, 3.0);
    x->constant = within(x->constant + PRIOR_CONSTANT_N * gain * q[1] * error, -CONSTANT_MOST_N, CONSTANT_MOST_N);
    x->slope    = within(x->slope + PRIOR_SLOPE * gain * q[2] * error, -SLOPE_MOST, SLOPE_MOST);
    x->scale    = within(x->scale + PRIOR_SLOPE * gain * q[3] * error, -SLOPE_MOST, SLOPE_MOST);
    for (int i = 0; i < BANK_LOADS; i++)
    {
        for (int j = 0; j < BANK_LOADS; j++)
        {
            x->covariance[i][j] -= gain * q[i] * q[j];
            x->covariance[i][j] += FORGETTING_1_N * travel * ((i == j ? 1.0 : 0.0) - x->covariance[i][j]);
        }
    }
    for (int j = 0; j < BANK_STOPS; j++)
    {
        x->weight[j + 1] = within(x->weight[j + 1] + PRIOR_STOP_SD * gain * q_stop[j] * error, -2.0, 2.0);
        x->variance[j] -= gain * q_stop[j] * q_stop[j];
        x->variance[j] += FORGETTING_1_N * travel * (1.0 - x->variance[j]);
    }
    x->doubt -= x->doubt * fmin(1.0, travel / DOUBT_TRAVEL_N);
    x->extra_margin -= x->extra_margin * travel / 0.1;
    x->f = friction(x, options, x->sigma);
    x->offset += x->f + bias(x) - before; // learning does not move u
}

/// Steps 7 and 8: the measured friction, and the same stops on the measured force.
static void observe(bank_t *x, const bank_options_t *options, double y)
{
    const double before = x->filtered;
    x->actuator += (1.0 - exp(-ACTUATOR * H)) * (x->u - x->actuator);
    x->sensor += (1.0 - exp(-SENSOR * H)) * (x->actuator - x->sensor);
    x->y_noise = noise(x->y_noise, y, x->y);
    x->filtered += PART(OBSERVER_TIME_S) * (y - x->filtered);
    x->difference += PART(OBSERVER_TIME_S) * (x->sensor - y - x->difference);
    const double rate  = (x->filtered - before) / H;
    const double half  = 0.5 * (TRAVEL_WIDTH_N + TRAVEL_NOISE * x->y_noise);
    const double now   = within(x->travelled, x->filtered - half, x->filtered + half);
    const double moved = now - x->travelled;
    double       last  = 0.0;
    double       psi[BANK_STOPS + 1];
    const double z      = x->difference - ARM_LAG * rate;
    const double change = (z - x->measured) * LAG_S / H;
    x->travelled        = now;
    x->measured         = z;
    if (x->phase == 1)
    {
        learn(x, options);
    }
    if (x->phase > 0)
    {
        x->phase = (x->phase + 1) % (int)options->period;
    }
    for (int j = 0; j <= BANK_STOPS; j++)
    {
        const double width  = j == 0 ? 0.5 * options->width_n : stop_width(options, j - 1);
        x->measured_stop[j] = within(x->measured_stop[j] + moved, -width, width);
        const double phi    = x->measured_stop[j] / width;
        psi[j]              = phi - last;
        last                = phi;
    }
    if (x->limited == 0 && x->sign != 0 && fabs(rate) <= RATE_MAX_N_S && !x->holds)
    {
        x->travel += fabs(moved);
        if (x->travel > 0.0 && x->phase == 0)
        {
            sample(x, psi, z, change);
            x->phase = 1;
        }
    }
}

/// f while r moves; `lead` gets the jump's lead. Returns f.
static double follow(bank_t *x, const bank_options_t *options, bool controller_alone, double *lead)
{
    const double before = x->sigma;
    const double most   = 2.0 * H / options->jump_time_s;
    x->sigma += controller_alone ? x->sign - before : within(x->sign - before, -most, most);
    const double jump = friction(x, options, x->sigma) - friction(x, options, before);
    if (controller_alone)
    {
        x->offset += jump;
    }
    *lead = controller_alone ? 0.0 : options->lead / (ACTUATOR * H) * jump;
    return friction(x, options, x->sigma);
}

/// True if r has stayed within `half` of one value for the still time.
static bool stands(bank_t *x, const bank_options_t *options, double half, bool step)
{
    x->still_s += H;
    if (fabs(x->reached - x->anchor) > half)
    {
        x->anchor  = x->reached;
        x->still_s = step && x->holds ? x->still_s : 0.0;
    }
    return options->still_time_s > 0.0 && x->still_s > options->still_time_s && x->sign != 0;
}

/// Compares what the controller does with friction fed forward (the travel of v) to what it would have to do without (the change
/// of the whole that overcomes friction, from a reversal to the next). Where it does more, `share` fades to nothing and stays there.
/// `reversed`: this tick is a judged reversal; `anew`: the comparison begins with this tick.
static void monitor(bank_t *x, double v, bool reversed, bool anew)
{
    const double L    = breakaway(x->reached);
    const double half = 0.5 * (EFFORT_WIDTH * L + NOISE_WIDTH * x->y_noise);
    x->effort += (v - x->effort) * PART(EFFORT_TIME_S);
    const double play = within(x->effort_play, x->effort - half, x->effort + half);
    x->effort_travel += fabs(play - x->effort_play);
    x->effort_play    = play;
    const double need = v + x->f - x->offset;
    if (reversed)
    {
        const double ratio = x->effort_travel / (fabs(need - x->last_need) + NEED_LEAST * L);
        x->harm += (fmin(ratio, HARM_MOST) - x->harm) / HARM_REVERSALS;
    }
    if (reversed || anew)
    {
        x->last_need     = need;
        x->effort_travel = 0.0;
    }
    if (x->harm > HARM || x->share < 1.0)
    {
        x->share = fmax(HARM_SHARE, x->share - (1.0 - HARM_SHARE) * H / FADE_TIME_S);
    }
}

double bank_tick(bank_t *x, const bank_options_t *options, double r, double y)
{
    double nodes[2];
    if (options->method == BANK_OFF)
    {
        const double v = output(x, r - y, nodes);
        return apply(x, r - y, nodes, v);
    }
    if (!x->running)
    {
        start(x, r, options->method == BANK_NO_SENSOR ? r : y);
    }
    // 1 to 3: rs, its rate, the stops, the sign.
    x->r_noise          = noise(x->r_noise, r, x->r);
    const double wanted = r - x->reached;
    const double moved  = x->limited != 0 && wanted * x->limited > 0.0 ? 0.0 : wanted;
    const bool   step   = fabs(moved) > STEP_N;
    const double was    = x->reached;
    const double widen  = NOISE_WIDTH * x->r_noise;
    const double half   = 0.5 * (options->width_n + widen);
    x->reached += moved;
    x->rate += ((step ? 0.0 : moved / H) - x->rate) * PART(RATE_TIME_S);
    const double stopped = within(x->stopped, x->reached - 0.5 * widen, x->reached + 0.5 * widen);
    for (int j = 0; j < BANK_STOPS; j++)
    {
        const double width = stop_width(options, j);
        x->stop[j]         = within(x->stop[j] + stopped - x->stopped, -width, width);
    }
    x->stopped             = stopped;
    const double play      = within(x->play, x->reached - half, x->reached + half);
    const int    last_sign = x->sign;
    x->sign                = play != x->play ? sign_of(play - x->play) : x->sign;
    x->play                = play;

    // 5: the error against the reference model, two low passes kept as distances from rs.
    const double ahead = (1.0 / ACTUATOR + ARM_LAG) * x->rate * options->width_n / (options->width_n + widen);
    const double lin   = x->reached + ahead + bias(x);
    double       e     = was - y + x->behind_sensor;
    x->behind_actuator -= moved;
    x->behind_sensor -= moved;
    x->behind_actuator += PART(1.0 / ACTUATOR + ARM_LAG) * (ahead - x->behind_actuator);
    x->behind_sensor += (1.0 - exp(-SENSOR * H)) * (x->behind_actuator - x->behind_sensor);

    // 4, 6 and 10: friction and its lead.
    const bool   holds  = options->method != BANK_NO_SENSOR && stands(x, options, half, step);
    const bool   leaves = x->holds && !holds;
    const bool   flips  = x->sign != last_sign;
    const bool   alone  = flips && (last_sign == 0 || (step && x->doubt > 0.5));
    double       lead   = 0.0;
    const double f      = holds ? hold(x, &e, y) : leaves ? leave(x, options, lin) : follow(x, options, alone, &lead);

    if (options->method == BANK_NO_SENSOR)
    {
        x->doubt = 0.0;
        x->f     = f;
        x->u     = within(lin + f + lead, -U_MAX, U_MAX);
        return x->u;
    }
    const double v = output(x, e, nodes);
    monitor(x, v, flips && !alone && !holds && !leaves, flips || holds || leaves);
    if (flips && !alone && !holds && !leaves)
    {
        x->offset = v;
    }
    if (leaves)
    {
        x->offset = v + lin + f - x->u;
    }
    x->offset = within(x->offset, -4.0 * U_MAX, 4.0 * U_MAX);
    x->f      = f;
    x->holds  = holds;
    x->u      = apply(x, e, nodes, v + lin + f + lead - x->offset);
    observe(x, options, y);
    return x->u;
}
