/// The programs in Python among the tools that tribo-sim came with.

#ifndef SIM_TOOL_H
#define SIM_TOOL_H

/// Runs one with `arguments`, the first being its name and the one after the last null, and waits for its end. Returns 0, or the
/// exit status; then it has said on stderr what is wrong.
int sim_tool_run(const char *const *arguments);

#endif
