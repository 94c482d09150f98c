"""The version of tribo, for the tools in Python: from the headers next to them, in the tree or installed, or from the Python package."""

import argparse
import importlib.metadata
from pathlib import Path

TOOLS = Path(__file__).resolve().parents[1]
HEADERS = (TOOLS.parent / "lib/include", TOOLS.parent / "fmu/lib/include", TOOLS.parents[2] / "include") if TOOLS.name == "tools" else ()


def version():
    for folder in HEADERS:
        header = folder / "tribo/status.h"
        if header.exists():
            return next(line.split('"')[1] for line in header.read_text(encoding="utf-8").splitlines() if "TRIBO_VERSION_STRING" in line)
    return importlib.metadata.version("tribo")


def add_option(parser, name):
    """Adds --version for the program `name`."""
    parser.add_argument("--version", action=Version, nargs=0, name=name, help="of this program")


class Version(argparse.Action):
    """Looks the version up only on request."""

    def __init__(self, *, name, **rest):
        super().__init__(**rest)
        self.name = name

    def __call__(self, parser, *_):
        print(self.name, version())
        parser.exit()


if __name__ == "__main__":
    print(version())
