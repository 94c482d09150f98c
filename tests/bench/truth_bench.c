// The truth models' numbers: tribo-truth-bench. No arguments; two or three minutes, most of them LuGre by
// methods that are not for it.
//
//   1. error of the plant's fixed steps against step size, every model, against CVODE at 1e-8;
//   2. what LuGre costs beside the paper's model (its section 4): steps, right-hand sides and time of one run each, with
//      the same input and tolerance, by CVODE's method for stiff problems and by
//      its other one, by the plant's fixed steps, and by explicit
//      Euler steps, the method that needs what LuGre's stiffness asks for.
//
// Time is processor time and differs from run to run; the counts do not.

#include "plant/truth/arm.h"
#include "rig.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static double now_s(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

/// The sawtooth of Fig. 8 in spirit: rises to 0.6 N, falls deep, rises, falls shallow, rises.
static const rig_ramp_t sawtooth[] = {{0.6, 3.0}, {0.12, 2.4}, {0.6, 2.4}, {0.42, 0.9}, {0.6, 0.9}};
#define SAWTOOTH_COUNT   (sizeof sawtooth / sizeof sawtooth[0])
#define SAWTOOTH_SECONDS 9.6

/// Jumps of u within 5 ms, as from a step of the reference.
static const rig_ramp_t jumps[] =
    {{0.5, 0.005}, {0.5, 0.195}, {0.1, 0.005}, {0.1, 0.195}, {0.45, 0.005}, {0.45, 0.195}};
#define JUMPS_COUNT (sizeof jumps / sizeof jumps[0])

static const double step_sizes_s[] = {1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5};
#define STEP_SIZES (sizeof step_sizes_s / sizeof step_sizes_s[0])

static void print_errors(const char *title, const rig_ramp_t *ramps, unsigned count)
{
    printf("\n%s\n%-18s", title, "step, ms");
    for (unsigned k = 0; k < STEP_SIZES; k++)
    {
        printf(" %8g", 1e3 * step_sizes_s[k]);
    }
    printf("\n");
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        rig_t rig;
        rig_init(&rig, sim_truth_models[i]);
        printf("%-18s", rig.truth->name);
        for (unsigned k = 0; k < STEP_SIZES; k++)
        {
            printf(" %8.4f", 100.0 * rig_compare(&rig, step_sizes_s[k], ramps, count, NULL).difference);
            fflush(stdout);
        }
        printf("\n");
    }
}

static void ignore(void *context, const rig_sample_t *sample)
{
    (void)context;
    (void)sample;
}

static cvode_cost_t run_cvode(const rig_t *rig, double tolerance, bool adams)
{
    cvode_options_t options    = cvode_defaults;
    options.relative_tolerance = tolerance;
    options.position_deg *= tolerance / cvode_defaults.relative_tolerance;
    options.speed_deg_per_s *= tolerance / cvode_defaults.relative_tolerance;
    options.states *= tolerance / cvode_defaults.relative_tolerance;
    options.adams     = adams;
    cvode_cost_t cost = {0};
    rig_run_reference(rig, &options, 0.1, sawtooth, SAWTOOTH_COUNT, ignore, NULL, &cost);
    return cost;
}

// The plant's fixed steps, with the law's evaluations counted.

static sim_law_t counted_law;
static long      evaluations;

static double count_update(const void *law, const sim_law_step_t *step, double end_speed, double z_end[])
{
    evaluations++;
    return sim_lugre_truth.law->update(law, step, end_speed, z_end);
}

static void *create_counted(const sim_truth_config_t *config, double step_s)
{
    return sim_arm_create(&counted_law, config, step_s);
}

static long count_evaluations(const rig_t *rig)
{
    if (rig->truth->law->update == NULL)
    {
        return lround(SAWTOOTH_SECONDS / RIG_STEP_S); // the paper's: one a step
    }
    sim_truth_ops_t counted = *rig->truth;
    rig_t           copy    = *rig;
    counted_law             = *rig->truth->law;
    counted_law.update      = count_update;
    counted.create          = create_counted;
    copy.truth              = &counted;
    evaluations             = 0;
    rig_run(&copy, RIG_STEP_S, sawtooth, SAWTOOTH_COUNT, ignore, NULL);
    return evaluations;
}

static double time_of_fixed_steps(const rig_t *rig)
{
    const int    repeats = 20;
    const double start   = now_s();
    for (int i = 0; i < repeats; i++)
    {
        rig_run(rig, RIG_STEP_S, sawtooth, SAWTOOTH_COUNT, ignore, NULL);
    }
    return (now_s() - start) / repeats;
}

// Explicit Euler on the law's own equations. Modes are left alone: for LuGre, which has none.

typedef struct
{
    double seconds;
    long   steps, flips; ///< flips of the sign of f
} euler_t;

