"""The files that are drawn: pictures by matplotlib, and pages that are opened in a browser."""

import importlib.util
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from conftest import ROOT, SHORT, done, sim

from tribo_plot import look
from tribo_plot.page import UPLOT_VERSION

CHROMIUM = shutil.which("chromium")
CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "tribo" / f"uplot-{UPLOT_VERSION}"
DRAWS = pytest.mark.skipif(importlib.util.find_spec("matplotlib") is None, reason="needs matplotlib, which tools/setup plot installs")
PAGES = pytest.mark.skipif(not CACHE.is_dir(), reason="needs uPlot, which tools/setup plot fetches")
OPENS = pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")


@DRAWS
def test_a_picture_has_its_signals_colours_and_the_same_bytes_again(runs, tmp_path):
    for name in ("a.svg", "b.svg"):
        done(sim("plot", runs / "feedforward", "--all", "--out", tmp_path / name))
    text = (tmp_path / "a.svg").read_text(encoding="utf-8")
    assert (tmp_path / "b.svg").read_text(encoding="utf-8") == text
    for signal in ("r_N", "F_N", "error", "u_N", "controller_N", "friction_term_N", "breakaway_positive_N"):
        assert look.colour(signal).lower() in text, signal


@DRAWS
def test_run_draws_with_and_without_a_folder_and_leaves_nothing_else(tmp_path):
    (tmp_path / "tmp").mkdir()
    environment = {**os.environ, "TMPDIR": str(tmp_path / "tmp")}
    done(sim("run", "triangle", *SHORT, "--plot", "a.png", cwd=tmp_path, env=environment))
    assert "--all needs --plot" in sim("run", "triangle", *SHORT, "--all", cwd=tmp_path, env=environment).stderr
    done(sim("run", "triangle", *SHORT, "--out", "o", "--plot", "b.svg", cwd=tmp_path, env=environment))
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert not list((tmp_path / "tmp").iterdir())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "b.svg", "o", "tmp"]
    assert (tmp_path / "o/summary.json").is_file()


@DRAWS
def test_the_rest_is_drawn_by_all(runs, tmp_path):
    learned = look.colour("breakaway_positive_N").lower()
    done(sim("run", "triangle", *SHORT, "--plot", tmp_path / "a.svg"))
    done(sim("run", "triangle", *SHORT, "--all", "--plot", tmp_path / "b.svg"))
    assert [learned in (tmp_path / name).read_text(encoding="utf-8") for name in ("a.svg", "b.svg")] == [False, True]


@DRAWS
def test_replay_draws_with_its_reference_and_a_gap_between_logs(runs, tmp_path):
    (tmp_path / "tmp").mkdir()
    environment = {**os.environ, "TMPDIR": str(tmp_path / "tmp")}
    logs = [runs / "paper/trace.csv", runs / "off/trace.csv"]
    done(sim("replay", *logs, "--out", "a.csv", "--plot", "a.svg", cwd=tmp_path, env=environment))
    assert "verdict" in done(sim("replay", *logs, "--plot", "b.svg", cwd=tmp_path, env=environment)).stdout
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert look.colour("residual_N").lower() in (tmp_path / "a.svg").read_text(encoding="utf-8")
    rows = (tmp_path / "a.csv").read_text().split()
    assert rows[0].endswith(",F_N,residual_N,r_N,segment") and rows[1].endswith(",0") and rows[-1].endswith(",1")
    assert not list((tmp_path / "tmp").iterdir())


@DRAWS
def test_a_sweep_without_pandas_says_so(tmp_path):
    """The frame of tribo.sweep is read by an environment that has pandas; tests/python draws one there."""
    (tmp_path / "pandas.py").write_text("raise ImportError('no such thing')\n", encoding="ascii")
    (tmp_path / "rows.parquet").write_bytes(b"PAR1")
    result = sim("plot", ".", "--out", "s.svg", cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(tmp_path)})
    assert result.returncode == 1 and "which read rows.parquet (no such thing): `pip install tribo[sweep]`" in result.stderr and not (tmp_path / "s.svg").exists()


@DRAWS
def test_noise_that_is_even_has_an_even_axis():
    import numpy as np
    from tribo_plot.sweeps import is_logarithmic

    even = np.linspace(0.00001, 0.005, 101)
    assert not is_logarithmic(even)
    assert is_logarithmic(np.geomspace(0.00001, 0.005, 101))
    assert not is_logarithmic(np.geomspace(1, 4, 101)) and not is_logarithmic(np.array([0.0, 1.0, 100.0]))


def page(folder, *paths):
    done(sim("plot", *paths, "--out", folder / "page.html", cwd=folder))
    return (folder / "page.html").read_text(encoding="utf-8")


@PAGES
def test_a_page_needs_no_network_and_no_matplotlib(runs, tmp_path):
    text = page(tmp_path, runs / "off", runs / "feedforward")
    assert not re.search(r"(src|href)\s*=|@import|url\(|fetch\(|XMLHttp", text)
    assert "uPlot" in text and "Leon Sorokin" in text
    assert len(text) < 4_000_000
    (tmp_path / "matplotlib.py").write_text("raise ImportError('no such thing')\n", encoding="ascii")
    assert page(tmp_path, runs / "off", runs / "feedforward") == text


@PAGES
def test_no_name_ends_the_page(runs, tmp_path):
    result = done(sim("plot", runs / "drive.csv", runs / "off", "--name", "</script><b>&", "--out", tmp_path / "a.html"))
    assert not result.stderr
    text = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert "</script><b>" not in text and "&lt;/script&gt;" in text


def opened(path, script):
    """What `script` leaves in the page's title."""
    copy = path.with_name("opened.html")
    copy.write_text(
        path.read_text(encoding="utf-8")
        + f"""<script>
            const once = setInterval(async () => {{
                if (!document.body.dataset.drawn) return;
                clearInterval(once);
                document.title = String(await (async () => {{ {script} }})());
            }}, 100);
        </script>""",
        encoding="utf-8",
    )
    command = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=60000", "--dump-dom", copy.as_uri()]
    dom = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300).stdout
    return re.search(r"<title>(.*?)</title>", dom)[1]


@PAGES
@OPENS
def test_a_page_draws_its_panels_and_zooms_them_together(runs, tmp_path):
    page(tmp_path, runs / "off", runs / "feedforward", "--all")
    zoom = 'timed[1].setScale("x", {min: 3, max: 4}); await new Promise((done) => setTimeout(done, 500)); return'
    found = opened(tmp_path / "page.html", f"{zoom} [document.body.dataset.drawn, ...timed.map((u) => u.scales.x.max)]").split(",")
    assert found == ["7", "4", "4", "4", "4", "4"]
    inked = opened(tmp_path / "page.html", """return [...document.querySelectorAll("canvas")].every((canvas) => {
        const pixels = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
        const colours = new Set();
        for (let i = 0; i < pixels.length; i += 4) if (pixels[i + 3] === 255) colours.add(pixels.slice(i, i + 3).join());
        return colours.size > 3;
    });""")
    assert inked == "true"


def test_the_tool_is_found_by_the_program_and_helps():
    result = subprocess.run([ROOT / "tools/tribo-plot", "--help"], capture_output=True, text=True, check=False, timeout=60)
    assert result.returncode == 0 and "--out" in result.stdout
