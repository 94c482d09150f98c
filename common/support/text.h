/// Formatted text, and how far two words are apart.

#ifndef COMMON_TEXT_H
#define COMMON_TEXT_H

#include <stddef.h>

/// printf into a new string, to be freed; null if there is no memory.
char *common_text_format(const char *format, ...);

/// Levenshtein's distance in bytes: letters changed, added or left out. SIZE_MAX where `b` is longer than 255 bytes.
size_t common_text_distance(const char *a, const char *b);

/// The first distance at which a word is not meant for another: more than a third of its letters, and more than two.
size_t common_text_too_far(const char *word);

#endif
