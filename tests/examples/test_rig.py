"""The params of examples/rig are those of its scenarios, which compensate as well as the paper's rig does."""

import json
import os
import pathlib
import subprocess

import pytest

RIG = pathlib.Path(__file__).resolve().parents[2] / "examples" / "rig"
HEADERS = sorted(RIG.glob("*.h"))


def sim(*arguments):
    return subprocess.run([os.environ["TRIBO_SIM"], *map(str, arguments)], stdout=subprocess.PIPE, text=True, timeout=300, check=True).stdout


@pytest.mark.parametrize("header", HEADERS, ids=[path.stem for path in HEADERS])
def test_headers_are_current(header):
    scenario, arithmetic = header.stem.rsplit("_", 1)
    assert sim("params", RIG / f"{scenario}.yaml", "--name", "rig", "--arith", arithmetic) == header.read_text()


@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
def test_the_stm32f405s_rig_is_the_same_loop(arithmetic):
    """tests/firmware/test_convert.c has it by the examples' headers; only the heads, with names of files, differ."""
    board = RIG.parents[1] / "firmware" / "port" / "stm32f405" / "rig.yaml"
    one, other = (sim("params", path, "--name", "rig", "--arith", arithmetic).partition("#ifndef") for path in (board, RIG / "rig_1khz.yaml"))
    assert one[1:] == other[1:] and len(one[2]) > 1000


@pytest.mark.parametrize("scenario", sorted(RIG.glob("*.yaml")), ids=lambda path: path.stem)
def test_rigs_compensate(scenario):
    fed = json.loads(sim("run", scenario, "--json"))
    bare = json.loads(sim("run", scenario, "--json", "--set", "compensator.method=off", "--set", "compensator.guard.on=no"))
    assert fed["guard"] == "none"
    assert fed["rms_error_N"] < 0.15e-3
    assert bare["rms_error_N"] > 3e-3
