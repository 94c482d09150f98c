"""A joint's friction from logs of effort u and position q, whatever loop moved it.

    u = J a + load(q) + side (friction + slope |J a + load(q)| + viscous |v|)

while the joint slides: inertia and load, a polynomial of q, belong to a log, friction to the joint. Rows within half a window of a stop are left out, because
sticking friction is unknown there. The effort that starts a joint is read where it has rested and u grew slowly. Intervals are 95 %, from the differences between
strokes (sandwich with a stroke as a cluster) and from how the estimate changes with the window and with the rows left out.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.ndimage import minimum_filter1d
from scipy.signal import savgol_filter
from scipy.stats import t as student

from tribo_identify.refusal import Refusal

TRAVELS_MIN = 16  # of a stroke that counts
STROKES_MIN = 3  # each way
STARTS_MIN = 8  # slow ones
POWERS = 4  # of q, of the load
WINDOW_PART = 0.1  # of a stroke's time, of the window that speed is taken in
WINDOW_MIN = 7  # ticks
SLOW = 0.1  # of the largest speed: slower rows are left out
REST_S = 0.08  # of a rest from which the joint starts
LAST_S = 0.02  # before a start: u is taken there
STEEP = 0.5  # of the friction, by which u may change meanwhile
START = 2.0  # counts of the encoder: it rests no more
START_PART = 0.12  # of the friction, in the interval of what a start needs
LAG_S = 0.004  # of a current loop, if nothing is known of it
LEFT = 0.3  # of the friction, rms: more that is left is no law of friction
LEFT_PART = 0.25  # of what is left, in an interval
LAW = 0.01  # of the friction, likewise: what a law of friction is good for
TOLD = 0.08  # half an interval of the slope: wider is not told
ALONE = 0.22  # part of the friction's direction that no other column has: with less the logs cannot tell friction
ALONE_FULL = 0.4  # likewise: with less the interval grows
DAMPED = -0.3  # of the friction: a viscous part at the largest speed that no joint has, but a position loop
RATTLES = 0.4  # of the friction, from tick to tick
NOTHING = 2.0  # likewise: there is no friction to speak of
BEYOND = 1.1  # of effort_max: u is something else
LIMIT, LIMITED = 0.98, 0.1  # of effort_max; part of the rows that may be there
NEAR_0, FOLDED = 0.02, 0.8  # of the largest effort; part of the strokes in which u of one sign comes so near to 0
KNEES = (0.03, 0.06, 0.12, 0.25)  # of the largest speed


@dataclass
class Log:
    file: str
    u: np.ndarray
    q: np.ndarray
    h: float


@dataclass
class Estimate:
    value: float
    half: float  # of its interval of 95 %

    def text(self):
        return f"{self.value:.4g} +- {self.half:.2g}"

    @property
    def is_sure(self):
        return abs(self.value) > self.half


@dataclass
class Stroke:
    log: int
    first: int
    last: int
    way: int


@dataclass
class Found:
    friction: Estimate  # that slides, without load and slow
    viscous: Estimate  # per unit of q a second
    slope: Estimate  # of friction over load; None: the logs cannot tell it
    hidden: float  # a slope up to which none is told
    breakaway: Estimate  # of a resting joint; None: no slow start is in the logs
    fall: float  # of friction from the slowest row to fast ones, over friction; 0: none seen
    load: float  # mean of |load|
    level: float  # friction at that load
    travel: float
    left: float  # rms that no law of friction explains
    strokes: int
    starts: int
    limited: int  # strokes left out, because u reaches its limit
    rows: tuple = field(repr=False, default=())  # speed and friction, for the picture


def noise_of(q):
    """The standard deviation of the noise, if neighbours are independent; some tenths of a count for an encoder."""
    return float(1.4826 * np.median(np.abs(np.diff(q, 2))) / np.sqrt(6)) if len(q) > 2 else 0.0


def quantum(q):
    """The least real change: a count of the encoder, or four standard deviations of a reading's noise."""
    steps = np.abs(np.diff(q))
    steps = steps[steps > 1e-9 * max(np.ptp(q), 1e-30)]
    least, noise = float(np.percentile(steps, 5)) if len(steps) else 0.0, noise_of(q)
    return least if least > 0.5 * noise else 4 * noise


