"""Rigs as a lab has them (lab.c), and what their owner does: play the command files of tribo-rig, run the loop of the result, ask tribo-identify accept.

A rig's owner knows its tick and its safe force, and nothing else of this.
"""

import ctypes
import functools
import json
from dataclasses import astuple, dataclass, replace

import foreign
import numpy as np
import way

import tribo
from tribo_identify import accept, bins
from tribo_identify.logs import Segment

STEP_S = 2e-5


@dataclass
class Lab:
    """The struct of lab.c, in its order; `high` is the safe force."""

    tick_s: float
    scale: float = 1.0
    bias: float = 0.0
    late_ticks: float = 1.0
    actuator_s: float = 0.002
    sensor_s: float = 0.002
    mass: float = 2.5e-5
    damping: float = 0.01
    offset: float = 0.4
    slope: float = 0.12
    downwards: float = 1.0
    law: float = 0.0
    falls_to: float = 1.0
    fall_at: float = 1.0
    travel: float = 0.3
    play: float = 0.0
    ripple: float = 0.0
    ripple_every: float = 1.0
    ripple_at: float = 0.0
    noise: float = 0.004
    step: float = 0.0
    drift_per_s: float = 0.0
    warms_per_s: float = 0.0
    seed: float = 1.0
    high: float = 20.0


COULOMB, STRIBECK, MAXWELL, MAXWELL_FALLS, BRISTLE = range(5)


def sized(tick_s, high, lag_s, part=0.15, slope=0.12, **more):
    """A rig by its size: breakaway is `part` of half of the safe force; what is in `more` is in parts of breakaway, but for the slope and what has no newton."""
    L = part * high / 2
    newtons = ("bias", "travel", "play", "ripple", "ripple_every", "noise", "step")
    values = {"noise": 0.005, **more}
    made = {name: value * L if name in newtons else value for name, value in values.items()}
    if made.get("law") == STRIBECK:
        made["fall_at"] *= high
    if made.get("law") == MAXWELL_FALLS:
        made["fall_at"] *= L
    damping = 0.5 * lag_s
    return Lab(tick_s, offset=max(L - slope * high / 2, 0.1 * L), slope=slope, damping=damping, mass=(damping / 1.6) ** 2, actuator_s=0.2 * lag_s, sensor_s=0.3 * lag_s, high=high, **made)


# Looked at while the prediction and the rule of accept were made.
SEEN = {
    "coulomb": sized(5e-4, 20.0, 0.019, scale=1.06, step=0.007),
    "steps": sized(1e-3, 20.0, 0.02, step=0.25, noise=0.01, late_ticks=2),
    "play": sized(1e-3, 10.0, 0.03, play=2.0, scale=0.95),
    "maxwell falls": sized(2e-3, 100.0, 0.06, law=MAXWELL_FALLS, falls_to=0.8, fall_at=0.6, travel=0.3),
    "cogging": sized(1e-3, 5.0, 0.025, ripple=0.12, ripple_every=2.0, ripple_at=0.3, bias=0.05),
    "bristle": sized(5e-4, 0.5, 0.012, law=BRISTLE, falls_to=0.9, fall_at=0.02, travel=0.2, step=0.05),
}
# Not looked at before the end.
UNSEEN = {
    "stribeck in steps": sized(2e-4, 2.0, 0.008, law=STRIBECK, falls_to=0.88, fall_at=0.02, step=0.15, late_ticks=3, scale=1.1),
    "maxwell drifts": sized(2e-3, 500.0, 0.08, law=MAXWELL, travel=0.25, drift_per_s=0.05, slope=0.2, part=0.25),
    "little play in steps": sized(1e-3, 50.0, 0.02, play=0.6, step=0.1, scale=0.9, bias=-0.1),
    "coulomb at 10 kHz": sized(1e-4, 0.1, 0.006, noise=0.02, part=0.2, scale=0.93, late_ticks=4),
    "coarse cogging": sized(1e-3, 200.0, 0.03, ripple=0.25, ripple_every=5.0, ripple_at=0.7, part=0.2),
    "coarse steps": sized(5e-4, 3.0, 0.015, step=0.5, noise=0.05, slope=0.05, late_ticks=2, scale=1.03),
}
RIGS = SEEN | UNSEEN


@functools.cache
def _library():
    c = ctypes.CDLL(str(foreign.built("lab.so", foreign.HERE / "lab.c")))
    array = np.ctypeslib.ndpointer(np.float64, flags="C")
    c.lab_open.argtypes, c.lab_open.restype = [array, ctypes.c_double], ctypes.c_void_p
    c.lab_close.argtypes = [ctypes.c_void_p]
    c.lab_read.argtypes, c.lab_read.restype = [ctypes.c_void_p], ctypes.c_double
    c.lab_tick.argtypes, c.lab_tick.restype = [ctypes.c_void_p, ctypes.c_double], None
    c.lab_play.argtypes, c.lab_play.restype = [ctypes.c_void_p, array, ctypes.c_int, array], None
    c.lab_most.argtypes, c.lab_most.restype = [ctypes.c_void_p], ctypes.c_double
    return c


