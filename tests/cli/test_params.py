"""`params`: a loop's params as C, which a program without set-up code steps to the same bits."""

import json
import math
import re
import shutil
import subprocess

import pytest

from conftest import PAPER, ROOT, SHORT, read_csv
from test_command_line import HINT

FIRMWARE = ROOT / "firmware"
ARITHMETICS = ("f32", "q31")

# Each has something that the others have not. Readings and references are multiples of 2^-10 N.
SHARED = """
duration_s: 4
reference: {kind: csv, file: reference.csv}
sensor: {quantisation_N: 0.0009765625, noise_N: 0.02}
"""
LOOPS = {
    "papers": "compensator: {method: paper, guard: {on: no}}\n",
    "lopsided": """
compensator:
  method: paper
  guard: {on: no}
  gain: 1.5
  friction:
    k_min: 4
    k_max: 11
    m: 2
    v0_N_per_s: 5
    breakaway: {offset_N: 0.02, slope: 0.25, negative_offset_N: 0.01, negative_slope: 0.5}
    set_level: 0.5
    reset_level: 0.625
    pulse_width_s: 0.005
    gravity_N: 0.03
  arm: {inertia_N_s2_per_deg: 0.0003, damping_N_s_per_deg: 0.05, stiffness_N_per_deg: 2}
limits: {u_min_N: -1, u_max_N: 0.8, input_max_N: 1.5, full_scale_N: 4}
""",
    "steep": """
compensator:
  method: paper
  guard: {on: no}
  friction:
    v0_N_per_s: 2
    breakaway: {offset_N: 0.02, slope: 1.25, negative_offset_N: 0.01, negative_slope: 1.5}
    reset_level: 0.3
    pulse_width_s: 0.02
""",
    "feedforward": """
compensator: {feedforward: {jump_lead: 0.5, still_time_s: 0}, guard: {on: no}}
""",
    "sensorless": """
compensator: {sensor: none, sensorless: {belief: 0.7}, feedforward: {jump_lead: 0.5}}
""",
    "guarded": """
compensator: {method: paper, gain: 1.5, friction: {breakaway: {offset_N: 0.01, slope: 0.4}}, guard: {on: yes, turn_N: 0.02, stray_N: 0.001, quick_time_s: 0.5}}
""",
    "table": """
compensator:
  method: paper
  guard: {on: no}
  friction:
    v0_N_per_s: 2
    reset_level: 0.4
    breakaway:
      table:
        - {force_N: 0, positive_N: 0.01, negative_N: 0.015}
        - {force_N: 0.25, positive_N: 0.1, negative_N: 0.08}
        - {force_N: 0.5, positive_N: 0.15, negative_N: 0.2}
controller:
  kind: z
  sections:
    - {b0: 1.2, b1: -0.9, b2: 0.2, a1: -1.1, a2: 0.3}
    - {b0: 0.5, b1: 0.1, b2: 0, a1: -0.4, a2: 0}
    - {b0: 1, b1: -0.5, b2: 0.06, a1: -0.7, a2: 0.12}
    - {b0: 0.8, b1: -0.792, b2: 0, a1: -1, a2: 0}
""",
}

