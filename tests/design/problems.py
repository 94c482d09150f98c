"""Seeded random problems, well-posed and ill-posed, for test_synthesis_many.py."""

import numpy as np


def root_text(root):
    root = complex(root)
    return f"{root.real:.9g}" if root.imag == 0 else f"{root.real:.9g}{root.imag:+.9g}j"


def random_plant(rng, bandwidth):
    """A stable plant of order 1 to 8: a dominant corner at `bandwidth`, the rest up to two decades faster, at times zeros."""
    order = int(rng.integers(1, 9))
    poles = []
    if order >= 2 and rng.random() < 0.3:
        damping = rng.uniform(0.1, 0.9)
        poles += [bandwidth * complex(-damping, s * np.sqrt(1 - damping**2)) for s in (1, -1)]
    else:
        poles.append(-bandwidth)
    while len(poles) < order:
        size = bandwidth * 10 ** rng.uniform(0.2, 2)
        if order - len(poles) >= 2 and rng.random() < 0.4:
            damping = rng.uniform(0.1, 0.95)
            poles += [size * complex(-damping, s * np.sqrt(1 - damping**2)) for s in (1, -1)]
        else:
            poles.append(-size)
    zeros = [-bandwidth * 10 ** rng.uniform(0.5, 2) for _ in range(int(rng.integers(0, 3)) if order >= 4 else 0)]
    gain = 10 ** rng.uniform(-1, 1) * rng.choice([1, 1, 1, -1])
    return gain, zeros, poles


def well_posed(seed):
    """A design as a dict: weights that ask for a bandwidth near the plant's own."""
    rng = np.random.default_rng(seed)
    bandwidth = 10 ** rng.uniform(0, 3)
    gain, zeros, poles = random_plant(rng, bandwidth)
    wanted = bandwidth * 10 ** rng.uniform(-1, 0.2)
    peak, steady = rng.uniform(1.5, 2.5), 10 ** rng.uniform(-4, -2)
    return {
        "name": f"random{seed}", "sample_time_s": float(f"{2 * np.pi / (bandwidth * 10 ** rng.uniform(1.7, 2.7)):.3g}"),
        "computation_delay_s": 0.0,
        "plant": {"gain": float(f"{gain:.6g}"), "zeros": [root_text(z) for z in zeros], "poles": [root_text(p) for p in poles]},
        "weights": {"wp": {"num": [1 / peak, wanted], "den": [1, wanted * steady]}, "wu": float(f"{10 ** rng.uniform(-1, 0) / abs(gain) ** 0 * min(1, abs(gain)):.3g}"),
                    "wT": {"num": [1, wanted * 2], "den": [1e-3, wanted * 4]}},
    }


CAUSES = ("unstable weight", "uncontrollable weight", "improper weight", "plant pole on the imaginary axis", "rank condition", "contradicting weights")


def ill_posed(seed):
    """A continuous problem (in w, the rank conditions of rolled-off weights never fail). (design, the cause it must be refused with). Each cause in turn, spoiling a well-posed problem."""
    rng = np.random.default_rng(10_000 + seed)
    design = well_posed(500 + seed)
    design["synthesis"] = {"domain": "continuous"}
    cause = CAUSES[seed % len(CAUSES)]
    weights = design["weights"]
    wanted = weights["wp"]["num"][1]
    name = rng.choice(["wp", "wT"])
    frequency = wanted * 10 ** rng.uniform(-1, 1)
    if cause == "unstable weight":
        kind = rng.integers(3)
        if kind == 0:
            weights[name] = {"k": 1.0, "zeros": [root_text(-frequency)], "poles": [root_text(frequency)]}
        elif kind == 1:
            weights["wp"] = {"num": [0.5, wanted], "den": [1, 0]}
        else:
            weights[name] = {"a": [[frequency]], "b": [1.0], "c": [frequency], "d": 0.5}
    elif cause == "uncontrollable weight":
        kind = rng.integers(3)
        if kind == 0:
            weights[name] = {"a": [[-frequency, 0], [0, -2 * frequency]], "b": [1, 0], "c": [frequency, 1], "d": 0.5}
        elif kind == 1:
            weights[name] = {"a": [[-frequency, 0], [0, -2 * frequency]], "b": [1, 1], "c": [frequency, 0], "d": 0.5}
        else:
            weights[name] = {"k": 1.0, "zeros": [root_text(-frequency), root_text(-3 * frequency)], "poles": [root_text(-frequency), root_text(-frequency / 50)]}
    elif cause == "improper weight":
        weights[rng.choice(["wp", "wu", "wT"])] = {"num": [1, frequency, frequency**2], "den": [1, wanted]}
    elif cause == "plant pole on the imaginary axis":
        poles = design["plant"]["poles"]
        if rng.random() < 0.5:
            design["plant"] = {"k": 1.0 * wanted, "zeros": [], "poles": [*poles, 0]}
        else:
            design["plant"]["poles"] = [*poles, f"{frequency:.9g}j", f"-{frequency:.9g}j"]
    elif cause == "rank condition":
        kind = rng.integers(3)
        design["plant"]["zeros"] = []
        if kind == 0:
            weights["wu"] = 0
        elif kind == 1:
            weights["wu"] = {"num": [frequency], "den": [1, frequency]}
        else:
            poles = [-frequency, -2 * frequency, -3 * frequency]
            pair = [f"{frequency:.9g}j", f"-{frequency:.9g}j"]
            design["plant"] = {"gain": 1.0, "zeros": pair, "poles": [root_text(p) for p in poles]}
            weights["wu"] = {"k": 0.1, "zeros": pair, "poles": [root_text(-frequency), root_text(-frequency)]}
    else:  # a resonance in wp where wT already forbids it: a contradiction in a narrow band at `frequency`
        frequency = contradiction_frequency(design)
        base = rng.uniform(0.4, 0.6)
        weights["wp"] = {"k": base, "zeros": [root_text(-frequency), root_text(-frequency)],
                         "poles": [root_text(complex(-0.004 * frequency, s * frequency)) for s in (1, -1)]}
        weights["wT"] = {"num": [30.0, 0.3 * frequency], "den": [1, frequency]}
        weights["wu"] = 1e-6
    return design, cause


