"""The whole way of a foreign rig: tribo-rig writes what to play, the foreign simulator plays it, and the generated header runs on it in the end."""

import contextlib
import io
import json
from dataclasses import dataclass

import foreign
import numpy as np

from tribo_identify import accept
from tribo_rig import cli


@dataclass
class Way:
    exit_code: int  # of the last call
    said: str
    beyond: float = 0.0  # largest force or command over the safe one, as a part of it
    predicted: dict = None  # rms of r - y by case, N
    played: dict = None

    @property
    def factor(self):
        return self.played["off"] / self.played["on"]

    def off_by(self, case):
        return self.predicted[case] / self.played[case] - 1


def call(folder):
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        code = cli.main([str(folder)])
    return code, out.getvalue()


def go(truth, folder):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rig.yaml").write_text(f"sample_time_s: {truth.tick_s}\nforce: {{low_N: 0, high_N: {truth.high:.6g}}}\nlog: {{columns: {{F: y}}}}\n")
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


def played(rig_of, tick_s, result):
    """RMS of r - y on the rig itself, with the header's loop, without and with compensation, on the triangle of the prediction."""
    low, high = json.loads((result / "verdict.json").read_text())["task_N"]
    t = np.arange(int(accept.PERIODS * accept.PERIOD_S / tick_s)) * tick_s
    r = low + (high - low) * (1 - np.abs(2 * (t % accept.PERIOD_S / accept.PERIOD_S) - 1))
    found = {}
    for case in ("off", "on"):
        rig, loop, u, y = rig_of(), foreign.Loop(result / "loop_params.h", case == "on"), np.empty(len(r)), np.empty(len(r))
        for k, wanted in enumerate(r):
            y[k] = rig.read()
            u[k] = loop.step(wanted, y[k])
            rig.tick(u[k])
        found[case] = accept.judged(t, r, u, y).rms
    return found
