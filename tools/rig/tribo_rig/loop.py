"""The loop for the identified rig: controller, feed-forward and guard, as a scenario; and its performance on the identified plant."""

import copy
import tempfile
from pathlib import Path

import numpy as np

from tribo_design import pipeline, progress, tuning
from tribo_design.config import validate, Design
from tribo_design.errors import DesignError
from tribo_design.output import yaml_text
from tribo_identify import accept, command_friction, native

from . import unexplained
from .lags import BUILDS_UP, substeps

CROSSOVER = 0.7  # of the loop's bandwidth by its whole lag: the wish that the design starts with
SLOWER = (1.0, 0.7, 0.5, 0.35, 0.25)  # times that, until the loop is robust
U_PER_R = 4.0
ROOM = 1.5  # of full scale and largest credible force over the safe ones
USUAL = 0.375  # of the largest safe force: where a loop mostly works
LAGS = (0.8, 1.25)  # of the plant over the model, that compensation must still help with
HELPS = 0.9  # of the error without compensation: in the worst of all plants it must be below


class NotSafe(DesignError):
    """No loop is better than no compensation on all plants near the identified one."""

    exit_code = 4


def plant_of(lags, h):
    """The plant from u in newton of F at rest, so with gain 1; poles beyond ten Nyquist frequencies are left out."""
    arm = np.roots([lags.inertia, lags.damping, 1.0])
    poles = [p for p in (-lags.actuator, *arm, -lags.sensor) if abs(p) < 10 * np.pi / h]
    return {"gain": 1.0, "zeros": [], "poles": [f"{p.real:.9g}{p.imag:+.9g}j" if np.imag(p) else f"{np.real(p):.9g}" for p in poles], "delay_s": lags.delay}


def design_of(rig, lags, bandwidth):
    limit = ROOM * rig.force.largest
    data = {"name": rig.name, "sample_time_s": rig.sample_time_s, "plant": plant_of(lags, rig.sample_time_s),
            "weights": {"wishes": {"bandwidth_rad_s": bandwidth, "u_per_r": U_PER_R}},
            "fixed_point": {"full_scale_n": 2 * limit, "u_max_n": limit}, "ramp": {"rate_n_per_s": 0.1 * rig.force.largest, "duration_s": 5.0}}
    return validate(Design, data, "rig.yaml")


def task_of(rig, result):
    """Low and high force of the loop: the user's, or those of the experiment."""
    if rig.task is not None:
        return rig.task.low_N, rig.task.high_N
    low, high = result.loads[0][0], result.loads[-1][1]
    return low + 0.25 * (high - low), high - 0.1 * (high - low)


def scenario(rig, lags, result, law, readings, ripple):
    """The loop without its controller, as a scenario with the identified plant. The loop has the friction of sliding."""
    low, high = task_of(rig, result)
    number = lambda x: float(f"{x:.9g}")
    arm = {"inertia_N_s2_per_deg": number(lags.inertia), "damping_N_s_per_deg": number(lags.damping), "stiffness_N_per_deg": 1.0}
    friction = command_friction.mapping_of(result)
    friction["pulse_width_s"] = number(3 * rig.sample_time_s)
    tree = {"description": f"{rig.name}, by tribo-rig", "duration_s": 40.0, "sample_time_s": rig.sample_time_s,
            "reference": {"kind": "triangle", "low_N": number(low), "high_N": number(high), "period_s": 10.0},
            "plant": {"step_s": number(rig.sample_time_s / substeps(rig.sample_time_s)), "actuator_pole_rad_per_s": number(lags.actuator), "arm": arm,
                      "friction": accept.scaled(friction, 1 + law.falls), **law.plant, **(ripple.keys() if ripple else {})},
            "sensor": {"pole_rad_per_s": number(lags.sensor), "delay_s": number(lags.delay), "noise_N": number(readings.noise), "quantisation_N": number(readings.step)},
            "controller": {"kind": "none"}, "compensator": {"usual_force_N": number(USUAL * rig.force.largest), "arm": arm, "friction": friction},
            "limits": {"u_min_N": number(min(rig.force.low_N, 0.0)), "u_max_N": number(rig.force.high_N), "input_max_N": number(ROOM * rig.force.largest),
                       "full_scale_N": number(2 * ROOM * rig.force.largest)},
            "metrics": {"start_s": 10.0}}
    return copy.deepcopy(tree)  # no value in two places


