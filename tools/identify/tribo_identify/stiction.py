"""Decides whether dry friction or a lag keeps F behind u, in a log whose slides all have about the same rate.

When u turns, an F behind a lag turns with it; an F behind friction stands until u has gone back by twice the friction. Mixtures of both with several shares are
simulated, and the share whose F is closest to the log's is taken as that of friction.
"""

from dataclasses import dataclass

import numpy as np

from . import slides

BIN_S = 0.002
SHARES = np.linspace(0, 1, 21)
LITTLE = 0.25  # of friction: an arm unlike two equal lags may appear to have this share


@dataclass
class Behind:
    force: float  # N, by which F is behind u while it slides
    rate: float  # of u there, N/s
    share: float  # of `force` that is friction

    def friction(self):
        return self.share * self.force

    def is_lag(self):
        return self.share <= LITTLE

    def text(self):
        return f"F follows u both ways and turns with it: the {self.force:.2g} N by which it is behind at {self.rate:.3g} N/s come from a lag of {1e3 * self.force / self.rate:.2g} ms"


def _played(u, h, friction, slope, lag, start):
    """Returns F for several shares side by side: behind a backlash of the friction's width and two equal lags."""
    out, force, once, late = np.empty((len(u), len(lag))), *np.full((3, len(lag)), start)
    keep = np.exp(-2 * h / np.maximum(lag, 1e-9))
    for k, command in enumerate(u):
        L = friction + slope * np.abs(force)
        force = np.minimum(np.maximum(force, command - L), command + L)
        once = force + keep * (once - force)
        late = once + keep * (late - once)
        out[k] = late
    return out


def behind(log, scale, bias, offset, slope):
    """Returns how far F is behind scale u + bias, and which share of that is friction. `offset` + `slope` |F| is friction and lag together. The log has one segment."""
    s = log.segments[0]
    size = max(int(round(BIN_S / s.h)), 1)
    u, y = (x[: len(x) // size * size].reshape(-1, size).mean(1) for x in (scale * s.u + bias, s.force))
    h = size * s.h
    rate = np.median(np.concatenate([np.abs(du[first:last]) for _, du, _, _, runs in slides.runs_of(log) for _, first, last in runs])) * abs(scale)
    force = offset + slope * float(np.median(np.abs(y)))
    played = _played(u, h, SHARES * offset, SHARES * slope, (1 - SHARES) * force / rate, float(y[0]))
    near = np.zeros(len(y), bool)  # rows in which u has turned recently
    turned = np.flatnonzero(np.diff(np.sign(np.diff(u))) != 0)
    for k in turned:
        near[k : k + int(3 * force / rate / h) + 1] = True
    cost = np.sum((played - y[:, None])[near] ** 2, axis=0)
    return Behind(float(force), float(rate), float(SHARES[int(np.argmin(cost))]))
