"""Writes the experiment that makes the friction parameters identifiable: a reference for the force loop, as CSV and as a scenario.

The experiment runs with the controller K(z) = 1/(1 + s/10) and without compensation, so that u follows r - F slowly, whatever the friction.
It is an experiment in u, from which the force sensor's noise is filtered out. At each level F goes up and down by a little, at three rates, in
every repeat; the levels are visited upwards and downwards in turn. With --hysteresis, ramps inside stiction at three slow rates follow, each
after a fall to the other end of stiction.

--low and --high bound u, and so they bound F: friction only makes F lag behind u. The levels lie in the range that F reaches with such a u.
"""

from dataclasses import dataclass, replace

import numpy as np

from tribo_design.errors import InputError
from tribo_plot.command_line import quoted

POLE = 10.0  # rad/s, of the controller
STEP_S = 0.01  # between rows of the reference
REST_S = 1.0  # at its beginning
RATES = (1.0, 3.0, 10.0)  # divisors of --rate for the cycles
SLOW = (40.0, 120.0, 400.0)  # divisors of --rate for the ramps inside stiction
SECONDS_MAX = 86400  # of a scenario's duration_s
RATE_MIN, RATE_MAX = 1e-6, 1e6  # N/s
MARGIN = 0.08  # of the range, at both ends of u, because friction may be less than guessed


