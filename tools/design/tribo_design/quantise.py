"""Sections to what the library stores: float32, and the Q31 params of tribo/controller_q31.h.

The Q31 numbers are the library's own: tribo_controller_q31_init makes them, with the scales of its nodes, the anti-windup and
the limits. Only reading them as real numbers is done here. This module is the only
one that knows the format.
"""

from dataclasses import asdict, dataclass

import numpy as np
from tribo._core import new_error, text
from tribo._native import ffi, lib

from .errors import DesignError

FIELDS = ("b0", "c1", "minus_a1", "c2", "d2", "d2_low", "shift", "scale")


@dataclass(frozen=True)
class Q31:
    """tribo_controller_q31_params_t."""

    sections: list  # of dicts with FIELDS
    input_scale: int
    output_scale: int
    anti_windup: int
    anti_windup_shift: int
    taken_max: int
    u_min: int
    u_max: int

    def as_dict(self):
        return asdict(self)

    def values(self):
        """Rows b0, b1, b2, a1, a2 as real numbers, the nodes' scales taken out again."""
        rows, before = [], self.input_scale
        for s in self.sections:
            by = s["scale"] - before  # the output's node against the input's
            rows.append([np.ldexp(float(s["b0"]), by - 28), np.ldexp(float(s["b0"] + s["c1"]), by - 28), np.ldexp(float(s["c2"]), by - 28 - s["shift"]),
                         np.ldexp(float(-s["minus_a1"]), -28), np.ldexp(float(-(s["d2"] * 2**32 + s["d2_low"])), -60 - s["shift"])])
            before = s["scale"]
        return np.array(rows)


@dataclass(frozen=True)
class Quantised:
    q31: Q31
    conditioning: float  # c of the anti-windup
    peaks: list  # of each section's output, in full scales


def to_f32(sections):
    """Rounded to float32; the values, exact in double."""
    return np.asarray(sections, float).astype(np.float32).astype(float)


def to_q31(f32, full_scale_n, u_min_n, u_max_n):
    """Returns the library's params for float32 sections; raises DesignError with the library's reason if it refuses them."""
    given = np.ascontiguousarray(f32, np.float32)
    numbers, peaks, conditioning, error = ffi.new("long long[39]"), ffi.new("float[4]"), ffi.new("double *"), new_error()
    made = lib.native_quantise(ffi.from_buffer("float *", given), len(given), full_scale_n, u_min_n, u_max_n, numbers, peaks, conditioning, error)
    if made == 0:
        raise DesignError(f"sections: the library refuses this controller: {text(error.text)}")
    each = len(FIELDS)
    sections = [dict(zip(FIELDS, numbers[i * each : (i + 1) * each])) for i in range(made)]
    return Quantised(Q31(sections, *numbers[made * each : made * each + 7]), conditioning[0], list(peaks[0:made]))
