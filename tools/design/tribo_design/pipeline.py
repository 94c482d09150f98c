"""The steps in order, the loop checked after each."""

from dataclasses import dataclass, field
from importlib import metadata
from typing import Optional

import numpy as np

from tribo_plot.version import version

from . import discretise, quantise, reduction, robustness, sections, structured, synthesis
from .reading import format_root, printable
from .errors import DesignError, IllPosedError, LimitError
from .loop import Continuous, Loop, Metrics, SampledPlant, SampledSections, SampledZpk

OFF_OPTIMUM_PERCENT = 1.0
GROWTH_MAX = 30  # largest growth within a sample time, as a power of e
STEPS = ("full", "reduced", "discrete", "f32", "q31")
TITLES = {"full": "full K", "reduced": "reduced K", "discrete": "K(z)", "f32": "K(z), f32", "q31": "K(z), Q31"}


@dataclass(frozen=True)
class Quantity:
    name: str  # field of Metrics
    title: str
    unit: str
    limit: str  # field of Limits, with the unit of the degradation
    format: str
    worse: str  # how a degradation is measured: rise, fall (percent), fall_abs, change (percent)


QUANTITIES = (
    Quantity("gamma", "gamma", "", "gamma_percent", ".4f", "rise"),
    Quantity("max_s", "max abs S", "", "max_s_percent", ".4f", "rise"),
    Quantity("max_t", "max abs T", "", "max_t_percent", ".4f", "rise"),
    Quantity("max_ks", "max abs KS", "", "max_ks_percent", ".4g", "rise"),
    Quantity("max_gs", "max abs GS", "", "max_gs_percent", ".4g", "rise"),
    Quantity("gain_margin", "gain margin", "", "gain_margin_percent", ".4g", "fall"),
    Quantity("phase_margin_deg", "phase margin", "deg", "phase_margin_deg", ".3f", "fall_abs"),
    Quantity("delay_margin_s", "delay margin", "s", "delay_margin_percent", ".4g", "fall"),
    Quantity("disk_margin", "disk margin", "", "disk_margin_percent", ".4g", "fall"),
    Quantity("bandwidth_rad_s", "bandwidth", "rad/s", "bandwidth_percent", ".4g", "fall"),
    Quantity("ramp_error_n", "ramp error", "N", "ramp_error_percent", ".5g", "rise"),
    Quantity("low_gain", "low-frequency gain", "", "low_gain_percent", ".5g", "fall"),
    Quantity("slowest_pole_rad_s", "slowest pole", "rad/s", "slowest_pole_percent", ".7g", "change"),
)


@dataclass
class Stage:
    step: str
    loop: Loop
    metrics: Metrics
    note: str


@dataclass
class Result:
    design: object
    digest: str
    source: str  # name of the input file
    versions: str = ""
    plant: object = None
    full: Optional[object] = None  # the controller before any reduction: Zpk in s, in w when it was designed there
    full_order: int = 0
    gamma_stated: Optional[float] = None  # by the solver
    structure_note: str = ""  # of a PI and the like: its parameters, and gamma of the full order
    in_w: bool = False  # designed in w: sampling costs nothing and has no row of its own
    reduced: Optional[object] = None  # reduction.Candidate
    sampled: Optional[object] = None  # Zpk in d
    cascade: Optional[object] = None
    f32: Optional[np.ndarray] = None
    q31: Optional[object] = None  # quantise.Q31
    quantised: Optional[object] = None
    noise_lsb: float = 0.0  # rounding noise of the Q31 cascade at its output, in open loop, rms
    stages: list = field(default_factory=list)
    imported: str = ""
    robustness: Optional[dict] = None
    friction: Optional[dict] = None
    traces: Optional[dict] = None  # of the loop with friction, for the plot
    warnings: list = field(default_factory=list)

    def __post_init__(self):
        self.source = printable(self.source)
        self.versions = self.versions or f"tribo-design {version()} (python-control {metadata.version('control')}, slycot {metadata.version('slycot')})"

    def stage(self, step):
        return next((s for s in self.stages if s.step == step), None)

    @property
    def peaks(self):
        """Says where gamma peaks, and in which term."""
        if not self.stages or self.stages[-1].metrics.gamma is None:
            return ""
        omega, name, terms = self.stages[-1].loop.peak_term()
        return (f"Gamma peaks at {omega:.3g} rad/s, where {name} is the largest term (" + ", ".join(f"{n} {v:.3g}" for n, v in terms.items())
                + "). Gamma is what all wishes together are missed by there; each term alone is below it.")

    @property
    def gamma(self):
        return self.stages[0].metrics.gamma if self.stages else None


