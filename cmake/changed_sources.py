#!/usr/bin/env python3
"""Prints the C sources for the linters of tools/check, one per line: those edited since the merge base with origin/main, and of
each edited header the nearest sources that include it, one for each arithmetic. Prints "all" if this is not known or if the rules
themselves changed. What an edited header does to all the others that include it is found by the compilers, and by tools/check --all."""

import collections
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
RULES = {".clang-tidy", "CMakeLists.txt", "cmake/lint.cmake", "cmake/warnings.cmake"}
UNCHECKED = ("examples/", "python/")  # by cmake/lint.cmake, which has no flags for them


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
            for name in re.findall(r"^#include ([A-Z]+)_HEADER$", text, re.MULTILINE):  # of the tests that are compiled for each arithmetic
                for arithmetic in ("f32", "q31"):
                    users[f"{name.lower()}_{arithmetic}.h"].add(path)
    return users


def nearest(header, users):
    """Returns the sources with the fewest headers between them and this one, of its own top folder where there are any. One of its own
    name goes before the others, and of these one for each arithmetic is enough."""
    level, seen, found = {header}, {header}, []
    while level:
        level = {user for path in level for user in users[pathlib.PurePath(path).name]} - seen
        seen |= level
        found += [sorted(path for path in level if path.endswith(".c") and not path.startswith(UNCHECKED))]
    room = header.partition("/")[0] + "/"
    for among in (room, ""):
        for sources in found:
            if fitting := [path for path in sources if path.startswith(among)]:
                own = [path for path in fitting if pathlib.PurePath(path).stem == pathlib.PurePath(header).stem]
                return own or {path[-6:-2]: path for path in fitting if path.endswith(("_f32.c", "_q31.c"))}.values() or fitting[:1]
    return []


def touched(files):
    users = including()
    found = {path for path in files if path.endswith(".c") and (ROOT / path).exists()}
    for header in (path for path in files if path.endswith(".h")):
        found.update(nearest(header, users))
    return sorted(found)


try:
    files = changed()
except (OSError, IndexError, subprocess.CalledProcessError):
    sys.exit(print("all"))
print("all" if files & RULES else "\n".join(touched(files)))
