// Prints what is promised in numbers beside what this build does. Not a test: the tests have the limits in them.
//
// Golden vectors: errors count on the rows where Q1, Q2 and Q agree. Where single precision switches a tick earlier or
// later they do not; "ticks apart" is the longest such stretch.

#include "scenario/runner.h"
#include "support/csv.h"
#include "tribo/force_loop_f32.h"
#include "tribo/paper_controller.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define SECTIONS TRIBO_PAPER_CONTROLLER_SECTION_COUNT

static void print_title(void)
{
    printf("%-52s %12s %12s\n", "", "measured", "target");
}

static void print_row(const char *what, double measured, const char *target)
{
    printf("%-52s %12.4g %12s\n", what, measured, target);
}

static void give_up(const char *why)
{
    fprintf(stderr, "tribo-bench: %s\n", why);
    exit(EXIT_FAILURE);
}

/// The cascade of tribo/paper_controller.h in double precision, fed with the error that the float one saw.
typedef struct
{
    double w1[SECTIONS], w2[SECTIONS];
    double largest_difference_n;
} double_controller_t;

static bool compare_controller(void *context, const sim_row_t *row, double part_done, sim_error_t *error)
{
    static const tribo_biquad_f32_section_t sections[SECTIONS] = TRIBO_PAPER_CONTROLLER_F32;

    double_controller_t *const controller = context;
    double                     x          = (double)row->loop.e_n;
    (void)part_done;
    (void)error;
    for (unsigned i = 0; i < SECTIONS; i++)
    {
        const tribo_biquad_f32_section_t *const s = &sections[i];
        const double                            y = (double)s->b0 * x + controller->w1[i];

        controller->w1[i] += (double)s->b1 * x - (double)s->a1 * y + controller->w2[i];
        controller->w2[i] += (double)s->b2 * x - (double)s->a2 * y;
        x = y;
    }
    controller->largest_difference_n =
        fmax(controller->largest_difference_n, fabs(x - (double)row->loop.controller.v_n));
    return true;
}

static sim_summary_t run_triangle(const char *gain, double_controller_t *controller)
{
    sim_error_t           error    = {0};
    sim_summary_t         summary  = {0};
    sim_scenario_t *const scenario = sim_scenario_create();

    if (scenario == NULL || !sim_scenario_load(scenario, TRIBO_SCENARIO_DIR "/triangle.yaml", &error) ||
        !sim_scenario_set(scenario, gain, &error) || !sim_scenario_check(scenario, &error) ||
        !sim_run(scenario, NULL, controller != NULL ? compare_controller : NULL, controller, &summary, &error))
    {
        give_up(error.text);
    }
    sim_scenario_destroy(scenario);
    return summary;
}

typedef struct
{
    double   f_n, force_n; ///< largest errors
    unsigned agree;        ///< rows with the same logic
    unsigned apart;        ///< longest stretch of others
} golden_result_t;

static golden_result_t play_golden(const char *name, const tribo_compensator_f32_config_t *config, bool whole)
{
    const sim_csv_column_t columns[] = {{.name = "u_N"},
                                        {.name = whole ? "F_hat_N" : "F_N"},
                                        {.name = "Q1"},
                                        {.name = "Q2"},
                                        {.name = "Q"},
                                        {.name = "f_N"}};

    char                            path[512];
    sim_csv_t                       csv;
    sim_error_t                     error = {0};
    tribo_compensator_f32_params_t  params;
    tribo_compensator_f32_state_t   state;
    tribo_compensator_f32_signals_t seen;
    golden_result_t                 result  = {0};
    unsigned                        stretch = 0;

    (void)snprintf(path, sizeof path, "%s/%s.csv", TRIBO_GOLDEN_DIR, name);
    if (!sim_csv_read(&csv, path, columns, sizeof columns / sizeof columns[0], &error))
    {
        give_up(error.text);
    }
    if (tribo_compensator_f32_init(&params, config, 1.0e-3f) != TRIBO_OK)
    {
        give_up(name);
    }
    tribo_compensator_f32_reset(&state);
    for (size_t i = 0; i < csv.rows; i++)
    {
        const float u = (float)csv.values[0][i];
        if (whole)
        {
            (void)tribo_compensator_f32_step(&params, &state, u, &seen);
        }
        else
        {
            (void)
                tribo_friction_f32_step(&params.friction, &state.friction, u, (float)csv.values[1][i], &seen.friction);
        }
        if ((csv.values[2][i] != 0.0) == ((seen.friction.relays & TRIBO_RELAY_Q1) != 0u) &&
            (csv.values[3][i] != 0.0) == ((seen.friction.relays & TRIBO_RELAY_Q2) != 0u) &&
            (csv.values[4][i] != 0.0) == ((seen.friction.relays & TRIBO_RELAY_Q) != 0u))
        {
            stretch = 0;
            result.agree++;
            result.f_n = fmax(result.f_n, fabs((double)seen.friction.f_n - csv.values[5][i]));
            if (whole)
            {
                result.force_n = fmax(result.force_n, fabs((double)seen.force_n - csv.values[1][i]));
            }
        }
        else
        {
            stretch++;
            result.apart = stretch > result.apart ? stretch : result.apart;
        }
    }
    sim_csv_free(&csv);
    return result;
}

static void print_golden(const char *name, const tribo_compensator_f32_config_t *config, bool whole)
{
    const golden_result_t result = play_golden(name, config, whole);

    printf("golden %s, logic agrees on %u rows\n", name, result.agree);
    print_row("    largest error of f, N", result.f_n, whole ? "5e-5" : "2e-5");
    if (whole)
    {
        print_row("    largest error of F^, N", result.force_n, "5e-5");
    }
    print_row("    logic switches, ticks apart", (double)result.apart, "2");
}

int main(void)
{
    const tribo_compensator_f32_config_t paper      = tribo_compensator_f32_paper();
    tribo_compensator_f32_config_t       asymmetric = paper;
    tribo_compensator_f32_config_t       k1p1       = paper;
    double_controller_t                  controller = {0};

    asymmetric.friction.positive  = (tribo_breakaway_f32_t){0.01f, 0.25f};
    asymmetric.friction.negative  = (tribo_breakaway_f32_t){0.005f, 0.35f};
    asymmetric.friction.gravity_n = 0.004f;
    k1p1.friction.k_min           = 1.1f;
    k1p1.friction.k_max           = 1.1f;

    print_title();
    print_row("triangle, gain 0, RMS of r - F, N",
              run_triangle("compensator.gain=0", NULL).result.rms_error_n,
              "0.003858");
    print_row("triangle, gain 0.85, RMS of r - F, N",
              run_triangle("compensator.gain=0.85", NULL).result.rms_error_n,
              "0.001068");
    (void)run_triangle("compensator.gain=0.85", &controller);
    print_row("controller against double, 60 s of triangle, N", controller.largest_difference_n, "5e-5");
    print_golden("friction_paper", &paper, false);
    print_golden("friction_asymmetric_gravity", &asymmetric, false);
    print_golden("friction_k1p1", &k1p1, false);
    print_golden("compensator_paper", &paper, true);
    print_golden("compensator_asymmetric_gravity", &asymmetric, true);
    print_row("state + params of one axis on this machine, bytes",
              (double)(sizeof(tribo_force_loop_f32_params_t) + sizeof(tribo_force_loop_f32_state_t)),
              "400");
    return 0;
}
