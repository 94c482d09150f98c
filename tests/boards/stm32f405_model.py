"""An STM32F405 as far as its image touches it: the registers of RM0090 around Unicorn's Cortex-M4, by facts of the manual.

Time passes in cycles of the system clock, which the image sets: an access to a register takes 20 with the instructions around it, two bytes
of the background's instructions take 1. Timers, converters, USART and watchdog run by that clock, and by the crystal and the oscillators that
the model is given, so a wrong divider shows as a wrong rate. A peripheral whose clock is off reads 0 and ignores writes. The USART holds one
received byte; what arrives behind it is lost. Exceptions are entered by priority through the vector table at VTOR; only the instructions are
Unicorn's.
"""

import struct

import bridge_model
from elftools.elf.elffile import ELFFile
from unicorn import (UC_ARCH_ARM, UC_HOOK_BLOCK, UC_HOOK_CODE, UC_HOOK_MEM_FETCH_UNMAPPED, UC_HOOK_MEM_READ_UNMAPPED, UC_HOOK_MEM_WRITE,
                     UC_HOOK_MEM_WRITE_UNMAPPED, UC_MODE_MCLASS, UC_MODE_THUMB, Uc)
from unicorn.arm_const import (UC_ARM_REG_LR, UC_ARM_REG_PC, UC_ARM_REG_PRIMASK, UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_R2, UC_ARM_REG_R3,
                               UC_ARM_REG_R12, UC_ARM_REG_S0, UC_ARM_REG_SP, UC_ARM_REG_XPSR)
from unicorn.arm_const import UC_CPU_ARM_CORTEX_M4

FLASH, FLASH_SIZE = 0x08000000, 1 << 20
STORE_SECTOR = 1 << 17  # the last two sectors, 10 and 11
STORE = FLASH + FLASH_SIZE - 2 * STORE_SECTOR
ERASE_S, WRITE_S = 1.0, 16e-6
RAM, RAM_SIZE = 0x20000000, 128 << 10
RETURN = 0x1FFF8000  # where a function or handler that is called returns to
BOOT_LOADER = 0x1FFF0000
WFI, LOOP = b"\x30\xbf", b"\xfe\xe7"

NEVER = float("inf")
ACCESS_CYCLES = 20  # with the instructions around it
BYTE_CYCLES = 0.5    # of the background's instructions: 1.5 for one of 3 bytes on average

NMI, HARD_FAULT = 2, 3
PVD, EXTI1, ADC, TIM2, USART1, EXTI15_10 = 1, 7, 18, 28, 37, 40

RCC, RCC_SIZE = 0x40023800, 0x400
PERIPHERALS = {  # base: name, offset and bit of its clock
    0x40000000: ("TIM2", 0x40, 0), 0x40010000: ("TIM1", 0x44, 0), 0x40000400: ("TIM3", 0x40, 1), 0x40000C00: ("TIM5", 0x40, 3), 0x40003000: ("IWDG", None, None),
    0x40007000: ("PWR", 0x40, 28), 0x40007400: ("DAC", 0x40, 29), 0x40011000: ("USART1", 0x44, 4), 0x40012000: ("ADC", 0x44, 8),
    0x40013800: ("SYSCFG", 0x44, 14), 0x40013C00: ("EXTI", None, None), 0x40014800: ("TIM11", 0x44, 18),
    0x40020000: ("GPIOA", 0x30, 0), 0x40020400: ("GPIOB", 0x30, 1), 0x40023800: ("RCC", None, None),
    0x40023C00: ("FLASH", None, None),
}

POWER_ON = 1 << 27 | 1 << 26 | 1 << 25  # reset flags: POR, pin, BOR
PIN = 1 << 26
BROWN_OUT = 1 << 26 | 1 << 25
WATCHDOG = 1 << 29 | PIN
SOFTWARE = 1 << 28 | PIN


class Reset(Exception):
    """The chip was reset; args[0] are the flags it starts with."""


