"""What tools/dev/packages writes, as far as it can be built here: a package's manifest is read and its sources are compiled as it says."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "support"))
import doors  # noqa: E402
from version import VERSION  # noqa: E402
IN_LIB = {path.relative_to(ROOT / "lib").as_posix() for path in (ROOT / "lib").rglob("*.c")}
M4F = ["-mthumb", "-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"]
CALLER = """#include "tribo/feedforward_f32.h"
#include "rig_1khz_f32.h"
int main(void)
{
    static tribo_feedforward_f32_memory_t memory;
    static tribo_force_loop_f32_state_t loop;
    loop.memory = &memory.state.tick;
    if (tribo_force_loop_f32_start(&loop, &rig_params, false) != TRIBO_OK)
        return 2;
    float u = 0.0f;
    for (int tick = 0; tick < 10; tick++)
    {
        u = tribo_force_loop_f32_step(&rig_params, &loop, 0.5f, 0.0f, NULL);
    }
    return !(u > 0.0f && u < 2.0f); // towards the reference
}
"""


def run(*command, **options):
    result = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600,
                            check=False, **options)
    assert result.returncode == 0, result.stdout
    return result.stdout


@pytest.fixture(scope="module", name="packages")
def _packages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("packages")
    run(ROOT / "tools" / "dev" / "packages", folder)
    return folder


@pytest.fixture(scope="module", name="cargo")
def _cargo(packages, tmp_path_factory):
    """cargo in the crates, whose objects stay from test to test; and the folder of its programs."""
    folder = tmp_path_factory.mktemp("cargo")
    return (lambda *words: run("cargo", *words, "--offline", cwd=packages / "crates", env={**os.environ, "CARGO_TARGET_DIR": str(folder)})), folder


def fused(objects):
    """Instructions that fuse a product and a sum."""
    return re.findall(r"\tvfn?m[as]\S*", run("arm-none-eabi-objdump", "-d", *objects))


def test_all_sources_are_in_each_package(packages):
    for kind, root in {"platformio": "", "arduino": "", "idf": "", "zephyr": "", "conan": "", "crates": "tribo-sys/lib"}.items():
        folder = packages / kind / root
        assert {path.relative_to(folder).as_posix() for path in folder.rglob("src/**/*.c")} == IN_LIB, kind
        assert not [path for path in (packages / kind).rglob("*") if path.is_file() and re.search(r"@[A-Z]+@", path.read_text())]


def test_platformio_compiles_as_its_manifest_says(packages, tmp_path):
    folder = packages / "platformio"
    manifest = json.loads((folder / "library.json").read_text())
    assert (manifest["name"], manifest["version"]) == ("tribo", VERSION)
    build = manifest["build"]
    sources = sorted((folder / build["srcDir"]).rglob("*.c"))
    assert (folder / build["includeDir"] / manifest["headers"]).exists()
    (tmp_path / "main.c").write_text(CALLER)
    run("gcc", "-std=gnu11", *build["flags"], f"-I{folder / build['includeDir']}", f"-I{ROOT / 'examples' / 'rig'}", tmp_path / "main.c", *sources,
        "-o", tmp_path / "program")
    run(tmp_path / "program")


@pytest.mark.parametrize("kind, standard", [("platformio", "c++11"), ("arduino", "gnu++17"), ("crates", "gnu++20")])  # the others' are platformio's
def test_a_program_in_cpp_uses_each_package(kind, standard, packages, tmp_path):
    """Every public header, without a warning, and the library's sources by the C compiler of the same project."""
    root = packages / kind / ("tribo-sys/lib" if kind == "crates" else "")
    headers = root / ("src" if kind == "arduino" else "include")
    names = sorted(path.name for path in (headers / "tribo").glob("*.h"))
    assert names
    text = "".join(f'#include "tribo/{name}"\n' for name in names) + CALLER.replace("NULL", "nullptr").replace("int main(void)", "int main()")
    (tmp_path / "main.cpp").write_text(text)
    warnings = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror"]
    run("g++", f"-std={standard}", *warnings, f"-I{headers}", f"-I{ROOT / 'examples' / 'rig'}", "-c", tmp_path / "main.cpp", "-o", tmp_path / "main.o")
    run("gcc", "-std=gnu11", "-ffp-contract=off", f"-I{headers}", *sorted((root / "src").rglob("*.c")), "-c", cwd=tmp_path)
    run("g++", *tmp_path.glob("*.o"), "-o", tmp_path / "program")
    run(tmp_path / "program")


