"""The paper's claims come out as research/reproduction.csv has them, and the report holds them."""

import csv
import os
import pathlib
import re
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tools"), str(ROOT / "research")]

from reproduction import claims  # noqa: E402
from reproduction.report import AGREES, DIFFERS, PARTLY  # noqa: E402
from reproduction.runs import ramps  # noqa: E402

QUICK = ("fig3", "fig5", "fig6", "fig10", "fig14")


def reproduce(out, *arguments):
    return subprocess.run([sys.executable, "-B", "-m", "reproduction", "--sim", os.environ["TRIBO_SIM"], "--bench", "none",
                           "--out", str(out), *arguments], cwd=ROOT, env={**os.environ, "PYTHONPATH": "tools:research"},
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    out = tmp_path_factory.mktemp("report")
    result = reproduce(out, *QUICK)
    assert (result.returncode, result.stderr) == (0, "")
    return out


def recorded():
    """Returns what rows() reads from the page that --update wrote."""
    with open(ROOT / "research/reproduction.csv", encoding="utf-8", newline="") as file:
        return {row["where"]: (row["this run shows"], row["verdict"]) for row in csv.DictReader(file)}


def rows(markdown):
    """The claims' rows: where, what the run shows, verdict. The report has columns between and behind."""
    table = [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in markdown.splitlines() if re.search(r"\| (agrees|partly|differs) \|", line)]
    verdicts = [next(i for i, cell in enumerate(cells) if cell in (AGREES, PARTLY, DIFFERS)) for cells in table]
    return {cells[0]: (cells[i - 1], cells[i]) for cells, i in zip(table, verdicts)}


def test_quick_claims_come_out_as_the_document_says(report):
    now = rows((report / "report.md").read_text(encoding="utf-8"))
    document = recorded()
    assert len(now) == 11
    for where, row in now.items():
        assert document[where] == row


def test_the_report_is_one_file_with_its_figures(report):
    page = (report / "report.html").read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") == len(QUICK)
    assert "src=\"report/" not in page and "http" not in page
    assert sorted(file.stem for file in (report / "report").glob("*.png")) == sorted(QUICK)


def test_the_document_counts_what_it_has():
    document = (ROOT / "research" / "reproduction.md").read_text(encoding="utf-8")
    agree, all_of_them = map(int, re.search(r"^(\d+) of (\d+) claims agree", document, re.M).groups())
    verdicts = [verdict for _, verdict in recorded().values()]
    assert (verdicts.count(AGREES), len(verdicts)) == (agree, all_of_them)


def test_an_unknown_claim_is_named(tmp_path):
    result = reproduce(tmp_path, "fig9")
    assert result.returncode == 2 and "no claim 'fig9'; there are fig2, fig3" in result.stderr


def test_ramps_are_corners_of_a_polygon():
    corners = claims.np.array(ramps((0.6, 0.2), (2.0, 0), (0.4, 0.1)))
    assert corners == pytest.approx(claims.np.array([(0, 0), (3.0, 0.6), (5.0, 0.6), (7.0, 0.4)]))


def test_k_is_recovered_from_friction():
    f = 7.5 * 0.1 * claims.np.tanh(0.08 / (7.5 * 0.1))
    assert claims.k_of(f, 0.08, 0.1) == pytest.approx(7.5)


def test_a_step_response_is_that_of_its_poles():
    t = claims.np.array([0.0, 0.1, 5.0])
    one = claims.step_of(claims.np.array([-2.0]), 3.0, t)
    assert one == pytest.approx(3 * (1 - claims.np.exp(-2 * t)))


@pytest.mark.parametrize("words, said", [(("--list", "--list"), "--list is given twice"), (("--update", "--up"), "--update is given twice"),
                                         (("--out", "a"), "--out OUT and --out a: only one is expected")])
def test_an_option_is_given_once(tmp_path, words, said):
    result = reproduce(tmp_path, *words)
    assert result.returncode == 2 and result.stderr.endswith(f": error: {said.replace('OUT', str(tmp_path))}\n") and not list(tmp_path.iterdir())
