"""tribo-identify on rigs of simulators that share no code with it. The long version is foreign_study.py."""

from concurrent.futures import ProcessPoolExecutor
from types import SimpleNamespace

import foreign
import foreign_study
import numpy as np
import pytest
import synthetic

from tribo_identify import events, friction, native, slides
from tribo_identify.events import Refusal

CASES = {"coulomb": (3, {}), "lugre": (13, {}), "maxwell": (2, {}), "calibrated": (12, {"scale": 1.0}), "falls": (18, {"scale": 1.0, "ratio": 0.9, "by_distance": True, "distance": None}),
         "asymmetric": (24, {"scale": 1.0, "bias": 0.0, "less": 0.7})}


ONE_WAY = 100018  # of foreign_study: a part of its log that goes one way


def rig_of(case):
    if case == "one way":
        return foreign_study.rig_of(ONE_WAY)
    seed, given = CASES[case]
    rig = foreign.rig_of(seed, **given)
    return rig | {"distance": 0.03 * rig["high"]} if rig["distance"] is None else rig


@pytest.fixture(scope="module")
def played():
    """(rig, log) of each case."""
    rigs = {case: rig_of(case) for case in (*CASES, "one way")}
    kinds = [[c for c in rigs if rigs[c]["kind"] == kind] for kind in foreign.KINDS]
    with ProcessPoolExecutor() as pool:
        rows = pool.map(foreign.play, [[rigs[c] for c in of_kind] for of_kind in kinds])
        return {c: (rigs[c], one) for of_kind, logs in zip(kinds, rows) for c, one in zip(of_kind, logs)}


def identify(rows, assume=None):
    return friction.identify(synthetic.log_of(rows), assume=assume)


def verdicts(result):
    return {e.verdict for e in result.estimates if e.name.startswith(("offset", "slope", "scale"))}


def L_hat(rig, result):
    force = np.linspace(rig["low"], rig["high"], 5)
    return force, friction.breakaway(result.params, result.table, force)


@pytest.mark.parametrize("case", ["coulomb", "lugre", "maxwell"])
def test_a_foreign_rig_is_found_within_its_intervals(played, case):
    rig, rows = played[case]
    result = identify(rows, "symmetric")
    truth = {**rig, "gravity": rig["bias"]}
    assert verdicts(result) == {"identified"}
    for e in result.estimates:
        if e.name in ("offset", "slope", "scale"):
            assert abs(e.value - truth[e.name]) <= e.half <= 0.2 * truth[e.name]
    force, (L, _) = L_hat(rig, result)
    assert pytest.approx(foreign.L_of(rig, force), rel=0.03) == L


def test_friction_that_falls_is_named_with_breakaway_and_sliding(played):
    rig, rows = played["falls"]
    result = identify(rows)
    assert verdicts(result) == {"weak"}
    assert result.fall[0] == pytest.approx(1 / 0.9 - 1, abs=0.03)
    assert any("friction falls once it slides: breakaway is" in r for r in result.remarks)
    force, (L, _) = L_hat(rig, result)
    assert pytest.approx(foreign.L_of(rig, force, sliding=True), rel=0.02) == L
    assert identify(played["calibrated"][1]).fall[0] < friction.FALL


def test_asymmetric_friction_is_named_and_fitted_by_direction(played):
    rig, rows = played["asymmetric"]
    result = identify(rows)
    assert "weak" in verdicts(result) and any("friction is asymmetric and u is right" in r for r in result.remarks)
    result = identify(rows, "calibrated")
    force, both = L_hat(rig, result)
    for way, L in zip((1, -1), both):
        assert pytest.approx(foreign.L_of(rig, force, way), rel=0.03) == L


def test_a_sensors_volts_are_no_newton(played):
    rig, rows = played["calibrated"]
    assert verdicts(identify(rows)) == {"identified"}
    with pytest.raises(Refusal, match="in a sensor's volts"):
        identify(rows * [1, 1, 0.3])
    assert "weak" in verdicts(identify(rows * [1, 1, 0.8]))


