"""`list`: scenarios, keys, parameters."""

import os
import re

import pytest

from conftest import SCENARIOS

NAMES = sorted(path.stem for path in SCENARIOS.glob("*.yaml"))


def keys(sim):
    """key -> (type, range, default)"""
    lines = [line.split(" | ") for line in sim.ok("list", "--keys").splitlines()]
    return {line[0]: tuple(line[1:]) for line in lines}


def test_list_shows_every_scenario_with_its_description(sim):
    lines = sim.ok("list").splitlines()
    assert [line.split()[0] for line in lines] == NAMES
    assert all(len(line.split()) > 3 for line in lines)


def test_list_shows_what_is_wrong_with_a_scenario(sim):
    sim.write("broken.yaml", "foo: 1\n")
    sim.write("good.yaml", "description: fine\n")
    sim.write("other.txt", "")
    text = sim.ok("list", env={**os.environ, "TRIBO_SCENARIOS": str(sim.folder)})
    assert text == f"broken          {sim.folder}/broken.yaml:1: unknown key foo\ngood            fine\n"


def test_list_without_a_folder(sim):
    sim.fails("/none: cannot be read: No such file or directory", "list", env={**os.environ, "TRIBO_SCENARIOS": "/none"})


@pytest.mark.parametrize("name", NAMES)
def test_every_scenario_runs_by_its_name(sim, name):
    summary = sim.summary(name)
    assert summary["ticks"] > 0
    assert summary["bad_inputs"] == 0
    assert 0 < summary["rms_error_N"] <= summary["max_error_N"] < 0.3


def test_a_name_is_found_in_the_chosen_folder_and_a_file_goes_first(sim):
    environment = {**os.environ, "TRIBO_SCENARIOS": str(sim.folder / "mine")}
    (sim.folder / "mine").mkdir()
    sim.write("mine/own.yaml", "duration_s: 0.002\nreference: {kind: step}\n")
    for name in ("own", "own.yaml"):
        assert "(limited" in sim.ok("run", name, env=environment)
    sim.fails(f"triangle: there is no such file, and no such scenario in {sim.folder / 'mine'} (tribo-sim list shows them)", "run",
              "triangle", env=environment)
    sim.write("own", "duration_s: 0.004\nreference: {kind: step}\n")
    assert "ticks                     4 " in sim.ok("run", "own", env=environment)


def test_the_tables_have_every_key_with_its_range_and_default(sim):
    rows = {}
    for line in sim.ok("list", "--markdown").splitlines():
        match = re.match(r"\| `([^`]+)` \| ([^|]*) \| ([^|]*) \| ([^|]*) \| (.*) \|$", line)
        if match:
            rows[match[1]] = match.groups()[1:]
    program = keys(sim)
    assert set(rows) == set(program)
    for key, (kind, allowed, default) in program.items():
        unit, table_range, table_default, meaning = rows[key]
        words = {"text": "text", "a list": "list"}.get(kind, allowed if allowed != "-" else kind)
        assert (key, table_range, table_default) == (key, words, default)
        assert len(meaning) > 5
        suffix = re.search(r"_(N|s|Hz|deg|rad_per_s|deg_per_s|N_per_s|N_s2_per_deg|N_s_per_deg|N_per_deg|N_m)$", key)
        assert (unit != "-") == bool(suffix), key


def test_parameters_have_the_keys_ranges_and_defaults_of_a_scenario(sim):
    rows = [line.strip("| ").split(" | ") for line in sim.ok("list", "--parameters").splitlines() if line.startswith("| `")]
    program = keys(sim)
    assert len(rows) > 40
    assert len({field for field, *_ in rows}) > 40
    for _, key, _, allowed, default, *_ in rows:
        if key != "-":
            assert program[key.strip("`")][1:] in ((allowed, default), (allowed, "-")), key


def test_the_tables_say_what_each_truth_model_is(sim):
    table = re.search(r"\| `plant.model` \| what \|\n\|---\|---\|\n((?:\|.*\n)*)", sim.ok("list", "--markdown"))[1]
    assert re.findall(r"\| `(\w+)` \| .{10,} \|\n", table) == re.split(", | or ", keys(sim)["plant.model"][0])


def test_every_number_has_a_range(sim):
    for key, (kind, allowed, _) in keys(sim).items():
        assert (allowed != "-") == (kind in ("a number", "a whole number")), key
