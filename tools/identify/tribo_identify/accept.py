"""tribo-identify accept: are the new parameters better on the rig? A fixed, short sequence, and a rule.

Without logs it writes the sequence: four loops on a triangle of force, with compensation off, on, and with L 20 % less and 20 % more; with
--old a fifth, the old loop. With their logs it judges. The new parameters are accepted if

- the error falls by the factor that a simulation with these parameters predicts, within its interval: the simulation with L 10 % less and
  more in the plant, a tenth added on both sides (a larger factor is welcome);
- with L 20 % less and more the error is smaller than without compensation;
- u does not chatter: it varies at most twice as much as predicted, in each of the four;
- the model follows the log without compensation within 10 % of breakaway;
- the error is smaller than with the old parameters, where these are given.

Otherwise the old ones stay, and the report says why.
"""

import copy
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tribo_design.errors import DesignError, InputError
from tribo_design.output import check_replaceable, write_directory, yaml_text
from tribo_design.reading import read_mapping

from . import bins, logs, native, report

CASES = {"off": None, "on": 1.0, "less": 0.8, "more": 1.2}
PERIOD_S, PERIODS = 10.0, 3
PLANT = (0.9, 1.0, 1.1)  # L of the simulated plant over the loop's
ROOM = 0.1
VARIES = 2.0
RESIDUAL = 0.1
SEQUENCE = (*(f"{case}.yaml" for case in CASES), "old.yaml")
VERDICT = ("report.html", "verdict.json", "accepted.y*ml")


class Rejected(DesignError):
    """The old parameters stay."""

    exit_code = 4


@dataclass
class Played:
    rms: float  # of r - y, over averages of 20 ms, without the first period
    variation: float  # of u, per second, likewise


def load(path):
    tree = read_mapping(path)
    if not isinstance(tree.get("compensator"), dict) or "breakaway" not in (tree["compensator"].get("friction") or {}):
        raise InputError(f"{path}: compensator.friction.breakaway: is missing; tribo-identify friction --scenario writes such a loop")
    return tree


def scaled(friction, times):
    """The friction with L times `times`."""
    friction = copy.deepcopy(friction)
    breakaway = friction["breakaway"]
    for key in ("offset_N", "slope", "negative_offset_N", "negative_slope"):
        if key in breakaway:
            breakaway[key] *= times
    for point in breakaway.get("table", []):
        point["positive_N"] *= times
        point["negative_N"] *= times
    return friction


def plant_of(loop, times=1.0):
    """The loop's plant, which slides with the loop's friction, `times`. Where it falls as it slides, breakaway is larger."""
    plant = loop.get("plant") or {}
    ratio = (plant.get(plant.get("model")) or {}).get("sliding_ratio", 1.0)
    return {**plant, "friction": scaled(loop["compensator"]["friction"], times / ratio)}


def case_of(loop, case, low, high):
    tree = copy.deepcopy(loop)
    compensator = tree["compensator"]
    tree["reference"] = {"kind": "triangle", "low_N": low, "high_N": high, "period_s": PERIOD_S}
    tree["duration_s"] = PERIOD_S * PERIODS
    tree["metrics"] = {"start_s": PERIOD_S}
    tree["description"] = f"acceptance, compensation {case}"
    if case == "off":
        compensator["method"] = "off"
    elif case != "old":
        compensator["friction"] = scaled(compensator["friction"], CASES[case])
    return tree


def check_range(low, high):
    for name, value in (("low", low), ("high", high)):
        if value is None or not np.isfinite(value) or abs(value) > 1e6:
            raise InputError(f"--{name}: value {value}: must be given, within -1e6 to 1e6 N")
    if not low < high:
        raise InputError(f"--high: value {high:g}: must be above --low")


def judged(t, r, u, y):
    h = float(np.median(np.diff(t)))
    rows = t - t[0] >= PERIOD_S
    size = bins.bin_size(h)
    error = bins.binned(r[rows] - y[rows], size)
    return Played(float(np.sqrt(np.mean(error**2))), float(np.sum(np.abs(np.diff(u[rows]))) / (h * max(rows.sum(), 1))))


