"""examples/odrive/joint.py: a joint without a force sensor behind a fake drive on a virtual bus."""

import math
import struct
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


@pytest.fixture(autouse=True)
def _patience(monkeypatch):
    monkeypatch.setattr(sys.modules["force"], "PATIENCE_S", 5.0)  # of a machine that is busy


@pytest.fixture(name="drive")
def _drive(request):
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


def test_a_start_moves_nothing(drive):
    drive.hinge.angle = 3.3
    follow(drive, joint.friction(), references()[:500])
    drive.finish()
    assert drive.seen[0] == drive.seen[1] == 3.3
    assert max(abs(q - 3.3 - asked) for q, asked in zip(drive.seen, references())) < 0.05


def test_the_term_goes_where_the_motor_turns_the_other_way(request):
    drive = fake.FakeJoint(request.node.name, joint.PERIOD_S, sign=-1)
    term = tribo.Joint(sample_time_s=joint.PERIOD_S, effort_max=1.0, travel=4 / joint.COUNTS, breakaway=0.15)
    follow(drive, term, references()[:1000])
    drive.close()
    report = term.report()
    assert report.cause != "sound" and report.share == 0
    assert (drive.state, drive.torque) == (IDLE, 0)


def test_the_torque_goes_while_the_encoder_reports_nan_and_comes_back(request):
    class Blind(fake.FakeJoint):
        """It reports NaN for the second from tick 3000 on."""

        torques = []

        def move(self, torque):
            self.torques.append(torque)
            super().move(torque)

        def sense(self):
            position = math.nan if 3000 <= len(self.seen) < 3500 else self.hinge.reading
            if self.state == 8:
                self.send(fake.NODE << 5 | 0x09, struct.pack("<ff", position, self.hinge.speed))

    drive = Blind(request.node.name, joint.PERIOD_S)
    follow(drive, joint.friction(), references()[:6000])
    drive.close()
    sent = [abs(torque) for torque in drive.torques]
    assert all(map(math.isfinite, sent))
    assert max(sent[3050:3500]) < 1e-6  # 0.1 s later
    assert max(sent[4500:]) > 0.05


def test_a_fault_of_the_drive_ends_the_loop(drive):
    drive.at[10] = lambda: drive.fail(0x1000)
    with pytest.raises(RuntimeError, match="0x1000"):
        follow(drive, joint.friction(), references()[:100])
    assert len(drive.seen) == 10
