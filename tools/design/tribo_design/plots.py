"""The report's plots, as PNG bytes."""

import numpy as np

from .drawing import figure_of, look, png
from .pipeline import TITLES

# Each step has its own line style. Later steps are thinner and more dashed, so that lines on top of each other stay visible.
LOOKS = {"full": dict(lw=5.0, ls="-"), "reduced": dict(lw=3.2, ls="-"), "discrete": dict(lw=2.0, ls="-"), "f32": dict(lw=1.4, ls=(0, (6, 4))),
         "q31": dict(lw=1.4, ls=(4, (2, 8)))}
LOOKS = {step: {"color": look.STAGES[step]} | more for step, more in LOOKS.items()}
BELOW_NYQUIST = 0.98  # at Nyquist itself a zero at z = -1 gives a vertical line, and its phase is rounding noise
CAPTIONS = {
    "sensitivity": "S, T, KS and GS at each step, against the inverse weights, the wish (dotted): a curve above its dotted line breaks it. With gamma below 1 none does.",
    "friction": "A triangle with the paper's friction in the loop, played by tribo-sim with the f32 sections: the last period, with and without compensation.",
    "nyquist": "Nyquist plot of the loop at each step: whole (scaled so that everything fits) and near -1, with the circle of max abs S.",
    "controller": "The controller itself at each step.",
    "step": "A reference step of 1 N: force, and controller output.",
    "ramp": "A reference ramp: force against the reference, and the error.",
    "sections": "Section by section: each section as it runs, and the rounding of its coefficients as the relative difference from the design.",
}


def draw_all(result):
    extra = {"friction": png(_friction(result))} if result.traces else {}
    return extra | {name: png(draw(result)) for name, draw in
            (("sensitivity", _sensitivity), ("nyquist", _nyquist), ("controller", _controller), ("step", _step), ("ramp", _ramp), ("sections", _sections))}


def _span(result):
    """The frequencies worth showing: around the weights' and the loop's corners."""
    stage = result.stages[-1]
    nyquist = np.pi / result.design.sample_time_s
    centre = stage.metrics.crossover_rad_s
    if not np.isfinite(centre):
        centre = nyquist / 30
    poles = np.abs(np.concatenate([s.loop.controller.poles() for s in result.stages]))
    low = max(min(centre / 100, poles[poles > 0].min() / 10 if np.any(poles > 0) else centre), centre / 1e5)
    return low, max(nyquist * 3, centre * 100)


def _omega(loop, span):
    low, high = span
    top = min(high, BELOW_NYQUIST * np.pi / loop.h) if loop.h is not None else high
    extra = loop.omega[(loop.omega > low) & (loop.omega < top)]
    return np.unique(np.r_[np.geomspace(low, top, 800), extra])


def _nyquist_line(axis, result):
    axis.axvline(np.pi / result.design.sample_time_s, color=look.GUIDE, lw=0.8, ls="--")


def _sensitivity(result):
    figure, axes = figure_of(2, 2, (12, 8.4))
    span = _span(result)
    for axis, index, name, weight in zip(axes.flat, range(4), ("S", "T", "KS", "GS"), ("wp", "wT", "wu", "wGS")):
        low, high = np.inf, 0
        for stage in result.stages:
            omega = _omega(stage.loop, span)
            size = np.abs(stage.loop.closed_loop(omega)[index] if index < 3 else stage.loop.load(omega))
            axis.loglog(omega, size, label=TITLES[stage.step], **LOOKS[stage.step])
            low, high = min(low, np.nanmin(size)), max(high, np.nanmax(size))
        function = result.stages[0].loop.weights.get(weight)
        if function is not None:
            omega = np.geomspace(*span, 800)
            axis.loglog(omega, 1 / np.maximum(np.abs(function(1j * omega)), 1e-300), color=look.WISH, lw=2, ls=":", label=f"1 / |{weight}|")
            high = max(high, min(1 / np.abs(function(1j * omega)).min(), high * 10))
        axis.set_ylim(max(low / 2, high * 1e-7), high * 3)
        _nyquist_line(axis, result)
        axis.set_title(f"|{name}|")
        axis.set_xlabel("frequency [rad/s]  (dashed: Nyquist)")
        axis.legend(fontsize=8, loc="best")
    return figure


