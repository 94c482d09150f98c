// Prints the message SETUP of the paper's loop, for a test that stands for the host: a word a line, in hexadecimal.

#include "tribo_wire.h"

#include <stdio.h>

int main(void)
{
    static tribo_setup_t setup = {.period_us = 1000, .late_us = 100, .budget_us = 500, .full_scale_n = 4.0f};
    static uint32_t      words[TRIBO_SETUP_WORDS];
    setup.loop.config = tribo_force_loop_f32_paper();
    tribo_setup_to_words(&setup, words);
    (void)printf("%08x\n%08x\n", (unsigned)TRIBO_WIRE_SETUP, (unsigned)TRIBO_SETUP_WORDS);
    for (size_t i = 0; i < TRIBO_SETUP_WORDS; i++)
    {
        (void)printf("%08x\n", (unsigned)words[i]);
    }
    return 0;
}
