"""The deepest stack that the image can need, from its instructions, against what the linker reserves: the background, in it a
received byte, in that a tick, in the tick the current loop of an image with the bridge, in that an emergency stop, and in that a crash. Frames are read off the prologues; calls through
pointers are those listed here."""

import os
import pathlib
import re
import struct
import subprocess

import pytest

TREE = pathlib.Path(os.environ["TRIBO_TREE"])
FRAME = 26 * 4 + 4  # that an exception pushes with the FPU in use, aligned to 8
VECTORS = 98 * 4

# Caller: callees through pointers. No other function may call through one, and none may be called so that is not here.
PORT = {"command", "enable", "inputs", "read_sensor", "time_us", "measure"}
FLASH = {"read_word", "erase", "write_word"}
THROUGH_POINTERS = {
    r"drive_tick|off|run_state|run_loop|take_text": PORT,
    r"log_text|log_number": {"log_byte"},
    r"modbus_take": {"receive"},
    r"modbus_(serve|execute|answer)": {"send", "take_text", "read_registers", "write_registers", "stop_drive"},
    r"make": {"suits"},
    r"dies_away|add_tail|add_response|tribo_(controller_f32_init|headroom_q31_quantize)": {"board_kick"},
    r"store_(read|write|holds)|look_at|mark_of|write_mark|mark_replaced|write_record|crc_of|word_of": FLASH,
    r"operate.*": {"run_in_ram"},
    r"selftest_ram|holds|check_word|check_addresses": {"real_read", "real_write"},
    r"refusal_of": {"set_up_(f32|q31)"},
    r"tribo_.*|last_of|make_part": {"tribo_.*", r"method_.*", r"part_make.*"},
    r"bridge_step|turn_on|calibrate": {"bridge_brushed", "bridge_brushed_begin"},
}


class Image:
    def __init__(self, path):
        self.path = path
        self.frames, self.calls, self.jumps = {}, {}, set()
        for name, body in re.findall(r"^[0-9a-f]+ <(.+)>:\n((?:.+\n)*)", self.run("objdump", "-d", "--no-show-raw-insn"), re.M):
            self.frames[name], self.calls[name] = 0, set()
            for line in body.splitlines():
                fields = line.split("\t")
                if len(fields) > 1:
                    self.read(name, fields[1].split(".")[0], fields[2] if len(fields) > 2 else "")

    def run(self, tool, *arguments):
        return subprocess.run([f"arm-none-eabi-{tool}", *arguments, self.path], capture_output=True, text=True, check=True).stdout

    def read(self, name, operation, operands):
        if operation in ("push", "vpush") or (operation in ("stmdb", "vstmdb") and operands.startswith("sp!")):
            for part in re.search(r"{(.*)}", operands)[1].split(","):
                first, _, last = part.strip().partition("-")
                self.frames[name] += (int(last[1:]) - int(first[1:]) + 1 if last else 1) * (8 if first[0] == "d" else 4)
        elif re.match(r"sp, (sp, )?#", operands) and operation in ("sub", "subw"):
            self.frames[name] += int(operands.split("#")[1].split("\t")[0].split("@")[0])
        elif operation in ("str", "strd") and re.search(r"\[sp, #-\d+\]!", operands):
            self.frames[name] += int(re.search(r"#-(\d+)", operands)[1])
        else:
            assert not re.match(r"sp\b", operands) or operation in ("add", "addw", "cmp", "mov", "ldmia"), f"{name}: {operation} {operands}"
        target = re.search(r"<([^>+]+)>", operands)
        if target and operation.startswith(("b", "cb")) and (target[1] != name or operation == "bl"):
            self.calls[name].add(target[1])
        if operation == "blx" or (operation == "bx" and operands.strip() != "lr"):
            self.jumps.add(name)

    def pointed_at(self):
        """Functions whose address stands in the image, but for the vectors."""
        functions = {int(address, 16) | 1: name for address, name in
                     re.findall(r"^([0-9a-f]{8}) .{6}F .*\s(\S+)$", self.run("objdump", "-t"), re.M)}
        assert len(functions) > 100
        content = self.path.with_suffix(".stack.bin")
        subprocess.run(["arm-none-eabi-objcopy", "-O", "binary", self.path, content], check=True)
        words = content.read_bytes()[VECTORS:]
        content.unlink()
        return {functions[word] for word, in struct.iter_unpack("<I", words[:len(words) // 4 * 4]) if word in functions}

    def symbol(self, name):
        return next(int(line.split()[0], 16) for line in self.run("nm").splitlines() if line.split()[-1] == name)

    def connect(self):
        pointed = self.pointed_at()
        patterns = [pattern for callees in THROUGH_POINTERS.values() for pattern in callees]
        for name in pointed:
            assert any(re.fullmatch(pattern, name) for pattern in patterns), f"{name}: who calls it through a pointer?"
        for name in self.jumps:
            callees = [callee for caller, some in THROUGH_POINTERS.items() if re.fullmatch(caller, name) for callee in some]
            assert callees, f"{name}: whom does it call through a pointer?"
            self.calls[name] |= {other for other in pointed if any(re.fullmatch(callee, other) for callee in callees)}

    def depth(self, name, above=()):
        """Bytes, and the way down."""
        assert name not in above, f"{name} calls itself: {above}"
        below = max((self.depth(callee, (*above, name)) for callee in self.calls[name] if callee in self.frames), default=(0, []))
        return self.frames[name] + below[0], [f"{name} {self.frames[name]}", *below[1]]

    def deepest(self, *names):
        return max(self.depth(name) for name in names)


@pytest.mark.parametrize("arithmetic", ["f32", "q31", "bridge-f32", "bridge-q31"])
def test_the_linker_reserves_more_stack_than_the_worst_case_needs(arithmetic):
    image = Image(TREE / "firmware" / f"tribo-stm32f405-{arithmetic}.elf")
    image.connect()
    ticks = [["TIM2_IRQHandler"], ["ADC_IRQHandler"]] if "bridge" in arithmetic else [["TIM2_IRQHandler", "ADC_IRQHandler"]]
    levels = [image.deepest("main"), image.deepest("USART1_IRQHandler"), *(image.deepest(*names) for names in ticks),
              image.deepest("EXTI1_IRQHandler", "EXTI15_10_IRQHandler", "PVD_IRQHandler"), image.deepest("NMI_Handler", "startup_end")]
    needed = sum(depth for depth, _ in levels) + (len(levels) - 1) * FRAME
    reserved = image.symbol("stack_size")
    print(f"\n{arithmetic}: {needed} of {reserved} bytes")
    for depth, way in levels:
        print(f"  {depth}: {', '.join(way)}")
    assert needed > 2000  # the analysis sees the loop and the set-up
    assert needed <= reserved - 512
