"""Clients of one drive that are in each other's way: other units on its serial line, noise, a second client over TCP, one that leaves
before its request is carried out. What stops the drive always acts, and nothing acts whose client has gone."""

import contextlib
import os
import pathlib
import random
import select
import socket
import struct
import subprocess
import threading
import time

import pytest

from conftest import until
from test_hostile import ADDRESSES, APPLY, BUSY, COMMAND, KEY, SAVE, START, STOP, Client, target  # noqa: F401

HERE = pathlib.Path(__file__).resolve().parent
IDLE, RUN = 0, 1


def crc(content):
    value = 0xFFFF
    for byte in content:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
    return struct.pack("<H", value)


def sealed(pdu, unit=1):
    return bytes([unit]) + pdu + crc(bytes([unit]) + pdu)


def command_pdu(number):
    return struct.pack(">BHH", 6, COMMAND, number)


def read_pdu(name):
    return struct.pack(">BHH", 3, ADDRESSES[name], 2)


def write_pdu(name, bits):
    return struct.pack(">BHHBI", 16, ADDRESSES[name], 2, 4, bits)


def bits_of(number):
    return struct.unpack(">I", struct.pack(">f", number))[0]


STOPS = {"6": command_pdu(STOP), "16": struct.pack(">BHHBH", 16, COMMAND, 1, 2, STOP),
         "23": struct.pack(">BHHHHBH", 23, 0, 2, COMMAND, 1, 2, STOP)}


class Master:
    """Talks on a serial line, byte by byte."""

    def __init__(self, served):
        self.served, self.file = served, os.open(served.line.port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)

    def hear(self, wait_s):
        return os.read(self.file, 4096) if select.select([self.file], [], [], wait_s)[0] else b""

    def ask_bytes(self, content, size, wait_s=100):
        """So many bytes of an answer."""
        os.write(self.file, content)
        return self.take(size, wait_s)

    def take(self, size, wait_s=100):
        answer, end = b"", time.monotonic() + wait_s
        while len(answer) < size and time.monotonic() < end:
            answer += self.hear(end - time.monotonic())
        return answer

    def ask(self, pdu, size):
        """The answer's PDU of `size` bytes; an exception's is shorter."""
        answer = self.ask_bytes(sealed(pdu), 5)
        answer += self.take((5 if answer[1] & 0x80 else size + 3) - len(answer))
        assert answer[:1] == b"\1" and crc(answer[:-2]) == answer[-2:], answer.hex()
        return answer[1:-2]

    def word(self, name):
        return struct.unpack(">I", self.ask(read_pdu(name), 6)[2:])[0]

    def command(self, number):
        answer = self.ask(command_pdu(number), 5)
        return answer[1] if answer[0] & 0x80 else 0

    def state_among_answers(self):
        """Behind the answer of a request before, if there is one; None: not yet. After a silence, as what was torn ends with it."""
        time.sleep(0.06)
        os.write(self.file, sealed(read_pdu("state")))
        heard = self.take(17, 0.5)
        frames = [heard[at:at + 9] for at in range(len(heard)) if heard[at:at + 3] == b"\1\3\4" and len(heard) >= at + 9]
        return struct.unpack(">I", frames[-1][3:7])[0] if frames and crc(frames[-1]) == b"\0\0" else None

    def settle(self):
        """Waits until no answer is on its way."""
        while self.hear(0.1):
            pass

    def until_state(self, state):
        until(lambda: self.word("state") == state, f"its state is not {state}")

    def pass_ticks(self, count):
        end = self.word("tick") + count
        until(lambda: self.word("tick") >= end, "the drive does not tick")


@pytest.fixture
def master(serve):
    made = []

    def start(rig=""):
        made.append(Master(serve(rig)))
        return made[-1]

    yield start
    for one in made:
        os.close(one.file)


# --- other units, and noise --------------------------------------------------------------------------------------------

def test_a_poll_of_an_absent_unit_swallows_nothing(master):
    line = master()
    for _ in range(10):
        assert line.command(START) == 0
        line.until_state(RUN)
        os.write(line.file, sealed(read_pdu("state"), unit=2))  # nobody answers, and its master asks on
        assert line.command(STOP) == 0
        line.until_state(IDLE)
    bad, frames = line.word("bad_frames"), line.word("frames")
    for _ in range(100):
        os.write(line.file, sealed(read_pdu("state"), unit=2))
        assert line.word("state") == IDLE
    assert line.word("bad_frames") == bad and line.word("frames") == frames + 102


