"""The solver is bounded in time and not believed blindly."""

import time

import control as ct
import numpy as np
import pytest
from conftest import PAPER
from problems import well_posed

from tribo_design import pipeline, synthesis
from tribo_design.config import Design, load_design, validate
from tribo_design.errors import IllPosedError
from tribo_design.loop import response_of
from tribo_design.systems import state_space


def design_of(data):
    return validate(Design, data, "test")


def hang(sender, *_):
    while True:
        time.sleep(1)


def die(sender, *_):
    import os

    os._exit(11)


def lie(sender, *_):
    """A destabilising controller with a beautiful gamma."""
    sender.send((0.5, np.array([[-1.0]]), np.array([[1.0]]), np.array([[-1e6]]), np.array([[0.0]])))


def boast(sender, *_):
    """A stabilising controller whose gamma is far from what it says."""
    sender.send((1.0, np.array([[-1.0]]), np.array([[1e-6]]), np.array([[1.0]]), np.array([[0.0]])))


def test_a_solver_that_hangs_is_stopped_in_time(monkeypatch, run, tmp_path):
    monkeypatch.setattr(synthesis, "_child", hang)
    began = time.monotonic()
    code, _, err = run("synthesize", PAPER, "--out", tmp_path / "out", "--time-limit", "1.5")
    assert time.monotonic() - began < 60
    assert code == 3 and "1.5 s" in err and "time_limit_s" in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("child, words", [(die, "broke down"), (lie, "not stable"), (boast, "gamma")])
def test_a_solver_that_dies_or_lies_is_refused(monkeypatch, child, words):
    monkeypatch.setattr(synthesis, "_child", child)
    design, _ = load_design(PAPER)
    with pytest.raises(IllPosedError, match=words):
        synthesis.solve(synthesis.make_problem(design), design.synthesis)


def test_a_search_that_stops_too_low_is_gone_over_again(monkeypatch):
    """As on processors on which rounding hides from the solver that a gamma cannot be reached."""
    design, _ = load_design(PAPER)
    problem = synthesis.make_problem(design)
    right = synthesis.solve(problem, design.synthesis)
    search = synthesis._search

    def low(systems):
        gamma = search(systems)[0]
        p = synthesis._augmented(*systems)
        return 0.7 * gamma, synthesis.slycot.sb10ad(p.nstates, p.ninputs, p.noutputs, 1, 1, 3 * gamma, p.A, p.B, p.C, p.D, job=4)[1:5]

    monkeypatch.setattr(synthesis, "_search", low)
    found = synthesis.solve(problem, design.synthesis)
    assert found.how.endswith("gamma bisected")
    assert right.gamma_measured * 0.995 < found.gamma_measured < right.gamma_measured * 1.015


def test_gamma_is_python_controls_own_norm(paper_result):
    """The figure against the norm of python-control's closed loop, made from its own pieces here."""
    s = ct.tf("s")
    poles = (-55, -200, -139 + 203j, -139 - 203j, -56778)
    plant = ct.zpk([], poles, 0.86 * np.prod([-p for p in poles]).real)
    wp, wt = (s / 1.1 + 20) / (s + 20e-4), (s + 18.2) / (1e-4 * s + 20)
    space = state_space(paper_result.full)
    omega = np.geomspace(1e-5, 1e7, 3000)
    k = response_of(space, 1j * omega)
    g = plant(1j * omega)
    sens = 1 / (1 + g * k)
    peak = np.sqrt(abs(wp(1j * omega) * sens) ** 2 + abs(k * sens) ** 2 + abs(wt(1j * omega) * g * k * sens) ** 2).max()
    assert paper_result.stage("full").metrics.gamma == pytest.approx(peak, rel=1e-3)


def test_forms_of_the_same_plant_give_the_same_controller():
    data = well_posed(0)
    data["plant"] = {"gain": 2.0, "zeros": [-300], "poles": [-10, "-20+30j", "-20-30j"]}
    data["sample_time_s"] = 0.002
    data["weights"] = {"wp": {"num": [0.5, 5], "den": [1, 0.005]}, "wu": 0.3, "wT": {"num": [1, 10], "den": [1e-3, 20]}}
    gain = 2.0 * 10 * 1300 / 300
    den = np.real(np.poly([-10, -20 + 30j, -20 - 30j]))
    forms = [data["plant"], {"k": gain, "zeros": [-300], "poles": [-10, "-20+30j", "-20-30j"]}, {"num": [gain, 300 * gain], "den": den.tolist()}]
    a, b, c, d = ct.ssdata(ct.tf2ss([gain, 300 * gain], den))
    forms.append({"a": np.asarray(a).tolist(), "b": np.asarray(b).ravel().tolist(), "c": np.asarray(c).ravel().tolist(), "d": 0})
    results = []
    for form in forms:
        results.append(pipeline.synthesize(design_of({**data, "plant": form}), "0" * 64, "test"))
    for result in results[1:]:
        assert result.gamma == pytest.approx(results[0].gamma, rel=1e-4)
        assert np.allclose(np.sort_complex(result.reduced.zpk.poles), np.sort_complex(results[0].reduced.zpk.poles), rtol=2e-3)


def test_an_unstable_plant_gets_a_stable_loop_or_says_that_the_controller_would_be_unstable():
    data = well_posed(0)
    data.update(sample_time_s=0.001, plant={"k": 20.0, "zeros": [], "poles": [5, -40]},
                weights={"wp": {"num": [0.3, 6], "den": [1, 0.01]}, "wu": 0.05, "wT": {"num": [1, 20], "den": [1e-3, 80]}})
    data["limits"] = {"floor": {"gain_margin_min": 1.2, "phase_margin_min_deg": 20}, "discrete": {}, "total": {}}
    result = pipeline.synthesize(design_of(data), "0" * 64, "test")
    assert all(s.metrics.stable for s in result.stages)


def test_an_unstable_mode_that_nothing_reaches_is_refused():
    data = well_posed(0)
    data["plant"] = {"a": [[1, 0], [0, -2]], "b": [0, 1], "c": [1, 1]}
    with pytest.raises(IllPosedError, match="plant: the mode at 1 rad/s cannot be controlled"):
        pipeline.synthesize(design_of(data), "0" * 64, "test")


def test_gamma_over_its_limit_names_a_frequency(paper_data):
    paper_data["synthesis"]["gamma_max"] = 1.6
    with pytest.raises(IllPosedError, match=r"gamma 1\.737 only, over gamma_max 1\.6.*rad/s") as error:
        pipeline.synthesize(design_of(paper_data), "0" * 64, "test")
    assert error.value.cause == "contradicting weights"
