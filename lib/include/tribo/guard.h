/// Why a guard has faded the compensation; see guard_f32.h.

#ifndef TRIBO_GUARD_H
#define TRIBO_GUARD_H

#ifdef __cplusplus
extern "C" {
#endif

typedef enum
{
    TRIBO_GUARD_NONE = 0, ///< it has not
    TRIBO_GUARD_HUNTING,  ///< friction turned quickly and drove y where r did not ask it to go
    TRIBO_GUARD_OVERSHOOT ///< F broke away with the wrong error, again and again
} tribo_guard_cause_t;

#ifdef __cplusplus
}
#endif

#endif
