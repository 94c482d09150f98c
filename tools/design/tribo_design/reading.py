"""Files as they come: text, rows of a CSV file, and names and roots as they are printed."""

import csv
import hashlib
import io
import urllib.parse
from pathlib import Path

import ruamel.yaml

from .errors import InputError


def read_text(path):
    path = Path(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if len(data) > 50_000_000:
        raise InputError(f"{path}: too large: {len(data)} bytes, at most 50 MB")
    try:
        return data.decode("utf-8-sig"), hashlib.sha256(data).hexdigest()
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not UTF-8 text (byte {error.start})") from None


def read_mapping(path, kind="safe"):
    """The mapping that a YAML file holds; `kind` as of ruamel.yaml: rt keeps comments and order."""
    text, _ = read_text(path)
    try:
        tree = ruamel.yaml.YAML(typ=kind).load(text)
    except ruamel.yaml.error.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        problem = getattr(error, "problem", None) or str(error).splitlines()[0]
        raise InputError(f"{path}:{mark.line + 1 if mark else 1}: not YAML: {problem}") from None
    if not isinstance(tree, dict):
        raise InputError(f"{path}:1: must be keys and values, as a scenario is")
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
