#!/usr/bin/env python3
"""The feed-forward of docs/feedforward.md in double precision, written from that page alone, and its golden vectors.

    tests/golden/feedforward.py            writes feedforward_*.csv beside it
    tests/golden/feedforward.py --check    compares them with what it would write

Given in a tick: `event` (1 restart, 2 entered from another method with the term `entry`, 3 changed params, 4 reset, 5 restore, 6 V_0 = `entry`,
7 changed to the other params, 8 b = `entry`), the guard's `share`, `r`, `y`, the controller's output `v`, `u` and `limited`. Expected: the step's
numbers by the page's names, and after the tick what is learned. `nan`: not computed in that tick.

Inputs are rounded so that single precision and Q31 hold them exactly, and a scenario is refused if one of its decisions is so close
that rounding could turn it: what is left to differ is arithmetic.
"""
import argparse
import dataclasses
import math
import pathlib
import random
import sys

FOLDER = pathlib.Path(__file__).resolve().parent
GIVEN = ("event", "entry", "share", "r", "y", "v", "u", "limited")
MODES = ("restart", "enter", "start", "moving", "hold")
RESTART, ENTER, START, MOVING, HOLD = range(5)
KEEP, REVERSAL, CONTINUE, TAKE_OVER = range(4)
NOTHING, DO_RESTART, DO_ENTER, DO_CHANGE, DO_RESET, DO_RESTORE, DO_CORRUPT = range(7)  # events before a tick
STAGES = 10  # N, of learning
BAD_IN_HOLD = (1000, 1001, 1002, 2200, 4500)  # ticks of the case `hold`
TIE = 5e-8  # of input_max: closer decisions than that are no vector


def clamp(x, low, high):
    return max(low, min(high, x))


def sign(x):
    return (x > 0) - (x < 0)


@dataclasses.dataclass(frozen=True)
class Rig:
    """What the params are made of; the defaults are the paper's."""

    h: float = 1e-3
    input_max: float = 2.0
    positive: tuple = (0.007, 0.3)  # offset, slope; or a table [(F, L+, L-), ...]
    negative: tuple = (0.007, 0.3)
    table: tuple = ()
    gravity: float = 0.0
    stiffness: float = 3.84
    damping: float = 0.0288
    inertia: float = 1.2e-4
    actuator_pole: float = 200.0
    sensor_pole: float = 55.0
    reversal: float = 0.0
    presliding: float = 0.0
    jump_time: float = 0.0
    lead: float = 0.7
    trust: float = 0.5
    forgetting: float = 0.0
    still_time: float = 0.2

    def breakaway(self, force):
        """L+ and L- of the model."""
        F = abs(force)
        if not self.table:
            return tuple(offset + slope * F for offset, slope in (self.positive, self.negative))
        if F <= self.table[0][0]:
            return self.table[0][1:]
        for left, right in zip(self.table, self.table[1:]):
            if F <= right[0]:
                part = (F - left[0]) / (right[0] - left[0])
                return tuple(a + part * (b - a) for a, b in zip(left[1:], right[1:]))
        return self.table[-1][1:]

    def L(self, force):
        return 0.5 * sum(self.breakaway(force))

    def D(self, force):
        positive, negative = self.breakaway(force)
        return 0.5 * (positive - negative) - self.gravity


