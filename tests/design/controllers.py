"""Controllers for every form of import: python-control's mixsyn and hinfsyn on seeded problems.

The truth is the file's own numbers, evaluated here in exact rational or 500-bit arithmetic, whatever their scaling.
"""

import json
import signal
import warnings

import control as ct
import flint
import numpy as np
import scipy.io
import scipy.signal
from problems import well_posed

H = 1e-3
FORMS = ("ss.json", "ss.mat", "zpk.json", "zpk.csv", "tf.json", "ss_discrete.json", "zpk_discrete.json", "tf_discrete.json", "sos.json", "sos.csv")


def synthesised(seed):
    """K(s) as python-control leaves it, often badly scaled; None where the solver finds none."""
    data = well_posed(seed)
    poles, zeros = ([complex(r) for r in data["plant"][k]] for k in ("poles", "zeros"))
    gain = data["plant"]["gain"] * np.prod(-np.array(poles)) / (np.prod(-np.array(zeros)) if zeros else 1)
    w = data["weights"]
    signal.signal(signal.SIGALRM, _too_long)
    signal.alarm(10)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            plant = ct.ss(ct.zpk(zeros, poles, np.real(gain)))
            weights = [ct.ss(ct.tf(w[n]["num"], w[n]["den"])) for n in ("wp", "wT")]
            if seed % 2:
                k, _, _ = ct.mixsyn(plant, weights[0], ct.ss([], [], [], [[w["wu"]]]), weights[1])
            else:
                k = ct.hinfsyn(ct.augw(plant, weights[0], ct.ss([], [], [], [[w["wu"]]]), weights[1]), 1, 1)[0]
    except (TimeoutError, ArithmeticError, ValueError):
        return None
    finally:
        signal.alarm(0)
    return tuple(np.asarray(m) for m in ct.ssdata(k))


def _too_long(*_):
    raise TimeoutError


def polynomials(a, b, c, d):
    """Numerator and denominator, highest power first, rounded to double from exact ones."""
    n = len(a)
    exact = flint.fmpq_mat(n, n, [q(x) for x in a.ravel()])
    loop = exact - flint.fmpq_mat(n, 1, [q(x) for x in b.ravel()]) * flint.fmpq_mat(1, n, [q(x) for x in c.ravel()])
    den = exact.charpoly()
    num = loop.charpoly() + (q(d.ravel()[0]) - 1) * den
    return [[float(flint.arb(x)) for x in reversed(p.coeffs())] for p in (num, den)]


def q(x):
    return flint.fmpq(*float(x).as_integer_ratio())


def write(folder, form, k):
    """The controller's file in a form, and its exact response as a function of complex points; None where the form cannot have it."""
    a, b, c, d = k
    path = folder / form
    discrete = "discrete" in form or "sos" in form
    if discrete:  # Tustin
        n = len(a)
        inverse = np.linalg.inv(np.eye(n) - a * H / 2)
        a, b, c, d = inverse @ (np.eye(n) + a * H / 2), inverse @ b * H, c @ inverse, d + c @ inverse @ b * H / 2
    data = {"sample_time_s": H} if discrete else {}
    if "ss" in form:
        truth = lambda points: state_space(a, b, c, d, points)  # noqa: E731
        data.update(a=a.tolist(), b=b.ravel().tolist(), c=c.ravel().tolist(), d=float(d[0, 0]))
        if form.endswith(".mat"):
            scipy.io.savemat(path, {"A": a, "B": b, "C": c, "D": d})
    elif "tf" in form:
        num, den = polynomials(a, b, c, d)
        data.update(num=num, den=den)
        truth = lambda points: rational([num], [den], 1.0, points)  # noqa: E731
    else:
        num, den = polynomials(a, b, c, d)
        zeros, poles = paired(np.roots(num)), paired(np.roots(den))
        gain = num[0] / den[0]
        if "sos" in form:
            rows = scipy.signal.zpk2sos(zeros, poles, gain)
            if any(r[0] == 0 for r in rows):
                return None
            data["sos"] = rows.tolist()
            truth = lambda points: rational([r[:3] for r in rows], [r[3:] for r in rows], 1.0, points)  # noqa: E731
            if form.endswith(".csv"):
                path.write_text("b0,b1,b2,a0,a1,a2\n" + "\n".join(",".join(repr(float(x)) for x in r) for r in rows) + "\n")
        else:
            data.update(zeros=[[z.real, z.imag] for z in zeros], poles=[[p.real, p.imag] for p in poles], k=gain)
            truth = lambda points: roots_response(zeros, poles, gain, points)  # noqa: E731
            if form.endswith(".csv"):
                rows = [f"zero,{z.real!r},{z.imag!r}" for z in zeros] + [f"pole,{p.real!r},{p.imag!r}" for p in poles] + [f"gain,{gain!r},0"]
                path.write_text("kind,re,im\n" + "\n".join(rows) + "\n")
    if form.endswith(".json"):
        path.write_text(json.dumps(data))
    return path, truth, discrete


def paired(roots):
    """numpy's roots with exact conjugates, as Python complex numbers."""
    return [complex(r.real) for r in roots if r.imag == 0] + [complex(v) for r in roots if r.imag > 0 for v in (r, np.conj(r))]


def state_space(a, b, c, d, points):
    """Solves with 500 bits."""
    with flint.ctx.workprec(500):
        row = flint.acb_mat([[flint.acb(float(x)) for x in c.ravel()]])
        out = []
        for p in points:
            x = flint.acb(p.real, p.imag)
            m = flint.acb_mat([[(x if i == j else 0) - flint.acb(float(v)) for j, v in enumerate(line)] for i, line in enumerate(a)])
            out.append(complex((row * m.solve(flint.acb_mat([[flint.acb(float(v))] for v in b.ravel()])))[0, 0] + float(d[0, 0])))
    return np.array(out)


def rational(nums, dens, gain, points):
    with flint.ctx.workprec(500):
        out = []
        for p in points:
            value = flint.acb(gain)
            for num, den in zip(nums, dens):
                for polynomial, up in ((num, True), (den, False)):
                    total = flint.acb(0)
                    for x in polynomial:
                        total = total * flint.acb(p.real, p.imag) + flint.acb(float(x))
                    value = value * total if up else value / total
            out.append(complex(value))
    return np.array(out)


def roots_response(zeros, poles, gain, points):
    with flint.ctx.workprec(500):
        out = []
        for p in points:
            value, x = flint.acb(gain), flint.acb(p.real, p.imag)
            for z in zeros:
                value *= x - flint.acb(z.real, z.imag)
            for r in poles:
                value /= x - flint.acb(r.real, r.imag)
            out.append(complex(value))
    return np.array(out)


def outcome(folder, form, k, design):
    """"equal", "refused: ..." or "WRONG ...", of one import."""
    from tribo_design.errors import InputError
    from tribo_design.importer import load_controller

    made = write(folder, form, k)
    if made is None:
        return "no such form"
    path, truth, discrete = made
    try:
        imported = load_controller(path, design)[0].zpk
    except InputError as error:
        return f"refused: {str(error).removeprefix(str(path))}"
    omega = np.geomspace(1e-4, 0.97 * np.pi / H, 50) if discrete else np.geomspace(1e-4, 1e11, 60)
    points = np.exp(1j * omega * H) if discrete else 1j * omega
    accepted, wanted = imported(points - 1 if discrete else points), truth(points)
    error = np.abs(accepted - wanted).max() if not np.any(wanted) else (np.abs(accepted - wanted) / np.abs(wanted)).max()
    return "equal" if error <= 1e-6 else f"WRONG by {error:.3g}"
