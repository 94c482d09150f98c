"""Calls the C code that tribo-identify uses: the library in double (native.c), and tribo-sim."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
from tribo._wide import ffi, lib

from tribo_design.errors import DesignError, InputError

NAMES = [name for name, _ in ffi.typeof("identify_params_t").fields]
PAPER = dict(k_min=6.0, k_max=20.0, m=3.0, v0=0.007, offset_positive=0.007, slope_positive=0.3, offset_negative=0.007, slope_negative=0.3, set_level=0.75,
             reset_level=0.8, pulse_width=0.003, gravity=0.0, scale=1.0, inertia=1.2e-4, damping=0.0288, stiffness=3.84, actuator=200.0, sensor=55.0, delay=0.0)
SETS_MAX = lib.IDENTIFY_SETS_MAX  # parameter sets in one simulation
OWN_MAX = 16  # own parameters of a truth model


def _doubles(array):
    return ffi.from_buffer("double *", np.ascontiguousarray(array, float))


def _structs(params):
    return ffi.new("identify_params_t[]", [{name: one[name] for name in NAMES} for one in params])


def simulate(params, u, interval_s, start_n, substeps=10, table=()):
    """Returns y of a segment. The library's compensator is the arm, behind the actuator and in front of the sensor."""
    return simulate_sets([params], u, interval_s, start_n, substeps, [table])[0]


def simulate_sets(params, u, interval_s, start_n, substeps, tables):
    """Does what simulate does for several parameter sets; their tables have one length."""
    points = np.array(tables, float).reshape(len(params), -1)
    y = np.empty((len(params), len(u)))
    status = lib.identify_simulate(_structs(params), _doubles(points if points.size else np.zeros(3)), points.shape[1] // 3, len(params), _doubles(u), len(u), interval_s, substeps, start_n,
                                   _doubles(y))
    if status != 0:
        raise DesignError(f"the library refuses these parameters: {ffi.string(lib.identify_status_text(status)).decode()}")
    return np.array([late(row, one["delay"], interval_s) for row, one in zip(y, params)])


def late(y, delay_s, interval_s):
    time = np.arange(len(y)) * interval_s
    return np.interp(time - delay_s, time, y) if delay_s else y


def play(truth, own, params, u, interval_s, substeps):
    """Returns y of tribo-sim's plant with a truth model. `own` has the model's own parameters in their order; missing ones have their default. The plant starts at rest at F = 0."""
    y, given = np.empty(len(u)), [*own.values(), *[np.nan] * (OWN_MAX - len(own))]
    if lib.identify_play(truth.encode(), _structs([params]), _doubles(given), _doubles(u), len(u), interval_s, substeps, _doubles(y)) != 0:
        raise DesignError(f"there is no truth model {truth}, or memory is exhausted")
    return late(y, params["delay"], interval_s)


def slides(u, force, interval_s):
    """Returns +1 or -1, the direction of a slow slide, or 0 for each row."""
    ways = np.zeros(len(u), np.int8)
    if lib.identify_slides(_doubles(u), _doubles(force), len(u), interval_s, ffi.from_buffer("signed char *", ways)) != 0:
        raise DesignError("out of memory")
    return ways


def tribo_sim():
    """Returns the path of tribo-sim: TRIBO_SIM, or the program in this environment, or the one in PATH."""
    beside = Path(sys.executable).with_name("tribo-sim")
    found = os.environ.get("TRIBO_SIM") or (str(beside) if beside.exists() else shutil.which("tribo-sim"))
    if found is None:
        raise DesignError("tribo-sim was not found: pip install puts it next to this program; or set TRIBO_SIM to its path")
    return found


def run_tribo_sim(*arguments, cwd=None):
    """Runs tribo-sim. Returns its standard output and standard error, or raises InputError with its message. Words are passed as UTF-8 in every locale; paths are passed as
    the system encodes them."""
    words = [b"./" * str(a).startswith("-") + os.fsencode(a) if isinstance(a, Path) else str(a).encode("utf-8", "surrogateescape") for a in arguments]
    done = subprocess.run([tribo_sim(), *words], capture_output=True, check=False, cwd=cwd)
    out, said = (text.decode("utf-8", "replace") for text in (done.stdout, done.stderr))
    if done.returncode != 0:
        raise InputError(said.strip().removeprefix("tribo-sim: ").split(" (tribo-sim --help")[0] or f"tribo-sim ended with {done.returncode}")
    return out, said
