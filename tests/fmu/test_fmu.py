"""FMUs have the bits of the simulator's own runner; what they refuse, and what they remember."""

import ctypes
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
try:
    import fmpy
    import numpy
    from fmpy import fmi2
    from fmpy.fmi1 import FMICallException
    from fmpy.validation import validate_fmu
except ImportError as error:
    pytest.skip(f"needs fmpy ({error}): tools/setup fmu", allow_module_level=True)

COLUMNS = os.environ["TRIBO_COLUMNS"]
TICK_S = 1e-3


def make(folder, scenario, part, *options):
    out = folder / f"{part}.fmu"
    subprocess.run([sys.executable, "-B", ROOT / "tools/tribo-fmu", scenario, "--part", part, *options, "--out", out], check=True)
    return out


def scenario_of(folder, name, text=""):
    """A scenario of the tree, 5 s long, with more keys."""
    lines = (ROOT / f"host_sim/scenarios/{name}.yaml").read_text(encoding="utf-8").splitlines()
    path = folder / "scenario.yaml"
    kept = [re.sub(r"(start_s|duration_s): .*", lambda match: f"{match[1]}: {5 if 'd' in match[1] else 0}", line) for line in lines]
    for group in re.findall(r"^\w+:\n(?: .*\n)+", text, flags=re.M):
        head, *keys = group.splitlines()
        at = kept.index(head) if head in kept else len(kept)
        kept[at:at + 1] = [head, *keys]
    path.write_text("\n".join(kept) + "\n", encoding="utf-8")
    return path


def columns_of(scenario, *options):
    done = subprocess.run([COLUMNS, scenario, *options], check=True, capture_output=True)
    names, data = done.stdout.split(b"\n", 1)
    names = names.decode().split(",")
    return dict(zip(names, numpy.frombuffer(data).reshape(len(names), -1), strict=True))


class Instance:
    """An FMU that has been started."""

    def __init__(self, path, start=True):
        self.said = []
        self.description = fmpy.read_model_description(str(path))
        self.reference = {variable.name: variable.valueReference for variable in self.description.modelVariables}
        self.type = {variable.name: variable.type for variable in self.description.modelVariables}
        self.outputs = [variable.name for variable in self.description.modelVariables if variable.causality == "output"]
        self.numbers = [name for name in self.outputs if self.type[name] == "Real"]
        self.flags = [name for name in self.outputs if self.type[name] == "Boolean"]
        self.folder = fmpy.extract(str(path))
        co = self.description.coSimulation
        self.fmu = fmi2.FMU2Slave(guid=self.description.guid, unzipDirectory=self.folder, modelIdentifier=co.modelIdentifier, instanceName="one")
        self.callbacks = fmi2.fmi2CallbackFunctions()
        self.callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(lambda _environment, _name, _status, _category, text: self.said.append(text.decode()))
        fmi2.addLoggerProxy(ctypes.byref(self.callbacks))
        self.fmu.instantiate(callbacks=self.callbacks)
        self.time_s = 0.0
        if start:
            self.start()

    def start(self):
        self.fmu.setupExperiment()
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def set(self, **values):
        self.fmu.setReal([self.reference[name.replace("__", ".")] for name in values], list(values.values()))

    def get(self, name):
        return self.fmu.getReal([self.reference[name]])[0]

    def step(self, **values):
        self.set(**values)
        self.fmu.doStep(self.time_s, TICK_S)
        self.time_s += TICK_S

    def seen(self):
        """All outputs."""
        numbers = self.fmu.getReal([self.reference[name] for name in self.numbers])
        flags = self.fmu.getBoolean([self.reference[name] for name in self.flags])
        return dict(zip(self.numbers + self.flags, [*numbers, *map(float, flags)], strict=True))


@pytest.mark.parametrize(("name", "text"), [("triangle", ""), ("asymmetric", ""), ("noisy", "")])
def test_loop_has_the_same_bits(tmp_path, name, text):
    scenario = scenario_of(tmp_path, name, text)
    path = make(tmp_path, scenario, "loop")
    assert validate_fmu(str(path)) == []
    run = columns_of(scenario)
    loop = Instance(path)
    assert set(loop.outputs) <= set(run) and {"u_N", "limited", "f_hat_N"} <= set(loop.outputs)
    for k in range(len(run["t_s"])):
        loop.step(r_N=run["r_N"][k], y_N=run["y_N"][k])
        assert loop.seen() == {name: run[name][k] for name in loop.outputs}, k


@pytest.fixture(scope="module")
def triangle(tmp_path_factory):
    """The loop of the triangle and its run."""
    folder = tmp_path_factory.mktemp("triangle")
    scenario = scenario_of(folder, "triangle")
    return make(folder, scenario, "loop"), columns_of(scenario)


