"""release.py SOURCE: what tools/dev/release makes, used by a stranger who has the archives and nothing else.

Everything is made twice, with the same bytes. At the end the wheel, the Debian package and the static program run in clean chroots of Debian 12 and
13, which needs root and mmdebstrap. A release that fails leaves nothing behind.
"""

import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile

SOURCE = pathlib.Path(sys.argv[1]).resolve()
sys.path.insert(0, str(SOURCE / "tests" / "support"))
from version import VERSION  # noqa: E402

RELEASE = SOURCE / "tools" / "dev" / "release"
RUN = ("run", "triangle", "--set", "duration_s=21", "--out")
PLAY = "import tribo; print(tribo.__file__, tribo.run('triangle').summary.rms_error_N)"
RUST = """fn main() {
    let mut axis = tribo::ForceLoop::new();
    let first = axis.step(0.5, 0.0);
    assert!(first.is_finite() && first > 0.0, "{}", first);
}
"""


def call(*words, **options):
    return subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **options)


def say(*words, **options):
    done = call(*words, **options)
    assert done.returncode == 0, f"{words}: {done.stdout}"
    return done.stdout.strip()


# --- refusals -------------------------------------------------------------------------------------------------------------------


def without(folder, *names):
    """An environment whose PATH has all programs but these."""
    folder.mkdir()
    for place in os.environ["PATH"].split(os.pathsep):
        for path in pathlib.Path(place).glob("*"):
            link = folder / path.name
            if path.name not in names and not link.is_symlink():
                link.symlink_to(path)
    return {**os.environ, "PATH": str(folder)}


def check_refusals(folder):
    def refused(words, *options, **rest):
        done = call(RELEASE, *options, "--uncommitted", "--only", "packages", **rest)
        assert done.returncode == 1 and re.search(words, done.stdout) and "Traceback" not in done.stdout, (words, done.stdout)

    (folder / "mine").mkdir()
    (folder / "mine/letter").write_text("dear")
    refused("mine is there and no release; nothing is overwritten", folder / "mine")
    assert (folder / "mine/letter").read_text() == "dear"
    environment = without(folder / "path", "cargo")
    refused(r"not in PATH: cargo\n", folder / "no", env=environment)
    (folder / "path/cargo").write_text("#!/bin/sh\necho the disk is full\nexit 1\n")
    (folder / "path/cargo").chmod(0o755)
    refused(r"(?s)the disk is full\ntools/dev/release: cargo failed", folder / "no", env=environment)
    assert sorted(path.name for path in folder.iterdir()) == ["mine", "path"], "something is left of a release that failed"


# --- what is in it --------------------------------------------------------------------------------------------------------------


def check_sums_and_bill(made):
    assert "FAILED" not in say("sha256sum", "--check", "--strict", "SHA256SUMS", cwd=made)
    archives = {path.name: path for path in made.iterdir() if path.name not in ("SHA256SUMS", f"tribo-{VERSION}.spdx.json")}
    assert {line.split()[1] for line in (made / "SHA256SUMS").read_text().splitlines()} == {*archives, f"tribo-{VERSION}.spdx.json"}
    patterns = [rf"tribo-{VERSION}\.tar\.gz", rf"tribo-{VERSION}-linux-(x86_64|aarch64)\.tar\.gz", rf"tribo-{VERSION}-cp311-abi3-manylinux_\S+_(x86_64|aarch64)\.whl",
                rf"tribo_{VERSION}_[a-z]+_(amd64|arm64)\.deb", rf"tribo(-sys)?-{VERSION}\.crate", rf"tribo-{VERSION}-(arduino\.zip|(platformio|idf|zephyr|conan)\.tar\.gz)",
                rf"tribo-(stm32f405|stm32f405-bridge|rp2040)-(f32|q31)-{VERSION}\.elf", rf"tribo-rp2040-(f32|q31)-{VERSION}\.uf2",
                rf"tribo-{VERSION}-(playground\.html|site\.tar\.gz)"]
    counts = [sum(re.fullmatch(pattern, name) is not None for name in archives) for pattern in patterns]
    assert counts == [1, 2, 2, 2, 2, 5, 6, 2, 2] and len(archives) == sum(counts), (counts, sorted(archives))

    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "tribo"
    lock = (pathlib.Path(__file__).parent / "requirements.txt").read_bytes()
    sys.path.insert(0, str(cache / f"release-python-{hashlib.sha256(lock).hexdigest()}"))
    from spdx_tools.spdx.parser.parse_anything import parse_file
    from spdx_tools.spdx.validation.document_validator import validate_full_spdx_document

    document = parse_file(str(made / f"tribo-{VERSION}.spdx.json"))
    assert document.creation_info.spdx_version == "SPDX-2.3" and validate_full_spdx_document(document) == []
    listed = {package.file_name: package.checksums[0].value for package in document.packages if package.file_name}
    assert listed == {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in archives.items()}
    assert {"libyaml", "cJSON", "uPlot", "CMSIS-Core"} <= {package.name for package in document.packages}

    for path in made.glob("*.uf2"):
        assert path.read_bytes()[:4] == b"UF2\n", path
    page = (made / f"tribo-{VERSION}-playground.html").read_text(encoding="utf-8")
    assert "WebAssembly" in page and not re.search(r"<(script|link|img)[^>]+(src|href)=\"?https?:", page)


