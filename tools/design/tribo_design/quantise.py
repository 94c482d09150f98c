"""Sections to what the library stores: float32, and the Q31 params of tribo/controller_q31.h.

The Q31 numbers are the library's own: tribo_controller_q31_init, compiled on the host from lib/, makes them, with the
scales of its nodes, the anti-windup and the limits. Only reading them as real numbers is done here. This module is the only
one that knows the format.
"""

import atexit
import functools
import os
import shutil
import subprocess
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

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
    """What the library makes of float32 sections; DesignError with the library's words when it refuses."""
    numbers = [full_scale_n, u_min_n, u_max_n, len(f32), *np.asarray(f32).ravel()]
    text = " ".join(f"{x:.9g}" for x in numbers)
    done = subprocess.run([_program()], input=text, capture_output=True, text=True, timeout=60, check=False)
    if done.returncode != 0:
        raise DesignError("q31: the library's quantiser broke down")
    sections, peaks, found = [], [], {}
    for line in done.stdout.splitlines():
        key, _, rest = line.partition(" ")
        if key == "error":
            raise DesignError(f"sections: the library refuses this controller: {rest}")
        values = [float(v) if key in ("peak", "conditioning") else int(v) for v in rest.split()]
        if key == "section":
            sections.append(dict(zip(FIELDS, values)))
        elif key == "peak":
            peaks.append(values[0])
        else:
            found[key] = values
    q31 = Q31(sections, *found["scales"], *found["anti_windup"], *found["limits"])
    return Quantised(q31, found["conditioning"][0], peaks)


def _program():
    """The library's quantiser as a program."""
    return compiled("quantise_q31")


@functools.lru_cache
def compiled(name):
    """NAME.c beside this file with the library, compiled once a process."""
    lib = Path(os.environ.get("TRIBO_LIB") or Path(__file__).resolve().parents[3] / "lib")
    if not (lib / "include" / "tribo" / "force_loop_q31.h").is_file():
        raise DesignError(f"q31: {lib} is not the library's lib/; set TRIBO_LIB to it")
    names = [os.environ["CC"]] if os.environ.get("CC") else ["cc", "gcc", "clang"]
    compiler = next((c for c in names if shutil.which(c)), None)
    if compiler is None:
        raise DesignError("q31: needs a C compiler (cc, gcc or clang in PATH, or CC), as the Q31 numbers are the library's own")
    folder = tempfile.mkdtemp(prefix="tribo-design-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    program = Path(folder) / name
    done = subprocess.run([compiler, "-std=c11", "-O0", "-ffp-contract=off", "-I", lib / "include", Path(__file__).with_name(f"{name}.c"),
                           *sorted((lib / "src").rglob("*.c")), "-o", program], capture_output=True, text=True, timeout=120, check=False)
    if done.returncode != 0:
        first = next((line for line in done.stderr.splitlines() if "error" in line), "no message")
        raise DesignError(f"q31: the library does not compile with {compiler}: {first}")
    return program
