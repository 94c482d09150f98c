/// The keys of a scenario: their types (for libcyaml) and their ranges.

#ifndef SIM_SCHEMA_H
#define SIM_SCHEMA_H

#include <cyaml/cyaml.h>

#include <stdbool.h>
#include <stddef.h>

/// Longest key path, e.g. "compensator.friction.breakaway.table[31].negative_N".
#define SIM_KEY_MAX 128u

extern const cyaml_schema_value_t sim_scenario_schema;    ///< sim_config_t
extern const cyaml_schema_value_t sim_compensator_schema; ///< sim_compensator_config_t

/// Allowed values of a number: min to max, both included.
typedef struct
{
    const char *key; ///< the end of the key path, without list indices
    double      min, max;
} sim_range_t;

/// The range for a key path; null if the key is no number.
const sim_range_t *sim_range_find(const char *path);

/// Where a key path leads.
typedef struct
{
    const cyaml_schema_field_t *field;  ///< the last key of the path
    const cyaml_schema_value_t *parent; ///< the mapping it is in
    size_t                      offset; ///< of that mapping's struct: bytes from the root's, or from `list`'s element
    const cyaml_schema_field_t *list;   ///< the list the path goes through, or null
    size_t                      list_offset; ///< of the struct that list is in
    size_t                      index;       ///< its element
    bool                        is_element;  ///< the path ends at that element itself; `field` is the list
} sim_place_t;

/// False if the schema has no such key.
bool sim_schema_find(const cyaml_schema_value_t *root, const char *path, sim_place_t *place);

/// Calls `visit` with every key path that holds a value, mappings and lists' elements included ("[]" for any index).
typedef void (*sim_key_visitor_t)(void *context, const char *path, const cyaml_schema_field_t *field);
void sim_schema_visit(const cyaml_schema_value_t *root, sim_key_visitor_t visit, void *context);

/// What a value of this type is called in a message, e.g. "a number". For choices, see sim_schema_choices.
const char *sim_schema_type_name(const cyaml_schema_value_t *value);

/// The words of a choice, "triangle, sine or step", in `text`.
void sim_schema_choices(const cyaml_schema_value_t *value, char *text, size_t size);

#endif
