"""Mixed-sensitivity synthesis, Eqs. (13), (14): why a problem has no solution, and python-control's solution.

The solver (python-control's mixsyn, SLICOT's SB10AD) can fail, return a wrong answer for a badly scaled problem, or never
return. So the problem is looked at first, the solver runs in a process of its own with a time limit, and its
answer is believed only when the loop that it makes has the norm it claims.
"""

import multiprocessing
import time
import warnings
from dataclasses import dataclass

import control as ct
import numpy as np
import scipy.linalg
import slycot

from . import discretise, wplane
from .reading import format_root
from .errors import IllPosedError
from .loop import Continuous, Loop, SampledPlant, SampledZpk
from .exact import zpk_of
from .systems import balanced_scaling, state_space
from .zpk import Zpk

LEAK = 1e-5  # of the fastest of wp's and the plant's corners: the pole that stands for an integrator inside the solver
AXIS = 1e-9  # a root whose real part is within this of its size counts as on the imaginary axis


@dataclass(frozen=True)
class Problem:
    plant: Zpk
    plant_space: object
    weights: dict  # name -> Zpk; wp, wu and perhaps wT, wGS
    h: float = None  # with it the problem is one in w (wplane.py)
    own_zeros: tuple = ()  # in rad/s, of the plant that was sampled to make a problem in w

    def omega(self, v):
        """Returns the frequency in the user's terms for the frequency v in w."""
        return v if self.h is None else float(wplane.unbend(v, self.h))


@dataclass
class Solution:
    gamma: float  # as the solver states it
    gamma_measured: float
    controller: Continuous
    how: str
    gamma_sampled: float = np.nan  # of solve_sampled: of the loop that will run


def make_problem(design):
    """The problem of a validated design, or IllPosedError with the cause."""
    plant, space = make_plant(design.plant, integrator=design.synthesis.domain == "sampled")
    weights = {}
    for name, system in design.weights.named().items():
        weights[name] = _weight(name, system)
    if "wGS" in weights and np.any(plant.poles.real > 0):
        raise IllPosedError("plant", f"weights.wGS needs a stable plant; pole {_list([p for p in plant.poles if p.real > 0])} rad/s is not. Leave wGS out: the report shows G S all the same")
    return Problem(plant, space, weights)


def make_plant(system, integrator=True):
    """The plant as Zpk and in state space. `integrator`: whether one pole at 0 will do."""
    if system.form == "ss":
        _refuse_hidden_modes("plant", "plant", system.matrices(), only_unstable=True)
    try:
        plant = system.zpk()
    except (OverflowError, ValueError) as error:
        raise IllPosedError("plant", f"plant: its roots or gain are beyond what double precision holds ({error})") from None
    if not np.isfinite(plant.gain) or not np.all(np.isfinite(np.r_[plant.zeros, plant.poles])):
        raise IllPosedError("plant", "plant: its roots or gain are beyond what double precision holds")
    hidden = _hidden_roots(plant)
    if any(p.real >= -AXIS * abs(p) for p in hidden):
        raise IllPosedError("plant", f"plant: its mode at {_list(hidden)} rad/s is cancelled by a zero and is not stable: no "
                                     "controller can reach it")
    if system.form == "ss" and hidden:  # exact roots: what is on top of each other is hidden, and only that
        zeros = list(plant.zeros)
        for pole in hidden:
            zeros.remove(min(zeros, key=lambda z: abs(z - pole)))
        poles = list(plant.poles)
        for pole in hidden:
            poles.remove(pole)
        plant = Zpk(zeros, poles, plant.gain)
    if plant.gain == 0:
        raise IllPosedError("plant", "plant: its gain is 0")
    if plant.relative_degree < 0:
        raise IllPosedError("plant", f"plant: improper ({len(plant.zeros)} zeros, {len(plant.poles)} poles): it cannot be built")
    on_axis = [p for p in plant.poles if abs(p.real) <= AXIS * abs(p)]
    if on_axis and not (integrator and on_axis == [0]):
        raise IllPosedError("plant pole on the imaginary axis",
                            f"plant: pole {_list(on_axis)} rad/s is on the imaginary axis. The synthesis needs every plant pole off "
                            "it: move it by a small real part, e.g. an integrator to -1e-3 times the wanted bandwidth")
    space = state_space(plant)
    if np.all(plant.poles.real < 0) and plant.order:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                space = ct.balred(space, plant.order)
            space = ct.ss(space.A, space.B, space.C, space.D, remove_useless_states=False)
        except Exception:  # noqa: BLE001 - any failure of the balancing leaves the cascade, which is right as well
            space = state_space(plant)
        if not _same_response(space, plant):
            space = state_space(plant)
    return plant, space


