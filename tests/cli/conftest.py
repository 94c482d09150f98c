"""Runs tribo-sim (its path is in TRIBO_SIM) and reads what it leaves."""

import csv
import io
import json
import os
import pathlib
import subprocess
import tarfile
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
VECTORS = ROOT / "tests" / "golden" / "vectors.tar.xz"
SCENARIOS = ROOT / "host_sim" / "scenarios"

# What compares the numbers of long runs. tools/check plays these with the optimised program alone, and the others, of messages, files and
# short runs, with the sanitizers alone.
numbers = pytest.mark.numbers

# The paper's method, by its name.
PAPER = ("--set", "compensator.method=paper", "--set", "compensator.guard.on=no")

# The shortest scenario there is; a test appends what it is about.
SHORT = "duration_s: 0.01\nreference: {kind: step}\n"


def pytest_configure(config):
    config.addinivalue_line("markers", "numbers: compares the numbers of long runs")


class Sim:
    """tribo-sim in a folder of its own."""

    def __init__(self, folder):
        self.folder = folder
        self.program = os.environ["TRIBO_SIM"]

    def write(self, name, content):
        path = self.folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def __call__(self, *arguments, **options):
        options.setdefault("cwd", self.folder)
        options.setdefault("stdout", subprocess.PIPE)
        return subprocess.run([self.program, *map(str, arguments)], stderr=subprocess.PIPE, text=True, timeout=1200,
                              check=False, **options)

    def ok(self, *arguments, **options):
        """A run that must succeed and say nothing on stderr."""
        result = self(*arguments, **options)
        assert result.stderr == ""
        assert result.returncode == 0
        return result.stdout

    def fails(self, message, *arguments, status=1, **options):
        """A run that must fail with exactly this message."""
        result = self(*arguments, **options)
        assert result.stderr == f"tribo-sim: {message}\n"
        assert result.returncode == status
        return result

    def summary(self, *arguments):
        return json.loads(self.ok("run", *arguments, "--json"))

    def trace(self, *arguments):
        self.ok("run", *arguments, "--out", "trace_of_run")
        return read_csv(self.folder / "trace_of_run" / "trace.csv")


def until(has_happened, what, limit_s=200):
    """Waits for it. The limit is for what never happens, and far beyond what a loaded machine takes."""
    end = time.monotonic() + limit_s
    while not has_happened():
        assert time.monotonic() < end, what
        time.sleep(0.005)


def processor_s(process):
    """The processor time that a process has taken so far."""
    fields = pathlib.Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def read_csv(path):
    """Columns of numbers by name."""
    with open(path, newline="", encoding="ascii") as file:
        return _columns(file)


def read_vectors(name):
    """Likewise, of golden vectors."""
    with tarfile.open(VECTORS) as archive, io.TextIOWrapper(archive.extractfile(f"{name}.csv"), "ascii", newline="") as file:
        return _columns(file)


def _columns(file):
    rows = csv.reader(file)
    names = next(rows)
    columns = list(zip(*[[float(value) for value in row] for row in rows]))
    return dict(zip(names, columns))


@pytest.fixture
def sim(tmp_path):
    return Sim(tmp_path)
