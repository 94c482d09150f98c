"""FMUs have the bits of the simulator's own runner; what they refuse, and what they remember."""

import csv
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
    from fmpy import fmi2, fmi3
    from fmpy.build import build_platform_binary
    from fmpy.fmi1 import FMICallException
    from fmpy.validation import validate_fmu
except ImportError as error:
    pytest.skip(f"needs fmpy ({error}): tools/setup fmu", allow_module_level=True)

sys.path.insert(0, str(ROOT / "tests" / "support"))
import foreign_process  # noqa: E402

SIM, COLUMNS = os.environ["TRIBO_SIM"], os.environ["TRIBO_COLUMNS"]
TICK_S = 1e-3

# The importer of the crate of this name, which tools/setup fmi-sim builds.
FMI_SIM_VERSION = "0.7.0"
FMI_SIM = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / f"tribo/fmi-sim-{FMI_SIM_VERSION}/bin/fmi-sim"


@pytest.fixture(scope="module", params=[2, 3])
def fmi(request):
    """FMI's version."""
    return request.param


def make(folder, scenario, part, fmi, *options):
    out = folder / f"{part}.fmu"
    subprocess.run([sys.executable, "-B", ROOT / "tools/tribo-fmu", scenario, "--part", part, "--fmi", str(fmi), *options, "--out", out], check=True)
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
    _digest, names, data = done.stdout.split(b"\n", 2)
    names = names.decode().split(",")
    return dict(zip(names, numpy.frombuffer(data).reshape(len(names), -1), strict=True))


class Slave2:
    """What FMI 2.0 calls by other names than FMI 3.0."""

    def __init__(self, said, **which):
        self.fmu = fmi2.FMU2Slave(**which)
        self.callbacks = fmi2.fmi2CallbackFunctions()
        self.callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(lambda _environment, _name, _status, _category, text: said.append(text.decode()))
        fmi2.addLoggerProxy(ctypes.byref(self.callbacks))
        self.fmu.instantiate(callbacks=self.callbacks)
        self.get, self.set, self.flags = self.fmu.getReal, self.fmu.setReal, self.fmu.getBoolean
        self.save, self.load = self.fmu.getFMUstate, self.fmu.setFMUstate
        self.to_bytes, self.from_bytes = self.fmu.serializeFMUstate, self.fmu.deSerializeFMUstate

    def start(self):
        self.fmu.setupExperiment()
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()


class Slave3:
    def __init__(self, said, logs=True, **which):
        self.fmu = fmi3.FMU3Slave(**which)
        self.fmu.instantiate(loggingOn=logs, logMessage=lambda _environment, _status, _category, text: said.append(text.decode()))
        self.get, self.set, self.flags = self.fmu.getFloat64, self.fmu.setFloat64, self.fmu.getBoolean
        self.save, self.load = self.fmu.getFMUState, self.fmu.setFMUState
        self.to_bytes, self.from_bytes = self.fmu.serializeFMUState, self.fmu.deserializeFMUState

    def start(self, start_s=0.0):
        self.fmu.enterInitializationMode(startTime=start_s)
        self.fmu.exitInitializationMode()


class Instance:
    """An FMU, or a folder that it was unpacked into, that has been started. Those of one file share what is loaded."""

    def __init__(self, path, start=True, guid=None, **options):
        self.said = []
        self.description = fmpy.read_model_description(str(path))
        variables = self.description.modelVariables
        self.reference = {variable.name: variable.valueReference for variable in variables}
        outputs = [variable for variable in variables if variable.causality == "output"]
        self.outputs = [variable.name for variable in outputs]
        self.numbers = [variable.name for variable in outputs if variable.type in ("Real", "Float64")]
        self.flags = [variable.name for variable in outputs if variable.type == "Boolean"]
        folder = path if path.is_dir() else path.with_suffix("")
        if not folder.exists():
            fmpy.extract(str(path), str(folder))
        kind = Slave2 if self.description.fmiVersion == "2.0" else Slave3
        self.slave = kind(self.said, guid=guid or self.description.guid, unzipDirectory=str(folder),
                          modelIdentifier=self.description.coSimulation.modelIdentifier, instanceName="one", **options)
        self.fmu = self.slave.fmu
        self.time_s = 0.0
        if start:
            self.slave.start()

    def set(self, **values):
        self.slave.set([self.reference[name.replace("__", ".")] for name in values], list(values.values()))

    def get(self, name):
        return self.slave.get([self.reference[name]])[0]

    def step(self, **values):
        self.set(**values)
        self.fmu.doStep(self.time_s, TICK_S)
        self.time_s += TICK_S

    def seen(self):
        """All outputs."""
        numbers = self.slave.get([self.reference[name] for name in self.numbers])
        flags = self.slave.flags([self.reference[name] for name in self.flags])
        return dict(zip(self.numbers + self.flags, [*numbers, *map(float, flags)], strict=True))


