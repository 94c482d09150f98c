"""tribo-identify accept: decides by a fixed, short sequence and a rule whether the new parameters are better on the rig.

Without logs it writes the sequence: four loops that follow a triangle of force, with compensation off, on, and with L 20 % less and 20 % more;
with --old also a fifth, the old loop. With the logs of these loops it judges. The new parameters are accepted if

- the error falls by the factor that a simulation with these parameters predicts, within its interval. The interval comes from simulations with
  L 10 % less and more in the plant and from the residual of the model in the log without compensation, plus a tenth on both sides (a larger
  factor is welcome);
- with L 20 % less and more the error is smaller than without compensation;
- u does not chatter: in each of the four loops it varies at most twice as much as predicted with the sensor's noise and steps in the log;
- the model follows the log without compensation within 10 % of breakaway;
- the error is smaller than with the old parameters, if these are given.

Otherwise the old parameters stay, and the report says why.
"""

import copy
import json
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import tribo
from tribo_design import progress
from tribo_design.errors import DesignError, InputError
from tribo_design.output import check_replaceable, write_directory, yaml_text
from tribo_design.reading import read_scenario

from . import bins, logs, native, report

CASES = {"off": None, "on": 1.0, "less": 0.8, "more": 1.2}
PERIOD_S, PERIODS = 10.0, 3
PLANT = (0.9, 1.0, 1.1)  # L of the simulated plant divided by the loop's
ROOM = 0.1  # added to both sides of the interval
WORST = 2.0  # times the unexplained error, in phase with the predicted one
UNIT_S = 0.2
FOLLOWS = 0.98
SAME_UNIT = 0.02
VARIES = 2.0
RESIDUAL = 0.1
FREE_N = 1e-6  # breakaway of an arm without friction
SEQUENCE = (*(f"{case}.yaml" for case in CASES), "old.yaml")
VERDICT = ("report.html", "verdict.json", "accepted.y*ml")


class Rejected(DesignError):
    """The new parameters are rejected; the old ones stay."""

    exit_code = 4


@dataclass
class Played:
    rms: float  # of r - y, over averages of 20 ms, without the first period
    variation: float  # of u per second, over the same rows


def load(path):
    tree = read_scenario(path)
    if not ((tree.get("compensator") or {}).get("friction") or {}).get("breakaway"):
        raise InputError(f"{path}: compensator.friction.breakaway: is missing; tribo-identify friction --scenario writes a loop that has it")
    return tree


def scaled(friction, times):
    """Returns the friction with L multiplied by `times`."""
    friction = copy.deepcopy(friction)
    breakaway = friction["breakaway"]
    for key in ("offset_N", "slope", "negative_offset_N", "negative_slope"):
        if key in breakaway:
            breakaway[key] = float(breakaway[key]) * times
    for point in breakaway.get("table", []):
        for key in ("positive_N", "negative_N"):
            point[key] = float(point[key]) * times
    return friction


def plant_of(loop, times=1.0):
    """Returns the loop's plant, whose sliding friction is the loop's multiplied by `times`. If friction falls once it slides, the plant's breakaway is larger."""
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


def predict(loop, low, high, readings):
    """Returns for each case the runs on the plants with less L, the same L and more L."""
    found = {}
    with tempfile.TemporaryDirectory() as name:
        for case in CASES:
            tree = case_of(loop, case, low, high)
            runs = []
            for times in PLANT:
                progress.at(f"simulates the loop with compensation {case} on a plant with {times:g} times the loop's breakaway")
                # The plant keeps the loop's original friction, whatever the case changes in the loop.
                plant = copy.deepcopy(tree)
                plant["plant"] = plant_of(loop, times)
                runs.append(run(plant, readings, Path(name)))
            found[case] = runs
    return found


def run(tree, readings, folder):
    return judged(*trace_of(tree, readings, folder))


def trace_of(tree, readings, folder):
    """Returns t, r, u and y of a simulated run."""
    if "arm" in tree["compensator"]:
        tree["plant"]["arm"] = tree["compensator"]["arm"]
    tree["sensor"] = {**tree.get("sensor", {}), "noise_N": readings.noise, "quantisation_N": readings.step, "noise_seed": 1}
    (folder / "case.yaml").write_text(yaml_text(tree), encoding="utf-8")
    try:
        played = tribo.run(folder / "case.yaml")
    except tribo.ScenarioError as error:
        raise InputError(str(error)) from None
    return tuple(np.array(played[name]) for name in ("t_s", "r_N", "u_N", "y_N"))


