#include "log/log.h"

#include "support/csv.h"
#include "support/number.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define JITTER    0.01       ///< largest deviation of an even interval, as a fraction
#define GAP       1.5        ///< a step of more intervals is a gap
#define GAP_MAX   10.0       ///< intervals bridged by default
#define STRAY_MAX 3u         ///< rows in succession with a stray stamp; with more the clock has begun anew
#define ROWS_MAX  50000000.0 ///< of a resampled log
#define BETWEEN_S 1.0        ///< time inserted between files with overlapping stamps
#define WHY_SIZE  200u       ///< of an option that requires a column, as a message shows it

static const char *const role_words[SIM_LOG_ROLES] = {"t", "u", "F", "x", "v", "r"};
static const char *const role_names[SIM_LOG_ROLES] = {"t_s", "u_N", "F_N", "x_deg", "w_deg_per_s", "r_N"};
static const char *const role_units[SIM_LOG_ROLES] = {"s", "N", "N", "deg", "deg/s", "N"};

typedef struct
{
    const char *name;
    const char *roles; ///< letters of the roles that may have this unit
    double      factor;
    bool        is_torque;
} unit_t;

// clang-format off: one row a unit
static const unit_t units[] = {
    {"s", "t", 1.0, false}, {"ms", "t", 1e-3, false}, {"us", "t", 1e-6, false}, {"ns", "t", 1e-9, false}, {"min", "t", 60.0, false},
    {"N", "uFr", 1.0, false}, {"mN", "uFr", 1e-3, false}, {"kN", "uFr", 1e3, false},
    {"N m", "uFr", 1.0, true}, {"Nm", "uFr", 1.0, true}, {"mN m", "uFr", 1e-3, true}, {"mNm", "uFr", 1e-3, true}, {"A", "uFr", 1.0, true},
    {"bar", "F", 1.0, true}, {"V", "uFr", 1.0, true},
    {"deg", "x", 1.0, false}, {"rad", "x", 57.295779513082323, false}, {"m", "x", 1.0, false}, {"mm", "x", 1.0, false},
    {"deg/s", "v", 1.0, false}, {"rad/s", "v", 57.295779513082323, false}, {"m/s", "v", 1.0, false}, {"mm/s", "v", 1.0, false}};
// clang-format on

#define UNITS (sizeof units / sizeof units[0])

/// Returns the column, and the text after the `=` in `*value`; null with the error filled in.
static sim_log_column_t *split(sim_log_options_t *options,
                               const char        *option,
                               const char        *text,
                               const char       **value,
                               common_error_t    *error)
{
    for (size_t i = 0; i < SIM_LOG_ROLES; i++)
    {
        if (text[0] == role_words[i][0] && text[1] == '=' && text[2] != '\0')
        {
            *value                     = text + 2;
            options->columns[i].option = option;
            options->columns[i].text   = text;
            return &options->columns[i];
        }
    }
    (void)common_error_set(error, "--%s %s: t, u, F, x, v or r, then = and a value are expected", option, text);
    return NULL;
}

bool sim_log_set_column(sim_log_options_t *options, const char *text, common_error_t *error)
{
    const char       *value  = NULL;
    sim_log_column_t *column = split(options, "column", text, &value, error);
    if (column != NULL && value[0] == '#' && (value[1] == '\0' || value[1 + strspn(value + 1, "0123456789")] != '\0'))
    {
        return common_error_set(error, "--column %s: a number of 1 or more is expected after #", text);
    }
    if (column != NULL)
    {
        column->name = value;
    }
    return column != NULL;
}

bool sim_log_set_unit(sim_log_options_t *options, const char *text, common_error_t *error)
{
    const char       *value  = NULL;
    sim_log_column_t *column = split(options, "unit", text, &value, error);
    for (size_t i = 0; column != NULL && i < UNITS; i++)
    {
        if (strcmp(value, units[i].name) == 0 && strchr(units[i].roles, text[0]) != NULL)
        {
            column->unit      = units[i].factor;
            column->is_torque = units[i].is_torque;
            return true;
        }
    }
    return column != NULL && common_error_set(error,
                                              "--unit %s: units are s, ms, us, ns, min for t; N, mN, kN, N m, mN m, A, "
                                              "V for u, F and r, also bar for F; "
                                              "deg, rad, m, mm for x, and these with /s for v",
                                              text);
}

