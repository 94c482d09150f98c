"""tribo-identify friction: reads the logs, fits the parameters, prints and writes the results."""

from pathlib import Path

import numpy as np

from tribo_design.errors import InputError
from tribo_design.output import check_replaceable, write_directory, yaml_text
from tribo_design.reading import printable, read_scenario
from tribo_plot import output

from . import friction, logs, native, report, strokes

NAMES = ("friction.yaml", "report.html", "loop*.yaml", "loop*_params.h")


def rig_of(options):
    rig = {}
    for name in ("actuator", "sensor"):
        value = getattr(options, name)
        if value is not None:
            if not (value == 0 or 1e-3 <= value <= 1e9):
                raise InputError(f"--{name}: value {value:g}: must be 0 or 0.001 to 1e9 rad/s")
            rig[name] = value
    if options.lag is not None:
        if not 1e-5 <= options.lag <= 10:
            raise InputError(f"--lag: value {options.lag:g}: must be 1e-5 to 10 s")
        rig["damping"] = options.lag * native.PAPER["stiffness"]
    return rig


def _check_options(options):
    """Refuses options that others make useless, and a place that takes no file, before the logs are read."""
    if options.arith and not options.scenario:
        raise InputError("--arith: is of loop_params.h, which needs --scenario")
    if options.scenario and not options.out:
        raise InputError("--scenario: is for loop.yaml and loop_params.h, which need --out")
    if options.out:
        check_replaceable(options.out, NAMES)
    if options.scenario:
        output.check_place(_trial(options))


def _trial(options):
    """The file that tribo-sim checks: in the folder of the scenario, because the scenario may name files."""
    base = Path(options.scenario).resolve()
    return base.with_name(f".{base.stem}.identified.yaml")


def run(options):
    _check_options(options)
    base = read_scenario(options.scenario, "rt") if options.scenario else None
    log = logs.read(options.logs, logs.arguments_of(options))
    if all(s.force is None for s in log.segments):
        return _strokes(log, options)
    result = friction.identify(log, rig_of(options), options.assume)
    lines = [*friction.line_of(result), *_summary(result)]
    print("\n".join(lines))
    if options.out:
        files = {"friction.yaml": friction_yaml(result, options).encode(), "report.html": report.html(log, result, lines).encode()}
        files |= _loop(base, result, options)
        write_directory(options.out, files, NAMES)
        print(f"wrote {options.out}: {', '.join(sorted(files))}")
    return 0


def _summary(result):
    lines = [] if result.line_error is None else [f"breakaway and command come from the slides, which a line fits within {result.line_error:.2g} N: inside stiction the friction does not follow the model"]
    lines += [f"{len(result.events)} break-aways at F from {result.loads[0][0]:.3g} to {result.loads[-1][1]:.3g} N; L in the middle of this range is known within {100 * result.L_half:.2g} % (95 %)",
             f"the model follows F within {result.residual_rms:.2g} N rms; the error in held-out half-cycles is {result.held_out:.2f} times that; delay {result.delay_s:.2g} s, ripple {result.ripple:.2g} N"]
    scale = next((e.value for e in result.estimates if e.name == "scale"), 1.0)
    if abs(scale - 1) > 0.02 and result.assume:
        lines.append(f"u: your command makes {scale:.4g} N for 1 N; divide it by {scale:.4g}, otherwise the parameters do not hold")
    return lines + [f"note: {r}" for r in result.remarks]


def mapping_of(result):
    """Returns the keys of a scenario's compensator.friction."""
    p = result.params
    number = lambda x: float(f"{x:.6g}")
    if result.table:
        breakaway = {"table": [{"force_N": number(f), "positive_N": number(a), "negative_N": number(b)} for f, a, b in result.table]}
    else:
        breakaway = {"offset_N": number(p["offset_positive"]), "slope": number(p["slope_positive"])}
        if result.assume == "calibrated":
            breakaway |= {"negative_offset_N": number(p["offset_negative"]), "negative_slope": number(p["slope_negative"])}
    keys = {"breakaway": breakaway, "k_min": number(p["k_min"]), "k_max": number(p["k_max"]), "m": number(p["m"]), "v0_N_per_s": number(p["v0"])}
    if abs(p["gravity"]) > 1e-9:
        keys["gravity_N"] = number(p["gravity"])
    return keys


