"""What fuzzing and users have found: each of these once hung, lied, or spoilt a terminal or a folder."""

import json
import os
import re
import resource
import shutil
import signal
import subprocess

import pytest

from conftest import ROOT, SHORT, read_csv
from test_command_line import HINT

GOOD_LOG = "t_s,u_N,F_N\n0,0.1,0\n0.001,0.2,0\n0.002,0.3,0\n"


def quickly(sim, message, *arguments):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    sim.fails(message, *arguments)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 10


# Sizes


def test_a_scenario_has_at_most_256_kb(sim):
    sim.write("x.yaml", SHORT + "#" * (256 * 1024 - len(SHORT)))
    sim.ok("run", "x.yaml")
    sim.write("x.yaml", SHORT + "#" * (256 * 1024 - len(SHORT) + 1))
    quickly(sim, "x.yaml: is larger than 256 KB, the limit for this file", "run", "x.yaml")
    quickly(sim, "/dev/zero:1: a zero byte: this is not a text file", "run", "/dev/zero")


def test_a_long_list_is_refused_at_once(sim):
    sim.write("x.yaml", SHORT + "controller: {kind: z, sections: [" + "0," * 120000 + "0]}\n")
    quickly(sim, "x.yaml:3: more than 1000 keys and values", "run", "x.yaml")
    quickly(sim, "--set controller.sections=[" + "0," * 390 + "0]: controller.sections: has 391 elements, 1 to 4 are expected",
            "run", "triangle", "--set", "controller.sections=[" + "0," * 390 + "0]")


DEEP = {"open": "[" * 250000, "closed": "[" * 120000 + "]" * 120000, "lines": "[\n" * 120000, "mappings": "{a: " * 60000}


@pytest.mark.parametrize("kind", DEEP)
def test_deep_nesting_is_refused_at_once(sim, kind):
    sim.write("x.yaml", SHORT + "x: " + DEEP[kind] + "\n")
    line = 18 if kind == "lines" else 3
    quickly(sim, f"x.yaml:{line}: nested too deeply", "run", "x.yaml")


def test_a_long_set_is_shown_by_its_start(sim):
    result = sim("run", "triangle", "--set", "compensator.gain=" + "x" * 100000)
    assert result.returncode == 1
    assert len(result.stderr) < 1200
    assert result.stderr.endswith("x...: compensator.gain: '" + "x" * 40 + "' is not a number\n")


# References without an end


@pytest.mark.parametrize("file", ["/dev/zero", "fifo", "/dev/stdin"])
def test_a_reference_that_is_not_a_file_is_refused(sim, file):
    os.mkfifo(sim.folder / "fifo")
    sim.write("x.yaml", f"duration_s: 0.01\nreference: {{kind: csv, file: {file}}}\n")
    quickly(sim, f"x.yaml:2: reference.file: {file}: cannot be opened: it is not a regular file", "run", "x.yaml")


# Nothing that is not finite comes out of a run that succeeds


@pytest.mark.parametrize("value", ["1e29", "-1000001"])
def test_a_reference_file_keeps_to_the_range_of_a_reference(sim, value):
    sim.write("r.csv", f"t_s,r_N\n0,0\n1,{value}\n")
    sim.write("x.yaml", "duration_s: 2\nreference: {kind: csv, file: r.csv}\n")
    sim.fails(f"r.csv:3:3: r_N: '{value}' is outside -1e+06 to 1e+06", "run", "x.yaml")


def test_a_reference_from_before_time_began_is_read(sim):
    sim.write("r.csv", "t_s,r_N\n-1e30,0\n1e-300,0.1\n1e30,0.2\n")
    sim.write("x.yaml", "duration_s: 0.1\nreference: {kind: csv, file: r.csv}\n")
    trace = sim.trace("x.yaml")
    assert all(0 <= r <= 0.2 for r in trace["r_N"])


def test_a_sensor_step_that_overflows_is_refused(sim):
    sim.write("x.yaml", SHORT)
    for value in ("1e-30", "9e-13"):
        sim.fails(f"--set sensor.quantisation_N={value}: sensor.quantisation_N: must be 0 or at least 1e-12", "run", "x.yaml",
                  "--set", f"sensor.quantisation_N={value}")
    sim.ok("run", "x.yaml", "--set", "sensor.quantisation_N=1e-12")


# With it the plant's matrices are no numbers.
NO_LDEXP = """
#include <math.h>
double ldexp(double x, int power)
{
    return x - x == power - power ? NAN : x;
}
"""


