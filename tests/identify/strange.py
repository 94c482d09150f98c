"""Sound and spoilt logs of strange.c, a simulator that shares no line with the project, and what tribo-identify may say of them.

    strange.py [COUNT] [FIRST SEED]

plays COUNT sound logs and COUNT spoilt ones. A spoilt log must be answered rightly or get a reason that is among its own; a sound one must not be refused. Seeds from
1000 on were not looked at while the checks were made.
"""

import contextlib
import functools
import io
import os
import re
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from synthetic import plan_over

from tribo_identify import cli

HERE = Path(__file__).parent
LAWS = ("coulomb", "stribeck", "maxwell", "lugre")
# What a text may name, by a word of it.
NAMES = {"jumps": r"jumps: |off for a row", "stands": r"F stands for", "no sign": r"its sign was lost", "turned": r"wrong sign", "held": r"held: |changes only every", "clock": r"clock: |does not come after|"
         r"goes back|runs backwards|row before", "unit of t": r"its stamps are", "exchanged": r"exchanged: ", "units": r"units: |is not a force", "limit": r"saturated: ", "silent": r"is silent|does not change",
         "loads": r"few loads", "one way": r"one direction", "pattern": r"a pattern over force|ripple: |a ripple of", "time": r"friction changes with time", "drift": r"F drifts",
         "falls": r"friction falls|sliding are not the model's", "law": r"differs from the model's|not the model's, which|does not explain|differ from a line|line does not fit", "none": r"no stiction", "push": r"would push",
         "column": r"no column|is no number|is not a number", "broken": r"rows are broken|more fields|fields, the", "scale": r"either your command makes", "noise": r"has noise of|logged in steps of"}


@functools.cache
def program():
    path = Path(tempfile.mkdtemp(prefix="strange-")) / "strange"
    subprocess.run(["cc", "-O2", "-std=c11", HERE / "strange.c", "-lm", "-o", path], check=True)
    return path


def rig_of(seed, both=False):
    """0.1 to 500 N, 0.5 to 10 kHz, ways of friction in turn."""
    source = np.random.default_rng([seed, 38])
    log = lambda low, high: float(np.exp(source.uniform(np.log(low), np.log(high))))
    high, law = log(0.1, 500.0), seed % len(LAWS)
    rig = {"seed": seed, "law": law, "high": high, "h": float(source.choice([1e-4, 2e-4, 5e-4, 1e-3, 2e-3])), "m": log(0.02, 5.0), "w": log(70.0, 250.0), "z": source.uniform(0.3, 1.0),
           "drive": log(3e-4, 5e-3), "sensor": log(3e-4, 8e-3), "noise": high * log(1e-4, 1e-3), "step": high * log(1e-4, 1e-3), "offset": high * log(0.01, 0.06), "slope": source.uniform(0.05, 0.3),
           "stiff": source.uniform(20.0, 60.0), "bias": high * source.uniform(-0.01, 0.01), "viscous": 0.0, "sliding": source.uniform(0.85, 0.95) if law == 1 else 1.0, "stribeck": high * log(0.05, 1.0),
           "delay": int(source.integers(0, 4)), "both": both}
    rig["viscous"] = float(source.uniform(0, 1)) * 2 * rig["z"] * rig["m"] * rig["w"]
    return rig


def play(rig, plan=None, **more):
    """Rows t, u, F of the plan of somebody who guesses friction within 20 %."""
    low = -rig["high"] if rig["both"] else 0.15 * rig["high"]
    plan = plan or plan_over(low, rig["high"], noise=float(f"{np.hypot(rig['noise'], 0.3 * rig['step']):.2g}"), offset=1.1 * rig["offset"], slope=1.1 * rig["slope"], sample_time_s=rig["h"])
    with tempfile.TemporaryDirectory() as name:
        np.savetxt(Path(name) / "plan.txt", plan.reference(), fmt="%.9g")
        numbers = {k: v for k, v in (rig | more).items() if k != "both"} | {"high": 3 * rig["high"]}
        done = subprocess.run([program(), Path(name) / "plan.txt", *(f"{k}={v!r}" for k, v in numbers.items())], capture_output=True, check=True)
    return np.frombuffer(done.stdout).reshape(-1, 3).copy()


