"""Roots without rounding: a system's numbers are binary fractions, so its polynomials are exact over the rationals.

Eigenvalue solvers lose a slow pole beside a fast one, and which of a badly scaled system's modes are minimal is a
matter of their tolerances. FLINT's characteristic polynomial is exact, and its roots are isolated with certainty; only the last
step rounds them to double. Nothing is reduced on the way: a hidden mode stays as a pole with a zero on top of it.
"""

import flint
import numpy as np
from flint import acb, acb_mat, acb_poly, fmpq, fmpq_mat, fmpq_poly

from .zpk import Zpk

BITS = 192  # precision of the roots before they are rounded to double


def rational(value):
    return fmpq(*float(value).as_integer_ratio())


class Ratio:
    """num(x) / den(x) with rational coefficients, lowest power first."""

    def __init__(self, num, den):
        self.num, self.den = num, den

    @classmethod
    def of_state_space(cls, a, b, c, d):
        """den = |xI - A|, num = |xI - A + b c| + (d - 1) |xI - A|."""
        a, b, c = (np.asarray(m, float) for m in (a, b, c))
        n = len(a)
        exact_a = fmpq_mat(n, n, [rational(x) for x in a.ravel()])
        column, row = (fmpq_mat(*shape, [rational(x) for x in m.ravel()]) for shape, m in (((n, 1), b), ((1, n), c)))
        den = exact_a.charpoly()
        return cls((exact_a - column * row).charpoly() + (rational(np.asarray(d, float).ravel()[0]) - 1) * den, den)

    @classmethod
    def of_zpk(cls, system):
        num, den = fmpq_poly([rational(system.gain)]), fmpq_poly([1])
        for root in system.zeros:
            num *= _factor(root)
        for root in system.poles:
            den *= _factor(root)
        return cls(num, den)

    @classmethod
    def of_polynomials(cls, num, den):
        """Highest power first, as transfer functions are written."""
        return cls(*(fmpq_poly([rational(x) for x in reversed(list(p))]) for p in (num, den)))

    @classmethod
    def of_sections(cls, rows):
        """Rows b0, b1, b2, a0, a1, a2 in z^-1."""
        num, den = fmpq_poly([1]), fmpq_poly([1])
        for row in rows:
            part = cls.of_polynomials(row[:3], row[3:])
            num, den = num * part.num, den * part.den
        return cls(num, den)

    def moved_to_delta(self):
        """Converts from z to d = z - 1."""
        shift = fmpq_poly([1, 1])
        return Ratio(self.num(shift), self.den(shift))

    def without_common_delays(self):
        """Multiplies numerator and denominator by z, which writes a first-order section as a second-order one."""
        num, den = self.num, self.den
        while num.degree() > 0 and den.degree() > 0 and num[0] == 0 and den[0] == 0:
            num, den = num.right_shift(1), den.right_shift(1)
        return Ratio(num, den)

    def zpk(self):
        """Zeros, poles and gain, each root right to the last digit."""
        if self.num.degree() < 0:
            return Zpk([], _roots(self.den), 0.0)
        gain = self.num[self.num.degree()] / self.den[self.den.degree()]
        return Zpk(_roots(self.num), _roots(self.den), _to_float(gain))

    def __call__(self, points):
        """Returns the response at complex points; only the result is rounded."""
        with flint.ctx.workprec(4 * BITS):
            num, den = acb_poly(self.num), acb_poly(self.den)
            return np.array([complex(num(acb(p.real, p.imag)) / den(acb(p.real, p.imag))) for p in np.atleast_1d(points)])


def _factor(root):
    """x - r; of a conjugate pair the quadratic, once."""
    if root.imag == 0:
        return fmpq_poly([-rational(root.real), 1])
    if root.imag < 0:
        return fmpq_poly([1])
    re, im = rational(root.real), rational(root.imag)
    return fmpq_poly([re * re + im * im, -2 * re, 1])


def closed_loop_poles(plant, controller):
    """Returns the zeros of 1 + G K, hidden modes included, each exact to the last digit; None if 1 + G K vanishes at infinity."""
    polynomial = plant.den * controller.den + plant.num * controller.num
    if polynomial.degree() < plant.den.degree() + controller.den.degree():
        return None
    return _roots(polynomial)


def _to_float(value):
    with flint.ctx.workprec(BITS):
        return float(flint.arb(value))


def _roots(polynomial):
    found = []
    if polynomial.degree() > 0:
        with flint.ctx.workprec(BITS):
            for root, count in polynomial.complex_roots():
                found += [complex(float(root.real.mid()), 0.0 if root.imag == 0 else float(root.imag.mid()))] * count
    return np.array(found, complex)


def state_space_response(a, b, c, d, points):
    """C (xI - A)^-1 B + D, by solving in 768 bits: nothing of the polynomials is used, so it checks them."""
    n = len(a)
    with flint.ctx.workprec(4 * BITS):
        exact = [[acb(float(x)) for x in row] for row in np.asarray(a, float)]
        column = acb_mat([[acb(float(x))] for x in np.ravel(b)])
        row = [acb(float(x)) for x in np.ravel(c)]
        out = []
        for p in np.atleast_1d(points):
            x = acb(p.real, p.imag)
            matrix = acb_mat([[x - v if i == j else -v for j, v in enumerate(line)] for i, line in enumerate(exact)])
            solved = matrix.solve(column)
            total = acb(float(np.ravel(d)[0]))
            for i in range(n):
                total += row[i] * solved[i, 0]
            out.append(complex(total))
    return np.array(out)


def zpk_of(system):
    """Zeros, poles and gain of a state-space system as it is, hidden modes included."""
    if system.nstates == 0:
        return Zpk(gain=system.D[0, 0])
    return Ratio.of_state_space(*(np.asarray(m) for m in (system.A, system.B, system.C, system.D))).zpk()
