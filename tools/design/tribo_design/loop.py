"""The loop around a controller, and the figures that the table shows.

Continuous time: L(s) = G(s) K(s). Sampled: L(z) = G(z) K(z), where G(z) is the plant behind a zero-order hold and
the computation delay, exactly as the samples see it; the hold's half sample and the delay are therefore in
every figure of the sampled rows. The weights are taken at s = j omega up to the Nyquist frequency.
"""

from dataclasses import asdict, dataclass, fields
from typing import Optional

import control as ct
import numpy as np
import scipy.optimize
import scipy.signal

from .systems import Zpk, balanced_scaling, state_space


class Continuous:
    """A continuous-time system as Zpk, as state space, or both (then the state space is what is evaluated)."""

    def __init__(self, zpk=None, space=None):
        self.zpk = zpk
        self._given = space
        self._space = space

    @property
    def space(self):
        if self._space is None:
            self._space = state_space(self.zpk)
        return self._space

    def response(self, omega):
        points = 1j * np.asarray(omega, float)
        if self._given is not None:
            return response_of(self._given, points)
        return self.zpk(points)

    def near_zero(self):
        if self._given is not None:
            a, b, c, d = (np.asarray(m) for m in ct.ssdata(self._given))
            if self._given.nstates == 0:
                return 0, d[0, 0], 0.0
            x = np.linalg.solve(a, b)
            return 0, (d - c @ x)[0, 0], -(c @ np.linalg.solve(a, x))[0, 0]
        return zpk_near_zero(self.zpk)

    def poles(self):
        if self.zpk is not None:
            return self.zpk.poles
        return np.linalg.eigvals(self._given.A)

    def roots(self):
        if self.zpk is not None:
            return np.r_[self.zpk.poles, self.zpk.zeros]
        return self.poles()


class SampledZpk:
    """A controller K(z) as Zpk in d = z - 1."""

    def __init__(self, zpk, h):
        self.zpk, self.h = zpk, h

    @property
    def space(self):
        return state_space(self.zpk)

    def response(self, omega):
        return self.zpk(np.expm1(1j * np.asarray(omega, float) * self.h))

    def near_zero(self):
        return zpk_near_zero(self.zpk)

    def poles(self):
        """As rad/s: s = log(1 + d) / h."""
        d = self.zpk.poles
        return np.log1p(d[np.abs(1 + d) > 1e-12]) / self.h


class SampledSections:
    """A controller K(z) as what runs: rows b0, b1, b2, a1, a2 of a cascade in d = z - 1."""

    def __init__(self, sections, h):
        self.sections, self.h = np.asarray(sections, float), h

    @property
    def space(self):
        total = None
        for b0, b1, b2, a1, a2 in self.sections:
            block = ct.ss([[-a1, 1], [-a2, 0]], [[b1 - a1 * b0], [b2 - a2 * b0]], [[1, 0]], [[b0]],
                          remove_useless_states=False)
            total = block if total is None else ct.series(total, block)
        return total

    def section_responses(self, omega):
        d = np.expm1(1j * np.asarray(omega, float) * self.h)
        b0, b1, b2, a1, a2 = (c[:, None] for c in self.sections.T)
        with np.errstate(divide="ignore", invalid="ignore"):
            return (b0 * d**2 + b1 * d + b2) / (d**2 + a1 * d + a2)

    def response(self, omega):
        return np.prod(self.section_responses(omega), axis=0)

    def near_zero(self):
        order, value, slope = 0, 1.0, 0.0
        for b0, b1, b2, a1, a2 in self.sections:
            if a2 == 0 and b2 != 0:
                order, v, s = order + 1, b2 / a1, 0.0
            elif a2 == 0:
                v, s = b1 / a1, (b0 * a1 - b1) / a1**2
            else:
                v, s = b2 / a2, (b1 * a2 - b2 * a1) / a2**2
            value, slope = value * v, slope * v + value * s
        return order, value, slope

    def poles(self):
        roots = np.concatenate([quadratic_roots(a1, a2) for _, _, _, a1, a2 in self.sections])
        return np.log1p(roots[np.abs(1 + roots) > 1e-9]) / self.h


def quadratic_roots(a1, a2):
    """Roots of d^2 + a1 d + a2 without cancellation in the small one."""
    root = np.sqrt(complex(a1 * a1 / 4 - a2))
    large = -a1 / 2 - root if a1 >= 0 else -a1 / 2 + root
    if large == 0:
        return np.zeros(2, complex)
    return np.array([large, a2 / large], complex)


