"""Parameters of feed-forward and guard from what is known of a rig: the library's own rule, lib/include/tribo/feedforward_f32.h.

The command line takes its options from here, so what is more than the standard library is imported where it is used.
"""

import math

from .errors import DesignError, InputError
from .options import add_number

METHOD = "feedforward"
# Option, its default, least value, where a scenario has it, what it is. The defaults are the paper's rig.
RIG = (
    ("offset", 0.007, 1e-6, "compensator.friction.breakaway.offset_N", "believed breakaway at no force, N"),
    ("slope", 0.3, 0.0, "compensator.friction.breakaway.slope", "and by how much it grows with the force"),
    ("negative-offset", None, 1e-6, "compensator.friction.breakaway.negative_offset_N", "the negative direction's own; as the positive one if left out"),
    ("negative-slope", None, 0.0, "compensator.friction.breakaway.negative_slope", "likewise"),
    ("inertia", 0.00012, 1e-12, "compensator.arm.inertia_N_s2_per_deg", "of the arm, N s2/deg"),
    ("damping", 0.0288, 0.0, "compensator.arm.damping_N_s_per_deg", "of the arm, N s/deg"),
    ("stiffness", 3.84, 1e-12, "compensator.arm.stiffness_N_per_deg", "of the arm, N/deg"),
    ("actuator-pole", 200.0, 1e-3, "plant.actuator_pole_rad_per_s", "rad/s"),
    ("sensor-pole", 55.0, 1e-3, "sensor.pole_rad_per_s", "rad/s"),
    ("usual-force", 0.5, 1e-6, "compensator.usual_force_N", "around which the rig works, N; of a LOOP.yaml without it a quarter of the larger limit of u"),
    ("noise", 0.0, 0.0, "sensor.noise_N", "standard deviation of the reading, N"),
    ("sample-time", 0.001, 1e-6, "sample_time_s", "s"),
)
FULL_SCALE = ("full-scale", None, 1e-6, "limits.full_scale_N", "force that is 2^31 in Q31, N; what Q31 cannot hold is then not printed")
MOST = 1e9
FASTEST = 1e6  # rad/s, the fastest pole that the feed-forward can represent. Within a tick a pole beyond it, or beyond ten Nyquist frequencies, has no effect
TUNED = ("feedforward.actuator_pole_rad_per_s", "feedforward.sensor_pole_rad_per_s", "feedforward.reversal_N", "feedforward.presliding_N", "feedforward.jump_time_s",
         "feedforward.forgetting_per_N", "guard.turn_N", "guard.quick_time_s", "guard.stray_N", "guard.fade_time_s")


def add_options(command):
    command.add_argument("loop", nargs="?", metavar="LOOP.yaml", help="a scenario that has them, as tribo-rig or tribo-identify friction writes it; options count more")
    for name, standard, _, _, text in (*RIG, FULL_SCALE):
        shown = "" if standard is None else f" ({standard:g})"
        add_number(command, f"--{name}", metavar="X", help=text + shown)


def command(options):
    from .reading import read_scenario

    given = {}
    if options.loop:
        loop = read_scenario(options.loop)
        _check(loop, options.loop)
        given = rig_of(loop)
        if not given:
            raise InputError(f"{options.loop}: has no key of a rig: {', '.join(key for *_, key, _ in RIG)}")
    given |= {name: value for name, *_ in (*RIG, FULL_SCALE) if (value := getattr(options, name.replace("-", "_"))) is not None}
    print(as_yaml(tuned(given)), end="")
    return 0


def _check(loop, path):
    """Refuses a table that gives no line."""
    forces = [float(point["force_N"]) for point in _at(loop, "compensator.friction.breakaway.table") or ()]
    if not all(low < high for low, high in zip(forces, forces[1:])):
        raise InputError(f"{path}: compensator.friction.breakaway.table: force_N must rise from point to point")


def rig_of(loop):
    """Returns what a valid scenario says about the rig, by the names of the options."""
    from tribo._native import lib

    found = {}
    for name, _, _, key, _ in (*RIG, FULL_SCALE):
        value = _at(loop, key)
        if value is not None:
            found[name] = float(value)
    limits = [float(_at(loop, f"limits.{name}") or 0.0) for name in ("u_min_N", "u_max_N")]
    if any(limits):
        found["usual-force"] = lib.native_usual_force(found.get("usual-force", 0.0), *limits)
    table = _at(loop, "compensator.friction.breakaway.table")
    if table:  # the nearest line
        import numpy as np

        for sign, way in (("", "positive_N"), ("negative-", "negative_N")):
            slope, offset = np.polyfit([point["force_N"] for point in table], [point[way] for point in table], 1) if len(table) > 1 else (0.0, table[0][way])
            found |= {f"{sign}slope": max(float(slope), 0.0), f"{sign}offset": max(float(offset), 1e-3 * max(point[way] for point in table))}
    return found


def _at(tree, key):
    for part in key.split("."):
        tree = tree.get(part) if isinstance(tree, dict) else None
    return tree


def tuned(given):
    """[(key, value as text)] under `compensator` of a scenario, by the names of the options."""
    from tribo._core import new_error, text
    from tribo._native import ffi, lib

    values = {name: standard for name, standard, *_ in (*RIG, FULL_SCALE)} | given
    for name in ("offset", "slope"):
        if values[f"negative-{name}"] is None:
            values[f"negative-{name}"] = values[name]
    full = values[FULL_SCALE[0]]
    for name, _, least, _, _ in RIG if full is None else (*RIG, FULL_SCALE):
        if not (math.isfinite(values[name]) and least <= values[name] <= MOST):
            raise InputError(f"--{name}: {values[name]:g}, allowed are {least:g} to {MOST:g}")
    fastest = min(10 * math.pi / values["sample-time"], FASTEST)
    for name in ("actuator-pole", "sensor-pole"):
        values[name] = min(values[name], fastest)
    found, error = ffi.new("float[10]"), new_error()
    if not lib.native_tune([values[name] for name, *_ in RIG], found, error):
        raise DesignError(f"tune: the library refuses this rig: {text(error.text)}")
    made = dict(zip(TUNED, found))
    for key, bound, within in () if full is None else (("presliding_N", 1.01e-4 * full, max), ("forgetting_per_N", 31 / full, min)):
        made[f"feedforward.{key}"] = within(made[f"feedforward.{key}"], bound)
    return [(key, f"{value:.6g}") for key, value in made.items()]


def compensator(given):
    """Returns the result as a mapping for a scenario's `compensator`."""
    tree = {"method": METHOD, "guard": {"on": "yes"}}
    for key, value in tuned(given):
        *groups, name = key.split(".")
        place = tree
        for group in groups:
            place = place.setdefault(group, {})
        place[name] = float(value)
    return tree


def as_yaml(pairs):
    lines, open_groups = ["compensator:", f"  method: {METHOD}"], []
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
