"""FMUs of the library's axis and joint: the bits of its own calls, what they do for an arm and a joint, what they refuse."""

import math
import subprocess
import sys
from pathlib import Path

import pytest

from test_fmu import FMICallException, Instance, fmpy, numpy, validate_fmu

ROOT = Path(__file__).resolve().parents[2]
AXIS = {"sample_time_s": 1e-3, "u_min_n": -2, "u_max_n": 2, "positive.offset_n": 0.007, "positive.slope": 0.3, "actuator_pole_rad_per_s": 200,
        "sensor_pole_rad_per_s": 55, "kp": 1.9, "ki_per_s": 110}
JOINT = {"sample_time_s": 1e-3, "effort_max": 1, "travel": 4 / 8192}
PERIOD = 10_000


def command(part, fields, out, *options):
    words = [word for name, value in fields.items() for word in ("--set", f"{name}={value!r}")]
    return [sys.executable, "-B", ROOT / "tools/tribo-fmu", "--part", part, *words, *options, "--out", out]


@pytest.fixture(scope="module", params=[2, 3])
def made(request, tmp_path_factory):
    """The axis and the joint, of FMI 2.0 and 3.0."""
    folder = tmp_path_factory.mktemp(f"doors{request.param}")
    for part, fields in (("axis", AXIS), ("joint", JOINT)):
        subprocess.run(command(part, fields, folder / f"{part}.fmu", f"--fmi={request.param}"), check=True)
    return {part: folder / f"{part}.fmu" for part in ("axis", "joint")}


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """u by the library's own calls, for rows of inputs."""
    program = tmp_path_factory.mktemp("own") / "doors"
    sources = [ROOT / "tests/fmu/doors.c", *(ROOT / "lib/src").rglob("*.c")]
    subprocess.run(["gcc", "-std=c11", "-O1", "-ffp-contract=off", "-I", ROOT / "lib/include", *sources, "-o", program], check=True)

    def play(part, rows):
        text = "".join(" ".join(float(x).hex() for x in row) + "\n" for row in rows)
        done = subprocess.run([program, part], input=text, check=True, capture_output=True, text=True)
        return [float.fromhex(line) for line in done.stdout.splitlines()]

    return play


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
        row = (float(numpy.float32(reference(tick))), float(numpy.float32(arm.reading)))
        rows.append(row)
        square += (reference(tick) - arm.force) ** 2 if tick >= count - PERIOD else 0.0
        arm.step(step(*row))
    return math.sqrt(square / PERIOD), rows


def plain_pi():
    state = [0.0]

    def step(r, y):
        state[0] += 0.11 * (r - y)
        return 1.9 * (r - y) + state[0]

    return step


def joint_run(step):
    """RMS error of a swing under a PD, from the sixth second to the twelfth, and what went in."""
    angle = speed = last = square = 0.0
    rows = []
    for tick in range(12_000):
        wanted = 0.25 * math.sin(math.pi * 1e-3 * tick)
        q = math.floor(angle * 8192) / 8192
        off = wanted - q
        row = tuple(float(numpy.float32(x)) for x in (20 * off + 0.7 * (off - last) * 1e3, wanted, q))
        rows.append(row)
        u, last = step(*row), off
        for _ in range(10):
            push = u + 0.0126 * speed / 1e-4
            speed = 0.0 if abs(push) < 0.1 else (push - math.copysign(0.1, push)) * 1e-4 / 0.0126
            angle += 1e-4 * speed
        square += (wanted - angle) ** 2 if tick >= 6000 else 0.0
    return math.sqrt(square / 6000), rows


def test_an_axis_takes_friction_out_with_the_librarys_bits(made, own):
    assert validate_fmu(str(made["axis"])) == []
    axis = Instance(made["axis"])
    seen = []

    def step(r, y):
        axis.step(r_n=r, y_n=y)
        seen.append(axis.get("u_n"))
        return seen[-1]

    on, rows = axis_run(step, 3 * PERIOD)
    off, _ = axis_run(plain_pi(), 3 * PERIOD)
    assert off > 10 * on, (off, on)
    assert seen == own("axis", [(*row, 1.9) for row in rows])
    breakaway = 1.2 * (0.007 + 0.3 * 0.5)
    assert axis.get("low_positive_n") < breakaway < axis.get("high_positive_n")
    assert (axis.get("share"), axis.get("bad_inputs"), axis.get("warnings")) == (1, 0, 0)


