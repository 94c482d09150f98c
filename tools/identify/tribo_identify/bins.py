"""Averages of a signal, and the noise in it."""

from dataclasses import dataclass

import numpy as np

BIN_S = 0.02  # length of an average


def bin_size(h):
    return max(int(round(BIN_S / h)), 1)


def binned(x, size):
    return x[: len(x) // size * size].reshape(-1, size).mean(1)


def noise_of(averages):
    """Returns the noise of the averages, a standard deviation, from their second differences."""
    return float(np.median(np.abs(np.diff(averages, 2))) / (0.6745 * np.sqrt(6))) if len(averages) > 2 else 0.0


FEW = 0.5  # of the rows: with more distinct values than this the readings have no steps
DITHERED = 0.14  # times the step squared: variance of the readings if their noise is a quarter of a step


@dataclass
class Readings:
    """The errors that a sensor adds to a force: white noise, then rounding to steps."""

    noise: float  # standard deviation before the steps, N
    step: float  # between two readings, N; 0 if none was seen

    @property
    def rms(self):
        """Error of noise and steps together."""
        return float(np.hypot(self.noise, self.step / np.sqrt(12)))

    @property
    def rounding(self):
        """Variance of rounding that averaging does not remove: all of it without noise, none if the noise carries the readings over the steps."""
        if self.step == 0:
            return 0.0
        waves = np.pi * np.arange(1, 20)  # harmonics of the sawtooth that rounding adds
        return float(np.sum(self.step**2 / (2 * waves**2) * np.exp(-((2 * waves * self.noise / self.step) ** 2))))

    @property
    def coarse(self):
        """The part of the step that no noise averages out, N."""
        return float(np.sqrt(12 * self.rounding))

    @property
    def worst(self):
        """Error of both, rms, if F rests half a step off."""
        return float(np.sqrt(self.rms**2 + 2 * self.rounding))

    def averaged(self, size):
        """Error of both in averages over `size` rows, rms."""
        return float(np.sqrt((self.rms**2 - self.rounding) / size + self.rounding))


def step_of(y):
    """Returns the median distance between neighbouring values of y, or 0 if values hardly repeat."""
    values = np.unique(y)
    if len(values) < 3 or len(values) > FEW * len(y):
        return 0.0
    return float(np.median(np.diff(values)))


def readings_of(y):
    """Returns noise and steps of a sensor, from the second differences of its readings.

    Noise above two steps shows in the median second difference, whatever else is in the log. With less noise many rows repeat the last one and the median is 0.
    Then the mean is used, less the second differences of a staircase, as long as noise does not blur them. Noise n far below a step q makes readings flicker only
    next to a threshold, with the variance q n / sqrt(pi) on average; above a quarter of a step the variance is that of noise and rounding, n^2 + q^2 / 12."""
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


OWN = 1.1  # times the variance of noise and steps is still explained by them


def beyond(left, readings, size):
    """Returns the residual `left`, in averages over `size` rows, less the part due to the sensor's noise and steps. F may rest half a step off for long."""
    left = np.sign(left) * np.maximum(np.abs(left) - np.sqrt(3 * readings.rounding), 0.0)
    share = 1 - OWN * (readings.rms**2 - readings.rounding) / size / max(float(np.mean(left**2)), 1e-300)
    return max(share, 0.0) ** 0.5 * left
