#!/usr/bin/env python3
"""Prints the coefficients of tanh_over_x in lib/src/friction_f32.c.

Fits tanh(x)/x by P(s)/Q(s), s = x^2, P and Q of degree 3, over 0 < x <= 6, for the least relative error
(Lawson's reweighted least squares on the linearised problem). Needs numpy.
"""

import numpy

X_MAX = 6.0
DEGREE = 3


def fit(x, iterations=400):
    s = x * x
    g = numpy.tanh(x) / x
    weight = numpy.ones_like(s)
    q = numpy.ones_like(s)
    best_error, best = numpy.inf, None
    powers = s[:, None] ** numpy.arange(DEGREE + 1)
    for _ in range(iterations):
        scale = numpy.sqrt(weight) / (g * q)
        matrix = numpy.hstack([powers, -g[:, None] * powers[:, 1:]])
        column = numpy.abs(matrix).max(axis=0)
        solution = numpy.linalg.lstsq(matrix / column * scale[:, None], g * scale, rcond=None)[0] / column
        p = powers @ solution[: DEGREE + 1]
        q = 1.0 + powers[:, 1:] @ solution[DEGREE + 1 :]
        error = numpy.abs(p / q / g - 1.0)
        if error.max() < best_error:
            best_error, best = error.max(), solution
        weight *= error / error.max() + 1e-3
        weight /= weight.mean()
    return best_error, best


def main():
    x = X_MAX * (1.0 - numpy.cos(numpy.linspace(0.0, numpy.pi, 6000)[1:])) / 2.0
    error, c = fit(x)
    print(f"relative error {error:.2e}")
    print("P, from s^0:", ", ".join(f"{value:.8e}" for value in c[: DEGREE + 1]))
    print("Q, from s^1:", ", ".join(f"{value:.8e}" for value in c[DEGREE + 1 :]), "(s^0: 1)")


if __name__ == "__main__":
    main()