def _same_response(space, plant):
    size = np.abs(np.r_[plant.poles, plant.zeros])
    size = size[size > 0]
    omega = np.geomspace(size.min() / 10, size.max() * 3, 60)
    exact = plant(1j * omega)
    return np.all(np.abs(Continuous(space=space).response(omega) - exact) <= 1e-5 * np.abs(exact) + 1e-9 * np.abs(exact).max())


def _weight(name, system):
    field = f"weights.{name}"
    if system.form == "ss":
        _refuse_unstable(field, np.linalg.eigvals(system.matrices()[0]))
        _refuse_hidden_modes(field, "uncontrollable weight", system.matrices(), only_unstable=False)
    try:
        weight = system.zpk()
    except (OverflowError, ValueError) as error:
        raise IllPosedError("improper weight", f"{field}: its roots or gain are beyond what double precision holds ({error})") from None
    if not np.isfinite(weight.gain):
        raise IllPosedError("improper weight", f"{field}: its gain is beyond what double precision holds")
    if weight.gain == 0:
        if name == "wp":
            raise IllPosedError("rank condition", "weights.wp is 0: nothing asks for control, the best controller is 0")
        raise IllPosedError("rank condition", f"weights.{name} is 0 at every frequency"
                            + (": the controller's output costs nothing, so D12 has not full column rank; give wu a small constant, e.g. 1e-3"
                               if name == "wu" else "; leave it out instead"))
    if weight.relative_degree < 0:
        raise IllPosedError("improper weight", f"{field}: improper ({len(weight.zeros)} zeros, {len(weight.poles)} poles): its gain grows without "
                                               "end. Add fast poles, e.g. far above the wanted bandwidth")
    _refuse_unstable(field, weight.poles)
    hidden = _hidden_roots(weight)
    if len(hidden):
        raise IllPosedError("uncontrollable weight", f"{field}: its mode at {_list(hidden)} rad/s is cancelled by a zero, so it cannot be "
                                                     "controlled or seen: cancel the factor in the file")
    return weight


def _refuse_unstable(field, poles):
    bad = [p for p in poles if p.real > -AXIS * abs(p) or p == 0]
    if bad:
        on_axis = all(abs(p.real) <= AXIS * abs(p) for p in bad)
        what = "is on the imaginary axis" if on_axis else "is unstable"
        raise IllPosedError("unstable weight", f"{field}: pole {_list(bad)} rad/s {what}. No controller acts on a weight's own states, so every pole "
                                               "of it must be in the left half plane; for integral action use a slow one, e.g. -1e-4 times the bandwidth")


def _hidden_roots(system):
    zeros = list(system.zeros)
    hidden = []
    for pole in system.poles:
        match = next((z for z in zeros if abs(z - pole) <= 1e-9 * abs(pole)), None)
        if match is not None:
            zeros.remove(match)
            hidden.append(pole)
    return hidden


def _refuse_hidden_modes(field, cause, matrices, only_unstable):
    """Hautus' test mode by mode."""
    system = balanced_scaling(ct.ss(*matrices, remove_useless_states=False))
    a, b, c = system.A, system.B, system.C
    n = len(a)
    scale = max(np.linalg.norm(a), 1e-300)
    for pole in np.linalg.eigvals(a):
        if only_unstable and pole.real < -AXIS * abs(pole):
            continue
        shifted = (a - pole * np.eye(n)) / scale
        for matrix, word in ((np.hstack([shifted, b / max(np.linalg.norm(b), 1e-300)]), "controlled from its input"),
                             (np.vstack([shifted, c / max(np.linalg.norm(c), 1e-300)]), "seen at its output")):
            if np.linalg.svd(matrix, compute_uv=False)[-1] < 1e-10:
                raise IllPosedError(cause, f"{field}: the mode at {format_root(pole)} rad/s cannot be {word}; remove it from a, b and c")


