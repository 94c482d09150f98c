"""The command line of tribo-identify. It imports only the standard library until a command runs, so that --help starts at once and a build can make the manual page."""

import importlib

from tribo_design.options import add_columns, add_number
from tribo_design.errors import run_command
from tribo_plot.command_line import Parser
from tribo_plot.version import add_option


def main(argv=None):
    return run_command("tribo-identify", _run, argv)


def _parser():
    parser = Parser(prog="tribo-identify", description="Finds friction parameters from logs of your own rig.")
    add_option(parser, "tribo-identify")
    commands = parser.add_subparsers(dest="command", required=True)
    _add_plan(commands)
    _add_friction(commands)
    _add_actuator(commands)
    _add_accept(commands)
    return parser


def _add(commands, name, text):
    return commands.add_parser(name, help=text.replace("%", "%%"), description=text)


def _add_plan(commands):
    command = _add(commands, "plan", "writes an experiment that makes the parameters identifiable, as a reference")
    add_number(command, "--low", required=True, metavar="N", help="smallest force and command that is safe")
    add_number(command, "--high", required=True, metavar="N", help="largest force and command that is safe; u never goes beyond it, and so F does not")
    command.add_argument("--levels", type=int, default=4, metavar="N", help="number of loads, 4 to 32 (4)")
    command.add_argument("--repeats", type=int, default=2, metavar="N", help="number of repeats, 2 to 100 (2)")
    add_number(command, "--rate", metavar="N/S", help="rate of u in the fastest cycles (twice the largest force per second)")
    add_number(command, "--offset", metavar="N", help="estimate of the breakaway without load (0.01 of the largest force)")
    add_number(command, "--slope", default=0.3, metavar="X", help="estimate of the growth of breakaway with load (0.3)")
    add_number(command, "--noise", default=0.0, metavar="N", help="noise of the force sensor, rms (0)")
    add_number(command, "--u-max", metavar="N", help="largest command of the drive")
    add_number(command, "--sample-time", default=1e-3, dest="sample_time_s", metavar="S", help="sample time of the control loop (0.001)")
    command.add_argument("--hysteresis", action="store_true", help="adds ramps inside stiction for k_min, k_max, m and v0; these take minutes")
    command.add_argument("--out", required=True, metavar="DIR", help="folder for plan.csv (t_s, r_N) and plan.yaml, the scenario that runs it")


def _add_friction(commands):
    command = _add(commands, "friction", "finds breakaway, command scale and hysteresis from logs, or refuses and says why")
    _add_logs(command)
    command.add_argument("--out", metavar="DIR", help="folder for friction.yaml and report.html; with --scenario also loop.yaml and loop_params.h")
    command.add_argument("--assume", choices=("symmetric", "calibrated"),
                         help="symmetric: L+ = L-, and scale and bias of u are fitted; calibrated: u is right, and L+ and L- are fitted (without it: symmetric, but values are weak if the scale is not 1)")
    command.add_argument("--scenario", metavar="BASE.yaml", help="loop of your rig, as tribo-design writes it; its friction is replaced")
    command.add_argument("--arith", choices=("f32", "q31"), help="arithmetic of loop_params.h (f32)")
    for name, unit, what in (("actuator", "RAD/S", "pole of the actuator; 0: none (without these three options their lags are found together)"), ("sensor", "RAD/S", "pole of the force sensor; 0: none"),
                             ("lag", "S", "lag of the arm, b/K")):
        add_number(command, f"--{name}", metavar=unit, help=what)


def _add_actuator(commands):
    command = _add(commands, "actuator", "finds gain, poles and delay of actuator, arm and sensor with tribo-design identify-plant")
    _add_logs(command)
    command.add_argument("--no-friction", action="store_true", help="the record stays within stiction, or friction is negligible: then the gain needs no second step height and direction")
    command.add_argument("--order", type=int, metavar="N", help="number of poles, 1 to 6 (chosen from the data)")
    add_number(command, "--stiffness", metavar="K", help="stiffness of the environment, N per degree (3.84); I and b are scaled with it")
    command.add_argument("--out", metavar="DIR", help="folder for plant.yaml (the plant of a design file) and actuator.txt")


def _add_accept(commands):
    command = _add(commands, "accept", "runs an acceptance test on the rig, with compensation off, on, and with L 20 % less and more; decides between new and old parameters")
    command.add_argument("loop", metavar="LOOP.yaml", help="loop with the new parameters, as tribo-identify friction --scenario writes it")
    add_number(command, "--low", metavar="N", help="smallest force of the sequence")
    add_number(command, "--high", metavar="N", help="largest force of the sequence")
    for case, what in (("off", "without compensation"), ("on", "with it"), ("less", "with L 20 %% less"), ("more", "with L 20 %% more")):
        command.add_argument(f"--{case}", metavar="LOG.csv", help=f"log of the rig {what}: t, r, u, F")
    command.add_argument("--old", metavar="OLD.yaml", help="loop with the old parameters, which stay unless the new ones are better")
    command.add_argument("--old-log", metavar="LOG.csv", help="log of the rig with the old parameters")
    add_columns(command)
    command.add_argument("--out", required=True, metavar="DIR", help="folder: without logs for the sequence, off.yaml to more.yaml; with logs for accepted.yaml, report.html and verdict.json")


def _add_logs(command):
    command.add_argument("logs", nargs="+", metavar="LOG.csv", help="logs of one experiment")
    add_columns(command)


RUNS = {"plan": "plan.command", "friction": "command_friction.run", "actuator": "actuator.command", "accept": "accept.command"}  # imported only for a command that runs


def _run(argv):
    options = _parser().parse_args(argv)
    module, function = RUNS[options.command].split(".")
    return getattr(importlib.import_module(f".{module}", __package__), function)(options)
