"""tribo-identify friction: finds breakaway, command scale and hysteresis from logs.

1. Start: the events (events.py) and the line through the slides (slides.py) give the first values, and the lags if none are given.
2. Output error: the library's compensator plays u (native.c) and must reproduce the recorded F. Gauss-Newton minimises the error over averages of 20 ms;
   blocks that fit far worse than the others are left out and reported. A delay between u and F is found first.
3. Intervals: block bootstrap. A block is a half-cycle, from one break-away to the next in the other direction, so that the number of repeats counts and
   not the number of samples. Each draw solves the linearised fit again; Student's t accounts for the number of blocks.
4. If the model does not follow the log and the line does so better, breakaway and command come from the line.
5. Lack of fit: the deviation of each block's own L, over the loads, is compared with the scatter between repeats at one load. If that refuses a line, a
   table replaces it.
6. Hold-out: a quarter of the blocks is held out and must fit as well as the others.
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

STEPS_MAX = 10_000_000  # of a simulation; beyond them the steps get longer
K_STARTS = (3.0, 5.0, 8.0, 14.0)  # starts of k_min; the fit has more than one minimum
APART = 0.08  # of L: a smaller difference between L+ and L- does no harm
L_STARTS = (1.0, 1.2, 1.5, 2.0)  # starts of L divided by the friction of slow slides
SHARP = 0.3  # factor of the Jacobian's steps near the end: with smaller steps the relays make the model rough, with larger ones it is curved
VALLEYS = 4  # minima that are searched
NOISE = 1.5  # times the noise of the averages: with so small an error no other minimum is deeper
FALL = 0.015  # of L: a larger fall of friction from break-away to sliding is reported
GAP = 0.005  # of L: possible error, in slow slides, of the median of a noisy log
EARLY_STEPS = -1.5  # steps between the lags that are tried at the turns: an F that comes earlier was not driven by u
FOLLOWS = 0.85  # of the travel of F must be in the direction of u
MATTERS = 0.01  # of the largest force: less friction counts as none
DOUBT = 0.03  # of L: a larger residual casts doubt on L, a third of it on hysteresis
ROWS_MAX = 2_400_000  # of all iterations together
START_ROWS = 60_000  # of a log are used to choose its start
FINE_S = 1e-4  # step of the fits
COARSE_S = 5e-4  # step for the choice of their starts
DRAWS = 999
SYMMETRIC = ("offset", "slope", "scale", "gravity")
CALIBRATED = ("offset_positive", "slope_positive", "offset_negative", "slope_negative")
HYSTERESIS = ("k_min", "k_max", "m", "v0")
REST = ("k_min", "k_max", "v0", "m", "delay")
# Parameters that a log may not show have a prior around the paper's values (as logarithms) or 0. The prior is part of the intervals of all others.
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
    table: list  # (F, L+, L-); empty if breakaway is a line
    events: list
    model: list  # F by segment
    residual_rms: float
    held_out: float  # rms of the held-out blocks divided by that of the others
    ripple: float
    delay_s: float
    loads: list
    assume: str
    remarks: list = field(default_factory=list)
    L_half: float = 0.0  # of L in the middle of the loads, relative
    rate_effect: float = 0.0  # of breakaway, relative, for ten times the rate
    slide_gap: tuple = (0.0, np.inf)  # measured friction in slow slides less the model's, divided by L; and half of its interval
    noises: noise.Noise = field(default_factory=lambda: noise.Noise(0.0, 0.0, 0.0))  # noise that no model follows; that of u is in units of F
    line_error: float | None = None  # N; set if the line through the slides gave breakaway and command
    fall: tuple = (0.0, np.inf)  # relative fall of friction from break-away to sliding, and half of its interval
    shown: list = field(default_factory=list)  # sentences on patterns in the residual of the slides
    lack_of_fit: tuple = (0.0, 1.0)  # largest relative deviation from the line, and the probability that it is chance


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
        self.sharp = 1.0  # factor of the Jacobian's steps
        self.table_at = None  # loads of a table
        self.delay_s = 0.0  # expected delay
        self.weight = np.ones(self.count)

    def step(self, step_s):
        wanted = max(int(np.ceil(self.log.sample_time_s / step_s - 1e-6)), 1)
        self.substeps = max(min(wanted, STEPS_MAX // max(self.log.rows, 1)), 1)

    def iterations(self):
        """Returns the number of iterations: fewer for a long log, because the fit to its first rows is a good start."""
        return max(min(8, ROWS_MAX // max(self.log.rows, 1)), 2)

    def _blocks(self):
        """Cuts the log into blocks. A block begins with each segment, and where F breaks away in another direction than before."""
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
        """Returns the averaged outputs for several parameter sets, one row each."""
        params, tables = zip(*(self.params(names, theta) for theta in thetas))
        pieces = []
        for s, y0 in zip(self.log.segments, self.start):
            y = native.simulate_sets(params, s.u, s.h, y0, self.substeps, tables)
            pieces.append([binned(one, self.size) for one in y])
        return np.concatenate(pieces, axis=1)

    def residual(self, names, theta):
        return self.y - self.outputs(names, [theta])[0]

    def noise(self):
        """Returns the noise of the averages of F, from their second differences."""
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
        """Returns the means and inverse variances of the priors."""
        mean = np.array([np.log(native.PAPER[n]) if n in LOGARITHMIC else self.delay_s if n == "delay" else 0.0 for n in names])
        return mean, np.array([1 / PRIOR[n] ** 2 if n in PRIOR else 0.0 for n in names])

    def solve(self, names, theta, iterations=8, j=None):
        """Gauss-Newton with damping. Keeps a Jacobian, `j` or the last one, as long as it helps."""
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
                if gain < 0.3:  # the next step needs a new Jacobian
                    self.j, j = j, None
                fresh = False
            self.j = self.j if j is None else j
        return theta, residual

    def _within(self, names, theta):
        """Limits theta to what the library accepts: offsets above 0, slopes of at least 0."""
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
        """Returns J'J and J'r of each block."""
        w = self.use()
        p = self.j.shape[1]
        a, g = np.zeros((self.count, p, p)), np.zeros((self.count, p))
        np.add.at(a, self.block, w[:, None, None] * self.j[:, :, None] * self.j[:, None, :])
        np.add.at(g, self.block, (w * residual)[:, None] * self.j)
        return a, g

    def bootstrap(self, names, residual, seed=1):
        """Returns draws of the difference from the fit. Draws blocks of the gradient, each corrected for its own influence on the fit, and the priors as well."""
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
        g = g - g.mean(0)  # at the optimum the mean is 0 except for the prior's share and the last step
        source = np.random.default_rng(seed)
        draws = source.multinomial(n, np.full(n, 1 / n), size=DRAWS)
        wider = scipy.special.stdtrit(max(n - len(SYMMETRIC), 1), 0.975) / 1.96
        pull = np.sqrt(penalty * variance) * source.normal(size=(DRAWS, p))
        return np.linalg.solve(total, (wider * (draws @ g) + pull).T).T

    def left(self, residual):
        """Returns the part of the sum of squares above the noise."""
        return max(self.rms(residual) ** 2 - (noise.OWN * self.noise()) ** 2, 0.0) * float(np.sum(self.use()))

    def model_half(self, names, residual):
        """Returns half of the intervals due to the model's own error: the residual above the noise may be an error of any one parameter."""
        return np.sqrt(np.diag(self.model_error(names, residual)))

    def model_error(self, names, residual):
        """Returns the model's own error as a covariance."""
        total = self.j.T @ (self.use()[:, None] * self.j) + np.diag(self.prior(names)[1] * self.rms(residual) ** 2)
        return self.left(residual) * np.linalg.pinv(total)

    def hysteresis_half(self, names, theta, residual):
        """Returns half of the intervals of the hysteresis parameters, 0 for the others. The relays make the model jump, and a jump within the Jacobian's step carries
        no information. So each derivative counts only as far as both one-sided differences agree on it."""
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
    """Fits F = scale u + gravity - way (offset + slope |F|) to the faster slides, in which friction is closest to L. Returns the values and the rows of slow slides."""
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
    """Returns a rig whose lags add up to `lag_s`, a third each in the arm, the sensor and the delay; and that delay."""
    part = max(lag_s / 3, 5e-4)
    k = native.PAPER["stiffness"]
    return {"actuator": 0.0, "sensor": 1 / part, "damping": k * part, "inertia": k * part**2 / 2}, lag_s - 2 * part