def by_source(rig):
    return np.random.default_rng([rig["seed"], 39])


class Risen:
    """A plan of ramps upwards alone, of several rates."""

    def __init__(self, rig):
        self.high = rig["high"]

    def reference(self):
        ends = np.linspace(0, 1, 9)
        lasts = np.where(np.arange(9) % 2 == 0, 0.5, 3.0)
        return np.array([(t, self.high * part) for end, part, last in zip(np.cumsum(lasts + 1.0), ends, lasts) for t in (end - 1.0, end)])


def sparse(rows, rig, part):
    return by_source(rig).uniform(size=len(rows)) < part


def wrapped(rows, rig, column=2):
    top = 0.65 * np.abs(rows[:, column]).max()
    rows[:, column] = (rows[:, column] + top) % (2 * top) - top
    return rows


def clipped(rows, column):
    rows[:, column] = np.minimum(rows[:, column], 0.7 * rows[:, column].max())
    return rows


def with_column(rows, column, values):
    rows = rows.copy()
    rows[:, column] = values
    return rows


def late(rows, rig, seconds):
    n = int(abs(seconds) / rig["h"])
    return np.c_[rows[:-n, 0], rows[n:, 1], rows[:-n, 2]] if seconds > 0 else np.c_[rows[:-n, 0], rows[:-n, 1], rows[n:, 2]]


def dead(rows, rig, seconds):
    """The bus is dead in the midst of the fastest slide: the logger repeats F."""
    n = int(seconds / rig["h"])
    size = max(int(0.05 / rig["h"]), 1)
    middle = len(rows) // 2 + int(np.argmax(np.abs(rows[len(rows) // 2 + size : -2 * n, 2] - rows[len(rows) // 2 : -2 * n - size, 2])))
    rows[middle : middle + n, 2] = rows[middle, 2]
    return rows


