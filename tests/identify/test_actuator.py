"""tribo-identify actuator: the poles of a record, through the reader of logs and identify-plant's code."""

import numpy as np
import pytest
import scipy.signal
import scipy.stats
import synthetic
from test_friction import identify

from tribo_design import identify as plant
from tribo_identify import native

INERTIA, DAMPING, STIFFNESS = 1.2e-4, 0.0288, 3.84


@pytest.fixture
def record(tmp_path):
    """Steps of two heights both ways, of the paper's arm between two poles, without friction, by scipy."""
    t = np.arange(4000) * 5e-4
    u = np.select([t < 0.1, t < 0.6, t < 1.1, t < 1.6], [0.0, 0.1, 0.3, 0.1], 0.0)
    system = ([200.0 * 55.0 * STIFFNESS], np.polymul(np.polymul([1, 200.0], [1, 55.0]), [INERTIA, DAMPING, STIFFNESS]))
    _, y, _ = scipy.signal.lsim(system, u, t, interp=False)
    y += 1e-5 * np.random.default_rng(1).normal(size=len(y))
    np.savetxt(tmp_path / "log.csv", np.c_[1e3 * t, u, y], delimiter=";", header="time;torque;force", comments="", fmt="%.9g")
    return [tmp_path / "log.csv", "--column", "t=time", "--unit", "t=ms", "--column", "u=torque", "--column", "F=force"]


def test_arm_and_poles_are_found(record, tmp_path, capsys):
    status, out, err = identify(capsys, "actuator", *record, "--no-friction", "--order", 4, "--out", tmp_path / "out")
    assert status == 0, err
    arm = out.split("arm: ")[1]
    assert float(arm.split("I ")[1].split()[0]) == pytest.approx(INERTIA, rel=0.05)
    assert float(arm.split("b ")[1].split()[0]) == pytest.approx(DAMPING, rel=0.05)
    poles = [float(p) for p in out.split("real poles ")[1].split(" rad/s")[0].split(",")]
    assert poles == pytest.approx([55, 200], rel=0.05)
    assert "plant:" in (tmp_path / "out/plant.yaml").read_text(encoding="utf-8")


def test_what_cannot_be_identified_is_refused(record, tmp_path, capsys):
    assert identify(capsys, "actuator", *record, "--stiffness", 0)[2].startswith("tribo-identify: --stiffness: value 0:")
    assert identify(capsys, "actuator", *record, "--order", 7)[2].startswith("tribo-identify: --order: value 7:")
    still = synthetic.write_log(tmp_path, np.c_[np.arange(100) * 1e-3, np.arange(100) > 50, np.zeros(100)], "still.csv")
    assert identify(capsys, "actuator", still)[2].startswith("tribo-identify: still.csv: F does not move")


def recorded(tmp_path, t, u, y):
    np.savetxt(tmp_path / "log.csv", np.c_[t, u, y + 1e-5 * np.random.default_rng(1).normal(size=len(y))], delimiter=",", header="t_s,u_N,F_N", comments="", fmt="%.9g")
    return tmp_path / "log.csv"


def test_a_chirp_within_stiction_shows_actuator_and_sensor(tmp_path, capsys):
    t = np.arange(4000) * 5e-4
    u = 0.1 * scipy.signal.chirp(t, 0.5, 2.0, 20.0, phi=-90)
    _, y, _ = scipy.signal.lsim(([200.0 * 55.0], np.polymul([1, 200.0], [1, 55.0])), u, t, interp=False)
    status, out, err = identify(capsys, "actuator", recorded(tmp_path, t, u, y), "--no-friction")
    assert status == 0, err
    assert [float(p) for p in out.split("real poles ")[1].split(" rad/s")[0].split(",")] == pytest.approx([55, 200], rel=0.01)


