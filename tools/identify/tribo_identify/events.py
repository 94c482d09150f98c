"""Break-away events (where the force begins to move, in which direction, with how much net force), and the refusals of logs that cannot tell friction."""

from dataclasses import dataclass

import numpy as np

from . import native, noise, rows
from .bins import BIN_S, bin_size, binned, noise_of
from .refusal import Refusal
from .slides import PART, SURE, later, runs_of, spans

LONG = 0.3  # of the range of F: a sweep this long counts as one more load
STANDS = 0.05  # of the range of u: F that stands for longer is at a limit
SATURATED_ROWS = 20  # at exactly the largest or smallest value
TOGETHER = 0.5  # least correlation of u with a noisy F that follows it
WRONG_SIGN = "wrong sign: F falls where u rises (--scale u=- or --scale F=-)"


@dataclass
class Event:
    segment: int
    start: int  # row where F begins to move
    end: int  # row after the slide's last
    way: int
    force: float  # before it moves
    low: float  # of F in the slide
    high: float
    net: float  # u - F at the start
    rate: float  # of u before it, N/s
    error: float = 0.0  # of the fitted L, in N
    weight: float = 1.0


def find(log):
    """Returns the events of all segments, in order, and the directions of slow slides by segment."""
    events, ways = [], _ways(log)
    for number, (s, way) in enumerate(zip(log.segments, ways)):
        moving = np.flatnonzero(way)
        if not len(moving):
            continue
        cuts = np.flatnonzero(np.diff(way[moving])) + 1
        size = bin_size(s.h)
        force = np.repeat(binned(s.force, size), size)
        noise = noise_of(binned(s.force, size))
        before = 0
        for run in np.split(moving, cuts):
            first, last, w = int(run[0]), int(run[-1]) + 1, int(way[run[0]])
            stand = force[before : max(first, before + 1)]
            level = float(stand.min() if w > 0 else stand.max())  # since it last moved the other way
            off = np.flatnonzero(w * (stand - level) > 6 * noise + 1e-3 * np.ptp(s.force))
            start = before + (int(off[0]) if len(off) else len(stand))
            start = min(start, len(s.u) - 1)
            back = max(start - max(int(0.2 / s.h), 2), 0)
            slide = s.force[first:last]
            events.append(Event(number, start, last, w, level, float(np.percentile(slide, 2)), float(np.percentile(slide, 98)), float(s.u[start] - level),
                                float(abs(s.u[start] - s.u[back]) / max((start - back) * s.h, s.h))))
            before = last - 1
    return events, ways


def _ways(log):
    """Returns the directions of slow slides for each row of each segment. If friction is too small for any slide to count as slow, uses the later parts of all slides,
    provided there are many: a few occur even in a log that goes one way."""
    ways = [native.slides(s.u, s.force, s.h) for s in log.segments]
    if {1, -1} <= {int(w) for way in ways for w in np.unique(way)}:
        return ways
    found, offset = later(runs_of(log), PART), 0
    if len(np.unique(found[:, 5])) < SURE:
        return ways
    for s, way in zip(log.segments, ways):
        size = bin_size(s.h)
        for of, number in found[:, [4, 6]].astype(int):
            if offset <= number < offset + len(way) // size:
                way[(number - offset) * size : (number - offset + 1) * size] = of
        offset += len(way) // size
    return ways


def _union(spans):
    out = []
    for low, high in sorted(spans):
        if out and low <= out[-1][1]:
            out[-1][1] = max(out[-1][1], high)
        else:
            out.append([low, high])
    return out


def loads(spans):
    """Returns the intervals of F in which it slides both ways, from (way, low, high) of the slides, and the number of loads they stand for: a long one counts as several."""
    up, down = (_union([span[1:] for span in spans if span[0] == w]) for w in (1, -1))
    both = [(max(a[0], b[0]), min(a[1], b[1])) for a in up for b in down if max(a[0], b[0]) < min(a[1], b[1])]
    if not both:
        return [], 0
    both = _union(both)
    span = both[-1][1] - both[0][0]
    return both, sum(int((b - a) / (LONG * span)) + 1 for a, b in both)


def _stands(x):
    """Returns (first, end, value) of the runs in which x stands still for long."""
    cuts = np.flatnonzero(np.diff(x)) + 1
    begin, end = np.r_[0, cuts], np.r_[cuts, len(x)]
    return [(a, b, x[a]) for a, b in zip(begin, end) if b - a >= SATURATED_ROWS]


