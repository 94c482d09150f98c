"""examples/linuxcnc in halrun, in a thread of 1 kHz. The namespaces of its own are for loadrt, which takes modules from one folder
only, and so that neither another test nor a machine that runs here shares its memory."""

import pathlib
import shutil
import subprocess

import pytest

from conftest import EXAMPLES, RMS_MAX_UN, make, rms_of

MODULES = pathlib.Path("/usr/lib/linuxcnc/modules")
HAL = EXAMPLES / "linuxcnc" / "force.hal"


def made(folder, *names):
    """The components, and those of LinuxCNC that a HAL file needs."""
    make("linuxcnc", folder)
    for name in ("hal_lib", "threads", "siggen", "sampler", *names):
        shutil.copy(MODULES / f"{name}.so", folder)
    return folder


@pytest.fixture(scope="module", name="modules")
def _modules(tmp_path_factory):
    return made(tmp_path_factory.mktemp("modules"))


def halrun(modules, folder, commands):
    """What halrun prints that runs a file of `commands`."""
    (folder / "test.hal").write_text(commands)
    script = f"mount --bind {modules} {MODULES} && exec unshare --user --map-user=1000 halrun -f test.hal"
    result = subprocess.run(["unshare", "--map-root-user", "--mount", "--ipc", "sh", "-c", script], cwd=folder, text=True, timeout=600,
                            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
                            env={"PATH": "/usr/bin:/bin:/usr/sbin:/sbin", "HOME": str(folder)})
    assert result.returncode == 0, result.stdout
    return result.stdout


def after(*commands):
    """The example's HAL file and then these, which print a pin a line."""
    return HAL.read_text() + "\n".join(commands) + "\n"


def printed(out):
    return [line for line in out.splitlines() if line.replace(".", "").replace("-", "").isdigit() or line in ("TRUE", "FALSE")]


WAIT = "loadusr -w sleep 0.3"


def test_the_loop_follows_against_friction(modules, tmp_path):
    halrun(modules, tmp_path, after("loadusr -w halsampler -n 20000 log"))
    lines = (tmp_path / "log").read_text().splitlines()
    assert "overrun" not in lines
    references, forces, commands, faults = zip(*(map(float, line.split()) for line in lines))
    assert len(references) == 20000
    assert rms_of(references, forces) < RMS_MAX_UN
    assert max(commands) > 0.7
    assert not any(faults)


def test_the_command_goes_with_enable_and_with_the_sensor(modules, tmp_path):
    pins = ["getp tribo-force.0.command", "getp tribo-force.0.fault"]
    out = printed(halrun(modules, tmp_path, after(
        WAIT, *pins, "setp tribo-force.0.enable 0", WAIT, *pins, "setp tribo-force.0.enable 1", WAIT, *pins,
        "setp sim-arm.0.broken 1", WAIT, *pins, "setp sim-arm.0.broken 0", WAIT, *pins,
        "setp tribo-force.0.enable 0", WAIT, "setp tribo-force.0.enable 1", WAIT, *pins)))
    commands, faults = [float(value) for value in out[::2]], out[1::2]
    assert faults == ["FALSE", "FALSE", "FALSE", "TRUE", "TRUE", "FALSE"]
    assert [command != 0 for command in commands] == [True, False, True, False, False, True]


def test_another_period_is_a_fault(modules, tmp_path):
    commands = after(WAIT, "getp tribo-force.0.command", "getp tribo-force.0.fault").replace("period1=1000000", "period1=2000000")
    out = printed(halrun(modules, tmp_path, commands))
    assert (float(out[0]), out[1]) == (0.0, "TRUE")
