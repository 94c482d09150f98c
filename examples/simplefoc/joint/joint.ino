// Friction compensation for SimpleFOC's own position control at 1 kHz. The lines between the marks are new; the others are your existing
// sketch.

#include <SimpleFOC.h>
// [add
#include "tribo/joint_f32.h"

static tribo_joint_f32_t joint;
// add]

BLDCMotor            motor = BLDCMotor(7);
BLDCDriver3PWM       driver = BLDCDriver3PWM(9, 10, 11, 8);
MagneticSensorSPI    sensor = MagneticSensorSPI(AS5147_SPI, 10);
InlineCurrentSense   current_sense = InlineCurrentSense(0.01f, 50.0f, A0, A2);

const float      CURRENT_MAX = 2.0f;           // A
const float      COUNT = 6.2831853f / 16384.0f; // rad per encoder count
volatile uint8_t ticks;                        // counts the timer's interrupts

void tick() // called by a 1 kHz timer
{
    ticks = ticks + 1;
}

void setup()
{
    sensor.init();
    motor.linkSensor(&sensor);
    driver.init();
    motor.linkDriver(&driver);
    current_sense.linkDriver(&driver);
    current_sense.init();
    motor.linkCurrentSense(&current_sense);
    motor.torque_controller = TorqueControlType::foc_current;
    motor.controller = MotionControlType::angle;
    motor.current_limit = CURRENT_MAX;
    motor.P_angle.P = 30.0f;
    motor.PID_velocity.P = 0.09f; // A s
    motor.PID_velocity.I = 0.0f;
    motor.motion_downsample = 0; // move() runs at the timer's rate
    motor.init();
    motor.initFOC();
    motor.target = motor.shaft_angle; // the motor stays where it is
    // [add
    tribo_joint_config_t config = tribo_joint_config(); // units: A and rad
    config.sample_time_s = 0.001f;
    config.effort_max = CURRENT_MAX;
    config.travel = 4 * COUNT;
    if (tribo_joint_f32_init(&joint, &config) != TRIBO_OK)
        motor.disable();
    // add]
    start_timer(tick, 1000); // your board's timer: HardwareTimer, IntervalTimer, esp_timer
}

void loop()
{
    motor.loopFOC(); // as often as possible
    static uint8_t seen;
    const uint8_t  waiting = ticks - seen;
    seen += waiting;
    if (waiting == 1 && motor.enabled)
    {
        motor.move();
        // [add
        motor.current_sp = tribo_joint_f32_step(&joint, motor.current_sp, motor.target, motor.shaft_angle);
        // add]
    }
    else if (waiting > 1)
    {
        motor.disable(); // a tick was missed
    }
    // [add
    if (!motor.enabled) tribo_joint_f32_rest(&joint); // it would learn from what does not reach the motor
    // add]
}
