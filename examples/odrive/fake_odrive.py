"""An ODrive on python-can's virtual bus, with the examples' arm and the amplifier of a torque sensor. Its time goes on by a period
with each torque command, so that a run is the same on any machine."""

import math
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "sim"))
from arm import Arm, triangle  # noqa: E402, F401
from can_node import CanNode  # noqa: E402

NODE, SENSOR = 0, 0x7C0
WATCHDOG_EXPIRED = 0x01000000
HEARTBEAT_PERIODS = 50


class FakeODrive(CanNode):
    def __init__(self, channel, period_s, watchdog_s=0.02):
        self.arm, self.period_s, self.watchdog_s = Arm(period_s), period_s, watchdog_s
        self.state, self.error, self.mode, self.torque, self.left_s = 1, 0, (2, 1), 0.0, watchdog_s
        self.forces = []  # at each command in closed loop
        self.at = {}  # what happens at the n-th command, beside it
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
            raise AssertionError("not torque control")
        self.torque = torque
        self.forces.append(self.arm.force)
        self.arm.step(torque)
        self.at.get(len(self.forces), lambda: None)()
        if len(self.forces) % HEARTBEAT_PERIODS == 0:
            self.heartbeat()
        self.sense()

    def sense(self):
        if self.state == 8 and self.has_sensor:
            self.send(SENSOR, struct.pack("<f", self.arm.reading))

    def fail(self, error):
        self.error, self.state, self.torque = error, 1, 0.0
        self.heartbeat()

    def elapse(self, time_s):
        """Time without a command."""
        self.left_s -= time_s
        if self.state == 8 and self.left_s <= 0:
            self.fail(WATCHDOG_EXPIRED)


class Hinge:
    """A joint of 0.002 kg m2 with 0.1 N m of Coulomb friction, in turns; its encoder has 8,192 counts."""

    INERTIA, FRICTION, COUNTS, SUBSTEPS = 0.0126, 0.1, 8192, 20  # N m s2 a turn

    def __init__(self, period_s):
        self.dt, self.force, self.speed = period_s / self.SUBSTEPS, 0.0, 0.0  # `force`: where it is

    @property
    def reading(self):
        return math.floor(self.force * self.COUNTS) / self.COUNTS

    def step(self, torque):
        for _ in range(self.SUBSTEPS):
            push = torque + self.INERTIA * self.speed / self.dt
            self.speed = 0.0 if abs(push) < self.FRICTION else (push - math.copysign(self.FRICTION, push)) * self.dt / self.INERTIA
            self.force += self.dt * self.speed


class FakeJoint(FakeODrive):
    """An ODrive with that joint, and frames of its encoder instead of a sensor's."""

    def __init__(self, channel, period_s):
        self.hinge = Hinge(period_s)
        super().__init__(channel, period_s)
        self.arm = self.hinge

    def sense(self):
        if self.state == 8 and self.has_sensor:
            self.send(NODE << 5 | 0x09, struct.pack("<ff", self.hinge.reading, self.hinge.speed))
