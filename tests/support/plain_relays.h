/// Relays as in Figs. 12 and 13, recomputed sample by sample, as a reference for the model's.

#ifndef PLAIN_RELAYS_H
#define PLAIN_RELAYS_H

#include "friction/relay.h"
#include "tribo/friction_f32.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/// Lines of set1, set2, reset1, reset2.
typedef struct
{
    bool before[TRIBO_EDGE_WIDTH_MAX][4]; // the newest first
    bool trigger[2];
    bool output[2];
} plain_relays_t;

static inline plain_relays_t plain_relays_at_rest(void)
{
    plain_relays_t r = {.trigger = {false, false}};
    for (uint32_t i = 0; i < TRIBO_EDGE_WIDTH_MAX; i++)
    {
        r.before[i][0] = true; // n is 0: within both breakaways
        r.before[i][1] = true;
    }
    return r;
}

static inline void plain_relays_step(plain_relays_t *r, uint32_t width, const bool line[4])
{
    bool pulse[4];
    for (uint32_t i = 0; i < 4u; i++)
    {
        pulse[i] = line[i] && !r->before[width - 1u][i];
    }
    memmove(r->before[1], r->before[0], sizeof r->before - sizeof r->before[0]);
    memcpy(r->before[0], line, sizeof r->before[0]);
    for (uint32_t i = 0; i < 2u; i++)
    {
        const bool trigger = pulse[i] || pulse[i + 2u];
        r->output[i]       = trigger && !r->trigger[i] ? pulse[i] : r->output[i];
        r->trigger[i]      = trigger;
    }
}

#endif
