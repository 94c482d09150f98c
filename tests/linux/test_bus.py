"""A running tribo-drive's bus, store and trace, by programs that are not of this port: tribo-link over a pty, mbpoll over TCP."""

import contextlib
import csv
import fcntl
import json
import os
import pathlib
import socket
import struct
import subprocess
import time

import pytest

from conftest import CLOCK_RIG, free_port, until

ROOT = pathlib.Path(__file__).resolve().parents[2]
TRIANGLE = ROOT / "host_sim" / "scenarios" / "triangle.yaml"


def rows_of(path):
    with open(path, newline="", encoding="ascii") as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def test_it_waits_for_its_start_and_holds_the_reference(serve):
    served = serve()
    assert "state: 0  # idle" in served.link("status") and served.value("q31") == 0
    assert json.loads(served.link("--json"))["state"] == 0
    served.link("start")
    assert "reference: --hold 3: drive.reference_ms is 0" in served.link("reference", 0.5, "--hold", 3, status=2) and served.value("r_N") == 0
    served.link("reference", 0.5, "--hold", 0)
    served.pass_ticks(2000)
    assert served.value("F_N") == pytest.approx(0.5, abs=0.02)
    served.link("stop")
    assert served.value("u_N") == 0 and served.value("r_N") == 0
    said = served.end()
    assert served.process.returncode == 0
    assert [line.split()[0] for line in said.splitlines() if " at tick " in line] == ["idle", "run", "idle", "idle"]


def test_params_change_while_it_runs(serve):
    served = serve()
    served.link("start")
    served.link("reference", 0.4)
    served.link("params", "set", "compensator.gain=0.3", "compensator.friction.k_max=25")
    assert served.link("params", "get", "compensator.gain", "compensator.friction.k_max") == \
        "compensator.gain: 0.300000012\ncompensator.friction.k_max: 25\n"
    assert "compensator.friction.k_min = 26 is refused" in served.link("params", "set", "compensator.friction.k_min=26", status=2)
    assert "drive.period_us = 2000 is refused" in served.link("params", "set", "drive.period_us=2000", "sample_time_s=0.002", status=2)
    assert served.link("params", "diff", TRIANGLE, status=1).startswith("compensator.gain: 0.300000012 in the drive, 0.850000024 in")
    served.link("params", "from", TRIANGLE)
    assert served.link("params", "diff", TRIANGLE) == ""
    assert served.value("state") == 1


def test_params_come_from_a_scenario(serve, tmp_path):
    served = serve()
    scenario = tmp_path / "other.yaml"
    scenario.write_text(TRIANGLE.read_text() + "compensator:\n  method: paper\n  gain: 0.6\n  guard: {on: yes, turn_N: 0.04}\n"
                        "  friction: {breakaway: {table: [{force_N: 0, positive_N: 0.01, negative_N: 0.02}, "
                        "{force_N: 1, positive_N: 0.3, negative_N: 0.4}]}}\n")
    different = served.link("params", "diff", scenario, status=1)
    assert "compensator.gain: 0.850000024 in the drive, 0.600000024 in" in different
    assert "compensator.friction.breakaway.table[1].negative_N: 0 in the drive, 0.400000006 in" in different
    served.link("params", "from", scenario)
    assert served.link("params", "diff", scenario) == ""
    params = served.link("params", "get")
    assert "table[1].negative_N: 0.400000006\n" in params and "guard.turn_N: 0.0399999991\n" in params and "compensator.method: 0\n" in params
    scenario.write_text(TRIANGLE.read_text() + "compensator: {feedforward: {sensor_pole_rad_per_s: 90}}\n")
    served.link("params", "from", scenario)
    assert "\ndrive.sensor_pole_rad_per_s: 90\n" in served.link("params", "get")  # the residual's as well, which protects
    assert "drive.sensor_pole_rad_per_s from 55 to 90" in served.link("changes")
    scenario.write_text("nonsense: 1\n")
    assert "nonsense" in served.link("params", "from", scenario, status=2)


def test_the_guard_and_what_is_learned(serve):
    served = serve()
    served.link("params", "set", "compensator.guard.on=true", "compensator.guard.stray_N=0.02")
    assert served.link("params", "get", "compensator.guard.on", "compensator.guard.stray_N") == \
        "compensator.guard.on: 1\ncompensator.guard.stray_N: 0.0199999996\n"
    message = served.link("params", "set", "compensator.guard.quick_time_s=101", status=2)  # over 100,000 samples
    assert "compensator.guard.quick_time_s = 101 is refused, the drive goes on as it was: 1e-06 to 1000" in message
    status = served.link("status")
    for line in ("warnings: 0  # none", "friction_fade: 1", "learned_positive_relative_variance: 1", "learned_negative_travel_N: 0 N",
                 "friction_harms: 0", "learned_forgotten: 0"):
        assert f"\n{line}\n" in status
    served.link("restore")
    served.link("forget")


