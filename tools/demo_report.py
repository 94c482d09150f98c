"""The table and the pictures of tools/demo.

    demo_report.py WITHOUT_DIR PAPER_DIR FEEDFORWARD_DIR REPLAY_CSV JOINT_CSV OUT_DIR

Reads what three runs of tribo-sim wrote, without friction compensation and with its two methods, the output of tribo-sim
replay for the friction law with k = 1.1, and the motions of a joint (tests/package/joint_board.c). Prints the table, writes PNG and SVG. The same data give the same files: no date, no
random ids.
"""

import bisect
import csv
import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.ticker import MultipleLocator

from tribo_plot import look
from tribo_plot.look import FALLS, FEEDFORWARD, GUIDE, PAPER, RISES, WITHOUT, colour

PERIOD_S = 20.0  # of the triangle
SETTLED_S = 20.0  # the first period starts from rest and counts in no figure
PAPER_RMS_N = 0.0038, 0.0010  # without and with compensation
TURNS_DOWN_S = 30.0
TURNS_UP_S = 40.0
TURNS_JOINT_S = 6.0

matplotlib.rcParams.update(
    {
        **look.STYLE,
        "axes.titlesize": 11,
        "figure.constrained_layout.h_pad": 0.08,
        "figure.dpi": 100,
        "font.size": 10,
        "lines.linewidth": 1.4,
        "savefig.dpi": 160,
    }
)


class Trace:
    """The columns of a CSV file of tribo-sim by name, as lists of numbers."""

    def __init__(self, columns):
        self._columns = columns

    @classmethod
    def read(cls, path):
        with open(path, newline="", encoding="utf-8") as file:
            rows = csv.reader(file)
            names = next(rows)
            columns = zip(*([float(text) for text in row] for row in rows))
        return cls(dict(zip(names, map(list, columns))))

    def __getitem__(self, name):
        return self._columns[name]

    def between(self, start_s, end_s):
        """The same columns from start_s to end_s."""
        times = self["t_s"]
        kept = slice(bisect.bisect_left(times, start_s), bisect.bisect_right(times, end_s))
        return Trace({name: values[kept] for name, values in self._columns.items()})

    def around(self, time_s, half_s):
        return self.between(time_s - half_s, time_s + half_s)

    def error_mn(self):
        """r - F, in mN."""
        return [1e3 * (r - force) for r, force in zip(self["r_N"], self["F_N"])]


def rms(values):
    return (sum(value * value for value in values) / len(values)) ** 0.5


def title(figure, text):
    """In a line above all axes; a legend on the right shares it."""
    figure.suptitle(text, x=0.012, ha="left", fontsize=13, fontweight="bold")


def legend(figure, axes):
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="upper right", ncols=len(labels), handlelength=1.6, columnspacing=1.4, borderaxespad=0.1
    )


def label_time(axes, trace):
    start_s, end_s = round(trace["t_s"][0], 1), round(trace["t_s"][-1], 1)
    axes.set_xlabel("time (s)")
    axes.set_xlim(start_s, end_s)
    axes.xaxis.set_major_locator(MultipleLocator(10.0 if end_s - start_s > 10.0 else 1.0 if end_s - start_s > 2.5 else 0.5))


def corners(times, values):
    """The points of a two-valued signal that a step plot needs."""
    last = len(values) - 1
    kept = [i for i, value in enumerate(values) if i in (0, last) or value != values[i - 1]]
    return [times[i] for i in kept], [values[i] for i in kept]


def by_direction(trace, values):
    """`values` where the net force rises and where it falls, each with gaps for the other."""
    n = trace["n_N"]
    rises = [after > before for before, after in zip(n, n[1:])]
    rises.append(rises[-1])
    gap = float("nan")
    return (
        [value if up else gap for value, up in zip(values, rises)],
        [gap if up else value for value, up in zip(values, rises)],
    )


