"""rig.yaml: what the owner knows about a rig."""

from pathlib import Path
from typing import Annotated, Literal, Optional

from pydantic import AfterValidator, Field, field_validator, model_validator

from tribo_design.config import Filled, Number, Positive, Strict, load_yaml, validate
from tribo_design.errors import check_number
from tribo_design.reading import read_text

FORCE_MAX = 1e6  # N, of the library
RANGE_MIN = 1e-3  # N, of the design's full scale
Meant = Annotated[Number, AfterValidator(check_number)]
Safe = Annotated[Meant, Field(ge=-FORCE_MAX, le=FORCE_MAX)]
Pole = Annotated[Number, Field(ge=1e-2, le=1e6)]


class Force(Strict):
    low_N: Safe
    high_N: Safe

    @model_validator(mode="after")
    def _order(self):
        if not self.high_N - self.low_N >= RANGE_MIN:
            raise ValueError(f"high_N: value {self.high_N:g}: must be above low_N, {self.low_N:g}, by at least {RANGE_MIN:g} N")
        if not self.high_N > 0:
            raise ValueError(f"high_N: value {self.high_N:g}: must be above 0; change the signs of command and force if the rig only pulls")
        return self

    @property
    def largest(self):
        return max(abs(self.low_N), abs(self.high_N))


class Task(Force):
    """The forces that the loop is for, inside the safe ones."""


class Log(Strict):
    """How to read a log, like --column, --unit and --scale of tribo-identify."""

    columns: dict[Literal["t", "u", "F"], Filled] = {}
    units: dict[Literal["t", "F"], Filled] = {}
    scales: dict[Literal["t", "u", "F"], Meant] = {}
    resample: bool = False


class Known(Strict):
    """Values that need not be identified, because a data sheet has them or they were measured."""

    actuator_pole_rad_per_s: Optional[Pole] = None
    sensor_pole_rad_per_s: Optional[Pole] = None
    command: bool = False  # command_per_N is right and u has no bias, so that L+ and L- can be separated


class Rig(Strict):
    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,30}$")] = "loop"
    sample_time_s: Annotated[Number, Field(ge=1e-5, le=0.1)]
    force: Force
    command_per_N: Annotated[Number, Field(ge=-1e9, le=1e9)] = 1.0
    log: Log = Log()
    known: Known = Known()
    task: Optional[Task] = None
    bandwidth_rad_s: Optional[Positive] = None
    arithmetic: Literal["f32", "q31"] = "f32"

    @field_validator("command_per_N")
    @classmethod
    def _not_0(cls, value):
        if not abs(value) >= 1e-9:
            raise ValueError("must not be 0")
        return value

    @field_validator("force")
    @classmethod
    def _holds_0(cls, force):
        if force.low_N > 0:
            raise ValueError(f"low_N: value {force.low_N:g}: must be 0 or less: an experiment begins and ends without a command, at 0 N: set low_N: 0, and task: "
                             f"{{low_N: {force.low_N:g}, high_N: {force.high_N:g}}}")
        return force

    @field_validator("task")
    @classmethod
    def _is_safe(cls, task, info):
        safe = info.data.get("force")
        if task is not None and safe is not None and not safe.low_N <= task.low_N < task.high_N <= safe.high_N:
            raise ValueError(f"must be within the safe forces, {safe.low_N:g} to {safe.high_N:g} N")
        return task

    @property
    def assume(self):
        """Of tribo_identify."""
        return "calibrated" if self.known.command else "symmetric"

    def words(self):
        """The options for tribo-sim log."""
        words = [w for role, name in ({"u": "u_N"} | self.log.columns).items() for w in ("--column", f"{role}={name}")]
        words += [w for role, unit in self.log.units.items() for w in ("--unit", f"{role}={unit}")]
        words += [w for role, scale in {**self.log.scales, "u": self.log.scales.get("u", 1.0) / self.command_per_N}.items() for w in ("--scale", f"{role}={scale:.12g}")]
        return words + (["--resample"] if self.log.resample else [])


def load(path):
    text, _ = read_text(path)
    data, lines = load_yaml(text, path)
    return validate(Rig, data, path, lines)


TEMPLATE = Path(__file__).with_name("rig.yaml")
