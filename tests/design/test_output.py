"""The generated files: byte-identical, compilable, whole or absent, and `check` sees every change."""

import json
import os
import re
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import PAPER, ROOT

from tribo_design import output
from tribo_design.cli import main
from tribo_design.errors import InputError


def test_the_same_input_gives_the_same_bytes(paper_dir, tmp_path):
    again = tmp_path / "again"
    assert main(["synthesize", str(PAPER), "--out", str(again), "--no-plots"]) == 0
    names = sorted(p.name for p in paper_dir.iterdir())
    assert names == ["DESIGN.yaml", "paper_controller.c", "paper_controller.h", "paper_design.json", "paper_scenario.yaml", "report.html", "report.md"]
    for name in names:
        assert (again / name).read_bytes() == (paper_dir / name).read_bytes(), name


@pytest.mark.parametrize("name, folder", [("paper_controller.h", "include/tribo"), ("paper_controller.c", "src/controller")])
def test_the_librarys_controller_is_this_tools_output(paper_dir, name, folder):
    assert (paper_dir / name).read_text() == (ROOT / "lib" / folder / name).read_text(), "make it again, as tools/design/README.md says"


@pytest.mark.skipif("TRIBO_SIM" not in os.environ, reason="no tribo-sim: TRIBO_SIM is not set")
def test_tribo_sim_makes_the_headers_params_of_the_scenario(run, tmp_path):
    """With a plant's gain of 1; another is in the scenario's last section, as friction is in newton of F."""
    design = tmp_path / "design.yaml"
    design.write_text(PAPER.read_text().replace("gain: 0.86", "gain: 1"))
    (tmp_path / "k.json").write_text(json.dumps({"zeros": [-55, -200], "poles": [-0.01, -400], "k": 0.8}))
    code, _, err = run("import", tmp_path / "k.json", "--design", design, "--out", tmp_path / "out", "--no-plots")
    assert code == 0, err
    params = subprocess.run([os.environ["TRIBO_SIM"], "params", tmp_path / "out" / "paper_scenario.yaml", "--arith", "q31"], capture_output=True, text=True, check=True).stdout
    header = (tmp_path / "out" / "paper_controller.h").read_text()
    for field in ("b0", "c1", "minus_a1", "c2", "d2", "d2_low", "shift", "scale", "count", "input_scale", "output_scale", "anti_windup", "taken_max", "u_min", "u_max"):
        numbers = re.findall(rf"\.{field} = (-?\d+)", header)
        assert numbers and re.findall(rf"\.{field} = (-?\d+)", params)[: len(numbers)] == numbers, field


@pytest.mark.parametrize("sample_time_s, pulse", [(1e-3, None), (4.7e-5, "0.000141"), (4.8e-5, None), (6.1e-3, "0.0183"), (5.9e-3, None)])
def test_a_scenario_has_a_pulse_that_its_tick_can_have(sample_time_s, pulse):
    from tribo_design.config import load_design
    from tribo_design.friction import scenario
    from tribo_design.synthesis import make_plant

    design = load_design(PAPER)[0].model_copy(update={"sample_time_s": sample_time_s})
    found = re.findall(r"pulse_width_s: (\S+)", scenario(design, make_plant(design.plant)[0], [[1.0] * 5], "paper.yaml"))
    assert found == ([] if pulse is None else [pulse])


@pytest.mark.skipif("TRIBO_SIM" not in os.environ, reason="no tribo-sim: TRIBO_SIM is not set")
@pytest.mark.parametrize("full_scale", [0.002, 0.005, 0.5, 50.0, 8000.0, 1e6])
@pytest.mark.parametrize("sample_time_s", [1e-6, 1e-5, 1e-3, 0.1])
def test_tribo_sim_takes_the_scenario_of_any_full_scale_and_tick(tmp_path, full_scale, sample_time_s):
    from tribo_design.config import load_design
    from tribo_design.friction import scenario
    from tribo_design.synthesis import make_plant

    design = load_design(PAPER)[0]
    design = design.model_copy(update={"sample_time_s": sample_time_s, "fixed_point": design.fixed_point.model_copy(
        update={"full_scale_n": full_scale, "u_max_n": full_scale})})
    path = tmp_path / "odd.yaml"
    path.write_text(scenario(design, make_plant(design.plant)[0], [[1.0, 0.75, 0.125, 0.5, 0.0625]], "paper.yaml"))
    for arithmetic in ("f32", "q31"):
        made = subprocess.run([os.environ["TRIBO_SIM"], "params", path, "--arith", arithmetic], capture_output=True, text=True, check=False)
        assert (made.returncode, made.stderr) == (0, "")


