"""TIM1, the injected conversions that it starts, and what hangs on its pins: legs of switches with diodes, and a winding between two
of them. By facts of RM0090.

The counter goes up and down between 0 and ARR. Compare values act from the next end of the counter on (preload). A leg's high side is
on below its compare value, its low side above; whichever comes on does so a dead time after the other went off. Without MOE, or with
the break input active, all are off at once. Each edge is checked: the other switch of the leg is off, and has been for `least_dead_s`.

A leg whose switches are off has the potential that the current through its diodes gives it.
"""

import math

TIM1, ADC = 0x40010000, 0x40012000
OFF, LOW, HIGH = 0, 1, 2
LEGS = 2
NEVER = float("inf")


class Leg:
    """One leg; `state` is the switch that is on."""

    def __init__(self):
        self.state, self.wanted, self.due_s = OFF, OFF, NEVER
        self.off_s = {LOW: -1.0, HIGH: -1.0}  # when each went off
        self.edges = 0


class Bridge:
    def __init__(self, chip):
        self.chip = chip
        self.legs = [Leg() for _ in range(LEGS)]
        self.least_dead_s, self.shortest_dead_s = 500e-9, NEVER
        self.begun_s = None     # TIM1 counts since
        self.half = 0           # of the period, since then: even ones count up
        self.half_s = 0.0       # of one
        self.next_half_s = NEVER
        self.shadow = [0] * 4   # compare values in use
        self.turns = [NEVER] * LEGS  # when a leg's compare value is met in this half
        self.at_s = 0.0         # up to which all is played
        self.main = False       # MOE
        self.locked = False
        self.ready_s = [NEVER, NEVER]   # ends of ADC1's and ADC2's conversions
        self.hold_s = NEVER             # when the codes are held
        self.done, self.codes = [0, 0], [[0] * 4, [0] * 4]
        self.held_a = 0.0
        self.triggers_work = True
        # The motor, its supply, and what is broken of them.
        self.r_ohm, self.l_h, self.emf_v, self.bus_v = 2.0, 1e-3, 0.0, 24.0
        self.current_a, self.charge = 0.0, 0.0
        self.is_open = False
        self.offset_v, self.gain, self.sensor_v = 0.0, 0.2, None
        self.temperature_v = 0.25
        self.currents = []      # at each sample, with its time, if it is wanted
        self.keeps = False
        self.off_since_s = 0.0
        self.periods = 0

    # --- registers -----------------------------------------------------------------------------------------------------

    def reg(self, offset):
        return self.chip.reg(TIM1 + offset)

    def read(self, offset):
        self.advance()
        if offset == 0x44:
            return self.reg(0x44) & ~(1 << 15) | self.main << 15
        return self.reg(offset)

    def write(self, offset, value):
        self.advance()
        registers = self.chip.registers
        if offset == 0x44:
            if not self.locked:
                registers[TIM1 + 0x44] = value & ~(1 << 15)
                self.locked = value >> 8 & 3 == 3
            self._set_main(value >> 15 & 1 == 1 and not self._breaks())
            return True
        if offset in (0x18, 0x1C) and self.locked:
            return True  # OCxM and OCxPE
        if offset == 0x14 and value & 1:
            self.shadow = [self.reg(0x34 + 4 * i) for i in range(4)]
        if offset == 0x00 and value & 1 and self.begun_s is None:
            assert value >> 5 & 3 == 1 and value >> 7 & 1, "not centre-aligned"
            assert self.reg(0x44) >> 8 & 15 == 15, "neither locked nor driven while idle"
            assert self.reg(0x18) & 0xF8F8 == 0x6868 and self.reg(0x1C) & 0xFF00 == 0x7800, "modes of the channels"
            assert self.reg(0x20) & 0xFF == 0x55, "polarity"
            self.begun_s = self.at_s = self.chip.now_s
            self.half_s = self.reg(0x2C) / self.chip.timer_hz(TIM1)
            self.half, self.next_half_s = -1, self.begun_s
        return False

    def converted(self, offset):
        """What ADC1 (0x000) or ADC2 (0x100) shows of injected conversions; None of other registers."""
        number, register = offset >> 8, offset & 0xFF
        if number > 1 or not self.chip.field(ADC + 0x100 * number + 0x08, 20, 2):
            return None
        self.advance()
        if register == 0x00:
            return self.done[number] << 2
        if 0x3C <= register <= 0x48:
            return self.codes[number][(register - 0x3C) // 4]
        return None

    def is_on(self):
        self.advance()
        return self.main

    def dead_time_s(self):
        dtg = self.reg(0x44) & 0xFF
        cycles = dtg if dtg < 128 else (64 + (dtg & 63)) * 2 if dtg < 192 else (32 + (dtg & 31)) * (8 if dtg < 224 else 16)
        return cycles / self.chip.timer_hz(TIM1)

    # --- break ---------------------------------------------------------------------------------------------------------

    def _breaks(self):
        enabled, high = self.reg(0x44) >> 12 & 1, self.reg(0x44) >> 13 & 1
        connected = self.chip.field(0x40020400, 24, 2) == 2 and self.chip.field(0x40020424, 16, 4) == 1
        return bool(enabled and connected and self.chip.pins >> 12 & 1 == high)

    def look_at_break(self):
        self.advance()
        if self._breaks():
            self._set_main(False)

    def _set_main(self, on):
        if on == self.main:
            return
        self.main = on
        self.off_since_s = self.chip.now_s
        for leg in self.legs:
            if on:
                self._want(leg, leg.wanted, self.at_s)
            else:
                self._switch_off(leg, self.at_s)
                leg.due_s = NEVER

    # --- switches ------------------------------------------------------------------------------------------------------

    @staticmethod
    def _switch_off(leg, at_s):
        if leg.state != OFF:
            leg.off_s[leg.state] = at_s
            leg.state = OFF
            leg.edges += 1

    def _want(self, leg, side, at_s):
        """The reference of a leg is this side from now on."""
        is_under_way = leg.wanted == side and leg.due_s < NEVER
        leg.wanted = side
        if not self.main or leg.state == side or is_under_way:
            return
        self._switch_off(leg, at_s)
        leg.due_s = at_s + self.dead_time_s()

    def _switch_on(self, leg, at_s):
        other = LOW if leg.wanted == HIGH else HIGH
        assert leg.state == OFF, "two switches of a leg are on"
        dead_s = at_s - leg.off_s[other]
        assert dead_s >= self.least_dead_s - 1e-12, f"a dead time of {1e9 * dead_s:.0f} ns"
        self.shortest_dead_s = min(self.shortest_dead_s, dead_s)
        leg.state, leg.due_s = leg.wanted, NEVER
        leg.edges += 1

    # --- the winding ---------------------------------------------------------------------------------------------------

    def _potential(self, leg, out_a):
        """With `out_a` out of the leg."""
        if leg.state != OFF:
            return self.bus_v if leg.state == HIGH else 0.0
        return None if out_a == 0.0 else 0.0 if out_a > 0.0 else self.bus_v

    def _flow(self, seconds):
        i = self.current_a
        if self.is_open or seconds <= 0.0:
            self.current_a = 0.0 if self.is_open else i
            return
        ends = self._potential(self.legs[0], i), self._potential(self.legs[1], -i)
        if None in ends:
            return  # no way for a current to begin
        v = ends[0] - ends[1] - self.emf_v
        last = v / self.r_ohm
        decay = math.exp(-seconds * self.r_ohm / self.l_h)
        after = last + (i - last) * decay
        if OFF in (self.legs[0].state, self.legs[1].state) and i * after < 0.0:
            after = 0.0  # diodes end it
        self.charge += 0.5 * (i + after) * seconds
        self.current_a = after

    def mean_a(self, seconds):
        """Returns the mean current since the last call, `seconds` ago."""
        charge, self.charge = self.charge, 0.0
        return charge / seconds

    # --- time ----------------------------------------------------------------------------------------------------------

    def due_s(self):
        return None if self.begun_s is None else min(self.next_half_s, self.ready_s[1])

    def _begin_half(self, at_s):
        self.half += 1
        self.next_half_s = at_s + self.half_s
        self.shadow = [self.reg(0x34 + 4 * i) for i in range(4)]
        top, hz = self.reg(0x2C), self.chip.timer_hz(TIM1)
        up = self.half % 2 == 0
        for number, leg in enumerate(self.legs):
            compare = self.shadow[number]
            if up:
                self._want(leg, HIGH if compare > 0 else LOW, at_s)
            self.turns[number] = at_s + (compare if up else top - compare) / hz
        if up:
            self.periods += 1
            self._trigger(at_s + self.shadow[3] / hz)

    def _trigger(self, at_s):
        if self.reg(0x04) >> 4 & 7 != 7 or not self.triggers_work:
            return
        hz = self.chip.apb_hz(2) / (2 * (self.chip.field(ADC + 0x304, 16, 2) + 1))
        for number in range(2):
            base = ADC + 0x100 * number
            control, order = self.chip.reg(base + 0x08), self.chip.reg(base + 0x38)
            if control & 1 and control >> 20 & 3 == 1 and control >> 16 & 15 == 1:
                length = (order >> 20 & 3) + 1
                channels = [order >> 5 * (3 - length + 1 + i) & 31 for i in range(length)]
                cycles = [(3, 15, 28, 56, 84, 112, 144, 480)[self.chip.field(base + 0x10, 3 * c, 3)] for c in channels]
                self.ready_s[number] = at_s + sum(c + 12 for c in cycles) / hz
                if number == 1:
                    self.hold_s = at_s + cycles[channels.index(1)] / hz

    def _code(self, channel):
        sensed_v = 1.65 + self.offset_v + self.gain * self.held_a
        volts = {0: self.chip.sensor_v, 1: sensed_v if self.sensor_v is None else self.sensor_v, 2: self.bus_v / 20,
                 3: self.temperature_v, 4: 1.65}[channel]
        return min(4095, max(0, int(volts / 3.3 * 4096)))

    def _convert(self, number):
        order = self.chip.reg(ADC + 0x100 * number + 0x38)
        length = (order >> 20 & 3) + 1
        self.codes[number] = [self._code(order >> 5 * (3 - length + 1 + i) & 31) for i in range(length)] + [0] * (4 - length)
        self.done[number] = 1
        if number == 1 and self.chip.field(ADC + 0x104, 7, 1):
            self.chip.pended.add(18)

    def advance(self):
        """Plays up to now."""
        now_s = self.chip.now_s
        if self.begun_s is None or now_s <= self.at_s:
            return
        while True:
            first = self.legs[0]
            second = self.legs[1]
            at_s = min(self.next_half_s, self.turns[0], self.turns[1], first.due_s, second.due_s, self.hold_s, *self.ready_s)
            if at_s > now_s:
                break
            self._flow(at_s - self.at_s)
            self.at_s = max(at_s, self.at_s)
            self._happen(at_s)
        self._flow(now_s - self.at_s)
        self.at_s = now_s

    def _happen(self, at_s):
        if at_s == self.hold_s:
            self.hold_s = NEVER
            self.held_a = self.current_a
            if self.keeps:
                self.currents.append((at_s, self.current_a))
        for number, leg in enumerate(self.legs):
            if at_s == self.turns[number]:
                self.turns[number] = NEVER
                self._want(leg, LOW if self.half % 2 == 0 else HIGH, at_s)
            if at_s == leg.due_s:
                self._switch_on(leg, at_s)
        for number in range(2):
            if at_s == self.ready_s[number]:
                self.ready_s[number] = NEVER
                self._convert(number)
        if at_s == self.next_half_s:
            self._begin_half(at_s)
