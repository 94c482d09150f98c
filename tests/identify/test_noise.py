"""Noise of F and steps of u are named for what they are, and for nothing that friction does. The rigs are of strange.c, which shares no line with the project."""

import re

import numpy as np
import pytest
import strange
from test_rows import log_of, played, rig_of

from tribo_identify import events, friction, noise, rows, slides
from tribo_identify.refusal import Refusal

CONSTANT = (0, 2, 3)  # laws whose friction does not fall once it slides


def in_steps(table, step):
    return np.c_[table[:, 0], np.round(table[:, 1] / step) * step, table[:, 2]]


def fall_of(table):
    log = log_of(table)
    return slides.fall(log, slides.line(log, "symmetric"))


@pytest.mark.parametrize("rms", [0.3, 0.5, 1.0])
@pytest.mark.parametrize("law", CONSTANT)
def test_noise_is_no_friction_that_falls(law, rms):
    share, half = fall_of(strange.play(rig_of(law), noise=rms))
    assert share <= friction.FALL + half


@pytest.mark.parametrize("step", [0.3, 0.6, 1.2])
@pytest.mark.parametrize("law", CONSTANT)
def test_steps_of_u_are_no_friction_that_falls(law, step):
    share, half = fall_of(in_steps(played(law), step))
    assert share <= friction.FALL + half


@pytest.mark.parametrize("part", [0.0, 0.03])
def test_friction_that_falls_is_found_in_noise(part):
    rig = strange.rig_of(9)
    share, half = fall_of(strange.play(rig, noise=part * (rig["offset"] + 0.5 * rig["slope"] * rig["high"])))
    assert share > friction.FALL + half and share < 1 / rig["sliding"] - 1 + half


def right(rig, text):
    """Is L in the middle of the loads as right as is said?"""
    offset, slope, _ = strange.estimates(text)
    low, high, within = map(float, re.search(r"at F from (\S+) to (\S+) N; L in the middle of this range is known within (\S+) %", text).groups())
    middle = (low + high) / 2
    return abs((offset + slope * middle) / (rig["offset"] + rig["slope"] * middle) - 1) <= 1.5 * within / 100


@pytest.mark.parametrize("what", ["noise", "steps"])
def test_the_fit_stands_and_says_what_widens_it(what):
    rig = rig_of(0)
    code, text = strange.call(strange.play(rig, noise=0.3) if what == "noise" else in_steps(played(0), 0.6))
    assert code == 0 and re.search(r"F has noise of 0\.0[67]\d* N rms in averages over 20 ms, \S+ % of breakaway" if what == "noise" else r"u is logged in steps of 0\.[56]\d* N", text), text
    assert not strange.named(text) & {"falls", "law", "pattern", "time", "clock"}, text
    assert right(rig, text), text


def test_noise_that_hides_friction_is_named_and_not_that_there_is_none():
    log = log_of(strange.play(rig_of(0) | {"offset": 0.1, "slope": 0.01}, noise=1.0))
    line = slides.line(log, "symmetric")
    with pytest.raises(Refusal, match=r"^noise: F has noise of 0\.2\d* N rms in averages over 20 ms, .* it hides up to \S+ N$"):
        friction._hidden(log, line, 0.2, 0.3)
    friction._hidden(log, line, 0.02, 0.03)  # less than matters


def test_a_coarse_sensor_that_flickers_has_no_readings_that_are_none():
    rig = strange.rig_of(8000)
    table = strange.play(rig, step=0.6 * (rig["offset"] + 0.5 * rig["slope"] * rig["high"]))
    assert not rows.spikes(table[:, 2]).any()
    table[1000, 2] += 20 * rig["high"]
    assert list(np.flatnonzero(rows.spikes(table[:, 2]))) == [1000]


def test_friction_that_is_lost_in_noise_is_no_clock_fault():
    rig = strange.rig_of(8000)
    code, text = strange.call(strange.play(rig, noise=2 * (rig["offset"] + 0.5 * rig["slope"] * rig["high"])))
    assert code == 3 and "noise: F has noise of" in text and "clock" not in text, text


def test_noise_of_u_is_named():
    """The model takes it as commanded."""
    rig = rig_of(0)
    table = played(0) + np.c_[np.zeros(len(played(0))), np.random.default_rng(1).normal(0, 0.8, len(played(0))), np.zeros(len(played(0)))]
    code, text = strange.call(table)
    assert re.search(r"u has noise of 0\.[78]\d* N rms from row to row, \S+ % of breakaway\. Log the command that the drive gets", text), text
    assert not strange.named(text) & {"falls", "law", "clock", "pattern", "time"} and (code == 3 or right(rig, text) or not strange.estimates(text)[2]), text


def test_a_command_that_is_held_is_in_no_steps():
    assert noise.rounding_of(played(0)[np.arange(len(played(0))) // 200 * 200, 1]) == 0
    assert noise.rounding_of(in_steps(played(0), 0.6)[:, 1]) == pytest.approx(0.6 / np.sqrt(12), rel=0.1)
    assert noise.rounding_of(played(0)[:, 1]) == 0


def test_noise_beyond_all_changes_is_named_and_no_silent_sensor():
    rig = rig_of(0)
    with pytest.raises(Refusal, match=r"^noise: F has noise of \S+ N rms in averages over 20 ms, and changes by \S+ N in all"):
        events.check(log_of(strange.play(rig, noise=8.0)))
    table = played(0).copy()
    table[:, 2] = np.random.default_rng(1).normal(0, 1.0, len(table))
    with pytest.raises(Refusal, match="^the force sensor is silent"):
        events.check(log_of(table))
