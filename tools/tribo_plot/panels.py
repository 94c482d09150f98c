"""Panels of lines, made from the columns of the runs."""

import math
from dataclasses import dataclass, field

from .look import SIGNALS

SMALL_N = 0.1  # differences below it are shown in mN
START_S, START_PART, START_RATIO = 1.0, 0.02, 3.0  # see axis_range
NET_FORCE = "net force n (N)"
NET_FORCES = ("plant_n_N", "f_N"), ("n_N", "f_hat_N")
PRIOR_DEVIATION = 0.4  # of L, as a part of it, before anything is learned: s_V of docs/feedforward.md


@dataclass
class Line:
    name: str  # of the signal
    colour: str
    x: list
    y: list
    run: int = 0
    is_step: bool = False
    is_guide: bool = False
    is_points: bool = False
    low: list = None  # of an interval around y
    high: list = None


@dataclass
class Panel:
    title: str
    y_label: str
    x_label: str = "time (s)"
    over_time: bool = True
    lines: list = field(default_factory=list)
    y_range: tuple = None  # None: all of it
    is_log: tuple = (False, False)  # x, y
    x_names: list = None  # of 0, 1, ...
    note: str = ""


def make(runs, is_whole=True):
    """The panels of one picture, those over time first. A closed loop has only force, error, command and a drive's state, unless the whole is requested."""
    errors = _errors(runs)
    if errors.lines and not is_whole:
        panels = [_forces(runs), errors, _add(Panel("Command u", "N"), runs, "u_N"), _states(runs), _ticks(runs)]
        return _ranged(runs, panels)
    panels = [_forces(runs), errors, _residuals(runs), _commands(runs), _breakaway(runs), _relays(runs), _states(runs), _ticks(runs)]
    panels += [_of_column(runs, "x_deg", "Position", "degrees"), _of_column(runs, "w_deg_per_s", "Speed", "degrees/s")]
    panels += [_friction(runs), _hysteresis(runs), _over_force(runs)]
    return _ranged(runs, panels)


def _ranged(runs, panels):
    """The panels that have lines, with their ranges."""
    panels = [panel for panel in panels if panel.lines]
    for panel in panels:
        panel.y_range, panel.note = axis_range(runs, panel)
    return panels


def _line(runs, run, signal, x, y, **more):
    return Line(*SIGNALS[signal], _broken(runs[run], x), _broken(runs[run], y), run, **more)


def _broken(run, values):
    """Inserts a gap before each later segment; `values` end with the run."""
    if "segment" not in run:
        return values
    segments = run["segment"][len(run["segment"]) - len(values) :]
    starts = [i for i in range(1, len(segments)) if segments[i] != segments[i - 1]]
    if not starts:
        return values
    parts = []
    for first, end in zip([0, *starts], [*starts, len(segments)]):
        parts += [*values[first:end], math.nan]
    return parts[:-1]


def _add(panel, runs, *signals, **more):
    """Sorts the lines by run, so that one run's lines are together."""
    for i, run in enumerate(runs):
        for signal in signals:
            if signal in run:
                panel.lines.append(_line(runs, i, signal, run["t_s"], run[signal], **more))
    return panel


def _of_column(runs, signal, title, label):
    return _add(Panel(title, label), runs, signal)


def _forces(runs):
    panel = Panel("Force", "N")
    for i, run in enumerate(runs):
        # The model's force is of interest where there is no reference: in a replay.
        for signal in ("y_N" if "F_N" in run else None, "F_N" if "F_N" in run else "y_N", None if "r_N" in run else "F_hat_N", "r_N"):
            same = signal == "r_N" and any("r_N" in before and list(before["r_N"]) == list(run["r_N"]) for before in runs[:i])
            if signal in run and not same:
                line = _line(runs, i, signal, run["t_s"], run[signal])
                line.is_guide = signal == "r_N"
                panel.lines.append(line)
    return panel


def _error_of(run):
    force = "F_N" if "F_N" in run else "y_N"
    if "r_N" not in run or force not in run:
        return None
    return [r - f for r, f in zip(run["r_N"], run[force])]


