"""A simulated Dynamixel of the X540 series on a pty: protocol 2.0, the registers that force.py uses, and the examples' arm. Each command
advances its time by one period, so that a run gives the same result on every machine."""

import math
import os
import pathlib
import struct
import sys
import threading
import tty

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "sim"))
from arm import Arm, triangle  # noqa: E402, F401
from hinge import Hinge  # noqa: E402

HEADER = b"\xff\xff\xfd\x00"
READ, WRITE, STATUS = 0x02, 0x03, 0x55
ACCESS_ERROR, ALERT = 0x07, 0x80
MODE, PORT_MODE, ENABLE, HARDWARE_ERROR, WATCHDOG, GOAL, POSITION, DATA = 11, 56, 64, 70, 98, 102, 132, 152


def crc16(data):
    """CRC-16 with the polynomial 0x8005, initial value 0, high bit first."""
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x8005 if crc & 0x8000 else crc << 1) & 0xFFFF
    return crc


class FakeServo:
    def __init__(self, period_s, n_m_per_unit, offset, n_m_per_count):
        self.arm, self.period_s = Arm(period_s), period_s
        self.n_m_per_unit, self.offset, self.n_m_per_count = n_m_per_unit, offset, n_m_per_count
        self.memory = {MODE: 3, PORT_MODE: 3, ENABLE: 0, HARDWARE_ERROR: 0, WATCHDOG: 0}
        self.units, self.silent_s, self.deaf = 0, 0.0, False
        self.commands, self.forces, self.at = 0, [], {}  # one force per command; n: a function to call at the n-th
        self.master, slave = os.openpty()
        tty.setraw(slave)
        self.name = os.ttyname(slave)
        self.slave = slave  # kept open, so that the pty survives a client that closes it
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def close(self):
        os.write(self.slave, b"\x00end\x00")
        self.thread.join()
        os.close(self.slave)
        os.close(self.master)

    def serve(self):
        data = b""
        while b"\x00end\x00" not in data:
            data += os.read(self.master, 256)
            start = data.find(HEADER)
            while start >= 0 and len(data) >= start + 7 and len(data) >= start + 7 + struct.unpack_from("<H", data, start + 5)[0]:
                size = 7 + struct.unpack_from("<H", data, start + 5)[0]
                self.take(data[start:start + size])
                data = data[start + size:]
                start = data.find(HEADER)

    def take(self, packet):
        to, _, instruction = struct.unpack_from("<BHB", packet, 4)
        if self.deaf or to != 1 or crc16(packet[:-2]) != struct.unpack("<H", packet[-2:])[0]:
            return
        self.silent_s = 0.0
        parameters = packet[8:-2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
        address = struct.unpack_from("<H", parameters)[0]
        if instruction == READ:
            self.answer(0, self.read(address, *struct.unpack_from("<H", parameters, 2)))
        elif instruction == WRITE:
            self.answer(self.write(address, parameters[2:]), b"")

    def answer(self, error, data):
        error |= ALERT if self.memory[HARDWARE_ERROR] else 0
        packet = HEADER + struct.pack("<BHBB", 1, len(data) + 4, STATUS, error) + data
        os.write(self.master, packet + struct.pack("<H", crc16(packet)))

    def read(self, address, size):
        if address == DATA and self.memory[PORT_MODE] == 0:
            counts = round(self.offset + self.arm.reading / self.n_m_per_count)
            return struct.pack("<H", min(max(counts, 0), 4095))
        return self.memory[address].to_bytes(size, "little")

    def write(self, address, data):
        if address == GOAL:
            return self.command(*struct.unpack("<h", data))
        if self.memory[ENABLE] and address in (MODE, PORT_MODE):
            return ACCESS_ERROR
        if address == ENABLE and self.memory[HARDWARE_ERROR]:
            return ACCESS_ERROR
        self.memory[address] = data[0]
        self.units = self.units if self.memory[ENABLE] else 0
        return 0

    def command(self, units):
        if self.memory[WATCHDOG] == 0xFF:
            return ACCESS_ERROR
        if self.memory[MODE] != 0 or not self.memory[ENABLE]:
            raise AssertionError("the mode must be current control, with torque enabled")
        self.units = units
        self.commands += 1
        self.move(units * self.n_m_per_unit)
        self.at.get(self.commands, lambda: None)()
        return 0

    def move(self, torque):
        self.forces.append(self.arm.force)
        self.arm.step(torque)

    def elapse(self, time_s):
        """Lets time pass without a packet."""
        self.silent_s += time_s
        if 0 < self.memory[WATCHDOG] < 0x80 and self.silent_s >= 0.02 * self.memory[WATCHDOG]:
            self.memory[WATCHDOG], self.units = 0xFF, 0

    def fail(self, error):
        self.memory[HARDWARE_ERROR], self.memory[ENABLE], self.units = error, 0, 0


class FakeJoint(FakeServo):
    """The same servo, with the examples' joint instead of the arm."""

    COUNTS = 4096  # per turn

    def __init__(self, period_s, n_m_per_unit, sign=1):
        self.hinge, self.sign, self.seen = Hinge(period_s, self.COUNTS), sign, []  # (angle, units) at each command
        super().__init__(period_s, n_m_per_unit, 0, 1.0)

    def move(self, torque):
        self.seen.append((self.COUNTS * self.hinge.angle, self.units))
        self.hinge.step(torque)

    def read(self, address, size):
        if address == POSITION:
            return struct.pack("<i", self.sign * math.floor(self.COUNTS * self.hinge.angle))
        return super().read(address, size)
