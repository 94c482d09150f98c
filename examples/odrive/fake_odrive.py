"""A simulated ODrive on python-can's virtual bus, with the examples' arm and the amplifier of a torque sensor. Each torque command advances
its time by one period, so that a run gives the same result on every machine."""

import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "sim"))
from arm import Arm, triangle  # noqa: E402, F401
from can_node import CanNode  # noqa: E402
from hinge import Hinge  # noqa: E402

NODE, SENSOR = 0, 0x7C0
WATCHDOG_EXPIRED = 0x01000000
HEARTBEAT_PERIODS = 50


class FakeODrive(CanNode):
    def __init__(self, channel, period_s, watchdog_s=0.02):
        self.arm, self.period_s, self.watchdog_s = Arm(period_s), period_s, watchdog_s
        self.state, self.error, self.mode, self.torque, self.left_s = 1, 0, (2, 1), 0.0, watchdog_s
        self.forces, self.commands = [], 0  # counted and recorded in closed loop only
        self.at = {}  # n: a function to call at the n-th command
        self.has_sensor = True
        super().__init__(channel)

    def heartbeat(self):
        self.send(NODE << 5 | 0x01, struct.pack("<IBBBB", self.error, self.state, 0, 0, 0))

    def take(self, message):
        if message.arbitration_id >> 5 == NODE:
            self.obey(message.arbitration_id & 0x1F, bytes(message.data))

    def obey(self, command, data):
        if command == 0x18:
            self.error = 0
        elif command == 0x0B:
            self.mode = struct.unpack("<II", data)
        elif command == 0x07:
            self.state = struct.unpack("<I", data)[0] if not self.error else 1
            self.torque = self.torque if self.state == 8 else 0.0
            self.left_s = self.watchdog_s
            self.heartbeat()
            self.sense()
        elif command == 0x0E:
            self.command(*struct.unpack("<f", data))

    def command(self, torque):
        self.left_s = self.watchdog_s
        if self.state != 8:
            return
        if self.mode != (1, 1):
            raise AssertionError("the controller mode must be torque control")
        self.torque = torque
        self.commands += 1
        self.move(torque)
        self.at.get(self.commands, lambda: None)()
        if self.commands % HEARTBEAT_PERIODS == 0:
            self.heartbeat()
        self.sense()

    def move(self, torque):
        self.forces.append(self.arm.force)
        self.arm.step(torque)

    def sense(self):
        if self.state == 8 and self.has_sensor:
            self.send(SENSOR, struct.pack("<f", self.arm.reading))

    def fail(self, error):
        self.error, self.state, self.torque = error, 1, 0.0
        self.heartbeat()

    def elapse(self, time_s):
        """Lets time pass without a command."""
        self.left_s -= time_s
        if self.state == 8 and self.left_s <= 0:
            self.fail(WATCHDOG_EXPIRED)


class FakeJoint(FakeODrive):
    """An ODrive with the examples' joint. It sends encoder frames instead of sensor frames."""

    def __init__(self, channel, period_s, sign=1):
        self.hinge, self.sign, self.seen = Hinge(period_s), sign, []  # sign: the motor's direction; seen: the angle at each command in closed loop
        super().__init__(channel, period_s)

    def move(self, torque):
        self.seen.append(self.hinge.angle)
        self.hinge.step(self.sign * torque)

    def sense(self):
        if self.state == 8 and self.has_sensor:
            self.send(NODE << 5 | 0x09, struct.pack("<ff", self.hinge.reading, self.hinge.speed))