@pytest.mark.skipif("TRIBO_SIM" not in os.environ, reason="no tribo-sim: TRIBO_SIM is not set")
@pytest.mark.parametrize("gain", [200.0, 0.02, -3.0])
def test_the_scenario_that_is_written_is_the_designs_loop_whatever_the_plants_gain(run, tmp_path, gain):
    """The same loop but for the gain's place: a K that is as many times smaller. Its run is the report's, in both arithmetics."""
    text = PAPER.read_text().replace("gain: 0.86", f"gain: {gain}")
    (tmp_path / "design.yaml").write_text(text)
    (tmp_path / "k.json").write_text(json.dumps({"zeros": [-55, -200], "poles": [-0.01, -400], "k": 0.8 / gain}))
    code, _, err = run("import", tmp_path / "k.json", "--design", tmp_path / "design.yaml", "--out", tmp_path / "out", "--no-plots")
    assert code == 0, err
    reported = json.loads((tmp_path / "out" / "paper_design.json").read_text())["friction"]["rms_n"]["with"]
    for arithmetic in ("f32", "q31"):
        done = subprocess.run([os.environ["TRIBO_SIM"], "run", tmp_path / "out" / "paper_scenario.yaml", "--json", "--arith", arithmetic], capture_output=True, text=True, check=True)
        played = json.loads(done.stdout)["rms_error_N"]
        assert played == pytest.approx(reported, rel=0.02)
        low, high = (float(n) for n in re.search(r"low_N: (\S+), high_N: (\S+),", (tmp_path / "out" / "paper_scenario.yaml").read_text()).groups())
        assert played < 0.5 * (high - low)


def test_a_tick_that_tribo_sim_cannot_have_gets_no_scenario(run, tmp_path):
    (tmp_path / "slow.yaml").write_text(PAPER.read_text().replace("sample_time_s: 1.0e-3", "sample_time_s: 0.2").replace(
        "computation_delay_s: 1.0e-4", "computation_delay_s: 0"))
    (tmp_path / "k.json").write_text(json.dumps({"sos": [[0.01, 0, 0, 1, -0.9, 0]], "sample_time_s": 0.2}))
    code, _, err = run("import", tmp_path / "k.json", "--design", tmp_path / "slow.yaml", "--out", tmp_path / "out", "--no-plots")
    assert code == 0, err
    assert not list((tmp_path / "out").glob("*_scenario.yaml"))
    assert run("check", tmp_path / "out")[0] == 0


def test_header_names_input_version_and_gamma(paper_dir):
    import hashlib

    text = (paper_dir / "paper_controller.h").read_text()
    assert hashlib.sha256(PAPER.read_bytes()).hexdigest() in text
    assert re.search(r"tribo-design \d+\.\d+\.\d+ \(python-control", text)
    assert "gamma     1.737" in text


COMPILERS = [c for c in ("gcc", "clang") if shutil.which(c)]