def _a_step_of(x, u):
    """Returns the median distance that u travels while x stands at a level that it reaches from one side and leaves on the other, or 0 if x does not stand. For a sensor
    that reads in coarse steps this is one step, whatever filter or scale is behind it."""
    cuts = np.flatnonzero(np.diff(x)) + 1
    ways = np.sign(np.diff(x)[cuts - 1])
    passed = np.flatnonzero(ways[:-1] == ways[1:])
    far = [np.max(w * (u[a:b] - u[a])) for a, b, w in zip(cuts[passed], cuts[passed + 1], ways[passed]) if b - a > 2]
    return float(np.median(far)) if far else 0.0


def saturated(segment, name=None):
    """Marks the rows in which u and F, or the signal `name`, stand at their largest or smallest value for long. If u stands at other levels as well, it is held and not at a
    limit. F may rest at its extreme in stiction, but only until u has gone beyond the point at which F arrived there by more than `room`, which includes two sensor steps."""
    rows, u = np.zeros(len(segment.u), bool), segment.u
    for x in (u, segment.force) if name is None else (getattr(segment, name),):
        still = _stands(x)
        held = x is u and len({v for *_, v in still} - {x.min(), x.max()}) >= 2
        room = 0.0 if x is u else STANDS * np.ptp(u) + 2 * _a_step_of(x, u)
        for extreme, way in ((x.max(), 1), (x.min(), -1)):
            came = way * u[int(np.argmax(x == extreme))]
            for a, b, value in still:
                if value != extreme:
                    continue
                came = max(came, way * u[a])  # F may have reached it earlier by an overshoot
                rows[a:b] |= not held and (x is u or np.max(way * u[a:b]) - came > room) and a > 0 and b < len(x)
    return rows


def held_s(log):
    """Returns how long u stands between regular changes, in s; 0 if they are not regular."""
    return float(np.median([rows.held_rows(s.u) for s in log.segments])) * log.sample_time_s


def not_of_one_clock(log, lag_s, also=""):
    """Returns the refusal of an F that comes before u, or far behind it."""
    held = held_s(log)
    if lag_s < 0 < held:
        return Refusal("held", f"held: u changes only every {held:.3g} s, and F comes {-lag_s:.3g} s before it: log u, the command that the drive receives, as often as F")
    if lag_s < 0:
        return Refusal("clock", f"clock: F comes {lag_s:.3g} s after u, before it was commanded; " + (also or "the time stamps of u and F come from different clocks"))
    return Refusal("clock", f"clock: F comes {lag_s:.3g} s after u; " + (also or "F passes a slow filter, or the time stamps of u and F come from different clocks"))


def falls_where_u_rises(log):
    """Returns whether F falls where u rises, from their changes over a tenth of a second."""
    step = max(1, round(0.1 / log.sample_time_s))
    moves = np.concatenate([np.diff(np.c_[s.u, s.force][::step], axis=0) for s in log.segments])
    return np.sum(moves[:, 0] * moves[:, 1]) < -0.3 * np.sqrt(np.prod(np.sum(moves**2, axis=0)))


INTERVALS = (1e-6, 0.1)  # s, that the library accepts
TOTAL_S = 1.0  # least length of a log
FORCES_N = (1e-6, 1e6)  # by which u and F may change in all; the library takes no others
UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0}
LONGER = {"--unit t=min": 60.0, "--scale t=3600": 3600.0, "--scale t=86400": 86400.0}


def _fits(interval, total):
    """Returns whether an experiment can have this sample time and this length."""
    return 1e-5 <= interval <= 0.05 and 5.0 <= total <= 2e4


def interval_and_length(log):
    return log.sample_time_s, log.segments[-1].t[-1] - log.segments[0].t[0]


def other_unit(log):
    """Returns the refusal that names the unit of the stamps in which the log would be an experiment. Returns None if the log already is one, or is one in no unit."""
    h, total = interval_and_length(log)
    said = f"clock: a row each {h:.3g} s, {total:.3g} s in all"
    now = UNITS.get(log.time_unit, 1.0)
    if _fits(h, total):
        return None
    if log.time_unit not in (None, "s") and _fits(h / now, total / now):
        return Refusal("clock", f"{said}: its stamps are not in {log.time_unit} but in s: leave --unit t={log.time_unit} out")
    for name, times in UNITS.items():
        if name not in ("s", "min") and _fits(h / now * times, total / now * times):
            return Refusal("clock", f"{said}: its stamps are in {name}: --unit t={name}")
    for words, times in LONGER.items():
        if log.time_unit is None and _fits(h * times, total * times):
            return Refusal("clock", f"{said}: its stamps are in another unit, probably {words}")
    return None


def check_clock(log):
    """Refuses a log whose stamps are in another unit, and names the unit in which it would be an experiment."""
    h, total = interval_and_length(log)
    if INTERVALS[0] <= h <= INTERVALS[1] and total >= TOTAL_S:
        return
    if refusal := other_unit(log):
        raise refusal
    said = f"clock: a row each {h:.3g} s, {total:.3g} s in all"
    if total < TOTAL_S:
        raise Refusal("clock", f"{said}: this is too short for an experiment, which takes a minute (tribo-identify plan)")
    raise Refusal("clock", f"{said}: the interval between rows must be {INTERVALS[0]:g} to {INTERVALS[1]:g} s; log " + ("more often" if h > INTERVALS[1] else "less often, or resample it (--resample=0.001)"))


