"""drive.py BUILD: what the preset linux-drive builds is a component of its own; installed alone it is whole."""

import pathlib
import re
import subprocess
import sys
import tempfile

with tempfile.TemporaryDirectory() as folder:
    prefix = pathlib.Path(folder) / "prefix"
    subprocess.run(["cmake", "--install", sys.argv[1], "--component", "drive", "--prefix", prefix], check=True, stdout=subprocess.DEVNULL)
    assert {path.name for path in (prefix / "bin").iterdir()} == {"tribo-drive", "tribo-link"}
    assert {path.name for path in (prefix / "share/man/man1").iterdir()} == {"tribo-drive.1", "tribo-link.1"}
    assert {"LICENSE", "linux", "plotjuggler.xml"} <= {path.name for path in (prefix / "share/doc/tribo").iterdir()}
    assert (prefix / "lib/udev/rules.d/99-tribo.rules").exists() and (prefix / "lib/sysusers.d/tribo.conf").exists()
    unit = (prefix / "lib/systemd/system/tribo-drive.service").read_text(encoding="utf-8")
    assert re.search(rf"^ExecStart={prefix}/bin/tribo-drive ", unit, re.M), unit
