"""Tables and pictures of a sweep, from the frame of tribo.sweep: each measure against each axis. The same rows give the same files."""

import math
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Patch

from . import output, page
from .look import GUIDE, STYLE, WITHOUT
from .look import PAPER as WITH
from .panels import Line, Panel
from .pictures import save
from .runs import PlotError, is_there

LISTED_MAX = 20  # values that an axis may have to be drawn as boxes
BINS = 8  # of an axis with more

matplotlib.rcParams.update({**STYLE, "axes.titlesize": 10, "font.size": 9, "savefig.dpi": 110})


class Sweep:
    """The rows with a result, by column, and the columns that are axes."""

    def __init__(self, frame):
        self.frame = frame
        self.rows = frame[frame["status"] == "ok"]
        if self.rows.empty:
            raise PlotError(f"{frame.attrs['study']}: no row has a result")
        self.axes = frame.attrs["axes"]
        self.text = {axis: [value if isinstance(value, str) else f"{value:.6g}" for value in self.rows[axis]] for axis in self.axes}
        self.is_paired = "ratio" in frame
        names = ["rms_error_N", "chatter_ticks", "window_ticks", "limited_ticks", "variation_ratio"]
        names += ["ratio", "without_rms_error_N", "without_chatter_ticks"] if self.is_paired else []
        self.value = {name: self.rows[name].to_numpy() for name in names}
        self.value["chatter"] = 100 * self.value["chatter_ticks"] / self.value["window_ticks"]

    @classmethod
    def read(cls, path):
        """Reads the rows of a sweep."""
        if not is_there(path):
            raise PlotError(f"{path}: there is none: has the sweep come to its end?")
        try:
            import pandas
            import pyarrow  # noqa: F401
        except ImportError as error:
            raise PlotError(f"{sys.executable} cannot import pandas and pyarrow, which read {path} ({error}): `pip install tribo[sweep]`") from None
        try:
            frame = pandas.read_parquet(path)
        except (OSError, ValueError) as error:
            raise PlotError(f"{path}: cannot be read: {error}") from None
        if "axes" not in frame.attrs:
            raise PlotError(f"{path}: is not of a sweep")
        return cls(frame)

    def groups(self, axis):
        """Label, place and rows of each value of an axis with few, or of each of its parts; and the values if there are many."""
        text = self.text[axis]
        listed = list(dict.fromkeys(text))
        is_number = not isinstance(self.rows[axis].iloc[0], str)
        numbers = self.rows[axis].to_numpy(float) if is_number else None
        if len(listed) <= LISTED_MAX or not is_number:
            if is_number:
                listed.sort(key=float)
            return [(value, i, np.array([one == value for one in text])) for i, value in enumerate(listed)], None
        edges = np.quantile(numbers, np.linspace(0, 1, BINS + 1))
        parts = []
        for low, high in zip(edges, edges[1:]):
            inside = (numbers >= low) & ((numbers < high) | (high == edges[-1]))
            parts.append((f"{low:.3g} to {high:.3g}", float(np.median(numbers[inside])), inside))
        return parts, numbers


def is_logarithmic(numbers):
    """Whether values cover a wide range, and are spread evenly over the logarithm, not over the numbers."""
    low, high, middle = numbers.min(), numbers.max(), np.median(numbers)
    if low <= 0 or high / low <= 8:
        return False
    return bool(abs(np.log(middle / np.sqrt(low * high))) < abs(np.log(middle / ((low + high) / 2))))


def label_of(sweep, axis):
    return f"{axis}, × the scenario's" if axis in sweep.frame.attrs["relative"] else axis


