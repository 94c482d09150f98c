"""Finds patterns in the residual of the slides: friction or a zero that changes with time, or a pattern over force, which stands for one over position."""

import numpy as np

from . import slides
from .bins import BIN_S

TIME_PART = 0.6  # of the variance over slides that a change with time must explain
TIME_LEAST = 0.03  # of breakaway
FORCE_PART = 0.3  # of the variance over rows that a sine over force must explain: at most 0.15 in 47 sound logs, at least 0.46 in 47 with cogging of a quarter of breakaway
FORCE_LEAST = 0.05  # of breakaway
PERIODS_MAX = 20.0  # over the range of F
ROWS_LEAST = 60
ENOUGH = 12  # slides


def _over(time, values):
    """Fits a parabola. Returns its first and last value, its range, and its share of the variance."""
    t = (time - time[0]) / max(time[-1] - time[0], 1e-300)
    fit = np.polyval(np.polyfit(t, values, 2), t)
    return float(fit[0]), float(fit[-1]), float(np.ptp(fit)), 1 - float(np.var(values - fit) / max(np.var(values), 1e-300))


def over_time(rows, left, level):
    """Returns a sentence if friction or the zero changes with time, otherwise None. Friction acts against the motion of F; the zero does not depend on its direction."""
    number, way = rows[:, 5].astype(int), rows[:, 4]
    all_slides = np.unique(number)
    if len(all_slides) < ENOUGH:
        return None
    mean = np.array([np.mean(left[number == n]) for n in all_slides])
    ways = np.array([way[number == n][0] for n in all_slides])
    time = np.array([np.mean(rows[number == n, 6]) for n in all_slides]) * BIN_S
    found = []
    for values, which in ((-ways * mean, "friction"), (mean, "zero")):
        begin, end, change, part = _over(time, values)
        if part > TIME_PART and change > TIME_LEAST * level:
            found.append((part, which, end - begin, change))
    if not found:
        return None
    _, which, whole, change = max(found)
    if which == "friction":
        return (f"friction changes with time: it is {abs(whole):.3g} N {'less' if whole < 0 else 'more'} at the end of the log than at its beginning, {100 * change / level:.2g} % of breakaway: "
                "the rig warms up or runs in. Let it run until friction is steady, then log the experiment again")
    return f"F drifts: in both directions it is {abs(whole):.3g} N {'less' if whole < 0 else 'more'} at the end of the log than at its beginning: the sensor's zero or the load changes with time"


def _alike_taken_off(rows, left):
    """Removes the slope that all slides have in common: friction that still builds up looks like such a slope, and a pattern does not."""
    number = rows[:, 5].astype(int)
    within = rows[:, 2] - (np.bincount(number, rows[:, 2]) / np.maximum(np.bincount(number), 1))[number]
    left = left - np.mean(left)
    return left - within * float(within @ left) / max(float(within @ within), 1e-300)


def over_force(rows, left, level):
    """Returns a sentence if there is a pattern over force, the same in both directions, otherwise None. Tries sines over force and takes the one that explains most."""
    span = float(np.ptp(rows[:, 2]))
    left = _alike_taken_off(rows, left)
    best = (0.0, 0.0, 0.0)
    for periods in np.arange(1.5, PERIODS_MAX, 0.1):
        slow = np.abs(rows[:, 3]) * BIN_S < span / periods / 4  # slow enough for an average to lie at one place of the pattern
        if slow.sum() < ROWS_LEAST:
            break
        phase = 2 * np.pi * periods * rows[slow, 2] / span
        waves = np.c_[np.sin(phase), np.cos(phase)]
        size, here = np.linalg.lstsq(waves, left[slow], rcond=None)[0], left[slow]
        best = max(best, (1 - float(np.var(here - waves @ size) / max(np.var(here), 1e-300)), float(np.hypot(*size)), span / periods))
    part, size, period = best
    if part < FORCE_PART or size < FORCE_LEAST * level:
        return None
    return (f"there is a pattern over force, the same upwards and downwards, of {size:.3g} N in periods of {period:.3g} N: {100 * size / level:.2g} % of breakaway. The cause is cogging, a nonlinear sensor, or another effect of "
            "the position: subtract it from u, or average over whole periods")


def shows(log, assume, level):
    """Returns sentences on the residual. A change with time comes first, because it makes a pattern over force as well."""
    rows, left = slides.residual(log, assume)
    if len(rows) < 20 or not level > 0:
        return []
    return [text for text in (over_time(rows, left, level), over_force(rows, left, level)) if text]
