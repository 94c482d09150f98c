"""Single-input single-output systems as zeros, poles and gain, and their state-space realisations.

Zeros, poles and gain are the form that the whole tool calculates in: roots keep their relative precision over
the nine decades between a slow controller pole and a fast sensor pole, polynomial coefficients do not.
The same class serves continuous time (roots in rad/s, variable s) and discrete time in the delta operator
d = z - 1 of lib/include/tribo/biquad_f32.h; who holds a system knows which.
"""

from dataclasses import dataclass, field

import control as ct
import numpy as np
import scipy.linalg
import scipy.signal


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


def state_space(system):
    """A state-space realisation of a proper Zpk: blocks of order 1 and 2 in series, fastest first."""
    pole_groups = sorted(quadratics(system.poles), key=lambda group: -abs(group[0]))
    partner = {}
    for zeros in sorted(quadratics(system.zeros), key=lambda group: (-len(group), -abs(group[0]))):
        free = [i for i, poles in enumerate(pole_groups) if i not in partner and len(poles) >= len(zeros)]
        partner[min(free, key=lambda i: _distance(zeros, pole_groups[i]))] = zeros
    blocks = [(partner.get(i, ()), poles) for i, poles in enumerate(pole_groups)]
    total, gain = None, system.gain
    for zeros, poles in blocks:
        num, den = np.atleast_1d(np.real(np.poly(zeros))), np.real(np.poly(poles))
        scale = den[-1] / num[-1] if num[-1] != 0 and den[-1] != 0 else 1.0
        gain /= scale
        block = ct.ss(*scipy.signal.tf2ss(num * scale, den), remove_useless_states=False)
        block = balanced_scaling(block)
        total = block if total is None else ct.series(total, block)
    if total is None:
        return ct.ss([], [], [], [[gain]])
    return ct.ss(total.A, total.B, total.C * gain, total.D * gain, remove_useless_states=False)


def _distance(group, other):
    return abs(np.log((abs(group[0]) + 1e-30) / (abs(other[0]) + 1e-30)))


def balanced_scaling(system):
    """The same system with its states scaled by powers of two (LAPACK's balancing)."""
    if system.nstates == 0:
        return system
    a, (scale, _) = scipy.linalg.matrix_balance(system.A, permute=False, separate=True)
    b, c = system.B / scale[:, None], system.C * scale[None, :]
    ratio = np.sqrt(max(np.linalg.norm(c), 1e-300) / max(np.linalg.norm(b), 1e-300))
    ratio = 2.0 ** np.round(np.log2(ratio)) if np.isfinite(ratio) and ratio > 0 else 1.0
    return ct.ss(a, b * ratio, c / ratio, system.D, remove_useless_states=False)


def zpk_of(system):
    """Zeros, poles and gain of a minimal state-space system (LAPACK's poles, slycot's or LAPACK's zeros).

    Zero finders take a large finite zero for an infinite one, or the other way round, when a system spans many
    decades. So several are asked, and the answer is the one whose response is nearest to the system's own.
    """
    if system.nstates == 0:
        return Zpk(gain=system.D[0, 0])
    poles = _pair(np.linalg.eigvals(system.A))
    size = np.abs(poles[np.abs(poles) > 0])
    omega = np.geomspace(size.min() / 10, size.max() * 10, 200) if len(size) else np.ones(1)
    wanted = np.array([system(1j * w) for w in omega])
    middle = float(np.exp(np.mean(np.log(omega))))
    best = None
    for zeros in _zero_sets(system, size):
        if len(zeros) > len(poles):
            continue
        try:
            shape = Zpk(_pair(zeros), poles, 1.0)
        except ValueError:
            continue
        with np.errstate(all="ignore"):
            ratio = np.real(wanted / shape(1j * omega))
            gain = np.median(ratio[np.isfinite(ratio)]) if np.any(np.isfinite(ratio)) else 0.0
            found = Zpk(shape.zeros, shape.poles, gain)
            error = np.abs(found(1j * omega) / wanted - 1)
        error = float(np.sort(error[np.isfinite(error)])[: int(0.9 * len(omega))].max(initial=0)) if np.any(np.isfinite(error)) else np.inf
        if best is None or error < best[0]:
            best = (error, found)
    if best is None:
        raise ValueError("no zeros and poles describe this system")
    found = best[1]
    point = 1j * middle
    return found.with_value_at(point, system(point)) if abs(found(point)[0]) > 0 else found


def _zero_sets(system, size):
    sets = []
    if len(size):
        scale = float(np.exp(np.mean(np.log(size))))
        scaled = balanced_scaling(ct.ss(system.A / scale, system.B / scale, system.C, system.D, remove_useless_states=False))
        for candidate, factor in ((system, 1.0), (scaled, scale)):
            sets.append(candidate.zeros() * factor)
        n = system.nstates
        pencil = np.block([[scaled.A, scaled.B], [scaled.C, scaled.D]])
        with np.errstate(all="ignore"):
            sets.append(scipy.linalg.eigvals(pencil, np.diag([1.0] * n + [0.0])) * scale)
        # With the fastest mode taken as instantaneous there is a direct feedthrough, and the zeros are eigenvalues.
        values, vectors = np.linalg.eig(scaled.A)
        fastest = int(np.argmax(np.abs(values)))
        if abs(values[fastest].imag) == 0:
            try:
                b, c = np.linalg.solve(vectors, scaled.B.astype(complex)), scaled.C @ vectors
                keep = np.arange(n) != fastest
                through = scaled.D[0, 0] - c[0, fastest] * b[fastest, 0] / values[fastest]
                sets.append(np.linalg.eigvals(np.diag(values[keep]) - b[keep] @ c[:, keep] / through) * scale)
            except np.linalg.LinAlgError:
                pass
    else:
        sets.append(system.zeros())
    out = []
    limit = 1e3 * size.max() if len(size) else np.inf
    for zeros in sets:
        zeros = np.asarray(zeros, complex)
        zeros = zeros[np.isfinite(zeros)]
        zeros = zeros[np.abs(zeros) < limit]
        # Rounding breaks the symmetry of a complex eigenvalue problem; tell real from complex again.
        zeros = np.where(np.abs(zeros.imag) < 1e-8 * np.abs(zeros), zeros.real, zeros)
        out.append(zeros)
        ordered = zeros[np.argsort(np.abs(zeros))]
        for drop in (1, 2):
            if len(ordered) > drop:
                out.append(ordered[:-drop])
    return out


def _pair(roots):
    """Conjugate symmetry restored: eigenvalues of real matrices pair to rounding only."""
    roots = np.asarray(roots, complex)
    return np.r_[roots[np.abs(roots.imag) <= 1e-12 * np.abs(roots)].real.astype(complex),
                 _mirror(roots[roots.imag > 1e-12 * np.abs(roots)])]


def _mirror(upper):
    return np.r_[upper, np.conj(upper)]


def round_roots(roots, digits):
    """Roots rounded to `digits` significant digits of their size, real and imaginary part alike."""
    return np.array([complex(_round(r.real, abs(r), digits), _round(r.imag, abs(r), digits)) for r in roots], complex)


def round_value(value, digits):
    return _round(value, abs(value), digits)


def _round(part, size, digits):
    if size == 0 or not np.isfinite(size):
        return part
    return float(round(part, digits - 1 - int(np.floor(np.log10(size)))))
