/// A force axis in one struct, single precision: the loop of force_loop_f32.h with the feed-forward and its guard.
///
///     static tribo_axis_f32_t  axis;
///     tribo_axis_f32_config_t  config = tribo_axis_f32_config(); // empty: the init refuses it until you describe the rig
///     ...
///     tribo_status_t status = tribo_axis_f32_init(&axis, &config); // tribo_status_text(status) names the next field
///     u = tribo_axis_f32_step(&axis, r, y);                        // every tick
///
/// With your own controller (tribo_own) the tick has two halves, and one call returns what the limit has cut off your
/// output:
///
///     e = tribo_axis_f32_error(&axis, r, y);
///     u = tribo_axis_f32_command(&axis, my_pid(e));
///     my_integral += my_gain * tribo_axis_f32_excess(&axis);
///
/// Not synchronized: one axis, one tick. A tick costs a tick of the force loop and 10 instructions, every tenth one
/// also about 2,000 floating-point operations to learn (48,000 instructions without an FPU), and cannot fail. Do not
/// move or copy an axis, because it points to itself. Keep it in zeroed memory until its init succeeds: only then do
/// the other functions know that it is empty. Its params hold pointers to code and lie in RAM; the loop trusts them
/// (force_loop_f32.h).

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
    TRIBO_CONTROLLER_NONE = 0, ///< the init refuses it
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
    /// Checks sections, at the init. tribo_sections and tribo_paper set it: only their call links the check.
    tribo_status_t (*make)(tribo_controller_f32_params_t       *made,
                           const tribo_controller_f32_config_t *controller,
                           float                                sample_time_s);
} tribo_axis_controller_t;

typedef struct
{
    float sample_time_s; ///< time between two ticks, 1e-6 to 0.1 s
    float u_min_n;       ///< -1e6 to 0 N
    float u_max_n;       ///< 0 to 1e6 N, over u_min_n
    float input_max_n;   ///< largest credible |r| and |y|, up to 1e6 N; 0: twice the larger limit of u
    /// |F| around which the rig usually works, in Q31 up to the full scale; 0: a quarter of the larger limit of u. The
    /// breakaway there sets all widths, so set it if your limits are generous: three times too much cost nothing on 60
    /// foreign grippers with friction that grows with F, ten times made 25 of them worse, by 7 % in the mean of all.
    float                   usual_force_n;
    tribo_breakaway_f32_t   positive;  ///< breakaway, offset_n + slope |F|, right within a factor of 3
    tribo_breakaway_f32_t   negative;  ///< breakaway in the negative direction; 0: the same as in the positive one
    float                   gravity_n; ///< constant load on the arm, as end-point force
    float                   arm_lag_s; ///< damping divided by stiffness of the arm, s; 0: not known, or r steps
    float                   noise_n;   ///< standard deviation of y; 0: not known
    tribo_axis_controller_t controller;
    /// Set the poles of actuator and sensor; the other members have their defaults. Count a delay T of the loop into the
    /// sensor's pole p: 1 / (1 / p + T). That was better than leaving it out or counting it into arm_lag_s.
    tribo_feedforward_f32_config_t feedforward;
} tribo_axis_f32_config_t;

/// The state of an axis in N, for both arithmetics.
typedef struct
{
    /// Learned breakaway at the usual force; TRIBO_BREAKAWAY_POSITIVE and _NEGATIVE are the indices. Friction that drops
    /// once the arm slides, steps of r and lost contact leave it too low.
    float breakaway_n[2];
    float low_n[2], high_n[2]; ///< 95 % interval, if the rig is as configured; it held 105 of 166 foreign breakaways
    /// Multiply the configured breakaway by this and initialise again: 3 if it is far too small (high_n is then 1e6 N),
    /// 0.2 if it is far too large, otherwise 1.
    float breakaway_factor;
    float travel_n;   ///< travel that was learned from
    float times_less; ///< factor by which compensation reduces the controller's work at a reversal, not the error, 0.25
                      ///< to 100; 0: not known, because no reversal was judged or friction is fed back
    float    share;   ///< part of friction that the guard lets through, 0 to 1
    uint32_t bad_inputs, limited_ticks, forgotten, late; ///< counted since the init; they stop at UINT32_MAX
    uint32_t warnings;                                   ///< bits for tribo_axis_warning
} tribo_axis_report_t;

/// Words of a, P, doubt, travel, breakaway, rig and seal of tribo_feedforward_learner_t.
#define TRIBO_AXIS_LEARNED_WORDS 25

/// The learned values, to keep while power is off. Store the bytes as they are.
typedef struct
{
    uint32_t version; ///< TRIBO_AXIS_F32_BLOB_VERSION
    uint32_t learned[TRIBO_AXIS_LEARNED_WORDS];
    uint32_t checksum; ///< CRC-32 of the members above
} tribo_axis_f32_blob_t;

#define TRIBO_AXIS_F32_BLOB_VERSION UINT32_C(0x54413134) ///< changes with the meaning of any bit

/// Returns a PI, v = kp e + ki (integral of e), integrated by the bilinear rule. kp is newtons of u per newton of
/// error, 1e-6 to 1e5. ki_per_s is in 1/s, 0 to 1e5, and times the sample time at most 2 kp. Tune both for the arm
/// without friction.
tribo_axis_controller_t tribo_pi(float kp, float ki_per_s);

/// Returns a controller of `count` sections, which are designed for the axis's sample time and described in
/// controller_f32.h. Only the init reads `sections`.
tribo_axis_controller_t tribo_sections(const tribo_biquad_f32_section_t *sections, uint32_t count);

