"""examples/moteus/joint.py over the real client, against a fake drive on a virtual bus."""

import asyncio
import math
from itertools import islice

import moteus
import pytest
import tribo

from conftest import error_of, load

joint, fake = load("moteus/joint.py"), load("moteus/fake_moteus.py")
TICKS = 6000
PATIENCE_S = 5.0


@pytest.fixture(name="drive")
def _drive(request):
    drive = fake.FakeJoint(request.node.name, joint.PERIOD_S, joint.COUNTS)
    yield drive
    drive.close()


async def no_pause():
    pass


def follow(drive, term, ticks=TICKS, patience_s=PATIENCE_S):
    async def run():
        async with moteus.PythonCan(interface="virtual", channel=drive.bus.channel_id) as transport:
            controller = moteus.Controller(id=1, query_resolution=joint.resolution(), transport=transport)
            await joint.follow(controller, term, islice(joint.swing(joint.PERIOD_S), ticks), no_pause, patience_s)

    asyncio.run(run())


def test_the_joint_follows_against_friction(drive, request):
    term = joint.friction()
    follow(drive, term)
    drive.finish()
    report = term.report()
    assert report.is_learned and report.cause == "sound" and report.friction == pytest.approx(fake.Hinge.FRICTION, rel=0.1)
    assert (drive.mode, drive.torque) == (moteus.Mode.STOPPED, 0)

    plain = fake.FakeJoint(request.node.name + "_plain", joint.PERIOD_S, joint.COUNTS)
    off = joint.friction()
    off.gain = 0.0
    follow(plain, off)
    plain.close()
    assert len(plain.seen) == len(drive.seen) == TICKS
    assert not any(feedforward for *_, feedforward in plain.seen)
    assert error_of(plain.seen) > 2.5 * error_of(drive.seen)


def test_a_start_moves_nothing(drive):
    drive.hinge.angle = 3.3
    follow(drive, joint.friction(), 500)
    drive.finish()
    assert drive.seen[0][:2] == (pytest.approx(3.3, abs=1 / joint.COUNTS), 3.3)
    assert max(abs(q - q_ref) for q_ref, q, _ in drive.seen) < 0.05


def test_the_term_goes_where_the_torques_sign_is_wrong(request):
    drive = fake.FakeJoint(request.node.name, joint.PERIOD_S, joint.COUNTS, torque_sign=-1)
    term = tribo.Joint(sample_time_s=joint.PERIOD_S, effort_max=10, travel=4 / joint.COUNTS, breakaway=0.15)
    follow(drive, term)
    drive.close()
    assert term.report().cause.startswith("reversed")
    sent = [abs(feedforward) for *_, feedforward in drive.seen]
    assert max(sent) > 0.05 and max(sent[-TICKS // 2:]) < 1e-9


@pytest.mark.parametrize("register", ["POSITION", "TORQUE"])
def test_the_term_goes_while_the_drive_reports_nan_and_comes_back(request, register):
    class Blind(fake.FakeJoint):
        """It reports NaN for the second from tick 3000 on."""

        def values(self):
            is_blind = 3000 <= len(self.seen) < 3500
            return super().values() | ({moteus.Register[register]: math.nan} if is_blind else {})

    drive = Blind(request.node.name, joint.PERIOD_S, joint.COUNTS)
    follow(drive, joint.friction())
    drive.close()
    sent = [abs(feedforward) for *_, feedforward in drive.seen]
    assert all(map(math.isfinite, sent))
    assert max(sent[2500:3000]) > 0.05 and max(sent[4500:]) > 0.05
    if register == "POSITION":
        assert max(sent[3050:3500]) < 1e-6  # 0.1 s later


def test_a_fault_of_the_drive_ends_the_loop(drive):
    drive.at[10] = lambda: drive.fail(33)
    with pytest.raises(moteus.FaultError) as error:
        follow(drive, joint.friction(), 100)
    assert str(error.value) == f"Fault mode={moteus.Mode.FAULT} code=33"
    assert len(drive.seen) == 10
    drive.finish()
    assert (drive.mode, drive.torque) == (moteus.Mode.STOPPED, 0)


def test_the_drive_lets_go_when_the_loop_hangs(drive):
    def hang():
        assert drive.torque != 0
        drive.elapse(joint.WATCHDOG_S)
        assert (drive.mode, drive.torque) == (moteus.Mode.TIMEOUT, 0)

    drive.at[500] = hang
    with pytest.raises(moteus.FaultError) as error:
        follow(drive, joint.friction())
    assert f"mode={moteus.Mode.TIMEOUT}" in str(error.value)
    assert len(drive.seen) == 500
