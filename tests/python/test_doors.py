"""An axis and a joint in one object each: ticks and arrays have the same bits, friction goes, and what is refused says why."""

import math
import pathlib
import sys

import numpy as np
import pytest

import tribo

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import doors  # noqa: E402

ARITHMETICS = ("f32", "q31")
RIG = {"sample_time_s": 1e-3, "u_min_N": -1.0, "u_max_N": 1.0, "offset_N": 0.007, "slope": 0.3, "arm_lag_s": 0.0075,
       "actuator_pole_rad_per_s": 200.0, "sensor_pole_rad_per_s": 55.0}  # fmt: skip


def error_of(tick, periods=4):
    return doors.axis_run(tick, periods * doors.PERIOD)[0]


@pytest.mark.parametrize("arith", ARITHMETICS)
def test_an_axis_takes_friction_out_and_says_what_it_learned(arith):
    axis = tribo.Axis(**RIG, kp=0.5, ki_per_s=27.0, arith=arith)
    assert error_of(axis.step) < 5e-4
    report = axis.report()
    truth = 1.2 * (0.007 + 0.3 * 0.25)
    assert report.breakaway_N == pytest.approx((truth, truth), rel=0.05)
    assert all(low < truth < high for low, high in zip(report.low_N, report.high_N))
    assert report.times_less > 1.5 and report.share == pytest.approx(1) and report.warnings == () and report.bad_inputs == 0


@pytest.mark.parametrize("arith", ARITHMETICS)
def test_full_scale_itself_is_a_good_input_and_more_is_not(arith):
    axis = tribo.Axis(**RIG, kp=0.5, ki_per_s=27.0, arith=arith, full_scale_N=2.0, input_max_N=2.0)
    axis.steps([2.0, -2.0], [2.0, 2.0])
    assert axis.report().bad_inputs == 0
    axis.steps([2.1, math.nan], [2.0, 2.0])
    assert axis.report().bad_inputs == 2


@pytest.mark.parametrize("arith", ARITHMETICS)
def test_ticks_and_arrays_of_an_axis_are_the_same(arith):
    r = 0.3 + 0.1 * np.sin(np.arange(2000) * 6e-3)
    one, many = (tribo.Axis(**RIG, kp=0.5, ki_per_s=27.0, arith=arith) for _ in range(2))
    assert [one.step(a, b) for a, b in zip(r, 0.9 * r)] == list(many.steps(r, 0.9 * r))


@pytest.mark.parametrize("arith", ARITHMETICS)
def test_a_controller_of_ones_own(arith):
    axis = tribo.Axis(**RIG, controller="own", arith=arith)
    integral = 0.0

    def tick(r, y):
        nonlocal integral
        error = axis.error(r, y)
        integral += 0.027 * error
        u = axis.command(0.5 * error + integral)
        integral += axis.excess_N
        return u

    assert error_of(tick) < 5e-4
    axis.error(0.0, 0.0)
    assert axis.command(3.0) == pytest.approx(1.0) and axis.excess_N < -1.0


@pytest.mark.parametrize("arith", ARITHMETICS)
def test_an_axis_is_changed_while_it_runs(arith):
    axis = tribo.Axis(**RIG, kp=0.5, ki_per_s=27.0, arith=arith)
    assert error_of(axis.step, 2) < 5e-4
    last, learned = axis.steps([0.3] * 9, 0.1)[-1], axis.report().breakaway_N
    for keywords in ({"kp": 0.2}, {"kp": 0.4, "ki_per_s": 20.0}, {"sections": [[0.6, 0.62, 0.02, 1.0, 0.0]]}, {"kp": 0.5, "ki_per_s": 27.0}):
        axis.change(**keywords)
        u = axis.step(0.3, 0.1)
        assert u == pytest.approx(last, abs=0.02), keywords  # the integral goes on by 0.0054; of kp alone u would jump by 0.06
        last = u
        axis.change(u_max_N=0.9)
        axis.change(u_max_N=1.0)  # twice before a tick
    assert axis.report().breakaway_N == pytest.approx(learned, rel=0.02)
    assert error_of(axis.step, 2) < 2e-3
    with pytest.raises(tribo.StatusError, match="kp"):
        axis.change(kp=-1.0)
    with pytest.raises(ValueError, match="one controller"):
        axis.change(kp=1.0, controller="own")
    with pytest.raises(TypeError, match="sample_time_s"):
        axis.change(sample_time_s=2e-3)
    axis.change(u_max_N=0.05)
    assert axis.step(0.9, 0.0) == pytest.approx(0.05)


