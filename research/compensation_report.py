"""Draws the picture for research/bench-compensation."""

from demo_report import legend, plt, title
from tribo_plot.look import FEEDFORWARD, GUIDE, PAPER


def ratios(triangles, cases, out):
    """Draws the ratios of the error without compensation to that with it. `triangles`: {(breakaway, noise): {method: [ratio]}}; `cases`: {method: [ratio]}."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.6), width_ratios=(1.3, 1))
    title(figure, "RMS error without compensation divided by that with it")
    colours = {"paper": PAPER, "feedforward": FEEDFORWARD}
    names = {"paper": "the paper's method", "feedforward": "feed-forward"}
    for place, (key, methods) in enumerate(triangles.items()):
        for side, (method, values) in zip((-0.17, 0.17), methods.items()):
            spots = [place + side + 0.1 * (i / len(values) - 0.5) for i in range(len(values))]
            left.plot(spots, values, ".", color=colours[method], markersize=3.5, label=names[method] if place == 0 else None)
    left.set_xticks(range(len(triangles)), [f"×{breakaway:g}\n{1e3 * noise:g} mN" for breakaway, noise in triangles])
    left.set_title("32 triangles, by breakaway of the plant and noise")
    left.set_xlabel("the plant's breakaway divided by the configured one; sensor noise")
    left.set_ylabel("ratio of the errors")
    for method, values in cases.items():
        right.plot(sorted(values), [100.0 * (i + 0.5) / len(values) for i in range(len(values))], color=colours[method])
    right.set_xlabel("ratio of the errors")
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
