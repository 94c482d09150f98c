#!/usr/bin/env python3
"""Prints the C sources that tools/check gives to its linters, one per line: the sources edited since the merge base with origin/main, and
for each edited header the nearest sources that include it, one for each arithmetic. Prints "all" if this is not known or if the linters'
rules changed. The compilers, and tools/check --all, find what an edited header does to the other sources that include it."""

import collections
import pathlib
import posixpath
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
RULES = {".clang-tidy", "CMakeLists.txt", "cmake/lint.cmake", "cmake/warnings.cmake"}
SKIPPED = re.search(r'AND NOT source MATCHES "(\^\(examples/.*)"\)', (ROOT / "cmake/lint.cmake").read_text(encoding="utf-8"))[1]
UNCHECKED = re.compile(SKIPPED.replace("${no_gpiod}", "lines_v[12]") + "|^tools/dev/")  # sources without a linter's test


def git(*arguments):
    return subprocess.run(["git", *arguments], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                          check=True).stdout.splitlines()


def changed():
    base = git("merge-base", "HEAD", "origin/main")[0]
    return {*git("diff", "--name-only", "--no-renames", base), *git("ls-files", "--others", "--exclude-standard")}


def includes(text):
    yield from re.findall(r'^[ \t]*#[ \t]*include[ \t]*["<]([^">]+)[">]', text, re.MULTILINE)
    for name in re.findall(r"^#include ([A-Z]+)_HEADER$", text, re.MULTILINE):  # of the tests that are compiled for each arithmetic
        yield from (f"{name.lower()}_{arithmetic}.h" for arithmetic in ("f32", "q31"))


def including():
    """Returns by header the files that include it. An include is a file of the includer's folder, else one in an include directory:
    in one that other includes leave no doubt about, where several headers have the name."""
    paths = {path for path in git("ls-files", "--cached", "--others", "--exclude-standard", "*.[ch]") if (ROOT / path).exists()}
    named = collections.defaultdict(set)
    for path in paths:
        named[posixpath.basename(path)].add(path)
    found = {}
    for path in paths:
        for name in includes((ROOT / path).read_text(encoding="utf-8")):
            beside = posixpath.normpath(posixpath.join(posixpath.dirname(path), name))
            found[path, name] = {beside} & paths or {header for header in named[posixpath.basename(name)] if f"/{header}".endswith(f"/{name}")}
    directories = {header.removesuffix(name) for (path, name), headers in found.items() if len(headers) == 1 for header in headers
                   if posixpath.dirname(header) != posixpath.dirname(path)}
    users = collections.defaultdict(set)
    for (path, name), headers in found.items():
        for header in {header for header in headers if len(headers) == 1 or header.removesuffix(name) in directories} or headers:
            users[header].add(path)
    return users


def nearest(header, users):
    """Returns the sources with the fewest headers between them and this one, of its own top folder where there are any. One of its own
    name goes before the others, and of these one for each arithmetic is enough."""
    level, seen, found = {header}, {header}, []
    while level:
        level = {user for path in level for user in users[path]} - seen
        seen |= level
        found += [sorted(path for path in level if path.endswith(".c") and not UNCHECKED.match(path))]
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


def main():
    try:
        files = changed()
    except (OSError, IndexError, subprocess.CalledProcessError):
        sys.exit(print("all"))
    print("all" if files & RULES else "\n".join(touched(files)))


if __name__ == "__main__":
    main()
