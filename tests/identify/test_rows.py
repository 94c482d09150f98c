"""What tribo-identify says of spoilt logs of a foreign simulator, before it fits anything; and that its advice, followed, leads to an answer. The whole study is strange.py."""

import functools
import itertools
import re

import numpy as np
import pytest
import strange
import synthetic

from tribo_identify import events, friction, residual, rows, slides
from tribo_identify.refusal import Refusal

# Those that a look at rows and slides tells.
EARLY = ("wrap of F", "wrap of u", "no sign of F", "no sign of u", "many spikes", "a converter of 10 a second", "F held in the log", "columns exchanged", "F turned", "u turned", "ampere", "millinewton",
         "counts", "F clipped", "u clipped", "F early", "F late", "ms for s", "s for ms", "stamps begin anew", "stamps twice", "F is constant", "u is constant")


def rig_of(law):
    return strange.rig_of(400 + law, both=False) | {"h": 1e-3, "high": 20.0, "offset": 0.4, "slope": 0.12, "noise": 0.005, "step": 0.005, "bias": 0.0}


@functools.cache
def played(law, both=False):
    return strange.play(rig_of(law) | {"both": both})


def log_of(table):
    log = synthetic.log_of(table)
    log.segments, log.remarks = rows.mended(log.segments)
    return log


@pytest.mark.parametrize("what", EARLY)
def test_a_spoilt_log_is_refused_for_what_it_has(what):
    rig = rig_of(0)
    spoilt, options = strange.spoilt(rig, what)
    code, text = strange.call(spoilt, options)
    assert code != 0 and strange.judge_spoilt(rig, what, code, text) == "right", text


def test_a_late_force_of_few_sure_slides_is_named_after_the_fit_as_well():
    rig = strange.rig_of(24)
    code, text = strange.call(*strange.spoilt(rig, "F late"))
    assert code != 0 and re.search(r"clock: F comes 0\.4\d* s after u", text), text


def test_a_late_force_whose_slides_show_no_friction_is_named_for_its_clock():
    rig = strange.rig_of(6024)
    code, text = strange.call(*strange.spoilt(rig, "F late"))
    assert code == 3 and strange.judge_spoilt(rig, "F late", code, text) == "right", text


def test_stamps_in_ms_of_rows_each_0_1_ms_are_named_although_0_1_s_is_a_sample_time():
    rig = strange.rig_of(27)
    code, text = strange.call(*strange.spoilt(rig, "s for ms"))
    assert code != 0 and "its stamps are in ms: --unit t=ms" in text, text


def level_of(rig):
    return rig["offset"] + 0.5 * rig["slope"] * rig["high"]


@pytest.mark.parametrize("law", range(4))
def test_the_residual_of_a_sound_log_shows_nothing(law):
    assert not residual.shows(log_of(played(law)), "symmetric", level_of(rig_of(law)))


SHOWN = {"warms up": "friction changes with time: it is", "drifts": "F drifts: in both directions it is", "cogging": "there is a pattern over force, the same upwards and downwards, of"}


@pytest.mark.parametrize("what", SHOWN)
def test_the_residual_shows_what_changes(what):
    rig = rig_of(0)
    found = residual.shows(log_of(strange.spoilt(rig, what)[0]), "symmetric", level_of(rig))
    assert found and found[0].startswith(SHOWN[what]), found


def test_a_pattern_is_found_with_its_size_and_period():
    rig = rig_of(0)
    text = residual.shows(log_of(strange.spoilt(rig, "cogging")[0]), "symmetric", level_of(rig))[0]
    assert float(text.split("periods of ")[1].split()[0]) == pytest.approx(0.13 * rig["high"], rel=0.05)
    assert float(text.split(", of ")[1].split()[0]) == pytest.approx(0.25 * level_of(rig), rel=0.4)


@pytest.mark.parametrize("seed", (1009, 1013, 1025))  # sliding has less friction, and few rows are slow
def test_cogging_is_found_along_with_falling_friction(seed):
    rig = strange.rig_of(seed)
    text = residual.shows(log_of(strange.spoilt(rig, "cogging")[0]), "symmetric", level_of(rig))[0]
    assert float(text.split("periods of ")[1].split()[0]) == pytest.approx(0.13 * rig["high"], rel=0.03), text


def test_a_zero_that_steps_is_named_before_the_pattern_that_it_makes():
    log = log_of(played(0) + np.c_[np.zeros((len(played(0)), 2)), np.where(np.arange(len(played(0))) > len(played(0)) / 3, 3.0, 0.0)])
    assert residual.shows(log, "symmetric", level_of(rig_of(0)))[0].startswith(SHOWN["drifts"])


def test_the_same_column_for_u_and_F_is_named():
    code, text = strange.call(played(0)[:, [0, 2, 2]])
    assert code == 3 and "F is u, row for row: it is the same column" in text, text