def _nyquist(result):
    figure, axes = figure_of(1, 2, (12, 5.6))
    span = _span(result)
    whole, near = axes[0]
    for stage in result.stages:
        omega = _omega(stage.loop, (span[0], span[1]))
        loop = stage.loop.open_loop(omega)
        squeezed = loop / np.maximum(np.abs(loop), 1e-300) * np.log1p(np.abs(loop))
        near.plot(loop.real, loop.imag, label=TITLES[stage.step], **LOOKS[stage.step])
        whole.plot(squeezed.real, squeezed.imag, label=TITLES[stage.step], **LOOKS[stage.step])
    angle = np.linspace(0, 2 * np.pi, 200)
    whole.plot(np.log(2) * np.cos(angle), np.log(2) * np.sin(angle), color=look.GUIDE, lw=0.8)
    whole.plot([-np.log(2)], [0], "r+", ms=12, mew=2)
    whole.set_title("whole, radius log(1 + |L|)")
    near.plot(np.cos(angle), np.sin(angle), color=look.GUIDE, lw=0.8)
    radius = 1 / result.stages[-1].metrics.max_s
    near.plot(-1 + radius * np.cos(angle), radius * np.sin(angle), color=look.WISH, lw=1.2, ls=":", label="max |S| circle, last step")
    near.plot([-1], [0], "r+", ms=12, mew=2)
    near.set_xlim(-2.2, 1.2)
    near.set_ylim(-1.7, 1.7)
    near.set_title("near -1")
    for axis in (whole, near):
        axis.set_aspect("equal")
        axis.set_xlabel("Re")
        axis.set_ylabel("Im")
    near.legend(fontsize=8, loc="upper right")
    return figure


def _controller(result):
    figure, axes = figure_of(2, 1, (9, 6.2))
    span = _span(result)
    for stage in result.stages:
        omega = _omega(stage.loop, span)
        response = stage.loop.controller.response(omega)
        axes[0, 0].loglog(omega, np.abs(response), label=TITLES[stage.step], **LOOKS[stage.step])
        axes[1, 0].semilogx(omega, np.degrees(np.unwrap(np.angle(response))), **LOOKS[stage.step])
    axes[0, 0].set_ylabel("|K|")
    axes[1, 0].set_ylabel("phase of K [deg]")
    axes[1, 0].set_xlabel("frequency [rad/s]  (dashed: Nyquist)")
    for axis in axes[:, 0]:
        _nyquist_line(axis, result)
        axis.set_xlim(*span)
    axes[0, 0].legend(fontsize=8)
    return figure


def _duration(result):
    bandwidth = result.stages[-1].metrics.bandwidth_rad_s
    if not np.isfinite(bandwidth):
        bandwidth = result.stages[-1].metrics.crossover_rad_s
    return 12 / bandwidth if np.isfinite(bandwidth) and bandwidth > 0 else 1000 * result.design.sample_time_s


def _step(result):
    figure, axes = figure_of(1, 2, (12, 4.6))
    for stage in result.stages:
        time, _, y, u = stage.loop.responses(_duration(result))
        axes[0, 0].plot(time, y, label=TITLES[stage.step], **LOOKS[stage.step])
        axes[0, 1].plot(time, u, drawstyle="default" if stage.loop.h is None else "steps-post", **LOOKS[stage.step])
    axes[0, 0].axhline(1, color=look.GUIDE, lw=0.8)
    for axis, name in zip(axes[0], ("force y [N]", "controller output u [N]")):
        axis.set_ylabel(name)
        axis.set_xlabel("time [s]")
    axes[0, 0].legend(fontsize=8)
    return figure


