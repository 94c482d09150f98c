#include "log/plot.h"

#include <math.h>

#define WIDTH   1100.0
#define HEIGHT  760.0
#define LEFT    70.0
#define GAP     80.0
#define TOP     50.0
#define PANEL_W ((WIDTH - LEFT - GAP - 20.0) / 2.0)
#define PANEL_H ((HEIGHT - TOP - 50.0 - GAP) / 2.0)
#define COLUMNS 800u ///< slightly more than pixels; a line keeps the least and largest value of each

/// One value of a row, for a line.
typedef double (*value_t)(const sim_log_t *log, const sim_replayed_t *replayed, size_t row);

static double u_of(const sim_log_t *log, const sim_replayed_t *replayed, size_t row)
{
    (void)replayed;
    return log->values[SIM_LOG_U][row];
}

static double force_of(const sim_log_t *log, const sim_replayed_t *replayed, size_t row)
{
    (void)replayed;
    return log->values[SIM_LOG_F][row];
}

static double n_of(const sim_log_t *log, const sim_replayed_t *replayed, size_t row)
{
    (void)log;
    return (double)replayed->n[row];
}

static double f_of(const sim_log_t *log, const sim_replayed_t *replayed, size_t row)
{
    (void)log;
    return (double)replayed->f[row];
}

static double limit_of(const sim_log_t *log, const sim_replayed_t *replayed, size_t row)
{
    (void)log;
    return copysign((double)replayed->L[row], (double)replayed->n[row]);
}

static double rest_of(const sim_log_t *log, const sim_replayed_t *replayed, size_t row)
{
    (void)log;
    return (double)replayed->n[row] - (double)replayed->f[row];
}

typedef struct
{
    const char *name, *colour;
    value_t     value;
} line_t;

typedef struct
{
    const char  *title, *x_label;
    const line_t lines[3];
    size_t       count;
    bool         over_force; ///< points over F, not lines over time
} panel_t;

static const panel_t panels[4] = {
    {"u and F [N]", "time [s]", {{"u", "#56B4E9", u_of}, {"F", "#000000", force_of}}, 2, false},
    {"net force n, estimate f, breakaway L [N]",
     "time [s]",
     {{"L for the sign of n", "#CC79A7", limit_of}, {"n", "#56B4E9", n_of}, {"f", "#000000", f_of}},
     3,
     false},
    {"what is left: n - f [N]", "time [s]", {{"n - f", "#D55E00", rest_of}}, 1, false},
    {"n and L over F [N]", "F [N]", {{"n", "#56B4E9", n_of}, {"L for the sign of n", "#CC79A7", limit_of}}, 2, true}};

typedef struct
{
    double x, y;                         ///< of the panel's upper left corner
    double x_low, x_high, y_low, y_high; ///< ranges of its axes
} frame_t;

static double to_x(const frame_t *frame, double x)
{
    return frame->x + (x - frame->x_low) / (frame->x_high - frame->x_low) * PANEL_W;
}

static double to_y(const frame_t *frame, double y)
{
    return frame->y + (frame->y_high - y) / (frame->y_high - frame->y_low) * PANEL_H;
}

static void widen(double *low, double *high)
{
    const double room = *high > *low ? 0.05 * (*high - *low) : fmax(1e-3, 0.05 * fabs(*low));
    *low -= room;
    *high += room;
}

static frame_t frame_of(const panel_t *panel, size_t index, const sim_log_t *log, const sim_replayed_t *replayed)
{
    frame_t frame = {.x      = LEFT + (double)(index % 2) * (PANEL_W + GAP),
                     .y      = TOP + (index >= 2 ? PANEL_H + GAP : 0.0),
                     .x_low  = HUGE_VAL,
                     .x_high = -HUGE_VAL,
                     .y_low  = HUGE_VAL,
                     .y_high = -HUGE_VAL};
    for (size_t k = 0; k < log->rows; k++)
    {
        const double x = log->values[panel->over_force ? SIM_LOG_F : SIM_LOG_T][k];
        frame.x_low    = fmin(frame.x_low, x);
        frame.x_high   = fmax(frame.x_high, x);
        for (size_t i = 0; i < panel->count; i++)
        {
            const double y = panel->lines[i].value(log, replayed, k);
            frame.y_low    = fmin(frame.y_low, y);
            frame.y_high   = fmax(frame.y_high, y);
        }
    }
    widen(&frame.x_low, &frame.x_high);
    widen(&frame.y_low, &frame.y_high);
    return frame;
}

/// The largest of 1, 2 and 5 times a power of ten with at least four ticks on an axis.
static double spacing_of(double span)
{
    const double power = pow(10.0, floor(log10(span / 4.0)));
    const double part  = span / 4.0 / power;
    return power * (part >= 5.0 ? 5.0 : part >= 2.0 ? 2.0 : 1.0);
}