def unpacked(made, folder, pattern):
    (archive,) = made.glob(pattern)
    folder.mkdir(parents=True)
    say("tar", "-xf", archive, "-C", folder)
    inside = list(folder.iterdir())
    return inside[0] if len(inside) == 1 else folder


def check_static_programs(made, folder):
    """Nothing to load, and on either processor the same bits."""
    traces = []
    for arch in ("x86_64", "aarch64"):
        prefix = unpacked(made, folder / arch, f"tribo-*-linux-{arch}.tar.gz")
        sim = prefix / "bin/tribo-sim"
        assert "INTERP" not in say("readelf", "-lW", sim) and (prefix / "share/doc/tribo/LICENSE.yaml").exists()
        by = [] if arch == os.uname().machine else [f"qemu-{arch}"]
        say(*by, sim, *RUN, folder / f"run-{arch}", cwd=folder)
        traces.append((folder / f"run-{arch}/trace.csv").read_bytes())
    assert traces[0] == traces[1]


def check_source(made, folder):
    """find_package(tribo) of what the source archive installs."""
    source = unpacked(made, folder / "source", f"tribo-{VERSION}.tar.gz")
    say("cmake", "-S", source, "-B", folder / "tree", "-DTRIBO_HOST_SIM=OFF", "-DBUILD_TESTING=OFF", f"-DCMAKE_INSTALL_PREFIX={folder / 'prefix'}")
    say("cmake", "--build", folder / "tree", "--target", "install")
    say("cmake", "-S", source / "tests/package/consumer", "-B", folder / "consumer", "-DTRIBO_BY=find_package", f"-DTRIBO_VERSION={VERSION}",
        f"-DCMAKE_PREFIX_PATH={folder / 'prefix'}")
    say("cmake", "--build", folder / "consumer")
    say("ctest", "--test-dir", folder / "consumer", "--no-tests=error")


def check_crates(made, folder):
    sys_crate, crate = (unpacked(made, folder / f"crates/{name}", f"{name}-{VERSION}.crate") for name in ("tribo-sys", "tribo"))
    project = folder / "rust"
    (project / "src").mkdir(parents=True)
    (project / "src/main.rs").write_text(RUST)
    (project / "Cargo.toml").write_text(f'[package]\nname = "drive"\nversion = "1.0.0"\nedition = "2021"\n\n[dependencies]\ntribo = {{ path = "{crate}" }}\n\n'
                                        f'[patch.crates-io]\ntribo-sys = {{ path = "{sys_crate}" }}\n')
    say("cargo", "run", "--offline", cwd=project)


def check_packages(made, folder):
    """Laid out as the two package managers want them, and their sources compile."""
    with zipfile.ZipFile(made / f"tribo-{VERSION}-arduino.zip") as archive:
        assert {name.split("/")[0] for name in archive.namelist()} == {"tribo"}
        archive.extractall(folder / "arduino")
    platformio = unpacked(made, folder / "platformio", f"tribo-{VERSION}-platformio.tar.gz")
    assert json.loads((platformio / "library.json").read_text())["version"] == VERSION
    assert f"version={VERSION}\n" in (folder / "arduino/tribo/library.properties").read_text()
    for root, headers in ((platformio, "include"), (folder / "arduino/tribo", "src")):
        objects = folder / f"objects-{headers}"
        objects.mkdir()
        say("gcc", "-c", "-ffp-contract=off", f"-I{root / headers}", *sorted((root / "src").rglob("*.c")), cwd=objects)


# --- a stranger's machine -------------------------------------------------------------------------------------------------------


