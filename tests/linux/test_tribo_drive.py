"""tribo-drive, and tribo-desk in its place where a plant is simulated: its command line, its configuration, its log. Ticks come from a file, so no load can disturb them."""

import contextlib
import csv
import os
import pathlib
import re
import resource
import shutil
import signal
import struct
import subprocess
import sys
import time

import pytest

from conftest import CLOCK_RIG, LOOP, RIG

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))
from version import VERSION  # noqa: E402
PI = ROOT / "firmware" / "port" / "linux" / "raspberry_pi"

DRIVE = os.environ["TRIBO_DRIVE"]

DEVICES = """scenario: loop.yaml
sensor: {device: adc, channel: voltage0}
pwm: {chip: pwmchip0}
lines:
  enable: {name: enable}
  emergency_stop: {name: stop}
watchdog: none
"""


@pytest.mark.parametrize("rig, message", [
    (RIG + "drive: {period_us: 5}\n", "rig.yaml:4: drive.period_us: 5 is outside 10 to 100000"),
    (RIG + "drive: {period_us: .nan}\n", "rig.yaml:4: drive.period_us: "),
    (RIG + "drive: {late_us: 1000}\n", "rig.yaml:4: drive.late_us: 1000 is outside 0 to 999"),
    (RIG + "drive: {safe_reference_n: -2, over_current_ms: 1.5}\n", "rig.yaml:4: drive.over_current_ms: 1.5 is not a whole number"),
    (RIG + "drive: {period_us: 2000}\n", "rig.yaml:4: drive.period_us: 2000 is not the scenario's sample_time_s of 0.001"),
    (RIG.replace("10000", "1"), "rig.yaml:3: heartbeat_ms: 1 is outside 2 to 10000"),
    (RIG + "pwm: {period_ns: 0}\n", "rig.yaml:4: pwm.period_ns: 0 is outside 100 to 1e+09"),
    (RIG + "heartbeats: 1\n", "rig.yaml:4: unknown key heartbeats"),
    (RIG + "output: relay\n", "rig.yaml:4: output: "),
    ("heartbeat_ms: 10\n", "rig.yaml: scenario: is missing"),
    ("scenario: nothing.yaml\n", "nothing.yaml"),
    (RIG.replace("loop.yaml", "trapeze"), "trapeze: cannot be opened: No such file or directory"),
    (DEVICES.replace("device: adc, ", ""), "rig.yaml:2: sensor.device: is missing"),
    (DEVICES.replace("chip: pwmchip0", "channel: 1"), "rig.yaml:3: pwm.chip: is missing"),
    (DEVICES.replace("  enable: {name: enable}\n", ""), "rig.yaml:4: lines.enable: is missing"),
    (DEVICES.replace("  emergency_stop: {name: stop}\n", ""), "rig.yaml:4: lines.emergency_stop: is missing"),
    (DEVICES.replace("{name: stop}", "{name: stop, chip: 1}"), "has a name and a chip: give only one of them"),
    (DEVICES + "drive: {ready_ms: 5}\n", "lines.ready: is missing; a drive.ready_ms other than 0 needs it"),
    (DEVICES + "output: dac\n", "rig.yaml: dac.device: is missing"),
    (DEVICES.replace("watchdog: none\n", ""), "rig.yaml: watchdog: is missing: give a device, e.g. /dev/watchdog, or none, with which a "
     "kernel that hangs leaves the outputs as they are"),
    (DEVICES.replace("none", "/dev/watchdog7"), "watchdog: /dev/watchdog7: No such file or directory"),
    (DEVICES + "watchdog_s: 61\n", "rig.yaml:8: watchdog_s: 61 is outside 1 to 60"),
    (DEVICES + "ready_off_ms: 10001\n", "rig.yaml:8: ready_off_ms: 10001 is outside 0 to 10000"),
    (DEVICES + "heartbeat_ticks: 0\n", "rig.yaml:8: heartbeat_ticks: 0 is outside 1 to 1000"),
    (DEVICES + "read_back: maybe\n", "rig.yaml:8: read_back: "),
    (DEVICES + "realtime: {cpu: 1000}\n", "realtime.cpu: value 1000: must be a CPU that this process may run on"),
    (DEVICES + "realtime: {catch_up_ms: 1}\n", "rig.yaml:8: realtime.catch_up_ms: is only for tribo-desk"),
    ("", "rig.yaml"),
    ("scenario: [\n", "rig.yaml:"),
])
def test_what_is_wrong_is_named(drive, rig, message):
    drive.program = DRIVE if "lines:" in rig else drive.program
    drive.write("rig.yaml", rig)
    run = drive.run("rig.yaml", "--check")
    assert run.returncode == 1
    assert run.stderr.startswith(f"{pathlib.Path(drive.program).name}: ")
    assert message in run.stderr


