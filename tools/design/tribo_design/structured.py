"""PI, PID with filter and lead-lag by the same weights: the least gamma that a structure with few numbers can reach.

Gamma over k and the corners is neither smooth nor convex: Nelder and Mead's simplex (scipy) from several starts, over the logarithms, on a fixed
grid, with the Nyquist criterion for stability; the result is judged like any other. Designed in w, so K(z) is Tustin's image without loss.
"""

import numpy as np
import scipy.optimize

from . import synthesis, wplane
from .errors import IllPosedError, LimitError
from .reduction import Candidate, rounded
from .zpk import Zpk

UNSTABLE = 1e6


def _pi(x):
    k, zero = np.exp(x)
    return Zpk([-zero], [0], k)


def _pid(x):
    k, size, damping, filtered = np.exp(x)
    damping = min(damping, 20.0)
    root = size * np.sqrt(complex(damping**2 - 1))
    zeros = [-damping * size + root, -damping * size - root] if abs(root) > 1e-9 * size else [-size, -size]
    return Zpk(zeros, [0, -filtered], k)


def _lead_lag(x):
    k, zero, pole, slow_zero, slow_pole = np.exp(x)
    return Zpk([-zero, -slow_zero], [-pole, -slow_pole], k)


# Name -> (K(w) of log parameters, starts for a crossover w and |K| of 1/g there).
STRUCTURES = {
    "pi": (_pi, lambda w, g: [(g, w * f) for f in (0.1, 0.5, 2)]),
    "pid": (_pid, lambda w, g: [(g * f, w * f, 0.8, 10 * w) for f in (0.5, 1, 3)] + [(3 * g, 0.5 * w, 2.0, 30 * w)]),
    "lead-lag": (_lead_lag, lambda w, g: [(g * f, w / f, w * f, 0.1 * w, 1e-3 * w) for f in (1.5, 3, 6)]),
}


def synthesize(result, checker, problem):
    """The stages of a structured design, into `result`."""
    from . import pipeline

    design, h = result.design, result.design.sample_time_s
    name = design.synthesis.structure
    x, gamma = _best(name, checker, problem, design)
    if not gamma < UNSTABLE:
        raise IllPosedError("contradicting weights", f"no {name} controller was found that stabilises this plant")
    controller = rounded(STRUCTURES[name][0](x), design.reduction.digits)
    result.full, result.full_order, result.in_w = controller, controller.order, True
    loop, metrics = checker.close(pipeline.as_sampled(controller, h))
    full = _full_order(checker, problem, design)
    result.structure_note = f"{name}: {_numbers(name, controller)}; gamma of the full order: {full}"
    result.stages.append(pipeline.Stage("full", loop, metrics, f"order {controller.order}, {result.structure_note}, with hold and {design.delay_s:g} s delay"))
    if not metrics.stable:
        raise LimitError(f"full: the best {name} controller does not make a stable loop", pipeline.table_text(result))
    if metrics.gamma > design.synthesis.gamma_max:
        omega, term, _ = loop.peak_term()
        raise IllPosedError("contradicting weights", f"the best {name} controller reaches gamma {metrics.gamma:.4g} only, over gamma_max {design.synthesis.gamma_max:g}, where {term} is large at "
                                                     f"{omega:.4g} rad/s; the full order reaches {full}")
    result.reduced = Candidate(controller, f"structure {name}")
    result.stages.append(pipeline.Stage("reduced", loop, metrics, "nothing to reduce"))
    broken = pipeline.breaches(None, metrics, design.limits.reduced, design.limits.floor)
    if broken:
        raise LimitError(f"reduced: {'; '.join(broken)}", pipeline.table_text(result))
    result.sampled = pipeline.as_sampled(controller, h).zpk
    pipeline.sampled_steps(result, checker)


def _full_order(checker, problem, design):
    try:
        return f"{synthesis.solve_sampled(problem, checker, design.synthesis, 0.0).gamma_sampled:.4g}"
    except IllPosedError as error:
        return f"none ({error.cause})"


