"""Every command that a page shows is played, line by line and in the page's order, or has a reason here why it cannot be.

Commands are the lines of code blocks and the `code` of a sentence that begin with a program of this project or a path in it. Each page has a folder of its own, in
which the tree's files are links: what its commands write stays there. Words in capitals and files of the reader's own are made first, by GIVEN.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = pathlib.Path(sys.executable).parent
PAGES = sorted(subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.split())
BEGINS = re.compile(r"(?:sudo |[A-Z_]+=\S+ )*(?:tribo-[a-z]+ |tribo-link$|(?:tools|research|build|tests)/[\w./-]+|cmake |pip |mbpoll |west |\./\w|mkdir |cp |cc |python |alias )")
PATIENCE_S = 900

HARDWARE, OTHERS = "needs hardware", "needs programs of others"
ELSEWHERE = "another test plays it: "
# Page, how its command begins, why it is not played here.
REASONS = [
    ("CHANGELOG.md", "", "what was, not what is"),
    ("README.md", "tools/", "installs packages; tools/check is what runs this"),
    (".*", "tools/setup", "installs packages"),
    (".*", "tools/dev/playground", ELSEWHERE + "tests/playground"),
    (".*", "pip install", ELSEWHERE + "tests/python/wheel.py"),
    (".*", "sudo ", "installs packages"),
    (".*", "west ", OTHERS),
    (".*", "mbpoll ", ELSEWHERE + "tests/linux/test_live.py"),
    (".*", r"cmake --(preset|build|workflow|install)", "builds for a target; tools/check does"),
    (".*", r"[^#]*--target (m0|m3|m4f|m7|rv32|serial|NAME)", "needs an emulator or a board; tests/lock_step"),
    ("examples/.*", r"\./(force|joint).py", HARDWARE + "; tests/examples plays it on stand-ins"),
    ("docs/your-rig.md", "", ELSEWHERE + "tests/rig"),
    ("research/reproduction.md", "", "written by research/reproduce, which plays them"),
    (".*", r"(\S*/python )?(tools/dev/bench|research/findings|research/reproduce|tools/dev/reference|tests/\w+/study|tests/\w+/foreign_study|tests/\w+/second_solver)",
     "a study: minutes to hours, by hand"),
    (".*", "build/host-release/tests/", "a study: minutes to hours, by hand"),
    (".*", "build/demo/", "what tools/demo has built; tools/check plays tools/demo"),
    (".*", r"TRIBO_WRITES=", "minutes; tests/firmware plays less of it"),
    (".*", "tools/tribo-fmu|tribo-sim fmu|tribo-fmu", ELSEWHERE + "tests/fmu"),
    (".*", "tools/dev/packages", ELSEWHERE + "tests/examples/test_packages.py"),
    ("docs/linux.md", "tribo-drive ", HARDWARE),
    ("AGENTS.md", "tribo-link ", ELSEWHERE + "tests/linux/test_live.py, against a drive"),
    (".*", "tribo-link (-d|--device) /dev", HARDWARE),
    ("docs/linux.md", "tribo-desk rig.yaml --duration 600", ELSEWHERE + "tests/linux"),
    ("docs/linux.md", r"tribo-link (watch|serve)", "goes on until Ctrl-C; tests/linux plays it"),
    ("docs/linux.md", "tribo-link$|tribo-link (ports|start|status)", ELSEWHERE + "tests/linux/test_live.py, against a drive"),
    ("docs/identification.md", r"tools/tribo-identify friction O-ring", "needs the file of a publication"),
    ("docs/identification.md", r"tools/tribo-identify (accept friction/loop.yaml --off|actuator)", "needs logs of a rig; tests/identify has some"),
    ("tools/design/README.md", "tribo-design identify-plant STEP.csv", "the page plays it with its own record, further down"),
    ("tools/design/README.md", "cp build/paper", "writes into the tree; tests/design/test_paper.py holds that it would change nothing"),
    ("docs/tools.md", "tribo-sim run playground.yaml", "the page in a browser writes the file; tests/playground"),
    ("examples/(bare/)?README.md", "tribo-sim params", ELSEWHERE + "tests/examples"),
    ("firmware/README.md", "tribo-link", ELSEWHERE + "tests/linux, against a drive"),
    ("docs/tools.md", "tribo-sim plot fault.csv", "needs a drive's files; tests/plot"),
    ("docs/tools.md", "tribo-plot sweep_dir", "needs a sweep's files; tests/python"),
    ("docs/tools.md", r"tribo-sim plot .*\.html$", "needs uPlot (tools/setup plot); tests/plot"),
    ("docs/tools.md", "TRIBO_PYTHON=", ELSEWHERE + "tests/python/test_mcap.py"),
]


def design(folder):
    example = (ROOT / "designs/example.yaml").read_text(encoding="utf-8")
    for name in ("DESIGN.yaml", "A.yaml", "B.yaml"):
        (folder / name).write_text(example.replace("name: example", f"name: example_{name[0].lower()}"), encoding="utf-8")
    (folder / "K.json").write_text('{"zeros": [-12.0], "poles": [-0.5, -300.0], "k": 300.0}', encoding="utf-8")
    shutil.copy(ROOT / "host_sim/scenarios/noisy.yaml", folder / "LOOP.yaml")


def logs(folder):
    """A log, and friction that was identified of it."""
    subprocess.run([os.environ["TRIBO_SIM"], "run", "triangle", "--set", "duration_s=5", "--set", "metrics.start_s=0", "--out", folder / "kept"], check=True, capture_output=True)
    shutil.copy(folder / "kept/trace.csv", folder / "log.csv")
    (folder / "my_friction.yaml").write_text("gain: 0.9\nfriction: {k_min: 10}\n", encoding="utf-8")
    for name in ("rig.yaml", "old.yaml", "my_rig.yaml"):
        shutil.copy(ROOT / "host_sim/scenarios/triangle.yaml", folder / name)


def experiment(folder):
    """A log that friction can be identified from."""
    plan = [BIN / "tribo-identify", "plan", "--low", "0", "--high", "0.9", "--noise", "0.001", "--out", folder / "plan"]
    subprocess.run(plan, check=True, capture_output=True)
    subprocess.run([os.environ["TRIBO_SIM"], "run", folder / "plan/plan.yaml", "--out", folder / "kept"], check=True, capture_output=True)
    shutil.copy(folder / "kept/trace.csv", folder / "log.csv")


def study(folder):
    """The study that the page shows."""
    page = (ROOT / "docs/sweep.md").read_text(encoding="utf-8")
    (folder / "study.yaml").write_text(re.search(r"(?:^    .*\n)+", page, re.M)[0].replace("\n    ", "\n").removeprefix("    "), encoding="utf-8")


GIVEN = {"docs/sweep.md": study, "AGENTS.md": experiment, "tools/design/README.md": design, "docs/identification.md": logs, "docs/tools.md": logs, "docs/integration.md": logs, "docs/linux.md": logs,
         "host_sim/scenarios/README.md": logs}


def without_comment(line):
    return re.sub(r"\s#(?!\d).*|\s{4,}.*", "", line).strip()


def commands_of(page):
    """[(line, command)], of code blocks and of sentences."""
    found, fenced, lines = [], False, (ROOT / page).read_text(encoding="utf-8").splitlines()
    kept, is_block = "", False
    for number, line in enumerate(lines, 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif fenced or re.match(r" {4,}(?![-*] |\d+\. )", line) or kept:
            text = kept + " " * bool(kept) + line.strip()
            is_block = True
            if text.endswith("\\"):
                kept = text[:-1].strip()
                continue
            kept = ""
            if BEGINS.match(text):
                found.append((number, without_comment(text)))
                continue
            is_block = False
        if not fenced and not is_block:  # a sentence, also where a list indents it
            text = line + " " + (lines[number] if number < len(lines) and line.count("`") % 2 else "")
            found += [(number, command) for command in re.findall(r"`([^`]+)`", text) if BEGINS.match(command) and is_whole(command)]
        is_block = False
    return found


def is_whole(command):
    """True unless it is only the name of a command or of an option, which a sentence mentions."""
    words = command.split()
    return command.startswith("tribo-") and "..." not in command and any(re.search(r"[./]\w", word) for word in words[1:]) and not re.search(r"[A-Z]{3,}|\[|\|", command)


def reason_of(page, command):
    return next((reason for pages, begin, reason in REASONS if re.fullmatch(pages, page) and re.match(begin, command)), None)


PLAYED = {page: rows for page in PAGES if (rows := [(number, command) for number, command in commands_of(page) if reason_of(page, command) is None])}


def test_each_reason_is_of_a_command():
    unused = [(pages, begin) for pages, begin, _ in REASONS
              if not any(re.fullmatch(pages, page) and re.match(begin, command) for page in PAGES for _, command in commands_of(page))]
    assert not [row for row in unused if row[0] not in ("CHANGELOG.md", "research/reproduction.md")]


def test_the_pages_have_their_commands():  # tests/python plays the README's
    assert {"AGENTS.md", "docs/control-engineer.md", "docs/firmware-engineer.md", "docs/roboticist.md", "tools/design/README.md", "docs/identification.md", "docs/tools.md", "host_sim/scenarios/README.md"} <= set(PLAYED)
    design_page = [command for _, command in PLAYED["tools/design/README.md"]]
    assert [command for command in design_page if "example_rig" in command] == [
        "tribo-design tune example_rig.yaml", "tribo-sim run example_rig.yaml", "tribo-sim params example_rig.yaml --arith q31 --out example_rig.h"]


def test_a_test_that_a_page_names_is_built_first():
    """In a fresh clone ctest finds none."""
    for page in PAGES:
        for paragraph in re.split(r"\n\s*\n", (ROOT / page).read_text(encoding="utf-8")):
            at = paragraph.find("`ctest --preset")
            assert at < 0 or "tools/check" in paragraph[:at] or "cmake --build" in paragraph[:at] or page == "CHANGELOG.md", (page, paragraph)


def make_folder(folder):
    """The tree in links, and its programs in a folder for PATH."""
    for path in ROOT.iterdir():
        if path.name not in ("build", ".git"):
            (folder / path.name).symlink_to(path)
    (folder / "build").mkdir()
    programs = folder / ".programs"
    programs.mkdir()
    found = {path.name: path for path in BIN.glob("tribo-*")} | {
        "tribo-sim": os.environ["TRIBO_SIM"], "tribo-link": os.environ["TRIBO_LINK"]}
    for name, path in found.items():
        (programs / name).symlink_to(path)
    python = programs / "python"  # no link: it would not know its environment
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n', encoding="utf-8")
    python.chmod(0o755)
    return programs


def take_tuned(folder):
    """What the page asks for in words: what tune has printed goes into the scenario's compensator."""
    import ruamel.yaml

    yaml = ruamel.yaml.YAML()
    scenario = yaml.load((folder / "example_rig.yaml").read_text(encoding="utf-8"))
    tuned = yaml.load((folder / "said").read_text(encoding="utf-8"))
    scenario["compensator"] |= tuned["compensator"]
    scenario["compensator"]["friction"] = {"breakaway": {"offset_N": 0.02, "slope": 0.1}}
    with open(folder / "example_rig.yaml", "w", encoding="utf-8") as file:
        yaml.dump(scenario, file)


BEFORE = {"tribo-design tune example_rig.yaml": lambda folder: shutil.copy(folder / "build/example/example_scenario.yaml", folder / "example_rig.yaml"),
          "tribo-sim run example_rig.yaml": take_tuned,
          "tools/tribo-identify accept friction/loop.yaml --low 0.4 --high 0.6 --old old.yaml --out sequence":
              lambda folder: shutil.copy(folder / "friction/loop.yaml", folder / "old.yaml")}


@pytest.mark.parametrize("page", PLAYED)
def test_a_page_is_played(page, tmp_path):
    programs = make_folder(tmp_path)
    if page in GIVEN:
        GIVEN[page](tmp_path)
    environment = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}"}
    for number, command in PLAYED[page]:
        if command in BEFORE:
            BEFORE[command](tmp_path)
        done = subprocess.run(["bash", "-c", command], cwd=tmp_path, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        assert done.returncode == 0, f"{page}:{number}: {command}\n{done.stdout}{done.stderr}"
        (tmp_path / "said").write_text(done.stdout, encoding="utf-8")
