"""Reads the input: the folder of a run or a sweep, or a CSV file of a run, a replay, a trace or a drive's log."""

import csv
import json
import math
from array import array
from pathlib import Path

from .command_line import quoted
from .look import SIGNALS

MORE = ("t_s", "segment", "plant_n_N", "relative_variance_positive", "relative_variance_negative")


class PlotError(Exception):
    """An error, with a sentence for the user."""


class Run:
    """The columns to draw, by name. `summary` is that of tribo-sim run, or empty."""

    def __init__(self, name, columns, summary=None):
        self.name = name
        self.columns = columns
        self.summary = summary or {}

    def __contains__(self, column):
        return column in self.columns

    def __getitem__(self, column):
        return self.columns[column]

    def between(self, start_s, end_s):
        """Cuts the run to start_s..end_s; None keeps the run's own limit."""
        t = self["t_s"]
        kept = [i for i, time in enumerate(t) if (start_s is None or time >= start_s) and (end_s is None or time <= end_s)]
        if not kept:
            raise PlotError(f"{self.name}: nothing between --from and --to; it has {t[0]:g} to {t[-1]:g} s")
        kept = slice(kept[0], kept[-1] + 1)
        return Run(self.name, {name: values[kept] for name, values in self.columns.items()}, self.summary)


def is_sweep(path):
    return (path / "rows.parquet").is_file() or path.name == "rows.parquet"


def sweep_rows(path):
    return path if path.name == "rows.parquet" else path / "rows.parquet"


def read_all(paths):
    """Gives the runs distinct names."""
    runs = [read(path) for path in paths]
    for depth in (2, 3, 4):
        if len({run.name for run in runs}) == len(runs):
            break
        for path, run in zip(paths, runs):
            run.name = "/".join(path.resolve().parts[-depth:])
    return runs


def read(path):
    if path.is_dir():
        trace = path / "trace.csv"
        if not is_there(trace):
            raise PlotError(f"{path}: holds neither the trace.csv of a run nor the rows.parquet of a sweep")
        return Run(path.resolve().name, read_columns(trace), read_summary(path / "summary.json"))
    is_of_run = path.name == "trace.csv"
    return Run(
        path.resolve().parent.name if is_of_run else path.stem,
        read_columns(path),
        read_summary(path.parent / "summary.json") if is_of_run else None,
    )


def is_there(path):
    """Whether the file exists. A path that cannot be accessed is an error, not absent."""
    try:
        path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError as error:
        raise PlotError(f"{path}: {error.strerror}") from None
    return True


def read_summary(path):
    """Returns an empty summary if there is none."""
    if not is_there(path):
        return {}
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise PlotError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise PlotError(f"{path}: not as tribo-sim wrote it: {error}") from None
    if not isinstance(summary, dict) or not isinstance(summary.get("rms_error_N", 0.0), (int, float)):
        raise PlotError(f"{path}: not as tribo-sim wrote it: a summary is keys and values, and its rms_error_N a number")
    return summary


ALIKE_ROWS = 20


def form(number):
    """Digits behind the point, and of the exponent."""
    mantissa, _, exponent = number.lower().partition("e")
    return len(mantissa.partition(".")[2]), len(exponent.lstrip("+-"))


def check_end(path):
    """Refuses a file that ends in the middle of a number, by the rule of common/support/csv.h."""
    with open(path, "rb") as file:
        file.seek(max(file.seek(0, 2) - 65536, 0))
        *above, last = (line.rpartition(b",")[2].decode(errors="replace") for line in file.read().split(b"\n"))
    forms = {form(number.strip()) for number in above[-ALIKE_ROWS:]}
    is_short = len(above) > ALIKE_ROWS and len(forms) == 1 and any(mine < other for mine, other in zip(form(last), *forms))
    if last.endswith(".") or (last and is_short):
        raise PlotError(f"{path}: the file ends in the middle of the number '{last}'; cut its last row off, or log to the end of a row")


NUMBER_MAX = 1e30  # of common/support/csv.h


def number_of(text, where):
    """The number of a field. Raises PlotError, also for what Python alone takes for one."""
    try:
        value = float(text) if text else math.nan
    except ValueError:
        value = None
    if value is None or "_" in text:
        raise PlotError(f"{where}: {text[:40]!r} is not a number")
    if abs(value) > NUMBER_MAX:
        raise PlotError(f"{where}: {text[:40]} is outside -{NUMBER_MAX:g} to {NUMBER_MAX:g}")
    return value


def read_rows(path, file):
    """Returns the columns in the table of signals."""
    rows = csv.reader("\n" if line.startswith("#") else line for line in file)
    names = [name.strip() for name in next(filter(None, rows), [])]
    if not names:
        raise PlotError(f"{path}: is empty")
    wanted = [(i, name, array("d")) for i, name in enumerate(names) if name in SIGNALS or name in MORE]
    twice = next((name for i, name, _ in wanted if name in names[:i]), None)
    if twice:
        raise PlotError(f"{path}:{rows.line_num}: column {twice} appears twice")
    if "t_s" not in names or len(wanted) < 2:
        raise PlotError(
            f"{path}: a header with t_s and signals of tribo is expected; `tribo-sim log {quoted(path)} --column t=NAME ... "
            "--out clean.csv` makes one of a foreign log"
        )
    columns, last = {name: values for _, name, values in wanted}, -math.inf
    for row in filter(None, rows):
        where = f"{path}:{rows.line_num}"
        if len(row) <= wanted[-1][0] or any(row[len(names) :]):
            raise PlotError(f"{where}: {len(row)} fields, the header has {len(names)}")
        for i, name, values in wanted:
            values.append(number_of(row[i].strip(), f"{where}: {name}"))
        time = columns["t_s"][-1]
        if not time >= last:
            raise PlotError(f"{where}: t_s: {time:g} does not come after {last:g}" if math.isfinite(time) else f"{where}: t_s: is not a finite number")
        last = time
    return columns


def read_columns(path):
    """Returns the columns in the table of signals; an empty field is NaN."""
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            columns = read_rows(path, file)
        if path.is_file():  # not a pipe, which has been read
            check_end(path)
    except UnicodeDecodeError as error:
        raise PlotError(f"{path}: not UTF-8 text (byte {error.start}); save it as UTF-8") from None
    except (OSError, csv.Error) as error:
        raise PlotError(f"{path}: {getattr(error, 'strerror', None) or error}") from None
    if not columns["t_s"]:
        raise PlotError(f"{path}: has no rows")
    return columns
