"""The command line itself: exit status 2 and a hint at --help."""

import sys

import pytest

from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests" / "support"))
from version import VERSION  # noqa: E402

HINT = " (tribo-sim --help lists the commands)"

MISTAKES = {
    (): "a command is expected: run, replay, log, plot, params, fmu or list",
    ("fly",): "unknown command fly",
    ("run",): "run: one scenario is expected, not 0",
    ("run", "a", "b"): "run: one scenario is expected, not 2",
    ("run", "a", "--fast"): "run: unknown option --fast",
    ("run", "a", "--set"): "run: --set needs a value",
    ("run", "a", "--out"): "run: --out needs a value",
    ("run", "a", "--set", "compensator.gain"): "--set compensator.gain: key=value is expected",
    ("run", "a", "--set", "=1"): "--set =1: key=value is expected",
    ("replay",): "replay: at least one log is expected",
    ("log",): "log: at least one log is expected",
    ("log", "a", "--column", "z=1"): "--column z=1: t, u, F, x, v or r, then = and a value are expected",
    ("log", "a", "--column", "u="): "--column u=: t, u, F, x, v or r, then = and a value are expected",
    ("log", "a", "--column", "u=#x"): "--column u=#x: a number of 1 or more is expected after #",
    ("log", "a", "--scale", "u=0"): "--scale u=0: 0 is outside its range",
    ("log", "a", "--scale", "u=x"): "--scale u=x: 'x' is not a number",
    ("log", "a", "--bias", "u=1e10"): "--bias u=1e10: '1e10' is outside -1e9 to 1e9",
    ("log", "a", "--resample=0"): "--resample 0: a number over 0 to 86400 s is expected",
    ("log", "a", "--gap", "nan"): "--gap nan: a number over 0 to 86400 s is expected",
    ("replay", "a", "--out", "x.svg", "--plot", "x.svg"): "replay: --out and --plot are the same file x.svg",
    ("replay", "a", "--plot", "x"): "--plot x: a name that ends in .png, .svg or .html is expected",
    ("replay", "a", "--fast"): "replay: unknown option --fast",
    ("replay", "a", "--params"): "replay: --params needs a value",
    ("replay", "a", "--force", "mine"): "--force mine: must be one of own, measured",
    ("params",): "params: one scenario is expected, not 0",
    ("params", "a", "b"): "params: one scenario is expected, not 2",
    ("run", "a", "--decimate", "0"): "--decimate 0: a whole number of 1 or more is expected",
    ("run", "a", "--columns", "r_N,x_N"): "--columns: a trace has no column 'x_N'",
    ("run", "a", "--columns", "t_"): "--columns: a trace has no column 't_'",
    ("fmu",): "fmu: one scenario is expected, not 0",
    ("fmu", "a", "--out", "a.fmu"): "fmu: --part loop and --out FILE.fmu are expected",
    ("fmu", "a", "--part", "plant"): "fmu: --part plant and --out FILE.fmu are expected",
    ("fmu", "a", "--part", "wheel"): "--part wheel: must be one of loop, compensator, plant",
    ("fmu", "a", "--fmi", "1"): "--fmi 1: must be one of 2, 3",
    ("plot", "a"): "plot: --out FILE is expected",
    ("plot", "--out", "a.png"): "plot: at least one folder or file is expected",
    ("run", "a", "--plot", "b.jpg"): "--plot b.jpg: a name that ends in .png, .svg or .html is expected",
    ("params", "a", "--json"): "params: unknown option --json",
    ("params", "a", "--out"): "params: --out needs a value",
    ("params", "a", "--arith", "both"): "--arith both: must be one of f32, q31",
    ("params", "a", "--set", "compensator.gain"): "--set compensator.gain: key=value is expected",
    ("list", "all"): "list: unknown argument all",
    # An option is given once, one of NAME=VALUE once for each NAME.
    ("run", "a", "--out", "b", "--out", "c"): "run: --out b and --out c: only one is expected",
    ("run", "a", "--out", "b", "--ou=b"): "run: --out b and --out b: only one is expected",
    ("run", "a", "--json", "--json"): "run: --json is given twice",
    ("run", "a", "--set", "duration_s=1", "--set", "duration_s=2"): "run: --set duration_s=1 and --set duration_s=2: only one is expected",
    ("run", "a", "--set", "description=a", "--set", "description=b={c"): "run: --set description=a and --set description=b={c: only one is expected",
    ("run", "a", "--set", "arithmetic=f32", "--arith", "q31"): "--arith and --set arithmetic: only one is expected",
    ("params", "a", "--arith", "q31", "--set", "arithmetic=f32"): "--arith and --set arithmetic: only one is expected",
    ("params", "a", "--name", "b", "--name", "c"): "params: --name b and --name c: only one is expected",
    ("replay", "a", "--force", "own", "--force", "measured"): "replay: --force own and --force measured: only one is expected",
    ("log", "a", "--column", "u=b", "--column", "u=c"): "log: --column u=b and --column u=c: only one is expected",
    ("log", "a", "--scale", "u=-", "--scale", "u=2"): "log: --scale u=- and --scale u=2: only one is expected",
    ("log", "a", "--resample", "--resample=0.1"): "log: --resample is given twice",
    ("fmu", "a", "--part", "loop", "--part", "plant"): "fmu: --part loop and --part plant: only one is expected",
    ("plot", "a", "--from", "1", "--from", "2"): "plot: --from 1 and --from 2: only one is expected",
    ("list", "--keys", "--keys"): "list: --keys is given twice",
}


