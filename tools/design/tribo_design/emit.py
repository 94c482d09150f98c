"""Writes the C header and source, and the JSON. They contain constants only; the same input gives the same bytes."""

import json
import re

import numpy as np

from .reading import format_root
from .quantise import FIELDS, Q31

WIDTH = 118


def _roots(roots):
    parts, i = [], 0
    while i < len(roots):
        r = roots[i]
        if r.imag:
            parts.append(f"{r.real:.6g} +- {abs(r.imag):.6g}j")
            i += 2
        else:
            parts.append(f"{r.real:.6g}")
            i += 1
    return ", ".join(parts) if parts else "none"


def _system(system):
    if system.form == "tf":
        return f"[{' '.join(f'{c:.9g}' for c in system.num)}] / [{' '.join(f'{c:.9g}' for c in system.den)}]"
    if system.form == "ss":
        return f"state space of order {len(system.a)}"
    if not system.poles and not system.zeros:
        return f"{system.gain if system.gain is not None else system.k:.9g}"
    gain = f"gain {system.gain:.9g}" if system.gain is not None else f"k {system.k:.9g}"
    return f"{gain}, zeros {_group(system.zeros)}, poles {_group(system.poles)}"


def _group(roots):
    return ", ".join(format_root(r) for r in roots) if roots else "none"


def provenance(result):
    design = result.design
    lines = [f"input     {result.source}, SHA-256 {result.digest}",
             f"tool      {result.versions}",
             f"plant     {_system(design.plant)}"]
    if design.weights is not None:
        parts = [f"{n} = {_system(getattr(design.weights, n))}" for n in design.weights.named()]
        lines.append("weights   " + "; ".join(parts))
    if not result.imported:
        full = result.stage("full")
        lines.append(f"gamma     {full.metrics.gamma:.4f}, " + (f"K(s) of order {result.full_order} by mixsyn" if not result.in_w
                     else f"K of order {result.full_order} by mixsyn on the sampled plant" if design.synthesis.structure == "full" else result.structure_note))
    else:
        gamma = result.gamma
        lines.append(f"K         imported: {result.imported}" + ("" if gamma is None else f"; gamma {gamma:.4f}"))
    if result.reduced is not None:
        zpk = result.reduced.zpk
        at_rest = zpk.at_zero()
        lines.append(f"reduced   {result.reduced.how}: order {zpk.order}, " + (f"K(0) = {at_rest:.7g}" if np.isfinite(at_rest) else f"k = {zpk.gain:.7g}"))
        lines.append(f"          poles {_roots(zpk.poles)}; zeros {_roots(zpk.zeros)} rad/s" + (" in w = (2/h) (z - 1)/(z + 1)" if result.in_w else ""))
        lines.append(f"K(z)      z = (1 + w h/2)/(1 - w h/2), sample time {design.sample_time_s:g} s" if result.in_w else f"K(z)      {design.discretisation.method}" + (f" at {design.discretisation.prewarp_rad_s:g} rad/s" if design.discretisation.prewarp_rad_s else "")
                     + f", sample time {design.sample_time_s:g} s")
    else:
        lines.append(f"K(z)      sample time {design.sample_time_s:g} s")
    final = result.stages[-1].metrics
    lines.append(f"loop      with hold and {design.delay_s:g} s delay, Q31: " + (f"gamma {final.gamma:.4f}, " if final.gamma is not None else "")
                 + f"gain margin {final.gain_margin:.2f}, phase margin {final.phase_margin_deg:.2f} deg")
    return lines


def _wrapped(lines):
    out = []
    for line in lines:
        indent = " " * 10
        while len(line) > WIDTH - 8:
            cut = line.rfind(" ", 20, WIDTH - 8)
            if cut < 0:
                break
            out.append(line[:cut])
            line = indent + line[cut + 1 :]
        out.append(line)
    return out