def diagnose(problem, gamma_max):
    """Refuses problems that no solver can solve. Returns the lower bound of gamma and its frequency."""
    plant, weights = problem.plant, problem.weights
    wp, wu, wt = weights["wp"], weights["wu"], weights.get("wT")
    if wu.relative_degree > 0 and (plant.relative_degree > 0 or (wp.relative_degree > 0 and (wt is None or wt.relative_degree > 0))):
        raise IllPosedError("rank condition", "weights.wu vanishes at high frequency, where the plant does too: an infinite controller gain would cost "
                                              "nothing (D12 has not full column rank). Give wu as many zeros as poles")
    for zero in wu.zeros:
        if abs(zero.real) <= AXIS * abs(zero) or zero == 0:
            vanish = any(abs(z - zero) <= 1e-9 * max(abs(zero), 1e-9) for z in plant.zeros)
            if vanish:
                raise IllPosedError("rank condition", f"weights.wu and the plant both vanish at {abs(zero.imag):g} rad/s: the controller's output costs nothing there "
                                                      "and changes nothing (rank condition on the imaginary axis). Move wu's zero off the axis")
    bound, omega, why, advice = lower_bound(problem, gamma_max)
    if bound > gamma_max:
        raise IllPosedError("contradicting weights", f"{why}. Whatever the controller, gamma is at least {bound:.4g}, over gamma_max {gamma_max:g}. {advice}")
    return bound, omega


def _zeros_by_origin(problem):
    """The right-half-plane zeros as (zero, the plant's own root in rad/s or None for one that sampling made)."""
    zeros = list(problem.plant.zeros[problem.plant.zeros.real > AXIS * np.abs(problem.plant.zeros)])
    if problem.h is None:
        return [(zero, zero) for zero in zeros]
    out, c = [], 2 / problem.h
    for own in problem.own_zeros:
        if own.real > AXIS * abs(own) and abs(own) < np.pi / problem.h and zeros:  # beyond Nyquist the samples do not show it
            image = c * np.tanh(own / c)
            out.append((zeros.pop(int(np.argmin(np.abs(np.array(zeros) - image)))), own))
    return out + [(zero, None) for zero in zeros]


