"""The experiments. Each returns a Section. Forces are in N, times in s."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from tribo_plot.look import FEEDFORWARD as THIRD
from tribo_plot.look import GUIDE, STYLE
from tribo_plot.look import PAPER as THICK
from tribo_plot.look import WITHOUT as THIN

from .report import Claim, Section, judge
from .runs import ramps

plt.rcParams.update({**STYLE, "axes.axisbelow": "line", "axes.titlesize": 11, "font.size": 10, "lines.linewidth": 1.5})

OFFSET, SLOPE = 0.007, 0.3  # L(F), Eq. (10)
K_MIN, K_MAX, M, V0 = 6.0, 20.0, 3.0, 0.007  # Eq. (7)
ORDINARY = "torque"  # the model of step 2, with saturation only

# The steps of section 3 as settings of plant.model paper.
NEVER, ALWAYS, NO_RELAYS = "plant.paper.curve=never", "plant.paper.curve=always", "plant.paper.curve=rising"
CONSTANT_K = ("plant.friction.k_min=6", "plant.friction.k_max=6")


def breakaway(force):
    return OFFSET + SLOPE * np.abs(force)


def mn(value):
    return f"{1e3 * value:.2f} mN"


def at(trace, name, time_s):
    return float(np.interp(time_s, trace.t_s, getattr(trace, name)))


def first(trace, condition, after_s=0.0):
    """Returns the time at which `condition` is first true."""
    hits = np.flatnonzero(condition & (trace.t_s >= after_s))
    return float(trace.t_s[hits[0]]) if len(hits) else float("nan")


# Figure 2

FIG2_TURNS = {"deep fall": 8.0, "deep rise": 15.0, "shallow rise": 34.0, "last fall": 50.0}
FIG2_INPUT = ((0, 0), (6, 0.55), (8, 0.55), (14, 0.10), (15, 0.10), (30, 0.40), (32, 0.34), (34, 0.34), (46, 0.58), (50, 0.58), (62, 0.02))


def fig2(runs):
    """Fig. 2: open loop, slowly varying input"""
    full = runs.open_loop("fig2", FIG2_INPUT)
    ordinary = runs.open_loop("fig2_ordinary", FIG2_INPUT, model=ORDINARY)

    def lead(turn_s):
        """Returns how far F has moved when the ordinary model's arm begins to move."""
        turned_s = turn_s + 0.2
        start = at(ordinary, "F_N", turned_s)
        moves_s = first(ordinary, np.abs(ordinary.F_N - start) > 1e-5, turned_s) - 0.01
        return abs(at(full, "F_N", moves_s) - at(full, "F_N", turned_s))

    leads = {name: lead(turn_s) for name, turn_s in FIG2_TURNS.items()}
    hold = full.F_N[(full.t_s >= 31.0) & (full.t_s <= 34.0)]
    steep = np.max(np.abs(np.gradient(full.F_N, full.t_s))[full.t_s > 58.0]) / 3.84
    figure, (force, rest) = plt.subplots(2, 1, figsize=(11, 6.5), sharex=True, height_ratios=(3, 1.4))
    force.plot(full.t_s, full.u_N, color=GUIDE, linewidth=1.0, label="input u")
    force.plot(ordinary.t_s, ordinary.F_N, ":", color=THIN, label="F of the ordinary model")
    force.plot(full.t_s, full.F_N, color=THICK, label="F of the paper's model")
    force.set_ylabel("force (N)")
    force.legend(ncols=3, loc="upper center", bbox_to_anchor=(0.5, 1.12))
    rest.plot(full.t_s, full.u_N - full.F_N, "-.", color=THIRD)
    rest.set_ylabel("u − F (N)")
    rest.set_xlabel("time (s)")
    names = {"deep fall": "gradual", "deep rise": "gradual", "shallow rise": "almost sharp", "last fall": "gradual"}
    for name, turn_s in FIG2_TURNS.items():
        force.annotate(names[name], (turn_s + 1.5, at(full, "F_N", turn_s) + 0.01), color=GUIDE)
    deep = min(leads[name] for name in ("deep fall", "deep rise", "last fall"))
    return Section(
        [
            Claim(
                "Fig. 2, standstill",
                "after a turn F stands still",
                f"F moves by {mn(np.ptp(hold))} while u falls by 60 mN and stands (31 to 34 s)",
                judge(np.ptp(hold) < 1e-4),
                "the input's corners are not listed: a polygon to the text's description",
            ),
            Claim(
                "Fig. 2, gradual transitions",
                "after u − F was far on the other side F leaves gradually, before the ordinary model's dotted line",
                "F has moved by " + ", ".join(f"{mn(leads[n])} ({n})" for n in ("deep fall", "deep rise", "last fall"))
                + " when the ordinary model's first moves",
                judge(deep > 1e-3),
            ),
            Claim(
                "Fig. 2, almost sharp transition",
                "33.5 to 38 s: u − F had not been far on the other side, F leaves almost sharply",
                f"F has moved by {mn(leads['shallow rise'])} when the ordinary model's first moves",
                judge(leads["shallow rise"] < 1e-4),
            ),
            Claim(
                "Footnote 1",
                "below 0.03 deg/s even where F is steepest",
                f"{steep:.3f} deg/s in the last 4 s",
                judge(steep < 0.03),
            ),
        ],
        figure,
    )


