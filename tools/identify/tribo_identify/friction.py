"""tribo-identify friction: breakaway, command and hysteresis from logs.

1. Events (events.py), and the line through the slides (slides.py), as the start; and the lags, where none are given.
2. Output error: the library's compensator plays u (native.c) and must give the recorded F. Gauss-Newton over averages of 20 ms; blocks that fit far worse
   than the others are left out, and said. A delay between u and F is found first.
3. Intervals: block bootstrap. A block is a half-cycle, from one break-away to the next of the other direction, so that repeats are what counts and not
   the number of samples. Each draw solves the linearised fit anew; Student's t for the number of blocks.
4. Where the model does not follow the log and the line does so better, breakaway and command are the line's.
5. Lack of fit: what each block's own L differs by, over the loads, against the scatter between repeats at a load: a table where a line is refused.
6. A quarter of the blocks, held out, must fit as the others do.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace

import numpy as np
import scipy.ndimage
import scipy.special
import scipy.stats

from tribo_design import progress

from . import native, noise, residual, rows, slides
from .bins import bin_size, binned, noise_of
from .events import WRONG_SIGN, check, check_events, find, held_s, loads, not_of_one_clock, other_unit, saturated
from .refusal import Refusal

STEPS_MAX = 10_000_000  # of a simulation, beyond which its steps grow
K_STARTS = (3.0, 5.0, 8.0, 14.0)  # of k_min, and L over the friction of slow slides: the fit has more than one valley
APART = 0.08  # of L: a smaller difference of L+ and L- does no harm
L_STARTS = (1.0, 1.2, 1.5, 2.0)
SHARP = 0.3  # of the Jacobian's steps, near the end: the relays make the model rough below and bent above it
VALLEYS = 4  # that are gone down into
NOISE = 1.5  # times the noise of the averages: no other valley is deeper
FALL = 0.015  # of L: a larger one from break-away to sliding is named
GAP = 0.005  # of L, in slow slides, that the median of a noisy log may be off by
EARLY_STEPS = -1.5  # of the lags that are tried at the turns: an earlier F was not driven by u
FOLLOWS = 0.85  # of the way of F, that goes the way of u
MATTERS = 0.01  # of the largest force: less friction is none
DOUBT = 0.03  # of L: a residual beyond it casts doubt on L, a third of it on hysteresis
ROWS_MAX = 2_400_000  # of all iterations together
START_ROWS = 60_000  # of a log, that its start is chosen by
FINE_S = 1e-4  # step of the fits, and of the choice of their starts: a relay that switches a step late may take another way
COARSE_S = 5e-4
DRAWS = 999
SYMMETRIC = ("offset", "slope", "scale", "gravity")
CALIBRATED = ("offset_positive", "slope_positive", "offset_negative", "slope_negative")
HYSTERESIS = ("k_min", "k_max", "m", "v0")
REST = ("k_min", "k_max", "v0", "m", "delay")
# What a log need not show has a prior, about the paper's values (as logarithms) or 0: it is part of the intervals of all others.
PRIOR = {"k_min": 1.0, "k_max": 0.6, "m": 0.4, "v0": 0.6, "delay": 0.005}
LOGARITHMIC = HYSTERESIS
LAG_MAX_S = 0.2
PAPER_LAG_S = 1 / native.PAPER["actuator"] + 1 / native.PAPER["sensor"] + native.PAPER["damping"] / native.PAPER["stiffness"]
UNITS = {"offset": "N", "offset_positive": "N", "offset_negative": "N", "gravity": "N", "v0": "N/s", "delay": "s"}
DESCRIBED = {"offset": "breakaway offset", "slope": "breakaway slope", "offset_positive": "L+ offset", "slope_positive": "L+ slope", "offset_negative": "L- offset",
             "slope_negative": "L- slope", "scale": "command scale", "gravity": "bias or gravity", "delay": "delay", "k_min": "k_min", "k_max": "k_max", "m": "m", "v0": "v0"}
EXPERIMENT = {"k_min": "ramps inside stiction (tribo-identify plan --hysteresis)", "k_max": "slow ramps inside stiction (tribo-identify plan --hysteresis)",
              "m": "ramps inside stiction at rates about v0, many times (plan --hysteresis --repeats 5)", "v0": "ramps inside stiction at several slow rates (plan --hysteresis)"}
BOUNDS = {"k_min": (1.02, 500.0), "k_max": (1.02, 1000.0), "m": (0.3, 30.0), "v0": (1e-5, 1e4)}


@dataclass
class Estimate:
    name: str
    value: float
    half: float  # 95 %
    verdict: str  # identified, weak, not identifiable, assumed
    remark: str = ""


@dataclass
class Result:
    estimates: list
    params: dict  # for native.simulate
    table: list  # (F, L+, L-), empty: the line
    events: list
    model: list  # F by segment
    residual_rms: float
    held_out: float  # rms of the held-out blocks over that of the others
    ripple: float
    delay_s: float
    loads: list
    assume: str
    remarks: list = field(default_factory=list)
    L_half: float = 0.0  # of L in the middle of the loads, relative
    rate_effect: float = 0.0  # of breakaway, relative, for ten times the rate
    slide_gap: tuple = (0.0, np.inf)  # friction seen in slow slides less the model's there, over L; and half of its interval
    noises: noise.Noise = field(default_factory=lambda: noise.Noise(0.0, 0.0, 0.0))  # what no model follows; a u that is off is in units of F
    line_error: float | None = None  # N, where the line through the slides gave breakaway and command
    fall: tuple = (0.0, np.inf)  # of friction from break-away to sliding, relative, and half of its interval
    shown: list = field(default_factory=list)  # what the residual of the slides shows
    lack_of_fit: tuple = (0.0, 1.0)  # largest deviation from the line, relative; probability by chance


class Fit:
    """The output-error problem: residuals in bins over all segments."""

    def __init__(self, log, events, rig, assume):
        self.log, self.events, self.assume = log, events, assume
        self.base = {**native.PAPER, **rig}
        self.rest = tuple(name for name in REST if name not in rig)  # a known delay is not fitted
        h = log.sample_time_s
        self.step(COARSE_S)
        self.size = bin_size(h)
        self.y = np.concatenate([binned(s.force, self.size) for s in log.segments])
        self.start = [float(np.mean(s.force[: self.size])) for s in log.segments]
        self.full = np.concatenate([binned(saturated(s).astype(float), self.size) > 0 for s in log.segments])
        self._blocks()
        self.sharp = 1.0  # of the steps of the Jacobian
        self.table_at = None  # loads of a table
        self.delay_s = 0.0  # that is expected
        self.weight = np.ones(self.count)

    def step(self, step_s):
        wanted = max(int(np.ceil(self.log.sample_time_s / step_s - 1e-6)), 1)
        self.substeps = max(min(wanted, STEPS_MAX // max(self.log.rows, 1)), 1)

    def iterations(self):
        """Fewer for a long log, for which the fit to its first rows is a good start."""
        return max(min(8, ROWS_MAX // max(self.log.rows, 1)), 2)

    def _blocks(self):
        """A block begins where F breaks away in another direction than before, and with each segment."""
        block, number, first = [], -1, 0
        self.of_event = {}
        for index, s in enumerate(self.log.segments):
            bins = len(s.u) // self.size
            mine = np.zeros(bins, int)
            number += 1
            way = 0
            for i, e in enumerate(self.events):
                if e.segment != index:
                    continue
                if way and e.way != way:
                    number += 1
                    mine[min(e.start // self.size, bins - 1) :] += 1
                way = e.way
                self.of_event[i] = number
            block.append(first + mine)
            first = number + 1
        self.block = np.concatenate(block)
        self.count = int(self.block.max()) + 1

    def params(self, names, theta):
        p = dict(self.base)
        table = []
        values = dict(zip(names, theta))
        for name, value in values.items():
            if name in LOGARITHMIC:
                value = float(np.clip(np.exp(value), *BOUNDS[name]))
            if name in ("offset", "slope"):
                value = max(value, 1e-6) if name == "offset" else max(value, 0.0)
                p[f"{name}_positive"] = p[f"{name}_negative"] = value
            elif name.startswith("table"):
                continue
            else:
                p[name] = max(value, 1e-6) if name.startswith("offset") else max(value, 0.0) if name.startswith("slope") else value
        if self.table_at is not None:
            plus = [max(values[f"table_{i}"], 1e-6) for i in range(len(self.table_at))]
            minus = [max(values.get(f"table_minus_{i}", values[f"table_{i}"]), 1e-6) for i in range(len(self.table_at))]
            table = list(zip(self.table_at, plus, minus))
        p["k_max"] = max(p["k_max"], p["k_min"])
        return p, table

    def model(self, names, theta):
        p, table = self.params(names, theta)
        return [native.simulate(p, s.u, s.h, y0, self.substeps, table) for s, y0 in zip(self.log.segments, self.start)]

    def outputs(self, names, thetas):
        """Of several parameters, averaged, a row each."""
        params, tables = zip(*(self.params(names, theta) for theta in thetas))
        pieces = []
        for s, y0 in zip(self.log.segments, self.start):
            y = native.simulate_sets(params, s.u, s.h, y0, self.substeps, tables)
            pieces.append([binned(one, self.size) for one in y])
        return np.concatenate(pieces, axis=1)

    def residual(self, names, theta):
        return self.y - self.outputs(names, [theta])[0]

    def noise(self):
        """Of the averages of F, from how they bend."""
        return noise_of(self.y)

    def rms(self, residual):
        w = self.use()
        return float(np.sqrt(np.sum(w * residual**2) / max(np.sum(w), 1)))

    def use(self):
        return self.weight[self.block] * ~self.full

    def step_of(self, name):
        if name in LOGARITHMIC:
            return self.sharp * {"k_min": 0.05, "k_max": 0.1, "m": 0.2, "v0": 0.1}[name]
        return self.sharp * {"delay": 5e-4, "scale": 0.004, "slope": 0.006, "slope_positive": 0.006, "slope_negative": 0.006}.get(name, 0.01 * self.level)

    def jacobian(self, names, theta, residual, pool):
        d = np.diag([self.step_of(n) for n in names])
        parts = np.array_split(theta + d, -(-len(names) // native.SETS_MAX))
        there = np.concatenate(list(pool.map(lambda part: self.outputs(names, part), parts)))
        return ((there - (self.y - residual)) / np.diag(d)[:, None]).T

    def prior(self, names):
        """Means, and inverse variances."""
        mean = np.array([np.log(native.PAPER[n]) if n in LOGARITHMIC else self.delay_s if n == "delay" else 0.0 for n in names])
        return mean, np.array([1 / PRIOR[n] ** 2 if n in PRIOR else 0.0 for n in names])

    def solve(self, names, theta, iterations=8, j=None):
        """Gauss-Newton with damping. A Jacobian, `j` or the last, is kept as long as it helps."""
        names, theta = list(names), np.array(theta, float)
        damping, fresh = 1e-3, False
        with ThreadPoolExecutor(2) as pool:
            residual = self.residual(names, theta)
            for _ in range(iterations):
                w = self.use()
                mean, inverse = self.prior(names)
                variance = float(np.sum(w * residual**2) / max(np.sum(w), 1))
                penalty = inverse * variance
                cost = float(np.sum(w * residual**2) + penalty @ (theta - mean) ** 2)
                if j is None:
                    j, fresh = self.jacobian(names, theta, residual, pool), True
                a, g = j.T @ (w[:, None] * j) + np.diag(penalty), j.T @ (w * residual) - penalty * (theta - mean)
                gain = 0.0
                for _ in range(5 if fresh else 1):
                    delta = np.linalg.lstsq(a + damping * np.diag(np.diag(a) + 1e-12 * np.trace(a)), g, rcond=None)[0]
                    there = self._within(names, theta + self._bounded(names, delta))
                    trial = self.residual(names, there)
                    lower = float(np.sum(w * trial**2) + penalty @ (there - mean) ** 2)
                    if lower < cost:
                        gain = 1 - lower / cost
                        theta, residual, damping = there, trial, damping * 0.2
                        break
                    damping *= 10 if fresh else 1
                if gain < 1e-3 and fresh:
                    break
                if gain < 0.3:  # another point, another slope
                    self.j, j = j, None
                fresh = False
            self.j = self.j if j is None else j
        return theta, residual

    def _within(self, names, theta):
        """What the library takes: offsets above 0, slopes from 0."""
        for i, name in enumerate(names):
            if name.startswith(("offset", "table")):
                theta[i] = max(theta[i], 1e-3 * self.level)
            elif name.startswith("slope"):
                theta[i] = max(theta[i], 0.0)
        return theta

    def _bounded(self, names, delta):
        for i, name in enumerate(names):
            most = 0.02 if name == "delay" else 0.7 if name in LOGARITHMIC else 0.2 if name in ("scale",) or name.startswith("slope") else 2 * self.level
            delta[i] = np.clip(delta[i], -most, most)
        return delta

    def sums(self, residual):
        """J'J and J'r of each block."""
        w = self.use()
        p = self.j.shape[1]
        a, g = np.zeros((self.count, p, p)), np.zeros((self.count, p))
        np.add.at(a, self.block, w[:, None, None] * self.j[:, :, None] * self.j[:, None, :])
        np.add.at(g, self.block, (w * residual)[:, None] * self.j)
        return a, g

    def bootstrap(self, names, residual, seed=1):
        """Draws of the difference from the fit: blocks of the gradient, each as it is without its own pull on the fit. The priors are drawn as well."""
        a, g = self.sums(residual)
        used = np.flatnonzero(np.trace(a, axis1=1, axis2=2) > 0)
        n, p = len(used), self.j.shape[1]
        a, g = a[used], g[used]
        w = self.use()
        variance = float(np.sum(w * residual**2) / np.sum(w))
        penalty = self.prior(names)[1] * variance
        total = a.sum(0)
        total = total + np.diag(penalty) + 1e-9 * np.diag(np.diag(total) + 1e-12 * np.trace(total))
        g = (total @ np.linalg.solve(total - a, g[..., None]))[..., 0]
        g = g - g.mean(0)  # at the optimum it is 0 but for the prior's share and the last step
        source = np.random.default_rng(seed)
        draws = source.multinomial(n, np.full(n, 1 / n), size=DRAWS)
        wider = scipy.special.stdtrit(max(n - len(SYMMETRIC), 1), 0.975) / 1.96
        pull = np.sqrt(penalty * variance) * source.normal(size=(DRAWS, p))
        return np.linalg.solve(total, (wider * (draws @ g) + pull).T).T

    def left(self, residual):
        """Of the sum of squares, what is above the noise."""
        return max(self.rms(residual) ** 2 - (noise.OWN * self.noise()) ** 2, 0.0) * float(np.sum(self.use()))

    def model_half(self, names, residual):
        """Half of the intervals by the model's own error: what the fit leaves above the noise may be an error of any one."""
        return np.sqrt(np.diag(self.model_error(names, residual)))

    def model_error(self, names, residual):
        """The same as a covariance."""
        total = self.j.T @ (self.use()[:, None] * self.j) + np.diag(self.prior(names)[1] * self.rms(residual) ** 2)
        return self.left(residual) * np.linalg.pinv(total)

    def hysteresis_half(self, names, theta, residual):
        """Intervals of the hysteresis, 0 for the rest: the relays make the model jump, and a jump within the Jacobian's step is no knowledge. So only what both
        sides say counts."""
        here = self.j
        with ThreadPoolExecutor(2) as pool:
            self.sharp *= -1
            there = self.jacobian(names, theta, residual, pool)
            self.sharp *= -1
        self.j = np.where(here * there > 0, np.sign(here) * np.minimum(np.abs(here), np.abs(there)), 0.0)
        changes = self.bootstrap(names, residual)
        half = np.hypot((np.percentile(changes, 97.5, axis=0) - np.percentile(changes, 2.5, axis=0)) / 2, self.model_half(names, residual))
        self.j = here
        return np.where([n in HYSTERESIS for n in names], half, 0.0)


