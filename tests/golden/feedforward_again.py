#!/usr/bin/env python3
"""A second implementation of docs/feedforward.md in double precision, written from that page alone and apart from feedforward.py, and
golden vectors of cases that those of feedforward.py do not have.

    tests/golden/feedforward_again.py            writes feedforward_again_*.csv beside it
    tests/golden/feedforward_again.py --check    compares them with what it would write, and plays feedforward_*.csv of the other model

Inputs are scripted, not of a closed loop, on a grid that single precision and Q31 hold exactly. A case is refused if one of its
decisions is so close that rounding could turn it.
"""
import argparse
import csv
import math
import pathlib
import random
import struct
import sys

FOLDER = pathlib.Path(__file__).resolve().parent
RESTART, ENTER, START, MOVING, HOLD = range(5)
KEEP, REVERSAL, CONTINUE, TAKE_OVER = range(4)
DO_RESTART, DO_ENTER, DO_CHANGE, DO_RESET, DO_RESTORE, FLIP_V0, TO_OTHER, FLIP_B = range(1, 9)  # events before a tick
N = 10  # ticks of a sample
ALIKE = 5e-8  # of input_max
GRID, FINE = 2.0**-22, 2.0**-36  # N
GIVEN = ("event", "entry", "share", "r", "y", "v", "u", "limited")
EXPECTED = ("e", "mode", "lin", "f", "lead", "b", "term", "sigma", "z", "V0", "V1", "V2", "V3", "V4", "c0", "c1", "c2", "doubt", "P4",
            "lambda", "turns", "xi", "back", "forgotten")


def clamp(x, low, high):
    return low if x < low else high if x > high else x


def sign(x):
    return (x > 0) - (x < 0)


class Params:
    """Keys and private constants, by the letters of the page."""

    def __init__(self, h=1e-3, input_max=2.0, g_0=0.0, K=3.84, b_arm=0.0288, line=((0.007, 0.3), (0.007, 0.3)), table=None, p_a=200.0,
                 p_s=55.0, w=0.0, d_4=0.0, T_j=0.0, alpha=0.7, gamma=0.5, Q=0.0, T_q=0.2):
        self.h, self.input_max, self.g_0, self.line, self.table, self.p_a = h, input_max, g_0, line, table, p_a
        self.alpha, self.gamma, self.T_q = alpha, gamma, T_q
        self.lag_arm = b_arm / K
        self.tau = 1 / p_a + self.lag_arm
        B = self.B = self.L(input_max / 4)
        self.w = w or B / 314
        d_4 = d_4 or B / 11
        self.d = [self.w / 2] + [d_4 * (3 / 8) ** k for k in (3, 2, 1, 0)]
        self.T_j = T_j or 2.1 * self.tau
        self.Q = Q or 0.0157 / B
        self.n_0 = 0.002 * self.w
        self.dr_s = B / 0.0785 * h
        self.T_n, self.T_r, self.T_y = max(0.25, 100 * h), max(0.8 * self.tau, 2 * h), max(0.8 * self.tau, 5 * h)
        self.dm_max = B / 0.314 * N * h
        self.s_V, self.s_U, self.s_0, self.s_1 = 0.4, 0.55, B / 5.23, 0.1
        self.E_pa, self.E_ps = 1 - math.exp(-p_a * h), 1 - math.exp(-p_s * h)
        self.still, self.quick = self.ticks(T_q), self.ticks(0.2)

    def ticks(self, T):
        return max(1, math.floor(T / self.h + 0.5))

    def low_pass(self, T, x, value, h=None):
        h = h or self.h
        return x + h / (T + h) * (value - x)

    def direction(self, i, F):
        if not self.table:
            return self.line[i][0] + self.line[i][1] * F
        at = [row[0] for row in self.table]
        L = [row[1 + i] for row in self.table]
        if F <= at[0]:
            return L[0]
        for k in range(1, len(at)):
            if F <= at[k]:
                return L[k - 1] + (L[k] - L[k - 1]) * (F - at[k - 1]) / (at[k] - at[k - 1])
        return L[-1]

    def L(self, F):
        return (self.direction(0, abs(F)) + self.direction(1, abs(F))) / 2

    def D(self, F):
        return (self.direction(0, abs(F)) - self.direction(1, abs(F))) / 2 - self.g_0