def test_steps_beyond_stiction_show_the_gain_and_say_that_the_poles_have_no_interval(tmp_path, capsys):
    # Breakaway of 0.05 N, by the library: each step lets the arm slide, and it sticks at the end.
    t = np.arange(6000) * 5e-4
    u = np.select([t < 0.1, t < 0.6, t < 1.1, t < 1.6, t < 2.1, t < 2.6], [0.0, 0.2, 0.5, 0.3, 0.0, 0.3], 0.5)
    params = {**native.PAPER, "k_min": 500.0, "k_max": 500.0, "inertia": 1e-6, "damping": 0.0768}
    params |= {f"{what}_{way}": x for way in ("positive", "negative") for what, x in (("offset", 0.05), ("slope", 0.0))}
    y = 0.8 * native.simulate(params, u, 5e-4, 0.0, 10)
    status, out, err = identify(capsys, "actuator", recorded(tmp_path, t, u, y), "--order", 3)
    assert status == 0, err
    gain = next(line for line in out.splitlines() if line.startswith("gain")).replace("+-", " ").split()
    assert float(gain[1]) == pytest.approx(0.8, rel=2e-3)
    assert "the poles are a description without intervals" in out


CHIRPS = [(damping, real) for damping in (0.05, 0.1, 0.2, 0.35, 0.5, 0.7) for real in (False, True)]


def chirp(case):
    """t, u, y, the pole of the pair and the real pole, if any, of a chirp through an arm."""
    damping, has_real = CHIRPS[case]
    source = np.random.default_rng(case)
    size, real = source.uniform(20, 120), source.uniform(40, 300)
    t = np.arange(2000) * 1e-3
    u = 0.1 * scipy.signal.chirp(t, 0.5, 2.0, 20.0, phi=-90)
    pair = [1, 2 * damping * size, size**2]
    system = ([size**2 * real], np.polymul(pair, [1, real])) if has_real else ([size**2], pair)
    _, y, _ = scipy.signal.lsim(system, u, t, interp=False)
    y += [1e-5, 1e-4][case % 4 // 2] * source.normal(size=len(y))
    return t, u - u[0], y, size * complex(-damping, np.sqrt(1 - damping**2)), real if has_real else None


def covers(pole, size, widened):
    found = np.hypot(pole["re"], pole["im"])
    return (pole["size_low"] / found) ** widened < size / found < (pole["size_high"] / found) ** widened


@pytest.mark.parametrize("case", range(len(CHIRPS)))
def test_a_chirp_shows_a_complex_pair_with_u_rounded_or_not(case):
    # Of some fifty intervals of 95 % a few miss: each, widened to 99.9 %, must not.
    widened = scipy.stats.norm.ppf(0.9995) / scipy.stats.norm.ppf(0.975)
    t, u, y, pole, real = chirp(case)
    answers = []
    for signal in (u, np.array([float(f"{x:.9g}") for x in u])):
        found = plant.identify(plant.Data(t, signal, y), None, True)[0]
        assert found["trusted"] and found["order"] == 2 + (real is not None), found["remarks"]
        assert abs(found["gain"] - 1) < widened * found["gain_half_width"] < 1e-3
        (pair,) = (p for p in found["poles"] if p["im"] > 0)
        assert pair["identifiable"] and covers(pair, abs(pole), widened) and pair["size_high"] < 1.01 * pair["size_low"]
        assert abs(pair["re"] - pole.real) < widened * pair["part_half_width"] < 0.03 * abs(pole)
        for p in found["poles"]:
            if not p["im"]:
                assert p["identifiable"] and covers(p, real, widened) and p["size_high"] < 1.1 * p["size_low"]
        answers.append([found["gain"], pair["re"], pair["im"]])
    assert answers[0] == pytest.approx(answers[1], rel=1e-4)


@pytest.mark.parametrize("case", [0, 3, 8])
def test_a_chirp_with_the_order_given(case):
    t, u, y, pole, real = chirp(case)
    right = plant.identify(plant.Data(t, u, y), 3 if real else 2, True)[0]
    assert right["trusted"] and any(covers(p, abs(pole), 1.0) for p in right["poles"] if p["im"])
    wrong = plant.identify(plant.Data(t, u, y), 1, True)[0]
    assert not wrong["trusted"] and any("the residual is not noise" in r or "integrator" in r for r in wrong["remarks"])
