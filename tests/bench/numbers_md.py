"""numbers_md.py [--check | --write]: prints all figures from tests/target/budget.txt (by tools/dev/bench-target) and accuracy.txt (by
tools/dev/bench): every part of a tick on every processor. --write writes the table of facts in README.md, --check fails where that is not current.
"""

import pathlib
import sys

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parents[1]
for folder in (ROOT / "tests" / "target", ROOT / "cmake"):
    sys.path.insert(0, str(folder))
import accuracy  # noqa: E402
import boards  # noqa: E402
import budget  # noqa: E402

README = ROOT / "README.md"
START = "<!-- facts: written by tools/dev/bench --update and tools/dev/bench-target --update -->\n"
END = "<!-- end -->\n"
TITLES = {"f32": "float32", "q31": "Q31"}
PROCESSORS = list(boards.EMULATED)


def name_of(processor):
    """As M4F, M0+, RV32IMC."""
    return processor.replace("cortex-", "").replace("plus", "+").upper()


def read_figures():
    """Figures as text, by processor and name."""
    lines = [line.split() for line in budget.BUDGET.read_text().splitlines() if line and not line.startswith("#")]
    processors = lines[0][1:]
    return {p: {row[0]: row[1 + i] for row in lines[1:] if row[1 + i] != "-"} for i, p in enumerate(processors)}


def derived(figures):
    """With the worst and the cheapest tick of all runs, and the spread between them in percent."""
    more = dict(figures)
    for arithmetic in TITLES:
        for signals in ("", ".without_signals"):
            worst = max(int(figures[f"{arithmetic}.{run}{signals}.max"]) for run in ("tick", "search"))
            least = min(int(figures[f"{arithmetic}.{run}{signals}.min"]) for run in ("tick", "search"))
            more[f"{arithmetic}.worst{signals}"] = worst
            more[f"{arithmetic}.spread{signals}"] = 100 * (worst / least - 1)
    return more


def number(text):
    """With commas, as 12,824; without decimals where it is a percentage."""
    value = float(text)
    return f"{value:,.0f}"


def table(title, columns, rows):
    lines = [f"| {' | '.join([title, *columns])} |", f"|{'---|' * (1 + len(columns))}"]
    return "\n".join(lines + [f"| {' | '.join(row)} |" for row in rows]) + "\n"


def costs(figures, rows, titles):
    """Rows of (text, names...) for each arithmetic of `titles`; more names stand side by side."""
    cells = [
        [title + text, *(" / ".join(number(figures[p][f"{arithmetic}.{name}"]) for name in names) for p in PROCESSORS)]
        for arithmetic, title in titles.items()
        for text, *names in rows
    ]
    return table("", [name_of(p) for p in PROCESSORS], cells)


def module(name, tick):
    return [
        ("instructions, mean / worst", f"{tick}.mean", f"{tick}.max"),
        ("code / stack, bytes", f"code.{name}", f"stack.{name}"),
    ]


def part(name, tick):
    """Its step is inline: the code is the caller's."""
    return [("instructions, mean / worst", f"{tick}.mean", f"{tick}.max"), ("stack, bytes", f"stack.{name}")]


def exactness(record, rows):
    def cell(name):
        if name not in record:
            return "-"
        found, limit = (text.replace("e-0", "e-") for text in record[name])
        return found if limit == "-" else f"{found} ({limit.replace('±', ' ± ').replace('>=', 'at least ')})"

    return table("largest error (limit in its test)", TITLES.values(), [[text, cell(f"f32.{name}"), cell(f"q31.{name}")] for text, name in rows])


