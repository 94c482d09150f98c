"""From the logs to the files of the result."""

import json
from dataclasses import replace

import numpy as np

from tribo_design import progress
from tribo_design.output import yaml_text
from tribo_identify import accept, bins, friction, slides
from tribo_identify.events import Refusal

from . import cogging, experiments, lags, law, loop, report, unexplained

GAINS = 1.2  # factor of the error below which the verdict calls the gain little
BUDGET_US = 250  # the drive's default, which must not be beyond its period
APART = 0.05  # of the whole lag: half intervals below which one lag is told from another
PASSES = 3  # of cogging and line
COARSE = 0.05  # of breakaway: a sensor's steps that are named
NAMED = 0.01  # likewise, of what the law leaves
UNSURE = 0.1  # relative half interval of L, above which the report asks for more


def of(rig, first, made, log, digest):
    """Returns (files of the result, lines to print)."""
    log, slow, line, ripple = _without_cogging(log, made, rig.assume)
    steps = experiments.part(log, 0.0, made.split_s)
    found = lags.fit(steps.segments[0], first, rig.known)
    _refuse_what_is_left(found, steps.segments[0], first.readings)
    progress.at("fits friction to the slides")
    known = {name: found.params[name] for name in ("actuator", "sensor", "damping", "inertia", "stiffness", "delay")}
    result, arm = law.fit(found, friction.identify(slow, known, rig.assume, allow_slides=False), log.segments[0], first)
    result.fall = _fall(slow, line, first.readings.step / 2 / found.level)
    left = unexplained.of(slow.segments[0], result.model[0], first.readings, found.level)
    base = loop.scenario(rig, found, result, arm, first.readings, ripple)
    tuned, designed, runs, others, echo, refused = loop.make(rig, found, base, first.readings, left, digest)
    per_n = rig.command_per_N / result.params["scale"]
    expected = accept.expected(runs, echo)
    lines = verdict(rig, tuned, found, result, arm, expected, others, per_n) + unsure(first.readings, found, result, left, ripple) + [_next(rig, tuned)]
    text = loop.header(tuned, rig)
    factor = f"#define {rig.name.upper()}_COMMAND_PER_N {np.float32(per_n):.8e}f ///< output of the drive for a newton of u\n"
    files = {"loop.yaml": (_head(per_n, digest) + yaml_text(tuned)).encode(),
             f"{rig.name}_params.h": text.replace("// clang-format off\n", "// clang-format off\n" + factor, 1).encode(),
             "registers.txt": registers(rig, tuned, per_n).encode(),
             "verdict.json": (json.dumps(numbers(tuned, found, result, arm, runs, expected, echo, per_n), indent=1) + "\n").encode()}
    progress.at("draws the report")
    details = [*friction.line_of(result), *(f"note: {r}" for r in result.remarks), *(f"tried and rejected: {r}" for r in refused)]
    files["report.html"] = report.html(rig, first, lines, details, tuned, found, result, steps, slow, designed).encode()
    return files, lines


def _without_cogging(log, made, assume):
    """The log, its slides, the line through them and the cogging: u as if the motor had been commanded to cancel it. Cogging bends the line, so it is searched again."""
    whole, ripple, played = log.segments[0], None, log
    for _ in range(PASSES):
        slow = experiments.part(played, made.split_s - experiments.REST_S, made.time[-1])
        line = slides.line(slow, assume)
        found = cogging.find(experiments.part(log, made.split_s - experiments.REST_S, made.time[-1]), line)
        if found is None:
            break
        ripple = found
        played = replace(log, segments=[replace(whole, u=whole.u + ripple.at(whole.force) / line.law()["scale"])])
    return played, experiments.part(played, made.split_s - experiments.REST_S, made.time[-1]), line, ripple


def _refuse_what_is_left(found, segment, readings):
    """Refuses the steps if their residual is too large for any use."""
    error = bins.beyond(segment.force - found.model, readings, 1)
    beyond = float(np.sqrt(np.mean(error[int((experiments.REST_S + experiments.APPROACH_S) / segment.h) :] ** 2)))
    if beyond <= lags.LEFT * found.level:
        return
    causes = unexplained.of(segment, found.model, readings, found.level).causes
    raise Refusal("model", f"2-slides-log.csv: no lags and friction explain the steps of this log: F is off by {beyond:.3g} N rms beyond the sensor's noise, {100 * beyond / found.level:.2g} % of "
                           "breakaway" + (f". The residual follows {causes[0][0]}" if causes else "") + ". Is the arm against a stiff contact, and is u what the motor got? Play 2-slides.csv again, "
                           "and check whether F repeats")


