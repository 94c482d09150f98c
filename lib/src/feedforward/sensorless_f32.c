// The feed-forward without a force sensor in single precision.

#include "../number/ranges.h"
#include "learner.h"
#include "words_f32.h"

#include "reference.h"

#define FASTEST 1000.0f // largest credible motion in a tick, widths

#define ROW(...) PARAMETERS_ROW(tribo_sensorless_f32_config_t, __VA_ARGS__)
const tribo_parameter_t tribo_sensorless_parameters[] = {TRIBO_SENSORLESS_PARAMETERS(ROW)};
#undef ROW

static bool is_part(float x)
{
    return within(x, 0.0f, 1.0f);
}

static part_t part_exactly(float x)
{
    return x;
}

static float number_of_sum(wide_t x)
{
    return x;
}

#include "sensorless.h"

tribo_sensorless_f32_config_t tribo_sensorless_f32_default(void)
{
    const tribo_sensorless_f32_config_t standard = {TRIBO_SENSORLESS_PARAMETERS(PARAMETERS_DEFAULT)};
    return standard;
}