@pytest.mark.skipif(not COMPILERS, reason="no C compiler")
@pytest.mark.parametrize("compiler", COMPILERS)
def test_c_compiles_without_warnings_and_holds_the_json_numbers(paper_dir, tmp_path, compiler):
    probe = tmp_path / "probe.c"
    probe.write_text("""#include "tribo/controller_f32.h"
#include "tribo/controller_q31.h"
#include "paper_controller.h"
#include <stddef.h>
#include <stdio.h>
int main(void)
{
    const tribo_biquad_f32_section_t macro[] = TRIBO_PAPER_CONTROLLER_F32;
    for (unsigned i = 0; i < TRIBO_PAPER_CONTROLLER_SECTION_COUNT; ++i)
    {
        const tribo_biquad_f32_section_t *s = &tribo_paper_controller_f32[i];
        if (macro[i].a2 != s->a2) { return 1; }
        printf("%.17g %.17g %.17g %.17g %.17g\\n", (double)s->b0, (double)s->b1, (double)s->b2, (double)s->a1, (double)s->a2);
    }
    // What is in flash is, bit by bit, what the library makes at run time of the f32 sections.
    const tribo_controller_f32_config_t config = {.sections = tribo_paper_controller_f32, .section_count = TRIBO_PAPER_CONTROLLER_SECTION_COUNT,
                                                  .u_min_n = -TRIBO_PAPER_CONTROLLER_U_MAX_N, .u_max_n = TRIBO_PAPER_CONTROLLER_U_MAX_N};
    tribo_controller_q31_params_t made;
    if (tribo_controller_q31_init(&made, &config, TRIBO_PAPER_CONTROLLER_FULL_SCALE_N, NULL) != TRIBO_OK) { return 2; }
    for (unsigned i = 0; i < TRIBO_PAPER_CONTROLLER_SECTION_COUNT; ++i)
    {
        const tribo_biquad_q31_section_t *a = &made.cascade.section[i], *b = &tribo_paper_controller_q31.cascade.section[i];
        if (a->b0 != b->b0 || a->c1 != b->c1 || a->c2 != b->c2 || a->minus_a1 != b->minus_a1 || a->d2 != b->d2 || a->shift != b->shift ||
            a->d2_low != b->d2_low || a->scale != b->scale) { return 3; }
    }
    if (made.cascade.count != tribo_paper_controller_q31.cascade.count || made.cascade.output_scale != tribo_paper_controller_q31.cascade.output_scale || made.cascade.input_scale != tribo_paper_controller_q31.cascade.input_scale ||
        made.anti_windup != tribo_paper_controller_q31.anti_windup || made.anti_windup_shift != tribo_paper_controller_q31.anti_windup_shift ||
        made.taken_max != tribo_paper_controller_q31.taken_max ||
        made.u_min != tribo_paper_controller_q31.u_min || made.u_max != tribo_paper_controller_q31.u_max) { return 4; }
    return 0;
}
""")
    program = tmp_path / "probe"
    subprocess.run([compiler, "-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror", "-ffp-contract=off", "-I", ROOT / "lib" / "include",
                    "-I", ROOT / "lib" / "src", "-I", paper_dir, probe, *sorted((ROOT / "lib" / "src").rglob("*.c")), "-o", program], check=True)  # with paper_controller.c
    lines = subprocess.run([program], check=True, capture_output=True, text=True).stdout.splitlines()
    stored = json.loads((paper_dir / "paper_design.json").read_text())["sections"]
    assert [[float(x) for x in line.split()] for line in lines] == stored["f32"]


def test_header_is_cpp_too(paper_dir, tmp_path):
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    probe = tmp_path / "probe.cpp"
    probe.write_text('#include "tribo/controller_f32.h"\n#include "tribo/controller_q31.h"\n#include "paper_controller.h"\n'
                     "const tribo_biquad_f32_section_t f32[] = TRIBO_PAPER_CONTROLLER_F32;\n"
                     "const tribo_controller_q31_params_t q31 = TRIBO_PAPER_CONTROLLER_Q31;\n")
    subprocess.run([compiler, "-std=c++20", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-fsyntax-only", "-I", ROOT / "lib" / "include",
                    "-I", paper_dir, probe], check=True)


def test_check_sees_a_full_controller_of_another_gain(run, copy):
    data = json.loads((copy / JSON).read_text())
    data["full"]["gain"] *= 1.01
    (copy / JSON).write_text(json.dumps(data))
    code, _, err = run("check", copy)
    assert code == 5 and "full K, gamma is" in err