def _fall(slow, line, rounding):
    """The fall of friction once the arm slides, and half of its interval: that of tribo_identify, less the part that readings rounded by `rounding` cause."""
    if line is None or not line.is_sure():
        return 0.0, np.inf
    share, half = slides.fall(slow, line)
    return share - rounding, half


def _head(per_n, digest):
    return (f"# The loop of your rig, by tribo-rig from logs of SHA-256 {digest[:16]}. u is in newton of F at rest: output u times {per_n:.6g}.\n"
            "# tribo-sim run plays it; tribo-identify accept judges it on the rig.\n")


def numbers(made, found, result, arm, runs, expected, echo, per_n):
    return {"command_per_N": per_n, "lags_s": _lags(found), "lags_within_s": found.halves, "law": found.law,
            "friction": {e.name: e.value for e in result.estimates}, "known_within": result.L_half, "falls_by": arm.falls or (result.fall[0] if _falls(result) else 0.0),
            "divided_by": expected.factors, "unexplained_rms_N": echo, "predicted_rms_N": {case: [run.rms for run in plants] for case, plants in runs.items()},
            "task_N": [made["reference"]["low_N"], made["reference"]["high_N"]]}


def verdict(rig, made, found, result, arm, expected, others, per_n):
    """The result in half a page of text: what was identified, and what to expect."""
    low, high = made["reference"]["low_N"], made["reference"]["high_N"]
    middle = (low + high) / 2
    L = float(np.mean(friction.breakaway(result.params, result.table, middle)))
    factor, least, most = expected.factors
    well = "tuned" if factor >= GAINS else "tuned, but it gains little"
    simulated = arm.falls > friction.FALL
    falls = _falls(result) and not simulated
    lines = [f"VERDICT: {well}{', but friction falls as it slides, which is not simulated' if falls else ''}: compensation divides the error on a triangle of {low:.3g} to {high:.3g} N by {factor:.3g} "
             f"({least:.3g} to {most:.3g} with the uncertainty of the rig), from {expected.off:.3g} to {expected.on:.3g} N rms; simulated.",
             f"friction: {L:.4g} N at {middle:.3g} N{' once it slides' if falls or simulated else ''}" + (f", a table of {len(result.table)} loads" if result.table else ", " + _laws(result))
             + f"; known within {100 * result.L_half:.2g} %" + (" if it is the same both ways" if result.assume == "symmetric" else "") + (f"; builds up while F moves by {arm.way:.3g} N, so feeding a jump forward gains less" if arm.way else ""),
             directions(rig, result, middle),
             f"command: output u times {per_n:.6g}" + (f" (a newton of your command makes {rig.command_per_N / per_n:.4g} N)" if abs(rig.command_per_N / per_n - 1) > 0.005 else "")
             + f"; bias or gravity {result.params['gravity']:.3g} N",
             lags_of(found),
             f"the model leaves {100 * found.residual_rms / found.level:.2g} % of breakaway in the steps, {100 * result.residual_rms / found.level:.2g} % in the slides"]
    if others:
        lines.append(f"the steps do not separate the actuator's lag from the sensor's: with the lags of the other models the error is divided by {min(a.rms / b.rms for a, b in others):.3g}. "
                     "A pole of the sensor or the current loop from a data sheet separates them (known in rig.yaml)")
    if simulated:
        lines.append(f"friction falls with speed: breakaway is {100 * arm.falls:.2g} +- {100 * arm.falls_half:.1g} % above sliding, {(1 + arm.falls) * L:.4g} N instead of {L:.4g} N, where F moves well below {arm.speed:.2g} N/s; "
                     "the simulation includes this, the compensation uses sliding friction")
    if falls:
        share, half = result.fall
        lines.append(f"friction falls once it slides: breakaway is at least {100 * share:.2g} +- {100 * half:.1g} % above sliding, {(1 + share) * L:.4g} N instead of {L:.4g} N. F jumps where it breaks away: the error "
                     "with compensation may be more than ten times the prediction")
    return lines


