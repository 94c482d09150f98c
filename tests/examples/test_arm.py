"""What is compiled for microcontrollers, and run in QEMU where it can be."""

import re

from conftest import make


def test_a_joint_with_a_controller_of_its_own_follows_better(tmp_path):
    without, compensated = map(int, re.findall(r"RMS error (\d+) uN m", make("exo", tmp_path, "run")))
    assert without > 40000
    assert compensated < without / 2.5


def test_the_sketch_of_simplefoc_compiles(tmp_path):
    make("simplefoc", tmp_path, "arm")
    assert (tmp_path / "sketch.o").exists()