class Model:
    def __init__(self, params, other=None):
        self.p, self.other = params, other or params
        self.closest, self.forgotten = 1.0, 0
        self.reset()

    def decides(self, x, limit):
        self.closest = min(self.closest, abs(abs(x) - limit) / self.p.input_max)

    # From outside.

    def reset(self):
        self.V, self.W, self.c = [1.0, 0, 0, 0, 0], [1.0, 0, 0, 0, 0], [0.0, 0.0, 0.0]
        self.M = [[float(i == j) for j in range(4)] for i in range(4)]
        self.P = [None, 1.0, 1.0, 1.0, 1.0]
        self.doubt, self.lam = 1.0, 0.0
        self.xi, self.harm, self.n_f, self.n_l = 0.0, False, 0, 0
        self.n_b, self.forgotten = 0, 0
        self.mode, self.term_last, self.next_rule = RESTART, 0.0, KEEP
        self.unsealed = self.unsealed_b = False

    def change(self, params):
        if self.mode >= START:
            self.next_rule = TAKE_OVER
            for j in range(5):
                self.x[j] *= params.d[j] / self.p.d[j]
                self.X[j] *= params.d[j] / self.p.d[j]
        self.p = params

    def happen(self, event, entry):
        if event == DO_RESTART:
            self.mode = RESTART
        elif event == DO_ENTER:
            self.mode, self.term_last = ENTER, entry
        elif event == DO_CHANGE:
            self.change(self.p)
        elif event == DO_RESET:
            self.reset()
        elif event == DO_RESTORE:
            self.xi, self.harm, self.n_f, self.n_l, self.n_b = 0.0, False, 0, 0, 0
        elif event == FLIP_V0:
            self.V[0], self.unsealed = entry, True
        elif event == TO_OTHER:
            before = self.p
            self.change(self.other)
            self.other = before
        elif event == FLIP_B:
            self.b, self.unsealed_b = entry, True

    def forget(self, term):
        count = self.forgotten + 1
        self.reset()
        self.mode, self.term_last, self.forgotten = ENTER, term, count
        self.seen["sigma"] = 0.0

    def begin(self, r, y):
        at = r if self.mode == ENTER else y
        self.next_rule = TAKE_OVER if self.mode == ENTER else KEEP
        self.b = 0.0 if self.mode == ENTER else self.load(y)
        self.term_last = self.term_last if self.mode == ENTER else 0.0
        self.r1, self.r2, self.n_r = r, r, 0.0
        self.rs, self.rate, self.rn, self.rp, self.s, self.sigma, self.x = at, 0.0, at, at, 0, 0.0, [0.0] * 5
        self.m_1, self.m_2 = at, at
        self.f, self.u_last, self.limited = 0.0, y, 0
        self.y1, self.y2, self.n_y, self.u_1, self.u_2, self.yf, self.zf, self.z, self.m = y, y, 0.0, y, y, y, 0.0, 0.0, y
        self.a, self.q, self.side, self.since, self.quick = at, 0, 0, 0, 0
        self.e_bar, self.n_e, self.n_a, self.rests = 0.0, 0.0, 1.0, False
        self.stage, self.m_s, self.z_s, self.X = 0, y, 0.0, [0.0] * 5
        self.side_s, self.hunts, self.since_s, self.delta, self.l = 0, False, 0, 0.0, 0.0
        self.vf, self.vp, self.t_v, self.need, self.v_bar = 0.0, 0.0, 0.0, 0.0, 0.0
        self.mode, self.unsealed_b = START, False

    def load(self, F):
        return self.c[0] + self.c[1] * abs(F) + self.c[2] * F

    def G(self):
        return self.share * (1 - (1 - self.p.gamma) * self.doubt) * self.p.L(self.rs)

    def friction(self, sigma):
        sum_ = self.W[0] * sigma + sum(self.W[j] * self.x[j] / self.p.d[j] for j in range(1, 5))
        return self.G() * clamp(sum_, -4, 4)

    # Steps 1 to 8.

    def error(self, r, y, share):
        p = self.p
        self.share = share
        r_good, self.y_good = abs(r) <= p.input_max, abs(y) <= p.input_max
        self.waits = self.mode in (RESTART, ENTER) and not (r_good and self.y_good)
        if self.waits:
            return 0.0
        if self.mode in (RESTART, ENTER):
            self.begin(r, y)
        self.rule, self.next_rule = self.next_rule, KEEP
        if self.unsealed_b:
            self.rule, self.unsealed_b, self.forgotten = TAKE_OVER, False, self.forgotten + 1
        r = r if r_good else self.r1
        self.y = y = y if self.y_good else self.y1
        # 2
        d2 = min(abs(r - 2 * self.r1 + self.r2), 4 * self.n_r + p.n_0)
        self.n_r += min(1, p.h / p.T_n) * (d2 - self.n_r)
        self.r1, self.r2 = r, self.r1
        w_n = 4 * self.n_r
        # 3
        dr = r - self.rs
        dr = 0.0 if dr * self.limited > 0 else dr
        step = abs(dr) > p.dr_s
        self.decides(dr, p.dr_s)
        e_0 = self.m_2 - y
        self.rs += dr
        self.rate = p.low_pass(p.T_r, self.rate, 0 if step else dr / p.h)
        # 4
        half = (p.w + w_n) / 2
        rn = clamp(self.rn, self.rs - w_n / 2, self.rs + w_n / 2)
        for j in range(1, 5):
            self.x[j] = clamp(self.x[j] + rn - self.rn, -p.d[j], p.d[j])
        self.rn = rn
        rp = clamp(self.rp, self.rs - half, self.rs + half)
        if sign(self.rs - self.rp) != self.s:
            self.decides(self.rs - self.rp, half)
        before, self.s = self.s, sign(rp - self.rp) or self.s
        self.rp = rp
        self.flips = self.s != before
        self.first = self.flips and before == 0
        self.decides(self.rs - self.a, half)
        if abs(self.rs - self.a) > half:
            if self.mode == HOLD and step:
                self.e_bar = self.rs - self.a
            else:
                self.q = 0
            self.rests, self.a = False, self.rs
        elif self.q < p.still:
            self.q += 1
        self.back = self.harm and self.n_f > 0
        self.still = p.T_q > 0 and self.q >= p.still
        stands = self.back or self.still
        if self.flips and not stands:
            self.turn()
        # 5
        ahead = p.tau * self.rate * p.w / (p.w + w_n)
        self.lin = self.rs + ahead + p.D(self.rs) + self.load(self.rs)
        self.m_1 = p.low_pass(p.tau, self.m_1, self.rs + ahead)
        self.m_2 += p.E_ps * (self.m_1 - self.m_2)
        self.e = e_0 if self.y_good else 0.0
        if self.y_good:
            self.e_bar = p.low_pass(0.3, self.e_bar, e_0)
        # 6
        self.need_now, self.lead = self.f - self.b, 0.0
        if self.mode == START or not (stands or self.mode == HOLD):
            self.follow(step)
        elif stands:
            self.hold()
        else:
            self.leave()
        return self.e

    def turn(self):
        one = clamp((self.M[0][0] - 0.15) / 0.25, 0, 1)
        lack = -one * self.l * self.X[0] / self.p.d[0]
        if lack > 0:
            V = clamp(self.V[0] - 1.15 * lack, 0.02, 3)
            self.W[0] += V - self.V[0]
            self.V[0] = V
            self.c = [c * (1 - one) for c in self.c]
            self.l *= 1 - one

    def follow(self, step):
        p, G = self.p, self.G()
        if self.s != 0:
            self.mode = MOVING
        if self.flips and (self.first or step and self.doubt > 0.5):
            self.b += G * self.W[0] * (self.s - self.sigma)
            self.sigma = float(self.s)
        else:
            by = clamp(self.s - self.sigma, -min(2, 2 * p.h / p.T_j), min(2, 2 * p.h / p.T_j))
            self.lead = p.alpha / (p.p_a * p.h) * G * self.W[0] * by
            self.sigma += by
            if self.flips:
                self.rule = REVERSAL if self.rule == KEEP else self.rule
                at_bound = self.V[0] <= 0.2 or self.V[0] >= 3
                self.n_b = 4 if self.n_b == 4 else self.n_b + 1 if at_bound else 0
        self.f = self.friction(self.sigma)

    def hold(self):
        p = self.p
        B_h = (1 - self.lam) * self.V[0] * self.share * p.L(self.rs)
        net = self.u_last - self.m - (p.D(self.rs) + self.load(self.rs))
        before, self.f, self.sigma = self.f, 0.94 * clamp(net, -B_h, B_h), 0.0
        if self.mode != HOLD:
            self.mode = HOLD
            self.b += self.f - before
            self.side, self.since, self.quick, self.rests, self.delta = self.s, 0, 0, False, 0.0
        if sign(net) != self.side:
            self.decides(net, B_h)
        side = sign(net) if abs(net) > B_h else self.side
        if side != self.side:
            self.quick = min(self.quick + 1, 4) if self.since < p.quick else 0
            self.lam += 0.1 * (1 - self.lam) if self.quick == 4 else 0
            self.since = 0
        else:
            self.since = min(self.since + 1, p.quick)
        self.side = side
        if self.y_good:
            changed = self.y != self.y1
            self.n_a = p.low_pass(0.3, self.n_a, float(changed))
            if changed:
                self.n_e = p.low_pass(0.3, self.n_e, abs(self.y - 2 * self.y1 + self.y2))
            d_a = 0.07 * self.n_y
            d = d_a + 0.6 * self.n_e * (1 - self.n_a)
            self.e -= clamp(self.e_bar, -d, d)
            most = 2.5 * d_a if self.rests else d_a
            if self.still:
                alike = self.p.h / 0.016  # Q31's mean of 0.3 s is off by some 1e-6 N at 1 kHz
                self.decides(alike * self.e_bar, alike * most)
            self.rests = self.still and abs(self.e_bar) < most
        if self.rests:
            self.e, self.rule = 0.0, CONTINUE

    def leave(self):
        self.mode, self.rule = MOVING, CONTINUE
        self.sigma = float(self.s)
        rise = self.G() * self.W[0]
        if self.side != self.s and rise > 0:
            self.sigma = clamp((self.u_last - self.lin - self.friction(0.0)) / rise, -1, 1)
        self.f = self.friction(self.sigma)

    # Step 9.

    def sum(self, v):
        if self.waits:
            return self.term_last if self.mode == ENTER else 0.0
        p = self.p
        self.v = v
        if self.flips:
            self.judge(v, v + self.need_now)
        if self.rule == REVERSAL:
            calm = v + clamp(self.v_bar - v, -2 * self.n_y, 2 * self.n_y)
            beyond = self.s * (self.b - calm) - self.p.w  # what v made up for, pushing F beyond the reversal
            self.b = calm + self.s * min(max(beyond, 0), abs(self.load(self.rs)) / 4)
        elif self.rule == CONTINUE:
            self.b = v + self.lin + self.f - self.u_last
        elif self.rule == TAKE_OVER:
            self.b = self.lin + self.f - self.term_last
        self.b = clamp(self.b, -4 * p.input_max, 4 * p.input_max)
        self.term = self.lin + self.f - self.b
        self.v_bar = p.low_pass(p.T_y, self.v_bar, v)
        self.seen = {"lin": self.lin, "f": self.f, "lead": self.lead, "b": self.b, "sigma": self.sigma}
        return self.term + self.lead

    def judge(self, v, need):
        if self.back:
            self.n_f -= 1
            self.xi = self.xi if self.n_f else 0.51
        elif not self.first:
            self.n_l -= self.n_l > 0
            self.xi += (min(4, self.t_v / (abs(need - self.need) + 0.1 * self.p.B)) - self.xi) / 8
            self.decides(self.xi, 0.6)
            if self.xi > 0.6:
                self.harm, self.n_l = True, min(max(8 * self.n_l, 4), 128)
                self.n_f = self.n_l
        if self.back or self.first:
            self.vf, self.vp = v, v
        self.need, self.t_v = need, 0.0

    # Steps 10 and 11.

    def after(self, u, limited):
        if self.waits:
            return
        p, y = self.p, self.y
        self.limited = sign(self.v + self.term + self.lead - u) if limited else 0
        self.u_last = self.u_last if self.rests and self.mode == HOLD else u
        self.term_last = self.term
        self.u_1 += p.E_pa * (u - self.u_1)
        self.u_2 += p.E_ps * (self.u_1 - self.u_2)
        d2 = min(abs(y - 2 * self.y1 + self.y2), 4 * self.n_y + p.n_0)
        self.n_y += min(1, p.h / p.T_n) * (d2 - self.n_y)
        self.y1, self.y2 = y, self.y1
        yf = p.low_pass(p.T_y, self.yf, y)
        self.zf = p.low_pass(p.T_y, self.zf, self.u_2 - y)
        self.z = self.zf - p.lag_arm * (yf - self.yf) / p.h
        self.yf = yf
        half = (p.w / 5 + 0.4 * self.n_y) / 2
        self.m = clamp(self.m, yf - half, yf + half)
        self.seen["z"] = self.z
        if self.flips:
            return
        stage, self.stage = self.stage, (self.stage + 1) % N
        work = (self.sample, self.regressor, self.project, self.weigh, self.weights, self.loads, self.use, self.covariance, self.variances,
                self.monitor)[stage]
        if stage in (0, 9) or self.delta > 0:
            work()

    def sample(self):
        p = self.p
        dm = self.m - self.m_s
        if sign(self.X[4] + dm) != self.side_s:
            self.decides(self.X[4] + dm, p.d[4])
        self.decides(dm, p.dm_max)
        for j in range(5):
            self.X[j] = clamp(self.X[j] + dm, -p.d[j], p.d[j])
        close = p.quick // 2
        side = sign(self.X[4]) if abs(self.X[4]) == p.d[4] else self.side_s
        if side != self.side_s:
            self.hunts, self.since_s = self.since_s < close, 0
        elif self.since_s < close:
            self.since_s += N
        self.side_s, self.jump = side, self.z - self.z_s
        self.m_s, self.z_s, self.yf_s = self.m, self.z, self.yf
        learns = self.mode == MOVING and self.limited == 0 and self.y_good and abs(dm) <= p.dm_max
        learns = learns and not (self.hunts and self.since_s < close)
        self.delta = min(abs(dm), p.B / 157) if learns else 0.0

    def regressor(self):
        p, F = self.p, self.yf_s
        L = p.L(F)
        part = [self.X[j] / p.d[j] for j in range(5)]
        psi = [part[0]] + [part[j] - part[j - 1] for j in range(1, 5)]
        self.k = (p.s_V * psi[0], min(2, p.s_0 / L), min(2, p.s_1 * abs(F) / L), clamp(p.s_1 * F / L, -2, 2))
        self.kappa = [None] + [p.s_U * psi[j] for j in range(1, 5)]
        self.eps = (self.z_s - p.D(F) - self.load(F)) / L - sum(self.V[j] * psi[j] for j in range(5))
        self.l = self.load(F) / L
        self.rho = p.B / 78.5 * (1 + min(8, 0.03 * abs(self.jump) / (N * p.h * L)) ** 2)

    def project(self):
        self.g = [sum(self.M[i][j] * self.k[j] for j in range(4)) for i in range(4)] + [0.0] * 4

    def weigh(self):
        for j in range(1, 5):
            self.g[3 + j] = self.P[j] * self.kappa[j]
        S = sum(self.g[i] * self.k[i] for i in range(4)) + sum(self.g[3 + j] * self.kappa[j] for j in range(1, 5))
        self.gain = self.delta / (self.rho + self.delta * S)
        if self.eps != 0:
            self.gain *= min(1, 4 * (S + 0.01) / self.eps**2)

    def weights(self):
        p, by = self.p, self.gain * self.eps
        self.V[0] = clamp(self.V[0] + p.s_V * by * self.g[0], 0.02, 3)
        for j in range(1, 5):
            self.V[j] = clamp(self.V[j] + p.s_U * by * self.g[3 + j], -2, 2)
        self.lam *= 1 - min(1, self.delta / (p.B / 1.57))

    def loads(self):
        p, by, before = self.p, self.gain * self.eps, self.load(self.rs)
        for i, (scale, most) in enumerate(((p.s_0, p.B), (p.s_1, 0.5), (p.s_1, 0.5))):
            self.c[i] = clamp(self.c[i] + scale * by * self.g[1 + i], -most, most)
        self.b += self.load(self.rs) - before
        self.A_n = 0.15 + 2 * self.n_y / (p.B / 7.85)

    def use(self):
        V, p = self.V, self.p
        A = sum(V[j] ** 2 for j in range(1, 5))
        S = [0.0] * 6
        for j in range(1, 5):
            S[j] = max(0, 1 - (self.A_n / A) ** 2) * V[j] ** 3 / (V[j] ** 2 + 0.2**2) if A > 0 else 0.0
        spared = min(self.k[1] * self.n_y / (3 * p.B / 7.85), V[0] / 4)
        self.W = [V[0] - S[1] - spared] + [S[j] - S[j + 1] for j in range(1, 5)]
        self.doubt *= 1 - min(1, self.delta / (p.B / 7.85))
        before, self.f = self.f, self.friction(self.sigma)
        self.b += self.f - before

    def cover(self, cells):
        part, g = min(1, self.p.Q * self.delta), self.g
        for i, j in cells:
            left = self.M[i][j] - self.gain * g[i] * g[j]
            left += part * ((i == j) - left)
            self.M[i][j] = self.M[j][i] = clamp(left, 0, 1) if i == j else clamp(left, -1, 1)

    def covariance(self):
        self.cover((i, j) for i in (0, 1) for j in range(i, 4))

    def variances(self):
        self.cover(((2, 2), (2, 3), (3, 3)))
        for j in range(1, 5):
            left = self.P[j] - self.gain * self.g[3 + j] ** 2
            self.P[j] = clamp(left + min(1, self.p.Q * self.delta) * (1 - left), 0, 1)

    def monitor(self):
        p = self.p
        if self.mode == MOVING:
            self.vf = p.low_pass(0.03, self.vf, self.v, N * p.h)
        half = (0.02 * p.B + 4 * self.n_y) / 2
        vp = clamp(self.vp, self.vf - half, self.vf + half)
        self.t_v = min(self.t_v + abs(vp - self.vp), 4 * p.B)
        self.vp = vp
        if self.unsealed:
            self.forget(self.term)

    def row(self, event, entry, share, r, y, v, u, limited):
        """What is expected of a tick, by name; NaN: not computed."""
        self.happen(event, entry)
        found = {"e": self.error(r, y, share), "term": self.sum(v)}
        self.after(u, limited != 0)
        found.update({} if self.waits else self.seen)
        found.update({"mode": self.mode, "doubt": self.doubt, "P4": self.P[4], "lambda": self.lam, "turns": self.n_b, "xi": self.xi,
                      "back": self.n_f, "forgotten": self.forgotten})
        found.update({f"V{j}": self.V[j] for j in range(5)})
        found.update({f"c{j}": self.c[j] for j in range(3)})
        return [found.get(name, math.nan) for name in EXPECTED]


