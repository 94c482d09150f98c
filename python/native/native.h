/// What the Python package calls of library and simulator. build.py gives these declarations to cffi as they are.

#ifndef NATIVE_H
#define NATIVE_H

#include <stdbool.h>
#include <stddef.h>

/// A refusal. `status` is the library's tribo_status_t, 0 if the words are the simulator's; `key` is the scenario's, "" if unknown.
typedef struct
{
    int  status;
    char key[128];
    char text[4096];
} native_error_t;

/// A row of tribo/parameters.h with its key in a scenario.
typedef struct
{
    const char *symbol, *key, *unit, *condition, *text;
    double      low, high, standard;
} native_parameter_t;

unsigned           native_parameter_count(void);
native_parameter_t native_parameter(unsigned index);
const char        *native_status_symbol(int status);
const char        *native_version(void);

// --- scenarios -----------------------------------------------------------------------------------------------------

typedef struct native_scenario native_scenario_t;

/// Of a file, or all defaults if `path` is null. Null if there is no memory or the file is refused.
native_scenario_t *native_scenario_open(const char *path, native_error_t *error);
void               native_scenario_close(native_scenario_t *scenario);

/// Takes "key=value". After a refusal the scenario is only to be closed.
bool native_scenario_set(native_scenario_t *scenario, const char *assignment, native_error_t *error);

/// The library's parameters of its loop, in double, without a check; false if `key` is none of them.
bool native_scenario_put(native_scenario_t *scenario, const char *key, double value);

/// A key that a scenario may have, and what its value is: number, whole, choice, text, group or list. Words of a choice: "a, b or c".
typedef struct
{
    char        path[128];
    const char *type;
    char        words[512];
} native_key_t;

/// `index` from 0; false behind the last.
bool native_key(unsigned index, native_key_t *key);

/// Of a scenario to be played: checks the whole.
bool     native_scenario_check(native_scenario_t *scenario, native_error_t *error);
size_t   native_scenario_ticks(const native_scenario_t *scenario);
unsigned native_scenario_columns(const native_scenario_t *scenario);

const char *native_column_name(unsigned column);
bool        native_column_is_flag(unsigned column);

/// Plays a checked scenario. `trace` takes its columns one after the other, each of `rows` doubles: the first of `every` ticks.
/// `trace_q31` likewise of a second loop in Q31, null: there is none. Ends where `go_on`, asked now and then, returns false. Returns the
/// summary as JSON, for native_free.
char *native_run(const native_scenario_t *scenario,
                 bool                     q31,
                 size_t                   rows,
                 size_t                   every,
                 double                  *trace,
                 double                  *trace_q31,
                 bool (*go_on)(void),
                 native_error_t *error);
void  native_free(char *text);

/// Reads a decimal number as all files of the simulator have it. Null, or what is wrong with it, e.g. "is not a number".
const char *native_number(const char *text, double *value);

/// What a key of a scenario holds, for a study that varies it: "number", with its value; "unset", a number that the scenario leaves out;
/// "whole", or "other". Null: there is no such key.
const char *native_scenario_number(const native_scenario_t *scenario, const char *key, double *value);

/// The path of the file with the reference's forces, for native_free. Null: the scenario reads none.
char *native_scenario_reference(const native_scenario_t *scenario);

/// Plays a checked scenario without a trace, for at most `timeout_s` of processor time. Returns "ok" with the summary as JSON, for
/// native_free, and the ticks of its metrics window; else why there is none, in words in `error`: "refused" before the first tick,
/// "failed" or "timeout".
const char *native_measure(const native_scenario_t *scenario,
                           bool                     q31,
                           double                   timeout_s,
                           char                   **json,
                           double                  *window_ticks,
                           native_error_t          *error);

// --- parts of a loop, stepped alone --------------------------------------------------------------------------------

typedef struct native_part native_part_t;

/// `kind` by its name: loop, friction, compensator, guard, feedforward. Null if it is refused.
native_part_t *native_part_new(const char *kind, const native_scenario_t *scenario, bool q31, native_error_t *error);
void           native_part_delete(native_part_t *part);
void           native_part_reset(native_part_t *part);

/// What goes into a tick and what comes out, by names; null behind the last.
const char *native_part_input(const native_part_t *part, unsigned index);
const char *native_part_output(const native_part_t *part, unsigned index);

/// One tick; as many inputs count as the part has. Returns the first output.
double native_part_step(native_part_t *part, double a, double b, double c, double d);

/// Outputs of the last tick; of a loop they are kept from here on.
double native_part_seen(native_part_t *part, unsigned index);

/// `count` ticks. An array for each input; an array for the first output, with `all` for each.
void native_part_play(native_part_t *part, const double *const *inputs, size_t count, double *const *outputs, bool all);

