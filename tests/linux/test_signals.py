"""Whatever signal reaches whichever process of tribo-drive, or takes its terminal away, enable goes off at once. The devices write down
what they are told (recorded_devices.c); all else is the real program. Its heartbeat of 10 s has no part in this, but where it is named.

20 ms are of a machine that has time for the drive. On one that others load a try may be late, and then counts as none."""

import contextlib
import errno
import fcntl
import mmap
import os
import pathlib
import signal
import struct
import subprocess
import termios
import time

import pytest

from conftest import until

RIG = """scenario: loop.yaml
sensor: {device: adc, channel: voltage0}
output: dac
dac: {device: dac, channel: voltage0}
lines: {enable: {name: enable}, emergency_stop: {name: stop}}
watchdog: none
ready_off_ms: 0
realtime: {required: no}
drive: {period_us: 20000, late_us: 19999, budget_us: 20000, residual_n: 0, command_limit_ms: 0, tracking_n: 0}
"""
LOOP = ("duration_s: 60\nsample_time_s: 0.02\nreference: {kind: step, low_N: 0.2, high_N: 0.2}\nplant: {step_s: 0.0001}\n"
        "compensator: {gain: 0, friction: {pulse_width_s: 0.02}}\n"
        "controller: {kind: z, sections: [{b0: 0.01, b1: 0, b2: 0, a1: -1, a2: 0}]}\n")
OFF_MS = 20
TRIES = 40


class Recorded:
    """A running drive with enable on."""

    def __init__(self, folder, heartbeat_ms, arguments, options):
        (folder / "loop.yaml").write_text(LOOP)
        (folder / "rig.yaml").write_text(f"{RIG}heartbeat_ms: {heartbeat_ms}\n")
        (folder / "record").write_bytes(bytes(4096))
        self.folder, self.said = folder, folder / "said.txt"
        with open(folder / "record", "r+b") as file:
            self.record = mmap.mmap(file.fileno(), 4096)
        with open(self.said, "wb") as said:
            self.process = subprocess.Popen([os.environ["TRIBO_RECORDED"], "rig.yaml", *arguments], cwd=folder, stdout=subprocess.DEVNULL,
                                            **{"stderr": said, "stdin": subprocess.DEVNULL, **options},
                                            env={**os.environ, "TRIBO_RECORD": str(folder / "record")})
        until(lambda: (self.is_on() and self.ticks() > 5) or self.process.poll() is not None, "it does not start")
        assert self.process.poll() is None or "tick missed" in self.said.read_text(), self.said.read_text()
        children = pathlib.Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
        self.loop = int((children.read_text().split() if children.exists() else [0])[0])

    def word(self, index):
        return struct.unpack_from("<q", self.record, 8 * index)[0]

    def is_on(self):
        return self.word(0) == 1

    def ticks(self):
        return self.word(3)

    def runs(self):
        """It has not been late on a loaded machine."""
        return self.is_on() and self.process.poll() is None

    def ms_to_off(self, begin_ns):
        """Once it has ended, both of it."""
        self.process.wait(timeout=300)
        until(lambda: not self.is_on(), "enable stays on")
        until(lambda: not pathlib.Path(f"/proc/{self.loop}").exists(), "the loop's process stays")
        return (self.word(2) - begin_ns) / 1e6

    def end(self):
        for pid in (self.process.pid, self.loop):
            for number in (signal.SIGCONT, signal.SIGKILL):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, number)
        self.process.wait(timeout=300)
        self.record.close()