def slow_rows(log, ways):
    """Returns u, F and direction of slow slides, averaged."""
    rows = []
    for s, way in zip(log.segments, ways):
        size = bin_size(s.h)
        w = binned(way.astype(float), size)
        rows.append(np.c_[binned(s.u, size), binned(s.force, size), w][np.abs(w) == 1])
    return np.concatenate(rows)


def ripple_of(rows, line):
    """Returns the amplitude of the force that u must overcome in addition to line and friction, the same in both directions: it is periodic in position, and so in F."""
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
    """Returns the friction parameters that the log shows, or raises Refusal. `rig` has the known ones of actuator, sensor, damping, stiffness, inertia and delay; without
    it the lags are found. `assume` is symmetric, calibrated, or None if neither is known: then symmetric is used, and every value that rests on it is weak. With
    `allow_slides` the line through the slides may replace the model's breakaway and command; otherwise that line is not computed."""
    progress.at(f"looks for slides in {log.rows} rows")
    check(log)
    events, ways = find(log)
    check_events(log, events)
    line = slides.line(log, assume or "symmetric") if allow_slides else _guess(log, rig, ways, assume)
    if line is None:
        raise Refusal("few loads", "few loads: F slides both ways too seldom; at least four loads are needed, each from both sides")
    slow = slow_rows(log, ways)
    load = float(np.median(slow[:, 1]))
    level = float(np.mean([line.breakaway(load, way) for way in (1, -1)]))
    _plausible(log, line, assume, level)
    shown = residual.shows(log, assume or "symmetric", level)
    _stiction(log, line, level, load, shown)
    ripple = ripple_of(slow, line)
    if ripple > level:
        raise Refusal("ripple", "ripple: " + (shown[0] if shown else f"u must overcome a force of {ripple:.3g} N that changes with position, more than the breakaway of {level:.3g} N; average over whole turns, or subtract this force from u"))
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
        remarks.append(f"u changes only every {held:.3g} s: if the drive's command changes in between, log it as often as F")
    by_slides = _by_slides(fit, line, left)
    if by_slides:
        names, theta, left = _rest(fit, line, names, theta)
    delay = float(fit.params(names, theta)[0]["delay"])
    early = delay < -3 * log.sample_time_s - 0.003
    if early and not rig and not by_slides and PAPER_LAG_S + delay > 0:  # no lags were given: try shorter ones
        return identify(log, rig_of(PAPER_LAG_S + delay)[0], assume, allow_slides)
    _explained(fit, left, level, shown)
    if not found and not by_slides and (early or delay > 0.1):
        raise _not_followed(log, line, delay, fit.rms(left), shown, level)
    return _finish(fit, names, theta, left, events, remarks, ripple, level, ways, line, by_slides, shown)