def preload(sim, source):
    """The environment in which this C goes before the program's libraries."""
    subprocess.run(["cc", "-shared", "-fPIC", "-fno-builtin", "-o", sim.folder / "before.so", sim.write("before.c", source), "-ldl"],
                   check=True)
    return {**os.environ, "LD_PRELOAD": str(sim.folder / "before.so"), "ASAN_OPTIONS": "verify_asan_link_order=0:detect_leaks=0"}


def test_a_plant_that_comes_to_no_number_is_an_error(sim):
    sim.write("x.yaml", "duration_s: 2\nreference: {kind: triangle, period_s: 1}\n")
    result = sim("run", "x.yaml", "--out", "d", env=preload(sim, NO_LDEXP))
    assert result.returncode == 1
    assert re.fullmatch(r"tribo-sim: the simulated plant diverges at t = \S+ s: plant.step_s is too long for its parameters\n",
                        result.stderr)
    assert not (sim.folder / "d").exists()


@pytest.mark.parametrize("column, force", [("u_N", "own"), ("F_N", "measured")])
def test_a_log_beyond_float_is_refused(sim, column, force):
    row, place = {"u_N": ("0.003,-1e39,0", 7), "F_N": ("0.003,0.1,-1e39", 11)}[column]
    sim.write("log.csv", GOOD_LOG + row + "\n")
    sim.fails(f"log.csv:5:{place}: {column}: '-1e39' is outside -1e+30 to 1e+30", "replay", "log.csv", "--force", force)


# Messages


def test_control_characters_are_shown_and_not_sent(sim):
    sim.write("x.yaml", SHORT + '"a\\e]0;b": 1\n')
    sim.fails(r"x.yaml:3: unknown key a\x1b]0;b", "run", "x.yaml")
    sim.write("x.yaml", SHORT + 'compensator: {gain: "\\e[31m\\x7f\\u009b5\\n"}\n')
    sim.fails(r"x.yaml:3: compensator.gain: '\x1b[31m\x7f\xc2\x9b5\n' is not a number", "run", "x.yaml")
    sim.fails(r"--set a\x1b=1: unknown key a\x1b", "run", "triangle", "--set", "a\x1b=1")
    sim.fails(r"unknown command \x1b[2J" + HINT, "\x1b[2J", status=2)
    sim.write("log.csv", "t_s,u_N\n0,\x1b[2J\n")
    sim.fails(r"log.csv:2:3: u_N: '\x1b[2J' is not a number", "replay", "log.csv")
    assert "größer" in sim("run", "triangle", "--set", "größer=1").stderr


def test_the_line_is_reported_however_long_the_path(sim):
    folder = sim.folder
    os.chdir(folder)
    while len(str(folder)) < 3500:
        folder = folder / ("long" * 50)
        folder.mkdir()
    path = folder / "x.yaml"
    path.write_text(SHORT + "compensator:\n  gain: 3\n", encoding="ascii")
    sim.fails(f"{path}:4: compensator.gain: 3 is outside 0 to 2", "run", path)
    path.write_text("duration_s: 1\nreference: {kind: csv, file: no.csv}\n", encoding="ascii")
    sim.fails(f"{path}:2: reference.file: {folder}/no.csv: cannot be opened: No such file or directory", "run", path)


def test_what_follows_a_zero_byte_is_not_ignored(sim):
    for text in ('compensator: {gain: "1\\0junk"}', 'description: "a\\0b"', 'plant: {model: "paper\\0r"}'):
        sim.write("x.yaml", SHORT + text + "\n")
        key = {"comp": "compensator.gain", "desc": "description", "plan": "plant.model"}[text[:4]]
        sim.fails(f"x.yaml:3: {key}: holds a zero byte", "run", "x.yaml")
    sim.write("x.yaml", SHORT + '"compensator\\0x": {gain: 1}\n')
    sim.fails("x.yaml:3: unknown key compensator", "run", "x.yaml")


def test_a_long_description_is_blamed_itself(sim):
    sim.write("x.yaml", "duration_s: 0.01\nreference: {kind: step}\ndescription: " + "x" * 201 + "\n")
    sim.fails("x.yaml:3: description: is longer than 200 bytes", "run", "x.yaml")
    sim.write("x.yaml", "duration_s: 0.01\nreference: {kind: step}\ndescription: " + "x" * 200 + "\n")
    sim.ok("run", "x.yaml")


def test_an_alias_is_refused_wherever_it_leads(sim):
    for text in ("compensator: {gain: &g 1}\nplant: {step_s: *g}", "compensator: &c {gain: 1, arm: *c}"):
        sim.write("x.yaml", SHORT + text + "\n")
        assert sim("run", "x.yaml").stderr.endswith(": aliases are not supported\n")


