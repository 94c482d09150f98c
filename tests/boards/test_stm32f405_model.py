"""The STM32F405's image on a model of the chip's registers: from power-up to RUN, in a closed loop through the codes of the converters,
and through everything that resets or stops it."""

import math
import os
import pathlib
import struct
import subprocess
import sys

import pytest
import stm32f405_model as model
from elftools.elf.elffile import ELFFile

TREE = pathlib.Path(os.environ["TRIBO_TREE"])
RIG = os.environ["TRIBO_RIG"]
SEAL = pathlib.Path(__file__).parents[2] / "firmware" / "tools" / "seal_image.py"
ZERO = 2048  # code of no current
STOP_PIN, READY_PIN, FAULT_PIN = 1, 8, 12

arithmetics = pytest.mark.parametrize("arithmetic", ["f32", "q31"])


def bits(x):
    return struct.unpack("<I", struct.pack("<f", x))[0]


def image_of(arithmetic):
    return TREE / "firmware" / f"tribo-stm32f405-{arithmetic}.elf"


class Bench:
    """A chip with the paper's plant at its converters."""

    def __init__(self, arithmetic, **of_chip):
        self.arithmetic = arithmetic
        self.chip = model.Chip(of_chip.pop("image", image_of(arithmetic)), **of_chip)
        self.chip.keep_argument("drive_tick")
        self.plant = subprocess.Popen([RIG], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.force_n = 0.0
        self.command_wire = self.sensor_wire = True
        self.chip.on_tick = self.tick
        self.before_tick = lambda: None

    def current_n(self):
        code = self.chip.output_code()
        if not self.chip.power_is_on() or code is None:
            return 0.0
        return (code - ZERO) / ZERO * 2.0 if self.command_wire else -2.0  # an open input reads 0 V

    def tick(self):
        self.plant.stdin.write(struct.pack("<d", self.current_n()))
        self.plant.stdin.flush()
        shown_n, self.force_n = struct.unpack("<2d", self.plant.stdout.read(16))
        self.chip.sensor_v = 1.65 + 0.66 * shown_n if self.sensor_wire else 0.0
        self.before_tick()

    def refer(self, r_n):
        drive = self.chip.argument  # of the last tick
        if self.arithmetic == "f32":
            self.chip.call("drive_set_reference", drive, force=r_n)
        else:
            self.chip.call("drive_set_reference", drive, int(r_n / 4.0 * 2**31))

    def is_off(self):
        return not self.chip.power_is_on() and self.chip.output_code() == ZERO

    def wait_for(self, words, seconds=0.3):
        self.chip.run_until(lambda: words in self.chip.text(), seconds)

    def command(self, text, words, seconds=0.3):
        """Sends a line and waits for `words` in what is logged after it."""
        before = len(self.chip.log)
        self.chip.send(text)
        self.chip.run_until(lambda: words in self.chip.log[before:].decode(), seconds)

    def run(self, r_n=0.5):
        self.wait_for("idle at tick")
        self.chip.run(0.01)
        self.refer(r_n)
        self.command("start\n", "run at tick")

    def close(self):
        self.plant.kill()
        self.plant.communicate()


def with_noise(board):
    """Adds noise of one code, so that the sensor is not stuck."""
    def add():
        board.chip.sensor_v += 0.002 * (board.chip.tick_count % 2)
    board.before_tick = add
    return board


@pytest.fixture
def bench():
    benches = []

    def open_bench(arithmetic="f32", **of_chip):
        benches.append(Bench(arithmetic, **of_chip))
        return benches[-1]

    yield open_bench
    for one in benches:
        one.close()


def changed_image(tmp_path, arithmetic="f32", bypass=0, image=None, **fields):
    """The image with other values in its rig_config and clock_hse_bypass, sealed again. A field is its place in the list of app/config.h."""
    image = image or image_of(arithmetic)
    content = bytearray(image.read_bytes())
    with open(image, "rb") as file:
        elf = ELFFile(file)

        def offset_of(name):
            symbol = elf.get_section_by_name(".symtab").get_symbol_by_name(name)[0]
            section = elf.get_section(symbol["st_shndx"])
            return section["sh_offset"] + symbol["st_value"] - section["sh_addr"]

        start, bypass_at = offset_of("rig_config"), offset_of("clock_hse_bypass")
    names = (pathlib.Path(__file__).parents[2] / "firmware/app/config.h").read_text().split("#define DRIVE_CONFIG_FIELDS")[1]
    names = [line.split(",")[1].strip() for line in names.split("typedef")[0].splitlines() if line.strip().startswith("FIELD(")]
    for name, value in fields.items():
        struct.pack_into("<I", content, start + 4 * names.index(name), value)
    struct.pack_into("<I", content, bypass_at, bypass)
    path = tmp_path / "changed.elf"
    path.write_bytes(content)
    subprocess.run([sys.executable, SEAL, path], check=True)
    return path


# --- from power-up to RUN ---------------------------------------------------------------------------------------------


@arithmetics
def test_boot_reports_reset_clock_and_what_is_off_and_waits_in_idle(bench, arithmetic):
    board = bench(arithmetic)
    board.wait_for("latest 0 us\n")
    lines = board.chip.lines()
    assert lines[:2] == [f"tribo {arithmetic}, self-test passed", "reset: power-on"]
    assert lines[2].startswith("clock: 168 MHz from HSE, HSE ")
    assert abs(int(lines[2].split()[-2]) - 8000) < 50
    assert lines[3] == "params: empty"
    assert lines[4] == "off: ready_ms over_current_a bus_low_v bus_high_v temperature_max_c speed_max_units_per_s"
    assert lines[5].startswith("idle at tick ")
    assert board.is_off()
    assert not board.chip.bad_baud
    assert board.chip.reg(0xE000ED08) == board.chip.symbols["vectors"]  # VTOR: the boot loader's was another


@arithmetics
def test_drive_tracks_the_triangle_through_codes(bench, arithmetic):
    """0.4 to 0.6 N in a second and back."""
    board = bench(arithmetic)
    board.run(0.4)
    chip = board.chip
    start = chip.tick_count
    errors, codes = [], set()

    def reference(tick):
        phase = (tick - start) / 1000.0 % 2.0
        return 0.4 + 0.2 * (phase if phase < 1.0 else 2.0 - phase)

    def observe():
        errors.append(reference(chip.tick_count) - board.force_n)
        codes.add(chip.output_code())

    board.before_tick = observe
    while chip.tick_count < start + 1400:
        board.refer(reference(chip.tick_count))
        chip.run(0.001)
    late = errors[300:]
    rms = math.sqrt(sum(e * e for e in late) / len(late))
    print(f"{arithmetic}: {len(late)} ticks, rms of r - F {1000 * rms:.2f} mN, largest {1000 * max(map(abs, late)):.1f} mN")
    assert rms < 0.012
    assert len(codes) > 100
    assert "fault" not in chip.text()
    board.command("?\n", " us\n")
    longest_us = int(chip.lines()[-1].split("longest tick ")[1].split()[0])
    assert longest_us <= 250
    board.command("x", "idle at tick")
    assert board.is_off()


def test_ticks_come_at_1_khz_of_the_crystal(bench, tmp_path):
    for crystal_mhz in (4, 8, 12, 25, 26):
        board = bench(image=changed_image(tmp_path, crystal_hz=crystal_mhz * 10**6), crystal_hz=crystal_mhz * 10**6)
        board.wait_for("idle at tick")
        assert "168 MHz from HSE" in board.chip.text()
        assert abs(board.chip.system_hz() - 168e6) < 1
        before_s, before = board.chip.now_s, board.chip.tick_count
        board.chip.run(0.05)
        assert abs((board.chip.tick_count - before) / (board.chip.now_s - before_s) - 1000) < 25
        assert not board.chip.bad_baud


# --- the clock --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("crystal_mhz", [4, 6, 12, 16, 25])
def test_another_crystal_than_the_configs_is_a_fault_for_good(bench, crystal_mhz):
    board = bench(crystal_hz=crystal_mhz * 10**6)
    board.wait_for("fault: clock since tick 0")
    assert "168 MHz from HSI, wrong HSE" in board.chip.text()
    assert not board.chip.bad_baud  # it can still say so
    board.command("ack\n?\n", "fault: clock")
    board.command("start\n?\n", "fault: clock")
    assert board.is_off()


@pytest.mark.parametrize("error", [-0.04, 0.04])
def test_an_internal_oscillator_that_is_off_by_4_percent_finds_the_crystal(bench, error):
    board = bench(hsi_hz=16e6 * (1 + error))
    board.wait_for("idle at tick")
    assert "168 MHz from HSE" in board.chip.text()


def test_without_a_crystal_the_clock_is_a_fault_unless_allowed(bench, tmp_path):
    board = bench(crystal_hz=0)
    board.wait_for("fault: clock since tick 0")
    assert "168 MHz from HSI, no HSE, HSE 0 kHz" in board.chip.text()
    allowed = bench(crystal_hz=0, image=changed_image(tmp_path, degraded_clock=1))
    allowed.run()
    assert "168 MHz from HSI, no HSE" in allowed.chip.text()
    wrong = bench(crystal_hz=12e6, image=changed_image(tmp_path, degraded_clock=1))
    wrong.wait_for("fault: clock since tick 0")


LEFT_BY_A_BOOT_LOADER = [0x83, 0x83 | 1 << 16, 0x83 | 1 << 16 | 1 << 18]  # RCC_CR: HSE off, on, bypassed


@pytest.mark.parametrize("control", LEFT_BY_A_BOOT_LOADER)
@arithmetics
def test_a_clock_at_osc_in_is_the_crystals(bench, tmp_path, arithmetic, control):
    board = bench(image=changed_image(tmp_path, arithmetic, bypass=1), clock_at_osc_in=True, control=control)
    board.wait_for("idle at tick")
    assert "168 MHz from HSE" in board.chip.text()
    assert board.chip.field(model.RCC, 18, 1) == 1 and board.chip.field(model.RCC, 19, 1) == 1  # HSEBYP, CSSON
    assert abs(board.chip.system_hz() - 168e6) < 1
    assert not board.chip.bad_baud


@pytest.mark.parametrize("control", LEFT_BY_A_BOOT_LOADER)
@arithmetics
def test_a_crystal_is_not_bypassed(bench, arithmetic, control):
    board = bench(arithmetic, control=control)
    board.wait_for("idle at tick")
    assert "168 MHz from HSE" in board.chip.text()
    assert board.chip.field(model.RCC, 18, 1) == 0 and board.chip.field(model.RCC, 19, 1) == 1


@pytest.mark.parametrize("of_chip, words", [
    ({"crystal_hz": 0}, "no HSE, HSE 0 kHz"), ({"crystal_hz": 12e6}, "wrong HSE"), ({"clock_at_osc_in": False}, "no HSE, HSE 0 kHz")])
def test_a_clock_at_osc_in_that_is_missing_or_another_is_a_fault(bench, tmp_path, of_chip, words):
    board = bench(image=changed_image(tmp_path, bypass=1), **{"clock_at_osc_in": True, **of_chip})
    board.wait_for("fault: clock since tick 0")
    assert f"168 MHz from HSI, {words}" in board.chip.text()


def test_a_pll_that_does_not_lock_is_a_fault(bench):
    board = bench(pll_locks=False)
    board.wait_for("fault: clock since tick 0", 1.0)
    assert "16 MHz from HSI, no PLL" in board.chip.text()
    assert not board.chip.bad_baud


# --- stops ------------------------------------------------------------------------------------------------------------


def stop_within_a_tick(board, pin, interrupt, instructions):
    """Makes the pin active after so many instructions of a tick. Returns the instructions from the interrupt to outputs off."""
    chip = board.chip
    seen = {"off": None}

    def output():
        if seen["off"] is None and board.is_off():
            seen["off"] = chip.counted

    def interrupted(at):
        at = chip.emulate_count(at, instructions)
        chip.on_output = output
        chip.counted = 0
        chip.set_pin(pin, True)
        assert chip.next_interrupt() == interrupt
        nested = chip.pc
        chip.pc = at
        chip.interrupt(interrupt)
        chip.pc = nested
        assert board.is_off()
        chip.on_output = lambda: None
        return at

    chip.run_until(lambda: model.TIM2 in chip.pended and not chip.active or chip.step_to_tick(), 0.01)
    chip.sleeping = False
    chip.interrupt(model.TIM2, interrupted)
    return seen["off"]


CYCLES_AN_INSTRUCTION = 8  # at most: five wait states of flash, and a write to a bus at a quarter of the clock


@pytest.mark.parametrize("pin, interrupt, words", [(STOP_PIN, model.EXTI1, "fault: emergency stop"),
                                                   (FAULT_PIN, model.EXTI15_10, "fault: power stage")])
def test_a_stop_at_50_instructions_of_a_tick_turns_the_outputs_off_within_20_us(bench, pin, interrupt, words):
    board = with_noise(bench())
    chip = board.chip
    chip.count_in("EXTI1_IRQHandler", "EXTI15_10_IRQHandler", "board_off", "trip")
    board.run()
    chip.fast_usart = True
    worst = 0
    for number in range(50):
        count = stop_within_a_tick(board, pin, interrupt, 1 + 13 * number)
        assert count >= 4
        worst = max(worst, count)
        assert board.is_off(), "the tick that was interrupted turned them on again"
        chip.set_pin(pin, False)  # a pulse: only the interrupt has seen it
        board.wait_for(words)
        board.command("ack\n", "idle at tick")
        chip.log.clear()
        board.refer(0.5)
        board.command("start\n", "run at tick")
        chip.log.clear()
    us = (12 + worst * CYCLES_AN_INSTRUCTION) / 168
    print(f"{words}: outputs off at most {worst} instructions after the interrupt, {us:.1f} us at 8 cycles each")
    assert us <= 20


def test_a_stop_that_is_open_from_the_start_is_found_by_the_tick(bench):
    board = bench()
    board.chip.set_pin(STOP_PIN, True)
    board.wait_for("fault: emergency stop since tick 1")
    board.command("ack\n?\n", "fault: emergency stop")
    board.chip.set_pin(STOP_PIN, False)
    board.command("ack\n", "idle at tick")


def test_an_input_that_bounces_does_not_starve_the_tick(bench):
    board = bench()
    board.run()
    chip = board.chip
    before = chip.tick_count
    for number in range(400):
        chip.set_pin(STOP_PIN, number % 2 == 0)
        chip.run(20e-6)
    chip.set_pin(STOP_PIN, False)
    chip.run(0.02)
    assert chip.tick_count > before + 20
    assert "tick" not in chip.text().split("fault: ")[1].split(" since")[0]
    assert board.is_off()


def test_a_low_supply_turns_the_outputs_off_and_is_reported(bench):
    board = bench()
    board.run()
    board.chip.set_supply(2.8)
    board.chip.run(20e-6)
    assert board.is_off()
    board.wait_for("fault: supply")
    board.command("ack\n?\n", "fault: supply")
    board.chip.set_supply(3.3)
    board.command("ack\n", "idle at tick")


@pytest.mark.parametrize("level", [0, 1])
def test_the_power_stages_levels_are_the_configs(bench, tmp_path, level):
    image = changed_image(tmp_path, fault_level=level, ready_level=level, ready_ms=20)
    board = bench(image=image)
    chip = board.chip
    chip.set_pin(FAULT_PIN, level == 0)
    chip.set_pin(READY_PIN, level == 0)  # not ready
    pulls = lambda pin: chip.field(0x4002040C, 2 * pin, 2)
    board.wait_for("idle at tick")
    assert pulls(FAULT_PIN) == (1 if level else 2)  # an open wire is a fault ...
    assert pulls(READY_PIN) == (2 if level else 1)  # ... and not ready
    chip.log.clear()
    board.refer(0.5)
    board.command("start\n", "starting at tick")
    assert chip.power_is_on() and chip.output_code() == ZERO
    chip.set_pin(READY_PIN, level == 1)
    board.wait_for("run at tick")
    chip.set_pin(FAULT_PIN, level == 1)
    chip.run(20e-6)
    assert board.is_off()
    board.wait_for("fault: power stage since")


def test_an_enable_that_reads_back_otherwise_is_a_fault(bench):
    board = bench()
    board.run()
    board.chip.enable_short = 0
    board.chip.run(0.003)
    assert board.is_off()
    board.wait_for("fault: power stage since")
    board.chip.enable_short = None
    board.command("ack\n", "idle at tick")
    board.chip.run(0.05)
    board.chip.enable_short = 1  # on, though nobody has asked for it
    board.wait_for("fault: power stage since")


def test_a_ready_output_must_fall_once_the_stage_is_off(bench, tmp_path):
    board = with_noise(bench(image=changed_image(tmp_path, ready_ms=20)))
    chip = board.chip
    board.wait_for("idle at tick")
    board.refer(0.5)
    chip.send("start\n")
    chip.run_until(chip.power_is_on, 0.3)
    chip.set_pin(READY_PIN, True)
    board.wait_for("run at tick")
    board.command("x\n", "idle at tick")
    chip.run(0.08)
    assert "fault" not in chip.text()
    board.wait_for("fault: power stage since")  # 100 ms after it was turned off
    chip.set_pin(READY_PIN, False)
    board.command("ack\n", "idle at tick")
    chip.run(0.2)
    assert chip.text().count("fault") == 1


@pytest.mark.parametrize("place, volts, words", [
    (0, 1.65 + 0.2 * 3.2, "over-current"), (0, 1.65 - 0.2 * 3.2, "over-current"), (1, 17.0 / 20, "bus voltage"),
    (1, 31.0 / 20, "bus voltage"), (2, 0.85, "temperature"), (None, None, "over-current")])
def test_what_the_power_stage_shows_stops_the_drive(bench, tmp_path, place, volts, words):
    image = changed_image(tmp_path, over_current_a=bits(3.0), bus_low_v=bits(18.0), bus_high_v=bits(30.0), temperature_max_c=bits(80.0),
                          temperature_ms=50)
    board = bench(image=image)
    board.run()
    board.chip.run(0.2)
    assert "fault" not in board.chip.text()
    if place is None:
        board.chip.adc2_works = False
    else:
        board.chip.measured_v[place] = volts
    board.wait_for(f"fault: {words} since")
    assert board.is_off()


@pytest.mark.parametrize("direction", [1, -1])
def test_an_arm_that_is_too_fast_stops_the_drive(bench, tmp_path, direction):
    """Edges of the encoder, 2 a millisecond allowed; the counter passes its end."""
    board = bench(image=changed_image(tmp_path, speed_max_units_per_s=bits(2000.0)))
    chip, speed = board.chip, 1

    def move():
        chip.encoder += direction * speed

    chip.encoder = 0x10000 - 300 * direction
    board.before_tick = move
    board.run()
    chip.run(0.4)
    assert "fault" not in chip.text() and chip.power_is_on()
    speed = 4
    begun = chip.tick_count
    board.wait_for("fault: arm too fast since")
    assert board.is_off()
    assert chip.tick_count - begun < 60  # twice speed_ms at most, and the message


def test_bytes_are_sent_with_the_line_driven_and_the_line_is_left_after_them(bench):
    board = with_noise(bench())
    board.wait_for("latest 0 us\n")
    chip = board.chip
    chip.run(0.005)
    assert chip.undriven == 0 and not chip.drives_line()
    before = len(chip.log)
    request = struct.pack(">BBHH", 1, 3, 0, 20)  # an answer of 45 bytes: 3.9 ms
    chip.send(request + struct.pack("<H", crc16(request)))
    chip.run_until(chip.drives_line, 0.05)
    chip.run_until(lambda: len(chip.log) >= before + 20, 0.05)
    assert chip.drives_line()
    chip.run_until(lambda: not chip.drives_line(), 0.05)
    assert len(chip.log) == before + 45 and chip.undriven == 0
    assert 0 <= chip.now_s - chip.sent_s < 0.001


def test_broken_wires_stop_the_drive(bench):
    for wire, words in (("sensor_wire", "fault: sensor out of range"), ("command_wire", "fault: ")):
        board = bench()
        board.run()
        board.chip.run(0.3)
        setattr(board, wire, False)
        broken_s = board.chip.now_s
        board.chip.run_until(board.is_off, 0.2)
        print(f"{wire} open: off after {1000 * (board.chip.now_s - broken_s):.0f} ms")
        board.wait_for(words)
        print(board.chip.lines()[-1])


def test_a_converter_that_stops_is_a_silent_sensor(bench):
    board = bench()
    board.run()
    board.chip.conversion_due_s = None
    board.wait_for("fault: sensor silent since tick")
    assert board.is_off()


def test_a_low_supply_of_a_running_chip_is_reported(bench):
    board = bench(options=0x0FFFAAED)  # as it comes from the factory: none
    board.wait_for("fault: brown-out level since tick 0")
    assert board.is_off()
    board.command("ack\n", "idle at tick")


# --- resets -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("flags, cause, state", [
    (model.POWER_ON, "power-on", "idle at"), (model.PIN, "pin", "idle at"),
    (model.BROWN_OUT, "low supply", "fault: reset by a low supply"),
    (model.WATCHDOG, "watchdog", "fault: reset by the watchdog"), (model.SOFTWARE, "software", "fault: reset by software")])
