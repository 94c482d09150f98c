"""docs.py ROOT TRIBO_SIM: the pages say what is there. Links lead somewhere, each page is reached from docs/index.md, the README
stays short, long tables come last. The table of docs/parameters.md has the program's keys, ranges and defaults, and fields that the headers declare; its second table has all keys
of feed-forward and guard.
"""

import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(sys.argv[1])
README_LINES = 100
LONG_TABLE = 15
PROSE_AFTER = 60  # words: a caption, not a page
PAGES = sorted(page for page in ROOT.rglob("*.md") if not {"build", ".venv"} & set(page.relative_to(ROOT).parts))
GENERATED = {"numbers.md", "registers.md", "reproduction.md"}


def anchors(path):
    titles = re.findall(r"^#+ (.*)$", path.read_text(), re.M)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


def links(page):
    return [target for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text()) if not target.startswith(("http:", "https:"))]


def dead_links(page):
    for target in links(page):
        name, _, anchor = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if not file.exists() or (anchor and anchor not in anchors(file)):
            yield f"{page.relative_to(ROOT)}: {target} leads nowhere"


def unreached():
    """Pages that no chain of links leads to from docs/index.md."""
    reached, ahead = set(), [ROOT / "docs" / "index.md"]
    while ahead:
        page = ahead.pop()
        if page in reached or page.suffix != ".md" or not page.exists():
            continue
        reached.add(page)
        ahead += [(page.parent / target.partition("#")[0]).resolve() for target in links(page) if not target.startswith("#")]
    for page in PAGES:
        if page.resolve() not in reached:
            yield f"{page.relative_to(ROOT)}: no link leads there from docs/index.md"


def early_tables(page):
    """A table of more rows than LONG_TABLE has only captions below it, unless a tool writes the page."""
    parts = re.split(r"((?:^\|.*\n)+)", re.sub(r"<!--.*?-->|^```.*?^```$", "", page.read_text(), flags=re.M | re.S), flags=re.M)
    for i, part in enumerate(parts):
        rows = part.count("\n") - 2 if part.startswith("|") else 0
        words = sum(len(text.split()) for text in parts[i + 1 :] if not text.startswith("|"))
        if rows > LONG_TABLE and words > PROSE_AFTER * sum(text.startswith("|") for text in parts[i:]):
            yield f"{page.relative_to(ROOT)}: a table of {rows} rows with {words} words below it: put it at the end"


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


complaints = [*long_readme(), *unreached()]
for page in PAGES:
    complaints += dead_links(page)
for page in (ROOT / "docs").glob("*.md"):
    if page.name not in GENERATED:
        complaints += early_tables(page)
complaints += wrong_parameters(sys.argv[2])
complaints += wrong_compensation()
print("\n".join(complaints))
sys.exit(bool(complaints))
