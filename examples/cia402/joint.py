#!/usr/bin/env python3
"""joint.py EDS: compensates the friction of a joint that a CiA 402 drive controls, through its torque offset (60B2h). It runs in cyclic
synchronous position mode over CANopen, at 500 Hz."""

import pathlib
import sys
import time

import canopen
import tribo

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "sim"))
from hinge import swing  # noqa: E402

NODE = 1
PERIOD_S = 0.002
COUNTS = 65536  # encoder counts per turn
OFFSET_MAX = 400  # per mille; above the highest friction
PATIENCE_S = 0.02  # ten periods
CONTROLWORD, STATUSWORD, MODE, TARGET, OFFSET, POSITION, TORQUE = 0x6040, 0x6041, 0x6060, 0x607A, 0x60B2, 0x6064, 0x6077
CYCLIC_SYNCHRONOUS_POSITION = 8
FAULT, ENABLED = 0x08, 0x27  # bits of the statusword


class Drive:
    """The part of CiA 402 that the joint needs: SDOs until the drive runs, then two PDOs at each SYNC."""

    def __init__(self, network, eds):
        self.network, self.node = network, network.add_node(NODE, eds)
        self.target, self.answer = self.node.rpdo[1], self.node.tpdo[1]

    def map(self, pdo, *objects):
        pdo.read()
        pdo.clear()
        for index in objects:
            pdo.add_variable(index)
        pdo.trans_type, pdo.enabled = 1, True

    def switch(self, word, state):
        """Sends a controlword and waits until the drive reaches the state; releasing a brake takes time."""
        self.node.sdo[CONTROLWORD].raw = word
        due = time.monotonic() + 1.0
        while self.exchange() & 0x6F != state:
            if time.monotonic() > due:
                raise TimeoutError(f"drive: controlword {word:#x} does not lead to state {state:#x}")

    def start(self):
        self.node.nmt.state = "PRE-OPERATIONAL"
        self.map(self.target, TARGET, OFFSET)
        self.map(self.answer, STATUSWORD, POSITION, TORQUE)
        self.target.event_timer = round(1000 * PATIENCE_S)  # the drive itself stops after this time
        self.target.save()
        self.answer.save()
        self.node.sdo[MODE].raw = CYCLIC_SYNCHRONOUS_POSITION
        self.target[TARGET].raw, self.target[OFFSET].raw = self.node.sdo[POSITION].raw, 0  # the joint stays where it is
        self.node.nmt.state = "OPERATIONAL"
        for word, state in ((0x80, 0x40), (0x06, 0x21), (0x07, 0x23), (0x0F, ENABLED)):
            self.switch(word, state)

    def exchange(self):
        """Sends target and offset, then a SYNC. Returns the statusword of the answer."""
        with self.answer.receive_condition:
            self.target.transmit()
            self.network.sync.transmit()
            if not self.answer.receive_condition.wait(PATIENCE_S):
                raise TimeoutError("drive: no answer to SYNC")
        return self.answer[STATUSWORD].raw

    def check(self):
        state = self.answer[STATUSWORD].raw
        if state & FAULT or state & 0x6F != ENABLED:
            raise RuntimeError(f"drive: statusword {state:#06x}, error {self.node.sdo[0x603F].raw:#06x}")

    def stop(self):
        self.node.sdo[CONTROLWORD].raw = 0


# [add
def friction():
    """Units: counts, and per mille of the rated torque. effort_max is high because the drive limits the torque itself."""
    return tribo.Joint(sample_time_s=PERIOD_S, effort_max=10000, travel=4)


def offset(joint, torque, sent, q_ref, q):
    """Returns 60B2h. `torque` (6077h) is the output of the drive's loop plus the offset sent before."""
    effort = torque - sent
    return min(max(round(joint.step(effort, q_ref, q) - effort), -OFFSET_MAX), OFFSET_MAX)
# add]


def follow(network, eds, joint, references):
    """Sends one reference per period until they end, as a travel from where the joint is now. Then, or at any fault, it switches the drive off."""
    drive = Drive(network, eds)
    target, answer = drive.target, drive.answer
    try:
        drive.start()
        begin = answer[POSITION].raw
        for travel in references:
            drive.check()
            q_ref = begin + travel
            target[OFFSET].raw = offset(joint, answer[TORQUE].raw, target[OFFSET].raw, q_ref, answer[POSITION].raw)
            target[TARGET].raw = round(q_ref)
            drive.exchange()
    finally:
        drive.stop()


def counts():
    """The travels to follow; replace them with yours."""
    return (COUNTS * q for q in swing(PERIOD_S))


def every(period_s, values):
    """Yields one value per period."""
    due = time.monotonic()
    for value in values:
        due = max(due + period_s, time.monotonic())  # does not catch up after a late tick
        time.sleep(max(0.0, due - time.monotonic()))
        yield value


if __name__ == "__main__":
    with canopen.Network() as can0:
        can0.connect(interface="socketcan", channel="can0")
        follow(can0, sys.argv[1], friction(), every(PERIOD_S, counts()))
