"""The package in somebody else's process: what is true of a program is not of a library. Locale, rounding, threads, a folder that is gone, closed
descriptors, signals; and nothing that acts on the whole process is linked."""

import concurrent.futures
import dataclasses
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

import tribo
import tribo._native
import tribo._wide

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import foreign_process as foreign  # noqa: E402

SHORT = {"duration_s": 0.5, "metrics.start_s": 0, "compensator.guard.turn_N": 0.001}


@pytest.fixture(scope="module")
def locales(tmp_path_factory):
    folder = tmp_path_factory.mktemp("locales")
    why = foreign.make_locales(folder)
    if why:
        pytest.skip(f"no locale with a decimal comma: {why}")
    return folder


def refusal(call, *words, **keywords):
    with pytest.raises(ValueError) as caught:
        call(*words, **keywords)
    return str(caught.value)


def everything(folder):
    """What is read, written and calculated, as text and bits."""
    path = folder / "scenario.yaml"
    path.write_text("duration_s: 0.25\nreference: {kind: csv, file: r.csv}\nmetrics: {start_s: 0.05}\n", encoding="utf-8")
    (folder / "r.csv").write_text("t_s,r_N\n0,0.125\n0.1,0.5\n0.25,0.25\n", encoding="utf-8")
    wrong = folder / "wrong.yaml"
    wrong.write_text("compensator: {gain: 2.5}\n", encoding="utf-8")
    runs = [tribo.run("triangle", SHORT, arith="both"), tribo.run(path), tribo.run("noisy", SHORT, gain=0.875)]
    timing = {"wall_s", "real_time_factor"}
    said = [{key: value for key, value in dataclasses.asdict(run.summary).items() if key not in timing} for run in runs]
    for one in said:
        if one["q31"]:
            one["q31"] = {key: value for key, value in one["q31"].items() if key not in timing}
    bits = [column.tobytes() for run in runs for column in run.values()]
    loop, hub = tribo.Loop("triangle", {"compensator.gain": 0.875}, arith="q31"), tribo.Friction(offset_N=0.0125)
    fed = tribo.FeedForward("triangle", actuator_pole_rad_per_s=157.5)
    bits += [loop.steps(np.linspace(0, 0.7, 99), 0.1).tobytes(), hub.steps(np.linspace(-1, 1, 99), 0.25).tobytes(), repr(loop.step(0.3, 0.1)), repr(fed.error(0.7, 0.1)),
             repr(fed.command(0.3))]
    refused = [refusal(tribo.run, "triangle", gain=2.5), refusal(tribo.run, wrong), refusal(tribo.run, "triangle", {"compensator.gain": "0,5"}),
               refusal(tribo.Friction, k_min=0.5), refusal(tribo.run, "triangle", {"limits.u_max_N": 1.5e7}), refusal(tribo.run, "no such one"),
               refusal(tribo.run, "triangle", {"reference.kind": "csv", "reference.file": str(folder)})]
    rows = [repr(row) for row in tribo.PARAMETERS.values()]
    return json.dumps(said), bits, refused, rows


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plain")
    made = everything(folder)
    assert "2.5 is outside 0 to 2" in made[2][0]
    return folder, made


@pytest.mark.parametrize("name", foreign.COMMA)
def test_a_decimal_comma_of_the_process_changes_nothing(plain, locales, name):
    folder, wanted = plain
    with foreign.in_locale(locales, name):
        assert everything(folder) == wanted
        assert os.fspath(locales) in os.environ["LOCPATH"] and f"{1.5:n}" == "1,5"  # as it was left


def test_a_decimal_comma_of_a_thread_changes_nothing(plain, locales):
    folder, wanted = plain

    def work():
        with foreign.in_thread_locale(locales, foreign.COMMA[0]):
            return everything(folder)

    with concurrent.futures.ThreadPoolExecutor(1) as pool:
        assert pool.submit(work).result() == wanted
    assert everything(folder) == wanted


def doors():
    return (tribo.Axis(sample_time_s=1e-3, u_min_N=-2, u_max_N=2, offset_N=0.007, slope=0.3, actuator_pole_rad_per_s=200, sensor_pole_rad_per_s=55, kp=1, ki_per_s=56),
            tribo.Joint(sample_time_s=1e-3, effort_max=3.0, travel=0.0015, breakaway=0.3))


