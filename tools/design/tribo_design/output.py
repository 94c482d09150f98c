"""Output directories that are either whole or not there."""

import contextlib
import io
import os
import shutil
import tempfile
from pathlib import Path

import ruamel.yaml

from tribo_plot.output import folder, is_protected, keep_mode

from .errors import InputError

DESIGN = ("*_controller.[hc]", "*_design.json", "*_scenario.yaml", "DESIGN.yaml", "report.md", "report.html", "plots/*.png")


def yaml_text(tree):
    """Writes a scenario for tribo-sim, which reads no aliases."""
    yaml, out = ruamel.yaml.YAML(), io.StringIO()
    yaml.width = 200
    yaml.representer.ignore_aliases = lambda _: True
    yaml.dump(tree, out)
    return out.getvalue()


def _is_named(file, names):
    return any(len(file.parts) == len(Path(n).parts) and file.match(n) for n in names)


def check_replaceable(out, names=DESIGN):
    """Only an empty directory or an earlier output may be replaced: one that has nothing but files of these names, and of
    those without a wildcard all, and that nobody has made read-only."""
    if not os.fspath(out):
        raise InputError("--out: is empty: the name of a directory is expected")
    out = Path(out)
    if out.exists() and not out.is_dir():
        raise InputError(f"--out {out}: exists and is not a directory")
    files = sorted(p.relative_to(out) for p in out.rglob("*") if p.is_symlink() or not p.is_dir())
    is_output = all((out / n).is_file() for n in names if "*" not in n)
    others = [f for f in files if not (is_output and _is_named(f, names))]
    if others:
        raise InputError(f"--out {out}: has other files in it ({others[0]}); give an empty or a new directory")
    for path in [out, *out.rglob("*")] if out.exists() else ():
        if is_protected(path.stat()):
            raise InputError(f"--out {out}: cannot be replaced: {path} is read-only")
    parent = out.resolve().parent
    while not parent.exists() and parent != parent.parent:
        parent = parent.parent
    if not parent.is_dir() or not os.access(parent, os.W_OK):
        raise InputError(f"--out {out}: {parent} is not a directory that can be written to")


def write_directory(out, files, names=DESIGN):
    """Writes into a directory beside `out`, then renames it into place."""
    check_replaceable(out, names)
    out = Path(out).resolve()
    try:
        with folder(out.parent), _fresh(out) as fresh:
            for name, data in files.items():
                path = fresh / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(data)
                keep_mode(path, out / name)
            mask = os.umask(0)
            os.umask(mask)
            fresh.chmod(0o777 & ~mask)
            keep_mode(fresh, out)
            _put(fresh, out)
    except OSError as error:
        raise InputError(f"--out {out}: cannot be written: {error.strerror}") from None


@contextlib.contextmanager
def _fresh(out):
    """Yields a new directory beside `out`, which goes unless it was renamed."""
    fresh = Path(tempfile.mkdtemp(prefix=f".{out.name}.", dir=out.parent))
    try:
        yield fresh
    finally:
        shutil.rmtree(fresh, ignore_errors=True)


def _put(fresh, out):
    """Renames a directory into place; what was there before stays if that fails."""
    if not out.exists():
        fresh.rename(out)
        return
    old = Path(tempfile.mkdtemp(prefix=f".{out.name}.old.", dir=out.parent))
    try:
        out.rename(old / "old")
        fresh.rename(out)
    except BaseException:
        if not out.exists():
            (old / "old").rename(out)
        old.rmdir()
        raise
    shutil.rmtree(old)
