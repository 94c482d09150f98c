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
EXPECTED = ("e", "mode", "lin", "f", "lead", "b", "term", "sigma", "z", "V0", "V1", "V2", "c0", "c2", "doubt", "P00", "P43", "turned", "xi", "left")
RESTART, ENTER, START, MOVING, HOLD = range(5)
KEEP, REVERSAL, CONTINUE, TAKE_OVER = range(4)
NOTHING, DO_RESTART, DO_ENTER, DO_CHANGE, DO_RESET = range(5)  # events before a tick
TIE = 5e-8  # of input_max: closer decisions than that are no vector
N = 10


def clamp(x, low, high):
    return max(low, min(high, x))


def sign(x):
    return (x > 0) - (x < 0)


@dataclasses.dataclass(frozen=True)
class Rig:
    """What the params are made of; the defaults are the paper's."""

    h: float = 1e-3
    input_max: float = 2.0
    usual: float = 0.5  # a quarter of the largest command
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


class Learner:
    """Steps 9 to 11."""

    def __init__(self, loop):
        self.loop = loop
        self.a = [0.0] * 5
        self.P = [[float(i == j) for j in range(5)] for i in range(5)]
        self.doubt, self.xi, self.harms, self.n_f, self.n_l = 1.0, 0.0, False, 0, 0
        self.start(0.0, 0.0)

    def start(self, m, z):
        self.X, self.m, self.z, self.l = [0.0] * 3, m, z, 0.0
        self.played = self.t_v = self.need = 0.0
        self.begun = False

    def V(self, j):
        return clamp(1 + 0.4 * self.a[0], 0.02, 3.0) if j == 0 else 0.55 * self.a[j]

    def c(self, F):
        return 0.3 * self.loop.B * self.a[3] + 0.1 * self.a[4] * F

    def turned(self):
        one = clamp(4 * self.P[0][0] - 0.6, 0.0, 1.0)
        lack = -one * self.l * self.X[0]
        return (clamp(self.V(0) - 1.15 * lack, 0.02, 3.0), 1 - one) if lack > 0 else (self.V(0), 1.0)

    def set_V0(self, V):
        self.a[0] = (clamp(V, 0.02, 3.0) - 1) / 0.4

    def step(self, s):
        B, unit = self.loop.B, self.loop.B / 314
        for _ in range(s["turns"]):
            V, kept = self.turned()
            self.set_V0(V)
            self.a[3], self.a[4], self.l = self.a[3] * kept, self.a[4] * kept, self.l * kept
        for _ in range(s["chatter"]):
            self.set_V0(0.9 * self.V(0))
        if s["starts"]:
            self.start(s["m"], s["z"])
        if s["flips"]:
            self.judge(s, B)
        # 9
        dm, dz = s["m"] - self.m, s["z"] - self.z
        self.X = [clamp(x + dm / d, -1.0, 1.0) for x, d in zip(self.X, (self.loop.w / 2, 0.375 * self.loop.d, self.loop.d))]
        self.m, self.z = s["m"], s["z"]
        delta = min(abs(dm), 2 * unit) if s["allowed"] else 0.0
        if delta > 0:
            self.filter(s, delta, dz, unit)
        # 11, between reversals
        if s["moves"]:
            half = 0.01 * B + 2 * s["n_y"]
            played = clamp(self.played, s["v"] - half, s["v"] + half)
            self.t_v = min(4 * B, self.t_v + abs(played - self.played))
            self.played = played
        A = self.V(1) ** 2 + self.V(2) ** 2
        least = self.V(0) ** 2 * (0.15 + s["n_y"] / (20 * unit))
        R = [0.0] + [self.V(j) * (1 - (min(1.0, least / A) if A > 0 else 1.0) ** 2) for j in (1, 2)]
        V, kept = self.turned()
        return {"V": self.V(0), "U": [self.V(0) - R[1], R[1] - R[2], R[2]], "c": (self.c(0.0), 0.1 * self.a[4]), "turned": V, "kept": kept,
                "G": 1 - (1 - self.loop.rig.trust) * self.doubt, "back": self.harms and self.n_f > 0}

    def judge(self, s, B):
        if self.n_f > 0 or not self.begun:
            self.played = s["v"]
            self.xi = 0.51 if self.n_f == 1 else self.xi
            self.n_f = max(self.n_f - 1, 0)
        else:
            self.xi += (min(4.0, self.t_v / (abs(s["need"] - self.need) + B / 10)) - self.xi) / 8
            self.n_l = max(self.n_l - 1, 0)
            self.loop.near(self.xi, 0.6)
            if self.xi > 0.6:
                self.n_f = self.n_l = int(clamp(8 * self.n_l, 4, 128))
                self.harms = True
        self.begun, self.need, self.t_v = True, s["need"], 0.0

    def filter(self, s, delta, dz, unit):
        """10."""
        rig, B, yf = self.loop.rig, self.loop.B, s["yf"]
        L, X = rig.L(yf), self.X
        k = [0.4 * X[0], 0.55 * (X[1] - X[0]), 0.55 * (X[2] - X[1]), min(0.3 * B / L, 2.0), clamp(0.1 * yf / L, -2.0, 2.0)]
        eps = (s["z"] - rig.D(yf)) / L - X[0] - sum(x * a for x, a in zip(k, self.a))
        self.l = self.c(yf) / L
        q = [sum(self.P[i][j] * k[j] for j in range(5)) for i in range(5)]
        s2 = sum(x * y for x, y in zip(k, q))
        rho = 4 * unit * (1 + clamp(1.5 * self.loop.T_j * dz / (N * rig.h) / L, -8.0, 8.0) ** 2)
        gain = delta / (rho + delta * s2) * min(1.0, 4 * (s2 + 0.01) / eps**2 if eps else 1.0)
        self.a = [clamp(a + gain * eps * x, -8.0, 8.0) for a, x in zip(self.a, q)]
        back = min(1.0, self.loop.Q * delta)
        for i in range(5):
            for j in range(5):
                p = self.P[i][j] - gain * q[i] * q[j]
                self.P[i][j] = clamp(p + back * ((i == j) - p), -1.0, 1.0)
        self.doubt *= 1 - min(1.0, delta / (40 * unit))