def start(log, rig, ways):
    """F = scale u + gravity - way (offset + slope F), over the faster slides, in which friction is nearest to L; and the rows of slow slides."""
    lag = sum(1 / rig[n] for n in ("actuator", "sensor") if rig[n] > 0) + rig["damping"] / rig["stiffness"]
    fast, slow = [], []
    for s, way in zip(log.segments, ways):
        size = bin_size(s.h)
        w, u, y = binned(way.astype(float), size), binned(s.u, size), binned(s.force, size)
        if len(y) < 5:
            continue
        rate = np.gradient(scipy.ndimage.median_filter(y, 3), size * s.h)
        steady = np.abs(scipy.ndimage.minimum_filter1d(np.sign(rate), 5) + scipy.ndimage.maximum_filter1d(np.sign(rate), 5)) == 2
        on = steady & (np.abs(rate) > 0.3 * np.percentile(np.abs(rate), 98))
        for rows, direction, mask in ((fast, np.sign(rate), on), (slow, w, np.abs(w) == 1)):
            rows.append(np.c_[u, np.ones(len(u)), -direction, -direction * np.abs(y), y + lag * rate, y][mask])
    fast, slow = np.concatenate(fast), np.concatenate(slow)
    rows = fast if len(fast) > 20 and len(set(fast[:, 2])) == 2 else slow
    matrix, target = rows[:, :4], rows[:, 4]
    keep = np.ones(len(rows), bool)
    for _ in range(4):
        solution = np.linalg.lstsq(matrix[keep], target[keep], rcond=None)[0]
        error = np.abs(target - matrix @ solution)
        keep = error <= 4 * np.median(error) + 1e-12
    return solution, slow


