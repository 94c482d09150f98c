"""The line through the slides where friction builds up over a way, so that it follows a breakaway that grows with F late."""

import numpy as np
import pytest

from tribo_identify import slides
from tribo_identify.logs import Log, Segment

OFFSET, SLOPE, H = 0.3, 0.3, 2e-3


def late_log(stiff):
    """Triangles of F from 2 to 10 N at two rates, u = F + f with df/dF = stiff (1 -+ f/L), as bristles `stiff` times the arm's stiffness have it at rest of all else."""
    turns = np.cumsum([0, *np.repeat([8.0, 4.0], 16)])
    t = np.arange(0, turns[-1], H)
    force = np.interp(t, turns, 2 + 8 * (np.arange(len(turns)) % 2))
    f, u = 0.0, np.empty(len(t))
    for k in range(len(t)):
        change = force[k] - force[max(k - 1, 0)]
        level = OFFSET + SLOPE * force[k]
        f = np.sign(change) * level + (f - np.sign(change) * level) * np.exp(-stiff * abs(change) / level)
        u[k] = force[k] + f
    return Log([Segment("late", t, u, force, h=H)], H)


def halves(line):
    return dict(zip(line.values, (np.percentile(line.draws, 97.5, axis=0) - np.percentile(line.draws, 2.5, axis=0)) / 2))


@pytest.mark.parametrize("stiff", [15.0, 30.0])
def test_the_interval_of_the_scale_covers_friction_that_follows_its_load_late(stiff):
    line = slides.line(late_log(stiff), "symmetric")
    off = line.values["scale"] - 1
    assert off == pytest.approx(SLOPE**2 / stiff, rel=0.2)  # the error itself, in all slides alike
    assert off < halves(line)["scale"] < 3 * off


def test_friction_that_does_not_build_up_widens_no_interval():
    assert halves(slides.line(late_log(1e4), "symmetric"))["scale"] < 1e-3


@pytest.mark.parametrize("name, sign", [("slope_positive", -1), ("slope_negative", 1)])
def test_where_u_is_right_the_late_friction_is_each_directions(name, sign):
    line = slides.line(late_log(15.0), "calibrated")
    off = line.values[name] - SLOPE
    assert off == pytest.approx(sign * SLOPE**2 / 15, rel=0.3) and abs(off) < halves(line)[name]
