// A rig that shares no line with the project: a mass before a spring, time-stepped after Moreau, with friction of its own, a drive and a sensor. Reads rows "t r" and
// writes rows t, u, F as doubles.
//
//     strange FILE key=value ...
//
// law 0 Coulomb, 1 Stribeck, 2 Maxwell slip, 3 LuGre; forces in N at the load. u comes from a slow controller of r - F, or with open=1 is r itself.

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum
{
    SLIPS = 12
};

static int    words;
static char **word;

static double key(const char *name, double otherwise)
{
    const size_t length = strlen(name);
    for (int i = 2; i < words; i++)
    {
        if (strncmp(word[i], name, length) == 0 && word[i][length] == '=')
        {
            return strtod(word[i] + length + 1, NULL);
        }
    }
    return otherwise;
}

static uint64_t seed;

static double uniform(void)
{
    uint64_t z = (seed += 0x9e3779b97f4a7c15u);
    z          = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z          = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) / 9007199254740992.0;
}

static double normal(void)
{
    const double radius = sqrt(-2.0 * log(1.0 - uniform()));
    return radius * cos(6.283185307179586 * uniform());
}

typedef struct
{
    int    law;
    double offset, slope, down, sliding, stribeck, viscous, stiff, warm, warm_s;
    double slip[SLIPS], bristle, last;
} friction_t;

/// What stands against the motion at full sliding.
static double level(const friction_t *f, double force, double way, double t)
{
    const double L = (f->offset + f->slope * fabs(force)) * (1.0 - f->warm * (1.0 - exp(-t / f->warm_s)));
    return way < 0.0 ? L * f->down : L;
}

/// Force against a motion with speed v over a step, where `stop` would just stop the mass.
static double against(friction_t *f, double L, double x, double v, double stop, double dt)
{
    if (f->law <= 1)
    {
        const double falls = f->law == 1 ? f->sliding + (1.0 - f->sliding) * exp(-fabs(v) / f->stribeck) : 1.0;
        const double most  = L * falls;
        return stop > most ? most : stop < -most ? -most : stop;
    }
    if (f->law == 2)
    {
        double sum = 0.0;
        for (int i = 0; i < SLIPS; i++)
        {
            const double most = 2.0 * L * (i + 1) / (SLIPS * (SLIPS + 1.0));
            f->slip[i]        = fmin(fmax(f->slip[i] + f->stiff / SLIPS * (x - f->last), -most), most);
            sum += f->slip[i];
        }
        f->last = x;
        return sum + 0.02 * f->stiff * v * 1e-2;
    }
    const double g   = L * (f->sliding + (1.0 - f->sliding) * exp(-fabs(v) / f->stribeck));
    const double was = f->bristle;
    f->bristle       = (was + dt * v) / (1.0 + dt * f->stiff * fabs(v) / g);
    return f->stiff * f->bristle + 0.004 * f->stiff * (f->bristle - was) / dt;
}

int main(int count, char **arguments)
{
    words              = count;
    word               = arguments;
    FILE         *file = fopen(arguments[1], "r");
    static double at[400000], r[400000];
    size_t        rows = 0;
    while (file != NULL && rows < 400000 && fscanf(file, "%lf %lf", &at[rows], &r[rows]) == 2)
    {
        rows++;
    }
    seed              = (uint64_t)key("seed", 1.0) * 7919u + 12345u;
    const double h    = key("h", 1e-3);
    const long   fine = (long)ceil(h / 2.5e-5 - 1e-9);
    const double dt = h / (double)fine, m = key("m", 1.0), k = m * pow(key("w", 150.0), 2.0),
                 c     = 2.0 * key("z", 0.5) * m * key("w", 150.0);
    const double drive = 1.0 - exp(-dt / key("drive", 2e-3)), sensor = 1.0 - exp(-dt / key("sensor", 3e-3));
    const double scale = key("scale", 1.0), bias = key("bias", 0.0), high = key("high", 20.0), cog = key("cog", 0.0),
                 period = key("period", 1.0);
    friction_t f        = {.law      = (int)key("law", 0.0),
                           .offset   = key("offset", 0.4),
                           .slope    = key("slope", 0.12),
                           .down     = key("down", 1.0),
                           .sliding  = key("sliding", 1.0),
                           .stribeck = key("stribeck", 1.0) / k,
                           .viscous  = key("viscous", 0.0),
                           .stiff    = key("stiff", 30.0) * k,
                           .warm     = key("warm", 0.0),
                           .warm_s   = key("warm_s", 10.0)};
    double     x = 0.0, v = 0.0, force = 0.0, seen = 0.0, u = 0.0, filtered = 0.0, held = 0.0, trail[64] = {0.0};
    const int  late = (int)key("delay", 0.0), hold = (int)key("hold", 1.0);
    const long ticks = (long)(at[rows - 1] / h);
    size_t     place = 0;
    for (long n = 0; n < ticks; n++)
    {
        const double t = (double)n * h;
        while (place + 2 < rows && at[place + 1] <= t)
        {
            place++;
        }
        const double wanted = r[place] + (r[place + 1] - r[place]) * (t - at[place]) / (at[place + 1] - at[place]);
        double       y      = seen + key("noise", 0.0) * normal() + key("drift", 0.0) * t / at[rows - 1] +
                   (t > key("tare_s", 1e9) ? key("tare", 0.0) : 0.0);
        const double step = key("step", 0.0);
        y                 = step > 0.0 ? step * floor(y / step + 0.5) : y;
        held              = n % hold == 0 ? y : held;
        // u = (r - y) / (1 + s / 10), backward Euler
        filtered += 10.0 * h / (1.0 + 10.0 * h) * (wanted - held - filtered);
        u                   = key("open", 0.0) > 0.0 ? wanted : fmin(fmax(filtered, -high), high);
        const double row[3] = {t, u, held};
        fwrite(row, sizeof row, 1, stdout);
        trail[n % 64]        = u;
        const double command = n >= late ? trail[(n - late) % 64] : 0.0;
        for (long i = 0; i < fine; i++)
        {
            force += drive * (scale * command + bias - force);
            const double push = force + cog * sin(6.283185307179586 * k * x / period) - k * x - (c + f.viscous) * v;
            const double stop = push + m * v / dt;
            const double way  = f.law <= 1 ? stop : v;
            v += dt / m * (push - against(&f, level(&f, k * x, way, t), x, v, stop, dt));
            x += dt * v;
            seen += sensor * (k * x - seen);
        }
    }
    return 0;
}
