"""Rigs of foreign simulators: foreign.c around tests/closed_loop/foreign_plant.c, which has no line of the project's models."""

import ctypes
import hashlib
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools" / name) for name in ("rig", "identify", "design")]

HERE = Path(__file__).parent
LAWS = ("coulomb", "stribeck", "lugre", "maxwell")
BUILT = Path(tempfile.mkdtemp(prefix="foreign-"))


@dataclass
class Truth:
    law: str
    tick_s: float
    actuator: float  # rad/s
    sensor: float
    inertia: float  # I/K, s^2
    damping: float  # b/K, s
    offset: float  # N
    slope: float
    sliding: float
    stribeck: float
    presliding: float  # N of travel
    noise: float
    scale: float
    bias: float
    delay: int  # ticks
    high: float  # safe force, N
    seed: int
    downwards: float = 1.0  # friction over that upwards


def truth_of(seed):
    """Rigs far from the paper's: 0.5 to 500 N, 0.5 to 5 kHz, lags of 3 to 100 ms."""
    source = np.random.default_rng([seed, 28])
    law = ("coulomb", "lugre", "maxwell")[seed % 3]
    high = float(10 ** source.uniform(-0.3, 2.7))
    lag = float(10 ** source.uniform(-2.4, -1.1))  # of actuator, arm and sensor together
    shares = source.dirichlet((4, 4, 4))
    tick = float(source.choice([2e-4, 5e-4, 1e-3, 2e-3]))
    tick = min(tick, 2e-3, lag / 10)
    tick = max(t for t in (2e-4, 2.5e-4, 5e-4, 1e-3, 2e-3) if t <= max(tick, 2e-4))
    damping, zeta = float(shares[1] * lag), source.uniform(0.5, 2.0)
    offset = float(high * source.uniform(0.005, 0.04))
    slope = float(source.uniform(0.05, 0.35))
    return Truth(law, tick, float(1 / (shares[0] * lag)), float(1 / (shares[2] * lag)), (damping / (2 * zeta)) ** 2, damping, offset, slope, 1.0, 0.05 * high,
                 float(high * source.uniform(0.001, 0.01)), float(high * 10 ** source.uniform(-4, -3)), float(source.uniform(0.85, 1.15)), float(high * source.uniform(-0.01, 0.01)),
                 int(source.integers(0, 4)), high, seed)


def falling(seed):
    """The same rig with Coulomb friction that falls with speed: to 0.8 to 0.95 of breakaway, at 0.5 to 10 % of its range in a second."""
    truth, source = truth_of(seed), np.random.default_rng([seed, 99])
    return replace(truth, law="stribeck", sliding=float(source.uniform(0.8, 0.95)), stribeck=float(truth.high * 10 ** source.uniform(-2.3, -1)))


def built(name, *words):
    """A shared library, compiled once."""
    out = BUILT / name
    if not out.exists():
        subprocess.run(["cc", "-std=c11", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-I", ROOT / "lib/include", *words, "-o", out, "-lm"], check=True)
    return out


def _compiled(name, *words):
    return ctypes.CDLL(str(built(f"{name}.so", *words)))


class Foreign:
    """The rig of a truth, at rest. `run` has its own noise."""

    def __init__(self, truth, run=0):
        t, self.c = truth, _compiled("foreign", HERE / "foreign.c", HERE.parent / "closed_loop/foreign_plant.c")
        self.c.foreign_open.argtypes = [np.ctypeslib.ndpointer(np.float64), ctypes.c_double, ctypes.c_double, ctypes.c_double, ctypes.c_size_t, ctypes.c_ulonglong]
        self.c.foreign_tick.argtypes, self.c.foreign_tick.restype = [ctypes.c_double], None
        self.c.foreign_read.restype = ctypes.c_double
        p = np.array([t.actuator, t.sensor, t.inertia, t.damping, t.offset, t.slope, LAWS.index(t.law), t.sliding, t.stribeck, t.presliding, t.noise, t.downwards], float)
        self.c.foreign_open(p, t.tick_s, t.scale, t.bias, t.delay, t.seed * 16 + run + 1)

    def read(self):
        return self.c.foreign_read()

    def tick(self, command):
        self.c.foreign_tick(command)

    @property
    def largest(self):
        low, high = ctypes.c_double(), ctypes.c_double()
        self.c.foreign_extremes(ctypes.byref(low), ctypes.byref(high))
        return max(-low.value, high.value)


class Loop:
    """The loop of a header that tribo-rig made, with the library."""

    def __init__(self, header, compensated):
        library = built("library.so", *sorted((ROOT / "lib/src").glob("*/*.c")), *sorted((ROOT / "lib/src").glob("*.c")))
        name = hashlib.sha256(Path(header).read_bytes()).hexdigest()[:12]
        self.c = _compiled(name, f'-DLOOP_HEADER="{Path(header).resolve()}"', HERE / "loop.c", library)
        self.c.loop_step.argtypes, self.c.loop_step.restype = [ctypes.c_double, ctypes.c_double], ctypes.c_double
        self.c.loop_start(int(compensated))
        self.step = self.c.loop_step
