"""tribo-identify on rigs of foreign simulators: foreign_study.py [COUNT] [FIRST SEED]. Half of COUNT logs are sound, half of those are spoilt as well.

A result is wrong with confidence if offset, slope and scale are all called identified, and L is anywhere below 0.95 of sliding or above 1.05 of breakaway,
or the scale of u off by more than 5 %. Coverage of the 95 % intervals is of the sound rigs whose friction neither falls nor differs by direction. All is as the command line
has it without options. Seeds from 100000 on were not looked at while the method was made.
"""

import os
import sys
import tempfile
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import foreign
import numpy as np
import synthetic

from tribo_design.errors import DesignError
from tribo_identify import friction, logs

SPOILS = ("wrong sign", "scale", "clipped", "delayed", "resampled", "missing samples", "one direction", "too small", "swapped columns", "degrees", "saturated", "held levels")
FAMILIES = ("calibrated", "scaled", "falling", "asymmetric")  # every third rig is of the next


def rig_of(seed):
    family = FAMILIES[seed // 3 % len(FAMILIES)]
    source = np.random.default_rng([seed, 30])
    given = {"calibrated": {"scale": 1.0}, "scaled": {}, "falling": {"scale": 1.0, "ratio": source.uniform(0.8, 0.95)}, "asymmetric": {"scale": 1.0, "less": source.choice([0.7, 0.85, 1.2, 1.4])}}
    return foreign.rig_of(seed, **given[family])


def played(seeds, pool):
    """(rig, rows) of each seed; rigs of a kind side by side."""
    rigs = [rig_of(s) for s in seeds]
    kinds = [[r for r in rigs if r["kind"] == kind] for kind in foreign.KINDS]
    rows = dict(zip([r["seed"] for of_kind in kinds for r in of_kind], [log for logs in pool.map(foreign.play, filter(None, kinds)) for log in logs]))
    return [(r, rows[r["seed"]]) for r in rigs]


def spoil(rig, rows, what, source):
    """Rows t, u, F with a flaw, and by how much u of them is smaller than the rig's."""
    rows, smaller, h = rows.copy(), 1.0, rig["period"]
    if what == "wrong sign":
        rows[:, source.integers(1, 3)] *= -1
    if what == "scale":
        times, column = np.exp(source.choice([-1, 1]) * source.uniform(np.log(1.25), np.log(10))), source.integers(1, 3)
        rows[:, column] *= times
        smaller = times if column == 1 else 1.0
    if what == "clipped":
        rows[:, 2] = np.minimum(rows[:, 2], np.quantile(rows[:, 2], source.uniform(0.5, 0.9)))
    if what == "saturated":
        rows[:, 1] = np.minimum(rows[:, 1], np.quantile(rows[:, 1], source.uniform(0.5, 0.95)))
    if what == "delayed":
        n, late = int(source.uniform(0.1, 0.6) / h), source.integers(2)
        rows = np.c_[rows[n:, 0], rows[n:, 1], rows[:-n, 2]] if late else np.c_[rows[:-n, 0], rows[:-n, 1], rows[n:, 2]]
    if what == "resampled":
        rows = rows[:: max(int(source.uniform(0.02, 0.1) / h), 1)]
    if what == "missing samples":  # and the stamps are made anew
        rows = rows[source.uniform(size=len(rows)) > source.uniform(0.05, 0.3)]
        rows[:, 0] = np.arange(len(rows)) * h
    if what == "one direction":
        begin = int(source.uniform(0.02, 0.8) * len(rows))
        span = rows[begin:, 2]
        end = begin + int(np.argmax(np.maximum.accumulate(span) - span > 0.05 * np.ptp(rows[:, 2]))) or len(rows)
        rows = rows[begin : max(end, begin + int(1.5 / h))]
    if what == "too small":
        rows[:, 1:] *= source.uniform(0.003, 0.03)
        rows[:, 2] = np.round((rows[:, 2] + source.normal(0, rig["noise"], len(rows))) / rig["step"]) * rig["step"]
    if what == "swapped columns":
        rows[:, 1:] = rows[:, 2:0:-1]
    if what == "degrees":
        rows[:, 2] = rows[:, 2] / np.exp(source.uniform(np.log(0.05), np.log(20))) + source.uniform(-1, 1) * np.ptp(rows[:, 2])
    if what == "held levels":
        n = max(int(source.uniform(0.1, 0.5) / h), 1)
        rows[:, 1] = rows[np.arange(len(rows)) // n * n, 1]
    rows[:, 0] -= rows[0, 0]
    return rows, smaller


def read(rows):
    """Reads a log as the command line does."""
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as name:
        return logs.read([synthetic.write_log(Path(name), rows)])


def judged(rig, result, smaller=1.0):
    """identified, weak or wrong."""
    if any(e.verdict != "identified" for e in result.estimates if e.name.startswith(("offset", "slope", "scale", "L"))):
        return "weak"
    force = np.linspace(rig["low"], rig["high"], 9)
    for way, L in zip((1, -1), friction.breakaway(result.params, result.table, force)):
        if np.any(L < 0.95 * foreign.L_of(rig, force, way, sliding=True)) or np.any(L > 1.05 * foreign.L_of(rig, force, way)):
            return "wrong"
    return "wrong" if abs(result.params["scale"] * smaller / rig["scale"] - 1) > 0.05 else "identified"


def one(task):
    """What becomes of a log: (verdict, text), and which intervals hold."""
    rig, rows, what = task
    source, smaller, hit = np.random.default_rng([rig["seed"], 31]), 1.0, {}
    try:
        if what in SPOILS:
            rows, smaller = spoil(rig, rows, what, source)
        result = friction.identify(read(rows), assume=None)
    except DesignError as error:
        return "refused", str(error), hit
    except Exception as error:  # what nobody thought of counts as wrong, and the study goes on
        return "wrong", repr(error), hit
    if what in FAMILIES[:2]:
        truth = {**rig, "gravity": rig["bias"]}
        hit = {e.name: abs(e.value - truth[e.name]) <= e.half for e in result.estimates if e.name in friction.SYMMETRIC}
    L = friction.breakaway(result.params, result.table, np.array([rig["low"], rig["high"]]))[0] / foreign.L_of(rig, np.array([rig["low"], rig["high"]]))
    scale = next((f"scale {e.value:.3f} +- {e.half:.2g}" for e in result.estimates if e.name == "scale"), "")
    return judged(rig, result, smaller), f"{'slides' if result.line_error is not None else 'model'}: L+ {L[0]:.3f}, {L[1]:.3f} of it; {scale}; falls by {result.fall[0]:.3f}", hit


def study(count=300, first=100_000):
    seen, hits, wrong = {}, [], 0
    with ProcessPoolExecutor(int(os.environ.get("STUDY_JOBS", os.cpu_count()))) as pool:
        rigs = played(range(first, first + count // 2), pool)
        tasks = [(rig, rows, what) for i, (rig, rows) in enumerate(rigs) for what in (FAMILIES[rig["seed"] // 3 % len(FAMILIES)], SPOILS[i % len(SPOILS)])]
        for (rig, _, what), (verdict, text, hit) in zip(tasks, pool.map(one, tasks)):
            print(f"{rig['seed']} {rig['kind']:<8} {what:<16} {verdict:<10} {text[:150]}", flush=True)
            seen.setdefault(what, Counter())[verdict] += 1
            hits += [hit] if hit else []
            wrong += verdict == "wrong"
    for what, by in seen.items():
        print(f"{what:<16}" + ", ".join(f"{verdict} {n}" for verdict, n in sorted(by.items())))
    print("coverage of the 95 % intervals: " + ", ".join(f"{n} {np.mean([h[n] for h in hits if n in h]):.1%} of {sum(n in h for h in hits)}" for n in friction.SYMMETRIC if any(n in h for h in hits)))
    print(f"wrong with confidence: {wrong} of {2 * len(rigs)} logs")
    return seen, hits, wrong


if __name__ == "__main__":
    os.nice(5)
    study(*map(int, sys.argv[1:]))