FUNCTIONS = [
    (
        "tribo_force_loop_*_step",
        "The whole tick: controller, limit, anti-windup, friction, arm, relays, counters.",
        [
            ("instructions over `triangle`, without signals, mean / worst", "tick.without_signals.mean", "tick.without_signals.max"),
            ("worst-case instructions, without / with signals", "worst.without_signals", "worst"),
            ("worst over cheapest tick, %", "spread"),
            ("worst with a breakaway table of 32 points", "tick.table.max"),
            ("worst where params change", "retuning.max"),
            ("stack, bytes / where params change / from or to four sections and a table", "stack.tick", "stack.retuning", "stack.largest"),
            ("state / params, bytes", "ram.axis", "flash.params"),
            ("flash at -Os, bytes: loop and params / with set-up", "flash.step", "flash.all"),
        ],
        [
            ("`triangle`, gain 0: RMS of r − F, N", "force_loop.rms_without"),
            ("`triangle`, gain 0.85: RMS of r − F, N", "force_loop.rms_with"),
            ("`triangle`: u against the same loop in double, N", "force_loop.u"),
        ],
    ),
    (
        "tribo_force_loop_*_step with the feed-forward",
        "The whole tick with params that name the feed-forward: learning while the arm slides, reversals, r at rest.",
        [
            ("instructions over fast triangles with rests, minimum / mean / worst (one that learns)", "feedforward.tick.min",
             "feedforward.tick.mean", "feedforward.tick.max"),
            ("worst over random inputs, limits and bad inputs", "feedforward.search.max"),
            ("what the guard adds, minimum / mean / worst", "guard.min", "guard.mean", "guard.max"),
            ("stack, bytes / where the method changes", "stack.feedforward", "stack.methods"),
            ("its memory / params, bytes, added to the loop's", "ram.feedforward", "flash.feedforward_params"),
            ("flash at -Os, bytes: loop with both methods and params", "flash.fed"),
        ],
        [],
    ),
    (
        "controller_*_step",
        "Cascade of two sections, limit, anti-windup.",
        part("controller", "tick.controller"),
        [
            ("`triangle`: v against the design in double, N", "controller.design"),
            ("e = ±20 mN at half the sample rate: v against double, N", "controller.ripple"),
        ],
    ),
    (
        "biquad_*: the cascade",
        "Cascade of two sections alone.",
        part("cascade", "tick.controller.cascade"),
        [
            ("signal to noise at fc/fs 0.1, dB", "cascade.snr_0.1"),
            ("… 0.01, dB", "cascade.snr_0.01"),
            ("… 0.001, dB", "cascade.snr_0.001"),
            ("zero-input limit cycle, random poles up to 2.7 rad, LSB", "cascade.limit_cycle"),
            ("… poles beyond 2.7 rad, LSB", "cascade.limit_cycle_beyond"),
            ("… the paper's controller, LSB", "cascade.limit_cycle_paper"),
        ],
    ),
    (
        "tribo_compensator_*_step",
        "Friction and arm. Golden vectors: an independent double-precision implementation of the model.",
        module("compensator", "tick.compensator"),
        [("golden vectors: F̂, N", "compensator.force"), ("golden vectors: f̂, N", "compensator.friction")],
    ),
    (
        "tribo_friction_*_step",
        "Net force, breakaway, relays, friction.",
        module("friction", "tick.compensator.friction"),
        [
            ("golden vectors: f, N", "friction.golden"),
            ("golden vectors: rows of a file whose logic differs", "friction.logic"),
            ("k = 1.01: k L tanh(n/(k L)), relative", "friction.tanh"),
        ],
    ),
    ("arm_*_step", "The arm's force; its accuracy is that of the compensator's F̂.", part("arm", "tick.compensator.arm"), []),
    (
        "relay_step",
        "One function for both arithmetics; exact.",
        part("relay", "tick.compensator.friction.relay"),
        [],
    ),
    (
        "edge_step",
        "One function for both arithmetics; exact.",
        part("edge", "tick.compensator.friction.relay.edge"),
        [],
    ),
]

