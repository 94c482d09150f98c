/// Formatted text.

#ifndef SIM_TEXT_H
#define SIM_TEXT_H

/// printf into a new string, to be freed; null if there is no memory.
char *sim_text_format(const char *format, ...);

#endif
