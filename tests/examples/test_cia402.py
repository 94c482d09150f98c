"""examples/cia402 by python's canopen, against a fake drive on a virtual bus."""

from itertools import islice

import canopen
import pytest

from conftest import error_of, load

joint, fake = load("cia402/joint.py"), load("cia402/fake_cia402.py")
TICKS = 6000
SWITCHED_OFF, FAULT = 0x40, 0x08


@pytest.fixture(autouse=True)
def _patience(monkeypatch):
    monkeypatch.setattr(joint, "PATIENCE_S", 5.0)  # of a machine that is busy


@pytest.fixture(name="drive")
def _drive(request):
    drive = fake.FakeDrive(request.node.name, joint.PERIOD_S, joint.COUNTS)
    yield drive
    drive.close()


def follow(drive, term, tmp_path, ticks=TICKS):
    eds = tmp_path / "drive.eds"
    eds.write_text(fake.eds())
    with canopen.Network() as network:
        network.connect(interface="virtual", channel=drive.bus.channel_id)
        joint.follow(network, str(eds), term, islice(joint.counts(), ticks))


def test_the_joint_follows_against_friction(drive, tmp_path, request):
    term = joint.friction()
    follow(drive, term, tmp_path)
    drive.finish()
    report = term.report()
    assert report.is_learned and report.cause == "sound"
    assert report.friction == pytest.approx(1000 * fake.Hinge.FRICTION / fake.RATED_N_M, rel=0.1)
    assert (drive.state, drive.torque) == (SWITCHED_OFF, 0)

    plain = fake.FakeDrive(request.node.name + "_plain", joint.PERIOD_S, joint.COUNTS)
    off = joint.friction()
    off.gain = 0.0
    follow(plain, off, tmp_path)
    plain.close()
    assert len(plain.seen) == len(drive.seen) >= TICKS
    assert not any(offset for *_, offset in plain.seen)
    assert error_of(plain.seen) > 2.5 * error_of(drive.seen)


def test_a_start_moves_nothing(drive, tmp_path):
    drive.hinge.angle, drive.objects[0x6064, 0] = 3.3, int(3.3 * joint.COUNTS)
    follow(drive, joint.friction(), tmp_path, 500)
    drive.finish()
    assert drive.seen[0][:2] == (pytest.approx(3.3, abs=1 / joint.COUNTS), 3.3)
    assert max(abs(q - q_ref) for q_ref, q, _ in drive.seen) < 0.05


def test_the_term_goes_where_the_torques_sign_is_wrong(request, tmp_path):
    drive = fake.FakeDrive(request.node.name, joint.PERIOD_S, joint.COUNTS, torque_sign=-1)
    term = joint.tribo.Joint(sample_time_s=joint.PERIOD_S, effort_max=10000, travel=4, breakaway=300)
    follow(drive, term, tmp_path)
    drive.close()
    assert term.report().cause.startswith("reversed")
    offsets = [abs(offset) for *_, offset in drive.seen]
    assert max(offsets) > 50 and not any(offsets[-TICKS // 2:])


def test_a_fault_of_the_drive_ends_the_loop(drive, tmp_path):
    drive.at[10] = lambda: drive.fail(0x7305)
    with pytest.raises(RuntimeError, match="error 0x7305"):
        follow(drive, joint.friction(), tmp_path, 100)
    assert (len(drive.seen), drive.torque) == (10, 0)


def test_the_drive_lets_go_when_the_loop_hangs(drive, tmp_path):
    def hang():
        assert drive.torque != 0
        drive.elapse(4.9)
        assert drive.state != FAULT
        drive.elapse(0.1)
        assert (drive.state, drive.torque) == (FAULT, 0)

    drive.at[500] = hang
    with pytest.raises(RuntimeError, match=f"error {fake.RPDO_TIMEOUT:#x}"):
        follow(drive, joint.friction(), tmp_path)
    assert len(drive.seen) == 500


def test_the_loop_ends_without_an_answer(drive, tmp_path, monkeypatch):
    monkeypatch.setattr(joint, "PATIENCE_S", 0.5)

    def cut():
        drive.deaf = True

    drive.at[10] = cut
    with pytest.raises((TimeoutError, canopen.SdoCommunicationError)):
        follow(drive, joint.friction(), tmp_path, 100)
    assert len(drive.seen) == 10
