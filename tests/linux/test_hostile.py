"""A client that knows every register (tribo-link list --markdown) and means no good, over TCP: it keeps the line, sends what no register is, and writes what may
not be written. The drive must go on, answer others, and keep what protects."""

import contextlib
import os
import pathlib
import random
import re
import socket
import struct
import subprocess
import threading
import time

import pytest

from conftest import CLOCK_RIG, free_port, until

ROOT = pathlib.Path(__file__).resolve().parents[2]
REGISTERS = subprocess.run([os.environ["TRIBO_LINK"], "list", "--markdown"], capture_output=True, text=True, check=True).stdout
ADDRESSES = {name: int(address, 16) for name, address in re.findall(r"^\| `([^`]+)` \| (0x[0-9a-f]{4}) \|", REGISTERS, re.M)}
KEY = int(re.search(r"write (0x[0-9a-f]{8}) to `unlock`", REGISTERS).group(1), 16)
START, STOP, ACKNOWLEDGE, APPLY, REVERT, DEFAULTS, SAVE, TRACE, TRACE_STOP = 1, 2, 3, 5, 6, 7, 8, 9, 10
COMMAND = 0x0100
ILLEGAL_ADDRESS, BUSY = 2, 6


class Client:
    """Modbus TCP by hand: what a library would refuse to send, too."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=30)
        self.number = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()

    def frame(self, pdu):
        self.number = (self.number + 1) % 65536
        return struct.pack(">HHHB", self.number, 0, len(pdu) + 1, 1) + pdu

    def take(self, size):
        answer = b""
        while len(answer) < size:
            part = self.socket.recv(size - len(answer))
            if not part:
                raise ConnectionError("it has hung up")
            answer += part
        return answer

    def ask(self, pdu):
        """The answer's PDU."""
        self.socket.sendall(self.frame(pdu))
        number, protocol, size, _ = struct.unpack(">HHHB", self.take(7))
        assert (number, protocol) == (self.number, 0)
        return self.take(size - 1)

    def read(self, address, count=2):
        """Its registers, or an exception's code as an int."""
        answer = self.ask(struct.pack(">BHH", 3, address, count))
        return answer[1] if answer[0] & 0x80 else struct.unpack(f">{count}H", answer[2:])

    def word(self, name):
        high, low = self.read(ADDRESSES[name])
        return high << 16 | low

    def number_of(self, name):
        return struct.unpack(">f", struct.pack(">I", self.word(name)))[0]

    def write(self, address, *values):
        """0, or an exception's code."""
        answer = self.ask(struct.pack(f">BHHB{len(values)}H", 16, address, len(values), 2 * len(values), *values))
        return answer[1] if answer[0] & 0x80 else 0

    def write_word(self, name, word):
        return self.write(ADDRESSES[name], word >> 16, word & 0xFFFF)

    def write_number(self, name, number):
        return self.write_word(name, struct.unpack(">I", struct.pack(">f", number))[0])

    def command(self, number):
        answer = self.ask(struct.pack(">BHH", 6, COMMAND, number))
        return answer[1] if answer[0] & 0x80 else 0

    def until_state(self, state):
        until(lambda: self.word("state") == state, f"its state is not {state}")


class Target:
    """A drive on TCP."""

    def __init__(self, drive, rig):
        self.port = free_port()
        self.ended = False  # by its test
        drive.write("rig.yaml", f"{CLOCK_RIG}bus: {{port: {self.port}, silent_s: 1}}\n{rig}")
        self.process, self.messages = drive.begin("--duration", "2000")

    def said(self):
        return self.messages.read_text()

    def try_state(self):
        """Reads the state as a new client; None if another client has the drive."""
        with Client(self.port) as client:
            answer = client.read(ADDRESSES["state"])
            return None if answer == BUSY else answer[0] << 16 | answer[1]


@pytest.fixture
def target(drive):
    made = []

    def start(rig="drive: {reference_ms: 0}\n"):
        made.append(Target(drive, rig))
        return made[-1]

    yield start
    for one in (it for it in made if not it.ended):
        assert one.process.poll() is None, one.said()
        one.process.terminate()
        assert one.process.wait(timeout=300) == 0