def header(result):
    name = result.design.name
    upper = name.upper()
    macro = f"TRIBO_{upper}_CONTROLLER"
    lines = [f"/// Coefficients of the controller \"{name}\", made by tribo-design: change its input, not this file.", "///"]
    lines += [f"///     {line}" for line in _wrapped(provenance(result))]
    lines += ["///",
              "/// F32: sections as b0, b1, b2, a1, a2 of tribo/controller_f32.h, the first nearest to the input, the slowest pole in the last.",
              "/// Q31: params of tribo/controller_q31.h, as tribo_controller_q31_init makes them of these sections and limits.",
              f"/// Constants only, no code; {name}_controller.c holds both, declared here for whoever has included their types before.",
              "", f"#ifndef {macro}_H", f"#define {macro}_H", "", "// clang-format off",
              f"#define {macro}_SAMPLE_TIME_S {_float_literal(result.design.sample_time_s)}",
              f"#define {macro}_SECTION_COUNT {len(result.f32)}u",
              f"#define {macro}_FULL_SCALE_N {_float_literal(result.design.fixed_point.full_scale_n)} ///< 2^31 in Q31",
              f"#define {macro}_U_MAX_N {_float_literal(result.design.fixed_point.limit_n)} ///< in Q31, of either sign", ""]
    rows = ["{" + ", ".join(_float_literal(c, 8) for c in row) + "}, \\" for row in result.f32]
    lines += _initialiser(f"{macro}_F32", rows)
    lines.append("")
    lines += _q31_initialiser(f"{macro}_Q31", result.q31)
    lines += ["// clang-format on", "", "#ifdef TRIBO_CONTROLLER_F32_H",
              f"extern const tribo_biquad_f32_section_t tribo_{name}_controller_f32[{macro}_SECTION_COUNT];", "#endif",
              "#ifdef TRIBO_CONTROLLER_Q31_H",
              f"extern const tribo_controller_q31_params_t tribo_{name}_controller_q31;", "#endif",
              "", "#endif", ""]
    return "\n".join(lines)


def _initialiser(name, rows):
    return _macro(name, ["{", *("    " + r[:-2] for r in rows), "}"])


def _q31_initialiser(name, q31):
    rows = []
    for s in q31.sections:
        parts = [f".{k} = {s[k]}" for k in FIELDS]
        rows += ["        {" + ", ".join(parts[:5]) + ",", "         " + ", ".join(parts[5:]) + "},"]
    return _macro(name, ["{", "    .cascade = {.section = {", *rows, f"    }}, .count = {len(q31.sections)}, .input_scale = {q31.input_scale}, .output_scale = {q31.output_scale}}},",
                         f"    .anti_windup = {q31.anti_windup}, .taken_max = {q31.taken_max},", f"    .u_min = {q31.u_min}, .u_max = {q31.u_max},",
                         f"    .anti_windup_shift = {q31.anti_windup_shift},", "}"])  # in the struct's order, which C++ requires


def _macro(name, rows):
    lines = [f"#define {name}", *("    " + r for r in rows)]
    width = max(len(line) for line in lines) + 1
    return [line.ljust(width) + "\\" for line in lines[:-1]] + [lines[-1]]


def source(result):
    name = result.design.name
    macro = f"TRIBO_{name.upper()}_CONTROLLER"
    return "\n".join([
        f"// Made by tribo-design; see {name}_controller.h. Input: {result.source}, SHA-256",
        f"// {result.digest}.",
        "", '#include "tribo/controller_f32.h"', '#include "tribo/controller_q31.h"', "", f'#include "{result.design.include_folder}{name}_controller.h"', "", "// clang-format off",
        f"const tribo_biquad_f32_section_t tribo_{name}_controller_f32[{macro}_SECTION_COUNT] = {macro}_F32;",
        f"const tribo_controller_q31_params_t tribo_{name}_controller_q31 = {macro}_Q31;", "// clang-format on", ""])


def _float_literal(value, digits=None):
    if digits is not None:
        return f"{value:.{digits}e}f"
    text = repr(float(np.float32(value))) if float(np.float32(value)) == value else f"{value:.9g}"
    if "e" in text:
        mantissa, exponent = text.split("e")
        return f"{mantissa if '.' in mantissa else mantissa + '.0'}e{int(exponent)}f"
    return (text if "." in text else text + ".0") + "f"


