"""Output directories that are either whole or not there."""

import os
import shutil
import tempfile
from pathlib import Path

from .errors import InputError

MARKERS = ("report.md", "DESIGN.yaml")


def check_replaceable(out, markers=MARKERS):
    """Only an empty directory or an earlier output may be replaced."""
    out = Path(out)
    if out.is_symlink() or (out.exists() and not out.is_dir()):
        raise InputError(f"--out {out}: exists and is not a directory")
    if out.is_dir() and any(out.iterdir()) and not all((out / m).is_file() for m in markers):
        raise InputError(f"--out {out}: has other files in it; give an empty or a new directory")
    parent = out.resolve().parent
    if not parent.is_dir() or not os.access(parent, os.W_OK):
        raise InputError(f"--out {out}: {parent} is not a directory that can be written to")


def write_directory(out, files, markers=MARKERS):
    """Writes into a directory beside `out`, then renames it into place."""
    check_replaceable(out, markers)
    out = Path(out).resolve()
    fresh = None
    try:
        fresh = Path(tempfile.mkdtemp(prefix=f".{out.name}.", dir=out.parent))
        for name, data in files.items():
            path = fresh / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        fresh.chmod(0o755)
        if out.exists():
            old = Path(tempfile.mkdtemp(prefix=f".{out.name}.old.", dir=out.parent))
            out.rename(old / "old")
            fresh.rename(out)
            shutil.rmtree(old)
        else:
            fresh.rename(out)
        fresh = None
    except OSError as error:
        raise InputError(f"--out {out}: cannot be written: {error.strerror}") from None
    finally:
        if fresh is not None:
            shutil.rmtree(fresh, ignore_errors=True)
