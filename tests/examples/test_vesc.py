"""examples/vesc, compiled against its stand-in and run in an emulator at two addresses, with a fake of VESC's table of functions."""

import shutil
import struct
import subprocess

import pytest
from elftools.elf.elffile import ELFFile
from unicorn import UC_ARCH_ARM, UC_HOOK_CODE, UC_MODE_MCLASS, UC_MODE_THUMB, Uc
from unicorn.arm_const import UC_ARM_REG_LR, UC_ARM_REG_PC, UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_S0, UC_ARM_REG_SP, UC_CPU_ARM_CORTEX_M4

from conftest import EXAMPLES, RMS_MAX_UN, load, make, rms_of

Arm, triangle = (getattr(load("sim/arm.py"), name) for name in ("Arm", "triangle"))
PERIOD_S, OFFSET_V, N_PER_V, AMPERE_PER_N = 0.001, 1.65, 1.5, 4.0  # as in package.c
TABLE, TRAPS, STACK, HEAP, INFO, RETURN = 0x1000F800, 0x30000000, 0x20010000, 0x20020000, 0x20030000, 0x30008000
STACK_SIZE, FRESH = 4096, b"\xa5"
SLOTS = {42: "sleep_us", 46: "malloc", 47: "free", 48: "spawn", 49: "request_terminate", 50: "should_terminate", 58: "io_read_analog",
         92: "mc_get_fault", 98: "mc_set_current", 134: "mc_set_current_off_delay", 175: "timeout_reset", 194: "timer_time_now",
         195: "timer_seconds_elapsed_since", 196: "timer_sleep"}


@pytest.fixture(scope="module", name="image")
def _image(tmp_path_factory):
    folder = tmp_path_factory.mktemp("vesc")
    make("vesc", folder)
    return folder / "tribo_force.elf"


