"""wheel.py ROOT: the wheel that tools/wheel makes of its sdist, installed in an environment of its own, where nothing of the tree is.

Its dependencies are those of tools/setup-design; nothing is fetched.
"""

import pathlib
import subprocess
import sys
import sysconfig
import tempfile
import time

ROOT = pathlib.Path(sys.argv[1]).resolve()
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
    for tool in ("tribo-design", "tribo-identify", "tribo-rig", "tribo-plot"):
        said(tools / tool, "--help", cwd=folder)
    assert "feedforward" in said(tools / "tribo-design", "tune", "--noise", "0.001", cwd=folder)
    said(tools / "tribo-identify", "plan", "--low", "0", "--high", "0.9", "--noise", "0.001", "--out", folder / "plan", cwd=folder)
    said(tools / "tribo-sim", "run", folder / "plan" / "plan.yaml", "--out", folder / "rig", cwd=folder)
