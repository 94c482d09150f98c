"""A joint with bristle friction behind a PD or PID position loop, which shares no line with the project: position_loop.py FIRST LAST says how steps alone are read, and what a sine adds."""

import math
import sys
from collections import Counter

import joints  # finds the packages
import numpy as np

from tribo_identify.refusal import Refusal
from tribo_rig import slip

assert joints.ROOT


def targets_of(random, amplitude, count):
    """Two positions in turn, a staircase, or positions at random."""
    shape = random.choice(["square", "square", "staircase", "random"])
    if shape == "square":
        return [amplitude * (i % 2) for i in range(count)]
    if shape == "staircase":
        return [amplitude / 5 * (i % 10 if i % 10 <= 5 else 10 - i % 10) for i in range(count)]
    return list(random.uniform(-amplitude, amplitude, count))


def rig_of(seed):
    """The joint, its loop and its targets."""
    random = np.random.default_rng(seed)
    h, inertia, friction = float(random.choice([5e-4, 1e-3, 2e-3])), 10 ** random.uniform(-2.3, -0.7), 10 ** random.uniform(-1.2, 0.0)
    amplitude, pole, damping = 10 ** random.uniform(-1.3, 0.0), random.uniform(8, 30), random.uniform(0.5, 1.2)
    gain = max(inertia * pole**2, friction / 0.05)
    targets = targets_of(random, amplitude, int(random.integers(10, 25)))
    jump = max(abs(b - a) for a, b in zip([0.0, *targets], targets))
    return {"h": h, "J": inertia, "friction": friction, "viscous": friction * random.uniform(0, 0.5),
            "weight": friction * float(random.choice([0, 0, 1, 2])), "kp": gain, "kd": 2 * damping * math.sqrt(gain * inertia), "ki": gain * float(random.choice([0, 1, 3])),
            "u_max": 1.6 * gain * jump + 5 * friction, "count": 2 * math.pi / float(random.choice([2000, 4096, 20000, 65536])), "targets": targets, "hold": random.uniform(0.6, 1.5), "amplitude": amplitude}


def play(rig, kind):
    """The log of steps, or of a sine of half a hertz."""
    h, targets = rig["h"], rig["targets"]
    count, parts = int(len(targets) * rig["hold"] / h), max(int(h / 1e-4), 5)
    dt, stiffness = h / parts, rig["friction"] / 0.002
    damping = math.sqrt(stiffness * rig["J"])
    q = v = bristle = integral = last = speed = 0.0
    effort, position = np.empty(count), np.empty(count)
    for k in range(count):
        goal = rig["amplitude"] * math.sin(math.pi * k * h) if kind == "sine" else targets[min(int(k * h / rig["hold"]), len(targets) - 1)]
        seen = round(q / rig["count"]) * rig["count"]
        speed += (1 - math.exp(-h * 300)) * ((seen - last) / h - speed)
        last = seen
        wish = rig["kp"] * (goal - seen) - rig["kd"] * speed + integral
        u = min(max(wish, -rig["u_max"]), rig["u_max"])
        integral += rig["ki"] * (goal - seen) * h if u == wish else 0.0
        effort[k], position[k] = u, seen
        for _ in range(parts):
            rate = v - stiffness * abs(v) / rig["friction"] * bristle
            bristle += rate * dt
            felt = stiffness * bristle + damping * rate * math.exp(-((v / 0.05) ** 2)) + rig["viscous"] * v
            v += (u - rig["weight"] * math.sin(q) - felt) / rig["J"] * dt
            q += v * dt
    return slip.Log(f"{kind}-log.csv", effort, position, h)


def found(rig, *logs):
    """Error of the friction and half of its interval, over the friction; or the cause of the refusal."""
    try:
        friction = slip.identify(list(logs), rig["u_max"]).friction
    except Refusal as refusal:
        return refusal.cause
    return friction.value / rig["friction"] - 1, friction.half / rig["friction"]


def judged(seeds):
    """What steps alone give by seed, and what a sine beside them gives where they show the loop alone."""
    alone, both = {}, {}
    for seed in seeds:
        rig = rig_of(seed)
        steps = play(rig, "steps")
        alone[seed] = found(rig, steps)
        if alone[seed] == "loop":
            both[seed] = found(rig, steps, play(rig, "sine"))
    return alone, both


def wrong(results):
    return {seed: one for seed, one in results.items() if not isinstance(one, str) and abs(one[0]) > one[1]}


def main():
    for title, results in zip(("steps alone", "where they show the loop, a sine as well"), judged(range(int(sys.argv[1]), int(sys.argv[2]) + 1))):
        told = [one for one in results.values() if not isinstance(one, str)]
        print(f"{title}: {len(told) - len(wrong(results))} of {len(told)} within their intervals; outside: {wrong(results)}; refused: {dict(Counter(one for one in results.values() if isinstance(one, str)))}")


if __name__ == "__main__":
    main()