def rig_of(lag_s):
    """A rig whose lags add up to one that was found: a third each in the arm, the sensor and the delay."""
    part = max(lag_s / 3, 5e-4)
    k = native.PAPER["stiffness"]
    return {"actuator": 0.0, "sensor": 1 / part, "damping": k * part, "inertia": k * part**2 / 2}, lag_s - 2 * part


def slow_rows(log, ways):
    """u, F and way of slow slides, averaged."""
    rows = []
    for s, way in zip(log.segments, ways):
        size = bin_size(s.h)
        w = binned(way.astype(float), size)
        rows.append(np.c_[binned(s.u, size), binned(s.force, size), w][np.abs(w) == 1])
    return np.concatenate(rows)


def ripple_of(rows, line):
    """Amplitude of what u has to overcome beside the line and friction, the same in both directions: periodic in position, so in F."""
    u, force, way = rows.T
    p = line.law()
    net = p["scale"] * u + p["gravity"] - force - way * line.breakaway(force, way)
    edges = np.linspace(force.min(), force.max(), 61)
    place = np.clip(np.digitize(force, edges) - 1, 0, 59)
    common = []
    for i in range(60):
        up, down = net[(place == i) & (way > 0)], net[(place == i) & (way < 0)]
        if len(up) > 2 and len(down) > 2:
            common.append((np.median(up) + np.median(down)) / 2)
    return float(np.sqrt(2) * np.std(common)) if len(common) > 5 else 0.0


