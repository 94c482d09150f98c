"""Prints the progress of a long command to stderr: a line after two seconds, then one every few seconds, fewer if stderr is a file.

A line names what the command is at, as the last `at` has it. A thread writes it, so that no loop has to ask for the time.
"""

import contextlib
import sys
import threading
import time

FIRST_S = 2.0
TERMINAL_S, FILE_S = 5.0, 30.0
_now = {"doing": ""}


def at(doing):
    """Names what the command does from here on, in a few words."""
    _now["doing"] = doing


def _tell(program, stream, end):
    begin, wait = time.monotonic(), FIRST_S
    while not end.wait(wait):
        wait = TERMINAL_S if stream.isatty() else FILE_S
        try:
            print(f"{program}: {time.monotonic() - begin:.0f} s: {_now['doing']}", file=stream, flush=True)
        except (OSError, ValueError):  # stderr is closed
            return


@contextlib.contextmanager
def shown(program):
    """Tells while the body runs; not within a command that another one calls."""
    if threading.current_thread() is not threading.main_thread() or "telling" in _now:
        yield
        return
    end = threading.Event()
    teller = threading.Thread(target=_tell, args=(program, sys.stderr, end), daemon=True)
    _now.update(doing="at work", telling=True)
    teller.start()
    try:
        yield
    finally:
        end.set()
        teller.join()
        del _now["telling"]