# Figure 3


def fig3(runs):
    """Fig. 3: achievable force and friction interval"""
    trace = runs.open_loop("fig3", ((0, 0), (25, 1.0), (50, 0)))
    up, down = trace.t_s < 25.0, trace.t_s >= 25.0
    slides_up = up & (trace.u_N - trace.F_N > 0.999 * breakaway(trace.F_N)) & (trace.F_N > 0.05)
    slides_down = down & (trace.F_N - trace.u_N > 0.999 * breakaway(trace.F_N)) & (trace.F_N > 0.05)
    forces = np.linspace(0.1, 0.5, 41)  # above this range the falling arm does not slide yet
    order = np.argsort(trace.F_N[slides_down])
    rising = np.interp(forces, trace.F_N[slides_up], trace.u_N[slides_up])
    falling = np.interp(forces, trace.F_N[slides_down][order], trace.u_N[slides_down][order])
    slope, offset = np.polyfit(forces, rising - falling, 1)
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2))
    left.plot(rising, forces, color=THICK, label="rising")
    left.plot(falling, forces, color=THIN, label="falling")
    left.plot((0, 1), (0, 1), "--", color=GUIDE, linewidth=1, label="u = F")
    left.set_xlabel("u (N)")
    left.set_ylabel("F (N)")
    left.legend()
    right.plot(forces, rising - falling, color=THICK)
    right.set_ylim(0, None)
    right.set_xlabel("F (N)")
    right.set_ylabel("friction interval (N)")
    return Section(
        [
            Claim(
                "Fig. 3",
                "the friction interval rises considerably, almost linearly, with F",
                f"interval = {offset:.4f} N + {slope:.3f} F; twice Eq. (10) is 0.0140 N + 0.600 F",
                judge(abs(slope / (2 * SLOPE) - 1) < 0.02 and abs(offset - 2 * OFFSET) < 1e-3),
                "u is in newton of F already; the paper scales it until both lines lie evenly about u = F",
            )
        ],
        figure,
    )


# Figures 4 and 5: the law alone


