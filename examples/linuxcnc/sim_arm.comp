component sim_arm "Simulates the examples' arm with friction at 1 kHz, in place of a drive, an axis and a force sensor";
pin in float command "N";
pin in bit broken "Breaks the sensor's wire: force reads NaN";
pin out float force "Reading of the sensor, N";
pin out float truth "True force, N";
include "../sim/arm.h";
variable arm_t arm;
function _ fp;
license "MIT";
;;
FUNCTION(_)
{
    arm_step(&arm, ARM_1KHZ, (float)command);
    force = broken ? 0.0 / 0.0 : arm.reading_n;
    truth = arm.force_n;
}
