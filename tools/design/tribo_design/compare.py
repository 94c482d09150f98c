"""compare: several designs in one table, with what gamma does not say: the loop with friction in it, and what it stands."""

import json
from pathlib import Path

import numpy as np

from . import check, friction, pipeline, synthesis
from .config import load_design
from .errors import DesignError, DisagreementError, InputError
from .structured import STRUCTURES

HEADER = ["design", "structure", "order", "gamma", "max abs S", "max abs GS", "gain margin", "phase margin [deg]", "delay margin [s]", "bandwidth [rad/s]", "worst max abs S",
          "RMS r - F [N], without", "with", "times less"]
NAMES = ("gamma", "max_s", "max_gs", "gain_margin", "phase_margin_deg", "delay_margin_s", "bandwidth_rad_s")


def command(options):
    wanted = options.structures.split(",") if options.structures else [None]
    for name in wanted:
        if name not in (None, "full", *STRUCTURES):
            raise InputError(f"--structures: value {name!r}: must be some of full, {', '.join(STRUCTURES)}, with commas between")
    if options.structures and all(Path(path).is_dir() for path in options.designs):
        raise InputError("--structures: is of design files, and only directories are given, whose structure is made already")
    rows, refused, notes = [], [], []
    for path in options.designs:
        directory = Path(path).is_dir()
        for structure in [None] if directory else wanted:  # a directory contains a finished design
            title = Path(path).name + (f", {structure}" if structure else "")
            try:
                row, note = _of_directory(Path(path)) if directory else _of_file(path, structure)
            except InputError:
                raise
            except DesignError as error:
                refused.append(f"{title}: {error}")
                continue
            rows.append(row)
            if note:
                notes.append(f"{title}: {note}")
    if rows:
        print(pipeline.aligned([HEADER, *rows]))
        print("After Q31, with hold and delay. Friction is the paper's, in the triangle of each design's scenario, played by tribo-sim.")
    for note in notes:
        print(f"note: {note}")
    if refused:
        raise DesignError("\n".join(f"refused: {text}" for text in refused))
    return 0


def _of_file(path, structure):
    design, digest = load_design(path)
    if structure is not None:
        design = design.model_copy(update={"synthesis": design.synthesis.model_copy(update={"structure": structure})})
        if structure != "full" and design.synthesis.domain == "continuous":
            raise InputError(f"{path}: synthesis.domain: value continuous: must be sampled for structure {structure}")
    result = pipeline.synthesize(design, digest, Path(path).name)
    played = friction.play(design, result.plant, result.f32)
    return _row(design, result.sampled.order, result.stages[-1].metrics.as_dict(), result.robustness, played)


def _of_directory(directory):
    """Reads an earlier output; it is used only if `check` agrees with it."""
    _, problems = check.check(directory)
    if problems:
        raise DisagreementError("; ".join(problems))
    design, _ = load_design(directory / "DESIGN.yaml")
    data = json.loads((directory / f"{design.name}_design.json").read_text())
    plant, _ = synthesis.make_plant(design.plant)
    played = friction.play(design, plant, np.array(data["sections"]["f32"]))
    return _row(design, len(data["discrete"]["poles"]), data["metrics"]["q31"], data["robustness"], played)


def _row(design, order, metrics, robustness, played):
    def cell(value):
        return "-" if value is None else value if isinstance(value, str) else f"{value:.4g}"

    times, note = ["-"] * 3, played.get("reason") and f"friction not simulated, as {played['reason']}"
    if "rms_n" in played:
        without, with_it = played["rms_n"]["without"], played["rms_n"]["with"]
        times = [f"{without:.4g}", f"{with_it:.4g}", f"{without / with_it:.2f}"]
        if with_it >= without:
            note = friction.in_words(played)
    worst = (robustness or {}).get("worst", {}).get("max_s")
    return [design.name, design.synthesis.structure, str(order), *(cell(metrics[name]) for name in NAMES), cell(worst), *times], note
