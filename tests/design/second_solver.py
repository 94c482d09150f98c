"""The discrete H-infinity solver (SLICOT's SB10DD) on the plant in z: a second opinion on what gamma can be reached.

The tool synthesises in w with the continuous solver. Here hold and delay are states of the plant in z and the weights are Tustin's, which
are the true ones where gamma peaks, far below the Nyquist frequency.
"""

import warnings

import control as ct
import numpy as np
import scipy.signal
import slycot
from independent import roots_of, sampled_plant, weight


def plant_in_z(data):
    plant, h = data["plant"], data["sample_time_s"]
    poles, zeros = roots_of(plant, "poles"), roots_of(plant, "zeros")
    k = plant["k"] if "k" in plant else plant["gain"] * (np.prod(-poles) / np.prod(-zeros)).real
    a, b, c, d = scipy.signal.zpk2ss(zeros, np.where(poles == 0, -1e-6 * np.abs(poles).max(), poles), k)
    late = data["computation_delay_s"] + plant.get("delay_s", 0.0)
    ticks = int(np.ceil(late / h - 1e-9))
    ad, bd, *_ = scipy.signal.cont2discrete((a, b, c, d), h, "zoh")
    if ticks == 0:
        return ct.ss(ad, bd, c, d, h)
    newer = scipy.signal.cont2discrete((a, b, c, d), max(ticks * h - late, 1e-15), "zoh")[1]  # of u, ticks - 1 ago, at the end of a sample
    n = len(a)
    whole, entry = np.zeros((n + ticks, n + ticks)), np.zeros((n + ticks, 1))
    whole[:n, :n], whole[:n, [n]] = ad, bd - newer
    whole[n:, n:] = np.eye(ticks, k=1)
    entry[-1] = 1.0
    if ticks == 1:
        entry[:n] = newer
    else:
        whole[:n, [n + 1]] = newer
    return ct.ss(whole, entry, np.c_[c, np.zeros((1, ticks))], d, h)


def reaches(data, gamma):
    """Whether it finds a controller that stabilises and keeps gamma."""
    h = data["sample_time_s"]
    plant = plant_in_z(data)

    def in_z(system):
        if not isinstance(system, dict):
            return ct.ss([], [], [], [[system]], h)
        return ct.ss(*scipy.signal.cont2discrete(scipy.signal.tf2ss(system["num"], system["den"]), h, "bilinear")[:4], h)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        matrices = ct.ssdata(ct.augw(plant, *(in_z(data["weights"][name]) for name in ("wp", "wu", "wT"))))
        try:
            found = slycot.sb10dd(len(matrices[0]), 2, 4, 1, 1, gamma, *matrices)
        except slycot.exceptions.SlycotError:
            return False
        a, b, c, d = [m for m in found if np.ndim(m) == 2][:4]
        loop = ct.feedback(ct.series(ct.ss(a, b, c, d, h), plant), 1)
    if not np.abs(loop.poles()).max() < 1:  # it does not check the coupling of its two Riccati equations: below the least gamma the loop is not stable
        return False
    omega = np.geomspace(1e-6 / h, 0.9999 * np.pi / h, 3000)
    z = np.exp(1j * omega * h)
    k = (c @ np.linalg.solve(z[:, None, None] * np.eye(len(a)) - a, b) + d)[:, 0, 0]
    s = 1 / (1 + k * sampled_plant(data["plant"], h, data["computation_delay_s"] + data["plant"].get("delay_s", 0.0))(z))
    terms = [weight(data["weights"]["wp"], omega) * s, weight(data["weights"]["wu"], omega) * k * s, weight(data["weights"]["wT"], omega) * (1 - s)]
    return bool(np.sqrt(sum(np.abs(t) ** 2 for t in terms)).max() <= 1.01 * gamma)