def unsure(readings, found, result, left, ripple):
    """Other findings in the log, and what would show more."""
    lines = []
    if readings.step > COARSE * found.level:
        lines.append(f"sensor: it reads in steps of {readings.step:.3g} N, {100 * readings.step / found.level:.2g} % of breakaway; the simulation includes them, and no loop follows F within them")
    if ripple:
        lines.append(f"cogging: {ripple.amplitude:.3g} N, {100 * ripple.amplitude / found.level:.2g} % of breakaway, a wave each {ripple.period:.3g} N of F; the simulation includes it, the compensation does not")
    if left.rms > NAMED * found.level:
        lines.append(f"no friction law that was tried leaves only noise: {left.rms:.2g} N rms remain, {100 * left.rms / found.level:.2g} % of breakaway"
                     + "".join(f"; {100 * share:.2g} % of that follows {what}" for what, share in left.causes) + ". The range of the verdict includes it")
    elif result.L_half > UNSURE:
        lines.append("2-slides.csv played again in a quieter hour would narrow the intervals")
    return lines


def _next(rig, made):
    low, high = made["reference"]["low_N"], made["reference"]["high_N"]
    return f"next: put the params of {rig.name}_params.h into the drive, then run on the rig: tribo-identify accept loop.yaml --low {low:.3g} --high {high:.3g} --out sequence"


def _falls(result):
    return result.fall[0] > friction.FALL + result.fall[1]


def _laws(result):
    p = result.params
    plus, minus = (f"{p[f'offset_{way}']:.4g} N + {p[f'slope_{way}']:.4g} |F|" for way in ("positive", "negative"))
    return plus if result.assume == "symmetric" else f"L+ {plus}, L- {minus}"


def directions(rig, result, force):
    """How friction differs by direction; or what a log at forces of one sign cannot show, and how large it would be."""
    if result.assume == "calibrated":
        L = [float(x) for x in friction.breakaway(result.params, result.table, force)]
        return (f"directions: L+ {L[0]:.4g} N, L- {L[1]:.4g} N at {force:.3g} N: downwards it is {L[1] / L[0]:.3g} times that upwards, if u is right, as rig.yaml says (known.command); "
                "a bias of u would look like their difference")
    L = float(np.mean(friction.breakaway(result.params, result.table, force)))
    if rig.force.low_N < 0:
        return "assumed: the same friction both ways (L+ = L-). A difference that is the same at all forces looks like a bias of u; one that grows with |F| is in the residual of the slides"
    text = ("assumed: the same friction both ways (L+ = L-). Pushing one way only, a log cannot tell unequal friction from a 1 % error of the command scale, "
            f"which would make L+ {(force + L) / 100:.3g} N larger and L- {(force - L) / 100:.3g} N smaller")
    plus, minus = friction.by_direction(result, force)
    other = abs(plus - minus) > friction.APART * L and min(plus, minus) > 0
    return text + (f". If your command is right, L+ is {plus:.3g} N and L- {minus:.3g} N: then write known: {{command: true}} into rig.yaml" if other else "")


def _lags(found):
    return {"actuator": 1 / found.actuator, "arm": found.damping, "sensor": 1 / found.sensor, "delay": found.delay}


def lags_of(found):
    """The lags, each with its interval if the steps separate them."""
    values = _lags(found)
    apart = max(found.halves.values()) < APART * found.whole
    text = ", ".join(f"{name} {1e3 * value:.2f} ms" + (f" +- {1e3 * found.halves[name]:.2g}" if apart and found.halves[name] else "") for name, value in values.items())
    return f"lags: {text}; {1e3 * found.whole:.3g} ms in all" + ("" if apart else ". The sum is certain, the parts are not (set known in rig.yaml)")


def registers(rig, made, per_n):
    """For a drive of this project: the registers besides the loop. A drive accepts tick and sample time only together."""
    keys = {"sample_time_s": made["sample_time_s"], "drive.period_us": round(1e6 * rig.sample_time_s), "drive.command_n_per_unit": abs(1 / per_n), "drive.command_reversed": int(per_n < 0),
            "drive.full_scale_n": made["limits"]["full_scale_N"]}
    if keys["drive.period_us"] < BUDGET_US:
        keys["drive.budget_us"] = keys["drive.period_us"]
    sets = " ".join(f"{key}={value:.7g}" for key, value in keys.items())
    return f"tribo-link params set {sets}\ntribo-link params from loop.yaml\ntribo-link params save\n"
