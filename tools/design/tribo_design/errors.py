"""What the tool says instead of a traceback."""


class DesignError(Exception):
    """An error in the user's terms. The command line prints it and exits with `exit_code`."""

    exit_code = 1


class InputError(DesignError):
    """An input file or option is wrong. The text names file, line, field, value and what is allowed."""

    exit_code = 2


class IllPosedError(DesignError):
    """The synthesis problem has no solution. `cause` is one of CAUSES."""

    exit_code = 3

    def __init__(self, cause, text):
        assert cause in CAUSES, cause
        super().__init__(text)
        self.cause = cause


class LimitError(DesignError):
    """A step took the loop past a limit of the design file. `table` is the table up to that step."""

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
