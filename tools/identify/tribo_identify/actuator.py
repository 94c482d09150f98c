"""tribo-identify actuator: finds gain, poles and delay of actuator, arm and sensor from a log, with identify-plant of tools/design."""

import numpy as np

from tribo_design import identify
from tribo_design.errors import DesignError, InputError
from tribo_design.output import check_replaceable, write_directory

from . import logs

NAMES = ("plant.yaml", "actuator.txt")
ROWS_MAX = 20_000


def data_of(log):
    """Returns one record for identify-plant, thinned to the number of rows that it uses."""
    data = identify.data_of(log)
    every = max(len(data.time) // ROWS_MAX, 1)
    return identify.Data(data.time[::every], data.u[::every], data.y[::every])


def arm_of(found, stiffness):
    """Describes the poles: the complex pair belongs to the arm, I s^2 + b s + K; real poles belong to the actuator, the sensor or a damped arm."""
    lines = []
    pairs = [p for p in found["poles"] if p["im"] > 0]
    real = sorted(-p["re"] for p in found["poles"] if not p["im"])
    for p in pairs:
        size = np.hypot(p["re"], p["im"])
        part = p["size_high"] / size - 1
        interval = f" (size of the pair +- {100 * part:.2g} %, 95 %)" if p["identifiable"] and found["trusted"] else " (without an interval)"
        lines.append(f"arm: I {stiffness / size**2:.4g} N s^2/deg, b {2 * -p['re'] / size**2 * stiffness:.4g} N s/deg at K {stiffness:g} N/deg, lag b/K {2 * -p['re'] / size**2:.4g} s{interval}")
    if real:
        lines.append(f"real poles {', '.join(f'{r:.4g}' for r in real)} rad/s: of actuator and sensor; u and F do not tell which is which"
                     + ("" if pairs else "; or of a damped arm"))
    return lines


def command(options):
    stiffness = 3.84 if options.stiffness is None else options.stiffness
    if not 1e-12 <= stiffness <= 1e12:
        raise InputError(f"--stiffness: value {stiffness:g}: must be 1e-12 to 1e12 N/deg")
    if options.order is not None and not 1 <= options.order <= identify.ORDER_MAX:
        raise InputError(f"--order: value {options.order}: must be at least 1 and at most {identify.ORDER_MAX}")
    if options.out:
        check_replaceable(options.out, NAMES)
    log = logs.read(options.logs, logs.arguments_of(options))
    found, *_ = identify.identify(data_of(log), options.order, options.no_friction)
    text = "\n".join([identify.describe(found), *arm_of(found, stiffness), *(f"note  {r}" for r in log.remarks)])
    print(text)
    if not found["separable"]:
        raise DesignError(f"no answer: {identify.NOT_SEPARABLE}")
    if not found["trusted"]:
        raise DesignError("no answer: " + "; ".join(found["remarks"]))
    if options.out:
        write_directory(options.out, {"plant.yaml": identify.plant_yaml(found, log.segments[0].file).encode(), "actuator.txt": (text + "\n").encode()}, NAMES)
        print(f"wrote {options.out}: {', '.join(NAMES)}")
    return 0