@pytest.mark.parametrize("name", ["triangle", "asymmetric", "noisy"])
def test_loop_has_the_same_bits(tmp_path, fmi, name):
    scenario = scenario_of(tmp_path, name)
    path = make(tmp_path, scenario, "loop", fmi)
    assert validate_fmu(str(path)) == []
    run = columns_of(scenario)
    loop = Instance(path)
    assert set(loop.outputs) <= set(run) and {"u_N", "limited", "f_hat_N"} <= set(loop.outputs)
    for k in range(len(run["t_s"])):
        loop.step(r_N=run["r_N"][k], y_N=run["y_N"][k])
        assert loop.seen() == {name: run[name][k] for name in loop.outputs}, k


@pytest.fixture(scope="module")
def triangle(tmp_path_factory, fmi):
    """The loop of the triangle and its run."""
    folder = tmp_path_factory.mktemp("triangle")
    scenario = scenario_of(folder, "triangle")
    return make(folder, scenario, "loop", fmi), columns_of(scenario)


def play(loop, run, first, last):
    outputs = []
    for k in range(first, last):
        loop.step(r_N=run["r_N"][k], y_N=run["y_N"][k])
        outputs.append(loop.seen())
    return outputs


def test_parameters_have_units_ranges_and_starts(triangle):
    variables = {variable.name: variable for variable in fmpy.read_model_description(str(triangle[0])).modelVariables}
    offset = variables["compensator.friction.breakaway.offset_N"]
    unit = offset.unit or offset.declaredType.unit
    assert (unit, offset.min, offset.max, offset.start, offset.variability) == ("N", "1e-06", "1000000.0", "0.007", "tunable")
    assert variables["limits.u_max_N"].variability == "fixed"
    assert variables["compensator.gain"].unit is variables["compensator.gain"].declaredType is None


def test_a_value_set_before_the_start_is_the_scenarios(tmp_path, triangle):
    plain, _ = triangle
    run = columns_of(scenario_of(tmp_path, "triangle", "compensator:\n  feedforward:\n    trust: 0.25\n"))
    loop = Instance(plain, start=False)
    loop.set(compensator__feedforward__trust=0.25)
    loop.slave.start()
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
        loop.slave.start()
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
    state = loop.slave.save()
    later = play(loop, run, 1000, 1500)
    loop.slave.load(state)
    assert play(loop, run, 1000, 1500) == later
    carried = other.slave.from_bytes(loop.slave.to_bytes(state))
    other.slave.load(carried)
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


def test_a_reset_loop_starts_again(triangle):
    path, run = triangle
    loop = Instance(path)
    first = play(loop, run, 0, 300)
    loop.set(compensator__gain=0.5)
    loop.fmu.reset()
    loop.slave.start()
    assert loop.get("compensator.gain") == 0.85
    assert play(loop, run, 0, 300) == first


def test_the_same_fmu_comes_out_twice(tmp_path, fmi, triangle):
    again = make(tmp_path, scenario_of(tmp_path, "triangle"), "loop", fmi)
    assert again.read_bytes() == triangle[0].read_bytes()


