"""check DIR: the numbers back from the C header, the loop closed again with them, and everything else compared.

Synthesis is not run again: the full controller is taken from the JSON and its loop, like each step's, is
calculated again from its own numbers. What runs, f32 and Q31, is taken from the header and from nowhere else.
"""

import html
import itertools
import json
import re
from pathlib import Path

import control as ct
import numpy as np

from . import emit, pipeline, quantise, sections, synthesis
from .config import load_design, read_text
from .errors import DisagreementError, InputError
from .loop import Continuous, SampledSections, SampledZpk
from .systems import Zpk

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
    report, _ = read_text(directory / "report.md")
    page, _ = read_text(directory / "report.html")
    try:
        header = emit.parse_header(header_text, name)
    except ValueError as error:
        raise DisagreementError(f"{headers[0]}: {error}") from None
    try:
        return _compare(directory, name, design, digest, header, source_text, data, report, page)
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


def _compare(directory, name, design, digest, header, source_text, data, report, page):
    problems = []

    def differ(where, what, found, expected):
        problems.append(f"{where}: {what} is {found}, expected {expected}")

    header_name, json_name = f"{name}_controller.h", f"{name}_design.json"
    if design.name != name:
        differ("DESIGN.yaml", "name", design.name, name)
    recorded = data["input"]["sha256"]
    if data["imported"] is None and digest != recorded:
        differ(json_name, "the input's SHA-256", recorded, f"{digest} (of DESIGN.yaml)")
    for where, text in (("report.md", report), ("report.html", page), (f"{name}_controller.c", source_text)):
        if recorded not in re.sub(r"\s", "", text):
            problems.append(f"{where}: does not name the input's SHA-256 {recorded}")
    for what, found, expected in (("the input's SHA-256", header["sha256"], recorded), ("sample time", header["sample_time_s"], float(f"{np.float32(design.sample_time_s):.9g}")),
                                  ("output limit", header["u_max_n"], design.fixed_point.limit_n), ("full scale", header["full_scale_n"], float(f"{np.float32(design.fixed_point.full_scale_n):.9g}"))):
        same = found == expected if isinstance(found, str) else np.float32(found) == np.float32(expected)
        if not same:
            differ(header_name, what, found, expected)
    macro = f"TRIBO_{name.upper()}_CONTROLLER"
    for line in (f"tribo_{name}_controller_f32[{macro}_SECTION_COUNT] = {macro}_F32;", f"tribo_{name}_controller_q31 = {macro}_Q31;"):
        if line not in source_text:
            problems.append(f"{name}_controller.c: has not the line ...{line}")

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
    scenario = emit.scenario(design, data["input"]["file"], f32)
    if scenario is not None:
        written, _ = read_text(directory / f"{name}_scenario.yaml")
        for found, expected in itertools.zip_longest(written.splitlines(), scenario.splitlines(), fillvalue="nothing"):
            if found != expected:
                differ(f"{name}_scenario.yaml", "a line", found, expected)
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
    result = pipeline.Result(design, digest, data["input"]["file"])
    plant, space = synthesis.make_plant(design.plant)
    weights = {} if design.weights is None else synthesis.make_problem(design).weights
    checker = pipeline.Checker(design, plant, space, weights)
    h = design.sample_time_s
    controllers = {}
    if data["full"] is not None:
        full = data["full"]
        given = ct.ss(*(np.array(full[k], float) for k in "abcd"), remove_useless_states=False) if data["imported"] is None else None
        controllers["full"] = Continuous(_zpk(full) if "poles" in full else None, given)
        if given is not None and "poles" in full:
            omega = np.logspace(-4, 6, 60)
            if not np.allclose(controllers["full"].zpk(1j * omega), controllers["full"].response(omega), rtol=1e-4):
                problems.append(f"{json_name}: full: the zeros, poles and gain are not those of a, b, c, d")
        controllers["reduced"] = Continuous(_zpk(data["reduced"]))
    controllers["discrete"] = SampledZpk(_zpk(data["discrete"]), h)
    controllers["f32"] = SampledSections(f32, h)
    controllers["q31"] = SampledSections(values, h)
    if set(data["metrics"]) != set(controllers):
        differ(json_name, "the steps", sorted(data["metrics"]), sorted(controllers))
        return [], problems
    limits = design.limits
    before = None
    for step, controller in controllers.items():
        loop, metrics = checker.close(controller)
        result.stages.append(pipeline.Stage(step, loop, metrics, ""))
        for key, value in metrics.as_dict().items():
            old = data["metrics"][step][key]
            if not _same(value, old):
                differ(json_name, f"{pipeline.TITLES[step]}, {key}", old, f"{value}, calculated from the numbers")
        allowed = getattr(limits, step, None)
        broken = pipeline.breaches(before, metrics, allowed, limits.floor if step != "full" else None) if allowed is not None or not metrics.stable else []
        problems += [f"{pipeline.TITLES[step]}: {b}" for b in broken]
        before = metrics
    broken = pipeline.breaches(result.stages[0].metrics, before, limits.total, None)
    problems += [f"total: {b}" for b in broken]
    gamma = result.gamma
    if header["gamma"] is not None and gamma is not None and abs(header["gamma"] - gamma) > 1e-3 * gamma:
        differ(header_name, "gamma", header["gamma"], f"{gamma:.4f}")
    table_head, figures, worse = pipeline.table_rows(result)
    for where, found in (("report.md", _markdown_rows(report)), ("report.html", _html_rows(page))):
        for row in [*figures, *worse]:
            match = found.get(row[0], [])
            for title, new in zip(table_head[1:], row[1:]):
                i = table_head.index(title) - 1
                if not any(len(m) > i and _same_cell(m[i], new) for m in match):
                    differ(where, f"{row[0]}, {title}", " or ".join(m[i] for m in match if len(m) > i) or "missing", new)
    return [pipeline.table_text(result)], problems


def _zpk(data):
    return Zpk([complex(*z) for z in data["zeros"]], [complex(*p) for p in data["poles"]], float(data["gain"]))


def _same(new, old):
    if isinstance(new, float) and isinstance(old, (int, float)) and not isinstance(old, bool):
        return abs(new - old) <= TOLERANCE * max(abs(new), 1e-12)
    return new == old and type(new) is type(old)


def _same_cell(found, new):
    """Equal, or different only in the last printed digit or in a degradation next to nothing."""
    if found == new:
        return True
    split = re.compile(r"[-+]?[0-9.]+(?:e[-+]?[0-9]+)?|inf")
    a, b = split.findall(found), split.findall(new)
    if len(a) != len(b) or split.sub("#", found) != split.sub("#", new):
        return False
    return all(abs(float(x) - float(y)) <= max(2e-3 * abs(float(y)), 2e-3 if "/" in new or "%" in new else 0) for x, y in zip(a, b))


def _markdown_rows(text):
    rows = {}
    for line in text.splitlines():
        if line.startswith("| "):
            first, *rest = [c.strip() for c in line.strip("| ").split(" | ")]
            rows.setdefault(first, []).append(rest)
    return rows


def _html_rows(text):
    rows = {}
    for row in re.findall(r"<tr>(.*?)</tr>", text):
        first, *rest = [html.unescape(c) for c in re.findall(r"<t[dh]>(.*?)</t[dh]>", row)] or [""]
        rows.setdefault(first, []).append(rest)
    return rows