# --- cases --------------------------------------------------------------------------------------------------------------------


def triangle(t, period, low, high):
    part = t / period % 1
    return low + (high - low) * min(2 * part, 2 - 2 * part)


class Rub:
    """(y, u) of a y that follows r, with the friction and the load of given weights: V_0 .. V_4, c_0 .. c_2, numbers or of the time."""

    def __init__(self, params, *weights, lag=0.02):
        self.p, self.weights = params, weights + (0.0,) * (8 - len(weights))
        self.part = params.h / (lag + params.h)
        self.y, self.x = None, [0.0] * 5

    def __call__(self, t, r):
        y = self.y = r if self.y is None else self.y + self.part * (r - self.y)
        move, self.last = y - getattr(self, "last", y), y
        d, L = self.p.d, self.p.L(y)
        self.x = [clamp(x + move, -width, width) for x, width in zip(self.x, d)]
        part = [x / width for x, width in zip(self.x, d)]
        w = [weight(t) if callable(weight) else weight for weight in self.weights]
        friction = w[0] * part[0] + sum(w[j] * (part[j] - part[j - 1]) for j in range(1, 5))
        return y, y + L * friction + w[5] + w[6] * abs(y) + w[7] * y


def exact(x, grid=GRID):
    return math.floor(x / grid + 0.5) * grid if math.isfinite(x) else x


