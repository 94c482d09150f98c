"""Finds friction from strokes at speed: logs of force and position, without a force at the load.

A file has one load or several in turn: a new load begins where strokes in the same direction differ by more than half of the friction. A stroke is a run of
the position in one direction; u is averaged over the middle of its travel. The load is the mean of both directions, friction is half their difference, and the
repeats are the pairs of strokes. This gives L(F) of sliding, and nothing about stiction.
"""

from dataclasses import dataclass

import numpy as np
import scipy.stats

from .bins import binned
from .refusal import Refusal

CUT = 0.15  # of the travel is left out at both ends
SHORT = 0.5  # of the range of the position: shorter strokes are left out
SMOOTH_S = 0.1
CLOSE = 0.1  # of friction: loads closer than this are one load
SCATTERS = 6.0
DRAWS = 999


@dataclass
class Level:
    file: str
    when: str  # time in the file, if it has several loads
    load: float  # with its sign
    friction: float
    repeats: np.ndarray  # friction of each pair of strokes
    strokes: list  # (segment, first row, last row, way, mean u)


@dataclass
class Law:
    levels: list
    offset: float
    slope: float
    offset_half: float
    slope_half: float
    r2: float
    is_table: bool
    deviation: float  # largest relative deviation from the line
    slope_shown: bool


def strokes_of(segment):
    """Returns (first, last, way) of the middle of each stroke."""
    size = max(int(round(SMOOTH_S / segment.h)), 1)
    x = binned(segment.position, size)
    if len(x) < 4:
        return []
    range_ = np.ptp(segment.position)
    rate = np.diff(x)
    way = np.where(np.abs(rate) > 0.1 * np.percentile(np.abs(rate), 90), np.sign(rate), 0)
    way = np.r_[way, 0]
    cuts = np.flatnonzero(np.diff(way)) + 1
    found = []
    for run in np.split(np.arange(len(way)), cuts):
        if way[run[0]] == 0 or len(run) < 3:
            continue
        found.append((int(run[0]), int(min(run[-1] + 1, len(x) - 1)), int(way[run[0]])))
    merged = []
    for first, last, w in found:  # a pause inside a stroke does not end it
        if merged and merged[-1][2] == w:
            merged[-1] = (merged[-1][0], last, w)
        else:
            merged.append((first, last, w))
    low, high = np.percentile(x, 2), np.percentile(x, 98)
    out = []
    for first, last, w in merged:
        if abs(x[last] - x[first]) < SHORT * range_:
            continue
        rows = np.arange(first * size, min((last + 1) * size, len(segment.u)))
        inside = rows[(segment.position[rows] > low + CUT * (high - low)) & (segment.position[rows] < high - CUT * (high - low))]
        if len(inside) > 10:
            out.append((int(inside[0]), int(inside[-1]) + 1, w))
    return out


def plateaus(strokes):
    """Returns the strokes of each load, in both directions. A new load begins where strokes in the same direction differ by more than half of the friction, or by far more
    than the strokes of one load do. Strokes without a partner in the other direction, in which the load changes, are left out."""
    means = [mean for *_, mean in strokes]
    changes = [abs(a - b) / 2 for a, b, one, other in zip(means, means[1:], strokes, strokes[1:]) if one[3] != other[3]]
    friction = float(np.median(changes)) if changes else np.inf
    apart = min(0.5 * friction, max(CLOSE * friction, SCATTERS * _scatter(strokes)))
    found = []
    for stroke in strokes:
        alike = [mean for *_, way, mean in found[-1] if way == stroke[3]] if found else []
        if not found or (alike and abs(stroke[4] - np.mean(alike)) > apart):
            found.append([])
        found[-1].append(stroke)
    return found if len(found) == 1 else [load for load in found if len({way for *_, way, _ in load}) == 2]


