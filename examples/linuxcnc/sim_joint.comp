component sim_joint "The examples' joint with friction, in place of a drive and an encoder of 16,384 counts";
pin in float torque "N m";
pin in bit exchanged "The motor's phases: it turns the other way";
pin out float feedback "What the encoder reads, degrees";
pin out float truth "Where the joint is, degrees";
include "../sim/hinge.h";
variable hinge_t hinge;
function _ fp;
license "MIT";
;;
FUNCTION(_)
{
    hinge_step(&hinge, fperiod, exchanged ? -torque : torque);
    feedback = 360.0 * hinge_reading(&hinge, 16384.0);
    truth = 360.0 * hinge.angle;
}
