// Judges a joint's friction term on joints of its own: 60 g to 3 kg, gears, loads, viscous and Stribeck friction, presliding, 200 Hz to 8 kHz,
// beside P-PI, PID and PD loops. Nothing here is of the method.
//
//     joint_study_f32 errors FIRST LAST    position error without over with the term, last third of 12 moves there and back
//     joint_study_f32 runaway FIRST LAST [MOST]   friction a third, signs wrong, loads, hands: speed beyond the intended after 0.2 s
//     joint_study_f32 force FIRST LAST     the end-point force from current
//     joint_study_f32 quick FIRST LAST     a PD that swings at 1 to 16 Hz, by up to 12 times its friction: trips for nothing, and signs wrong
//
// An error counts at least one count of the encoder. Beside each joint's ratio stands that of the same joint with no friction in it, which bounds
// what a term can do. Seeds below 4000 were looked at while the method was made, those from 8001 to 8600 of quick; those from 7001 on, and from
// 9001, were not. Exit status 1 where a joint is below 0.9, the median of those where friction is to blame below 3.5, the guard steps in for nothing
// in more than one of ten (of the quick: at all, or more than one wrong sign of ten is unseen), more than MOST (0) events are runaways, or the
// force is outside its interval too often.

#include "tribo/joint_f32.h"
#include "tribo/joint_q31.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TWO_PI     6.283185307179586
#define JOINTS_MAX 2000

#ifdef TRIBO_ARITHMETIC_Q31
#define JOINT(name) tribo_joint_q31_##name
#else
#define JOINT(name) tribo_joint_f32_##name
#endif

typedef enum
{
    P_PI,
    PID,
    PD,
    NO_LOOP,
    LOOPS
} loop_kind_t;

typedef enum
{
    SINE,
    STROKES,
    WALK,
    STEPS,
    MOVES
} move_t;

static const char *const loop_names[LOOPS] = {"P-PI", "PID", "PD", "none"};
static const char *const move_names[MOVES] = {"sine", "strokes", "walk", "steps"};

typedef struct
{
    uint64_t seed;
    double   h, mass, friction, u_max, pole, pole_believed, count, stroke, half_period;
    double   viscous, peak, knee, bristle, mesh, load; // friction's, over `friction`; bristle: presliding in m, 0: none
    double   bandwidth, ahead; // ahead: the loop's mass for the acceleration of q_ref, over the truth; 0: none
    loop_kind_t loop;
    move_t      move;
    double      believed; // breakaway, over the truth; 0: none
} joint_case_t;

static uint64_t state_of_draw;

/// Uniform over 0 to 1: xorshift64* (Vigna, 2016).
static double draw(void)
{
    state_of_draw ^= state_of_draw >> 12;
    state_of_draw ^= state_of_draw << 25;
    state_of_draw ^= state_of_draw >> 27;
    return (double)((state_of_draw * 2685821657736338717ULL) >> 11) / 9007199254740992.0;
}

static double between(double low, double high)
{
    return low + (high - low) * draw();
}

static double between_log(double low, double high)
{
    return low * pow(high / low, draw());
}

