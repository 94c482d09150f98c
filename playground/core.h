/// The functions that the page and its tests call. They run a scenario's text, or the settings of joint.h, with the
/// simulator's own source, and return the columns of the run.
///
/// There is one run at a time. Returned data stays valid until the next run.

#ifndef PLAYGROUND_CORE_H
#define PLAYGROUND_CORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// JavaScript calls a function by the name in brackets.
#ifdef __wasm__
#define EXPORT(name) __attribute__((export_name(#name)))
#else
#define EXPORT(name)
#endif

/// Allocates room for text or settings, which the caller writes and a run frees.
EXPORT(room) char *playground_room(size_t size);

/// Runs the scenario in `text`. Returns false if it fails; then `complaint` says why.
EXPORT(play) bool playground_play(char *text, bool q31);

/// Runs the joint with JOINT_SETTINGS numbers. Returns false if it fails; then `complaint` says why.
EXPORT(play_joint) bool playground_play_joint(double *settings);

EXPORT(complaint) const char *playground_complaint(void);
EXPORT(row_count) size_t playground_row_count(void);
EXPORT(column_count) unsigned playground_column_count(void);
EXPORT(column_name) const char *playground_column_name(unsigned column);
EXPORT(column) const double *playground_column(unsigned column);
/// Returns the error in N, or in rad for a joint.
EXPORT(rms_error) double playground_rms_error(void);
EXPORT(max_error) double playground_max_error(void);
/// Returns why the guard has faded the compensation, "" if there is no guard. For a joint, returns "sound" or a sentence.
EXPORT(guard) const char *playground_guard(void);

/// Returns the scenario as it ran, in the form that `tribo-sim run --out` writes. Running it again gives the same run.
EXPORT(scenario_text) const char *playground_scenario_text(void);

/// Returns FNV-1a over all numbers of all columns, eight bytes at a time; it is equal for equal bits.
EXPORT(digest) uint64_t playground_digest(void);

#endif
