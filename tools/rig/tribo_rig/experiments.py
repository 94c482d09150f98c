"""The experiments: u to play, one row per tick, never beyond the safe forces.

Friction only takes from u: at rest |F| is at most |u| (scale and bias apart). The first ramp does not know the scale yet, so it goes only to
half of the safe forces. Later experiments know it, and keep both F and the command within the safe forces.
"""

from dataclasses import dataclass, replace

import numpy as np

from tribo_design.errors import DesignError, InputError
from tribo_identify import friction, noise, stiction
from tribo_identify.events import Refusal
from tribo_identify.plan import Plan

RAMP = 0.5  # of the safe forces: safe where a newton of command makes up to two
RAMP_PARTS = (0.3, 0.6, 1.0)  # of that, one after the other
RAMP_S = 5.0  # for the largest part, one way
REST_S = 1.0
STEP_PART = 0.2  # of the range: two steps in a row and all of their overshoot stay within it
STEPS = 3  # of two up and two down
FAR = 0.02  # of its range: u has begun
APPROACH_S = 1.0  # until F slides, before they begin


@dataclass
class Experiment:
    name: str
    time: np.ndarray
    u: np.ndarray  # N, as commanded
    split_s: float = 0.0  # where the steps end and the slides begin

    def csv(self, command_per_N):
        rows = "".join(f"{t:.7g},{u:.7g}\n" for t, u in zip(self.time, self.u * command_per_N))
        return f"t_s,u\n{rows}"


def _sampled(name, corners, h, split_s=0.0):
    corners = np.array(corners)
    time = np.arange(int(np.ceil(corners[-1, 0] / h)) + 1) * h
    return Experiment(name, time, np.interp(time, corners[:, 0], corners[:, 1]), split_s)


def ramp(rig):
    """Ramps up and down, further each time; with a negative safe force also to that side."""
    corners = [(0.0, 0.0), (REST_S, 0.0)]
    for part in RAMP_PARTS:
        for end in (rig.force.high_N, rig.force.low_N) if rig.force.low_N < 0 else (rig.force.high_N,):
            last = corners[-1][0]
            corners += [(last + part * RAMP_S, RAMP * part * end), (last + 2 * part * RAMP_S, 0.0)]
    return _sampled("1-ramp", [*corners, (corners[-1][0] + REST_S, 0.0)], rig.sample_time_s)


def steps(plan, hold_s):
    """Corners of u in which F never stops between two steps of one way, so that they show the lags alone."""
    bottom, top = plan.range()
    span = top - bottom
    corners = [(0.0, 0.0), (REST_S, 0.0)]

    def go(force, way, seconds):
        corners.append((corners[-1][0] + seconds, force + way * plan.breakaway(force)))

    for number in range(STEPS):
        shift = 0.05 * span * number
        for way, levels in ((1, (0.2, 0.2 + STEP_PART, 0.2 + 2 * STEP_PART)), (-1, (0.55, 0.55 - STEP_PART, 0.55 - 2 * STEP_PART))):
            go(bottom + levels[0] * span + way * shift, way, APPROACH_S)
            for level in levels[1:]:
                corners.append((corners[-1][0] + hold_s / 2, corners[-1][1]))
                go(bottom + level * span + way * shift, way, 0.0)
            corners.append((corners[-1][0] + hold_s, corners[-1][1]))
    return [*corners, (corners[-1][0] + 2 * APPROACH_S, 0.0), (corners[-1][0] + 2 * APPROACH_S + REST_S, 0.0)]


