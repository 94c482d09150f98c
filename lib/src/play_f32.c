#include "tribo/play_f32.h"

#include "ieee_f32.h"
#include "play_f32_step.h"

void tribo_play_f32_reset(tribo_play_f32_state_t *state, float position_n)
{
    state->position_n = position_n;
    state->way        = 0;
}

float tribo_play_f32_step(tribo_play_f32_state_t *state, float x_n, float below_n, float above_n)
{
    const bool good = !exceeds(x_n, TRIBO_F32_FORCE_MAX_N) && within(below_n, 0.0f, TRIBO_F32_FORCE_MAX_N) &&
                      within(above_n, 0.0f, TRIBO_F32_FORCE_MAX_N);
    return good ? play_f32_step(state, x_n, below_n, above_n) : 0.0f;
}
