"""cmake/boards.json is the one list of boards: what is made from it is current, and every tool has all of its rows."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "cmake"))
import boards  # noqa: E402

EMULATED_KEYS = {"what", "tools", "flags", "qemu", "memory"}
OPTIONAL_KEYS = {"model", "test_qemu", "test_memory", "same_code"}


def said_by(*command, **options):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600, check=False, **options)
    assert done.returncode != 0
    return done.stdout


def test_the_presets_are_those_of_the_list():
    assert boards.PRESETS.read_text() == boards.presets_text(), "run cmake/boards.py"


@pytest.mark.parametrize("name", boards.EMULATED)
def test_a_row_of_an_emulated_processor_is_complete(name):
    row = boards.ROWS[name]
    assert EMULATED_KEYS <= row.keys() <= EMULATED_KEYS | OPTIONAL_KEYS
    assert ("test_qemu" in row) == ("test_memory" in row)
    if "same_code" in row:
        assert row["same_code"] in boards.EMULATED and "same_code" not in boards.ROWS[row["same_code"]]
    for key in ("memory", "test_memory"):
        assert re.fullmatch(r"(0x[0-9a-f]+ ){4}0x[0-9a-f]+", row.get(key, row["memory"]))


@pytest.mark.parametrize("name", boards.PORTS)
def test_a_row_of_a_board_has_a_port_and_a_test(name):
    row = boards.ROWS[name]
    assert row.keys() == {"what", "processor"}
    assert row["processor"] in boards.EMULATED
    assert (ROOT / "firmware" / "port" / name / "CMakeLists.txt").exists()
    assert (ROOT / "tests" / "boards" / f"test_{name}.py").exists()


def test_every_port_has_a_row():
    folders = {path.parent.name for path in (ROOT / "firmware" / "port").glob("*/CMakeLists.txt")}
    assert folders == {"emulated", "linux", *boards.PORTS}


def test_check_knows_every_board():
    parts = said_by(ROOT / "tools" / "check", "nosuch").rsplit("there are: ", 1)[1].split()
    assert [part for part in parts if part in boards.ROWS] == [*boards.EMULATED, *boards.PORTS]


def test_tribo_sim_knows_every_emulated_processor():
    names = said_by(os.environ["TRIBO_SIM"], "run", "triangle", "--target", "nosuch").split("must be one of ", 1)[1].split(" (")[0]
    assert sorted(names.split(", ")) == sorted(["serial:DEVICE", *(name.removeprefix("cortex-") for name in boards.EMULATED)])


def test_the_budget_has_every_board():
    lines = (ROOT / "tests" / "target" / "budget.txt").read_text().splitlines()
    assert next(line for line in lines if line.startswith("figure")).split()[1:] == list(boards.ROWS)


def test_a_processor_that_is_not_in_the_list_is_refused():
    text = said_by("cmake", "-DTRIBO_PROCESSOR=cortex-m99", "-P", ROOT / "cmake" / "toolchain.cmake")
    assert "no processor 'cortex-m99' in cmake/boards.json" in " ".join(text.split())
    assert "no machine for 'stm32f405'" in said_by(ROOT / "tests" / "target" / "emulate", "stm32f405", "program")


def test_a_new_row_is_all_that_its_presets_need(tmp_path):
    shutil.copytree(ROOT / "cmake", tmp_path / "cmake")
    shutil.copy(ROOT / "CMakePresets.json", tmp_path)
    rows = boards.ROWS | {"cortex-m23": boards.ROWS["cortex-m33"], "new_board": {"what": "new", "processor": "cortex-m23"}}
    (tmp_path / "cmake" / "boards.json").write_text(json.dumps(rows))
    subprocess.run([tmp_path / "cmake" / "boards.py"], check=True, timeout=600)
    listed = subprocess.run(["cmake", "--list-presets=workflow"], cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    assert {"cortex-m23", "cortex-m23-os", "new_board"} <= set(re.findall(r'"(.*?)"', listed))


def test_no_other_file_lists_the_processors():
    """The budget holds their figures; the others were lists once."""
    files = [path for folder in ("cmake", "firmware", "host_sim/target", "tests", "tools") for path in (ROOT / folder).rglob("*")]
    files += [ROOT / "CMakePresets.json", ROOT / "CMakeLists.txt"]
    text = {path: path.read_text(errors="ignore") for path in files if path.is_file() and ".venv" not in path.parts}
    naming = {path.relative_to(ROOT).as_posix() for path, content in text.items() if "rv32" + "imafc" in content}
    assert naming == {"cmake/boards.json", "cmake/presets/boards.json", "tests/target/budget.txt"}