@pytest.mark.parametrize("talk", [
    sealed(read_pdu("state"), 2) + sealed(bytes([3, 4, 0, 0, 0, 1]), 2),
    sealed(read_pdu("state"), 2) + sealed(bytes([0x83, 2]), 2),
    sealed(command_pdu(START), 2) * 2,  # its answer is as its request
    sealed(struct.pack(">BHH", 3, 0, 8), 2) + sealed(bytes([3, 16]) + sealed(command_pdu(START)) * 2, 2),  # a start for us in its values
    sealed(bytes([4, 16]) + sealed(command_pdu(START)) * 2, 2),
    sealed(bytes([16, 0, 0, 0, 8, 16]) + sealed(command_pdu(START)) * 2, 2),
    sealed(bytes([43, 14, 1, 0]), 2),
], ids=["answered", "refused", "written", "start in values", "start in an input", "start in a write", "other function"])
@pytest.mark.parametrize("pause_s", [0, 0.002], ids=["at once", "byte by byte"])
def test_what_others_say_is_not_for_this_unit(master, talk, pause_s):
    line = master()
    bad = line.word("bad_frames")
    if pause_s == 0:
        os.write(line.file, talk)
    for byte in talk if pause_s > 0 else b"":
        os.write(line.file, bytes([byte]))
        time.sleep(pause_s)
    assert line.command(STOP) == 0
    line.pass_ticks(20)
    assert line.word("state") == IDLE
    assert line.word("bad_frames") == bad or pause_s > 0  # a loaded machine may make a silence of a pause


@pytest.mark.parametrize("noise", [b"\xff" * 300, bytes(300), b"\xff" * 7, b"\1", b"\1\3\0\0", b"\1\x10\x11\0\0\x7b\xf6" + bytes(20), b"\x55" * 5000])
def test_after_noise_the_next_request_is_answered(master, noise):
    line = master()
    bad = line.word("bad_frames")
    for start in range(0, len(noise), 500):
        os.write(line.file, noise[start:start + 500])
        time.sleep(0.001)
    assert line.word("state") == IDLE
    assert line.word("bad_frames") == bad + 1


def stops_after(line, what):
    """A stop right behind it acts."""
    assert line.command(START) == 0
    line.until_state(RUN)
    os.write(line.file, what)
    os.write(line.file, sealed(command_pdu(STOP)))
    until(lambda: line.state_among_answers() == IDLE, what.hex())
    line.settle()


@pytest.mark.parametrize("unit", [2, 247, 255, 0])
def test_no_request_to_another_unit_swallows_a_stop(master, unit):
    """Absent units are polled with any function: coils, inputs, files, identification. Nobody answers a read of all units."""
    line = master()
    for function in (1, 2, 3, 4, 5, 7, 8, 11, 12, 15, 17, 20, 22, 23, 24, 43, 0x41, 0x64):
        for data in (b"", bytes(4), b"\0\1\0\1\1\xff"):
            stops_after(line, sealed(bytes([function]) + data, unit))


WRITE = struct.pack(">BHHB", 16, 0x112, 120, 240) + bytes(240)
HALF_FRAMES = [sealed(pdu, unit)[:size] for pdu, unit, size in [(read_pdu("state"), 1, n) for n in range(1, 8)] + [(read_pdu("state"), 2, n) for n in (1, 3, 5, 7)] +
               [(WRITE, unit, n) for unit in (1, 2) for n in (5, 7, 8, 50, 200)]] + [b"\1\x17" + bytes(9) + b"\xf0", b"\2\3\xf0", b"\1\3\xf8", b"\0\x10"]


def test_half_a_frame_swallows_no_stop(master):
    line = master()
    for half in HALF_FRAMES:
        stops_after(line, half)


