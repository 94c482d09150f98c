// Joints of a stranger, for the judge of tribo-rig --joint: a mass with Coulomb, Stribeck, LuGre or Maxwell-slip friction that may grow with the
// load, gravity, viscous drag, an encoder, a current loop, and a position loop of its owner's. Nothing here is of the project.
//
//     joints SEED FOLDER [FAULT]    writes sine-log.csv and steps-log.csv, and the truth as JSON to stdout
//
// FAULT: sign, units (u in thousandths), still, oneway, none (no friction), hand, saturated, exchanged (u and q), coarse (encoder), jumps (steps without a ramp, so that u reaches its limit), late (a log without its second half).

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI       3.141592653589793
#define ELEMENTS 12

typedef enum
{
    COULOMB,
    STRIBECK,
    LUGRE,
    MAXWELL,
    LAWS
} law_t;

static const char *const law_names[] = {"coulomb", "stribeck", "lugre", "maxwell"};

typedef struct
{
    law_t  law;
    double h, inertia, friction, peak, knee, viscous, slope, gravity, bias, count, pole, presliding, noise, ku, u_max;
    double kp, ki, kd, stroke, period;
} joint_t;

typedef struct
{
    double q, v, actuator, bristle, element[ELEMENTS], integral, last, speed;
} state_t;

static uint64_t draws;

static double draw(void)
{
    draws += 0x9e3779b97f4a7c15ULL; // splitmix64
    uint64_t z = draws;
    z          = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z          = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return (double)((z ^ (z >> 31)) >> 11) / 9007199254740992.0;
}

static double between(double low, double high)
{
    return low + (high - low) * draw();
}

static double between_log(double low, double high)
{
    return low * pow(high / low, draw());
}

static double normal(void)
{
    return sqrt(-2.0 * log(1.0 - draw())) * cos(2.0 * PI * draw());
}

static joint_t joint_of(uint64_t seed)
{
    joint_t             j        = {0};
    static const double rates[4] = {250.0, 500.0, 1000.0, 2000.0};
    draws                        = seed * 7919u + 12345u;
    j.law                        = (law_t)(seed % LAWS);
    j.h                          = 1.0 / rates[(int)between(0.0, 3.999)];
    j.inertia                    = between_log(0.002, 2.0);
    j.friction                   = j.inertia * between_log(2.0, 40.0);
    j.stroke                     = between(0.5, 1.5); // rad, peak to peak
    j.period                     = between_log(3.0, 8.0);
    const double top             = PI * j.stroke / j.period;
    j.viscous                    = draw() < 0.3 ? 0.0 : between(0.05, 0.6) * j.friction / top;
    j.peak                       = j.law == STRIBECK || (j.law == LUGRE && draw() < 0.5) ? between(0.05, 0.5) : 0.0;
    j.knee                       = top * between_log(0.01, 0.1);
    j.gravity                    = draw() < 0.4 ? 0.0 : between(0.5, 4.0) * j.friction;
    j.bias                       = draw() < 0.5 ? 0.0 : between(-0.5, 0.5) * j.friction;
    j.slope                      = j.gravity > 0.0 && draw() < 0.6 ? between(0.03, 0.2) : 0.0;
    j.count                      = 2.0 * PI / between_log(4096.0, 65536.0);
    j.presliding                 = j.count * between_log(0.3, 6.0);
    j.pole                       = between_log(200.0, 2000.0);
    j.noise                      = j.friction * between(0.0, 0.03);
    j.ku                         = between_log(0.1, 1000.0); // effort of the log for a newton metre
    j.u_max                      = 4.0 * (j.friction * (2.0 + j.peak) + j.gravity + fabs(j.bias)) + 40.0 * j.inertia;
    const double w               = fmin(between_log(15.0, 60.0), 0.06 / j.h);
    j.kp                         = j.inertia * w * w;
    j.kd                         = j.inertia * 1.6 * w;
    j.ki                         = draw() < 0.4 ? 0.0 : j.kp * between(0.5, 3.0);
    return j;
}

static double level_of(const joint_t *j, double v, double load)
{
    return (j->friction + j->slope * fabs(load)) * (1.0 + j->peak * exp(-pow(v / j->knee, 2.0)));
}

/// Friction of the bristles at speed v, which it takes with it by dt; only for laws with presliding.
static double bristles(const joint_t *j, state_t *x, double v, double level, double dt)
{
    if (j->law == LUGRE)
    {
        const double stiff = level / j->presliding;
        const double rate  = fabs(v) * stiff / level;
        x->bristle         = (x->bristle + v * dt) / (1.0 + rate * dt);
        return stiff * x->bristle;
    }
    double force = 0.0;
    for (int i = 0; i < ELEMENTS; i++)
    {
        const double own  = level / ELEMENTS;
        const double soft = j->presliding * (0.3 + 1.4 * i / (ELEMENTS - 1.0));
        x->element[i]     = fmax(-soft, fmin(soft, x->element[i] + v * dt));
        force += own * x->element[i] / soft;
    }
    return force;
}

