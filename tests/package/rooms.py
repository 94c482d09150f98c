"""rooms.py LIB_SRC: the folders of lib/src include each other only downwards, in at most PAIRS_MAX pairs, so without circles.

Files beside the folders (status, parameters) are at the bottom. A folder that is not in ROOMS fails.
"""

import pathlib
import re
import sys

ROOMS = ["number", "controller", "paper", "feedforward", "guard", "loop"]  # from the bottom to the top
PAIRS_MAX = 20


def floor(room):
    return ROOMS.index(room) if room != "." else -1


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    pairs = {}
    for source in sorted(root.rglob("*.[ch]")):
        for name in re.findall(r'^\s*#\s*include\s+"([^"]+)"', source.read_text(), re.MULTILINE):
            target = next((p for p in ((source.parent / name).resolve(), (root / name).resolve()) if p.exists()), None)
            if target is None or root not in target.parents:
                continue  # public: tribo/NAME.h
            pair = tuple(p.parent.relative_to(root).as_posix() for p in (source, target))
            if pair[0] != pair[1]:
                pairs.setdefault(pair, []).append(f"{source.relative_to(root)} includes {target.relative_to(root)}")
    unknown = {room for pair in pairs for room in pair} | {p.relative_to(root).as_posix() for p in root.iterdir() if p.is_dir()}
    unknown -= {".", *ROOMS}
    complaints = [f"{room}/: not one of {', '.join(ROOMS)}" for room in sorted(unknown)]
    if not unknown:
        upwards = [pair for pair in pairs if floor(pair[0]) <= floor(pair[1])]
        complaints += [f"upwards: {line}" for pair in upwards for line in pairs[pair]]
    if len(pairs) > PAIRS_MAX:
        complaints.append(f"{len(pairs)} pairs of folders, more than {PAIRS_MAX}")
    print(f"{len(pairs)} pairs: " + ", ".join(f"{a} -> {b}" for a, b in sorted(pairs)))
    print("\n".join(complaints))
    return bool(complaints) or not pairs


if __name__ == "__main__":
    sys.exit(main())