def check_wheel_for_arm64(made, folder):
    """The wheel for 64-bit ARM in Debian 12's Python for it, emulated: the same bits as the static program here. Debian's packages are only
    unpacked, so nothing has chosen a BLAS for numpy yet."""
    root, package = folder / "arm64", folder / "wheel"
    say("mmdebstrap", "--variant=extract", "--architectures=arm64", "--include=python3,python3-numpy,python3-cffi-backend,python3-ruamel.yaml", "bookworm", root)
    (wheel,) = made.glob("*_aarch64.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(package)
    libraries = root / "usr/lib/aarch64-linux-gnu"
    path = f"import sys; sys.path[:0] = [{str(package)!r}, {str(root / 'usr/lib/python3/dist-packages')!r}]; "
    file, error = say("qemu-aarch64", "-L", root, "-E", f"LD_LIBRARY_PATH={libraries / 'blas'}:{libraries / 'lapack'}", root / "usr/bin/python3.11", "-B", "-c",
                      path + PLAY, cwd=folder).split()
    assert file.startswith(str(package))
    sim = folder / "static/x86_64" / f"tribo-{VERSION}-linux-x86_64/bin/tribo-sim"
    assert float(error) == json.loads(say(sim, "run", "triangle", "--json", cwd=folder))["rms_error_N"]


def check_chroot(made, folder, codename):
    """The wheel from what pip finds for it, the Debian package with apt, the static program: nothing is compiled, as there is no compiler."""
    root = folder / codename
    say("mmdebstrap", "--variant=apt", "--include=python3,python3-venv,ca-certificates", codename, root)
    shutil.copytree(made, root / "release")
    shutil.copy("/etc/resolv.conf", root / "etc/resolv.conf")
    for path in ("/etc/pip.conf", "/etc/ssl/certs/ca-certificates.crt"):
        if os.path.exists(path):
            shutil.copy(path, root / path[1:])
    others = {name: value for name, value in os.environ.items() if not name.startswith(("TRIBO_", "CMAKE_", "PYTHON", "PIP_FIND_LINKS"))}
    inside = {"cwd": "/", "env": {**others, "PATH": "/usr/bin:/usr/sbin:/bin:/sbin", "HOME": "/root", "DEBIAN_FRONTEND": "noninteractive"}}

    def chroot(*words):
        return say("unshare", "--mount", "--pid", "--fork", f"--root={root}", "--mount-proc", *words, **inside)

    assert call("chroot", root, "which", "cc", "gcc", "clang").returncode != 0
    chroot("python3", "-m", "venv", "/venv")
    chroot("sh", "-c", "/venv/bin/pip install --only-binary :all: /release/*_x86_64.whl")
    file, error = chroot("/venv/bin/python", "-c", PLAY).split()
    assert file.startswith("/venv/")
    chroot("sh", "-c", "mkdir /static && tar -C /static --strip-components=1 -xf /release/*-linux-x86_64.tar.gz")
    (deb,) = (root / "release").glob("*_amd64.deb")
    chroot("apt-get", "update")
    if f"_{codename}_" in deb.name:
        chroot("apt-get", "-y", "--no-install-recommends", "install", f"/release/{deb.name}")
        assert chroot("tribo-link", "--version") == f"tribo-link {VERSION}"
    else:  # of another Debian, whose libraries for a drive are others
        chroot("apt-get", "-y", "--no-install-recommends", "install", "libyaml-0-2", "libcjson1")
        chroot("dpkg-deb", "-x", f"/release/{deb.name}", "/")
    errors = {error}
    for sim in ("/venv/bin/tribo-sim", "/static/bin/tribo-sim", "/usr/bin/tribo-sim"):
        assert chroot(sim, "--version") == f"tribo-sim {VERSION}"
        errors.add(str(json.loads(chroot(sim, "run", "triangle", "--json"))["rms_error_N"]))
    assert len({float(error) for error in errors}) == 1, errors


def main():
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        check_refusals(folder)
        made = folder / "first"
        for name in ("first", "second/elsewhere"):
            say(RELEASE, folder / name, "--uncommitted")
        first, second = ((folder / name / "SHA256SUMS").read_text().splitlines() for name in ("first", "second/elsewhere"))
        assert first == second, sorted(set(first) ^ set(second))
        check_sums_and_bill(made)
        check_static_programs(made, folder / "static")
        check_source(made, folder)
        check_crates(made, folder)
        check_packages(made, folder)
        if os.geteuid() != 0 or not shutil.which("mmdebstrap"):
            print("all but the chroots of Debian passed; they need root and mmdebstrap (tools/setup all)")
            sys.exit(77)
        check_wheel_for_arm64(made, folder)
        for codename in ("bookworm", "trixie"):
            check_chroot(made, folder, codename)


if __name__ == "__main__":
    main()
