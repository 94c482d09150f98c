"""Processor seconds of the commands, each in a process of its own: python tests/design/study_speed.py"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from conftest import PAPER, ROOT
from records import linear, staircase


def seconds(*arguments):
    before = os.times()
    done = subprocess.run([sys.executable, "-m", "tribo_design", *map(str, arguments)], capture_output=True, text=True, check=False)
    after = os.times()
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    return after.children_user + after.children_system - before.children_user - before.children_system


def record(path, n):
    rng = np.random.default_rng(3)
    u = staircase(rng, n)
    dt = 4.8 / n
    y = linear([-10.0, -60.0], 1.3, False, 0.03, u, dt, fine=1 if n > 1000 else 10) + rng.normal(0, 0.002, n)
    path.write_text("t_s,u_n,y_n\n" + "\n".join(f"{i * dt!r},{a!r},{b!r}" for i, (a, b) in enumerate(zip(u.tolist(), y.tolist()))) + "\n")
    return path


def main():
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        print(f"synthesize designs/paper.yaml, with plots       {seconds('synthesize', PAPER, '--out', out / 'a'):5.1f} s")
        print(f"synthesize designs/example.yaml, with plots     {seconds('synthesize', ROOT / 'designs' / 'example.yaml', '--out', out / 'b'):5.1f} s")
        print(f"synthesize designs/example.yaml, no plots       {seconds('synthesize', ROOT / 'designs' / 'example.yaml', '--out', out / 'c', '--no-plots'):5.1f} s")
        print(f"identify-plant, 300 rows                        {seconds('identify-plant', record(out / 'small.csv', 300)):5.1f} s")
        print(f"identify-plant, 60,000 rows                     {seconds('identify-plant', record(out / 'large.csv', 60_000)):5.1f} s")


if __name__ == "__main__":
    main()