def draw_force(axes, without, with_, fed):
    axes.plot(without["t_s"], without["F_N"], color=WITHOUT, label="without compensation")
    axes.plot(with_["t_s"], with_["F_N"], color=PAPER, label="the paper's method")
    axes.plot(fed["t_s"], fed["F_N"], color=FEEDFORWARD, label="feed-forward", linewidth=2.2)
    axes.plot(with_["t_s"], with_["r_N"], color=colour("r_N"), linestyle=(0, (4, 2)), linewidth=1.1, label="reference")
    axes.set_ylabel("force (N)")
    label_time(axes, with_)


def draw_errors(rows, *traces):
    """Below each other at one scale: `rows` share their axes."""
    names = "Without compensation", "The paper's method", "Feed-forward"
    for axes, trace, shown, name in zip(rows, traces, (WITHOUT, PAPER, FEEDFORWARD), names):
        axes.axhline(0.0, color=GUIDE, linewidth=0.8)
        axes.plot(trace["t_s"], trace.error_mn(), color=shown)
        axes.set_ylabel("r − F (mN)")
        axes.set_title(f"{name}: {rms(trace.error_mn()):.2f} mN RMS")
    label_time(rows[-1], traces[-1])


def force_figure(*traces):
    figure, (whole, up, down) = plt.subplots(1, 3, figsize=(12, 4.2), width_ratios=(2, 1, 1))
    title(figure, "Force, triangle benchmark")
    draw_force(whole, *traces)
    whole.set_title("Two periods")
    for axes, time_s, way in ((up, TURNS_UP_S, "up"), (down, TURNS_DOWN_S, "down")):
        draw_force(axes, *(trace.around(time_s, 1.5) for trace in traces))
        axes.set_title(f"Where it turns {way}")
    legend(figure, whole)
    return figure


def error_figure(*traces):
    figure, rows = plt.subplots(3, 1, figsize=(10, 6.6), sharex=True, sharey=True)
    title(figure, "Error, triangle benchmark")
    draw_errors(rows, *traces)
    return figure


def hysteresis_figure(replay, with_):
    figure, (law, rest) = plt.subplots(1, 2, figsize=(12, 5))
    title(figure, "Friction against net force")
    for part, shown, name in zip(by_direction(replay, replay["f_hat_N"]), (RISES, FALLS), ("rises", "falls")):
        law.plot(replay["n_N"], part, color=shown, label=f"net force {name}", linewidth=1.8)
    breakaway = replay["L_N"][0]
    for level in (-breakaway, breakaway):
        law.axhline(level, color=GUIDE, linestyle=":", linewidth=1.2)
    law.text(-breakaway, breakaway - 0.004, "breakaway L", color=GUIDE, va="top")
    law.set_title("The law drawn with k = 1.1, at F = 0.5 N")
    law.set_ylabel("friction f (N)")
    for time_s, shown in ((TURNS_UP_S, RISES), (TURNS_DOWN_S, FALLS)):
        turn = with_.between(time_s + 0.01, time_s + 0.5)
        rest.plot(turn["n_N"], [1e3 * (n - f) for n, f in zip(turn["n_N"], turn["f_hat_N"])], color=shown, linewidth=1.8)
    rest.set_title("Two reversals of the benchmark, k = 6 to 20: net force less friction")
    rest.set_ylabel("n − f (mN)")
    for axes in (law, rest):
        axes.set_xlabel("net force n (N)")
    legend(figure, law)
    return figure