class Feedforward:
    """One loop's feed-forward. A tick: `error`, then `sum` with the controller's output, then `after` with u."""

    def __init__(self, rig):
        h = rig.h
        self.rig = rig
        self.B = rig.L(rig.input_max / 4)  # their usual force F_u
        self.tau = 1 / rig.actuator_pole + rig.damping / rig.stiffness
        self.w = rig.reversal or self.B / 314
        d4 = rig.presliding or self.B / 11
        self.d = [self.w / 2, d4 * (3 / 8) ** 3, d4 * (3 / 8) ** 2, d4 * 3 / 8, d4]
        self.T_j = rig.jump_time or 2.1 * self.tau
        self.Q = rig.forgetting or 0.0157 / self.B
        self.T_n = max(0.25, 100 * h)
        self.T_r = max(0.8 * self.tau, 2 * h)
        self.T_y = max(0.8 * self.tau, 5 * h)
        self.E_pa = 1 - math.exp(-rig.actuator_pole * h)
        self.E_ps = 1 - math.exp(-rig.sensor_pole * h)
        self.w_y = self.w / 5
        self.s_0 = self.B / 5.23
        self.closest = math.inf  # decision so far
        self.forgotten = 0
        self.reset()

    # What is not written as a step.

    def low_pass(self, x, value, T):
        return x + self.rig.h / (T + self.rig.h) * (value - x)

    def ticks(self, T):
        return max(1, math.floor(T / self.rig.h + 0.5))

    def exceeds(self, x, limit, parts=1.0):
        """x > limit, and how near it was: `parts` times more where both are small, so that they are exact to more digits,
        less where they are exact to fewer."""
        self.closest = min(self.closest, abs(x - limit) / self.rig.input_max * parts)
        return x > limit

    def reset(self):
        self.lam, self.n_b, self.unsealed = 0.0, 0, False
        self.forward_again()
        self.V, self.W = [1.0, 0, 0, 0, 0], [1.0, 0, 0, 0, 0]
        self.c, self.l = [0.0, 0.0, 0.0], 0.0
        self.M = [[float(i == j) for j in range(4)] for i in range(4)]
        self.P = [1.0] * 5  # P[0] is not used
        self.doubt = 1.0
        self.y_last, self.e_last, self.term, self.f = 0.0, 0.0, 0.0, 0.0
        self.mode = RESTART

    def restart(self):
        self.mode = RESTART

    def enter(self, term):
        self.mode, self.term = ENTER, term

    def restore(self):
        self.n_b = 0
        self.forward_again()

    def forward_again(self):
        self.xi, self.harm, self.n_f, self.n_l = 0.0, False, 0, 0

    def change_params(self):
        if self.mode > ENTER:
            self.rule_next = TAKE_OVER

    def start(self, r, y):
        at = y if self.mode == RESTART else r
        self.rule_next = KEEP if self.mode == RESTART else TAKE_OVER
        load = self.c[0] + self.c[1] * abs(y) + self.c[2] * y if self.mode == RESTART else 0.0
        if self.mode == RESTART:
            self.term = 0.0
        self.r1 = self.r2 = r
        self.n_r = 0.0
        self.rs = self.rn = self.rp = self.m1 = self.m2 = self.a = at
        self.rate, self.s, self.sigma, self.x = 0.0, 0, 0.0, [0.0] * 5
        self.b, self.f, self.u, self.limited, self.e_last = load, 0.0, y, 0, 0.0
        self.y1 = self.y2 = self.u1 = self.u2 = self.yf = self.m = y
        self.n_y, self.zf, self.z, self.X = 0.0, 0.0, 0.0, [0.0] * 5
        self.m_s, self.z_s, self.side_s, self.hunts, self.since_s = y, 0.0, 0, False, 0
        self.q_still, self.side, self.since, self.quick = 0, 0, 0, 0
        self.e_mean, self.n_e, self.n_a, self.rests = 0.0, 0.0, 1.0, False
        self.vf = self.vp = self.t_v = self.need = self.v_mean = 0.0
        self.stage, self.delta, self.l = 0, 0.0, 0.0
        self.mode = START

    # The steps.

    def friction(self, sigma):
        G = self.share * (1 - (1 - self.rig.trust) * self.doubt) * self.rig.L(self.rs)
        return G * clamp(self.W[0] * sigma + sum(self.W[j] * self.x[j] / self.d[j] for j in range(1, 5)), -4.0, 4.0), G

    def rise(self, of_sigma):
        return self.friction(0.0)[1] * self.W[0] * of_sigma

    def error(self, r, y, share):
        rig, h = self.rig, self.rig.h
        self.share, self.waits = share, False
        # 1
        r_good, self.y_good = abs(r) <= rig.input_max, abs(y) <= rig.input_max
        if self.mode in (RESTART, ENTER):
            if not (r_good and self.y_good):
                self.waits = True
                return 0.0
            self.start(r, y)
        r = r if r_good else self.r1
        y = y if self.y_good else self.y1
        self.y = y
        rule, self.rule_next = self.rule_next, KEEP
        # 2
        d2 = min(abs(r - 2 * self.r1 + self.r2), 4 * self.n_r + 0.002 * self.w)
        self.n_r += min(1, h / self.T_n) * (d2 - self.n_r)
        self.r2, self.r1 = self.r1, r
        w_n = 4 * self.n_r
        # 3
        dr = r - self.rs
        if dr * self.limited > 0:
            dr = 0.0
        step = self.exceeds(abs(dr), self.B / 0.0785 * h)
        e0 = self.m2 - y
        self.rs += dr
        self.rate = self.low_pass(self.rate, 0.0 if step else dr / h, self.T_r)
        # 4
        rn = clamp(self.rn, self.rs - w_n / 2, self.rs + w_n / 2)
        for j in range(1, 5):
            self.x[j] = clamp(self.x[j] + rn - self.rn, -self.d[j], self.d[j])
        self.rn = rn
        half = (self.w + w_n) / 2
        rp, s = clamp(self.rp, self.rs - half, self.rs + half), self.s
        if rp != self.rp:
            s = sign(rp - self.rp)
        if sign(self.rs - self.rp) != self.s:
            self.exceeds(abs(self.rs - self.rp), half)  # a reversal's tick
        flips = s != self.s
        first = flips and self.s == 0
        self.rp, self.s = rp, s
        still = self.ticks(rig.still_time)
        if self.exceeds(abs(self.rs - self.a), half, 10.0):  # of exact numbers
            if self.mode == HOLD and step:
                self.e_mean = self.rs - self.a
            else:
                self.q_still = 0
            self.rests, self.a = False, self.rs
        elif self.q_still < still:
            self.q_still += 1
        self.fed_back = self.harm and self.n_f > 0
        of_itself = rig.still_time > 0 and self.q_still >= still
        stands = self.fed_back or of_itself
        if flips and not stands:
            self.turn()
        # 5
        ahead = self.tau * self.rate * self.w / (self.w + w_n)
        self.lin = self.rs + ahead + rig.D(self.rs) + self.c[0] + self.c[1] * abs(self.rs) + self.c[2] * self.rs
        self.m1 = self.low_pass(self.m1, self.rs + ahead, self.tau)
        self.m2 += self.E_ps * (self.m1 - self.m2)
        e = e0 if self.y_good else 0.0
        if self.y_good:
            self.e_mean = self.low_pass(self.e_mean, e0, 0.3)
        # 6
        f_before, self.lead = self.f, 0.0
        self.before, self.flips, self.first = self.f - self.b, flips, first
        if self.mode == START or (self.mode == MOVING and not stands):
            if flips and (first or (step and self.exceeds(self.doubt, 0.5))):
                self.b += self.rise(s - self.sigma)
                self.sigma = float(s)
            else:
                most = min(2, 2 * h / self.T_j)
                sigma = self.sigma + clamp(s - self.sigma, -most, most)
                self.lead = rig.lead / (rig.actuator_pole * h) * self.rise(sigma - self.sigma)
                self.sigma = sigma
                if flips:
                    rule = REVERSAL if rule == KEEP else rule
                    self.n_b = min(self.n_b + 1, 4) if self.V[0] <= 0.2 or self.V[0] >= 3 or self.n_b == 4 else 0
            self.f = self.friction(self.sigma)[0]
            if s != 0:
                self.mode = MOVING
        elif stands:
            self.hold(f_before)
            if self.y_good:
                e = self.deadband(e, y, of_itself)
            if self.rests:
                e, rule = 0.0, CONTINUE
        else:
            # 8
            self.mode = MOVING
            self.sigma = float(s)
            f0, G = self.friction(0.0)
            if self.side != s and self.W[0] * G > 0:
                self.sigma = clamp((self.u - self.lin - f0) / (self.W[0] * G), -1.0, 1.0)
            self.f = self.friction(self.sigma)[0]
            rule = CONTINUE
        self.rule, self.e = rule, e
        return e

    def turn(self):
        one = clamp((self.M[0][0] - 0.15) / 0.25, 0.0, 1.0)
        lack = -one * self.l * self.X[0] / self.d[0]
        if lack > 0:
            V = clamp(self.V[0] - 1.15 * lack, 0.02, 3.0)
            self.W[0] += V - self.V[0]
            self.V[0] = V
            self.c = [(1 - one) * c for c in self.c]
            self.l *= 1 - one

    def forget(self):
        term, count = self.term, self.forgotten + 1
        self.reset()
        self.mode, self.term, self.forgotten = ENTER, term, count

    def hold(self, f_before):
        """7, but for the deadband."""
        B_h, close = (1 - self.lam) * self.V[0] * self.share * self.rig.L(self.rs), self.ticks(0.2)
        net = self.u - self.m - (self.rig.D(self.rs) + self.load())
        self.f, self.sigma = 0.94 * clamp(net, -B_h, B_h), 0.0
        if self.mode == MOVING:
            self.b += self.f - f_before
            self.side, self.since, self.quick, self.rests, self.delta = self.s, 0, 0, False, 0.0
            self.mode = HOLD
        if sign(net) != self.side and self.exceeds(abs(net), B_h):
            self.quick = min(self.quick + 1, 4) if self.since < close else 0
            if self.quick == 4:
                self.lam += 0.1 * (1 - self.lam)
            self.side, self.since = sign(net), 0
        else:
            self.since = min(self.since + 1, close)

    def deadband(self, e, y, of_itself):
        changed = y != self.y1
        self.n_a = self.low_pass(self.n_a, float(changed), 0.3)
        if changed:
            self.n_e = self.low_pass(self.n_e, abs(y - 2 * self.y1 + self.y2), 0.3)
        d_a = 0.07 * self.n_y
        d = d_a + 0.6 * self.n_e * (1 - self.n_a)
        # Q31 cuts a low pass of many ticks, hence the part.
        self.rests = of_itself and self.exceeds(2.5 * d_a if self.rests else d_a, abs(self.e_mean), self.rig.h / 0.016)
        return e - clamp(self.e_mean, -d, d)

    def sum(self, v):
        """9, until u."""
        if self.waits:
            return self.term if self.mode == ENTER else 0.0
        self.v = v
        if self.flips:
            self.judge(v, v + self.before, self.first)
        if self.rule == REVERSAL:
            quiet = v + clamp(self.v_mean - v, -2 * self.n_y, 2 * self.n_y)
            self.b = quiet + self.s * clamp(self.s * (self.b - quiet) - self.w, 0, abs(self.load()) / 4)
        elif self.rule == CONTINUE:
            self.b = v + self.lin + self.f - self.u
        elif self.rule == TAKE_OVER:
            self.b = self.lin + self.f - self.term
        self.b = clamp(self.b, -4 * self.rig.input_max, 4 * self.rig.input_max)
        self.term = self.lin + self.f - self.b
        self.v_mean = self.low_pass(self.v_mean, v, self.T_y)
        return self.term + self.lead

    def judge(self, v, need, first):
        if first or self.fed_back:
            self.vf = self.vp = v
        if self.fed_back:
            self.n_f -= 1
            if self.n_f == 0:
                self.xi = 0.51
        elif not first:
            self.xi += (min(4, self.t_v / (abs(need - self.need) + 0.1 * self.B)) - self.xi) / 8
            self.n_l = max(self.n_l - 1, 0)
            if self.exceeds(self.xi, 0.6):
                self.harm = True
                self.n_f = self.n_l = clamp(8 * self.n_l, 4, 128)
        self.need, self.t_v = need, 0.0

    def monitor(self):
        pause = STAGES * self.rig.h
        if self.mode == MOVING:
            self.vf += pause / (0.030 + pause) * (self.v - self.vf)
        half = (0.02 * self.B + 4 * self.n_y) / 2
        vp = clamp(self.vp, self.vf - half, self.vf + half)
        self.t_v = min(self.t_v + abs(vp - self.vp), 4 * self.B)
        self.vp = vp

    def after(self, u, limited):
        if self.waits:
            return
        rig, h = self.rig, self.rig.h
        self.limited, self.e_last = limited, self.e
        if not (self.mode == HOLD and self.rests):
            self.u = u
        self.seen = {"lin": self.lin, "f": self.f, "lead": self.lead, "b": self.b, "sigma": self.sigma}
        # 10
        self.u1 += self.E_pa * (u - self.u1)
        self.u2 += self.E_ps * (self.u1 - self.u2)
        d2 = min(abs(self.y - 2 * self.y1 + self.y2), 4 * self.n_y + 0.002 * self.w)
        self.n_y += min(1, h / self.T_n) * (d2 - self.n_y)
        self.y2, self.y1 = self.y1, self.y
        yf = self.low_pass(self.yf, self.y, self.T_y)
        self.zf = self.low_pass(self.zf, self.u2 - self.y, self.T_y)
        rate_y = (yf - self.yf) / h
        self.yf = yf
        z = self.zf - rig.damping / rig.stiffness * rate_y
        self.z = z
        half = (self.w_y + 0.4 * self.n_y) / 2
        self.m = clamp(self.m, yf - half, yf + half)
        self.seen["z"] = z
        # 11
        if self.flips:
            return
        stage, self.stage = self.stage, (self.stage + 1) % STAGES
        if stage == 0:
            self.sample(limited)
        elif stage == 9:
            self.monitor()
            if self.unsealed:
                self.forget()
        elif self.delta > 0:
            (self.regress, self.project, self.weigh, self.learn_weights, self.learn_load, self.use, self.learn_covariance,
             self.learn_variances)[stage - 1]()

    def sample(self, limited):
        h = self.rig.h
        dm = self.m - self.m_s
        for j, d in enumerate(self.d):
            if j == 4 and sign(self.X[j] + dm) != self.side_s:
                self.exceeds(abs(self.X[j] + dm), d)
            self.X[j] = clamp(self.X[j] + dm, -d, d)
        side = sign(self.X[4]) if abs(self.X[4]) == self.d[4] else self.side_s
        close = self.ticks(0.2) // 2
        if side != self.side_s:
            self.hunts, self.since_s = self.since_s < close, 0
        elif self.since_s < close:
            self.since_s += STAGES
        self.side_s = side
        self.jump = self.z - self.z_s
        self.m_s, self.z_s, self.yf_s = self.m, self.z, self.yf
        learns = self.mode == MOVING and limited == 0 and self.y_good and not (self.hunts and self.since_s < close)
        learns = learns and not self.exceeds(abs(dm), self.B / 0.314 * STAGES * h, 10.0)
        self.delta = min(abs(dm), self.B / 157) if learns else 0.0

    def regress(self):
        part = [X / d for X, d in zip(self.X, self.d)]
        Psi = [part[0]] + [part[j] - part[j - 1] for j in range(1, 5)]
        z, yf, L = self.z_s, self.yf_s, self.rig.L(self.yf_s)
        self.k = (0.4 * Psi[0], min(2, self.s_0 / L), min(2, 0.1 * abs(yf) / L), clamp(0.1 * yf / L, -2, 2))
        self.kappa = [0.55 * psi for psi in Psi]
        self.rho = self.B / 78.5 * (1 + min(8, 0.030 * abs(self.jump) / (STAGES * self.rig.h * L)) ** 2)
        load = self.c[0] + self.c[1] * abs(yf) + self.c[2] * yf
        self.l = load / L
        self.eps = (z - self.rig.D(yf) - load) / L - sum(V * psi for V, psi in zip(self.V, Psi))

    def project(self):
        self.q = [sum(a * k for a, k in zip(row, self.k)) for row in self.M]

    def weigh(self):
        self.qj = [P * kappa for P, kappa in zip(self.P, self.kappa)]
        S = sum(q * k for q, k in zip(self.q, self.k)) + sum(q * kappa for q, kappa in zip(self.qj[1:], self.kappa[1:]))
        self.gain = self.delta / (self.rho + self.delta * S)
        if self.eps != 0:
            self.gain *= min(1, 4 * (S + 0.01) / self.eps**2)

    def learn_weights(self):
        step = self.gain * self.eps
        self.V[0] = clamp(self.V[0] + 0.4 * step * self.q[0], 0.02, 3.0)
        for j in range(1, 5):
            self.V[j] = clamp(self.V[j] + 0.55 * step * self.qj[j], -2.0, 2.0)
        self.lam *= 1 - min(1, self.delta / (self.B / 1.57))

    def load(self):
        return self.c[0] + self.c[1] * abs(self.rs) + self.c[2] * self.rs

    def learn_load(self):
        before, step = self.load(), self.gain * self.eps
        self.c[0] = clamp(self.c[0] + self.s_0 * step * self.q[1], -self.B, self.B)
        self.c[1] = clamp(self.c[1] + 0.1 * step * self.q[2], -0.5, 0.5)
        self.c[2] = clamp(self.c[2] + 0.1 * step * self.q[3], -0.5, 0.5)
        self.b += self.load() - before
        self.A_n = 0.15 + 2 * self.n_y / (self.B / 7.85)

    def use(self):
        A = sum(V**2 for V in self.V[1:])
        used = max(0, 1 - (self.A_n / A) ** 2) if A > 0 else 0
        S = [0.0] + [used * V**3 / (V**2 + 0.2**2) for V in self.V[1:]]
        unused = min(self.k[1] * self.n_y / (3 * self.B / 7.85), self.V[0] / 4)
        self.W = [self.V[0] - S[1] - unused] + [S[j] - S[j + 1] for j in (1, 2, 3)] + [S[4]]
        self.doubt *= 1 - min(1, self.delta / (self.B / 7.85))
        before, self.f = self.f, self.friction(self.sigma)[0]
        self.b += self.f - before

    def learn_covariance(self, last=False):
        o = min(1, self.Q * self.delta)
        for i in range(4):
            for j in range(4):
                if (min(i, j) > 1) == last:
                    self.M[i][j] -= self.gain * self.q[i] * self.q[j]
                    self.M[i][j] += o * (float(i == j) - self.M[i][j])

    def learn_variances(self):
        self.learn_covariance(last=True)
        o = min(1, self.Q * self.delta)
        for j in range(1, 5):
            self.P[j] -= self.gain * self.qj[j] ** 2
            self.P[j] += o * (1 - self.P[j])