def test_wrong_arguments_are_reported(serve):
    served = serve()
    for words, why in (
            ("params set compensator.gian=1", "there is no param compensator.gian"), ("params set gain=1", "did you mean compensator.gain"),
            ("params set compensator.gain=3", "compensator.gain=3: 0 to 2"), ("params set compensator.gain=nan", "compensator.gain=nan"),
            ("params set drive.late_us=1.5", "a whole number is expected"),
            ("params set compensator.guard.on=maybe", "compensator.guard.on=maybe: is not no or yes, nor their number from 0"),
            ("params set", "NAME=VALUE is expected"), ("params frobnicate", "params frobnicate: get, set, save"), ("params", "params: get, set, save"),
            ("frobnicate", "there is no command frobnicate"), ("reference 7", "reference 7: outside -2 to 2 N (limits.input_max_N)"),
            ("-u 9 status", "no answer from unit 9")):
        assert why in served.link(*words.split(), status=2)


def test_a_fault_waits_for_its_acknowledgement(serve, tmp_path):
    served = serve()
    served.link("params", "set", "limits.u_max_N=0.1", "drive.command_limit_ms=20")
    assert served.link("fault") == "fault: none\n"
    served.link("start")
    served.pass_ticks(500)
    served.link("reference", 1.0)
    until(lambda: "command at its limit" in served.link("fault"), "no fault")
    served.pass_ticks(100)
    log = tmp_path / "fault.csv"
    assert served.link("fault", "--out", log).startswith("fault: command at its limit, since tick ")
    rows = rows_of(log)
    assert len(rows) == 216
    assert rows[199]["u_N"] == pytest.approx(0.1) and all(row["u_N"] == 0 for row in rows[200:])
    done = subprocess.run([os.environ["TRIBO_SIM"], "replay", log, "--out", tmp_path / "estimate.csv"], capture_output=True, text=True,
                          check=False)
    assert done.returncode == 0, done.stderr
    assert "refused" in served.link("start", status=2)
    served.link("fault", "--acknowledge")
    served.link("start")
    assert "fault: command at its limit since tick" in served.end()


def test_a_trace_is_recorded_while_it_runs(serve, tmp_path):
    served = serve()
    served.link("start")
    log = tmp_path / "trace.csv"
    for high in (0.3, 0.5):
        served.link("reference", 0)
        served.pass_ticks(1000)
        before = served.line.answers
        tracing = subprocess.Popen([os.environ["TRIBO_LINK"], "-d", served.line.port, "trace", "--signals", "r_N,F_N,u_N", "--trigger", "rise",
                                    "--watch", "F_N", "--level", "0.2", "--after", "500", "--wait", "300", "--out", log])
        # The line is one client's at a time, and a trace's leaves it to others while it waits for its trigger.
        until(lambda: served.line.answers > before + 20, "it does not ask for a trace")
        served.link("reference", high)
        assert tracing.wait(timeout=300) == 0
        rows = rows_of(log)
        trigger = len(rows) - 501
        assert rows[trigger]["F_N"] >= 0.2 > rows[trigger - 1]["F_N"]
        assert rows[-1]["r_N"] == pytest.approx(high)


@pytest.mark.parametrize("trigger, why", [
    ("fault", "trace: the trigger fault did not come within 0.2 s, so nothing is written; --wait waits longer, and --trigger none records without a trigger"),
    ("reversal", "the trigger reversal did not come within 0.2 s"),
    ("rise --level 1000", "the trigger rise did not come within 0.2 s"),
    ("fall --level -1000", "the trigger fall did not come within 0.2 s")])
def test_a_trigger_that_does_not_come_is_an_error(serve, tmp_path, trigger, why):
    served = serve()
    served.link("start")
    for out in ([], ["--out", tmp_path / "trace.csv"]):
        done = subprocess.run([os.environ["TRIBO_LINK"], "-d", served.line.port, "trace", "--trigger", *trigger.split(), "--wait", "0.2", *out],
                              capture_output=True, text=True, timeout=600, check=False)
        assert done.returncode == 2 and done.stdout == "" and done.stderr.count("\n") == 1 and why in done.stderr
    assert not (tmp_path / "trace.csv").exists()


def test_signals_that_are_no_trace_are_named_before_it(serve):
    served = serve()
    many = "r_N,F_N,u_N,F_hat_N,n_N,L_N,e_N,f_hat_N,controller_N"
    for signals, why in (("", "--signals : has 0 names, 1 to 8 are expected"), (many, f"--signals {many}: has 9 names, 1 to 8 are expected"), ("r_N,u_N,r_N", "--signals r_N,u_N,r_N: r_N is given twice"),
                         ("r_N,x_N", "unknown signal x_N"), ("r_N,,u_N", "unknown signal  (tribo-link list shows them)")):
        assert why in served.link("trace", "--wait", "0.1", "--signals", signals, status=2)
    assert served.value("trace_state") == 0