@pytest.mark.parametrize("arguments", [[], ["a.yaml", "b.yaml"], ["rig.yaml", "--duration", "0"], ["rig.yaml", "--duration", "nan"],
                                       ["rig.yaml", "--ticks", "one"], ["rig.yaml", "--nothing"]])
def test_a_wrong_command_line_is_refused(drive, arguments):
    assert drive.run(*arguments).returncode == 2


def test_a_missing_configuration(drive):
    run = drive.run("none.yaml")
    assert run.returncode == 1 and "none.yaml" in run.stderr


def test_check_runs_no_tick(drive):
    run = drive.run("rig.yaml", "--check", "--log", "log.csv")
    assert run.returncode == 0
    assert "nothing has moved" in run.stdout
    assert not (drive.folder / "log.csv").exists()


def simulate(drive):
    subprocess.run([os.environ["TRIBO_SIM"], "run", "loop.yaml", "--out", "sim"], cwd=drive.folder, check=True, stdout=subprocess.PIPE)
    with open(drive.folder / "sim" / "trace.csv", newline="", encoding="ascii") as file:
        return list(csv.DictReader(file))


def test_it_tracks_as_tribo_sim_does(drive):
    log, said = drive.ticks(5000)
    overruns = int(re.search("5000 ticks, 0 late, (\\d+) overruns", said)[1])
    longest_us = float(re.search(r"step: .* longest ([\d.]+) us", said)[1])  # budget_us is 250; a loaded machine may take longer
    assert "5000 rows, 0 dropped" in said and (overruns > 0) == (longest_us > 250.0)
    assert log["t_s"] == [pytest.approx(k * 1e-3, abs=1e-7) for k in range(5000)]
    trace = simulate(drive)
    # The same but for float32 at the converters.
    for ours, theirs in (("r_N", "r_N"), ("u_N", "u_N")):
        assert log[ours] == pytest.approx([float(row[theirs]) for row in trace], abs=2e-5)


def test_it_feeds_friction_forward_as_tribo_sim_does(drive):
    drive.write("loop.yaml", LOOP + "compensator: {method: feedforward}\n")
    log, _ = drive.ticks(5000)
    assert log["u_N"] == pytest.approx([float(row["u_N"]) for row in simulate(drive)], abs=2e-5)
    paper, _ = drive.ticks(5000, "--set", "compensator.method=paper")
    assert max(abs(a - b) for a, b in zip(log["u_N"], paper["u_N"])) > 0.01


def test_it_needs_no_sensor_as_tribo_sim_does(drive):
    drive.write("loop.yaml", LOOP + "compensator: {sensor: none}\n")
    refused = drive.run("rig.yaml", "--check")
    assert refused.returncode == 1
    assert "rig.yaml: drive.residual_n: 0.109999999 does not suit the devices and the loop: 0 to 0 is expected" in refused.stderr
    drive.write("rig.yaml", RIG + "drive: {residual_n: 0, tracking_n: 0}\n")
    log, said = drive.ticks(5000)
    assert "off: stuck_ticks residual_n" in said and set(log["F_N"]) == {0}
    assert log["u_N"] == pytest.approx([float(row["u_N"]) for row in simulate(drive)], abs=2e-5)


