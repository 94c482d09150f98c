"""The design's loop with friction in it, played by tribo-sim: gamma alone does not choose a force controller."""

import json
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import tuning

STIFFNESS = 3.84  # N/deg, the paper's value. Only the ratios of inertia and damping to it matter
INSTANT = 1e8  # rad/s: stands for the pole of an actuator or sensor without one
PERIODS = 3
CASES = {"without": ("--set", "compensator.method=off"), "with": ()}  # options of tribo-sim for the unchanged scenario


@dataclass(frozen=True)
class Chain:
    """The plant in tribo-sim's form: actuator pole, arm, sensor pole."""

    actuator: float
    sensor: float
    inertia: float
    damping: float


def chain_of(plant, h):
    """(Chain, "") or (None, why not). Poles of ten Nyquist frequencies and more count as instantaneous."""
    if len(plant.zeros):
        return None, "the plant has zeros, tribo-sim's has none"
    if np.any(plant.poles.real >= 0):
        return None, "the plant is not stable, tribo-sim's is"
    slow = [p for p in plant.poles if abs(p) < 10 * np.pi / h]
    pairs, reals = [p for p in slow if p.imag > 0], sorted((p.real for p in slow if p.imag == 0), key=abs)
    if len(pairs) > 1 or len(slow) > 4 or not slow:
        return None, f"the plant has {len(slow)} poles below ten Nyquist frequencies, {len(pairs)} complex pairs among them; tribo-sim's has four and one"
    if pairs:
        product, total = abs(pairs[0]) ** 2, -2 * pairs[0].real
    else:  # of four poles the sensor gets the slowest, the actuator the fastest, the arm the two between
        middle = [reals.pop(1), reals.pop(1)] if len(reals) == 4 else [reals.pop(0), reals.pop(0)] if len(reals) >= 2 else [reals.pop(0), -100 * np.pi / h]
        product, total = middle[0] * middle[1], -(middle[0] + middle[1])
    actuator = -reals.pop() if reals else INSTANT
    sensor = -reals.pop() if reals else INSTANT
    return Chain(actuator, sensor, STIFFNESS / product, STIFFNESS * total / product), ""


def scenario(design, plant, f32, source):
    """The scenario's text; None for a tick longer than tribo-sim knows. Its u is in newton of F at rest, so that the plant's gain counts."""
    h, limit, full = design.sample_time_s, design.fixed_point.limit_n, design.fixed_point.full_scale_n
    if h > 0.1:
        return None
    chain, why = chain_of(plant, h)
    scaled = ""  # a note for the reader of the scenario; tribo-sim params copies it
    gain = plant.at_zero() if chain is not None else 1.0
    limit_f = abs(gain) * limit
    full_f = max(full, limit_f)  # of both e and u
    top = min(0.3 * limit, 0.5 * limit_f)
    rows = np.array(f32, float)
    rows[-1, :3] *= gain
    sections = [", ".join(f"{k}: {value:.9g}" for k, value in zip(("b0", "b1", "b2", "a1", "a2"), row)) for row in rows]
    # The paper's friction, if full scale and sample time can represent it.
    friction = [] if 1 <= round(3e-3 / h) <= 63 else [f"    pulse_width_s: {3 * h:.9g} # three ticks"]
    offset = 0.007 if 1e-5 * full_f <= 0.007 <= 0.1 * full_f else 0.0035 * full_f
    friction += [] if offset == 0.007 else [f"    breakaway: {{offset_N: {offset:.9g}}}"]
    slowest = 3 * full_f / (6 * 2**31 * h)  # v0 below this is less than one bit per tick
    friction += [] if 2 * slowest <= 0.007 else [f"    v0_N_per_s: {2 * slowest:.9g}"]
    lines = [f'# A force loop with the controller "{design.name}", made by tribo-design of {source}.']
    usual = min(limit_f / 4, top)  # the limits of a plant with a large gain are far above its typical reference
    rig = {"offset": offset, "usual-force": usual, "sample-time": h, "full-scale": full_f}
    if chain is None:
        lines += [f"# The plant and the arm are the paper's, as {why}."]
        arm, parts = None, [f"plant: {{step_s: {h / 10:.9g}}}"]
    else:
        lines += ["# The plant is the design's."]
        if abs(gain - 1) > 1e-9:
            scaled = f"; put u / {gain:.9g} out"
            lines += [f"# u is in newton of F at rest, so the last section has the plant's gain of {gain:.6g} in it and the header's has not: put u / {gain:.9g} out."]
        arm = f"{{inertia_N_s2_per_deg: {chain.inertia:.9g}, damping_N_s_per_deg: {chain.damping:.9g}, stiffness_N_per_deg: {STIFFNESS:.9g}}}"
        parts = [f"plant: {{step_s: {h / 10:.9g}, actuator_pole_rad_per_s: {chain.actuator:.9g}, arm: {arm}}}",
                 f"sensor: {{pole_rad_per_s: {chain.sensor:.9g}" + (f", delay_s: {design.delay_s:.9g}" if design.delay_s else "") + "}"]
        rig |= {"actuator-pole": chain.actuator, "sensor-pole": chain.sensor,
                "inertia": chain.inertia, "damping": chain.damping, "stiffness": STIFFNESS}
    lines += ["# Its friction is the paper's: copy it, give your rig's under compensator and plant, and put what tribo-design tune makes of it into compensator.",
              "# tribo-sim run plays it, tribo-sim params makes a drive's params of it."]
    return "\n".join([
        *lines, f'description: "a triangle with the controller {design.name}{scaled}"', f"duration_s: {20 * PERIODS}", f"sample_time_s: {h:.9g}",
        f"reference: {{kind: triangle, low_N: {2 * top / 3:.9g}, high_N: {top:.9g}, period_s: 20}}", *parts,
        "controller:", "  kind: delta", "  sections:", *(f"    - {{{section}}}" for section in sections),
        *tuning.as_yaml(tuning.tuned(rig)).splitlines(), *([f"  usual_force_N: {usual:.9g}"] if usual < limit_f / 4 else []), *([f"  arm: {arm}"] if arm else []), *(["  friction:", *friction] if friction else []),
        f"limits: {{u_min_N: {-limit_f:.9g}, u_max_N: {limit_f:.9g}, input_max_N: {full:.9g}, full_scale_N: {full_f:.9g}}}",
        "metrics: {start_s: 20}", ""])