class Feedforward:
    """Steps 1 to 8. A tick: `error`, then `sum` with the controller's output, then `after` with u."""

    def __init__(self, rig):
        self.rig, self.B = rig, rig.L(rig.usual)
        self.tau = 1 / rig.actuator_pole + rig.damping / rig.stiffness
        self.w = rig.reversal or self.B / 314
        self.d = rig.presliding or self.B / 11
        self.T_j = rig.jump_time or 2.1 * self.tau
        self.Q = rig.forgetting or 0.0157 / self.B
        self.T_n = max(0.3, 100 * rig.h)
        self.T_y = max(0.8 * self.tau, 5 * rig.h)
        self.E_a = 1 - math.exp(-rig.actuator_pole * rig.h)
        self.E_s = 1 - math.exp(-rig.sensor_pole * rig.h)
        self.closest = math.inf  # decision so far
        self.reset()

    def reset(self):
        self.mode, self.term = RESTART, 0.0
        self.learner = Learner(self)
        self.used = {"V": 1.0, "U": [1.0, 0.0, 0.0], "c": (0.0, 0.0), "turned": 1.0, "kept": 1.0, "G": self.rig.trust, "back": False}
        self.result = None
        self.counts, self.turned_since = {"turns": 0, "chatter": 0}, False

    def low_pass(self, x, value, T):
        return x + self.rig.h / (T + self.rig.h) * (value - x)

    def ticks(self, T):
        return max(1, math.floor(T / self.rig.h + 0.5))

    def near(self, x, limit, parts=1.0):
        self.closest = min(self.closest, abs(x - limit) / self.rig.input_max * parts)

    def exceeds(self, x, limit, parts=1.0):
        self.near(x, limit, parts)
        return x > limit

    def noise(self, n, x, x1, x2):
        return self.low_pass(n, min(abs(x - 2 * x1 + x2), 4 * n + self.w / 500), self.T_n)

    def c(self, F):
        return self.used["c"][0] + self.used["c"][1] * F

    def restart(self):
        self.mode = RESTART

    def enter(self, term):
        self.mode, self.term = ENTER, term

    def change_params(self):
        if self.mode > ENTER:
            self.rule = TAKE_OVER

    def start(self, r, y):
        enters = self.mode == ENTER
        at = r if enters else y
        self.rule = TAKE_OVER if enters else KEEP
        self.r1 = self.r2 = r
        self.y1 = self.y2 = y
        self.rs = self.rp = at
        self.n_r = self.n_y = self.rate = self.m1 = self.m2 = self.sigma = self.f = self.v_mean = self.e_mean = 0.0
        self.b = 0.0 if enters else self.c(at)
        self.phi, self.s, self.limited, self.still, self.since, self.side, self.quick, self.rests = [0.0, 0.0], 0, 0, 0, 0, 0, 0, False
        self.u1 = self.u2 = self.yf = self.m = y
        self.zf = self.z = 0.0
        self.phase, self.counts = N - 1, {**self.counts, "starts": True, "flips": 0}
        self.need = 0.0
        self.mode = START

    def level(self):
        return self.share * self.used["G"] * self.rig.L(self.rs)

    def friction(self, sigma):
        U = self.used["U"]
        return self.level() * clamp(U[0] * sigma + U[1] * self.phi[0] + U[2] * self.phi[1], -4.0, 4.0)

    def turn(self):
        u = self.used
        u["U"][0] += u["turned"] - u["V"]
        u["V"], u["c"], u["kept"] = u["turned"], (u["c"][0] * u["kept"], u["c"][1] * u["kept"]), 1.0

    def error(self, r, y, share):
        rig, h = self.rig, self.rig.h
        self.share, self.waits = share, False
        r_good, self.y_good = abs(r) <= rig.input_max, abs(y) <= rig.input_max
        if self.mode in (RESTART, ENTER):
            if not (r_good and self.y_good):
                self.waits = True
                return 0.0
            self.start(r, y)
        r = r if r_good else self.r1
        self.y = y if self.y_good else self.y1
        # 1
        e0 = self.rs - self.y + self.m2
        # 2
        self.n_r = self.noise(self.n_r, r, self.r1, self.r2)
        last = self.r1 - self.r2
        self.r2, self.r1 = self.r1, r
        dr = r - self.rs
        if dr * self.limited > 0:
            dr = 0.0
        limit = 4000 * self.B / 314 * h
        step = self.exceeds(abs(dr), limit) and self.exceeds(abs(dr - last), limit)
        self.rs += dr
        self.rate = self.low_pass(self.rate, 0.0 if step else dr / h, self.T_y)
        # 3
        W = self.w + 4 * self.n_r
        if sign(self.rs - self.rp) != self.s:
            self.near(abs(self.rs - self.rp), W / 2)
        rp = clamp(self.rp, self.rs - W / 2, self.rs + W / 2)
        move, self.rp_before, self.rp, before = rp - self.rp, self.rp, rp, self.s
        self.phi = [clamp(x + move / d, -1.0, 1.0) for x, d in zip(self.phi, (0.375 * self.d, self.d))]
        still = self.ticks(rig.still_time)
        if dr and self.still >= still:
            self.near(abs(self.rs - self.rp_before), W / 2)
        if move:
            self.s = sign(move)
        if move and dr:
            self.rests = False
            if self.mode == HOLD and step:
                self.e_mean = dr
            else:
                self.still = 0
        else:
            self.still = min(self.still + 1, still)
        self.flips = self.s != before
        of_itself = rig.still_time > 0 and self.still >= still
        stands = of_itself or self.used["back"]
        if self.flips and not stands:
            self.turn()
            self.counts["turns"] += 1
            self.turned_since = True
        # 4
        ahead = self.tau * self.rate * self.w / W
        self.load = rig.D(self.rs) + self.c(self.rs)
        self.lin = self.rs + ahead + self.load
        self.m1 = self.low_pass(self.m1 - dr, ahead, self.tau)
        self.m2 = self.m2 - dr
        self.m2 += self.E_s * (self.m1 - self.m2)
        self.e = e0 if self.y_good else 0.0
        if self.y_good:
            self.e_mean = self.low_pass(self.e_mean, e0, 0.3)
        self.before, self.lead = self.f - self.b, 0.0
        if stands and self.mode != START:
            self.hold(of_itself)
        elif self.mode == HOLD:
            self.sigma, rise = float(self.s), self.level() * self.used["U"][0]
            if self.side != self.s and rise > 0:
                self.sigma = clamp((self.u - self.lin - self.friction(0.0)) / rise, -1.0, 1.0)
            self.f, self.mode, self.rule = self.friction(self.sigma), MOVING, CONTINUE
        else:
            self.slide(self.flips and before == 0)
        return self.e

    def slide(self, first):
        """5."""
        most = min(2.0, 2 * self.rig.h / self.T_j)
        by = self.s - self.sigma if first else clamp(self.s - self.sigma, -most, most)
        jump = self.level() * self.used["U"][0] * by
        self.sigma = clamp(self.sigma + by, -1.0, 1.0)
        self.f = self.friction(self.sigma)
        self.mode = MOVING if self.s else START
        if first:
            self.b += jump
        else:
            self.lead = self.rig.lead / (self.rig.actuator_pole * self.rig.h) * jump
            self.rule = REVERSAL if self.flips and self.rule == KEEP else self.rule

    def hold(self, of_itself):
        """6."""
        A = self.used["V"] * self.share * self.rig.L(self.rs)
        net = self.u - self.m - self.load
        before, self.f = self.f, 0.94 * clamp(net, -A, A)
        if self.mode != HOLD:
            self.b += self.f - before
            self.mode, self.rests, self.side, self.since, self.quick, self.sigma = HOLD, False, self.s, 0, 0, 0.0
        quick = self.ticks(0.3)
        if sign(net) != self.side and self.exceeds(abs(net), A):
            self.quick = min(self.quick + 1, 4) if self.since < quick else 0
            self.since, self.side = 0, sign(net)
            self.counts["chatter"] += self.quick == 4
        else:
            self.since = min(self.since + 1, quick)
        d = 0.04 * self.n_y
        if self.y_good:
            self.e -= clamp(self.e_mean, -d, d)
            self.rests = of_itself and self.exceeds(3.5 * d if self.rests else d, abs(self.e_mean), self.rig.h / 0.016)
        if self.rests:
            self.e, self.rule = 0.0, CONTINUE

    def sum(self, v):
        """7, until u."""
        if self.waits:
            return self.term if self.mode == ENTER else 0.0
        if self.flips:
            self.counts["flips"] += 1
            self.need = v + self.before
        if self.rule == REVERSAL:
            kept = clamp(self.s * (self.b - self.v_mean) - self.w, 0.0, abs(self.c(self.rs)) / 4)
            self.b = self.v_mean + self.s * kept
        elif self.rule == CONTINUE:
            self.b = v + self.lin + self.f - self.u
        elif self.rule == TAKE_OVER:
            self.b, self.v_mean = self.lin + self.f - self.term, v
        self.rule = KEEP
        self.v_mean = self.low_pass(self.v_mean, v, self.T_y)
        self.b = clamp(self.b, -4 * self.rig.input_max, 4 * self.rig.input_max)
        self.term = self.lin + self.f - self.b
        return self.term + self.lead

    def after(self, u, limited):
        if self.waits:
            return
        self.u = self.u if self.rests else u
        self.limited = limited
        # 8
        self.n_y = self.noise(self.n_y, self.y, self.y1, self.y2)
        self.y2, self.y1 = self.y1, self.y
        self.u1 += self.E_a * (u - self.u1)
        self.u2 += self.E_s * (self.u1 - self.u2)
        yf = self.low_pass(self.yf, self.y, self.T_y)
        self.zf = self.low_pass(self.zf, self.u2 - self.y, self.T_y)
        self.z = self.zf - self.rig.damping / self.rig.stiffness * (yf - self.yf) / self.rig.h
        self.yf = yf
        half = self.w / 10 + self.n_y / 5
        self.m = clamp(self.m, yf - half, yf + half)
        self.seen = {"lin": self.lin, "lead": self.lead, "sigma": self.sigma, "z": self.z}
        self.phase += 1
        if self.phase == N:
            self.phase = 0
            self.exchange()

    def exchange(self):
        f, load = self.f, self.c(self.rs)
        if self.result:
            self.used = self.result
            if self.turned_since:
                self.turn()
        if self.mode != HOLD:
            self.f = self.friction(self.sigma)
        self.b += self.f - f + self.c(self.rs) - load
        self.b -= self.b * N * self.rig.h / (1000 * self.tau + N * self.rig.h)
        slides = self.mode == MOVING or (self.mode == HOLD and self.still < self.ticks(self.rig.still_time))
        self.result = self.learner.step({**self.counts, "m": self.m, "yf": self.yf, "z": self.z, "n_y": self.n_y, "v": self.v_mean, "need": self.need,
                                         "allowed": slides and self.limited == 0 and self.y_good, "moves": self.mode == MOVING})
        self.counts, self.turned_since = {"starts": False, "flips": 0, "turns": 0, "chatter": 0}, False

    def told(self):
        x = self.learner
        return {"f": self.f, "b": self.b, "V0": 1 + 0.4 * x.a[0], "V1": x.V(1), "V2": x.V(2), "c0": x.c(0.0), "c2": 0.1 * x.a[4], "doubt": x.doubt, "P00": x.P[0][0],
                "P43": x.P[4][3], "turned": self.used["turned"], "xi": x.xi, "left": x.n_f} if self.mode > ENTER else {}


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