def test_causes_of_resets_are_distinguished(bench, flags, cause, state):
    board = bench(flags=flags)
    board.wait_for(state)
    assert f"reset: {cause}\n" in board.chip.text()
    assert board.chip.reg(model.RCC + 0x74) == 0  # the next one shows its own
    if state != "idle at":
        board.command("ack\n", "idle at tick")


def reset_of(chip, number, pc):
    with pytest.raises(model.Reset) as reset:
        chip.exception(number, pc)
    return reset.value.args[0]


def test_a_hard_fault_is_reported_with_its_address(bench):
    board = bench()
    board.run()
    board.chip.registers[0xE000ED28] = 1 << 9  # CFSR: a bus fault
    flags = reset_of(board.chip, model.HARD_FAULT, 0x08001234)
    assert board.is_off()
    again = bench(flags=flags, ram=board.chip.ram())
    again.wait_for("fault: reset after an exception")
    assert "reset: exception 3 at 08001234, status 00000200" in again.chip.text()
    third = bench(flags=model.PIN, ram=again.chip.ram())  # it is told once
    third.wait_for("idle at tick")


def test_an_interrupt_without_a_handler_is_reported(bench):
    board = bench()
    board.run()
    flags = reset_of(board.chip, 16 + 50, 0x08002468)
    again = bench(flags=flags, ram=board.chip.ram())
    again.wait_for("fault: reset after an exception")
    assert "reset: exception 66 at 08002468" in again.chip.text()


