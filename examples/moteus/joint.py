#!/usr/bin/env python3
"""joint.py: friction out of a joint that a moteus controls in position mode, by its feedforward torque; 500 Hz."""

import asyncio
import math
import pathlib
import sys

import moteus
import tribo

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "sim"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from force import WATCHDOG_S, every  # noqa: E402
from hinge import swing  # noqa: E402

PERIOD_S = 0.002
MAX_TORQUE = 1.0  # N m; the drive's own limit
COUNTS = 16384  # of the encoder, a turn


def resolution():
    """What each reply shall have: mode, fault, position and torque."""
    wanted = moteus.QueryResolution()
    wanted.position = wanted.torque = moteus.F32
    wanted.velocity = wanted.voltage = wanted.temperature = moteus.IGNORE
    return wanted


# [add
def friction():
    """Turns and N m."""
    return tribo.Joint(sample_time_s=PERIOD_S, effort_max=10 * MAX_TORQUE, travel=4 / COUNTS)


def feedforward(joint, torque, sent, q_ref, q):
    """`torque` is that of the drive's loop and of the feedforward that was sent before."""
    effort = torque - sent
    return min(max(joint.step(effort, q_ref, q) - effort, -MAX_TORQUE / 2), MAX_TORQUE / 2)
# add]


async def follow(controller, joint, references, pause, patience_s=WATCHDOG_S):
    """A position a period, until they end; then, or with any fault, the drive is stopped."""
    sent = last = 0.0
    try:
        await controller.set_stop()  # a moteus leaves a fault or a timeout only so
        state = await controller.query()
        for tick, q_ref in enumerate(references):
            sent = feedforward(joint, state.values[moteus.Register.TORQUE], sent, q_ref, state.values[moteus.Register.POSITION])
            velocity, last = (q_ref - last) / PERIOD_S if tick else 0.0, q_ref
            state = await asyncio.wait_for(controller.set_position(
                position=q_ref, velocity=velocity, velocity_limit=math.nan, accel_limit=math.nan, feedforward_torque=sent, maximum_torque=MAX_TORQUE,
                watchdog_timeout=WATCHDOG_S, query=True), patience_s)
            if state.values[moteus.Register.MODE] != moteus.Mode.POSITION:
                raise moteus.FaultError(state.values[moteus.Register.MODE], state.values[moteus.Register.FAULT])
            await pause()
    finally:
        await controller.set_stop()


if __name__ == "__main__":
    asyncio.run(follow(moteus.Controller(id=1, query_resolution=resolution()), friction(), swing(PERIOD_S), every(PERIOD_S)))
