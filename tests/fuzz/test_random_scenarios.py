"""300 random scenarios from end to end: each runs, and then all that it writes is finite, or is refused in one line."""

import json
import math
import os
import pathlib
import random
import subprocess

import pytest

SEED = int(os.environ.get("TRIBO_SEED", "20240214"))
SCENARIOS = 300

SECTIONS = "controller.sections"
TABLE = "breakaway.table"


def keys():
    text = subprocess.run([os.environ["TRIBO_SIM"], "list", "--keys"], capture_output=True, text=True, check=True).stdout
    return [line.split(" | ") for line in text.splitlines()]


def number(rng, low, high, default):
    """Mostly near the default; else anywhere in the range, by size, or at an end of it."""
    how = rng.random()
    if how < 0.7 and default != "-":
        return min(max(float(default) * math.exp(rng.gauss(0, 0.7)), low), high)
    if how < 0.78:
        return rng.choice((low, high))
    sizes = [abs(end) for end in (low, high) if end] + [rng.choice((1e-9, 1e-37))]
    size = math.exp(rng.uniform(math.log(min(sizes)), math.log(max(sizes))))
    return min(max(rng.choice((-1, 1)) * size, low), high)


def value(rng, kind, allowed, default):
    if kind in ("a number", "a whole number"):
        low, high = map(float, allowed.split(" to "))
        x = number(rng, low, high, default)
        return str(int(x)) if kind == "a whole number" else f"{x:.9g}"
    if kind == "text":
        return rng.choice(("''", "r.csv", "none.csv"))
    return rng.choice(kind.replace(" or ", ", ").split(", "))


def scenario(rng, table):
    """--set options in random number. A step of the plant is at least a thousandth of a sample, for the time it takes."""
    chosen = {"duration_s": f"{rng.uniform(0.01, 0.3):.3g}", "reference.kind": rng.choice(("triangle", "sine", "step", "ramp",
              "sawtooth", "chirp", "csv")), "reference.file": "r.csv"}
    for key, kind, allowed, default in table:
        if "[]" in key or kind == "a list" or key in ("duration_s", "plant.step_s", "sample_time_s"):
            continue
        if rng.random() < 0.08:
            chosen[key] = value(rng, kind, allowed, default)
    if rng.random() < 0.3:
        form = rng.choice(("z", "delta"))
        section = {name: rng.uniform(-1, 1) for name in ("b1", "b2", "a1", "a2")} | {"b0": rng.choice((1e-3, 1, 50))}
        if form == "delta":
            section |= {"a1": rng.uniform(0, 1), "a2": rng.uniform(0, 0.3)}
        chosen |= {"controller.kind": form, SECTIONS: "[{" + ", ".join(f"{k}: {v:.6g}" for k, v in section.items()) + "}]"}
        sample_time = rng.choice((1e-4, 5e-4, 1e-3, 1e-2))
        chosen |= {"sample_time_s": f"{sample_time:g}", "plant.step_s": f"{sample_time / rng.choice((1, 4, 10, 100)):g}"}
    elif rng.random() < 0.3:
        chosen["plant.step_s"] = rng.choice(("0.001", "0.0005", "0.00001"))
    return chosen


def refuse_constant(text):
    raise AssertionError(f"{text} in JSON")


@pytest.mark.parametrize("part", range(10))
def test_random_scenarios(tmp_path, part):
    table = keys()
    rng = random.Random(SEED * 10 + part)
    (tmp_path / "r.csv").write_text("t_s,r_N\n0,0.1\n0.1,0.5\n0.2,-0.3\n", encoding="ascii")
    ran = 0
    for index in range(SCENARIOS // 10):
        options = [word for key, text in scenario(rng, table).items() if key != "arithmetic" for word in ("--set", f"{key}={text}")]
        arith = rng.choice(("f32", "q31", "both"))
        (tmp_path / "x.yaml").write_text("{}\n", encoding="ascii")
        out = tmp_path / str(index)
        result = subprocess.run([os.environ["TRIBO_SIM"], "run", "x.yaml", *options, "--arith", arith, "--out", out], cwd=tmp_path,
                                capture_output=True, text=True, timeout=600, check=False)
        about = f"seed {SEED}, part {part}, scenario {index}: {' '.join(options)} --arith {arith}"
        assert result.returncode in (0, 1), about
        if result.returncode == 1:
            assert result.stderr.startswith("tribo-sim: ") and result.stderr.count("\n") == 1, about
            assert not list(out.glob("*")) or "was a bad input in" in result.stderr, about  # then they are there to see it
            continue
        ran += 1
        json.loads((out / "summary.json").read_text(encoding="ascii"), parse_constant=refuse_constant)
        for trace in out.glob("trace*.csv"):
            numbers = trace.read_text(encoding="ascii").split("\n", maxsplit=1)[1].replace(",", " ").split()
            assert all(math.isfinite(float(x)) for x in numbers), about
    assert ran >= SCENARIOS // 40  # if nearly all were refused, this would show nothing