def test_a_stack_that_is_lost_has_no_address(bench):
    board = bench()
    board.run()
    board.chip.registers[0xE000ED28] = 1 << 4  # the frame could not be pushed
    again = bench(flags=reset_of(board.chip, model.HARD_FAULT, 0x08001234), ram=board.chip.ram())
    again.wait_for("fault: reset after an exception")
    assert "at 00000000, status 00000010" in again.chip.text()


def test_a_stopped_crystal_is_reported_and_then_missing(bench, tmp_path):
    image = changed_image(tmp_path, degraded_clock=1)
    board = bench(image=image)
    board.run()
    board.chip.registers[model.RCC + 0x0C] = 1 << 7
    flags = reset_of(board.chip, model.NMI, 0x08001234)
    assert board.is_off()
    again = bench(image=image, flags=flags, ram=board.chip.ram(), crystal_hz=0)
    again.wait_for("fault: reset after the crystal stopped")
    assert "reset: crystal stopped\n" in again.chip.text()


def test_a_tick_that_hangs_ends_in_the_watchdog(bench):
    board = bench()
    board.run()
    board.chip.enabled.discard(model.TIM2)
    with pytest.raises(model.Reset) as reset:
        board.chip.run(0.1)
    assert reset.value.args[0] == model.WATCHDOG