def fig4(runs):
    """Fig. 4: hysteresis for k = 1.1, and k against v"""
    L = breakaway(0.5)
    t = np.arange(8000) / 1000.0
    phase = (t / 4.0 + 0.25) % 1.0
    net = 2.0 * L * np.where(phase < 0.5, 4 * phase - 1, 3 - 4 * phase)
    loop = runs.friction("fig4a", t, net, params="friction: {k_min: 1.1, k_max: 1.1}\n")
    loop = type(loop)(**{name: value[4000:] for name, value in vars(loop).items()})
    rises = np.gradient(loop.n_N) > 0
    gap = np.interp(L, loop.n_N[rises & (loop.n_N > 0)], (loop.n_N - loop.f_hat_N)[rises & (loop.n_N > 0)]) / L
    expected = 1 - 1.1 * np.tanh(1 / 1.1)
    back = ~rises & (loop.n_N > 0) & (loop.n_N < 0.7 * L)
    behind = np.max(np.abs(loop.n_N - loop.f_hat_N)[back]) / L

    rates, seen = np.geomspace(1e-3, 0.04, 20), []
    for rate in rates:
        # n goes down to -0.95 L, which sets the relay, and up at the rate. k is computed from f at 0.6 L, where Eq. (3) is curved enough.
        down_s, up_s = 0.5, 1.6 * L / rate
        time = np.arange(0, down_s + up_s, 1e-3)
        part = np.where(time < down_s, -0.95 * L * time / down_s, -0.95 * L + (time - down_s) * rate)
        trace = runs.friction("fig4b", time, part)
        hit = np.flatnonzero((trace.t_s > down_s + 0.01) & (trace.n_N > 0.6 * L))[0]
        seen.append((trace.v_N_per_s[hit], k_of(trace.f_hat_N[hit], trace.n_N[hit], L)))
    seen = np.array(seen)
    law = (K_MAX + K_MIN) / 2 - (K_MAX - K_MIN) / 2 * np.tanh(M * (seen[:, 0] / V0 - 1))
    worst = np.max(np.abs(seen[:, 1] / law - 1))

    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.4))
    left.plot(np.where(rises, loop.n_N, np.nan) / L, loop.f_hat_N / L, color=THICK, label="n rises")
    left.plot(np.where(rises, np.nan, loop.n_N) / L, loop.f_hat_N / L, color=THIN, label="n falls")
    left.set_xlabel("net force / L")
    left.set_ylabel("f / L")
    left.set_title("k = 1.1")
    left.legend()
    right.plot(1e3 * seen[:, 0], law, color=GUIDE, linewidth=1, label="Eq. (5)")
    right.plot(1e3 * seen[:, 0], seen[:, 1], "o", color=THICK, markersize=4, label="from f")
    right.set_xlabel("net-force rate v (mN/s)")
    right.set_ylabel("k")
    right.legend()
    return Section(
        [
            Claim(
                "Fig. 4(a), Eq. (3)",
                "while n rises after a deep turn f follows k L tanh(n/(k L)) and ends at L; while n falls f is n",
                f"f is {100 * gap:.1f} % of L below n at n = L, {100 * expected:.1f} % in Eq. (3); at most {100 * behind:.2f} % of L "
                f"beside n on the way back; greatest f is {np.max(loop.f_hat_N) / L:.4f} L",
                judge(abs(gap - expected) < 2e-3 and behind < 5e-3 and abs(np.max(loop.f_hat_N) / L - 1) < 1e-4),
            ),
            Claim(
                "Fig. 4(b), Eq. (5)",
                "k falls from k_max = 20 at rest to k_min = 6 at high rates, half way at 0.007 N/s",
                f"k recovered from f at {len(seen)} rates: {seen[0, 1]:.1f} at {1e3 * seen[0, 0]:.1f} mN/s to {seen[-1, 1]:.2f} "
                f"at {1e3 * seen[-1, 0]:.0f} mN/s, at most {100 * worst:.1f} % beside Eq. (5)",
                judge(worst < 0.05),
            ),
        ],
        figure,
    )


def k_of(f, n, L):
    """Solves f = k L tanh(n/(k L)) for k by bisection; f rises with k."""
    low, high = 1.0, 1000.0
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if middle * L * np.tanh(n / (middle * L)) < f else (low, middle)
    return low


