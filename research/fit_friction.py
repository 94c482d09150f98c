#!/usr/bin/env python3
"""Prints the coefficients of lib/src/friction/law_f32.h and friction_q31.h.

Approximates 2^-f on 0 <= f <= 1 by a polynomial of degree 4, and 1 - tanh(x)/x on 0 < x <= 2.66 by
s (r1 + r2 s)/(1 + q1 s + q2 s^2), s = x^2. Both have the least maximum relative error, of 2^-f and of tanh(x)/x (Lawson's
reweighted least squares). Needs numpy.
"""

import numpy

X_MAX = 2.66  # beyond atanh(1/1.01), where friction has reached its breakaway for every k


def lawson(error_of, solve, points, iterations=400):
    """Returns the smallest maximum error and its solution. Increases the weights where the error is large."""
    weight = numpy.ones(points)
    best_error, best = numpy.inf, None
    for _ in range(iterations):
        solution = solve(weight)
        error = error_of(solution)
        if error.max() < best_error:
            best_error, best = error.max(), solution
        weight *= error / error.max() + 1e-3
        weight /= weight.mean()
    return best_error, best


def fit_power():
    f = numpy.linspace(0.0, 1.0, 4001)
    powers = f[:, None] ** numpy.arange(5)
    exact = 2.0**-f

    def solve(weight):
        scale = numpy.sqrt(weight) / exact
        return numpy.linalg.lstsq(powers * scale[:, None], exact * scale, rcond=None)[0]

    return lawson(lambda c: numpy.abs(powers @ c / exact - 1.0), solve, len(f))


def fit_shortfall():
    x = X_MAX * (1.0 - numpy.cos(numpy.linspace(0.0, numpy.pi, 6000)[1:])) / 2.0
    s = x * x
    g = numpy.tanh(x) / x
    powers = s[:, None] ** numpy.arange(1, 3)
    denominator = numpy.ones_like(s)

    def solve(weight):
        scale = numpy.sqrt(weight) / (g * denominator)
        matrix = numpy.hstack([powers, -(1.0 - g)[:, None] * powers])
        column = numpy.abs(matrix).max(axis=0)
        return numpy.linalg.lstsq(matrix / column * scale[:, None], (1.0 - g) * scale, rcond=None)[0] / column

    def error_of(c):
        denominator[:] = 1.0 + powers @ c[2:]
        return numpy.abs(powers @ c[:2] / denominator - (1.0 - g)) / g

    return lawson(error_of, solve, len(s))


def main():
    (error, c), (shortfall_error, shortfall) = fit_power(), fit_shortfall()
    print("2^-f, from f^0:", ", ".join(f"{value:.9g}" for value in c), f"(relative error {error:.2e})")
    print("    over 8:", ", ".join(f"{value / 8:.9g}" for value in c))
    print("    in Q32:", ", ".join(f"{round(abs(value) * 2**32)}" for value in c))
    print("r1, r2, q1, q2:", ", ".join(f"{value:.9g}" for value in shortfall), f"(relative error {shortfall_error:.2e})")
    p, q = numpy.sort(-1.0 / numpy.roots([shortfall[3], shortfall[2], 1.0]))[::-1]
    ratios = (shortfall[0] / p, shortfall[1] / p**2, q / p)
    print(f"    (1 + p s)(1 + q s): p^(-1/2) = {p**-0.5:.9g}, r1/p, r2/p^2, q/p:", ", ".join(f"{v:.9g}" for v in ratios))
    halves = zip(shortfall, (0.5, 2.0, 0.5, 2.0))
    print("    r1/2, 2 r2, q1/2, 2 q2 in Q32:", ", ".join(f"{round(v * m * 2**32)}" for v, m in halves))


if __name__ == "__main__":
    main()