def as_json(result):
    """Everything, with full precision."""
    design = result.design
    data = {
        "tool": "tribo-design", "versions": result.versions, "domain": "w" if result.in_w else "s", "structure_note": result.structure_note,
        "name": design.name, "input": {"file": result.source, "sha256": result.digest},
        "sample_time_s": design.sample_time_s, "computation_delay_s": design.computation_delay_s,
        "full_scale_n": design.fixed_point.full_scale_n,
        "imported": result.imported or None,
        "full": None, "reduced": None,
        "discrete": {"operator": "d = z - 1", **_zpk(result.sampled)},
        "sections": {"columns": ["b0", "b1", "b2", "a1", "a2"], "design": result.cascade.sections.tolist(), "f32": result.f32.tolist(),
                     "q31": result.q31.as_dict(), "q31_values": result.q31.values().tolist()},
        "cascades_tried": result.cascade.tried,
        "q31_peaks": result.quantised.peaks,
        "q31_noise_lsb_rms": result.noise_lsb,
        "anti_windup": result.quantised.conditioning,
        "metrics": {s.step: s.metrics.as_dict() for s in result.stages},
        "notes": {s.step: s.note for s in result.stages}, "remarks": result.warnings,
        "robustness": result.robustness, "friction": result.friction,
    }
    if result.full is not None:
        data["full"] = {**_zpk(result.full), "order": result.full_order, "gamma_stated": result.gamma_stated}
    if result.reduced is not None:
        data["reduced"] = {"how": result.reduced.how, **_zpk(result.reduced.zpk)}
    return json.dumps(data, indent=1, allow_nan=False) + "\n"


def _zpk(system):
    return {"zeros": [[r.real, r.imag] for r in system.zeros], "poles": [[r.real, r.imag] for r in system.poles], "gain": system.gain}


# Reads the header back for `check`. This uses none of the functions above, only the format of the text.

def parse_header(text, name):
    """Reads a generated header into a dict; raises ValueError naming what is missing."""
    macro = f"TRIBO_{name.upper()}_CONTROLLER"
    flat = re.sub(r"[ \t]*\\\n", " ", text)

    def constant(suffix):
        found = re.search(rf"#define {macro}_{suffix} ([-+0-9.eE]+)[fu]?\b", flat)
        if not found:
            raise ValueError(f"{macro}_{suffix} is missing")
        return float(found.group(1))

    def rows(suffix):
        found = re.search(rf"#define {macro}_{suffix} +(\{{.*)", flat)
        if not found:
            raise ValueError(f"{macro}_{suffix} is missing")
        return found.group(1)

    number = r"[-+]?[0-9]+\.[0-9]+e[-+][0-9]+"
    f32 = [[float(x) for x in re.findall(rf"({number})f", row)] for row in re.findall(r"\{([^{}]*)\}", rows("F32"))]
    text_q31 = rows("Q31")

    def field(key, where=text_q31):
        found = re.findall(rf"\.{key} = (-?[0-9]+)[,}}]", where)
        if len(found) != 1:
            raise ValueError(f"{macro}_Q31: {key} is missing")
        return int(found[0])

    sections = [{k: field(k, row) for k in FIELDS} for row in re.findall(r"\{(\.b0[^{}]*\})", text_q31)]
    q31 = Q31(sections, *(field(k) for k in ("input_scale", "output_scale", "anti_windup", "anti_windup_shift", "taken_max", "u_min", "u_max")))
    count = int(constant("SECTION_COUNT"))
    if len(f32) != count or any(len(row) != 5 for row in f32):
        raise ValueError(f"{macro}_F32 does not have {count} rows of 5 coefficients")
    if len(sections) != max(count, 2) or field("count") != len(sections):
        raise ValueError(f"{macro}_Q31 does not have {max(count, 2)} sections")
    digest = re.search(r"SHA-256\s+(?:///\s+)?([0-9a-f]{64})", text)
    gamma = re.search(r"gamma +([0-9.]+)", text)
    if not digest:
        raise ValueError("the input's SHA-256 is missing")
    return {"sample_time_s": constant("SAMPLE_TIME_S"), "full_scale_n": constant("FULL_SCALE_N"), "u_max_n": constant("U_MAX_N"), "f32": f32, "q31": q31,
            "sha256": digest.group(1), "gamma": float(gamma.group(1)) if gamma else None}