def fig5(runs):
    """Fig. 5: relay characteristics from a sweep"""
    L = breakaway(0.5)
    peaks = np.concatenate(([0.95], np.tile((-0.95, 0.95, -0.7, 0.85, -0.8, 0.79, -0.9, 0.95), 2)))
    times = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(peaks)))))
    t = np.arange(0, times[-1], 1e-3)
    trace = runs.friction("fig5", t, L * np.interp(t, times, peaks))
    part = trace.n_N / L
    edges = {}
    for name in ("Q1", "Q2"):
        change = np.diff(getattr(trace, name))
        edges[name, "high"] = part[1:][change > 0]
        edges[name, "low"] = part[1:][change < 0]
    figure, axes = plt.subplots(1, 2, figsize=(11, 3.4))
    for plot, name in zip(axes, ("Q2", "Q1")):
        value = getattr(trace, name)
        plot.plot(part, value, color=GUIDE, linewidth=0.8)
        plot.plot(edges[name, "high"], np.full_like(edges[name, "high"], 0.5), "^", color=THICK, label="goes high")
        plot.plot(edges[name, "low"], np.full_like(edges[name, "low"], 0.5), "v", color=THIN, label="goes low")
        plot.set_title(name)
        plot.set_xlabel("net force / L")
        plot.set_yticks((0, 1))
        plot.legend()
    step = np.max(np.abs(np.diff(part)))
    high = edges["Q2", "high"], -edges["Q1", "high"]
    low = edges["Q2", "low"], -edges["Q1", "low"]
    sets = all(len(e) and np.all(np.abs(e + 0.75) <= 4 * step) for e in high)
    resets = all(len(e) and np.all(e >= 0.8 - 4 * step) for e in low)
    return Section(
        [
            Claim(
                "Fig. 5, Eq. (9)",
                "Q2 goes high where the rising net force passes −0.75 L, Q1 where the falling one passes 0.75 L",
                f"Q2 at {high[0].min():.3f} to {high[0].max():.3f} L, Q1 at {-high[1].max():.3f} to {-high[1].min():.3f} L; "
                "a turn at ±0.7 L sets nothing",
                judge(sets),
                "the crossing is seen at a sample",
            ),
            Claim(
                "Figs. 5 and 12",
                "Q2 goes low where the net force falls from beyond 0.8 L, or above; Q1 the other way round",
                f"Q2 at {low[0].min():.3f} to {low[0].max():.3f} L, Q1 at {-low[1].max():.3f} to {-low[1].min():.3f} L; "
                "a turn at ±0.79 L resets nothing",
                judge(resets),
                "the text gives 0.8 L as the least level; here a relay resets at the first sample that falls",
            ),
        ],
        figure,
    )


# Figures 6 and 7 and the five steps: the plant, alone

DEEP = ramps((0.6, 0.2), (0.12, 0.2), (0.8, 0.2))
SHALLOW = ramps((0.6, 0.2), (0.42, 0.2), (0.8, 0.2))


def before_break(runs, name, corners, sets):
    """Returns the run, its turn, and how far F has moved from rest when u - F reaches 0.8 L, or at the end."""
    trace = runs.open_loop(name, corners, sets)
    turn_s = corners[-2][0]
    start = stands(trace, turn_s)
    reached = (trace.t_s >= turn_s) & (trace.u_N - trace.F_N >= 0.8 * breakaway(start))
    reached[-1] = True
    return trace, turn_s, at(trace, "F_N", first(trace, reached)) - start


def stands(trace, turn_s):
    """Returns F where it comes to rest after a fall; this is after the turn, because the arm is damped."""
    return float(np.min(trace.F_N[trace.t_s >= turn_s]))


def fig6(runs):
    """Fig. 6: with the relays and without"""
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.4))
    moved = {}
    for plot, (depth, corners) in zip(axes, (("deep", DEEP), ("shallow", SHALLOW))):
        for kind, sets, style in (("relays", (), "-"), ("none", (NO_RELAYS,), ":")):
            trace, turn_s, moved[depth, kind] = before_break(runs, f"fig6_{depth}_{kind}", corners, sets)
            shown = (trace.t_s > turn_s - 0.3) & (trace.t_s < turn_s + 1.9)
            plot.plot(trace.t_s[shown], trace.F_N[shown], style, color=THICK if kind == "relays" else THIN,
                      label="with relays" if kind == "relays" else "Q = v > 0")
        plot.set_title(f"rise from {depth} below F")
        plot.set_xlabel("time (s)")
        plot.legend()
    axes[0].set_ylabel("F (N)")
    return Section(
        [
            Claim(
                "Fig. 6, with relays",
                "gradual where the input was deep below the force, sharp where it was not",
                f"at 0.8 L F has moved by {mn(moved['deep', 'relays'])} from deep, {mn(moved['shallow', 'relays'])} from shallow",
                judge(moved["deep", "relays"] > 1e-3 and abs(moved["shallow", "relays"]) < 1e-5),
                "the input is not listed: 0.6 N, down to 0.12 N or 0.42 N, up at 0.2 N/s",
            ),
            Claim(
                "Fig. 6, without",
                "with Q = v > 0 transitions are gradual from either",
                f"{mn(moved['deep', 'none'])} from deep, {mn(moved['shallow', 'none'])} from shallow",
                judge(moved["deep", "none"] > 1e-3 and moved["shallow", "none"] > 5e-4),
            ),
        ],
        figure,
    )


RISES_S = (2.0, 10.0, 50.0)


