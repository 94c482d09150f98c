"""State-space realisations of zeros, poles and gain."""

import control as ct
import numpy as np
import scipy.signal
import slycot

from .zpk import quadratics


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
    """The same system with its states scaled by powers of two (SLICOT's TB01ID)."""
    if system.nstates == 0:
        return system
    _, a, b, c, _ = slycot.tb01id(system.nstates, 1, 1, 0.0, *(np.array(m, float) for m in (system.A, system.B, system.C)))
    return ct.ss(a, b, c, system.D, remove_useless_states=False)