def calibrated(law):
    """Converts symmetric friction with a scaled command into L+ and L- with a correct command: at forces above 0 no log tells the two apart."""
    scale, bias = law["scale"], law["gravity"]
    return {"offset_positive": (law["offset"] - bias) / scale, "slope_positive": (1 + law["slope"]) / scale - 1,
            "offset_negative": (law["offset"] + bias) / scale, "slope_negative": 1 - (1 - law["slope"]) / scale}


def _guess(log, rig, ways, assume):
    """Returns a line that serves only as a start, for a log whose lags are known."""
    (scale, gravity, offset, slope), _ = start(log, {**native.PAPER, **(rig or {})}, ways)
    law = {"offset": offset, "slope": slope, "scale": scale, "gravity": gravity}
    return slides.Line(calibrated(law) if assume == "calibrated" else law, 0.0, np.inf, 0, np.zeros((0, 4)), np.zeros(0, int))


def _early(log):
    """Returns the smallest lag that u and F of one clock can appear to have."""
    return -3 * log.sample_time_s - 0.003


def _is_late(log, lag):
    """Returns whether F can be so late at the turns."""
    return EARLY_STEPS * rows.turn_step_s(log) <= lag <= LAG_MAX_S


def _plausible(log, line, assume, level):
    """Refuses faults that rows and slides show together: exchanged columns, a wrong sign, stamps of two clocks, a wrong unit."""
    scale, least = line.values.get("scale", 1.0), 0.2 if assume else 0.5
    late = line.is_sure() and not _early(log) <= line.lag_s <= LAG_MAX_S
    if level > 0 and least <= scale <= 1 / least and not late:
        return
    lag, share = rows.lag_at_turns(log)
    if hidden := noise.of(log).hides(level, max(np.ptp(s.force) for s in log.segments)):
        raise Refusal("noise", f"noise: {hidden}")
    if (level <= 0 or share < FOLLOWS) and _is_exchanged(log):
        raise Refusal("exchanged", "exchanged: u and F: F turns before u, and u stands at each turn as F does with friction. Name their columns the other way round (--column u=... --column F=...)")
    if _is_turned(log, scale, share):
        raise Refusal("sign", WRONG_SIGN)
    if share < FOLLOWS:
        raise other_unit(log) or Refusal("clock", f"clock: F does not follow u: at most {100 * share:.2g} % of the travel of F has the direction of u, at any delay. Their time stamps come from different clocks, one of them is another column, or a filter of F is slower than the motion")
    if not _is_late(log, lag):
        raise not_of_one_clock(log, lag)
    if shown := residual.shows(log, assume or "symmetric", abs(level)):
        raise Refusal("model", f"model: {shown[0]}")
    if scale < 0:
        raise Refusal("sign", WRONG_SIGN)
    if not least <= scale <= 1 / least:
        raise Refusal("units", f"units: F moves by {scale:.3g} N for a newton of u: one of them is not in N but, for example, in a sensor's volts or a drive's amperes; give its scale (--scale u={scale:.4g}, or --scale F=...)"
                      + ("" if assume or not 0.2 <= scale <= 5 else "; if both are in N, add --assume symmetric"))
    if late:
        raise not_of_one_clock(log, line.lag_s)


