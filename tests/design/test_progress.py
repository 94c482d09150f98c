"""What takes long says what it does: on stderr, not at once, and each tool through run_command."""

import io
import re
import threading

import numpy as np
import pytest

from tribo_design import progress
from tribo_design.errors import InputError, run_command
from tribo_design.identify import Data, identify


class Stream(io.StringIO):
    """Counts its lines, and may be a terminal."""

    def __init__(self, is_terminal):
        super().__init__()
        self.is_terminal, self.lines = is_terminal, threading.Semaphore(0)

    def isatty(self):
        return self.is_terminal

    def write(self, text):
        super().write(text)
        if text.endswith("\n"):
            self.lines.release()


@pytest.fixture
def quick(monkeypatch):
    """The first line at once, a terminal's next ones as soon, a file's never."""
    monkeypatch.setattr(progress, "FIRST_S", 0.0)
    monkeypatch.setattr(progress, "TERMINAL_S", 0.0)
    monkeypatch.setattr(progress, "FILE_S", 1000.0)

    def watch(is_terminal=False):
        stream = Stream(is_terminal)
        monkeypatch.setattr("sys.stderr", stream)
        return stream

    return watch


def test_a_slow_command_prints_its_progress(quick):
    stream = quick(is_terminal=True)

    def run(argv):
        progress.at("counts the bristles")
        while "counts the bristles" not in stream.getvalue():
            assert stream.lines.acquire(timeout=60)
        return len(argv)

    progress.at("is an earlier command")
    assert run_command("tribo-rig", run, ["a", "b"]) == 2
    assert re.search(r"^tribo-rig: \d+ s: counts the bristles$", stream.getvalue(), re.M) and "earlier" not in stream.getvalue()


def test_a_terminal_is_told_again_and_a_file_seldom(quick):
    for is_terminal in (True, False):
        stream = quick(is_terminal)
        assert run_command("x", lambda argv, s=stream, n=3 if is_terminal else 1: [s.lines.acquire(timeout=60) for _ in range(n)] and 0, []) == 0
        assert is_terminal == (len(stream.getvalue().splitlines()) >= 3) and stream.getvalue().startswith("x: 0 s: at work\n")


def test_a_quick_command_and_one_that_fails_say_nothing_more(quick, monkeypatch):
    monkeypatch.setattr(progress, "FIRST_S", 1000.0)
    stream = quick()
    assert run_command("x", lambda argv: 0, []) == 0 and stream.getvalue() == ""

    def fail(argv):
        raise InputError("file.yaml: wrong")

    assert run_command("x", fail, []) == 2 and stream.getvalue() == "x: file.yaml: wrong\n"
    assert not any(t.name.endswith("(_tell)") for t in threading.enumerate())


def test_a_search_says_what_it_fits():
    t = np.arange(200) * 1e-3
    identify(Data(t, np.ones(200), 1 - np.exp(-40 * t)), 1, no_friction=True)
    assert "fits models of order " in progress._now["doing"] and progress._now["doing"].endswith(" to 200 rows")
