component tribo_force "Force control that compensates friction, by tribo";
pin in float ref "Force that is wanted, N";
pin in float force "The sensor's, N";
pin in bit enable "From the machine's amp-enable-out";
pin out float command "Force for the drive, N; 0 without enable";
pin out bit fault "The thread's period is not the rig's, or 20 readings in succession were bad. Until enable falls";
pin out s32 guard "Why friction is faded: 0 it is not, 1 hunting, 2 overshoot";
include "rig_1khz_f32.h";
variable tribo_force_loop_f32_state_t loop;
variable tribo_feedforward_f32_memory_t learned;
variable unsigned bad;
variable unsigned running;
function _ fp "Once in a thread of the rig's period";
option extra_setup;
license "MIT";
;;
#undef guard // the pin: the state has a member of that name

static void start(struct __comp_state *__comp_inst)
{
    loop.memory = &learned.state.tick;
    tribo_force_loop_f32_start(&loop, &rig_params, true); // what it learns it keeps while the machine is off
    tribo_guard_f32_restore(&loop.guard);
    bad = 0;
    fault = 0;
}

EXTRA_SETUP()
{
    tribo_feedforward_f32_reset(&learned.state);
    return 0;
}

FUNCTION(_)
{
    if (!enable || !running) {
        start(__comp_inst);
        fault = enable && (fperiod < 0.99 * RIG_SAMPLE_TIME_S || fperiod > 1.01 * RIG_SAMPLE_TIME_S);
        running = enable;
    }
    const unsigned before = loop.bad_inputs;
    const float u = tribo_force_loop_f32_step(&rig_params, &loop, (float)ref, (float)force, NULL);
    tribo_feedforward_f32_learn(&rig_params, &learned);
    bad = loop.bad_inputs != before ? bad + 1 : 0;
    fault = fault || bad >= 20;
    command = enable && !fault ? u : 0;
    *__comp_inst->guard = loop.guard.cause;
}