class Vesc:
    """A package that is loaded at `base`, and its thread."""

    def __init__(self, image, base, references):
        with open(image, "rb") as file:
            elf = ELFFile(file)
            sections = [(s["sh_addr"], s.data()) for s in elf.iter_sections() if s["sh_flags"] & 2 and s["sh_size"]]
            start = elf.get_section_by_name(".symtab").get_symbol_by_name("init")[0]["st_value"]
        self.uc = uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        uc.ctl_set_cpu_model(UC_CPU_ARM_CORTEX_M4)
        for address, size in ((base & ~0xFFF, 0x10000), (TABLE & ~0xFFF, 0x1000), (TRAPS, 0x10000), (STACK - 0x8000, 0x8000),
                              (HEAP, 0x4000), (INFO, 0x1000)):
            uc.mem_map(address, size)
        for address, data in sections:
            uc.mem_write(base + address, data)
        uc.mem_write(TABLE, b"".join(struct.pack("<I", TRAPS + 4 * slot + 1) for slot in range(256)))
        uc.mem_write(TRAPS, b"\x70\x47\x00\xbf" * 256)  # bx lr
        uc.hook_add(UC_HOOK_CODE, self.trap, begin=TRAPS, end=TRAPS + 4 * 256 - 1)
        self.arm, self.references = Arm(PERIOD_S), references
        self.now_s, self.fault, self.late = 0.0, 0, 0.0
        self.cut = range(0)  # ticks in which the sensor's wire is open
        self.forces, self.currents, self.delays = [], [], []
        self.thread, self.freed, self.fed = None, False, 0
        assert self.call(base + start, INFO) == 1
        self.stop, self.argument, _ = struct.unpack("<3I", uc.mem_read(INFO, 12))
        assert self.thread[1:] == (STACK_SIZE, self.argument)

    def call(self, address, argument):
        self.uc.reg_write(UC_ARM_REG_SP, STACK)
        self.uc.reg_write(UC_ARM_REG_LR, RETURN | 1)
        self.uc.reg_write(UC_ARM_REG_R0, argument)
        self.uc.emu_start(address | 1, RETURN)
        return self.uc.reg_read(UC_ARM_REG_R0) & 0xFF

    def run(self):
        """The thread, and how much of its stack it needed."""
        self.uc.mem_write(STACK - STACK_SIZE, FRESH * STACK_SIZE)
        self.call(self.thread[0], self.thread[2])
        used = self.uc.mem_read(STACK - STACK_SIZE, STACK_SIZE).lstrip(FRESH)
        return len(used)

    def trap(self, uc, address, size, data):
        result = getattr(self, SLOTS[(address - TRAPS) // 4])(uc.reg_read(UC_ARM_REG_R0), self.s0())
        if isinstance(result, float):
            uc.reg_write(UC_ARM_REG_S0, struct.unpack("<I", struct.pack("<f", result))[0])
        elif result is not None:
            uc.reg_write(UC_ARM_REG_R0, result)

    def s0(self):
        return struct.unpack("<f", struct.pack("<I", self.uc.reg_read(UC_ARM_REG_S0)))[0]

    def malloc(self, size, _):
        assert size <= 0x4000
        return HEAP

    def free(self, address, _):
        assert address == HEAP
        self.freed = True

    def spawn(self, function, _):
        argument = 3  # r3
        self.thread = (function & ~1, self.uc.reg_read(UC_ARM_REG_R1), self.uc.reg_read(UC_ARM_REG_R0 + argument))
        return 0x1234

    def request_terminate(self, thread, _):
        assert thread == 0x1234

    def should_terminate(self, *_):
        return len(self.forces) == len(self.references)

    def io_read_analog(self, pin, _):
        if pin == 7:
            return 0.0 if len(self.forces) in self.cut else OFFSET_V + self.arm.reading / N_PER_V
        return 3.3 * self.references[len(self.forces)]

    def mc_get_fault(self, *_):
        return self.fault if len(self.forces) >= 10 else 0

    def mc_set_current_off_delay(self, _, seconds):
        self.delays.append(seconds)

    def mc_set_current(self, _, ampere):
        self.currents.append(ampere)
        self.now_s += 20e-6  # what the tick takes
        if len(self.forces) < len(self.references):
            self.forces.append(self.arm.force)
            self.arm.step(ampere / AMPERE_PER_N)

    def timeout_reset(self, *_):
        self.fed += 1

    def timer_time_now(self, *_):
        return round(self.now_s * 1e7) & 0xFFFFFFFF

    def timer_seconds_elapsed_since(self, time, _):
        return (round(self.now_s * 1e7) - time & 0xFFFFFFFF) / 1e7

    def sleep_us(self, time, _):
        self.now_s += -(-time // 100) * 100e-6  # ends at a tick of 100 us

    def timer_sleep(self, _, seconds):
        self.now_s += seconds


def test_the_package_follows_at_any_address(image):
    references = list(triangle(PERIOD_S))
    first, second = Vesc(image, 0x08060000, references), Vesc(image, 0x0C002230, references[:2000])
    stack = first.run()
    second.run()
    assert rms_of(references, first.forces) < RMS_MAX_UN
    assert second.currents[:2000] == first.currents[:2000]
    assert (first.currents[-1], second.currents[-1]) == (0, 0)
    assert first.now_s == pytest.approx(len(references) * PERIOD_S, rel=1e-3)
    assert first.fed == len(references)
    assert first.delays == pytest.approx([0.02] * len(references))
    assert stack < STACK_SIZE / 2


def test_a_fault_ends_the_thread(image):
    vesc = Vesc(image, 0x08060000, [0.5] * 100)
    vesc.fault = 4
    vesc.run()
    assert len(vesc.currents) == 11
    assert vesc.currents[-2] != 0
    assert vesc.currents[-1] == 0
    vesc.call(vesc.stop & ~1, vesc.argument)
    assert vesc.freed


def test_20_bad_readings_end_the_thread(image):
    vesc = Vesc(image, 0x08060000, [0.5] * 1100)
    vesc.cut = range(10, 1010)
    vesc.run()
    assert (len(vesc.currents), vesc.currents[-1]) == (31, 0)
    vesc = Vesc(image, 0x08060000, [0.5] * 100)
    vesc.cut = range(10, 29)
    vesc.run()
    assert len(vesc.currents) == 101


def test_a_package_at_another_tick_runs_no_controller_of_1_ms(tmp_path):
    """Somebody changes PERIOD_S alone."""
    shutil.copytree(EXAMPLES, tmp_path / "examples")
    shutil.copytree(EXAMPLES.parent / "lib", tmp_path / "lib")
    source = tmp_path / "examples/vesc/package.c"
    assert "PERIOD_S     0.001f" in source.read_text()
    source.write_text(source.read_text().replace("PERIOD_S     0.001f", "PERIOD_S     0.002f"))
    subprocess.run(["make", "--silent", f"BUILD={tmp_path}/build"], cwd=source.parent, check=True, timeout=300)
    vesc = Vesc(tmp_path / "build/tribo_force.elf", 0x08060000, [0.5] * 100)
    vesc.run()
    assert vesc.currents == [0]


def test_no_address_is_left_to_relocate(image):
    with open(image, "rb") as file:
        elf = ELFFile(file)
        for section in elf.iter_sections():
            if section["sh_type"] == "SHT_REL" and elf.get_section(section["sh_info"])["sh_flags"] & 2:
                kinds = {relocation["r_info_type"] for relocation in section.iter_relocations()}
                assert kinds <= {3, 10, 30}, section.name  # REL32, THM_CALL, THM_JUMP24
        assert elf.get_section_by_name(".got") is None or not any(elf.get_section_by_name(".got").data()[12:])