def find_tribo_sim():
    """TRIBO_SIM, or the one in PATH, or one that is built here."""
    named = os.environ.get("TRIBO_SIM")
    if named is not None:
        return named if os.access(named, os.X_OK) else None
    built = sorted(Path(__file__).resolve().parents[3].glob("build/**/host_sim/tribo-sim"), key=lambda p: p.stat().st_mtime)
    return shutil.which("tribo-sim") or (str(built[-1]) if built else None)


def play(design, plant, f32, traces=False):
    """{"rms_n": {"without": ..., "with": ...}, "max_n": ...}, or {"reason": why it was not played}. With `traces` the last period of each."""
    text = scenario(design, plant, f32, "the design")
    if text is None:
        return {"reason": "a tick of more than 0.1 s"}
    why = chain_of(plant, design.sample_time_s)[1]
    if why:
        return {"reason": why}
    program = find_tribo_sim()
    if program is None:
        return {"reason": "no tribo-sim was found (build it, or set TRIBO_SIM to it)"}
    out = {"rms_n": {}, "max_n": {}}
    shown = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "loop.yaml"
        path.write_text(text)
        for case, options in CASES.items():
            done = subprocess.run([program, "run", path, "--json", *options, "--out", Path(folder) / case], capture_output=True, text=True, timeout=300, check=False)
            if done.returncode != 0:
                return {"reason": f"tribo-sim refuses it: {(done.stderr.strip().splitlines() or ['no message'])[-1].replace(folder, '')}"}
            summary = json.loads(done.stdout)
            out["rms_n"][case], out["max_n"][case] = summary["rms_error_N"], summary["max_error_N"]
            if traces:
                shown[case] = _trace(Path(folder) / case / "trace.csv")
    if traces:
        out["traces"] = shown
    return out


def _trace(path):
    """Time, reference and force of the last period."""
    head, *rows = path.read_text().splitlines()
    columns = [head.split(",").index(name) for name in ("t_s", "r_N", "F_N")]
    data = np.genfromtxt(rows[len(rows) * (PERIODS - 1) // PERIODS :: max(len(rows) // 30_000, 1)], delimiter=",", usecols=columns)
    return data.T


def in_words(played):
    if "reason" in played:
        return f"with friction: not simulated, as {played['reason']}"
    without, with_it = played["rms_n"]["without"], played["rms_n"]["with"]
    said = f"with the paper's friction, triangle, RMS of r - F: {without:.4g} N without compensation, {with_it:.4g} N with it "
    if with_it >= without:
        return said + f"(WARNING: {with_it / without:.2f} times the error: compensation makes this loop {'worse' if with_it > without else 'no better'})"
    return said + f"({without / with_it:.2f} times less)"