def _verdict(name, value, half):
    if name in ("gravity", "delay"):
        return "identified"
    part = half / max(abs(value), 1e-12)
    if name in HYSTERESIS:
        return "identified" if part <= 0.15 else "weak" if part <= 0.5 else "not identifiable"
    if name in ("scale",):
        return "identified" if part <= 0.05 else "weak"
    return "identified" if part <= 0.2 else "weak"


def identify(log, rig=None, assume="symmetric", allow_slides=True):
    """The parameters of the friction that the log shows, or Refusal. `rig` has what is known of actuator, sensor, damping, stiffness, inertia, delay; without it the
    lags are found. `assume` is symmetric, calibrated, or None if neither is known: then symmetric, and what it rests on is weak. `allow_slides`: the slides'
    line may take the place of the model's breakaway and command; else it is not asked."""
    progress.at(f"looks for slides in {log.rows} rows")
    check(log)
    events, ways = find(log)
    check_events(log, events)
    line = slides.line(log, assume or "symmetric") if allow_slides else _guess(log, rig, ways, assume)
    if line is None:
        raise Refusal("few loads", "few loads: F slides both ways too seldom; four loads at least, each from both sides")
    slow = slow_rows(log, ways)
    load = float(np.median(slow[:, 1]))
    level = float(np.mean([line.breakaway(load, way) for way in (1, -1)]))
    _plausible(log, line, assume, level)
    shown = residual.shows(log, assume or "symmetric", level)
    _stiction(log, line, level, load, shown)
    ripple = ripple_of(slow, line)
    if ripple > level:
        raise Refusal("ripple", "ripple: " + (shown[0] if shown else f"u has to overcome {ripple:.3g} N that changes with position, more than breakaway, {level:.3g} N; average over whole turns, or take it out of u"))
    found = not rig and line.is_sure() and line.error < DOUBT / 3 * level
    rig, expected = rig_of(max(line.lag_s, 1e-3)) if found else (rig or {}, 0.0)
    fit = Fit(log, events, rig, assume)
    fit.level, fit.delay_s = level, expected
    names = list(SYMMETRIC if assume != "calibrated" else CALIBRATED)
    least = {"offset": 0.02 * level, "slope": 0.0}
    theta = [max(line.values[n], least.get(n.split("_")[0], -np.inf)) for n in names]
    progress.at(f"fits friction to {log.rows} rows")
    few = _short(fit, log, events, rig, assume)
    theta, left, said = _whole(fit, *_best(few, names, theta, line))
    names = [*names, *fit.rest]
    remarks = list(log.remarks) + said
    if held := held_s(log):
        remarks.append(f"u changes each {held:.3g} s only: if the drive's command changes in between, log it as often as F")
    by_slides = _by_slides(fit, line, left)
    if by_slides:
        names, theta, left = _rest(fit, line, names, theta)
    delay = float(fit.params(names, theta)[0]["delay"])
    early = delay < -3 * log.sample_time_s - 0.003
    if early and not rig and not by_slides and PAPER_LAG_S + delay > 0:  # lags that nobody gave are shorter
        return identify(log, rig_of(PAPER_LAG_S + delay)[0], assume, allow_slides)
    _explained(fit, left, level, shown)
    if not found and not by_slides and (early or delay > 0.1):
        raise _not_followed(log, line, delay, fit.rms(left), shown, level)
    return _finish(fit, names, theta, left, events, remarks, ripple, level, ways, line, by_slides, shown)


def calibrated(law):
    """Symmetric friction of a scaled command as L+ and L- of one that is right: at forces above 0 no log tells the two from each other."""
    scale, bias = law["scale"], law["gravity"]
    return {"offset_positive": (law["offset"] - bias) / scale, "slope_positive": (1 + law["slope"]) / scale - 1,
            "offset_negative": (law["offset"] + bias) / scale, "slope_negative": 1 - (1 - law["slope"]) / scale}


def _guess(log, rig, ways, assume):
    """A line that is only a start, of a log whose lags are known."""
    (scale, gravity, offset, slope), _ = start(log, {**native.PAPER, **(rig or {})}, ways)
    law = {"offset": offset, "slope": slope, "scale": scale, "gravity": gravity}
    return slides.Line(calibrated(law) if assume == "calibrated" else law, 0.0, np.inf, 0, np.zeros((0, 4)), np.zeros(0, int))


def _early(log):
    """The least lag that u and F of one clock may seem to have."""
    return -3 * log.sample_time_s - 0.003


def _is_late(log, lag):
    """May F be so late at the turns?"""
    return EARLY_STEPS * rows.turn_step_s(log) <= lag <= LAG_MAX_S


