"""A drive in QEMU with a bus: this stands for the host of the emulated port, with a plant whose force follows u, at about the
drive's own pace; clients talk to the bus's other end, a pty."""

import os
import pathlib
import select
import struct
import subprocess
import sys
import termios
import threading
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "cmake"))
import boards  # noqa: E402

PROCESSOR = os.environ["TRIBO_PROCESSOR"]
TREE = pathlib.Path(os.environ["TRIBO_TREE"])
HOST = pathlib.Path(os.environ["TRIBO_HOST"])
LINK = HOST / "tools" / "link" / "tribo-link"
SIM = HOST / "host_sim" / "tribo-sim"
SETUP_WORDS = HOST / "tests" / "bus" / "setup_words"

HELLO, SETUP, READY, TICK, TOCK, END = range(0x54520001, 0x54520007)
EMERGENCY_STOP = 1
FULL_SCALE_N = 4.0
BUS_FD, FLASH_FD = 5, 6


def raw(fd):
    """Bytes as they are; a read returns at once."""
    attributes = termios.tcgetattr(fd)
    attributes[0] = attributes[1] = attributes[3] = 0
    attributes[6][termios.VMIN] = attributes[6][termios.VTIME] = 0
    termios.tcsetattr(fd, termios.TCSANOW, attributes)