def level_of(loop, force):
    b, p = loop["compensator"]["friction"]["breakaway"], native.PAPER
    if b.get("table"):
        return float(np.interp(abs(force), *np.array([(q["force_N"], q["positive_N"]) for q in b["table"]]).T))
    return b.get("offset_N", p["offset_positive"]) + b.get("slope", p["slope_positive"]) * abs(force)


def _by_rows(loop, rows, h, plant, limit):
    """Returns the loop's scenario on another plant, without compensation, with `rows` as the reference, each for h seconds."""
    tree = copy.deepcopy(loop)
    tree |= {"duration_s": len(rows) * h, "reference": {"kind": "csv", "file": "rows.csv"}, "plant": plant,
             "limits": {"u_min_N": -limit, "u_max_N": limit, "input_max_N": limit, "full_scale_N": 2 * limit}}
    tree["compensator"] = {name: value for name, value in loop["compensator"].items() if name in ("arm", "friction")} | {"method": "off"}
    tree.pop("metrics", None)
    return tree


def _played(tree, rows, h):
    """Returns t, r, u and y of the simulation without noise."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.savetxt(folder / "rows.csv", np.c_[np.arange(len(rows)) * h, rows], delimiter=",", header="t_s,r_N", comments="", fmt="%.9g")
        return trace_of(tree, bins.Readings(0.0, 0.0), folder)


def residual(loop, segment):
    """Returns the residual of the loop's plant, which plays the log's u, in averages of 20 ms."""
    tree = _by_rows(loop, segment.u, segment.h, plant_of(loop), 10 * float(np.max(np.abs(segment.u))) + 1.0)
    y = _played(tree | {"controller": {"kind": "none"}}, segment.u, segment.h)[3]
    n = min(len(y), len(segment.force))
    late = segment.t[:n] - segment.t[0] >= PERIOD_S / 2
    return bins.binned((segment.force[:n] - y[:n])[late], bins.bin_size(segment.h))


def echo(loop, left, h):
    """Returns how much of a disturbance of F the loop leaves in r - F, rms in N. The disturbance is played as a reference on the same plant without friction,
    because the loop treats both alike."""
    if not np.any(left):
        return 0.0
    free = {key: value for key, value in (loop.get("plant") or {}).items() if key in ("step_s", "actuator_pole_rad_per_s", "arm")}
    free["friction"] = {"breakaway": {"offset_N": FREE_N, "slope": 0.0}}
    t, r, _, y = _played(_by_rows(loop, left, h, free, 1e3 * float(np.max(np.abs(left))) + 1.0), left, h)
    error = bins.binned(r - y, bins.bin_size(float(np.median(np.diff(t)))))
    return float(np.sqrt(np.mean(error**2)))


@dataclass
class Expected:
    """The simulated effect of compensation: rms of r - y in N without and with it, and the factor by which the error falls (likely, least, most)."""

    off: float
    on: float
    factors: tuple


def expected(predicted, left):
    """Returns the expected effect. `left` is the part of r - y that no law explains, rms in N. It may add to the predicted error, up to WORST times its rms, or the
    predicted error may be too large by it."""
    off, on = ([run.rms for run in predicted[case]] for case in ("off", "on"))
    likely = Expected(float(np.hypot(off[1], left)), float(np.hypot(on[1], left)), ())
    least = min(a / (b + WORST * left) for a, b in zip(off, on))
    most = max((a + left) / max(b - left, b / WORST, 1e-300) for a, b in zip(off, on))
    likely.factors = (likely.off / max(likely.on, 1e-300), (1 - ROOM) * least, (1 + ROOM) * most)
    return likely


def rule(measured, predicted, left, level, echo):
    """Returns the lines of the verdict and the reasons against. `left` is the model's residual in the log without compensation, `echo` its effect in the loop, both
    rms in N."""
    factor = measured["off"].rms / max(measured["on"].rms, 1e-300)
    likely, low, high = expected(predicted, echo).factors
    lines = [f"error of r - y: off {measured['off'].rms:.4g} N, on {measured['on'].rms:.4g} N, L 20 % less {measured['less'].rms:.4g} N, more {measured['more'].rms:.4g} N",
             f"the error is divided by {factor:.3g}; predicted {likely:.3g}, {low:.3g} to {high:.3g}",
             f"the model follows the log without compensation within {left:.2g} N rms, {100 * left / level:.2g} % of breakaway"]
    against = []
    if not factor > 1:
        against.append(f"compensation does not help: the error is {1 / factor:.3g} times that without it")
    elif factor < low:
        against.append(f"the error is divided by only {factor:.3g}; {low:.3g} to {high:.3g} were predicted")
    if factor > high:
        lines.append("the error falls by more than predicted")
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
            against.append(f"u chatters with compensation {case}: it varies by {measured[case].variation:.3g} N/s; at most {most:.3g} N/s are allowed")
    if left > RESIDUAL * level:
        against.append(f"the model is off by {left:.2g} N rms without compensation, {100 * left / level:.2g} % of breakaway: the parameters are not this rig's")
    return lines, against


def unit_of(loop, segment):
    """Returns the log's u per newton of the loop's u, and the correlation of the log's u with the u that the loop's controller computes from the log's r and F."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "off.yaml"
        path.write_text(yaml_text(case_of(loop, "off", float(segment.reference.min()), float(segment.reference.max()))), encoding="utf-8")
        controller = tribo.Loop(path)
    ticks = np.arange(segment.t[0], segment.t[-1], controller.sample_time_s)
    made = controller.steps(*(np.interp(ticks, segment.t, x) for x in (segment.reference, segment.force)))
    size = max(int(round(UNIT_S / controller.sample_time_s)), 1)
    made, given = (np.diff(bins.binned(x, size)) for x in (made, np.interp(ticks, segment.t, segment.u)))
    both = float(made @ given)
    return both / max(float(made @ made), 1e-300), both / max(float(made @ made) ** 0.5 * float(given @ given) ** 0.5, 1e-300)


