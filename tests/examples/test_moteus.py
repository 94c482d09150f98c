"""examples/moteus over the real client, against a fake drive on a virtual bus."""

import asyncio
import math

import moteus
import pytest
import tribo

from conftest import EXAMPLES, RMS_MAX_UN, load, rms_of

force, fake = load("moteus/force.py"), load("moteus/fake_moteus.py")
PATIENCE_S = 5.0


@pytest.fixture(name="loop")
def _loop():
    return tribo.Loop(EXAMPLES / "rig" / "rig_500hz.yaml")


@pytest.fixture(name="drive")
def _drive(loop, request):
    drive = fake.FakeMoteus(request.node.name, loop.sample_time_s, force.OFFSET, force.N_M_PER_UNIT)
    yield drive
    drive.close()


async def no_pause():
    pass


def hold(loop, drive, references, pause=no_pause, patience_s=PATIENCE_S):
    async def run():
        async with moteus.PythonCan(interface="virtual", channel=drive.bus.channel_id) as transport:
            controller = moteus.Controller(id=1, query_resolution=force.resolution(), transport=transport)
            await force.hold(controller, loop, references, pause, patience_s)

    asyncio.run(run())


def test_the_loop_follows_against_friction(loop, drive):
    references = list(fake.triangle(loop.sample_time_s))
    hold(loop, drive, references)
    assert len(drive.forces) == len(references)
    assert rms_of(references, drive.forces) < RMS_MAX_UN
    assert loop.guard_cause == "none"
    drive.finish()
    assert drive.mode == moteus.Mode.STOPPED


def test_a_fault_of_the_drive_ends_the_loop(loop, drive):
    async def pause():
        if len(drive.forces) == 10:
            drive.fail(33)

    with pytest.raises(moteus.FaultError) as error:
        hold(loop, drive, [0.5] * 100, pause)
    assert str(error.value) == f"Fault mode={moteus.Mode.FAULT} code=33"
    assert len(drive.forces) == 10
    drive.finish()
    assert drive.mode == moteus.Mode.STOPPED


def test_the_drive_lets_go_when_the_loop_hangs(loop, drive):
    async def pause():
        if len(drive.forces) == 10:
            assert drive.torque != 0
            drive.elapse(force.WATCHDOG_S / 2)
            assert drive.mode == moteus.Mode.POSITION
            drive.elapse(force.WATCHDOG_S / 2)
            assert (drive.mode, drive.torque) == (moteus.Mode.TIMEOUT, 0)

    with pytest.raises(moteus.FaultError) as error:
        hold(loop, drive, [0.5] * 100, pause)
    assert f"mode={moteus.Mode.TIMEOUT}" in str(error.value)
    assert len(drive.forces) == 10


@pytest.mark.parametrize("tick", [0, 10])
def test_the_loop_ends_without_an_answer(loop, drive, tick):
    async def pause():
        drive.deaf = len(drive.forces) == 10

    drive.deaf = tick == 0
    with pytest.raises(asyncio.TimeoutError):
        hold(loop, drive, [0.5] * 100, pause, 0.2)
    assert len(drive.forces) == tick


def test_the_drive_is_stopped_after_20_bad_readings(loop, drive):
    async def pause():
        if len(drive.forces) == 10:
            drive.arm.reading = math.nan

    with pytest.raises(RuntimeError, match="20 bad readings"):
        hold(loop, drive, [0.5] * 510, pause)
    drive.finish()
    assert (len(drive.forces), drive.mode, drive.torque) == (30, moteus.Mode.STOPPED, 0)


def test_the_loop_goes_on_after_19_bad_readings(loop, drive):
    async def pause():
        if len(drive.forces) in (10, 29):
            drive.arm.reading = math.nan if len(drive.forces) == 10 else 0.5

    hold(loop, drive, [0.5] * 100, pause)
    assert (len(drive.forces), loop.bad_inputs) == (100, 19)
