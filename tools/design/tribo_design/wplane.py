"""Represents the sampled loop as a continuous one: w = (2/h) (z - 1)/(z + 1).

The plant behind hold and delay becomes rational in w, exactly, and the unit circle the imaginary axis, so the continuous solver designs K(w),
and Tustin's rule gives back K(z) without any loss. Frequencies are bent: w = j v with v = (2/h) tan(omega h/2). The weights mean
|W(j omega)|, so each is fitted in w to that magnitude, order for order, with most care where it decides gamma.
"""

import numpy as np
import scipy.optimize

from .zpk import Zpk

SLOW = 0.01  # a root below this times 1/h changes by less than 1e-5 and is kept
SPAN = 1.5  # how far, in powers of e, a fitted root may move


def bend(omega, h):
    return 2 / h * np.tan(np.asarray(omega) * h / 2)


def unbend(v, h):
    return 2 / h * np.arctan(np.asarray(v) * h / 2)


def to_w(system, h):
    """G(z), a Zpk in d = z - 1, in w: w = c d/(d + 2), c = 2/h. Zeros at z = infinity come to w = c; roots at z = -1 go to infinity."""
    c = 2 / h
    zeros, poles = (r[np.abs(2 + r) > 1e-12] for r in (system.zeros, system.poles))
    bent = Zpk(np.r_[c * zeros / (2 + zeros), np.full(system.relative_degree, c)], c * poles / (2 + poles), 1.0)
    w = 1j * c * 0.1
    d = 2 * w / (c - w)
    return Zpk(bent.zeros, bent.poles, float(np.real(system(d)[0] / bent(w)[0])))


class WeightFit:
    """One weight in w, fitted to |W(j omega)|."""

    def __init__(self, weight, h):
        self.weight, self.h = weight, h
        c = 2 / h
        zeros = np.r_[weight.zeros, np.full(weight.relative_degree, -5 * c)] if weight.relative_degree > 0 else weight.zeros
        self.fixed, self.free = ([], []), ([], [])
        for i, roots in enumerate((zeros, weight.poles)):
            for root in roots:
                if abs(root) * h < SLOW:
                    self.fixed[i].append(root)
                elif root.imag >= 0:
                    moved = c * np.tanh(root * h / 2) if abs(root) < c else root / abs(root) * c
                    self.free[i].append(moved)
        self.start = np.concatenate([[0.0], *([np.log(abs(r))] + ([np.angle(r)] if r.imag > 0 else []) for roots in self.free for r in roots)])

    def system(self, theta):
        values, out = list(theta[1:]), []
        for fixed, free in zip(self.fixed, self.free):
            roots = list(fixed)
            for root in free:
                size = np.exp(values.pop(0))
                if root.imag > 0:
                    angle = values.pop(0)
                    roots += [size * np.exp(1j * angle), size * np.exp(-1j * angle)]
                else:
                    roots.append(size * np.sign(root.real))
            out.append(roots)
        return Zpk(*out, np.sign(self.weight.gain) * np.exp(theta[0]))

    def fitted(self, omega, care):
        """The weight whose magnitude is |W(j omega)| at v, with `care` for each frequency."""
        if self.weight.order == 0:
            return self.weight
        v = bend(omega, self.h)
        with np.errstate(divide="ignore"):
            wanted = np.log(np.abs(self.weight(1j * omega)))
        care = np.where(np.isfinite(wanted), care, 0.0)
        wanted = np.where(np.isfinite(wanted), wanted, 0.0)

        def misfit(theta):
            with np.errstate(divide="ignore"):
                return care * np.clip(np.log(np.abs(self.system(theta)(1j * v))) - wanted, -50, 50)

        start = self.start.copy()
        with np.errstate(divide="ignore"):
            start[0] = float(np.median(wanted - np.log(np.abs(self.system(start)(1j * v)))))
        span = np.r_[20.0, np.full(len(start) - 1, SPAN)]
        kinds = [k for roots in self.free for r in roots for k in ([False, True] if r.imag > 0 else [False])]
        for i, angle in enumerate(kinds, 1):
            if angle:  # a complex pair stays a pair, on the same side of the axis
                limit = (0.0, np.pi / 2) if start[i] < np.pi / 2 else (np.pi / 2, np.pi)
                span[i] = 0.9 * min(start[i] - limit[0], limit[1] - start[i]) + 1e-12
        found = scipy.optimize.least_squares(misfit, start, bounds=(start - span, start + span), x_scale=np.r_[1.0, np.full(len(start) - 1, 0.3)], max_nfev=200)
        return self.system(found.x)


def fit_grid(h, corners):
    """Frequencies for the fit: up to Nyquist, closer together towards it."""
    low = max(min(np.min(corners, initial=np.inf), 0.01 / h) / 10, 1e-9 / h)
    return np.unique(np.r_[np.geomspace(low, 0.98 * np.pi / h, 300), np.linspace(0.3, 0.99, 60) * np.pi / h])
