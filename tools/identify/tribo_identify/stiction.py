"""Dry friction or a lag: what keeps F behind u, of a log whose slides are all of about one rate.

Where u turns, F behind a lag turns with it; F behind friction stands until u has gone back by twice the friction. Both are played, mixed in several shares, and the
share whose F is nearest to the log's is friction's.
"""

from dataclasses import dataclass

import numpy as np

from . import slides

BIN_S = 0.002
SHARES = np.linspace(0, 1, 21)
LITTLE = 0.25  # a share that an arm of another shape than two equal lags may seem to have


@dataclass
class Behind:
    force: float  # N, by which F is behind u while it slides
    rate: float  # of u there, N/s
    share: float  # of it that is friction

    def friction(self):
        return self.share * self.force

    def is_lag(self):
        return self.share <= LITTLE

    def text(self):
        return f"F follows u both ways and turns with it: the {self.force:.2g} N by which it is behind at {self.rate:.3g} N/s are a lag of {1e3 * self.force / self.rate:.2g} ms"


def _played(u, h, friction, slope, lag, start):
    """F of several shares side by side: behind a play of the friction's width, and two equal lags."""
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
    """By how much F is behind scale u + bias, as offset + slope |F| of friction and lag together, and how much of that is friction. A log of one segment."""
    s = log.segments[0]
    size = max(int(round(BIN_S / s.h)), 1)
    u, y = (x[: len(x) // size * size].reshape(-1, size).mean(1) for x in (scale * s.u + bias, s.force))
    h = size * s.h
    rate = np.median(np.concatenate([np.abs(du[first:last]) for _, du, _, _, runs in slides.runs_of(log) for _, first, last in runs])) * abs(scale)
    force = offset + slope * float(np.median(np.abs(y)))
    played = _played(u, h, SHARES * offset, SHARES * slope, (1 - SHARES) * force / rate, float(y[0]))
    near = np.zeros(len(y), bool)  # where u has turned lately
    turned = np.flatnonzero(np.diff(np.sign(np.diff(u))) != 0)
    for k in turned:
        near[k : k + int(3 * force / rate / h) + 1] = True
    cost = np.sum((played - y[:, None])[near] ** 2, axis=0)
    return Behind(float(force), float(rate), float(SHARES[int(np.argmin(cost))]))
