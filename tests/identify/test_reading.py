"""Logs by way of tribo-sim: the words of options, and what a row more or less does."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import synthetic

from tribo_identify import logs
from tribo_identify.cli import main


@pytest.mark.parametrize("head, times, code, why", [
    ("t_s,F_N,x", 1.0, 2, "log.csv:1:1: no column is named u_N; there are t_s, F_N, x"), ("t_s,u_N,F_N", 1e28, 3, "units: u changes by 1e+28 N in all; 1e-06 to 1e+06 N are expected"),
    ("t_s,u_N,F_N", 1e-28, 3, "units: u changes by 1e-28 N in all"), ("t_s,F_N,u_N", 1e-9, 3, "units: F changes by 1e-09 N in all; 1e-06 to 1e+06 N are expected: name its unit (--unit F=mN) or")])
def test_a_log_without_u_or_of_other_sizes_is_refused_for_that(tmp_path, capsys, head, times, code, why):
    (tmp_path / "log.csv").write_text(f"{head}\n" + "".join(f"{k / 1000},{times * (k % 1001) / 1000},{k % 501 / 1000}\n" for k in range(4000)))
    assert main(["friction", str(tmp_path / "log.csv"), "--out", str(tmp_path / "out")]) == code
    assert why in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_a_log_whose_name_begins_with_a_hyphen_is_read(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "-log.csv").write_text("t_s,u_N,F_N\n0,1,2\n0.001,3,4\n")
    assert logs.read(["-log.csv"]).rows == logs.read([Path("./-log.csv")]).rows == 2


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