static joint_case_t case_of(uint64_t seed)
{
    static const double rates[] = {200.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0};
    joint_case_t        c       = {.seed = seed};
    state_of_draw               = 0x9e3779b97f4a7c15ULL * (seed + 1u);
    for (int i = 0; i < 8; i++)
    {
        (void)draw();
    }
    c.h             = 1.0 / rates[(int)between(0.0, 5.999)];
    c.mass          = between_log(0.06, 3.0);
    c.friction      = c.mass * between_log(0.7, 6.0);
    c.u_max         = c.friction * between(5.0, 15.0);
    c.bandwidth     = fmin(between(0.05, 0.12) / c.h, between_log(60.0, 400.0));
    c.pole          = fmax(4.0 * c.bandwidth, between_log(200.0, 3000.0));
    c.pole_believed = c.pole * between(0.7, 1.4);
    const double w  = 0.3 * c.bandwidth * between_log(0.015, 0.1);
    c.half_period   = 0.5 * TWO_PI / w;
    c.stroke        = between_log(0.02, 0.2) * c.u_max / c.mass / (w * w);
    c.count         = c.stroke / between_log(4000.0, 100000.0);
    c.viscous       = draw() < 0.3 ? 0.0 : between(0.0, 0.4);
    c.peak          = draw() < 0.4 ? 0.0 : between(0.05, 0.5);
    c.knee          = c.stroke * w * between_log(0.005, 0.05);
    c.bristle       = draw() < 0.4 ? 0.0 : c.count * between_log(0.5, 8.0);
    c.mesh          = draw() < 0.5 ? 0.0 : between(0.0, 0.1);
    c.load          = draw() < 0.4 ? 0.0 : between(-0.6, 0.6);
    c.loop          = (loop_kind_t)(int)between(0.0, 2.999);
    c.move          = (move_t)(int)between(0.0, 3.999);
    c.ahead         = draw() < 0.25 ? 0.0 : between(0.8, 1.2);
    c.believed      = draw() < 0.3 ? 0.0 : between_log(0.5, 2.0);
    return c;
}

// --- the joint -------------------------------------------------------------------------------------------------------

typedef struct
{
    double actuator, position, speed, bristle, friction; // friction: last force
    double scale;                                        // of friction
} plant_t;

/// Semi-implicit, with friction that at most stops the joint in a substep; presliding by a bristle that slides.
static void plant_step(plant_t *x, const joint_case_t *c, double u, double outer, double dt)
{
    x->actuator += (1.0 - exp(-c->pole * dt)) * (u - x->actuator);
    const double rub =
        x->scale * c->friction * (1.0 + c->peak * exp(-fabs(x->speed) / c->knee)) + c->mesh * fabs(x->actuator);
    const double thick = c->viscous * c->friction / (c->stroke / c->half_period);
    const double push  = x->actuator + c->load * c->friction + outer;
    const double free  = (x->speed + push / c->mass * dt) / (1.0 + thick / c->mass * dt);
    if (c->bristle > 0.0)
    {
        const double stiff = rub / c->bristle;
        const double damp  = 0.4 * sqrt(stiff * c->mass);
        // Implicit in the speed: bristle force at the end of the substep.
        const double soft  = c->mass * (1.0 + thick / c->mass * dt) / dt;
        double       speed = (soft * free - stiff * x->bristle) / (soft + stiff * dt + damp);
        double       z     = x->bristle + speed * dt;
        x->friction        = stiff * z + damp * speed;
        if (fabs(z) > c->bristle)
        {
            z           = copysign(c->bristle, z);
            x->friction = copysign(rub, z);
            speed       = free - x->friction / soft;
        }
        x->bristle = z;
        x->speed   = speed;
    }
    else
    {
        const double hold = free * c->mass * (1.0 + thick / c->mass * dt) / dt;
        x->friction       = fmax(-rub, fmin(rub, hold));
        x->speed          = free - x->friction / hold * free;
        x->speed          = fabs(hold) <= rub ? 0.0 : x->speed;
    }
    x->position += x->speed * dt;
}

// --- reference and loop ---------------------------------------------------------------------------------------------------

static double corner(const joint_case_t *c, long i)
{
    const uint64_t mixed = (c->seed * 1000003u + (uint64_t)(i + 7)) * 0xd1342543de82ef95ULL;
    const double   x     = (double)(mixed >> 40) / 16777216.0;
    return c->move == WALK ? (x - 0.5) * c->stroke : (i % 2 == 0 ? -0.5 : 0.5) * c->stroke;
}

static double wanted(const joint_case_t *c, double t)
{
    const long   i     = (long)floor(t / c->half_period);
    const double phase = t / c->half_period - (double)i;
    const double share = c->move == SINE ? 1.0 : (c->move == STEPS ? 0.35 : 0.7);
    const double s     = fmin(1.0, phase / share);
    const double from  = corner(c, i);
    const double to    = corner(c, i + 1);
    const double bend  = c->move == STROKES ? (s < 0.2   ? 3.125 * s * s
                                               : s > 0.8 ? 1.0 - 3.125 * (1.0 - s) * (1.0 - s)
                                                         : 0.125 + 1.25 * (s - 0.2))
                                            : 0.5 - 0.5 * cos(0.5 * TWO_PI * s);
    return from + (to - from) * bend;
}