def contradiction_frequency(design):
    return 0.1 / design["sample_time_s"]


def wild(seed):
    """Nothing promised: up to order 20, up to 21 decades, unstable, repeated and barely damped roots, any method."""
    rng = np.random.default_rng(seed)
    low, high = (-3, 6) if rng.random() < 0.5 else (-9, 12)

    def roots(count, unstable):
        out = []
        while len(out) < count:
            size, sign = 10 ** rng.uniform(low, high), -1 if rng.random() < unstable else 1
            if count - len(out) >= 2 and rng.random() < 0.4:
                damping = rng.uniform(0.001, 1)
                out += [size * complex(-damping * sign, s * np.sqrt(1 - damping**2)) for s in (1, -1)]
            elif out and out[-1].imag == 0 and rng.random() < 0.1:
                out.append(out[-1])
            else:
                out.append(complex(-size * sign))
        return [root_text(r) for r in out]

    order = int(rng.integers(0, 21))
    design = {"name": "wild", "sample_time_s": float(10 ** rng.uniform(-6, 1)), "weights": {}, "synthesis": {"gamma_max": 1e6, "time_limit_s": 1},
              "plant": {"gain": 1.0, "poles": roots(order, 0.1), "zeros": roots(int(rng.integers(0, order + 1)), 0.1)},
              "reduction": {"method": str(rng.choice(["modal", "balanced", "auto"]))}, "discretisation": {"method": str(rng.choice(["tustin", "zoh", "matched"]))}}
    for name in ("wp", "wu", "wT"):
        order = int(rng.integers(0, 4))
        design["weights"][name] = {"k": float(10 ** rng.uniform(-3, 1)), "poles": roots(order, 0.02), "zeros": roots(order, 0.1)}
    return design


KINDS = ("stable", "unstable", "non-minimum phase", "resonant", "integrating", "with delay")


def sampled_problem(seed):
    """(design, kind) for the default domain: a plant of each kind in turn, and weights that ask for what it can give, or a little more."""
    rng = np.random.default_rng(20_000 + seed)
    kind = KINDS[seed % len(KINDS)]
    design = well_posed(1000 + seed)
    w = design["weights"]["wp"]["num"][1]
    plant, h = design["plant"], design["sample_time_s"]
    if kind == "unstable":
        pole = w * 10 ** rng.uniform(-1.5, -0.3)
        design["plant"] = {"gain": -float(f"{10 ** rng.uniform(-1, 1):.4g}"), "zeros": [], "poles": [root_text(pole), root_text(-w * 10 ** rng.uniform(1, 2))]}
    elif kind == "non-minimum phase":
        plant["zeros"] = [root_text(w * 10 ** rng.uniform(0.3, 1.5))]
        plant["poles"] = plant["poles"] if len(plant["poles"]) > 1 else [*plant["poles"], root_text(-20 * w)]
    elif kind == "resonant":
        size, damping = w * 10 ** rng.uniform(-0.5, 0.8), 10 ** rng.uniform(-2.3, -0.7)
        plant["poles"] = [*plant["poles"][:0], root_text(-w * 10 ** rng.uniform(0.5, 1.5)), *(root_text(size * complex(-damping, s * np.sqrt(1 - damping**2))) for s in (1, -1))]
        plant["zeros"] = []
    elif kind == "integrating":
        design["plant"] = {"k": float(f"{w:.4g}"), "zeros": [], "poles": [0, root_text(-w * 10 ** rng.uniform(0.5, 1.5))]}
    elif kind == "with delay":
        plant["delay_s"] = float(f"{min(10 ** rng.uniform(-1.5, -0.3) / w, 35 * h):.4g}")
    design["computation_delay_s"] = float(f"{h * rng.choice([0, 0.3, 1.0]):.6g}")
    design["limits"] = {"floor": {"gain_margin_min": 1.3, "phase_margin_min_deg": 20}}
    return design, kind