static bool set_number(double *number, const char *option, const char *text, const char *value, common_error_t *error)
{
    const char *complaint = common_number_parse(value, number);
    if (complaint == NULL && fabs(*number) > 1e9)
    {
        complaint = "is outside -1e9 to 1e9";
    }
    return complaint == NULL || common_error_set(error, "--%s %s: '%s' %s", option, text, value, complaint);
}

bool sim_log_set_scale(sim_log_options_t *options, const char *text, common_error_t *error)
{
    const char       *value  = NULL;
    sim_log_column_t *column = split(options, "scale", text, &value, error);
    if (column == NULL)
    {
        return false;
    }
    if (strcmp(value, "-") == 0)
    {
        column->scale = -1.0;
        return true;
    }
    return set_number(&column->scale, "scale", text, value, error) &&
           (column->scale != 0.0 || common_error_set(error, "--scale %s: 0 is outside its range", text));
}

bool sim_log_set_bias(sim_log_options_t *options, const char *text, common_error_t *error)
{
    const char       *value  = NULL;
    sim_log_column_t *column = split(options, "bias", text, &value, error);
    return column != NULL && set_number(&column->bias, "bias", text, value, error);
}

static int compare_numbers(const void *a, const void *b)
{
    double x, y;
    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    return (x > y) - (x < y);
}

/// Returns the median interval, which gaps hardly affect; negative if there is no memory.
static double median_interval(const double *t, size_t rows)
{
    const size_t count     = rows - 1;
    double      *intervals = malloc(rows * sizeof *intervals);
    if (intervals == NULL)
    {
        return -1.0;
    }
    for (size_t i = 0; i < count; i++)
    {
        intervals[i] = t[i + 1] - t[i];
    }
    qsort(intervals, count, sizeof *intervals, compare_numbers);
    const double median = intervals[count / 2];
    free(intervals);
    return median;
}

static double value_of(const sim_log_column_t *column, double field)
{
    const double unit  = (column->unit != 0.0) ? column->unit : 1.0;
    const double scale = (column->scale != 0.0) ? column->scale : 1.0;
    return unit == 1.0 && scale == 1.0 && column->bias == 0.0 ? field : scale * (unit * field) + column->bias;
}

/// Takes over the reader's count of broken rows and its message about them.
static void note_left_out(sim_log_report_t *report, common_csv_t *csv)
{
    report->left_out += csv->left_out;
    if (report->left_out_first == NULL)
    {
        report->left_out_first = csv->left_out_first;
        csv->left_out_first    = NULL;
    }
}

/// Refuses a column whose unit the log names and no option confirms: a force in mN would otherwise be read a thousand times
/// too large.
static bool check_unit(const common_csv_t *csv, size_t role, const sim_log_column_t *column, common_error_t *error)
{
    if (csv->values[role] == NULL || column->unit != 0.0 || column->scale != 0.0)
    {
        return true;
    }
    for (size_t i = 0; i < UNITS; i++)
    {
        const unit_t *const unit = &units[i];
        if ((unit->factor != 1.0 || unit->is_torque) && strcmp(csv->units[role], unit->name) == 0 &&
            strchr(unit->roles, role_words[role][0]) != NULL)
        {
            return common_error_set(
                error,
                "%s: column %s is in %s: confirm this by --unit %s=%s%s%s%s, or give --unit %s=%s if it is not",
                csv->name,
                column->name != NULL ? column->name : role_names[role],
                unit->name,
                role_words[role],
                unit->name,
                unit->is_torque ? " --scale " : "",
                unit->is_torque ? role_words[role] : "",
                unit->is_torque ? "=NEWTON" : "",
                role_words[role],
                role_units[role]);
        }
    }
    return true;
}

