"""The RP2040's image in rp2040js, an emulator of the chip in JavaScript, from its second stage to RUN with the paper's rig at its pins. What
the emulator has not, no test here has seen: see firmware/README.md."""

import json
import os
import pathlib
import shutil
import struct
import subprocess

import pytest

ROOT = pathlib.Path(__file__).parents[2]
TREE = pathlib.Path(os.environ["TRIBO_TREE"])
RIG = os.environ["TRIBO_RIG"]
MODULES = pathlib.Path(os.environ["TRIBO_RP2040JS"])  # the folder of rp2040js
RUN = pathlib.Path(__file__).with_name("rp2040_run.mjs")
REGISTERS = [line.split() for line in subprocess.run([os.environ["TRIBO_LINK"], "list"], capture_output=True, text=True, check=True).stdout.splitlines()]
STOP, FAULT = "5", "6"
UF2 = (0x0A324655, 0x9E5D5157)
APPLY, SET_REFUSED = 5, 3
STATE, FAULT_CAUSE, MAX_TICK_US = 0x06, 0x08, 0x10

pytestmark = pytest.mark.skipif(not (MODULES.exists() and shutil.which("node")), reason="no rp2040js: run tools/setup rp2040")

arithmetics = pytest.mark.parametrize("arithmetic", ["f32", "q31"])


def uf2_of(arithmetic):
    return TREE / "firmware" / f"tribo-rp2040-{arithmetic}.uf2"


def crc16(content):
    crc = 0xFFFF
    for byte in content:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return crc


