"""Lags, delay and the law of friction, from steps in slides: the plant of tribo-sim plays u and must give F in every row.

    u -> delay -> actuator's pole -> arm I s^2 + b s + K with friction -> sensor's pole -> y          K = 1: all in newton

Which of two lags is the actuator's and which the sensor's shows where F reverses after a step, because friction is between them. That needs the right law of
friction: the paper's acts on the net force, Coulomb's on the motion, LuGre's and Maxwell's build up over a travel, and each may fall with speed. All are tried. The
fit starts from several shares of the whole lag; the best result counts. Values that the steps do not show keep their start values.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import scipy.optimize
import scipy.stats

from tribo_design import progress
from tribo_identify import native
from tribo_identify.events import Refusal
from tribo_identify.friction import breakaway

from . import experiments

NAMES = ("actuator", "arm", "ratio", "sensor", "delay", "scale", "gravity", "offset", "slope", "offset_negative", "slope_negative", "way", "exponent", "falls", "speed")
DOWNWARDS = ("offset_negative", "slope_negative")
COMMAND = ("scale", "gravity")
SHAPES = ("way", "exponent", "falls", "speed")
# Lags in s; ratio: I K/b^2; way: over which friction builds up, N of F; exponent: of Maxwell's elements; offset and slope are of sliding: breakaway is 1 + falls
# times that, and friction falls from there at a speed, N/s of F.
LOGARITHMIC = ("actuator", "arm", "ratio", "sensor", "way", "speed")
SHARES = ((0.2, 0.3, 0.4, 0.1), (0.4, 0.3, 0.2, 0.1), (0.1, 0.2, 0.6, 0.1), (0.1, 0.6, 0.2, 0.1), (0.15, 0.15, 0.15, 0.55))  # of the whole lag: actuator, arm, sensor, delay
STIFFENS, FALLS = ", stiffens", ", falls"
BUILDS_UP = ("lugre", "maxwell_slip")
WAYS = (0.02, 0.2)  # of a usual breakaway, to start from
FALL, SPEEDS = 0.1, (0.01, 0.1)  # likewise; of the range of F in a second
STEPS_S = 1e-4  # of the simulation, at least
COARSE = 0.02  # of the whole lag: steps of the first search
FASTEST = 0.02  # of a tick: a lag as short as this is none
LEFT = 0.1  # of breakaway, rms: a model that leaves more is not this rig's
EXACT = 1.06  # times the noise: no other law is looked for
BETTER = 0.97  # of what the simpler law leaves
ALIKE = 1.3  # times what the best law leaves: the lags may as well be this law's
OTHER = 0.2  # of a pole: beyond it a model with another one is tried with the loop
AWAY = 100.0  # times the largest F: as far as a plant runs away
ROBUST = 3.0  # weighted residuals beyond this count less
FEW, PASSES = 6, 30  # of the best starts, and of the best two of these
STARTS = 5  # that are gone down from


@dataclass
class Lags:
    actuator: float  # rad/s
    sensor: float
    damping: float  # b/K, s
    inertia: float  # I/K, s^2
    delay: float  # s
    law: str  # truth model of tribo-sim
    theta: np.ndarray  # of Fit
    params: dict  # of Fit
    halves: dict  # of 95 % intervals, s: actuator, arm, sensor, delay
    others: list  # (actuator, sensor) in rad/s of models that leave almost as little
    residual_rms: float
    level: float  # breakaway in the middle
    model: np.ndarray

    @property
    def whole(self):
        """Lag of a ramp, s."""
        return 1 / self.actuator + 1 / self.sensor + self.damping + self.delay


def substeps(h):
    """Of a tick, as the scenario has them."""
    return int(max(np.ceil(h / STEPS_S - 1e-6), 2))


def model_of(law):
    """Truth model of tribo-sim."""
    return law.split(",")[0]


def own_of(law, p, level):
    """A truth model's own parameters, for an arm of 1 N/deg: its stiffness is that of friction over the arm's. LuGre's bristles are damped critically.
    Bristles have either one stiffness, or one travel to breakaway and so a stiffness that grows with breakaway. `p` holds Fit's parameters."""
    model, stiffens = model_of(law), STIFFENS in law
    stiffness = float(np.clip((1.0 if stiffens else level) / p["way"], 1e-4, 1e6))
    falls = {"sliding_ratio": 1 / (1 + p["falls"]), "stribeck_speed_deg_per_s": float(np.clip(p["speed"], 1e-5, 100.0))}
    sliding = {"viscous_N_s_per_deg": 0.0, **falls}
    return {"paper": {}, "coulomb": falls,
            "lugre": {"stiffness_N_per_deg": stiffness, "bristle_damping_N_s_per_deg": float(np.sqrt(p["inertia"] * stiffness)), **sliding, "limited": False, "stiffens": stiffens},
            "maxwell_slip": {"stiffness_N_per_deg": stiffness, "attraction_N_per_s": 1e6, **sliding, "exponent": p["exponent"], "stiffens": stiffens}}[model]


