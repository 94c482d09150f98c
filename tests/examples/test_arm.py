"""What is compiled for microcontrollers, and run in QEMU where it can be."""

import re
import subprocess

import pytest

from conftest import EXAMPLES, make


def test_a_joint_with_a_controller_of_its_own_follows_better(tmp_path):
    without, compensated = map(int, re.findall(r"RMS error (\d+) uN m", make("exo", tmp_path, "run")))
    assert without > 40000
    assert compensated < without / 2.5


def test_the_sketches_of_simplefoc_compile(tmp_path):
    make("simplefoc", tmp_path, "arm")
    assert (tmp_path / "simplefoc.o").exists() and (tmp_path / "joint.o").exists()


@pytest.mark.parametrize("source", ["freertos/force_task.c", "zephyr/src/main.c"])
def test_tasks_compile(source, tmp_path):
    example = EXAMPLES / source.split("/")[0]
    subprocess.run(["arm-none-eabi-gcc", "-mthumb", "-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard", "-std=c11", "-O2", "-Wall",
                    "-Wextra", "-Werror", "-I", example / "stand_in", "-I", EXAMPLES / "rig", "-I", EXAMPLES.parent / "lib" / "include",
                    "-c", EXAMPLES / source, "-o", tmp_path / "task.o"], check=True, timeout=600)
