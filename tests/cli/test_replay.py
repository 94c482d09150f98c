"""`replay`: against the golden vectors, and every way in which a log can be wrong."""

import os
import pathlib
import re
import stat
import subprocess

import pytest

from conftest import PAPER, numbers, read_csv, read_vectors

HEADER = "t_s,u_N,F_hat_N,n_N,L_N,v_N_per_s,Q1,Q2,Q,f_hat_N"

ASYMMETRIC = """friction:
  breakaway: {offset_N: 0.01, slope: 0.25, negative_offset_N: 0.005, negative_slope: 0.35}
  gravity_N: 0.004
"""
PARAMS = {"paper": "{}\n", "asymmetric_gravity": ASYMMETRIC, "k1p1": "friction: {k_min: 1.1, k_max: 1.1}\n"}


def log_of(sim, name, columns):
    """The input of golden vectors as a log, with time stamps at 1 ms."""
    rows = read_vectors(name)
    lines = ["t_s," + ",".join(columns)]
    for k in range(len(rows["u_N"])):
        lines.append(f"{k * 0.001:.3f}," + ",".join(f"{rows[name][k]:.12g}" for name in columns))
    sim.write("log.csv", "\n".join(lines) + "\n")
    return rows


def compare(golden, result, pairs, tolerance):
    """Where the logic agrees the numbers do too; where it does not, it is for two ticks at most."""
    agree = [all(golden[name][k] == result[name][k] for name in ("Q1", "Q2", "Q")) for k in range(len(golden["u_N"]))]
    longest = run = 0
    for same in agree:
        run = 0 if same else run + 1
        longest = max(longest, run)
    assert longest <= 2
    for golden_name, name in pairs:
        worst = max(abs(a - b) for a, b, same in zip(golden[golden_name], result[name], agree) if same)
        assert worst <= tolerance, name


@pytest.mark.parametrize("params", ["paper", "asymmetric_gravity"])
def test_own_force_reproduces_the_golden_compensator(sim, params):
    golden = log_of(sim, f"compensator_{params}", ["u_N"])
    sim.write("p.yaml", PARAMS[params])
    sim.ok("replay", "log.csv", "--params", "p.yaml", "--out", "out.csv")
    result = read_csv(sim.folder / "out.csv")
    compare(golden, result, [("F_hat_N", "F_hat_N"), ("f_N", "f_hat_N")], 5e-5)
    assert result["t_s"] == tuple(round(k * 0.001, 3) for k in range(len(golden["u_N"])))
    assert result["u_N"] == pytest.approx(golden["u_N"], rel=1e-8)


@pytest.mark.parametrize("params", ["paper", "asymmetric_gravity", "k1p1"])
def test_measured_force_reproduces_the_golden_friction(sim, params):
    golden = log_of(sim, f"friction_{params}", ["F_N", "u_N"])
    sim.write("p.yaml", PARAMS[params])
    sim.ok("replay", "log.csv", "--params", "p.yaml", "--force", "measured", "--out", "out.csv")
    result = read_csv(sim.folder / "out.csv")
    compare(golden, result, [("F_N", "F_hat_N"), ("n_N", "n_N"), ("f_N", "f_hat_N")], 2e-5)
    compare(golden, result, [("L_N", "L_N")], 1e-6)
    compare(golden, result, [("v_N_per_s", "v_N_per_s")], 1e-3)


def test_replay_of_a_simulated_run_gives_what_the_loop_saw(sim):
    trace = sim.trace("triangle", *PAPER, "--set", "duration_s=5", "--set", "metrics.start_s=0")
    sim.ok("replay", "trace_of_run/trace.csv", "--out", "out.csv")
    result = read_csv(sim.folder / "out.csv")
    for name in ("F_hat_N", "n_N", "L_N", "Q1", "Q2", "Q", "f_hat_N"):
        assert result[name] == pytest.approx(trace[name], abs=1e-6), name


@numbers
def test_set_goes_over_the_params_file(sim):
    log_of(sim, "compensator_paper", ["u_N"])
    sim.write("p.yaml", "friction: {k_min: 3}\n")
    soft = sim.ok("replay", "log.csv", "--params", "p.yaml")
    assert soft == sim.ok("replay", "log.csv", "--set", "compensator.friction.k_min=3")
    assert soft != sim.ok("replay", "log.csv")
    assert sim.ok("replay", "log.csv") == sim.ok("replay", "log.csv", "--params", "p.yaml", "--set", "compensator.friction.k_min=6")


