#!/usr/bin/env python3
"""joint.py: a position loop for a joint without a force sensor, with an ODrive over CANSimple, and its friction taken out. The drive's encoder
frames are the clock: 500 Hz."""

import pathlib
import struct
import sys

import can
import tribo

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "sim"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from force import IDLE, NODE, SET_AXIS_STATE, SET_INPUT_TORQUE, Axis  # noqa: E402
from hinge import PositionLoop, swing  # noqa: E402

ENCODER_ESTIMATES = 0x09
PERIOD_S = 0.002
COUNTS = 8192  # of the encoder, a turn
KP, KD = 20.0, 0.7  # N m a turn, N m s a turn: yours


class Joint(Axis):
    """What of CANSimple a position loop needs."""

    def take(self, message):
        if message is not None and message.arbitration_id == NODE << 5 | ENCODER_ESTIMATES:
            return struct.unpack("<ff", message.data)[0], None
        return super().take(message)

    def position(self):
        """The next position, in turns; the newest if there are several."""
        return self.torque()


# [add
def friction():
    """Turns and N m. Friction is learned from the loop's own torque."""
    return tribo.Joint(sample_time_s=PERIOD_S, effort_max=1.0, travel=4 / COUNTS)


def torque(joint, effort, q_ref, q):
    """What is sent to the drive instead of `effort`."""
    return joint.step(effort, q_ref, q)
# add]


def follow(bus, joint, references):
    """A position a reference, until they end; then, or with any fault, the axis is idle."""
    axis = Joint(bus)
    try:
        axis.start()
        loop = PositionLoop(KP, KD, PERIOD_S)
        for q_ref in references:
            q = axis.position()
            axis.send(SET_INPUT_TORQUE, "<f", torque(joint, loop.step(q_ref, q), q_ref, q))
    finally:
        axis.send(SET_AXIS_STATE, "<I", IDLE)


if __name__ == "__main__":
    with can.Bus(interface="socketcan", channel="can0") as can0:
        follow(can0, friction(), swing(PERIOD_S))
