// Prints what tribo_controller_q31_init makes of sections, for quantise.py: the library itself does the rounding.
//   in   full scale, u_min, u_max, section count, then b0 b1 b2 a1 a2 of each section
//   out  "error TEXT", or one "key value ..." a line

#include "tribo/force_loop_q31.h"

#include <stdio.h>

int main(void)
{
    float                         full_scale_n, u_min_n, u_max_n;
    unsigned                      count;
    tribo_biquad_f32_section_t    sections[TRIBO_BIQUAD_SECTIONS_MAX];
    tribo_controller_f32_params_t f32;
    tribo_controller_q31_params_t q31;
    tribo_headroom_q31_t          headroom;

    if (scanf("%f %f %f %u", &full_scale_n, &u_min_n, &u_max_n, &count) != 4 || count > TRIBO_BIQUAD_SECTIONS_MAX)
    {
        return 2;
    }
    for (unsigned i = 0; i < count; i++)
    {
        tribo_biquad_f32_section_t *s = &sections[i];
        if (scanf("%f %f %f %f %f", &s->b0, &s->b1, &s->b2, &s->a1, &s->a2) != 5)
        {
            return 2;
        }
    }
    const tribo_controller_f32_config_t config = {.sections      = sections,
                                                  .section_count = count,
                                                  .u_min_n       = u_min_n,
                                                  .u_max_n       = u_max_n};
    tribo_status_t                      status = tribo_controller_f32_init(&f32, &config);
    if (status == TRIBO_OK)
    {
        double through = 1.0;
        for (unsigned i = 0; i < count; i++)
        {
            through *= (double)sections[i].b0;
        }
        printf("conditioning %.9g\n", (double)f32.anti_windup * through);
        status = tribo_controller_q31_init(&q31, &config, full_scale_n, &headroom);
    }
    if (status != TRIBO_OK)
    {
        printf("error %s\n", tribo_status_text(status));
        return 0;
    }
    for (unsigned i = 0; i < q31.cascade.count; i++) // two at least
    {
        const tribo_biquad_q31_section_t *s = &q31.cascade.section[i];
        printf("section %ld %ld %ld %ld %ld %ld %u %u\n",
               (long)s->b0,
               (long)s->c1,
               (long)s->minus_a1,
               (long)s->c2,
               (long)s->d2,
               (long)s->d2_low,
               (unsigned)s->shift,
               (unsigned)s->scale);
        printf("peak %.9g\n", (double)headroom.output[i]);
    }
    printf("scales %u %u\n", (unsigned)q31.cascade.input_scale, (unsigned)q31.cascade.output_scale);
    printf("anti_windup %ld %u %ld\n", (long)q31.anti_windup, (unsigned)q31.anti_windup_shift, (long)q31.taken_max);
    printf("limits %ld %ld\n", (long)q31.u_min, (long)q31.u_max);
    return 0;
}