def test_a_trace_that_is_not_complete_is_an_error(serve, tmp_path):
    served = serve()
    served.link("start")
    served.pass_ticks(100)
    log = tmp_path / "trace.csv"
    log.write_text("old")
    before = served.line.answers
    tracing = subprocess.Popen([os.environ["TRIBO_LINK"], "-d", served.line.port, "trace", "--trigger", "rise", "--level", "0.2", "--watch", "F_N", "--after", "9000",
                                "--decimation", "1000000", "--wait", "2", "--out", log], stderr=subprocess.PIPE, text=True)
    until(lambda: served.line.answers > before + 5, "it does not ask for a trace")
    served.link("reference", 0.5)
    assert "trace: the trigger came, but not all 9000 samples after it within 2 s, so nothing is written; a longer --wait or a smaller --after" in tracing.communicate(timeout=300)[1]
    assert tracing.returncode == 2 and log.read_text() == "old"
    assert served.link("trace", "--wait", "0.2").startswith("t_s,")


def test_a_wrong_place_is_found_before_a_trace_and_an_acknowledgement(serve, tmp_path):
    served = serve()
    (tmp_path / "old.csv").write_text("old")
    (tmp_path / "old.csv").chmod(0o444)
    for out, why in (("no/trace.csv", "No such file or directory"), (".", "Is a directory"), ("old.csv", "it is read-only")):
        message = f"{tmp_path / out}: cannot be written: {why}"
        assert message in served.link("trace", "--trigger", "fault", "--wait", "86400", "--out", tmp_path / out, status=2)
        assert message in served.link("fault", "--acknowledge", "--out", tmp_path / out, status=2)
    assert served.value("trace_state") == 0  # no trace was armed
    assert not list(tmp_path.glob(".*")) and (tmp_path / "old.csv").read_text() == "old"


@pytest.mark.parametrize("words, why", [
    ("trace --after 3", "trace: --after needs a --trigger"), ("trace --trigger none --after 3", "trace: --after needs a --trigger"),
    ("trace --trigger fault --level 1", "trace: --level needs --trigger rise or fall"),
    ("trace --trigger reversal --level 1", "trace: --level needs --trigger rise or fall"),
    ("trace --trigger fault --watch F_N", "trace: --watch needs --trigger reversal, rise or fall"),
    ("ports --device x", "ports has no option --device"), ("list --device x", "list has no option --device"), ("list --markdown -u 3", "list has no option --unit"),
    ("list --baud 9600", "list has no option --baud"), ("completion bash -d x", "completion has no option --device"), ("--unit 2 completion bash", "completion has no option --unit"),
    ("completion bash --baud 9600", "completion has no option --baud"), ("--baud 9600 -d tcp:localhost:1", "--baud: tcp:localhost:1 is no serial line"),
    ("start now", "start takes no argument, but now was given"), ("stop x", "stop takes no argument"), ("status x", "status takes no argument"),
    ("trace x", "trace takes no argument"), ("fault x", "fault takes no argument"), ("list x", "list takes no argument"),
    ("ports x", "ports takes no argument"), ("params save x", "params save takes no argument"), ("params defaults x", "params defaults takes no argument"),
    ("status --device tcp:localhost:1 --baud 9600", "--baud: tcp:localhost:1 is no serial line"),
    ("status -u 2 --unit=3", "--unit 2 and --unit 3: only one is expected"), ("status --json --json", "--json is given twice")])
def test_options_without_effect_are_refused_before_a_drive_is_queried(words, why):
    done = subprocess.run([os.environ["TRIBO_LINK"], *words.split()], capture_output=True, text=True, timeout=600, check=False,
                          env={**os.environ, "TRIBO_LINK_DEVICE": "/dev/null/none"})
    assert done.returncode == 2 and done.stdout == "" and done.stderr.startswith(f"tribo-link: {why}"), done


def test_a_param_is_set_once(serve):
    served = serve()
    was = served.link("params", "get", "compensator.gain", "limits.u_max_N")
    assert "params set compensator.gain=0.5 compensator.gain=0.7: only one is expected" in served.link("params", "set", "compensator.gain=0.5", "limits.u_max_N=1", "compensator.gain=0.7", status=2)
    assert served.link("params", "get", "compensator.gain", "limits.u_max_N") == was


def test_a_trace_that_the_ring_does_not_hold_names_the_option_and_its_range(serve):
    served = serve()
    for signals, most in (("r_N", 65535), ("r_N,F_N,u_N", 21844)):
        words = ("trace", "--trigger", "fault", "--wait", "0", "--signals", signals, "--after")
        for after in (most + 1, 4294967295):
            assert f"trace: --after {float(after):.7g}: 0 to {most} is expected, because" in served.link(*words, after, status=2)
        assert "the trigger fault did not come" in served.link(*words, most, status=2)


