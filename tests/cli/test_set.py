"""--set: reaches every key, checks it like a file's, and what it sets has an effect on the run."""

import pytest

from conftest import PAPER, SHORT, numbers
from test_list import keys

SECTIONS = "controller.sections=[{b0: 1, b1: 0, b2: 0, a1: -0.5, a2: 0}, {b0: 1, b1: 0, b2: 0, a1: -0.9, a2: 0}]"
# Stable in z^-1 and in z - 1 alike.
BOTH_FORMS = "controller.sections=[{b0: 1, b1: 0, b2: 0, a1: 0.5, a2: 0.1}]"
TABLE = ".friction.breakaway.table=[{force_N: 0, positive_N: 0.01, negative_N: 0.01}," \
        " {force_N: 1, positive_N: 0.3, negative_N: 0.3}]"


# Ramps, a step, noise and a stand, for what feeds friction forward; its arm is not as believed.
FED = ["compensator.method=feedforward", "duration_s=9", "reference={kind: csv, file: fed.csv}", "sensor.noise_N=0.0005",
       "plant.friction.breakaway={slope: 0.1, negative_slope: 0.45}"]
# The paper's method with far too much of it.
HUNTING = ["compensator.gain=1", "plant.friction.breakaway={offset_N: 0.0035, slope: 0.15}",
           "reference={low_N: 0.4, high_N: 0.6, period_s: 20}", "duration_s=14"]
FED_REFERENCE = "t_s,r_N\n0,0.3\n1,0.4\n2,0.3\n2.02,0.27\n3,0.4\n4,0.5\n5,0.35\n7.5,0.35\n9,0.5\n"


def companions(key):
    """What has to be set first for this key to exist or to have an effect."""
    if key.startswith("compensator.feedforward."):
        return FED
    if key in ("compensator.sensor", "compensator.usual_force_N"):
        return FED
    if key.startswith("compensator.sensorless."):
        return [*FED, "compensator.sensor=none"]
    if key == "compensator.method":
        return ["compensator.gain=0.5"]
    if key.startswith("compensator.guard."):
        return HUNTING
    if key in ("controller.kp", "controller.ki_per_s"):
        return ["controller.kind=pi", "controller.kp=2"]
    if key.startswith("controller.sections"):
        return ["controller.kind=z", SECTIONS]
    if ".table[" in key:
        return [key.split(".", maxsplit=1)[0] + TABLE]
    if key.endswith((".k_max", ".m")):
        return [key.rsplit(".", maxsplit=1)[0] + ".v0_N_per_s=10"]  # some rates below v0
    if key.endswith(".reset_level"):
        return ["sensor.noise_N=0.01"]  # so that n turns round between the levels
    if key.startswith("plant.ripple.") and not key.endswith(".amplitude_N"):
        return ["plant.ripple.amplitude_N=0.05"]
    group = key.split(".")[1] if key.startswith("plant.") and key.count(".") == 2 else ""
    if group not in ("", "friction", "arm", "command", "ripple"):  # a key that only this truth model has
        stribeck = [f"plant.{group}.sliding_ratio=0.8"] if key.endswith(".stribeck_speed_deg_per_s") else []
        return ["plant.model=" + group, *stribeck]
    return {
        "reference.file": ["reference.kind=csv"],
        "reference.ramp_s": ["reference.kind=ramp"],
        "reference.from_Hz": ["reference.kind=chirp"],
        "reference.to_Hz": ["reference.kind=chirp"],
        "reference.sweep_s": ["reference.kind=chirp"],
        "sensor.noise_seed": ["sensor.noise_N=0.01"],
        "sample_time_s": ["controller.kind=z", SECTIONS],
        "controller.kind": [SECTIONS],
    }.get(key, [])