def slow_rises(runs, name, sets):
    """Returns how far a rise that stays below breakaway lifts F, for each of RISES_S, and the traces of the rises."""
    lifts, traces = [], []
    for rise_s in RISES_S:
        trace = runs.open_loop(f"{name}_{rise_s:g}s", ((0, 0), (3, 0.6), (5.5, 0.1), (5.5 + rise_s, 0.195)), sets)
        rise = trace.t_s >= 5.52  # the arm is at rest
        lifts.append(trace.F_N[-1] - stands(trace, 5.5))
        traces.append((trace.u_N[rise], trace.F_N[rise] - stands(trace, 5.5)))
    return lifts, traces


def fig7(runs):
    """Fig. 7: hysteresis and the rate-dependent k"""
    kinds = {"saturation alone": (NEVER,), "constant k = 6": CONSTANT_K, "k(v)": ()}
    figure, axes = plt.subplots(1, 3, figsize=(12, 4), sharey=True)
    lifts = {}
    for plot, (kind, sets) in zip(axes, kinds.items()):
        lifts[kind], traces = slow_rises(runs, "fig7_" + kind.split()[0], sets)
        for rise_s, (u, force), colour in zip(RISES_S, traces, (THIN, THIRD, THICK)):
            plot.plot(u, 1e3 * force, color=colour, label=f"in {rise_s:g} s")
        plot.set_title(kind)
        plot.set_xlabel("u (N)")
        plot.legend()
    axes[0].set_ylabel("F has risen by (mN)")
    constant, full = lifts["constant k = 6"], lifts["k(v)"]

    def listed(kind):
        return " / ".join(f"{1e3 * lift:.1f}" for lift in lifts[kind]) + " mN in 2 / 10 / 50 s"

    left_over = (full[2] - full[0]) / (constant[2] - constant[0])
    return Section(
        [
            Claim(
                "Fig. 7, thin; Eq. (11)",
                "saturation alone: F stands until it breaks away sharply",
                f"F rises by {listed('saturation alone')}",
                judge(max(lifts["saturation alone"]) < 1e-5),
                "inputs are not listed: after 0.6 N and 0.1 N a rise to 0.195 N, below breakaway",
            ),
            Claim(
                "Fig. 7, dotted",
                "constant k = 6: the slower the input, the higher the force",
                f"F rises by {listed('constant k = 6')}",
                judge(constant[2] > constant[1] > constant[0] and constant[2] > 3 * constant[0]),
            ),
            Claim(
                "Fig. 7, thick",
                "k(v) resolves this significantly",
                f"F rises by {listed('k(v)')}: {100 * left_over:.0f} % of the excess is left",
                judge(left_over < 0.1, partly=left_over < 0.3),
                "\"significantly\" has no figure: below 10 % agrees, below 30 % partly",
            ),
        ],
        figure,
    )


STEPS = (
    ("1: f = n", ("plant.paper.limited=no", NEVER)),
    ("2: saturation", (NEVER,)),
    ("3: curve always, k = 6", (ALWAYS, *CONSTANT_K)),
    ("4: relays, k = 6", CONSTANT_K),
    ("5: relays, k(v)", ()),
)