def test_tribo_sim_makes_the_same_fmu(tmp_path, fmi):
    scenario = scenario_of(tmp_path, "triangle")
    expected = make(tmp_path, scenario, "loop", fmi, "--q31").read_bytes()
    made = tmp_path / "made.fmu"
    subprocess.run([SIM, "fmu", "scenario", "--part", "loop", f"--fmi={fmi}", "--arith=q31", "--out", made], check=True,
                   env={**os.environ, "TRIBO_SCENARIOS": str(tmp_path)})
    assert made.read_bytes() == expected


def test_a_scenario_is_not_replaced_by_its_fmu(tmp_path):
    scenario = scenario_of(tmp_path, "triangle")
    before = scenario.read_bytes()
    done = subprocess.run([sys.executable, "-B", ROOT / "tools/tribo-fmu", scenario, "--part", "plant", "--out", scenario], capture_output=True, text=True)
    assert done.returncode == 1 and f"--out {scenario} is the same file as the scenario" in done.stderr and scenario.read_bytes() == before


def test_a_refused_scenario_leaves_no_file(tmp_path):
    scenario = scenario_of(tmp_path, "triangle", "limits:\n  u_max_N: -1\n")
    out = tmp_path / "loop.fmu"
    done = subprocess.run([sys.executable, "-B", ROOT / "tools/tribo-fmu", scenario, "--part", "loop", "--out", out], capture_output=True, text=True)
    assert done.returncode != 0 and "limits.u_max_N: -1 is outside 0 to 1e+06" in done.stderr and not out.exists()


@pytest.mark.parametrize(("name", "text", "arithmetic"), [
    ("triangle", "", []),
    ("asymmetric", "", []),
    ("noisy", "", []),
    ("triangle", "plant:\n  model: lugre\n", []),
    ("triangle", "plant:\n  model: bristle\nsensor:\n  delay_s: 0.0005\n", []),
    ("triangle", "plant:\n  model: servo_mx64\n", []),
    ("triangle", "", ["q31"]),
    ("noisy", "compensator:\n  method: paper\n", ["q31"]),
])
def test_loop_and_plant_in_a_circle_have_the_same_bits(tmp_path, fmi, name, text, arithmetic):
    scenario = scenario_of(tmp_path, name, text)
    path = make(tmp_path, scenario, "plant", fmi)
    assert validate_fmu(str(path)) == []
    run = columns_of(scenario, *arithmetic)
    loop, plant = Instance(make(tmp_path, scenario, "loop", fmi, *(f"--{word}" for word in arithmetic))), Instance(path)
    before = ("y_N", "F_N")
    for k in range(len(run["t_s"])):
        read = {output: plant.get(output) for output in before}
        loop.step(r_N=run["r_N"][k], y_N=read["y_N"])
        plant.step(u_N=loop.get("u_N"))
        seen = plant.seen() | loop.seen() | read
        if arithmetic:  # u, whose bits the plant needs, has more digits than its column
            seen["u_N"] = float(numpy.float32(seen["u_N"]))
        assert seen == {output: run[output][k] for output in seen}, k


@pytest.mark.parametrize("model", ["paper", "bristle", "maxwell_slip"])
def test_a_plants_state_is_saved_and_restored_and_survives_bytes(tmp_path, fmi, model):
    scenario = scenario_of(tmp_path, "noisy", f"plant:\n  model: {model}\n")
    run = columns_of(scenario)["u_N"]
    path = make(tmp_path, scenario, "plant", fmi)

    def forced(plant, first, last):
        seen = []
        for k in range(first, last):
            plant.step(u_N=run[k])
            seen.append(plant.seen())
        return seen

    plant, other = Instance(path), Instance(path)
    forced(plant, 0, 1000)
    state = plant.slave.save()
    later = forced(plant, 1000, 1500)
    plant.slave.load(state)
    assert forced(plant, 1000, 1500) == later
    forced(other, 0, 7)
    carried = other.slave.from_bytes(plant.slave.to_bytes(state))
    other.slave.load(carried)
    plant.fmu.freeInstance()
    assert forced(other, 1000, 1500) == later


