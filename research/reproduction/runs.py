"""Runs tribo-sim and returns its results as arrays."""

import json
import pathlib
import subprocess
import types

import numpy as np

PAPER = ("compensator.method=paper", "compensator.guard.on=no")  # its method without the guard
FINE_S = 1e-4  # step of the open-loop runs: u changes at every step of the plant, as in the paper's simulations


class Runs:
    """Runs scenarios in their own folder and keeps them there, so that each can be run again by hand."""

    def __init__(self, sim, bench, folder):
        self.sim = str(pathlib.Path(sim).resolve())
        self.bench = bench
        self.folder = pathlib.Path(folder).resolve()
        self.folder.mkdir(parents=True, exist_ok=True)

    def _call(self, *arguments):
        return subprocess.run([self.sim, *arguments], cwd=self.folder, check=True, stdout=subprocess.PIPE, text=True).stdout

    def open_loop(self, name, corners, sets=(), columns=("F_N",), model="paper"):
        """Runs the plant alone, without the actuator's lag. `corners`: (t in s, u in N). Returns t, u and the columns."""
        write_csv(self.folder / f"{name}_u.csv", "t_s,r_N", corners)
        lines = (
            f"duration_s: {corners[-1][0]}",
            f"sample_time_s: {FINE_S}",
            f"reference: {{kind: csv, file: {name}_u.csv}}",
            "controller: {kind: none}",
            f"plant: {{model: {model}, step_s: {FINE_S}, actuator_pole_rad_per_s: 1e9}}",
        )
        (self.folder / f"{name}.yaml").write_text("\n".join(lines) + "\n", encoding="utf-8")
        return self.scenario(f"{name}.yaml", sets, ("u_N", *columns))

    def scenario(self, scenario, sets=(), columns=("r_N", "F_N")):
        """Returns the trace of a scenario. Removes the file after reading, because a fine trace has a hundred megabytes."""
        options = [option for setting in (*PAPER, *sets) for option in ("--set", setting)]
        self._call("run", scenario, *options, "--out", "trace")
        path = self.folder / "trace" / "trace.csv"
        trace = read_csv(path, ("t_s", *columns))
        path.unlink()
        return trace

    def summary(self, scenario, sets=()):
        options = [option for setting in (*PAPER, *sets) for option in ("--set", setting)]
        return json.loads(self._call("run", scenario, *options, "--json"))

    def friction(self, name, times, net, force_n=0.5, params=""):
        """Runs the compensator's friction law alone, on the net force `net`, while F stands at `force_n`."""
        rows = np.column_stack((times, force_n + net, np.full_like(net, force_n)))
        write_csv(self.folder / f"{name}.csv", "t_s,u_N,F_N", rows)
        (self.folder / f"{name}.yaml").write_text(params or "friction: {}\n", encoding="utf-8")
        self._call("replay", f"{name}.csv", "--params", f"{name}.yaml", "--force", "measured", "--out", f"{name}_out.csv")
        return read_csv(self.folder / f"{name}_out.csv")

    def solver_times(self):
        """Returns the bench's table of section 4: (method, model, steps, right-hand sides, ms)."""
        output = subprocess.run([self.bench], check=True, stdout=subprocess.PIPE, text=True).stdout
        rows = []
        for line in output.split("Section 4", 1)[1].split("\n\n")[0].splitlines()[2:]:
            words = line[35:].split()
            if words and words[0] in ("paper", "lugre"):
                rows.append((line[:35].strip(), words[0], int(words[1]), int(words[2]), float(words[3])))
        return rows


def write_csv(path, header, rows):
    np.savetxt(path, np.asarray(rows), fmt="%.12g", delimiter=",", header=header, comments="")


def read_csv(path, columns=None):
    """Columns by name: trace.F_N is an array."""
    with open(path, encoding="utf-8") as file:
        names = file.readline().strip().split(",")
    wanted = [i for i, name in enumerate(names) if columns is None or name in columns]
    values = np.loadtxt(path, delimiter=",", skiprows=1, usecols=wanted, ndmin=2)
    return types.SimpleNamespace(**{names[i]: values[:, column] for column, i in enumerate(wanted)})


def ramps(*corners):
    """Returns the corners of a polygon from (u, rate in N/s) one after another, from 0 N at 0 s; rate 0 holds for `u` s."""
    points = [(0.0, 0.0)]
    for level, speed in corners:
        t, u = points[-1]
        points.append((t + level, u) if speed == 0 else (t + abs(level - u) / speed, level))
    return points