typedef struct
{
    double integral, last, speed, last_wanted, last_speed;
} servo_t;

static double servo(servo_t *x, const joint_case_t *c, double at, double seen)
{
    const double w  = c->bandwidth;
    const double kv = c->mass * w;
    x->speed += (1.0 - exp(-4.0 * w * c->h)) * ((seen - x->last) / c->h - x->speed);
    const double v = (at - x->last_wanted) / c->h;
    x->last        = seen;
    const double a = (v - x->last_speed) / c->h;
    x->last_wanted = at;
    x->last_speed  = v;
    const double e = at - seen;
    double       p = kv * (v + 0.3 * w * e - x->speed) + c->ahead * c->mass * a;
    double       i = 0.0;
    if (c->loop == P_PI)
    {
        i = kv * 0.25 * w * (v + 0.3 * w * e - x->speed);
    }
    else if (c->loop == PID)
    {
        i = kv * 0.04 * w * w * e;
    }
    else if (c->loop == NO_LOOP)
    {
        p = 0.0;
    }
    if (fabs(p + x->integral) < c->u_max || (p + x->integral) * i < 0.0)
    {
        x->integral += i * c->h;
    }
    return fmax(-c->u_max, fmin(c->u_max, p + x->integral));
}

// --- the library ------------------------------------------------------------------------------------------------------------

typedef struct
{
    JOINT(t) joint;
    int sign_q_ref, sign_q; // as the joint is told
} told_t;

static void open_joint(told_t *x, const joint_case_t *c, bool is_on)
{
    tribo_joint_config_t config    = tribo_joint_config();
    config.sample_time_s           = (float)c->h;
    config.effort_max              = (float)c->u_max;
    config.travel                  = 4.0f;
    config.breakaway               = (float)fmin(c->believed * c->friction, c->u_max);
    config.actuator_pole_rad_per_s = (float)c->pole_believed;
    config.gain                    = is_on ? config.gain : 0.0f;
    const tribo_status_t status    = JOINT(init)(&x->joint, &config);
    if (status != TRIBO_OK)
    {
        (void)fprintf(stderr, "%s\n", tribo_status_text(status));
        exit(2);
    }
    x->sign_q_ref = 1;
    x->sign_q     = 1;
}

static double told_step(told_t *x, const joint_case_t *c, double effort, double q_ref, double counts)
{
#ifdef TRIBO_ARITHMETIC_Q31
    const double full = 2147483647.0;
    return (double)JOINT(step)(&x->joint,
                               (int32_t)(effort / c->u_max * full),
                               x->sign_q_ref * (int32_t)floor(q_ref / c->count),
                               x->sign_q * (int32_t)counts) /
           full * c->u_max;
#else
    return (double)JOINT(
        step)(&x->joint, (float)effort, (float)(x->sign_q_ref * q_ref / c->count), (float)(x->sign_q * counts));
#endif
}

typedef struct
{
    plant_t plant;
    servo_t servo;
    told_t  told;
    double  t, seen, u;
} run_t;

static void start(run_t *x, const joint_case_t *c, bool is_on)
{
    memset(x, 0, sizeof *x);
    x->plant.position    = wanted(c, 0.0);
    x->plant.scale       = 1.0;
    x->servo.last        = x->plant.position;
    x->servo.last_wanted = x->plant.position;
    open_joint(&x->told, c, is_on);
}

static double tick(run_t *x, const joint_case_t *c, double at, double outer)
{
    const double counts = floor(x->plant.position / c->count);
    const double error  = x->plant.position - at;
    x->seen             = (counts + 0.5) * c->count;
    const double effort = servo(&x->servo, c, at, x->seen);
    x->u                = told_step(&x->told, c, effort, at, counts);
    const int substeps  = (int)fmax(4.0, ceil(c->h / 1e-4));
    for (int i = 0; i < substeps; i++)
    {
        plant_step(&x->plant, c, x->u, outer, c->h / substeps);
    }
    x->t += c->h;
    return error;
}

