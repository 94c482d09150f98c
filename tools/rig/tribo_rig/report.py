"""The report: one page, the verdict first."""

import tempfile
from pathlib import Path

import numpy as np

from tribo_identify import accept
from tribo_identify.report import figure_of, law_picture, look, page, picture, thin


def html(rig, first, lines, details, loop, lags, result, steps, slow, designed):
    pictures = [("What to expect", _expected(loop, first.readings)), ("Friction over force", law_picture(result)), ("The steps and the identified lags", _record(steps.segments[0], lags.model)),
                ("The slides and the identified friction", _record(slow.segments[0], result.model[0]))]
    last = designed.stages[-1].metrics
    margins = [f"controller: {len(designed.f32)} sections, bandwidth {last.bandwidth_rad_s:.3g} rad/s, gain margin {last.gain_margin:.3g}, phase margin {last.phase_margin_deg:.3g} deg"]
    return page(f"Rig {rig.name}", [*lines, "", *margins, *details], pictures)


def _expected(loop, readings):
    """Two periods of the task with and without compensation."""
    figure, axes = figure_of(2, 1, (12, 5))
    with tempfile.TemporaryDirectory() as name:
        for case, colour, label in (("off", look.WITHOUT, "without compensation"), ("on", look.FEEDFORWARD, "with it")):
            tree = accept.case_of(loop, case, loop["reference"]["low_N"], loop["reference"]["high_N"])
            t, r, _, y = accept.trace_of(tree, readings, Path(name))
            late = t >= t[-1] - 2 * accept.PERIOD_S
            axes[0, 0].plot(*thin(t[late], y[late]), color=colour, lw=1, label=label)
            axes[1, 0].plot(*thin(t[late], (r - y)[late]), color=colour, lw=0.8)
    axes[0, 0].set(ylabel="F [N]")
    axes[1, 0].set(ylabel="r - F [N]", xlabel="time [s]")
    axes[0, 0].legend(loc="upper right", fontsize=8)
    return picture(figure)


def _record(segment, model):
    figure, axes = figure_of(2, 1, (12, 5))
    n = min(len(model), len(segment.t))
    t, u, force, y = thin(segment.t[:n], segment.u[:n], segment.force[:n], np.asarray(model)[:n])
    axes[0, 0].plot(t, u, color=look.colour("u_N"), lw=0.8, label="u")
    axes[0, 0].plot(t, force, color=look.MEASURED, lw=1.8, label="F")
    axes[0, 0].plot(t, y, color=look.MODEL, lw=0.9, ls="--", label="model")
    axes[1, 0].plot(t, force - y, color=look.DIFFERENCE, lw=0.8)
    axes[0, 0].set(ylabel="u, F [N]")
    axes[1, 0].set(ylabel="F minus model [N]", xlabel="time [s]")
    axes[0, 0].legend(loc="upper right", fontsize=8)
    return picture(figure)
