/// A joint with a current measurement and an encoder, single precision. It takes friction out behind your loop:
///
///     u = limit(effort + load + term)        term: the friction that opposes the intended motion, learned from your loop's own effort
///
///     static tribo_joint_f32_t joint;
///     tribo_joint_config_t     config = tribo_joint_config(); // empty: the init refuses it until you describe the joint
///     ...
///     tribo_status_t status = tribo_joint_f32_init(&joint, &config);
///     u = tribo_joint_f32_step(&joint, my_loop(q_ref, q), q_ref, q); // every tick
///
/// Your loop may control position, velocity or impedance, or hold the joint against gravity. `q_ref` is the position
/// that the loop wants, `q` the measured one, both in radians, counts or metres. If positions begin anew after a turn,
/// set `wrap`; without it count turns. (In Q31 they may wrap at 32 bits.) For a velocity loop q_ref is the integral of
/// its reference. Where a hand leads the joint, pass q as q_ref. Effort is the output of your loop in N m, N or A.
///
/// Direction. While q_ref moves, the term opposes the friction of that motion. While q_ref rests and the joint is off
/// by two `travel` or more, the term points back to q_ref. From the second change of direction on, each change halves
/// the term until q_ref moves again, so that hunting dies out. Nearer to q_ref the term gives way to an effort that
/// opposes it. At rest without an effort the term is 0. It fades after 50 ms (4 ticks if these are longer) in which the
/// joint is away from q_ref without any effort, because your loop is off, or in which a position is not a number,
/// because the encoder fails. The fade takes another 1.05 lags and 2 to 3 ticks, where the lag is that of the actuator,
/// 1 / actuator_pole_rad_per_s: without it the term is 0 after 52 ms with a tick of 1 ms, and after 0.6 s with one of
/// 0.1 s. After a time without ticks call tribo_joint_f32_rest, or the old term goes on for that time. u must reach the
/// motor: while it does not, call tribo_joint_f32_rest instead of the step.
///
/// Learning. Between two reversals of q (a slide) the kinetic energy does not change, so the work of the effort goes
/// into friction and load. Slides in both directions tell the two apart. Only the slow part of a slide counts, because
/// viscous friction is not part of breakaway. All of a slide does if that part is less than a sixteenth, or if the slide
/// is shorter than 6 (T + a tick), where T is the longest of 10 ms, 5 ticks and 0.8 (lag + 2 ticks). Effort that the
/// slow part takes beyond the fast part lifts a load or bends a gear, and is left out. Only slides that q_ref asked for
/// count, of 16 `travel` or more and a sixteenth of what q_ref asked for.
///
/// Guard. It fades the term within 0.1 s (1.05 lags and 4 ticks if these are longer) and latches the reason until
/// tribo_joint_f32_restore: the joint runs away from q_ref with its term, it hunts at rest, or slides give more energy
/// than they take (the effort or the encoder has the wrong sign).
///
/// No heap, no libm. The end of a slide costs one division, other ticks none. Not synchronized: one joint, one tick.

#ifndef TRIBO_JOINT_F32_H
#define TRIBO_JOINT_F32_H

#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_joint_f32 tribo_joint_f32_t;

/// Effort and q have the units of your loop.
typedef struct
{
    float sample_time_s; ///< time between two ticks, 1e-6 to 0.1 s
    float effort_max;    ///< limit of |u|, 1e-6 to 1e6
    float travel;    ///< smallest change of q that is not noise, e.g. four counts; 1e-9 to 1e6; in Q31 counts, 1 to 1e4
    float breakaway; ///< your guess of the friction, 0 to effort_max; half of it is used until friction is learned
    float actuator_pole_rad_per_s; ///< pole of the current loop, 1e-3 to 1e6; 0: fast
    float gain; ///< part of the learned friction that is taken out, 0 to 1; where a hand leads at most 0.8
    float wrap; ///< travel of a turn after which q and q_ref begin anew, e.g. 2 pi; at least 100 travel; 0: they do not
} tribo_joint_config_t;

typedef enum
{
    TRIBO_JOINT_SOUND = 0,
    TRIBO_JOINT_ASTRAY,  ///< with its term it moved away from q_ref
    TRIBO_JOINT_HUNTING, ///< it moved back and forth about a resting q_ref
    TRIBO_JOINT_REVERSED ///< the effort gained energy from friction: a sign is wrong, or your loop itself rattles
} tribo_joint_cause_t;

/// The state of a joint in your units, for both arithmetics.
typedef struct
{
    float               friction, low, high; ///< learned friction and its interval
    float               load;                ///< learned load in addition to the one you pass; your loop holds it
    float               share;               ///< part of the term that the guard lets through, 0 to 1
    bool                is_learned;          ///< false: `friction` is your guess
    tribo_joint_cause_t cause;
    uint32_t            bad_inputs, limited_ticks;
} tribo_joint_report_t;

/// The force that the joint exerts on its surroundings. A positive force drives q up.
typedef struct
{
    float force, low, high;
} tribo_joint_force_t;

/// Returns the beginning of a config. Everything that depends on the joint is 0, and the init refuses it until you set
/// it. gain is 0.97.
tribo_joint_config_t tribo_joint_config(void);

/// Initialises a joint at rest that has learned nothing. Returns TRIBO_OK, TRIBO_ERR_NULL, or the status of the first
/// wrong field. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_joint_f32_init(tribo_joint_f32_t *joint, const tribo_joint_config_t *config);