# --- memory protection ------------------------------------------------------------------------------------------------


def regions(chip):
    """Start, end, access and subregions left out of the MPU's regions."""
    found = {}
    for number, (base, attributes) in chip.mpu.items():
        size = 2 << (attributes >> 1 & 31)
        assert attributes & 1 and base & ~31 & (size - 1) == 0
        found[number] = (base & ~31, (base & ~31) + size, attributes >> 24 & 7, attributes >> 8 & 255)
    return found


def test_the_mpu_guards_the_stack_and_flash(bench):
    chip = bench().chip
    chip.run_until(lambda: chip.reg(0xE000ED94) == 5, 0.3)  # on, with the default map for the rest; off in the hard fault's handler
    seen = regions(chip)
    flash, ram, guard = (seen[number] for number in range(3))
    assert flash == (model.FLASH, model.FLASH + model.FLASH_SIZE, 6, 0xC0)  # read only, but for the last two of 128 KiB
    assert chip.symbols["store_start"] == model.FLASH + model.FLASH_SIZE // 8 * 6
    assert ram == (model.RAM, model.RAM + model.RAM_SIZE, 3, 0)
    assert guard == (chip.symbols["stack_guard"], chip.symbols["stack_guard"] + 256, 0, 0)
    assert chip.symbols["stack_top"] - guard[1] >= chip.symbols["stack_size"]
    assert chip.symbols["bss_end"] <= guard[0]


