"""budget.py BOARD|host BUILD_TREE [--results]: measures what a tick costs on a target and compares it with
budget.txt.

Fails when a figure has grown by more than 2 %, when a hash of the results has changed, and when a figure is only measured
or only in the budget; on the host, with another compiler than the budget's and with --results only hashes are compared.
Smaller figures are named; `tools/dev/bench-target --update` writes them into the budget. Of a board only the images are
measured.
"""

import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE.parents[1] / "cmake"))
import boards  # noqa: E402

BUDGET = HERE / "budget.txt"
GROWTH = 1.02
COMPARED = ("peer.", "cycles.")  # others' code and a model: in the table, but not ours to hold
COMPILER = "12"  # gcc's major version whose figures the budget holds

def tool(processor, name):
    return boards.processor(processor)["tools"] + name

def compiler(processor):
    version = subprocess.run([tool(processor, "gcc"), "-dumpversion"], check=True, capture_output=True, text=True).stdout
    return version.split(".")[0].strip()

def run(processor, program):
    """Runs a program that prints "name value" lines, with instructions counted."""
    command = [program] if processor == "host" else [HERE / "emulate", processor, program, "-icount", "shift=8"]
    out = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return dict(line.split() for line in out.splitlines())

def flash(processor, image):
    """Bytes of code and constants, and of initialised data."""
    out = subprocess.run([tool(processor, "size"), image], check=True, capture_output=True, text=True).stdout
    text, data = out.splitlines()[1].split()[:2]
    return int(text) + int(data)

def ram(processor, image):
    """Bytes of variables, without the stack."""
    out = subprocess.run([tool(processor, "size"), "-A", image], check=True, capture_output=True, text=True).stdout
    sections = [line.split() for line in out.splitlines()]
    return sum(int(s[1]) for s in sections if s and s[0] in (".data", ".sdata", ".bss", ".sbss"))

def code(processor, library, arithmetic):
    """Bytes of each module's step function alone: what it calls is not included."""
    out = subprocess.run([tool(processor, "nm"), "-S", library], check=True, capture_output=True, text=True).stdout
    sizes = {row[3]: int(row[1], 16) for row in map(str.split, out.splitlines()) if len(row) == 4}
    names = {module: f"tribo_{module}_{arithmetic}_step" for module in ("force_loop", "compensator", "friction")}
    return {f"{arithmetic}.code.{module}": sizes[name] for module, name in names.items()}

def measure(processor, tree):
    figures = {}
    programs = tree / "tests" / "target"
    for arithmetic in ("f32", "q31"):
        if processor not in boards.PORTS:
            figures |= run(processor, programs / f"cost_{arithmetic}")
        if processor == "host":
            continue
        if processor not in boards.PORTS:
            figures |= code(processor, programs / "libtribo_small.a", arithmetic)
        for part in () if processor in boards.PORTS else ("step", "fed", "all"):
            figures[f"{arithmetic}.flash.{part}"] = flash(processor, programs / f"image_{arithmetic}_{part}")
        if processor not in boards.PORTS and arithmetic == "f32":
            figures |= {f"f32.{what}.readme": size(processor, programs / "image_f32_readme") for what, size in (("flash", flash), ("ram", ram))}
        if processor in boards.PORTS:
            for name, feedforward in (("drive", 0), ("drive_fed", 1)):
                image = tree / "firmware" / "port" / processor / f"image_small_{arithmetic}_{feedforward}"
                figures[f"{arithmetic}.flash.{name}"] = flash(processor, image)
        else:
            figures |= run(processor, tree / "tests" / "firmware" / f"drive_cost_{arithmetic}")
        image = tree / "firmware" / f"tribo-{processor if processor in boards.PORTS else 'drive'}-{arithmetic}.elf"
        figures[f"{arithmetic}.flash.image"] = flash(processor, image)
        figures[f"{arithmetic}.ram.image"] = ram(processor, image)
    return {name: int(value) for name, value in figures.items()}

def read_budget():
    """Figures by name, then by processor, in the file's order. A board has only a few."""
    lines = [line.split() for line in BUDGET.read_text().splitlines() if line and not line.startswith(("#", *COMPARED))]
    processors = lines[0][1:]
    return {name: {p: int(v) for p, v in zip(processors, values) if v != "-"} for name, *values in lines[1:]}

def compare(budget, measured):
    """Complaints and remarks."""
    failures = [f"{name}: measured, but not in the budget" for name in measured if name not in budget]
    failures += [f"{name}: in the budget, but not measured" for name in budget if name not in measured]
    remarks = []
    for name, limit in budget.items():
        if name not in measured:
            continue
        found = measured[name]
        text = f"{name}: {found}, budget {limit}"
        if ".hash." in name:
            if found != limit:
                failures.append(f"{text}: the results have changed")
        elif name.endswith(".min"):
            continue  # a smaller minimum is no gain, and .max is held
        elif found > limit * GROWTH:
            failures.append(f"{text}: {100 * (found / limit - 1):+.1f} %")
        elif found < limit:
            remarks.append(f"{text}: less")
    return failures, remarks

def main():
    processor, tree = sys.argv[1], pathlib.Path(sys.argv[2])
    budget = read_budget()
    measured = measure(processor, tree)
    results_only = processor == "host" or "--results" in sys.argv
    if results_only or compiler(processor) != COMPILER:
        if not results_only:
            print(f"gcc {compiler(processor)} here: the results are compared, not the figures, which are gcc {COMPILER}'s")
        budget = {name: next(iter(row.values())) for name, row in budget.items() if ".hash." in name and name in measured}
        measured = {name: value for name, value in measured.items() if ".hash." in name}
    else:
        budget = {name: row[processor] for name, row in budget.items() if processor in row}
    failures, remarks = compare(budget, measured)
    print("\n".join(remarks + failures))
    if failures:
        print("budget.py: not within the budget; if that is meant: tools/dev/bench-target --update")
    return bool(failures)

if __name__ == "__main__":
    sys.exit(main())
