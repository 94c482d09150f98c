// A drive on a foreign rig, for the tests of tribo-rig. The rig is tests/closed_loop/foreign_plant.h, which shares no code with the project. What its owner does not know stands here:
// the scale and bias of the command, and the delay.

#include "../closed_loop/foreign_plant.h"

#include <math.h>
#include <stddef.h>

#define DELAY_MAX    64
#define STEPS_A_TICK 10

typedef struct
{
    foreign_plant_t plant;
    double          tick_s, scale, bias;
    double          late[DELAY_MAX]; // commands that are on their way
    size_t          delay, at;       // in ticks
    double          highest, lowest; // force so far
} drive_t;

static drive_t drive;

/// `p`: poles of actuator and sensor, I/K, b/K, offset and slope upwards, law, sliding, Stribeck rate, presliding, noise, friction downwards over that upwards.
void foreign_open(const double *p, double tick_s, double scale, double bias, size_t delay, unsigned long long seed)
{
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
                                           .step_s        = tick_s / STEPS_A_TICK};
    drive                               = (drive_t){.tick_s = tick_s, .scale = scale, .bias = bias, .delay = delay};
    foreign_plant_open(&drive.plant, &config, seed);
}

void foreign_tick(double command)
{
    drive.late[(drive.at + drive.delay) % DELAY_MAX] = drive.scale * command + drive.bias;
    for (int i = 0; i < STEPS_A_TICK; i++)
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
