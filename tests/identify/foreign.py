"""Rigs of three simulators that share no code with the project: a mass before a spring, with friction of Coulomb and Stribeck, LuGre or Maxwell slip.

    m dv/dt = scale u_a + bias - f(x, v) - c v - K x        F = K x,  friction f reaches at most L(F) = offset + slope |F|

u_a is u some ticks late behind a lag; y is F behind a lag, with noise, in steps, sampled. Many rigs are played side by side, an array for each quantity.
A rig's numbers come from its seed. All frictions are given as at the load: N of F.
"""

import numpy as np
from synthetic import plan_over

from tribo_identify.plan import POLE

KINDS = ("coulomb", "lugre", "maxwell")
STEP_S = 1e-4
SLIPS = 8  # elements of the Maxwell slip


def rig_of(seed, **given):
    """A rig far from the paper's. `ratio` is sliding over breakaway, `less` what the negative direction has of the positive one's friction."""
    source = np.random.default_rng([seed, 28])
    log = lambda low, high: float(np.exp(source.uniform(np.log(low), np.log(high))))
    high = log(0.05, 200.0)
    rig = {"seed": seed, "kind": KINDS[seed % len(KINDS)], "high": high, "low": high * source.uniform(0.1, 0.3), "period": float(source.choice([2e-4, 5e-4, 1e-3, 2e-3, 5e-3])),
           "delay": int(source.integers(0, 4)), "mass": log(0.02, 5.0), "frequency": log(60.0, 250.0), "damping": source.uniform(0.2, 1.0), "actuator": log(2e-4, 0.01),
           "sensor": log(2e-4, 0.01), "scale": source.uniform(0.7, 1.3), "bias": high * source.uniform(-0.02, 0.02), "noise": high * log(1e-4, 2e-3), "step": high * log(1e-4, 2e-3),
           "offset": high * log(0.005, 0.08), "slope": source.uniform(0.05, 0.4), "ratio": 1.0, "less": 1.0, "speed": high * log(0.05, 1.0), "distance": high * log(0.01, 0.1),
           "by_distance": bool(source.integers(2)), "stiff": log(8.0, 50.0), "bristle_damping": source.uniform(0.3, 1.0), "guess": source.uniform(0.75, 1.3)}
    assert set(given) <= set(rig)
    return rig | given


def plan_of(rig):
    """Plans as a user does who knows the range of forces, the noise, the sample time and, from a first try, friction within 30 %."""
    noise = float(f"{np.hypot(rig['noise'], 0.3 * rig['step']):.2g}")
    return plan_over(rig["low"], rig["high"], noise=noise, offset=rig["guess"] * rig["offset"], slope=rig["guess"] * rig["slope"], sample_time_s=rig["period"])


def L_of(rig, force, way=1, sliding=False):
    """Breakaway, or what is left of it in long slides."""
    return (rig["offset"] + rig["slope"] * np.abs(force)) * (rig["ratio"] if sliding else 1.0) * (1.0 if way > 0 else rig["less"])


class Coulomb:
    """Sticks while what pushes stays below breakaway; falls to sliding with speed or with the distance since it stood."""

    def __init__(self, p):
        self.p, self.gone = p, np.zeros(p["mass"].shape)

    def step(self, x, v, stop, L):
        p = self.p
        speed = np.abs(v) * p["stiffness"]
        left = np.where(p["by_distance"], np.exp(-self.gone / p["distance"]), np.exp(-((speed / p["speed"]) ** 2)))
        most = L * (p["ratio"] + (1 - p["ratio"]) * left)
        f = np.minimum(np.maximum(stop, -most), most)
        self.gone = np.where(f == stop, 0.0, self.gone + speed * STEP_S)
        return f


class LuGre:
    """dz/dt = v - s0 |v| z / g(v),  f = s0 z + s1 dz/dt, with g from breakaway to sliding by speed."""

    def __init__(self, p):
        self.p, self.z = p, np.zeros(p["mass"].shape)
        self.s0 = p["stiff"] * p["stiffness"]
        self.s1 = p["bristle_damping"] * np.sqrt(self.s0 * p["mass"])

    def step(self, x, v, stop, L):
        p = self.p
        g = L * (p["ratio"] + (1 - p["ratio"]) * np.exp(-((v * p["stiffness"] / p["speed"]) ** 2)))
        rate = self.s0 * np.abs(v) / g
        before = self.z
        self.z = self.z * np.exp(-rate * STEP_S) + np.where(v == 0, 0.0, np.sign(v) * g / self.s0 * -np.expm1(-rate * STEP_S))
        return self.s0 * self.z + self.s1 * (self.z - before) / STEP_S


