#include "tribo/play_q31.h"

#include "limit_q31.h"
#include "play_q31_step.h"

#define PLAY_MAX (INT32_C(1) << 30)

void tribo_play_q31_reset(tribo_play_q31_state_t *state, int32_t position)
{
    state->position = limit_q31(position, -PLAY_MAX, PLAY_MAX);
    state->way      = 0;
}

int32_t tribo_play_q31_step(tribo_play_q31_state_t *state, int32_t x, int32_t below, int32_t above)
{
    return play_q31_step(state,
                         limit_q31(x, -PLAY_MAX, PLAY_MAX),
                         limit_q31(below, 0, PLAY_MAX),
                         limit_q31(above, 0, PLAY_MAX));
}
