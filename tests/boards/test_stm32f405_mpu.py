"""The memory protection of the STM32F405's image at work, in QEMU's netduinoplus2, which has the MPU of a Cortex-M4: with registers that a
debugger has set, code of the image itself writes where it must not, and the exception ends where it should. QEMU is spoken to in
the remote protocol of gdb."""

import os
import pathlib
import socket
import subprocess
import time

import pytest

TREE = pathlib.Path(os.environ["TRIBO_TREE"])
IMAGE = TREE / "firmware" / "tribo-stm32f405-f32.elf"
FLASH, STORE = 0x08000000, 0x080C0000
SP, LR, PC, XPSR = 13, 14, 15, 25
MPU_CTRL, CFSR, MMFAR = 0xE000ED94, 0xE000ED28, 0xE000ED34
ACCESS, STACKING, FETCH, ADDRESS_VALID = 0x02, 0x10, 0x01, 0x80  # of CFSR


class Debugger:
    def __init__(self, path):
        deadline = time.monotonic() + 100
        while True:
            self.socket = socket.socket(socket.AF_UNIX)
            try:
                self.socket.connect(str(path))
                break
            except OSError:
                assert time.monotonic() < deadline, "QEMU does not answer"
                time.sleep(0.02)
        self.socket.settimeout(300)
        self.bytes = b""
        self.ask("qSupported:xmlRegisters=arm")
        assert self.ask("qXfer:features:read:target.xml:0,ffb").startswith(("l", "m"))  # from here on registers have their numbers

    def ask(self, command):
        self.socket.sendall(b"$%s#%02x" % (command.encode(), sum(command.encode()) & 0xFF))
        while b"#" not in self.bytes[:-2] or b"$" not in self.bytes:
            more = self.socket.recv(4096)
            assert more, "QEMU has ended"
            self.bytes += more
        packet, _, rest = self.bytes.partition(b"$")[2].partition(b"#")
        self.bytes = rest[2:]
        self.socket.sendall(b"+")
        return packet.decode()

    def word(self, address):
        return int.from_bytes(bytes.fromhex(self.ask(f"m{address:x},4")), "little")

    def register(self, number):
        return int.from_bytes(bytes.fromhex(self.ask(f"p{number:x}")), "little")

    def set(self, **registers):
        for name, value in registers.items():
            number = {"sp": SP, "lr": LR, "pc": PC}.get(name) or int(name[1:])
            assert self.ask(f"P{number:x}={value.to_bytes(4, 'little').hex()}") == "OK"

    def run_to(self, *places):
        """Goes on up to one of these addresses, which it returns."""
        for place in places:
            assert self.ask(f"Z1,{place:x},2") == "OK"
        assert self.ask("c").startswith("T05")
        for place in places:
            assert self.ask(f"z1,{place:x},2") == "OK"
        return self.register(PC)


@pytest.fixture
def chip(tmp_path):
    """A debugger at the end of board_start, and the image's symbols."""
    table = subprocess.run(["arm-none-eabi-nm", IMAGE], check=True, capture_output=True, text=True).stdout
    symbols = {name: int(value, 16) & ~1 for value, _, name in (line.split() for line in table.splitlines() if len(line.split()) == 3)}
    qemu = ["qemu-system-arm", "-M", "netduinoplus2", "-accel", "tcg", "-nographic", "-monitor", "none",
            "-serial", "none", "-S", "-chardev", f"socket,id=gdb,path={tmp_path}/gdb,server=on,wait=off", "-gdb", "chardev:gdb",
            "-kernel", str(IMAGE)]
    process = subprocess.Popen(qemu, stdin=subprocess.DEVNULL)
    debugger = Debugger(tmp_path / "gdb")
    yield debugger, symbols
    process.kill()
    process.wait()


def start(chip):
    """Up to the background's first loop, with the MPU on."""
    debugger, symbols = chip
    debugger.run_to(symbols["board_start"])
    debugger.run_to(debugger.register(LR) & ~1)
    assert debugger.word(MPU_CTRL) == 5
    return debugger, symbols


def call_memset(debugger, symbols, address, back):
    """memset(address, 0, 4) from here. True if it returns to `back`, false if it ends in the handler of exceptions."""
    debugger.set(r0=address, r1=0, r2=4, lr=back | 1, pc=symbols["memset"])
    return debugger.run_to(back, symbols["startup_end"]) == back


def check_hard_fault(debugger, bits, low, high):
    assert debugger.register(XPSR) & 0x1FF == 3
    assert debugger.word(CFSR) & 0xFF == bits | ADDRESS_VALID
    assert low <= debugger.word(MMFAR) < high


def test_a_write_to_flash_is_a_hard_fault(chip):
    debugger, symbols = start(chip)
    back = debugger.register(PC)
    assert call_memset(debugger, symbols, symbols["stack_guard"] - 4, back)  # RAM below the guard can be written
    assert call_memset(debugger, symbols, STORE, back)  # and the sectors of the params, whose erasing and writing the flash guards
    assert not call_memset(debugger, symbols, STORE - 4, back)
    check_hard_fault(debugger, ACCESS, STORE - 4, STORE)


def test_a_write_to_flash_before_the_mpu_is_on_has_no_effect(chip):
    debugger, symbols = chip
    back = debugger.run_to(symbols["main"])
    assert debugger.word(MPU_CTRL) == 0
    assert call_memset(debugger, symbols, FLASH + 0x400, back)


def test_a_stack_that_grows_into_its_guard_is_a_hard_fault(chip):
    debugger, symbols = start(chip)
    guard = symbols["stack_guard"]
    debugger.set(sp=guard + 256 + 8, lr=debugger.register(PC) | 1, pc=symbols["modbus_execute"])  # which pushes more than that
    assert debugger.run_to(symbols["startup_end"]) == symbols["startup_end"]
    assert debugger.word(CFSR) & (ACCESS | STACKING)
    check = debugger.word(CFSR) & 0xFF
    check_hard_fault(debugger, check & ~ADDRESS_VALID, guard, guard + 256)


def test_code_in_ram_is_a_hard_fault_and_ends_in_a_restart(chip):
    debugger, symbols = start(chip)
    debugger.set(pc=symbols["registers"])
    assert debugger.run_to(symbols["startup_end"]) == symbols["startup_end"]
    assert debugger.register(XPSR) & 0x1FF == 3
    assert debugger.word(CFSR) & 0xFF == FETCH
    assert debugger.run_to(symbols["Reset_Handler"]) == symbols["Reset_Handler"]
    record = [debugger.word(symbols["record"] + 4 * i) for i in range(6)]
    assert record[0] == 0x54455352  # what the next boot report tells: the exception, its address, CFSR
    assert 3 in record and symbols["registers"] in [word & ~1 for word in record] and FETCH in record
