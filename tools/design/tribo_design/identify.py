"""identify-plant: gain and poles from an open-loop step response (Fig. 10 of the paper).

Models of order 1, 2, ... (no zeros, real poles and complex pairs) are fitted by least squares (scipy); the order is the one
with the least BIC. Confidence intervals are 95 %, from the Jacobian and Student's t, with as many independent samples as the
residual's autocorrelation leaves. The fit figure is taken where the response moves: a long flat tail would flatter it.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import control as ct
import numpy as np
import scipy.optimize
import scipy.signal
import scipy.stats

from . import __version__
from .config import format_root, read_rows, read_text
from .errors import DesignError, InputError
from .systems import Zpk, state_space

SAMPLES_MIN, SAMPLES_MAX = 20, 200_000
FIT_SAMPLES_MAX = 4000
CHANGES_MAX = 50  # of u, up to which its steps' responses are added up
ORDER_MAX = 6


@dataclass(frozen=True)
class Data:
    time: np.ndarray
    u: np.ndarray  # at every sample of the record; time and y at every step-th
    y: np.ndarray
    step: int = 1


@dataclass
class Fit:
    order: int
    pairs: int
    theta: np.ndarray  # log of the real poles' and pairs' sizes, damping logits; the gain and offset are solved linearly
    gain: float
    offset: float
    poles: np.ndarray
    residual: np.ndarray
    bic: float
    model: np.ndarray


def load_step(path, step_size=None):
    text, _ = read_text(path)
    rows = read_rows(path, text)
    head = [c.lower() for c in rows[0][1]]
    columns = {}
    for name, aliases in (("t", ("t", "t_s", "time", "time_s")), ("u", ("u", "u_n", "input")), ("y", ("y", "y_n", "f", "f_n", "output"))):
        found = [i for i, c in enumerate(head) if c in aliases]
        if len(found) > 1:
            raise InputError(f"{path}:{rows[0][0]}: column {name}: is given twice")
        if found:
            columns[name] = found[0]
    for name in ("t", "y"):
        if name not in columns:
            raise InputError(f"{path}:{rows[0][0]}: column {name}_{'s' if name == 't' else 'n'}: is missing; the first row must name t_s, y_n and perhaps u_n")
    if "u" not in columns and step_size is None:
        raise InputError(f"{path}: no column u_n: give the step's height with --step-size")
    if step_size is not None and not (np.isfinite(step_size) and step_size != 0):
        raise InputError(f"--step-size: value {step_size:g}: must be finite and not 0")
    values = {name: [] for name in columns}
    for line, row in rows[1:]:
        for name, i in columns.items():
            text = row[i] if i < len(row) else ""
            try:
                value = float(text)
            except ValueError:
                raise InputError(f"{path}:{line}: {name}: value {text!r}: must be a number") from None
            if not np.isfinite(value):
                raise InputError(f"{path}:{line}: {name}: value {text!r}: must be finite")
            values[name].append(value)
    time, y = np.array(values["t"]), np.array(values["y"])
    if not SAMPLES_MIN <= len(time) <= SAMPLES_MAX:
        raise InputError(f"{path}: {len(time)} samples; must be {SAMPLES_MIN} to {SAMPLES_MAX}")
    steps = np.diff(time)
    if not np.all(steps > 0):
        line = rows[1 + int(np.argmax(steps <= 0)) + 1][0]
        raise InputError(f"{path}:{line}: t: value {time[int(np.argmax(steps <= 0)) + 1]:g}: time must rise from row to row")
    if steps.max() > 1.05 * np.median(steps) or steps.min() < 0.95 * np.median(steps):
        line = rows[1 + int(np.argmax(np.abs(steps - np.median(steps)))) + 1][0]
        raise InputError(f"{path}:{line}: t: samples must be evenly spaced within 5 % (the median step is {np.median(steps):g} s)")
    if "u" in values:
        u = np.array(values["u"])
        if np.ptp(u) == 0 and u[0] == 0:
            raise InputError(f"{path}: u: is 0 throughout: there is no step in it")
        if np.ptp(u) > 0:
            u = u - u[0]  # the operating point before the step
    else:
        u = np.full(len(time), float(step_size))
    if np.ptp(y) == 0:
        raise InputError(f"{path}: y: does not move: nothing can be identified")
    return Data(time - time[0], u, y)


def _poles(theta, pairs):
    pairs_part, reals = theta[: 2 * pairs], theta[2 * pairs :]
    out = [complex(-np.exp(r)) for r in reals]
    for size, logit in zip(pairs_part[0::2], pairs_part[1::2]):
        damping = 1 / (1 + np.exp(-logit))
        size = np.exp(size)
        out += [size * complex(-damping, np.sqrt(1 - damping**2)), size * complex(-damping, -np.sqrt(1 - damping**2))]
    return np.array(out)


def _powers(matrix, vector, count):
    """[v, m v, m^2 v, ...], by doubling."""
    states = vector[:, None]
    while states.shape[1] < count:
        states = np.hstack([states, matrix @ states])
        matrix = matrix @ matrix
    return states[:, :count]


def _unit_response(theta, pairs, data):
    """The response of the model of gain 1 to u, held between samples."""
    poles = _poles(theta, pairs)
    system = state_space(Zpk([], poles, 1.0).with_value_at(0.0, 1.0))
    dt = float(np.median(np.diff(data.time))) / data.step
    a, b, c, d, _ = scipy.signal.cont2discrete(ct.ssdata(system), dt, "zoh")
    n, rows = len(data.u), len(data.time)
    changes = np.flatnonzero(np.diff(data.u, prepend=0.0))
    if len(changes) > CHANGES_MAX:
        impulse = np.r_[d[0], (c @ _powers(a, b[:, 0], n))[0]][:n]
        return scipy.signal.fftconvolve(data.u, impulse)[: n : data.step]
    held = np.block([[a, b], [np.zeros((1, len(a))), np.ones((1, 1))]])  # with a constant input among the states
    by_row, output = np.linalg.matrix_power(held, data.step), np.hstack([c, d])[0]
    out = np.zeros(rows)
    for k in changes:
        first = -(-k // data.step)  # row that sees it
        start = np.linalg.matrix_power(held, first * data.step - k)[:, -1]
        out[first:] += (data.u[k] - (data.u[k - 1] if k else 0.0)) * (output @ _powers(by_row, start, rows - first))
    return out


def _linear(column, y):
    """Gain and offset that fit y best, and the residual."""
    matrix = np.stack([column, np.ones(len(y))], axis=1)
    solution, *_ = np.linalg.lstsq(matrix, y, rcond=None)
    return solution, y - matrix @ solution


def _thinned(data):
    """The fit looks at FIT_SAMPLES_MAX samples of y at most, evenly spaced; u stays whole, as its steps' times matter."""
    if len(data.time) <= FIT_SAMPLES_MAX:
        return data
    step = int(np.ceil(len(data.time) / FIT_SAMPLES_MAX))
    return Data(data.time[::step], data.u, data.y[::step], step)


