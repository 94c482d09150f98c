"""deb.py SOURCE: tools/dev/deb's packages, installed and run: this machine's in a clean chroot of Debian, the other processor's in QEMU.

The first needs root and mmdebstrap.
"""

import os
import pathlib
import subprocess
import sys
import tempfile
import zipfile

RUN = ("run", "triangle", "--set", "duration_s=21", "--out")


def say(*command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
    return done.stdout.strip()


def in_chroot(source, folder):
    """Installs with apt-get and all dependencies, runs, removes. Returns the run's log."""
    deb, root = pathlib.Path(say(source / "tools/dev/deb", cwd=source).splitlines()[-1]), folder / "root"
    codename = say("sh", "-c", ". /etc/os-release && echo $VERSION_CODENAME")
    say("mmdebstrap", "--variant=apt", codename, root)
    (root / "tribo.deb").write_bytes((source / deb).read_bytes())
    others = {name: value for name, value in os.environ.items() if not name.startswith(("TRIBO_", "CMAKE_"))}
    inside = {"cwd": "/", "env": {**others, "PATH": "/usr/bin:/usr/sbin:/bin:/sbin", "DEBIAN_FRONTEND": "noninteractive"}}
    say("cp", "/etc/resolv.conf", root / "etc/resolv.conf")

    def chroot(*command):
        return say("unshare", "--mount", "--pid", "--fork", f"--root={root}", "--mount-proc", *command, **inside)

    chroot("apt-get", "update")
    chroot("apt-get", "-y", "--no-install-recommends", "install", "/tribo.deb", "systemd")
    assert "triangle" in chroot("tribo-sim", "list")
    chroot("tribo-sim", *RUN, "/o")
    assert "tribo-link" in chroot("tribo-link", "--version") and "tribo-drive" in chroot("tribo-drive", "--version")
    assert "tribo" in chroot("sh", "-c", "systemd-sysusers tribo.conf && id tribo")
    assert chroot("systemd-analyze", "verify", "--man=no", "/usr/lib/systemd/system/tribo-drive.service") == ""
    if (root / "usr/bin/tribo-fmu").exists():
        chroot("apt-get", "-y", "--no-install-recommends", "install", "python3", "cmake", "ninja-build", "gcc", "libc6-dev")
        chroot("tribo-fmu", "/usr/share/tribo/scenarios/triangle.yaml", "--part", "loop", "--fmi", "3", "--out", "/loop.fmu")
        assert "binaries/x86_64-linux/tribo_fmu.so" in zipfile.ZipFile(root / "loop.fmu").namelist()
    log = (root / "o/trace.csv").read_bytes()
    chroot("dpkg", "--purge", "tribo")
    assert not list(root.glob("usr/bin/tribo-*")) and not (root / "usr/share/tribo").exists() and not (root / "usr/libexec/tribo").exists()
    return log


def in_qemu(source, folder, arch, machine):
    deb, root = source / say(source / "tools/dev/deb", arch, cwd=source).splitlines()[-1], folder / arch
    say("dpkg-deb", "-x", deb, root)
    assert say("dpkg-deb", "-f", deb, "Architecture") == arch and "libyaml-0-2" in say("dpkg-deb", "-f", deb, "Depends")
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME", pathlib.Path.home() / ".cache")) / "tribo"
    libraries = next(cache.glob(f"root-{arch}-*"))
    say(f"qemu-{machine}", "-L", libraries, root / "usr/bin/tribo-sim", *RUN, folder / "o")
    assert (root / "usr/share/man/man1/tribo-sim.1").stat().st_size > 1000
    return (folder / "o/trace.csv").read_bytes()


def main():
    if os.geteuid() != 0:
        print("skipped: a chroot needs root")
        sys.exit(77)
    source = pathlib.Path(sys.argv[1])
    other = {"amd64": ("arm64", "aarch64"), "arm64": ("amd64", "x86_64")}[say("dpkg", "--print-architecture")]
    with tempfile.TemporaryDirectory() as folder:
        assert in_chroot(source, pathlib.Path(folder)) == in_qemu(source, pathlib.Path(folder), *other)


main()