class Chip:
    """One power-up of an image. `ram`, `flags` and `store`, the last two sectors, are those of a chip that has run before."""

    def __init__(self, image, crystal_hz=8_000_000, hsi_hz=16_000_000, flags=POWER_ON, ram=None, pll_locks=True, store=None, options=0x0FFFAAE1,
                 clock_at_osc_in=False, control=0x83):
        with open(image, "rb") as file:
            elf = ELFFile(file)
            self.sizes = {s.name: (s["st_value"], s["st_size"]) for s in elf.get_section_by_name(".symtab").iter_symbols()}
            self.symbols = {name: value for name, (value, _) in self.sizes.items()}
            segments = [(s["p_paddr"], s.data()) for s in elf.iter_segments() if s["p_type"] == "PT_LOAD" and s["p_filesz"]]
        self.crystal_hz, self.hsi_hz, self.pll_locks = crystal_hz, hsi_hz, pll_locks
        self.clock_at_osc_in = clock_at_osc_in  # instead of a crystal
        self.uc = uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS)
        uc.ctl_set_cpu_model(UC_CPU_ARM_CORTEX_M4)
        uc.mem_map(FLASH, FLASH_SIZE)
        uc.mem_write(FLASH, b"\xff" * FLASH_SIZE)
        uc.mem_write(STORE, store if store is not None else b"\xff" * 2 * STORE_SECTOR)
        uc.hook_add(UC_HOOK_MEM_WRITE, self._on_flash_write, begin=FLASH, end=FLASH + FLASH_SIZE - 1)
        uc.mem_map(RAM, RAM_SIZE)
        uc.mem_map(BOOT_LOADER, 0x10000)
        uc.mmio_map(0x40000000, 0x80000, self._read, 0x40000000, self._write, 0x40000000)
        uc.mmio_map(0xE0000000, 0x100000, self._read, 0xE0000000, self._write, 0xE0000000)
        for address, data in segments:
            uc.mem_write(address, data)
            for at in range(0, len(data), 2):
                if data[at:at + 2] == WFI:
                    uc.hook_add(UC_HOOK_CODE, self._on_wfi, begin=address + at, end=address + at)
        uc.mem_write(RETURN, LOOP)
        start = self.symbols["board_start"] & ~1
        self.started = False
        self.start_hook = uc.hook_add(UC_HOOK_CODE, self._on_start, begin=start, end=start)
        uc.hook_add(UC_HOOK_CODE, lambda *_: uc.emu_stop(), begin=RETURN, end=RETURN)
        uc.hook_add(UC_HOOK_MEM_READ_UNMAPPED | UC_HOOK_MEM_WRITE_UNMAPPED | UC_HOOK_MEM_FETCH_UNMAPPED, self._on_unmapped)
        uc.mem_write(RAM, ram if ram is not None else bytes([0xA5]) * RAM_SIZE)

        self.registers = {0x40023C14: options, RCC + 0x00: control, RCC + 0x74: flags, 0xE000ED08: BOOT_LOADER}  # VTOR: as the boot loader left it
        self.next_due_s = NEVER
        self.now_s, self.cycle_s = 0.0, 1 / hsi_hz
        self.error = None          # what a callback raised
        self.sleeping = False
        self.enabled, self.pended, self.active = set(), set(), []
        self.priorities = {}
        self.mpu = {}
        self.undriven = 0          # bytes that an RS-485 transceiver would not have sent
        self.log, self.bad_baud = bytearray(), False
        self.incoming = []         # bytes on the line, with the times at which they will have arrived
        self.received, self.overrun = None, False
        self.sent_s, self.fast_usart = 0.0, False
        self.sensor_v = 1.65       # at PA0
        self.measured_v = [1.65, 1.2, 0.25]  # at PA1 to PA3: 0 A, 24 V, 25 degC
        self.encoder = 0           # edges so far at PA6 and PA7
        self.enable_short = None   # to ground or to the supply: what PB0 reads, whatever it is set to
        self.supply_v = 3.3
        self.adc2_done, self.adc2_works = False, True
        self.pins = 0              # of port B, as wired: PB1 and PB12 closed to ground
        self.kicked_s = None       # the watchdog's last reload
        self.longest_wait_s = 0.0  # between two of them
        self.tick_due_s = self.conversion_due_s = None
        self.timer_started_s, self.timer_held_s, self.tick_left_s = {}, {}, None
        self.flash_keys, self.flash_locked, self.flash_busy_s, self.flash_errors, self.flash_word = 0, True, 0.0, 0, None
        self.flash_fails = False   # says that it is done, and changes nothing
        self.captures_s = 0.0
        self.tick_count = self.counted = 0
        self.bridge = bridge_model.Bridge(self)
        self.on_tick = lambda: None
        self.on_output = lambda: None
        sp, pc = struct.unpack("<II", uc.mem_read(FLASH, 8))
        uc.reg_write(UC_ARM_REG_SP, sp)
        self.pc = pc & ~1

    # --- clocks ------------------------------------------------------------------------------------------------------

    def reg(self, address):
        return self.registers.get(address, 0)

    def field(self, address, position, width):
        return self.reg(address) >> position & ((1 << width) - 1)

    def system_hz(self):
        """Returns the frequency that the registers set now."""
        if self.field(RCC + 8, 0, 2) != 2:
            return self.hsi_hz
        source = self.crystal_hz if self.field(RCC + 4, 22, 1) else self.hsi_hz
        return source / self.field(RCC + 4, 0, 6) * self.field(RCC + 4, 6, 9) / (2 * (self.field(RCC + 4, 16, 2) + 1))

    def apb_hz(self, number):
        divider = self.field(RCC + 8, 10 if number == 1 else 13, 3)
        return self.system_hz() / (1 if divider < 4 else 2 << (divider - 4))

    def timer_hz(self, base):
        number = 1 if base < 0x40010000 else 2
        divider = self.field(RCC + 8, 10 if number == 1 else 13, 3)
        return self.apb_hz(number) * (1 if divider < 4 else 2) / (self.reg(base + 0x28) + 1)


    # --- registers ---------------------------------------------------------------------------------------------------

    def _guard(self, function, *arguments):
        """Python's exceptions do not cross the emulator."""
        try:
            return function(*arguments)
        except Exception as error:  # pylint: disable=broad-except
            self.error = self.error or error
            self.uc.emu_stop()
            return 0

    def _read(self, _uc, offset, size, base):
        return self._guard(self.read, base + offset, size)

    def _write(self, _uc, offset, size, value, base):
        self._guard(self.write, base + offset, size, value)

    def _is_clocked(self, address):
        _, enable, bit = PERIPHERALS[self._base(address)]
        return enable is None or self.field(RCC + enable, bit, 1) == 1

    @staticmethod
    def _base(address):
        for base in PERIPHERALS:
            if base <= address < base + 0x400:
                return base
        raise AssertionError(f"no such register: {address:#x}")

    def read(self, address, size):
        self.now_s += ACCESS_CYCLES * self.cycle_s
        if address == 0x40011000:  # a wait for the USART reads it thousands of times
            return self._read_usart1(0)
        if address >= 0xE0000000:
            return self._read_core(address)
        assert size == 4, f"{address:#x} is read by {size} bytes"
        base = self._base(address)
        if not self._is_clocked(address):
            return 0
        handler = getattr(self, f"_read_{PERIPHERALS[base][0].lower()}", None)
        return handler(address - base) if handler else self.reg(address)

    def write(self, address, size, value):
        self.now_s += ACCESS_CYCLES * self.cycle_s
        if address >= 0xE0000000:
            self._write_core(address, size, value)
            return
        assert size == 4, f"{address:#x} is written by {size} bytes"
        base = self._base(address)
        if not self._is_clocked(address):
            return
        handler = getattr(self, f"_write_{PERIPHERALS[base][0].lower()}", None)
        if not handler or not handler(address - base, value):
            self.registers[address] = value
        if base == RCC:
            self.cycle_s = 1 / self.system_hz()

    def _read_rcc(self, offset):
        value = self.reg(RCC + offset)
        if offset == 0x00:
            value = value & ~(1 << 1 | 1 << 17 | 1 << 25) | (value & 1) << 1
            value |= self.hse_runs() << 17
            value |= (value >> 24 & 1 & self.pll_locks) << 25
        if offset == 0x08:
            value = value & ~0xC | (value & 3) << 2
        return value

    def hse_runs(self):
        """In bypass the crystal is not driven. Of a clock at OSC_IN without bypass the manual says nothing: it is none here."""
        return bool(self.crystal_hz) and self.field(RCC, 16, 1) == 1 and self.field(RCC, 18, 1) == self.clock_at_osc_in

    def _write_rcc(self, offset, value):
        if offset == 0x00 and self.field(RCC, 16, 1):  # HSEBYP is locked while HSE is on
            self.registers[RCC] = value & ~(1 << 18) | self.reg(RCC) & 1 << 18
            return True
        if offset == 0x74 and value & 1 << 24:
            self.registers[RCC + 0x74] = 0
            return True
        if offset == 0x0C:
            self.registers[RCC + 0x0C] = self.reg(RCC + 0x0C) & ~(value >> 16 & 0xFF)
            return True
        return False

    def _read_pwr(self, offset):
        low = self.field(0x40007000, 4, 1) and self.supply_v < 2.92
        return self.reg(0x40007000 + offset) | (low << 2 if offset == 4 else 0)

    # pins and their interrupts

    def _read_gpiob(self, offset):
        return self.levels() if offset == 0x10 else self.reg(0x40020400 + offset)

    def _write_gpio(self, base, offset, value):
        if offset == 0x18:
            out = self.reg(base + 0x14)
            self.registers[base + 0x14] = (out | value & 0xFFFF) & ~(value >> 16)
            self.on_output()
        return offset == 0x18

    def _write_gpioa(self, offset, value):
        return self._write_gpio(0x40020000, offset, value)

    def _write_gpiob(self, offset, value):
        return self._write_gpio(0x40020400, offset, value)

    def levels(self):
        enable = self.reg(0x40020414) & 1 if self.enable_short is None else self.enable_short
        return self.pins & ~1 | enable

    def drives_line(self):
        return self.field(0x40020400, 10, 2) == 1 and self.field(0x40020414, 5, 1) == 1

    def power_is_on(self):
        return self.field(0x40020400, 0, 2) == 1 and self.field(0x40020414, 0, 1) == 1

    def set_pin(self, pin, high):
        before = self.pins
        self.pins = self.pins | 1 << pin if high else self.pins & ~(1 << pin)
        self.bridge.look_at_break()
        if before != self.pins and self.field(0x40013808 + pin // 4 * 4, pin % 4 * 4, 4) == 1:
            self._edge(pin, high)

    def set_supply(self, volts):
        low = self.supply_v < 2.92
        self.supply_v = volts
        if self.field(0x40007000, 4, 1) and low != (volts < 2.92):
            self._edge(16, volts < 2.92)

    def _edge(self, line, rising):
        if self.field(0x40013C08 if rising else 0x40013C0C, line, 1):
            self.registers[0x40013C14] = self.reg(0x40013C14) | 1 << line
            self._request_lines()

    def _request_lines(self):
        lines = self.reg(0x40013C14) & self.reg(0x40013C00)
        for mask, interrupt in ((1 << 1, EXTI1), (0x3F << 10, EXTI15_10), (1 << 16, PVD)):
            if lines & mask:
                self.pended.add(interrupt)

    def _write_exti(self, offset, value):
        if offset == 0x14:
            self.registers[0x40013C14] = self.reg(0x40013C14) & ~value
            for mask, interrupt in ((1 << 1, EXTI1), (0x3F << 10, EXTI15_10), (1 << 16, PVD)):
                if value & mask and interrupt not in self.active:
                    self.pended.discard(interrupt)
        return offset == 0x14

    # timers

    def _timer_count(self, base):
        started = self.timer_started_s.get(base)
        return 0 if started is None else int((self.now_s - started) * self.timer_hz(base))

    def _write_timer(self, base, offset, value):
        if offset == 0x00 and value & 1 and base not in self.timer_started_s:
            self.timer_started_s[base] = self.now_s - self.timer_held_s.pop(base, 0.0)
            if base == 0x40000000:
                left_s, self.tick_left_s = self.tick_left_s, None
                self.tick_due_s = self.now_s + (left_s or (self.reg(base + 0x2C) + 1) / self.timer_hz(base))
                self.next_due_s = self.now_s  # look again at what is due
        if offset == 0x00 and not value & 1 and base in self.timer_started_s:
            self.timer_held_s[base] = self.now_s - self.timer_started_s.pop(base)
            if base == 0x40000000:
                self.tick_left_s, self.tick_due_s = self.tick_due_s - self.now_s, None

    def _write_tim1(self, offset, value):
        return self.bridge.write(offset, value)

    def _read_tim1(self, offset):
        return self.bridge.read(offset)

    def _write_tim2(self, offset, value):
        self._write_timer(0x40000000, offset, value)
        if offset == 0x10:
            self.registers[0x40000010] = self.reg(0x40000010) & value
        return offset == 0x10

    def _write_tim5(self, offset, value):
        self._write_timer(0x40000C00, offset, value)
        return False

    def _read_tim5(self, offset):
        return self._timer_count(0x40000C00) & 0xFFFFFFFF if offset == 0x24 else self.reg(0x40000C00 + offset)

    def _read_tim3(self, offset):
        """Counts as an encoder: both edges of both inputs, which the pins hand on."""
        if offset != 0x24:
            return self.reg(0x40000400 + offset)
        pins = all(self.field(0x40020000, 2 * pin, 2) == 2 and self.field(0x40020020, 4 * pin, 4) == 2 for pin in (6, 7))
        inputs = self.field(0x40000418, 0, 2) == 1 and self.field(0x40000418, 8, 2) == 1 and self.reg(0x40000420) & 0x22 == 0
        counts = self.field(0x40000400, 0, 1) == 1 and self.field(0x40000408, 0, 3) == 3
        return self.encoder % (self.reg(0x4000042C) + 1) if pins and inputs and counts else 0

    def _write_tim11(self, offset, value):
        self._write_timer(0x40014800, offset, value)
        self.captures_s = self.now_s if offset == 0x00 and value & 1 else self.captures_s
        return offset == 0x10

    def _capture_period_s(self):
        """Returns the period of the captures at input 1: the crystal, divided for the RTC and by the prescaler."""
        divider = self.field(RCC + 8, 16, 5)
        wired = self.reg(0x40014850) == 2 and self.field(0x40014818, 0, 2) == 1 and self.reg(0x40014820) & 1
        if not wired or divider < 2 or not self.hse_runs():
            return None
        return divider * (1 << self.field(0x40014818, 2, 2)) / self.crystal_hz

    def _read_tim11(self, offset):
        period_s = self._capture_period_s()
        running = 0x40014800 in self.timer_started_s
        waiting = int((self.now_s - self.captures_s) / period_s) if running and period_s else 0
        if offset == 0x10:
            return (waiting > 0) << 1 | (waiting > 1) << 9
        if offset == 0x34 and waiting:
            self.captures_s += waiting * period_s
            return int((self.captures_s - self.timer_started_s[0x40014800]) * self.timer_hz(0x40014800)) & 0xFFFF
        return self.reg(0x40014800 + offset)

    # converters

    def _write_adc(self, offset, value):
        if offset in (0x00, 0x100):  # what is written as 0 is cleared
            self.bridge.done[offset // 0x100] &= value >> 2 & 1
        if offset == 0x108 and value & 1 << 30 and value & 1:
            assert self.field(RCC + 0x44, 9, 1), "ADC2 has no clock"
            self.adc2_done = self.adc2_works
        if offset == 0x08 and value & 1 << 30 and value & 1:
            self.conversion_due_s = self.now_s + self._conversion_s()
            self.next_due_s = self.now_s
        return False

    def _conversion_s(self):
        cycles = (3, 15, 28, 56, 84, 112, 144, 480)[self.field(0x40012010, 0, 3)] + 12
        rate_hz = self.apb_hz(2) / (2 * (self.field(0x40012304, 16, 2) + 1))
        assert rate_hz <= 36e6, "the converter's clock is too fast"
        return cycles / rate_hz

    def _read_adc(self, offset):
        injected = self.bridge.converted(offset)
        if injected is not None:
            return injected
        if offset == 0x100:  # ADC2: slow against a tick, fast against an access
            return self.adc2_done << 1
        if offset == 0x14C:
            self.adc2_done = False
            return int(self.measured_v[self.reg(0x40012134) - 1] / 3.3 * 4096)
        if offset == 0x4C:
            self.registers[0x40012000] = self.reg(0x40012000) & ~2
            return min(4095, max(0, int(self.sensor_v / 3.3 * 4096)))
        return self.reg(0x40012000 + offset)

    def _write_dac(self, offset, value):
        self.registers[0x40007400 + offset] = value
        self.on_output()
        return True

    def output_code(self):
        """Returns the converter's code; None while it is off."""
        return self.reg(0x40007408) & 0xFFF if self.field(0x40007400, 0, 1) else None

    # flash

    def _in_ram(self):
        return RAM <= self.uc.reg_read(UC_ARM_REG_PC) < RAM + RAM_SIZE

    def _read_flash(self, offset):
        if offset == 0x0C:
            if self.flash_word is not None:  # what was written has cleared bits and set none
                address, value = self.flash_word
                self.uc.mem_write(address, struct.pack("<I", value))
                self.flash_word = None
            busy = self.now_s < self.flash_busy_s
            if busy:
                assert self._in_ram(), "an instruction from flash while it is busy"
                self.now_s += 1e-3 if self.flash_busy_s - self.now_s > 1e-3 else 1e-6
            return busy << 16 | self.flash_errors
        return self.reg(0x40023C00 + offset) | (self.flash_locked << 31 if offset == 0x10 else 0)

    def _write_flash(self, offset, value):
        if offset == 0x04:
            self.flash_keys = 1 if value == 0x45670123 else 2 if value == 0xCDEF89AB and self.flash_keys == 1 else 0
            self.flash_locked = self.flash_locked and self.flash_keys != 2
        if offset == 0x0C:
            self.flash_errors &= ~value
        if offset == 0x10 and value >> 31:
            self.flash_locked = True
        elif offset == 0x10 and not self.flash_locked:
            self.registers[0x40023C10] = value & 0x7FFFFFFF
            if value & 0x10002 == 0x10002:
                assert not self.bridge.is_on(), "flash is erased while the bridge is on"
                sector = value >> 3 & 15
                assert sector in (10, 11) and value >> 8 & 3 == 2, f"flash control {value:#x}"
                if not self.flash_fails:
                    self.uc.mem_write(STORE + (sector - 10) * STORE_SECTOR, b"\xff" * STORE_SECTOR)
                self.flash_busy_s = self.now_s + ERASE_S
        return offset != 0x00

    def _on_flash_write(self, _uc, _access, address, size, value, _user):
        def check():
            assert not self.flash_locked and self.reg(0x40023C10) & 0x301 == 0x201 and size == 4, f"write to {address:#x}"
            assert not self.bridge.is_on(), "flash is written while the bridge is on"
            assert address >= STORE, f"write to the image at {address:#x}"
            assert not self.reg(0xE000ED94) & 1 or address >= STORE
            was = struct.unpack("<I", self.uc.mem_read(address, 4))[0]
            self.flash_word = address, was if self.flash_fails else was & value
            self.flash_busy_s = self.now_s + WRITE_S
        self._guard(check)

    def store(self):
        return bytes(self.uc.mem_read(STORE, 2 * STORE_SECTOR))

    # USART1 and watchdog

    def _read_usart1(self, offset):
        self._receive()
        if offset == 0x00:
            return (self.now_s >= self.sent_s) * 0xC0 | (self.received is not None) << 5 | self.overrun << 3  # TXE and TC, RXNE, ORE
        if offset == 0x04 and self.received is not None:
            byte, self.received, self.overrun = self.received, None, False
            return byte
        return self.reg(0x40011000 + offset)

    def _receive(self):
        while self.incoming and self.incoming[0][0] <= self.now_s:
            _, byte = self.incoming.pop(0)
            self.overrun = self.received is not None
            self.received = self.received if self.overrun else byte

    def _write_usart1(self, offset, value):
        if offset == 0x04:
            baud = self.apb_hz(2) / self.reg(0x40011008)
            self.bad_baud = self.bad_baud or abs(baud / 115200 - 1) > 0.03
            self.log.append(value)
            self.undriven += not self.drives_line()
            self.sent_s = max(self.now_s, self.sent_s) + (0 if self.fast_usart else 10 / baud)
        return False

    def _write_iwdg(self, offset, value):
        if offset == 0 and value == 0xAAAA and self.kicked_s is not None:
            self.longest_wait_s = max(self.longest_wait_s, self.now_s - self.kicked_s)
        if offset == 0 and value in (0xCCCC, 0xAAAA):
            self.kicked_s = self.now_s if value == 0xCCCC or self.kicked_s is not None else None
        return False

    def _watchdog_s(self):
        return (4 << self.reg(0x40003004)) * ((self.reg(0x40003008) or 0xFFF) + 1) / 32000

    # --- the core's own registers ------------------------------------------------------------------------------------

    def _read_core(self, address):
        if 0xE000E100 <= address < 0xE000E180:
            return self._bits(self.enabled, address)
        return self.reg(address)

    @staticmethod
    def _bits(interrupts, address):
        first = (address & 0x7F) // 4 * 32
        return sum(1 << (i - first) for i in interrupts if first <= i < first + 32)

    def _write_core(self, address, size, value):
        if 0xE000E100 <= address < 0xE000E300:
            first = (address & 0x7F) // 4 * 32
            named = {first + i for i in range(32) if value >> i & 1}
            if address < 0xE000E180:
                self.enabled |= named
                self._request_lines()
            elif address < 0xE000E200:
                self.enabled -= named
            elif address >= 0xE000E280:
                self.pended -= named
            return
        if 0xE000E400 <= address < 0xE000E500:
            self.priorities[address - 0xE000E400] = value >> 4
            return
        if address == 0xE000ED0C and value & 4:
            raise Reset(SOFTWARE)
        if address == 0xE000EDA0:
            self.mpu[self.reg(0xE000ED98)] = (self.reg(0xE000ED9C), value)
        if address == 0xE000ED9C and value & 0x10:
            self.registers[0xE000ED98] = value & 0xF
        self.registers[address] = value

    # --- running -----------------------------------------------------------------------------------------------------

    def _on_start(self, *_):
        """The self-test's millions of blocks are behind: from here on an interrupt may end the background at any block."""
        self.started = True
        self.uc.emu_stop()

    def _on_block(self, _uc, _address, size, _user):
        if not self.active:
            self.now_s += BYTE_CYCLES * size * self.cycle_s
        if self.now_s >= self.next_due_s:
            self.uc.emu_stop()

    def _on_wfi(self, *_):
        self.sleeping = True
        self.uc.emu_stop()

    def _on_unmapped(self, _uc, _access, address, _size, _value, _user):
        self.error = self.error or AssertionError(f"access to {address:#x} from {self.uc.reg_read(UC_ARM_REG_PC):#x}")
        return False

    def _emulate(self, pc, count=0):
        try:
            self.uc.emu_start(pc | 1, RETURN, count=count)
        except Exception as error:  # pylint: disable=broad-except
            self.error = self.error or error
        if self.error:
            error, self.error = self.error, None
            raise error
        return self.uc.reg_read(UC_ARM_REG_PC) & ~1

    def functions(self, *names):
        """Start and size of those that there are, with the compiler's parts of them."""
        return [(at & ~1, size) for name, (at, size) in self.sizes.items() if name.split(".")[0] in names and size]

    def keep_argument(self, name):
        """Keeps the first argument of each call of a function in `argument`."""
        at = self.symbols[name] & ~1

        def keep(uc, *_):
            self.argument = uc.reg_read(UC_ARM_REG_R0)

        self.uc.hook_add(UC_HOOK_CODE, keep, begin=at, end=at)

    def count_in(self, *names):
        """Counts the instructions of these functions from now on, in `counted`. Before the first of them runs."""
        for at, size in self.functions(*names):
            self.uc.hook_add(UC_HOOK_CODE, self._on_counted, begin=at, end=at + size - 1)

    def _on_counted(self, *_):
        self.counted += 1

    def emulate_count(self, pc, instructions):
        return self._emulate(pc, instructions)

    def step_to_tick(self):
        """Background and conversions until a tick is about to be entered; false, for run_until."""
        while TIM2 not in self.pended:
            self.now_s = max(self.now_s, min(self._due()))
            self._pass_time()
            number = self.next_interrupt()
            if number is not None and number != TIM2:
                self.interrupt(number)
        return True

    def call(self, function, *arguments, force=None):
        """A function of the image, as if the background called it; returns r0. `force` goes in the first float register."""
        context = self.uc.context_save()
        for register, value in zip((UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_R2, UC_ARM_REG_R3), arguments):
            self.uc.reg_write(register, value & 0xFFFFFFFF)
        if force is not None:
            self.uc.reg_write(UC_ARM_REG_S0, struct.unpack("<I", struct.pack("<f", force))[0])
        self.uc.reg_write(UC_ARM_REG_XPSR, 1 << 24)
        self.uc.reg_write(UC_ARM_REG_LR, RETURN | 1)
        at = self._emulate(self.symbols[function])
        while at != RETURN:  # a timer was started, which looks at what is due
            self.next_due_s = NEVER
            at = self._emulate(at)
        result = self.uc.reg_read(UC_ARM_REG_R0)
        self.uc.context_restore(context)
        return result

    def _is_due(self, interrupt):
        if interrupt not in self.enabled:
            return False
        return not self.active or self.priorities.get(interrupt, 0) < self.priorities.get(self.active[-1], 0)

    def next_interrupt(self):
        masked = self.uc.reg_read(UC_ARM_REG_PRIMASK) & 1
        due = [] if masked else [i for i in self.pended if self._is_due(i)]
        return min(due, key=lambda i: (self.priorities.get(i, 0), i)) if due else None

    def exception(self, number, pc, interrupted=None):
        """Enters exception `number` at `pc` and runs it to its end; `interrupted` is called with the chip at its first instruction."""
        vectors = self.reg(0xE000ED08)
        handler = struct.unpack("<I", self.uc.mem_read(vectors + 4 * number, 4))[0]
        assert handler & 1, f"exception {number}: no handler in the vector table at {vectors:#x}"
        context = self.uc.context_save()
        sp = self.uc.reg_read(UC_ARM_REG_SP)
        frame = (sp - 104) & ~7
        words = [self.uc.reg_read(r) for r in (UC_ARM_REG_R0, UC_ARM_REG_R1, UC_ARM_REG_R2, UC_ARM_REG_R3, UC_ARM_REG_R12,
                                               UC_ARM_REG_LR)] + [pc, 0x01000000]
        self.uc.mem_write(frame, struct.pack("<8I", *words))
        self.uc.reg_write(UC_ARM_REG_SP, frame)
        self.uc.reg_write(UC_ARM_REG_XPSR, 1 << 24 | number)  # out of an IT block, too
        self.uc.reg_write(UC_ARM_REG_LR, RETURN | 1)
        self.now_s += 12 * self.cycle_s
        at = handler & ~1
        if interrupted:
            at = interrupted(at)
        if at != RETURN:
            self._emulate(at)
        self.uc.context_restore(context)

    def interrupt(self, number, interrupted=None):
        self.pended.discard(number)
        self.active.append(number)
        self.exception(16 + number, self.pc, interrupted)
        self.active.pop()
        self._request_lines()

    def _pass_time(self):
        """What has become due by now."""
        if self.tick_due_s is not None and self.now_s >= self.tick_due_s:
            self.on_tick()
            self.tick_count += 1
            self.tick_due_s += (self.reg(0x4000002C) + 1) / self.timer_hz(0x40000000)
            self.registers[0x40000010] = self.reg(0x40000010) | 1
            if self.reg(0x4000000C) & 1:
                self.pended.add(TIM2)
        if self.conversion_due_s is not None and self.now_s >= self.conversion_due_s:
            self.conversion_due_s += self._conversion_s()
            self.registers[0x40012000] = self.reg(0x40012000) | 2
            if self.reg(0x40012004) & 1 << 5:
                self.pended.add(ADC)
        self.bridge.advance()
        self._receive()
        if self.received is not None and self.field(0x4001100C, 5, 1):
            self.pended.add(USART1)
        if self.kicked_s is not None and self.now_s - self.kicked_s > self._watchdog_s():
            raise Reset(WATCHDOG)

    def _due(self):
        arrival_s = self.incoming[0][0] if self.incoming else None
        return [t for t in (self.tick_due_s, self.conversion_due_s, arrival_s, self.bridge.due_s()) if t is not None]

    def _run_background(self, until_s):
        self.next_due_s = min([until_s, *self._due()])
        self.pc = self._emulate(self.pc)
        self.next_due_s = NEVER
        if self.started and self.start_hook is not None:
            self.uc.hook_del(self.start_hook)
            self.start_hook = None
            self.uc.ctl_remove_cache(FLASH, FLASH + FLASH_SIZE)
            self.uc.hook_add(UC_HOOK_BLOCK, self._on_block)

    def run(self, seconds):
        """Background and interrupts for this long."""
        until_s = self.now_s + seconds
        while self.now_s < until_s:
            self._pass_time()
            number = self.next_interrupt()
            if number is not None:
                self.sleeping = False
                self.interrupt(number)
            elif self.sleeping:
                self.now_s = max(self.now_s, min([until_s, *self._due()]))
            else:
                self._run_background(until_s)
                if self.sleeping:
                    self.pc += 2  # behind the WFI

    def run_until(self, condition, seconds):
        until_s = self.now_s + seconds
        while not condition():
            assert self.now_s < until_s, f"not within {seconds} s; log: {self.text()}"
            self.run(0.0005)

    def text(self):
        return self.log.decode("ascii", "replace")

    def lines(self):
        return self.text().splitlines()

    def send(self, text):
        """To the chip, at 115200 baud."""
        at_s = max(self.now_s, self.incoming[-1][0] if self.incoming else 0.0)
        for number, byte in enumerate(text if isinstance(text, bytes) else text.encode()):
            self.incoming.append((at_s + (number + 1) * 10 / 115200, byte))

    def ram(self):
        return bytes(self.uc.mem_read(RAM, RAM_SIZE))
