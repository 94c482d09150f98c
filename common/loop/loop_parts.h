/// The method and the guard of a loop in the arithmetic of the file that includes this.

#ifndef COMMON_LOOP_PARTS_H
#define COMMON_LOOP_PARTS_H

#include "loop/loop_config.h"
#include "tribo_arithmetic.h"

/// The library's config, which names the method and the guard of `loop`: an init makes them in `feedforward` and `guard`.
static inline tribo_force_loop_f32_config_t common_loop_with_parts(const common_loop_config_t *loop,
                                                                   TRIBO(feedforward, params_t) * feedforward,
                                                                   TRIBO(guard, params_t) * guard)
{
    tribo_force_loop_f32_config_t config = loop->config;
    if (loop->is_sensorless)
    {
        config.method = TRIBO(sensorless, use)(feedforward, &loop->feedforward, &loop->sensorless);
    }
    else if (loop->feeds_forward)
    {
        config.method = TRIBO(feedforward, use)(feedforward, &loop->feedforward);
    }
    if (loop->guarded)
    {
        config.guard = TRIBO(guard, use)(guard, &loop->guard);
    }
    return config;
}

#endif
