"""installed.py PREFIX SOURCE BUILD: the programs of an installed tree find all they need in it, wherever it is.

installed.py --alone SOURCE: likewise of a copy of the source that is built, installed, and no longer there.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

UNDOCUMENTED = ("--help", "--usage", "--version")


def say(*command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, timeout=1200, **options)
    assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
    return done.stdout


def check(prefix, forbidden):
    bin_dir, share = prefix / "bin", prefix / "share"
    programs = [path for path in bin_dir.iterdir() if not path.is_symlink()]
    assert {"tribo-sim"} <= {path.name for path in programs}, programs
    for program in programs:
        content = program.read_bytes()
        for path in forbidden:
            assert str(path).encode() not in content, f"{program.name} has {path} in it"
    links = {path.name: path.resolve() for path in bin_dir.iterdir() if path.is_symlink()}
    assert set(links) == {"tribo-plot", "tribo-sweep-report", "tribo-demo-drive"}
    assert all(path.is_file() and prefix.resolve() in path.parents for path in links.values()), links
    assert "MIT" in (share / "doc/tribo/LICENSE").read_text(encoding="utf-8")

    for program in programs:
        page = (share / f"man/man1/{program.name}.1").read_text(encoding="utf-8") if program.name != "tribo-desk" else None
        options = re.findall(r"^ {2,6}(?:-\w, )?(--[\w-]+)", say(program, "--help"), re.M)
        assert page is None or all(option.replace("-", "\\-") in page for option in options if option not in UNDOCUMENTED), program
        assert page is None or page.startswith(f".TH {program.name.upper()} 1")
    assert all(word in (share / "man/man1/tribo-sim.1").read_text() for word in (".SH SWEEP", "\\-\\-decimate=N", ".B replay"))

    with tempfile.TemporaryDirectory() as folder:
        here = {"cwd": folder, "env": {name: value for name, value in os.environ.items() if not name.startswith("TRIBO_")}}
        sim = bin_dir / "tribo-sim"
        assert say(sim, "list", **here).count("\n") == len(list((share / "tribo/scenarios").glob("*.yaml"))) > 5
        say(sim, "run", "triangle", "--set", "duration_s=21", "--out", "o", **here)
        assert str((share / "tribo/scenarios/triangle.yaml").resolve()) in say(sim, "sweep", "triangles", "--row", "0", **here)
        assert "--out" in say(bin_dir / "tribo-plot", "--help", **here)
        assert "live drive" in say(bin_dir / "tribo-demo-drive", "--help", **here)
        assert "Pictures" in say(bin_dir / "tribo-sweep-report", "--help", **here)
        if (share / "tribo/tools/uplot").is_dir():
            nowhere = {**here, "env": {**here["env"], "XDG_CACHE_HOME": folder}}
            say(sim, "plot", "o", "--out", "o.html", **nowhere)
            assert "uPlot" in pathlib.Path(folder, "o.html").read_text(encoding="utf-8")


def alone(source):
    with tempfile.TemporaryDirectory() as folder:
        copy, build, prefix = (pathlib.Path(folder) / name for name in ("source", "build", "prefix"))
        for name in say("git", "ls-files", cwd=source).splitlines():
            if (source / name).is_file():
                (copy / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(source / name, copy / name)
        say("cmake", "-S", copy, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DBUILD_TESTING=OFF")
        say("cmake", "--build", build)
        say("cmake", "--install", build, "--prefix", prefix)
        shutil.rmtree(copy)
        shutil.rmtree(build)
        check(prefix, [copy, build])


if sys.argv[1] == "--alone":
    alone(pathlib.Path(sys.argv[2]))
else:
    check(*(lambda prefix, *others: (prefix, others))(*map(pathlib.Path, sys.argv[1:])))
