"""Reads logs with `tribo-sim log`, which uses the reader and the options of replay."""

import os
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from . import native, rows

OPTIONS = ("column", "unit", "scale", "bias")
COLUMNS = {"t_s": "t", "u_N": "u", "F_N": "force", "x_deg": "position", "w_deg_per_s": "speed", "r_N": "reference"}


@dataclass
class Segment:
    file: str
    t: np.ndarray
    u: np.ndarray
    force: np.ndarray | None = None
    position: np.ndarray | None = None
    speed: np.ndarray | None = None
    reference: np.ndarray | None = None
    h: float = 0.0


@dataclass
class Log:
    segments: list
    sample_time_s: float
    remarks: list = field(default_factory=list)
    time_unit: str | None = None  # of its stamps, as the user gave it

    @property
    def rows(self):
        return sum(len(s.t) for s in self.segments)


def arguments_of(options, needs_u=True):
    words = ["--column", "u=u_N"] if needs_u and not any(value.startswith("u=") for value in options.column) else []
    for name in OPTIONS:
        for value in getattr(options, name):
            words += [f"--{name}", os.fsencode(value).decode("utf-8", "surrogateescape")]  # as typed, in every locale
    if options.resample is not None:
        words.append("--resample" + (f"={options.resample}" if options.resample else ""))
    if options.gap:
        words += ["--gap", options.gap]
    return words


def read(paths, words=()):
    """Reads each segment of each file; all belong to one experiment."""
    segments, remarks = [], []
    for path in paths:
        with tempfile.TemporaryDirectory() as folder:
            clean = Path(folder) / "clean.csv"
            _, said = native.run_tribo_sim("log", Path(path), *words, "--out", clean)
            remarks += said.strip().splitlines()
            with open(clean, encoding="ascii") as file:
                names = file.readline().strip().split(",")
            table = np.loadtxt(clean, delimiter=",", skiprows=1, ndmin=2)
        for number in np.unique(table[:, -1]):
            mine = table[table[:, -1] == number]
            columns = {COLUMNS[n]: np.ascontiguousarray(mine[:, i]) for i, n in enumerate(names[:-1])}
            t = columns["t"]
            segments.append(Segment(file=Path(path).name, h=float((t[-1] - t[0]) / (len(t) - 1)), u=columns.pop("u", np.zeros(len(t))), **columns))
    segments, said = rows.mended(segments)
    unit = next((value.removeprefix("t=") for word, value in zip(words, words[1:]) if word == "--unit" and value.startswith("t=")), None)
    return Log(segments, float(np.median([s.h for s in segments])), remarks + said, unit)
