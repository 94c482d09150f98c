"""A study: a scenario and the keys that vary from row to row. docs/sweep.md describes its file."""

from __future__ import annotations

import difflib
import hashlib
import io
import math
import numbers
import os
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn, TypeAlias

import numpy as np
import numpy.typing as npt
from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from ._core import FOLDER, Scenario, ScenarioError, __version__, scenario_path, text
from ._native import ffi, lib

Probabilities: TypeAlias = npt.NDArray[np.float64]
Settings: TypeAlias = "list[tuple[str, str, Node]]"  # key, value, its place in the file

AXES_MAX, KEYS_MAX, POINTS_MAX, RUNS_MAX, ROWS_MAX = 64, 16, 100_000, 1_000_000, 10_000_000
BYTES_MAX = 4 << 20
METHODS = ("latin_hypercube", "monte_carlo", "sobol")
STUDY_WORDS = ("description", "scenario", "arithmetic", "method", "runs", "seed", "timeout_s", "set", "without", "grid", "sample")
KINDS = ("values", "cases", "uniform", "log_uniform", "normal")
AXIS_WORDS = (*KINDS, "keys", "relative", "points", "within")
CALLED = {ScalarNode: "a single value", MappingNode: "a mapping", SequenceNode: "a list"}

PLAIN = re.compile(r"[\w+\-./]+", re.ASCII)
MEASURES = ["rms_error_N", "max_error_N", "rms_measured_error_N", "u_variation_N", "variation_ratio", "chatter_ticks", "Q_switches", "window_ticks", "limited_ticks", "bad_inputs"]
COLUMNS = {"row", *MEASURES, *(f"without_{name}" for name in MEASURES), "ratio", "status", "message"}


def number_of(words: str) -> float:
    """A decimal number, as the simulator reads it. Raises ValueError with the reason if it is not one."""
    value = ffi.new("double *")
    complaint = lib.native_number(words.encode(errors="replace"), value)
    if complaint != ffi.NULL:
        raise ValueError(text(complaint))
    return float(value[0])


def is_number(words: str) -> bool:
    try:
        number_of(words)
    except ValueError:
        return False
    return True


def quoted(value: str) -> str:
    """The value as YAML that reads back as one word."""
    if PLAIN.fullmatch(value):
        return value
    return '"' + "".join(f"\\x{ord(c):02x}" if ord(c) < 0x20 else f"\\{c}" if c in '"\\' else c for c in value) + '"'


@dataclass
class Axis:
    """A column of the frame and its values. `probability` has a number from 0 to 1 for each sample, or for each point of a grid."""

    name: str
    place: Node
    kind: str = "values"
    labels: list[str] = field(default_factory=list)
    cases: list[Settings] = field(default_factory=list)
    keys: list[str] = field(default_factory=list)
    a: float = 0.0
    b: float = 0.0
    within: tuple[float, float] | None = None
    points: int = 0
    is_relative: bool = False
    is_whole: bool = False
    base: list[float] = field(default_factory=list)
    probability: Probabilities | None = None

    @property
    def is_listed(self) -> bool:
        return self.kind in ("values", "cases")

    @property
    def is_numeric(self) -> bool:
        return not self.is_listed or (self.kind == "values" and all(map(is_number, self.labels)))

    @property
    def is_integer(self) -> bool:
        return self.is_whole or (self.kind == "values" and all(re.fullmatch("[0-9]{1,19}", label) for label in self.labels))

    def __len__(self) -> int:
        return len(self.labels) if self.is_listed else self.points

    def draw(self, p: float) -> str:
        """The distribution's value at a probability, in six digits."""
        if self.kind == "log_uniform":
            x = self.a * (self.b / self.a) ** p
        elif self.kind == "normal":
            from scipy.special import ndtr, ndtri  # type: ignore[import-untyped]

            low, high = (ndtr((end - self.a) / self.b) for end in self.within) if self.within else (0.0, 1.0)
            x = self.a + self.b * float(ndtri(low + p * (high - low)))
        elif self.is_whole:
            return f"{min(math.floor(self.a + p * (self.b - self.a + 1)), self.b):.0f}"
        else:
            x = self.a + p * (self.b - self.a)
        return f"{x:.6g}"

    def value(self, key: int, label: str) -> str:
        """The value that one of the axis's keys is set to."""
        return f"{float(label) * self.base[key]:.9g}" if self.is_relative else label

    def settings(self, index: int) -> Settings:
        """The settings of the value with this index; for a distribution, of that sample or point."""
        if self.is_listed:
            return self.cases[index]
        label = self.label(index)
        return [(key, self.value(k, label), self.place) for k, key in enumerate(self.keys)]

    def label(self, index: int) -> str:
        if self.is_listed:
            return self.labels[index]
        assert self.probability is not None
        return self.draw(float(self.probability[index]))