class Board:
    """A chip with the paper's plant at its pins: a whole period forward is 2 N."""

    def __init__(self, arithmetic="q31", image=None, before=None):
        command = ["node", RUN, MODULES, image or uf2_of(arithmetic), *([json.dumps(before)] if before else [])]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.plant = subprocess.Popen([RIG], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.pins = {STOP: False, FAULT: False, "8": False}
        self.codes = [2048, 2048, 1489]  # force, current, bus
        self.force_n, self.log, self.ticks, self.seen = 0.0, bytearray(), 0, {}
        self.sensor_wire = True

    def ask(self, **request):
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        self.seen = json.loads(self.process.stdout.readline())
        self.log += bytes(self.seen.get("log", []))
        return self.seen

    def step(self, **request):
        """A millisecond."""
        seen = self.ask(step=1000, adc=self.codes, pins=self.pins, **request)
        forward, backward = seen["duty"]
        assert min(forward, backward) == 0.0 or not seen["enable"], "both sides of the bridge"
        u_n = 2.0 * (forward - backward) if seen["enable"] else 0.0
        self.plant.stdin.write(struct.pack("<d", u_n))
        self.plant.stdin.flush()
        shown_n, self.force_n = struct.unpack("<2d", self.plant.stdout.read(16))
        volts = 1.65 + 0.66 * shown_n if self.sensor_wire else 0.0
        self.ticks += 1
        self.codes[0] = min(4095, max(0, int(volts / 3.3 * 4096))) + self.ticks % 2  # noise of a code
        return seen

    def run(self, ms):
        for _ in range(ms):
            self.step()

    def run_until(self, condition, ms):
        for passed in range(ms):
            if condition():
                return passed
            self.step()
        assert condition(), f"not within {ms} ms; log: {self.log.decode('latin1')}"
        return ms

    def boot(self):
        self.run_until(lambda: b"latest 0 us\n" in self.log, 1000)
        self.run(3)

    def exchange(self, request):
        """The answer to a Modbus request, both without their CRC."""
        before = len(self.log)
        self.step(send=list(request + struct.pack("<H", crc16(request))))
        self.run_until(lambda: len(self.log) >= before + 4 and crc16(self.log[before:]) == 0, 1000)  # a set is answered when made
        return bytes(self.log[before:-2])

    def read(self, address):
        return struct.unpack(">I", self.exchange(struct.pack(">BBHH", 1, 3, address, 2))[3:])[0]

    def command(self, number):
        self.exchange(struct.pack(">BBHH", 1, 6, 0x100, number))

    def refer(self, r_n):
        self.exchange(struct.pack(">BBHHBf", 1, 16, REFERENCE, 2, 4, r_n))

    def write(self, name, pack, value):
        self.exchange(struct.pack(">BBHHB" + pack, 1, 16, address_of(name), 2, 4, value))

    def start(self, r_n=0.5):
        self.boot()
        self.refer(r_n)
        self.command(1)
        self.run_until(lambda: self.seen["enable"], 10)

    def hold(self, r_n, ms):
        """The host renews its reference, as it must."""
        for _ in range(ms // 60 + 1):
            self.refer(r_n)
            self.run(50)

    def is_off(self):
        return not self.seen["enable"] and self.seen["duty"] == [0, 0]

    def close(self):
        for process in (self.process, self.plant):
            process.kill()
            process.communicate()


def address_of(name):
    return next(int(words[1], 16) for words in REGISTERS if words[0] == name)


REFERENCE = address_of("reference")


@pytest.fixture
def bench():
    boards = []

    def open_board(*arguments, **options):
        boards.append(Board(*arguments, **options))
        return boards[-1]

    yield open_board
    for board in boards:
        board.close()


@arithmetics
def test_the_uf2_is_the_image(arithmetic):
    content = uf2_of(arithmetic).read_bytes()
    blocks = [content[at:at + 512] for at in range(0, len(content), 512)]
    flash = {}
    for number, block in enumerate(blocks):
        head = struct.unpack("<8I", block[:32])
        assert head[:3] == (*UF2, 0x2000) and head[4:] == (256, number, len(blocks), 0xE48BFF56)
        assert block[508:] == struct.pack("<I", 0x0AB16F30)
        flash[head[3]] = block[32:288]
    assert len(flash) == len(blocks) and min(flash) == 0x10000000
    binary = TREE / f"{arithmetic}.bin"
    subprocess.run(["arm-none-eabi-objcopy", "-O", "binary", uf2_of(arithmetic).with_suffix(".elf"), binary], check=True)
    image = binary.read_bytes()
    binary.unlink()
    assert b"".join(flash[page] for page in sorted(flash))[:len(image)] == image


@arithmetics
def test_the_drive_holds_a_force_in_a_closed_loop(bench, arithmetic):
    board = bench(arithmetic)
    board.start()
    assert f"tribo {arithmetic}, self-test passed\nreset: power-on or pin\n" in board.log.decode("latin1")
    assert board.seen["hz"] == 125_000_000 and abs(board.seen["baud"] / 115200 - 1) < 0.01
    board.hold(0.5, 300)
    assert board.read(STATE) == 1
    errors = []
    for _ in range(4):
        board.refer(0.5)
        for _ in range(10):
            board.step()
            errors.append(abs(board.force_n - 0.5))
    print(f"{arithmetic}: within {1000 * max(errors):.1f} mN of 0.5 N; longest tick {board.read(MAX_TICK_US)} us")
    assert max(errors) < 0.02
    assert board.read(MAX_TICK_US) <= {"f32": 500, "q31": 250}[arithmetic]
    board.refer(-0.5)
    board.hold(-0.5, 400)
    assert board.read(STATE) == 1 and abs(board.force_n + 0.5) < 0.05
    board.command(2)
    board.run(2)
    assert board.is_off()
    assert not board.seen["drives"]  # the line is left once all is sent


@pytest.mark.parametrize("pin, cause", [(STOP, "EMERGENCY_STOP"), (FAULT, "POWER")])
def test_a_stop_turns_the_outputs_off_at_once(bench, pin, cause):
    board = bench()
    board.start()
    board.hold(0.5, 100)
    assert not board.is_off()
    board.ask(step=300, adc=board.codes, pins={pin: True})
    seen = board.ask(step=5, pins={pin: False})  # a pulse: the tick has not seen it
    assert not seen["enable"] and seen["duty"] == [0, 0]
    board.run(3)
    assert board.read(STATE) == 2 and board.read(FAULT_CAUSE) == fault_number(cause)
    board.command(3)
    board.run(2)
    assert board.read(STATE) == 0


def fault_number(cause):
    lines = (ROOT / "firmware" / "app" / "drive.h").read_text().split("DRIVE_FAULT_NONE,")[1].splitlines()
    names = [line.split(",")[0].strip() for line in lines if line.strip().startswith("DRIVE_FAULT_")]
    return names.index(f"DRIVE_FAULT_{cause}") + 1


@pytest.mark.parametrize("name, pack, value", [
    ("drive.command_n_per_unit", "f", 1e-6), ("drive.sensor_n_per_unit", "f", 1e-4),
    ("drive.reference_ms", "I", 0), ("drive.reference_ramp_n_per_s", "f", 0.001)])
def test_an_unlocked_client_gets_past_no_ceiling(bench, name, pack, value):
    board = bench()
    board.boot()
    board.write("unlock", "I", 0x6C6F6F73)
    assert board.read(address_of("unlocked_ticks")) > 0
    board.write(name, pack, value)
    board.command(APPLY)
    board.run(60)
    assert board.read(address_of("outcome")) == SET_REFUSED and board.read(address_of("refused_register")) == address_of(name)


def break_sensor(board):
    board.sensor_wire = False


@pytest.mark.parametrize("breaks, cause", [
    (break_sensor, "SENSOR_RANGE"), (lambda board: board.ask(dead_adc=1), "SENSOR_SILENT"),
    (lambda board: board.ask(shorted=False), "POWER"), (lambda board: board.run(300), "REFERENCE")])
def test_what_breaks_stops_the_drive(bench, breaks, cause):
    board = bench()
    board.start()
    board.hold(0.5, 100)
    assert board.read(STATE) == 1
    breaks(board)
    board.run_until(board.is_off, 10)
    assert board.read(STATE) == 2 and board.read(FAULT_CAUSE) == fault_number(cause)


def test_a_hanging_tick_triggers_the_watchdog_and_is_reported(bench):
    board = bench()
    board.start()
    board.ask(no_ticks=True)
    for _ in range(60):
        if board.ask(step=1000)["reset"]:
            break
    assert board.seen["reset"]
    again = bench(before=board.seen["reset"])
    again.run_until(lambda: b"fault: reset by the watchdog since tick 0" in again.log, 1000)
    assert again.is_off()
    again.command(3)
    again.run(2)
    assert again.read(STATE) == 0


def test_an_exception_turns_the_outputs_off_and_is_reported(bench):
    board = bench()
    board.start()
    board.hold(0.5, 100)
    seen = board.ask(step=100, interrupt=5)  # which has no handler
    assert seen["reset"] and not seen["enable"]
    again = bench(before=seen["reset"])
    again.run_until(lambda: b"fault: reset after an exception since tick 0" in again.log, 1000)
    assert b"reset: reset after an exception 21 at " in again.log


def test_a_changed_image_does_not_get_past_the_self_test(bench, tmp_path):
    content = bytearray(uf2_of("q31").read_bytes())
    texts = (b"params refused", b"emergency stop", b"not a number", b"over-current")  # one that no block's end divides
    content[next(content.index(text) for text in texts if text in content)] ^= 0x20
    changed = tmp_path / "changed.uf2"
    changed.write_bytes(content)
    board = bench(image=changed)
    board.run_until(lambda: b"fault: self-test: image since tick 0" in board.log, 1000)
    board.command(1)
    board.run(5)
    assert board.is_off() and board.read(STATE) == 2


def test_a_second_stage_with_a_wrong_crc_is_not_started(bench, tmp_path):
    content = bytearray(uf2_of("q31").read_bytes())
    content[40] ^= 1
    changed = tmp_path / "changed.uf2"
    changed.write_bytes(content)
    assert "error" in bench(image=changed).ask(step=1)