@pytest.mark.parametrize("name", ["report.md", "DESIGN.yaml", "plots/mine.png"])
def test_a_file_of_an_outputs_name_alone_is_no_output(run, tmp_path, name):
    mine = tmp_path / "mine" / name
    mine.parent.mkdir(parents=True)
    mine.write_text("precious")
    code, _, err = run("synthesize", PAPER, "--out", tmp_path / "mine", "--no-plots")
    assert code == 2 and f"has other files in it ({name})" in err
    assert mine.read_text() == "precious"


def test_a_folder_with_other_files_is_not_replaced(run, copy):
    (copy / "mine").mkdir()
    (copy / "mine" / "notes_controller.h").write_text("mine")
    code, _, err = run("synthesize", copy / "DESIGN.yaml", "--out", copy, "--no-plots")
    assert code != 0 and "has other files in it (mine/notes_controller.h)" in err
    assert (copy / "mine" / "notes_controller.h").read_text() == "mine"
    shutil.rmtree(copy / "mine")
    assert run("synthesize", copy / "DESIGN.yaml", "--out", copy, "--no-plots")[0] == 0


@pytest.fixture
def copy(paper_dir, tmp_path):
    shutil.copytree(paper_dir, tmp_path / "copy")
    return tmp_path / "copy"


def test_check_agrees_with_what_was_generated(run, paper_dir):
    code, out, err = run("check", paper_dir)
    assert code == 0, err
    assert "agree" in out


def spoil(path, pattern, replacement, count=1):
    text = path.read_text()
    changed = re.sub(pattern, replacement, text, count=count)
    assert changed != text, pattern
    path.write_text(changed)


HEADER, JSON, SCENARIO = "paper_controller.h", "paper_design.json", "paper_scenario.yaml"


@pytest.mark.parametrize("name, pattern, replacement, said", [
    (HEADER, r"(F32 .*\n.*\n +\{)1\.818", r"\g<1>1.819", "f32 section 1 b0"),
    (HEADER, r"(\d)(\de-07f)", lambda m: f"{(int(m.group(1)) + 1) % 10}{m.group(2)}", "f32 section 2 a2"),
    (HEADER, r"\.d2 = -9991", ".d2 = -9992", "Q31 section 2 d2"),
    (HEADER, r"d2_low = 1", "d2_low = 2", "Q31 section 2 d2_low"),
    (HEADER, r"\.scale = 4\},(.*\n)*?.*\.count", lambda m: m.group(0).replace(".scale = 4},", ".scale = 5},", 1), "Q31 section 1 scale"),
    (HEADER, r"output_scale = 4", "output_scale = 5", "Q31 output_scale"),
    (HEADER, r"input_scale = 3", "input_scale = 2", "Q31 input_scale"),
    (HEADER, r"anti_windup = 1", "anti_windup = 2", "Q31 anti_windup"),
    (HEADER, r"taken_max = 1", "taken_max = 2", "Q31 taken_max"),
    (JSON, r'"sample_time_s": 0.001', '"sample_time_s": 0.002', "sample_time_s"),
    (JSON, r'"computation_delay_s": 0.000\d', '"computation_delay_s": 0.0009', "computation_delay_s"),
    (JSON, r'"full_scale_n": 2.0', '"full_scale_n": 4.0', "full_scale_n"),
    (JSON, r'("q31_values": \[\s*\[\s*\d\.\d)\d', lambda m: m.group(1) + "0", "q31_values"),
    (JSON, r'("q31_peaks": \[\s*)\d', r"\g<1>9", "q31_peaks"),
    (JSON, r'("anti_windup": )[01]', r"\g<1>7", "anti_windup"),
    (HEADER, r"u_max = 2147483647", "u_max = 2147483646", "Q31 u_max"),
    (HEADER, r"U_MAX_N 2.0f", "U_MAX_N 1.0f", "output limit"),
    (HEADER, r"SAMPLE_TIME_S 0.001f", "SAMPLE_TIME_S 0.002f", "sample time"),
    (HEADER, r"FULL_SCALE_N 2.0f", "FULL_SCALE_N 4.0f", "full scale"),
    (HEADER, r"SECTION_COUNT 2u", "SECTION_COUNT 3u", "rows of 5"),
    (HEADER, r"gamma     1\.73", "gamma     1.63", r"paper_controller\.h:\d+: a line"),
    (HEADER, r"SHA-256 (\w)", lambda m: "SHA-256 " + ("0" if m.group(1) != "0" else "1"), r"paper_controller\.h:\d+: a line"),
    (HEADER, r"CONTROLLER_Q31", "CONTROLLER_Q30", "Q31 is missing"),
    ("paper_controller.c", r"= TRIBO_PAPER_CONTROLLER_Q31", "= TRIBO_OTHER_CONTROLLER_Q31", r"paper_controller\.c:\d+: a line"),
    (SCENARIO, r"b2: 0\.(\d+)(\d)", lambda m: f"b2: 0.{m.group(1)}{(int(m.group(2)) + 1) % 10}", r"paper_scenario\.yaml:\d+: a line"),
    (SCENARIO, r"sample_time_s: 0\.001", "sample_time_s: 0.002", r"paper_scenario\.yaml:\d+: a line"),
    (SCENARIO, r"full_scale_N: 2", "full_scale_N: 4", r"paper_scenario\.yaml:\d+: a line"),
    (SCENARIO, r"metrics: .*\n", "", r"paper_scenario\.yaml:\d+: a line"),
    ("DESIGN.yaml", r"gain: 0\.86", "gain: 0.87", "SHA-256"),
    ("report.md", r"\| 1\.7616 \|", "| 1.7516 |", r"report\.md:\d+: a line"),
    ("report.md", r"SHA-256 \w", "SHA-256 x", "report.md"),
    ("report.html", r"<td>1\.7616</td>", "<td>1.7516</td>", r"report\.html:\d+: a line"),
    (JSON, r'"gamma": 1\.76', '"gamma": 1.75', "gamma"),
    (JSON, r'"stable": true', '"stable": false', "stable"),
    (JSON, r'"f32": \[', '"f33": [', "paper_design.json"),
    (JSON, r"^\{", "[", "not JSON"),
])
def test_check_sees(run, copy, name, pattern, replacement, said):
    spoil(copy / name, pattern, replacement)
    code, _, err = run("check", copy)
    assert code == 5
    assert re.search(said, err), err


