"""200 controllers of python-control's mixsyn and hinfsyn: none comes in as another one."""

import collections
import json

import numpy as np
import pytest
import scipy.io
from conftest import PAPER
from controllers import FORMS, outcome, synthesised

from tribo_design.config import load_design
from tribo_design.importer import load_controller


def test_200_synthesised_controllers_come_in_as_they_are(tmp_path):
    design, _ = load_design(PAPER)
    found = collections.Counter()
    made = seed = 0
    while made < 200:
        k = synthesised(seed)
        seed += 1
        if k is None:
            continue
        for i in range(3):
            form = FORMS[(3 * made + i) % len(FORMS)]
            result = outcome(tmp_path, form, k, design)
            assert not result.startswith("WRONG"), (seed - 1, form, result)
            # Rounding a polynomial in z can make a slow pole unstable: true of the file, and said.
            assert result == "equal" or ("is unstable" in result and "discrete" in form + "discrete" * ("sos" in form)), (seed - 1, form, result)
            found[result.split(":")[0]] += 1
        made += 1
    assert found["equal"] >= 570, found


def test_a_mode_next_to_a_pole_at_1e10_is_kept(tmp_path):
    """What ct.minreal dropped: a slow mode whose residue is small beside the fast one's."""
    design, _ = load_design(PAPER)
    a, b, c = np.diag([-0.002, -340.0, -1e10]), np.array([1e-3, 1.0, 1e5]), np.array([25.0, 3.0, 1e5])
    (tmp_path / "k.json").write_text(json.dumps({"a": a.tolist(), "b": b.tolist(), "c": c.tolist(), "d": 0}))
    k = load_controller(tmp_path / "k.json", design)[0].zpk
    omega = np.array([1e-4, 1e-2, 1.0, 1e3, 1e9])
    assert k.order == 3
    assert np.allclose(k(1j * omega), sum(c[i] * b[i] / (1j * omega - a[i, i]) for i in range(3)), rtol=1e-12)


def test_a_response_that_is_not_the_files_is_refused(run, tmp_path, monkeypatch):
    from tribo_design import exact, importer
    from tribo_design.zpk import Zpk

    original = exact.Ratio.zpk
    monkeypatch.setattr(importer.Ratio, "zpk", lambda self: (lambda s: Zpk(s.zeros, s.poles, s.gain * (1 + 3e-6)))(original(self)))
    (tmp_path / "k.json").write_text(json.dumps({"a": [[-2, 0], [0, -7]], "b": [1, 1], "c": [3, 5], "d": 1}))
    code, _, err = run("import", tmp_path / "k.json", "--design", PAPER, "--out", tmp_path / "out")
    assert code == 2 and "cannot be represented" in err and "rad/s" in err


def test_reals_of_complex_type_are_reals(tmp_path):
    design, _ = load_design(PAPER)
    (tmp_path / "k.json").write_text(json.dumps({"zeros": ["-5+0j"], "poles": [[-10, 0]], "k": "2+0j"}))
    scipy.io.savemat(tmp_path / "k.mat", {"A": np.array([[-10 + 0j]]), "B": np.array([[1 + 0j]]), "C": np.array([[-10 + 0j]]), "D": np.array([[2 + 0j]])})
    for name in ("k.json", "k.mat"):
        k = load_controller(tmp_path / name, design)[0].zpk
        assert np.allclose(k([1j]), 2 * (1j + 5) / (1j + 10)), name


def test_a_sample_time_that_is_not_the_designs_is_shown_with_all_its_digits(run, tmp_path):
    (tmp_path / "k.json").write_text(json.dumps({"zeros": [0.5], "poles": [0.9], "k": 1, "sample_time_s": 1.0000001e-3}))
    assert "0.0010000001: must be the design's, 0.001\n" in run("import", tmp_path / "k.json", "--design", PAPER, "--out", tmp_path / "out")[2]


HOSTILE = {
    "digits.json": '{"zeros": [], "poles": [-1], "k": 1' + "0" * 400 + "}", "more_digits.json": '{"zeros": [], "poles": [-1], "k": 1' + "0" * 9000 + "}",
    "root_digits.json": '{"zeros": [], "poles": [-1' + "0" * 400 + '], "k": 1}', "keys.json": "{" + ",".join(f'"k{i}": 1' for i in range(100_000)) + "}",
    "rows.json": '{"sample_time_s": 0.001, "sos": [' + ",".join(["[1,0,0,1,0,0]"] * 20_000) + "]}",
    "matrix.json": '{"a": [' + ",".join(["[1]"] * 100_000) + '], "b": [1], "c": [1]}', "empty.json": '{"a": [], "b": [], "c": []}',
    "large.json": '{"a": [[-1e300, 1], [0, -1]], "b": [1, 1], "c": [1e300, 1]}', "small.json": '{"a": [[-1e-300]], "b": [1e-300], "c": [1]}',
    "field.csv": "kind,re,im\ngain," + "1" * 200_000 + ",0\n", "nul.csv": "kind,re,im\ngain,\x00,0\n", "text.json": '{"k": "' + "n" * 500_000 + '", "poles": []}',
    "deep.json": '{"a": ' + "[" * 100_000, "range.json": '{"num": [1e99, 1e99], "den": [1e-99, 1, 1e99, 1e-99, 1e99]}', "list.json": '{"sos": [[]], "Ts": 0.001}',
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_controllers_are_refused_at_once(run, tmp_path, name):
    import time

    (tmp_path / name).write_text(HOSTILE[name])
    began = time.process_time()
    code, _, err = run("import", tmp_path / name, "--design", PAPER, "--out", tmp_path / "out", "--no-plots")
    assert code == 2 and name in err and len(err) < 600, err[:600]
    assert time.process_time() - began < 2
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("old, new", [("sample_time_s: 1.0e-3", "sample_time_s: 1" + "0" * 400), ("-55, -200", "-55, -2" + "0" * 400), ("gain: 0.86", "gain: 1.0e300"), ("gain: 0.86", "gain: 1.0e-300"),
                                      ("order_max: 8", "order_max: 8" + "0" * 5000), ("wu: 1", "wu: 1.0e+300"), ("wu: 1", "wu: {num: [1.0e-300, 1.0e300], den: [1.0e300, 1]}")])
def test_hostile_numbers_in_a_design_are_refused(run, tmp_path, old, new):
    (tmp_path / "d.yaml").write_text(PAPER.read_text().replace(old, new, 1))
    code, _, err = run("synthesize", tmp_path / "d.yaml", "--out", tmp_path / "out", "--no-plots")
    assert code in (2, 3) and "d.yaml" in err or code == 3, err


def test_a_record_with_a_huge_field_is_refused(run, tmp_path):
    (tmp_path / "r.csv").write_text("t_s,u_n,y_n\n0,1," + "1" * 200_000 + "\n")
    code, _, err = run("identify-plant", tmp_path / "r.csv")
    assert code == 2 and "r.csv" in err and len(err) < 500


def test_a_name_with_a_newline_puts_no_code_into_generated_files(run, tmp_path):
    design = tmp_path / "x\nint evil(void) { return 1; }\n\\.yaml"
    design.write_text(PAPER.read_text())
    code, _, err = run("synthesize", design, "--out", tmp_path / "out", "--no-plots")
    assert code == 0, err
    for name in ("paper_controller.h", "paper_controller.c", "paper_scenario.yaml", "report.md"):
        lines = (tmp_path / "out" / name).read_text().splitlines()
        assert not any(line.lstrip().startswith(("int evil", "\\")) for line in lines), name
    assert run("check", tmp_path / "out")[0] == 0