def _plausible(log, line, assume, level):
    """Refuses what rows and slides show together: columns that are exchanged, a sign, stamps that are not of one clock, a unit."""
    scale, least = line.values.get("scale", 1.0), 0.2 if assume else 0.5
    late = line.is_sure() and not _early(log) <= line.lag_s <= LAG_MAX_S
    if level > 0 and least <= scale <= 1 / least and not late:
        return
    lag, share = rows.lag_at_turns(log)
    if hidden := noise.of(log).hides(level, max(np.ptp(s.force) for s in log.segments)):
        raise Refusal("noise", f"noise: {hidden}")
    if (level <= 0 or share < FOLLOWS) and _is_exchanged(log):
        raise Refusal("exchanged", "exchanged: u and F: F turns before u, which stands at each turn as F does because of friction. Name their columns the other way round (--column u=... --column F=...)")
    if _is_turned(log, scale, share):
        raise Refusal("sign", WRONG_SIGN)
    if share < FOLLOWS:
        raise other_unit(log) or Refusal("clock", f"clock: F does not follow u: at most {100 * share:.2g} % of the way of F goes the way of u, however late it is taken. Their stamps are not of one clock, one of them is another column, or a filter of F is slower than the motion")
    if not _is_late(log, lag):
        raise not_of_one_clock(log, lag)
    if shown := residual.shows(log, assume or "symmetric", abs(level)):
        raise Refusal("model", f"model: {shown[0]}")
    if scale < 0:
        raise Refusal("sign", WRONG_SIGN)
    if not least <= scale <= 1 / least:
        raise Refusal("units", f"units: F moves by {scale:.3g} N for a newton of u: one of them is not in N, as a sensor's volts are not, nor a drive's ampere; give its scale (--scale u={scale:.4g}, or --scale F=...)"
                      + ("" if assume or not 0.2 <= scale <= 5 else "; if both are, say so: --assume symmetric"))
    if late:
        raise not_of_one_clock(log, line.lag_s)


def _is_turned(log, scale, share):
    """Would F with the other sign follow u, and better? A turned F may seem to follow as well, before u."""
    lag, other = rows.lag_at_turns(rows.turned(log))
    return (share < FOLLOWS and (scale < 0 or other >= FOLLOWS)) or (other >= max(FOLLOWS, share) and _is_late(log, lag))


def _is_exchanged(log):
    """Would u for F, and F for u, be a log of friction?"""
    other = rows.exchanged(log)
    line = slides.line(other, "symmetric")
    if line is None or not 0.2 <= line.values["scale"] <= 5:
        return False
    lag, share = rows.lag_at_turns(other)
    load = float(np.median(np.abs(np.concatenate([s.force for s in other.segments]))))
    return share >= FOLLOWS and _is_late(other, lag) and line.breakaway(load, 1) > 0


def _stiction(log, line, level, load, shown):
    """Refuses friction that is not there: an answer of its own, if u and F are of one clock."""
    if not line.is_sure():
        if not level > 0:
            raise Refusal("sign", "friction would push the way that F goes: a sign is wrong, or u and F are not of the same time")
        return
    low, high = np.percentile(_middle(list(line.values), line.draws, load), [2.5, 97.5])
    if level <= max((high - low) / 2, 2 * line.error):
        lag, share = rows.lag_at_turns(log)
        if share >= FOLLOWS and not _is_late(log, lag):
            raise not_of_one_clock(log, lag)
        if shown and level > 0:
            raise Refusal("model", f"model: {shown[0]}")
        _hidden(log, line, level, (high - low) / 2)
        raise Refusal("no stiction", f"no stiction found: F follows u both ways with a lag of {1e3 * line.lag_s:.2g} ms, and friction is {level:.2g} +- {(high - low) / 2:.2g} N. There is nothing that compensation could take out")


def _hidden(log, line, level, half):
    """Refuses where noise, or the steps of u, leave room for friction that matters."""
    known, force = noise.of(log), max(np.abs(s.force).max() for s in log.segments)
    if known.beyond(line.error, noise.MEDIAN) < 0.5 * line.error and level + half > MATTERS * force:
        raise Refusal("noise", f"noise: {known.says(max(level, 0) + half, 0)[0]}: it hides up to {max(level, 0) + half:.3g} N")


def _middle_row(names, load):
    """What L at a load has of each, as the mean of both directions."""
    shares = {"offset": 1, "slope": load, "offset_positive": 0.5, "slope_positive": 0.5 * load, "offset_negative": 0.5, "slope_negative": 0.5 * load}
    return np.array([shares.get(n, 0.0) for n in names], float)


def _middle(names, draws, load):
    """The draws' changes of L at a load, the mean of both directions."""
    return draws @ _middle_row(names, load)


def _not_followed(log, line, delay, rms, shown, level):
    """The refusal of a log that the model follows only with a delay that nothing has."""
    lag, _ = rows.lag_at_turns(log)
    if said := noise.of(log).says(level, 2):
        return Refusal("noise", f"noise: {said[0]}")
    if lag is not None and _is_late(log, lag):
        if shown:
            return Refusal("ripple" if "pattern" in shown[0] else "model", f"model: {shown[0]}")
        few = (f"do not lie on a line: it leaves {line.error:.3g} N of them" if line.is_sure() else f"are too few: {slides.SURE} at least (tribo-identify plan makes 24, --repeats more)")
        return Refusal("model", f"model: inside stiction the friction is not the model's, which leaves {rms:.3g} N rms of F: it builds up, or falls, about the turns. The {line.slides} slides beyond them, which do "
                                f"without the model, {few}")
    return not_of_one_clock(log, delay, "the stamps of u and F are not of one clock, or the rig's lags are others than were taken (--actuator --sensor --lag)")


def _by_slides(fit, line, residual):
    """Does the line through the slides say it better than the model?"""
    if not line.is_sure() or fit.rms(residual) < NOISE * fit.noise():
        return False
    return line.error < float(np.median(np.abs(residual[line.rows])))


def _rest(fit, line, names, theta):
    """The hysteresis with breakaway and command as the slides have them."""
    fit.base, _ = fit.params(list(line.values), list(line.values.values()))
    return list(fit.rest), *fit.solve(fit.rest, theta[-len(fit.rest) :], 4)


def _short(fit, log, events, rig, assume):
    """The problem of the first rows only, for the choice of a start."""
    if log.rows <= START_ROWS:
        return fit
    segments, rows = [], 0
    for s in log.segments:
        n = min(len(s.t), START_ROWS - rows)
        if n * s.h < 1.0:
            break
        segments.append(replace(s, t=s.t[:n], u=np.ascontiguousarray(s.u[:n]), force=np.ascontiguousarray(s.force[:n])))
        rows += n
    few = Fit(replace(log, segments=segments), [e for e in events if e.segment < len(segments) and e.end <= len(segments[e.segment].t)], rig, assume)
    few.level, few.delay_s = fit.level, fit.delay_s
    return few if len(few.events) >= 8 else fit