def _scatter(strokes):
    """Returns the standard deviation of strokes of the same direction and load. Uses the half of the neighbours that differ least, because the others may have another load;
    if no load has two strokes, uses the second differences of friction from pair to pair, because a load shifts both directions alike."""
    up, down = ([mean for *_, w, mean in strokes if w == way] for way in (1, -1))
    if min(len(up), len(down)) < 4:
        return np.inf
    apart = np.sort(np.abs(np.r_[np.diff(up), np.diff(down)]))
    pairs = min(len(up), len(down))
    bends = np.diff((np.array(up[:pairs]) - np.array(down[:pairs])) / 2, 2)
    return float(min(np.median(apart[: len(apart) // 2]) / (0.45 * np.sqrt(2)), np.median(np.abs(bends)) / (0.6745 * np.sqrt(3))))


def _steady(strokes, segments):
    """Returns the strokes in which the load does not change. If it does, the two halves of a stroke differ more than those of the others."""
    halves = np.array([float(np.diff([np.mean(part) for part in np.array_split(segments[number].u[first:last], 2)])[0]) for number, first, last, *_ in strokes])
    ways = np.array([way for *_, way, _ in strokes])
    means = np.array([mean for *_, mean in strokes])
    if len({*ways}) < 2:
        return strokes
    friction = abs(float(np.median(means[ways > 0]) - np.median(means[ways < 0]))) / 2
    usual = {way: np.median(halves[ways == way]) for way in (1, -1)}
    return [stroke for stroke, half in zip(strokes, halves) if abs(half - usual[stroke[3]]) <= 0.5 * friction]


def levels_of(file, segments):
    strokes = _steady([(number, first, last, way, float(np.mean(s.u[first:last]))) for number, s in enumerate(segments) for first, last, way in strokes_of(s)], segments)
    if len({way for *_, way, _ in strokes}) < 2:
        raise Refusal("one direction", f"{file}: one direction only: friction is half the difference between the directions")
    loads = plateaus(strokes)
    return [_level(file, segments, load, len(loads) > 1) for load in loads]


def _level(file, segments, strokes, is_one_of_several):
    up, down = (np.array([mean for *_, way, mean in strokes if way == w]) for w in (1, -1))
    pairs = min(len(up), len(down))
    half = (np.mean(up) - np.mean(down)) / 2
    repeats = (up[:pairs] - down[:pairs]) / 2
    begin, end = (segments[number].t[row] for number, row in ((strokes[0][0], strokes[0][1]), (strokes[-1][0], strokes[-1][2] - 1)))
    when = f" from {begin:.4g} to {end:.4g} s" if is_one_of_several else ""
    return Level(file, when, float((np.mean(up) + np.mean(down)) / 2), float(abs(half)), np.abs(repeats), strokes)


def identify(log):
    """Returns the levels and the law through them."""
    for s in log.segments:
        if s.position is None:
            s.position = np.r_[0, np.cumsum((s.speed[1:] + s.speed[:-1]) / 2 * np.diff(s.t))]
    files = {}
    for s in log.segments:
        files.setdefault(s.file, []).append(s)
    levels = sorted((level for file, segments in files.items() for level in levels_of(file, segments)), key=lambda level: abs(level.load))
    if len(levels) < 4:
        raise Refusal("few loads", f"few loads: {len(levels)}; at least four are needed to tell a line from a bend, in one file each or in turn, with two strokes each way")
    load, friction = np.abs([v.load for v in levels]), np.array([v.friction for v in levels])
    if np.ptp(load) < 0.15 * load.max():
        raise Refusal("few loads", f"few loads: all are within {np.ptp(load):.3g} N of each other; they must span at least 15 % of the largest load")
    fit = scipy.stats.linregress(load, friction)
    t = scipy.stats.t.ppf(0.975, len(levels) - 2)
    # The intervals include the scatter of the repeats: each draw fits a line through levels that are drawn again from their own pairs.
    source = np.random.default_rng(1)
    draws = np.array([np.polyfit(load, [source.choice(v.repeats, len(v.repeats)).mean() for v in levels], 1) for _ in range(DRAWS)])
    spread = (np.percentile(draws, 97.5, axis=0) - np.percentile(draws, 2.5, axis=0)) / 2
    slope_half, offset_half = max(t * fit.stderr, spread[0]), max(t * fit.intercept_stderr, spread[1])
    deviation = float(np.max(np.abs(friction - fit.intercept - fit.slope * load) / friction))
    within = np.concatenate([v.repeats - v.repeats.mean() for v in levels])
    free = max(len(within) - len(levels), 1)
    number = np.array([len(v.repeats) for v in levels])
    between = float(np.sum(number * (friction - fit.intercept - fit.slope * load) ** 2)) / (len(levels) - 2)
    chance = float(scipy.stats.f.sf(between / max(float(within @ within) / free, 1e-300), len(levels) - 2, free))
    return Law(levels, float(fit.intercept), float(fit.slope), float(offset_half), float(slope_half), float(fit.rvalue**2), bool(deviation > 0.1 and chance < 0.01), deviation,
               bool(abs(fit.slope) > slope_half))
