#include "log/verdict.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#define BLOCK_S     0.02 ///< averaging time of F
#define NOISES      5.0  ///< half the width of the play, in standard deviations of an averaged F ...
#define RANGE_PART  1e-4 ///< ... plus this fraction of the range of F
#define RUN_IN_PART 0.01 ///< length of a slide before it counts, as a fraction of the range of F
#define LAG_S       0.03 ///< lag of actuator, arm and sensor together
#define LAG_MAX     0.1  ///< largest effect of the lag, as a fraction of n
#define AT_LIMIT    0.999
#define RATIO_LOW   0.8 ///< least friction of a slide divided by L; with true params a slow slide creeps at 0.85 and more
#define RATIO_HIGH  1.25
#define SCALE_OFF   0.05
#define UNITS_OFF   100.0
#define Q_FAST      50.0 ///< switches a second that are too many
#define LITTLE      0.02 ///< fraction of the log that is too little
#define SILENT      1e-6 ///< range of F divided by that of u, below which the sensor is silent

typedef struct
{
    double *force, *net; ///< means of the blocks
    size_t  count, size;
} blocks_t;

static int compare_numbers(const void *a, const void *b)
{
    double x, y;
    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    return (x > y) - (x < y);
}

static double median(double *x, size_t count)
{
    qsort(x, count, sizeof *x, compare_numbers);
    return count > 0 ? x[count / 2] : 0.0;
}

static bool make_blocks(blocks_t *blocks, const double *force, const float *n, size_t rows, double sample_time_s)
{
    const double size = floor(BLOCK_S / sample_time_s + 0.5);
    blocks->size      = size > 1.0 && (double)rows / size >= 20.0 ? (size_t)size : 1;
    blocks->count     = rows / blocks->size;
    blocks->force     = calloc(blocks->count + 1, sizeof *blocks->force);
    blocks->net       = calloc(blocks->count + 1, sizeof *blocks->net);
    for (size_t b = 0; blocks->force != NULL && blocks->net != NULL && b < blocks->count; b++)
    {
        for (size_t k = b * blocks->size; k < (b + 1) * blocks->size; k++)
        {
            blocks->force[b] += force[k] / (double)blocks->size;
            blocks->net[b] += (double)n[k] / (double)blocks->size;
        }
    }
    return blocks->force != NULL && blocks->net != NULL;
}

/// Estimates the noise of the averaged F from second differences, which cancel a slope.
static double noise_of(const blocks_t *blocks, double *room)
{
    for (size_t b = 2; b < blocks->count; b++)
    {
        room[b - 2] = fabs(blocks->force[b] - 2.0 * blocks->force[b - 1] + blocks->force[b - 2]);
    }
    return blocks->count > 2 ? median(room, blocks->count - 2) / (0.6745 * sqrt(6.0)) : 0.0;
}

static double range_of(const double *x, size_t count)
{
    double low = x[0], high = x[0];
    for (size_t k = 1; k < count; k++)
    {
        low  = fmin(low, x[k]);
        high = fmax(high, x[k]);
    }
    return high - low;
}

static void mark(const blocks_t *blocks, double half, double run_in, double sample_time_s, signed char *ways)
{
    double      play = blocks->force[0], distance = 0.0;
    signed char way = 0;
    for (size_t b = 1; b < blocks->count; b++)
    {
        const double force = blocks->force[b];
        const double to    = fmin(fmax(play, force - half), force + half);
        const double moved = to - play;
        play               = to;
        if (moved == 0.0)
        {
            continue;
        }
        const signed char now = moved > 0.0 ? 1 : -1;
        distance              = (now == way ? distance : 0.0) + fabs(moved);
        way                   = now;
        const double rate     = fabs(force - blocks->force[b - 1]) / ((double)blocks->size * sample_time_s);
        if (distance > run_in && rate * LAG_S < LAG_MAX * fabs(blocks->net[b]))
        {
            memset(ways + b * blocks->size, way, blocks->size);
        }
    }
}

