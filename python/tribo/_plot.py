"""Pictures of recordings: reference and response, the error, the command. matplotlib is imported when the first picture is drawn."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = npt.NDArray[Any]

_SMALL_N = 0.1  # smaller errors are shown in mN
_MAX = 1e30  # what a picture can show, as of a CSV file
_START = 0.02  # fraction of a picture that may leave the axis: the start would flatten the rest


@dataclass(frozen=True)
class _Chart:
    title: str
    unit: str
    values: Array
    colour: str
    asked: Array | None = None  # the reference, drawn once as a broken line


def _force_charts(columns: Mapping[str, Array]) -> list[_Chart]:
    force = "F_N" if "F_N" in columns else "y_N"
    r_N = columns["r_N"]
    return [
        _Chart("Force", "N", columns[force], force, r_N),
        _Chart(f"Error r − {force[0]}", "N", r_N - columns[force], "error"),
        _Chart("Command u", "N", columns["u_N"], "u_N"),
    ]


def _joint_charts(columns: Mapping[str, Array]) -> list[_Chart]:
    q_ref, q = columns["q_ref"], columns["q"]
    return [_Chart("Position q", "", q, "F_N", q_ref), _Chart("Error q_ref − q", "", q_ref - q, "error"), _Chart("Effort u", "", columns["u"], "u_N")]


_KINDS = ((("t_s", "r_N", "F_N", "u_N"), _force_charts), (("t_s", "r_N", "y_N", "u_N"), _force_charts), (("t_s", "q_ref", "q", "u"), _joint_charts))


def _charts(columns: Mapping[str, Array]) -> list[_Chart]:
    kind = next(((wanted, make) for wanted, make in _KINDS if all(name in columns for name in wanted)), None)
    if kind is None:
        raise ValueError(f"a picture needs t_s, r_N, F_N or y_N, and u_N; or t_s, q_ref, q and u. It has {', '.join(columns) or 'none'}")
    arrays = {name: np.asarray(columns[name], np.float64) for name in kind[0]}
    count = arrays["t_s"].size
    for name, values in arrays.items():
        if values.shape != (count,) or count == 0:
            raise ValueError(f"{name}: {values.shape} values; a picture needs as many as t_s has, {count}, and at least one")
        if np.any(np.abs(values) > _MAX) or (name == "t_s" and np.any(np.isnan(values))):
            raise ValueError(f"{name}: {values[np.argmax(~(np.abs(values) <= _MAX))]:g} is outside -{_MAX:g} to {_MAX:g}")
    return kind[1](arrays)


def _late(values: Array) -> Array:
    return values[int(_START * len(values)) :]


def _small(runs: Sequence[list[_Chart]]) -> list[list[_Chart]]:
    """Scales errors to mN if they are small after the start."""
    largest = max((float(np.nanmax(np.abs(_late(charts[1].values)), initial=0.0)) for charts in runs), default=0.0)
    if runs[0][1].unit != "N" or largest >= _SMALL_N:
        return list(runs)
    return [[charts[0], replace(charts[1], unit="mN", values=1e3 * charts[1].values), charts[2]] for charts in runs]


def _label(name: str, run: Mapping[str, Array], charts: Sequence[_Chart]) -> str:
    """The run's name with its RMS error: that of the summary, or of the values drawn after the start."""
    error = charts[1]
    summary = getattr(run, "summary", None)
    rms = float(np.sqrt(np.nanmean(_late(error.values) ** 2)))
    if summary is not None:
        rms = summary.rms_error_N * (1e3 if error.unit == "mN" else 1.0)
    return f"{name}: RMS error {rms:.3g} {error.unit}".rstrip()


def _names(given: Sequence[str], count: int) -> list[str]:
    if given and len(given) != count:
        raise ValueError(f"names: {len(given)} names for {count} runs")
    return list(given) or (["run"] if count == 1 else ["this run"] + [f"run {number}" for number in range(2, count + 1)])


