"""contributing.py ROOT: the lists of files in CONTRIBUTING.md are those of the tree.

A section with <!-- example: NAME --> lists, at the beginning of its items, the files that its kind of change touches; NAME stands for
the new thing's name, and a folder for all that is in it. They must be the files whose text or path has the example's name. The mark
may go on, each part behind a semicolon:

    names: REGEX      what is looked for in the text, in place of the name
    in: FOLDER...     where; files that are listed elsewhere must be there
    at most N         of the numbered items, the files written by hand
"""

import os
import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
NOT_SEARCHED = {".git", ".venv", "build", "docs", "__pycache__", "CONTRIBUTING.md", "CHANGELOG.md"}
SECTIONS = ("A friction parameter", "A method", "A truth model", "A processor", "A board")


def files():
    for folder, folders, names in os.walk(ROOT):
        folders[:] = [name for name in folders if name not in NOT_SEARCHED]
        for name in names:
            if name not in NOT_SEARCHED:
                yield (pathlib.Path(folder) / name).relative_to(ROOT).as_posix()


TEXT = {path: (ROOT / path).read_text(encoding="utf-8", errors="ignore") for path in files() if (ROOT / path).is_file()}


def is_in(path, entry):
    return path == entry or (entry.endswith("/") and path.startswith(entry))


def complaints(title, section):
    mark = re.search(r"<!-- example: (\w+)((?:; [^;]+)*) -->", section)
    if not mark:
        yield f"{title}: no example"
        return
    example = mark[1]
    names = re.search(r"; names: ([^;]+)", mark[2])
    folders = re.search(r"; in: ([^;]+)", mark[2])
    limit = re.search(r"; at most (\d+)", mark[2])
    pattern = re.compile(names[1] if names else example)
    folders = tuple(f"{folder}/" for folder in folders[1].split()) if folders else ("",)
    items = re.findall(r"^(?:\d+\.|-) ((?:`[^`]+`(?:, | and )?)+)", section, re.M)
    by_hand = re.findall(r"^\d+\. ((?:`[^`]+`(?:, | and )?)+)", section, re.M)
    paths, hand = ([path.replace("NAME", example) for item in some for path in re.findall(r"`([^`]+)`", item)] for some in (items, by_hand))
    found = {path for path, text in TEXT.items() if path.startswith(folders) and (pattern.search(text) or pattern.search(path))}
    for path in sorted(found):
        if not any(is_in(path, entry) for entry in paths):
            yield f"{title}: {path} names {example} and is not listed"
    for entry in sorted(set(paths)):
        there = any(is_in(path, entry) for path in found) if entry.startswith(folders) else (ROOT / entry).exists()
        if not there:
            yield f"{title}: {entry} is listed, and does not name {example}"
    if limit and len(hand) > int(limit[1]):
        yield f"{title}: {len(hand)} files by hand, {limit[1]} at most"


sections = dict(re.findall(r"^## (.*?)\n(.*?)(?=^## |\Z)", (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8"), re.M | re.S))
found = [f"CONTRIBUTING.md: no section '{title}'" for title in SECTIONS if title not in sections]
found += [complaint for title in SECTIONS if title in sections for complaint in complaints(title, sections[title])]
print("\n".join(found))
sys.exit(bool(found))