def test_check_closes_the_loop_with_the_headers_numbers(run, copy):
    """Header, scenario and JSON changed alike, consistently to the last bit: the loop still tells."""
    data = json.loads((copy / JSON).read_text())
    from tribo_design.quantise import to_f32

    rows = data["sections"]["design"]
    rows[1][0] *= 1.5
    f32 = to_f32(rows)
    old = data["sections"]["f32"][1][0]
    data["sections"]["f32"] = f32.tolist()
    (copy / JSON).write_text(json.dumps(data))
    spoil(copy / HEADER, re.escape(f"{old:.8e}f"), f"{f32[1][0]:.8e}f")
    spoil(copy / SCENARIO, re.escape(f"b0: {old * 0.86:.9g}"), f"b0: {f32[1][0] * 0.86:.9g}")
    code, _, err = run("check", copy)
    assert code == 5
    assert "Q31 params are not what the library makes" in err


def test_check_sees_a_loop_that_is_not_the_tables(run, copy):
    """Another plant in the design, its hash put right everywhere: only the loop can tell."""
    import hashlib

    old = hashlib.sha256((copy / "DESIGN.yaml").read_bytes()).hexdigest()
    spoil(copy / "DESIGN.yaml", r"gain: 0\.86", "gain: 0.87")
    new = hashlib.sha256((copy / "DESIGN.yaml").read_bytes()).hexdigest()
    for path in copy.iterdir():
        path.write_text(path.read_text().replace(old, new))
    code, _, err = run("check", copy)
    assert code == 5
    assert re.search(r"K\(z\), Q31, gain_margin", err) 


@pytest.mark.parametrize("missing", ["paper_controller.h", "paper_controller.c", "paper_design.json", "paper_scenario.yaml", "DESIGN.yaml", "report.md"])
def test_check_misses_a_file(run, copy, missing):
    (copy / missing).unlink()
    code, _, err = run("check", copy)
    assert code == 2 and ("cannot be read" in err or "found 0" in err)


