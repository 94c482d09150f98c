#include "rivals.h"

#include "tribo/controller_f32.h"
#include "tribo/paper_controller.h"

#include <math.h>
#include <stddef.h>

// The paper's rig: sample time, poles of actuator and sensor, b/K of the arm, limit of u.
#define H        1e-3
#define ACTUATOR 200.0
#define SENSOR   55.0
#define ARM      133.3
#define TAU      (1.0 / ACTUATOR + 1.0 / ARM)
#define U_MAX    2.0
#define RAMP_S   0.026 // of a jump

const char *const rival_names[RIVALS] =
    {"K x gain", "tanh", "disturbance observer", "LADRC", "reinforcement", "mirror", "small"};

static double clamp(double x, double low, double high)
{
    return fmin(fmax(x, low), high);
}

/// Part of the way to its input that a low pass with time constant `T` goes in a tick.
static double part(double T)
{
    return H / (T + H);
}

static double pole(double p)
{
    return 1.0 - exp(-p * H);
}

static double L_at(const rival_t *x, double force)
{
    return x->config.offset_n + x->config.slope * fabs(force);
}

/// The paper's controller, in the delta operator.
static double control(rival_t *x, double e)
{
    double v = x->config.gain * e;
    for (size_t i = 0; i < TRIBO_PAPER_CONTROLLER_SECTION_COUNT; i++)
    {
        const tribo_biquad_f32_section_t *const k = &tribo_paper_controller_f32[i];
        rival_section_t *const                  s = &x->section[i];
        const double                            w = v - (double)k->a1 * s->w1 - (double)k->a2 * s->w2;
        v                                         = (double)k->b0 * w + (double)k->b1 * s->w1 + (double)k->b2 * s->w2;
        s->w2 += s->w1;
        s->w1 += w;
    }
    return v;
}

/// Where F should be, and the error from there.
static double path_error(rival_t *x, double r, double y, double rate_s, double step_rate)
{
    const double rate = (r - x->r) / H;
    x->rate += part(rate_s) * ((fabs(rate) > step_rate ? 0.0 : rate) - x->rate);
    x->lin = r + TAU * x->rate;
    x->m1 += part(TAU) * (x->lin - x->m1);
    x->m2 += pole(SENSOR) * (x->m1 - x->m2);
    return x->m2 - y;
}

/// Moves `place` with `input`; true where the sign of its moves changes.
static bool play(rival_t *x, double input, double half)
{
    const double place = clamp(x->place, input - half, input + half);
    const double sign  = place > x->place ? 1.0 : place < x->place ? -1.0 : x->sign;
    const bool   flips = sign != x->sign;
    x->place           = place;
    x->sign            = sign;
    return flips;
}

static double ramp(double from, double to, double height)
{
    const double most = fabs(height) * H / RAMP_S;
    return from + clamp(to - from, -most, most);
}

static double tanh_term(rival_t *x, double r)
{
    return 0.85 * L_at(x, r) * tanh(x->rate / 4e-3);
}

static double observer_term(rival_t *x, double r, double y)
{
    x->u1 += pole(ACTUATOR) * (x->u - x->u1);
    x->u2 += pole(ARM) * (x->u1 - x->u2);
    x->u3 += pole(SENSOR) * (x->u2 - x->u3);
    x->d += part(0.025) * (x->u3 - y - x->d);
    return clamp(0.5 * x->d, -1.2 * L_at(x, r), 1.2 * L_at(x, r));
}

static double ladrc(rival_t *x, double r, double y)
{
    static const double b0 = 32.6, wc = 20.0, wo = 80.0;
    const double        z  = exp(-wo * H);
    const double        p1 = x->x1 + H * x->x2 + H * b0 * x->u;
    const double        q  = y - p1;
    x->x1                  = p1 + (1.0 - z * z) * q;
    x->x2 += (1.0 - z) * (1.0 - z) / H * q;
    return (wc * (r - x->x1) - x->x2) / b0;
}