/// Returns the paper's controller, for 1 ms and an arm like the paper's.
tribo_axis_controller_t tribo_paper(void);

/// Says that you run your own controller between tribo_axis_f32_error and _command. A change to or from it drops the
/// output of that controller from u.
tribo_axis_controller_t tribo_own(void);

/// Returns the beginning of a config. Everything that depends on the rig is 0, and the init refuses it field by field
/// until you set it. The other numbers of the feed-forward have their defaults.
tribo_axis_f32_config_t tribo_axis_f32_config(void);

/// Initialises an axis at rest that has learned nothing. Returns TRIBO_OK, TRIBO_ERR_NULL, the status of the first
/// wrong field, or one of tribo_force_loop_f32_init. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_axis_f32_init(tribo_axis_f32_t *axis, const tribo_axis_f32_config_t *config);

/// Runs one tick: returns u in N, within its limits for any r and y, or 0 before the init. Every 10 ticks it also
/// learns. After a time without ticks, for example while the drive was off, call tribo_axis_f32_rest first: otherwise u
/// continues from its old value.
float tribo_axis_f32_step(tribo_axis_f32_t *axis, float r_n, float y_n);

/// The first half of a tick with tribo_own: returns the error for your controller. tribo_force_loop_f32_error explains
/// the halves.
float tribo_axis_f32_error(tribo_axis_f32_t *axis, float r_n, float y_n);

/// The second half: returns u in N for the output `v_n` of your controller.
float tribo_axis_f32_command(tribo_axis_f32_t *axis, float v_n);

/// Returns what the limit cut off in the last command: u minus the unlimited sum, 0 within the limits.
float tribo_axis_f32_excess(const tribo_axis_f32_t *axis);

/// Writes the report; before the init share and breakaway_factor are 1 and the rest is 0. Not for the tick.
void tribo_axis_f32_report(const tribo_axis_f32_t *axis, tribo_axis_report_t *report);

/// Returns the sentence for one bit of `warnings` and clears that bit; null if no bit is set.
const char *tribo_axis_warning(uint32_t *warnings);

/// Puts the axis to rest, between two ticks: the next tick is the first one. Learned values, counters and what the guard
/// has latched stay.
void tribo_axis_f32_rest(tribo_axis_f32_t *axis);

/// Clears what guard and learner have latched, and lets all friction through again. Call it between two ticks, on
/// command, once the cause is found. Learned values stay, and so do counters and their warnings.
void tribo_axis_f32_restore(tribo_axis_f32_t *axis);

/// Prepares params for a change of config while the axis runs. Call it in the background, then call
/// tribo_axis_f32_change between two ticks. Never prepare the params that the axis uses: alternate two. Returns the
/// statuses of tribo_axis_f32_init.
tribo_status_t tribo_axis_f32_prepare(tribo_axis_f32_params_t *next, const tribo_axis_f32_config_t *config);

/// Makes the axis use the prepared params from the next tick on. u does not jump. Learned values stay, but are forgotten
/// if breakaway, gravity_n or presliding_n differ, to which they refer. `next` must live until the axis has run a tick
/// with other params. Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_AXIS_ORDER if `next` was not prepared or is in use, or
/// the axis not initialised, or TRIBO_ERR_SAMPLE_TIME if `next` is for another sample time.
tribo_status_t tribo_axis_f32_change(tribo_axis_f32_t *axis, const tribo_axis_f32_params_t *next);

/// Copies the learned values to `blob`, which is empty before the init. Call it between two ticks.
void tribo_axis_f32_export(const tribo_axis_f32_t *axis, tribo_axis_f32_blob_t *blob);

/// Takes over learned values from `blob`, between two ticks at any time after the init; u does not jump. Returns
/// TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_AXIS_ORDER before the init, TRIBO_ERR_BLOB_VERSION, TRIBO_ERR_BLOB_CHECKSUM or
/// TRIBO_ERR_BLOB_RIG. Changes nothing unless TRIBO_OK.
tribo_status_t tribo_axis_f32_import(tribo_axis_f32_t *axis, const tribo_axis_f32_blob_t *blob);

// --- contents of the types above: reserve room for them; write only the members whose comment says so ---------------

/// Constants of an axis, computed from its config. Do not change them while they are in use.
struct tribo_axis_f32_params
{
    tribo_force_loop_f32_params_t  loop;
    tribo_feedforward_f32_params_t feedforward;
    tribo_guard_f32_params_t       guard;
    float                          sample_time_s, full_scale_n, usual_force_n;
    uint8_t                        is_own; ///< 1: the controller is the caller's
};

struct tribo_axis_f32
{
    const tribo_axis_f32_params_t *active; ///< null before the init
    const tribo_axis_f32_params_t *ran;    ///< params of the last tick; null before the first one
    tribo_axis_f32_params_t        params;
    tribo_controller_f32_state_t   controller; ///< contains limited_ticks
    uint32_t                       bad_inputs;
    uint8_t                        is_far_below; ///< latched: the configured breakaway is a third of the rig's or less
    uint8_t                        is_miscalled; ///< latched: a tick was called in the way of another controller
    uint8_t                        is_half_done; ///< between the halves of a tick
    float                          excess_n;
    tribo_guard_f32_state_t        guard;       ///< before `feedforward`, which so is aligned as its memory
    tribo_feedforward_f32_state_t  feedforward; ///< the last member
};

#ifdef __cplusplus
}
#endif

#endif
