"""K(s) to K(z), root by root, in the delta operator d = z - 1.

A pole p of the slow kind is exp(p h) - 1 or 2p/(2/h - p) in d, with all its digits; through z it would lose as many
as it is close to 1. scipy's cont2discrete gives what has no formula per root: the zeros of a zero-order hold.
"""

import numpy as np
import scipy.signal

from .errors import DesignError
from .exact import zpk_of
from .systems import state_space
from .zpk import Zpk
import control as ct


def discretise(system, settings, h):
    """K(z) in d. The steady gain is K(s)'s to the last digit (the leading gain with an integrator)."""
    method = settings.method
    if method in ("tustin", "tustin-prewarped"):
        return tustin(system, h, settings.prewarp_rad_s)
    if method == "matched":
        return matched(system, h)
    return zero_order_hold(system, h)


def tustin(system, h, prewarp=None):
    """s = c d/(d + 2), c = 2/h or w/tan(w h/2): (s - p) becomes (c - p)(d - 2p/(c - p))/(d + 2)."""
    c = 2 / h if prewarp is None else prewarp / np.tan(prewarp * h / 2)
    if np.any(np.abs(c - system.zeros) < 1e-12 * c):
        raise DesignError(f"discretisation: the zero at {c:g} rad/s has no image under Tustin's rule; choose another method")
    zeros = np.r_[2 * system.zeros / (c - system.zeros), np.full(system.relative_degree, -2.0)]
    poles = 2 * system.poles / (c - system.poles)
    ratio = np.prod(c - system.zeros) / np.prod(c - system.poles)
    return _gain(Zpk(zeros, poles, float(np.real(system.gain * ratio))), system, h)


def matched(system, h):
    """Poles and zeros to exp(s h); zeros at infinity to z = -1, as the library's sections need direct feedthrough."""
    zeros = np.r_[np.expm1(system.zeros * h), np.full(system.relative_degree, -2.0)]
    return _gain(Zpk(zeros, np.expm1(system.poles * h), 1.0), system, h)


def zero_order_hold(system, h):
    if system.order == 0:
        return system
    if system.relative_degree > 0:
        raise DesignError("discretisation: zero-order hold of a strictly proper K(s) has no direct feedthrough, which the library's sections need; "
                          "use tustin or matched")
    a, b, c, d = ct.ssdata(state_space(system))
    phi, gamma, c, d, _ = scipy.signal.cont2discrete((a, b, c, d), h, "zoh")
    shifted = zpk_of(ct.ss(phi - np.eye(len(phi)), gamma, c, d, remove_useless_states=False))
    zeros = shifted.zeros.copy()
    at_rest = np.argsort(np.abs(zeros))[: int(np.sum(system.zeros == 0))]
    zeros[at_rest] = 0.0  # a zero at rest stays there exactly
    return _gain(Zpk(zeros, np.expm1(system.poles * h), float(d[0, 0])), system, h)


def _gain(sampled, system, h):
    if np.any(system.poles == 0) or np.any(system.zeros == 0):
        # s becomes d/h near rest: match c of c / s^n.
        n = int(np.sum(system.poles == 0) - np.sum(system.zeros == 0))
        slow = Zpk(system.zeros[system.zeros != 0], system.poles[system.poles != 0], system.gain)(0.0)[0] * h**n
        here = Zpk(sampled.zeros[sampled.zeros != 0], sampled.poles[sampled.poles != 0], 1.0)(0.0)[0]
        return Zpk(sampled.zeros, sampled.poles, float(np.real(slow / here)))
    return sampled.with_value_at(0.0, system.at_zero())
