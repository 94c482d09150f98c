#!/usr/bin/env python3
"""joint.py: a position loop with friction compensation for a joint without a force sensor, with an ODrive over CANSimple. The drive's encoder
frames set the pace, 500 Hz."""

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
COUNTS = 8192  # encoder counts per turn
KP, KD = 20.0, 0.7  # N m per turn, N m s per turn; set yours


class Joint(Axis):
    """The part of CANSimple that a position loop needs."""

    def take(self, message):
        if message is not None and message.arbitration_id == NODE << 5 | ENCODER_ESTIMATES:
            return struct.unpack("<ff", message.data)[0], None
        return super().take(message)

    def position(self):
        """Waits for the next position, in turns. If several have arrived, returns the newest."""
        return self.torque()


# [add
def friction():
    """Units: turns and N m. Friction is learned from the loop's own torque."""
    return tribo.Joint(sample_time_s=PERIOD_S, effort_max=1.0, travel=4 / COUNTS)


def torque(joint, effort, q_ref, q):
    """Returns the torque to send to the drive instead of `effort`."""
    return joint.step(effort, q_ref, q)
# add]


def follow(bus, joint, references):
    """Sends a torque for each reference until they end, a travel from where the joint is now. Then, or at any fault, it sets the axis idle."""
    axis = Joint(bus)
    try:
        axis.start()
        loop = PositionLoop(KP, KD, PERIOD_S)
        begin = None
        for travel in references:
            q = axis.position()
            begin = q if begin is None else begin
            q_ref = begin + travel
            axis.send(SET_INPUT_TORQUE, "<f", torque(joint, loop.step(q_ref, q), q_ref, q))
    finally:
        axis.send(SET_AXIS_STATE, "<I", IDLE)


if __name__ == "__main__":
    with can.Bus(interface="socketcan", channel="can0") as can0:
        follow(can0, friction(), swing(PERIOD_S))
