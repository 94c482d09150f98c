/// Handles signals to a drive. Every signal that would end or stop a process by default stops the drive in order, from any
/// sender: a terminal's keys and its hang-up, a service manager, a limit of the kernel.

#ifndef LINUX_SIGNALS_H
#define LINUX_SIGNALS_H

#include <signal.h>
#include <stdbool.h>

/// Returns whether a signal requests a stop. Signals that are ignored by default (a child's end, a window's size) do not.
/// Nor do those that this process causes by a write to a pipe without a reader or beyond a file's limit, because the write
/// reports an error.
bool signals_stop(int signal, const siginfo_t *info);

/// Makes signals_latest() return the latest signal that requests a stop; 0 if there is none. Call this with all signals
/// blocked: they arrive from now on, including earlier ones. A fault of the program itself ends it.
void signals_take(void);
int  signals_latest(void);

/// Blocks signals for the threads that are created next, so that only the creating thread gets them. Ends when `before` is
/// set again.
void signals_block(sigset_t *before);

#endif
