"""wheel.py ROOT: the wheel that tools/wheel makes of its sdist, installed in an environment of its own, where nothing of the tree is.

Its dependencies are those of tools/setup-design; nothing is fetched.
"""

import os
import pathlib
import platform
import re
import signal
import subprocess
import sys
import sysconfig
import tempfile
import time
import zipfile

ROOT = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(ROOT / "tests" / "support"))
import man_page  # noqa: E402

FIRST_START_S = 3.0
PLAY = """
import sys
import tribo
assert not tribo.__file__.startswith(sys.argv[1]), tribo.__file__
run = tribo.run("triangle", gain=0.9)
print(f"{run.summary.rms_error_N:.6f} N")
"""


def said(*words, **options):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f"{words}: {done.stdout}{done.stderr}"
    return done.stdout


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    made = said(ROOT / "tools" / "wheel", folder / "dist").split()
    wheel = next(path for path in made if path.endswith(".whl"))
    assert "-cp311-abi3-linux_" in wheel, wheel
    said(sys.executable, "-m", "venv", "--without-pip", folder / "own")
    tools = folder / "own" / "bin"
    said(sys.executable, "-m", "pip", "--python", tools / "python", "install", "--no-deps", "--no-index", wheel)
    site = pathlib.Path(said(tools / "python", "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip())
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")  # a path here has no .pth files read: nothing of the tree

    start = time.perf_counter()
    said(tools / "tribo-identify", "--version", cwd=folder)
    print(f"first start of tribo-identify: {time.perf_counter() - start:.2f} s, {FIRST_START_S:.0f} s wanted of an idle machine")

    error = said(tools / "python", "-c", PLAY, ROOT, cwd=folder).strip()
    assert error in said(tools / "tribo-sim", "run", "triangle", "--set", "compensator.gain=0.9", cwd=folder), error
    programs = sorted(tools.glob("tribo-*"))
    assert {"tribo-design", "tribo-fmu", "tribo-identify", "tribo-plot", "tribo-rig", "tribo-sim", "tribo-sweep"} <= {path.name for path in programs}
    for program in programs:
        man_page.check(program, folder / f"own/share/man/man1/{program.name}.1")
        assert re.fullmatch(rf"{program.name} \d+\.\d+\.\d+\n", said(program, "--version", cwd=folder)), program
    assert "feedforward" in said(tools / "tribo-design", "tune", "--noise", "0.001", cwd=folder)
    said(tools / "tribo-identify", "plan", "--low", "0", "--high", "0.9", "--noise", "0.001", "--out", folder / "plan", cwd=folder)
    said(tools / "tribo-sim", "run", folder / "plan" / "plan.yaml", "--out", folder / "rig", cwd=folder)

    # A page with uPlot inside, where it was fetched before the wheel was made; not that of the user's cache.
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "tribo"
    for program in ([tools / "tribo-plot"], [tools / "tribo-sim", "plot"]) if list(cache.glob("uplot-*")) else ():
        said(*program, folder / "rig", "--out", folder / "rig.html", cwd=folder, env={**os.environ, "XDG_CACHE_HOME": str(folder)})
        assert "uPlot" in (folder / "rig.html").read_text(encoding="utf-8")

    # FMI's headers are those of fmpy; the tool says so if there is none.
    fmu = [tools / "tribo-sim", "fmu", "triangle", "--part", "loop", "--out", folder / "loop.fmu"]
    fmpy = sorted(cache.glob("fmu-python-*/fmpy/c-code"))
    if platform.machine() == "x86_64" and fmpy:
        said(*fmu, cwd=folder, env={**os.environ, "TRIBO_FMI_HEADERS": str(fmpy[0])})
        assert "sources/fmu/fmi2.c" in zipfile.ZipFile(folder / "loop.fmu").namelist()
    elif platform.machine() == "x86_64":
        done = subprocess.run(list(map(str, fmu)), capture_output=True, text=True, check=False, cwd=folder)
        assert done.returncode == 1 and "install the Python package fmpy" in done.stderr, done.stderr

    # The live drive, where its libraries were when the wheel was made.
    if (tools / "tribo-desk").exists() and (tools / "tribo-link").exists():
        demo = subprocess.Popen([tools / "tribo-demo-drive", "--port", "0"], stdout=subprocess.PIPE, text=True, cwd=folder)
        device = re.search(r"tcp:127\.0\.0\.1:\d+", demo.stdout.readline())[0]
        assert '"state_text"' in said(tools / "tribo-link", "-d", device, "status", "--json", cwd=folder)
        demo.send_signal(signal.SIGINT)
        demo.wait(timeout=100)
    else:
        print("tribo-link and tribo-demo-drive not tried: no libmodbus, libmicrohttpd, libgpiod or libiio")