# --- who keeps the line ----------------------------------------------------------------------------------------------

HALF = {"nothing": b"", "a byte": b"\0", "half a head": b"\0\1\0\0", "a head": b"\0\1\0\0\0\6\1",
        "half a write": b"\0\1\0\0\0\xfd\1\x10\x10\0\0\x7b\xf6" + bytes(50)}


@pytest.mark.parametrize("sent", HALF.values(), ids=HALF.keys())
def test_a_client_that_asks_for_nothing_gives_way(target, sent):
    drive = target()
    with socket.create_connection(("127.0.0.1", drive.port), timeout=100) as silent:
        silent.sendall(sent)
        assert drive.try_state() is None  # not at once
        until(lambda: drive.try_state() == 0, "it keeps its place")
        assert silent.recv(64) == b""
    assert "is dropped: it has sent no request for 1 s, and another client has" in drive.said()


def test_a_client_that_dribbles_gives_way(target):
    """A byte now and then of one long request is no request, and keeps nobody waiting."""
    drive = target()
    ends = threading.Event()
    with socket.create_connection(("127.0.0.1", drive.port), timeout=100) as slow:

        def dribble():
            try:
                for byte in HALF["half a write"] + bytes(10000):
                    slow.sendall(bytes([byte]))
                    if ends.wait(0.02):
                        return
            except OSError:
                pass

        thread = threading.Thread(target=dribble)
        thread.start()
        until(lambda: drive.try_state() == 0, "it keeps its place")
        ends.set()
        thread.join()


def test_a_client_that_asks_now_and_then_keeps_its_place(target):
    drive = target()
    with Client(drive.port) as master:
        for _ in range(30):
            assert master.word("state") == 0
            assert drive.try_state() is None
            time.sleep(0.1)
    assert "is dropped" not in drive.said()


def test_a_request_that_comes_in_pieces_is_answered(target):
    drive = target()
    with Client(drive.port) as client:
        request = client.frame(struct.pack(">BHH", 3, ADDRESSES["state"], 2))
        for byte in request:
            client.socket.sendall(bytes([byte]))
            time.sleep(0.06)
        assert client.take(13)[6:] == bytes.fromhex("01030400000000")
        client.socket.sendall(3 * request)  # and three in one
        assert client.take(39)[26:] == client.take(0) + bytes.fromhex("00010000000701030400000000")


def test_a_client_that_does_not_read_is_left(target):
    """The answers fill its buffer, and then the drive's; whoever comes next is not kept waiting for it."""
    drive = target()
    with Client(drive.port) as deaf:
        deaf.socket.settimeout(1)
        with pytest.raises(OSError):
            for _ in range(100000):
                deaf.socket.sendall(100 * deaf.frame(struct.pack(">BHH", 3, 0x1000, 94)))
        until(lambda: drive.try_state() == 0, "it keeps its place until the kernel gives up, after 5 s", limit_s=3)


def test_a_crowd_does_not_disturb_the_master(target):
    drive = target()
    ends = threading.Event()

    def crowd():
        while not ends.is_set():
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", drive.port), timeout=0.2) as one:
                one.sendall(bytes.fromhex("000100000006010601000001"))  # start

    threads = [threading.Thread(target=crowd) for _ in range(10)]
    with Client(drive.port) as master:
        for thread in threads:
            thread.start()
        until(lambda: (master.word("state"), "(1 refused)" in drive.said())[1], "it does not refuse any")
        assert all(master.word("state") == 0 for _ in range(3000))
        ends.set()
        for thread in threads:
            thread.join()
    assert "is dropped" not in drive.said()


@pytest.mark.parametrize("head", ["000000010006", "000000000000", "000000000001", "0000000000ff", "00000000ffff", "ffffffffffff"])
def test_bytes_that_are_not_modbus_end_the_connection(target, head):
    drive = target()
    with Client(drive.port) as client:
        client.socket.sendall(bytes.fromhex(head) + bytes(20))
        assert client.socket.recv(64) == b""
    assert drive.try_state() == 0


# --- what it asks for ------------------------------------------------------------------------------------------------