def zpk_near_zero(zpk):
    """(n, c, slope): the value is c / x^n + slope ... as x goes to 0."""
    poles, zeros = zpk.poles, zpk.zeros
    order = int(np.sum(poles == 0) - np.sum(zeros == 0))
    poles, zeros = poles[poles != 0], zeros[zeros != 0]
    value = float(np.real(Zpk(zeros, poles, zpk.gain)(0.0)[0]))
    slope = value * float(np.real(np.sum(-1 / zeros) + np.sum(1 / poles)))
    return order, value, slope


def response_of(space, points):
    """C (x I - A)^-1 B + D at complex points, all in one batch."""
    a, b, c, d = (np.asarray(m, complex) for m in ct.ssdata(space))
    n = a.shape[0]
    if n == 0:
        return np.full(points.shape, d[0, 0])
    out = np.empty(points.shape, complex)
    for start in range(0, len(points), 4096):
        x = points[start : start + 4096]
        matrices = x[:, None, None] * np.eye(n) - a
        out[start : start + 4096] = (c @ np.linalg.solve(matrices, np.broadcast_to(b, (len(x), n, 1))))[:, 0, 0] + d[0, 0]
    return out


class SampledPlant:
    """The plant behind hold and delay. `space` is in d = z - 1, with the delayed inputs as states."""

    def __init__(self, plant, h, delay=0.0):
        self.h, self.delay = h, delay
        a, b, c, d = (np.asarray(m) for m in ct.ssdata(plant))
        whole = int(np.floor(delay / h + 1e-9))
        part = max(delay - whole * h, 0.0)
        if part < 1e-9 * h:
            part = 0.0
        phi, gamma_now, *_ = scipy.signal.cont2discrete((a, b, c, d), h - part, "zoh")
        if part:
            rest, gamma_before, *_ = scipy.signal.cont2discrete((a, b, c, d), part, "zoh")
            gamma_before = phi @ gamma_before
            phi = phi @ rest
        n = len(a)
        # States: x, then u[k-1] ... u[k-whole-1]; input of the plant is u[k-whole], and u[k-whole-1] before `part`.
        taps = whole + (1 if part else 0)
        big = np.zeros((n + taps, n + taps))
        into = np.zeros((n + taps, 1))
        out = np.zeros((1, n + taps))
        through = np.zeros((1, 1))
        big[:n, :n] = phi
        out[:, :n] = c
        current = gamma_now
        if whole:
            big[:n, n + whole - 1 : n + whole] += current
        else:
            into[:n] += current
        if part:
            big[:n, n + whole : n + whole + 1] += gamma_before
        seen = whole + (1 if part else 0)  # at the sample itself, the plant still has this old an input
        if seen:
            out[:, n + seen - 1] += d[0, 0]
        else:
            through[:] = d
        for i in range(taps):
            if i == 0:
                into[n] = 1.0
            else:
                big[n + i, n + i - 1] = 1.0
        self.space = ct.ss(big - np.eye(n + taps), into, out, through, remove_useless_states=False)

    def response(self, omega):
        return response_of(self.space, np.expm1(1j * np.asarray(omega, float) * self.h))

    def near_zero(self):
        return Continuous(space=self.space).near_zero()


@dataclass(frozen=True)
class Metrics:
    stable: bool
    gamma: Optional[float]
    max_s: float
    max_t: float
    max_ks: float
    gain_margin: float
    phase_margin_deg: float
    delay_margin_s: float
    crossover_rad_s: float
    bandwidth_rad_s: float
    ramp_error_n: float
    slowest_pole_rad_s: float

    def as_dict(self):
        return {k: (None if isinstance(v, float) and not np.isfinite(v) else v) for k, v in asdict(self).items()}


METRIC_NAMES = [f.name for f in fields(Metrics)]


