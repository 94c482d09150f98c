#!/usr/bin/env -S python3 -B
"""Reads boards.json, the list of boards, for the tools; boards.cmake reads it for CMake. A new board needs only a row and its
folder. Run as a program, this file writes presets/boards.json, the presets of every row.

A row of an emulated processor describes a QEMU machine; all of these share firmware/port/emulated:

    what         one line about it
    tools        prefix of its compiler and binutils
    flags        flags of the compiler
    qemu         the command that starts its machine
    memory       start and size of flash, start and size of RAM, size of the stack
    model        llvm-mca's CPU; left out if there is none
    test_qemu, test_memory    more RAM for the tests, if the machine's own is too small for them
    same_code    another processor for which the compiler writes the same instructions, as the test target.same_code checks:
                 the unit and contract tests run there only

A row with `processor` describes a board with its own port, the folder firmware/port/NAME, for that processor.
"""

import json
import pathlib

HERE = pathlib.Path(__file__).resolve().parent
PRESETS = HERE / "presets" / "boards.json"
ROWS = json.loads((HERE / "boards.json").read_text())
EMULATED = [name for name, row in ROWS.items() if "processor" not in row]
PORTS = [name for name, row in ROWS.items() if "processor" in row]


def processor(name):
    """Returns the row that has a board's compiler."""
    return ROWS[ROWS[name].get("processor", name)]


def test_machine(name):
    """Returns the QEMU command for an emulated processor's tests."""
    return ROWS[name]["qemu"].split() + ROWS[name].get("test_qemu", "").split()


def configure_presets(name):
    row = ROWS[name]
    variables = {"TRIBO_PROCESSOR": row.get("processor", name)}
    if name in PORTS:
        variables["TRIBO_BOARD"] = name
    preset = {"name": name, "displayName": row["what"], "inherits": "target", "cacheVariables": variables}
    yield preset
    if name in EMULATED:
        small = {"name": f"{name}-os", "displayName": f"{row['what']}; at -Os"}
        yield preset | small | {"cacheVariables": variables | {"CMAKE_C_FLAGS_RELEASE": "-Os"}}


def presets():
    configure = [preset for name in ROWS for preset in configure_presets(name)]
    names = [preset["name"] for preset in configure]
    target = {
        "name": "target",
        "hidden": True,
        "inherits": "base",
        "toolchainFile": "${sourceDir}/cmake/toolchain.cmake",
        "cacheVariables": {
            "CMAKE_BUILD_TYPE": "Release",
            "CMAKE_C_FLAGS_RELEASE": "-O2",
            "TRIBO_HOST_SIM": "OFF",
            "TRIBO_PACKAGE_TESTS": "OFF",
        },
    }
    return {
        "version": 6,
        "include": ["base.json"],
        "configurePresets": [target, *configure],
        "buildPresets": [{"name": name, "configurePreset": name} for name in names],
        "testPresets": [{"name": name, "inherits": "base", "configurePreset": name} for name in names],
        "workflowPresets": [
            {"name": name, "steps": [{"type": step, "name": name} for step in ("configure", "build", "test")]} for name in names
        ],
    }


def presets_text():
    """Formats the presets, one per line."""
    parts = []
    for key, value in presets().items():
        if isinstance(value, list):
            lines = ",\n".join(f"    {json.dumps(item)}" for item in value)
            parts.append(f'  "{key}": [\n{lines}\n  ]')
        else:
            parts.append(f'  "{key}": {json.dumps(value)}')
    return "{\n" + ",\n".join(parts) + "\n}\n"


if __name__ == "__main__":
    PRESETS.write_text(presets_text())
