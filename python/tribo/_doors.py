"""The library's force axis and its joint without a force sensor, each as one object, in either arithmetic."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, TypedDict, Unpack

import numpy as np
import numpy.typing as npt

from ._core import Arithmetic, new_error, raised, text
from ._native import ffi, lib
from ._plot import Record, recorded

Floats = npt.NDArray[np.float64]


def _arithmetic(arith: str) -> bool:
    if arith not in ("f32", "q31"):
        raise ValueError(f"arith={arith!r}: must be f32 or q31")
    return arith == "q31"


def _number(name: str, x: Any) -> float:
    if not hasattr(x, "__float__"):
        raise TypeError(f"{name}={x!r}: a number is expected")
    return float(x)


def _columns(*inputs: npt.ArrayLike) -> list[Floats]:
    given = [np.ascontiguousarray(x, np.float64) for x in np.broadcast_arrays(*(np.atleast_1d(np.asarray(x, np.float64)) for x in inputs))]
    if given[0].ndim != 1:
        raise ValueError("an input must be a number or an array of one dimension")
    return given


def _played(play: object, handle: object, inputs: list[Floats]) -> Floats:
    out = np.empty(len(inputs[0]))
    play(handle, *(ffi.from_buffer("double *", x) for x in inputs), len(out), ffi.from_buffer("double *", out, require_writable=True))  # type: ignore[operator]
    return out


@dataclass(frozen=True)
class AxisReport:
    """Learned breakaway at the usual force with its interval, in the positive and the negative direction."""

    breakaway_N: tuple[float, float]
    low_N: tuple[float, float]
    high_N: tuple[float, float]
    travel_N: float
    times_less: float  # controller effort (not error) at a reversal without compensation, divided by that with it, up to 100; 0: not known
    share: float  # fraction of the friction that the guard lets through
    bad_inputs: int
    limited_ticks: int
    forgotten: int
    breakaway_factor: float  # multiply the configured breakaway by it and make a new axis: 3 or 0.2 if it is far off, otherwise 1
    warnings: tuple[str, ...]


class AxisChanges(TypedDict, total=False):
    """The keywords that an axis accepts while it runs."""

    u_min_N: float
    u_max_N: float
    offset_N: float
    slope: float
    actuator_pole_rad_per_s: float
    sensor_pole_rad_per_s: float
    kp: float
    ki_per_s: float
    sections: npt.ArrayLike
    controller: Literal["paper", "own"]
    negative_offset_N: float
    negative_slope: float
    input_max_N: float
    usual_force_N: float
    gravity_N: float
    arm_lag_s: float
    noise_N: float
    presliding_N: float
    still_time_s: float


_NUMBERS = ("sample_time_s", "u_min_N", "u_max_N", "input_max_N", "usual_force_N", "offset_N", "slope", "negative_offset_N", "negative_slope",
            "gravity_N", "arm_lag_s", "noise_N", "actuator_pole_rad_per_s", "sensor_pole_rad_per_s", "kp", "ki_per_s", "full_scale_N",
            "presliding_N", "still_time_s")  # fmt: skip


def _full_scale_N(x: dict[str, Any]) -> float:
    """Four times the larger limit of u; more if another force needs it, and within the range of a full scale."""
    offset_N = max(x["offset_N"], x["negative_offset_N"])
    needed_N = max(4.0 * max(abs(x["u_min_N"]), abs(x["u_max_N"])), x["input_max_N"], x["usual_force_N"], 2.0 * abs(x["gravity_N"]), 2.0 * offset_N)
    return float(min(max(needed_N, 1e-3), 1e6))


def _config(x: dict[str, Any]) -> tuple[object, ...]:
    """An axis' keywords as arguments of the native calls."""
    has_gains = x["kp"] is not None or x["ki_per_s"] is not None
    if has_gains + (x["sections"] is not None) + (x["controller"] is not None) != 1:
        raise ValueError("give one controller: kp and ki_per_s, sections, or controller='paper' or 'own'")
    if x["controller"] not in (None, "paper", "own"):
        raise ValueError(f"controller={x['controller']!r}: must be paper or own")
    rows = np.ascontiguousarray(np.empty((0, 5)) if x["sections"] is None else x["sections"], np.float32)
    if rows.ndim != 2 or rows.shape[1] != 5:
        raise ValueError("sections: each row must have b0, b1, b2, a1, a2")
    kind = "pi" if has_gains else x["controller"] or "sections"
    return [_number(name, x[name] or 0.0) for name in _NUMBERS], kind.encode(), ffi.from_buffer("float *", rows) if rows.size else ffi.NULL, len(rows)


