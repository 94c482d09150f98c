"""Checks what the final loop tolerates: plants within the stated percentages, simultaneous changes of gain and phase, and mu.

Corners and a seeded interior of the plant's ranges are closed with the Q31 controller, hold and delay included, each judged exactly. Mu (SLICOT's
AB13MD) bounds what lies between: 1/mu is by how much all ranges can grow before some plant in them may be unstable; it takes the plant
as continuous and the hold as its frequency response, without aliasing.
"""

import itertools

import numpy as np
import slycot

from .reading import format_root
from .errors import DesignError
from .loop import Loop, SampledPlant
from .systems import state_space
from .zpk import Zpk

CORNERS_MAX = 64
INTERIOR = 60
SEED = 1
DAMPING_LIGHT = 0.1
CANCELLED = 0.2  # distance of a zero of K from a lightly damped plant pole, of the pole


def ranges(plant):
    """[(what, kind, index, fraction)] of a config.Plant: a complex pair is one."""
    out = [("gain", "gain", 0, plant.gain_percent / 100)] if plant.gain_percent else []
    if plant.delay_s and plant.delay_percent:
        out.append(("dead time", "delay", 0, plant.delay_percent / 100))
    for name in ("poles", "zeros"):
        percents = getattr(plant, f"{name}_percent")
        for i, (root, percent) in enumerate(zip(getattr(plant, name), percents)):
            if percent and root.imag >= 0:
                out.append((f"{name[:-1]} {format_root(root)}", name, i, percent / 100))
    return out


def moved(plant, nominal, chosen):
    """(Zpk, dead time) with each range at `chosen` times its fraction. The steady gain stays, but for its own range."""
    roots = {"poles": np.array(plant.poles, complex), "zeros": np.array(plant.zeros, complex)}
    gain, delay = 1.0, plant.delay_s
    for (_, kind, i, fraction), x in zip(ranges(plant), chosen):
        factor = 1 + x * fraction
        if kind == "gain":
            gain = factor
        elif kind == "delay":
            delay *= factor
        else:
            pair = roots[kind] == np.conj(roots[kind][i])
            roots[kind][i] *= factor
            if roots[kind][i].imag:
                roots[kind][np.flatnonzero(pair)[0]] *= factor
    system = Zpk(roots["zeros"], roots["poles"], nominal.gain)
    if plant.gain is not None and np.isfinite(nominal.at_zero()):
        system = system.with_value_at(0.0, nominal.at_zero())
    return Zpk(system.zeros, system.poles, system.gain * gain), delay


def study(result, checker):
    """The dict that the report shows; {} for a plant without ranges."""
    plant, design = result.design.plant, result.design
    across = ranges(plant)
    found = {"cancelled": _cancelled(result)}
    if not across:
        return found
    corners = list(itertools.product((-1, 1), repeat=len(across)))
    rng = np.random.default_rng(SEED)
    if len(corners) > CORNERS_MAX:
        corners = [corners[i] for i in rng.choice(len(corners), CORNERS_MAX, replace=False)]
    points = [*corners, *rng.uniform(-1, 1, (INTERIOR, len(across)))]
    controller = result.stages[-1].loop.controller
    worst = {"max_s": (0.0, None), "gain_margin": (np.inf, None), "phase_margin_deg": (np.inf, None), "disk_margin": (np.inf, None)}
    unstable = []
    for x in points:
        system, delay = moved(plant, result.plant, x)
        loop = Loop(SampledPlant(state_space(system), design.sample_time_s, design.computation_delay_s + delay), controller, {}, design.sample_time_s,
                    roots=np.r_[system.poles, system.zeros], density=40)
        if not loop.is_stable():
            unstable.append([float(v) for v in x])
            continue
        s, t, _, _ = loop.closed_loop(loop.omega)
        gain_margin, phase_margin, _, _ = loop.margins()
        for name, value, is_worse in (("max_s", float(np.abs(s).max()), np.greater), ("gain_margin", float(gain_margin), np.less), ("phase_margin_deg", float(phase_margin), np.less),
                                      ("disk_margin", float(2 / np.abs(s - t).max()), np.less)):
            if is_worse(value, worst[name][0]):
                worst[name] = (value, [float(v) for v in x])
    found.update({"ranges": [f"{what} +- {100 * fraction:g} %" for what, _, _, fraction in across], "plants": len(points), "corners": len(corners), "unstable": len(unstable),
                  "first_unstable": unstable[0] if unstable else None, "worst": {name: ("inf" if np.isinf(v) else v) for name, (v, _) in worst.items()},
                  "worst_at": {name: x for name, (_, x) in worst.items()}, "mu": mu_peak(result, checker)})
    return found


def _cancelled(result):
    """Lightly damped plant modes that K's zeros sit on: max abs S does not see what happens when the mode moves, or when friction excites it."""
    h = result.design.sample_time_s
    d = result.sampled.zeros
    zeros = np.log1p(d[np.abs(1 + d) > 1e-9]) / h
    out = []
    for pole in result.plant.poles:
        if pole.imag > 0 and -pole.real < DAMPING_LIGHT * abs(pole) and abs(pole) < np.pi / h:
            near = min((abs(z - pole) / abs(pole) for z in zeros), default=np.inf)
            if near < CANCELLED:
                out.append(f"{format_root(complex(np.round(pole, 6)))}")
    return out