def test_a_joint_loses_its_friction_with_the_librarys_bits(made, own):
    assert validate_fmu(str(made["joint"])) == []
    joint = Instance(made["joint"])
    seen = []

    def step(effort, q_ref, q):
        joint.step(effort=effort, q_ref=q_ref, q=q)
        seen.append(joint.get("u"))
        return seen[-1]

    on, rows = joint_run(step)
    off, _ = joint_run(lambda effort, _q_ref, _q: min(max(effort, -1), 1))
    assert off > 2.5 * on, (off, on)
    assert seen == own("joint", rows)
    now = joint.seen()
    assert now["is_learned"] == 1 and now["friction_low"] < 0.1 < now["friction_high"] and now["cause"] == 0
    assert now["force_low"] < now["force"] < now["force_high"]


def test_parameters_have_the_configs_names_units_ranges_and_starts(made):
    for part, name, expected in (("axis", "positive.offset_n", ("N", "1e-06", "1000000.0", "0.007", "tunable")),
                                 ("axis", "sample_time_s", ("s", "1e-06", "0.1", "0.001", "fixed")),
                                 ("joint", "gain", (None, "0.0", "1.0", "0.9", "tunable")),
                                 ("joint", "travel", (None, "1e-09", "1000000.0", repr(4 / 8192), "fixed"))):
        variable = next(x for x in fmpy.read_model_description(str(made[part])).modelVariables if x.name == name)
        unit = variable.unit or (variable.declaredType.unit if variable.declaredType else None)
        assert (unit, variable.min, variable.max, variable.start, variable.variability) == expected
        assert variable.description


@pytest.mark.parametrize(("part", "values", "text"), [
    ("axis", {"u_max_n": float("nan")}, "u_max_n: nan is outside 0 to 1e+06"),
    ("axis", {"positive__offset_n": 0.0}, "positive.offset_n: 0 is outside 1e-06 to 1e+06"),
    ("joint", {"gain": 1.5}, "gain: 1.5 is outside 0 to 1"),
    ("joint", {"travel": float("inf")}, "travel: inf is outside 1e-09 to 1e+06"),
])
def test_a_value_outside_its_range_is_refused_with_its_name(made, part, values, text):
    door = Instance(made[part], start=False)
    with pytest.raises(FMICallException):
        door.set(**values)
    assert text in door.said[-1]
    door.slave.start()  # nothing has changed


@pytest.mark.parametrize(("part", "values", "text"), [
    ("axis", {"ki_per_s": 1e5}, "kp, ki_per_s: kp 1e-6 to 1e5"),
    ("axis", {"u_min_n": 0.0, "u_max_n": 0.0}, "u_max_n"),
    ("joint", {"breakaway": 2.0}, "breakaway: 0 to effort_max"),
    ("joint", {"actuator_pole_rad_per_s": 1e-5}, "actuator_pole_rad_per_s: 1e-3 to 1e6"),
])
def test_values_that_do_not_go_together_are_refused_at_the_start(made, part, values, text):
    door = Instance(made[part], start=False)
    door.set(**values)
    with pytest.raises(FMICallException):
        door.slave.start()
    assert text in door.said[-1]
    with pytest.raises(FMICallException):
        door.step()
    assert "it has not started" in door.said[-1]


def test_inputs_that_are_no_numbers_are_counted(made):
    axis, joint = Instance(made["axis"]), Instance(made["joint"])
    for bad in (float("nan"), float("inf"), -1e300):
        axis.step(r_n=bad, y_n=0.1)
        joint.step(effort=bad, q_ref=0.0, q=0.0)
        assert abs(axis.get("u_n")) <= 2 and abs(joint.get("u")) <= 1
    assert (axis.get("bad_inputs"), joint.get("bad_inputs")) == (3, 3)
    assert int(axis.get("warnings")) & 1