def fit_order(data, order):
    best = None
    span = data.time[-1]
    dt = float(np.median(np.diff(data.time)))
    moving = np.abs(data.y - data.y[-1]) > 0.37 * max(np.ptp(data.y), 1e-300)
    guess = max(float(data.time[moving][-1]) if np.any(moving) else span / 10, dt)
    for pairs in range(order // 2 + 1):
        reals = order - 2 * pairs
        for spread in (1.5, 4.0):
            sizes = np.log(order / guess) + np.log(spread) * np.linspace(-0.3, 1, max(order, 1)) * (order > 1)
            theta = []
            for i in range(pairs):
                theta += [sizes[min(2 * i + 1, order - 1)], 0.0]
            theta += list(sizes[[j for j in range(order)][-reals:]] if reals else [])
            lower = np.array([np.log(0.01 / span), -7.0] * pairs + [np.log(0.01 / span)] * reals)
            upper = np.array([np.log(100 / dt), 7.0] * pairs + [np.log(100 / dt)] * reals)
            theta = np.clip(np.array(theta), lower + 1e-6, upper - 1e-6)
            try:
                found = scipy.optimize.least_squares(lambda t, p=pairs: _linear(_unit_response(t, p, data), data.y)[1], theta, bounds=(lower, upper),
                                                     xtol=1e-12, ftol=1e-12, gtol=1e-14, max_nfev=100)
            except (ValueError, np.linalg.LinAlgError):
                continue
            if best is None or found.cost < best[0]:
                best = (found.cost, pairs, found.x)
    if best is None:
        return None
    _, pairs, theta = best
    column = _unit_response(theta, pairs, data)
    (gain, offset), residual = _linear(column, data.y)
    n = len(data.y)
    variance = max(float(residual @ residual) / n, 1e-300)
    return Fit(order, pairs, theta, float(gain), float(offset), _poles(theta, pairs), residual, n * np.log(variance) + (order + 2) * np.log(n), data.y - residual)


def identify(data, order=None):
    """(the fit, figures)."""
    data = _thinned(data)
    fits = []
    for n in [order] if order else range(1, ORDER_MAX + 1):
        fit = fit_order(data, n)
        if fit is not None:
            fits.append(fit)
        if len(fits) >= 3 and order is None and fits[-1].bic > fits[-2].bic > fits[-3].bic:
            break
    if not fits:
        raise DesignError("no model of the asked order fits this response")
    best = min(fits, key=lambda f: f.bic)
    return best, figures(best, data, fits)


def figures(fit, data, fits):
    n, parameters = len(data.y), fit.order + 2

    def whole(p):
        return p[-2] * _unit_response(p[:-2], fit.pairs, data) + p[-1]

    p = np.r_[fit.theta, fit.gain, fit.offset]
    jacobian = np.empty((n, len(p)))
    for i in range(len(p)):
        step = 1e-5 * max(abs(p[i]), 0.1)
        up, down = p.copy(), p.copy()
        up[i] += step
        down[i] -= step
        jacobian[:, i] = (whole(up) - whole(down)) / (2 * step)
    centred = fit.residual - fit.residual.mean()
    power = float(centred @ centred)
    rho = float(np.clip(centred[1:] @ centred[:-1] / power, 0, 0.999)) if power > 0 else 0.0
    independent = max(n * (1 - rho) / (1 + rho), parameters + 1)
    variance = float(fit.residual @ fit.residual) / max(n - parameters, 1) * n / independent
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0] = 1.0
    q, s, v = np.linalg.svd(jacobian / scale, full_matrices=False)
    covariance = (v.T / np.maximum(s, 1e-12 * s[0]) ** 2) @ v * variance / np.outer(scale, scale)
    t = float(scipy.stats.t.ppf(0.975, max(independent - parameters, 1)))
    half = t * np.sqrt(np.maximum(np.diag(covariance), 0))
    poles = []
    dt = float(np.median(np.diff(data.time)))

    def entry(pole, size_half, part_half):
        relative = size_half
        visible = relative < 1.0 and abs(pole) < np.pi / dt
        return {"pole": format_root(pole), "re": pole.real, "im": pole.imag, "size_low": abs(pole) * np.exp(-min(size_half, 700)), "size_high": abs(pole) * np.exp(min(size_half, 700)),
                "part_half_width": part_half, "identifiable": bool(visible)}

    for i in range(fit.pairs):
        size, logit = np.exp(fit.theta[2 * i]), fit.theta[2 * i + 1]
        damping = 1 / (1 + np.exp(-logit))
        gradient = np.array([-size * damping, -size * damping * (1 - damping)])
        block = covariance[2 * i : 2 * i + 2, 2 * i : 2 * i + 2]
        part = t * float(np.sqrt(max(gradient @ block @ gradient, 0)))
        pole = size * complex(-damping, np.sqrt(1 - damping**2))
        poles.append(entry(pole, half[2 * i], part))
        poles.append(entry(np.conj(pole), half[2 * i], part))
    for i in range(2 * fit.pairs, fit.order):
        size = float(np.exp(fit.theta[i]))
        poles.append(entry(complex(-size), half[i], half[i] * size))
    moves = fit.model - fit.offset
    settled = np.abs(moves - moves[-1]) > 0.02 * np.ptp(moves) if np.ptp(moves) > 0 else np.ones(n, bool)
    last = int(np.flatnonzero(settled)[-1]) + 1 if np.any(settled) else n
    window = slice(0, max(min(last, n), parameters + 2))
    y = data.y[window]
    fit_figure = 100 * (1 - np.linalg.norm(fit.residual[window]) / max(np.linalg.norm(y - y.mean()), 1e-300))
    all_figure = 100 * (1 - np.linalg.norm(fit.residual) / max(np.linalg.norm(data.y - data.y.mean()), 1e-300))
    return {"order": fit.order, "gain": fit.gain, "gain_half_width": float(half[-2]), "offset": fit.offset, "offset_half_width": float(half[-1]), "poles": poles,
            "fit_percent_where_it_moves": float(fit_figure), "fit_percent_all": float(all_figure), "residual_rms": float(np.sqrt(np.mean(fit.residual**2))),
            "residual_lag1": rho, "samples": n, "independent_samples": float(independent),
            "bic": {str(f.order): float(f.bic) for f in fits}}


