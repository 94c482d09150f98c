#!/usr/bin/env python3
"""force.py RIG PORT: holds a torque with a Dynamixel of the X540 series in current mode, at the rate of the rig, ../rig/rig_250hz.yaml.
The torque sensor is on the servo's external port 1."""

import sys
import time

import tribo
from dynamixel_sdk import COMM_SUCCESS, PacketHandler, PortHandler

ID, BAUD = 1, 1_000_000
N_M_PER_UNIT = 0.0045  # one unit of Goal Current: 2.69 mA times the output torque per ampere; set yours
BAD_MAX = 20  # bad readings in succession, 80 ms
OFFSET, N_M_PER_COUNT = 2048, 0.001  # the sensor's amplifier, 4,095 counts at 3.3 V; set yours

OPERATING_MODE, EXTERNAL_PORT_MODE_1, TORQUE_ENABLE = 11, 56, 64
BUS_WATCHDOG, GOAL_CURRENT, EXTERNAL_PORT_DATA_1 = 98, 102, 152
CURRENT_CONTROL, ANALOG_INPUT = 0, 0
WATCHDOG_20MS = 1


class Servo:
    """Accesses the registers that the loop needs. It raises an exception if the servo does not answer or reports an error."""

    def __init__(self, port):
        self.port, self.packets = port, PacketHandler(2.0)

    def checked(self, result, error):
        if result != COMM_SUCCESS:
            raise TimeoutError(self.packets.getTxRxResult(result))
        if error:
            raise RuntimeError(self.packets.getRxPacketError(error))

    def write1(self, address, value):
        self.checked(*self.packets.write1ByteTxRx(self.port, ID, address, value))

    def start(self):
        self.write1(BUS_WATCHDOG, 0)  # also clears an expired watchdog
        self.write1(TORQUE_ENABLE, 0)
        self.write1(OPERATING_MODE, CURRENT_CONTROL)
        self.write1(EXTERNAL_PORT_MODE_1, ANALOG_INPUT)
        self.write1(BUS_WATCHDOG, WATCHDOG_20MS)
        self.write1(TORQUE_ENABLE, 1)

    def off(self):
        self.packets.write1ByteTxOnly(self.port, ID, TORQUE_ENABLE, 0)

    def torque(self):
        counts, *status = self.packets.read2ByteTxRx(self.port, ID, EXTERNAL_PORT_DATA_1)
        self.checked(*status)
        return (counts - OFFSET) * N_M_PER_COUNT

    def command(self, units):
        self.checked(*self.packets.write2ByteTxRx(self.port, ID, GOAL_CURRENT, units & 0xFFFF))


# [add
def hold(servo, loop, references, pause):
    """Sends one reference per period until they end. Then, or at any fault, it switches the torque off."""
    left, bad = 0.0, 0
    try:
        servo.start()
        for reference in references:
            before = loop.bad_inputs
            wanted = loop.step(reference, servo.torque()) / N_M_PER_UNIT + left
            bad = bad + 1 if loop.bad_inputs > before else 0
            if bad == BAD_MAX:
                raise RuntimeError(f"{bad} bad readings in succession")
            units = round(wanted)
            left = wanted - units  # the rounding remainder goes into the next command
            servo.command(units)
            pause()
    finally:
        servo.off()
# add]


def every(period_s):
    """Returns a function that waits for the next period."""
    due = time.monotonic()

    def pause():
        nonlocal due
        due = max(due + period_s, time.monotonic())  # does not catch up after a late tick
        time.sleep(max(0.0, due - time.monotonic()))

    return pause


def steps():
    """The references; replace them with yours."""
    while True:
        yield 0.5


def opened(name):
    port = PortHandler(name)
    if not port.openPort() or not port.setBaudRate(BAUD):
        raise OSError(f"cannot open {name}")
    return port


if __name__ == "__main__":
    force_loop = tribo.Loop(sys.argv[1])
    hold(Servo(opened(sys.argv[2])), force_loop, steps(), every(force_loop.sample_time_s))
