"""Runs of tribo-sim (its path is in TRIBO_SIM) to be drawn, each played once."""

import os
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

SHORT = ("--set", "duration_s=6", "--set", "reference.period_s=2", "--set", "metrics.start_s=2")


def sim(*arguments, **options):
    return subprocess.run([os.environ["TRIBO_SIM"], *map(str, arguments)], capture_output=True, text=True, check=False, timeout=600, **options)


def done(result):
    assert result.returncode == 0, result.stderr
    return result


@pytest.fixture(scope="session")
def runs(tmp_path_factory):
    """Folders of the triangle by each method, and a replay of one of them."""
    folder = tmp_path_factory.mktemp("runs")
    for method in ("off", "paper", "feedforward"):
        done(sim("run", "triangle", *SHORT, "--set", f"compensator.method={method}", "--out", folder / method))
    (folder / "log.csv").write_text(
        "t_s,u_N,F_N\n" + "".join(",".join(row.split(",")[i] for i in (0, 7, 3)) + "\n" for row in (folder / "paper/trace.csv").read_text().split()[1:]),
        encoding="ascii",
    )
    done(sim("replay", folder / "log.csv", "--out", folder / "replay.csv"))
    (folder / "drive.csv").write_text(
        "t_s,r_N,F_N,u_N,state,fault,limits,late_us,step_us\n"
        + "".join(f"{0.001 * i:.3f},0.5,{0.5 - 0.001 * (i % 7)},0.6,1,0,0,{i % 5},{10 + i % 3}\n" for i in range(500)),
        encoding="ascii",
    )
    return folder
