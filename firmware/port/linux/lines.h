/// The drive's GPIO lines, through libgpiod: lines_v1.c for its first interface, lines_v2.c for its second.
///
/// Each line is requested exclusively. Outputs are low when requested. The kernel keeps the edges of inputs, so that the
/// tick sees a pulse between two ticks. Levels here already include active_low.

#ifndef LINUX_LINES_H
#define LINUX_LINES_H

#include "support/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define LINES_NAME_MAX 63u

typedef enum
{
    LINE_ENABLE, ///< lines up to LINE_PROBE are outputs, the others inputs
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

/// A line is given by `name`, or by `chip` (its label, name, number or path) and `offset`. If neither is given, the drive has no
/// such line.
typedef struct
{
    char     name[LINES_NAME_MAX + 1], chip[LINES_NAME_MAX + 1];
    uint64_t offset;
    int      active_low; ///< 0 or 1
    int      bias;       ///< a line_bias_t
} line_config_t;

typedef struct lines lines_t;

bool line_is_used(const line_config_t *config);

/// Requests all lines in use for `consumer`. Returns null with the line and the cause in `error`.
lines_t *lines_open(const line_config_t config[LINE_COUNT], const char *consumer, common_error_t *error);
void     lines_close(lines_t *lines);

/// Sets an output. Returns false if the kernel refuses, e.g. because the chip is gone. An unused output accepts any level.
bool lines_set(lines_t *lines, line_t output, bool high);

/// Reads the level at the pin of an output. Returns false if the chip cannot read its outputs, or is gone.
bool lines_read_back(lines_t *lines, line_t output, bool *high);

/// Reads whether an input has been high, and low, since the last call; both if it changed. Returns false if the kernel
/// refuses. Does not allocate.
bool lines_seen(lines_t *lines, line_t input, bool *high, bool *low);

/// Writes a line's name for messages: "enable ('NAME')" or "enable (CHIP line 3)".
void line_describe(line_t line, const line_config_t *config, char *text, size_t size);

#endif
