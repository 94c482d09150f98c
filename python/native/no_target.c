// In place of host_sim/target: an emulator needs fork, signals and a serial line. Neither the package nor the playground plays a run on one.

#include "target/target.h"

#include <stddef.h>

sim_target_t *sim_target_start(const char                 *name,
                               bool                        q31,
                               const common_loop_config_t *config,
                               double                      full_scale_n,
                               common_error_t             *error)
{
    (void)q31, (void)config, (void)full_scale_n;
    (void)common_error_set(error, "%s: targets are tribo-sim's", name);
    return NULL;
}

bool sim_target_step(sim_target_t                   *target,
                     double                          r_n,
                     double                          y_n,
                     double                         *u_n,
                     tribo_force_loop_f32_signals_t *signals,
                     common_error_t                 *error)
{
    (void)target, (void)r_n, (void)y_n, (void)u_n, (void)signals, (void)error;
    return false;
}

const sim_loop_t *sim_target_twin(const sim_target_t *target)
{
    (void)target;
    return NULL;
}

bool sim_target_finish(sim_target_t *target, sim_target_result_t *result, common_error_t *error)
{
    (void)target, (void)result, (void)error;
    return false;
}

void sim_target_destroy(sim_target_t *target)
{
    (void)target;
}
