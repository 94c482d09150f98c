/// A door of the library inside an FMU: the force axis (axis.c) or the joint without a force sensor (joint.c). door.c is what both share.
///
/// values.h, made by tools/tribo-fmu, has FMU_FIELDS, a row FIELD(symbol, name, low, high, start, is_tunable) for each parameter; FMU_SIGNALS,
/// a row SIGNAL(name) for the time, each input and each output; FMU_INPUTS, how many inputs; FMU_DIRECT, 1 where outputs of a tick follow the
/// inputs before the step; and FMU_TOKEN. In Q31 it defines TRIBO_ARITHMETIC_Q31.

#ifndef FMU_DOOR_H
#define FMU_DOOR_H

#include "tribo/status.h"

#include <stddef.h>

#include "values.h"

// NOLINTBEGIN(bugprone-macro-parentheses): names of enumerators
#define FIELD(symbol, ...) FIELD_##symbol,
#define SIGNAL(name)       SIGNAL_##name,
// NOLINTEND(bugprone-macro-parentheses)
enum
{
    FMU_FIELDS FIELD_COUNT
};
enum
{
    FMU_SIGNALS SIGNAL_COUNT
};
#undef FIELD
#undef SIGNAL

/// Bytes of a door, which may be copied, also to another process.
extern const size_t fmu_door_size;

/// At rest, nothing learned. A refusal leaves it as it was.
tribo_status_t fmu_door_start(void *door, const double fields[FIELD_COUNT]);

/// Other tunable fields while it runs.
tribo_status_t fmu_door_change(void *door, const double fields[FIELD_COUNT]);

/// One tick: inputs are read, and the command is written.
void fmu_door_tick(void *door, double signals[SIGNAL_COUNT]);

/// The other outputs.
void fmu_door_report(void *door, double signals[SIGNAL_COUNT]);

/// Latches open.
void fmu_door_restore(void *door);

#endif
