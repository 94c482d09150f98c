"""What a library finds in somebody else's process: a decimal comma, another direction of rounding, traps."""

import contextlib
import ctypes
import ctypes.util
import locale
import os
import subprocess

# glibc's numbers on x86-64 and arm64.
UPWARD = {"x86_64": 0x800, "aarch64": 0x400000}.get(os.uname().machine)
LC_ALL_MASK = 0x1FBF

COMMA = ("de_DE.UTF-8", "de_DE.ISO-8859-1", "tr_TR.UTF-8")

# Functions and variables of the C library that a program may use and a library in it may not.
ACTS_ON_THE_PROCESS = {
    "exit", "_exit", "abort", "atexit", "assert_fail", "fork", "vfork", "execvp", "kill", "raise", "signal", "sysv_signal", "sigaction", "sigprocmask", "setitimer", "alarm",
    "setlocale", "printf", "puts", "putchar", "stdin", "stdout", "stderr", "environ", "setenv", "putenv", "chdir", "umask", "rand", "srand", "strtok", "localtime", "gmtime",
    "ctime", "asctime"}


def make_locales(folder):
    """Compiles those of COMMA into a folder of its own; why that cannot be, or None."""
    for name in COMMA:
        language, charset = name.split(".")
        try:
            done = subprocess.run(["localedef", "-i", language, "-f", charset, str(folder / name)], capture_output=True, text=True, check=False)
        except FileNotFoundError:
            return "there is no localedef"
        if done.returncode != 0:
            return f"localedef: {done.stderr.strip()}"
    return None


@contextlib.contextmanager
def in_locale(folder, name):
    """For the whole process, as setlocale does it."""
    kept = os.environ.get("LOCPATH")
    os.environ["LOCPATH"] = str(folder)
    before = locale.setlocale(locale.LC_ALL)
    try:
        locale.setlocale(locale.LC_ALL, name)
        assert locale.localeconv()["decimal_point"] == ","
        yield
    finally:
        locale.setlocale(locale.LC_ALL, before)
        os.environ.pop("LOCPATH") if kept is None else os.environ.update(LOCPATH=kept)


@contextlib.contextmanager
def in_thread_locale(folder, name):
    """For the calling thread alone."""
    libc = ctypes.CDLL(None)
    libc.newlocale.restype = libc.uselocale.restype = ctypes.c_void_p
    libc.newlocale.argtypes, libc.uselocale.argtypes = [ctypes.c_int, ctypes.c_char_p, ctypes.c_void_p], [ctypes.c_void_p]
    os.environ["LOCPATH"] = str(folder)
    made = libc.newlocale(LC_ALL_MASK, name.encode(), None)
    assert made
    before = libc.uselocale(made)
    try:
        yield
        assert libc.uselocale(None) == made  # as it was left
    finally:
        libc.uselocale(before)
        os.environ.pop("LOCPATH")


@contextlib.contextmanager
def rounding_upward():
    libm = ctypes.CDLL(ctypes.util.find_library("m"))
    before = libm.fegetround()
    assert libm.fesetround(UPWARD) == 0
    try:
        yield
        assert libm.fegetround() == UPWARD
    finally:
        libm.fesetround(before)
