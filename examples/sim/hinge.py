"""The simulated joint for the Python examples without a force sensor, and stand-ins for your position loop and your reference. hinge.h has the
same joint in C. Positions are in turns, torques in N m."""

import math


class Hinge:
    """A joint of 0.002 kg m2 that sticks at 0.12 N m and slides at 0.1 N m; its encoder has `counts` per turn."""

    INERTIA, FRICTION, BREAKAWAY, STRIBECK, SUBSTEPS = 0.0126, 0.1, 0.12, 0.02, 20  # N m s2 per turn, N m, N m, turns/s

    def __init__(self, period_s, counts=8192):
        self.dt, self.counts, self.angle, self.speed = period_s / self.SUBSTEPS, counts, 0.0, 0.0

    @property
    def reading(self):
        return math.floor(self.angle * self.counts) / self.counts

    def move(self, torque):
        """Advances the joint by one substep."""
        held = self.FRICTION + (self.BREAKAWAY - self.FRICTION) * math.exp(-abs(self.speed) / self.STRIBECK)
        push = torque + self.INERTIA * self.speed / self.dt
        self.speed = 0.0 if abs(push) < held else (push - math.copysign(held, push)) * self.dt / self.INERTIA
        self.angle += self.dt * self.speed

    def step(self, torque):
        """Advances the joint by one period with a constant torque."""
        for _ in range(self.SUBSTEPS):
            self.move(torque)


class PositionLoop:
    """A PD whose D term acts on the error, and so includes the reference's velocity."""

    def __init__(self, kp, kd, period_s):
        self.kp, self.kd, self.period_s, self.last_off = kp, kd, period_s, None

    def step(self, q_ref, q):
        off = q_ref - q
        rate = 0.0 if self.last_off is None else (off - self.last_off) / self.period_s
        self.last_off = off
        return self.kp * off + self.kd * rate


def swing(period_s, half_turn=0.25):
    """Yields one position per period, to and fro in two seconds."""
    tick = 0
    while True:
        yield half_turn * math.sin(math.pi * period_s * tick)
        tick += 1