def lower_bound(problem, gamma_max):
    """The largest of the pointwise bounds that no controller beats, its frequency, why it is one, and what to do about it.

    At a frequency, with T = a/(a + b) the best choice of S + T = 1:  |wp S|^2 + |wu K S|^2 + |wT T|^2 >= a b / (a + b),
    a = |wp|^2, b = |wT|^2 + |wu/G|^2. At a right-half-plane zero of the plant S = 1, at a right-half-plane pole T = 1.
    """
    plant, weights = problem.plant, problem.weights
    corners = np.abs(np.concatenate([np.r_[x.poles, x.zeros] for x in (plant, *weights.values())]))
    corners = corners[corners > 1e-9]
    omega = np.geomspace(corners.min() / 100, corners.max() * 100, 4000) if len(corners) else np.ones(1)
    points = 1j * omega
    a = np.abs(weights["wp"](points))
    by_u = np.abs(weights["wu"](points)) / np.maximum(np.abs(plant(points)), 1e-150)
    by_t = np.abs(weights["wT"](points)) if "wT" in weights else np.zeros(len(omega))
    b = np.hypot(by_t, by_u)
    value = a * b / np.maximum(np.hypot(a, b), 1e-300)
    i = int(np.flatnonzero(value >= 0.99 * value.max())[0])  # of a plateau, its lower end
    over = omega[value > gamma_max]
    band = f" (the contradiction reaches from {problem.omega(over[0]):.3g} to {problem.omega(over[-1]):.3g} rad/s)" if len(over) else ""
    other = "wu |1/G|" if by_u[i] > by_t[i] else "wT"
    size = max(by_u[i], by_t[i])
    contradict, lower = "weights contradict each other at {:.4g} rad/s", "Lower one of the two there"
    at = problem.omega(omega[i])
    best = (float(value[i]), at,
            contradict.format(at) + f"{band}: |wp| is {a[i]:.4g} (the error must stay below {1 / a[i]:.3g}) and |{other}| is {size:.4g} "
            + ("(the plant passes too little of the allowed controller output)" if other != "wT" else "(T must stay below "
               f"{1 / size:.3g}), but S + T = 1"), lower)
    for zero, own in _zeros_by_origin(problem):
        bound = float(np.abs(weights["wp"](zero)[0]))
        if bound > best[0]:
            at = problem.omega(abs(zero))
            if own is None:
                best = (bound, at, f"sample_time_s: value {problem.h:g}: too long for weights.wp: no loop answers within a sample, which fixes S = 1 at w = (2/h) (z - 1)/(z + 1) = "
                        f"{format_root(zero)} ({at:.4g} rad/s), and wp wants it below {1 / bound:.3g}", "Shorten the sample time (in seconds) or lower wp there")
            else:
                best = (bound, at, contradict.format(at) + f": the plant's right-half-plane zero {format_root(own)} fixes S = 1 there, and wp wants it below {1 / bound:.3g}", lower)
    for pole in plant.poles[plant.poles.real > 0]:
        if "wT" in weights:
            bound = float(np.abs(weights["wT"](pole)[0]))
            if bound > best[0]:
                at = problem.omega(abs(pole))
                best = (bound, at, contradict.format(at) + f": the plant's unstable pole {format_root(pole)} fixes T = 1 there, and wT wants it below {1 / bound:.3g}", lower)
    return best


# The meanings of SB10AD's INFO in the user's terms.
SOLVER_CAUSES = {
    1: ("rank condition", "the controller's output costs nothing at some frequency of the imaginary axis (rank condition on A - jw, B2; C1, D12)"),
    2: ("rank condition", "the reference cannot reach a state at some frequency of the imaginary axis (rank condition on A - jw, B1; C2, D21): "
                          "a plant or weight pole is too close to the axis"),
    3: ("rank condition", "D12 has not full column rank: wu is too small at high frequency"),
    4: ("rank condition", "D21 has not full row rank"),
}
FITS = 7  # largest number of fits of the weights
CLOSE = 1.005  # gamma of the loop that will run over the solver's, of which no other fit is tried
SHARPNESS = 40  # of the care, a power of gamma at each frequency over its peak


def solve_sampled(problem, checker, synthesis, off_percent):
    """K(w) for the loop that will run. The weights are fitted in w twice: the second time with the care that each term deserves at each
    frequency, once the first solution has shown its share of gamma there. As long as gamma is above what the solver states, they are fitted
    anew with more care where it peaks (Lawson's rule)."""
    h = checker.h
    plant = checker.sampled
    if np.any(problem.plant.poles == 0):  # the solver's own plant forgets, very slowly; all figures are the true one's
        slow = np.abs(np.r_[problem.weights["wp"].zeros, problem.weights["wp"].poles, problem.plant.poles])
        leaky = Zpk(problem.plant.zeros, np.where(problem.plant.poles == 0, -LEAK * slow.max(initial=1 / h), problem.plant.poles), problem.plant.gain)
        plant = SampledPlant(state_space(leaky), h, checker.sampled.delay)
    plant = _without_far_roots(wplane.to_w(zpk_of(plant.space), h), h)
    corners = np.abs(np.concatenate([np.r_[x.poles, x.zeros] for x in (problem.plant, *problem.weights.values())]))
    omega = wplane.fit_grid(h, corners[corners > 0])
    fits = {name: wplane.WeightFit(weight, h) for name, weight in problem.weights.items()}
    care = {name: np.ones(len(omega)) for name in fits}
    deadline = time.monotonic() + synthesis.time_limit_s
    solution, peak = None, np.ones(len(omega))
    for i in range(FITS):
        if i >= 2 and solution.gamma_sampled < CLOSE * (1 + off_percent / 100) * solution.gamma:
            break
        weights = {name: fit.fitted(omega, care[name]) for name, fit in fits.items()}
        left = max(deadline - time.monotonic(), 0.5)
        try:
            again = solve(Problem(plant, state_space(plant), weights, h, tuple(problem.plant.zeros)), synthesis.model_copy(update={"time_limit_s": left}), off_percent)
        except IllPosedError:
            if solution is None:
                raise
            break
        loop = Loop(checker.sampled, SampledZpk(discretise.tustin(again.controller.zpk, h), h), problem.weights, h, roots=checker.roots)
        s, t, ks, total = loop.closed_loop(omega)
        g = checker.sampled.response(omega)
        again.gamma_sampled = float(np.nanmax(total))
        if solution is None or again.gamma_sampled < solution.gamma_sampled:
            solution = again
        terms = loop.terms(1j * omega, s, t, ks, g)
        titles = {"wp": "wp S", "wu": "wu KS", "wT": "wT T", "wGS": "wGS GS"}
        if i >= 1:
            peak *= (total / np.nanmax(total)) ** SHARPNESS
        care = {name: np.abs(terms[titles[name]]) / total * peak / peak.max() + 3e-3 for name in fits}
    return solution


