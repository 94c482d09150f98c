"""Friction that builds up over a way: does Dahl's model explain the slides better than the paper's, and with which way and breakaway?

The paper's model, which the fit of tribo_identify has, sticks until breakaway. Where the arm gives way before, the fit finds a breakaway some
percent too large, and no simulation with it says what a controller meets. So tribo-sim plays the log's u on both.
"""

import copy
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.optimize

from tribo_design.output import yaml_text
from tribo_identify import accept, events, native

SLIDES_S = 20.0  # of the slides, behind the steps
SETTLED_S = 4.0  # until the force with which the arm stood in the beginning is forgotten
SMALL = 5e-3  # of a usual breakaway: a residual that is good enough
BETTER = 0.8  # of the residual: Dahl's is taken below it
START = (0.97, 0.05)  # breakaway over the fit's; the way over a usual breakaway, both in newton of F
CALLS = 18


@dataclass
class Presliding:
    times: float  # breakaway over that of the fit
    way: float  # in which friction builds up, in newton of F; 0: the paper's model
    plant: dict  # keys of the plant
    residual_rms: float  # of F, averages of 20 ms


def fit(loop, segment, split_s, scale, level):
    """What is better than the paper's model, or the paper's. `loop` has what was fitted; `level` is a usual breakaway."""
    rows = slice(0, int((split_s + SLIDES_S) / segment.h))
    u, force = segment.u[rows], segment.force[rows]
    size = events.bin_size(segment.h)
    settled = int(SETTLED_S / segment.h / size)
    tree = copy.deepcopy(loop)
    tree |= {"duration_s": float(len(u) * segment.h), "reference": {"kind": "csv", "file": "u.csv"}, "controller": {"kind": "none"}, "compensator": {"method": "off"},
             "limits": {name: 10 * value for name, value in loop["limits"].items()} | {"u_min_N": -10 * loop["limits"]["u_max_N"]}}
    del tree["metrics"], tree["sensor"]["noise_N"]

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.savetxt(folder / "u.csv", np.c_[np.arange(len(u)) * segment.h, scale * u], delimiter=",", header="t_s,r_N", comments="", fmt="%.9g")

        def left(times, plant):
            one = copy.deepcopy(tree)
            one["plant"] |= {"friction": accept.scaled(loop["plant"]["friction"], times), **plant}
            y = accept.trace_of(one, 0.0, folder)[3]
            n = min(len(y), len(force))
            return float(np.sqrt(np.mean(events.binned(y[:n] - force[:n], size)[settled:] ** 2)))

        plain = left(1.0, {})
        found = scipy.optimize.minimize(lambda x: left(float(np.exp(x[0])), _dahl(x[1])), np.log(START), method="Nelder-Mead",
                                        options={"maxfev": CALLS, "initial_simplex": np.log([START, (1.02, START[1]), (START[0], 3 * START[1])])})
    if found.fun > BETTER * plain or plain < SMALL * level:
        return Presliding(1.0, 0.0, {}, plain)
    return Presliding(float(np.exp(found.x[0])), float(np.exp(found.x[1])) * level, _dahl(found.x[1]), float(found.fun))


def _dahl(log_way):
    return {"model": "dahl", "dahl": {"stiffness_N_per_deg": float(np.clip(np.exp(-log_way), 1.0, 1e6))}}

