"""A picture that cannot be drawn loses nothing; tests/plot is of those that can."""

import os
import subprocess

import pytest


def without_python(sim):
    (sim.folder / "tmp").mkdir(exist_ok=True)
    return {**os.environ, "TRIBO_PYTHON": "/none", "TMPDIR": str(sim.folder / "tmp")}


MISSING = ("tribo-plot: needs Python 3.9 or later (/none): `tools/setup plot` or `apt install python3 python3-matplotlib` installs it\n"
           "tribo-sim: there is no picture, but nothing is lost: tribo-sim plot {} --out a.png draws it\n")


def test_without_python_the_run_is_there_and_the_message_says_what_to_install(sim):
    result = sim("run", "step", "--out", "o", "--plot", "a.png", env=without_python(sim))
    assert result.returncode == 1 and result.stderr == MISSING.format("o")
    assert "RMS error" in result.stdout
    assert {"trace.csv", "summary.json"} <= {path.name for path in (sim.folder / "o").iterdir()}
    assert not (sim.folder / "a.png").exists()


def test_the_command_that_draws_later_is_one_for_a_shell(sim):
    result = sim("run", "step", "--out", "my run", "--plot", "a.png", env=without_python(sim))
    assert result.stderr == MISSING.format("'my run'")


@pytest.mark.parametrize("out", ["it's", "'", "-e", "-it's", "a\\b", "$HOME", "~", "#a", "a=b", "größe", "*"])
def test_a_shell_hands_the_command_that_draws_later_to_the_same_folder(sim, out):
    result = sim("run", "step", f"--out={out}", "--plot=-p.png", env=without_python(sim))
    command = result.stderr.partition("nothing is lost: ")[2].removesuffix(" draws it\n")
    words = subprocess.run(["sh", "-c", f"printf '%s\\0' {command}"], stdout=subprocess.PIPE, check=True, cwd=sim.folder).stdout.decode().split("\0")
    assert words == ["tribo-sim", "plot", f"./{out}" if out[0] == "-" else out, "--out", "./-p.png", ""]
    assert sim(*words[1:-1], env=without_python(sim)).returncode == 1  # not 2: the command line is right, and Python is missing
    assert (sim.folder / words[2] / "trace.csv").exists()


def test_a_run_without_a_folder_is_kept_until_it_is_drawn(sim):
    result = sim("run", "step", "--plot", "a.png", env=without_python(sim))
    (kept,) = (sim.folder / "tmp").iterdir()
    assert result.returncode == 1 and result.stderr == MISSING.format(kept)
    assert {"trace.csv", "summary.json"} <= {path.name for path in kept.iterdir()}


def test_a_replay_is_kept_until_it_is_drawn(sim):
    sim.ok("run", "triangle", "--set", "duration_s=6", "--set", "reference.period_s=2", "--set", "metrics.start_s=2", "--out", "o")
    result = sim("replay", "o/trace.csv", "--plot", "a.png", env=without_python(sim))
    (kept,) = (sim.folder / "tmp").iterdir()
    assert result.returncode == 1 and result.stderr.endswith(MISSING.format(kept / "replay.csv"))
    assert "verdict" in result.stdout
    header = (kept / "replay.csv").read_text().split("\n", 1)[0].split(",")
    assert header[-3:] == ["F_N", "residual_N", "r_N"]


def test_a_run_that_fails_leaves_no_folder(sim):
    result = sim("run", "step", "--set", "duration_s=-1", "--plot", "a.png", env=without_python(sim))
    assert result.returncode == 1 and "duration_s" in result.stderr
    result = sim("run", "triangle", "--set", "controller={kind: z, sections: [{b0: 1, b1: 0, b2: 0, a1: 5, a2: 0}]}", "--plot", "a.png",
                 env=without_python(sim))
    assert result.returncode == 1
    assert not list((sim.folder / "tmp").iterdir())


def test_a_program_that_stands_alone_names_the_tool_that_it_misses(sim):
    import shutil

    alone = sim.folder / "bin" / "tribo-sim"
    alone.parent.mkdir()
    shutil.copy(sim.program, alone)
    sim.write("o.csv", "t_s,F_N\n0,1\n")
    sim.program = alone
    result = sim("plot", "o.csv", "--out", "a.png")
    assert result.returncode == 1
    assert result.stderr == f"tribo-sim: {sim.folder}/bin/../share/tribo/tools/tribo-plot: cannot be started: No such file or directory\n"
