"""What the tools in Python do with a result file that exists, with a place that takes none, and with standard output that is lost."""

import os
import signal
import stat
import subprocess
import sys

import pytest
from conftest import ROOT

from tribo_plot import output

OLD = b"old content, longer than the new one\n"
NEW = "new\n"
RUN = "t_s,r_N,F_N,u_N\n" + "".join(f"{k / 100:g},0.5,{0.5 - k % 3 / 100:g},{0.6 + k % 2 / 100:g}\n" for k in range(300))
TOOL = [sys.executable, "-B", "-m"]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "tools")}


def plot(folder, *arguments, **options):
    (folder / "run.csv").write_text(RUN, encoding="ascii")
    return subprocess.run([*TOOL, "tribo_plot", *map(str, arguments)], capture_output=True, text=True, check=False, cwd=folder, env=ENVIRONMENT, timeout=600, **options)


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o664])
def test_a_file_keeps_its_mode_and_a_link_stays(tmp_path, mode):
    place, link = tmp_path / "place", tmp_path / "link"
    place.write_bytes(OLD)
    place.chmod(mode)
    link.symlink_to("place")
    output.write(link, NEW)
    assert place.read_text() == NEW and stat.S_IMODE(place.stat().st_mode) == mode and os.readlink(link) == "place"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["link", "place"]


def test_a_new_file_has_the_mode_of_any_new_file(tmp_path):
    mask = os.umask(0o027)
    try:
        output.write(tmp_path / "place", NEW)
    finally:
        os.umask(mask)
    assert stat.S_IMODE((tmp_path / "place").stat().st_mode) == 0o640


@pytest.mark.parametrize("place, why", [("old", "it is read-only"), ("link", "it is read-only"), ("folder", "Is a directory"), ("no/file", "No such file or directory"), ("old/file", "Not a directory")])
def test_a_place_that_takes_no_file_is_named_before_the_work(tmp_path, place, why):
    (tmp_path / "old").write_bytes(OLD)
    (tmp_path / "old").chmod(0o444)
    (tmp_path / "link").symlink_to("old")
    (tmp_path / "folder").mkdir()
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(output.PlaceError, match=f"{place}: cannot be written: {why}"), output.replaced(tmp_path / place):
        pytest.fail("the work has begun")
    assert sorted(tmp_path.rglob("*")) == before and (tmp_path / "old").read_bytes() == OLD


def test_what_is_not_finished_leaves_the_old_file(tmp_path):
    place = tmp_path / "place"
    place.write_bytes(OLD)
    with pytest.raises(RuntimeError), output.replaced(place) as new:
        new.write_text("half")
        raise RuntimeError
    assert place.read_bytes() == OLD and list(tmp_path.iterdir()) == [place]


@pytest.mark.parametrize("before, made", [("", "a"), ("", "a/b/c"), ("a", "a/b/c"), ("a/b", "a/b")])
def test_a_folder_goes_if_the_work_in_it_fails(tmp_path, before, made):
    (tmp_path / before).mkdir(parents=True, exist_ok=True)
    there = sorted(tmp_path.rglob("*"))
    for error in (KeyboardInterrupt, OSError):
        with pytest.raises(error), output.folder(tmp_path / made):
            assert (tmp_path / made).is_dir()
            raise error
        assert sorted(tmp_path.rglob("*")) == there
    with output.folder(tmp_path / made):
        pass
    assert (tmp_path / made).is_dir()