@pytest.mark.parametrize("arguments", MISTAKES)
def test_a_wrong_command_line(sim, arguments):
    result = sim.fails(MISTAKES[arguments] + HINT, *arguments, status=2)
    assert result.stdout == ""


def test_options_for_different_names_are_all_taken(sim):
    """Also where one name begins with the other."""
    sim.write("a.csv", "time,cmd,torque\n0,1,2\n0.001,1,2\n0.002,1,2\n")
    text = sim.ok("log", "a.csv", "--column", "t=time", "--column", "u=cmd", "--column", "F=torque", "--unit", "u=mN", "--unit", "F=mN")
    assert text.startswith("t_s,u_N,F_N,segment\n0,0.001,0.002,0\n")
    sim.ok("run", "step", "--set", "duration_s=3", "--set", "compensator.friction.k_max=21", "--set", "compensator.friction.k_min=7")
    for blanks in ("", " ", " \t "):
        sim.ok("run", "step", "--set", "duration_s=3", "--set", f"plant.friction={blanks}{{k_min: 5}}", "--set", f"plant.friction={blanks}{{k_max: 20}}")


@pytest.mark.parametrize("arguments", [("--help",), ("-h",), ("fly", "--help")])
def test_help_names_every_command_and_exit_status(sim, arguments):
    text = sim.ok(*arguments)
    for word in ("run", "replay", "log", "plot", "params", "list", "COMMAND --help", "--version", "Exit status"):
        assert word in text
    assert "--set" not in text


HELP = {
    "run": ("--set", "--learned", "--out", "--json", "--arith", "--target", "Targets: m0"),
    "replay": ("--params", "--force", "--plot", "--scale"),
    "log": ("--column", "--unit", "--gap"),
    "plot": ("--out", "--from", "--to", "--name"),
    "params": ("--name", "--arith", "--learned"),
    "list": ("--keys", "--markdown", "--parameters"),
}


@pytest.mark.parametrize("command", HELP)
def test_help_of_a_command_shows_its_options_alone(sim, command):
    for arguments in ((command, "--help"), (command, "x", "-h")):
        text = sim.ok(*arguments)
        assert all(option in text for option in HELP[command])
        assert text.count("Usage: ") == 1 and f"tribo-sim {command} " in text
        assert ("Targets" in text) == (command == "run")


def test_version(sim):
    assert sim.ok("--version") == f"tribo-sim {VERSION}\n"


def test_a_full_standard_output_is_an_error(sim):
    for command in (("run", "step", "--set", "duration_s=3", "--json"), ("list",), ("list", "--keys")):
        with open("/dev/full", "w", encoding="ascii") as full:
            sim.fails("standard output: cannot be written: No space left on device", *command, stdout=full)
