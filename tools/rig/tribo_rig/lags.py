"""Lags and delay, from steps in slides: the model of the library plays u and must give F. Output error, as in tribo_identify.friction, but in every row.

    u -> delay -> actuator's pole -> arm I s^2 + b s + K with friction -> sensor's pole -> y          K = 1: all in newton

Which of two lags is the actuator's and which the sensor's shows only where friction stands between them. So the fit starts from several shares of
the whole lag; the best one counts. What the steps do not show stays where its start had it.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import scipy.optimize

from tribo_identify import native
from tribo_identify.events import Refusal

NAMES = ("actuator", "arm", "ratio", "sensor", "delay", "scale", "gravity", "offset", "slope", "presliding")
LOGARITHMIC = ("actuator", "arm", "ratio", "sensor", "presliding")  # lags in s; ratio: I K/b^2
SHARES = ((0.2, 0.3, 0.4, 0.1), (0.4, 0.3, 0.2, 0.1), (0.1, 0.2, 0.6, 0.1), (0.1, 0.6, 0.2, 0.1), (0.15, 0.15, 0.15, 0.55))  # of the whole lag: actuator, arm, sensor, delay
STEPS_S = 1e-4  # of the simulation, at least
FASTEST = 0.02  # of a tick: a lag as short as this is none
LEFT = 0.1  # of breakaway, rms: a model that leaves more is not this rig's
FEW, PASSES = 6, 30  # of each start, and of the best two


@dataclass
class Lags:
    actuator: float  # rad/s
    sensor: float
    damping: float  # b/K, s
    inertia: float  # I/K, s^2
    delay: float  # s
    params: dict  # of native.simulate
    residual_rms: float
    level: float  # breakaway in the middle
    model: np.ndarray

    @property
    def whole(self):
        """Lag of a ramp, s."""
        return 1 / self.actuator + 1 / self.sensor + self.damping + self.delay


class _Fit:
    def __init__(self, segment, first, known, noise):
        self.s, self.first, self.known, self.noise = segment, first, known, noise
        self.h = segment.h
        self.substeps = int(np.clip(np.ceil(self.h / STEPS_S), 2, 20))
        self.start = float(np.mean(segment.force[:20]))
        self.level = first.offset + first.slope * float(np.median(np.abs(segment.force)))
        self.weight = 1 / max(noise, 0.01 * self.level)

    def params(self, theta):
        v = {n: float(np.exp(x)) if n in LOGARITHMIC else float(x) for n, x in zip(NAMES, theta)}
        k = float(np.clip(1 / v["presliding"], 1.05, 500.0))
        return {**native.PAPER, "actuator": 1 / v["actuator"], "sensor": 1 / v["sensor"], "stiffness": 1.0, "damping": v["arm"], "inertia": v["ratio"] * v["arm"] ** 2,
                "delay": v["delay"], "scale": v["scale"], "gravity": v["gravity"], "offset_positive": v["offset"], "offset_negative": v["offset"],
                "slope_positive": v["slope"], "slope_negative": v["slope"], "k_min": k, "k_max": max(k, 20.0), "v0": native.PAPER["v0"] * self.level / 0.157,
                "pulse_width": 3 * self.h / self.substeps}

    def outputs(self, thetas):
        params = [self.params(t) for t in thetas]
        return native.simulate_sets(params, self.s.u, self.h, self.start, self.substeps, [()] * len(params))

    def solve(self, theta, passes):
        free = [i for i, n in enumerate(NAMES) if n not in self.known]
        prior = np.array([0.3 if n in ("ratio", "presliding") else 0.1 if n in LOGARITHMIC else 0.0 for n in NAMES])[free]
        begin = np.array(theta, float)
        size = {"delay": 0.1 * self.h, "scale": 1e-3, "slope": 1e-3, "offset": 2e-3 * self.level, "gravity": 2e-3 * self.level}
        step = np.array([size.get(NAMES[i], 0.01) for i in free])

        def whole(x):
            full = begin.copy()
            full[free] = x
            return full

        def residual(x):
            return np.r_[self.weight * (self.outputs([whole(x)])[0] - self.s.force), prior * (x - begin[free])]

        def jacobian(x):
            sets = [x, *(x + step * (np.arange(len(x)) == i) for i in range(len(x)))]
            groups = [sets[i : i + native.SETS_MAX] for i in range(0, len(sets), native.SETS_MAX)]
            with ThreadPoolExecutor(2) as pool:
                y = np.concatenate(list(pool.map(lambda g: self.outputs([whole(x) for x in g]), groups)))
            return np.vstack([self.weight * ((y[1:] - y[0]) / step[:, None]).T, np.diag(prior)])

        low = {"delay": 0.0, "offset": 1e-3 * self.level, "slope": 0.0, "scale": 0.3, "ratio": np.log(1e-3), "presliding": np.log(2e-3), "gravity": -np.inf}
        high = {"delay": 60 * self.h, "offset": 10 * self.level, "slope": 0.9, "scale": 3.0, "ratio": np.log(20.0), "presliding": np.log(0.9), "gravity": np.inf}
        bounds = np.array([[low.get(NAMES[i], np.log(FASTEST * self.h)) for i in free], [high.get(NAMES[i], np.log(1e5 * self.h)) for i in free]])
        x0 = np.clip(begin[free], bounds[0] + 1e-9, bounds[1] - 1e-9)
        found = scipy.optimize.least_squares(residual, x0, jacobian, bounds=bounds, x_scale=np.maximum(step, 1e-9) * 20, loss="soft_l1", f_scale=3.0, max_nfev=passes)
        return found.cost, whole(found.x)


def _whole_lag(segment, first):
    """By how much F comes after u where u steps within a slide: the time to 63 % of its way."""
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
        raise Refusal("silent", "2-slides-log.csv: F does not follow the steps of u: nothing tells the lags")
    return max(float(np.median(lags)), segment.h)


def fit(segment, first, known):
    """`known`: poles of actuator and sensor, or None each."""
    lag = _whole_lag(segment, first)
    fixed = {"actuator": known.actuator_pole_rad_per_s, "sensor": known.sensor_pole_rad_per_s}
    problem = _Fit(segment, first, {n for n, v in fixed.items() if v is not None}, first.noise)
    tried = []
    for actuator, arm, sensor, delay in SHARES:
        start = {"actuator": actuator * lag, "arm": arm * lag, "sensor": sensor * lag, "ratio": 0.25} | {n: 1 / v for n, v in fixed.items() if v is not None}
        start = {n: np.log(v) for n, v in start.items()}
        start |= {"delay": delay * lag, "scale": first.scale, "gravity": first.bias, "offset": max(first.offset, 0.02 * problem.level), "slope": first.slope, "presliding": np.log(0.1)}
        tried.append(problem.solve([start[n] for n in NAMES], FEW))
    tried.sort(key=lambda t: t[0])
    _, theta = min((problem.solve(t, PASSES) for _, t in tried[:2]), key=lambda t: t[0])
    p = problem.params(theta)
    model = problem.outputs([theta])[0]
    left = float(np.sqrt(np.mean((model - segment.force) ** 2)))
    level = p["offset_positive"] + p["slope_positive"] * float(np.median(np.abs(segment.force)))
    return Lags(p["actuator"], p["sensor"], p["damping"], p["inertia"], p["delay"], p, left, level, model)