# Values that change what the run of MOVING does, where one and a half times the default does not.
VALUES = {
    "arithmetic": "q31",
    "duration_s": "2.1",
    "reference.kind": "sine",
    "stiffens": "yes",
    "reference.high_N": "0.5",
    "reference.start_s": "0.1",
    "reference.period_s": "0.6",
    "reference.ramp_s": "1",
    "reference.sweep_s": "2",
    "reference.file": "r.csv",
    "sample_time_s": "0.002",
    "plant.step_s": "0.0002",
    "sensor.noise_N": "0.001",
    "sensor.quantisation_N": "0.01",
    "sensor.delay_s": "0.0003",
    "sensor.noise_seed": "2",
    "controller.kind": "delta",
    "ki_per_s": "20",
    "controller.sections": "[{b0: 2, b1: 0, b2: 0, a1: -0.5, a2: 0}]",
    "sections[].b0": "1.1",
    "sections[].b1": "0.1",
    "sections[].b2": "0.1",
    "sections[].a1": "-0.6",
    "sections[].a2": "0.01",
    "m": "0.1",
    "v0_N_per_s": "10",
    "negative_offset_N": "0.02",
    "negative_slope": "0.2",
    "breakaway.table": "[{force_N: 0, positive_N: 0.01, negative_N: 0.2}]",
    "table[].force_N": "0.2",
    "table[].positive_N": "0.02",
    "table[].negative_N": "0.02",
    "set_level": "0.1",
    "reset_level": "0.1",
    "pulse_width_s": "0.05",
    "gravity_N": "0.05",
    "inertia_N_s2_per_deg": "0.001",
    "scale_error": "0.1",
    "bias_N": "0.02",
    "ripple.amplitude_N": "0.05",
    "ripple.phase": "0.25",
    "limited": "no",
    "paper.curve": "always",
    "bristle.seed": "2",
    "sliding_ratio": "0.8",
    "elastic_ratio": "0.5",
    "transition": "0.9",
    "viscous_N_s_per_deg": "0.1",
    "compensator.method": "feedforward",
    "compensator.sensor": "none",
    "belief": "0.5",
    "guard.on": "no",
    "reversal_N": "0.01",
    "presliding_N": "0.05",
    "jump_time_s": "0.05",
    "jump_lead": "0.5",
    "trust": "0.2",
    "forgetting_per_N": "5",
    "still_time_s": "0.5",
    "guard.quick_time_s": "0.01",
    "stray_N": "0.3",
    "usual_force_N": "0.05",
    "limits.u_min_N": "-0.01",
    "limits.u_max_N": "0.3",
    "limits.input_max_N": "0.3",
    "metrics.start_s": "1",
    "metrics.end_s": "1",
}

# Fast and wide enough for every part of the model to matter within two seconds.
MOVING = """duration_s: 2
reference: {kind: triangle, low_N: -0.2, high_N: 0.6, period_s: 0.5}
compensator: {method: paper}
"""


def value_for(key, default):
    known = [suffix for suffix in VALUES if key == suffix or key.endswith("." + suffix)]
    return VALUES[max(known, key=len)] if known else f"{1.5 * float(default):.6g}"


def set_options(assignments):
    return [word for assignment in assignments for word in ("--set", assignment)]


def outcome(sim, assignments, *options):
    """What a run leaves, without its times on the wall."""
    sim.ok("run", "moving.yaml", *set_options(assignments), "--out", "out", *options)
    summary = (sim.folder / "out/summary.json").read_text(encoding="ascii").splitlines()
    summary = [line for line in summary if "wall_s" not in line and "real_time" not in line]
    return summary, (sim.folder / "out/trace.csv").read_bytes()


