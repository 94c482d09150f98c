/// A part of a loop, in either arithmetic: a loop of which only that part is stepped.

#ifndef NATIVE_PART_H
#define NATIVE_PART_H

#include "native.h"

#include "scenario/loop.h"

enum
{
    NATIVE_INPUTS_MAX  = 4,
    NATIVE_OUTPUTS_MAX = 16
};

typedef enum
{
    NATIVE_LOOP,
    NATIVE_FRICTION,
    NATIVE_COMPENSATOR,
    NATIVE_GUARD,
    NATIVE_FEEDFORWARD,
    NATIVE_KINDS
} native_kind_t;

typedef struct
{
    const char *name;
    const char *inputs[NATIVE_INPUTS_MAX + 1];   ///< ended by null
    const char *outputs[NATIVE_OUTPUTS_MAX + 1]; ///< likewise; the first is what a tick returns
} native_shape_t;

struct native_part
{
    native_kind_t         kind;
    const native_shape_t *shape;
    unsigned              inputs;
    bool                  q31;
    common_loop_config_t  config; ///< the loop's params point into it
    sim_loop_t            loop;
    double                outputs[NATIVE_OUTPUTS_MAX]; ///< of the last tick
    double                r_n, y_n, e_n;               ///< of a feed-forward between the halves of its tick
};

/// One tick of each kind: fills the first output, and with `all` the others.
typedef void (*native_tick_t)(native_part_t *part, const double *in, double *out, bool all);

typedef struct
{
    native_tick_t tick[NATIVE_KINDS];
    double (*error)(native_part_t *part, double r_n, double y_n);
    void (*command)(native_part_t *part, double v_n, double *out);
    void (*restore)(native_part_t *part);
} native_functions_t;

extern const native_functions_t native_f32_functions;
extern const native_functions_t native_q31_functions;

#endif
