"""From the logs to the files of the result."""

import json

import numpy as np

from tribo_design.output import yaml_text
from tribo_identify import friction, slides
from tribo_identify.events import Refusal

from . import experiments, lags, law, loop, report

GAINS = 1.2  # factor by which the error falls, below which the verdict calls it little
BUDGET_US = 250  # the drive's default, which must not be beyond its period
APART = 0.05  # of the whole lag: half intervals below which one lag is told from another
UNSURE = 0.1  # relative half interval of L, above which the report asks for more


def of(rig, first, made, log, digest):
    """(files of the result, lines to say)."""
    steps = experiments.part(log, 0.0, made.split_s)
    found = lags.fit(steps.segments[0], first, rig.known)
    if found.residual_rms > lags.LEFT * found.level:
        raise Refusal("model", f"2-slides-log.csv: no lags and friction make the steps of this log: F is off by {found.residual_rms:.3g} N rms, {100 * found.residual_rms / found.level:.2g} % of "
                               "breakaway. Is the arm against a stiff contact, and u what the motor got? Play 2-slides.csv again, and look whether F repeats itself")
    slow = experiments.part(log, made.split_s - experiments.REST_S, made.time[-1])
    known = {name: found.params[name] for name in ("actuator", "sensor", "damping", "inertia", "stiffness", "delay")}
    result, arm = law.fit(found, friction.identify(slow, known, rig.assume, allow_slides=False), log.segments[0], first)
    result.fall = _fall(slow, rig.assume)
    base = loop.scenario(rig, found, result, arm, first.noise)
    tuned, designed, runs, others, refused = loop.make(rig, found, base, digest)
    per_n = rig.command_per_N / result.params["scale"]
    lines = verdict(rig, tuned, found, result, arm, runs, others, per_n)
    text = loop.header(tuned, rig)
    factor = f"#define {rig.name.upper()}_COMMAND_PER_N {np.float32(per_n):.8e}f ///< what the drive puts out for a newton of u\n"
    files = {"loop.yaml": (_head(per_n, digest) + yaml_text(tuned)).encode(),
             f"{rig.name}_params.h": text.replace("// clang-format off\n", "// clang-format off\n" + factor, 1).encode(),
             "registers.txt": registers(rig, tuned, per_n).encode(),
             "verdict.json": (json.dumps(numbers(tuned, found, result, arm, runs, per_n), indent=1) + "\n").encode()}
    details = [*friction.line_of(result), *(f"note: {r}" for r in result.remarks), *(f"tried and left: {r}" for r in refused)]
    files["report.html"] = report.html(rig, lines, details, tuned, found, result, steps, slow, designed).encode()
    return files, lines


def _fall(slow, assume):
    """Of friction once it slides, and half of the interval: as tribo_identify sees it."""
    line = slides.line(slow, assume)
    return slides.fall(slow, line) if line is not None and line.is_sure() else (0.0, np.inf)


def _head(per_n, digest):
    return (f"# The loop of your rig, by tribo-rig from logs of SHA-256 {digest[:16]}. u is in newton of F at rest: put u times {per_n:.6g} out.\n"
            "# tribo-sim run plays it; tribo-identify accept judges it on the rig.\n")


def numbers(made, found, result, arm, runs, per_n):
    return {"command_per_N": per_n, "lags_s": _lags(found), "lags_within_s": found.halves, "law": found.law,
            "friction": {e.name: e.value for e in result.estimates}, "known_within": result.L_half, "falls_by": arm.falls or (result.fall[0] if _falls(result) else 0.0),
            "predicted_rms_N": {case: [run.rms for run in plants] for case, plants in runs.items()},
            "task_N": [made["reference"]["low_N"], made["reference"]["high_N"]]}


