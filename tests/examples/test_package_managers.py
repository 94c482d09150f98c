"""The package managers themselves take what tools/dev/packages writes, without a network: PlatformIO builds a program for a platform of this
test's own, Conan makes its package, ESP-IDF's component manager packs its component."""

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile

import pytest

from conftest import EXAMPLES
from test_packages import CALLER, ROOT, VERSION


def alone(*command, **options):
    """Runs a command in a network namespace of its own, which has none."""
    result = subprocess.run(["unshare", "--map-root-user", "--net", *map(str, command)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            text=True, timeout=600, check=False, **options)
    assert result.returncode == 0, result.stdout
    return result.stdout


@pytest.fixture(name="package")
def _package(tmp_path):
    def write(kind):
        subprocess.run([ROOT / "tools" / "dev" / "packages", tmp_path / "packages", kind], check=True, stdout=subprocess.DEVNULL, timeout=600)
        return tmp_path / "packages" / kind

    return write


def put(folder, **files):
    folder.mkdir(parents=True)
    for name, text in files.items():
        (folder / name.replace("__", ".")).write_text(text)


def installed(kind, name, version):
    """PlatformIO's note of where a package came from."""
    return json.dumps({"type": kind, "name": name, "version": version, "spec": {"owner": None, "id": None, "name": name,
                                                                             "requirements": None, "uri": None}})


def test_platformio_builds_a_program_with_the_library(package, tmp_path):
    wanted = subprocess.run([sys.executable, "-c", "from platformio.dependencies import get_core_dependencies as get; print(get()['tool-scons'])"],
                            stdout=subprocess.PIPE, text=True, check=True, timeout=600).stdout
    scons = re.search(r"[\d.]+", wanted)[0]
    core, project = tmp_path / "core", tmp_path / "project"
    put(core / "packages" / "tool-scons", scons__py="import SCons.Script\nSCons.Script.main()\n",
        package__json=json.dumps({"name": "tool-scons", "version": scons, "system": "*"}),
        __piopm=installed("tool", "tool-scons", scons).replace('"owner": null', '"owner": "platformio"'))
    put(core / "platforms" / "here", __piopm=installed("platform", "here", "1.0.0"),
        platform__json=json.dumps({"name": "here", "version": "1.0.0", "title": "this machine", "frameworks": {}, "packages": {}}),
        platform__py="from platformio.public import PlatformBase\n\n\nclass HerePlatform(PlatformBase):\n    pass\n")
    put(core / "platforms" / "here" / "builder",
        main__py='from SCons.Script import Default, DefaultEnvironment\nenv = DefaultEnvironment()\n'
                 'env.Replace(CC="gcc", CXX="g++", AR="ar", RANLIB="ranlib", LINK="gcc", PROGNAME="program")\nDefault(env.BuildProgram())\n')
    put(project, platformio__ini="[env:here]\nplatform = here\n")
    put(project / "src", main__c=CALLER)
    shutil.copy(EXAMPLES / "rig" / "rig_1khz_f32.h", project / "src")
    shutil.copytree(package("platformio"), project / "lib" / "tribo")
    out = alone(sys.executable, "-B", "-m", "platformio", "run", "--verbose", cwd=project,
                env={**os.environ, "PLATFORMIO_CORE_DIR": str(core), "PLATFORMIO_SETTING_ENABLE_TELEMETRY": "no"})
    compiled = [line for line in out.splitlines() if "force_loop_f32.c" in line]
    assert compiled and "-ffp-contract=off" in compiled[0]
    subprocess.run([project / ".pio" / "build" / "here" / "program"], check=True, timeout=600)


def test_conan_makes_its_package(package, tmp_path):
    folder = package("conan")
    conan = [sys.executable, "-B", "-c", "from conans.conan import run; run()"]
    environment = {**os.environ, "CONAN_HOME": str(tmp_path / "home")}
    alone(*conan, "profile", "detect", env=environment)
    out = alone(*conan, "create", folder, "--no-remote", env=environment)
    assert f"tribo/{VERSION}" in out
    assert [*(tmp_path / "home").rglob("p/lib/libtribo.a")]
    assert [*(tmp_path / "home").rglob("p/include/tribo/feedforward_f32.h")]


def test_idfs_component_manager_packs_its_component(package, tmp_path):
    folder = package("idf")
    alone(sys.executable, "-B", "-c", "from idf_component_manager.cli import safe_cli; safe_cli()", "component", "pack", "--name", "tribo",
          "--project-dir", folder, env={**os.environ, "HOME": str(tmp_path)})
    with tarfile.open(folder / "dist" / f"tribo_{VERSION}.tgz") as archive:
        names = [name.removeprefix("./") for name in archive.getnames()]
    assert {"idf_component.yml", "CMakeLists.txt", "include/tribo/feedforward_f32.h", "src/loop/force_loop_f32.c"} <= set(names)