def in_newton(loop, segments):
    """Returns the segments with u in the loop's newtons, and lines to print: a drive may log the command in its own unit."""
    unit, follows = unit_of(loop, segments["off"])
    if abs(follows) < FOLLOWS:
        return segments, [f"note: u in the log without compensation differs from the u that this loop computes from r and F (correlation {follows:.2g}): check that u is the command (--column u=...) and that this loop ran in the drive"]
    if abs(unit - 1) <= SAME_UNIT:
        return segments, []
    return {case: replace(s, u=s.u / unit) for case, s in segments.items()}, [f"u: the log has {unit:.4g} of the drive's units per newton of the loop's u, and is converted"]


def judge(loop, segments, readings, predicted):
    """Returns (measured by case, lines of the verdict, reasons against) for the logs of a sequence."""
    segments, said = in_newton(loop, segments)
    measured = {case: judged(s.t, s.reference, s.u, s.force) for case, s in segments.items()}
    off = segments["off"]
    progress.at("simulates the log without compensation on the loop's plant")
    left, size = residual(loop, off), bins.bin_size(off.h)
    middle = (float(off.reference.min()) + float(off.reference.max())) / 2
    lines, against = rule(measured, predicted, float(np.sqrt(np.mean(left**2))), level_of(loop, middle), echo(loop, bins.beyond(left, readings, size), size * off.h))
    return measured, said + lines, against


def _read(path, words):
    progress.at(f"reads {path}")
    log = logs.read([path], words)
    segment = max(log.segments, key=lambda s: len(s.t))
    if segment.force is None or segment.reference is None:
        raise InputError(f"{path}: needs columns of the reference and of the force (--column r=..., --column F=...)")
    if segment.t[-1] - segment.t[0] < 2 * PERIOD_S:
        raise InputError(f"{path}: lasts {segment.t[-1] - segment.t[0]:.3g} s, but the sequence takes {PERIOD_S * PERIODS:g} s; at least {2 * PERIOD_S:g} s are needed")
    return segment


def _option(case):
    return "--old-log" if case == "old" else f"--{case}"


def _check_options(options):
    """Refuses options of the other step: without logs it writes a sequence, with logs it judges."""
    has_logs = any(getattr(options, case) for case in CASES) or options.old_log
    for name in ("low", "high") if has_logs else ("column", "unit", "scale", "bias", "resample", "gap"):
        if getattr(options, name) not in (None, []):
            raise InputError(f"--{name}: " + ("the logs have the range of the sequence" if has_logs else "is how logs are read, and none is given"))


def command(options):
    _check_options(options)
    loop = load(options.loop)
    old = load(options.old) if options.old else None
    paths = {case: getattr(options, case) for case in CASES} | ({"old": options.old_log} if old else {})
    if options.old_log and not old:
        raise InputError("--old: must be given with --old-log")
    has_logs = any(paths.values())
    if not has_logs:
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
    off = segments["off"].reference
    low, high = float(off.min()), float(off.max())
    for case, s in segments.items():
        if abs(s.reference.min() - low) > 0.02 * (high - low) or abs(s.reference.max() - high) > 0.02 * (high - low):
            raise InputError(f"{paths[case]}: its reference goes from {s.reference.min():.4g} to {s.reference.max():.4g} N, but that of the first log from {low:.4g} to {high:.4g} N")
    readings = bins.readings_of(segments["off"].force)
    measured, lines, against = judge(loop, segments, readings, predict(loop, low, high, readings))
    lines += [f"REJECTED: {reason}" for reason in against] or ["ACCEPTED: use the new parameters"]
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
