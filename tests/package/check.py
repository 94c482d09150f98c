"""check.py ROOT TREE: what tools/check leaves out of TREE's tests for a change of some paths, asked of ctest itself."""

import pathlib
import re
import subprocess
import sys

ROOT, TREE = pathlib.Path(sys.argv[1]), sys.argv[2]
SCRIPT = (ROOT / "tools/check").read_text(encoding="utf-8")
CHOICE = SCRIPT[SCRIPT.index("\nlabels=all\n"):SCRIPT.index("\ngroups=(check)\n")]


def say(*words):
    return subprocess.run(words, check=True, stdout=subprocess.PIPE, text=True).stdout


def tests(*options):
    return {name.split("/", 1)[-1] for name in re.findall(r"Test +#\d+: (\S+)", say("ctest", "--test-dir", TREE, "-N", *options))}


def left_out(changed, all_of_them="no"):
    script = f'set -euo pipefail\nall={all_of_them}\nchanged="$1"\n{CHOICE}\nprintf "%s\\n" "${{left_out[@]}}"'
    return tests() - tests(*say("bash", "-c", script, "bash", changed).split())


by_night = left_out("all")
drive = {"linux.tribo_drive", "linux.clients", "linux.browser"} & tests()
library = {name for name in tests() - by_night if re.match(r"identity\.(gcc|clang|portable|refused)|closed_loop\.(effort|flips|smooth|joint_)|package\.(lib_in|headers|freestanding)", name)}
simulator = {name for name in tests() if name.startswith("truth.")}
studies = {name for name in tests() - by_night if re.match(r"firmware\.(fault|loop)_study", name)}
assert len(library) > 20 and not by_night & drive, "what is not known to be untouched runs"
assert left_out("all", "yes") == set(), "--all leaves nothing out"
assert len(simulator) > 10 and studies == {"firmware.fault_study_f32", "firmware.loop_study_q31"}
assert left_out("README.md") >= by_night | drive | library | simulator | studies
assert left_out("host_sim/plant/plant.c") & (simulator | studies) == set()
assert left_out("firmware/app/drive.c") & (simulator | studies) == simulator
assert left_out("lib/src/axis/axis.h") & (drive | library) == drive
assert left_out("docs/index.md\nfirmware/app/drive.c") & (drive | library) == library
assert {"unit.status", "identity.this_build", "contract.refusal_q31"} <= tests() - left_out("README.md")