STEPPER = """
#include "loop.h"
#include "loop.h"
#include <stdio.h>
#ifdef Q31
#include "tribo/feedforward_q31.h"
#include "tribo/force_loop_q31.h"
typedef int32_t number_t;
#define LOOP(what) tribo_force_loop_q31_##what
#define FEED(what) tribo_feedforward_q31_##what
#define PART(n) ((n) / (double)LOOP_FULL_SCALE_N * 2147483648.0)
#define GIVEN(n) (PART(n) < 2147483647.0 ? (int32_t)PART(n) : INT32_MAX)
#define NEWTON(x) (double)(float)((x) / 2147483648.0 * (double)LOOP_FULL_SCALE_N)
#define FRICTION seen.compensator.friction
#define RATE (double)(float)(FRICTION.rise / 2147483648.0 * (double)LOOP_FULL_SCALE_N / (double)LOOP_SAMPLE_TIME_S)
#define SEEN NEWTON(seen.controller.u), NEWTON(FRICTION.L), RATE, NEWTON(FRICTION.f)
#else
#include "tribo/feedforward_f32.h"
#include "tribo/force_loop_f32.h"
#define LOOP(what) tribo_force_loop_f32_##what
#define FEED(what) tribo_feedforward_f32_##what
#define GIVEN(n) ((float)(n))
#define FRICTION seen.compensator.friction
#define SEEN (double)seen.controller.u_n, (double)FRICTION.L_n, (double)FRICTION.v_n_per_s, (double)FRICTION.f_n
#endif
int main(void)
{
    static LOOP(state_t) state;
    static FEED(memory_t) memory;
    double r, y;
    state.memory = &memory.state.tick;
    if (LOOP(start)(&state, &loop_params, false) != TRIBO_OK)
        return 1;
    while (scanf("%lf,%lf", &r, &y) == 2)
    {
        LOOP(signals_t) seen;
        (void)LOOP(step)(&loop_params, &state, GIVEN(r), GIVEN(y), &seen);
        (void)FEED(learn)(&loop_params, &memory);
        // In single precision, as in a trace.
        printf("%.9g,%.9g,%.9g,%.9g\\n", SEEN);
    }
    return 0;
}
"""


@pytest.fixture(scope="module", name="library")
def _library(tmp_path_factory):
    """The library, compiled once."""
    folder = tmp_path_factory.mktemp("library")
    sources = sorted((ROOT / "lib" / "src").rglob("*.c"))
    subprocess.run(["cc", "-std=c11", "-O1", "-ffp-contract=off", "-c", "-I", ROOT / "lib" / "include", "-I", ROOT / "lib" / "src", *sources],
                   cwd=folder, check=True)
    return sorted(folder.glob("*.o"))


