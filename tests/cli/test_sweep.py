"""`sweep` and `merge`: the same rows whoever plays them, whatever ends them, and rows that anyone can replay."""

import csv
import json
import math
import os
import pathlib
import pty
import re
import shlex
import shutil
import signal
import statistics
import subprocess

import pytest

from conftest import ROOT, processor_s, until
from test_hostile_input import NO_LDEXP, preload

MEASURES = ("rms_error_N max_error_N rms_measured_error_N u_variation_N variation_ratio chatter_ticks Q_switches window_ticks "
            "limited_ticks bad_inputs").split()
PROBABILITIES = [0, 0.05, 0.25, 0.5, 0.75, 0.95, 1]

BASE = "duration_s: 1\nreference: {kind: triangle, low_N: 0.4, high_N: 0.6, period_s: 1}\n"

# Every kind of axis; 6 samples of a grid of 2 x 2.
STUDY = """\
scenario: base.yaml
seed: 7
runs: 6
without: {compensator.gain: 0}
grid:
  compensator.gain: [0.5, 0.85]
  plant.model: [paper, lugre]
sample:
  breakaway:
    keys: [plant.friction.breakaway.offset_N, plant.friction.breakaway.slope]
    relative: true
    uniform: [0.5, 1.5]
  sensor.noise_N: {log_uniform: [1e-5, 1e-3]}
  sensor.noise_seed: {uniform: [1, 1000000]}
  sensor.delay_s: [0, 0.001, 0.003]
  plant.actuator_pole_rad_per_s: {normal: [200, 40], within: [150, 300]}
  waveform:
    cases:
      slow: {reference.period_s: 2}
      "fast, and wide": {reference.period_s: 0.5, reference.low_N: 0.2}
"""


@pytest.fixture
def study(sim):
    sim.write("base.yaml", BASE)
    return sim.write("study.yaml", STUDY)


