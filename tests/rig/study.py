"""The whole way of many foreign rigs, as a table: study.py N [FIRST SEED [accept] [falls]]. Ends with 1 where a rig ended worse than without compensation, or was
driven beyond its safe force. With `accept`, tribo-identify accept judges each loop on its rig and on others near it; with `falls` all have Coulomb friction that
falls with speed."""

import sys
import tempfile
from pathlib import Path

import foreign
import numpy as np
import way


def main():
    count, first = int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0
    tuned, worse, beyond, refused, astray = [], 0, 0, 0, {name: 0 for name in way.OTHERS}
    for seed in range(first, first + count):
        truth = foreign.falling(seed) if "falls" in sys.argv else foreign.truth_of(seed)
        with tempfile.TemporaryDirectory() as name:
            w = way.go(truth, Path(name) / "rig")
            said = way.accepted(Path(name) / "rig/result", way.others(truth), truth.tick_s) if "accept" in sys.argv and w.played else {}
        head = f"{seed:4} {truth.law:8} {truth.high:7.3g} N {1e3 * truth.tick_s:5.2f} ms"
        beyond += w.beyond > 1.0
        if w.played is None:
            refused += 1
            print(f"{head}  refused ({w.exit_code}): {w.said.strip().splitlines()[-1][:200]}", flush=True)
            continue
        tuned.append(w)
        worse += w.factor < 1.0
        print(f"{head}  error off {w.played['off']:9.3g} N, divided by {w.factor:6.3g}, predicted {w.predicted['off'] / w.predicted['on']:6.3g}; prediction off by {100 * w.off_by('off'):+6.1f} % without, "
              f"{100 * w.off_by('on'):+6.1f} % with; force at most {100 * w.beyond:.3g} %", flush=True)
        if w.astray():
            print(f"{'':5}outside their intervals: {'; '.join(w.astray())}", flush=True)
        for name, against in said.items():
            if (not against) != way.OTHERS[name][2]:
                astray[name] += 1
                print(f"{'':5}accept on {name}: {'; '.join(against) or 'taken'}", flush=True)
    if "accept" in sys.argv:
        print(f"accept: of {len(tuned)} loops judged wrongly " + ", ".join(f"{name} {n}" for name, n in astray.items()))
    if tuned:
        off, on = (np.abs([w.off_by(case) for w in tuned]) for case in ("off", "on"))
        print(f"{len(tuned)} of {count} tuned, {refused} refused, {worse} worse than without, {beyond} beyond the safe force; error divided by {np.median([w.factor for w in tuned]):.3g} (median), "
              f"prediction within 5 % without compensation on {np.mean(off <= 0.05):.0%}, with it on {np.mean(on <= 0.05):.0%}; median {np.median(off):.1%} and {np.median(on):.1%}; lags within their intervals {1 - np.mean([len(w.astray()) for w in tuned]) / len(tuned[0].lags):.0%}")
    return int(worse + beyond > 0)


if __name__ == "__main__":
    sys.exit(main())
