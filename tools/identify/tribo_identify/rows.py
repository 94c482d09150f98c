"""Finds faults that the rows show before any fit: invalid readings, stretches that repeat, jumps, a column without its sign, held values, exchanged columns; and the
lag of F behind u at the turns."""

from dataclasses import replace

import numpy as np
import scipy.ndimage

from .bins import BIN_S, binned, noise_of, step_of
from .refusal import Refusal

SPIKE_ROWS = 2  # longest run of invalid readings
SPIKE = 0.05  # of the range of the other rows: least size of a spike
SPIKES = 0.01  # of the rows may be spikes
NOISES = 20.0  # times the median deviation: least size of a spike
STUCK_S, STUCK_ROWS = 0.05, 20  # of the same value, in a signal that otherwise changes
STUCK_JUMP = 0.01  # of the range: least jump at the end of the stretch
JUMP = {"force": 0.25, "u": 0.6}  # of the range, from a row to the next; in stiction F follows no step of u
TURN_S = 5e-3  # between the lags that are tried at the turns
TURNS_MAX_S = 0.7
TURNS_LOST = 0.01  # of the travel of F may go in the wrong direction


def _place(segment, k):
    return f"row {k + 1}, {segment.t[k]:.6g} s"


def spikes(x):
    """Marks readings that are off for a row or two, by far more than the noise and by a part of the range."""
    smooth = scipy.ndimage.median_filter(x, 2 * SPIKE_ROWS + 1)
    off = np.abs(x - smooth)
    low, high = np.percentile(smooth, [0.1, 99.9])
    return off > max(SPIKE * (high - low), NOISES * float(np.median(off)), 10 * float(np.percentile(off, 98)), 1.5 * step_of(x))  # a coarse sensor flickers by one step


def _without_spikes(segment, name):
    """Returns the signal without spikes, and what to report."""
    x = getattr(segment, name)
    at = np.flatnonzero(spikes(x))
    if not len(at) or len(at) > SPIKES * len(x):
        return x, []
    smooth = scipy.ndimage.median_filter(x, 2 * SPIKE_ROWS + 1)
    worst = at[int(np.argmax(np.abs(x - smooth)[at]))]
    mended = x.copy()
    mended[at] = smooth[at]
    letter = {"u": "u", "force": "F"}[name]
    return mended, [f"{len(at)} rows of {letter} are off for a row or two, by up to {abs(x[worst] - smooth[worst]):.3g} N ({_place(segment, worst)}: {x[worst]:.6g} N): they are replaced by the median of their neighbours"]


def runs_of(x):
    """Returns (first, length) of the runs of one value."""
    cuts = np.r_[0, np.flatnonzero(np.diff(x)) + 1, len(x)]
    return cuts[:-1], np.diff(cuts)


def stuck(segment):
    """Returns (first, end) of the stretches in which F repeats one value, although it otherwise changes from row to row, and then jumps to its current value."""
    x = segment.force
    first, length = runs_of(x)
    most = np.sort(length)[: max(int(0.999 * len(length)), 1)].max()
    least = max(STUCK_ROWS, STUCK_S / segment.h, 8 * most)
    jump = max(10 * float(np.median(np.abs(np.diff(x)))), STUCK_JUMP * np.ptp(x))
    found = [(int(a), int(a + n)) for a, n in zip(first, length) if n >= least and 0 < a and a + n < len(x)]
    return [(a, b) for a, b in found if np.ptp(segment.u[a:b]) > 0 and abs(x[b] - x[a]) > jump and x[a] not in (x.min(), x.max())]  # events.saturated reports limits