class _Reader:
    """Reads nodes of one file. Each complaint names file, line and column."""

    def __init__(self, path: str) -> None:
        self.path = path

    def complain(self, node: Node | None, words: str, key: str | None = None) -> NoReturn:
        line, column = (node.start_mark.line + 1, node.start_mark.column + 1) if node is not None else (1, 1)
        raise ScenarioError(f"{self.path}:{line}:{column}: {words}", key)

    def compose(self, content: str) -> Node:
        try:
            root: Node | None = YAML(typ="safe", pure=True).compose(io.StringIO(content))
        except MarkedYAMLError as error:
            mark = error.problem_mark or error.context_mark
            raise ScenarioError(f"{self.path}:{mark.line + 1}:{mark.column + 1}: not valid YAML: {error.problem}") from None
        except (YAMLError, RecursionError) as error:
            raise ScenarioError(f"{self.path}:1:1: not valid YAML: {str(error).splitlines()[0] if str(error) else type(error).__name__}") from None
        if root is None:
            self.complain(None, "the file is empty")
        return root

    def expect(self, node: Node, kind: type[Node], name: str) -> None:
        if not isinstance(node, kind):
            self.complain(node, f"{name}: {CALLED[kind]} is expected here, not {CALLED[type(node)]}", name)

    def word(self, node: Node, name: str) -> str:
        self.expect(node, ScalarNode, name)
        if "\0" in node.value:
            self.complain(node, f"{name}: holds a zero byte", name)
        return str(node.value)

    def pairs(self, node: Node, name: str, words: Sequence[str] = ()) -> dict[str, tuple[Node, Node]]:
        """The pairs of a mapping by key. Keys must differ and, if `words` are given, be among them."""
        self.expect(node, MappingNode, name)
        found: dict[str, tuple[Node, Node]] = {}
        for key, value in node.value:
            word = self.word(key, name)
            if word in found:
                self.complain(key, f"{word} is given twice, first in line {found[word][0].start_mark.line + 1}", word)
            if words and word not in words:
                meant = difflib.get_close_matches(word, words, 1)
                self.complain(key, f"unknown key {word}" + (f", did you mean {meant[0]}?" if meant else ""), word)
            found[word] = key, value
        return found

    def items(self, node: Node, name: str) -> list[Node]:
        self.expect(node, SequenceNode, name)
        return list(node.value)

    def number(self, node: Node, name: str, low: float = -math.inf, high: float = math.inf) -> float:
        word = self.word(node, name)
        try:
            value = number_of(word)
        except ValueError as error:
            self.complain(node, f"{name}: '{word[:40]}' {error}", name)
        if not low <= value <= high:
            self.complain(node, f"{name}: {value:g} is outside {low:g} to {high:g}", name)
        return value

    def whole(self, node: Node, name: str, low: int, high: int) -> int:
        word = self.word(node, name)
        if not re.fullmatch("[0-9]+", word):
            self.complain(node, f"{name}: '{word[:40]}' is not a whole number of 0 or more", name)
        if not (len(word) <= 20 and low <= int(word) <= high):
            self.complain(node, f"{name}: {word[:40]} is outside {low} to {high}", name)
        return int(word)

    def choice(self, node: Node, name: str, words: Sequence[str]) -> str:
        word = self.word(node, name)
        if word not in words:
            self.complain(node, f"{name}: '{word[:40]}' is not {', '.join(words[:-1])} or {words[-1]}", name)
        return word

    def two(self, node: Node, name: str) -> tuple[float, float]:
        ends = self.items(node, name)
        if len(ends) != 2:
            self.complain(node, f"{name}: two numbers are expected here", name)
        return self.number(ends[0], name), self.number(ends[1], name)

    def settings(self, node: Node, name: str) -> Settings:
        return [(key, self.word(value, key), value) for key, (_, value) in self.pairs(node, name).items()]

    # --- axes ---

    def axis(self, name: Node, node: Node, in_grid: bool) -> Axis:
        axis = Axis(str(name.value), name)
        given = {"values": (node, node)} if isinstance(node, SequenceNode) and node.value else self.pairs(node, axis.name, AXIS_WORDS) if not isinstance(node, SequenceNode) else {}
        kinds = [word for word in given if word in KINDS]
        if not kinds:
            self.complain(node, f"{axis.name}: values, cases, uniform, log_uniform or normal is expected", axis.name)
        if len(kinds) > 1:
            self.complain(given[kinds[1]][0], f"{axis.name}: {kinds[0]} and {kinds[1]} do not go together", axis.name)
        axis.kind = kinds[0]
        if "relative" in given:
            axis.is_relative = self.choice(given["relative"][1], "relative", ("false", "no", "true", "yes")) in ("true", "yes")
        if "keys" in given:
            axis.keys = self._keys(axis, given["keys"][1])
        self._check_together(axis, given, node, in_grid)
        self._read_kind(axis, given[axis.kind][1])
        if "within" in given:
            axis.within = self._ordered(given["within"][1], "within")
        if "points" in given:
            axis.points = self.whole(given["points"][1], "points", 2, POINTS_MAX)
        return axis

    def _keys(self, axis: Axis, node: Node) -> list[str]:
        nodes = [node] if isinstance(node, ScalarNode) else self.items(node, "keys")
        if not nodes:
            self.complain(node, "keys: the list is empty", axis.name)
        if len(nodes) > KEYS_MAX:
            self.complain(nodes[KEYS_MAX], f"{axis.name}: more than {KEYS_MAX} keys", axis.name)
        return [self.word(one, "keys") for one in nodes]

    def _check_together(self, axis: Axis, given: Mapping[str, tuple[Node, Node]], node: Node, in_grid: bool) -> None:
        if axis.kind == "cases" and (axis.is_relative or axis.keys):
            self.complain(given["cases"][0], f"{axis.name}: cases have their own keys: remove keys and relative", axis.name)
        if "points" in given and (axis.is_listed or not in_grid):
            self.complain(given["points"][0], f"{axis.name}: only a distribution in the grid takes points", axis.name)
        if "within" in given and axis.kind != "normal":
            self.complain(given["within"][0], f"{axis.name}: only normal takes within", axis.name)
        if in_grid and not axis.is_listed and "points" not in given:
            self.complain(node, f"{axis.name}: a distribution in the grid needs points, their number", axis.name)

    def _ordered(self, node: Node, name: str) -> tuple[float, float]:
        low, high = self.two(node, name)
        if not low < high:
            self.complain(node, f"{name}: {low:g} is not below {high:g}", name)
        return low, high

    def _read_kind(self, axis: Axis, node: Node) -> None:
        if axis.kind == "cases":
            cases = self.pairs(node, axis.name)
            axis.labels, axis.cases = list(cases), [self.settings(value, label) for label, (_, value) in cases.items()]
        elif axis.kind == "values":
            values = [(self.word(value, axis.name), value) for value in self.items(node, axis.name)]
            axis.keys = axis.keys or [axis.name]
            axis.labels, axis.cases = [word for word, _ in values], [[(key, word, value) for key in axis.keys] for word, value in values]
        else:
            axis.keys = axis.keys or [axis.name]
            axis.a, axis.b = self._ordered(node, "uniform") if axis.kind == "uniform" else self.two(node, axis.kind)
        if axis.is_listed and not axis.labels:
            self.complain(node, f"{axis.name}: has no values", axis.name)
        if axis.kind == "log_uniform" and not 0 < axis.a < axis.b:
            self.complain(node, f"log_uniform: 0 < from < to is expected, not {axis.a:g}, {axis.b:g}", axis.name)
        if axis.kind == "normal" and not axis.b > 0:
            self.complain(node, f"normal: the standard deviation {axis.b:g} is not above 0", axis.name)

    def axes(self, node: Node, name: str, others: list[Axis]) -> list[Axis]:
        """The axes of the grid or of the samples; `others` were read before."""
        self.expect(node, MappingNode, name)
        axes: list[Axis] = []
        for key, value in node.value:
            self.word(key, name)
            if len(others) + len(axes) == AXES_MAX:
                self.complain(key, f"more than {AXES_MAX} axes")
            same = next((axis for axis in (*others, *axes) if axis.name == key.value), None)
            if same is not None:
                self.complain(key, f"{key.value} is given twice, first in line {same.place.start_mark.line + 1}", same.name)
            if key.value in COLUMNS:
                self.complain(key, f"{key.value}: a column of every sweep has this name, give the axis another", str(key.value))
            axes.append(self.axis(key, value, name == "grid"))
        return axes


