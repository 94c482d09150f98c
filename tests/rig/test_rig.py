"""tribo-rig: the page, line by line; foreign rigs through the whole way; and what it refuses. The long version is study.py."""

import gzip
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import bench
import foreign
import numpy as np
import page
import pytest
import ruamel.yaml as yaml
import way

from tribo_identify import accept, bins
from tribo_identify.plan import POLE, Plan
from tribo_rig import cli, experiments, loop
from tribo_rig import rig as rigs

ROOT = foreign.ROOT
DATA = Path(__file__).parent / "data"


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """A folder in which the page's commands were run, and what each of its blocks said."""
    root = tmp_path_factory.mktemp("page")
    return root, page.play(root)


def test_the_page_says_what_its_commands_say(played):
    shown = page.blocks("")
    assert len(shown) == 3
    assert [line for one, said in zip(shown, played[1]) for line in page.differs(one, said)] == []


@pytest.mark.parametrize("old, new", [("by 9.58", "by 10.4"), ("0.0079 N", "0.00731 N"), ("VERDICT: tuned", "VERDICT: turned"), ("3.15e-05", "3.15e-03"), ("\nnext", "\nmore\nnext"), ("\nnext", "")])
def test_a_page_that_is_of_another_tree_differs(old, new):
    said = "VERDICT: tuned: by 9.58, from 0.0757 to 0.0079 N rms\nbias 3.15e-05 N\nnext: params\n"
    assert page.differs(said, said) == [] and page.differs(said.replace("9.58", "9.6").replace("3.15e-05", "-2e-04"), said) == []
    assert page.differs(said.replace(old, new, 1), said)


def test_what_leads_nowhere_or_cannot_be_looked_at_is_not_absent(tmp_path):
    """A folder on a drive that is not mounted, or a log that is a link to it: no rig.yaml is written over it, and no experiment is asked for again."""
    (tmp_path / "rig.yaml").symlink_to("rig.yaml")
    said = subprocess.run([sys.executable, "-m", "tribo_rig", tmp_path], capture_output=True, text=True, check=False)
    assert said.returncode == 2 and "rig.yaml: cannot be read: Too many levels of symbolic links" in said.stderr and said.stdout == ""
    assert [path.name for path in tmp_path.iterdir()] == ["rig.yaml"]


