"""G S, ranges of the plant, disk margin, mu, and a controller that hides a resonance."""

import numpy as np
import pytest
import ruamel.yaml
from conftest import ROOT
from independent import cascade, sampled_plant

from tribo_design import pipeline, robustness
from tribo_design.config import Design, Plant, validate
from tribo_design.errors import DesignError, InputError
from tribo_design.loop import Continuous, Loop
from tribo_design.zpk import Zpk

WISHES = {"bandwidth_rad_s": 15, "u_per_r": 5}
JOINT = {"name": "joint", "sample_time_s": 1e-3, "plant": {"gain": 1, "poles": [-300, "-1.885+94.23j", "-1.885-94.23j"]}, "weights": {"wishes": WISHES}}
MOVING = {**JOINT, "plant": {"gain": 1, "poles": [-300, "-1.885+94.23j ± 10 %", "-1.885-94.23j ± 10 %"]}}


def synthesized(data):
    return pipeline.synthesize(validate(Design, data, "test"), "0" * 64, "test")


@pytest.fixture(scope="module")
def joint():
    return synthesized(JOINT)


def test_a_cancelled_resonance_is_reported_with_its_g_s(joint):
    """A 15 Hz joint with damping 0.02: max S 1.1, and the resonance 10 % lower is unstable."""
    assert joint.stages[-1].metrics.max_s < 1.2 and joint.stages[-1].metrics.max_gs > 5
    assert any("cancels the lightly damped mode -1.885+94.23j" in s for s in robustness.in_words(joint.robustness))


def test_a_range_that_holds_unstable_plants_is_refused():
    with pytest.raises(DesignError, match=r"robustness: \d+ of \d+ plants within the stated ranges are unstable.*94\.23j \+- 10 % at -1"):
        synthesized(MOVING)


def test_a_weight_on_g_s_makes_the_resonance_safe():
    result = synthesized({**MOVING, "weights": {"wishes": WISHES, "wGS": 0.3}})
    assert result.robustness["unstable"] == 0 and result.stages[-1].metrics.max_gs < 3
    assert not result.robustness["cancelled"]
    # The term counts in gamma: an independent sum of all four.
    omega = np.geomspace(0.01, np.pi / 1e-3 * 0.999, 20_000)
    z = np.exp(1j * omega * 1e-3)
    g, k = sampled_plant(JOINT["plant"], 1e-3, 0.0)(z), cascade(result.q31.values(), z)
    s = 1 / (1 + g * k)
    w = result.stages[-1].loop.weights
    gamma = np.sqrt(sum(abs(w[n](1j * omega) * f) ** 2 for n, f in (("wp", s), ("wu", k * s), ("wT", g * k * s), ("wGS", g * s)))).max()
    assert result.stages[-1].metrics.gamma == pytest.approx(gamma, rel=1e-3)


def test_worst_figures_are_those_of_the_worst_plant():
    data = ruamel.yaml.YAML(typ="safe").load((ROOT / "designs" / "example.yaml").read_text())
    data["plant"] = {"gain": "1.40 ± 20 %", "poles": ["-12 ± 10 %", "-81+60j", "-81-60j"]}
    result = synthesized(data)
    found = result.robustness
    assert found["corners"] == 4 and found["plants"] == 64 and found["unstable"] == 0
    x = found["worst_at"]["max_s"]
    plant = {"gain": 1.4 * (1 + 0.2 * x[0]), "poles": [-12 * (1 + 0.1 * x[1]), "-81+60j", "-81-60j"]}
    omega = np.geomspace(0.01, np.pi / 2e-3, 20_000)
    z = np.exp(1j * omega * 2e-3)
    worst = abs(1 / (1 + sampled_plant(plant, 2e-3, 2e-3)(z) * cascade(result.q31.values(), z))).max()
    assert found["worst"]["max_s"] == pytest.approx(worst, rel=5e-3)
    assert found["worst"]["max_s"] > result.stages[-1].metrics.max_s
    assert 0 < found["mu"]["peak"] < 1


def test_mu_of_the_gain_alone_is_the_gain_margin():
    data = ruamel.yaml.YAML(typ="safe").load((ROOT / "designs" / "example.yaml").read_text())
    data["plant"] = {"gain": "1.40 ± 20 %", "poles": [-12, "-81+60j", "-81-60j"]}
    result = synthesized(data)
    margin = result.stages[-1].metrics.gain_margin
    assert result.robustness["mu"]["peak"] == pytest.approx(0.2 / (margin - 1), rel=0.03)


def test_check_sees_a_robustness_that_is_not_the_designs(run, tmp_path):
    import json

    path = tmp_path / "u.yaml"
    path.write_text((ROOT / "designs" / "example.yaml").read_text().replace("gain: 1.40", "gain: 1.40 ± 5 %"))
    code, out, err = run("synthesize", path, "--out", tmp_path / "out", "--no-plots")
    assert code == 0 and "62 plants within gain +- 5 %" in out, err
    assert run("check", tmp_path / "out")[0] == 0
    data = json.loads((tmp_path / "out" / "example_design.json").read_text())
    data["robustness"]["worst"]["max_s"] *= 0.99
    (tmp_path / "out" / "example_design.json").write_text(json.dumps(data))
    code, _, err = run("check", tmp_path / "out")
    assert code == 5 and "robustness" in err


def test_disk_margin_is_python_controls():
    import control as ct

    plant, k = Zpk([], [-1, -2, -3], 6.0), Zpk([-1.5], [-0.1, -30.0], 40.0)
    loop = ct.zpk(plant.zeros, plant.poles, plant.gain) * ct.zpk(k.zeros, k.poles, k.gain)
    omega = np.geomspace(1e-2, 1e2, 4000)
    assert Loop(Continuous(plant), Continuous(k)).metrics().disk_margin == pytest.approx(float(np.min(ct.disk_margins(loop, omega, skew=0.0)[0])), rel=1e-3)


def test_ranges_are_read_in_both_ways():
    short = Plant.model_validate({"gain": "0.86 ± 5 %", "poles": [-55, "-139+203j +- 10 %", "-139-203j ± 10%"], "delay_s": "0.002 ± 20 %"})
    long = Plant.model_validate({"gain": 0.86, "gain_percent": 5, "poles": [-55, "-139+203j", "-139-203j"], "poles_percent": [0, 10, 10], "delay_s": 0.002, "delay_percent": 20})
    assert short == long and [r[1] for r in robustness.ranges(short)] == ["gain", "delay", "poles"]
    system, delay = robustness.moved(short, Zpk([], short.poles, 1.0).with_value_at(0, 0.86), (1, -1, 1))
    assert system.at_zero() == pytest.approx(0.86 * 1.05) and delay == pytest.approx(0.0016)
    assert np.allclose(sorted(abs(system.poles)), [55, 1.1 * abs(-139 + 203j), 1.1 * abs(-139 + 203j)])


@pytest.mark.parametrize("plant, words", [({"gain": "1 ± x %", "poles": [-1]}, "gain_percent"), ({"gain": "1 ± 5 %", "gain_percent": 5, "poles": [-1]}, "given twice"),
                                          ({"gain": 1, "poles": ["-1 ± 120 %"]}, "poles_percent"), ({"gain": 1, "poles": [-1, -2], "poles_percent": [5]}, "as many entries as poles")])
def test_broken_ranges_are_refused(plant, words):
    with pytest.raises(InputError, match=words):
        validate(Design, {"name": "x", "sample_time_s": 1e-3, "plant": plant}, "test")