static double reinforcement_term(rival_t *x, double r, double v)
{
    (void)play(x, v, 1e-3 + 3.0 * x->config.sigma_n);
    x->ramp = ramp(x->ramp, x->sign, 2.0);
    return 0.9 * L_at(x, r) * x->ramp;
}

/// What the controller holds beside the load at a reversal is friction in the old direction.
static double mirror_term(rival_t *x, double r)
{
    const double s = x->sign;
    x->held += part(0.02) * (x->u - x->lin - x->held);
    if (play(x, r, 0.25e-3))
    {
        const double L = L_at(x, r);
        if (x->flips > 1)
        {
            const double V = s * (x->held - x->previous) / (L + x->previous_L);
            x->load += 0.3 * (x->held - s * V * L - x->load);
        }
        const double most    = 2.6 * L;
        const double part_of = x->flips == 0 ? 0.5 : 1.0;
        x->turned += part_of * clamp(-2.0 * 0.95 * (x->held - x->load), -most, most);
        x->previous   = x->held;
        x->previous_L = L;
        x->flips++;
    }
    x->ramp = ramp(x->ramp, x->turned, 2.0 * L_at(x, r));
    return x->ramp;
}

// --- the small feed-forward -----------------------------------------------------------------------------------------

#define RATE_S  (0.8 * TAU)
#define SLIDE_S (20.0 * TAU)
#define JUMP_S  (2.1 * TAU)
#define STILL_S 0.2
#define USUAL_N 0.5 // |F| around which the rig works

/// Means of two slides: what u needed upward and downward. Half their difference is friction.
static void learn_slide(rival_t *x)
{
    const int    was = x->sign > 0.0 ? 0 : 1; // the direction that ends; s is the new one's sign
    const double p   = -x->sign;
    if ((double)x->n * H > SLIDE_S)
    {
        x->mean_g[was] = x->sum_g / (double)x->n;
        x->mean_L[was] = x->sum_L / (double)x->n;
        x->known[was]  = true;
        x->G += 0.5 * (x->sum_z / x->sum_L - x->G);
        double A = p * x->mean_g[was] / x->mean_L[was]; // this one alone: all of it is friction
        if (x->known[0] && x->known[1])
        {
            A = x->A + 0.5 * ((x->mean_g[1] - x->mean_g[0]) / (x->mean_L[0] + x->mean_L[1]) - x->A);
            if (!x->is_back)
            {
                x->c += 0.5 * (x->c0 - x->c);
            }
        }
        A        = clamp(A, 0.02, 3.0);
        x->c0    = x->c - (A - x->A) * p * L_at(x, x->m1);
        x->c     = x->c0;
        x->A     = A;
        x->lag   = 0.0;
        x->looks = x->known[0] && x->known[1] && !x->is_back;
    }
    x->n     = 0;
    x->sum_g = x->sum_L = x->sum_z = 0.0;
}

/// One number for all presliding: the error over the way behind a reversal.
static void learn_presliding(rival_t *x, double e, double way, double w)
{
    const double W = 0.5 * (x->d_small + 3.0 * w);
    if (x->looks && way > W)
    {
        x->d_small = clamp(x->d_small + 3.0 * x->lag / W, 0.0, 3.0 * (x->d_small + w));
        x->looks   = false;
    }
    if (x->looks)
    {
        const double a = -x->sign * e - 0.5 * w;
        x->lag += (a < 0.0 ? 3.0 * a : a) * fabs(x->rate) * H;
    }
}