@pytest.mark.parametrize("arguments, message", [
    ([], "rig.yaml: sensor.device: is missing"),
    (["--set", "compensator.sensor=none"], "lines.enable ('enable'): there is no such line"),
    (["--set", "compensator.sensor=none", "--set", "compensator.method=paper"], "compensator.sensor: none is allowed only with"),
])
def test_devices_without_a_sensor_go_with_a_loop_that_needs_none(drive, arguments, message):
    drive.write("rig.yaml", DEVICES.replace("sensor: {device: adc, channel: voltage0}\n", ""))
    drive.program = DRIVE
    run = drive.run("rig.yaml", "--check", *arguments)
    assert run.returncode == 1 and message in run.stderr, run.stderr


def test_its_guard_fades_compensation_as_in_tribo_sim(drive):
    # Half of the friction that the loop believes in.
    drive.write("loop.yaml", LOOP + "plant: {friction: {breakaway: {offset_N: 0.0035, slope: 0.15}}}\n"
                "compensator: {method: paper, gain: 1}\n")
    log, said = drive.ticks(5000)
    assert "warning: " in said
    assert log["u_N"] == pytest.approx([float(row["u_N"]) for row in simulate(drive)], abs=1e-4)
    unguarded, said = drive.ticks(5000, "--set", "compensator.guard.on=no")
    assert "warning: " not in said and max(abs(a - b) for a, b in zip(log["u_N"], unguarded["u_N"])) > 0.01


@pytest.mark.parametrize("loop, arguments, message", [
    ("", [], "lines.enable ('enable'): there is no such line"),
    ("plant: {model: rubber}\nsensor: 3\nmetrics: []\n", [], "lines.enable ('enable'): there is no such line"),
    ("", ["--set", "plant.model=lugre"], "--set plant.model=lugre: unknown key plant.model"),
    ("compensator: {gain: 3}\n", [], "loop.yaml:2: compensator.gain: 3 is outside 0 to 2"),
    ("compensator: {gian: 1}\n", [], "loop.yaml:2: unknown key compensator.gian, did you mean compensator.gain?"),
    ("compensator: {friction: {pulse_width_s: 1}}\n", [], "loop.yaml:2: compensator.friction.pulse_width_s: 1 s is refused: "),
    ("plants: {}\n", [], "loop.yaml:2: unknown key plants, did you mean plant?"),
])
def test_the_drive_reads_the_loop_of_a_scenario_alone(drive, loop, arguments, message):
    drive.write("rig.yaml", DEVICES)
    drive.write("loop.yaml", "reference: {kind: sine}\n" + loop)
    drive.program = DRIVE
    run = drive.run("rig.yaml", "--check", *arguments)
    assert run.returncode == 1 and message in run.stderr, run.stderr


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


@pytest.mark.parametrize("value, said", [
    ("2e-41", "too small to be meant: 0, or at least 1e-09 N in size"), ("-1.6e-23", "too small to be meant: 0, or at least 1e-09 N in size"),
    ("1e-400", "too small to be meant"), ("1e400", "is too large for a number"), ("0,5", "is not a number"), ("5N", "is not a number")])
def test_what_was_meant_as_a_number_is_no_name_of_a_shape(drive, value, said):
    run = drive.run("rig.yaml", "--check", f"--reference={value}")
    assert run.returncode != 0 and f"--reference {value}: {said}" in run.stderr and "kind" not in run.stderr


def test_the_least_force_that_is_meant(drive):
    for value in ("0", "-0", "0e-50", "1e-9", "-1e-9"):
        assert drive.run("rig.yaml", "--check", f"--reference={value}").returncode == 0


def test_a_shape_as_reference(drive):
    log, _ = drive.ticks(200, "--reference", "sine")
    assert log["r_N"][0] == pytest.approx(0.5)
    run = drive.run("rig.yaml", "--reference", "square")
    assert run.returncode == 1 and "square" in run.stderr and "triangle" in run.stderr


def test_a_file_as_reference(drive):
    drive.write("r.csv", "t_s,r_N\n0,0.1\n0.1,0.2\n")
    log, _ = drive.ticks(101, "--reference", "r.csv")
    assert log["r_N"][50] == pytest.approx(0.15)


@pytest.mark.parametrize("words, name", [
    (("--reference", "5"), "--reference: 5 N"), (("--reference", "-2.5"), "--reference: 2.5 N"),
    (("--set", "reference.high_N=3"), "reference: 3 N"), (("--reference", "r.csv"), "reference: 2.01 N")])