@pytest.mark.parametrize("arith", ARITHMETICS)
def test_a_change_has_the_bits_of_an_axis_made_so(arith):
    made, changed = tribo.Axis(**RIG, kp=0.7, ki_per_s=30.0, arith=arith), tribo.Axis(**RIG, kp=0.5, ki_per_s=27.0, arith=arith)
    changed.change(kp=0.6, gravity_N=0.1)
    changed.change(kp=0.7, ki_per_s=30.0, gravity_N=0.0)
    r = 0.3 + 0.1 * np.sin(np.arange(200) * 0.05)
    assert list(changed.steps(r, 0.9 * r)) == list(made.steps(r, 0.9 * r))


@pytest.mark.parametrize("arith", ARITHMETICS)
def test_what_an_axis_has_learned_is_handed_on(arith):
    axis = tribo.Axis(**RIG, kp=0.5, ki_per_s=27.0, arith=arith)
    error_of(axis.step, 2)
    other = tribo.Axis(**RIG, kp=0.5, ki_per_s=27.0, arith=arith)
    blob = axis.export()
    other.load(blob)
    assert other.report().breakaway_N == axis.report().breakaway_N
    with pytest.raises(tribo.StatusError, match="checksum"):
        other.load(blob[:-1] + bytes([blob[-1] ^ 1]))
    with pytest.raises(tribo.StatusError, match="version"):
        other.load(blob[:-4])
    with pytest.raises(tribo.StatusError, match="rig"):
        tribo.Axis(**RIG | {"offset_N": 0.02}, kp=0.5, ki_per_s=27.0, arith=arith).load(blob)


def test_an_axis_refuses_what_is_ambiguous_or_out_of_range():
    with pytest.raises(ValueError, match="one controller"):
        tribo.Axis(**RIG)
    with pytest.raises(ValueError, match="one controller"):
        tribo.Axis(**RIG, kp=1.0, ki_per_s=1.0, controller="own")
    with pytest.raises(ValueError, match="paper or own"):
        tribo.Axis(**RIG, controller="pid")
    with pytest.raises(ValueError, match="each row"):
        tribo.Axis(**RIG, sections=[1.0, 2.0])
    with pytest.raises(ValueError, match="f32 or q31"):
        tribo.Axis(**RIG, controller="paper", arith="f64")
    with pytest.raises(tribo.StatusError, match="section_count"):
        tribo.Axis(**RIG, sections=np.ones((5, 5)))
    with pytest.raises(tribo.StatusError, match="kp"):
        tribo.Axis(**RIG, kp=math.nan, ki_per_s=1.0)
    with pytest.raises(tribo.StatusError, match="sample_time_s"):
        tribo.Axis(**RIG | {"sample_time_s": 0}, controller="paper")
    axis = tribo.Axis(**RIG, controller="paper")
    assert -1 <= axis.step(math.nan, 0.0) <= 1
    assert axis.report().bad_inputs == 1 and "bad_inputs" in axis.report().warnings[0]
    axis.restore()


@pytest.mark.parametrize("arith", ARITHMETICS)
@pytest.mark.parametrize("advice", [{"presliding_N": 0.02}, {"still_time_s": 0.0}, {"noise_N": 0.002}])
def test_what_a_warning_advises_can_be_configured(arith, advice):
    axis = tribo.Axis(**RIG, kp=0.5, ki_per_s=27.0, arith=arith)
    axis.change(**advice)
    assert error_of(axis.step, 2) < error_of(tribo.Axis(**RIG, kp=0.5, ki_per_s=27.0, arith=arith).step, 2) * 2
    (name,) = advice
    with pytest.raises(tribo.StatusError, match=name.removesuffix("_N")):
        axis.change(**{name: -1.0})


