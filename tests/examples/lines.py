"""lines.py: the lines that a user adds to his own project, in each example: those between [add and add] in its sources, without
blank ones and comments. Fails where the table of examples/README.md says otherwise, and if their median is over MEDIAN_MAX."""

import pathlib
import re
import statistics
import sys

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"
MEDIAN_MAX = 25
NO_CODE = re.compile(r"\s*(//.*|/\*.*\*/|#(?!\s*(include|define|if|else|endif)\b).*|\"\"\".*\"\"\")?\s*")


def added(text):
    parts = re.findall(r"\[add\b.*?\n(.*?)\n[^\n]*\badd\]", text, re.S)
    return sum(not NO_CODE.fullmatch(line) for part in parts for line in part.splitlines())


def count(folder):
    """A folder may show the same thing twice, in two languages or two arithmetics: each is a whole example."""
    counts = [added(path.read_text()) for path in sorted(folder.rglob("*")) if path.is_file() and path.suffix != ".md"
              and "build" not in path.parts]
    return max(counts, default=0)


def main():
    table = (EXAMPLES / "README.md").read_text()
    said = {name: int(lines) for name, lines in re.findall(r"^\| \[(\w+)\]\(.* (\d+) \|$", table, re.M)}
    folders = [path.parent.name for path in EXAMPLES.glob("*/README.md")]
    counted = {name: count(EXAMPLES / name) for name in sorted(folders)}
    median = statistics.median(counted.values())
    print(*(f"{name}: {lines}, the table says {said.get(name)}" for name, lines in counted.items()), f"median: {median}", sep="\n")
    return said != counted or median > MEDIAN_MAX or not all(counted.values())


if __name__ == "__main__":
    sys.exit(main())
