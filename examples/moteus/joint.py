#!/usr/bin/env python3
"""joint.py: compensates the friction of a joint that a moteus controls in position mode, through its feedforward torque, at 500 Hz."""

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
COUNTS = 16384  # encoder counts per turn


def resolution():
    """The contents of each reply: mode, fault, position and torque."""
    wanted = moteus.QueryResolution()
    wanted.position = wanted.torque = moteus.F32
    wanted.velocity = wanted.voltage = wanted.temperature = moteus.IGNORE
    return wanted


# [add
def friction():
    """Units: turns and N m."""
    return tribo.Joint(sample_time_s=PERIOD_S, effort_max=10 * MAX_TORQUE, travel=4 / COUNTS)


def feedforward(joint, torque, sent, q_ref, q):
    """Returns the new feedforward. `torque` is the output of the drive's loop plus the feedforward sent before; NaN counts as 0."""
    effort = torque - sent if math.isfinite(torque) else 0.0
    return min(max(joint.step(effort, q_ref, q) - effort, -MAX_TORQUE / 2), MAX_TORQUE / 2)
# add]


async def follow(controller, joint, references, pause, patience_s=WATCHDOG_S):
    """Sends one reference per period until they end, as a travel from where the joint is now. Then, or at any fault, it stops the drive."""
    sent = last = 0.0
    try:
        await controller.set_stop()  # only this clears a fault or a timeout of the moteus
        state = await asyncio.wait_for(controller.query(), patience_s)
        begin = state.values[moteus.Register.POSITION]
        for tick, travel in enumerate(references):
            q_ref = begin + travel
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
