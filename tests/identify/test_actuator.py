"""tribo-identify actuator: the poles of a record, through the reader of logs and identify-plant's code."""

import numpy as np
import pytest
import scipy.signal
import synthetic
from test_friction import identify

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