def free_of(law):
    """The parameters of a law of friction besides breakaway."""
    model = model_of(law)
    return (*(("way",) if model != "coulomb" else ()), *(("exponent",) if model == "maxwell_slip" else ()), *(("falls", "speed") if FALLS in law else ()))


class Fit:
    """`known`: names that stay fixed. `assume` is that of tribo_identify: symmetric, L+ = L-; or calibrated, the command is right and L+ and L- are each their own."""

    def __init__(self, segment, first, known, assume):
        self.s, self.assume = segment, assume
        self.known = {*known, *(COMMAND if assume == "calibrated" else DOWNWARDS)}
        self.h = segment.h
        self.level = first.offset + first.slope * float(np.median(np.abs(segment.force)))
        self.weight = 1 / max(first.noise, 0.01 * self.level)
        self.span = float(np.ptp(segment.force))
        self.away = AWAY * float(np.abs(segment.force).max())
        self.substeps = substeps(self.h)
        self.begin = int((experiments.REST_S + 0.9 * experiments.APPROACH_S) / self.h)  # F may have rested anywhere before
        change = np.abs(np.diff(segment.u[self.begin :]))
        self.steps = np.flatnonzero(change > 0.5 * change.max()) + 1

    def params(self, theta):
        v = {n: float(np.exp(x)) if n in LOGARITHMIC else float(x) for n, x in zip(NAMES, theta)}
        if self.assume == "symmetric":
            v |= {n: v[n.removesuffix("_negative")] for n in DOWNWARDS}
        k = float(np.clip(self.level / v["way"], 1.05, 500.0))
        return {**native.PAPER, **{n: v[n] for n in ("way", "exponent", "falls", "speed")}, "actuator": 1 / v["actuator"], "sensor": 1 / v["sensor"], "stiffness": 1.0, "damping": v["arm"], "inertia": v["ratio"] * v["arm"] ** 2,
                "delay": v["delay"], "scale": v["scale"], "gravity": v["gravity"], "offset_positive": v["offset"], "offset_negative": v["offset_negative"],
                "slope_positive": v["slope"], "slope_negative": v["slope_negative"], "k_min": k, "k_max": max(k, 20.0), "v0": native.PAPER["v0"] * self.level / 0.157,
                "pulse_width": 3 * self.h}

    def output(self, law, theta, finer=1):
        params = self.params(theta)
        breakaway = {n: (1 + params["falls"]) * params[n] for n in ("offset_positive", "offset_negative", "slope_positive", "slope_negative")}
        y = native.play(model_of(law), own_of(law, params, self.level), params | breakaway, self.s.u, self.h, finer * self.substeps)
        return np.clip(np.nan_to_num(y, nan=self.away), -self.away, self.away)

    def solve(self, law, theta, passes):
        """(cost, theta, halves of 95 % intervals)."""
        mine = free_of(law)
        free = [i for i, n in enumerate(NAMES) if n not in self.known and (n not in SHAPES or n in mine)]
        prior = np.array([0.3 if n in ("ratio", *SHAPES) else 0.1 if n in LOGARITHMIC else 0.0 for n in NAMES])[free]
        begin = np.array(theta, float)
        size = {"delay": 0.1 * self.h, "scale": 1e-3, "slope": 1e-3, "offset": 2e-3 * self.level, "gravity": 2e-3 * self.level}
        size |= {n: size[n.removesuffix("_negative")] for n in DOWNWARDS}
        step = np.array([size.get(NAMES[i], 0.01) for i in free])

        def whole(x):
            full = begin.copy()
            full[free] = x
            return full

        def left(x, finer=1):
            return self.weight * (self.output(law, whole(x), finer) - self.s.force)[self.begin :]

        def residual(x):
            return np.r_[left(x), prior * (x - begin[free])]

        def jacobian(x):
            with ThreadPoolExecutor(2) as pool:
                y = np.array(list(pool.map(left, [x, *(x + step * (np.arange(len(x)) == i) for i in range(len(x)))])))
            return np.vstack([((y[1:] - y[0]) / step[:, None]).T, np.diag(prior)])

        low = {"delay": 0.0, "offset": 1e-3 * self.level, "slope": 0.0, "scale": 0.3, "ratio": np.log(1e-3), "way": np.log(2e-3 * self.level), "gravity": -np.inf,
               "exponent": -2.0, "falls": 0.0, "speed": np.log(1e-4 * self.span)}
        high = {"delay": 60 * self.h, "offset": 10 * self.level, "slope": 0.9, "scale": 3.0, "ratio": np.log(20.0), "way": np.log(0.9 * self.level), "gravity": np.inf,
                "exponent": 2.0, "falls": 1.0, "speed": np.log(10 * self.span)}
        for end in (low, high):
            end |= {n: end[n.removesuffix("_negative")] for n in DOWNWARDS}
        bounds = np.array([[low.get(NAMES[i], np.log(FASTEST * self.h)) for i in free], [high.get(NAMES[i], np.log(1e5 * self.h)) for i in free]])
        x0 = np.clip(begin[free], bounds[0] + 1e-9, bounds[1] - 1e-9)
        found = scipy.optimize.least_squares(residual, x0, jacobian, bounds=bounds, x_scale=np.maximum(step, 1e-9) * 20, loss="soft_l1", f_scale=ROBUST, max_nfev=passes, ftol=1e-5, xtol=1e-6)
        halves = np.zeros(len(NAMES))
        finer = left(found.x, 2) - left(found.x) if passes > FEW else 0.0 * found.fun[: -len(free)]
        halves[free] = self._halves(found, len(free), finer)
        return found.cost, whole(found.x), halves

    def _halves(self, found, count, finer):
        """Halves of the 95 % intervals. The residual is not white noise: rows of one step count once, and errors that return with each step count fully. `finer`
        is the change of the model with half the step: the model's own first-order error is as large."""
        inverse = np.linalg.pinv(found.jac.T @ found.jac)
        own = 2 * np.abs(inverse @ found.jac[:-count].T @ finer)
        white = 2 * found.cost / len(found.fun) * np.diag(inverse)
        rows = found.jac[:-count] * (found.fun[:-count] * (1 + (found.fun[:-count] / ROBUST) ** 2) ** 0.25)[:, None]  # found.jac belongs to the robust cost
        steps = [pull.sum(0) for pull in np.split(rows, self.steps) if len(pull)]
        if len(steps) <= 2:
            return own + 1.96 * np.sqrt(white)
        moved = np.array(steps) @ inverse
        few = len(steps) / (len(steps) - 1)
        return own + np.sqrt(np.maximum(1.96**2 * white, scipy.stats.t.ppf(0.975, len(steps) - 1) ** 2 * few * (moved**2).sum(0)))

    def left(self, law, theta):
        return float(np.sqrt(np.mean((self.output(law, theta) - self.s.force)[self.begin :] ** 2)))


