"""A simulated CiA 402 drive on python-can's virtual bus: NMT, expedited SDO, one PDO each way at SYNC, the state machine, and a position loop
at 10 kHz that turns the examples' joint. It shares no code with the client; it answers with the bytes that CiA 301 defines. Each SYNC advances its
time by one period, so that a run gives the same result on every machine."""

import math
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "sim"))
from can_node import CanNode  # noqa: E402
from hinge import Hinge  # noqa: E402

NODE = 1
RPDO_TIMEOUT = 0x8250
RATED_N_M = 0.5  # 6076h, 500 mN m
OBJECTS = {  # index, sub: type of CiA 301, access, value
    (0x1000, 0): ("u32", "ro", 0x00020192), (0x1001, 0): ("u8", "ro", 0),
    (0x1400, 0): ("u8", "ro", 5), (0x1400, 1): ("u32", "rw", 0x200 + NODE), (0x1400, 2): ("u8", "rw", 255), (0x1400, 5): ("u16", "rw", 0),
    (0x1600, 0): ("u8", "rw", 1), (0x1600, 1): ("u32", "rw", 0x60400010), (0x1600, 2): ("u32", "rw", 0), (0x1600, 3): ("u32", "rw", 0),
    (0x1800, 0): ("u8", "ro", 2), (0x1800, 1): ("u32", "rw", 0x40000180 + NODE), (0x1800, 2): ("u8", "rw", 255),
    (0x1A00, 0): ("u8", "rw", 1), (0x1A00, 1): ("u32", "rw", 0x60410010), (0x1A00, 2): ("u32", "rw", 0), (0x1A00, 3): ("u32", "rw", 0),
    (0x603F, 0): ("u16", "ro", 0), (0x6040, 0): ("u16", "rw", 0), (0x6041, 0): ("u16", "ro", 0x40), (0x6060, 0): ("i8", "rw", 0),
    (0x6064, 0): ("i32", "ro", 0), (0x6077, 0): ("i16", "ro", 0), (0x607A, 0): ("i32", "rw", 0), (0x60B2, 0): ("i16", "rw", 0)}
TYPES = {"u8": ("<B", 5), "u16": ("<H", 6), "u32": ("<I", 7), "i8": ("<b", 2), "i16": ("<h", 3), "i32": ("<i", 4)}  # layout, DataType of an EDS
STEPS = {(0x40, 0x06): 0x21, (0x21, 0x07): 0x23, (0x21, 0x0F): 0x23, (0x23, 0x0F): 0x27, (0x27, 0x0F): 0x27}  # (state, controlword): next state


def eds():
    """The drive's electronic data sheet, as its manufacturer would supply it."""
    lines = ["[DeviceInfo]", "VendorName=none"]
    for index in sorted({index for index, _ in OBJECTS}):
        subs = {sub: OBJECTS[index, sub] for i, sub in OBJECTS if i == index}
        record = subs.keys() != {0}
        lines += [f"[{index:04X}]", f"ParameterName=object {index:04X}", f"ObjectType={'0x9' if record else '0x7'}"]
        if record:
            lines.append(f"SubNumber={len(subs)}")
        for sub, (kind, access, _) in subs.items():
            lines += [f"[{index:04X}sub{sub:X}]", f"ParameterName=sub {sub}", "ObjectType=0x7"] if record else []
            lines += [f"DataType={TYPES[kind][1]}", f"AccessType={access}"]
    lists = [index for index in sorted({index for index, _ in OBJECTS}) if index != 0x1000 and index != 0x1001]
    lines += ["[MandatoryObjects]", "SupportedObjects=2", "1=0x1000", "2=0x1001", "[OptionalObjects]", f"SupportedObjects={len(lists)}"]
    return "\n".join(lines + [f"{number}={index:#x}" for number, index in enumerate(lists, 1)]) + "\n"


