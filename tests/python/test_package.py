"""Doctests, types, and the tools that are installed with it."""

import doctest
import pathlib
import subprocess
import sys

import pytest

import tribo

ROOT = pathlib.Path(__file__).resolve().parents[2]


def test_doctests():
    tested = doctest.testmod(tribo, extraglobs={"tribo": tribo})
    assert tested.attempted > 20 and tested.failed == 0


def test_types(tmp_path):
    said = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path, ROOT / "python" / "tribo"], capture_output=True, text=True, check=False)
    assert said.returncode == 0, said.stdout


@pytest.mark.parametrize("tool", ["tribo-design", "tribo-identify", "tribo-plot", "tribo-rig", "tribo-sim"])
def test_tools_are_installed(tool):
    said = subprocess.run([pathlib.Path(sys.executable).with_name(tool), "--help"], capture_output=True, text=True, check=False)
    assert said.returncode == 0 and tool in said.stdout
