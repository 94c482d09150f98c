"""tribo-identify: against truths that are known, and against logs that cannot tell. The long versions are in study.py."""

import csv
import os
import re
import shlex
import subprocess

import numpy as np
import pytest
import synthetic
from ruamel.yaml import YAML
from synthetic import L_of

from tribo_design.errors import InputError
from tribo_identify import cli, events, friction, native, slides
from tribo_identify.events import Refusal
from tribo_identify.plan import Plan

FORCE = np.linspace(0.1, 0.6, 11)
ROOT = synthetic.ROOT


@pytest.fixture(scope="module")
def experiment():
    """A rig's truth, the rows of its planned experiment, and what is found in it."""
    truth, rows = synthetic.sound(1)
    return truth, rows, friction.identify(synthetic.log_of(rows))


def found(result):
    return {e.name: e for e in result.estimates}


def test_the_librarys_own_code_is_the_model(experiment):
    # An independent way through the same code: tribo-sim's plant with the paper's friction, noise left out.
    truth, rows, result = experiment
    error = rows[:, 2] - result.model[0]
    assert np.std(events.binned(error, 20)) < 0.3e-3


@pytest.mark.parametrize("name, part", [("offset", 0.03), ("slope", 0.005), ("scale", 0.002), ("k_min", 0.03)])
def test_parameters_are_found_within_and_beside_their_intervals(experiment, name, part):
    truth, _, result = experiment
    estimate = found(result)[name]
    assert estimate.verdict == "identified"
    assert abs(estimate.value / truth[name] - 1) < part
    assert 0 < estimate.half < 2 * part * truth[name]


def test_bias_of_the_command_comes_out_as_gravity(experiment):
    truth, _, result = experiment
    assert found(result)["gravity"].value == pytest.approx(truth["bias"], abs=3e-4)


def test_L_is_within_three_percent_over_the_loads(experiment):
    truth, _, result = experiment
    L = result.params["offset_positive"] + result.params["slope_positive"] * FORCE
    assert np.max(np.abs(L / L_of(truth, FORCE) - 1)) < 0.03


def test_what_the_log_does_not_show_is_reported_with_the_experiment_for_it(experiment):
    by_name = found(experiment[2])
    assert by_name["m"].verdict == "not identifiable"
    for name in ("k_max", "v0", "m"):
        assert by_name[name].verdict != "identified" and "plan --hysteresis" in by_name[name].remark


def test_k_min_and_k_max_are_found_where_they_are_planned_for():
    # k_min 3.3 lets the friction of slow slides look like another L and scale.
    truth, rows = synthetic.sound(0, hysteresis=True)
    by_name = found(friction.identify(synthetic.log_of(rows)))
    for name in ("k_min", "k_max"):
        assert by_name[name].verdict == "identified"
        assert by_name[name].value == pytest.approx(truth[name], rel=0.05)
    assert by_name["slope"].value == pytest.approx(truth["slope"], rel=0.01)


def test_the_model_follows_ramps_inside_stiction_within_the_noise():
    # In float32 n would move by a few units in the last place, and F be 4 mN off.
    truth, rows = synthetic.sound(3, hysteresis=True)
    params = {**native.PAPER, **{n: truth[n] for n in ("k_min", "k_max", "m", "v0", "scale", "delay")}, "gravity": truth["bias"]}
    params |= {f"{n}_{way}": truth[n] for n in ("offset", "slope") for way in ("positive", "negative")}
    u, force = (np.ascontiguousarray(rows[:, i]) for i in (1, 2))
    error = events.binned(force - native.simulate(params, u, 1e-3, float(np.mean(force[:20])), 10), 20)
    assert np.sqrt(np.mean(error**2)) < 0.2e-3


def test_breakaway_is_found_where_little_of_it_is_sharp():
    # k_min 3.0: a step of 0.5 ms in the model is enough for another way of the relays.
    truth, rows = synthetic.sound(178)
    result = friction.identify(synthetic.log_of(rows))
    L = result.params["offset_positive"] + result.params["slope_positive"] * FORCE
    assert np.max(np.abs(L / L_of(truth, FORCE) - 1)) < 0.01


def test_each_event_is_where_the_force_begins_to_move(experiment):
    truth, rows, result = experiment
    assert len(result.events) >= 16
    ways = [e.way for e in result.events]
    assert ways.count(1) >= 8 and ways.count(-1) >= 8
    u_true = truth["scale"] * rows[:, 1] + truth["bias"]
    for e in result.events[1:]:
        share = e.way * (u_true[e.start] - e.force) / L_of(truth, e.force)
        assert 0.2 < share < 1.6  # creeps from 0.3 L on, and u goes on while F leaves the noise
        assert e.way * (rows[min(e.start + 400, len(rows) - 1), 2] - e.force) > 0


