/// Standard error for programs that must go on whether or not it is read. They do not wait for a terminal that Ctrl-S has
/// stopped or for a full pipe, and do not end with a pipe whose reader has left. A message without room is dropped and
/// counted; the next message says so.

#ifndef LINUX_MESSAGES_H
#define LINUX_MESSAGES_H

/// Makes `stderr` such a stream from now on, also in processes that are forked later. Its lines are written whole.
void messages_begin(void);

#endif