class Checker:
    """Closes controllers into the design's loop, continuous or sampled."""

    def __init__(self, design, plant, space, weights):
        self.design, self.weights = design, weights
        self.plant = Continuous(plant, space)
        self.roots = np.r_[plant.poles, plant.zeros]
        self.h = design.sample_time_s
        self._sampled = None

    @property
    def sampled(self):
        if self._sampled is None:
            growing = [p for p in self.plant.zpk.poles if p.real * self.h > GROWTH_MAX]
            if growing:
                raise IllPosedError("plant", f"plant: its unstable pole {format_root(growing[0])} rad/s grows more than {np.exp(GROWTH_MAX):.0e} times within "
                                             "one sample time: no sampled loop holds it")
            with np.errstate(all="ignore"):
                self._sampled = SampledPlant(self.plant.space, self.h, self.design.delay_s)
                order, value, _ = self._sampled.near_zero() if np.all(np.isfinite(self._sampled.space.A)) else (0, np.nan, 0)
            steady = self.plant.zpk.at_zero()
            if np.isfinite(steady) and not (order == 0 and abs(value - steady) <= 1e-6 * abs(steady)):
                raise IllPosedError("numerical", f"plant: sampled at {self.h:g} s its steady gain is {value:.6g} instead of {steady:.6g}: its roots are too far apart for double precision; "
                                                 "leave out those far beyond the Nyquist frequency")
        return self._sampled

    def close(self, controller):
        continuous = isinstance(controller, Continuous)
        loop = Loop(self.plant if continuous else self.sampled, controller, self.weights, None if continuous else self.h, self.design.ramp, self.roots)
        with np.errstate(all="ignore"):
            return loop, loop.metrics()


def synthesize(design, digest, source):
    if design.weights is None:
        raise DesignError(f"{source}: weights: is missing (synthesize needs them; import does not)")
    problem = synthesis.make_problem(design)
    checker = Checker(design, problem.plant, problem.plant_space, problem.weights)
    off = design.synthesis.off_optimum_percent
    first = None
    for percent in (0.0, OFF_OPTIMUM_PERCENT) if off is None else (off,):
        result = Result(design, digest, source, plant=problem.plant)
        try:
            if design.synthesis.structure != "full":
                structured.synthesize(result, checker, problem)
            elif design.synthesis.domain == "sampled":
                _synthesize_sampled(result, checker, problem, percent)
            else:
                _synthesize_continuous(result, checker, problem, percent)
            return result
        except DesignError as error:  # slightly off the optimum K has no pole near infinity, which makes the next steps easier
            first = first or error
            if design.synthesis.structure != "full" or not getattr(error, "after_full", False):
                raise
    raise first


def _synthesize_continuous(result, checker, problem, percent):
    design = result.design
    solution = synthesis.solve(problem, design.synthesis, percent)
    controller = solution.controller
    result.full, result.full_order, result.gamma_stated = controller.zpk, controller.zpk.order, solution.gamma
    loop, metrics = checker.close(controller)
    result.stages.append(Stage("full", loop, metrics, f"order {result.full_order}, {solution.how}" + (f", {percent:g} % off the optimum" if percent else "")))
    if not metrics.stable:
        raise LimitError("full: the loop is not stable", table_text(result))
    reduce_and_go_on(result, checker, controller)