/// Reads one file as a log of one segment, not yet resampled.
static bool read_file(sim_log_t               *log,
                      const char              *path,
                      const sim_log_options_t *options,
                      common_csv_t            *csv,
                      common_error_t          *error)
{
    common_csv_column_t columns[SIM_LOG_ROLES + 1];
    char                why[SIM_LOG_ROLES][WHY_SIZE];
    for (size_t i = 0; i < SIM_LOG_ROLES; i++)
    {
        const sim_log_column_t *column = &options->columns[i];
        const bool              required =
            column->option != NULL || i == SIM_LOG_T || (i == SIM_LOG_U && !options->command_optional);
        columns[i] =
            (common_csv_column_t){.name = column->name != NULL ? column->name : role_names[i], .optional = !required};
        if (column->option != NULL && column->name == NULL)
        {
            (void)snprintf(why[i], WHY_SIZE, "--%s %s: ", column->option, column->text);
            columns[i].why = why[i];
        }
    }
    // A trace has the true force and that of the sensor. Take the true one if present.
    const bool either          = options->columns[SIM_LOG_F].name == NULL;
    columns[SIM_LOG_F].or_else = either ? SIM_LOG_ROLES : 0;
    columns[SIM_LOG_ROLES]     = (common_csv_column_t){.name = "y_N", .optional = true};
    if (!common_csv_read(csv, path, columns, SIM_LOG_ROLES + (either ? 1u : 0u), true, error))
    {
        return false;
    }
    if (csv->values[SIM_LOG_F] == NULL && either)
    {
        csv->values[SIM_LOG_F]     = csv->values[SIM_LOG_ROLES];
        csv->values[SIM_LOG_ROLES] = NULL;
        memcpy(csv->units[SIM_LOG_F], csv->units[SIM_LOG_ROLES], COMMON_CSV_UNIT_MAX);
    }
    for (size_t i = 0; i < SIM_LOG_ROLES; i++)
    {
        if (!check_unit(csv, i, &options->columns[i], error))
        {
            return false;
        }
    }
    if (csv->rows < 2)
    {
        return common_csv_complain(csv,
                                   0,
                                   error,
                                   "%s: one row gives no sample time; at least two are expected",
                                   columns[0].name);
    }
    log->rows = csv->rows;
    for (size_t i = 0; i < SIM_LOG_ROLES; i++)
    {
        for (size_t k = 0; csv->values[i] != NULL && k < csv->rows; k++)
        {
            csv->values[i][k] = value_of(&options->columns[i], csv->values[i][k]);
        }
        log->values[i] = csv->values[i];
    }
    return true;
}

typedef struct
{
    double stamp;
    size_t row;
} stamp_t;

static int compare_stamps(const void *a, const void *b)
{
    stamp_t x, y;
    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    return x.stamp != y.stamp ? (x.stamp > y.stamp) - (x.stamp < y.stamp) : (x.row > y.row) - (x.row < y.row);
}

/// Puts the rows in the order of their stamps.
static bool put_in_order(sim_log_t *file, common_error_t *error)
{
    stamp_t   *order = malloc(file->rows * sizeof *order);
    double    *room  = malloc(file->rows * sizeof *room);
    const bool ok    = order != NULL && room != NULL;
    for (size_t k = 0; ok && k < file->rows; k++)
    {
        order[k] = (stamp_t){file->values[SIM_LOG_T][k], k};
    }
    if (ok)
    {
        qsort(order, file->rows, sizeof *order, compare_stamps);
    }
    for (size_t i = 0; ok && i < SIM_LOG_ROLES; i++)
    {
        for (size_t k = 0; file->values[i] != NULL && k < file->rows; k++)
        {
            room[k] = file->values[i][order[k].row];
        }
        if (file->values[i] != NULL)
        {
            memcpy(file->values[i], room, file->rows * sizeof *room);
        }
    }
    free(order);
    free(room);
    return ok || common_error_set(error, "out of memory");
}

/// How the stamps run from row to row.
typedef struct
{
    size_t back, repeated,
        first;      ///< rows whose stamp is less than, or equal to, the one before; the first of these rows
    double largest; ///< largest step back
} order_t;

static order_t order_of(const double *t, size_t rows)
{
    order_t order = {.first = rows};
    for (size_t k = rows - 1; k > 0; k--)
    {
        const double step = t[k] - t[k - 1];
        order.back += step < 0.0;
        order.repeated += step == 0.0;
        order.largest = fmax(order.largest, -step);
        order.first   = !(step > 0.0) ? k : order.first;
    }
    return order;
}

