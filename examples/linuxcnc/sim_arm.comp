component sim_arm "The examples' arm with friction, at 1 kHz, in place of a drive, an axis and a force sensor";
pin in float command "N";
pin in bit broken "The sensor's wire: it reads NaN";
pin out float force "What the sensor reads, N";
pin out float truth "The force itself, N";
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
