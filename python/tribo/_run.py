"""Runs of the simulator."""

from __future__ import annotations

import json
import numbers
import os
import threading
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal, Unpack, cast

import numpy as np
import numpy.typing as npt

from ._core import Keys, Scenario, ScenarioError, Value, all_keys, new_error, raised, signature_of, text
from ._keywords import RunKeys
from ._native import ffi, lib
from ._plot import Record

Array = npt.NDArray[Any]

TRACE_BYTES_MAX = min(4 << 30, os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2)  # of a run: 5 hours at 1 kHz


@dataclass(frozen=True)
class Way:
    """The learned breakaway in one direction."""

    breakaway_N: float
    relative_variance: float
    travel_N: float
    at_bound: bool
    stays_at_bound: bool


@dataclass(frozen=True)
class Learned:
    """Learned values of a feed-forward: breakaway in both directions, whether friction fed forward did harm and was fed back, and how often its memory was corrupt.
    A run also has the usual force, whose breakaway set the widths of the feed-forward, and the reason if too little was learned."""

    positive: Way
    negative: Way
    harms: bool
    forgotten: int
    usual_force_N: float | None = field(default=None, compare=False)
    not_learned: str | None = field(default=None, compare=False)


@dataclass(frozen=True)
class Difference:
    """Differences of two loops over the metrics window: Q31 minus f32."""

    max_u_N: float
    rms_u_N: float
    max_F_N: float
    rms_F_N: float


@dataclass(frozen=True)
class Summary:
    """The results of a run, with the keys of summary.json. Errors, variation, chatter and switches are over the metrics window."""

    rms_error_N: float
    max_error_N: float
    rms_measured_error_N: float
    u_variation_N: float
    variation_ratio: float | None
    chatter_ticks: int
    Q_switches: int
    limited_ticks: int
    bad_inputs: int
    ticks: int | None = None
    simulated_s: float | None = None
    wall_s: float | None = None
    real_time_factor: float | None = None
    guard: str | None = None
    learned: Learned | None = None
    q31: Summary | None = None
    difference: Difference | None = None


_WHOLE = {field.name for field in fields(Summary) if str(field.type).startswith("int")}


def _summary(tree: dict[str, Any]) -> Summary:
    tree = {key: int(value) if key in _WHOLE else value for key, value in tree.items()}
    if "learned" in tree:
        tree["learned"] = learned(tree["learned"])
    if "q31" in tree:
        tree |= {"q31": _summary(tree["q31"]), "difference": Difference(**tree["difference"])}
    return Summary(**tree)


def learned(tree: dict[str, Any]) -> Learned:
    return Learned(Way(**tree["positive"]), Way(**tree["negative"]), tree["harms"], int(tree["forgotten"]), tree.get("usual_force_N"), tree.get("not_learned"))


class Run(Record):
    """A run's trace: the columns of trace.csv as numpy arrays, by name (`run["r_N"]`) or as attributes (`run.r_N`). `summary` has
    the results; `q31` is the second loop's trace if the run has both arithmetics, or None. `run.plot()` draws the run."""

    summary: Summary
    q31: Run | None

    def __init__(self, columns: dict[str, Array], summary: Summary, q31: Run | None = None) -> None:
        super().__init__(columns)
        self.summary = summary
        self.q31 = q31

    def __repr__(self) -> str:
        return f"<tribo.Run of {len(self['t_s'])} ticks, RMS error {self.summary.rms_error_N:.6f} N>"


def _columns(trace: Array) -> dict[str, Array]:
    return {text(lib.native_column_name(i)): trace[i] != 0 if lib.native_column_is_flag(i) else trace[i] for i in range(len(trace))}


