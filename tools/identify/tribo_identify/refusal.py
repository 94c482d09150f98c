"""The reasons why a log cannot tell the parameters."""

from tribo_design.errors import DesignError

CAUSES = ("silent", "units", "sign", "one direction", "few loads", "saturated", "ripple", "clock", "held", "model", "no stiction", "jumps", "exchanged", "noise", "loop")


class Refusal(DesignError):
    """The log cannot tell the parameters. `cause` is one of CAUSES."""

    exit_code = 3

    def __init__(self, cause, text):
        assert cause in CAUSES, cause
        super().__init__(text)
        self.cause = cause
