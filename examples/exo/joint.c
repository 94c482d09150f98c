// Adds friction compensation to your own controller: the paper's compensator and the guard. The feed-forward is not used
// because it shapes the error of the library's controller; this method needs only the torque that goes to the motor.

#include "joint.h"

// [add
#include "tribo/force_loop_f32.h"

#define PERIOD_S  0.002f
#define GAIN      0.85f // eta; start with 0.3
#define U_MAX_N_M 2.0f  // limit of the motor's torque

static tribo_compensator_f32_params_t params;
static tribo_compensator_f32_state_t  state;
static tribo_guard_f32_params_t       guard_params;
static tribo_guard_f32_state_t        guard;
static float                          friction, fade = 1.0f;

bool joint_start(void)
{
    const tribo_breakaway_f32_t    breakaway = {.offset_n = 0.007f, .slope = 0.3f}; // N m, fraction of torque: yours
    tribo_compensator_f32_config_t joint     = tribo_force_loop_f32_rig().compensator;
    const tribo_guard_f32_config_t limits    = tribo_guard_f32_default();
    joint.friction.positive = joint.friction.negative = breakaway;
    joint.arm = (tribo_arm_f32_config_t){.inertia = 1.2e-4f, .damping = 0.0288f, .stiffness = 3.84f}; // set yours
    tribo_compensator_f32_reset(&state);
    tribo_guard_f32_reset(&guard);
    return tribo_compensator_f32_init(&params, &joint, PERIOD_S) == TRIBO_OK &&
           tribo_guard_f32_init(&guard_params, &limits, PERIOD_S) == TRIBO_OK;
}

float joint_step(float command_n_m, float measured_n_m, float controller_n_m)
{
    tribo_compensator_f32_signals_t signals;
    const float                     term = fade * GAIN * friction;
    float                           u    = controller_n_m + term;
    u                                    = u > U_MAX_N_M ? U_MAX_N_M : u < -U_MAX_N_M ? -U_MAX_N_M : u == u ? u : 0.0f;
    friction                             = tribo_compensator_f32_step(&params, &state, u, &signals);
    fade = tribo_guard_f32_step(&guard_params, &guard, command_n_m, measured_n_m, term, true);
    return u;
}
// add]
