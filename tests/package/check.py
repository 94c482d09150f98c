"""check.py ROOT TREE: what tools/check leaves out of TREE's tests for a change of some paths, asked of ctest itself, and which sources
its linters take for a header, compared with what TREE's compiler has read."""

import collections
import os
import pathlib
import re
import subprocess
import sys

ROOT, TREE = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2]
sys.path.insert(0, str(ROOT / "cmake"))
import changed_sources  # noqa: E402

SCRIPT = (ROOT / "tools/check").read_text(encoding="utf-8")
CHOICE = SCRIPT[SCRIPT.index("\nlabels=all\n"):SCRIPT.index("\ngroups=(check)\n")]


def say(*words):
    return subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True).stdout


def tests(*options):
    return {name.split("/", 1)[-1] for name in re.findall(r"Test +#\d+: (\S+)", say("ctest", "--test-dir", TREE, "-N", *options))}


def options(changed, all_of_them="no"):
    script = f'set -euo pipefail\nall={all_of_them}\nchanged="$1"\n{CHOICE}\nprintf "%s\\n" "${{left_out[@]}}"'
    return say("bash", "-c", script, "bash", changed).split()


def left_out(changed, all_of_them="no"):
    return tests() - tests(*options(changed, all_of_them))


def runs(changed, test):
    """Tells it of a test of another tree."""
    return not re.match(options(changed)[-1], test)


by_night = left_out("all")
drive = {"linux.tribo_drive", "linux.clients", "linux.browser"} & tests()
library = {name for name in tests() - by_night if re.match(r"identity\.(gcc|clang|portable|refused)|closed_loop\.(effort|flips|smooth|joint_)|package\.(lib_in|headers|freestanding)", name)}
simulator = {name for name in tests() if name.startswith("truth.")}
studies = {name for name in tests() - by_night if re.match(r"firmware\.loop_study", name)}
assert len(library) > 20 and not by_night & drive, "what is not known to be untouched runs"
assert left_out("all", "yes") == set(), "--all leaves nothing out"
assert len(simulator) > 10 and studies == {"firmware.loop_study_q31"}
assert left_out("README.md") >= by_night | drive | library | simulator | studies
assert left_out("host_sim/plant/plant.c") & (simulator | studies | drive) == drive - {"linux.tribo_drive"}
closed_loop = {name for name in tests() - by_night if name.startswith("closed_loop.")}
assert len(closed_loop) > 20 and left_out("common/support/elementary.c") & (simulator | closed_loop | studies | drive) == set()
assert left_out("tests/support/random.h") & (simulator | closed_loop) == set()
for rule in ("CMakeLists.txt", "CMakePresets.json", "tests/CMakeLists.txt", "cmake/unity.cmake", "cmake/presets/boards.json", "cmake/boards.py", "tools/setup"):
    assert left_out(rule) & (drive | library | simulator | closed_loop | studies) == set(), rule
for page in ("AGENTS.md", "docs/linux.md", "tools/tribo_plot/look.py"):
    assert left_out(page) & drive == drive - {"linux.clients"}, page
assert left_out("tests/browser/chromium.py") & drive == {"linux.tribo_drive"}
for path in ("playground/core.c", "tests/playground/columns.c", "tools/fmu/axis.c", "tools/tribo-plot", "tests/browser/chromium.py"):
    assert {"plot", "playground", "fmu"} <= tests() - left_out(path), path
assert {"plot", "playground", "fmu"} <= left_out("lib/src/axis/axis.h")
for path, test in (("host_sim/target/emulator.c", "cortex-m4f/lock_step.emulator"), ("host_sim/target/serial.c", "stm32f405/lock_step"),
                   ("tests/lock_step/conftest.py", "stm32f405/lock_step"),
                   ("tests/boards/requirements.txt", "stm32f405/examples.vesc"), ("firmware/port/stm32f405/board.c", "stm32f405/model.1"),
                   ("examples/rig/rig_500hz.yaml", "host-release/guard.python")):
    assert runs(path, test) and not runs("designs.txt", test), (path, test)
assert left_out("firmware/app/drive.c") & (simulator | studies) == simulator
assert left_out("lib/src/axis/axis.h") & (drive | library) == drive
assert left_out("docs/index.md\nfirmware/app/drive.c") & (drive | library) == library
assert {"unit.status", "identity.this_build", "contract.refusal_q31"} <= tests() - left_out("README.md")

# For a header, the linters take sources that include it.
for header, sources in {
        "lib/src/feedforward/words_q31.h": ["lib/src/feedforward/sensorless_q31.c"], "lib/src/number/words_q31.h": ["lib/src/joint/joint_q31.c"],
        "common/support/clock.h": ["firmware/port/linux/bus.c"], "firmware/port/serial/serial.h": ["firmware/port/serial/link.c"],
        "tests/closed_loop/rig.h": ["tests/closed_loop/rig.c"], "tests/truth/rig.h": ["tests/truth/rig.c"],
        "firmware/port/stm32f405/board.h": [],
        "firmware/port/stm32f405/registers.h": [], "firmware/port/stm32f405/wait.h": []}.items():  # no linter has the flags of this chip
    assert (ROOT / header).exists() and changed_sources.touched({header}) == sources, (header, changed_sources.touched({header}))
headers = changed_sources.git("ls-files", "*.h")
users = changed_sources.including()
taken = {header: changed_sources.nearest(header, users) for header in headers}
read = collections.defaultdict(set)
for entry in say("ninja", "-C", TREE, "-t", "deps").split("\n\n"):
    paths = [os.path.relpath(os.path.join(TREE, line.strip()), ROOT) for line in entry.splitlines()[1:]]
    for path in paths[:1]:
        read[path].update(paths)
compared = 0
for header in headers:
    for source in taken[header]:
        assert not changed_sources.UNCHECKED.match(source) and (source not in read or header in read[source]), (header, source)
        compared += source in read
    assert taken[header] or not [path for path in read if header in read[path] and not changed_sources.UNCHECKED.match(path) and path.endswith(".c")], header
assert compared > 100, compared