def rows_of(sim, folder="o"):
    with open(sim.folder / folder / "rows.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def sweep(sim, text, *options, folder="o", base=BASE):
    """The rows of a study that must succeed."""
    sim.write("base.yaml", base)
    sim.write("study.yaml", text)
    sim.ok("sweep", "study.yaml", "--out", folder, *options)
    return rows_of(sim, folder)


def column(rows, name):
    return [float(row[name]) for row in rows]


# Rows


def test_the_columns_are_the_axes_and_the_measures_of_both_runs(sim, study):
    rows = sweep(sim, STUDY)
    axes = ["compensator.gain", "plant.model", "breakaway", "sensor.noise_N", "sensor.noise_seed", "sensor.delay_s",
            "plant.actuator_pole_rad_per_s", "waveform"]
    assert list(rows[0]) == ["study", "row", *axes, *MEASURES, *("without_" + name for name in MEASURES), "ratio", "status",
                             "message"]
    assert [row["row"] for row in rows] == [str(i) for i in range(24)]
    assert {row["status"] for row in rows} == {"ok"}
    assert len({row["study"] for row in rows}) == 1
    for row in rows:
        assert float(row["ratio"]) == pytest.approx(float(row["without_rms_error_N"]) / float(row["rms_error_N"]), rel=1e-8)
    # The grid runs through all combinations for each sample, its last axis fastest.
    assert [(row["compensator.gain"], row["plant.model"]) for row in rows[:5]] == [
        ("0.5", "paper"), ("0.5", "lugre"), ("0.85", "paper"), ("0.85", "lugre"), ("0.5", "paper")]
    samples = [tuple(row[axis] for axis in axes[2:]) for row in rows]
    assert all(samples[i] == samples[i // 4 * 4] for i in range(24)) and len(set(samples)) == 6


@pytest.mark.parametrize("without", [0, 1])
def test_every_row_is_what_its_command_gives(sim, study, without):
    rows = sweep(sim, STUDY)
    for i in (0, 3, 10, 23):
        command = shlex.split(sim.ok("sweep", "study.yaml", "--row", i).splitlines()[without])
        assert command[:3] == ["tribo-sim", "run", "base.yaml"]
        summary = sim.summary(*command[2:])
        for name in MEASURES:
            if name != "window_ticks":
                assert float(rows[i][("without_" if without else "") + name]) == pytest.approx(summary[name], rel=1e-8), name


def test_arithmetic_is_of_the_whole_study(sim):
    text = "scenario: base.yaml\narithmetic: {}\ngrid: {{compensator.gain: [0.85]}}\n"
    f32 = sweep(sim, text.format("f32"))
    q31 = sweep(sim, text.format("q31"), folder="q")
    assert float(q31[0]["rms_error_N"]) == pytest.approx(sim.summary("base.yaml", "--arith", "q31")["rms_error_N"],
                                                             rel=1e-8)
    assert float(q31[0]["rms_error_N"]) == pytest.approx(float(f32[0]["rms_error_N"]), rel=0.01)
    assert f32[0]["rms_error_N"] != q31[0]["rms_error_N"]
    assert "--arith q31" in sim.ok("sweep", "study.yaml", "--row", 0)


def test_a_study_without_axes_is_one_row(sim):
    row, = sweep(sim, "scenario: base.yaml\n")
    assert list(row) == ["study", "row", *MEASURES, "status", "message"]
    assert float(row["rms_error_N"]) == pytest.approx(sim.summary("base.yaml")["rms_error_N"], rel=1e-8)


def test_a_scenario_beside_the_study_goes_before_one_of_the_folder(sim):
    (sim.folder / "d").mkdir()
    sim.write("d/triangle", BASE)
    sim.write("d/study.yaml", "scenario: triangle\n")
    assert shlex.split(sim.ok("sweep", "d/study.yaml", "--row", 0))[2] == "d/triangle"
    sim.write("study.yaml", "scenario: triangle\n")
    assert shlex.split(sim.ok("sweep", "study.yaml", "--row", 0))[2].endswith("host_sim/scenarios/triangle.yaml")


def test_values_reach_the_shell_and_the_scenario_as_they_are(sim):
    name = "it's a \"file\" $HOME.csv"
    sim.write(name, "t_s,r_N\n0,0.4\n1,0.6\n")
    rows = sweep(sim, "scenario: base.yaml\nset: {reference.kind: csv}\ngrid:\n  reference.file: ['it''s a \"file\" $HOME.csv']\n")
    assert rows[0]["reference.file"] == name
    command = sim.ok("sweep", "study.yaml", "--row", 0).replace("tribo-sim", sim.program, 1)
    output = subprocess.run(["sh", "-c", command.strip() + " --json"], cwd=sim.folder, capture_output=True, text=True, check=True)
    assert json.loads(output.stdout)["rms_error_N"] == pytest.approx(float(rows[0]["rms_error_N"]), rel=1e-8)


# Where the samples are

SHORT_RUN = "scenario: base.yaml\nset: {duration_s: 0.001}\n"


def test_latin_hypercube_has_one_sample_in_each_part(sim):
    rows = sweep(sim, SHORT_RUN + "runs: 40\nsample:\n  sensor.noise_N: {uniform: [0, 0.004]}\n"
                 "  plant.actuator_pole_rad_per_s: {log_uniform: [50, 800]}\n"
                 "  sensor.pole_rad_per_s: {normal: [55, 5]}\n  sensor.delay_s: [0, 0.001, 0.002, 0.003]\n")
    normal = statistics.NormalDist(55, 5)
    parts = {"sensor.noise_N": lambda x: x / 0.004, "plant.actuator_pole_rad_per_s": lambda x: math.log(x / 50) / math.log(16),
             "sensor.pole_rad_per_s": normal.cdf}
    orders = []
    for name, part in parts.items():
        found = [int(part(x) * 40) for x in column(rows, name)]
        assert sorted(found) == list(range(40)), name
        orders.append(found)
    assert orders[0] != orders[1] != orders[2] != orders[0] and orders[0] != sorted(orders[0])
    assert [column(rows, "sensor.delay_s").count(x) for x in (0, 0.001, 0.002, 0.003)] == [10] * 4


def test_monte_carlo_is_independent_and_even(sim):
    rows = sweep(sim, SHORT_RUN + "method: monte_carlo\nruns: 2000\nsample:\n  sensor.noise_N: {uniform: [0, 1]}\n"
                 "  sensor.quantisation_N: {uniform: [0, 1]}\n  sensor.pole_rad_per_s: {normal: [55, 5], within: [50, 65]}\n"
                 "  sensor.noise_seed: {uniform: [3, 5]}\n")
    x, y = column(rows, "sensor.noise_N"), column(rows, "sensor.quantisation_N")
    counts = [sum(i / 10 <= value < (i + 1) / 10 for value in x) for i in range(10)]
    assert sum((count - 200) ** 2 / 200 for count in counts) < 27.9  # chi squared, 9 degrees of freedom, 0.1 %
    assert len({int(value * 2000) for value in x}) < 1500  # not stratified
    assert abs(statistics.correlation(x, y)) < 0.08
    poles = column(rows, "sensor.pole_rad_per_s")
    assert 50 <= min(poles) < 50.1 and 64.5 < max(poles) <= 65
    # Of a normal distribution between -1 and 2 standard deviations.
    n = statistics.NormalDist()
    mean = (n.pdf(-1) - n.pdf(2)) / (n.cdf(2) - n.cdf(-1))
    assert statistics.fmean(poles) == pytest.approx(55 + 5 * mean, abs=0.3)
    seeds = [row["sensor.noise_seed"] for row in rows]
    assert set(seeds) == {"3", "4", "5"} and all(600 < seeds.count(seed) < 733 for seed in set(seeds))


def test_the_seed_moves_all_axes_and_another_axis_none(sim):
    def noise(folder, seed, more=""):
        return column(sweep(sim, SHORT_RUN + f"seed: {seed}\nruns: 10\nsample:\n  sensor.noise_N: {{uniform: [0, 1]}}\n{more}",
                            folder=folder), "sensor.noise_N")

    one = noise("a", 1)
    assert noise("b", 1, "  sensor.quantisation_N: {uniform: [0, 1]}\n") == one
    assert noise("c", 2) != one


def test_distributions_in_a_grid_are_points(sim):
    rows = sweep(sim, SHORT_RUN + "grid:\n  sensor.noise_N: {uniform: [0, 1], points: 3}\n"
                 "  plant.actuator_pole_rad_per_s: {log_uniform: [100, 400], points: 3}\n"
                 "  sensor.pole_rad_per_s: {normal: [55, 5], points: 2}\n")
    assert column(rows, "sensor.noise_N") == [0] * 6 + [0.5] * 6 + [1] * 6
    assert column(rows[:6], "plant.actuator_pole_rad_per_s") == [100, 100, 200, 200, 400, 400]
    n = statistics.NormalDist(55, 5)
    assert column(rows[:2], "sensor.pole_rad_per_s") == pytest.approx([n.inv_cdf(0.25), n.inv_cdf(0.75)], rel=1e-5)


def test_relative_values_are_times_the_scenarios_own(sim):
    sweep(sim, SHORT_RUN.replace("0.001}", "0.001, plant.arm.stiffness_N_per_deg: 4}")
          + "grid:\n  plant.arm.stiffness_N_per_deg: {values: [0.5, 2], relative: true}\n"
          "  both: {keys: [plant.friction.breakaway.slope, compensator.friction.breakaway.slope], relative: true, values: [1.5]}\n")
    commands = [sim.ok("sweep", "study.yaml", "--row", i) for i in (0, 1)]
    assert [re.search("stiffness_N_per_deg=(\\S*)", command)[1] for command in commands] == ["2", "8"]
    assert "plant.friction.breakaway.slope=0.45 " in commands[0] and "compensator.friction.breakaway.slope=0.45\n" in commands[0]


# The same bytes


def test_workers_do_not_show(sim, study):
    results = []
    for workers in (1, 2, 5, 24):
        sim.ok("sweep", "study.yaml", "--out", f"o{workers}", "--workers", workers)
        results.append([(sim.folder / f"o{workers}" / name).read_bytes() for name in ("rows.csv", "summary.json")])
    assert all(result == results[0] for result in results)
    sim.ok("sweep", "study.yaml", "--out", "default")
    assert (sim.folder / "default/rows.csv").read_bytes() == results[0][0]


@pytest.mark.parametrize("shards", [2, 5, 30])
def test_shards_merge_to_what_one_sweep_writes(sim, study, shards):
    sim.ok("sweep", "study.yaml", "--out", "whole")
    for i in range(1, shards + 1):
        sim.ok("sweep", "study.yaml", "--out", "parts", "--shard", f"{i}/{shards}")
    printed = sim.ok("merge", "study.yaml", "--out", "parts")
    for name in ("rows.csv", "summary.json"):
        assert (sim.folder / "parts" / name).read_bytes() == (sim.folder / "whole" / name).read_bytes()
    assert "worse than without" in printed


@pytest.mark.skipif(shutil.which("parallel") is None, reason="needs GNU parallel")
def test_gnu_parallel_runs_the_shards(sim, study):
    """As docs/sweep.md has it."""
    sim.ok("sweep", "study.yaml", "--out", "whole")
    subprocess.run(["parallel", "--will-cite", "--halt", "now,fail=1", "-j2", sim.program,
                    "sweep study.yaml --out parts --workers 1 --shard {}/4", ":::", "1", "2", "3", "4"],
                   cwd=sim.folder, check=True, timeout=1000, stdout=subprocess.DEVNULL)
    sim.ok("merge", "study.yaml", "--out", "parts")
    assert (sim.folder / "parts/rows.csv").read_bytes() == (sim.folder / "whole/rows.csv").read_bytes()


def test_merge_refuses_what_is_not_whole(sim, study):
    sim.fails("parts: cannot be read: No such file or directory", "merge", "study.yaml", "--out", "parts")
    (sim.folder / "parts").mkdir()
    sim.fails("parts: holds no rows-I-of-N.csv", "merge", "study.yaml", "--out", "parts")
    sim.ok("sweep", "study.yaml", "--out", "parts", "--shard", "1/2")
    sim.fails("parts/rows-2-of-2.csv: cannot be opened: No such file or directory", "merge", "study.yaml", "--out", "parts")
    sim.ok("sweep", "study.yaml", "--out", "parts", "--shard", "2/2")
    part = sim.folder / "parts/rows-2-of-2.csv"
    text = part.read_bytes()
    part.write_bytes(b"".join(text.splitlines(keepends=True)[:-1]))
    sim.fails("parts/rows-2-of-2.csv: has 11 rows of 12: not finished", "merge", "study.yaml", "--out", "parts")
    assert sorted(path.name for path in (sim.folder / "parts").iterdir()) == ["rows-1-of-2.csv", "rows-2-of-2.csv"]
    part.write_bytes(text)
    sim.ok("sweep", "study.yaml", "--out", "parts", "--shard", "1/3")
    sim.fails("parts: holds parts of 2 and of 3: remove those of an earlier sweep", "merge", "study.yaml", "--out", "parts")


# Ended and taken up again


def test_a_killed_sweep_is_taken_up_in_the_middle_of_a_row(sim, study):
    sim.ok("sweep", "study.yaml", "--out", "o")
    path = sim.folder / "o/rows.csv"
    whole = path.read_bytes()
    ends = [i for i, byte in enumerate(whole) if byte == 10]
    for cut in (0, 5, ends[0], ends[0] + 1, ends[0] + 30, ends[7], ends[7] + 1, ends[7] + 12, len(whole) - 1, len(whole)):
        path.write_bytes(whole[:cut])
        printed = sim.ok("sweep", "study.yaml", "--out", "o")
        assert path.read_bytes() == whole, cut
        done = max(0, whole[:cut].count(b"\n") - 1)
        assert printed.startswith(f"24 rows, {24 - done} of them played now")


def test_sigkill_at_any_moment_changes_nothing(sim, study):
    """The program and its workers are killed again and again, until it gets through."""
    text = STUDY.replace("seed: 7", "seed: 8\nset: {plant.step_s: 1e-5}")
    sim.write("study.yaml", text)
    sim.ok("sweep", "study.yaml", "--out", "whole")
    sizes = set()
    for kills in range(200):
        process = subprocess.Popen([sim.program, "sweep", "study.yaml", "--out", "o", "--workers", "2"], cwd=sim.folder,
                                   stdout=subprocess.DEVNULL, start_new_session=True)
        try:
            process.wait(0.05 * 1.05**kills)
            break
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL) if kills % 2 else process.kill()
            process.wait()
        sizes.add((sim.folder / "o/rows.csv").stat().st_size if (sim.folder / "o/rows.csv").exists() else 0)
        if (sim.folder / "o/summary.json").exists():  # killed after its last act, as a sanitizer's exit takes long
            break
    else:
        raise AssertionError("never got through")
    assert process.returncode in (0, -signal.SIGKILL)
    assert len(sizes) > 1, "never killed between rows"
    for name in ("rows.csv", "summary.json"):
        assert (sim.folder / "o" / name).read_bytes() == (sim.folder / "whole" / name).read_bytes()


def test_orphaned_workers_end(sim, study):
    sim.write("study.yaml", STUDY.replace("seed: 7", "set: {duration_s: 3}\nseed: 7").replace("runs: 6", "runs: 1000"))
    process = subprocess.Popen([sim.program, "sweep", "study.yaml", "--out", "o", "--workers", "3"], cwd=sim.folder)
    until(lambda: len(children(process.pid)) == 3, "never three workers")
    workers = children(process.pid)
    process.kill()
    process.wait()
    until(lambda: not any(is_running(worker) for worker in workers), "workers go on")


@pytest.mark.parametrize("change", [("study.yaml", STUDY.replace("seed: 7", "seed: 8")), ("base.yaml", BASE + "limits: {u_max_N: 1}\n")])
def test_rows_of_another_study_are_not_taken_up(sim, study, change):
    sim.ok("sweep", "study.yaml", "--out", "o")
    before = (sim.folder / "o/rows.csv").read_bytes()
    sim.write(*change)
    sim.fails("o/rows.csv:2:1: is not of this study as it is now: remove the file, or give another folder", "sweep", "study.yaml",
              "--out", "o")
    assert (sim.folder / "o/rows.csv").read_bytes() == before


def test_a_changed_reference_is_another_study(sim):
    sim.write("r.csv", "t_s,r_N\n0,0.4\n1,0.6\n")
    base = "duration_s: 1\nreference: {kind: csv, file: r.csv}\n"
    sweep(sim, "scenario: base.yaml\n", base=base)
    sim.write("r.csv", "t_s,r_N\n0,0.4\n1,0.5\n")
    assert sim("sweep", "study.yaml", "--out", "o").returncode == 1


def test_a_damaged_row_is_named(sim, study):
    sim.ok("sweep", "study.yaml", "--out", "o")
    path = sim.folder / "o/rows.csv"
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:5] + lines[6:]))
    sim.fails("o/rows.csv:6:1: is not of this study as it is now: remove the file, or give another folder", "sweep", "study.yaml",
              "--out", "o")
    path.write_text("\n")
    sim.fails("o/rows.csv:1:1: is not of this study as it is now: remove the file, or give another folder", "sweep", "study.yaml",
              "--out", "o")