class FakeDrive(CanNode):
    KP, KD = 20.0, 0.7  # N m per turn, N m s per turn

    def __init__(self, channel, period_s, counts, torque_sign=1):
        self.hinge, self.period_s, self.counts, self.sign = Hinge(period_s, counts), period_s, counts, torque_sign
        self.objects = {key: value for key, (_, _, value) in OBJECTS.items()}
        self.operational, self.deaf, self.silent_s, self.armed, self.torque = False, False, 0.0, False, 0.0
        self.last_off, self.set_point, self.received = None, 0.0, b""
        self.seen = []  # (target, angle, offset) at each SYNC in state operation enabled
        self.at = {}  # n: a function to call at the n-th such SYNC
        super().__init__(channel)

    @property
    def state(self):
        return self.objects[0x6041, 0]

    def take(self, message):
        identifier, data = message.arbitration_id, bytes(message.data)
        if self.deaf:
            return
        if identifier == 0x000 and data[1] in (0, NODE):
            self.operational = {1: True, 128: False}.get(data[0], self.operational)
        elif identifier == 0x600 + NODE:
            self.serve(data)
        elif self.operational and identifier == self.objects[0x1400, 1]:
            self.received, self.silent_s, self.armed = data, 0.0, True
        elif self.operational and identifier == 0x080:
            self.sync()

    def serve(self, data):
        """Answers an expedited SDO, and aborts every other one."""
        command, index, sub = struct.unpack_from("<BHB", data)
        if (index, sub) not in OBJECTS:
            return self.send(0x580 + NODE, struct.pack("<BHBI", 0x80, index, sub, 0x06020000))
        kind, access, _ = OBJECTS[index, sub]
        layout = TYPES[kind][0]
        if command == 0x40:
            value = struct.pack(layout, self.objects[index, sub])
            return self.send(0x580 + NODE, struct.pack("<BHB4s", 0x43 | 4 - len(value) << 2, index, sub, value))
        if command != 0x23 | 4 - struct.calcsize(layout) << 2 or access != "rw":
            return self.send(0x580 + NODE, struct.pack("<BHBI", 0x80, index, sub, 0x06010002 if access != "rw" else 0x06070010))
        self.objects[index, sub] = struct.unpack_from(layout, data, 4)[0]
        if (index, sub) == (0x6040, 0):
            self.control(self.objects[index, sub])
        return self.send(0x580 + NODE, struct.pack("<BHBI", 0x60, index, sub, 0))

    def control(self, word):
        if self.state == 0x08:
            reached = 0x40 if word & 0x80 else 0x08
        else:
            reached = STEPS.get((self.state, word & 0x0F), 0x40 if word & 0x02 == 0 else self.state)
        if reached == 0x27 and self.objects[0x6060, 0] != 8:
            raise AssertionError("not cyclic synchronous position")
        self.objects[0x6041, 0] = reached
        self.torque, self.last_off = (self.torque, self.last_off) if reached == 0x27 else (0.0, None)

    def mapped(self, index):
        """Keys of the objects that a PDO has, as the client has mapped them."""
        entries = [self.objects[index, sub] for sub in range(1, 1 + self.objects[index, 0])]
        return [(entry >> 16, entry >> 8 & 0xFF) for entry in entries]

    def sync(self):
        keys = self.mapped(0x1600)
        values = struct.unpack("<" + "".join(TYPES[OBJECTS[key][0]][0][1] for key in keys), self.received)
        self.objects.update(zip(keys, values))
        if self.state == 0x27:
            self.seen.append((self.objects[0x607A, 0] / self.counts, self.hinge.angle, self.objects[0x60B2, 0]))
            self.at.get(len(self.seen), lambda: None)()
        for left in reversed(range(Hinge.SUBSTEPS)):
            self.control_position(left)
            self.hinge.move(self.torque)
        self.objects[0x6064, 0] = math.floor(self.hinge.angle * self.counts)
        self.objects[0x6077, 0] = round(self.sign * 1000 * self.torque / RATED_N_M)
        self.answer()

    def control_position(self, left):
        """The drive's own loop: a PD that follows a ramp to the target. The torque offset is added to its output."""
        if self.state != 0x27:
            return
        target = self.objects[0x607A, 0] / self.counts
        self.set_point = target if self.last_off is None else self.set_point + (target - self.set_point) / (left + 1)
        off = self.set_point - self.hinge.reading
        rate = 0.0 if self.last_off is None else (off - self.last_off) / self.period_s
        self.last_off = off if self.last_off is None else self.last_off + (off - self.last_off) / Hinge.SUBSTEPS
        self.torque = self.KP * off + self.KD * rate + self.sign * self.objects[0x60B2, 0] * RATED_N_M / 1000

    def answer(self):
        if not self.deaf:
            keys = self.mapped(0x1A00)
            data = b"".join(struct.pack(TYPES[OBJECTS[key][0]][0], self.objects[key]) for key in keys)
            self.send(self.objects[0x1800, 1] & 0x7FF, data)

    def fail(self, error):
        self.objects[0x603F, 0], self.objects[0x6041, 0], self.torque = error, 0x08, 0.0

    def elapse(self, time_s):
        """Lets time pass without a frame."""
        self.silent_s += time_s
        timer = self.objects[0x1400, 5]
        if self.armed and timer and 1000 * self.silent_s >= timer:
            self.fail(RPDO_TIMEOUT)
