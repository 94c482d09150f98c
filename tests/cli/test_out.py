"""--out and --plot on files, links, pipes and folders that exist: what is kept, what is refused, and when."""

import os
import resource
import signal
import stat
import subprocess
import threading

import pytest
from conftest import SHORT, processor_s, until

OLD = "old content, longer than a few bytes\n"
ROWS = "t_s,u_N,F_N\n" + "".join(f"{k / 1000:g},{0.3 + k % 7 / 100:g},{0.2 + k % 5 / 100:g}\n" for k in range(400))

# Each command that writes the one file that --out names.
COMMANDS = (("params", "triangle", "--out"), ("log", "log.csv", "--out"), ("replay", "log.csv", "--out"))


@pytest.fixture(params=COMMANDS, ids=lambda command: command[0])
def writes(request, sim):
    """The command up to its --out, and its result as it is on standard output."""
    sim.write("log.csv", ROWS)
    return request.param, sim.ok(*request.param[:-1])


def left_in(folder):
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o644, 0o664, 0o755])
def test_a_file_keeps_its_mode(sim, writes, mode):
    command, content = writes
    out = sim.write("out", OLD)
    out.chmod(mode)
    sim.ok(*command, "out")
    assert out.read_text() == content and stat.S_IMODE(out.stat().st_mode) == mode


def test_a_read_only_file_is_refused_before_the_work(sim, writes):
    command, _ = writes
    out = sim.write("out", OLD)
    for mode in (0o444, 0o400, 0o555):
        out.chmod(mode)
        before = left_in(sim.folder)
        sim.fails("out: cannot be written: it is read-only", *command, "out")
        assert out.read_text() == OLD and stat.S_IMODE(out.stat().st_mode) == mode and left_in(sim.folder) == before


def test_a_link_stays_a_link_and_a_read_only_target_is_refused(sim, writes):
    command, content = writes
    (sim.folder / "far").mkdir()
    target = sim.write("far/target", OLD)
    target.chmod(0o640)
    link = sim.folder / "out"
    link.symlink_to("far/target")
    sim.ok(*command, "out")
    assert os.readlink(link) == "far/target" and target.read_text() == content and stat.S_IMODE(target.stat().st_mode) == 0o640
    target.chmod(0o440)
    sim.fails("out: cannot be written: it is read-only", *command, "out")
    assert target.read_text() == content and left_in(sim.folder / "far") == ["target"]


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may give files away")
def test_the_owner_stays(sim, writes):
    command, content = writes
    out = sim.write("out", OLD)
    os.chown(out, 12345, 54321)
    sim.ok(*command, "out")
    assert (out.stat().st_uid, out.stat().st_gid) == (12345, 54321) and out.read_text() == content


@pytest.mark.parametrize("path", ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"])
def test_standard_output_by_its_path_is_appended_to(sim, writes, path):
    command, content = writes
    with open(sim.folder / "all", "w", encoding="ascii") as out:
        out.write("before\n")
        out.flush()
        done = sim(*command, path, stdout=out)
        out.seek(0, os.SEEK_END)
        out.write("after\n")
    said = (sim.folder / "all").read_text()
    assert done.returncode == 0 and said.startswith("before\n" + content) and said.endswith("after\n")


@pytest.mark.parametrize("path", ["/dev/stderr", "/dev/fd/2", "/proc/self/fd/2"])
def test_standard_error_by_its_path_is_appended_to(sim, writes, path):
    command, content = writes
    log = sim.write("log", "before\n")
    with open(log, "a", encoding="ascii") as out:
        subprocess.run([sim.program, *command, path], cwd=sim.folder, stderr=out, stdout=subprocess.DEVNULL, check=True)
    assert log.read_text().startswith("before\n") and content in log.read_text()


def test_a_pipe_gets_the_content(sim, writes):
    command, content = writes
    pipe = sim.folder / "out"
    os.mkfifo(pipe)
    got = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_text()), daemon=True)
    reader.start()
    sim.ok(*command, "out")
    reader.join(200)
    assert got == [content] and stat.S_ISFIFO(pipe.stat().st_mode)


