"""Finds breakaway and command from the slides alone, whatever the friction is inside stiction.

Once the arm has slid in one direction for long, friction is L. With the lags T1 before friction and T2 behind it,

    F + T2 dF/dt = scale u - T1 du/dt + gravity - way (offset + slope |F|).

A slide is a run of F from one turn to the next; only its later part counts. The law is fitted by linear least squares, each slide with the same weight. The
intervals come from a bootstrap over slides and from the change of the answer with the part of the slides that is used, which is an error of this law.

If breakaway grows with F, bristles follow it late, by the travel over which they build up. Friction is then less than L while F rises and more while it falls, in
all slides alike, which looks like a scale of u. The turns show how late the bristles would follow, but not whether they do.
"""

from dataclasses import dataclass

import numpy as np
import scipy.ndimage
import scipy.special

from .bins import binned, bin_size, noise_of, readings_of

PART = 0.5  # of a slide's travel: the slide counts from there on
PARTS = (0.3, 0.7)  # alternatives to PART, for the interval
END = 0.98  # of a slide's travel: the slide counts up to there
SHORT = 0.08  # of the range of F: shorter slides do not count
SHORTER = 0.015  # of the range of F: slides below it never count
SLOW = 0.3  # of a slide's median rate: slower rows are turning
ENOUGH = 8  # slides for an interval
SURE = 12  # slides to replace the model
LAG_S = 0.05
MEDIAN_OF_3 = 0.67  # standard deviation of the median of three values divided by that of one
DRAWS = 999
COLUMNS = {"symmetric": ("offset", "slope", "scale", "gravity"), "calibrated": ("offset_positive", "slope_positive", "offset_negative", "slope_negative")}


@dataclass
class Line:
    values: dict
    lag_s: float
    error: float  # N, median over the slides
    slides: int
    draws: np.ndarray  # differences of the values, one column each
    rows: np.ndarray  # bins that count, numbered over all segments

    def law(self):
        return {"scale": 1.0, "gravity": 0.0} | self.values

    def breakaway(self, force, way):
        offset, slope = (np.where(way > 0, self.values.get(f"{n}_positive"), self.values.get(f"{n}_negative")) if n not in self.values else self.values[n] for n in ("offset", "slope"))
        return offset + slope * np.abs(force)

    def is_sure(self):
        return self.slides >= SURE


def turns(y, room):
    """Returns (way, first, last) of each run of y from one turn to the next. A reversal by less than `room` is no turn."""
    runs, way, low, high, first = [], 0, 0, 0, 0
    for k in range(1, len(y)):
        if way >= 0 and y[k] >= y[high]:
            high = k
        if way <= 0 and y[k] <= y[low]:
            low = k
        if way >= 0 and y[high] - y[k] > room:
            runs, first, way, low = runs + [(way or 1, first, high)], high, -1, k
        elif way <= 0 and y[k] - y[low] > room:
            runs, first, way, high = runs + [(way or -1, first, low)], low, 1, k
    return runs + ([(way, first, high if way > 0 else low)] if way else [])


def shortest(lengths, room, span):
    """Returns the least length of a slide: a part of the range. If too few slides are that long, for example at many levels, returns half of their median length."""
    if np.sum(lengths > SHORT * span) >= SURE:
        return SHORT * span
    some = lengths[lengths > max(SHORTER * span, 3 * room)]
    return min(SHORT * span, 0.5 * float(np.median(some))) if len(some) >= SURE else SHORT * span


def runs_of(log):
    """Returns each segment's averages u, du/dt, F, dF/dt and the runs of F that are long enough."""
    span = max(np.ptp(s.force) for s in log.segments)
    found = []
    for s in log.segments:
        size = bin_size(s.h)
        u, y = binned(s.u, size), binned(s.force, size)
        room = 10 * noise_of(y) + 2e-3 * span
        runs = turns(y, room) if len(y) > 3 else []
        lengths = np.array([abs(y[last] - y[first]) for _, first, last in runs])
        slope = [np.gradient(x, size * s.h) if len(x) > 1 else np.zeros(len(x)) for x in (u, y)]
        found.append((u, slope[0], y, slope[1], [run for run, length in zip(runs, lengths) if length > shortest(lengths, room, span)]))
    return found


def spans(log):
    """Returns (way, low, high) of each run."""
    return [(way, *sorted((float(y[first]), float(y[last])))) for *_, y, _, runs in runs_of(log) for way, first, last in runs]