def strokes_of(q, travel, number):
    """The strokes, each from one reversal to the next, with a play of a travel."""
    out, held, first, way = [], q[0], 0, 0
    top = q[0]
    top_at = 0
    for i, at in enumerate(q):
        if way * (at - top) >= 0 and way:
            top, top_at = at, i
        elif way * (top - at) > travel or (not way and abs(at - held) > travel):
            if way:
                out.append(Stroke(number, first, top_at, way))
            way = 1 if at > (top if way else held) else -1
            first, top, top_at = (top_at if out else 0), at, i
    if way:
        out.append(Stroke(number, first, top_at, way))
    return [s for s in out if abs(q[s.last] - q[s.first]) > TRAVELS_MIN * travel]


def moving_ticks(q, stroke):
    """The time of the middle 80 % of the stroke, divided by 0.8."""
    part = stroke.way * (q[stroke.first:stroke.last + 1] - q[stroke.first])
    inside = (part > 0.1 * part[-1]) & (part < 0.9 * part[-1])
    return max(int(np.count_nonzero(inside) / 0.8), 1)


@dataclass
class Rows:
    """The rows of all strokes for a regression."""

    u: np.ndarray
    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    way: np.ndarray
    log: np.ndarray
    cluster: np.ndarray

    def only(self, kept):
        return Rows(*(getattr(self, name)[kept] for name in ("u", "q", "v", "a", "way", "log", "cluster")))


