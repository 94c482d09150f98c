"""setup_design.py ROOT: tools/setup-design --guard in a copy that has one package, from a folder, with a blank in the path of the user's cache:
what it keeps there, and that it leaves nothing there when pip fails in the middle or the script is interrupted."""

import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import zipfile

ROOT = pathlib.Path(sys.argv[1])
BROKEN_PIP = '''import os, pathlib, signal, sys
target = pathlib.Path(sys.argv[sys.argv.index("--target") + 1])
target.mkdir()
(target / "half").touch()
if os.environ["BROKEN"] == "interrupted":
    os.kill(os.getppid(), signal.SIGTERM)
sys.exit(1)
'''


def make_wheel(folder):
    """A package that tools/setup-design knows by name, as a wheel; returns its hash."""
    wheel = folder / "iniconfig-1.0-py3-none-any.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("iniconfig.py", "")
        archive.writestr("iniconfig-1.0.dist-info/METADATA", "Metadata-Version: 2.1\nName: iniconfig\nVersion: 1.0\n")
        archive.writestr("iniconfig-1.0.dist-info/WHEEL", "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
        archive.writestr("iniconfig-1.0.dist-info/RECORD", "iniconfig.py,,\niniconfig-1.0.dist-info/METADATA,,\n"
                         "iniconfig-1.0.dist-info/WHEEL,,\niniconfig-1.0.dist-info/RECORD,,\n")
    return hashlib.sha256(wheel.read_bytes()).hexdigest()


def make_copy(folder):
    tools = folder / "tools"
    tools.mkdir()
    for name in ("setup-design", "about.sh"):
        shutil.copy(ROOT / "tools" / name, tools)
    (tools / "requirements.lock").write_text(f"iniconfig==1.0 --hash=sha256:{make_wheel(folder)}\n")
    (tools / "setup").write_text("#!/bin/sh\n")  # Debian's packages are there
    (tools / "setup").chmod(0o755)
    status = folder / "lib/include/tribo/status.h"
    status.parent.mkdir(parents=True)
    shutil.copy(ROOT / "lib/include/tribo/status.h", status)
    (folder / "pip").mkdir()
    (folder / "pip" / "__init__.py").touch()
    (folder / "pip" / "__main__.py").write_text(BROKEN_PIP)


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    make_copy(folder)
    cache = folder / "a cache"

    def set_up(**environment):
        """Returns what it says, and the folders of the cache."""
        clean = {key: value for key, value in os.environ.items() if not key.startswith(("PIP_", "PYTHON"))}
        done = subprocess.run([folder / "tools/setup-design", "--guard"], stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, timeout=600,
                              env={**clean, "XDG_CACHE_HOME": str(cache), "PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(folder), **environment})
        return done, sorted((cache / "tribo").glob("*")) + sorted(path for path in folder.glob("a*") if path != cache)

    (cache / "tribo").mkdir(parents=True)
    for broken, status in ("failing", 1), ("interrupted", 143):
        done, kept = set_up(PYTHONPATH=str(folder), BROKEN=broken)
        assert done.returncode == status and not kept, (broken, done, kept)
    done, kept = set_up()
    assert done.returncode == 1 and "cannot build and install tribo" in done.stderr, done  # there is no tribo in the copy
    assert len(kept) == 1 and (kept[0] / "iniconfig.py").exists() and "." not in kept[0].name.partition("-")[2].partition("-")[2], kept
