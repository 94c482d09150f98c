"""Noise of F and of u, and the steps in which u is logged. Friction explains none of them, and each may look like friction."""

from dataclasses import dataclass

import numpy as np

from .bins import BIN_S, bin_size, binned, noise_of, readings_of

OWN = 1.1  # times the known noise is what a fit may leave by chance
MEDIAN = 0.6745  # median of the absolute deviation, in standard deviations
NAMED = {"force": 0.03, "rounding": 0.03, "u": 0.1}  # of breakaway: smaller values are not reported. The model takes changes of u from row to row as commanded
HIDES = 0.2  # of breakaway: this much noise hides friction
RANGE = 2e-3  # of the range of F: smaller noise hides nothing
QUIETER = "Find the source of the noise, or let the sensor's converter average"


@dataclass
class Noise:
    force: float  # of averages of F, N rms
    rounding: float  # error of u because it is logged in steps, N rms
    u: float  # of u from row to row, N rms

    @property
    def step(self):
        return np.sqrt(12) * self.rounding

    def beyond(self, rms, part=1.0):
        """Returns the part of `rms` beyond noise and rounding. `part` is the size of `rms` in standard deviations."""
        return max(rms**2 - (OWN * part * np.hypot(self.force, self.rounding)) ** 2, 0.0) ** 0.5

    def sentence(self, name, level):
        """Returns a sentence that compares `name` with breakaway and says what to do about it."""
        if name == "force":
            return f"F has noise of {self.force:.3g} N rms in averages over {1e3 * BIN_S:g} ms, {100 * self.force / level:.2g} % of breakaway. {QUIETER}"
        if name == "rounding":
            return f"u is logged in steps of {self.step:.3g} N, {100 * self.step / level:.2g} % of breakaway. Log the command with more digits if the drive receives it with more"
        return f"u has noise of {self.u:.3g} N rms from row to row, {100 * self.u / level:.2g} % of breakaway. Log the command that the drive gets, not a measured current"

    def says(self, level, times=1.0):
        """Returns a sentence for each value that is large compared with breakaway, the largest first."""
        found = {name: getattr(self, name) / (NAMED[name] * level) for name in NAMED}
        return [self.sentence(name, level) for name in sorted(found, key=found.get, reverse=True) if found[name] > times]

    def hides(self, level, span):
        """Returns a sentence if noise hides the friction, otherwise None."""
        largest = max(self.force, self.rounding)
        return (self.says(max(level, 1e-9 * span)) or [None])[0] if largest > max(HIDES * level, RANGE * span) else None


NONE = Noise(0.0, 0.0, 0.0)


def rounding_of(u):
    """Returns the error of u because it is logged in steps, N rms; 0 if its values lie on no grid, like those that a logger holds."""
    apart = np.diff(np.unique(u))
    if len(apart) < 2:
        return 0.0
    steps = apart / np.median(apart)
    return readings_of(u).coarse / np.sqrt(12) if np.mean(np.abs(steps - np.round(steps)) < 0.02) > 0.9 else 0.0


def of(log):
    size = bin_size(log.sample_time_s)
    forces, rounding, u = zip(*((noise_of(binned(s.force, size)), rounding_of(s.u), noise_of(s.u)) for s in log.segments))
    return Noise(max(forces), float(np.median(rounding)), max(u))
