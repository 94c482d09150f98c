"""Synthetic step records of known plants, with what a bench puts on top: friction, dead time, an integrator, drift, hum, outliers."""

import numpy as np
import scipy.signal

KINDS = ("white", "coulomb", "stribeck", "one step with friction", "dead time", "integrator", "drift", "hum", "outliers", "everything")


def staircase(rng, n, both=True):
    """u = 0, h, 2h, h, 0, -h ... or one step."""
    h = 10 ** rng.uniform(-0.5, 0.5)
    shape = [0, 1, 2, 1, 0, 1.6, 0.6, 0] if both else [0, 1, 1, 1, 1, 1, 1, 1]
    u = np.repeat(np.array(shape) * h, n // len(shape) + 1)[:n]
    return u


def linear(poles, gain, integrator, tau, u, dt, fine=10):
    """y at the samples, u held, by scipy at a tenth of the sample time (tau to within that)."""
    zeros, p = [], np.array(poles, complex)
    a, b, c, d = scipy.signal.zpk2ss(zeros, p, gain * np.prod(-p).real)
    if integrator:
        n = len(a)
        a = np.block([[a, np.zeros((n, 1))], [c, np.zeros((1, 1))]])
        b, c, d = np.vstack([b, d]), np.hstack([np.zeros((1, n)), [[1.0]]]), np.zeros((1, 1))
    step = dt / fine
    late = int(round(tau / step))
    held = np.r_[np.zeros(late), np.repeat(u, fine)][: len(u) * fine]
    ad, bd, cd, dd, _ = scipy.signal.cont2discrete((a, b, c, d), step, "zoh")
    return scipy.signal.dlsim((ad, bd, cd, dd, step), held)[1][::fine, 0]


def with_friction(actuator, arm, sensor, gain, coulomb, static, u, dt, fine=20):
    """Actuator pole, a light arm that sticks below `static` and slides with `coulomb`, sensor pole. At 1/20 of the sample time."""
    step = dt / fine
    ka, ks = 1 - np.exp(-actuator * step), 1 - np.exp(-sensor * step)
    force = position = reading = 0.0
    sliding = 0
    speed_scale = 0.05
    out = np.empty(len(u))
    for i, value in enumerate(u):
        out[i] = reading * gain
        for _ in range(fine):
            force += ka * (value - force)
            net = force - position
            if sliding == 0 and abs(net) > static:
                sliding = 1 if net > 0 else -1
            if sliding:
                held = coulomb
                rate = arm * (net - sliding * held)
                if static > coulomb:  # friction falls from static to Coulomb as the arm gets faster: two rounds for the rate
                    for _ in range(2):
                        held = coulomb + (static - coulomb) * np.exp(-abs(rate) / (arm * speed_scale))
                        rate = arm * (net - sliding * held)
                if rate * sliding <= 0:
                    sliding = 0
                else:
                    position += step * rate
            reading += ks * (position - reading)
    return out


def record(seed):
    """(kind, truth, time, u, y): truth has gain, poles, delay_s, integrator."""
    rng = np.random.default_rng(40_000 + seed)
    kind = KINDS[seed % len(KINDS)]
    n = int(rng.choice([300, 400, 800]))
    slow = 10 ** rng.uniform(0.5, 1.5)
    poles = [-slow]
    if rng.random() < 0.7:
        if rng.random() < 0.3:
            size, damping = slow * rng.uniform(1.5, 3), rng.uniform(0.4, 0.8)
            poles = [size * complex(-damping, s * np.sqrt(1 - damping**2)) for s in (1, -1)]
        else:
            poles.append(-slow * rng.uniform(4, 8))
    gain = float(10 ** rng.uniform(-0.5, 0.5))
    dt = 8 * 6 / min(abs(np.real(p)) for p in poles) / n  # each of eight plateaus is six time constants
    truth = {"gain": gain, "poles": poles, "delay_s": 0.0, "integrator": False}
    u = staircase(rng, n, kind != "one step with friction")
    height = np.ptp(u)
    if kind in ("coulomb", "stribeck", "one step with friction"):
        level = height * rng.uniform(0.05, 0.2)
        arm, actuator, sensor = slow, slow * rng.uniform(4, 7), slow * rng.uniform(10, 20)
        static = level * rng.uniform(1.3, 1.7) if kind == "stribeck" else level
        y = with_friction(actuator, arm, sensor, gain, level, static, u, dt)
        truth["poles"] = None  # of a plant that sticks nobody owes poles
    else:
        if kind in ("dead time", "everything"):
            truth["delay_s"] = float(np.round(rng.uniform(1.5, 8), 1) * dt)
        if kind == "integrator":
            truth["integrator"], truth["gain"] = True, gain * slow
        y = linear(poles, truth["gain"], truth["integrator"], truth["delay_s"], u, dt)
    noise = np.ptp(y) * 10 ** rng.uniform(-3, -2)
    time = np.arange(n) * dt
    y = y + rng.normal(0, noise, n) + rng.normal(0, 0.1) * np.ptp(y)
    if kind in ("drift", "everything"):
        y = y + np.cumsum(rng.normal(0, noise * rng.uniform(0.1, 0.6), n))
    if kind in ("hum", "everything"):
        y = y + noise * rng.uniform(1, 5) * np.sin(rng.uniform(0.1, 0.8) * np.pi / dt * time + rng.uniform(0, 6))
    if kind in ("outliers", "everything"):
        at = rng.choice(n, max(n // 100, 2), replace=False)
        y[at] += noise * rng.uniform(15, 60, len(at)) * rng.choice([-1, 1], len(at))
    return kind, truth, time, u - u[0], y


def judged(seed):
    """(kind, "answered" or "not answered", {quantity: (inside its interval, how many half widths off)}, text)."""
    from tribo_design.errors import DesignError
    from tribo_design.identify import Data, identify

    kind, truth, time, u, y = record(seed)
    try:
        found = identify(Data(time, u, y))[0]
    except DesignError as error:
        return kind, "not answered", {}, str(error)
    if not (found["separable"] and found["trusted"]):
        return kind, "not answered", {}, "; ".join(found["remarks"]) or "not separable"
    off = {"gain": abs(found["gain"] - truth["gain"]) / max(found["gain_half_width"], 1e-300)}
    if found["integrator"] != truth["integrator"]:
        off["integrator"] = np.inf
    if truth["poles"] is not None:
        if found["delay_half_width_s"] is not None and (truth["delay_s"] or found["delay_s"]):
            off["delay"] = abs(found["delay_s"] - truth["delay_s"]) / max(found["delay_half_width_s"], 1e-300)
        for pole in found["poles"]:
            if pole["identifiable"] and pole["im"] >= 0:
                size = np.hypot(pole["re"], pole["im"])
                nearest = min(truth["poles"], key=lambda p: abs(np.log(abs(p) / size)))
                off[f"pole {pole['pole']}"] = abs(np.log(abs(nearest) / size)) / max(np.log(pole["size_high"] / size), 1e-300)
    return kind, "answered", off, f"order {found['order']}, {found['gain_from']}, drift {found['drift']}, hum {len(found['hum_rad_s'])}, outliers {found['outliers']}"
