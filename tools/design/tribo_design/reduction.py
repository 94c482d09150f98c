"""Reduces the synthesised controller to an order that a microcontroller can run.

modal     removes modes beyond a multiple of the Nyquist frequency (their steady value stays), all or only the fastest of
          them, then cancels poles with the zeros next to them, the closest first
balanced  balanced truncation (python-control's balred), every order from 1 on
auto      both

Each candidate is closed into the loop; the lowest order whose loop is within the limits of the step is taken. What
is taken is then rounded to a few digits, so that the last bits of a machine's linear algebra do not reach the C;
the candidates are rounded before they are judged.
"""

import warnings
from dataclasses import dataclass

import control as ct
import numpy as np

from .exact import zpk_of
from .zpk import Zpk, round_roots, round_value


@dataclass(frozen=True)
class Candidate:
    zpk: Zpk
    how: str


def candidates(controller, settings, h):
    """Candidates, the lowest order first, none above settings.order_max."""
    found = []
    if settings.method in ("modal", "auto"):
        found += _modal(controller, settings, h)
    if settings.method in ("balanced", "auto"):
        found += _balanced(controller, settings)
    found = [Candidate(rounded(c.zpk, settings.digits), c.how) for c in found if c.zpk.order <= settings.order_max]
    return sorted(found, key=lambda c: c.zpk.order)


def _modal(controller, settings, h):
    full = controller.zpk
    if full is None:
        return []
    bound = settings.fast_mode_multiple * np.pi / h
    fast = sorted({round(float(abs(p)), 9) for p in full.poles if abs(p) > bound})
    found = []
    for keep_below in [bound, *(f * (1 + 1e-6) for f in fast)]:
        slow = _without_fast(full, keep_below)
        removed = full.order - slow.order
        how = "nothing removed" if not removed else f"{removed} modes beyond {max(keep_below * h / np.pi, settings.fast_mode_multiple):.3g} x Nyquist removed"
        found.append(Candidate(slow, how))
        current = slow
        while (pair := _closest_pair(current)) is not None and pair[0] <= settings.cancellation_percent / 100:
            current = _without(current, pair[1], pair[2])
            found.append(Candidate(current, f"{how}, {slow.order - current.order} poles cancelled with zeros within {100 * pair[0]:.2g} %"))
    unique = {}
    for candidate in found:  # of two candidates of the same order, the second keeps more
        unique.setdefault((candidate.zpk.order, tuple(candidate.zpk.poles)), candidate)
    return list(unique.values())


def _anchor(system):
    """Where a removal keeps the gain: at rest, or with an integrator or a zero there, low in the band."""
    roots = np.abs(np.r_[system.poles, system.zeros])
    if np.all(roots > 0):
        return 0.0
    return 1j * 1e-3 * float(roots[roots > 0].min()) if np.any(roots > 0) else 1j


def _without_fast(system, bound):
    poles, fast = [p for p in system.poles if abs(p) <= bound], [p for p in system.poles if abs(p) > bound]
    zeros = [z for z in system.zeros if abs(z) <= bound]
    fast.sort(key=abs)
    while len(zeros) > len(poles) and fast:  # keep the system proper: keep the slowest of the fast poles
        pole = fast.pop(0)
        poles.append(pole)
        if pole.imag:
            twin = next(p for p in fast if p == np.conj(pole))
            fast.remove(twin)
            poles.append(twin)
    if not poles:
        return Zpk(gain=np.real(system(_anchor(system))[0]))
    anchor = _anchor(system)
    return Zpk(zeros, poles, 1.0).with_value_at(anchor, system(anchor)[0])


def _closest_pair(system):
    best = None
    for pole in system.poles:
        for zero in system.zeros:
            if (pole.imag > 0) != (zero.imag > 0) or pole.imag < 0 or zero.imag < 0 or pole == 0:
                continue
            distance = abs(pole - zero) / abs(pole)
            if best is None or distance < best[0]:
                best = (distance, pole, zero)
    return best


def _without(system, pole, zero):
    poles, zeros = list(system.poles), list(system.zeros)
    poles.remove(pole)
    zeros.remove(zero)
    if pole.imag:
        poles.remove(np.conj(pole))
        zeros.remove(np.conj(zero))
    anchor = _anchor(system)
    return Zpk(zeros, poles, 1.0).with_value_at(anchor, system(anchor)[0])


def _balanced(controller, settings):
    found = []
    space = controller.space
    for order in range(1, min(settings.order_max, space.nstates) + 1):
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                reduced = ct.balred(space, order)
            zpk = zpk_of(reduced)
        except Exception:  # noqa: BLE001 - an order that the truncation cannot give is no candidate
            continue
        if zpk.order and np.all(np.isfinite(zpk.poles)) and np.all(zpk.poles.real < 0) and np.isfinite(zpk.gain):
            zeros = zpk.zeros[np.abs(zpk.zeros) < 1e9 * np.abs(zpk.poles).max()]
            if len(zeros) < len(zpk.zeros):
                zpk = Zpk(zeros, zpk.poles, 1.0).with_value_at(0.0, zpk.at_zero())
            found.append(Candidate(zpk, f"balanced truncation to order {order}"))
    return found


def rounded(system, digits):
    rounded = Zpk(round_roots(system.zeros, digits), round_roots(system.poles, digits), 1.0)
    anchor = _anchor(rounded)
    if anchor == 0.0:
        return rounded.with_value_at(0.0, round_value(system.at_zero(), digits))
    return Zpk(rounded.zeros, rounded.poles, round_value(system.gain, digits))