@pytest.mark.skipif(not shutil.which("arm-none-eabi-g++"), reason="no cross-compiler: in the tree of the Cortex-M4F")
def test_arduino_compiles_as_its_builder_does(packages, tmp_path):
    folder = packages / "arduino"
    properties = dict(line.split("=", 1) for line in (folder / "library.properties").read_text().splitlines())
    assert (properties["name"], properties["version"]) == ("tribo", VERSION)
    assert {"author", "maintainer", "sentence", "paragraph", "category", "url", "architectures"} <= set(properties)
    flags = [*M4F, "-O2", f"-I{folder / 'src'}"]
    for source in (folder / "src").rglob("*.c"):
        run("arm-none-eabi-gcc", "-std=gnu11", *flags, "-c", source, "-o", tmp_path / f"{source.stem}.o")
    assert not fused(tmp_path.glob("*.o"))
    (tmp_path / "Arduino.h").write_text("#include <stdint.h>\nextern \"C\" float sinf(float);\nuint32_t micros();\nstruct serial_t { void begin(int); void println(const char *); };\nextern serial_t Serial;\n")
    sketches = [CALLER.replace('"tribo/feedforward_f32.h"', f"<{properties['includes']}>")]
    sketches += ['#include "Arduino.h"\n' + path.read_text() for path in sorted(folder.glob("examples/*/*.ino"))]
    assert len(sketches) == 5
    for number, sketch in enumerate(sketches):
        (tmp_path / f"{number}.ino.cpp").write_text(sketch)
        run("arm-none-eabi-g++", "-std=gnu++14", "-Wall", "-Wextra", "-Werror", *flags, f"-I{ROOT / 'examples' / 'rig'}", "-c", tmp_path / f"{number}.ino.cpp", "-o", tmp_path / f"{number}.ino.o")


STUBS = {
    "idf": """
function(idf_component_register)
  cmake_parse_arguments(arg "" "" "SRCS;INCLUDE_DIRS" ${ARGN})
  add_library(tribo STATIC ${arg_SRCS})
  target_include_directories(tribo PUBLIC ${arg_INCLUDE_DIRS})
  set(COMPONENT_LIB tribo PARENT_SCOPE)
endfunction()
add_subdirectory(${PACKAGE} component)
""",
    "zephyr": """
set(CONFIG_TRIBO y)
add_library(zephyr_interface INTERFACE)
function(zephyr_include_directories)
  target_include_directories(zephyr_interface INTERFACE ${ARGN})
endfunction()
function(zephyr_library_named name)
  add_library(${name} STATIC)
  target_link_libraries(${name} PUBLIC zephyr_interface)
endfunction()
function(zephyr_library_sources)
  target_sources(tribo PRIVATE ${ARGN})
endfunction()
function(zephyr_library_compile_options)
  target_compile_options(tribo PRIVATE ${ARGN})
endfunction()
add_subdirectory(${PACKAGE}/zephyr component)
""",
    "conan": "add_subdirectory(${PACKAGE} component)\n",
}


