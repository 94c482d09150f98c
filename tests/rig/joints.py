"""Joints of joints.c, which has no line of the project's models; and how well tribo-rig --joint finds them: joints.py FIRST LAST."""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools" / name) for name in ("rig", "identify", "design")]

from tribo_identify.refusal import Refusal  # noqa: E402
from tribo_rig import slip  # noqa: E402

BUILT = Path(tempfile.mkdtemp(prefix="joints-"))


def play(seed, folder, fault=""):
    """Writes the logs, and returns the truth."""
    if not (BUILT / "joints").exists():
        subprocess.run(["cc", "-std=c11", "-O2", Path(__file__).with_name("joints.c"), "-o", BUILT / "joints", "-lm"], check=True)
    return json.loads(subprocess.run([BUILT / "joints", str(seed), folder, *([fault] if fault else [])], capture_output=True, text=True, check=True).stdout)


def logs_in(folder):
    made = []
    for path in sorted(Path(folder).glob("*-log.csv")):
        t, u, q = np.loadtxt(path, delimiter=",", skiprows=1, unpack=True)
        made.append(slip.Log(path.name, np.ascontiguousarray(u), np.ascontiguousarray(q), float(t[1] - t[0])))
    return made


def found(seed, fault=""):
    """The truth, and what is found or why it is refused."""
    with tempfile.TemporaryDirectory() as folder:
        truth = play(seed, folder, fault)
        try:
            return truth, slip.identify(logs_in(folder), truth["u_max"])
        except Refusal as refusal:
            return truth, refusal


def compared(truth, result):
    """For each reported number: its error and half of its interval, divided by the friction."""
    load = truth["slope"] * result.load
    true = {"friction": truth["friction"] + (0 if result.slope else load), "viscous": truth["viscous"], "slope": truth["slope"], "breakaway": (truth["friction"] + load) * (1 + truth["peak"])}
    unit = {"viscous": truth["friction"] / truth["top"], "slope": 1.0}
    estimates = {name: getattr(result, name) for name in true}
    return {name: ((e.value - true[name]) / unit.get(name, truth["friction"]), e.half / unit.get(name, truth["friction"])) for name, e in estimates.items() if e is not None}


def main():
    rows, refused = {}, 0
    for seed in range(int(sys.argv[1]), int(sys.argv[2]) + 1):
        truth, result = found(seed)
        if isinstance(result, Refusal):
            refused += 1
            print(f"{seed:5} {truth['law']:9} refused, {result.cause}: {result}")
            continue
        told = compared(truth, result)
        print(f"{seed:5} {truth['law']:9} {1 / truth['sample_time_s']:5.0f} Hz  " + ", ".join(f"{name} {error:+.3f} +- {half:.3f}{'' if abs(error) <= half else ' OUTSIDE'}" for name, (error, half) in told.items()), flush=True)
        for name, pair in told.items():
            rows.setdefault(name, []).append(pair)
    for name, pairs in rows.items():
        error, half = np.abs(np.array(pairs)).T
        print(f"{name}: {np.sum(error <= half)} of {len(error)} within their intervals of 95 %; error {np.median(error):.4f} in the median, {np.percentile(error, 90):.4f} at 90 %; half interval {np.median(half):.4f}")
    print(f"refused: {refused}")


if __name__ == "__main__":
    main()
