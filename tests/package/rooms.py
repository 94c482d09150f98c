"""rooms.py LIB: the rooms of the library include each other only downwards, in at most ARROWS_MAX arrows, so without circles.

A room is a folder of LIB/src and the public headers that it implements, HEADERS. Every source, private header and public header is
in a room; a folder that is not in ROOMS or a public header that is in no room fails, and so does a private header named like a public one.
"""

import pathlib
import re
import sys

ROOMS = ["number", "friction", "controller", "loop", "feedforward", "axis", "joint"]  # from the bottom to the top
HEADERS = {
    "number": ["parameters.h", "q31.h", "status.h"],
    "friction": ["friction_f32.h", "friction_q31.h"],
    "controller": ["controller_f32.h", "controller_q31.h", "paper_controller.h"],
    "loop": ["force_loop_f32.h", "force_loop_q31.h"],  # with the guard, which the loop calls
    "feedforward": ["feedforward_f32.h", "feedforward_q31.h"],
    "axis": ["axis_f32.h", "axis_q31.h"],
    "joint": ["joint_f32.h", "joint_q31.h"],
}
ARROWS_MAX = 12
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)


def rooms_of(lib):
    """The room of each file, and what is wrong."""
    rooms, complaints = {}, []
    public = {path.name: path for path in (lib / "include/tribo").glob("*.h")}
    owner = {name: room for room, names in HEADERS.items() for name in names}
    for name, path in sorted(public.items()):
        rooms[path] = owner.get(name)
        if rooms[path] is None:
            complaints.append(f"include/tribo/{name}: in no room")
    complaints += [f"include/tribo/{name}: there is none" for name in sorted(set(owner) - set(public))]
    for path in sorted((lib / "src").rglob("*.[ch]")):
        rooms[path] = path.parent.relative_to(lib / "src").as_posix()
        if rooms[path] not in ROOMS:
            complaints.append(f"{path.relative_to(lib)}: not in one of {', '.join(ROOMS)}")
        if path.suffix == ".h" and path.name in public:
            complaints.append(f"{path.relative_to(lib)}: named like a public header")
    return rooms, complaints


def target_of(lib, source, name):
    places = [source.parent / name, lib / "src" / name, lib / "include" / name]
    return next((place.resolve() for place in places if place.exists()), None)


def main():
    lib = pathlib.Path(sys.argv[1]).resolve()
    rooms, complaints = rooms_of(lib)
    arrows = {}
    for source in rooms:
        for name in INCLUDE.findall(source.read_text()):
            target = target_of(lib, source, name)
            if target not in rooms:
                complaints.append(f"{source.relative_to(lib)} includes {name}: not found")
            elif rooms[source] != rooms[target]:
                line = f"{source.relative_to(lib)} includes {target.relative_to(lib)}"
                arrows.setdefault((rooms[source], rooms[target]), []).append(line)
    floor = {room: i for i, room in enumerate(ROOMS)}
    upwards = [pair for pair in arrows if floor.get(pair[0], -1) < floor.get(pair[1], -1)]
    circles = [pair for pair in arrows if pair[0] < pair[1] and pair[::-1] in arrows]
    complaints += [f"upwards: {line}" for pair in upwards for line in arrows[pair]]
    if len(arrows) > ARROWS_MAX:
        complaints.append(f"{len(arrows)} arrows, more than {ARROWS_MAX}")
    print(f"{len(arrows)} arrows, {len(upwards)} upwards, {len(circles)} circles of two: " + ", ".join(f"{a} -> {b}" for a, b in sorted(arrows)))
    print("\n".join(complaints))
    return bool(complaints) or not arrows


if __name__ == "__main__":
    sys.exit(main())
