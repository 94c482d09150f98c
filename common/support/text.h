/// Formats text, and measures the distance between two words.

#ifndef COMMON_TEXT_H
#define COMMON_TEXT_H

#include <stddef.h>

/// Formats into a new string, as printf does. Free it; null if there is no memory.
char *common_text_format(const char *format, ...);

/// Returns a path as a shell takes it, in quotes if it needs them, with ./ ahead of a hyphen, which would begin an option. Free
/// it; null if there is no memory.
char *common_text_quoted(const char *path);

/// Returns Levenshtein's distance in bytes: letters changed, added or omitted. SIZE_MAX if `b` is longer than 255 bytes.
size_t common_text_distance(const char *a, const char *b);

/// Returns the smallest distance at which a word is not a misspelling of another: more than a third of its letters, and more than
/// two.
size_t common_text_too_far(const char *word);

#endif
