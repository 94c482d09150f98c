"""The report: one HTML file that marks every event in the plot it came from."""

import base64
import html as markup
import io

import matplotlib

matplotlib.use("Agg")

import numpy as np
from matplotlib.figure import Figure
from tribo_design.drawing import look

STRIP_S = 40.0
STRIPS_MAX = 24
POINTS = 4000  # at most, per line


def picture(figure):
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=85, metadata={"Software": None})
    return f'<img src="data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}">'


def figure_of(rows, columns, size):
    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False)
    for axis in axes.flat:
        axis.grid(True, color=look.GRID, lw=0.6)
    return figure, axes


def page(title, lines, pictures):
    table = "\n".join(markup.escape(line) for line in lines)
    body = "\n".join(f"<h2>{markup.escape(t)}</h2>\n{p}" for t, p in pictures)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>{markup.escape(title)}</title>
<style>body{{font-family:sans-serif;max-width:1150px;margin:2em auto;padding:0 1em}}pre{{background:#f4f4f4;padding:1em;white-space:pre-wrap;overflow-wrap:anywhere}}img{{max-width:100%}}</style></head>
<body><h1>{markup.escape(title)}</h1><pre>{table}</pre>
{body}
</body></html>
"""


def thin(*columns):
    every = max(len(columns[0]) // POINTS, 1)
    return [c[::every] for c in columns]


def law_picture(result):
    figure, axes = figure_of(1, 2, (12, 4.5))
    force = np.linspace(max(result.loads[0][0], 0), result.loads[-1][1], 100)
    p = result.params
    for way, name in ((1, "positive"), (-1, "negative")):
        if result.table:
            at, plus, minus = np.array(result.table).T
            L = np.interp(force, at, plus if way > 0 else minus)
        else:
            L = p[f"offset_{name}"] + p[f"slope_{name}"] * force
        axes[0, 0].plot(force, way * L, color=look.WAYS[way], label=f"L{'+' if way > 0 else '-'}")
        mine = [e for e in result.events if e.way == way]
        at = np.array([(e.low + e.high) / 2 for e in mine])
        own = np.array([e.error for e in mine]) + np.interp(at, force, L)
        out = np.array([e.weight == 0 for e in mine], bool)
        axes[0, 0].plot(at[~out], way * own[~out], "o", ms=4, color=look.WAYS[way])
        axes[0, 0].plot(at[out], way * own[out], "x", ms=6, color=look.GUIDE)
    axes[0, 0].set(xlabel="F [N]", ylabel="breakaway [N]", title="each half-cycle's own L, and the law (x: left out)")
    axes[0, 0].legend()
    axes[0, 1].bar(range(len(result.events)), [e.error for e in result.events], color=[look.WAYS[e.way] for e in result.events])
    axes[0, 1].set(xlabel="event", ylabel="own L less the law [N]", title="differences")
    return picture(figure)


def _strip(s, model, events, begin, end):
    rows = slice(int(np.searchsorted(s.t, begin)), int(np.searchsorted(s.t, end)))
    figure, axes = figure_of(2, 1, (12, 4.6))
    t, u, force, y = thin(s.t[rows], s.u[rows], s.force[rows], model[rows])
    axes[0, 0].plot(t, force, color=look.MEASURED, lw=1.8, label="F")
    axes[0, 0].plot(t, y, color=look.MODEL, lw=0.9, ls="--", label="model")
    axes[1, 0].plot(t, u - force, color=look.colour("n_N"), lw=0.8, label="u - F")
    for number, e in events:
        if begin <= s.t[e.start] < end:
            for axis, at in ((axes[0, 0], e.force), (axes[1, 0], e.net)):
                axis.plot([s.t[e.start]], [at], "^" if e.way > 0 else "v", color=look.WAYS[e.way], ms=7)
            axes[0, 0].annotate(str(number), (s.t[e.start], e.force), textcoords="offset points", xytext=(4, 4), fontsize=8)
    axes[0, 0].margins(y=0.15)  # room for the numbers
    axes[0, 0].set(ylabel="F [N]")
    axes[1, 0].set(ylabel="u - F [N]", xlabel="time [s]")
    for axis in axes[:, 0]:
        axis.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1, frameon=False, fontsize=8)  # where no event is marked
    return picture(figure)


def html(log, result, lines):
    pictures = [("Breakaway over load", law_picture(result))]
    total = sum(s.t[-1] - s.t[0] for s in log.segments)
    strip = max(STRIP_S, total / (STRIPS_MAX - len(log.segments)) if len(log.segments) < STRIPS_MAX / 2 else total)
    for index, s in enumerate(log.segments):
        events = [(n, e) for n, e in enumerate(result.events) if e.segment == index]
        for begin in np.arange(s.t[0], s.t[-1], strip):
            pictures.append((f"{s.file}, {begin:.4g} to {min(begin + strip, s.t[-1]):.4g} s", _strip(s, result.model[index], events, begin, begin + strip)))
    return page("Friction", lines, pictures)


def strokes_html(log, law, lines):
    figure, axes = figure_of(1, 1, (8, 4.5))
    load = np.array([v.load for v in law.levels])
    for v in law.levels:
        axes[0, 0].plot(np.full(len(v.repeats), v.load), v.repeats, ".", color=look.MEASURED)
    axes[0, 0].plot(load, [v.friction for v in law.levels], "o", color=look.MODEL, label="mean of the repeats")
    if law.is_table:
        axes[0, 0].plot(load, [v.friction for v in law.levels], color=look.colour("L_N"), label="table")
    else:
        axes[0, 0].plot(load, law.offset + law.slope * load, color=look.colour("L_N"), label="line")
    axes[0, 0].set(xlabel="load [N]", ylabel="friction [N]")
    axes[0, 0].legend()
    pictures = [("Friction over load", picture(figure))]
    for v in law.levels:
        figure, axes = figure_of(2, 1, (12, 4.6))
        for number, s in enumerate([s for s in log.segments if s.file == v.file]):
            axes[0, 0].plot(*thin(s.t, s.u), color=look.colour("u_N"), lw=0.8)
            axes[1, 0].plot(*thin(s.t, s.position), color=look.colour("x_deg"), lw=0.8)
            for n, first, last, way, mean in v.strokes:
                if n == number:
                    axes[0, 0].plot(s.t[[first, last - 1]], [mean, mean], color=look.WAYS[way], lw=2)
        axes[0, 0].set(ylabel="u [N]")
        axes[1, 0].set(ylabel="position", xlabel="time [s]")
        pictures.append((v.file + v.when, picture(figure)))
    return page("Friction of strokes", lines, pictures)


TITLES = {"off": "without compensation", "on": "the new parameters", "less": "L 20 % less", "more": "L 20 % more", "old": "the old parameters"}


def accept_html(segments, lines):
    figure, axes = figure_of(len(segments), 2, (12, 2.75 * len(segments)))
    for row, (case, s) in enumerate(segments.items()):
        axes[row, 0].plot(*thin(s.t - s.t[0], s.reference), color=look.colour("r_N"), lw=1, ls=":")
        axes[row, 0].plot(*thin(s.t - s.t[0], s.force), color=look.colour("F_N"), lw=1)
        axes[row, 0].set(ylabel="r, F [N]", title=TITLES[case])
        axes[row, 1].plot(*thin(s.t - s.t[0], s.reference - s.force), color=look.colour("error"), lw=0.8)
        axes[row, 1].set(ylabel="r - F [N]")
    return page("Acceptance", lines, [("The sequence", picture(figure))])
