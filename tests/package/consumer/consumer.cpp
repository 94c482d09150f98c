#include "tribo/force_loop_f32.h"

#include <cstdio>

int main()
{
    std::puts(tribo_status_text(TRIBO_OK));
    return tribo_force_loop_f32_init(nullptr, nullptr) == TRIBO_ERR_NULL ? 0 : 1;
}
