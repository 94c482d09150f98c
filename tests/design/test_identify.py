"""Plants found in step responses that python-control makes here."""

import json

import control as ct
import numpy as np
import pytest
import ruamel.yaml

POLES = np.array([-55, -200, -139 + 203j, -139 - 203j])


def write(path, poles, gain, noise, seed=0, count=400, dt=1e-3, step=0.2, offset=0.1, start=0, extra=None):
    plant = ct.ss(ct.zpk([], poles, gain * np.prod(-np.asarray(poles)).real))
    time = np.arange(count) * dt
    u = np.where(np.arange(count) >= start, step, 0.0)
    y = ct.forced_response(plant, time, u).outputs if start else step * ct.step_response(plant, time).outputs
    if start:  # hold, not interpolation
        y = np.r_[np.zeros(start), step * ct.step_response(plant, time).outputs][:count]
    y = y + offset + np.random.default_rng(seed).normal(0, noise, count)
    if extra is not None:
        y = y + extra(time)
    path.write_text("t_s,u_n,y_n\n" + "\n".join(f"{t!r},{a!r},{b!r}" for t, a, b in zip(time.tolist(), u.tolist(), y.tolist())) + "\n")
    return path


def identified(run, path, *options):
    code, out, err = run("identify-plant", path, *options, "--out", path.parent / "found")
    assert code == 0, err
    return json.loads((path.parent / "found" / "identification.json").read_text()), out


def poles_of(found):
    return np.array([complex(p["re"], p["im"]) for p in found["poles"]])


def test_the_papers_slow_poles_without_noise(run, tmp_path):
    found, _ = identified(run, write(tmp_path / "step.csv", POLES, 0.86, 0.0))
    assert found["order"] == 4
    assert found["gain"] == pytest.approx(0.86, rel=1e-5)
    assert np.allclose(np.sort_complex(poles_of(found)), np.sort_complex(POLES), rtol=1e-3)
    assert found["fit_percent_where_it_moves"] > 99.99


def test_a_step_in_the_middle_of_the_record(run, tmp_path):
    found, _ = identified(run, write(tmp_path / "step.csv", [-40.0], 1.5, 1e-5, start=60))
    assert found["order"] == 1 and found["gain"] == pytest.approx(1.5, rel=1e-3)
    assert poles_of(found)[0] == pytest.approx(-40, rel=2e-3)


def test_a_long_record_keeps_the_time_of_its_step(run, tmp_path):
    """Of 39,990 samples the fit looks at every tenth; the step is not at one of those."""
    found, _ = identified(run, write(tmp_path / "step.csv", [-20.0, -300.0], 2.0, 1e-4, count=39_990, dt=1e-4, start=3001), "--order", "2")
    assert found["gain"] == pytest.approx(2.0, rel=1e-3)
    assert np.allclose(np.sort(poles_of(found).real), [-300, -20], rtol=2e-2)


def test_an_input_that_always_moves(run, tmp_path):
    time, u = np.arange(6000) * 1e-3, np.repeat(np.r_[0.0, np.random.default_rng(1).normal(0, 1, 599)], 10)
    y = ct.forced_response(ct.sample_system(ct.ss(ct.zpk([], [-30.0], 30 * 0.7)), 1e-3, "zoh"), time, u).outputs
    (tmp_path / "step.csv").write_text("t_s,u_n,y_n\n" + "\n".join(f"{t!r},{a!r},{b!r}" for t, a, b in zip(time.tolist(), u.tolist(), y.tolist())) + "\n")
    found, _ = identified(run, tmp_path / "step.csv", "--order", "1")
    assert found["gain"] == pytest.approx(0.7, rel=1e-4) and poles_of(found)[0] == pytest.approx(-30, rel=1e-3)


def test_a_folder_with_the_record_in_it_is_not_replaced(run, tmp_path):
    record = write(tmp_path / "step.csv", [-40.0], 1.5, 1e-5)
    identified(run, record)
    moved = record.rename(tmp_path / "found" / "step.csv")
    code, _, err = run("identify-plant", moved, "--out", tmp_path / "found")
    assert code != 0 and "has other files in it (step.csv)" in err
    assert moved.is_file()


def test_a_byte_order_mark_is_no_name(run, tmp_path):
    record = write(tmp_path / "step.csv", [-40.0], 1.5, 1e-5)
    record.write_bytes(b"\xef\xbb\xbf" + record.read_bytes())
    assert identified(run, record)[0]["gain"] == pytest.approx(1.5, rel=1e-3)


def test_confidence_intervals_hold_what_they_promise(run, tmp_path):
    """95 % intervals over 20 seeds: the truth is in most of them, and they are not padded."""
    inside_gain = inside_pole = 0
    widths, errors = [], []
    for seed in range(20):
        found, _ = identified(run, write(tmp_path / "step.csv", [-30.0, -150.0], 1.2, 2e-3, seed=seed, count=300), "--order", "2")
        inside_gain += abs(found["gain"] - 1.2) <= found["gain_half_width"]
        slow = min(found["poles"], key=lambda p: abs(p["re"]))
        inside_pole += slow["size_low"] <= 30 <= slow["size_high"]
        widths.append(found["gain_half_width"])
        errors.append(found["gain"] - 1.2)
    assert inside_gain >= 16 and inside_pole >= 16
    assert np.mean(widths) < 4 * np.std(errors)


def test_a_pole_beyond_the_sampling_is_not_claimed(run, tmp_path):
    found, out = identified(run, write(tmp_path / "step.csv", [-50.0, -56778.0], 0.9, 1e-4), "--order", "2")
    fast = max(found["poles"], key=lambda p: abs(complex(p["re"], p["im"])))
    assert not fast["identifiable"] and "NOT identifiable" in out
    assert f"# pole {fast['pole']} is NOT identifiable" in (tmp_path / "found" / "plant.yaml").read_text()


def test_what_the_model_misses_is_said(run, tmp_path):
    found, out = identified(run, write(tmp_path / "step.csv", [-50.0], 0.9, 1e-5, extra=lambda t: 0.01 * np.sin(40 * t)), "--order", "1")
    assert "the model misses something" in out
    assert found["fit_percent_where_it_moves"] < 99


def test_a_flat_tail_does_not_flatter_the_fit(run, tmp_path):
    short, _ = identified(run, write(tmp_path / "step.csv", [-50.0], 0.9, 5e-3, count=200), "--order", "1")
    long, _ = identified(run, write(tmp_path / "step.csv", [-50.0], 0.9, 5e-3, count=4000), "--order", "1")
    assert long["fit_percent_where_it_moves"] == pytest.approx(short["fit_percent_where_it_moves"], abs=3)


def test_plant_yaml_goes_into_a_design(run, tmp_path):
    from tribo_design.config import System

    identified(run, write(tmp_path / "step.csv", POLES, 0.86, 1e-5))
    data = ruamel.yaml.YAML(typ="safe").load((tmp_path / "found" / "plant.yaml").read_text())
    plant = System.model_validate(data["plant"]).zpk()
    assert plant.at_zero() == pytest.approx(0.86, rel=1e-2) and plant.order == 4
    assert (tmp_path / "found" / "fit.png").read_bytes().startswith(b"\x89PNG")