def test_a_place_that_takes_no_file_is_found_before_the_work(tmp_path):
    """A folder of somebody else where the result goes, and a file to play that is read-only."""
    def refused():
        before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
        said = subprocess.run([sys.executable, "-m", "tribo_rig", tmp_path], capture_output=True, text=True, check=False)
        assert said.returncode == 2 and said.stdout == "" and {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
        return said.stderr

    (tmp_path / "rig.yaml").write_text("sample_time_s: 1e-3\nforce: {low_N: 0, high_N: 10}\n")
    (tmp_path / "1-ramp.csv").write_text("mine")
    (tmp_path / "1-ramp.csv").chmod(0o444)
    assert refused().splitlines()[-1] == f"tribo-rig: {tmp_path / '1-ramp.csv'}: cannot be written: it is read-only"
    (tmp_path / "result").mkdir()
    (tmp_path / "result/notes.txt").write_text("mine")
    (tmp_path / "1-ramp-log.csv").write_text("not even read\n")
    assert refused().splitlines()[-1] == f"tribo-rig: {tmp_path / 'result'}: has other files in it (notes.txt); move them elsewhere"
    (tmp_path / "rig.yaml").unlink()
    (tmp_path / "joint.yaml").write_text("sample_time_s: 1e-3\neffort_max: 3\n")
    (tmp_path / "sine-log.csv").write_text("not even read\n")
    assert refused().splitlines()[-1] == f"tribo-rig: {tmp_path / 'result'}: has other files in it (notes.txt); move them elsewhere"


def test_the_pages_rig_is_found(played):
    """Friction, scale and whole lag of tests/rig/bench.py."""
    found = json.loads((played[0] / "build/bench/result/verdict.json").read_text())
    assert found["friction"]["offset"] == pytest.approx(0.4, rel=0.02) and found["friction"]["slope"] == pytest.approx(0.12, rel=0.01)
    assert found["command_per_N"] == pytest.approx(1 / 1.06, rel=0.002)
    lags = {"actuator": 1 / bench.CURRENT, "arm": bench.DAMPING / bench.STIFFNESS, "sensor": 1 / bench.FILTER, "delay": bench.LATE * bench.TICK_S}
    assert found["lags_s"] == pytest.approx(lags, rel=0.01, abs=1e-4)


def test_the_pages_loop_does_what_it_says_on_its_rig(played):
    """The generated header, compiled with the library, drives the simulation; predicted against played error."""
    result = played[0] / "build/bench/result"
    rms = way.played(bench.Bench, bench.TICK_S, result)
    predicted = json.loads((result / "verdict.json").read_text())["predicted_rms_N"]
    assert rms["off"] > 5 * rms["on"]
    assert predicted["off"][1] == pytest.approx(rms["off"], rel=0.05)
    assert predicted["on"][1] == pytest.approx(rms["on"], rel=0.05)


def test_the_logs_of_the_page_are_of_its_rig(played):
    """The simulation plays the experiments again. It is deterministic but for the last digit."""
    for name in ("1-ramp", "2-slides"):
        made = played[0] / f"{name}.csv"
        subprocess.run([sys.executable, ROOT / "tests/rig/bench.py", played[0] / f"build/bench/{name}.csv", made], check=True)
        log = np.loadtxt(gzip.open(DATA / f"{name}-log.csv.gz", "rt"), delimiter=",", skiprows=1)
        assert np.abs(np.loadtxt(made, delimiter=",", skiprows=1) - log).max() < 0.011


@pytest.fixture(scope="module")
def whole_way(tmp_path_factory):
    """The way of a foreign rig of 1 ms, and its folder."""
    folder = tmp_path_factory.mktemp("foreign") / "rig"
    return way.go(foreign.truth_of(0), folder), folder


def check(w):
    assert w.exit_code == 0, w.said
    assert w.beyond <= 1.0
    assert w.factor > 2.0
    assert abs(w.off_by("off")) < 0.05
    assert "friction falls" not in w.said and "the same friction both ways (L+ = L-)" in w.said


def test_a_foreign_rig_goes_the_whole_way(whole_way):
    check(whole_way[0])
    assert abs(whole_way[0].off_by("on")) < 0.05


def test_a_foreign_rig_whose_friction_builds_up_goes_the_whole_way(tmp_path):
    check(way.go(foreign.truth_of(5), tmp_path / "rig"))


COMMAND = "known: {command: true}\n"
UNEVEN = foreign.Truth("stribeck", 1e-3, 500.0, 200.0, 4e-5, 0.012, offset=0.3, slope=0.13, sliding=0.85, stribeck=0.3, presliding=0.05, noise=0.004, scale=1.0, bias=0.0, delay=1, high=16.0,
                       seed=11, downwards=1.25)


def each_way(truth, force, part=1.0):
    """L+ and L- of a rig; `part` of breakaway is left in sliding."""
    return [part * times * (truth.offset + truth.slope * force) for times in (1.0, truth.downwards)]


@pytest.fixture(scope="module")
def uneven(tmp_path_factory):
    """The way of a rig whose friction falls as it slides and is larger downwards. Its command is known."""
    folder = tmp_path_factory.mktemp("uneven") / "rig"
    return way.go(UNEVEN, folder, COMMAND), folder


def test_friction_of_each_direction_is_found_where_the_command_is_known(uneven):
    w, folder = uneven
    assert w.exit_code == 0, w.said
    assert w.beyond <= 1.0 and w.factor > 1.0
    loop, found = yaml.YAML(typ="safe").load((folder / "result/loop.yaml").read_text()), json.loads((folder / "result/verdict.json").read_text())
    header = [float(x) for x in re.findall(r"\.offset_n = (\S+)f, \.slope = (\S+)f", (folder / "result/loop_params.h").read_text())[0]]
    for place, part in (("plant", 1.0), ("compensator", UNEVEN.sliding)):
        law = loop[place]["friction"]["breakaway"]
        for force in (4.0, 8.0, 12.0):
            L = [law[f"{way}offset_N"] + law[f"{way}slope"] * force for way in ("", "negative_")]
            assert L == pytest.approx(each_way(UNEVEN, force, part), rel=min(found["known_within"], 0.01))
    law = loop["compensator"]["friction"]["breakaway"]
    assert header == pytest.approx([law["offset_N"], law["slope"]], rel=1e-5)
    assert "drive.command_n_per_unit=1 " in (folder / "result/registers.txt").read_text()
    assert "downwards it is 1.25 times that upwards" in w.said


def test_friction_that_falls_is_found_and_simulated(uneven):
    """Breakaway and speed of the fall; the prediction jumps where the rig does."""
    w, folder = uneven
    assert "VERDICT: tuned: " in w.said and "friction falls with speed: breakaway is 18 +- " in w.said
    plant = yaml.YAML(typ="safe").load((folder / "result/loop.yaml").read_text())["plant"]
    assert plant["model"] == "coulomb" and plant["coulomb"]["sliding_ratio"] == pytest.approx(UNEVEN.sliding, rel=0.01)
    assert plant["coulomb"]["stribeck_speed_deg_per_s"] == pytest.approx(UNEVEN.stribeck, rel=0.1)
    assert json.loads((folder / "result/verdict.json").read_text())["falls_by"] == pytest.approx(1 / UNEVEN.sliding - 1, abs=0.01)
    assert abs(w.off_by("off")) < 0.05 and abs(w.off_by("on")) < 0.05


def test_a_value_that_the_command_cannot_reveal_is_reported(uneven, tmp_path):
    """The same logs without a known command: symmetric friction of another scale makes them, too."""
    for name in ("rig.yaml", "1-ramp-log.csv", "2-slides-log.csv"):
        (tmp_path / name).write_text((uneven[1] / name).read_text().replace(COMMAND, ""))
    code, said = way.call(tmp_path)
    assert code == 0 and "assumed: the same friction both ways (L+ = L-). Pushing one way only" in said, said
    force, *L = (float(re.search(text, said)[1]) for text in (r"N at (\S+) N once it slides", r"L\+ is (\S+) N and L-", r"N and L- (\S+) N: then write known"))
    assert L == pytest.approx(each_way(UNEVEN, force, UNEVEN.sliding), rel=0.03)
    mean = float(re.search(r"friction: (\S+) N at", said)[1])
    found = json.loads((tmp_path / "result/verdict.json").read_text())
    assert abs(mean / np.mean(each_way(UNEVEN, force, UNEVEN.sliding)) - 1) < found["known_within"]
    assert "if it is the same both ways" in said


def test_accept_knows_the_rig_from_others(whole_way):
    truth = foreign.truth_of(0)
    said = way.accepted(whole_way[1] / "result", way.others(truth), truth.tick_s)
    assert {name: not against for name, against in said.items()} == {name: takes for name, (_, _, takes) in way.OTHERS.items()}, said


def test_a_drive_takes_the_registers(whole_way, tmp_path):
    """registers.txt line by line on tribo-desk, whose own file has the same limits, tick, poles and arm; it runs with loop.yaml then."""
    result, built = whole_way[1] / "result", ROOT / "build/host-release"
    loop, port = yaml.YAML(typ="safe").load((result / "loop.yaml").read_text()), 20000 + os.getpid() % 12000
    boot = {"duration_s": 5, "reference": {"kind": "triangle"}, "limits": loop["limits"], "compensator": {"arm": loop["compensator"]["arm"], "friction": {"gravity_N": loop["compensator"]["friction"]["gravity_N"]}}}
    poles = f"actuator_pole_rad_per_s: {loop['plant']['actuator_pole_rad_per_s']:g}, sensor_pole_rad_per_s: {loop['sensor']['pole_rad_per_s']:g}"
    (tmp_path / "boot.yaml").write_text("".join(f"{key}: {json.dumps(value)}\n" for key, value in boot.items()).replace('"', ""))
    (tmp_path / "rig.yaml").write_text(f"scenario: boot.yaml\nrealtime: {{required: no, catch_up_ms: 10000}}\nheartbeat_ms: 10000\nbus: {{port: {port}}}\nstore: params.bin\ndrive: {{{poles}}}\n")
    desk = subprocess.Popen([os.environ.get("TRIBO_DESK", built / "firmware/desk/tribo-desk"), "rig.yaml"], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
    try:
        while not desk.stderr.readline().startswith("off:"):
            assert desk.poll() is None
        lines = [line.split()[1:] for line in (result / "registers.txt").read_text().splitlines()]
        assert lines[0][:2] == ["params", "set"] and f"sample_time_s={loop['sample_time_s']:g}" in lines[0]
        for words in [*lines, ["params", "diff", "loop.yaml"], ["start"]]:
            done = subprocess.run([os.environ.get("TRIBO_LINK", built / "tools/link/tribo-link"), "-d", f"tcp:127.0.0.1:{port}", *words], cwd=result, capture_output=True, text=True, check=False)
            assert done.returncode == 0, (words, done.stdout, done.stderr)
    finally:
        desk.terminate()
        desk.communicate(timeout=100)


def test_a_loop_is_judged_by_the_lags_of_other_models_too():
    """Played(rms, variation), without and with compensation, for slower and faster lags and then for those of another model."""
    good, bad = ([accept.Played(1.0, 1.0), accept.Played(on, 1.0)] for on in (0.2, 0.95))
    runs = {case: [accept.Played(rms, 1.0)] * 3 for case, rms in (("off", 1.0), ("on", 0.1), ("less", 0.2), ("more", 0.2))}
    assert loop.against(runs, [good, good], 0.0) == [] and loop.against(runs, [good, good, good], 0.3) == []
    assert loop.against(runs, [good, good, bad], 0.0) == ["with the lags of another model that fits almost as well the error is 0.95 times that without compensation"]
    assert "lags 0.8 to 1.25 times" in loop.against(runs, [bad, good, good], 0.0)[0]
    assert "with the residual of the law the error is 0.95 times" in loop.against(runs, [good, good], 3.0)[0]


RIG = "sample_time_s: 1.0e-3\nforce: {low_N: 0, high_N: 10}\n"
WRONG = {
    "nothing": ("- 1\n", "rig.yaml"),
    "not filled in": (None, "rig.yaml:2: sample_time_s: value 'FILL_IN': must be a number"),
    "unknown field": (RIG + "mass: 2\n", "rig.yaml:3: mass: there is no such field"),
    "missing": ("sample_time_s: 1.0e-3\n", "rig.yaml:1: force: is missing"),
    "tick": (RIG.replace("1.0e-3", "1.0"), "rig.yaml:1: sample_time_s: value 1.0: must be at most 0.1"),
    "range": (RIG.replace("10}", "-1}"), "rig.yaml:2: force: value {'low_N': 0, 'high_N': -1}: high_N: value -1: must be above low_N"),
    "no rest": (RIG.replace("low_N: 0", "low_N: 5"), "low_N: value 5: must be 0 or less: an experiment begins and ends without a command, at 0 N: set low_N: 0, and task: {low_N: 5, high_N: 10}"),
    "task": (RIG + "task: {low_N: 2, high_N: 12}\n", "rig.yaml:3: task: value {'low_N': 2, 'high_N': 12}: must be within the safe forces, 0 to 10 N"),
    "command": (RIG + "command_per_N: 0\n", "rig.yaml:3: command_per_N: value 0: must not be 0"),
    "arithmetic": (RIG + "arithmetic: q15\n", "rig.yaml:3: arithmetic: value 'q15': must be one of 'f32' or 'q31'"),
    "role": (RIG + "log: {columns: {z: a}}\n", "rig.yaml:3: log.columns.z"),
    "no name": (RIG + "log: {columns: {F: ''}}\n", "rig.yaml:3: log.columns.F"),
    "hexadecimal": (RIG.replace("10}", "0x10}"), "rig.yaml:2: value 0x10: must be a decimal number"),
    "thousands": (RIG + "command_per_N: 1_000\n", "rig.yaml:3: value 1_000: must be a decimal number"),
    "thousands in text": (RIG + "command_per_N: '1_000.5e1'\n", "rig.yaml:3: value 1_000.5e1: must be a decimal number"),
    "yaml": (RIG + "log: {\n", "not YAML"),
    "twice": (RIG + "sample_time_s: 1.0e-3\n", "rig.yaml:3: sample_time_s: is given twice"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_field_is_named(case, tmp_path):
    text, said = WRONG[case]
    if text is None:
        assert way.call(tmp_path / "rig")[0] == 0
    else:
        (tmp_path / "rig").mkdir()
        (tmp_path / "rig/rig.yaml").write_text(text)
    code, out = way.call(tmp_path / "rig")
    assert code == 2 and said in out, out
    assert [p.name for p in (tmp_path / "rig").iterdir()] == ["rig.yaml"]


def test_a_folder_that_is_none_is_refused(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("mine")
    for words in ([""], ["file"], ["file", "--joint"]):
        assert cli.main(words) == 2 and f"FOLDER: value {words[0]!r}: must be a folder" in capsys.readouterr().err
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("file", "mine")]


@pytest.mark.parametrize("folder", ["-r", "it's", "my rig"])
def test_a_shell_hands_the_next_command_to_the_same_folder(folder, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for file, words, text in (("rig.yaml", (), RIG), ("joint.yaml", ("--joint",), "sample_time_s: 0.001\neffort_max: 10\n")):
        assert cli.main([*words, "--", folder]) == 0
        for _ in range(2):
            said = capsys.readouterr().out
            command = shlex.split(re.search(r"[Tt]hen run: (tribo-rig .*)", said)[1])
            assert command == ["tribo-rig", f"./{folder}" if folder[0] == "-" else folder]
            (tmp_path / folder / file).write_text(text)
            assert cli.main(command[1:]) == 0
        shutil.rmtree(tmp_path / folder)


def ramp_of(truth):
    """t, u, F of the first experiment on a rig, which does not scale u."""
    made = experiments.ramp(rigs.validate(rigs.Rig, {"sample_time_s": truth.tick_s, "force": {"low_N": 0, "high_N": truth.high}}, "rig.yaml"))
    foreigner, y = foreign.Foreign(truth), np.empty(len(made.u))
    for k, command in enumerate(made.u):
        y[k] = foreigner.read()
        foreigner.tick(command)
    return np.c_[made.time, made.u, y]


@pytest.fixture(scope="module")
def ramp():
    """rig.yaml, and t, u, F of the first experiment on a foreign rig."""
    return RIG.replace("10}", "400}"), ramp_of(replace(foreign.truth_of(0), tick_s=1e-3, high=400.0))


SMALL = {"seed 0": (0, 0.0), "seed 1": (1, 0.0), "seed 5": (5, 0.0), "in a short lag": (0, 0.02), "in a lag": (3, 0.02), "of LuGre": (4, 0.02)}


@pytest.mark.parametrize("case", SMALL)
def test_an_arm_without_stiction_is_distinguished_from_one_with_little(case, tmp_path):
    """Neither is asked for more force. Of friction 2 % of the ramp is nothing that the rate of the ramp hides."""
    seed, part = SMALL[case]
    truth = replace(foreign.truth_of(seed), offset=max(0.5 * part, 1e-9) * foreign.truth_of(seed).high, slope=0.0, scale=1.0, bias=0.0)
    (tmp_path / "rig.yaml").write_text(f"sample_time_s: {truth.tick_s}\nforce: {{low_N: 0, high_N: {truth.high}}}\n")
    np.savetxt(tmp_path / "1-ramp-log.csv", ramp_of(truth), delimiter=",", header="t_s,u_N,F_N", comments="", fmt="%.7g")
    code, said = way.call(tmp_path)
    assert "larger" not in said
    if part:
        assert code == 0 and "2-slides.csv" in said, said
    else:
        assert code == 3 and "1-ramp-log.csv: no stiction found: F follows u both ways and turns with it: " in said and "There is nothing" in said, said


@pytest.mark.parametrize("friction, noise, cause", [(0.02, 0.03, "noise"), (0.0, 0.0005, "no stiction")])
def test_friction_that_noise_hides_is_not_told_to_be_none(friction, noise, cause, tmp_path):
    """Friction and noise are in parts of the safe force."""
    truth = replace(foreign.truth_of(1), slope=0.0, scale=1.0, bias=0.0)
    truth = replace(truth, offset=max(friction, 1e-9) * truth.high)
    log = ramp_of(truth)
    log[:, 2] += np.random.default_rng(3).normal(0, noise * truth.high, len(log))
    (tmp_path / "rig.yaml").write_text(f"sample_time_s: {truth.tick_s}\nforce: {{low_N: 0, high_N: {truth.high}}}\n")
    np.savetxt(tmp_path / "1-ramp-log.csv", log, delimiter=",", header="t_s,u_N,F_N", comments="", fmt="%.7g")
    code, said = way.call(tmp_path)
    assert code == 3 and f"1-ramp-log.csv: {'F has noise of' if cause == 'noise' else 'no stiction found'}" in said and "larger" not in said, said
    assert ("There is nothing" in said) == (cause == "no stiction")


@pytest.mark.parametrize("moves", [(0, 1), (1, 1)])
def test_a_force_that_does_not_come_back_asks_for_no_more(moves, ramp, tmp_path):
    """It stands after it has risen, or before and after."""
    text, log = ramp
    log = log.copy()
    risen = np.maximum.accumulate(log[:, 2])
    log[:, 2] = np.maximum(risen - moves[0] * risen[3000], 0.0) if moves[0] else risen
    (tmp_path / "rig.yaml").write_text(text)
    np.savetxt(tmp_path / "1-ramp-log.csv", log, delimiter=",", header="t_s,u_N,F_N", comments="", fmt="%.7g")
    code, said = way.call(tmp_path)
    assert code == 3 and "F does not follow u up and down: it goes from" in said and "larger" not in said, said


SPOILT = {
    "sound": (lambda log: log, 0, "Play"),
    "late": (lambda log: np.r_[np.c_[np.arange(500) * 1e-3, np.zeros((500, 2))], log + [0.5, 0, 0]], 0, "Play"),
    "turned": (lambda log: log * [1, 1, -1], 3, "F falls where u rises"),
    "in mN": (lambda log: log * [1, 1, 1000], 3, "one of them is not in N (log.units: {F: mN}, or a factor: log.scales: {F: 0.0013} makes their ranges equal)"),
    "in kN": (lambda log: log * [1, 1, 0.001], 3, "(log.units: {F: kN}, or a factor: log.scales: {F: "),
    "of two stamps": (lambda log: log[np.r_[:500, 499 : len(log)]], 2, "(log.resample: yes repairs this)"),
    "ten times": (lambda log: log * [1, 1, 10], 3, "a newton of command makes 10 N"),
    "other command": (lambda log: log * [1, 0.5, 1], 2, "u is 0.5 times that of 1-ramp.csv in all rows"),
    "in ampere": (lambda log: log * [1, 0.05, 1], 2, "set log.scales: {u: 20} if the drive got the commands of the file"),
    "of another experiment": (lambda log: np.c_[log[:, 0], np.where(log[:, 0] > 9, log[:, 1] / 2, log[:, 1]), log[:, 2]], 2, "u differs from 1-ramp.csv, first at"),
    "short": (lambda log: log[:12_000], 2, "record all of it"),
    "in seconds": (lambda log: log * [1000, 1, 1], 2, "sample_time_s is 0.001 s"),
    "silent": (lambda log: log * [1, 1, 0], 3, "silent"),
    "no command": (lambda log: log * [1, 0, 1], 2, "u does not move"),
}


@pytest.mark.parametrize("case", SPOILT)
def test_a_spoilt_log_stops_the_way_and_says_why(case, ramp, tmp_path):
    text, log = ramp
    spoil, code, said = SPOILT[case]
    (tmp_path / "rig.yaml").write_text(text)
    np.savetxt(tmp_path / "1-ramp-log.csv", spoil(log), delimiter=",", header="t_s,u_N,F_N", comments="", fmt="%.7g")
    got, out = way.call(tmp_path)
    assert got == code and said in out, out
    assert (tmp_path / "2-slides.csv").exists() == (code == 0)


def test_a_command_that_is_logged_in_ampere_is_read_as_advised(ramp, tmp_path):
    text, log = ramp
    (tmp_path / "rig.yaml").write_text(text + "log: {scales: {u: 20}}\n")
    np.savetxt(tmp_path / "1-ramp-log.csv", log * [1, 0.05, 1], delimiter=",", header="t_s,u_N,F_N", comments="", fmt="%.7g")
    code, said = way.call(tmp_path)
    assert code == 0 and "2-slides.csv" in said, said


def test_a_force_in_mN_is_read_as_advised(ramp, tmp_path):
    text, log = ramp
    (tmp_path / "rig.yaml").write_text(text + "log: {units: {F: mN}}\n")
    np.savetxt(tmp_path / "1-ramp-log.csv", log * [1, 1, 1000], delimiter=",", header="t_s,u_N,F_N", comments="", fmt="%.7g")
    code, said = way.call(tmp_path)
    assert code == 0 and "2-slides.csv" in said, said


@pytest.mark.parametrize("option, key", [("(--unit F=mN, or", "(log.units: {F: mN}, or"), ("--unit u=mN", "log.units: {F: kN}"), ("--scale u=8e+02 makes", "log.scales: {F: 0.0013} makes"), ("--unit F=N m --scale F=NEWTON", "log.units: {F: N m} log.scales: {F: NEWTON}"),
                                         ("(--scale u=- or --scale F=-)", "(command_per_N with the other sign or log.scales: {F: -1})"), ("--scale F=-0.5)", "log.scales: {F: -0.5})"),
                                         ("(--resample=0.001)", "(log.resample: yes)"), ("(--column F=...)", "(log.columns: {F: ...})"),
                                         ("--scale F=-1: log.csv", "log.scales: {F: -1}: log.csv"), ("--unit F=...: is not", "log.units: {F: ...}: is not")])
def test_advice_names_what_the_rigs_file_has(option, key):
    assert cli.in_yaml(option) == key


def test_a_unit_in_the_log_that_nobody_said_is_named_as_rig_yaml_has_it(ramp, tmp_path):
    text, log = ramp
    np.savetxt(tmp_path / "1-ramp-log.csv", log * [1000, 1, 1], delimiter=",", header="t_s,u_N,F_N\nms,N,N", comments="", fmt="%.7g")
    for more, code, words in (("", 2, "column t_s is in ms: confirm this by log.units: {t: ms}, or give log.units: {t: s} if it is not"), ("log: {units: {t: ms}}\n", 0, "Play")):
        (tmp_path / "rig.yaml").write_text(text + more)
        got, said = way.call(tmp_path)
        assert got == code and words in said, said


def test_a_known_command_that_makes_friction_push_is_refused(ramp, tmp_path):
    text, log = ramp
    (tmp_path / "rig.yaml").write_text(text + COMMAND)
    np.savetxt(tmp_path / "1-ramp-log.csv", log * [1, 1, 1.5], delimiter=",", header="t_s,u_N,F_N", comments="", fmt="%.7g")
    code, said = way.call(tmp_path)
    assert code == 3 and "as known.command says: one of them would push" in said, said


@pytest.mark.parametrize("safe", [(0, 10), (-10, 10), (-3, 10)])
def test_no_experiment_leaves_the_safe_forces(safe):
    """Whatever the ramp finds, within what it lets through: command and force of an arm without friction."""
    source = np.random.default_rng(28)
    rig = rigs.validate(rigs.Rig, {"sample_time_s": 1e-3, "force": {"low_N": safe[0], "high_N": safe[1]}}, "rig.yaml")
    low, high = safe
    first = experiments.ramp(rig).u
    assert 0.5 * low <= first.min() and first.max() <= 0.5 * high
    for _ in range(20):
        found = experiments.First(source.uniform(0.7, 1.5), source.uniform(-1, 1), source.uniform(0, 0.5), source.uniform(0, 0.25), bins.Readings(0.001, 0.0))
        u = experiments.slides(rig, found).u
        for x in (u, found.scale * u + found.bias):
            assert low - abs(found.bias) - 1e-9 <= x.min() and x.max() <= high + 1e-9
        assert np.ptp(u) > 0.3 * (high - low) / found.scale


@pytest.mark.parametrize("scale", [1.06, 1.3])
def test_a_plan_alone_stays_below_the_limit_on_an_unknown_rig(scale, monkeypatch):
    """Played by the plan's own controller, without the careful ramp, on a drive that makes more of a newton than it says."""
    monkeypatch.setattr(bench, "SCALE", scale)
    plan, rig, h = Plan(0.0, 20.0, sample_time_s=bench.TICK_S).check(), bench.Bench(), bench.TICK_S
    rows = plan.reference()
    b, a = POLE * h / (2 + POLE * h), (POLE * h - 2) / (POLE * h + 2)
    u = error = 0.0
    for r in np.interp(np.arange(0, rows[-1, 0], h), rows[:, 0], rows[:, 1]):
        last, error = error, r - rig.read()
        u = min(max(b * (error + last) - a * u, 0.0), 20.0)
        rig.tick(u)
    assert 10 < rig.largest < 20
