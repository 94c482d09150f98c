"""What a law of friction leaves, by its causes; cogging; the range of a prediction; and the rule of accept beside its simulations."""

import itertools

import lab
import numpy as np
import pytest
from test_rig import whole_way  # noqa: F401 - the way of a foreign rig, played once

from tribo_identify import accept, bins, events, slides
from tribo_identify.logs import Log, Segment
from tribo_rig import cogging, experiments, results, unexplained

H = 1e-3
LEVEL = 1.5


def force_of(seconds=40.0, period=8.0, low=2.0, high=14.0):
    """A triangle that rests for a while at each turn, as F does in stiction."""
    t = np.arange(0, seconds, H)
    return t, np.clip(low - 1 + (high - low + 2) * (1 - np.abs(2 * (t % period / period) - 1)), low, high)


def since_turn(t, period=8.0):
    """Seconds since F has begun to move after a turn, and its way."""
    return (t - 0.3) % (period / 2), np.where((t - 0.3) % period < period / 2, 1, -1)


NOISE = bins.Readings(0.004, 0.0)


@pytest.mark.parametrize("cause, error", [
    (unexplained.BACKLASH, lambda t, F: -0.3 * since_turn(t)[1] * (since_turn(t)[0] < 0.15)),
    (unexplained.BUILDS_UP, lambda t, F: 0.3 * since_turn(t)[1] * (since_turn(t)[0] < 0.15)),
    (unexplained.POSITION, lambda t, F: 0.2 * np.sin(2 * np.pi * F / 3)),
    (unexplained.LOAD, lambda t, F: 0.1 * np.sin(2 * np.pi * (F - 2) / 12) * since_turn(t)[1]),
    (unexplained.TIME, lambda t, F: 0.01 * (t - 20)),
])
def test_what_is_left_is_named_by_what_it_goes_with(cause, error):
    t, F = force_of()
    readings = F + error(t, F) + NOISE.noise * np.random.default_rng(38).normal(size=len(t))
    left = unexplained.of(Segment("log", t, F, readings, h=H), F, NOISE, LEVEL)
    assert left.causes[0][0] == cause and left.causes[0][1] > 0.5
    assert left.rms == pytest.approx(np.std(error(t, F)), rel=0.25)


def test_noise_and_steps_alone_leave_nothing():
    t, F = force_of()
    for own in (NOISE, bins.Readings(0.003, 0.2), bins.Readings(0.05, 0.05)):
        y = F + own.noise * np.random.default_rng(3).normal(size=len(t))
        y = np.round(y / own.step) * own.step if own.step else y
        left = unexplained.of(Segment("log", t, F, y, h=H), F, own, LEVEL)
        assert left.rms < 0.3 * own.averaged(20), own


@pytest.mark.parametrize("clipped", [False, True])
def test_a_force_that_stays_within_a_step_is_not_saturated_and_a_clipped_one_is(clipped):
    """F goes on within its largest reading while u goes on; a clipped one stands while u goes on by much more."""
    t = np.arange(0, 40, H)
    u = 1 + 15.2 * (1 - np.abs(2 * (t % 8 / 8) - 1))
    F = np.minimum(list(itertools.accumulate(u, lambda F, now: min(max(F, now - 0.5), now + 0.5), initial=0.5)), 10.0 if clipped else 99.0)[1:]
    y = np.round(F / 1.5) * 1.5
    assert events.saturated(Segment("log", t, u + 0.01 * np.sin(50 * t), y, h=H)).any() == clipped


def cogged(amplitude, phase=0.3, period=2.5, force_noise=0.004):
    """A log of slides under Coulomb friction, of which u makes F, and whose motor cogs."""
    corners = np.array([2, 6, 3, 9, 5, 13, 7, 14, 4, 12, 2, 13, 3, 11, 2, 14, 2.0])
    t = np.arange(0, 4.0 * (len(corners) - 1), H)
    F = np.interp(t, 4.0 * np.arange(len(corners)), corners)
    way = np.sign(np.gradient(F))
    u = F + way * (0.4 + 0.12 * F) - amplitude * np.sin(2 * np.pi * (F / period + phase))
    return Log([Segment("log", t, u, F + force_noise * np.random.default_rng(5).normal(size=len(t)), h=H)], H)


@pytest.mark.parametrize("amplitude", [0.05, 0.15, 0.5])
def test_cogging_is_found_with_its_period_and_phase(amplitude):
    log = cogged(amplitude)
    made = experiments.Experiment("2-slides", log.segments[0].t, log.segments[0].u, experiments.REST_S)
    played, slow, line, found = results._without_cogging(log, made, "symmetric")
    p = line.law()
    assert (p["scale"], p["offset"], p["slope"]) == pytest.approx((1.0, 0.4, 0.12), rel=0.03)
    assert found.amplitude == pytest.approx(amplitude, rel=0.1) and found.period == pytest.approx(2.5, rel=0.005)
    force = np.linspace(3, 13, 200)
    assert np.abs(found.at(force) - amplitude * np.sin(2 * np.pi * (force / 2.5 + 0.3))).max() < 0.3 * amplitude
    assert found.keys()["ripple"].keys() == {"amplitude_N", "period_deg", "phase"}


def test_a_rig_that_does_not_cog_has_none():
    for log in (cogged(0.0), cogged(0.0, force_noise=0.05), cogged(0.005)):
        assert cogging.find(log, slides.line(log, "symmetric")) is None
    assert cogging.find(cogged(0.1), None) is None


def runs(off, on):
    return {"off": [accept.Played(x, 1.0) for x in off], "on": [accept.Played(x, 1.0) for x in on]}


