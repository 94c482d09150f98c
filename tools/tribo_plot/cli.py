"""The command line of tribo-plot."""

import argparse
import importlib.util
import os
import sys
from pathlib import Path

from . import panels, runs
from .runs import PlotError
from .version import add_option

SUFFIXES = (".png", ".svg", ".html", ".mcap")


def parse(arguments):
    parser = argparse.ArgumentParser(
        prog="tribo-plot",
        description="Draws runs, replays, sweeps, traces and logs of a drive; several of them on top of each other.",
    )
    parser.add_argument("paths", nargs="+", type=Path, metavar="DIR|CSV", help="the folder of a run or a sweep, or a CSV file")
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="what to write: .png, .svg, .html, which zooms, or .mcap, a log for Foxglove and PlotJuggler")
    parser.add_argument("--from", dest="start_s", type=float, metavar="S", help="draws from this time on")
    parser.add_argument("--to", dest="end_s", type=float, metavar="S", help="draws until this time")
    parser.add_argument("--name", action="append", default=[], metavar="TEXT", help="what to call a run; the first is the first run's")
    parser.add_argument("--all", action="store_true", help="what was learned, relays, position and friction over net force, too; without it a loop's force, error and command")
    add_option(parser, "tribo-plot")
    return parser.parse_args(arguments)


def labels_of(all_runs):
    """Names of the runs, with their error if a summary has it."""
    rms = [run.summary.get("rms_error_N") for run in all_runs]
    return [run.name + (f": RMS error {1e3 * error:.4g} mN" if error is not None else "") for run, error in zip(all_runs, rms)]


def best_first(all_runs):
    """Puts the first run in front, as the strong line."""
    if not all("rms_error_N" in run.summary for run in all_runs):
        return all_runs
    return sorted(all_runs, key=lambda run: run.summary["rms_error_N"])


def draw(options):
    if options.out.suffix not in SUFFIXES:
        raise PlotError(f"--out {options.out}: a name that ends in {', '.join(SUFFIXES)} is expected")
    if not options.out.absolute().parent.is_dir():
        raise PlotError(f"--out {options.out}: there is no such folder")
    for path in options.paths:
        if not runs.is_there(path):
            raise PlotError(f"{path}: there is none")
        if path.is_file() and options.out.exists() and path.samefile(options.out):
            raise PlotError(f"--out {options.out} is the same file as {path}")
    are_sweeps = [runs.is_sweep(path) for path in options.paths]
    if any(are_sweeps) and len(options.paths) > 1:
        raise PlotError("a sweep is drawn alone")
    if options.out.suffix == ".mcap":
        if any(are_sweeps):
            raise PlotError(f"--out {options.out}: a sweep has no rows over time; .png, .svg or .html shows it")
        if importlib.util.find_spec("mcap") is None:
            raise PlotError(f"{sys.executable} has no mcap, which writes .mcap: TRIBO_PYTHON names a Python with `pip install mcap`")
    elif (options.out.suffix != ".html" or any(are_sweeps)) and importlib.util.find_spec("matplotlib") is None:
        raise PlotError(
            f"{sys.executable} has no matplotlib, which draws {options.out.suffix}: `tools/setup plot` or `apt install "
            "python3-matplotlib` installs it, in an environment of your own `pip install matplotlib`"
        )
    # Under another name until it is whole.
    temporary = options.out.with_name(f".{options.out.stem}.{os.getpid()}{options.out.suffix}")
    try:
        _draw_into(options, any(are_sweeps), temporary)
        temporary.replace(options.out)
    except OSError as error:
        raise PlotError(f"{options.out}: cannot be written: {error.strerror}") from None
    finally:
        temporary.unlink(missing_ok=True)


def _draw_into(options, is_sweep, out):
    if is_sweep:
        from . import sweeps

        sweeps.draw(runs.sweep_rows(options.paths[0]), out)
        return
    all_runs = runs.read_all(options.paths)
    for run, name in zip(all_runs, options.name):
        run.name = name
    if options.start_s is not None or options.end_s is not None:
        all_runs = [run.between(options.start_s, options.end_s) for run in all_runs]
    if out.suffix == ".mcap":
        from .mcap_file import write

        write(all_runs, out)
        return
    all_runs = best_first(all_runs)
    made = panels.make(all_runs, options.all)
    if out.suffix == ".html":
        from .page import draw as draw_them
    else:
        from .pictures import draw as draw_them
    draw_them(labels_of(all_runs), made, out)


def main(arguments=None):
    options = parse(arguments)
    try:
        draw(options)
    except PlotError as error:
        print(f"tribo-plot: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    return 0