def happen(model, event, entry):
    if event == DO_RESTART:
        model.restart()
    elif event == DO_ENTER:
        model.enter(entry)
    elif event == DO_CHANGE:
        model.change_params()
    elif event == DO_RESET:
        model.reset()


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
        seen = {} if model.waits else {**model.seen, **model.told()}
        seen = {"e": e, "mode": model.mode, "term": added, **seen}
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
    level = 0.45 if t < 1.1 else 0.4469
    if t < 3.1:
        less = 2e-4 if 1.5 < t < 1.7 else 1e-4 if t > 1.5 else 0
        return level + 0.0303 * (clamp(t - 0.1, 0, 0.3) - clamp(t - 2, 0, 0.3)) / 0.3 + less
    if t < 3.6:
        return level - 0.0137 * math.floor((t - 2.8) / 0.3)
    return 0.62 - 0.0937 * max(0, t - 3.77) if t < 3.85 else 0.5


def bad_in_hold(k, r, y):
    return r, math.nan if k in (200, 201, 202, 430, 900) else y


def chatter(t, r):
    """A hold in which u crosses from side to side."""
    return 0.1, r + (0.4 if math.fmod(t, 0.17) < 0.085 else -0.4) if 0.7 < t < 1.8 else r + 0.1


def against(t, r):
    """A controller that works back and forth between the reversals, as against friction fed forward the wrong way."""
    return (0.3 if t < 1.3 else 0.002) * math.sin(65.3 * t), r + 0.02


