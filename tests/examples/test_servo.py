"""examples/servo over ROBOTIS' own client, against a fake servo on a pty."""

import time

import dynamixel_sdk.port_handler
import pytest
import tribo

from conftest import EXAMPLES, load, rms_of

force, fake = load("servo/force.py"), load("servo/fake_servo.py")
RMS_MAX_UN = 500  # a count of the sensor is 1,000, a unit of current 4,500; without compensation 10,200


@pytest.fixture(name="loop")
def _loop():
    return tribo.Loop(EXAMPLES / "rig" / "rig_250hz.yaml")


@pytest.fixture(name="drive")
def _drive(loop, monkeypatch):
    monkeypatch.setattr(dynamixel_sdk.port_handler, "LATENCY_TIMER", 2000)  # ms; of a machine that is busy
    drive = fake.FakeServo(loop.sample_time_s, force.N_M_PER_UNIT, force.OFFSET, force.N_M_PER_COUNT)
    yield drive
    drive.close()


def hold(loop, drive, references, pause=lambda: None):
    port = force.opened(drive.name)
    try:
        force.hold(force.Servo(port), loop, references, pause)
    finally:
        port.ser.flush()
        port.closePort()


def test_the_loop_follows_against_friction(loop, drive):
    references = list(fake.triangle(loop.sample_time_s))
    hold(loop, drive, references)
    assert len(drive.forces) == len(references)
    assert rms_of(references, drive.forces) < RMS_MAX_UN
    assert loop.guard_cause == "none"


def test_a_fault_of_the_servo_ends_the_loop(loop, drive):
    drive.at[10] = lambda: drive.fail(0x20)
    with pytest.raises(RuntimeError, match="[Hh]ardware"):
        hold(loop, drive, [0.5] * 100)
    assert (len(drive.forces), drive.units) == (10, 0)


def test_the_servo_lets_go_when_the_loop_hangs(loop, drive):
    def hang():
        if len(drive.forces) == 10:
            assert drive.units != 0
            drive.elapse(0.02)
            assert drive.units == 0

    with pytest.raises(RuntimeError):
        hold(loop, drive, [0.5] * 100, hang)
    assert len(drive.forces) == 10


def test_the_loop_ends_without_an_answer(loop, drive, monkeypatch):
    monkeypatch.setattr(dynamixel_sdk.port_handler, "LATENCY_TIMER", 100)

    def cut():
        drive.deaf = True

    drive.at[10] = cut
    with pytest.raises(TimeoutError):
        hold(loop, drive, [0.5] * 100)
    assert len(drive.forces) <= 11


def open_sensor(drive):
    drive.arm.reading = -1e9  # 0 counts, for longer than the test


def test_the_torque_is_off_after_20_bad_readings(loop, drive):
    drive.at[10] = lambda: open_sensor(drive)
    with pytest.raises(RuntimeError, match="20 bad readings"):
        hold(loop, drive, [0.5] * 260)
    due = time.monotonic() + 60.0
    while drive.memory[fake.ENABLE] and time.monotonic() < due:
        time.sleep(0.01)  # the last packet asks for no answer
    assert (len(drive.forces), drive.memory[fake.ENABLE], drive.units) == (29, 0, 0)


def test_the_loop_goes_on_after_19_bad_readings(loop, drive):
    def mend():
        drive.arm.reading = 0.5

    drive.at[10], drive.at[29] = lambda: open_sensor(drive), mend
    hold(loop, drive, [0.5] * 100)
    assert (len(drive.forces), loop.bad_inputs) == (100, 19)
