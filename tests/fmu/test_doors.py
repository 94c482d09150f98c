"""FMUs of the library's axis and joint: the bits of its own calls, what they do for an arm and a joint, what they refuse."""

import math
import subprocess
import sys
from pathlib import Path

import pytest

from test_fmu import FMICallException, Instance, fmpy, validate_fmu
import doors
from doors import FULL_SCALE_N, PERIOD, axis_run, joint_run, plain_pi

ROOT = Path(__file__).resolve().parents[2]
AXIS, JOINT = doors.AXIS | doors.PI, doors.JOINT


def command(part, fields, out, *options):
    words = [word for name, value in fields.items() for word in ("--set", f"{name}={value!r}")]
    return [sys.executable, "-B", ROOT / "tools/tribo-fmu", "--part", part, *words, *options, "--out", out]


class Made(dict):
    """FMUs by part, and the library's own calls in their arithmetic."""

    def __init__(self, folder, fmi, is_q31, play):
        super().__init__()
        self.folder, self.is_q31, self.play = folder, is_q31, play
        self.options = (f"--fmi={fmi}", *(["--q31"] if is_q31 else []))

    def make(self, name, part, fields, *options):
        subprocess.run(command(part, fields, self.folder / f"{name}.fmu", *self.options, *options), check=True)
        self[name] = self.folder / f"{name}.fmu"

    def words(self, numbers, full_scale):
        """What the library reads of these numbers."""
        return [doors.q31(x, full_scale) if self.is_q31 else doors.word(x) for x in numbers]

    def numbers(self, words, full_scale):
        return [doors.of_q31(x, full_scale) if self.is_q31 else doors.number(x) for x in words]

    def axis(self, rows, others, *arguments):
        """What the axis makes of rows of forces, each with another number."""
        played = self.play(["axis", *arguments], [[*self.words(row, FULL_SCALE_N), other] for row, other in zip(rows, others, strict=True)])
        return [self.numbers(row, FULL_SCALE_N) for row in played]

    def joint(self, rows, load):
        """What the joint makes of rows of effort, q_ref and q."""
        places = [row[1:] if self.is_q31 else self.words(row[1:], 1) for row in rows]
        played = self.play(["joint"], [[*self.words(row[:1], 1), *place, *self.words([load], 1)] for row, place in zip(rows, places, strict=True)])
        return [self.numbers(row, 1)[0] for row in played]


@pytest.fixture(scope="module")
def plays(tmp_path_factory):
    """The library's own calls, in float32 and in Q31."""
    folder = tmp_path_factory.mktemp("plays")
    return {arithmetic: doors.build(folder, arithmetic == "q31") for arithmetic in ("f32", "q31")}


@pytest.fixture(scope="module", params=[(2, "f32"), (3, "f32"), (3, "q31")], ids=lambda row: f"fmi{row[0]}-{row[1]}")
def made(request, plays, tmp_path_factory):
    """The axis with a PI and the joint."""
    fmi, arithmetic = request.param
    found = Made(tmp_path_factory.mktemp(f"doors{fmi}{arithmetic}"), fmi, arithmetic == "q31", plays[arithmetic])
    found.make("axis", "axis", AXIS)
    found.make("joint", "joint", doors.JOINT_COUNTS if found.is_q31 else JOINT)
    return found


@pytest.fixture(scope="module", params=[(2, "q31"), (3, "f32")], ids=lambda row: f"fmi{row[0]}-{row[1]}")
def others(request, plays, tmp_path_factory):
    """The axis with other controllers."""
    fmi, arithmetic = request.param
    found = Made(tmp_path_factory.mktemp(f"controllers{fmi}{arithmetic}"), fmi, arithmetic == "q31", plays[arithmetic])
    found.make("own", "axis", doors.AXIS, "--controller=own")
    found.make("paper", "axis", doors.AXIS, "--controller=paper")
    found.make("sections", "axis", doors.AXIS | {f"sections[{i}].{name}": x for i, row in enumerate(doors.SECTIONS) for name, x in
                                                 zip(("b0", "b1", "b2", "a1", "a2"), row)}, "--controller=sections")
    return found


