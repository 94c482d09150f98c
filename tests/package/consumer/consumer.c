#include "tribo/force_loop_f32.h"

#include <stdio.h>

int main(void)
{
    puts(tribo_status_text(TRIBO_OK));
    return tribo_force_loop_f32_init(0, 0) == TRIBO_ERR_NULL ? 0 : 1;
}