def test_a_frame_to_all_units_stops_and_does_nothing_more(master):
    line = master()
    for pdu in (read_pdu("state"), STOPS["23"], struct.pack(">BHHHHBH", 23, 0, 2, COMMAND, 1, 2, START), command_pdu(START), write_pdu("unlock", KEY), write_pdu("reference", bits_of(0.3)),
                write_pdu("compensator.gain", bits_of(0.25)), command_pdu(SAVE), command_pdu(4)):
        os.write(line.file, sealed(pdu, 0))
        line.pass_ticks(5)
        assert (line.word("state"), line.word("unlocked_ticks"), line.word("reference"), line.word("compensator.gain")) == (IDLE, 0, 0, bits_of(0.85))
    for stop in (STOPS["6"], STOPS["16"]):
        assert line.command(START) == 0
        line.until_state(RUN)
        os.write(line.file, sealed(stop, 0))
        line.until_state(IDLE)


def test_a_stop_acts_in_a_storm(master):
    """The storm is noise, other units, and requests whose answers nobody waits for."""
    line = master()
    random.seed(38)
    for _ in range(10):
        assert line.command(START) == 0
        line.until_state(RUN)
        for _ in range(30):
            os.write(line.file, random.choice((random.randbytes(random.randrange(1, 40)), sealed(read_pdu("state"), 2),
                                               sealed(read_pdu("state")), sealed(command_pdu(START))[:random.randrange(1, 8)])))
        time.sleep(0.2)  # its master waits for an answer
        line.hear(0)
        os.write(line.file, sealed(command_pdu(STOP)))
        time.sleep(0.3)
        line.hear(0)
        line.until_state(IDLE)


# --- both lines alike --------------------------------------------------------------------------------------------------

REQUESTS = [bytes([function]) + data for function in range(256) for data in (b"", b"\x55", b"\x12\x34\0\1")] + [
    bytes.fromhex("0800001234"), bytes.fromhex("2b0e0100")] + [
    struct.pack(">BHH", 3, address, count) for address in (0, 1, 0x0100, 0x0FFF, 0x1000, 0x3000, 0xFFFE, 0xFFFF)
    for count in (0, 1, 2, 3, 125, 126, 0x8000, 0xFFFF)] + [
    struct.pack(">BHH", 6, address, value) for address in (0, 0x0100, 0x0110, 0x1000, 0x1001, 0xFFFF) for value in (0, 2, 13, 99, 0xFFFF)] + [
    struct.pack(">BHHB", 16, address, count, size) + bytes(size) for address in (0, 0x0100, 0x0112, 0x1108, 0x1109, 0xFFFF)
    for count in (0, 1, 2, 3, 123, 124) for size in (0, 1, 2, 4, 5, 246)] + [
    struct.pack(">BHHHHB", 23, at, count, to, 2, 4) + bytes(4) for at in (0, 0x0FFF, 0xFFFF) for count in (0, 2, 125, 126)
    for to in (0, 0x0112, 0x1108, 0xFFFF)]


def test_serial_and_tcp_answer_alike(master, target):  # noqa: F811
    """All functions, lengths, addresses and quantities, with the same counts of frames, of bad ones and of exceptions."""
    line = master()
    with Client(target().port) as network:
        counters = ("frames", "bad_frames", "exceptions")
        before = [{name: one.word(name) for name in counters} for one in (line, network)]
        for pdu in REQUESTS:
            over_tcp = network.ask(pdu)
            answer = line.ask_bytes(sealed(pdu), len(over_tcp) + 3)
            assert answer[1:-2] == over_tcp and crc(answer) == b"\0\0", pdu.hex()
        after = [{name: one.word(name) for name in counters} for one in (line, network)]
    counted = [{name: after[i][name] - before[i][name] for name in counters} for i in (0, 1)]
    assert counted[0] == counted[1] and counted[0]["bad_frames"] == 0 and counted[0]["frames"] == len(REQUESTS) + 3


# --- a second client over TCP ------------------------------------------------------------------------------------------

def start(client):
    assert client.command(START) == 0
    client.until_state(RUN)


@pytest.mark.parametrize("pdu", STOPS.values(), ids=STOPS.keys())
def test_a_second_client_may_stop(target, pdu):  # noqa: F811
    drive = target()
    with Client(drive.port) as first:
        start(first)
        with Client(drive.port) as second:
            assert second.ask(pdu)[0] in (6, 16, 0x97)
            first.until_state(IDLE)
            start(first)  # and goes on