# --- closed loops that give the inputs ----------------------------------------------------------------------------------------

PAPER_CONTROLLER = (  # b0, b1, b2, a1, a2 in z - 1, from lib/include/tribo/paper_controller.h
    (1.81855643, 0.533418715, 0.0953765884, 0.374956906, 0.0953765884),
    (0.758975148, 0.178621888, 0.00738663969, 0.290768296, 5.81531992e-07),
)


class Controller:
    """K(z) with the input that would have given u (Hanus)."""

    def __init__(self, sections):
        self.sections = sections
        self.state = [[0.0, 0.0] for _ in sections]

    def run(self, e, advance):
        for (b0, b1, b2, a1, a2), state in zip(self.sections, self.state):
            w1, w2 = state
            out = b0 * e + (b1 - b0 * a1) * w1 + (b2 - b0 * a2) * w2
            if advance:
                state[0], state[1] = w1 + e - a1 * w1 - a2 * w2, w2 + w1
            e = out
        return e

    def step(self, e, added, low, high):
        v = self.run(e, False)
        asked = v + added
        u = clamp(asked, low, high)
        through = math.prod(section[0] for section in self.sections)
        self.run(e + (u - asked) / through, True)
        return v, u, sign(asked - u) if abs(asked - u) > 1e-9 else 0