class Rig:
    """At rest."""

    def __init__(self, lab, run=0):
        self.c = _library()
        self.lab = self.c.lab_open(np.array(astuple(replace(lab, seed=64 * lab.seed + run))[:-1], float), STEP_S)
        self.read, self.tick = functools.partial(self.c.lab_read, self.lab), functools.partial(self.c.lab_tick, self.lab)

    def __del__(self):
        self.c.lab_close(self.lab)

    def play(self, u):
        u, y = np.ascontiguousarray(u, float), np.empty(len(u))
        self.c.lab_play(self.lab, u, len(u), y)
        return y

    @property
    def largest(self):
        return self.c.lab_most(self.lab)


def go(lab, folder, more=""):
    """tribo-rig the whole way on a rig: (exit code, what the last call said)."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rig.yaml").write_text(f"sample_time_s: {lab.tick_s}\nforce: {{low_N: 0, high_N: {lab.high:.6g}}}\nlog: {{columns: {{F: y}}}}\n{more}")
    for run, name in enumerate(("1-ramp", "2-slides")):
        code, said = way.call(folder)
        if code or not (folder / f"{name}.csv").exists():
            return code or 1, said
        t, u = np.loadtxt(folder / f"{name}.csv", delimiter=",", skiprows=1).T
        rig = Rig(lab, run)
        np.savetxt(folder / f"{name}-log.csv", np.c_[t, u, rig.play(u)], delimiter=",", header="t_s,u_N,y", comments="", fmt="%.7g")
        assert max(rig.largest, u.max()) <= lab.high
    return way.call(folder)


def run(lab, scenario, per_N, low, high, number):
    """t, r, u in the rig's command, y: the library's loop of a scenario on the rig, tick by tick, on the triangle of accept."""
    loop, rig = tribo.Loop(scenario), Rig(lab, number)
    t = np.arange(int(accept.PERIODS * accept.PERIOD_S / lab.tick_s)) * lab.tick_s
    r = low + (high - low) * (1 - np.abs(2 * (t % accept.PERIOD_S / accept.PERIOD_S) - 1))
    u, y = np.empty(len(r)), np.empty(len(r))
    for k, wanted in enumerate(r.tolist()):
        y[k] = now = rig.read()
        u[k] = command = per_N * loop.step(wanted, now)
        rig.tick(command)
    return t, r, u, y


def breakaway_off(lab, folder):
    """By how much the loop's breakaway is off over the task, as (least, most) over the rig's: of one that falls as it slides, over what it slides with."""
    loop, (low, high) = accept.load(folder / "result/loop.yaml"), json.loads((folder / "result/verdict.json").read_text())["task_N"]
    parts = [accept.level_of(loop, force) / (lab.offset + lab.slope * abs(force)) / (lab.falls_to if lab.law else 1.0) - 1 for force in np.linspace(low, high, 50)]
    return min(parts), max(parts)


# What the rig has in place of what was identified, and whether accept has to take the loop.
AMPERE = 0.05  # for a newton of u, where the drive's own log has the command in its unit
OTHERS = {
    "right": ({}, True),
    "logged in the drive's unit": ({}, True),
    "30 % less friction": ({"offset": 0.7, "slope": 0.7}, False),
    "40 % more friction": ({"offset": 1.4, "slope": 1.4}, False),
    "command 12 % less": ({"scale": 0.88}, False),
    "no friction": ({"offset": 1e-3, "slope": 1e-3}, False),
}


def sequence(lab, folder, case):
    """Segments by case: the logs of accept's sequence on the rig of OTHERS."""
    found = json.loads((folder / "result/verdict.json").read_text())
    other = replace(lab, **{name: times * getattr(lab, name) for name, times in OTHERS[case][0].items()})
    low, high = found["task_N"]
    loop, segments = accept.load(folder / "result/loop.yaml"), {}
    for number, name in enumerate(accept.CASES):
        path = folder / f"{name}.yaml"
        path.write_text(accept.yaml_text(accept.case_of(loop, name, low, high)), encoding="utf-8")
        t, r, u, y = run(other, path, found["command_per_N"], low, high, 2 + number)
        segments[name] = Segment(name, t, u / found["command_per_N"] * (AMPERE if "unit" in case else 1.0), y, reference=r, h=lab.tick_s)
    return segments


def accepted(lab, folder, cases=tuple(OTHERS)):
    """(measured, lines, reasons against) of accept by case of OTHERS; and what it predicts, as that is the same for all."""
    loop, found = accept.load(folder / "result/loop.yaml"), json.loads((folder / "result/verdict.json").read_text())
    predicted, said = None, {}
    for case in cases:
        segments = sequence(lab, folder, case)
        readings = bins.readings_of(segments["off"].force)
        predicted = predicted or accept.predict(loop, *found["task_N"], readings)
        said[case] = accept.judge(loop, segments, readings, predicted)
    return said, predicted


def played(verdicts, folder):
    """By what the error of the right rig is divided; and (likely, least, most) as the verdict of tribo-rig has it."""
    rms = verdicts["right"][0]
    return rms["off"].rms / rms["on"].rms, json.loads((folder / "result/verdict.json").read_text())["divided_by"]
