"""The paper's case against the numbers of its design page: gamma 1.737, K's poles and zeros, margins."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
from conftest import PAPER

POLES = [-0.002, -340.23, -167.14 + 293.43j, -167.14 - 293.43j]
ZEROS = [-55, -200, -139 + 203j, -139 - 203j]


def nearest(found, wanted):
    return max(min(abs(f - w) / abs(w) for f in found) for w in wanted)


def test_gamma_is_the_papers_within_half_a_percent(paper_result):
    assert paper_result.stage("full").metrics.gamma == pytest.approx(1.737, rel=0.005)
    assert paper_result.gamma_stated == pytest.approx(1.737, rel=0.005)


def test_reduced_controller_has_order_4_and_the_papers_roots(paper_result):
    zpk = paper_result.reduced.zpk
    assert zpk.order == 4 and len(zpk.zeros) == 4
    assert nearest(zpk.poles, POLES) < 0.02
    assert nearest(zpk.zeros, ZEROS) < 0.02
    assert zpk.at_zero() == pytest.approx(1.27e4, rel=0.005)


def test_continuous_margins_are_the_oracles(paper_result):
    m = paper_result.stage("full").metrics
    assert m.gain_margin == pytest.approx(11.5, rel=0.01)
    assert m.phase_margin_deg == pytest.approx(82.6, abs=0.1)
    assert m.crossover_rad_s == pytest.approx(21.8, rel=0.01)
    assert m.max_s == pytest.approx(1.126, rel=0.002)


def test_after_q31_gamma_and_margins_stay(paper_result):
    full, last = paper_result.stage("full").metrics, paper_result.stage("q31").metrics
    assert last.stable
    assert last.gamma == pytest.approx(full.gamma, rel=0.02)
    assert abs(last.phase_margin_deg - full.phase_margin_deg) < 3
    assert last.gain_margin >= 8


def test_the_slow_pole_survives_every_step(paper_result):
    for stage in paper_result.stages:
        assert stage.metrics.slowest_pole_rad_s == pytest.approx(0.002, rel=1e-5), stage.step


def test_whole_run_with_plots_within_20_seconds(tmp_path):
    began = os.times()
    done = subprocess.run([sys.executable, "-m", "tribo_design", "synthesize", str(PAPER), "--out", str(tmp_path / "out")], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    ended = os.times()  # processor time, as other tests may share the machine
    assert ended.children_user + ended.children_system - began.children_user - began.children_system < 20
    for name in ("sensitivity", "nyquist", "controller", "step", "ramp", "sections"):
        assert (tmp_path / "out" / "plots" / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    page = (tmp_path / "out" / "report.html").read_text()
    assert page.count("data:image/png;base64,") == 6 + (tmp_path / "out" / "plots" / "friction.png").is_file()
    assert "://" not in page and "src=\"plots" not in page


def test_the_table_is_printed_and_saved_with_every_quantity(run, tmp_path):
    code, out, _ = run("synthesize", PAPER, "--out", tmp_path / "out", "--no-plots")
    assert code == 0
    saved = (tmp_path / "out" / "report.md").read_text()
    for text in (out, saved):
        for quantity in ("gamma", "max abs S", "max abs T", "max abs KS", "gain margin", "phase margin", "delay margin", "bandwidth", "ramp error", "slowest pole"):
            assert quantity in text
        for step in ("full K", "reduced K", "K(z)", "K(z), f32", "K(z), Q31", "total"):
            assert step in text
    data = json.loads((tmp_path / "out" / "paper_design.json").read_text())
    assert list(data["metrics"]) == ["full", "reduced", "discrete", "f32", "q31"]


def test_loop_is_stable_with_the_header_numbers_by_scipy_alone(paper_dir):
    """The f32 rows as text from the header, the plant from the page, nothing of the tool: poles inside the unit circle,
    and the same step response as the closed loop promises (no steady error to speak of)."""
    import re
    import scipy.signal

    text = (paper_dir / "paper_controller.h").read_text()
    block = text[text.index("CONTROLLER_F32") : text.index("CONTROLLER_Q31")]
    rows = [[float(x.rstrip("f")) for x in row.split(",")] for row in re.findall(r"\{([-0-9.e+f, ]+)\}", block)]
    assert len(rows) == 2
    poles = np.array([-55, -200, -139 + 203j, -139 - 203j, -56778])
    a, b, c, d, _ = scipy.signal.cont2discrete(scipy.signal.zpk2ss([], poles, 0.86 * np.prod(-poles).real), 1e-3, "zoh")
    x, w, y, u_before = np.zeros(len(a)), np.zeros((2, 2)), 0.0, 0.0
    trace = []
    for _ in range(1000):
        y = (c @ x)[0]
        v = 1.0 - y
        for i, (b0, b1, b2, a1, a2) in enumerate(rows):
            out = b0 * v + w[i, 0]
            w[i] = w[i, 0] + b1 * v - a1 * out + w[i, 1], w[i, 1] + b2 * v - a2 * out
            v = out
        x = a @ x + b[:, 0] * v
        trace.append(y)
    assert abs(trace[-1] - 1) < 1e-3
    assert max(trace) < 1.01
    assert trace[50] == pytest.approx(1 - np.exp(-22 * 0.05), abs=0.1)  # crossover 21.8 rad/s
