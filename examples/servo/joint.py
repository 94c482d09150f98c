#!/usr/bin/env python3
"""joint.py PORT: a 250 Hz position loop with friction compensation for a Dynamixel X540 in current mode, without a force sensor."""

import pathlib
import struct
import sys

import tribo

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "sim"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from force import ID, Servo, every, opened  # noqa: E402
from hinge import PositionLoop, swing  # noqa: E402

PRESENT_POSITION = 132
PERIOD_S = 0.004
COUNTS = 4096  # per turn
CURRENT_MAX = 500  # units of 2.69 mA; at most the servo's Current Limit (38)
KP, KD = 0.8, 0.025  # units per count, units s per count; set yours


class Joint(Servo):
    def position(self):
        counts, *status = self.packets.read4ByteTxRx(self.port, ID, PRESENT_POSITION)
        self.checked(*status)
        return struct.unpack("<i", struct.pack("<I", counts))[0]


# [add
def friction():
    """Units: counts, and units of Goal Current. Friction is learned from the loop's own current."""
    return tribo.Joint(sample_time_s=PERIOD_S, effort_max=CURRENT_MAX, travel=4)


def current(joint, effort, q_ref, q):
    """Returns the current to send to the servo instead of `effort`."""
    return round(joint.step(effort, q_ref, q))
# add]


def follow(servo, joint, references, pause):
    """Sends one current per period until the references end, travels from where the joint is now. Then, or at any fault, it switches the torque
    off."""
    try:
        servo.start()
        loop = PositionLoop(KP, KD, PERIOD_S)
        begin = servo.position()
        for travel in references:
            q_ref, q = begin + travel, servo.position()
            servo.command(current(joint, loop.step(q_ref, q), q_ref, q))
            pause()
    finally:
        servo.off()


def counts():
    """The travels to follow; replace them with yours."""
    return (COUNTS * q for q in swing(PERIOD_S))


if __name__ == "__main__":
    follow(Joint(opened(sys.argv[1])), friction(), counts(), every(PERIOD_S))
