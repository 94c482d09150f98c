"""docs.py ROOT: links lead somewhere, each page is reached from docs/index.md, the README stays short, long tables come last.

In a public header the refusals of a set-up, from "Returns TRIBO_OK" on, name public functions and statuses alone.
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1])
README_LINES = 100
LONG_TABLE = 15
PROSE_AFTER = 60  # words: a caption, not a page
PAGES = sorted(page for page in ROOT.rglob("*.md")
               if not any(part == "build" or part.startswith(".") for part in page.relative_to(ROOT).parts))
SPECIFICATIONS = {"feedforward.md"}  # define their symbols before they use them


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


def private_refusals():
    headers = {path.name: path.read_text() for path in (ROOT / "lib" / "include" / "tribo").glob("*.h")}
    code = re.sub(r"///.*", "", "".join(headers.values()))
    public = set(re.findall(r"\btribo_\w+(?=\()", code))
    for name, text in sorted(headers.items()):
        for block in re.findall(r"(?:^ *///.*\n)+", text, re.M):
            refusals = re.search(r"Returns TRIBO_OK.*", re.sub(r"\s*///", " ", block).replace("\n", " "))
            for function in re.findall(r"\btribo_\w+", refusals[0] if refusals else ""):
                if function not in public:
                    yield f"{name}: the refusals name {function}, which is not public"


complaints = [*long_readme(), *unreached(), *private_refusals()]
for page in PAGES:
    complaints += dead_links(page)
for page in (ROOT / "docs").glob("*.md"):
    if page.name not in SPECIFICATIONS:
        complaints += early_tables(page)
print("\n".join(complaints))
sys.exit(bool(complaints))
