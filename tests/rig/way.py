"""The whole way of a foreign rig: tribo-rig writes what to play, the foreign simulator plays it, and the generated header runs on it in the end."""

import contextlib
import functools
import io
import json
from dataclasses import dataclass, replace

import foreign
import numpy as np

from tribo_identify import accept, bins, native
from tribo_identify.logs import Segment
from tribo_rig import cli


@dataclass
class Way:
    exit_code: int  # of the last call
    said: str
    beyond: float = 0.0  # largest force or command over the safe one, as a part of it
    predicted: dict = None  # rms of r - y by case, N
    played: dict = None
    lags: dict = None  # by name: what was found, half of its interval, and what is true, s

    @property
    def factor(self):
        return self.played["off"] / self.played["on"]

    def astray(self):
        """Lags that are outside their interval."""
        return [f"{name} {1e3 * value:.3g} +- {1e3 * half:.2g} for {1e3 * true:.3g} ms" for name, (value, half, true) in self.lags.items() if abs(value - true) > half]

    def off_by(self, case):
        return self.predicted[case] / self.played[case] - 1


def call(folder):
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        code = cli.main([str(folder)])
    return code, out.getvalue()


def go(truth, folder, more=""):
    """`more`: lines of rig.yaml."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rig.yaml").write_text(f"sample_time_s: {truth.tick_s}\nforce: {{low_N: 0, high_N: {truth.high:.6g}}}\nlog: {{columns: {{F: y}}}}\n{more}")
    beyond = 0.0
    for run, name in enumerate(("1-ramp", "2-slides")):
        code, said = call(folder)
        if not (folder / f"{name}.csv").exists() or code:
            return Way(code, said, beyond)
        t, u = np.loadtxt(folder / f"{name}.csv", delimiter=",", skiprows=1).T
        rig, y = foreign.Foreign(truth, run), np.empty(len(u))
        for k, command in enumerate(u):
            y[k] = rig.read()
            rig.tick(command)
        beyond = max(beyond, max(rig.largest, float(np.abs(u).max())) / truth.high)
        np.savetxt(folder / f"{name}-log.csv", np.c_[t, u, y], delimiter=",", header="t_s,u_N,y", comments="", fmt=("%.7g", "%.7g", "%.7g"))
    code, said = call(folder)
    way = Way(code, said, beyond)
    if code == 0:
        compare(truth, folder / "result", way)
    return way


def compare(truth, result, way):
    found = json.loads((result / "verdict.json").read_text())
    way.predicted = {case: found["predicted_rms_N"][case][1] for case in ("off", "on")}
    way.played = played(lambda: foreign.Foreign(truth, 8), truth.tick_s, result)
    true = {"actuator": 1 / truth.actuator, "arm": truth.damping, "sensor": 1 / truth.sensor, "delay": truth.delay * truth.tick_s}
    way.lags = {name: (found["lags_s"][name], found["lags_within_s"][name], value) for name, value in true.items()}


def played(rig_of, tick_s, result):
    """RMS of r - y on the rig itself, with the header's loop, without and with compensation, on the triangle of the prediction."""
    low, high = json.loads((result / "verdict.json").read_text())["task_N"]
    return {case: accept.judged(*run(rig_of(), foreign.Loop(result / "loop_params.h", case == "on"), tick_s, low, high)).rms for case in ("off", "on")}


def run(rig, loop, tick_s, low, high):
    """t, r, u in the rig's command, y of the triangle of accept."""
    t = np.arange(int(accept.PERIODS * accept.PERIOD_S / tick_s)) * tick_s
    r = low + (high - low) * (1 - np.abs(2 * (t % accept.PERIOD_S / accept.PERIOD_S) - 1))
    u, y = np.empty(len(r)), np.empty(len(r))
    for k, wanted in enumerate(r):
        y[k] = rig.read()
        u[k] = loop.step(wanted, y[k])
        rig.tick(u[k])
    return t, r, u, y


def accepted(result, rigs, tick_s):
    """Whether accept takes the loop of a result on each of `rigs`, functions that make one; and why not."""
    tree, found = accept.load(result / "loop.yaml"), json.loads((result / "verdict.json").read_text())
    low, high = found["task_N"]
    headers = {}
    for case in accept.CASES:
        path = result.parent / f"{case}.yaml"
        path.write_text(accept.yaml_text(accept.case_of(tree, "on" if case == "off" else case, low, high)), encoding="utf-8")
        headers[case] = path.with_suffix(".h")
        made = native.run_tribo_sim("params", path, "--arith", "f32", "--name", "loop")[0]
        headers[case].write_text(f"#define LOOP_COMMAND_PER_N {found['command_per_N']:.9g}f\n{made}", encoding="utf-8")
    predicted, said = None, {}
    for name, rig_of in rigs.items():
        logs = {case: run(rig_of(), foreign.Loop(headers[case], case != "off"), tick_s, low, high) for case in accept.CASES}
        segments = {case: Segment(case, t, u / found["command_per_N"], y, reference=r, h=tick_s) for case, (t, r, u, y) in logs.items()}
        readings = bins.readings_of(segments["off"].force)
        predicted = predicted or accept.predict(tree, low, high, readings)
        said[name] = accept.judge(tree, segments, readings, predicted)[2]
    return said


# Of the rig over what was identified: breakaway and command; and whether accept has to take the loop.
OTHERS = {"right": (1.0, 1.0, True), "L 5 % less": (0.95, 1.0, True), "L 5 % more": (1.05, 1.0, True), "L 25 % less": (0.75, 1.0, False), "L 25 % more": (1.25, 1.0, False),
          "u 10 % less": (1.0, 0.9, False), "u 10 % more": (1.0, 1.1, False), "no friction": (1e-3, 1.0, False)}


def others(truth, names=tuple(OTHERS)):
    """The rig of a truth, and others near it, for accepted()."""
    return {name: functools.partial(foreign.Foreign, replace(truth, offset=truth.offset * L, slope=truth.slope * L, scale=truth.scale * u), 9) for name in names for L, u, _ in (OTHERS[name],)}
