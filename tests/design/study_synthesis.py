"""Random problems of every kind in the default domain: python tests/design/study_synthesis.py [COUNT, default 300 [FIRST SEED, default 0]]

Each result is closed again by independent.py on a dense grid; each refusal is printed with what makes it true or not.
"""

import collections
import os
import re
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np
from independent import figures, sampled_plant, weight
from problems import sampled_problem
from second_solver import reaches

from tribo_design import pipeline
from tribo_design.config import Design, validate
from tribo_design.errors import DesignError, IllPosedError, LimitError


GAMMA_MAX = 5.0  # synthesis.gamma_max


def one(seed):
    """(kind, "verified" or "refused" or "WRONG", text)."""
    data, kind = sampled_problem(seed)
    design = validate(Design, data, "random")
    try:
        result = pipeline.synthesize(design, "0" * 64, "random")
    except DesignError as error:
        return kind, "refused" if is_true(error, data, kind) else "WRONG", str(error)
    found = figures(data, result.q31.values(), data["weights"], design.delay_s)
    stated = result.stage("q31").metrics
    for name, value in (("gamma", stated.gamma), ("max_s", stated.max_s)):
        if not abs(found[name] / value - 1) < 1e-3:
            return kind, "WRONG", f"{name} {value}, independently {found[name]}"
    if abs(found["missing_turns"]) > 0.2:
        return kind, "WRONG", f"not stable: {found['missing_turns']} turns missing"
    if reaches(data, 0.95 * result.stage("full").metrics.gamma):
        return kind, "WRONG", f"gamma {result.stage('full').metrics.gamma}: a second solver reaches 0.95 of it"
    return kind, "verified", f"gamma {stated.gamma:.4g}"


def is_true(error, data, kind):
    """Whether a refusal's reason is a fact of its class."""
    text = str(error)
    if isinstance(error, IllPosedError):
        if error.cause == "plant pole on the imaginary axis":
            return kind == "integrating"
        if error.cause == "contradicting weights":
            at = re.search(r"contradict each other at ([0-9.e+-]+) rad/s", text)
            if at and "S = 1" not in text and "T = 1" not in text:
                return lower_bound(data, float(at.group(1))) > 4.9
            return not reaches(data, GAMMA_MAX)  # a right-half-plane root's bound, or the solver's best
        if error.cause == "time limit":  # the clock says so; a dead time of 40 ticks makes K of order 50
            return True
        if error.cause == "unstable controller":
            return "pole" in text
        return False
    if isinstance(error, LimitError):
        # The criterion that is named is one that the table shows as broken; "not stable" never stands for a margin.
        return ("is under" in text or "worse" in text or "leaves no controller" in text) and "not stable" not in text
    outside = re.search(r"zeros on or outside the unit circle \(z = (\S+?)[,)]", text)
    return bool(outside) and abs(complex(outside.group(1))) > 1 - 1e-6


def lower_bound(data, omega):
    """At one frequency, of any controller: the least of |wp S|, |wu K S|, |wT T| together with S + T = 1."""
    omega = np.array([omega])
    h = data["sample_time_s"]
    g = sampled_plant(data["plant"], h, data["computation_delay_s"] + data["plant"].get("delay_s", 0.0))(np.exp(1j * omega * h))
    a = abs(weight(data["weights"]["wp"], omega)) ** 2
    b = abs(weight(data["weights"]["wu"], omega) / g) ** 2 + abs(weight(data["weights"]["wT"], omega)) ** 2
    return float(np.sqrt(a * b / (a + b))[0])


def main(count=300, first=0):
    total = collections.Counter()
    for seed in range(first, first + count):
        kind, verdict, text = one(seed)
        total[kind, verdict] += 1
        if verdict != "verified":
            print(f"seed {seed} {kind}: {verdict}: {text[:300]}", flush=True)
    for kind in dict.fromkeys(k for k, _ in total):
        print(f"{kind:20s}", ", ".join(f"{v} {n}" for (k, v), n in sorted(total.items()) if k == kind))
    return any(verdict == "WRONG" for _, verdict in total)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