def test_a_reference_beyond_the_loops_range_is_refused(drive, words, name):
    drive.write("r.csv", "t_s,r_N\n0,0.1\n0.1,-2.01\n")
    run = drive.run("rig.yaml", "--check", *words)
    assert run.returncode == 1 and f"{name}: must be within -2 to 2 N, the range of limits.input_max_N" in run.stderr


@pytest.mark.parametrize("required, status", [("yes", 1), ("no", 0)])
def test_a_desk_wants_the_cpu_as_its_run_does(drive, required, status):
    drive.write("rig.yaml", f"scenario: loop.yaml\nrealtime: {{cpu: 1000, required: {required}}}\n")
    run = drive.run("rig.yaml", "--check")
    assert run.returncode == status and "realtime.cpu: value 1000: must be a CPU that this process may run on" in run.stderr


@pytest.mark.parametrize("name", ["sine", "sine.yaml"])
def test_a_scenario_that_comes_with_the_program_goes_by_its_name(drive, name):
    drive.write("rig.yaml", RIG.replace("loop.yaml", name))
    assert drive.ticks(100)[0]["r_N"][0] == pytest.approx(0.5)
    drive.write(name, LOOP)  # the configuration's own folder comes first
    assert drive.ticks(100)[0]["r_N"][0] == pytest.approx(0.4)


def test_a_scenario_that_cannot_be_looked_at_has_no_substitute(drive):
    (drive.folder / "sine.yaml").symlink_to("sine.yaml")
    drive.write("rig.yaml", RIG.replace("loop.yaml", "sine.yaml"))
    run = drive.run("rig.yaml", "--check")
    assert run.returncode == 1 and "sine.yaml: cannot be opened: Too many levels of symbolic links" in run.stderr


def test_a_line_beyond_the_loops_range_ends_the_run(drive):
    run = drive.run("rig.yaml", "--reference", "-", "--duration", "1", lines="0.1\n7\n")
    assert run.returncode == 1 and "standard input: 7 N: must be within -2 to 2 N" in run.stderr


def test_lines_as_reference(drive):
    log, _ = drive.ticks(100, "--reference", "-", lines="0.1\n0.25\n")
    assert log["r_N"][-1] == pytest.approx(0.25)


@pytest.mark.parametrize("line", ["much\n", "nan\n", "1 2\n", "9" * 100 + "\n"])
def test_a_line_that_is_not_a_number_ends_the_run(drive, line):
    _, said = drive.ticks(100, "--reference", "-", lines=line, status=1)
    assert "standard input" in said


@pytest.mark.parametrize("lines", ["0.5", "0.1\n0.5"])
def test_a_last_line_without_an_end_ends_the_run(drive, lines):
    """Its sender may have died within 0.5e-3."""
    log, said = drive.ticks(100, "--reference", "-", lines=lines, status=1)
    assert "standard input: '0.5' is not a whole line: it ends without a newline" in said
    assert max(log["r_N"]) < 0.2 and len(log["r_N"]) < 100


def test_set_changes_the_scenario(drive):
    log, _ = drive.ticks(10, "--set", "reference.kind=step", "--set", "reference.high_N=0.2")
    assert log["r_N"][-1] == pytest.approx(0.2)


def test_a_fault_ends_it(drive):
    drive.write("rig.yaml", RIG + "drive: {command_limit_ms: 5}\n")
    log, said = drive.ticks(1000, "--set", "limits.u_max_N=0.1", "--reference", "1", status=3)
    assert 5 < len(log["t_s"]) < 1000
    assert log["fault"][-1] != 0 and log["u_N"][-1] == 0
    assert "limit" in said


SHADOW_BYTES = 64 << 20  # nothing of the drive's is so large, but a sanitizer's own memory is