def verdict(rig, made, found, result, arm, runs, others, per_n):
    """Half a page in words: what was found, what is to be expected, what to do next."""
    low, high = made["reference"]["low_N"], made["reference"]["high_N"]
    middle = (low + high) / 2
    L = float(np.mean(friction.breakaway(result.params, result.table, middle)))
    off, on = ([run.rms for run in runs[case]] for case in ("off", "on"))
    factor = off[1] / on[1]
    well = "tuned" if factor >= GAINS else "tuned, but it gains little"
    simulated = arm.falls > friction.FALL
    falls = _falls(result) and not simulated
    lines = [f"VERDICT: {well}{', but friction falls as it slides, which is not simulated' if falls else ''}: compensation divides the error on a triangle of {low:.3g} to {high:.3g} N by {factor:.3g} "
             f"({min(a / b for a, b in zip(off, on)):.3g} to {max(a / b for a, b in zip(off, on)):.3g} if breakaway is off by 10 %), from {off[1]:.3g} to {on[1]:.3g} N rms; simulated.",
             f"friction: {L:.4g} N at {middle:.3g} N{' once it slides' if falls or simulated else ''}" + (f", a table of {len(result.table)} loads" if result.table else ", " + _laws(result))
             + f"; known within {100 * result.L_half:.2g} %" + (" if it is the same both ways" if result.assume == "symmetric" else "") + (f"; builds up while F goes {arm.way:.3g} N, so that feed-forward of a jump gains less" if arm.way else ""),
             directions(rig, result, middle),
             f"command: put u times {per_n:.6g} out" + (f" (a newton of yours makes {rig.command_per_N / per_n:.4g} N)" if abs(rig.command_per_N / per_n - 1) > 0.005 else "")
             + f"; bias or gravity {result.params['gravity']:.3g} N",
             lags_of(found),
             f"the model leaves {100 * found.residual_rms / found.level:.2g} % of breakaway in the steps, {100 * result.residual_rms / found.level:.2g} % in the slides"]
    if others:
        lines.append(f"the steps do not tell the actuator's lag from the sensor's: with those of the other models the error is divided by {min(a.rms / b.rms for a, b in others):.3g}. "
                     "A data sheet's pole of the sensor or the current loop tells (known in rig.yaml)")
    noise = law.UNEXPLAINED * made["sensor"]["noise_N"]
    if simulated:
        lines.append(f"friction falls with speed: breakaway is {100 * arm.falls:.2g} +- {100 * arm.falls_half:.1g} % above sliding, {(1 + arm.falls) * L:.4g} N for {L:.4g} N, where F moves by well below {arm.speed:.2g} N/s; "
                     "the simulation has it, the compensation has sliding")
    if falls:
        share, half = result.fall
        lines.append(f"friction falls once it slides: breakaway is at least {100 * share:.2g} +- {100 * half:.1g} % above sliding, {(1 + share) * L:.4g} N for {L:.4g} N. F jumps where it breaks away: the error "
                     "with compensation may be more than ten times what is predicted")
    if not falls and max(found.residual_rms, result.residual_rms) > noise:
        lines.append("no law of friction that was tried leaves noise alone: the error with compensation may be some ten percent off what is predicted")
    if result.L_half > UNSURE and result.residual_rms <= noise:
        lines.append("more would be known from 2-slides.csv played again in a quieter hour")
    return lines + [f"next: params of {rig.name}_params.h into the drive, then on the rig tribo-identify accept loop.yaml --low {low:.3g} --high {high:.3g} --out sequence"]


def _falls(result):
    return result.fall[0] > friction.FALL + result.fall[1]


def _laws(result):
    p = result.params
    plus, minus = (f"{p[f'offset_{way}']:.4g} N + {p[f'slope_{way}']:.4g} |F|" for way in ("positive", "negative"))
    return plus if result.assume == "symmetric" else f"L+ {plus}, L- {minus}"


def directions(rig, result, force):
    """How friction differs by direction; or what no log at forces of one sign can tell, and what it would be."""
    if result.assume == "calibrated":
        L = [float(x) for x in friction.breakaway(result.params, result.table, force)]
        return (f"directions: L+ {L[0]:.4g} N, L- {L[1]:.4g} N at {force:.3g} N: downwards it is {L[1] / L[0]:.3g} times that upwards, if u is right as rig.yaml has it (known.command); "
                "a bias of u would show as their difference")
    L = float(np.mean(friction.breakaway(result.params, result.table, force)))
    if rig.force.low_N < 0:
        return "directions: L+ = L- is assumed; a difference that is the same at all forces looks like a bias of u, one that grows with |F| is part of what the slides leave"
    text = (f"directions: L+ = L- is assumed, as at forces of one sign no log tells a difference from scale and bias of u. If a newton of yours made 1 % more than below, L+ would be {(force + L) / 100:.3g} N more "
            f"and L- {(force - L) / 100:.3g} N less")
    plus, minus = friction.by_direction(result, force)
    other = abs(plus - minus) > friction.APART * L and min(plus, minus) > 0
    return text + (f". If your command is right, L+ is {plus:.3g} N and L- {minus:.3g} N: then say known: {{command: true}} in rig.yaml" if other else "")


def _lags(found):
    return {"actuator": 1 / found.actuator, "arm": found.damping, "sensor": 1 / found.sensor, "delay": found.delay}


def lags_of(found):
    """Each with its interval, if the steps tell them apart."""
    values = _lags(found)
    apart = max(found.halves.values()) < APART * found.whole
    text = ", ".join(f"{name} {1e3 * value:.2f} ms" + (f" +- {1e3 * found.halves[name]:.2g}" if apart and found.halves[name] else "") for name, value in values.items())
    return f"lags: {text}; {1e3 * found.whole:.3g} ms in all" + ("" if apart else ". The sum is sure; which lag is whose is not (known in rig.yaml tells)")


def registers(rig, made, per_n):
    """For a drive of this project: what its bus needs beside the loop. A drive takes tick and sample time only together."""
    keys = {"sample_time_s": made["sample_time_s"], "drive.period_us": round(1e6 * rig.sample_time_s), "drive.command_n_per_unit": abs(1 / per_n), "drive.command_reversed": int(per_n < 0),
            "drive.full_scale_n": made["limits"]["full_scale_N"]}
    if keys["drive.period_us"] < BUDGET_US:
        keys["drive.budget_us"] = keys["drive.period_us"]
    sets = " ".join(f"{key}={value:.7g}" for key, value in keys.items())
    return f"tribo-link params set {sets}\ntribo-link params from loop.yaml\ntribo-link params save\n"
