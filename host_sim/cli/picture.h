/// Pictures, drawn by the Python program tribo-plot among the tools that tribo-sim came with.

#ifndef SIM_PICTURE_H
#define SIM_PICTURE_H

/// Runs it with `arguments`, the first being its name and the one after the last null, and waits for its end. Returns 0, or the
/// exit status; then it has said on stderr what is wrong.
int sim_picture_draw(const char *const *arguments);

#endif
