// What others take for the same: CMSIS-DSP's cascades on the controller's two sections, one sample a call, and the C
// library's tanhf. Beside each its error, RMS against a cascade in double, as a fraction of full scale.

#include "../support/cascade_f32.h"
#include "../support/cascade_q31.h"
#include "counter.h"
#include "friction/arm_q31.h"
#include "tribo/force_loop_q31.h"
#include "tribo/paper_controller.h"

#include "dsp/filtering_functions.h"

#include <math.h>
#include <stdio.h>

#define TICKS        20000
#define FULL_SCALE_N 2.0f

static const tribo_biquad_f32_section_t sections[] = TRIBO_PAPER_CONTROLLER_F32;

typedef struct
{
    const char *name;
    counts_t    calls;
    double      square_error;
} peer_t;

static double reference(double x)
{
    static double w1[2], w2[2];
    for (int i = 0; i < 2; i++)
    {
        const tribo_biquad_f32_section_t *s = &sections[i];
        const double                      y = (double)s->b0 * x + w1[i];
        w1[i] += (double)s->b1 * x - (double)s->a1 * y + w2[i];
        w2[i] += (double)s->b2 * x - (double)s->a2 * y;
        x = y;
    }
    return x;
}

static void add_error(peer_t *peer, double y, double expected)
{
    const double error = y - expected;
    peer->square_error += error * error;
}

static int32_t to_q31(double x)
{
    return (int32_t)lrint(x * 2147483647.0);
}

COUNTED(float,
        counted_ours_f32,
        (const tribo_biquad_f32_params_t *params, tribo_biquad_f32_state_t *state, float x),
        cascade_f32_step(params, state, x))
COUNTED(int32_t,
        counted_ours_q31,
        (const tribo_biquad_q31_params_t *params, tribo_biquad_q31_state_t *state, int32_t x),
        cascade_q31_step(params, state, x))
COUNTED(int,
        counted_df2T_f32,
        (const arm_biquad_cascade_df2T_instance_f32 *filter, const float *in, float *out, uint32_t n),
        (arm_biquad_cascade_df2T_f32(filter, in, out, n), 0))
COUNTED(int,
        counted_df1_q31,
        (const arm_biquad_casd_df1_inst_q31 *filter, const q31_t *in, q31_t *out, uint32_t n),
        (arm_biquad_cascade_df1_q31(filter, in, out, n), 0))
COUNTED(int,
        counted_wide_q31,
        (const arm_biquad_cas_df1_32x64_ins_q31 *filter, const q31_t *in, q31_t *out, uint32_t n),
        (arm_biquad_cas_df1_32x64_q31(filter, in, out, n), 0))
COUNTED(float, counted_tanhf, (float x), tanhf(x))

static void print(const peer_t *peer)
{
    printf("peer.%s.instructions %lu\n", peer->name, (unsigned long)peer->calls.max);
    printf("peer.%s.error %.1e\n", peer->name, sqrt(peer->square_error / TICKS));
}

int main(void)
{
    static peer_t ours_f32 = {.name = "biquad_f32"}, ours_q31 = {.name = "biquad_q31"};
    static peer_t df2T_f32 = {.name = "arm_biquad_cascade_df2T_f32"}, df1_q31 = {.name = "arm_biquad_cascade_df1_q31"};
    static peer_t wide_q31 = {.name = "arm_biquad_cas_df1_32x64_q31"};

    // z from delta; CMSIS-DSP adds a y, and holds a coefficient over 4 in Q31.
    static float   z_f32[10];
    static int32_t z_q31[10];
    for (int i = 0; i < 2; i++)
    {
        const tribo_biquad_f32_section_t *s    = &sections[i];
        const double                      z[5] = {s->b0,
                                                  (double)s->b1 - 2.0 * (double)s->b0,
                                                  (double)s->b2 - (double)s->b1 + (double)s->b0,
                                                  2.0 - (double)s->a1,
                                                  (double)s->a1 - (double)s->a2 - 1.0};
        for (int j = 0; j < 5; j++)
        {
            z_f32[5 * i + j] = (float)z[j];
            z_q31[5 * i + j] = to_q31(z[j] / 4.0);
        }
    }
    static float                                df2T_state[4];
    static q31_t                                df1_state[8];
    static q63_t                                wide_state[8];
    static arm_biquad_cascade_df2T_instance_f32 df2T;
    static arm_biquad_casd_df1_inst_q31         df1;
    static arm_biquad_cas_df1_32x64_ins_q31     wide;
    arm_biquad_cascade_df2T_init_f32(&df2T, 2, z_f32, df2T_state);
    arm_biquad_cascade_df1_init_q31(&df1, 2, z_q31, df1_state, 2);
    arm_biquad_cas_df1_32x64_init_q31(&wide, 2, z_q31, wide_state, 2);

    static tribo_force_loop_f32_params_t f32;
    static tribo_force_loop_q31_params_t q31;
    static tribo_biquad_f32_state_t      f32_state;
    static tribo_biquad_q31_state_t      q31_state;
    const tribo_force_loop_f32_config_t  config     = tribo_force_loop_f32_paper();
    const tribo_force_loop_q31_config_t  config_q31 = {.loop = config, .full_scale_n = FULL_SCALE_N};
    if (tribo_force_loop_f32_init(&f32, &config) != TRIBO_OK ||
        tribo_force_loop_q31_init(&q31, &config_q31) != TRIBO_OK)
    {
        return 1;
    }
    tribo_biquad_f32_reset(&f32_state);
    tribo_biquad_q31_reset(&q31_state);

    counter_init();
    counts_t tanhf_calls = {0};
    uint32_t random      = 1;
    for (int k = 0; k < TICKS; k++)
    {
        random            = random * 1664525u + 1013904223u;
        const int32_t x_q = (int32_t)random / 64; // 1/64 of full scale
        const float   x_f = (float)x_q / 2147483648.0f;
        const double  y   = reference((double)x_f);
        int32_t       in  = to_q31((double)x_f);
        float         out_f;
        int32_t       out_q;

        out_f = counted_ours_f32(&f32.controller.cascade, &f32_state, x_f);
        counts_add(&ours_f32.calls);
        add_error(&ours_f32, (double)out_f, y);
        counted_df2T_f32(&df2T, &x_f, &out_f, 1);
        counts_add(&df2T_f32.calls);
        add_error(&df2T_f32, (double)out_f, y);
        out_q = counted_ours_q31(&q31.controller.cascade, &q31_state, in);
        counts_add(&ours_q31.calls);
        add_error(&ours_q31, out_q / 2147483648.0, y);
        counted_df1_q31(&df1, &in, &out_q, 1);
        counts_add(&df1_q31.calls);
        add_error(&df1_q31, out_q / 2147483648.0, y);
        counted_wide_q31(&wide, &in, &out_q, 1);
        counts_add(&wide_q31.calls);
        add_error(&wide_q31, out_q / 2147483648.0, y);
        (void)counted_tanhf(200.0f * x_f);
        counts_add(&tanhf_calls);
    }
    print(&ours_f32);
    print(&df2T_f32);
    print(&ours_q31);
    print(&df1_q31);
    print(&wide_q31);
    printf("peer.tanhf.instructions.min %lu\n", (unsigned long)tanhf_calls.min);
    printf("peer.tanhf.instructions.mean %lu\n", (unsigned long)(tanhf_calls.sum / tanhf_calls.calls));
    printf("peer.tanhf.instructions.max %lu\n", (unsigned long)tanhf_calls.max);
    return 0;
}
