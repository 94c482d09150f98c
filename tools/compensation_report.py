"""The picture of docs/compensation.md.

    compensation_report.py TRACE_CSV OUT_PNG

Reads what compensation_study_f32 --trace prints, a period of the triangle benchmark, and draws the error r - F without
compensation, with the paper's method and with the feed-forward:

    build/host-release/tests/closed_loop/compensation_study_f32 --trace >trace.csv
    /usr/bin/python3 tools/compensation_report.py trace.csv docs/compensation.png

The same data give the same file.
"""

import sys

from demo_report import GUIDE, THIRD, WITH, WITHOUT, MultipleLocator, Trace, label_time, legend, plt, rms, title

METHODS = (
    ("F_off_N", "without compensation", WITHOUT),
    ("F_paper_N", "the paper's method", WITH),
    ("F_feedforward_N", "feed-forward", THIRD),
)
TURN_S = 49.8, 51.6  # the reference turns down at 50 s


def draw(axes, trace, name, label, colour):
    errors = [1e3 * (r - force) for r, force in zip(trace["r_N"], trace[name])]
    axes.plot(trace["t_s"], errors, color=colour, label=label)
    return errors


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    trace = Trace.read(sys.argv[1])
    figure = plt.figure(figsize=(12, 5.4))
    title(figure, "Error over a period of the triangle")
    grid = figure.add_gridspec(3, 2, width_ratios=(1.25, 1))
    turn = figure.add_subplot(grid[:, 1])
    turn.yaxis.set_major_locator(MultipleLocator(10.0))
    turn.axhline(0.0, color=GUIDE, linewidth=0.8)
    whole = None
    for row, (name, label, colour) in enumerate(METHODS):
        whole = figure.add_subplot(grid[row, 0], sharex=whole, sharey=turn)
        whole.axhline(0.0, color=GUIDE, linewidth=0.8)
        errors = draw(whole, trace, name, label, colour)
        draw(turn, trace.between(*TURN_S), name, label, colour)
        whole.set_title(f"{label[0].upper()}{label[1:]}: {rms(errors):.2f} mN RMS")
        whole.set_ylabel("r − F (mN)")
        whole.tick_params(labelbottom=row == len(METHODS) - 1)
    turn.set_title("Where the reference turns down")
    label_time(whole, trace)
    label_time(turn, trace.between(*TURN_S))
    legend(figure, turn)
    figure.savefig(sys.argv[2], metadata={"Software": None})


if __name__ == "__main__":
    main()
