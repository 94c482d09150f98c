"""tribo-demo-drive and tribo-fmu of an installed package: the scripts that came with it."""

import os
import sys
from pathlib import Path


def demo_drive() -> None:
    _run("demo-drive")


def fmu() -> None:
    _run("tribo-fmu")


def _run(name: str) -> None:
    """Found from the command, as an installation of a user's own is not in sys.prefix."""
    script = Path(sys.argv[0]).resolve().parents[1] / "share/tribo/tools" / name
    if not script.exists():
        sys.exit(f"{Path(sys.argv[0]).name}: there is no {script}: it is not made for this machine")
    os.execv(sys.executable, [sys.executable, "-B", str(script), *sys.argv[1:]])
