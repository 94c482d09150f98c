"""Modelled cycles of one tick: the instructions that QEMU executed in it, in their order, through llvm-mca's model of the
core. A lower bound: no wait states of a flash memory, every branch predicted."""

import pathlib
import re
import subprocess

HERE = pathlib.Path(__file__).parent
MODELS = {"cortex-m4f": "cortex-m4", "cortex-m7": "cortex-m7"}
LOOP = re.compile(r"tribo_force_loop_\w+_step_\w+$")
PARTS = re.compile(r"tribo_(?:controller|biquad|compensator|friction|arm|relay|edge)_\w*(?:step|output|advance)$")
RETURN = re.compile(r"^(pop|ldmia\.w\s+sp!|bx\s+lr).*(pc|lr)")


def text_of(command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def tick_functions(program):
    """Addresses by name."""
    lines = [line.split() for line in text_of(["arm-none-eabi-nm", "-S", program]).splitlines()]
    found = [line for line in lines if len(line) == 4 and (LOOP.match(line[3]) or PARTS.match(line[3]))]
    return {name: range(int(start, 16), int(start, 16) + int(size, 16)) for start, size, _, name in found}


def disassembly(program):
    """Instruction by address, in what llvm-mca reads: no comments, one label to branch to."""
    instructions = {}
    command = ["llvm-objdump-19", "-d", "--no-show-raw-insn", "--triple=thumbv7em-none-eabihf", "--mcpu=cortex-m7"]
    for line in text_of([*command, program]).splitlines():
        match = re.match(r"^\s*([0-9a-f]+):\s+(.*)$", line)
        if match:
            text = re.sub(r"\s*[@;].*", "", match[2])
            text = re.sub(r"^(cbn?z\s+\w+,|b\S*\s)\s*0x[0-9a-f]+ <.*>", r"\1 end", text)
            instructions[int(match[1], 16)] = text
    return instructions


def one_instruction_a_block():
    """QEMU's option for it, by its version."""
    option = "one-insn-per-tb"
    return ["-accel", f"tcg,{option}=on"] if option in text_of(["qemu-system-arm", "-help"]) else ["-singlestep"]


def executed(processor, program, arithmetic, way="with_signals"):
    """The instructions of the program's last tick."""
    functions = tick_functions(program)
    instructions = disassembly(program)
    log = program.with_suffix(".log")
    ranges = ",".join(f"{r.start:#x}+{len(r):#x}" for r in functions.values())
    trace = [*one_instruction_a_block(), "-d", "exec,nochain", "-dfilter", ranges, "-D", log]
    subprocess.run([HERE / "emulate", processor, program, *trace], check=True, timeout=100)
    addresses = [int(line.split("/")[1], 16) for line in log.read_text().splitlines() if line.startswith("Trace")]
    log.unlink()

    loop = [where for name, where in functions.items() if LOOP.match(name)]
    entry = functions[f"tribo_force_loop_{arithmetic}_step_{way}"].start
    first = len(addresses) - 1 - addresses[::-1].index(entry)
    tick = []
    for address in addresses[first:]:
        tick.append(instructions[address])
        if RETURN.match(instructions[address]) and any(address in function for function in loop):
            return tick
    raise RuntimeError("the last tick does not return")


def cycles(processor, program, arithmetic):
    """Modelled cycles and executed instructions of a tick, or None where there is no model."""
    if processor not in MODELS:
        return None
    tick = executed(processor, program, arithmetic)
    source = ".syntax unified\n.thumb\n" + "\n".join(tick) + "\nend:\n"
    command = ["llvm-mca-19", "-mtriple=thumbv7em-none-eabihf", f"-mcpu={MODELS[processor]}", "-iterations=1", "-call-latency=3"]
    command.append("-skip-unsupported-instructions=lack-sched")  # the M7's model has no IT, which is no operation
    out = subprocess.run([*command, "-"], input=source, check=True, capture_output=True, text=True).stdout
    return int(re.search(r"Total Cycles:\s+(\d+)", out)[1]), len(tick)
