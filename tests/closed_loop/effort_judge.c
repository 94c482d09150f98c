// Judges what the feed-forward without a force sensor learns from the effort of a position loop. Axes, frictions, loops and moves are
// its own. Prints a table:
//
//     effort_judge_f32 FIRST LAST [errors]    seeds; exit status 1 if what is learned is off by more than a tenth
//
// "learned" is V L over the friction of the slides, the dissipated energy over the way. "error" is the RMS of the position error
// without friction fed forward, over that with it, as believed and as learned.

#include "../support/init_parts.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SUBSTEPS 20
#define TWO_PI   6.283185307179586

typedef struct
{
    const char *name;
    double      h_s, mass, friction, u_max, actuator_pole; // in N, kg, m or N m, kg m^2, rad
    double      count, width, stroke, period_s;            // of the encoder; a reversal; of a move, and there and back
    double      bandwidth;                                 // of the velocity loop, rad/s
} axis_t;

#define AXES 3
static const axis_t axes[AXES] = {
    {"2 kg, 100 N, 2 kHz", 5e-4, 2.0, 9.0, 100.0, 1200.0, 1e-6, 1e-4, 0.06, 1.6, 250.0},
    {"60 g, 2 N, 1 kHz", 1e-3, 0.06, 0.15, 2.0, 500.0, 5e-6, 5e-5, 0.012, 2.0, 90.0},
    {"3e-4 kg m2, 5 kHz", 2e-4, 3e-4, 0.05, 1.2, 2500.0, TWO_PI / 16384, 4e-3, 3.0, 0.9, 500.0},
};

typedef enum
{
    COULOMB, // breakaway is sliding friction, and a viscous part
    STRIBECK,
    LUGRE,
    LAWS
} law_t;

typedef enum
{
    STROKES, // at a steady speed, with rests
    SINE,
    WALK,  // between random points, with rests
    SHORT, // strokes of 40 widths
    LOADS, // strokes, with a load that changes in mid-stroke every five moves
    MOVES
} move_t;

static const char *const law_names[LAWS]   = {"coulomb", "stribeck", "lugre"};
static const char *const move_names[MOVES] = {"strokes", "sine", "walk", "short", "loads"};

typedef enum
{
    NONE,
    BELIEVED,
    LEARNED
} method_t;

typedef struct
{
    const axis_t *axis;
    law_t         law;
    move_t        move;
    double        believed;                                // over the truth
    double        load, viscous, peak, pole, stiff, speed; // relative, of this seed
    int           is_pid;
    uint64_t      seed;
} case_t;

/// Uniform over -1 to 1, after PCG (O'Neill, 2014).
static double draw(uint64_t *seed)
{
    *seed              = *seed * 6364136223846793005ULL + 1442695040888963407ULL;
    const uint32_t x   = (uint32_t)(((*seed >> 18) ^ *seed) >> 27);
    const uint32_t rot = (uint32_t)(*seed >> 59);
    return (double)((x >> rot) | (x << ((32u - rot) & 31u))) / 2147483648.0 - 1.0;
}

// --- the axis ------------------------------------------------------------------------------------------------------

typedef struct
{
    double actuator, position, speed, bristle;
    double friction, dissipated, way;
} plant_t;

static double level_of(const case_t *c, double speed)
{
    const double knee = 0.02 * TWO_PI * c->axis->stroke / c->axis->period_s;
    const double peak = c->law == COULOMB ? 0.0 : c->peak * exp(-(speed / knee) * (speed / knee));
    return c->axis->friction * (1.0 + peak);
}

static double load_at(const case_t *c, double t)
{
    const long part = (long)floor(t * c->speed / (2.5 * c->axis->period_s) + 0.3);
    return c->axis->friction * (c->move == LOADS && part % 2 != 0 ? c->load - 1.0 : c->load);
}

