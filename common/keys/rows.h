/// Short forms for the rows of a table of keys. Include this only in sources that define a table.

#ifndef COMMON_ROWS_H
#define COMMON_ROWS_H

#include "keys/key.h"
#include "tribo/parameters.h"

// clang-format off: one form a line
#define AT(type_, member) .offset = offsetof(type_, member)
#define RANGE(unit_, min_, max_, standard_) .unit = (unit_), .min = (min_), .max = (max_), .standard = (standard_)

#define NUMBER(name_, at, range, text_)           {.name = (name_), .type = COMMON_KEY_NUMBER, at, range, .text = (text_)}
#define REQUIRED(name_, at, range, text_)         {.name = (name_), .type = COMMON_KEY_NUMBER, .is_required = true, at, range, .text = (text_)}
#define OPTIONAL(name_, at, range, text_)         {.name = (name_), .type = COMMON_KEY_OPTIONAL, at, range, .text = (text_)}
#define WHOLE(name_, at, range, text_)            {.name = (name_), .type = COMMON_KEY_WHOLE, at, range, .text = (text_)}
#define CHOICE(name_, at, words_, standard_, text_) {.name = (name_), .type = COMMON_KEY_CHOICE, at, .unit = "-", .words = (words_), .standard = (standard_), .text = (text_)}
#define TEXT(name_, at, max_, text_)              {.name = (name_), .type = COMMON_KEY_TEXT, at, .unit = "-", .max = (max_), .text = (text_)}
#define GROUP(name_, at, keys_, text_) {.name = (name_), .type = COMMON_KEY_GROUP, at, .keys = (keys_), .text = (text_)}
#define LIST(name_, type_, member, counter, max_, keys_, text_) \
    {.name = (name_), .type = COMMON_KEY_LIST, AT(type_, member), .unit = "-", .min = 1, .max = (max_), .keys = (keys_), \
     .size = sizeof((type_ *)0)->member[0], .count_offset = offsetof(type_, counter), .text = (text_)}
/// A row from a list of tribo/parameters.h. Its member of T is a double, or a common_optional_t if the key may be missing.
#define PARAMETER(group_, symbol_, member_, name_, unit_, low_, high_, standard_, change_, number_, condition_, text_) \
    {.name = (name_), .type = _Generic(((T *)0)->member_, double: COMMON_KEY_NUMBER, common_optional_t: COMMON_KEY_OPTIONAL), AT(T, member_), \
     RANGE(unit_, low_, high_, standard_), .text = (text_)},
#define ELEMENT(symbol_, member_, name_, unit_, low_, high_, text_) REQUIRED(name_, AT(T, member_), RANGE(unit_, low_, high_, 0.0), text_),
/// A key of another program; its value is ignored.
#define SKIPPED(name_) {.name = (name_), .type = COMMON_KEY_SKIPPED, .unit = "-", .text = ""}
#define END {.name = NULL}
// clang-format on

#endif
