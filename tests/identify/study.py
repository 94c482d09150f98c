"""What tribo-identify is worth on many synthetic logs: study.py coverage|hysteresis|flaws|models|loop|speed [COUNT] [FIRST SEED].

  coverage    of the 95 % intervals of offset and slope, error of L, refusals of sound logs      (500 logs)
  hysteresis  errors of k_min and k_max where they were planned for                               (20)
  flaws       confident answers to logs with a flaw                                               (500)
  models      every truth model: L against the friction of slow sliding
  loop        identified parameters in the closed loop against the true ones                      (20)
  speed       a log of 1e6 rows, with report
"""

import os
import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import synthetic
from synthetic import FLAWS, MODELS, L_of

from tribo_identify import friction
from tribo_identify.events import Refusal

FORCE = np.linspace(0.1, 0.6, 11)


def by_name(result):
    return {e.name: e for e in result.estimates}


def L_hat(result, force):
    if result.table:
        at, plus, _ = np.array(result.table).T
        return np.interp(force, at, plus)
    return result.params["offset_positive"] + result.params["slope_positive"] * force


def confident(result):
    return all(e.verdict == "identified" for e in result.estimates if e.name in ("offset", "slope", "scale"))


def coverage(count=500, first=0):
    hits = {"offset": 0, "slope": 0}
    errors, refused, weak, tables = [], [], 0, 0
    for seed in range(first, first + count):
        truth, rows = synthetic.sound(seed)
        try:
            result = friction.identify(synthetic.log_of(rows))
        except Refusal as refusal:
            refused.append((seed, str(refusal)))
            continue
        if result.table:
            tables += 1
            continue
        found = by_name(result)
        for name in hits:
            hits[name] += abs(found[name].value - truth[name]) <= found[name].half
        errors.append(float(np.max(np.abs(L_hat(result, FORCE) / L_of(truth, FORCE) - 1))))
        weak += not confident(result)
        if errors[-1] > 0.03:
            print(f"seed {seed}: L off by {errors[-1]:.2%}, {'confident' if confident(result) else 'weak'}", flush=True)
        if seed % 10 == 9:
            print(f"{seed + 1 - first}: offset {hits['offset']}, slope {hits['slope']} of {len(errors)}; L within {np.median(errors):.2%} median, {max(errors):.2%} worst;"
                  f" refused {len(refused)}, weak {weak}, tables {tables}", flush=True)
    answered = max(len(errors), 1)
    print(f"coverage: offset {hits['offset'] / answered:.1%}, slope {hits['slope'] / answered:.1%} of {answered}; error of L {np.median(errors):.2%} median, "
          f"{np.quantile(errors, 0.95):.2%} 95 %, {max(errors):.2%} worst; refused {len(refused)} of {count}, weak {weak}, tables {tables}")
    for seed, text in refused:
        print(f"  seed {seed}: {text}")
    return hits, errors, refused


def hysteresis(count=20, first=0):
    errors = {"k_min": [], "k_max": []}
    shown = {"k_min": 0, "k_max": 0}
    for seed in range(first, first + count):
        truth, rows = synthetic.sound(seed, hysteresis=True)
        result = friction.identify(synthetic.log_of(rows))
        found = by_name(result)
        for name, values in errors.items():
            shown[name] += found[name].verdict == "identified"
            values.append(abs(found[name].value / truth[name] - 1))
        print(f"{seed}: k_min {found['k_min'].value:.3g} of {truth['k_min']:.3g} {found['k_min'].verdict}, k_max {found['k_max'].value:.3g} of {truth['k_max']:.3g} {found['k_max'].verdict}", flush=True)
    for name, values in errors.items():
        print(f"{name}: error {np.median(values):.2%} median, {max(values):.2%} worst; identified {shown[name]} of {count}")
    return errors


def flaws(count=500, first=0):
    wrong, refused, causes = [], 0, {}
    for i in range(count):
        flaw, seed = FLAWS[i % len(FLAWS)], first + i
        truth, rows = synthetic.flawed(flaw, seed)
        if i % 35 == 34:
            print(f"{i} done: refused {refused}, wrong {len(wrong)}", flush=True)
        try:
            result = friction.identify(synthetic.log_of(rows))
        except Refusal as refusal:
            refused += 1
            causes.setdefault(flaw, {}).setdefault(refusal.cause, []).append(seed)
            continue
        error = float(np.max(np.abs(L_hat(result, FORCE) / L_of(truth, FORCE) - 1)))
        causes.setdefault(flaw, {}).setdefault("answered", []).append(seed)
        if confident(result) and error > 0.1:
            wrong.append((flaw, seed, error))
            print(f"WRONG: {flaw}, seed {seed}: L off by {error:.1%}", flush=True)
    for flaw, by in causes.items():
        print(f"{flaw:<14}" + ", ".join(f"{cause} {len(seeds)}" for cause, seeds in by.items()))
    print(f"flaws: {refused} of {count} refused, {len(wrong)} answered with confidence and wrong (L off by more than 10 %)")
    return wrong


