"""The emulated drive's bus, asked by programs that are not of this project (mbpoll, and libmodbus in tribo-link): params, commands,
traces, and power that fails while params are saved."""

import csv
import os
import random
import re
import subprocess
import sys
import threading
import time

import pytest

from conftest import EMERGENCY_STOP, ROOT, SIM

sys.path.insert(0, str(ROOT / "tests" / "support"))
from version import VERSION  # noqa: E402

TRIANGLE = ROOT / "host_sim" / "scenarios" / "triangle.yaml"
COMMAND, REFERENCE, GAIN, ACTIVE = 0x100, 0x110, 0x1108, 0x1000


def test_version(drive):
    assert drive.link("--version") == f"tribo-link {VERSION}\n"


def test_mbpoll_reads_and_writes(drive):
    assert re.search(r"\[0\]: *\t*10\b", drive.poll("-t", "4:int", "-B", "-r", 0, "-c", 1))  # the lists' version
    assert "0.85" in drive.poll("-t", "4:float", "-B", "-r", GAIN, "-c", 1)
    drive.poll("-t", "4:float", "-B", "-r", GAIN, "--", 0.5)  # function 16, into the staged set
    assert "0.85" in drive.poll("-t", "4:float", "-B", "-r", GAIN + ACTIVE, "-c", 1)
    drive.poll("-t", "4", "-r", COMMAND, "--", 5)  # function 6: apply
    assert "0.5" in drive.poll("-t", "4:float", "-B", "-r", GAIN + ACTIVE, "-c", 1)
    drive.poll("-t", "4", "-r", COMMAND, "--", 1)
    drive.poll("-t", "4:float", "-B", "-r", REFERENCE, "--", 0.5)
    drive.pass_s(1)
    assert drive.state == 1 and abs(drive.force - 0.5) < 0.05
    drive.poll("-t", "4", "-r", COMMAND, "--", 2)
    drive.pass_s(0.1)
    assert drive.state == 0 and drive.command == 0.0


def test_mbpoll_gets_the_exceptions(drive):
    assert "Illegal data address" in drive.poll("-t", "4", "-r", 0x0fff, "-c", 1, status=1)
    assert "Illegal function" in drive.poll("-t", "3", "-r", 0, "-c", 1, status=1)
    assert "Illegal data value" in drive.poll("-t", "4", "-r", COMMAND, "--", 99, status=1)
    assert "Illegal data address" in drive.poll("-t", "4", "-r", GAIN, "--", 1, status=1)  # half a register
    assert "Slave device or server failure" in drive.poll("-t", "4", "-r", COMMAND, "--", 3, status=1)  # nothing to acknowledge
    assert "timed out" in drive.poll("-a", 2, "-t", "4", "-r", 0, "-c", 1, status=1)  # nobody's address


def test_a_broadcast_stops_and_does_nothing_else(drive):
    """No client sends such a frame, so the test writes its bytes out, with their CRC. Nobody answers it."""
    bad = drive.value("bad_frames")
    line = os.open(drive.port, os.O_RDWR | os.O_NOCTTY)
    os.write(line, bytes.fromhex("000601000001") + bytes.fromhex("4827"))  # start
    drive.pass_s(0.2)
    assert os.read(line, 100) == b"" and drive.state == 0
    os.close(line)
    drive.link("start")
    line = os.open(drive.port, os.O_RDWR | os.O_NOCTTY)
    os.write(line, bytes.fromhex("0006010000020827"))  # stop, with a wrong CRC
    drive.pass_s(0.2)
    assert drive.state == 1
    os.write(line, bytes.fromhex("000601000002") + bytes.fromhex("0826"))
    drive.until(lambda: drive.state == 0, "it does not stop")
    assert os.read(line, 100) == b""
    os.close(line)
    assert drive.value("bad_frames") == bad + 1


def test_params_are_set_while_the_drive_runs(drive):
    drive.link("start")
    drive.link("reference", 0.4)
    drive.pass_s(1)
    drive.link("params", "set", "compensator.gain=0.3", "compensator.friction.k_max=25")
    assert drive.link("params", "get", "compensator.gain", "compensator.friction.k_max") == \
        "compensator.gain: 0.300000012\ncompensator.friction.k_max: 25\n"
    message = drive.link("params", "set", "compensator.gain=0.5", "compensator.friction.k_min=26", status=2)
    assert "compensator.friction.k_min = 26 is refused, the drive goes on as it was: 1.01 to 1000; friction k_min: 1.01 to 1000; at most k_max" in message
    assert drive.link("params", "get", "compensator.gain") == "compensator.gain: 0.300000012\n"
    assert drive.state == 1 and abs(drive.force - 0.4) < 0.05
    drive.link("stop")