@pytest.mark.parametrize("flaw", synthetic.FLAWS)
@pytest.mark.parametrize("seed", [0, 1])
def test_a_flaw_is_refused_or_answered_rightly(flaw, seed):
    truth, rows = synthetic.flawed(flaw, seed)
    try:
        result = friction.identify(synthetic.log_of(rows))
    except Refusal as refusal:
        if flaw in ("one direction", "silent", "saturated", "few loads"):
            assert refusal.cause == flaw
        return
    assert flaw == "ripple" or flaw == "few loads"  # of the others none is answered
    L = result.params["offset_positive"] + result.params["slope_positive"] * FORCE
    weak = any(e.verdict != "identified" for e in result.estimates if e.name in ("offset", "slope", "scale"))
    assert weak or np.max(np.abs(L / L_of(truth, FORCE) - 1)) < 0.1


@pytest.mark.parametrize("held_s", [0.1, 0.5])
def test_a_command_that_is_logged_more_slowly_than_force_is_named(experiment, held_s):
    rows = experiment[1].copy()
    rows[:, 1] = np.repeat(rows[:: round(1e3 * held_s), 1], round(1e3 * held_s))[: len(rows)]
    with pytest.raises(Refusal, match=f"^held: u changes only every {held_s:g} s"):
        friction.identify(synthetic.log_of(rows))


def test_steps_of_a_resolution_are_no_hold():
    t = np.arange(0, 8, 1e-3)
    u = np.interp(t, [0, 4, 8], [0, 2, 0])
    assert events.held_s(synthetic.log_of(np.c_[t, np.round(u, 2), u])) == 0
    for turn_s in (4, 0.5, 2):
        u = np.interp(t, [0, turn_s, 8], [0, 2, 0])
        assert events.held_s(synthetic.log_of(np.c_[t, u, u])) == 0
    assert events.held_s(synthetic.log_of(np.c_[t, np.repeat(u[::50], 50), u])) == pytest.approx(0.05)


def test_stamps_of_two_clocks_are_named(experiment):
    rows = experiment[1].copy()
    rows[:, 1] = np.interp(rows[:, 0] - 0.05, rows[:, 0], rows[:, 1])
    with pytest.raises(Refusal, match="^clock: F comes -.* s after u, before it was commanded; "):
        friction.identify(synthetic.log_of(rows))


@pytest.mark.parametrize("held_s", [0.1, 0.5])
def test_a_command_that_the_drive_holds_is_as_good(held_s, tmp_path):
    """The drive makes the steps that the log has, and F shows them."""
    truth, commands = synthetic.truth_of(1), synthetic.plan_over(0.1, 0.6, noise=0.001).commands()
    time, each = commands[:, 0], round(100 * held_s)
    u = np.repeat(commands[::each, 1], each)[: len(time)]
    rows = [(t, x) for a, b, x in zip(time, [*time[1:], time[-1] + 0.01], u) for t, x in ((a, x), (b - 1e-4, x))]
    (tmp_path / "held.csv").write_text("t_s,r_N\n" + "".join(f"{t:.5f},{x:.6g}\n" for t, x in rows), encoding="ascii")
    (tmp_path / "held.yaml").write_text(f"duration_s: {time[-1]:.2f}\nsample_time_s: 0.001\nreference: {{kind: csv, file: held.csv}}\ncontroller: {{kind: none}}\n"
                                        "compensator: {method: off}\nlimits: {u_min_N: -5, u_max_N: 5, input_max_N: 5}\n", encoding="ascii")
    synthetic.play(tmp_path, tmp_path / "held.yaml", synthetic.settings(truth))
    result = friction.identify(synthetic.log_of(synthetic.trace(tmp_path)))
    assert found(result)["slope"].value == pytest.approx(truth["slope"], rel=0.01)
    assert f"u changes only every {held_s:g} s: if the drive's command changes in between, log it as often as F" in result.remarks


def test_a_wrong_sign_is_named(experiment):
    _, rows, _ = experiment
    for column in (1, 2):
        wrong = rows.copy()
        wrong[:, column] *= -1
        with pytest.raises(Refusal, match="sign"):
            friction.identify(synthetic.log_of(wrong))


def test_different_directions_are_distinguished_when_u_is_calibrated():
    truth = {**synthetic.truth_of(5), "scale": 1.0, "bias": 0.0}
    import tempfile
    from pathlib import Path

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sets = synthetic.settings(truth)
        sets[0] = ("plant.friction={k_min: 6, k_max: 20, breakaway: {offset_N: 0.01, slope: 0.25, negative_offset_N: 0.005, negative_slope: 0.35}}")
        synthetic.play(folder, synthetic.write_plan(folder, synthetic.plan_over(0.1, 0.6, noise=0.001)), sets)
        result = friction.identify(synthetic.log_of(synthetic.trace(folder)), assume="calibrated")
    assert not result.table
    plus, minus = (result.params[f"offset_{d}"] + result.params[f"slope_{d}"] * FORCE for d in ("positive", "negative"))
    assert plus == pytest.approx(0.01 + 0.25 * FORCE, rel=0.03)
    assert minus == pytest.approx(0.005 + 0.35 * FORCE, rel=0.03)


