"""tribo.sweep and tribo-sweep: rows of tribo-sim's bits, the same whoever plays them and whatever ends them, and rows that anyone can replay."""

import json
import math
import os
import pathlib
import re
import shlex
import signal
import statistics
import subprocess
import sys
import time
from concurrent import futures

import numpy as np
import pandas
import pytest

import tribo
from tribo import _sweep

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIM = os.environ["TRIBO_SIM"]
BIN = pathlib.Path(sys.executable).parent
STUDIES = ROOT / "host_sim/studies"
MEASURES = ("rms_error_N max_error_N rms_measured_error_N u_variation_N variation_ratio chatter_ticks Q_switches window_ticks "
            "limited_ticks bad_inputs").split()
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
AXES = ["compensator.gain", "plant.model", "breakaway", "sensor.noise_N", "sensor.noise_seed", "sensor.delay_s", "plant.actuator_pole_rad_per_s", "waveform"]


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    """A folder with the scenario and the study."""
    monkeypatch.chdir(tmp_path)
    pathlib.Path("base.yaml").write_text(BASE)
    pathlib.Path("study.yaml").write_text(STUDY)
    return tmp_path


def sweep(text, *words, **options):
    pathlib.Path("given.yaml").write_text(text)
    return tribo.sweep("given.yaml", *words, workers=2, **options)


def command(*words, **options):
    return subprocess.run([BIN / "tribo-sweep", *map(str, words)], capture_output=True, text=True, check=False, timeout=1200, **options)


def until(has_happened, what, limit_s=200):
    """Waits for it. The limit is for what never happens."""
    end = time.monotonic() + limit_s
    while not has_happened():
        assert time.monotonic() < end, what
        time.sleep(0.005)


def same(a, b):
    pandas.testing.assert_frame_equal(a, b, check_exact=True)
    assert a.attrs == b.attrs
    return True


# Rows


