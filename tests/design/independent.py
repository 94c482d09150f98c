"""The sampled loop by partial fractions, with nothing of the tool: the plant's step response behind hold and delay, summed up in z."""

import numpy as np


def roots_of(plant, name):
    return np.array([complex(r) for r in plant.get(name, [])], complex)


def sampled_plant(plant, h, delay):
    """G(z) as a function of complex z; simple poles only."""
    zeros, poles = roots_of(plant, "zeros"), roots_of(plant, "poles")
    slope = 0.0
    if np.any(poles == 0):  # k with an integrator: the step response is slope t + rest + ...
        k, poles = plant["k"], poles[poles != 0]
        slope = k * np.prod(-zeros) / np.prod(-poles)
        rest = slope * (np.sum(-1 / zeros) + np.sum(1 / poles))
        residues = np.array([k * np.prod(p - zeros) / np.prod(np.delete(p - poles, i)) / p**2 for i, p in enumerate(poles)])
    else:
        rest, k = plant["gain"], plant["gain"] * np.prod(-poles) / np.prod(-zeros)
        residues = np.array([k * np.prod(p - zeros) / np.prod(np.delete(p - poles, i)) / p for i, p in enumerate(poles)])
    first = int(np.ceil(delay / h - 1e-9))  # the sample that sees the step first
    late = first * h - delay

    def response(z):
        total = (rest + slope * late) / (1 - 1 / z) + slope * h / z / (1 - 1 / z) ** 2
        for p, r in zip(poles, residues):
            total = total + r * np.exp(p * late) / (1 - np.exp(p * h) / z)
        # A strictly proper plant's step response begins at 0: what it is at its first sample is in the sum already.
        return (1 - 1 / z) * total * z**-first

    return response


def cascade(rows, z):
    d = z - 1
    value = np.ones(len(z), complex)
    for b0, b1, b2, a1, a2 in rows:
        value = value * (b0 * d**2 + b1 * d + b2) / (d**2 + a1 * d + a2)
    return value


def weight(system, omega):
    if isinstance(system, (int, float)):
        return np.full(len(omega), float(system), complex)
    return np.polyval(system["num"], 1j * omega) / np.polyval(system["den"], 1j * omega)


def figures(data, rows, weights, delay, points=20_000):
    """Of the loop with the cascade's rows: gamma, max S, encirclements of -1 minus what stability needs (0: stable)."""
    h = data["sample_time_s"]
    g = sampled_plant(data["plant"], h, delay)
    omega = np.unique(np.r_[np.geomspace(1e-7 / h, np.pi / h * 0.99999, points), np.linspace(1e-4, 0.99999, points) * np.pi / h]
                      if not len(roots_of(data["plant"], "poles")) else
                      np.r_[np.geomspace(1e-7 / h, np.pi / h * 0.99999, points), np.linspace(1e-4, 0.99999, points) * np.pi / h,
                            *(abs(p) * (1 + abs(p.real / p) * np.linspace(-5, 5, 400)) for p in roots_of(data["plant"], "poles") if p.imag > 0 and abs(p) * 1.5 < np.pi / h)])
    omega = omega[(omega > 0) & (omega < np.pi / h)]
    z = np.exp(1j * omega * h)
    k, plant = cascade(rows, z), g(z)
    s = 1 / (1 + k * plant)
    gamma = np.sqrt(abs(weight(weights["wp"], omega) * s) ** 2 + abs(weight(weights["wu"], omega) * k * s) ** 2
                    + (abs(weight(weights["wT"], omega) * (1 - s)) ** 2 if "wT" in weights else 0))
    turns = np.unwrap(np.angle(1 / s))
    unstable = int(np.sum(roots_of(data["plant"], "poles").real > 0))
    # From just above 0 to pi, half the unit circle: it must turn around -1 by pi for each unstable plant pole; past an integrator by half of that.
    unstable += 0.5 * np.sum(roots_of(data["plant"], "poles") == 0)
    return {"gamma": float(gamma.max()), "max_s": float(abs(s).max()), "missing_turns": float((turns[-1] - turns[0]) / np.pi - unstable)}