def test_breakaway_that_bends_needs_the_table():
    truth = {**synthetic.truth_of(2), "scale": 1.0, "bias": 0.0, "k_min": 6.0, "k_max": 20.0}
    import tempfile
    from pathlib import Path

    points = [(0.05, 0.05), (0.2, 0.06), (0.35, 0.08), (0.5, 0.2), (0.65, 0.22)]
    table = ", ".join(f"{{force_N: {f}, positive_N: {L}, negative_N: {L}}}" for f, L in points)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sets = synthetic.settings(truth)
        sets[0] = f"plant.friction={{breakaway: {{table: [{table}]}}}}"
        synthetic.play(folder, synthetic.write_plan(folder, synthetic.plan_over(0.1, 0.6, levels=6, noise=0.001)), sets)
        result = friction.identify(synthetic.log_of(synthetic.trace(folder)), assume="calibrated")
    assert len(result.table) >= 4
    at, plus, _ = np.array(result.table).T
    force = np.linspace(0.15, 0.55, 9)
    assert np.interp(force, at, plus) == pytest.approx(np.interp(force, *zip(*points)), rel=0.35)
    assert any("a line does not fit breakaway" in r for r in result.remarks)


def identify(capsys, *arguments):
    status = cli.main([str(a) for a in arguments])
    told = capsys.readouterr()
    return status, told.out, told.err


def seal(name):
    files = [ROOT / f"tests/identify/data/{name}_{bar}bar.tsv" for bar in (1, 3, 5, 7)]
    return [*files, "--column", "t=#1", "--unit", "t=ms", "--column", "u=#3", "--column", "x=#2", "--unit", "x=mm", "--resample", "--gap", "0.5"]


def test_measured_o_ring_is_as_an_independent_fit_has_it(capsys):
    status, out, _ = identify(capsys, "friction", *seal("O-ring"))
    assert status == 0
    words = out.split("offset ")[1].split()
    assert float(words[0]) == pytest.approx(4.83, abs=0.1) and float(words[2]) == pytest.approx(0.46, abs=0.15)
    words = out.split("slope ")[1].split()
    assert float(words[0]) == pytest.approx(0.0173, abs=5e-4) and float(words[2]) == pytest.approx(0.0020, abs=7e-4)
    loads = [float(line.split("load ")[1].split()[0]) for line in out.splitlines() if "load " in line and "friction" in line][:4]
    friction_n = [float(line.split("friction ")[1].split()[0]) for line in out.splitlines() if "pairs of strokes" in line]
    assert loads == pytest.approx([49, 149, 248, 346], abs=1.5)
    assert friction_n == pytest.approx([5.64, 7.52, 9.04, 10.86], abs=0.05)


def test_measured_x_ring_needs_the_table(capsys, tmp_path):
    status, out, _ = identify(capsys, "friction", *seal("X-ring257"), "--out", tmp_path / "out")
    assert status == 0 and "a line does not fit: " in out and "a table of 4 loads" in out
    text = (tmp_path / "out/friction.yaml").read_text(encoding="utf-8")
    assert text.count("force_N") == 4
    log = tmp_path / "log.csv"
    log.write_text("t_s,u_N\n0,0\n0.001,0\n", encoding="ascii")
    native.run_tribo_sim("replay", log, "--params", tmp_path / "out/friction.yaml", "--out", tmp_path / "replayed.csv")


def test_measured_kdn_shows_no_slope(capsys):
    status, out, _ = identify(capsys, "friction", *seal("KDN"))
    assert status == 0 and "slope: weak" in out and "a line does not fit" not in out


def strokes(path, load, pairs):
    """Strokes of 10 mm at 10 mm/s against a load: friction 2 N + 0.05 |load|, and 10 mN of noise."""
    t = np.arange(0, 2 * pairs, 0.001)
    way = np.where(t % 2 < 1, 1, -1)
    x = np.where(way > 0, t % 1, 1 - t % 1) * 10
    u = load + way * (2 + 0.05 * abs(load)) + np.random.default_rng(int(abs(load))).normal(0, 0.01, len(t))
    path.write_text("t_s,u_N,x_deg\n" + "".join(f"{a:.3f},{b:.5f},{c:.4f}\n" for a, b, c in zip(t, u, x)), encoding="ascii")
    return path


def test_friction_of_strokes_grows_with_the_loads_size(tmp_path, capsys):
    """A load from the other side has a negative sign, and the same friction."""
    logs = [strokes(tmp_path / f"{load}.csv", load, 3) for load in (-80, -40, 20, 60)]
    status, out, err = identify(capsys, "friction", *logs, "--out", tmp_path / "out")
    assert status == 0, err
    assert float(out.split("offset ")[1].split()[0]) == pytest.approx(2, abs=0.05)
    assert float(out.split("slope ")[1].split()[0]) == pytest.approx(0.05, abs=0.002)