/// Of a feed-forward, the two halves of a tick: the error for a controller, and u once its output v is known.
double native_feedforward_error(native_part_t *part, double r_n, double y_n);
double native_feedforward_command(native_part_t *part, double v_n);

/// Of a loop or feed-forward at an end-point force, L+ and L-: breakaway, relative variance, travel, whether at a bound and whether it
/// stays there; then whether friction harms, and how often the memory was corrupt. False: it does not learn.
bool native_part_learned(const native_part_t *part, double force_n, double values[12]);

const char *native_part_guard_cause(const native_part_t *part);
void        native_part_restore(native_part_t *part);
unsigned    native_part_limited_ticks(const native_part_t *part);
unsigned    native_part_bad_inputs(const native_part_t *part);
double      native_part_sample_time_s(const native_part_t *part);

// --- an axis and a joint in one struct -------------------------------------------------------------------------------------------

typedef struct native_axis  native_axis_t;
typedef struct native_joint native_joint_t;

/// `numbers`: sample time, u_min, u_max, input_max, usual force, breakaway's offset and slope (positive, negative), gravity, arm's lag, noise,
/// poles of actuator and sensor, kp, ki, full scale, presliding, still time. `kind` of the controller: pi, sections (of five numbers each), paper, own or none. Null if it is
/// refused.
native_axis_t *native_axis_new(bool            q31,
                               const float     numbers[19],
                               const char     *kind,
                               const float    *sections,
                               unsigned        count,
                               native_error_t *error);
void           native_axis_delete(native_axis_t *axis);

/// Other numbers from the next tick on; the sample time and the full scale are those of the start. False: nothing has changed.
bool   native_axis_change(native_axis_t  *axis,
                          const float     numbers[19],
                          const char     *kind,
                          const float    *sections,
                          unsigned        count,
                          native_error_t *error);
void   native_axis_play(native_axis_t *axis, const double *r_n, const double *y_n, size_t count, double *u_n);
double native_axis_error(native_axis_t *axis, double r_n, double y_n);
double native_axis_command(native_axis_t *axis, double v_n);
double native_axis_excess(const native_axis_t *axis);
void   native_axis_rest(native_axis_t *axis);
void   native_axis_restore(native_axis_t *axis);

/// Learned breakaway, low, high (positive, negative each), travel, times_less, share, bad_inputs, limited_ticks, forgotten, breakaway_factor. Then the
/// warnings, one by one:
/// null behind the last.
void        native_axis_report(native_axis_t *axis, double numbers[13]);
const char *native_axis_warning(native_axis_t *axis);

/// What is learned, as `size` bytes; what fits in no axis of that arithmetic and rig is refused.
size_t native_axis_blob_size(const native_axis_t *axis);
void   native_axis_export(const native_axis_t *axis, void *bytes);
bool   native_axis_import(native_axis_t *axis, const void *bytes, size_t size, native_error_t *error);

/// `numbers`: sample time, effort_max, travel, breakaway, actuator's pole, gain, wrap. Null if it is refused.
native_joint_t *native_joint_new(bool q31, const float numbers[7], native_error_t *error);
void            native_joint_delete(native_joint_t *joint);
void            native_joint_play(native_joint_t *joint,
                                  const double   *effort,
                                  const double   *q_ref,
                                  const double   *q,
                                  size_t          count,
                                  double         *u);
void            native_joint_load(native_joint_t *joint, double load);
bool            native_joint_gain(native_joint_t *joint, double gain, native_error_t *error);
void            native_joint_rest(native_joint_t *joint);
void            native_joint_restore(native_joint_t *joint);

/// Force, low, high.
void native_joint_force(const native_joint_t *joint, double force[3]);

/// Friction, low, high, load, share, 1 if it is learned, bad_inputs, limited_ticks. Returns the cause's sentence.
const char *native_joint_report(const native_joint_t *joint, double numbers[8]);

// --- for tribo-design ----------------------------------------------------------------------------------------------

/// What tribo_controller_q31_init makes of float32 sections of five numbers each. `numbers`: eight of each section made, two at
/// least, then input and output scale, anti-windup, its shift, taken_max, u_min, u_max. `peaks`: of each section made. Returns how
/// many were made, 0 if the sections are refused.
unsigned native_quantise(const float    *sections,
                         unsigned        count,
                         float           full_scale_n,
                         float           u_min_n,
                         float           u_max_n,
                         long long       numbers[39],
                         float           peaks[4],
                         double         *conditioning,
                         native_error_t *error);

/// The force around which a rig with these limits of u usually works; 0: it is not said.
float native_usual_force(float usual_force_n, float u_min_n, float u_max_n);

/// Feed-forward and guard that the library's rule makes of a rig: offset and slope in both directions, I, b, K, poles of actuator
/// and sensor, usual force, noise and sample time. `tuned`: six of the feed-forward, four of the guard.
bool native_tune(const float rig[12], float tuned[10], native_error_t *error);

#endif
