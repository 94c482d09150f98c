"""check DIR: the numbers back from the C header, the loop closed again with them, and everything else compared.

Synthesis is not run again: the full controller is taken from the JSON and its loop, like each step's, is
calculated again from its own numbers. What runs, f32 and Q31, is taken from the header and from nowhere else. Then every text is
rendered again from what was verified, and must be the file's.
"""

import itertools
import json
from pathlib import Path

import numpy as np

from . import commands, emit, pipeline, quantise, reduction, robustness, sections, synthesis
from .config import load_design
from .reading import read_text
from .errors import DisagreementError, InputError
from .loop import Continuous, Metrics, SampledSections, SampledZpk
from .zpk import Zpk

TOLERANCE = 1e-6  # of a figure calculated again, against the JSON's


def command(options):
    lines, problems = check(options.dir)
    print("\n".join(lines))
    if problems:
        raise DisagreementError("\n".join(problems))
    print(f"{options.dir}: header, source, scenario, JSON and reports agree, and the loop is within its limits")
    return 0


def check(directory):
    """(what to print, the disagreements)."""
    directory = Path(directory)
    if not directory.is_dir():
        raise InputError(f"{directory}: is not a directory")
    headers = sorted(directory.glob("*_controller.h"))
    if len(headers) != 1:
        raise InputError(f"{directory}: needs exactly one *_controller.h, found {len(headers)}")
    name = headers[0].name.removesuffix("_controller.h")
    design, digest = load_design(directory / "DESIGN.yaml")
    header_text, _ = read_text(headers[0])
    source_text, _ = read_text(directory / f"{name}_controller.c")
    data = _load_json(directory / f"{name}_design.json")
    for file in ("report.md", "report.html"):
        read_text(directory / file)
    try:
        header = emit.parse_header(header_text, name)
    except ValueError as error:
        raise DisagreementError(f"{headers[0]}: {error}") from None
    try:
        return _compare(directory, name, design, digest, header, source_text, data)
    except (KeyError, TypeError, IndexError, ValueError) as error:
        raise DisagreementError(f"{directory / (name + '_design.json')}: not as it was written: {type(error).__name__} {error}") from None


def _load_json(path):
    text, _ = read_text(path)
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise DisagreementError(f"{path}: not JSON: {error}") from None
    if not isinstance(data, dict):
        raise DisagreementError(f"{path}: not as it was written: no object")
    return data