def draw_axis(axes, sweep, axis, measure, colour):
    """Quantiles of a measure over an axis: a band from 5 to 95 %, one from 25 to 75 %, and the median."""
    groups, numbers = sweep.groups(axis)
    values = sweep.value[measure]
    places = [place for _, place, _ in groups]
    quantiles = np.array([np.nanquantile(values[inside], (0.05, 0.25, 0.5, 0.75, 0.95)) for _, _, inside in groups]).T
    if numbers is None:
        width = 0.7
        axes.bar(places, quantiles[4] - quantiles[0], width, quantiles[0], color=colour, alpha=0.2, linewidth=0)
        axes.bar(places, quantiles[3] - quantiles[1], width, quantiles[1], color=colour, alpha=0.35, linewidth=0)
        axes.hlines(quantiles[2], np.array(places) - width / 2, np.array(places) + width / 2, color=colour, linewidth=2)
        labels = [label for label, _, _ in groups]
        turned = sum(map(len, labels)) > 40
        axes.set_xticks(places, labels, rotation=90 if turned else 0, fontsize=7 if turned else 9)
        axes.grid(axis="x", visible=False)
    else:
        axes.plot(numbers, values, ".", color=colour, markersize=2, alpha=max(0.05, min(0.5, 500 / len(numbers))))
        axes.fill_between(places, quantiles[0], quantiles[4], color=colour, alpha=0.2, linewidth=0)
        axes.fill_between(places, quantiles[1], quantiles[3], color=colour, alpha=0.35, linewidth=0)
        axes.plot(places, quantiles[2], color=colour, linewidth=2)
        if is_logarithmic(numbers):
            axes.set_xscale("log")


def shown_axes(sweep):
    return [axis for axis in sweep.axes if len(set(sweep.text[axis])) > 1 and axis != "sensor.noise_seed"]


def figure_of(sweep, measures, title, unit, log):
    """Makes one panel per axis."""
    shown = shown_axes(sweep)
    columns = min(3, max(1, len(shown)))
    rows = max(1, math.ceil(len(shown) / columns))
    figure, panels = plt.subplots(rows, columns, figsize=(max(8.0, 4.6 * columns), 2.9 * rows + 0.5), squeeze=False, sharey=True)
    figure.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold")
    for panel, axis in zip(panels.flat, shown):
        for measure, colour, _ in measures:
            draw_axis(panel, sweep, axis, measure, colour)
        panel.set_xlabel(label_of(sweep, axis))
        if log:
            panel.set_yscale("log")
        if measures[0][0] == "ratio":
            panel.axhline(1.0, color=GUIDE, linewidth=1, linestyle="--")
    for panel in list(panels.flat)[len(shown) :]:
        panel.set_visible(False)
    for row in panels:
        row[0].set_ylabel(unit)
    handles = [plt.Line2D([], [], color=colour, linewidth=2, label=name) for _, colour, name in measures if name]
    shades = GUIDE if handles else measures[0][1]
    handles.append(plt.Line2D([], [], color=shades, linewidth=2, label="median"))
    handles += [Patch(color=shades, alpha=alpha, linewidth=0, label=f"{part} % of rows") for part, alpha in ((50, 0.5), (90, 0.2))]
    figure.legend(handles=handles, loc="upper right", ncols=len(handles))
    return figure


def milli(value):
    return f"{1e3 * value:.3g}"


def table_of(sweep, axis):
    """A Markdown table with the results of each value or part of an axis."""
    head = ["" if axis is None else axis, "rows", "RMS error, 50 %", "95 %", "largest (mN)"]
    if sweep.is_paired:
        head += ["without, 50 % (mN)", "ratio, 5 %", "50 %", "95 %", "worse than without"]
    head += ["chatter, 50 %", "95 % of ticks"]
    lines = [head, ["---"] * len(head)]
    groups = [("all", 0, np.full(len(sweep.value["rms_error_N"]), True))] if axis is None else sweep.groups(axis)[0]
    for label, _, inside in groups:
        rms, chatter = sweep.value["rms_error_N"][inside], sweep.value["chatter"][inside]
        line = [label, str(len(rms)), milli(np.quantile(rms, 0.5)), milli(np.quantile(rms, 0.95)), milli(rms.max())]
        if sweep.is_paired:
            ratio = sweep.value["ratio"][inside]
            line.append(milli(np.quantile(sweep.value["without_rms_error_N"][inside], 0.5)))
            line += [f"{np.nanquantile(ratio, p):.3g}" for p in (0.05, 0.5, 0.95)]
            line.append(f"{100 * np.mean(ratio < 1):.3g} %")
        line += [f"{np.quantile(chatter, p):.3g}" for p in (0.5, 0.95)]
        lines.append(line)
    return ["| " + " | ".join(line) + " |" for line in lines]


