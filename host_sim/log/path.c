#include "log/path.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ROWS_MAX    200000u ///< most rows of the log that are played, counted from its start
#define BLOCK_S     0.02    ///< averaging time of residuals
#define ITERATIONS  10
#define LAG_START_S 0.02 ///< first guess of the lag of actuator and sensor
#define CREEP       1.5  ///< L divided by the friction of creeping slides
#define LAG_MAX_S   0.2
#define RATIO_MIN   1e-3
#define DONE        1e-3 ///< relative change of the sum of squares

enum
{
    SCALE,
    BIAS,
    RATIO,
    LAG,
    COUNT
};

typedef struct
{
    const sim_log_t   *log;
    const sim_model_t *model;
    unsigned char     *counts; ///< for each row; false until the model has surely forgotten its start
    size_t             rows, block;
    double             size_n;                           ///< size of F, the unit of the bias
    double            *played, *residual, *trial, *side; ///< for each row
    double            *slopes[COUNT];
    bool               is_free[COUNT];
} problem_t;

/// The relays at the start of a segment are unknown. A segment therefore counts from its third alternating slide on, or as a
/// whole if it has fewer.
static void choose_rows(problem_t *problem, const signed char *ways)
{
    const sim_log_t *log = problem->log;
    for (size_t s = 0; s < log->segments && log->starts[s] < problem->rows; s++)
    {
        const size_t end  = log->starts[s + 1] < problem->rows ? log->starts[s + 1] : problem->rows;
        size_t       from = log->starts[s];
        signed char  way  = 0;
        int          turn = 0;
        for (size_t k = from; k < end && turn < 3; k++)
        {
            turn += ways[k] != 0 && ways[k] != way;
            way  = ways[k] != 0 ? ways[k] : way;
            from = turn == 3 ? k : from;
        }
        for (size_t k = log->starts[s]; k < end; k++)
        {
            problem->counts[k] = k >= from;
        }
    }
}

/// Computes F minus the model's F, averaged over each row's block. If only the lag has changed, `play` is false.
static double residual_of(problem_t *problem, const sim_path_t *path, bool play, double *residual)
{
    const sim_log_t *log = problem->log;
    if (play)
    {
        problem->model->play(problem->model->context, log, problem->rows, path, problem->played);
    }
    const double keep = path->lag_s > 0.0 ? exp(-log->sample_time_s / path->lag_s) : 0.0;
    double       late = 0.0, sum = 0.0;
    for (size_t s = 0; s < log->segments && log->starts[s] < problem->rows; s++)
    {
        const size_t end = log->starts[s + 1] < problem->rows ? log->starts[s + 1] : problem->rows;
        late             = problem->played[log->starts[s]];
        for (size_t k = log->starts[s]; k < end; k++)
        {
            late        = problem->played[k] + keep * (late - problem->played[k]);
            residual[k] = problem->counts[k] ? log->values[SIM_LOG_F][k] - late : 0.0;
        }
    }
    for (size_t first = 0; first < problem->rows; first += problem->block)
    {
        const size_t size = problem->rows - first < problem->block ? problem->rows - first : problem->block;
        double       mean = 0.0;
        for (size_t k = first; k < first + size; k++)
        {
            mean += residual[k] / (double)size;
        }
        for (size_t k = first; k < first + size; k++)
        {
            residual[k] = mean;
        }
        sum += (double)size * mean * mean;
    }
    return sum;
}

static sim_path_t moved(const problem_t *problem, const sim_path_t *path, const double step[COUNT])
{
    return (sim_path_t){.scale_error = fmax(path->scale_error + step[SCALE], -0.9),
                        .bias_n      = path->bias_n + step[BIAS] * problem->size_n,
                        .ratio       = fmax(path->ratio * (1.0 + fmax(step[RATIO], -0.7)), RATIO_MIN),
                        .lag_s       = fmin(fmax(path->lag_s + step[LAG], 0.0), LAG_MAX_S)};
}

/// Solves a x = b. A row without a slope gives 0.
static void solve(double a[COUNT][COUNT], double b[COUNT], double x[COUNT])
{
    for (size_t i = 0; i < COUNT; i++)
    {
        for (size_t j = i + 1; j < COUNT && a[i][i] > 0.0; j++)
        {
            const double part = a[j][i] / a[i][i];
            for (size_t k = i; k < COUNT; k++)
            {
                a[j][k] -= part * a[i][k];
            }
            b[j] -= part * b[i];
        }
    }
    for (size_t i = COUNT; i-- > 0;)
    {
        x[i] = b[i];
        for (size_t k = i + 1; k < COUNT; k++)
        {
            x[i] -= a[i][k] * x[k];
        }
        x[i] = a[i][i] > 0.0 ? x[i] / a[i][i] : 0.0;
    }
}

