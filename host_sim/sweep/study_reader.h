/// Reads a study's file (YAML) into its struct and checks its structure and types. Keys of the scenario and values are checked
/// later, against the scenario (study.c).

#ifndef SIM_STUDY_READER_H
#define SIM_STUDY_READER_H

#include "sweep/study.h"

/// Reads `text`; messages call it `study->path`. `*scenario_name` receives the scenario's name.
bool sim_study_read(sim_study_t *study, const char *text, char **scenario_name, common_error_t *error);

/// "FILE:LINE:COLUMN: " and the rest. Always false.
bool sim_study_complain(const sim_study_t *study,
                        size_t             line,
                        size_t             column,
                        common_error_t    *error,
                        const char        *format,
                        ...);

/// "key=value", the value quoted as YAML requires; null if there is no memory.
char *sim_study_assignment(const char *key, const char *value);

#endif