def test_an_axis_takes_friction_out_with_the_librarys_bits(made):
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
    assert seen == [u for u, in made.axis(rows, [doors.word(1.9)] * len(rows), "pi")]
    breakaway = 1.2 * (0.007 + 0.3 * 0.5)
    assert axis.get("low_positive_n") < breakaway < axis.get("high_positive_n")
    assert abs(axis.get("breakaway_positive_n") - breakaway) < 0.05 * breakaway and axis.get("travel_n") > 1
    assert (axis.get("share"), axis.get("bad_inputs"), axis.get("warnings")) == (1, 0, 0)


def test_a_joint_loses_its_friction_with_the_librarys_bits(made):
    assert validate_fmu(str(made["joint"])) == []
    joint = Instance(made["joint"])
    seen = []

    def step(effort, q_ref, q):
        joint.step(effort=effort, q_ref=q_ref, q=q)
        seen.append(joint.get("u"))
        return seen[-1]

    on, rows = joint_run(step, made.is_q31)
    off, _ = joint_run(lambda effort, _q_ref, _q: min(max(effort, -1), 1), made.is_q31)
    assert off > 2.5 * on, (off, on)
    assert seen == made.joint(rows, 0.0)
    loaded = Instance(made["joint"])
    for row, expected in zip(rows[:3000], made.joint(rows[:3000], 0.05), strict=True):
        loaded.step(**dict(zip(("effort", "q_ref", "q"), row, strict=True)), load=0.05)
        assert loaded.get("u") == expected
    now = joint.seen()
    assert now["is_learned"] == 1 and now["friction_low"] < 0.1 < now["friction_high"] and now["cause"] == 0
    assert now["force_low"] < now["force"] < now["force_high"]


def test_parameters_have_the_configs_names_units_ranges_and_starts(made):
    for part, name, expected in (("axis", "positive.offset_n", ("N", "1e-06", "1000000.0", "0.007", "tunable")),
                                 ("axis", "sample_time_s", ("s", "1e-06", "0.1", "0.001", "fixed")),
                                 ("joint", "gain", (None, "0.0", "1.0", "0.97", "tunable")),
                                 ("joint", "travel", (None, "1.0", "10000.0", "4.0", "fixed") if made.is_q31 else
                                  (None, "1e-09", "1000000.0", repr(4 / 8192), "fixed"))):
        variable = next(x for x in fmpy.read_model_description(str(made[part])).modelVariables if x.name == name)
        unit = variable.unit or (variable.declaredType.unit if variable.declaredType else None)
        assert (unit, variable.min, variable.max, variable.start, variable.variability) == expected
        assert variable.description