JOINT = {"sample_time_s": 1e-3, "effort_max": 1.0, "travel": 4.0}


@pytest.mark.parametrize("arith", ARITHMETICS)
def test_a_joint_learns_its_friction_and_takes_it_out(arith):
    joint, plain = tribo.Joint(**JOINT, arith=arith), tribo.Joint(**JOINT, gain=0.0, arith=arith)
    assert doors.joint_run(plain.step, True)[0] > 2.5 * doors.joint_run(joint.step, True)[0]
    report = joint.report()
    assert report.is_learned and report.cause == "sound" and report.friction == pytest.approx(0.1, rel=0.1)
    assert report.low < 0.1 < report.high and report.bad_inputs == 0
    force = joint.force()
    assert force.low < force.force < force.high and force.high - force.low < 0.35


@pytest.mark.parametrize("arith", ARITHMETICS)
def test_ticks_and_arrays_of_a_joint_are_the_same(arith):
    q = np.floor(400 * np.sin(np.arange(3000) * 4e-3))
    one, many = (tribo.Joint(**JOINT, breakaway=0.2, arith=arith) for _ in range(2))
    for joint in (one, many):
        joint.load(-0.1)
    inputs = (0.1 * np.cos(np.arange(3000) * 4e-3), q + 3, q)
    stepped = [one.step(*tick) for tick in zip(*inputs)]
    assert stepped == list(many.steps(*inputs))
    assert stepped[0] == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("arith", ARITHMETICS)
def test_a_joint_with_the_wrong_sign_says_so_until_restored(arith):
    joint = tribo.Joint(**JOINT, breakaway=0.1, arith=arith)
    for stroke in range(10):
        way = 1 if stroke % 2 == 0 else -1
        q = np.arange(400) if way > 0 else 400 - np.arange(400)
        joint.steps(-0.2 * way, q + way, q)
    assert "reversed" in joint.report().cause and joint.report().share == 0
    joint.restore()
    assert joint.report().cause == "sound"


def test_a_joint_refuses_what_is_out_of_range():
    for keys, words in (({"effort_max": 0}, "effort_max"), ({"travel": math.nan}, "travel"), ({"breakaway": 2.0}, "breakaway"), ({"gain": 1.5}, "gain"),
                        ({"sample_time_s": 1.0}, "^sample_time_s: 1e-6 to 0.1 s"), ({"actuator_pole_rad_per_s": -1}, "actuator_pole")):  # fmt: skip
        with pytest.raises(tribo.StatusError, match=words):
            tribo.Joint(**JOINT | keys)
    for make, words in ((lambda: tribo.Joint(**JOINT | {"travel": "4"}), "travel='4': a number"), (lambda: tribo.Joint(**JOINT | {"gain": None}), "gain=None: a number"),
                        (lambda: tribo.Axis(**RIG | {"u_max_N": "1"}, controller="own"), "u_max_N='1': a number"),
                        (lambda: tribo.Axis(**RIG, kp=0.5, ki_per_s=27.0).change(kp="1"), "kp='1': a number")):  # fmt: skip
        with pytest.raises(TypeError, match=words):
            make()
    with pytest.raises(ValueError, match="f32 or q31"):
        tribo.Joint(**JOINT, arith="f64")
    joint = tribo.Joint(**JOINT)
    with pytest.raises(tribo.StatusError, match="gain"):
        joint.gain = 2.0
    joint.gain = 0.5
    assert joint.gain == 0.5
    for arith in ARITHMETICS:
        joint = tribo.Joint(**JOINT, arith=arith)
        assert np.isfinite(joint.steps([math.nan, 0.1, 0.1], [0, math.nan, 0], [0, 0, math.inf])).all()


