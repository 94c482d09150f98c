"""Builds examples outside the source tree."""

import importlib.util
import math
import pathlib
import re
import subprocess

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"
RMS_MAX_UN = 200  # as tests/package has it for the same arm; 3,900 without compensation


def make(example, build, *arguments, status=0):
    """What `make ARGUMENTS` in an example's folder prints."""
    result = subprocess.run(["make", "--silent", f"BUILD={build}", *arguments], cwd=EXAMPLES / example, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, text=True, timeout=3000, check=False)
    assert (result.returncode != 0) == (status != 0), result.stdout
    return result.stdout


def load(path):
    """A module of an example: several have a force.py."""
    specification = importlib.util.spec_from_file_location(path.replace("/", "_").removesuffix(".py"), EXAMPLES / path)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def rms_un(text):
    return int(re.search(r"RMS error (\d+) uN", text)[1])


def rms_of(references, forces):
    """In micronewton, over the second half."""
    half = len(references) // 2
    return 1e6 * math.sqrt(sum((r - f) ** 2 for r, f in zip(references[half:], forces[half:])) / half)


def error_of(seen):
    """RMS over the second half of what a fake drive with a joint has seen: rows that begin with reference and position."""
    half = seen[len(seen) // 2:]
    return math.sqrt(sum((row[0] - row[1]) ** 2 for row in half) / len(half))