@numbers
def test_set_reaches_every_key_and_every_key_has_an_effect(sim):
    sim.write("moving.yaml", MOVING)
    sim.write("r.csv", "t_s,r_N\n0,0\n1,0.5\n")
    sim.write("fed.csv", FED_REFERENCE)
    baselines = {}
    without = []
    for key, (_, _, default) in keys(sim).items():
        if key in ("description", "plant.model"):
            continue
        if key == "limits.full_scale_N":  # of Q31 alone
            change = [key + "=" + value_for(key, default)]
            assert outcome(sim, [], "--arith", "q31") != outcome(sim, change, "--arith", "q31")
            assert outcome(sim, []) == outcome(sim, change)
            continue
        first = companions(key)
        if key == "reference.file":
            first, extra = [], ["reference.kind=csv"]
        elif key == "controller.kind":
            first, extra = ["controller.kind=z", BOTH_FORMS], []
        else:
            extra = []
        if tuple(first) not in baselines:
            baselines[tuple(first)] = outcome(sim, first)
        assignment = key.replace("[]", "[1]") + "=" + value_for(key, default)
        others = [one for one in first + extra if not one.startswith(key + "=")]
        if outcome(sim, others + [assignment]) == baselines[tuple(first)]:
            without.append(assignment)
    assert without == []


@numbers
def test_a_pi_by_gains_is_its_section(sim):
    """The bilinear rule by hand: (kp + ki h/2) + (ki h/2 - kp) z^-1 over 1 - z^-1."""
    sim.write("moving.yaml", MOVING)
    half = 0.5 * 40 * 0.001
    section = f"controller={{kind: z, sections: [{{b0: {0.9 + half}, b1: {half - 0.9}, b2: 0, a1: -1, a2: 0}}]}}"
    pi = ["controller.kind=pi", "controller.kp=0.9", "controller.ki_per_s=40"]
    for arithmetic in ("f32", "q31"):
        errors = [sim.summary("moving.yaml", *set_options(controller), "--arith", arithmetic)["rms_error_N"] for controller in ([section], pi, [*pi[:2], "controller.ki_per_s=30"])]
        assert errors[1] == pytest.approx(errors[0], rel=1e-4)
        assert errors[2] > 1.02 * errors[0]


def test_set_checks_the_range_of_every_number(sim):
    sim.write("x.yaml", SHORT)
    for key, (kind, allowed, _) in keys(sim).items():
        if kind != "a number":
            continue
        low, high = allowed.split(" to ")
        path = key.replace("[]", "[1]")
        for value in (float(low) - 1.0, float(high) * 2 + 1.0):
            assignment = f"{path}={value:.10g}"
            sim.fails(f"--set {assignment}: {path}: {value:.10g} is outside {allowed}", "run", "x.yaml",
                      *set_options(one for one in companions(key) if not one.startswith(path + "=")), "--set", assignment)


def test_both_ends_of_a_range_are_allowed(sim):
    sim.write("x.yaml", SHORT)
    for value in ("0", "2"):
        sim.ok("run", "x.yaml", "--set", "compensator.gain=" + value)


def test_set_gives_what_the_file_left_out(sim):
    sim.write("x.yaml", "{}\n")
    sim.ok("run", "x.yaml", "--set", "duration_s=0.01", "--set", "reference.kind=step")


def test_set_goes_over_the_file(sim):
    sim.write("x.yaml", SHORT)
    assert sim.summary("x.yaml", "--set", "duration_s=0.03")["ticks"] == 30


def test_set_of_a_mapping_changes_only_what_it_names(sim):
    sim.write("moving.yaml", MOVING)
    whole = outcome(sim, ["sensor={noise_N: 0.01, quantisation_N: 0.001}", "sensor={noise_seed: 7}"])
    single = outcome(sim, ["sensor.noise_N=0.01", "sensor.noise_seed=7", "sensor.quantisation_N=0.001"])
    assert whole == single


def test_both_directions_follow_the_slope_unless_the_negative_one_has_its_own(sim):
    sim.write("moving.yaml", MOVING)
    name = "plant.friction.breakaway."
    assert outcome(sim, [name + "slope=0.36"]) == outcome(sim, [name + "slope=0.36", name + "negative_slope=0.36"])
    assert outcome(sim, [name + "slope=0.36"]) != outcome(sim, [name + "slope=0.36", name + "negative_slope=0.3"])


