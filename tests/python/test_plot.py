"""Pictures of runs and records: what is drawn, and what is refused."""

import subprocess
import sys

import matplotlib
import numpy as np
import pytest

import tribo

matplotlib.use("agg")

from matplotlib import pyplot  # noqa: E402

T_S = np.arange(1000) * 1e-3


@pytest.fixture(autouse=True)
def _closed():
    yield
    pyplot.close("all")


def joint(error=0.1):
    q_ref = np.sin(T_S)
    return tribo.Record(t_s=T_S, q_ref=q_ref, q=q_ref - error, u=np.cos(T_S))


def test_a_run_lies_above_the_others_and_is_the_strong_line(tmp_path):
    on, off = tribo.run("triangle", duration_s=30), tribo.run("triangle", duration_s=30, method="off")
    figure = on.plot(off, names=("on", "off"), path=tmp_path / "run.png")
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["Force", "Error r − F", "Command u"]
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    force, error, command = figure.axes
    below, above, reference = force.lines
    assert above.get_linewidth() > below.get_linewidth() and above.get_zorder() > below.get_zorder() and reference.get_zorder() > above.get_zorder()
    assert np.array_equal(above.get_ydata(), on.F_N) and np.array_equal(below.get_ydata(), off.F_N) and np.array_equal(reference.get_ydata(), on.r_N)
    assert np.allclose(error.lines[1].get_ydata(), 1e3 * (on.r_N - on.F_N)) and error.get_ylabel() == "mN"
    assert np.array_equal(command.lines[1].get_ydata(), on.u_N)
    named = [text.get_text() for text in force.get_legend().get_texts()]
    assert named == [f"off: RMS error {1e3 * off.summary.rms_error_N:.3g} mN", f"on: RMS error {1e3 * on.summary.rms_error_N:.3g} mN", "reference"]
    low, high = error.get_ylim()
    assert -100 < low < np.min(error.lines[0].get_ydata()[600:]) < np.max(error.lines[0].get_ydata()[600:]) < high < 100  # the start at 400 mN is left out


@pytest.mark.parametrize("arith", ["f32", "q31"])
def test_what_a_part_records_is_what_it_steps(arith):
    r_N, q = 0.5 + 0.05 * np.sin(T_S), np.floor(400 * np.sin(4 * T_S))
    rig = {"sample_time_s": 1e-3, "u_min_N": -1, "u_max_N": 1, "offset_N": 0.02, "slope": 0.2, "actuator_pole_rad_per_s": 200, "sensor_pole_rad_per_s": 55}
    axis = tribo.Axis(**rig, kp=0.5, ki_per_s=27, arith=arith).record(r_N, 0.9 * r_N)
    assert np.array_equal(axis.u_N, tribo.Axis(**rig, kp=0.5, ki_per_s=27, arith=arith).steps(r_N, 0.9 * r_N)) and np.array_equal(axis.y_N, 0.9 * r_N)
    keys = {"sample_time_s": 1e-3, "effort_max": 1.0, "travel": 4, "arith": arith}
    seen = tribo.Joint(**keys).record(0.1, q + 3, q)
    assert np.array_equal(seen.u, tribo.Joint(**keys).steps(0.1, q + 3, q)) and np.array_equal(seen.effort, np.full(1000, 0.1))
    loop = tribo.Loop("triangle", arith=arith).record(r_N, 0.9 * r_N)
    assert np.array_equal(loop.u_N, tribo.Loop("triangle", arith=arith).steps(r_N, 0.9 * r_N))
    for record in (axis, seen, loop):
        assert np.allclose(record.t_s, T_S) and len(record.plot().axes) == 3


def test_a_joint_has_position_error_and_effort():
    figure = joint().plot(joint(0.3))
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["Position q", "Error q_ref − q", "Effort u"]
    assert [text.get_text() for text in figure.axes[0].get_legend().get_texts()] == ["run 2: RMS error 0.3", "this run: RMS error 0.1", "reference"]


@pytest.mark.parametrize("call, words", [
    (lambda: tribo.Record(t_s=T_S, q=T_S).plot(), "q_ref, q and u. It has t_s, q"), (lambda: tribo.Record().plot(), "It has none"),
    (lambda: joint().plot(names=("a", "b")), "2 names for 1 runs"), (lambda: joint().plot(tribo.run("triangle", {"metrics.start_s": 0}, duration_s=1)), "both a force and a position"),
    (lambda: tribo.Record(joint() | {"u": T_S[:5]}).plot(), r"u: \(5,\) values"), (lambda: tribo.Record(joint() | {"u": [1e308] * len(T_S)}).plot(), r"u: 1e\+308 is outside -1e\+30 to 1e\+30"), (lambda: tribo.Record(joint() | {"t_s": [np.nan] * len(T_S)}).plot(), "t_s: nan is outside"),
    (lambda: tribo.Record(t_s=[], q_ref=[], q=[], u=[]).plot(), "at least one")])  # fmt: skip
def test_what_cannot_be_drawn_says_why(call, words):
    with pytest.raises(ValueError, match=words):
        call()


def test_a_picture_without_an_ending_is_a_png(tmp_path):
    joint().plot(path=tmp_path / "picture")
    assert (tmp_path / "picture").read_bytes().startswith(b"\x89PNG")


def test_an_attribute_that_is_none_names_the_columns():
    with pytest.raises(AttributeError, match="a record has no F_N; its columns are t_s, q_ref, q, u"):
        joint().F_N


def test_matplotlib_is_imported_by_the_first_picture_and_missed_in_words():
    code = "import sys, tribo; assert 'matplotlib' not in sys.modules; sys.modules['matplotlib'] = None; tribo.run('triangle', {'metrics.start_s': 0}, duration_s=1).plot()"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert said.returncode == 1 and "ImportError: plot() needs matplotlib: pip install matplotlib" in said.stderr