class Loop:
    def __init__(self, plant, controller, weights=None, h=None, ramp=None, roots=()):
        """`plant` and `controller` both continuous, or both sampled with `h`. `roots`: further corner frequencies."""
        self.plant, self.controller, self.weights, self.h, self.ramp = plant, controller, weights or {}, h, ramp
        corners = np.abs(np.concatenate([np.atleast_1d(np.asarray(r, complex)).ravel() for r in
                                         [roots, controller.poles(), *(np.r_[w.poles, w.zeros] for w in self.weights.values())]]))
        corners = corners[(corners > 1e-9) & (corners < 1e15)]
        low, high = (corners.min(), corners.max()) if len(corners) else (1.0, 1.0)
        if h is not None:
            high = np.pi / h
            low = min(low, high / 10)
        self.omega = self._grid(low, high, corners, np.asarray([r for r in np.atleast_1d(np.asarray(roots, complex))]))

    def _grid(self, low, high, corners, roots):
        top = high if self.h is not None else high * 1e2
        start = low * 1e-2
        count = int(min(200 * max(np.log10(top / start), 1), 4000))
        omega = np.geomspace(start, top, count)
        for root in [*roots, *self.controller.poles()]:  # lightly damped roots need points of their own
            damping = abs(root.real) / abs(root) if root else 1
            if 0 < damping < 0.1 and start < abs(root) < top:
                span = np.linspace(-8, 8, 81) * max(damping, 1e-6)
                omega = np.r_[omega, abs(root) * np.exp(span)]
        omega = np.unique(omega)
        return omega[(omega > 0) & (omega <= top)]

    def open_loop(self, omega):
        return self.plant.response(omega) * self.controller.response(omega)

    def closed_loop(self, omega):
        """S, T, KS, and gamma's weighted sum, at the frequencies."""
        k = self.controller.response(omega)
        loop = self.plant.response(omega) * k
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            s = 1 / (1 + loop)
            t = np.where(np.isfinite(loop), loop / (1 + loop), 1.0)
            ks = k * s
        total = None
        if self.weights:
            points = 1j * np.asarray(omega, float)
            total = np.sqrt(sum(np.abs(w(points) * f) ** 2 for w, f in
                                ((self.weights.get("wp"), s), (self.weights.get("wu"), ks), (self.weights.get("wT"), t))
                                if w is not None))
        return s, t, ks, total

    def is_stable(self):
        slack, certain = stability_slack(self.plant.space, self.controller.space, self.h)
        if slack > 0 or certain or self.h is not None:
            return slack > 0
        # A pole many decades beyond the others spoils the small eigenvalues: count the encirclements of -1 instead.
        for space in (self.plant.space, self.controller.space):
            if space.nstates and np.any(np.linalg.eigvals(space.A).real >= 0):
                return False
        around = np.unwrap(np.angle(1 + self.open_loop(self.omega)))
        return bool(abs(around[-1] - around[0]) < np.pi / 2)

    def _peak(self, values, which):
        """The largest of a magnitude on the grid, refined between the neighbours of the three highest points."""
        values = np.where(np.isfinite(values), values, -np.inf)
        best = float(values.max())
        inner = np.flatnonzero((values[1:-1] >= values[:-2]) & (values[1:-1] >= values[2:])) + 1
        logs = np.log(self.omega)
        for i in inner[np.argsort(values[inner])][-3:]:
            found = scipy.optimize.minimize_scalar(lambda x: -which(np.exp([x]))[0], method="bounded",
                                                   bounds=(logs[i - 1], logs[i + 1]), options={"xatol": 1e-7})
            best = max(best, float(-found.fun))
        return best

    def margins(self):
        loop = self.open_loop(self.omega)
        omega, log = self.omega, np.log(self.omega)
        size = np.log(np.abs(loop))
        gain_crossings = _crossings(lambda x: float(np.log(np.abs(self.open_loop(np.exp([x]))[0]))), log, size)
        phase_values = np.where(np.abs(loop) > 1e-7, np.imag(loop) / np.abs(loop), np.nan)
        phase_crossings = _crossings(lambda x: _sine(self.open_loop(np.exp([x]))[0]), log, phase_values)
        real = [float(np.real(self.open_loop(np.exp([x]))[0])) for x in phase_crossings]
        if self.h is not None:
            real.append(float(np.real(self.open_loop(np.array([np.pi / self.h]))[0])))
        gains = [abs(r) for r in real if r < 0]
        gain_margin = min((max(g, 1 / g) for g in gains if g > 0), default=np.inf)
        phase_margin, delay_margin = np.inf, np.inf
        crossover = np.nan
        for x in gain_crossings:
            w = float(np.exp(x))
            angle = np.angle(self.open_loop(np.array([w]))[0])
            phase = (angle + np.pi + np.pi) % (2 * np.pi) - np.pi
            phase_margin = min(phase_margin, abs(np.degrees(phase)))
            delay_margin = min(delay_margin, (phase % (2 * np.pi)) / w)
            crossover = w
        return gain_margin, phase_margin, delay_margin, crossover

    def ramp_error(self):
        """Error at the end of the ramp, its transients over: rate (S(0) T + S'(0))."""
        if self.ramp is None:
            return np.nan
        order_k, k, slope_k = self.controller.near_zero()
        order_g, g, slope_g = self.plant.near_zero()
        order, value = order_k + order_g, k * g
        unit = self.h if self.h is not None else 1.0
        if order >= 2:
            return 0.0
        if order == 1:
            return abs(self.ramp.rate_n_per_s * unit / value) if value else np.inf
        if order < 0:
            return abs(self.ramp.rate_n_per_s * self.ramp.duration_s)
        s0 = 1 / (1 + value)
        s1 = -(slope_k * g + k * slope_g) * s0**2
        return abs(self.ramp.rate_n_per_s * (s0 * self.ramp.duration_s + s1 * unit))

    def metrics(self):
        s, t, ks, total = self.closed_loop(self.omega)
        size_t = np.abs(t)
        below = np.flatnonzero(size_t < np.sqrt(0.5))
        bandwidth = np.nan
        if len(below) and below[0] > 0:
            i = below[0]
            bandwidth = float(np.exp(scipy.optimize.brentq(
                lambda x: np.abs(self.closed_loop(np.exp([x]))[1][0]) - np.sqrt(0.5),
                np.log(self.omega[i - 1]), np.log(self.omega[i]), xtol=1e-10)))
        gain_margin, phase_margin, delay_margin, crossover = self.margins()
        poles = self.controller.poles()
        return Metrics(
            stable=bool(self.is_stable()),
            gamma=None if total is None else self._peak(total, lambda w: self.closed_loop(w)[3]),
            max_s=self._peak(np.abs(s), lambda w: np.abs(self.closed_loop(w)[0])),
            max_t=self._peak(size_t, lambda w: np.abs(self.closed_loop(w)[1])),
            max_ks=self._peak(np.abs(ks), lambda w: np.abs(self.closed_loop(w)[2])),
            gain_margin=float(gain_margin), phase_margin_deg=float(phase_margin),
            delay_margin_s=float(delay_margin), crossover_rad_s=float(crossover), bandwidth_rad_s=bandwidth,
            ramp_error_n=float(self.ramp_error()),
            slowest_pole_rad_s=float(np.abs(poles).min()) if len(poles) else np.nan)

    def responses(self, duration, ramp_rate=None, points=1500):
        """Time, y and u of a step of 1 N, or of a ramp."""
        k, g = self.controller.space, self.plant.space
        loop = ct.feedback(ct.append(k, g), ct.ss([], [], [], [[0, 1], [-1, 0]]), sign=-1)
        closed = ct.ss(loop.A, loop.B[:, :1], loop.C, loop.D[:, :1], remove_useless_states=False)
        if self.h is None:
            time = np.linspace(0, duration, points)
            r = np.ones(points) if ramp_rate is None else ramp_rate * time
            a, b, c, d = (np.asarray(m) for m in ct.ssdata(closed))
            out = scipy.signal.lsim((a, b, c, d), r, time)[1]
            return time, r, out[:, 1], out[:, 0]
        count = int(min(max(duration / self.h, 10), 20000))
        time = np.arange(count) * self.h
        r = np.ones(count) if ramp_rate is None else ramp_rate * time
        a, b, c, d = (np.asarray(m) for m in ct.ssdata(closed))
        out = scipy.signal.dlsim((a + np.eye(len(a)), b, c, d, self.h), r)[1]
        return time, r, out[:, 1], out[:, 0]


