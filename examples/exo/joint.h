/// Friction compensation for a joint that has a controller already.

#ifndef EXAMPLES_EXO_JOINT_H
#define EXAMPLES_EXO_JOINT_H

#include <stdbool.h>

bool  joint_start(void); ///< once, before the first tick; false: the parameters are refused
float joint_step(float command_n_m,
                 float measured_n_m,
                 float controller_n_m); ///< at 500 Hz; returns the motor's torque

#endif
