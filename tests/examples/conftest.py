"""Builds examples outside the source tree."""

import pathlib
import re
import subprocess

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"
RMS_MAX_UN = 200  # as tests/package has it for the same arm; 3,900 without compensation


def make(example, build, *arguments, status=0):
    """What `make ARGUMENTS` in an example's folder prints."""
    result = subprocess.run(["make", "--silent", f"BUILD={build}", *arguments], cwd=EXAMPLES / example, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, text=True, timeout=300, check=False)
    assert (result.returncode != 0) == (status != 0), result.stdout
    return result.stdout


def rms_un(text):
    return int(re.search(r"RMS error (\d+) uN", text)[1])
