"""Parts stepped alone: the same bits tick by tick, over arrays and in the run that they are parts of."""

import dataclasses
import pathlib

import numpy as np
import pytest

import tribo

ROOT = pathlib.Path(__file__).resolve().parents[2]
ARITHMETICS = ("f32", "q31")
PARTS = (tribo.Loop, tribo.Friction, tribo.Compensator, tribo.Guard, tribo.FeedForward)
T = np.arange(3000) * 1e-3
R = 0.5 + 0.1 * np.sin(6 * T)
Y = R + 0.02 * np.cos(11 * T)
F = 0.2 * np.sign(np.sin(20 * np.pi * T))
HUNTING = [np.full(len(T), 0.5), 0.5 + F, F, np.arange(len(T)) % 97 > 0]  # r, y, friction, good


def inputs_of(part):
    if isinstance(part, tribo.Guard):
        return HUNTING
    values = {"r_N": R, "y_N": Y, "u_N": R + 0.2 * np.cos(9 * T), "F_N": R, "controller_N": 3 * (R - Y)}
    return [values[name] for name in part.inputs]


@pytest.mark.parametrize("arith", ARITHMETICS)
@pytest.mark.parametrize("scenario, keys", [("triangle", {}), ("noisy", {"compensator.method": "paper"}), ("mismatch", {"compensator.method": "paper"})])
def test_a_loop_steps_as_in_a_run(scenario, keys, arith):
    run = tribo.run(scenario, keys | {"metrics.start_s": 0}, duration_s=12, arith=arith)
    seen = tribo.Loop(scenario, keys, arith=arith).record(run.r_N, run.y_N)
    for name in ("e_N", "controller_N", "friction_term_N", "limited", "F_hat_N", "n_N", "L_N", "v_N_per_s", "Q1", "Q2", "Q", "f_hat_N"):
        assert np.array_equal(seen[name], run[name]), name
    assert np.array_equal(seen["u_N"].astype(np.float32), run.u_N.astype(np.float32))


@pytest.mark.parametrize("arith", ARITHMETICS)
@pytest.mark.parametrize("kind", PARTS)
def test_ticks_arrays_and_records_are_the_same(kind, arith):
    one, many, whole = (kind(arith=arith) for _ in range(3))
    inputs = inputs_of(one)
    if kind is tribo.FeedForward:
        stepped = [(one.error(r, y), one.command(v))[1] for r, y, v in zip(*inputs)]
    else:
        stepped = [one.step(*tick) for tick in zip(*inputs)]
    array = many.steps(*inputs)
    assert np.array_equal(stepped, array)
    seen = whole._record(*inputs)
    assert tuple(seen) == whole.outputs and np.array_equal(seen[whole.outputs[0]], array)
    assert {name: column[-1] for name, column in seen.items()} == one.signals == whole.signals
    assert len(np.unique(array)) > (1 if kind is tribo.Guard else 100)
    one.reset()
    assert np.array_equal(one.steps(*inputs), array)
    if kind in (tribo.Loop, tribo.Compensator, tribo.FeedForward):  # the others have forgotten by then
        assert not np.array_equal(many.steps(*inputs), array)


@pytest.mark.parametrize("arith", ARITHMETICS)
def test_the_feed_forward_around_another_controller_is_the_loops(arith):
    limits = {"limits.u_max_N": 0.62}
    run = tribo.run("triangle", limits | {"metrics.start_s": 0}, duration_s=25, arith=arith)
    fed = tribo.FeedForward("triangle", limits, arith=arith)
    seen = fed.record(run.r_N, run.y_N, run.controller_N)
    loop = tribo.Loop("triangle", limits, arith=arith)
    whole = loop.record(run.r_N, run.y_N)
    exact = {"rtol": 0, "atol": 0 if arith == "f32" else 2.0**-24}  # in Q31 a trace has v to float's digits
    assert 0 < np.count_nonzero(seen["limited"]) < len(run.t_s) and seen["F_hat_N"].any()
    for name in ("u_N", "e_N", "friction_term_N", "limited", "F_hat_N", "f_hat_N"):
        np.testing.assert_allclose(seen[name], whole[name], **exact)
    np.testing.assert_allclose(fed.learned(0.5).positive.breakaway_N, loop.learned(0.5).positive.breakaway_N, rtol=0 if arith == "f32" else 1e-5)
    assert fed.learned(0.5).positive.travel_N == pytest.approx(loop.learned(0.5).positive.travel_N, rel=1e-5) and fed.learned(0.5).positive.travel_N > 0.1


