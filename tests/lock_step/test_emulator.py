"""Failures of an emulator are reported within seconds, and nothing is left behind. What is bounded in time here is ten times what an
idle machine takes; what would not end takes longer."""

import contextlib
import os
import pathlib
import re
import shutil
import signal
import stat
import struct
import subprocess
import sys
import time

import pytest
from conftest import TREE

ROOT = pathlib.Path(__file__).parents[2]
IMAGE = TREE / "firmware" / "tribo-drive-f32.elf"
LONG = ["triangle", "--set", "duration_s=3600", "--target", "m4f"]
SHORT = ["triangle", "--set", "duration_s=0.1", "--set", "metrics.start_s=0", "--target", "m4f"]


def put_emulator(sim, script):
    """A qemu-system-arm of our own, before the real one."""
    folder = sim.folder / "bin"
    folder.mkdir()
    program = folder / "qemu-system-arm"
    program.write_text(f"#!{sys.executable}\n{script}")
    program.chmod(0o755)
    sim.environment["PATH"] = f"{folder}:{sim.environment['PATH']}"


def put_image(sim, content):
    sim.tree.unlink()
    folder = sim.tree / "firmware"
    folder.mkdir(parents=True)
    (folder / IMAGE.name).write_bytes(content)


def sizes_of_open_files(pid):
    files = []
    for name in pathlib.Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(OSError):  # closed meanwhile
            status = name.stat()
            files += [status.st_size] if stat.S_ISREG(status.st_mode) and "/long/" in os.readlink(name) else []
    return files


def start_long_run(sim):
    """A run in the middle of its ticks: the process and the emulator's process number."""
    process = subprocess.Popen(sim.command(*LONG, "--out", "long"), cwd=sim.folder, env=sim.environment,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    children = pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children")
    deadline = time.monotonic() + 200
    while not any(written > 10000 for written in sizes_of_open_files(process.pid)):  # the trace has no name yet
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.02)
    return process, int(children.read_text())