def test_the_range_of_a_prediction_has_what_the_law_leaves():
    sure = accept.expected(runs((0.9, 1.0, 1.1), (0.2, 0.2, 0.2)), 0.0)
    assert (sure.off, sure.on) == (1.0, 0.2) and sure.factors == pytest.approx((5.0, 0.9 * 4.5, 1.1 * 5.5))
    unsure = accept.expected(runs((0.9, 1.0, 1.1), (0.2, 0.2, 0.2)), 0.1)
    assert unsure.on == pytest.approx(np.hypot(0.2, 0.1)) and unsure.factors[0] == pytest.approx(np.hypot(1.0, 0.1) / np.hypot(0.2, 0.1))
    assert unsure.factors[1] == pytest.approx(0.9 * 0.9 / 0.4) and unsure.factors[2] == pytest.approx(1.1 * 1.2 / 0.1)


def test_what_a_loop_leaves_of_a_disturbance_is_what_it_leaves_of_a_reference(whole_way):  # noqa: F811
    """Slow ones next to nothing, fast ones all; by the arithmetic of the loop itself, as tribo-sim plays it."""
    loop = accept.load(whole_way[1] / "result/loop.yaml")
    size = 1e-3 * loop["limits"]["u_max_N"]
    h = bins.bin_size(loop["sample_time_s"]) * loop["sample_time_s"]
    t = np.arange(0, 30, h)
    slow, fast = (accept.echo(loop, size * np.sin(2 * np.pi * t / period), h) / (size / 2**0.5) for period in (20.0, 4 * h))
    assert slow < 0.1 and 0.5 < fast < 2.0
    assert accept.echo(loop, 2 * size * np.sin(2 * np.pi * t / 20), h) == pytest.approx(2 * slow * size / 2**0.5, rel=0.01)
    assert accept.echo(loop, np.zeros(100), h) == 0.0


def test_a_command_in_the_drives_unit_is_recognised(whole_way):  # noqa: F811
    """In ampere, with a sign, next to a bias; and what is no command of this loop is not taken for one."""
    loop, source = accept.load(whole_way[1] / "result/loop.yaml"), np.random.default_rng(38)
    t = np.arange(0, 30, loop["sample_time_s"])
    low, high = loop["reference"]["low_N"], loop["reference"]["high_N"]
    r = low + (high - low) * (1 - np.abs(2 * (t % 10 / 10) - 1))
    y = r * 0.98 + 0.01 * high * np.sin(t) + 1e-4 * high * source.normal(size=len(t))
    path = whole_way[1] / "unit.yaml"
    path.write_text(accept.yaml_text(accept.case_of(loop, "off", low, high)))
    u = accept.tribo.Loop(path).steps(r, y)
    for unit, bias in ((1.0, 0.0), (0.05, 0.0), (-20.0, 3.0), (0.94, 0.0)):
        segment = Segment("off", t, unit * u + bias, y, reference=r, h=loop["sample_time_s"])
        assert accept.unit_of(loop, segment) == (pytest.approx(unit, rel=1e-3), pytest.approx(np.sign(unit), abs=1e-3))
        turned, said = accept.in_newton(loop, {"off": segment})
        assert np.ptp(turned["off"].u) == pytest.approx(np.ptp(u), rel=2e-2) and bool(said) == (unit != 1.0)
        assert all(f"{unit:.4g} of the drive's units per newton" in line for line in said)
    segment = Segment("off", t, high * np.sin(3 * t), y, reference=r, h=loop["sample_time_s"])
    same, said = accept.in_newton(loop, {"off": segment})
    assert same["off"] is segment and "differs from the u that this loop computes from r and F" in said[0]


LAW = {"off": 1.0, "on": 0.2, "less": 0.4, "more": 0.4}


def ruled(left=0.01, echo=0.0, **changed):
    measured = {case: accept.Played(rms, 1.0) for case, rms in {**LAW, **changed}.items()}
    predicted = {case: [accept.Played(rms, 1.0)] * 3 for case, rms in LAW.items()}
    return accept.rule(measured, predicted, left, 1.0, echo)[1]


def test_a_loop_within_what_is_unexplained_is_accepted_and_one_that_does_not_help_never():
    assert ruled() == [] and ruled(on=0.22) == []
    assert "the error is divided by only 3.85" in ruled(on=0.26)[0] and ruled(on=0.26, echo=0.05) == []
    against = ruled(on=1.02, echo=1.0)
    assert against == ["compensation does not help: the error is 1.02 times that without it"]
    assert "the parameters are not this rig's" in ruled(left=0.11)[0]


def test_a_sensor_in_steps_goes_the_whole_way(tmp_path):
    """Steps of a quarter of breakaway and hardly any noise: the prediction has them, they are named, and they are not taken for chatter."""
    rig, folder = lab.RIGS["steps"], tmp_path / "rig"
    code, said = lab.go(rig, folder)
    assert code == 0 and "sensor: it reads in steps of 0.375 N" in said and "friction falls" not in said, said
    verdicts, _ = lab.accepted(rig, folder)
    factor, (likely, least, most) = lab.played(verdicts, folder)
    assert least <= factor <= most and abs(likely / factor - 1) < 0.1 and most < 1.6 * least
    assert {case: not against for case, (_, _, against) in verdicts.items()} == {case: takes for case, (_, takes) in lab.OTHERS.items()}
    assert "u: the log has 0.05 of the drive's units per newton of the loop's u" in verdicts["logged in the drive's unit"][1][0]
