"""accuracy.py BUILD_TREE [--update]: how exact the library is, as printed by the tests that hold its limits.

Prints each figure beside the limit in its test, and compares it with accuracy.txt: fails when a figure is no longer printed,
or has moved by more than a tenth. --update writes accuracy.txt instead.
"""

import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
RECORD = HERE / "accuracy.txt"

GOLDEN_FRICTION = r"friction_.*: f within (\S+) N"
GOLDEN_ARM = r"compensator_.*: F\^ within (\S+) N"
GOLDEN_COMPENSATOR = r"compensator_.*f\^ within (\S+) N"

# Name, test program, the figure in what it prints (of several the largest counts), the limit in the test.
FIGURES = [
    ("f32.force_loop.rms_without", "closed_loop/closed_loop_triangle_f32", r"gain 0.00: RMS of r - F (\S+) N", "0.003858±2%"),
    ("f32.force_loop.rms_with", "closed_loop/closed_loop_triangle_f32", r"gain 0.85: RMS of r - F (\S+) N", "0.001068±2%"),
    ("f32.force_loop.u", "closed_loop/closed_loop_triangle_f32", r"u within (\S+) N of double", "5e-05"),
    ("f32.controller.design", "closed_loop/closed_loop_triangle_f32", r"controller within (\S+) N of double", "5e-05"),
    ("f32.controller.ripple", "contract/contract_controller_f32", r"v with ripple: within (\S+) N", "6e-06"),
    ("f32.compensator.force", "contract/contract_golden_f32", GOLDEN_ARM, "5e-06"),
    ("f32.compensator.friction", "contract/contract_golden_f32", GOLDEN_COMPENSATOR, "5e-06"),
    ("f32.friction.golden", "contract/contract_golden_f32", GOLDEN_FRICTION, "2e-07"),
    ("f32.friction.logic", "contract/contract_golden_f32", r"(\d+) of \d+ rows differ in logic", "1%"),
    ("f32.friction.tanh", "unit/unit_friction_f32", r"k = 1\.01: .* within (\S+) of itself", "1.2e-06"),
    ("q31.force_loop.rms_without", "closed_loop/closed_loop_triangle_q31", r"gain 0.00: RMS of r - F (\S+) N", "0.003858±2%"),
    ("q31.force_loop.rms_with", "closed_loop/closed_loop_triangle_q31", r"gain 0.85: RMS of r - F (\S+) N", "0.001068±2%"),
    ("q31.force_loop.u", "closed_loop/closed_loop_triangle_q31", r"u within (\S+) N of double", "2e-06"),
    ("q31.controller.design", "closed_loop/closed_loop_triangle_q31", r"controller within (\S+) N of double", "5e-05"),
    ("q31.controller.ripple", "contract/contract_controller_q31", r"v with ripple: within (\S+) N", "1e-07"),
    ("q31.compensator.force", "contract/contract_golden_q31", GOLDEN_ARM, "2e-06"),
    ("q31.compensator.friction", "contract/contract_golden_q31", GOLDEN_COMPENSATOR, "2e-06"),
    ("q31.friction.golden", "contract/contract_golden_q31", GOLDEN_FRICTION, "5e-07"),
    ("q31.friction.logic", "contract/contract_golden_q31", r"(\d+) of \d+ rows differ in logic", "1%"),
    ("q31.friction.tanh", "unit/unit_friction_q31", r"k = 1\.01: .* within (\S+) of itself", "9e-07"),
    ("q31.cascade.snr_0.1", "unit/unit_biquad_q31", r"fc/fs 0\.1: (\S+) dB", ">=175"),
    ("q31.cascade.snr_0.01", "unit/unit_biquad_q31", r"fc/fs 0\.01: (\S+) dB", ">=160"),
    ("q31.cascade.snr_0.001", "unit/unit_biquad_q31", r"fc/fs 0\.001: (\S+) dB", ">=140"),
    ("q31.cascade.limit_cycle", "unit/unit_biquad_q31", r"up to 2\.7 rad: (\d+) LSB", "64"),
    ("q31.cascade.limit_cycle_beyond", "unit/unit_biquad_q31", r"beyond: (\d+) LSB", "-"),
    ("q31.cascade.limit_cycle_paper", "unit/unit_biquad_q31", r"of the paper's controller: (\d+) LSB", "1"),
]


def measure(tree):
    """Measured figures and their limits, by name."""
    out = {}
    rows = {}
    for name, program, pattern, limit in FIGURES:
        if program not in out:
            run = subprocess.run([tree / "tests" / program], capture_output=True, text=True, timeout=1500)
            if run.returncode:
                sys.exit(f"{run.stdout}accuracy.py: {program} failed")
            out[program] = run.stdout
        found = re.findall(pattern, out[program])
        if not found:
            sys.exit(f"accuracy.py: {program} does not print {name}")
        rows[name] = (max(found, key=float), limit)
    return rows


def read():
    lines = [line.split() for line in RECORD.read_text().splitlines() if not line.startswith("#")]
    return {name: (found, limit) for name, found, limit in lines}


def write(rows):
    with RECORD.open("w") as file:
        print("# How exact the library is: figure, measured, limit in its test. Written by tools/dev/bench --update.", file=file)
        for name, (found, limit) in rows.items():
            print(f"{name:<32} {found:>10} {limit:>12}", file=file)


def main():
    rows = measure(pathlib.Path(sys.argv[1]))
    print(f"{'':<34} {'measured':>10} {'limit':>12}")
    for name, (found, limit) in rows.items():
        print(f"{name:<34} {found:>10} {limit:>12}")
    if "--update" in sys.argv:
        write(rows)
        return 0
    record = read()
    moved = [
        f"{name}: recorded {record.get(name, ('nothing',))[0]}, measured {rows.get(name, ('nothing',))[0]}"
        for name in {**record, **rows}
        if name not in record or name not in rows or record[name][1] != rows[name][1] or is_far(record[name][0], rows[name][0])
    ]
    print("\n".join(moved))
    if moved:
        print("accuracy.py: accuracy.txt is not current; if that is meant: tools/dev/bench --update")
    return bool(moved)


def is_far(recorded, measured):
    return abs(float(measured) - float(recorded)) > 0.1 * abs(float(recorded))


if __name__ == "__main__":
    sys.exit(main())
