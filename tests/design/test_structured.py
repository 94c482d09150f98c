"""PI, PID and lead-lag by the same weights, weights from wishes, and designs side by side."""

import json
import os
import subprocess

import numpy as np
import pytest
import ruamel.yaml
import scipy.optimize
from conftest import PAPER, ROOT
from independent import figures, sampled_plant, weight

from tribo_design import friction, pipeline, structured
from tribo_design.config import Design, Weights, validate
from tribo_design.errors import IllPosedError, InputError
from tribo_design.synthesis import make_plant
from tribo_design.zpk import Zpk

EXAMPLE = ruamel.yaml.YAML(typ="safe").load((ROOT / "designs" / "example.yaml").read_text())
EXAMPLE["limits"] = {"floor": {"gain_margin_min": 2}}
SIM = pytest.mark.skipif("TRIBO_SIM" not in os.environ, reason="no tribo-sim: TRIBO_SIM is not set")


def synthesized(data, **synthesis):
    return pipeline.synthesize(validate(Design, {**data, "synthesis": synthesis}, "test"), "0" * 64, "test")


def test_no_pi_on_a_dense_grid_is_better():
    result = synthesized(EXAMPLE, structure="pi")
    stated = result.stages[-1].metrics.gamma
    found = figures(EXAMPLE, result.q31.values(), EXAMPLE["weights"], 2e-3)
    assert found["gamma"] == pytest.approx(stated, rel=1e-3) and abs(found["missing_turns"] - 0.5) < 0.1  # the PI's own pole at 0
    h = EXAMPLE["sample_time_s"]
    omega = np.geomspace(1e-3, 0.999 * np.pi / h, 1500)
    z = np.exp(1j * omega * h)
    g, w = sampled_plant(EXAMPLE["plant"], h, 2e-3)(z), 2 / h * (z - 1) / (z + 1)
    parts = [weight(EXAMPLE["weights"][n], omega) for n in ("wp", "wu", "wT")]
    best = np.inf
    for kp in np.geomspace(0.2, 5, 40):
        for corner in np.geomspace(2, 60, 40):
            k = kp * (w + corner) / w
            back = 1 + g * k
            turned = np.unwrap(np.angle(back))
            if abs(turned[-1] - turned[0] - np.pi / 2) > 1:
                continue
            gamma = np.sqrt(abs(parts[0] / back) ** 2 + abs(parts[1] * k / back) ** 2 + abs(parts[2] * g * k / back) ** 2).max()
            best = min(best, gamma)
    assert stated <= 1.001 * best


def test_each_structure_is_between_the_full_order_and_what_it_contains():
    gammas = {name: synthesized(EXAMPLE, structure=name).stages[-1].metrics.gamma for name in ("full", "pi", "pid", "lead-lag")}
    assert gammas["full"] <= 1.001 * gammas["pid"] <= 1.002 * gammas["pi"]
    assert gammas["full"] <= 1.001 * gammas["lead-lag"] < 1.05 * gammas["full"]


def test_the_numbers_that_are_told_make_the_controller():
    result = synthesized(EXAMPLE, structure="pid")
    import re

    kp, ki, kd, f = (float(re.search(rf"{n} ([-0-9.e+]+)", result.structure_note).group(1)) for n in ("kp", "ki", "kd", "filter"))
    w = 1j * np.array([0.1, 10.0, 300.0])
    assert np.allclose(kp + ki / w + kd * w * f / (w + f), result.full(w), rtol=1e-3)
    assert "gamma of the full order: 0.966" in result.structure_note
    assert "pid: kp" in "\n".join(__import__("tribo_design.emit", fromlist=["emit"]).provenance(result))


def test_a_structure_that_cannot_stabilise_is_refused():
    data = {**EXAMPLE, "plant": {"k": 1.0, "poles": [30, 40, -100]}}
    with pytest.raises(IllPosedError, match="no pi controller was found that stabilises"):
        synthesized(data, structure="pi")
    with pytest.raises(InputError, match="structure"):
        synthesized(EXAMPLE, structure="pi", domain="continuous")


