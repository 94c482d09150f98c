"""Every form of import on many controllers: python tests/design/study_import.py [COUNT, default 500 [FIRST SEED, default 0]]

Prints how many files of each form were accepted with an equal response, refused, or accepted wrongly (which must be none).
"""

import collections
import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")

from conftest import PAPER
from controllers import FORMS, outcome, random_controller, synthesised

from tribo_design.config import load_design


def main(count=500, first=0):
    design, _ = load_design(PAPER)
    total = collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        made, seed = 0, first
        while made < count:
            k = synthesised(seed) if seed % 4 < 2 else random_controller(seed)
            seed += 1
            if k is None:
                continue
            made += 1
            for form in FORMS:
                found = outcome(Path(folder), form, k, design)
                kind = found.split(":")[0].split(" by")[0]
                total[form, kind] += 1
                if kind in ("WRONG", "refused"):
                    print(f"seed {seed - 1} {form}: {found[:150]}", flush=True)
    for form in FORMS:
        print(f"{form:20s}", ", ".join(f"{kind} {n}" for (f, kind), n in sorted(total.items()) if f == form))
    return any(kind == "WRONG" for _, kind in total)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
