"""Rows a second of a sweep of `triangle`, here and as a loop over `tribo-sim run`; not a test. By wall clock, and of the processor's own time.

    tools/design/.venv/bin/python tests/python/bench_sweep.py [ROWS [WORKERS]]
"""

import resource
import subprocess
import sys
import time
from pathlib import Path

import tribo

ROWS = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
WORKERS = int(sys.argv[2]) if len(sys.argv) > 2 else 2
STUDY = {"scenario": "triangle", "runs": ROWS, "sample": {"sensor.noise_seed": {"uniform": [1, 1e9]}, "plant.friction.breakaway.slope": {"uniform": [0.2, 0.4]}}}
SIM = Path(sys.executable).with_name("tribo-sim")


def processor_s():
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def rate(name, rows, call):
    wall, processor = time.perf_counter(), processor_s()
    call()
    wall, processor = time.perf_counter() - wall, processor_s() - processor
    print(f"{name:24s}{rows:8d} rows{wall:9.1f} s{processor:9.1f} s of processor time{1e3 * processor / rows:9.2f} ms a row", flush=True)


def run_each():
    study = tribo.Study(STUDY | {"runs": min(ROWS, 100)})
    for row in range(study.rows):
        subprocess.run([SIM, "run", "triangle", *(word for one in study.assignments(row) for word in ("--set", one))], check=True, stdout=subprocess.DEVNULL)


rate(f"sweep, {WORKERS} workers", ROWS, lambda: tribo.sweep(STUDY, workers=WORKERS))
rate("tribo-sim run each", min(ROWS, 100), run_each)