bool sim_verdict_find_slides(const sim_log_t *log, const float *n, signed char *ways, common_error_t *error)
{
    memset(ways, 0, log->rows);
    for (size_t s = 0; s < log->segments; s++)
    {
        const size_t  first  = log->starts[s];
        const size_t  rows   = log->starts[s + 1] - first;
        const double *force  = log->values[SIM_LOG_F] + first;
        blocks_t      blocks = {.count = 0};
        const bool    made   = make_blocks(&blocks, force, n + first, rows, log->sample_time_s);
        double       *room   = malloc((blocks.count + 1) * sizeof *room);
        const bool    ok     = made && room != NULL;
        if (ok)
        {
            const double range = range_of(force, rows);
            const double half  = NOISES * noise_of(&blocks, room) + RANGE_PART * range;
            mark(&blocks, half, RUN_IN_PART * range + 2.0 * half, log->sample_time_s, ways + first);
        }
        free(room);
        free(blocks.force);
        free(blocks.net);
        if (!ok)
        {
            return common_error_set(error, "out of memory");
        }
    }
    return true;
}

/// Solves the symmetric a x = b of size n in place.
static bool solve(double a[3][3], double b[3], size_t n)
{
    for (size_t i = 0; i < n; i++)
    {
        if (!(a[i][i] > 1e-12))
        {
            return false;
        }
        for (size_t j = i + 1; j < n; j++)
        {
            const double part = a[j][i] / a[i][i];
            for (size_t k = i; k < n; k++)
            {
                a[j][k] -= part * a[i][k];
            }
            b[j] -= part * b[i];
        }
    }
    for (size_t i = n; i-- > 0;)
    {
        for (size_t k = i + 1; k < n; k++)
        {
            b[i] -= a[i][k] * b[k];
        }
        b[i] /= a[i][i];
    }
    return true;
}

/// Fits n to +-L, 1 and, if the forces differ enough, F; each is scaled to about 1.
static void fit(sim_verdict_t *verdict, const sim_log_t *log, const sim_replayed_t *replayed, const signed char *ways)
{
    const double *force = log->values[SIM_LOG_F];
    const double  size  = fmax(fmax(fabs(verdict->low_n), fabs(verdict->high_n)), 1e-12);
    double        least = 0.0;
    for (size_t k = 0; k < log->rows; k++)
    {
        least = ways[k] != 0 ? fmax(least, (double)replayed->L[k]) : least;
    }
    verdict->scale_is_fitted = verdict->high_n - verdict->low_n > 0.2 * size;
    const size_t columns     = verdict->scale_is_fitted ? 3 : 2;
    double       a[3][3] = {{0.0}}, b[3] = {0.0};
    for (size_t k = 0; k < log->rows; k++)
    {
        const double row[3] = {(double)ways[k] * (double)replayed->L[k] / least, 1.0, force[k] / size};
        for (size_t i = 0; ways[k] != 0 && i < columns; i++)
        {
            for (size_t j = 0; j < columns; j++)
            {
                a[i][j] += row[i] * row[j] / (double)verdict->moving;
            }
            b[i] += row[i] * (double)replayed->n[k] / (double)verdict->moving;
        }
    }
    verdict->is_fitted = solve(a, b, columns);
    if (verdict->is_fitted)
    {
        verdict->bias_n      = b[1];
        verdict->scale_error = columns == 3 ? b[2] / size : 0.0;
        verdict->ratio       = b[0] / least / (1.0 + verdict->scale_error);
    }
}

/// Computes the medians of the residuals of the line (in n) and of the path (in F), in the slides where both are known. An
/// rms would be dominated by the few rows around a reversal, which fit no line.
static bool compare(const sim_verdict_t  *verdict,
                    const sim_log_t      *log,
                    const sim_replayed_t *replayed,
                    const signed char    *ways,
                    const double         *by_path,
                    double                misfit_n[2])
{
    double *const left  = malloc(2u * log->rows * sizeof *left);
    size_t        count = 0;
    for (size_t k = 0; left != NULL && k < log->rows; k++)
    {
        if (ways[k] == 0 || isnan(by_path[k]))
        {
            continue;
        }
        const double L    = verdict->ratio * (1.0 + verdict->scale_error) * (double)replayed->L[k];
        const double line = (double)ways[k] * L + verdict->bias_n + verdict->scale_error * log->values[SIM_LOG_F][k];
        left[count]       = fabs((double)replayed->n[k] - line);
        left[log->rows + count] = fabs(by_path[k]);
        count++;
    }
    if (left != NULL)
    {
        misfit_n[0] = median(left, count);
        misfit_n[1] = median(left + log->rows, count);
    }
    free(left);
    return left != NULL;
}

