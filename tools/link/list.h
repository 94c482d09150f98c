/// The drive's registers with their names, made of the lists of firmware/app/registers.h, params.h and config.h.

#ifndef LINK_LIST_H
#define LINK_LIST_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum
{
    LINK_STATE,
    LINK_SIGNAL,
    LINK_REQUEST,
    LINK_CHANGE, ///< a protection change
    LINK_PARAM   ///< at its address in the staged set
} link_group_t;

typedef struct
{
    char         name[72];
    link_group_t group;
    uint16_t     address;
    bool         is_float, has_range, can_be_0; ///< can_be_0: 0 is allowed as well, and turns the field off
    bool         protects;                      ///< changes only out of run and unlocked ...
    bool         wired;                         ///< ... or not at all
    double       low, high, normal;
    double       least; ///< of the size of a float that is not 0
    const char  *unit, *text;
} link_row_t;

/// All rows, by group and address; `*count` of them.
const link_row_t *link_list(size_t *count);

/// Returns null if there is no such name.
const link_row_t *link_find(const char *name);
const link_row_t *link_at(uint16_t address);

/// The first name that has `part` in it, of any group or, if `params_only`, of a param; null if none has.
const char *link_nearest(const char *part, bool params_only);

/// Further values of the lists, for a program that includes libmodbus, whose names collide with those of the drive's server.
extern const uint16_t link_command_at, link_window_at;
extern const uint16_t link_active_offset;              ///< of the set that the drive runs with, from the staged one
extern const unsigned link_apply, link_stop;           ///< commands
extern const uint32_t link_key;                        ///< of unlock
extern const unsigned link_version;                    ///< of the lists
uint32_t              link_layout(bool feeds_forward); ///< of a drive with or without the feed-forward
bool                  link_is_of_feedforward(const link_row_t *row);
const char           *link_outcome_text(uint32_t outcome);
extern const uint32_t link_store_failed; ///< state `store`: it could not be written

typedef enum
{
    LINK_DONE,
    LINK_BUSY,
    LINK_WRONG_STATE,
    LINK_SET_REFUSED,
    LINK_NOT_SAVED = 5,
    LINK_TRACE_REFUSED,
    LINK_PROTECTED,
    LINK_LOCKED
} link_outcome_t;

#define LINK_WINDOW 62u ///< words

/// Prints all registers as a page in Markdown.
void link_print_markdown(void);

#endif
