#!/usr/bin/env python3
"""force.py RIG: holds a torque with a moteus, at the rate of the rig, ../rig/rig_500hz.yaml."""

import asyncio
import math
import sys
import time

import moteus
import tribo

WATCHDOG_S = 0.02  # ten periods: without a command the drive stops by itself
BAD_MAX = 20  # bad readings in succession, 40 ms
MAX_TORQUE = 2.0  # N m; the drive's own limit, at or above the loop's
OFFSET, N_M_PER_UNIT = 0.5, 4.0  # torque sensor on aux1 pin 1: the drive reports its voltage as a fraction of full scale


def resolution():
    """The contents of each reply: mode, fault and the sensor's voltage."""
    wanted = moteus.QueryResolution()
    wanted.position = wanted.velocity = wanted.torque = wanted.voltage = wanted.temperature = moteus.IGNORE
    wanted._extra = {moteus.Register.AUX1_ANALOG_IN1: moteus.F32}
    return wanted


# [add
async def hold(controller, loop, references, pause, patience_s=WATCHDOG_S):
    """Sends one reference per period until they end. Then, or at any fault, it stops the drive."""
    try:
        await controller.set_stop()  # only this clears a fault or a timeout of the moteus
        state = await asyncio.wait_for(controller.query(), patience_s)
        bad = 0
        for reference in references:
            torque = (state.values[moteus.Register.AUX1_ANALOG_IN1] - OFFSET) * N_M_PER_UNIT
            before = loop.bad_inputs
            command = loop.step(reference, torque)
            bad = bad + 1 if loop.bad_inputs > before else 0
            if bad == BAD_MAX:
                raise RuntimeError(f"{bad} bad readings in succession")
            state = await asyncio.wait_for(controller.set_position(
                position=math.nan, kp_scale=0, kd_scale=0, feedforward_torque=command, maximum_torque=MAX_TORQUE,
                watchdog_timeout=WATCHDOG_S, query=True), patience_s)
            if state.values[moteus.Register.MODE] != moteus.Mode.POSITION:
                raise moteus.FaultError(state.values[moteus.Register.MODE], state.values[moteus.Register.FAULT])
            await pause()
    finally:
        await controller.set_stop()
# add]


def every(period_s):
    """Returns a coroutine that waits for the next period."""
    due = time.monotonic()

    async def pause():
        nonlocal due
        due = max(due + period_s, time.monotonic())  # does not catch up after a late tick
        await asyncio.sleep(max(0.0, due - time.monotonic()))

    return pause


def steps():
    """The references; replace them with yours."""
    while True:
        yield 0.5


if __name__ == "__main__":
    force_loop = tribo.Loop(sys.argv[1])
    asyncio.run(hold(moteus.Controller(id=1, query_resolution=resolution()), force_loop, steps(), every(force_loop.sample_time_s)))
