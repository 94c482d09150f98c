"""Controllers made elsewhere, in every form: the same loop as the original's."""

import json
import os
import subprocess

import control as ct
import numpy as np
import pytest
import scipy.io
import scipy.signal
from conftest import PAPER
from tribo_design import importer
from tribo_design.errors import InputError
from tribo_design.zpk import Zpk

H = 1e-3
ZEROS, POLES, GAIN = [-55, -200, -139 + 203j, -139 - 203j], [-0.002, -340.23, -167.14 + 293.43j, -167.14 - 293.43j], 1.48032448
POLES_FAST = [-0.5, *POLES[1:]]  # where a form through polynomials has to keep the slow pole


def ss_of(poles=POLES):
    a, b, c, d = scipy.signal.zpk2ss(np.array(ZEROS) / 100, np.array(poles) / 100, GAIN)
    return a * 100, b * 100, c, d


def text(root):
    return str(complex(root)).strip("()")


def sos_of(poles=POLES):
    z, p, k = scipy.signal.bilinear_zpk(ZEROS, poles, GAIN, 1 / H)
    return scipy.signal.zpk2sos(z, p, k)


def files(tmp_path):
    a, b, c, d = ss_of()
    z, p, k = scipy.signal.bilinear_zpk(ZEROS, POLES, GAIN, 1 / H)
    num, den = scipy.signal.zpk2tf(ZEROS, POLES, GAIN)
    made = {
        "zpk.json": {"zeros": [text(r) for r in ZEROS], "poles": [[complex(r).real, complex(r).imag] for r in POLES], "k": GAIN},
        "tf.json": {"num": num.tolist(), "den": den.tolist()},
        "ss.json": {"a": a.tolist(), "b": b.ravel().tolist(), "c": c.tolist(), "d": float(d[0, 0])},
        "zpk_discrete.json": {"zeros": [text(r) for r in z], "poles": [text(r) for r in p], "k": float(k), "sample_time_s": H},
        "sos.json": {"sos": sos_of().tolist(), "sample_time_s": H},
    }
    paths = []
    for name, data in made.items():
        (tmp_path / name).write_text(json.dumps(data))
        paths.append(tmp_path / name)
    rows = [f"zero,{complex(r).real!r},{complex(r).imag!r}" for r in ZEROS] + [f"pole,{complex(r).real!r},{complex(r).imag!r}" for r in POLES] + [f"gain,{GAIN!r},0"]
    (tmp_path / "zpk.csv").write_text("# from elsewhere\nkind,re,im\n" + "\n".join(rows) + "\n")
    (tmp_path / "sos.csv").write_text("b0,b1,b2,a0,a1,a2\n" + "\n".join(",".join(repr(float(x)) for x in row) for row in sos_of()) + "\n")
    scipy.io.savemat(tmp_path / "ss.mat", {"A": a, "B": b, "C": c, "D": d})
    scipy.io.savemat(tmp_path / "zpk.mat", {"z": np.array(ZEROS)[:, None], "p": np.array(POLES)[:, None], "k": GAIN})
    scipy.io.savemat(tmp_path / "sos.mat", {"sos": sos_of(), "Ts": H})
    scipy.io.savemat(tmp_path / "tf.mat", {"num": num, "den": den})
    return paths + [tmp_path / n for n in ("zpk.csv", "sos.csv", "ss.mat", "zpk.mat", "sos.mat", "tf.mat")]


def test_every_form_gives_the_papers_loop(run, tmp_path, paper_result):
    wanted = paper_result.stage("q31").metrics
    for path in files(tmp_path):
        out = tmp_path / f"out_{path.name}"
        code, text, err = run("import", path, "--design", PAPER, "--out", out, "--no-plots")
        assert code == 0, (path.name, err)
        data = json.loads((out / "paper_design.json").read_text())
        m = data["metrics"]["q31"]
        assert m["gamma"] == pytest.approx(wanted.gamma, rel=1e-3), path.name
        assert m["phase_margin_deg"] == pytest.approx(wanted.phase_margin_deg, abs=0.02), path.name
        assert m["slowest_pole_rad_s"] == pytest.approx(0.002, rel=1e-4), path.name
        discrete = "sos" in path.name or "discrete" in path.name
        assert ("full" in data["metrics"]) == (not discrete)
        assert path.name in (out / "paper_controller.h").read_text()
        assert run("check", out)[0] == 0, path.name


