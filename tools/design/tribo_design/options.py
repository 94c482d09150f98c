"""Options that several commands have. Nothing but the standard library: see cli.py."""

from .errors import InputError, check_number


def add_number(command, name, **more):
    """Adds an option for a number in a plausible range."""

    def number(text):
        try:
            return check_number(float(text))
        except ValueError as error:
            if "could not convert" in str(error):
                raise
            raise InputError(f"{name}: value {text}: {error}") from None

    command.add_argument(name, type=number, **more)


def add_columns(command):
    """Adds the options for reading a log with logs.py of tribo_identify."""
    command.add_argument("--column", action="append", default=[], metavar="ROLE=NAME", help="where t, u, F, x, v or r is, e.g. u=torque_cmd or u=#2; as in tribo-sim replay")
    command.add_argument("--unit", action="append", default=[], metavar="ROLE=UNIT", help="e.g. t=ms, F=mN")
    command.add_argument("--scale", action="append", default=[], metavar="ROLE=X", help="multiplies a column; `-` changes its sign")
    command.add_argument("--bias", action="append", default=[], metavar="ROLE=X", help="added after the scale")
    command.add_argument("--resample", nargs="?", const="", metavar="S", help="mends stamps that jitter, and small gaps")
    command.add_argument("--gap", metavar="S", help="with --resample: a longer gap splits the log")
