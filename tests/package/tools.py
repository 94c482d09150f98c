"""tools.py TOOLS: every program there says what it does and of which version it is, and does nothing else for it."""

import os
import pathlib
import re
import subprocess
import sys

TOOLS = pathlib.Path(sys.argv[1])
INSTALLED_AS = {"demo-drive": "tribo-demo-drive"}
# These make their Python environment first; tests/python/wheel.py has them as they are installed.
WITH_ENVIRONMENT = {"tribo-identify", "tribo-rig"}

VERSION = re.search(r'TRIBO_VERSION_STRING "(.*)"', (TOOLS.parent / "lib/include/tribo/status.h").read_text(encoding="utf-8"))[1]


def say(*command):
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0 and not done.stderr, f"{command}: {done.returncode} {done.stdout}{done.stderr}"
    return done.stdout


programs = [path for path in sorted(TOOLS.iterdir()) if path.is_file() and os.access(path, os.X_OK) and path.name not in WITH_ENVIRONMENT]
assert len(programs) > 15, programs
for program in programs:
    name = program.name
    called = INSTALLED_AS.get(name, name)
    assert say(program, "--version") == f"{called if called.startswith('tribo-') else 'tools/' + called} {VERSION}\n", program
    assert len(say(program, "--help")) > 100, program
