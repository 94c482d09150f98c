"""tribo-desk, tribo-drive on a simulated rig, in a folder of its own, and programs that talk to it over a pty."""

import contextlib
import csv
import os
import pathlib
import random
import re
import select
import signal
import socket
import subprocess
import termios
import threading
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LINK = os.environ["TRIBO_LINK"]

# Ticks from a file are late on a machine that others load as well.
RIG = "scenario: loop.yaml\nrealtime: {required: no}\nheartbeat_ms: 10000\n"
LOOP = "duration_s: 5\nreference: {kind: triangle, low_N: 0.4, high_N: 0.6, period_s: 4}\nmetrics: {start_s: 1}\n"

# On the clock of a machine that others load as well.
CLOCK_RIG = "scenario: loop.yaml\nrealtime: {required: no, catch_up_ms: 10000}\nheartbeat_ms: 10000\n"


def until(has_happened, what, limit_s=200):
    """Waits for it. The limit is for what never happens, and far beyond what a loaded machine takes."""
    end = time.monotonic() + limit_s
    while not has_happened():
        assert time.monotonic() < end, what
        time.sleep(0.005)


def free_port():
    """A TCP port that nobody has, below those that the system takes for outgoing connections."""
    for port in random.sample(range(20000, 32000), 100):
        with contextlib.suppress(OSError), socket.socket() as probe:
            probe.bind(("127.0.0.1", port))
            return port
    raise AssertionError("no port is free")