# By name: (what is played otherwise, what becomes of the rows, options of the command, the names that a reason may have; of one that may be answered rightly `right`)
SPOILS = {
    "wrap of F": ({}, lambda rows, rig: wrapped(rows, rig), (), {"jumps"}),
    "wrap of u": ({}, lambda rows, rig: wrapped(rows, rig, 1), (), {"jumps"}),
    "no sign of F": ({"both": True}, lambda rows, rig: with_column(rows, 2, np.abs(rows[:, 2])), (), {"no sign"}),
    "no sign of u": ({"both": True}, lambda rows, rig: with_column(rows, 1, np.abs(rows[:, 1])), (), {"no sign"}),
    "spikes of 0xFFFF": ({}, lambda rows, rig: with_column(rows, 2, np.where(sparse(rows, rig, 0.001), 65535 * rig["step"], rows[:, 2])), (), {"jumps", "right"}),
    "spikes of 0": ({}, lambda rows, rig: with_column(rows, 2, np.where(sparse(rows, rig, 0.002), 0.0, rows[:, 2])), (), {"jumps", "right"}),
    "many spikes": ({}, lambda rows, rig: with_column(rows, 2, np.where(sparse(rows, rig, 0.05), 3 * rig["high"], rows[:, 2])), (), {"jumps"}),
    "a converter of 10 a second": ({"hold_s": 0.1}, lambda rows, rig: rows, (), {"held"}),
    "F held in the log": ({}, lambda rows, rig: with_column(rows, 2, rows[np.arange(len(rows)) // int(0.08 / rig["h"]) * int(0.08 / rig["h"]), 2]), (), {"held"}),
    "u held in the log": ({}, lambda rows, rig: with_column(rows, 1, rows[np.arange(len(rows)) // int(0.2 / rig["h"]) * int(0.2 / rig["h"]), 1]), (), {"held"}),
    "warms up": ({"warm": 0.3}, lambda rows, rig: rows, (), {"time"}),
    "drifts": ({"drift": 0.05}, lambda rows, rig: rows, (), {"drift"}),
    "tare in the midst": ({"tare": 0.06}, lambda rows, rig: rows, (), {"drift", "jumps"}),
    "cogging": ({"cog": 0.25}, lambda rows, rig: rows, (), {"pattern"}),
    "columns exchanged": ({}, lambda rows, rig: rows[:, [0, 2, 1]], (), {"exchanged"}),
    "F turned": ({}, lambda rows, rig: rows * [1, 1, -1], (), {"turned"}),
    "u turned": ({}, lambda rows, rig: rows * [1, -1, 1], (), {"turned"}),
    "ampere": ({}, lambda rows, rig: rows * [1, 0.08, 1], (), {"units"}),
    "millinewton": ({}, lambda rows, rig: rows * [1, 1, 1000], (), {"units"}),
    "counts": ({}, lambda rows, rig: rows * [1, 1, 1 / rig["step"]], (), {"units"}),
    "percent": ({}, lambda rows, rig: rows * [1, 100 / rig["high"] if not 0.5 < 100 / rig["high"] < 2 else 10, 1], (), {"units"}),
    "F clipped": ({}, lambda rows, rig: clipped(rows, 2), (), {"limit"}),
    "u clipped": ({}, lambda rows, rig: clipped(rows, 1), (), {"limit"}),
    "F early": ({}, lambda rows, rig: late(rows, rig, -0.3), (), {"clock"}),
    "F late": ({}, lambda rows, rig: late(rows, rig, 0.4), (), {"clock"}),
    "the bus is dead": ({}, lambda rows, rig: dead(rows, rig, 0.3), (), {"stands", "right"}),
    "ms for s": ({}, lambda rows, rig: rows, ("--unit", "t=ms"), {"unit of t"}),
    "s for ms": ({}, lambda rows, rig: rows * [1000, 1, 1], (), {"unit of t"}),
    "stamps begin anew": ({}, lambda rows, rig: with_column(rows, 0, rows[:, 0] % (0.5 * rows[-1, 0])), (), {"clock"}),
    "stamps twice": ({}, lambda rows, rig: with_column(rows, 0, rows[np.arange(len(rows)) // 2 * 2, 0]), (), {"clock"}),
    "F is constant": ({}, lambda rows, rig: with_column(rows, 2, rows[0, 2]), (), {"silent"}),
    "u is constant": ({}, lambda rows, rig: with_column(rows, 1, 0.1), (), {"silent"}),
    "one way": ({}, lambda rows, rig: play(rig, plan=Risen(rig)), (), {"one way", "loads"}),
}


def spoilt(rig, what):
    """Rows of a spoilt log, and the options to read it."""
    more, change, options, _ = SPOILS[what]
    rig = rig | {"both": more.get("both", False)}
    scaled = {k: v * rig["high"] for k, v in more.items() if k in ("drift", "tare")}
    if "cog" in more:
        scaled |= {"cog": more["cog"] * (rig["offset"] + 0.5 * rig["slope"] * rig["high"]), "period": 0.13 * rig["high"]}
    if "tare" in more:
        scaled["tare_s"] = 15.0
    if "hold_s" in more:
        scaled["hold"] = int(more["hold_s"] / rig["h"])
    if "warm" in more:
        scaled["warm"] = more["warm"]
    return change(play(rig, **scaled), rig), options


def call(rows, options=()):
    """What the command line says of rows, as a logger writes them."""
    out, err = io.StringIO(), io.StringIO()
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "log.csv"
        np.savetxt(path, rows, delimiter=",", header="time,cmd,force", comments="", fmt=("%.7g", "%.7g", "%.6g"))
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = cli.main(["friction", str(path), "--column", "t=time", "--column", "u=cmd", "--column", "F=force", *options])
    return code, out.getvalue() + err.getvalue()


def named(text):
    """What a text names."""
    return {name for name, words in NAMES.items() if re.search(words, text)}


def estimates(text):
    """offset and slope, and whether both are called identified; None if there are none."""
    found = [re.search(rf"breakaway {name} +(\S+).*?(identified|weak)", text) for name in ("offset", "slope")]
    return None if None in found else (*(float(f[1]) for f in found), all(f[2] == "identified" for f in found))


def is_right(rig, text, within):
    """Is L right over the loads? Where it falls with speed, between sliding and breakaway; a table is not looked at."""
    found = estimates(text)
    if found is None:
        return True
    force = np.linspace(0.15, 1.0, 5) * rig["high"]
    true = rig["offset"] + rig["slope"] * force
    L = found[0] + found[1] * force
    return bool(np.all(L > (1 - within) * rig["sliding"] * true) and np.all(L < (1 + within) * true))


def judge_sound(rig, code, text):
    untrue = named(text) & {"time", "drift", "pattern", "jumps", "stands", "held", "clock", "units", "exchanged", "limit", "none", "noise"}
    untrue |= {"falls"} & named(text) if rig["sliding"] == 1.0 else set()
    confident = (estimates(text) or (0, 0, False))[2]
    return "refused" if code else "wrong with confidence" if confident and not is_right(rig, text, 0.05) else f"untrue: {', '.join(sorted(untrue))}" if untrue else "right"


def judge_spoilt(rig, what, code, text):
    mine = SPOILS[what][3]
    said = named(text) - ({"scale", "law"} if code == 0 else set())
    confident = (estimates(text) or (0, 0, False))[2]
    if code == 0 and confident and not is_right(rig, text, 0.05):
        return "wrong with confidence"
    if said & mine or ("right" in mine and code == 0 and is_right(rig, text, 0.05)):
        return "right" if not said - mine - {"falls"} or code else f"untrue as well: {', '.join(sorted(said - mine))}"
    return "nothing said" if code == 0 and not said else f"untrue: {', '.join(sorted(said))}"


def one(task):
    seed, what = task
    rig = rig_of(seed)
    try:
        rows, options = (play(rig), ()) if what == "sound" else spoilt(rig, what)
        code, text = call(rows, options)
        if code == 70:
            return task, "internal error", text
        return task, judge_sound(rig, code, text) if what == "sound" else judge_spoilt(rig, what, code, text), text
    except Exception as error:  # counts as wrong, and the study goes on
        return task, f"error {error!r}", ""


def tasks_of(first, count):
    names = list(SPOILS)
    return [(seed, what) for i, seed in enumerate(range(first, first + count)) for what in ("sound", names[i % len(names)])]


def study(count=33, first=1000):
    seen = {True: Counter(), False: Counter()}
    with ProcessPoolExecutor(int(os.environ.get("STUDY_JOBS", os.cpu_count()))) as pool:
        for (seed, what), verdict, text in pool.map(one, tasks_of(first, count)):
            seen[what == "sound"][verdict.split(":")[0]] += 1
            said = next((line for line in text.splitlines() if line.startswith("tribo-identify")), "; ".join(line[:150] for line in text.splitlines() if line.startswith("note: ") and "L+ = L-" not in line))
            print(f"{seed:5d} {LAWS[seed % 4]:<9} {what:<28} {verdict:<30} {said[:260]}", flush=True)
    for sound, by in seen.items():
        print("sound: " if sound else "spoilt: ", dict(by))
    return seen


if __name__ == "__main__":
    os.nice(5)
    found = study(*map(int, sys.argv[1:]))
    sys.exit(any(verdict != "right" for verdict in (*found[True], *found[False])))