@pytest.mark.parametrize("kind, arith", [(tribo.Compensator, "f32"), (tribo.Compensator, "q31"), (tribo.Friction, "f32")])
def test_friction_alone_is_that_of_the_loop(kind, arith):
    keys = {"compensator.method": "paper"}
    run = tribo.run("triangle", keys | {"metrics.start_s": 0, "reference.low_N": -0.5}, duration_s=25, arith=arith)
    loop = tribo.Loop("triangle", keys, arith=arith).record(run.r_N, run.y_N)
    assert all(len(np.unique(loop[name])) == 2 for name in ("Q1", "Q2", "Q"))
    seen = kind("triangle", keys, arith=arith).record(*[loop[name] for name in ("u_N", "F_hat_N")[: 1 + (kind is not tribo.Compensator)]])
    for name, values in seen.items():
        assert np.array_equal(values.astype(np.float32), loop["f_hat_N" if name == "f_N" else name].astype(np.float32)), name


def test_what_a_loop_learns_is_what_a_run_learns():
    run = tribo.run("triangle")
    loop = tribo.Loop("triangle")
    loop.steps(run.r_N, run.y_N)
    learned, of_run = loop.learned(run.r_N[-1]), run.summary.learned
    for way in ("positive", "negative"):  # the summary's numbers have 15 digits
        assert dataclasses.astuple(getattr(learned, way)) == pytest.approx(dataclasses.astuple(getattr(of_run, way)), rel=1e-14)
    assert loop.guard_cause == run.summary.guard == "none"
    assert tribo.Loop(method="paper").learned() is None


def test_a_loop_knows_its_sample_time():
    assert tribo.Loop("triangle").sample_time_s == pytest.approx(0.001)
    assert tribo.Loop(ROOT / "examples/rig/rig_500hz.yaml", arith="q31").sample_time_s == pytest.approx(0.002)


def test_counters_and_bad_inputs():
    loop = tribo.Loop()
    u = loop.steps([0.5, np.nan, 3.0, -3.0, 2.0, 2.0], [0.0, 0.0, 0.0, 0.0, -2.0, -2.0])
    assert np.all(np.isfinite(u)) and loop.bad_inputs == 3 and loop.limited_ticks == 2
    loop.reset()
    assert loop.bad_inputs == loop.limited_ticks == 0


@pytest.mark.parametrize("full_scale_n", [2, 4])
@pytest.mark.parametrize("arith", ["f32", "q31"])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e9, -1e9])
@pytest.mark.parametrize("at", ["r", "y"])
def test_a_missing_input_holds_u_and_is_counted(full_scale_n, arith, bad, at):
    """With full scale equal to input_max, as scenarios have it by default, and with room above."""
    loop = tribo.Loop("triangle", {"compensator.method": "off", "limits.full_scale_N": full_scale_n}, arith=arith)
    force, u = 0.0, []
    for k in range(3100):
        inputs = {"r": 0.5, "y": force}
        if k >= 3000:
            inputs[at] = bad
        u.append(loop.step(inputs["r"], inputs["y"]))
        force += 0.05 * (u[-1] - force)
    assert loop.bad_inputs == 100
    assert u[2999] == pytest.approx(0.5, abs=1e-3) and np.ptp(u[3000:]) < 1e-4


@pytest.mark.parametrize("arith", ["f32", "q31", "both"])
def test_a_run_whose_inputs_were_nearly_all_bad_ends_with_an_error(arith):
    with pytest.raises(tribo.ScenarioError, match="bad input in 2000 of 2000 ticks, beyond limits.input_max_N"):
        tribo.run("step", {"reference.low_N": 25, "reference.high_N": 25, "metrics.start_s": 0}, duration_s=2, arith=arith)


