"""The command line of every tool in Python. Only the standard library."""

import argparse
import shlex


class Parser(argparse.ArgumentParser):
    """Takes an option once, and one of NAME=VALUE once for each NAME, as the programs in C do (common/support/options.c)."""

    def parse_known_args(self, args=None, namespace=None):
        self._given = {}
        return super().parse_known_args(args, namespace)

    def _get_values(self, action, arg_strings):
        if action.option_strings:
            self._note(action, " ".join([action.option_strings[-1], *arg_strings]), arg_strings)
        return super()._get_values(action, arg_strings)

    def _note(self, action, words, values):
        is_assignment = "=" in str(action.metavar)
        if isinstance(action, argparse._AppendAction) and not is_assignment:
            return
        what = action.dest, values[0].partition("=")[0] if is_assignment else None
        before = self._given.get(what)
        if before is not None:
            raise argparse.ArgumentError(None, f"{before} and {words}: only one is expected" if values else f"{words} is given twice")
        self._given[what] = words


def quoted(path):
    """Returns a path as a shell takes it, in quotes if it needs them, with ./ ahead of a hyphen, which would begin an option."""
    return shlex.quote("./" * str(path).startswith("-") + str(path))
