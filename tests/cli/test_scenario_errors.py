"""Every mistake in a scenario file: exit status 1 and one line that names file, line, key and what is allowed."""

import pytest

from conftest import SCENARIOS, SHORT
from test_list import keys

SECTION = "{b0: 1, b1: 0, b2: 0, a1: -0.5, a2: 0}"
POINT = "{force_N: %s, positive_N: 1, negative_N: 1}"
KINDS = "triangle, sine, step, ramp, sawtooth, chirp or csv"

# What is appended to SHORT, and the message without the leading file name; MODELS are the truth models.
MISTAKES = {
    "unknown key": ("foo: 1", ":3: unknown key foo"),
    "misspelt mapping": ("compensater: {gain: 1}", ":3: unknown key compensater, did you mean compensator?"),
    "misspelt key": ("compensator:\n  gian: 1", ":4: unknown key compensator.gian, did you mean compensator.gain?"),
    "key in the wrong place": ("gain: 1", ":3: unknown key gain, did you mean compensator.gain?"),
    "key with a dot": ("compensator.gain: 1", ":3: unknown key compensator.gain"),
    "text for a number": ("compensator:\n  gain: abc", ":4: compensator.gain: 'abc' is not a number"),
    "text after a number": ("compensator:\n  gain: 0.5 N", ":4: compensator.gain: '0.5 N' is not a number"),
    "two numbers": ("compensator:\n  gain: 1 2", ":4: compensator.gain: '1 2' is not a number"),
    "decimal comma": ("compensator:\n  gain: 0,85", ":4: compensator.gain: '0,85' is not a number"),
    "hexadecimal": ("compensator:\n  gain: 0x1", ":4: compensator.gain: '0x1' is not a number"),
    "no value": ("compensator:\n  gain:", ":4: compensator.gain: '' is not a number"),
    "sign alone": ("compensator:\n  gain: '-'", ":4: compensator.gain: '-' is not a number"),
    "point alone": ("compensator:\n  gain: .", ":4: compensator.gain: '.' is not a number"),
    "exponent alone": ("compensator:\n  gain: 1e", ":4: compensator.gain: '1e' is not a number"),
    "not a number": ("compensator:\n  gain: .nan", ":4: compensator.gain: '.nan' is not a finite number"),
    "NaN": ("compensator:\n  gain: NaN", ":4: compensator.gain: 'NaN' is not a finite number"),
    "infinity": ("compensator:\n  gain: -.inf", ":4: compensator.gain: '-.inf' is not a finite number"),
    "overflow": ("compensator:\n  gain: 1e999", ":4: compensator.gain: '1e999' is too large for a number"),
    "swapped words": ("compensator:\n  gain: 2.26001e-41", ":4: compensator.gain: '2.26001e-41' is too small for a number: 0, or at least 1.2e-38 in size"),
    "underflow": ("plant: {friction: {gravity_N: -1e-320}}", ":3: plant.friction.gravity_N: '-1e-320' is too small for a number: 0, or at least 1.2e-38 in size"),
    "above the range": ("compensator:\n  gain: 2.01", ":4: compensator.gain: 2.01 is outside 0 to 2"),
    "below the range": ("compensator:\n  gain: -1e-9", ":4: compensator.gain: -1e-09 is outside 0 to 2"),
    "list for a number": ("compensator:\n  gain: [1]", ":4: compensator.gain: a number is expected here, not a list"),
    "mapping for a number": (
        "compensator:\n  gain: {a: 1}",
        ":4: compensator.gain: a number is expected here, not a mapping",
    ),
    "value for a mapping": ("compensator: 3", ":3: compensator: a mapping is expected here, not a single value"),
    "list for a mapping": ("compensator: [3]", ":3: compensator: a mapping is expected here, not a list"),
    "value for a list": (
        "controller: {kind: z, sections: 3}",
        ":3: controller.sections: a list is expected here, not a single value",
    ),
    "value for an element": (
        "controller: {kind: z, sections: [3]}",
        ":3: controller.sections[0]: a mapping is expected here, not a single value",
    ),
    "list for text": ("description: [a]", ":3: description: text is expected here, not a list"),
    "list for a word": ("plant: {model: [paper]}", ":3: plant.model: a word is expected here, not a list"),
    "list for a whole number": (
        "sensor: {noise_seed: [1]}",
        ":3: sensor.noise_seed: a whole number is expected here, not a list",
    ),
    "negative seed": (
        "sensor:\n  noise_seed: -1",
        ":4: sensor.noise_seed: '-1' is not a whole number of 0 or more",
    ),
    "broken seed": (
        "sensor:\n  noise_seed: 1.5",
        ":4: sensor.noise_seed: '1.5' is not a whole number of 0 or more",
    ),
    "large seed": (
        "sensor:\n  noise_seed: 18446744073709551616",
        ":4: sensor.noise_seed: '18446744073709551616' is too large for a whole number",
    ),
    "unknown controller": ("controller: {kind: pid}", ":3: controller.kind: 'pid' is not paper, pi, z, delta or none, did you mean pi?"),
    "number for a word": ("plant: {model: 0}", ":3: plant.model: '0' is not MODELS"),
    "misspelt word": ("plant: {model: lugr}", ":3: plant.model: 'lugr' is not MODELS, did you mean lugre?"),
    "word with nothing of another": ("plant: {paper: {limited: ja}}", ":3: plant.paper.limited: 'ja' is not no or yes"),
    "above a model's range": (
        "plant:\n  model: dahl\n  dahl:\n    stiffness_N_per_deg: 1.01e6",
        ":6: plant.dahl.stiffness_N_per_deg: 1010000 is outside 1 to 1e+06",
    ),
    "below a model's range": (
        "plant: {lugre: {sliding_ratio: 0.099}}",
        ":3: plant.lugre.sliding_ratio: 0.099 is outside 0.1 to 1",
    ),
    "negative bristle seed": (
        "plant: {bristle: {seed: -1}}",
        ":3: plant.bristle.seed: '-1' is not a whole number of 0 or more",
    ),
    "key of another model": (
        "plant: {dahl: {sliding_ratio: 1}}",
        ":3: unknown key plant.dahl.sliding_ratio, did you mean plant.coulomb.sliding_ratio?",
    ),
    "model without keys": ("plant: {torque: {}}", ":3: unknown key plant.torque"),
    "ripple without length": (
        "plant:\n  ripple: {amplitude_N: 0.1, period_deg: 0}",
        ":4: plant.ripple.period_deg: 0 is outside 0.001 to 360",
    ),
    "negative drive": ("plant: {command: {scale_error: -1}}", ":3: plant.command.scale_error: -1 is outside -0.9 to 9"),
    "given twice": ("duration_s: 2", ":3: duration_s is given twice, first in line 1"),
    "given twice deeper": (
        "compensator:\n  gain: 1\n  gain: 1",
        ":5: compensator.gain is given twice, first in line 4",
    ),
    "alias": ("compensator: *x", ":3: aliases are not supported"),
    "second document": ("---\nduration_s: 1", ":3: a second document in one file"),
    "tab": ("compensator:\n\tgain: 1", ":4: not valid YAML: found character that cannot start any token"),
    "unclosed": ("compensator: {gain: 1", ":4: not valid YAML: did not find expected ',' or '}'"),
    "key that is a mapping": ("? {a: 1}\n: 2", ":3: a key must be a word"),
    "too deep": ("x: " + "[" * 40, ":3: nested too deeply"),
    "long key": ("x" * 200 + ": 1", ":3: a key is too long"),
    "empty list": (
        "controller: {kind: z, sections: []}",
        ":3: controller.sections: has 0 elements, 1 to 4 are expected",
    ),
    "long list": (
        "controller: {kind: z, sections: [" + ", ".join([SECTION] * 5) + "]}",
        ":3: controller.sections: has 5 elements, 1 to 4 are expected",
    ),
    "incomplete element": (
        "controller:\n  kind: z\n  sections:\n    - " + SECTION + "\n    - b0: 1",
        ":7: controller.sections[1].b1: is missing",
    ),
    "range in a list": (
        "controller:\n  kind: z\n  sections:\n    - " + SECTION + "\n    - {b0: 1, b1: 0,\n       b2: 9e6, a1: 0, a2: 0}",
        ":8: controller.sections[1].b2: 9000000 is outside -1e+06 to 1e+06",
    ),
    "plant step does not fit": (
        "plant: {step_s: 0.0003}",
        ":3: plant.step_s: must divide sample_time_s without a remainder",
    ),
    "plant step too long": (
        "plant: {step_s: 0.01}",
        ":3: plant.step_s: must divide sample_time_s without a remainder",
    ),
    "window too late": ("metrics: {end_s: 0.02}", ":3: metrics.end_s: is after the end of the run"),
    "empty window": (
        "metrics: {start_s: 0.01}",
        ":3: metrics.start_s: leaves no time before the window's end",
    ),
    "k_min over k_max": (
        "compensator:\n  friction:\n    k_min: 30",
        ":5: compensator.friction.k_min: is larger than k_max",
    ),
    "k_min over k_max in the plant": (
        "plant:\n  friction:\n    k_max: 2",
        ":4: plant.friction.k_min: is larger than k_max",
    ),
    "table does not rise": (
        "compensator:\n  friction:\n    breakaway:\n      table:\n        - "
        + POINT % 0 + "\n        - " + POINT % 1 + "\n        - " + POINT % 1,
        ":9: compensator.friction.breakaway.table[2].force_N: must be larger than in the point before",
    ),
    "sections in open loop": (
        "controller: {kind: none, sections: [" + SECTION + "]}",
        ":3: controller.sections: are allowed only with controller.kind z or delta",
    ),
    "sections with the paper's": (
        "controller: {sections: [" + SECTION + "]}",
        ":3: controller.sections: are allowed only with controller.kind z or delta",
    ),
    "no sections": (
        "controller: {kind: delta}",
        ":3: controller.sections: is missing; controller.kind z or delta needs it",
    ),
    "a PI without its gain": ("controller: {kind: pi, ki_per_s: 3}", ":3: controller.kp: is missing; controller.kind pi needs it"),
    "a gain without a PI": ("controller: {kp: 3}", ":3: controller.kp: is allowed only with controller.kind pi"),
    "sections with a PI": (
        "controller: {kind: pi, kp: 3, sections: [" + SECTION + "]}",
        ":3: controller.sections: are allowed only with controller.kind z or delta",
    ),
    "an integral too fast": (
        "controller: {kind: pi, kp: 0.5, ki_per_s: 1001}",
        ":3: controller.ki_per_s: times sample_time_s must be at most 2 controller.kp",
    ),
    "other sample time": (
        "sample_time_s: 0.002",
        ":3: sample_time_s: must be 0.001 with controller.kind paper",
    ),
    "a law and a table": (
        "compensator:\n  friction:\n    breakaway:\n      slope: 0.2\n"
        "      table: [{force_N: 0, positive_N: 0.1, negative_N: 0.1}]",
        ":6: compensator.friction.breakaway.slope: is not allowed with a table, which replaces it",
    ),
    "a law and the plant's table": (
        "plant:\n  friction:\n    breakaway:\n      table: [{force_N: 0, positive_N: 0.1, negative_N: 0.1}]\n"
        "      negative_offset_N: 0.2",
        ":7: plant.friction.breakaway.negative_offset_N: is not allowed with a table, which replaces it",
    ),
    "pulse too wide": (
        "compensator:\n  friction: {pulse_width_s: 0.1}",
        ":4: compensator.friction.pulse_width_s: 0.1 s is refused: friction pulse_width_s: 1e-6 to 6.3 s; 1 to 63 sample times",
    ),
    "unstable section": (
        "controller: {kind: z, sections: [{b0: 1, b1: 0, b2: 0, a1: -3, a2: 1}]}",
        ":3: controller.sections[0]: controller section poles: inside the unit circle, or one of them at z = 1; read as controller.kind z, in z^-1",
    ),
    "coefficients in z taken as those in delta": (
        "controller: {kind: delta, sections: [{b0: 1, b1: -0.9, b2: 0, a1: -1.2, a2: 0.3}]}",
        ":3: controller.sections[0]: controller section poles: inside the unit circle, or one of them at z = 1; read as controller.kind delta, in z - 1",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_named_with_file_and_line(sim, mistake):
    text, message = MISTAKES[mistake]
    sim.write("x.yaml", SHORT + text)
    message = message.replace("MODELS", keys(sim)["plant.model"][0])
    sim.fails("x.yaml" + message, "run", "x.yaml")


WHOLE_FILES = {
    "empty": ("", ":1: the file is empty"),
    "comment": ("# nothing\n", ":1: the file is empty"),
    "list": ("- 1\n", ":1: a mapping is expected here"),
    "value": ("3\n", ":1: a mapping is expected here"),
    "nothing": ("{}\n", ": duration_s: is missing"),
    "no reference": ("duration_s: 1\n", ": reference.kind: is missing"),
    "reference without kind": ("duration_s: 1\nreference: {low_N: 0}\n", ":2: reference.kind: is missing"),
    "no file": (
        "duration_s: 1\nreference:\n  kind: csv\n",
        ":2: reference.file: is missing; reference.kind csv needs it",
    ),
    "other kind": ("duration_s: 1\nreference: {kind: steps}\n", f":2: reference.kind: 'steps' is not {KINDS}, did you mean step?"),
    "no duration": ("duration_s: 0\nreference: {kind: step}\n", ":1: duration_s: 0 is outside 0.001 to 86400"),
    "shorter than a sample": (
        "duration_s: 0.001\nsample_time_s: 0.01\nreference: {kind: step}\n",
        ":1: duration_s: is shorter than one sample",
    ),
    "binary": (b"duration_s: 1\n\0\n", ":2: a zero byte: this is not a text file"),
}


@pytest.mark.parametrize("case", WHOLE_FILES)
def test_a_file_that_is_not_a_scenario(sim, case):
    content, message = WHOLE_FILES[case]
    sim.write("x.yaml", content)
    sim.fails("x.yaml" + message, "run", "x.yaml")


def test_a_missing_file(sim):
    for command in ("run", "params"):
        sim.fails(f"none.yaml: there is no such file, and no such scenario in {SCENARIOS} (tribo-sim list shows them)", command,
                  "none.yaml")


def test_a_folder_for_a_file(sim):
    sim.fails("/: cannot be read: Is a directory", "run", "/")


def test_utf8_byte_order_mark_and_crlf_are_read(sim):
    sim.write("x.yaml", b"\xef\xbb\xbf" + SHORT.replace("\n", "\r\n").encode())
    sim.ok("run", "x.yaml")


def test_a_missing_reference_file(sim):
    sim.write("x.yaml", "duration_s: 1\nreference: {kind: csv, file: no.csv}\n")
    message = "reference.file: no.csv: cannot be opened: No such file or directory"
    sim.fails("x.yaml:2: " + message, "run", "x.yaml")
    sim.fails("--set reference={kind: csv, file: no.csv}: " + message, "run", "triangle", "--set", "reference={kind: csv, file: no.csv}")
