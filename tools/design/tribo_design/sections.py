"""K(z) as a cascade of the library's sections: which roots share a section, in what order, with what gains.

Rules, and why:
* The section with the slowest pole is last. Its state then holds the output itself, which is what a bumpless change and the
  anti-windup work on, and no rounding of an earlier section is left in a state that forgets slowly.
* All other freedom (which poles and zeros share a section, the order of the earlier sections) goes to the least
  rounding noise at the output: each section's output is rounded to Q31, and that noise passes d^2/(d^2 + a1 d + a2) of its own
  section and all sections after it. All groupings are tried (up to 2,000; beyond, real roots are grouped by size only).
* An earlier section has gain 1 at rest, so that a change of controller finds like signals between like sections. In float no more
  scaling is needed; in Q31 the library holds each section's output times a power of two, 2^-scale, by the worst case of its
  l1 norm (lib/src/controller/headroom_q31.c), and the noise is judged with such scales.
"""

import itertools
from dataclasses import dataclass

import numpy as np
import scipy.signal

from .errors import DesignError

SECTIONS_MAX = 4  # TRIBO_BIQUAD_SECTIONS_MAX
COEFFICIENT_MAX = 1e6
FEEDTHROUGH_MIN = 1e-6
TRIES_MAX = 2000


@dataclass(frozen=True)
class Cascade:
    sections: np.ndarray  # rows b0, b1, b2, a1, a2 in d
    peaks: list  # l1 norm from the input to each section's output; the last one is limited by the actuator's limit
    tried: int


def make_cascade(system, h):
    """`system`: Zpk in d. DesignError names what the library's sections cannot hold."""
    if system.relative_degree != 0:
        raise DesignError("sections: K(z) has no direct feedthrough, which the library's sections need: discretisation.method tustin gives one to a strictly proper K")
    if system.order > 2 * SECTIONS_MAX:
        raise DesignError(f"sections: K(z) is of order {system.order}; the library runs at most {2 * SECTIONS_MAX}")
    _check_stable(system)
    if system.order == 0:  # a gain: both roots of its section at z = 0
        return Cascade(system.gain * np.array([[1.0, 2.0, 1.0, 0, 0]]) + np.array([[0, 0, 0, 2.0, 1.0]]), [abs(system.gain)], 1)
    best = None
    tried = 0
    for poles, zeros in _groupings(system):
        for order in _orders(poles):
            tried += 1
            sections, peaks = _unit_gains(np.array([_section(zeros[i], poles[i]) for i in order]), system, samples=2048)
            noise = rounding_noise(sections, [*map(node_scale, peaks[:-1]), 0])
            if best is None or noise < best[0] * (1 - 1e-6):
                best = (noise, sections)
        if tried >= TRIES_MAX:
            break
    sections, peaks = _unit_gains(best[1] / np.array([[b0, b0, b0, 1, 1] for b0 in best[1][:, 0]]), system)
    check_sections(sections)
    return Cascade(sections, peaks, tried)


def _check_stable(system):
    outside = [p for p in system.poles if not 2 * p.real + abs(p) ** 2 < 0 and p != 0]  # |1 + p| < 1, to the last bit
    if outside:
        raise DesignError(f"sections: K(z) is unstable: pole z = {1 + outside[0]:.9g} is not inside the unit circle")
    if np.sum(system.poles == 0) > 1:
        raise DesignError("sections: K(z) has two poles at z = 1; the library accepts one integrator")


def _groupings(system):
    """Ways to share out roots: (pole groups, zero groups in the same order)."""
    pole_ways, zero_ways = list(_pairings(system.poles)), list(_pairings(system.zeros))
    count = len(pole_ways) * len(zero_ways)
    n = (system.order + 1) // 2
    for i in range(2, n + 1):
        count *= i
    if count * max(1, n - 1) > TRIES_MAX:
        pole_ways, zero_ways = pole_ways[:1], zero_ways[:1]
    for poles in pole_ways:
        for zeros in zero_ways:
            for order in itertools.permutations(zeros):
                if all(len(z) == len(p) for p, z in zip(poles, order)):
                    yield poles, order


def _pairings(roots):
    """Groups of two, conjugates together, real roots in every way; with an odd count one stays alone. Sorted neighbours (slowest
    with fastest) come first."""
    pairs = [(r, np.conj(r)) for r in roots if r.imag > 0]
    reals = sorted((r for r in roots if r.imag == 0), key=abs)
    seen = set()
    first = _slow_with_fast(reals)
    for way in itertools.chain([first], _matchings(reals)):
        key = tuple(sorted(tuple(sorted((g.real for g in group))) for group in way))
        if key not in seen:
            seen.add(key)
            yield pairs + list(way)


