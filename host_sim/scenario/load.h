/// YAML text into the structs of a scenario: keys, types and lists are checked, ranges are not (check.h).

#ifndef SIM_LOAD_H
#define SIM_LOAD_H

#include "scenario/config.h"
#include "scenario/schema.h"
#include "scenario/source.h"

typedef struct
{
    const char *text;
    const char *name;      ///< for messages: the file, or "--set key=value"
    bool        is_option; ///< a line number would mean nothing
} sim_load_text_t;

typedef struct
{
    const cyaml_schema_value_t *schema; ///< of the mapping that the text is
    void                       *data;   ///< the struct of that mapping
    const char                 *prefix; ///< what makes a key path of the text one of the scenario, e.g. "compensator."
} sim_load_target_t;

/// Moves the values that `from` gives into `target` and notes where they were written. All or nothing.
bool sim_load_text(const sim_load_text_t   *from,
                   const sim_load_target_t *target,
                   sim_sources_t           *sources,
                   sim_error_t             *error);

/// Frees a scenario's values and everything they point to.
void sim_load_free(sim_config_t *config);

#endif