/// Returns how many rows around row `at`, whose stamp goes back, are stray: without them the stamps go on. The first of them is
/// `*first`. Returns 0 if there are more than STRAY_MAX.
static size_t find_stray(const double *t, size_t rows, size_t at, size_t *first)
{
    for (size_t count = 1; count <= STRAY_MAX; count++)
    {
        for (int may_be_outer = 0; may_be_outer < 2; may_be_outer++)
        {
            for (size_t before = count + 1; before-- > 0;)
            {
                const size_t begin = at - before, end = begin + count; // wraps if there are not so many
                const bool   is_outer = begin == 0 || end == rows;
                *first                = begin;
                if (begin <= at && end <= rows && (is_outer ? may_be_outer == 1 : t[end] > t[begin - 1]))
                {
                    return count;
                }
            }
        }
    }
    return 0;
}

/// Refuses the stamp of row `at`, which goes far back.
static bool complain_of_jump(const common_csv_t *csv,
                             const double       *t,
                             size_t              rows,
                             size_t              at,
                             const char         *name,
                             common_error_t     *error)
{
    size_t       first = at;
    const size_t count = find_stray(t, rows, at, &first);
    if (count == 0)
    {
        return common_csv_complain(csv,
                                   at,
                                   error,
                                   "%s: goes back by %.6g s, to %.6g s: the clock begins anew here; split the log "
                                   "here and pass both files as one experiment",
                                   name,
                                   t[at - 1] - t[at],
                                   t[at]);
    }
    const bool  is_outer = first == 0 || first + count == rows;
    const char *where    = first == 0 ? "after" : is_outer ? "before" : "before and after";
    const char *then     = is_outer ? "" : "; --resample then bridges the gap";
    return count == 1 ? common_csv_complain(csv,
                                            first,
                                            error,
                                            "%s: %.6g s is far from the stamps %s it: remove this row%s",
                                            name,
                                            t[first],
                                            where,
                                            then)
                      : common_csv_complain(
                            csv,
                            first,
                            error,
                            "%s: %zu stamps from %.6g s on are far from those %s them: remove these %zu rows%s",
                            name,
                            count,
                            t[first],
                            where,
                            count,
                            then);
}

/// Refuses stamps that begin anew or run backwards; without --resample also those that --resample repairs.
static bool check_order(sim_log_report_t   *report,
                        sim_log_t          *file,
                        const common_csv_t *csv,
                        const char         *name,
                        bool                resample,
                        common_error_t     *error)
{
    const double *t     = file->values[SIM_LOG_T];
    const order_t order = order_of(t, file->rows);
    const size_t  k     = order.first;
    if (order.back + order.repeated == 0)
    {
        return true;
    }
    const double span = fmax(fabs(t[file->rows - 1] - t[0]), order.largest);
    const double far  = GAP_MAX * span / (double)file->rows; // GAP_MAX intervals if stamps seldom go back
    if (2 * order.back > file->rows && file->rows > 2)
    {
        return common_csv_complain(csv, k, error, "%s: falls from row to row: the log runs backwards", name);
    }
    for (size_t i = k; i < file->rows; i++)
    {
        if (t[i - 1] - t[i] > far)
        {
            return complain_of_jump(csv, t, file->rows, i, name, error);
        }
    }
    if (!resample)
    {
        return common_csv_complain(
            csv,
            k,
            error,
            "%s: %.15g does not come after %.15g; %zu stamps appear twice, %zu go back (--resample repairs this)",
            name,
            t[k],
            t[k - 1],
            order.repeated,
            order.back);
    }
    report->moved_rows += order.back;
    return order.back == 0 || put_in_order(file, error);
}

/// Keeps only the first of rows with equal stamps.
static size_t drop_repeated(sim_log_t *log)
{
    const double *t    = log->values[SIM_LOG_T];
    size_t        kept = 1;
    for (size_t k = 1; k < log->rows; k++)
    {
        if (t[k] != t[kept - 1])
        {
            for (size_t i = 0; i < SIM_LOG_ROLES; i++)
            {
                if (log->values[i] != NULL)
                {
                    log->values[i][kept] = log->values[i][k];
                }
            }
            kept++;
        }
    }
    const size_t dropped = log->rows - kept;
    log->rows            = kept;
    return dropped;
}

static bool is_even(double interval, double median)
{
    return fabs(interval - median) <= JITTER * median;
}