static void plant_step(plant_t *x, const case_t *c, double u, double load, double dt)
{
    const axis_t *a       = c->axis;
    const double  viscous = c->viscous * a->friction / (TWO_PI * a->stroke / a->period_s);
    const double  level   = level_of(c, x->speed);
    x->actuator += (1.0 - exp(-a->actuator_pole * c->pole * dt)) * (u - x->actuator);
    const double push = a->mass / dt * x->speed + x->actuator - load;
    const double body = a->mass / dt + viscous;
    if (c->law == LUGRE)
    {
        const double stiffness = a->friction / (c->stiff * a->width);
        const double damper    = sqrt(stiffness * a->mass) / dt;
        const double kept      = 1.0 / (1.0 + dt * fabs(x->speed) * stiffness / level);
        const double both      = (stiffness + damper) * kept;
        const double speed     = (push - both * x->bristle + damper * x->bristle) / (body + both * dt);
        x->friction            = (stiffness + damper) * kept * (x->bristle + dt * speed) - damper * x->bristle;
        x->bristle             = kept * (x->bristle + dt * speed);
        x->speed               = speed;
    }
    else
    {
        x->friction = fmax(-level, fmin(level, push));
        x->speed    = (push - x->friction) / body;
    }
    x->position += dt * x->speed;
    x->dissipated += (x->friction + viscous * x->speed) * x->speed * dt;
    x->way += fabs(x->speed) * dt;
}

// --- where it shall be, and the loop that brings it there ---------------------------------------------------------------

typedef struct
{
    double position, speed;
} point_t;

static double corner(const case_t *c, long i)
{
    uint64_t seed = c->seed * 77u + (uint64_t)(i + 5) * 0x9e3779b97f4a7c15u;
    (void)draw(&seed);
    (void)draw(&seed);
    return 0.5 * c->axis->stroke * draw(&seed);
}

/// From a to b in the first part of `phase`, 0 to 1: a ramp with round ends of 0.15 (cosine) where `steady`, else a cosine.
static double blend(double phase, double moving, int steady)
{
    const double s = fmin(1.0, phase / moving);
    const double r = 0.15;
    if (steady == 0)
    {
        return 0.5 - 0.5 * cos(0.5 * TWO_PI * s);
    }
    const double v = 1.0 / (1.0 - r);
    return s < r         ? v * s * s / (2.0 * r)
           : s > 1.0 - r ? 1.0 - v * (1.0 - s) * (1.0 - s) / (2.0 * r)
                         : v * (s - 0.5 * r);
}

static double wanted(const case_t *c, double t)
{
    const double half   = 0.5 * c->axis->period_s / c->speed;
    const long   i      = (long)floor(t / half);
    const double phase  = t / half - (double)i;
    const double stroke = c->move == SHORT ? 40.0 * c->axis->width : c->axis->stroke;
    const double from   = c->move == WALK ? corner(c, i) : (i % 2 == 0 ? -0.5 : 0.5) * stroke;
    const double to     = c->move == WALK ? corner(c, i + 1) : -from;
    return from + (to - from) * blend(phase, c->move == SINE ? 1.0 : 0.75, c->move != SINE && c->move != WALK);
}

typedef struct
{
    double integral, speed, last, error;
} servo_t;

/// The effort of a P-PI cascade or of a PID with a filtered derivative.
static double servo(servo_t *x, const case_t *c, point_t at, double seen)
{
    const axis_t *a    = c->axis;
    const double  w    = a->bandwidth;
    const double  part = 1.0 - exp(-4.0 * w * a->h_s);
    x->speed += part * ((seen - x->last) / a->h_s - x->speed);
    x->last            = seen;
    const double error = at.position - seen;
    const double kv    = a->mass * w;
    const double p =
        c->is_pid ? kv * (0.3 * w * error + at.speed - x->speed) : kv * (at.speed + 0.25 * w * error - x->speed);
    const double i   = c->is_pid ? kv * 0.04 * w * w * error : kv * 0.25 * w * (at.speed + 0.25 * w * error - x->speed);
    const double sum = p + x->integral + i * a->h_s;
    if (fabs(sum) < a->u_max || sum * i < 0.0)
    {
        x->integral += i * a->h_s;
    }
    return fmax(-a->u_max, fmin(a->u_max, sum));
}