def play(loop, run, first, last):
    outputs = []
    for k in range(first, last):
        loop.step(r_N=run["r_N"][k], y_N=run["y_N"][k])
        outputs.append(loop.seen())
    return outputs


def test_parameters_have_units_ranges_and_starts(triangle):
    variables = {variable.name: variable for variable in fmpy.read_model_description(str(triangle[0])).modelVariables}
    offset = variables["compensator.friction.breakaway.offset_N"]
    assert (offset.unit, offset.min, offset.max, offset.start, offset.variability) == ("N", "1e-06", "1000000.0", "0.007", "tunable")
    assert variables["limits.u_max_N"].variability == "fixed"
    assert variables["compensator.gain"].unit is None


def test_a_value_set_before_the_start_is_the_scenarios(tmp_path):
    plain = make(tmp_path, scenario_of(tmp_path, "triangle"), "loop")
    run = columns_of(scenario_of(tmp_path, "triangle", "compensator:\n  feedforward:\n    trust: 0.25\n"))
    loop = Instance(plain, start=False)
    loop.set(compensator__feedforward__trust=0.25)
    loop.start()
    assert loop.get("compensator.feedforward.trust") == 0.25
    outputs = play(loop, run, 0, 3000)
    assert [row["u_N"] for row in outputs] == list(run["u_N"][:3000])


def test_a_loop_goes_on_when_it_is_tuned(triangle):
    path, run = triangle
    loop, other = Instance(path), Instance(path)
    play(loop, run, 0, 2000)
    before = play(other, run, 0, 2001)[-1]
    for belief in (0.05, 0.06, 0.07):  # more than once between two ticks
        loop.set(compensator__friction__breakaway__offset_N=belief)
    assert loop.get("compensator.friction.breakaway.offset_N") == 0.07
    after = play(loop, run, 2000, 2001)[-1]
    assert abs(after["u_N"] - before["u_N"]) < 0.01
    assert play(loop, run, 2001, 2200) != play(other, run, 2001, 2200)


@pytest.mark.parametrize(("values", "text"), [
    ({"compensator__friction__k_max": 5.0}, "compensator.friction.k_min: friction k_min"),
    ({"compensator__gain": 3.0}, "compensator.gain: 3 is outside 0 to 2"),
    ({"compensator__gain": float("nan")}, "compensator.gain: nan is outside 0 to 2"),
    ({"compensator__gain": 0.5, "compensator__friction__k_min": 21.0}, "compensator.friction.k_min: friction k_min"),
])
def test_a_refusal_says_why_and_changes_nothing(triangle, values, text):
    path, run = triangle
    other, loop = Instance(path), Instance(path)  # fmpy's logger is that of the last instance
    play(loop, run, 0, 100)
    with pytest.raises(FMICallException):
        loop.set(**values)
    assert text in loop.said[-1]
    assert loop.get("compensator.gain") == 0.85
    assert play(loop, run, 100, 200) == play(other, run, 0, 200)[100:]


def test_a_refusal_at_the_start(triangle):
    loop = Instance(triangle[0], start=False)
    loop.set(compensator__friction__k_min=21.0)
    with pytest.raises(FMICallException):
        loop.start()
    assert "compensator.friction.k_min: friction k_min" in loop.said[-1]


@pytest.mark.parametrize("step_s", [0.0, 0.0005, 0.0015, -1e-3, float("nan")])
def test_a_step_of_no_whole_ticks_is_refused(triangle, step_s):
    loop = Instance(triangle[0])
    with pytest.raises(FMICallException):
        loop.fmu.doStep(0.0, step_s)
    assert "is not a multiple of sample_time_s, 0.001 s" in loop.said[-1]


def test_a_state_is_saved_and_restored_and_survives_bytes(triangle):
    path, run = triangle
    loop, other = Instance(path), Instance(path)
    play(loop, run, 0, 1000)
    loop.set(compensator__feedforward__trust=0.3)  # not yet in a tick
    state = loop.fmu.getFMUstate()
    later = play(loop, run, 1000, 1500)
    loop.fmu.setFMUstate(state)
    assert play(loop, run, 1000, 1500) == later
    carried = other.fmu.deSerializeFMUstate(loop.fmu.serializeFMUstate(state))
    other.fmu.setFMUstate(carried)
    loop.fmu.freeInstance()  # nothing of it is used any more
    assert other.get("compensator.feedforward.trust") == 0.3
    assert play(other, run, 1000, 1500) == later