def test_a_line_in_use_is_refused_with_its_holder(serve):
    served = serve()
    with open(served.line.port, "rb", buffering=0) as line:
        fcntl.flock(line, fcntl.LOCK_EX)
        name = pathlib.Path("/proc/self/comm").read_text().strip()
        assert f"{served.line.port}: in use by {name}, process {os.getpid()}\n" in served.link("status", status=2)
        # One that comes free meanwhile is taken.
        late = subprocess.Popen([os.environ["TRIBO_LINK"], "-d", served.line.port, "status"], stdout=subprocess.DEVNULL)
        until(lambda: served.line.port in open_files(late.pid), "it does not open the line")
        fcntl.flock(line, fcntl.LOCK_UN)
        assert late.wait(timeout=300) == 0


@pytest.mark.parametrize("words", ["", "status", "status --json", "watch --json --hold 60", "params get", "params get compensator.gain", "changes", "fault",
                                   "list", "list --markdown", "--help", "status --help", "--usage", "--version", "completion bash",
                                   "params diff", "trace --wait 0", "serve --listen 127.0.0.1:0"])
def test_output_that_cannot_be_written_is_an_error(serve, words):
    """In one piece at the end, or in the middle of a long one."""
    served = serve()
    served.link("params", "set", "compensator.gain=0.3", "drive.residual_ms=40")
    words += f" {TRIANGLE}" if words == "params diff" else ""
    with open("/dev/full", "w", encoding="ascii") as full:
        done = subprocess.run([os.environ["TRIBO_LINK"], *words.split()], stdout=full, stderr=subprocess.PIPE, text=True,
                              timeout=600, check=False, env={**os.environ, "TRIBO_LINK_DEVICE": served.line.port})
    assert done.returncode == 2, done
    assert done.stderr.splitlines()[-1].startswith("tribo-link: standard output: cannot be written: No space left on device")
    assert done.stderr.count("cannot be written") == 1


def test_a_reader_that_has_gone_ends_a_watch_without_a_word(serve):
    served = serve()
    with subprocess.Popen([os.environ["TRIBO_LINK"], "-d", served.line.port, "watch", "--json", "--rate", "100"], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True) as run:
        assert run.stdout.readline().startswith("{")
        run.stdout.close()
        assert run.wait(timeout=300) == 0 and run.stderr.read() == ""


def open_files(pid):
    files = []
    for fd in pathlib.Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(FileNotFoundError):  # closed meanwhile
            files.append(os.readlink(fd))
    return files


def test_saved_params_outlast_the_program(serve):
    served = serve("store: params.bin\n")
    assert "params: store empty" in served.said()
    served.link("params", "set", "compensator.gain=0.3")
    served.link("params", "save")
    served = serve("store: params.bin\n")
    assert "params: store read, and they differ from the configuration's" in served.said()
    assert served.link("params", "get", "compensator.gain") == "compensator.gain: 0.300000012\n"
    served.link("params", "defaults")
    assert served.link("params", "get", "compensator.gain") == "compensator.gain: 0.850000024\n"
    served.link("params", "save")
    served = serve("store: params.bin\n")
    assert "differ" not in served.said()
    served.link("start")
    assert "refused: the drive is in run: tribo-link stop ends that" in served.link("params", "save", status=2)


def test_a_damaged_store_is_a_fault_until_a_set_is_applied(serve, drive):
    served = serve("store: params.bin\n")
    served.link("params", "save")
    served.end()
    content = bytearray((drive.folder / "params.bin").read_bytes())
    content[200] ^= 4
    (drive.folder / "params.bin").write_bytes(content)
    served = serve("store: params.bin\n")
    assert "params: store damaged" in served.said()
    assert "saved params damaged" in served.link("fault")
    assert "a set must be applied first" in served.link("fault", "--acknowledge", status=2)
    served.link("params", "defaults")
    served.link("fault", "--acknowledge")
    served.link("start")
    served.link("stop")
    served.link("params", "save")
    assert "params: store read" in serve("store: params.bin\n").said()


def test_without_a_store_nothing_is_saved(serve):
    served = serve()
    assert "params: the configuration's" in served.said()
    assert "saving the params: refused: the drive has no store: add store: FILE to its configuration" in served.link("params", "save", status=2)