def later(found, part):
    """Returns rows (u, du/dt, F, dF/dt, way, slide, bin) of the later part of each run."""
    rows, offset, number = [], 0, 0
    for u, du, y, dy, runs in found:
        for way, first, last in runs:
            k = np.arange(first, last + 1)
            gone = way * (y[k] - y[first])
            k = k[(gone > part * gone[-1]) & (gone < END * gone[-1])]
            k = k[way * dy[k] > SLOW * np.median(way * dy[k])] if len(k) else k
            rows.append(np.c_[u[k], du[k], y[k], dy[k], np.full(len(k), way), np.full(len(k), number), offset + k])
            number += 1
        offset += len(y)
    return np.concatenate(rows) if rows else np.zeros((0, 7))


def system(rows, assume):
    """Returns the matrix, with the lags' columns last, and the right side."""
    u, du, y, dy, way = rows[:, :5].T
    up, down, lags = (way > 0).astype(float), (way < 0).astype(float), np.c_[-du, -dy]
    if assume == "symmetric":
        return np.c_[-way, -way * np.abs(y), u, np.ones(len(u)), lags], y
    return np.c_[-up, -up * np.abs(y), down, down * np.abs(y), lags], y - u


def prior(a, rows):
    """Returns a weak prior of the lags around 0, as rows below the matrix: slides of one rate do not tell lags from the offset."""
    size = 1e-3 * np.ptp(rows[:, 2]) / LAG_S
    return np.diag(np.r_[np.full(a.shape[1] - 2, 1e-9 * np.abs(a).max()), size, size])


def solve(rows, assume):
    """Returns the solution, its errors, and the weights of the rows; outliers have weight 0."""
    a, b = system(rows, assume)
    slide = rows[:, 5].astype(int)
    keep = np.ones(len(rows), bool)
    for _ in range(4):
        weight = keep / np.sqrt(np.maximum(np.bincount(slide, keep)[slide], 1))
        x = np.linalg.lstsq(np.r_[weight[:, None] * a, prior(a, rows)], np.r_[weight * b, np.zeros(a.shape[1])], rcond=None)[0]
        error = np.abs(b - a @ x)
        keep = error <= 5 * np.median(error) + 1e-12
    return x, error, weight


def draw(rows, assume, x, weight, seed=1):
    """Returns the differences from the solution when slides are drawn again, each corrected for its own influence."""
    a, b = system(rows, assume)
    slide = rows[:, 5].astype(int)
    used, number = np.unique(slide, return_inverse=True)
    n, p = len(used), a.shape[1]
    own, g = np.zeros((n, p, p)), np.zeros((n, p))
    np.add.at(own, number, (weight**2)[:, None, None] * a[:, :, None] * a[:, None, :])
    np.add.at(g, number, (weight**2 * (b - a @ x))[:, None] * a)
    total = own.sum(0) + prior(a, rows) ** 2
    g = (total @ np.linalg.solve(total - own, g[..., None]))[..., 0]
    draws = np.random.default_rng(seed).multinomial(n, np.full(n, 1 / n), size=DRAWS)
    wider = scipy.special.stdtrit(max(n - p, 1), 0.975) / 1.96
    return wider * np.linalg.solve(total, (draws @ (g - g.mean(0))).T).T


def error_draws(rows, assume, weight, error, source):
    """Returns draws of the error of the law: the residual of the line may be an error of any one value that is the same in all slides."""
    a, _ = system(rows, assume)
    share = weight / np.sqrt(np.sum(weight**2))
    upper = np.linalg.qr(np.r_[share[:, None] * a, prior(a, rows) / np.sqrt(np.sum(weight**2))], mode="r")
    return error / 2 * np.linalg.solve(upper, source.normal(size=(a.shape[1], DRAWS))).T


def build_up(found, law, lag_s, breakaway):
    """Returns the travel, divided by breakaway, over which friction comes within 1/e of breakaway if it builds up exponentially: after a turn friction is 0 at ln 2 of
    this travel. Takes the upper quartile of the slowest third, because the result serves as a bound."""
    seen = []
    for u, du, y, _, runs in found:
        for way, first, last in runs:
            k = np.arange(first, last + 1)
            share = way * (law["scale"] * (u[k] - lag_s * du[k]) + law["gravity"] - y[k])
            after = int(np.argmax(share > 0))
            if after:
                part = share[after] / (share[after] - share[after - 1])
                here, before = y[k[after]], y[k[after - 1]]
                gone = way * ((1 - part) * here + part * before - y[first]) + abs(here - before) / 2  # the turn lies within one average
                seen.append((np.median(np.abs(du[k])), max(gone, 0.0) / breakaway(y[first], way)))
    if len(seen) < ENOUGH:
        return 0.0
    rate, ways = np.array(seen).T
    return float(np.quantile(ways[rate <= np.quantile(rate, 1 / 3)], 0.75) / np.log(2))