def test_wishes_are_the_weights_they_stand_for():
    made = Weights.model_validate({"wishes": {"bandwidth_rad_s": 15, "peak": 2, "steady_error": 1e-3, "u_per_r": 3, "rolloff_rad_s": 60}})
    assert made.wp.num == [0.5, 15] and made.wp.den == [1, 0.015] and made.wu.k == pytest.approx(1 / 3) and made.wT.num == [1, 30] and made.wT.den == [0.01, 60]
    both = Weights.model_validate({"wishes": {"bandwidth_rad_s": 15, "u_per_r": 3}, "wu": 0.1})
    assert both.wu.k == 0.1
    with pytest.raises(InputError, match="u_per_r"):
        validate(Design, {"name": "x", "sample_time_s": 1e-3, "plant": {"gain": 1, "poles": [-1]}, "weights": {"wishes": {"bandwidth_rad_s": 15}}}, "test")


def test_the_chain_of_tribo_sim_has_the_plants_poles():
    for poles in ([-55, -200, -139 + 203j, -139 - 203j], [-12, -81 + 60j, -81 - 60j], [-12, -300], [-20, -50, -300]):
        chain, why = friction.chain_of(Zpk([], poles, 1.0).with_value_at(0, 1.0), 1e-3)
        arm = np.roots([chain.inertia, chain.damping, friction.STIFFNESS])
        found = [r for r in [-chain.actuator, -chain.sensor, *arm] if abs(r) < 1e6]
        assert why == "" and np.allclose(np.sort_complex(found), np.sort_complex(np.array(poles, complex)))
    assert "zeros" in friction.chain_of(Zpk([-3], [-1, -2], 1.0), 1e-3)[1]
    assert "not stable" in friction.chain_of(Zpk([], [1, -2], 1.0), 1e-3)[1]


@SIM
def test_the_scenario_plays_the_designs_own_plant(tmp_path, paper_result):
    """Without friction to speak of, tribo-sim's step is the closed loop's of the sections and the plant."""
    plant, _ = make_plant(paper_result.design.plant)
    text = friction.scenario(paper_result.design, plant, paper_result.f32, "x")
    (tmp_path / "loop.yaml").write_text(text.replace("kind: triangle, low_N: 0.4, high_N: 0.6, period_s: 20", "kind: step, low_N: 0, high_N: 0.5, start_s: 0").replace("duration_s: 60", "duration_s: 0.3").replace("start_s: 20", "start_s: 0"))
    subprocess.run([os.environ["TRIBO_SIM"], "run", tmp_path / "loop.yaml", "--out", tmp_path / "run", "--set", "compensator.method=off", "--set", "plant.friction.breakaway={offset_N: 1.0e-6, slope: 0}"],
                   check=True, capture_output=True)
    rows = np.genfromtxt(tmp_path / "run" / "trace.csv", delimiter=",", names=True)
    time, _, y, _ = paper_result.stage("f32").loop.responses(0.3)
    assert np.allclose(rows["y_N"][:290], 0.5 * y[:290], atol=2e-3)


@SIM
def test_the_papers_benchmark_is_in_the_report(run, tmp_path):
    code, out, err = run("synthesize", PAPER, "--out", tmp_path / "out")
    assert code == 0, err
    played = json.loads((tmp_path / "out" / "paper_design.json").read_text())["friction"]
    assert played["rms_n"]["without"] / played["rms_n"]["with"] > 2
    text = (tmp_path / "out" / "report.md").read_text()
    assert "RMS of r - F" in text and "plots/friction.png" in text and "Gamma peaks at" in text
    assert run("check", tmp_path / "out")[0] == 0


def test_without_tribo_sim_the_report_says_so(monkeypatch, paper_result):
    monkeypatch.setenv("TRIBO_SIM", "/nowhere/tribo-sim")
    played = friction.play(paper_result.design, paper_result.plant, paper_result.f32)
    assert "no tribo-sim was found" in friction.in_words(played)


