// What a tick of a joint costs on this target: prints instructions, least, mean and most, and bytes of RAM. Exit status 1 where the most is
// over MOST on a core that has the arithmetic in hardware: somewhat more than the 1,381 of an M0 in Q31, a few more than an M4F's 402 in float32.

#include "counter.h"
#include "tribo/joint_f32.h"
#include "tribo/joint_q31.h"

#include <stdio.h>

#ifdef TRIBO_ARITHMETIC_Q31
#define JOINT(name) tribo_joint_q31_##name
#define ARITHMETIC  "q31"
#define MOST        1500u
typedef int32_t number_t;
#else
#define JOINT(name) tribo_joint_f32_##name
#define ARITHMETIC  "f32"
#define MOST        410u
typedef float number_t;
#endif

#if defined(__ARM_FP) || defined(TRIBO_ARITHMETIC_Q31)
#define IS_IN_HARDWARE 1
#else
#define IS_IN_HARDWARE 0
#endif

#define TICKS 20000

static JOINT(t) joint;

/// Converts thousandths of full scale.
static number_t effort_of(int32_t thousandths)
{
#ifdef TRIBO_ARITHMETIC_Q31
    return thousandths * (INT32_MAX / 1000);
#else
    return (float)thousandths * 1e-3f;
#endif
}

static COUNTED_ALONE number_t counted_step(number_t effort, number_t q_ref, number_t q)
{
    const uint32_t from = counter_read();
    const number_t u    = JOINT(step)(&joint, effort, q_ref, q);
    counter_passed      = counter_between(from, counter_read());
    return u;
}

int main(void)
{
    tribo_joint_config_t config = tribo_joint_config();
    config.sample_time_s        = 1e-3f;
    config.effort_max           = 1.0f;
    config.travel               = 4.0f;
    config.breakaway            = 0.1f;
    if (JOINT(init)(&joint, &config) != TRIBO_OK)
    {
        return 1;
    }
    uint32_t least = UINT32_MAX;
    uint32_t most  = 0;
    uint32_t sum   = 0;
    int32_t  q     = 0;
    counter_init();
    for (int32_t k = 0; k < TICKS; k++) // strokes of 500 counts with rests, and a push at each rest
    {
        const int32_t phase = k % 1000;
        const int32_t way   = k / 1000 % 2 == 0 ? 1 : -1;
        q += phase < 500 ? way : 0;
        const int32_t pushed = phase > 800 && phase < 900 ? 20 : 0;
        (void)counted_step(effort_of(way * 100), (number_t)(q + way), (number_t)(q + pushed));
        const uint32_t passed = counter_instructions(counter_passed);
        least                 = passed < least ? passed : least;
        most                  = passed > most ? passed : most;
        sum += passed;
    }
    printf("%s.joint.tick.min %lu\n", ARITHMETIC, (unsigned long)least);
    printf("%s.joint.tick.mean %lu\n", ARITHMETIC, (unsigned long)(sum / TICKS));
    printf("%s.joint.tick.max %lu\n", ARITHMETIC, (unsigned long)most);
    printf("%s.joint.ram %lu\n", ARITHMETIC, (unsigned long)(uint32_t)sizeof joint);
    return IS_IN_HARDWARE != 0 && most > MOST ? 1 : 0;
}