def test_places_that_take_no_file(sim, writes):
    command, _ = writes
    (sim.folder / "folder").mkdir()
    before = left_in(sim.folder)
    for out, why in (("folder", "Is a directory"), ("folder/", "Is a directory"), ("no/out", "No such file or directory"),
                     ("log.csv/out", "Not a directory"), ("", "No such file or directory"), ("/dev/full", "No space left on device")):
        result = sim(*command, out)
        assert result.returncode == 1 and result.stderr == f"tribo-sim: {out}: cannot be written: {why}\n"
        assert left_in(sim.folder) == before


# The log does not exist, so only a check before the work can name the place.
@pytest.mark.parametrize("command", [("log", "none.csv", "--out"), ("replay", "none.csv", "--out"), ("replay", "none.csv", "--plot")])
def test_a_wrong_place_is_found_before_the_log_is_read(sim, command):
    out = "no/x.png"
    sim.fails(f"{out}: cannot be written: No such file or directory", *command, out)


@pytest.mark.parametrize("options", [("--out", "no/file/d"), ("--plot", "no/x.png"), ("--plot", "no/x.html"), ("--plot", "old.png")])
def test_a_wrong_place_is_found_before_the_run(sim, options):
    """A run of days would not end within the time of a test."""
    sim.write("no", "") if options[0] == "--out" else None
    sim.write("old.png", OLD).chmod(0o444)
    result = sim("run", "triangle", "--set", "duration_s=80000", *options)
    assert result.returncode == 1 and (f"{options[1]}: cannot be written: " in result.stderr or "the folder cannot be created" in result.stderr)
    assert (sim.folder / "old.png").read_text() == OLD


@pytest.mark.parametrize("name", ["trace.csv", "trace_q31.csv", "learned.yaml", "scenario.yaml", "summary.json"])
def test_a_read_only_file_of_an_earlier_run_is_refused_before_the_run(sim, name):
    sim.ok("run", "triangle", "--set", "duration_s=1", "--set", "metrics.start_s=0", "--arith", "both", "--out", "d")
    path = sim.folder / "d" / name
    before = {path.name: path.read_bytes() for path in (sim.folder / "d").iterdir()}
    path.chmod(0o444)
    result = sim("run", "triangle", "--set", "duration_s=80000", "--out", "d")
    assert (result.returncode, result.stderr) == (1, f"tribo-sim: d/{name}: cannot be written: it is read-only\n")
    assert {path.name: path.read_bytes() for path in (sim.folder / "d").iterdir()} == before


def test_the_files_of_a_run_keep_their_modes(sim):
    sim.write("x.yaml", SHORT)
    sim.ok("run", "x.yaml", "--out", "d")
    (sim.folder / "d/trace.csv").chmod(0o600)
    sim.ok("run", "x.yaml", "--set", "duration_s=0.02", "--out", "d")
    assert stat.S_IMODE((sim.folder / "d/trace.csv").stat().st_mode) == 0o600


def test_a_full_disk_leaves_the_file_as_it_was(sim, writes):
    command, _ = writes
    out = sim.write("out", OLD)
    limit = len(OLD) + 100

    result = sim(*command, "out", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
    assert result.returncode == 1 and result.stderr == "tribo-sim: out: cannot be written: File too large\n"
    assert out.read_text() == OLD


@pytest.mark.parametrize("options, result", [
    ("scenario.yaml --out .", "./scenario.yaml"), ("x.yaml --out .", "./trace.csv"), ("x.yaml --learned learned.yaml --set reference.kind=step --out .", "./learned.yaml"),
    ("x.yaml --learned learned.yaml --set compensator.method=paper --set reference.kind=step --out link", "link/learned.yaml"), ("x.svg --plot x.svg", "x.svg"), ("x.svg --plot link/x.svg", "link/x.svg")])
def test_a_run_does_not_write_over_its_inputs(sim, options, result):
    for name in ("scenario.yaml", "x.svg"):
        sim.write(name, SHORT)
    sim.write("x.yaml", "# by hand\nduration_s: 0.01\nreference: {kind: csv, file: trace.csv}\n")
    sim.write("trace.csv", "t_s,r_N\n0,0\n1,0.1\n")
    sim.write("learned.yaml", "gain: 0.9\n")
    (sim.folder / "link").symlink_to(".")
    if "reference.kind=step" in options:
        (sim.folder / "trace.csv").unlink()
    before = {path.name: path.read_bytes() for path in sim.folder.iterdir() if path.is_file()}
    sim.fails(f"{result}: cannot be written: this run reads it", "run", *options.split())
    assert {path.name: path.read_bytes() for path in sim.folder.iterdir() if path.is_file()} == before
    sim.fails("params: --out learned.yaml is the same file as --learned learned.yaml (tribo-sim --help lists the commands)",
              "params", "scenario.yaml", "--learned", "learned.yaml", "--out", "learned.yaml", status=2)


# What was there before, and where the run writes to.
FOLDERS = (("", "a"), ("", "a/b//c/"), ("a", "a/b/c"), ("a/b", "a/b"), ("", "{}/a/b"))


def start_in(sim, before, out):
    if before:
        (sim.folder / before).mkdir(parents=True)
    return "run", "triangle", "--set", "duration_s=80000", "--out", out.format(sim.folder)


@pytest.mark.parametrize("before, out", FOLDERS)
def test_a_run_that_fails_leaves_no_folder(sim, before, out):
    command = start_in(sim, before, out)
    left = sorted(sim.folder.rglob("*"))
    result = sim(*command, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100000, 100000)))
    assert result.returncode == 1 and "trace.csv: cannot be written: File too large" in result.stderr
    assert sorted(sim.folder.rglob("*")) == left