@numbers
def test_a_breakaway_table_is_used(sim):
    log_of(sim, "friction_paper", ["F_N", "u_N"])
    points = ", ".join(f"{{force_N: {F}, positive_N: {0.007 + 0.3 * F}, negative_N: {0.007 + 0.3 * F}}}" for F in (0, 1, 10))
    sim.write("p.yaml", f"friction:\n  breakaway:\n    table: [{points}]\n")
    sim.ok("replay", "log.csv", "--params", "p.yaml", "--force", "measured", "--out", "table.csv")
    sim.ok("replay", "log.csv", "--force", "measured", "--out", "line.csv")
    table, line = read_csv(sim.folder / "table.csv"), read_csv(sim.folder / "line.csv")
    for name in ("L_N", "f_hat_N"):
        assert table[name] == pytest.approx(line[name], abs=1e-5)


def test_a_set_that_replay_does_not_read(sim):
    sim.write("log.csv", GOOD)
    hint = " (tribo-sim --help lists the commands)"
    sim.fails(f"replay: --set plant.model=lugre: replay reads only keys of compensator{hint}", "replay", "log.csv", "--set",
              "plant.model=lugre", status=2)
    for other in ("compensator.method=feedforward", "compensator.gain=0.5", "compensator.guard.on=yes", "compensator.feedforward.lead=2"):
        sim.fails(f"replay: --set {other}: replay judges the friction model, and this key is not part of it{hint}", "replay", "log.csv", "--set",
                  other, status=2)
    sim.fails(f"--set compensator.gain: key=value is expected{hint}", "replay", "log.csv", "--set", "compensator.gain", status=2)
    sim.fails("--set compensator.model=lugre: unknown key compensator.model, did you mean plant.model?", "replay", "log.csv", "--set", "compensator.model=lugre")


@numbers
def test_the_paper_is_the_default(sim):
    log_of(sim, "compensator_paper", ["u_N"])
    sim.write("p.yaml", "{}\n")
    assert sim.ok("replay", "log.csv") == sim.ok("replay", "log.csv", "--params", "p.yaml", "--force", "own")


def test_the_sample_time_is_the_logs(sim):
    sim.write("slow.csv", "t_s,u_N\n0,0\n0.002,0.002\n0.004,0.006\n")
    lines = sim.ok("replay", "slow.csv").splitlines()
    assert lines[0] == HEADER
    assert [float(line.split(",")[5]) for line in lines[1:]] == pytest.approx([0, 1, 2], rel=1e-6)


def test_time_stamps_come_out_as_they_went_in(sim):
    stamps = ["1700000000.001", "1700000000.002", "1700000000.003", "1700000000.004"]
    sim.write("log.csv", "t_s,u_N\n" + "".join(f"{stamp},0\n" for stamp in stamps))
    assert [line.split(",")[0] for line in sim.ok("replay", "log.csv").splitlines()[1:]] == stamps


GOOD = "t_s,u_N\n0,0.1\n0.001,0.2\n0.002,0.3\n"

HARMLESS = {
    "CRLF": GOOD.replace("\n", "\r\n"),
    "byte order mark": b"\xef\xbb\xbf" + GOOD.encode(),
    "byte order mark and quotes": b'\xef\xbb\xbf"t_s","u_N"\n0,0.1\n0.001,0.2\n0.002,0.3\n',
    "quoted fields": '"t_s","u_N"\n"0",0.1\n0.001,"0.2"\n0.002 , "0.3" \n',
    "quoted comma elsewhere": 't_s,"a, b ""c""",u_N\n0,"1, ""2""",0.1\n0.001,,0.2\n0.002,,0.3\n',
    "spaces": " t_s , u_N\n 0,\t0.1 \n0.001,0.2\n0.002,0.3\n",
    "empty lines at the end": GOOD + "\n \n\r\n",
    "no last newline": GOOD.rstrip("\n"),
    "other columns": "x,u_N,t_s,note\na,0.1,0,\nb,0.2,0.001,nan\n,0.3,0.002,?\n",
    "other columns twice": "x,t_s,x,u_N\n,0,,0.1\n,0.001,,0.2\n,0.002,,0.3\n",
    "numbers in other ways": "t_s,u_N\n0e0,+.1\n1E-3,2.e-1\n+0.002,30e-2\n",
    "jitter": "t_s,u_N\n0,0.1\n0.00100001,0.2\n0.002,0.3\n",
    "later origin": GOOD.replace("0,0.1", "1000,0.1").replace("0.001", "1000.001").replace("0.002", "1000.002"),
}