def test_a_refused_command_says_the_state_and_the_way_out(serve):
    served = serve()

    def refused(*words):
        return served.link(*words, status=2).splitlines()[-1]

    assert refused("fault", "--acknowledge") == "tribo-link: acknowledgement: refused: the drive is in idle, not in fault: nothing is to be acknowledged"
    served.link("params", "set", "limits.u_max_N=0.1", "drive.command_limit_ms=20")
    served.link("start")
    assert refused("start") == "tribo-link: start: refused: the drive is in run already"
    assert refused("fault", "--acknowledge") == "tribo-link: acknowledgement: refused: the drive is in run, not in fault: nothing is to be acknowledged"
    for words, what in ((("forget",), "forget"), (("params", "save"), "saving the params"), (("tare",), "tare")):
        assert refused(*words) == f"tribo-link: {what}: refused: the drive is in run: tribo-link stop ends that, then try again"
    served.link("reference", 1.0)
    until(lambda: "command at its limit" in served.link("fault"), "no fault")
    for word in ("start", "tare"):
        assert refused(word) == f"tribo-link: {word}: refused: the drive is in fault (command at its limit): remove the cause, then tribo-link fault --acknowledge"
    served.link("fault", "--acknowledge")  # what it says leads on
    served.link("start")


@pytest.mark.parametrize("content, message", [(b"scenario: loop.yaml\n", "this is not a store of params"), (None, "Is a directory")])
def test_a_file_that_is_not_a_store_is_left_unchanged(drive, content, message):
    drive.write("rig.yaml", CLOCK_RIG + "store: other\n")
    if content is None:
        (drive.folder / "other").mkdir()
    else:
        (drive.folder / "other").write_bytes(content)
    run = drive.run("rig.yaml", "--duration", "0.01")
    assert run.returncode == 1 and f"store: other: {message}" in run.stderr
    assert content is None or (drive.folder / "other").read_bytes() == content


def test_a_store_is_one_drives(serve, drive):
    serve("store: params.bin\n")
    run = drive.run("rig.yaml", "--check")
    assert run.returncode == 1 and "store: params.bin: another drive has it" in run.stderr


def test_only_frames_with_the_right_crc_do_anything(serve):
    served = serve()
    bad, frames = served.value("bad_frames"), served.value("frames")
    line = os.open(served.line.port, os.O_RDWR | os.O_NOCTTY)
    os.write(line, bytes.fromhex("010601000001") + bytes.fromhex("4837"))  # start, with a wrong CRC
    until(lambda: served.value("bad_frames") == bad + 1, "the frame does not come")
    assert served.value("state") == 0
    os.close(line)
    assert served.value("frames") > frames
    # Half a frame, and then a whole one.
    line = os.open(served.line.port, os.O_RDWR | os.O_NOCTTY)
    os.write(line, bytes.fromhex("010601"))
    time.sleep(0.3)
    os.close(line)
    served.link("stop")


def test_a_reference_of_the_command_line(serve):
    served = serve(arguments=("--reference", "0.25"))
    served.link("start")
    message = served.link("reference", 0.5, status=2)  # not even for the tick that it might come into
    assert "reference: not taken; a drive that was started with --reference takes none from the bus" in message
    served.pass_ticks(100)
    assert served.value("r_N") == 0.25


def swapped(number):
    """A master that has the low word first."""
    high, low = struct.unpack(">HH", struct.pack(">f", number))
    return struct.unpack(">f", struct.pack(">HH", low, high))[0]


def test_an_implausible_reference_or_param_is_refused_with_the_cause(serve):
    served = serve()
    for value in (f"{swapped(0.3):.9g}", f"{swapped(0.5):.9g}", "9e-10", "1e-400"):
        assert f"reference {value}: too small to be meant: 0, or at least 1e-09 in size" in served.link("reference", "--", value, status=2)
    for value, why in (("nan", "is not a finite number"), ("-inf", "is not a finite number"), ("1e400", "is too large for a number"), ("0,3", "is not a number")):
        assert f"reference {value}: {why}" in served.link("reference", "--", value, status=2)
    assert "compensator.gain=1e-20: too small to be meant: 0, or at least 1e-15 in size" in served.link("params", "set", "compensator.gain=1e-20", status=2)
    assert "controller.sections[0].b2=2e-41: too small to be meant: 0, or at least 1e-20 in size" in \
        served.link("params", "set", "controller.sections[0].b2=2e-41", status=2)


def test_a_reference_that_is_not_renewed(serve):
    served = serve("drive: {period_us: 1000}\n")
    assert "drive.reference_ms: 250\n" in served.link("params", "get", "drive.reference_ms")  # its default
    served = serve("drive: {reference_ms: 3000}\n")  # time for a client on a loaded machine
    for beyond in ("reference_ms=0", "reference_ms=4000", "reference_ramp_n_per_s=0.001"):  # nor does a ramp that takes an hour
        assert "is refused, the drive goes on as it was" in served.link("params", "set", f"drive.{beyond}", status=2)
    served.link("start")
    served.pass_ticks(1000)
    assert served.value("state") == 1  # nobody has set one
    with served.host(0.4):
        served.pass_ticks(3000)
        assert served.value("state") == 1 and served.value("F_N") == pytest.approx(0.4, abs=0.02)
    until(lambda: "reference not renewed" in served.link("fault"), "no fault")


