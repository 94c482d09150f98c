"""Plays a study: a scenario many times, with other values of its keys each time. After a kill the same command continues."""

import argparse
import re
import sys
from pathlib import Path

from . import output
from .command_line import Parser
from .runs import PlotError
from .version import add_option

PROGRAM = "tribo-sweep"
REPORT = ("report.md", "ratio.png", "rms.png", "chatter.png")
QUANTILES = (0, 0.05, 0.25, 0.5, 0.75, 0.95, 1)


def shard_of(text):
    found = re.fullmatch(r"(\d+)/(\d+)", text, re.ASCII)
    if not found:
        raise argparse.ArgumentTypeError(f"{text}: I/N is expected")
    return int(found[1]), int(found[2])


def parse(arguments):
    parser = Parser(prog=PROGRAM, description=__doc__)
    parser.add_argument("study", metavar="STUDY", help="a study's file, or the name of one that came with tribo")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where DIR/rows.parquet goes; rows that are there already are not played again")
    parser.add_argument("--workers", type=int, metavar="N", help="how many runs at a time; one for each core if left out")
    parser.add_argument("--shard", type=shard_of, metavar="I/N", help="plays the I-th of N parts alone; the command without it gathers them")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="plays the rows on the workers of this scheduler of dask.distributed")
    parser.add_argument("--report", action="store_true", help="also writes DIR/report.md, with tables and pictures")
    parser.add_argument("--row", type=int, metavar="ROW", help="plays nothing, prints the commands that play this row")
    add_option(parser, PROGRAM)
    options = parser.parse_args(arguments)
    if (options.out is None) == (options.row is None):
        parser.error("--out DIR or --row ROW is expected, one of them")
    if options.report and options.shard:
        parser.error("--report is of all rows, --shard of some")
    if options.row is not None:
        for name in ("workers", "shard", "scheduler", "report"):
            if getattr(options, name):
                parser.error(f"--{name}: --row plays nothing")
    if options.workers is not None and options.scheduler:
        parser.error("--workers is of this machine, --scheduler has its own")
    return options


def show(frame):
    """Prints quantiles of the measures."""
    measures = [name for name in frame.columns if re.fullmatch(r"(without_)?\w+(_N|_ratio|_ticks|_switches|_inputs)|ratio", name) and name not in frame.attrs["axes"]]
    table = frame[measures].quantile(list(QUANTILES)).T
    table.columns = [f"{100 * q:g} %" for q in QUANTILES]
    print(table.to_string(float_format=lambda value: f"{value:.5g}"))
    if "ratio" in frame:
        worse = int((frame["ratio"] < 1).sum())
        print(f"worse than without: {worse} of {frame['ratio'].count()} rows")
    for name, rows in frame.attrs["worst"].items():
        if rows:
            print(f"worst {name}, {rows[0]['value']:.4g} in row {rows[0]['row']}:\n  {rows[0]['command']}")


def play(options):
    import tribo

    study = tribo.Study(options.study)
    if options.row is not None:
        print("\n".join(study.command(options.row, without) for without in ((False, True) if study.is_paired else (False,))))
        return 0
    client = None
    if options.scheduler:
        import distributed

        client = distributed.Client(options.scheduler)
    for path in (options.out / name for name in REPORT if options.report):
        if path.exists():
            output.check_place(path)
    frame = tribo.sweep(study, options.out, workers=options.workers, shard=options.shard, executor=client)
    show(frame)
    if options.shard is None:
        written = tribo.sweep_report(frame, options.out) if options.report else []
        print("written:", ", ".join(map(str, [options.out / "rows.parquet", *written])))
    failed = frame[frame["status"] != "ok"]
    if len(failed):
        first = failed.iloc[0]
        print(f"{PROGRAM}: {len(failed)} of {len(frame)} rows failed, the first: row {first['row']}: {first['status']}: {first['message']}", file=sys.stderr)
    return 1 if len(failed) else 0


def main(arguments=None):
    return output.run(PROGRAM, _main, arguments)


def _main(arguments):
    options = parse(arguments)
    try:
        return play(options)
    except (ValueError, OSError, ImportError, PlotError) as error:
        if isinstance(error, OSError) and output.is_lost(error):
            raise
        print(f"{PROGRAM}: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print(f"{PROGRAM}: interrupted; the same command goes on from here", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