# --- the bus, and params in flash -------------------------------------------------------------------------------------


def ask(board, request, seconds=0.02):
    """The answer to a Modbus request, both without their CRC, which is checked."""
    board.chip.fast_usart = True
    before = len(board.chip.log)
    board.chip.send(request + struct.pack("<H", crc16(request)))
    board.chip.run(seconds)
    answer = bytes(board.chip.log[before:])
    assert len(answer) >= 4 and crc16(answer) == 0, answer
    return answer[:-2]


def crc16(content):
    crc = 0xFFFF
    for byte in content:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return crc


GAIN, SECTION_COUNT, SECTIONS, STORE_STATE, OUTCOME, ACTIVE = 0x1108, 0x1128, 0x1300, 0x1C, 0x1E, 0x1000


def read_word(board, address):
    return struct.unpack(">I", ask(board, struct.pack(">BBHH", 1, 3, address, 2))[3:])[0]


def command(board, number, seconds=0.02):
    ask(board, struct.pack(">BBHH", 1, 6, 0x100, number), seconds)


def write_gain(board, gain):
    ask(board, struct.pack(">BBHHBf", 1, 16, GAIN, 2, 4, gain))
    command(board, 5, 0.2)  # in Q31 the set-up takes 50 ms
    assert read_word(board, GAIN + ACTIVE) == struct.unpack(">I", struct.pack(">f", gain))[0]


