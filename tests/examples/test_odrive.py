"""examples/odrive over python-can, against a fake drive on a virtual bus."""

import math
import threading

import can
import pytest
import tribo

from conftest import EXAMPLES, RMS_MAX_UN, load, rms_of

force, fake = load("odrive/force.py"), load("odrive/fake_odrive.py")
IDLE = 1


@pytest.fixture(name="loop")
def _loop():
    return tribo.Loop(EXAMPLES / "rig" / "rig_500hz.yaml")


@pytest.fixture(name="drive")
def _drive(loop, request, monkeypatch):
    monkeypatch.setattr(force, "PATIENCE_S", 5.0)  # of a machine that is busy
    drive = fake.FakeODrive(request.node.name, loop.sample_time_s)
    yield drive
    drive.close()


def hold(loop, drive, references):
    with can.Bus(interface="virtual", channel=drive.bus.channel_id) as bus:
        force.hold(bus, loop, references)


def test_the_loop_follows_against_friction(loop, drive):
    references = list(fake.triangle(loop.sample_time_s))
    hold(loop, drive, references)
    drive.finish()
    assert len(drive.forces) == len(references)
    assert rms_of(references, drive.forces) < RMS_MAX_UN
    assert loop.guard_cause == "none"
    assert (drive.state, drive.torque) == (IDLE, 0)


def test_a_fault_of_the_drive_ends_the_loop(loop, drive):
    drive.at[10] = lambda: drive.fail(0x1000)
    with pytest.raises(RuntimeError, match="0x1000"):
        hold(loop, drive, [0.5] * 100)
    assert len(drive.forces) == 10


def test_the_drive_lets_go_when_the_loop_hangs(loop, drive):
    def hang():
        assert drive.torque != 0
        drive.elapse(0.01)
        assert drive.state != IDLE
        drive.elapse(0.01)

    drive.at[10] = hang
    with pytest.raises(RuntimeError, match="0x1000000"):
        hold(loop, drive, [0.5] * 100)
    assert (len(drive.forces), drive.torque) == (10, 0)


@pytest.mark.parametrize("others", [False, True])
def test_the_axis_is_idle_without_its_sensor(loop, drive, monkeypatch, others):
    """`others`: another node's frames keep coming."""
    monkeypatch.setattr(force, "PATIENCE_S", 0.2)
    over = threading.Event()

    def chat():
        with can.Bus(interface="virtual", channel=drive.bus.channel_id) as bus:
            while not over.wait(0.05):
                bus.send(can.Message(arbitration_id=0x123, data=bytes(8), is_extended_id=False))

    def cut():
        drive.has_sensor = False

    drive.at[10] = cut
    chatter = threading.Thread(target=chat)
    if others:
        chatter.start()
    with pytest.raises(TimeoutError):
        hold(loop, drive, [0.5] * 100)
    over.set()
    if others:
        chatter.join()
    drive.finish()
    assert (len(drive.forces), drive.state) == (10, IDLE)


def break_sensor(drive):
    drive.arm.reading = math.nan


def test_the_axis_is_idle_after_20_bad_readings(loop, drive):
    drive.at[10] = lambda: break_sensor(drive)
    with pytest.raises(RuntimeError, match="20 bad readings"):
        hold(loop, drive, [0.5] * 510)
    drive.finish()
    assert (len(drive.forces), drive.state, drive.torque) == (30, IDLE, 0)


def test_the_loop_goes_on_after_19_bad_readings(loop, drive):
    def mend():
        drive.arm.reading = 0.5

    drive.at[10], drive.at[29] = lambda: break_sensor(drive), mend
    hold(loop, drive, [0.5] * 100)
    drive.finish()
    assert (len(drive.forces), loop.bad_inputs) == (100, 19)
