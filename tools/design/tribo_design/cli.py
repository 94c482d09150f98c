"""tribo-design: the command line. Nothing but the standard library until a command runs: --help starts at once, a build makes the manual page."""

import argparse
import importlib

from tribo_plot.command_line import Parser
from tribo_plot.version import add_option

from . import tuning
from .errors import run_command
from .fields import FIELDS
from .options import add_columns, add_number


def main(argv=None):
    return run_command("tribo-design", _run, argv)


def _parser():
    parser = Parser(prog="tribo-design", description="From a plant and weights to checked C coefficients.")
    add_option(parser, "tribo-design")
    commands = parser.add_subparsers(dest="command", required=True)

    command = _add(commands, "synthesize", "weights + plant -> K(s) -> reduced -> discrete -> sections -> f32 -> Q31", epilog="DESIGN.yaml: " + FIELDS.replace("%", "%%"),
                   formatter_class=argparse.RawDescriptionHelpFormatter)
    command.add_argument("design", metavar="DESIGN.yaml", help="plant, weights, sample time and limits")
    command.add_argument("--out", required=True, metavar="DIR", help="directory for the C, JSON and reports; replaced when it is an earlier output")
    command.add_argument("--no-plots", action="store_true", help="reports without plots (faster)")
    add_number(command, "--time-limit", metavar="SECONDS", help="instead of synthesis.time_limit_s")

    command = _add(commands, "import", "a controller made elsewhere, checked and converted")
    command.add_argument("controller", metavar="K.json|K.csv|K.mat", help="state space, zeros and poles, transfer function or sections")
    command.add_argument("--design", required=True, metavar="DESIGN.yaml", help="plant, sample time and limits; weights may be left out")
    command.add_argument("--out", required=True, metavar="DIR", help="as of synthesize")
    command.add_argument("--no-plots", action="store_true", help="likewise")

    command = _add(commands, "identify-plant", "gain and poles from an open-loop step response")
    command.add_argument("step", metavar="STEP.csv", help="columns t_s, u_N and F_N, or t_s, u_n and y_n (no u with --step-size)")
    add_number(command, "--step-size", metavar="U", help="height of the input step at the first sample, when there is no column u")
    command.add_argument("--no-friction", action="store_true", help="friction is known to be negligible: the gain needs no second height and direction then")
    command.add_argument("--order", type=int, metavar="N", help="number of poles, 1 to 6 (default: the order the data supports)")
    add_columns(command)
    command.add_argument("--out", metavar="DIR", help="writes plant.yaml, identification.json and a report with a plot")

    command = _add(commands, "compare", "several designs in one table, each with friction in its loop")
    command.add_argument("designs", nargs="+", metavar="DESIGN.yaml|DIR", help="design files, and directories that synthesize or import made")
    command.add_argument("--structures", metavar="NAME,...", help="each design file with each of full, pi, pid, lead-lag; directories are taken as they are")

    tuning.add_options(_add(commands, "tune", "parameters of the feed-forward and its guard from what is known of a rig"))

    command = _add(commands, "check", "reads generated files back from the C header and verifies the loop again")
    command.add_argument("dir", metavar="DIR", help="that synthesize or import made")
    return parser


def _add(commands, name, text, **more):
    return commands.add_parser(name, help=text.replace("%", "%%"), description=text, **more)


RUNS = {"synthesize": "commands.synthesize", "import": "commands.import_controller", "identify-plant": "identify.command", "compare": "compare.command",
        "tune": "tuning.command", "check": "check.command"}  # imported only for a command that runs


def _run(argv):
    options = _parser().parse_args(argv)
    module, function = RUNS[options.command].split(".")
    return getattr(importlib.import_module(f".{module}", __package__), function)(options)
