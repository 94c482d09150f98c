component tribo_joint "Compensates the friction of a joint from its current and encoder, by tribo";
pin in float command "Commanded position, e.g. joint.N.motor-pos-cmd";
pin in float feedback "Measured position in the same unit, e.g. joint.N.motor-pos-fb";
pin in float effort "Output of your position loop, e.g. pid.x.output";
pin in bit enable "Connect to the machine's amp-enable-out; its rising edge restores a friction term that the guard has removed";
pin out float output "Effort for the drive, with the friction term; 0 while enable is off";
pin out float offset "The friction term alone, for a drive with its own position loop";
pin out float learned "Learned friction, in the unit of effort";
pin out bit fault "Set if a parameter is refused; the log names it. Cleared when enable falls";
pin out s32 guard "Why the guard has removed the friction term: 0 not removed, 1 astray, 2 hunting, 3 reversed";
param rw float effort_limit = 0 "Limit of the output";
param rw float least_motion = 0 "Smallest motion above the noise: four counts of the encoder";
param rw float friction_gain = 0.97 "Fraction of the friction to compensate, 0 to 1";
include <math.h>;
include "tribo/joint_f32.h";
variable tribo_joint_f32_t joint;
variable unsigned made;
variable unsigned running;
variable double gain_set;
function _ fp "Add once to a thread, after the position loop";
license "MIT";
;;
static tribo_status_t made_of(struct __comp_state *__comp_inst, double period_s)
{
    tribo_joint_config_t config = tribo_joint_config();
    config.sample_time_s = period_s;
    config.effort_max = effort_limit;
    config.travel = least_motion;
    config.gain = friction_gain;
    return tribo_joint_f32_init(&joint, &config);
}

static void start(struct __comp_state *__comp_inst, double period_s)
{
    const tribo_status_t status = made ? TRIBO_OK : made_of(__comp_inst, period_s);
    if (status != TRIBO_OK) {
        rtapi_print_msg(RTAPI_MSG_ERR, "tribo-joint: %s\n", tribo_status_text(status));
    }
    made = status == TRIBO_OK; // learned values stay while the machine is off
    gain_set = made ? gain_set : friction_gain;
    tribo_joint_f32_restore(&joint);
}

FUNCTION(_)
{
    if (enable && !running) {
        start(__comp_inst, fperiod);
    }
    running = enable;
    if (friction_gain != gain_set && tribo_joint_f32_gain(&joint, friction_gain) == TRIBO_OK) {
        gain_set = friction_gain;
    }
    fault = enable && !made;
    const double limit = effort_limit > 0 ? effort_limit : 0;
    double u = 0;
    if (enable) {
        u = tribo_joint_f32_step(&joint, (float)effort, (float)command, (float)feedback);
        u = fmax(-limit, fmin(u, limit)); // the joint has the limit of its first start
    } else {
        tribo_joint_f32_rest(&joint); // what does not reach the motor must not be learned
    }
    const double own = isnan(effort) ? 0 : fmax(-limit, fmin(effort, limit));
    output = enable && made ? u : 0;
    offset = enable && made ? u - own : 0;
    tribo_joint_report_t report;
    tribo_joint_f32_report(&joint, &report);
    learned = report.friction;
    guard = report.cause;
}