@arithmetics
def test_params_are_saved_in_flash_and_are_those_of_the_next_power_up(bench, arithmetic):
    board = with_noise(bench(arithmetic))
    board.wait_for("latest 0 us\n")
    write_gain(board, 0.5)
    command(board, 8, 1.2)  # a second of erasure, with the watchdog at 30 ms
    assert read_word(board, OUTCOME) == 0
    assert read_word(board, 0x06) == 0  # still idle: the drive's time stood still
    again = with_noise(bench(arithmetic, store=board.chip.store()))
    again.wait_for("params: read\n")
    again.wait_for("latest 0 us\n")
    assert read_word(again, GAIN + ACTIVE) == 0x3F000000
    write_gain(again, 0.25)  # into the other sector
    command(again, 8, 1.2)
    assert again.chip.store()[:8] == bytes(8) and again.chip.store()[STORE_SECTOR:STORE_SECTOR + 4] == b"RRUC"


STORE_SECTOR = model.STORE_SECTOR


@pytest.mark.parametrize("clock", ["168 MHz", "16 MHz"])
@arithmetics
def test_the_slowest_params_are_applied_while_the_watchdog_is_kicked(bench, tmp_path, arithmetic, clock):
    """Four sections with zeros and poles at 1e-4 and less of a tick, whose responses last for 1e5 ticks and more."""
    pll_locks = clock == "168 MHz"
    board = with_noise(bench(arithmetic, image=changed_image(tmp_path, arithmetic, degraded_clock=1), pll_locks=pll_locks))
    board.wait_for("idle at tick")
    board.chip.run(0.02)
    ask(board, struct.pack(">BBHHBI", 1, 16, SECTION_COUNT, 2, 4, 4))
    for i, (zero, pole) in enumerate([(1e-4, 2e-4), (3e-4, 1e-4), (2e-4, 3e-4), (1e-4, 5e-5)]):
        section = 1.0, 0.5 + zero, 0.5 * zero, 0.6 + pole, 0.6 * pole
        ask(board, struct.pack(">BBHHB5f", 1, 16, SECTIONS + 10 * i, 10, 20, *section))
    chip = board.chip
    chip.longest_wait_s = 0.0
    before, begun_s = len(chip.log), chip.now_s
    request = struct.pack(">BBHH", 1, 6, 0x100, 5)
    chip.send(request + struct.pack("<H", crc16(request)))
    chip.run_until(lambda: len(chip.log) >= before + 8, 5.0)  # the whole answer
    print(f"{arithmetic}, {clock}: applied in {1e3 * (chip.now_s - begun_s):.0f} ms, kicked every {1e3 * chip.longest_wait_s:.1f} ms at least")
    assert read_word(board, OUTCOME) == 0
    assert read_word(board, SECTION_COUNT + ACTIVE) == 4
    assert chip.longest_wait_s <= 0.010


