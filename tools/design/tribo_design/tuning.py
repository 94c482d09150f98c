"""Parameters of feed-forward and guard from what is known of a rig: the library's own rule, lib/include/tribo/feedforward_f32.h."""

import math
import subprocess

from . import quantise
from .errors import DesignError, InputError

# Option, its default, least value, what it is. The defaults are the paper's rig.
RIG = (
    ("offset", 0.007, 1e-6, "believed breakaway at no force, N"),
    ("slope", 0.3, 0.0, "and by how much it grows with the force"),
    ("negative-offset", None, 1e-6, "the negative direction's own; as the positive one if left out"),
    ("negative-slope", None, 0.0, "likewise"),
    ("inertia", 0.00012, 1e-12, "of the arm, N s2/deg"),
    ("damping", 0.0288, 0.0, "of the arm, N s/deg"),
    ("stiffness", 3.84, 1e-12, "of the arm, N/deg"),
    ("actuator-pole", 200.0, 1e-3, "rad/s"),
    ("sensor-pole", 55.0, 1e-3, "rad/s"),
    ("input-max", 2.0, 1e-6, "largest credible force, N"),
    ("noise", 0.0, 0.0, "standard deviation of the reading, N"),
    ("sample-time", 0.001, 1e-6, "s"),
)
MOST = 1e9


def add_command(commands):
    command = commands.add_parser("tune", help="parameters of the feed-forward and its guard from what is known of a rig")
    for name, standard, _, text in RIG:
        shown = "" if standard is None else f" ({standard:g})"
        command.add_argument(f"--{name}", type=float, default=standard, metavar="X", help=text + shown)


def command(options):
    values = {name: getattr(options, name.replace("-", "_")) for name, *_ in RIG}
    for name in ("offset", "slope"):
        if values[f"negative-{name}"] is None:
            values[f"negative-{name}"] = values[name]
    for name, _, least, _ in RIG:
        if not (math.isfinite(values[name]) and least <= values[name] <= MOST):
            raise InputError(f"--{name}: {values[name]:g}, allowed are {least:g} to {MOST:g}")
    print(as_yaml(tuned([values[name] for name, *_ in RIG])), end="")
    return 0


def tuned(numbers):
    """[(key, value as text)] under `compensator` of a scenario."""
    text = " ".join(f"{number:.9g}" for number in numbers)
    done = subprocess.run([quantise.compiled("tuning")], input=text, capture_output=True, text=True, timeout=60, check=False)
    if done.returncode != 0:
        raise DesignError("tune: the library's rule broke down")
    pairs = [tuple(line.split(" ", 1)) for line in done.stdout.splitlines()]
    if pairs[0][0] == "error":
        raise DesignError(f"tune: the library refuses this rig: {pairs[0][1]}")
    return pairs


def as_yaml(pairs):
    lines, open_groups = ["compensator:", "  method: feedforward"], []
    for key, value in pairs:
        *groups, name = key.split(".")
        for depth, group in enumerate(groups):
            if open_groups[depth:depth + 1] != [group]:
                open_groups = [*open_groups[:depth], group]
                lines.append(f"{'  ' * (depth + 1)}{group}:")
                if group == "guard":
                    lines.append("    on: yes")
        lines.append(f"{'  ' * (len(groups) + 1)}{name}: {value}")
    return "\n".join(lines) + "\n"