def predict(loop, low, high, noise):
    """By case, of the plants with less L, the same, more."""
    found = {}
    with tempfile.TemporaryDirectory() as name:
        for case in CASES:
            tree = case_of(loop, case, low, high)
            runs = []
            for times in PLANT:
                # The plant's friction is the loop's own, whatever the case does to the loop's.
                plant = copy.deepcopy(tree)
                plant["plant"] = plant_of(loop, times)
                runs.append(run(plant, noise, Path(name)))
            found[case] = runs
    return found


def run(tree, noise, folder):
    return judged(*trace_of(tree, noise, folder))


def trace_of(tree, noise, folder):
    """t, r, u, y of a simulated run."""
    if "arm" in tree["compensator"]:
        tree["plant"]["arm"] = tree["compensator"]["arm"]
    tree["sensor"] = {**tree.get("sensor", {}), "noise_N": noise, "noise_seed": 1}
    (folder / "case.yaml").write_text(yaml_text(tree), encoding="utf-8")
    native.run_tribo_sim("run", folder / "case.yaml", "--out", folder / "run")
    with open(folder / "run/trace.csv", encoding="ascii") as file:
        names = file.readline().strip().split(",")
    return np.loadtxt(folder / "run/trace.csv", delimiter=",", skiprows=1, usecols=[names.index(n) for n in ("t_s", "r_N", "u_N", "y_N")]).T


def level_of(loop, force):
    b, p = loop["compensator"]["friction"]["breakaway"], native.PAPER
    if b.get("table"):
        return float(np.interp(abs(force), *np.array([(q["force_N"], q["positive_N"]) for q in b["table"]]).T))
    return b.get("offset_N", p["offset_positive"]) + b.get("slope", p["slope_positive"]) * abs(force)


def residual(loop, segment):
    """Of the loop's plant over the log, which plays the log's u, over averages of 20 ms."""
    tree = copy.deepcopy(loop)
    most = 10 * float(np.max(np.abs(segment.u))) + 1.0
    tree |= {"duration_s": len(segment.u) * segment.h, "reference": {"kind": "csv", "file": "u.csv"}, "controller": {"kind": "none"},
             "limits": {"u_min_N": -most, "u_max_N": most, "input_max_N": most, "full_scale_N": 2 * most}}
    tree["plant"] = plant_of(loop)
    tree["compensator"] = {name: value for name, value in loop["compensator"].items() if name in ("arm", "friction")} | {"method": "off"}
    tree.pop("metrics", None)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.savetxt(folder / "u.csv", np.c_[np.arange(len(segment.u)) * segment.h, segment.u], delimiter=",", header="t_s,r_N", comments="", fmt="%.9g")
        y = trace_of(tree, 0.0, folder)[3]
    n = min(len(y), len(segment.force))
    late = segment.t[:n] - segment.t[0] >= PERIOD_S / 2
    error = bins.binned((segment.force[:n] - y[:n])[late], bins.bin_size(segment.h))
    return float(np.sqrt(np.mean(error**2)))


def rule(measured, predicted, left, level):
    """Lines of the verdict, and the reasons against."""
    factor = measured["off"].rms / max(measured["on"].rms, 1e-300)
    factors = [off.rms / max(on.rms, 1e-300) for off, on in zip(predicted["off"], predicted["on"])]
    low, high = (1 - ROOM) * min(factors), (1 + ROOM) * max(factors)
    lines = [f"error of r - y: off {measured['off'].rms:.4g} N, on {measured['on'].rms:.4g} N, L 20 % less {measured['less'].rms:.4g} N, more {measured['more'].rms:.4g} N",
             f"it falls by {factor:.3g}; predicted {factors[1]:.3g}, {low:.3g} to {high:.3g}",
             f"the model follows the log without compensation within {left:.2g} N rms, {100 * left / level:.2g} % of breakaway"]
    against = []
    if factor < low:
        against.append(f"the error falls by {factor:.3g} only, where {low:.3g} to {high:.3g} are predicted")
    if factor > high:
        lines.append("it falls by more than predicted")
    for case, what in (("less", "less"), ("more", "more")):
        if not measured[case].rms < measured["off"].rms:
            against.append(f"with L 20 % {what} the error is {measured[case].rms / measured['off'].rms:.3g} times that without compensation: there is no margin")
    if "old" in measured:
        lines.append(f"error with the old parameters {measured['old'].rms:.4g} N")
        if not measured["on"].rms < measured["old"].rms:
            against.append(f"the error is {measured['on'].rms / measured['old'].rms:.3g} times that with the old parameters: the new ones do not help")
    for case in CASES:
        most = VARIES * max(p.variation for p in predicted[case])
        if measured[case].variation > most:
            against.append(f"u chatters with compensation {case}: it varies by {measured[case].variation:.3g} N/s, at most {most:.3g} N/s are sound")
    if left > RESIDUAL * level:
        against.append(f"the model is off by {left:.2g} N rms without compensation, {100 * left / level:.2g} % of breakaway: the parameters are not this rig's")
    return lines, against


