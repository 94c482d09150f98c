"""A joint with current and encoder: from logs under the user's own loop to its friction and the code that compensates it."""

import hashlib
import json
from pathlib import Path
from typing import Annotated, Literal, Optional

import numpy as np
from pydantic import Field

from tribo_design.config import Filled, Number, Positive, Strict, load_yaml, validate
from tribo_design.errors import InputError
from tribo_design.output import check_replaceable, write_directory, yaml_text
from tribo_design.reading import read_text
from tribo_plot.command_line import quoted

TEMPLATE = Path(__file__).with_name("joint.yaml")
NAMES = ("config.yaml", "*_joint.h", "main.c", "Makefile", "verdict.json", "report.html")
COLUMNS = {"t": "t_s", "u": "effort", "q": "position"}
ROLES = {"t": "t", "u": "u", "q": "x"}  # of tribo-sim log
PLAY = ("Swing the joint under your own position loop, at working load, and record time, effort (the loop's output) and position at each tick: a sine through its working range, six swings "
        "at working speed and four at half of it; then twenty position steps with a second of rest after each, of a tenth of that range, or less if the effort reaches its limit. "
        "Keep a hand on the emergency stop.")


class Log(Strict):
    """How to read a log, like --column, --unit and --scale of tribo-sim log."""

    columns: dict[Literal["t", "u", "q"], Filled] = {}
    units: dict[Literal["t"], Filled] = {}
    scales: dict[Literal["t", "u", "q"], Number] = {}
    resample: bool = False

    def words(self):
        words = [w for role, name in (COLUMNS | self.columns).items() for w in ("--column", f"{ROLES[role]}={name}")]
        words += ["--unit", "u=N", "--unit", "x=deg", *(w for role, unit in self.units.items() for w in ("--unit", f"{role}={unit}"))]
        words += [w for role, scale in self.scales.items() for w in ("--scale", f"{ROLES[role]}={scale:.12g}")]
        return words + (["--resample"] if self.resample else [])


class Joint(Strict):
    name: Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,30}$")] = "arm"
    sample_time_s: Annotated[Number, Field(ge=1e-6, le=0.1)]
    effort_max: Annotated[Number, Field(ge=1e-6, le=1e6)]
    travel: Optional[Positive] = None
    actuator_pole_rad_per_s: Annotated[Number, Field(ge=1e-3, le=1e6)] | None = None
    arithmetic: Literal["f32", "q31"] = "f32"
    log: Log = Log()


def load(path):
    text, _ = read_text(path)
    data, lines = load_yaml(text, path)
    return validate(Joint, data, path, lines)


def go_on(folder, say):
    """Runs the next step of the folder's joint."""
    joint = load(folder / "joint.yaml")
    paths = sorted(folder.glob("*-log.csv"))
    if not paths:
        return say(PLAY, f"Save the logs as {folder / 'sine-log.csv'} and {folder / 'steps-log.csv'} (every *-log.csv is read), then run: tribo-rig {quoted(folder)}")
    check_replaceable(folder / "result", NAMES)
    from . import slip

    found = slip.identify(_read(paths, joint), joint.effort_max, joint.travel or 0.0)
    _check_travel(joint, found)
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in [folder / "joint.yaml", *paths])).hexdigest()
    lines = lines_of(found)
    files = files_of(joint, found, lines, digest)
    write_directory(folder / "result", files, NAMES)
    return say(*lines, f"Wrote {folder / 'result'}: {', '.join(sorted(files))}")


def _read(paths, joint):
    from tribo_identify import logs

    from . import slip

    made = []
    for path in paths:
        for s in logs.read([path], joint.log.words()).segments:
            if abs(s.h / joint.sample_time_s - 1) > 0.01:
                raise InputError(f"{path}: a row every {s.h:.6g} s, but sample_time_s is {joint.sample_time_s:g} s; record at the tick of the loop, or correct log.units.t")
            made.append(slip.Log(path.name, s.u, s.position, s.h))
    return made


def _check_travel(joint, found):
    if joint.arithmetic == "q31" and not 1 <= found.travel <= 1e4:
        raise InputError(f"joint.yaml: arithmetic: q31 takes positions in counts. The least motion is {found.travel:.4g} in the log's unit; 1 to 10000 counts are allowed: log.scales: {{q: {4 / found.travel:.6g}}} makes "
                         "counts of this unit")


def lines_of(found):
    """The result in half a page of text."""
    per = "the loop's effort for a unit of position a second"
    lines = [f"friction: {found.friction.text()} when the joint slides slowly without load; {found.level:.4g} at the mean load of these logs, {found.load:.3g}",
             f"viscous: {found.viscous.text()}, {per}",
             f"load: friction grows by {found.slope.text()} of the load" if found.slope else
             f"load: no growth of friction found: it would show above {found.hidden:.2g} of the load. Logs at larger loads, e.g. with a payload, show more",
             f"to start: a joint at rest holds {found.breakaway.text()}" if found.breakaway else
             "to start: not found. The logs have too few rests that end slowly, or the joint yields before it slides"]
    if found.fall:
        lines.append(f"friction falls with speed: it is {100 * found.fall:.2g} % larger at {np.min(np.abs(found.rows[0])):.3g} units a second, the slowest in these logs; slower it may be larger still")
    if found.limited:
        lines.append(f"left out: {found.limited} strokes in which the effort reaches effort_max")
    return [*lines, f"from {found.strokes} strokes and {found.starts} slow starts; no friction law explains {found.left:.2g} rms. Intervals are 95 %"]


