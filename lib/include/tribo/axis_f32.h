/// A force axis in one struct, single precision: the loop of force_loop_f32.h with the feed-forward and its guard.
///
///     static tribo_axis_f32_t  axis;
///     tribo_axis_f32_config_t  config = tribo_axis_f32_config(); // empty: refused until the rig is in it
///     ...
///     tribo_status_t status = tribo_axis_f32_init(&axis, &config); // each refusal names the next field: tribo_status_text
///     u = tribo_axis_f32_step(&axis, r, y);                        // every tick
///
/// With a controller of your own (tribo_own) the tick has two halves, and one call tells what the limit has taken from your output:
///
///     e = tribo_axis_f32_error(&axis, r, y);
///     u = tribo_axis_f32_command(&axis, my_pid(e));
///     my_integral += my_gain * tribo_axis_f32_excess(&axis);
///
/// Not synchronized: one axis, one tick. A tick is a tick of the force loop and 10 instructions, and cannot fail. It does not move or copy:
/// the axis points to itself.

#ifndef TRIBO_AXIS_F32_H
#define TRIBO_AXIS_F32_H

#include "tribo/feedforward_f32.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_axis_f32_params tribo_axis_f32_params_t;
typedef struct tribo_axis_f32        tribo_axis_f32_t;

typedef enum
{
    TRIBO_CONTROLLER_NONE = 0, ///< refused
    TRIBO_CONTROLLER_PI,
    TRIBO_CONTROLLER_SECTIONS,
    TRIBO_CONTROLLER_OWN
} tribo_controller_kind_t;

typedef struct
{
    tribo_controller_kind_t           kind;
    float                             kp, ki_per_s;
    const tribo_biquad_f32_section_t *sections;
    uint32_t                          section_count;
} tribo_axis_controller_t;

typedef struct
{
    float sample_time_s; ///< of every tick, 1e-6 to 0.1 s
    float u_min_n;       ///< -1e6 to 0 N
    float u_max_n;       ///< 0 to 1e6 N, over u_min_n
    float input_max_n;   ///< largest credible |r| and |y|, up to 1e6 N; 0: twice the larger limit of u
    float usual_force_n; ///< |F| around which the rig usually works; 0: a quarter of the larger limit of u
    tribo_breakaway_f32_t positive,
        negative; ///< breakaway, offset_n + slope |F|, within a factor of 3; a negative of 0 is as the positive
    float                          gravity_n; ///< constant load on the arm, as end-point force
    float                          arm_lag_s; ///< damping over stiffness of the arm, s; 0: none that is known
    float                          noise_n;   ///< standard deviation of y; 0: unknown
    tribo_axis_controller_t        controller;
    tribo_feedforward_f32_config_t feedforward; ///< poles of actuator and sensor; the rest has its defaults
} tribo_axis_f32_config_t;

/// For both arithmetics, in N.
typedef struct
{
    float breakaway_n[2];      ///< learned, at the usual force, by TRIBO_BREAKAWAY_POSITIVE and _NEGATIVE
    float low_n[2], high_n[2]; ///< between these it is, at 95 %
    float travel_n;            ///< learned from
    float
        times_less; ///< work of the controller at a reversal: so many times less than without compensation; 0: not known yet
    float    share;                                      ///< of friction that the guard lets through, 0 to 1
    uint32_t bad_inputs, limited_ticks, forgotten, late; ///< since the init; they stop at UINT32_MAX
    uint32_t warnings;                                   ///< bits, for tribo_axis_warning
} tribo_axis_report_t;

/// a, P, doubt, travel and seal of tribo_feedforward_learner_t.
#define TRIBO_AXIS_LEARNED_WORDS 23

/// What is learned, to be kept over a loss of power. Any storage will do; bytes as they are.
typedef struct
{
    uint32_t version; ///< TRIBO_AXIS_F32_BLOB_VERSION
    uint32_t rig;     ///< the config's breakaway, usual force and presliding
    uint32_t learned[TRIBO_AXIS_LEARNED_WORDS];
    uint32_t checksum; ///< CRC-32 of all before
} tribo_axis_f32_blob_t;

#define TRIBO_AXIS_F32_BLOB_VERSION UINT32_C(0x54413132) ///< changes with the meaning of any bit

/// v = kp e + ki times the integral of e, by the bilinear rule: newtons of u per newton of error, 1e-6 to 1e5, and that per second,
/// 0 to 1e5 and times the sample time at most 2 kp. Friction is no part of it: tune it for the arm without friction.
tribo_axis_controller_t tribo_pi(float kp, float ki_per_s);

