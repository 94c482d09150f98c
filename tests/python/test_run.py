"""tribo.run against tribo-sim (its path is in TRIBO_SIM): the same bits."""

import dataclasses
import json
import math
import os
import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest

import tribo
from tribo import _run

SIM = os.environ["TRIBO_SIM"]
LEAST = {"duration_s": 0.1, "reference.kind": "step"}


def played(folder, scenario, *words):
    """What tribo-sim leaves of the same run: the text of its traces, and its summary."""
    subprocess.run([SIM, "run", scenario, *map(str, words), "--out", folder], check=True, capture_output=True)
    return [path.read_text() for name in ("trace.csv", "trace_q31.csv") if (path := pathlib.Path(folder) / name).exists()], json.loads((pathlib.Path(folder) / "summary.json").read_text())


def as_csv(run):
    """The trace as tribo-sim writes it: nine digits are all of a float."""
    rows = zip(*(column.astype(float) for column in run.values()))
    return ",".join(run) + "\n" + "".join(",".join(f"{value:.9g}" for value in row) + "\n" for row in rows)


def test_the_readme_runs_as_it_stands(tmp_path):
    block = re.search(r"```python\n(.*?)```", (pathlib.Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8"), re.DOTALL).group(1)
    said = subprocess.run([sys.executable, "-c", block], cwd=tmp_path, check=True, capture_output=True, text=True).stdout.splitlines()
    assert 0.9e-4 < float(said[0]) < 1.15e-4 and said[1].endswith(" sound")
    assert (tmp_path / "run.png").stat().st_size > 10_000


def test_the_defaults_lack_what_the_page_says():
    said = re.search(r"`None` for the defaults, which lack `(\S+)` and\s+`(\S+)`\.", (pathlib.Path(__file__).parents[2] / "docs/python.md").read_text(encoding="utf-8"))
    assert set(said.groups()) == set(LEAST)
    for key in LEAST:
        with pytest.raises(tribo.ScenarioError, match=f"{key}: is missing"):
            tribo.run(None, {other: value for other, value in LEAST.items() if other != key})
    assert tribo.run(None, LEAST).summary.max_error_N > 0


@pytest.mark.parametrize("arith", ["f32", "q31"])
@pytest.mark.parametrize("scenario, keys", [("triangle", {"gain": 0.9, "method": "paper"}), ("noisy", {}), ("asymmetric", {"plant.friction.breakaway.slope": 0.25})])
def test_a_run_has_the_bits_of_tribo_sim(tmp_path, scenario, keys, arith):
    full = {"gain": "compensator.gain", "method": "compensator.method"}
    words = [word for key, value in keys.items() for word in ("--set", f"{full.get(key, key)}={value}")]
    (trace,), summary = played(tmp_path, scenario, "--arith", arith, *words)
    run = tribo.run(scenario, {key: value for key, value in keys.items() if "." in key}, arith=arith, **{key: value for key, value in keys.items() if "." not in key})
    assert as_csv(run) == trace
    found = {key: value for key, value in dataclasses.asdict(run.summary).items() if key in summary}
    for timing in ("wall_s", "real_time_factor"):
        found[timing] = summary[timing]
    assert found == summary


def test_the_scenario_says_the_arithmetic_unless_the_call_does():
    f32, q31, as_said, called = (tribo.run("triangle", {"metrics.start_s": 0, **keys}, duration_s=0.5, arith=arith)
                                 for keys, arith in (({}, None), ({}, "q31"), ({"arithmetic": "q31"}, None), ({"arithmetic": "q31"}, "f32")))
    assert as_csv(as_said) == as_csv(q31) != as_csv(f32) == as_csv(called)


def test_both_arithmetics_side_by_side(tmp_path):
    (f32, q31), summary = played(tmp_path, "triangle", "--arith", "both", "--set", "duration_s=3", "--set", "metrics.start_s=1")
    run = tribo.run("triangle", {"metrics.start_s": 1}, duration_s=3, arith="both")
    assert as_csv(run) == f32
    assert as_csv(run.q31) == q31
    assert dataclasses.asdict(run.summary.difference) == summary["difference"]
    assert run.q31.summary.rms_error_N == summary["q31"]["rms_error_N"] == run.summary.q31.rms_error_N
    assert not np.array_equal(run.u_N, run.q31.u_N)


def test_columns_are_arrays_by_name_and_attribute():
    run = tribo.run("step", {"metrics.start_s": 0}, duration_s=1)
    assert run.u_N is run["u_N"] and run.u_N.dtype == np.float64 and run.limited.dtype == bool
    assert len(run.t_s) == run.summary.ticks == 1000
    assert "plant_L_N" in dir(run)
    with pytest.raises(AttributeError, match="its columns are t_s, r_N"):
        run.nothing


def test_a_path_and_no_scenario_at_all(tmp_path):
    path = tmp_path / "mine.yaml"
    path.write_text("duration_s: 0.1\nreference: {kind: step}\n")
    assert as_csv(tribo.run(path)) == as_csv(tribo.run(None, LEAST)) == as_csv(tribo.run(str(path)))


def test_lists_choices_and_switches_are_values(tmp_path):
    sections = [{"b0": 1.5, "b1": 0.5, "b2": 0.05, "a1": 0.3, "a2": 0.01}]
    keys = LEAST | {"controller.kind": "delta", "controller.sections": sections, "compensator.guard.on": False, "sensor.noise_N": np.float32(0.001), "sensor.noise_seed": np.int64(7)}
    run = tribo.run(None, keys)
    assert run.summary.guard is None
    assert run.controller_N[0] == np.float32(1.5) * np.float32(run.e_N[0])
    assert not np.array_equal(run.y_N, tribo.run(None, keys | {"sensor.noise_seed": 8}).y_N)


def test_a_group_is_a_mapping():
    parts = {"compensator": {"method": "paper", "friction": {"k_min": 7, "k_max": 21.5}}, "sensor": {"noise_N": 0.001}}
    assert as_csv(tribo.run(None, LEAST | parts)) == as_csv(tribo.run(None, LEAST | {"compensator.method": "paper", "compensator.friction.k_min": 7, "compensator.friction.k_max": 21.5, "sensor.noise_N": 0.001}))


@pytest.mark.parametrize("keys, field, words", [
    ({"gain": 3}, "compensator.gain", "compensator.gain: 3 is outside 0 to 2"),
    ({"compensator.gian": 1}, "compensator.gian", "did you mean compensator.gain?"),
    ({"nonsense": 1}, "nonsense", "unknown key nonsense"),
    ({5: 1}, None, "5: the name of a key is expected"),
    ({"compensator": {"gain": 5.0}}, "compensator", "compensator.gain: 5 is outside 0 to 2"),
    ({"method": None}, "compensator.method", "compensator.method: None is not a number, a word, a mapping or a list of these"),
    ({"plant": {"step_s": b"1"}}, "plant", "plant: b'1' is not a number"),
    ({"controller.sections": [1.0]}, "controller.sections", "controller.sections[0]: a mapping is expected here"),
    ({"k_min": 7}, "k_min", "several keys end with this name, give one of them in a dict: compensator.friction.k_min, plant.friction.k_min"),
    ({"plant.step_s": 3e-4}, None, "must divide sample_time_s without a remainder"),
])
def test_a_refusal_names_the_key(keys, field, words):
    with pytest.raises(tribo.ScenarioError) as refused:
        tribo.run("triangle", keys)
    assert words in str(refused.value) and "--set" not in str(refused.value)
    assert refused.value.field == field
    assert not isinstance(refused.value, tribo.StatusError)


@pytest.mark.parametrize("keys, arith, bounds", [({"duration_s": 86400}, None, (10_000, 40_000)), ({"duration_s": 86400}, "both", (5_000, 20_000)),
                                                 ({"duration_s": 86400, "compensator.method": "off"}, None, (10_000, 60_000)),
                                                 ({"duration_s": 300, "sample_time_s": 1e-5, "plant.step_s": 1e-5, "controller": {"kind": "pi", "kp": 1.0, "ki_per_s": 1.0}, "compensator.method": "off", "compensator.friction.pulse_width_s": 1e-4}, None, (100, 400))])
def test_a_run_whose_trace_would_fill_the_memory_is_refused(monkeypatch, keys, arith, bounds):
    monkeypatch.setattr(_run, "TRACE_BYTES_MAX", 4 << 30)
    with pytest.raises(tribo.ScenarioError) as refused:
        tribo.run("step", keys, arith=arith)
    found = re.match(rf"duration_s: {keys['duration_s']} is outside {keys.get('sample_time_s', 0.001):g} to ([\d.]+): a trace of \d+ rows takes ([\d.]+) GB of memory, more than 4.29 GB; decimate=(\d+) keeps fewer rows$", str(refused.value))
    assert found and bounds[0] < float(found[1]) < bounds[1] and refused.value.field == "duration_s"
    assert float(found[2]) / 4.295 == pytest.approx(keys["duration_s"] / float(found[1]), rel=0.05) and int(found[3]) == math.ceil(keys["duration_s"] / float(found[1]))


def test_the_longest_run_that_a_refusal_names_is_taken(monkeypatch):
    keys = {"metrics.start_s": 0}
    columns = len(tribo.run("step", keys, duration_s=1))
    monkeypatch.setattr(_run, "TRACE_BYTES_MAX", 8 * columns * 1000 + 7)
    assert len(tribo.run("step", keys, duration_s=1).t_s) == 1000
    for arith, words in ((None, "1.001 is outside 0.001 to 1: a trace of 1001 rows takes .*decimate=2 "), ("both", "1.001 is outside 0.001 to 0.5: .*decimate=3 ")):
        with pytest.raises(tribo.ScenarioError, match=words):
            tribo.run("step", keys, duration_s=1.001, arith=arith)
    assert len(tribo.run("step", keys, duration_s=0.5, arith="both").t_s) == 500
    with pytest.raises(tribo.ScenarioError, match="0.501 is outside 0.001 to 0.5: a trace of 501 rows"):
        tribo.run("step", keys, duration_s=0.501, arith="both")
    monkeypatch.setattr(_run, "TRACE_BYTES_MAX", 8 * columns * 12345)
    with pytest.raises(tribo.ScenarioError, match=r"duration_s: 60 is outside 0.001 to 37.035: "):
        tribo.run("step", keys, duration_s=60, decimate=3)
    assert len(tribo.run("step", keys, duration_s=37.035, decimate=3).t_s) == 12345
    monkeypatch.setattr(_run, "TRACE_BYTES_MAX", 8 * columns * 1000 + 7)
    assert len(tribo.run("step", keys, duration_s=1.001, decimate=2).t_s) == 501
    assert len(tribo.run("step", keys, duration_s=1.001, decimate=3, arith="both").q31.t_s) == 334


@pytest.mark.parametrize("every", [1, 7, 1000, 10**18])
def test_decimate_keeps_the_first_of_so_many_rows(tmp_path, every):
    (trace, trace_q31), _ = played(tmp_path, "triangle", "--arith", "both", "--set", "duration_s=3", "--set", "metrics.start_s=1", "--decimate", every)
    run, whole = (tribo.run("triangle", {"metrics.start_s": 1}, duration_s=3, arith="both", decimate=n) for n in (every, 1))
    assert as_csv(run) == trace and as_csv(run.q31) == trace_q31
    assert run.summary.rms_error_N == whole.summary.rms_error_N and len(run.t_s) == -(-3000 // every)


@pytest.mark.parametrize("value", [0, -1, 1.5, "2", True, None, 2**63])
def test_a_useless_decimate_is_named(value):
    with pytest.raises(ValueError, match=re.escape(f"decimate={value!r}: a whole number from 1 to 9223372036854775807 is expected")):
        tribo.run("step", decimate=value)


def test_the_librarys_refusal_of_a_run_is_a_status():
    with pytest.raises(tribo.StatusError) as refused:
        tribo.run("triangle", {"compensator.friction.pulse_width_s": 0.1})
    assert (refused.value.status, refused.value.field) == ("PULSE_WIDTH", "compensator.friction.pulse_width_s")


@pytest.mark.parametrize("keys, keywords", [({"compensator.gain": 1, "gain": 0.5}, {}), ({"compensator.gain": 1}, {"gain": 0.5}), ({"gain": 1}, {"gain": 0.5})])
def test_a_key_that_is_given_twice_is_refused(keys, keywords):
    with pytest.raises(tribo.ScenarioError, match="^compensator.gain: is given twice: 1 and 0.5$") as refused:
        tribo.run("step", keys, **keywords)
    assert refused.value.field == "compensator.gain"


def test_a_scenario_that_is_not_there():
    with pytest.raises(tribo.ScenarioError, match="nowhere: there is no such file, and no such scenario in"):
        tribo.run("nowhere")


def test_scenarios_are_those_of_tribo_sim(monkeypatch, tmp_path):
    said = subprocess.run([SIM, "list"], capture_output=True, text=True, check=True).stdout
    assert tribo.scenarios() == sorted(line.split()[0].removesuffix(".yaml") for line in said.splitlines() if line[:1].isalpha())
    (tmp_path / "own.yaml").write_text("duration_s: 0.1\nreference: {kind: step}\n")
    monkeypatch.setenv("TRIBO_SCENARIOS", str(tmp_path))
    assert tribo.scenarios() == ["own"]
    assert len(tribo.run("own").t_s) == 100


def test_a_scenario_that_cannot_be_looked_at_is_not_absent(tmp_path):
    loop = tmp_path / "loop.yaml"
    loop.symlink_to("loop.yaml")
    with pytest.raises(tribo.ScenarioError, match="loop.yaml: cannot be opened: Too many levels of symbolic links"):
        tribo.run(loop)