static void judge_stamps(sim_log_report_t *report, const double *t, size_t rows, double median)
{
    for (size_t k = 1; k < rows; k++)
    {
        const double interval = t[k] - t[k - 1];
        report->gaps += interval > GAP * median;
        report->jittery += !is_even(interval, median);
        report->largest_s = fmax(report->largest_s, interval);
    }
}

/// Returns half a unit of the last place of a stamp in the file, in s.
static double rounding_of(const common_csv_t *csv, const sim_log_column_t *column, double stamp)
{
    const double unit = value_of(column, 1.0) - column->bias;
    return fabs(unit) * common_csv_rounding(csv, (stamp - column->bias) / unit);
}

/// Finds an even clock whose stamps were rounded when written; replaces the file's stamps with its own and returns its interval.
/// Returns false if the stamps are even as they are, or more uneven than rounding explains. A last place of more than half an
/// interval would hide a missing row.
static bool take_off_rounding(sim_log_t              *file,
                              const common_csv_t     *csv,
                              const sim_log_column_t *column,
                              double                 *interval,
                              double                 *last_place)
{
    double      *t      = file->values[SIM_LOG_T];
    const double rows   = (double)file->rows;
    const double middle = 0.5 * (rows - 1.0);
    double       mean   = t[0];
    double       slope  = 0.0;
    for (size_t k = 0; k < file->rows; k++)
    {
        mean += (t[k] - t[0]) / rows;
        slope += ((double)k - middle) * (t[k] - t[0]) * 12.0 / (rows * (rows * rows - 1.0));
    }
    *last_place = 2.0 * fmax(rounding_of(csv, column, t[0]), rounding_of(csv, column, t[file->rows - 1]));
    if (!(*last_place > JITTER * slope && *last_place <= 0.5 * slope))
    {
        return false;
    }
    for (size_t k = 0; k < file->rows; k++)
    {
        const double off = t[k] - (mean + ((double)k - middle) * slope);
        if (!(fabs(off) <= rounding_of(csv, column, t[k]) + 0.5 * *last_place)) // rounding also moves the line
        {
            return false;
        }
    }
    for (size_t k = 0; k < file->rows; k++)
    {
        t[k] = mean + ((double)k - middle) * slope;
    }
    *interval = slope;
    return true;
}

/// Returns the first row whose interval to the row before is uneven; `rows` if there is none.
static size_t first_uneven(const double *t, size_t rows, double median)
{
    size_t k = 1;
    while (k < rows && is_even(t[k] - t[k - 1], median))
    {
        k++;
    }
    return k;
}

/// Refuses uneven stamps.
static bool check_even(const common_csv_t *csv, const char *name, double median, common_error_t *error)
{
    const double *t = csv->values[SIM_LOG_T];
    const size_t  k = first_uneven(t, csv->rows, median);
    return k == csv->rows ||
           common_csv_complain(
               csv,
               k,
               error,
               "%s: %.6g s after the row before, where the log's interval is %.6g s (--resample repairs this)",
               name,
               t[k] - t[k - 1],
               median);
}

/// Returns the number of rows missing between even stamps if the reader has left out as many or more; otherwise 0.
static size_t missing_rows(const double *t, size_t rows, double median, size_t left_out)
{
    double missing = 0.0;
    for (size_t k = 1; k < rows; k++)
    {
        const double interval = t[k] - t[k - 1], steps = floor(interval / median + 0.5);
        if (!(fabs(interval - steps * median) <= JITTER * median) || steps > GAP_MAX)
        {
            return 0;
        }
        missing += steps - 1.0;
    }
    return missing <= (double)left_out ? (size_t)missing : 0;
}

static bool grow(double **values, size_t rows, common_error_t *error)
{
    double *larger = realloc(*values, rows * sizeof **values);
    if (larger == NULL)
    {
        return common_error_set(error, "out of memory");
    }
    *values = larger;
    return true;
}

/// Makes room for `rows` more rows in each column of the file.
static bool make_room(sim_log_t *log, const sim_log_t *file, size_t rows, common_error_t *error)
{
    for (size_t i = 0; i < SIM_LOG_ROLES; i++)
    {
        if (file->values[i] != NULL && !grow(&log->values[i], log->rows + rows, error))
        {
            return false;
        }
    }
    return true;
}

