/// Reads numbers as users write them, strictly: decimal digits, one point, an exponent, and nothing else. Hexadecimal,
/// "nan", "inf", thousands separators and trailing text are refused, in every locale.

#ifndef COMMON_NUMBER_H
#define COMMON_NUMBER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Reads a finite number into `*value`. Returns null, or the fault in a few words. A number below the normal numbers of single
/// precision is refused, because it comes from swapped words or from a slip in the exponent.
const char *common_number_parse(const char *text, double *value);

/// Reads a sample of a log. A decaying signal reaches such tiny numbers, which become 0 here.
const char *common_number_parse_sample(const char *text, double *value);

/// Reads a whole number from 0 to 2^64 - 1.
const char *common_number_parse_whole(const char *text, uint64_t *value);

/// Returns whether `text` is a number that is not 0, but smaller than `least`.
bool common_number_is_below(const char *text, double least);

#endif
