"""Torque that depends on the motor's angle (cogging, the mesh of gears). Against a stiff contact the angle follows F, so the torque is a sine over F, the same both ways."""

from dataclasses import dataclass

import numpy as np

from tribo_identify import slides

PERIODS = (0.02, 0.5)  # fraction of the range of F in which the arm slides
TRIED = 400
SHARE = 0.5  # of what the line through the slides leaves: a sine that explains less is chance
LEAST = 0.02  # of breakaway


@dataclass
class Cogging:
    amplitude: float  # N
    period: float  # N of F
    phase: float  # at F = 0, in periods
    share: float  # of the variance that the slides' line leaves

    def at(self, force):
        return self.amplitude * np.sin(2 * np.pi * (force / self.period + self.phase))

    def keys(self):
        """The ripple keys of a scenario's plant whose arm moves by a degree per newton."""
        return {"ripple": {"amplitude_N": float(f"{self.amplitude:.6g}"), "period_deg": float(f"{self.period:.6g}"), "phase": float(f"{self.phase % 1.0:.6g}")}}


def _waves(force, period):
    angle = 2 * np.pi * force / period
    return np.c_[np.ones(len(force)), force, np.sin(angle), np.cos(angle)]


def find(log, line):
    """The cogging of a log, from its later slides, in which friction is fully built up; None if there is none."""
    if line is None:
        return None
    rows, p = slides.later(slides.runs_of(log), slides.PART), line.law()
    u, du, force, _, way = rows[:, :5].T
    left = force - (p["scale"] * (u - line.lag_s * du) + p["gravity"] - way * line.breakaway(force, way))
    left = left - np.median(left)
    keep = np.abs(left) <= 6 * np.median(np.abs(left)) + 1e-12
    left, force, way = left[keep], force[keep], way[keep]
    level = float(np.mean(line.breakaway(np.median(force), 1)))

    def fitted(period, rows):
        waves = _waves(force[rows], period)
        x = np.linalg.lstsq(waves, left[rows], rcond=None)[0]
        return x, float(np.sum((left[rows] - waves @ x) ** 2))

    every = np.ones(len(left), bool)
    tried = np.geomspace(*(part * np.ptp(force) for part in PERIODS), TRIED)
    period = min(tried, key=lambda t: fitted(t, every)[1])
    period = min(np.linspace(0.98, 1.02, 81) * period, key=lambda t: fitted(t, every)[1])
    x, rest = fitted(period, every)
    cogging = Cogging(float(np.hypot(*x[2:])), float(period), float(np.arctan2(x[3], x[2]) / (2 * np.pi)), 1 - rest / max(float(np.sum(left**2)), 1e-300))
    each = [np.hypot(*fitted(period, way == w)[0][2:]) for w in (1, -1)]
    alike = min(each) > 0.5 * max(each)
    return cogging if alike and cogging.share > SHARE and cogging.amplitude > LEAST * level else None
