/// The drive's GPIO lines through libgpiod: lines_v1.c for its first interface, lines_v2.c for its second.
///
/// Each line is requested for this drive alone. Outputs are low when requested. The kernel keeps the edges of inputs, so that a
/// pulse between two ticks is seen. Levels here are after active_low.

#ifndef LINUX_LINES_H
#define LINUX_LINES_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define LINES_NAME_MAX 63u

typedef enum
{
    LINE_ENABLE, ///< outputs up to LINE_PROBE, inputs from there on
    LINE_HEARTBEAT,
    LINE_PROBE,
    LINE_EMERGENCY_STOP,
    LINE_POWER_FAULT,
    LINE_READY,
    LINE_COUNT
} line_t;

extern const char *const line_names[LINE_COUNT]; ///< in the configuration

typedef enum
{
    LINE_BIAS_AS_IS,
    LINE_BIAS_DISABLED,
    LINE_BIAS_PULL_UP,
    LINE_BIAS_PULL_DOWN
} line_bias_t;

/// By `name`, or else by `chip` (its label, name, number or path) and `offset`. Neither: the drive has no such line.
typedef struct
{
    char     name[LINES_NAME_MAX + 1], chip[LINES_NAME_MAX + 1];
    uint64_t offset;
    int      active_low; ///< 0 or 1
    int      bias;       ///< line_bias_t
} line_config_t;

typedef struct lines lines_t;

bool line_is_used(const line_config_t *config);

/// Requests all lines in use for `consumer`. Null with the line and the cause in `error`.
lines_t *lines_open(const line_config_t config[LINE_COUNT], const char *consumer, common_error_t *error);
void     lines_close(lines_t *lines);

/// False if the kernel refuses, e.g. because the chip is gone. An unused output accepts any level.
bool lines_set(lines_t *lines, line_t output, bool high);

/// The level at the pin of an output. False if the chip cannot read its outputs, or is gone.
bool lines_read_back(lines_t *lines, line_t output, bool *high);

/// Whether an input has been high, and low, since the last call: both if it changed. False as lines_set. No allocation.
bool lines_seen(lines_t *lines, line_t input, bool *high, bool *low);

/// For messages: "enable ('NAME')" or "enable (CHIP line 3)".
void line_describe(line_t line, const line_config_t *config, char *text, size_t size);

#endif