def relay_figure(with_):
    figure, rows = plt.subplots(4, 2, figsize=(12, 6.5), sharex="col", sharey="row", height_ratios=(4, 1, 1, 1))
    title(figure, "Relay signals of the compensator, triangle benchmark")
    turns = (
        ("up", TURNS_UP_S, -0.75, "Q2 sets above −0.75", 0.8, "Q2 resets when n falls from beyond 0.8"),
        ("down", TURNS_DOWN_S, 0.75, "Q1 sets below 0.75", -0.8, "Q1 resets when n rises from beyond −0.8"),
    )
    for column, (way, time_s, set_level, set_text, reset_level, reset_text) in enumerate(turns):
        trace = with_.around(time_s, 1.0)
        times = trace["t_s"]
        net = rows[0][column]
        for level in (set_level, reset_level):
            net.axhline(level, color=GUIDE, linestyle=":", linewidth=1.2)
        net.plot(times, [n / L for n, L in zip(trace["n_N"], trace["L_N"])], color=colour("n_N"))
        # Each text stands over its line, on the side that the curve leaves free.
        net.text(times[-1], set_level + 0.05, set_text, color=GUIDE, ha="right", va="bottom")
        net.text(times[0] + 0.02, reset_level + 0.05, reset_text, color=GUIDE, va="bottom")
        net.set_ylim(-1.15, 1.15)
        net.set_title(f"Where the reference turns {way}")
        for axes, name in zip((row[column] for row in rows[1:]), ("Q1", "Q2", "Q")):
            points = corners(times, trace[name])
            axes.fill_between(*points, step="post", color=colour(name), alpha=0.25, linewidth=0)
            axes.step(*points, where="post", color=colour(name))
            axes.set_ylim(-0.15, 1.25)
            axes.set_yticks((0, 1))
            axes.grid(axis="y", visible=False)
            if column == 0:
                axes.set_ylabel(name, rotation=0, ha="right", va="center", color=colour(name), fontweight="bold")
        label_time(rows[-1][column], trace)
    rows[0][0].set_ylabel("net force n / breakaway L")
    return figure


def stuck_until(trace, time_s):
    """When F has moved by 1 mN from where it stood as the reference turned."""
    turn = trace.between(time_s, time_s + 0.5 * PERIOD_S)
    return next(t for t, force in zip(turn["t_s"], turn["F_N"]) if abs(force - turn["F_N"][0]) > 1e-3)


def mark_stuck(axes, trace, time_s):
    """The time that F stands still behind a reversal, over its line."""
    end_s = stuck_until(trace, time_s)
    level = trace.between(time_s, end_s)["F_N"][0] + 1.2e-3
    axes.annotate("", (end_s, level), (time_s, level), arrowprops={"arrowstyle": "<->", "color": WITHOUT, "shrinkA": 0, "shrinkB": 0})
    axes.text(0.5 * (time_s + end_s), level + 4e-4, f"stuck for {end_s - time_s:.1f} s", color=WITHOUT, ha="center", va="bottom", fontweight="bold")
    axes.set_ylim(top=level + 4e-3)


def hero_figure(*traces):
    figure = plt.figure(figsize=(12, 5.6))
    title(figure, "Friction taken out of reversals")
    grid = figure.add_gridspec(3, 2, width_ratios=(1, 1.25))
    force = figure.add_subplot(grid[:, 0])
    draw_force(force, *(trace.around(TURNS_DOWN_S, 1.8) for trace in traces))
    force.set_title("The force where its reference turns")
    mark_stuck(force, traces[0], TURNS_DOWN_S)
    rows = [figure.add_subplot(grid[0, 1])]
    rows += [figure.add_subplot(grid[row, 1], sharex=rows[0], sharey=rows[0]) for row in (1, 2)]
    draw_errors(rows, *traces)
    times_less = rms(traces[0].error_mn()) / rms(traces[2].error_mn())
    rows[2].text(0.99, 0.9, f"{times_less:.0f} times less", color=FEEDFORWARD, ha="right", va="top", fontweight="bold", transform=rows[2].transAxes)
    for axes in rows[:-1]:
        axes.tick_params(labelbottom=False)
    legend(figure, force)
    return figure