def _slow_with_fast(reals):
    reals = list(reals)
    way = []
    if len(reals) % 2:
        way.append((reals.pop(len(reals) // 2),))
    while reals:
        way.append((reals.pop(0), reals.pop()))
    return way


def _matchings(reals):
    if len(reals) <= 1:
        yield [tuple(reals)] if reals else []
        return
    if len(reals) % 2:
        for i in range(len(reals)):
            for rest in _matchings(reals[:i] + reals[i + 1 :]):
                yield [(reals[i],), *rest]
        return
    for i in range(1, len(reals)):
        for rest in _matchings(reals[1:i] + reals[i + 1 :]):
            yield [(reals[0], reals[i]), *rest]


def _orders(poles):
    slowest = min(range(len(poles)), key=lambda i: min(abs(p) for p in poles[i]))
    others = [i for i in range(len(poles)) if i != slowest]
    for order in itertools.permutations(others):
        yield [*order, slowest]


def _section(zeros, poles):
    """Monic numerator; a lone root's partner is z = 0, d = -1."""
    if len(poles) == 1:
        zeros, poles = (zeros[0], -1.0), (poles[0], -1.0)
    b1, b2 = _sum_and_product(zeros)
    a1, a2 = _sum_and_product(poles)
    return (1.0, b1, b2, a1, a2)


def _sum_and_product(roots):
    return float(np.real(-(roots[0] + roots[1]))), float(np.real(roots[0] * roots[1]))


_D = np.expm1(1j * np.pi * np.geomspace(1e-5, 1, 400))
_WIDTH = np.gradient(np.geomspace(1e-5, 1, 400))


def rounding_noise(sections, scales):
    """Output noise in LSB rms, in open loop: each section's output rounded to 2^scale LSB (of variance 1/12, white)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        b0, b1, b2, a1, a2 = (c[:, None] for c in np.asarray(sections).T)
        denominator = _D**2 + a1 * _D + a2
        response = (b0 * _D**2 + b1 * _D + b2) / denominator
        shape = _D**2 / denominator
    total, after = 0.0, np.ones(len(_D))
    for i in reversed(range(len(sections))):
        total += 4.0 ** scales[i] * np.sum(np.abs(shape[i] * after) ** 2 * _WIDTH) / 12
        after = after * response[i]
    return float(np.sqrt(total))


def node_scale(peak):
    """The least power of two that takes a peak within full scale."""
    return max(int(np.ceil(np.log2(peak))), 0) if 0 < peak < np.inf else 0


def _unit_gains(sections, system, samples=1 << 17):
    """Gain 1 at rest for all but the last (or 1 at the peak, where there is none at rest), and the l1 norms up to each."""
    sections = np.array(sections)
    gain_left = system.gain
    peaks = []
    for i in range(len(sections) - 1):
        b0, b1, b2, a1, a2 = sections[i]
        if b2 != 0 and a2 != 0:
            unit = abs(a2 / b2)
        else:
            unit = 1.0 / max(np.abs((_D**2 + b1 * _D + b2) / (_D**2 + a1 * _D + a2)).max(), 1e-12)
        sections[i, :3] *= unit
        peaks.append(_l1(sections[: i + 1], samples))
        gain_left /= sections[i, 0]
    sections[-1, :3] *= gain_left
    peaks.append(_l1(sections, samples))
    return sections, [float(p) for p in peaks]


def _l1(sections, samples):
    """Sum of the impulse response's magnitudes; what is left after `samples` is a slow mode of one sign: its sum is the
    steady gain's remainder."""
    sos = to_z(sections)
    impulse = np.zeros(samples)
    impulse[0] = 1.0
    response = scipy.signal.sosfilt(sos, impulse)
    total = float(np.abs(response).sum())
    with np.errstate(divide="ignore", invalid="ignore"):
        steady = float(np.prod(sections[:, 2] / sections[:, 4]))
    if np.isfinite(steady):
        tail = abs(steady - float(response.sum()))
        if tail > 1e-6 * total:
            total += tail
    elif np.isinf(steady):
        return np.inf
    return total


def to_z(sections):
    """Rows b0, b1, b2, 1, a1, a2 in z^-1, as scipy takes them."""
    b0, b1, b2, a1, a2 = np.asarray(sections).T
    return np.stack([b0, b1 - 2 * b0, b0 - b1 + b2, np.ones_like(a1), a1 - 2, 1 - a1 + a2], axis=1)


def check_sections(sections):
    """What tribo_biquad_f32_init and tribo_controller_f32_init accept."""
    for i, (b0, b1, b2, a1, a2) in enumerate(sections):
        if not all(abs(c) <= COEFFICIENT_MAX for c in (b0, b1, b2)):
            raise DesignError(f"sections: section {i + 1} has a coefficient of {max(abs(b0), abs(b1), abs(b2)):.4g}; the library accepts up to {COEFFICIENT_MAX:g}: "
                              "lower the controller's high-frequency gain (raise wu)")
        if not abs(b0) >= FEEDTHROUGH_MIN:
            raise DesignError(f"sections: section {i + 1} has a direct feedthrough of {b0:.4g}; the library needs at least {FEEDTHROUGH_MIN:g}")
        if not (0 <= a2 < a1 and 4 - 2 * a1 + a2 > 0):
            raise DesignError(f"sections: section {i + 1} is not stable in the library's terms (a1 {a1:.9g}, a2 {a2:.9g})")
