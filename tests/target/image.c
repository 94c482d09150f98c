// The least program with a loop in it, linked without a C library's start-up: its size is what the loop costs in flash, the
// compiler's helpers and its params included, which tribo-sim params has made. With IMAGE_INIT it makes them itself, with
// IMAGE_FED it feeds friction forward.

#include "tribo_arithmetic.h"

static TRIBO(force_loop, state_t) state;
static TRIBO(force_loop, signals_t) signals;

#ifdef IMAGE_FED
static TRIBO(feedforward, memory_t) memory;
#endif
#ifdef IMAGE_INIT
static TRIBO(force_loop, params_t) params;
#else
#include RIG_HEADER
#ifdef IMAGE_FED
#define params fed_params
#else
#define params golden_params
#endif
#endif

volatile tribo_force_t image_r, image_y, image_u;

int main(void);

int main(void)
{
#ifdef IMAGE_INIT
    const tribo_force_loop_f32_config_t config = tribo_force_loop_f32_paper();
    if (tribo_init_loop(&params, NULL, &config, 2.0f) != TRIBO_OK)
    {
        return 1;
    }
#endif
#ifdef IMAGE_FED
    state.memory = &memory.state.tick;
#endif
    (void)TRIBO(force_loop, start)(&state, &params, false);
    for (;;)
    {
        image_u = TRIBO(force_loop, step)(&params, &state, image_r, image_y, &signals);
    }
}
