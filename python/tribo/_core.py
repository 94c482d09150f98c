"""Scenarios, their keys and their refusals."""

from __future__ import annotations

import inspect
import numbers
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeAlias

from ._native import ffi, lib

Arithmetic: TypeAlias = Literal["f32", "q31"]
Value: TypeAlias = float | bool | str | Sequence[Mapping[str, float]] | Mapping[str, Any]
Keys: TypeAlias = Mapping[str, Value]

# The wheel's own folder, or that of the source tree.
FOLDER = next(folder for folder in (Path(__file__).with_name("scenarios"), Path(__file__).resolve().parents[2] / "host_sim" / "scenarios") if folder.exists())


def text(pointer: Any) -> str:
    """Text from the C part. File names and file content in it may be in any encoding."""
    return bytes(ffi.string(pointer)).decode(errors="backslashreplace")


__version__ = text(lib.native_version())


class ScenarioError(ValueError):
    """A scenario that the simulator refuses; `field` is the key at fault, or None."""

    def __init__(self, message: str, field: str | None = None) -> None:
        super().__init__(message)
        self.field = field


class StatusError(ScenarioError):
    """A status of the library: `status` is its name without TRIBO_ERR_, `field` the key in a scenario, `text` the library's message.

    >>> try:
    ...     Friction(k_min=8, k_max=7)
    ... except StatusError as error:
    ...     error.status, error.field
    ('K_MIN', 'compensator.friction.k_min')
    """

    def __init__(self, status: str, field: str, words: str) -> None:
        super().__init__(f"{field}: {words}" if field and not words.startswith(f"{field}:") else words, field)
        self.status = status
        self.text = words


@dataclass(frozen=True)
class Parameter:
    """A parameter of the library, by its key in a scenario."""

    key: str
    unit: str
    low: float
    high: float
    default: float
    condition: str
    text: str


def _parameters() -> dict[str, Parameter]:
    rows = [lib.native_parameter(i) for i in range(lib.native_parameter_count())]
    return {text(row.key): Parameter(text(row.key), text(row.unit), row.low, row.high, row.standard, text(row.condition), text(row.text)) for row in rows}


@dataclass(frozen=True)
class Key:
    """A key of a scenario: number, whole, choice (of words), text, group or list."""

    type: str
    words: tuple[str, ...]


def _keys() -> dict[str, Key]:
    found: dict[str, Key] = {}
    key = ffi.new("native_key_t *")
    while lib.native_key(len(found), key):
        words = re.split(", | or ", text(key.words)) if text(key.type) == "choice" else []
        found[text(key.path)] = Key(text(key.type), tuple(words))
    return found


PARAMETERS: dict[str, Parameter] = _parameters()
KEYS: dict[str, Key] = _keys()


def raised(error: Any) -> ScenarioError:
    """The exception for a native_error_t."""
    key, words = text(error.key), text(error.text)
    if error.status:
        return StatusError(text(lib.native_status_symbol(error.status)), key, words)
    return ScenarioError(words.replace("--set ", ""), key or None)


def new_error() -> Any:
    return ffi.new("native_error_t *")


def full_key(name: str, groups: Sequence[str] = (), within: Sequence[str] = ("",), is_group: bool = False) -> str:
    """The key that a keyword means: itself, one in the groups, or the only one that ends with it. `within` lists the beginnings of a part's keys; a loop
    has no keys of the plant. A group's name means a key of that name (`compensator.sensor`) unless its value `is_group`: YAML in braces, or a mapping."""
    if not isinstance(name, str):
        raise ScenarioError(f"{name!r}: the name of a key is expected")
    if "." in name:
        return name
    for key in (name, *(group + name for group in groups)):
        if key in KEYS and (is_group or KEYS[key].type != "group"):
            return key
    found = sorted(key for key, row in KEYS.items() if key.endswith(f".{name}") and key.startswith(tuple(within)) and "[" not in key and (is_group or row.type != "group"))
    if len(found) > 1:
        raise ScenarioError(f"{name}: several keys end with this name, give one of them in a dict: {', '.join(found)}", name)
    return found[0] if found else name


def all_keys(keys: Keys | None, keywords: Keys, groups: Sequence[str] = (), within: Sequence[str] = ("",)) -> dict[str, Value]:
    found: dict[str, Value] = {}
    for name, value in (*(keys or {}).items(), *keywords.items()):
        key = full_key(name, groups, within, isinstance(value, Mapping) or isinstance(value, str) and value.lstrip().startswith("{"))
        if key in found:
            raise ScenarioError(f"{key}: is given twice: {found[key]!r} and {value!r}", key)
        found[key] = value
    return found