def _synthesize_sampled(result, checker, problem, percent):
    design, h = result.design, result.design.sample_time_s
    solution = synthesis.solve_sampled(problem, checker, design.synthesis, percent)
    controller = solution.controller  # K(w)
    result.full, result.full_order, result.gamma_stated, result.in_w = controller.zpk, controller.zpk.order, solution.gamma, True
    loop, metrics = checker.close(as_sampled(controller.zpk, h))
    above = metrics.gamma / solution.gamma - 1 if metrics.stable else 0.0
    result.stages.append(Stage("full", loop, metrics, f"order {result.full_order}, {solution.how}, with hold and {design.delay_s:g} s delay" + (f", {percent:g} % off the optimum" if percent else "")
                               + (f", gamma about {100 * above:.2g} % above the least, as the weights in w are not quite those asked for" if above > 0.01 + percent / 100 else "")))
    if not metrics.stable:
        raise LimitError("full: the loop is not stable", table_text(result))
    if metrics.gamma > design.synthesis.gamma_max:
        raise IllPosedError("contradicting weights", f"the best controller reaches gamma {metrics.gamma:.4g} only, over gamma_max {design.synthesis.gamma_max:g}: the weights "
                                                     f"contradict each other most at {loop.peak_term()[0]:.4g} rad/s")
    reduce_and_go_on(result, checker, controller)


def as_sampled(in_w, h):
    """K(z) of K(w)."""
    return SampledZpk(discretise.tustin(in_w, h), h)


def from_import(design, digest, source, imported):
    """Takes an imported controller, continuous or discrete in d, through the remaining steps."""
    plant, space = synthesis.make_plant(design.plant)
    weights = {} if design.weights is None else synthesis.make_problem(design).weights
    result = Result(design, digest, source, plant=plant, imported=imported.describe())
    checker = Checker(design, plant, space, weights)
    if imported.continuous and design.plant.delay_s:
        result.sampled = discretise.discretise(imported.zpk, design.discretisation, design.sample_time_s)  # there is no continuous-time row with a dead time
        sampled_steps(result, checker)
    elif imported.continuous:
        controller = Continuous(imported.zpk)
        result.full, result.full_order = imported.zpk, imported.zpk.order
        loop, metrics = checker.close(controller)
        result.stages.append(Stage("full", loop, metrics, f"imported, order {imported.zpk.order}"))
        if not metrics.stable:
            raise LimitError("full: the loop with the imported controller is not stable (negative feedback, u = K (r - y)): its slowest closed-loop "
                             "pole is in the right half plane", table_text(result))
        reduce_and_go_on(result, checker, controller)
    else:
        result.sampled = imported.zpk
        sampled_steps(result, checker)
    return result


def reduce_and_go_on(result, checker, controller):
    design, limits, h = result.design, result.design.limits, result.design.sample_time_s
    before = result.stages[-1].metrics
    tried, refused, whole = [], None, list(result.stages)
    for candidate in reduction.candidates(controller, design.reduction, h):
        loop, metrics = checker.close(as_sampled(candidate.zpk, h) if result.in_w else Continuous(candidate.zpk))
        broken = breaches(before, metrics, limits.reduced, limits.floor)
        tried.append((candidate, metrics, broken))
        if broken:
            continue
        result.reduced = candidate
        result.stages = [*whole, Stage("reduced", loop, metrics, f"order {candidate.zpk.order}, {candidate.how}")]
        try:
            result.sampled = discretise.tustin(candidate.zpk, h) if result.in_w else discretise.discretise(candidate.zpk, design.discretisation, h)
            sampled_steps(result, checker)
            return
        except LimitError:
            raise
        except DesignError as error:  # the library refuses this candidate; try the next one
            refused = refused or error
    if refused is not None:
        raise _after_full(refused)
    result.stages = whole
    if not tried:
        ways = [f"a larger cancellation_percent than {design.reduction.cancellation_percent:g}"] if design.reduction.cancellation_percent < 50 else []
        ways += ["reduction.method auto"] if design.reduction.method != "auto" else []
        ways += ["a larger reduction.order_max"] if design.reduction.order_max < 8 else []
        raise _after_full(LimitError(f"reduced: method {design.reduction.method} leaves no controller of order {design.reduction.order_max} or less (K has order "
                                     f"{result.full_order})" + (f"; try {', or '.join(ways)}" if ways else ""), table_text(result)))
    candidate, _, broken = min(tried, key=lambda t: (not t[1].stable, len(t[2]), -t[0].zpk.order))
    raise _after_full(LimitError(f"reduced: no order up to {design.reduction.order_max} keeps the loop within its limits; the nearest, order {candidate.zpk.order} "
                                 f"({candidate.how}): {'; '.join(broken)}", table_text(result)))


