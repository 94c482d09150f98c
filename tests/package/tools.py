"""tools.py ROOT: every program of tools, tools/dev and research says what it does and of which version it is, and does nothing else for it.

The changelog has a section of that version.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(sys.argv[1])
DIRECTLY = 8  # programs in tools itself
INSTALLED_AS = {"demo-drive": "tribo-demo-drive"}
# These make their Python environment first; tests/python/wheel.py has them as they are installed.
WITH_ENVIRONMENT = {"tribo-identify", "tribo-rig"}

sys.path.insert(0, str(ROOT / "tests" / "support"))
from version import VERSION  # noqa: E402


def say(*command):
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0 and not done.stderr, f"{command}: {done.returncode} {done.stdout}{done.stderr}"
    return done.stdout


programs = [path for folder in ("tools", "tools/dev", "tools/link", "research") for path in sorted((ROOT / folder).iterdir())
            if path.is_file() and os.access(path, os.X_OK)]
assert len(programs) > 15, programs
assert sum(path.parent == ROOT / "tools" for path in programs) <= DIRECTLY, programs
for program in programs:
    if program.name in WITH_ENVIRONMENT:
        continue
    called = INSTALLED_AS.get(program.name, program.name)
    assert say(program, "--version") == f"{called if called.startswith('tribo-') else program.relative_to(ROOT)} {VERSION}\n", program
    assert len(say(program, "--help")) > 100, program

# What does not fit is refused at once, before anything is installed, built or written.
WRONG = {
    ("tools/demo", "x"): "takes no arguments", ("tools/setup",): "usage: tools/setup check", ("tools/setup", "fly"): "usage: tools/setup check",
    ("tools/setup", "check", "x"): "'x' is one argument too many", ("tools/setup", "package"): "at least one NAME is expected", ("tools/setup", "package", ""): "package '': a name of",
    ("tools/setup", "package", "-y"): "package '-y': a name of", ("tools/setup-design", "x"): "no option 'x'", ("tools/setup-design", "--guard", "x"): "'x' is one argument too many",
    ("tools/check", "x"): "no part 'x'", ("tools/dev/deb", "x"): "usage: tools/dev/deb", ("tools/dev/deb", "amd64", "x"): "'x' is one argument too many",
    ("tools/dev/bench", "x"): "no option 'x'", ("tools/dev/bench", "--update", "x"): "'x' is one argument too many", ("tools/dev/wheel", "a", "b"): "'b' is one argument too many",
    ("tools/dev/packages", ""): "is empty", ("tools/dev/packages", "/dev/null"): "cannot be written", ("tools/dev/packages", "out", "x"): "no kind 'x'",
    ("tools/dev/reference", ""): "is empty", ("tools/dev/reference", "/dev/null/x"): "/dev/null/x: cannot be made: Not a directory",
    ("tools/dev/playground", "--build", ""): "is empty", ("tools/dev/playground", "--build", "/dev/null/x"): "/dev/null/x: cannot be written", ("tools/dev/playground", "--port", "x"): "invalid int value"}
with tempfile.TemporaryDirectory() as folder:
    for (program, *words), said in WRONG.items():
        done = subprocess.run([ROOT / program, *words], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, timeout=60)
        assert done.returncode != 0 and said in done.stderr and "Traceback" not in done.stderr, (program, words, done)
        assert not os.listdir(folder), (program, words)

# The usage of tools/setup names everything that it takes.
cases = re.search(r'case "\${1-}" in\n(.*?)\nesac', (ROOT / "tools/setup").read_text(encoding="utf-8"), re.S)[1]
taken = [word for line in re.findall(r"^    ([a-z][\w| -]*)\)", cases, re.M) for word in line.split(" | ")]
usage = subprocess.run([ROOT / "tools/setup"], capture_output=True, text=True, check=False, timeout=60).stderr
assert len(taken) > 15 and set(taken) == set(re.sub(r".*tools/setup (check .*) NAME.*", r"\1", usage.strip()).split(" | ")), (taken, usage)

released = re.findall(r"^## (\d\S*) - \d{4}-\d\d-\d\d$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)
assert released[0] == VERSION, released