def _whole_lag(segment, first):
    """The lag of F after u where u steps within a slide: the time to 63 % of the change."""
    change = np.abs(np.diff(segment.u))
    at = np.flatnonzero(change > 0.5 * change.max())
    lags = []
    for a, b in zip(at, np.r_[at[1:], len(segment.u)]):
        y = segment.force[a : min(b, a + int(2.0 / segment.h) + 2)]
        end = float(np.mean(y[-max(len(y) // 10, 2) :]))
        way = end - y[0]
        if abs(way) > max(10 * first.noise, 0.2 * first.scale * change[a] / (1 + first.slope)):
            lags.append(np.argmax((y - y[0]) / way > 0.63) * segment.h)
    if not lags:
        raise Refusal("silent", "2-slides-log.csv: F does not follow the steps of u, so the lags cannot be found")
    return max(float(np.median(lags)), segment.h)


def _best(problem, law, starts, lag):
    """Fits the best starts in coarse steps, then the best two of them in the steps of the scenario."""
    progress.at(f"fits the lags with friction of {law.replace('_', ' ')}")
    problem.substeps = int(max(np.ceil(problem.h / max(STEPS_S, COARSE * lag)), 2))
    starts = sorted(starts, key=lambda theta: problem.left(law, theta))[:STARTS] if len(starts) > STARTS else starts
    tried = sorted((problem.solve(law, theta, FEW) for theta in starts), key=lambda t: t[0])
    problem.substeps = substeps(problem.h)
    return min((problem.solve(law, theta, PASSES) for _, theta, _ in tried[:2]), key=lambda t: t[0])


def _laws(problem, first, starts, swappable, lag):
    """(law, residual, theta, halves of intervals) of each law of friction that was tried, the best first."""
    found = []

    def attempt(law, begins):
        _, theta, halves = _best(problem, law, begins, lag)
        found.append((law, problem.left(law, theta), theta, halves))

    def best():
        """Prefers a simpler law to one with a little less residual."""
        return min(found, key=lambda f: f[1] * (BETTER if f[0] == "coulomb" else 1.0))

    def changed(theta, **values):
        return np.array([values.get(n, x) for n, x in zip(NAMES, theta)])

    def turned(theta):
        return theta[[NAMES.index({"actuator": "sensor", "sensor": "actuator"}.get(n, n)) for n in NAMES]] if swappable else theta

    def falling(theta):
        return [changed(theta, falls=FALL, speed=np.log(speed * problem.span)) for speed in SPEEDS]

    attempt("coulomb", starts)
    near = found[0][2]
    swapped = turned(near)
    ways = [changed(theta, way=np.log(way * problem.level)) for theta in (near, swapped, *starts[:2]) for way in WAYS]
    last = lambda: found[-1][2]
    for law, begins in (("coulomb" + FALLS, lambda: falling(near) + falling(swapped)), ("lugre", lambda: ways), ("lugre" + STIFFENS, lambda: [last()]),
                        ("maxwell_slip", lambda: ways), ("maxwell_slip" + STIFFENS, lambda: [last()]), ("paper", lambda: [*ways[1:4:2], *starts])):
        if best()[1] <= EXACT * first.readings.worst:
            break
        attempt(law, begins())
    law, left, theta, _ = best()
    if left > EXACT * first.readings.worst and model_of(law) in BUILDS_UP:
        attempt(law + FALLS, falling(theta))
    law, _, theta, _ = best()
    attempt(law, [turned(theta)])
    return sorted(found, key=lambda f: f is not best())


def fit(segment, first, known):
    """`known`: poles of actuator and sensor, or None each."""
    lag = _whole_lag(segment, first)
    fixed = {"actuator": known.actuator_pole_rad_per_s, "sensor": known.sensor_pole_rad_per_s}
    problem = Fit(segment, first, {n for n, v in fixed.items() if v is not None}, "calibrated" if known.command else "symmetric")
    friction = first.of(problem.assume)
    friction |= {n: max(friction[n], 0.02 * problem.level) for n in ("offset", "offset_negative")}
    starts = []
    for actuator, arm, sensor, delay in SHARES:
        start = {"actuator": actuator * lag, "arm": arm * lag, "sensor": sensor * lag, "ratio": 0.25} | {n: 1 / v for n, v in fixed.items() if v is not None}
        start = {n: np.log(v) for n, v in start.items()}
        start |= {"delay": delay * lag, "way": np.log(WAYS[0] * problem.level), "exponent": 1.0, "falls": 0.0, "speed": np.log(SPEEDS[0] * problem.span)}
        starts.append(np.array([(start | friction)[n] for n in NAMES]))
    tried = _laws(problem, first, starts, swappable=not any(v is not None for v in fixed.values()), lag=lag)
    law, left, theta, halves = tried[0]
    p = problem.params(theta)
    level = float(np.mean(breakaway(p, [], float(np.median(np.abs(segment.force))))))
    lags = {"actuator": 1 / p["actuator"], "arm": p["damping"], "sensor": 1 / p["sensor"], "delay": 1.0}
    alike = [problem.params(other) for _, rms, other, _ in tried if rms < ALIKE * left]
    far = {"actuator": [1 / q["actuator"] for q in alike], "arm": [q["damping"] for q in alike], "sensor": [1 / q["sensor"] for q in alike], "delay": [q["delay"] for q in alike]}
    own = {n: lags[n] if n != "delay" else p["delay"] for n in lags}
    halves = {n: float(lags[n] * halves[NAMES.index(n)] + np.abs(np.array(far[n]) - own[n]).max()) for n in lags}
    others = [(q["actuator"], q["sensor"]) for q in alike if max(abs(np.log(q[n] / p[n])) for n in ("actuator", "sensor")) > OTHER]
    return Lags(p["actuator"], p["sensor"], p["damping"], p["inertia"], p["delay"], law, theta, p, halves, others, left, level, problem.output(law, theta))