class Axis:
    """A force axis: loop, feed-forward and guard. Breakaway is offset_N + slope |F|; negative values that are left out equal the positive ones.

    >>> axis = Axis(sample_time_s=1e-3, u_min_N=-2, u_max_N=2, offset_N=0.007, slope=0.3, actuator_pole_rad_per_s=200, sensor_pole_rad_per_s=55, kp=1, ki_per_s=56)
    >>> -2 <= axis.step(0.5, 0.0) <= 2
    True

    Give one controller: kp and ki_per_s; or sections, rows of b0, b1, b2, a1, a2 in the delta operator; or controller="paper" or "own". With "own" a tick is
    `u = axis.command(my_pid(axis.error(r, y)))`.
    """

    def __init__(
        self,
        *,
        sample_time_s: float,
        u_min_N: float,
        u_max_N: float,
        offset_N: float,
        slope: float = 0.0,
        actuator_pole_rad_per_s: float,
        sensor_pole_rad_per_s: float,
        kp: float | None = None,
        ki_per_s: float | None = None,
        sections: npt.ArrayLike | None = None,
        controller: Literal["paper", "own"] | None = None,
        negative_offset_N: float = 0.0,
        negative_slope: float = 0.0,
        input_max_N: float = 0.0,
        usual_force_N: float = 0.0,
        gravity_N: float = 0.0,
        arm_lag_s: float = 0.0,
        noise_N: float = 0.0,
        presliding_N: float = 0.0,
        still_time_s: float = 0.2,
        full_scale_N: float = 0.0,
        arith: Arithmetic = "f32",
    ) -> None:
        given = locals()
        self._keywords: dict[str, Any] = {name: x for name, x in given.items() if name not in ("self", "arith")}
        _config(self._keywords)  # names a number that is none
        if arith == "f32" and full_scale_N and not 1e-3 <= full_scale_N <= 1e6:  # of Q31, which then checks it
            raise ValueError(f"full_scale_N={full_scale_N:g}: must be 0.001 to 1e6 N")
        self._keywords["full_scale_N"] = full_scale_N or _full_scale_N(self._keywords)
        error = new_error()
        made = lib.native_axis_new(_arithmetic(arith), *_config(self._keywords), error)
        if made == ffi.NULL:
            refused = raised(error)
            if arith == "q31" and not full_scale_N and "q31:" in str(refused):
                refused.args = (f"{refused}; full_scale_N was left out and is {self._keywords['full_scale_N']:g}; arith='f32' needs none",)
            raise refused
        self._axis = ffi.gc(made, lib.native_axis_delete)
        self.arith = arith
        self.sample_time_s = sample_time_s

    def change(self, **keywords: Unpack[AxisChanges]) -> None:
        """Changes keywords from the next tick on. u does not jump. Learned values stay, unless breakaway or gravity_N
        differ, to which they refer. A refusal changes nothing."""
        unknown = sorted(set(keywords) - set(AxisChanges.__annotations__))
        if unknown:
            raise TypeError(f"change() got an unexpected keyword argument {unknown[0]!r}")
        others = {"kp", "ki_per_s", "sections", "controller"}
        if {"sections", "controller"} & set(keywords):
            dropped = others
        else:
            dropped = {"sections", "controller"} if others & set(keywords) else set()
        changed = {name: None if name in dropped else x for name, x in self._keywords.items()} | keywords
        error = new_error()
        if not lib.native_axis_change(self._axis, *_config(changed), error):
            raise raised(error)
        self._keywords = changed

    def step(self, r_N: float, y_N: float) -> float:
        """Runs one tick: reference and reading give u."""
        return float(self.steps(r_N, y_N)[0])

    def steps(self, r_N: npt.ArrayLike, y_N: npt.ArrayLike) -> Floats:
        """A tick for each element."""
        return _played(lib.native_axis_play, self._axis, _columns(r_N, y_N))

    def record(self, r_N: npt.ArrayLike, y_N: npt.ArrayLike) -> Record:
        """Does what steps() does, and returns u with t_s, r_N and y_N; plot() draws them."""
        u_N = self.steps(r_N, y_N)
        return Record(recorded(self.sample_time_s, r_N=r_N, y_N=y_N) | {"u_N": u_N})

    def error(self, r_N: float, y_N: float) -> float:
        """Runs the first half of a tick: returns the error for your own controller."""
        return lib.native_axis_error(self._axis, r_N, y_N)  # type: ignore[no-any-return]

    def command(self, v_N: float) -> float:
        """Runs the second half of a tick: returns u for your controller's output."""
        return lib.native_axis_command(self._axis, v_N)  # type: ignore[no-any-return]

    @property
    def excess_N(self) -> float:
        """The part of the last command that the limit cut off, for your controller's anti-windup."""
        return lib.native_axis_excess(self._axis)  # type: ignore[no-any-return]

    def report(self) -> AxisReport:
        """Returns the learned values, and warnings as text."""
        x = ffi.new("double[13]")
        lib.native_axis_report(self._axis, x)
        warnings = []
        while (warning := lib.native_axis_warning(self._axis)) != ffi.NULL:
            warnings.append(text(warning))
        return AxisReport((x[0], x[1]), (x[2], x[3]), (x[4], x[5]), x[6], x[7], x[8], int(x[9]), int(x[10]), int(x[11]), x[12], tuple(warnings))

    def rest(self) -> None:
        """Puts the axis to rest: the next tick is the first one, with what was learned."""
        lib.native_axis_rest(self._axis)

    def restore(self) -> None:
        """Clears the latches of guard and monitor: friction returns in full."""
        lib.native_axis_restore(self._axis)

    def export(self) -> bytes:
        """Returns the learned values, for load()."""
        blob = ffi.new("char[]", lib.native_axis_blob_size(self._axis))
        lib.native_axis_export(self._axis, blob)
        return bytes(ffi.buffer(blob))

    def load(self, blob: bytes) -> None:
        """Adopts the learned values of another axis with the same rig and arithmetic."""
        error = new_error()
        if not lib.native_axis_import(self._axis, ffi.from_buffer(blob), len(blob), error):
            raise raised(error)