def test_a_step_past_its_limit_writes_nothing_and_prints_the_table(run, tmp_path):
    design = tmp_path / "tight.yaml"
    design.write_text(PAPER.read_text().replace("phase_margin_deg: 2,", "phase_margin_deg: 0.1,"))
    code, out, err = run("synthesize", design, "--out", tmp_path / "out")
    assert code == 4
    assert "discrete: phase margin" in err and "limit 0.1 deg (phase_margin_deg)" in err and "nothing was written" in err
    assert "gamma" in out and "K(z)" in out
    assert sorted(p.name for p in tmp_path.iterdir()) == ["tight.yaml"]


LIMITS = [("reduced", "gamma_percent"), ("discrete", "gamma_percent"), ("discrete", "max_s_percent"), ("discrete", "gain_margin_percent"), ("discrete", "delay_margin_percent"),
          ("total", "gamma_percent"), ("total", "phase_margin_deg")]


@pytest.mark.parametrize("step, limit", LIMITS)
def test_each_limit_is_enforced(paper_data, step, limit):
    from tribo_design.config import Design, validate
    from tribo_design.errors import LimitError
    from tribo_design.pipeline import synthesize

    paper_data["limits"][step][limit] = 0
    with pytest.raises(LimitError, match=f"^{step}.*{limit}"):
        synthesize(validate(Design, paper_data, "x"), "0" * 64, "x")


@pytest.mark.parametrize("floor, value", [("gain_margin_min", 11), ("phase_margin_min_deg", 82)])
def test_floors_are_enforced(paper_data, floor, value):
    from tribo_design.config import Design, validate
    from tribo_design.errors import LimitError
    from tribo_design.pipeline import synthesize

    paper_data["limits"]["floor"][floor] = value
    with pytest.raises(LimitError, match=floor):
        synthesize(validate(Design, paper_data, "x"), "0" * 64, "x")


def test_an_earlier_output_is_replaced_and_other_files_are_not(run, copy, tmp_path):
    (copy / "plots").mkdir(exist_ok=True)
    (copy / "plots" / "stale.png").write_text("x")
    assert run("synthesize", PAPER, "--out", copy, "--no-plots")[0] == 0
    assert not (copy / "plots").exists()
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.txt").write_text("precious")
    code, _, err = run("synthesize", PAPER, "--out", mine, "--no-plots")
    assert code == 2 and "other files" in err
    assert (mine / "thesis.txt").read_text() == "precious"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["copy", "mine"]


def test_a_failing_disk_leaves_nothing(run, tmp_path, monkeypatch):
    original = Path.write_bytes

    def full(self, data):
        if self.name == "report.html":
            raise OSError(28, "No space left on device")
        return original(self, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    code, _, err = run("synthesize", PAPER, "--out", tmp_path / "new/out", "--no-plots")
    assert code == 2 and "No space left" in err
    assert list(tmp_path.iterdir()) == []


def test_the_worked_example_is_what_the_readme_says(run, tmp_path):
    code, out, err = run("identify-plant", ROOT / "designs" / "example_step.csv", "--no-friction", "--out", tmp_path / "plant")
    assert code == 0, err
    readme = (ROOT / "tools" / "design" / "README.md").read_text()
    for line in out.splitlines()[1:5]:
        assert line in readme
    code, out, err = run("synthesize", ROOT / "designs" / "example.yaml", "--out", tmp_path / "out", "--no-plots")
    assert code == 0, err
    data = json.loads((tmp_path / "out" / "example_design.json").read_text())
    assert data["metrics"]["full"]["gamma"] == pytest.approx(0.966, abs=0.001)
    assert data["metrics"]["q31"]["gamma"] == pytest.approx(0.966, abs=0.001)
    assert run("check", tmp_path / "out")[0] == 0


@pytest.fixture
def earlier(tmp_path):
    """An earlier output."""
    (tmp_path / "out/plots").mkdir(parents=True)
    for name in ("DESIGN.yaml", "report.md", "report.html", "plots/a.png"):
        (tmp_path / "out" / name).write_text("old")
    return tmp_path / "out"


FILES = {"DESIGN.yaml": b"new", "report.md": b"new", "report.html": b"new", "plots/a.png": b"new"}


def test_an_output_that_is_replaced_keeps_its_modes(earlier):
    for path, mode in ((earlier, 0o2750), (earlier / "report.md", 0o600), (earlier / "plots/a.png", 0o640)):
        path.chmod(mode)
    output.write_directory(earlier, FILES)
    assert [stat.S_IMODE((earlier / name).stat().st_mode) for name in ("", "report.md", "plots/a.png")] == [0o2750, 0o600, 0o640]
    assert all((earlier / name).read_bytes() == b"new" for name in FILES) and list(earlier.parent.iterdir()) == [earlier]


def test_an_empty_name_is_no_output(run):
    code, _, err = run("synthesize", PAPER, "--out", "", "--no-plots")
    assert code == 2 and "--out: is empty" in err


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError])
@pytest.mark.parametrize("number", [1, 2])
def test_an_output_stays_if_it_cannot_be_replaced(earlier, monkeypatch, error, number):
    original, calls = Path.rename, []

    def rename(self, to):
        calls.append(to)
        if len(calls) == number:
            raise error
        return original(self, to)

    monkeypatch.setattr(Path, "rename", rename)
    with pytest.raises((KeyboardInterrupt, InputError)):
        output.write_directory(earlier, FILES)
    assert all((earlier / name).read_bytes() == b"old" for name in FILES) and list(earlier.parent.iterdir()) == [earlier]