MISTAKES = {
    "gain=1": "unknown key gain, did you mean compensator.gain?",
    "compensator.friction.offset_N=1": "unknown key compensator.friction.offset_N,"
                                       " did you mean compensator.friction.breakaway.offset_N?",
    "compensator.gian=1": "unknown key compensator.gian, did you mean compensator.gain?",
    "plant.friction.breakaway.slop=1": "unknown key plant.friction.breakaway.slop,"
                                       " did you mean plant.friction.breakaway.slope?",
    "limits.u_upper_N=1": "unknown key limits.u_upper_N",
    "something.else.entirely=1": "unknown key something.else.entirely",
    "x" * 300 + "=1": "unknown key " + "x" * 300,
    "compensator.friction={k_mim: 1}": "unknown key compensator.friction.k_mim,"
                                       " did you mean compensator.friction.k_min?",
    "compensator.gain=": "compensator.gain: '' is not a number",
    "compensator.gain=abc": "compensator.gain: 'abc' is not a number",
    "compensator.gain=nan": "compensator.gain: 'nan' is not a finite number",
    "compensator.gain=3": "compensator.gain: 3 is outside 0 to 2",
    "compensator.gain=[1]": "compensator.gain: a number is expected here, not a list",
    "compensator.gain=1\nb: 2": "unknown key compensator.b",
    "compensator.gain={": "not valid YAML: did not find expected node content",
    "compensator=1": "compensator: a mapping is expected here, not a single value",
    "controller.kind=pid": "controller.kind: 'pid' is not paper, pi, z, delta or none, did you mean pi?",
    "controller.sections=[{b0: 1}]": "controller.sections[0].b1: is missing",
    "controller.sections[0].b0=1": "the list controller.sections has 0 elements, counted from 0",
    "controller.sections[0]=1": "controller.sections[0] is a whole element: set one of its keys, or the list",
    "controller.sections[x].b0=1": "unknown key controller.sections[x].b0, did you mean controller.sections[].b0?",
    "compensator[0].gain=1": "unknown key compensator[0].gain, did you mean compensator.gain?",
    "compensator.friction.pulse_width_s=0.1":
        "compensator.friction.pulse_width_s: 0.1 s is refused: friction pulse_width_s: 1e-6 to 6.3 s; 1 to 63 sample times",
    "reference.kind=csv": None,
}


@pytest.mark.parametrize("assignment", MISTAKES)
def test_a_wrong_set_is_named(sim, assignment):
    sim.write("x.yaml", SHORT)
    message = MISTAKES[assignment]
    if message is None:
        message = "x.yaml:2: reference.file: is missing; reference.kind csv needs it"
    else:
        message = f"--set {assignment}: {message}".replace("\n", "\\n")
    sim.fails(message, "run", "x.yaml", "--set", assignment)


A_TABLE = "compensator.friction.breakaway.table=[{force_N: 0, positive_N: 0.02, negative_N: 0.02}]"


def test_a_table_goes_over_the_files_law_but_not_over_a_set_one(sim):
    sim.write("x.yaml", SHORT + "compensator: {friction: {breakaway: {offset_N: 0.01, slope: 0.25, negative_slope: 0.3}}}\n")
    assert set(sim.trace("x.yaml", *PAPER, "--set", A_TABLE)["L_N"]) == {0.0199999996}
    slope = "compensator.friction.breakaway.slope=0.2"
    for sets in (("--set", A_TABLE, "--set", slope), ("--set", slope, "--set", A_TABLE)):
        sim.fails(f"--set {slope}: compensator.friction.breakaway.slope: is not allowed with a table, which replaces it", "run",
                  "x.yaml", *sets)