@pytest.mark.parametrize("law", range(4))
def test_the_lag_at_the_turns_is_the_rigs(law):
    """Whatever the friction. The other column, the other sign and another clock are seen by it."""
    rig, log = rig_of(law), log_of(played(law))
    lag, share = rows.lag_at_turns(log)
    lags = rig["drive"] + rig["sensor"] + 2 * rig["z"] / rig["w"] + rig["delay"] * rig["h"] + rig["viscous"] / (rig["m"] * rig["w"] ** 2)
    assert share > 0.9 and lag == pytest.approx(lags, abs=0.03)
    assert rows.lag_at_turns(rows.turned(log))[1] < 0.85
    for seconds in (-0.3, 0.4):
        there, _ = rows.lag_at_turns(log_of(strange.late(played(law), rig, seconds)))
        assert there == pytest.approx(lag + seconds, abs=0.02)


def test_readings_that_are_none_count_as_their_neighbours():
    rig, sound = rig_of(0), played(0)
    spoilt = strange.spoilt(rig, "spikes of 0xFFFF")[0]
    log = log_of(spoilt)
    bad = np.flatnonzero(spoilt[:, 2] != sound[:, 2])
    assert len(bad) > 10 and np.max(np.abs(log.segments[0].force - sound[:, 2])) < 0.5
    assert f"{len(bad)} rows of F are off for a row or two, by up to 32" in log.remarks[0]
    assert not log_of(sound).remarks


def test_a_stretch_that_repeats_is_left_out():
    rig = rig_of(0)
    log = log_of(strange.spoilt(rig, "the bus is dead")[0])
    assert len(log.segments) == 2 and "F stands for 30" in log.remarks[0]
    line, sound = (slides.line(one, "symmetric") for one in (log, log_of(played(0))))
    assert line.values["slope"] == pytest.approx(sound.values["slope"], rel=0.02)


def test_a_jump_says_row_and_size():
    spoilt = played(0).copy()
    spoilt[20_000:, 2] += 9.0
    with pytest.raises(Refusal, match=r"^jumps: F jumps by [89]\.\d* N from one row to the next, once, from row 20000 \(.* N, 19.999 s\) to the next \(.* N\), and u does not: its zero or its range was changed"):
        events.check(log_of(spoilt))


def test_a_step_of_u_is_no_jump():
    """F follows it."""
    t = np.arange(0, 40, 1e-3)
    u = np.repeat([2.0, 8.0, 3.0, 9.0, 1.0, 7.0, 2.0, 6.0], 5000)
    force = np.convolve(u, np.exp(-np.arange(100) / 15) / 15.5)[: len(u)] + np.random.default_rng(1).normal(0, 0.01, len(u))
    rows.check_jumps(synthetic.log_of(np.c_[t, u, force]))


ADVICE = {"columns exchanged": ("--column u=", ["--column", "u=force", "--column", "F=cmd"]), "ms for s": ("leave --unit t=ms out", []), "s for ms": ("--unit t=ms", ["--unit", "t=ms"]),
          "F turned": ("--scale F=-", ["--scale", "F=-"]), "u turned": ("--scale u=-", ["--scale", "u=-"]), "millinewton": ("--unit F=mN", ["--unit", "F=mN"]),
          "stamps twice": ("--resample", ["--resample"]), "ampere": ("--scale u=", None)}


@pytest.mark.parametrize("what", ADVICE)
def test_advice_that_is_followed_leads_to_no_other_refusal(what, monkeypatch):
    """Up to the fit, which a sound log passes."""
    fits = []
    monkeypatch.setattr(friction, "Fit", lambda *given: fits.append(given) or (_ for _ in ()).throw(Refusal("model", "fitted")))
    said, options = ADVICE[what]
    spoilt, wrong = strange.spoilt(rig_of(0), what)
    code, text = strange.call(spoilt, wrong)
    assert code != 0 and not fits and said in text, text
    options = ["--scale", "u=" + text.split("--scale u=")[1].split(",")[0].split(" ")[0].rstrip(").")] if options is None else options
    code, text = strange.call(spoilt, options)
    assert len(fits) == 1 and "fitted" in text, text


@pytest.mark.parametrize("times, said, not_said", [([1, 1, 1000], "--unit F=mN", "u=mN"), ([1, 1000, 1], "--unit u=mN", "F=mN"), ([1, 1, 60], "--scale u=", "mN"), ([1, 0.03, 1], "--scale u=", "mN")])
def test_only_the_unit_that_mends_it_is_named(times, said, not_said):
    with pytest.raises(Refusal, match="^units: ") as refusal:
        events.check(log_of(played(0) * times))
    assert said in str(refusal.value) and not_said not in str(refusal.value)
    factor = re.search(r"--scale u=(\S+) makes", str(refusal.value))[1]
    log = log_of(played(0) * times * {"--unit F=mN": [1, 1, 1e-3], "--unit u=mN": [1, 1e-3, 1], "--scale u=": [1, float(factor), 1]}[said])
    events.check(log)  # followed, it leads on


