/// Signals to a drive. Whatever would end or stop a process by default stops the drive in order, whoever sends it: a terminal's keys
/// and its hang-up, a service manager, a limit of the kernel.

#ifndef LINUX_SIGNALS_H
#define LINUX_SIGNALS_H

#include <signal.h>
#include <stdbool.h>

/// Whether it asks for a stop. Not what is ignored by default (a child's end, a window's size), nor what this process has caused
/// itself by a write to a pipe that nobody reads, or beyond a file's limit: the write says so.
bool signals_stop(int signal, const siginfo_t *info);

/// From now on the latest that asks for a stop is signals_latest(), 0: none. For a process with all signals blocked: they come
/// from now on, also those of before. A fault of the program itself ends it.
void signals_take(void);
int  signals_latest(void);

/// For threads that are made next, until `before` is set again: signals are for the one that makes them.
void signals_block(sigset_t *before);

#endif