def poke(process, old, new):
    """Changes a float wherever it is in the memory of the loop's process."""
    loop = int(pathlib.Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()[0])
    found = 0
    with open(f"/proc/{loop}/mem", "r+b", buffering=0) as memory:
        for line in pathlib.Path(f"/proc/{loop}/maps").read_text().splitlines():
            (first, end), rights = (int(x, 16) for x in line.split()[0].split("-")), line.split()[1]
            if not rights.startswith("rw") or "[v" in line or "/dev" in line or end - first > SHADOW_BYTES:
                continue
            memory.seek(first)
            content = memory.read(end - first)
            for at in [at for at in range(0, len(content) - 3, 4) if content[at:at + 4] == struct.pack("<f", old)]:
                memory.seek(first + at)
                memory.write(struct.pack("<f", new))
                found += 1
    return found


def test_params_that_change_by_themselves_stop_a_drive_without_a_bus(drive):
    drive.write("rig.yaml", RIG + "drive: {residual_n: 0.1234567}\n")
    os.mkfifo(drive.folder / "ticks")
    (drive.folder / "done").touch()
    with drive.start("rig.yaml", "--ticks", "ticks,done") as process:
        with open(drive.folder / "ticks", "wb", buffering=0) as ticks:
            ticks.write(b"." * 2000)
            drive.until(lambda: (drive.folder / "done").stat().st_size == 2000, "no ticks")
            assert poke(process, 0.1234567, 0.7) > 0
            with contextlib.suppress(BrokenPipeError):
                ticks.write(b"." * 2000)
        _, said = process.communicate(timeout=300)
    assert process.returncode == 3 and "fault: params changed" in said, said


def test_the_feed_forwards_poles_are_the_residuals_unless_the_configuration_names_them(drive):
    wrong = ["--set", "compensator.feedforward.sensor_pole_rad_per_s=2", "--reference", "0.8"]
    assert "sensor and model differ" in drive.ticks(1000, *wrong, status=3)[1]
    drive.ticks(1000, *wrong, "--set", "compensator.method=paper")
    drive.write("rig.yaml", RIG + "drive: {sensor_pole_rad_per_s: 55}\n")
    drive.ticks(1000, *wrong)
    drive.write("rig.yaml", RIG + "drive: {actuator_pole_rad_per_s: 200}\n")
    assert "sensor and model differ" in drive.ticks(1000, *wrong, status=3)[1]
    slow = ["--set", "compensator.feedforward.actuator_pole_rad_per_s=2", "--reference", "0.8"]
    drive.ticks(1000, *slow)


@pytest.mark.parametrize("log, why", [
    ("nowhere/log.csv", "No such file or directory"), (".", "Is a directory"), ("old.csv", "it is read-only"), ("rig.yaml", "this run reads it"), ("loop.yaml", "this run reads it"),
    ("ref.csv", "this run reads it"), ("store.bin", "this run reads it"), ("link/rig.yaml", "this run reads it")])
@pytest.mark.parametrize("check", [[], ["--check"]])
def test_a_log_that_cannot_be_made_or_would_replace_an_input(drive, log, why, check):
    drive.write("rig.yaml", RIG + "store: store.bin\n")
    drive.write("ref.csv", "t_s,r_N\n0,0\n1,0.1\n")
    (drive.folder / "link").symlink_to(".")
    for name in ("store.bin", "old.csv"):
        drive.write(name, "")
    (drive.folder / "old.csv").chmod(0o444)
    before = {path.name: path.read_bytes() for path in drive.folder.iterdir() if path.is_file()}
    run = drive.run("rig.yaml", "--reference", "ref.csv", "--log", log, *check)
    assert run.returncode == 1 and run.stderr.endswith(f"{log}: cannot be written: {why}\n")
    assert {path.name: path.read_bytes() for path in drive.folder.iterdir() if path.is_file() and path.name != "lines"} == before


CLOCK = RIG + "drive: {period_us: 20000, late_us: 19999, budget_us: 20000, residual_n: 0, command_limit_ms: 0}\n"
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
        _, said = run.communicate(timeout=300)
    rows = (drive.folder / "log.csv").read_text().count("\n") - 1
    assert run.returncode in (0, 3), said  # 3: a loaded machine was late
    assert f"{rows} rows, 0 dropped" in said