def test_the_columns_are_the_axes_and_the_measures_of_both_runs():
    frame = sweep(STUDY)
    assert list(frame) == ["row", *AXES, *MEASURES, *("without_" + name for name in MEASURES), "ratio", "status", "message"]
    assert frame["row"].tolist() == list(range(24)) and set(frame["status"]) == {"ok"} and set(frame["message"]) == {""}
    assert (frame["ratio"] == frame["without_rms_error_N"] / frame["rms_error_N"]).all()
    # The grid runs through all combinations for each sample, its last axis fastest.
    assert frame[AXES[:2]].head(5).values.tolist() == [[0.5, "paper"], [0.5, "lugre"], [0.85, "paper"], [0.85, "lugre"], [0.5, "paper"]]
    samples = list(frame[AXES[2:]].itertuples(index=False, name=None))
    assert all(samples[i] == samples[i // 4 * 4] for i in range(24)) and len(set(samples)) == 6
    assert frame["sensor.noise_seed"].dtype == np.uint64 and frame["sensor.delay_s"].dtype == np.float64
    assert frame.attrs["axes"] == AXES and frame.attrs["relative"] == ["breakaway"]


@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
def test_every_row_has_the_bits_of_its_command(arithmetic):
    frame = sweep(STUDY + f"arithmetic: {arithmetic}\n")
    study = tribo.Study("given.yaml")
    for row in (0, 3, 10, 23):
        for without in (False, True):
            words = shlex.split(study.command(row, without))
            assert words[:3] == ["tribo-sim", "run", "base.yaml"] and ("--arith" in words) == (arithmetic == "q31")
            summary = json.loads(subprocess.run([SIM, *words[1:], "--json"], check=True, capture_output=True, text=True).stdout)
            found = {name: frame.loc[row, ("without_" if without else "") + name] for name in MEASURES if name != "window_ticks"}
            assert found == {name: summary[name] for name in found}
        assert [f"--set {key}" for key in study.keys(row)] == re.findall(r"--set [\w.\[\]]+", study.command(row))
    assert frame["window_ticks"].tolist() == [1000] * 24


def test_a_study_without_axes_is_one_row():
    frame = sweep("scenario: base.yaml\n")
    assert list(frame) == ["row", *MEASURES, "status", "message"]
    assert frame.loc[0, "rms_error_N"] == tribo.run("base.yaml").summary.rms_error_N


def test_a_scenario_next_to_the_study_precedes_one_of_the_folder():
    pathlib.Path("d").mkdir()
    pathlib.Path("d/triangle").write_text(BASE)
    pathlib.Path("d/study.yaml").write_text("scenario: triangle\n")
    assert tribo.Study("d/study.yaml").scenario == "d/triangle"
    pathlib.Path("study.yaml").write_text("scenario: triangle\n")
    assert tribo.Study("study.yaml").scenario.endswith("scenarios/triangle.yaml")


def test_values_reach_the_shell_and_the_scenario_as_they_are():
    name = "it's a \"file\" $HOME.csv"
    pathlib.Path(name).write_text("t_s,r_N\n0,0.4\n1,0.6\n")
    frame = sweep("scenario: base.yaml\nset: {reference.kind: csv}\ngrid:\n  reference.file: ['it''s a \"file\" $HOME.csv']\n")
    assert frame.loc[0, "reference.file"] == name and frame.loc[0, "status"] == "ok"
    said = subprocess.run(["sh", "-c", tribo.Study("given.yaml").command(0).replace("tribo-sim", SIM, 1) + " --json"], capture_output=True, text=True, check=True).stdout
    assert json.loads(said)["rms_error_N"] == frame.loc[0, "rms_error_N"]


def test_a_mapping_is_a_study_of_the_same_rows():
    study = {"scenario": "base.yaml", "set": {"compensator.guard.on": False}, "runs": np.int64(3), "grid": {"compensator.gain": np.array([0.5, 1])},
             "sample": {"sensor.noise_N": {"uniform": (0, 0.001), "relative": False}}}
    frame = tribo.sweep(study, workers=1)
    text = "scenario: base.yaml\nset: {compensator.guard.on: no}\nruns: 3\ngrid: {compensator.gain: [0.5, 1]}\nsample: {sensor.noise_N: {uniform: [0, 0.001]}}\n"
    pandas.testing.assert_frame_equal(frame, sweep(text))
    with pytest.raises(tribo.ScenarioError, match=r"study:\d+:\d+: compensator.gain: .* is not a finite number|nan"):
        tribo.sweep({"scenario": "base.yaml", "grid": {"compensator.gain": [0.5, math.nan]}})


# Where the samples are

SHORT = "scenario: base.yaml\nset: {duration_s: 0.001}\n"


def drawn(text):
    """The values of each axis, without a run."""
    pathlib.Path("drawn.yaml").write_text(text)
    study = tribo.Study("drawn.yaml")
    rows = [study.labels(row) for row in range(study.rows)]
    return {axis.name: [float(row[i]) for row in rows] for i, axis in enumerate(study.axes)}


@pytest.mark.parametrize("method, runs", [("latin_hypercube", 40), ("sobol", 64)])
def test_a_stratified_sample_has_one_in_each_part(method, runs):
    found = drawn(SHORT + f"method: {method}\nruns: {runs}\nsample:\n  sensor.noise_N: {{uniform: [0, 0.004]}}\n"
                  "  plant.actuator_pole_rad_per_s: {log_uniform: [50, 800]}\n  sensor.pole_rad_per_s: {normal: [55, 5]}\n  sensor.delay_s: [0, 0.001, 0.002, 0.003]\n")
    normal = statistics.NormalDist(55, 5)
    parts = {"sensor.noise_N": lambda x: x / 0.004, "plant.actuator_pole_rad_per_s": lambda x: math.log(x / 50) / math.log(16), "sensor.pole_rad_per_s": normal.cdf}
    orders = []
    for name, part in parts.items():
        orders.append([int(part(x) * runs) for x in found[name]])
        assert sorted(orders[-1]) == list(range(runs)), name
    assert orders[0] != orders[1] != orders[2] != orders[0] and orders[0] != sorted(orders[0])
    assert [found["sensor.delay_s"].count(x) for x in (0, 0.001, 0.002, 0.003)] == [runs // 4] * 4
    if method == "sobol":  # which Latin hypercubes are not: even in the plane of two axes
        cells = {(a // 8, b // 8) for a, b in zip(orders[0], orders[1])}
        assert len(cells) == 64


def test_monte_carlo_is_independent_and_even():
    found = drawn(SHORT + "method: monte_carlo\nruns: 2000\nsample:\n  sensor.noise_N: {uniform: [0, 1]}\n"
                  "  sensor.quantisation_N: {uniform: [0, 1]}\n  sensor.pole_rad_per_s: {normal: [55, 5], within: [50, 65]}\n  sensor.noise_seed: {uniform: [3, 5]}\n")
    x, y = found["sensor.noise_N"], found["sensor.quantisation_N"]
    counts = [sum(i / 10 <= value < (i + 1) / 10 for value in x) for i in range(10)]
    assert sum((count - 200) ** 2 / 200 for count in counts) < 27.9  # chi squared, 9 degrees of freedom, 0.1 %
    assert len({int(value * 2000) for value in x}) < 1500  # not stratified
    assert abs(statistics.correlation(x, y)) < 0.08
    poles = found["sensor.pole_rad_per_s"]
    assert 50 <= min(poles) < 50.1 and 64.5 < max(poles) <= 65
    n = statistics.NormalDist()  # cut off at -1 and 2 standard deviations
    assert statistics.fmean(poles) == pytest.approx(55 + 5 * (n.pdf(-1) - n.pdf(2)) / (n.cdf(2) - n.cdf(-1)), abs=0.3)
    seeds = found["sensor.noise_seed"]
    assert set(seeds) == {3, 4, 5} and all(600 < seeds.count(seed) < 733 for seed in set(seeds))


@pytest.mark.parametrize("method", ["latin_hypercube", "monte_carlo"])
def test_the_seed_moves_all_axes_and_another_axis_none(method):
    def noise(seed, more=""):
        return drawn(SHORT + f"seed: {seed}\nmethod: {method}\nruns: 10\nsample:\n{more}  sensor.noise_N: {{uniform: [0, 1]}}\n")["sensor.noise_N"]

    assert noise(1, "  sensor.quantisation_N: {uniform: [0, 1]}\n") == noise(1) != noise(2)
    assert noise(2**64 - 1) != noise(2**64 - 2)


def test_distributions_in_a_grid_are_points():
    found = drawn(SHORT + "grid:\n  sensor.noise_N: {uniform: [0, 1], points: 3}\n  plant.actuator_pole_rad_per_s: {log_uniform: [100, 400], points: 3}\n"
                  "  sensor.pole_rad_per_s: {normal: [55, 5], points: 2}\n")
    assert found["sensor.noise_N"] == [0] * 6 + [0.5] * 6 + [1] * 6
    assert found["plant.actuator_pole_rad_per_s"][:6] == [100, 100, 200, 200, 400, 400]
    n = statistics.NormalDist(55, 5)
    assert found["sensor.pole_rad_per_s"][:2] == pytest.approx([n.inv_cdf(0.25), n.inv_cdf(0.75)], rel=1e-5)


def test_relative_values_are_times_the_scenarios_own():
    pathlib.Path("r.yaml").write_text(SHORT.replace("0.001}", "0.001, plant.arm.stiffness_N_per_deg: 4}")
                                      + "grid:\n  plant.arm.stiffness_N_per_deg: {values: [0.5, 2], relative: true}\n"
                                      "  both: {keys: [plant.friction.breakaway.slope, compensator.friction.breakaway.slope], relative: true, values: [1.5]}\n")
    study = tribo.Study("r.yaml")
    assert [study.keys(row)["plant.arm.stiffness_N_per_deg"] for row in (0, 1)] == ["2", "8"]
    assert study.keys(0)["plant.friction.breakaway.slope"] == study.keys(0)["compensator.friction.breakaway.slope"] == "0.45"


# The same frame


def test_workers_executors_and_folders_do_not_show(here):
    frame = tribo.sweep("study.yaml", workers=1)
    assert same(tribo.sweep("study.yaml", workers=5), frame)
    assert same(tribo.sweep("study.yaml", "o"), frame) and same(tribo.sweep("study.yaml", "o"), frame)
    assert same(pandas.read_parquet("o/rows.parquet"), frame)
    assert sorted(path.name for path in pathlib.Path("o").iterdir()) == [".lock", "rows.parquet"]
    with futures.ThreadPoolExecutor(2) as executor:
        assert same(tribo.sweep("study.yaml", executor=executor), frame)


def test_a_cluster_of_dask_plays_the_same_rows():
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None) as cluster, distributed.Client(cluster) as client:
        assert same(tribo.sweep("study.yaml", "o", executor=client), tribo.sweep("study.yaml"))


@pytest.mark.parametrize("shards", [2, 5, 30])
def test_shards_come_to_what_one_sweep_has(shards, monkeypatch):
    frames = [tribo.sweep("study.yaml", "parts", shard=(i, shards), workers=1) for i in range(1, shards + 1)]
    assert sorted(row for frame in frames for row in frame["row"]) == list(range(24))
    whole = tribo.sweep("study.yaml", workers=2)
    monkeypatch.setattr(_sweep, "_play_blocks", lambda study, blocks, pool: iter(()) if not list(blocks) else pytest.fail("plays a row again"))
    assert same(tribo.sweep("study.yaml", "parts"), whole)
    assert tribo.sweep("study.yaml", "parts", shard=(1, shards))["row"].tolist() == frames[0]["row"].tolist()


def test_a_block_of_many_rows_is_that_of_single_ones(monkeypatch):
    whole = tribo.sweep("study.yaml")
    monkeypatch.setattr(_sweep, "BLOCKS", 3)
    assert [len(block) for block in _sweep._blocks(tribo.Study("study.yaml"), None)] == [8, 8, 8]
    assert same(tribo.sweep("study.yaml", "o"), whole)


# Ended and taken up again

LONG = "scenario: base.yaml\nset: {duration_s: 600}\ngrid: {compensator.gain: [0.1, 0.2, 0.3]}\n"


def test_sigkill_at_any_moment_changes_nothing():
    """The program and its workers are killed again and again, until it gets through."""
    pathlib.Path("study.yaml").write_text(STUDY.replace("seed: 7", "seed: 8\nset: {duration_s: 20}"))
    whole, counts, kills = tribo.sweep("study.yaml"), set(), 0
    while True:
        process = subprocess.Popen([BIN / "tribo-sweep", "study.yaml", "--out", "o", "--workers", "2"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        parts = pathlib.Path("o/parts")

        def played():
            return len(list(parts.glob("*.parquet"))) if parts.exists() else 0

        wanted = played() + 3 + kills
        until(lambda process=process, wanted=wanted: process.poll() is not None or played() >= wanted, "no rows")
        if process.poll() is not None:
            break
        os.killpg(process.pid, signal.SIGKILL) if kills % 2 else process.kill()
        process.wait()
        kills += 1
        counts.add(played())
    assert process.returncode == 0 and kills >= 2 and len(counts) > 1
    assert same(pandas.read_parquet("o/rows.parquet"), whole)
    assert sorted(path.name for path in pathlib.Path("o").iterdir()) == [".lock", "rows.parquet"]


@pytest.mark.parametrize("how, status", [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_an_ended_shard_leaves_whole_files_and_goes_on(how, status):
    pathlib.Path("study.yaml").write_text(STUDY.replace("seed: 7", "seed: 9\nset: {duration_s: 15}"))
    shard = [BIN / "tribo-sweep", "study.yaml", "--out", "o", "--workers", "1", "--shard", "1/2"]
    process = subprocess.Popen(shard, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, preexec_fn=lambda: [signal.signal(number, signal.SIG_DFL if number != signal.SIGINT else signal.default_int_handler)
                                                                                                            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)])
    until(lambda: process.poll() is not None or len(list(pathlib.Path("o").glob("parts/*.parquet"))) >= 2, "no rows")
    process.send_signal(how)
    _, errors = process.communicate(timeout=200)
    parts = list(pathlib.Path("o/parts").iterdir())
    assert process.returncode == status and 2 <= len(parts) < 12 and all(path.suffix == ".parquet" for path in parts), errors
    assert b"Traceback" not in errors and sum(len(pandas.read_parquet(path)) for path in parts) == len(parts)
    assert subprocess.run(shard, capture_output=True, check=False).returncode == 0
    assert same(tribo.sweep("study.yaml", "o"), tribo.sweep("study.yaml"))


def test_half_a_file_of_an_interrupted_write_is_not_taken_up():
    whole = tribo.sweep("study.yaml")
    tribo.sweep("study.yaml", "o", shard=(1, 2))
    part = pathlib.Path("o/parts/00000003.part")
    part.write_bytes(b"PAR1")
    assert same(tribo.sweep("study.yaml", "o"), whole) and not part.exists()


def children(process):
    return [int(word) for word in pathlib.Path(f"/proc/{process}/task/{process}/children").read_text(encoding="ascii").split()]


def processor_s(process):
    fields = pathlib.Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def is_running(process):
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def started(study, *words):
    """The program in the middle of its rows, and its workers."""
    pathlib.Path("long.yaml").write_text(study)
    process = subprocess.Popen([BIN / "tribo-sweep", "long.yaml", "--out", "o", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler))  # which a shell's background ignores
    until(lambda: pathlib.Path("o/parts").exists() and (children(process.pid) or process.poll() is not None), "no workers")
    assert process.poll() is None, process.communicate()
    return process, children(process.pid)


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_workers_end_with_their_sweep(how):
    process, workers = started(LONG.replace("600", "80000"), "--workers", "3")
    until(lambda: len(children(process.pid)) == 3 and all(processor_s(worker) > 0.1 for worker in children(process.pid)), "never three workers that work")
    workers = children(process.pid)
    process.send_signal(how)
    _, errors = process.communicate(timeout=200)
    assert process.returncode == (-how if how == signal.SIGKILL else 130)
    if how == signal.SIGINT:
        assert errors == "tribo-sweep: interrupted; the same command goes on from here\n"
    until(lambda: not any(map(is_running, workers)), "workers go on")
    assert not list(pathlib.Path("o").rglob("*.part"))


def test_two_sweeps_do_not_write_one_folder():
    process, _ = started(LONG.replace("600", "80000"))
    try:
        with pytest.raises(tribo.SweepError, match="^o: another sweep is writing there$"):
            tribo.sweep("study.yaml", "o")
        with pytest.raises(tribo.SweepError, match="another sweep"):
            tribo.sweep("study.yaml", "o", shard=(1, 2))
    finally:
        process.kill()
        process.communicate()
    with _sweep._locked(pathlib.Path("o"), (1, 2)):
        with pytest.raises(tribo.SweepError, match="another sweep"):
            tribo.sweep("long.yaml", "o", shard=(1, 2))
        with pytest.raises(tribo.SweepError, match="another sweep"):
            tribo.sweep("long.yaml", "o")
        with _sweep._locked(pathlib.Path("o"), (2, 2)):
            pass


@pytest.mark.parametrize("change", [("study.yaml", STUDY.replace("seed: 7", "seed: 8")), ("base.yaml", BASE + "limits: {u_max_N: 1}\n")])
@pytest.mark.parametrize("shard", [None, (1, 2)])
def test_rows_of_another_study_are_not_taken_up(change, shard):
    tribo.sweep("study.yaml", "o", shard=shard)
    path = pathlib.Path("o/rows.parquet" if shard is None else "o/parts/00000000.parquet")
    before = path.read_bytes()
    pathlib.Path(change[0]).write_text(change[1])
    with pytest.raises(tribo.SweepError, match=f"^{path}: belongs to another study, or to an earlier version of this one: remove it, or give another folder$"):
        tribo.sweep("study.yaml", "o", shard=shard)
    assert path.read_bytes() == before


@pytest.mark.parametrize("study", ["scenario: csv.yaml\n", "scenario: base.yaml\nset: {reference.kind: csv, reference.file: r.csv}\n",
                                   "scenario: base.yaml\nset: {reference.kind: csv}\ngrid: {reference.file: [r.csv]}\n"])
def test_a_changed_reference_is_another_study(study):
    pathlib.Path("r.csv").write_text("t_s,r_N\n0,0.4\n1,0.6\n")
    pathlib.Path("csv.yaml").write_text("duration_s: 1\nreference: {kind: csv, file: r.csv}\n")
    assert set(sweep(study, "o")["status"]) == {"ok"}
    pathlib.Path("r.csv").write_text("t_s,r_N\n0,0.4\n1,0.5\n")
    with pytest.raises(tribo.SweepError, match="belongs to another study"):
        sweep(study, "o")


def test_a_damaged_file_is_named():
    tribo.sweep("study.yaml", "o", shard=(1, 2))
    pathlib.Path("o/parts/00000002.parquet").write_bytes(b"PAR1 and no more")
    with pytest.raises(tribo.SweepError, match=r"^o/parts/00000002.parquet: cannot be read: .*: remove the file$"):
        tribo.sweep("study.yaml", "o")


# Rows that fail


def test_a_worker_that_is_killed_costs_no_row():
    process, workers = started(LONG.replace("[0.1, 0.2, 0.3]", str([k / 100 for k in range(8)])), "--workers", "1")
    os.kill(workers[0], signal.SIGKILL)
    _, errors = process.communicate(timeout=1000)
    assert process.returncode == 0, errors
    frame = pandas.read_parquet("o/rows.parquet")
    assert frame["row"].tolist() == list(range(8)) and set(frame["status"]) == {"ok"}


def test_a_row_that_crashes_its_worker_costs_itself_alone(monkeypatch):
    play = _sweep._play

    def crash(how, sets):
        if "compensator.gain=0.2" in sets:
            os.kill(os.getpid(), signal.SIGKILL)
        return play(how, sets)

    monkeypatch.setattr(_sweep, "_play", crash)
    frame = sweep("scenario: base.yaml\ngrid: {compensator.gain: [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8]}\n", "o")
    assert frame["status"].tolist() == ["ok", "crashed", *["ok"] * 6]
    assert frame.loc[1, "message"] == "the worker process ended abruptly" and frame.loc[1, MEASURES].isna().all()


def test_a_worker_of_a_cluster_that_is_lost_is_its_rows_end(monkeypatch):
    class KilledWorker(Exception):
        """An exception of Dask has this name."""

    play, lost = _sweep._play, KilledWorker("a row")

    def fail(how, sets):
        if "compensator.gain=0.2" in sets:
            raise lost
        return play(how, sets)

    monkeypatch.setattr(_sweep, "_play", fail)
    study = {"scenario": "base.yaml", "grid": {"compensator.gain": [0.1, 0.2, 0.3]}}
    with futures.ThreadPoolExecutor(1) as executor:
        assert tribo.sweep(study, executor=executor)["status"].tolist() == ["ok", "crashed", "ok"]
        lost = ModuleNotFoundError("No module named 'tribo'")  # else every row of such a cluster would have crashed
        with pytest.raises(ModuleNotFoundError):
            tribo.sweep(study, executor=executor)


def test_a_run_that_takes_too_long_is_ended():
    frame = sweep("scenario: base.yaml\ntimeout_s: 0.1\ngrid: {duration_s: [1, 80000, 1]}\n")
    assert frame["status"].tolist() == ["ok", "timeout", "ok"]
    assert frame.loc[1, "message"] == "took more processor time than timeout_s"


def test_a_run_that_is_refused_is_a_row():
    text = ("scenario: base.yaml\nwithout: {compensator.gain: 0}\ngrid:\n  which:\n    cases:\n      fine: {compensator.gain: 0.5}\n"
            "      refused: {compensator.friction.k_min: 30}\n      also: {plant.step_s: 0.0003}\n")
    frame = sweep(text)
    assert frame["status"].tolist() == ["ok", "refused", "refused"]
    assert "compensator.friction.k_m" in frame.loc[1, "message"] and "plant.step_s" in frame.loc[2, "message"] and "--set" not in frame.loc[1, "message"]
    assert frame.loc[1:, [*MEASURES, "ratio"]].isna().all(axis=None)
    said = command("given.yaml", "--out", "o")
    assert said.returncode == 1 and said.stderr.startswith("tribo-sweep: 2 of 3 rows failed, the first: row 1: refused: ")
    assert [row["row"] for row in frame.attrs["worst"]["ratio"]] == [0]


def test_a_second_run_that_is_refused_leaves_the_first():
    frame = sweep("scenario: base.yaml\nwithout: {plant.step_s: 0.0003}\n")
    assert frame.loc[0, "status"] == "refused" and frame.loc[0, "message"].startswith("without: ")
    assert frame.loc[0, "rms_error_N"] > 0 and math.isnan(frame.loc[0, "ratio"])


def test_a_run_whose_loop_coasted_has_no_figures():
    frame = sweep("scenario: base.yaml\nset: {reference.low_N: 40, reference.high_N: 60, limits.input_max_N: 1}\n")
    assert frame.loc[0, "status"] == "failed" and "bad input" in frame.loc[0, "message"]


# The report


def quantile(values, p):
    return float(np.quantile(values, p))


@pytest.mark.parametrize("paired", [True, False])
def test_the_report_has_a_table_and_a_panel_for_each_axis(paired):
    frame = sweep(STUDY if paired else STUDY.replace("without: {compensator.gain: 0}\n", ""), "o")
    pictures = [*(["ratio.png"] if paired else []), "chatter.png", "rms.png"]
    written = tribo.sweep_report(frame, "o")
    assert sorted(path.name for path in written) == sorted([*pictures, "report.md"])
    assert all(pathlib.Path("o", name).read_bytes().startswith(b"\x89PNG") for name in pictures)
    text = pathlib.Path("o/report.md").read_text(encoding="utf-8")
    assert all(f"| {axis} | rows | " in text for axis in AXES)
    line = next(line for line in text.splitlines() if line.startswith("| lugre | 12 | ")).split(" | ")
    lugre = frame[frame["plant.model"] == "lugre"]
    assert float(line[2]) == pytest.approx(1e3 * quantile(lugre["rms_error_N"], 0.5), rel=0.01)
    if paired:
        assert float(line[7]) == pytest.approx(quantile(lugre["ratio"], 0.5), rel=0.01)
        assert line[9] == f"{100 * (lugre['ratio'] < 1).sum() / 12:.3g} %"
    worst = frame.attrs["worst"]["rms_error_N"]
    assert [one["row"] for one in worst] == frame.sort_values("rms_error_N", ascending=False, kind="stable")["row"].head(10).tolist()
    assert f"    {worst[0]['command']}\n" in text and worst[0]["command"] == tribo.Study("given.yaml").command(worst[0]["row"])
    before = [path.read_bytes() for path in written]
    tribo.sweep_report(pandas.read_parquet("o/rows.parquet"), "o")
    assert [path.read_bytes() for path in written] == before


def test_a_sweep_is_drawn_alone(here):
    def plot(*words):
        return subprocess.run([BIN / "tribo-plot", *words], capture_output=True, text=True, check=False)

    sweep(STUDY, "o")
    assert plot("o", "--out", "s.svg").returncode == 0 and "× the scenario's" in pathlib.Path("s.svg").read_text(encoding="utf-8")
    (here / "run").mkdir()
    done = plot("o", "run", "--out", "t.svg")
    assert done.returncode == 1 and "a sweep is drawn alone" in done.stderr and not pathlib.Path("t.svg").exists()
    pandas.DataFrame({"row": [1]}).to_parquet("other.parquet")
    (here / "p").mkdir()
    pathlib.Path("other.parquet").rename("p/rows.parquet")
    assert "p/rows.parquet: is not of a sweep" in plot("p", "--out", "t.svg").stderr
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "tribo"
    if list(cache.glob("uplot-*")):
        assert plot("o/rows.parquet", "--out", "s.html").returncode == 0
        assert "× the scenario's" in pathlib.Path("s.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("path", sorted(STUDIES.glob("*.yaml")), ids=lambda path: path.stem)
def test_the_projects_studies_can_be_played(path):
    study = tribo.Study(path.stem)
    assert study.id == tribo.Study(path).id and study.is_paired
    for row in (0, study.rows - 1):
        tribo.run(study.scenario, {"metrics.start_s": 0, "duration_s": 0.01, **{key: value for key, value in study.keys(row).items() if key not in ("metrics.start_s", "duration_s")}})


# Errors


def refuses(text, message, mark="^"):
    """The mark in the text is where the complaint must point."""
    before, _, after = text.partition(mark)
    line, column = before.count("\n") + 1, len(before) - (before.rfind("\n") + 1) + 1
    pathlib.Path("wrong.yaml").write_text(before + after)
    with pytest.raises(tribo.ScenarioError) as refused:
        tribo.sweep("wrong.yaml", "never")
    assert str(refused.value) == f"wrong.yaml:{line}:{column}: {message}"
    assert not pathlib.Path("never").exists()


START = "scenario: base.yaml\n"
HUNDRED = "{uniform: [0, 1], points: 100000}"


@pytest.mark.parametrize("text, message", [
    ("^", "the file is empty"),
    ("^a\n", "a study: a mapping is expected here, not a single value"),
    ("^seed: 1\n", "scenario: is missing"),
    ("scenario: ^[a]\n", "scenario: a single value is expected here, not a list"),
    (START + "^sead: 1\n", "unknown key sead, did you mean seed?"),
    (START + "seed: 1\n^seed: 2\n", "seed is given twice, first in line 2"),
    (START + "seed: ^-1\n", "seed: '-1' is not a whole number of 0 or more"),
    (START + "seed: ^18446744073709551616\n", "seed: 18446744073709551616 is outside 0 to 18446744073709551615"),
    (START + "arithmetic: ^q15\n", "arithmetic: 'q15' is not f32 or q31"),
    (START + "timeout_s: ^0\n", "timeout_s: 0 is outside 0.01 to 1e+06"),
    (START + "timeout_s: ^.nan\n", "timeout_s: '.nan' is not a finite number"),
    (START + "timeout_s: ^1_0\n", "timeout_s: '1_0' is not a number"),
    (START + "timeout_s: ^1e999\n", "timeout_s: '1e999' is too large for a number"),
    (START + "^runs: 5\n", "only sample takes runs, and there is no sample"),
    (START + "^sample: {sensor.noise_N: [1]}\n", "sample needs runs, their number"),
    (START + "runs: ^0\nsample: {sensor.noise_N: [1]}\n", "runs: 0 is outside 1 to 1000000"),
    (START + "runs: 1\nmethod: ^halton\nsample: {sensor.noise_N: [1]}\n", "method: 'halton' is not latin_hypercube, monte_carlo or sobol"),
    (START + "set: {plant.modle: ^paper}\n", "unknown key plant.modle, did you mean plant.model?"),
    (START + "without: {compensator.gain: ^3}\n", "compensator.gain: 3 is outside 0 to 2"),
    (START + "set: {compensator.gain: ^.nan}\n", "compensator.gain: '.nan' is not a finite number"),
    (START + "set: {sensor: ^{noise_N: 1}}\n", "sensor: a single value is expected here, not a mapping"),
    (START + "grid:\n  ^compensator.gain: {uniform: [0, 2.5], points: 2}\n", "compensator.gain: 2.5 is outside 0 to 2"),
    (START + "grid:\n  any: [^1]\n", "unknown key any"),
    (START + "grid:\n  any: {keys: ^[], values: [1]}\n", "keys: the list is empty"),
    (START + "grid:\n  ^plant.model: {uniform: [0, 1], points: 2}\n", "plant.model is not a number: values are expected"),
    (START + "grid:\n  ^metrics.end_s: {values: [1], relative: true}\n", "metrics.end_s: the scenario gives no value to be relative to"),
    (START + "grid:\n  ^ratio: {keys: compensator.gain, values: [1]}\n", "ratio: a column of every sweep has this name, give the axis another"),
    (START + "runs: 9\ngrid: {sensor.noise_N: [1]}\nsample: {^sensor.noise_N: [1]}\n", "sensor.noise_N is given twice, first in line 3"),
    (START + f"^grid: {{sensor.noise_N: {HUNDRED}, compensator.gain: {HUNDRED}}}\n", "grid: more than 10000000 combinations"),
    (START + "^runs: 1000000\ngrid: {sensor.noise_N: {uniform: [0, 1], points: 11}}\nsample: {compensator.gain: [1]}\n",
     "runs: 11000000 rows with the grid, more than 10000000"),
    (START + "grid: {x: {keys: [" + "a, " * 16 + "^b], values: [1]}}\n", "x: more than 16 keys"),
    (START + "grid:\n" + "".join(f"  {'^' if i == 64 else ''}a{i}: {{keys: sensor.noise_N, values: [0]}}\n" for i in range(65)), "more than 64 axes"),
])
def test_complaints_name_file_line_column_value_and_range(text, message):
    refuses(text, message)


@pytest.mark.parametrize("axis, message", [
    ("^3", "compensator.gain: a mapping is expected here, not a single value"),
    ("^[]", "compensator.gain: values, cases, uniform, log_uniform or normal is expected"),
    ("^{}", "compensator.gain: values, cases, uniform, log_uniform or normal is expected"),
    ("[0.1, ^2.5]", "compensator.gain: 2.5 is outside 0 to 2"),
    ("[0.1, ^x]", "compensator.gain: 'x' is not a number"),
    ("[0.1, ^.nan]", "compensator.gain: '.nan' is not a finite number"),
    ("^{uniform: [0, 1]}", "compensator.gain: a distribution in the grid needs points, their number"),
    ("{uniform: [0, 1], points: ^1}", "points: 1 is outside 2 to 100000"),
    ("{values: [1], ^points: 2}", "compensator.gain: only a distribution in the grid takes points"),
    ("{uniform: ^[1, 1], points: 2}", "uniform: 1 is not below 1"),
    ("{uniform: ^[1], points: 2}", "uniform: two numbers are expected here"),
    ("{uniform: [1, ^a], points: 2}", "uniform: 'a' is not a number"),
    ("{uniform: [0, ^.inf], points: 2}", "uniform: '.inf' is not a finite number"),
    ("{log_uniform: ^[0, 1], points: 2}", "log_uniform: 0 < from < to is expected, not 0, 1"),
    ("{normal: ^[0, 0], points: 2}", "normal: the standard deviation 0 is not above 0"),
    ("{normal: [^nan, 1], points: 2}", "normal: 'nan' is not a finite number"),
    ("{normal: [0, 1], within: ^[1, 0], points: 2}", "within: 1 is not below 0"),
    ("{uniform: [0, 1], ^within: [0, 1], points: 2}", "compensator.gain: only normal takes within"),
    ("{uniform: [0, 1], ^normal: [0, 1]}", "compensator.gain: uniform and normal do not go together"),
    ("{^unifrom: [0, 1]}", "unknown key unifrom, did you mean uniform?"),
    ("{values: [1, ^a], relative: true}", "compensator.gain: 'a' is not a number"),
    ("{values: [2, ^3], relative: true}", "compensator.gain: 2.55 is outside 0 to 2"),
    ("{values: [2], relative: ^maybe}", "relative: 'maybe' is not false, no, true or yes"),
    ("{cases: {a: {compensator.gain: ^3}}}", "compensator.gain: 3 is outside 0 to 2"),
    ("{^cases: {a: {compensator.gain: 1}}, relative: true}", "compensator.gain: cases have their own keys: remove keys and relative"),
])
def test_complaints_about_an_axis(axis, message):
    refuses(f"{START}grid:\n  compensator.gain: {axis}\n", message)


@pytest.mark.parametrize("content, message", [
    (b"[\n", r"wrong.yaml:\d:\d: not valid YAML: .+"),
    (b"a: \xff\n", "wrong.yaml:1:1: not valid YAML: not UTF-8"),
    (b"a: \0\n", r"wrong.yaml:1:1: not valid YAML: .+"),
    (b"a: 1\n---\nb: 2\n", r"wrong.yaml:2:1: not valid YAML: .+"),
    (b"a: &a {b: *a}\n", "wrong.yaml:1:1: unknown key a"),
    (b"[" * 20_000, "wrong.yaml:1:1: not valid YAML: .+"),
    (b"#" * (5 << 20), "wrong.yaml: is larger than 4194304 bytes"),
    (b"scenario: nothing\n", "wrong.yaml:1:11: scenario: nothing: there is no such file, and no such scenario in .*"),
])
def test_a_file_that_is_not_a_study(content, message):
    pathlib.Path("wrong.yaml").write_bytes(content)
    with pytest.raises(tribo.ScenarioError) as refused:
        tribo.Study("wrong.yaml")
    assert re.fullmatch(message, str(refused.value)), refused.value


def test_the_scenarios_own_errors_are_its_files():
    pathlib.Path("base.yaml").write_text(BASE + "limits: {u_max_N: x}\n")
    with pytest.raises(tribo.ScenarioError, match=r"^base.yaml:3: limits.u_max_N: 'x' is not a number$"):
        tribo.Study("study.yaml")


def test_a_normal_distribution_that_leaves_the_range_is_refused_before_the_first_run():
    text = "scenario: base.yaml\nruns: 100\nsample:\n  compensator.gain: {normal: [1.5, 0.5]}\n"
    with pytest.raises(tribo.ScenarioError, match=r"^given.yaml:4:3: compensator.gain: 2\.\d+ is outside 0 to 2$"):
        sweep(text, "o")
    assert not pathlib.Path("o").exists()


def test_arguments_are_checked():
    for words, message in (({"shard": (0, 2)}, "shard 0/2: i of n is expected, with i from 1 to n, at most 100000"), ({"shard": (3, 2)}, "shard 3/2"), ({"shard": (1, 100_001)}, "at most 100000"),
                           ({"workers": 0}, "workers=0: a number from 1 to 1024 is expected"), ({"workers": 1025}, "workers=1025"), ({"workers": 1, "executor": 1}, "exclude each other")):
        with pytest.raises(ValueError, match=re.escape(message)):
            tribo.sweep("study.yaml", "o", **words)
    with pytest.raises(ValueError, match="a shard needs a folder"):
        tribo.sweep("study.yaml", shard=(1, 2))
    with pytest.raises(ValueError, match="row 24: 24 is outside 0 to 23"):
        tribo.Study("study.yaml").keys(24)
    with pytest.raises(tribo.ScenarioError, match="no.yaml: there is no such file, and no such study in"):
        tribo.sweep("no.yaml")
    pathlib.Path("file").write_text("")
    for out, why in (("file/o", "^file/o: Not a directory$"), ("file", "^file: is not a folder$")):
        with pytest.raises(tribo.SweepError, match=why):
            tribo.sweep("study.yaml", out)
    before = sorted(pathlib.Path().iterdir())
    with pytest.raises(ValueError, match="out: is empty"):
        tribo.sweep("study.yaml", "")
    with pytest.raises(tribo.ScenarioError, match="^/dev/full: is larger than 4194304 bytes$"):
        tribo.sweep("/dev/full")
    assert sorted(pathlib.Path().iterdir()) == before


def test_the_command_line():
    done = command("study.yaml", "--out", "o", "--workers", "2", "--report")
    assert (done.returncode, done.stderr) == (0, "")
    frame = pandas.read_parquet("o/rows.parquet")
    line = next(line.split() for line in done.stdout.splitlines() if line.startswith("rms_error_N "))
    assert [float(word) for word in line[1:]] == pytest.approx([quantile(frame["rms_error_N"], p) for p in (0, 0.05, 0.25, 0.5, 0.75, 0.95, 1)], rel=1e-4)
    assert f"worse than without: {(frame['ratio'] < 1).sum()} of 24 rows" in done.stdout
    assert "written: o/rows.parquet, o/report.md, o/rms.png" in done.stdout and pathlib.Path("o/report.md").exists()
    study = tribo.Study("study.yaml")
    assert command("study.yaml", "--row", 3).stdout.splitlines() == [study.command(3), study.command(3, without=True)]
    for words, status, message in ((("study.yaml",), 2, "--out DIR or --row ROW is expected"), (("study.yaml", "--out", "o", "--shard", "x"), 2, "x: I/N is expected"),
                                   (("study.yaml", "--out", "p", "--shard", "3/2"), 1, "tribo-sweep: shard 3/2"), (("study.yaml", "--row", "24"), 1, "tribo-sweep: row 24"),
                                   (("study.yaml", "--out", "p", "--workers", "0"), 1, "tribo-sweep: workers=0"), (("no.yaml", "--out", "p"), 1, "tribo-sweep: no.yaml: there is no such file")):
        done = command(*words)
        assert done.returncode == status and message in done.stderr and "Traceback" not in done.stderr, done.stderr
    shards = [command("study.yaml", "--out", "parts", "--shard", f"{i}/2") for i in (1, 2)]
    assert [done.returncode for done in shards] == [0, 0]
    assert command("study.yaml", "--out", "parts").returncode == 0
    assert same(pandas.read_parquet("parts/rows.parquet"), frame)


def test_a_progress_bar_is_drawn_where_it_is_wanted(capfd):
    tribo.sweep("study.yaml", workers=1, progress=True)
    assert re.search(r"24/24.*row/s", capfd.readouterr().err)
    tribo.sweep("study.yaml", workers=1)
    assert capfd.readouterr().err == ""
