/// A stand-in for SimpleFOC: only the types that the sketches use, with the meaning that version 2.4 gives them. Its motor
/// drives the examples' arm or joint: see main.cpp and joint.cpp.

#ifndef EXAMPLES_STAND_IN_SIMPLEFOC_H
#define EXAMPLES_STAND_IN_SIMPLEFOC_H

#include <stddef.h>
#include <stdint.h>

#define A0         0
#define A2         2
#define AS5147_SPI 0

enum class MotionControlType
{
    torque,
    velocity,
    angle,
    custom
};
enum class TorqueControlType
{
    voltage,
    foc_current
};

struct DQCurrent_s
{
    float d, q;
};

/// A PI controller for the 1 kHz at which the sketches call move().
struct PIDController
{
    float P = 0, I = 0, integral = 0;

    float operator()(float error)
    {
        integral += 0.001f * I * error;
        return P * error + integral;
    }
};

class FOCMotor {
  public:
    virtual ~FOCMotor()
    {
    }
    float target = 0, current_sp = 0, current_limit = 0, shaft_angle = 0, shaft_velocity = 0, feed_forward_velocity = 0;
    PIDController     P_angle, PID_velocity;
    DQCurrent_s       feed_forward_current = {0, 0};
    int8_t            enabled              = 0;
    unsigned          motion_downsample    = 0;
    MotionControlType controller           = MotionControlType::torque;
    TorqueControlType torque_controller    = TorqueControlType::voltage;

    void linkCustomMotionControl(float (*method)(FOCMotor *))
    {
        custom = method;
    }
    void initFOC()
    {
        shaft_angle = __builtin_nanf(""); // not yet measured
        sense();
        enabled = 1;
    }
    void enable()
    {
        enabled = 1;
    }
    void disable()
    {
        enabled = 0;
    }
    void move()
    {
        if (motion_count++ < motion_downsample)
        {
            return;
        }
        motion_count = 0;
        sense();
        if (enabled)
        {
            current_sp = controller == MotionControlType::custom && custom ? custom(this)
                         : controller == MotionControlType::angle
                             ? PID_velocity(feed_forward_velocity + P_angle(target - shaft_angle) - shaft_velocity)
                             : target;
        }
    }

    /// Adds feed_forward_current to the set-point at each call, as SimpleFOC does; only move() sets the set-point again.
    void loopFOC()
    {
        const float limited = current_sp > current_limit    ? current_limit
                              : current_sp < -current_limit ? -current_limit
                                                            : current_sp;
        current_sp          = limited + feed_forward_current.q;
        flows(enabled ? current_sp : 0.0f);
    }

  private:
    void flows(float ampere); // main.cpp, joint.cpp
    void sense();
    float (*custom)(FOCMotor *) = nullptr;
    unsigned motion_count       = 0;
};

struct MagneticSensorSPI
{
    MagneticSensorSPI(int, int)
    {
    }
    void init()
    {
    }
};
struct BLDCDriver3PWM
{
    BLDCDriver3PWM(int, int, int, int)
    {
    }
    void init()
    {
    }
};
struct InlineCurrentSense
{
    InlineCurrentSense(float, float, int, int)
    {
    }
    void linkDriver(BLDCDriver3PWM *)
    {
    }
    void init()
    {
    }
};
struct BLDCMotor : FOCMotor
{
    explicit BLDCMotor(int)
    {
    }
    void linkSensor(MagneticSensorSPI *)
    {
    }
    void linkDriver(BLDCDriver3PWM *)
    {
    }
    void linkCurrentSense(InlineCurrentSense *)
    {
    }
    void init()
    {
    }
};

void start_timer(void (*tick)(), int hertz);

#endif