def test_a_killed_loop_is_reported(drive):
    drive.write("rig.yaml", CLOCK_RIG)
    with drive.start("rig.yaml", "--duration", "600", "--log", "log.csv") as run:
        drive.until_rows(2)
        loop = pathlib.Path(f"/proc/{run.pid}/task/{run.pid}/children").read_text().split()
        os.kill(int(loop[0]), signal.SIGKILL)
        _, said = run.communicate(timeout=300)
    assert run.returncode == 128 + signal.SIGKILL
    assert "ended by signal 9, stopped" in said


def test_late_ticks_are_made_up(drive):
    """10 s at 1 kHz on this machine, however late it wakes up, and once stopped for 0.3 s: each tick is made, and each is in the log."""
    drive.write("rig.yaml", CLOCK_RIG)
    with drive.start("rig.yaml", "--duration", "10", "--log", "log.csv") as run:
        drive.until_rows(1000)
        loop = int(pathlib.Path(f"/proc/{run.pid}/task/{run.pid}/children").read_text().split()[0])
        os.kill(loop, signal.SIGSTOP)
        time.sleep(0.3)
        os.kill(loop, signal.SIGCONT)
        _, said = run.communicate(timeout=600)
    assert run.returncode == 0, said
    assert "log: 10000 rows, 0 dropped\n10000 ticks, " in said
    with open(drive.folder / "log.csv", newline="", encoding="ascii") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["t_s"]) for row in rows] == [pytest.approx(k * 1e-3, abs=1e-7) for k in range(10000)]
    assert {row["fault"] for row in rows} == {"0"} and {row["state"] for row in rows} == {"1"}
    # It is told how late they were, and the simulated time knows nothing of it.
    assert max(float(row["late_us"]) for row in rows) > 250e3
    late, wake = int(re.search("ticks, ([0-9]+) late", said)[1]), re.search("wake-up: .*longest ([0-9.]+) us;(.*)", said)
    assert late >= 250 and float(wake[1]) > 250e3
    assert sum(int(part.split()[1]) for part in wake[2].split("<")[1:]) == 10000
    by_ticks, _ = drive.ticks(10000)
    assert [float(row["u_N"]) for row in rows] == by_ticks["u_N"]


def test_more_than_the_bound_late_is_a_fault(drive):
    drive.write("rig.yaml", CLOCK_RIG.replace("catch_up_ms: 10000", "catch_up_ms: 1500"))
    with drive.start("rig.yaml", "--duration", "10", "--log", "log.csv") as run:
        drive.until_rows(100)
        loop = int(pathlib.Path(f"/proc/{run.pid}/task/{run.pid}/children").read_text().split()[0])
        os.kill(loop, signal.SIGSTOP)
        time.sleep(1.8)
        os.kill(loop, signal.SIGCONT)
        _, said = run.communicate(timeout=600)
    assert run.returncode == 3 and "fault: tick missed since tick" in said, said


@pytest.mark.parametrize("required, status", [("yes", 1), ("no", 0)])
def test_without_the_privileges_it_says_so(drive, required, status):
    """As nobody in particular, with no right to real time. Of locking first, unless a sanitizer has made mlockall() do nothing."""
    sanitized = b"__asan_init" in pathlib.Path(drive.program).read_bytes()
    what = "realtime.priority: SCHED_FIFO 80: " if sanitized else "memory cannot be locked: "
    def drop():
        for limit in (resource.RLIMIT_RTPRIO, resource.RLIMIT_MEMLOCK):
            resource.setrlimit(limit, (0, 0))

    drive.write("rig.yaml", CLOCK_RIG.replace("required: no", f"required: {required}"))
    shutil.copy(drive.program, drive.folder / "tribo-desk")
    drive.program = "./tribo-desk"
    drive.folder.chmod(0o755)
    run = drive.run("rig.yaml", "--duration", "0.1", preexec_fn=drop, **({"user": 65534, "group": 65534} if os.geteuid() == 0 else {}))
    assert "tribo-desk: no real time: " + what in run.stderr
    assert run.returncode == status
    assert ("100 ticks" in run.stderr) == (status == 0)