def test_a_line_of_text_is_taken_at_whatever_time_of_a_tick_it_comes(bench):
    board = bench()
    board.wait_for("latest 0 us\n")
    for _ in range(100):
        board.chip.run(0.003 + 10e-6)
        board.command("?\n", " us\n", 0.03)


def test_text_that_comes_while_the_log_is_written_is_taken_or_stops_the_drive(bench):
    """A report takes 6 ms and more, longer than a line and the silence behind it."""
    board = with_noise(bench())
    board.run()
    chip = board.chip
    for wait_ms in range(8):
        before = len(chip.log)
        chip.send("?\n")
        chip.run_until(lambda: len(chip.log) > before, 0.03)
        chip.send("+++++++\n")
        chip.run(0.001 * wait_ms)
        chip.send("x")
        chip.run_until(board.is_off, 0.05)
        chip.run(0.02)
        chip.log.clear()
        board.refer(0.5)
        board.command("\nstart\n", "run at tick")  # where bytes were lost, the rest of their line is ignored
        chip.log.clear()


def test_flash_that_cannot_be_written_is_reported(bench):
    board = with_noise(bench())
    board.wait_for("latest 0 us\n")
    board.chip.flash_fails = True
    write_gain(board, 0.5)
    command(board, 8, 1.2)
    assert read_word(board, OUTCOME) == 5
    assert read_word(board, STORE_STATE) == 4


