"""Panels as one HTML file that zooms and needs no network: uPlot, the data and the page itself, inlined."""

import base64
import gzip
import html
import json
import os
import sys
from array import array
from pathlib import Path

from . import look
from .panels import thin
from .runs import PlotError

UPLOT_VERSION = "1.6.32"  # cmake/uplot.cmake fetches it
COLUMNS = 100_000  # more points than four times as many are thinned
HERE = Path(__file__).resolve().parent


def uplot(name):
    """Reads a file of uPlot, from this package or the user's cache."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tribo"
    for folder in (HERE / "uplot", cache / f"uplot-{UPLOT_VERSION}"):
        path = folder / name
        if path.is_file():
            return path.read_text(encoding="utf-8")
    raise PlotError(f"uPlot {UPLOT_VERSION}, which zooms an HTML page, is missing: `tools/setup plot` in tribo's source fetches it with npm")


def uplot_parts():
    return {"CSS": uplot("dist/uPlot.min.css"), "LICENSE": uplot("LICENSE"), "UPLOT": uplot("dist/uPlot.iife.min.js")}


class Pool:
    """Arrays of little-endian numbers, each kept once."""

    def __init__(self):
        self._bytes = bytearray()
        self._places = {}

    def add(self, values, code):
        """Returns the place of the numbers: code, offset in bytes, count."""
        numbers = array(code, values)
        if sys.byteorder == "big":
            numbers.byteswap()
        content = numbers.tobytes()
        if (code, content) not in self._places:
            self._bytes += bytes(-len(self._bytes) % 8)
            self._places[code, content] = len(self._bytes)
            self._bytes += content
        return [code, self._places[code, content], len(numbers)]

    def text(self):
        return base64.b64encode(gzip.compress(bytes(self._bytes), mtime=0)).decode()


def _line(line, panel, names, pool):
    x, y = thin(line, COLUMNS, panel.over_time)
    width, dashes, order = look.RUNS[line.run % len(look.RUNS)][2:]
    made = {
        "name": line.name if len(names) == 1 else f"{line.name}, {names[line.run].split(':')[0]}",
        "colour": look.shade(line.colour, line.run),
        "width": width,
        "dash": [4, 4] if line.is_guide else list(dashes or ()),
        "order": order + 10 * line.is_guide,
        "step": line.is_step,
        "points": line.is_points,
        "x": pool.add(x, "d"),
        "y": pool.add(y, "f"),
    }
    if line.low:
        every = 1 + len(line.x) // (4 * COLUMNS)
        made["band"] = [pool.add(values[::every], code) for values, code in ((line.x, "d"), (line.low, "f"), (line.high, "f"))]
    return made


def draw(names, panels, out):
    pool = Pool()
    data = [
        {
            "title": panel.title + (f" ({panel.note})" if panel.note else ""),
            "yLabel": panel.y_label,
            "xLabel": panel.x_label,
            "overTime": panel.over_time,
            "yRange": panel.y_range,
            "isLog": panel.is_log,
            "xNames": panel.x_names,
            "lines": sorted((_line(line, panel, names, pool) for line in panel.lines), key=lambda made: made["order"]),
        }
        for panel in panels
    ]
    title = ", ".join(names)
    parts = {
        "TITLE": html.escape(title),
        **uplot_parts(),
        # Nothing in a name may end the script element.
        "DATA": json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c"),
        "NUMBERS": pool.text(),
        "GRID": look.GRID,
        "SCRIPT": "".join((HERE / name).read_text(encoding="utf-8") for name in ("chart.js", "page.js")),
    }
    out.write_text(fill(HERE / "page.html", parts), encoding="utf-8")


def fill(template, parts):
    """Fills in the %%PARTS%% of a template's text."""
    pieces = template.read_text(encoding="utf-8").split("%%")
    return "".join(parts[piece] if i % 2 else piece for i, piece in enumerate(pieces))
