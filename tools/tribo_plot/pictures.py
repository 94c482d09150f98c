"""Panels as PNG or SVG, by matplotlib. The same data give the same file: no date, no random ids."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from . import look
from .panels import thin

COLUMNS = 1600  # a little more than pixels


def draw(names, panels, out):
    with matplotlib.rc_context({**look.STYLE, "font.size": 9, "axes.titlesize": 10}):
        figure = _figure(names, panels)
        save(figure, out)
        plt.close(figure)


def save(figure, out):
    metadata = {"Date": None, "Creator": None} if out.suffix == ".svg" else {"Software": None}
    figure.savefig(out, dpi=130, metadata=metadata)


def _figure(names, panels):
    over_time = [panel for panel in panels if panel.over_time]
    others = [panel for panel in panels if not panel.over_time]
    figure = plt.figure(figsize=(13, 0.6 + max(1.75 * len(over_time), 3.4 * len(others))))
    figure.suptitle(names[0] if len(names) == 1 else " ", x=0.008, ha="left", fontsize=12, fontweight="bold")
    if len(names) > 1:
        handles = [plt.Line2D([], [], label=name, **_style(look.GUIDE, run)) for run, name in enumerate(names)]
        figure.legend(handles=handles, loc="upper left", ncols=len(names), handlelength=3.0, fontsize=10)
    halves = figure.subfigures(1, 2, width_ratios=(2, 1), facecolor="none") if over_time and others else (figure, figure)
    if over_time:
        rows = halves[0].subplots(len(over_time), 1, sharex=True, squeeze=False)[:, 0]
        for axes, panel in zip(rows, over_time):
            _draw(axes, panel)
            axes.margins(x=0)
        rows[-1].set_xlabel(over_time[-1].x_label)
    if others:
        for axes, panel in zip(halves[-1].subplots(len(others), 1, squeeze=False)[:, 0], others):
            _draw(axes, panel)
            axes.set_xlabel(panel.x_label)
    return figure


def _style(colour, run):
    width, dashes, order = look.RUNS[run % len(look.RUNS)][2:]
    return {"color": look.shade(colour, run), "linewidth": width, "linestyle": (0, dashes) if dashes else "-", "zorder": 2 + 0.1 * order}


def _draw(axes, panel):
    handles = {}
    for line in panel.lines:
        style = _style(line.colour, line.run)
        if line.is_guide:
            style |= {"linestyle": (0, (4, 2)), "linewidth": 0.9, "zorder": 3}
        x, y = thin(line, COLUMNS, panel.over_time)
        axes.plot(x, y, drawstyle="steps-post" if line.is_step else "default", **style)
        handles.setdefault(line.name, plt.Line2D([], [], label=line.name, **{**_style(line.colour, 0), "linestyle": "--" if line.is_guide else "-"}))
        if line.low:
            every = max(1, len(line.x) // COLUMNS)
            axes.fill_between(line.x[::every], line.low[::every], line.high[::every], color=line.colour, alpha=0.15, linewidth=0)
    axes.set_ylabel(panel.y_label)
    if panel.y_range:
        axes.set_ylim(*panel.y_range)
    if panel.title == "Relays":
        axes.set_yticks([])
    # Above the panel, where no line is: beside the title where there is room, else below it.
    axes.set_title(panel.title + (f"  ({panel.note})" if panel.note else ""), pad=6 if panel.over_time else 20)
    side = ("lower right", (1.0, 1.0)) if panel.over_time else ("lower left", (0.0, 1.0))
    axes.legend(handles=list(handles.values()), loc=side[0], bbox_to_anchor=side[1], ncols=len(handles), borderaxespad=0.1,
                handlelength=1.6, columnspacing=1.2, fontsize=8)