def test_a_plants_parameters_are_fixed(tmp_path, fmi):
    plant = Instance(make(tmp_path, scenario_of(tmp_path, "triangle"), "plant", fmi), start=False)
    plant.set(plant__friction__breakaway__slope=0.4)
    plant.slave.start()
    with pytest.raises(FMICallException):
        plant.set(plant__friction__breakaway__slope=0.3)
    assert "plant.friction.breakaway.slope: cannot be set once the plant has started" in plant.said[-1]
    with pytest.raises(FMICallException):
        plant.set(u_N=float("nan"))
    assert plant.get("plant.friction.breakaway.slope") == 0.4


def test_a_compensator_has_the_bits_of_that_in_the_papers_loop(tmp_path, fmi):
    scenario = scenario_of(tmp_path, "triangle", "compensator:\n  method: paper\n")
    path = make(tmp_path, scenario, "compensator", fmi)
    assert validate_fmu(str(path)) == []
    run = columns_of(scenario)
    compensator = Instance(path)
    for k in range(len(run["t_s"])):
        compensator.step(u_N=run["u_N"][k])
        assert compensator.seen() == {output: run[output][k] for output in compensator.outputs}, k


def test_an_fmu_is_not_for_another_description(triangle):
    with pytest.raises(Exception, match="nstantiate"):
        Instance(triangle[0], guid="0" * 32)


def test_its_sources_make_the_same_bits(tmp_path, triangle):
    path, run = triangle
    fmpy.extract(str(path), str(tmp_path / "built"))
    for made in (tmp_path / "built/binaries").rglob("*.so"):
        made.unlink()
    build_platform_binary(tmp_path / "built", generator="Ninja")
    assert play(Instance(tmp_path / "built"), run, 0, 3000) == play(Instance(path), run, 0, 3000)


@pytest.fixture(scope="module")
def triangle3(tmp_path_factory):
    folder = tmp_path_factory.mktemp("triangle3")
    return make(folder, scenario_of(folder, "triangle"), "loop", 3)


def test_fmi_3_has_all_functions_and_no_others(triangle3):
    header = (Path(fmpy.__file__).parent / "c-code/fmi3Functions.h").read_text(encoding="utf-8")
    Instance(triangle3)
    library = triangle3.with_suffix("") / "binaries/x86_64-linux/tribo_fmu.so"
    symbols = subprocess.run(["nm", "-D", "--defined-only", library], check=True, capture_output=True, text=True).stdout
    assert sorted(re.findall(r"^FMI3_Export fmi3\w+TYPE +(fmi3\w+);", header, flags=re.M)) == sorted(re.findall(r" T (\w+)$", symbols, flags=re.M))


def test_fmi_3_knows_the_time(triangle3):
    loop = Instance(triangle3, start=False)
    loop.slave.start(7.0)
    assert loop.get("time") == 7.0
    loop.fmu.doStep(7.0, TICK_S)
    state = loop.slave.save()
    assert loop.fmu.doStep(7.0 + TICK_S, 2 * TICK_S) == (False, False, False, 7.0 + TICK_S + 2 * TICK_S)
    assert loop.get("time") == 7.0 + TICK_S + 2 * TICK_S
    loop.slave.load(state)
    assert loop.get("time") == 7.0 + TICK_S


def test_fmi_3_logs_nothing_unless_logging_is_on(triangle3):
    loop = Instance(triangle3, logs=False)
    for categories, texts in ((["logEvents"], 0), (["logStatusError"], 1), ([], 2)):
        loop.fmu.setDebugLogging(True, categories)
        with pytest.raises(FMICallException):
            loop.set(compensator__gain=3.0)
        assert len(loop.said) == texts


