"""Parts of a loop that can be stepped separately."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, ClassVar, Unpack

import numpy as np
import numpy.typing as npt

from ._core import Arithmetic, Keys, Scenario, Value, all_keys, new_error, raised, signature_of, text
from ._keywords import CompensatorKeys, FeedForwardKeys, FrictionKeys, GuardKeys, LoopKeys
from ._native import ffi, lib
from ._plot import Record, recorded
from ._run import Learned, learned

Floats = npt.NDArray[np.float64]
_FRICTION = ("compensator.friction.", "compensator.friction.breakaway.", "compensator.arm.")
_LOOP = ("sample_time_s", "controller.", "compensator.", "limits.")
_STEP = lib.native_part_step


class Part:
    """A part of a scenario's loop, in one arithmetic. The scenario is a name, a path, or None for the defaults. Keys are those of tribo.run; the library
    checks its own parameters."""

    _kind: ClassVar[str]
    _groups: ClassVar[tuple[str, ...]] = ()
    _within: ClassVar[tuple[str, ...]] = _LOOP

    def __init_subclass__(cls) -> None:
        if "_kind" in cls.__dict__:
            cls.__signature__ = signature_of(Part, cls._groups, cls._within)  # type: ignore[attr-defined]

    def __init__(self, scenario: str | os.PathLike[str] | None = None, keys: Keys | None = None, /, *, arith: Arithmetic = "f32", **keywords: Value) -> None:
        if arith not in ("f32", "q31"):
            raise ValueError(f"arith={arith!r}: must be f32 or q31")
        made = Scenario(scenario)
        made.put(all_keys(keys, keywords, self._groups, self._within))
        error = new_error()
        part = lib.native_part_new(self._kind.encode(), made.handle, arith == "q31", error)
        if part == ffi.NULL:
            raise raised(error)
        self._part = ffi.gc(part, lib.native_part_delete)
        self.arith = arith
        self.inputs = self._names(lib.native_part_input)
        self.outputs = self._names(lib.native_part_output)

    def _names(self, get: Any) -> tuple[str, ...]:
        names: list[str] = []
        while (name := get(self._part, len(names))) != ffi.NULL:
            names.append(text(name))
        return tuple(names)

    def reset(self) -> None:
        """Returns the part to rest, with nothing learned."""
        lib.native_part_reset(self._part)

    @property
    def signals(self) -> dict[str, float]:
        """Every output of the last step."""
        return {name: lib.native_part_seen(self._part, i) for i, name in enumerate(self.outputs)}

    def _play(self, inputs: tuple[npt.ArrayLike, ...], all_outputs: bool) -> list[Floats]:
        given = [np.ascontiguousarray(x, np.float64) for x in np.broadcast_arrays(*(np.atleast_1d(np.asarray(x, np.float64)) for x in inputs))]
        if given[0].ndim != 1:
            raise ValueError("an input must be a number or an array of one dimension")
        made = [np.empty(len(given[0])) for _ in (self.outputs if all_outputs else self.outputs[:1])]
        ins = ffi.new("double *[]", [ffi.from_buffer("double *", x) for x in given])
        outs = ffi.new("double *[]", [ffi.from_buffer("double *", x, require_writable=True) for x in made])
        lib.native_part_play(self._part, ffi.cast("double const * const *", ins), len(given[0]), outs, all_outputs)
        return made

    def _record(self, *inputs: npt.ArrayLike) -> dict[str, Floats]:
        return dict(zip(self.outputs, self._play(inputs, True)))


class _Latches(Part):
    def restore(self) -> None:
        """Clears the latches of guard and feed-forward; learned values stay."""
        lib.native_part_restore(self._part)


class _Learns(_Latches):
    def learned(self, F_N: float = 0.0) -> Learned | None:
        """Returns the breakaway learned so far at an end-point force, or None if the method does not learn."""
        values = ffi.new("double[12]")
        if not lib.native_part_learned(self._part, F_N, values):
            return None
        names = ("breakaway_N", "relative_variance", "travel_N", "at_bound", "stays_at_bound")
        ways = [dict(zip(names, [*values[i : i + 3], values[i + 3] != 0, values[i + 4] != 0])) for i in (0, 5)]
        return learned({"positive": ways[0], "negative": ways[1], "harms": values[10] != 0, "forgotten": values[11]})


class Loop(_Learns):
    """The whole force loop: controller, compensation by `method`, guard.

    >>> loop = Loop("triangle", arith="q31")
    >>> seen = loop.record([0.4, 0.41], [0.4, 0.4])
    >>> bool(seen["u_N"][1] == loop.signals["u_N"])
    True
    """

    _kind = "loop"
    _groups = ("limits.",)

    if TYPE_CHECKING:

        def __init__(self, scenario: str | os.PathLike[str] | None = None, keys: Keys | None = None, /, *, arith: Arithmetic = "f32", **keywords: Unpack[LoopKeys]) -> None: ...

    def step(self, r_N: float, y_N: float) -> float:
        """Runs one tick: reference and measured force give the command u in N."""
        return _STEP(self._part, r_N, y_N, 0.0, 0.0)  # type: ignore[no-any-return]

    def steps(self, r_N: npt.ArrayLike, y_N: npt.ArrayLike) -> Floats:
        """Runs a tick for each element and returns u."""
        return self._play((r_N, y_N), False)[0]

    def record(self, r_N: npt.ArrayLike, y_N: npt.ArrayLike) -> Record:
        """Does what steps() does, and returns every output with t_s, r_N and y_N."""
        outputs = self._record(r_N, y_N)
        return Record(recorded(self.sample_time_s, r_N=r_N, y_N=y_N) | outputs)

    @property
    def guard_cause(self) -> str | None:
        """Why the guard has faded friction: none, hunting or overshoot; None without a guard."""
        cause = lib.native_part_guard_cause(self._part)
        return None if cause == ffi.NULL else text(cause)

    @property
    def sample_time_s(self) -> float:
        """Changes keys between two steps."""
        return float(lib.native_part_sample_time_s(self._part))

    @property
    def limited_ticks(self) -> int:
        return int(lib.native_part_limited_ticks(self._part))

    @property
    def bad_inputs(self) -> int:
        return int(lib.native_part_bad_inputs(self._part))


class Friction(Part):
    """The paper's friction of a hub, Eqs. (3) to (9): f as a function of the command u and the end-point force F.

    >>> hub = Friction(offset_N=0.01, slope=0)
    >>> hub.steps([0.001, 0.004, 1.0], 0.0).round(6).tolist()
    [0.001, 0.004, 0.01]
    """

    _kind = "friction"
    _groups = _FRICTION
    _within: ClassVar[tuple[str, ...]] = ("sample_time_s", "limits.", "compensator.friction.", "compensator.arm.")

    if TYPE_CHECKING:

        def __init__(self, scenario: str | os.PathLike[str] | None = None, keys: Keys | None = None, /, *, arith: Arithmetic = "f32", **keywords: Unpack[FrictionKeys]) -> None: ...

    def step(self, u_N: float, F_N: float) -> float:
        return _STEP(self._part, u_N, F_N, 0.0, 0.0)  # type: ignore[no-any-return]

    def steps(self, u_N: npt.ArrayLike, F_N: npt.ArrayLike) -> Floats:
        return self._play((u_N, F_N), False)[0]

    def record(self, u_N: npt.ArrayLike, F_N: npt.ArrayLike) -> dict[str, Floats]:
        return self._record(u_N, F_N)


class Compensator(Part):
    """The paper's estimate of friction from u alone, by friction law and a model of the arm.

    >>> Compensator().record(0.01)["F_hat_N"]
    array([0.])
    """

    _kind = "compensator"
    _groups = _FRICTION
    _within = ("sample_time_s", "limits.", "compensator.friction.", "compensator.arm.")

    if TYPE_CHECKING:

        def __init__(self, scenario: str | os.PathLike[str] | None = None, keys: Keys | None = None, /, *, arith: Arithmetic = "f32", **keywords: Unpack[CompensatorKeys]) -> None: ...

    def step(self, u_N: float) -> float:
        return _STEP(self._part, u_N, 0.0, 0.0, 0.0)  # type: ignore[no-any-return]

    def steps(self, u_N: npt.ArrayLike) -> Floats:
        return self._play((u_N,), False)[0]

    def record(self, u_N: npt.ArrayLike) -> dict[str, Floats]:
        return self._record(u_N)


class Guard(_Latches):
    """The guard against over-compensation: reference, reading and the friction in u give the factor on friction.

    >>> guard = Guard(fade_time_s=0.1)
    >>> guard.step(0.5, 0.5, 0.0), guard.cause
    (1.0, 'none')
    """

    _kind = "guard"
    _groups = ("compensator.guard.",)
    _within = ("sample_time_s", "limits.", "compensator.guard.")

    if TYPE_CHECKING:

        def __init__(self, scenario: str | os.PathLike[str] | None = None, keys: Keys | None = None, /, *, arith: Arithmetic = "f32", **keywords: Unpack[GuardKeys]) -> None: ...

    def step(self, r_N: float, y_N: float, friction_N: float, good: bool = True) -> float:
        """Runs one tick. `good` says that r and y are credible."""
        return _STEP(self._part, r_N, y_N, friction_N, good)  # type: ignore[no-any-return]

    def steps(self, r_N: npt.ArrayLike, y_N: npt.ArrayLike, friction_N: npt.ArrayLike, good: npt.ArrayLike = True) -> Floats:
        return self._play((r_N, y_N, friction_N, good), False)[0]

    @property
    def cause(self) -> str:
        """The cause: none, hunting or overshoot; latched until restore()."""
        return text(lib.native_part_guard_cause(self._part))


class FeedForward(_Learns):
    """The feed-forward around your own controller: in each tick `v = K(fed.error(r, y))`, then `u = fed.command(v)`.

    >>> fed = FeedForward(actuator_pole_rad_per_s=150)
    >>> error_N = fed.error(0.5, 0.4)
    >>> u_N = fed.command(2.0 * error_N)
    >>> fed.signals["e_N"] == error_N
    True
    """

    _kind = "feedforward"
    _groups = ("compensator.feedforward.", *_FRICTION, "limits.")
    _within = ("sample_time_s", "limits.", "compensator.feedforward.", "compensator.friction.", "compensator.arm.")

    if TYPE_CHECKING:

        def __init__(self, scenario: str | os.PathLike[str] | None = None, keys: Keys | None = None, /, *, arith: Arithmetic = "f32", **keywords: Unpack[FeedForwardKeys]) -> None: ...

    def error(self, r_N: float, y_N: float) -> float:
        """Begins a tick: returns the error for the controller."""
        return lib.native_feedforward_error(self._part, r_N, y_N)  # type: ignore[no-any-return]

    def command(self, v_N: float) -> float:
        """Ends the tick: returns u for the controller's output."""
        return lib.native_feedforward_command(self._part, v_N)  # type: ignore[no-any-return]

    def record(self, r_N: npt.ArrayLike, y_N: npt.ArrayLike, controller_N: npt.ArrayLike) -> dict[str, Floats]:
        """Runs a tick for each element, with the recorded output of the controller."""
        return self._record(r_N, y_N, controller_N)

    def steps(self, r_N: npt.ArrayLike, y_N: npt.ArrayLike, controller_N: npt.ArrayLike) -> Floats:
        """Does what record() does, and returns u alone."""
        return self._play((r_N, y_N, controller_N), False)[0]
