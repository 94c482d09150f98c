"""Modelled cycles of one tick: the instructions that QEMU executed in it, in their order, through llvm-mca's model of the
core. A lower bound: no wait states of a flash memory, every branch predicted."""

import itertools
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
sys.path.insert(0, str(HERE.parents[1] / "cmake"))
import boards  # noqa: E402

# llvm-mca has no model of a Cortex-M0 or M0+; for an M3 and M33 it uses the M4's. QEMU's RISC-V cores are not those of a
# real chip: the models are of cores with exactly these instructions.
MODELS = {name: row["model"] for name, row in boards.ROWS.items() if "model" in row}


def text_of(command, source=None):
    return subprocess.run(command, input=source, check=True, capture_output=True, text=True).stdout


def triple(processor):
    return "riscv32" if processor.startswith("rv32") else "thumbv7em-none-eabihf"


def disassembly(processor, program):
    """Instructions by function, then by address."""
    functions = {}
    command = ["llvm-objdump-19", "-d", "--no-show-raw-insn", f"--triple={triple(processor)}", f"--mcpu={MODELS[processor]}"]
    for line in text_of([*command, program]).splitlines():
        if label := re.match(r"[0-9a-f]+ <(\w+)>:$", line):
            function = functions[label[1]] = {}
        elif instruction := re.match(r"\s*([0-9a-f]+):\s+(.*)$", line):
            function[int(instruction[1], 16)] = instruction[2]
    return functions


def with_called(functions, name):
    """The instructions of a function and of all that it may call, the compiler's helpers among them."""
    found, left = {}, [name]
    while left:
        name = left.pop()
        if name in functions and name not in found:
            found[name] = functions[name]
            left += re.findall(r"<(\w+)", " ".join(functions[name].values()))
    return found


def one_instruction_a_block():
    """QEMU's option for it, by its version."""
    option = "one-insn-per-tb"
    return ["-accel", f"tcg,{option}=on"] if option in text_of(["qemu-system-arm", "-help"]) else ["-singlestep"]


def executed(processor, program, arithmetic):
    """The instructions of the program's last tick."""
    functions = disassembly(processor, program)
    name = f"tribo_force_loop_{arithmetic}_step"
    parts = with_called(functions, name)
    log = program.with_suffix(".log")
    traced = [*parts.values(), functions["main"]]
    ranges = ",".join(f"{min(part):#x}..{max(part):#x}" for part in traced)
    trace = [*one_instruction_a_block(), "-d", "exec,nochain", "-dfilter", ranges, "-D", log]
    subprocess.run([HERE / "emulate", processor, program, *trace], check=True, timeout=100)
    with log.open() as lines:
        addresses = [int(line.split("/")[1], 16) for line in lines if line.startswith("Trace")]
    log.unlink()

    first = len(addresses) - 1 - addresses[::-1].index(min(functions[name]))
    tick = itertools.takewhile(lambda address: address not in functions["main"], addresses[first:])
    instructions = {address: text for part in parts.values() for address, text in part.items()}
    return [instructions[address] for address in tick]


def cycles(processor, program, arithmetic):
    """Modelled cycles and executed instructions of a tick."""
    tick = executed(processor, program, arithmetic)
    # What llvm-mca reads has no comments, and one label to branch to.
    text = re.sub(r"0x[0-9a-f]+ <.*>", "end", re.sub(r"\s*[@;].*", "", "\n".join(tick)))
    start = "" if processor.startswith("rv32") else ".syntax unified\n.thumb\n"
    command = ["llvm-mca-19", f"-mtriple={triple(processor)}", f"-mcpu={MODELS[processor]}", "-iterations=1", "-call-latency=3"]
    command.append("-skip-unsupported-instructions=lack-sched")  # the M7's model has no IT, which is no operation
    out = text_of([*command, "-"], f"{start}{text}\nend:\n")
    return int(re.search(r"Total Cycles:\s+(\d+)", out)[1]), len(tick)


def measure(processor, tree):
    figures = {"cycles.model": MODELS[processor]}
    for arithmetic in ("f32", "q31"):
        modelled, count = cycles(processor, tree / "tests" / "target" / f"trace_{arithmetic}", arithmetic)
        figures |= {f"cycles.{arithmetic}.tick": modelled, f"cycles.{arithmetic}.instructions": count}
    return figures