def test_params_come_from_a_scenario(drive, tmp_path):
    scenario = tmp_path / "other.yaml"
    paper = TRIANGLE.read_text() + "compensator:\n  method: paper\n  guard: {on: no}\n"
    scenario.write_text(paper)
    assert drive.link("params", "diff", scenario) == ""
    scenario.write_text(paper + ("  gain: 0.6\n  friction: {breakaway: {table: "
                        "[{force_N: 0, positive_N: 0.01, negative_N: 0.02}, {force_N: 1, positive_N: 0.3, negative_N: 0.4}]}}\n"))
    different = drive.link("params", "diff", scenario, status=1)
    assert "compensator.gain: 0.850000024 in the drive, 0.600000024 in" in different
    assert "compensator.friction.breakaway.table[1].negative_N: 0 in the drive, 0.400000006 in" in different
    drive.link("params", "from", scenario)
    assert drive.link("params", "diff", scenario) == ""
    assert "table[1].negative_N: 0.400000006\n" in drive.link("params", "get")
    scenario.write_text(TRIANGLE.read_text() + "compensator: {feedforward: {sensor_pole_rad_per_s: 90}}\n")
    drive.link("params", "from", scenario)
    assert "\ndrive.sensor_pole_rad_per_s: 90\n" in drive.link("params", "get")  # the residual's as well, which protects
    assert "drive.sensor_pole_rad_per_s from 55 to 90" in drive.link("changes")
    scenario.write_text("nonsense: 1\n")
    assert "nonsense" in drive.link("params", "from", scenario, status=2)


