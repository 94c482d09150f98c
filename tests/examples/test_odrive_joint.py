"""examples/odrive/joint.py: a joint without a force sensor behind a fake drive on a virtual bus."""

import sys

import can
import pytest
import tribo

from conftest import error_of, load

joint, fake = load("odrive/joint.py"), load("odrive/fake_odrive.py")
IDLE = 1
SECONDS = 16


def references():
    return [q for q, _ in zip(joint.swing(joint.PERIOD_S), range(int(SECONDS / joint.PERIOD_S)))]


@pytest.fixture(name="drive")
def _drive(request, monkeypatch):
    monkeypatch.setattr(sys.modules["force"], "PATIENCE_S", 5.0)  # of a machine that is busy
    drive = fake.FakeJoint(request.node.name, joint.PERIOD_S)
    yield drive
    drive.close()


def follow(drive, term, asked):
    with can.Bus(interface="virtual", channel=drive.bus.channel_id) as bus:
        joint.follow(bus, term, asked)


def test_the_joint_follows_against_friction(drive, request):
    asked = references()
    term = joint.friction()
    follow(drive, term, asked)
    drive.finish()
    assert len(drive.seen) == len(asked)
    assert (drive.state, drive.torque) == (IDLE, 0)
    report = term.report()
    assert report.is_learned and report.cause == "sound" and report.friction == pytest.approx(fake.Hinge.FRICTION, rel=0.1)

    plain = fake.FakeJoint(request.node.name + "_plain", joint.PERIOD_S)
    off = joint.friction()
    off.gain = 0.0
    follow(plain, off, asked)
    plain.close()
    assert error_of(list(zip(asked, plain.seen))) > 2.5 * error_of(list(zip(asked, drive.seen)))


def test_the_term_goes_where_the_motor_turns_the_other_way(request):
    drive = fake.FakeJoint(request.node.name, joint.PERIOD_S, sign=-1)
    term = tribo.Joint(sample_time_s=joint.PERIOD_S, effort_max=1.0, travel=4 / joint.COUNTS, breakaway=0.15)
    follow(drive, term, references()[:1000])
    drive.close()
    report = term.report()
    assert report.cause != "sound" and report.share == 0
    assert (drive.state, drive.torque) == (IDLE, 0)


def test_a_fault_of_the_drive_ends_the_loop(drive):
    drive.at[10] = lambda: drive.fail(0x1000)
    with pytest.raises(RuntimeError, match="0x1000"):
        follow(drive, joint.friction(), references()[:100])
    assert len(drive.seen) == 10