def _after_full(error):
    error.after_full = True
    return error


def sampled_steps(result, checker):
    design, limits, h = result.design, result.design.limits, result.design.sample_time_s
    method = design.discretisation.method if result.reduced else "as imported"
    if not result.in_w:
        _accept(result, checker, "discrete", SampledZpk(result.sampled, h), limits.discrete, f"{method}, h {h:g} s, delay {design.delay_s:g} s + hold")
    result.cascade = sections.make_cascade(result.sampled, h)
    result.f32 = quantise.to_f32(result.cascade.sections)
    sections.check_sections(result.f32)
    _accept(result, checker, "f32", SampledSections(result.f32, h), limits.f32, f"{len(result.f32)} sections, float32 coefficients")
    fixed = design.fixed_point
    try:
        result.quantised = quantise.to_q31(result.f32, fixed.full_scale_n, -fixed.limit_n, fixed.limit_n)
    except DesignError as error:
        outside = [f"{1 + z:.6g}" for z in result.sampled.zeros if abs(1 + z) > 1 - 1e-6]
        other = "" if not result.reduced else ", sample time" if result.in_w else ", sample time or discretisation method"
        hint = f". K(z) has zeros on or outside the unit circle (z = {', '.join(outside)}), which its anti-windup suffers from: try another limit{other}" if outside else ""
        raise DesignError(f"{error}{hint}") from None
    result.q31 = result.quantised.q31
    values = result.q31.values()
    sections.check_sections(values)
    scales = ", ".join(str(s["scale"]) for s in result.q31.sections)
    result.noise_lsb = sections.rounding_noise(values, [s["scale"] for s in result.q31.sections])
    _accept(result, checker, "q31", SampledSections(values, h), limits.q31, f"{len(values)} sections, full scale {fixed.full_scale_n:g} N, outputs held times 2^-scale, scale {scales}")
    broken = breaches(result.stages[0].metrics, result.stages[-1].metrics, limits.total, None)
    if broken:
        raise LimitError(f"total, {result.stages[-1].step} against {result.stages[0].step}: {'; '.join(broken)}", table_text(result))
    result.robustness = robustness.study(result, checker)
    robustness.refuse_unstable(result.robustness)
    result.warnings = remarks(result)


def _accept(result, checker, step, controller, limits, note):
    before = result.stages[-1].metrics if result.stages else None
    loop, metrics = checker.close(controller)
    result.stages.append(Stage(step, loop, metrics, note))
    broken = breaches(before, metrics, limits, result.design.limits.floor)
    if broken:
        hint = _faster(result, checker) if step == "discrete" and result.reduced is not None else ""
        raise LimitError(f"{step}: {'; '.join(broken)}{hint}", table_text(result))


def _faster(result, checker):
    """Returns a sample time with which the design succeeds, if there is one: half, a quarter, ... of the design's."""
    design, full = result.design, result.stage("full")
    for i in range(1, 7):
        h = design.sample_time_s / 2**i
        trial = design.model_copy(update={"sample_time_s": h, "computation_delay_s": min(design.computation_delay_s, 2 * h)})
        faster = Checker(trial, checker.plant.zpk, checker.plant.space, checker.weights)
        try:
            for candidate in reduction.candidates(full.loop.controller, trial.reduction, h):
                _, reduced = faster.close(Continuous(candidate.zpk))
                if not breaches(full.metrics, reduced, trial.limits.reduced, trial.limits.floor):
                    break
            else:
                continue
            sampled = discretise.discretise(candidate.zpk, trial.discretisation, h)
            _, metrics = faster.close(SampledZpk(sampled, h))
        except (DesignError, ValueError, np.linalg.LinAlgError):
            continue
        if not breaches(reduced, metrics, trial.limits.discrete, trial.limits.floor):
            return f". Sampling costs too much here: a sample time of {h:.3g} s would keep the limits"
    return ". No shorter sample time tried (down to 1/64) keeps the limits either: ask for less bandwidth, or raise the limits"