@dataclass
class Plan:
    low: float
    high: float
    levels: int = 4
    repeats: int = 2
    rate: float | None = None  # N/s of u
    offset: float | None = None  # guess of the breakaway
    slope: float = 0.3
    noise: float = 0.0
    u_max: float | None = None
    sample_time_s: float = 1e-3
    hysteresis: bool = False

    def check(self):
        def refuse(name, value, allowed):
            raise InputError(f"--{name}: value {value:g}: must be {allowed}")

        for name in ("low", "high", "slope", "noise", "sample_time_s"):
            if not np.isfinite(getattr(self, name)):
                refuse(name.replace("_", "-"), getattr(self, name), "finite")
        if not abs(self.low) <= 1e6:
            refuse("low", self.low, "-1e6 to 1e6 N")
        if not self.low < self.high <= 1e6:
            refuse("high", self.high, "above --low and at most 1e6 N")
        if not 4 <= self.levels <= 32:
            refuse("levels", self.levels, "4 to 32: with fewer levels a bend of L(F) does not show")
        if not 2 <= self.repeats <= 100:
            refuse("repeats", self.repeats, "2 to 100: intervals come from repeats")
        if not 0 <= self.slope <= 0.9:
            refuse("slope", self.slope, "0 to 0.9")
        largest = max(abs(self.low), abs(self.high))
        if not 0 <= self.noise < largest:
            refuse("noise", self.noise, f"0 to {largest:g} N")
        if not 1e-6 <= self.sample_time_s <= 0.1:
            refuse("sample-time", self.sample_time_s, "1e-6 to 0.1 s")
        self.offset = 0.01 * largest if self.offset is None else self.offset
        if not 0 < self.offset <= 10 * largest:
            refuse("offset", self.offset, f"over 0 to {10 * largest:g} N")
        self.rate = min(max(2 * largest, RATE_MIN), RATE_MAX) if self.rate is None else self.rate
        if not RATE_MIN <= self.rate <= RATE_MAX:
            refuse("rate", self.rate, f"{RATE_MIN:g} to {RATE_MAX:g} N/s")
        bottom, top = self.range()
        if not top - bottom > max(0.1 * (self.high - self.low), 0.3 * self.breakaway(max(abs(bottom), abs(top)))):
            raise InputError(f"--high: value {self.high:g}: breakaway of {self.offset:g} N + {self.slope:g} |F| leaves F no travel between --low and --high")
        if not self._stands_out():
            fewer = next((levels for levels in range(self.levels - 1, 3, -1) if replace(self, levels=levels)._stands_out()), None)
            raise InputError(f"--noise: value {self.noise:g}: {self.levels} levels between {bottom:.3g} and {top:.3g} N do not stand out of it"
                             + (f"; --levels {fewer} would" if fewer else ", nor do fewer: this sensor is too noisy for so small a range"))
        if self.u_max is not None and not self.u_max >= largest:
            refuse("u-max", self.u_max, f"at least {largest:g} N, the largest of --low and --high in size")
        if self.seconds() > SECONDS_MAX:
            refuse("rate", self.rate, f"at least {1.01 * self.rate * self.seconds() / SECONDS_MAX:.3g} N/s: the experiment would take {self.seconds():.3g} s, and a run at most {SECONDS_MAX} s; fewer --repeats or --levels shorten it, too")
        return self

    def _stands_out(self):
        """Returns whether the steps of F from level to level stand out of the noise."""
        bottom, top = self.range()
        step = (top - bottom - 2 * self.swing()) / (self.levels - 1)
        return self.noise == 0 or self.swing() <= max(0.9 * step, 0.25 * step + 8 * self.noise)

    def breakaway(self, force):
        return self.offset + self.slope * abs(force)

    def slid(self, u, way):
        """Returns F after u has moved it in the direction `way`: F + way (offset + slope |F|) = u."""
        net = u - way * self.offset
        return net / (1 + way * self.slope * np.sign(net))

    def range(self):
        """Returns F at both ends of u."""
        margin = MARGIN * (self.high - self.low)
        return self.slid(self.low + margin, -1), self.slid(self.high - margin, 1)

    def swing(self):
        """Returns how far F goes beyond a level."""
        bottom, top = self.range()
        return max(0.25 * (top - bottom) / (self.levels - 0.5), 10 * self.noise, 0.1 * self.breakaway(max(abs(bottom), abs(top))))

    def moves(self):
        """Yields the values that u goes to, with the rate in N/s."""

        def around(level, rate):
            for way in (1, -1):
                end = level + way * self.swing()
                yield end + way * self.breakaway(end), rate

        bottom, top = self.range()
        levels = np.linspace(bottom + self.swing(), top - self.swing(), self.levels)
        for repeat in range(self.repeats):
            for level in levels if repeat % 2 == 0 else levels[::-1]:
                for slower in RATES:
                    yield from around(level, self.rate / slower)
        if self.hysteresis:
            level = levels[len(levels) // 2]
            for _ in range(self.repeats):
                for slow in SLOW:
                    yield from around(level, self.rate)
                    yield level + self.swing() + self.breakaway(level + self.swing()), self.rate / slow
        yield min(max(0.0, self.low), self.high), self.rate / 3

    def seconds(self):
        """Returns how long the experiment takes."""
        u, seconds = 0.0, REST_S
        for to, rate in self.moves():
            u, seconds = to, seconds + abs(to - u) / rate
        return seconds

    def corners(self):
        """Returns (time, u, expected F) at the corners of the experiment."""
        corners = [(0.0, 0.0, 0.0), (REST_S, 0.0, 0.0)]
        for to, rate in self.moves():
            time, u, force = corners[-1]
            span = abs(to - u) / rate
            pieces = max(int(np.ceil(span / STEP_S)), 1)
            for i in range(1, pieces + 1):
                at = u + (to - u) * i / pieces
                force = min(max(force, self.slid(at, 1)), self.slid(at, -1))
                corners.append((time + span * i / pieces, at, force))
        return np.array(corners)

    def commands(self):
        """Returns rows t, u for a drive that plays u itself."""
        corners = self.corners()
        time = np.arange(0, corners[-1, 0] + STEP_S, STEP_S)
        return np.c_[time, np.interp(time, corners[:, 0], corners[:, 1])]

    def reference(self):
        """Returns rows t, r. r leads u by the controller's lag and adds the expected force."""
        corners = self.corners()
        time = np.arange(0, corners[-1, 0], STEP_S)
        u, force = np.interp(time, corners[:, 0], corners[:, 1]), np.interp(time, corners[:, 0], corners[:, 2])
        return np.c_[time, u + force + np.gradient(u, STEP_S) / POLE]

    def scenario(self, file):
        h = self.sample_time_s
        b = POLE * h / (2 + POLE * h)
        rows = self.reference()
        top = max(float(np.abs(rows[:, 1]).max()), self.high, -self.low)
        return f"""# An experiment for friction: u = (r - y) / (1 + s/{POLE:g}), no compensation. Made by tribo-identify plan.
description: "friction identification, {self.low:g} to {self.high:g} N"
duration_s: {rows[-1, 0]:.3f}
sample_time_s: {h:.9g}
reference: {{kind: csv, file: {file}}}
compensator: {{method: "off"}}
controller:
  kind: z
  sections:
    - {{b0: {b:.9g}, b1: {b:.9g}, b2: 0, a1: {(POLE * h - 2) / (POLE * h + 2):.12g}, a2: 0}}
limits: {{u_min_N: {min(self.low, 0.0):.6g}, u_max_N: {max(self.high, 0.0):.6g}, input_max_N: {3 * top:.6g}}}
"""


NAMES = ("plan.csv", "plan.yaml")


def command(options):
    from tribo_design.output import check_replaceable, write_directory

    plan = Plan(**{name: getattr(options, name) for name in Plan.__dataclass_fields__}).check()
    check_replaceable(options.out, NAMES)
    rows = plan.reference()
    text = "t_s,r_N\n" + "".join(f"{t:.3f},{r:.6g}\n" for t, r in rows)
    write_directory(options.out, {"plan.csv": text.encode(), "plan.yaml": plan.scenario("plan.csv").encode()}, NAMES)
    bottom, top = plan.range()
    print(f"{plan.levels} loads; F goes from {bottom:.3g} to {top:.3g} N with the guessed friction, u from {plan.low:g} to {plan.high:g} N, in both directions at {', '.join(f'{plan.rate / r:.3g}' for r in RATES)} N/s, {plan.repeats} times"
          + (f"; ramps inside stiction at {', '.join(f'{plan.rate / s:.3g}' for s in SLOW)} N/s" if plan.hysteresis else "; k_min, k_max, m and v0 need --hysteresis"))
    print(f"{rows[-1, 0]:.0f} s; run it without compensation: tribo-sim run {quoted(f'{options.out}/plan.yaml')} --out DIR, or on the drive plan.csv as the reference with the controller of plan.yaml")
    return 0
