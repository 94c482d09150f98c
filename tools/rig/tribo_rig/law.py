"""Breakaway and command for the law of friction that the steps have shown, from steps and slides together.

The fit of tribo_identify uses the paper's model, which sticks until breakaway and acts on the net force. On another arm its breakaway is up to some
percent off, and a simulation with it does not predict what a controller meets. The difference of the two counts as an error of the result.
"""

from dataclasses import dataclass, replace

import numpy as np

from tribo_identify import friction

from . import lags as steps

PASSES = 15
FITTED = {*friction.SYMMETRIC, *friction.CALIBRATED}
FALLING = ("sliding_ratio", "stribeck_speed_deg_per_s")
UNEXPLAINED = 1.5  # times the noise: the largest residual of a law


@dataclass
class Law:
    way: float  # N of F over which friction builds up; 0: it does not
    falls: float  # part of sliding by which breakaway is above it
    falls_half: float  # of its 95 % interval
    speed: float  # of F where most of that is gone, N/s
    plant: dict  # keys of the plant


def _law(found, p, falls_half):
    model, own = steps.model_of(found.law), steps.own_of(found.law, p, found.level)
    own = {name: value if isinstance(value, bool) else float(f"{value:.9g}") for name, value in own.items() if p["falls"] or name not in FALLING}
    keys = {} if model == "paper" else {"model": model} | ({model: own} if own else {})
    return Law(p["way"] if model in steps.BUILDS_UP else 0.0, p["falls"], falls_half, p["speed"], keys)


def fit(found, result, segment, first):
    """(friction, law): `result` with the values of the law if it is not the paper's. `found` holds the lags, which stay fixed."""
    if found.law == "paper" or result.table:
        return _covering(result, found, first), _law(found, found.params, 0.0)
    problem = steps.Fit(segment, first, {"actuator", "arm", "ratio", "sensor", "delay"}, result.assume)
    _, theta, halves = problem.solve(found.law, found.theta, PASSES)
    p = problem.params(theta)
    halves = dict(zip(steps.NAMES, halves))
    halves |= {f"{n}_positive": halves[n] for n in ("offset", "slope")}
    values = p | {"offset": p["offset_positive"], "slope": p["slope_positive"]}
    middle = (result.loads[0][0] + result.loads[-1][1]) / 2
    before = float(np.mean(friction.breakaway(result.params, [], middle)))
    estimates = [replace(e, value=values[e.name], half=float(np.hypot(max(e.half, halves[e.name]), abs(values[e.name] - e.value)))) if e.name in FITTED else e for e in result.estimates]
    params = result.params | {n: p[n] for n in ("scale", "gravity", "offset_positive", "offset_negative", "slope_positive", "slope_negative")}
    L = float(np.mean(friction.breakaway(params, [], middle)))
    model = problem.output(found.law, theta)
    left = float(np.sqrt(np.mean((model - segment.force)[problem.begin :] ** 2)))
    result = replace(result, estimates=estimates, params=params, model=[model[-len(result.model[0]) :]], L_half=float(np.hypot(result.L_half, abs(L / before - 1))), residual_rms=left)
    return _covering(result, found, first), _law(found, p, halves["falls"])


def _covering(result, found, first):
    """The half interval of L, widened by a residual well beyond the noise, which may be friction that the law does not have."""
    beyond = max(result.residual_rms**2 - (UNEXPLAINED * first.noise) ** 2, 0.0) ** 0.5
    return replace(result, L_half=float(np.hypot(result.L_half, 1.96 * beyond / found.level)))