def test_a_second_client_may_do_nothing_else(target):  # noqa: F811
    drive = target()
    with Client(drive.port) as first, Client(drive.port) as second:
        start(first)
        for number in set(range(14)) - {STOP}:
            assert second.command(number) == BUSY
        assert second.write_word("unlock", KEY) == BUSY and second.write_number("reference", 0.3) == BUSY
        assert second.write_number("compensator.gain", 0.1) == BUSY
        assert second.read(0) == BUSY and second.read(0x2000, 94) == BUSY
        assert first.word("state") == RUN and first.number_of("r_N") == 0 and first.word("unlocked_ticks") == 0
        assert first.number_of("compensator.gain") == pytest.approx(0.85)


def open_descriptors(drive):
    loop = pathlib.Path(f"/proc/{drive.process.pid}/task/{drive.process.pid}/children").read_text().split()[0]
    return len(list(pathlib.Path(f"/proc/{loop}/fd").iterdir()))


def test_a_crowd_of_silent_clients_keeps_no_stop_out(target):  # noqa: F811
    """Silent, with half a request, and dribbling ones."""
    drive = target()
    with Client(drive.port) as first, contextlib.ExitStack() as crowd:
        start(first)
        few = open_descriptors(drive)
        for i in range(200):
            assert first.word("state") == RUN  # it keeps its place
            one = crowd.enter_context(socket.create_connection(("127.0.0.1", drive.port), timeout=100))
            with contextlib.suppress(OSError):
                one.sendall(bytes.fromhex("000100000006010601000001")[:i % 12])
        with Client(drive.port) as stopper:
            assert stopper.command(STOP) == 0
        first.until_state(IDLE)
        assert open_descriptors(drive) <= few + 8


def test_eight_clients_at_once(target):  # noqa: F811
    """Each starts, stops and reads as it likes, and leaves in the middle of a frame; the drive answers and stops at the end."""
    drive = target()
    ends = threading.Event()
    broken = []

    def play(seed):
        chance = random.Random(seed)
        while not ends.is_set():
            try:
                with Client(drive.port) as client:
                    for _ in range(chance.randrange(1, 6)):
                        client.command(chance.choice((START, STOP, 3, 7)))
                        client.read(ADDRESSES["state"])
                    client.socket.sendall(client.frame(command_pdu(START))[:chance.randrange(13)])
            except ConnectionError:
                pass
            except (OSError, AssertionError, struct.error) as error:
                broken.append(error)

    threads = [threading.Thread(target=play, args=(seed, )) for seed in range(8)]
    for thread in threads:
        thread.start()
    time.sleep(5)
    ends.set()
    for thread in threads:
        thread.join()
    assert not broken
    with Client(drive.port) as last:
        last.command(STOP)
        until(lambda: last.read(ADDRESSES["state"]) == (0, IDLE), "it does not stop")


def test_killed_clients_leave_nothing(target):  # noqa: F811
    """kill -9 after each part of a start: only a whole one that is there in time acts."""
    drive = target()
    frame = bytes.fromhex("000100000006010601000001")
    for size in range(len(frame)):
        code = f"import socket,os,signal; s=socket.create_connection(('127.0.0.1',{drive.port})); s.sendall({frame[:size]!r}); os.kill(os.getpid(), 9)"
        subprocess.run(["/usr/bin/python3", "-c", code], check=False)
        with Client(drive.port) as client:
            until(lambda: client.read(ADDRESSES["state"]) == (0, IDLE), "it is not idle")  # pylint: disable=cell-var-from-loop


# --- what outlives a client --------------------------------------------------------------------------------------------

def test_the_key_ends_with_the_client_that_gives_way(target):  # noqa: F811
    """The silent client is still connected; bus.silent_s has passed."""
    drive = target()
    with Client(drive.port) as first, Client(drive.port) as second:
        assert first.write_word("unlock", KEY) == 0 and first.write_number("limits.u_max_N", 1.0) == 0
        until(lambda: second.read(ADDRESSES["unlocked_ticks"]) != BUSY, "it keeps its place")
        assert second.word("unlocked_ticks") == 0 and second.number_of("limits.u_max_N") == 2


