/// A stand-in for mjbots' C++ client: only the types that force.cc uses. It has no bus; it drives the examples' arm.

#ifndef EXAMPLES_STAND_IN_MOTEUS_H
#define EXAMPLES_STAND_IN_MOTEUS_H

#include "../../sim/arm.h"

#include <cmath>

namespace mjbots {
namespace moteus {

enum Resolution
{
    kFloat,
    kIgnore
};
enum Register
{
    kAux1AnalogIn1 = 0x060
};
enum class Mode
{
    kStopped  = 0,
    kFault    = 1,
    kPosition = 10
};

struct Query
{
    struct ItemValue
    {
        int    register_number = 0;
        double value           = 0;
    };
    struct Result
    {
        Mode      mode = Mode::kStopped;
        ItemValue extra[16];
    };
    struct ItemFormat
    {
        int        register_number = 0;
        Resolution resolution      = kIgnore;
    };
    struct Format
    {
        ItemFormat extra[16];
    };
};

struct PositionMode
{
    struct Command
    {
        double position = 0, feedforward_torque = 0, kp_scale = 1, kd_scale = 1, maximum_torque = NAN,
               watchdog_timeout = NAN;
    };
    struct Format
    {
        Resolution position = kFloat, feedforward_torque = kIgnore, kp_scale = kIgnore, kd_scale = kIgnore,
                   maximum_torque = kIgnore, watchdog_timeout = kIgnore;
    };
};

class Controller {
  public:
    struct Options
    {
        int                  id = 1;
        PositionMode::Format position_format;
        Query::Format        query_format;
    };
    struct Result
    {
        Query::Result values;
    };

    /// Does what std::optional does.
    struct Optional
    {
        bool     there = false;
        Result   result;
        explicit operator bool() const
        {
            return there;
        }
        const Result *operator->() const
        {
            return &result;
        }
    };

    explicit Controller(const Options &with) : options(with)
    {
    }

    void SetStop()
    {
        mode = Mode::kStopped;
    }

    Optional SetQuery()
    {
        Optional answer;
        answer.there                        = !silent;
        answer.result.values.mode           = mode;
        answer.result.values.extra[0].value = blind ? NAN : 0.5 + arm.reading_n / 4.0;
        return answer;
    }

    /// The drive ignores each field that the format leaves out.
    Optional SetPosition(const PositionMode::Command &command)
    {
        const PositionMode::Format &format = options.position_format;
        const bool torque_alone = std::isnan(command.position) && format.kp_scale == kFloat && command.kp_scale == 0 &&
                                  format.kd_scale == kFloat && command.kd_scale == 0;
        const bool watched = format.watchdog_timeout == kFloat && command.watchdog_timeout < 0.1;
        mode               = faulty || !torque_alone || !watched ? Mode::kFault : Mode::kPosition;
        arm_step(&arm, ARM_500HZ, mode == Mode::kPosition ? static_cast<float>(command.feedforward_torque) : 0.0f);
        return SetQuery();
    }

    Options options;
    arm_t   arm    = {};
    Mode    mode   = Mode::kStopped;
    bool    faulty = false, silent = false, blind = false;
};

} // namespace moteus
} // namespace mjbots

#endif