def joint_figure(trace):
    """A joint that follows a sine, behind a position loop with and without friction taken out."""
    figure = plt.figure(figsize=(12, 4.6))
    title(figure, "A joint with current and encoder, without a force sensor")
    grid = figure.add_gridspec(2, 2, width_ratios=(1, 1.25))
    motion = figure.add_subplot(grid[:, 0])
    rows = [figure.add_subplot(grid[0, 1])]
    rows.append(figure.add_subplot(grid[1, 1], sharex=rows[0], sharey=rows[0]))
    turn = trace.around(TURNS_JOINT_S, 1.0)
    names = ("q_without_rad", "without compensation", WITHOUT), ("q_with_rad", "friction taken out", FEEDFORWARD)
    errors = []
    for (column, name, shown), axes in zip(names, rows):
        motion.plot(turn["t_s"], [1e3 * q for q in turn[column]], color=shown, label=name)
        error = [1e3 * (wanted - q) for wanted, q in zip(trace["q_ref_rad"], trace[column])]
        axes.axhline(0.0, color=GUIDE, linewidth=0.8)
        axes.plot(trace["t_s"], error, color=shown)
        axes.set_ylabel("q_ref − q (mrad)")
        axes.set_title(f"{name[0].upper()}{name[1:]}: {rms(error):.1f} mrad RMS")
        errors.append(rms(error))
    rows[1].text(0.99, 0.9, f"{errors[0] / errors[1]:.0f} times less", color=FEEDFORWARD, ha="right", va="top", fontweight="bold", transform=rows[1].transAxes)
    motion.plot(turn["t_s"], [1e3 * q for q in turn["q_ref_rad"]], color=colour("r_N"), linestyle=(0, (4, 2)), linewidth=1.1, label="reference")
    motion.set_title("The position where its reference turns")
    motion.set_ylabel("position (mrad)")
    label_time(motion, turn)
    label_time(rows[1], trace)
    rows[0].tick_params(labelbottom=False)
    legend(figure, motion)
    return figure


def print_table(folders):
    """The benchmark's figure beside the paper's."""
    measured = [json.loads((folder / "summary.json").read_text(encoding="utf-8"))["rms_error_N"] for folder in folders]
    rows = [
        ("without compensation", *(1e3 * values[0] for values in (PAPER_RMS_N, measured)), " mN"),
        ("the paper's method (gain 0.85)", *(1e3 * values[1] for values in (PAPER_RMS_N, measured)), " mN"),
        ("without / the paper's", *(values[0] / values[1] for values in (PAPER_RMS_N, measured)), "   "),
    ]
    print(f"{'RMS of r - F, triangle':<32}{'paper':>10}{'this run':>12}{'ratio':>8}")
    for name, paper, run, unit in rows:
        print(f"{name:<32}{paper:7.2f}{unit}{run:9.3f}{unit}{run / paper:8.2f}")
    print(f"{'feed-forward':<32}{'':10}{1e3 * measured[2]:9.3f} mN")
    print(f"{'without / feed-forward':<32}{'':10}{measured[0] / measured[2]:9.3f}")


def main():
    if len(sys.argv) != 7:
        sys.exit(__doc__)
    folders = [pathlib.Path(folder) for folder in sys.argv[1:4]]
    print_table(folders)
    traces = tuple(
        Trace.read(folder / "trace.csv").between(SETTLED_S, SETTLED_S + 2 * PERIOD_S) for folder in folders
    )
    replay = Trace.read(sys.argv[4]).between(4.0, 8.0)
    joint = Trace.read(sys.argv[5])
    out = pathlib.Path(sys.argv[6])
    out.mkdir(parents=True, exist_ok=True)
    figures = {
        "hero": hero_figure(*traces),
        "force": force_figure(*traces),
        "error": error_figure(*traces),
        "hysteresis": hysteresis_figure(replay, traces[1]),
        "relays": relay_figure(traces[1]),
        "joint": joint_figure(joint),
    }
    for name, figure in figures.items():
        figure.savefig(out / f"{name}.png", metadata={"Software": None})
        figure.savefig(out / f"{name}.svg", metadata={"Date": None, "Creator": None})


if __name__ == "__main__":
    main()