def _is_turned(log, scale, share):
    """Returns whether F with the other sign would follow u better. A reversed F may also appear to follow u, but earlier than u."""
    lag, other = rows.lag_at_turns(rows.turned(log))
    return (share < FOLLOWS and (scale < 0 or other >= FOLLOWS)) or (other >= max(FOLLOWS, share) and _is_late(log, lag))


def _is_exchanged(log):
    """Returns whether the log would show friction with u and F exchanged."""
    other = rows.exchanged(log)
    line = slides.line(other, "symmetric")
    if line is None or not 0.2 <= line.values["scale"] <= 5:
        return False
    lag, share = rows.lag_at_turns(other)
    load = float(np.median(np.abs(np.concatenate([s.force for s in other.segments]))))
    return share >= FOLLOWS and _is_late(other, lag) and line.breakaway(load, 1) > 0


def _stiction(log, line, level, load, shown):
    """Refuses a log without friction; that is a valid answer if u and F are of one clock."""
    if not line.is_sure():
        if not level > 0:
            raise Refusal("sign", "friction would push in the direction of motion: a sign is wrong, or u and F are not of the same time")
        return
    low, high = np.percentile(_middle(list(line.values), line.draws, load), [2.5, 97.5])
    if level <= max((high - low) / 2, 2 * line.error):
        lag, share = rows.lag_at_turns(log)
        if share >= FOLLOWS and not _is_late(log, lag):
            raise not_of_one_clock(log, lag)
        if shown and level > 0:
            raise Refusal("model", f"model: {shown[0]}")
        _hidden(log, line, level, (high - low) / 2)
        raise Refusal("no stiction", f"no stiction found: F follows u both ways with a lag of {1e3 * line.lag_s:.2g} ms, and friction is {level:.2g} +- {(high - low) / 2:.2g} N. There is nothing to compensate")


def _hidden(log, line, level, half):
    """Refuses a log in which noise, or the steps of u, may hide friction that matters."""
    known, force = noise.of(log), max(np.abs(s.force).max() for s in log.segments)
    if known.beyond(line.error, noise.MEDIAN) < 0.5 * line.error and level + half > MATTERS * force:
        raise Refusal("noise", f"noise: {known.says(max(level, 0) + half, 0)[0]}: it hides up to {max(level, 0) + half:.3g} N")


def _middle_row(names, load):
    """Returns the share of each parameter in L at a load, as the mean of both directions."""
    shares = {"offset": 1, "slope": load, "offset_positive": 0.5, "slope_positive": 0.5 * load, "offset_negative": 0.5, "slope_negative": 0.5 * load}
    return np.array([shares.get(n, 0.0) for n in names], float)


def _middle(names, draws, load):
    """Returns the change of L at a load in each draw, as the mean of both directions."""
    return draws @ _middle_row(names, load)