def test_on_a_line_the_key_and_a_staged_set_end_after_a_silence(master):
    line = master()
    key = struct.pack(">BHHBI", 16, ADDRESSES["unlock"], 2, 4, KEY)
    gain = struct.pack(">BHHBf", 16, ADDRESSES["compensator.gain"], 2, 4, 0.5)
    assert line.ask(key, 5)[0] == 16 and line.ask(gain, 5)[0] == 16
    staged = struct.unpack(">f", struct.pack(">I", line.word("compensator.gain")))[0]
    assert staged == 0.5 and line.word("unlocked_ticks") > 0
    end = line.word("tick") + 10100
    time.sleep(10.2)
    until(lambda: (time.sleep(1), line.word("tick") >= end)[1], "the drive does not tick", limit_s=200)
    # On a loaded machine the asking above may have come in time; then once more.
    until(lambda: (time.sleep(11), line.word("unlocked_ticks") == 0)[1], "it stays unlocked")
    assert struct.unpack(">f", struct.pack(">I", line.word("compensator.gain")))[0] == pytest.approx(0.85)


SLOW = r"""
#define _GNU_SOURCE
#include <time.h>
#include <unistd.h>
int fdatasync(int file)
{
    (void)file;
    if (access("slow", F_OK) == 0)
    {
        (void)creat_began();
        while (access("slow", F_OK) == 0)
        {
            (void)nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
        }
    }
    return 0;
}
"""


@pytest.fixture
def slow_disk(drive, monkeypatch):
    """A disk that takes as long as there is a file `slow`; there is one `began` once it waits."""
    source = drive.folder / "slow.c"
    source.write_text(SLOW.replace("(void)creat_began()", "(void)close(open(\"began\", O_CREAT | O_WRONLY, 0644))").replace(
        "#include <time.h>", "#include <fcntl.h>\n#include <time.h>"))
    subprocess.run(["cc", "-shared", "-fPIC", "-o", drive.folder / "slow.so", source], check=True)
    monkeypatch.setenv("LD_PRELOAD", str(drive.folder / "slow.so"))
    monkeypatch.setenv("ASAN_OPTIONS", "verify_asan_link_order=0:" + os.environ.get("ASAN_OPTIONS", ""))  # where it is built with it
    return drive.folder


def begin_save(folder, client):
    assert client.write_number("compensator.gain", 0.5) == 0 and client.command(APPLY) == 0
    (folder / "slow").touch()
    assert client.command(SAVE) == 0
    until((folder / "began").exists, "it does not save")


STORE = "store: params.bin\ndrive: {reference_ms: 0}\n"


def test_on_a_line_a_start_during_a_slow_save_does_not_act_later(slow_disk, master):
    line = master("store: params.bin\n")
    gain = struct.pack(">BHHBf", 16, ADDRESSES["compensator.gain"], 2, 4, 0.5)
    assert line.ask(gain, 5)[0] == 16 and line.command(APPLY) == 0
    (slow_disk / "slow").touch()
    assert line.command(SAVE) == 0
    until((slow_disk / "began").exists, "it does not save")
    os.write(line.file, sealed(command_pdu(START)))
    time.sleep(0.3)
    (slow_disk / "slow").unlink()
    assert line.take(5)[:3] == bytes([1, 0x86, BUSY])
    line.pass_ticks(50)
    assert line.word("state") == IDLE and line.word("outcome") == 0
    assert line.command(START) == 0  # one in time acts
    line.until_state(RUN)


def test_a_disk_that_takes_for_ever_holds_up_no_end(slow_disk, target):  # noqa: F811
    drive = target(STORE)
    with Client(drive.port) as client:
        begin_save(slow_disk, client)
        drive.process.terminate()
        assert drive.process.wait(timeout=300) == 1
    assert "store: params.bin: its disk takes too long; the program ends without it" in drive.said()
    (slow_disk / "slow").unlink()
    drive.ended = True


LATE = {"key": write_pdu("unlock", KEY), "set": write_pdu("compensator.gain", bits_of(0.25)), "reference": write_pdu("reference", bits_of(0.3)), "apply": command_pdu(APPLY),
        "save": command_pdu(SAVE), "start": command_pdu(START), "tare": command_pdu(4), "defaults": command_pdu(7), "trace": command_pdu(9), "level": write_pdu("trace.level", bits_of(0.7)),
        "start by 23": struct.pack(">BHHHHBH", 23, 0, 2, COMMAND, 1, 2, START)}


