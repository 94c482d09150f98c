/// A joint with current and encoder: takes friction out beside a loop of yours, single precision.
///
///     u = limit(effort + load + term)        term: the friction that opposes the intended motion, learned from the loop's own effort
///
///     static tribo_joint_f32_t joint;
///     tribo_joint_config_t     config = tribo_joint_config(); // empty: refused until the joint is in it
///     ...
///     tribo_status_t status = tribo_joint_f32_init(&joint, &config);
///     u = tribo_joint_f32_step(&joint, my_loop(q_ref, q), q_ref, q); // every tick
///
/// The loop may control position, velocity or impedance, or hold the joint against gravity. q_ref is where the joint shall be, q where it is: both
/// radians, counts, or metres. With a velocity loop q_ref is the integral of its reference. Where a hand leads the joint give q for q_ref.
/// Effort is what the loop puts out: N m, N, or A.
///
/// Direction. While q_ref moves friction opposes its motion. While it rests friction opposes the way back to it, once the joint is off by two
/// `travel`; from the second change of direction on each halves the term until q_ref moves again, so that what hunts dies out. Nearer than
/// that the term gives way to an effort that opposes it. The term alone never moves a resting joint: without an effort (a loop that is off)
/// there is none.
///
/// Learning. From a reversal to the next (a slide) no kinetic energy is left over, so the effort's work is that of friction and load; slides in
/// either direction tell the two apart. The slow part of a slide counts, since viscous friction is no part of breakaway. Only slides count
/// that q_ref asked for, 16 `travel` or longer.
///
/// Guard. Once it notices, it fades the term within 0.1 s, says why, and stays until tribo_joint_f32_restore: where the joint runs away from q_ref with
/// its term, where it hunts at rest, where slides give more energy than they take (effort or encoder have the wrong sign).
///
/// No heap, no libm. One division at the end of a slide, none in any other tick. Not synchronized: one joint, one tick.

#ifndef TRIBO_JOINT_F32_H
#define TRIBO_JOINT_F32_H

#include "tribo/status.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct tribo_joint_f32 tribo_joint_f32_t;

/// Units of effort and of q are those of your loop.
typedef struct
{
    float sample_time_s; ///< of every tick, 1e-6 to 0.1 s
    float effort_max;    ///< limit of |u|, 1e-6 to 1e6
    float
        travel; ///< least change of q that is motion and no noise: four counts of the encoder; 1e-9 to 1e6; Q31: in counts, 1 to 1e4
    float
        breakaway; ///< friction as you believe it, 0 to effort_max; half of it is used until it is learned. 0: nothing is
    float actuator_pole_rad_per_s; ///< of the current loop, 1e-3 to 1e6; 0: fast
    float gain; ///< part of the learned friction that is taken out, 0 to 1; at most 0.9 of it where a hand leads
} tribo_joint_config_t;

typedef enum
{
    TRIBO_JOINT_SOUND = 0,
    TRIBO_JOINT_ASTRAY,  ///< it moved away from q_ref, with its term, and q_ref did not ask for it
    TRIBO_JOINT_HUNTING, ///< it went to and fro about a resting q_ref
    TRIBO_JOINT_REVERSED ///< the effort has gained energy from friction: its sign or the encoder's is wrong
} tribo_joint_cause_t;

/// For both arithmetics, in your units.
typedef struct
{
    float               friction, low, high; ///< learned, and the interval in which it is
    float               load;                ///< that does not reverse, beside the one given; the loop holds it
    float               share;               ///< of the term that the guard lets through, 0 to 1
    bool                is_learned;          ///< false: `friction` is as configured
    tribo_joint_cause_t cause;
    uint32_t            bad_inputs, limited_ticks;
} tribo_joint_report_t;

/// What the joint does to its surroundings, less what holds it: positive drives q up.
typedef struct
{
    float force, low, high;
} tribo_joint_force_t;

/// All that depends on the joint is 0 and refused; gain is 0.97.
tribo_joint_config_t tribo_joint_config(void);

/// Makes a joint at rest that has learned nothing. Returns TRIBO_OK, TRIBO_ERR_NULL, TRIBO_ERR_SAMPLE_TIME, TRIBO_ERR_JOINT_EFFORT,
/// TRIBO_ERR_JOINT_TRAVEL, TRIBO_ERR_JOINT_BREAKAWAY, TRIBO_ERR_JOINT_POLE or TRIBO_ERR_JOINT_GAIN. Writes nothing unless TRIBO_OK. Not for the tick.
tribo_status_t tribo_joint_f32_init(tribo_joint_f32_t *joint, const tribo_joint_config_t *config);