def test_a_fault_is_reported_and_its_trace_can_be_replayed(drive, tmp_path):
    assert drive.link("fault") == "fault: none\n"
    drive.link("start")
    drive.link("reference", 0.4)
    drive.pass_s(1)
    drive.inputs = EMERGENCY_STOP
    drive.until(lambda: drive.state == 2, "no fault")
    drive.pass_s(0.2)
    assert "the drive is in fault: emergency stop" in drive.link("fault", "--acknowledge", status=2)
    log = tmp_path / "fault.csv"
    assert drive.link("fault", "--out", log).startswith("fault: emergency stop, since tick ")
    rows = list(csv.DictReader(log.open()))
    assert len(rows) == 216 and list(rows[0]) == ["t_s", "r_N", "F_N", "u_N", "F_hat_N"]
    running = [float(row["u_N"]) for row in rows[:200]]
    assert all(u > 0.1 for u in running) and all(float(row["u_N"]) == 0.0 for row in rows[200:])
    done = subprocess.run([SIM, "replay", log, "--out", tmp_path / "estimate.csv"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert len((tmp_path / "estimate.csv").read_text().splitlines()) == 217
    drive.inputs = 0
    assert "refused" in drive.link("start", status=2)
    drive.link("fault", "--acknowledge")
    drive.link("start")


def test_a_trace_is_read_while_the_drive_runs(drive, tmp_path):
    drive.link("start")
    log = tmp_path / "step.csv"
    drive.link("reference", 0.4)
    drive.pass_s(1)
    recorded = threading.Event()

    def knock():  # again, as the client may take its time to ask for the trace
        while not recorded.is_set():
            drive.pass_s(1)
            drive.knock()

    knocking = threading.Thread(target=knock, daemon=True)
    knocking.start()
    drive.link("trace", "--signals", "F_N,e_N,u_N", "--trigger", "rise", "--watch", "F_N", "--level", "0.2", "--after", "50",
               "--wait", "300", "--out", log)
    recorded.set()
    knocking.join()
    rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(log.open())]
    assert drive.state == 1
    trigger = len(rows) - 51
    assert rows[trigger]["F_N"] >= 0.2 > rows[trigger - 1]["F_N"]
    assert all(abs(row["F_N"] + row["e_N"] - 0.4) < 1e-6 for row in rows[trigger:])
    assert all(abs(row["t_s"] - 0.001 * i) < 1e-9 for i, row in enumerate(rows))
    drive.link("trace", "--wait", "2", "--decimation", "5", "--out", log)
    assert len(log.read_text().splitlines()) > 20
    said = drive.link("trace", "--trigger", "fault", "--after", "100000", status=2)
    most = re.search(r"trace: --after 100000: 0 to (\d+) is expected, because the drive holds no more samples of so many signals", said)
    assert most, said
    assert "trace: the trigger fault did not come" in drive.link("trace", "--trigger", "fault", "--after", most[1], "--wait", "0", status=2)
    assert f"0 to {most[1]} is expected" in drive.link("trace", "--trigger", "fault", "--after", int(most[1]) + 1, status=2)


def test_saved_params_outlive_the_power(start, tmp_path):
    flash = tmp_path / "flash"
    flash.write_bytes(b"")
    drive = start(flash)
    assert drive.value("store") == 1
    drive.link("params", "set", "compensator.gain=0.5")
    drive.link("params", "save")
    drive.cut_power()
    drive = start(flash)
    assert drive.value("store") == 0
    assert drive.link("params", "get", "compensator.gain") == "compensator.gain: 0.5\n"
    drive.link("start")
    assert "refused: the drive is in run: tribo-link stop ends that" in drive.link("params", "save", status=2)


def test_a_damaged_store_is_reported_and_needs_a_new_set(start, tmp_path):
    flash = tmp_path / "flash"
    flash.write_bytes(b"")
    drive = start(flash)
    drive.link("params", "save")
    drive.cut_power()
    content = bytearray(flash.read_bytes())
    content[100] ^= 1
    flash.write_bytes(content)
    drive = start(flash)
    assert drive.link("fault").startswith("fault: saved params damaged")
    assert "a set must be applied first" in drive.link("fault", "--acknowledge", status=2)
    drive.link("params", "from", TRIANGLE)
    drive.link("fault", "--acknowledge")
    drive.link("params", "save")
    drive.cut_power()
    assert start(flash).value("store") == 0


def test_power_that_fails_in_a_save_leaves_the_old_params_or_the_new(start, tmp_path):
    flash = tmp_path / "flash"
    flash.write_bytes(b"")
    seen = set()
    drive = start(flash)
    drive.link("params", "set", "compensator.gain=0.5")
    drive.link("params", "save")
    old = 0.5
    for i in range(6):
        new = round(0.6 + 0.05 * i, 2)
        drive.link("params", "set", f"compensator.gain={new}")
        drive.poll("-t", "4", "-r", COMMAND, "--", 8)
        time.sleep(random.Random(i).uniform(0.0, 0.12))
        drive.cut_power()
        drive = start(flash)
        assert drive.value("store") == 0
        found = round(float(drive.link("params", "get", "compensator.gain").split()[1]), 6)
        assert found in (old, new)
        seen.add(found == new)
        old = found
    assert seen  # which of the two depends on the machine


def test_wrong_arguments_are_reported(drive):
    assert "there is no param compensator.gian" in drive.link("params", "set", "compensator.gian=1", status=2)
    assert "did you mean compensator.gain" in drive.link("params", "set", "gain=1", status=2)
    assert "compensator.gain=3: 0 to 2" in drive.link("params", "set", "compensator.gain=3", status=2)
    assert "compensator.gain=nan" in drive.link("params", "set", "compensator.gain=nan", status=2)
    assert "a whole number is expected" in drive.link("params", "set", "drive.late_us=1.5", status=2)
    assert "compensator.guard.on=maybe: is not no or yes, nor their number from 0" in \
        drive.link("params", "set", "compensator.guard.on=maybe", status=2)
    assert "NAME=VALUE is expected" in drive.link("params", "set", status=2)
    assert "params frobnicate: get, set, save" in drive.link("params", "frobnicate", status=2)
    assert "params: get, set, save" in drive.link("params", status=2)
    assert "there is no command frobnicate" in drive.link("frobnicate", status=2)
    assert "unknown signal q_N" in drive.link("trace", "--signals", "q_N", status=2)
    assert "reference 7: outside -2 to 2 N (limits.input_max_N)" in drive.link("reference", 7, status=2)
    assert "no answer from unit 9" in drive.link("-u", 9, "status", status=2)
    drive.port = "/dev/no/such/line"
    assert "/dev/no/such/line: No such file or directory" in drive.link("status", status=2)


def test_the_guard_and_what_is_learned(drive, tmp_path):
    drive.link("params", "set", "compensator.method=feedforward", "compensator.guard.on=true", "compensator.guard.stray_N=0.02")
    assert drive.link("params", "get", "compensator.guard.on", "compensator.guard.stray_N") == \
        "compensator.guard.on: 1\ncompensator.guard.stray_N: 0.0199999996\n"
    message = drive.link("params", "set", "compensator.guard.quick_time_s=101", status=2)  # over 100,000 samples
    assert "compensator.guard.quick_time_s = 101 is refused, the drive goes on as it was: 1e-06 to 1000" in message
    status = drive.link("status")
    assert "\nwarnings: 0  # none\n" in status and "\nfriction_fade: 1\n" in status
    assert float(re.search(r"\nlearned_positive_relative_variance: (\S+)\n", status)[1]) == pytest.approx(1)
    assert "\nlearned_negative_travel_N: 0 N\n" in status
    assert "\nfriction_harms: 0\n" in status and "\nlearned_forgotten: 0\n" in status
    drive.link("restore")
    drive.link("forget")
    guarded = tmp_path / "guarded.yaml"
    guarded.write_text(TRIANGLE.read_text() + "compensator: {method: paper, guard: {on: yes, turn_N: 0.04}}\n")
    drive.link("params", "from", guarded)
    assert drive.link("params", "diff", guarded) == ""
    assert drive.link("params", "get", "compensator.guard.turn_N", "compensator.method") == \
        "compensator.guard.turn_N: 0.0399999991\ncompensator.method: 0\n"
    drive.link("params", "from", TRIANGLE)