def sliding(rows, scale, bias, truth):
    """Friction of slow sliding over L, from half the difference of the directions at the same force; as the log has it."""
    log = synthetic.log_of(rows)
    _, ways = friction.find(log)
    net = scale * rows[:, 1] + bias - rows[:, 2]
    way = ways[0]
    return float(np.median(way[way != 0] * net[way != 0] / L_of(truth, rows[way != 0, 2])))


def models(count=1, first=0):
    for model in MODELS:
        for seed in range(first, first + count):
            truth, rows = synthetic.sound(seed, model=model)
            try:
                result = friction.identify(synthetic.log_of(rows))
            except Refusal as refusal:
                print(f"{model:<18} refused: {refusal}", flush=True)
                continue
            slide = sliding(rows, truth["scale"], truth["bias"], truth)
            found = by_name(result)
            scale = found["scale"].value if "scale" in found else np.nan
            print(f"{model:<18} L_hat/L {np.mean(L_hat(result, FORCE) / L_of(truth, FORCE)):.3f}, sliding/L {slide:.3f}, scale {scale / truth['scale']:.3f}, slow slides {result.slide_gap[0]:+.2%} off, F within {result.residual_rms:.2g} N, "
                  f"{'table' if result.table else 'line'}, {'confident' if confident(result) else 'weak'}", flush=True)


def loop(count=20, first=0):
    """RMS of r - F on the triangle: without compensation, with the true parameters, with the identified ones; u scaled by the identified scale."""
    share = []
    for seed in range(first, first + count):
        truth, rows = synthetic.sound(seed)
        p = friction.identify(synthetic.log_of(rows)).params
        rms = {}
        with tempfile.TemporaryDirectory() as name:
            for what, q in (("none", None), ("true", {**truth, "gravity": truth["bias"]}),
                            ("identified", {"offset": p["offset_positive"], "slope": p["slope_positive"], "k_min": p["k_min"], "k_max": p["k_max"], "m": p["m"], "v0": p["v0"], "scale": p["scale"],
                                            "gravity": p["gravity"]})):
                sets = [s for s in synthetic.settings(truth) if not s.startswith("plant.command")]
                applied = truth["scale"] / (q["scale"] if q else truth["scale"])
                sets.append(f"plant.command={{scale_error: {applied - 1}, bias_N: {truth['bias']}}}")
                if q is None:
                    sets.append("compensator.method=off")
                else:
                    sets.append(f"compensator.friction={{k_min: {q['k_min']}, k_max: {q['k_max']}, m: {q['m']}, v0_N_per_s: {q['v0']}, gravity_N: {q['gravity']}, "
                                f"breakaway: {{offset_N: {q['offset']}, slope: {q['slope']}}}}}")
                rms[what] = synthetic.play(Path(name), synthetic.ROOT / "host_sim/scenarios/triangle.yaml", sets)["rms_error_N"]
        share.append((rms["none"] - rms["identified"]) / (rms["none"] - rms["true"]))
        print(f"{seed}: {1e3 * rms['none']:.3f} mN without, {1e3 * rms['true']:.3f} with the true, {1e3 * rms['identified']:.3f} with the identified: {share[-1]:.1%} of the improvement", flush=True)
    print(f"loop: {np.median(share):.1%} median, {min(share):.1%} least of the improvement")
    return share


def speed():
    """A log of a million rows, by the command line."""
    from tribo_identify import cli

    _, rows = synthetic.sound(0)
    times = int(np.ceil(1e6 / len(rows)))
    long = np.tile(rows, (times, 1))[:1_000_000]
    long[:, 0] = np.arange(len(long)) * 1e-3
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path = synthetic.write_log(folder, long)
        begin, before = time.monotonic(), sum(resource.getrusage(w).ru_utime + resource.getrusage(w).ru_stime for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
        status = cli.main(["friction", str(path), "--out", str(folder / "out")])
        used = sum(resource.getrusage(w).ru_utime + resource.getrusage(w).ru_stime for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)) - before
    print(f"speed: {len(long)} rows in {time.monotonic() - begin:.1f} s, {used:.1f} s of processor time, status {status}")
    return used


if __name__ == "__main__":
    os.nice(5)
    what = {f.__name__: f for f in (coverage, hysteresis, flaws, models, loop, speed)}
    if len(sys.argv) < 2 or sys.argv[1] not in what:
        sys.exit(__doc__)
    what[sys.argv[1]](*map(int, sys.argv[2:]))