def _without_far_roots(plant, h):
    """Zeros in w so far away that they change nothing below 0.999 of the Nyquist frequency."""
    far = np.abs(plant.zeros) > 1e7 / h
    if not np.any(far):
        return plant
    kept = Zpk(plant.zeros[~far], plant.poles, 1.0)
    point = 0.1j / h
    return kept.with_value_at(point, plant(point)[0])


def solve(problem, synthesis, off_percent=0.0):
    """The controller, verified, or IllPosedError. Takes at most the time limit."""
    bound, bound_omega = diagnose(problem, synthesis.gamma_max)
    deadline = time.monotonic() + synthesis.time_limit_s
    corners = np.abs(np.concatenate([np.r_[x.poles, x.zeros] for x in (problem.plant, *problem.weights.values())]))
    corners = corners[corners > 0]
    middle = float(np.exp(np.mean(np.log(corners)))) if len(corners) else 1.0
    best, infos, timed_out = None, [], False
    attempts = [("balanced realisation", problem.plant_space, 1.0),
                ("balanced realisation, time scaled", problem.plant_space, middle),
                ("cascade realisation, time scaled", state_space(problem.plant), middle)]
    for i, (how, space, scale) in enumerate(attempts):
        left = deadline - time.monotonic()
        if left <= 0:
            timed_out = True
            break
        answer = _run(space, problem.weights, scale, left if i == len(attempts) - 1 else max(left / 2, min(left, 1.0)), off_percent)
        if answer is None:
            timed_out = True
            continue
        if isinstance(answer, tuple) and answer[0] == "failed":
            infos.append(answer[1:])
            continue
        gamma, a, b, c, d = answer
        solution = _verify(problem, gamma, ct.ss(a, b, c, d, remove_useless_states=False), how)
        if solution is None:
            infos.append((None, "the loop that it makes is not stable"))
            continue
        if best is None or solution.gamma_measured < best.gamma_measured:
            best, best_space, best_scale = solution, space, scale
        if abs(solution.gamma_measured / solution.gamma - 1) < 5e-3 + off_percent / 100:
            break
    if best is None:
        known = next((SOLVER_CAUSES[info] for info, _ in infos if info in SOLVER_CAUSES), None)
        if known:
            raise IllPosedError(known[0], f"the solver finds no controller: {known[1]}")
        if timed_out:
            raise IllPosedError("time limit", f"no controller within {synthesis.time_limit_s:g} s (synthesis.time_limit_s). A dead time of many ticks, each a "
                                              f"state, or roots that are decades apart make the solver slow; the weights come closest to a contradiction at {bound_omega:.4g} rad/s")
        raise IllPosedError("numerical", "the solver finds no controller that stands a check "
                                         f"({'; '.join(sorted({text for _, text in infos}))}): the problem's frequencies are too far apart or a weight is too close to singular; "
                                         f"the weights come closest to a contradiction at {bound_omega:.4g} rad/s")
    if not _holds(best, 0.05, off_percent):
        best = _bisect(problem, best_space, best_scale, best, deadline, off_percent)
    if not _holds(best, 0.05, off_percent):
        raise IllPosedError("numerical", f"the solver states gamma {best.gamma:.4g}, but its loop has {best.gamma_measured:.4g}: the problem is too badly scaled to be solved "
                                         "in double precision; bring the slowest and fastest poles of plant and weights closer together")
    if best.gamma_measured > synthesis.gamma_max:
        raise IllPosedError("contradicting weights", f"the best controller reaches gamma {best.gamma_measured:.4g} only, over gamma_max {synthesis.gamma_max:g}: the weights "
                                                     f"contradict each other most at {problem.omega(_worst(problem, best)):.4g} rad/s")
    unstable = [p for p in best.controller.poles() if p.real > 0]
    if unstable:
        raise IllPosedError("unstable controller", f"the best controller is unstable itself (pole {_list(unstable)} rad/s); the library runs stable controllers only. "
                                                   "Ask for less bandwidth, or limit wT less")
    return best