@pytest.mark.parametrize("what, limits", [("the thread of --log cannot be started", {resource.RLIMIT_STACK: 1 << 46}), ("no real time", {resource.RLIMIT_RTPRIO: 0, resource.RLIMIT_MEMLOCK: 0})])
@pytest.mark.parametrize("old", [None, "t_s,r_N\n0,1\n"])
def test_a_run_that_cannot_begin_leaves_the_log_as_it_was(drive, what, limits, old):
    """No thread has room for a stack as large as the limit of one."""
    if resource.RLIMIT_STACK in limits and b"__asan_init" in pathlib.Path(drive.program).read_bytes():
        pytest.skip("a sanitizer sizes the stacks of threads itself")

    def restrict():
        for limit, value in limits.items():
            resource.setrlimit(limit, (value, value))

    log = drive.folder / "log.csv"
    drive.write("rig.yaml", CLOCK_RIG.replace("required: no", "required: yes"))
    shutil.copy(drive.program, drive.folder / "tribo-desk")
    drive.program = "./tribo-desk"
    drive.folder.chmod(0o777)
    if old is not None:
        log.write_text(old)
        log.chmod(0o666)
    run = drive.run("rig.yaml", "--duration", "0.1", "--log", "log.csv", preexec_fn=restrict, **({"user": 65534, "group": 65534} if os.geteuid() == 0 else {}))
    assert run.returncode == 1 and f"tribo-desk: {what}" in run.stderr
    assert (log.read_text() if log.exists() else None) == old


def test_a_log_on_standard_output_follows_what_is_there(drive):
    drive.write("all.csv", "before\n")
    drive.write("ticks", "." * 20)
    with open(drive.folder / "all.csv", "a", encoding="ascii") as out:
        run = subprocess.run([drive.program, "rig.yaml", "--ticks", "ticks,/dev/null", "--log", "/dev/stdout"], cwd=drive.folder, stdout=out, stderr=subprocess.PIPE, text=True,
                             timeout=600, check=False)
    assert run.returncode == 0, run.stderr
    lines = (drive.folder / "all.csv").read_text().splitlines()
    assert lines[0] == "before" and lines[1].startswith("t_s,r_N") and len(lines) == 22


@pytest.mark.parametrize("number, words, said", [(1, ("--log", "/dev/stdout"), "--log /dev/stdout: Bad file descriptor"), (0, ("--reference", "-"), "standard input: cannot be read: Bad file descriptor")])
def test_a_closed_stream_that_is_used_ends_the_run(drive, number, words, said):
    drive.write("ticks", "." * 20)
    run = subprocess.run([drive.program, "rig.yaml", "--ticks", "ticks,/dev/null", *words], cwd=drive.folder, stderr=subprocess.PIPE, text=True, timeout=600, check=False,
                         preexec_fn=lambda: os.close(number))
    assert run.returncode == 1 and f"tribo-desk: {said}\n" in run.stderr, run


def test_an_option_is_given_once(drive):
    for words, said in ((("--duration", "1", "--dur=2"), "--duration 1 and --duration 2: only one is expected"), (("--check", "-c"), "--check is given twice"),
                        (("--set", "duration_s=1", "--set", "reference.kind=sine", "--set", "duration_s=2"), "--set duration_s=1 and --set duration_s=2: only one is expected")):
        run = drive.run("rig.yaml", *words)
        assert run.returncode == 2 and f": {said}\n" in run.stderr, run


def test_a_duration_ends_it(drive):
    log, said = drive.ticks(100, "--duration", "0.05")
    assert len(log["t_s"]) == 50 and "50 ticks" in said


def test_a_waived_watchdog_is_reported(drive):
    drive.program = DRIVE
    drive.write("rig.yaml", DEVICES)
    assert "watchdog: none, so nothing turns the outputs off if the kernel hangs\n" in drive.run("rig.yaml", "--check").stderr


def test_a_desk_arms_no_watchdog(drive):
    drive.write("rig.yaml", RIG + "watchdog: dog\n")
    drive.write("dog", "")
    drive.ticks(100)
    assert (drive.folder / "dog").read_text() == ""


def names_of(pid):
    """What killall, pkill and pidof look at."""
    process = pathlib.Path(f"/proc/{pid}")
    return {(process / "comm").read_text().strip(), pathlib.Path((process / "cmdline").read_bytes().split(b"\0")[0].decode()).name}