def play(params, seconds, reference, rub, *, other=None, seed=1, noise=0.0, noise_r=0.0, v=lambda t: 0.0, u_of=None, y_of=None, events=None,
         bad=None):
    """Rows of a case. `rub` gives (y, u) of (t, r); `u_of` u of (t, u); `y_of` y of (t, y with its noise); `events` maps a tick to (event,
    entry), `bad` one to "r", "y" or both."""
    rng, model, rows = random.Random(seed), Model(params, other), []
    for k in range(round(seconds / params.h)):
        t = k * params.h
        event, entry = (events or {}).get(k, (0, 0.0))
        r = reference(t)
        y, u = rub(t, r)
        u = u_of(t, u) if u_of else u
        r += noise_r * rng.gauss(0, 1)
        y += noise * rng.gauss(0, 1)
        y = y_of(t, y) if y_of else y
        given = [event, exact(entry), 1.0, exact(r), exact(y), exact(v(t)), exact(u, FINE if abs(u) < 0.015 else GRID), 0]
        for name in (bad or {}).get(k, ""):
            given[GIVEN.index(name)] = math.nan
        rows.append(given + model.row(*given))
    if model.closest < ALIKE:
        raise SystemExit(f"a decision is as close as {model.closest:.1e}")
    return rows


def coarse():
    """100 Hz, a jump within a tick, no hold, noise; a step back while friction is in doubt."""
    params = Params(h=0.01, T_j=0.004, T_q=0.0, alpha=1.0, gamma=0.2)

    def reference(t):
        return 0.31 + 0.05 * t if t < 0.4 else 0.23 + 0.04 * math.sin(3 * t) if t < 1 else triangle(t, 1.73, -0.21, 0.37) if t < 9 else 0.2

    return params, None, play(params, 12, reference, Rub(params, 1.1, 0, 0, 0.3, 0.4), seed=1, noise=5e-4, noise_r=2e-4, v=lambda t: 0.1 * math.sin(t))