@pytest.mark.parametrize("what", foreign_study.SPOILS)
def test_a_spoilt_log_is_never_wrong_with_confidence(played, what):
    verdict, text, _ = foreign_study.one((*played["calibrated"], what))
    assert verdict in ("refused", "weak", "identified"), text


def test_break_aways_that_share_no_load_are_refused(played):
    verdict, text, _ = foreign_study.one((*played["one way"], "one direction"))
    assert verdict == "refused" and text.startswith("few loads: F breaks away both ways at no load"), text


def test_the_judge_knows_a_wrong_answer(played):
    rig, rows = played["calibrated"]
    result = identify(rows)
    assert foreign_study.judged(rig, result) == "identified"
    assert foreign_study.judged(rig | {"slope": 1.2 * rig["slope"]}, result) == "wrong"
    assert foreign_study.judged(rig, result, smaller=1.1) == "wrong"


def segment(u, force):
    return synthetic.log_of(np.c_[np.arange(len(u)) * 1e-3, u, force]).segments[0]


def test_held_levels_of_u_are_no_limit():
    u = np.repeat([0.0, 0.3, 0.6, 0.9, 0.6, 0.3, 0.0, 0.4], 100)
    assert not events.saturated(segment(u, 0.8 * u + np.linspace(0, 1e-3, len(u)))).any()
    u = np.minimum(1 - np.abs(np.linspace(-1, 1, 800)), 0.7)
    assert events.saturated(segment(u, np.linspace(0, 1e-3, len(u)))).mean() > 0.2


def test_a_scale_hardly_off_is_asymmetric_friction_where_friction_is_small():
    """0.4 % of scale are 15 % of a breakaway of 0.05 |F|. Seed 100019 of foreign_study was wrong with confidence."""
    t = np.arange(0, 80, 1e-3)
    force = 5.0 + 4.0 * np.interp(t % 8, [0, 1, 2, 5, 8], [-1, 1, -1, 1, -1])
    way, rate = np.sign(np.gradient(force)), np.gradient(force, 1e-3)
    for less, calls in ((0.85, True), (1.0, False)):
        u = force + 0.01 * rate + way * (0.05 + 0.05 * force) * np.where(way > 0, 1.0, less) + np.random.default_rng(1).normal(0, 1e-3, len(t))
        found = slides.line(synthetic.log_of(np.c_[t, u, force]), "symmetric")
        scale = friction.Estimate("scale", found.values["scale"], 1e-3, "identified")
        params = native.PAPER | {"gravity": 0.0, **{f"{n}_{way}": found.values[n] for n in ("offset", "slope") for way in ("positive", "negative")}}
        result = SimpleNamespace(estimates=[scale], params=params, table=[], loads=[(1.0, 1.0), (9.0, 9.0)])
        assert abs(scale.value - 1) < friction.GAP
        assert bool(friction._readings(result)) == calls


def test_the_line_of_exact_slides():
    t = np.arange(0, 80, 1e-3)
    force = 1.0 + 0.5 * np.interp(t % 8, [0, 1, 2, 5, 8], [0, 1, 0, 1, 0]) + 0.1 * t / 4
    way, rate = np.sign(np.gradient(force)), np.gradient(force, 1e-3)
    u = (force + 0.01 * rate + way * (0.05 + 0.2 * force) - 0.03) / 0.9
    found = slides.line(synthetic.log_of(np.c_[t, u, force]), "symmetric")
    assert found.is_sure() and found.error < 1e-4
    assert [found.values[n] for n in ("offset", "slope", "scale", "gravity")] == pytest.approx([0.05, 0.2, 0.9, 0.03], abs=1e-4)
    assert found.lag_s == pytest.approx(0.01, abs=5e-4)