def refuse_unstable(found):
    """Refuses to write coefficients for a design that is unstable with a plant within its own ranges."""
    if found.get("unstable"):
        at = ", ".join(f"{name} at {x:+.2f} of it" for name, x in zip(found["ranges"], found["first_unstable"]))
        raise DesignError(f"robustness: {found['unstable']} of {found['plants']} plants within the stated ranges are unstable with this controller, e.g. {at}. "
                          "Ask for less bandwidth, put a weight wGS on the mode that moves, or narrow the ranges if they are wider than what is known")


def mu_peak(result, checker):
    """The largest mu over frequency of the ranges as independent real perturbations."""
    plant, h = result.design.plant, result.design.sample_time_s
    stage = result.stages[-1].loop
    omega = stage.omega[(stage.omega < 0.999 * np.pi / h)]
    omega = np.unique(np.r_[omega[:: max(len(omega) // 150, 1)], *(abs(p) * np.linspace(0.8, 1.2, 41) for p in result.plant.poles if p.imag > 0)])
    omega = omega[omega < np.pi / h]
    s = 1j * omega
    delay = result.design.delay_s
    hold = (1 - np.exp(-s * h)) / (s * h) * np.exp(-s * delay)
    k = stage.controller.response(omega) * hold
    # The plant as a chain: blocks with one perturbation each, x -> through F, and what delta sees of it.
    blocks = [(np.full(len(s), result.plant.gain, complex), None)]
    for what, kind, i, fraction in ranges(plant):
        if kind == "gain":
            blocks.append((np.ones(len(s), complex), fraction * np.ones(len(s))))
        elif kind == "delay":
            blocks.append((np.ones(len(s), complex), fraction * plant.delay_s * s))  # e^-x near 1 - x
    for kind in ("poles", "zeros"):
        roots, percents = np.array(getattr(plant, kind), complex), list(getattr(plant, f"{kind}_percent")) or [0.0] * len(getattr(plant, kind))
        for root, percent in zip(roots, percents):
            if root.imag < 0:
                continue
            factor = (s - root) * (s - np.conj(root)) if root.imag else s - root
            r = percent / 100
            # The factor of a root that moves by r: with the steady gain kept it is divided by (1 + r) for each of its roots, to first order.
            change = (-2 * root.real * r * s + 2 * abs(root) ** 2 * r - 2 * r * factor) / factor if root.imag else (-root * r - r * factor) / factor
            if kind == "poles":
                blocks.append((1 / factor, -change if percent else None))
            else:
                blocks.append((factor, change if percent else None))
    n = sum(see is not None for _, see in blocks)
    through = np.cumprod([f for f, _ in blocks], axis=0)
    total = through[-1]
    sensitivity = 1 / (1 + total * k)
    uncertain = [j for j, (_, see) in enumerate(blocks) if see is not None]
    peak, at = 0.0, np.nan
    if n == 1:  # of one real number: where what it sees of itself is real
        j = uncertain[0]
        seen = -blocks[j][1] * through[j] * k * sensitivity * total / through[j]
        for i in np.flatnonzero(np.sign(seen.imag[:-1]) != np.sign(seen.imag[1:])):
            part = seen.imag[i] / (seen.imag[i] - seen.imag[i + 1])
            size = abs(seen.real[i] + part * (seen.real[i + 1] - seen.real[i]))
            if size > peak:
                peak, at = float(size), float(omega[i])
        return {"peak": peak, "omega_rad_s": None if np.isnan(at) else at}
    for w in range(len(omega)):
        m = np.empty((n, n), complex)
        for row, i in enumerate(uncertain):
            for column, j in enumerate(uncertain):
                # delta_j adds at block j's output; block i sees its own output.
                direct = through[i, w] / through[j, w] if i > j else 0.0
                after = total[w] / through[j, w]
                m[row, column] = blocks[i][1][w] * (direct - through[i, w] * k[w] * sensitivity[w] * after)
        bound = slycot.ab13md(m, [1] * n, [1] * n)[0]
        if bound > peak:
            peak, at = float(bound), float(omega[w])
    return {"peak": peak, "omega_rad_s": None if np.isnan(at) else at}


def in_words(found):
    """Sentences for terminal and report."""
    out = []
    if found.get("ranges"):
        w = found["worst"]
        out.append(f"Of {found['plants']} plants within {', '.join(found['ranges'])} ({found['corners']} corners, {found['plants'] - found['corners']} inside, seeded) {found['unstable']} are unstable; "
                   + ", ".join(f"worst {title} {w[name] if isinstance(w[name], str) else format(w[name], '.4g')}" for name, title in
                               (("max_s", "max abs S"), ("gain_margin", "gain margin"), ("phase_margin_deg", "phase margin [deg]"), ("disk_margin", "disk margin"))) + ".")
        mu = found["mu"]["peak"]
        out.append(f"Mu is at most {mu:.3g}" + (f", at {found['mu']['omega_rad_s']:.3g} rad/s" if mu else "") + ": "
                   + (f"all ranges could grow {1 / mu:.3g} times before a plant in them may be unstable" if 0 < mu < 1 else "mu does not exclude an unstable plant between those tried" if mu >= 1 else
                      "no plant in them is on the brink") + " (continuous plant, without aliasing).")
    for mode in found.get("cancelled", []):
        out.append(f"K cancels the lightly damped mode {mode} rad/s: max abs S does not see it. When the mode moves, or friction excites it, it rings: look at GS, give the pole a range, "
                   "or give a weight wGS.")
    return out
