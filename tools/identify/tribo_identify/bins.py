"""Averages of a signal, and the noise in it."""

from dataclasses import dataclass

import numpy as np

BIN_S = 0.02  # over which signals are averaged


def bin_size(h):
    return max(int(round(BIN_S / h)), 1)


def binned(x, size):
    return x[: len(x) // size * size].reshape(-1, size).mean(1)


def noise_of(averages):
    """Standard deviation, from how they bend."""
    return float(np.median(np.abs(np.diff(averages, 2))) / (0.6745 * np.sqrt(6))) if len(averages) > 2 else 0.0


FEW = 0.5  # of the rows: with more distinct values than that a reading has no steps
DITHERED = 0.14  # of a step squared: the variance of readings whose noise is a quarter of a step


@dataclass
class Readings:
    """What a sensor adds to a force: white noise, then steps."""

    noise: float  # standard deviation before the steps, N
    step: float  # between two readings, N; 0: none seen

    @property
    def rms(self):
        """Of both."""
        return float(np.hypot(self.noise, self.step / np.sqrt(12)))

    @property
    def rounding(self):
        """Variance of rounding that no average takes out: all of it without noise, none where noise carries the readings over the steps."""
        if self.step == 0:
            return 0.0
        waves = np.pi * np.arange(1, 20)  # of the sawtooth that rounding adds
        return float(np.sum(self.step**2 / (2 * waves**2) * np.exp(-((2 * waves * self.noise / self.step) ** 2))))

    @property
    def coarse(self):
        """The steps, as far as no noise carries the readings over them, N."""
        return float(np.sqrt(12 * self.rounding))

    @property
    def worst(self):
        """Of both, rms, where F rests half a step off."""
        return float(np.sqrt(self.rms**2 + 2 * self.rounding))

    def averaged(self, size):
        """Of both in averages over `size` rows, rms."""
        return float(np.sqrt((self.rms**2 - self.rounding) / size + self.rounding))


def step_of(y):
    """The usual distance between neighbouring values of y, 0 where values hardly repeat."""
    values = np.unique(y)
    if len(values) < 3 or len(values) > FEW * len(y):
        return 0.0
    return float(np.median(np.diff(values)))


def readings_of(y):
    """Noise and steps of a sensor, from how its readings bend.

    Noise above two steps shows in the median bend, whatever else is in the log. Below them many rows repeat the last one and the median is 0: there the mean counts,
    less, until noise blurs them, the bends of a staircase. A noise n far below a step q makes readings flicker next to a threshold only, with the variance q n / sqrt(pi) on
    average; above a quarter of a step the variance is that of noise and rounding, n^2 + q^2 / 12."""
    step, bend = step_of(y), np.diff(y, 2)
    if len(bend) == 0:
        return Readings(0.0, step)
    white = float(np.median(np.abs(bend)) / (0.6745 * np.sqrt(6)))
    if white >= 2 * step:
        return Readings(max(white**2 - step**2 / 12, 0.0) ** 0.5, step)
    smooth = binned(y, 20)
    rate = np.abs(np.diff(smooth)).sum() / max(20 * (len(smooth) - 1), 1)  # N a row
    staircase = min(2 * step * rate, step**2 / 2)
    variance = np.mean(np.minimum(np.abs(bend), 8 * step) ** 2) / 6
    flickers = max(variance - staircase / 6, 0.0)
    return Readings(float(np.sqrt(np.pi) * flickers / step if flickers < DITHERED * step**2 else (variance - step**2 / 12) ** 0.5), step)


OWN = 1.1  # times the variance that noise and steps alone leave


def beyond(left, readings, size):
    """What a model leaves of averages over `size` rows, without the part that the sensor's noise and steps make. F may rest half a step off for long."""
    left = np.sign(left) * np.maximum(np.abs(left) - np.sqrt(3 * readings.rounding), 0.0)
    share = 1 - OWN * (readings.rms**2 - readings.rounding) / size / max(float(np.mean(left**2)), 1e-300)
    return max(share, 0.0) ** 0.5 * left