def _without_stretches(segment):
    """Returns the pieces between the stretches that repeat, and what to report."""
    found = stuck(segment)
    if not found or sum(b - a for a, b in found) > 0.2 * len(segment.t):
        return [segment], []
    a, b = found[0]
    said = [f"F stands for {b - a} rows from {segment.t[a]:.4g} s on, although it otherwise changes from row to row" + (f", and {len(found) - 1} more times" if len(found) > 1 else "") + ": these rows are left out"]
    edges = [0, *(k for pair in found for k in pair), len(segment.t)]
    pieces = [slice(a, b) for a, b in zip(edges[::2], edges[1::2]) if (b - a) * segment.h > 1.0]
    cut = lambda rows: {name: None if getattr(segment, name) is None else np.ascontiguousarray(getattr(segment, name)[rows]) for name in ("t", "u", "force", "position", "speed", "reference")}
    return [replace(segment, **cut(rows)) for rows in pieces], said


def mended(segments):
    """Returns the segments without invalid readings and without stretches that repeat, and what was done."""
    out, remarks = [], []
    for s in segments:
        for name in ("u", "force"):
            if getattr(s, name) is not None and s.force is not None and len(s.t) > 100 and not len(_jumps(s, name, "u" if name == "force" else "force")[0]):
                x, said = _without_spikes(s, name)
                s = replace(s, **{name: x})
                remarks += said
        pieces, said = _without_stretches(s) if s.force is not None and len(s.t) > 100 else ([s], [])
        out += pieces
        remarks += said
    return out, remarks


def _jumps(segment, name, other):
    """Returns the rows at which a signal jumps and stays while the other does not follow. Returns none for a held signal, which jumps all the time."""
    if held_rows(getattr(segment, name)):
        return np.zeros(0, int), np.zeros(0)
    x, y = (scipy.ndimage.median_filter(getattr(segment, which), 2 * SPIKE_ROWS + 1) for which in (name, other))
    d = np.diff(x)
    at = np.flatnonzero(np.abs(d) > max(JUMP[name] * np.ptp(x), 10 * float(np.percentile(np.abs(d), 99))))
    after = max(int(round(0.1 / segment.h)), 3)
    if len(at):  # all jumps, including those that do not last
        d = np.diff(getattr(segment, name))
        at = np.flatnonzero(np.abs(d) > 0.8 * np.median(np.abs(np.diff(x)[at])))
    alone = [k for k in at if abs(np.ptp(y[max(k - after, 0) : k + after])) / max(np.ptp(y), 1e-300) < 0.5 * abs(d[k]) / np.ptp(x)]
    return np.array(alone, int), d


def check_jumps(log):
    for s in log.segments:
        for name, other, letter in (("force", "u", "F"), ("u", "force", "u")):
            many = np.mean(spikes(getattr(s, name)))
            if many > SPIKES:
                raise Refusal("jumps", f"jumps: {letter} is off for a row or two in {100 * many:.2g} % of the rows: these readings are invalid. Check the sensor's bus and the logger, and log it again")
            at, d = _jumps(s, name, other)
            if not len(at):
                continue
            size, k = float(np.median(np.abs(d[at]))), int(at[0])
            times = f"{len(at)} times, first" if len(at) > 1 else "once,"
            same = len(at) > 1 and np.all(np.abs(np.abs(d[at]) - size) < 0.05 * size)
            raise Refusal("jumps", f"jumps: {letter} jumps by {size:.4g} N from one row to the next, {times} from row {k + 1} ({getattr(s, name)[k]:.4g} N, {s.t[k]:.6g} s) to the next "
                                   f"({getattr(s, name)[k + 1]:.4g} N), and {'u' if letter == 'F' else 'F'} does not: "
                          + ("a counter wraps there; log it with more bits, or unwrapped" if same else "its zero or its range was changed; log the experiment again without that"))


