"""tribo takes the friction out of motor drives; this is its Python package.

It runs the project's own C: a run has the same bits as `tribo-sim run`.

>>> import tribo
>>> run = tribo.run("triangle", gain=0.9, method="paper")
>>> len(run.t_s), float(run.r_N.max())
(60000, 0.6)
>>> run.summary.rms_error_N < 0.002
True

Parts of a loop can be stepped separately, tick by tick or over arrays.

>>> loop = tribo.Loop()
>>> u_N = loop.step(0.5, 0.0)
>>> u_N == loop.signals["u_N"]
True

A refusal of the library raises an exception that names the key.

>>> tribo.Friction(k_min=0.5)
Traceback (most recent call last):
    ...
tribo.StatusError: compensator.friction.k_min: friction k_min: 1.01 to 1000; at most k_max
"""

from ._core import PARAMETERS, Parameter, ScenarioError, StatusError, __version__, scenarios
from ._doors import Axis, AxisReport, Joint, JointForce, JointReport
from ._parts import Compensator, FeedForward, Friction, Guard, Loop
from ._plot import Record
from ._run import Difference, Learned, Run, Summary, run
from ._study import Study
from ._sweep import SweepError, sweep, sweep_report

__all__ = ["PARAMETERS", "Axis", "AxisReport", "Compensator", "Difference", "FeedForward", "Friction", "Guard", "Joint", "JointForce", "JointReport", "Learned", "Loop", "Parameter", "Record", "Run", "ScenarioError", "StatusError",
           "Study", "Summary", "SweepError", "__version__", "run", "scenarios", "sweep", "sweep_report"]

for _public in (Axis, AxisReport, Compensator, Difference, FeedForward, Friction, Guard, Joint, JointForce, JointReport, Learned, Loop, Parameter, Record, Run, ScenarioError, StatusError, Study, Summary, SweepError, run, scenarios, sweep, sweep_report):
    _public.__module__ = "tribo"
