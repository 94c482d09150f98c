"""tribo-identify accept: new parameters are taken if the rig is as they say, and only then."""

import json

import pytest
from test_friction import identify  # the command line in this process

from tribo_identify import accept, native

LOOP = """duration_s: 10
reference: {kind: triangle}
compensator:
  method: feedforward
  friction:
    breakaway: {offset_N: OFFSET, slope: SLOPE}
"""


METHODS = {"feedforward": "feedforward", "paper": "paper\n  guard: {on: no}"}  # the paper's alone, as it hunts where L is wrong


@pytest.fixture
def rig(tmp_path, capsys):
    """Plays the sequence of a loop on a rig whose breakaway is `plant` times the paper's; what accept is given."""

    def play(believed, plant, method="feedforward"):
        loop = tmp_path / "loop.yaml"
        loop.write_text(LOOP.replace("OFFSET", f"{0.007 * believed:.6g}").replace("SLOPE", f"{0.3 * believed:.6g}").replace("feedforward", METHODS[method]), encoding="utf-8")
        status, _, err = identify(capsys, "accept", loop, "--low", 0.4, "--high", 0.6, "--out", tmp_path / "sequence")
        assert status == 0, err
        arguments = ["accept", loop, "--column", "F=y_N", "--out", tmp_path / "verdict"]
        for case in accept.CASES:
            native.run_tribo_sim("run", tmp_path / f"sequence/{case}.yaml", "--set", f"plant.friction.breakaway={{offset_N: {0.007 * plant}, slope: {0.3 * plant}}}",
                                 "--set", "sensor={noise_N: 0.0005, noise_seed: 4}", "--out", tmp_path / case)
            arguments += [f"--{case}", tmp_path / case / "trace.csv"]
        return arguments

    return play


