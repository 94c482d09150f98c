"""Files as they come: text, rows of a CSV file, and names and roots as they are printed."""

import csv
import hashlib
import io
import re
import urllib.parse
from pathlib import Path

import ruamel.yaml

from .errors import InputError

SIZE_MAX = 50_000_000


def is_there(path):
    """Whether the name exists, also as a dangling link. A path that cannot be accessed is an error, not absent."""
    try:
        Path(path).lstat()
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    return True


def read_text(path):
    path = Path(path)
    try:
        with open(path, "rb") as file:
            data = file.read(SIZE_MAX + 1)  # not to the end of a device that has none
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if len(data) > SIZE_MAX:
        raise InputError(f"{path}: too large: more than {SIZE_MAX // 10**6} MB")
    try:
        return data.decode("utf-8-sig"), hashlib.sha256(data).hexdigest()
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not UTF-8 text (byte {error.start})") from None


def parse_yaml(text, path, kind):
    """What the text holds; `kind` as of ruamel.yaml: rt keeps comments, order and lines."""
    try:
        if re.search(r"[\[{]{20}", text):
            raise RecursionError
        return ruamel.yaml.YAML(typ=kind, pure=True).load(text)
    except ruamel.yaml.constructor.DuplicateKeyError as error:
        name = re.search(r'duplicate key "(.*?)"', error.problem or "")
        raise InputError(f"{path}:{error.problem_mark.line + 1}: {name.group(1) if name else 'a field'}: is given twice") from None
    except ruamel.yaml.error.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        problem = getattr(error, "problem", None) or str(error).splitlines()[0]
        raise InputError(f"{path}:{mark.line + 1 if mark else 1}: not YAML: {problem}") from None
    except RecursionError:
        raise InputError(f"{path}:1: nested too deeply") from None
    except (ValueError, TypeError, AttributeError, AssertionError, IndexError) as error:  # raised for broken tags, dates and the like
        raise InputError(f"{path}:1: not YAML: {error}") from None


def read_mapping(path, kind="safe"):
    """The mapping that a YAML file holds."""
    text, _ = read_text(path)
    tree = parse_yaml(text, path, kind)
    if not isinstance(tree, dict):
        raise InputError(f"{path}:1: must be keys and values, as a scenario is")
    return tree


def read_scenario(path, kind="safe"):
    """The mapping of a scenario whose keys and values tribo-sim accepts."""
    from tribo._core import Scenario, ScenarioError

    tree = read_mapping(path, kind)
    try:
        Scenario(path)
    except ScenarioError as error:
        raise InputError(str(error)) from None
    return tree


def read_rows(path, text):
    """(line, cells) of a CSV file, without comments and empty rows."""
    try:
        rows = [(i, [c.strip() for c in row]) for i, row in enumerate(csv.reader(io.StringIO(text)), 1)
                if any(c.strip() for c in row) and not row[0].lstrip().startswith("#")]
    except csv.Error as error:
        raise InputError(f"{path}: not a CSV file: {error}") from None
    if not rows:
        raise InputError(f"{path}: is empty")
    return rows


def printable(name):
    """A file's name for generated files: a newline or a backslash in it must not become C or YAML."""
    return urllib.parse.quote(name, safe=" -._~+,=@()%")


def format_root(root):
    root = complex(root)
    return f"{root.real:g}" if root.imag == 0 else f"{root.real:g}{root.imag:+g}j"