@pytest.mark.parametrize("kind, languages", [*((kind, "C") for kind in sorted(STUBS)), ("conan", "CXX")])
def test_cmake_of_a_package_builds(kind, languages, packages, tmp_path):
    main = "main.cpp" if languages == "CXX" else "main.c"
    (tmp_path / "CMakeLists.txt").write_text(f"cmake_minimum_required(VERSION 3.20)\nproject(user {languages})\n" + STUBS[kind] +
                                             f"add_executable(program {main})\ntarget_link_libraries(program PRIVATE tribo)\n"
                                             f"target_include_directories(program PRIVATE {ROOT / 'examples' / 'rig'})\n")
    (tmp_path / main).write_text(CALLER)
    run("cmake", "-S", tmp_path, "-B", tmp_path / "build", f"-DPACKAGE={packages / kind}", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON")
    commands = json.loads((tmp_path / "build" / "compile_commands.json").read_text())
    assert all("-ffp-contract=off" in row["command"] for row in commands if "/src/" in row["file"])
    run("cmake", "--build", tmp_path / "build")
    run(tmp_path / "build" / "program")


def test_manifests_of_idf_and_conan(packages):
    assert f'version: "{VERSION}"' in (packages / "idf" / "idf_component.yml").read_text()
    recipe = (packages / "conan" / "conanfile.py").read_text()
    compile(recipe, "conanfile.py", "exec")
    assert f'version = "{VERSION}"' in recipe


def test_zephyrs_kconfig_has_its_symbol(packages):
    kconfiglib = pytest.importorskip("kconfiglib")
    symbol = kconfiglib.Kconfig(packages / "zephyr" / "zephyr" / "Kconfig").syms["TRIBO"]
    assert symbol.orig_type == kconfiglib.BOOL
    assert symbol.str_value == "n"


@pytest.mark.skipif(not shutil.which("cargo"), reason="no cargo: tools/setup all")
def test_crates_pass_their_tests(cargo):
    cargo[0]("test")


@pytest.mark.skipif(not shutil.which("cargo"), reason="no cargo: tools/setup all")
@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
def test_crates_have_the_bits_of_the_librarys_own_calls(arithmetic, packages, cargo, tmp_path):
    """Axis with each controller, tuned and moved while it runs, and joint."""
    is_q31 = arithmetic == "q31"
    examples = packages / "crates" / "tribo" / "examples"
    examples.mkdir(exist_ok=True)
    shutil.copy(ROOT / "tests" / "examples" / "doors.rs", examples)
    cargo[0]("build", "--example", "doors")
    of_the_library = doors.build(tmp_path, is_q31)

    def words(row, full_scale):
        return [doors.q31(x, full_scale) if is_q31 else doors.word(x) for x in row]

    _, rows = doors.axis_run(doors.plain_pi(), doors.PERIOD + 3000)
    forces = [words(row, doors.FULL_SCALE_N) for row in rows]
    pi, outputs = doors.plain_pi(), []
    for tick, row in enumerate(rows):
        outputs += words([pi(*row) + (3 if tick % 997 < 5 else 0)], doors.FULL_SCALE_N)  # beyond the limit, too
    tuned = {"pi": [1.2 if 5000 < tick < 7000 else 1.9 for tick in range(len(rows))], "sections": [0.75 if tick > 5000 else 1.0 for tick in range(len(rows))]}
    _, swing = doors.joint_run(lambda effort, _q_ref, _q: min(max(effort, -1), 1), is_q31)
    swing = [[*words([effort], 1), *([q_ref, q] if is_q31 else words([q_ref, q], 1)), *words([0.1 if tick > 3000 else 0.0], 1)]
             for tick, (effort, q_ref, q) in enumerate(swing)]
    for arguments, played in ((["axis", "pi"], [[*row, doors.word(x)] for row, x in zip(forces, tuned["pi"])]),
                              (["axis", "sections", *(doors.word(x) for section in doors.SECTIONS for x in section)],
                               [[*row, doors.word(x)] for row, x in zip(forces, tuned["sections"])]),
                              (["axis", "paper"], [[*row, doors.word(1.0)] for row in forces]),
                              (["axis", "own"], [[*row, v] for row, v in zip(forces, outputs)]),
                              (["joint"], swing)):
        expected = of_the_library(arguments, played)
        assert len(expected) == len(played) and len(set(expected)) > 1000
        assert doors.played([cargo[1] / "debug" / "examples" / "doors", arithmetic, *arguments], played) == expected, arguments


@pytest.mark.skipif(not shutil.which("rustc"), reason="no rustc: tools/setup all")
def test_crates_build_for_the_cortex_m4f(cargo):
    target = "thumbv7em-none-eabihf"
    if not pathlib.Path(run("rustc", "--print", "target-libdir", "--target", target).strip()).exists():
        pytest.skip(f"rustc has no {target}: rustup target add {target}")
    cargo[0]("build", "--release", "--target", target)
    assert list((cargo[1] / target).rglob("libtribo-*.rlib"))

