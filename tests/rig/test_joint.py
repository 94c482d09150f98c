"""tribo-rig --joint on joints of a stranger: what is found, what is refused, and what is written. The long version is joints.py."""

import json
import subprocess
import sys
from dataclasses import replace

import joints
import numpy as np
import position_loop
import pytest
import ruamel.yaml as yaml

import tribo
from tribo_identify.refusal import Refusal
from tribo_rig import joint as way
from tribo_rig import slip

SEEDS = range(3001, 3013)  # three of each law


def rig(folder, *words):
    return subprocess.run([sys.executable, "-B", "-m", "tribo_rig", folder, *words], capture_output=True, text=True, check=False)


def test_friction_of_strange_joints_is_within_its_interval():
    pairs = {}
    for seed in SEEDS:
        for name, pair in joints.compared(*joints.found(seed)).items():
            pairs.setdefault(name, []).append(pair)
    assert len(pairs["friction"]) == len(SEEDS)
    for name, widest, least in (("friction", 0.02, 12), ("viscous", 0.03, 12), ("slope", 0.05, 2), ("breakaway", 0.15, 3)):
        error, half = np.abs(np.array(pairs[name])).T
        assert len(error) >= least, name
        assert np.sum(error > half) <= 1, (name, error, half)
        assert np.median(half) < widest, name


def test_a_fall_of_friction_is_told_where_the_logs_show_it():
    for seed in (3002, 3005, 3009):
        truth, found = joints.found(seed)
        slowest = np.min(np.abs(found.rows[0]))
        assert found.fall == pytest.approx(truth["peak"] * np.exp(-((slowest / truth["knee"]) ** 2)), rel=0.2)
        line = next(line for line in way.lines_of(found) if line.startswith("friction falls with speed"))
        assert f"{100 * found.fall:.2g} % larger at {slowest:.3g} units a second" in line


@pytest.mark.parametrize("fault, cause", [("units", "units"), ("sign", "sign"), ("oneway", "one direction"), ("none", "no stiction"), ("hand", "model"), ("saturated", "saturated"), ("exchanged", "exchanged"),
                                          ("coarse", "few loads"), ("late", "one direction"), ("still", "silent")])
def test_what_a_log_cannot_tell_is_refused_with_its_cause(fault, cause):
    for seed in (1, 17):
        _, refusal = joints.found(seed, fault)
        assert getattr(refusal, "cause", None) == cause, (seed, refusal)


@pytest.mark.parametrize("name", ["noisy position", "coarse effort", "large numbers", "late effort"])
def test_other_readings_of_the_same_joint_say_the_same(name, tmp_path):
    for seed in (5001, 5006):
        truth, random = joints.play(seed, tmp_path), np.random.default_rng(seed)
        change = {"noisy position": lambda s: {"q": s.q + truth["count"] * random.normal(size=len(s.q))}, "coarse effort": lambda s: {"u": np.round(s.u / truth["friction"] * 15) * truth["friction"] / 15},
                  "large numbers": lambda s: {"q": 1e4 * s.q + 1e5}, "late effort": lambda s: {"u": np.r_[np.full(3, s.u[0]), s.u[:-3]]}}[name]  # fmt: skip
        result = slip.identify([replace(s, **change(s)) for s in joints.logs_in(tmp_path)], 1.2 * truth["u_max"])
        error, half = joints.compared(truth, result)["friction"]
        assert abs(error) < half < 0.1, (seed, error, half)


def test_strokes_at_the_limit_of_effort_are_left_out(tmp_path):
    for seed in (1, 24):
        truth, result = joints.found(seed, "jumps")
        error, half = joints.compared(truth, result)["friction"]
        assert abs(error) < half < 0.02 and result.limited >= 10, (seed, error, half)
        assert f"left out: {result.limited} strokes in which the effort reaches effort_max" in way.lines_of(result)
    truth = joints.play(24, tmp_path, "jumps")
    with pytest.raises(Refusal, match="u reaches effort_max, 12.95, in 16 strokes.*Play smaller or slower steps") as refused:
        slip.identify([s for s in joints.logs_in(tmp_path) if "steps" in s.file], truth["u_max"])
    assert refused.value.cause == "saturated" and "steps with a second of rest after each, of a tenth of that range" in way.PLAY


