"""installed.py PREFIX SOURCE BUILD: the programs of an installed tree find all they need in it, wherever it is.

installed.py --alone SOURCE: likewise of a copy of the source that is built, installed, and no longer there.
"""

import os
import pathlib
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "support"))
import man_page  # noqa: E402


def say(*command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, timeout=1200, **options)
    assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
    return done.stdout


def check(prefix, forbidden):
    bin_dir, share = prefix / "bin", prefix / "share"
    programs = [path for path in [*bin_dir.iterdir(), *prefix.glob("libexec/tribo/*")] if not path.is_symlink()]
    assert {"tribo-sim"} <= {path.name for path in programs}, programs
    for program in programs:
        content = program.read_bytes()
        for path in forbidden:
            assert str(path).encode() not in content, f"{program.name} has {path} in it"
    links = {path.name: path.resolve() for path in bin_dir.iterdir() if path.is_symlink()}
    makes_fmus = platform.machine() == "x86_64"
    assert set(links) == {"tribo-plot", "tribo-demo-drive", *(["tribo-fmu"] if makes_fmus else [])}
    assert all(path.is_file() and prefix.resolve() in path.parents for path in links.values()), links
    assert "MIT" in (share / "doc/tribo/LICENSE").read_text(encoding="utf-8")

    for program in bin_dir.iterdir():
        man_page.check(program, share / f"man/man1/{program.name}.1")
        assert re.fullmatch(rf"{program.name} \d+\.\d+\.\d+\n", say(program, "--version"))
    unit = prefix / "lib/systemd/system/tribo-drive.service"
    assert not unit.exists() or re.search(r"^ExecStart=/\S+/bin/tribo-drive ", unit.read_text(encoding="utf-8"), re.M), unit.read_text(encoding="utf-8")
    drive = share / "man/man1/tribo-drive.1"
    assert not (bin_dir / "tribo-drive").exists() or ".SH FILES" in drive.read_text(encoding="utf-8")

    with tempfile.TemporaryDirectory() as folder:
        here = {"cwd": folder, "env": {name: value for name, value in os.environ.items() if not name.startswith("TRIBO_")}}
        sim = bin_dir / "tribo-sim"
        assert say(sim, "list", **here).count("\n") == len(list((share / "tribo/scenarios").glob("*.yaml"))) > 5
        say(sim, "run", "triangle", "--set", "duration_s=21", "--out", "o", **here)
        assert "--out" in say(bin_dir / "tribo-plot", "--help", **here)
        assert "live drive" in say(bin_dir / "tribo-demo-drive", "--help", **here)
        if makes_fmus:
            check_fmu(sim, share, here)
        if (share / "tribo/tools/tribo_plot/uplot").is_dir():
            nowhere = {**here, "env": {**here["env"], "XDG_CACHE_HOME": folder}}
            say(sim, "plot", "o", "--out", "o.html", **nowhere)
            assert "uPlot" in pathlib.Path(folder, "o.html").read_text(encoding="utf-8")


def check_fmu(sim, share, here):
    """An FMU of the installed sources, where FMI's headers came along; else it says what is missing."""
    command = [sim, "fmu", "triangle", "--part", "loop", "--out", "loop.fmu"]
    if (share / "tribo/fmu/fmi").is_dir():
        say(*command, **here)
        with zipfile.ZipFile(pathlib.Path(here["cwd"], "loop.fmu")) as fmu:
            assert {"modelDescription.xml", "binaries/linux64/tribo_fmu.so", "sources/fmu/fmi2.c"} <= set(fmu.namelist())
    else:
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **here)
        assert done.returncode != 0 and "fmpy" in done.stderr, done.stderr


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
