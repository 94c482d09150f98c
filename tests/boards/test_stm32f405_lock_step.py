"""The STM32F405's lock-step image in QEMU, its USART1 at a pty, and tribo-sim at the other end: the same bits as the host, and no
hang whatever the line does. Its speed is QEMU's, which takes a byte at a time."""

import json
import os
import pathlib
import pty
import subprocess
import threading
import time
import tty

import pytest

TREE = pathlib.Path(os.environ["TRIBO_TREE"])
SIM = os.environ["TRIBO_SIM"]
QEMU = ["qemu-system-arm", "-M", "netduinoplus2", "-accel", "tcg", "-nographic", "-monitor", "none", "-serial", "stdio", "-kernel"]
SHORT = ["triangle", "--set", "reference.period_s=0.1", "--set", "duration_s=0.06", "--set", "metrics.start_s=0"]


class Line:
    """A serial line whose other end is `answer`, a function of the bytes that come and a function that sends."""

    def __init__(self):
        self.board, line = pty.openpty()
        tty.setraw(line)
        self.device = os.ttyname(line)
        self.line = line
        self.process = None
        self.hook = lambda data: data  # on the way to the host
        self.stopped = False

    def attach_board(self, image):
        self.process = subprocess.Popen([*QEMU, str(image)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0)
        self.forward(self.board, lambda data: os.write(self.process.stdin.fileno(), data))
        self.forward(self.process.stdout.fileno(), lambda data: os.write(self.board, self.hook(data)))

    def forward(self, source, take):
        def copy():
            while not self.stopped:
                try:
                    data = os.read(source, 4096)
                    take(data)
                except OSError:  # nobody has the line open
                    time.sleep(0.01)
                    continue
                if not data:
                    return

        threading.Thread(target=copy, daemon=True).start()

    def run(self, *arguments):
        return subprocess.run([SIM, "run", *SHORT, *arguments, "--target", f"serial:{self.device}"], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, timeout=600, check=False)

    def fails(self, message, *arguments):
        done = self.run(*arguments)
        assert done.returncode == 1
        assert done.stderr.startswith(f"tribo-sim: serial:{self.device}: ") and done.stderr.count("\n") == 1
        assert message in done.stderr

    def close(self):
        self.stopped = True
        if self.process:
            self.process.kill()
            self.process.communicate()
        os.close(self.line)
        os.close(self.board)


@pytest.fixture
def line():
    one = Line()
    yield one
    one.close()


def image_of(arithmetic):
    return TREE / "firmware" / f"tribo-stm32f405-lock-step-{arithmetic}.elf"


@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
def test_board_computes_the_bits_of_the_host_again_and_again(line, arithmetic, tmp_path):
    line.attach_board(image_of(arithmetic))
    for _ in range(2):
        done = line.run("--arith", arithmetic, "--json", "--out", str(tmp_path / "on_board"))
        assert (done.returncode, done.stderr) == (0, "")
        summary = json.loads(done.stdout)
        assert (summary["ticks"], summary["different_ticks"], summary["bad_inputs"]) == (60, 0, 0)
    subprocess.run([SIM, "run", *SHORT, "--arith", arithmetic, "--out", tmp_path / "on_host"], check=True, stdout=subprocess.PIPE)
    assert (tmp_path / "on_board/trace.csv").read_bytes() == (tmp_path / "on_host/trace.csv").read_bytes()


def test_the_other_arithmetic_is_refused(line):
    line.attach_board(image_of("f32"))
    line.fails("the image has another version or arithmetic", "--arith", "q31")


def at_byte(number, change):
    """A hook that changes one byte of what the board says, by then in an answer to a tick."""
    seen = {"bytes": 0}

    def hook(data):
        at, seen["bytes"] = number - seen["bytes"], seen["bytes"] + len(data)
        return data[:at] + change(data[at]) + data[at + 1:] if 0 <= at < len(data) else data

    return hook


def test_a_session_that_was_cut_does_not_spoil_the_next(line):
    in_the_ticks = threading.Event()
    line.hook = at_byte(1000, lambda byte: in_the_ticks.set() or bytes([byte]))
    line.attach_board(image_of("f32"))
    cut = subprocess.Popen([SIM, "run", "triangle", "--target", f"serial:{line.device}"], stdout=subprocess.PIPE)
    assert in_the_ticks.wait(200)
    cut.kill()
    cut.communicate()
    done = line.run("--json")
    assert (done.returncode, json.loads(done.stdout)["different_ticks"]) == (0, 0)


@pytest.mark.parametrize("number", [1000, 1027])
@pytest.mark.parametrize("change", [lambda byte: bytes([byte ^ 4]), lambda byte: b"", lambda byte: bytes([byte, byte])])
def test_a_damaged_a_lost_or_an_added_byte_ends_the_run_within_seconds(line, number, change):
    line.hook = at_byte(number, change)
    line.attach_board(image_of("f32"))
    started = time.monotonic()
    done = line.run()
    assert done.returncode == 1
    assert any(words in done.stderr for words in ("its CRC is wrong", "another kind or version", "stopped within a message"))
    assert time.monotonic() - started < 200


def test_a_drive_that_stops_ends_the_run_with_its_fault(line):
    line.attach_board(image_of("f32"))
    line.fails("the drive stopped at t = ", "--set", "sensor.noise_N=1")


def test_a_silent_line_is_an_error_in_seconds(line):
    started = time.monotonic()
    line.fails("no board answers")
    assert time.monotonic() - started < 80


def test_bytes_that_trickle_in_do_not_extend_the_wait(line):
    def trickle():
        while not line.stopped:
            os.write(line.board, b"\x01\x00TR")
            time.sleep(0.2)

    threading.Thread(target=trickle, daemon=True).start()
    started = time.monotonic()
    line.fails("no board answers")
    assert time.monotonic() - started < 80


@pytest.mark.parametrize("device, message", [
    ("/nowhere", "/nowhere cannot be used as a serial line: No such file or directory"),
    ("/dev/null", "/dev/null cannot be used as a serial line: "), ("", "names no device"), (",9600", "names no device"),
    ("/dev/null,1", "rates are 9600, "), ("/dev/null,9600x", "rates are 9600, ")])
def test_a_device_that_is_not_a_serial_line_is_refused(device, message):
    done = subprocess.run([SIM, "run", *SHORT, "--target", f"serial:{device}"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, timeout=100, check=False)
    assert done.returncode == 1
    assert message in done.stderr and done.stderr.count("\n") == 1
