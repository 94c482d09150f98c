"""Runs tribo-sim with its loop on an emulated target.

TRIBO_SIM is the program, TRIBO_PROCESSOR the target's processor, TRIBO_TREE the folder that its image was built in.
"""

import os
import pathlib
import subprocess
import tempfile

import pytest

PROCESSOR = os.environ["TRIBO_PROCESSOR"]
TARGET = PROCESSOR.removeprefix("cortex-")
TREE = pathlib.Path(os.environ["TRIBO_TREE"])


class LockStep:
    """tribo-sim in a folder of its own, with the images of this tree."""

    def __init__(self, folder, temporary):
        self.folder = folder
        self.temporary = temporary
        self.program = os.environ["TRIBO_SIM"]
        assert os.access(self.program, os.X_OK), f"no {self.program}: see the test lock_step.host"
        self.images = folder / "images"
        self.images.mkdir()
        self.tree = self.images / PROCESSOR  # the name that tribo-sim looks for; the tree's own may differ
        self.tree.symlink_to(TREE)
        self.environment = {**os.environ, "TRIBO_FIRMWARE": str(self.images), "TMPDIR": str(self.temporary)}

    def command(self, *arguments):
        return [self.program, "run", *map(str, arguments)]

    def __call__(self, *arguments):
        result = subprocess.run(self.command(*arguments), cwd=self.folder, env=self.environment, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, text=True, timeout=600, check=False)
        assert list(self.temporary.iterdir()) == [], "something is left behind"
        return result

    def ok(self, *arguments):
        result = self(*arguments)
        assert result.stderr == ""
        assert result.returncode == 0
        return result.stdout

    def fails(self, message, *arguments):
        result = self(*arguments)
        assert message in result.stderr
        assert result.stderr.startswith("tribo-sim: ")
        assert result.stderr.count("\n") == 1
        assert result.returncode == 1


@pytest.fixture
def sim(tmp_path):
    with tempfile.TemporaryDirectory() as temporary:  # a short name, which fits any buffer
        yield LockStep(tmp_path, pathlib.Path(temporary))


@pytest.fixture
def target():
    return TARGET