def test_damaged_params_are_reported_and_need_a_new_set(bench):
    board = with_noise(bench())
    board.wait_for("latest 0 us\n")
    command(board, 8, 1.2)
    store = bytearray(board.chip.store())
    store[100] ^= 1
    again = with_noise(bench(store=bytes(store)))
    again.wait_for("params: damaged\n")
    again.wait_for("fault: saved params damaged since tick 0 at tick 4, longest tick 0 us, latest 0 us\n")
    again.chip.send("ack\nstart\n")
    again.chip.run(0.1)
    assert again.is_off() and read_word(again, 0x06) == 2


def test_after_a_frame_text_is_no_command(bench):
    board = with_noise(bench())
    board.wait_for("latest 0 us\n")
    lists = (pathlib.Path(__file__).parents[2] / "firmware" / "app" / "registers.h").read_text()
    assert f"#define REGISTERS_VERSION {read_word(board, 0x00)}u" in lists
    board.chip.send("start\n")
    board.chip.run(0.1)
    assert read_word(board, 0x06) == 0
    board.refer(0.2)
    command(board, 1)
    assert read_word(board, 0x06) == 1
    board.chip.send("x")
    board.chip.run(0.1)
    assert read_word(board, 0x06) == 1
    command(board, 2)
    assert board.is_off()