/// Computes the slopes at `path`, whose F is in `played`. The slope of the lag comes first because it needs no new playing.
static void find_slopes(problem_t *problem, const sim_path_t *path)
{
    static const double steps[COUNT] = {[SCALE] = 0.005, [BIAS] = 0.003, [RATIO] = 0.01, [LAG] = 0.002};
    for (size_t i = COUNT; i-- > 0;)
    {
        double step[COUNT] = {0.0};
        step[i]            = problem->is_free[i] ? steps[i] : 0.0;
        if (problem->is_free[i])
        {
            const sim_path_t there = moved(problem, path, step);
            (void)residual_of(problem, &there, i != LAG, problem->side);
        }
        for (size_t k = 0; k < problem->rows; k++)
        {
            problem->slopes[i][k] = problem->is_free[i] ? (problem->residual[k] - problem->side[k]) / steps[i] : 0.0;
        }
    }
}

/// Takes one Gauss-Newton step, shortened if necessary. Returns false if no step reduces the cost.
static bool descend(problem_t *problem, sim_path_t *path, double *cost)
{
    double a[COUNT][COUNT] = {{0.0}}, b[COUNT] = {0.0};
    find_slopes(problem, path);
    for (size_t i = 0; i < COUNT; i++)
    {
        for (size_t k = 0; k < problem->rows; k++)
        {
            b[i] += problem->slopes[i][k] * problem->residual[k];
            for (size_t j = 0; j < COUNT; j++)
            {
                a[i][j] += problem->slopes[i][k] * problem->slopes[j][k];
            }
        }
    }
    for (double damping = 1e-3; damping < 20.0; damping *= 10.0)
    {
        double damped[COUNT][COUNT], right[COUNT], step[COUNT];
        memcpy(damped, a, sizeof a);
        memcpy(right, b, sizeof b);
        for (size_t i = 0; i < COUNT; i++)
        {
            damped[i][i] *= 1.0 + damping;
        }
        solve(damped, right, step);
        const sim_path_t there = moved(problem, path, step);
        const double     lower = residual_of(problem, &there, true, problem->trial);
        if (lower < *cost)
        {
            double *const before = problem->residual;
            const bool    is_far = lower < (1.0 - DONE) * *cost;
            problem->residual    = problem->trial;
            problem->trial       = before;
            *path                = there;
            *cost                = lower;
            return is_far;
        }
    }
    return false;
}

static double fit_from(problem_t *problem, sim_path_t *path)
{
    double cost = residual_of(problem, path, true, problem->residual);
    for (int i = 0; i < ITERATIONS && descend(problem, path, &cost); i++)
    {
    }
    return cost;
}

static void leave(problem_t *problem, const sim_path_t *path, double *left_n)
{
    problem->block = 1;
    (void)residual_of(problem, path, true, problem->residual);
    for (size_t k = 0; k < problem->log->rows; k++)
    {
        left_n[k] = k < problem->rows && problem->counts[k] ? problem->residual[k] : (double)NAN;
    }
}

bool sim_path_fit(sim_path_t        *path,
                  double            *left_n,
                  const sim_log_t   *log,
                  const sim_model_t *model,
                  const signed char *ways,
                  bool               is_scale_free,
                  common_error_t    *error)
{
    const size_t  rows    = log->rows < ROWS_MAX ? log->rows : ROWS_MAX;
    double *const room    = malloc((4u + COUNT) * rows * sizeof *room);
    problem_t     problem = {.log     = log,
                             .model   = model,
                             .rows    = rows,
                             .block   = (size_t)fmax(1.0, floor(BLOCK_S / log->sample_time_s + 0.5)),
                             .is_free = {[SCALE] = is_scale_free, [BIAS] = true, [RATIO] = true, [LAG] = true}};
    problem.counts        = malloc(rows);
    if (room == NULL || problem.counts == NULL)
    {
        free(room);
        free(problem.counts);
        return common_error_set(error, "out of memory");
    }
    choose_rows(&problem, ways);
    problem.played   = room;
    problem.residual = room + rows;
    problem.trial    = room + 2 * rows;
    problem.side     = room + 3 * rows;
    for (size_t i = 0; i < COUNT; i++)
    {
        problem.slopes[i] = room + (4 + i) * rows;
    }
    for (size_t k = 0; k < rows; k++)
    {
        problem.size_n = fmax(problem.size_n, fabs(log->values[SIM_LOG_F][k]));
    }
    const double     least    = fmax(path->ratio, RATIO_MIN);
    const sim_path_t starts[] = {{.scale_error = path->scale_error, .bias_n = path->bias_n, .ratio = least},
                                 {.scale_error = path->scale_error, .bias_n = path->bias_n, .ratio = CREEP * least},
                                 {.ratio = CREEP * least},
                                 {.ratio = 1.0}};
    double           best     = HUGE_VAL;
    for (size_t i = 0; i < sizeof starts / sizeof starts[0]; i++)
    {
        sim_path_t from   = starts[i];
        from.lag_s        = LAG_START_S;
        const double cost = fit_from(&problem, &from);
        *path             = cost < best ? from : *path;
        best              = fmin(cost, best);
    }
    leave(&problem, path, left_n);
    free(room);
    free(problem.counts);
    return true;
}
