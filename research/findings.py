"""Makes the tables and figures of research/findings.md.

    findings.py DIR [--update]

Runs each study of host_sim/studies except the wide one in a folder of DIR. Prints all tables, and writes them with their figures to
DIR/report.md. --update also writes the tables that research/findings.md has a mark for into it, and its figure next to it.
"""

import pathlib
import re
import shutil
import sys

from matplotlib.colors import LogNorm

import tribo
from tribo_plot.look import FEEDFORWARD, GUIDE, PAPER, shade
from tribo_plot.sweeps import Sweep, is_logarithmic, np, plt

COMPENSATIONS = ("paper, 0.5", shade(PAPER, 1)), ("paper, 0.7", PAPER), ("paper, 0.85", shade(PAPER, 2)), ("feedforward", FEEDFORWARD)
ROOT = pathlib.Path(__file__).resolve().parents[1]


def markdown(rows):
    lines = ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join([lines[0], "|" + "---|" * len(rows[0]), *lines[1:]])


def one(sweep, measure, **values):
    """Returns a measure of the one row whose axes have these values."""
    inside = np.full(len(sweep.value[measure]), True)
    for axis, value in values.items():
        inside &= np.array([text == value for text in sweep.text[axis.replace("__", ".")]])
    found = sweep.value[measure][inside]
    assert len(found) == 1, values
    return found[0]


def listed(sweep, axis):
    return list(dict.fromkeys(sweep.text[axis]))


def mn(value):
    return f"{1e3 * value:.2f}"


def ratio(value):
    """Formats a ratio, in bold if compensation makes the error larger."""
    return f"{value:.2f}" if value >= 1 else f"**{value:.2f}**"


def percent(value):
    return f"{value:.0f}" if value >= 0.5 or value == 0 else "<1"


def triangles(sweep):
    rows = [["range, slope", "without (mN)", "paper (mN)", "ratio", "chatter, % of ticks", "feed-forward (mN)", "ratio"]]
    for wave in listed(sweep, "waveform"):
        paper, forward = ({"compensation": kind, "waveform": wave} for kind in ("paper", "feedforward"))
        rows.append([wave, mn(one(sweep, "without_rms_error_N", **paper)), mn(one(sweep, "rms_error_N", **paper)),
                     ratio(one(sweep, "ratio", **paper)), percent(one(sweep, "chatter", **paper)),
                     mn(one(sweep, "rms_error_N", **forward)), ratio(one(sweep, "ratio", **forward))])
    return markdown(rows)


def truths(sweep):
    gains = ["paper, 0.7", "paper, 0.85", "paper, 1", "feedforward"]
    rows = [["truth", *(f"ratio: {gain}" for gain in gains)]]
    for model in listed(sweep, "plant.model"):
        at = {"plant__model": model, "slope": "20 mN/s"}
        rows.append([f"`{model}`", *(ratio(one(sweep, "ratio", **at, compensation=gain)) for gain in gains)])
    return markdown(rows)


def one_at_a_time(sweep):
    kinds = listed(sweep, "compensation")
    rows = [["what differs", "without (mN)", *(f"ratio: {kind}" for kind in kinds)]]
    for what in listed(sweep, "what"):
        rows.append([what, mn(one(sweep, "without_rms_error_N", what=what, compensation=kinds[0])),
                     *(ratio(one(sweep, "ratio", what=what, compensation=kind)) for kind in kinds)])
    return markdown(rows)


def gain_breakaway(sweep):
    """For each gain, finds the least breakaway factor from which on compensation never increases the error."""
    factors = sorted(listed(sweep, "breakaway"), key=float)
    rows = [["gain", "quiet sensor", "noise of 1 mN", "smallest ratio from there on"]]
    for kind in listed(sweep, "compensation"):
        line, least = [kind], []
        for sensor in listed(sweep, "sensor"):
            values = [one(sweep, "ratio", sensor=sensor, breakaway=factor, compensation=kind) for factor in factors]
            safe = next((i for i in range(len(values)) if min(values[i:]) >= 1), None)
            line.append("never" if safe is None else f"{factors[safe]} L")
            least += values[safe:] if safe is not None else []
        rows.append([*line, f"{min(least):.2f}" if least else "-"])
    return markdown(rows)


