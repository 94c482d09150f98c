component tribo_force "Force control that compensates friction, by tribo";
pin in float ref "Target force, N";
pin in float force "Measured force, N";
pin in bit enable "Connect to the machine's amp-enable-out";
pin out float command "Force command for the drive, N; 0 while enable is off";
pin out bit fault "Set if the thread's period is not the rig's, or after 20 consecutive bad readings. Cleared when enable falls";
pin out s32 guard "Why the guard has faded friction out: 0 not faded, 1 hunting, 2 overshoot";
include "rig_1khz_f32.h";
variable tribo_force_loop_f32_state_t loop;
variable tribo_feedforward_f32_memory_t learned;
variable unsigned bad;
variable unsigned running;
function _ fp "Add once to a thread whose period is the rig's";
option extra_setup;
license "MIT";
;;
#undef guard // macro of the pin; the state has a member of that name

static void start(struct __comp_state *__comp_inst)
{
    loop.memory = &learned.state.tick;
    tribo_force_loop_f32_start(&loop, &rig_params, true); // learned values stay while the machine is off
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
    command = 0;
    if (enable && !fault) { // what does not reach the motor must not be learned
        const unsigned before = loop.bad_inputs;
        const float u = tribo_force_loop_f32_step(&rig_params, &loop, (float)ref, (float)force, NULL);
        tribo_feedforward_f32_learn(&rig_params, &learned);
        bad = loop.bad_inputs != before ? bad + 1 : 0;
        fault = bad >= 20;
        command = fault ? 0 : u;
    }
    *__comp_inst->guard = loop.guard.cause;
}
