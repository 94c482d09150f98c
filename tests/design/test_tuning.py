"""`tune`: the library's rule, printed as a scenario takes it."""

import pytest
import ruamel.yaml

from tribo_design import tuning
from tribo_design.cli import main


def tuned(capsys, *arguments):
    assert main(["tune", *arguments]) == 0
    return ruamel.yaml.YAML(typ="safe").load(capsys.readouterr().out)["compensator"]


def test_the_papers_rig_has_the_defaults_of_the_library(capsys):
    found = tuned(capsys)
    assert found["method"] == "feedforward"
    assert (found["feedforward"]["reversal_N"], found["feedforward"]["jump_time_s"]) == (0.0005, 0.02625)
    assert (found["feedforward"]["presliding_N"], found["feedforward"]["forgetting_per_N"]) == pytest.approx((0.157 / 11, 0.1), rel=1e-5)
    assert found["guard"] == {"on": "yes", "turn_N": 0.05, "quick_time_s": 0.2, "stray_N": 0.01, "fade_time_s": 0.5}


def test_noise_rig_and_tick_count(capsys):
    found = tuned(capsys, "--offset", "0.07", "--negative-offset", "0.21", "--usual-force", "5", "--noise", "0.02", "--sample-time", "0.002",
                  "--actuator-pole", "100")
    assert found["feedforward"]["reversal_N"] == pytest.approx(1.64 / 314, rel=1e-5)  # mean L at 5 N is 1.64 N; over 314
    assert found["feedforward"]["presliding_N"] == pytest.approx(1.64 / 11, rel=1e-5)
    assert found["feedforward"]["forgetting_per_N"] == pytest.approx(0.0157 / 1.64, rel=1e-5)
    assert found["feedforward"]["jump_time_s"] == 0.03675
    assert found["guard"]["stray_N"] == 0.16


def test_what_cannot_be_is_refused_by_name(capsys):
    for arguments, exit_code, text in ((("--noise", "-1"), 2, "--noise: -1, allowed are 0"), (("--slope", "nan"), 2, "--slope: value nan"),
                                       (("--sample-time", "1"), 1, "sample_time_s: 1e-6 to 0.1 s"), (("--stiffness", "1e9"), 1, "arm: ")):
        assert main(["tune", *arguments]) == exit_code
        assert text in capsys.readouterr().err


LOOP = """sample_time_s: 2.0e-3
plant: {actuator_pole_rad_per_s: 100}
limits: {u_min_N: -12, u_max_N: 20, input_max_N: 2000}
sensor: {noise_N: 0.02}
compensator: {friction: {breakaway: BREAKAWAY}}
"""


@pytest.mark.parametrize("breakaway", ["{offset_N: 0.07, slope: 0.3, negative_offset_N: 0.21}",
                                       "{table: [{force_N: 0, positive_N: 0.07, negative_N: 0.21}, {force_N: 10, positive_N: 3.07, negative_N: 3.21}]}"])
def test_a_loop_says_the_same_as_its_numbers(tmp_path, capsys, breakaway):
    path = tmp_path / "loop.yaml"
    path.write_text(LOOP.replace("BREAKAWAY", breakaway))
    numbers = ("--offset", "0.07", "--negative-offset", "0.21", "--noise", "0.02", "--sample-time", "0.002", "--actuator-pole", "100")
    assert tuned(capsys, str(path)) == tuned(capsys, *numbers, "--usual-force", "5")
    assert tuned(capsys, str(path), "--usual-force", "10") == tuned(capsys, *numbers, "--usual-force", "10") != tuned(capsys, *numbers, "--usual-force", "5")


