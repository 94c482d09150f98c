"""The verdict of tribo-sim replay on the log of the plan, whose slides creep and lag."""

import numpy as np
import pytest
import synthetic

from tribo_identify import native


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    """t, u, y of the paper's plant, as the five commands of docs/identification.md make it."""
    folder = tmp_path_factory.mktemp("plan")
    synthetic.play(folder, synthetic.write_plan(folder, synthetic.plan_over(0.1, 0.6, noise=0.001, u_max=2)), [])
    return synthetic.trace(folder)


def replay(folder, rows, *options, force="measured", L=1.0, params=""):
    """The verdict's lines, bias, scale error and sliding."""
    log = synthetic.write_log(folder, rows)
    (folder / "p.yaml").write_text(params or f"friction:\n  breakaway: {{offset_N: {0.007 * L}, slope: {0.3 * L}}}\n")
    out, _ = native.run_tribo_sim("replay", log, "--params", folder / "p.yaml", "--force", force, "--out", folder / "out.csv", *options)
    words = [line[10:] for line in out.splitlines() if line.startswith("verdict")]
    numbers = [float(out.split(word)[1].split()[0].rstrip(",")) for word in ("bias ", "scale off by ", "sliding   at ")]
    return words, *numbers


@pytest.mark.parametrize("force", ["own", "measured"])
def test_true_params_fit(rows, tmp_path, force):
    words, bias, scale, sliding = replay(tmp_path, rows, force=force)
    assert words == ["the params fit this log"]
    assert abs(bias) < 1e-3 and abs(scale) < 0.5
    assert sliding == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("times", [0.6, 0.9, 1.1])
def test_a_wrong_scale_alone_is_named_with_its_factor(rows, tmp_path, times):
    words, *_ = replay(tmp_path, rows * [1, times, 1])
    assert len(words) == 1 and words[0].startswith("wrong scale")
    assert float(words[0].split("multiply u by ")[1].split()[0]) == pytest.approx(1 / times, rel=0.01)


def test_a_wrong_sign_is_named(rows, tmp_path):
    words, *_ = replay(tmp_path, rows * [1, -1, 1])
    assert len(words) == 1 and words[0].startswith("wrong sign")


@pytest.mark.parametrize("times", [1.5, 20])
def test_an_L_that_is_too_large_is_named(rows, tmp_path, times):
    words, *_ = replay(tmp_path, rows, L=times)
    assert len(words) == 1 and float(words[0].split("L is ")[1].split()[0]) == pytest.approx(times, rel=0.02)


def test_an_L_that_is_too_small_is_named(rows, tmp_path):
    words, *_ = replay(tmp_path, rows, L=0.5)
    assert len(words) == 1 and words[0].startswith("L is too small")
    assert float(words[0].split("slides at ")[1].split()[0]) == pytest.approx(2, rel=0.02)


def test_scale_and_L_are_told_apart(rows, tmp_path):
    words, bias, scale, sliding = replay(tmp_path, rows * [1, 0.85, 1] + [0, 0.02, 0], L=2)
    assert [w.split(":")[0].split(" is")[0] for w in words] == ["wrong scale", "L"]
    assert bias == pytest.approx(0.02, abs=1e-3) and scale == pytest.approx(-15, abs=0.5) and sliding == pytest.approx(0.5, abs=0.01)


def test_a_table_is_the_same_as_its_line(rows, tmp_path):
    table = "friction:\n  breakaway:\n    table:\n" + "".join(f"      - {{force_N: {F}, positive_N: {0.014 + 0.6 * F}, negative_N: {0.014 + 0.6 * F}}}\n" for F in (0.0, 0.5, 1.0))
    words, *numbers = replay(tmp_path, rows, params=table)
    line, *as_line = replay(tmp_path, rows, L=2)
    assert words == line and numbers == pytest.approx(as_line, abs=2e-3)


def test_a_log_that_begins_under_load(rows, tmp_path):
    assert replay(tmp_path, rows[15000:25000])[0] == ["the params fit this log"]


@pytest.mark.parametrize("seed", range(3))
def test_rigs_with_noise(tmp_path, seed):
    truth, rows = synthetic.sound(seed)
    rows = np.c_[rows[:, 0], truth["scale"] * rows[:, 1] + truth["bias"], rows[:, 2]]
    params = (f"friction: {{k_min: {truth['k_min']}, k_max: {truth['k_max']}, m: {truth['m']}, v0_N_per_s: {truth['v0']}, "
              f"breakaway: {{offset_N: {truth['offset']}, slope: {truth['slope']}}}}}\n")
    words, *_ = replay(tmp_path, rows, params=params)
    assert words == ["the params fit this log"]
    words, *_ = replay(tmp_path, rows * [1, 0.9, 1], params=params)
    assert words[0].startswith("wrong scale") and not any(w.startswith("L") for w in words)