def measure(folder, act, heartbeat_ms=10000, arguments=("--reference", "0.2"), limit_ms=OFF_MS, **options):
    """Starts a drive, acts on it, and waits until enable is off; again if the machine was too slow for it. What it said, and its exit
    status."""
    worst = []
    for _ in range(TRIES):
        drive = Recorded(folder, heartbeat_ms, arguments, options)
        try:
            if not drive.runs():
                continue
            begin_ns = time.monotonic_ns()
            act(drive)
            worst.append(drive.ms_to_off(begin_ns))
            if worst[-1] <= limit_ms and "tick missed" not in drive.said.read_text():
                assert drive.word(4) == 0  # and the output
                return drive.said.read_text(), drive.process.returncode
        finally:
            drive.end()
    raise AssertionError(f"enable off after {worst} ms")


# Ignored by default; the last ones are the C library's own, and end a process.
HARMLESS = {signal.SIGCHLD, signal.SIGCONT, signal.SIGURG, signal.SIGWINCH}
CATCHABLE = [number for number in range(1, signal.SIGRTMAX + 1) if number not in HARMLESS | {signal.SIGKILL, signal.SIGSTOP}]
OF_THE_LIBRARY = {32, 33}


@pytest.mark.parametrize("number", CATCHABLE)
def test_any_signal_to_the_supervisor(tmp_path, number):
    said, status = measure(tmp_path, lambda drive: os.kill(drive.process.pid, number))
    assert status == (-number if number in OF_THE_LIBRARY else 0), said
    assert "ticks, " in said


@pytest.mark.parametrize("number", CATCHABLE)
def test_any_signal_to_the_loop(tmp_path, number):
    said, status = measure(tmp_path, lambda drive: os.kill(drive.loop, number))
    assert status == (128 + number if number in OF_THE_LIBRARY else 0), said
    assert "ticks, " in said or number in OF_THE_LIBRARY


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGINT, signal.SIGQUIT, signal.SIGTERM, signal.SIGTSTP, signal.SIGUSR1, signal.SIGTTIN])
def test_a_signal_to_the_group(tmp_path, number):
    measure(tmp_path, lambda drive: os.killpg(drive.process.pid, number), start_new_session=True)


def test_what_is_ignored_by_default_stops_nothing(tmp_path):
    def act(drive):
        for number in HARMLESS:
            for pid in (drive.process.pid, drive.loop):
                os.kill(pid, number)
        ticks = drive.ticks()
        until(lambda: drive.ticks() > ticks + 20 or not drive.runs(), "it does not tick")
        assert drive.runs() or "tick missed" in drive.said.read_text()
        os.kill(drive.process.pid, signal.SIGTERM)

    measure(tmp_path, act, limit_ms=1e6)


def prepare_deaf():
    """Starts below nohup, and from a program that has blocked each signal that can be blocked."""
    for number in CATCHABLE:
        if number not in OF_THE_LIBRARY:
            signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGTERM, signal.SIGQUIT, signal.SIGPIPE])
@pytest.mark.parametrize("to_loop", [False, True])
def test_whatever_its_parent_has_ignored_or_blocked(tmp_path, number, to_loop):
    _, status = measure(tmp_path, lambda drive: os.kill(drive.loop if to_loop else drive.process.pid, number), preexec_fn=prepare_deaf)
    assert status == 0


# --- what cannot be caught ---------------------------------------------------------------------------------------------

@pytest.mark.parametrize("to_loop", [False, True], ids=["supervisor", "loop"])
def test_kill_9_of_either(tmp_path, to_loop):
    measure(tmp_path, lambda drive: os.kill(drive.loop if to_loop else drive.process.pid, signal.SIGKILL))


def test_kill_9_of_the_group(tmp_path):
    measure(tmp_path, lambda drive: os.killpg(drive.process.pid, signal.SIGKILL), start_new_session=True)


