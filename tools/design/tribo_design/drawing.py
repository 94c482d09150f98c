"""Figures with axes, and their PNG bytes."""

import io

from matplotlib.figure import Figure
from tribo_plot import look


def png(figure):
    for axis in (a for axes in figure.axes for a in (axes.xaxis, axes.yaxis)):
        low, high = axis.get_view_interval()
        if axis.get_scale() == "log" and high > 100 * low:
            axis.minorticks_off()  # half of the time to draw
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=100, metadata={"Software": None})
    return buffer.getvalue()


def figure_of(rows, columns, size):
    figure = Figure(figsize=size)
    figure.subplots_adjust(left=0.9 / size[0], right=1 - 0.2 / size[0], bottom=0.6 / size[1], top=1 - 0.4 / size[1], wspace=0.25, hspace=0.3)
    axes = figure.subplots(rows, columns, squeeze=False)
    for axis in axes.flat:
        axis.grid(True, which="major", color=look.GRID, lw=0.6)
        axis.set_axisbelow(True)
    return figure, axes
