"""Ticks a second of each part from Python, best of five; not a test. By wall clock, and of the processor's own time.

    tools/design/.venv/bin/python tests/python/bench.py
"""

import time

import numpy as np

import tribo

TICKS = 1_000_000
T = np.arange(TICKS) * 1e-3
R = 0.5 + 0.1 * np.sin(T)
Y = R + 1e-3 * np.sin(7 * T)


def rate(name, call, ticks=TICKS):
    wall, own = [], []
    for _ in range(5):
        clocks = time.perf_counter(), time.process_time()
        call()
        wall.append(time.perf_counter() - clocks[0])
        own.append(time.process_time() - clocks[1])
    print(f"{name:42s}{ticks / min(wall):12.3g}{ticks / min(own):12.3g}", flush=True)


print(f"{'over an array of a million':42s}{'wall':>12s}{'processor':>12s}")
for arith in ("f32", "q31"):
    for method in ("paper", "feedforward"):
        loop = tribo.Loop(method=method, arith=arith)
        rate(f"loop with guard, {method}, {arith}", lambda: loop.steps(R, Y))
    rate(f"the same with all signals, {arith}", lambda: loop.record(R, Y))
    rate(f"Friction, {arith}", lambda part=tribo.Friction(arith=arith): part.steps(R, Y))
    rate(f"Compensator, {arith}", lambda part=tribo.Compensator(arith=arith): part.steps(R))
    rate(f"Guard, {arith}", lambda part=tribo.Guard(arith=arith): part.steps(R, Y, 0.01))
    rate(f"FeedForward, {arith}", lambda part=tribo.FeedForward(arith=arith): part.steps(R, Y, R))
print("tick by tick")
step, pairs = tribo.Loop().step, list(zip(R[:200_000].tolist(), Y[:200_000].tolist()))
rate("loop with guard, feedforward, f32", lambda: [step(r, y) for r, y in pairs], len(pairs))
