"""The tables and pictures of tools/sweep-report.

    sweep_report.py DIR

Reads DIR/rows.csv and DIR/summary.json of tribo-sim sweep; writes DIR/report.md, and DIR/ratio.png, rms.png and chatter.png: each
measure against each axis. The same rows give the same files.
"""

import csv
import json
import math
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

WITHOUT = "#D55E00"
WITH = "#0072B2"
GUIDE = "#767676"

LISTED_MAX = 20  # values that an axis may have to be drawn as boxes
BINS = 8  # of an axis with more

matplotlib.rcParams.update(
    {
        "axes.axisbelow": True,
        "axes.grid": True,
        "axes.spines.right": False,
        "axes.spines.top": False,
        "axes.titlelocation": "left",
        "axes.titlesize": 10,
        "figure.constrained_layout.use": True,
        "font.family": "DejaVu Sans",
        "font.size": 9,
        "grid.color": "#E4E4E4",
        "legend.frameon": False,
        "savefig.dpi": 110,
    }
)


def number(text):
    """NaN for what is no number."""
    try:
        return float(text)
    except ValueError:
        return math.nan


class Sweep:
    """The rows by column, and which of the columns are axes."""

    def __init__(self, folder):
        self.folder = folder
        self.summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        with open(folder / "rows.csv", newline="", encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file) if row["status"] == "ok"]
        if not rows:
            sys.exit(f"{folder}/rows.csv: no row has a result")
        self.rows = rows
        self.axes = self.summary["axes"]
        self.text = {axis: [row[axis] for row in rows] for axis in self.axes}
        self.is_paired = "ratio" in rows[0]
        names = ["rms_error_N", "chatter_ticks", "window_ticks", "limited_ticks"]
        names += ["ratio", "without_rms_error_N", "without_chatter_ticks"] if self.is_paired else []
        self.value = {name: self.number(name) for name in names}
        self.value["chatter"] = 100 * self.value["chatter_ticks"] / self.value["window_ticks"]

    def number(self, name):
        """A column, NaN where there is no number."""
        return np.array([number(row[name]) for row in self.rows])

    def groups(self, axis):
        """Label, place and rows of each value of an axis with few, or of each of its parts; and the values if there are many."""
        text = self.text[axis]
        listed = list(dict.fromkeys(text))
        numbers = np.array([number(value) for value in text])
        is_number = not np.isnan(numbers).any()
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
        if numbers.min() > 0 and numbers.max() / numbers.min() > 30:
            axes.set_xscale("log")


def figure_of(sweep, measures, title, unit, log):
    """One panel an axis."""
    shown = [axis for axis in sweep.axes if len(set(sweep.text[axis])) > 1 and axis != "sensor.noise_seed"]
    columns = min(3, max(1, len(shown)))
    rows = max(1, math.ceil(len(shown) / columns))
    figure, panels = plt.subplots(rows, columns, figsize=(4.6 * columns, 2.9 * rows + 0.5), squeeze=False, sharey=True)
    figure.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold")
    for panel, axis in zip(panels.flat, shown):
        for measure, colour, _ in measures:
            draw_axis(panel, sweep, axis, measure, colour)
        panel.set_title(axis)
        if log:
            panel.set_yscale("log")
        if measures[0][0] == "ratio":
            panel.axhline(1.0, color=GUIDE, linewidth=1, linestyle="--")
    for panel in list(panels.flat)[len(shown) :]:
        panel.set_visible(False)
    for row in panels:
        row[0].set_ylabel(unit)
    handles = [plt.Line2D([], [], color=colour, linewidth=2, label=name) for _, colour, name in measures if name]
    if handles:
        figure.legend(handles=handles, loc="upper right", ncols=len(handles))
    return figure


def milli(value):
    return f"{1e3 * value:.3g}"


def table_of(sweep, axis):
    """Markdown: what each value or part of an axis comes to."""
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
    summary = sweep.summary
    lines = [f"# {summary['study']}", "", f"{summary['rows']} rows, {summary['failed']} of them failed."]
    lines += [f"- {failure}" for failure in summary["failures"]]
    lines += ["", *table_of(sweep, None), ""]
    for name in ("ratio", "rms", "chatter") if sweep.is_paired else ("rms", "chatter"):
        lines += [f"![{name} against each axis]({name}.png)", ""]
    for axis in sweep.axes:
        lines += [*table_of(sweep, axis), ""]
    lines.append("Worst rows, each with and without:" if sweep.is_paired else "Worst rows:")
    for name, worst in summary["worst"].items():
        lines += ["", f"## {name}", ""]
        for one in worst:
            lines += [f"row {one['row']}, {one['value']:.4g}:", "", "    " + one["command"]]
            lines += ["    " + one["without"], ""] if "without" in one else [""]
    return "\n".join(lines).rstrip() + "\n"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    for name in ("rows.csv", "summary.json"):
        if not (folder / name).is_file():
            sys.exit(f"{folder / name}: there is none: has the sweep come to its end?")
    sweep = Sweep(folder)
    pair = [("without_rms_error_N", WITHOUT, "without"), ("rms_error_N", WITH, "with")]
    figures = {
        "rms": figure_of(sweep, pair if sweep.is_paired else pair[1:], "RMS of r − F", "N", True),
        "chatter": figure_of(sweep, [("chatter", WITH, "")], "Chatter", "% of ticks", False),
    }
    if sweep.is_paired:
        figures["ratio"] = figure_of(sweep, [("ratio", WITH, "")], "RMS error without / with", "ratio", True)
    for name, figure in figures.items():
        figure.savefig(folder / f"{name}.png", metadata={"Software": None})
        plt.close(figure)
    (folder / "report.md").write_text(report_of(sweep), encoding="utf-8")
    print(f"written: report.md, {', '.join(name + '.png' for name in figures)} in {folder}")


if __name__ == "__main__":
    main()