def test_without_its_host_a_drive_with_a_ramp_goes_to_its_safe_reference(serve):
    served = serve("drive: {reference_ms: 3000, reference_ramp_n_per_s: 0.5, safe_reference_n: 0.1}\n")
    served.link("start")
    with served.host(0.4):
        until(lambda: abs(served.value("r_N") - 0.4) < 1e-6, "no reference")
        assert served.value("limits") == 0
    until(lambda: served.value("r_N") == pytest.approx(0.1), "no ramp")
    assert served.value("state") == 1 and served.value("limits") == 4
    with served.host(0.3):
        until(lambda: abs(served.value("r_N") - 0.3) < 1e-6, "it does not come back")


def test_what_protects_changes_only_at_rest_and_is_said(serve):
    served = serve()
    protection = served.value("protection")
    served.link("start")
    message = served.link("params", "set", "drive.residual_ms=40", status=2)
    assert "drive.residual_ms = 40 is refused, the drive goes on as it was: it protects, and is 50; stop the drive first" in message
    assert "limits.u_max_N = 1.5 is refused" in served.link("params", "set", "limits.u_max_N=1.5", status=2)
    served.link("stop")
    done = subprocess.run([os.environ["TRIBO_LINK"], "-d", served.line.port, "params", "set", "drive.residual_ms=40", "limits.u_max_N=1.5"],
                          capture_output=True, text=True, check=True)
    assert done.stderr == "drive.residual_ms protects: from 50 to 40\nlimits.u_max_N protects: from 2 to 1.5\n"
    assert served.value("protection") != protection and served.value("protection_changes") == 2 and served.value("unlocked_ticks") == 0
    changes = served.link("changes").splitlines()
    assert [line.split(": ")[1] for line in changes] == ["drive.residual_ms from 50 to 40", "limits.u_max_N from 2 to 1.5"]
    served.wait_for("protection: limits.u_max_N from 2 to 1.5 at tick ")


def test_all_changes_of_a_set_are_reported(serve):
    """More than the registers keep."""
    served = serve("drive: {reference_ms: 0, stuck_ticks: 100}\n")
    fields = {"late_us": (50, 40), "budget_us": (250, 200), "residual_ms": (50, 40), "command_limit_ms": (500, 400), "tracking_ms": (1000, 900),
              "over_current_ms": (5, 4), "bus_voltage_ms": (10, 9), "temperature_ms": (1000, 900), "speed_ms": (20, 19),
              "stuck_ticks": (100, 90)}
    served.link("params", "set", *(f"drive.{name}={value}" for name, (_, value) in fields.items()))
    assert served.value("protection_changes") == len(fields)
    for name, (before, after) in fields.items():
        served.wait_for(f"protection: drive.{name} from {before} to {after} at tick ")


def test_no_client_exceeds_the_configuration(serve):
    served = serve("store: params.bin\n")
    assert "drive.residual_ms = 80 is refused, the drive goes on as it was: 1 to 50" in \
        served.link("params", "set", "drive.residual_ms=80", status=2)
    assert "limits.u_max_N = 2.5 is refused, the drive goes on as it was: 0 to 2" in \
        served.link("params", "set", "limits.u_max_N=2.5", status=2)
    for ticks, other, allowed in [("drive.period_us=500", [], "1000 to 1000"), ("sample_time_s=0.0005", [], "0.001 to 0.001"),
                                  ("drive.period_us=500", ["sample_time_s=0.0005"], "1000 to 1000")]:
        assert f"{ticks.replace('=', ' = ')} is refused, the drive goes on as it was: {allowed}; no set can change the ticks of a drive" in \
            served.link("params", "set", ticks, *other, status=2)
    assert "drive.command_limit_ms = 0 is refused, the drive goes on as it was: 1 to 500\n" in \
        served.link("params", "set", "drive.command_limit_ms=0", status=2)
    for beyond, allowed in [("command_n_per_unit=0.001", "1 to 3.4"), ("command_zero_units=0.5", "0 to 0"), ("sensor_n_per_unit=0.5", "1 to 3.4")]:
        message = served.link("params", "set", f"drive.{beyond}", status=2)
        assert f"{beyond.replace('=', ' = ')} is refused, the drive goes on as it was: {allowed}" in message
    for blinds, allowed in [("drive.sensor_pole_rad_per_s=0.001", "27.5 to 3.4"), ("drive.actuator_pole_rad_per_s=0.001", "100 to 3.4"),
                            ("compensator.arm.inertia_N_s2_per_deg=1", "0 to 0.00024"), ("compensator.arm.damping_N_s_per_deg=10", "0 to 0.0576"),
                            ("compensator.arm.stiffness_N_per_deg=0.1", "1.92 to 3.4"), ("compensator.friction.gravity_N=-0.5", "-0.055 to 0.055"),
                            ("drive.swing_ms=0", "1 to 1000"), ("drive.command_n_per_a=2", "1e-06 to 1")]:
        assert f"{blinds.replace('=', ' = ')} is refused, the drive goes on as it was: {allowed}" in served.link("params", "set", blinds, status=2)
    served.link("params", "save")
    served = serve("store: params.bin\ndrive: {residual_ms: 40}\n")  # narrower than what was saved
    assert "params: the store's drive.residual_ms = 50 is refused: 1 to 40\n" in served.said()
    assert "saved params damaged" in served.link("fault")