def _not_followed(log, line, delay, rms, shown, level):
    """Returns the refusal of a log that the model follows only with a delay that no rig has."""
    lag, _ = rows.lag_at_turns(log)
    if said := noise.of(log).says(level, 2):
        return Refusal("noise", f"noise: {said[0]}")
    if lag is not None and _is_late(log, lag):
        if shown:
            return Refusal("ripple" if "pattern" in shown[0] else "model", f"model: {shown[0]}")
        few = (f"do not lie on a line: they are off by {line.error:.3g} N" if line.is_sure() else f"are too few: {slides.SURE} at least (tribo-identify plan makes 24, --repeats more)")
        return Refusal("model", f"model: inside stiction the friction is not the model's, which is off by {rms:.3g} N rms: friction builds up, or falls, near the turns. The {line.slides} slides beyond them, which need "
                                f"no such model, {few}")
    return not_of_one_clock(log, delay, "the time stamps of u and F come from different clocks, or the rig's lags differ from those used (--actuator --sensor --lag)")


def _by_slides(fit, line, residual):
    """Returns whether the line through the slides describes the log better than the model."""
    if not line.is_sure() or fit.rms(residual) < NOISE * fit.noise():
        return False
    return line.error < float(np.median(np.abs(residual[line.rows])))


def _rest(fit, line, names, theta):
    """Fits the hysteresis with breakaway and command from the slides."""
    fit.base, _ = fit.params(list(line.values), list(line.values.values()))
    return list(fit.rest), *fit.solve(fit.rest, theta[-len(fit.rest) :], 4)


def _short(fit, log, events, rig, assume):
    """Returns the problem with the first rows only, for the choice of a start."""
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
    """Returns starts for the whole log, best first, because Gauss-Newton finds more than one minimum."""
    names, grid = [*names, "k_min"], []
    for k in K_STARTS:
        for times in L_STARTS:
            at = [*(x * times if n.startswith(("offset", "slope")) else x for n, x in zip(names, theta)), np.log(k)]
            grid.append(_tried(fit, names, *fit.solve(names, at, 1)))
    grid = [_tried(fit, names, *fit.solve(names, at, 4)) for _, at in sorted(grid, key=lambda g: g[0])[:VALLEYS]]
    rest = fit.prior(fit.rest[1:])[0]
    return [np.r_[at, rest] for _, at in sorted(grid, key=lambda g: g[0])]


def _tried(fit, names, theta, residual):
    """Returns the mean absolute residual, in which diverging half-cycles count little, and theta."""
    return float(np.mean(np.abs(residual))), theta


def _best(fit, names, theta, line):
    """Returns the best of the fits from each start. Two fits are enough if the line through the slides describes the log far better."""
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
    """Continues from the fit to the first rows to the fit to all rows."""
    if fit is few:
        return theta, residual, said
    fit.step(FINE_S)
    residual = fit.residual(names, theta)
    if np.median(np.abs(residual)) > 0.6745 * NOISE * fit.noise():
        return _descend(fit, names, _slow(fit, names, theta))
    fit.sharp = SHARP
    said = _leave_out(fit, residual)  # the fit is as good as the noise allows: one more pass, with all rows
    return *fit.solve(names, theta, fit.iterations()), said


def _slow(fit, names, theta):
    """Improves k_max and v0 of the start from the slow ramps of the whole log: returns the best of a grid."""
    grid = []
    for a in (1.0, 0.5, 1.7):
        for b in (1.0, 0.6, 1.6):
            there = np.array(theta, float)
            there[names.index("k_max")] += np.log(a)
            there[names.index("v0")] += np.log(b)
            grid.append(there)
    return min(grid, key=lambda t: float(np.sum(fit.residual(names, t) ** 2)))


def _leave_out(fit, residual):
    """Leaves out blocks that fit far worse than the others. Returns what to report."""
    w = ~fit.full
    rms = np.sqrt(np.bincount(fit.block, w * residual**2, fit.count) / np.maximum(np.bincount(fit.block, w, fit.count), 1))
    bad = rms > 6 * np.median(rms) + 1e-9
    if bad.mean() > 0.3:
        return [f"{bad.sum()} of {fit.count} half-cycles fit far worse than the others; because they are so many, none is left out"]
    fit.weight[bad] = 0.0
    return [f"{bad.sum()} of {fit.count} half-cycles fit far worse than the others and are left out"] if bad.any() else []


def _own(fit, names, residual, L_columns):
    """Returns the difference between each block's own L and the fitted L, and its weight."""
    column = fit.j[:, L_columns].sum(1)
    w = fit.use()
    up = np.bincount(fit.block, w * column * residual, fit.count)
    down = np.bincount(fit.block, w * column**2, fit.count)
    return up / np.maximum(down, 1e-300), down