class Drive:
    """tribo-desk in a folder of its own, or another program."""

    def __init__(self, folder):
        self.folder = folder
        self.program = os.environ["TRIBO_DESK"]
        self.write("loop.yaml", LOOP)
        self.write("rig.yaml", RIG)

    def write(self, name, content):
        (self.folder / name).write_text(content)

    def run(self, *arguments, lines="", **options):
        """`lines` come from a file: in a pipe they could be later than the last tick."""
        self.write("lines", lines)
        with open(self.folder / "lines", encoding="ascii") as stdin:
            return subprocess.run([self.program, *arguments], cwd=self.folder, stdin=stdin, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                  text=True, timeout=600, check=False, **options)

    def ticks(self, count, *arguments, status=0, **options):
        """So many ticks of rig.yaml; its log by column, and what it said."""
        self.write("ticks", "." * count)
        run = self.run("rig.yaml", "--ticks", "ticks,/dev/null", "--log", "log.csv", *arguments, **options)
        assert run.returncode == status, run.stderr
        with open(self.folder / "log.csv", newline="", encoding="ascii") as file:
            names, *rows = csv.reader(file)
        return {name: [float(row[i]) for row in rows] for i, name in enumerate(names)}, run.stderr

    @contextlib.contextmanager
    def start(self, *arguments):
        """It ends with the block, by itself or, where the test has failed, killed."""
        with subprocess.Popen([self.program, *arguments], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
            try:
                yield run
            except BaseException:
                run.kill()
                raise

    def begin(self, *arguments):
        """Starts it on its clock. Returns its process once it has begun, and the file for its messages."""
        messages = self.folder / "said.txt"
        with open(messages, "w", encoding="utf-8") as said:
            process = subprocess.Popen([self.program, "rig.yaml", *arguments], cwd=self.folder, stderr=said)
        until(lambda: "off:" in messages.read_text() or process.poll() is not None, "it does not start")
        assert "off:" in messages.read_text(), messages.read_text()
        return process, messages

    def until(self, has_happened, what):
        until(has_happened, what)

    def until_rows(self, rows):
        """Waits until the log has so many."""
        log = self.folder / "log.csv"
        self.until(lambda: log.exists() and log.read_text().count("\n") > rows, "no rows")


class Line:
    """A serial line: two ptys and what carries bytes between them. The drive opens `drive`, a client `port`."""

    def __init__(self):
        self.masters, self.slaves = zip(*(os.openpty(), os.openpty()))
        for fd in self.masters + self.slaves:
            attributes = termios.tcgetattr(fd)
            attributes[0] = attributes[1] = attributes[3] = 0
            termios.tcsetattr(fd, termios.TCSANOW, attributes)
        self.drive, self.port = (os.ttyname(fd) for fd in self.slaves)
        self.ends = threading.Event()
        self.answers, self.asked = 0, False  # pieces of answers so far, and whether one is due
        self.thread = threading.Thread(target=self.carry, daemon=True)
        self.thread.start()

    def carry(self):
        while not self.ends.is_set():
            for fd in select.select(self.masters, [], [], 0.05)[0]:
                side = self.masters.index(fd)
                os.write(self.masters[1 - side], os.read(fd, 4096))
                self.answers, self.asked = self.answers + (side == 0), side == 1

    def cut(self):
        if not self.ends.is_set():
            self.ends.set()
            self.thread.join()
            for fd in self.masters + self.slaves:
                os.close(fd)


class Served:
    """A drive that runs on its clock, with a bus on a line; what it says on standard error goes to a file. Unless the rig has another
    drive: the reference need not be renewed, as a test's is set once."""

    def __init__(self, drive, rig="", arguments=()):
        rig += "" if "drive:" in rig else "drive: {reference_ms: 0}\n"
        self.drive, self.line = drive, Line()
        drive.write("rig.yaml", f"{CLOCK_RIG}bus: {{device: {self.line.drive}}}\n{rig}")
        self.process, self.messages = drive.begin(*arguments)

    def said(self):
        return self.messages.read_text()

    def wait_for(self, what):
        until(lambda: what in self.said() or self.process.poll() is not None, f"no '{what}'")
        assert what in self.said(), self.said()

    def pass_ticks(self, count):
        """Waits for ticks of the drive, which are behind the clock's on a loaded machine."""
        end = self.value("tick") + count
        until(lambda: self.value("tick") >= end, "the drive does not tick")

    def link(self, *arguments, status=0):
        done = subprocess.run([os.environ["TRIBO_LINK"], "-d", self.line.port, *map(str, arguments)], capture_output=True, text=True,
                              timeout=600, check=False)
        assert done.returncode == status, done.stdout + done.stderr + self.said()
        return done.stdout if status == 0 else done.stdout + done.stderr

    @contextlib.contextmanager
    def host(self, r_n):
        """A tribo-link that renews its reference until the end."""
        before = self.line.answers
        link = subprocess.Popen([os.environ["TRIBO_LINK"], "-d", self.line.port, "reference", str(r_n)], stderr=subprocess.DEVNULL)
        until(lambda: self.line.answers > before + 3, "it does not renew")
        yield
        assert link.poll() is None
        link.terminate()
        link.wait(timeout=300)

    def value(self, name):
        line = next(line for line in self.link("status").splitlines() if line.startswith(f"{name}: "))
        return float(line.split()[1])

    def end(self):
        if self.process.poll() is None:
            self.process.terminate()
        self.process.wait(timeout=300)
        self.line.cut()
        return self.said()


@pytest.fixture
def drive(tmp_path):
    return Drive(tmp_path)


@pytest.fixture
def serve(drive):
    """Starts a drive with a bus; more than one is one after the other."""
    served = []

    def start(*arguments, **options):
        for before in served:
            before.end()
        served.append(Served(drive, *arguments, **options))
        return served[-1]

    yield start
    for one in served:
        one.end()


class Demo:
    def __init__(self, folder):
        self.folder = folder
        self.said = folder / "said.txt"
        with open(self.said, "w", encoding="utf-8") as said:
            self.process = subprocess.Popen([ROOT / "tools/link/demo-drive", "--port", "0"], stdout=said, stderr=said, cwd=folder,
                                            env={**os.environ, "TMPDIR": str(folder)})
        until(lambda: "Ctrl-C" in self.text() or self.process.poll() is not None, "it does not start")
        self.tcp, self.line = re.search(r"runs at (\S+) and on (\S+)\. ", self.text()).groups()

    def text(self):
        return self.said.read_text(encoding="utf-8")

    def link(self, *arguments, device=None, status=0):
        for _ in range(1 if status else 5):  # a loaded machine may not schedule the drive within the 2 s that tribo-link waits
            done = subprocess.run([LINK, *map(str, arguments)], capture_output=True, text=True, timeout=600, check=False,
                                  env={**os.environ, "TRIBO_LINK_DEVICE": device or self.tcp})
            if "no answer from unit" not in done.stderr:
                break
        assert done.returncode == status, done.stdout + done.stderr
        return done.stdout + (done.stderr if status else "")

    def folders(self):
        return list(self.folder.glob("tribo-demo-*"))


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    made = Demo(tmp_path_factory.mktemp("demo"))
    yield made
    made.process.send_signal(signal.SIGINT)
    made.process.wait(timeout=300)