def rows_of(logs, strokes, part):
    """Sliding rows, by windows of a `part` of a stroke's time."""
    pieces = []
    for number, s in enumerate(logs):
        mine = [(k, stroke) for k, stroke in enumerate(strokes) if stroke.log == number]
        if not mine:
            continue
        ticks = np.median([moving_ticks(s.q, stroke) for _, stroke in mine])
        window = int(max(WINDOW_MIN, part * ticks)) | 1
        if window >= len(s.q):
            continue
        short = max(5, window // 3) | 1
        if 4 * noise_of(s.q) * np.sqrt(12 / short**3) / s.h > SLOW * np.percentile(np.abs(np.gradient(s.q[:: max(short, 2)], max(short, 2) * s.h)), 90):
            short = window  # the noise of a short one would look like a stop
        v, a = (savgol_filter(s.q, window, 2, deriv=d, delta=s.h) for d in (1, 2))
        u, near = savgol_filter(s.u, window, 2), savgol_filter(s.q, short, 1, deriv=1, delta=s.h)
        for k, stroke in mine:
            rows = np.arange(stroke.first + window, stroke.last - window, max(1, window // 4))
            if not len(rows):
                continue
            least = minimum_filter1d(stroke.way * near, window)[rows]
            rows = rows[(stroke.way * v[rows] > SLOW * np.max(stroke.way * v[rows])) & (least > 0)]
            pieces.append((u[rows], s.q[rows], v[rows], a[rows], np.full(len(rows), stroke.way), np.full(len(rows), number), np.full(len(rows), k)))
    return Rows(*(np.concatenate(column) for column in zip(*pieces))) if pieces else None


def frames_of(rows):
    """Middle and half of the span of q, of each log."""
    return {int(number): (rows.q[rows.log == number].mean(), max(np.ptp(rows.q[rows.log == number]) / 2, 1e-30)) for number in np.unique(rows.log)}


def columns_of(rows, load=None, knee=0.0):
    """Friction, viscous, [slope], [fall], then inertia and load of each log."""
    shared = [rows.way, rows.v]
    if load is not None:
        shared.append(rows.way * np.abs(load))
    if knee:
        shared.append(rows.way * np.exp(-np.abs(rows.v) / knee))
    own = []
    for number, (middle, span) in frames_of(rows).items():
        mine, x = rows.log == number, (rows.q - middle) / span
        own += [mine * rows.a, *(mine * x**power for power in range(POWERS + 1))]
    return np.column_stack([*shared, *own]), len(shared)


def alone_of(rows):
    """The part of the friction's column that the others cannot make, 0 to 1. Between two positions a position loop moves the joint by u = gain (r - q) - damping v, and its r is a
    constant for each way, as friction is: then speed, position and acceleration make the column of friction, and a fit finds the loop in place of the joint."""
    matrix, _ = columns_of(rows)
    scaled = matrix / np.maximum(np.sqrt(np.mean(matrix**2, axis=0)), 1e-30)
    made, *_ = np.linalg.lstsq(scaled[:, 1:], scaled[:, 0], rcond=1e-9)
    return float(np.sqrt(np.mean((scaled[:, 0] - scaled[:, 1:] @ made) ** 2)))


@dataclass
class Fit:
    values: np.ndarray  # friction, viscous, [slope], [fall]
    errors: np.ndarray
    own: np.ndarray  # a row for each log: inertia, load
    loads: tuple  # of each row: J a + load(q), and load(q) alone
    left: np.ndarray
    dof: int


def solved(rows, load=None, knee=0.0):
    """Least squares, with errors by the strokes."""
    matrix, shared = columns_of(rows, load, knee)
    scale = np.maximum(np.sqrt(np.mean(matrix**2, axis=0)), 1e-30)
    scaled = matrix / scale
    values, *_ = np.linalg.lstsq(scaled, rows.u, rcond=1e-9)
    left = rows.u - scaled @ values
    clusters = np.unique(rows.cluster)
    scores = np.array([scaled[rows.cluster == k].T @ left[rows.cluster == k] for k in clusters])
    inverse = np.linalg.pinv(scaled.T @ scaled, rcond=1e-12)
    dof = max(len(clusters) - shared - 1, 1)
    errors = np.sqrt(np.maximum(np.diag(inverse @ scores.T @ scores @ inverse) * len(clusters) / dof, 0)) / scale
    values = values / scale
    whole = matrix[:, shared:] @ values[shared:]
    own = values[shared:].reshape(-1, POWERS + 2)
    inertia = matrix[:, shared :: POWERS + 2] @ own[:, 0]
    return Fit(values[:shared], errors[:shared], own, (whole, whole - inertia), left, dof)


def with_slope(rows, fit, knee, kind):
    """The load that friction grows with is the fit's own: some steps to where both agree."""
    for _ in range(3):
        fit = solved(rows, fit.loads[kind], knee)
    return fit


@dataclass
class Shape:
    """What the strokes show of the law: the speed at which friction falls, or 0; and the load that it grows with, an index of Fit.loads, or None."""

    knee: float
    load: int | None
    hidden: float  # a slope that is within the interval, if none is told


def shape_of(rows):
    fit, top = solved(rows), np.max(np.abs(rows.v))
    best, made = min(((part * top, solved(rows, None, part * top)) for part in KNEES), key=lambda one: np.sum(one[1].left ** 2))
    falls = made.values[2] > 4 * made.errors[2] and np.sum(made.left**2) < 0.8 * np.sum(fit.left**2)
    knee = best if falls else 0.0
    kind, sloped = min(((kind, with_slope(rows, made if falls else fit, knee, kind)) for kind in (0, 1)), key=lambda one: np.sum(one[1].left ** 2))
    half = student.ppf(0.975, sloped.dof) * sloped.errors[2]
    told = half < TOLD and sloped.values[2] > half
    return Shape(knee, kind if told else None, float(max(sloped.values[2], 0.0) + half))


def fitted(rows, shape):
    fit = solved(rows, None, shape.knee)
    return fit if shape.load is None else with_slope(rows, fit, shape.knee, shape.load)


def starts_of(logs, strokes, fit_at, level, count):
    """The effort that a resting joint holds at most, (least, most) of each slow start: effort less the load where it began to move. Under an evenly growing effort the joint
    moves by rate t^3 / 6 J from there, so it began that long before the encoder shows it."""
    out = []
    for stroke in strokes:
        s, way = logs[stroke.log], stroke.way
        moved = way * (s.q[stroke.first : stroke.last + 1] - s.q[stroke.first])
        go = stroke.first + int(np.argmax(moved > START * count))
        rest, last = (max(4, int(round(time / s.h))) for time in (REST_S, LAST_S))
        if go < rest + last or np.ptp(s.q[go - rest : go]) > 3 * count:
            continue
        load, inertia = fit_at(stroke.log, s.q[go])
        slope, there = np.polyfit(s.h * np.arange(1 - last, 1), way * s.u[go - last : go], 1)
        ago = float(np.cbrt(6 * max(inertia, 0) * START * count / slope)) if slope > 0 else 0.0
        change = slope * (1.2 * ago + LAG_S)
        if 0 <= change < STEEP * level:
            out.append((there - way * load - change, there - way * load - slope * 0.8 * ago))
    return out


def with_interval(index, fit, others, floor):
    """The 95 % intervals, from the differences between strokes, the results of other windows and speeds, and the residual that no law explains."""
    value = float(fit.values[index])
    spread = max((abs(float(other.values[index]) - value) for other in others), default=0.0)
    return Estimate(value, float(np.sqrt((student.ppf(0.975, fit.dof) * fit.errors[index]) ** 2 + spread**2 + floor**2)))


def _refuse(cause, text, is_sure=False):
    """If it is sure, exchanged columns are no cause."""
    refusal = Refusal(cause, text)
    refusal.is_sure = is_sure
    raise refusal


def _refuse_limited(s, effort_max):
    most = float(np.max(np.abs(s.u)))
    if most > BEYOND * effort_max:
        _refuse("units", f"{s.file}: u reaches {most:.4g}, and effort_max is {effort_max:.4g}: u is another column (log.columns.u) or in another unit (log.scales.u), or effort_max in joint.yaml is wrong")
    share = float(np.mean(np.abs(s.u) > LIMIT * effort_max))
    if share > LIMITED:
        _refuse("saturated", f"{s.file}: u is at effort_max, {effort_max:.4g}, in {100 * share:.2g} % of the rows, so the joint cannot follow. Move it more slowly, or with less load")


def _within_limits(logs, strokes, effort_max):
    """Returns the strokes in which u stays below its limit, and the number of the others: their jumps of u and of acceleration are too fast for the windows."""
    kept = [stroke for stroke in strokes if np.max(np.abs(logs[stroke.log].u[stroke.first : stroke.last + 1])) <= LIMIT * effort_max]
    return kept, len(strokes) - len(kept)


def _refuse_one_sign(s, strokes):
    """u of one sign may carry a load; but one that comes to 0 in nearly each stroke and never beyond is an absolute value, or is cut off there."""
    if len(strokes) < 2 * STROKES_MIN:
        return
    u = s.u[strokes[0].first : strokes[-1].last + 1]
    near = NEAR_0 * np.max(np.abs(u))
    touches = np.mean([np.min(np.abs(s.u[stroke.first : stroke.last + 1])) < near for stroke in strokes])
    if (np.min(u) >= 0 or np.max(u) <= 0) and touches > FOLDED:
        _refuse("sign", f"{s.file}: u is never {'below' if np.min(u) >= 0 else 'above'} 0, and comes to 0 in {100 * touches:.0f} % of the strokes: its sign was lost (an absolute value, an unsigned number, "
                        "or a limit at 0); log it with its sign")


def _strokes(logs, travel, effort_max):
    for s in logs:
        if not np.ptp(s.u) > 0:
            _refuse("silent", f"{s.file}: u does not change: it must be the output of your loop (log.columns.u)")
        if not np.ptp(s.q) > 0:
            _refuse("silent", f"{s.file}: q does not change: the joint did not move, or q is another column (log.columns.q)")
    strokes = [stroke for number, s in enumerate(logs) for stroke in strokes_of(s.q, travel, number)]
    for number, s in enumerate(logs):
        _refuse_one_sign(s, [stroke for stroke in strokes if stroke.log == number])
    strokes, limited = _within_limits(logs, strokes, effort_max)
    ways = [sum(stroke.way == way for stroke in strokes) for way in (1, -1)]
    if min(ways) < STROKES_MIN <= min(ways) + limited:
        _refuse("saturated", f"u reaches effort_max, {effort_max:.4g}, in {limited} strokes, so the joint cannot follow, and only {ways[0]} strokes up and {ways[1]} down are without that; "
                             f"{STROKES_MIN} each way are needed. Play smaller or slower steps", is_sure=True)
    if min(ways) < STROKES_MIN:
        longest = max(float(np.ptp(s.q)) for s in logs)
        if longest < TRAVELS_MIN * travel:
            _refuse("few loads", f"the joint moves by {longest:.4g}, and {travel:.4g} is the least motion above noise: it must move by {TRAVELS_MIN} times that, {TRAVELS_MIN * travel:.4g}, "
                                 "each way. Play larger strokes")
        _refuse("one direction", f"there are {ways[0]} strokes up and {ways[1]} down, of {TRAVELS_MIN * travel:.4g} or more; {STROKES_MIN} each way are needed. Swing the joint back and forth")
    return strokes, limited


def identify(logs, effort_max, travel=0.0):
    """Returns Found for logs with file, u, q and h. Raises Refusal with what the logs lack."""
    try:
        return _identify(logs, effort_max, travel)
    except Refusal as refusal:
        if refusal.cause in ("sign", "model", "no stiction", "few loads", "units", "saturated") and not refusal.is_sure:
            _refuse_exchanged(logs)
        raise


def _refuse_exchanged(logs):
    try:
        _identify([replace(s, u=s.q, q=s.u) for s in logs], np.inf, 0.0)
    except Refusal:
        return
    _refuse("exchanged", "u and q are exchanged: as named, no friction law explains these logs; exchanged, one does. Check log.columns")


def _identify(logs, effort_max, travel):
    for s in logs:
        _refuse_limited(s, effort_max)
    count = max(quantum(s.q) for s in logs)
    travel = travel or 4 * count
    strokes, limited = _strokes(logs, travel, effort_max)
    strokes = _without_loops(logs, strokes)
    rows = rows_of(logs, strokes, WINDOW_PART)
    if rows is None or len(np.unique(rows.cluster)) < 2 * STROKES_MIN or any(np.sum(rows.way == way) < 10 for way in (1, -1)):
        _refuse("few loads", "the strokes have too few rows in which the joint slides evenly: record at a higher rate, or move it more slowly and further")
    shape = shape_of(rows)
    alone = alone_of(rows)
    if alone < ALONE:
        _refuse_loop()
    half = rows_of(logs, strokes, WINDOW_PART / 2) if alone < ALONE_FULL else None  # it tells what the window does to a friction that is hard to tell
    others = [other for other in (rows_of(logs, strokes, 2 * WINDOW_PART), half, rows.only(np.abs(rows.v) > 0.35 * np.max(np.abs(rows.v)))) if other is not None and len(other.u) > 40]
    fit, load, left, (friction, viscous, slope) = _estimates(rows, others, shape, alone)
    if slope is not None and not (slope.half < TOLD and slope.is_sure):
        shape = replace(shape, load=None, hidden=abs(slope.value) + slope.half)
        fit, load, left, (friction, viscous, slope) = _estimates(rows, others, shape, alone)
    level = friction.value + (slope.value * load if slope else 0.0)
    _judge(friction, level, left, max(float(np.std(np.diff(s.u))) for s in logs))
    if viscous.value + viscous.half < 0 and viscous.value * np.max(np.abs(rows.v)) < DAMPED * abs(level):
        _refuse_loop()
    frames = frames_of(rows)

    def fit_at(number, q):
        middle, span = frames[number]
        own = fit.own[list(frames).index(number)]
        return float(sum(c * ((q - middle) / span) ** power for power, c in enumerate(own[1:]))), float(own[0])

    starts = starts_of(logs, [stroke for stroke in strokes if stroke.log in frames], fit_at, level, count)
    fall = float(fit.values[-1] / level * np.exp(-np.min(np.abs(rows.v)) / shape.knee)) if shape.knee else 0.0
    return Found(friction, viscous, slope, shape.hidden, _breakaway(starts, level), fall, load, level, travel, left, len(np.unique(rows.cluster)), len(starts), limited,
                 (rows.v, rows.way * (rows.u - fit.loads[0])))


def _without_loops(logs, strokes):
    """Leaves out the strokes of logs that show their position loop alone, if there are others."""
    rows, loops = rows_of(logs, strokes, WINDOW_PART), set()
    for number in np.unique(rows.log) if rows is not None else ():
        mine = rows.only(rows.log == number)
        ways = [len(np.unique(mine.cluster[mine.way == way])) for way in (1, -1)]
        if min(ways) >= STROKES_MIN and alone_of(mine) < ALONE:
            loops.add(number)
    kept = [stroke for stroke in strokes if stroke.log not in loops]
    return kept if any(sum(stroke.way == way for stroke in kept) >= STROKES_MIN for way in (1, -1)) else strokes


def _refuse_loop():
    _refuse("loop", "these logs show your position loop rather than the joint: in steps between the same positions its output goes with position and speed as that of a spring and a damper, and "
                     "friction is no different. Record a sine as well, and keep the steps: the same friction must then explain both")


def _estimates(rows, others, shape, alone):
    """Returns the fit, the mean load, the residual, and (friction, viscous, slope or None) with their intervals."""
    fit, others = fitted(rows, shape), [fitted(other, shape) for other in others]
    left, load = float(np.sqrt(np.mean(fit.left**2))), float(np.mean(np.abs(fit.loads[shape.load or 0])))
    floor = float(np.hypot(LEFT_PART * left, LAW * fit.values[0]))
    viscous = with_interval(1, fit, others, 2 * floor / float(np.max(np.abs(rows.v))))
    slope = None if shape.load is None else with_interval(2, fit, others, floor / load)
    return fit, load, left, (with_interval(0, fit, others, floor * max(1.0, ALONE_FULL / alone)), viscous, slope)


def _judge(friction, level, left, jumps):
    if friction.value + friction.half < 0 and left < LEFT * abs(level):
        _refuse("sign", "moving the joint gives energy: u and q have opposite signs. Change one sign, by log.scales: {u: -1}")
    if left > NOTHING * abs(level) or not friction.is_sure:
        _refuse("no stiction", f"no friction found: {friction.text()}, with {left:.2g} rms that no friction law explains. There is nothing to compensate; if you know better, check "
                               "whether u is the loop's output (log.columns.u), and whether a hand touched the joint")
    if left > LEFT * abs(level) and jumps > RATTLES * abs(level):
        _refuse("jumps", f"u jumps by {jumps:.3g} rms from tick to tick, with {level:.3g} of friction: your loop rattles. Lower its gain on speed or filter the speed, and record again")
    if left > LEFT * abs(level):
        _refuse("model", f"no friction law explains these logs: {left:.3g} rms of effort remain, with {level:.3g} of friction. Did a hand or a stop touch the joint, does another joint move it, "
                         "or is u another column (log.columns.u)?")


def _breakaway(starts, level):
    """The starting effort, or None if there are too few slow starts, or if the joint yields before it slides: it would then be less than sliding friction."""
    if len(starts) < STARTS_MIN:
        return None
    low, high = np.array(starts).T
    spread = student.ppf(0.975, len(low) - 1) * np.std((low + high) / 2, ddof=1) / np.sqrt(len(low))
    found = Estimate(float(np.median(low) + np.median(high)) / 2, float(np.sqrt(spread**2 + ((np.median(high) - np.median(low)) / 2) ** 2 + (START_PART * level) ** 2)))
    return found if found.value + found.half > level else None