def imported(path, fmi, inputs, *options):
    """What fmi-sim's outputs are after each tick with these inputs; the first row is that before the first."""
    count = len(next(iter(inputs.values())))
    # Of FMI 2.0 it applies what was there just before a tick, of FMI 3.0 what is there from then on; the last row is only the end.
    times = [(k - 0.5 if fmi == 2 else k) * TICK_S for k in range(count + 1)]
    rows = zip(times, *(map(float, [*values, values[-1]]) for values in inputs.values()), strict=True)
    path.with_name("inputs.csv").write_text("".join(",".join(map(str, row)) + "\n" for row in (("time", *inputs), *rows)), encoding="utf-8")
    out = path.with_name("outputs.csv")
    subprocess.run([FMI_SIM, "--model", path, "-i", path.with_name("inputs.csv"), "-o", out, "co-simulation", "-f", str(count * TICK_S),
                    "--output-interval", str(TICK_S), *options], check=True, capture_output=True)
    with open(out, encoding="utf-8", newline="") as lines:
        return [{name: float({"true": 1, "false": 0}.get(text, text)) for name, text in row.items() if name != "time"} for row in csv.DictReader(lines)]


@pytest.mark.skipif(not FMI_SIM.exists(), reason=f"needs fmi-sim {FMI_SIM_VERSION}: tools/setup fmi-sim")
@pytest.mark.parametrize(("part", "text", "inputs", "before", "values"), [
    ("loop", "", ("r_N", "y_N"), (), {}),
    ("loop", "limits:\n  u_max_N: 0.45\n", ("r_N", "y_N"), (), {"limits.u_max_N": 0.45}),
    ("plant", "", ("u_N",), ("y_N", "F_N"), {}),
    ("compensator", "compensator:\n  method: paper\n", ("u_N",), (), {}),
])
def test_another_importer_has_the_same_bits(tmp_path, fmi, part, text, inputs, before, values):
    path = make(tmp_path, scenario_of(tmp_path, "triangle", "" if values else text), part, fmi)
    run = columns_of(scenario_of(tmp_path, "triangle", text))
    seen = imported(path, fmi, {name: run[name] for name in inputs}, *(f"--init-values={key}={value}" for key, value in values.items()))
    assert len(seen) == len(run["t_s"]) + 1 and len(seen[0]) > len(inputs)
    for k, (row, after) in enumerate(zip(seen, seen[1:], strict=False)):
        assert after | {name: row[name] for name in before} == {name: run[name][k] for name in after}, k


@pytest.fixture(scope="module")
def locales(tmp_path_factory):
    folder = tmp_path_factory.mktemp("locales")
    why = foreign_process.make_locales(folder)
    if why:
        pytest.skip(f"no locale with a decimal comma: {why}")
    return folder


@pytest.mark.parametrize("name", foreign_process.COMMA)
def test_an_importer_with_a_decimal_comma(triangle, locales, name):
    path, run = triangle
    plain = play(Instance(path), run, 0, 200)
    with foreign_process.in_locale(locales, name):
        loop = Instance(path)
        assert play(loop, run, 0, 200) == plain
        with pytest.raises(FMICallException):
            loop.set(compensator__gain=2.5)
        assert "compensator.gain: 2.5 is outside 0 to 2" in loop.said[-1]
        with pytest.raises(FMICallException):
            loop.fmu.doStep(0.0, 0.0015)
        assert "0.0015 s is not a multiple of sample_time_s, 0.001 s" in loop.said[-1]


@pytest.mark.skipif(foreign_process.UPWARD is None, reason="its number for the direction of rounding is not known")
def test_an_importer_that_rounds_otherwise(triangle, tmp_path, fmi):
    path, run = triangle
    plant = make(tmp_path, scenario_of(tmp_path, "noisy"), "plant", fmi)

    def force():
        instance = Instance(plant)
        for _ in range(200):
            instance.step(u_N=0.3)
        return instance.seen()

    plain = play(Instance(path), run, 0, 200), force()
    with foreign_process.rounding_upward():
        assert (play(Instance(path), run, 0, 200), force()) == plain


def test_nothing_is_linked_that_acts_on_the_whole_process(triangle):
    Instance(triangle[0])
    library = next(triangle[0].with_suffix("").rglob("*.so"))
    done = subprocess.run(["nm", "-D", "--undefined-only", library], capture_output=True, text=True, check=True)
    names = {re.sub(r"@.*|^__|_chk(@.*)?$", "", line.split()[-1]) for line in done.stdout.splitlines()}
    assert "memcpy" in names and not names & foreign_process.ACTS_ON_THE_PROCESS
