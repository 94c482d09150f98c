"""docs.py ROOT TRIBO_SIM: README.md and docs/ say what is there. Links lead somewhere, the README stays short, and the table
of docs/parameters.md has the program's keys, ranges and defaults, and fields that the headers declare; its second table has all keys
of feed-forward and guard.
"""

import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(sys.argv[1])
README_LINES = 130


def anchors(path):
    titles = re.findall(r"^#+ (.*)$", path.read_text(), re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def dead_links(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text()):
        if target.startswith(("http:", "https:")):
            continue
        name, _, anchor = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if not file.exists() or (anchor and anchor not in anchors(file)):
            yield f"{page.relative_to(ROOT)}: {target} leads nowhere"


def long_readme():
    lines = len((ROOT / "README.md").read_text().splitlines())
    if lines > README_LINES:
        yield f"README.md: {lines} lines, {README_LINES} at most"


def keys(tribo_sim):
    """(range, default) by key."""
    out = subprocess.run([tribo_sim, "list", "--keys"], check=True, capture_output=True, text=True).stdout
    rows = [line.split(" | ") for line in out.splitlines()]
    return {key: ("list" if kind == "a list" else allowed, default) for key, kind, allowed, default in rows}


def wrong_parameters(tribo_sim):
    page = (ROOT / "docs" / "parameters.md").read_text()
    rows = re.findall(r"^\| `(\S+)` \| `(\S+)` \| [^|]* \| ([^|]*) \| ([^|]*) \|$", page, re.M)
    headers = "".join(path.read_text() for path in sorted((ROOT / "lib" / "include" / "tribo").glob("*.h")))
    known = keys(tribo_sim)
    if len(rows) < 20:
        yield f"docs/parameters.md: only {len(rows)} rows in its table"
    for key, field, default, allowed in rows:
        if known.get(key) != (allowed, default):
            yield f"docs/parameters.md: {key}: {allowed}, default {default}; tribo-sim has {known.get(key)}"
        for name in field.split("."):
            if not re.search(rf"\b{name}(,[^;\n]*)?;", headers):
                yield f"docs/parameters.md: {field}: no field {name} in lib/include"


def wrong_compensation():
    """The rows of feed-forward and guard are those of the scenarios' README, which the program writes, and one column more."""
    pattern = r"^\| `compensator\.(?:method|feedforward\.|guard\.).*"
    page = re.findall(pattern, (ROOT / "docs" / "parameters.md").read_text(), re.M)
    made = re.findall(pattern, (ROOT / "host_sim" / "scenarios" / "README.md").read_text(), re.M)
    if len(made) < 35:
        yield f"host_sim/scenarios/README.md: only {len(made)} keys of feed-forward and guard"
    for row in made:
        if not any(re.fullmatch(re.escape(row) + r" [^|]+ \|", other) for other in page):
            yield f"docs/parameters.md lacks the row: {row}"
    if len(page) != len(made):
        yield f"docs/parameters.md: {len(page)} rows of feed-forward and guard, {len(made)} keys"


complaints = [*long_readme()]
for page in (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))):
    complaints += dead_links(page)
complaints += wrong_parameters(sys.argv[2])
complaints += wrong_compensation()
print("\n".join(complaints))
sys.exit(bool(complaints))
