"""The residual of the best law of friction in a log beyond noise and steps of the sensor: its size, what it follows, and its effect in the loop."""

from dataclasses import dataclass

import numpy as np

from tribo_identify import accept, bins, slides

NAMED = 0.3  # fraction of the residual: a cause that explains less is not named
CLASSES = 24  # of force, and of time
ALIKE = 5  # averages in a row that tell no more than one
LEAST = 0.05  # of breakaway: F that goes back by less has not turned
BACKLASH = "reversals of F, after which F stays longer than by the law: backlash, or a joint with play"
BUILDS_UP = "reversals of F, after which F comes sooner than by the law: friction that builds up, or a soft part between motor and sensor"
POSITION = "position, the same both ways: cogging, or a contact that bends"
LOAD = "force: friction over load is not a line"
TIME = "time: drift of the sensor, of the bias or of friction"


@dataclass
class Left:
    trace: np.ndarray  # N, averages over bins.BIN_S, without what noise and steps make of them
    h: float
    causes: list  # (what, share), the largest first

    @property
    def rms(self):
        return float(np.sqrt(np.mean(self.trace**2)))


def of(segment, model, readings, level):
    """`model` is F by the law, for each row of the segment; `level` is breakaway in the middle."""
    size = bins.bin_size(segment.h)
    error, force = bins.binned(segment.force - model, size), bins.binned(segment.force, size)
    left = Left(bins.beyond(error, readings, size), size * segment.h, [])
    if left.rms > 0:
        left.causes = _causes(error, force, level)
    return left


def _by_class(error, group):
    """Share of the squares that the means of classes explain, less the share by chance."""
    groups = np.unique(group, return_inverse=True)[1]
    count = np.bincount(groups)
    between = np.sum(np.bincount(groups, error) ** 2 / count) / max(float(np.sum(error**2)), 1e-300)
    chance = len(count) / max(len(error) / ALIKE, len(count) + 1)
    return max((between - chance) / (1 - chance), 0.0)


def _at_turns(error, turned):
    """Share of the squares in these rows beyond their share of the rows."""
    rows = float(np.mean(turned))
    return max((float(np.sum(error[turned] ** 2) / max(np.sum(error**2), 1e-300)) - rows) / max(1 - rows, 1e-3), 0.0)


def _causes(error, force, level):
    """The causes that the averages follow."""
    way, gone = np.zeros(len(force)), np.full(len(force), np.inf)
    for w, first, last in slides.turns(force, 10 * bins.noise_of(force) + LEAST * level):
        way[first : last + 1], gone[first : last + 1] = w, np.abs(force[first : last + 1] - force[first])
    turned = gone < level
    behind = float(np.sum((error * way)[turned])) < 0
    over = np.digitize(force, np.linspace(force.min(), force.max(), CLASSES)[1:-1])
    found = [(BACKLASH if behind else BUILDS_UP, _at_turns(error, turned)), (POSITION, _by_class(error, over)), (LOAD, _by_class(error * way, over)),
             (TIME, _by_class(error, np.arange(len(error)) * CLASSES // len(error)))]
    return sorted(((what, share) for what, share in found if share > NAMED), key=lambda f: -f[1])


def in_loop(loop, left):
    """The residual's effect on r - F, rms in N. It is played as a reference on the same plant without friction, because the loop treats both alike."""
    if left.rms == 0.0:
        return 0.0
    return accept.echo(loop, left.trace, left.h)