/// `count` sections for the axis' sample time, as tribo_controller_f32_config_t has them; read by the init alone.
tribo_axis_controller_t tribo_sections(const tribo_biquad_f32_section_t *sections, uint32_t count);

/// The paper's, for 1 ms and an arm like the paper's.
tribo_axis_controller_t tribo_paper(void);

/// None of the library's: use _error and _command.
tribo_axis_controller_t tribo_own(void);

/// The beginning: all that depends on the rig is 0 and refused, field by field. The feed-forward's other numbers are the defaults.
tribo_axis_f32_config_t tribo_axis_f32_config(void);

/// Makes an axis at rest that has learned nothing. Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_SAMPLE_TIME, TRIBO_ERR_U_MIN,
/// TRIBO_ERR_U_MAX, TRIBO_ERR_CONTROLLER, TRIBO_ERR_PI, TRIBO_ERR_AXIS_LAG, or a status of tribo_force_loop_f32_init. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_axis_f32_init(tribo_axis_f32_t *axis, const tribo_axis_f32_config_t *config);

/// One tick: u in N, within its limits, for any r and y; 0 before the init. Every 10 ticks it learns, too.
float tribo_axis_f32_step(tribo_axis_f32_t *axis, float r_n, float y_n);

/// The tick in two halves, for tribo_own: the error for your controller, then u for its output. See tribo_force_loop_f32_error.
float tribo_axis_f32_error(tribo_axis_f32_t *axis, float r_n, float y_n);

/// The second half: u in N for the output v of your controller.
float tribo_axis_f32_command(tribo_axis_f32_t *axis, float v_n);

/// What the limit took in the last command: u less the sum that was wanted; 0 within the limits.
float tribo_axis_f32_excess(const tribo_axis_f32_t *axis);

/// Not for the tick. Zeros before the init.
void tribo_axis_f32_report(const tribo_axis_f32_t *axis, tribo_axis_report_t *report);

/// The sentence of one of `warnings`, whose bit is cleared; null where none is left.
const char *tribo_axis_warning(uint32_t *warnings);

/// By command, once the cause is found: friction returns in full, latches open. What is learned stays.
void tribo_axis_f32_restore(tribo_axis_f32_t *axis);

/// Another config while it runs: `next` is made in the background, then handed over between two ticks. u does not jump, and what is
/// learned stays. `next` must live until another has been handed over and run for a tick. Statuses of the init; of the change TRIBO_ERR_NULL, of a next that
/// was not made or an axis without init TRIBO_ERR_AXIS_ORDER, of another sample time TRIBO_ERR_SAMPLE_TIME.
tribo_status_t tribo_axis_f32_prepare(tribo_axis_f32_params_t *next, const tribo_axis_f32_config_t *config);

/// Hands the prepared params over, between two ticks; see _prepare.
tribo_status_t tribo_axis_f32_change(tribo_axis_f32_t *axis, const tribo_axis_f32_params_t *next);

/// Between two ticks, as is the import. Nothing learned before the init.
void tribo_axis_f32_export(const tribo_axis_f32_t *axis, tribo_axis_f32_blob_t *blob);

/// Takes over what was learned, at any time after the init; u does not jump. Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_AXIS_ORDER
/// before the init, TRIBO_ERR_BLOB_VERSION, TRIBO_ERR_BLOB_CHECKSUM or TRIBO_ERR_BLOB_RIG; then nothing has changed.
tribo_status_t tribo_axis_f32_import(tribo_axis_f32_t *axis, const tribo_axis_f32_blob_t *blob);

// --- what they hold: give it room; write only what a comment says ------------------------------------------------------

/// What is made of a config. Const once it is in use.
struct tribo_axis_f32_params
{
    tribo_force_loop_f32_params_t  loop;
    tribo_feedforward_f32_params_t feedforward;
    tribo_guard_f32_params_t       guard;
    float                          sample_time_s, full_scale_n, usual_force_n;
    float                          breakaway_n; ///< as configured, at the usual force
    uint32_t                       rig;         ///< of the numbers that what is learned refers to
};

struct tribo_axis_f32
{
    const tribo_axis_f32_params_t *active; ///< null before the init
    tribo_axis_f32_params_t        params;
    tribo_force_loop_f32_state_t   loop;
    tribo_feedforward_f32_memory_t memory;
    float                          excess_n;
};

#ifdef __cplusplus
}
#endif

#endif
