// A rig as a lab would have it, for judging tribo-rig and tribo-identify. It shares no line with the project or with its other simulators.
//
// Time stepping after Moreau: each step first takes the velocity that the arm would have, then the impulse of dry friction that
// stops it or as much as there is. Forces are in N, the arm's position x in N of its contact's spring.
//
//     m dv/dt = ua + ripple(x) - damping v - F - dry friction,   dx/dt = v,   F = what the contact makes of x
//
// F lags behind x by the play of a gear or a joint: it stays while x crosses the play. Dry friction is, by `law`,
//   0 Coulomb's,  1 Stribeck's: falls with speed,  2 of elements that stick and slip one after the other (Maxwell),
//   3 the same where breakaway falls with the way since the turn,  4 a bristle (Dahl's equation with a peak by speed, as LuGre).

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#define ELEMENTS 10
#define LATE_MAX 256

typedef struct
{
    double tick_s;
    double scale, bias, late_ticks;  // of the command
    double actuator_s, sensor_s;     // time constants; 0: none
    double mass, damping;            // s^2 and s, as the spring is 1
    double offset, slope, downwards; // dry friction at F, and of the way down over that up
    double law, falls_to, fall_at;   // share that is left of it; speed in N/s, or travel in N, at which it has fallen
    double travel;                   // N of x until all of friction has built up
    double play, ripple, ripple_every, ripple_at;
    double noise, step, drift_per_s; // of the sensor
    double warms_per_s;              // of friction: share by which it grows a second
    double seed;
} lab_config_t;

typedef struct
{
    lab_config_t c;
    int          substeps;
    double       dt, time;
    double       ua, x, v, contact, sensor;
    double       element[ELEMENTS], bristle, gone, way;
    double       late[LATE_MAX];
    int          at;
    uint64_t     random;
    double       most; // largest |F| so far
} lab_t;

static double uniform(lab_t *lab)
{
    // Weyl sequence through a mixer
    uint64_t z = (lab->random += 0x9e3779b97f4a7c15u);
    z          = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z          = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return ((double)((z ^ (z >> 31)) >> 11) + 0.5) / 9007199254740992.0;
}

lab_t *lab_open(const lab_config_t *config, double step_s)
{
    lab_t *const lab = calloc(1, sizeof *lab);
    lab->c           = *config;
    lab->substeps    = (int)ceil(config->tick_s / step_s - 1e-6);
    lab->dt          = config->tick_s / lab->substeps;
    lab->random      = (uint64_t)config->seed * 7919u + 17u;
    return lab;
}

void lab_close(lab_t *lab)
{
    free(lab);
}

/// Breakaway in the direction of `way`.
static double level(const lab_t *lab, double way)
{
    const double L = (lab->c.offset + lab->c.slope * fabs(lab->contact)) * (1.0 + lab->c.warms_per_s * lab->time);
    return way < 0.0 ? lab->c.downwards * L : L;
}

static double left_at(const lab_t *lab, double how_far)
{
    return lab->c.falls_to + (1.0 - lab->c.falls_to) * exp(-how_far / lab->c.fall_at);
}

/// Velocity after the step, from that without dry friction, of an arm that a force moves by `ease`.
static double stuck_or_sliding(const lab_t *lab, double free_v, double ease)
{
    const double peak = lab->c.law == 1.0 ? left_at(lab, fabs(lab->v)) : 1.0;
    const double most = ease * level(lab, free_v) * peak;
    return fabs(free_v) <= most ? 0.0 : free_v - copysign(most, free_v);
}

/// Dry friction that builds up with travel, at the end of the step if the arm goes on at `v`.
static double builds_up(lab_t *lab, double v)
{
    const double dx = v * lab->dt;
    if (v * lab->way < 0.0)
    {
        lab->gone = 0.0;
    }
    lab->way = v != 0.0 ? v : lab->way;
    lab->gone += fabs(dx);
    double L = level(lab, v);
    if (lab->c.law == 4.0)
    {
        L *= left_at(lab, fabs(v));
        const double stiff = 3.0 * level(lab, v) / lab->c.travel;
        lab->bristle += dx * stiff * (1.0 - copysign(1.0, v) * lab->bristle / L);
        lab->bristle = fmax(-1.3 * L, fmin(1.3 * L, lab->bristle));
        return lab->bristle +
               2.0 * lab->c.mass * sqrt(stiff / lab->c.mass) * v * exp(-fabs(v) / (lab->c.travel * 20.0));
    }
    L *= lab->c.law == 3.0 ? left_at(lab, lab->gone) : 1.0;
    double sum = 0.0;
    for (int i = 0; i < ELEMENTS; i++)
    {
        const double most = L / ELEMENTS, slips_after = lab->c.travel * (i + 1) / ELEMENTS;
        lab->element[i] = fmax(-most, fmin(most, lab->element[i] + dx * most / slips_after));
        sum += lab->element[i];
    }
    return sum + 0.6 * sqrt(lab->c.mass * level(lab, v) / lab->c.travel) * v * exp(-fabs(v) / (lab->c.travel * 20.0));
}

static void substep(lab_t *lab, double command)
{
    const lab_config_t *const c  = &lab->c;
    const double              dt = lab->dt;
    lab->ua += c->actuator_s > 0.0 ? (command - lab->ua) * -expm1(-dt / c->actuator_s) : command - lab->ua;
    double       push = lab->ua - lab->contact;
    const double turn = 6.283185307179586;
    push += c->ripple > 0.0 ? c->ripple * sin(turn * (lab->x / c->ripple_every + c->ripple_at)) : 0.0;
    // Damping and, without play, the spring at the end of the step.
    const double ease = dt / (c->mass + dt * c->damping + (c->play > 0.0 ? 0.0 : dt * dt));
    if (c->law < 2.0)
    {
        lab->v = stuck_or_sliding(lab, (c->mass * lab->v + dt * push) * ease / dt, ease);
    }
    else
    {
        lab->v = (c->mass * lab->v + dt * (push - builds_up(lab, lab->v))) * ease / dt;
    }
    lab->x += dt * lab->v;
    lab->contact = fmax(lab->x - c->play / 2.0, fmin(lab->x + c->play / 2.0, lab->contact));
    lab->sensor +=
        c->sensor_s > 0.0 ? (lab->contact - lab->sensor) * -expm1(-dt / c->sensor_s) : lab->contact - lab->sensor;
    lab->most = fmax(lab->most, fabs(lab->contact));
    lab->time += dt;
}

double lab_read(lab_t *lab)
{
    const double gauss = sqrt(-2.0 * log(uniform(lab))) * cos(6.283185307179586 * uniform(lab));
    const double y     = lab->sensor + lab->c.drift_per_s * lab->time + lab->c.noise * gauss;
    return lab->c.step > 0.0 ? floor(y / lab->c.step + 0.5) * lab->c.step : y;
}

void lab_tick(lab_t *lab, double command)
{
    lab->late[(lab->at + (int)lab->c.late_ticks) % LATE_MAX] = lab->c.scale * command + lab->c.bias;
    for (int i = 0; i < lab->substeps; i++)
    {
        substep(lab, lab->late[lab->at % LATE_MAX]);
    }
    lab->at++;
}

/// A reading before each of `n` commands.
void lab_play(lab_t *lab, const double *u, int n, double *y)
{
    for (int k = 0; k < n; k++)
    {
        y[k] = lab_read(lab);
        lab_tick(lab, u[k]);
    }
}

double lab_most(const lab_t *lab)
{
    return lab->most;
}
