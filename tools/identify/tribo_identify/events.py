"""Break-away events: where the force begins to move, which way, and with how much net force; and what a log cannot tell."""

from dataclasses import dataclass

import numpy as np

from tribo_design.errors import DesignError

from . import native

BIN_S = 0.02  # over which signals are averaged
LONG = 0.3  # of the range of F: a sweep over so much stands for one load more
STANDS = 0.005  # of the range of u
SATURATED_ROWS = 20  # at exactly the largest or least value
WRONG_SIGN = "wrong sign: F falls where u rises (--scale u=- or --scale F=-)"


class Refusal(DesignError):
    """The log cannot tell the parameters. `cause` is one of CAUSES."""

    exit_code = 3

    def __init__(self, cause, text):
        assert cause in CAUSES, cause
        super().__init__(text)
        self.cause = cause


CAUSES = ("silent", "units", "sign", "one direction", "few loads", "saturated", "ripple", "clock", "model")


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


def binned(x, size):
    return x[: len(x) // size * size].reshape(-1, size).mean(1)


def bin_size(h):
    return max(int(round(BIN_S / h)), 1)


def find(log):
    """Events of all segments, in order, and the ways of slow slides by segment."""
    events, ways = [], []
    for number, s in enumerate(log.segments):
        way = native.slides(s.u, s.force, s.h)
        ways.append(way)
        moving = np.flatnonzero(way)
        if not len(moving):
            continue
        cuts = np.flatnonzero(np.diff(way[moving])) + 1
        size = bin_size(s.h)
        force = np.repeat(binned(s.force, size), size)
        noise = np.median(np.abs(np.diff(binned(s.force, size), 2))) / (0.6745 * np.sqrt(6)) if len(force) > 3 * size else 0.0
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


def _union(spans):
    out = []
    for low, high in sorted(spans):
        if out and low <= out[-1][1]:
            out[-1][1] = max(out[-1][1], high)
        else:
            out.append([low, high])
    return out


def loads(events):
    """Intervals of F in which it slides both ways; and how many loads they stand for: a long one is several."""
    up, down = (_union([(e.low, e.high) for e in events if e.way == w]) for w in (1, -1))
    both = [(max(a[0], b[0]), min(a[1], b[1])) for a in up for b in down if max(a[0], b[0]) < min(a[1], b[1])]
    if not both:
        return [], 0
    both = _union(both)
    span = both[-1][1] - both[0][0]
    return both, sum(int((b - a) / (LONG * span)) + 1 for a, b in both)


def saturated(segment):
    """Rows in which u or F stands at its largest or least value for long. F may rest there in stiction, but not while u goes on."""
    rows = np.zeros(len(segment.u), bool)
    for x in (segment.u, segment.force):
        for extreme, way in ((x.max(), 1), (x.min(), -1)):
            at = np.r_[0, (x == extreme).astype(np.int8), 0]
            begin, end = np.flatnonzero(np.diff(at) > 0), np.flatnonzero(np.diff(at) < 0)
            for a, b in zip(begin, end):
                goes_on = x is segment.u or np.max(way * (segment.u[a:b] - segment.u[a])) > STANDS * np.ptp(segment.u)
                if b - a >= SATURATED_ROWS and a > 0 and b < len(x) and goes_on:
                    rows[a:b] = True
    return rows


def falls_where_u_rises(log):
    """By the changes of u and F over a tenth of a second."""
    step = max(1, round(0.1 / log.sample_time_s))
    moves = np.concatenate([np.diff(np.c_[s.u, s.force][::step], axis=0) for s in log.segments])
    return np.sum(moves[:, 0] * moves[:, 1]) < -0.3 * np.sqrt(np.prod(np.sum(moves**2, axis=0)))


def check(log):
    """Refuses what shows before any fit."""
    if not 1e-6 <= log.sample_time_s <= 0.1:
        raise Refusal("clock", f"clock: an interval of {log.sample_time_s:.3g} s: the library takes 1e-6 to 0.1 s; is t in another unit (--unit t=ms)?")
    u, force = np.concatenate([s.u for s in log.segments]), np.concatenate([s.force for s in log.segments])
    span_u, span = np.ptp(u), np.ptp(force)
    size = bin_size(log.sample_time_s)
    averaged = np.concatenate([binned(s.force, size) for s in log.segments])
    noise = np.median(np.abs(np.diff(averaged, 2))) / (0.6745 * np.sqrt(6)) if len(averaged) > 2 else 0.0
    if span_u == 0:
        raise Refusal("silent", "u does not change: there is no experiment in this log")
    if np.ptp(averaged) <= max(20 * noise, 1e-6 * span_u):
        raise Refusal("silent", f"the force sensor is silent: F stays within {np.ptp(averaged):.3g} N while u changes by {span_u:.3g} N (or u never leaves stiction)")
    if span > 20 * span_u or span_u > 20 * span:
        raise Refusal("units", f"units: F changes by {span:.3g} N and u by {span_u:.3g} N: one of them is not in N (--unit u=mN, --unit F=mN)")
    total = log.segments[-1].t[-1] - log.segments[0].t[0]
    if total < 1.0:
        raise Refusal("clock", f"clock: the whole log lasts {total:.3g} s; is t in another unit (--unit t=ms)?")
    full = sum(saturated(s).sum() for s in log.segments) / log.rows
    if full > 0.02:
        if falls_where_u_rises(log):  # then u goes on where F rests in stiction, and only seems to be at a limit
            raise Refusal("sign", WRONG_SIGN)
        raise Refusal("saturated", f"saturated: u or F stands at its limit in {100 * full:.2g} % of the rows; stay within the limits of drive and sensor")


def check_events(log, events):
    """Refuses what shows in the events."""
    if not events:
        raise Refusal("silent", "F never slides slowly: nothing tells breakaway (tribo-identify plan writes an experiment that does)")
    ways = {e.way for e in events}
    if len(ways) == 1:
        raise Refusal("one direction", "one direction only: breakaway cannot be told from scale and bias of u; approach every load from both sides")
    both, count = loads(events)
    largest = max(abs(e.high) for e in events)
    if not both or both[-1][1] - both[0][0] < 0.15 * largest:
        raise Refusal("few loads", "few loads: F slides both ways over too little of its range; four loads at least, over the forces that you use")
    if count < 4:
        raise Refusal("few loads", f"few loads: F slides both ways at {count} only; four at least tell a line from a bend")
