"""Logs of simulated rigs, sound and flawed, each from a seed: tribo-sim plays the plan of `tribo-identify plan`."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools" / "identify"), str(ROOT / "tools" / "design")]

from tribo_identify import logs, native  # noqa: E402
from tribo_identify.plan import MARGIN, Plan  # noqa: E402

FLAWS = ("one direction", "few loads", "saturated", "ripple", "clock", "silent", "units")
MODELS = ("paper", "torque", "coulomb", "karnopp", "armstrong", "dahl", "bristle", "reset_integrator", "bliman_sorine", "lubricated", "lugre", "elasto_plastic", "leuven",
          "maxwell_slip", "servo_mx106", "servo_mx64", "servo_xl330", "servo_erob80")


def truth_of(seed):
    """A rig: breakaway, hysteresis, errors of the drive and of the sensor."""
    source = np.random.default_rng(seed)
    return {"offset": source.uniform(0.003, 0.02), "slope": source.uniform(0.1, 0.4), "k_min": source.uniform(3, 10), "k_max": source.uniform(10, 30), "m": 3.0,
            "v0": source.uniform(0.004, 0.01), "scale": source.uniform(0.6, 1.1), "bias": source.uniform(-0.01, 0.01), "noise": source.uniform(0.0005, 0.001),
            "delay": source.uniform(0, 0.003), "seed": int(seed)}


def settings(truth, model="paper"):
    friction = (f"{{k_min: {truth['k_min']}, k_max: {truth['k_max']}, m: {truth['m']}, v0_N_per_s: {truth['v0']}, "
                f"breakaway: {{offset_N: {truth['offset']}, slope: {truth['slope']}}}}}")
    return [f"plant.friction={friction}", f"plant.model={model}", f"plant.command={{scale_error: {truth['scale'] - 1}, bias_N: {truth['bias']}}}",
            f"sensor={{noise_N: {truth['noise']}, quantisation_N: 0.001, delay_s: {truth['delay']}, noise_seed: {truth['seed']}}}"]


def play(folder, scenario, sets, out="run"):
    command = [native.tribo_sim(), "run", str(scenario), "--out", str(folder / out), "--json"]
    for s in sets:
        command += ["--set", s]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    return json.loads(done.stdout)


def plan_over(low, high, **options):
    """A plan whose levels are from `low` to `high` for the breakaway that it guesses."""
    options = {"rate": 2 * high} | options
    span = (high - low) * (1 + 0.5 / (options.get("levels", 4) - 1))
    middle, guess = (low + high) / 2, Plan(0.0, 1.3 * high, **options).check()
    bottom, top = middle - span / 2, middle + span / 2
    ends = bottom - guess.breakaway(bottom), top + guess.breakaway(top)
    more = MARGIN / (1 - 2 * MARGIN) * (ends[1] - ends[0])
    return Plan(ends[0] - more, ends[1] + more, **options | {"offset": guess.offset}).check()


def write_plan(folder, plan):
    rows = plan.reference()
    (folder / "plan.csv").write_text("t_s,r_N\n" + "".join(f"{t:.3f},{r:.6g}\n" for t, r in rows))
    (folder / "plan.yaml").write_text(plan.scenario("plan.csv"))
    return folder / "plan.yaml"


def trace(folder, name="run/trace.csv"):
    """t, u, y of a run, as an array."""
    path = folder / name
    with open(path, encoding="ascii") as file:
        names = file.readline().strip().split(",")
    return np.loadtxt(path, delimiter=",", skiprows=1, usecols=[names.index(n) for n in ("t_s", "u_N", "y_N")])


def write_log(folder, rows, name="log.csv"):
    np.savetxt(folder / name, rows, delimiter=",", header="t_s,u_N,F_N", comments="", fmt=("%.6f", "%.9g", "%.9g"))
    return folder / name


def sound(seed, hysteresis=False, model="paper"):
    """(truth, rows) of a planned experiment on the rig of the seed."""
    truth = truth_of(seed)
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as name:
        folder = Path(name)
        scenario = write_plan(folder, plan_over(0.1, 0.6, noise=0.001, hysteresis=hysteresis))
        play(folder, scenario, settings(truth, model))
        return truth, trace(folder)


def _few_loads(truth, source):
    """One to three loads, each a log of its own that stays about it."""
    pieces = []
    for level in source.choice([0.15, 0.3, 0.45, 0.6], int(source.integers(1, 4)), replace=False):
        with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as name:
            folder = Path(name)
            play(folder, write_plan(folder, plan_over(float(level) - 0.03, float(level) + 0.03)), [*settings(truth), "limits={u_min_N: -2, u_max_N: 2, input_max_N: 2}"])
            rows = trace(folder)
            pieces.append(rows[int(0.1 * len(rows)) : int(0.9 * len(rows))])
    return pieces


def flawed(flaw, seed):
    """(truth, rows) of an experiment with a flaw."""
    truth = truth_of(seed)
    source = np.random.default_rng([seed, 1])
    if flaw == "few loads":
        return truth, _few_loads(truth, source)
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as name:
        folder = Path(name)
        extra = []
        scenario = write_plan(folder, plan_over(0.1, 0.6, noise=0.001))
        if flaw == "one direction":  # a ramp, either way
            rate = source.uniform(0.01, 0.1)
            up = source.uniform() < 0.5
            extra = [f"reference={{kind: ramp, low_N: {0.1 if up else 0.9}, high_N: {1.3 if up else 0.1}, ramp_s: {1.0 / rate}}}", f"duration_s: {1.0 / rate}".replace(": ", "=")]
        if flaw == "ripple":
            largest = truth["offset"] + truth["slope"] * 0.6
            extra = [f"plant.ripple={{amplitude_N: {largest * source.uniform(1.1, 2)}, period_deg: {source.uniform(0.02, 0.1)}}}"]
        if flaw == "saturated" and source.uniform() < 0.5:  # by the drive, which the log shows as applied
            extra = [f"limits.u_max_N={source.uniform(0.25, 0.5)}"]
            play(folder, scenario, settings(truth) + extra)
            return truth, trace(folder)
        play(folder, scenario, settings(truth) + extra)
        rows = trace(folder)
    if flaw == "one direction":  # from where it first has moved
        rows = rows[int(0.3 * len(rows)) :]
    if flaw == "saturated":  # the sensor
        rows[:, 2] = np.minimum(rows[:, 2], np.quantile(rows[:, 2], source.uniform(0.5, 0.85)))
    if flaw == "clock":  # in milliseconds, or force ahead of or far behind the command
        way = source.integers(3)
        if way == 0:
            rows[:, 0] *= 1000
        else:
            shift = int(source.integers(20, 200)) if way == 1 else -int(source.integers(150, 1000))
            rows = np.c_[rows[: len(rows) - abs(shift), 0], rows[-shift:, 1] if shift < 0 else rows[: len(rows) - shift, 1], rows[: len(rows) + shift, 2] if shift < 0 else rows[shift:, 2]]
    if flaw == "silent":
        rows[:, 2] = source.uniform(-1, 1) + truth["noise"] * source.normal(size=len(rows))
    if flaw == "units":
        rows[:, 1 + int(source.integers(2))] *= [1000, 0.001][int(source.integers(2))]
    return truth, rows


def log_of(rows):
    """Returns what logs.read would return, without a file."""
    segments = []
    for piece in rows if isinstance(rows, list) else [rows]:
        t, u, y = (np.ascontiguousarray(piece[:, i]) for i in range(3))
        segments.append(logs.Segment("log.csv", t, u, y, h=float((t[-1] - t[0]) / (len(t) - 1))))
    return logs.Log(segments, segments[0].h)


def L_of(truth, force):
    return truth["offset"] + truth["slope"] * force
