"""identify-plant: gain, dead time and poles from open-loop step responses (Fig. 10 of the paper), and what the record cannot tell.

Model       y = offset + g H(s) e^(-s tau) (u - friction), H of unit gain, real poles and complex pairs, perhaps an integrator.
Friction    while the arm slides it is L or -L by the direction of the last step, so it acts as one more input: its columns are
            H of that direction, and of the unknown friction before the first step; with enough levels also of direction x |y|.
            One step in one direction cannot tell g from friction: g is then "not separable".
Noise       white, plus a random walk (an integrated moving average with one parameter, which whitens residual and columns alike), hum
            (sines found in the residual's spectrum), and outliers (a column of their own each). The residual must then be white over
            many lags (Ljung-Box); where it is not, gain and friction are taken from the plateaus alone, whose scatter
            says how far they can be trusted, or nothing is said.
Structure   the one with the least BIC of all orders, with and without dead time and integrator, each from several starts. Responses are
            sums of modes in closed form. Intervals are 95 %, from the optimum's Jacobian and Student's t, over all sizes that the walk may
            have, weighted by their restricted likelihood.
"""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy.linalg
import scipy.optimize
import scipy.special

from tribo_plot.version import version

from . import progress
from .reading import format_root, printable
from .errors import DesignError, InputError

SAMPLES_MIN, SAMPLES_MAX = 20, 200_000
SEARCH_ROWS, FIT_ROWS = 600, 4000  # of the record, that the search for a structure and the last fit look at
CHANGES_LOOP = 200  # of u, up to which modes are carried from change to change; beyond, from sample to sample
ORDER_MAX = 6
FINE, COARSE = {"xtol": 1e-8, "ftol": 1e-9, "gtol": 1e-10}, {"xtol": 1e-6, "ftol": 1e-7, "gtol": 1e-8}
SPACING = 2e-3  # least relative distance of two poles in a sum of modes
LOGIT_MAX = 7.0
GRID, GRID_LOGITS = 24, (-2.5, -0.5)  # sizes and dampings (0.08, 0.4) of a pair that is looked for
WHITE = 1e-3  # probability of a residual as coloured as this, if it were noise
BIC_CLOSE = 6.0
RIVAL = 0.3  # of BIC, beyond the price of one parameter: how near a structure must be to count as well
SETTLED = 6.0  # time constants in the record
NOTHING = 1e-6  # of y's range: a residual that is the fit's own rounding
HOPELESS = 100.0  # of BIC: such a structure needs no more poles


@dataclass(frozen=True)
class Data:
    time: np.ndarray
    u: np.ndarray
    y: np.ndarray


def read_step(options):
    """The log of a step by the reader of all logs. Unless --column says otherwise its names are those of the tools, or t_s, u_n and y_n."""
    from tribo_identify import logs

    words = logs.arguments_of(options, needs_u=False)
    log = logs.read([options.step], words)
    if options.column or log.segments[0].force is not None:
        return log
    force = ["--column", "F=y_n"]
    if options.step_size is not None:
        return logs.read([options.step], [*words, *force])
    try:
        return logs.read([options.step], [*words, *force, "--column", "u=u_n"])
    except InputError as error:
        raise InputError(f"{error}; --column says where u and F are, --step-size the height of a step of u that was not logged" if "column" in str(error) else str(error)) from None


def data_of(log, step_size=None):
    """One record, from rest."""
    if len(log.segments) != 1:
        raise InputError(f"{log.segments[1].file}: {len(log.segments)} pieces; poles are found in one record without gaps")
    s = log.segments[0]
    if s.force is None:
        raise InputError(f"{s.file}: there is no force: name its column (--column F=...)")
    if step_size is not None and not (np.isfinite(step_size) and step_size != 0):
        raise InputError(f"--step-size: value {step_size:g}: must be finite and not 0")
    if step_size is not None and np.ptp(s.u) > 0:
        raise InputError(f"--step-size: {s.file} has a u that moves, so the height of the step is known; leave the option out")
    if not SAMPLES_MIN <= len(s.t) <= SAMPLES_MAX:
        raise InputError(f"{s.file}: {len(s.t)} samples; must be {SAMPLES_MIN} to {SAMPLES_MAX}")
    u = s.u if step_size is None else np.full(len(s.t), float(step_size))
    if np.ptp(u) == 0 and u[0] == 0:
        raise InputError(f"{s.file}: u is 0 throughout: there is no step in it; --step-size gives the height of one that was not logged")
    if np.ptp(s.force) == 0:
        raise InputError(f"{s.file}: F does not move: nothing can be identified")
    return Data(s.t - s.t[0], u - u[0] if np.ptp(u) > 0 else u, s.force)  # from the operating point before the step on


def recursion(memory, columns):
    """y[n] = memory y[n-1] + x[n], down each column."""
    bands = np.ones((2, len(columns)), columns.dtype)
    bands[1] = -memory
    return scipy.linalg.get_lapack_funcs("tbtrs", (bands,))(bands, columns, uplo="L")[0]