def degradation(quantity, before, after):
    """Returns how much worse `after` is, in the limit's unit; None if it is not defined."""
    old, new = getattr(before, quantity.name), getattr(after, quantity.name)
    if old is None or new is None or np.isnan(old) or np.isnan(new):
        return None
    if np.isinf(old) or np.isinf(new):
        if old == new:
            return 0.0
        return np.inf if np.isinf(new) == (quantity.worse == "rise") else -np.inf
    if quantity.worse == "fall_abs":
        return old - new
    if old == 0:
        return 0.0 if new == 0 else np.inf if quantity.worse != "fall" else -np.inf
    percent = 100 * (new / old - 1)
    return {"rise": percent, "fall": -percent, "change": abs(percent)}[quantity.worse]


def breaches(before, after, limits, floor):
    """Returns the limits that a step breaks, each as one phrase. NaN breaks a limit."""
    if not after.stable:
        return ["the loop is not stable"]
    broken = []
    if before is not None:
        for quantity in QUANTITIES:
            limit = getattr(limits, quantity.limit)
            worse = degradation(quantity, before, after)
            if limit is None or worse is None:
                continue
            if not worse <= limit + 1e-9:
                unit = "deg" if quantity.worse == "fall_abs" else "%"
                broken.append(f"{quantity.title} {getattr(before, quantity.name):{quantity.format}} -> {getattr(after, quantity.name):{quantity.format}} is "
                              f"{worse:.3g} {unit} worse, limit {limit:g} {unit} ({quantity.limit})")
    if floor is not None:
        if not after.gain_margin >= floor.gain_margin_min:
            broken.append(f"gain margin {after.gain_margin:.4g} is under {floor.gain_margin_min:g} (limits.floor.gain_margin_min)")
        if not after.phase_margin_deg >= floor.phase_margin_min_deg:
            broken.append(f"phase margin {after.phase_margin_deg:.4g} deg is under {floor.phase_margin_min_deg:g} deg (limits.floor.phase_margin_min_deg)")
    return broken


def remarks(result):
    said = []
    if result.imported and result.reduced is not None and result.reduced.zpk.order < result.full_order:
        said.append(f"the imported K(s) is not what runs: {result.reduced.how}, which the row `reduced` shows. A K(z) is taken as it is; to keep more of K(s), raise "
                    "reduction.fast_mode_multiple and lower reduction.cancellation_percent")
    c = result.quantised.conditioning
    if abs(c - 1) > 1e-4:
        said.append(f"K(z) has a zero on or outside the unit circle: the library's anti-windup conditions with c = {c:.4g} instead of 1")
    return said


def cells(metrics):
    out = []
    for quantity in QUANTITIES:
        value = getattr(metrics, quantity.name)
        out.append("-" if value is None or np.isnan(value) else "inf" if np.isinf(value) else f"{value:{quantity.format}}")
    return out


def table_rows(result):
    """Header and rows as text cells: the figures, then each step's degradation against its limit."""
    header = ["step"] + [q.title + (f" [{q.unit}]" if q.unit else "") for q in QUANTITIES]
    figures = [[TITLES[s.step], *cells(s.metrics)] for s in result.stages]
    limits = result.design.limits
    pairs = [(result.stages[i - 1], result.stages[i], getattr(limits, result.stages[i].step), f"{TITLES[result.stages[i].step]} against the step before")
             for i in range(1, len(result.stages))]
    if len(result.stages) > 1 and result.stages[-1].step == "q31":
        pairs.append((result.stages[0], result.stages[-1], limits.total, "total"))
    worse = []
    for before, after, limit, title in pairs:
        row = [title]
        for quantity in QUANTITIES:
            value, bound = degradation(quantity, before.metrics, after.metrics), getattr(limit, quantity.limit)
            unit = " deg" if quantity.worse == "fall_abs" else " %"
            text = "-" if value is None else f"{value + 0.0:+.2g}" if abs(value) >= 5e-4 else "0"
            row.append(text + ("" if bound is None else f" / {bound:g}") + ("" if value is None else unit))
        worse.append(row)
    return header, figures, worse


def aligned(rows):
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "\n".join("  ".join(cell.ljust(w) if i == 0 else cell.rjust(w) for i, (cell, w) in enumerate(zip(row, widths))) for row in rows)


def table_text(result):
    if not result.stages:
        return ""
    header, figures, worse = table_rows(result)
    text = aligned([header, *figures])
    if worse:
        text += "\n\nworse than before (+) / limit\n" + aligned([header, *worse])
    return text