def _table(fit, names, theta, residual, events, level):
    """Returns the size and probability of the deviation from the line, and the loads for a table."""
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
    """Returns the relative change of breakaway for ten times the ramp's rate, from the events."""
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
        remarks.append(f"a line does not fit breakaway: it is off by up to {100 * lack[0]:.2g} % at a load (probability by chance {lack[1]:.1g}); the result is a table of {len(at)} loads")
    changes = fit.bootstrap(names, residual)
    half = np.hypot((np.percentile(changes, 97.5, axis=0) - np.percentile(changes, 2.5, axis=0)) / 2, fit.model_half(names, residual))
    half, error = np.maximum(half, fit.hysteresis_half(names, theta, residual)), fit.model_error(names, residual) if line is None else None
    if line is not None:  # values from the slides come first
        names, theta, changes = [*line.values, *names], [*line.values.values(), *theta], np.c_[line.draws, changes]
        half = np.r_[(np.percentile(line.draws, 97.5, axis=0) - np.percentile(line.draws, 2.5, axis=0)) / 2, half]
    estimates = [_estimate(fit, name, value, h) for name, value, h in zip(names, theta, half)]
    params, table = fit.params(names, theta)
    both, _ = loads([(e.way, e.low, e.high) for e in events] if not by_slides else slides.spans(fit.log))
    if not both:
        raise Refusal("few loads", "few loads: F breaks away both ways at no load; approach every load from both sides")
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
        remark = f"this log does not show it; {EXPERIMENT[name]} would"
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
    """Returns half of the relative interval of L in the middle of the loads, from the draws and from the model's `error`, a covariance."""
    middle = abs(both[0][0] + both[-1][1]) / 2  # L depends on |F|
    row = np.array([n == f"table_{int(np.argmin(np.abs(np.array(fit.table_at) - middle)))}" for n in names], float) if fit.table_at is not None else _middle_row(names, middle)
    L, spread = float(row @ theta), changes @ row
    half = np.hypot((np.percentile(spread, 97.5) - np.percentile(spread, 2.5)) / 2, 0.0 if error is None else np.sqrt(row @ error @ row))
    return float(half / max(L, 1e-12))


def _hold_out(fit, residual):
    """Fits without every fourth block. Returns the rms of the held-out blocks divided by that of the others."""
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
    """Returns L+ and L- at forces."""
    load = np.abs(force)
    if table:
        at, plus, minus = np.array(table).T
        return np.interp(load, at, plus), np.interp(load, at, minus)
    return tuple(params[f"offset_{way}"] + params[f"slope_{way}"] * load for way in ("positive", "negative"))


def _slide_gap(fit, result, ways):
    """Returns the measured friction in slow slides less the model's in the same rows (so with the same lag), divided by L; and half of the interval, from the scatter
    between slides. Fast motion outweighs slow slides in the fit. The mean of both directions is taken because no bias of u moves it."""
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
        if share >= FOLLOWS and not _is_late(fit.log, lag):  # too few slides may have hidden it before
            raise not_of_one_clock(fit.log, lag)
        if said := known.says(level, 2):
            raise Refusal("noise", f"noise: {said[0]}")
        raise Refusal("model", f"model: {shown[0]}" if shown else f"the model does not explain the log: it is off from F by {rms:.3g} N rms, and breakaway is {level:.3g} N; so there is no answer")


def by_direction(result, force):
    """Returns L+ and L- for a correct u, from a fit that assumed them equal."""
    scale, bias, L = result.params["scale"], result.params["gravity"], float(breakaway(result.params, result.table, force)[0])
    return (force + L - bias) / scale - force, force - (force - L - bias) / scale


def _readings(result):
    """Explains a scale other than 1: that of u, that of F, or friction that differs by direction and grows with u, if L+ and L- are then above 0."""
    scale = next((e for e in result.estimates if e.name == "scale"), None)
    if scale is None:
        return []
    ways, ends = [], (result.loads[0][0], result.loads[-1][1])
    off = abs(scale.value - 1)
    # If L is a small part of F, a scale that is only slightly off means that friction differs by much.
    apart = max(2 * max(off, scale.half) * abs(force) / float(breakaway(result.params, result.table, force)[0]) for force in ends)
    if off <= max(scale.half, GAP) and apart <= APART:
        return []
    for force in ends:
        ways.append(by_direction(result, force))
    law = [", ".join(f"{L:.3g} N at {load:.3g} N" for L, load in zip(column, ends)) for column in zip(*ways)]
    asymmetric = f", or friction is asymmetric and u is right: L+ {law[0]}; L- {law[1]}" if np.min(ways) > 0 else ""
    return [f"either your command makes {scale.value:.4g} N for 1 N, or F is not in N (--scale F=...){asymmetric}. This log cannot tell: add --assume symmetric"
            + (" or --assume calibrated (which fits L+ and L- each)" if asymmetric else " if F is in N")]


