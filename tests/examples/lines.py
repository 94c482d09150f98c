"""lines.py: the lines that a user adds to his own project, in each example: those between [add and add] in its sources, without
blank ones and comments. Fails where a table of examples/README.md says otherwise, if their median is over MEDIAN_MAX, or if an example without a
force sensor takes more than JOINT_MAX."""

import pathlib
import re
import statistics
import sys

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"
MEDIAN_MAX = 25
JOINT_MAX = 10
NO_CODE = re.compile(r"\s*(//.*|/\*.*\*/|#(?!\s*(include|define|if|else|endif)\b).*|\"\"\".*\"\"\")?\s*")


def added(text):
    parts = re.findall(r"\[add\b.*?\n(.*?)\n[^\n]*\badd\]", text, re.S)
    return sum(not NO_CODE.fullmatch(line) for part in parts for line in part.splitlines())


def sources(folder):
    return [path for path in sorted(folder.rglob("*")) if path.is_file() and path.suffix != ".md" and "build" not in path.parts]


def counted_in(joints):
    """Of each example with a force sensor its folder, of the `joints` the file. A folder may show the same thing twice, in two languages or two
    arithmetics: each is a whole example."""
    counted = {name: added((EXAMPLES / name).read_text()) for name in joints}
    for folder in sorted(path.parent for path in EXAMPLES.glob("*/README.md")):
        counts = [added(path.read_text()) for path in sources(folder) if path.relative_to(EXAMPLES).as_posix() not in joints]
        if any(counts):
            counted[folder.name + "/README.md"] = max(counts)
    return counted


def main():
    table = (EXAMPLES / "README.md").read_text()
    said = {name: int(lines) for name, lines in re.findall(r"^\| \[\w+\]\((\w+/[\w/.]+)\) .* (\d+) \|$", table, re.M)}
    joints = [name for name in said if not name.endswith(".md")]
    counted = counted_in(joints)
    median = statistics.median(lines for name, lines in counted.items() if name not in joints)
    most = max(counted[name] for name in joints)
    print(*(f"{name}: {lines}, the table says {said.get(name)}" for name, lines in counted.items()), f"median: {median}", sep="\n")
    folders = {path.parent.name for path in EXAMPLES.glob("*/README.md")}
    is_whole = folders == {name.split("/")[0] for name in counted} and all(counted.values())
    return said != counted or median > MEDIAN_MAX or most > JOINT_MAX or not is_whole


if __name__ == "__main__":
    sys.exit(main())
