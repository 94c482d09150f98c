"""The STM32F405's image that is the bridge itself, on the model of the chip's registers with switches, a winding and the paper's rig behind
them: the current loop, and that whatever breaks turns all switches off. The model checks each edge of each switch."""

import os
import pathlib
import struct

import pytest
import stm32f405_model as model
from bridge_model import NEVER
from test_stm32f405_model import Bench, changed_image, with_noise

TREE = pathlib.Path(os.environ["TRIBO_TREE"])
STOP_PIN, FAULT_PIN = 1, 12
DEAD_NS = 500

arithmetics = pytest.mark.parametrize("arithmetic", ["f32", "q31"])


def image_of(arithmetic="f32"):
    return TREE / "firmware" / f"tribo-stm32f405-bridge-{arithmetic}.elf"


def bits(x):
    return struct.unpack("<I", struct.pack("<f", x))[0]


class BridgeBench(Bench):
    """A chip with a winding that pushes the paper's rig with 1 N/A."""

    def __init__(self, arithmetic="f32", **of_chip):
        of_chip.setdefault("image", image_of(arithmetic))
        super().__init__(arithmetic, **of_chip)
        self.bridge = self.chip.bridge
        self.motor_n_per_a = 1.0
        with_noise(self)

    def current_n(self):
        return self.motor_n_per_a * self.bridge.mean_a(1e-3)

    def is_off(self):
        return not self.chip.power_is_on() and not self.bridge.is_on()


@pytest.fixture
def bench():
    benches = []

    def open_bench(*arguments, **of_chip):
        benches.append(BridgeBench(*arguments, **of_chip))
        return benches[-1]

    yield open_bench
    for one in benches:
        one.close()


def test_nothing_switches_before_a_start_and_the_timer_is_set_for_good(bench):
    board = bench()
    board.wait_for("latest 0 us\n")
    board.chip.run(0.02)
    bridge, chip = board.bridge, board.chip
    assert "off: speed_max_units_per_s" in chip.text()
    assert board.is_off() and [leg.edges for leg in bridge.legs] == [0, 0] and bridge.current_a == 0.0
    periods, now_s = bridge.periods, chip.now_s
    chip.run(0.1)
    assert abs((bridge.periods - periods) / (chip.now_s - now_s) - 20000) < 20
    assert DEAD_NS <= 1e9 * bridge.dead_time_s() < DEAD_NS + 13  # two cycles of a step
    before = chip.reg(0x40010044)
    chip.write(0x40010044, 4, 0)
    assert chip.reg(0x40010044) == before  # locked
    for pin, port in ((8, 0x40020000), (9, 0x40020000), (12, 0x40020400), (13, 0x40020400), (14, 0x40020400)):
        assert chip.field(port, 2 * pin, 2) == 2 and chip.field(port + 0x24, 4 * (pin - 8), 4) == 1, pin


@arithmetics
def test_the_drive_holds_and_follows_forces_through_its_own_bridge(bench, arithmetic):
    board = bench(arithmetic)
    board.run(0.4)
    chip, errors = board.chip, []
    start = chip.tick_count

    def reference(tick):
        phase = (tick - start) / 1000.0 % 2.0
        return 0.4 + 0.2 * (phase if phase < 1.0 else 2.0 - phase)

    noise = board.before_tick
    board.before_tick = lambda: (noise(), errors.append(reference(chip.tick_count) - board.force_n))
    while chip.tick_count < start + 450:
        board.refer(reference(chip.tick_count))
        chip.run(0.001)
    late = errors[250:]
    rms = (sum(e * e for e in late) / len(late)) ** 0.5
    print(f"{arithmetic}: rms of r - F {1000 * rms:.2f} mN; shortest dead time {1e9 * board.bridge.shortest_dead_s:.0f} ns")
    assert rms < 0.012
    assert "fault" not in chip.text()
    assert board.bridge.shortest_dead_s < NEVER
    board.command("x", "idle at tick")
    assert board.is_off()
    chip.run(0.005)
    assert board.bridge.current_a == 0.0