static tribo_joint_report_t report_of(const run_t *x)
{
    tribo_joint_report_t report;
    JOINT(report)(&x->told.joint, &report);
    return report;
}

// --- errors ------------------------------------------------------------------------------------------------------------------

#define TURNS 12

static double rms_of(const joint_case_t *c, bool is_on, tribo_joint_report_t *report)
{
    static run_t x;
    const long   ticks   = lround(TURNS * 2.0 * c->half_period / c->h);
    double       square  = 0.0;
    long         counted = 0;
    start(&x, c, is_on);
    for (long k = 0; k < ticks; k++)
    {
        const double e = tick(&x, c, wanted(c, x.t), 0.0);
        square += k > 2 * ticks / 3 ? e * e : 0.0;
        counted += k > 2 * ticks / 3;
    }
    *report = report_of(&x);
    return sqrt(square / (double)counted + c->count * c->count);
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

/// Judges the joints whose error comes from friction: without friction, with the same load and viscous part, it would be a fifth.
#define BLAME 5.0

static joint_case_t without_friction(const joint_case_t *c)
{
    joint_case_t x = *c;
    x.friction *= 1e-9;
    x.mesh = 0.0;
    x.load *= 1e9; // over the friction
    x.viscous *= 1e9;
    return x;
}

static void print_ratios(const char *title, double *ratios, size_t count)
{
    qsort(ratios, count, sizeof ratios[0], by_size);
    if (count > 0)
    {
        printf("%s: %zu joints: error off over on: least %.2f, tenth %.2f, median %.2f, most %.1f\n",
               title,
               count,
               ratios[0],
               ratios[count / 10],
               ratios[count / 2],
               ratios[count - 1]);
    }
}

static int errors(uint64_t first, uint64_t last)
{
    static double all[JOINTS_MAX];
    static double blamed[JOINTS_MAX];
    static double bounds[JOINTS_MAX];
    size_t        count   = 0;
    size_t        some    = 0;
    size_t        below   = 0;
    size_t        tripped = 0;
    for (uint64_t seed = first; seed <= last && count < JOINTS_MAX; seed++)
    {
        tribo_joint_report_t off;
        tribo_joint_report_t on;
        const joint_case_t   c        = case_of(seed);
        const double         none     = rms_of(&c, false, &off);
        const double         ratio    = none / rms_of(&c, true, &on);
        const joint_case_t   free     = without_friction(&c);
        const double         best     = none / rms_of(&free, false, &off);
        const bool           is_worse = !(ratio >= 0.9);
        bounds[count]                 = best;
        all[count++]                  = ratio;
        if (best >= BLAME)
        {
            blamed[some++] = ratio;
        }
        below += is_worse ? 1u : 0u;
        tripped += on.cause != TRIBO_JOINT_SOUND ? 1u : 0u;
        if (is_worse || on.cause != TRIBO_JOINT_SOUND)
        {
            printf("%5llu %4.0f Hz %5.0f g %-4s %-7s: %.2f, learned %.2f, %s\n",
                   (unsigned long long)seed,
                   1.0 / c.h,
                   1e3 * c.mass,
                   loop_names[c.loop],
                   move_names[c.move],
                   ratio,
                   (double)on.friction / c.friction,
                   tribo_joint_cause_text(on.cause));
        }
    }
    print_ratios("all", all, count);
    print_ratios("the same, with no friction in the joint", bounds, count);
    print_ratios("friction is to blame", blamed, some);
    printf("%zu below 0.9, guard in %zu\n", below, tripped);
    return below > 0 || 10 * tripped > count || (some > 0 && blamed[some / 2] < 3.5);
}

// --- runaway ------------------------------------------------------------------------------------------------------------------

typedef enum
{
    THIRD,   // friction falls to a third: the term is three times what it should be
    SIGN,    // q and q_ref are told with the wrong sign: the term drives the other way
    ENCODER, // q alone is
    PULL,    // a load of 0.9 of the friction
    HAND,    // pushes with three times the friction for 0.1 s
    EVENTS
} event_t;

static const char *const event_names[EVENTS] = {"friction a third", "sign", "encoder", "load", "hand"};

/// Learns for twelve moves; then q_ref rests and the event happens. The largest speed from 0.2 s to 1 s after it, over that of the moves.
static double speed_after(const joint_case_t *c, event_t event, int way, bool is_on, bool from_start, bool is_alone)
{
    static run_t x;
    start(&x, c, is_on);
    if (from_start && event == SIGN)
    {
        x.told.sign_q     = -1;
        x.told.sign_q_ref = -1;
    }
    x.told.sign_q      = from_start && event == ENCODER ? -1 : x.told.sign_q;
    const double learn = 12.0 * c->half_period;
    const double rest  = learn + 0.15;
    double       most  = 0.0;
    joint_case_t at    = *c;
    while (x.t < rest + 1.0)
    {
        const bool after = x.t >= rest;
        if (after && is_alone)
        {
            at.loop          = NO_LOOP;
            x.servo.integral = 0.0;
        }
        double outer  = 0.0;
        x.plant.scale = after && event == THIRD ? 1.0 / 3.0 : 1.0;
        if (after && event == SIGN)
        {
            x.told.sign_q     = -1;
            x.told.sign_q_ref = -1;
        }
        x.told.sign_q = after && event == ENCODER ? -1 : x.told.sign_q;
        outer += after && event == PULL ? 0.9 * c->friction * way : 0.0;
        const double hand = event == THIRD ? 0.05 : 0.1; // a nudge starts what would hunt
        outer += after && x.t < rest + hand && (event == HAND || event == THIRD) ? 3.0 * c->friction * way : 0.0;
        (void)tick(&x, &at, wanted(c, fmin(x.t, learn)), outer);
        most = x.t > rest + hand + 0.2 ? fmax(most, fabs(x.plant.speed)) : most;
    }
    return most / (c->stroke / c->half_period);
}

static int runaway(uint64_t first, uint64_t last, long most)
{
    long count = 0;
    long bad   = 0;
    for (uint64_t seed = first; seed <= last; seed++)
    {
        joint_case_t c = case_of(seed);
        c.believed     = seed % 3 == 0 ? 3.0 : c.believed;
        for (int event = 0; event < EVENTS; event++)
        {
            c.loop                = (loop_kind_t)((seed + (uint64_t)event) % 3);
            const bool   at_start = seed % 4 == 0;
            const bool   is_alone = seed % 5 == 0; // then the loop is off, and nothing but friction holds the joint
            const int    way      = seed % 2 == 0 ? 1 : -1;
            const double with     = speed_after(&c, (event_t)event, way, true, at_start, is_alone);
            const double without  = speed_after(&c, (event_t)event, way, false, at_start, is_alone);
            const bool   is_bad   = with > 0.05 + without;
            count++;
            bad += is_bad;
            if (is_bad)
            {
                printf("%5llu %s, %4.0f Hz %5.0f g %-4s: speed %.3f of that of its moves, %.3f without\n",
                       (unsigned long long)seed,
                       event_names[event],
                       1.0 / c.h,
                       1e3 * c.mass,
                       loop_names[c.loop],
                       with,
                       without);
            }
        }
    }
    printf("%ld events: %ld with a speed beyond the intended after 0.2 s\n", count, bad);
    return bad > most;
}

// --- the force from current ---------------------------------------------------------------------------------------------------

/// Something pushes a resting joint, slowly, with up to three times the friction; the joint holds.
static int force(uint64_t first, uint64_t last)
{
    double inside = 0.0;
    double all    = 0.0;
    double width  = 0.0;
    double hidden = 0.0; // breakaway to either side
    for (uint64_t seed = first; seed <= last; seed++)
    {
        static run_t x;
        joint_case_t c     = case_of(seed);
        const double learn = 12.0 * c.half_period;
        c.load             = 0.0;
        c.loop             = seed % 2 == 0 ? PID : PD; // such as rest; a P-PI on a coarse encoder does not
        start(&x, &c, true);
        while (x.t < learn + 4.0)
        {
            const double after = x.t - learn - 0.5;
            const double outer =
                after > 0.0 ? 3.0 * c.friction * sin(2.0 * after) * cos(0.7 * after + (double)seed) : 0.0;
            (void)tick(&x, &c, wanted(&c, fmin(x.t, learn)), outer);
            if (after > 0.0)
            {
                const tribo_joint_force_t told = JOINT(force)(&x.told.joint);
                inside += (double)told.low <= -outer && -outer <= (double)told.high ? 1.0 : 0.0;
                width += ((double)told.high - (double)told.low) / c.friction;
                hidden += 2.0 * (1.0 + c.peak);
                all += 1.0;
            }
        }
    }
    printf("force within its interval in %.1f %% of the ticks; the interval is %.2f of the sliding friction wide, %.2f "
           "times what sticks may hide\n",
           100.0 * inside / all,
           width / all,
           width / hidden);
    return inside < 0.95 * all;
}

// --- quick swings ---------------------------------------------------------------------------------------------------------------

static double quick_case_of(joint_case_t *c, uint64_t seed)
{
    *c                 = case_of(seed);
    const double hertz = between_log(1.0, 16.0);
    const double w     = TWO_PI * hertz;
    const double swing = fmin(between_log(1.0, 12.0), 0.7 * c->u_max / c->friction); // of the effort, over the friction
    c->loop            = PD;
    c->move            = SINE;
    c->half_period     = 0.5 / hertz;
    c->stroke          = 2.0 * swing * c->friction / c->mass / (w * w);
    c->count           = c->stroke / between_log(200.0, 20000.0);
    c->knee            = c->stroke * w * between_log(0.005, 0.05);
    c->bristle         = c->bristle > 0.0 ? c->count * between_log(0.5, 8.0) : 0.0;
    return hertz;
}

/// The report after 10 s of such a swing.
static tribo_joint_report_t swung(const joint_case_t *c, int sign_q_ref, int sign_q)
{
    static run_t x;
    start(&x, c, true);
    x.told.sign_q_ref = sign_q_ref;
    x.told.sign_q     = sign_q;
    while (x.t < 10.0)
    {
        (void)tick(&x, c, wanted(c, x.t), 0.0);
    }
    return report_of(&x);
}

static int quick(uint64_t first, uint64_t last)
{
    long count    = 0;
    long tripped  = 0;
    long unseen   = 0;
    long reversed = 0;
    for (uint64_t seed = first; seed <= last; seed++)
    {
        joint_case_t               c;
        const double               hertz = quick_case_of(&c, seed);
        const tribo_joint_report_t sound = swung(&c, 1, 1);
        const bool                 trips = sound.cause != TRIBO_JOINT_SOUND;
        count++;
        tripped += trips;
        if (trips)
        {
            printf("%5llu %4.0f Hz %5.0f g swings at %.1f Hz: learned %.2f, %s\n",
                   (unsigned long long)seed,
                   1.0 / c.h,
                   1e3 * c.mass,
                   hertz,
                   (double)sound.friction / c.friction,
                   tribo_joint_cause_text(sound.cause));
        }
        for (int sign_q_ref = -1; sign_q_ref <= 1; sign_q_ref += 2)
        {
            reversed++;
            unseen += swung(&c, sign_q_ref, -1).cause == TRIBO_JOINT_SOUND;
        }
    }
    printf("%ld swings: guard in %ld; of %ld with a wrong sign %ld unseen after 10 s\n",
           count,
           tripped,
           reversed,
           unseen);
    return tripped > 0 || 10 * unseen > reversed;
}

int main(int argc, char **argv)
{
    const uint64_t first = argc > 3 ? strtoull(argv[2], NULL, 10) : 1;
    const uint64_t last  = argc > 3 ? strtoull(argv[3], NULL, 10) : 1;
    if (argc > 1 && strcmp(argv[1], "runaway") == 0)
    {
        return runaway(first, last, argc > 4 ? strtol(argv[4], NULL, 10) : 0);
    }
    if (argc > 1 && strcmp(argv[1], "quick") == 0)
    {
        return quick(first, last);
    }
    return argc > 1 && strcmp(argv[1], "force") == 0 ? force(first, last) : errors(first, last);
}