def _plant(base, result, options):
    """Returns the base's actuator and arm with the friction of the log in place of the base's friction."""
    plant = {key: base[key] for key in ("step_s", "actuator_pole_rad_per_s", "arm") if key in base}
    plant["friction"] = mapping_of(result)
    if options.actuator:
        plant["actuator_pole_rad_per_s"] = options.actuator
    return plant


def friction_yaml(result, options):
    head = [f"# Friction that tribo-identify found in {', '.join(printable(Path(p).name) for p in options.logs)}; for tribo-sim replay --params."]
    head += [f"# {line}" for line in [*friction.line_of(result), *_summary(result)]]
    return "\n".join(head) + "\n" + yaml_text({"friction": mapping_of(result)})


def _loop(tree, result, options):
    """Returns the files of the rig's loop with this friction, checked by the library, and its parameters for the drive."""
    if tree is None:
        return {}
    tree.setdefault("compensator", {})["friction"] = mapping_of(result)
    tree["plant"] = _plant(tree.get("plant") or {}, result, options)
    if options.sensor:
        tree["sensor"] = (tree.get("sensor") or {}) | {"pole_rad_per_s": options.sensor}
    text = yaml_text(tree)
    trial = _trial(options)
    try:
        trial.write_text(text, encoding="utf-8")
        header, _ = native.run_tribo_sim("params", trial, "--arith", options.arith or "f32", "--name", "loop")
    finally:
        trial.unlink(missing_ok=True)
    return {"loop.yaml": text.encode(), "loop_params.h": header.replace(trial.name, "loop.yaml").encode()}


def _standard_error(repeats):
    return f"standard error {np.std(repeats, ddof=1) / len(repeats) ** 0.5:.2g} N" if len(repeats) > 1 else "no standard error: one pair has no scatter"


def _strokes(log, options):
    if any(s.position is None and s.speed is None for s in log.segments):
        raise InputError(f"{options.logs[0]}: has no force: name its column (--column F=...); for strokes at speed, name that of the position or the speed (--column x=... or --column v=...)")
    for name in ("assume", "actuator", "sensor", "lag", "scenario"):
        if getattr(options, name) is not None:
            raise InputError(f"--{name}: {options.logs[0]} has no force, and friction of strokes has no use for it")
    law = strokes.identify(log)
    lines = [f"{v.file}{v.when}: load {v.load:.5g} N, friction {v.friction:.4g} N, {len(v.repeats)} pair{'s' * (len(v.repeats) > 1)} of strokes, {_standard_error(v.repeats)}" for v in law.levels]
    if law.is_table:
        lines.append(f"a line does not fit: it is off by up to {100 * law.deviation:.2g} % at a load, far beyond the scatter of the repeats; the result is a table of {len(law.levels)} loads")
    else:
        lines.append(f"offset {law.offset:.4g} +- {law.offset_half:.2g} N, slope {law.slope:.3g} +- {law.slope_half:.2g} (95 %), R2 {law.r2:.4f}")
        if not law.slope_shown:
            lines.append("slope: weak: these loads do not show a slope; more loads would")
    lines.append("note: this is the friction of sliding at these speeds; breakaway, k_min, k_max, m and v0 need a log of u and F (tribo-identify plan)")
    lines += [f"note: {r}" for r in log.remarks]
    print("\n".join(lines))
    if options.out:
        number = lambda x: float(f"{x:.6g}")
        breakaway = {"table": [{"force_N": number(abs(v.load)), "positive_N": number(v.friction), "negative_N": number(v.friction)} for v in law.levels]}
        if not law.is_table and law.slope > 0 and law.offset > 0:
            breakaway = {"offset_N": number(law.offset), "slope": number(law.slope)}
        text = "\n".join(f"# {line}" for line in lines) + "\n" + yaml_text({"friction": {"breakaway": breakaway}})
        write_directory(options.out, {"friction.yaml": text.encode(), "report.html": report.strokes_html(log, law, lines).encode()}, NAMES)
        print(f"wrote {options.out}: friction.yaml, report.html")
    return 0