def settling_s(board, to_a):
    """From a current that has settled, until it stays within 5 % of a step."""
    chip, bridge = board.chip, board.bridge
    chip.step_to_tick()
    chip.interrupt(model.TIM2)
    from_a = bridge.current_a
    chip.call("stage_command", force=to_a)
    bridge.keeps, bridge.currents, begun_s = True, [], chip.now_s
    chip.run(0.0009)
    bridge.keeps = False
    late = [at_s for at_s, a in bridge.currents if abs(a - to_a) > 0.05 * abs(to_a - from_a)]
    assert abs(bridge.currents[-1][1] - to_a) < 0.05 * abs(to_a - from_a)
    overshoot = max((a - to_a) / (to_a - from_a) for _, a in bridge.currents)
    return max(late) + 50e-6 - begun_s, overshoot


def test_a_step_of_current_settles_within_300_us(bench):
    board = bench()
    board.run(0.4)
    board.chip.run(0.1)
    worst_s, worst_overshoot = 0.0, 0.0
    for to_a in (1.0, -1.0, 1.5, 0.0, -0.5, 2.0, -1.9):
        step_s, overshoot = settling_s(board, to_a)
        worst_s, worst_overshoot = max(worst_s, step_s), max(worst_overshoot, overshoot)
        board.chip.run(0.0015)  # the drive's own command again
    print(f"step of current: within 5 % after {1e6 * worst_s:.0f} us at worst, overshoot {100 * worst_overshoot:.1f} %")
    assert worst_s <= 300e-6
    assert worst_overshoot < 0.1


def test_the_handler_of_the_current_loop_takes_at_most_400_instructions(bench):
    board = bench()
    chip = board.chip
    counts, deep = [], [None]

    def count(uc, address, _size, _user):
        if chip.active and chip.active[-1] == model.ADC:
            deep[0] = (deep[0] or 0) + 1

    entered = chip.exception

    def exception(number, pc, interrupted=None):
        deep[0] = None
        entered(number, pc, interrupted)
        if number == 16 + model.ADC:
            counts.append(deep[0])

    for at, size in set(chip.sizes.values()):
        if model.FLASH <= at < model.FLASH + model.FLASH_SIZE and size:
            chip.uc.hook_add(model.UC_HOOK_CODE, count, begin=at & ~1, end=(at & ~1) + size - 1)
            break
    chip.uc.hook_add(model.UC_HOOK_CODE, count, begin=model.FLASH, end=chip.symbols["store_start"] - 1)
    chip.exception = exception
    board.run(0.4)
    chip.run(0.02)
    settling_s(board, 1.0)
    board.bridge.r_ohm, board.bridge.l_h = 0.05, 50e-6  # and a trip
    board.wait_for("fault: ")
    print(f"current loop: {max(counts)} instructions at most, {min(counts)} at least, of {len(counts)} periods")
    assert len(counts) > 500 and min(counts) > 30
    assert max(counts) <= 400


# --- faults -----------------------------------------------------------------------------------------------------------


def short_circuit(board):
    board.bridge.r_ohm, board.bridge.l_h = 0.05, 50e-6


def hang_the_tick(board):
    board.chip.enabled.discard(model.TIM2)
    with pytest.raises(model.Reset):
        board.chip.run(0.1)


def break_with_interrupts_off(board):
    """Nothing of the image runs: the timer itself."""
    board.chip.enabled.clear()
    board.chip.set_pin(FAULT_PIN, True)
    assert not board.bridge.is_on()


def exception_in(number):
    def inject(board):
        board.chip.registers[model.RCC + 0x0C] = 1 << 7  # of an NMI: the crystal
        with pytest.raises(model.Reset):
            board.chip.exception(number, 0x08001234)
    return inject


def pulse_of_the_break(board):
    board.chip.set_pin(FAULT_PIN, True)
    board.chip.now_s += 1e-6
    board.chip.set_pin(FAULT_PIN, False)


def set_of(**values):
    def inject(board):
        for name, value in values.items():
            setattr(board.bridge, name, value)
    return inject


def set_chip(**values):
    def inject(board):
        for name, value in values.items():
            setattr(board.chip, name, value)
    return inject


