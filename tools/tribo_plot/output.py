"""Result files that are whole or as they were, and standard output that is whole or an error. Only the standard library, for every tool in Python."""

import argparse
import contextlib
import errno
import os
import signal
import stat
import sys
import tempfile
import threading
from pathlib import Path


class PlaceError(OSError):
    """A result cannot go where it shall. The text names the place and the reason."""


def named(text):
    """A folder's name for argparse. An empty one would be the folder at hand."""
    if not text:
        raise argparse.ArgumentTypeError("is empty: a name is expected")
    return Path(text)


def is_protected(info):
    """Whether nobody may write a file. Permissions do not bind root, but this is somebody's intent."""
    return not stat.S_IMODE(info.st_mode) & 0o222


def check_place(path):
    """Raises PlaceError if no file can be written at `path`; called before long work whose result goes there."""
    path = Path(path)
    try:
        info = path.stat() if path.exists() else None
        if info is not None and stat.S_ISDIR(info.st_mode):
            raise PlaceError(f"{path}: cannot be written: Is a directory")
        if info is not None and stat.S_ISREG(info.st_mode) and is_protected(info):
            raise PlaceError(f"{path}: cannot be written: it is read-only")
        if info is not None and not os.access(path, os.W_OK):
            raise PlaceError(f"{path}: cannot be written: Permission denied")
        if info is None or stat.S_ISREG(info.st_mode):
            with tempfile.TemporaryFile(dir=Path(os.path.realpath(path)).parent):
                pass
    except PlaceError:
        raise
    except OSError as error:
        raise PlaceError(f"{path}: cannot be written: {error.strerror}") from None


def keep_mode(new, old):
    """Gives a file or a directory the mode of the one that it replaces, if there is one, and its group and owner where this user may."""
    if old.exists():
        info = old.stat()
        for user, group in ((-1, info.st_gid), (info.st_uid, -1)):
            with contextlib.suppress(PermissionError):
                os.chown(new, user, group)
        new.chmod(stat.S_IMODE(info.st_mode))


@contextlib.contextmanager
def replaced(path):
    """Yields a new path with the ending of `path`. What is written there takes the place of `path` if nothing is raised; a file that exists keeps its mode and
    its owner, and what links to it. Raises PlaceError."""
    check_place(path)
    place = Path(os.path.realpath(path))
    is_file = place.is_file() or not place.exists()
    with tempfile.TemporaryDirectory(prefix=f".{place.stem}.", dir=place.parent if is_file else None) as beside:
        new = Path(beside) / place.name
        try:
            yield new
            if is_file:
                keep_mode(new, place)
                os.replace(new, place)
            else:
                place.write_bytes(new.read_bytes())
        except PlaceError:
            raise
        except OSError as error:
            if error.filename is not None and os.fspath(error.filename) not in (str(new), str(place)):
                raise
            raise PlaceError(f"{path}: cannot be written: {error.strerror}") from None


@contextlib.contextmanager
def folder(path):
    """Makes a folder and its missing parents; if the body raises, those that it made go again."""
    missing = [one for one in (path, *path.parents) if not one.exists()]
    try:
        path.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for one in missing:
            with contextlib.suppress(OSError):
                one.rmdir()
        raise


def write(path, data):
    """Writes text or bytes to `path`, wholly or not at all. Raises PlaceError."""
    with replaced(path) as new:
        new.write_bytes(data if isinstance(data, bytes) else data.encode())


def is_lost(error):
    """Whether an OSError says that standard output takes no more; that of a file has its name."""
    return error.filename is None and error.errno in (errno.ENOSPC, errno.EBADF, errno.EIO, errno.EFBIG, errno.EDQUOT, errno.EPIPE)


class _Watched:
    """A stream that remembers a failed write: argparse drops it when it prints its help."""

    def __init__(self, stream):
        self.stream, self.error = stream, None

    def write(self, text):
        try:
            return self.stream.write(text)
        except OSError as error:
            self.error = error
            raise

    def __getattr__(self, name):
        return getattr(self.stream, name)


def _end(number, _):
    signal.signal(number, signal.SIG_IGN)
    sys.exit(128 + number)


@contextlib.contextmanager
def _ended_by_signals():
    """Signals that would kill the program end it as sys.exit does, so that half-made files go."""
    is_main = threading.current_thread() is threading.main_thread()
    numbers = [number for number in (signal.SIGTERM, signal.SIGHUP) if is_main and signal.getsignal(number) == signal.SIG_DFL]
    for number in numbers:
        signal.signal(number, _end)
    try:
        yield
    finally:
        for number in numbers:
            signal.signal(number, signal.SIG_DFL)


def run(program, command, *arguments):
    """Returns the exit status of command(*arguments), or 1 with a message if what it printed was lost. A reader that has gone ends it without one."""
    with _ended_by_signals():
        return _run(program, command, *arguments)


def _run(program, command, *arguments):
    if sys.stdout is None:  # closed by the caller: a file must not get its number, and lines must not vanish
        sys.stdout = os.fdopen(os.open(os.devnull, os.O_RDONLY), "w")
    watched = sys.stdout = _Watched(sys.stdout)
    try:
        try:
            return command(*arguments)
        finally:  # also at the SystemExit of --help and --version
            sys.stdout = watched.stream
            if watched.error is not None:
                raise watched.error
            sys.stdout.flush()
    except OSError as error:
        if not is_lost(error):
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # leaves the interpreter nothing to fail at when it ends
        if isinstance(error, BrokenPipeError):
            return 141
        print(f"{program}: standard output: cannot be written: {error.strerror}", file=sys.stderr)
        return 1
