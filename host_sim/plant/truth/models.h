/// The truth models of this folder, for the list in truths.c. The paper's is in plant/truth.h.

#ifndef SIM_TRUTH_MODELS_H
#define SIM_TRUTH_MODELS_H

#include "plant/truth.h"

extern const sim_truth_ops_t sim_torque_truth;
extern const sim_truth_ops_t sim_coulomb_truth;
extern const sim_truth_ops_t sim_karnopp_truth;
extern const sim_truth_ops_t sim_armstrong_truth;
extern const sim_truth_ops_t sim_dahl_truth;
extern const sim_truth_ops_t sim_bristle_truth;
extern const sim_truth_ops_t sim_reset_integrator_truth;
extern const sim_truth_ops_t sim_bliman_sorine_truth;
extern const sim_truth_ops_t sim_lubricated_truth;
extern const sim_truth_ops_t sim_lugre_truth;
extern const sim_truth_ops_t sim_elasto_plastic_truth;
extern const sim_truth_ops_t sim_leuven_truth;
extern const sim_truth_ops_t sim_maxwell_slip_truth;
extern const sim_truth_ops_t sim_servo_mx106_truth;
extern const sim_truth_ops_t sim_servo_mx64_truth;
extern const sim_truth_ops_t sim_servo_xl330_truth;
extern const sim_truth_ops_t sim_servo_erob80_truth;

#endif