def test_compare_puts_designs_in_one_table(run, tmp_path, paper_dir):
    path = tmp_path / "example.yaml"
    with path.open("w") as file:
        ruamel.yaml.YAML(typ="safe").dump(EXAMPLE, file)
    code, out, err = run("compare", path, "--structures", "full,pi")
    assert code == 0, err
    rows = [line.split() for line in out.splitlines() if line.startswith("example")]
    assert [r[1] for r in rows] == ["full", "pi"] and float(rows[0][3]) < float(rows[1][3])
    code, out, err = run("compare", paper_dir, path)
    assert code == 0 and [line.split()[0] for line in out.splitlines()[1:3]] == ["paper", "example"], err
    if "TRIBO_SIM" in os.environ:
        assert all(float(r[-1]) > 0 for r in rows)


def test_compare_takes_directories_as_they_are_beside_structures_for_files(run, tmp_path, paper_dir):
    path = tmp_path / "example.yaml"
    with path.open("w") as file:
        ruamel.yaml.YAML(typ="safe").dump(EXAMPLE, file)
    code, out, err = run("compare", path, paper_dir, "--structures", "full,pi")
    assert code == 0, err
    assert [line.split()[:2] for line in out.splitlines()[1:4]] == [["example", "full"], ["example", "pi"], ["paper", "full"]] and out.count("paper  ") == 1


@SIM
def test_compensation_that_makes_the_loop_worse_is_warned_of(run, tmp_path, monkeypatch):
    """A tick of 50 ms and one of delay, with an arm at 30 rad/s that rings: it helps even here, so the two errors change places."""
    path = tmp_path / "slow.yaml"
    path.write_text("name: slow\nsample_time_s: 0.05\ncomputation_delay_s: 0.05\nplant: {gain: 1, poles: [-12, -10+30j, -10-30j]}\n"
                    "weights: {wishes: {bandwidth_rad_s: 6, u_per_r: 3}}\nfixed_point: {full_scale_n: 5}\nlimits: {floor: {gain_margin_min: 1.2, phase_margin_min_deg: 10}}\n")
    code, out, err = run("synthesize", path, "--out", tmp_path / "out", "--no-plots")
    assert code == 0 and "WARNING" not in out, err
    played = json.loads((tmp_path / "out" / "slow_design.json").read_text())["friction"]["rms_n"]
    assert played["without"] / played["with"] > 2
    monkeypatch.setattr(friction, "play", lambda *arguments, **options: {"rms_n": {"without": played["with"], "with": played["without"]}, "max_n": {}})
    code, out, err = run("synthesize", path, "--out", tmp_path / "worse", "--no-plots")
    assert code == 0, err
    warning = f"WARNING: {played['without'] / played['with']:.2f} times the error: compensation makes this loop worse"
    assert warning in out and warning in (tmp_path / "worse" / "report.md").read_text() and warning in (tmp_path / "worse" / "report.html").read_text()
    assert "note: worse: with the paper's friction" in (compared := run("compare", tmp_path / "worse")[1]) and warning in compared


def test_compensation_is_reported_to_help_only_where_it_does():
    def words(without, with_it):
        return friction.in_words({"rms_n": {"without": without, "with": with_it}})

    assert "(2.00 times less)" in words(0.02, 0.01) and "WARNING" not in words(0.02, 0.01)
    assert "WARNING: 2.00 times the error: compensation makes this loop worse" in words(0.01, 0.02) and "less" not in words(0.01, 0.02)
    assert "WARNING" in words(0.01, 0.01) and "no better" in words(0.01, 0.01)


def test_compare_says_what_was_refused_and_still_shows_the_others(run, tmp_path, paper_dir):
    path = tmp_path / "bad.yaml"
    path.write_text(PAPER.read_text().replace("gamma_max: 5", "gamma_max: 1"))
    code, out, err = run("compare", paper_dir, path)
    assert code == 1 and "refused: bad.yaml: " in err and "gamma_max" in err and "paper" in out
    assert run("compare", path, "--structures", "p")[0] == 2
