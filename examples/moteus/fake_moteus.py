"""A simulated moteus on python-can's virtual bus, with the examples' arm and a torque sensor on aux1: only the part that force.py uses.
FakeJoint has the examples' joint instead, in position mode. Each position command advances time by one period, so that a run gives the same
result on every machine."""

import pathlib
import struct
import sys

import moteus

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "sim"))
from arm import Arm, triangle  # noqa: E402, F401
from can_node import CanNode  # noqa: E402
from hinge import Hinge  # noqa: E402

R = moteus.Register
RESOLUTION = {moteus.INT8: (0x21, "<b"), moteus.INT16: (0x25, "<h"), moteus.INT32: (0x29, "<i"), moteus.F32: (0x2D, "<f")}


class FakeMoteus(CanNode):
    def __init__(self, channel, period_s, offset, n_m_per_unit):
        self.arm, self.period_s = Arm(period_s), period_s
        self.offset, self.n_m_per_unit = offset, n_m_per_unit
        self.mode, self.fault, self.left_s, self.torque = moteus.Mode.STOPPED, 0, 0.0, 0.0
        self.forces, self.torques = [], []  # one value per command
        self.deaf = False  # ignores all frames, as with a broken wire
        super().__init__(channel)

    def take(self, message):
        if self.deaf or message.arbitration_id & 0xFF != 1:
            return
        said = moteus.parse_registers(message.data)
        mode = said.command.get(R.MODE)
        if mode == moteus.Mode.STOPPED:
            self.mode, self.fault, self.torque = mode, 0, 0.0
        elif mode == moteus.Mode.POSITION and self.mode in (moteus.Mode.STOPPED, moteus.Mode.POSITION):
            self.command(said.command)
        if message.arbitration_id & 0x8000:
            self.reply(said.query, message.arbitration_id >> 8 & 0x7F)

    def command(self, command):
        """Accepts torque commands only: a position or velocity gain would be a second controller."""
        position_gain, velocity_gain = command.get(R.COMMAND_KP_SCALE, 1.0), command.get(R.COMMAND_KD_SCALE, 1.0)
        if position_gain or velocity_gain or command[R.COMMAND_POSITION] == command[R.COMMAND_POSITION]:
            raise AssertionError("the command must be torque only")
        limit = command[R.COMMAND_POSITION_MAX_TORQUE]
        self.mode, self.left_s = moteus.Mode.POSITION, command[R.COMMAND_TIMEOUT]
        self.torque = min(max(command[R.COMMAND_FEEDFORWARD_TORQUE], -limit), limit)
        self.forces.append(self.arm.force)
        self.torques.append(self.torque)
        self.arm.step(self.torque)

    def elapse(self, time_s):
        """Lets time pass without a command."""
        self.left_s -= time_s
        if self.mode == moteus.Mode.POSITION and self.left_s <= 0:
            self.mode, self.torque = moteus.Mode.TIMEOUT, 0.0
        for _ in range(round(time_s / self.period_s)):
            self.arm.step(self.torque)

    def fail(self, code):
        self.mode, self.fault, self.torque = moteus.Mode.FAULT, code, 0.0

    def values(self):
        return {R.MODE: self.mode, R.FAULT: self.fault, R.AUX1_ANALOG_IN1: self.offset + self.arm.reading / self.n_m_per_unit}

    def reply(self, query, to):
        values = self.values()
        data = b""
        for register, resolution in query:
            head, code = RESOLUTION[resolution]
            value = values[register]
            data += bytes((head, register)) + struct.pack(code, value if code == "<f" else int(value))
        size = next(n for n in (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64) if n >= len(data))
        self.send(1 << 8 | to, data.ljust(size, b"\x50"), is_fd=True, is_extended_id=to != 0)


class FakeJoint(FakeMoteus):
    """Position mode: the drive's own PD runs at each substep, and the feedforward torque is added to its output."""

    KP, KD = 20.0, 0.7  # servo.pid_position, N m per turn and N m s per turn

    def __init__(self, channel, period_s, counts, torque_sign=1):
        self.hinge, self.sign = Hinge(period_s, counts), torque_sign
        self.seen, self.at = [], {}  # (target, angle, feedforward) at each command; n: a function to call at the n-th
        super().__init__(channel, period_s, 0.0, 1.0)

    def command(self, command):
        limit, target, velocity = (command[x] for x in (R.COMMAND_POSITION_MAX_TORQUE, R.COMMAND_POSITION, R.COMMAND_VELOCITY))
        self.mode, self.left_s = moteus.Mode.POSITION, command[R.COMMAND_TIMEOUT]
        self.seen.append((target, self.hinge.angle, command[R.COMMAND_FEEDFORWARD_TORQUE]))
        for substep in range(Hinge.SUBSTEPS):
            position = target + substep * self.hinge.dt * velocity
            wanted = self.KP * (position - self.hinge.reading) + self.KD * (velocity - self.hinge.speed)
            self.torque = min(max(wanted + self.sign * command[R.COMMAND_FEEDFORWARD_TORQUE], -limit), limit)
            self.hinge.move(self.torque)
        self.at.get(len(self.seen), lambda: None)()

    def elapse(self, time_s):
        """Lets time pass without a command."""
        self.left_s -= time_s
        if self.mode == moteus.Mode.POSITION and self.left_s <= 0:
            self.mode, self.torque = moteus.Mode.TIMEOUT, 0.0

    def values(self):
        return {R.MODE: self.mode, R.FAULT: self.fault, R.POSITION: self.hinge.reading, R.TORQUE: self.sign * self.torque}
