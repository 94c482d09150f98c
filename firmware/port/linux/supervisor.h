/// Two processes: the one that runs the loop, and its supervisor, which turns the outputs off when the other ends, however it
/// ends, or shows no heartbeat for longer than allowed. Both hold the lines and the output, opened before.

#ifndef LINUX_SUPERVISOR_H
#define LINUX_SUPERVISOR_H

#include "support/error.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct
{
    uint64_t    heartbeat_ms;   ///< longest time without one
    uint64_t    priority;       ///< of the supervisor, if it may have one: more than the loop's
    const char *watchdog;       ///< e.g. /dev/watchdog, kept alive as long as the heart beats; null: none
    uint64_t    watchdog_s;     ///< its timeout, set and read back
    void (*off)(void *context); ///< the power stage off, then command 0
    void *context;
} supervisor_config_t;

/// In ps, for killall and pidof; the loop's process keeps the program's.
#define SUPERVISOR_NAME "tribo-safe"

/// What the loop's process is given to show that it lives.
typedef struct heart heart_t;
void                 heart_beat(heart_t *heart);

/// From here on no beats are expected, until the next one: the loop has turned its outputs off.
void heart_rest(heart_t *heart);

/// Runs `loop` in a process of its own and returns its exit status once it has ended and the outputs are off; 128 and more:
/// the signal that ended it. SIGINT and SIGTERM are passed on to it. -1 with why in `error` if there is no such process.
int supervisor_run(const supervisor_config_t *config,
                   int (*loop)(void *context, heart_t *heart),
                   void           *context,
                   common_error_t *error);

#endif
