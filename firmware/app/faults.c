#include "app/faults.h"

#include "app/scaling.h"

static uint32_t ticks_of(uint32_t ms, uint32_t period_us)
{
    return (ms * 1000u + period_us - 1u) / period_us;
}

void faults_init(faults_bounds_t *bounds, const drive_config_t *config)
{
    *bounds = (faults_bounds_t){.residual            = scaling_number(config->residual_n, config->full_scale_n),
                                .tare_max            = scaling_number(config->tare_max_n, config->full_scale_n),
                                .residual_ticks      = ticks_of(config->residual_ms, config->period_us),
                                .command_limit_ticks = ticks_of(config->command_limit_ms, config->period_us),
                                .reference_ticks     = ticks_of(config->reference_ms, config->period_us),
                                .ready_ticks         = ticks_of(config->ready_ms, config->period_us)};
    if (config->residual_n > 0.0f && bounds->residual == 0)
    {
        bounds->residual = tribo_force_of_word(1u); // the smallest nonzero: 0 means off
    }
}