def reference(k):
    """Creeping up and down on one side, to and fro, jumps to more than an input may be, creeping on the other side."""
    if k < 1500:
        return round(1024 * (0.25 + 0.03 * math.sin(k / 250))) / 1024
    if k < 2500:
        return (k // 7 * 37 % 41 - 20) / 64
    if k < 3000:
        return [0.75, -1.5, 1.75, 2.5][k // 20 % 4]
    return round(1024 * (-0.3 + 0.03 * math.sin(k / 150))) / 1024


def syntax(compiler, header, *flags):
    language = "c++" if "++" in compiler else "c"
    return subprocess.run([compiler, "-x", language, "-fsyntax-only", "-pedantic-errors", "-Wall", "-Wextra", "-Wconversion",
                           "-Wshadow", "-Wundef", "-Werror", "-I", ROOT / "lib" / "include", "-include", header, *flags,
                           "/dev/null"], capture_output=True, text=True, check=False)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("loop", LOOPS)
def test_params_are_those_of_a_run(sim, library, loop, arithmetic):
    scenario = sim.write("loop.yaml", SHARED + LOOPS[loop])
    sim.write("reference.csv", "t_s,r_N\n" + "".join(f"{k / 1000},{reference(k)}\n" for k in range(4000)))
    sim.ok("params", scenario, "--arith", arithmetic, "--out", "loop.h")
    summary = json.loads(sim.ok("run", scenario, "--arith", arithmetic, "--out", "run", "--json"))
    assert summary.get("guard") == ("overshoot" if loop == "guarded" else None)
    trace = read_csv(sim.folder / "run" / "trace.csv")
    assert len(set(trace["u_N"])) > 1000

    source = sim.write("stepper.c", STEPPER)
    subprocess.run(["cc", "-std=c11", f"-D{arithmetic.upper()}", "-Wall", "-Wextra", "-Werror", "-I", sim.folder, "-I",
                    ROOT / "lib" / "include", source, *library, "-o", "stepper"], cwd=sim.folder, check=True)
    given = "".join(f"{round(r * 1024) / 1024},{round(y * 1024) / 1024}\n" for r, y in zip(trace["r_N"], trace["y_N"]))
    stepped = subprocess.run([sim.folder / "stepper"], input=given, capture_output=True, text=True, check=True).stdout
    assert [tuple(map(float, line.split(","))) for line in stepped.splitlines()] == list(zip(
        trace["u_N"], trace["L_N"], trace["v_N_per_s"], trace["f_hat_N"]))


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_each_direction_has_its_law(sim, arithmetic):
    header = sim.ok("params", sim.write("loop.yaml", SHORT + LOOPS["lopsided"]), "--arith", arithmetic)
    positive, negative = re.findall(r"\{\.offset\w* = ([^,]*)[uf], \.slope = ([^}]*)[uf]\}", header)
    assert float(positive[0]) == pytest.approx(2 * float(negative[0]), rel=1e-6)
    assert 2 * float(positive[1]) == pytest.approx(float(negative[1]), rel=1e-6)


def test_the_arithmetic_is_the_scenarios_unless_the_command_says_it(sim):
    chosen = {said: sim.ok("params", sim.write("loop.yaml", SHORT), "--arith", said) for said in ARITHMETICS}
    for said, made in (("f32", "f32"), ("q31", "q31"), ("both", "f32")):
        assert sim.ok("params", sim.write("loop.yaml", SHORT + f"arithmetic: {said}\n")) == chosen[made]
    assert sim.ok("params", sim.write("loop.yaml", SHORT + "arithmetic: q31\n"), "--arith", "f32") == chosen["f32"]


@pytest.mark.parametrize("loop, set_level, reset_level", [("papers", 0.75, 0.8), ("lopsided", 0.5, 0.625), ("steep", 0.75, 0.3),
                                                          ("table", 0.75, 0.4)])
def test_the_relays_levels_are_the_scenarios(sim, loop, set_level, reset_level):
    scenario = sim.write("loop.yaml", SHORT + LOOPS[loop])
    for arithmetic, one in (("f32", 1), ("q31", 2**32)):
        header = sim.ok("params", scenario, "--arith", arithmetic)
        levels = re.findall(r"\.(?:set|reset)_level = (.*)[uf],", header)
        assert [float(level) / one for level in levels] == pytest.approx([set_level, reset_level], rel=1e-6)


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("made", ["app/golden", "../tests/target/fed"])
def test_the_firmwares_params_are_what_is_made_of_their_scenario(sim, made, arithmetic):
    written = (FIRMWARE / f"{made}_{arithmetic}.h").read_text(encoding="ascii")
    assert sim.ok("params", FIRMWARE / f"{made}.yaml", "--arith", arithmetic) == written


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
@pytest.mark.parametrize("loop", LOOPS)
def test_a_header_compiles_without_a_warning(sim, loop, arithmetic):
    scenario = sim.write("loop.yaml", SHARED + LOOPS[loop])
    header = sim.folder / "loop.h"
    sim.ok("params", scenario, "--arith", arithmetic, "--out", header)
    wanted = [("cc", "-std=c11"), *((compiler, standard) for compiler in ("c++", "clang++-19") for standard in ("-std=c++11", "-std=c++20"))]
    for compiler, standard in wanted:
        if shutil.which(compiler) is None:
            continue
        result = syntax(compiler, header, standard)
        assert (result.returncode, result.stderr) == (0, "")


@pytest.mark.parametrize("arithmetic", ARITHMETICS)
def test_params_of_another_version_of_the_library_do_not_compile(sim, arithmetic):
    header = sim.write("old.h", re.sub(r"(_VERSION != )\d+", r"\g<1>1", sim.ok("params", "triangle", "--arith", arithmetic)))
    result = syntax("cc", header, "-std=c11")
    assert result.returncode != 0
    assert "made for another version of tribo: run tribo-sim params again" in result.stderr


def test_a_header_names_its_inputs(sim):
    sets = ["compensator.gain=0.5", 'description="one\\\ntwo */ \u202e"']
    header = sim.ok("params", "triangle", "--name", "Knob_2", "--arith", "q31", "--set", sets[0], "--set", sets[1])
    comment = "\n".join(line for line in header.splitlines() if line.startswith("///"))
    assert 'of the force loop "Knob_2" in Q31' in comment
    assert 'scenario     "triangle"' in comment
    assert f'--set        "{sets[0]}"\n' in comment
    assert '--set        "description="one\\?two */ ???""' in comment
    assert "0.001 s" in comment and "2 N is 2^31" in comment and "gain         0.5" in comment
    assert "#ifndef KNOB_2_PARAMS_Q31_H" in header
    assert "static const tribo_force_loop_q31_params_t Knob_2_params = {" in header
    assert re.search(r"^#define KNOB_2_FULL_SCALE_N 2.0+e\+00f$", header, re.M)
    assert syntax("cc", sim.write("knob.h", header), "-std=c11").returncode == 0


def test_the_name_is_the_scenarios(sim):
    scenario = sim.write("my_rig2.yaml", SHORT)
    assert "tribo_force_loop_f32_params_t my_rig2_params = {" in sim.ok("params", scenario)


WRONG_NAMES = ["2nd", "_knob", "a-b", "a b", "", "k\u00e9", "x" * 41, 'a";int b']


@pytest.mark.parametrize("name", WRONG_NAMES)
def test_a_name_that_is_none_in_c(sim, name):
    sim.fails(f"--name {name}: up to 40 letters, digits and _, a letter first" + HINT, "params", "triangle", "--name", name,
              status=2)


def test_a_scenario_that_gives_no_name(sim):
    scenario = sim.write("my-rig.yaml", SHORT)
    sim.fails(f"params: {scenario} is not a name in C: give one with --name" + HINT, "params", scenario, status=2)
    assert "my_rig_params" in sim.ok("params", scenario, "--name", "my_rig")


def test_a_loop_that_does_not_fit_is_refused_and_leaves_what_was_there(sim):
    sim.write("rig.h", "old")
    scenario = sim.write("rig.yaml", SHORT + "limits: {full_scale_N: 1}\n")
    result = sim("params", scenario, "--arith", "q31", "--out", "rig.h")
    assert result.returncode == 1
    assert result.stderr.startswith(f"tribo-sim: {scenario}")
    assert "limits.input_max_N" in result.stderr
    assert (sim.folder / "rig.h").read_text(encoding="ascii") == "old"
    assert sorted(path.name for path in sim.folder.iterdir()) == ["rig.h", "rig.yaml"]


def test_the_full_scale_is_the_float_that_it_was_made_with(sim):
    header = sim.ok("params", "triangle", "--arith", "q31", "--set", "limits.full_scale_N=4.7927491663886475")
    assert "TRIANGLE_FULL_SCALE_N 4.79274893e+00f" in header  # the nearest float; nine digits of the number are nearer to another


def test_a_scenario_is_not_overwritten(sim):
    scenario = sim.write("rig.yaml", SHORT)
    (sim.folder / "link.h").symlink_to(scenario)
    for out in ("rig.yaml", "./rig.yaml", "link.h"):
        sim.fails(f"params: --out {out} is the same file as the scenario rig.yaml" + HINT, "params", "rig.yaml", "--out", out,
                  status=2)
    assert scenario.read_text(encoding="ascii") == SHORT


def test_a_place_that_cannot_be_written(sim):
    result = sim("params", "triangle", "--out", "no/such/rig.h")
    assert result.returncode == 1
    assert "no/such/rig.h" in result.stderr
    with open("/dev/full", "w", encoding="ascii") as full:
        sim.fails("standard output: cannot be written: No space left on device", "params", "triangle", stdout=full)
