"""tribo-rig: from a rig to its loop. It continues from what the folder contains, and says what to play next.

    FOLDER/rig.yaml            data of the rig; if missing, it is written for you to fill in
    FOLDER/1-ramp.csv          to play; save its log as 1-ramp-log.csv
    FOLDER/2-slides.csv        to play; save its log as 2-slides-log.csv
    FOLDER/result/             the loop: header for the drive, loop.yaml, registers.txt, report.html

The files are the whole state: remove a log to repeat its step.

A joint without a force sensor has its own folder, made by --joint:

    FOLDER/joint.yaml          data of the joint; if missing, it is written for you to fill in
    FOLDER/*-log.csv           effort and position, a sine and steps under your own loop
    FOLDER/result/             friction with intervals, and the code that compensates it
"""

import argparse
import hashlib
import re
from pathlib import Path

from tribo_design.errors import DesignError, InputError, run_command
from tribo_plot import output
from tribo_plot.command_line import Parser, quoted
from tribo_plot.version import add_option

NAMES = ("report.html", "loop.yaml", "*_params.h", "registers.txt", "verdict.json")


# Options of tribo-identify and tribo-sim, as rig.yaml and joint.yaml have them. u has been compared with the command that was played, so only F can be in another unit.
WORDS = (
    (r"--unit u=mN", r"log.units: {F: kN}"),
    (r"--scale u=([\d.e+-]+) makes", lambda found: f"log.scales: {{F: {1 / float(found[1]):.2g}}} makes"),
    (r"--scale u=-(?![\d.])", r"command_per_N with the other sign"),
    (r"--scale (\w)=-(?![\d.])", r"log.scales: {\1: -1}"),
    (r"--(unit|scale|column) (\w)=(m?N m|[^\s,;)]*[^\s,;):])", r"log.\1s: {\2: \3}"),
    (r"--resample(=[\d.]+)?", r"log.resample: yes"),
    (r"^--out ", r""),
    (r"give an empty or a new directory$", r"move them elsewhere"),
)


def in_yaml(text):
    for option, key in WORDS:
        text = re.sub(option, key, text)
    return text


def main(argv=None):
    return run_command("tribo-rig", _advised, argv)


def _advised(argv):
    """Errors of tribo-identify and tribo-sim advise options that this program does not have."""
    try:
        return _run(argv)
    except DesignError as error:
        error.args = (in_yaml(str(error)), *error.args[1:])
        raise


def _run(argv):
    parser = Parser(prog="tribo-rig", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", help="the folder of rig.yaml; it is written there if missing")
    parser.add_argument("--joint", action="store_true", help="a joint with current and encoder, without a force sensor")
    add_option(parser, "tribo-rig")
    options = parser.parse_args(argv)
    folder = Path(options.folder)
    from tribo_design.reading import is_there

    from . import joint as joints
    from . import rig as rigs

    path = folder / "rig.yaml"
    if not options.folder or is_there(folder) and not folder.is_dir():
        raise InputError(f"FOLDER: value {options.folder!r}: must be a folder, or a name that does not exist")
    if options.joint and is_there(path):
        raise InputError(f"{path}: this folder belongs to a force axis; a joint needs its own folder")
    if options.joint or is_there(folder / "joint.yaml") and not is_there(path):
        if not is_there(folder / "joint.yaml"):
            return _begin(folder / "joint.yaml", joints.TEMPLATE, "its sample time and the limit of its effort")
        return joints.go_on(folder, _say)
    if not is_there(path):
        return _begin(path, rigs.TEMPLATE, "its sample time and safe forces")
    return _go_on(folder, rigs.load(path))


def _begin(path, template, what):
    try:
        with output.folder(path.parent):
            output.write(path, template.read_text(encoding="utf-8"))
    except output.PlaceError:
        raise
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from None
    return _say(f"Wrote {path}: fill in {what}.", f"Then run: tribo-rig {quoted(path.parent)}")


def _say(*lines):
    print("\n".join(lines))
    return 0


def _go_on(folder, rig):
    from tribo_design.output import check_replaceable, write_directory

    from . import experiments

    check_replaceable(folder / "result", NAMES)
    ramp = experiments.ramp(rig)
    log = _log(folder, ramp, rig, "It goes slowly up and down, to half of the safe forces: keep a hand on the emergency stop.")
    if log is None:
        return 0
    first = experiments.of_ramp(log, rig.assume)
    slides = experiments.slides(rig, first)
    print(f"1-ramp: a newton of command makes {first.scale:.4g} N; friction about {first.offset:.3g} N + {first.slope:.3g} |F|, noise {first.noise:.2g} N")
    log = _log(folder, slides, rig, "Steps and slow slides, which stay within the safe forces by the scale from the ramp.")
    if log is None:
        return 0
    from . import results

    digest = hashlib.sha256(b"".join((folder / name).read_bytes() for name in ("rig.yaml", "1-ramp-log.csv", "2-slides-log.csv"))).hexdigest()
    files, lines = results.of(rig, first, slides, log, digest)
    write_directory(folder / "result", files, NAMES)
    return _say(*lines, f"Wrote {folder / 'result'}: {', '.join(sorted(files))}")


def _log(folder, made, rig, what):
    """The log of an experiment, or None with a message if it is still to be played."""
    from tribo_design.reading import is_there
    from tribo_identify import logs

    from . import experiments

    played, path = folder / f"{made.name}.csv", folder / f"{made.name}-log.csv"
    if not is_there(path):
        output.write(played, made.csv(rig.command_per_N))
        _say(f"Play {played} as the command, one row every {rig.sample_time_s:g} s for {made.time[-1]:.0f} s: {min(made.u):.3g} to {max(made.u):.3g} N. {what}",
             f"Save the log (time, command, force; one row per tick) as {path}, then run: tribo-rig {quoted(folder)}")
        return None
    return experiments.aligned(logs.read([path], rig.words()), made, path)