@pytest.mark.parametrize("arith", ["f32", "q31"])
def test_the_largest_credible_force_is_credible(arith):
    loop = tribo.Loop("triangle", arith=arith)
    loop.steps([2.0, -2.0, 0.0, 0.0], [0.0, 0.0, 2.0, -2.0])
    assert loop.bad_inputs == 0


def test_a_guard_fades_hunting_and_is_restored():
    guard = tribo.Guard()
    assert guard.steps(*HUNTING[:3])[-1] < 0.1 and guard.cause == "hunting"
    guard.restore()
    assert guard.cause == "none"
    assert np.all(tribo.Guard().steps(*HUNTING[:3], False) == 1)


@pytest.mark.parametrize("kind, keys, status, field", [
    (tribo.Friction, {"k_min": 0.5}, "K_MIN", "compensator.friction.k_min"),
    (tribo.Friction, {"offset_N": 0}, "BREAKAWAY_OFFSET", "compensator.friction.breakaway.offset_N"),
    (tribo.Friction, {"negative_offset_N": 0}, "BREAKAWAY_NEGATIVE_OFFSET", "compensator.friction.breakaway.negative_offset_N"),
    (tribo.Friction, {"pulse_width_s": 1.0}, "PULSE_WIDTH", "compensator.friction.pulse_width_s"),
    (tribo.Compensator, {"stiffness_N_per_deg": float("nan")}, "STIFFNESS", "compensator.arm.stiffness_N_per_deg"),
    (tribo.Guard, {"turn_N": 0}, "GUARD_TURN", "compensator.guard.turn_N"),
    (tribo.FeedForward, {"trust": 2}, "TRUST", "compensator.feedforward.trust"),
    (tribo.Loop, {"gain": 3}, "GAIN", "compensator.gain"),
    (tribo.Loop, {"u_min_N": 1}, "U_MIN", "limits.u_min_N"),
    (tribo.Loop, {"controller.kind": "delta", "controller.sections": [{"b0": 1, "b1": 0.5, "b2": 0.01, "a1": 0.3, "a2": -0.1}]}, "SECTION_UNSTABLE", "controller.sections"),
])
def test_the_librarys_refusals_are_exceptions(kind, keys, status, field):
    with pytest.raises(tribo.StatusError) as refused:
        kind(None, keys)
    assert (refused.value.status, refused.value.field) == (status, field)
    assert str(refused.value) == f"{field}: {refused.value.text}"


def test_the_negative_direction_is_as_the_positive_one_unless_given():
    assert tribo.Friction(offset_N=0.5, slope=0).step(-2.0, 0.0) == pytest.approx(-0.5, rel=1e-3)
    assert tribo.Friction(offset_N=0.5, slope=0, negative_offset_N=0.25).step(-2.0, 0.0) == pytest.approx(-0.25, rel=1e-3)
    table = [{"force_N": 0, "positive_N": 0.1, "negative_N": 0.2}, {"force_N": 1, "positive_N": 0.3, "negative_N": 0.4}]
    hub = tribo.Friction(None, {"compensator.friction.breakaway.table": table})
    assert hub.record(2.0, 0.5)["L_N"][0] == pytest.approx(0.2)


def test_an_open_loop_and_a_wrong_shape_are_refused():
    with pytest.raises(tribo.ScenarioError, match="controller.kind"):
        tribo.Loop(None, {"controller.kind": "none"})
    with pytest.raises(ValueError, match="one dimension"):
        tribo.Friction().steps(np.zeros((2, 2)), 0.0)
    with pytest.raises(ValueError, match="must be f32 or q31"):
        tribo.Loop(arith="f64")
    with pytest.raises(ValueError):
        tribo.Friction().steps(np.zeros(3), np.zeros(2))


def test_parameters_are_the_librarys_rows():
    rows = tribo.PARAMETERS
    k_max = rows["compensator.friction.k_max"]
    assert (k_max.low, k_max.high, k_max.default, k_max.unit) == (1.01, 1000, 20, "-")
    assert len(rows) > 30 and all(row.text for row in rows.values())
