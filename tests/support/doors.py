"""The library's axis and joint by its own calls (doors.c), for whatever else calls them; and an arm and a joint that share no code with it."""

import math
import struct
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PERIOD = 10_000
FULL_SCALE_N = 8.0

# What doors.c has.
AXIS = {"sample_time_s": 1e-3, "u_min_n": -2, "u_max_n": 2, "positive.offset_n": 0.007, "positive.slope": 0.3, "actuator_pole_rad_per_s": 200,
        "sensor_pole_rad_per_s": 55}
PI = {"kp": 1.9, "ki_per_s": 110}
JOINT = {"sample_time_s": 1e-3, "effort_max": 1, "travel": 4 / 8192}
JOINT_COUNTS = JOINT | {"travel": 4}

# PI's section and one more, as exact floats: b0, b1, b2, a1, a2 in the delta operator.
SECTIONS = ((1.953125, 2.0625, 0.109375, 1.0, 0.0), (1.25, 1.5, 0.375, 1.0, 0.25))


def single(x):
    """The nearest float."""
    return struct.unpack("f", struct.pack("f", x))[0] if abs(x) < 3e38 else math.copysign(math.inf, x)


def word(x):
    """Bits of a float."""
    return struct.unpack("i", struct.pack("f", single(x) if math.isfinite(x) else x))[0]


def number(bits):
    return struct.unpack("f", struct.pack("i", bits))[0]


def q31(x, full_scale):
    """To the nearest bit, halves away from 0; full scale itself is next to the end, and more is the end."""
    if math.isnan(x) or abs(single(x)) > full_scale:
        return -(2**31) if math.isnan(x) else int(math.copysign(2**31 - 1, x))
    whole = math.floor(abs(x) / full_scale * 2**31 + 0.5)
    return int(math.copysign(min(whole, 2**31 - 2), x))


def of_q31(bits, full_scale):
    return bits / 2**31 * full_scale


def build(folder, is_q31):
    """doors.c, compiled: play(arguments, rows of whole numbers) gives the rows that it writes."""
    program = Path(folder) / f"doors_{'q31' if is_q31 else 'f32'}"
    sources = [ROOT / "tests/support/doors.c", *(ROOT / "lib/src").rglob("*.c")]
    subprocess.run(["gcc", "-std=c11", "-O1", "-ffp-contract=off", *(["-DTRIBO_ARITHMETIC_Q31"] if is_q31 else []), "-I", ROOT / "lib/include",
                    "-I", ROOT / "wire", *sources, "-o", program], check=True)
    return lambda arguments, rows: played([program, *arguments], rows)


def played(command, rows):
    text = "".join(" ".join(map(str, row)) + "\n" for row in rows)
    done = subprocess.run([str(word) for word in command], input=text, check=True, capture_output=True, text=True)
    return [tuple(map(int, line.split())) for line in done.stdout.splitlines()]


def reference(tick):
    phase = tick % PERIOD / PERIOD
    return 0.4 + 0.4 * min(phase, 1 - phase)


class Arm:
    """Its breakaway is 20 % above what AXIS says."""

    def __init__(self):
        self.actuator = self.force = self.reading = 0.0

    def step(self, u):
        breakaway = 1.2 * (0.007 + 0.3 * abs(self.force))
        self.actuator += 0.18127 * (u - self.actuator)
        held = min(max(self.force, self.actuator - breakaway), self.actuator + breakaway)
        self.force += 0.11765 * (held - self.force)
        self.reading += 0.05351 * (self.force - self.reading)


def axis_run(step, count):
    """RMS error of the last period, and what went in."""
    arm, square, rows = Arm(), 0.0, []
    for tick in range(count):
        row = (single(reference(tick)), single(arm.reading))
        rows.append(row)
        square += (reference(tick) - arm.force) ** 2 if tick >= count - PERIOD else 0.0
        arm.step(step(*row))
    return math.sqrt(square / PERIOD), rows


def plain_pi():
    """PI, by itself."""
    state = [0.0]

    def step(r, y):
        state[0] += 0.11 * (r - y)
        return 1.9 * (r - y) + state[0]

    return step


def joint_run(step, in_counts=False):
    """RMS error of a swing under a PD, from the sixth second to the twelfth, and what went in: effort, q_ref, q in revolutions or 8192 counts."""
    angle = speed = last = square = 0.0
    rows = []
    for tick in range(12_000):
        wanted = 0.25 * math.sin(math.pi * 1e-3 * tick)
        q = math.floor(angle * 8192) / 8192
        off = wanted - q
        effort = single(20 * off + 0.7 * (off - last) * 1e3)
        rows.append((effort, math.floor(8192 * wanted), int(8192 * q)) if in_counts else (effort, single(wanted), q))
        u, last = step(*rows[-1]), off
        for _ in range(10):
            push = u + 0.0126 * speed / 1e-4
            speed = 0.0 if abs(push) < 0.1 else (push - math.copysign(0.1, push)) * 1e-4 / 0.0126
            angle += 1e-4 * speed
        square += (wanted - angle) ** 2 if tick >= 6000 else 0.0
    return math.sqrt(square / 6000), rows
