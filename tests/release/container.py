"""container.py SOURCE: the Containerfile, line by line in a chroot of its Debian; then tools/setup of what tools/check needs fetches nothing more.

Needs root and mmdebstrap. There is no container's engine here, so its base image is Debian's own.
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(sys.argv[1]).resolve()
CODENAMES = {"docker.io/library/debian:12": "bookworm", "docker.io/library/debian:13": "trixie"}


def say(*words, **options):
    done = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **options)
    assert done.returncode == 0, f"{words}: {done.stdout}"
    return done.stdout


def copy_tree(to):
    for name in say("git", "ls-files", "-z", cwd=SOURCE).split("\0")[:-1]:
        if (SOURCE / name).is_file():
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(SOURCE / name, to / name)


def main():
    words = [line.split(" ", 1) for line in (SOURCE / "Containerfile").read_text().splitlines() if line and not line.startswith("#")]
    assert [word for word, _ in words] == ["FROM", "RUN", "COPY", "RUN"], words
    described = json.loads((SOURCE / ".devcontainer/devcontainer.json").read_text())
    assert (SOURCE / ".devcontainer" / described["build"]["dockerfile"]).resolve() == SOURCE / "Containerfile"
    own = re.findall(r"install.* (\S+) (\S+)$", words[1][1])
    assert own == [("ca-certificates", "git")], f"the packages are those of tools/setup, not {own}"
    if os.geteuid() != 0 or not shutil.which("mmdebstrap"):
        print("skipped: a chroot needs root and mmdebstrap (tools/setup all)")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder) / "root"
        say("mmdebstrap", "--variant=apt", CODENAMES[words[0][1]], root)
        (root / "etc/dpkg/dpkg.cfg.d/unsafe-io").write_text("force-unsafe-io\n")  # as in the image
        shutil.copy("/etc/resolv.conf", root / "etc/resolv.conf")
        others = {name: value for name, value in os.environ.items() if not name.startswith(("TRIBO_", "CMAKE_", "PYTHON", "PIP_FIND_LINKS", "XDG_"))}
        inside = {"cwd": "/", "env": {**others, "PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "DEBIAN_FRONTEND": "noninteractive"}}

        def chroot(command, *options):
            return say("unshare", "--mount", "--pid", "--fork", *options, f"--root={root}", "--mount-proc", "sh", "-c", command, **inside)

        chroot(words[1][1])
        shutil.copy("/etc/ssl/certs/ca-certificates.crt", root / "etc/ssl/certs")
        assert words[2][1] == ". /tmp/tribo"
        copy_tree(root / "tmp/tribo")
        chroot(words[3][1])
        copy_tree(root / "tribo")
        for command in ("check", "target", "board"):
            assert chroot(f"/tribo/tools/setup {command}", "--net") == "", command


main()