@pytest.mark.parametrize("name, change", [("absolute", np.abs), ("never below", lambda u: np.maximum(u, 0)), ("never above", lambda u: np.minimum(u, 0))])
def test_an_effort_without_its_sign_is_refused(name, change, tmp_path):
    for seed in (1, 24):
        truth = joints.play(seed, tmp_path)
        with pytest.raises(Refusal, match="its sign was lost") as refused:
            slip.identify([replace(s, u=change(s.u)) for s in joints.logs_in(tmp_path)], truth["u_max"])
        assert refused.value.cause == "sign", name


def test_an_effort_of_one_sign_that_carries_a_load_is_read(tmp_path):
    truth = joints.play(24, tmp_path)
    for side in (1, -1):
        logs = [replace(s, u=s.u + 1.05 * side * np.max(np.abs(s.u))) for s in joints.logs_in(tmp_path)]
        assert all(np.all(side * s.u > 0) for s in logs)
        error, half = joints.compared(truth, slip.identify(logs, 3 * truth["u_max"]))["friction"]
        assert abs(error) < half < 0.02


def test_a_loop_that_rattles_is_named():
    for seed in (6023, 6051):
        assert joints.found(seed)[1].cause == "jumps"


def test_a_refusal_of_coarse_logs_names_what_is_needed():
    _, refusal = joints.found(1, "coarse")
    assert "the joint moves by 1.305" in str(refusal) and "4.39" in str(refusal)


@pytest.fixture(scope="module", name="made")
def _made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "arm"
    said = [rig(folder, "--joint")]
    (folder / "joint.yaml").write_text("sample_time_s: 2e-3\neffort_max: 13\n")
    said.append(rig(folder))
    truth = joints.play(24, folder)
    said.append(rig(folder))
    return folder, said, truth


def test_a_folder_goes_from_nothing_to_its_result(made):
    folder, (first, second, third), truth = made
    assert [one.returncode for one in made[1]] == [0, 0, 0], [one.stderr for one in made[1]]
    assert f"Wrote {folder / 'joint.yaml'}" in first.stdout and "Swing the joint" in second.stdout and "sine-log.csv" in second.stdout
    numbers = json.loads((folder / "result/verdict.json").read_text())
    assert abs(numbers["friction"]["value"] - truth["friction"]) < numbers["friction"]["half"] < 0.02 * truth["friction"]
    assert f"friction: {numbers['friction']['value']:.4g} +- " in third.stdout and "Wrote" in third.stdout
    assert (folder / "result/report.html").read_text().startswith("<!DOCTYPE html>")


@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
def test_the_result_compiles_and_has_the_bits_of_its_config(arithmetic, tmp_path):
    truth = joints.play(24, tmp_path)
    scale = round(1 / truth["count"])
    (tmp_path / "joint.yaml").write_text(f"sample_time_s: 2e-3\neffort_max: 13\nname: elbow\narithmetic: {arithmetic}\nlog: {{scales: {{q: {scale}}}}}\n")
    said = rig(tmp_path)
    assert said.returncode == 0, said.stderr
    result = tmp_path / "result"
    subprocess.run(["make", "--silent", f"TRIBO={joints.ROOT / 'lib'}", "CC=cc -Werror"], cwd=result, check=True)
    config = yaml.YAML(typ="safe").load((result / "config.yaml").read_text())
    joint = tribo.Joint(**config, arith=arithmetic)
    q = np.round(300 * np.sin(np.arange(4000) * 2e-3))
    effort = np.round(np.cos(np.arange(4000) * 2e-3), 4)
    rows = "".join(f"{u:.4f} {a + 4:.0f} {a:.0f}\n" for u, a in zip(effort, q))
    played = subprocess.run([result / "elbow"], input=rows, capture_output=True, text=True, check=True).stdout.split()
    assert np.allclose(np.array(played, float), joint.steps(effort, q + 4, q), atol=2e-6)
    assert np.ptp(joint.steps(0.5, q + 4, q)) > 0