class Drive:
    """A running image. `port` is the path that clients open."""

    def __init__(self, arithmetic, flash=None):
        self.q31 = arithmetic == "q31"
        self.inputs, self.force, self.command, self.state, self.ticks = 0, 0.0, 0.0, None, 0
        self.bus, bus = os.openpty()
        self.client, client = os.openpty()
        for fd in (bus, client, self.bus, self.client):
            raw(fd)
        self.port = os.ttyname(client)
        self.ends = [bus, client]
        to_target, self.to_target = os.pipe()
        self.from_target, from_target = os.pipe()
        self.flash = open(flash, "r+b") if flash else None
        given = {3: to_target, 4: from_target, BUS_FD: bus}
        if flash:
            given[FLASH_FD] = self.flash.fileno()
        image = TREE / "firmware" / f"tribo-drive-{arithmetic}.elf"
        console = "enable=on,target=native,chardev=console,arg=drive,arg=bus" + (",arg=flash" if flash else "")
        command = [*boards.ROWS[PROCESSOR]["qemu"].split(), "-accel", "tcg", "-nographic", "-monitor", "none", "-serial", "none",
                   "-chardev", f"file,id=console,path={os.devnull}", "-semihosting-config", console, "-kernel", str(image)]
        # The shell moves the files to their numbers: the pipes' own may be in the way.
        high = {number: os.dup2(fd, 100 + number) for number, fd in given.items()}
        moves = " ".join(f"{number}<&{fd}" if number in (3, ) else f"{number}<>/dev/fd/{fd}" if number in (BUS_FD, FLASH_FD)
                         else f"{number}>&{fd}" for number, fd in high.items())
        self.process = subprocess.Popen(["bash", "-c", f'exec "$@" {moves}', "qemu", *command], pass_fds=high.values(),
                                        stdin=subprocess.DEVNULL)
        for fd in (to_target, from_target, *high.values()):
            os.close(fd)
        assert self.receive(HELLO)[2] == 0
        words = subprocess.run([SETUP_WORDS], check=True, capture_output=True, text=True).stdout.split()
        os.write(self.to_target, b"".join(struct.pack("<I", int(word, 16)) for word in words))
        assert self.receive(READY) == (0,)
        self.ends_now = threading.Event()
        self.threads = [threading.Thread(target=work, daemon=True) for work in (self.run, self.carry)]
        for thread in self.threads:
            thread.start()

    def read(self, size):
        content = b""
        while len(content) < size:
            more = os.read(self.from_target, size - len(content))
            if not more:
                raise EOFError
            content += more
        return content

    def receive(self, kind):
        found, count = struct.unpack("<II", self.read(8))
        assert found == kind
        return struct.unpack(f"<{count}I", self.read(4 * count))

    def to_word(self, force):
        if self.q31:
            return int(force / FULL_SCALE_N * 2**31) & 0xffffffff
        return struct.unpack("<I", struct.pack("<f", force))[0]

    def to_force(self, word):
        if self.q31:
            return struct.unpack("<i", struct.pack("<I", word))[0] / 2**31 * FULL_SCALE_N
        return struct.unpack("<f", struct.pack("<I", word))[0]

    def run(self):
        start = time.monotonic()
        try:
            while not self.ends_now.is_set():
                now = 1000 * self.ticks & 0xffffffff
                words = (0, now, now + 20 & 0xffffffff, self.inputs, 0, 0, self.to_word(self.force))
                os.write(self.to_target, struct.pack("<9I", TICK, 7, *words))
                tock = self.receive(TOCK)
                self.command, self.state = self.to_force(tock[0]), tock[2]
                self.force += 0.02 * (self.command - self.force)
                self.ticks += 1
                time.sleep(max(0.0, start + self.ticks * 1e-3 - time.monotonic()))
        except (OSError, EOFError):
            pass

    def until(self, has_happened, what, limit_s=200):
        """Waits for it. The limit is for what never happens, and far beyond what a loaded machine takes."""
        end = time.monotonic() + limit_s
        while not has_happened():
            assert time.monotonic() < end and self.process.poll() is None, what
            time.sleep(0.002)

    def pass_s(self, seconds):
        """Time of the drive's, which is behind the clock's on a loaded machine."""
        end = self.ticks + 1000 * seconds
        self.until(lambda: self.ticks >= end, "the drive does not tick")

    def knock(self):
        self.force = 0.0

    def carry(self):
        """Bytes between the pty of the drive and that of the client."""
        while not self.ends_now.is_set():
            for fd in select.select([self.bus, self.client], [], [], 0.1)[0]:
                try:
                    content = os.read(fd, 4096)
                    os.write(self.client if fd == self.bus else self.bus, content)
                except OSError:
                    return

    def cut_power(self):
        self.process.kill()
        self.close()

    def close(self):
        self.ends_now.set()
        self.process.kill()
        self.process.wait()
        for thread in self.threads:
            thread.join()
        for fd in (self.bus, self.client, self.to_target, self.from_target, *self.ends):
            os.close(fd)
        self.ends, self.bus = [], -1
        if self.flash:
            self.flash.close()

    def link(self, *arguments, status=0):
        """tribo-link with these arguments: its output, and its messages if it fails as expected."""
        done = subprocess.run([LINK, "-d", self.port, *map(str, arguments)], capture_output=True, text=True, timeout=600, check=False)
        assert done.returncode == status, done.stdout + done.stderr
        return done.stdout if status == 0 else done.stdout + done.stderr

    def value(self, name):
        """A line of tribo-link status."""
        line = next(line for line in self.link("status").splitlines() if line.startswith(f"{name}: "))
        return float(line.split()[1])

    def poll(self, *arguments, status=0):
        """mbpoll with these arguments: its lines of values."""
        command = ["mbpoll", "-m", "rtu", "-b", "115200", "-P", "none", "-0", "-1", "-q", "-o", "10", *map(str, arguments)]
        port = command.index("-o")  # the device comes before values to be written
        values = []
        if "--" in command:
            values = command[command.index("--") + 1:]
            command = command[:command.index("--")]
        done = subprocess.run([*command, self.port, *values], capture_output=True, text=True, timeout=600, check=False)
        assert done.returncode == status and port, done.stdout + done.stderr
        return done.stdout + done.stderr


@pytest.fixture(params=["f32", "q31"])
def arithmetic(request):
    return request.param


@pytest.fixture
def start(arithmetic):
    drives = []

    def start_drive(flash=None):
        drives.append(Drive(arithmetic, flash))
        return drives[-1]

    yield start_drive
    for drive in drives:
        if drive.bus >= 0:
            drive.close()


@pytest.fixture
def drive(start):
    return start()
