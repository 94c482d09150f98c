"""The simulated arm for the examples in Python; arm.h is the same in C. Forces are in N, or N m."""

import math


class Arm:
    """A pole for the actuator, an arm that friction holds while the net force is within the breakaway, and a pole for the sensor. Its
    breakaway is 20 % above the value in the examples' rig."""

    def __init__(self, period_s):
        self.parts = (1 - math.exp(-200 * period_s), period_s / (period_s + 0.0075), 1 - math.exp(-55 * period_s))
        self.actuator = self.force = self.reading = 0.0

    def step(self, u):
        """Advances the arm by one period with the command u."""
        actuator, arm, sensor = self.parts
        breakaway = 1.2 * (0.007 + 0.3 * abs(self.force))
        self.actuator += actuator * (u - self.actuator)
        held = min(max(self.force, self.actuator - breakaway), self.actuator + breakaway)
        self.force += arm * (held - self.force)
        self.reading += sensor * (self.force - self.reading)


def triangle(period_s, cycle_s=10.0, cycles=2):
    """Yields the benchmark's reference, 0.4 to 0.6 N, one value per period."""
    ticks = round(cycle_s / period_s)
    for tick in range(cycles * ticks):
        phase = tick % ticks / ticks
        yield 0.4 + 0.4 * min(phase, 1 - phase)