def gain_figure(sweep):
    factors = sorted(listed(sweep, "breakaway"), key=float)
    kinds = listed(sweep, "compensation")
    figure, panels = plt.subplots(1, 2, figsize=(13, 6.2), sharey=True)
    for panel, sensor in zip(panels, listed(sweep, "sensor")):
        grid = np.array([[one(sweep, "ratio", sensor=sensor, breakaway=factor, compensation=kind) for kind in kinds]
                         for factor in factors])
        panel.imshow(grid, origin="lower", aspect="auto", cmap="RdYlBu", norm=LogNorm(1 / 30, 30))
        for (i, j), value in np.ndenumerate(grid):
            panel.text(j, i, f"{value:.2g}" if value < 9.95 else f"{value:.0f}", ha="center", va="center", fontsize=7,
                       color="white" if value < 0.1 or value > 12 else "black")
        panel.set_xticks(range(len(kinds)), [kind.removeprefix("paper, ") for kind in kinds], rotation=90)
        panel.set_yticks(range(len(factors)), factors)
        panel.grid(False)
        panel.set_xlabel("gain of the paper's method, or feed-forward")
        panel.set_title(f"sensor: {sensor}")
    panels[0].set_ylabel("breakaway of the plant divided by the configured")
    figure.suptitle("RMS error without / with compensation; below 1 compensation hurts", x=0.01, ha="left", fontsize=12, fontweight="bold")
    return figure


def asymmetry(sweep):
    values = sorted(listed(sweep, "positive"), key=float)
    tables = []
    for kind in ("paper, 0.7", "paper, 0.85", "feedforward"):
        rows = [[f"{kind}: L+ down, L− across", *values]]
        for positive in values:
            rows.append([positive, *(ratio(one(sweep, "ratio", positive=positive, negative=negative, compensation=kind))
                                     for negative in values)])
        tables.append(markdown(rows))
    return "\n\n".join(tables)


def quantile_row(sweep, inside):
    values = sweep.value["ratio"][inside]
    rms = sweep.value["rms_error_N"][inside]
    return [mn(np.median(rms)), mn(np.quantile(rms, 0.95)), *(ratio(np.quantile(values, p)) for p in (0.0, 0.05, 0.5, 0.95)), f"{100 * np.mean(values < 1):.1f} %"]


QUANTILES = ["50 % (mN)", "95 % (mN)", "ratio, worst", "5 %", "50 %", "95 %", "worse than without"]


def uncertainty(sweep):
    kinds = listed(sweep, "compensation")
    rows = [["compensation", *QUANTILES]]
    for kind in kinds:
        inside = np.array([text == kind for text in sweep.text["compensation"]])
        rows.append([kind, *quantile_row(sweep, inside)])
    return markdown(rows)


def uncertainty_by_breakaway(sweep):
    breakaway = np.array([float(text) for text in sweep.text["breakaway"]])
    parts = [["breakaway divided by the configured; compensation", *QUANTILES]]
    for low, high in ((0.5, 0.75), (0.75, 0.9), (0.9, 1.1), (1.1, 1.5)):
        for kind in ("paper, 0.5", "paper, 0.7", "paper, 0.85", "paper, 1", "feedforward"):
            inside = np.array([text == kind for text in sweep.text["compensation"]]) & (breakaway >= low) & (breakaway < high)
            parts.append([f"{low:g} to {high:g}; {kind}", *quantile_row(sweep, inside)])
    return markdown(parts)