def _rows(made: Scenario, decimate: int, row_bytes: int) -> int:
    """Rows of a run's trace. Refuses one that would fill the memory."""
    rows, rows_max = -(-lib.native_scenario_ticks(made.handle) // decimate), TRACE_BYTES_MAX // row_bytes
    if rows <= rows_max:
        return int(rows)
    values = {key: ffi.new("double *") for key in ("duration_s", "sample_time_s")}
    for key, value in values.items():
        lib.native_scenario_number(made.handle, key.encode(), value)
    duration_s, sample_time_s = (value[0] for value in values.values())
    raise ScenarioError(f"duration_s: {duration_s:.9g} is outside {sample_time_s:g} to {rows_max * decimate * sample_time_s:.12g}: a trace of {rows} rows takes {row_bytes * rows / 1e9:.3g} GB "
                        f"of memory, more than {TRACE_BYTES_MAX / 1e9:.3g} GB; decimate={-(-rows * decimate // rows_max)} keeps fewer rows", "duration_s")


_stopped = threading.local()


def _stop(_: object, by: BaseException, __: object) -> None:
    _stopped.by = by


@ffi.def_extern(error=False, onerror=_stop)  # type: ignore[untyped-decorator]
def native_go_on() -> bool:
    """Python acts on Ctrl-C when it enters this function: the simulator calls it now and then."""
    return True


def run(scenario: str | os.PathLike[str] | None, keys: Keys | None = None, /, *, arith: Literal["f32", "q31", "both"] | None = None, decimate: int = 1,
        **keywords: Unpack[RunKeys]) -> Run:
    """Runs a scenario as `tribo-sim run` does: a path, the name of one in the scenarios folder, or None for the defaults, which lack `duration_s` and
    `reference.kind`.

    `keys` are keys of a scenario by their dotted names. A keyword may be the last part of a key if that is unique. Without `arith` the arithmetic is
    the scenario's, in most f32. `decimate=N` keeps only the first of every N rows.

    >>> short = run("triangle", {"metrics.start_s": 0, "plant.friction.k_min": 5}, duration_s=2, arith="both")
    >>> short.summary.ticks, len(short.q31.u_N), bool(short.limited.any())
    (2000, 2000, False)
    >>> run("triangle", start_s=0)
    Traceback (most recent call last):
        ...
    tribo.ScenarioError: start_s: several keys end with this name, give one of them in a dict: metrics.start_s, reference.start_s
    """
    if arith not in ("f32", "q31", "both", None):
        raise ValueError(f"arith={arith!r}: must be f32, q31 or both")
    if not isinstance(decimate, numbers.Integral) or isinstance(decimate, bool) or not 1 <= decimate < 2**63:
        raise ValueError(f"decimate={decimate!r}: a whole number from 1 to {2**63 - 1} is expected")
    made = Scenario(scenario)
    for key, value in all_keys(keys, cast(Mapping[str, Value], keywords)).items():
        made.set(key, value)
    if arith is not None:
        made.set("arithmetic", arith)
    error = new_error()
    if not lib.native_scenario_check(made.handle, error):
        raise raised(error)
    loops, columns = 1 + (arith == "both"), lib.native_scenario_columns(made.handle)
    rows = _rows(made, int(decimate), 8 * columns * loops)
    traces = [np.empty((columns, rows)) for _ in range(loops)]
    pointers = [ffi.from_buffer("double *", trace, require_writable=True) for trace in traces]
    json_text = lib.native_run(made.handle, arith == "q31", rows, int(decimate), pointers[0], pointers[1] if arith == "both" else ffi.NULL, lib.native_go_on, error)
    if (stopped := _stopped.__dict__.pop("by", None)) is not None:
        raise stopped
    if json_text == ffi.NULL:
        raise raised(error)
    try:
        summary = _summary(json.loads(text(json_text)))
    finally:
        lib.native_free(json_text)
    second = Run(_columns(traces[1]), summary.q31) if summary.q31 else None
    return Run(_columns(traces[0]), summary, second)


run.__signature__ = signature_of(run)  # type: ignore[attr-defined]
