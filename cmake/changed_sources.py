#!/usr/bin/env python3
"""Prints the C sources that changed since the merge base with origin/main, one per line: those that were edited, and those that
include an edited header, directly or through others. Prints "all" if this is not known or if the rules themselves changed."""

import collections
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
RULES = {".clang-tidy", "CMakeLists.txt", "cmake/lint.cmake", "cmake/warnings.cmake"}


def git(*arguments):
    return subprocess.run(["git", *arguments], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                          check=True).stdout.splitlines()


def changed():
    base = git("merge-base", "HEAD", "origin/main")[0]
    return {*git("diff", "--name-only", "--no-renames", base), *git("ls-files", "--others", "--exclude-standard")}


def including():
    """Returns the files that include a header, by its name without folders; headers of the same name count as one."""
    users = collections.defaultdict(set)
    for path in git("ls-files", "--cached", "--others", "--exclude-standard", "*.[ch]"):
        if (ROOT / path).exists():
            text = (ROOT / path).read_text(encoding="utf-8")
            for name in re.findall(r'^[ \t]*#[ \t]*include[ \t]*["<]([^">]+)[">]', text, re.MULTILINE):
                users[pathlib.PurePath(name).name].add(path)
    return users


def touched(files):
    users, seen, left = including(), set(), list(files)
    while left:
        path = left.pop()
        if path not in seen:
            seen.add(path)
            left += users[pathlib.PurePath(path).name] if path.endswith(".h") else []
    return sorted(path for path in seen if path.endswith(".c") and (ROOT / path).exists())


try:
    files = changed()
except (OSError, IndexError, subprocess.CalledProcessError):
    sys.exit(print("all"))
print("all" if files & RULES else "\n".join(touched(files)))
