"""Synthetic step records: python tests/design/study_identify.py [COUNT, default 500 [FIRST SEED, default 0]]

How many are answered, how often the 95 % intervals hold the truth, and the answers that are sure and wrong (more than three half widths off).
"""

import collections
import os
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")

from records import KINDS, judged


def main(count=500, first=0):
    verdicts, inside, totals, wrong = collections.Counter(), collections.Counter(), collections.Counter(), 0
    for seed in range(first, first + count):
        kind, verdict, off, text = judged(seed)
        verdicts[kind, verdict] += 1
        for name, halves in off.items():
            name = name.split()[0]
            totals[kind, name] += 1
            inside[kind, name] += halves <= 1
        if any(halves > 3 for halves in off.values()):
            wrong += 1
            print(f"seed {seed} {kind}: SURE AND WRONG: {off} ({text})", flush=True)
        elif verdict == "not answered":
            print(f"seed {seed} {kind}: not answered: {text[:140]}", flush=True)
    for kind in KINDS:
        print(f"{kind:24s} answered {verdicts[kind, 'answered']:3d}, not {verdicts[kind, 'not answered']:3d}; " + ", ".join(
            f"{name} {inside[kind, name]}/{n}" for (k, name), n in sorted(totals.items()) if k == kind))
    for name in ("gain", "delay", "pole"):
        n = sum(v for (_, q), v in totals.items() if q == name)
        print(f"{name}: {100 * sum(v for (_, q), v in inside.items() if q == name) / max(n, 1):.1f} % of {n} intervals hold the truth")
    print(f"sure and wrong: {wrong} of {count}")
    return wrong > 0


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