def test_a_design_without_weights_will_do_for_import(run, tmp_path):
    design = tmp_path / "plant.yaml"
    design.write_text("name: mine\nsample_time_s: 0.001\nplant: {gain: 0.86, poles: [-55, -200, -139+203j, -139-203j]}\n")
    (tmp_path / "k.json").write_text(json.dumps({"zeros": [-30], "poles": [0], "k": 0.7}))
    code, out, err = run("import", tmp_path / "k.json", "--design", design, "--out", tmp_path / "out", "--no-plots")
    assert code == 0, err
    assert run("check", tmp_path / "out")[0] == 0
    data = json.loads((tmp_path / "out" / "mine_design.json").read_text())
    assert data["metrics"]["q31"]["gamma"] is None
    # PI with integral gain 21/s: the ramp error is rate/(21 0.86), rate 1 N/s
    assert data["metrics"]["q31"]["ramp_error_n"] == pytest.approx(1 / (21 * 0.86), rel=1e-4)
    assert "weights: is missing" in run("synthesize", design, "--out", tmp_path / "out2")[2]


def test_a_field_given_twice_is_refused(run, tmp_path):
    (tmp_path / "k.json").write_text('{"zeros": [-30], "poles": [0], "k": 1, "k": 0.7}')
    code, _, err = run("import", tmp_path / "k.json", "--design", PAPER, "--out", tmp_path / "out")
    assert code != 0 and "k: is given twice" in err


def test_a_controller_that_does_not_stabilise_is_refused(run, tmp_path):
    (tmp_path / "k.json").write_text(json.dumps({"zeros": [-5], "poles": [-0.1], "k": 500}))
    code, out, err = run("import", tmp_path / "k.json", "--design", PAPER, "--out", tmp_path / "out")
    assert code == 4 and "not stable" in err
    (tmp_path / "k.json").write_text(json.dumps({"sos": [[-1.0, 0.5, 0, 1, -0.999, 0]], "sample_time_s": H}))
    code, out, err = run("import", tmp_path / "k.json", "--design", PAPER, "--out", tmp_path / "out")
    assert code == 4 and "not stable" in err
    assert not (tmp_path / "out").exists()


def test_a_mains_notch_is_imported(run, tmp_path):
    """50 Hz, Q = 30 at 5 kHz: zeros on the unit circle."""
    (tmp_path / "k.json").write_text(json.dumps({"sample_time_s": 0.0002, "sos": [[
        0.9989538975423421, -1.9939653804297088, 0.9989538975423421, 1.0, -1.9939653804297088, 0.9979077950846842]]}))
    (tmp_path / "n5k.yaml").write_text("name: n5k\nsample_time_s: 0.0002\nplant: {gain: 1.0, zeros: [], poles: [-50, -200]}\n")
    code, _, err = run("import", tmp_path / "k.json", "--design", tmp_path / "n5k.yaml", "--out", tmp_path / "out", "--no-plots")
    assert code == 0, err


@pytest.mark.parametrize("low_hz, high_hz, rate_hz", [(0.1, 0.11, 4e4), (0.01, 0.02, 4e4), (5.0, 5.01, 4e4)])
def test_a_slow_band_pass_is_what_its_sections_say(low_hz, high_hz, rate_hz):
    """Polynomials in double at z near 1 are off by 1e-6 here: they refused it."""
    rows = scipy.signal.butter(1, [low_hz, high_hz], "bandpass", fs=rate_hz, output="sos")
    system, given = importer._sections("k.json", {"sos": rows.tolist()}, True)
    importer._check_response("k.json", system, given, 1 / rate_hz)


def test_poles_on_the_unit_circle_are_refused_whatever_their_last_bit():
    for hertz in np.linspace(1, 200, 60):
        pole = np.exp(2j * np.pi * hertz * 1e-3)
        with pytest.raises(InputError, match="stability boundary"):
            importer._check("k.json", Zpk([], [pole - 1, np.conj(pole) - 1], 1.0), 1e-3)


def test_sections_of_first_order_and_of_both(run, tmp_path):
    from tribo_design.config import load_design
    from tribo_design.importer import load_controller

    sos = [[0.7, -0.65, 0, 1, -0.99, 0], [1.0, -0.5, 0.1, 1, -0.3, 0.2]]
    doubled = [sos[0], [2 * c for c in sos[1][:3]] + [2 * c for c in sos[1][3:]]]  # a0 = 2
    (tmp_path / "k.json").write_text(json.dumps({"sos": doubled, "sample_time_s": H}))
    imported, _ = load_controller(tmp_path / "k.json", load_design(PAPER)[0])
    assert imported.zpk.order == 3
    w, wanted = scipy.signal.sosfreqz(sos, np.array([0.01, 0.3, 2.0]))
    assert np.allclose(imported.zpk(np.expm1(1j * w)), wanted, rtol=1e-9)


