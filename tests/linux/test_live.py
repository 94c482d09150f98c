"""tools/link/demo-drive, and what tribo-link shows of a drive while it runs: short, as JSON, live, to PlotJuggler and Teleplot."""

import json
import os
import pathlib
import pty
import re
import signal
import socket
import subprocess
import sys
import time
import xml.etree.ElementTree

import pytest

from conftest import LINK, ROOT, Demo, free_port, until

sys.path.insert(0, str(ROOT / "tools"))


def processes_in(folder):
    """Returns the processes whose working directory is in the folder."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            found += [process.name] if str(folder) in os.readlink(process / "cwd") else []
        except OSError:
            continue
    return found


def test_the_page_of_the_firmware_sets_a_param_that_the_demo_takes(demo):
    page = (ROOT / "firmware/README.md").read_text(encoding="utf-8")
    words = re.findall(r"`tribo-link (params set [^`\s]+=[^`\s]+)`", page)
    assert words
    for word in words:
        demo.link(*word.split())


def test_mbpoll_does_on_the_demo_what_the_page_says(demo):
    page = (ROOT / "docs/linux.md").read_text(encoding="utf-8").split("## What turns it off")[0]
    lines = [line.split("#") for line in page.splitlines() if line.startswith("    mbpoll ")]
    assert [comment.strip() for _, comment in lines] == ["start", "F in N", "stop", "r in N"]
    try:
        for line, comment in lines:
            done = subprocess.run(line.replace("1502", demo.tcp.split(":")[-1]).split(), capture_output=True, text=True, timeout=300, check=False)
            # The demo has a reference of its own; test_bus.py gives a drive one of the bus.
            assert (done.returncode == 0) == (comment.strip() != "r in N"), done.stdout + done.stderr
            if comment.strip() == "start":
                until(lambda: "state    run" in demo.link(), "it does not start")
            assert comment.strip() != "F in N" or re.search(r"^\[130\]: \t-?\d", done.stdout, re.M), done.stdout
        assert "state    idle" in demo.link()
    finally:
        demo.link("stop")


def test_an_assistant_can_do_on_the_demo_what_its_page_says(demo):
    page = (ROOT / "AGENTS.md").read_text(encoding="utf-8")
    lines = [line.split("#")[0].split()[1:] for line in page.splitlines() if line.startswith("    tribo-link ")]
    assert ["stop"] in lines and ["status", "--json"] in lines and len(lines) > 5
    said = {" ".join(line): demo.link(*line) for line in lines}
    named = re.findall(r"`(\w+)`", page.split("| in `status --json` |")[1].split("## What not to do")[0])
    assert {"state_text", "fault_text", "warnings", "refused_register"} <= set(json.loads(said["status --json"])) & set(named)


def test_the_demo_can_be_typed_along_and_leaves_nothing(tmp_path):
    demo = Demo(tmp_path)
    commands = [line.strip().split("#")[0].split() for line in demo.text().splitlines() if line.startswith("    ")]
    assert [command[-1] for command in commands] == ["start", "watch", "compensator.method=off"]
    for command in (commands[0], commands[2]):
        assert subprocess.run(command, capture_output=True, text=True, timeout=300, check=False).returncode == 0
    assert "state    run" in demo.link()
    assert len(demo.folders()) == 1 and len(processes_in(demo.folders()[0])) >= 2
    folder = demo.folders()[0]
    demo.process.send_signal(signal.SIGINT)
    assert demo.process.wait(timeout=300) == 0
    assert demo.text().endswith("The drive has ended.\n")
    assert not demo.folders() and not processes_in(folder)


def test_the_drive_ends_with_a_demo_that_is_killed(tmp_path):
    demo = Demo(tmp_path)
    demo.process.kill()
    demo.process.wait(timeout=300)
    until(lambda: not processes_in(demo.folders()[0]), "the drive goes on")


def test_status_is_short_whole_or_json_on_either_line(demo):
    demo.link("start")
    short = demo.link()
    assert len(short.splitlines()) < 9 and "state    run" in short and re.search(r"learned +L +0\.\d+ N up", short)
    assert len(demo.link("status").splitlines()) > 40
    found = json.loads(demo.link("status", "--json", device=demo.line))
    assert found["state_text"] == "run" and found["version"] == 10 and 0.39 < found["r_N"] < 0.61
    assert {line.split(":")[0] for line in demo.link("status").splitlines()} == {name for name in found if not name.endswith("_text")}


def test_status_says_what_the_method_that_runs_does(demo):
    try:
        assert "compensation is in by 100 %" in demo.link()
        for method in ("off", "paper"):
            demo.link("params", "set", f"compensator.method={method}")
            short = demo.link()
            assert "learned" not in short
            assert ("friction is not compensated" in short) == (method == "off") != ("compensation is in by 100 %" in short)
    finally:
        demo.link("params", "set", "compensator.method=feedforward")
    assert "learned" in demo.link()


def test_watch_is_a_line_a_sample(demo):
    rows = [json.loads(line) for line in demo.link("watch", "--json", "--rate", "50", "--hold", "2").splitlines()]
    assert 2 < len(rows) <= 101
    assert all(later["tick"] > row["tick"] and later["timestamp"] > row["timestamp"] for row, later in zip(rows, rows[1:]))
    assert all(len(json.dumps(row)) < 2000 for row in rows)


def test_others_have_their_turn_while_it_is_watched(demo):
    with subprocess.Popen([LINK, "-d", demo.tcp, "watch", "--json"], stdout=subprocess.PIPE, text=True) as watch:
        watch.stdout.readline()
        demo.link("params", "set", "compensator.gain=0.8")
        assert "0.8" in demo.link("params", "get", "compensator.gain", device=demo.line)
        watch.stdout.readline()
        watch.send_signal(signal.SIGINT)
        watch.stdout.read()
    assert watch.returncode == 0


@pytest.mark.parametrize("option", ["--udp", "--teleplot"])
def test_watch_sends_what_plotters_read(demo, option):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(60)
        watch = subprocess.Popen([LINK, "-d", demo.tcp, "watch", option, f"127.0.0.1:{receiver.getsockname()[1]}"], stdout=subprocess.DEVNULL)
        got = [receiver.recv(65536) for _ in range(3)][-1].decode()
        watch.terminate()
        assert watch.wait(timeout=60) == 0
    assert len(got) < 2048
    if option == "--udp":
        assert json.loads(got)["r_N"] == pytest.approx(0.5, abs=0.11)
    else:
        rows = dict(re.fullmatch(r"(\w+):\d{13}\.\d{3}:(\S+)", line).groups() for line in got.splitlines())
        assert float(rows["r_N"]) == pytest.approx(0.5, abs=0.11) and "F_N" in rows


def test_the_view_leaves_the_terminal_as_it_was(demo):
    process, terminal = pty.fork()
    if process == 0:
        os.execv(LINK, [LINK, "-d", demo.tcp, "watch"])
    seen = b""
    while seen.count("▁".encode()) < 5:
        seen += os.read(terminal, 4096)
    os.kill(process, signal.SIGINT)
    try:
        while part := os.read(terminal, 4096):
            seen += part
    except OSError:
        pass  # the end of a pty
    assert os.waitstatus_to_exitcode(os.waitpid(process, 0)[1]) == 0
    assert seen.startswith(b"\033[?1049h\033[?25l") and seen.endswith(b"\033[?25h\033[?1049l")
    assert b"state    " in seen


def test_a_signal_that_cannot_be_watched_is_reported(demo):
    assert "standard output is no terminal" in demo.link("watch", status=2)
    assert "HOST:PORT is expected" in demo.link("watch", "--udp", "nowhere", status=2)
    assert "no such address" in demo.link("watch", "--udp", "no.such.host.invalid:1", status=2)
    port = free_port()
    assert f"tcp:127.0.0.1:{port}: Connection refused" in demo.link("status", device=f"tcp:127.0.0.1:{port}", status=2)


def test_a_drive_that_serves_another_is_waited_for(demo):
    host, port = demo.tcp.removeprefix("tcp:").split(":")
    with socket.create_connection((host, int(port))) as other:
        other.sendall(bytes.fromhex("000100000006010300000002"))
        assert other.recv(100)
        begin = time.monotonic()
        assert "serves another program" in demo.link("status", status=2)
        assert time.monotonic() - begin > 2
    demo.link("status")


def test_the_layout_of_plotjuggler_has_names_and_colours_of_ours(demo):
    from tribo_plot.look import SIGNALS

    sent = json.loads(demo.link("watch", "--json", "--hold", "0.01").splitlines()[0])
    colours = {"e_N": SIGNALS["error"][1], "learned_positive_N": SIGNALS["breakaway_positive_N"][1],
               "learned_negative_N": SIGNALS["breakaway_negative_N"][1]}
    curves = list(xml.etree.ElementTree.parse(ROOT / "tools/link/plotjuggler.xml").iter("curve"))
    assert len(curves) == 8
    for curve in curves:
        name = curve.get("name").removeprefix("/")
        assert name in sent
        assert curve.get("color") == (colours.get(name) or SIGNALS[name][1]).lower()


def test_bash_completes_every_command_and_option():
    script = subprocess.run([LINK, "completion", "bash"], capture_output=True, text=True, check=True).stdout
    words = subprocess.run(["bash", "-c", f"{script}\ncomplete -p tribo-link"], capture_output=True, text=True, check=True).stdout.split("'")[1].split()
    shown = subprocess.run([LINK, "--help"], capture_output=True, text=True, check=True).stdout
    assert set(re.findall(r"--[a-z]+", shown)) <= set(words)
    commands = set(re.findall(r"^  ([a-z]+)", shown, re.M))
    assert len(commands) > 10 and commands <= set(words)


def options_of(*command):
    shown = subprocess.run([LINK, *command, "--help"], capture_output=True, text=True, check=True).stdout
    return set(re.findall(r"--([a-z]+)", shown.split("\n\n", 1)[1]))


def test_help_of_a_command_shows_its_own_and_no_other_is_taken():
    trace = {"after", "decimation", "level", "out", "signals", "trigger", "wait", "watch"}
    common = {"baud", "device", "help", "unit", "usage", "version"}
    assert options_of("trace") == trace | common and options_of("--help", "start") == common
    assert options_of("serve") == {"allow", "listen", "rate"} | common
    commands = re.findall(r"^  ([a-z]+)", subprocess.run([LINK, "--help"], capture_output=True, text=True, check=True).stdout, re.M)
    assert set().union(*(options_of(command) for command in commands)) == options_of()
    for words, text in ((("start", "--level", "3"), "start has no option --level"), (("--listen", "x:1", "status"), "status has no option --listen"),
                        (("fly", "--help"), "there is no command fly"), (("a(", "--help"), "there is no command a("), (("fly",), "there is no command fly")):
        done = subprocess.run([LINK, *words], capture_output=True, text=True, check=False)
        assert done.returncode == 2 and text in done.stderr and done.stdout == ""