def report_of(sweep):
    attrs, failed = sweep.frame.attrs, sweep.frame[sweep.frame["status"] != "ok"]
    lines = [f"# {attrs['study']}", "", f"{len(sweep.frame)} rows, {len(failed)} of them failed."]
    lines += [f"- row {row}: {status}: {message}" for row, status, message in failed[["row", "status", "message"]].head(10).itertuples(index=False)]
    lines += ["", *table_of(sweep, None), ""]
    for name in ("ratio", "rms", "chatter") if sweep.is_paired else ("rms", "chatter"):
        lines += [f"![{name} against each axis]({name}.png)", ""]
    for axis in sweep.axes:
        lines += [*table_of(sweep, axis), ""]
    lines.append("Worst rows, each with and without:" if sweep.is_paired else "Worst rows:")
    for name, worst in attrs["worst"].items():
        lines += ["", f"## {name}", ""]
        for one in worst:
            lines += [f"row {one['row']}, {one['value']:.4g}:", "", "    " + one["command"]]
            lines += ["    " + one["without"], ""] if "without" in one else [""]
    return "\n".join(lines).rstrip() + "\n"


def figures_of(sweep):
    """The pictures by name, drawn on request."""
    pair = [("without_rms_error_N", WITHOUT, "without"), ("rms_error_N", WITH, "with")]
    figures = {
        "rms": lambda: figure_of(sweep, pair if sweep.is_paired else pair[1:], "RMS of r − F", "N", True),
        "chatter": lambda: figure_of(sweep, [("chatter", WITH, "")], "Chatter", "% of ticks", False),
    }
    if sweep.is_paired:
        figures["ratio"] = lambda: figure_of(sweep, [("ratio", WITH, "")], "RMS error without / with", "ratio", True)
    return figures


MEASURES = {"ratio": ("RMS error without / with", "ratio", WITH), "without_rms_error_N": ("RMS of r − F without", "N", WITHOUT),
            "rms_error_N": ("RMS of r − F", "N", WITH), "chatter": ("Chatter", "% of ticks", WITH)}


def panels_of(sweep):
    """Every row as a point, and the medians, for a page."""
    panels = []
    for measure, (title, unit, colour) in MEASURES.items():
        for axis in shown_axes(sweep) if measure in sweep.value else ():
            groups, numbers = sweep.groups(axis)
            values, label = sweep.value[measure], label_of(sweep, axis)
            panel = Panel(f"{title}, {label}", unit, label, over_time=False, is_log=(False, measure != "chatter"))
            places = [place for _, place, _ in groups]
            if numbers is None:
                panel.x_names = [name for name, _, _ in groups]
                numbers = np.array([next(place for _, place, inside in groups if inside[i]) for i in range(len(values))], float)
            else:
                panel.is_log = (is_logarithmic(numbers), panel.is_log[1])
            medians = [float(np.nanmedian(values[inside])) for _, _, inside in groups]
            panel.lines = [Line("a row", colour, list(numbers), list(values), is_points=True), Line("median", colour, places, medians)]
            panels.append(panel)
    return panels


def draw(path, out):
    """The main measure of a sweep: the ratio if it has one, otherwise the error; a page has all measures."""
    sweep = Sweep.read(path)
    if out.suffix == ".html":
        page.draw([sweep.frame.attrs["study"]], panels_of(sweep), out)
    else:
        save(figures_of(sweep)["ratio" if sweep.is_paired else "rms"](), out)


def report(frame, folder):
    """Writes the report and its pictures, and returns their paths."""
    sweep = Sweep(frame)
    figures = figures_of(sweep)
    for name, make in figures.items():
        figure = make()
        with output.replaced(folder / f"{name}.png") as new:
            figure.savefig(new, metadata={"Software": None})
        plt.close(figure)
    output.write(folder / "report.md", report_of(sweep))
    return [folder / "report.md", *(folder / f"{name}.png" for name in figures)]
