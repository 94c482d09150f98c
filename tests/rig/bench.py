"""A stranger's rig on a bench, simulated: 2.3 kg on a contact of 20 kN/m, friction of 0.4 N + 0.12 |F|, a drive at 2 kHz that is two ticks late and
makes 1.06 N for a newton. It shares no code with the project.

    bench.py COMMANDS.csv LOG.csv      plays the commands and records, like the rig's own logger
"""

import sys

import numpy as np

TICK_S, STEPS = 5e-4, 10
MASS_KG, STIFFNESS, DAMPING = 2.3, 20e3, 260.0  # N/m, N s/m
OFFSET_N, SLOPE = 0.4, 0.12
CURRENT, FILTER = 600.0, 300.0  # rad/s: poles of current loop and sensor
LATE, SCALE = 2, 1.06  # ticks, N for a newton
NOISE_N, LSB_N = 0.004, 0.01


class Bench:
    def __init__(self, seed=28):
        self.source = np.random.default_rng(seed)
        self.force = self.speed = self.travel = self.reading = 0.0
        self.late = [0.0] * LATE
        self.largest = 0.0

    def read(self):
        return round((self.reading + NOISE_N * self.source.normal()) / LSB_N) * LSB_N

    def tick(self, command):
        """One tick, in which the motor gets the command of two ticks before."""
        self.late.append(SCALE * command)
        wanted, dt = self.late.pop(0), TICK_S / STEPS
        for _ in range(STEPS):
            self.force += dt * CURRENT * (wanted - self.force)
            contact = STIFFNESS * self.travel
            # The speed without friction, damper and spring at the end of the step; friction takes from it what it can.
            speed = (self.speed + dt / MASS_KG * (self.force - contact)) / (1 + dt / MASS_KG * (DAMPING + dt * STIFFNESS))
            most = dt / MASS_KG * (OFFSET_N + SLOPE * abs(contact)) / (1 + dt / MASS_KG * (DAMPING + dt * STIFFNESS))
            self.speed = speed - max(-most, min(most, speed))
            self.travel += dt * self.speed
            self.reading += dt * FILTER * (STIFFNESS * self.travel - self.reading)
            self.largest = max(self.largest, abs(STIFFNESS * self.travel))


def main():
    commands = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1, usecols=1)
    bench = Bench()
    with open(sys.argv[2], "w", encoding="ascii") as log:
        log.write("time_ms,command,force\n")
        for number, command in enumerate(commands):
            log.write(f"{1e3 * TICK_S * number:g},{command:.3f},{bench.read():.2f}\n")
            bench.tick(command)


if __name__ == "__main__":
    main()
