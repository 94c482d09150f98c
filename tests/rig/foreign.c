// A drive on a foreign rig, for the tests of tribo-rig. The rig is tests/closed_loop/foreign_plant.h, which shares no code with the project. What its owner does not know stands here:
// the scale and bias of the command, and the delay.

#include "../closed_loop/foreign_plant.h"

#include <math.h>
#include <stddef.h>

#define DELAY_MAX 64
#define STEP_S    1e-5 // its own error is half a step in each lag

typedef struct
{
    foreign_plant_t plant;
    double          scale, bias;
    int             steps;           // a tick
    double          late[DELAY_MAX]; // commands that are on their way
    size_t          delay, at;       // in ticks
    double          highest, lowest; // force so far
} drive_t;

static drive_t drive;

/// `p`: poles of actuator and sensor, I/K, b/K, offset and slope upwards, law, sliding, Stribeck rate, presliding, noise, friction downwards over that upwards.
void foreign_open(const double *p, double tick_s, double scale, double bias, size_t delay, unsigned long long seed)
{
    const int                    steps  = (int)ceil(tick_s / STEP_S - 1e-6);
    const foreign_plant_config_t config = {.actuator_pole = p[0],
                                           .sensor_pole   = p[1],
                                           .inertia       = p[2],
                                           .damping       = p[3],
                                           .offset        = {p[4], p[11] * p[4]},
                                           .slope         = {p[5], p[11] * p[5]},
                                           .law           = (foreign_law_t)p[6],
                                           .sliding       = p[7],
                                           .stribeck      = p[8],
                                           .presliding    = p[9],
                                           .noise         = p[10],
                                           .step_s        = tick_s / steps};
    drive                               = (drive_t){.steps = steps, .scale = scale, .bias = bias, .delay = delay};
    foreign_plant_open(&drive.plant, &config, seed);
}

void foreign_tick(double command)
{
    drive.late[(drive.at + drive.delay) % DELAY_MAX] = drive.scale * command + drive.bias;
    for (int i = 0; i < drive.steps; i++)
    {
        foreign_plant_step(&drive.plant, drive.late[drive.at % DELAY_MAX], 0.0, 0.0);
    }
    drive.at++;
    const double force = foreign_plant_force(&drive.plant);
    drive.highest      = fmax(drive.highest, force);
    drive.lowest       = fmin(drive.lowest, force);
}

double foreign_read(void)
{
    return foreign_plant_read(&drive.plant);
}

void foreign_extremes(double *lowest, double *highest)
{
    *lowest  = drive.lowest;
    *highest = drive.highest;
}
