"""The command line itself: exit status 2 and a hint at --help."""

import pytest

HINT = " (tribo-sim --help shows what there is)"

MISTAKES = {
    (): "a command is wanted: run, replay, params or list",
    ("fly",): "unknown command fly",
    ("run",): "run: one scenario is wanted, not 0",
    ("run", "a", "b"): "run: one scenario is wanted, not 2",
    ("run", "a", "--fast"): "run: unknown option --fast",
    ("run", "a", "--set"): "run: --set wants a value",
    ("run", "a", "--out"): "run: --out wants a value",
    ("run", "a", "--set", "compensator.gain"): "--set compensator.gain: key=value is wanted",
    ("run", "a", "--set", "=1"): "--set =1: key=value is wanted",
    ("replay",): "replay: one log is wanted, not 0",
    ("replay", "a", "b"): "replay: one log is wanted, not 2",
    ("replay", "a", "--fast"): "replay: unknown option --fast",
    ("replay", "a", "--params"): "replay: --params wants a value",
    ("replay", "a", "--force", "mine"): "--force mine: there are own, measured",
    ("params",): "params: one scenario is wanted, not 0",
    ("params", "a", "b"): "params: one scenario is wanted, not 2",
    ("params", "a", "--json"): "params: unknown option --json",
    ("params", "a", "--out"): "params: --out wants a value",
    ("params", "a", "--arith", "both"): "--arith both: there are f32, q31",
    ("params", "a", "--set", "compensator.gain"): "--set compensator.gain: key=value is wanted",
    ("list", "all"): "list: unknown argument all",
}


@pytest.mark.parametrize("arguments", MISTAKES)
def test_a_wrong_command_line(sim, arguments):
    result = sim.fails(MISTAKES[arguments] + HINT, *arguments, status=2)
    assert result.stdout == ""


@pytest.mark.parametrize("arguments", [("--help",), ("-h",), ("run", "--help"), ("replay", "x", "--help")])
def test_help_names_every_option_and_exit_status(sim, arguments):
    text = sim.ok(*arguments)
    for word in ("run", "replay", "params", "list", "--set", "--name", "--out", "--json", "--params", "--force", "--keys", "Exit status"):
        assert word in text


def test_a_full_standard_output_is_an_error(sim):
    for command in (("run", "step", "--set", "duration_s=3", "--json"), ("list",), ("list", "--keys")):
        with open("/dev/full", "w", encoding="ascii") as full:
            sim.fails("standard output: cannot be written: No space left on device", *command, stdout=full)