def test_a_new_output_has_the_mode_of_any_new_directory(tmp_path):
    mask = os.umask(0o027)
    try:
        output.write_directory(tmp_path / "out", FILES)
    finally:
        os.umask(mask)
    assert [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("out", "out/report.md")] == [0o750, 0o640]


@pytest.mark.parametrize("name", ["report.md", "plots/a.png", "plots", ""])
def test_an_output_with_a_read_only_part_is_refused_before_the_work(earlier, run, name):
    path = earlier / name
    path.chmod(0o555 if path.is_dir() else 0o444)
    code, out, err = run("synthesize", PAPER, "--out", earlier, "--no-plots")
    path.chmod(0o755)
    assert (code, out) == (2, "") and err.endswith(f"tribo-design: --out {earlier}: cannot be replaced: {path} is read-only\n")
    assert all((earlier / one).read_bytes() == b"old" for one in FILES)


def test_a_link_to_an_output_stays_a_link(earlier):
    link = earlier.parent / "link"
    link.symlink_to("out")
    output.write_directory(link, FILES)
    assert os.readlink(link) == "out" and (earlier / "report.md").read_bytes() == b"new" and sorted(earlier.parent.iterdir()) == [link, earlier]


@pytest.mark.parametrize("words", [("--help",), ("--version",), ("compare", "--help"), ("tune",)])
def test_a_failed_write_of_the_output_is_an_error(words):
    for program in ("tribo_design", "tribo_identify", "tribo_rig"):
        if words[0] in ("compare", "tune") and program != "tribo_design":
            continue
        with open("/dev/full", "w") as full:
            done = subprocess.run([sys.executable, "-B", "-m", program, *words], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        assert (done.returncode, done.stderr) == (1, f"{program.replace('_', '-')}: standard output: cannot be written: No space left on device\n")


def test_structures_without_a_design_file_are_refused(run, tmp_path):
    code, _, err = run("compare", tmp_path, "--structures", "pi")
    assert code == 2 and err.startswith("tribo-design: --structures: is of design files")


def test_a_step_whose_height_is_known_takes_no_step_size(run, tmp_path):
    log = tmp_path / "step.csv"
    log.write_text("t_s,u_N,F_N\n" + "".join(f"{k / 1000:g},{float(k >= 100):g},{0.8 * (1 - 0.99 ** max(k - 100, 0)):.6g}\n" for k in range(1000)))
    code, out, err = run("identify-plant", log, "--step-size", 2, "--out", tmp_path / "out")
    assert code == 2 and out == "" and "--step-size: step.csv has a u that moves" in err and not (tmp_path / "out").exists()