def check_sign(log):
    """Refuses a column that has lost its sign, next to one with both signs."""
    u, force = (np.concatenate([getattr(s, name) for s in log.segments]) for name in ("u", "force"))
    for x, y, one, other in ((force, u, "F", "u"), (u, force, "u", "F")):
        way = 1.0 if abs(x.max()) >= abs(x.min()) else -1.0
        x = way * x
        size = max(np.abs(y).max(), 1e-300)
        both = min(-y.min(), y.max()) > 0.15 * size
        far = 0.5 * min(-y.min(), y.max())
        if not both or x.min() < -0.02 * x.max() or not (np.any(y < -far) and np.any(y > far)):
            continue
        middle = float(np.percentile(x[np.abs(y) <= 0.3 * far], 20)) if np.any(np.abs(y) <= 0.3 * far) else x.min()
        if min(np.median(x[y < -far]), np.median(x[y > far])) > middle + 0.1 * x.max():
            raise Refusal("sign", f"sign: {other} goes from {y.min():.3g} to {y.max():.3g} N, but {one} is never {'below' if way > 0 else 'above'} 0 and grows on both sides: its sign was lost "
                                  "(an absolute value, or an unsigned number); log it with its sign")


def held_rows(x):
    """Returns the rows between changes of x, if these are regular and at least 3 rows apart. Returns 0 if they are not, or if all have one size, like steps of a resolution."""
    changes = np.diff(x)
    apart = np.diff(np.flatnonzero(changes))
    steps = np.abs(changes[changes != 0])
    rows = float(np.median(apart)) if len(apart) else 0.0
    if rows < 3 or np.percentile(steps, 90) < 1.5 * np.percentile(steps, 10):
        return 0.0
    return rows if np.mean(np.abs(apart - rows * np.round(apart / rows)) <= 1) > 0.9 else 0.0


def held_force(log):
    """Returns how long F stands between conversions, in s."""
    rows = float(np.median([held_rows(s.force) for s in log.segments]))
    return rows * log.sample_time_s


def check_held(log):
    held = held_force(log)
    if held > 1.5 * BIN_S:
        raise Refusal("held", f"held: F changes only every {held:.3g} s ({held / log.sample_time_s:.0f} rows): the sensor converts no faster, or the logger repeats its values. "
                              f"This hides breakaway: log F at least every {BIN_S:g} s")


def turn_step_s(log):
    """Returns the step between the lags that are tried at the turns, in s."""
    return max(int(round(TURN_S / log.sample_time_s)), 1) * log.sample_time_s


def _moves(segment, size):
    """Returns the changes of F from average to average beyond its noise, and those of u."""
    force, u = binned(segment.force, size), binned(segment.u, size)
    d = np.diff(force)
    return np.where(np.abs(d) > 4 * noise_of(force), d, 0.0), np.diff(u)


def exchanged(log):
    """Returns the log with u and F exchanged."""
    return replace(log, segments=[replace(s, u=s.force, force=s.u) for s in log.segments])


def turned(log):
    """Returns the log with the other sign of F."""
    return replace(log, segments=[replace(s, force=-s.force) for s in log.segments])


def lag_at_turns(log):
    """Returns the lag of F behind u in s, whatever the friction, and the share of the travel of F that then has the direction of u; the share is 1 if u drives F. F moves in
    the direction of u until u turns, then it stands. So the lag is the smallest one at which F moves in the direction of u."""
    step = turn_step_s(log)
    size = int(round(step / log.sample_time_s))
    most = int(TURNS_MAX_S / step)
    lags, total = np.arange(-most, most + 1), 0.0
    agrees = np.zeros(len(lags))
    for s in log.segments:
        if len(s.u) < 4 * size * most:
            continue
        moves, du = _moves(s, size)
        way = np.sign(scipy.ndimage.uniform_filter1d(du, 5))  # over several averages, because u may be noisy, too
        way = way[np.maximum.accumulate(np.where(way != 0, np.arange(len(way)), 0))]  # a held u keeps its direction
        total += float(np.sum(np.abs(moves[most:-most])))
        for i, lag in enumerate(lags):
            agrees[i] += float(np.sum(moves[most:-most] * way[most - lag : len(way) - most - lag]))
    if not total:
        return None, 0.0
    agrees /= total
    best = int(np.argmax(agrees >= agrees.max() - TURNS_LOST))
    return float(lags[best] * step), float(agrees.max())
