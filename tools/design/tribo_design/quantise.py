"""Sections to what the library stores: float32, and Q31 mantissas with an exponent each.

Q31: value = mantissa * 2^(shift - 31), 2^30 <= |mantissa| < 2^31 (or 0, 0): 31 bits for every coefficient, however small.
This module is the only place that knows the format.
"""

import math

import numpy as np

SHIFT_MIN, SHIFT_MAX = -63, 31


def to_f32(sections):
    """Rounded to float32; the values, exact in double."""
    return np.asarray(sections, float).astype(np.float32).astype(float)


def q31(value):
    """(mantissa, shift) nearest to `value`."""
    if value == 0:
        return 0, 0
    fraction, exponent = math.frexp(value)  # 0.5 <= |fraction| < 1
    mantissa = round(fraction * 2**31)
    if abs(mantissa) == 2**31:
        mantissa, exponent = mantissa // 2, exponent + 1
    if exponent > SHIFT_MAX:
        raise ValueError("too large for Q31")
    if exponent < SHIFT_MIN:
        return 0, 0
    return mantissa, exponent


def q31_value(mantissa, shift):
    return math.ldexp(mantissa, shift - 31)


def to_q31(sections):
    """[[(mantissa, shift) of b0, b1, b2, a1, a2] of each section]."""
    return [[q31(float(c)) for c in row] for row in sections]


def from_q31(coded):
    return np.array([[q31_value(m, s) for m, s in row] for row in coded])