def test_one_killall_does_not_take_both_processes(drive):
    drive.write("rig.yaml", CLOCK_RIG)
    with drive.start("rig.yaml", "--duration", "600", "--log", "log.csv") as run:
        drive.until_rows(2)
        loop = int(pathlib.Path(f"/proc/{run.pid}/task/{run.pid}/children").read_text())
        named = {pid: names_of(pid) for pid in (run.pid, loop)}
        for pid in (pid for pid, names in named.items() if pathlib.Path(drive.program).name in names):
            os.kill(pid, signal.SIGKILL)
        _, said = run.communicate(timeout=600)
    assert named == {run.pid: {"tribo-safe"}, loop: {pathlib.Path(drive.program).name}}
    assert run.returncode == 128 + signal.SIGKILL
    assert f"{pathlib.Path(drive.program).name}: the loop's process was ended by signal 9, stopped" in said


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="there is no systemd-analyze")
def test_the_unit_is_exposed_by_4_at_most(tmp_path):
    unit = tmp_path / "tribo-drive.service"
    unit.write_text((PI.parent / "tribo-drive.service.in").read_text().replace("@bindir@", "/usr/bin"))
    run = subprocess.run(["systemd-analyze", "security", "--offline=yes", "--threshold=40", "--no-pager", unit], stdout=subprocess.PIPE,
                         stderr=subprocess.STDOUT, text=True, check=False)
    assert run.returncode == 0, run.stdout
    # As a user that the package makes.
    assert "\nUser=tribo\n" in unit.read_text() and "\nu tribo " in (PI.parent / "tribo.sysusers").read_text()


def test_the_table_of_keys_takes_nothing_else(drive):
    for words in (("--keys", "rig.yaml"), ("--check", "--keys"), ("--keys", "--log", "x.csv")):
        run = drive.run(*words)
        assert run.returncode == 2 and run.stdout == "" and "--keys goes with nothing else" in run.stderr


@pytest.mark.parametrize("words", [["--keys"], ["rig.yaml", "--check"], ["--help"], ["-?"], ["--usage"], ["--version"], ["-V"], ["rig.yaml", "--help"]])
def test_output_that_cannot_be_written_is_an_error(drive, words):
    with open("/dev/full", "w", encoding="ascii") as full:
        run = subprocess.run([drive.program, *words], cwd=drive.folder, stdout=full, stderr=subprocess.PIPE, text=True, timeout=600, check=False)
    assert run.returncode == 1 and run.stderr.endswith("tribo-desk: standard output: cannot be written: No space left on device\n")


def test_the_table_of_keys_says_what_each_is(drive):
    header, _, *lines = drive.run("--keys").stdout.splitlines()
    rows = re.findall(r"^\| `([^`]+)` \| [^|]+ \| [^|]+ \| [^|]+ \| (?:[^|]|\\\|){3,} \|$", "\n".join(lines), re.M)
    assert header == "| key | unit | range | default | meaning |" and len(rows) == len(lines) > 90 and {"scenario", "sensor.device", "lines.enable.name", "drive.swing_ms"} <= set(rows)


def test_version(drive):
    assert drive.run("--version").stdout == f"tribo-desk {VERSION}\n"


def test_the_example_fits_its_loop(drive):
    """All but its devices: its loop and its bounds, on the plant of its scenario."""
    rig = (PI / "rig.yaml").read_text().replace("cpu: 3}", f"cpu: {min(os.sched_getaffinity(0))}}}")  # one that this process may use
    drive.write("rig.yaml", rig)
    drive.write("loop.yaml", (PI / "loop.yaml").read_text())
    assert drive.run("rig.yaml", "--check").returncode == 0
    assert "\nwatchdog: /dev/watchdog " in rig  # which may be this machine's
    drive.write("rig.yaml", rig.replace("watchdog: /dev/watchdog", "watchdog: none"))
    drive.program = DRIVE
    run = drive.run("rig.yaml", "--check")
    assert run.returncode == 1 and re.search("lines.enable .*no such line", run.stderr)