def check_limits(log):
    """Refuses a log in which u or F stands at its limit."""
    full = {name: sum(saturated(s, name).sum() for s in log.segments) / log.rows for name in ("u", "force")}
    if sum(full.values()) <= 0.02:
        return
    if falls_where_u_rises(log):  # F rests in stiction while u goes on, and only seems to be at a limit
        raise Refusal("sign", WRONG_SIGN)
    name = max(full, key=full.get)
    x = np.concatenate([getattr(s, name) for s in log.segments])
    at = x.max() if np.mean(x == x.max()) >= np.mean(x == x.min()) else x.min()
    what = "the drive or the logger saturates there" if name == "u" else "the sensor or the logger saturates there"
    raise Refusal("saturated", f"saturated: {'u' if name == 'u' else 'F'} stands at {at:.4g} N in {100 * full[name]:.2g} % of the rows: {what}. Stay within this limit")


def _go_together(log, size):
    """Returns whether F follows u overall."""
    u, force = (np.concatenate([binned(getattr(s, name), size) for s in log.segments]) for name in ("u", "force"))
    return len(u) > 50 and np.ptp(u) > 0 and np.ptp(force) > 0 and np.corrcoef(u, force)[0, 1] > TOGETHER


def check(log):
    """Refuses faults that show before any fit."""
    check_clock(log)
    u, force = np.concatenate([s.u for s in log.segments]), np.concatenate([s.force for s in log.segments])
    span_u, span = np.ptp(u), np.ptp(force)
    size = bin_size(log.sample_time_s)
    averaged = np.concatenate([binned(s.force, size) for s in log.segments])
    if span_u == 0:
        raise Refusal("silent", f"u does not change; it is {u[0]:.4g} N throughout: this log has no experiment, or u is in another column")
    if span == 0:
        raise Refusal("silent", f"the force sensor is silent: F is {force[0]:.4g} N throughout")
    for name, changes in (("u", span_u), ("F", span)):
        if not FORCES_N[0] <= changes <= FORCES_N[1]:
            raise Refusal("units", f"units: {name} changes by {changes:.3g} N in all; {FORCES_N[0]:g} to {FORCES_N[1]:g} N are expected: name its unit (--unit {name}=mN) or a factor (--scale {name}=X)")
    if np.max(np.abs(u - force)) < 1e-5 * span:
        raise Refusal("silent", "F is u, row for row: it is the same column; name the column of the measured force (--column F=...)")
    rows.check_jumps(log)
    if np.ptp(averaged) <= max(20 * noise_of(averaged), 1e-6 * span_u):
        if _go_together(log, size):
            raise Refusal("noise", f"noise: F has noise of {noise_of(averaged):.3g} N rms in averages over {1e3 * BIN_S:g} ms, and changes by {np.ptp(averaged):.3g} N in all: it hides the friction. {noise.QUIETER}")
        raise Refusal("silent", f"the force sensor is silent: F stays within {np.ptp(averaged):.3g} N while u changes by {span_u:.3g} N (or u never leaves stiction)")
    rows.check_sign(log)
    rows.check_held(log)
    check_limits(log)
    if span > 20 * span_u or span_u > 20 * span:
        times = span / span_u
        milli = "--unit F=mN" if 200 < times < 5000 else "--unit u=mN" if 200 < 1 / times < 5000 else None
        raise Refusal("units", f"units: F changes by {span:.3g} N and u by {span_u:.3g} N: one of them is not in N (" + (f"{milli}, or " if milli else "") + f"a factor: --scale u={times:.2g} makes their ranges equal)")


def check_events(log, events):
    """Refuses faults that show in the events."""
    if not events:
        raise Refusal("silent", "F never slides slowly, so the log does not show breakaway (tribo-identify plan writes an experiment that does)")
    found = spans(log)
    if len({e.way for e in events} | {way for way, *_ in found}) == 1:
        raise Refusal("one direction", "one direction only: breakaway cannot be told from scale and bias of u; approach every load from both sides")
    both, count = loads(found)
    largest = max(abs(high) for *_, high in found) if found else 0.0
    if not both or both[-1][1] - both[0][0] < 0.15 * largest:
        raise Refusal("few loads", "few loads: F slides both ways over too little of its range; at least four loads over the forces that you use are needed")
    if count < 4:
        raise Refusal("few loads", f"few loads: F slides both ways at only {count} load{'s' * (count != 1)}; at least four are needed to tell a line from a bend")
