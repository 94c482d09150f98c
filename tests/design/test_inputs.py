"""Broken design files, controllers and records: one clear error that names file, line, field, value and range; nothing written."""

import json

import numpy as np
import pytest
import scipy.io
from conftest import PAPER

PLANT = "  gain: 0.86\n  zeros: []\n  poles: [-55, -200, -139+203j, -139-203j, -56778]\n"

# (what to replace, with what, what the error must say)
DESIGNS = [
    ("sample_time_s: 1.0e-3", "sample_time_s: -1", ["sample_time_s", "-1", "at least 1e-06", ":7"]),
    ("sample_time_s: 1.0e-3", "sample_time_s: .nan", ["sample_time_s", "finite"]),
    ("sample_time_s: 1.0e-3", "sample_time_s: fast", ["sample_time_s", "'fast'", "must be a number"]),
    ("sample_time_s: 1.0e-3", "sample_time_s: [1]", ["sample_time_s", "must be a number"]),
    ("sample_time_s: 1.0e-3", "sample_time_s: true", ["sample_time_s", "must be a number"]),
    ("sample_time_s: 1.0e-3\n", "", ["sample_time_s: is missing"]),
    ("sample_time_s: 1.0e-3", "sample_time_s: 1.0e-3\nsample_time_s: 2.0e-3", ["sample_time_s: is given twice", ":8"]),
    ("computation_delay_s: 1.0e-4", "computation_delay_s: 1", ["computation_delay_s", "two sample times"]),
    ("name: paper", "name: Paper Case", ["name", "lower-case"]),
    ("name: paper", "name: ../../etc", ["name", "lower-case"]),
    ("name: paper", "nam: paper", ["nam: there is no such field", "name: is missing"]),
    ("-139+203j, -139-203j", "-139+203j", ["plant", "-139+203j", "no complex conjugate"]),
    ("-139+203j, -139-203j", "-139+203j, -139-204j", ["plant", "no complex conjugate"]),
    ("-55, -200", "-55, .inf", ["plant.poles[1]", "finite"]),
    ("-55, -200", "-55, two", ["plant.poles[1]", "'two'", "complex number like"]),
    ("-55, -200", "-55, -1e15", ["plant.poles[1]", "1e+12"]),
    ("gain: 0.86", "gain: .nan", ["plant.gain", "finite"]),
    ("gain: 0.86", "gain: 1e-300", ["plant.gain", "size within 1e-60 and 1e+60"]),
    ("gain: 0.86", f"gain: {'1' * 400}", ["plant.gain", "finite"]),
    ("num: [0.9090909090909091, 20]", "num: [1e300, 20]", ["weights.wp.num[0]", "size within 1e-60 and 1e+60"]),
    ("wu: 1", "wu: {a: [[-1e80]], b: [1], c: [1]}", ["weights.wu.a[0][0]", "size within 1e-60 and 1e+60"]),
    ("gain: 0.86", "gain: 0", ["plant", "gain is 0"]),
    ("gain: 0.86", "gain: 1\n  k: 2", ["plant", "either gain"]),
    ("gain: 0.86", "num: [1]", ["plant", "exactly one of the forms", "zpk and tf"]),
    (PLANT, "  num: [1, 2, 3]\n  den: []\n", ["plant.den", "at least 1"]),
    (PLANT, "  num: [1, 2, 3]\n  den: [0, 0]\n", ["plant", "den must not be all 0"]),
    (PLANT, "  num: [1, 2, 3]\n  den: [1, 2]\n", ["plant: improper (2 zeros, 1 poles)"]),
    (PLANT, "  a: [[1, 2]]\n  b: [1]\n  c: [1]\n", ["plant", "a: must be 1 x 1", "found 1 x 2"]),
    (PLANT, "  a: [[-1, 0], [0, -2]]\n  b: [[1, 2], [3, 4]]\n  c: [1, 1]\n", ["plant", "b: must be 2 x 1"]),
    (PLANT, "  a: [[-1, 0], [0, -2]]\n  b: [1, 1, 1]\n  c: [1, 1]\n", ["plant", "b: must be 2 x 1", "found 3 x 1"]),
    (PLANT, "  a: [[-1, .nan], [0, -2]]\n  b: [1, 1]\n  c: [1, 1]\n", ["plant.a[0][1]", "finite"]),
    (PLANT, "  - 1\n", ["plant", "one of the forms"]),
    ("wu: 1", "wu: hello", ["weights.wu.k", "'hello'", "must be a number"]),
    ("wu: 1", "wU: 1", ["weights.wU: there is no such field", "weights.wu: is missing"]),
    ("den: [1, 20.0e-4]", "den: [1, 20.0e-4, 0x]", ["weights.wp.den[2]", "'0x'"]),
    ("method: modal", "method: magic", ["reduction.method", "'magic'", "'modal', 'balanced' or 'auto'"]),
    ("order_max: 8", "order_max: 9", ["reduction.order_max", "9", "at most 8"]),
    ("digits: 5", "digits: 5.5", ["reduction.digits", "5.5", "integer"]),
    ("method: tustin", "method: tustin-prewarped", ["prewarp_rad_s"]),
    ("method: tustin", "method: tustin-prewarped, prewarp_rad_s: 4000", ["prewarp_rad_s", "3141.59"]),
    ("time_limit_s: 60", "time_limit_s: 0", ["synthesis.time_limit_s", "at least 1"]),
    ("full_scale_n: 2,", "full_scale_n: 0,", ["fixed_point.full_scale_n", "at least 0.001"]),
    ("u_max_n: 2", "u_max_n: 3", ["fixed_point", "u_max_n", "at most full_scale_n, 2"]),
    ("  floor: {gain_margin_min: 8", "  floor: {gain_margin_min: 0.5", ["limits.floor.gain_margin_min", "at least 1"]),
    ("  reduced: {gamma_percent: 0.5", "  reduced: {gamma_percent: -1", ["limits.reduced.gamma_percent", "at least 0"]),
    ("synthesis: {domain: continuous, time_limit_s: 60, gamma_max: 5}", "synthesis: &s {time_limit_s: 60, gamma_max: 5}\nramp2: *s", ["not supported"]),
    ("name: paper", "name: {", ["not YAML"]),
    ("name: paper", "name: \x00", ["not YAML"]),
    ("weights:\n", "weights:\n\t- x\n", ["not YAML"]),
]


