"""Noise and steps of a sensor, from its readings alone."""

import numpy as np
import pytest

from tribo_identify import bins

RAMPS = {"slow": (2.0, 1e-3), "fast": (10.0, 5e-4)}  # N/s, s


def readings(ramp, noise, step, digits=7):
    """20 s of a ramp up and down over 5 N, as a log has it."""
    rate, h = RAMPS[ramp]
    y = 5 * np.abs(np.arange(0, 20, h) * rate / 5 % 2 - 1) + noise * np.random.default_rng(38).normal(size=int(20 / h))
    y = np.round(y / step) * step if step else y
    return np.array([float(f"{v:.{digits}g}") for v in y])


@pytest.mark.parametrize("ramp", RAMPS)
@pytest.mark.parametrize("step", [0.0, 0.01, 0.05, 0.2, 0.5])
@pytest.mark.parametrize("noise", [0.001, 0.01, 0.05, 0.2])
def test_noise_and_steps_are_distinguished(ramp, noise, step):
    """Noise within a fifth where it is a quarter of a step or more, within two fifths to a fifteenth if the ramp stays at each step for
    ten rows; below that it is little. Both together are never none."""
    found = bins.readings_of(readings(ramp, noise, step))
    assert found.step == pytest.approx(step, rel=0.01)
    rate, h = RAMPS[ramp]
    if noise >= step / 4 or noise >= step / 15 and step >= 10 * rate * h:
        assert found.noise == pytest.approx(noise, rel=0.2 if noise >= step / 4 else 0.4)
        assert found.rms == pytest.approx(np.hypot(noise, step / 12**0.5), rel=0.1)
    else:
        assert found.noise <= 1.4 * noise and found.rms >= 0.95 * step / 12**0.5


def test_steps_of_a_converter_that_a_log_rounds_again_are_seen():
    """0.0123 N a count, written with three digits after the point."""
    y = np.round(readings("slow", 0.02, 0.0) / 0.0123) * 0.0123
    found = bins.readings_of(np.round(y, 3))
    assert found.step == pytest.approx(0.0123, abs=0.001) and found.noise == pytest.approx(0.02, rel=0.1)


def test_breaking_away_is_no_noise():
    """A force that stays and jumps, read in coarse steps without noise."""
    y = np.round(np.repeat(np.random.default_rng(1).uniform(0, 10, 40), 500) / 0.2) * 0.2
    assert bins.readings_of(y).noise < 0.03


def test_what_averages_keep_of_the_steps():
    """Noise of a step and more averages them out; without noise a slow force keeps all of their error."""
    assert bins.Readings(0.0, 0.1).averaged(20) == pytest.approx(0.1 / 12**0.5, rel=0.03)
    assert bins.Readings(0.1, 0.1).averaged(20) == pytest.approx(np.hypot(0.1, 0.1 / 12**0.5) / 20**0.5, rel=1e-3)
    for noise in (0.01, 0.02, 0.04, 0.1):
        x = np.linspace(0, 3, 40_000) + noise * np.random.default_rng(2).normal(size=40_000)
        left = bins.binned(np.round(x / 0.1) * 0.1, 20) - bins.binned(np.linspace(0, 3, 40_000), 20)
        assert bins.Readings(noise, 0.1).averaged(20) == pytest.approx(np.std(left), rel=0.15)


def test_what_is_beyond_the_sensor_is_left():
    source, own = np.random.default_rng(3), bins.Readings(0.02, 0.0)
    noise, more = own.averaged(20) * source.normal(size=5000), 0.05 * np.sin(np.arange(5000) / 7)
    assert np.std(bins.beyond(noise, own, 20)) < 0.3 * np.std(noise)
    assert np.std(bins.beyond(noise + more, own, 20)) == pytest.approx(np.std(more), rel=0.05)
    assert not np.any(bins.beyond(np.zeros(10), own, 20))