static bool begin_segment(sim_log_t *log, common_error_t *error)
{
    size_t *starts = realloc(log->starts, (log->segments + 2) * sizeof *starts);
    if (starts == NULL)
    {
        return common_error_set(error, "out of memory");
    }
    log->starts                  = starts;
    log->starts[log->segments++] = log->rows;
    return true;
}

/// Resamples rows `first` to `last` of the file to the grid of the log, as a segment.
static bool resample_run(sim_log_t       *log,
                         const sim_log_t *file,
                         size_t           first,
                         size_t           last,
                         double           by_s,
                         const char      *path,
                         common_error_t  *error)
{
    const double *t      = file->values[SIM_LOG_T];
    const double  h      = log->sample_time_s;
    const double  span_s = t[last] - t[first];
    const double  length = floor(span_s / h + 1e-6) + 1.0;
    const size_t  rows   = length < ROWS_MAX ? (size_t)length : 0;
    if (rows == 0 || log->rows + rows > (size_t)ROWS_MAX)
    {
        return common_error_set(
            error,
            "%s: %.6g s at --resample=%.6g are %.3g rows, and a log may have %.0f: --resample=%.3g makes fewer",
            path,
            span_s,
            h,
            length + (double)log->rows,
            ROWS_MAX,
            2.0 * h * (length + (double)log->rows) / ROWS_MAX);
    }
    if (rows < 2)
    {
        return true; // a single row between two gaps
    }
    if (!begin_segment(log, error) || !make_room(log, file, rows, error))
    {
        return false;
    }
    size_t k = first;
    for (size_t j = 0; j < rows; j++)
    {
        const double at = fmin(t[first] + (double)j * h, t[last]);
        while (k + 1 < last && t[k + 1] <= at)
        {
            k++;
        }
        const double part = (at - t[k]) / (t[k + 1] - t[k]);
        for (size_t i = 0; i < SIM_LOG_ROLES; i++)
        {
            const double *x = file->values[i];
            if (x != NULL)
            {
                log->values[i][log->rows + j] = i == SIM_LOG_T ? at + by_s : x[k] + part * (x[k + 1] - x[k]);
            }
        }
    }
    log->rows += rows;
    return true;
}

static bool append_resampled(sim_log_t       *log,
                             const sim_log_t *file,
                             double           gap_s,
                             double           by_s,
                             const char      *path,
                             common_error_t  *error)
{
    const double *t     = file->values[SIM_LOG_T];
    size_t        first = 0;
    for (size_t k = 1; k <= file->rows; k++)
    {
        if (k == file->rows || t[k] - t[k - 1] > gap_s)
        {
            log->report.splits += k < file->rows;
            if (!resample_run(log, file, first, k - 1, by_s, path, error))
            {
                return false;
            }
            first = k;
        }
    }
    return true;
}

static bool append(sim_log_t *log, const sim_log_t *file, double by_s, common_error_t *error)
{
    if (!begin_segment(log, error) || !make_room(log, file, file->rows, error))
    {
        return false;
    }
    for (size_t i = 0; i < SIM_LOG_ROLES; i++)
    {
        for (size_t k = 0; file->values[i] != NULL && k < file->rows; k++)
        {
            log->values[i][log->rows + k] = file->values[i][k] + (i == SIM_LOG_T ? by_s : 0.0);
        }
    }
    log->rows += file->rows;
    return true;
}

/// Returns the shift that puts a file's stamps after those of the log so far.
static double shift_of(sim_log_t *log, const sim_log_t *file)
{
    const double start = file->values[SIM_LOG_T][0];
    if (log->rows == 0 || start > log->values[SIM_LOG_T][log->rows - 1])
    {
        return 0.0;
    }
    log->report.moved++;
    return log->values[SIM_LOG_T][log->rows - 1] + BETWEEN_S - start;
}