def command(options):
    if options.order is not None and not 1 <= options.order <= ORDER_MAX:
        raise InputError(f"--order: value {options.order}: must be at least 1 and at most {ORDER_MAX}")
    data = load_step(options.step, options.step_size)
    if options.out:
        from .output import check_replaceable

        check_replaceable(options.out, NAMES)
    fit, found = identify(data, options.order)
    text = describe(found)
    print(text)
    if options.out:
        from .output import write_directory

        files = {"plant.yaml": plant_yaml(found, Path(options.step).name).encode(), "identification.json": (json.dumps(found, indent=1) + "\n").encode(),
                 "report.md": ("# Plant from a step response\n\n```\n" + text + "\n```\n\n![Fit](fit.png)\n").encode(), "fit.png": _plot(fit, _thinned(data))}
        write_directory(options.out, files, NAMES)
        print(f"wrote {options.out}: {', '.join(sorted(files))}")
    return 0


NAMES = ("plant.yaml", "identification.json", "report.md", "fit.png")


def describe(found):
    lines = [f"order {found['order']} (BIC: " + ", ".join(f"{k}: {v:.6g}" for k, v in found["bic"].items()) + ")",
             f"gain  {found['gain']:.6g} +- {found['gain_half_width']:.2g} (95 %)"]
    for p in found["poles"]:
        if not p["identifiable"]:
            lines.append(f"pole  {p['pole']} rad/s: NOT identifiable from this record (faster than the sampling, or within the noise)")
        elif p["im"]:
            lines.append(f"pole  {p['re']:.5g}{p['im']:+.5g}j rad/s, size {p['size_low']:.5g} to {p['size_high']:.5g}, real part +- {p['part_half_width']:.2g} (95 %)")
        else:
            lines.append(f"pole  {p['re']:.5g} rad/s, {-p['size_high']:.5g} to {-p['size_low']:.5g} (95 %)")
    lines += [f"fit   {found['fit_percent_where_it_moves']:.2f} % where the response moves ({found['fit_percent_all']:.2f} % of the whole record); residual {found['residual_rms']:.3g} rms, "
              f"neighbouring residuals correlate by {found['residual_lag1']:.2f}"]
    if found["residual_lag1"] > 0.5:
        lines.append("note  the residual is not noise: the model misses something (friction, a delay, a zero), and its intervals hold only if that is small")
    if found["fit_percent_where_it_moves"] < 80:
        lines.append("note  a poor fit: do not design on this model")
    return "\n".join(lines)