def _plain(value: Any) -> Any:
    """A value of a Python mapping, as YAML has it."""
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, numbers.Integral):
        return int(value)
    if isinstance(value, numbers.Real):
        return float(value)
    if isinstance(value, Sequence | np.ndarray) and not isinstance(value, str):
        return [_plain(one) for one in value]
    return str(value)


def _as_yaml(study: Mapping[str, Any]) -> str:
    stream = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    yaml.dump(_plain(study), stream)
    return stream.getvalue()


def _study_path(study: str | os.PathLike[str]) -> Path:
    path, folder = Path(study), FOLDER.with_name("studies")
    if not path.exists() and path.name == os.fspath(study):
        path = next((found for ending in ("", ".yaml") if (found := folder / (path.name + ending)).is_file()), path)
    if not path.exists():
        raise ScenarioError(f"{path}: there is no such file, and no such study in {folder}")
    return path


class Study:
    """A study, read and checked: a path, the name of one in the studies folder, or a mapping of the same keys.

    >>> study = Study({"scenario": "triangle", "grid": {"compensator.gain": [0.5, 1]}, "without": {"compensator.gain": 0}})
    >>> study.rows, study.keys(1), study.keys(1, without=True)
    (2, {'compensator.gain': '1'}, {'compensator.gain': '0'})
    """

    def __init__(self, study: str | os.PathLike[str] | Mapping[str, Any]) -> None:
        if isinstance(study, Mapping):
            self.path, content = "study", _as_yaml(study)
        else:
            path = _study_path(study)
            self.path, content = os.fspath(path), self._content(path)
        reader = _Reader(self.path)
        root = reader.compose(content)
        parts = reader.pairs(root, "a study", STUDY_WORDS)
        self._read_plain(reader, parts)
        self.grid = reader.axes(parts["grid"][1], "grid", []) if "grid" in parts else []
        self._combinations = math.prod(map(len, self.grid))
        if self._combinations > ROWS_MAX:
            reader.complain(parts["grid"][0], f"grid: more than {ROWS_MAX} combinations")
        self.sampled, self.samples, self.method = self._read_samples(reader, parts)
        self.rows = self._combinations * self.samples
        if self.rows > ROWS_MAX:
            reader.complain(parts["runs"][0], f"runs: {self.rows} rows with the grid, more than {ROWS_MAX}")
        self.axes = [*self.grid, *self.sampled]
        self._prepare(reader, content)

    def _content(self, path: Path) -> str:
        try:
            with open(path, "rb") as file:
                content = file.read(BYTES_MAX + 1)
            if len(content) > BYTES_MAX:
                raise ScenarioError(f"{path}: is larger than {BYTES_MAX} bytes")
            return content.decode()
        except OSError as error:
            raise ScenarioError(f"{path}: cannot be read: {error.strerror}") from None
        except UnicodeDecodeError as error:
            raise ScenarioError(f"{path}:{error.object[: error.start].count(10) + 1}:1: not valid YAML: not UTF-8") from None

    def _read_plain(self, reader: _Reader, parts: Mapping[str, tuple[Node, Node]]) -> None:
        value = {word: node for word, (_, node) in parts.items()}
        if "scenario" not in value:
            reader.complain(None, "scenario: is missing", "scenario")
        name = reader.word(value["scenario"], "scenario")
        if "description" in value:
            reader.word(value["description"], "description")
        self.is_q31 = "arithmetic" in value and reader.choice(value["arithmetic"], "arithmetic", ("f32", "q31")) == "q31"
        self.seed = reader.whole(value["seed"], "seed", 0, 2**64 - 1) if "seed" in value else 1
        self.timeout_s = reader.number(value["timeout_s"], "timeout_s", 0.01, 1e6) if "timeout_s" in value else 600.0
        self._set = reader.settings(value["set"], "set") if "set" in value else []
        self._without = reader.settings(value["without"], "without") if "without" in value else []
        self.is_paired = "without" in value
        beside = Path(self.path).parent / name
        try:
            self.scenario = os.fspath(beside if beside.is_file() else scenario_path(name))
        except ScenarioError as error:
            reader.complain(value["scenario"], f"scenario: {error}", "scenario")

    def _read_samples(self, reader: _Reader, parts: Mapping[str, tuple[Node, Node]]) -> tuple[list[Axis], int, str]:
        if "sample" not in parts:
            for word in ("method", "runs"):
                if word in parts:
                    reader.complain(parts[word][0], f"only sample takes {word}, and there is no sample", word)
            return [], 1, METHODS[0]
        if "runs" not in parts:
            reader.complain(parts["sample"][0], "sample needs runs, their number", "runs")
        runs = reader.whole(parts["runs"][1], "runs", 1, RUNS_MAX)
        method = reader.choice(parts["method"][1], "method", METHODS) if "method" in parts else METHODS[0]
        return reader.axes(parts["sample"][1], "sample", self.grid), runs, method

    # --- against the scenario ---

    def _prepare(self, reader: _Reader, content: str) -> None:
        """Checks every key and every value, and draws the samples."""
        scenario = Scenario(self.scenario)
        self._try(reader, scenario, self._set)
        references = self._references(scenario)
        for axis in self.axes:
            self._find_keys(reader, scenario, axis)
        self._draw_samples()
        for axis in self.axes:
            for settings in axis.cases if axis.is_listed else self._ends(axis):
                self._try(reader, scenario, settings)
        self._try(reader, scenario, self._without)
        self.id = self._identify(content, references)

    def _try(self, reader: _Reader, scenario: Scenario, settings: Settings) -> None:
        for key, value, node in settings:
            try:
                scenario.set(key, quoted(value))
            except ScenarioError as error:
                reader.complain(node, str(error), key)

    def _find_keys(self, reader: _Reader, scenario: Scenario, axis: Axis) -> None:
        """The scenario's values of the axis's keys; a relative axis multiplies them."""
        axis.base = [1.0] * len(axis.keys)
        value = ffi.new("double *")
        for k, key in enumerate(axis.keys if axis.kind != "cases" else ()):
            found = lib.native_scenario_number(scenario.handle, key.encode(errors="replace"), value)
            kind = None if found == ffi.NULL else text(found)
            axis.is_whole |= kind == "whole" and axis.kind == "uniform" and not axis.is_relative
            if kind in ("whole", "other") and not axis.is_whole and (axis.is_relative or not axis.is_listed):
                reader.complain(axis.place, f"{key} is not a number: values are expected", key)
            if kind == "unset" and axis.is_relative:
                reader.complain(axis.place, f"{key}: the scenario gives no value to be relative to", key)
            if kind == "number":
                axis.base[k] = value[0]
        if axis.is_relative and axis.is_listed:
            for i, settings in enumerate(axis.cases):
                reader.number(settings[0][2], axis.name)
                axis.cases[i] = [(key, axis.value(k, axis.labels[i]), node) for k, (key, _, node) in enumerate(settings)]

    def _draw_samples(self) -> None:
        """Each sampled axis draws its own random numbers, from the seed and its name, so adding an axis leaves the others unchanged. Sobol's points are drawn in all
        axes at once."""
        from scipy.stats import qmc  # type: ignore[import-untyped]

        for axis in self.grid:
            if not axis.is_listed:
                axis.probability = (np.arange(axis.points) + 0.5) / axis.points if axis.kind == "normal" else np.arange(axis.points) / (axis.points - 1)
        drawn = qmc.Sobol(len(self.sampled), rng=np.random.default_rng(self.seed)).random(self.samples).T if self.method == "sobol" and self.sampled else None
        for i, axis in enumerate(self.sampled):
            rng = np.random.default_rng([self.seed, *axis.name.encode()])
            if drawn is not None:
                p = drawn[i]
            elif self.method == "latin_hypercube":
                p = qmc.LatinHypercube(1, rng=rng).random(self.samples)[:, 0]
            else:
                p = rng.random(self.samples)
            axis.probability = np.clip(p, 2.0**-53, 1.0 - 2.0**-53)

    def _ends(self, axis: Axis) -> list[Settings]:
        """The extreme values of a distribution; these suffice, because a key's range has no gaps. A distribution without bounds is checked by its samples."""
        assert axis.probability is not None
        is_bounded = axis.kind != "normal" or axis.within is not None
        ends = (0.0, 1.0) if is_bounded else (float(axis.probability.min()), float(axis.probability.max()))
        return [[(key, axis.value(k, axis.draw(p)), axis.place) for k, key in enumerate(axis.keys)] for p in ends]

    def _identify(self, content: str, references: set[Path]) -> str:
        """A hash of all that determines a row: the files of study, scenario and reference, the samples, the version."""
        digest = hashlib.sha256()
        samples = [axis.probability.tobytes() for axis in self.sampled if axis.probability is not None]
        files = [path.read_bytes() for path in (Path(self.scenario), *sorted(references)) if path.is_file()]
        for part in (__version__.encode(), content.encode(), *samples, *files):
            digest.update(len(part).to_bytes(8) + part)
        return digest.hexdigest()[:16]

    def _references(self, scenario: Scenario) -> set[Path]:
        """Reference files that rows may read."""
        read = lib.native_scenario_reference(scenario.handle)
        named = [value for settings in (self._without, *(case for axis in self.axes for case in axis.cases)) for key, value, _ in settings if key == "reference.file"]
        paths = {Path(self.scenario).parent / name for name in named}
        if read != ffi.NULL:
            paths.add(Path(os.fsdecode(ffi.string(read))))
            lib.native_free(read)
        return paths

    # --- rows ---

    def places(self, row: int) -> list[int]:
        """The index of each axis's value in the row."""
        indices = []
        combination = row % self._combinations
        for axis in reversed(self.grid):
            combination, index = divmod(combination, len(axis))
            indices.append(index)
        indices.reverse()
        for axis in self.sampled:
            sample = row // self._combinations
            assert axis.probability is not None
            indices.append(min(int(axis.probability[sample] * len(axis)), len(axis) - 1) if axis.is_listed else sample)
        return indices

    def labels(self, row: int) -> list[str]:
        """The row's entry in each axis's column."""
        return [axis.label(index) for axis, index in zip(self.axes, self.places(row))]

    def keys(self, row: int, without: bool = False) -> dict[str, str]:
        """The settings of a row, by the scenario's keys."""
        if not 0 <= row < self.rows:
            raise ValueError(f"row {row}: {row} is outside 0 to {self.rows - 1}")
        settings = [self._set, *(axis.settings(index) for axis, index in zip(self.axes, self.places(row))), self._without if without else []]
        return {key: value for one in settings for key, value, _ in one}

    def assignments(self, row: int, without: bool = False) -> list[str]:
        """The settings of a row as key=value, with the value in YAML."""
        return [f"{key}={quoted(value)}" for key, value in self.keys(row, without).items()]

    def command(self, row: int, without: bool = False) -> str:
        """The shell command that plays a row.

        >>> Study({"scenario": "triangle", "set": {"compensator.gain": 0.5}}).command(0).partition("/host_sim/")[2]
        'scenarios/triangle.yaml --set compensator.gain=0.5'
        """
        sets = [word for assignment in self.assignments(row, without) for word in ("--set", assignment)]
        return shlex.join(["tribo-sim", "run", "./" * self.scenario.startswith("-") + self.scenario, *(["--arith", "q31"] if self.is_q31 else []), *sets])