PEERS = [
    ("`biquad_f32`", "biquad_f32"),
    ("CMSIS-DSP `arm_biquad_cascade_df2T_f32`", "arm_biquad_cascade_df2T_f32"),
    ("`biquad_q31`", "biquad_q31"),
    ("CMSIS-DSP `arm_biquad_cascade_df1_q31`", "arm_biquad_cascade_df1_q31"),
    ("CMSIS-DSP `arm_biquad_cas_df1_32x64_q31`", "arm_biquad_cas_df1_32x64_q31"),
]

INTRODUCTION = """# Numbers

`tests/bench/numbers_md.py` prints this page of what `tools/dev/bench --update` and `tools/dev/bench-target --update` have recorded; tests fail where a figure grows.
**Nothing here has run on a real drive.** Instructions were counted exactly by QEMU, from the call to the return, in code from gcc 12 at -O2. Code size and flash are
at -Os. Stack was measured by painting it. A tick has two sections and no breakaway table unless stated. The worst tick is the worst found in 60 s of `triangle` and
20 s of random, limiting and bad inputs; it is not proven. Results are the same bits on every target.
"""


def peers(figures):
    rows = []
    for text, peer in PEERS:
        found = [figures[p].get(f"peer.{peer}.instructions") for p in PROCESSORS]
        if not any(found):
            return ""
        rows.append([text, *map(number, found), figures[PROCESSORS[0]][f"peer.{peer}.error"]])
    heading = "## Next to CMSIS-DSP\n\nThe paper's controller, two sections, one sample a call: instructions, and the error's RMS as a fraction of full scale.\n"
    m4f = figures["cortex-m4f"]
    ratios = [
        f"{int(m4f[f'peer.{ours}.instructions']) / int(m4f[f'peer.{theirs}.instructions']):.2f} of `{theirs}`"
        for ours, theirs in ((PEERS[0][1], PEERS[1][1]), (PEERS[2][1], PEERS[3][1]), (PEERS[2][1], PEERS[4][1]))
    ]
    note = f"On the M4F this is {', '.join(ratios)}: reported, not promised.\n"
    return f"\n{heading}\n{table('', [*(name_of(p) for p in PROCESSORS), 'error'], rows)}\n{note}"


def cycles(figures):
    modelled = [p for p in PROCESSORS if "cycles.model" in figures[p]]
    if not modelled:
        return ""
    rows = [["model", *(figures[p]["cycles.model"] for p in modelled)]]
    for arithmetic, title in TITLES.items():
        rows.append([f"{title}: cycles (instructions)", *(f"{number(figures[p][f'cycles.{arithmetic}.tick'])} ({number(figures[p][f'cycles.{arithmetic}.instructions'])})" for p in modelled)])
    heading = "## Modelled cycles of a tick\n\nOne tick with signals through llvm-mca's model of a core: no wait states, every branch predicted. A lower bound, not a measurement.\n"
    return f"\n{heading}\n{table('', [name_of(p) for p in modelled], rows)}"


DRIVE = [
    ("loop and drive, mean / worst", "drive.and_loop.mean", "drive.and_loop.max"),
    ("of these the loop", "drive.loop.mean", "drive.loop.max"),
    ("bytes from the bus", "drive.bus.mean", "drive.bus.max"),
    ("trace of eight signals", "drive.trace.mean", "drive.trace.max"),
    ("trace kept for faults", "drive.fault_trace.mean", "drive.fault_trace.max"),
    ("the whole handler", "drive.everything.mean", "drive.everything.max"),
]


def drive(figures):
    what = "What the firmware does in the timer's interrupt, in RUN with every check on, without a board's converters; bytes at 115,200 baud, both traces every tick. `tests/firmware/drive_cost.c`."
    return f"\n## The drive's tick\n\n{what}\n\n{costs(figures, DRIVE, {key: f'{name}: ' for key, name in TITLES.items()})}"