def limits_of(force, u):
    """Rows at a limit of F."""
    return np.mean(events.saturated(synthetic.log_of(np.c_[np.arange(len(u)) * 1e-3, u, force]).segments[0], "force"))


def to_and_fro(corners, friction, seconds=4.0):
    """u through its corners, and F behind it as sliding friction leaves it."""
    u = np.interp(np.arange(0, seconds * (len(corners) - 1), 1e-3), seconds * np.arange(len(corners)), corners)
    return u, np.array(list(itertools.accumulate(u, lambda F, now: min(max(F, now - friction), now + friction))))


COARSE = {"as read": lambda F: F, "resampled": lambda F: np.interp(np.arange(len(F)), np.arange(len(F)) + np.random.default_rng(2).uniform(-0.3, 0.3, len(F)), F),
          "averaged": lambda F: np.convolve(F, [0.25, 0.25, 0.25, 0.25], "same")}


@pytest.mark.parametrize("scale", [0.001, 0.3, 1.0, 1000.0])
@pytest.mark.parametrize("seen", COARSE)
@pytest.mark.parametrize("step", [0.5, 3.0, 6.0])
def test_the_largest_reading_of_a_coarse_sensor_is_no_limit(step, seen, scale):
    """u goes on by nearly a step before the sensor shows the next, in whatever unit u is, and whatever became of F since; a sensor that ends goes on for longer."""
    top = 6 * np.floor(40 / 6) + 2.9  # all but the next step of each
    u, F = to_and_fro([0, 30, 10, top + 2, 5, top + 1.5, 0, 20, 8, top + 2, 0], 2.0)
    F = F + 0.02 * np.random.default_rng(1).normal(size=len(F))
    read = lambda F: COARSE[seen](np.round(F / step) * step)
    assert limits_of(read(F), scale * u) == 0
    assert limits_of(read(np.minimum(F, 18.0)), scale * u) > 0.1


def test_a_force_that_has_overshot_to_its_largest_reading_is_at_no_limit():
    """Backlash: once F came there by an impact, when u was far below where it is when F slides there."""
    u, F = to_and_fro([0, 30, 10, 38, 5, 38, 0, 38, 0], 2.0)
    F = np.round(F / 0.25) * 0.25
    assert limits_of(F, u) == 0
    first = int(np.argmax(F >= 20))
    F[first : first + 3] = F.max()
    assert limits_of(F, u) == 0
    assert limits_of(np.minimum(F, 30.0), u) > 0.05


@pytest.mark.parametrize("part", [0.5, 1.0])
@pytest.mark.parametrize("law", range(4))
def test_many_levels_of_load_are_many(law, part):
    """Nine, whose slides are short beside the range of F; in the first half of the log, F goes back in short ones only."""
    rig = rig_of(law)
    plan = synthetic.plan_over(3.0, 20.0, noise=0.006, levels=9, offset=0.4, slope=0.12, sample_time_s=1e-3)
    table = strange.play(rig, plan=plan)
    log = log_of(table[: int(part * len(table))])
    assert events.loads(slides.spans(log))[1] >= 4
    line = slides.line(log, "symmetric")
    assert line.is_sure() and line.values["slope"] == pytest.approx(rig["sliding"] * 0.12, rel=0.1)


def test_no_stiction_is_an_answer(monkeypatch):
    """Viscous friction alone; and little friction, which is not none."""
    rig = rig_of(0) | {"offset": 1e-9, "slope": 0.0}
    with pytest.raises(Refusal, match="^no stiction found: F follows u both ways with a lag of .*There is nothing to compensate"):
        friction.identify(log_of(strange.play(rig, plan=synthetic.plan_over(3.0, 20.0, noise=0.006, offset=0.4, slope=0.05, sample_time_s=1e-3))))
    monkeypatch.setattr(friction, "Fit", lambda *given: (_ for _ in ()).throw(Refusal("model", "fitted")))
    with pytest.raises(Refusal, match="fitted"):
        friction.identify(log_of(strange.play(rig | {"offset": 0.2}, plan=synthetic.plan_over(3.0, 20.0, noise=0.006, offset=0.2, slope=0.01, sample_time_s=1e-3))))


def test_the_middle_of_negative_forces_has_friction_of_their_size():
    """Half of the interval was 1.8e12 % of an L that was below 0."""
    from types import SimpleNamespace

    from tribo_identify.friction import _relative_half

    half = _relative_half(SimpleNamespace(table_at=None), ["offset", "slope"], [0.6, 0.1], np.random.default_rng(1).normal(0, [0.01, 0.0], (999, 2)), [(-16.8, -0.4)])
    assert half == pytest.approx(1.96 * 0.01 / 1.46, rel=0.1)
