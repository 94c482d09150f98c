// The two functions that the example in docs/integration.md leaves to its reader, and a main that runs it on a simple plant.

#include "tribo/status.h"

#include <stdio.h>

float          read_force_n(void);
void           command_force_n(float u);
tribo_status_t force_control_start(void);
void           force_control_tick(float reference_n);

static float force_n;

float read_force_n(void)
{
    return force_n;
}

void command_force_n(float u)
{
    force_n += 0.05f * (u / 1.3f - force_n); // a first-order plant that loses some of u to friction
}

int main(void)
{
    if (force_control_start() != TRIBO_OK)
    {
        return 1;
    }
    for (int i = 0; i < 5000; i++)
    {
        force_control_tick(0.5f);
    }
    printf("reference 0.5 N, force after 5 s: %.4f N\n", (double)force_n);
    return force_n > 0.49f && force_n < 0.51f ? 0 : 1;
}
