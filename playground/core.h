/// What the page and its tests call: a scenario's text in, a run's columns out, by the simulator's own source; or the settings of joint.h.
///
/// One run at a time: what a function returns stays until the next run.

#ifndef PLAYGROUND_CORE_H
#define PLAYGROUND_CORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// JavaScript knows a function by the name in brackets.
#ifdef __wasm__
#define EXPORT(name) __attribute__((export_name(#name)))
#else
#define EXPORT(name)
#endif

/// Room for text or settings that the caller writes and a run frees.
EXPORT(room) char *playground_room(size_t size);

/// Plays the scenario of `text`. False: `complaint` says why.
EXPORT(play) bool playground_play(char *text, bool q31);

/// Plays the joint of JOINT_SETTINGS numbers. False: `complaint` says why.
EXPORT(play_joint) bool playground_play_joint(double *settings);

EXPORT(complaint) const char *playground_complaint(void);
EXPORT(row_count) size_t playground_row_count(void);
EXPORT(column_count) unsigned playground_column_count(void);
EXPORT(column_name) const char *playground_column_name(unsigned column);
EXPORT(column) const double *playground_column(unsigned column);
/// In N, of a joint in rad.
EXPORT(rms_error) double playground_rms_error(void);
EXPORT(max_error) double playground_max_error(void);
/// Why the guard has faded the compensation; "" if there is none. Of a joint "sound", or a sentence.
EXPORT(guard) const char *playground_guard(void);

/// The scenario as played, as `tribo-sim run --out` writes it: a file that plays it again.
EXPORT(scenario_text) const char *playground_scenario_text(void);

/// FNV-1a over all numbers of all columns, eight bytes at a time: the same for the same bits.
EXPORT(digest) uint64_t playground_digest(void);

#endif