/// Takes scale, bias and ratio from the model's path if it fits the slides better.
static bool try_path(sim_verdict_t        *verdict,
                     const sim_log_t      *log,
                     const sim_replayed_t *replayed,
                     const sim_model_t    *model,
                     const signed char    *ways,
                     common_error_t       *error)
{
    double        misfit_n[2] = {0.0};
    double *const left        = malloc(log->rows * sizeof *left);
    sim_path_t    path = {.scale_error = verdict->scale_error, .bias_n = verdict->bias_n, .ratio = verdict->ratio};
    if (left == NULL)
    {
        return common_error_set(error, "out of memory");
    }
    bool ok = sim_path_fit(&path, left, log, model, ways, verdict->scale_is_fitted, error);
    if (ok && !compare(verdict, log, replayed, ways, left, misfit_n))
    {
        ok = common_error_set(error, "out of memory");
    }
    free(left);
    verdict->is_by_path = ok && misfit_n[1] < misfit_n[0];
    if (verdict->is_by_path)
    {
        verdict->scale_error = path.scale_error;
        verdict->bias_n      = path.bias_n;
        verdict->ratio       = path.ratio;
    }
    return ok;
}

static int sign_of(double x)
{
    return (x > 0.0) - (x < 0.0);
}

/// Returns the sign of the hub's motion at a row: that of the speed, or of the change of position; 0 if unknown.
static int motion(const sim_log_t *log, size_t k)
{
    const double *x = log->values[SIM_LOG_X], *v = log->values[SIM_LOG_V];
    if (v != NULL)
    {
        return sign_of(v[k]);
    }
    return x != NULL && k > 0 ? sign_of(x[k] - x[k - 1]) : 0;
}

/// Counts the ticks that reveal L, and those in which friction opposes the motion.
static void count_slides(sim_verdict_t        *verdict,
                         const sim_log_t      *log,
                         const sim_replayed_t *replayed,
                         const signed char    *ways)
{
    const bool is_known = log->values[SIM_LOG_X] != NULL || log->values[SIM_LOG_V] != NULL;
    verdict->low_n      = HUGE_VAL;
    verdict->high_n     = -HUGE_VAL;
    for (size_t k = 0; k < log->rows; k++)
    {
        if (ways[k] == 0)
        {
            continue;
        }
        const double force = log->values[SIM_LOG_F][k];
        const int    way   = is_known ? motion(log, k) : ways[k];
        verdict->moving++;
        verdict->rising += ways[k] > 0;
        verdict->low_n  = fmin(verdict->low_n, force);
        verdict->high_n = fmax(verdict->high_n, force);
        verdict->has_motion += is_known && way != 0;
        verdict->against += way != 0 && (double)replayed->f[k] * (double)way >= 0.0;
    }
}

static void sum_up(sim_verdict_t *verdict, const sim_log_t *log, const sim_replayed_t *replayed)
{
    double net = 0.0, residual = 0.0;
    size_t at_limit = 0, switches = 0;
    for (size_t k = 0; k < log->rows; k++)
    {
        const double n = (double)replayed->n[k], e = n - (double)replayed->f[k];
        net += n * n;
        residual += e * e;
        verdict->net_peak_n      = fmax(verdict->net_peak_n, fabs(n));
        verdict->residual_peak_n = fmax(verdict->residual_peak_n, fabs(e));
        at_limit += fabs((double)replayed->f[k]) >= AT_LIMIT * (double)replayed->L[k];
        switches += k > 0 && replayed->q[k] != replayed->q[k - 1];
    }
    const double rows       = (double)log->rows;
    verdict->net_rms_n      = sqrt(net / rows);
    verdict->residual_rms_n = sqrt(residual / rows);
    verdict->limit_share    = (double)at_limit / rows;
    verdict->q_per_s        = (double)switches / (rows * log->sample_time_s);
}

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static void
say(sim_verdict_t *verdict, const char *format, ...)
{
    const size_t at = verdict->fault_count;
    if (at < sizeof verdict->words / sizeof verdict->words[0])
    {
        va_list args;
        va_start(args, format);
        (void)vsnprintf(verdict->words[at], sizeof verdict->words[at], format, args);
        va_end(args);
        verdict->fault_count++;
    }
}

