"""What runs on the host against a stand-in; for a microcontroller the sketch of SimpleFOC is compiled by test_arm.py."""

import re

import pytest

from conftest import RMS_MAX_UN, make, rms_un


@pytest.fixture(scope="module", name="simplefoc")
def _simplefoc(tmp_path_factory):
    """Its folder, with one library for both sketches."""
    return tmp_path_factory.mktemp("simplefoc")


def test_simplefocs_sketch_follows_against_friction_until_a_tick_is_missed_or_the_sensor_fails(simplefoc):
    out = make("simplefoc", simplefoc, "run")
    assert rms_un(out) < RMS_MAX_UN
    assert "enabled 1" in out
    assert "enabled 1" in make("simplefoc", simplefoc, "run", "WITH=glitch")
    for word, after in (("stall", 1), ("blind", 19)):
        out = make("simplefoc", simplefoc, "run", f"WITH={word}")
        assert rms_un(out) > 100 * RMS_MAX_UN
        assert out.endswith(f"enabled 0, off after {after}, on for 0\n")
    assert "on for 0" in make("simplefoc", simplefoc, "run", "WITH=stubborn")


def test_simplefocs_joint_follows_against_friction_and_its_guard_takes_the_term_out(simplefoc):
    def run(word):
        out = make("simplefoc", simplefoc, "joint", f"WITH={word}")
        return dict(zip(("error", "enabled", "friction", "share", "cause", "blind", "first"), re.match(
            r"RMS error (\d+) urad, enabled (\d), friction (\d+) mA, share ([\d.]+), (\w+).*, (\d+) uA.*, first (\d+) mA", out).groups()))

    on, off, stall, exchanged, blind, hand, away = (run(word) for word in ("", "off", "stall", "reversed", "blind", "hand", "away"))
    assert int(off["error"]) > 2.5 * int(on["error"])
    assert (on["enabled"], on["share"], on["cause"]) == ("1", "1.00", "sound")
    assert 360 < int(on["friction"]) < 440  # 0.1 N m, 4 A for a newton metre
    assert stall["enabled"] == "0"
    assert (exchanged["share"], exchanged["cause"]) == ("0.00", "astray")
    assert (blind["blind"], blind["enabled"]) == ("0", "1")
    assert hand["enabled"] == "0" and 360 < int(hand["friction"]) < 440  # a hand teaches nothing
    assert int(away["first"]) <= int(on["first"]) + 50 and int(away["error"]) < 1.1 * int(on["error"])


def test_the_loop_for_moteus_in_cpp_follows_and_stops_with_a_fault(tmp_path):
    assert rms_un(make("moteus", tmp_path, "run")) < RMS_MAX_UN
    make("moteus", tmp_path, "force")
    assert (tmp_path / "force").exists()
