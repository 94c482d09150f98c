"""The command line of tribo-plot."""

import importlib.util
import math
import sys
from pathlib import Path

from . import output, panels, runs
from .command_line import Parser
from .runs import PlotError
from .version import add_option

SUFFIXES = (".png", ".svg", ".html", ".mcap")


def parse(arguments):
    parser = Parser(
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


def check_effects(options, is_sweep):
    """Refuses options that would change nothing in the picture."""
    for name, value in (("from", options.start_s), ("to", options.end_s)):
        if value is not None and not math.isfinite(value):
            raise PlotError(f"--{name} {value:g}: a time in s is expected")
    if options.start_s is not None and options.end_s is not None and not options.start_s < options.end_s:
        raise PlotError(f"--from {options.start_s:g} --to {options.end_s:g}: the first time must be the smaller one")
    given = [name for name, is_given in (("from", options.start_s is not None), ("to", options.end_s is not None), ("name", options.name), ("all", options.all)) if is_given]
    if is_sweep and given:
        raise PlotError(f"--{given[0]}: a sweep has neither times nor runs to name, and is drawn whole")
    if options.all and options.out.suffix == ".mcap":
        raise PlotError("--all: an .mcap file has all columns without it")
    if len(options.name) > len(options.paths):
        raise PlotError(f"--name {options.name[len(options.paths)]}: there are {len(options.name)} names for {len(options.paths)} run{'s' * (len(options.paths) > 1)}")


def draw(options):
    if options.out.suffix not in SUFFIXES:
        raise PlotError(f"--out {options.out}: a name that ends in {', '.join(SUFFIXES)} is expected")
    for path in options.paths:
        if not runs.is_there(path):
            raise PlotError(f"{path}: there is none")
        if path.is_file() and options.out.exists() and path.samefile(options.out):
            raise PlotError(f"--out {options.out} is the same file as {path}")
    output.check_place(options.out)
    are_sweeps = [runs.is_sweep(path) for path in options.paths]
    if any(are_sweeps) and len(options.paths) > 1:
        raise PlotError("a sweep is drawn alone")
    check_effects(options, any(are_sweeps))
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
    with output.replaced(options.out) as new:
        _draw_into(options, any(are_sweeps), new)


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
    return output.run("tribo-plot", _main, arguments)


def _main(arguments):
    options = parse(arguments)
    try:
        draw(options)
    except (PlotError, output.PlaceError) as error:
        print(f"tribo-plot: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    return 0
