"""cmake/cmsis_core.cmake with a stand-in for npm: what is wrong is said, and nothing of it stays in the cache."""

import os
import pathlib
import shutil
import subprocess

import pytest

SCRIPT = pathlib.Path(__file__).parents[2] / "cmake" / "cmsis_core.cmake"


@pytest.fixture
def fetch(tmp_path):
    """Runs the script with an empty cache and the shell script that is given as npm, or with none."""
    (tmp_path / "bin").mkdir()

    def run(npm=None):
        if npm:
            program = tmp_path / "bin" / "npm"
            program.write_text(f"#!/bin/sh\n{npm}\n")
            program.chmod(0o755)
        environment = {**os.environ, "PATH": str(tmp_path / "bin"), "XDG_CACHE_HOME": str(tmp_path / "cache")}
        done = subprocess.run([shutil.which("cmake"), "-P", SCRIPT], env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=600, check=False)
        return done.returncode, " ".join(done.stdout.split())

    return run


@pytest.mark.parametrize("npm, message", [
    (None, "there is no npm to fetch it: connect to the network and run tools/setup board, or give -DTRIBO_CMSIS_CORE_DIR="),
    ("echo npm: no network >&2; exit 1", "npm cannot fetch it: connect to the network and run tools/setup board"),
    ("exit 0", "npm cannot fetch it"),
    ("echo something else > arm-cmsis-core.tgz", "is not the expected one"),
])
def test_failed_fetch_says_the_way_out_and_leaves_nothing(fetch, tmp_path, npm, message):
    returncode, output = fetch(npm)
    assert returncode != 0
    assert message in output
    assert [path for path in (tmp_path / "cache").rglob("*") if path.is_file()] == []


def test_reason_of_npm_is_shown(fetch):
    assert "npm: no network" in fetch("echo npm: no network >&2; exit 1")[1]


def test_cached_headers_need_no_npm(fetch, tmp_path):
    version = next(line.split()[1].rstrip(")") for line in SCRIPT.read_text().splitlines() if "set(cmsis_version" in line)
    headers = tmp_path / "cache" / "tribo" / f"cmsis-core-{version}" / "CMSIS" / "Core" / "Include"
    headers.mkdir(parents=True)
    (headers / "core_cm4.h").touch()
    assert fetch() == (0, "")