def slides(rig, first):
    """Steps, then the plan of tribo-identify, in newton of F; then by scale and bias of the ramp as commands."""
    low, high = (sorted((force, first.scale * force + first.bias))[place] for force, place in ((rig.force.low_N, 1), (rig.force.high_N, 0)))
    try:
        plan = Plan(low, high, offset=max(first.offset, 1e-3 * rig.force.largest), slope=float(np.clip(first.slope, 0, 0.9)), noise=first.noise,
                    sample_time_s=rig.sample_time_s, rate=rig.force.largest).check()
    except InputError as error:
        raise Refusal("few loads", f"1-ramp-log.csv: {str(error).replace('--low', 'force.low_N').replace('--high', 'force.high_N').replace('--noise: value', 'noise of F, in N:')}") from None
    corners = steps(plan, max(0.5, 250 * rig.sample_time_s))
    split = corners[-1][0]
    corners += [(split + t, u) for t, u in plan.commands()[1:]]
    corners = [(t, (u - first.bias * min(t, REST_S) / REST_S) / first.scale) for t, u in corners]
    made = _sampled("2-slides", [*corners, (corners[-1][0] + 1.0, 0.0)], rig.sample_time_s, split)
    made.u = np.clip(made.u, rig.force.low_N, rig.force.high_N)
    return made


def _times(u, made):
    """The factor of u over the commands of the file, if it is one factor."""
    times = float(u @ made / (made @ made))
    return times if abs(times) > 1e-9 and np.percentile(np.abs(u - times * made), 95) <= 0.05 * abs(times) * np.ptp(made) else None


def aligned(log, made, path):
    """The log as one piece from the beginning to the end of the experiment. Raises a refusal for a log of something else."""
    if len(log.segments) != 1:
        stands = [remark for remark in log.remarks if "F stands for" in remark]
        raise InputError(f"{path}: " + (f"{stands[0].split(':')[0]}: play {made.name}.csv again" if stands else f"has {len(log.segments)} pieces; one record without gaps is needed (log.resample bridges small gaps)"))
    s = log.segments[0]
    if s.force is None:
        raise InputError(f"{path}: there is no force: name its column in rig.yaml (log.columns.F)")
    h = made.time[1] - made.time[0]
    if abs(s.h / h - 1) > 0.01:
        raise InputError(f"{path}: a row every {s.h:.6g} s, but sample_time_s is {h:g} s; record at the tick of the loop, or correct log.units.t")
    if not np.ptp(s.u) > 1e-9 * np.ptp(made.u):
        raise InputError(f"{path}: u does not move: it must be the command as played (log.columns.u)")
    # Both begin where u begins, whatever the unit.
    shift = int(np.flatnonzero(np.abs(s.u - s.u[0]) > FAR * np.ptp(s.u))[0]) - int(np.flatnonzero(np.abs(made.u - made.u[0]) > FAR * np.ptp(made.u))[0])
    rows = np.arange(len(made.u)) + shift
    inside = (rows >= 0) & (rows < len(s.u))
    if inside.sum() < 0.9 * len(rows):
        raise InputError(f"{path}: lasts {len(s.u) * h:.4g} s; {made.name}.csv lasts {len(rows) * h:.4g} s: record all of it")
    off = np.abs(s.u[rows[inside]] - made.u[inside])
    if np.percentile(off, 95) > 0.05 * np.ptp(made.u):
        times = _times(s.u[rows[inside]], made.u[inside])
        if times is not None:
            raise InputError(f"{path}: u is {times:.4g} times that of {made.name}.csv in all rows: it is logged in another unit, e.g. ampere, or command_per_N is not what was played. "
                             f"Log the command as {made.name}.csv has it, or set log.scales: {{u: {1 / times:.6g}}} if the drive got the commands of the file")
        at = made.time[inside][int(np.argmax(off > 0.05 * np.ptp(made.u)))]
        raise InputError(f"{path}: u differs from {made.name}.csv, first at {at:.4g} s: the log is of another experiment, u is another column (log.columns.u), or command_per_N differs")
    return part(log, shift * h, shift * h + made.time[-1])


def part(log, begin_s, end_s):
    """The log's only segment, cut between two of its times."""
    s = log.segments[0]
    rows = slice(max(int(round(begin_s / s.h)), 0), min(int(round(end_s / s.h)) + 1, len(s.u)))
    piece = replace(s, t=s.t[rows] - s.t[rows][0], u=np.ascontiguousarray(s.u[rows]), force=np.ascontiguousarray(s.force[rows]), position=None, speed=None, reference=None)
    return replace(log, segments=[piece])


