"""Averages of a signal, and the noise in them."""

import numpy as np

BIN_S = 0.02  # over which signals are averaged


def bin_size(h):
    return max(int(round(BIN_S / h)), 1)


def binned(x, size):
    return x[: len(x) // size * size].reshape(-1, size).mean(1)


def noise_of(averages):
    """Standard deviation, from how they bend."""
    return float(np.median(np.abs(np.diff(averages, 2))) / (0.6745 * np.sqrt(6))) if len(averages) > 2 else 0.0
