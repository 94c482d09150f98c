"""`tune`: the library's rule, printed as a scenario takes it."""

import pytest
import ruamel.yaml

from tribo_design.cli import main


def tuned(capsys, *arguments):
    assert main(["tune", *arguments]) == 0
    return ruamel.yaml.YAML(typ="safe").load(capsys.readouterr().out)["compensator"]


def test_the_papers_rig_has_the_defaults_of_the_library(capsys):
    found = tuned(capsys)
    assert found["method"] == "feedforward"
    assert (found["feedforward"]["reversal_N"], found["feedforward"]["jump_time_s"]) == (0.0005, 0.02)
    assert found["feedforward"]["learning"] == {"offset_sd_N": 0.01, "weight_N": 0.0002, "forgetting_per_N": 0.1}
    assert found["guard"] == {"on": "yes", "turn_N": 0.05, "quick_time_s": 0.2, "stray_N": 0.01, "fade_time_s": 0.5}


def test_noise_rig_and_tick_count(capsys):
    found = tuned(capsys, "--offset", "0.07", "--negative-offset", "0.21", "--input-max", "20", "--noise", "0.02", "--sample-time", "0.002",
                  "--actuator-pole", "100")
    assert found["feedforward"]["reversal_N"] == pytest.approx(1.64 / 314, rel=1e-5)  # mean L at 5 N is 1.64 N; over 314
    assert found["feedforward"]["slide_width_N"] == pytest.approx(0.06)
    assert found["feedforward"]["jump_time_s"] == 0.028
    assert found["guard"]["stray_N"] == 0.16


def test_what_cannot_be_is_refused_by_name(capsys):
    for arguments, exit_code, text in ((("--noise", "-1"), 2, "--noise: -1, allowed are 0"), (("--slope", "nan"), 2, "--slope: nan"),
                                       (("--sample-time", "1"), 1, "sample_time_s: 1e-6 to 0.1 s"), (("--stiffness", "1e9"), 1, "arm: ")):
        assert main(["tune", *arguments]) == exit_code
        assert text in capsys.readouterr().err
