"""tribo-drive on a simulated rig: its command line, its configuration, its log. Ticks come from a file, so no load can disturb them."""

import csv
import os
import pathlib
import re
import signal
import subprocess
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PI = ROOT / "firmware" / "port" / "linux" / "raspberry_pi"

RIG = "scenario: loop.yaml\nio: simulated\nrealtime: {required: no}\n"
DEVICES = """scenario: loop.yaml
sensor: {device: adc, channel: voltage0}
pwm: {chip: pwmchip0}
lines:
  enable: {name: enable}
  emergency_stop: {name: stop}
"""
LOOP = "duration_s: 5\nreference: {kind: triangle, low_N: 0.4, high_N: 0.6, period_s: 4}\nmetrics: {start_s: 1}\n"


class Drive:
    """tribo-drive in a folder of its own."""

    def __init__(self, folder):
        self.folder = folder
        self.program = os.environ["TRIBO_DRIVE"]
        self.write("loop.yaml", LOOP)
        self.write("rig.yaml", RIG)

    def write(self, name, content):
        (self.folder / name).write_text(content)

    def run(self, *arguments, **options):
        return subprocess.run([self.program, *arguments], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                              timeout=60, check=False, **options)

    def ticks(self, count, *arguments, status=0, **options):
        """So many ticks of rig.yaml; its log by column, and what it said."""
        self.write("ticks", "." * count)
        run = self.run("rig.yaml", "--ticks", "ticks,/dev/null", "--log", "log.csv", *arguments, **options)
        assert run.returncode == status, run.stderr
        with open(self.folder / "log.csv", newline="", encoding="ascii") as file:
            names, *rows = csv.reader(file)
        return {name: [float(row[i]) for row in rows] for i, name in enumerate(names)}, run.stderr

    def start(self, *arguments):
        return subprocess.Popen([self.program, *arguments], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def until_rows(self, rows):
        """Waits until the log has so many."""
        for _ in range(2000):
            log = self.folder / "log.csv"
            if log.exists() and log.read_text().count("\n") > rows:
                return
            time.sleep(0.005)
        raise AssertionError("no rows")


@pytest.fixture
def drive(tmp_path):
    return Drive(tmp_path)


@pytest.mark.parametrize("rig, message", [
    (RIG + "drive: {period_us: 5}\n", "rig.yaml:4: drive.period_us: 5 is outside 10 to 100000"),
    (RIG + "drive: {period_us: .nan}\n", "rig.yaml:4: drive.period_us: "),
    (RIG + "drive: {late_us: 1000}\n", "rig.yaml:4: drive.late_us: 1000 is outside 0 to 999"),
    (RIG + "drive: {period_us: 1000.5}\n", "rig.yaml:4: drive.period_us: 1000.5 is no whole number"),
    (RIG + "drive: {period_us: 2000}\n", "rig.yaml:4: drive.period_us: 2000 is not the scenario's sample_time_s of 0.001"),
    (RIG + "heartbeat_ms: 1\n", "rig.yaml:4: heartbeat_ms: 1 is outside 2 to 10000"),
    (RIG + "pwm: {period_ns: 0}\n", "rig.yaml:4: pwm.period_ns: 0 is outside 100 to 1e+09"),
    (RIG + "heartbeats: 1\n", "rig.yaml:4: unknown key heartbeats"),
    (RIG + "output: relay\n", "rig.yaml:4: output: "),
    ("io: simulated\n", "rig.yaml: scenario: is missing"),
    ("scenario: nothing.yaml\nio: simulated\n", "nothing.yaml"),
    (DEVICES.replace("device: adc, ", ""), "rig.yaml:2: sensor.device: is missing"),
    (DEVICES.replace("chip: pwmchip0", "channel: 1"), "rig.yaml:3: pwm.chip: is missing"),
    (DEVICES.replace("  enable: {name: enable}\n", ""), "rig.yaml:4: lines.enable: is missing"),
    (DEVICES.replace("  emergency_stop: {name: stop}\n", ""), "rig.yaml:4: lines.emergency_stop: is missing"),
    (DEVICES.replace("{name: stop}", "{name: stop, chip: 1}"), "has a name and a chip, one of them is wanted"),
    (DEVICES + "drive: {ready_ms: 5}\n", "lines.ready: is missing, drive.ready_ms is not 0"),
    (DEVICES + "output: dac\n", "rig.yaml: dac.device: is missing"),
    ("", "rig.yaml"),
    ("scenario: [\n", "rig.yaml:"),
])
def test_what_is_wrong_is_named(drive, rig, message):
    drive.write("rig.yaml", rig)
    run = drive.run("rig.yaml", "--check")
    assert run.returncode == 1
    assert run.stderr.startswith("tribo-drive: ")
    assert message in run.stderr


@pytest.mark.parametrize("arguments", [[], ["a.yaml", "b.yaml"], ["rig.yaml", "--duration", "0"], ["rig.yaml", "--duration", "nan"],
                                       ["rig.yaml", "--ticks", "one"], ["rig.yaml", "--nothing"]])
def test_a_wrong_command_line_is_refused(drive, arguments):
    assert drive.run(*arguments).returncode == 2


def test_a_configuration_that_is_not_there(drive):
    run = drive.run("none.yaml")
    assert run.returncode == 1 and "none.yaml" in run.stderr


def test_check_runs_no_tick(drive):
    run = drive.run("rig.yaml", "--check", "--log", "log.csv")
    assert run.returncode == 0
    assert "nothing has moved" in run.stdout
    assert not (drive.folder / "log.csv").exists()


def test_it_tracks_as_tribo_sim_does(drive):
    log, said = drive.ticks(5000)
    assert "5000 rows, 0 dropped" in said and "5000 ticks, 0 overruns" in said
    assert log["t_s"] == [pytest.approx(k * 1e-3, abs=1e-7) for k in range(5000)]
    subprocess.run([os.environ["TRIBO_SIM"], "run", "loop.yaml", "--out", "sim"], cwd=drive.folder, check=True, stdout=subprocess.PIPE)
    with open(drive.folder / "sim" / "trace.csv", newline="", encoding="ascii") as file:
        trace = list(csv.DictReader(file))
    # The same but for float32 at the converters.
    for ours, theirs in (("r_N", "r_N"), ("u_N", "u_N")):
        assert log[ours] == pytest.approx([float(row[theirs]) for row in trace], abs=2e-5)


def test_replay_reads_the_log(drive):
    drive.ticks(3000)
    run = subprocess.run([os.environ["TRIBO_SIM"], "replay", "log.csv", "--force=measured", "--out", "out.csv"], cwd=drive.folder,
                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    assert run.returncode == 0, run.stdout
    assert (drive.folder / "out.csv").read_text().count("\n") == 3001


def test_a_constant_reference(drive):
    log, _ = drive.ticks(2000, "--reference", "0.3")
    assert log["r_N"] == pytest.approx([0.3] * 2000)
    assert log["F_N"][-1] == pytest.approx(0.3, abs=0.02)


def test_a_shape_as_reference(drive):
    log, _ = drive.ticks(200, "--reference", "sine")
    assert log["r_N"][0] == pytest.approx(0.5)
    run = drive.run("rig.yaml", "--reference", "square")
    assert run.returncode == 1 and "square" in run.stderr and "triangle" in run.stderr


def test_a_file_as_reference(drive):
    drive.write("r.csv", "t_s,r_N\n0,0.1\n0.1,0.2\n")
    log, _ = drive.ticks(101, "--reference", "r.csv")
    assert log["r_N"][50] == pytest.approx(0.15)


def test_lines_as_reference(drive):
    log, _ = drive.ticks(100, "--reference", "-", input="0.1\n0.25\n")
    assert log["r_N"][-1] == pytest.approx(0.25)


@pytest.mark.parametrize("line", ["much\n", "nan\n", "1 2\n", "9" * 100 + "\n"])
def test_a_line_that_is_no_number_ends_the_run(drive, line):
    _, said = drive.ticks(100, "--reference", "-", input=line, status=1)
    assert "standard input" in said


def test_set_changes_the_scenario(drive):
    log, _ = drive.ticks(10, "--set", "reference.kind=step", "--set", "reference.high_N=0.2")
    assert log["r_N"][-1] == pytest.approx(0.2)


def test_a_fault_ends_it(drive):
    drive.write("rig.yaml", RIG + "drive: {command_limit_ms: 5}\n")
    log, said = drive.ticks(1000, "--set", "limits.u_max_N=0.1", "--reference", "1", status=3)
    assert 5 < len(log["t_s"]) < 1000
    assert log["fault"][-1] != 0 and log["u_N"][-1] == 0
    assert "limit" in said


def test_a_log_that_cannot_be_made(drive):
    run = drive.run("rig.yaml", "--log", "nowhere/log.csv")
    assert run.returncode == 1 and "--log nowhere/log.csv: No such file" in run.stderr


CLOCK = RIG + "heartbeat_ms: 5000\ndrive: {period_us: 20000, late_us: 19999, budget_us: 20000, residual_n: 0, command_limit_ms: 0}\n"
SLOW = ("duration_s: 60\nsample_time_s: 0.02\nreference: {kind: step, low_N: 0.2, high_N: 0.2}\nplant: {step_s: 0.0001}\n"
        "compensator: {gain: 0, friction: {pulse_width_s: 0.02}}\n"
        "controller: {kind: z, sections: [{b0: 0.01, b1: 0, b2: 0, a1: -1, a2: 0}]}\n")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_in_order(drive, number):
    drive.write("rig.yaml", CLOCK)
    drive.write("loop.yaml", SLOW)
    with drive.start("rig.yaml", "--log", "log.csv") as run:
        drive.until_rows(2)
        run.send_signal(number)
        _, said = run.communicate(timeout=30)
    rows = (drive.folder / "log.csv").read_text().count("\n") - 1
    assert run.returncode in (0, 3), said  # 3: a loaded machine was late
    assert f"{rows} rows, 0 dropped" in said


def test_a_killed_loop_is_told(drive):
    drive.write("rig.yaml", CLOCK)
    drive.write("loop.yaml", SLOW)
    with drive.start("rig.yaml", "--log", "log.csv") as run:
        drive.until_rows(2)
        loop = pathlib.Path(f"/proc/{run.pid}/task/{run.pid}/children").read_text().split()
        os.kill(int(loop[0]), signal.SIGKILL)
        _, said = run.communicate(timeout=30)
    assert run.returncode == 128 + signal.SIGKILL
    assert "ended by signal 9, stopped" in said


def test_a_duration_ends_it(drive):
    log, said = drive.ticks(100, "--duration", "0.05")
    assert len(log["t_s"]) == 50 and "50 ticks" in said


def test_the_watchdog_is_fed(drive):
    drive.write("rig.yaml", RIG + "watchdog: dog\n")
    drive.write("dog", "")
    drive.ticks(1000)
    assert re.fullmatch(r"\.+V", (drive.folder / "dog").read_text())


def test_the_table_of_keys_is_current(drive):
    assert drive.run("--keys").stdout in (ROOT / "docs" / "linux.md").read_text()


def test_the_man_page_has_all_options(drive):
    page = (PI.parent / "tribo-drive.1").read_text().replace("\\", "")
    options = re.findall(r"--([a-z]+)", drive.run("--help").stdout)
    assert len(options) > 8
    assert [option for option in options if f"--{option}" not in page] == []


def test_the_example_fits_its_loop(drive):
    """All but its devices: its loop and its bounds, on the plant of its scenario."""
    drive.write("rig.yaml", (PI / "rig.yaml").read_text().replace("scenario: loop.yaml", "scenario: loop.yaml\nio: simulated"))
    drive.write("loop.yaml", (PI / "loop.yaml").read_text())
    assert drive.run("rig.yaml", "--check").returncode == 0
    run = drive.run(str(PI / "rig.yaml"), "--check")
    assert run.returncode == 1 and re.search("lines.enable .*no such line", run.stderr)
