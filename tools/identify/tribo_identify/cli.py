"""tribo-identify: the command line."""

import argparse
import os
import sys

from tribo_design.errors import DesignError

from . import __version__, accept, actuator, logs, plan


def main(argv=None):
    try:
        return _run(argv)
    except DesignError as error:
        print(f"tribo-identify: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print("tribo-identify: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except Exception as error:  # noqa: BLE001 - never a traceback; TRIBO_DESIGN_DEBUG=1 shows it to a developer
        if os.environ.get("TRIBO_DESIGN_DEBUG"):
            raise
        print(f"tribo-identify: internal error ({type(error).__name__}: {error}); please report it with the log. TRIBO_DESIGN_DEBUG=1 shows where", file=sys.stderr)
        return 70


def _parser():
    parser = argparse.ArgumentParser(prog="tribo-identify", description="From logs of your own rig to friction parameters.")
    parser.add_argument("--version", action="version", version=f"tribo-identify {__version__}")
    commands = parser.add_subparsers(dest="command", required=True)
    plan.add_options(commands.add_parser("plan", help="the experiment that makes the parameters identifiable, as a reference"))

    command = commands.add_parser("friction", help="breakaway, command and hysteresis from logs; or refusal with its reason")
    logs.add_options(command)
    command.add_argument("--out", metavar="DIR", help="friction.yaml, report.html; with --scenario also loop.yaml and loop_params.h")
    command.add_argument("--assume", choices=("symmetric", "calibrated"), default="symmetric",
                         help="symmetric: L+ = L-, scale and bias of u are fitted; calibrated: u is right, L+ and L- are fitted (symmetric)")
    command.add_argument("--scenario", metavar="BASE.yaml", help="the loop of your rig, as tribo-design writes it; its friction is replaced")
    command.add_argument("--arith", choices=("f32", "q31"), default="f32", help="of loop_params.h (f32)")
    for name, unit, what in (("actuator", "RAD/S", "pole of the actuator; 0: none (200)"), ("sensor", "RAD/S", "pole of the force sensor; 0: none (55)"),
                             ("lag", "S", "of the arm, b/K (0.0075)")):
        command.add_argument(f"--{name}", type=float, metavar=unit, help=what)
    actuator.add_options(commands.add_parser("actuator", help="gain, poles and delay of actuator, arm and sensor, by tribo-design identify-plant"))
    accept.add_options(commands.add_parser("accept", help="an acceptance test on the rig: compensation off, on, with L 20 %% less and more; the new parameters or the old ones"))
    return parser


def _run(argv):
    options = _parser().parse_args(argv)
    if options.command == "plan":
        return plan.command(options)
    if options.command == "accept":
        return accept.command(options)
    if options.command == "actuator":
        return actuator.command(options)
    from . import command_friction

    return command_friction.run(options)
