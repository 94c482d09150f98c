"""tribo-identify: the command line."""

import argparse

from tribo_design.errors import run_command

from . import __version__, accept, actuator, logs, plan


def main(argv=None):
    return run_command("tribo-identify", _run, argv)


def _parser():
    parser = argparse.ArgumentParser(prog="tribo-identify", description="From logs of your own rig to friction parameters.")
    parser.add_argument("--version", action="version", version=f"tribo-identify {__version__}")
    commands = parser.add_subparsers(dest="command", required=True)
    plan.add_options(commands.add_parser("plan", help="the experiment that makes the parameters identifiable, as a reference"))

    command = commands.add_parser("friction", help="breakaway, command and hysteresis from logs; or refusal with its reason")
    logs.add_options(command)
    command.add_argument("--out", metavar="DIR", help="friction.yaml, report.html; with --scenario also loop.yaml and loop_params.h")
    command.add_argument("--assume", choices=("symmetric", "calibrated"),
                         help="symmetric: L+ = L-, scale and bias of u are fitted; calibrated: u is right, L+ and L- are fitted (neither: symmetric, but called weak where a scale other than 1 rests on it)")
    command.add_argument("--scenario", metavar="BASE.yaml", help="the loop of your rig, as tribo-design writes it; its friction is replaced")
    command.add_argument("--arith", choices=("f32", "q31"), default="f32", help="of loop_params.h (f32)")
    for name, unit, what in (("actuator", "RAD/S", "pole of the actuator; 0: none (all three found together, if none is given)"), ("sensor", "RAD/S", "pole of the force sensor; 0: none"),
                             ("lag", "S", "of the arm, b/K")):
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
