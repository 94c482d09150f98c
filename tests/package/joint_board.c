// What the joint's example leaves to its reader: a joint that sticks with half as much friction again as the example says, an encoder of 16384
// counts, a position loop, and a main that compares the loop with the example and without. With a PATH it writes the motions there.

#include "tribo/status.h"

#include <math.h>
#include <stdio.h>

float          read_position_rad(void);
void           command_n_m(float u);
float          my_position_loop(float q_ref, float q);
tribo_status_t joint_start(void);
void           joint_tick(float q_ref);

#define INERTIA  0.02 // kg m^2
#define FRICTION 0.45 // N m
#define COUNT    (6.283185307179586 / 16384.0)
#define TICKS    60000 // of 1 ms
#define STEPS    10
#define SHOWN    8000 // ticks at the end, two periods, that count; every tenth is written

static double position, speed, last, integral;
static double shown[2][SHOWN]; // without and with the joint

float read_position_rad(void)
{
    return (float)(COUNT * floor(position / COUNT));
}

void command_n_m(float u)
{
    for (int i = 0; i < STEPS; i++)
    {
        const double most  = (double)u + INERTIA * speed * 1e3 * STEPS; // that stops it in this step
        const double brake = fmin(FRICTION, fmax(-FRICTION, most));
        speed += ((double)u - brake) / INERTIA * 1e-3 / STEPS;
        position += speed * 1e-3 / STEPS;
    }
}

float my_position_loop(float q_ref, float q)
{
    const double error = (double)q_ref - (double)q;
    integral           = fmin(2.0, fmax(-2.0, integral + 60.0 * error * 1e-3));
    const double u     = 12.0 * error + integral - 0.5 * ((double)q - last) * 1e3;
    last               = (double)q;
    return (float)u;
}

static double reference_at(long tick)
{
    return 0.2 * (1.0 - cos(6.283185307179586 * 0.25 * (double)tick * 1e-3));
}

/// RMS error in rad over the last periods of a slow sine.
static double follow(int with_joint)
{
    position = speed = last = integral = 0.0;
    double sum                         = 0.0;
    for (long tick = 0; tick < TICKS; tick++)
    {
        const double reference = reference_at(tick);
        if (tick >= TICKS - SHOWN)
        {
            sum += (reference - position) * (reference - position);
            shown[with_joint][tick - (TICKS - SHOWN)] = position;
        }
        if (with_joint)
        {
            joint_tick((float)reference);
        }
        else
        {
            command_n_m(my_position_loop((float)reference, read_position_rad()));
        }
    }
    return sqrt(sum / SHOWN);
}

static int write_motions(const char *path)
{
    FILE *const file = fopen(path, "w");
    if (file == NULL)
    {
        perror(path);
        return 1;
    }
    fprintf(file, "t_s,q_ref_rad,q_without_rad,q_with_rad\n");
    for (int i = 0; i < SHOWN; i += 10)
    {
        fprintf(file, "%.2f,%.6f,%.6f,%.6f\n", 1e-3 * i, reference_at(TICKS - SHOWN + i), shown[0][i], shown[1][i]);
    }
    return fclose(file);
}

int main(int argc, char **argv)
{
    if (joint_start() != TRIBO_OK)
    {
        return 1;
    }
    const double without = follow(0), with = follow(1);
    if (argc > 1 && write_motions(argv[1]) != 0)
    {
        return 1;
    }
    printf("position loop: RMS error %.2f mrad, with the joint %.2f mrad\n", 1e3 * without, 1e3 * with);
    return fabs(without - 16.4e-3) < 0.1e-3 && fabs(with - 3.2e-3) < 0.1e-3 ? 0 : 1; // what the README says
}