@pytest.mark.parametrize("old, new, said", DESIGNS)
def test_a_broken_design_is_refused_by_field(run, tmp_path, old, new, said):
    text = PAPER.read_text()
    assert old in text
    design = tmp_path / "broken.yaml"
    design.write_text(text.replace(old, new, 1))
    code, _, err = run("synthesize", design, "--out", tmp_path / "out", "--no-plots")
    assert code in (2, 3), err
    for words in said:
        assert words in err, err
    if code == 2:
        assert "broken.yaml:" in err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["broken.yaml"]


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"- 1\n- 2\n", b"just words", b"[" * 5000, b"a: " * 3000, b"!!python/object:os.system x", b"1: 2", b"? [a]\n: b\n"])
def test_a_file_that_is_not_a_design_is_refused(run, tmp_path, content):
    design = tmp_path / "x.yaml"
    design.write_bytes(content)
    code, _, err = run("synthesize", design, "--out", tmp_path / "out")
    assert code == 2 and "x.yaml" in err


def test_a_missing_design_and_a_bad_out(run, tmp_path):
    assert "cannot be read" in run("synthesize", tmp_path / "none.yaml", "--out", tmp_path / "out")[2]
    assert "not a directory" in run("synthesize", PAPER, "--out", PAPER)[2]
    assert "written to" in run("synthesize", PAPER, "--out", PAPER / "b" / "c")[2]
    assert run("synthesize", PAPER, "--out", tmp_path / "a" / "b" / "c", "--no-plots")[0] == 0 and (tmp_path / "a" / "b" / "c" / "report.md").is_file()
    assert run("synthesize")[0] == 2
    assert run("check", tmp_path / "none")[0] == 2
    assert "time-limit" in run("synthesize", PAPER, "--out", tmp_path / "o", "--time-limit", "nan")[2]