def uncertainty_figure(sweep):
    shown = [axis for axis in sweep.axes if axis not in ("compensation", "sensor.noise_seed")]
    figure, panels = plt.subplots(4, 4, figsize=(15, 11), sharey=True)
    for panel, axis in zip(panels.flat, shown):
        numbers = np.array([float(text) for text in sweep.text[axis]])
        edges = np.quantile(numbers, np.linspace(0, 1, 8))
        for kind, colour in COMPENSATIONS:
            of_kind = np.array([text == kind for text in sweep.text["compensation"]])
            places, quantiles = [], []
            for low, high in zip(edges, edges[1:]):
                inside = of_kind & (numbers >= low) & (numbers <= high)
                places.append(np.median(numbers[inside]))
                quantiles.append(np.quantile(sweep.value["ratio"][inside], (0.05, 0.5)))
            low, middle = np.array(quantiles).T
            panel.plot(places, middle, color=colour, linewidth=1.6, label=kind)
            panel.plot(places, low, color=colour, linewidth=1.0, linestyle=":")
        panel.axhline(1.0, color=GUIDE, linewidth=1, linestyle="--")
        panel.set_yscale("log")
        panel.set_title(axis)
        if is_logarithmic(numbers):
            panel.set_xscale("log")
    for panel in list(panels.flat)[len(shown):]:
        panel.set_visible(False)
    for row in panels:
        row[0].set_ylabel("ratio")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper right", ncols=4)
    figure.suptitle("RMS error without / with compensation: median, and 5 % quantile dotted", x=0.01, ha="left", fontsize=12, fontweight="bold")
    return figure


def chatter(sweep):
    slopes = listed(sweep, "slope")
    rows = [["truth, gain, plant step", *slopes]]
    for model in listed(sweep, "plant.model"):
        for gain in ("0.5", "0.85"):
            for step, name in (("0.0001", "0.1 ms"), ("0.001", "1 ms")):
                rows.append([f"`{model}`, {gain}, {name}",
                             *(percent(one(sweep, "chatter", plant__model=model, slope=slope, plant__step_s=step,
                                           compensator__gain=gain)) for slope in slopes)])
    without = sweep.value["without_chatter_ticks"]
    return markdown(rows) + f"\n\nWithout compensation: {int(without.max())} ticks in the worst of all {len(without)} rows."


def main():
    if len(sys.argv) not in (2, 3) or sys.argv[2:] not in ([], ["--update"]):
        sys.exit(__doc__)
    folder = pathlib.Path(sys.argv[1])
    sweeps = {}
    for name in ("triangles", "truths", "gain_breakaway", "asymmetry", "one_at_a_time", "uncertainty", "chatter"):
        print(name, file=sys.stderr)
        frame = tribo.sweep(name, folder / name)
        tribo.sweep_report(frame, folder / name)
        sweeps[name] = Sweep(frame)
    makers = {"triangles": triangles, "truths": truths, "gain_breakaway": gain_breakaway, "asymmetry": asymmetry,
              "one_at_a_time": one_at_a_time, "uncertainty": uncertainty, "chatter": chatter}
    tables = {name: maker(sweeps[name]) for name, maker in makers.items()}
    tables["uncertainty_by_breakaway"] = uncertainty_by_breakaway(sweeps["uncertainty"])
    figures = {"gain.png": gain_figure(sweeps["gain_breakaway"]), "uncertainty.png": uncertainty_figure(sweeps["uncertainty"])}
    for name, figure in figures.items():
        figure.savefig(folder / name, metadata={"Software": None})
    pages = [f"## {name}\n\n{table}\n" for name, table in tables.items()] + [f"![{name}]({name})\n" for name in figures]
    print("\n".join(pages))
    (folder / "report.md").write_text("\n".join(["# Findings\n", *pages]), encoding="utf-8")
    if "--update" not in sys.argv:
        return
    place = ROOT / "research" / "findings.md"
    text, count = re.subn(r"(<!-- made by research/findings: (\w+) -->\n).*?(<!-- end -->)",
                          lambda found: f"{found[1]}\n{tables[found[2]]}\n\n{found[3]}", place.read_text(encoding="utf-8"), flags=re.S)
    if count == 0:
        sys.exit(f"{place}: has no mark for a table")
    place.write_text(text, encoding="utf-8")
    shutil.copy(folder / "gain.png", place.parent / "gain.png")


if __name__ == "__main__":
    main()
