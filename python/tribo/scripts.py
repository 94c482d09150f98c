"""Runs the scripts tribo-demo-drive and tribo-fmu of an installed package."""

import os
import sys
from pathlib import Path


def demo_drive() -> None:
    _run("demo-drive")


def fmu() -> None:
    _run("tribo-fmu")


def _run(name: str) -> None:
    """Finds the script from the command's path, because a user installation is not in sys.prefix."""
    script = Path(sys.argv[0]).resolve().parents[1] / "share/tribo/tools" / name
    if not script.exists():
        sys.exit(f"{Path(sys.argv[0]).name}: {script} is missing: this package does not include it")
    os.execv(sys.executable, [sys.executable, "-B", str(script), *sys.argv[1:]])
