"""The C code that tribo-identify uses: the library, compiled once into a shared one, and tribo-sim."""

import ctypes
import functools
import hashlib
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from tribo_design.errors import DesignError, InputError

ROOT = Path(__file__).resolve().parents[3]
NAMES = ("k_min", "k_max", "m", "v0", "offset_positive", "slope_positive", "offset_negative", "slope_negative", "set_level", "reset_level", "pulse_width",
         "gravity", "scale", "inertia", "damping", "stiffness", "actuator", "sensor")
PAPER = dict(k_min=6.0, k_max=20.0, m=3.0, v0=0.007, offset_positive=0.007, slope_positive=0.3, offset_negative=0.007, slope_negative=0.3, set_level=0.75,
             reset_level=0.8, pulse_width=0.003, gravity=0.0, scale=1.0, inertia=1.2e-4, damping=0.0288, stiffness=3.84, actuator=200.0, sensor=55.0, delay=0.0)
SETS_MAX = 4  # of parameters in one simulation
WIDE = Path(__file__).with_name("wide.h")


def _sources():
    lib = [ROOT / f"lib/src/{name}.c" for name in ("paper/compensator_f32", "paper/friction_f32", "paper/arm_f32", "number/parameters", "status")]
    return [Path(__file__).with_name("native.c"), ROOT / "host_sim/log/verdict.c", ROOT / "host_sim/log/path.c", ROOT / "common/support/error.c", *lib]


def _digest():
    seen = hashlib.sha256()
    for path in [WIDE, *_sources(), *sorted((ROOT / "lib/src").glob("*/*.h")), *sorted((ROOT / "lib/include/tribo").glob("*.h")), ROOT / "host_sim/log/verdict.h", ROOT / "host_sim/log/path.h", ROOT / "host_sim/log/log.h"]:
        seen.update(path.read_bytes())
    return seen.hexdigest()[:16]


@functools.cache
def library():
    """Compiled into the user's cache, under the sources' digest."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tribo" / "identify"
    built = cache / f"native-{_digest()}.so"
    if not built.exists():
        compiler = next((c for c in ([os.environ["CC"]] if os.environ.get("CC") else ["cc", "gcc", "clang"]) if shutil.which(c)), None)
        if compiler is None:
            raise DesignError("needs a C compiler (cc, gcc or clang in PATH, or CC), as the friction model is the library's own")
        cache.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=cache) as folder:
            fresh = Path(folder) / "native.so"
            done = subprocess.run([compiler, "-std=c11", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-D_XOPEN_SOURCE=700", "-include", WIDE, "-I", ROOT / "lib/include", "-I", ROOT / "common", "-I", ROOT / "host_sim",
                                   *_sources(), "-o", fresh, "-lm"], capture_output=True, text=True, check=False)
            if done.returncode != 0:
                raise DesignError(f"the library does not compile with {compiler}: {(done.stderr.splitlines() or ['no message'])[0]}")
            fresh.rename(built)
    native = ctypes.CDLL(str(built))
    assert ctypes.c_int.in_dll(native, "identify_parameters").value == len(NAMES)
    assert ctypes.c_int.in_dll(native, "identify_sets_max").value == SETS_MAX
    doubles = np.ctypeslib.ndpointer(np.float64, flags="C")
    native.identify_simulate.argtypes = [doubles, doubles, ctypes.c_int, ctypes.c_int, doubles, ctypes.c_size_t, ctypes.c_double, ctypes.c_int, ctypes.c_double, doubles]
    native.identify_slides.argtypes = [doubles, doubles, ctypes.c_size_t, ctypes.c_double, np.ctypeslib.ndpointer(np.int8, flags="C")]
    native.identify_status_text.restype = ctypes.c_char_p
    return native


def simulate(params, u, interval_s, start_n, substeps=10, table=()):
    """y of a segment: the library's compensator as the arm, behind the actuator and in front of the sensor."""
    return simulate_sets([params], u, interval_s, start_n, substeps, [table])[0]


def simulate_sets(params, u, interval_s, start_n, substeps, tables):
    """The same for each of several params, and their tables of one length."""
    p = np.array([[one[name] for name in NAMES] for one in params], float)
    points = np.array(tables, float).reshape(len(p), -1)
    y = np.empty((len(p), len(u)))
    status = library().identify_simulate(p.ravel(), np.ascontiguousarray(points).ravel() if points.size else np.zeros(3), points.shape[1] // 3, len(p), u, len(u), interval_s,
                                         substeps, start_n, y.ravel())
    if status != 0:
        raise DesignError(f"the library refuses these parameters: {library().identify_status_text(status).decode()}")
    time = np.arange(len(u)) * interval_s
    for row, one in zip(y, params):
        if one["delay"]:
            row[:] = np.interp(time - one["delay"], time, row)
    return y


def slides(u, force, interval_s):
    """+1, -1 or 0 for each row: the way of a slow slide."""
    ways = np.zeros(len(u), np.int8)
    if library().identify_slides(u, np.ascontiguousarray(force), len(u), interval_s, ways) != 0:
        raise DesignError("out of memory")
    return ways


def tribo_sim():
    """The program: TRIBO_SIM, or what tools/demo or a preset has built, or in PATH."""
    if os.environ.get("TRIBO_SIM"):
        return os.environ["TRIBO_SIM"]
    for tree in ("demo/tree", "host-release", "clang"):
        built = ROOT / "build" / tree / "host_sim" / "tribo-sim"
        if built.exists():
            return str(built)
    found = shutil.which("tribo-sim")
    if found is None:
        raise DesignError("tribo-sim is not built: run tools/demo, or set TRIBO_SIM to its path")
    return found


def run_tribo_sim(*arguments, cwd=None):
    """Its standard output; its own words if it fails."""
    done = subprocess.run([tribo_sim(), *map(str, arguments)], capture_output=True, text=True, check=False, cwd=cwd)
    if done.returncode != 0:
        raise InputError(done.stderr.strip().removeprefix("tribo-sim: ").split(" (tribo-sim --help")[0] or f"tribo-sim ended with {done.returncode}")
    return done.stdout, done.stderr