def _ramp(result):
    figure, axes = figure_of(1, 2, (12, 4.6))
    ramp = result.design.ramp
    duration = min(ramp.duration_s, _duration(result))
    for stage in result.stages:
        time, r, y, _ = stage.loop.responses(duration, ramp.rate_n_per_s)
        axes[0, 0].plot(time, y, label=TITLES[stage.step], **LOOKS[stage.step])
        axes[0, 1].plot(time, r - y, **LOOKS[stage.step])
    axes[0, 0].plot(time, r, color=look.WISH, lw=1, ls=":", label="reference")
    axes[0, 0].set_ylabel("force y [N]")
    axes[0, 1].set_ylabel("error r - y [N]")
    final = result.stages[-1].metrics.ramp_error_n
    if np.isfinite(final):
        axes[0, 1].axhline(final, color=look.GUIDE, lw=0.8, ls="--")
        axes[0, 1].set_title(f"dashed: the table's error after {ramp.duration_s:g} s, {final:.4g} N", fontsize=9)
    for axis in axes[0]:
        axis.set_xlabel("time [s]")
    axes[0, 0].legend(fontsize=8)
    return figure


def _friction(result):
    figure, axes = figure_of(1, 2, (12, 4.6))
    for (case, (time, r, force)), color in zip(result.traces.items(), (look.WITHOUT, look.FEEDFORWARD)):
        label = f"{case} compensation"
        axes[0, 0].plot(time, force, color=color, lw=1.4, label=label)
        axes[0, 1].plot(time, r - force, color=color, lw=1.2, label=label)
    axes[0, 0].plot(time, r, color=look.GUIDE, lw=1, ls=":", label="reference")
    axes[0, 0].set_ylabel("force F [N]")
    axes[0, 1].set_ylabel("error r - F [N]")
    for axis in axes[0]:
        axis.set_xlabel("time [s]")
        axis.legend(fontsize=8)
    return figure


def _sections(result):
    from .loop import SampledSections

    h = result.design.sample_time_s
    count = len(result.f32)
    figure, axes = figure_of(2, count + 1, (4.2 * (count + 1), 6.4))
    omega = np.geomspace(max(_span(result)[0], 1e-6 / h), BELOW_NYQUIST * np.pi / h, 1200)
    design = SampledSections(result.cascade.sections, h).section_responses(omega)
    coded = {"f32": SampledSections(result.f32, h).section_responses(omega), "q31": SampledSections(result.q31.values(), h).section_responses(omega)}
    for i in range(count + 1):
        top, bottom = axes[0, i], axes[1, i]
        pick = (lambda r: np.prod(r, axis=0)) if i == count else (lambda r, i=i: r[i])
        top.loglog(omega, np.abs(pick(design)), label="design", **LOOKS["discrete"])
        for step in ("f32", "q31"):
            top.loglog(omega, np.abs(pick(coded[step])), label=TITLES[step], **LOOKS[step])
            difference = np.abs(pick(coded[step]) / pick(design) - 1)
            bottom.loglog(omega, np.maximum(difference, 1e-17), label=TITLES[step], **(dict(color=look.shade(look.GUIDE, 1), lw=4) if step == "f32" else dict(color=look.STAGES["q31"], lw=1.4)))
        top.set_title("whole cascade" if i == count else f"section {i + 1}" + (" (input)" if i == 0 else " (output)" if i == count - 1 else ""))
        bottom.set_ylim(1e-13, 1e-4)
        bottom.set_xlabel("frequency [rad/s]")
    axes[0, 0].set_ylabel("magnitude")
    axes[1, 0].set_ylabel("relative difference from the design")
    axes[0, 0].legend(fontsize=8)
    axes[1, 0].legend(fontsize=8)
    return figure