def children(process):
    listed = pathlib.Path(f"/proc/{process}/task/{process}/children").read_text(encoding="ascii")
    return [int(word) for word in listed.split()]


def is_running(process):
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


LONG = "scenario: base.yaml\nset: {duration_s: 600}\ngrid: {compensator.gain: [0.1, 0.2, 0.3]}\n"


def test_two_sweeps_do_not_write_one_file(sim):
    sim.write("base.yaml", BASE)
    sim.write("study.yaml", LONG.replace("[0.1, 0.2, 0.3]", str([k / 1000 for k in range(1000)])))
    first = subprocess.Popen([sim.program, "sweep", "study.yaml", "--out", "o"], cwd=sim.folder, stdout=subprocess.DEVNULL)
    try:
        rows = sim.folder / "o/rows.csv"
        until(lambda: rows.exists() and rows.stat().st_size > 0, "no rows")
        sim.fails("o/rows.csv: another tribo-sim is writing it", "sweep", "study.yaml", "--out", "o")
    finally:
        first.kill()
        first.wait()


# Rows that fail


def test_a_worker_that_crashes_costs_its_row_alone(sim):
    sim.write("base.yaml", BASE)
    sim.write("study.yaml", LONG)
    process = subprocess.Popen([sim.program, "sweep", "study.yaml", "--out", "o", "--workers", "1"], cwd=sim.folder, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    until(lambda: children(process.pid) and processor_s(children(process.pid)[0]) > 0, "no worker that works")
    os.kill(children(process.pid)[0], signal.SIGKILL)  # a sanitizer would make an exit of any other
    output, errors = process.communicate(timeout=1000)
    rows = rows_of(sim)
    assert [row["status"] for row in rows] == ["crashed", "ok", "ok"]
    assert rows[0]["message"] == "the program was ended by signal 9" and rows[0]["rms_error_N"] == ""
    assert process.returncode == 1
    assert errors == "tribo-sim: 1 of 3 rows failed, the first: row 0: crashed: the program was ended by signal 9\n"
    summary = json.loads((sim.folder / "o/summary.json").read_text())
    assert summary["failed"] == 1 and summary["failures"] == ["row 0: crashed: the program was ended by signal 9"]
    assert "rms_error_N" in output


def test_a_run_that_takes_too_long_is_ended(sim):
    sim.write("base.yaml", BASE)
    sim.write("study.yaml", "scenario: base.yaml\ntimeout_s: 0.1\ngrid: {duration_s: [1, 80000, 1]}\n")
    result = sim("sweep", "study.yaml", "--out", "o", "--workers", "2")
    assert result.stderr == "tribo-sim: 1 of 3 rows failed, the first: row 1: timeout: took more than 0.1 s of CPU time\n"
    assert [row["status"] for row in rows_of(sim)] == ["ok", "timeout", "ok"]


def test_a_run_that_is_refused_is_a_row(sim):
    sim.write("base.yaml", BASE)
    sim.write("study.yaml", "scenario: base.yaml\nwithout: {compensator.gain: 0}\ngrid:\n  which:\n    cases:\n"
              "      fine: {compensator.gain: 0.5}\n"
              "      refused: {compensator.friction.k_min: 30}\n"
              "      also: {plant.step_s: 0.0003}\n")
    result = sim("sweep", "study.yaml", "--out", "o")
    rows = rows_of(sim)
    assert result.returncode == 1
    assert [row["status"] for row in rows] == ["ok", "refused", "refused"]
    assert rows[1]["message"].startswith("--set compensator.friction.k_min=30: compensator.friction.k_m")
    assert all(row[name] == "" for row in rows[1:] for name in (*MEASURES, "ratio"))
    assert result.stderr.startswith("tribo-sim: 2 of 3 rows failed, the first: row 1: refused: --set ")
    summary = json.loads((sim.folder / "o/summary.json").read_text())
    assert summary["failed"] == 2 and len(summary["failures"]) == 2
    assert summary["quantiles"]["ratio"] == pytest.approx([float(rows[0]["ratio"])] * 7)


def test_a_plant_that_diverges_is_a_row(sim):
    sim.write("base.yaml", BASE)
    sim.write("study.yaml", "scenario: base.yaml\nwithout: {compensator.gain: 0}\n")
    assert sim("sweep", "study.yaml", "--out", "o", env=preload(sim, NO_LDEXP)).returncode == 1
    row, = rows_of(sim)
    assert row["status"] == "failed" and row["message"].startswith("the simulated plant diverges at t = ")


# Summary


def quantile(values, p):
    values = sorted(values)
    place = p * (len(values) - 1)
    below = int(place)
    above = min(below + 1, len(values) - 1)
    return values[below] + (place - below) * (values[above] - values[below])


def test_the_summary_is_that_of_the_rows(sim, study):
    printed = sim.ok("sweep", "study.yaml", "--out", "o")
    rows = rows_of(sim)
    summary = json.loads((sim.folder / "o/summary.json").read_text())
    assert list(summary) == ["study", "id", "rows", "failed", "worse_than_without", "failures", "axes", "relative", "quantiles", "worst"]
    assert summary["relative"] == ["breakaway"]
    assert (summary["study"], summary["id"], summary["rows"], summary["failed"]) == ("study.yaml", rows[0]["study"], 24, 0)
    assert summary["quantiles"]["probabilities"] == PROBABILITIES
    for name in [*MEASURES, *("without_" + name for name in MEASURES), "ratio"]:
        values = column(rows, name)
        assert summary["quantiles"][name] == pytest.approx([quantile(values, p) for p in PROBABILITIES], rel=1e-9), name
        line = next(line for line in printed.splitlines() if line.split()[0] == name)
        assert [float(word) for word in line.split()[1:]] == pytest.approx(summary["quantiles"][name], rel=1e-4)
    ratios = column(rows, "ratio")
    assert summary["worse_than_without"] == sum(ratio < 1 for ratio in ratios)
    for name, sign in (("ratio", 1), ("rms_error_N", -1), ("chatter_ticks", -1)):
        values = column(rows, name)
        worst = sorted(range(24), key=lambda i: sign * values[i])[:10]
        assert [one["row"] for one in summary["worst"][name]] == worst
        assert [one["value"] for one in summary["worst"][name]] == [values[i] for i in worst]
        for one in summary["worst"][name]:
            assert [one["command"], one["without"]] == sim.ok("sweep", "study.yaml", "--row", one["row"]).splitlines()


def test_progress_has_the_time_left(sim):
    sim.write("base.yaml", BASE)
    sim.write("study.yaml", "scenario: base.yaml\nruns: 30\nsample: {duration_s: {uniform: [1200, 1500]}}\n")
    parent, child = pty.openpty()
    process = subprocess.Popen([sim.program, "sweep", "study.yaml", "--out", "o"], cwd=sim.folder, stdout=subprocess.DEVNULL,
                               stderr=child)
    os.close(child)
    seen = b""
    try:
        while chunk := os.read(parent, 4096):
            seen += chunk
    except OSError:
        pass
    assert process.wait() == 0
    assert re.search(rb"\r *\d+ %, \d+ of 30 rows, \d+ s left", seen)


# The studies and the pictures that come with the project


@pytest.mark.parametrize("path", sorted((ROOT / "host_sim" / "studies").glob("*.yaml")), ids=lambda path: path.stem)
def test_the_projects_studies_can_be_played(sim, path):
    commands = sim.ok("sweep", path, "--row", 0).splitlines()
    assert len(commands) == 2
    sim.ok("run", *shlex.split(commands[0])[2:], "--set", "metrics.start_s=0", "--set", "duration_s=0.01")


def report(sim, folder):
    return subprocess.run(["/usr/bin/python3", "-B", "-m", "tribo_plot.sweep_report", folder], cwd=sim.folder, capture_output=True,
                          env={**os.environ, "PYTHONPATH": str(ROOT / "tools")}, text=True, check=False, timeout=1000)


DRAWS = pytest.mark.skipif(subprocess.run(["/usr/bin/python3", "-c", "import matplotlib"], capture_output=True, check=False).returncode,
                           reason="needs matplotlib, which tools/setup all installs")


@DRAWS
@pytest.mark.parametrize("paired", [True, False])
def test_the_report_has_a_table_and_a_panel_for_each_axis(sim, paired):
    rows = sweep(sim, STUDY if paired else STUDY.replace("without: {compensator.gain: 0}\n", ""))
    result = report(sim, "o")
    assert result.returncode == 0, result.stderr
    pictures = ["chatter.png", "ratio.png", "rms.png"] if paired else ["chatter.png", "rms.png"]
    assert sorted(path.name for path in (sim.folder / "o").glob("*.png")) == pictures
    assert all((sim.folder / "o" / name).read_bytes().startswith(b"\x89PNG") for name in pictures)
    text = (sim.folder / "o/report.md").read_text(encoding="utf-8")
    for axis in list(rows[0])[2:10]:
        assert f"| {axis} | rows | " in text
    line = next(line for line in text.splitlines() if line.startswith("| lugre | 12 | ")).split(" | ")
    lugre = [row for row in rows if row["plant.model"] == "lugre"]
    assert float(line[2]) == pytest.approx(1e3 * quantile(column(lugre, "rms_error_N"), 0.5), rel=0.01)
    if paired:
        assert float(line[7]) == pytest.approx(quantile(column(lugre, "ratio"), 0.5), rel=0.01)
        assert line[9] == f"{100 * sum(ratio < 1 for ratio in column(lugre, 'ratio')) / 12:.3g} %"
    assert sim.ok("sweep", "study.yaml", "--row", 3).splitlines()[0].count("--set") > 5
    worst = json.loads((sim.folder / "o/summary.json").read_text())["worst"]["rms_error_N"][0]
    assert f"    {worst['command']}\n" in text
    before = [(sim.folder / "o" / name).read_bytes() for name in (*pictures, "report.md")]
    report(sim, "o")
    assert [(sim.folder / "o" / name).read_bytes() for name in (*pictures, "report.md")] == before


@DRAWS
def test_the_report_wants_a_sweep_that_has_come_to_its_end(sim, study):
    assert "rows.csv: there is none" in report(sim, "nowhere").stderr
    sim.ok("sweep", "study.yaml", "--out", "o", "--shard", "1/1")
    (sim.folder / "o/summary.json").unlink()
    result = report(sim, "o")
    assert result.returncode == 1 and "summary.json: there is none" in result.stderr


# Errors


def test_complaints_name_file_line_column_value_and_range(sim):
    """The mark in each text is where the complaint must point."""
    sim.write("base.yaml", BASE)

    def complains(text, message, mark="^"):
        before, _, after = text.partition(mark)
        line, column = before.count("\n") + 1, len(before) - (before.rfind("\n") + 1) + 1
        sim.write("study.yaml", before + after)
        sim.fails(f"study.yaml:{line}:{column}: {message}", "sweep", "study.yaml", "--out", "o")
        assert not (sim.folder / "o").exists()

    start = "scenario: base.yaml\n"
    complains("^", "the file is empty")
    complains("[\n^", "not valid YAML: did not find expected node content")
    complains("^a\n", "a study: a mapping is expected here, not a single value")
    complains("^seed: 1\n", "scenario: is missing")
    complains("scenario: ^[a]\n", "scenario: a single value is expected here, not a list")
    complains(start + "^sead: 1\n", "unknown key sead, did you mean seed?")
    complains(start + "seed: 1\n^seed: 2\n", "seed is given twice, first in line 2")
    complains(start + "seed: ^-1\n", "seed: '-1' is not a whole number of 0 or more")
    complains(start + "arithmetic: ^q15\n", "arithmetic: 'q15' is not f32 or q31")
    complains(start + "timeout_s: ^0\n", "timeout_s: 0 is outside 0.01 to 1e+06")
    complains(start + "timeout_s: ^.nan\n", "timeout_s: '.nan' is not a finite number")
    complains(start + "^runs: 5\n", "runs goes with sample, which is missing")
    complains(start + "^sample: {sensor.noise_N: [1]}\n", "sample wants runs: how many")
    complains(start + "runs: ^0\nsample: {sensor.noise_N: [1]}\n", "runs: 0 is outside 1 to 1000000")
    complains(start + "runs: 1\nmethod: ^sobol\nsample: {sensor.noise_N: [1]}\n",
              "method: 'sobol' is not monte_carlo or latin_hypercube")
    complains(start + "set: {plant.modle: ^paper}\n", "unknown key plant.modle, did you mean plant.model?")
    complains(start + "set:\n  plant.model: ^lugra\n", "plant.model: 'lugra' is not paper, torque, coulomb, karnopp, "
              "armstrong, dahl, bristle, reset_integrator, bliman_sorine, lubricated, lugre, elasto_plastic, leuven, maxwell_slip, "
              "servo_mx106, servo_mx64, servo_xl330 or servo_erob80, did you mean lugre?")
    complains(start + "without: {compensator.gain: ^3}\n", "compensator.gain: 3 is outside 0 to 2")
    complains(start + "set: {sensor: ^{noise_N: 1}}\n", "sensor: a single value is expected here, not a mapping")
    complains(start + "set: {sensor: ^1}\n", "sensor: a mapping is expected here, not a single value")

    def gain(axis, message):
        complains(f"{start}grid:\n  compensator.gain: {axis}\n", message)

    gain("^3", "compensator.gain: a mapping is expected here, not a single value")
    gain("^[]", "compensator.gain: values, cases, uniform, log_uniform or normal is expected")
    gain("^{}", "compensator.gain: values, cases, uniform, log_uniform or normal is expected")
    gain("[0.1, ^2.5]", "compensator.gain: 2.5 is outside 0 to 2")
    gain("[0.1, ^x]", "compensator.gain: 'x' is not a number")
    gain("^{uniform: [0, 1]}", "compensator.gain: in a grid a distribution wants points: how many")
    gain("{uniform: [0, 1], points: ^1}", "points: 1 is outside 2 to 100000")
    gain("{values: [1], ^points: 2}", "compensator.gain: points are for a distribution in the grid")
    gain("{uniform: ^[1, 1], points: 2}", "uniform: 1 is not below 1")
    gain("{uniform: ^[1], points: 2}", "uniform: two numbers are expected here")
    gain("{uniform: [1, ^a], points: 2}", "uniform: 'a' is not a number")
    gain("{log_uniform: ^[0, 1], points: 2}", "log_uniform: 0 < from < to is expected, not 0, 1")
    gain("{normal: ^[0, 0], points: 2}", "normal: the standard deviation 0 is not above 0")
    gain("{normal: [0, 1], within: ^[1, 0], points: 2}", "within: 1 is not below 0")
    gain("{uniform: [0, 1], ^within: [0, 1], points: 2}", "compensator.gain: within goes with normal alone")
    gain("{uniform: [0, 1], ^normal: [0, 1]}", "compensator.gain: uniform and normal do not go together")
    gain("{^unifrom: [0, 1]}", "unknown key unifrom, did you mean uniform?")
    gain("{values: [1, ^a], relative: true}", "compensator.gain: 'a' is not a number")
    gain("{values: [2, ^3], relative: true}", "compensator.gain: 2.55 is outside 0 to 2")
    gain("{values: [2], relative: ^maybe}", "relative: 'maybe' is not false or true")
    gain("{cases: {a: {compensator.gain: ^3}}}", "compensator.gain: 3 is outside 0 to 2")
    gain("{^cases: {a: {compensator.gain: 1}}, relative: true}",
         "compensator.gain: cases have keys of their own: no keys, no relative")
    complains(start + "grid:\n  ^compensator.gain: {uniform: [0, 2.5], points: 2}\n", "compensator.gain: 2.5 is outside 0 to 2")
    complains(start + "grid:\n  any: [^1]\n", "unknown key any")
    complains(start + "grid:\n  any: {keys: ^[], values: [1]}\n", "keys: the list is empty")
    complains(start + "grid:\n  ^plant.model: {uniform: [0, 1], points: 2}\n", "plant.model is not a number: values are expected")
    complains(start + "grid:\n  ^metrics.end_s: {values: [1], relative: true}\n",
              "metrics.end_s: the scenario gives no value to be relative to")
    complains(start + "runs: 9\ngrid: {sensor.noise_N: [1]}\nsample: {^sensor.noise_N: [1]}\n",
              "sensor.noise_N is there twice, first in line 3")
    hundred = "{uniform: [0, 1], points: 100000}"
    complains(start + f"^grid: {{sensor.noise_N: {hundred}, compensator.gain: {hundred}}}\n",
              "grid: more than 10000000 combinations")
    complains(start + "^runs: 1000000\ngrid: {sensor.noise_N: {uniform: [0, 1], points: 11}}\nsample: {compensator.gain: [1]}\n",
              "runs: 11000000 rows with the grid, more than 10000000")
    complains(start + "grid: {x: {keys: [" + "a, " * 16 + "^b], values: [1]}}\n", "x: more than 16 keys")
    complains(start + "grid:\n" + "".join(f"  {'^' if i == 64 else ''}a{i}: {{keys: sensor.noise_N, values: [0]}}\n" for i in range(65)),
              "more than 64 axes")
    sim.write("study.yaml", "scenario: nothing.yaml\n")
    sim.fails("nothing.yaml: cannot be opened: No such file or directory", "sweep", "study.yaml", "--out", "o")


def test_a_normal_distribution_that_leaves_the_range_is_refused_before_the_first_run(sim):
    sim.write("base.yaml", BASE)
    sim.write("study.yaml", "scenario: base.yaml\nruns: 100\nsample:\n  compensator.gain: {normal: [1.5, 0.5]}\n")
    result = sim("sweep", "study.yaml", "--out", "o")
    assert result.returncode == 1
    assert re.fullmatch(r"tribo-sim: study.yaml:4:3: compensator.gain: 2\.\d+ is outside 0 to 2\n", result.stderr)
    assert not (sim.folder / "o").exists()


def test_the_scenarios_own_errors_are_its_files(sim):
    sim.write("base.yaml", BASE + "limits: {u_max_N: x}\n")
    sim.write("study.yaml", "scenario: base.yaml\n")
    sim.fails("base.yaml:3: limits.u_max_N: 'x' is not a number", "sweep", "study.yaml", "--out", "o")


def test_the_command_line(sim, study):
    sim.fails("sweep: --out DIR is expected (tribo-sim --help shows what there is)", "sweep", "study.yaml", status=2)
    sim.fails("merge: --out DIR is expected (tribo-sim --help shows what there is)", "merge", "study.yaml", status=2)
    sim.fails("sweep: --out and --row do not go together (tribo-sim --help shows what there is)", "sweep", "study.yaml", "--out", "o",
              "--row", 1, status=2)
    for workers in ("0", "-1", "x", "1025"):
        sim.fails(f"--workers {workers}: a number from 1 to 1024 is expected (tribo-sim --help shows what there is)", "sweep",
                  "study.yaml", "--out", "o", f"--workers={workers}", status=2)
    for shard in ("0/2", "3/2", "1", "1/x", "a/2", "1/100001", "/", ""):
        sim.fails(f"--shard {shard}: I/N is expected, with I from 1 to N, at most 100000 (tribo-sim --help shows what there is)",
                  "sweep", "study.yaml", "--out", "o", f"--shard={shard}", status=2)
    sim.fails("--row 24: 24 is outside 0 to 23", "sweep", "study.yaml", "--row", 24)
    sim.fails("--row x: 'x' is not a whole number of 0 or more", "sweep", "study.yaml", "--row", "x")
    sim.fails("no.yaml: cannot be opened: No such file or directory", "sweep", "no.yaml", "--out", "o")


def test_a_full_disk_is_an_error(sim, study):
    (sim.folder / "o").mkdir()
    (sim.folder / "o/rows.csv").symlink_to("/dev/full")
    sim.fails("o/rows.csv: is not a regular file", "sweep", "study.yaml", "--out", "o")
    sim.write("file", "")
    assert sim("sweep", "study.yaml", "--out", "file/o").returncode == 1