def running_median(values, width):
    padded = np.pad(values, width // 2, mode="edge")
    return np.median(np.lib.stride_tricks.sliding_window_view(padded, width), axis=-1)


class Record:
    """The rows that a fit looks at, and the inputs as changes: of u, of the direction, of "has begun"."""

    def __init__(self, data, rows_max, friction=()):
        n = len(data.time)
        self.dt = float(data.time[-1] / (n - 1))
        self.every = every = int(np.ceil(n / rows_max))
        self.t, self.y = data.time[::every], data.y[::every]
        self.row_dt, self.span, self.n = self.dt * every, float(data.time[-1]), len(self.t)
        change = np.diff(data.u, prepend=0.0)
        change[np.abs(change) <= 1e-9 * np.ptp(np.r_[0.0, data.u])] = 0.0
        at = np.flatnonzero(change)
        inputs = [change]
        if "coulomb" in friction:
            direction = np.zeros(n)
            signs = np.sign(change[at])
            direction[at] = np.diff(signs, prepend=0.0)
            began = np.zeros(n)
            began[at[0]] = 1.0
            inputs += [direction, began]
        if "load" in friction:
            signs = np.sign(change)
            last = signs[np.maximum.accumulate(np.where(signs != 0, np.arange(n), 0))]
            smooth = running_median(data.y, min(n // 50 * 2 + 1, 9))
            inputs.append(np.diff(last * np.abs(smooth - data.y[: max(at[0], 1)].mean()), prepend=0.0))
        self.names = ["u", *(["direction", "began"] if "coulomb" in friction else []), *(["load"] if "load" in friction else [])]
        self._seen = self._blocks = None
        inputs = np.array(inputs).T
        self.dense = len(at) > CHANGES_LOOP or "load" in friction
        self.at = data.time if self.dense else data.time[at]
        self.change = inputs if self.dense else inputs[at]
        self.level = np.vstack([np.zeros(inputs.shape[1]), np.cumsum(self.change, axis=0)])
        self.moment = np.vstack([np.zeros(inputs.shape[1]), np.cumsum(self.change * self.at[:, None], axis=0)])

    def amplitudes(self, poles, seen):
        """Of each mode just after the first `seen` changes, for each input; a row each."""
        k, m = self.change.shape
        if self.dense:
            return self._amplitudes_of_dense(poles, seen)
        out = np.zeros((k + 1, len(poles), m), poles.dtype)
        since = np.maximum(self.at[:, None] - self.at, 0.0)
        out[1:] = np.einsum("jip,im->jpm", np.exp(since[:, :, None] * poles) * np.tri(k)[:, :, None], self.change)
        return out[seen]

    def _amplitudes_of_dense(self, poles, seen):
        """The changes between two rows of the fit are summed up as they have decayed at the second, so that the recursion takes a step a row."""
        every, m, last = self.every, self.change.shape[1], int(seen[-1])
        rows = last // every + 1
        if self._blocks is None or self._blocks[0] != last:
            blocks = np.r_[np.zeros((rows * every - last, m)), self.change[:last]].reshape(rows, every, m)
            self._blocks = last, np.ascontiguousarray(blocks.transpose(0, 2, 1)).reshape(rows * m, every)
        sums = (self._blocks[1] @ np.exp(np.outer(np.arange(every - 1, -1, -1) * self.dt, poles))).reshape(rows, m, len(poles))
        out = np.zeros((rows + 1, len(poles), m), poles.dtype)
        for i, p in enumerate(poles):
            out[1:, i] = recursion(np.exp(p * self.dt * every), sums[:, :, i])
        return out[rows + (seen - last) // every]

    def response(self, poles, tau, integrator):
        """Of the model of unit gain to each input, at the rows."""
        if self._seen is None or self._seen[0] != tau:
            seen = np.searchsorted(self.at, self.t - tau + 1e-6 * self.dt, side="right")
            self._seen = tau, seen, np.clip(np.where(seen > 0, self.t - tau - self.at[np.maximum(seen - 1, 0)], 0.0), 0.0, self.span)[:, None], self.level[seen]
        _, seen, since, level = self._seen
        if not np.any(poles.imag):
            poles = poles.real  # four times faster
        upper = poles[poles.imag >= 0]
        apart = poles[None, :] - poles[:, None]
        np.fill_diagonal(apart, 1.0)
        ratio = poles[None, :] / apart
        np.fill_diagonal(ratio, 1.0)
        weight = -(np.prod(ratio, axis=1) * np.where(poles.imag > 0, 2, 1))[poles.imag >= 0]
        out = np.zeros(level.shape)
        if len(upper):
            if integrator:
                weight = weight / upper
            modes = np.exp(since * upper) * weight
            out = np.einsum("ri,rim->rm", modes, self.amplitudes(upper, seen)).real
        if integrator:
            return (self.t - tau)[:, None] * level - self.moment[seen] - float(np.sum(weight.real)) * level + out
        return level + out


@dataclass(frozen=True)
class Structure:
    order: int  # without the integrator
    pairs: int
    delay: bool
    integrator: bool
    extra: float = 0.0  # a further pole, fixed, in rad/s

    @property
    def size(self):
        return self.order + self.delay

    def __str__(self):
        return f"{self.order}" + ("+integrator" if self.integrator else "") + ("+delay" if self.delay else "")


@dataclass(frozen=True)
class Noise:
    """What is between the model and y: theta of the moving average (1: white), hum in rad/s, rows of outliers, whether y drifts in a line."""

    memory: float = 1.0
    hum: tuple = ()
    outliers: tuple = ()
    trend: bool = False
    drifts: bool = False

    def columns(self, record):
        out = [np.ones(record.n)]
        if self.trend:
            out.append(record.t / record.span)
        for w in self.hum:
            out += [np.sin(w * record.t), np.cos(w * record.t)]
        for i in self.outliers:
            out.append((np.arange(record.n) == i).astype(float))
        return np.array(out).T

    def whitened(self, columns):
        return columns if self.memory >= 1 else recursion(self.memory, np.r_[columns[:1], np.diff(columns, axis=0)])


@dataclass
class Fit:
    structure: Structure
    theta: np.ndarray
    linear: np.ndarray  # gain, the friction columns' and the noise columns' coefficients
    noise: Noise
    residual: np.ndarray  # whitened
    bic: float

    @property
    def poles(self):
        return poles_of(self.structure, self.theta)

    @property
    def tau(self):
        return abs(self.theta[-1]) if self.structure.delay else 0.0


def poles_of(structure, theta):
    out = []
    for i in range(structure.pairs):
        size, damping = np.exp(theta[2 * i]), 1 / (1 + np.exp(-np.clip(theta[2 * i + 1], -LOGIT_MAX, LOGIT_MAX)))
        for j in range(0, len(out), 2):  # a sum of modes needs them apart
            if abs(np.log(abs(out[j]) / size)) < SPACING:
                size = abs(out[j]) * (1 + SPACING)
        out += [size * complex(-damping, np.sqrt(1 - damping**2)), size * complex(-damping, -np.sqrt(1 - damping**2))]
    reals = sorted(-np.exp(theta[2 * structure.pairs : structure.order]))
    for i in range(1, len(reals)):
        if reals[i] - reals[i - 1] < SPACING * abs(reals[i]):
            reals[i] = reals[i - 1] * (1 - SPACING)
    hidden = [complex(-structure.extra)] if structure.extra else []
    return np.array(out + [complex(r) for r in reals] + hidden, complex)


def _matrix(record, structure, theta, noise_columns):
    return np.hstack([_responses(record, structure, theta), noise_columns])


def _responses(record, structure, theta):
    limited = theta.copy()
    limited[: structure.order] = np.clip(limited[: structure.order], -40, 40)
    poles = poles_of(structure, limited)
    tau = min(abs(theta[-1]), record.span) if structure.delay else 0.0
    return record.response(poles, tau, structure.integrator)


def _solve(record, structure, theta, noise, noise_columns, y):
    """The linear parameters, and the whitened residual; y is whitened already."""
    return _least_squares(noise.whitened(_matrix(record, structure, theta, noise_columns)), y)


def _least_squares(matrix, y):
    scale = np.sqrt(np.einsum("ij,ij->j", matrix, matrix))
    scale[scale == 0] = 1.0
    matrix = matrix / scale
    q, r = np.linalg.qr(matrix)
    if np.abs(np.diag(r)).min() > 1e-9:
        solution = np.linalg.solve(r, q.T @ y)
    else:
        solution = np.linalg.lstsq(matrix, y, rcond=1e-9)[0]
    return solution / scale, y - matrix @ solution


def fit(record, structure, noise, starts, thorough=False):
    """The best of the fits from `starts`: of all, or of the two that are nearest to begin with."""
    noise_columns, y = noise.columns(record), noise.whitened(record.y)
    low, high = np.log(0.02 / record.span), np.log(3 * np.pi / record.row_dt)
    best = None
    sizes = np.array([i for i in range(structure.order) if i >= 2 * structure.pairs or i % 2 == 0], int)

    aside = np.linalg.qr(noise.whitened(noise_columns))[0]  # what the noise columns can take is taken once
    y_aside = y - aside @ (aside.T @ y)

    def misfit(theta):
        columns = noise.whitened(_responses(record, structure, theta))
        residual = _least_squares(columns - aside @ (aside.T @ columns), y_aside)[1]
        # Beyond what the record can show the response no longer changes: a gentle slope back keeps the fit from running away.
        beyond = np.maximum(theta[sizes] - high, 0) + np.maximum(low - theta[sizes], 0)
        logits = theta[1 : 2 * structure.pairs : 2]
        return np.r_[residual, 0.1 * scale * beyond, 0.1 * scale * np.maximum(np.abs(logits) - LOGIT_MAX + 1, 0)]

    scale = max(float(np.std(y)), 1e-300)
    if structure.size and not thorough and len(starts) > 2:
        with np.errstate(all="ignore"):
            starts = sorted(starts, key=lambda start: np.nan_to_num(float(np.sum(misfit(start) ** 2)), nan=np.inf))[:2]
    size = np.r_[np.full(structure.order, 0.5), np.full(int(structure.delay), max(record.row_dt, 1e-3 * record.span))]
    for start in starts:
        if structure.size == 0:
            theta = np.zeros(0)
        else:
            try:
                # MINPACK's own differences: those of least_squares take a fifth of the time.
                theta, *_, stopped = scipy.optimize.leastsq(misfit, start, full_output=True, diag=1 / size, maxfev=(30 if thorough else 12) * (structure.size + 2) * (structure.size + 1),
                                                            **(FINE if thorough else COARSE))
                if stopped not in range(1, 9):
                    continue
            except (ValueError, np.linalg.LinAlgError):
                continue
        try:
            linear, residual = _solve(record, structure, theta, noise, noise_columns, y)
        except (ValueError, np.linalg.LinAlgError):
            continue
        cost = float(residual @ residual)
        if np.isfinite(cost) and (best is None or cost < best[0]):
            best = (cost, theta, linear, residual)
    if best is None:
        return None
    cost, theta, linear, residual = best
    parameters = structure.size + len(linear) + len(noise.hum) + noise.drifts
    bic = record.n * np.log(max(cost / record.n, 1e-300)) + parameters * np.log(record.n)
    return Fit(structure, theta, linear, noise, residual, float(bic))


def _starts(record, structure, known):
    """Several: from the record's own time to settle, spread in different ways, and from the next smaller structure's answer."""
    moved = np.abs(record.y - record.y[-1]) > 0.37 * max(np.ptp(record.y), 1e-300)
    begin = float(record.at[0]) if not record.dense else 0.0
    first_next = float(record.at[1]) if not record.dense and len(record.at) > 1 else record.span
    inside = (record.t >= begin) & (record.t < first_next)
    y = record.y[inside]
    if len(y) > 5:
        level = np.median(y[-max(len(y) // 10, 1) :])
        moved = np.abs(y - level) > 0.37 * max(np.abs(y[0] - level), 1e-300)
        guess = float(record.t[inside][moved][-1] - begin) if np.any(moved) else record.span / 10
    else:
        guess = float(record.t[moved][-1]) if np.any(moved) else record.span / 10
    guess = max(guess, record.row_dt)
    reals = structure.order - 2 * structure.pairs
    out = []
    delays = [0.3 * guess, 2 * record.row_dt] if structure.delay else [None]
    for spread, logit in ((1.5, 0.0), (6.0, -1.5)):
        sizes = np.log(structure.order / guess) + np.log(spread) * np.linspace(-0.3, 1, max(structure.order, 1)) * (structure.order > 1) if structure.order else np.zeros(0)
        theta = []
        for i in range(structure.pairs):
            theta += [sizes[min(2 * i + 1, structure.order - 1)], logit]
        theta += list(sizes[structure.order - reals :]) if reals else []
        for delay in delays:
            out.append(np.array(theta + ([delay] if delay is not None else [])))
    for smaller in known:
        s = smaller.structure
        if s.integrator != structure.integrator:
            continue
        if s.order == structure.order - 1 and s.pairs == structure.pairs and s.delay == structure.delay:
            fast = np.log(3 * max(np.abs(smaller.poles), default=1 / guess))
            tail = smaller.theta[s.order :]
            out.append(np.r_[smaller.theta[: s.order], fast, tail])
        if s.order == structure.order and s.pairs == structure.pairs and structure.delay and not s.delay:
            out.append(np.r_[smaller.theta, record.row_dt])
    return out


def _pair_starts(record, structure, known):
    """Where u moves all the time no step shows how long y takes, and a valley is no wider than its resonance: one pair over a grid of sizes, beside the
    next smaller structure's answer, or beside real poles on either side of it."""
    if not record.dense or "load" in record.names or not structure.pairs:
        return []
    rest, tail = structure.order - 2, [2 * record.row_dt] if structure.delay else []
    smaller = [f.theta for f in known if f.structure == replace(structure, order=rest, pairs=structure.pairs - 1)]
    reals = np.arange(rest)
    out = []
    for size in np.linspace(np.log(6 / record.span), np.log(0.7 * np.pi / record.row_dt), GRID):
        for logit in GRID_LOGITS:
            out += [np.r_[size, logit, theta] for theta in smaller]
            if structure.pairs == 1:
                out += [np.r_[size, logit, size + way * (1 + 0.5 * reals), tail] for way in ((1, -1) if rest else (1,))]
    return out


def search(record, order, noise, keep=4):
    """The best structures by BIC, with their fits on few rows."""
    found, least = [], np.inf
    for integrator in (False, True):
        if integrator and found and not order:
            best = min(found, key=lambda f: f.bic)
            if best.structure.order and np.min(np.abs(best.poles)) * record.span > SETTLED:
                break  # y comes to rest: nothing integrates
        for delay in (False, True):
            best_of_order = []
            for n in ([order - integrator] if order else range(0 if integrator else 1, ORDER_MAX + 1)):
                if integrator and best_of_order and n > 1 and best_of_order[-1] > least + HOPELESS:
                    break
                here = []
                for pairs in range(n // 2 + 1 if n <= 4 else 2):
                    structure = Structure(n, pairs, delay, integrator)
                    progress.at(f"fits models of order {structure} to {record.n} rows")
                    one = fit(record, structure, noise, _starts(record, structure, found) + _pair_starts(record, structure, found))
                    if one is not None:
                        here.append(one)
                        found.append(one)
                if here:
                    best_of_order.append(min(f.bic for f in here))
                    least = min(least, best_of_order[-1])
                if len(best_of_order) >= 3 and best_of_order[-1] > best_of_order[-2] and best_of_order[-1] > min(best_of_order) + BIC_CLOSE:
                    break
    found.sort(key=lambda f: f.bic)
    return found[:keep], found


# Noise.

def find_noise(record, best):
    """The noise that the best fit so far leaves: outliers, hum, a walk."""
    noise = best.noise
    plain = replace(noise, memory=1.0)
    residual = _solve(record, best.structure, best.theta, plain, plain.columns(record), record.y)[1]
    if np.std(residual) < NOTHING * np.ptp(record.y):
        return noise
    # A walk and a model's misfit move the residual slowly: an outlier stands out of its neighbours, and of the whole residual.
    neighbours = np.stack([np.roll(residual, k) for k in (-3, -2, -1, 1, 2, 3)])
    rest = residual - np.median(neighbours, axis=0)
    spread = [1.4826 * float(np.median(np.abs(x - np.median(x)))) for x in (rest, residual)]
    out = set(noise.outliers) | set(np.flatnonzero(np.abs(rest) > 7 * max(spread[0], 0.5 * spread[1], 1e-300)).tolist())
    if len(out) > max(0.03 * record.n, 3):
        out = set(noise.outliers)  # so many are no outliers
    noise = replace(noise, outliers=tuple(sorted(out)))
    hum = list(noise.hum)
    for _ in range(3):
        trial = replace(noise, hum=tuple(hum), memory=1.0)
        residual = _solve(record, best.structure, best.theta, trial, trial.columns(record), record.y)[1]
        w = _strongest_sine(record, residual)
        if w is None or any(abs(w - x) < 2 * 2 * np.pi / record.span for x in hum):
            break
        hum.append(w)
    noise = replace(noise, hum=tuple(hum))
    memory, drifts = _memory(record, best, noise)
    if drifts:
        straight = replace(noise, trend=True)
        noise = min((noise, straight), key=lambda n: float(walks(record, best, n).costs.min()) + n.trend * np.log(record.n))
        memory, drifts = _memory(record, best, noise)
    return replace(noise, memory=memory, drifts=drifts or noise.trend)


def _strongest_sine(record, residual):
    """Its frequency, when Fisher's test takes it for no noise and it has ten periods or more."""
    n = len(residual)
    window = np.diff(residual)  # a walk is white then
    power = np.abs(np.fft.rfft(window * np.hanning(len(window)))) ** 2
    w = 2 * np.pi * np.arange(len(power)) / (len(window) * record.row_dt)
    inside = (w > 2 * np.pi * 10 / record.span) & (w < 0.95 * np.pi / record.row_dt)
    if np.count_nonzero(inside) < 10:
        return None
    shaped = np.where(inside, power, 0.0) / np.maximum(2 - 2 * np.cos(w * record.row_dt), 1e-9) ** 0.5  # between a walk and white
    local = running_median(shaped, 31) / np.log(2)
    ratio = np.where(inside, shaped / np.maximum(local, 1e-300), 0)
    i = int(np.argmax(ratio))
    if ratio[i] < 2.5 * np.log(np.count_nonzero(inside) / 1e-4):
        return None

    def left(x):
        matrix = np.array([np.sin(x * record.t), np.cos(x * record.t), np.ones(n)]).T
        return float(np.sum((residual - matrix @ np.linalg.lstsq(matrix, residual, rcond=None)[0]) ** 2))

    step = 2 * np.pi / record.span
    found = float(scipy.optimize.minimize_scalar(left, bounds=(w[i] - step, w[i] + step), method="bounded", options={"xatol": 1e-6 * step}).x)
    waves = []  # hum is there all the time, with one amplitude and phase: what follows u's steps is not
    for part in np.array_split(np.arange(n), 5):
        matrix = np.array([np.sin(found * record.t[part]), np.cos(found * record.t[part]), np.ones(len(part)), record.t[part]]).T
        a, b, *_ = np.linalg.lstsq(matrix, residual[part], rcond=None)[0]
        waves.append(complex(a, b))
    return found if max(abs(w - np.mean(waves)) for w in waves) < 0.6 * abs(np.mean(waves)) else None


LAG_EVIDENCE = 12.0  # of -2 log likelihood
HIDDEN, HIDDEN_EVIDENCE = (4.0, 8.0, 16.0), 2.0  # a pole so many times faster than the fastest, as long as -2 log likelihood grows by no more
WALKS = (0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 18.0, 27.0, 40.0, 60.0, 90.0, 135.0, 200.0, 300.0, 450.0, 675.0, 1000.0, 1500.0, 2200.0, 3300.0, 5000.0)  # rows x (1 - memory)


def _jacobian(record, best, noise):
    """Of the rows by the nonlinear and then the linear parameters, unwhitened."""
    columns = noise.columns(record)
    sides = []
    for i in range(best.structure.size):
        step = 1e-4 * (1.0 if i < best.structure.order else max(record.row_dt, abs(best.theta[i])))
        for sign in (1, -1):
            theta = best.theta.copy()
            theta[i] += sign * step
            sides.append(_matrix(record, best.structure, theta, columns)[:, : len(record.names)] @ best.linear[: len(record.names)] / (2 * sign * step))
    nonlinear = [sides[2 * i] + sides[2 * i + 1] for i in range(best.structure.size)]
    return np.c_[np.array(nonlinear).reshape(-1, record.n).T, _matrix(record, best.structure, best.theta, columns)]


@dataclass(frozen=True)
class Walks:
    """Of random walks from none to nothing else, a row each."""

    memories: np.ndarray
    costs: np.ndarray  # -2 log likelihood of the best fit with it
    restricted: np.ndarray  # the same of the residual's distribution alone
    moves: np.ndarray  # from the fit's parameters, without those of the noise
    covariances: np.ndarray

    @property
    def weights(self):
        """The probability of each, all sizes being as probable beforehand."""
        size = 1 - self.memories
        edges = np.r_[0.0, (size[1:] + size[:-1]) / 2, size[-1]]
        weights = np.exp(-0.5 * (self.restricted - self.restricted.min())) * np.diff(edges)
        return weights / weights.sum()


def walks(record, best, noise):
    """Linear about the fit. Gain and poles take a part of a walk with them, so that the likelihood of the best fit sees too small a walk or none; the
    restricted one does not."""
    jacobian = _jacobian(record, best, noise)
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0] = 1.0
    used = len(record.names) + best.structure.size
    names = np.r_[best.linear[: len(record.names)], np.zeros(jacobian.shape[1] - used)]
    residual = record.y - jacobian[:, best.structure.size :] @ names  # without the noise columns, which are fitted again
    n, p = jacobian.shape
    memories = [1 - w / n for w in WALKS if w < n] + [0.0]
    costs, restricted, moves, covariances = [], [], [], []
    for memory in memories:
        trial = replace(noise, memory=memory)
        both = trial.whitened(np.c_[jacobian / scale, residual])
        u, s, v = np.linalg.svd(both[:, :-1], full_matrices=False)
        s = np.maximum(s, 1e-10 * s[0])
        along = u.T @ both[:, -1]
        rest = max(float(both[:, -1] @ both[:, -1] - along @ along), 1e-300)
        costs.append(n * np.log(rest))
        restricted.append(max(n - p, 1) * np.log(rest) + 2 * float(np.sum(np.log(s))))
        inverse = v.T[:used] / s
        moves.append(inverse @ along / scale[:used])
        covariances.append(inverse @ inverse.T * rest / max(n - p, 1) / np.outer(scale, scale)[:used, :used])
    return Walks(np.array(memories), np.array(costs), np.array(restricted), np.array(moves), np.array(covariances))


def _memory(record, best, noise):
    """(memory, whether y drifts)."""
    seen = walks(record, best, noise)
    return float(seen.weights @ seen.memories), bool(seen.restricted[0] - seen.restricted.min() > 6)


def whiteness(residual, parameters):
    """The least of Ljung and Box's probabilities over short and long spans of lags."""
    n = len(residual)
    r = residual - residual.mean()
    power = float(r @ r)
    if power <= 0:
        return 1.0
    spectrum = np.abs(np.fft.rfft(r, 2 * n)) ** 2
    rho = np.fft.irfft(spectrum)[: n // 2] / power
    least = 1.0
    for lags in (5, 20, max(n // 5, 25)):
        lags = min(lags, n // 2 - 1)
        q = n * (n + 2) * float(np.sum(rho[1 : lags + 1] ** 2 / (n - np.arange(1, lags + 1))))
        least = min(least, 3 * float(scipy.special.chdtrc(lags, q)))
    return least


# What the record can tell.

def steps_of(data):
    """(times, sizes) of u's steps of some size; None when u moves all the time."""
    change = np.diff(data.u, prepend=0.0)
    at = np.flatnonzero(np.abs(change) > 0.02 * np.max(np.abs(change)))
    return (data.time[at], change[at]) if len(at) <= CHANGES_LOOP else (None, None)


def levels(data):
    """A row a plateau: u, direction, has begun, 1, and of y's last quarter the mean and the scatter; the means of the two quarters before."""
    at, sizes = steps_of(data)
    if at is None:
        return np.zeros((0, 8))
    rows = []
    edges = np.r_[data.time[0] - 1 if at[0] > data.time[0] else at[0], at, data.time[-1] + 1e-9]
    edges = np.unique(edges)
    for a, b in zip(edges[:-1], edges[1:]):
        inside = (data.time >= a) & (data.time < b)
        if np.count_nonzero(inside) < 8:
            continue
        inside = np.flatnonzero(inside)
        n = max(len(inside) // 4, 4)
        tail, third, second = inside[-n:], inside[-2 * n : -n], inside[-3 * n : -2 * n] if len(inside) >= 3 * n else inside[-2 * n : -n]
        k = int(np.searchsorted(at, data.time[tail[0]], side="right"))
        rows.append([data.u[tail[0]], np.sign(sizes[k - 1]) if k else 0.0, float(k > 0), 1.0, float(np.mean(data.y[tail])), float(np.ptp(data.y[tail])), float(np.mean(data.y[third])), float(np.mean(data.y[second]))])
    return np.array(rows) if rows else np.zeros((0, 8))


def friction_of(data):
    """What of friction the record's levels can tell: (), coulomb, or coulomb and load."""
    at, sizes = steps_of(data)
    if at is None:
        return ("coulomb",)
    table = levels(data)
    if len(table) < 3 or len(set(np.sign(sizes))) < 2:
        return ()
    matrix = table[:, :4] / np.maximum(np.abs(table[:, :4]).max(axis=0), 1e-300)
    matrix = matrix[:, np.any(matrix != 0, axis=0)]
    if not np.any(table[:, 2] == 0):
        matrix = matrix[:, [0, 1, -1]]
    if np.linalg.svd(matrix, compute_uv=False)[-1] < 0.1 or len(table) < matrix.shape[1]:
        return ()
    load = table[:, 1] * np.abs(table[:, 4] - table[0, 4])
    if np.ptp(load) == 0:
        return ("coulomb",)
    more = np.c_[matrix, load / np.abs(load).max()]
    enough = len(table) >= more.shape[1] and np.linalg.svd(more, compute_uv=False)[-1] > 0.15
    return ("coulomb", "load") if enough else ("coulomb",)


NOT_SEPARABLE = ("gain and friction are not separable in this record: a step of one height or in one direction looks the same with less gain as with more friction. Record two "
                 "heights in both directions, e.g. u = 0, h, 2h, h, 0, each held until y rests; or give --no-friction if friction is known to be negligible")


def identify(data, order=None, no_friction=False):
    """Figures as a dict; `separable` and `trusted` say what of them holds."""
    friction = () if no_friction else friction_of(data)
    separable = no_friction or bool(friction)
    # Friction, then noise, then the structure again with both, as each hides the others.
    base = ("coulomb",) if "coulomb" in friction else ()
    record = Record(data, SEARCH_ROWS, base)
    pool, everything = search(record, order, Noise(), keep=6)
    if not pool:
        raise DesignError("no model fits this response")
    answers = [(base, record, *_with_noise(record, pool, order))]
    for way in [w for w in ((), ("coulomb", "load")) if w != base and set(w) <= set(friction)]:
        record = Record(data, SEARCH_ROWS, way)
        again = [fit(record, f.structure, f.noise, [f.theta], thorough=True) for f in _distinct(answers[0][2])[:4]]
        again = sorted((f for f in again if f is not None), key=lambda f: f.bic)
        if again:
            answers.append((way, record, *_with_noise(record, again, order)))
    way, record, candidates, _ = min(answers, key=lambda a: a[2][0].bic)
    full = Record(data, FIT_ROWS, way)
    if full.n != record.n:
        noise = candidates[0].noise
        candidates = [fit(full, c.structure, replace(noise, outliers=()), [c.theta], thorough=True) for c in candidates]
        candidates = sorted((f for f in candidates if f is not None), key=lambda f: f.bic)
        noise = find_noise(full, candidates[0])
        candidates = sorted((f for f in (fit(full, c.structure, noise, [c.theta], thorough=True) for c in candidates) if f is not None), key=lambda f: f.bic)
    best = candidates[0]
    found = figures(full, best, candidates, data, way)
    found.update(separable=bool(separable), friction_assumed_none=bool(no_friction), bic={str(f.structure): f.bic for f in sorted(_per_label(everything), key=lambda f: str(f.structure))})
    _judge(found, data, friction, way, full, best, candidates)
    return found, full, best


def _with_noise(record, candidates, order):
    """The candidates with the noise that they leave, best first, twice; all structures again where the noise is a walk."""
    searched = False
    for _ in range(3):
        noise = find_noise(record, candidates[0])
        if noise == candidates[0].noise:
            break
        if noise.drifts and not searched:
            searched = True
            candidates = search(record, order, noise, keep=6)[0]
            continue
        again = [fit(record, c.structure, noise, [c.theta], thorough=True) for c in _distinct(candidates)[:6]]
        candidates = sorted((f for f in again if f is not None), key=lambda f: f.bic)
    return candidates, searched


def _distinct(fits):
    seen, out = set(), []
    for f in fits:
        if f.structure not in seen:
            seen.add(f.structure)
            out.append(f)
    return out


def _per_label(fits):
    best = {}
    for f in fits:
        label = str(f.structure)
        if label not in best or f.bic < best[label].bic:
            best[label] = f
    return best.values()


def figures(record, best, candidates, data, way):
    """The numbers of one fit with their intervals."""
    structure, noise = best.structure, best.noise
    nonlinear, parameters = structure.size, structure.size + len(best.linear) + len(noise.hum)
    seen = walks(record, best, noise)
    weights = seen.weights

    def half_width(gradient):
        """95 % of what all walks together leave of this combination of parameters."""
        off = seen.moves @ gradient
        size = np.sqrt(np.maximum(np.einsum("i,kij,j->k", gradient, seen.covariances, gradient), 1e-300))
        low, high = 0.0, float(np.max(np.abs(off) + 1e3 * size))
        free = max(record.n - parameters, 1)
        for _ in range(60):
            middle = (low + high) / 2
            inside = weights @ (scipy.special.stdtr(free, (middle - off) / size) - scipy.special.stdtr(free, (-middle - off) / size))
            low, high = (middle, high) if inside < 0.95 else (low, middle)
        return high

    half = np.array([half_width(row) for row in np.eye(nonlinear + 1, nonlinear + len(record.names))])
    poles = []

    def entry(pole, size_half, part_half):
        visible = size_half < 0.7 and abs(pole) < 0.7 * np.pi / record.row_dt and abs(pole) > 0.3 / record.span
        return {"pole": format_root(pole), "re": pole.real, "im": pole.imag, "size_low": abs(pole) * np.exp(-min(size_half, 600)), "size_high": abs(pole) * np.exp(min(size_half, 600)),
                "part_half_width": part_half, "identifiable": bool(visible)}

    for i in range(structure.pairs):
        size, damping = np.exp(best.theta[2 * i]), 1 / (1 + np.exp(-best.theta[2 * i + 1]))
        gradient = np.zeros(nonlinear + len(record.names))
        gradient[2 * i : 2 * i + 2] = -size * damping, -size * damping * (1 - damping)
        part = half_width(gradient)
        pole = size * complex(-damping, np.sqrt(1 - damping**2))
        poles += [entry(pole, half[2 * i], part), entry(np.conj(pole), half[2 * i], part)]
    for i in range(2 * structure.pairs, structure.order):
        size = float(np.exp(best.theta[i]))
        poles.append(entry(complex(-size), half[i], half[i] * size))
    gain, coulomb, load = float(best.linear[0]), None, None
    if "coulomb" in way:
        coulomb = -float(best.linear[1]) / gain if gain else np.nan
        load = -float(best.linear[3]) / gain if "load" in way and gain else None
    plain = replace(noise, memory=1.0)
    response = _matrix(record, structure, best.theta, plain.columns(record)) @ best.linear
    moves = _matrix(record, structure, best.theta, plain.columns(record))[:, : len(record.names)] @ best.linear[: len(record.names)]
    settled = np.abs(moves - moves[-1]) > 0.02 * np.ptp(moves) if np.ptp(moves) > 0 else np.ones(record.n, bool)
    last = int(np.flatnonzero(settled)[-1]) + 1 if np.any(settled) else record.n
    window = slice(0, max(min(last, record.n), parameters + 2))
    error = record.y - response
    y = record.y[window]
    return {"order": structure.order + structure.integrator, "integrator": structure.integrator, "gain": gain, "gain_half_width": float(half[nonlinear]), "offset": float(best.linear[len(record.names)]),
            "delay_s": best.tau, "delay_half_width_s": float(half[structure.order]) if structure.delay else 0.0, "poles": poles,
            "friction_n": coulomb, "friction_per_force": load,
            "fit_percent_where_it_moves": float(100 * (1 - np.linalg.norm(error[window]) / max(np.linalg.norm(y - y.mean()), 1e-300))),
            "fit_percent_all": float(100 * (1 - np.linalg.norm(error) / max(np.linalg.norm(record.y - record.y.mean()), 1e-300))),
            "residual_rms": float(np.sqrt(np.mean(best.residual**2))), "whiteness": whiteness(best.residual, parameters), "samples": record.n,
            "drift": noise.drifts, "hum_rad_s": list(noise.hum), "outliers": len(noise.outliers), "gain_from": "the whole record"}


def _judge(found, data, friction, way, record, best, candidates):
    """What holds of it: `trusted` for the intervals of gain, dead time and poles; remarks in words."""
    remarks = []
    found["trusted"] = True
    for rival in candidates[1:]:  # structures that the record cannot tell apart: both intervals in one
        if rival.bic - best.bic > np.log(record.n) + RIVAL or rival.structure.integrator != best.structure.integrator:
            continue
        if np.max(np.abs(rival.poles), initial=0) > 0.7 * np.pi / record.row_dt or (rival.structure.delay and rival.tau < 0.3 * record.row_dt):
            continue  # one more parameter that does nothing
        other = figures(record, rival, candidates, data, way)
        found["gain_half_width"] = max(found["gain_half_width"], abs(other["gain"] - found["gain"]) + other["gain_half_width"])
        if found["delay_s"]:
            found["delay_half_width_s"] = max(found["delay_half_width_s"], abs(other["delay_s"] - found["delay_s"]) + other["delay_half_width_s"])
        for p in found["poles"]:
            size = np.hypot(p["re"], p["im"])
            nearest = min(other["poles"], key=lambda q, size=size: abs(np.log(np.hypot(q["re"], q["im"]) / size)), default=p)
            p["size_low"], p["size_high"] = min(p["size_low"], nearest["size_low"]), max(p["size_high"], nearest["size_high"])
            p["identifiable"] = p["identifiable"] and p["size_high"] < 2 * size and p["size_low"] > size / 2
    _allow_for_a_hidden_pole(found, record, best)
    _allow_for_lag_and_dead_time(found, record, best, remarks)
    near = [f for f in candidates if f.structure.integrator != best.structure.integrator and f.bic - best.bic < BIC_CLOSE]
    slow = [p for p in found["poles"] if np.hypot(p["re"], p["im"]) * record.span < 1.0]
    if near or slow:
        found["trusted"] = False
        remarks.append("an integrator and a slow pole are not separable in this record: it is too short for its slowest mode")
    if found["whiteness"] < WHITE and found["residual_rms"] > NOTHING * np.ptp(record.y):
        found["trusted"] = False
        if not _from_levels(found, data, friction, remarks):
            remarks.append("the residual is not noise: the model misses something (friction that changes with speed, a zero, another input), so no interval would hold; tools/tribo-rig finds lags beside friction")
    _allow_for_overshoot(found, data, best, way, remarks)
    if not found["gain_half_width"] < abs(found["gain"]):
        found["trusted"] = False
        remarks.append("the interval of the gain holds 0: as far as this record tells y does not answer to u")
    if found["integrator"]:
        remarks.append("an integrator: the gain is that of 1/s, in y per u and second")
    if "coulomb" in way and "load" not in way:
        remarks.append("friction is the same at every force, as far as this record tells" if "load" in friction else
                       "friction is taken as the same at every force; u = 0, h, 2h, h, 0 would tell")
    if found["drift"]:
        remarks.append("y drifts like a random walk; the intervals allow for it")
    if found["hum_rad_s"]:
        remarks.append("hum at " + ", ".join(f"{w / 2 / np.pi:.4g} Hz" for w in found["hum_rad_s"]) + " is taken out")
    if found["outliers"]:
        remarks.append(f"{found['outliers']} outliers are left out")
    if found["fit_percent_where_it_moves"] < 80:
        remarks.append("a poor fit: do not design on this model")
    found["remarks"] = remarks


def _allow_for_a_hidden_pole(found, record, best):
    """The record may hold one more fast pole, too small to be found, that moves all others: what it would move within the noise is in the intervals."""
    if best.structure.order == 0:
        return
    n, least = record.n, float(best.residual @ best.residual)
    for times in HIDDEN:
        extra = times * float(np.max(np.abs(best.poles)))
        if extra > np.pi / record.row_dt:
            break
        other = fit(record, replace(best.structure, extra=extra), best.noise, [best.theta], thorough=True)
        if other is None or n * np.log(float(other.residual @ other.residual) / least) > HIDDEN_EVIDENCE:
            continue
        found["gain_half_width"] = max(found["gain_half_width"], abs(float(other.linear[0]) - found["gain"]) + 0.5 * found["gain_half_width"])
        if found["delay_s"]:
            found["delay_half_width_s"] = max(found["delay_half_width_s"], abs(other.tau - found["delay_s"]) + 0.5 * found["delay_half_width_s"])
        for p in found["poles"]:
            size = np.hypot(p["re"], p["im"])
            moved = min(np.abs(other.poles[:-1]), key=lambda q, size=size: abs(np.log(q / size)), default=size) / size
            p["size_high"] = max(p["size_high"], size * moved * np.sqrt(p["size_high"] / size)) if moved > 1 else p["size_high"]
            p["size_low"] = min(p["size_low"], size * moved * np.sqrt(p["size_low"] / size)) if moved < 1 else p["size_low"]
            p["identifiable"] = p["identifiable"] and p["size_high"] < 2 * size and p["size_low"] > size / 2


def _allow_for_lag_and_dead_time(found, record, best, remarks):
    """A dead time and fast poles look alike when there is noise. A wrong structure beats the true one by LAG_EVIDENCE once in some 400 records:
    up to there both count, however many parameters they have."""
    s, noise = best.structure, best.noise
    others = []
    if s.delay:
        tau = max(best.tau, 0.1 * record.row_dt)
        for more in (1, 2):
            others.append((Structure(s.order + more, s.pairs, False, s.integrator), np.r_[best.theta[: s.order], np.log(more / tau) + 0.3 * np.arange(more)]))
        others.append((Structure(s.order + 2, s.pairs + 1, False, s.integrator), np.r_[np.log(1.4 / tau), 1.0, best.theta[: s.order]]))
    elif s.order > 2 * s.pairs:
        reals = np.sort(best.theta[2 * s.pairs :])
        others += [(Structure(s.order - 1, s.pairs, True, s.integrator), np.r_[best.theta[: 2 * s.pairs], reals[:-1], np.exp(-reals[-1])])]
    elif s.pairs:
        others += [(Structure(s.order - 2, s.pairs - 1, True, s.integrator), np.r_[best.theta[2 : s.order], 1.4 * np.exp(-best.theta[0])])]
    least, ambiguous = float(best.residual @ best.residual), False
    for structure, start in others:
        other = fit(record, structure, noise, [start], thorough=True)
        if other is None or record.n * np.log(float(other.residual @ other.residual) / max(least, 1e-300)) > LAG_EVIDENCE:
            continue
        if s.delay and len(other.poles) and np.max(np.abs(other.poles)) > 10 / max(best.tau, 0.1 * record.row_dt):
            continue  # a pole too fast to stand for the dead time
        ambiguous = True
        found["gain_half_width"] = max(found["gain_half_width"], abs(float(other.linear[0]) - found["gain"]) + found["gain_half_width"])
        found["delay_half_width_s"] = max(found["delay_half_width_s"], abs(other.tau - found["delay_s"]) + found["delay_half_width_s"])
        for p in found["poles"]:
            size = np.hypot(p["re"], p["im"])
            moved = min(np.abs(other.poles), key=lambda q, size=size: abs(np.log(q / size)), default=np.inf) / size
            p["size_low"], p["size_high"] = p["size_low"] * min(moved, 1), p["size_high"] * max(moved, 1)
            p["identifiable"] = bool(p["identifiable"] and p["size_high"] < 2 * size and p["size_low"] > size / 2)
    if ambiguous:
        remarks.append("dead time and fast poles are not separable in this record: " + ("there may be a lag instead of the dead time" if s.delay else "there may be a dead time instead of the fastest poles"))


def _allow_for_overshoot(found, data, best, way, remarks):
    """An arm that overshoots turns within a plateau and sticks off the friction of its last step: by its overshoot, at most by twice the friction."""
    if "coulomb" not in way or not best.structure.pairs:
        return
    pairs = best.poles[best.poles.imag > 0]
    overshoot = float(np.max(np.exp(np.pi * pairs.real / pairs.imag)))
    friction = abs(found["friction_n"] or 0.0) + abs(found["friction_per_force"] or 0.0) * np.ptp(data.y) / max(abs(found["gain"]), 1e-300)
    step = float(np.max(np.abs(np.diff(data.u, prepend=0.0))))
    # Friction damps: the plant's own overshoot is larger than that of the fit.
    found["gain_half_width"] += abs(found["gain"]) * min(2 * overshoot * step, 2 * friction) / np.ptp(np.r_[0.0, data.u])
    for p in found["poles"]:
        p["identifiable"] = False
    remarks.append("friction and overshoot: where the arm comes to rest depends on both; the gain's interval allows for it, complex poles and those beside them are a description without intervals")


def _from_levels(found, data, friction, remarks):
    """Gain and friction from the plateaus alone, whatever happens between them; False where there are too few."""
    table = levels(data)
    if found["integrator"] or not found.get("separable", bool(friction)) or len(table) < 2:
        return False
    moving = table[:, 5] > 0.1 * np.ptp(table[:, 4])
    if np.any(moving):
        return False
    columns = [0, 1, 2, 3] if friction else [0, 3]
    matrix = table[:, columns]
    if friction and not np.any(table[:, 2] == 0):
        matrix = table[:, [0, 1, 3]]
    if "load" in friction:
        matrix = np.c_[matrix, table[:, 1] * np.abs(table[:, 4] - table[0, 4])]
    free = len(table) - matrix.shape[1]
    if free < 2 or np.linalg.matrix_rank(matrix) < matrix.shape[1]:
        return False
    inverse = np.linalg.pinv(matrix)
    solution = inverse @ table[:, 4]
    residual = table[:, 4] - matrix @ solution
    half = scipy.special.stdtrit(free, 0.975) * np.sqrt(np.diag(inverse @ inverse.T) * float(residual @ residual) / free)
    # The plateaus are not quite at rest: what they still have to go, if they go on as they did, moves the gain with them.
    last, before = table[:, 4] - table[:, 6], table[:, 6] - table[:, 7]
    ratio = np.clip(float(last @ before) / max(float(before @ before), 1e-300), 0.0, 0.9)
    half += np.abs(inverse @ last) * ratio / (1 - ratio)
    if not half[0] < 0.25 * abs(solution[0]):
        return False
    found.update(gain=float(solution[0]), gain_half_width=float(half[0]), gain_from="the plateaus", friction_n=-float(solution[1]) / float(solution[0]) if friction else None)
    found["trusted"] = True
    for p in found["poles"]:
        p["identifiable"] = False
    found["delay_half_width_s"] = None
    remarks.append("the residual is not noise between the plateaus (friction that changes with speed, sticking): gain and friction are those of the plateaus, the poles are a description without intervals")
    return True


def command(options):
    if options.order is not None and not 1 <= options.order <= ORDER_MAX:
        raise InputError(f"--order: value {options.order}: must be at least 1 and at most {ORDER_MAX}")
    if options.out:
        from .output import check_replaceable

        check_replaceable(options.out, NAMES)
    log = read_step(options)
    data = data_of(log, options.step_size)
    found, record, best = identify(data, options.order, options.no_friction)
    text = "\n".join([describe(found), *(f"note  {remark}" for remark in log.remarks)])
    print(text)
    if not found["separable"]:
        raise DesignError(f"not answered: {NOT_SEPARABLE}")
    if not found["trusted"]:
        raise DesignError("not answered: " + "; ".join(found["remarks"]))
    if options.out:
        from .output import write_directory

        files = {"plant.yaml": plant_yaml(found, printable(Path(options.step).name)).encode(), "identification.json": (json.dumps(found, indent=1, default=lambda number: number.item()) + "\n").encode(),
                 "report.md": ("# Plant from a step response\n\n```\n" + text + "\n```\n\n![Fit](fit.png)\n").encode(), "fit.png": _plot(record, best)}
        write_directory(options.out, files, NAMES)
        print(f"wrote {options.out}: {', '.join(sorted(files))}")
    return 0


NAMES = ("plant.yaml", "identification.json", "report.md", "fit.png")


def describe(found):
    lines = [f"order {found['order']}{', one of it an integrator' if found['integrator'] else ''} (BIC: " + ", ".join(f"{k}: {v:.6g}" for k, v in found["bic"].items()) + ")"]
    if not found["separable"]:
        lines.append(f"gain  not separable from friction: {found['gain']:.6g} if there is none")
    elif not found["trusted"]:
        lines.append(f"gain  {found['gain']:.6g}, without an interval")
    else:
        lines.append(f"gain  {found['gain']:.6g} +- {found['gain_half_width']:.2g} (95 %)" + (f", from {found['gain_from']}" if found["gain_from"] != "the whole record" else ""))
    if found["friction_n"] is not None:
        lines.append(f"friction {found['friction_n']:.4g} N" + (f" + {found['friction_per_force']:.3g} |F|" if found["friction_per_force"] is not None else ""))
    if found["delay_s"]:
        lines.append(f"delay {found['delay_s']:.6g} s" + (f" +- {found['delay_half_width_s']:.2g} (95 %)" if found["trusted"] and found["delay_half_width_s"] is not None else ""))
    elif found["delay_half_width_s"]:
        lines.append(f"delay none found, up to {found['delay_half_width_s']:.2g} s possible")
    for p in found["poles"]:
        if not p["identifiable"]:
            lines.append(f"pole  {p['pole']} rad/s: NOT identifiable from this record")
        elif not found["trusted"]:
            lines.append(f"pole  {p['pole']} rad/s, without an interval")
        elif p["im"]:
            lines.append(f"pole  {p['re']:.5g}{p['im']:+.5g}j rad/s, size {p['size_low']:.5g} to {p['size_high']:.5g}, real part +- {p['part_half_width']:.2g} (95 %)")
        else:
            lines.append(f"pole  {p['re']:.5g} rad/s, {-p['size_high']:.5g} to {-p['size_low']:.5g} (95 %)")
    lines.append(f"fit   {found['fit_percent_where_it_moves']:.2f} % where the response moves ({found['fit_percent_all']:.2f} % of the whole record); residual {found['residual_rms']:.3g} rms, "
                 f"as coloured as this by chance: {found['whiteness']:.2g}")
    return "\n".join(lines + [f"note  {remark}" for remark in found["remarks"]])


def plant_yaml(found, source):
    """With the intervals as percentages, for the robustness table of a design."""
    def percent(p):
        size = np.hypot(p["re"], p["im"])
        return 100 * max(p["size_high"] / size - 1, 1 - p["size_low"] / size, 1e-4)  # the interval need not be even

    roots = [(f"{p['re']:.6g}{p['im']:+.6g}j" if p["im"] else f"{p['re']:.6g}") + (f" ± {percent(p):.2g} %" if p["identifiable"] and percent(p) < 99 else "") for p in found["poles"]]
    if found["integrator"]:
        roots = ["0", *roots]
    doubts = "".join(f"# pole {p['pole']} is NOT identifiable from this record\n" for p in found["poles"] if not p["identifiable"])
    doubts += "".join(f"# {remark}\n" for remark in found["remarks"])
    gain, name = found["gain"], "k" if found["integrator"] else "gain"
    if found["integrator"]:  # the form k, zeros, poles: leading coefficients
        for p in found["poles"]:
            gain *= np.hypot(p["re"], p["im"])
    spread = 100 * found["gain_half_width"] / max(abs(found["gain"]), 1e-300)
    lines = [f"# From {source} by tribo-design {version()} identify-plant; paste into a design file.", f"# fit where it moves {found['fit_percent_where_it_moves']:.2f} %"]
    text = "\n".join(lines) + f"\n{doubts}plant:\n  {name}: {gain:.6g}" + (f" ± {spread:.2g} %" if 1e-4 < spread < 99 else "") + f"\n  zeros: []\n  poles: [{', '.join(roots)}]\n"
    if found["delay_s"]:
        late = 100 * (found["delay_half_width_s"] or 0) / found["delay_s"]
        text += f"  delay_s: {found['delay_s']:.6g}" + (f" ± {late:.2g} %" if 1e-4 < late < 99 else "") + "\n"
    return text


def _plot(record, best):
    from .drawing import figure_of, look, png

    plain = replace(best.noise, memory=1.0)
    model = _matrix(record, best.structure, best.theta, plain.columns(record)) @ best.linear
    figure, axes = figure_of(2, 1, (9, 6))
    axes[0, 0].plot(record.t, record.y, color=look.MEASURED, lw=2.5, label="measured")
    axes[0, 0].plot(record.t, model, color=look.MODEL, lw=1.2, ls="--", label=f"model of order {best.structure}")
    axes[0, 0].legend()
    axes[0, 0].set_ylabel("y")
    axes[1, 0].plot(record.t, record.y - model, color=look.DIFFERENCE, lw=0.9)
    axes[1, 0].set_ylabel("residual")
    axes[1, 0].set_xlabel("time [s]")
    return png(figure)
