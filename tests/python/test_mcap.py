"""What tribo-plot writes as MCAP is what the run's trace says, read by mcap's own reader."""

import csv
import json
import os
import pathlib
import subprocess
import sys

import pytest
from mcap.reader import make_reader

SIM = os.environ["TRIBO_SIM"]
PLOT = pathlib.Path(__file__).resolve().parents[2] / "tools/tribo-plot"


def plot(*words):
    return subprocess.run([PLOT, *words], capture_output=True, text=True, check=False, env={**os.environ, "TRIBO_PYTHON": sys.executable})


@pytest.fixture(name="folder", scope="module")
def _folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    for name, gain in (("on", "0.9"), ("off", "0")):
        words = ("--set", "duration_s=1", "--set", "metrics.start_s=0.5", "--set", f"compensator.gain={gain}", "--out", folder / name)
        subprocess.run([SIM, "run", "triangle", *words], check=True, capture_output=True)
    return folder


def test_each_run_is_a_channel_with_all_its_rows(folder):
    done = plot(folder / "on", folder / "off", "--from", "0.25", "--out", folder / "both.mcap")
    assert done.returncode == 0, done.stderr
    read = {"/on": [], "/off": []}
    with open(folder / "both.mcap", "rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            row = json.loads(message.data)
            assert set(row) == set(json.loads(schema.data)["properties"]) and message.log_time == round(1e9 * row["t_s"])
            read[channel.topic].append(row)
    for topic, rows in read.items():
        with open(folder / topic[1:] / "trace.csv", newline="", encoding="utf-8") as file:
            trace = [row for row in csv.DictReader(file) if float(row["t_s"]) >= 0.25]
        assert len(rows) == len(trace) == 750
        assert {"r_N", "F_N", "u_N"} <= set(rows[0])
        assert all(row[name] == float(of_trace[name]) for row, of_trace in zip(rows, trace) for name in row if row[name] is not None)


def test_a_time_before_0_and_a_sweep_are_refused(folder):
    (folder / "early.csv").write_text("t_s,F_N\n-0.001,1\n0,1\n")
    early = plot(folder / "early.csv", "--out", folder / "early.mcap")
    assert early.returncode == 1 and "t_s is -0.001 s" in early.stderr and not list(folder.glob("*early.*mcap"))
    (folder / "sweep").mkdir()
    (folder / "sweep/rows.parquet").write_bytes(b"PAR1")
    sweep = plot(folder / "sweep", "--out", folder / "sweep.mcap")
    assert sweep.returncode == 1 and "no rows over time" in sweep.stderr
