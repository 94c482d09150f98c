"""Markdown and self-contained HTML reports: the same words, table and plots."""

import base64
import html as escaping

from . import emit, friction, pipeline, robustness


def _sections_rows(result):
    rows = [["section", "b0", "b1", "b2", "a1", "a2", "largest output in e's and u's whole range, full scales", "held in Q31 times"]]
    for i, row in enumerate(result.cascade.sections):
        rows.append([str(i + 1), *(f"{c:.9g}" for c in row), f"{result.quantised.peaks[i]:.4g}", f"2^-{result.q31.sections[i]['scale']}"])
    return rows


def _content(result, images):
    """(kind, content) pairs: h1, h2, p, pre, list, table, image."""
    from .plots import CAPTIONS

    design = result.design
    final = result.stages[-1].metrics
    header, figures, worse = pipeline.table_rows(result)
    yield "h1", f"Controller \"{design.name}\""
    if design.description:
        yield "p", design.description
    yield "p", (f"Every step's loop is within its limits. After Q31, with hold, computation delay and dead time of {design.delay_s:g} s in all: "
                + (f"gamma {final.gamma:.4f}, " if final.gamma is not None else "") + f"gain margin {final.gain_margin:.4g}, phase margin {final.phase_margin_deg:.4g} deg, "
                f"delay margin {final.delay_margin_s:.4g} s.")
    yield "h2", "Where it comes from"
    yield "pre", "\n".join(emit.provenance(result))
    yield "h2", "The loop after each step"
    if result.peaks:
        yield "p", result.peaks
    yield "table", [header, *figures]
    yield "p", ("Margins are factors and degrees; the bandwidth is where |T| first falls below 0.707; the ramp error is the error at the end of a ramp of "
                f"{design.ramp.rate_n_per_s:g} N/s and {design.ramp.duration_s:g} s, its transients over; the slowest pole is K's.")
    yield "h2", "Worse than before (+), against the limit"
    yield "table", [header, *worse]
    yield "h2", "What each step did"
    yield "list", [f"{pipeline.TITLES[s.step]}: {s.note}" for s in result.stages] + list(result.warnings)
    for name in ("sensitivity", "nyquist", "controller", "step", "ramp"):
        if name in images:
            yield "image", (name, CAPTIONS[name])
    if robustness.in_words(result.robustness):
        yield "h2", "What it stands"
        yield "list", robustness.in_words(result.robustness)
    yield "h2", "With friction in the loop"
    yield "p", friction.in_words(result.friction) + "." if result.friction else "Not simulated."
    if "friction" in images:
        yield "image", ("friction", CAPTIONS["friction"])
    yield "h2", "Sections"
    yield "p", "b0 d^2 + b1 d + b2 over d^2 + a1 d + a2, d = z - 1; before rounding. The first is nearest to the input."
    yield "table", _sections_rows(result)
    yield "p", (f"Rounding every section's output to Q31 makes {result.noise_lsb:.3g} LSB rms at the output of the cascade in open loop ({result.noise_lsb * design.fixed_point.full_scale_n / 2**31:.3g} N), "
                f"the least of the {result.cascade.tried} groupings and orders tried. Anti-windup: the library will condition with c = {result.quantised.conditioning:.4g}.")
    if "sections" in images:
        yield "image", ("sections", CAPTIONS["sections"])


def markdown(result, images):
    out = []
    for kind, content in _content(result, images):
        if kind in ("h1", "h2"):
            out += [("# " if kind == "h1" else "## ") + content, ""]
        elif kind == "p":
            out += [content, ""]
        elif kind == "pre":
            out += ["```", content, "```", ""]
        elif kind == "list":
            out += [f"* {item}" for item in content] + [""]
        elif kind == "table":
            head, *rows = content
            out += ["| " + " | ".join(head) + " |", "|" + "---|" * len(head), *("| " + " | ".join(r) + " |" for r in rows), ""]
        elif kind == "image":
            out += [f"![{content[0]}](plots/{content[0]}.png)", "", content[1], ""]
    return "\n".join(out)


STYLE = """body { font: 15px/1.5 system-ui, sans-serif; max-width: 1200px; margin: 2em auto; padding: 0 1em; color: #222 }
table { border-collapse: collapse; font-size: 13px; margin: 1em 0 } td, th { border: 1px solid #ccc; padding: 3px 8px; text-align: right }
td:first-child, th:first-child { text-align: left } th { background: #f2f2f2 } img { max-width: 100% } figure { margin: 1.5em 0 }
figcaption { color: #555; font-size: 13px } pre { background: #f6f6f6; padding: 1em; overflow-x: auto; font-size: 13px } .wide { overflow-x: auto }"""


def html(result, images):
    e = escaping.escape
    out = ["<!DOCTYPE html>", '<html lang="en"><head><meta charset="utf-8">', f"<title>Controller {e(result.design.name)}</title>", f"<style>{STYLE}</style></head><body>"]
    for kind, content in _content(result, images):
        if kind in ("h1", "h2", "p"):
            out.append(f"<{kind}>{e(content)}</{kind}>")
        elif kind == "pre":
            out.append(f"<pre>{e(content)}</pre>")
        elif kind == "list":
            out.append("<ul>" + "".join(f"<li>{e(i)}</li>" for i in content) + "</ul>")
        elif kind == "table":
            head, *rows = content
            out.append('<div class="wide"><table><tr>' + "".join(f"<th>{e(c)}</th>" for c in head) + "</tr>")
            out += ["<tr>" + "".join(f"<td>{e(c)}</td>" for c in row) + "</tr>" for row in rows]
            out.append("</table></div>")
        elif kind == "image":
            data = base64.b64encode(images[content[0]]).decode()
            out.append(f'<figure><img alt="{e(content[0])}" src="data:image/png;base64,{data}"><figcaption>{e(content[1])}</figcaption></figure>')
    out.append("</body></html>")
    return "\n".join(out) + "\n"