@pytest.mark.parametrize("case", HARMLESS)
def test_a_harmless_log_is_read(sim, case):
    sim.write("good.csv", GOOD)
    sim.write("log.csv", HARMLESS[case])
    expected = [line.split(",")[1:5] for line in sim.ok("replay", "good.csv").splitlines()]
    assert [line.split(",")[1:5] for line in sim.ok("replay", "log.csv").splitlines()] == expected


MISTAKES = {
    "empty file": ("", ":1:1: the file is empty"),
    "nothing but lines": ("\n\r\n \n", ":1:1: the file is empty"),
    "header only": ("t_s,u_N\n", ":2:1: no rows after the header"),
    "one row": ("t_s,u_N\n0,0.1\n", ":2:1: t_s: one row gives no sample time; at least two are expected"),
    "no time": ("t,u_N\n0,0.1\n", ":1:1: no column is named t_s, did you mean t?; there are t, u_N"),
    "no input": ("t_s,u\n0,0.1\n", ":1:1: no column is named u_N, did you mean u?; there are t_s, u"),
    "no header": ("0,0.1\n0.001,0.2\n", ":1:1: no header, so no column is named t_s; there are #1 to #2"),
    "column twice": ("t_s,u_N,x,u_N\n0,0.1,0,0.1\n", ":1:11: column u_N appears twice"),
    "text": ("t_s,u_N\n0,0.1\n0.001,abc\n", ":3:7: u_N: 'abc' is not a number"),
    "text in a number": ("t_s,u_N\n0,0.1\n0.001,0.2N\n", ":3:7: u_N: '0.2N' is not a number"),
    "text in a quoted number": ('t_s,u_N\n0,0.1\n0.001, "0.2 N"\n', ":3:8: u_N: '0.2 N' is not a number"),
    "nothing in a field": ("t_s,u_N\n0,0.1\n,0.2\n", ":3:1: t_s: '' is not a number"),
    "NaN": ("t_s,u_N\n0,0.1\n0.001,nan\n", ":3:7: u_N: 'nan' is not a finite number"),
    "minus infinity": ("t_s,u_N\n0,0.1\n0.001,-Inf\n", ":3:7: u_N: '-Inf' is not a finite number"),
    "overflow": ("t_s,u_N\n0,0.1\n0.001,1e400\n", ":3:7: u_N: '1e400' is too large for a number"),
    "hexadecimal": ("t_s,u_N\n0,0.1\n0.001,0x1p-3\n", ":3:7: u_N: '0x1p-3' is not a number"),
    "too few fields": ("t_s,x,u_N\n0,0,0.1\n0.001,0\n", ":3:7: 2 fields, the header has 3"),
    "too many fields": ("t_s,u_N\n0,0.1\n0.001,0.2,7\n", ":3:11: more fields than the header's 2"),
    "open quote": ('t_s,u_N\n0,0.1\n0.001,"0.2\n0.002,0.3"\n', ":3:7: a quote is opened and not closed in its line, and 1 more rows of 3 are broken"),
    "text after a quote": ('t_s,u_N\n0,0.1\n"0.001"5,0.2\n', ":3:8: text after a quoted field"),
    "zero byte": (b"t_s,u_N\n0,0.1\n0.001\0,0.2\n", ":3: a zero byte: this is not a text file"),
    "time stands still": ("t_s,u_N\n0,0.1\n0.001,0.2\n0.001,0.3\n", ":4:1: t_s: 0.001 does not come after 0.001; 1 stamps appear twice, 0 go back (--resample repairs this)"),
    "time goes back": ("u_N,t_s\n0.1,0\n0.2,0.001\n0.3,0\n", ":4:5: t_s: 0 does not come after 0.001; 0 stamps appear twice, 1 go back (--resample repairs this)"),
    "gap": (
        "t_s,u_N\n0,0\n0.001,0\n0.002,0\n0.004,0\n0.005,0\n",
        ":5:1: t_s: 0.002 s after the row before, where the log's interval is 0.001 s (--resample repairs this)",
    ),
    "large gap at the start": (
        "t_s,u_N\n0,0\n100,0\n100.001,0\n100.002,0\n",
        ":3:1: t_s: 100 s after the row before, where the log's interval is 0.001 s (--resample repairs this)",
    ),
    "too much jitter": (
        "t_s,u_N\n0,0\n0.001,0\n0.002,0\n0.00298,0\n0.004,0\n0.005,0\n",
        ":5:1: t_s: 0.00098 s after the row before, where the log's interval is 0.001 s (--resample repairs this)",
    ),
    "sample time too long": (
        "t_s,u_N\n0,0\n1,0\n2,0\n",
        ": its sample time is 1 s; sample_time_s: 1e-6 to 0.1 s",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_in_a_log_is_named_with_line_and_column(sim, mistake):
    content, message = MISTAKES[mistake]
    sim.write("log.csv", content)
    sim.fails("log.csv" + message, "replay", "log.csv", "--out", "out.csv")
    assert not (sim.folder / "out.csv").exists()


@pytest.mark.parametrize("last, good", [("0.0029901", True), ("0.0029899", False)])
def test_jitter_of_one_percent_is_the_limit(sim, last, good):
    sim.write("log.csv", f"t_s,u_N\n0,0\n0.001,0\n0.002,0\n{last},0\n")
    assert (sim("replay", "log.csv").returncode == 0) == good


def test_measured_force_wants_its_column(sim):
    sim.write("log.csv", GOOD)
    sim.fails("--force measured: log.csv:1:1: no column is named F_N; there are t_s, u_N", "replay", "log.csv", "--force", "measured")
    sim.fails("--plot x.svg: log.csv:1:1: no column is named F_N; there are t_s, u_N", "replay", "log.csv", "--plot", "x.svg")


def test_a_broken_force_is_an_error_even_if_it_is_not_used(sim):
    sim.write("log.csv", "t_s,u_N,F_N\n0,0,0\n0.001,0,x\n")
    sim.fails("log.csv:3:9: F_N: 'x' is not a number", "replay", "log.csv")


def test_a_missing_log(sim):
    sim.fails("no.csv: cannot be opened: No such file or directory", "replay", "no.csv")


PARAM_MISTAKES = {
    "missing": (None, ": cannot be opened: No such file or directory"),
    "empty": ("", ":1: the file is empty"),
    "a scenario": ("compensator: {gain: 1}\n", ":1: compensator is a key of a whole scenario:"
                   " a file with only the keys of its compensator is expected here"),
    "unknown key": (
        "friction:\n  k_mim: 1\n",
        ":2: unknown key compensator.friction.k_mim, did you mean compensator.friction.k_min?",
    ),
    "text": ("friction:\n  k_min: x\n", ":2: compensator.friction.k_min: 'x' is not a number"),
    "range": ("friction:\n  k_min: 1\n", ":2: compensator.friction.k_min: 1 is outside 1.01 to 1000"),
    "together": ("friction:\n  k_min: 30\n", ":2: compensator.friction.k_min: is larger than k_max"),
    "the log's sample time": (
        "friction:\n  pulse_width_s: 0.1\n",
        ":2: compensator.friction.pulse_width_s: 0.1 s is refused: friction pulse_width_s: 1e-6 to 6.3 s; 1 to 63 sample times",
    ),
}


@pytest.mark.parametrize("mistake", PARAM_MISTAKES)
def test_a_mistake_in_the_params_is_named(sim, mistake):
    content, message = PARAM_MISTAKES[mistake]
    sim.write("log.csv", GOOD)
    if content is not None:
        sim.write("p.yaml", content)
    sim.fails("p.yaml" + message, "replay", "log.csv", "--params", "p.yaml")


def test_forces_too_large_for_the_compensator_are_reported(sim):
    sim.write("log.csv", GOOD + "0.003,1e7\n")
    result = sim("replay", "log.csv")
    assert result.returncode == 0
    assert result.stderr == "tribo-sim: log.csv: warning: 1 rows hold forces too large for the compensator\n"
    assert len(result.stdout.splitlines()) == 5


def test_results_replace_a_file_whole(sim):
    sim.write("log.csv", GOOD)
    sim.write("out.csv", "old")
    sim.ok("replay", "log.csv", "--out", "out.csv")
    assert (sim.folder / "out.csv").read_text(encoding="ascii") == sim.ok("replay", "log.csv")
    assert sorted(os.listdir(sim.folder)) == ["log.csv", "out.csv"]


def test_a_link_stays_and_what_it_points_to_is_replaced(sim):
    sim.write("log.csv", GOOD)
    (sim.folder / "d").mkdir()
    sim.write("d/real.csv", "old")
    (sim.folder / "out.csv").symlink_to("d/real.csv")
    sim.ok("replay", "log.csv", "--out", "out.csv")
    assert os.readlink(sim.folder / "out.csv") == "d/real.csv"
    assert (sim.folder / "d/real.csv").read_text(encoding="ascii") == sim.ok("replay", "log.csv")
    assert os.listdir(sim.folder / "d") == ["real.csv"]


@pytest.mark.parametrize("out", ["pipe", "link"])
def test_a_pipe_is_written_to_and_stays(sim, out):
    sim.write("log.csv", GOOD)
    os.mkfifo(sim.folder / "pipe")
    (sim.folder / "link").symlink_to("pipe")
    with subprocess.Popen(["cat", sim.folder / "pipe"], stdout=subprocess.PIPE, text=True) as reader:
        try:
            sim.ok("replay", "log.csv", "--out", out)
            assert reader.communicate(timeout=200)[0] == sim.ok("replay", "log.csv")
        finally:
            reader.kill()
    assert stat.S_ISFIFO(os.lstat(sim.folder / "pipe").st_mode) and (sim.folder / "link").is_symlink()
    assert sorted(os.listdir(sim.folder)) == ["link", "log.csv", "pipe"]


def test_a_device_is_written_to_and_stays(sim):
    sim.write("log.csv", GOOD)
    try:  # a null device of our own, which takes root to make and a file system that allows it to open
        os.mknod(sim.folder / "null", stat.S_IFCHR | 0o600, os.makedev(1, 3))
        (sim.folder / "null").write_bytes(b"")
    except OSError as error:
        pytest.skip(f"no device can be made here: {error}")
    sim.ok("replay", "log.csv", "--out", "null")
    assert stat.S_ISCHR(os.lstat(sim.folder / "null").st_mode)
    assert sorted(os.listdir(sim.folder)) == ["log.csv", "null"]


@pytest.mark.parametrize("name, what", [("log.csv", "the log log.csv"), ("p.yaml", "--params p.yaml")])
@pytest.mark.parametrize("linked", [False, True])
def test_a_result_over_what_it_is_made_from_is_refused(sim, name, what, linked):
    sim.write("log.csv", GOOD)
    sim.write("p.yaml", "{}\n")
    out = name
    if linked:
        out = "link"
        (sim.folder / out).symlink_to(name)
    before = {path.name: path.read_bytes() for path in sim.folder.iterdir()}
    sim.fails(f"replay: --out {out} is the same file as {what} (tribo-sim --help lists the commands)",
              "replay", "log.csv", "--params", "p.yaml", "--out", out, status=2)
    assert {path.name: path.read_bytes() for path in sim.folder.iterdir()} == before


@pytest.mark.parametrize("out", ["no/out.csv", "."])
def test_a_result_that_cannot_be_written(sim, out):
    sim.write("log.csv", GOOD)
    result = sim("replay", "log.csv", "--out", out)
    assert result.returncode == 1
    assert result.stderr.startswith(f"tribo-sim: {out}: cannot be written: ")
    assert pathlib.Path(sim.folder / "log.csv").exists() and len(os.listdir(sim.folder)) == 1


def test_a_full_standard_output_is_an_error(sim):
    sim.write("log.csv", GOOD)
    with open("/dev/full", "w", encoding="ascii") as full:
        sim.fails("standard output: cannot be written: No space left on device", "replay", "log.csv", stdout=full)


@pytest.mark.parametrize("params", ["paper", "asymmetric_gravity"])
def test_q31_reproduces_the_golden_vectors(sim, params):
    sim.write("p.yaml", PARAMS[params])
    golden = log_of(sim, f"compensator_{params}", ["u_N"])
    sim.ok("replay", "log.csv", "--params", "p.yaml", "--arith", "q31", "--out", "out.csv")
    compare(golden, read_csv(sim.folder / "out.csv"), [("F_hat_N", "F_hat_N"), ("f_N", "f_hat_N")], 2e-6)
    golden = log_of(sim, f"friction_{params}", ["F_N", "u_N"])
    sim.ok("replay", "log.csv", "--params", "p.yaml", "--arith", "q31", "--force", "measured", "--out", "out.csv")
    compare(golden, read_csv(sim.folder / "out.csv"), [("n_N", "n_N"), ("f_N", "f_hat_N")], 5e-7)


def test_both_has_the_columns_of_each_and_says_how_they_differ(sim):
    log_of(sim, "compensator_paper", ["u_N"])
    results = {}
    for arith in ("f32", "q31"):
        sim.ok("replay", "log.csv", "--arith", arith, "--out", "out.csv")
        results[arith] = read_csv(sim.folder / "out.csv")
        assert ",".join(results[arith]) == HEADER
    told = sim("replay", "log.csv", "--arith", "both", "--out", "out.csv")
    assert told.returncode == 0
    both = read_csv(sim.folder / "out.csv")
    assert len(both) == 18
    largest = []
    for name in ("F_hat_N", "f_hat_N", "n_N", "L_N", "Q"):
        other = name.replace("_N", "_q31_N") if "_N" in name else name + "_q31"
        assert both[name] == results["f32"][name] and both[other] == results["q31"][name]
        largest.append(max(abs(a - b) for a, b in zip(both[name], both[other])))
    shown = [float(word) for word in told.stderr.split() if word[0].isdigit()]
    assert shown == pytest.approx(largest[:2], rel=6e-3)
    assert 0 < largest[0] < 2e-6


def test_full_scale_of_a_replay(sim):
    sim.write("log.csv", "t_s,u_N\n0,0.1\n0.001,-1.5\n0.002,0.2\n")
    sim.ok("replay", "log.csv", "--arith", "q31")
    result = sim("replay", "log.csv", "--arith", "q31", "--full-scale", "1")
    assert result.returncode == 0
    assert result.stderr == "tribo-sim: log.csv: warning: 1 rows hold forces beyond full scale\n"
    assert sim("replay", "log.csv", "--arith", "q31", "--full-scale", "0").stderr.startswith("tribo-sim: --full-scale 0: ")
    assert sim("replay", "log.csv", "--full-scale", "x").returncode == 2
    assert sim("replay", "log.csv", "--arith", "x").returncode == 2


@numbers
def test_the_activity_is_that_of_the_log(sim):
    """Replay counts what the run that made the log counted; a gap is no move."""
    summary = sim.summary("triangle", *PAPER, "--set", "reference.period_s=60", "--set", "metrics.start_s=0", "--out", "d")
    assert summary["chatter_ticks"] > 1000
    for options, counted in ((("--arith", "f32"), r"Q switches (\d+) times"),
                             (("--arith", "q31"), r"Q switches (\d+) times in Q31"),
                             (("--arith", "both"), r"Q switches (\d+) times, (\d+) times in Q31")):
        line = sim("replay", "d/trace.csv", "--out", "r.csv", *options).stdout.splitlines()[-1]
        found = re.fullmatch(r"activity  u varies (\S+) N, chatter in (\d+) of 60000 ticks; " + counted, line)
        assert found, line
        assert float(found[1]) == pytest.approx(summary["u_variation_N"], rel=1e-3)
        assert int(found[2]) == pytest.approx(summary["chatter_ticks"], abs=2)
        assert all(int(switches) == pytest.approx(summary["Q_switches"], rel=0.01) for switches in found.groups()[2:])
    sim.write("a.csv", "t_s,u_N\n" + "".join(f"{i / 1000},0.1\n" for i in range(50)))
    sim.write("b.csv", "t_s,u_N\n" + "".join(f"{i / 1000},0.3\n" for i in range(50)))
    line = sim("replay", "a.csv", "b.csv", "--out", "r.csv").stdout.splitlines()[-1]
    assert line == "activity  u varies 0 N, chatter in 0 of 100 ticks; Q switches 0 times"