# Name: what breaks in RUN, within how many seconds all switches are off, and what the drive says of it; None where it is reset.
FAULTS = {
    "emergency stop": (lambda board: board.chip.set_pin(STOP_PIN, True), 20e-6, "emergency stop"),
    "power stage's fault": (lambda board: board.chip.set_pin(FAULT_PIN, True), 1e-6, "power stage"),
    "its pulse of 1 us": (pulse_of_the_break, 2e-6, "power stage"),
    "its fault while no code runs": (break_with_interrupts_off, 1e-6, None),
    "winding shorted": (short_circuit, 0.5e-3, "over-current|power stage"),  # beyond the level, or the sensor at a rail
    "winding open": (set_of(is_open=True), 0.2, "sensor and model differ"),
    "current sensor reversed": (set_of(gain=-0.2), 2e-3, "over-current"),
    "current sensor's wire open": (set_of(sensor_v=0.0), 0.2e-3, "power stage"),
    "current sensor at the supply": (set_of(sensor_v=3.3), 0.2e-3, "power stage"),
    "current sensor stuck at 0 A": (set_of(sensor_v=1.65), 0.05, "sensor out of range"),  # by the force
    "bus too high": (set_of(bus_v=31.0), 0.015, "bus voltage"),
    "bus far too high": (set_of(bus_v=37.0), 0.2e-3, "bus voltage"),
    "bus too low": (set_of(bus_v=17.0), 0.015, "bus voltage"),
    "bus gone": (set_of(bus_v=0.0), 0.015, "bus voltage"),
    "too hot": (set_of(temperature_v=0.85), 0.035, "temperature"),
    "tick hangs": (hang_the_tick, 0.005, None),
    "no conversions": (set_of(triggers_work=False), 0.003, "sensor silent"),
    "force sensor's wire open": (lambda board: setattr(board, "sensor_wire", False), 0.003, "sensor out of range"),
    "supply low": (lambda board: board.chip.set_supply(2.8), 20e-6, "supply"),
    "enable shorted to ground": (set_chip(enable_short=0), 0.003, "power stage"),
    "hard fault": (exception_in(model.HARD_FAULT), 10e-6, None),
    "crystal stops": (exception_in(model.NMI), 10e-6, None),
    "timer's outputs off by themselves": (lambda board: board.bridge._set_main(False), 1e-6, "power stage"),
}


@pytest.fixture(scope="module")
def survivor(tmp_path_factory):
    """One chip for all faults that it survives, made anew where a case has failed. Their starts and stops, some a second, swing F."""
    boards = []

    def board():
        if not boards:
            boards.append(BridgeBench(image=changed_image(tmp_path_factory.mktemp("image"), image=image_of(), temperature_ms=30, swing_ms=2000)))
            boards[0].wait_for("idle at tick")
        return boards[0]

    board.drop = lambda: boards.pop().close()
    yield board
    if boards:
        board.drop()


HEALTHY = {"r_ohm": 2.0, "l_h": 1e-3, "is_open": False, "gain": 0.2, "sensor_v": None, "bus_v": 24.0, "temperature_v": 0.25,
           "triggers_work": True}


def mend(board):
    set_of(**HEALTHY)(board)
    board.sensor_wire, board.chip.enable_short = True, None
    board.chip.set_pin(STOP_PIN, False)
    board.chip.set_pin(FAULT_PIN, False)
    board.chip.set_supply(3.3)


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_turns_all_switches_off(survivor, name):
    inject, within_s, words = FAULTS[name]
    board = survivor()
    chip, bridge = board.chip, board.bridge
    try:
        chip.log.clear()
        board.refer(0.5)
        board.command("start\n", "run at tick")
        chip.run(0.06)
        assert "fault" not in chip.text() and bridge.is_on() and abs(bridge.current_a) > 0.3
        begun_s = chip.now_s
        inject(board)
        if words:
            chip.run_until(lambda: not bridge.is_on(), within_s + 0.001)
        assert not bridge.is_on()
        took_s = bridge.off_since_s - begun_s
        print(f"{name}: all switches off after {1e6 * took_s:.1f} us, {bridge.current_a:.2f} A")
        assert took_s <= within_s
        edges = [leg.edges for leg in bridge.legs]
        if words:
            chip.run_until(lambda: any(f"fault: {one} since" in chip.text() for one in words.split("|")), 0.05)
            chip.send("start\n")
            chip.run(0.02)
            assert edges == [leg.edges for leg in bridge.legs] and abs(bridge.current_a) < 1e-6
            mend(board)
            chip.run(0.02)  # the sensor shows the rig again
            board.command("ack\n", "idle at tick")
    except BaseException:
        survivor.drop()
        raise
    if not words:
        survivor.drop()