def predicted(loop, readings, others):
    """Runs of accept by case, for L 10 % less, right, 10 % more; and (off, on) with wrong lags: all lags, and for `others` the poles of actuator and sensor."""
    low, high = loop["reference"]["low_N"], loop["reference"]["high_N"]
    runs = accept.predict(loop, low, high, readings)
    lags = []
    with tempfile.TemporaryDirectory() as name:
        actuator, sensor = loop["plant"]["actuator_pole_rad_per_s"], loop["sensor"]["pole_rad_per_s"]
        for poles in (*((actuator / times, sensor / times) for times in LAGS), *others):
            pair = []
            for case in ("off", "on"):
                tree = accept.case_of(loop, case, low, high)
                tree["plant"]["actuator_pole_rad_per_s"], tree["sensor"]["pole_rad_per_s"] = poles
                pair.append(accept.run(tree, readings, Path(name)))
            lags.append(pair)
    return runs, lags


def against(runs, lags, left):
    """Reasons against this loop, or none. `left` is the part of r - F that the law does not explain."""
    reasons = []
    ratio = np.hypot(runs["on"][1].rms, left) / np.hypot(runs["off"][1].rms, left)
    if ratio > HELPS:
        reasons.append(f"with the residual of the law the error is {ratio:.2g} times that without compensation")
    for case, what in (("on", "the identified friction"), ("less", "L 20 % less in the loop"), ("more", "L 20 % more in the loop")):
        worst = max(on.rms / off.rms for on, off in zip(runs[case], runs["off"]))
        if worst > HELPS:
            reasons.append(f"with {what} the error is {worst:.2g} times that without compensation")
    for pairs, what in ((lags[: len(LAGS)], f"lags {LAGS[0]:g} to {LAGS[1]:g} times the identified ones"), (lags[len(LAGS) :], "the lags of another model that fits almost as well")):
        worst = max((on.rms / off.rms for off, on in pairs), default=0.0)
        if worst > HELPS:
            reasons.append(f"with {what} the error is {worst:.2g} times that without compensation")
    return reasons


def make(rig, lags, base, readings, left, digest):
    """(loop, design's result, predicted runs, those with lags of other models, its response to `left`, refusals) of the highest bandwidth that passes.
    `base` is the loop without controller."""
    refused = []
    base["compensator"] |= tuning.compensator(tuning.rig_of(base) | {"noise": readings.rms})
    wishes = [rig.bandwidth_rad_s] if rig.bandwidth_rad_s else [part * CROSSOVER / (lags.whole + rig.sample_time_s) for part in SLOWER]
    for bandwidth in wishes:
        progress.at(f"designs a loop of {bandwidth:.3g} rad/s")
        try:
            designed = pipeline.synthesize(design_of(rig, lags, bandwidth), digest, "rig.yaml")
        except DesignError as error:
            refused.append(f"bandwidth {bandwidth:.3g} rad/s: {str(error).splitlines()[0]}")
            continue
        rows = [dict(zip(("b0", "b1", "b2", "a1", "a2"), (float(f"{x:.9g}") for x in row))) for row in np.array(designed.f32, float)]
        loop = base | {"controller": {"kind": "delta", "sections": rows}}
        progress.at(f"plays the loop of {bandwidth:.3g} rad/s on plants near the identified one")
        runs, other = predicted(loop, readings, lags.others)
        echo = unexplained.in_loop(loop, left)
        reasons = against(runs, other, echo)
        if not reasons:
            return loop, designed, runs, other[len(LAGS) :], echo, refused
        refused.append(f"bandwidth {bandwidth:.3g} rad/s: {'; '.join(reasons)}")
    way = base["plant"].get("model") in BUILDS_UP
    raise NotSafe("no loop was found that is better than no compensation on all plants near this one:\n" + "\n".join(refused) + "\nWhat would help: "
                  + ("friction builds up over a travel here: use a reference with longer strokes (task in rig.yaml)" if way else
                     "a shorter delay or a faster sensor, or a task further from 0 N (task in rig.yaml)"))


def header(loop, rig):
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "loop.yaml"
        path.write_text(yaml_text(loop), encoding="utf-8")
        return native.run_tribo_sim("params", path, "--arith", rig.arithmetic, "--name", rig.name)[0]