def _holds(solution, tolerance, off_percent):
    """Whether the loop has the gamma that the solver states."""
    return solution.gamma_measured < (1 + tolerance + off_percent / 100) * solution.gamma


def _bisect(problem, space, scale, wrong, deadline, off_percent):
    """The solution of the least gamma, within 0.5 %, that its loop holds. The solver's own search stops too low where rounding hides
    from it that a gamma cannot be reached, which depends on the processor: `wrong` is what it found. `wrong` again if there is none."""
    best, low, high = wrong, wrong.gamma, wrong.gamma_measured
    while high > 1.005 * low and time.monotonic() < deadline:
        gamma = float(np.sqrt(low * high))
        answer = _run(space, problem.weights, scale, deadline - time.monotonic(), off_percent, gamma)
        found = None
        if answer is not None and answer[0] != "failed":
            found = _verify(problem, gamma, ct.ss(*answer[1:], remove_useless_states=False), f"{wrong.how}, gamma bisected")
        if found is not None and _holds(found, 5e-3, off_percent):
            best, high = found, gamma
        else:
            low = gamma
    return best


def _worst(problem, solution):
    """Returns the frequency where |wp S| and another weighted term are both large, i.e. where the weights conflict."""
    loop = Loop(Continuous(problem.plant, problem.plant_space), solution.controller, problem.weights, roots=np.r_[problem.plant.poles, problem.plant.zeros])
    s, t, ks, _ = loop.closed_loop(loop.omega)
    points = 1j * loop.omega
    first = np.abs(problem.weights["wp"](points) * s)
    rest = np.hypot(np.abs(problem.weights["wu"](points) * ks), np.abs(problem.weights["wT"](points) * t) if "wT" in problem.weights else 0)
    return float(loop.omega[int(np.argmax(np.minimum(first, rest)))])


def _verify(problem, gamma, controller, how):
    with np.errstate(all="ignore"):
        if not all(np.all(np.isfinite(m)) for m in ct.ssdata(controller)):
            return None
        try:
            zpk = zpk_of(controller)
        except (ValueError, OverflowError):
            return None
        wrapped = Continuous(zpk, controller)
        loop = Loop(Continuous(problem.plant, problem.plant_space), wrapped, problem.weights, roots=np.r_[problem.plant.poles, problem.plant.zeros])
        if not loop.is_stable():
            return None
        total = loop.closed_loop(loop.omega)[3]
        measured = loop._peak(total, lambda w: loop.closed_loop(w)[3])
    return Solution(float(gamma), float(measured), wrapped, how)


def _performance(space, weights):
    """wp, or wp over wGS G: both act on the error."""
    if "wGS" not in weights:
        return state_space(weights["wp"])
    parts = [state_space(weights["wp"]), ct.series(space, state_space(weights["wGS"]))]
    a, c, d = scipy.linalg.block_diag(*(p.A for p in parts)), scipy.linalg.block_diag(*(p.C for p in parts)), np.vstack([p.D for p in parts])
    return ct.ss(a, np.vstack([p.B for p in parts]), c, d, remove_useless_states=False)