@pytest.mark.parametrize("name, offset_v, current_a", [("offset of 0.5 A", 0.1, 0.0), ("of -0.5 A", -0.1, 0.0), ("a current", 0.0, 0.6)])
def test_what_cannot_be_0_a_lets_nothing_begin(bench, name, offset_v, current_a):
    board = bench()
    board.wait_for("idle at tick")
    board.bridge.offset_v = offset_v
    board.refer(0.5)
    if current_a:  # a motor that is turned from outside, through the diodes
        board.bridge._flow = lambda seconds: setattr(board.bridge, "current_a", current_a * (board.bridge.periods % 2))
    board.command("start\n", "fault: power stage since")
    assert [leg.edges for leg in board.bridge.legs] == [0, 0]


def test_an_offset_within_the_sensors_is_taken_out(bench):
    board = bench()
    board.wait_for("idle at tick")
    board.bridge.offset_v = 0.06  # 0.3 A
    board.run(0.5)
    board.chip.run(0.3)
    assert "fault" not in board.chip.text()
    settling_s(board, 1.0)
    assert abs(board.bridge.current_a - 1.0) < 0.02


def test_a_break_that_is_active_lets_nothing_begin(bench):
    board = bench()
    board.wait_for("idle at tick")
    board.chip.set_pin(FAULT_PIN, True)
    board.wait_for("fault: power stage since")
    board.chip.send("ack\nstart\n")
    board.chip.run(0.1)
    assert [leg.edges for leg in board.bridge.legs] == [0, 0]


def test_flash_is_written_only_with_the_outputs_off(bench):
    board = bench()
    board.run(0.5)
    store = board.chip.store()
    assert board.chip.call("erase", 0, 0) == 0
    assert board.chip.store() == store and board.bridge.is_on()
    board.command("x", "idle at tick")
    board.chip.run(0.01)
    board.chip.enabled.clear()  # what writes has the chip to itself
    board.chip.call("erase", 0, 0)
    assert board.chip.call("write_word", 0, 0, 0, 0x12345678) == 1
    assert struct.unpack("<I", board.chip.store()[:4])[0] == 0x12345678


def test_the_dead_time_is_the_configs(bench, tmp_path):
    for ns in (200, 760, 1510, 6000):
        board = bench(image=changed_image(tmp_path, image=image_of(), dead_time_ns=ns))
        board.bridge.least_dead_s = 1e-9 * ns
        board.run(0.4)
        board.chip.run(0.005)
        assert 1e-9 * ns <= board.bridge.shortest_dead_s + 1e-12 <= 1e-9 * ns + 16 / 168e6
        assert "fault" not in board.chip.text()


@pytest.mark.parametrize("fields", [{"ready_ms": 0}, {"bridge_trip_a": bits(2.2)}, {"bridge_trip_a": bits(8.0)}, {"current_max_a": 0},
                                    {"current_bandwidth_hz": bits(2101.0)}, {"motor_inductance_h": bits(4e-5)}, {"dead_time_ns": 100},
                                    {"bus_high_v": 0}, {"temperature_max_c": 0}])
def test_params_that_do_not_suit_the_bridge_never_start_it(bench, tmp_path, fields):
    board = bench(image=changed_image(tmp_path, image=image_of(), **fields))
    board.wait_for("fault: params refused")
    board.chip.send("ack\nstart\n")
    board.chip.run(0.05)
    assert [leg.edges for leg in board.bridge.legs] == [0, 0]


def test_16_mhz_are_too_slow_for_the_bridge(bench, tmp_path):
    board = bench(image=changed_image(tmp_path, image=image_of(), degraded_clock=1), pll_locks=False)
    board.wait_for("fault: clock since tick 0", 1.0)
    assert board.is_off()
