#include "keys/document.h"

#include <stdio.h>
#include <string.h>

#define DEPTH_MAX 16

typedef struct
{
    const char                *text;
    unsigned                   nodes_max;
    common_document_problem_t *problem;
    unsigned                   depth, nodes, documents;
} shape_t;

static bool complain(const shape_t *shape, const char *what)
{
    (void)snprintf(shape->problem->what, sizeof shape->problem->what, "%s", what);
    return false;
}

static bool complain_yaml(const shape_t *shape, const yaml_parser_t *parser)
{
    common_document_problem_t *problem = shape->problem;
    problem->line                      = COMMON_LINE(parser->problem_mark);
    problem->column                    = COMMON_COLUMN(parser->problem_mark);
    if (parser->error == YAML_READER_ERROR) // this error has only an offset
    {
        problem->line = problem->column = 1;
        for (size_t i = 0; i < parser->problem_offset && shape->text[i] != '\0'; i++)
        {
            problem->column = (shape->text[i] == '\n') ? 1u : problem->column + 1u;
            problem->line += (shape->text[i] == '\n') ? 1u : 0u;
        }
    }
    (void)snprintf(problem->what,
                   sizeof problem->what,
                   "not valid YAML: %s",
                   parser->problem != NULL ? parser->problem : "unreadable");
    return false;
}

static bool check_event(shape_t *shape, const yaml_event_t *event)
{
    const yaml_event_type_t type  = event->type;
    const bool              opens = type == YAML_SEQUENCE_START_EVENT || type == YAML_MAPPING_START_EVENT;
    const bool              ends  = type == YAML_SEQUENCE_END_EVENT || type == YAML_MAPPING_END_EVENT;
    shape->problem->line          = COMMON_LINE(event->start_mark);
    shape->problem->column        = COMMON_COLUMN(event->start_mark);
    shape->depth                  = shape->depth + (opens ? 1u : 0u) - (ends ? 1u : 0u);
    shape->nodes += (opens || type == YAML_SCALAR_EVENT) ? 1u : 0u;
    shape->documents += (type == YAML_DOCUMENT_START_EVENT) ? 1u : 0u;
    if (shape->documents == 0 && type == YAML_STREAM_END_EVENT)
    {
        shape->problem->line = shape->problem->column = 1;
        return complain(shape, "the file is empty");
    }
    char too_many[64];
    (void)snprintf(too_many, sizeof too_many, "more than %u keys and values", shape->nodes_max);
    const char *what = (shape->documents > 1)              ? "a second document in one file"
                       : (type == YAML_ALIAS_EVENT)        ? "aliases are not supported"
                       : (shape->depth > DEPTH_MAX)        ? "nested too deeply"
                       : (shape->nodes > shape->nodes_max) ? too_many
                                                           : NULL;
    return what == NULL || complain(shape, what);
}

/// Checks the document's events before it is loaded, because libyaml's time to load grows with the square of the depth, to
/// minutes for a file of brackets.
static bool check_shape(shape_t *shape)
{
    yaml_parser_t parser;
    yaml_event_t  event;
    bool          ok   = yaml_parser_initialize(&parser) == 1;
    bool          more = ok;
    yaml_parser_set_input_string(&parser, (const unsigned char *)shape->text, strlen(shape->text));
    while (ok && more)
    {
        if (!yaml_parser_parse(&parser, &event))
        {
            ok = complain_yaml(shape, &parser);
            break;
        }
        ok   = check_event(shape, &event);
        more = event.type != YAML_STREAM_END_EVENT;
        yaml_event_delete(&event);
    }
    yaml_parser_delete(&parser);
    return ok;
}

bool common_document_load(yaml_document_t           *document,
                          const char                *text,
                          unsigned                   nodes_max,
                          common_document_problem_t *problem)
{
    shape_t       shape = {.text = text, .nodes_max = nodes_max, .problem = problem};
    yaml_parser_t parser;
    *problem = (common_document_problem_t){.line = 1, .column = 1, .what = "out of memory"};
    if (!check_shape(&shape) || yaml_parser_initialize(&parser) != 1)
    {
        return false;
    }
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, strlen(text));
    const bool ok = yaml_parser_load(&parser, document) == 1;
    yaml_parser_delete(&parser);
    return ok;
}
