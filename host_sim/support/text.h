/// Text that is made of parts.

#ifndef SIM_TEXT_H
#define SIM_TEXT_H

/// As printf writes it, to be freed; null if there is no memory.
char *sim_text_format(const char *format, ...);

#endif