def fine():
    """5 kHz."""
    params = Params(h=2e-4)
    return params, None, play(params, 0.5, lambda t: 0.3 + 0.1503 * math.sin(27 * t), Rub(params, 1.1, 0, 0, 0.3, 0.4), seed=6, noise=1e-4, noise_r=1e-5,
                              v=lambda t: 0.1 * math.sin(9 * t))


def belief():
    """A V_0 that counts as at its bound but is above it, with params changed at reversals and a `restore`; b beyond its bound; two turns in
    one sample; from 5 s a breakaway far below the force."""
    params = Params(h=4e-3, input_max=0.5, line=((0.06, 0.5), (0.06, 0.5)), Q=2.0)
    low = Params(h=4e-3, input_max=0.5, line=((0.001, 0.02), (0.001, 0.02)), d_4=0.01)

    def reference(t):
        return triangle(t, 0.93, 0.051, 0.201) - (0.004 if 1.215 < t < 1.23 else 0.0)

    rubs = (Rub(params, 0.11, 0, 0, 0, 0, 0.02), Rub(low, 2.0, 1.0))

    def rub(t, r):
        return [one(t, r) for one in rubs][t >= 5]

    events = {1060: (DO_RESTORE, 0), 1250: (TO_OTHER, 0), 466: (DO_CHANGE, 0), 815: (DO_CHANGE, 0)}
    return params, low, play(params, 8, reference, rub, other=low, v=lambda t: 3.1 if 4 < t < 4.8 else 0.1 * math.sin(2.1 * t), events=events)