// --- the library ------------------------------------------------------------------------------------------------------

typedef struct
{
    double full_scale;
    TRIBO(force_loop, params_t) params;
    TRIBO(feedforward, params_t) own;
    TRIBO(feedforward, memory_t) memory;
    TRIBO(force_loop, state_t) state;
    tribo_point_t table[TRIBO_BREAKAWAY_POINTS_MAX];
} loop_t;

static void open_loop(loop_t *x, const case_t *c)
{
    static const tribo_biquad_f32_section_t beside[] = {TRIBO_BIQUAD_F32(1.0, -0.9, 0.0, -0.95, 0.0)}; // not run
    const axis_t                           *a        = c->axis;
    memset(x, 0, sizeof *x);
    x->full_scale                                  = 2.0 * a->u_max;
    tribo_force_loop_f32_config_t  config          = tribo_force_loop_f32_paper();
    tribo_feedforward_f32_config_t method          = tribo_feedforward_f32_default();
    const tribo_breakaway_f32_t    breakaway       = {.offset_n = (float)(c->believed * a->friction)};
    config.sample_time_s                           = (float)a->h_s;
    config.controller.sections                     = beside;
    config.controller.section_count                = 1;
    config.input_max_n                             = (float)a->u_max;
    config.usual_force_n                           = 0.25f * (float)a->u_max;
    config.controller.u_min_n                      = (float)-a->u_max;
    config.controller.u_max_n                      = (float)a->u_max;
    config.compensator.arm.damping                 = (float)(2.0 * a->h_s);
    config.compensator.arm.inertia                 = (float)(a->h_s * a->h_s);
    config.compensator.arm.stiffness               = 1.0f;
    config.compensator.friction.positive           = breakaway;
    config.compensator.friction.negative           = breakaway;
    config.compensator.friction.v0_n_per_s         = (float)(0.05 * a->friction);
    method.actuator_pole_rad_per_s                 = (float)a->actuator_pole;
    const tribo_sensorless_f32_config_t sensorless = tribo_sensorless_f32_default();
    const tribo_status_t                status =
        tribo_init_sensorless(&x->params, x->table, &x->own, &config, &method, &sensorless, (float)x->full_scale);
    if (status != TRIBO_OK)
    {
        (void)fprintf(stderr, "%s: refused, %s\n", a->name, tribo_status_text(status));
        exit(2);
    }
    x->state.memory = &x->memory.state.tick;
    (void)TRIBO(force_loop, start)(&x->state, &x->params, false); // its memory is there
}

static double loop_step(loop_t *x, double effort, double intended, double measured)
{
    TRIBO(sensorless,
          motion)(&x->memory,
                  TRIBO_EITHER((float)intended, (int32_t)(fmax(-3.99, fmin(3.99, intended)) * 536870912.0)),
                  TRIBO_EITHER((float)measured, (int32_t)(fmax(-3.99, fmin(3.99, measured)) * 536870912.0)));
    const tribo_force_t r = tribo_force_of_n(effort, x->full_scale);
    return tribo_force_n(TRIBO(force_loop, step)(&x->params, &x->state, r, 0, NULL), x->full_scale);
}

static double loop_weight(const loop_t *x)
{
    return (double)x->memory.state.weights.sliding / TRIBO_EITHER(1.0, 536870912.0);
}

typedef struct
{
    double rms, learned;
} result_t;

