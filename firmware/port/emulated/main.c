// The drive in an emulator, one port for every machine.

#include "lock_step.h"

int main(void)
{
    return lock_step();
}