def test_what_was_found_takes_friction_out_from_the_first_move(made):
    """With the found breakaway half of the friction is used before anything is learned; without it nothing."""
    folder, _, _ = made
    config = yaml.YAML(typ="safe").load((folder / "result/config.yaml").read_text())
    q = 500 * config["travel"] * np.sin(np.arange(500) * 2e-3)
    assert tribo.Joint(**config).steps(0.5, q, q)[400] == pytest.approx(0.5 + 0.8 * config["breakaway"] / 2, rel=0.05)


@pytest.mark.parametrize("text, words", [
    ("sample_time_s: 1e-3\neffort_max: 13\n", "a row every 0.002 s, but sample_time_s is 0.001 s"), ("sample_time_s: 2e-3\neffort_max: 0\n", "effort_max"),
    ("sample_time_s: 2e-3\n", "effort_max"), ("sample_time_s: 2e-3\neffort_max: 13\nbreakaway: 1\n", "breakaway"),
    ("sample_time_s: 2e-3\neffort_max: 13\nlog: {columns: {q: angle}}\n", "angle"), ("sample_time_s: 2e-3\neffort_max: 13\narithmetic: q31\n", "positions in counts")])  # fmt: skip
def test_a_bad_joint_yaml_says_what_is_wrong_and_writes_nothing(text, words, made, tmp_path):
    for path in made[0].glob("*-log.csv"):
        (tmp_path / path.name).symlink_to(path)
    (tmp_path / "joint.yaml").write_text(text)
    said = rig(tmp_path)
    assert said.returncode == 2 and words in said.stderr, said.stderr
    assert not (tmp_path / "result").exists()


def test_the_advice_for_q31_leads_on(made, tmp_path):
    for path in made[0].glob("*-log.csv"):
        (tmp_path / path.name).symlink_to(path)
    text = "sample_time_s: 2e-3\neffort_max: 13\narithmetic: q31\n"
    (tmp_path / "joint.yaml").write_text(text)
    advice = rig(tmp_path).stderr.split("log.scales: ")[1].split("}")[0] + "}"
    (tmp_path / "joint.yaml").write_text(text + f"log: {{scales: {advice}}}\n")
    said = rig(tmp_path)
    assert said.returncode == 0, said.stderr


def test_a_folder_of_a_force_axis_is_not_taken_for_a_joints(tmp_path):
    (tmp_path / "rig.yaml").write_text("")
    said = rig(tmp_path, "--joint")
    assert said.returncode == 2 and "belongs to a force axis" in said.stderr


def test_steps_between_two_positions_show_the_loop_and_a_sine_helps():
    """A fit of such steps alone finds gain and damping of the position loop: the friction was up to two hundred times too large, with an interval of a tenth."""
    alone, both = position_loop.judged(range(4001, 4021))
    assert list(alone.values()).count("loop") >= 4 and "exchanged" not in alone.values()
    assert len(position_loop.wrong(alone)) <= 1, position_loop.wrong(alone)
    assert sum(not isinstance(one, str) for one in both.values()) >= 4 and len(position_loop.wrong(both)) <= 1, both


def test_the_refusal_of_steps_says_what_to_record():
    rig = position_loop.rig_of(next(seed for seed, one in position_loop.judged(range(4001, 4010))[0].items() if one == "loop"))
    with pytest.raises(Refusal, match="Record a sine as well, and keep the steps"):
        slip.identify([position_loop.play(rig, "steps")], rig["u_max"])


def test_steps_to_many_positions_are_still_read_without_a_sine(tmp_path):
    for seed in (7001, 7008, 7010):
        truth = joints.play(seed, tmp_path)
        error, half = joints.compared(truth, slip.identify([s for s in joints.logs_in(tmp_path) if "steps" in s.file], 1.2 * truth["u_max"]))["friction"]
        assert abs(error) < half < 0.1, (seed, error, half)
