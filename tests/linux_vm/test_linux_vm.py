"""tribo-drive against a real kernel: builds the test machine, boots it once in QEMU, and looks at each line that it printed.

Its time is counted in instructions of 4 ns each, so that neither the load nor the speed of this machine is in its figures: a
processor of 250 million instructions a second, idle time left out.
"""

import json
import os
import pathlib
import shutil
import subprocess

import pytest

HERE = pathlib.Path(__file__).parent
TICKS = 5000  # of the closed loop: 5 s, all of its scenario
DRIVES = os.environ["TRIBO_DRIVES"].split()
VERSIONS = [drive.split("=")[0] for drive in DRIVES]
KERNELS = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "tribo" / "linux"

CASES = """
check check_leaves_all_off busy_line consumer
unknown_line unknown_chip no_such_offset unknown_device unknown_channel unknown_pwm pwm_channel
runs_after_start probe_is_low_between_ticks code_through_scale code_through_offset active_low duty_is_the_command ends_with_its_ticks ends_off
emergency_stop_in_the_tick power_fault_in_the_tick pulse_between_ticks open_wire sensor_removed output_removed chip_removed chip_is_back
ready_in_time ready_lost ready_never ready_though_off heartbeat watchdog_opens no_watchdog
KILL STOP TERM INT BLOCKED_KILL BLOCKED_STOP BLOCKED_NONE killed_by_name supervisor_killed priorities
dac_is_the_command dac_ends_off triangle
""".split()


def why_not():
    if shutil.which("qemu-system-x86_64") is None:
        return "there is no qemu-system-x86_64"
    return "" if list(KERNELS.glob("*/vmlinuz")) else f"there is no kernel in {KERNELS}"


@pytest.fixture(scope="session")
def console():
    """All that the machine printed: {"v1.check": "ok", "v1.KILL.ms": 12.5, ...}."""
    if why_not():
        pytest.skip(f"the test machine is not installed: {why_not()}; tools/setup vm brings it")
    out = pathlib.Path(os.environ["TRIBO_TREE"])
    subprocess.run([HERE / "build.sh", out, str(TICKS), os.environ["TRIBO_PLANT"], os.environ["TRIBO_SIGNAL"], *DRIVES],
                   check=True, timeout=300)
    qemu = ["qemu-system-x86_64", "-M", "q35", "-accel", "tcg", "-icount", "shift=2,sleep=off", "-m", "512", "-nographic",
            "-no-reboot", "-device", "i6300esb", "-action", "watchdog=debug", "-kernel", out / "kernel", "-initrd", out / "initrd.gz", "-append", "console=ttyS0 quiet panic=-1"]
    run = subprocess.run(qemu, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=500, check=False)
    text = run.stdout.decode(errors="replace")
    (out / "console.txt").write_text(text)
    found = {}
    marked = "start"
    for line in text.splitlines():
        words = line.split()
        if words[:1] == ["ok"]:
            found[words[1]] = "ok"
        elif words[:2] == ["not", "ok"]:
            found[words[2].rstrip(":")] = line
        elif words[:1] == ["value"]:
            found[words[1]] = float(words[2])
        elif words[:1] == ["mark"]:
            marked = words[1]
        elif line == "watchdog: timer fired":
            found[f"{marked}.fired"] = found.get(f"{marked}.fired", 0.0) + 1
    assert "done" in text.splitlines(), text[-3000:]
    return found


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("version", VERSIONS)
def test_case(console, version, case):
    assert console.get(f"{version}.{case}", "was not run") == "ok"


def test_no_other_line(console):
    assert {name: what for name, what in console.items() if isinstance(what, str) and what != "ok"} == {}


@pytest.mark.parametrize("signal", ["KILL", "STOP", "TERM", "INT", "BLOCKED_KILL", "BLOCKED_STOP", "BLOCKED_NONE"])
@pytest.mark.parametrize("version", VERSIONS)
def test_enable_is_off_within_20_ms(console, version, signal):
    assert console[f"{version}.{signal}.ms"] <= 20.0


@pytest.mark.parametrize("version", VERSIONS)
def test_the_watchdog_fires_when_both_processes_are_killed(console, version):
    assert [name for name in console if name.endswith(".fired") and name.startswith(version)] == [f"{version}.watchdog_killed.fired"]


def simulated(scenario):
    """The RMS of r - F of the same scenario in tribo-sim, with the converter's steps."""
    command = [os.environ["TRIBO_SIM"], "run", HERE / scenario, "--json", "--set", "sensor.quantisation_N=6.103515625e-5"]
    run = subprocess.run(command, stdout=subprocess.PIPE, timeout=60, check=True)
    summary = json.loads(run.stdout)
    assert summary["ticks"] == TICKS
    return summary["rms_error_N"]


@pytest.mark.parametrize("version", VERSIONS)
def test_triangle_tracks_as_in_the_simulation(console, version):
    found = [console[f"{version}.triangle.{how}"] for how in ("with", "without")]
    wanted = [simulated("triangle.yaml"), simulated("off.yaml")]
    print(found, wanted)
    assert found == pytest.approx(wanted, rel=0.03)
    assert found[1] / found[0] == pytest.approx(wanted[1] / wanted[0], rel=0.03)
