"""docs/your-rig.md, played: what its commands say against what it shows. page.py --update writes what they say into it."""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/your-rig.md"
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.M | re.S)
NUMBER = re.compile(r"(?<![\w.-])-?\d+\.?\d*(?:e-?\d+)?")


def blocks(language):
    return [text for kind, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")) if kind == language]


def play(root):
    """What each of the page's command blocks says, in a folder that has what they need."""
    for name in ("tools", "tests", "lib", "common", "host_sim"):
        (root / name).symlink_to(ROOT / name)
    said = []
    for commands in blocks("sh"):
        done = subprocess.run(["sh", "-eu", "-c", commands], cwd=root, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{commands}\n{done.stdout}{done.stderr}"
        said.append(done.stdout)
    return said


def differs(shown, said):
    """Lines of the page that differ from what was said: word by word, number by number. A number may be 2 % off, as the last digits of a fit are the machine's and the
    compiler's; one below 1e-3 that is next to nothing, a bias, is as good as any other below it."""
    wrong = []
    for one, other in zip(shown.splitlines() + [""] * 99, said.splitlines()):
        a, b = ([float(x) for x in NUMBER.findall(line)] for line in (one, other))
        same = NUMBER.sub("#", one) == NUMBER.sub("#", other) and all(abs(x - y) <= 0.02 * abs(y) or max(abs(x), abs(y)) < 1e-3 for x, y in zip(a, b))
        wrong += [] if same else [f"{one!r} for {other!r}"]
    return wrong + shown.splitlines()[len(said.splitlines()) :]


def main():
    with tempfile.TemporaryDirectory() as name:
        said = iter(play(Path(name)))
    text = PAGE.read_text(encoding="utf-8")
    if sys.argv[1:] == ["--update"]:
        text = BLOCK.sub(lambda found: f"```\n{next(said)}```" if found[1] == "" else found[0], text)
        PAGE.write_text(text, encoding="utf-8")
        return 0
    wrong = [line for shown in blocks("") for line in differs(shown, next(said))]
    print("\n".join(wrong))
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