/// Returns the correlation of the changes of u and F over `step` rows. If only signs count, all changes have the same weight.
static double correlation(const sim_log_t *log, size_t step, bool of_signs)
{
    const double *u = log->values[SIM_LOG_U], *force = log->values[SIM_LOG_F];
    double        uu = 0.0, uf = 0.0, ff = 0.0;
    for (size_t s = 0; s < log->segments; s++)
    {
        for (size_t k = log->starts[s] + step; k < log->starts[s + 1]; k += step)
        {
            const double by_u = u[k] - u[k - step], by_force = force[k] - force[k - step];
            const double du = of_signs ? sign_of(by_u) : by_u, df = of_signs ? sign_of(by_force) : by_force;
            uu += du * du;
            uf += du * df;
            ff += df * df;
        }
    }
    return uu > 0.0 && ff > 0.0 ? uf / sqrt(uu * ff) : 0.0;
}

/// Finds faults that hide all others. Returns true if there is one.
static bool find_gross(sim_verdict_t *verdict, const sim_log_t *log)
{
    const double u = range_of(log->values[SIM_LOG_U], log->rows), force = range_of(log->values[SIM_LOG_F], log->rows);
    if (!(force > SILENT * u))
    {
        say(verdict, "F does not move: the sensor is silent, or u stays within stiction; nothing can be said about L");
        return true;
    }
    if (force > UNITS_OFF * u || u > UNITS_OFF * force)
    {
        say(verdict,
            "units: F ranges over %.3g N and u over %.3g N; one of them is not in N (--unit u=mN, --unit F=mN)",
            force,
            u);
        return true;
    }
    // A hunting loop reduces u while F slips on, for a tenth of a second but not on average. The first ticks of a loop move u far
    // while F moves back: that is one large step, but few ticks of many.
    const size_t fast = (size_t)fmax(1.0, 0.1 / log->sample_time_s),
                 slow = fast > log->rows / 20 ? fast : log->rows / 20;
    if (correlation(log, fast, false) < -0.3 && correlation(log, slow, false) <= 0.0 &&
        correlation(log, slow, true) < 0.0)
    {
        say(verdict, "wrong sign: F falls where u rises (--scale u=- or --scale F=-)");
        return true;
    }
    return false;
}

static void find_faults(sim_verdict_t *verdict, bool is_measured)
{
    const size_t falling = verdict->moving - verdict->rising;
    if ((double)verdict->moving < LITTLE * (double)verdict->ticks)
    {
        say(verdict,
            "only %.2g %% of the log slides slowly enough to tell L: record slow triangles of u",
            100.0 * (double)verdict->moving / (double)verdict->ticks);
    }
    if (verdict->rising == 0 || falling == 0)
    {
        say(verdict, "F slides in one direction only: L cannot be told from scale and bias of u");
        return;
    }
    if (verdict->is_fitted && verdict->scale_error <= -1.0)
    {
        say(verdict, "wrong sign: F falls where u rises (--scale u=- or --scale F=-)");
        return;
    }
    if (verdict->is_fitted && verdict->ratio < 0.0)
    {
        say(verdict, "wrong sign: friction would push in the direction of F's motion (--scale u=- or --scale F=-)");
        return;
    }
    if (verdict->is_fitted && fabs(verdict->scale_error) > SCALE_OFF)
    {
        say(verdict,
            "wrong scale: u - F grows by %.3g N a newton of F in both directions; multiply u by %.3g (--scale u=...)",
            verdict->scale_error,
            1.0 / (1.0 + verdict->scale_error));
    }
    if (verdict->is_fitted && verdict->ratio < RATIO_LOW)
    {
        say(verdict, "L is %.2f times too large: the arm slides at %.2f of it", 1.0 / verdict->ratio, verdict->ratio);
    }
    if (verdict->is_fitted && verdict->ratio > RATIO_HIGH)
    {
        say(verdict, "L is too small: the arm slides at %.2f times L", verdict->ratio);
    }
    if (verdict->q_per_s > Q_FAST && !is_measured)
    {
        say(verdict, "Q switches %.0f times a second: the net force is noisy, or creeps", verdict->q_per_s);
    }
}