def small_images(figures):
    """At -Os, of the board."""
    board = next(iter(boards.PORTS))
    rows = [[f"{board}, {title}", *(number(figures[board][f"{arithmetic}.flash.{what}"]) for what in ("drive", "drive_fed"))] for arithmetic, title in TITLES.items()]
    what = "The same at -Os, with Modbus, store and traces; the switch is `TRIBO_DRIVE_FEEDFORWARD`."
    return f"\n{what}\n\n{table('', ['flash without the feed-forward, bytes', 'with it'], rows)}"


def images(figures):
    board = next(iter(boards.PORTS))
    rows = [[f"{board}, {title}", *(number(figures[board][f"{arithmetic}.{what}.image"]) for what in ("flash", "ram"))] for arithmetic, title in TITLES.items()]
    return f"\n## The drive's image\n\nThe firmware with self-test, state machine and the board's port, at -O2; RAM without the stack.\n\n{table('', ['flash, bytes', 'RAM, bytes'], rows)}"


def numbers_md(figures, record):
    """With every part of a tick on every processor."""
    parts = [INTRODUCTION]
    for title, what, rows, exact in FUNCTIONS:
        titles = {key: f"{name}: " for key, name in TITLES.items()} if "_*" in title else {"f32": ""}
        parts.append(f"\n## {title}\n\n{what}\n\n{costs(figures, rows, titles)}")
        if exact:
            parts.append(f"\n{exactness(record, exact)}")
    return "".join(parts) + drive(figures) + images(figures) + small_images(figures) + peers(figures) + cycles(figures)


def facts(figures, record):
    m4f = figures["cortex-m4f"]

    def span(of, arithmetic):
        least, most = (
            [int(of[f"{arithmetic}.feedforward.{run}.{end}"]) for run in ("tick", "search", "without_signals")]
            for end in ("min", "max")
        )
        return f"{number(min(least))} to {number(max(most))}"

    def both(name, of=m4f):
        return " / ".join(number(of[f"{arithmetic}.{name}"]) for arithmetic in TITLES)

    def exact(name):
        return " / ".join(record[f"{arithmetic}.{name}"][0].replace("e-0", "e-") for arithmetic in TITLES)

    targets = ", ".join(name_of(p) for p in PROCESSORS).replace("M0", "Cortex-M0", 1)
    rows = [
        ["instructions of a tick, cheapest to worst", f"float32 {span(m4f, 'f32')}, Q31 {span(m4f, 'q31')}; Q31 on RV32IMC {span(figures['rv32imc'], 'q31')}"],
        ["RAM and flash of the C below, float32", f"{number(m4f['f32.ram.readme'])} bytes an axis, {number(m4f['f32.flash.readme'])} bytes with set-up; stack of a tick {number(m4f['f32.stack.feedforward'])} bytes"],
        ["flash with params made on the host, float32 / Q31", f"{both('flash.fed')} bytes; with the paper's method alone {both('flash.step')} bytes"],
        ["u over the benchmark against double, float32 / Q31", f"within {exact('force_loop.u')} N; the same bits on every target"],
        ["targets", f"{targets}, all emulated; Linux; an image for the STM32F405"],
    ]
    return table("what it costs", ["on a Cortex-M4F unless named; `tests/bench/numbers_md.py` prints all figures"], rows)


def read():
    """Figures and record."""
    return {p: derived(column) if p in PROCESSORS else column for p, column in read_figures().items()}, accuracy.read()


def readme():
    """The README with today's facts."""
    text = README.read_text()
    before, after = text.index(START) + len(START), text.index(END)
    return f"{text[:before]}\n{facts(*read())}\n{text[after:]}"


def write():
    README.write_text(readme())


def main():
    if sys.argv[1:] == ["--write"]:
        write()
    elif sys.argv[1:] != ["--check"]:
        print(numbers_md(*read()), end="")
    elif README.read_text() != readme():
        print("numbers_md.py: the README's table is not current; run tests/bench/numbers_md.py --write")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