def stability_slack(plant, controller, h):
    """How far the slowest closed-loop pole is inside the stable region, of its own size; not over 0 is unstable. And
    whether the eigenvalues can be trusted to say so."""
    through = plant.D[0, 0] * controller.D[0, 0]
    if abs(1 + through) < 1e-12:
        return -1.0, True
    closed = balanced_scaling(ct.feedback(ct.series(controller, plant), 1))
    poles = np.linalg.eigvals(closed.A) if closed.nstates else np.array([-1.0])
    size = np.maximum(np.abs(poles), 1e-300)
    if h is None:
        slack = -poles.real / size
    else:  # d = z - 1: 1 - |1 + d|^2 = -(2 Re d + |d|^2)
        slack = -(2 * poles.real + np.abs(poles) ** 2) / (2 * size)
    bad = poles[slack <= 0]
    certain = not np.any(np.abs(bad) < 1e-6 * size.max())
    return float(slack.min()), certain


def _crossings(function, x, values):
    found = []
    good = np.isfinite(values)
    for i in np.flatnonzero(good[:-1] & good[1:] & (np.sign(values[:-1]) != np.sign(values[1:]))):
        if function(x[i]) * function(x[i + 1]) < 0:
            found.append(scipy.optimize.brentq(function, x[i], x[i + 1], xtol=1e-12))
        else:
            found.append(x[i])
    return found


def _sine(value):
    return float(value.imag / abs(value)) if value != 0 else 0.0
