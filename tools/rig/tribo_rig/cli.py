"""tribo-rig: the whole way from a rig to its loop. Looks at what the folder has, goes on from there, and says what to play next.

    FOLDER/rig.yaml            what is known of the rig; written to be filled in, if it is not there
    FOLDER/1-ramp.csv          to play; its log goes to 1-ramp-log.csv
    FOLDER/2-slides.csv        to play; its log goes to 2-slides-log.csv
    FOLDER/result/             the loop: header for the drive, loop.yaml, registers.txt, report.html

The files are the whole state: remove a log, and that step is done again.
"""

import argparse
import hashlib
from pathlib import Path

from tribo_design.errors import InputError, run_command
from tribo_plot.version import add_option

NAMES = ("report.html", "loop.yaml", "*_params.h", "registers.txt", "verdict.json")


def main(argv=None):
    return run_command("tribo-rig", _run, argv)


def _run(argv):
    parser = argparse.ArgumentParser(prog="tribo-rig", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", help="where rig.yaml is, or where it shall be")
    add_option(parser, "tribo-rig")
    folder = Path(parser.parse_args(argv).folder)
    from tribo_design.reading import is_there

    from . import rig as rigs

    path = folder / "rig.yaml"
    if not is_there(path):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            path.write_text(rigs.TEMPLATE.read_text(encoding="utf-8"), encoding="utf-8")
        except OSError as error:
            raise InputError(f"{path}: cannot be written: {error.strerror}") from None
        return _say(f"Wrote {path}: fill in its sample time and safe forces.", f"Then run: tribo-rig {folder}")
    return _go_on(folder, rigs.load(path))


def _say(*lines):
    print("\n".join(lines))
    return 0


def _go_on(folder, rig):
    from tribo_design.output import check_replaceable, write_directory

    from . import experiments

    ramp = experiments.ramp(rig)
    log = _log(folder, ramp, rig, "Slowly up and down, to half of the safe forces: keep a hand on the emergency stop.")
    if log is None:
        return 0
    first = experiments.of_ramp(log, rig.assume)
    slides = experiments.slides(rig, first)
    print(f"1-ramp: a newton of command makes {first.scale:.4g} N; friction about {first.offset:.3g} N + {first.slope:.3g} |F|, noise {first.noise:.2g} N")
    log = _log(folder, slides, rig, "Steps and slow slides, within the safe forces by what the ramp has told.")
    if log is None:
        return 0
    check_replaceable(folder / "result", NAMES)
    from . import results

    digest = hashlib.sha256(b"".join((folder / name).read_bytes() for name in ("rig.yaml", "1-ramp-log.csv", "2-slides-log.csv"))).hexdigest()
    files, lines = results.of(rig, first, slides, log, digest)
    write_directory(folder / "result", files, NAMES)
    return _say(*lines, f"Wrote {folder / 'result'}: {', '.join(sorted(files))}")


def _log(folder, made, rig, what):
    """The log of an experiment; None where it is still to be played, which is said then."""
    from tribo_design.reading import is_there
    from tribo_identify import logs

    from . import experiments

    played, path = folder / f"{made.name}.csv", folder / f"{made.name}-log.csv"
    if not is_there(path):
        played.write_text(made.csv(rig.command_per_N), encoding="ascii")
        _say(f"Play {played}, a row each {rig.sample_time_s:g} s for {made.time[-1]:.0f} s, as the command: {min(made.u):.3g} to {max(made.u):.3g} N. {what}",
             f"Put the log (time, command, force; a row each tick) to {path}, then run: tribo-rig {folder}")
        return None
    return experiments.aligned(logs.read([path], rig.words()), made, path)
