/// All truth models, and their parameters by name.

#ifndef SIM_TRUTHS_H
#define SIM_TRUTHS_H

#include "plant/truth.h"

/// The paper's model first; sim_truth_count of them.
extern const sim_truth_ops_t *const sim_truths[];
extern const size_t                 sim_truth_count;

/// Null if there is no model of that name.
const sim_truth_ops_t *sim_truth_find(const char *name);

/// Null if the model has no such parameter.
const sim_truth_parameter_t *sim_truth_parameter_find(const sim_truth_ops_t *truth, const char *name);

/// Writes the defaults to a parameter struct of truth->parameters_size bytes.
void sim_truth_parameters_default(const sim_truth_ops_t *truth, void *parameters);

/// Writes one parameter. False, and nothing written, if the model has none of that name or the value is out of range.
bool sim_truth_parameter_set(const sim_truth_ops_t *truth, void *parameters, const char *name, double value);

#endif