def _read(path, words):
    log = logs.read([path], words)
    segment = max(log.segments, key=lambda s: len(s.t))
    if segment.force is None or segment.reference is None:
        raise InputError(f"{path}: needs columns of the reference and of the force (--column r=..., --column F=...)")
    if segment.t[-1] - segment.t[0] < 2 * PERIOD_S:
        raise InputError(f"{path}: lasts {segment.t[-1] - segment.t[0]:.3g} s, the sequence {PERIOD_S * PERIODS:g} s")
    return segment


def _option(case):
    return "--old-log" if case == "old" else f"--{case}"


def command(options):
    loop = load(options.loop)
    old = load(options.old) if options.old else None
    paths = {case: getattr(options, case) for case in CASES} | ({"old": options.old_log} if old else {})
    if options.old_log and not old:
        raise InputError("--old: must be given with --old-log")
    if not any(paths.values()):
        check_range(options.low, options.high)
        files = {f"{case}.yaml": yaml_text(case_of(old if case == "old" else loop, case, options.low, options.high)).encode() for case in paths}
        write_directory(options.out, files, SEQUENCE)
        print(f"wrote {options.out}: {', '.join(files)}; play each for {PERIOD_S * PERIODS:g} s, then give the logs to accept ({', '.join(_option(case) for case in paths)})")
        return 0
    missing = [case for case, path in paths.items() if not path]
    if missing:
        raise InputError(f"{_option(missing[0])}: its log is missing: the rule needs all {len(paths)}")
    check_replaceable(options.out, VERDICT)
    segments = {case: _read(path, logs.arguments_of(options)) for case, path in paths.items()}
    measured = {case: judged(s.t, s.reference, s.u, s.force) for case, s in segments.items()}
    off = segments["off"]
    low, high = float(off.reference.min()), float(off.reference.max())
    for case, s in segments.items():
        if abs(s.reference.min() - low) > 0.02 * (high - low) or abs(s.reference.max() - high) > 0.02 * (high - low):
            raise InputError(f"{paths[case]}: its reference goes from {s.reference.min():.4g} to {s.reference.max():.4g} N, that of the first log from {low:.4g} to {high:.4g} N")
    noise = bins.noise_of(off.force)
    lines, against = rule(measured, predict(loop, low, high, noise), residual(loop, off), level_of(loop, (low + high) / 2))
    lines += [f"REJECTED: {reason}" for reason in against] or ["ACCEPTED: the new parameters"]
    if against:
        lines.append(f"the old parameters stay: {options.old}" if old else "keep the old parameters")
    print("\n".join(lines))
    files = {"report.html": report.accept_html(segments, lines).encode(),
             "verdict.json": (json.dumps({"accepted": not against, "reasons": against, "rms_N": {c: m.rms for c, m in measured.items()}}, indent=1) + "\n").encode()}
    kept = Path(options.loop) if not against else Path(options.old) if old else None
    if kept:
        files["accepted.yaml"] = kept.read_bytes()
    write_directory(options.out, files, VERDICT)
    print(f"wrote {options.out}: {', '.join(sorted(files))}")
    if against:
        raise Rejected("the new parameters are rejected")
    return 0