NUMBERS = [(name, address >= 0x1000) for name, address in ADDRESSES.items() if re.search(rf"^\| `{re.escape(name)}` \| 0x[0-9a-f]{{4}} \| float32 ", REGISTERS, re.M) and
           (address >= 0x1000 or 0x0110 <= address < 0x0140)]
NOBODY_MEANS = {"infinite": 0x7F800000, "-infinite": 0xFF800000, "NaN": 0x7FC00000, "signalling NaN": 0x7F800001, "NaN with a payload": 0xFFC12345,
                "least subnormal": 1, "-subnormal": 0x807FFFFF, "1.0 with swapped words": 0x00003F80, "100 with swapped words": 0x000042C8, "1.0 with swapped bytes": 0x0000803F}


def test_an_implausible_number_is_refused_in_every_register(target):
    """Also where it counts for nothing as yet: in a section or a row of the table that is not used."""
    assert len(NUMBERS) > 50 and ("trace.level", False) in NUMBERS and ("reference", False) in NUMBERS
    with Client(target().port) as client:
        for name, _ in NUMBERS:
            before = client.word(name)
            for what, bits in NOBODY_MEANS.items():
                assert client.write_word(name, bits) == 3, (name, what)
            assert client.word(name) == before
            if name != "reference":
                assert client.write_word(name, 0x80000000) == 0 and client.word(name) == 0, name  # -0 is 0
        assert client.write_number("trace.level", 1e6) == 0 and client.write_number("trace.level", -1.1e6) == 3


def test_an_unknown_register_is_refused(target):
    """Every address that the list of registers does not name, one by one; and those that it does are there."""
    named = {address + half for address in ADDRESSES.values() for half in (0, 1)}
    with Client(target().port) as client:
        for name, address in ADDRESSES.items():
            assert client.read(address) != ILLEGAL_ADDRESS, name
        lists = [range(0x0180, 0x0200), range(0x0200, 0x027C), range(0x1300, 0x1328), range(0x1400, 0x14C0)]  # of which the first is named
        for address in range(0, 0x3000, 1):
            alike = address - 0x1000 if address >= 0x2000 else address
            known = alike in named or address == COMMAND or any(alike in one for one in lists)
            answer = client.read(address, 1)
            assert known or answer == ILLEGAL_ADDRESS, hex(address)
        for address in (0x3000, 0x7FFF, 0xFFFE, 0xFFFF):
            assert client.read(address, 1) == ILLEGAL_ADDRESS
            assert client.read(address, 125) == ILLEGAL_ADDRESS


def test_a_write_over_a_border_writes_nothing(target):
    with Client(target().port) as client:
        last = ADDRESSES["drive.swing_ms"]
        for address, count in [(last, 4), (last + 1, 2), (last, 1), (last, 3), (ADDRESSES["drive.period_us"] - 2, 4), (0xFFFE, 2),
                               (ADDRESSES["unlock"], 4), (COMMAND, 2), (COMMAND - 1, 2), (0x0000, 2), (0x2000, 2), (0x0200, 2)]:
            before = client.read(last), client.read(ADDRESSES["drive.period_us"]), client.word("unlocked_ticks")
            assert client.write(address, *([0xFFFF] * count)) != 0, hex(address)
            assert before == (client.read(last), client.read(ADDRESSES["drive.period_us"]), client.word("unlocked_ticks"))


def test_a_guessed_key_opens_nothing(target):
    random.seed(26)
    with Client(target().port) as client:
        for trial in range(3000):
            key = KEY ^ (1 << trial if trial < 32 else random.getrandbits(32) or 1)
            assert client.write_word("unlock", key) != 0 or key == 0
            assert client.word("unlocked_ticks") == 0


def start_at(client, force_n):
    assert client.command(START) == 0
    client.until_state(1)
    assert client.write_number("reference", force_n) == 0
    until(lambda: abs(client.number_of("F_N") - force_n) < 0.02, "F does not come to r")