@pytest.mark.parametrize("before, out, number", [*((*folder, signal.SIGTERM) for folder in [*FOLDERS, ("", None)]), ("", "a", signal.SIGINT),
                                                 ("", None, signal.SIGINT), ("", "a", signal.SIGHUP), ("", None, signal.SIGHUP)])
def test_a_signal_leaves_no_folder(sim, before, out, number):
    """Neither the folder of --out nor, for a picture alone, a temporary one is left."""
    command = start_in(sim, before, out or "") if out else (*start_in(sim, before, "")[:-2], "--plot", "x.svg")
    left = sorted(sim.folder.rglob("*"))
    (sim.folder / "tmp").mkdir()
    run = subprocess.Popen([sim.program, *command], cwd=sim.folder, env={**os.environ, "TMPDIR": str(sim.folder / "tmp")})
    until(lambda: processor_s(run.pid) > 0.3, "it does not run")
    run.send_signal(number)
    assert run.wait(timeout=200) == -number and list((sim.folder / "tmp").iterdir()) == []
    (sim.folder / "tmp").rmdir()
    assert sorted(sim.folder.rglob("*")) == left


def test_options_without_effect_are_refused(sim):
    sim.write("log.csv", ROWS)
    hint = " (tribo-sim --help lists the commands)"
    for message, *command in (("--decimate needs --out or --plot", "run", "triangle", "--decimate", 3),
                              ("--columns needs --out or --plot", "run", "triangle", "--columns", "u_N"),
                              ("--all needs --plot", "run", "triangle", "--all"),
                              ("log: --gap needs --resample", "log", "log.csv", "--gap", 1),
                              ("replay: --gap needs --resample", "replay", "log.csv", "--gap", 1),
                              ("--full-scale needs --arith q31 or both", "replay", "log.csv", "--full-scale", 3),
                              ("list: --parameters goes with no other option", "list", "--keys", "--parameters"),
                              ("list: --parameters goes with no other option", "list", "--parameters", "--markdown"),
                              ("fmu: --arith is the loop's, and --part plant has none", "fmu", "triangle", "--part", "plant", "--arith", "f32", "--out", "x.fmu")):
        sim.fails(message + hint, *command, status=2)
    assert sim.ok("list", "--keys", "--markdown") == sim.ok("list", "--markdown") == sim.ok("list", "--markdown", "--keys")


@pytest.mark.parametrize("closed", [(1,), (2,), (0, 1, 2), (0, 1)])
def test_a_file_does_not_take_the_place_of_a_closed_descriptor(sim, closed):
    def close():
        for descriptor in closed:
            os.close(descriptor)

    sim.write("x.yaml", SHORT)
    sim.ok("run", "x.yaml", "--out", "whole")
    result = sim("run", "x.yaml", "--out", "d", preexec_fn=close)
    assert result.returncode == (1 if 1 in closed else 0)
    assert result.stderr == ("tribo-sim: standard output: cannot be written: Bad file descriptor\n" if 1 in closed and 2 not in closed else "")
    for name in ("trace.csv", "scenario.yaml"):
        mine, whole = ((sim.folder / folder / name).read_text().splitlines()[1:] for folder in ("d", "whole"))
        assert mine == whole
