/// Writes the params of a loop as C, for programs without set-up code.

#ifndef SIM_PARAMS_HEADER_H
#define SIM_PARAMS_HEADER_H

#include "scenario/loop.h"

#include <stdio.h>

typedef struct
{
    const char        *name;        ///< prefix of all declarations, a C identifier
    const char        *scenario;    ///< source file, for the comment
    const char        *description; ///< the scenario's description, for the comment; "": it has none
    const char *const *sets;        ///< the --set options, for the comment
    int                set_count;

    const tribo_force_loop_f32_config_t *config;
    const sim_loop_t                    *loop; ///< initialised with the same config
    bool                                 is_sensorless;
} sim_params_header_t;

/// Writes a header that declares NAME_params, its table if there is one, NAME_SAMPLE_TIME_S and in Q31 NAME_FULL_SCALE_N,
/// bit for bit as made by the library's init function. Check ferror(stream) afterwards.
void sim_params_header_f32_write(FILE *stream, const sim_params_header_t *header);
void sim_params_header_q31_write(FILE *stream, const sim_params_header_t *header);

#endif