HALF = """
import pathlib, sys, time
from tribo_plot import output
def work():
    with output.folder(pathlib.Path("a/b")), output.replaced("a/b/c") as new:
        new.write_text("half")
        print("begun", flush=True)
        time.sleep(600)
sys.exit(output.run("half", work))
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_leaves_nothing_half_made(tmp_path, number):
    with subprocess.Popen([sys.executable, "-B", "-c", HALF], cwd=tmp_path, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        assert run.stdout.readline() == "begun\n"
        run.send_signal(number)
        assert run.wait(timeout=200) == 128 + number and run.stderr.read() == "" and list(tmp_path.iterdir()) == []


def test_a_callers_signals_stay_its_own():
    seen = output.run("x", lambda: signal.getsignal(signal.SIGTERM))
    assert callable(seen) and signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


@pytest.mark.parametrize("ending", ["png", "html"])
def test_a_picture_does_not_replace_a_read_only_file(tmp_path, ending):
    old = tmp_path / f"old.{ending}"
    old.write_bytes(OLD)
    old.chmod(0o444)
    result = plot(tmp_path, "run.csv", "--out", old.name)
    assert (result.returncode, result.stderr) == (1, f"tribo-plot: {old.name}: cannot be written: it is read-only\n")
    assert old.read_bytes() == OLD and stat.S_IMODE(old.stat().st_mode) == 0o444


@pytest.mark.parametrize("options, why", [
    (["run.csv", "--name", "a", "--name", "b"], "--name b: there are 2 names for 1 run"),
    (["run.csv", "run.csv", "--name", "a", "--name", "b", "--name", "c"], "--name c: there are 3 names for 2 runs"),
    (["run.csv", "--from", "2", "--to", "1"], "--from 2 --to 1: the first time must be the smaller one"),
    (["run.csv", "--from", "nan"], "--from nan: a time in s is expected"), (["run.csv", "--to", "inf"], "--to inf: a time in s is expected")])
def test_options_without_effect_are_refused(tmp_path, options, why):
    result = plot(tmp_path, *options, "--out", "x.png")
    assert (result.returncode, result.stdout, result.stderr) == (1, "", f"tribo-plot: {why}\n") and not (tmp_path / "x.png").exists()


PATH = {"PYTHONPATH": os.pathsep.join(str(ROOT / "tools" / name) for name in ("", "design", "identify", "rig"))}


@pytest.mark.parametrize("command, said", [
    ([*TOOL, "tribo_plot", "a", "--out", "b", "--out", "c"], "--out b and --out c: only one is expected"),
    ([*TOOL, "tribo_plot", "a", "--out", "b", "--all", "--all"], "--all is given twice"),
    ([*TOOL, "tribo_plot.sweep", "a", "--workers", "1", "--work=2"], "--workers 1 and --workers 2: only one is expected"),
    ([*TOOL, "tribo_design", "compare", "a", "--structures", "pi", "--structures", "pid"], "--structures pi and --structures pid: only one is expected"),
    ([*TOOL, "tribo_identify", "plan", "--low", "-1", "--low", "1"], "--low -1 and --low 1: only one is expected"),
    ([*TOOL, "tribo_identify", "friction", "a", "--column", "u=b", "--column", "F=b", "--column", "u=c"], "--column u=b and --column u=c: only one is expected"),
    ([*TOOL, "tribo_identify", "friction", "a", "--resample", "--resample", "1"], "--resample and --resample 1: only one is expected"),
    ([*TOOL, "tribo_rig", "a", "--joint", "--joint"], "--joint is given twice"),
    ([sys.executable, "-B", ROOT / "tools/tribo-fmu", "--part", "axis", "--set", "a=1", "--set", "b=1", "--set", "a=2"], "--set a=1 and --set a=2: only one is expected"),
    ([sys.executable, "-B", ROOT / "tools/link/demo-drive", "--port", "1", "--port", "2"], "--port 1 and --port 2: only one is expected"),
    ([sys.executable, "-B", ROOT / "tools/dev/playground", "--port", "1", "--port", "2"], "--port 1 and --port 2: only one is expected")])
def test_an_option_is_given_once(tmp_path, command, said):
    result = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path, env=ENVIRONMENT | PATH, timeout=600)
    assert result.returncode == 2 and result.stderr.endswith(f": error: {said}\n"), result
    assert not list(tmp_path.iterdir())


def test_what_may_be_repeated_is_taken_in_order(tmp_path):
    (tmp_path / "other.csv").write_text(RUN, encoding="ascii")
    result = plot(tmp_path, "run.csv", "other.csv", "--name", "one", "--name", "one", "--name", "three", "--out", "x.png")
    assert result.stderr == "tribo-plot: --name three: there are 3 names for 2 runs\n"


def test_names_that_begin_with_a_hyphen_are_names(tmp_path):
    """Also where tribo-sim passes them to tribo-plot."""
    sim = os.environ["TRIBO_SIM"]
    short = ("--set", "duration_s=0.1", "--set", "metrics.start_s=0")
    for words in (("run", "step", *short, "--out=-run", "--plot=-a.svg", "--all"), ("run", "step", *short, "--plot=-b.svg"), ("plot", "--out=-c.svg", "--name=-x", "--from", "-1", "--", "-run", "-run/trace.csv"),
                  ("plot", "--all", "--out=-d.svg", "./-run")):
        done = subprocess.run([sim, *words], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=600)
        assert (done.returncode, done.stderr) == (0, ""), (words, done)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["-a.svg", "-b.svg", "-c.svg", "-d.svg", "-run"]


def test_options_of_a_run_are_refused_for_a_sweep_and_mcap(tmp_path):
    (tmp_path / "rows.parquet").write_bytes(b"")
    for option in (["--name", "a"], ["--from", "1"], ["--to", "1"], ["--all"]):
        result = plot(tmp_path, "rows.parquet", *option, "--out", "x.png")
        assert result.returncode == 1 and result.stderr.startswith(f"tribo-plot: {option[0]}: a sweep has neither times nor runs"), result
    assert "--all: an .mcap file has all columns" in plot(tmp_path, "run.csv", "--all", "--out", "x.mcap").stderr


@pytest.mark.parametrize("words", [["tribo_plot", "--help"], ["tribo_plot", "--version"], ["tribo_plot.sweep", "--help"], ["tribo_plot.sweep", "--version"]])
@pytest.mark.parametrize("lost", ["full", "closed", "gone"])
def test_a_failed_write_of_the_help_is_an_error(words, lost):
    lost_is_an_error([*TOOL, *words], "tribo-" + words[0].replace("_plot.", "-").split("-")[-1].removeprefix("tribo_"), lost)


@pytest.mark.parametrize("script, option", [("tools/tribo-fmu", "--help"), ("tools/tribo-fmu", "--version"), ("tools/link/demo-drive", "--help"), ("tools/link/demo-drive", "--version")])
@pytest.mark.parametrize("lost", ["full", "closed", "gone"])
def test_a_failed_write_of_a_scripts_help_is_an_error(script, option, lost):
    lost_is_an_error([sys.executable, "-B", ROOT / script, option], {"tools/tribo-fmu": "tribo-fmu"}.get(script, "tribo-demo-drive"), lost)


def lost_is_an_error(command, program, lost):
    environment = {name: value for name, value in ENVIRONMENT.items() if name != "PYTHONUNBUFFERED"}
    if lost == "gone":
        reader, writer = os.pipe()
        os.close(reader)
        result = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True, check=False, env=environment, timeout=600)
        os.close(writer)
        assert (result.returncode, result.stderr) == (141, "")
        return
    with open("/dev/full", "w", encoding="ascii") as full:
        result = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False, env=environment, timeout=600,
                                preexec_fn=(lambda: os.close(1)) if lost == "closed" else None)
    why = "No space left on device" if lost == "full" else "Bad file descriptor"
    assert (result.returncode, result.stderr) == (1, f"{program}: standard output: cannot be written: {why}\n")


def test_a_sweeps_options_that_the_others_make_useless_are_refused():
    for words, why in ((["--row", "1", "--workers", "2"], "--workers: --row plays nothing"), (["--row", "1", "--report"], "--report: --row plays nothing"),
                       (["--row", "1", "--shard", "1/2"], "--shard: --row plays nothing"), (["--out", "d", "--workers", "2", "--scheduler", "x"], "--workers is of this machine")):
        result = subprocess.run([*TOOL, "tribo_plot.sweep", "study", *words], capture_output=True, text=True, check=False, env=ENVIRONMENT, timeout=600)
        assert result.returncode == 2 and why in result.stderr, result