def state_of(client):
    return (client.word("state"), client.word("unlocked_ticks"), client.number_of("compensator.gain"), client.number_of("reference"), client.number_of("trace.level"),
            client.word("trace_state"), client.word("tare"), client.word("protection_changes"))


@pytest.mark.parametrize("gone", ["closed", "half closed", "reset", "waits"])
def test_nothing_that_came_during_a_slow_save_acts_later(slow_disk, target, gone):  # noqa: F811
    """Any request, and any end of its client. A client that waits hears that the drive was busy."""
    drive = target(STORE)
    with Client(drive.port) as first:
        begin_save(slow_disk, first)
        before = None
        for pdu in LATE.values():
            first.socket.sendall(first.frame(pdu))
        with Client(drive.port) as second:  # comes, starts and goes
            second.socket.sendall(second.frame(command_pdu(START)))
        if gone == "half closed":
            first.socket.shutdown(socket.SHUT_WR)
        if gone == "reset":
            first.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        if gone in ("closed", "reset"):
            first.socket.close()
        time.sleep(0.2)
        (slow_disk / "slow").unlink()
        if gone in ("waits", "half closed"):
            answers = [first.take(9)[7:] for _ in LATE]
            assert [answer[1] for answer in answers] == [BUSY] * len(LATE), answers
    with Client(drive.port) as last:
        until(lambda: last.read(ADDRESSES["state"]) != BUSY, "its place is not free")
        ticks = last.word("tick")
        until(lambda: last.word("tick") > ticks + 50, "it does not tick")
        before = (IDLE, 0, 0.5, 0.0, 0.0, 0, 0, 0)
        assert state_of(last) == before
        assert last.word("outcome") == 0  # the save's
    assert "run at tick" not in drive.said()


@pytest.mark.parametrize("how", ["closed", "half closed", "reset", "killed"])
def test_the_key_and_a_staged_set_end_however_their_client_goes(target, how):  # noqa: F811
    drive = target()
    with Client(drive.port) as first:
        if how == "killed":
            sent = [first.frame(pdu) for pdu in (LATE["key"], write_pdu("limits.u_max_N", bits_of(1.0)))]
            first.socket.close()
            code = (f"import socket,os,time; s=socket.create_connection(('127.0.0.1',{drive.port}))\n"
                    f"for frame in {sent!r}: s.sendall(frame); s.recv(100)\nos.kill(os.getpid(), 9)")
            subprocess.run(["/usr/bin/python3", "-c", code], check=False)
        else:
            assert first.write_word("unlock", KEY) == 0 and first.write_number("limits.u_max_N", 1.0) == 0
            if how == "half closed":
                first.socket.shutdown(socket.SHUT_WR)
            if how == "reset":
                first.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            if how != "half closed":
                first.socket.close()
        with Client(drive.port) as second:
            until(lambda: second.read(ADDRESSES["unlocked_ticks"]) == (0, 0), "it stays unlocked")
            assert second.number_of("limits.u_max_N") == 2 and second.command(APPLY) == 0 and second.word("protection_changes") == 0


def test_a_stop_of_another_acts_while_the_first_floods(target):  # noqa: F811
    """Requests without end, whose answers it reads as they come; and starts among them."""
    drive = target()
    with Client(drive.port) as first:
        start(first)
        ends = threading.Event()
        flood = b"".join(first.frame(pdu) for pdu in [read_pdu("state")] * 50)

        def send():
            with contextlib.suppress(OSError):
                while not ends.is_set():
                    first.socket.sendall(flood)

        def hear():
            with contextlib.suppress(OSError):
                while first.socket.recv(65536):
                    pass

        threads = [threading.Thread(target=work, daemon=True) for work in (send, hear)]
        for thread in threads:
            thread.start()
        time.sleep(0.5)
        with Client(drive.port) as second:
            assert second.ask(STOPS["6"])[0] == 6
        until(lambda: "idle at tick" in drive.said() or "stopped" in drive.said(), "it runs on")
        ends.set()
        first.socket.shutdown(socket.SHUT_RDWR)
        for thread in threads:
            thread.join(timeout=100)