def hold():
    """Changes of side that are just close and just not, in a hold; bad readings in one, one at no force, one while friction is fed back, steps in it,
    params changed when it ends. Rest that begins with the hold and later, goes on over bad readings, a change of params and a flipped b, and ends
    with a creep of the error, a step, as r moves; with a y that always changes and one that seldom does."""
    params = Params(h=4e-3)

    def reference(t):
        if t < 2:
            return triangle(t, 2 / 3, 0.0011, 0.0811)
        if t < 4.3:
            return 0.0011 if t < 4 else 0.0101
        if t < 4.9:
            return 0.0101 + 0.155 * (t - 4.3)
        if t < 7.3:
            return 0.1031
        return triangle(t - 7.3, 0.21, 0.1031, 0.1331) if t < 8.7 else 0.1231 if t < 9.1 else 0.0631 if t < 9.2 else 0.0631 + 0.1 * (t - 9.2)

    def u_of(t, u):
        if 2.1 < t < 4.3:
            return 0.0011 - 0.0026 * math.cos(11.3 * t) - 0.0009 * math.sin(97 * t)
        if 5.3 < t < 7.3:
            width = 0.2 if t < 6.6 else 0.1  # changes of side 50 and 25 ticks apart
            return 0.1031 + (0.14 if (t - 5.3) // width % 2 else -0.14)
        return u

    def y_of(t, y):
        if 3 < t < 4.9:
            return exact(y + (0.004 if 3.1 < t < 3.5 or 4.1 < t < 4.34 else 0.0), 2.0**-8)  # a converter's steps: y seldom changes
        return y + 0.0009 if 5.16 < t < 6.32 else y

    bad = {k: "y" for k in (530, 700, 701, 702, 1500, 1510, 2230)}
    events = {701: (DO_CHANGE, 0), 720: (FLIP_B, 0.2), 1700: (DO_RESTART, 0), 2301: (DO_CHANGE, 0)}
    return params, None, play(params, 10, reference, Rub(params, 1.0), seed=10, noise=5e-4, u_of=u_of, y_of=y_of, bad=bad, events=events,
                              v=lambda t: (0.3 if 7.3 < t else 0.01) * math.sin(65.3 * t))


def retune():
    """Other params in each mode: at rest, entering, before the first motion, at a reversal, in its jump, within a sample, in a hold; a
    late first motion beside a controller that works; bad readings and flipped bits meanwhile."""
    params = Params()
    other = Params(p_a=150.0, p_s=80.0, w=1e-3, d_4=0.03, T_j=0.03, alpha=0.3, gamma=0.8, Q=0.5, T_q=0.1, line=((0.01, 0.25), (0.005, 0.35)),
                   g_0=0.004)

    def reference(t):
        if t < 0.317:
            return 0.2503
        if t < 1.7:
            return 0.25 + 0.0611 * math.sin(8.3 * (t - 0.312))
        return 0.2817 if t < 2.3 else 0.2817 + 0.0531 * math.sin(9.7 * (t - 2.6)) * (t > 2.6)

    def y_of(t, y):
        return exact(y, 2.0**-13) if 1.75 < t < 2.6 else y  # a converter's steps, within the noise

    bad = {**{k: "r" for k in range(8)}, **{k: "y" for k in (*range(8, 12), 300, 690, 2020)}, **{k: "ry" for k in (*range(2900, 2906), 3101)}}
    to_other = (6, 100, 400, 521, 690, 905, 1105, 1950, 2010, 2050, 2400, 2601, 2903)
    events = {**{k: (TO_OTHER, 0) for k in to_other}, 1400: (FLIP_B, 0.2), 2900: (DO_ENTER, 0.05), 3300: (FLIP_V0, 1.3)}
    return params, other, play(params, 3.5, reference, Rub(params, 0.9, 0, 0, 0.3, 0.3, 0.01), other=other, seed=2, noise=1e-4, noise_r=1e-5,
                               y_of=y_of, v=lambda t: 0.1 * math.sin(13 * t + 1), bad=bad, events=events)


def back():
    """Friction fed back for 4 reversals, longer after each trial that fails, up to 128: over a restart, an entry, other params, a stand, a
    step, bad readings, until restored; u rests in the stand alone. Then a trial that goes well for some reversals and fails."""
    params = Params(h=4e-3)
    other = Params(h=4e-3, w=1e-3, d_4=0.02, gamma=0.7, line=((0.01, 0.25), (0.005, 0.35)))

    def reference(t):
        if 5.2 < t < 5.95:
            return 0.4937  # a stand
        return triangle(t, 0.1603, 0.48, 0.52) + (0.05 if 6.4 < t < 6.9 else 0.0)  # two steps

    def v(t):
        well = 12.25 < t < 12.6  # a trial that saves
        return (0.002 if well else 0.3) * math.sin(65.3 * t)

    def y_of(t, y):
        return y + 0.0005 if 5.4 < t < 5.6 else y  # the error's mean falls sooner

    events = {60: (DO_RESTART, 0), 700: (DO_RESTART, 0), 950: (DO_ENTER, 0.05), 1113: (DO_CHANGE, 0), 1231: (TO_OTHER, 0), 1500: (TO_OTHER, 0),
              2900: (DO_RESTORE, 0)}
    bad = {800: "y", 801: "ry", 1440: "y", 1520: "y", 1650: "r"}
    return params, other, play(params, 14, reference, Rub(params, 1.0), other=other, seed=1, noise=1e-4, y_of=y_of, v=v, events=events,
                               bad=bad)


CASES = {"back": back, "coarse": coarse, "fine": fine, "belief": belief, "hold": hold, "retune": retune}


def text_of(rows):
    lines = ["# made by feedforward_again.py, a second implementation of docs/feedforward.md from its text", ",".join(GIVEN + EXPECTED)]
    lines += [",".join(f"{x:.9g}" if i < len(GIVEN) else f"{x:.7g}" for i, x in enumerate(row)) for row in rows]
    return "\n".join(lines) + "\n"


def differ(text, other):
    """True beyond the last digits of another machine's exp and sin."""
    numbers = [[[float(x) for x in line.split(",")] for line in of.split("\n")[2:-1]] for of in (text, other)]
    pairs = [pair for row, like in zip(*numbers) for pair in zip(row, like)]
    return len(numbers[0]) != len(numbers[1]) or not all(abs(x - y) <= 1e-7 * (1 + abs(x)) or (x != x and y != y) for x, y in pairs)


RIG = Params(h=5e-4, input_max=200.0, g_0=1.5, K=2e6, b_arm=2800.0, table=((0, 3, 2), (40, 8, 9), (80, 14, 18)), p_a=700.0, p_s=300.0, w=0.06,
             d_4=2.0, T_j=0.009, alpha=0.5, gamma=0.7, Q=0.002, T_q=0.15)
SLOW = Params(h=4e-3)
FIRST = {"tracking": Params(), "noise": Params(), "hold": Params(), "chatter": SLOW, "bounds": SLOW, "monitor": SLOW, "limits": Params(),
         "changes": Params(), "rig": RIG}  # of the other model


def single(x):
    return struct.unpack("f", struct.pack("f", x))[0]


def follows(name, params):
    """Whether this model gives what the other has given for its inputs."""
    model = Model(params)
    with open(FOLDER / f"feedforward_{name}.csv", encoding="utf-8") as file:
        for row in list(csv.reader(file))[1:]:
            given = [int(row[0]), float(row[1]), float(row[2]), *(single(float(x)) for x in row[3:7]), int(row[7])]
            found = zip(model.row(*given), map(float, row[8:]))
            if not all(abs(x - y) <= 1e-6 * max(1e-3, abs(y)) for x, y in found if y == y):
                return False
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    wrong = []
    if not parser.parse_args().check:
        for name, case in CASES.items():
            (FOLDER / f"feedforward_again_{name}.csv").write_text(text_of(case()[2]), encoding="utf-8")
        return 0
    for name, case in CASES.items():
        file = FOLDER / f"feedforward_again_{name}.csv"
        wrong += [file.name] if differ(file.read_text(encoding="utf-8"), text_of(case()[2])) else []
    wrong += [f"feedforward_{name}.csv" for name, params in FIRST.items() if not follows(name, params)]
    return f"not what the model gives: {', '.join(wrong)}" if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