@pytest.mark.parametrize("arith", ["f32", "q31"])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_each_bad_input_of_a_joint_is_counted_once_a_tick(arith, bad):
    for place in range(3):
        joint = tribo.Joint(sample_time_s=1e-3, effort_max=3.0, travel=4, arith=arith)
        inputs = [0.5, 0.0, 0.0]
        joint.step(*inputs)
        inputs[place] = bad
        assert joint.step(*inputs) == pytest.approx(0.0 if place == 0 else 0.5, abs=1e-6) and joint.report().bad_inputs == 1
        joint.step(bad, bad, bad)
        assert joint.report().bad_inputs == 2
        joint.load(bad)
        assert joint.report().bad_inputs == 3 and joint.step(0.5, 0.0, 0.0) == pytest.approx(0.5, abs=1e-6) and joint.report().bad_inputs == 3


@pytest.mark.parametrize("arith", ["f32", "q31"])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_bad_output_of_a_callers_controller_is_0_and_counted(arith, bad):
    """A NaN of one's own PID was the largest command downwards in Q31."""
    axis, other = (tribo.Axis(**RIG, controller="own", arith=arith) for _ in range(2))
    for one in (axis, other):
        one.error(0.5, 0.4)
    assert axis.command(bad) == other.command(0.0) and (axis.report().bad_inputs, other.report().bad_inputs) == (1, 0)


@pytest.mark.parametrize("arith", ["f32", "q31"])
@pytest.mark.parametrize("changes", [
    {"u_min_N": -1e-5, "u_max_N": 1e-5, "offset_N": 1e-6, "slope": 0.3}, {"u_min_N": 0.0, "u_max_N": 1e-4, "offset_N": 1e-6, "slope": 0.3}, {"u_min_N": -1e6, "u_max_N": 1e6, "offset_N": 100.0},
    {"u_min_N": -2.0, "u_max_N": 0.0}, {"input_max_N": 100.0}, {"usual_force_N": 50.0}, {"offset_N": 20.0}, {"negative_offset_N": 30.0}, {"gravity_N": 30.0}, {"gravity_N": -30.0},
    {"noise_N": 5.0}, {"sample_time_s": 1e-6}, {"sample_time_s": 1e-6, "arm_lag_s": 1e-6}, {"sample_time_s": 1e-5}, {"arm_lag_s": 1e-7}])  # fmt: skip
def test_a_default_refuses_no_legal_config(arith, changes):
    axis = tribo.Axis(**({"sample_time_s": 1e-3, "u_min_N": -2.0, "u_max_N": 2.0, "offset_N": 0.007, "slope": 0.3, "actuator_pole_rad_per_s": 200.0, "sensor_pole_rad_per_s": 55.0, "kp": 1.9, "ki_per_s": 110.0} | changes), arith=arith)
    most = max(abs(axis._keywords["u_min_N"]), abs(axis._keywords["u_max_N"]))
    assert np.isfinite(axis.steps(np.full(100, 0.1 * most), 0.0)).all()


def test_the_default_full_scale_is_that_of_the_limits_where_they_are_the_largest():
    assert [tribo.Axis(**RIG, kp=1.0, ki_per_s=1.0, arith=arith)._keywords["full_scale_N"] for arith in ("f32", "q31")] == [4.0 * max(-RIG["u_min_N"], RIG["u_max_N"])] * 2


@pytest.mark.parametrize("arith, error", [("f32", ValueError), ("q31", tribo.StatusError)])
@pytest.mark.parametrize("full_scale_N", [float("nan"), 1e-4, 1e30])
def test_a_full_scale_is_checked_also_where_it_has_no_effect(arith, error, full_scale_N):
    with pytest.raises(error, match="full_scale"):
        tribo.Axis(**RIG, kp=1.0, ki_per_s=1.0, arith=arith, full_scale_N=full_scale_N)


def test_a_refusal_by_the_default_full_scale_names_it():
    with pytest.raises(tribo.StatusError, match="breakaway at usual_force_n: q31: 0.0011.*full_scale_N was left out and is 0.001; arith='f32' needs none"):
        tribo.Axis(**(RIG | {"u_min_N": -1e-6, "u_max_N": 1e-6, "offset_N": 1e-6, "slope": 0.0}), kp=1.0, ki_per_s=1.0, arith="q31")