def verdict(tmp_path):
    return json.loads((tmp_path / "verdict/verdict.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("method", ["feedforward", "paper"])
def test_parameters_of_the_rig_are_accepted(rig, tmp_path, capsys, method):
    status, out, _ = identify(capsys, *rig(1.0, 1.0, method))
    assert status == 0 and "ACCEPTED" in out and verdict(tmp_path)["accepted"]
    assert (tmp_path / "verdict/accepted.yaml").read_bytes() == (tmp_path / "loop.yaml").read_bytes()
    assert "<img src=\"data:image/png;base64," in (tmp_path / "verdict/report.html").read_text(encoding="utf-8")


def with_old(arguments, tmp_path, plant, old):
    """The arguments with the log of an old loop on the rig, whose breakaway is `old` times the paper's."""
    path = tmp_path / "old.yaml"
    path.write_text(LOOP.replace("OFFSET", f"{0.007 * old:.6g}").replace("SLOPE", f"{0.3 * old:.6g}"), encoding="utf-8")
    tree = accept.case_of(accept.load(path), "old", 0.4, 0.6)
    (tmp_path / "sequence/old.yaml").write_text(accept.yaml_text(tree), encoding="utf-8")
    native.run_tribo_sim("run", tmp_path / "sequence/old.yaml", "--set", f"plant.friction.breakaway={{offset_N: {0.007 * plant}, slope: {0.3 * plant}}}",
                         "--set", "sensor={noise_N: 0.0005, noise_seed: 4}", "--out", tmp_path / "old")
    return [*arguments, "--old", path, "--old-log", tmp_path / "old/trace.csv"]


@pytest.mark.parametrize("method, plant, named", [("paper", 0.5, ["u chatters with compensation on", "there is no margin"]), ("feedforward", 0.5, []),
                                                  ("feedforward", 1.6, [])])
def test_parameters_of_another_rig_are_rejected_and_the_old_stay(rig, tmp_path, capsys, method, plant, named):
    arguments = with_old(rig(1.0, plant, method), tmp_path, plant, 0.05)
    old = tmp_path / "old.yaml"
    status, out, err = identify(capsys, *arguments)
    assert status == 4 and "rejected" in err and "REJECTED" in out
    reasons = " ".join(verdict(tmp_path)["reasons"])
    assert all(reason in reasons for reason in named) and "the parameters are not this rig's" in reasons
    assert (tmp_path / "verdict/accepted.yaml").read_bytes() == old.read_bytes()


def test_new_parameters_that_are_no_better_than_the_old_are_rejected(rig, tmp_path, capsys):
    status, _, _ = identify(capsys, *with_old(rig(0.9, 1.0), tmp_path, 1.0, 1.0))
    assert status == 4 and "times that with the old parameters: the new ones do not help" in " ".join(verdict(tmp_path)["reasons"])
    assert (tmp_path / "verdict/accepted.yaml").read_bytes() == (tmp_path / "old.yaml").read_bytes()


def test_new_parameters_that_are_better_than_the_old_are_accepted(rig, tmp_path, capsys):
    status, out, _ = identify(capsys, *with_old(rig(1.0, 1.0), tmp_path, 1.0, 0.5))
    assert status == 0 and "error with the old parameters" in out
    assert (tmp_path / "verdict/accepted.yaml").read_bytes() == (tmp_path / "loop.yaml").read_bytes()


def test_without_old_parameters_a_rejection_names_none(rig, tmp_path, capsys):
    status, out, _ = identify(capsys, *rig(1.0, 0.5))
    assert status == 4 and "keep the old parameters" in out
    assert not (tmp_path / "verdict/accepted.yaml").exists()


def test_the_sequence_is_the_loop_with_its_breakaway_scaled(rig, tmp_path):
    rig(1.0, 1.0)
    trees = {case: accept.load(tmp_path / f"sequence/{case}.yaml") for case in accept.CASES}
    slopes = [trees[case]["compensator"]["friction"]["breakaway"]["slope"] for case in ("on", "less", "more")]
    assert slopes == pytest.approx([0.3, 0.24, 0.36])
    assert trees["off"]["compensator"]["method"] == "off" and trees["on"]["compensator"]["method"] == "feedforward"
    table = accept.scaled({"breakaway": {"table": [{"force_N": 0.1, "positive_N": 0.2, "negative_N": 0.3}]}}, 0.5)
    assert table["breakaway"]["table"] == [{"force_N": 0.1, "positive_N": 0.1, "negative_N": 0.15}]


def test_mistakes_are_named(rig, tmp_path, capsys):
    arguments = rig(1.0, 1.0)
    logs = {arguments[i][2:]: arguments[i + 1] for i in range(len(arguments)) if str(arguments[i])[2:] in accept.CASES}
    cut = [a for i, a in enumerate(arguments) if a != "--more" and arguments[i - 1] != "--more"]
    assert "--more: its log is missing: the rule needs all 4" in identify(capsys, *cut)[2]
    assert "--old-log: its log is missing: the rule needs all 5" in identify(capsys, *arguments, "--old", tmp_path / "loop.yaml")[2]
    assert "--old: must be given with --old-log" in identify(capsys, *arguments, "--old-log", logs["on"])[2]
    short = tmp_path / "short.csv"
    short.write_text("\n".join(logs["on"].read_text(encoding="ascii").splitlines()[:5000]) + "\n", encoding="ascii")
    status, _, err = identify(capsys, *[short if a == logs["on"] else a for a in arguments])
    assert status == 2 and "lasts 5 s, but the sequence takes 30 s" in err
    blind = tmp_path / "blind.csv"
    blind.write_text("t_s,u_N,y_N\n" + "".join(f"{t},0,{t}\n" for t in range(30)), encoding="ascii")
    status, _, err = identify(capsys, *[blind if a == logs["on"] else a for a in arguments])
    assert status == 2 and "needs columns of the reference and of the force" in err
    bare = tmp_path / "bare.yaml"
    bare.write_text("duration_s: 1\n", encoding="ascii")
    status, _, err = identify(capsys, "accept", bare, "--low", 0.1, "--high", 0.6, "--out", tmp_path / "x")
    assert status == 2 and "compensator.friction.breakaway: is missing" in err
    bare.write_text("duration_s: 1\nplant: {a: [\n", encoding="ascii")
    status, _, err = identify(capsys, "accept", bare, "--low", 0.1, "--high", 0.6, "--out", tmp_path / "x")
    assert status == 2 and "bare.yaml:3: not YAML: " in err
    status, _, err = identify(capsys, "accept", tmp_path / "loop.yaml", "--low", 0.6, "--high", 0.6, "--out", tmp_path / "x")
    assert status == 2 and "--high: value 0.6: must be above --low" in err
    assert not (tmp_path / "verdict").exists() and not (tmp_path / "x").exists()


@pytest.mark.parametrize("friction, said", [
    ("x", "friction: a mapping is expected"), ("[1]", "friction: a mapping is expected"), ("{breakaway: 5}", "breakaway: a mapping is expected"),
    ("{breakaway: {offset_N: x}}", "offset_N: 'x' is not a number"), ("{breakaway: {offset_N: 1e400}}", "offset_N: '1e400' is too large"), ("{breakaway: {offset_N: [1]}}", "offset_N: a number is expected here, not a list"),
    ("{breakaway: {table: [1]}}", "table[0]: a mapping is expected"), ("{breakaway: {table: [{force_N: 1}]}}", "table")])
@pytest.mark.parametrize("command", ["accept", "friction"])
def test_a_loop_that_the_simulator_refuses_is_refused_at_once(tmp_path, capsys, monkeypatch, command, friction, said):
    monkeypatch.setattr("tribo_identify.logs.read", lambda *_: pytest.fail("the logs are read"))
    loop = tmp_path / "loop.yaml"
    loop.write_text(f"duration_s: 1\nreference: {{kind: step}}\ncompensator:\n  friction: {friction}\n", encoding="ascii")
    words = [loop, "--low", 0.1, "--high", 0.6] if command == "accept" else ["log.csv", "--scenario", loop]
    status, out, err = identify(capsys, command, *words, "--out", tmp_path / "x")
    assert (status, out) == (2, "") and f"{loop}" in err and said in err and len(err.splitlines()) == 1, err
    assert not (tmp_path / "x").exists()


def test_a_quoted_number_of_a_loop_is_its_number(tmp_path, capsys):
    loop = tmp_path / "loop.yaml"
    loop.write_text(LOOP.replace("OFFSET", "'0.01'").replace("SLOPE", '"0.5"'), encoding="ascii")
    assert identify(capsys, "accept", loop, "--low", 0.1, "--high", 0.6, "--out", tmp_path / "x")[0] == 0
    assert accept.load(tmp_path / "x/less.yaml")["compensator"]["friction"]["breakaway"] == {"offset_N": 0.008, "slope": 0.4}


# As tribo-design writes it, far from the paper's rig: 2 ms, a slow actuator, an arm and a delay of its own.
DESIGNED = """duration_s: 60
sample_time_s: 0.002
reference: {kind: triangle, low_N: 1, high_N: 1.5, period_s: 20}
plant: {step_s: 0.0002, actuator_pole_rad_per_s: 12, arm: {inertia_N_s2_per_deg: 0.00038, damping_N_s_per_deg: 0.061, stiffness_N_per_deg: 3.84}}
sensor: {pole_rad_per_s: 100000000, delay_s: 0.002}
controller:
  kind: delta
  sections:
    - {b0: 2.10039663, b1: 0.653936446, b2: 0.0726709738, a1: 0.423257381, a2: 0.0726709738}
    - {b0: 1.59466267, b1: 1.63247762, b2: 0.0378149718, a1: 1.00003004, a2: 2.999955e-05}
compensator:
  method: feedforward
  feedforward: {actuator_pole_rad_per_s: 12, sensor_pole_rad_per_s: 15708, reversal_N: 0.000461783, presliding_N: 0.0131818, jump_time_s: 0.208359, forgetting_per_N: 0.108276}
  guard: {on: yes, turn_N: 0.0461783, quick_time_s: 1.5875, stray_N: 0.00923567, fade_time_s: 0.5}
  friction: {breakaway: {offset_N: 0.02, slope: 0.1}}
  arm: {inertia_N_s2_per_deg: 0.00038, damping_N_s_per_deg: 0.061, stiffness_N_per_deg: 3.84}
limits: {u_min_N: -7, u_max_N: 7, input_max_N: 5, full_scale_N: 7}
"""


@pytest.mark.parametrize("plant, status", [(1.0, 0), (0.75, 4), (1.25, 4)])
def test_a_designed_loop_of_another_rig_is_judged(tmp_path, capsys, plant, status):
    loop = tmp_path / "loop.yaml"
    loop.write_text(DESIGNED, encoding="utf-8")
    assert identify(capsys, "accept", loop, "--low", 1, "--high", 1.5, "--out", tmp_path / "sequence")[0] == 0
    arguments = ["accept", loop, "--column", "F=y_N", "--out", tmp_path / "verdict"]
    for case in accept.CASES:
        native.run_tribo_sim("run", tmp_path / f"sequence/{case}.yaml", "--set", f"plant.friction.breakaway={{offset_N: {0.02 * plant}, slope: {0.1 * plant}}}",
                             "--set", "sensor.noise_N=0.001", "--out", tmp_path / case)
        arguments += [f"--{case}", tmp_path / case / "trace.csv"]
    assert identify(capsys, *arguments)[0] == status