def _numbers(name, k):
    if name == "pi":
        return f"kp {k.gain:.5g}, ki {k.gain * -k.zeros[0].real:.5g} 1/s"
    if name == "pid":
        # k (w^2 + b w + c)/(w (w + f)) = kp + ki/w + kd w f/(w + f)
        f, b, c = -k.poles[np.argmax(np.abs(k.poles))].real, -np.sum(k.zeros).real, np.prod(k.zeros).real
        ki = k.gain * c / f
        kp = (k.gain * b - ki) / f
        return f"kp {kp:.5g}, ki {ki:.5g} 1/s, kd {(k.gain - kp) / f:.5g} s, filter {f:.5g} rad/s"
    return f"k {k.gain:.5g}, zeros {', '.join(f'{z.real:.5g}' for z in k.zeros)}, poles {', '.join(f'{p.real:.5g}' for p in k.poles)} rad/s"


def _best(name, checker, problem, design):
    make, starts = STRUCTURES[name]
    h = design.sample_time_s
    corners = np.abs(np.concatenate([np.r_[x.poles, x.zeros] for x in (problem.plant, *problem.weights.values())]))
    omega = wplane.fit_grid(h, corners[corners > 0])
    lightly = [abs(p) * (1 + 3 * abs(p.real / p) * np.linspace(-1, 1, 31)) for p in problem.plant.poles if p.imag > 0]
    omega = np.unique(np.r_[omega, *lightly])
    omega = omega[(omega > 0) & (omega < np.pi / h)]
    w = 1j * wplane.bend(omega, h)
    g = checker.sampled.response(omega)
    size = {n: np.abs(weight(1j * omega)) for n, weight in problem.weights.items()}
    turns = np.pi * (np.sum(problem.plant.poles.real > 0) + 0.5 * np.sum(problem.plant.poles == 0))
    sign = np.sign(problem.plant.at_zero()) if np.isfinite(problem.plant.at_zero()) else np.sign(problem.plant.gain)

    if sign < 0:
        raise IllPosedError("plant", f"plant: its gain is negative: for a {name} controller turn the sign of u, so that its numbers are positive")

    def gamma(x):
        if np.any(np.abs(x) > 60):
            return UNSTABLE
        system = make(x)
        k = system(w)
        loop = g * k
        back = 1 + loop
        around = np.unwrap(np.angle(back))
        # The Nyquist criterion on half the circle; each pole at 0, the structure's too, starts it half a turn off.
        if abs(around[-1] - around[0] - turns - 0.5 * np.pi * np.sum(system.poles == 0)) > 0.3 * np.pi:
            return UNSTABLE
        s = 1 / back
        return float(np.sqrt((size["wp"] * np.abs(s)) ** 2 + (size["wu"] * np.abs(k * s)) ** 2
                             + ((size["wT"] * np.abs(loop * s)) ** 2 if "wT" in size else 0) + ((size["wGS"] * np.abs(g * s)) ** 2 if "wGS" in size else 0)).max())

    wp = size["wp"]
    wanted = float(omega[np.flatnonzero(wp >= 1)[-1]]) if np.any(wp >= 1) else float(omega[len(omega) // 2])
    best = None
    for scale in (1.0, 0.3, 0.1, 0.03, 3.0):
        at = min(scale * wanted, 0.5 * np.pi / h)
        level = 1 / max(float(np.abs(g[np.argmin(np.abs(omega - at))])), 1e-12)
        for start in starts(at, level):
            found = scipy.optimize.minimize(gamma, np.log(start), method="Nelder-Mead", options={"maxfev": 300, "xatol": 1e-3, "fatol": 1e-4})
            if best is None or found.fun < best.fun:
                best = found
    for _ in range(3):  # a simplex that collapsed starts again where it stands
        best = min(best, scipy.optimize.minimize(gamma, best.x, method="Nelder-Mead", options={"maxfev": 600, "xatol": 1e-5, "fatol": 1e-7}), key=lambda f: f.fun)
    return best.x, best.fun