def test_instances_do_not_know_of_each_other(triangle):
    path, run = triangle
    alone, one, two = Instance(path), Instance(path), Instance(path)
    expected = play(alone, run, 0, 300)
    got = []
    for k in range(300):
        got += play(one, run, k, k + 1)
        two.step(r_N=-0.3, y_N=0.1)
    assert got == expected


def test_a_reset_loop_starts_anew(triangle):
    path, run = triangle
    loop = Instance(path)
    first = play(loop, run, 0, 300)
    loop.set(compensator__gain=0.5)
    loop.fmu.reset()
    loop.start()
    assert loop.get("compensator.gain") == 0.85
    assert play(loop, run, 0, 300) == first


def test_the_same_fmu_comes_out_twice(tmp_path, triangle):
    again = make(tmp_path, scenario_of(tmp_path, "triangle"), "loop")
    assert again.read_bytes() == triangle[0].read_bytes()


def test_a_refused_scenario_leaves_no_file(tmp_path):
    scenario = scenario_of(tmp_path, "triangle", "limits:\n  u_max_N: -1\n")
    out = tmp_path / "loop.fmu"
    done = subprocess.run([sys.executable, "-B", ROOT / "tools/tribo-fmu", scenario, "--part", "loop", "--out", out], capture_output=True, text=True)
    assert done.returncode != 0 and "limits.u_max_N: -1 is outside 0 to 1e+06" in done.stderr and not out.exists()


@pytest.mark.parametrize(("name", "text"), [
    ("triangle", ""),
    ("asymmetric", ""),
    ("noisy", ""),
    ("triangle", "plant:\n  model: lugre\n"),
    ("triangle", "plant:\n  model: bristle\nsensor:\n  delay_s: 0.0005\n"),
    ("triangle", "plant:\n  model: servo_mx64\n"),
])
def test_loop_and_plant_in_a_circle_have_the_same_bits(tmp_path, name, text):
    scenario = scenario_of(tmp_path, name, text)
    path = make(tmp_path, scenario, "plant")
    assert validate_fmu(str(path)) == []
    run = columns_of(scenario)
    loop, plant = Instance(make(tmp_path, scenario, "loop")), Instance(path)
    before = ("y_N", "F_N")
    for k in range(len(run["t_s"])):
        read = {output: plant.get(output) for output in before}
        loop.step(r_N=run["r_N"][k], y_N=read["y_N"])
        plant.step(u_N=loop.get("u_N"))
        seen = plant.seen() | loop.seen() | read
        assert seen == {output: run[output][k] for output in seen}, k


@pytest.mark.parametrize("model", ["paper", "bristle", "maxwell_slip"])
def test_a_plants_state_is_saved_and_restored_and_survives_bytes(tmp_path, model):
    scenario = scenario_of(tmp_path, "noisy", f"plant:\n  model: {model}\n")
    run = columns_of(scenario)["u_N"]
    path = make(tmp_path, scenario, "plant")

    def forced(plant, first, last):
        seen = []
        for k in range(first, last):
            plant.step(u_N=run[k])
            seen.append(plant.seen())
        return seen

    plant, other = Instance(path), Instance(path)
    forced(plant, 0, 1000)
    state = plant.fmu.getFMUstate()
    later = forced(plant, 1000, 1500)
    plant.fmu.setFMUstate(state)
    assert forced(plant, 1000, 1500) == later
    forced(other, 0, 7)
    carried = other.fmu.deSerializeFMUstate(plant.fmu.serializeFMUstate(state))
    other.fmu.setFMUstate(carried)
    plant.fmu.freeInstance()
    assert forced(other, 1000, 1500) == later


def test_a_plants_parameters_are_fixed(tmp_path):
    plant = Instance(make(tmp_path, scenario_of(tmp_path, "triangle"), "plant"), start=False)
    plant.set(plant__friction__breakaway__slope=0.4)
    plant.start()
    with pytest.raises(FMICallException):
        plant.set(plant__friction__breakaway__slope=0.3)
    assert "plant.friction.breakaway.slope: cannot be set once the plant has started" in plant.said[-1]
    with pytest.raises(FMICallException):
        plant.set(u_N=float("nan"))
    assert plant.get("plant.friction.breakaway.slope") == 0.4


def test_a_compensator_has_the_bits_of_that_in_the_papers_loop(tmp_path):
    scenario = scenario_of(tmp_path, "triangle", "compensator:\n  method: paper\n")
    path = make(tmp_path, scenario, "compensator")
    assert validate_fmu(str(path)) == []
    run = columns_of(scenario)
    compensator = Instance(path)
    for k in range(len(run["t_s"])):
        compensator.step(u_N=run["u_N"][k])
        assert compensator.seen() == {output: run[output][k] for output in compensator.outputs}, k