class Maxwell:
    """Elements of spring and slip side by side: the k-th begins to slip at k times the shortest distance."""

    def __init__(self, p):
        self.p = p
        share = np.arange(1, SLIPS + 1)[:, None] / SLIPS
        self.k = p["stiff"] * p["stiffness"] / SLIPS * np.ones_like(share)
        self.most = share / share.sum()  # of L
        self.f, self.x = np.zeros((SLIPS, *p["mass"].shape)), np.zeros(p["mass"].shape)
        self.damper = p["bristle_damping"] * np.sqrt(p["stiff"] * p["stiffness"] * p["mass"]) * 0.3

    def step(self, x, v, stop, L):
        most = self.most * L
        self.f = np.minimum(np.maximum(self.f + self.k * (x - self.x), -most), most)
        self.x = x
        inside = np.abs(self.f[-1]) < most[-1]
        return self.f.sum(0) + np.where(inside, self.damper * v, 0.0)


def play(rigs, references=None):
    """Rows t, u, y of each rig's experiment, `references` (rows t, r) or the plan's, with the plan's controller. All rigs are of one kind."""
    kind, = {r["kind"] for r in rigs}
    references = [plan_of(r).reference() for r in rigs] if references is None else references
    p = {name: np.array([r[name] for r in rigs]) for name in rigs[0] if name not in ("kind",)}
    p["stiffness"] = p["mass"] * p["frequency"] ** 2
    c = 2 * p["damping"] * p["mass"] * p["frequency"]
    friction = {"coulomb": Coulomb, "lugre": LuGre, "maxwell": Maxwell}[kind](p)
    every = np.round(p["period"] / STEP_S).astype(int)
    ticks = np.array([int(ref[-1, 0] / r["period"]) for r, ref in zip(rigs, references)])
    r, noise, us, ys = np.zeros((4, ticks.max() + 1, len(rigs)))
    for i, (rig, ref) in enumerate(zip(rigs, references)):
        r[: ticks[i], i] = np.interp(np.arange(ticks[i]) * rig["period"], *ref.T)
        noise[: ticks[i], i] = np.random.default_rng([rig["seed"], 29]).normal(0, rig["noise"], ticks[i])
    b, a = POLE * p["period"] / (2 + POLE * p["period"]), (POLE * p["period"] - 2) / (POLE * p["period"] + 2)
    actuator, sensor = -np.expm1(-STEP_S / p["actuator"]), -np.expm1(-STEP_S / p["sensor"])
    x, v, force, y, command, e = np.zeros((6, len(rigs)))
    for k in range(int(np.max(ticks * every))):
        due = np.flatnonzero(k % every == 0)
        if len(due):
            tick = np.minimum(k // every[due], ticks[due])
            seen = np.round((y[due] + noise[tick, due]) / p["step"][due]) * p["step"][due]
            error = r[tick, due] - seen
            us[tick, due] = b[due] * (error + e[due]) - a[due] * us[tick - 1, due]
            ys[tick, due], e[due] = seen, error
            command[due] = us[tick - p["delay"][due], due]  # 0 from the other end before the first
        force += actuator * (p["scale"] * command + p["bias"] - force)
        push = force - p["stiffness"] * x - c * v
        stop = push + p["mass"] * v / STEP_S  # what would stop it within the step
        L = (p["offset"] + p["slope"] * np.abs(p["stiffness"] * x)) * np.where((stop if kind == "coulomb" else v) < 0, p["less"], 1.0)
        v = v + STEP_S / p["mass"] * (push - friction.step(x, v, stop, L))
        x = x + STEP_S * v
        y += sensor * (p["stiffness"] * x - y)
    return [np.c_[np.arange(n) * rig["period"], us[:n, i], ys[:n, i]] for i, (n, rig) in enumerate(zip(ticks, rigs))]
