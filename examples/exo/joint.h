/// Friction compensation for a joint that already has a controller.

#ifndef EXAMPLES_EXO_JOINT_H
#define EXAMPLES_EXO_JOINT_H

#include <stdbool.h>

bool  joint_start(void); ///< call once, before the first tick; false if the parameters are refused
float joint_step(float command_n_m,
                 float measured_n_m,
                 float controller_n_m); ///< call at 500 Hz; returns the torque for the motor

#endif
