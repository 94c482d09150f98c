/// Runs two processes: one runs the loop, the other supervises it. The supervisor turns the outputs off when the loop's
/// process ends, for any reason, or misses its heartbeat. The loop notices when the supervisor ends or is stopped. Both hold
/// the lines and the output, which are opened before. The loop has a session of its own, so that keys of a terminal and
/// signals to a group reach only one of them.

#ifndef LINUX_SUPERVISOR_H
#define LINUX_SUPERVISOR_H

#include "support/error.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct
{
    uint64_t    heartbeat_ms;   ///< longest time without a heartbeat
    uint64_t    priority;       ///< priority of the supervisor, if permitted; higher than that of the loop
    const char *watchdog;       ///< e.g. /dev/watchdog, kept alive as long as the heart beats; null: none
    uint64_t    watchdog_s;     ///< timeout of the watchdog, set and read back
    void (*off)(void *context); ///< turns the power stage off, then commands 0
    void *context;
} supervisor_config_t;

/// The supervisor's name in ps, for killall and pidof; the loop's process keeps the name of the program.
#define SUPERVISOR_NAME "tribo-safe"

#define SUPERVISOR_END_S 8u

/// Shows that the loop's process is alive. Returns false if the supervisor has not looked for heartbeat_ms in which the loop
/// did beat.
typedef struct heart heart_t;
bool                 heart_beat(heart_t *heart);

/// Reports that the loop has turned its outputs off for good and that its process ends soon.
void heart_rest(heart_t *heart);

/// Runs `loop` in a process of its own and returns its exit status once it has ended and the outputs are off; 128 plus the
/// number of the signal that ended it. Signals that request a stop (signals.h) are passed on to it as SIGTERM, which is
/// signals_latest() there. A process that has not ended SUPERVISOR_END_S after that, or after its rest, is killed. Returns
/// -1 with the cause in `error` if the process cannot be started.
int supervisor_run(const supervisor_config_t *config,
                   int (*loop)(void *context, heart_t *heart),
                   void           *context,
                   common_error_t *error);

#endif