def plant_yaml(found, source):
    roots = ", ".join(f"{p['re']:.6g}{p['im']:+.6g}j" if p["im"] else f"{p['re']:.6g}" for p in found["poles"])
    doubts = "".join(f"# pole {p['pole']} is NOT identifiable from this record\n" for p in found["poles"] if not p["identifiable"])
    return (f"# From {source} by tribo-design {__version__} identify-plant; paste into a design file.\n"
            f"# fit where it moves {found['fit_percent_where_it_moves']:.2f} %\n{doubts}plant:\n  gain: {found['gain']:.6g}\n  zeros: []\n  poles: [{roots}]\n")


def _plot(fit, data):
    from .plots import _figure, _png

    figure, axes = _figure(2, 1, (9, 6))
    axes[0, 0].plot(data.time, data.y, color="#56B4E9", lw=2.5, label="measured")
    axes[0, 0].plot(data.time, fit.model, color="#000000", lw=1.2, ls="--", label=f"model of order {fit.order}")
    axes[0, 0].legend()
    axes[0, 0].set_ylabel("y")
    axes[1, 0].plot(data.time, fit.residual, color="#D55E00", lw=0.9)
    axes[1, 0].set_ylabel("residual")
    axes[1, 0].set_xlabel("time [s]")
    return _png(figure)
