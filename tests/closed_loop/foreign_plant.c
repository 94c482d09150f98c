#include "foreign_plant.h"

#include <math.h>

double foreign_random(uint64_t *seed)
{
    *seed ^= *seed << 13; // Marsaglia's xorshift
    *seed ^= *seed >> 7;
    *seed ^= *seed << 17;
    return (double)(*seed >> 11) * 0x1p-52 - 1.0;
}

void foreign_plant_open(foreign_plant_t *plant, const foreign_plant_config_t *config, uint64_t seed)
{
    *plant = (foreign_plant_t){.config        = *config,
                               .actuator_part = 1.0 - exp(-config->actuator_pole * config->step_s),
                               .sensor_part   = 1.0 - exp(-config->sensor_pole * config->step_s),
                               .seed          = seed * 0x9e3779b97f4a7c15u + 1u};
}

double foreign_plant_force(const foreign_plant_t *plant)
{
    return plant->position - plant->environment;
}

double foreign_plant_read(foreign_plant_t *plant)
{
    double sum = 0.0;
    for (int i = 0; i < 12; i++)
    {
        sum += foreign_random(&plant->seed); // variance 1/3 each
    }
    return plant->sensor + plant->config.noise * 0.5 * sum;
}

static double breakaway(const foreign_plant_t *plant, double direction)
{
    const foreign_plant_config_t *c = &plant->config;
    const int                     d = direction < 0.0 ? 1 : 0;
    return c->offset[d] + c->slope[d] * fabs(foreign_plant_force(plant));
}

/// The rate after a step in which friction of the given level opposes motion: `push` = `inertia` rate + friction.
static double rate_coulomb(foreign_plant_t *plant, double push, double inertia)
{
    const foreign_plant_config_t *c     = &plant->config;
    const double                  ratio = plant->rate / c->stribeck;
    const double peak  = c->law == FOREIGN_STRIBECK ? c->sliding + (1.0 - c->sliding) * exp(-ratio * ratio) : 1.0;
    const double level = peak * breakaway(plant, push);
    plant->friction    = fmax(-level, fmin(level, push));
    return (push - plant->friction) / inertia;
}

/// Dahl's bristle with a damper on it, linear in the new rate.
static double rate_lugre(foreign_plant_t *plant, double push, double inertia)
{
    const foreign_plant_config_t *c         = &plant->config;
    const double                  dt        = c->step_s;
    const double                  stiffness = breakaway(plant, plant->bristle[0]) / c->presliding;
    const double                  damper    = sqrt(c->inertia * stiffness) / dt;
    const double                  both      = stiffness + damper;
    const double                  kept      = 1.0 / (1.0 + dt * fabs(plant->rate) / c->presliding);
    const double                  old       = plant->bristle[0];
    const double                  rate      = (push + damper * old - both * kept * old) / (inertia + both * kept * dt);
    plant->bristle[0]                       = (old + dt * rate) * kept;
    plant->friction                         = both * plant->bristle[0] - damper * old;
    return rate;
}

/// Newton's method on a monotone function of straight parts.
static double rate_maxwell(foreign_plant_t *plant, double push, double inertia)
{
    static const double           share[FOREIGN_STOPS] = {0.4, 0.25, 0.2, 0.15};
    static const double           width[FOREIGN_STOPS] = {0.03, 0.12, 0.4, 1.0}; // of the travel
    const foreign_plant_config_t *c                    = &plant->config;
    const double                  L                    = breakaway(plant, push);
    double                        rate                 = plant->rate;
    double                        moved[FOREIGN_STOPS];
    for (int pass = 0; pass < 12; pass++)
    {
        double slope    = inertia;
        plant->friction = 0.0;
        for (int i = 0; i < FOREIGN_STOPS; i++)
        {
            const double most = width[i] * c->presliding;
            const double free = plant->bristle[i] + c->step_s * rate;
            moved[i]          = fmax(-most, fmin(most, free));
            slope += fabs(free) < most ? L * share[i] / most * c->step_s : 0.0;
            plant->friction += L * share[i] / most * moved[i];
        }
        rate -= (inertia * rate + plant->friction - push) / slope;
    }
    for (int i = 0; i < FOREIGN_STOPS; i++)
    {
        plant->bristle[i] = moved[i];
    }
    return rate;
}

/// Newton's method, kept between bounds that every pass narrows: tanh alone would make it leap to and fro.
static double rate_smooth(foreign_plant_t *plant, double push, double inertia)
{
    const foreign_plant_config_t *c    = &plant->config;
    const double                  L    = breakaway(plant, push);
    double                        low  = (push - L) / inertia;
    double                        high = (push + L) / inertia;
    double                        rate = fmax(low, fmin(high, plant->rate));
    for (int pass = 0; pass < 60; pass++)
    {
        const double part  = tanh(rate / c->creep);
        const double wrong = inertia * rate + L * part - push;
        plant->friction    = L * part;
        low                = wrong < 0.0 ? rate : low;
        high               = wrong < 0.0 ? high : rate;
        const double next  = rate - wrong / (inertia + L / c->creep * (1.0 - part * part));
        if (fabs(next - rate) <= 1e-12 * fabs(rate))
        {
            break;
        }
        rate = next > low && next < high ? next : 0.5 * (low + high);
    }
    return rate;
}

void foreign_plant_step(foreign_plant_t *plant, double u, double load, double environment)
{
    const foreign_plant_config_t *c  = &plant->config;
    const double                  dt = c->step_s;
    plant->actuator += plant->actuator_part * (u - plant->actuator);
    plant->environment   = environment;
    const double inertia = c->inertia / dt + c->damping + dt;
    const double push    = c->inertia / dt * plant->rate + plant->actuator + load - (plant->position - environment);
    plant->rate          = c->law == FOREIGN_LUGRE     ? rate_lugre(plant, push, inertia)
                           : c->law == FOREIGN_MAXWELL ? rate_maxwell(plant, push, inertia)
                           : c->law == FOREIGN_SMOOTH  ? rate_smooth(plant, push, inertia)
                                                       : rate_coulomb(plant, push, inertia);
    plant->position += dt * plant->rate;
    plant->sensor += plant->sensor_part * (foreign_plant_force(plant) - plant->sensor);
}