def test_state_space_with_a_hidden_mode_keeps_it_until_the_reduction(tmp_path):
    from tribo_design import reduction
    from tribo_design.config import Reduction, load_design
    from tribo_design.importer import load_controller
    from tribo_design.loop import Continuous

    (tmp_path / "k.json").write_text(json.dumps({"a": [[-2, 0], [0, -7]], "b": [1, 0], "c": [3, 5], "d": 1}))
    imported, _ = load_controller(tmp_path / "k.json", load_design(PAPER)[0])
    assert imported.zpk.order == 2
    k = ct.ss([[-2]], [[1]], [[3]], [[1]])
    assert np.allclose(imported.zpk([1j, 10j]), k(np.array([1j, 10j])))
    found = reduction.candidates(Continuous(imported.zpk), Reduction(), H)
    assert found[0].zpk.order == 1 and np.allclose(found[0].zpk.poles, [-2])


LAB = """name: lab
sample_time_s: 0.001
computation_delay_s: 5.0e-4
plant: {gain: GAIN, poles: [-30, -200]}
fixed_point: {full_scale_n: 40, u_max_n: 30}
"""


@pytest.fixture
def lab(run, tmp_path):
    """Imports a file of these fields; its exit code, what it said, and the folder."""
    def import_of(name, gain=1.0, **fields):
        design, path = tmp_path / "lab.yaml", tmp_path / name
        design.write_text(LAB.replace("GAIN", str(gain)))
        path.write_text(json.dumps(fields)) if name.endswith("json") else scipy.io.savemat(path, fields)
        code, out, err = run("import", path, "--design", design, "--out", tmp_path / "out", "--no-plots")
        return code, out + err, tmp_path / "out"
    return import_of


# PI with a lead and a roll-off, as K(z) at 1 kHz.
NUM_Z, DEN_Z = scipy.signal.zpk2tf(*scipy.signal.bilinear_zpk([-25.0, -150.0], [0.0, -700.0], 12.0, 1 / H))


def test_a_discrete_controller_without_sample_time_is_refused_with_that_reason(lab):
    code, said, _ = lab("k.mat", num=NUM_Z, den=DEN_Z)
    assert code == 2 and "a discrete K needs its sample time as well, sample_time_s (in MATLAB: Ts = K.Ts" in said
    assert lab("k.mat", num=NUM_Z, den=DEN_Z, Ts=H)[0] == 0  # the advice, followed
    code, said, _ = lab("u.json", zeros=[], poles=[2.0], k=1.0)
    assert code == 2 and "right half plane" in said and "sample time" not in said


@pytest.mark.parametrize("ticks", [1, 3])
@pytest.mark.parametrize("form", ["num", "zeros"])
def test_a_strictly_proper_controller_in_z_gets_a_remedy(lab, ticks, form):
    zeros, poles, gain = scipy.signal.tf2zpk(NUM_Z, DEN_Z)
    late = {"num": {"num": [0.0] * ticks + NUM_Z.tolist(), "den": DEN_Z.tolist() + [0.0] * ticks},
            "zeros": {"zeros": zeros.real.tolist(), "poles": poles.real.tolist() + [0.0] * ticks, "k": gain}}[form]
    code, said, out = lab("k.json", sample_time_s=H, **late)
    assert code == 2 and f"{ticks} more pole" in said and f"tf('z', Ts){'^3' if ticks == 3 else ''}" in said and f"{ticks * H:g} s for as much" in said and not out.exists()
    early = {"num": {"num": NUM_Z.tolist() + [0.0] * ticks, "den": late["den"] if "den" in late else None},
             "zeros": {**late, "zeros": late.get("zeros", []) + [0.0] * ticks}}[form]
    assert lab("k.json", sample_time_s=H, **early)[0] == 0  # the advice, followed


def test_cells_of_tfdata_are_vectors(lab):
    cell = np.empty((1, 1), object)
    cells = {}
    for name, values in (("num", NUM_Z), ("den", DEN_Z)):
        cells[name] = cell.copy()
        cells[name][0, 0] = values
    assert lab("k.mat", Ts=H, **cells)[0] == 0


def test_what_is_removed_of_a_continuous_controller_is_said(lab):
    code, said, _ = lab("k.json", zeros=[-25.0], poles=[0.0, -100000.0, -1000000.0], k=60000000000.0)
    assert code == 0 and "note: the imported K(s) is not what runs: 2 modes beyond 1 x Nyquist removed" in said
    assert "is not what runs" not in lab("z.json", sample_time_s=H, num=NUM_Z.tolist(), den=DEN_Z.tolist())[1]


def test_what_u_is_divided_by_is_in_the_header_too(lab, tmp_path):
    code, said, out = lab("k.json", gain=-1.0, zeros=[-25.0], poles=[0.0], k=-0.6)
    assert code == 0, said
    header = tmp_path / "lab.h"
    subprocess.run([os.environ["TRIBO_SIM"], "params", out / "lab_scenario.yaml", "--arith", "q31", "--out", header], check=True)
    assert "put u / -1 out" in (out / "lab_scenario.yaml").read_text() and 'description  "a triangle with the controller lab; put u / -1 out"' in header.read_text()