def _valleys(fit, names, theta):
    """Starts for the whole log, best first: Gauss-Newton goes down into more than one valley."""
    names, grid = [*names, "k_min"], []
    for k in K_STARTS:
        for times in L_STARTS:
            at = [*(x * times if n.startswith(("offset", "slope")) else x for n, x in zip(names, theta)), np.log(k)]
            grid.append(_tried(fit, names, *fit.solve(names, at, 1)))
    grid = [_tried(fit, names, *fit.solve(names, at, 4)) for _, at in sorted(grid, key=lambda g: g[0])[:VALLEYS]]
    rest = fit.prior(fit.rest[1:])[0]
    return [np.r_[at, rest] for _, at in sorted(grid, key=lambda g: g[0])]


def _tried(fit, names, theta, residual):
    """Half-cycles that go astray count little in the choice."""
    return float(np.mean(np.abs(residual))), theta


def _best(fit, names, theta, line):
    """The best of the fits that begin in each valley; two are enough where the line through the slides says it far better."""
    best = None
    starts = _valleys(fit, names, theta)
    names = [*names, *fit.rest]
    fit.step(FINE_S)
    for tried, at in enumerate(starts):
        fit.weight[:] = 1.0
        theta, residual, said = _descend(fit, names, _slow(fit, names, at))
        rms = fit.rms(residual)
        if best is None or rms < best[0]:
            best = rms, theta, residual, said, fit.weight.copy(), fit.j
        if best[0] < NOISE * fit.noise() or tried and line.is_sure() and line.error < 0.5 * float(np.median(np.abs(best[2]))):
            break
    fit.weight, fit.j = best[4:]
    return fit, names, *best[1:4]


def _descend(fit, names, theta):
    iterations = fit.iterations()
    fit.sharp = 1.0
    theta, residual = fit.solve(names, theta, iterations)
    said = _leave_out(fit, residual)
    fit.sharp = SHARP
    return *fit.solve(names, theta, iterations), said


def _whole(fit, few, names, theta, residual, said):
    """From the fit to the first rows that to all rows."""
    if fit is few:
        return theta, residual, said
    fit.step(FINE_S)
    residual = fit.residual(names, theta)
    if np.median(np.abs(residual)) > 0.6745 * NOISE * fit.noise():
        return _descend(fit, names, _slow(fit, names, theta))
    fit.sharp = SHARP
    said = _leave_out(fit, residual)  # else as good as it gets: once more, with all rows
    return *fit.solve(names, theta, fit.iterations()), said


def _slow(fit, names, theta):
    """k_max and v0 of the start, by the slow ramps of the whole log: the best of a grid."""
    grid = []
    for a in (1.0, 0.5, 1.7):
        for b in (1.0, 0.6, 1.6):
            there = np.array(theta, float)
            there[names.index("k_max")] += np.log(a)
            there[names.index("v0")] += np.log(b)
            grid.append(there)
    return min(grid, key=lambda t: float(np.sum(fit.residual(names, t) ** 2)))


def _leave_out(fit, residual):
    """Blocks that fit far worse than the others."""
    w = ~fit.full
    rms = np.sqrt(np.bincount(fit.block, w * residual**2, fit.count) / np.maximum(np.bincount(fit.block, w, fit.count), 1))
    bad = rms > 6 * np.median(rms) + 1e-9
    if bad.mean() > 0.3:
        return [f"{bad.sum()} of {fit.count} half-cycles fit far worse than the others; none is left out"]
    fit.weight[bad] = 0.0
    return [f"{bad.sum()} of {fit.count} half-cycles fit far worse than the others and are left out"] if bad.any() else []


def _own(fit, names, residual, L_columns):
    """By how much each event's own L differs from the fitted, from its block alone."""
    column = fit.j[:, L_columns].sum(1)
    w = fit.use()
    up = np.bincount(fit.block, w * column * residual, fit.count)
    down = np.bincount(fit.block, w * column**2, fit.count)
    return up / np.maximum(down, 1e-300), down