@dataclass(frozen=True)
class JointReport:
    """Learned friction with its interval, in the unit of effort."""

    friction: float
    low: float
    high: float
    load: float  # part of the effort that does not reverse; the loop holds it
    share: float  # fraction of the term that the guard lets through
    is_learned: bool
    bad_inputs: int
    limited_ticks: int
    cause: str  # "sound", or why the guard has faded the term out


@dataclass(frozen=True)
class JointForce:
    """The force of the joint on its surroundings, with its interval."""

    force: float
    low: float
    high: float


class Joint:
    """A joint with current and encoder, behind a position, velocity or impedance loop whose output is `effort`.

    >>> joint = Joint(sample_time_s=1e-3, effort_max=3.0, travel=0.0015)
    >>> joint.step(0.5, 0.0, 0.0)
    0.5

    q_ref and q are in one unit, in q31 whole counts of the encoder; `travel` is the least change of q that is motion, not noise, e.g. four counts. If
    positions begin anew after a turn, `wrap` is its travel. `breakaway` is your guess of the friction; half of it is used until friction is learned.
    `gain` is the part of the learned friction that is taken out, at most 0.8 where a hand leads, with q as q_ref. `actuator_pole_rad_per_s` is the
    current loop's; 0: it is fast.
    """

    def __init__(
        self,
        *,
        sample_time_s: float,
        effort_max: float,
        travel: float,
        breakaway: float = 0.0,
        actuator_pole_rad_per_s: float = 0.0,
        gain: float = 0.97,
        wrap: float = 0.0,
        arith: Arithmetic = "f32",
    ) -> None:
        given = locals()
        numbers = [_number(name, given[name]) for name in ("sample_time_s", "effort_max", "travel", "breakaway", "actuator_pole_rad_per_s", "gain", "wrap")]
        error = new_error()
        made = lib.native_joint_new(_arithmetic(arith), numbers, error)
        if made == ffi.NULL:
            raise raised(error)
        self._joint = ffi.gc(made, lib.native_joint_delete)
        self._gain = gain
        self.arith = arith
        self.sample_time_s = sample_time_s

    def step(self, effort: float, q_ref: float, q: float) -> float:
        """Runs one tick: returns u for the drive."""
        return float(self.steps(effort, q_ref, q)[0])

    def steps(self, effort: npt.ArrayLike, q_ref: npt.ArrayLike, q: npt.ArrayLike) -> Floats:
        """A tick for each element."""
        return _played(lib.native_joint_play, self._joint, _columns(effort, q_ref, q))

    def record(self, effort: npt.ArrayLike, q_ref: npt.ArrayLike, q: npt.ArrayLike) -> Record:
        """Does what steps() does, and returns u with t_s, effort, q_ref and q; plot() draws them."""
        u = self.steps(effort, q_ref, q)
        return Record(recorded(self.sample_time_s, effort=effort, q_ref=q_ref, q=q) | {"u": u})

    def load(self, load: float) -> None:
        """Sets the load from your model of the arm, e.g. gravity, as effort. It is added to u from the next tick on, and is not learned."""
        lib.native_joint_load(self._joint, load)

    @property
    def gain(self) -> float:
        """Fraction of the learned friction that is compensated, 0 to 1; its time constant is 0.1 s, upwards the actuator's lag if that is longer."""
        return self._gain

    @gain.setter
    def gain(self, gain: float) -> None:
        error = new_error()
        if not lib.native_joint_gain(self._joint, gain, error):
            raise raised(error)
        self._gain = gain

    def rest(self) -> None:
        """Puts the joint to rest: the next tick is the first one, with what was learned."""
        lib.native_joint_rest(self._joint)

    def restore(self) -> None:
        """Brings the term back. Remove the guard's cause first."""
        lib.native_joint_restore(self._joint)

    def force(self) -> JointForce:
        """Returns the end-point force from current, with its interval."""
        x = ffi.new("double[3]")
        lib.native_joint_force(self._joint, x)
        return JointForce(x[0], x[1], x[2])

    def report(self) -> JointReport:
        """Returns the learned values and the guard's cause."""
        x = ffi.new("double[8]")
        cause = text(lib.native_joint_report(self._joint, x))
        return JointReport(x[0], x[1], x[2], x[3], x[4], x[5] > 0.0, int(x[6]), int(x[7]), cause)
