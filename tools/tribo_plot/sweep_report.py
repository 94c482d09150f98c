"""Pictures and tables of a sweep, beside what `tribo-sim sweep STUDY.yaml --out DIR` wrote there: report.md (a table for each axis, the worst
rows with the commands that play them), and ratio, rms and chatter as .png."""

import argparse
import sys
from pathlib import Path

from .runs import PlotError
from .version import add_option


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="tribo-sweep-report", description=__doc__)
    parser.add_argument("folder", type=Path, metavar="DIR", help="of the sweep")
    add_option(parser, "tribo-sweep-report")
    folder = parser.parse_args(arguments).folder
    from . import sweeps

    try:
        written = sweeps.report(folder)
    except PlotError as error:
        print(f"tribo-sweep-report: {error}", file=sys.stderr)
        return 1
    print(f"written: {', '.join(written)} in {folder}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