def config_of(joint, found):
    """The keywords of tribo.Joint."""
    config = {"sample_time_s": joint.sample_time_s, "effort_max": joint.effort_max, "travel": _rounded(found.travel), "breakaway": min(_rounded(found.level), joint.effort_max)}
    if joint.actuator_pole_rad_per_s:
        config["actuator_pole_rad_per_s"] = joint.actuator_pole_rad_per_s
    return config


def _rounded(value):
    return float(f"{value:.4g}")


def files_of(joint, found, lines, digest):
    config, name = config_of(joint, found), joint.name
    head = f"by tribo-rig from logs of SHA-256 {digest[:16]}"
    numbers = {key: None if (e := getattr(found, key)) is None else {"value": e.value, "half": e.half} for key in ("friction", "viscous", "slope", "breakaway")}
    numbers |= {key: getattr(found, key) for key in ("level", "load", "fall", "travel", "left", "strokes", "starts", "limited")}
    return {"config.yaml": f"# The joint for tribo.Joint(**config), {head}\n{yaml_text(config)}".encode(),
            f"{name}_joint.h": _header(joint, config, lines, head).encode(), "main.c": _main(joint).encode(), "Makefile": MAKEFILE.replace("NAME", name).encode(),
            "verdict.json": (json.dumps(numbers, indent=1) + "\n").encode(), "report.html": _report(joint, found, lines).encode()}


def _header(joint, config, lines, head):
    guard, comment = f"{joint.name.upper()}_JOINT_H", "\n".join(f"/// {line}" for line in lines)
    fields = "\n".join(f"    config.{key} = {np.float32(value):.8e}f;" for key, value in config.items())
    return (f"// Made {head}. Do not edit.\n// clang-format off\n#ifndef {guard}\n#define {guard}\n\n#include \"tribo/joint_{joint.arithmetic}.h\"\n\n{comment}\n"
            f"static inline tribo_joint_config_t {joint.name}_joint_config(void)\n{{\n    tribo_joint_config_t config = tribo_joint_config();\n{fields}\n    return config;\n}}\n\n#endif\n")


def _main(joint):
    """A program that reads rows of effort, q_ref and q, to show each call."""
    q31 = joint.arithmetic == "q31"
    step = ("(double)tribo_joint_q31_step(&joint, (int32_t)(effort / config.effort_max * 2147483647.0), (int32_t)q_ref, (int32_t)q) / 2147483648.0 * config.effort_max" if q31 else
            "(double)tribo_joint_f32_step(&joint, (float)effort, (float)q_ref, (float)q)")
    return f"""// Reads rows of effort, q_ref and q, and prints the command for the drive: your tick makes the same call.
#include "{joint.name}_joint.h"

#include <stdio.h>

int main(void)
{{
    static tribo_joint_{joint.arithmetic}_t joint;
    const tribo_joint_config_t config = {joint.name}_joint_config();
    const tribo_status_t status = tribo_joint_{joint.arithmetic}_init(&joint, &config);
    if (status != TRIBO_OK)
    {{
        fprintf(stderr, "%s\\n", tribo_status_text(status));
        return 1;
    }}
    double effort, q_ref, q;
    while (scanf("%lf %lf %lf", &effort, &q_ref, &q) == 3)
    {{
        printf("%.9g\\n", {step});
    }}
    return 0;
}}
"""


MAKEFILE = """# make TRIBO=.../tribo/lib: the program of main.c; your firmware needs NAME_joint.h and the library's sources.
TRIBO ?= lib

NAME: main.c NAME_joint.h
	$(CC) -std=c11 -O2 -ffp-contract=off -Wall -Wextra -I $(TRIBO)/include main.c $(wildcard $(TRIBO)/src/*/*.c) -o $@
"""


def _report(joint, found, lines):
    from tribo_identify.report import figure_of, look, page, picture, thin

    figure, axes = figure_of(1, 1, (9, 4.5))
    speed, friction = thin(*found.rows)
    axes[0, 0].plot(np.abs(speed), friction, ".", ms=3, color=look.MEASURED, label="rows in which the joint slides")
    at = np.linspace(0, np.max(np.abs(speed)), 50)
    axes[0, 0].plot(at, found.level + found.viscous.value * at, color=look.MODEL, label="friction at the mean load, and viscous")
    axes[0, 0].set(xlabel="speed, units of position a second", ylabel="effort against the motion, less the load")
    axes[0, 0].set_ylim(0, None)
    axes[0, 0].legend()
    return page(f"Joint {joint.name}", lines, [("Friction over speed", picture(figure))])