def keywords_of(groups: Sequence[str] = (), within: Sequence[str] = ("",)) -> dict[str, Key]:
    """Every keyword that means exactly one key, by its name."""
    found: dict[str, Key] = {}
    for name in sorted({path.rpartition(".")[2] for path, row in KEYS.items() if row.type != "group" and "[" not in path}):
        try:
            key = full_key(name, groups, within)
        except ScenarioError:
            continue
        if key in KEYS and key.startswith((*within, *groups)):
            found[name] = KEYS[key]
    return found


def annotation_of(key: Key) -> str:
    """The Python type of the key's values, as source text."""
    plain = {"number": "float", "whole": "int", "text": "str", "list": "Sequence[Mapping[str, float]]"}
    if key.type != "choice":
        return plain[key.type]
    words = ", ".join(f'"{word}"' for word in key.words)
    return f"bool | Literal[{words}]" if key.words == ("no", "yes") else f"Literal[{words}]"


def signature_of(function: Any, groups: Sequence[str] = (), within: Sequence[str] = ("",)) -> inspect.Signature:
    """A function's signature with all its keywords, for help and completion. The default ... means the scenario's value."""
    given = inspect.signature(function)
    named = [parameter for parameter in given.parameters.values() if parameter.kind != inspect.Parameter.VAR_KEYWORD]
    rows = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=..., annotation=annotation_of(key)) for name, key in keywords_of(groups, within).items()]
    return given.replace(parameters=[*named, *(row for row in rows if row.name not in given.parameters)])


def _yaml(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_yaml(one)}" for key, one in value.items()) + "}"
    if isinstance(value, Iterable) and not isinstance(value, bytes):
        return "[" + ", ".join(map(_yaml, value)) + "]"
    raise ScenarioError(f"{value!r} is not a number, a word, a mapping or a list of these")


def scenarios() -> list[str]:
    """The scenarios that can be given by name.

    >>> "triangle" in scenarios()
    True
    """
    return sorted(path.stem for path in _folder().glob("*.yaml"))


def _folder() -> Path:
    return Path(os.environ.get("TRIBO_SCENARIOS") or FOLDER)


def _is_there(path: Path) -> bool:
    """Whether the path exists. A path that cannot be accessed is an error, not absent."""
    try:
        path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError as error:
        raise ScenarioError(f"{path}: cannot be opened: {error.strerror}") from None
    return True


def scenario_path(scenario: str | os.PathLike[str]) -> Path:
    path = Path(scenario)
    if not _is_there(path) and path.name == os.fspath(scenario):
        path = next((found for ending in ("", ".yaml") if _is_there(found := _folder() / (path.name + ending))), path)
    if not _is_there(path):
        raise ScenarioError(f"{path}: there is no such file, and no such scenario in {_folder()}")
    return path


class Scenario:
    """A scenario under construction."""

    def __init__(self, scenario: str | os.PathLike[str] | None) -> None:
        error = new_error()
        path = ffi.NULL if scenario is None else os.fsencode(scenario_path(scenario))
        handle = lib.native_scenario_open(path, error)
        if handle == ffi.NULL:
            raise raised(error)
        self.handle = ffi.gc(handle, lib.native_scenario_close)

    def set(self, key: str, value: Value) -> None:
        """Sets a key, as --set does."""
        error = new_error()
        try:
            assignment = f"{key}={_yaml(value)}"
        except ScenarioError as kind:
            raise ScenarioError(f"{key}: {kind}", key) from None
        if "\0" in assignment:
            raise ScenarioError(f"{key!r}: holds a zero byte", key)
        if not lib.native_scenario_set(self.handle, assignment.encode(errors="surrogateescape"), error):
            refused = raised(error)
            raise ScenarioError(str(refused).removeprefix(f"{assignment}: "), refused.field)

    def put(self, keys: Mapping[str, Value]) -> None:
        """Checks the scenario except for the library's own parameters, which the library checks."""
        for key, value in keys.items():
            is_number = isinstance(value, numbers.Real) and not isinstance(value, bool)
            if not (is_number and lib.native_scenario_put(self.handle, key.encode(), value)):
                self.set(key, value)