def test_bytes_turned_at_random_never_give_a_traceback(run, tmp_path):
    """Seeded damage to the paper's design: whatever happens, it is said in one of the tool's own ways."""
    text = PAPER.read_text()[:900].encode()
    rng = np.random.default_rng(11)
    for i in range(30):
        data = bytearray(text)
        for _ in range(int(rng.integers(1, 4))):
            data[rng.integers(len(data))] = rng.choice(list(b"0123456789.-+ej[]{}:,#\n \t'\"&*abc"))
        design = tmp_path / "x.yaml"
        design.write_bytes(bytes(data))
        code, _, err = run("synthesize", design, "--out", tmp_path / "out", "--no-plots")
        assert code in (0, 1, 2, 3, 4), (i, err)
        assert code == 0 or err.startswith("tribo-design: "), (i, err)


# Controllers.

CONTROLLERS = [
    ({"zeros": [-5], "poles": ["-10+3j"], "k": 1}, ["poles", "-10+3j", "no complex conjugate"]),
    ({"zeros": [-5], "poles": [[-10, 3], [-10, -4]], "k": 1}, ["poles", "no complex conjugate"]),
    ({"zeros": [-5, -6], "poles": [-10], "k": 1}, ["zeros", "not proper"]),
    ({"zeros": [-5], "poles": [10], "k": 1}, ["poles", "10 rad/s", "unstable"]),
    ({"zeros": [-5, -6], "poles": [0, 0], "k": 1}, ["poles", "one integrator"]),
    ({"zeros": [-5, -6], "poles": ["3j", "-3j"], "k": 1}, ["poles", "boundary"]),
    ({"zeros": [-5], "poles": [float("nan")], "k": 1}, ["poles[0]", "finite"]),
    ({"zeros": [-5], "poles": [None], "k": 1}, ["poles[0]", "real number"]),
    ({"zeros": [-5], "poles": ["ten"], "k": 1}, ["poles[0]", "'ten'"]),
    ({"zeros": [-5], "poles": [-10]}, ["k: is missing"]),
    ({"zeros": [-5], "poles": [-10], "k": float("inf")}, ["k", "finite"]),
    ({"zeros": [-5], "poles": [-10], "k": 0}, ["K is 0"]),
    ({"zeros": [-5], "poles": [-10], "k": "1+2j"}, ["k", "real number"]),
    ({"num": [1, 2, 3], "den": [1, 2]}, ["num", "not proper"]),
    ({"num": [1], "den": [0, 0]}, ["den", "all 0"]),
    ({"num": [1], "den": []}, ["den", "empty"]),
    ({"num": [[1, 2], [3, 4]], "den": [1, 2]}, ["num", "vector"]),
    ({"num": [1, 1], "den": [1, float("nan")]}, ["den[1]", "finite"]),
    ({"num": [1, 1], "den": [1, -2]}, ["poles", "2 rad/s", "unstable"]),
    ({"num": [1, 1]}, ["den: is missing"]),
    ({"a": [[-1, 0]], "b": [1], "c": [1]}, ["a", "1 x 1", "1 x 2"]),
    ({"a": [[-1, 0], [0]], "b": [1, 1], "c": [1, 1]}, ["a", "same length"]),
    ({"a": [[-1]], "b": [[1, 2]], "c": [1]}, ["b", "1 x 1", "1 x 2"]),
    ({"a": [[-1]], "b": [1], "c": [[1], [2]]}, ["c", "1 x 1", "2 x 1"]),
    ({"a": [["x"]], "b": [1], "c": [1]}, ["a[0][0]", "'x'"]),
    ({"a": [[1]], "b": [1], "c": [1], "d": 1}, ["poles", "unstable"]),
    ({"sos": [[1, 0, 0, 1, 0]], "sample_time_s": 0.001}, ["sos[0]", "6 entries"]),
    ({"sos": [[1, 0, 0, 0, 0, 0]], "sample_time_s": 0.001}, ["sos[0][3]", "a0"]),
    ({"sos": [[0, 1, 0, 1, 0, 0]], "sample_time_s": 0.001}, ["sos[0][0]", "feedthrough"]),
    ({"sos": [[1, 0, 0, 1, 0, 1.1]], "sample_time_s": 0.001}, ["poles", "unit circle", "unstable"]),
    ({"sos": [[1, 0, 0, 1, 0, 0]]}, ["sample_time_s", "missing"]),
    ({"sos": "x", "sample_time_s": 0.001}, ["sos", "rows of"]),
    ({"zeros": [0.5], "poles": [0.9], "k": 1, "sample_time_s": 0.002}, ["sample_time_s", "0.002", "design's, 0.001"]),
    ({"zeros": [0.5], "poles": [0.9], "k": 1, "Ts": -1}, ["sample_time_s", "more than 0"]),
    ({"zeros": [-5], "poles": [-10], "k": 1, "num": [1], "den": [1]}, ["exactly one form"]),
    ({"zeroes": [-5]}, ["zeroes", "no such field"]),
    ({}, ["exactly one form", "none"]),
    ([1, 2], ["must be an object"]),
]


