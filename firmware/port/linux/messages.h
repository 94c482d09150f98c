/// Standard error, for programs that must go on whoever reads it: not wait for a terminal that Ctrl-S has stopped or a pipe that is
/// full, and not end with a pipe whose reader has left. A message without room is dropped and counted; the next one says so.

#ifndef LINUX_MESSAGES_H
#define LINUX_MESSAGES_H

/// From here on `stderr` is that, also in processes that are forked later. Its lines are written whole.
void messages_begin(void);

#endif