def test_bytes_that_are_not_text_are_reported_with_their_line(sim):
    sim.write("x.yaml", SHORT.encode() + b"# \xff\n")
    sim.fails("x.yaml:3: not valid YAML: invalid leading UTF-8 octet", "run", "x.yaml")


# Results


@pytest.mark.parametrize("length", [248, 249, 251, 255])
def test_a_long_name_is_a_name(sim, length):
    sim.write("log.csv", GOOD_LOG)
    name = "x" * (length - 4) + ".csv"
    sim.ok("replay", "log.csv", "--out", name)
    assert sorted(os.listdir(sim.folder)) == sorted(["log.csv", name])


# A rename that ends the program once it is done.
RENAMER = """
#define _GNU_SOURCE
#include <dlfcn.h>
#include <signal.h>
#include <stdlib.h>
int rename(const char *from, const char *to)
{
    static int calls;
    int (*original)(const char *, const char *);
    *(void **)&original = dlsym(RTLD_NEXT, "rename");
    const int result = original(from, to);
    if (++calls == atoi(getenv("RENAMES")))
    {
        raise(atoi(getenv("NUMBER")));
    }
    return result;
}
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
@pytest.mark.parametrize("renames", [1, 2, 3])
def test_a_summary_is_never_beside_the_traces_of_another_run(sim, renames, number):
    sim.write("x.yaml", SHORT + "compensator: {method: paper}\n")
    sim.ok("run", "x.yaml", "--arith", "both", "--out", "d")
    environment = preload(sim, RENAMER) | {"RENAMES": str(renames), "NUMBER": str(int(number))}
    result = sim("run", "x.yaml", "--arith", "both", "--out", "d", "--set", "duration_s=0.02", env=environment)
    assert result.returncode == -number
    left = sorted(path.name for path in (sim.folder / "d").iterdir())
    if number == signal.SIGTERM:  # waits until all are in their places
        assert left == ["scenario.yaml", "summary.json", "trace.csv", "trace_q31.csv"]
    if "summary.json" in left:
        ticks = json.loads((sim.folder / "d/summary.json").read_text(encoding="ascii"))["ticks"]
        for name in ("trace.csv", "trace_q31.csv"):
            assert len(read_csv(sim.folder / "d" / name)["t_s"]) == ticks == 20


# The program and its tools


@pytest.mark.skipif("TRIBO_SIM_SPEED" not in os.environ, reason="flags of an optimised build")
def test_the_program_is_hardened(sim):
    if shutil.which("readelf") is None:
        pytest.skip("no readelf")
    text = subprocess.run(["readelf", "-W", "-h", "-d", "-l", "-s", sim.program], capture_output=True, text=True, check=True).stdout
    assert re.search(r"Type:\s+DYN", text)
    assert "GNU_RELRO" in text and re.search(r"FLAGS.*(BIND_)?NOW", text)
    assert "__stack_chk_fail" in text
    assert re.search(r"__\w+_chk\b(?<!__stack_chk_fail)", text)
    assert re.search(r"GNU_STACK\s+\S+\s+\S+\s+\S+\s+\S+\s+\S+\s+RW\s", text)


def test_every_target_that_the_help_names_is_one(sim):
    names = re.search(r"Targets: (.*)\.", sim.ok("--help"))[1].split(", ")
    assert len(names) == 9 and names[-1] == "serial:DEVICE"
    for name in names[:-1]:
        result = sim("run", "step", "--target", name, env={**os.environ, "TRIBO_FIRMWARE": str(sim.folder)})
        assert result.stderr.startswith(f"tribo-sim: {name}: no image {sim.folder}/")


def test_setup_does_not_write_through_a_link_that_waits_for_it(sim):
    """Its log is in a folder where others may put a link with the name they expect."""
    (sim.folder / "bin").mkdir()
    (sim.folder / "tmp").mkdir()
    for name, status in (("dpkg-query", 1), ("apt-get", 1), ("sudo", 0)):
        sim.write(f"bin/{name}", f"#!/bin/sh\necho overwritten\nexit {status}\n").chmod(0o755)
    victim = sim.write("victim", "mine")
    script = f'ln -s {victim} "$TMPDIR/tribo-setup.$$.log"; exec {ROOT}/tools/setup demo'
    subprocess.run(["bash", "-c", script], env={**os.environ, "PATH": f"{sim.folder}/bin:{os.environ['PATH']}",
                                                "TMPDIR": str(sim.folder / "tmp")}, capture_output=True, check=False)
    assert victim.read_text(encoding="ascii") == "mine"