@pytest.mark.parametrize("changes_s", [0.0, 0.6])
@pytest.mark.parametrize("role", ["x_deg", "w_deg_per_s"])
def test_successive_loads_are_distinguished_in_one_log(role, changes_s, tmp_path, capsys):
    """As strokes() makes them, three pairs a load; the load changes at a turn, or in the middle of a stroke. Of the speed alone, too, in rad/s."""
    t = np.arange(0, 24, 0.001)
    way, load = np.where(t % 2 < 1, 1, -1), np.array([20, 60, 40, 80])[np.minimum(t + 6 - changes_s, 29.9).astype(int) // 6 - 1]
    u = load + way * (2 + 0.05 * load) + np.random.default_rng(1).normal(0, 0.01, len(t))
    at = np.where(way > 0, t % 1, 1 - t % 1) * 10 if role == "x_deg" else way * 10 * np.pi / 180
    (tmp_path / "log.csv").write_text(f"t_s,u_N,{role}\n" + "".join(f"{a:.3f},{b:.5f},{c:.9g}\n" for a, b, c in zip(t, u, at)), encoding="ascii")
    status, out, err = identify(capsys, "friction", tmp_path / "log.csv", *(["--unit", "v=rad/s"] if role != "x_deg" else []), "--out", tmp_path / "out")
    assert status == 0, err
    assert [float(line.split("load ")[1].split()[0]) for line in out.splitlines() if "pairs of strokes" in line] == pytest.approx([20, 40, 60, 80], abs=0.05)
    assert float(out.split("offset ")[1].split()[0]) == pytest.approx(2, abs=0.05)
    assert float(out.split("slope ")[1].split()[0]) == pytest.approx(0.05, abs=0.002)


@pytest.mark.parametrize("pairs", [1, 2, 3])
@pytest.mark.parametrize("step_n, base_n", [(10.0, 2.0), (1.0, 2.0), (2.5, 12.0)])
def test_nine_loads_in_turn_are_nine(pairs, step_n, base_n, tmp_path, capsys):
    """As a gear motor lifts one weight after another: of one pair of strokes each, and of loads that are closer than half of the friction."""
    t = np.arange(0, 2 * pairs * 9, 0.002)
    way, load = np.where(t % 2 < 1, 1, -1), 20 + step_n * np.minimum(t // (2 * pairs), 8)
    u = load + way * (base_n + 0.05 * load) + np.random.default_rng(1).normal(0, 0.02, len(t))
    x = np.where(way > 0, t % 1, 1 - t % 1) * 10
    (tmp_path / "log.csv").write_text("t_s,u_N,x_deg\n" + "".join(f"{a:.3f},{b:.5f},{c:.4f}\n" for a, b, c in zip(t, u, x)), encoding="ascii")
    status, out, err = identify(capsys, "friction", tmp_path / "log.csv", "--out", tmp_path / "out")
    assert status == 0, err
    loads = [float(line.split("load ")[1].split()[0]) for line in out.splitlines() if "of strokes" in line]
    assert loads == pytest.approx([20 + step_n * k for k in range(9)], abs=0.1)


def test_one_pair_of_strokes_has_no_standard_error(tmp_path, capsys):
    status, out, err = identify(capsys, "friction", *[strokes(tmp_path / f"{load}.csv", load, 1) for load in (20, 40, 60, 80)])
    assert status == 0, err
    assert out.count("1 pair of strokes, no standard error") == 4 and "standard error 0" not in out


def test_strokes_at_three_loads_are_refused(capsys):
    arguments = seal("O-ring")
    status, _, err = identify(capsys, "friction", *arguments[1:])
    assert status == 3 and err.startswith("tribo-identify: few loads: 3; at least four are needed")


@pytest.fixture
def log(experiment, tmp_path):
    return synthetic.write_log(tmp_path, experiment[1])


def test_the_result_is_what_tribo_sim_and_the_drive_take(experiment, log, tmp_path, capsys):
    status, out, _ = identify(capsys, "friction", log, "--out", tmp_path / "out", "--scenario", ROOT / "host_sim/scenarios/triangle.yaml", "--arith", "q31")
    assert status == 0
    assert sorted(os.listdir(tmp_path / "out")) == ["friction.yaml", "loop.yaml", "loop_params.h", "report.html"]
    native.run_tribo_sim("replay", log, "--params", tmp_path / "out/friction.yaml", "--out", tmp_path / "replayed.csv")
    native.run_tribo_sim("run", tmp_path / "out/loop.yaml", "--set", "duration_s=1", "--set", "metrics.start_s=0")
    tree = YAML(typ="safe").load((tmp_path / "out/loop.yaml").read_text(encoding="utf-8"))
    assert tree["plant"]["friction"] == tree["compensator"]["friction"]  # the plant is the log's, too
    header = tmp_path / "out/loop_params.h"
    program = tmp_path / "main.c"
    program.write_text('#include "loop_params.h"\nint main(void) { return loop_params.input_max == 0; }\n', encoding="ascii")
    subprocess.run(["cc", "-std=c11", "-Wall", "-Werror", "-I", ROOT / "lib/include", "-I", tmp_path / "out", "-fsyntax-only", program], check=True)
    assert header.read_text(encoding="ascii").count("loop.yaml") == 1
    page = (tmp_path / "out/report.html").read_text(encoding="utf-8")
    assert page.count("<img src=\"data:image/png;base64,") >= 3 and "http" not in page
    for line in out.splitlines()[:5]:
        assert line.split("  ")[0] in page
    assert not list((ROOT / "host_sim/scenarios").glob(".*"))


def test_the_plant_of_the_loop_is_that_of_the_log(experiment, log, tmp_path, capsys):
    base = tmp_path / "base.yaml"
    base.write_text("duration_s: 1\nreference: {kind: triangle}\nplant: {model: karnopp, karnopp: {sliding_ratio: 0.7}, ripple: {amplitude_N: 0.1}, arm: {stiffness_N_per_deg: 4}}\n"
                    "sensor: {noise_N: 0.001}\n", encoding="ascii")
    status, _, err = identify(capsys, "friction", log, "--out", tmp_path / "out", "--scenario", base, "--actuator", 210, "--sensor", 54)
    assert status == 0, err
    tree = YAML(typ="safe").load((tmp_path / "out/loop.yaml").read_text(encoding="utf-8"))
    assert tree["plant"] == {"arm": {"stiffness_N_per_deg": 4}, "friction": tree["compensator"]["friction"], "actuator_pole_rad_per_s": 210}
    assert tree["sensor"] == {"noise_N": 0.001, "pole_rad_per_s": 54}


def test_a_refusal_writes_nothing(log, tmp_path, capsys):
    rows = log.read_text(encoding="ascii").splitlines()
    log.write_text("\n".join(rows[:1] + [f"{r.rsplit(',', 1)[0]},0.3" for r in rows[1:]]) + "\n", encoding="ascii")
    status, out, err = identify(capsys, "friction", log, "--out", tmp_path / "out")
    assert status == 3 and out == "" and "silent" in err
    assert not (tmp_path / "out").exists()


BAD = {
    "no file": (["friction", "none.csv"], "none.csv: cannot be opened"),
    "no column": (["friction", "LOG", "--column", "F=force"], "no column is named force"),
    "unit": (["friction", "LOG", "--unit", "u=lbf"], "--unit u=lbf: units are s, ms"),
    "actuator": (["friction", "LOG", "--actuator", "-1"], "--actuator: value -1: must be 0 or"),
    "lag": (["friction", "LOG", "--lag", "nan"], "--lag: value nan: must be"),
    "scenario": (["friction", "LOG", "--scenario", "none.yaml", "--out", "OUT"], "none.yaml: cannot be read: No such file or directory"),
    "levels": (["plan", "--low", "0.1", "--high", "0.6", "--levels", "3", "--out", "OUT"], "--levels: value 3: must be 4 to 32"),
    "range": (["plan", "--low", "0.6", "--high", "0.1", "--out", "OUT"], "--high: value 0.1: must be above --low"),
    "repeats": (["plan", "--low", "0.1", "--high", "0.6", "--repeats", "1", "--out", "OUT"], "--repeats: value 1: must be 2 to 100"),
    "limit": (["plan", "--low", "0.1", "--high", "0.6", "--u-max", "0.5", "--out", "OUT"], "--u-max: value 0.5:"),
    "NaN": (["plan", "--low", "nan", "--high", "0.6", "--out", "OUT"], "--low: value nan: must be finite"),
    "infinite": (["plan", "--low", "0.1", "--high", "0.6", "--u-max", "1e400", "--out", "OUT"], "--u-max: value 1e400: must be finite"),
    "subnormal": (["plan", "--low=-2e-41", "--high", "0.6", "--out", "OUT"], "--low: value -2e-41: is too small for a number: 0, or at least 1.2e-38 in size"),
    "subnormal lag": (["friction", "LOG", "--lag", "1e-41"], "--lag: value 1e-41: is too small for a number"),
    "subnormal force": (["accept", "none.yaml", "--low", "1e-41", "--out", "OUT"], "--low: value 1e-41: is too small for a number"),
    "noise": (["plan", "--low", "0.1", "--high", "0.6", "--noise", "0.1", "--out", "OUT"], "--noise: value 0.1:"),
}


@pytest.mark.parametrize("out", ["-pl", "it's", "my plan"])
def test_a_shell_hands_the_planned_run_to_tribo_sim(out, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["plan", "--low", "0.1", "--high", "0.6", f"--out={out}"]) == 0
    words = shlex.split(capsys.readouterr().out.partition("run it without compensation: ")[2].partition(", or")[0])
    assert words == ["tribo-sim", "run", f"./{out}/plan.yaml" if out[0] == "-" else f"{out}/plan.yaml", "--out", "DIR"]
    assert (tmp_path / words[2]).exists()


@pytest.mark.parametrize("command", [[], ["plan"], ["friction"], ["actuator"], ["accept"]])
def test_every_command_says_what_it_does(command, capsys):
    with pytest.raises(SystemExit) as ended:
        cli.main([*command, "--help"])
    assert ended.value.code == 0 and "options:" in capsys.readouterr().out


@pytest.mark.parametrize("text", ["a: [1, 2\nb: {c", "a: 1\n\tb: 2\n"])
def test_invalid_yaml_is_reported_with_its_line(text, log, tmp_path, capsys):
    (tmp_path / "bad.yaml").write_text(text, encoding="ascii")
    status, _, err = identify(capsys, "friction", log, "--scenario", tmp_path / "bad.yaml")
    assert status == 2 and "bad.yaml:2: not YAML: " in err


@pytest.mark.parametrize("case", BAD)
def test_a_mistake_is_named(case, log, tmp_path, capsys):
    arguments, message = BAD[case]
    places = {"LOG": str(log), "OUT": str(tmp_path / "plan")}
    status, _, err = identify(capsys, *(places.get(a, a) for a in arguments))
    assert status == 2 and err.startswith("tribo-identify: ") and message in err
    assert not (tmp_path / "plan").exists()


def test_the_command_that_plays_a_plan_is_one_for_a_shell(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    status, out, _ = identify(capsys, "plan", "--low", "0.1", "--high", "0.6", "--out", "my plan")
    words = shlex.split(out.splitlines()[1].partition("compensation: ")[2].partition(" --out")[0])
    assert status == 0 and words == ["tribo-sim", "run", "my plan/plan.yaml"] and (tmp_path / words[2]).exists()


def test_a_plan_is_played_by_tribo_sim_and_stays_in_its_limits(tmp_path, capsys):
    status, out, _ = identify(capsys, "plan", "--low", "-0.05", "--high", "0.9", "--noise", "0.001", "--u-max", "1.2", "--out", tmp_path / "plan")
    assert status == 0 and "4 loads; F goes from 0.05 to 0.627 N with the guessed friction, u from -0.05 to 0.9 N" in out
    with open(tmp_path / "plan/plan.csv", encoding="ascii") as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["t_s", "r_N"]
    native.run_tribo_sim("run", tmp_path / "plan/plan.yaml", "--out", tmp_path / "run")
    trace = np.genfromtxt(tmp_path / "run/trace.csv", delimiter=",", names=True)
    assert trace["limited"].sum() == 0
    both, count = events.loads(slides.spans(synthetic.log_of(np.c_[trace["t_s"], trace["u_N"], trace["F_N"]])))
    assert count >= 4 and both[0][0] < 0.2 and both[-1][1] > 0.55
    # Without noise F rests at its largest in stiction, which is no limit; a sensor that is cut off is one.
    log = synthetic.log_of(np.c_[trace["t_s"], trace["u_N"], trace["y_N"]])
    assert not events.saturated(log.segments[0]).any()
    turned = synthetic.log_of(np.c_[trace["t_s"], -trace["u_N"], trace["y_N"]])
    with pytest.raises(Refusal, match="wrong sign"):
        friction.identify(turned)
    log.segments[0].force = np.minimum(log.segments[0].force, 0.5)
    with pytest.raises(Refusal, match="saturated"):
        events.check(log)


@pytest.mark.parametrize("friction", ["{offset_N: 0.007, slope: 0.3}", "{offset_N: 0.002, slope: 0.02}", "{offset_N: 0.02, slope: 0.5}"])
@pytest.mark.parametrize("limits", [(0.0, 0.9), (-0.6, 0.6), (-0.9, -0.1)])
def test_no_force_of_a_plan_exceeds_the_limit(limits, friction, tmp_path):
    plan = Plan(*limits).check()
    u = plan.commands()[:, 1]
    assert limits[0] <= u[2 * len(u) // 10 :].min() < u.max() <= max(limits[1], 0.0)
    synthetic.play(tmp_path, synthetic.write_plan(tmp_path, plan), [f"plant.friction={{breakaway: {friction}}}"])
    _, u, y = synthetic.trace(tmp_path).T
    for x in (u, y):
        assert x.max() <= max(limits[1], 0.0) + 1e-9 and x.min() >= min(limits[0], 0.0) - 1e-9
    assert np.ptp(y) > 0.25 * (limits[1] - limits[0])


def test_a_second_run_replaces_its_own_output_only(tmp_path, capsys):
    arguments = ["plan", "--low", "0.1", "--high", "0.6", "--out", tmp_path / "plan"]
    assert identify(capsys, *arguments)[0] == 0
    assert identify(capsys, *arguments)[0] == 0
    (tmp_path / "plan/mine.txt").write_text("", encoding="ascii")
    status, _, err = identify(capsys, *arguments)
    assert status == 2 and "has other files in it" in err


def test_intervals_are_of_repeats_not_of_samples(experiment):
    # Every sample of every half-cycle twice tells nothing new; half of the half-cycles tell less.
    truth, rows, _ = experiment
    log = synthetic.log_of(rows)
    fit = friction.Fit(log, events.find(log)[0], {"k_min": truth["k_min"]}, "symmetric")
    fit.level = L_of(truth, 0.3)
    fit.step(friction.FINE_S)
    names = list(friction.SYMMETRIC)
    _, residual = fit.solve(names, [truth["offset"], truth["slope"], truth["scale"], truth["bias"]], 1)
    once, sums = fit.bootstrap(names, residual), fit.sums
    fit.sums = lambda r: tuple(2 * x for x in sums(r))
    assert fit.bootstrap(names, residual) == pytest.approx(once, rel=1e-6, abs=1e-12)
    fit.sums = lambda r: tuple(x * (np.arange(fit.count) % 2 == 0).reshape(-1, *[1] * (x.ndim - 1)) for x in sums(r))
    assert np.std(fit.bootstrap(names, residual)[:, 1]) > 1.2 * np.std(once[:, 1])


def test_on_line_and_off_line_agree_on_the_same_log(tmp_path):
    program = os.environ.get("TRIBO_LEARNING")
    if not program:
        pytest.skip("TRIBO_LEARNING is not set: the program of test_learning_alone.c")
    path = tmp_path / "log.csv"
    told = subprocess.run([program], env={**os.environ, "TRIBO_LEARNING_LOG": str(path)}, capture_output=True, text=True, check=True).stdout
    line = told.splitlines()[0]
    on_line = [float(line.split(f"{name} ")[1].split()[0].rstrip(",")) for name in ("L+", "L-")]
    from tribo_identify import logs

    result = friction.identify(logs.read([path]))
    off_line = (result.params["offset_positive"] + 0.5 * result.params["slope_positive"]) / 0.157
    # Off line scale and bias of u are fitted as well; of the sum of both directions neither assumes anything.
    scale = found(result)["scale"]
    assert np.mean(on_line) == pytest.approx(off_line / scale.value, abs=0.01 + result.L_half + scale.half)


def test_a_servos_friction_is_found_under_the_assumption_made():
    # MX-106 by its publication: L+ and L- differ, as friction grows with u + F. That looks like a scale of u, and nothing in u and F tells it from one.
    base, load = 0.007, 0.108
    truth, rows = synthetic.sound(0, model="servo_mx106")
    up, down = (base + 2 * load * FORCE) / (1 - load), (base + 2 * load * FORCE) / (1 + load)
    result = friction.identify(synthetic.log_of(rows))
    seen_as = 1 / (1 + 2 * load**2 / (1 - load**2))
    assert result.params["scale"] / truth["scale"] == pytest.approx(seen_as, abs=0.003)
    assert friction.breakaway(result.params, result.table, FORCE)[0] == pytest.approx(seen_as * (up + down) / 2, rel=0.04)
    assert abs(result.slide_gap[0]) < friction.GAP
    assert any("or friction is asymmetric and u is right" in r for r in result.remarks)
    rows[:, 1] = truth["scale"] * rows[:, 1] + truth["bias"]
    calibrated = friction.identify(synthetic.log_of(rows), assume="calibrated")
    for found_at, right in zip(friction.breakaway(calibrated.params, calibrated.table, FORCE), (up, down)):
        assert found_at == pytest.approx(right, rel=0.04)


def test_breakaway_above_sliding_makes_a_verdict_weak(experiment):
    assert abs(experiment[2].slide_gap[0]) < friction.GAP / 4
    _, rows = synthetic.sound(0, model="bliman_sorine")
    result = friction.identify(synthetic.log_of(rows))
    assert result.fall[0] == pytest.approx(0.1, abs=0.02)
    assert any("friction falls once it slides" in r for r in result.remarks)
    assert all(found(result)[name].verdict == "weak" for name in ("offset", "slope", "scale"))


@pytest.mark.parametrize("command", ["plan", "friction", "actuator", "accept"])
def test_no_option_takes_an_implausible_number(command, capsys):
    """NaN, infinite and subnormal ones, of each option that takes a number."""
    options = {"plan": ("low", "high", "rate", "offset", "slope", "noise", "u-max", "sample-time"), "friction": ("actuator", "sensor", "lag"), "actuator": ("stiffness",), "accept": ("low", "high")}[command]
    for name in options:
        for value in ("nan", "inf", "-inf", "1e400", "1e-41", "-2e-45"):
            status, _, err = identify(capsys, command, "none", f"--{name}={value}")
            assert status == 2 and f"--{name}: value {value}: " in err, err


def refused(values):
    try:
        Plan(**values).check()
    except InputError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("values", [{"low": 0.1, "high": 0.6, "rate": 1e-6}, {"low": -1e6, "high": 1e6, "rate": 1.0}, {"low": 0.1, "high": 0.6, "rate": 1e-3, "hysteresis": True},
                                    {"low": 0.1, "high": 0.6, "rate": 0.05, "levels": 32, "repeats": 100}])
def test_a_plan_that_lasts_longer_than_a_run_may_is_told_the_rate_that_would_do(values, monkeypatch):
    monkeypatch.setattr(Plan, "corners", lambda _: pytest.fail("makes the rows before it looks"))
    found = re.fullmatch(r"--rate: value \S+: must be at least (\S+) N/s: the experiment would take (\S+) s, and a run at most 86400 s; fewer --repeats or --levels shorten it, too", refused(values))
    assert found and float(found[2]) > 86400
    plan = Plan(**values | {"rate": float(found[1])}).check()
    monkeypatch.undo()
    assert 80_000 < plan.seconds() <= 86400
    assert Plan(0.1, 0.6, hysteresis=True).check().corners()[-1, 0] == pytest.approx(Plan(0.1, 0.6, hysteresis=True).check().seconds(), rel=1e-9)


@pytest.mark.parametrize("high", [1e6, 1e-7])
def test_no_plan_is_refused_for_a_rate_that_was_not_given(high):
    assert "--rate" not in refused({"low": 0.0, "high": high})


def test_levels_that_noise_hides_are_told_how_many_would_do():
    """And if none would, no number is told: of 15,242 such plans 10,804 were told that fewer would, and they did not."""
    source, told = np.random.default_rng(1), {True: 0, False: 0}
    for _ in range(3000):
        high = float(np.exp(source.uniform(np.log(0.1), np.log(500))))
        values = {"low": float(source.choice([0.15 * high, -high, 0.0])), "high": high, "noise": high * float(np.exp(source.uniform(-7, -1))), "offset": high * source.uniform(0.005, 0.1),
                  "slope": source.uniform(0, 0.4), "levels": int(source.integers(5, 33))}
        if "do not stand out" not in (text := refused(values)):
            continue
        fewer = re.search(r"; --levels (\d+) would$", text)
        assert bool(fewer) != (", nor do fewer: " in text), text
        told[bool(fewer)] += 1
        if fewer:
            assert not refused(values | {"levels": int(fewer[1])}), text
        else:
            assert all(refused(values | {"levels": levels}) for levels in range(4, values["levels"]))
    assert min(told.values()) > 100


@pytest.mark.parametrize("words, why", [
    (("--arith", "q31"), "--arith: is of loop_params.h, which needs --scenario"), (("--arith", "f32", "--out", "out"), "--arith: is of loop_params.h"),
    (("--scenario", "loop.yaml"), "--scenario: is for loop.yaml and loop_params.h, which need --out"),
    (("--assume", "symmetric"), "--assume: 80.csv has no force"), (("--actuator", "0"), "--actuator: 80.csv has no force"), (("--sensor", "60"), "--sensor: 80.csv has no force"),
    (("--lag", "0.01"), "--lag: 80.csv has no force"), (("--scenario", "loop.yaml", "--out", "out"), "--scenario: 80.csv has no force")])
def test_options_without_effect_are_refused(tmp_path, capsys, monkeypatch, words, why):
    monkeypatch.chdir(tmp_path)
    strokes(tmp_path / "80.csv", 80, 2)
    (tmp_path / "loop.yaml").write_text("duration_s: 1\n")
    status, out, err = identify(capsys, "friction", "80.csv", *words)
    assert (status, out) == (2, "") and err.splitlines()[-1].startswith(f"tribo-identify: {why}")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["80.csv", "loop.yaml"]


def test_a_scenario_in_a_folder_that_takes_no_files_is_found_before_the_work(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("tribo_identify.command_friction.logs.read", lambda *_: pytest.fail("the logs are read"))
    status, out, err = identify(capsys, "friction", "80.csv", "--scenario", "/proc/loop.yaml", "--out", tmp_path / "out")
    assert (status, out) == (2, "") and "/proc/.loop.identified.yaml: cannot be written: " in err and list(tmp_path.iterdir()) == []


def test_options_of_the_other_step_of_accept_are_refused(tmp_path, capsys):
    loop = ROOT / "host_sim/scenarios/triangle.yaml"
    for words, why in ((("--low", "0.1", "--high", "1", "--column", "u=x"), "--column: is how logs are read, and none is given"), (("--off", "a.csv", "--low", "0.1"), "--low: the logs have the range")):
        status, out, err = identify(capsys, "accept", loop, *words, "--out", tmp_path / "out")
        assert (status, out) == (2, "") and err.splitlines()[-1].startswith(f"tribo-identify: {why}") and list(tmp_path.iterdir()) == []
