// A force loop in a SimpleFOC sketch, 2.4.0 and later. The lines between the marks are new; the others are your existing sketch.

#include <SimpleFOC.h>

BLDCMotor          motor         = BLDCMotor(7);
BLDCDriver3PWM     driver        = BLDCDriver3PWM(9, 10, 11, 8);
MagneticSensorSPI  sensor        = MagneticSensorSPI(AS5147_SPI, 10);
InlineCurrentSense current_sense = InlineCurrentSense(0.01f, 50.0f, A0, A2);

// [add
#include "rig_1khz_f32.h"

const float      AMPERE_PER_N = 0.8f; // u in N is the force at rest without friction
const uint8_t    BAD_MAX      = 20;   // bad readings in succession
volatile float   reference_n;
volatile uint8_t ticks; // counts the timer's interrupts

static tribo_force_loop_f32_state_t   force_loop;
static tribo_feedforward_f32_memory_t memory;

float read_force_n(); // write this; it returns NAN if there is no reading

float force_control(FOCMotor *)
{
    static uint8_t bad;
    const uint32_t before = force_loop.bad_inputs;
    const float    u_n    = tribo_force_loop_f32_step(&rig_params, &force_loop, reference_n, read_force_n(), NULL);
    tribo_feedforward_f32_learn(&rig_params, &memory);
    bad = force_loop.bad_inputs == before ? 0 : bad < BAD_MAX ? bad + 1 : BAD_MAX;
    if (bad >= BAD_MAX)
    {
        motor.disable();
    }
    return AMPERE_PER_N * u_n;
}

void force_tick() // called by a 1 kHz timer
{
    ticks = ticks + 1;
}

void force_start()
{
    force_loop.memory = &memory.state.tick;
    (void)tribo_force_loop_f32_start(&force_loop, &rig_params, false);
    motor.linkCustomMotionControl(force_control);
    motor.controller        = MotionControlType::custom;
    motor.motion_downsample = 0; // move() runs at the timer's rate, which must be the rig's
}
// add]

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
    motor.current_limit     = 2.0f;
    motor.init();
    motor.initFOC();
    force_start();
    start_timer(force_tick, 1000); // your board's timer: HardwareTimer, IntervalTimer, esp_timer
}

void loop()
{
    motor.loopFOC(); // as often as possible
    // [add
    static uint8_t seen;
    const uint8_t  waiting = ticks - seen;
    seen += waiting;
    if (!motor.enabled)
    {
        motor.current_sp = 0;
        (void)tribo_force_loop_f32_start(&force_loop, &rig_params, true); // at rest when you enable it again
    }
    if (waiting == 1)
    {
        motor.move();
    }
    else if (waiting > 1)
    {
        motor.disable(); // a tick was missed
    }
    // add]
}
