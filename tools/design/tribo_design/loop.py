"""The loop around a controller, and the figures that the table shows.

Continuous time: L(s) = G(s) K(s). Sampled: L(z) = G(z) K(z), where G(z) is the plant behind a zero-order hold and
the computation delay, exactly as the samples see it; the hold's half sample and the delay are therefore in
every figure of the sampled rows. The weights are taken at s = j omega up to the Nyquist frequency.
"""

import functools
from dataclasses import asdict, dataclass, fields
from typing import Optional

import control as ct
import numpy as np
import scipy.optimize
import scipy.signal
from flint import fmpq_poly

from .exact import Ratio, closed_loop_poles
from .systems import balanced_scaling, state_space
from .zpk import Zpk


class Continuous:
    """A continuous-time system as Zpk, as state space, or both (then the Zpk is what is evaluated, as it has no rounding)."""

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
        return self.zpk(points) if self.zpk is not None else response_of(self._given, points)

    @property
    def ratio(self):
        return Ratio.of_state_space(*self._matrices()) if self._given is not None and self.zpk is None else Ratio.of_zpk(self.zpk)

    def _matrices(self):
        return [np.asarray(m) for m in ct.ssdata(self._given)]

    def near_zero(self):
        if self.zpk is None:
            a, b, c, d = self._matrices()
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

    @property
    def ratio(self):
        return Ratio.of_zpk(self.zpk)

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

    @property
    def ratio(self):
        num, den = fmpq_poly([1]), fmpq_poly([1])
        for b0, b1, b2, a1, a2 in self.sections:
            part = Ratio.of_polynomials([b0, b1, b2], [1, a1, a2])
            num, den = num * part.num, den * part.den
        return Ratio(num, den)

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

    @functools.cached_property
    def ratio(self):
        return Ratio.of_state_space(*(np.asarray(m) for m in ct.ssdata(self.space)))

    def response(self, omega):
        return response_of(self.space, np.expm1(1j * np.asarray(omega, float) * self.h))

    def near_zero(self):
        system = self.ratio.zpk()
        return zpk_near_zero(Zpk(system.zeros, np.where(np.abs(system.poles) < 1e-12, 0.0, system.poles), system.gain))


@dataclass(frozen=True)
class Metrics:
    stable: bool
    gamma: Optional[float]
    max_s: float
    max_t: float
    max_ks: float
    max_gs: float
    gain_margin: float
    phase_margin_deg: float
    delay_margin_s: float
    disk_margin: float
    crossover_rad_s: float
    bandwidth_rad_s: float
    ramp_error_n: float
    low_gain: float
    slowest_pole_rad_s: float

    def as_dict(self):
        """For JSON, which has neither: None for not a number, "inf" for infinite."""
        return {k: v if not isinstance(v, float) or np.isfinite(v) else "inf" if np.isinf(v) else None for k, v in asdict(self).items()}

    @classmethod
    def from_dict(cls, data):
        if set(data) != set(METRIC_NAMES):
            raise ValueError(f"metrics: not {', '.join(METRIC_NAMES)}")
        return cls(**{k: np.inf if v == "inf" else np.nan if v is None and k != "gamma" else v for k, v in data.items()})


METRIC_NAMES = [f.name for f in fields(Metrics)]


class Loop:
    def __init__(self, plant, controller, weights=None, h=None, ramp=None, roots=(), density=200):
        """`plant` and `controller` both continuous, or both sampled with `h`. `roots`: further corner frequencies. `density`: points a decade."""
        self.density = density
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
        count = int(min(self.density * max(np.log10(top / start), 1), 20 * self.density))
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
        k, g = self.controller.response(omega), self.plant.response(omega)
        loop = g * k
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            s = 1 / (1 + loop)
            t = np.where(np.isfinite(loop), loop / (1 + loop), 1.0)
            ks = k * s
        total = None
        if self.weights:
            points = 1j * np.asarray(omega, float)
            total = np.sqrt(sum(np.abs(x) ** 2 for x in self.terms(points, s, t, ks, g).values()))
        return s, t, ks, total

    def load(self, omega):
        """G S: what a force at the plant's input, such as friction, does to the output."""
        plant = self.plant.response(omega)
        return plant / (1 + plant * self.controller.response(omega))

    def terms(self, points, s, t, ks, plant):
        """Name -> weighted term, of those that have a weight."""
        parts = {"wp": ("wp S", s), "wu": ("wu KS", ks), "wT": ("wT T", t), "wGS": ("wGS GS", plant * s)}
        return {title: self.weights[name](points) * f for name, (title, f) in parts.items() if self.weights.get(name) is not None}

    def peak_term(self):
        """Where gamma peaks, and the largest term there."""
        s, t, ks, total = self.closed_loop(self.omega)
        i = int(np.nanargmax(total))
        at = self.omega[i : i + 1]
        terms = self.terms(1j * at, s[i : i + 1], t[i : i + 1], ks[i : i + 1], self.plant.response(at))
        return float(at[0]), max(terms, key=lambda name: abs(terms[name][0])), {name: float(abs(v[0])) for name, v in terms.items()}

    def closed_loop_poles(self):
        """In rad/s, or in d = z - 1; None when the loop is not well-posed."""
        return closed_loop_poles(self.plant.ratio, self.controller.ratio)

    def is_stable(self):
        if self._well_inside():
            return True
        poles = self.closed_loop_poles()
        if poles is None:
            return False
        if self.h is None:
            return bool(np.all(poles.real < 0))
        return bool(np.all(2 * poles.real + np.abs(poles) ** 2 < 0))  # d = z - 1: |1 + d| < 1

    def _well_inside(self):
        """Whether a sampled loop's eigenvalues are so far inside the unit circle that their rounding does not matter."""
        if self.h is None or self.plant.space.nstates == 0 or self.controller.space.nstates == 0:
            return False
        if abs(1 + self.plant.space.D[0, 0] * self.controller.space.D[0, 0]) < 1e-6:
            return False
        closed = balanced_scaling(ct.feedback(ct.series(self.controller.space, self.plant.space), 1))
        size = float(np.abs(1 + np.linalg.eigvals(closed.A)).max())
        return size < 1 - 1e-4 and np.linalg.norm(closed.A) < 1e6

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

    def low_gain(self):
        """|L| at the slowest frequency that matters, one over the ramp's duration."""
        if self.ramp is None:
            return np.nan
        omega = 1 / self.ramp.duration_s
        return float(np.abs(self.open_loop(np.array([omega if self.h is None else min(omega, np.pi / self.h)]))[0]))

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
            max_gs=self._peak(np.abs(self.load(self.omega)), lambda w: np.abs(self.load(w))),
            disk_margin=1 / self._peak(np.abs(s - t) / 2, lambda w: np.abs(np.subtract(*self.closed_loop(w)[:2])) / 2),
            low_gain=self.low_gain(),
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