def test_a_storm_of_sets_and_traces_in_run_moves_nothing(target):
    drive = target()
    with Client(drive.port) as client:
        start_at(client, 0.4)
        protection, refused = client.word("protection"), 0
        for i in range(400):
            assert client.write_number("compensator.gain", 0.5 + 0.1 * (i % 3)) == 0
            assert client.write_word("trace.decimation", 1 + i % 7) == 0
            refused += sum(client.command(number) != 0 for number in (APPLY, TRACE, APPLY, TRACE_STOP, SAVE, DEFAULTS, REVERT))
            assert abs(client.number_of("F_N") - 0.4) < 0.05 and abs(client.number_of("u_N")) <= 2
        assert client.word("state") == 1 and client.word("protection") == protection
        assert 400 <= refused <= 400 * 3  # a save in run; a set while the last one is not taken
    assert "fault" not in drive.said().split("run at tick")[1]


def test_a_trace_that_is_refused_leaves_the_one_that_records(target):
    with Client(target().port) as client:
        assert client.write_word("trace.trigger", 0) == 0 and client.command(TRACE) == 0
        until(lambda: client.word("trace_count") > 10, "it does not record")
        for name, word in (("trace.decimation", 0), ("trace.signals", 0), ("trace.signals", 0xFFFFFFFF), ("trace.trigger", 9), ("trace.after", 1 << 20)):
            before = client.word(name)
            assert client.write_word(name, word) == 0 and client.command(TRACE) == 4
            count = client.word("trace_count")
            assert client.word("trace_state") == 1, name
            until(lambda: client.word("trace_count") > count, "it has been stopped")  # noqa: B023
            assert client.write_word(name, before) == 0
        assert client.command(TRACE) == 0


def evil_pdu(client, near):
    """One of those that a fuzzer without this list would hardly find: at registers that there are, with lengths that nearly fit."""
    address = (random.choice(near) + random.choice((-2, -1, 0, 0, 0, 0, 1, 2))) % 65536
    count = random.choice((0, 1, 2, 2, 2, 4, 8, 121, 123, 124, 125, 126, 0xFFFF))
    values = b"".join(struct.pack(">f", random.choice((0.0, -0.0, 1.0, -1.0, 1e30, float("nan"), float("inf"), 0.3))) for _ in range(64))
    kind = random.randrange(6)
    if kind == 0:
        return struct.pack(">BHH", 3, address, count)
    if kind == 1:
        return struct.pack(">BHH", 6, random.choice((COMMAND, address)), random.choice((*range(16), 0xFFFF)))
    if kind == 2:
        size = 2 * min(count, 120) + random.choice((0, 0, 0, 0, -1, 1, 2))
        return struct.pack(">BHHB", 16, address, count, max(size, 0) % 256) + values[:max(size, 0)]
    if kind == 3:
        return struct.pack(">BHHHHB", 23, address, count, random.choice(near), 2, 4) + values[:random.choice((4, 4, 4, 2, 6))]
    if kind == 4:
        return bytes(random.randrange(256) for _ in range(random.randrange(1, 253)))
    return struct.pack(">BHHB", 16, random.choice(near), 2, 4) + values[:4]


@pytest.mark.parametrize("seed", range(3))
def test_a_fuzzer_that_knows_the_registers_does_no_harm(target, seed):
    random.seed(seed)
    drive = target("store: params.bin\ndrive: {reference_ms: 0}\n")
    near = list(ADDRESSES.values())
    with Client(drive.port) as client:
        protection, in_run = client.word("protection"), 0
        for i in range(4000):
            pdu = evil_pdu(client, near)
            if pdu[:1] in (b"\6", b"\x10", b"\x17") and b"loos" in pdu:
                continue
            answer = client.ask(pdu)
            assert answer[0] & 0x7F == pdu[0] & 0x7F
            assert not answer[0] & 0x80 or (len(answer) == 2 and answer[1] in (1, 2, 3, 4, 6))
            if i % 20 == 0:
                state = client.word("state")
                in_run += state == 1
                client.command({0: START, 2: ACKNOWLEDGE}.get(state, REVERT))
                assert client.word("protection") == protection
                assert abs(client.number_of("u_N")) <= 2
        assert in_run > 20
    assert drive.try_state() is not None
