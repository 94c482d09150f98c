"""functions.py FOLDER: no C function below it has more than 60 lines or a cyclomatic complexity of more than 12.

Lines are counted from that of the name to the closing brace. Complexity is 1 and one for each if, for, while, case, ?, && and ||.
Sources are formatted by clang-format, so a function begins with a line at the margin that has a parenthesis, and its braces are at the
margin.
"""

import pathlib
import re
import sys

LINES_MAX = 60
COMPLEXITY_MAX = 12
BRANCH = re.compile(r"\b(?:if|for|while|case)\b|&&|\|\||\?")
NO_CODE = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\])*"' r"|'(?:\\.|[^'\\])*'", re.S)


def functions(text):
    """Name, first line, lines and complexity of each."""
    code = NO_CODE.sub(lambda match: "\n" * match[0].count("\n"), text)
    lines = code.splitlines()
    start = None
    for number, line in enumerate(lines, 1):
        if begin := re.match(r"\w[^=;(]*\b(\w+)\(", line):
            start, name = number, begin[1]
        elif line.startswith("}"):
            if start:
                body = "\n".join(lines[start - 1 : number])
                yield name, start, number - start + 1, 1 + len(BRANCH.findall(body))
            start = None
        elif line.endswith(";") and not line.startswith((" ", "{")):
            start = None


def main():
    root = pathlib.Path(sys.argv[1])
    found = [(path.relative_to(root), *function) for path in sorted(root.rglob("*.[ch]")) for function in functions(path.read_text())]
    for path, name, line, length, complexity in found:
        if length > LINES_MAX or complexity > COMPLEXITY_MAX:
            print(f"{path}:{line}: {name}: {length} lines of {LINES_MAX}, complexity {complexity} of {COMPLEXITY_MAX}")
    longest, hardest = max(row[3] for row in found), max(row[4] for row in found)
    print(f"{len(found)} functions, at most {longest} lines and a complexity of {hardest}")
    return longest > LINES_MAX or hardest > COMPLEXITY_MAX or len(found) < 100


if __name__ == "__main__":
    sys.exit(main())