@pytest.mark.skipif(foreign.UPWARD is None, reason="its number for the direction of rounding is not known")
def test_another_direction_of_rounding_changes_no_bit(plain):
    _, wanted = plain
    with foreign.rounding_upward():
        run = tribo.run("triangle", SHORT, arith="both")
        loop, hub = tribo.Loop("triangle", {"compensator.gain": 0.875}, arith="q31"), tribo.Friction(offset_N=0.0125)
        steps = loop.steps(np.linspace(0, 0.7, 99), 0.1).tobytes(), hub.steps(np.linspace(-1, 1, 99), 0.25).tobytes(), repr(loop.step(0.3, 0.1))
    assert [column.tobytes() for column in run.values()] == wanted[1][:len(run)]
    (axis, joint), (twin, other) = doors(), doors()
    time_s = np.linspace(0, 9, 3000)
    with foreign.rounding_upward():
        bits = axis.steps(np.sin(time_s), 0.9).tobytes(), joint.steps(0.1, np.sin(time_s), np.sin(time_s - 0.05)).tobytes()
    assert bits == (twin.steps(np.sin(time_s), 0.9).tobytes(), other.steps(0.1, np.sin(time_s), np.sin(time_s - 0.05)).tobytes())
    again = tribo.Loop("triangle", {"compensator.gain": 0.875}, arith="q31")
    again.steps(np.linspace(0, 0.7, 99), 0.1)
    assert steps == tuple(wanted[1][-5:-2]) and repr(again.step(0.3, 0.1)) == steps[2]


def test_threads_that_run_at_once_do_not_meet(plain):
    """cffi gives up Python's lock in each call."""
    folder, wanted = plain
    start = threading.Barrier(4)

    def work(index):
        own = folder / f"thread{index}"
        own.mkdir(exist_ok=True)
        start.wait(timeout=300)
        made = everything(own)
        return [*made[:2], [words.replace(str(own), str(folder)) for words in made[2]], made[3]]

    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        for made in pool.map(work, range(4)):
            assert made == list(wanted)


def in_a_process(code, **options):
    return subprocess.run([sys.executable, "-B", "-c", code], capture_output=True, text=True, timeout=600, check=False, **options)


def test_ctrl_c_ends_a_run():
    code = """
import os, signal, threading, time, tribo
threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
begin_s = time.monotonic()
try:
    tribo.run("triangle", duration_s=86400, decimate=1000000)
except KeyboardInterrupt:
    ended = "at once" if time.monotonic() - begin_s < 20 else "at its own end, two minutes later"
    print(ended, tribo.run("triangle", {"duration_s": 0.2, "metrics.start_s": 0}).summary.ticks)
"""
    done = in_a_process(code)
    assert (done.returncode, done.stdout, done.stderr) == (0, "at once 200\n", "")


def test_a_folder_that_is_gone_and_closed_descriptors(tmp_path):
    code = """
import os, sys
result = os.dup(1)
os.makedirs("gone"); os.chdir("gone"); os.rmdir(os.getcwd())
for descriptor in (0, 1, 2):
    os.close(descriptor)
import tribo
run = tribo.run("triangle", {"duration_s": 0.2, "metrics.start_s": 0})
try:
    tribo.run("triangle", gain=3)
except tribo.ScenarioError as error:
    os.write(result, f"{len(run)} {error}".encode())
"""
    done = in_a_process(code, cwd=tmp_path)
    assert done.returncode == 0 and re.fullmatch(r"\d+ compensator.gain.* 3 is outside 0 to 2", done.stdout), done


def test_it_goes_on_in_a_fork(plain):
    code = """
import os, tribo
before = tribo.run("triangle", {"duration_s": 0.2, "metrics.start_s": 0}).u_N.tobytes()
child = os.fork()
if child == 0:
    os._exit(0 if tribo.run("triangle", {"duration_s": 0.2, "metrics.start_s": 0}).u_N.tobytes() == before else 3)
assert os.waitpid(child, 0)[1] == 0
"""
    assert in_a_process(code).returncode == 0


def test_the_process_is_as_it_was(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def state():
        umask = os.umask(0)
        os.umask(umask)
        return ({number: signal.getsignal(number) for number in signal.valid_signals()}, signal.pthread_sigmask(signal.SIG_BLOCK, []), umask, dict(os.environ), os.getcwd(),
                sorted(os.listdir("/proc/self/fd")), threading.active_count())

    before = state()
    tribo.run("triangle", SHORT)
    refusal(tribo.run, "triangle", gain=3)
    assert state() == before and not list(tmp_path.iterdir())


@pytest.mark.parametrize("module", [tribo._native, tribo._wide])
def test_nothing_is_linked_that_acts_on_the_whole_process(module):
    done = subprocess.run(["nm", "-D", "--undefined-only", module.__file__], capture_output=True, text=True, check=True)
    names = {re.sub(r"@.*|^__|_chk(@.*)?$", "", line.split()[-1]) for line in done.stdout.splitlines()}
    assert "memcpy" in names
    assert not names & foreign.ACTS_ON_THE_PROCESS


def test_a_name_that_is_not_utf8_is_reported(tmp_path):
    path = os.fsdecode(os.fsencode(tmp_path) + b"/r\xe4der.yaml")
    pathlib.Path(path).write_text("gain: 3\n", encoding="utf-8")
    assert r"r\xe4der.yaml:1: unknown key gain" in refusal(tribo.run, path)
    assert "mälder" in refusal(tribo.run, "triangle", {"plant.model": "mälder"})


def test_a_zero_byte_cuts_no_value():
    assert "holds a zero byte" in refusal(tribo.run, "triangle", {"plant.model": "relays\0x"})
    assert "holds a zero byte" in refusal(tribo.run, "triangle", {"compensator.gain": "0.5\0"})
