/// The Python programs that are installed with tribo-sim.

#ifndef SIM_TOOL_H
#define SIM_TOOL_H

/// Runs one with `arguments`, of which the first is its name and the last is null, and waits for its end. Returns 0, or the exit
/// status after it has reported the error on stderr.
int sim_tool_run(const char *const *arguments);

#endif