class Plant:
    """Arm behind an actuator's pole, with three stops of widths in N as friction (a narrow one is Coulomb's), and a sensor's pole."""

    SHARE = (0.6, 0.25, 0.15)

    def __init__(self, rig, scale=(1.0, 1.0), widths=(2e-4, 3e-3, 1.2e-2), load=0.0, steps=2):
        self.rig, self.scale, self.widths, self.load, self.steps = rig, scale, widths, load, steps
        self.actuator = self.F = self.rate = self.y = 0.0
        self.z = [0.0] * 3

    def friction(self, rate, dt, move=False):
        positive, negative = self.rig.breakaway(self.F)
        moved = [clamp(z + rate * dt, -w, w) for z, w in zip(self.z, self.widths)]
        if move:
            self.z = moved
        total = sum(share * z / w for share, z, w in zip(self.SHARE, moved, self.widths))
        return total * (positive * self.scale[0] if total > 0 else negative * self.scale[1])

    def step(self, u):
        rig, dt = self.rig, self.rig.h / self.steps
        inertia, damping = rig.inertia / rig.stiffness, rig.damping / rig.stiffness
        for _ in range(self.steps):
            self.actuator += (1 - math.exp(-rig.actuator_pole * dt)) * (u - self.actuator)
            push = inertia / dt * self.rate + self.actuator + rig.gravity + self.load - self.F
            mass = inertia / dt + damping + dt
            low, high = -rig.input_max / rig.h, rig.input_max / rig.h
            for _ in range(44):  # the rate of a monotone balance, by bisection
                middle = 0.5 * (low + high)
                if mass * middle + self.friction(middle, dt) > push:
                    high = middle
                else:
                    low = middle
            self.rate = 0.5 * (low + high)
            self.friction(self.rate, dt, move=True)
            self.F += dt * self.rate
            self.y += (1 - math.exp(-rig.sensor_pole * dt)) * (self.F - self.y)