def _in_small_unit(panel, runs, lines):
    """Lines of (run, signal, values) in mN if they are small after the start, otherwise in N."""
    late = [abs(y) for run, _, values in lines for y in values[len(values) // 10 :] if not math.isnan(y)]
    factor, panel.y_label = (1e3, "mN") if late and max(late) < SMALL_N else (1.0, "N")
    for run, signal, values in lines:
        panel.lines.append(_line(runs, run, signal, runs[run]["t_s"], [factor * y for y in values]))
    return panel


def _errors(runs):
    lines = [(i, "error", error) for i, error in enumerate(map(_error_of, runs)) if error]
    return _in_small_unit(Panel("Error r − F", ""), runs, lines)


def _residuals(runs):
    lines = [(i, "residual_N", run["residual_N"]) for i, run in enumerate(runs) if "residual_N" in run]
    return _in_small_unit(Panel("What is left: n − f", ""), runs, lines)


def _commands(runs):
    return _add(Panel("Command u and its parts", "N"), runs, "friction_term_N", "controller_N", "u_N")


def _breakaway(runs):
    panel = Panel("Breakaway L, learned", "N")
    for i, run in enumerate(runs):
        for way in ("positive", "negative"):
            L = f"breakaway_{way}_N"
            if L in run:
                line = _line(runs, i, L, run["t_s"], run[L])
                parts = [PRIOR_DEVIATION * math.sqrt(max(v, 0.0)) for v in run[f"relative_variance_{way}"]]
                line.low = [value * (1 - part) for value, part in zip(run[L], parts)]
                line.high = [value * (1 + part) for value, part in zip(run[L], parts)]
                panel.lines.append(line)
    for i, run in enumerate(runs):
        if "breakaway_positive_N" in run and "plant_L_N" in run:
            panel.lines.append(_line(runs, i, "plant_L_N", run["t_s"], [abs(L) for L in run["plant_L_N"]], is_guide=True))
    return panel


def _relays(runs):
    panel = Panel("Relays", "")
    for i, run in enumerate(runs):
        for place, signal in enumerate(("Q", "Q2", "Q1")):
            if signal in run and len(set(run[signal])) > 1:
                panel.lines.append(_line(runs, i, signal, run["t_s"], [1.4 * place + q for q in run[signal]], is_step=True))
    return panel


def _states(runs):
    panel = Panel("State and fault, by their numbers", "")
    for i, run in enumerate(runs):
        for signal in ("state", "fault"):
            if signal in run:
                panel.lines.append(_line(runs, i, signal, run["t_s"], run[signal], is_step=True))
    return panel


def _ticks(runs):
    return _add(Panel("Ticks", "µs"), runs, "late_us", "step_us")


def _rests(run):
    """The first row after the start; the start would flatten a panel over another signal than time."""
    t = run["t_s"]
    after = t[0] + min(START_S, START_PART * (t[-1] - t[0]))
    return next(i for i, time in enumerate(t) if time >= after)


def _friction(runs):
    panel = Panel("Friction against net force", "friction (N)", NET_FORCE, over_time=False)
    for i, run in enumerate(runs):
        for n, f in NET_FORCES:
            if n in run and f in run:
                first = _rests(run)
                panel.lines.append(_line(runs, i, f, run[n][first:], run[f][first:]))
    return panel


def _hysteresis(runs):
    """Net force less friction: their difference is hysteresis, too small to see in the panel of both."""
    panel = Panel("Hysteresis: net force less friction", "n − f (mN)", NET_FORCE, over_time=False)
    for i, run in enumerate(runs):
        n, f = next(((n, f) for n, f in NET_FORCES if n in run and f in run), (None, None))
        if f and "residual_N" not in run:
            first = _rests(run)
            panel.lines.append(_line(runs, i, f, run[n][first:], [1e3 * (x - y) for x, y in zip(run[n][first:], run[f][first:])]))
    return panel


def _over_force(runs):
    panel = Panel("Net force and L, over F", "N", "force F (N)", over_time=False)
    for i, run in enumerate(runs):
        if "residual_N" in run and "L_N" in run:
            first = _rests(run)
            force, n = run["F_N"][first:], run["n_N"][first:]
            panel.lines.append(_line(runs, i, "n_N", force, n))
            panel.lines.append(_line(runs, i, "L_N", force, [math.copysign(L, x) for L, x in zip(run["L_N"][first:], n)], is_guide=True))
    return panel


def _ends(values):
    kept = [y for y in values if math.isfinite(y)]
    return (min(kept), max(kept)) if kept else (math.inf, -math.inf)


def axis_range(runs, panel):
    """The range of y and a note. A start that would flatten the rest is left outside, and the note says so."""
    if not panel.over_time:
        return None, ""
    whole, rest = [math.inf, -math.inf], [math.inf, -math.inf]
    for line in panel.lines:
        first = _rests(runs[line.run])
        for ends, values in ((whole, line.y), (rest, line.y[first:])):
            low, high = _ends(values)
            ends[:] = min(ends[0], low), max(ends[1], high)
    if not rest[1] > rest[0] or whole[1] - whole[0] <= START_RATIO * (rest[1] - rest[0]):
        return None, ""
    room = 0.1 * (rest[1] - rest[0])
    shown = rest[0] - room, rest[1] + room
    outside = [end for end, is_out in zip(whole, (whole[0] < shown[0], whole[1] > shown[1])) if is_out]
    return shown, "the start goes to " + " and ".join(f"{end:.3g}" for end in outside)


def thin(line, columns, over_time=True):
    """x and y with at most 4 points a column: over time the least and the largest y of each column, otherwise every n-th point of many."""
    count = len(line.y)
    if not over_time:
        kept = slice(None, None, 1 + count // (50 * columns))
        return list(line.x[kept]), list(line.y[kept])
    every = -(-count // (2 * columns))
    if count <= 4 * columns:
        return list(line.x), list(line.y)
    xs, ys = [], []
    for first in range(0, count, every):
        part = line.y[first : first + every]
        if math.isnan(sum(part)):
            places = range(len(part))  # a gap stays one
        else:
            places = sorted({part.index(min(part)), part.index(max(part))})
        xs += [line.x[first + i] for i in places]
        ys += [part[i] for i in places]
    return xs, ys