/// 24 moves there and back; the last third counts.
static result_t run(const case_t *c, method_t method)
{
    static loop_t loop;
    const axis_t *a       = c->axis;
    const long    ticks   = lround(24.0 * a->period_s / c->speed / a->h_s);
    plant_t       plant   = {.position = wanted(c, 0.0)};
    servo_t       own     = {.last = plant.position};
    double        last[2] = {plant.position, plant.position};
    double        square  = 0.0;
    double        way = 0.0, dissipated = 0.0, weight = 0.0;
    long          count = 0;
    open_loop(&loop, c);
    for (long k = 0; k < ticks; k++)
    {
        const double  t     = (double)k * a->h_s;
        const point_t at    = {.position = wanted(c, t), .speed = (wanted(c, t + a->h_s) - wanted(c, t)) / a->h_s};
        const double  seen  = floor(plant.position / a->count) * a->count;
        const double  r     = servo(&own, c, at, seen);
        const double  moved = method == LEARNED ? (seen - last[1]) / a->width : 0.0;
        const double  u = method == NONE ? r : loop_step(&loop, r, 20.0 * (at.position - last[0]) / a->width, moved);
        last[0]         = at.position;
        last[1]         = seen;
        if (k == 2 * ticks / 3)
        {
            way        = plant.way;
            dissipated = plant.dissipated;
        }
        if (k > 2 * ticks / 3)
        {
            square += (at.position - plant.position) * (at.position - plant.position);
            weight += loop_weight(&loop);
            count++;
        }
        for (int i = 0; i < SUBSTEPS; i++)
        {
            plant_step(&plant, c, u, load_at(c, t), a->h_s / SUBSTEPS);
        }
    }
    const double truth = (plant.dissipated - dissipated) / (plant.way - way);
    return (result_t){.rms     = sqrt(square / (double)count),
                      .learned = weight / (double)count * c->believed * a->friction / truth};
}

static double judge(const case_t *c, bool errors)
{
    const result_t learned = run(c, LEARNED);
    if (errors || fabs(learned.learned - 1.0) > 0.1)
    {
        const double none     = run(c, NONE).rms;
        const double believed = run(c, BELIEVED).rms;
        printf("%-20s %-9s %-8s %s x%.1f: learned %.3f, error %.2f as believed, %.2f as learned\n",
               c->axis->name,
               law_names[c->law],
               move_names[c->move],
               c->is_pid ? "PID " : "P-PI",
               c->believed,
               learned.learned,
               none / believed,
               none / learned.rms);
    }
    return learned.learned;
}

int main(int argc, char **argv)
{
    static const double believed[] = {0.5, 0.7, 1.3, 2.0};
    const long          first      = argc > 2 ? strtol(argv[1], NULL, 10) : 1;
    const long          last       = argc > 2 ? strtol(argv[2], NULL, 10) : 1;
    long                count = 0, off = 0;
    double              least = 9.0, most = 0.0;
    for (long seed = first; seed <= last; seed++)
    {
        for (int i = 0; i < AXES * LAWS * MOVES * 4; i++)
        {
            uint64_t draws = (uint64_t)seed * 1000u + (uint64_t)i;
            (void)draw(&draws);
            (void)draw(&draws);
            const case_t c = {.axis     = &axes[i % AXES],
                              .law      = (law_t)(i / AXES % LAWS),
                              .move     = (move_t)(i / AXES / LAWS % MOVES),
                              .believed = 1.0 / believed[i / AXES / LAWS / MOVES],
                              .load     = 0.6 * draw(&draws),
                              .viscous  = 0.2 + 0.2 * draw(&draws),
                              .peak     = 0.3 + 0.2 * draw(&draws),
                              .pole     = exp(0.3 * draw(&draws)),
                              .stiff    = 0.3 + 0.2 * draw(&draws),
                              .speed    = exp(0.6 * draw(&draws)),
                              .is_pid   = draw(&draws) > 0.0,
                              .seed     = (uint64_t)seed};
            const double x = judge(&c, argc > 3);
            count++;
            off += !(fabs(x - 1.0) <= 0.1);
            least = fmin(least, x);
            most  = fmax(most, x);
        }
    }
    printf("%ld cases: learned %.3f to %.3f of the friction, %ld off by more than 0.1\n", count, least, most, off);
    return off == 0 ? 0 : 1;
}
