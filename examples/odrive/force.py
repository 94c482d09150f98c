#!/usr/bin/env python3
"""force.py RIG: holds a torque with an ODrive over CANSimple, at 500 Hz with ../rig/rig_500hz.yaml. The torque sensor's amplifier is on
the same bus, and its frames are the clock."""

import struct
import sys
import time

import can
import tribo

NODE = 0  # axis.config.can.node_id of the ODrive
SENSOR = 0x7C0  # the amplifier's frame: a float in N m; yours
PATIENCE_S = 0.02  # ten periods without a frame of the sensor

HEARTBEAT, SET_AXIS_STATE, SET_CONTROLLER_MODE, SET_INPUT_TORQUE, CLEAR_ERRORS = 0x01, 0x07, 0x0B, 0x0E, 0x18
IDLE, CLOSED_LOOP = 1, 8
TORQUE_CONTROL, PASSTHROUGH = 1, 1


class Axis:
    """What of CANSimple the loop needs. An error in the drive's heartbeat is an exception here."""

    def __init__(self, bus):
        self.bus = bus

    def send(self, command, layout, *values):
        self.bus.send(can.Message(arbitration_id=NODE << 5 | command, is_extended_id=False, data=struct.pack(layout, *values)))

    def start(self, patience_s=1.0):
        self.send(CLEAR_ERRORS, "<B", 0)
        self.send(SET_CONTROLLER_MODE, "<II", TORQUE_CONTROL, PASSTHROUGH)
        self.send(SET_INPUT_TORQUE, "<f", 0.0)
        self.send(SET_AXIS_STATE, "<I", CLOSED_LOOP)
        due = time.monotonic() + patience_s
        while self.take(self.bus.recv(patience_s))[1] != CLOSED_LOOP:
            if time.monotonic() > due:
                raise TimeoutError("ODrive: no closed loop")

    def take(self, message):
        """Reading and state that a frame brings, or None."""
        if message is None:
            raise TimeoutError("ODrive: nothing on the bus")
        if message.arbitration_id == SENSOR:
            return struct.unpack("<f", message.data)[0], None
        if message.arbitration_id == NODE << 5 | HEARTBEAT:
            error, state = struct.unpack_from("<IB", message.data)
            if error:
                raise RuntimeError(f"ODrive: axis error {error:#x}")
            return None, state
        return None, None

    def torque(self):
        """The sensor's next reading, the newest if there are several: one that has waited is not taken for a new one."""
        reading, message = None, self.bus.recv(PATIENCE_S)
        while reading is None or message is not None:
            new, state = self.take(message)
            if state not in (None, CLOSED_LOOP):
                raise RuntimeError("ODrive: the axis has left closed loop")
            reading = reading if new is None else new
            message = self.bus.recv(PATIENCE_S if reading is None else 0)
        return reading


# [add
def hold(bus, loop, references):
    """A reference a reading, until they end; then, or with any fault, the axis is idle."""
    axis = Axis(bus)
    try:
        axis.start()
        for reference in references:
            axis.send(SET_INPUT_TORQUE, "<f", loop.step(reference, axis.torque()))
    finally:
        axis.send(SET_AXIS_STATE, "<I", IDLE)
# add]


def steps():
    """What is to be held: yours."""
    while True:
        yield 0.5


if __name__ == "__main__":
    with can.Bus(interface="socketcan", channel="can0") as can0:
        hold(can0, tribo.Loop(sys.argv[1]), steps())