def test_a_running_axis_is_tuned_with_the_librarys_bits(made, own):
    axis = Instance(made["axis"])
    tunings = {2000: (1.5,), 2001: (1.0, 0.9), 2500: (1.9,), 2501: (1.2,)}  # in a row, and twice before a tick
    seen, gains, kp = [], [], 1.9

    def step(r, y):
        nonlocal kp
        for kp in tunings.get(len(seen), ()):
            axis.set(kp=float(numpy.float32(kp)))
        gains.append(kp)
        axis.step(r_n=r, y_n=y)
        seen.append(axis.get("u_n"))
        return seen[-1]

    _, rows = axis_run(step, 4000)
    assert seen == own("axis", [(*row, kp) for row, kp in zip(rows, gains, strict=True)])
    assert max(abs(b - a) for a, b in zip(seen[1500:], seen[1501:])) < 0.01
    with pytest.raises(FMICallException):
        axis.set(ki_per_s=99_000.0)
    assert "kp, ki_per_s" in axis.said[-1] and axis.get("ki_per_s") == 110
    with pytest.raises(FMICallException):
        axis.set(sample_time_s=2e-3)
    assert "sample_time_s: cannot be set once it has started" in axis.said[-1]


def test_a_joint_that_is_reversed_comes_back_by_restore(made):
    joint = Instance(made["joint"], start=False)
    joint.set(breakaway=0.1, travel=4.0)
    joint.slave.start()
    for stroke in range(10):
        way = 1 if stroke % 2 == 0 else -1
        for i in range(400):
            q = i if way > 0 else 400 - i
            joint.step(effort=-0.2 * way, q_ref=q + way, q=q)
    assert (joint.get("cause"), joint.get("share")) == (3, 0)
    joint.step(effort=0.0, restore=1.0)
    assert joint.get("cause") == 0


def play(door, part, count):
    seen = []
    for tick in range(count):
        wave = 0.3 * math.sin(0.01 * tick)
        door.step(**({"r_n": 0.5 + wave, "y_n": 0.4 + wave} if part == "axis" else {"effort": wave, "q_ref": wave, "q": 0.9 * wave}))
        seen.append(door.seen())
    return seen


@pytest.mark.parametrize("part", ["axis", "joint"])
def test_a_state_goes_to_another_instance_and_another_process(made, part, tmp_path):
    one, other = Instance(made[part]), Instance(made[part])
    play(one, part, 1500)
    one.set(**({"kp": 1.2} if part == "axis" else {"gain": 0.5}))  # not yet in a tick
    state = one.slave.save()
    carried = one.slave.to_bytes(state)
    later = play(one, part, 700)
    other.slave.load(other.slave.from_bytes(carried))
    one.fmu.freeInstance()  # nothing of it is used any more
    assert play(other, part, 700) == later
    (tmp_path / "state").write_bytes(bytes(carried))
    there = ("import pathlib, sys, test_doors as t; path, part, state = sys.argv[1:]; door = t.Instance(pathlib.Path(path));"
             "door.slave.load(door.slave.from_bytes(pathlib.Path(state).read_bytes())); print(t.play(door, part, 700))")
    done = subprocess.run([sys.executable, "-B", "-c", there, made[part], part, tmp_path / "state"], cwd=Path(__file__).parent, check=True,
                          capture_output=True, text=True)
    assert done.stdout.strip() == str(later)


@pytest.mark.parametrize(("fields", "options", "text"), [
    ({"sample_time_s": 1e-3}, (), "--part joint needs --set effort_max=NUMBER, 1e-06 to 1e+06: limit of |u|"),
    (JOINT | {"friction": 1}, (), "--set friction: --part joint has sample_time_s, effort_max, travel, breakaway"),
    (JOINT | {"gain": 2}, (), "--set gain=2: outside 0 to 1"),
    (JOINT | {"gain": float("nan")}, (), "--set gain=nan: outside 0 to 1"),
    (JOINT | {"gain": "much"}, (), "a number is expected, 0 to 1"),
    (JOINT, ("--q31",), "--q31 is for the loop"),
    (JOINT, (ROOT / "host_sim/scenarios/triangle.yaml",), "--part joint takes no scenario, but --set FIELD=NUMBER"),
])
def test_a_config_that_is_not_whole_makes_no_file(tmp_path, fields, options, text):
    done = subprocess.run(command("joint", fields, tmp_path / "joint.fmu", *options), capture_output=True, text=True, check=False)
    assert done.returncode != 0 and text in done.stderr and not (tmp_path / "joint.fmu").exists()