@dataclass
class First:
    """Results of the ramp: F = scale u + bias - friction."""

    scale: float
    bias: float
    offset: float
    slope: float
    readings: object  # of the force, tribo_identify.bins.Readings

    @property
    def noise(self):
        """Noise and steps together, rms in N: the residual of the best model."""
        return self.readings.rms

    def of(self, assume):
        """Command and friction under `assume` of tribo_identify, in the names of lags.Fit."""
        symmetric = {"scale": self.scale, "gravity": self.bias, "offset": self.offset, "slope": self.slope}
        if assume == "symmetric":
            return symmetric | {"offset_negative": self.offset, "slope_negative": self.slope}
        return {"scale": 1.0, "gravity": 0.0} | {name.removesuffix("_positive"): value for name, value in friction.calibrated(symmetric).items()}


def _friction(log, line, started, rms):
    """Offset and slope, as `started` gives them if these lags leave any friction; raises a refusal if there is none."""
    law, load = line.law(), float(np.median(np.abs(log.segments[0].force)))
    seen = stiction.behind(log, law["scale"], law["gravity"], law["offset"], law["slope"])
    if not seen.force > 0:
        raise DesignError("1-ramp-log.csv: friction would push in the direction of F: u and F are not of the same time, or one of them is filtered too much")
    if not seen.is_lag() and friction.MATTERS * np.max(np.abs(log.segments[0].force)) < seen.friction() < 2 * rms:
        raise Refusal("noise", f"1-ramp-log.csv: F has noise of {rms:.3g} N rms, and friction of {seen.friction():.2g} N, as far as it can be seen, does not stand out from it. {noise.QUIETER}")
    if seen.is_lag() or seen.friction() < 2 * rms:
        raise Refusal("no stiction", f"1-ramp-log.csv: no stiction found: {seen.text()}. There is nothing to compensate")
    return started if started[0] + started[1] * load > 0 else (law["offset"] - seen.force + seen.friction(), law["slope"])


def of_ramp(log, assume="symmetric"):
    """Fits by linear least squares over the slides, as the fit of tribo-identify starts."""
    from tribo_identify import bins, events, native, slides

    events.check(log)
    line = slides.line(log, "symmetric") if len({way for way, *_ in slides.spans(log)}) == 2 else None
    if line is None:
        s = log.segments[0]
        raise Refusal("one direction", f"1-ramp-log.csv: F does not follow u up and down: it goes from {s.force.min():.3g} to {s.force.max():.3g} N, u from {s.u.min():.3g} to {s.u.max():.3g} N. "
                                       "The arm may be stuck, or out of contact, or F is another column (log.columns.F): check rig and log before you play anything more")
    (scale, bias, offset, slope), _ = friction.start(log, native.PAPER, events.find(log)[1])
    s = log.segments[0]
    if scale < 0:
        raise Refusal("sign", "1-ramp-log.csv: F falls where u rises: change the sign of command_per_N, or of F by log.scales.F: -1")
    if not 0.5 <= scale <= 2:
        raise Refusal("units", f"1-ramp-log.csv: a newton of command makes {scale:.3g} N: correct command_per_N (to {1 / scale:.3g} times its value), remove the log and play the ramp again")
    readings = bins.readings_of(s.force)
    offset, slope = _friction(log, line, (offset, slope), readings.rms)
    first = First(float(scale), float(bias), float(max(offset, 0.0)), float(max(slope, 0.0)), readings)
    law, load = first.of(assume), float(np.max(np.abs(s.force)))
    L = [law[f"offset{way}"] + law[f"slope{way}"] * load for way in ("", "_negative")]
    if not min(L) > 0:
        raise Refusal("units", f"1-ramp-log.csv: L+ would be {L[0]:.3g} N and L- {L[1]:.3g} N at {load:.3g} N if command_per_N were right, as known.command says: one of them would push. "
                               f"Remove known.command; where friction is the same both ways, a newton of command makes {scale:.3g} N")
    return first
