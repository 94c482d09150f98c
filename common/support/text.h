/// Formatted text.

#ifndef COMMON_TEXT_H
#define COMMON_TEXT_H

/// printf into a new string, to be freed; null if there is no memory.
char *common_text_format(const char *format, ...);

#endif