@pytest.mark.parametrize("who", ["supervisor", "loop", "group"])
def test_a_stop_of_either_is_seen_by_the_other(tmp_path, who):
    """enable goes off within the heartbeat. The supervisor stays stopped, so the test waits for enable alone."""
    def act(drive):
        os.kill(drive.loop if who == "loop" else drive.process.pid, signal.SIGSTOP) if who != "group" else os.killpg(drive.process.pid, signal.SIGSTOP)
        until(lambda: not drive.is_on(), "enable stays on")
        os.kill(drive.process.pid, signal.SIGCONT)

    said, _ = measure(tmp_path, act, heartbeat_ms=400, limit_ms=10000, start_new_session=True)
    assert ("no heartbeat for 400 ms, stopped" if who == "loop" else "tribo-safe has not looked for 400 ms, stopped") in said


# --- a terminal --------------------------------------------------------------------------------------------------------

class Terminal:
    """The leader of the session is the drive, or a shell that has it in the foreground."""

    def __init__(self):
        self.master, self.slave = os.openpty()

    def take(self):
        os.setsid()
        fcntl.ioctl(self.slave, termios.TIOCSCTTY, 0)

    def hang_up(self):
        os.close(self.slave)
        os.close(self.master)
        self.master = -1

    def end(self):
        for fd in (self.master, self.slave):
            with contextlib.suppress(OSError):
                os.close(fd)


@pytest.fixture
def terminal():
    made = []

    def start():
        made.append(Terminal())
        return made[-1]

    yield start
    for one in made:
        one.end()


@pytest.mark.parametrize("key", [b"\x03", b"\x1c", b"\x1a", None], ids=["Ctrl-C", "Ctrl-backslash", "Ctrl-Z", "hang-up"])
@pytest.mark.parametrize("reference", ["0.2", "-"], ids=["a constant", "from the terminal"])
def test_a_terminal(tmp_path, terminal, key, reference):
    for _ in range(TRIES):
        line = terminal()
        drive = Recorded(tmp_path, 10000, ["--reference", reference], {"preexec_fn": line.take, "stdin": line.slave})
        try:
            if not drive.runs():
                continue
            begin_ns = time.monotonic_ns()
            if key is None:
                line.hang_up()
            else:
                os.write(line.master, key)
            took_ms = drive.ms_to_off(begin_ns)
            assert drive.process.returncode in (0, 3)  # a reference that has not come, or a late tick
            if took_ms <= OFF_MS:
                return
        finally:
            drive.end()
    raise AssertionError("enable is not off in time")


def test_a_job_in_the_background_reads_its_reference(tmp_path, terminal):
    """The terminal would stop a process of its own session that reads it from there."""
    line = terminal()
    code = ("import os,subprocess,sys; subprocess.Popen(sys.argv[1:], preexec_fn=lambda: os.setpgid(0, 0)).wait()")
    (tmp_path / "loop.yaml").write_text(LOOP)
    (tmp_path / "rig.yaml").write_text(f"{RIG}heartbeat_ms: 10000\n".replace("tracking_n: 0", "tracking_n: 0, reference_ms: 0"))
    (tmp_path / "record").write_bytes(bytes(4096))
    shell = subprocess.Popen(["/usr/bin/python3", "-c", code, os.environ["TRIBO_RECORDED"], "rig.yaml", "--reference", "-", "--duration", "1"],
                             cwd=tmp_path, preexec_fn=line.take, stdin=line.slave, stderr=subprocess.PIPE, text=True,
                             env={**os.environ, "TRIBO_RECORD": str(tmp_path / "record")})
    os.write(line.master, b"0.1\n")
    _, said = shell.communicate(timeout=300)
    assert "50 ticks, " in said or "tick missed" in said, said


# --- begin and end -----------------------------------------------------------------------------------------------------