bool sim_verdict_make(sim_verdict_t        *verdict,
                      const sim_log_t      *log,
                      const sim_replayed_t *replayed,
                      const sim_model_t    *model,
                      common_error_t       *error)
{
    *verdict = (sim_verdict_t){.ticks = log->rows, .has_force = log->values[SIM_LOG_F] != NULL};
    sum_up(verdict, log, replayed);
    if (!verdict->has_force)
    {
        say(verdict, "the log has no force, so the compensator's estimate cannot be checked");
        return true;
    }
    signed char *ways = malloc(log->rows);
    if (ways == NULL)
    {
        return common_error_set(error, "out of memory");
    }
    bool ok = sim_verdict_find_slides(log, replayed->n, ways, error);
    if (ok)
    {
        count_slides(verdict, log, replayed, ways);
        if (verdict->moving > 0)
        {
            fit(verdict, log, replayed, ways);
        }
        if (!find_gross(verdict, log))
        {
            const bool has_sign = verdict->is_fitted && verdict->scale_error > -1.0 && verdict->ratio >= 0.0;
            ok                  = !has_sign || try_path(verdict, log, replayed, model, ways, error);
            find_faults(verdict, replayed->is_measured);
        }
    }
    free(ways);
    return ok;
}

void sim_verdict_write(const sim_verdict_t *verdict, const sim_log_t *log, FILE *file)
{
    const sim_log_report_t *report = &log->report;
    (void)fprintf(file,
                  "log       %zu rows in %zu file%s, %zu segment%s, %.6g s an interval\n",
                  report->rows_read,
                  report->files,
                  report->files == 1 ? "" : "s",
                  log->segments,
                  log->segments == 1 ? "" : "s",
                  log->sample_time_s);
    if (verdict->has_force)
    {
        (void)fprintf(file, "u - F     rms %.4g N, peak %.4g N\n", verdict->net_rms_n, verdict->net_peak_n);
        (void)fprintf(file, "less f    rms %.4g N, peak %.4g N\n", verdict->residual_rms_n, verdict->residual_peak_n);
    }
    (void)fprintf(file,
                  "f at L    %.3g %% of the ticks; Q switches %.3g times a second\n",
                  100.0 * verdict->limit_share,
                  verdict->q_per_s);
    if (verdict->has_force)
    {
        (void)fprintf(file,
                      "L         %.3g %% of the log can tell it: %zu ticks rising, %zu falling",
                      100.0 * (double)verdict->moving / (double)verdict->ticks,
                      verdict->rising,
                      verdict->moving - verdict->rising);
        (void)fprintf(file, verdict->moving > 0 ? ", F from %.4g to %.4g N\n" : "\n", verdict->low_n, verdict->high_n);
    }
    if (verdict->is_fitted)
    {
        (void)fprintf(file,
                      "sliding   at %.3f of L; friction opposes the motion in %.3g %% of these ticks",
                      verdict->ratio,
                      100.0 * (double)verdict->against /
                          (double)(verdict->has_motion > 0 ? verdict->has_motion : verdict->moving));
        (void)fprintf(file, "%s\n", verdict->has_motion > 0 ? " (by the log's motion)" : " (by F)");
        (void)fprintf(file, "u         bias %.4g N", verdict->bias_n);
        (void)fprintf(file, verdict->scale_is_fitted ? ", scale off by %.3g %%\n" : "\n", 100.0 * verdict->scale_error);
    }
    (void)fputs(verdict->fault_count == 0 ? "verdict   the params fit this log\n" : "", file);
    for (size_t i = 0; i < verdict->fault_count; i++)
    {
        (void)fprintf(file, "verdict   %s\n", verdict->words[i]);
    }
}
