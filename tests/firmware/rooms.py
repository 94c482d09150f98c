"""Firmware does not know the simulator, but for firmware/desk, nor the simulator firmware; common/ knows neither.

    rooms.py ROOT [SIMULATOR.a PROGRAM... -- DESK]

By the includes of their sources; and no PROGRAM holds a function that SIMULATOR.a defines. DESK, which has some, shows that this sees them.
"""

import pathlib
import re
import subprocess
import sys

ROOMS = ("common", "firmware", "host_sim", "lib/include")


def finds(root, source, name, rooms=ROOMS):
    """The room whose file `source` means by #include "name"; its own folder comes first."""
    if (source.parent / name).exists():
        return source.relative_to(root).parts[0]
    return next((room for room in rooms if (root / room / name).exists()), None)


def includes(root, folder):
    for source in sorted((root / folder).rglob("*.[ch]")):
        for name in re.findall(r'^\s*#\s*include\s+["<]([^">]+)[">]', source.read_text(), re.M):
            yield source, name, finds(root, source, name)


def wrong_includes(root):
    """Each as text, and how many of the desk's are the simulator's."""
    at_desk, wrong = 0, []
    for folder, forbidden in (("common", {"firmware", "host_sim"}), ("host_sim", {"firmware"}), ("firmware", {"host_sim"})):
        for source, name, room in includes(root, folder):
            place = source.relative_to(root)
            if room in forbidden and place.parts[:2] == ("firmware", "desk"):
                at_desk += 1
            elif room in forbidden:
                wrong.append(f'{place} includes "{name}" of {room}/')
    return at_desk, wrong


def functions(binary):
    lines = subprocess.run(["nm", "--defined-only", binary], capture_output=True, text=True, check=True).stdout.splitlines()
    return {parts[2] for parts in map(str.split, lines) if len(parts) == 3 and parts[1] == "T"}


def main(root, *binaries):
    root = pathlib.Path(root)
    at_desk, wrong = wrong_includes(root)
    if at_desk == 0:
        wrong.append("firmware/desk includes nothing of host_sim/: this test sees no includes")
    if binaries:
        simulator, *programs, separator, desk = binaries
        assert separator == "--"
        known = functions(simulator)
        for program in programs:
            wrong += [f"{program} holds {name} of the simulator" for name in sorted(functions(program) & known)]
        if not functions(desk) & known:
            wrong.append(f"{desk} holds nothing of the simulator: this test sees no functions")
    print("\n".join(wrong) or "each room keeps to itself")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
