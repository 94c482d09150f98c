"""The STM32F405's image in QEMU's netduinoplus2, which has the chip's timers and USART but neither its clocks nor its
converters: the boot must pass every wait for a flag that is never set, and the drive must refuse that clock. test_stm32f405_model.py has
the chip's registers, but not its own timing, exceptions and interrupts."""

import os
import pathlib
import re
import select
import shutil
import subprocess
import time

import pytest

TREE = pathlib.Path(os.environ["TRIBO_TREE"])
QEMU = ["qemu-system-arm", "-M", "netduinoplus2", "-accel", "tcg", "-icount", "shift=0,sleep=off", "-nographic", "-monitor",
        "none", "-serial", "stdio", "-kernel"]


class Board:
    """A running image and its serial line."""

    def __init__(self, image):
        self.process = subprocess.Popen([*QEMU, str(image)], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.text = b""

    def send(self, command):
        self.process.stdin.write(command)
        self.process.stdin.flush()

    def line(self):
        """The next line of the log."""
        deadline = time.monotonic() + 300
        while b"\n" not in self.text:
            ready, _, _ = select.select([self.process.stdout], [], [], 0.1)
            assert time.monotonic() < deadline, f"silent after {self.text}"
            if ready:
                more = os.read(self.process.stdout.fileno(), 4096)
                assert more, "the emulator has ended"
                self.text += more
        line, self.text = self.text.split(b"\n", 1)
        return line.decode()

    def ticks(self):
        """Asks for the state; the ticks so far, of a drive that is in fault."""
        self.send(b"?\n")
        found = re.fullmatch(r"fault: clock since tick 0 at tick (\d+), longest tick 0 us, latest \d+ us", self.line())
        assert found
        return int(found[1])

    def until_tick(self, count):
        deadline = time.monotonic() + 300
        while self.ticks() <= count:
            assert time.monotonic() < deadline, "ticks too slowly"
            time.sleep(0.01)

    def stop(self):
        self.process.kill()
        self.process.communicate()


@pytest.fixture
def start():
    boards = []

    def start_image(image):
        boards.append(Board(image))
        return boards[-1]

    yield start_image
    for board in boards:
        board.stop()


def image_of(arithmetic):
    return TREE / "firmware" / f"tribo-stm32f405-{arithmetic}.elf"


# No reset flags, no oscillator flags.
BOOT = ["reset: pin", "clock: 16 MHz from HSI, no PLL, HSE 0 kHz", "params: damaged", "off: ready_ms over_current_a bus_low_v bus_high_v temperature_max_c speed_max_units_per_s"]  # QEMU's flash is not erased


@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
def test_boot_passes_the_self_test_ticks_and_refuses_the_clock(start, arithmetic):
    board = start(image_of(arithmetic))
    assert [board.line() for _ in range(5)] == [f"tribo {arithmetic}, self-test passed", *BOOT]
    assert board.line().startswith("fault: clock since tick 0 at tick ")

    first = board.ticks()
    for command in (b"start\n", b"ack\n", b"start\n"):  # the fault is for good
        board.send(command)
        board.until_tick(first + 100)
        first = board.ticks()


@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
def test_changed_image_does_not_get_past_the_self_test(start, tmp_path, arithmetic):
    content = bytearray(image_of(arithmetic).read_bytes())
    at = content.index(b"params refused")
    content[at] ^= 0x20
    changed = tmp_path / "changed.elf"
    changed.write_bytes(content)
    board = start(changed)
    assert [board.line() for _ in range(5)] == [f"tribo {arithmetic}, self-test failed", *BOOT]
    assert board.line().startswith("fault: self-test: image since tick 0 at tick ")
    for command in (b"start\n", b"ack\n", b"start\n"):
        board.send(command)
        time.sleep(0.1)
    board.send(b"?\n")
    assert board.line().startswith("fault: self-test: image since tick 0 at tick ")


@pytest.fixture
def flash(tmp_path):
    """Builds the target `flash` where openocd is the shell script that is given, or where there is none."""

    def run(openocd=None):
        path = tmp_path / "bin"
        path.mkdir()
        (path / "dirname").symlink_to(shutil.which("dirname"))
        if openocd:
            (path / "openocd").write_text(f"#!/bin/sh\n{openocd}\n")
            (path / "openocd").chmod(0o755)
        return subprocess.run([shutil.which("cmake"), "--build", TREE, "--target", "flash"], env={**os.environ, "PATH": str(path)},
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600, check=False)

    return run


def test_flash_hands_the_image_to_openocd(flash, tmp_path):
    done = flash(f'printf "%s\\n" "$@" > {tmp_path}/arguments')
    assert done.returncode == 0, done.stdout
    option, config, command, program = (tmp_path / "arguments").read_text().splitlines()
    assert (option, command) == ("-f", "-c")
    assert "interface/stlink.cfg" in pathlib.Path(config).read_text()
    assert program in [f"program {{{image_of(arithmetic)}}} verify reset exit" for arithmetic in ("f32", "q31")]


def test_flash_without_openocd_says_so(flash):
    done = flash()
    assert done.returncode != 0
    assert "flash: there is no openocd here" in done.stdout


def test_flash_that_openocd_cannot_write_is_an_error(flash):
    done = flash("exit 1")
    assert done.returncode != 0
    assert "flash: openocd has not written" in done.stdout