static void write_axes(FILE *file, const panel_t *panel, const frame_t *frame)
{
    (void)fprintf(file,
                  "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"none\" stroke=\"#888\"/>\n",
                  frame->x,
                  frame->y,
                  PANEL_W,
                  PANEL_H);
    (void)fprintf(file, "<text x=\"%.1f\" y=\"%.1f\">%s</text>\n", frame->x, frame->y - 8.0, panel->title);
    (void)fprintf(file,
                  "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s</text>\n",
                  frame->x + PANEL_W / 2.0,
                  frame->y + PANEL_H + 34.0,
                  panel->x_label);
    const double dx = spacing_of(frame->x_high - frame->x_low), dy = spacing_of(frame->y_high - frame->y_low);
    const long   x_first = (long)ceil(frame->x_low / dx), x_last = (long)floor(frame->x_high / dx);
    const long   y_first = (long)ceil(frame->y_low / dy), y_last = (long)floor(frame->y_high / dy);
    for (long i = x_first; i <= x_last; i++)
    {
        (void)fprintf(file,
                      "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%.6g</text>\n",
                      to_x(frame, (double)i * dx),
                      frame->y + PANEL_H + 16.0,
                      (double)i * dx);
    }
    for (long i = y_first; i <= y_last; i++)
    {
        const double y = to_y(frame, (double)i * dy);
        (void)fprintf(file,
                      "<path d=\"M%.1f %.1fh%.1f\" stroke=\"#ddd\"/><text x=\"%.1f\" y=\"%.1f\" "
                      "text-anchor=\"end\">%.4g</text>\n",
                      frame->x,
                      y,
                      PANEL_W,
                      frame->x - 6.0,
                      y + 4.0,
                      (double)i * dy);
    }
}

/// A line over time, with the least and largest value of each column of pixels; each segment is a separate line.
static void write_line(FILE                 *file,
                       const line_t         *line,
                       const frame_t        *frame,
                       const sim_log_t      *log,
                       const sim_replayed_t *replayed)
{
    const size_t every = log->rows / COLUMNS + 1;
    (void)fprintf(file, "<path fill=\"none\" stroke=\"%s\" d=\"", line->colour);
    for (size_t s = 0; s < log->segments; s++)
    {
        const char *letter = "M";
        for (size_t k = log->starts[s]; k < log->starts[s + 1]; k += every)
        {
            const size_t end = k + every < log->starts[s + 1] ? k + every : log->starts[s + 1];
            double       low = HUGE_VAL, high = -HUGE_VAL;
            for (size_t j = k; j < end; j++)
            {
                low  = fmin(low, line->value(log, replayed, j));
                high = fmax(high, line->value(log, replayed, j));
            }
            const double x = to_x(frame, log->values[SIM_LOG_T][k]);
            (void)fprintf(file, "%s%.1f %.1f", letter, x, to_y(frame, low));
            if (high > low)
            {
                (void)fprintf(file, "V%.1f", to_y(frame, high));
            }
            letter = "L";
        }
    }
    (void)fputs("\"/>\n", file);
}

static void write_points(FILE                 *file,
                         const line_t         *line,
                         const frame_t        *frame,
                         const sim_log_t      *log,
                         const sim_replayed_t *replayed)
{
    const size_t every = log->rows / (4u * COLUMNS) + 1;
    (void)fprintf(file, "<path stroke=\"%s\" stroke-width=\"2\" stroke-linecap=\"round\" d=\"", line->colour);
    for (size_t k = 0; k < log->rows; k += every)
    {
        const double x = to_x(frame, log->values[SIM_LOG_F][k]);
        (void)fprintf(file, "M%.1f %.1fh0", x, to_y(frame, line->value(log, replayed, k)));
    }
    (void)fputs("\"/>\n", file);
}

/// Text, with XML's special characters escaped.
static void write_text(FILE *file, const char *text)
{
    for (const char *p = text; *p != '\0'; p++)
    {
        switch (*p)
        {
        case '<':
            (void)fputs("&lt;", file);
            break;
        case '&':
            (void)fputs("&amp;", file);
            break;
        default:
            (void)fputc((unsigned char)*p < 0x20u ? '?' : *p, file);
        }
    }
}

void sim_plot_write(FILE *file, const char *title, const sim_log_t *log, const sim_replayed_t *replayed)
{
    (void)fprintf(
        file,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" font-family=\"sans-serif\" "
        "font-size=\"12\">\n<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n<text x=\"%.0f\" y=\"20\" "
        "font-size=\"14\">",
        WIDTH,
        HEIGHT,
        LEFT);
    write_text(file, title);
    (void)fputs("</text>\n", file);
    for (size_t i = 0; i < 4; i++)
    {
        const panel_t *panel = &panels[i];
        const frame_t  frame = frame_of(panel, i, log, replayed);
        write_axes(file, panel, &frame);
        for (size_t j = 0; j < panel->count; j++)
        {
            (panel->over_force ? write_points : write_line)(file, &panel->lines[j], &frame, log, replayed);
            (void)fprintf(file,
                          "<text x=\"%.1f\" y=\"%.1f\" fill=\"%s\" text-anchor=\"end\">%s</text>\n",
                          frame.x + PANEL_W - 6.0,
                          frame.y + 16.0 + 15.0 * (double)j,
                          panel->lines[j].colour,
                          panel->lines[j].name);
        }
    }
    (void)fputs("</svg>\n", file);
}
