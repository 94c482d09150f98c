component sim_joint "Simulates the examples' joint with friction, in place of a drive and an encoder of 16,384 counts";
pin in float torque "Torque of the drive, N m";
pin in bit exchanged "Exchanges the motor's phases, so that it turns the other way";
pin out float feedback "Reading of the encoder, degrees";
pin out float truth "True position, degrees";
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