def _run(space, weights, scale, seconds, off_percent, gamma=None):
    """mixsyn in a process of its own, or K for a given gamma. None when the time is over, ("failed", info, text), or gamma and K's matrices."""
    methods = multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context("fork" if "fork" in methods else "spawn")
    receiver, sender = context.Pipe(duplex=False)
    systems = [_matrices(s) for s in (space, _performance(space, weights), *(state_space(weights[n]) if n in weights else None for n in ("wu", "wT")))]
    child = context.Process(target=_child, args=(sender, systems, scale, off_percent, gamma), daemon=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about a fork while numpy has idle threads
        child.start()
    sender.close()
    try:
        if not receiver.poll(seconds):
            return None
        return receiver.recv()
    except EOFError:
        return ("failed", None, "the solver broke down")
    finally:
        child.kill()
        child.join()
        receiver.close()


def _matrices(space):
    return None if space is None else tuple(np.asarray(m) for m in ct.ssdata(space))


def _augmented(plant, w1, wu, wt):
    """From r and u to w1 (r - y), wu u, wt y and r - y."""
    a, b, c, d = (np.asarray(m) for m in ct.ssdata(plant))
    one, none = np.ones((1, 1)), np.zeros((1, 1))
    parts = [(w1, -c, one, -d), (wu, np.zeros_like(c), none, one)] + ([(wt, c, none, d)] if wt is not None else [])  # what drives each: of the plant's state, r, u
    n = len(a)
    rows_a, rows_b1, rows_b2 = [a], [np.zeros((n, 1))], [b]
    for w, by_state, by_r, by_u in parts:
        rows_a.append(w.B @ by_state)
        rows_b1.append(w.B @ by_r)
        rows_b2.append(w.B @ by_u)
    total_a = np.hstack([np.vstack(rows_a), np.vstack([np.zeros((n, sum(w.nstates for w, *_ in parts))), scipy.linalg.block_diag(*(w.A for w, *_ in parts))])])
    total_c = np.hstack([np.vstack([*(w.D @ by_state for w, by_state, *_ in parts), -c]),
                         np.vstack([scipy.linalg.block_diag(*(w.C.reshape(w.noutputs, w.nstates) for w, *_ in parts)), np.zeros((1, sum(w.nstates for w, *_ in parts)))])])
    total_d = np.hstack([np.vstack([*(w.D @ by_r for w, _, by_r, _ in parts), one]), np.vstack([*(w.D @ by_u for w, _, _, by_u in parts), -d])])
    return ct.ss(total_a, np.hstack([np.vstack(rows_b1), np.vstack(rows_b2)]), total_c, total_d, remove_useless_states=False)


def _search(systems):
    """Returns the smallest gamma and the matrices of K."""
    if systems[1].noutputs == 1:
        k, _, (gamma, _) = ct.mixsyn(*systems)
    else:  # python-control's augw takes as many outputs of wp as it has inputs
        k, _, gamma, _ = ct.hinfsyn(_augmented(*systems), 1, 1)
    return gamma, tuple(np.asarray(m) for m in ct.ssdata(k))


def _child(sender, systems, scale, off_percent, gamma):
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scaled = [None if s is None else ct.ss(s[0] / scale, s[1] / scale, s[2], s[3], remove_useless_states=False) for s in systems]
            searched = gamma is None
            if searched:
                gamma, k = _search(scaled)
            if off_percent or not searched:
                p = _augmented(*scaled)
                k = slycot.sb10ad(p.nstates, p.ninputs, p.noutputs, 1, 1, gamma * (1 + off_percent / 100), p.A, p.B, p.C, p.D, job=4)[1:5]
        sender.send((float(gamma), k[0] * scale, k[1] * scale, k[2], k[3]))
    except Exception as error:  # noqa: BLE001 - whatever the solver does, the parent says it in the user's terms
        sender.send(("failed", getattr(error, "info", None), f"{type(error).__name__}: {str(error).strip().splitlines()[0] if str(error).strip() else ''}"))
    finally:
        sender.close()


def _list(roots):
    return ", ".join(format_root(r) for r in roots)
