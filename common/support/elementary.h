/// Elementary functions that have the same bits on every machine, in double precision. libm's differ from one to the next, and on one
/// processor by the instructions that it has: a simulated plant would differ with them.
///
/// Made of operations that IEEE 754 leaves no freedom: + - * /, and of libm fabs, fmod and frexp. Within 1 ulp; NaN gives NaN,
/// infinities give the limits.

#ifndef COMMON_ELEMENTARY_H
#define COMMON_ELEMENTARY_H

double common_exp(double x);
double common_expm1(double x); ///< exp(x) - 1
double common_tanh(double x);

/// ln(x); x < 0 gives NaN, 0 gives -infinity.
double common_log(double x);

/// x^y for x >= 0, else NaN. Within 1 ulp while |y ln(x)| <= 10.
double common_pow(double x, double y);

/// Within 1 ulp for |x| <= 1e6; beyond, of x modulo 2 pi as a double.
double common_sin(double x);
double common_cos(double x);

#endif