def _limits(lines: Sequence[Array]) -> tuple[float, float] | None:
    """Limits of the axis by the values after the start, if the start would flatten them."""
    rest, whole = (np.concatenate([part(values) for values in lines]) for part in (_late, np.asarray))
    low, high = float(np.nanmin(rest)), float(np.nanmax(rest))
    if not high > low or np.nanmax(whole) - np.nanmin(whole) <= 2.5 * (high - low):
        return None
    return low - 0.1 * (high - low), high + 0.1 * (high - low)


def recorded(sample_time_s: float, **inputs: npt.ArrayLike) -> dict[str, Array]:
    """The inputs of a part as arrays of one length, and their time."""
    arrays = np.broadcast_arrays(*(np.atleast_1d(np.asarray(x, np.float64)) for x in inputs.values()))
    return {"t_s": sample_time_s * np.arange(len(arrays[0])), **dict(zip(inputs, arrays))}


def plot(runs: Sequence[Mapping[str, Array]], names: Sequence[str], path: str | os.PathLike[str] | None) -> Figure:
    """The first run is the strong line, on top of the others."""
    made = _small([_charts(run) for run in runs])
    labels = [_label(*each) for each in zip(_names(names, len(runs)), runs, made)]
    if len({charts[0].title for charts in made}) > 1:
        raise ValueError("one picture cannot show both a force and a position")
    try:
        from matplotlib import pyplot
        from tribo_plot import look, output  # type: ignore[import-untyped]
    except ImportError as error:
        raise ImportError(f"plot() needs matplotlib: pip install matplotlib ({error})") from error
    with pyplot.rc_context({**look.STYLE, "font.size": 9}):
        figure, rows = pyplot.subplots(3, 1, sharex=True, figsize=(10, 6.4))
        for row, (axes, charts) in enumerate(zip(rows, zip(*made))):
            for order, (run, chart, label) in reversed(list(enumerate(zip(runs, charts, labels)))):
                colour = look.colour(chart.colour) if order == 0 else look.shade(look.GUIDE, 1 if order == 1 else 3)
                axes.plot(run["t_s"], chart.values, color=colour, linewidth=1.5 if order == 0 else 1.0, label=label if row == 0 else None, zorder=3 - 0.1 * order)
            if charts[0].asked is not None:
                axes.plot(runs[0]["t_s"], charts[0].asked, color=look.colour("r_N"), linewidth=0.9, linestyle=(0, (4, 2)), label="reference", zorder=4)
            axes.set_title(charts[0].title)
            axes.set_ylabel(charts[0].unit)
            axes.set_ylim(_limits([chart.values for chart in charts]))
            axes.margins(x=0)
        rows[-1].set_xlabel("time (s)")
        rows[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(runs) + 1, borderaxespad=0.1, fontsize=8)
        if path is not None:
            with output.replaced(path) as new:
                figure.savefig(new, dpi=130, format=new.suffix[1:] or "png")
    return figure


class Record(dict[str, Array]):
    """Arrays of one length by their names, one value per tick, also as attributes (`record.u_N`). A picture needs time, reference, response and command:
    t_s, r_N, F_N or y_N, and u_N; or t_s, q_ref, q and u.

    >>> import numpy as np
    >>> t_s = np.arange(100) * 1e-3
    >>> mine = Record(t_s=t_s, q_ref=np.sin(t_s), q=0.9 * np.sin(t_s), u=np.cos(t_s))
    >>> len(mine.plot().axes)
    3
    """

    def __getattr__(self, name: str) -> Array:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"a {type(self).__name__.lower()} has no {name}; its columns are {', '.join(self)}") from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self]

    def plot(self, *others: Mapping[str, Array], names: Sequence[str] = (), path: str | os.PathLike[str] | None = None) -> Figure:
        """Draws force or position with its reference, the error, and the command, over time; this run is the strong line, the `others` lie beneath it. `names` names all
        of them, this one first. `path` is the file to write, .png or .svg. Returns matplotlib's figure. Raises ImportError without matplotlib, and
        ValueError if columns are missing or the number of `names` is wrong."""
        return plot([self, *others], names, path)
