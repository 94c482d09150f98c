/// Runs a drive in lock-step with the host (wire/tribo_wire.h), over any link (link.h).

#ifndef EMULATED_LOCK_STEP_H
#define EMULATED_LOCK_STEP_H

/// Runs one session with the host, from HELLO to END. Returns 0 after END, otherwise the exit status of a program.
int lock_step(void);

#endif