EXPECTED = ("e", "mode", "lin", "f", "lead", "b", "term", "sigma", "z", "V0", "V1", "V2", "V3", "V4", "c0", "c1", "c2", "doubt", "P4",
            "lambda", "turns", "xi", "back", "forgotten")


def happen(model, event, entry):
    if event == DO_RESTART:
        model.restart()
    elif event == DO_ENTER:
        model.enter(entry)
    elif event == DO_CHANGE:
        model.change_params()
    elif event == DO_RESET:
        model.reset()
    elif event == DO_RESTORE:
        model.restore()
    elif event == DO_CORRUPT:
        model.V[0], model.unsealed = entry, True


def play(rig, seconds, reference, *, seed, plant=None, noise=0.0, noise_r=0.0, u_max=None, share=None, events=None, upset=None, given=None, grid=2.0**-22,
         controller=PAPER_CONTROLLER):
    """The rows of a run. `events` maps a tick to (event, entry); `upset` changes (r, y) of a tick; `given` gives (v, u), in place of
    controller and plant: y is r."""
    rng = random.Random(seed)
    model = Feedforward(rig)
    plant = plant or Plant(rig)
    control = Controller(controller)
    u_max = u_max or rig.input_max
    quantum = grid

    def exact(x):
        return math.floor(x / quantum + 0.5) * quantum if math.isfinite(x) else x

    rows = []
    for k in range(round(seconds / rig.h)):
        event, entry = (events or {}).get(k, (NOTHING, 0.0))
        entry = exact(entry)
        happen(model, event, entry)
        r = exact(reference(k * rig.h) + rng.gauss(0, 1) * noise_r)
        y = r if given else exact(plant.y + rng.gauss(0, 1) * noise)
        if upset:
            r, y = upset(k, r, y)
        part = share(k * rig.h) if share else 1.0
        e = model.error(r, y, part)
        if given:
            v, u = map(exact, given(k * rig.h, r))
            added, limited = model.sum(v), 0
        else:
            v = exact(control.run(e, False))
            added = model.sum(v)
            _, u, limited = control.step(e, added, -u_max, u_max)
            u = exact(u)
            plant.step(u)
        model.after(u, limited)
        seen = {} if model.waits else model.seen
        seen = {"e": e, "mode": model.mode, "term": added, "doubt": model.doubt, "P4": model.P[4], "lambda": model.lam, "turns": model.n_b,
                "xi": model.xi, "back": model.n_f, "forgotten": model.forgotten,
                **{f"c{j}": model.c[j] for j in range(3)}, **{f"V{j}": model.V[j] for j in range(5)}, **seen}
        rows.append([event, entry, part, r, y, v, u, limited] + [seen.get(name, math.nan) for name in EXPECTED])  # NaN: not computed
    if model.closest < TIE:
        raise SystemExit(f"a decision is as close as {model.closest:.1e}")
    return rows