@pytest.mark.parametrize("limits, said, force", [("{u_min_N: -12, u_max_N: 20}", None, 5.0), ("{u_min_N: -30, u_max_N: 20}", None, 7.5), ("{u_max_N: 4}", None, 1.0), ("{u_max_N: 4}", 3, 3.0)])
def test_the_usual_force_is_the_librarys(limits, said, force):
    loop = ruamel.yaml.YAML(typ="safe").load(f"limits: {limits}") | ({"compensator": {"usual_force_N": said}} if said else {})
    assert tuning.rig_of(loop)["usual-force"] == force


def test_a_pole_too_fast_for_a_tick_is_left_out(capsys, tmp_path):
    """As import and synthesize write the sensor of a plant of three poles."""
    fastest = tuned(capsys, "--sensor-pole", "1e8", "--actuator-pole", "1e9")
    assert fastest["feedforward"]["sensor_pole_rad_per_s"] == fastest["feedforward"]["actuator_pole_rad_per_s"] == pytest.approx(10 * 3.14159265e3, rel=1e-5)
    assert fastest == tuned(capsys, "--sensor-pole", "31415.927", "--actuator-pole", "31415.927")
    assert tuned(capsys, "--sensor-pole", "1e8", "--sample-time", "1e-6")["feedforward"]["sensor_pole_rad_per_s"] == 1e6
    path = tmp_path / "loop.yaml"
    path.write_text(LOOP.replace("BREAKAWAY", "{offset_N: 0.07}").replace("noise_N: 0.02", "noise_N: 0.02, pole_rad_per_s: 100000000"))
    assert tuned(capsys, str(path))["feedforward"]["sensor_pole_rad_per_s"] == pytest.approx(15708, rel=1e-4)


def test_what_q31_cannot_hold_is_not_printed(capsys, tmp_path):
    wide = tuned(capsys, "--full-scale", "1000")["feedforward"]
    assert wide["presliding_N"] == pytest.approx(0.101) and wide["forgetting_per_N"] == pytest.approx(0.031)
    path = tmp_path / "loop.yaml"
    path.write_text("limits: {full_scale_N: 1000}\n")
    assert tuned(capsys, str(path))["feedforward"] == wide != tuned(capsys)["feedforward"] == tuned(capsys, "--full-scale", "2")["feedforward"]
    assert main(["tune", "--full-scale", "-1"]) == 2 and "--full-scale: -1, allowed are 1e-06" in capsys.readouterr().err


def test_an_invalid_loop_is_refused(tmp_path, capsys):
    path = tmp_path / "loop.yaml"
    for text, what in (("- 1", "must be keys and values"), ("sample_time_s: soon", ":1: sample_time_s: 'soon' is not a number"), ("a: [", "not YAML"), ("a: !!int zz", "not YAML"),
                       ("a: 2001-99-99", "not YAML"), ("[" * 5000, "nested too deeply"), ("a: 1\na: 2", ":2: a: is given twice"),
                       ("compensator: {friction: {breakaway: {table: [1]}}}", ":1: compensator.friction.breakaway.table[0]"), ("name: paper\nsample_time_s: 0.001", ":1: unknown key name"),
                       ("compensator: {friction: {breakaway: {table: [{force_N: 1, positive_N: [1]}]}}}", "table[0].positive_N: a number is expected here, not a list"),
                       ("limits: {u_min_N: -.inf}", ":1: limits.u_min_N: '-.inf' is not a finite number"), ("plant: 5", ":1: plant: a mapping is expected"),
                       ("description: x", "has no key of a rig: compensator.friction.breakaway.offset_N"),
                       ("compensator: {friction: {breakaway: {table: [{force_N: 1, positive_N: 1}, {force_N: 1, positive_N: 1}]}}}", "table[0].negative_N: is missing"),
                       ("compensator: {friction: {breakaway: {table: [{force_N: 1, positive_N: 1, negative_N: 1}, {force_N: 1, positive_N: 1, negative_N: 1}]}}}", "rise")):
        path.write_text(text)
        assert main(["tune", str(path)]) == 2
        assert f"{path}" in (err := capsys.readouterr().err) and what in err