/// Runs one tick: returns u for the drive, within +-effort_max for any input, or 0 before the init of a zeroed struct. A
/// bad effort (NaN, or beyond 1e9) counts as 0; with a bad q_ref or q the joint counts as not moved. Both are counted,
/// and so is a state that a flipped bit has made no number: the joint forgets it and learns anew. Pass your loop's
/// output before its own limit, and stop its integral while |u| is effort_max.
float tribo_joint_f32_step(tribo_joint_f32_t *joint, float effort, float q_ref, float q);

/// Sets the load that your model of the arm computes, for example gravity, as an effort. It is added to u from the next
/// tick on, and is neither learned nor reported as a force. A bad load is counted and changes nothing.
void tribo_joint_f32_load(tribo_joint_f32_t *joint, float load);

/// Changes the gain, 0 to 1, while the joint runs; the term follows with a time constant of 0.1 s, upwards with
/// the actuator's lag if that is longer. Returns TRIBO_OK, or TRIBO_ERR_JOINT_GAIN for any other gain: above 1 it would
/// exceed the learned friction.
tribo_status_t tribo_joint_f32_gain(tribo_joint_f32_t *joint, float gain);

/// Puts the joint to rest, between two ticks, for example before the first tick after the drive was off. Learned values,
/// load, counters and a latched cause stay.
void tribo_joint_f32_rest(tribo_joint_f32_t *joint);

/// Clears the latched cause; the term rises again over 0.4 s (8 ticks, or 1.05 lags and 4 ticks, if these are longer).
/// Call it on command, once the cause is found. Learned values stay.
void tribo_joint_f32_restore(tribo_joint_f32_t *joint);

/// Returns the end-point force computed from the current. An arm that sticks may hold any force within its friction, so
/// the interval extends by 1.5 times the friction to either side, and by effort_max before friction is learned. While
/// the arm moves, `force` is free of friction, but contains the inertia's force.
tribo_joint_force_t tribo_joint_f32_force(const tribo_joint_f32_t *joint);

/// Writes the report. Not for the tick.
void tribo_joint_f32_report(const tribo_joint_f32_t *joint, tribo_joint_report_t *report);

/// Returns a sentence that explains a cause and says what to do. The term stays out until tribo_joint_f32_restore.
const char *tribo_joint_cause_text(tribo_joint_cause_t cause);

// --- contents of the types above: reserve room for them; write only the members whose comment says so ---------------

/// Constants of a tick.
typedef struct
{
    float    effort_max, half, fastest; ///< half of `travel`; what a motion of q may grow by in a tick, or it is a jump
    float    wrap, per_wrap;            ///< a turn and its reciprocal; 0: positions do not wrap
    float    gain, led;                 ///< the gain, and the gain where a hand leads
    float    jump;                      ///< largest change of the term in a tick, divided by the learned friction
    float    level_part, observer_part, actuator_part;
    float    fade_step;
    uint32_t rest_ticks;
} tribo_joint_f32_params_t;

/// A slide, from one reversal of q to the next. Its slow part is below half of the last slide's peak speed, where
/// viscous friction is small and the kinetic energy at both ends is the same.
typedef struct
{
    float    moved, effort; ///< low passes of the motion in a tick, and of the effort without the load
    float    slack;         ///< position of `moved` in a play of `travel`
    float    travel;        ///< travel of q in this slide
    float    asked[2];      ///< travel of q_ref, negative and positive, since the last slide that way
    float    work, slow_travel, slow_work;
    float    peak, knee; ///< largest speed of this slide; half of the last slide's
    float    mean[2];    ///< mean effort against the motion in the last counted slides, negative and positive
    uint32_t ticks;
    int8_t   side;
    uint8_t  follows;                ///< q_ref has differed from q
    uint8_t  has[2];                 ///< there is a mean for that direction
    uint8_t  ended;                  ///< 2 in the tick that ends one, then 1
    float    fast_travel, fast_work; ///< of that slide, beyond the knee; 0: hardly any
} tribo_joint_f32_slide_t;

struct tribo_joint_f32
{
    tribo_joint_f32_params_t params;
    uint8_t                  made, runs, learned;
    uint8_t                  cause;          ///< tribo_joint_cause_t, latched
    uint8_t                  against;        ///< number of slides in succession that gave energy
    uint8_t                  turns;          ///< changes of direction since q_ref came to rest
    uint8_t                  is_off;         ///< q is away from a resting q_ref
    int8_t                   sign, intended; ///< sign of the term; sign of the last motion of q_ref
    uint32_t                 still;          ///< ticks since q_ref moved, up to rest_ticks
    uint32_t                 alive;         ///< ticks until the term fades because the loop is off or the encoder fails
    float                    q_ref, q;      ///< in the last tick
    float                    moved;         ///< change of q in the last tick
    float                    slack, astray; ///< q_ref in a play of half a travel; motion away from q_ref
    float                    share;         ///< part of the term that the guard lets through
    float level, term, kept;                ///< kept: the part of the term that your loop's integral holds after a rest
    float load, lagged;                     ///< the load you set; u behind the actuator
    float friction, spread,
        offset; ///< learned: half of the difference of both directions, its deviation, half of their sum
    float                   direction;                 ///< low pass of the direction of motion, -1 to 1
    uint32_t                bad_inputs, limited_ticks; ///< since the init; they stop at UINT32_MAX
    tribo_joint_f32_slide_t slide;
};

#ifdef __cplusplus
}
#endif

#endif