@pytest.mark.parametrize(("part", "values", "text"), [
    ("axis", {"u_max_n": float("nan")}, "u_max_n: nan is outside 0 to 1e+06"),
    ("axis", {"positive__offset_n": 0.0}, "positive.offset_n: 0 is outside 1e-06 to 1e+06"),
    ("joint", {"gain": 1.5}, "gain: 1.5 is outside 0 to 1"),
    ("joint", {"travel": float("inf")}, "travel: inf is outside 1"),
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


def test_inputs_that_are_not_numbers_are_counted(made):
    axis, joint = Instance(made["axis"]), Instance(made["joint"])
    for bad in (float("nan"), float("inf"), -1e300):
        axis.step(r_n=bad, y_n=0.1)
        joint.step(effort=bad, q_ref=0.0, q=0.0)
        assert abs(axis.get("u_n")) <= 2 and abs(joint.get("u")) <= 1
    assert (axis.get("bad_inputs"), joint.get("bad_inputs")) == (3, 2 if made.is_q31 else 3)  # in Q31 a large effort is a limited one
    assert int(axis.get("warnings")) & 1


def test_a_running_axis_is_tuned_with_the_librarys_bits(made):
    axis = Instance(made["axis"])
    tunings = {2000: (1.5,), 2001: (1.0, 0.9), 2500: (1.9,), 2501: (1.2,)}  # in a row, and twice before a tick
    seen, gains, kp = [], [], 1.9

    def step(r, y):
        nonlocal kp
        for kp in tunings.get(len(seen), ()):
            axis.set(kp=doors.single(kp))
        gains.append(kp)
        axis.step(r_n=r, y_n=y)
        seen.append(axis.get("u_n"))
        return seen[-1]

    _, rows = axis_run(step, 4000)
    assert seen == [u for u, in made.axis(rows, map(doors.word, gains), "pi")]
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
    seen, unit = [], 8192 if part == "joint" and door.get("travel") >= 1 else 1
    for tick in range(count):
        wave = 0.3 * math.sin(0.01 * tick)
        door.step(**({"r_n": 0.5 + wave, "y_n": 0.4 + wave} if part == "axis" else {"effort": wave, "q_ref": unit * wave, "q": 0.9 * unit * wave}))
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


def with_own_controller(axis, outputs, reads_at_once):
    """A tick of a master that has the PI: e, u and the excess come at once, or only after a step, so that the PI is a tick late."""
    integral, v = 0.0, 0.0

    def step(r, y):
        nonlocal integral, v
        axis.set(r_n=r, y_n=y)
        if not reads_at_once:
            axis.set(v_n=v)
            axis.step()
        e = axis.get("e_n")
        integral += 0.11 * e
        v = doors.single(1.9 * e + integral + (3 if len(outputs) < PERIOD and len(outputs) % 997 < 5 else 0))  # beyond the limit, too
        if reads_at_once:
            axis.set(v_n=v)
        outputs.append((e, axis.get("u_n"), axis.get("excess_n")))
        if reads_at_once:
            axis.step()
            assert (axis.get("e_n"), axis.get("u_n"), axis.get("excess_n")) == outputs[-1]
        given.append(v)
        return outputs[-1][1]

    given = []
    return step, given


@pytest.mark.parametrize("reads_at_once", [True, False])
def test_a_controller_of_the_masters_has_the_librarys_bits(others, reads_at_once):
    assert validate_fmu(str(others["own"])) == []
    axis, outputs = Instance(others["own"]), []
    step, given = with_own_controller(axis, outputs, reads_at_once)
    on, rows = axis_run(step, 3 * PERIOD)
    off, _ = axis_run(plain_pi(), 3 * PERIOD)
    assert off > 10 * on, (off, on)
    if not reads_at_once:
        given = [0.0, *given[:-1]]
    assert outputs == [tuple(row) for row in others.axis(rows, others.words(given, FULL_SCALE_N), "own")]
    assert min(excess for _, _, excess in outputs) < -1 and axis.get("limited_ticks") > 10


def test_what_is_read_before_a_step_changes_nothing(others):
    axis, other = Instance(others["own"]), Instance(others["own"])
    for door in (axis, other):
        door.step(r_n=0.5, y_n=0.4, v_n=0.2)
    seen = []
    for tick in range(300):
        for _ in range(3):
            axis.set(r_n=0.1, y_n=float("nan"), v_n=-3.0)
            axis.get("u_n")
        inputs = {"r_n": 0.4 + 0.001 * tick, "y_n": 0.4, "v_n": 0.3}
        axis.set(**inputs)
        seen.append((axis.get("e_n"), axis.get("u_n")))
        axis.step()
        other.step(**inputs)
        assert (other.get("e_n"), other.get("u_n")) == seen[-1]
    assert axis.seen() == other.seen() and axis.get("bad_inputs") == 0
    fresh = Instance(others["own"], start=False)
    fresh.set(r_n=0.5, y_n=0.4, v_n=0.3)
    fresh.slave.start()
    ahead = fresh.get("u_n")  # of inputs from before the start
    fresh.step()
    assert ahead == fresh.get("u_n") != 0
    axis.set(r_n=0.2, y_n=0.1, v_n=0.1)
    state = axis.slave.save()
    ahead = axis.get("u_n")
    other.slave.load(other.slave.from_bytes(axis.slave.to_bytes(state)))
    assert other.get("u_n") == ahead


def followed(path):
    """The inputs that each output follows at once."""
    description = fmpy.read_model_description(str(path))
    assert len(description.outputs) == len(Instance(path).outputs)
    assert all(unknown.dependencies == [] for unknown in description.initialUnknowns)
    return {unknown.variable.name: {of.name for of in unknown.dependencies} for unknown in description.outputs if unknown.dependencies}


def test_outputs_with_ones_own_controller_say_which_inputs_they_follow_at_once(others):
    assert followed(others["own"]) == {"e_n": {"r_n", "y_n"}, "u_n": {"r_n", "y_n", "v_n"}, "excess_n": {"r_n", "y_n", "v_n"}}


def test_other_outputs_follow_a_step_alone(made):
    assert followed(made["axis"]) == {} and followed(made["joint"]) == {}


@pytest.mark.parametrize("kind", ["sections", "paper"])
def test_other_controllers_have_the_librarys_bits(others, kind):
    assert validate_fmu(str(others[kind])) == []
    axis, seen, factors = Instance(others[kind]), [], []
    words = [doors.word(x) for row in doors.SECTIONS for x in row] if kind == "sections" else []

    def step(r, y):
        if kind == "sections" and len(seen) in (2000, 3000):
            factor = 0.75 if len(seen) == 2000 else 1.0
            axis.set(**{f"sections[0].{name}": factor * x for name, x in zip(("b0", "b1", "b2"), doors.SECTIONS[0], strict=False)})
        factors.append(0.75 if kind == "sections" and 2000 <= len(seen) < 3000 else 1.0)
        axis.step(r_n=r, y_n=y)
        seen.append(axis.get("u_n"))
        return seen[-1]

    _, rows = axis_run(step, 5000)
    assert seen == [u for u, in others.axis(rows, map(doors.word, factors), kind, *words)] and len(set(seen)) > 1000
    if kind == "sections":
        with pytest.raises(FMICallException):
            axis.set(**{"sections[0].a2": 2.0})
        assert "section" in axis.said[-1]


def test_a_limit_beyond_the_full_scale_is_refused(others):
    axis = Instance(others["own"])
    if others.is_q31:
        assert axis.get("full_scale_n") == FULL_SCALE_N
        with pytest.raises(FMICallException):
            axis.set(u_max_n=9.0)
        assert axis.said[-1]
    else:
        assert "full_scale_n" not in axis.reference


@pytest.mark.parametrize(("fields", "options", "text"), [
    (doors.AXIS, (), "--part axis needs --set kp=NUMBER"),
    (AXIS, ("--controller=own",), "--set kp: --part axis has"),
    (doors.AXIS, ("--controller=sections",), "needs --set sections[0].b0=NUMBER"),
    (doors.AXIS | {"sections[1].b0": 1}, ("--controller=sections",), "needs --set sections[0].b0=NUMBER"),
    (doors.AXIS | {"sections[4].b0": 1}, ("--controller=sections",), "--set sections[4].b0: --part axis has"),
    (AXIS | {"full_scale_n": 8}, (), "--set full_scale_n: --part axis has"),
    (AXIS | {"full_scale_n": 0}, ("--q31",), "--set full_scale_n=0: outside 0.001 to 1e+06"),
])
def test_an_axis_that_is_not_whole_makes_no_file(tmp_path, fields, options, text):
    done = subprocess.run(command("axis", fields, tmp_path / "axis.fmu", *options), capture_output=True, text=True, check=False)
    assert done.returncode != 0 and text in done.stderr and not (tmp_path / "axis.fmu").exists()


@pytest.mark.parametrize(("fields", "options", "text"), [
    ({"sample_time_s": 1e-3}, (), "--part joint needs --set effort_max=NUMBER, 1e-06 to 1e+06: limit of |u|"),
    (JOINT | {"friction": 1}, (), "--set friction: --part joint has sample_time_s, effort_max, travel, breakaway"),
    (JOINT | {"gain": 2}, (), "--set gain=2: outside 0 to 1"),
    (JOINT | {"gain": float("nan")}, (), "--set gain=nan: outside 0 to 1"),
    (JOINT | {"gain": "much"}, (), "a number is expected, 0 to 1"),
    (JOINT, ("--controller=own",), "--controller is for the axis"),
    (JOINT, ("--q31",), "--set travel=0.00048828125: outside 1 to 10000"),
    (JOINT, (ROOT / "host_sim/scenarios/triangle.yaml",), "--part joint takes no scenario, but --set FIELD=NUMBER"),
])
def test_a_config_that_is_not_whole_makes_no_file(tmp_path, fields, options, text):
    done = subprocess.run(command("joint", fields, tmp_path / "joint.fmu", *options), capture_output=True, text=True, check=False)
    assert done.returncode != 0 and text in done.stderr and not (tmp_path / "joint.fmu").exists()