def test_a_line_that_goes_stops_nothing(serve):
    served = serve()
    served.link("start")
    served.line.cut()
    served.wait_for("bus.device: ")
    time.sleep(1.5)
    assert served.process.poll() is None
    assert served.end().count("bus.device: ") == 1


@pytest.mark.parametrize("bus, message", [
    ("device: /dev/nothing", "bus.device: /dev/nothing: No such file or directory"),
    ("listen: no.such.host.invalid", "bus.listen: no.such.host.invalid: "),
    ("device: /dev/ttyS0, listen: 127.0.0.1", "rig.yaml:4: bus: has a device and an address: give only one of them"),
    ("device: /dev/ttyS0, baud: 300", "rig.yaml:4: bus.baud: 300 is outside 1200 to 4e+06"),
    ("device: /dev/ptmx, rs485: yes", "bus.device: /dev/ptmx: "),  # a pty has no transceiver
    ("listen: 127.0.0.1, port: 0", "rig.yaml:4: bus.port: 0 is outside 1 to 65535"),
])
def test_a_wrong_bus_is_named_in_the_error(drive, bus, message):
    drive.write("rig.yaml", f"{CLOCK_RIG}bus: {{{bus}}}\n")
    run = drive.run("rig.yaml", "--check")
    assert run.returncode == 1 and message in run.stderr


GAIN, COMMAND, REFERENCE, ACTIVE = 0x1108, 0x100, 0x110, 0x1000


def test_unread_messages_delay_nothing(drive):
    """Nobody reads the messages, as on a terminal that Ctrl-S has stopped."""
    port = free_port()
    drive.write("rig.yaml", f"{CLOCK_RIG}bus: {{port: {port}}}\n")
    reading, writing = os.pipe()
    run = subprocess.Popen([drive.program, "rig.yaml"], cwd=drive.folder, stderr=writing)
    os.close(writing)
    said = b""
    while b"idle at" not in said:
        said += os.read(reading, 4096)
    fcntl.fcntl(reading, fcntl.F_SETPIPE_SZ, 4096)  # from here on: a pipe of one page takes one message, and what comes before was read
    with socket.create_connection(("127.0.0.1", port), timeout=100) as client:
        for k in range(100):  # starts and stops, a line each
            for command in (1, 2):
                client.sendall(bytes.fromhex(f"0008000000060106010000{command:02x}"))
                assert client.recv(64)[7] == 6, f"no answer to command {command} of round {k}"
                until(lambda due=command % 2: read_state(client)[-1] == due, "it does not change its state")
    run.terminate()
    assert run.wait(timeout=300) == 0
    said = b"".join(iter(lambda: os.read(reading, 4096), b""))
    os.close(reading)
    assert b"run at tick" in said


def test_a_reader_of_messages_that_leaves_ends_nothing(drive):
    drive.write("rig.yaml", CLOCK_RIG)
    reading, writing = os.pipe()
    run = subprocess.Popen([drive.program, "rig.yaml", "--duration", "0.5"], cwd=drive.folder, stderr=writing)
    os.close(writing)
    os.read(reading, 1)
    os.close(reading)
    assert run.wait(timeout=300) == 0


def read_state(client):
    client.sendall(bytes.fromhex("000800000006010300060002"))
    return client.recv(64)


STATE = bytes.fromhex("000800000007010304")


@pytest.fixture
def listen(drive):
    """A drive with a bus over TCP, what it said before it began, and its port."""
    runs = []

    def start(bus):
        port = free_port()
        drive.write("rig.yaml", f"{CLOCK_RIG}bus: {{{bus}port: {port}}}\n")
        run, messages = drive.begin("--duration", "2000")
        runs.append(run)
        return messages, port

    yield start
    for run in runs:
        run.terminate()
        run.wait(timeout=300)


