/// A study's file (YAML) into its struct: what belongs where, and of which kind. Keys of the scenario and values are checked later,
/// against the scenario (study.c).

#ifndef SIM_STUDY_READER_H
#define SIM_STUDY_READER_H

#include "sweep/study.h"

/// Reads `text`, which messages call `study->path`. `*scenario_line` and `*scenario_name` are where and what the scenario is.
bool sim_study_read(sim_study_t *study, const char *text, char **scenario_name, sim_error_t *error);

/// "FILE:LINE:COLUMN: " and the rest. Always false.
bool sim_study_complain(const sim_study_t *study,
                        size_t             line,
                        size_t             column,
                        sim_error_t       *error,
                        const char        *format,
                        ...);

/// "key=value" with the value quoted as YAML wants it; null if there is no memory.
char *sim_study_assignment(const char *key, const char *value);

#endif