def scenarios():
    """Name, rig and rows of each file.

    tracking: triangle; breakaway 0.8 and 1.2 of the model's, with presliding
    noise: h = 4 ms; sine over both signs of F, 0.5 mN noise on y, 0.2 mN on r, a constant load
    hold: h = 4 ms; ramps, stands in which u rests until the error grows, r steps or r moves, staircase, steps; y with noise of 4 mN, and bad
    chatter: h = 4 ms; a hold in which u changes its side all the time
    monitor: h = 4 ms; a controller that works against friction fed forward: it is fed back; a hand-over
    limits: h = 4 ms; u limited at ±0.64 N; NaN in y, 5 N in r, both; bad from the first tick
    changes: h = 4 ms; restart, reset, hand-over, change of params, a guard that fades
    rig: 2 kHz, 200 N, breakaway table, gravity, no key at its default
    """
    paper = Rig()
    slow = Rig(h=4e-3)
    pi = ((0.3, 0.032, 0.0, 0.0, 0.0),)
    yield "tracking", paper, play(paper, 0.6, lambda t: triangle(t, 0.31, 0.38, 0.61), seed=10, plant=Plant(paper, (0.8, 1.2)))

    yield "noise", slow, play(slow, 2.1, lambda t: 0.09 + 0.21 * math.sin(5.9 * t), seed=29, noise=5e-4, noise_r=2e-4, controller=pi,
                              plant=Plant(slow, (1.3, 1.1), load=0.02))

    yield "hold", slow, play(slow, 4.2, steps_and_stands, seed=9, noise=4e-3, upset=bad_in_hold, controller=pi,
                             plant=Plant(slow, (0.6, 0.6), widths=(2e-4, 2e-4, 2e-4)))

    yield "chatter", slow, play(slow, 2.2, lambda t: 0.4 + 0.0517 * clamp(t - 0.2, 0, 0.3) + 0.0713 * clamp(t - 2.0, 0, 1), seed=70, given=chatter)

    yield "monitor", slow, play(slow, 2.9, lambda t: triangle(t, 0.26, 0.48, 0.52), seed=90, given=against, events={650: (DO_ENTER, 0.05)})

    def upset(k, r, y):
        if k in (0, 1, 300, 301, 302, 480):
            return r, math.nan
        if k in (350, 480, 520):
            return 5.0, y
        return r, y

    yield "limits", slow, play(slow, 2.1, lambda t: 0.35 + 0.3 * math.sin(5.8182 * t) + (0.2 if 1.15 < t < 1.45 else 0), seed=43, u_max=0.64, noise=1e-5, noise_r=1e-5,
                               upset=upset, controller=pi)

    events = {90: (DO_ENTER, 0.07), 290: (DO_RESTART, 0), 400: (DO_CHANGE, 0), 460: (DO_ENTER, -0.11), 600: (DO_RESET, 0)}
    yield "changes", slow, play(slow, 2.7, lambda t: 0.5 + 0.1103 * math.sin(7.9 * t) * (t < 2.3), seed=58, noise=1e-5, noise_r=1e-5, events=events, controller=pi,
                                share=lambda t: 1.0 if t < 0.9 else 0.75 if t < 1.7 else 0.25)

    rig = Rig(h=5e-4, input_max=200.0, usual=50.0, table=((0.0, 3.0, 2.0), (40.0, 8.0, 9.0), (80.0, 14.0, 18.0)), gravity=1.5, stiffness=2e6,
              damping=2800.0, inertia=2.0, actuator_pole=700.0, sensor_pole=300.0, reversal=0.06, presliding=2.0, jump_time=0.009, lead=0.5,
              trust=0.7, forgetting=0.002, still_time=0.05)
    controller = ((9.0, 1.2, 0.0, 0.6, 0.0), (1.0, 0.0, 0.0, 1.0, 0.0))

    def reference(t):
        return triangle(min(t, 0.25), 0.22, 31.0, 72.0) if t < 0.35 else 10.0 * math.sin(31.0 * t)

    yield "rig", rig, play(rig, 0.4, reference, seed=64, noise=0.02, grid=2.0**-15, controller=controller,
                           plant=Plant(rig, (0.9, 1.1), widths=(0.02, 0.4, 1.8)))


def text_of(rows):
    lines = [",".join(GIVEN + EXPECTED)]
    lines += [",".join(f"{x:.9g}" if i < len(GIVEN) else f"{x:.7g}" for i, x in enumerate(row)) for row in rows]
    return "\n".join(lines) + "\n"


def same(a, b):
    """True if the numbers are the same except for the last digits of another machine's exp and sin."""
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