@pytest.mark.parametrize("content, said", CONTROLLERS)
def test_a_broken_controller_is_refused_by_field(run, tmp_path, content, said):
    path = tmp_path / "k.json"
    path.write_text(json.dumps(content))
    code, _, err = run("import", path, "--design", PAPER, "--out", tmp_path / "out")
    assert code == 2, err
    assert "k.json" in err
    for words in said:
        assert words in err, err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["k.json"]


@pytest.mark.parametrize("text, said", [
    ("", ["is empty"]), ("a,b\n1,2\n", ["first row"]), ("kind,re,im\npole,x,0\n", [":2", "re", "'x'"]), ("kind,re,im\nqole,1,0\n", [":2", "kind", "'qole'"]),
    ("kind,re,im\npole,-1,0\n", ["k: is missing"]), ("kind,re,im\ngain,1,0\ngain,2,0\n", [":3", "given twice"]), ("kind,re,im\ngain,1,1\npole,-1,0\n", ["gain", "real"]),
    ("kind,re,im\npole,-1,2\ngain,1,0\n", ["no complex conjugate"]), ("kind,re,im\npole,nan,0\ngain,1,0\n", ["poles[0]", "finite"]),
    ("b0,b1,b2,a0,a1,a2\n1,2,3\n", [":2", "6 columns"]), ("b0,b1,b2,a0,a1,a2\n", ["sos"]), ("kind,re,im\n1\n", [":2", "3 columns"])])
def test_a_broken_csv_controller(run, tmp_path, text, said):
    path = tmp_path / "k.csv"
    path.write_text(text)
    code, _, err = run("import", path, "--design", PAPER, "--out", tmp_path / "out")
    assert code == 2, err
    for words in ["k.csv", *said]:
        assert words in err, err


def test_broken_mat_files(run, tmp_path):
    path = tmp_path / "k.mat"
    for content, said in [(b"", "not a MATLAB file"), (b"MATLAB 5.0 MAT-file" + b"x" * 200, "not a MATLAB file")]:
        path.write_bytes(content)
        assert said in run("import", path, "--design", PAPER, "--out", tmp_path / "out")[2]
    for content, said in [({"z": np.ones((2, 2)), "p": [1], "k": 1}, "z: must be a vector"), ({"z": [-1], "p": [-2], "k": [1, 2]}, "k: must be one number"),
                          ({"K": {"a": 1}}, "K: must be numbers"), ({"A": np.eye(2), "B": np.ones((2, 1)), "C": np.ones((1, 3)), "D": 0}, "c: must be 1 x 2"), ({"x": 1}, "no such field")]:
        scipy.io.savemat(path, content)
        code, _, err = run("import", path, "--design", PAPER, "--out", tmp_path / "out")
        assert code == 2 and said in err, err


def test_other_suffixes_and_missing_files(run, tmp_path):
    (tmp_path / "k.txt").write_text("x")
    assert "must be one of .json, .csv, .mat" in run("import", tmp_path / "k.txt", "--design", PAPER, "--out", tmp_path / "out")[2]
    assert "cannot be read" in run("import", tmp_path / "none.json", "--design", PAPER, "--out", tmp_path / "out")[2]


# Step responses.

def record(rows, head="t_s,u_n,y_n"):
    return head + "\n" + "\n".join(",".join(str(c) for c in row) for row in rows) + "\n"


GOOD = [(i * 0.001, 0.2, 0.17 * (1 - np.exp(-0.05 * i))) for i in range(200)]


