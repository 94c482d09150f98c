// What both arithmetics of a joint share: constants, and the check of a config.

#ifndef TRIBO_JOINT_JOINT_CONFIG_H
#define TRIBO_JOINT_JOINT_CONFIG_H

#include "tribo/joint_f32.h"

#define JOINT_GAIN           0.97f
#define JOINT_LED            0.8f  // most of it where a hand leads: too much would drive the joint by itself
#define JOINT_UNLEARNED      2     // part of the believed friction that is used: one over that
#define JOINT_REST_TIME      0.05f // s without motion of q_ref
#define JOINT_FADE_TIME      0.05f // s, of the guard
#define JOINT_LEVEL_TIME     0.1f  // s, time constant of a change of what is taken out
#define JOINT_JUMP_TIME      2.1f  // of the term, over the lag from u to the joint
#define JOINT_LAG_TICKS      2.0f  // of that lag, beside the actuator's
#define JOINT_OBSERVER_TIME  0.8f  // over that lag
#define JOINT_OBSERVER_TICKS 5.0f
#define JOINT_OBSERVER_LEAST 0.01f   // s
#define JOINT_FASTEST        1000.0f // travels by which a motion may grow in a tick
#define JOINT_WRAP_MIN       100.0f  // travels
#define JOINT_WRAP_MAX       1.0e9f
#define JOINT_DEADBAND       4     // halves of a travel
#define JOINT_ASTRAY         64    // halves of a travel
#define JOINT_AHEAD          4     // rest times at the last knee
#define JOINT_MODEL          0.15f // of the friction: what a mean of slides leaves out
#define JOINT_SLOW_MIN       16    // halves of a travel
#define JOINT_SLOW_PART      16    // of a slide, one over that: a smaller part shows what accelerates the joint
#define JOINT_REBOUND        16    // of what q_ref asked for, likewise: less travel is no slide
#define JOINT_BRIEF          6     // time constants of the low pass
#define JOINT_VISCOUS        5     // eighths of the rise of friction from the slow to the fast part of a slide
#define JOINT_VISCOUS_MIN    8     // a smaller rise, friction divided by it, is none
#define JOINT_SLIDE_MIN      32    // halves of a travel
#define JOINT_SUPPORT        4     // times the effort that goes back, at rest
#define JOINT_TURNS          4u    // at rest
#define JOINT_AGAINST        4u    // slides
#define JOINT_INTERVAL       1.5f  // of the friction, on either side: what sticks may hold half more than what slides
#define JOINT_TICKS_MAX      (UINT32_C(1) << 20)

/// Returns TRIBO_OK or the status of the first wrong field.
tribo_status_t tribo_joint_config_check(const tribo_joint_config_t *config);

#endif