/// Checks that the stamps rise, and finds their interval. `missing` rows, which were broken, are bridged later.
static bool find_interval(sim_log_t               *log,
                          sim_log_t               *file,
                          common_csv_t            *csv,
                          const sim_log_options_t *options,
                          double                  *median,
                          size_t                  *missing,
                          common_error_t          *error)
{
    const char *name =
        options->columns[SIM_LOG_T].name != NULL ? options->columns[SIM_LOG_T].name : role_names[SIM_LOG_T];
    if (file->values[SIM_LOG_T][0] == file->values[SIM_LOG_T][file->rows - 1] &&
        order_of(file->values[SIM_LOG_T], file->rows).repeated + 1 == file->rows)
    {
        return common_error_set(error, "%s: all stamps are the same", csv->name);
    }
    if (!check_order(&log->report, file, csv, name, options->resample, error))
    {
        return false;
    }
    log->report.repeated += drop_repeated(file);
    *median = median_interval(file->values[SIM_LOG_T], file->rows);
    if (*median < 0.0)
    {
        return common_error_set(error, "out of memory");
    }
    double last_place = 0.0;
    if (first_uneven(file->values[SIM_LOG_T], file->rows, *median) < file->rows &&
        take_off_rounding(file, csv, &options->columns[SIM_LOG_T], median, &last_place))
    {
        log->report.last_place_s = last_place;
    }
    judge_stamps(&log->report, file->values[SIM_LOG_T], file->rows, *median);
    *missing = options->resample ? 0 : missing_rows(file->values[SIM_LOG_T], file->rows, *median, csv->left_out);
    return options->resample || *missing > 0 || check_even(csv, name, *median, error);
}

static bool add_file(sim_log_t *log, const char *path, const sim_log_options_t *options, common_error_t *error)
{
    sim_log_t    file    = {.rows = 0};
    common_csv_t csv     = {.rows = 0};
    double       median  = 0.0;
    size_t       missing = 0;
    if (!read_file(&file, path, options, &csv, error))
    {
        common_csv_free(&csv);
        return false;
    }
    log->report.rows_read += file.rows;
    note_left_out(&log->report, &csv);
    log->report.files++;
    bool ok = find_interval(log, &file, &csv, options, &median, &missing, error);
    for (size_t i = 0; ok && log->rows > 0 && i < SIM_LOG_ROLES; i++)
    {
        ok = (log->values[i] != NULL) == (file.values[i] != NULL) ||
             common_error_set(error, "%s: column %s is in one file and not in another", path, role_names[i]);
    }
    if (ok && log->sample_time_s == 0.0)
    {
        const double *t    = file.values[SIM_LOG_T];
        log->sample_time_s = !options->resample      ? (t[file.rows - 1] - t[0]) / (double)(file.rows - 1 + missing)
                             : options->rate_s > 0.0 ? options->rate_s
                                                     : median;
    }
    else if (ok && !options->resample && !(fabs(median / log->sample_time_s - 1.0) <= JITTER))
    {
        ok =
            common_error_set(error,
                             "%s: its interval is %.6g s, that of the file before %.6g s (--resample makes them equal)",
                             path,
                             median,
                             log->sample_time_s);
    }
    if (ok)
    {
        const double by_s  = shift_of(log, &file);
        const double gap_s = options->gap_s > 0.0 ? options->gap_s : GAP_MAX * median;
        ok                 = options->resample || missing > 0 ? append_resampled(log, &file, gap_s, by_s, path, error)
                                                              : append(log, &file, by_s, error);
    }
    common_csv_free(&csv);
    return ok;
}

bool sim_log_read(sim_log_t               *log,
                  const char *const       *paths,
                  size_t                   count,
                  const sim_log_options_t *options,
                  common_error_t          *error)
{
    *log    = (sim_log_t){.report = {.resampled = options->resample}};
    bool ok = true;
    for (size_t i = 0; ok && i < SIM_LOG_ROLES; i++)
    {
        ok = !options->columns[i].is_torque || options->columns[i].scale != 0.0 ||
             common_error_set(
                 error,
                 "--unit %s=...: is not a force: give --scale %s=NUMBER, the N for one of this unit (1/lever for a "
                 "torque in N m)",
                 role_words[i],
                 role_words[i]);
    }
    for (size_t i = 0; ok && i < count; i++)
    {
        ok = add_file(log, paths[i], options, error);
    }
    ok = ok && (log->rows > 0 || common_error_set(error, "%s: no two rows without a gap between them", paths[0]));
    if (!ok)
    {
        sim_log_free(log);
        return false;
    }
    log->starts[log->segments] = log->rows;
    return true;
}

void sim_log_free(sim_log_t *log)
{
    for (size_t i = 0; i < SIM_LOG_ROLES; i++)
    {
        free(log->values[i]);
    }
    free(log->starts);
    free(log->report.left_out_first);
    *log = (sim_log_t){.rows = 0};
}
