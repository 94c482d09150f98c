"""examples/servo/joint.py over ROBOTIS' own client, against a fake servo on a pty."""

from itertools import islice

import dynamixel_sdk.port_handler
import pytest
import tribo

from conftest import error_of, load

joint, fake = load("servo/joint.py"), load("servo/fake_servo.py")
N_M_PER_UNIT = 0.0045
TICKS = 3500


@pytest.fixture(name="servo")
def _servo(monkeypatch):
    monkeypatch.setattr(dynamixel_sdk.port_handler, "LATENCY_TIMER", 2000)  # ms; of a machine that is busy
    servos = []

    def made(**options):
        servos.append(fake.FakeJoint(joint.PERIOD_S, N_M_PER_UNIT, **options))
        return servos[-1]

    yield made
    for servo in servos:
        servo.close()


def follow(servo, term, ticks=TICKS, pause=lambda: None):
    port = joint.opened(servo.name)
    asked = list(islice(joint.counts(), ticks))
    try:
        joint.follow(joint.Joint(port), term, asked, pause)
    finally:
        port.ser.flush()
        port.closePort()
    return [(q_ref, q) for q_ref, (q, _) in zip(asked, servo.seen, strict=True)]


def test_the_joint_follows_against_friction(servo):
    term, off = joint.friction(), joint.friction()
    off.gain = 0.0
    with_term, without = follow(servo(), term), follow(servo(), off)
    report = term.report()
    assert report.is_learned and report.cause == "sound"
    assert report.friction == pytest.approx(fake.Hinge.FRICTION / N_M_PER_UNIT, rel=0.15)
    assert error_of(without) > 2.5 * error_of(with_term)


def test_a_start_moves_nothing(servo):
    one = servo()
    one.hinge.angle = 3.3
    rows = follow(one, joint.friction(), 250)
    assert rows[0][1] == rows[1][1] == 3.3 * joint.COUNTS
    assert max(abs(q - 3.3 * joint.COUNTS - asked) for asked, q in rows) < 0.05 * joint.COUNTS


def test_the_term_goes_where_the_encoders_sign_is_wrong(servo):
    one, term = servo(sign=-1), tribo.Joint(sample_time_s=joint.PERIOD_S, effort_max=joint.CURRENT_MAX, travel=4, breakaway=30)
    follow(one, term, 500)
    assert term.report().cause != "sound" and term.report().share == 0
    assert max(abs(units) for _, units in one.seen) <= joint.CURRENT_MAX


def test_a_fault_of_the_servo_ends_the_loop(servo):
    one = servo()
    one.at[10] = lambda: one.fail(0x20)
    with pytest.raises(RuntimeError, match="[Hh]ardware"):
        follow(one, joint.friction(), 100)
    assert (len(one.seen), one.units) == (10, 0)


def test_the_servo_lets_go_when_the_loop_hangs(servo):
    one = servo()

    def hang():
        if len(one.seen) == 100:
            assert one.units != 0
            one.elapse(0.02)
            assert one.units == 0

    with pytest.raises(RuntimeError):
        follow(one, joint.friction(), pause=hang)
    assert len(one.seen) == 100