def late_friction(values, way):
    """Returns the largest error of the values if friction follows L with the travel `way`."""
    if "scale" in values:
        late = way * values["slope"]
        return {"scale": late * values["slope"], "gravity": late * values["offset"]}
    law = {name: (values[f"{name}_positive"] + values[f"{name}_negative"]) / 2 for name in ("offset", "slope")}
    return {f"{name}_{side}": sign * way * law["slope"] * law[name] for name in law for side, sign in (("positive", -1), ("negative", 1))}


def line(log, assume):
    """Returns the law through the slides, or None if there are too few."""
    found = runs_of(log)
    rows = later(found, PART)
    slides = len(np.unique(rows[:, 5]))
    if slides < 4 or len(np.unique(rows[:, 4])) < 2 or len(rows) < 20:
        return None
    x, error, weight = solve(rows, assume)
    values = dict(zip(COLUMNS[assume], x))
    lag = (x[-2] + x[-1] * values.get("scale", 1.0)) / values.get("scale", 1.0)
    draws = np.zeros((DRAWS, 4))
    if slides >= ENOUGH:
        changed = np.subtract(*(solve(later(found, part), assume)[0] for part in PARTS))
        source = np.random.default_rng(2)
        draws = draw(rows, assume, x, weight) + source.normal(size=(DRAWS, 1)) * changed / 2 + error_draws(rows, assume, weight, np.median(error), source)
        draws = draws[:, :4]
    found_line = Line(values, float(lag), float(np.median(error)), slides, draws, rows[:, 6].astype(int))
    if slides >= ENOUGH:
        late = late_friction(values, build_up(found, found_line.law(), found_line.lag_s, found_line.breakaway))
        draws += source.choice([-1.0, 1.0], size=(DRAWS, 1)) * [late.get(name, 0.0) for name in values]
    return found_line


def residual(log, assume):
    """Returns the rows of the later parts of the slides, as `later` does, and the residual of the law in each."""
    rows = later(runs_of(log), PART)
    x, *_ = solve(rows, assume)
    a, target = system(rows, assume)
    return rows, target - a @ x


def half_of(values):
    """Returns half of the interval of a median."""
    return float(1.96 * 1.2533 * 1.4826 * np.median(np.abs(values - np.median(values))) / np.sqrt(len(values))) if len(values) >= ENOUGH else np.inf


def fall(log, line):
    """Returns by how much friction is larger when F begins to move than later in the slide, relative, and half of the interval. Uses the slowest third of the slides, in
    which the lags change the net force least. Noise and steps of u raise the largest net force if it stays the same for long; they hardly raise a short peak. The
    interval includes all of this effect, and half as much again because noise moves the turns."""
    found, p = [], line.law()
    for s, (u, du, y, _, runs) in zip(log.segments, runs_of(log)):
        coarse = readings_of(s.u).coarse * p["scale"]
        for way, first, last in runs:
            k = np.arange(first, last + 1)
            L = line.breakaway(y[k], way)
            share = way * (p["scale"] * (u[k] - line.lag_s * du[k]) + p["gravity"] - y[k]) / L
            gone = way * (y[k] - y[first])
            begin, later = int(np.argmax(gone > PART * gone[-1])), (gone > PART * gone[-1]) & (gone < END * gone[-1])
            if begin >= 5 and later.sum() >= 3:
                raised = MEDIAN_OF_3 * noise_of(share[begin:]) * scipy.special.ndtri(1 - 1 / (begin + 1)) + coarse / np.median(L)
                found.append((np.median(np.abs(du[k])), np.max(scipy.ndimage.median_filter(share[:begin], 3)) - np.median(share[later]), raised))
    if len(found) < ENOUGH:
        return 0.0, np.inf
    rate, share, raised = np.array(found).T
    slow = rate <= np.quantile(rate, 1 / 3)
    share, raised = share[slow], float(np.median(raised[slow]))
    return float(np.median(share)), half_of(share) + 1.5 * raised
