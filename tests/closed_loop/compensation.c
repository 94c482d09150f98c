#include "compensation.h"

#include "loop/loop_f32.h"
#include "plant/plant.h"
#include "plant/sensor.h"
#include "scenario/config.h"
#include "tribo/force_loop_f32.h"
#include "unity.h"

#include <math.h>
#include <stddef.h>

#define H            1e-3
#define STEPS_A_TICK 10 // of 0.1 ms

compensation_truth_t compensation_nominal(void)
{
    return (compensation_truth_t){.breakaway_positive = 1.0,
                                  .breakaway_negative = 1.0,
                                  .actuator_gain      = 1.0,
                                  .noise_seed         = 1,
                                  .settle_s           = 1.0};
}

typedef struct
{
    common_scenario_t *scenario; // for the plant's defaults
    sim_plant_config_t config;
    sim_plant_t       *plant;
    sim_sensor_t       sensor;
    double             gain;
    double             environment_n, environment_rad_per_s;
    double             push_n, push_s, push_end_s;
    double             t;
} rig_t;

static void open_rig(rig_t *rig, const compensation_truth_t *truth)
{
    rig->scenario = sim_scenario_create();
    TEST_ASSERT_NOT_NULL(rig->scenario);
    const sim_config_t *defaults = sim_scenario_config(rig->scenario);
    rig->config                  = (sim_plant_config_t){.step_s                  = H / STEPS_A_TICK,
                                                        .actuator_pole_rad_per_s = defaults->plant.actuator_pole_rad_per_s,
                                                        .sensor_pole_rad_per_s   = defaults->sensor.pole_rad_per_s,
                                                        .truth                   = {.friction = defaults->plant.friction,
                                                                                    .arm      = defaults->plant.arm,
                                                                                    .own      = defaults->plant.own[SIM_TRUTH_paper]}};

    common_breakaway_config_t *breakaway = &rig->config.truth.friction.breakaway;
    breakaway->negative_offset_n         = (common_optional_t){true, truth->breakaway_negative * breakaway->offset_n};
    breakaway->negative_slope            = (common_optional_t){true, truth->breakaway_negative * breakaway->slope};
    breakaway->offset_n *= truth->breakaway_positive;
    breakaway->slope *= truth->breakaway_positive;
    rig->gain                  = truth->actuator_gain;
    rig->environment_n         = truth->environment_n;
    rig->environment_rad_per_s = 2.0 * 3.14159265358979 * truth->environment_hz;
    rig->push_n                = truth->push_n;
    rig->push_s                = truth->push_s;
    rig->push_end_s            = truth->push_s + truth->push_time_s;
    rig->t                     = 0.0;
    rig->plant                 = sim_plant_create(&rig->config, &sim_paper_truth);
    TEST_ASSERT_NOT_NULL(rig->plant);
    const sim_sensor_config_t sensor = {.noise_n = truth->noise_n, .noise_seed = truth->noise_seed};
    TEST_ASSERT_TRUE(sim_sensor_init(&rig->sensor, &sensor, rig->config.step_s));
}

static void close_rig(rig_t *rig)
{
    sim_sensor_free(&rig->sensor);
    sim_plant_destroy(rig->plant);
    common_scenario_destroy(rig->scenario);
}

/// An environment that has moved by x reduces the force by K x. For the arm this equals K x more motor force. The plant's input
/// is before the actuator's pole p, hence (1 + s/p) K x.
static double environment_in_front(const rig_t *rig)
{
    const double phase = rig->environment_rad_per_s * rig->t;
    const double lead  = rig->environment_rad_per_s / rig->config.actuator_pole_rad_per_s;
    return rig->environment_n * (sin(phase) + lead * cos(phase));
}

static double force(const rig_t *rig)
{
    return sim_plant_force(rig->plant) - rig->environment_n * sin(rig->environment_rad_per_s * rig->t);
}

/// The force after the sensor's pole, with the environment's motion filtered by that pole.
static double filtered_force(const rig_t *rig)
{
    const double phase = rig->environment_rad_per_s * rig->t;
    const double lag   = rig->environment_rad_per_s / rig->config.sensor_pole_rad_per_s;
    const double swing = rig->environment_n * (sin(phase) - lag * cos(phase)) / (1.0 + lag * lag);
    return sim_plant_filtered_force(rig->plant) - swing;
}

static void tick_rig(rig_t *rig, double u)
{
    sim_plant_signals_t seen;
    for (int i = 0; i < STEPS_A_TICK; i++)
    {
        const double push = rig->t >= rig->push_s && rig->t < rig->push_end_s ? rig->push_n : 0.0;
        sim_sensor_push(&rig->sensor, filtered_force(rig));
        sim_plant_step(rig->plant, rig->gain * u + push + environment_in_front(rig), &seen);
        rig->t += rig->config.step_s;
    }
}

compensation_result_t compensation_run(compensation_t                        method,
                                       const tribo_feedforward_f32_config_t *config,
                                       const compensation_truth_t           *truth,
                                       compensation_reference_t              reference,
                                       const void                           *context,
                                       double                                first_s,
                                       double                                second_s)
{
    const tribo_feedforward_f32_config_t standard = tribo_feedforward_f32_default();
    tribo_force_loop_f32_config_t        off      = tribo_force_loop_f32_paper();
    static loop_t                        loop;
    rig_t                                rig;
    open_rig(&rig, truth);
    off.gain                                   = 0.0f;
    const tribo_feedforward_f32_config_t *used = config != NULL ? config : &standard;
    const bool                            fed  = method == COMPENSATION_FEEDFORWARD;
    TEST_ASSERT_EQUAL_INT(TRIBO_OK, loop_init_feedforward(&loop, &off, fed ? used : NULL));

    compensation_result_t result = {.rms = 0.0};
    const long            first  = lround(first_s / H);
    const long            settle = lround(fmin(truth->settle_s, 0.5 * first_s) / H);
    const long            all    = first + lround(second_s / H);
    double                last_u = 0.0;
    for (long k = 0; k < all; k++)
    {
        const double r     = reference(context, (double)k * H);
        const double y     = sim_sensor_read(&rig.sensor, filtered_force(&rig));
        const double F     = force(&rig);
        const double error = r - F;
        const double u     = loop_step(&loop, r, y).u;
        if (k < first)
        {
            const double counted = k >= settle ? error : 0.0;
            result.first_rms += counted * counted;
        }
        else
        {
            result.rms += error * error;
            result.peak = fmax(result.peak, fabs(error));
            result.variation += fabs(u - last_u);
        }
        last_u = u;
        tick_rig(&rig, u);
    }
    close_rig(&rig);
    result.first_rms = first > 0 ? sqrt(result.first_rms / (double)(first - settle)) : 0.0;
    result.rms       = sqrt(result.rms / (double)(all - first));
    return result;
}

double compensation_triangle(const void *context, double t)
{
    const compensation_triangle_t *triangle = context;
    const double                   height   = triangle->high - triangle->low;
    const double                   sign     = fmod(triangle->slope * t, 2.0 * height);
    return triangle->low + (sign < height ? sign : 2.0 * height - sign);
}

compensation_result_t compensation_run_triangle(compensation_t                        method,
                                                const tribo_feedforward_f32_config_t *config,
                                                const compensation_truth_t           *truth,
                                                compensation_triangle_t               triangle)
{
    const double period = 2.0 * (triangle.high - triangle.low) / triangle.slope;
    return compensation_run(method, config, truth, compensation_triangle, &triangle, period, 2.0 * period);
}
