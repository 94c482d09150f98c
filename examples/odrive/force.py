#!/usr/bin/env python3
"""force.py RIG: holds a torque with an ODrive over CANSimple, at 500 Hz with ../rig/rig_500hz.yaml. The torque sensor's amplifier is on
the same bus, and its frames set the pace."""

import struct
import sys
import time

import can
import tribo

NODE = 0  # axis.config.can.node_id of the ODrive
SENSOR = 0x7C0  # identifier of the amplifier's frame, a float in N m; set yours
PATIENCE_S = 0.02  # ten periods without a sensor frame
BAD_MAX = 20  # bad readings in succession, 40 ms

HEARTBEAT, SET_AXIS_STATE, SET_CONTROLLER_MODE, SET_INPUT_TORQUE, CLEAR_ERRORS = 0x01, 0x07, 0x0B, 0x0E, 0x18
IDLE, CLOSED_LOOP = 1, 8
TORQUE_CONTROL, PASSTHROUGH = 1, 1


class Axis:
    """The part of CANSimple that the loop needs. It raises an exception if the heartbeat reports an error."""

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
                raise TimeoutError("ODrive: the axis does not enter closed loop")

    def take(self, message):
        """Returns the reading and the state in a frame, each None if the frame has none."""
        if message is None:
            raise TimeoutError("ODrive: no frame on the bus")
        if message.arbitration_id == SENSOR:
            return struct.unpack("<f", message.data)[0], None
        if message.arbitration_id == NODE << 5 | HEARTBEAT:
            error, state = struct.unpack_from("<IB", message.data)
            if error:
                raise RuntimeError(f"ODrive: axis error {error:#x}")
            return None, state
        return None, None

    def torque(self):
        """Waits for the sensor's next reading. If several have arrived, returns the newest, so that no old reading is taken for a new one."""
        due = time.monotonic() + PATIENCE_S  # frames of other nodes do not extend it
        reading, message = None, self.bus.recv(PATIENCE_S)
        while reading is None or message is not None:
            new, state = self.take(message)
            if state not in (None, CLOSED_LOOP):
                raise RuntimeError("ODrive: the axis has left closed loop")
            reading = reading if new is None else new
            message = self.bus.recv(max(0.0, due - time.monotonic()) if reading is None else 0)
        return reading


# [add
def hold(bus, loop, references):
    """Sends a command for each reading until the references end. Then, or at any fault, it sets the axis idle."""
    axis = Axis(bus)
    try:
        axis.start()
        bad = 0
        for reference in references:
            before = loop.bad_inputs
            axis.send(SET_INPUT_TORQUE, "<f", loop.step(reference, axis.torque()))
            bad = bad + 1 if loop.bad_inputs > before else 0
            if bad == BAD_MAX:
                raise RuntimeError(f"{bad} bad readings in succession")
    finally:
        axis.send(SET_AXIS_STATE, "<I", IDLE)
# add]


def steps():
    """The references; replace them with yours."""
    while True:
        yield 0.5


if __name__ == "__main__":
    with can.Bus(interface="socketcan", channel="can0") as can0:
        hold(can0, tribo.Loop(sys.argv[1]), steps())