def _table(fit, names, theta, residual, events, level):
    """Deviation from the line by load, its size and probability; loads for a table."""
    offset_at = [i for i, n in enumerate(names) if n.startswith("offset")]
    own, sure = _own(fit, names, residual, offset_at)
    seen = {}
    for i, e in enumerate(events):
        b = fit.of_event[i]
        e.error, e.weight = float(own[b]), float(fit.weight[b])
        if fit.weight[b] > 0 and sure[b] > 1e-3 * np.median(sure[sure > 0]):
            seen.setdefault(b, []).append(((e.low + e.high) / 2, e.way))
    if len(seen) < 8:
        return (0.0, 1.0), None
    where = np.array([np.mean([f for f, _ in v]) for v in seen.values()])
    error = np.array([own[b] for b in seen])
    count = min(max(len(seen) // 4, 4), 8)
    edges = np.quantile(where, np.linspace(0, 1, count + 1))
    group = np.clip(np.searchsorted(edges, where, "right") - 1, 0, count - 1)
    groups = [g for g in range(count) if np.sum(group == g) >= 2]
    if len(groups) < 4:
        return (0.0, 1.0), None
    at = np.array([where[group == g].mean() for g in groups])
    mean = np.array([np.median(error[group == g]) for g in groups])
    line = np.polyfit(at, mean, 1)
    off = mean - np.polyval(line, at)
    within = np.concatenate([error[group == g] - error[group == g].mean() for g in groups])
    free = len(within) - len(groups)
    number = np.array([np.sum(group == g) for g in groups])
    between = float(np.sum(number * off**2)) / (len(groups) - 2)
    f = between / max(float(within @ within) / max(free, 1), 1e-300)
    chance = float(scipy.stats.f.sf(f, len(groups) - 2, max(free, 1)))
    return (float(np.max(np.abs(off)) / level), chance), at


def _rate_effect(events, level):
    """Relative change of breakaway for ten times the ramp's rate, from the events."""
    rate = np.array([e.rate for e in events if e.weight > 0 and e.rate > 0])
    error = np.array([e.error for e in events if e.weight > 0 and e.rate > 0])
    if len(rate) < 6 or rate.max() < 2 * rate.min():
        return 0.0
    return float(np.polyfit(np.log10(rate), error, 1)[0] / level)


def _finish(fit, names, theta, residual, events, remarks, ripple, level, ways, guess, by_slides, shown):
    line = guess if by_slides else None
    lack, at = _table(fit, names, theta, residual, events, level) if line is None else ((0.0, 1.0), None)
    if at is not None and lack[0] > 0.1 and lack[1] < 0.01:
        names, theta = _to_table(fit, names, theta, at)
        theta, residual = fit.solve(names, theta)
        remarks.append(f"breakaway is no line: off by up to {100 * lack[0]:.2g} % at a load (by chance: {lack[1]:.1g}); a table of {len(at)} loads")
    changes = fit.bootstrap(names, residual)
    half = np.hypot((np.percentile(changes, 97.5, axis=0) - np.percentile(changes, 2.5, axis=0)) / 2, fit.model_half(names, residual))
    half, error = np.maximum(half, fit.hysteresis_half(names, theta, residual)), fit.model_error(names, residual) if line is None else None
    if line is not None:  # what the slides say, in front of the rest
        names, theta, changes = [*line.values, *names], [*line.values.values(), *theta], np.c_[line.draws, changes]
        half = np.r_[(np.percentile(line.draws, 97.5, axis=0) - np.percentile(line.draws, 2.5, axis=0)) / 2, half]
    estimates = [_estimate(fit, name, value, h) for name, value, h in zip(names, theta, half)]
    params, table = fit.params(names, theta)
    both, _ = loads([(e.way, e.low, e.high) for e in events] if not by_slides else slides.spans(fit.log))
    if not both:
        raise Refusal("few loads", "few loads: F breaks away both ways at none; approach every load from both sides")
    result = Result(estimates, params, table, events, fit.model(names, theta), fit.rms(residual), _hold_out(fit, residual), ripple, params["delay"], both, fit.assume, remarks, lack_of_fit=lack)
    result.rate_effect = _rate_effect(events, level)
    result.L_half = _relative_half(fit, names, np.array(theta, float), changes, both, error)
    result.noises = noise.of(fit.log)
    result.slide_gap = _slide_gap(fit, result, ways)
    result.line_error = None if line is None else line.error
    result.fall = slides.fall(fit.log, guess) if guess.is_sure() else (0.0, np.inf)
    result.shown = shown
    _judge(fit, result, level)
    return result


def _estimate(fit, name, value, half):
    if name in LOGARITHMIC:
        value, half = float(np.clip(np.exp(value), *BOUNDS[name])), float(np.exp(value) * np.expm1(min(half, 5.0)))
    verdict, remark = _verdict(name.split("_")[0] if name.startswith("table") else name, value, half), ""
    if verdict == "not identifiable":
        remark = f"not shown by this log; {EXPERIMENT[name]} would"
    elif verdict == "weak":
        remark = EXPERIMENT.get(name, "more repeats, more loads or less noise would narrow it")
    if name.startswith("table"):
        name = f"L{'-' if 'minus' in name else ''}({fit.table_at[int(name.split('_')[-1])]:.4g} N)"
    return Estimate(name, float(value), float(half), verdict, remark)


def _to_table(fit, names, theta, at):
    values = dict(zip(names, theta))
    fit.table_at = [float(x) for x in at]
    rest = [n for n in names if not n.startswith(("offset", "slope"))]
    table = {}
    if fit.assume != "calibrated":
        table = {f"table_{i}": values["offset"] + values["slope"] * x for i, x in enumerate(at)}
    else:
        table = {f"table_{i}": values["offset_positive"] + values["slope_positive"] * x for i, x in enumerate(at)}
        table |= {f"table_minus_{i}": values["offset_negative"] + values["slope_negative"] * x for i, x in enumerate(at)}
    return [*table, *rest], [*table.values(), *(values[n] for n in rest)]


def _relative_half(fit, names, theta, changes, both, error=None):
    """Half of the interval of L in the middle of the loads, over it, by the draws and by the model's `error`, a covariance."""
    middle = abs(both[0][0] + both[-1][1]) / 2  # as far as L knows of it
    row = np.array([n == f"table_{int(np.argmin(np.abs(np.array(fit.table_at) - middle)))}" for n in names], float) if fit.table_at is not None else _middle_row(names, middle)
    L, spread = float(row @ theta), changes @ row
    half = np.hypot((np.percentile(spread, 97.5) - np.percentile(spread, 2.5)) / 2, 0.0 if error is None else np.sqrt(row @ error @ row))
    return float(half / max(L, 1e-12))


def _hold_out(fit, residual):
    """Every fourth block out, the fit to the others, and its rms there over theirs."""
    a, g = fit.sums(residual)
    out = np.arange(fit.count) % 4 == 2
    if not out.any() or not (fit.weight[out] > 0).any():
        return 1.0
    change = np.linalg.lstsq(a[~out].sum(0), g[~out].sum(0), rcond=None)[0]
    left = residual - fit.j @ change
    w, held = fit.use(), out[fit.block]
    inside, outside = (np.sqrt(np.sum((w * left**2)[m]) / max(np.sum(w[m]), 1)) for m in (~held, held))
    return float(outside / max(inside, 1e-300))


def breakaway(params, table, force):
    """L+ and L- at forces."""
    load = np.abs(force)
    if table:
        at, plus, minus = np.array(table).T
        return np.interp(load, at, plus), np.interp(load, at, minus)
    return tuple(params[f"offset_{way}"] + params[f"slope_{way}"] * load for way in ("positive", "negative"))


def _slide_gap(fit, result, ways):
    """Of slow slides, which count little in the fit beside what moves fast: friction seen less the model's in the same rows, so with the same lag, over L; and half of the
    interval, by how much slides differ. The mean of both directions, which no bias of u moves."""
    gaps = {1: [], -1: []}
    for s, way, model in zip(fit.log.segments, ways, result.model):
        for w, L in zip((1, -1), breakaway(result.params, result.table, s.force)):
            on = np.flatnonzero(way == w)
            gaps[w] += [w * (model[k] - s.force[k]) / L[k] for k in np.split(on, np.flatnonzero(np.diff(on) > 1) + 1) if len(k)]
    found = [(float(np.median(np.concatenate(g))), slides.half_of([np.median(one) for one in g])) for g in gaps.values() if g]
    return (float(np.mean([gap for gap, _ in found])), float(np.mean([half for _, half in found]))) if found else (0.0, np.inf)


def _explained(fit, residual, level, shown):
    rms = fit.rms(residual)
    known = noise.of(fit.log)
    if known.beyond(rms) > 0.25 * level:
        lag, share = rows.lag_at_turns(fit.log)
        if share >= FOLLOWS and not _is_late(fit.log, lag):  # few slides may have hidden it before
            raise not_of_one_clock(fit.log, lag)
        if said := known.says(level, 2):
            raise Refusal("noise", f"noise: {said[0]}")
        raise Refusal("model", f"model: {shown[0]}" if shown else f"the model does not explain the log: F is off by {rms:.3g} N rms, where breakaway is {level:.3g} N; no answer is better than this one")


def by_direction(result, force):
    """L+ and L- if u is right, of a fit that took them as alike."""
    scale, bias, L = result.params["scale"], result.params["gravity"], float(breakaway(result.params, result.table, force)[0])
    return (force + L - bias) / scale - force, force - (force - L - bias) / scale


def _readings(result):
    """What a scale other than 1 may be: u's, F's, or friction that differs by direction and grows with u, if L+ and L- are then above 0."""
    scale = next((e for e in result.estimates if e.name == "scale"), None)
    if scale is None:
        return []
    ways, ends = [], (result.loads[0][0], result.loads[-1][1])
    off = abs(scale.value - 1)
    # Where L is a small part of F, a scale that is hardly off is friction that differs by much.
    apart = max(2 * max(off, scale.half) * abs(force) / float(breakaway(result.params, result.table, force)[0]) for force in ends)
    if off <= max(scale.half, GAP) and apart <= APART:
        return []
    for force in ends:
        ways.append(by_direction(result, force))
    law = [", ".join(f"{L:.3g} N at {load:.3g} N" for L, load in zip(column, ends)) for column in zip(*ways)]
    asymmetric = f", or friction is asymmetric and u is right: L+ {law[0]}; L- {law[1]}" if np.min(ways) > 0 else ""
    return [f"either your command makes {scale.value:.4g} N for 1 N, or F is not in N (--scale F=...){asymmetric}. This log cannot tell: say --assume symmetric"
            + (" or --assume calibrated (which fits L+ and L- each)" if asymmetric else " if F is in N")]


def _doubts(result, level):
    """What casts doubt on all of it. What the residual of the slides shows is the reason of whatever else would be said."""
    found = list(_misfits(result, level, result.noises, result.slide_gap[1]))
    if not found and (seen := list(_misfits(result, level, noise.NONE, 0.0))):  # noise explains it, and may hide as much
        found = result.noises.says(level, 0.0)[:1] or seen
    if found and result.noises.u > noise.NAMED["u"] * level:  # the model takes it as commanded, and that loosens all that sticks
        found = [result.noises.sentence("u", level)]
    yield from result.shown if result.shown and (found or result.line_error is not None) else found
    if result.assume is None:
        yield from _readings(result)


def _misfits(result, level, known, gap_half):
    """What the log has and the model has not, beyond the noise and the steps of u that are known."""
    left = known.beyond(result.residual_rms)
    if result.line_error is None:
        gap = result.slide_gap[0]
        if left > DOUBT * level:
            yield f"F is off by {left:.3g} N rms, {100 * left / level:.2g} % of breakaway: the friction differs from the model's"
        if result.held_out > 2.5:
            yield f"half-cycles that were held out fit {result.held_out:.2g} times worse"
        if abs(gap) > max(GAP, result.L_half, gap_half, known.rounding / level):
            yield f"friction in slow slides differs from the model's by {100 * gap:+.2g} %, beyond the interval of L: breakaway and sliding are not the model's"
        if result.ripple > 0.3 * level and left > DOUBT / 3 * level:  # a model that follows F leaves no room for one
            yield f"a ripple of {result.ripple:.3g} N with position, {100 * result.ripple / level:.2g} % of breakaway: average over whole turns"
    elif (left := known.beyond(result.line_error, noise.MEDIAN)) > DOUBT / 3 * level:
        yield f"slides differ from a line by {left:.3g} N, {100 * left / level:.2g} % of breakaway: their friction is not offset + slope |F|"
    share, half = result.fall
    if share > FALL + half:
        L = breakaway(result.params, result.table, np.mean([result.loads[0][0], result.loads[-1][1]]))[0]
        yield (f"friction falls once it slides: breakaway is {100 * share:.2g} +- {100 * half:.1g} % above sliding, {(1 + share) * L:.3g} N for {L:.3g} N in the middle of the loads; "
               "the parameters are those of sliding")


def _judge(fit, result, level):
    doubts = list(_doubts(result, level))
    result.remarks += [text for text in result.noises.says(level) if text not in doubts]
    if result.residual_rms > DOUBT / 3 * level or result.line_error is not None:
        for e in result.estimates:
            if e.name in HYSTERESIS and e.verdict == "identified":
                e.verdict, e.remark = "weak", "the model does not follow the log closely enough to tell it"
    result.remarks += doubts
    if doubts:
        for e in result.estimates:
            if e.verdict == "identified":
                e.verdict = "weak"
    if abs(result.rate_effect) > 0.1:
        result.remarks.append(f"breakaway differs from the model's by {100 * result.rate_effect:+.2g} % for ten times the ramp's rate")
    result.remarks += _readings(result) if result.assume else []
    if result.assume != "calibrated":
        result.remarks.append("L+ = L- is assumed, which tells scale and bias of u; without it only L+ + L- is known (--assume calibrated: u is right, L+ and L- may differ)")
    else:
        result.remarks.append("u is taken as right, so that L+ and L- are told apart; a bias of u would show as their difference")


def line_of(result):
    return [f"{DESCRIBED.get(e.name, e.name):<18}{e.value:11.5g}"
            + (f" +- {e.half:<9.2g}" if np.isfinite(e.half) else " " * 13) + f" {UNITS.get(e.name, ''):<4}{e.verdict}" + (f": {e.remark}" if e.remark else "") for e in result.estimates]