/// One tick: u for the drive, within +-effort_max whatever comes in; 0 before the init. A bad effort counts as 0, a bad q_ref or q as
/// one that has not moved; both are counted. Give your loop's output before its own limit.
float tribo_joint_f32_step(tribo_joint_f32_t *joint, float effort, float q_ref, float q);

/// The load by a model of the arm, e.g. gravity, as effort: added to u from the next tick on, and neither learned nor told as a force. A bad one is
/// counted and changes nothing.
void tribo_joint_f32_load(tribo_joint_f32_t *joint, float load);

/// Another gain, 0 to 1, while it runs; the term follows in a third of a second. Returns TRIBO_OK or TRIBO_ERR_JOINT_GAIN: more than the learned friction
/// is refused.
tribo_status_t tribo_joint_f32_gain(tribo_joint_f32_t *joint, float gain);

/// By command, once the cause is found: the term comes back in a third of a second. What is learned stays.
void tribo_joint_f32_restore(tribo_joint_f32_t *joint);

/// The end-point force from current. An arm that sticks may hold anything within its friction: the interval is 1.5 times that on either side, and as
/// wide as 2 effort_max before anything is learned. Where it moves, `force` is without friction; acceleration is not taken out.
tribo_joint_force_t tribo_joint_f32_force(const tribo_joint_f32_t *joint);

/// Not for the tick.
void tribo_joint_f32_report(const tribo_joint_f32_t *joint, tribo_joint_report_t *report);

/// A sentence on a cause.
const char *tribo_joint_cause_text(tribo_joint_cause_t cause);

// --- contents of the types above: reserve room for them; write only the members whose comment says so ---------------

/// Constants of a tick.
typedef struct
{
    float    effort_max, half, fastest; ///< half of `travel`; motion of a tick that is none
    float    gain, led;                 ///< as asked for; where a hand leads
    float    jump;                      ///< of the term a tick, over the learned friction
    float    level_part, observer_part, actuator_part;
    float    fade_step;
    uint32_t rest_ticks;
} tribo_joint_f32_params_t;

/// A slide: from a reversal of q to the next. `slow` is the part of it below half of the last slide's peak speed: there is no viscous
/// friction worth the name, and kinetic energy is the same at both ends of the rest.
typedef struct
{
    float    moved, effort; ///< motion of a tick, and effort without the load; low passes
    float    slack;         ///< of moved, in a play of `travel`
    float    travel;        ///< of q
    float    asked[2];      ///< travel of q_ref, negative and positive, since the last slide that way
    float    work, slow_travel, slow_work;
    float    peak, knee; ///< largest speed of this slide; half of the last one's
    float    mean[2];    ///< effort against the motion, of the last slides that counted: negative, positive
    uint32_t ticks;
    int8_t   side;
    uint8_t  follows; ///< q_ref has been other than q
    uint8_t  has[2];  ///< means
} tribo_joint_f32_slide_t;

struct tribo_joint_f32
{
    tribo_joint_f32_params_t params;
    uint8_t                  made, runs, learned;
    uint8_t                  cause;             ///< tribo_joint_cause_t, latched
    uint8_t                  against;           ///< slides in succession that gave energy
    uint8_t                  turns;             ///< of the direction since q_ref came to rest
    uint8_t                  is_off;            ///< q is away from a resting q_ref
    int8_t                   sign, intended;    ///< of the term; of the last motion of q_ref
    uint32_t                 still;             ///< ticks since q_ref moved, up to rest_ticks
    uint32_t                 idle;              ///< ticks in which the loop is off or the encoder fails
    float                    q_ref, q;          ///< of the last tick
    float                    slack, astray;     ///< of q_ref, in a play of half a travel; motion away from q_ref
    float                    share;             ///< of the term that the guard lets through
    float                    level, term, kept; ///< kept: what the loop's integral has of the term after a rest
    float                    load, lagged;      ///< as given; u behind the actuator
    float                    friction, spread,
        offset; ///< learned: half of the difference of both directions, its deviation, half of their sum
    float                   direction;                 ///< of the motion, low pass of -1 to 1
    uint32_t                bad_inputs, limited_ticks; ///< since the init; they stop at UINT32_MAX
    tribo_joint_f32_slide_t slide;
};

#ifdef __cplusplus
}
#endif

#endif