@pytest.mark.parametrize("bus, where, who", [
    ("", "127.0.0.1", "only programs on this machine reach the drive"),
    ("listen: 127.0.0.1, ", "127.0.0.1", "only programs on this machine reach the drive"),
    ("listen: 0.0.0.0, ", "0.0.0.0", "anyone who reaches this address can move the drive, without a password"),
])
def test_the_start_says_who_reaches_it(listen, bus, where, who):
    messages, port = listen(bus)
    assert f"bus: Modbus TCP on {where} port {port}: {who}\n" in messages.read_text()
    with socket.create_connection(("127.0.0.1", port)) as client:
        assert read_state(client).startswith(STATE)


def test_a_second_client_is_refused_while_the_first_lives(listen):
    messages, port = listen("")
    busy = bytes.fromhex("0008000000030183" "06")
    with socket.create_connection(("127.0.0.1", port)) as first, socket.create_connection(("127.0.0.1", port)) as second:
        assert read_state(first).startswith(STATE)
        for trial in range(3):  # told once a second
            assert read_state(second) == busy
            here = second.getsockname()[1]
            said = f"127.0.0.1 port {here} is refused: 127.0.0.1 port {first.getsockname()[1]} has the drive (1 refused)"
            until(lambda what=said: trial > 0 or what in messages.read_text(), "it is not told")
            assert read_state(first).startswith(STATE)
        first.close()
        until(lambda: read_state(second).startswith(STATE), "its place is not free")


def test_a_client_that_disconnects_is_not_the_first_client(listen):
    """Its last request is answered, and the next client is not refused for it."""
    messages, port = listen("")
    for _ in range(20):
        client = socket.create_connection(("127.0.0.1", port))
        client.sendall(bytes.fromhex("000800000006010300060002"))
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
        client.close()  # a reset
    with socket.create_connection(("127.0.0.1", port)) as client:
        assert read_state(client).startswith(STATE)
    assert "is refused" not in messages.read_text()


def test_mbpoll_over_tcp(drive):
    """An outside client: reads, writes and all exceptions."""
    port = free_port()
    drive.write("rig.yaml", f"{CLOCK_RIG}bus: {{listen: 127.0.0.1, port: {port}}}\ndrive: {{reference_ms: 0}}\n")
    with drive.start("rig.yaml", "--duration", "2000") as run:
        while not run.stderr.readline().startswith("off:"):
            assert run.poll() is None

        def poll(*arguments, status=0):
            values = [*map(str, arguments)]
            split = values.index("--") if "--" in values else len(values)
            done = subprocess.run(["mbpoll", "-m", "tcp", "-p", str(port), "-0", "-1", "-q", "-o", "10", *values[:split], "127.0.0.1",
                                   *values[split + 1:]], capture_output=True, text=True, timeout=300, check=False)
            assert done.returncode == status, done.stdout + done.stderr
            return done.stdout + done.stderr

        def value(address):
            line = next(line for line in poll("-t", "4:float", "-B", "-r", address).splitlines() if line.startswith("["))
            return float(line.split()[-1])

        assert value(GAIN) == pytest.approx(0.85)
        poll("-t", "4:float", "-B", "-r", GAIN, "--", 0.5)
        assert value(GAIN) == value(GAIN + ACTIVE) == pytest.approx(0.85)  # what it had staged ended with its connection
        poll("-t", "4", "-r", COMMAND, "--", 1)
        poll("-t", "4:float", "-B", "-r", REFERENCE, "--", 0.3)
        until(lambda: value(0x82) == pytest.approx(0.3, abs=0.02), "F does not come to r")
        time.sleep(0.5)
        assert value(0x82) == pytest.approx(0.3, abs=0.02)  # F_N
        assert "Illegal data address" in poll("-t", "4", "-r", 0x0fff, "-c", 1, status=1)
        assert "Illegal function" in poll("-t", "3", "-r", 0, "-c", 1, status=1)
        assert "Illegal data value" in poll("-t", "4", "-r", COMMAND, "--", 99, status=1)
        assert "Illegal data address" in poll("-t", "4", "-r", GAIN, "--", 1, status=1)  # half a register
        assert "Slave device or server failure" in poll("-t", "4", "-r", COMMAND, "--", 3, status=1)  # nothing to acknowledge
        # Function 23: a stop is written, and the command reads as 0 in the same frame.
        with socket.create_connection(("127.0.0.1", port)) as client:
            client.sendall(bytes.fromhex("00070000000d01 17 01000001 01000001 02 0002".replace(" ", "")))
            assert client.recv(64) == bytes.fromhex("000700000005011702 0000".replace(" ", ""))

            def state():
                client.sendall(bytes.fromhex("00080000000601 03 0006 0002".replace(" ", "")))
                return client.recv(64)

            until(lambda: state() == bytes.fromhex("0008000000070103 04 00000000".replace(" ", "")), "it does not stop")
        run.terminate()
        assert run.wait(timeout=300) == 0