@pytest.mark.parametrize("text, said", [
    ("", ["is empty"]), (record(GOOD, "x,u_n,y_n"), [":1:1: no column is named t_s", "there are x, u_n, y_n"]), (record(GOOD, "t_s,u_n,q"), ["no column is named y_n", "--column"]),
    (record(GOOD[:5]), ["5 samples", "20"]), (record([*GOOD[:50], (0.049, 0.2, 0.1), *GOOD[51:]]), [":52:1: t_s: 0.049 does not come after 0.049"]),
    (record([*GOOD[:50], *GOOD[60:]]), [":52:1: t_s: 0.011 s after the row before", "--resample"]), (record([(t, 0, y) for t, _, y in GOOD]), ["u", "no step"]),
    (record([(t, u, 1.0) for t, u, _ in GOOD]), ["F does not move"]), (record([(t, u, "x") for t, u, _ in GOOD]), ["y_n", "'x' is not a number"])])
def test_a_broken_record_is_refused_with_the_words_of_the_reader_of_logs(run, tmp_path, text, said):
    path = tmp_path / "step.csv"
    path.write_text(text)
    code, _, err = run("identify-plant", path, "--out", tmp_path / "out")
    assert code == 2, err
    for words in ["step.csv", *said]:
        assert words in err, err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["step.csv"]


@pytest.mark.parametrize("row, said", [((0.05, 0.2, "x"), ":52:10: y_n: 'x' is not a number"), ((0.05, 0.2, "nan"), ":52:10: y_n: 'nan' is not a finite number"), ((0.05, 0.2), ":52:6: 2 fields, the header has 3"),
                                       ((0.05, 0.2, "1e300"), ":52:10: y_n: '1e300' is outside -1e+30 to 1e+30"), ((0.05, 0.2, 0.05, 7), ":52:")])
def test_a_broken_row_of_a_record_is_bridged_and_named(run, tmp_path, row, said):
    path = tmp_path / "step.csv"
    path.write_text(record([*GOOD[:50], row, *GOOD[51:]]))
    code, out, err = run("identify-plant", path, "--no-friction", "--order", "1")
    assert code == 0, err
    assert "note  " in out and "1 of 200 rows are broken, left out and bridged" in out and said in out


@pytest.mark.parametrize("text, options", [
    ("sep=;\nt_s;u_n;y_n\n" + "\n".join(f"{t};{u};{y}" for t, u, y in GOOD).replace(".", ","), ()),
    ("rig 7\nby hand\n\ntime,cmd,load\ns,N,N\n" + "\n".join(f"{t},{u},{y}" for t, u, y in GOOD) + "\n# end\n", ("--column", "t=time", "--column", "u=cmd", "--column", "F=load")),
    (record([(1000 * t, u, y) for t, u, y in GOOD], "t_s,u_N,F_N"), ("--unit", "t=ms"))])
def test_a_record_is_read_as_loggers_write_it(run, tmp_path, text, options):
    (tmp_path / "plain.csv").write_text(record(GOOD))
    (tmp_path / "step.csv").write_text(text)
    plain, other = (run("identify-plant", tmp_path / name, "--no-friction", "--order", "1", *more) for name, more in (("plain.csv", ()), ("step.csv", options)))
    assert plain[0] == other[0] == 0, other[2]
    assert other[1].splitlines()[:4] == plain[1].splitlines()[:4]


def test_step_size_and_order_are_checked(run, tmp_path):
    path = tmp_path / "step.csv"
    path.write_text(record([(t, y) for t, _, y in GOOD], "t_s,y_n"))
    assert "--step-size" in run("identify-plant", path)[2]
    assert "--step-size" in run("identify-plant", path, "--step-size", "0")[2]
    assert "--order" in run("identify-plant", path, "--step-size", "0.2", "--order", "9")[2]


def test_extreme_coefficients_never_give_an_internal_error(run, tmp_path):
    """1e300 in a weight once ended in one."""
    for old, new in (("num: [0.9090909090909091, 20]", "num: [1e60, 20]"), ("gain: 0.86", "gain: 1e60"), ("gain: 0.86", "gain: 1e-60"), ("wu: 1", "wu: 1e60")):
        (tmp_path / "d.yaml").write_text(PAPER.read_text().replace(old, new).replace("time_limit_s: 60", "time_limit_s: 2"))
        code, _, err = run("synthesize", tmp_path / "d.yaml", "--out", tmp_path / "out")
        assert code in (3, 4) and err, (new, code, err)
