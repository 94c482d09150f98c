// What the README's snippet leaves to its reader, without a variable of its own: its size is the snippet's.

#include "tribo/status.h"

#define REGISTER(address) (*(volatile float *)(address))

float          read_force_n(void);
void           command_force_n(float u);
tribo_status_t force_control_start(void);
void           force_control_tick(float reference_n);
int            main(void);

float read_force_n(void)
{
    return REGISTER(0x40000000u);
}

void command_force_n(float u)
{
    REGISTER(0x40000004u) = u;
}

int main(void)
{
    if (force_control_start() != TRIBO_OK)
    {
        return 1;
    }
    for (;;)
    {
        force_control_tick(REGISTER(0x40000008u));
    }
}