static void move(const joint_t *j, state_t *x, double u, double outer, double dt)
{
    x->actuator += (1.0 - exp(-j->pole * dt)) * (u - x->actuator);
    const double load  = j->gravity * sin(x->q) + j->bias;
    const double level = level_of(j, x->v, load);
    const double push  = x->actuator + outer - load - j->viscous * x->v;
    if (j->law == COULOMB || j->law == STRIBECK)
    {
        const double stop = push + j->inertia * x->v / dt;
        x->v              = fabs(stop) <= level ? 0.0 : (stop - copysign(level, stop)) * dt / j->inertia;
    }
    else
    {
        const double damp = 0.6 * sqrt(level / j->presliding * j->inertia) * (fabs(x->v) < 0.1 * j->knee ? 1.0 : 0.0);
        const double rub  = bristles(j, x, x->v, level, dt);
        x->v              = (x->v + (push - rub) * dt / j->inertia) / (1.0 + damp * dt / j->inertia);
    }
    x->q += x->v * dt;
}

static double asked(const joint_t *j, int is_steps, int is_jump, double t)
{
    if (!is_steps)
    {
        const double slow = t < 6.0 * j->period ? 1.0 : 2.0; // the second part at half the speed
        return 0.5 * j->stroke * (1.0 - cos(2.0 * PI * t / (slow * j->period)));
    }
    static const double levels[] = {0.0, 0.5, 1.0, 0.6, 0.9, 0.3, 0.7, 0.1, 0.4, 0.0};
    const double        each     = fmax(1.2, 0.5 * j->period);
    const int           at       = (int)(t / each);
    const double        s        = is_jump ? 1.0 : fmin(1.0, (t - at * each) / (0.4 * each));
    const double        from     = levels[at % 10];
    const double        to       = levels[(at + 1) % 10];
    return j->stroke * (from + (to - from) * s * s * (3.0 - 2.0 * s));
}

static double owner(const joint_t *j, state_t *x, double wanted, double q)
{
    const double off  = wanted - q;
    const double part = fmin(1.0, 120.0 * j->h);
    x->speed += part * ((off - x->last) / j->h - x->speed);
    x->last = off;
    x->integral += j->ki * off * j->h;
    return j->kp * off + j->kd * x->speed + x->integral;
}

static void play(const joint_t *j, int is_steps, const char *path, const char *fault)
{
    FILE *const file = fopen(path, "w");
    if (file == NULL)
    {
        exit(2);
    }
    fputs("t_s,effort,position\n", file);
    state_t      x        = {0};
    const double last     = is_steps ? 20.0 * fmax(1.2, 0.5 * j->period) : 14.0 * j->period;
    const long   ticks    = (long)(last / j->h);
    const int    parts    = (int)ceil(j->h / 2e-5);
    const double count    = strcmp(fault, "coarse") == 0 ? j->stroke / 20.0 : j->count;
    const int    is_milli = strcmp(fault, "units") == 0;
    const int    is_sign  = strcmp(fault, "sign") == 0;
    for (long k = 0; k < ticks; k++)
    {
        const double t      = k * j->h;
        double       wanted = strcmp(fault, "still") == 0 ? 0.0 : asked(j, is_steps, strcmp(fault, "jumps") == 0, t);
        if (strcmp(fault, "oneway") == 0)
        {
            wanted = 0.2 * t;
        }
        const double q = floor(x.q / count) * count;
        double       u = owner(j, &x, wanted, q);
        u              = fmax(-j->u_max, fmin(j->u_max, u));
        const double hand =
            strcmp(fault, "hand") == 0 ? 1.5 * j->friction * sin(1.7 * t) * (fmod(t, 5.0) < 2.5 ? 1.0 : 0.2) : 0.0;
        const double said = j->ku * (u + j->noise * normal()) * (is_sign ? -1.0 : is_milli ? 1000.0 : 1.0);
        if (strcmp(fault, "late") != 0 || t < 0.1 * last)
        {
            if (strcmp(fault, "exchanged") == 0)
            {
                fprintf(file, "%.6f,%.9g,%.9g\n", t, q, said);
            }
            else
            {
                fprintf(file, "%.6f,%.9g,%.9g\n", t, said, q);
            }
        }
        for (int i = 0; i < parts; i++)
        {
            move(j, &x, u, hand, j->h / parts);
        }
    }
    fclose(file);
}

int main(int count, char **words)
{
    if (count < 3)
    {
        return 2;
    }
    const char *fault = count > 3 ? words[3] : "";
    joint_t     j     = joint_of(strtoull(words[1], NULL, 10));
    if (strcmp(fault, "none") == 0)
    {
        j.friction = 1e-6 * j.inertia;
        j.slope    = 0.0;
        j.law      = COULOMB;
    }
    if (strcmp(fault, "saturated") == 0)
    {
        j.u_max = 1.1 * (j.friction + j.gravity);
    }
    char path[4096];
    for (int is_steps = 0; is_steps < 2; is_steps++)
    {
        (void)snprintf(path, sizeof path, "%s/%s-log.csv", words[2], is_steps ? "steps" : "sine");
        play(&j, is_steps, path, fault);
    }
    printf("{\"law\": \"%s\", \"sample_time_s\": %.9g, \"friction\": %.9g, \"peak\": %.9g, \"knee\": %.9g, "
           "\"viscous\": %.9g, \"slope\": %.9g, \"gravity\": %.9g, "
           "\"bias\": %.9g, \"count\": %.9g, \"u_max\": %.9g, \"ki\": %.9g, \"top\": %.9g, \"presliding\": %.9g, "
           "\"noise\": %.9g}\n",
           law_names[j.law],
           j.h,
           j.ku * j.friction,
           j.peak,
           j.knee,
           j.ku * j.viscous,
           j.slope,
           j.ku * j.gravity,
           j.ku * j.bias,
           j.count,
           j.ku * j.u_max,
           j.ki / j.kp,
           PI * j.stroke / j.period,
           j.presliding,
           j.ku * j.noise);
    return 0;
}