static double small_step(rival_t *x, double r, double y)
{
    const double usual    = L_at(x, USUAL_N);
    const double w        = usual / 314.0;
    const bool   first    = x->sign == 0.0;
    const double e        = path_error(x, r, y, RATE_S, usual / 0.0785);
    const double F        = x->m1;
    const double L        = L_at(x, F);
    const double place    = x->place;
    const bool   flips    = play(x, F, 0.5 * w);
    const bool   was_back = x->is_back;
    x->still_s            = x->place == place ? x->still_s + H : 0.0;
    const bool stands     = x->still_s >= STILL_S;
    if (flips && !first)
    {
        learn_slide(x);
    }
    x->is_back     = stands || x->A < 0.6 * x->G;
    const double v = control(x, e);
    x->yf += part(RATE_S) * (y - x->yf);
    double lead = 0.0;
    if (flips)
    {
        x->F0 = F - x->sign * w;
    }
    if (x->is_back)
    {
        const double most = fmin(1.0, x->G) * L;
        const double f    = 0.9 * clamp(x->u - x->yf, -most, most);
        if (!was_back)
        {
            x->o += x->f - f;
        }
        x->f = f;
    }
    else
    {
        if (flips || was_back)
        {
            const double g = v + x->f + x->o;
            x->sigma       = first ? x->sign : clamp((g - x->c) / (x->A * L), -1.0, 1.0);
            x->sigma0      = x->sigma;
            x->o           = first ? g - x->sigma * x->A * L - v : x->c - v;
            x->F0          = F - x->sign * w;
        }
        const double gone  = fabs(F - x->F0);
        const double D     = 0.5 * x->d_small * fabs(x->sign - x->sigma0);
        const double left  = gone < D ? 1.0 - gone / D : 0.0;
        const double goal  = x->sign - (x->sign - x->sigma0) * left * left * left;
        const double sigma = x->sigma + clamp(goal - x->sigma, -2.0 * H / JUMP_S, 2.0 * H / JUMP_S);
        lead               = 0.7 / (ACTUATOR * H) * x->A * L * (sigma - x->sigma);
        x->sigma           = sigma;
        x->f               = sigma * x->A * L;
        x->o -= x->o * H / (200.0 * SLIDE_S);
    }
    const double gone = fabs(F - x->F0);
    learn_presliding(x, e, gone, w);
    if (!stands && !flips && (x->is_back || fabs(x->sigma - x->sign) < 0.01) && gone > x->d_small + w)
    {
        x->n++;
        x->sum_g += v + x->f + x->o;
        x->sum_L += L;
        x->sum_z += fabs(x->z);
        x->c += x->is_back ? 0.0 : part(SLIDE_S) * (v + x->o - x->c);
    }
    const double u = clamp(v + x->lin + x->f + x->o + lead, -U_MAX, U_MAX);
    x->u1 += pole(ACTUATOR) * (u - x->u1);
    x->u2 += pole(SENSOR) * (x->u1 - x->u2);
    x->z += part(RATE_S) * (x->u2 - y - x->z);
    return u;
}

void rival_open(rival_t *rival, rival_law_t law, const rival_config_t *config)
{
    *rival         = (rival_t){.law = law, .config = *config, .A = 0.5, .G = 0.5};
    rival->d_small = 3.0 * L_at(rival, USUAL_N) / 314.0;
}

static double term_of(rival_t *x, double r, double y)
{
    switch (x->law)
    {
    case RIVAL_TANH:
        return tanh_term(x, r);
    case RIVAL_OBSERVER:
        return observer_term(x, r, y);
    default:
        return mirror_term(x, r);
    }
}

double rival_step(rival_t *rival, double r, double y)
{
    double u = 0.0;
    if (!rival->has_run)
    {
        rival->r  = r;
        rival->m1 = rival->m2 = rival->x1 = rival->place = rival->yf = rival->u1 = rival->u2 = rival->u3 = y;
        rival->u                                                                                         = y;
        rival->has_run                                                                                   = true;
    }
    switch (rival->law)
    {
    case RIVAL_GAIN:
        u = control(rival, r - y);
        break;
    case RIVAL_LADRC:
        u = ladrc(rival, r, y);
        break;
    case RIVAL_REINFORCEMENT:
        u = control(rival, r - y);
        u += reinforcement_term(rival, r, u);
        break;
    case RIVAL_SMALL:
        u = small_step(rival, r, y);
        break;
    default:
        u = control(rival, path_error(rival, r, y, 0.01, (double)INFINITY));
        u += rival->lin + term_of(rival, r, y);
        break;
    }
    rival->r = r;
    rival->u = clamp(u, -U_MAX, U_MAX);
    return rival->u;
}
