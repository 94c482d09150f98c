"""examples/linuxcnc/joint.hal in halrun, in a thread of 1 kHz, behind LinuxCNC's own pid."""

import pytest

from conftest import EXAMPLES, error_of
from test_linuxcnc import WAIT, halrun, made, printed

HAL = (EXAMPLES / "linuxcnc" / "joint.hal").read_text()
FRICTION_N_M = 0.1  # ../sim/hinge.h
PINS = [f"getp tribo-joint.0.{pin}" for pin in ("output", "offset", "fault", "guard")]


@pytest.fixture(scope="module", name="modules")
def _modules(tmp_path_factory):
    return made(tmp_path_factory.mktemp("modules"), "pid")


def log_of(modules, folder, *commands):
    """Rows of command, truth, torque and friction."""
    halrun(modules, folder, HAL + "\n".join((*commands, "loadusr -w halsampler -n 12000 log")) + "\n")
    lines = (folder / "log").read_text().splitlines()
    assert "overrun" not in lines
    return [tuple(map(float, line.split())) for line in lines]


def test_the_joint_follows_against_friction(modules, tmp_path):
    rows = log_of(modules, tmp_path)
    (tmp_path / "plain").mkdir()
    plain = log_of(modules, tmp_path / "plain", "setp tribo-joint.0.friction-gain 0")
    assert len(rows) == len(plain) == 12000
    assert rows[-1][3] == pytest.approx(FRICTION_N_M, rel=0.1)
    assert error_of(plain) > 2.5 * error_of(rows)


def test_the_output_goes_with_enable(modules, tmp_path):
    out = printed(halrun(modules, tmp_path, HAL + "\n".join((
        "loadusr -w sleep 6", *PINS, "setp tribo-joint.0.enable 0", WAIT, *PINS, "setp tribo-joint.0.enable 1", WAIT, *PINS)) + "\n"))
    outputs, offsets, faults, guards = (out[i::4] for i in range(4))
    assert [float(output) != 0 for output in outputs] == [True, False, True]
    assert [float(offset) != 0 for offset in offsets] == [True, False, True]
    assert (faults, guards) == (["FALSE"] * 3, ["0"] * 3)


def test_a_lower_limit_holds_at_once(modules, tmp_path):
    out = printed(halrun(modules, tmp_path, HAL + "\n".join((
        WAIT, "setp tribo-joint.0.effort-limit 0.01", "loadusr -w sleep 2", *("getp tribo-joint.0.output", "loadusr -w sleep 0.3") * 5)) + "\n"))
    assert 0 < max(abs(float(output)) for output in out) <= 0.0100001


def test_nothing_is_learned_while_the_amplifier_is_off(modules, tmp_path):
    """Meanwhile a hand swings the joint against the loop, whose torque reaches no motor."""
    out = printed(halrun(modules, tmp_path, HAL.replace("=> sim-joint.0.torque", "").replace("start\n", "net loop-torque => sim-joint.0.torque\nstart\n") +
                         "\n".join(("setp tribo-joint.0.enable 0", "getp tribo-joint.0.learned", "loadusr -w sleep 6", "getp tribo-joint.0.learned")) + "\n"))
    assert float(out[-2]) == float(out[-1]) == 0


def test_output_and_offset_go_without_readings(modules, tmp_path):
    out = printed(halrun(modules, tmp_path, HAL + "\n".join((
        "loadusr -w sleep 6", *PINS, *(f"{verb} tribo-joint.0.{pin}{value}" for pin in ("feedback", "effort") for verb, value in (
            ("unlinkp", ""), ("setp", " nan"))), WAIT, *PINS)) + "\n"))
    assert [float(x) == 0 for x in (*out[:2], *out[4:6])] == [False, False, True, True]


def test_the_term_goes_where_the_motors_phases_are_exchanged(modules, tmp_path):
    out = printed(halrun(modules, tmp_path, HAL + "\n".join((
        "loadusr -w sleep 6", *PINS, "setp sim-joint.0.exchanged 1", WAIT, WAIT, *PINS, "unlinkp tribo-joint.0.command",
        "unlinkp tribo-joint.0.feedback", "setp tribo-joint.0.enable 0", WAIT, *PINS, "setp tribo-joint.0.enable 1", WAIT, *PINS)) + "\n"))
    offsets, guards = out[1::4], out[3::4]
    assert guards[0] == "0" and guards[1] in ("1", "2", "3") and guards[2:] == [guards[1], "0"]
    assert float(offsets[1]) == pytest.approx(0, abs=1e-9)


def test_parameters_that_are_refused_are_a_fault(modules, tmp_path):
    text = halrun(modules, tmp_path, HAL.replace("setp tribo-joint.0.least-motion 0.0879\n", "") + "\n".join((WAIT, *PINS)) + "\n")
    assert "travel" in text
    assert printed(text)[-4:-1] == ["0", "0", "TRUE"]
