"""Single-input single-output systems as zeros, poles and gain, and their state-space realisations.

Zeros, poles and gain are the form that the whole tool calculates in: roots keep their relative precision over
the nine decades between a slow controller pole and a fast sensor pole, polynomial coefficients do not.
The same class serves continuous time (roots in rad/s, variable s) and discrete time in the delta operator
d = z - 1 of lib/src/controller/biquad_f32.h; who holds a system knows which.
"""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Zpk:
    """gain * prod(x - zeros) / prod(x - poles), with roots in conjugate pairs."""

    zeros: np.ndarray = field(default_factory=lambda: np.zeros(0, complex))
    poles: np.ndarray = field(default_factory=lambda: np.zeros(0, complex))
    gain: float = 1.0

    def __post_init__(self):
        object.__setattr__(self, "zeros", tidy_roots(self.zeros))
        object.__setattr__(self, "poles", tidy_roots(self.poles))
        object.__setattr__(self, "gain", float(np.real(self.gain)))

    @property
    def order(self):
        return len(self.poles)

    @property
    def relative_degree(self):
        return len(self.poles) - len(self.zeros)

    def __call__(self, points):
        """The response at complex points; numerator and denominator are multiplied up root by root, pairwise,
        so that neither overflows."""
        points = np.atleast_1d(np.asarray(points, complex))
        value = np.full(points.shape, self.gain, complex)
        zeros, poles = list(self.zeros), list(self.poles)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            for i in range(max(len(zeros), len(poles))):
                if i < len(zeros):
                    value = value * (points - zeros[i])
                if i < len(poles):
                    value = value / (points - poles[i])
        return value

    def __mul__(self, other):
        return Zpk(np.r_[self.zeros, other.zeros], np.r_[self.poles, other.poles], self.gain * other.gain)

    def at_zero(self):
        """The value at 0: the steady gain. Infinite with a pole at 0."""
        if np.any(self.poles == 0):
            return np.inf * np.sign(self.gain) if not np.any(self.zeros == 0) else np.nan
        return float(np.real(self(0.0)[0]))

    def with_value_at(self, point, value):
        """The same roots, with the gain that gives `value` (its real ratio) at `point`."""
        here = self(point)[0]
        return Zpk(self.zeros, self.poles, self.gain * float(np.real(value / here)))


def tidy_roots(roots):
    """Roots as a complex array in a fixed order, with exact conjugates and exact reals."""
    roots = np.atleast_1d(np.asarray(roots, complex)).ravel()
    real = [r for r in roots if abs(r.imag) <= 1e-13 * abs(r)]
    upper = [r for r in roots if r.imag > 1e-13 * abs(r)]
    lower = [r for r in roots if r.imag < -1e-13 * abs(r)]
    if len(upper) != len(lower):
        raise ValueError("complex roots must come in conjugate pairs")
    upper.sort(key=lambda r: (abs(r), r.real))
    tidy = [complex(r.real, 0.0) for r in sorted(real, key=lambda r: (abs(r.real), r.real))]
    left = list(lower)
    for root in upper:
        partner = min(left, key=lambda r: abs(np.conj(r) - root))
        left.remove(partner)
        if abs(np.conj(partner) - root) > 1e-6 * abs(root):
            raise ValueError("complex roots must come in conjugate pairs")
        mean = 0.5 * (root + np.conj(partner)) if partner != np.conj(root) else root
        tidy += [mean, np.conj(mean)]
    return np.array(tidy, complex)


def quadratics(roots):
    """Groups tidy roots into factors: conjugate pairs, and real roots two by two (the last may stay alone)."""
    pairs = [(roots[i], roots[i + 1]) for i in range(len(roots)) if roots[i].imag > 0]
    reals = [r for r in roots if r.imag == 0]
    return pairs + [tuple(reals[i : i + 2]) for i in range(0, len(reals), 2)]


def round_roots(roots, digits):
    """Roots rounded to `digits` significant digits of their size, real and imaginary part alike."""
    return np.array([complex(_round(r.real, abs(r), digits), _round(r.imag, abs(r), digits)) for r in roots], complex)


def round_value(value, digits):
    return _round(value, abs(value), digits)


def _round(part, size, digits):
    if size == 0 or not np.isfinite(size):
        return part
    return float(round(part, digits - 1 - int(np.floor(np.log10(size)))))