def section3(runs):
    """Section 3: the five steps to the model"""
    rows, seen = [], []
    for number, (title, sets) in enumerate(STEPS, start=1):
        deep_run, _, deep = before_break(runs, f"step{number}_deep", DEEP, sets)
        _, _, shallow = before_break(runs, f"step{number}_shallow", SHALLOW, sets)
        lifts, _ = slow_rises(runs, f"step{number}", sets)
        travel, excess = np.ptp(deep_run.F_N), lifts[2] - lifts[0]
        beyond = np.max(np.abs(deep_run.u_N - deep_run.F_N) - breakaway(deep_run.F_N))
        seen.append((travel, deep, shallow, excess, beyond))
        rows.append((title, mn(travel), mn(deep), mn(shallow), mn(excess)))
    one, two, three, four, five = seen
    return Section(
        [
            Claim("Step 1", "f = n does not depend on the actuation, and exceeds the threshold",
                  f"F moves by {mn(one[0])} while u goes to 0.6 N; u − F exceeds L by {one[4]:.2f} N",
                  judge(one[0] < 1e-4 and one[4] > 0.1)),
            Claim("Step 2", "friction within L(F), but no gradual transitions", f"F moves by {mn(two[1])} before 0.8 L",
                  judge(abs(two[1]) < 1e-5 and two[0] > 0.3)),
            Claim("Step 3", "gradual transitions, but irrespective of the history; excessive force for slow inputs",
                  f"{mn(three[1])} from deep, {mn(three[2])} from shallow; {mn(three[3])} more in 50 s than in 2 s",
                  judge(three[1] > 1e-3 and three[2] > 5e-4 and three[3] > 5e-3)),
            Claim("Step 4", "the relays mend the history, the excess remains",
                  f"{mn(four[1])} from deep, {mn(four[2])} from shallow; {mn(four[3])} more in 50 s than in 2 s",
                  judge(four[1] > 1e-3 and abs(four[2]) < 1e-5 and four[3] > 5e-3)),
            Claim("Step 5", "k(v) resolves the excess",
                  f"{mn(five[1])} from deep, {mn(five[2])} from shallow; {mn(five[3])} more in 50 s than in 2 s",
                  judge(five[1] > 1e-3 and abs(five[2]) < 1e-5 and five[3] < 0.1 * four[3], partly=five[3] < 0.3 * four[3])),
        ],
        table=(("step", "F moves in all", "from deep, at 0.8 L", "from shallow, at 0.8 L", "50 s more than 2 s"), *rows),
    )


# LuGre


def fig8(runs):
    """Fig. 8: LuGre shows no hysteresis gap"""
    corners = ramps((0.6, 0.2), (0.12, 0.2), (0.6, 0.2), (0.12, 0.2), (0.6, 0.2))
    traces = {model: runs.open_loop(f"fig8_{model}", corners, model=model) for model in ("paper", "lugre", ORDINARY)}
    after = traces["paper"].t_s > corners[2][0]
    gap = {model: traces[model].F_N - traces[ORDINARY].F_N for model in ("paper", "lugre")}
    largest = {model: np.max(np.abs(gap[model][after])) for model in gap}
    figure, (left, right) = plt.subplots(1, 2, figsize=(12, 4.4))
    left.plot(traces["paper"].t_s, traces["paper"].u_N, color=GUIDE, linewidth=1, label="input u")
    for model, colour, name in (("lugre", THIN, "LuGre"), ("paper", THICK, "the paper's model")):
        left.plot(traces[model].t_s, traces[model].F_N, color=colour, label=name)
        right.plot(traces[model].t_s, 1e3 * gap[model], color=colour, label=name)
    left.set_ylabel("force (N)")
    right.set_ylabel("F beside the ordinary model (mN)")
    for plot in (left, right):
        plot.set_xlabel("time (s)")
        plot.legend()
    return Section(
        [
            Claim(
                "Fig. 8",
                "LuGre does not show the hysteresis, the paper's model does",
                f"largest distance to the ordinary model: {mn(largest['paper'])} for the paper's, {mn(largest['lugre'])} for LuGre",
                judge(largest["lugre"] < 0.1 * largest["paper"]),
                "a sawtooth between 0.12 N and 0.6 N at 0.2 N/s; LuGre limited to ±L(F), as in the paper",
            )
        ],
        figure,
    )


def section4(runs):
    """Section 4: simulation time of LuGre"""
    rows = runs.solver_times()
    cost = {(method, model): (steps, calls, ms) for method, model, steps, calls, ms in rows}
    table, ratios = [], {}
    for method in dict.fromkeys(row[0] for row in rows):
        lugre = cost.get((method, "lugre"))
        paper = cost.get((method, "paper"))
        if lugre and paper:
            ratios[method] = lugre[1] / paper[1], lugre[2] / paper[2]
            table.append((method, *(f"{value:,}" for value in (paper[1], lugre[1])), f"{ratios[method][0]:,.2f}", f"{ratios[method][1]:,.2f}"))
    stiff = [ratio for method, ratio in ratios.items() if "BDF" in method]
    other = [ratio for method, ratio in ratios.items() if "Adams" in method]
    return Section(
        [
            Claim(
                "Section 4, a method for non-stiff problems",
                "LuGre's simulation takes much longer, above all in stiction",
                f"CVODE Adams: {min(r[0] for r in other):,.0f} to {max(r[0] for r in other):,.0f} times the right-hand sides",
                judge(min(r[0] for r in other) > 10),
                "the paper names no solver",
            ),
            Claim(
                "Section 4, a method for stiff problems",
                "LuGre's simulation takes much longer, above all in stiction",
                f"CVODE BDF: {min(r[0] for r in stiff):.2f} to {max(r[0] for r in stiff):.2f} times the right-hand sides, "
                f"{min(r[1] for r in stiff):.2f} to {max(r[1] for r in stiff):.2f} times the time",
                judge(min(r[0] for r in stiff) > 2),
                "same input, tolerances 1e-4 to 1e-8, root finding at switches",
            ),
        ],
        table=(("method, relative tolerance", "right-hand sides, paper's", "LuGre", "ratio", "ratio of time"), *table),
    )