@pytest.mark.parametrize("old, new", [
    ("lead", "jump_lead"), ("learning.trust", "trust"), ("learning.forgetting_per_N", "forgetting_per_N"),
    ("hold.still_time_s", "still_time_s")])
def test_a_key_of_an_earlier_version_is_refused_with_its_name_of_today(sim, old, new):
    group = "compensator.feedforward."
    sim.fails(f"--set {group}{old}=1: unknown key {group}{old}, did you mean {group}{new}?", "run", "triangle", "--set", f"{group}{old}=1")


def test_a_direction_that_q31_cannot_have_is_named_with_its_value(sim):
    assignment = "compensator.friction.breakaway.negative_offset_N=3"
    sim.fails(f"--set {assignment}: compensator.friction.breakaway.negative_offset_N: 3 N is refused: friction breakaway "
              "negative.offset_n: 1e-6 to 1e6 N; q31: 1e-6 to under 1 full_scale_n",
              "run", "triangle", "--arith", "q31", "--set", assignment)


def test_a_point_of_a_table_that_q31_cannot_have_is_named_with_its_row_and_value(sim):
    table = "compensator.friction.breakaway.table"
    points = "[{force_N: 0, positive_N: 0.1, negative_N: 0.1}, {force_N: 1, positive_N: 0.1, negative_N: 3}]"
    sim.fails(f"--set {table}={points}: {table}[1].negative_N: 3 N is refused: friction table negative_n: 1e-6 to 1e6 N; q31: 1e-6 "
              "to under 1 full_scale_n",
              "run", "triangle", "--arith", "q31", "--set", f"{table}={points}")


TWO_SECTIONS = SHORT + """controller:
  kind: z
  sections:
    - {b0: 1, b1: 0, b2: 0, a1: -0.5, a2: 0.1}
    - {b0: 1, b1: 0, b2: 0, a1: -0.5, a2: 0.1}
"""
UNSTABLE = "controller section poles: inside the unit circle, or one of them at z = 1; read as controller.kind z, in z^-1"
NO_FEEDTHROUGH = "controller section b0: magnitude 1e-6 to 1e6, so that the cascade is biproper"


@pytest.mark.parametrize("assignment, message", [("controller.sections[1].a2=1.2", UNSTABLE), ("controller.sections[0].a1=-4", UNSTABLE),
                                                 ("controller.sections[1].b0=0", NO_FEEDTHROUGH)])
def test_a_section_that_a_set_has_spoiled_is_named(sim, assignment, message):
    sim.write("x.yaml", TWO_SECTIONS)
    section = assignment.split(".")[0] + "." + assignment.split(".")[1]
    assert message in sim("run", "x.yaml", "--set", assignment).stderr
    sim.fails(f"--set {assignment}: {section}: {message}", "run", "x.yaml", "--set", "compensator.gain=0.5", "--set", assignment)


def test_a_file_named_by_set_is_in_the_current_folder(sim):
    (sim.folder / "below").mkdir()
    sim.write("below/x.yaml", "duration_s: 0.01\nreference: {kind: csv, file: r.csv}\n")
    sim.write("below/r.csv", "t_s,r_N\n0,0.1\n")
    sim.write("own.csv", "t_s,r_N\n0,0.2\n")
    assert set(sim.trace("below/x.yaml")["r_N"]) == {0.1}
    assert set(sim.trace("below/x.yaml", "--set", "reference.file=own.csv")["r_N"]) == {0.2}


def test_true_and_false_are_yes_and_no(sim):
    sim.write("x.yaml", SHORT + "plant: {paper: {limited: false}}\ncompensator: {guard: {on: true}}\n")
    assert sim.summary("x.yaml")["guard"] == "none"
    assert "guard" not in sim.summary("x.yaml", "--set", "compensator.guard.on=false")
    sim.fails("--set compensator.method=true: compensator.method: 'true' is not paper, feedforward or off", "run", "x.yaml",
              "--set", "compensator.method=true")