static euler_t run_euler(const rig_t *rig, double step_s)
{
    const sim_law_t           *law                    = rig->truth->law;
    const common_arm_config_t *arm                    = &rig->config.arm;
    double                     memory[256]            = {0};
    double                     z[SIM_LAW_STATES_MAX]  = {0};
    double                     dz[SIM_LAW_STATES_MAX] = {0};
    double                     position               = 0.0;
    double                     speed                  = 0.0;
    double                     past                   = 0.0;
    euler_t                    euler                  = {0};
    TEST_ASSERT_LESS_OR_EQUAL_size_t(sizeof memory, law->size);
    sim_law_reset(law, memory, &rig->config, z);

    const double start = now_s();
    double       from  = 0.0;
    for (unsigned i = 0; i < SAWTOOTH_COUNT; i++)
    {
        const long steps = lround(sawtooth[i].seconds / step_s);
        for (long k = 0; k < steps; k++)
        {
            const double u     = from + (sawtooth[i].to_n - from) * (double)k / (double)steps;
            const double force = arm->stiffness * position;

            const sim_contact_t now = {.u_n             = u,
                                       .n_n             = u - force,
                                       .force_n         = force,
                                       .speed_deg_per_s = speed,
                                       .breakaway       = sim_breakaway_at(&rig->config.friction.breakaway, force)};
            const double        f   = law->friction(memory, &now, z);
            law->rates(memory, &now, z, dz);
            position += step_s * speed;
            speed += step_s * (now.n_n - arm->damping * speed - f) / arm->inertia;
            z[0] += step_s * dz[0];
            euler.flips += f * past < 0.0;
            past = f;
            euler.steps++;
        }
        from = sawtooth[i].to_n;
    }
    euler.seconds = now_s() - start;
    return euler;
}

static void print_cost(const char *method, const char *model, long steps, long calls, double seconds)
{
    printf("%-34s %-8s %10ld %10ld %10.3f\n", method, model, steps, calls, 1e3 * seconds);
}

static void print_ratio(const char *method, double calls, double seconds)
{
    printf("%-34s %-8s %10s %10.2f %10.2f\n", method, "ratio", "", calls, seconds);
}

static void compare_costs(void)
{
    rig_t paper;
    rig_t lugre;
    rig_init(&paper, &sim_paper_truth);
    rig_init(&lugre, &sim_lugre_truth);
    printf("\nSection 4: LuGre beside the paper's model, one sawtooth of %g s\n", SAWTOOTH_SECONDS);
    printf("%-34s %-8s %10s %10s %10s\n", "", "", "steps", "rhs", "ms");
    for (int adams = 0; adams < 2; adams++)
    {
        for (double tolerance = 1e-4; tolerance > 0.9e-8; tolerance *= 1e-2)
        {
            char method[64];
            (void)snprintf(method, sizeof method, "CVODE %s, %g", adams ? "Adams" : "BDF", tolerance);
            const cvode_cost_t of_paper = run_cvode(&paper, tolerance, adams != 0);
            const cvode_cost_t of_lugre = run_cvode(&lugre, tolerance, adams != 0);
            print_cost(method, "paper", of_paper.steps, of_paper.right_hand_sides, of_paper.seconds);
            print_cost(method, "lugre", of_lugre.steps, of_lugre.right_hand_sides, of_lugre.seconds);
            print_ratio(method,
                        (double)of_lugre.right_hand_sides / (double)of_paper.right_hand_sides,
                        of_lugre.seconds / of_paper.seconds);
        }
    }

    const long   plant_steps  = lround(SAWTOOTH_SECONDS / RIG_STEP_S);
    const long   paper_calls  = count_evaluations(&paper);
    const long   lugre_calls  = count_evaluations(&lugre);
    const double paper_time_s = time_of_fixed_steps(&paper);
    const double lugre_time_s = time_of_fixed_steps(&lugre);
    print_cost("fixed, 0.1 ms", "paper", plant_steps, paper_calls, paper_time_s);
    print_cost("fixed, 0.1 ms (LuGre 2 of 0.05)", "lugre", 2 * plant_steps, lugre_calls, lugre_time_s);
    print_ratio("fixed", (double)lugre_calls / (double)paper_calls, lugre_time_s / paper_time_s);

    for (double step_s = 2.0e-6; step_s > 0.2e-6; step_s *= 0.5)
    {
        const euler_t euler = run_euler(&lugre, step_s);
        char          method[64];
        const double  flipping = 100.0 * (double)euler.flips / (double)euler.steps;
        (void)snprintf(method, sizeof method, "Euler %g us, f flips in %.2g %%", 1e6 * step_s, flipping);
        print_cost(method, "lugre", euler.steps, euler.steps, euler.seconds);
        print_ratio(method, (double)euler.steps / (double)paper_calls, euler.seconds / paper_time_s);
    }
}

static void print_speeds(void)
{
    printf("\nTimes real time, one core, open loop, 0.1 ms\n");
    for (size_t i = 0; i < SIM_TRUTH_COUNT; i++)
    {
        rig_t rig;
        rig_init(&rig, sim_truth_models[i]);
        printf("%-18s %8.0f\n", rig.truth->name, SAWTOOTH_SECONDS / time_of_fixed_steps(&rig));
    }
}

static void measure(void)
{
    compare_costs();
    print_speeds();
    print_errors("Largest error of F over the largest F, %: ramps of 0.06 to 0.4 N/s",
                 rig_compare_ramps,
                 rig_compare_count);
    print_errors("The same: jumps of u within 5 ms", jumps, JUMPS_COUNT);
}

int main(void)
{
    UNITY_BEGIN(); // what the rig finds wrong ends the measurement
    RUN_TEST(measure);
    return UNITY_END();
}
