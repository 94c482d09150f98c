"""The pictures of docs/compensation.md.

    compensation_report.py OFF_DIR PAPER_DIR FEEDFORWARD_DIR OUT_PNG

Draws the error r - F over a period of the triangle benchmark, of the runs that tools/demo leaves in build/demo:

    /usr/bin/python3 tools/compensation_report.py build/demo/off build/demo/paper build/demo/feedforward docs/compensation.png

tools/bench-compensation calls `ratios`. The same data give the same file.
"""

import pathlib
import sys

from demo_report import MultipleLocator, Trace, label_time, legend, plt, rms, title
from tribo_plot.look import FEEDFORWARD, GUIDE, PAPER, WITHOUT

METHODS = (("without compensation", WITHOUT), ("the paper's method", PAPER), ("feed-forward", FEEDFORWARD))
PERIOD_S = 40.0, 60.0
TURN_S = 49.8, 51.6  # the reference turns down at 50 s


def benchmark(folders, out):
    traces = [Trace.read(folder / "trace.csv") for folder in folders]
    figure = plt.figure(figsize=(12, 5.4))
    title(figure, "Error over a period of the triangle")
    grid = figure.add_gridspec(3, 2, width_ratios=(1.25, 1))
    turn = figure.add_subplot(grid[:, 1])
    turn.yaxis.set_major_locator(MultipleLocator(10.0))
    turn.axhline(0.0, color=GUIDE, linewidth=0.8)
    whole = None
    for row, (trace, (label, colour)) in enumerate(zip(traces, METHODS)):
        whole = figure.add_subplot(grid[row, 0], sharex=whole, sharey=turn)
        whole.axhline(0.0, color=GUIDE, linewidth=0.8)
        for axes, part in ((whole, trace.between(*PERIOD_S)), (turn, trace.between(*TURN_S))):
            axes.plot(part["t_s"], part.error_mn(), color=colour, label=label)
        errors = trace.between(*PERIOD_S).error_mn()
        whole.set_title(f"{label[0].upper()}{label[1:]}: {rms(errors):.2f} mN RMS")
        whole.set_ylabel("r − F (mN)")
        whole.tick_params(labelbottom=row == len(METHODS) - 1)
    turn.set_title("Where the reference turns down")
    label_time(whole, traces[0].between(*PERIOD_S))
    label_time(turn, traces[0].between(*TURN_S))
    legend(figure, turn)
    figure.savefig(out, metadata={"Software": None})


def ratios(triangles, cases, out):
    """How many times the error is smaller. `triangles`: {(breakaway, noise): {method: [ratio]}}; `cases`: {method: [ratio]}."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.6), width_ratios=(1.3, 1))
    title(figure, "RMS error without compensation over that with it")
    colours = {"paper": PAPER, "feedforward": FEEDFORWARD}
    names = {"paper": "the paper's method", "feedforward": "feed-forward"}
    for place, (key, methods) in enumerate(triangles.items()):
        for side, (method, values) in zip((-0.17, 0.17), methods.items()):
            spots = [place + side + 0.1 * (i / len(values) - 0.5) for i in range(len(values))]
            left.plot(spots, values, ".", color=colours[method], markersize=3.5, label=names[method] if place == 0 else None)
    left.set_xticks(range(len(triangles)), [f"×{breakaway:g}\n{1e3 * noise:g} mN" for breakaway, noise in triangles])
    left.set_title("32 triangles, as the plant's breakaway and the noise")
    left.set_xlabel("the plant's breakaway over the believed one; noise of the sensor")
    left.set_ylabel("times that the error is smaller")
    for method, values in cases.items():
        right.plot(sorted(values), [100.0 * (i + 0.5) / len(values) for i in range(len(values))], color=colours[method])
    right.set_xlabel("times that the error is smaller")
    right.set_ylabel("cases below (%)")
    right.set_title(f"{len(values)} random plants and waveforms")
    left.set_yscale("log")
    right.set_xscale("log")
    left.axhline(1.0, color=GUIDE, linewidth=0.8)
    right.axvline(1.0, color=GUIDE, linewidth=0.8)
    for axis in (left.yaxis, right.xaxis):
        axis.set_major_formatter(lambda value, _: f"{value:g}")
    legend(figure, left)
    figure.savefig(out, metadata={"Software": None})


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    benchmark([pathlib.Path(folder) for folder in sys.argv[1:4]], sys.argv[4])


if __name__ == "__main__":
    main()