def triangle(t, period, low, high):
    phase = math.fmod(t, period) / period
    return low + (high - low) * (2 * phase if phase < 0.5 else 2 - 2 * phase)


def steps_and_stands(t):
    """A ramp, a stand in which r steps while u rests and later moves by less than a reversal, the ramp back, a stand, a staircase
    down, a large step, a ramp and a step back."""
    level = 0.45 if t < 1.5 else 0.4469
    if t < 4.7:
        return level + 0.0303 * (clamp(t - 0.1, 0, 0.3) - clamp(t - 3, 0, 0.3)) / 0.3 + (2e-4 if 2.4 < t < 2.9 else 0)
    if t < 5.3:
        return level - 0.0137 * math.floor((t - 4.4) / 0.3)
    return 0.62 - 0.0937 * max(0, t - 5.57) if t < 5.65 else 0.5


def coarse_later(k, r, y):
    """A y that always changes, then one of steps of 4 mN; bad in a rest of the one, and in holds without."""
    if k in BAD_IN_HOLD:
        return r, math.nan
    return r, math.floor(y * 256 + 0.5) / 256 if k >= 3000 else y


def quick_triangle(t):
    return triangle(t, 1.15, 0.38, 0.62)


class WrongFriction:
    """v, and u that belongs to frictions far beyond the bounds of what is learned."""

    def __init__(self, rig):
        self.rig, self.x, self.last = rig, 0.0, quick_triangle(0)

    def __call__(self, t, r):
        self.x = clamp(self.x + r - self.last, -14e-3, 14e-3)
        self.last = r
        slide, build = sign(self.x), self.x / 14e-3
        L = self.rig.L(r)
        v = 0.1 * math.sin(2.1 * t)
        if t < 5.6:
            return v, r + 3.6 * L * slide
        if t < 9:
            return v, r - 0.3 * L * slide
        return v, r + 0.1 + 0.6 * r + L * (slide - 2.5 * build)