def _doubts(result, level):
    """Yields the reasons to doubt all values. A pattern in the residual of the slides is reported in place of the others, because it causes them."""
    found = list(_misfits(result, level, result.noises, result.slide_gap[1]))
    if not found and (seen := list(_misfits(result, level, noise.NONE, 0.0))):  # noise explains the misfit, and may hide one as large
        found = result.noises.says(level, 0.0)[:1] or seen
    if found and result.noises.u > noise.NAMED["u"] * level:  # the model takes this noise as commanded motion, which frees everything that sticks
        found = [result.noises.sentence("u", level)]
    yield from result.shown if result.shown and (found or result.line_error is not None) else found
    if result.assume is None:
        yield from _readings(result)


def _misfits(result, level, known, gap_half):
    """Yields the ways in which the log differs from the model, beyond the known noise and the known steps of u."""
    left = known.beyond(result.residual_rms)
    if result.line_error is None:
        gap = result.slide_gap[0]
        if left > DOUBT * level:
            yield f"the model is off from F by {left:.3g} N rms, {100 * left / level:.2g} % of breakaway: the friction differs from the model's"
        if result.held_out > 2.5:
            yield f"held-out half-cycles fit {result.held_out:.2g} times worse"
        if abs(gap) > max(GAP, result.L_half, gap_half, known.rounding / level):
            yield f"friction in slow slides differs from the model's by {100 * gap:+.2g} %, beyond the interval of L: breakaway and sliding are not the model's"
        if result.ripple > 0.3 * level and left > DOUBT / 3 * level:  # if the model follows F there is no ripple
            yield f"there is a ripple of {result.ripple:.3g} N over position, {100 * result.ripple / level:.2g} % of breakaway: average over whole turns"
    elif (left := known.beyond(result.line_error, noise.MEDIAN)) > DOUBT / 3 * level:
        yield f"slides differ from a line by {left:.3g} N, {100 * left / level:.2g} % of breakaway: their friction is not offset + slope |F|"
    share, half = result.fall
    if share > FALL + half:
        L = breakaway(result.params, result.table, np.mean([result.loads[0][0], result.loads[-1][1]]))[0]
        yield (f"friction falls once it slides: breakaway is {100 * share:.2g} +- {100 * half:.1g} % above sliding, {(1 + share) * L:.3g} N instead of {L:.3g} N in the middle of the loads; "
               "the parameters are those of sliding")


def _judge(fit, result, level):
    doubts = list(_doubts(result, level))
    result.remarks += [text for text in result.noises.says(level) if text not in doubts]
    if result.residual_rms > DOUBT / 3 * level or result.line_error is not None:
        for e in result.estimates:
            if e.name in HYSTERESIS and e.verdict == "identified":
                e.verdict, e.remark = "weak", "the model does not follow the log closely enough to show it"
    result.remarks += doubts
    if doubts:
        for e in result.estimates:
            if e.verdict == "identified":
                e.verdict = "weak"
    if abs(result.rate_effect) > 0.1:
        result.remarks.append(f"breakaway differs from the model's by {100 * result.rate_effect:+.2g} % for ten times the ramp's rate")
    result.remarks += _readings(result) if result.assume else []
    if result.assume != "calibrated":
        result.remarks.append("L+ = L- is assumed, so that scale and bias of u can be fitted; without this assumption only L+ + L- is known (--assume calibrated: u is right, L+ and L- may differ)")
    else:
        result.remarks.append("u is assumed to be right, so that L+ and L- can be fitted separately; a bias of u would show as their difference")


def line_of(result):
    return [f"{DESCRIBED.get(e.name, e.name):<18}{e.value:11.5g}"
            + (f" +- {e.half:<9.2g}" if np.isfinite(e.half) else " " * 13) + f" {UNITS.get(e.name, ''):<4}{e.verdict}" + (f": {e.remark}" if e.remark else "") for e in result.estimates]