def test_a_signal_at_any_time_of_the_start_and_of_the_end(tmp_path):
    """Enable is off in the end, however early or late it comes."""
    for step in range(60):
        (tmp_path / "record").write_bytes(bytes(4096))
        (tmp_path / "loop.yaml").write_text(LOOP)
        (tmp_path / "rig.yaml").write_text(f"{RIG}heartbeat_ms: 10000\n")
        run = subprocess.Popen([os.environ["TRIBO_RECORDED"], "rig.yaml", "--reference", "0.2", "--duration", "0.06"], cwd=tmp_path,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env={**os.environ, "TRIBO_RECORD": str(tmp_path / "record")})
        time.sleep(0.002 * step)
        with contextlib.suppress(ProcessLookupError):
            run.send_signal((signal.SIGHUP, signal.SIGQUIT, signal.SIGTSTP)[step % 3])
            until(lambda: run.poll() is not None or is_stopped(run.pid), "it does not end")  # pylint: disable=cell-var-from-loop
            run.send_signal(signal.SIGCONT)
            run.send_signal(signal.SIGTERM)
        run.wait(timeout=300)
        assert struct.unpack_from("<q", (tmp_path / "record").read_bytes())[0] == 0


def is_stopped(pid):
    """Before there are two processes, and nothing moves: Ctrl-Z is still what it is to any program."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "T"
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_an_unread_log_does_not_delay_the_end(tmp_path):
    """A pipe that is full: enable is off at once, and the process ends, with the rows that were lost."""
    log = tmp_path / "log"
    os.mkfifo(log)
    reader = os.open(log, os.O_RDONLY | os.O_NONBLOCK)
    full = os.open(log, os.O_WRONLY | os.O_NONBLOCK)
    fcntl.fcntl(full, fcntl.F_SETPIPE_SZ, 4096)

    def act(drive):
        until(lambda: not fill(full), "it is not full")
        ticks = drive.ticks()
        until(lambda: drive.ticks() > ticks + 3 or not drive.runs(), "it does not tick")
        os.kill(drive.process.pid, signal.SIGTERM)

    said, status = measure(tmp_path, act, arguments=("--reference", "0.2", "--log", "log"), limit_ms=1e6)
    assert status == 1 and "--log: Connection timed out" in said and "rows, 0 dropped" not in said
    os.close(reader)
    os.close(full)


def fill(pipe):
    try:
        return os.write(pipe, b"x") > 0
    except BlockingIOError:
        return False


def test_a_log_without_a_reader_is_refused(tmp_path):
    (tmp_path / "record").write_bytes(bytes(4096))
    (tmp_path / "loop.yaml").write_text(LOOP)
    (tmp_path / "rig.yaml").write_text(RIG)
    os.mkfifo(tmp_path / "log")
    run = subprocess.run([os.environ["TRIBO_RECORDED"], "rig.yaml", "--log", "log"], cwd=tmp_path, capture_output=True, text=True, check=False,
                         env={**os.environ, "TRIBO_RECORD": str(tmp_path / "record")}, timeout=300)
    assert run.returncode == 1 and "--log log: this pipe has no reader" in run.stderr


# --- a scale that cannot be read (case of a driver that fails) -----------------------------------------------------------

@pytest.mark.parametrize("attribute", ["scale", "offset"])
@pytest.mark.parametrize("code", [errno.EIO, errno.EINVAL, errno.ETIMEDOUT, errno.EACCES, errno.ENODEV, errno.ENOENT])
def test_only_an_attribute_that_is_not_there_has_its_default(tmp_path, attribute, code):
    (tmp_path / "record").write_bytes(bytes(4096))
    (tmp_path / "loop.yaml").write_text(LOOP)
    (tmp_path / "rig.yaml").write_text(RIG)
    run = subprocess.run([os.environ["TRIBO_RECORDED"], "rig.yaml", "--check"], cwd=tmp_path, capture_output=True, text=True, check=False,
                         env={**os.environ, "TRIBO_RECORD": str(tmp_path / "record"), "TRIBO_ATTRIBUTE": f"{attribute} {code}"})
    if code == errno.ENOENT:
        assert run.returncode == 0, run.stderr
    else:
        assert run.returncode == 1
        assert f"sensor: {attribute} of voltage0 of 'adc' cannot be read: {os.strerror(code)}" in run.stderr
