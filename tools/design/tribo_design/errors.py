"""The errors that the tools print instead of a traceback."""

import math
import os
import sys

from tribo_plot import output

from . import progress


class DesignError(Exception):
    """An error in the user's terms. The command line prints it and exits with `exit_code`."""

    exit_code = 1


class InputError(DesignError):
    """An input file or option is wrong. The text names file, line, field, value and what is allowed."""

    exit_code = 2


NUMBER_MIN = 1.2e-38  # the limit of tribo-sim's reader, because all settings are float32


def check_number(value):
    """Returns a number unchanged if it is in a plausible range, otherwise raises ValueError."""
    if not math.isfinite(value):
        raise ValueError("must be finite")
    if 0 < abs(value) < NUMBER_MIN:
        raise ValueError(f"is too small for a number: 0, or at least {NUMBER_MIN:g} in size")
    return value


class IllPosedError(DesignError):
    """The synthesis problem has no solution. `cause` is one of CAUSES."""

    exit_code = 3

    def __init__(self, cause, text):
        assert cause in CAUSES, cause
        super().__init__(text)
        self.cause = cause


class LimitError(DesignError):
    """A step exceeded a limit of the design file. `table` is the table up to that step."""

    exit_code = 4

    def __init__(self, text, table=""):
        super().__init__(text)
        self.table = table


class DisagreementError(DesignError):
    """`check` found that the generated files disagree with each other or with the loop they make."""

    exit_code = 5


CAUSES = (
    "unstable weight",
    "uncontrollable weight",
    "improper weight",
    "plant pole on the imaginary axis",
    "plant",
    "rank condition",
    "contradicting weights",
    "time limit",
    "numerical",
    "unstable controller",
)


def run_command(program, run, argv):
    """run(argv), its exit status; errors in the user's terms, and what takes long says so."""
    return output.run(program, _run_command, program, run, argv)


def _run_command(program, run, argv):
    try:
        with progress.shown(program):
            return run(argv)
    except DesignError as error:
        if isinstance(error, LimitError):
            print(error.table, end="\n" if error.table else "")
        for line in str(error).splitlines():
            print(f"{program}: {line}", file=sys.stderr)
        if isinstance(error, LimitError):
            print(f"{program}: nothing was written", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print(f"{program}: interrupted", file=sys.stderr)
        return 130
    except output.PlaceError as error:
        print(f"{program}: {error}", file=sys.stderr)
        return InputError.exit_code
    except Exception as error:  # noqa: BLE001 - never a traceback; TRIBO_DESIGN_DEBUG=1 shows it to a developer
        if isinstance(error, OSError) and output.is_lost(error):
            raise
        if os.environ.get("TRIBO_DESIGN_DEBUG"):
            raise
        print(f"{program}: internal error ({type(error).__name__}: {error}); please report it with its input files. TRIBO_DESIGN_DEBUG=1 shows where", file=sys.stderr)
        return 70