def _compare(directory, name, design, digest, header, source_text, data):
    problems = []

    def differ(where, what, found, expected):
        problems.append(f"{where}: {what} is {found}, expected {expected}")

    header_name, json_name = f"{name}_controller.h", f"{name}_design.json"
    if design.name != name:
        differ("DESIGN.yaml", "name", design.name, name)
    recorded = data["input"]["sha256"]
    if data["imported"] is None and digest != recorded:
        differ(json_name, "the input's SHA-256", recorded, f"{digest} (of DESIGN.yaml)")
    for what, found, expected in (("sample time", header["sample_time_s"], design.sample_time_s), ("output limit", header["u_max_n"], design.fixed_point.limit_n),
                                  ("full scale", header["full_scale_n"], design.fixed_point.full_scale_n)):
        if np.float32(found) != np.float32(expected):
            differ(header_name, what, found, expected)

    # The coefficients: header against JSON, and both against the design's unrounded sections.
    stored = data["sections"]
    wanted = np.array(stored["design"], float)
    f32 = np.array(header["f32"]).astype(np.float32).astype(float)
    coded = header["q31"]
    if wanted.shape != f32.shape:
        raise ValueError(f"{len(wanted)} sections, the header has {len(f32)}")
    coefficient = ("b0", "b1", "b2", "a1", "a2")
    for i in range(len(f32)):
        for j, c in enumerate(coefficient):
            place = f"section {i + 1} {c}"
            if f32[i, j] != float(stored["f32"][i][j]):
                differ(header_name, f"f32 {place}", f"{f32[i, j]:.9g}", f"{stored['f32'][i][j]:.9g} ({json_name})")
            elif f32[i, j] != float(np.float32(wanted[i, j])):
                differ(json_name, f"f32 {place}", f"{f32[i, j]:.9g}", f"{np.float32(wanted[i, j]):.9g}, the design rounded")
    kept = stored["q31"]
    for key, value in coded.as_dict().items():
        for where, found, wanted_value in ([(f"section {i + 1} {k}", v, kept["sections"][i][k]) for i, section in enumerate(value) for k, v in section.items()]
                                           if key == "sections" else [(key, value, kept[key])]):
            if found != wanted_value:
                differ(header_name, f"Q31 {where}", found, f"{wanted_value} ({json_name})")
    values = coded.values()
    again = quantise.to_q31(f32, design.fixed_point.full_scale_n, -design.fixed_point.limit_n, design.fixed_point.limit_n)
    stated = [("sample_time_s", design.sample_time_s), ("computation_delay_s", design.computation_delay_s), ("full_scale_n", design.fixed_point.full_scale_n)]
    if again.q31 == coded:
        stated += [("q31_peaks", again.peaks), ("anti_windup", again.conditioning)]
    for key, expected in stated:
        if data[key] != expected:
            differ(json_name, key, data[key], expected)
    if stored["q31_values"] != values.tolist():
        differ(json_name, "q31_values", stored["q31_values"], values.tolist())
    if not problems and again.q31 != coded:
        problems.append(f"{header_name}: the Q31 params are not what the library makes of the f32 sections (or the library has changed: synthesize again)")
    for title, numbers in (("f32", f32), ("Q31", values)):
        try:
            sections.check_sections(numbers)
        except Exception as error:  # noqa: BLE001
            problems.append(f"{header_name}: {title}: {error}")
    if problems:
        return [], problems

    # The loop, closed again.
    h, in_w = design.sample_time_s, data["domain"] == "w"
    result = pipeline.Result(design, recorded, data["input"]["file"], data["versions"], in_w=in_w, structure_note=data["structure_note"], imported=data["imported"] or "", f32=f32, q31=coded,
                             quantised=again, noise_lsb=data["q31_noise_lsb_rms"], cascade=sections.Cascade(wanted, [], data["cascades_tried"]), warnings=data["remarks"],
                             robustness=data["robustness"], friction=data["friction"])
    plant, space = synthesis.make_plant(design.plant)
    weights = {} if design.weights is None else synthesis.make_problem(design).weights
    checker = pipeline.Checker(design, plant, space, weights)
    result.plant, result.sampled = plant, _zpk(data["discrete"])
    controllers = {}
    for step in ("full", "reduced"):
        if data[step] is not None:
            controllers[step] = pipeline.as_sampled(_zpk(data[step]), h) if in_w else Continuous(_zpk(data[step]))
    if data["full"] is not None:
        result.full, result.full_order, result.gamma_stated = _zpk(data["full"]), data["full"]["order"], data["full"]["gamma_stated"]
        result.reduced = reduction.Candidate(_zpk(data["reduced"]), data["reduced"]["how"])
    if not in_w:
        controllers["discrete"] = SampledZpk(result.sampled, h)
    controllers["f32"] = SampledSections(f32, h)
    controllers["q31"] = SampledSections(values, h)
    if list(data["metrics"]) != list(controllers):
        differ(json_name, "the steps", list(data["metrics"]), list(controllers))
        return [], problems
    before = None
    for step, controller in controllers.items():
        loop, metrics = checker.close(controller)
        stored = Metrics.from_dict(data["metrics"][step])
        result.stages.append(pipeline.Stage(step, loop, stored, data["notes"][step]))
        for key, value in metrics.as_dict().items():
            old = data["metrics"][step][key]
            if not _same(value, old):
                differ(json_name, f"{pipeline.TITLES[step]}, {key}", old, f"{value}, calculated from the numbers")
        allowed = getattr(design.limits, step, None)
        broken = pipeline.breaches(before, metrics, allowed, design.limits.floor if step != "full" else None) if allowed is not None or not metrics.stable else []
        problems += [f"{pipeline.TITLES[step]}: {b}" for b in broken]
        before = metrics
    broken = pipeline.breaches(checker.close(controllers[next(iter(controllers))])[1], before, design.limits.total, None)
    problems += [f"total: {b}" for b in broken]
    if not problems and not _same_data(robustness.study(result, checker), data["robustness"]):
        problems.append(f"{json_name}: robustness is not what the plant's ranges give with this controller")
    if not problems:
        problems += _compare_texts(directory, name, result)
    return [pipeline.table_text(result)], problems


def _compare_texts(directory, name, result):
    """Every text file against its own rendering from the verified numbers."""
    problems = []
    images = {p.stem: p.read_bytes() for p in sorted((directory / "plots").glob("*.png"))} if (directory / "plots").is_dir() else {}
    for file, expected in commands.texts_of(result, images).items():
        written, _ = read_text(directory / file)
        for number, (found, right) in enumerate(itertools.zip_longest(written.split("\n"), expected.split("\n"), fillvalue="nothing"), 1):
            if found != right:
                problems.append(f"{file}:{number}: a line is {_short(found)}, expected {_short(right)}")
                break
    return problems


def _short(line):
    return line if len(line) <= 300 else line[:297] + "..."


def _same_data(new, old):
    if isinstance(new, dict):
        return isinstance(old, dict) and new.keys() == old.keys() and all(_same_data(v, old[k]) for k, v in new.items())
    if isinstance(new, (list, tuple)):
        return isinstance(old, list) and len(new) == len(old) and all(map(_same_data, new, old))
    return _same(new, old)


def _zpk(data):
    return Zpk([complex(*z) for z in data["zeros"]], [complex(*p) for p in data["poles"]], float(data["gain"]))


def _same(new, old):
    if isinstance(new, float) and isinstance(old, (int, float)) and not isinstance(old, bool):
        return abs(new - old) <= TOLERANCE * max(abs(new), 1e-12)
    return new == old and type(new) is type(old)
