/// Elementary functions in double precision that have the same bits on every machine. Those of libm differ between
/// libraries, and on one processor with its instructions; a simulated plant would differ with them.
///
/// The functions use only operations whose bits IEEE 754 fixes: + - * /, and from libm fabs, fmod and frexp. Results are within
/// 1 ulp; NaN gives NaN, infinities give the limits.

#ifndef COMMON_ELEMENTARY_H
#define COMMON_ELEMENTARY_H

double common_exp(double x);
double common_expm1(double x); ///< exp(x) - 1
double common_tanh(double x);

/// Returns ln(x); x < 0 gives NaN, 0 gives -infinity.
double common_log(double x);

/// Returns x^y for x >= 0, otherwise NaN. Within 1 ulp while |y ln(x)| <= 10.
double common_pow(double x, double y);

/// Returns sin(x) or cos(x) within 1 ulp for |x| <= 1e6; beyond that, of x modulo 2 pi with 2 pi as a double.
double common_sin(double x);
double common_cos(double x);

#endif