def chatter(t, r):
    """A hold in which u crosses from side to side."""
    return 0.1, r + (0.4 if math.fmod(t, 0.17) < 0.085 else -0.4) if 0.7 < t < 2.1 else r + 0.1


def opposed(t, r):
    """A controller that works back and forth between the reversals, as against friction fed forward the wrong way."""
    return (0.3 if t < 1.3 else 0.002) * math.sin(65.3 * t), r + 0.02


def scenarios():
    """Name, rig, rows."""
    paper = Rig()
    slow = Rig(h=4e-3)
    yield "tracking", paper, play(paper, 5, lambda t: triangle(t, 1.9, 0.38, 0.61), seed=10, plant=Plant(paper, (0.8, 1.2)))

    yield "noise", paper, play(paper, 5, lambda t: 0.09 + 0.21 * math.sin(2.9 * t), seed=29, noise=5e-4, noise_r=2e-4,
                               plant=Plant(paper, (1.3, 1.1), load=0.02))

    yield "hold", paper, play(paper, 6, steps_and_stands, seed=8, noise=4e-3, upset=coarse_later,
                              plant=Plant(paper, (0.6, 0.6), widths=(2e-4, 2e-4, 2e-4)))

    yield "chatter", slow, play(slow, 4, lambda t: 0.4 + 0.0517 * clamp(t - 0.2, 0, 0.3) + 0.0713 * clamp(t - 2.5, 0, 1), seed=70, given=chatter)

    yield "bounds", slow, play(slow, 12, quick_triangle, seed=80, given=WrongFriction(slow), events={1400: (DO_RESET, 0)})

    yield "monitor", slow, play(slow, 5.6, lambda t: triangle(t, 0.26, 0.48, 0.52), seed=90, given=opposed,
                                events={620: (DO_ENTER, 0.05), 870: (DO_RESTORE, 0)})

    def upset(k, r, y):
        if k in (0, 1, 1500, 1501, 1502, 3100):
            return r, math.nan
        if k in (2000, 3100, 3600):
            return 5.0, y
        return r, y

    yield "limits", paper, play(paper, 4, lambda t: 0.35 + 0.3 * math.sin(2.9091 * t) + (0.2 if 2.3 < t < 2.9 else 0), seed=43, u_max=0.64, noise=1e-5, noise_r=1e-5, upset=upset)

    events = {400: (DO_ENTER, 0.07), 1300: (DO_RESTART, 0), 2150: (DO_CHANGE, 0), 2400: (DO_ENTER, -0.11), 3300: (DO_RESET, 0), 4853: (DO_CORRUPT, 1.25)}
    yield "changes", paper, play(paper, 5, lambda t: 0.5 + 0.1103 * math.sin(4.9 * t) * (t < 4.5), seed=58, noise=1e-5, noise_r=1e-5, events=events,
                                 share=lambda t: 1.0 if t < 1.6 else 0.75 if t < 2.8 else 0.25)

    rig = Rig(h=5e-4, input_max=200.0, table=((0.0, 3.0, 2.0), (40.0, 8.0, 9.0), (80.0, 14.0, 18.0)), gravity=1.5, stiffness=2e6,
              damping=2800.0, inertia=2.0, actuator_pole=700.0, sensor_pole=300.0, reversal=0.06, presliding=2.0, jump_time=0.009, lead=0.5,
              trust=0.7, forgetting=0.002, still_time=0.15)
    controller = ((9.0, 1.2, 0.0, 0.6, 0.0), (1.0, 0.0, 0.0, 1.0, 0.0))

    def reference(t):
        return triangle(min(t, 1.5), 0.93, 31.0, 72.0) if t < 1.9 else 10.0 * math.sin(11.0 * t)

    yield "rig", rig, play(rig, 3, reference, seed=64, noise=0.02, grid=2.0**-15, controller=controller,
                           plant=Plant(rig, (0.9, 1.1), widths=(0.02, 0.4, 1.8)))


def text_of(rows):
    lines = [",".join(GIVEN + EXPECTED)]
    lines += [",".join(f"{x:.9g}" if i < len(GIVEN) else f"{x:.7g}" for i, x in enumerate(row)) for row in rows]
    return "\n".join(lines) + "\n"


def same(a, b):
    """The same numbers but for the last digits of another machine's exp and sin."""
    a, b = a.split(), b.split()
    pairs = [(float(x), float(y)) for row, other in zip(a[1:], b[1:]) for x, y in zip(row.split(","), other.split(","))]
    return a[0] == b[0] and len(a) == len(b) and all(abs(x - y) <= 1e-7 * (1 + abs(x)) or (x != x and y != y) for x, y in pairs)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    wrong = []
    for name, _, rows in scenarios():
        file = FOLDER / f"feedforward_{name}.csv"
        if check:
            wrong += [] if same(file.read_text(), text_of(rows)) else [file.name]
        else:
            file.write_text(text_of(rows))
    return f"not what the model gives: {', '.join(wrong)}" if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