# The loop

POLES = np.array((-55.0, -200.0, -139.0 + 203.0j, -139.0 - 203.0j, -56778.0))


def step_of(poles, gain, t):
    """Returns the step response of gain * prod(-p) / prod(s - p), by partial fractions."""
    scale = gain * np.prod(-poles)
    response = np.full(len(t), gain, dtype=complex)
    for i, pole in enumerate(poles):
        response += scale / (pole * np.prod(pole - np.delete(poles, i))) * np.exp(pole * t)
    return response.real


def fig10(runs):
    """Fig. 10: open-loop step response and its approximation"""
    corners = ((0, 0), (0.05, 0), (0.05 + 1e-6, 0.2), (0.3, 0.2))
    rest = runs.open_loop("fig10", corners, ("plant.actuator_pole_rad_per_s=200",), ("y_N",))
    slide = ((0, 0), (3, 0.4), (3.2, 0.4), (3.2 + 1e-6, 0.6), (3.5, 0.6))
    moving = runs.open_loop("fig10_sliding", slide, ("plant.actuator_pole_rad_per_s=200",), ("y_N",))
    t = rest.t_s[rest.t_s >= 0.05] - 0.05
    approximation = 0.2 * step_of(POLES, 0.86, t)
    gains = [
        (rest.y_N[-1] - at(rest, "y_N", 0.05)) / 0.2,
        (moving.y_N[-1] - at(moving, "y_N", 3.2)) / 0.2,
    ]

    def rise_s(times, values):
        part = (values - values[0]) / (values[-1] - values[0])
        return float(times[np.flatnonzero(part > 0.632)[0]] - times[0])

    shown = rest.t_s >= 0.05
    rises = rise_s(t, rest.y_N[shown]), rise_s(t, approximation)
    arm = np.roots((1.2e-4, 0.0288, 3.84))
    figure, plot = plt.subplots(figsize=(8, 4.2))
    plot.plot(1e3 * t, rest.y_N[shown], color=THICK, label="plant with friction, from rest")
    after = moving.t_s >= 3.2
    plot.plot(1e3 * (moving.t_s[after] - 3.2), moving.y_N[after] - moving.y_N[after][0], color=THIRD, label="from a slide at 0.4 N, shifted")
    plot.plot(1e3 * t, approximation, "--", color=THIN, label="the paper's linear approximation")
    plot.set_xlabel("time after the step of u by 0.2 N (ms)")
    plot.set_ylabel("y (N)")
    plot.set_xlim(0, 200)
    plot.legend()
    return Section(
        [
            Claim(
                "Fig. 10, gain",
                "a steady-state gain of 0.86",
                f"{gains[0]:.3f} from rest, {gains[1]:.3f} from a slide; a slow rise has 1/1.3 = 0.769, a step overshoots and sticks",
                judge(abs(max(gains) / 0.86 - 1) < 0.05),
                "where the step starts is not said",
            ),
            Claim(
                "Fig. 10, speed",
                "poles at −55, −200, −139 ± 203j and −56778 rad/s",
                f"63 % after {1e3 * rises[0]:.1f} ms here, {1e3 * rises[1]:.1f} ms by these poles",
                judge(abs(rises[0] / rises[1] - 1) < 0.1, partly=abs(rises[0] / rises[1] - 1) < 0.3),
                "here: sensor −55, actuator −200, the arm of Eq. (10) and its friction",
            ),
            Claim(
                "Fig. 10 and Eq. (10)",
                "the arm's poles −139 ± 203j",
                f"I, b and K of Eq. (10) give {arm[0].real:.0f} ± {abs(arm[0].imag):.0f}j",
                judge(abs(abs(arm[0]) / abs(-139 + 203j) - 1) < 0.05),
                "the text's two sets of numbers contradict each other; the loop holds with either",
            ),
        ],
        figure,
    )