def is_running(number):
    try:
        return pathlib.Path(f"/proc/{number}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def check_failure(sim, process, message, seconds):
    started = time.monotonic()
    _, said = process.communicate(timeout=300)
    assert time.monotonic() - started < seconds
    assert process.returncode == 1
    assert message in said
    assert list(sim.temporary.iterdir()) == []
    assert not (sim.folder / "long" / "trace.csv").exists()


def test_killed_emulator_is_an_error_at_once(sim):
    process, emulator = start_long_run(sim)
    os.kill(emulator, signal.SIGKILL)
    check_failure(sim, process, "m4f: the emulator was ended by signal 9", 20)


def test_hanging_emulator_is_an_error_in_seconds_and_is_ended(sim):
    process, emulator = start_long_run(sim)
    os.kill(emulator, signal.SIGSTOP)
    check_failure(sim, process, "m4f: the emulator has not answered for 5 s", 60)
    assert not is_running(emulator)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_emulator_does_not_outlive_tribo_sim(sim, number):
    process, emulator = start_long_run(sim)
    process.send_signal(number)
    process.communicate(timeout=300)
    deadline = time.monotonic() + 50
    while is_running(emulator):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    assert list(sim.temporary.iterdir()) == []


def test_missing_emulator_is_an_error(sim):
    sim.environment["PATH"] = str(sim.folder)
    sim.fails("m4f: qemu-system-arm cannot be started: No such file or directory", *SHORT)


def test_missing_image_is_an_error_that_says_how_to_build_it(sim):
    sim.tree.unlink()
    sim.fails("cmake --build --preset cortex-m4f", *SHORT)


def test_emulator_that_ends_at_once_is_an_error_with_its_words(sim):
    put_emulator(sim, "import sys; sys.exit('no such machine')")
    sim.fails("m4f: the emulator ended with status 1: no such machine", *SHORT)


def test_emulator_that_never_speaks_is_an_error_in_seconds(sim):
    put_emulator(sim, "import time; time.sleep(600)")
    started = time.monotonic()
    sim.fails("m4f: the emulator has not answered for 5 s", *SHORT)
    assert time.monotonic() - started < 60


@pytest.mark.parametrize("pause_s", [0.06, 0.24, 0.9])
def test_emulator_that_speaks_byte_by_byte_is_an_error_in_seconds(sim, pause_s):
    hello = [0x54520001, 3, 2, 0, 0]
    put_emulator(sim, f"import os, struct, time\nfor byte in struct.pack('<5I', *{hello}) + b'x' * 10000:\n"
                      f"    os.write(4, bytes([byte]))\n    time.sleep({pause_s})")
    started = time.monotonic()
    sim.fails("m4f: the emulator has stopped within a message", *SHORT)
    assert time.monotonic() - started < 60


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_signal_at_any_moment_of_the_start_leaves_nothing_behind(sim, number):
    for milliseconds in range(0, 120, 10):
        process = subprocess.Popen(sim.command(*LONG), cwd=sim.folder, env=sim.environment, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
        time.sleep(milliseconds / 1000)
        process.send_signal(number)
        process.communicate(timeout=300)
        assert process.returncode == -number
        assert list(sim.temporary.iterdir()) == []
    assert sorted(path.name for path in sim.folder.iterdir()) == ["images"]


def test_nonsense_is_an_error(sim):
    put_emulator(sim, "import os; os.write(4, b'x' * 1000)")
    sim.fails("m4f: the emulator's program sends messages of another kind or version", *SHORT)


# The real emulator behind pipes of its own, with one bit of the target's answers flipped on the way.
PROXY = """
import os, struct, subprocess, sys
target_reads, to_target = os.pipe()
from_target, target_writes = os.pipe()
def connect():
    os.dup2(target_reads, 3)
    os.dup2(target_writes, 4)
child = subprocess.Popen(["QEMU", *sys.argv[1:]], close_fds=False, preexec_fn=connect)
os.close(target_reads)
os.close(target_writes)
from_host, to_host = open(3, "rb", buffering=0), open(4, "wb", buffering=0)
to_target, from_target = open(to_target, "wb", buffering=0), open(from_target, "rb", buffering=0)
def message(pipe):
    data = b""
    while len(data) < 8 or len(data) < 8 + 4 * struct.unpack_from("<I", data, 4)[0]:
        more = pipe.read(65536)
        if not more:
            sys.exit(child.wait())
        data += more
    return bytearray(data)
count = 0
while True:
    answer = message(from_target)
    if count == TICK + 2:
        answer[8 + 4 * WORD] ^= 1
    count += 1
    to_host.write(answer)
    to_target.write(message(from_host))
"""


WORDS = [(0, "the command"), (7, "the guard's cause"), (8, "limited, Q1, Q2, Q"), (9, "e"), (12, "u"), (17, "f_hat")]


@pytest.mark.parametrize("word, name", WORDS)
def test_one_flipped_bit_is_found_and_the_files_are_written(sim, word, name):
    script = PROXY.replace("QEMU", shutil.which("qemu-system-arm")).replace("TICK", "17").replace("WORD", str(word))
    put_emulator(sim, script)
    sim.fails(f"m4f: 1 of 100 ticks differ from the host's; the first: {name} in tick 17 is ", *SHORT, "--out", "out")
    assert (sim.folder / "out" / "trace.csv").read_text().count("\n") == 101
    assert '"different_ticks":\t1' in (sim.folder / "out" / "summary.json").read_text()


def test_sensor_beyond_its_range_stops_the_drive_and_the_run(sim):
    sim.fails("m4f: the drive stopped at t = ", *SHORT, "--set", "sensor.noise_N=1")
    sim.fails("fault: sensor out of range since tick ", *SHORT, "--set", "sensor.noise_N=1")


@pytest.mark.parametrize("place", [b"self-test: golden vector", b"SEAL"])
def test_self_test_finds_a_changed_image_or_seal(sim, place):
    content = bytearray(IMAGE.read_bytes())
    content[content.index(place)] ^= 0x20
    put_image(sim, content)
    sim.fails("m4f: the drive's self-test failed with fault 1", *SHORT)


def test_self_test_finds_a_loop_that_computes_something_else(sim, tmp_path):
    """An image with a changed coefficient and a seal that fits: only the golden vector can find it."""
    header = (ROOT / "firmware" / "app" / "golden_f32.h").read_text()
    b0 = struct.pack("<f", float(re.search(r"\.b0 = (\S+)f,", header)[1]))
    content = bytearray(IMAGE.read_bytes())
    content[content.index(b0)] ^= 1
    image = tmp_path / "changed.elf"
    image.write_bytes(content)
    subprocess.run([sys.executable, ROOT / "firmware" / "tools" / "seal_image.py", image], check=True)
    put_image(sim, image.read_bytes())
    sim.fails("m4f: the drive's self-test failed with fault 3", *SHORT)


def test_unknown_target_and_arithmetic_are_usage_errors(sim):
    for arguments in (["--target", "m5"], ["--target", "m4f", "--arith", "f64"]):
        result = sim("triangle", *arguments)
        assert result.returncode == 2
        assert "must be one of" in result.stderr
