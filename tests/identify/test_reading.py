"""Logs by way of tribo-sim: the words of options, and what a row more or less does."""

import os
import subprocess
import sys

import pytest
import synthetic


@pytest.mark.parametrize("locale", ["C", "C.UTF-8", "de_DE.ISO-8859-1"])
def test_names_are_bytes_of_utf_8_whatever_the_locale(locale, tmp_path):
    """Of a command line, whose bytes pass through, and of a file's text."""
    (tmp_path / "log.csv").write_bytes("t,u,Kraft [µN] ü\n".encode() + b"0,1,2\n0.001,3,4\n")
    code = ("import sys; from types import SimpleNamespace as O; from tribo_identify import logs; "
            "o = O(column=['t=t', 'u=u', sys.argv[2]], unit=[], scale=[], bias=[], resample=None, gap=None); "
            "words = ['--column', 't=t', '--column', 'u=u', '--column', 'F=Kraft [\\u00b5N] \\u00fc']; "
            "assert [logs.read([sys.argv[1]], w).segments[0].force[1] for w in (logs.arguments_of(o), words)] == [4, 4]")
    paths = [str(synthetic.ROOT / "tools" / name) for name in ("identify", "design")]
    env = {**os.environ, "LC_ALL": locale, "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONPATH": os.pathsep.join(paths)}
    done = subprocess.run([sys.executable.encode(), b"-B", b"-c", code.encode(), str(tmp_path / "log.csv").encode(), "F=Kraft [µN] ü".encode()], env=env, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode(errors="replace")