def fig14(runs):
    """Fig. 14: tracking a triangle"""
    off = runs.scenario("triangle", ("compensator.gain=0",))
    on = runs.scenario("triangle")
    rms = [runs.summary("triangle", (f"compensator.gain={gain}",))["rms_error_N"] for gain in (0, 0.85, 1)]
    figure, rows = plt.subplots(2, 1, figsize=(10, 5), sharex=True, sharey=True)
    for plot, trace, colour, name, value in zip(rows, (off, on), (THIN, THICK), ("Without", "With"), rms):
        shown = trace.t_s >= 20
        plot.plot(trace.t_s[shown], 1e3 * (trace.r_N - trace.F_N)[shown], color=colour)
        plot.set_title(f"{name} compensation: {1e3 * value:.2f} mN RMS")
        plot.set_ylabel("r − F (mN)")
    rows[-1].set_xlabel("time (s)")
    return Section(
        [
            Claim("Fig. 14, without", "RMS of the steady-state error 0.0038 N", f"{rms[0]:.6f} N",
                  judge(abs(rms[0] / 0.0038 - 1) < 0.05), "0.4 to 0.6 N in 20 s, the last two of three periods, r − F"),
            Claim("Fig. 14, with", "0.001 N", f"{rms[1]:.6f} N", judge(abs(rms[1] / 0.001 - 1) < 0.1)),
            Claim("Section 5, gain", "f̂ is weakened by 0.85 to prevent overcompensation",
                  f"at gain 1 the error is {rms[2]:.6f} N", judge(rms[2] > 1.5 * rms[1])),
        ],
        figure,
    )


SPANS = ((0.1, 0.3), (0.2, 0.5), (0.2, 0.6), (0.3, 0.5), (0.4, 0.6), (0.1, 0.5), (-0.2, 0.2), (-0.4, 0.4))
RATES = (0.01, 0.015, 0.02, 0.04)


def triangles(runs):
    """32 triangles: where else the compensation helps"""
    rows, ratios = [], []
    for low, high in SPANS:
        for rate in RATES:
            period = 2 * (high - low) / rate
            sets = (f"reference.low_N={low}", f"reference.high_N={high}", f"reference.period_s={period:.9g}",
                    f"duration_s={3 * period:.9g}", f"metrics.start_s={period:.9g}")
            off, on = (runs.summary("triangle", (*sets, f"compensator.gain={gain}")) for gain in (0, 0.85))
            ratios.append(off["rms_error_N"] / on["rms_error_N"])
            rows.append((f"{low:g} to {high:g}", f"{rate:g}", f"{1e3 * off['rms_error_N']:.3f}", f"{1e3 * on['rms_error_N']:.3f}",
                         f"{ratios[-1]:.2f}", f"{on['chatter_ticks']:,}", f"{on['Q_switches']:,}"))
    ratios = np.array(ratios).reshape(len(SPANS), len(RATES))
    figure, plot = plt.subplots(figsize=(9, 4.4))
    for column, (rate, colour) in enumerate(zip(RATES, (GUIDE, THIRD, THICK, THIN))):
        plot.plot([f"{low:g} to\n{high:g} N" for low, high in SPANS], ratios[:, column], "o", color=colour, label=f"{rate:g} N/s")
    plot.axhline(1, color="black", linewidth=0.8)
    plot.set_ylabel("RMS without / with")
    plot.set_ylim(0, None)
    plot.legend(ncols=4)
    return Section(
        [
            Claim("Section 6", "the model reduces the error in force control", f"ratio without / with {ratios.min():.2f} to "
                  f"{ratios.max():.2f}, median {np.median(ratios):.2f}", judge(ratios.min() > 1.05),
                  "one waveform in the paper, 32 here; gain 0.85, the compensator's L right")
        ],
        figure,
        (("r (N)", "rate (N/s)", "RMS without (mN)", "with (mN)", "ratio", "chatter (ticks)", "switches of Q"), *rows),
    )


EXPERIMENTS = {
    experiment.__name__: experiment
    for experiment in (fig2, fig3, fig4, fig5, fig6, fig7, section3, fig8, section4, fig10, fig14, triangles)
}
