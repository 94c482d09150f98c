"""Keywords: what they mean, what a part has, and what an editor knows of them."""

import inspect
import pathlib
import subprocess
import sys

import pytest

import tribo
from tribo import _core

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "python"))
import keywords  # noqa: E402

PARTS = keywords.PARTS
CALLED = [tribo.run, *PARTS]
SHORT = {"duration_s": 0.2, "metrics.start_s": 0}


def test_a_keyword_of_a_loop_is_no_plants():
    assert tribo.Loop(offset_N=0.02).steps([0.1] * 50, 0.0).tolist() == tribo.Loop(None, {"compensator.friction.breakaway.offset_N": 0.02}).steps([0.1] * 50, 0.0).tolist()
    with pytest.raises(tribo.ScenarioError, match="several keys end with this name.*compensator.*plant"):
        tribo.run("triangle", SHORT, offset_N=0.02)


def test_every_short_name_of_a_loops_key_is_clear_or_its_own_twin():
    """What only a plant has too is clear."""
    for path, row in _core.KEYS.items():
        name = path.rpartition(".")[2]
        twins = [other for other in _core.KEYS if other.rpartition(".")[2] == name and other.startswith(tribo.Loop._within) and "[" not in other and _core.KEYS[other].type != "group"]
        if path in twins and len(twins) == 1:
            assert _core.full_key(name, tribo.Loop._groups, tribo.Loop._within) == path


@pytest.mark.parametrize("name", ["none", "force"])
def test_sensor_is_the_loops_word_and_the_plants_group(name):
    assert tribo.run("triangle", SHORT, sensor=name).u_N.tolist() == tribo.run("triangle", {**SHORT, "compensator.sensor": name}).u_N.tolist()
    tribo.Loop(sensor=name)
    noisy = tribo.run("triangle", SHORT, sensor="{noise_N: 0.001, noise_seed: 7}")
    assert noisy.y_N.tolist() != tribo.run("triangle", SHORT).y_N.tolist()


def test_a_keyword_that_the_part_has_not_is_refused():
    for part, name in ((tribo.Friction, "gain"), (tribo.Loop, "amplitude_N"), (tribo.Guard, "k_min"), (tribo.Loop, "noise_N"), (tribo.Loop, "no_such")):
        with pytest.raises(tribo.ScenarioError, match=f"unknown key {name}"):
            part(**{name: 1.0})


@pytest.mark.parametrize("function", CALLED, ids=lambda function: function.__name__)
def test_the_signature_has_every_keyword_and_each_is_taken(function):
    parameters = inspect.signature(function).parameters
    named = {name: row for name, row in parameters.items() if row.kind == inspect.Parameter.KEYWORD_ONLY and name not in ("arith", "decimate")}
    assert len(named) > 5 and not any(row.kind == inspect.Parameter.VAR_KEYWORD for row in parameters.values())
    for name, row in named.items():
        groups, within = getattr(function, "_groups", ()), getattr(function, "_within", ("",))
        key = _core.full_key(name, groups, within)
        assert key in _core.KEYS and row.annotation == _core.annotation_of(_core.KEYS[key])
        if key in _core.PARAMETERS and function is not tribo.run:
            try:
                function(**{name: _core.PARAMETERS[key].default})
            except tribo.ScenarioError as refused:
                assert "unknown key" not in str(refused)


def test_signatures_have_what_users_type():
    assert {"gain", "method", "duration_s", "sensor", "noise_N"} <= set(inspect.signature(tribo.run).parameters)
    assert {"offset_N", "gain", "method", "sensor", "u_max_N", "k_min"} <= set(inspect.signature(tribo.Loop).parameters)
    assert inspect.signature(tribo.Loop).parameters["method"].annotation == 'Literal["paper", "feedforward", "off"]'
    assert "offset_N: 'float' = Ellipsis" in str(inspect.signature(tribo.Friction)) or "offset_N: float = Ellipsis" in str(inspect.signature(tribo.Friction))


def test_the_keywords_file_is_that_of_the_table():
    """Make it again: python/keywords.py says how."""
    assert (ROOT / "python/tribo/_keywords.py").read_text(encoding="utf-8") == keywords.text()


def test_a_type_checker_knows_them(tmp_path):
    good = tmp_path / "good.py"
    good.write_text("""import tribo
run = tribo.run("triangle", gain=0.9, method="paper", sensor="none", on=True)
loop = tribo.Loop(offset_N=0.02, sensor="none", arith="q31")
hub = tribo.Friction("triangle", {"k_min": 5}, offset_N=0.01)
error_N: float = tribo.FeedForward(actuator_pole_rad_per_s=150).error(0.5, 0.4)
""", encoding="utf-8")
    bad = tmp_path / "bad.py"
    bad.write_text("""import tribo
tribo.run("triangle", gian=0.9)
tribo.run("triangle", gain="much")
tribo.Loop(method="papr")
tribo.Loop(amplitude_N=1.0)
""", encoding="utf-8")
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", good, bad], capture_output=True, text=True, check=False, cwd=tmp_path)
    lines = [line for line in done.stdout.splitlines() if "error:" in line]
    assert [line.split(":")[1] for line in lines] == ["2", "3", "4", "5"] and all(line.startswith("bad.py") for line in lines), done.stdout
