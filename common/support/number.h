/// Numbers as users write them, read strictly: decimal digits, one point, an exponent, and nothing else.
/// No hexadecimal, no "nan", no "inf", no thousands separators, no trailing text, whatever the locale.

#ifndef COMMON_NUMBER_H
#define COMMON_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Null if `text` is a finite number, then in `*value`; else the fault in a few words. What single precision has no normal number for
/// is none: it comes of swapped words or a slip in the exponent, and nobody means it.
const char *common_number_parse(const char *text, double *value);

/// The same for a sample of a log, where a signal that decays reaches such numbers: they are 0.
const char *common_number_parse_sample(const char *text, double *value);

/// The same for a whole number from 0 to 2^64 - 1.
const char *common_number_parse_whole(const char *text, uint64_t *value);

/// Whether `text` is a number that is not 0, but smaller than `least`.
bool common_number_is_below(const char *text, double least);

#endif
